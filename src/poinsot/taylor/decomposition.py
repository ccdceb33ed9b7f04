"""Vector fields as elementary operations, each with a recurrence of its Taylor coefficients.

A value is a number that stays (`Coefficient`) or the result of an operation, by its number. With u_n the coefficients
of a value, the recurrences are, for n > 0,

    sum         u_n = sum_k c_k (u_k)_n
    product     u_n = sum_{j=0..n} a_j b_{n-j}
    quotient    u_n = (a_n - sum_{j=1..n} b_j u_{n-j}) / b_0
    select      u_n = a_n or b_n
    invariant   u_n = 0
    function    n u_n = sum_i sum_{j=1..n} j (a_i)_j (w_i)_{n-j}, as u' = sum_i w_i a_i'

Slopes w_i may come after their function: order n of the function needs order n - 1 of its slopes.

The inner sums of a product, a quotient or a function are sums of orders below n, sum_{j=1..n-1} a_j b_{n-j}. The inner
sums of all operations come first, in loops over j that share the rows that they load; the rest of order n has no loops.
"""

from __future__ import annotations

import heapq
import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Generic, NamedTuple, TypeAlias, TypeVar, cast

__all__ = [
    "Coefficient",
    "CoefficientRow",
    "Crossing",
    "Decomposition",
    "Draft",
    "DraftOperand",
    "Function",
    "InnerSum",
    "Invariant",
    "Momenta",
    "Monomial",
    "Number",
    "Operand",
    "Operation",
    "Product",
    "Quotient",
    "Schedule",
    "Select",
    "Sum",
    "Time",
    "Variable",
    "magnitude",
    "operands_of",
    "products_of",
    "varying",
]

Factor = TypeVar("Factor")
"""Operand of an operation: the number of an operation, or a monomial while a decomposition is made."""


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

    The derivative is the sum of slopes times derivatives of arguments. The slope of a coefficient has no effect.
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
    """Zeros of the value of an event that the kernel records.

    Parameters
    ----------
    direction : {-1, 0, 1}
        -1 for zeros where the value falls with time, 1 for zeros where it rises; 0 for both.
    stops : bool
        True if the motion stops at a zero, at its end or to continue with another state.
    """

    direction: int
    stops: bool


