"""The names of the units of a system."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping
from typing import Any

from poinsot.immutable import Immutable
from poinsot.printable import described, quoted
from poinsot.quantities import Quantity, annotated_with, plain
from poinsot.records.parameters import Parametric, listed

__all__ = ["PER_TIME", "DerivedUnits", "checked_units", "dated_units", "in_units", "length_of_inertia"]

PER_TIME = "rad per unit of time"
"""Unit of angular velocities of a result without units."""


class DerivedUnits(Immutable):
    """The units of derived quantities in CF notation, from those of time, inertia and length.

    They are "1" where these have none, and "" where there is no length; a rate has "rad" alone in data, not in words.
    """

    def __init__(self, units: Mapping[str, str]) -> None:
        self.time, self.inertia, self.length = units["time"], units["inertia"], units.get("length", "")
        self.per_time = _power(self.time, -1)
        self.rate = "rad" if self.time == "1" else f"rad {self.per_time}"
        self.rate_in_words = PER_TIME if self.time == "1" else self.rate
        self.momentum = _product(self.inertia, self.per_time)
        self.energy = _product(self.inertia, _power(self.time, -2))
        self.velocity = self._with_length(self.length, self.per_time)
        self.mass = self._with_length(self.inertia, _power(self.length, -2))
        self.linear_momentum = self._with_length(self.momentum, _power(self.length, -1))
        self.gravitation = self._with_length(_power(self.length, 5), _power(self.inertia, -1), _power(self.time, -2))

    def converted(self, name: str, value: Any) -> Any:
        """Return an argument of a state without its unit, in the unit of the system; unchanged if that has no name.

        Raises
        ------
        TypeError
            If the unit of the value does not convert.
        """
        unit, parts = {
            "omega": (self.rate, (self.time,)),
            "angular_momentum": (self.momentum, (self.time, self.inertia)),
            "position": (self.length, (self.length,)),
            "velocity": (self.velocity, (self.time, self.length)),
            "time": (self.time, (self.time,)),
        }.get(name.removesuffix("_body").removesuffix("_space"), ("", ("",)))
        is_named = not {"", "1"}.intersection(parts)
        return plain(name, value, unit) if value is not None and is_named else value

    def _with_length(self, *units: str) -> str:
        return self.length and _product(*units)


def in_units(record: Any, units: DerivedUnits) -> str:
    """Return the repr of a record with the units of those of its numbers whose units are known."""
    own: Any = type(record).__repr__
    if own is not Parametric.__repr__:
        return repr(record)
    name, fields = record.definition
    known = {"moments": units.inertia, "mass": units.mass}
    measured = {"angle": "rad", "rate": units.rate, "time": units.time, "duration": units.time}
    known |= {field: measured[quantity.kind] for field, quantity in annotated_with(type(record), Quantity).items()}
    texts = (f"{field}={_in_unit(value, known.get(field, '1'), units)}" for field, value in fields.items())
    return f"{name}({', '.join(texts)})"


def _in_unit(value: Any, unit: str, units: DerivedUnits) -> str:
    if isinstance(value, Parametric):
        return in_units(value, units)
    return listed(value) + (f" {unit}" if unit not in ("", "1") else "")


WORD = re.compile(r"([A-Za-z]+)(-?\d+)?")


def _power(unit: str, exponent: int) -> str:
    words = [WORD.fullmatch(word) for word in unit.split()]
    if not all(words) or len(words) < 2:
        return "1" if unit == "1" else f"{unit}{exponent}"
    return _product(*(f"{word[1]}{int(word[2] or 1) * exponent}" for word in words if word))


def length_of_inertia(inertia: str, lengths: Container[str]) -> str:
    """Return the unit of length in a unit of inertia, "km" in "kg km2"; "" if none of the known lengths is squared."""
    words = (WORD.fullmatch(word) for word in inertia.split())
    return next((word[1] for word in words if word and word[1] in lengths and word[2] == "2"), "")


def _product(*units: str) -> str:
    """Return a product in which each unit is there once, if all are words with exponents."""
    together = " ".join(unit for unit in units if unit != "1")
    exponents: dict[str, int] = {}
    for word in together.split():
        if not (known := WORD.fullmatch(word)):
            return together
        exponents[known[1]] = exponents.get(known[1], 0) + int(known[2] or 1)
    return " ".join(name if n == 1 else f"{name}{n}" for name, n in exponents.items() if n) or "1"


TIME_WORDS = {
    "s": ("sec", "second"),
    "min": ("minute",),
    "h": ("hr", "hour"),
    "d": ("day",),
    "yr": ("year",),
}
"""Words for units of time, by the symbol in which results name the unit; the plural is accepted too."""

SYMBOL_OF_WORD = {word: symbol for symbol, words in TIME_WORDS.items() for word in words}


def _time_unit(name: str) -> str:
    """Return the symbol of a unit of time that is given as a word; any other name unchanged."""
    singular = name.strip().lower().removesuffix("s")
    return SYMBOL_OF_WORD.get(singular, name)


def checked_units(units: Mapping[str, str] | None, measures: tuple[str, ...]) -> dict[str, str]:
    """Return the units of what a system measures, such as time and inertia, "1" where none is given."""
    units = {} if units is None else units
    if not isinstance(units, Mapping):
        raise TypeError(f'units must be a mapping such as {{"time": "s"}}, got {described(units)}.')
    for key, unit in units.items():
        if not isinstance(key, str) or key not in measures:
            *others, last = map(repr, measures)
            raise ValueError(f"units must name {', '.join(others)} and {last}, got {quoted(key)}.")
        if not isinstance(unit, str):
            remedy = f" Write {quoted(str(unit))}." if hasattr(unit, "to_string") else ""
            raise TypeError(f"units must be words, but units[{quoted(key)}] = {quoted(unit)}.{remedy}")
    checked = {measure: units.get(measure, "1") for measure in measures}
    return {**checked, "time": _time_unit(checked["time"])}


def dated_units(checked: dict[str, str], given: Mapping[str, str] | None, calendar: Any) -> dict[str, str]:
    """Return the units with the calendar's of time; refuse another one."""
    if calendar is None:
        return checked
    if given is not None and checked["time"] not in ("1", calendar.unit):
        raise ValueError(
            f"units['time'] must be {quoted(calendar.unit)}, in which the calendar of the orbits counts, got "
            f"{quoted(checked['time'])}."
        )
    return {**checked, "time": calendar.unit}
