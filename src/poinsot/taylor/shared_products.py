"""Products of several factors as products of two, and all operations of drafts in their final order."""

from __future__ import annotations

import heapq
import itertools
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from poinsot.taylor.decomposition import Coefficient, Function, Integral, Operation, Product, Quotient, Select, Sum

__all__ = ["Assembly", "Monomial", "common_factors", "operands_of"]

Monomial = tuple[int, ...]
"""A product of operations, by their numbers in order."""

Pair = tuple[Monomial, Monomial]
"""Two factors of a product, in order."""


class Assembly:
    """Operations in their final order, with products in place of monomials."""

    def __init__(self, drafts: Sequence[Any], slopes: Mapping[int, Any]) -> None:
        self._drafts, self._slopes, self._waiting = drafts, slopes, list[int]()
        self._operations: list[Operation] = []
        self._placed: dict[int, int] = {}
        self._known: dict[Any, int] = {}
        operands = itertools.chain(*map(operands_of, drafts), *slopes.values())
        self._ways = common_factors({x for x in operands if not isinstance(x, Coefficient) and len(x) > 1})

    def operations(self) -> tuple[Operation, ...]:
        """Return the operations, with slopes behind their functions."""
        while self._waiting:
            place = self._waiting.pop()
            function = self._operations[place]
            assert isinstance(function, Function)  # noqa: S101
            slopes = self._slopes[int(function.slopes[0])]  # type: ignore[arg-type]
            self._operations[place] = function._replace(slopes=tuple(map(self.value, slopes)))
        return tuple(self._operations)

    def value(self, operand: Any) -> Any:
        """Return a coefficient, or the number of the operation that a monomial is."""
        if isinstance(operand, Coefficient):
            return operand
        return self._place(operand[0]) if len(operand) == 1 else self._product(operand)

    def _product(self, monomial: Monomial) -> int:
        parts = self._ways.get(monomial, (monomial[:-1], monomial[-1:]))
        first, second = sorted(self.value(part) for part in parts)
        return self._append(Product(first, second))

    def _place(self, number: int) -> int:
        if number not in self._placed:
            draft = self._drafts[number]
            place = self._append(_with_operands(draft, self.value))
            self._placed[number] = place
            if isinstance(draft, Function):
                self._waiting.append(place)
        return self._placed[number]

    def _append(self, operation: Operation) -> int:
        key = type(operation), operation  # tuples of two kinds may be equal
        if key not in self._known:
            self._known[key] = len(self._operations)
            self._operations.append(operation)
        return self._known[key]


def operands_of(draft: Any) -> list[Any]:
    """Return the coefficients and monomials that a draft combines."""
    operands: list[Any] = []
    _with_operands(draft, operands.append)
    return operands


def _with_operands(draft: Any, value: Callable[[Any], Any]) -> Operation:
    if isinstance(draft, Sum):
        return draft._replace(terms=tuple((c, value(x)) for c, x in draft.terms))
    if isinstance(draft, Quotient):
        return Quotient(value(draft.numerator), value(draft.denominator))
    if isinstance(draft, Select):
        return Select(draft.condition, value(draft.first), value(draft.second))
    if isinstance(draft, Integral):
        return Integral(tuple(map(value, draft.roots)))
    if isinstance(draft, Function):
        return draft._replace(arguments=tuple(map(value, draft.arguments)))
    operation: Operation = draft
    return operation


def common_factors(monomials: Iterable[Monomial]) -> dict[Monomial, Pair]:
    """Return for each monomial the two that it is the product of: pairs of factors that most have in common first."""
    return _Factoring(monomials).ways


class _Factoring:
    """Monomials as products of parts; the pair of parts that most of them have becomes one part, again and again.

    Which monomials have a pair is kept: to count all pairs anew each time takes the square of their number.

    Attributes
    ----------
    ways : dict
        The two parts of each product so far.
    """

    def __init__(self, monomials: Iterable[Monomial]) -> None:
        self.ways: dict[Monomial, Pair] = {}
        self._parts: dict[Monomial, tuple[Monomial, ...]] = {}
        self._having: defaultdict[Pair, set[Monomial]] = defaultdict(set)
        self._splits: defaultdict[Monomial, set[Pair]] = defaultdict(set)
        self._queue: list[tuple[bool, int, Pair]] = []
        for monomial in monomials:
            self._exchange(monomial, tuple((factor,) for factor in monomial))
        while self._queue:
            *_, pair = best = heapq.heappop(self._queue)
            if self._having[pair] and best == self._order(pair):
                self._join(pair)

    def _order(self, pair: Pair) -> tuple[bool, int, Pair]:
        """Return what is least of the best pair: its product is there anyway, and most have it."""
        return _joined(pair) not in self.ways, -len(self._having[pair]), pair

    def _join(self, pair: Pair) -> None:
        """Make one part of a pair."""
        self._know(pair)
        for monomial in sorted(self._having[pair]):
            rest = list(self._parts[monomial])
            for part in pair:
                rest.remove(part)
            self._exchange(monomial, tuple(sorted([*rest, _joined(pair)])))

    def _exchange(self, monomial: Monomial, parts: tuple[Monomial, ...]) -> None:
        """Give a monomial other parts; one of two is done."""
        before, now = _pairs(self._parts.get(monomial, ())), _pairs(parts)
        for pair in before:
            self._having[pair].discard(monomial)
        for pair in now:
            self._having[pair].add(monomial)
            self._splits[_joined(pair)].add(pair)
        self._parts[monomial] = parts
        self._rank(before | now)
        if len(parts) == 2:
            self._know((parts[0], parts[1]))

    def _know(self, pair: Pair) -> None:
        product = _joined(pair)
        if product not in self.ways:
            self.ways[product] = pair
            self._rank(self._splits[product])

    def _rank(self, pairs: Iterable[Pair]) -> None:
        """Put pairs where they belong now in the order in which they are taken."""
        for pair in pairs:
            if self._having[pair]:
                heapq.heappush(self._queue, self._order(pair))


def _pairs(parts: Sequence[Monomial]) -> set[Pair]:
    """Return the pairs of parts that may be joined."""
    return set(itertools.combinations(parts, 2)) if len(parts) > 2 else set()


def _joined(pair: Pair) -> Monomial:
    return tuple(sorted(pair[0] + pair[1]))
