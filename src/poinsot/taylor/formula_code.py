"""Formulas of scalars as LLVM's code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from poinsot.taylor import llvm_functions, wide_functions
from poinsot.taylor.decomposition import Coefficient
from poinsot.taylor.graph import OPERATORS, GraphScalar, Node, needed
from poinsot.taylor.llvm_ir import BOOL, FunctionText, Value, Wide

__all__ = ["written"]


def written(lines: FunctionText, known: Mapping[int, Value], outputs: Sequence[GraphScalar], kind: str) -> list[Value]:
    """Write formulas of numbers of a type; values of some nodes are known by the places of these."""
    values = dict(known)

    def value(operand: GraphScalar) -> Value:
        return values[operand.place] if isinstance(operand, Node) else lines.constant(kind, operand)

    for node in needed([x for x in outputs if isinstance(x, Node)], known):
        values[node.place] = _result(node, [value(x) for x in node.arguments], isinstance(kind, Wide))
    return [value(output) for output in outputs]


def _result(node: Node, operands: list[Value], wide: bool) -> Value:
    """Write an operation of scalars; conditions are masks, those that are parameters 0 or 1."""
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
            write = wide_functions.elementary if wide else llvm_functions.elementary
            return write(name, given, operands)
