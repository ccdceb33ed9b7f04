"""Formulas as graphs: traced once, differentiated, and evaluated on scalars of any kind.

A formula that is called with symbols makes nodes, each an operation on nodes and numbers. Equal operations on equal
operands are one node. Constants are the inputs of a run and all nodes that depend on them alone; nodes that depend on a
symbol vary.
"""

from __future__ import annotations

import functools
import itertools
import math
import operator
from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Hashable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeAlias, TypeGuard, cast

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Comparable, Scalar, Vector

__all__ = [
    "HELD",
    "Evaluator",
    "Graph",
    "GraphScalar",
    "Node",
    "Number",
    "Primitive",
    "computed",
    "gradient",
    "needed",
    "number",
    "ordered",
    "partials",
    "replaced",
    "ruled",
    "tangents",
    "wide",
]

GraphScalar: TypeAlias = "Node | float | Fraction"
"""An operand of a formula in a graph."""

Number: TypeAlias = float | np.floating | NDArray[np.floating]
"""The value of an input of a run, for one body or for members."""

MAX_PRODUCT_POWER = 256
"""Whole powers up to this one are products, which have derivatives at zero."""


_Operator: TypeAlias = "Callable[[Node, GraphScalar], GraphScalar]"

OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": operator.add,
    "neg": operator.neg,
    "mul": operator.mul,
    "div": operator.truediv,
    "pow": operator.pow,
}


def _operators(name: str) -> tuple[_Operator, _Operator]:
    """Return the methods of an operator: with the node on its left and on its right."""
    return (lambda node, other: _combined(name, node, other)), (lambda node, other: _combined(name, other, node))


def _combined(name: str, a: Any, b: Any) -> Any:
    """Return the result of an operator on two operands; vectors have their own rules, arrays of nodes go one by one."""
    graph = a.graph if a.__class__ is Node else b.graph
    if _is_operand(a, graph) and _is_operand(b, graph):
        return graph.simplified(name, (a, b))
    for x in (a, b):
        if x.__class__ in SCALARS:
            continue
        if isinstance(x, Vector):
            return NotImplemented
        if isinstance(x, np.ndarray) and x.dtype == object:
            return OPERATORS[name](*map(_in_an_array, (a, b)))
    return _newest((a, b)).applied(name, a, b)


def _in_an_array(scalar: Scalar) -> NDArray[np.object_]:
    array = np.empty(np.shape(scalar) if isinstance(scalar, np.ndarray) else (), dtype=object)
    array[()] = scalar
    return array


