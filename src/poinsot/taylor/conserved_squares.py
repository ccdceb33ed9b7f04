"""Sums of squares that are integrals of the motion, as the norm of a quaternion: each saves the square of a variable.

A constant of the motion has no Taylor coefficients but the first, so it costs no product of series. If N is
x^2 + y^2 + z^2, the form x^2 - y^2 is N - 2 y^2 - z^2. The kernel computes N when a step begins; it assumes no value.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from poinsot.taylor.decomposition import (
    Coefficient,
    Draft,
    DraftOperand,
    Invariant,
    Monomial,
    Sum,
    Variable,
    operands_of,
    products_of,
)

__all__ = ["without_squares"]


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
