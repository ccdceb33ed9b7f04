"""Numbers with a unit, written as text: "45 deg", "3 rpm", "8 h"."""

from __future__ import annotations

import re

from poinsot.mechanics.calendar import SECONDS
from poinsot.quantities import ANGLE_UNITS, NAMED_RATES

__all__ = ["quantity"]

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)\s*(?P<unit>[A-Za-z]+(\s*/\s*[A-Za-z]+)?)\s*"
)


def quantity(text: str, kind: str, time_unit: str | None) -> float:
    """Return an angle in radians, a rate in radians per unit of time, or a time in units of time.

    Parameters
    ----------
    text : str
        A number and a unit.
    kind : {"angle", "rate", "time"}
    time_unit : {"s", "min", "h", "d"}, optional
        What the numbers without a unit are counted in.

    Raises
    ------
    ValueError
        With the second half of a sentence: what it must be, and what it is.
    """
    found = _QUANTITY.fullmatch(text) if len(text) < 100 else None
    if found is None:
        raise ValueError(f"must be a number, alone or with a unit such as {EXAMPLES[kind]}, got {_short(text)}.")
    unit = "".join(found["unit"].split())
    return float(found["number"]) * _factor(unit, kind, time_unit, text)


EXAMPLES = {"angle": "'45 deg'", "rate": "'0.1 deg/s'", "time": "'8 h'"}


def _factor(unit: str, kind: str, time_unit: str | None, text: str) -> float:
    if kind == "angle":
        return ANGLE_UNITS[_known(unit, ANGLE_UNITS, kind, text)]
    if kind == "time":
        return SECONDS[_known(unit, SECONDS, kind, text)] / _seconds(time_unit, text)
    angle, _, per = "/".join(NAMED_RATES.get(unit, (unit,))).partition("/")
    if angle not in ANGLE_UNITS or per not in SECONDS:
        raise ValueError(
            f"must be a rate: rpm, or an angle ({', '.join(ANGLE_UNITS)}) over a time ({', '.join(SECONDS)}), "
            f"got {_short(text)}."
        )
    return ANGLE_UNITS[angle] * _seconds(time_unit, text) / SECONDS[per]


def _known(unit: str, units: dict[str, float] | dict[str, int], kind: str, text: str) -> str:
    if unit not in units:
        article = "an" if kind == "angle" else "a"
        raise ValueError(f"must be {article} {kind} in {', '.join(units)}, got {_short(text)}.")
    return unit


def _seconds(time_unit: str | None, text: str) -> int:
    if time_unit is None:
        raise ValueError(
            f"must be a number where the file does not say its unit of time, got {_short(text)}. "
            f"Say units.time: {', '.join(SECONDS)}."
        )
    return SECONDS[time_unit]


def _short(text: str) -> str:
    return repr(text) if len(text) <= 40 else repr(text[:37] + "...")
