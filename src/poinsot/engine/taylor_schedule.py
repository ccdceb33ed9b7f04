"""The order in which Taylor coefficients of a decomposition are computed, for emitters of kernels.

Order n of a product, a quotient or a function has an inner sum of orders below n, sum_{j=1..n-1} a_j b_{n-j}. Those of
all operations come first, in loops over j that share what they load; the rest of order n has no loops.
"""

from __future__ import annotations

import functools
import heapq
import itertools
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from poinsot.engine.decomposition import (
    Coefficient,
    Decomposition,
    Function,
    Integral,
    Operation,
    Product,
    Quotient,
    Select,
    State,
    Sum,
    Time,
)

__all__ = ["HigherOrder", "InnerSum", "Row", "Schedule", "ZerothOrder"]

GROUP = 24
"""How many inner sums one loop has at most: with their operands they fill 32 registers."""

NOTHING = Coefficient(0.0)

_Values = Callable[[Coefficient | int], Any]

_Load = tuple[int, "Row"]
"""What a loop loads: rows as first operands (0) and as second ones (1)."""

_Option = tuple[int, int, "InnerSum"]
"""Of an inner sum its place, whether its operands change places, and what it is then."""


class Row(NamedTuple):
    """Coefficients u_j of an operation that inner sums read, or j u_j."""

    operation: int
    weighted: bool


class InnerSum(NamedTuple):
    """sum_{j=1..n-1} first_j second_{n-j}, at a place among all."""

    place: int
    first: Row
    second: Row


class ZerothOrder(Protocol):
    """What an emitter writes order 0 with.

    Values have the operators + - * / and the methods fma(factor, addend), is_(relation, number) and, of what that
    returns, choose(yes, no).
    """

    def coefficient(self, coefficient: Coefficient) -> Any:
        """Return a number times a parameter, or a number."""

    def state(self, place: int) -> Any:
        """Return the coefficient of a state variable."""

    def time(self) -> Any:
        """Return that of the time."""

    def function(self, function: Function, arguments: Sequence[Any]) -> Any:
        """Return the value of an elementary function."""

    def keep(self, k: int, value: Any) -> None:
        """Store what higher orders need of the coefficient of an operation."""


class HigherOrder(ZerothOrder, Protocol):
    """What it writes an order n > 0 with."""

    def zero(self, operation: int) -> Any:
        """Return order 0 of an operation."""

    def reciprocal(self, operation: int) -> Any:
        """Return one over that."""

    def inner_sum(self, place: int) -> Any:
        """Return an inner sum."""

    def over_order(self, value: Any) -> Any:
        """Return a value over n."""


