"""Plots of Poincare sections: one colour for the points of each motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from poinsot.analysis.sections import Section
from poinsot.plot.labels import COLOURS
from poinsot.plot.panels import dress, one_panel, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["section"]

NEIGHBOURS = COLOURS[:5]
INK = 3e4
"""Points of a picture at which they become single dots."""


@plot
def section(section: Section, *, ax: Axes | None = None, title: str = "") -> Axes:
    """Draw the points of a section; neighbouring members have different colours.

    Parameters
    ----------
    section : Section
        Labels of the axes are its own.
    {options}

    Returns
    -------
    matplotlib Axes
        Its figure is `axes.figure`, for `savefig`.

    Examples
    --------
    >>> found = pt.analysis.section(motion, lambda at: at.omega_body[:, :2].T, labels=("first", "second"))
    >>> pt.plot.section(found, title="Angular velocity").get_xlabel()
    'first'
    """
    axes = one_panel(ax, (7, 6), title)
    points = np.isfinite(section.x)
    size = float(np.clip(INK / max(int(np.count_nonzero(points)), 1), 0.1, 6.0))
    for k, colour in enumerate(NEIGHBOURS):
        mine = points.copy()
        mine[np.arange(len(mine)) % len(NEIGHBOURS) != k] = False
        axes.scatter(section.x[mine], section.y[mine], s=size, color=colour, linewidths=0, rasterized=True)
    axes.margins(0.01)
    dress(axes, *section.labels)
    return axes
