"""The orbits of a system, and what they have in common."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from poinsot.mechanics.axes import SPACE_AXES, SpaceAxes, TrackingAxes
from poinsot.mechanics.environment import Axes, Orbit
from poinsot.mechanics.parameters import Parametric

__all__ = ["common_axes", "orbits_of", "same", "sample_time", "space_axes", "span", "tracked_orbits"]


def orbits_of(record: Any) -> Iterator[Orbit]:
    """Yield the orbits among the parts of a system, of a record and of their parts."""
    for part in record.parts:
        if isinstance(part, Orbit):
            yield part
        else:
            yield from orbits_of(part)


def span(system: Any) -> tuple[float, float]:
    """Return the first and the last time at which all orbits of a system are known."""
    spans = [(-np.inf, np.inf), *(orbit.span for orbit in orbits_of(system))]
    return max(first for first, _ in spans), min(last for _, last in spans)


def sample_time(record: Any) -> float:
    """Return a time at which the orbits of a system or of a force are felt; of members the first one's."""
    return next((float(t) for orbit in orbits_of(record) for t in np.ravel(orbit.sample_time)[:1] if t), 0.0)


def common_axes(system: Any) -> Axes | None:
    """Return the axes that all the orbits of a system have in common; None if there are none."""
    axes, *others = [orbit.axes for orbit in orbits_of(system)] or [None]
    if axes is None or any(other is None or not same(other, axes) for other in others):
        return None
    return axes


def tracked_orbits(system: Any) -> list[Orbit]:
    """Return the orbits whose variables are integrated along."""
    return [orbit for orbit in orbits_of(system) if orbit.tracked]


def space_axes(system: Any, closed_forms: bool = False) -> Axes:
    """Return the space axes, with the variables of those orbits; orbits that are one path share them.

    With closed forms, of those orbits alone that have none.
    """
    axes: SpaceAxes = SPACE_AXES
    for place, orbit in enumerate(orbits_of(system)):
        if orbit.tracked and not (closed_forms and orbit.closed_form):
            axes = TrackingAxes(orbit, place, _offset(axes, orbit), axes)
    return axes


def _offset(axes: SpaceAxes, orbit: Orbit) -> int:
    """Return where the variables of an orbit begin that is tracked by axes and itself."""
    node, own = axes, orbit.axes
    while isinstance(node, TrackingAxes):
        if own is not None and same(node.own, own):
            return node.offset
        node = node.others
    return axes.size


def same(a: Parametric, b: Parametric) -> bool:
    """Whether two records of numbers are equal, whatever the shape of their members."""
    return a is b or (
        a.structure == b.structure
        and all(np.array_equal(np.ravel(x), np.ravel(y)) for x, y in zip(a.numbers, b.numbers, strict=True))
    )
