"""Plots of branches of periodic motions: stable parts solid, unstable ones dashed, bifurcations marked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.analysis.continuation import Branch
from poinsot.analysis.periodic import PeriodicMotion
from poinsot.errors import real_array
from poinsot.plot.labels import BLACK, BLUE, GREEN, PURPLE, VERMILION
from poinsot.plot.panels import dress, one_panel, plot
from poinsot.printable import quoted

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
    "doubling": ("D", PURPLE),
    "collision": ("X", BLACK),
    "torus": ("P", GREEN),
    "unresolved": ("$?$", BLACK),
}


@plot
def branch(
    branch: Branch | Sequence[Branch],
    quantity: Callable[[PeriodicMotion], float],
    labels: tuple[str, str],
    *,
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Draw a quantity of the periodic motions of one or several branches against the parameter.

    Parameters
    ----------
    branch : Branch or sequence of them
        Branches, all in the same parameter.
    quantity : function of a PeriodicMotion
        Function that returns a number, such as an initial angle, or the amplitude over the period.
    labels : pair of str
        Labels of the axes with units: ("eccentricity", "amplitude [deg]").
    {options}

    Returns
    -------
    matplotlib Axes
        The panel; `axes.figure` is its figure, for `savefig`.

    Raises
    ------
    TypeError, ValueError
        If there is no branch, or the quantity is not a number.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> body = pt.Body((1.0, 1.3, 1.6))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    >>> system = pt.System(body, pt.GravityGradient(orbit))
    >>> at_rest = pt.analysis.periodic_motion(system, start, orbit.period, orbit.frame)
    >>> found = pt.analysis.continue_motion(at_rest, "moments[0]", 1.01, frame=lambda _: orbit.frame)
    >>> pt.plot.branch(found, lambda motion: motion.period, ("moments[0]", "period")).get_ylabel()
    'period'
    """
    if len(labels) != 2:
        raise ValueError(f"labels must be a pair of them, got {quoted(labels)}.")
    branches = [branch] if isinstance(branch, Branch) else branch
    if not branches:
        raise ValueError("branch must be a Branch or several, got none.")
    axes = one_panel(ax, (8, 4.5), title)

    def name(label: str) -> str | None:
        return None if label in axes.get_legend_handles_labels()[1] else label

    for each in branches:
        for stable, points in _parts(each, quantity):
            axes.plot(*np.transpose(points), linewidth=1.6, label=name(NAMES[stable]), **STYLES[stable])
    for each in branches:
        for found in each.bifurcations:
            marker, colour = MARKS[found.kind]
            place = found.value, _value(quantity, found.motion)
            axes.plot(*place, marker, color=colour, markersize=7, label=name(found.kind), zorder=5)
    dress(axes, *labels)
    return axes


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
