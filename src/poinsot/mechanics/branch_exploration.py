"""Scalars that stand for others in formulas: duals of duals, and samples that take every branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.dual import Dual
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Environment, Orbit

__all__ = ["BRANCHES", "ExploredEnvironment", "Nested", "opened"]

BRANCHES = 16
"""Samples that take all ways of four conditions."""


class Wrapped(functions.Combining):
    """A scalar that duals take for a plain one; what is computed from it is wrapped again."""

    def __init__(self, inner: Any) -> None:
        self.inner = inner

    def wrapped(self, value: Any) -> Any:
        """Return the result of an operation as a scalar of this kind."""
        return type(self)(value)

    def combined(self, operation: Callable[..., Any], *operands: Any) -> Any:
        """Return what an operation makes of what the operands stand for; a dual or a vector has its own rules."""
        if any(isinstance(operand, Dual | Vector) for operand in operands):
            return NotImplemented
        return self.wrapped(operation(*map(opened, operands)))

    def __bool__(self) -> bool:
        return bool(self.inner)

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function of scalars, this one among them."""
        return self.combined(getattr(functions, name), *arguments)


class Nested(Wrapped):
    """A dual that other duals take for a plain scalar, so that a torque derived from an energy is derived again."""

    @override
    def wrapped(self, value: Any) -> Any:
        return Nested(value) if isinstance(value, Dual) else value


class Explored(Wrapped):
    """Values at samples that take every branch: sixteen of them go all ways of four conditions.

    Parameters
    ----------
    inner : array (..., 16)
    asked : list
        The conditions so far, which all scalars of one evaluation share.
    other : bool
        Whether each sample goes the other way at every condition.
    """

    def __init__(self, inner: Any, asked: list[str], other: bool) -> None:
        super().__init__(inner)
        self._asked, self._other = asked, other

    def wrapped(self, value: Any) -> Any:
        return Explored(value, self._asked, self._other)

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function; of `less` the next pattern of true and false."""
        if name != "less":
            return super().apply(name, arguments)
        if any(isinstance(argument, Dual) for argument in arguments):
            return NotImplemented
        self._asked.append(name)
        bit = (len(self._asked) - 1) % 4
        return (np.arange(BRANCHES) >> bit & 1).astype(bool) != self._other


class ExploredEnvironment(Environment):
    """The environment at sample times, where conditions on time and orbits go every way, whatever the times are.

    Parameters
    ----------
    time : array (16,) or Dual of one
    other : bool
        As of `Explored`.

    Attributes
    ----------
    asked : list
        The conditions that formulas have asked.
    """

    def __init__(self, time: Any, other: bool = False) -> None:
        self.asked: list[str] = []
        self._plain, self._other = Environment(time), other
        super().__init__(self._explored(time))

    @override
    def position(self, orbit: Orbit) -> Vector:
        return Vector(map(self._explored, self._plain.position(orbit)))

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        return Vector(map(self._explored, self._plain.velocity(orbit)))

    @override
    def inverse_distance(self, orbit: Orbit) -> Scalar:
        return self._explored(self._plain.inverse_distance(orbit))

    def _explored(self, scalar: Any) -> Any:
        if isinstance(scalar, Dual):
            return Dual(self._explored(scalar.value), {k: self._explored(p) for k, p in scalar.partials.items()})
        return Explored(scalar, self.asked, self._other)


def opened(scalar: Any) -> Any:
    """Return what a wrapped scalar stands for, or any other scalar unchanged."""
    return scalar.inner if isinstance(scalar, Wrapped) else scalar