class Schedule:
    """What is computed of a decomposition, and when; the same for every layout, so that all give the same bits.

    Parameters
    ----------
    decomposition : Decomposition

    Attributes
    ----------
    outputs : tuple of Coefficient or int
        The rates and, behind them, what is watched.
    groups : list of lists of InnerSum
    rows : list of Row
        What inner sums read.
    zeros, reciprocals : sets of int
        The operations of which order 0, or one over it, is needed in higher orders.
    """

    def __init__(self, decomposition: Decomposition) -> None:
        self.operations = decomposition.operations
        self.outputs = (*decomposition.rates, *decomposition.watched)
        self.zeros: set[int] = set()
        self.reciprocals: set[int] = set()
        self._of: dict[tuple[int, int], int] = {}
        sums: list[InnerSum] = []
        for k, operation in enumerate(self.operations):
            for part, (first, second) in self._convolutions(k, operation):
                self._of[k, part] = len(sums)
                sums.append(InnerSum(len(sums), first, second))
        self.sums = len(sums)
        self.rows = list(dict.fromkeys(row for inner in sums for row in (inner.first, inner.second)))
        self.groups = _grouped(sums)

    def state_of(self, row: Row) -> int | None:
        """Return the place of the state variable whose coefficients a row has, if it has one's."""
        operation = self.operations[row.operation]
        return operation.place if isinstance(operation, State) and not row.weighted else None

    def _convolutions(self, k: int, operation: Operation) -> list[tuple[int, tuple[Row, Row]]]:
        """Return the inner sums of an operation, each with the number of the argument that it is of."""
        match operation:
            case Product(first, second):
                self.zeros |= {first, second}
                return [(0, (Row(first, False), Row(second, False)))]
            case Quotient(_, denominator):
                self.zeros.add(k)
                self.reciprocals.add(denominator)
                return [(0, (Row(denominator, False), Row(k, False)))]
            case Function():
                parts = _varying(operation)
                self.zeros |= {slope for _, _, slope in parts if isinstance(slope, int)}
                return [
                    (i, (Row(argument, True), Row(slope, False)))
                    for i, argument, slope in parts
                    if isinstance(slope, int)
                ]
        return []

    def zeroth_order(self, arithmetic: ZerothOrder) -> list[Any]:
        """Write the values of all operations, and return those of the outputs."""
        return self._written(arithmetic, self._at_zero, arithmetic.coefficient)

    def higher_order(self, arithmetic: HigherOrder) -> list[Any]:
        """Write the coefficients of an order n > 0 of all operations, and return those of the outputs."""
        return self._written(arithmetic, self._above, lambda _: arithmetic.coefficient(NOTHING))

    def _written(self, arithmetic: Any, one: Callable[..., Any], constant: Callable[[Coefficient], Any]) -> list[Any]:
        values: list[Any] = []

        def value(of: Coefficient | int) -> Any:
            return values[of] if isinstance(of, int) else constant(of)

        for k, operation in enumerate(self.operations):
            values.append(one(arithmetic, k, operation, value))
            arithmetic.keep(k, values[k])
        return [value(output) for output in self.outputs]

    @staticmethod
    def _at_zero(arithmetic: ZerothOrder, _: int, operation: Operation, value: _Values) -> Any:
        match operation:
            case Sum(terms, constants):
                return _linear(arithmetic, terms, constants, value)
            case Product(first, second):
                return value(first) * value(second)
            case Quotient(numerator, denominator):
                return value(numerator) / value(denominator)
            case Function():
                return arithmetic.function(operation, list(map(value, operation.arguments)))
            case Integral((first, *others)):
                start = value(first) * value(first)
                return functools.reduce(lambda total, root: value(root).fma(value(root), total), others, start)
        return _without_products(arithmetic, operation, value)

    def _above(self, arithmetic: HigherOrder, k: int, operation: Operation, value: _Values) -> Any:
        match operation:
            case Sum(terms, _):
                changing = [(c, x) for c, x in terms if not isinstance(self.operations[x], Integral)]
                return _linear(arithmetic, changing, (), value)
            case Product():
                return self._product(arithmetic, k, operation, value)
            case Quotient():
                return self._quotient(arithmetic, k, operation, value)
            case Function():
                return self._function(arithmetic, k, operation, value)
            case Integral():
                return arithmetic.coefficient(NOTHING)
        return _without_products(arithmetic, operation, value)

    def _product(self, arithmetic: HigherOrder, k: int, product: Product, value: _Values) -> Any:
        inner = arithmetic.inner_sum(self._of[k, 0])
        early, late = sorted(product)  # the last step waits for the operand that is known last
        if early == late:
            return (2.0 * arithmetic.zero(early)).fma(value(early), inner)
        return arithmetic.zero(early).fma(value(late), arithmetic.zero(late).fma(value(early), inner))

    def _quotient(self, arithmetic: HigherOrder, k: int, quotient: Quotient, value: _Values) -> Any:
        below = quotient.denominator
        result = -arithmetic.zero(k).fma(value(below), arithmetic.inner_sum(self._of[k, 0]))
        if isinstance(quotient.numerator, int):
            result = value(quotient.numerator) + result
        return result * arithmetic.reciprocal(below)

    def _function(self, arithmetic: HigherOrder, k: int, function: Function, value: _Values) -> Any:
        inner = [arithmetic.inner_sum(self._of[k, i]) for i in range(len(function.arguments)) if (k, i) in self._of]
        result = arithmetic.over_order(sum(inner[1:], inner[0])) if inner else arithmetic.coefficient(NOTHING)
        for _, argument, slope in _varying(function):
            factor = arithmetic.zero(slope) if isinstance(slope, int) else arithmetic.coefficient(slope)
            result = factor.fma(value(argument), result)
        return result


