"""From formulas to a decomposition: constants leave the vector field, and what is left are few elementary operations.

What depends on inputs of the run alone becomes a parameter where it meets a variable. Numbers and constants are taken
out of products, so that 2 (3 (a x)) costs one operation; sums that are used once are part of the sum that uses them.
"""

from __future__ import annotations

import functools
import heapq
import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.program import Graph, Node, ordered, partials, replaced
from poinsot.algebra.replay import HELD, Replay, wide
from poinsot.engine.decomposition import (
    Coefficient,
    Crossing,
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
from poinsot.engine.integrals import without_squares
from poinsot.engine.jumps import Jumps, Update

__all__ = ["TIME", "Constants", "Events", "Program", "conditions_of", "lowered", "simplified"]

TIME = "time"
"""The name of the symbol of the time; a variable of the state vector is named by its place."""

POWERS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "add": lambda a, b, _: a or b,
    "neg": lambda a, _, __: a,
    "mul": lambda a, b, _: a + b,
    "div": lambda a, b, _: a - b,
    "pow": lambda a, _, exponent: a * exponent,
    "sqrt": lambda a, _, __: a / 2,
}
"""The power of what an operation makes of two operands, from theirs and the number that the second one is."""


Monomial = tuple[int, ...]
"""A product of operations, by their numbers in order."""


Pair = tuple[Monomial, Monomial]
"""Two factors of a product, in order."""


DraftSum: Any = Sum
DraftQuotient: Any = Quotient
"""With monomials for operands."""


class Linear(NamedTuple):
    """A sum of coefficients, numbers or constants, times monomials, and of a constant."""

    terms: dict[Monomial, Any]
    constant: Any = 0.0


class Root(NamedTuple):
    """What is under a square root, a node and its value, and the parameter that is added to it."""

    argument: Node
    value: Coefficient | int
    parameter: int


class Events(NamedTuple):
    """Values whose zeros are watched for, and what is done there."""

    values: Sequence[Any] = ()
    crossings: tuple[Crossing, ...] = ()


NO_EVENTS = Events()


@dataclass(frozen=True)
class Program:
    """A decomposition with what its parameters are computed from.

    Attributes
    ----------
    decomposition : Decomposition
    others : list of Coefficient or int
        Values of other functions than the rates.
    parameters : list of Node
    conditions : dict
        The place of a condition in the graph to the parameter that holds it.
    roots : list of Root
    given : sequence of Node
        The `Constants` of runs in which none of them is zero, if some may be.
    jumps : Jumps, optional
        What is done at samples.
    """

    decomposition: Decomposition
    others: list[Coefficient | int]
    parameters: list[Node]
    conditions: dict[int, int]
    roots: list[Root]
    given: Sequence[Node] = ()
    jumps: Jumps | None = None

    def with_jumps(self, graph: Graph, own: list[Node], updates: list[Update]) -> Program:
        """Return the program with the formulas of updates, whose constants are parameters behind the others."""
        if not updates:
            return self
        first, constants = len(self.parameters), _constants_met([x for update in updates for x in update.values])
        jumps = Jumps(graph, own, updates, constants, first)
        decomposition = replace(self.decomposition, parameters=first + len(constants))
        return replace(self, decomposition=decomposition, parameters=[*self.parameters, *constants], jumps=jumps)

    def values(self, typed: Callable[[Any], Any]) -> Replay:
        """Return what gives the values of `given` and of the parameters for the inputs of a run, 0 for those held."""
        return Replay([*self.given, *self.parameters], typed)

    @functools.cached_property
    def powers(self) -> NDArray[np.int_]:
        """To which power of the first input each of the parameters goes: all are homogeneous in it."""
        known: dict[int, Any] = {}
        for node in ordered(self.parameters):
            if node.name in POWERS:
                first, second = (*node.operands, *node.operands)[:2]
                a, b = (known[x.place] if isinstance(x, Node) else 0 for x in (first, second))
                known[node.place] = POWERS[node.name](a, b, second)
            else:
                known[node.place] = int(node.name == "input" and node.operands == (0,))
        return np.array([known[node.place] for node in self.parameters], dtype=int)


