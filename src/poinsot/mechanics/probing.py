"""The orbits of a system, and sample states at which its formulas are tried."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.mechanics.axes import SPACE_AXES, Axes, SpaceAxes, TrackingAxes
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.parameters import Parametric

if TYPE_CHECKING:
    from poinsot.mechanics.system import System

__all__ = [
    "common_axes",
    "orbits_of",
    "same",
    "sample_time",
    "samples",
    "space_axes",
    "span",
    "time_scale",
    "tracked_orbits",
]

Array = NDArray[np.float64]


def samples(system: System, count: int = 6) -> tuple[Array, Array, Array]:
    """Return unit quaternions (n, 4), times (n,) and rates (n, 3), always the same."""
    random = np.random.default_rng(20061027)
    q = random.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    scale = time_scale(system)
    farthest = min([3.0, *(np.log10(np.min(orbit.sample_reach) / scale) for orbit in orbits_of(system))])
    times = random.uniform(-1, 1, count) * 10.0 ** np.linspace(-1, farthest, count)  # near and far, for what switches
    return q, _within(span(system), sample_time(system) + times * scale), random.normal(size=(count, 3))


def span(system: System) -> tuple[float, float]:
    """Return the first and the last time at which all orbits of a system are known."""
    spans = [(-np.inf, np.inf), *(orbit.span for orbit in orbits_of(system))]
    return max(first for first, _ in spans), min(last for _, last in spans)


def _within(limits: tuple[float, float], times: Array) -> Array:
    first, last = limits
    return first + np.mod(times - first, last - first) if np.isfinite(last - first) else times


def time_scale(system: System) -> float:
    """Return the time in which the fastest orbit turns by about a radian; 1 without one."""
    rates = [
        np.max(functions.norm(orbit.velocity_at(t)) * orbit.inverse_distance_at(t))
        for orbit in orbits_of(system)
        for t in [orbit.sample_time]
    ]
    return 1 / float(np.max(rates, initial=0.0) or 1.0)


def sample_time(record: Any) -> float:
    """Return a time at which the orbits of a system or of a force are felt; of members the first one's."""
    return next((float(t) for orbit in orbits_of(record) for t in np.ravel(orbit.sample_time)[:1] if t), 0.0)


def orbits_of(record: Any) -> Iterator[Orbit]:
    """Yield the orbits among the fields of the forces of a system."""
    parts = record.parts if isinstance(record, Parametric) else record.forces
    for part in parts:
        if isinstance(part, Orbit):
            yield part
        else:
            yield from orbits_of(part)


def common_axes(system: System) -> Axes | None:
    """Return the axes that all the orbits of a system have in common; None if there are none."""
    axes, *others = [orbit.axes for orbit in orbits_of(system)] or [None]
    if axes is None or any(other is None or not same(other, axes) for other in others):
        return None
    return axes


def tracked_orbits(system: System) -> list[Orbit]:
    """Return the orbits whose variables are integrated along."""
    return [orbit for orbit in orbits_of(system) if orbit.tracked]


def space_axes(system: System, closed_forms: bool = False) -> Axes:
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
