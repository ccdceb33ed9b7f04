"""Sums of squares that are integrals of the motion, as the norm of a quaternion: each saves the square of a variable.

What does not change with time has no Taylor coefficients but the first, so it costs no product of series. Where N is
x^2 + y^2 + z^2, the form x^2 - y^2 is N - 2 y^2 - z^2. N is what it is as a step begins: none is taken for 1.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from poinsot.taylor.decomposition import Coefficient, Integral, State, Sum
from poinsot.taylor.shared_products import operands_of

__all__ = ["without_squares"]


def without_squares(drafts: Sequence[Any], rates: Sequence[Any]) -> Sequence[Any]:
    """Return drafts with integrals in the place of squares in sums, where that leaves fewer products.

    Parameters
    ----------
    drafts : sequence
        Operations whose operands are coefficients and monomials: the numbers of the drafts that are multiplied.
    rates : sequence of coefficients and monomials
        The time derivatives of the state variables.
    """
    squared = sorted(x[0] for x in _products(drafts) if len(x) == 2 and x[0] == x[1])
    slopes = {k: _slope(k, rates[drafts[k].place], drafts) for k in squared if isinstance(drafts[k], State)}
    for numbers in _integrals(slopes):
        changed = [_without_square(x, numbers, len(drafts)) if isinstance(x, Sum) else x for x in drafts]
        if len(_products(changed)) < len(_products(drafts)):
            drafts = [*changed, Integral(tuple((number,) for number in numbers))]  # type: ignore[misc]
    return drafts


def _products(drafts: Iterable[Any]) -> set[Any]:
    """Return the monomials that have several factors."""
    operands = itertools.chain.from_iterable(map(operands_of, drafts))
    return {x for x in operands if not isinstance(x, Coefficient) and len(x) > 1}


def _terms(draft: Any) -> Sequence[tuple[Coefficient, Any]]:
    return draft.terms  # type: ignore[no-any-return]


def _slope(number: int, rate: Any, drafts: Sequence[Any]) -> Mapping[Any, float]:
    """Return half the time derivative of the square of a variable: numbers by parameters and monomials."""
    total: defaultdict[Any, float] = defaultdict(float)
    for size, factors, x in _written_out(rate, drafts):
        total[tuple(sorted(factors)), tuple(sorted((number, *x)))] += size
    return total


def _written_out(value: Any, drafts: Sequence[Any]) -> list[tuple[Any, list[int], Any]]:
    """Return a value as a sum: numbers, each with parameters and a monomial that it multiplies."""
    if isinstance(value, Coefficient):
        return [(value.number, [] if value.parameter is None else [value.parameter], ())]
    draft = drafts[value[0]]
    if len(value) > 1 or not isinstance(draft, Sum):
        return [(1.0, [], value)]
    whole = [*_terms(draft), *((Coefficient(), constant) for constant in draft.constants)]
    return [
        (number * size, [*own, *factors], x)
        for coefficient, part in whole
        for number, own, _ in _written_out(coefficient, drafts)
        for size, factors, x in _written_out(part, drafts)
    ]


def _integrals(slopes: Mapping[int, Mapping[Any, float]]) -> list[list[int]]:
    """Return the groups of squares whose derivatives have terms in common and cancel."""
    groups: list[tuple[list[int], dict[Any, float]]] = []
    for number, slope in slopes.items():
        numbers, total = [number], dict(slope)
        for group in [group for group in groups if group[1].keys() & slope.keys()]:
            groups.remove(group)
            numbers += group[0]
            total |= {key: size + total.get(key, 0.0) for key, size in group[1].items()}
        groups.append((sorted(numbers), total))
    return [numbers for numbers, total in groups if not any(total.values())]


def _without_square(draft: Any, numbers: Sequence[int], integral: int) -> Any:
    """Return a sum in which an integral less the other squares is in the place of the first square."""
    first, *others = numbers
    found: defaultdict[Any, float] = defaultdict(float)
    for (number, parameter), x in _terms(draft):
        if x != (first, first):
            found[x, parameter] += number
            continue
        found[(integral,), parameter] += number
        for other in others:
            found[(other, other), parameter] -= number
    terms = [(Coefficient(number, parameter), x) for (x, parameter), number in found.items() if number]
    return draft._replace(terms=tuple(sorted(terms, key=lambda term: term[1])))