class Constants:
    """The values of the constants that a variable meets in formulas, for the inputs of a run.

    Of the formulas it keeps these constants alone, so that a great many may be known, and the program until it is
    asked for.

    Parameters
    ----------
    rates : sequence of scalars
    program : Program
        For runs in which none of the constants is zero.
    jumps : bool
        Whether tangent vectors may jump on the way.

    Attributes
    ----------
    size : int
        How many operations there are.
    count : int
        How many constants.
    values : Replay
    switches : bool
        Whether a formula branches on the way.
    latest : dict
        Which constants were zero in the last run of a kind.
    """

    def __init__(self, rates: Sequence[Any], program: Program, jumps: bool) -> None:
        self.size, self.jumps, self.latest = program.decomposition.size, jumps, dict[Any, tuple[int, ...]]()
        self._program: Program | None = program
        conditions = {node.operands[0] for node in ordered(rates) if node.name == "where"}
        met = _constants_met(rates)
        self.count, self.values = len(met), Replay(met, wide)
        self._never_conditions = [number for number, node in enumerate(met) if node not in conditions]
        self.switches = bool(conditions_of(rates))

    def whole_program(self) -> Program | None:
        """Return the program when it is asked for first, and forget it with its formulas; None later."""
        program, self._program = self._program, None
        return program

    def zeros(self, values: Sequence[Any], numbers: Sequence[Any]) -> tuple[int, ...]:
        """Return which constants are zero for all members; none if one of all is not finite, which is to stop the run.

        Further values may follow those of the constants. Those on which a formula branches are not among them, nor
        those that other numbers of members would change: no member depends on who else is in its ensemble.
        """
        arrays, own = np.ndarray in map(type, numbers), values[: self.count]
        total = sum(map(float, [value for value in own if value.__class__ is not np.ndarray] if arrays else own))
        if total - total:
            return ()
        if not arrays:
            return tuple([number for number in self._never_conditions if not own[number]])
        found = [number for number in self._never_conditions if _is_zero_for_all(values[number])]
        if found:
            others = self.values([_other_members(i) if np.ndim(x) else x for i, x in enumerate(numbers)])
            found = [number for number in found if _is_zero_for_all(others[number])]
        return tuple(found)


def _other_members(place: int) -> Any:
    """Return numbers between 0 and 1 that members might have at a place, always the same."""
    return 0.1 + 0.8 * np.mod((place + 1) * (math.sqrt(5) - 1) / 2 + np.array([0.0, 0.29, 0.61]), 1.0)


def _constants_met(rates: Sequence[Any]) -> list[Node]:
    met = [x for node in ordered(rates) if node.varies for x in node.nodes if not x.varies]
    return [*dict.fromkeys([*met, *(x for x in rates if isinstance(x, Node) and not x.varies)])]


def _is_zero_for_all(value: Any) -> bool:
    return not value.any() if value.__class__ is np.ndarray else not value


def conditions_of(outputs: Iterable[Any]) -> dict[Node, Any]:
    """Return the conditions on which formulas branch on the way, and what is negative where they hold."""
    found = [node for node in ordered(outputs) if node.name == "less" and node.varies]
    return {node: node.operands[0] - node.operands[1] for node in found}


def lowered(graph: Graph, rates: Sequence[Any], others: Sequence[Any] = (), events: Events = NO_EVENTS) -> Program:
    """Return the program of the time derivatives of the state variables, of other functions behind them and events.

    The engine's own kernels would compute integrals of the motion as often as squares.
    """
    return _Lowering(graph, rates, others, events).program(lambda drafts, _: drafts)


def simplified(graph: Graph, rates: Sequence[Any], zeros: Iterable[int], events: Events) -> Program:
    """Return the program for runs in which some of the `Constants` are zero; the values of all of these are given."""
    formulas, count = [*rates, *events.values], len(rates)
    constants = _constants_met(formulas)
    left = replaced(formulas, {constants[number]: 0.0 for number in zeros})
    events = events._replace(values=left[count:])
    program = _Lowering(graph, left[:count], (), events).program(without_squares)
    return replace(program, given=constants)


