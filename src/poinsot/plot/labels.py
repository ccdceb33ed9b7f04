"""Colours of plots, units of axes, and checks of the motion."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from poinsot.mechanics.environment import Orbit
from poinsot.printable import quoted
from poinsot.propagation.columns import unit_of_column
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import ANGLE_UNITS, NAMED_RATES
from poinsot.records.calendar import SECONDS
from poinsot.records.parameters import same
from poinsot.records.units import DerivedUnits
from poinsot.systems.system import System

__all__ = [
    "BLACK",
    "BLUE",
    "COLOURS",
    "GREEN",
    "GREY",
    "PURPLE",
    "TIME_UNITS",
    "TORQUE_UNITS",
    "VERMILION",
    "Unit",
    "angle_unit_of",
    "bracketed",
    "column_label",
    "different_orbits",
    "in_words",
    "momentum_label",
    "one_body",
    "one_member",
    "one_rotation",
    "rate_unit_of",
    "time_unit_of",
    "torque_unit_of",
    "unit_of",
]

COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of Okabe and Ito, which colour-blind readers can distinguish."""
BLACK, BLUE, VERMILION, GREEN, PURPLE = COLOURS[:5]
GREY = "#8C8C8C"

TIME_UNITS = {**SECONDS, "yr": 365.25 * SECONDS["d"]}
"""Units of time in seconds, with the Julian year."""

SPANS = {"yr": 3.0, "d": 3.0, "h": 10_000 / 3600, "min": 10.0, "s": 0.0}
"""Units of time with their least span: the first unit in which the span reaches it is the default."""
RATES = {"rpm": 10.0, "deg/s": 0.01, "deg/h": 1.0, "deg/d": 0.0}
"""Units of angular velocity with their least size: the default is the first that the largest rate reaches."""
SMALL_ANGLE = np.radians(0.1)
"""Angle, radians, below which the default unit is the arc second."""

