"""The names of the units of a system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from poinsot.mechanics.parameters import described

__all__ = ["DerivedUnits", "checked_units", "dated_units"]


class DerivedUnits:
    """The units of derived quantities in CF notation, from those of time and inertia; "1" where these have none."""

    def __init__(self, units: Mapping[str, str]) -> None:
        self.time, self.inertia = units["time"], units["inertia"]
        self.per_time = _power(self.time, -1)
        self.rate = "rad" if self.time == "1" else f"rad {self.per_time}"
        self.momentum = _product(self.inertia, self.per_time)
        self.energy = _product(self.inertia, _power(self.time, -2))


def _power(unit: str, exponent: int) -> str:
    return "1" if unit == "1" else f"{unit}{exponent}"


def _product(*units: str) -> str:
    return " ".join(unit for unit in units if unit != "1") or "1"


def checked_units(units: Mapping[str, str] | None) -> dict[str, str]:
    """Return the units of time and inertia, "1" where none is given."""
    units = {} if units is None else units
    if not isinstance(units, Mapping):
        raise TypeError(f'units must be a mapping such as {{"time": "s"}}, got {described(units)}.')
    for key, unit in units.items():
        if key not in ("time", "inertia"):
            raise ValueError(f"units must name 'time' and 'inertia', got {key!r}.")
        if not isinstance(unit, str):
            raise TypeError(f"units must be words, but units[{key!r}] = {unit!r}.")
    return {"time": units.get("time", "1"), "inertia": units.get("inertia", "1")}


def dated_units(checked: dict[str, str], given: Mapping[str, str] | None, calendar: Any) -> dict[str, str]:
    """Return the units with the calendar's of time; refuse another one."""
    if calendar is None:
        return checked
    if given is not None and checked["time"] not in ("1", calendar.unit):
        raise ValueError(
            f"units['time'] must be {calendar.unit!r}, in which the calendar of the orbits counts, got "
            f"{checked['time']!r}."
        )
    return {**checked, "time": calendar.unit}