class _Lowering:
    """Operations whose operands are monomials, which become products at the end."""

    def __init__(self, graph: Graph, rates: Sequence[Any], others: Sequence[Any], events: Events) -> None:
        self._graph, self._rates, self._others, self._events = graph, rates, others, events
        self._watched = conditions_of([*rates, *events.values])
        self._drafts: list[Any] = []
        self._known: dict[Any, int] = {}
        self._parameters: dict[int, int] = {}
        self._constants: list[Node] = []
        self._linear: dict[int, Linear] = {}
        self._scaled: dict[int, tuple[Node, Monomial]] = {}
        self._slopes: dict[int, tuple[Any, ...]] = {}
        self._conditions: dict[int, int] = {}
        self._roots: list[tuple[Node, int]] = []

    def program(self, reduced: Callable[[Sequence[Any], Sequence[Any]], Sequence[Any]]) -> Program:
        """Return the program, whose drafts and rates are reduced to fewer drafts."""
        groups = (self._rates, self._others, [*self._watched.values(), *self._events.values])
        nodes = self._with_slopes(groups)
        self._uses = Counter(x.place for node in nodes for x in node.nodes)
        self._divides = Counter(x.place for node in nodes if node.name == "div" for x in node.nodes[-1:])
        for slopes in self._slopes.values():
            self._uses.update(x.place for x in slopes if isinstance(x, Node))
        outputs = [[self._output(output) for output in group] for group in groups]
        for node, _ in self._roots:
            self._value(node.operands[0])
        by_function: dict[int, Any] = {place: tuple(map(self._value, each)) for place, each in self._slopes.items()}
        final = Assembly(reduced(self._drafts, outputs[0]), by_function)
        rates, others, watched = ([final.value(x) for x in group] for group in outputs)
        roots = [
            Root(node.operands[0], final.value(self._value(node.operands[0])), parameter)
            for node, parameter in self._roots
        ]
        places = tuple(self._conditions[node.place] for node in self._watched)
        own = tuple(rates), len(self._constants), tuple(watched), places, self._events.crossings
        return Program(Decomposition(final.operations(), *own), others, self._constants, self._conditions, roots)

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
            held = self._parameter(self._graph.node(HELD, (condition.place,), False))
            self._conditions[condition.place] = held
        else:
            held = self._parameter(condition)
        return self._drafted(Select(held, self._value(a), self._value(b)))

    def _function(self, node: Node) -> Function:
        arguments = [self._value(x) for x in node.operands]
        if node.name == "sqrt":
            held = self._graph.node(HELD, (node.place,), False)
            self._roots.append((node, self._parameter(held)))
            arguments = [self._value(node.operands[0] + held)]
        return Function(node.name, tuple(arguments), (node.place,))

    # ------------------------------------------------------------------ operations

    def _drafted(self, operation: Any) -> Linear:
        key = type(operation), operation  # tuples of two kinds may be equal
        if key not in self._known:
            self._known[key] = len(self._drafts)
            self._drafts.append(operation)
        return Linear({(self._known[key],): 1.0})

    def _coefficient(self, scalar: Any) -> Coefficient:
        if not isinstance(scalar, Node):
            return Coefficient(scalar)
        number, constant = _split(scalar)
        return Coefficient(math.copysign(1.0, number), self._parameter(_times(abs(number), constant)))

    def _parameter(self, constant: Node) -> int:
        if constant.place not in self._parameters:
            self._parameters[constant.place] = len(self._constants)
            self._constants.append(constant)
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


class Assembly:
    """Operations in their final order, with products in place of monomials."""

    def __init__(self, drafts: Sequence[Any], slopes: Mapping[int, Any]) -> None:
        self._drafts, self._slopes, self._waiting = drafts, slopes, list[int]()
        self._operations: list[Operation] = []
        self._placed: dict[int, int] = {}
        self._known: dict[Any, int] = {}
        monomials = {x for draft in drafts for x in _monomials(draft)}
        monomials |= {x for each in slopes.values() for x in each if not isinstance(x, Coefficient)}
        self._ways = common_factors({x for x in monomials if len(x) > 1})

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


def _monomials(draft: Any) -> list[Monomial]:
    match draft:
        case Sum():
            terms: Any = draft.terms
            return [x for _, x in terms]
        case Quotient(a, b):
            operands: tuple[Any, ...] = (a, b)
        case Select(_, a, b):
            operands = (a, b)
        case Function(_, arguments):
            operands = arguments
        case _:
            operands = ()
    return [x for x in operands if not isinstance(x, Coefficient)]


def common_factors(monomials: Iterable[Monomial]) -> dict[Monomial, Pair]:
    """Return for each monomial the two that it is the product of: pairs of factors that most have in common first."""
    factoring = _Factoring(tuple(monomials))
    while factoring.left:
        factoring.join()
    return factoring.ways


