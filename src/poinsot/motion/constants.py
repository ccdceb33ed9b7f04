"""Arithmetic between runtime parameters, done once for a run and not at every step.

A formula that multiplies two parameters, or takes the cosine of one, makes a derived constant. Only the
constants that meet a variable of the motion become parameters of the kernel; their values follow from the
numbers of a system by replaying the arithmetic, for one body or for arrays of members.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import heyoka as hy
import numpy as np

from poinsot import functions
from poinsot.functions import Vector
from poinsot.mechanics.dual import Dual

__all__ = ["Constant", "Constants"]


class Constants:
    """The constants of one kernel."""

    def __init__(self) -> None:
        self._recipes: list[tuple[Callable[..., Any] | None, tuple[Any, ...]]] = []
        self._known: dict[Any, Constant] = {}
        self._parameters: dict[int, Any] = {}

    def inputs(self) -> Iterator[Constant]:
        """Yield one constant after another, for the numbers that a run is given, in order."""
        while True:
            self._recipes.append((None, ()))
            yield Constant(self, len(self._recipes) - 1)

    def derived(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Constant:
        """Return the constant that a function makes of constants and numbers."""
        key = (function, *(a.place if isinstance(a, Constant) else ("number", a) for a in arguments))
        if key not in self._known:
            self._recipes.append((function, arguments))
            self._known[key] = Constant(self, len(self._recipes) - 1)
        return self._known[key]

    def parameter(self, constant: Constant) -> Any:
        """Return the kernel's parameter for a constant that meets a variable."""
        return self._parameters.setdefault(constant.place, hy.par[len(self._parameters)])

    def values(self, numbers: Sequence[Any]) -> list[Any]:
        """Return the values of the kernel's parameters for the numbers of a run, scalars or arrays."""
        known: list[Any] = []
        given = iter(numbers)
        with np.errstate(all="ignore"):  # a constant that is not finite stops the run with a sentence
            for function, arguments in self._recipes:
                values = (known[a.place] if isinstance(a, Constant) else a for a in arguments)
                known.append(next(given) if function is None else function(*values))
        return [known[place] for place in self._parameters]


class Constant:
    """A number of a run; arithmetic with numbers and constants gives constants, with variables expressions."""

    __array_ufunc__ = None

    def __init__(self, home: Constants, place: int) -> None:
        self.home, self.place = home, place

    def _with(self, function: Callable[..., Any], *arguments: Any) -> Any:
        if any(isinstance(a, Vector | Dual) for a in arguments):
            return NotImplemented
        if all(isinstance(a, Constant | int | float) for a in arguments):
            return self.home.derived(function, arguments)
        return function(*(self.home.parameter(a) if isinstance(a, Constant) else a for a in arguments))

    def __add__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with(operator.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with(operator.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return self if _is(other, 0) else self._with(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._with(operator.sub, other, self)

    def __mul__(self, other: Any) -> Any:
        return _product(self, other, self._with)

    def __rmul__(self, other: Any) -> Any:
        return _product(self, other, self._with)

    def __truediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, other, self)

    def __pow__(self, other: Any) -> Any:
        return self._with(operator.pow, self, other)

    def __rpow__(self, other: Any) -> Any:
        return self._with(operator.pow, other, self)

    def __neg__(self) -> Any:
        return self._with(operator.neg, self)

    def __bool__(self) -> bool:
        raise TypeError("a formula must not branch with `if` on a value, but it does.")

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function of scalars, this one among them."""
        return self._with(getattr(functions, name), *arguments)


def _is(value: Any, number: int) -> bool:
    return isinstance(value, int | float) and value == number


def _product(constant: Constant, other: Any, combine: Callable[..., Any]) -> Any:
    if _is(other, 0):
        return 0.0
    return constant if _is(other, 1) else combine(operator.mul, constant, other)
