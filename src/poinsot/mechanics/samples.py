"""The orbits of a system, and sample states at which its formulas are tried."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.mechanics.axes import SPACE_AXES, Axes, TrackingAxes
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.sky import Orbit

if TYPE_CHECKING:
    from poinsot.mechanics.system import System

__all__ = ["common_axes", "orbits_of", "sample_time", "samples", "space_axes", "time_scale"]

Array = NDArray[np.float64]


def samples(system: System, count: int = 6) -> tuple[Array, Array, Array]:
    """Return unit quaternions (n, 4), times (n,) and rates (n, 3), always the same."""
    random = np.random.default_rng(20061027)
    q = random.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    times = random.uniform(-1, 1, count) * 10.0 ** np.linspace(-1, 3, count)  # near and far, for what switches
    return q, sample_time(system) + times * time_scale(system), random.normal(size=(count, 3))


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
    """Return the axes of the one orbit that the forces of a system have in common; None if there is none."""
    orbits = list(orbits_of(system))
    if not orbits or any(not _equal(orbit, orbits[0]) for orbit in orbits[1:]):
        return None
    return orbits[0].axes


def space_axes(system: System) -> Axes:
    """Return the space axes, with the variables of those orbits whose formulas do not run on symbols."""
    axes: Axes = SPACE_AXES
    for orbit in orbits_of(system):
        if not orbit.closed_form and orbit.axes is not None:
            axes = TrackingAxes(orbit.axes, axes)
    return axes


def _equal(a: Orbit, b: Orbit) -> bool:
    return a is b or (
        a.structure == b.structure and all(np.array_equal(x, y) for x, y in zip(a.numbers, b.numbers, strict=True))
    )
