"""Products of several factors as products of two, and all operations of a canonical form in their final order."""

from __future__ import annotations

import heapq
import itertools
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import TypeAlias

from poinsot.taylor.canonical_form import CanonicalForm
from poinsot.taylor.decomposition import (
    Coefficient,
    Draft,
    DraftOperand,
    Function,
    Invariant,
    Monomial,
    Operand,
    Operation,
    Product,
    Quotient,
    Select,
    Sum,
    operands_of,
    products_of,
)

__all__ = ["CommonSubexpressions", "Factoring"]

Pair: TypeAlias = tuple[Monomial, Monomial]
"""Two factors of a product, in order."""


class CommonSubexpressions:
    """Operations in their final order, with products of two in place of monomials; equal ones are one operation."""

    def __init__(self, drafts: Sequence[Draft], form: CanonicalForm) -> None:
        self._drafts, self._form, self._waiting = drafts, form, list[tuple[int, Function[int], int]]()
        self._operations: list[Operation] = []
        self._placed: dict[int, int] = {}
        self._known: dict[tuple[type, Operation], int] = {}
        self._ways = Factoring(products_of([*map(operands_of, drafts), *form.slopes.values()])).ways

    def operations(self) -> tuple[Operation, ...]:
        """Return the operations, with slopes behind their functions."""
        while self._waiting:
            place, function, number = self._waiting.pop()
            slopes = tuple(map(self.value, self._form.slopes[self._form.functions[number]]))
            self._operations[place] = function._replace(slopes=slopes)
        return tuple(self._operations)

    def value(self, operand: DraftOperand) -> Operand:
        """Return a coefficient, or the number of the operation that computes a monomial."""
        return operand if isinstance(operand, Coefficient) else self._place(operand)

    def _place(self, monomial: Monomial) -> int:
        if len(monomial) == 1:
            (number,) = monomial
            if number not in self._placed:
                self._placed[number] = self._placed_draft(number)
            return self._placed[number]
        first, second = sorted(map(self._place, self._ways.get(monomial, (monomial[:-1], monomial[-1:]))))
        return self._append(Product(first, second))

    def _placed_draft(self, number: int) -> int:
        match self._drafts[number]:
            case Sum(terms, constants):
                return self._append(Sum(tuple([(c, self._place(x)) for c, x in terms]), constants))
            case Quotient(numerator, denominator):
                return self._append(Quotient(self.value(numerator), self._place(denominator)))
            case Select(condition, first, second):
                return self._append(Select(condition, self.value(first), self.value(second)))
            case Invariant(roots):
                return self._append(Invariant(tuple(map(self._place, roots))))
            case Function(name, arguments):
                function = Function(name, tuple(map(self.value, arguments)), ())
                place = len(self._operations)
                self._operations.append(function)
                self._waiting.append((place, function, number))
                return place
            case operation:
                return self._append(operation)

    def _append(self, operation: Operation) -> int:
        key = type(operation), operation  # tuples of two kinds may be equal
        if key not in self._known:
            self._known[key] = len(self._operations)
            self._operations.append(operation)
        return self._known[key]


class Factoring:
    """Monomials as products of parts; the pair of parts that most monomials contain becomes one part, repeatedly.

    The monomials of each pair are stored, since counting all pairs each time takes the square of their number.

    Attributes
    ----------
    ways : dict
        For each product the two parts that it is the product of.
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
        """Return a key, least for the best pair: a pair of a known product, then of the most monomials."""
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
        """Put pairs into the queue at their present ranks."""
        for pair in pairs:
            if self._having[pair]:
                heapq.heappush(self._queue, self._order(pair))


def _pairs(parts: Sequence[Monomial]) -> set[Pair]:
    """Return the pairs of parts that may be joined."""
    return set(itertools.combinations(parts, 2)) if len(parts) > 2 else set()


def _joined(pair: Pair) -> Monomial:
    return tuple(sorted(pair[0] + pair[1]))
