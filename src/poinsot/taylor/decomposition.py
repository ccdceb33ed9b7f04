"""A vector field as elementary operations, each with a recurrence of its Taylor coefficients: what kernels are made of.

A value is a number that stays (`Coefficient`) or the result of an operation, by its number. With u_n the coefficients
of a value, the recurrences are, for n > 0,

    sum         u_n = sum_k c_k (u_k)_n
    product     u_n = sum_{j=0..n} a_j b_{n-j}
    quotient    u_n = (a_n - sum_{j=1..n} b_j u_{n-j}) / b_0
    select      u_n = a_n or b_n
    integral    u_n = 0
    function    n u_n = sum_i sum_{j=1..n} j (a_i)_j (w_i)_{n-j}, as u' = sum_i w_i a_i'

Slopes w_i may come after their function: order n of the function needs order n - 1 of its slopes.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

__all__ = [
    "Coefficient",
    "Crossing",
    "Decomposition",
    "Function",
    "Integral",
    "Momenta",
    "Operation",
    "Product",
    "Quotient",
    "Select",
    "State",
    "Sum",
    "Time",
]


class Coefficient(NamedTuple):
    """A number, a double or an exact fraction, times a parameter of the run, or a number alone."""

    number: float | Fraction = 1.0
    parameter: int | None = None


class State(NamedTuple):
    """A variable of the state vector, by its place."""

    place: int


class Time(NamedTuple):
    """The time."""


class Sum(NamedTuple):
    """A linear sum of values: coefficients times operations, and coefficients alone."""

    terms: tuple[tuple[Coefficient, int], ...]
    constants: tuple[Coefficient, ...] = ()


class Product(NamedTuple):
    """The product of two operations, which may be one: a square."""

    first: int
    second: int


class Quotient(NamedTuple):
    """A coefficient or an operation over an operation."""

    numerator: Coefficient | int
    denominator: int


class Function(NamedTuple):
    """An elementary function by its name in `poinsot.functions`, or "pow".

    The derivative is the sum of slopes times those of the arguments; the slope of an argument that is a coefficient
    is not looked at.
    """

    name: str
    arguments: tuple[Coefficient | int, ...]
    slopes: tuple[Coefficient | int, ...]


class Select(NamedTuple):
    """One of two values: the first where a parameter, which holds a condition, is not zero."""

    condition: int
    first: Coefficient | int
    second: Coefficient | int


class Integral(NamedTuple):
    """The sum of the squares of operations, which does not change along the motion."""

    roots: tuple[int, ...]


class Crossing(NamedTuple):
    """What is done at the zeros of a value that is watched.

    Parameters
    ----------
    direction : {-1, 0, 1}
        Only where the value falls or rises with time; 0: both.
    stops : bool
        Whether the motion stops there, for good or to go on with another state.
    """

    direction: int
    stops: bool


class Momenta(NamedTuple):
    """Momenta that are rescaled by a power of two where their norm leaves a band as a step begins.

    Parameters
    ----------
    places : tuple of int
        Of the state variables whose norm it is.
    scaled : tuple of int
        Of all that go with the scale.
    powers : tuple of int
        To which power of the scale each parameter goes.
    conjugates : tuple of (int, int)
        Where the quaternions and their conjugate momenta begin. Momenta that have shrunk lose q . Q, the rounding of
        larger ones, which changes no motion but would hide those that shrink on.
    """

    places: tuple[int, ...] = ()
    scaled: tuple[int, ...] = ()
    powers: tuple[int, ...] = ()
    conjugates: tuple[tuple[int, int], ...] = ()


NO_MOMENTA = Momenta()

Operation = State | Time | Sum | Product | Quotient | Function | Select | Integral


@dataclass(frozen=True)
class Decomposition:
    """A vector field of states, time and parameters.

    Parameters
    ----------
    operations : tuple of Operation
        Each after its operands, slopes excepted.
    rates : tuple of Coefficient or int
        The time derivatives of the state variables, in their order.
    parameters : int
        How many parameters there are.
    watched : tuple of Coefficient or int
        What is negative where each condition holds, then the values of events.
    conditions : tuple of int
        The parameters that hold these conditions, 1 or 0.
    events : tuple of Crossing
    stops : tuple of int
        The conditions, by number, behind whose switch the motion stops, to go on with other variables.
    attitude : tuple of int
        The state variables that are attitudes.
    momenta : Momenta
        Those that a looped kernel rescales.
    """

    operations: tuple[Operation, ...]
    rates: tuple[Coefficient | int, ...]
    parameters: int
    watched: tuple[Coefficient | int, ...] = ()
    conditions: tuple[int, ...] = ()
    events: tuple[Crossing, ...] = ()
    stops: tuple[int, ...] = ()
    attitude: tuple[int, ...] = ()
    momenta: Momenta = NO_MOMENTA

    @property
    def size(self) -> int:
        """How many operations on one or two operands there are."""
        return sum(
            len(operation.terms) + len(operation.constants) if isinstance(operation, Sum) else 1
            for operation in self.operations
        )
