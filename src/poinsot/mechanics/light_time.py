"""Light time: when a body was as an observer sees it."""

from __future__ import annotations

import numpy as np

from poinsot import functions
from poinsot.functions import Vector
from poinsot.mechanics.environment import Orbit
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS
from poinsot.records.units import DerivedUnits, length_of_inertia

__all__ = ["METRES", "SPEED_OF_LIGHT", "emission_time", "length_unit", "speed_of_light"]

SPEED_OF_LIGHT = 299_792_458.0
"""Speed of light in vacuum, m/s (exact)."""

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "au": 149_597_870_700.0}
"""Units of length."""

MAX_STEPS = 50
"""Largest number of Newton steps; two suffice for planets, whose speed is 1e-4 of the speed of light."""


def length_unit(units: DerivedUnits) -> str:
    """Return the unit of length of a system, also from a unit of inertia such as "kg km2"; "" if it is unknown."""
    return units.length if units.length in METRES else length_of_inertia(units.inertia, METRES)


def speed_of_light(units: DerivedUnits) -> float:
    """Return the speed of light in the units of a system.

    Raises
    ------
    ValueError
        If the unit of length or of time is unknown.
    """
    length = length_unit(units)
    if not length or units.time not in SECONDS:
        raise ValueError(
            "light_time must have known units of time and length to be computed, got the units "
            f"{quoted(units.time)} and {quoted(units.inertia)}. "
            'Write System(..., units={"time": "s", "inertia": "kg km2"}), or light_time=False.'
        )
    return SPEED_OF_LIGHT * SECONDS[units.time] / METRES[length]


def emission_time(orbit: Orbit, time: Array, speed: float) -> Array:
    """Return the times at which light left the body that reaches the observer at the given times.

    The time te solves te + |r(te)| / c = t, with the position r of the body relative to the observer. The result has
    the shape of the times; with members of the orbit (members, n).
    """
    emitted = np.asarray(time, dtype=float)
    for _ in range(MAX_STEPS):
        r, v = Vector(orbit.position_at(emitted)), Vector(orbit.velocity_at(emitted))
        distance = functions.norm(r)
        excess = emitted + distance / speed - time
        step = np.asarray(excess / (1 + functions.dot(r, v) / (distance * speed)), dtype=float)
        emitted = emitted - step
        if np.all(np.abs(step) <= np.spacing(np.abs(emitted) + np.abs(time))):
            break
    return emitted
