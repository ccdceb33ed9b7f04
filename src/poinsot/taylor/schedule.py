"""Inner sums of the Taylor coefficients of a decomposition, and the loops that they share.

Order n of a product, a quotient or a function has an inner sum of orders below n, sum_{j=1..n-1} a_j b_{n-j}. The inner
sums of all operations come first, in loops over j that share the rows that they load; the rest of order n has no loops.
"""

from __future__ import annotations

import heapq
import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from poinsot.taylor.decomposition import Decomposition, Function, Operand, Operation, Product, Quotient, Variable

__all__ = ["CoefficientRow", "InnerSum", "Schedule", "varying"]

MAX_SUMS_IN_LOOP = 24
"""Largest number of inner sums in one loop: with their operands they fill 32 registers."""

_Load = tuple[int, "CoefficientRow"]
"""Rows that a loop loads as first operands (0) and as second operands (1)."""

_Option = tuple[int, int, "InnerSum"]
"""Of an inner sum its place, whether its operands change places, and what it is then."""


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
        The rates and, behind them, what is watched.
    places : dict
        The place of an inner sum among all, by its operation and the number of the argument that it is of.
    groups : list of lists of InnerSum
    rows : list of CoefficientRow
        Rows that inner sums read.
    zeros, reciprocals : dict
        The operations of which order 0, or one over it, is needed in higher orders, each with its place among these.
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
        """Return the place of the state variable whose coefficients a row has, if it has one's."""
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
