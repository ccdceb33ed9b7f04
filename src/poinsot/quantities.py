"""Numbers that carry a unit or a mask: the ones that convert, and the sentences about the others."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

__all__ = ["ANGLES", "plain", "refuse_beyond_a_turn"]

ANGLES = (
    *("inclination", "node", "argument_of_periapsis", "true_anomaly", "mean_anomaly", "eccentric_anomaly"),
    *("euler_angles", "roll_pitch_yaw", "turn", "angle", "angles", "obliquity", "l", "g", "h"),
)
"""Names of arguments in radians, everywhere."""

WITHIN_A_TURN = ("inclination", "obliquity")
"""Angles between two planes, of which more than a turn is a number of degrees."""

DEEPEST = 32
"""The most axes of an array, about."""


def plain(name: str, value: Any, time_unit: str | None = None, depth: int = 0) -> Any:
    """Return a value without its unit, converted where that is known: angles by their names, times by a unit.

    Raises
    ------
    TypeError
        If it has a mask, or a unit that does not convert.
    """
    if isinstance(value, list | tuple) and depth < DEEPEST:
        if {int, float}.issuperset(map(type, value)):
            return value
        return [plain(name, item, time_unit, depth + 1) for item in value]
    kind = type(value)
    if isinstance(value, np.ma.MaskedArray) or hasattr(kind, "unmasked"):
        raise TypeError(
            f"{name} must be plain numbers, got a masked array. Write value.compressed(), or value.filled(number)."
        )
    if hasattr(kind, "to_value") and hasattr(kind, "unit"):
        return _converted(name, value, time_unit)
    if hasattr(kind, "units") and (hasattr(kind, "magnitude") or hasattr(kind, "to_value")):
        raise TypeError(_own_units(name, value.units))
    return value


def _converted(name: str, value: Any, time_unit: str | None) -> Any:
    """Return the numbers of a quantity as astropy has them."""
    unit = "rad" if name.rpartition(".")[2] in ANGLES else time_unit
    if unit is None:
        raise TypeError(_own_units(name, value.unit))
    try:
        return value.to_value(unit)
    except ValueError:  # another kind of unit, or a name that astropy does not know
        rule = "be an angle" if unit == "rad" else "be plain numbers, or times where the unit of time is named"
        hint = "" if unit == "rad" else " System(..., units={'time': 's'}) names it."
        raise TypeError(f"{name} must {rule}, got {_quantity(value.unit)}.{hint}") from None


def _own_units(name: str, unit: Any) -> str:
    hint = "Write value.to_value(unit), with the unit that your other numbers have."
    return f"{name} must be plain numbers in your own units, got {_quantity(unit)}. {hint}"


def _quantity(unit: Any) -> str:
    return f"a quantity in {unit}" if str(unit) else "a dimensionless quantity"


def refuse_beyond_a_turn(name: str, radians: Any) -> None:
    """Refuse an inclination that can only be a number of degrees."""
    wrong = np.ravel(radians)[np.ravel(np.abs(radians)) > 2 * math.pi]
    if name in WITHIN_A_TURN and wrong.size:
        raise ValueError(f"{name} must be within 2 pi, in radians, got {wrong[0]}. Degrees: np.radians({wrong[0]}).")
