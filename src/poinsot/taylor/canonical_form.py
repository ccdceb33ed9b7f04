"""Canonical polynomial form of formulas: linear forms of monomials, the drafts of the operations of a decomposition.

A scalar that depends on inputs of the run alone becomes a parameter where it meets a variable. Numbers and constants
are taken out of products, so that 2 (3 (a x)) costs one operation; a sum that is used once is part of the sum that
uses it.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple, cast

import numpy as np

from poinsot.taylor.decomposition import (
    Coefficient,
    Draft,
    DraftOperand,
    Function,
    Monomial,
    Number,
    Quotient,
    Select,
    Sum,
    Time,
    Variable,
    magnitude,
)
from poinsot.taylor.graph import HELD, GraphScalar, Node, ordered, partials

__all__ = ["TIME", "CanonicalForm", "Root"]

TIME = "time"
"""The name of the symbol of the time; a variable of the state vector is named by its place."""


class Root(NamedTuple):
    """The argument of a square root, and the parameter that is added to it."""

    argument: Node
    parameter: int


class Linear(NamedTuple):
    """A sum of coefficients, numbers or constants, times monomials, and of a constant."""

    terms: dict[Monomial, GraphScalar]
    constant: GraphScalar = 0.0


class CanonicalForm:
    """Formulas as operations on monomials.

    Parameters
    ----------
    groups : sequence of sequences of scalars
        The formulas.

    Attributes
    ----------
    outputs : list of lists
        The values of the formulas.
    drafts : list
    functions : dict
        For each function, by the number of its draft, its place in the graph.
    slopes : dict
        The slopes of functions by these places.
    constants : list of Node
        The parameters.
    conditions : dict
        The place of a condition in the graph to the parameter that holds it.
    roots : list of Root
    """

    def __init__(self, groups: Sequence[Sequence[GraphScalar]]) -> None:
        self.drafts: list[Draft] = []
        self.functions: dict[int, int] = {}
        self.constants: list[Node] = []
        self.conditions: dict[int, int] = {}
        self.roots: list[Root] = []
        self._known: dict[tuple[type, Draft], int] = {}
        self._parameters: dict[int, int] = {}
        self._linear: dict[int, Linear] = {}
        self._scaled: dict[int, tuple[GraphScalar, Monomial]] = {}
        self._slopes: dict[int, tuple[GraphScalar, ...]] = {}
        nodes = self._with_slopes(groups)
        self._uses = Counter(x.place for node in nodes for x in node.nodes)
        self._divides = Counter(x.place for node in nodes if node.name == "div" for x in node.nodes[-1:])
        for slopes in self._slopes.values():
            self._uses.update(x.place for x in slopes if isinstance(x, Node))
        self.outputs = [[self._output(output) for output in group] for group in groups]
        for root in self.roots:
            self._value(root.argument)
        self.slopes = {place: tuple(map(self._value, slopes)) for place, slopes in self._slopes.items()}

    def _with_slopes(self, groups: Iterable[Iterable[GraphScalar]]) -> list[Node]:
        """Return the nodes of the outputs and the nodes of the slopes of their functions."""
        wanted, count = [*itertools.chain(*groups)], -1
        while count != len(wanted):
            count = len(wanted)
            for node in ordered(wanted):
                if node.varies and node.name not in NO_FUNCTIONS and node.place not in self._slopes:
                    slopes = zip(partials(node), node.operands, strict=True)
                    self._slopes[node.place] = own = tuple(s if _varies(x) else 0.0 for s, x in slopes)
                    wanted += own
        return ordered(wanted)

    # ------------------------------------------------------------------ linear forms

    def _form(self, scalar: GraphScalar) -> Linear:
        """Return a scalar as a linear form; a sum that is used several times is one operation."""
        if not isinstance(scalar, Node) or not scalar.varies:
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
            form: Linear = make(*node.arguments)
            return form
        return self._function(node)

    def _form_of_symbol(self, name: int | str) -> Linear:
        return self._drafted(Time() if name == TIME else Variable(int(name)))

    def _form_of_add(self, a: GraphScalar, b: GraphScalar) -> Linear:
        total = _sum(self._form(a), self._form(b))
        plain = {x: self._without_constants(x) for x in total.terms}
        twice = {x for x, count in Counter(y for y, _ in plain.values()).items() if count > 1}
        apart = Linear({x: c for x, c in total.terms.items() if plain[x][0] not in twice}, total.constant)
        for x, c in total.terms.items():
            y, constant = plain[x]
            if y in twice:  # a (c b) and (d a) b are (c + d) (a b)
                apart = _sum(apart, Linear({y: _times(c, constant)}))
        return apart

    def _without_constants(self, monomial: Monomial) -> tuple[Monomial, GraphScalar | None]:
        """Return a product without the constants that were multiplied into its factors, and these constants."""
        constant: GraphScalar | None = None
        factors = list[int]()
        for place in monomial:
            if place in self._scaled:
                own, factor = self._scaled[place]
                constant = own if constant is None else _times(constant, own)
                factors += factor
            else:
                factors.append(place)
        return tuple(sorted(factors)), constant

    def _form_of_neg(self, a: GraphScalar) -> Linear:
        return _scaled(self._form(a), -1)

    def _form_of_mul(self, a: GraphScalar, b: GraphScalar) -> Linear:
        forms = self._form(a), self._form(b)
        for one, other in (forms, forms[::-1]):
            if not one.terms:  # also where all terms cancel
                return _scaled(other, one.constant)
        (m, x), (n, y) = self._factors(a), self._factors(b)
        m, x, n = self._multiplied_in(m, x, n)
        n, y, m = self._multiplied_in(n, y, m)
        return Linear({tuple(sorted(x + y)): _times(m, n)})

    def _multiplied_in(self, m: GraphScalar, x: Monomial, n: GraphScalar) -> tuple[GraphScalar, Monomial, GraphScalar]:
        """Multiply a constant into its only factor if the other product has none, so that products may share it."""
        if not isinstance(m, Node) or isinstance(n, Node) or len(x) > 1:
            return m, x, n
        sign, parameter = self._coefficient(m)
        ((y, _),) = self._drafted(Sum(((Coefficient(1.0, parameter), x),))).terms.items()
        self._scaled[y[0]] = _times(sign, m), x
        return sign, y, n

    def _form_of_div(self, a: GraphScalar, b: Node) -> Linear:
        form, divisor = self._form(a), self._form(b)
        if not divisor.terms:
            return _scaled(form, _reciprocal(divisor.constant))
        n, y = self._factors(b)
        if self._divides[b.place] == 1 and form.terms:
            m, x = self._factors(a)
            return _scaled(self._drafted(Quotient(x, y)), _times(m, _reciprocal(n)))
        return _scaled(_times_form(form, self._drafted(Quotient(Coefficient(), y))), _reciprocal(n))

    def _form_of_ruled(self, value: GraphScalar) -> Linear:
        return self._form(value)

    def _form_of_where(self, condition: Node, a: GraphScalar, b: GraphScalar) -> Linear:
        if condition.varies:
            held = self._parameter(condition.graph.node(HELD, (condition.place,), False))
            self.conditions[condition.place] = held
        else:
            held = self._parameter(condition)
        return self._drafted(Select(held, self._value(a), self._value(b)))

    def _function(self, node: Node) -> Linear:
        arguments = [self._value(x) for x in node.operands]
        if node.name == "sqrt":
            held = node.graph.node(HELD, (node.place,), False)
            self.roots.append(Root(node.operands[0], self._parameter(held)))
            arguments = [self._value(node.operands[0] + held)]
        self.functions[len(self.drafts)] = node.place
        return self._appended(Function(node.name, tuple(arguments), ()))

    # ------------------------------------------------------------------ operations

    def _drafted(self, draft: Draft) -> Linear:
        """Return the form of an operation, a known one if there is one."""
        key = type(draft), draft  # tuples of two kinds may be equal
        if key not in self._known:
            self._known[key] = len(self.drafts)
            return self._appended(draft)
        return Linear({(self._known[key],): 1.0})

    def _appended(self, draft: Draft) -> Linear:
        self.drafts.append(draft)
        return Linear({(len(self.drafts) - 1,): 1.0})

    def _coefficient(self, scalar: GraphScalar) -> Coefficient:
        number, constant = _split(scalar)
        if constant is None:
            return Coefficient(number)
        return Coefficient(math.copysign(1.0, number), self._parameter(cast(Node, _times(magnitude(number), constant))))

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
        signs: dict[Monomial, GraphScalar] = {
            x: math.copysign(1.0, n / number) for x, (n, _) in zip(form.terms, splits, strict=True)
        }
        return _scaled(self._drafted(self._draft_of(Linear(signs))), _times(number, constant))

    def _draft_of(self, form: Linear) -> Sum[Monomial]:
        terms = tuple((self._coefficient(c), x) for x, c in sorted(form.terms.items()))
        return Sum(terms, () if _is_zero(form.constant) else (self._coefficient(form.constant),))

    def _factors(self, scalar: GraphScalar) -> tuple[GraphScalar, Monomial]:
        """Return a coefficient and a monomial."""
        form = self._form(scalar)
        if len(form.terms) != 1 or not _is_zero(form.constant):
            form = self._single(form)
        ((monomial, coefficient),) = form.terms.items()
        return coefficient, monomial

    def _value(self, scalar: GraphScalar) -> DraftOperand:
        """Return a scalar as an operand: a coefficient or a monomial."""
        return self._value_of(self._form(scalar))

    def _value_of(self, form: Linear) -> DraftOperand:
        if not form.terms:
            return self._coefficient(form.constant)
        draft = self._draft_of(form)
        if not draft.constants and draft.terms[0][0] == Coefficient() and len(draft.terms) == 1:
            return draft.terms[0][1]
        (monomial,) = self._drafted(draft).terms
        return monomial

    def _output(self, scalar: GraphScalar) -> DraftOperand:
        form = self._form(scalar)
        sizes = {_size(_split(c)) for c in form.terms.values()}
        if len(form.terms) > 1 and len(sizes) == 1 and sizes != {UNIT} and _is_zero(form.constant):
            form = self._single(form)
        return self._value_of(form)


NO_FUNCTIONS = ("symbol", "ruled", "add", "neg", "mul", "div", "where", "less")
"""Operations that are no elementary functions."""


# ---------------------------------------------------------------------- coefficients: numbers or constants

UNIT = (1.0, None)
"""The size of the coefficient 1."""


def _varies(scalar: GraphScalar) -> bool:
    return isinstance(scalar, Node) and scalar.varies


def _is_zero(scalar: GraphScalar) -> bool:
    return not isinstance(scalar, Node) and scalar == 0


def _split(scalar: GraphScalar) -> tuple[Number, Node | None]:
    """Return the number in a coefficient, and the constant that it multiplies."""
    if not isinstance(scalar, Node):
        return scalar, None
    if scalar.name == "neg":
        number, constant = _split(scalar.operands[0])
        return -number, constant
    if scalar.name == "mul" and not isinstance(scalar.operands[0], Node):
        number, constant = scalar.operands
        return number, constant
    return 1.0, scalar


def _size(split: tuple[Number, Node | None]) -> tuple[Number, int | None]:
    number, constant = split
    return magnitude(number), None if constant is None else constant.place


def _times(a: GraphScalar, b: GraphScalar | None) -> GraphScalar:
    """Return the product of two coefficients; None stands for 1. A divisor that is a number divides a constant."""
    if b is None:
        return a
    for number, constant in ((a, b), (b, a)):
        if isinstance(constant, Node) and isinstance(number, Fraction):
            divisor = _number(1 / number)
            return constant / divisor if isinstance(divisor, float) else number * constant
    return _combined(operator.mul, a, b)


def _reciprocal(scalar: GraphScalar) -> GraphScalar:
    if isinstance(scalar, Node):
        return 1.0 / scalar
    if not scalar or not math.isfinite(scalar):
        return float(np.divide(1.0, float(scalar)))
    return _number(1 / Fraction(scalar))


def _combined(
    operation: Callable[[GraphScalar, GraphScalar], GraphScalar], a: GraphScalar, b: GraphScalar
) -> GraphScalar:
    """Return the sum or the product of two coefficients, exact if one of them is a fraction and both are numbers."""
    exact = isinstance(a, Fraction) or isinstance(b, Fraction)
    if not exact or isinstance(a, Node) or isinstance(b, Node) or not (math.isfinite(a) and math.isfinite(b)):
        return operation(a, b)
    return _number(cast(Fraction, operation(Fraction(a), Fraction(b))))


def _number(exact: Fraction) -> float | Fraction:
    """Return a number as a float if that is exact."""
    return float(exact) if float(exact) == exact else exact


def _scaled(form: Linear, factor: GraphScalar) -> Linear:
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
