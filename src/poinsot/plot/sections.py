"""Plots of Poincare sections: one colour for the points of each motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from poinsot.analysis.sections import Section
from poinsot.plot.labels import COLOURS, angle_unit_of, rate_unit_of
from poinsot.plot.panels import count_degrees, dress, one_panel, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["section"]

Array = NDArray[np.float64]

RADIANS = " [rad]"
RATE = " [rad / unit of time]"
NEIGHBOURS = COLOURS[:5]
MAX_INK = 3e4
"""Points of a picture at which they become single dots."""


@plot
def section(
    section: Section,
    *,
    ax: Axes | None = None,
    angle_unit: str | None = None,
    rate_unit: str | None = None,
    title: str = "",
) -> Axes:
    """Draw the points of a section, with different colours for neighbouring members.

    Parameters
    ----------
    section : Section
        Points with the labels of their axes. Coordinates in "[rad]" are angles and coordinates in "[rad/s]" (or per
        other unit of time of the system) angular velocities, both drawn in a suitable unit.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel; `axes.figure` is its figure, for `savefig`.

    Examples
    --------
    >>> found = pt.analysis.section(motion, lambda at: at.omega_body[:, :2].T, labels=("first", "second"))
    >>> pt.plot.section(found, title="Angular velocity").get_xlabel()
    'first'
    """
    axes = one_panel(ax, (7, 6), title)
    points = np.isfinite(section.x)
    (x, x_label), (y, y_label) = (
        _in_unit(values, label, section.motion.system.units, angle_unit, rate_unit)
        for values, label in zip((section.x, section.y), section.labels, strict=True)
    )
    size = float(np.clip(MAX_INK / max(int(np.count_nonzero(points)), 1), 0.1, 6.0))
    for k, colour in enumerate(NEIGHBOURS):
        mine = points.copy()
        mine[np.arange(len(mine)) % len(NEIGHBOURS) != k] = False
        axes.scatter(x[mine], y[mine], s=size, color=colour, linewidths=0, rasterized=True)
    axes.margins(0.01)
    dress(axes, x_label, y_label)
    for axis in (axes.xaxis, axes.yaxis):
        count_degrees(axis, axis.get_label_text())
    return axes


def _in_unit(
    values: Array, label: str, units: Mapping[str, str], angle_unit: str | None, rate_unit: str | None
) -> tuple[Array, str]:
    """Return coordinates and their label, of angles and angular velocities in the unit of an axis."""
    own = next((unit for unit in (RADIANS, f" [rad/{units['time']}]", RATE) if label.endswith(unit)), None)
    if own is None:
        return values, label
    unit = angle_unit_of(angle_unit, values) if own == RADIANS else rate_unit_of(units, rate_unit, values)
    return unit.factor * values, label.removesuffix(own) + unit.label
