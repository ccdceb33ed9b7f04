"""Units of numbers and axes of vectors, stated by annotations; numbers with a unit or a mask, converted or refused.

`inclination: Angle` declares a parameter of a record or a function: scenario files may then say "45 deg", and a
quantity of astropy becomes radians. A number without a quantity is in units of the user's own. `axis: BodyVector`
declares three components along the body axes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import math
from collections.abc import Callable
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.dimensions import in_order, names_of

__all__ = [
    "ANGLE_UNITS",
    "MAX_AXES",
    "NAMED_RATES",
    "OR_NUMBER",
    "Along",
    "Angle",
    "Angles",
    "AngularVelocities",
    "AngularVelocity",
    "Array",
    "BodyVector",
    "Date",
    "Duration",
    "Inclination",
    "Quantity",
    "Real",
    "Rule",
    "SpaceVector",
    "Time",
    "Times",
    "annotated_with",
    "extras_of",
    "hints_of",
    "plain",
    "quantity_of",
]

Array = NDArray[np.float64]
"""Array of floats, of any shape."""

ANGLE_UNITS = {
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": math.pi / 180,
    "arcmin": math.pi / 10_800,
    "arcsec": math.pi / 648_000,
    "rev": 2 * math.pi,
}
"""Angle units in radians."""

NAMED_RATES = {"rpm": ("rev", "min")}
"""Rates whose names are no quotient."""

MAX_AXES = 32
"""Approximate largest number of axes of an array."""


@dataclasses.dataclass(frozen=True)
class Quantity:
    """Physical quantity of a number. A call with the name and the value of an argument returns the value in radians.

    Attributes
    ----------
    kind : {"angle", "rate", "time", "duration"}
        A rate is an angle over a time; a time may be given as a date, a duration not.
    largest : float
        The size of an angle beyond which it can only be a number of degrees.
    """

    kind: str
    largest: float = math.inf

    @property
    def converts(self) -> bool:
        """True if a call changes the value."""
        return self.kind == "angle"

    def __call__(self, name: str, value: Any) -> Any:
        """Return an angle without its unit, in radians; any other value unchanged."""
        if not self.converts:
            return value
        value = plain(name, value, "rad")
        if math.isfinite(self.largest):
            self._refuse_degrees(name, value)
        return value

    def _refuse_degrees(self, name: str, value: Any) -> None:
        angles = np.empty(0)
        with contextlib.suppress(Exception):  # no numbers: refused where they are used
            angles = np.ravel(np.asarray(value, dtype=float))
        wrong = angles[np.isfinite(angles) & (np.abs(angles) > self.largest)]
        if wrong.size:
            hint = f"Degrees: np.radians({wrong[0]})."
            raise ValueError(f"{name} must be within 2 pi, in radians, got {wrong[0]}. {hint}")


@dataclasses.dataclass(frozen=True)
class Along:
    """The axes along which the components of a vector are, by their name."""

    axes: str


OR_NUMBER = "or a number"
"""Metadata next to the shape of an array, for which the user may give one number."""


@dataclasses.dataclass(frozen=True)
class Rule:
    """Condition on the values of a field: a function that raises an error, and the remedy that ends its message."""

    refuse: Callable[[str, Any, str], None]
    hint: str = ""

    def check(self, name: str, value: Any) -> None:
        """Raise a ValueError if a value is another."""
        self.refuse(name, value, self.hint)


_ANGLE, _RATE, _TIME = Quantity("angle"), Quantity("rate"), Quantity("time")

Real = Annotated[float | NDArray[Any], ()]
"""A number, or an array of one for each member."""
BodyVector = Annotated[Any, (3,), Along("body axes")]
SpaceVector = Annotated[Any, (3,), Along("space axes")]
"""Three components, or rows of three for each member."""
Angle = Annotated[float | NDArray[Any], _ANGLE]
Angles = Annotated[ArrayLike, _ANGLE]
Inclination = Annotated[float | NDArray[Any], Quantity("angle", 2 * math.pi)]
"""An angle between two planes."""
AngularVelocity = Annotated[float | NDArray[Any], _RATE]
AngularVelocities = Annotated[ArrayLike, _RATE]
Time = Annotated[float | NDArray[Any], _TIME]
Times = Annotated[ArrayLike, _TIME]
Date = Annotated[Any, _TIME]
"""A time, or what a calendar makes one."""
Duration = Annotated[float | NDArray[Any], Quantity("duration")]


def extras_of(hint: Any) -> tuple[Any, ...]:
    """Return the metadata of `Annotated`, also of one of several alternatives."""
    if get_origin(hint) is Annotated:
        return get_args(hint)[1:]
    alternatives = get_args(hint) if get_origin(hint) in (Union, UnionType) else ()
    return tuple(extra for one in alternatives for extra in extras_of(one))


def quantity_of(hint: Any) -> Quantity | None:
    """Return the quantity of an annotated number; None if it is in the units of the user."""
    return next((extra for extra in extras_of(hint) if isinstance(extra, Quantity)), None)


def annotated_with(cls: Any, kind: Any) -> dict[str, Any]:
    """Return the metadata of a kind (`Quantity`, `Along`, `Rule`) of the fields of a record, by field name."""
    return _annotated_with(cls, kind)


@functools.cache
def _annotated_with(cls: type, kind: Any) -> dict[str, Any]:
    hints = hints_of(cls).items()
    return {name: extra for name, hint in hints for extra in extras_of(hint) if isinstance(extra, kind)}


def hints_of(cls: type) -> dict[str, Any]:
    """Return the annotations of a record, stored with its class.

    A class of a script takes them to another process, which does not know the names in them.
    """
    if "_hints" not in vars(cls):
        cls._hints = get_type_hints(cls, include_extras=True)  # type: ignore[attr-defined]
    hints: dict[str, Any] = vars(cls)["_hints"]
    return hints


def plain(name: str, value: Any, unit: str | None = None, depth: int = 0) -> Any:
    """Return a value without its unit, converted to the unit that is meant, if one is.

    The axes of an array with named dimensions are in the order members, times, components.

    Raises
    ------
    TypeError
        If it has a mask, or a unit that does not convert.
    ValueError
        If names of dimensions do not determine their order.
    """
    if isinstance(value, list | tuple) and depth < MAX_AXES:
        if {int, float}.issuperset(map(type, value)):
            return value
        return [plain(name, item, unit, depth + 1) for item in value]
    kind = type(value)
    if kind is np.ndarray:
        return value
    if hasattr(kind, "harden_mask") or (hasattr(kind, "unmasked") and not hasattr(kind, "jd1")):  # NumPy, no Time
        raise TypeError(
            f"{name} must be plain numbers, got a masked array. Write value.compressed(), or value.filled(number)."
        )
    if hasattr(kind, "to_value") and hasattr(kind, "unit"):
        return _converted(name, value, unit)
    if hasattr(kind, "units") and (hasattr(kind, "magnitude") or hasattr(kind, "to_value")):
        raise TypeError(_own_units(name, value.units))
    names = names_of(value)
    return value if names is None else in_order(name, value, names)


def _converted(name: str, value: Any, unit: str | None) -> Any:
    """Return the numbers of a quantity as astropy has them."""
    if unit is None:
        raise TypeError(_own_units(name, value.unit))
    try:
        return value.to_value(unit)
    except ValueError:  # another kind of unit, or a name that astropy does not know
        if unit == "rad":
            raise TypeError(f"{name} must be an angle, got {_quantity(value.unit)}.") from None
        if unit == "1":
            hint = "System(..., units={'time': 's'}) names it."
            raise TypeError(
                f"{name} must be plain numbers, or times where the unit of time is named, got {_quantity(value.unit)}. "
                f"{hint}"
            ) from None
        raise TypeError(
            f"{name} must convert to {unit}, the unit of the system, got {_quantity(value.unit)}."
        ) from None


def _own_units(name: str, unit: Any) -> str:
    hint = "Write value.to_value(unit), with the unit that your other numbers have."
    return f"{name} must be plain numbers in your own units, got {_quantity(unit)}. {hint}"


def _quantity(unit: Any) -> str:
    return f"a quantity in {unit}" if str(unit) else "a dimensionless quantity"