class Momenta(NamedTuple):
    """Momenta that are rescaled by a power of two where their norm leaves a band as a step begins.

    Parameters
    ----------
    places : tuple of int
        Places of the state variables in the norm.
    scaled : tuple of int
        Places of all state variables that are proportional to the scale.
    powers : tuple of int
        The power of the scale in each parameter.
    conjugates : tuple of (int, int)
        First places of the quaternions and of their conjugate momenta. Momenta that have shrunk lose q . Q, the
        rounding error of larger momenta, which changes no motion but would hide a further decrease.
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

DraftOperand: TypeAlias = Coefficient | Monomial
"""A coefficient, or the numbers of drafts that are multiplied."""


def operands_of(draft: Draft) -> tuple[DraftOperand, ...]:
    """Return the coefficients and monomials that a draft combines."""
    match draft:
        case Sum(terms):
            return tuple([x for _, x in terms])
        case Quotient() | Select():
            return draft[-2:]
        case Invariant(roots):
            return roots
        case Function(_, arguments):
            return arguments
    return ()


def products_of(operands: Iterable[Sequence[DraftOperand]]) -> set[Monomial]:
    """Return the monomials with several factors among operands."""
    return {x for x in itertools.chain(*operands) if not isinstance(x, Coefficient) and len(x) > 1}


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
        Number of parameters.
    watched : tuple of Coefficient or int
        A function for each condition, negative where the condition holds, then the values of events.
    conditions : tuple of int
        The parameters that hold these conditions, 1 or 0.
    events : tuple of Crossing
    stops : tuple of int
        Numbers of the conditions at whose switch the motion stops, to continue with other variables.
    attitude : tuple of int
        The state variables that are attitudes.
    momenta : Momenta
        Momenta that the kernel rescales.
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
        """Number of operations on one or two operands."""
        return sum(
            len(operation.terms) + len(operation.constants) if isinstance(operation, Sum) else 1
            for operation in self.operations
        )


# ---------------------------------------------------------------------- inner sums

MAX_SUMS_IN_LOOP = 24
"""Largest number of inner sums in one loop: with their operands they fill 32 registers."""

_Load = tuple[int, "CoefficientRow"]
"""Rows that a loop loads as first operands (0) and as second operands (1)."""

_Option = tuple[int, int, "InnerSum"]
"""Place of an inner sum, 1 if its operands change places, and the sum with these operands."""


class CoefficientRow(NamedTuple):
    """Coefficients u_j of an operation that inner sums read, or j u_j."""

    operation: int
    weighted: bool


class InnerSum(NamedTuple):
    """sum_{j=1..n-1} first_j second_{n-j}, at a place among all."""

    place: int
    first: CoefficientRow
    second: CoefficientRow


class Schedule:
    """Order of the computations of a decomposition: the same for every layout, so that all give the same bits.

    Attributes
    ----------
    outputs : tuple of Coefficient or int
        The rates, then the watched functions.
    places : dict
        The place of an inner sum among all, by its operation and the number of the argument that it is of.
    groups : list of lists of InnerSum
    rows : list of CoefficientRow
        Rows that inner sums read.
    zeros, reciprocals : dict
        Operations whose order 0, or its reciprocal, enters higher orders, each with its place among these.
    """

    def __init__(self, decomposition: Decomposition) -> None:
        self.operations = decomposition.operations
        self.outputs = (*decomposition.rates, *decomposition.watched)
        self.places: dict[tuple[int, int], int] = {}
        sums = list[InnerSum]()
        for k, operation in enumerate(self.operations):
            for part, first, second in _convolutions(k, operation):
                self.places[k, part] = len(sums)
                sums.append(InnerSum(len(sums), first, second))
        self.sums = len(sums)
        self.rows = list(dict.fromkeys(row for inner in sums for row in (inner.first, inner.second)))
        self.zeros = _numbered(row.operation for row in self.rows if not row.weighted)
        self.reciprocals = _numbered(x.denominator for x in self.operations if isinstance(x, Quotient))
        self.groups = _grouped(sums)

    def state_of(self, row: CoefficientRow) -> int | None:
        """Return the place of the state variable whose coefficients a row contains, None for other operations."""
        operation = self.operations[row.operation]
        return operation.place if isinstance(operation, Variable) and not row.weighted else None


def _convolutions(k: int, operation: Operation) -> list[tuple[int, CoefficientRow, CoefficientRow]]:
    """Return the inner sums of an operation, each with the number of the argument that it is of."""
    match operation:
        case Product(first, second):
            return [(0, CoefficientRow(first, False), CoefficientRow(second, False))]
        case Quotient(_, denominator):
            return [(0, CoefficientRow(denominator, False), CoefficientRow(k, False))]
        case Function():
            own = varying(operation.arguments, operation.slopes)
            return [
                (i, CoefficientRow(argument, True), CoefficientRow(slope, False))
                for i, argument, slope in own
                if isinstance(slope, int)
            ]
    return []


def _numbered(operations: Iterable[int]) -> dict[int, int]:
    return {k: place for place, k in enumerate(sorted(set(operations)))}


def varying(arguments: Sequence[Operand], slopes: Sequence[Operand]) -> list[tuple[int, int, Operand]]:
    """Return the numbers of the arguments of a function that are operations, these and their slopes."""
    pairs = zip(arguments, slopes, strict=True)
    return [(i, argument, slope) for i, (argument, slope) in enumerate(pairs) if isinstance(argument, int)]


def _grouped(sums: Sequence[InnerSum]) -> list[list[InnerSum]]:
    """Return inner sums in groups that load few rows; either operand may be the first."""
    readers: defaultdict[_Load, list[_Option]] = defaultdict(list)
    for inner in sums:
        for turned, option in enumerate((inner, InnerSum(inner.place, inner.second, inner.first))):
            for load in _loads(option):
                readers[load].append((inner.place, turned, option))
    left = {inner.place: inner for inner in sums}
    groups: list[list[InnerSum]] = []
    count = -(-len(left) // MAX_SUMS_IN_LOOP)
    while left:
        size = -(-len(left) // (count - len(groups)))
        groups.append(_group(left, readers, size))
    return groups


def _group(left: dict[int, InnerSum], readers: Mapping[_Load, Sequence[_Option]], size: int) -> list[InnerSum]:
    """Take a number of the remaining inner sums, each time the sum that loads the fewest further rows."""
    group, loaded, waiting = list[InnerSum](), set[_Load](), list[tuple[int, _Option]]()
    while len(group) < size:
        best = heapq.heappop(waiting)[1][-1] if waiting else next(iter(left.values()))
        if best.place not in left:  # it was taken for less
            continue
        del left[best.place]
        group.append(best)
        new = {*_loads(best)} - loaded
        loaded |= new
        for option in itertools.chain.from_iterable(map(readers.__getitem__, new)):
            heapq.heappush(waiting, (len({*_loads(option[-1])} - loaded), option))
    return group


def _loads(inner: InnerSum) -> tuple[_Load, _Load]:
    return (0, inner.first), (1, inner.second)