class Graph:
    """The nodes of formulas that are traced together.

    Nodes of an older graph are constants here, as arrays are: a derivative may be taken within another trace.
    """

    _ages = itertools.count()

    def __init__(self) -> None:
        self.age = next(self._ages)
        self._known: dict[Hashable, Node] = {}
        self._foreign: list[Scalar] = []

    def symbol(self, name: Hashable) -> Node:
        """Return the node that varies under a name."""
        return self.node("symbol", (name,), varies=True)

    def variable(self, value: Scalar) -> Node:
        """Return a node that varies about a value of any kind."""
        node = self.node("variable", (len(self._known),), varies=True)
        node.value = value
        return node

    def input(self, number: int) -> Node:
        """Return the input of a run at a place, a constant."""
        return self.node("input", (number,), varies=False)

    def evaluated(self, outputs: Sequence[Scalar], values: Mapping[Node, Scalar] | None = None) -> list[Any]:
        """Return the values of outputs for values of symbols and inputs, or of any other nodes of this graph."""
        known: dict[int, Scalar] = {node.place: value for node, value in (values or {}).items()}
        own = [x for x in outputs if isinstance(x, Node) and x.graph is self]
        path = needed(own, known)
        last = {x.place: node.place for node in path for x in node.nodes} | {x.place: -1 for x in own}
        for node in path:
            known[node.place] = node.value if node.name in NAMES_OF_VALUES else replayed(node, known, path)
            for x in node.nodes:
                if last[x.place] == node.place:
                    known.pop(x.place, None)  # so that memory is used again
        return [known[x.place] if isinstance(x, Node) and x.graph is self else x for x in outputs]

    def finished(self, outputs: Sequence[Scalar]) -> list[Any]:
        """Return the values of outputs, and forget all nodes, so that their memory is free at once."""
        values = self.evaluated(outputs)
        self._known.clear()
        return values

    def node(self, name: str, operands: tuple[Any, ...], varies: bool | None = None) -> Node:
        """Return the node of an operation, a new one if it is not known."""
        key = name, operands
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = Node(self, len(self._known), name, operands, varies)
        return found

    def leaf(self, scalar: Scalar) -> GraphScalar:
        """Return a scalar as an operand: a node, a number, or a node that holds an array or a scalar of other kinds."""
        if isinstance(scalar, NUMBERS):
            return float(scalar) if isinstance(scalar, float) else scalar  # type: ignore[return-value]
        if _is_operand(scalar, self):
            return scalar
        self._foreign.append(scalar)  # so that no other one has its identity
        node = self.node("value", (id(scalar),), varies=False)
        node.value = scalar
        return node

    def applied(self, name: str, *scalars: Scalar) -> GraphScalar:
        """Return a function of scalars, of which one at least is a node."""
        return self.simplified(name, tuple([x if _is_operand(x, self) else self.leaf(x) for x in scalars]))

    def simplified(self, name: str, operands: tuple[GraphScalar, ...]) -> GraphScalar:
        """Return a function of operands: a node, or a simpler operand."""
        if name in SIMPLER:
            simple = SIMPLER[name](*operands)
            if simple is not None:
                return simple
        if name in COMMUTATIVE:
            a, b = operands
            if b.__class__ is not Node or (a.__class__ is Node and b.place < a.place):
                operands = b, a
        return self.node(name, operands)


