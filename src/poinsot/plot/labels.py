"""What the pictures share: colours, units on labels, and the check of what is drawn."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.parameters import described
from poinsot.mechanics.system import System
from poinsot.propagation.trajectory import Trajectory

__all__ = [
    "BLACK",
    "BLUE",
    "GREEN",
    "GREY",
    "VERMILION",
    "bracketed",
    "checked_motion",
    "energy_unit",
    "instant",
    "momentum_unit",
    "rate_label",
    "time_label",
]

BLACK, BLUE, VERMILION, GREEN = "#000000", "#0072B2", "#D55E00", "#009E73"
"""Four colours of Okabe and Ito: told apart by all eyes."""

GREY = "#8C8C8C"

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def checked_motion(motion: Any, name: str = "motion") -> Trajectory:
    """Return the trajectory of one body; refuse anything else."""
    if not isinstance(motion, Trajectory):
        raise TypeError(f"{name} must be a Trajectory, got {described(motion)}.")
    if motion.quaternion.ndim != 2:
        raise ValueError(
            f"{name} must be of one body, got an ensemble of {len(motion.quaternion)} members. "
            f"Take one: {name}.member(0)."
        )
    return motion


def momentum_unit(units: Mapping[str, str]) -> str:
    """Return the CF unit of angular momentum from the units of a system; "1" where they have none."""
    return _inertia_over_time(units, 1)


def energy_unit(units: Mapping[str, str]) -> str:
    """Return the CF unit of energy from the units of a system; "1" where they have none."""
    return _inertia_over_time(units, 2)


def _inertia_over_time(units: Mapping[str, str], power: int) -> str:
    per_time = "1" if units["time"] == "1" else f"{units['time']}-{power}"
    return " ".join(unit for unit in (units["inertia"], per_time) if unit != "1") or "1"


def time_label(system: System, calendar: Calendar | None = None) -> str:
    """Return the label of an axis of time: "time [s] since 2029-04-13 TDB", by the orbits unless a calendar is said."""
    calendar = calendar or system.calendar
    since = "" if calendar is None else f" since {calendar.zero} {calendar.scale}"
    return f"time{bracketed(system.units['time'])}{since}"


def rate_label(units: Mapping[str, str]) -> str:
    """Return the unit of angular velocity in brackets: " [rad s⁻¹]"."""
    return " [rad / unit of time]" if units["time"] == "1" else bracketed(f"rad {units['time']}-1")


def instant(motion: Trajectory, index: int) -> str:
    """Return one of the times of a motion in words: "time 12.5 s"."""
    unit = motion.system.units["time"]
    return f"time {motion.times[index]:.6g}" + ("" if unit == "1" else f" {unit}")


def bracketed(unit: str) -> str:
    """Return a CF unit as people write it: "kg m2 s-1" becomes " [kg m² s⁻¹]"."""
    if unit == "1":
        return " (dimensionless)"
    raised = re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power.group().translate(SUPERSCRIPTS), unit)
    return f" [{raised}]"
