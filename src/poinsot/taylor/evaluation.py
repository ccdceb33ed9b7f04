"""Evaluation of formulas in compiled double-double arithmetic."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.taylor.formula_code import written
from poinsot.taylor.graph import HELD, Node, needed
from poinsot.taylor.llvm_functions import LIBRARY
from poinsot.taylor.llvm_ir import BOOL, DOUBLE, INTEGER, POINTER, Array, Module, Value, Wide, machine_code

__all__ = ["WideEvaluator"]


class WideEvaluator:
    """Formulas of numbers, compiled in double-double arithmetic; conditions and roots that a kernel holds are 0.

    Parameters
    ----------
    outputs : sequence of scalars
        Nodes or numbers.
    first : sequence of Node
        Nodes whose values come first in a call; inputs of the run follow.
    """

    def __init__(self, outputs: Sequence[Any], first: Sequence[Node] = ()) -> None:
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
        self._code = machine_code(str(module), LIBRARY)
        types = ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64
        self._evaluate = ctypes.CFUNCTYPE(None, *types)(self._code.get_function_address("evaluate"))

    def __call__(self, given: Sequence[Any]) -> Sequence[Any]:
        """Return the high parts of all outputs, then their low parts: a list of floats, or a tuple of arrays."""
        numbers = np.broadcast_arrays(*(given[place] for place in self._places), *self._values, np.float64(0.0))
        shape = numbers[0].shape
        table = np.array([number.ravel() for number in numbers], dtype=float)
        results = np.empty((2 * self._count, table.shape[1]))
        self._evaluate(table.ctypes.data, results.ctypes.data, table.shape[1])
        return tuple(results) if shape else results[:, 0].tolist()
