"""Evaluation of formulas in compiled code: at samples in a kernel, and of parameters in double-double arithmetic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from poinsot.taylor.decomposition import Coefficient
from poinsot.taylor.elementary import elementary
from poinsot.taylor.graph import HELD, OPERATORS, GraphScalar, Node, Number, needed
from poinsot.taylor.llvm_ir import (
    BOOL,
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    FunctionText,
    Module,
    Value,
    Wide,
)
from poinsot.taylor.object_cache import function_of

__all__ = ["WideEvaluator", "written"]


def written(lines: FunctionText, known: Mapping[int, Value], outputs: Sequence[GraphScalar], kind: str) -> list[Value]:
    """Write formulas of numbers of a type; values of some nodes are known by the places of these."""
    values = dict(known)

    def value(operand: GraphScalar) -> Value:
        return values[operand.place] if isinstance(operand, Node) else lines.constant(kind, operand)

    for node in needed([x for x in outputs if isinstance(x, Node)], known):
        values[node.place] = _result(node, [value(x) for x in node.arguments])
    return [value(output) for output in outputs]


def _result(node: Node, operands: list[Value]) -> Value:
    """Write an operation of scalars; a condition is a mask, or a parameter that is 0 or 1."""
    match node.name:
        case "less":
            return operands[0].is_("lt", operands[1])
        case "where":
            condition, first, second = operands
            return (condition if condition.type == BOOL else condition.is_("ne", 0.0)).choose(first, second)
        case "ruled":
            return operands[0]
        case "rint":
            return operands[0].rint()
        case name if name in OPERATORS and name != "pow":
            result: Value = OPERATORS[name](*operands)
            return result
        case name:
            given = tuple(0 if isinstance(x, Node) else Coefficient(float(x)) for x in node.operands)
            return elementary(name, given, operands)


class WideEvaluator:
    """Formulas of numbers, compiled in double-double arithmetic; conditions and roots that a kernel holds are 0.

    Parameters
    ----------
    outputs : sequence of scalars
        Nodes or numbers.
    first : sequence of Node
        Nodes whose values come first in a call; inputs of the run follow.
    """

    def __init__(self, outputs: Sequence[GraphScalar], first: Sequence[Node] = ()) -> None:
        own = {node.place: place for place, node in enumerate(first)}
        nodes = needed([x for x in outputs if isinstance(x, Node)], own)
        given = own | {node.place: len(first) + node.operands[0] for node in nodes if node.name == "input"}
        values = [node for node in nodes if node.name == "value"]
        held = [node for node in nodes if node.name == HELD]
        self._count, self._values = len(outputs), [node.value for node in values]
        self._places = [*given.values()]
        known = {place: i for i, place in enumerate([*given, *(node.place for node in values)])}

        def body(numbers: Value, results: Value, count: Value) -> None:
            source, out = Array(numbers, DOUBLE), Array(results, DOUBLE)

            def member(m: Value) -> None:
                zero = m.function.constant(Wide(DOUBLE), 0.0)
                own = {place: zero.like(source[count * i + m]) for place, i in known.items()}
                own |= {node.place: zero for node in held}
                for i, value in enumerate(written(m.function, own, outputs, Wide(DOUBLE))):
                    truth = value.choose(m.function.constant(DOUBLE, 1.0), 0.0) if value.type == BOOL else value
                    for part, number in enumerate(zero.like(truth).parts):
                        out[count * (i + part * len(outputs)) + m] = number

            count.function.count(count, member)

        module = Module()
        module.function("evaluate", "void", [POINTER, POINTER, INTEGER], body)
        self._evaluate = function_of(module, "evaluate")

    def __call__(self, given: Sequence[Number]) -> Sequence[Number]:
        """Return the high parts of all outputs, then their low parts: a list of floats, or a tuple of arrays."""
        numbers = np.broadcast_arrays(*(given[place] for place in self._places), *self._values, np.float64(0.0))
        shape = numbers[0].shape
        table = np.array([number.ravel() for number in numbers], dtype=float)
        results = np.empty((2 * self._count, table.shape[1]))
        self._evaluate(table.ctypes.data, results.ctypes.data, table.shape[1])
        return tuple(results) if shape else results[:, 0].tolist()
