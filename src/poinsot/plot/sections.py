"""Plots of Poincare sections: one colour for the points of each motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from poinsot.analysis.sections import Section
from poinsot.checked import checked
from poinsot.mechanics.parameters import described
from poinsot.plot.labels import BLACK, BLUE, GREEN, VERMILION
from poinsot.plot.panels import one_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["section"]

COLOURS = (BLACK, BLUE, VERMILION, GREEN, "#CC79A7")

INK = 3e4
"""Points of a picture at which they become single dots."""


@checked
def section(section: Section, *, ax: Axes | None = None, title: str = "") -> Axes:
    """Draw the points of a section; neighbouring members have different colours.

    Parameters
    ----------
    section : Section
        Labels of the axes are its own.
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    title : str

    Returns
    -------
    matplotlib Axes
        Its figure is `axes.figure`, for `savefig`.

    Raises
    ------
    TypeError
        If it is no section.
    """
    if not isinstance(section, Section):
        raise TypeError(f"section must be a Section, got {described(section)}.")
    axes = one_panel(ax, (7, 6))
    points = np.isfinite(section.x)
    size = float(np.clip(INK / max(int(np.count_nonzero(points)), 1), 0.1, 6.0))
    for k, colour in enumerate(COLOURS):
        mine = points.copy()
        mine[np.arange(len(mine)) % len(COLOURS) != k] = False
        axes.scatter(section.x[mine], section.y[mine], s=size, color=colour, linewidths=0, rasterized=True)
    axes.set_xlabel(section.labels[0])
    axes.set_ylabel(section.labels[1])
    axes.set_title(title)
    axes.margins(0.01)
    axes.grid(alpha=0.25)
    return axes