class Node(Comparable):
    """The result of an operation in a graph.

    Attributes
    ----------
    place : int
        Its number in the graph, larger than the numbers of its operands.
    name : str
        "symbol", "variable", "input", "value", "ruled", "primitive", "entry", "add", "neg", "mul", "div",
        "pow", "less", "where" or a function of formulas.
    operands : tuple
        Nodes and numbers; of a symbol its name, of an input its number.
    nodes : tuple
        The operands that are nodes.
    varies : bool
        True if it depends on a symbol or a variable.
    """

    __slots__ = ("graph", "name", "nodes", "operands", "place", "value", "varies")
    varies: bool
    __array_ufunc__ = None

    def __init__(self, graph: Graph, place: int, name: str, operands: tuple[Any, ...], varies: bool | None) -> None:
        self.graph, self.place, self.name, self.operands = graph, place, name, operands
        self.nodes: tuple[Node, ...] = tuple([x for x in operands if x.__class__ is Node])
        self.varies = True in [x.varies for x in self.nodes] if varies is None else varies
        self.value: Any = None

    def __repr__(self) -> str:
        return f"{self.name}({', '.join(map(repr, self.operands))})"

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Operands that determine the value: all but a rule of derivatives and its variables."""
        return self.operands[: WITHOUT_RULE.get(self.name)]

    __add__, __radd__ = _operators("add")
    __mul__, __rmul__ = _operators("mul")
    __truediv__, __rtruediv__ = _operators("div")
    __pow__, __rpow__ = _operators("pow")

    def __neg__(self) -> GraphScalar:
        return self.graph.applied("neg", self)

    def __sub__(self, other: GraphScalar) -> GraphScalar:
        result: GraphScalar = self + (-other)
        return result

    def __rsub__(self, other: GraphScalar) -> GraphScalar:
        result: GraphScalar = other + (-self)
        return result

    def __abs__(self) -> GraphScalar:
        return cast("GraphScalar", functions.abs(self))

    def __bool__(self) -> bool:
        raise TypeError("a formula must not branch with `if` on a value, but it does.")

    def apply(self, name: str, arguments: tuple[Scalar, ...]) -> GraphScalar:
        """Return an elementary function of scalars, this one among them."""
        return _newest(arguments).applied(name, *arguments)


NUMBERS = (int, float, Fraction, np.integer, np.floating)
PLAIN_NUMBERS = (int, float)
SCALARS = (Node, int, float, np.float64)
REPLAYED: Mapping[str, Callable[..., Any]] = {
    **OPERATORS,
    "ruled": lambda value, *_: value,
    "entry": lambda entries, number, *_: entries[number],
}
WITHOUT_RULE = {"ruled": 1, "entry": 2}
"""Operations with rules of their derivatives, and how many operands determine the value."""
UNITS = (1, -1)
COMMUTATIVE = ("add", "mul")
NAMES_OF_VALUES = ("variable", "value")


def _is_operand(scalar: Scalar, graph: Graph) -> TypeGuard[GraphScalar]:
    return scalar.graph is graph if scalar.__class__ is Node else scalar.__class__ in PLAIN_NUMBERS


def _newest(scalars: Iterable[Scalar]) -> Graph:
    graphs = {x.graph for x in scalars if x.__class__ is Node}
    return graphs.pop() if len(graphs) == 1 else max(graphs, key=operator.attrgetter("age"))


# ---------------------------------------------------------------------- simplifications: None where there is none


def _added(a: GraphScalar, b: GraphScalar) -> GraphScalar | None:
    return b if a == 0 else a if b == 0 else None


def _negated(a: Node) -> GraphScalar | None:
    inner: GraphScalar | None = a.operands[0] if a.name == "neg" else None
    return inner


def _multiplied(a: GraphScalar, b: GraphScalar) -> GraphScalar | None:
    inner: GraphScalar
    for one, other in ((a, b), (b, a)):
        if one.__class__ is Node:
            if one.name == "neg":
                inner = one.operands[0]
                return -(inner * other)
        elif one == 0:
            return 0.0
        elif one in UNITS:
            return other if one == 1 else -other
        elif other.__class__ is Node and other.name == "mul" and other.operands[0].__class__ is not Node:
            number, rest = other.operands
            inner = (one * number) * rest
            return inner
    return None


def _divided(a: GraphScalar, b: GraphScalar) -> GraphScalar | None:
    inner: GraphScalar
    if a == 0:
        return 0.0
    if b == 1:
        return a
    if isinstance(b, Node) and b.name == "div" and b.operands[0] == 1:
        inner = b.operands[1]
        return a * inner
    if isinstance(a, Node) and a.name == "neg":
        inner = a.operands[0]
        return -(inner / b)
    return None


def _powered(base: GraphScalar, power: GraphScalar) -> GraphScalar | None:
    if isinstance(power, Node):
        return functions.exp(power * functions.log(base)) if power.varies else None
    n = float(power)
    if n == int(n) and 0 <= n <= MAX_PRODUCT_POWER:
        return _whole_power(base, int(n))
    return functions.sqrt(base) if n == 0.5 else None


def _whole_power(x: GraphScalar, n: int) -> GraphScalar:
    """Return x^n as products of squares."""
    if n < 2:
        return x if n else 1.0
    root = _whole_power(x, n // 2)
    return root * root * x if n % 2 else root * root


def _chosen(condition: GraphScalar, a: GraphScalar, b: GraphScalar) -> GraphScalar | None:
    if not isinstance(condition, Node):
        return a if condition else b
    return a if a is b or a == b else None


def _on_a_circle(eccentricity: GraphScalar, mean_anomaly: GraphScalar) -> GraphScalar | None:
    return mean_anomaly if eccentricity == 0 else None


SIMPLER: Mapping[str, Callable[..., GraphScalar | None]] = {
    "add": _added,
    "neg": _negated,
    "mul": _multiplied,
    "div": _divided,
    "pow": _powered,
    "where": _chosen,
    "eccentric_anomaly": _on_a_circle,
}


# ---------------------------------------------------------------------- derivatives


def _exact(scalar: GraphScalar) -> GraphScalar:
    """Return a number as a fraction, so that sums and products with other numbers have all digits."""
    return Fraction(scalar) if isinstance(scalar, float) and math.isfinite(scalar) else scalar


def _by_atan2(_: Node, y: GraphScalar, x: GraphScalar) -> tuple[GraphScalar, ...]:
    square = _exact(x) * _exact(x) + _exact(y) * _exact(y)
    return x / square, -y / square


def _by_anomaly(E: Node, e: GraphScalar, _: GraphScalar) -> tuple[GraphScalar, ...]:
    sine = functions.sin(0.5 * E)
    slope = 1 / ((1 - _exact(e)) + 2 * e * (sine * sine))
    return slope * functions.sin(E), slope


def _by_inverse_hyperbolic_defect(_: Node, x: GraphScalar) -> tuple[GraphScalar, ...]:
    root = functions.sqrt(1 + x * x)
    return (x * x / (root * (1 + root)),)


PARTIALS: Mapping[str, Callable[..., tuple[GraphScalar, ...]]] = {
    "add": lambda *_: (1, 1),
    "neg": lambda *_: (-1,),
    "mul": lambda _, a, b: (b, a),
    "div": lambda y, _, b: (1 / b, -y / b),
    "pow": lambda y, a, b: (b * y / a, y * functions.log(a) if isinstance(b, Node) else 0.0),
    "sqrt": lambda y, _: (0.5 / y,),
    "exp": lambda y, _: (y,),
    "log": lambda _, a: (1 / a,),
    "sin": lambda _, a: (functions.cos(a),),
    "cos": lambda _, a: (-functions.sin(a),),
    "tan": lambda y, _: (1 + y * y,),
    "tanh": lambda y, _: (1 - y * y,),
    "asin": lambda _, a: (1 / functions.sqrt((1 - a) * (1 + a)),),
    "acos": lambda _, a: (-1 / functions.sqrt((1 - a) * (1 + a)),),
    "atan": lambda _, a: (1 / (1 + a * a),),
    "atan2": _by_atan2,
    "eccentric_anomaly": _by_anomaly,
    "sine_defect": lambda _, a: (2 * functions.sin(0.5 * a) ** 2,),
    "asinh_defect": _by_inverse_hyperbolic_defect,
}


def partials(node: Node) -> tuple[GraphScalar, ...]:
    """Return the derivatives of a node by its operands, and 0 for operands that are numbers.

    Raises
    ------
    TypeError
        If the node has no derivative.
    """
    if node.name == "ruled":
        *variables, slope = node.operands[1:]
        return 0.0, *map(slope, range(len(variables))), 0.0
    if node.name == "primitive":  # its entries depend on the variables themselves
        return (0.0,) * len(node.operands)
    if node.name == "entry" and node.operands[1] == 0:
        return 0.0, 0.0, *map(functools.partial(_slope_of_primitive, node), range(1, len(node.operands) - 1))
    if node.name == "rint":  # it is flat between its jumps
        return (0.0,)
    if node.name not in PARTIALS:
        raise TypeError(f"{node.name} must have a derivative, but it has none.")
    slopes = PARTIALS[node.name](node, *node.operands)
    return tuple([s if isinstance(x, Node) else 0.0 for s, x in zip(slopes, node.operands, strict=True)])


def ruled(value: Scalar, variables: Sequence[Scalar], slope: Callable[[int], Scalar]) -> Scalar:
    """Return a value whose derivatives follow from a rule: `slope` of the number of a variable."""
    if not any(isinstance(x, Node) for x in variables):
        return value
    graph = _newest(variables)
    return graph.node("ruled", (*map(graph.leaf, (value, *variables)), slope))


class Primitive(ABC):
    """Function of scalars that is computed as a whole for arrays, with closed derivatives."""

    @abstractmethod
    def entries(self, numbers: Sequence[int], *variables: Number) -> Mapping[int, Number]:
        """Return entries by number: 0 is the value, k the derivative with respect to the k-th variable, from 1."""


def computed(primitive: Primitive, variables: Sequence[Scalar]) -> Scalar:
    """Return the value of a primitive function: a number or an array, or a node if a variable is a node.

    The evaluation of a graph calls the function once for all entries that its outputs need.
    """
    if not any(isinstance(x, Node) for x in variables):
        value: Scalar = primitive.entries((0,), *cast("Sequence[Number]", variables))[0]
        return value
    graph = _newest(variables)
    leaves = tuple(map(graph.leaf, variables))
    return graph.node("entry", (graph.node("primitive", (primitive, *leaves)), 0, *leaves))


def _slope_of_primitive(value: Node, number: int) -> GraphScalar:
    entries, _, *variables = value.operands
    return value.graph.node("entry", (entries, number, *variables)) if isinstance(variables[number - 1], Node) else 0.0


def ordered(outputs: Iterable[Scalar]) -> list[Node]:
    """Return all nodes that outputs depend on, themselves included, operands first."""
    return needed([x for x in outputs if isinstance(x, Node)], ())


def gradient(output: Scalar, by: Sequence[Node]) -> list[GraphScalar]:
    """Return the derivatives of one scalar by some nodes, none of which depends on another: by reverse passes."""
    if not by or not isinstance(output, Node) or output.graph is not by[0].graph:
        return [0.0] * len(by)
    nodes, ends = ordered([output]), {node.place for node in by}
    reached = _reached(nodes, ends)
    adjoints: dict[int, GraphScalar] = {output.place: 1} if output.place in reached else {}
    for node in reversed(nodes):
        if node.place not in adjoints or node.place in ends:
            continue
        adjoint = adjoints[node.place]
        factors = [adjoint if x.__class__ is Node and x.place in reached else 0.0 for x in node.operands]
        for x, share in zip(node.operands, _shares(node, factors), strict=True):
            if not _is_zero(share):
                adjoints[x.place] = adjoints[x.place] + share if x.place in adjoints else share
    return [adjoints.get(node.place, 0.0) for node in by]


def tangents(outputs: Sequence[Scalar], seeds: Mapping[Node, GraphScalar]) -> list[GraphScalar]:
    """Return the differentials of outputs for differentials of some nodes, which need not be symbols."""
    found: dict[int, GraphScalar] = {node.place: seed for node, seed in seeds.items()}
    graphs = {node.graph for node in seeds}
    own = [x if isinstance(x, Node) and x.graph in graphs else 0.0 for x in outputs]
    for node in ordered(own):
        if node.place in found or not any(x.place in found for x in node.nodes):
            continue
        if node.name == "less":
            continue
        factors = [_known(found, x) for x in node.operands]
        if node.name == "where":
            change: Any = functions.where(node.operands[0], *factors[1:])
        else:
            change = sum([share for share in _shares(node, factors) if not _is_zero(share)], start=0.0)
        if not _is_zero(change):
            found[node.place] = change
    return [_known(found, x) for x in own]


def _shares(node: Node, factors: Sequence[GraphScalar]) -> Sequence[Any]:
    """Return the derivatives of a node by its operands, each times a factor."""
    if node.name == "add":
        return factors
    if node.name == "where":
        condition, (_, first, second) = node.operands[0], factors
        return 0.0, functions.where(condition, first, 0.0), functions.where(condition, 0.0, second)
    return [0.0 if _is_zero(x) else s * x for s, x in zip(partials(node), factors, strict=True)]


def _is_zero(scalar: GraphScalar) -> bool:
    return isinstance(scalar, NUMBERS) and bool(scalar == 0)


def _known(found: Mapping[int, GraphScalar], operand: GraphScalar) -> GraphScalar:
    return found.get(operand.place, 0.0) if operand.__class__ is Node else 0.0


def _reached(nodes: Iterable[Node], ends: Iterable[int]) -> set[int]:
    """Return the places of nodes that depend on other nodes, and the places of these."""
    reached = set(ends)
    for node in nodes:
        if node.name != "less" and any(x.place in reached for x in node.nodes):
            reached.add(node.place)
    return reached


SINGULAR = {"div": 1, "atan2": 1, "sqrt": 0, "log": 0, "pow": 0}
"""Operations that have no value, or no slope, where one of their operands is zero, and which one."""


def replaced(outputs: Sequence[GraphScalar], values: Mapping[Node, GraphScalar]) -> Sequence[GraphScalar]:
    """Return simplified outputs with some nodes replaced; unchanged outputs if an operation would be singular."""
    known: dict[int, GraphScalar] = {node.place: value for node, value in values.items()}
    for node in ordered(outputs):
        if node.place in known or not any(x.place in known for x in node.nodes):
            continue
        operands = [known.get(x.place, x) if x.__class__ is Node else x for x in node.operands]
        if node.name in SINGULAR and _is_zero(operands[SINGULAR[node.name]]):
            return outputs
        known[node.place] = operation_of(node)(*operands)
    return [known.get(x.place, x) if x.__class__ is Node else x for x in outputs]


# ---------------------------------------------------------------------- values


def number(scalar: Any) -> Any:
    """Return the value of a node that depends on variables alone, and any other scalar as it is."""
    while isinstance(scalar, Node) and all(node.nodes or node.name in NAMES_OF_VALUES for node in ordered([scalar])):
        (scalar,) = scalar.graph.evaluated([scalar])
    return scalar


def replayed(node: Node, known: Mapping[int, Scalar], path: Sequence[Node]) -> Scalar:
    """Return the value of a node from the values of its arguments, by their places; `path` as in `operation_of`."""
    arguments = [known[x.place] if x.__class__ is Node else x for x in node.arguments]
    value: Scalar = operation_of(node, path)(*[float(x) if x.__class__ is Fraction else x for x in arguments])
    return value


def operation_of(node: Node, path: Sequence[Node] = ()) -> Callable[..., Any]:
    """Return the function that computes the value of a node from the values of its arguments.

    `path` contains the nodes of the evaluation, which determine the entries of a primitive function that are computed.
    """
    if node.name == "primitive":
        numbers = tuple([x.operands[1] for x in path if x.name == "entry" and x.operands[0] is node])
        return lambda primitive, *variables: primitive.entries(numbers, *variables)
    operation: Callable[..., Any] = REPLAYED.get(node.name) or getattr(functions, node.name)
    return operation


def needed(outputs: Iterable[Node], known: Container[int]) -> list[Node]:
    """Return the nodes that outputs depend on, operands first, without the nodes at known places and their operands."""
    found: dict[int, Node] = {}
    waiting = list(outputs)
    while waiting:
        node = waiting.pop()
        if node.place not in found and node.place not in known:
            found[node.place] = node
            waiting += node.nodes
    return [found[place] for place in sorted(found)]


HELD = "held"
"""Name of constants that the kernel holds: conditions and square roots, which change at switches and at the start."""

wide: Callable[[Number], Number] = np.longdouble(1).__mul__  # type: ignore[assignment]
"""Convert a number or an array to long double, in a quarter of the time of `np.longdouble`."""

MAX_SELECTIONS = 8
"""Sets of inputs that change together, for which an evaluator stores the operations to repeat."""

_Operation: TypeAlias = tuple[int, Callable[..., Number], Callable[[list[Number]], Sequence[Number]], int]
"""Register of the result, function, choice of its operands among all registers, and its inputs, as bits."""

_LastCall: TypeAlias = tuple[Sequence[Number], list[Number], tuple[Number, ...]]
"""Numbers of a call, all registers, and the values of the outputs."""

NO_CALL: _LastCall = (), [], ()


class Evaluator:
    """Evaluation of formulas for the inputs of a run, node by node. Constants named `HELD` are zero.

    For scalars, a call repeats only the operations that depend on inputs whose numbers differ from the last call.

    Parameters
    ----------
    outputs : sequence of scalars
        Nodes or numbers.
    typed : callable
        Conversion of each input, a scalar or an array, to the type of the arithmetic.
    first : sequence of Node
        Nodes whose values come first in a call; inputs of the run follow.
    """

    def __init__(
        self, outputs: Sequence[GraphScalar], typed: Callable[[Number], Number], first: Sequence[Node] = ()
    ) -> None:
        self._typed, self._registers = typed, list[Number]()
        nodes = [x for x in outputs if isinstance(x, Node)]
        given = {node.place: number for number, node in enumerate(first)}
        inputs = [node for node in needed(nodes, given) if node.name == "input"]
        given |= {node.place: len(first) + node.operands[0] for node in inputs}
        places = {place: self._register() for place in given}
        bits = {places[place]: 1 << number for place, number in given.items()}
        self._given = [(number, places[place]) for place, number in given.items()]
        self._operations: list[_Operation] = []
        path = needed(nodes, given)
        for node in path:
            if node.name in ("value", HELD):
                places[node.place] = self._register(node.value if node.name == "value" else 0.0)
            else:
                operands = tuple(
                    [places[x.place] if isinstance(x, Node) else self._register(x) for x in node.arguments]
                )
                places[node.place] = result = self._register()
                bits[result] = functools.reduce(operator.or_, (bits.get(x, 0) for x in operands), 0)
                self._operations.append((result, operation_of(node, path), _choice(operands), bits[result]))
        self._outputs = [places[x.place] if isinstance(x, Node) else self._register(x) for x in outputs]
        self._selections: dict[int, list[_Operation]] = {}
        self._count, self._last = max([number + 1 for number, _ in self._given], default=0), NO_CALL

    def _register(self, value: Number | Fraction = 0.0) -> int:
        if isinstance(value, Fraction):
            value = np.longdouble(value.numerator) / np.longdouble(value.denominator)
        self._registers.append(value)
        return len(self._registers) - 1

    def __call__(self, given: Sequence[Number]) -> tuple[Number, ...]:
        """Return the values, scalars or arrays: the same tuple as in the last call if all numbers are equal."""
        scalars = np.ndarray not in map(type, given)
        last, known, values = self._last if scalars else NO_CALL  # threads exchange it whole
        changed = sum([
            1 << number
            for number, x, y in zip(range(self._count), given, last, strict=False)
            if x is not y and (x != y or (not x and math.copysign(1.0, x) != math.copysign(1.0, y)))
        ]) if last else -1  # fmt: skip
        if changed:
            known = (known or self._registers).copy()
            for number, place in self._given:
                if changed >> number & 1:
                    known[place] = self._typed(given[number])
            for result, function, operands, _ in self._selection(changed):
                known[result] = function(*operands(known))
            values = tuple([known[place] for place in self._outputs])
            self._last = (tuple(given), known, values) if scalars else NO_CALL
        return values

    def _selection(self, changed: int) -> list[_Operation]:
        """Return the operations that depend on inputs, which are given as bits; all where such sets are many."""
        if changed == -1 or (changed not in self._selections and len(self._selections) >= MAX_SELECTIONS):
            return self._operations
        if changed not in self._selections:
            self._selections[changed] = [one for one in self._operations if one[3] & changed]
        return self._selections[changed]


def _choice(places: tuple[int, ...]) -> Callable[[list[Number]], Sequence[Number]]:
    """Return the function that chooses the registers of an operation; faster than a loop over their places."""
    return operator.itemgetter(*places) if len(places) > 1 else operator.itemgetter(slice(places[0], places[0] + 1))
