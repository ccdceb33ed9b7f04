"""Few products of a canonical form: conserved squares, shared factors, and all operations in their final order.

A sum of squares that is an integral of the motion, such as the norm of a quaternion, saves the square of a variable. A
constant of the motion has no Taylor coefficients but the first, so it costs no product of series. If N is
x^2 + y^2 + z^2, the form x^2 - y^2 is N - 2 y^2 - z^2. The kernel computes N when a step begins; it assumes no value.
"""

from __future__ import annotations

import heapq
import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
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
    Variable,
    operands_of,
    products_of,
)

__all__ = ["CommonSubexpressions", "Factoring", "without_squares"]

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


# ---------------------------------------------------------------------- conserved squares

Slope: TypeAlias = Mapping[tuple[tuple[int, ...], Monomial], float | Fraction]
"""A sum of numbers times parameters and a monomial."""


def without_squares(drafts: Sequence[Draft], rates: Sequence[DraftOperand]) -> Sequence[Draft]:
    """Return drafts with invariants in the place of squares in sums, where that leaves fewer products.

    Parameters
    ----------
    drafts : sequence of Draft
    rates : sequence of coefficients and monomials
        The time derivatives of the state variables.
    """
    variables = {k: draft.place for k, draft in enumerate(drafts) if isinstance(draft, Variable)}
    squared = sorted(x[0] for x in products_of(map(operands_of, drafts)) if len(x) == 2 and x[0] == x[1])
    slopes = {k: _slope(k, rates[variables[k]], drafts) for k in squared if k in variables}
    for numbers in _invariants(slopes):
        changed = [_without_square(x, numbers, len(drafts)) if isinstance(x, Sum) else x for x in drafts]
        if len(products_of(map(operands_of, changed))) < len(products_of(map(operands_of, drafts))):
            drafts = [*changed, Invariant(tuple((number,) for number in numbers))]
    return drafts


def _slope(number: int, rate: DraftOperand, drafts: Sequence[Draft]) -> Slope:
    """Return half the time derivative of the square of a variable."""
    total: defaultdict[tuple[tuple[int, ...], Monomial], float | Fraction] = defaultdict(float)
    for size, factors, x in _written_out(rate, drafts):
        total[tuple(sorted(factors)), tuple(sorted((number, *x)))] += size
    return total


def _written_out(value: DraftOperand, drafts: Sequence[Draft]) -> list[tuple[float | Fraction, list[int], Monomial]]:
    """Return a value as a sum: numbers, each with parameters and a monomial that it multiplies."""
    if isinstance(value, Coefficient):
        return [(value.number, [] if value.parameter is None else [value.parameter], ())]
    draft = drafts[value[0]]
    if len(value) > 1 or not isinstance(draft, Sum):
        return [(1.0, [], value)]
    whole: list[tuple[Coefficient, DraftOperand]] = [*draft.terms, *((Coefficient(), x) for x in draft.constants)]
    return [
        (number * size, [*own, *factors], x)
        for coefficient, part in whole
        for number, own, _ in _written_out(coefficient, drafts)
        for size, factors, x in _written_out(part, drafts)
    ]


def _invariants(slopes: Mapping[int, Slope]) -> list[list[int]]:
    """Return the groups of squares whose derivatives have terms in common and cancel."""
    groups: list[tuple[list[int], Slope]] = []
    for number, slope in slopes.items():
        numbers, total = [number], dict(slope)
        for group in [group for group in groups if group[1].keys() & slope.keys()]:
            groups.remove(group)
            numbers += group[0]
            total |= {key: size + total.get(key, 0.0) for key, size in group[1].items()}
        groups.append((sorted(numbers), total))
    return [numbers for numbers, total in groups if not any(total.values())]


def _without_square(draft: Sum[Monomial], numbers: Sequence[int], invariant: int) -> Sum[Monomial]:
    """Return a sum in which an invariant less the other squares is in the place of the first square."""
    first, *others = numbers
    found: defaultdict[tuple[Monomial, int | None], float | Fraction] = defaultdict(float)
    for (number, parameter), x in draft.terms:
        if x != (first, first):
            found[x, parameter] += number
            continue
        found[(invariant,), parameter] += number
        for other in others:
            found[(other, other), parameter] -= number
    terms = [(Coefficient(number, parameter), x) for (x, parameter), number in found.items() if number]
    return draft._replace(terms=tuple(sorted(terms, key=lambda term: term[1])))