MEASURES: dict[str, tuple[float, dict[str, int]]] = {
    "m": (1.0, {"m": 1}),
    "au": (149597870700.0, {"m": 1}),
    "g": (1e-3, {"kg": 1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    **{time: (seconds, {"s": 1}) for time, seconds in TIME_UNITS.items()},
}
"""Units of which other units are products, in kg, m and s."""
PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}

NAMED_UNITS = {"kg m2 s-1": "N m s", "kg m2 s-2": "J"}
"""Names of the units of angular momentum and energy in kg, m and s."""
TORQUE_UNITS = {"kg m2 s-2": "N m"}
"""Name of the unit of torque in kg, m and s."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def one_rotation(motion: Trajectory, name: str = "motion") -> Trajectory:
    """Return the motion of one body or of an ensemble; raise an error for two bodies."""
    if len(motion.of_bodies) > 1:
        raise ValueError(f"{name} must be of one body, got two bodies. Take {name}.primary or {name}.secondary.")
    return motion


def one_body(motion: Trajectory, name: str = "motion") -> Trajectory:
    """Return the trajectory of one body; raise an error for two bodies, an ensemble or no times."""
    return one_member(one_rotation(motion, name), name)


def one_member(motion: Trajectory, name: str = "motion") -> Trajectory:
    """Return the trajectory of one body or one pair; raise an error for an ensemble or no times."""
    if motion.is_ensemble:
        alone = "one body" if len(motion.of_bodies) == 1 else "one pair"
        raise ValueError(
            f"{name} must be of {alone}, got an ensemble of {len(motion)} members. Take one: {name}.member(0)."
        )
    if not motion.times.size:
        raise ValueError(f"{name} must contain times to draw, got none.")
    return motion


def different_orbits(motion: Trajectory) -> list[Orbit]:
    """Return the orbits of a system, each once, in the order of its forces."""
    orbits: list[Orbit] = []
    for orbit in motion.system.orbits:
        if not any(same(orbit, known) for known in orbits):
            orbits.append(orbit)
    return orbits


@dataclass(frozen=True)
class Unit:
    """Unit of an axis: the factor from the numbers of a motion, and its text."""

    factor: float
    written: str

    @property
    def label(self) -> str:
        """Unit in brackets: " [rad s⁻¹]"."""
        return bracketed(self.written)


def time_unit_of(units: Mapping[str, str], chosen: str | None, times: ArrayLike) -> Unit:
    """Return the unit of an axis of time: the one that suits the span of times unless another is chosen."""
    if chosen is None and units["time"] in TIME_UNITS:
        span = TIME_UNITS[units["time"]] * (float(np.ptp(times)) or _largest(times))
        chosen = next(unit for unit, least in SPANS.items() if span >= least * TIME_UNITS[unit])
    if chosen is None or chosen == units["time"]:
        return Unit(1.0, units["time"])
    return Unit(_seconds("time_unit", units) / TIME_UNITS[_known("time_unit", chosen, TIME_UNITS)], chosen)


def angle_unit_of(chosen: str | None, angles: ArrayLike) -> Unit:
    """Return the unit of an axis of angles: the one that suits the largest unless another is chosen."""
    if chosen is None:
        chosen = "arcsec" if 0 < _largest(angles) < SMALL_ANGLE else "deg"
    return Unit(1 / ANGLE_UNITS[_known("angle_unit", chosen, ANGLE_UNITS)], chosen)


def rate_unit_of(units: Mapping[str, str], chosen: str | None, rates: ArrayLike | None = None) -> Unit:
    """Return the unit of an angular velocity: "deg/s", "rpm"; an angle alone is per unit of time of the system.

    The default suits the largest rate. It is radians if the unit of time has no known length.
    """
    if chosen is None and rates is not None and units["time"] in TIME_UNITS:
        largest = _largest(rates)
        chosen = next(unit for unit, least in RATES.items() if rate_unit_of(units, unit).factor * largest >= least)
    angle, _, per = "/".join(NAMED_RATES.get(chosen or "rad", (chosen or "rad",))).partition("/")
    if angle not in ANGLE_UNITS or per not in ("", *TIME_UNITS):
        raise ValueError(
            f"rate_unit must be rpm, or an angle ({', '.join(ANGLE_UNITS)}) alone or over a time "
            f"({', '.join(TIME_UNITS)}) as in 'deg/s', got {quoted(chosen)}."
        )
    time = 1.0 if per in ("", units["time"]) else TIME_UNITS[per] / _seconds("rate_unit", units)
    if chosen in NAMED_RATES:
        return Unit(time / ANGLE_UNITS[angle], chosen)
    counted = per or units["time"]
    written = f"{angle} / unit of time" if counted == "1" else f"{angle} {counted}-1"
    return Unit(time / ANGLE_UNITS[angle], written)


def unit_of(name: str, own: str, chosen: str | None) -> Unit:
    """Return the unit of lengths, momenta or torques in CF notation, by default the motion's own."""
    if chosen is None or chosen == own:
        return Unit(1.0, own)
    before, after = (_measured(unit) for unit in (own, chosen))
    if before is None or after is None or before[1] != after[1]:
        raise ValueError(
            f"{name} must be of the kind of {quoted(own)}, the unit of the motion, got {quoted(chosen)}. Words are "
            f"{', '.join(MEASURES)}, with {' '.join(PREFIXES)} before them, and powers after: 'mN m', 'km2'."
        )
    return Unit(before[0] / after[0], chosen)


def torque_unit_of(units: Mapping[str, str], chosen: str | None = None) -> Unit:
    """Return the unit of torques, by default the unit of the motion, written as N m where it is kg m2 s-2."""
    own = DerivedUnits(units).energy
    return unit_of("torque_unit", own, TORQUE_UNITS.get(own) if chosen is None else chosen)


def _measured(unit: str) -> tuple[float, dict[str, int]] | None:
    """Return the factor and the powers of a unit in kg, m and s; None for a unit with an unknown word."""
    factor, powers = 1.0, {"kg": 0, "m": 0, "s": 0}
    for word in unit.split():
        found = re.fullmatch(rf"({'|'.join(PREFIXES)})??({'|'.join(MEASURES)})(-?\d+)?", word)
        if found is None:
            return None
        size, own = MEASURES[found[2]]
        power = int(found[3] or 1)
        factor *= (PREFIXES[found[1] or ""] * size) ** power
        for base, exponent in own.items():
            powers[base] += power * exponent
    return factor, powers


def _largest(values: ArrayLike) -> float:
    """Return the largest magnitude of finite numbers, 0 for no numbers."""
    sizes = np.abs(np.asarray(values, dtype=float))
    return float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))


def _known(name: str, unit: str, units: Mapping[str, float]) -> str:
    if unit not in units:
        raise ValueError(f"{name} must be one of {', '.join(units)}, got {quoted(unit)}.")
    return unit


def _seconds(name: str, units: Mapping[str, str]) -> float:
    if units["time"] not in TIME_UNITS:
        raise ValueError(
            f"{name} must be left out where the unit of time of the system has no known length, got one. "
            "System(..., units={'time': 's'}) names it."
        )
    return TIME_UNITS[units["time"]]


def column_label(system: System, name: str) -> str:
    """Return the unit of an output variable of a motion in brackets: " [N m s]"; "" if it is unknown."""
    unit = unit_of_column(system, name)
    return unit and bracketed(unit)


def momentum_label(units: Mapping[str, str]) -> str:
    """Return the unit of angular momentum in brackets: " [N m s]"."""
    return bracketed(DerivedUnits(units).momentum)


def bracketed(unit: str) -> str:
    """Return a CF unit in its usual notation: "kg m2 s-1" becomes " [N m s]", "km s-1" becomes " [km s⁻¹]"."""
    if unit == "1":
        return " (dimensionless)"
    unit = NAMED_UNITS.get(unit, unit)
    raised = re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power.group().translate(SUPERSCRIPTS), unit)
    return f" [{raised}]"


def in_words(name: str) -> str:
    """Return the name of a class as words: "GravityGradient" becomes "gravity gradient"."""
    words = re.split(r"(?<=[a-z])(?=[A-Z])", name.replace("Yorp", "YORP"))
    return " ".join(word[:1].lower() + word[1:] if word[1:2].islower() else word for word in words)
