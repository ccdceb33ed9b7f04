"""Formulas as linear forms of monomials: drafts of the operations of a decomposition.

What depends on inputs of the run alone becomes a parameter where it meets a variable. Numbers and constants are taken
out of products, so that 2 (3 (a x)) costs one operation; sums that are used once are part of the sum that uses them.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from poinsot.taylor.decomposition import Coefficient, Function, Quotient, Select, State, Sum, Time
from poinsot.taylor.graph import HELD, Node, ordered, partials
from poinsot.taylor.shared_products import Monomial

__all__ = ["TIME", "Drafts"]

TIME = "time"
"""The name of the symbol of the time; a variable of the state vector is named by its place."""

DraftSum: Any = Sum
DraftQuotient: Any = Quotient
"""With monomials for operands."""


class Linear(NamedTuple):
    """A sum of coefficients, numbers or constants, times monomials, and of a constant."""

    terms: dict[Monomial, Any]
    constant: Any = 0.0


class Drafts:
    """Operations whose operands are monomials, in the place of formulas.

    Parameters
    ----------
    groups : sequence of sequences of scalars
        The formulas.

    Attributes
    ----------
    outputs : list of lists
        Their values: coefficients and monomials, the numbers of drafts that are multiplied.
    drafts : list
    slopes : dict
        Those of functions, by the number that these have in the place of their slopes.
    constants : list of Node
        The parameters.
    conditions : dict
        The place of a condition in the graph to the parameter that holds it.
    roots : list
        Of each square root its argument, the value of that and the parameter that is added to it.
    """

    def __init__(self, groups: Sequence[Sequence[Any]]) -> None:
        self.drafts: list[Any] = []
        self.constants: list[Node] = []
        self.conditions: dict[int, int] = {}
        self._known: dict[Any, int] = {}
        self._parameters: dict[int, int] = {}
        self._linear: dict[int, Linear] = {}
        self._scaled: dict[int, tuple[Node, Monomial]] = {}
        self._slopes: dict[int, tuple[Any, ...]] = {}
        self._roots: list[tuple[Node, int]] = []
        nodes = self._with_slopes(groups)
        self._uses = Counter(x.place for node in nodes for x in node.nodes)
        self._divides = Counter(x.place for node in nodes if node.name == "div" for x in node.nodes[-1:])
        for slopes in self._slopes.values():
            self._uses.update(x.place for x in slopes if isinstance(x, Node))
        self.outputs = [[self._output(output) for output in group] for group in groups]
        for node, _ in self._roots:
            self._value(node.operands[0])
        self.slopes: dict[int, Any] = {place: tuple(map(self._value, each)) for place, each in self._slopes.items()}
        self.roots = [(node.operands[0], self._value(node.operands[0]), held) for node, held in self._roots]

    def _with_slopes(self, groups: Iterable[Iterable[Any]]) -> list[Node]:
        """Return the nodes of the outputs with those of the slopes of their functions."""
        wanted, count = [*itertools.chain(*groups)], -1
        while count != len(wanted):
            count = len(wanted)
            for node in ordered(wanted):
                if node.varies and node.name not in PLAIN and node.place not in self._slopes:
                    slopes = zip(partials(node), node.operands, strict=True)
                    self._slopes[node.place] = own = tuple(s if _varies(x) else 0.0 for s, x in slopes)
                    wanted += own
        return ordered(wanted)

    # ------------------------------------------------------------------ linear forms

    def _form(self, scalar: Any) -> Linear:
        """Return a scalar as a linear form; what is used elsewhere too is one operation in it."""
        if not _varies(scalar):
            return Linear({}, scalar)
        form = self._linear.get(scalar.place)
        if form is None:
            form = self._linear[scalar.place] = self._new_form(scalar)
        several = len(form.terms) > 1 or (form.terms and not _is_zero(form.constant))
        if several and self._uses[scalar.place] > 1:
            form = self._linear[scalar.place] = self._single(form)
        return form

    def _new_form(self, node: Node) -> Linear:
        make = getattr(self, f"_form_of_{node.name}", None)
        if make is not None:
            form: Linear = make(*node.operands)
            return form
        return self._drafted(self._function(node))

    def _form_of_symbol(self, name: Any) -> Linear:
        return self._drafted(Time() if name == TIME else State(name))

    def _form_of_add(self, a: Any, b: Any) -> Linear:
        total = _sum(self._form(a), self._form(b))
        plain = {x: self._without_constants(x) for x in total.terms}
        twice = {x for x, count in Counter(y for y, _ in plain.values()).items() if count > 1}
        apart = Linear({x: c for x, c in total.terms.items() if plain[x][0] not in twice}, total.constant)
        for x, c in total.terms.items():
            y, constant = plain[x]
            if y in twice:  # a (c b) and (d a) b are (c + d) (a b)
                apart = _sum(apart, Linear({y: _times(c, constant)}))
        return apart

    def _without_constants(self, monomial: Monomial) -> tuple[Monomial, Any]:
        """Return a product without the constants that were multiplied into its factors, and these."""
        constant, factors = None, list[int]()
        for place in monomial:
            own, factor = self._scaled.get(place, (None, (place,)))
            constant = _times(constant, own)
            factors += factor
        return tuple(sorted(factors)), constant

    def _form_of_neg(self, a: Any) -> Linear:
        return _scaled(self._form(a), -1)

    def _form_of_mul(self, a: Any, b: Any) -> Linear:
        forms = self._form(a), self._form(b)
        for one, other in (forms, forms[::-1]):
            if not one.terms:  # also where all terms cancel
                return _scaled(other, one.constant)
        (m, x), (n, y) = self._factors(a), self._factors(b)
        m, x, n = self._multiplied_in(m, x, n)
        n, y, m = self._multiplied_in(n, y, m)
        return Linear({tuple(sorted(x + y)): _times(m, n)})

    def _multiplied_in(self, m: Any, x: Monomial, n: Any) -> tuple[Any, Monomial, Any]:
        """Multiply a constant into its one factor where the other one has none: other products may use that."""
        if not isinstance(m, Node) or isinstance(n, Node) or len(x) > 1:
            return m, x, n
        sign, parameter = self._coefficient(m)
        ((y, _),) = self._drafted(DraftSum(((Coefficient(1.0, parameter), x),))).terms.items()
        self._scaled[y[0]] = _times(sign, m), x
        return sign, y, n

    def _form_of_div(self, a: Any, b: Any) -> Linear:
        form, divisor = self._form(a), self._form(b)
        if not divisor.terms:
            return _scaled(form, _reciprocal(divisor.constant))
        n, y = self._factors(b)
        if self._divides[b.place] == 1 and form.terms:
            m, x = self._factors(a)
            return _scaled(self._drafted(DraftQuotient(x, y)), _times(m, _reciprocal(n)))
        return _scaled(_times_form(form, self._drafted(DraftQuotient(Coefficient(), y))), _reciprocal(n))

    def _form_of_ruled(self, value: Any, *_: Any) -> Linear:
        return self._form(value)

    def _form_of_where(self, condition: Any, a: Any, b: Any) -> Linear:
        if condition.varies:
            held = self._parameter(condition.graph.node(HELD, (condition.place,), False))
            self.conditions[condition.place] = held
        else:
            held = self._parameter(condition)
        return self._drafted(Select(held, self._value(a), self._value(b)))

    def _function(self, node: Node) -> Function:
        arguments = [self._value(x) for x in node.operands]
        if node.name == "sqrt":
            held = node.graph.node(HELD, (node.place,), False)
            self._roots.append((node, self._parameter(held)))
            arguments = [self._value(node.operands[0] + held)]
        return Function(node.name, tuple(arguments), (node.place,))

    # ------------------------------------------------------------------ operations

    def _drafted(self, operation: Any) -> Linear:
        key = type(operation), operation  # tuples of two kinds may be equal
        if key not in self._known:
            self._known[key] = len(self.drafts)
            self.drafts.append(operation)
        return Linear({(self._known[key],): 1.0})

    def _coefficient(self, scalar: Any) -> Coefficient:
        if not isinstance(scalar, Node):
            return Coefficient(scalar)
        number, constant = _split(scalar)
        return Coefficient(math.copysign(1.0, number), self._parameter(_times(abs(number), constant)))

    def _parameter(self, constant: Node) -> int:
        if constant.place not in self._parameters:
            self._parameters[constant.place] = len(self.constants)
            self.constants.append(constant)
        return self._parameters[constant.place]

    def _single(self, form: Linear) -> Linear:
        """Return a form with one term: a coefficient that all terms share, times their sum."""
        splits = [_split(c) for c in form.terms.values()]
        number, constant = splits[0]
        if not _is_zero(form.constant) or len({_size(split) for split in splits}) > 1:
            leading = number if _is_zero(form.constant) else _split(form.constant)[0]
            factor = math.copysign(1.0, leading)
            return _scaled(self._drafted(self._draft_of(_scaled(form, factor))), factor)
        signs = {x: math.copysign(1.0, n / number) for x, (n, _) in zip(form.terms, splits, strict=True)}
        return _scaled(self._drafted(self._draft_of(Linear(signs))), _times(number, constant))

    def _draft_of(self, form: Linear) -> Any:
        terms = tuple((self._coefficient(c), x) for x, c in sorted(form.terms.items()))
        return DraftSum(terms, () if _is_zero(form.constant) else (self._coefficient(form.constant),))

    def _factors(self, scalar: Any) -> tuple[Any, Monomial]:
        """Return a coefficient and a monomial."""
        form = self._form(scalar)
        if len(form.terms) != 1 or not _is_zero(form.constant):
            form = self._single(form)
        ((monomial, coefficient),) = form.terms.items()
        return coefficient, monomial

    def _value(self, scalar: Any) -> Any:
        """Return a scalar as an operand: a coefficient or a monomial."""
        return self._value_of(self._form(scalar))

    def _value_of(self, form: Linear) -> Any:
        if not form.terms:
            return self._coefficient(form.constant)
        draft = self._draft_of(form)
        if not draft.constants and draft.terms[0][0] == Coefficient() and len(draft.terms) == 1:
            return draft.terms[0][1]
        (monomial,) = self._drafted(draft).terms
        return monomial

    def _output(self, scalar: Any) -> Any:
        form = self._form(scalar)
        sizes = {_size(_split(c)) for c in form.terms.values()}
        if len(form.terms) > 1 and len(sizes) == 1 and sizes != {UNIT} and _is_zero(form.constant):
            form = self._single(form)
        return self._value_of(form)


PLAIN = ("symbol", "ruled", "add", "neg", "mul", "div", "where", "less")
"""Operations that are no elementary functions."""


# ---------------------------------------------------------------------- coefficients: numbers or constants

UNIT = (1.0, None)
"""The size of the coefficient 1."""


def _varies(scalar: Any) -> bool:
    return isinstance(scalar, Node) and scalar.varies


def _is_zero(scalar: Any) -> bool:
    return isinstance(scalar, Real) and scalar == 0


def _split(scalar: Any) -> tuple[Any, Node | None]:
    """Return the number in a coefficient, and the constant that it multiplies."""
    if not isinstance(scalar, Node):
        return scalar, None
    if scalar.name == "neg":
        number, constant = _split(scalar.operands[0])
        return -number, constant
    if scalar.name == "mul" and isinstance(scalar.operands[0], Real):
        number, constant = scalar.operands
        return number, constant
    return 1.0, scalar


def _size(split: tuple[Any, Node | None]) -> tuple[Any, int | None]:
    number, constant = split
    return abs(number), None if constant is None else constant.place


def _times(a: Any, b: Any) -> Any:
    """Return the product of two coefficients; None stands for 1. A divisor that is a number divides a constant."""
    if a is None or b is None:
        return b if a is None else a
    for number, constant in ((a, b), (b, a)):
        if isinstance(constant, Node) and isinstance(number, Fraction):
            divisor = _number(1 / number)
            return constant / divisor if isinstance(divisor, float) else number * constant
    return _combined(operator.mul, a, b)


def _reciprocal(scalar: Any) -> Any:
    if isinstance(scalar, Node):
        return 1.0 / scalar
    if not scalar or not math.isfinite(scalar):
        return float(np.divide(1.0, scalar))
    return _number(1 / Fraction(scalar))


def _combined(operation: Callable[[Any, Any], Any], a: Any, b: Any) -> Any:
    """Return the sum or the product of two coefficients, exact if one of them is a fraction and both are numbers."""
    exact = isinstance(a, Fraction) or isinstance(b, Fraction)
    if not exact or isinstance(a, Node) or isinstance(b, Node) or not (math.isfinite(a) and math.isfinite(b)):
        return operation(a, b)
    return _number(operation(Fraction(a), Fraction(b)))


def _number(exact: Fraction) -> float | Fraction:
    """Return a number as a float if that is exact."""
    return float(exact) if float(exact) == exact else exact


def _scaled(form: Linear, factor: Any) -> Linear:
    if _is_zero(factor):
        return Linear({})
    return Linear({x: _times(c, factor) for x, c in form.terms.items()}, _times(form.constant, factor))


def _sum(a: Linear, b: Linear) -> Linear:
    terms = dict(a.terms)
    for x, c in b.terms.items():
        terms[x] = _combined(operator.add, terms[x], c) if x in terms else c
    return Linear({x: c for x, c in terms.items() if not _is_zero(c)}, _combined(operator.add, a.constant, b.constant))


def _times_form(form: Linear, other: Linear) -> Linear:
    """Return the product of a form and of one with one term."""
    ((y, n),) = other.terms.items()
    terms = {tuple(sorted(x + y)): _times(c, n) for x, c in form.terms.items()}
    return _sum(Linear(terms), Linear({y: _times(form.constant, n)}))
