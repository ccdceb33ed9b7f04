"""Sample states at which a system's formulas are compared with themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.axes import Axes
from poinsot.mechanics.force import Potential
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.sky import Orbit, Sky

if TYPE_CHECKING:
    from poinsot.mechanics.system import System

__all__ = ["SAME", "common_axes", "orbits_of", "samples", "see_alike", "time_scale"]

Array = NDArray[np.float64]

SAME = 1e-11
"""Relative difference up to which two values of a formula count as equal."""


def samples(system: System, count: int = 6) -> tuple[Array, Array, Array]:
    """Return unit quaternions (n, 4), times (n,) and rates (n, 3), always the same."""
    random = np.random.default_rng(20061027)
    q = random.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    return q, random.uniform(0, 1, count) * time_scale(system), random.normal(size=(count, 3))


def time_scale(system: System) -> float:
    """Return the time in which the fastest orbit turns by about a radian; 1 without one."""
    rates = [functions.norm(orbit.velocity_at(0.0)) * orbit.inverse_distance_at(0.0) for orbit in orbits_of(system)]
    return 1 / float(np.max(rates, initial=0.0) or 1.0)


def orbits_of(record: Any) -> Iterator[Orbit]:
    """Yield the orbits among the fields of the forces of a system."""
    parts = record.parts if isinstance(record, Parametric) else record.forces
    for part in parts:
        if isinstance(part, Orbit):
            yield part
        yield from orbits_of(part)


def common_axes(system: System) -> Axes | None:
    """Return the axes of the one orbit that the forces of a system have in common; None if there is none."""
    orbits = list(orbits_of(system))
    if not orbits or any(not _equal(orbit, orbits[0]) for orbit in orbits[1:]):
        return None
    return orbits[0].axes


def _equal(a: Orbit, b: Orbit) -> bool:
    return a is b or (
        a.structure == b.structure and all(np.array_equal(x, y) for x, y in zip(a.numbers, b.numbers, strict=True))
    )


def see_alike(system: System, axes: Axes) -> bool:
    """Return whether every force gives the same with all vectors along the axes as with all along space."""
    q, t, omega = samples(system, 3)
    first = axes.with_numbers(np.ravel(number)[0] for number in axes.numbers)
    variables = first.start(t)
    along = quat.product(quat.conjugate(first.quaternion(t, variables)), q)
    in_space = _values(system, q, omega, Sky(t))
    in_axes = _values(system, along, omega, first.sky(t, variables.T))
    return all(np.allclose(x, y, rtol=0, atol=SAME * np.max(np.abs(x))) for x, y in zip(in_space, in_axes, strict=True))


def _values(system: System, q: Array, omega: Array, sky: Sky) -> list[Scalar]:
    twin = system.with_numbers(np.ravel(number)[0] for number in system.numbers)
    attitude = Attitude.from_quaternion(Vector(q.T))
    return [
        force.energy(twin.body, attitude, sky)
        if isinstance(force, Potential)
        else np.stack(np.broadcast_arrays(*force.torque(twin.body, attitude, Vector(omega.T), sky)))  # type: ignore[attr-defined]
        for force in twin.forces
    ]
