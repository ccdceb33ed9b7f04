"""A vector field as elementary operations, each with a recurrence of its Taylor coefficients: what kernels are made of.

A value is a number that stays (`Coefficient`) or the result of an operation, by its number. With u_n the coefficients
of a value, the recurrences are, for n > 0,

    sum         u_n = sum_k c_k (u_k)_n
    product     u_n = sum_{j=0..n} a_j b_{n-j}
    quotient    u_n = (a_n - sum_{j=1..n} b_j u_{n-j}) / b_0
    select      u_n = a_n or b_n
    invariant   u_n = 0
    function    n u_n = sum_i sum_{j=1..n} j (a_i)_j (w_i)_{n-j}, as u' = sum_i w_i a_i'

Slopes w_i may come after their function: order n of the function needs order n - 1 of its slopes.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Generic, NamedTuple, TypeAlias, TypeVar, cast

__all__ = [
    "Coefficient",
    "Crossing",
    "Decomposition",
    "Draft",
    "Function",
    "Invariant",
    "Momenta",
    "Monomial",
    "Number",
    "Operand",
    "Operation",
    "Product",
    "Quotient",
    "Select",
    "Sum",
    "Time",
    "Variable",
    "magnitude",
]

Factor = TypeVar("Factor")
"""What an operation combines: an operation by its number, or a monomial while a decomposition is made."""


Number: TypeAlias = float | Fraction
"""A double, or an exact fraction."""


def magnitude(number: Number) -> Number:
    """Return the absolute value of a number."""
    return cast(Number, abs(number))


class Coefficient(NamedTuple):
    """A number times a parameter of the run, or a number alone."""

    number: Number = 1.0
    parameter: int | None = None


Operand: TypeAlias = Coefficient | int
"""A constant, or the number of an operation."""

Monomial: TypeAlias = tuple[int, ...]
"""A product of operations, by their numbers in order."""


class Variable(NamedTuple):
    """A variable of the state vector, by its place."""

    place: int


class Time(NamedTuple):
    """The time."""


class Sum(NamedTuple, Generic[Factor]):
    """A linear sum of values: coefficients times operations, and coefficients alone."""

    terms: tuple[tuple[Coefficient, Factor], ...]
    constants: tuple[Coefficient, ...] = ()


class Product(NamedTuple):
    """The product of two operations, which may be one: a square."""

    first: int
    second: int


class Quotient(NamedTuple, Generic[Factor]):
    """A coefficient or an operation over an operation."""

    numerator: Coefficient | Factor
    denominator: Factor


class Function(NamedTuple, Generic[Factor]):
    """An elementary function by its name in `poinsot.functions`, or "pow".

    The derivative is the sum of slopes times those of the arguments; the slope of an argument that is a coefficient
    is not looked at.
    """

    name: str
    arguments: tuple[Coefficient | Factor, ...]
    slopes: tuple[Coefficient | Factor, ...]


class Select(NamedTuple, Generic[Factor]):
    """One of two values: the first where a parameter, which holds a condition, is not zero."""

    condition: int
    first: Coefficient | Factor
    second: Coefficient | Factor


class Invariant(NamedTuple, Generic[Factor]):
    """The sum of the squares of operations, which does not change along the motion."""

    roots: tuple[Factor, ...]


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

Operation: TypeAlias = (
    Variable | Time | Sum[int] | Product | Quotient[int] | Function[int] | Select[int] | Invariant[int]
)

Draft: TypeAlias = (
    Variable | Time | Sum[Monomial] | Quotient[Monomial] | Function[Monomial] | Select[Monomial] | Invariant[Monomial]
)
"""An operation on monomials."""


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
    rates: tuple[Operand, ...]
    parameters: int
    watched: tuple[Operand, ...] = ()
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