def _varying(function: Function) -> list[tuple[int, int, Coefficient | int]]:
    """Return the numbers of the arguments that are operations, these and their slopes."""
    pairs = zip(function.arguments, function.slopes, strict=True)
    return [(i, argument, slope) for i, (argument, slope) in enumerate(pairs) if isinstance(argument, int)]


def _without_products(arithmetic: ZerothOrder, operation: Operation, value: _Values) -> Any:
    """Return a state variable, the time, or one of two values."""
    match operation:
        case State(place):
            return arithmetic.state(place)
        case Time():
            return arithmetic.time()
        case Select(condition, first, second):
            absent = arithmetic.coefficient(Coefficient(1.0, condition)).is_("eq", 0.0)
            return absent.choose(value(second), value(first))
    raise TypeError(f"operation must be one with a recurrence, got {operation}.")


def _linear(
    arithmetic: ZerothOrder,
    terms: Sequence[tuple[Coefficient, int]],
    constants: Sequence[Coefficient],
    value: _Values,
) -> Any:
    """Return a linear sum; terms with one factor share it, and what is known last comes last."""
    shared: dict[Coefficient, list[tuple[int, bool]]] = {}
    for coefficient, k in sorted(terms, key=lambda term: term[1]):
        size = coefficient._replace(number=abs(coefficient.number))
        shared.setdefault(size, []).append((k, coefficient.number < 0))
    total = None
    for constant in constants:
        number = arithmetic.coefficient(constant)
        total = number if total is None else total + number
    for size, members in sorted(shared.items(), key=lambda item: item[1][-1]):
        if size == Coefficient(1.0):
            total = _signed(total, members, value)
            continue
        negative = members[0][1]
        inner = _signed(None, [(k, minus != negative) for k, minus in members], value)
        factor = arithmetic.coefficient(size)
        if total is None:
            total = -(factor * inner) if negative else factor * inner
        else:
            total = (-factor if negative else factor).fma(inner, total)
    return arithmetic.coefficient(NOTHING) if total is None else total


def _signed(total: Any, members: Sequence[tuple[int, bool]], value: _Values) -> Any:
    """Return a total and some values more or, where marked, less."""
    if total is None:
        (first, minus), *members = sorted(members, key=lambda member: member[1])
        total = -value(first) if minus else value(first)
    for k, minus in members:
        total = total - value(k) if minus else total + value(k)
    return total


def _grouped(sums: Sequence[InnerSum]) -> list[list[InnerSum]]:
    """Return inner sums in groups that load few rows; either operand may be the first."""
    readers: defaultdict[_Load, list[_Option]] = defaultdict(list)
    for inner in sums:
        for turned, option in enumerate((inner, InnerSum(inner.place, inner.second, inner.first))):
            for load in _loads(option):
                readers[load].append((inner.place, turned, option))
    left = {inner.place: inner for inner in sums}
    groups: list[list[InnerSum]] = []
    count = -(-len(left) // GROUP)
    while left:
        size = -(-len(left) // (count - len(groups)))
        groups.append(_group(left, readers, size))
    return groups


def _group(left: dict[int, InnerSum], readers: Mapping[_Load, Sequence[_Option]], size: int) -> list[InnerSum]:
    """Take so many inner sums of those that are left, each time the one that loads the fewest rows more."""
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
