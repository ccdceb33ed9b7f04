"""Plots of branches of periodic motions: stable parts solid, unstable ones dashed, bifurcations marked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.analysis.continuation import Branch
from poinsot.analysis.periodic import PeriodicMotion
from poinsot.checked import checked
from poinsot.errors import real_array
from poinsot.mechanics.parameters import described
from poinsot.plot.labels import BLACK, BLUE, GREEN, VERMILION
from poinsot.plot.panels import one_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["branch"]

STYLES: dict[bool, dict[str, Any]] = {
    True: {"color": BLUE, "linestyle": "-"},
    False: {"color": VERMILION, "linestyle": "--"},
}
NAMES = {True: "stable", False: "unstable"}
MARKS = {
    "fold": ("o", BLACK),
    "branching": ("s", GREEN),
    "doubling": ("D", "#CC79A7"),
    "collision": ("X", BLACK),
    "torus": ("P", GREEN),
    "unresolved": ("$?$", BLACK),
}


@checked
def branch(
    branch: Branch | Sequence[Branch],
    quantity: Callable[[PeriodicMotion], float],
    labels: tuple[str, str],
    *,
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Draw a quantity of the motions of a branch, or of several, over the parameter.

    Parameters
    ----------
    branch : Branch or sequence of them
        All in the same parameter.
    quantity : function of a PeriodicMotion
        A number: an angle of the start, the amplitude over the period.
    labels : pair of str
        Of the axes, with units: ("eccentricity", "amplitude [deg]").
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    title : str

    Returns
    -------
    matplotlib Axes
        Its figure is `axes.figure`, for `savefig`.

    Raises
    ------
    TypeError, ValueError
        If something else comes.
    """
    branches = _checked(branch, quantity, labels)
    axes = one_panel(ax, (8, 4.5), title)
    named: set[str] = set()

    def name(label: str) -> str | None:
        new = label not in named
        named.add(label)
        return label if new else None

    for each in branches:
        for stable, points in _parts(each, quantity):
            axes.plot(*np.transpose(points), linewidth=1.6, label=name(NAMES[stable]), **STYLES[stable])
    for each in branches:
        for found in each.bifurcations:
            marker, colour = MARKS[found.kind]
            place = found.value, _value(quantity, found.motion)
            axes.plot(*place, marker, color=colour, markersize=7, label=name(found.kind), zorder=5)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.grid(alpha=0.25)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(named), frameon=False)
    return axes


def _checked(branch: Any, quantity: Any, labels: Any) -> list[Branch]:
    """Return the branches, or refuse what is none."""
    if not callable(quantity):
        raise TypeError(f"quantity must be a function of a PeriodicMotion, got {described(quantity)}.")
    if isinstance(labels, str) or len(labels) != 2:
        raise ValueError(f"labels must be a pair of them, got {labels!r}.")
    branches = list(branch) if isinstance(branch, Sequence) else [branch]
    if not branches:
        raise ValueError("branch must be a Branch or several, got none.")
    for each in branches:
        if not isinstance(each, Branch):
            raise TypeError(f"branch must be a Branch or several, got {described(each)}.")
    return branches


def _value(quantity: Callable[[PeriodicMotion], float], motion: PeriodicMotion) -> float:
    return float(real_array("the quantity of a motion", quantity(motion), ()))


def _parts(branch: Branch, quantity: Callable[[PeriodicMotion], float]) -> Iterator[tuple[bool, list[Any]]]:
    """Yield connected points of one stability; where that changes at a bifurcation, there, else at the next point."""
    part: list[Any] = []
    stable = branch.motions[0].stable
    for i, (value, motion) in enumerate(zip(branch.values, branch.motions, strict=True)):
        point = value, _value(quantity, motion)
        if motion.stable != stable:
            seam = [(b.value, _value(quantity, b.motion)) for b in branch.bifurcations if b.after == i - 1] or [point]
            yield stable, [*part, seam[-1]]
            part, stable = [seam[-1]], motion.stable
        part.append(point)
    yield stable, part
