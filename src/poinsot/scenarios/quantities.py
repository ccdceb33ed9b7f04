"""Numbers with a unit, written as text: "45 deg", "3 rpm", "8 h"."""

from __future__ import annotations

import re

from poinsot.mechanics.calendar import SECONDS
from poinsot.printable import quoted
from poinsot.quantities import ANGLE_UNITS, NAMED_RATES

__all__ = ["quantity"]

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)\s*(?P<unit>[A-Za-z]+(\s*/\s*[A-Za-z]+)?)\s*"
)


EXAMPLES = {"angle": "'45 deg'", "rate": "'0.1 deg/s'", "time": "'8 h'"}


def quantity(text: str, kind: str, time_unit: str | None) -> float:
    """Return an angle in radians, a rate in radians per unit of time, or a time in units of time.

    A ValueError has the second half of a sentence: what the text must be, and what it is.

    Parameters
    ----------
    text : str
        A number and a unit.
    kind : {"angle", "rate", "time"}
    time_unit : {"s", "min", "h", "d"}, optional
        What the numbers without a unit are counted in.
    """
    given = quoted(text)
    found = _QUANTITY.fullmatch(text) if len(text) < 100 else None
    if found is None:
        raise ValueError(f"must be a number, alone or with a unit such as {EXAMPLES[kind]}, got {given}.")
    unit = "".join(found["unit"].split())
    angle, _, per = "/".join(NAMED_RATES.get(unit, (unit,))).partition("/")
    angles, times = ", ".join(ANGLE_UNITS), ", ".join(SECONDS)
    known = {
        "angle": (unit in ANGLE_UNITS, f"an angle in {angles}"),
        "time": (unit in SECONDS, f"a time in {times}"),
        "rate": (angle in ANGLE_UNITS and per in SECONDS, f"a rate: rpm, or an angle ({angles}) over a time ({times})"),
    }
    is_known, rule = known[kind]
    if not is_known:
        raise ValueError(f"must be {rule}, got {given}.")
    if kind == "angle":
        return float(found["number"]) * ANGLE_UNITS[unit]
    if time_unit is None:
        hint = f"Say units.time: {times}."
        raise ValueError(f"must be a number where the file does not state its unit of time, got {given}. {hint}")
    if kind == "time":
        return float(found["number"]) * (SECONDS[unit] / SECONDS[time_unit])
    return float(found["number"]) * (ANGLE_UNITS[angle] * SECONDS[time_unit] / SECONDS[per])