class _Factoring:
    """Monomials as products of parts; the pair of parts that most of them have becomes one part, again and again.

    Which monomials have a pair is kept: to count all pairs anew each time takes the square of their number.

    Attributes
    ----------
    ways : dict
        The two parts of each product so far.
    left : dict
        The parts of the other monomials, by their numbers.
    """

    def __init__(self, monomials: tuple[Monomial, ...]) -> None:
        self._monomials = monomials
        self.ways: dict[Monomial, Pair] = {}
        self.left: dict[int, tuple[Monomial, ...]] = {}
        self._pairs: dict[int, list[Pair]] = {}
        self._places: defaultdict[Pair, dict[int, int]] = defaultdict(dict)
        self._with_product: defaultdict[Monomial, set[Pair]] = defaultdict(set)
        self._queue: list[tuple[bool, int, int, int, Pair]] = []
        self._exchange({number: tuple((factor,) for factor in x) for number, x in enumerate(monomials)})

    def join(self) -> None:
        """Make one part of the best pair; monomials of two parts are done."""
        done = self._done
        for number in done:
            self._know(self._monomials[number], self._pairs[number][0])
        best = self._best()
        changed = {number: _with_pair(self.left[number], best) for number in self._places[best]}
        if len(done) < len(self.left):
            self._know(_joined(best), best)
        self._exchange(changed | dict.fromkeys(done, ()))

    def _know(self, product: Monomial, pair: Pair) -> None:
        self.ways[product] = pair
        self._rank(self._with_product[product])

    def _exchange(self, changed: dict[int, tuple[Monomial, ...]]) -> None:
        """Give some monomials other parts, or none if they are done."""
        touched: set[Pair] = set()
        for number, parts in changed.items():
            self.left[number] = parts
            before, now = self._pairs.get(number, []), [*set(itertools.combinations(parts, 2))]
            self._pairs[number] = now
            for pair in before:
                del self._places[pair][number]
            for place, pair in enumerate(now):
                self._places[pair][number] = place
                self._with_product[_joined(pair)].add(pair)
            touched.update(before, now)
        self._done = [number for number, parts in changed.items() if len(parts) == 2]
        for number in [number for number, parts in changed.items() if not parts]:
            del self.left[number]
        self._rank(touched)

    def _rank(self, pairs: Iterable[Pair]) -> None:
        """Put pairs where they belong now in the order in which they are taken."""
        for pair in pairs:
            if self._places[pair]:
                heapq.heappush(self._queue, (*self._order(pair), pair))

    def _order(self, pair: Pair) -> tuple[bool, int, int, int]:
        """Return what is least of the best pair: its product is there anyway, most have it, it comes first."""
        places = self._places[pair]
        first = min(places, default=-1)
        return _joined(pair) not in self.ways, -len(places), first, places.get(first, -1)

    def _best(self) -> Pair:
        while True:
            *order, pair = heapq.heappop(self._queue)
            if tuple(order) == self._order(pair):
                return pair


def _joined(pair: Pair) -> Monomial:
    return tuple(sorted(pair[0] + pair[1]))


def _with_pair(parts: tuple[Monomial, ...], pair: Pair) -> tuple[Monomial, ...]:
    rest = list(parts)
    for part in pair:
        rest.remove(part)
    return tuple(sorted([*rest, _joined(pair)]))


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
        if isinstance(constant, Node) and isinstance(number, np.longdouble):
            exact = float(number)
            return exact * constant if exact == number else constant / float(1 / number)
    return a * b


def _reciprocal(scalar: Any) -> Any:
    if isinstance(scalar, Node):
        return 1.0 / scalar
    wide = np.longdouble(1) / scalar
    return float(wide) if float(wide) == wide else wide


def _scaled(form: Linear, factor: Any) -> Linear:
    if _is_zero(factor):
        return Linear({})
    return Linear({x: _times(c, factor) for x, c in form.terms.items()}, _times(form.constant, factor))


def _sum(a: Linear, b: Linear) -> Linear:
    terms = dict(a.terms)
    for x, c in b.terms.items():
        terms[x] = terms[x] + c if x in terms else c
    return Linear({x: c for x, c in terms.items() if not _is_zero(c)}, a.constant + b.constant)


def _times_form(form: Linear, other: Linear) -> Linear:
    """Return the product of a form and of one with one term."""
    ((y, n),) = other.terms.items()
    terms = {tuple(sorted(x + y)): _times(c, n) for x, c in form.terms.items()}
    return _sum(Linear(terms), Linear({y: _times(form.constant, n)}))
