"""Sums of formulas over the rows of a table, compiled: for each set of inputs a loop over vectors of rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.evaluation import written
from poinsot.taylor.graph import GraphScalar, Node, needed
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Array, Module, Value, vector
from poinsot.taylor.object_cache import function_of

__all__ = ["CompiledSums"]

LANES = 8
"""Number of rows of a vector. It is the same on all processors, so that sums have the same bits."""

Doubles = NDArray[np.float64]


class CompiledSums:
    """Sums over the rows of a table of formulas of a row and of inputs, where a condition holds.

    Rows of zeros are added up to a multiple of the length of a vector; the condition must not hold for them.

    Parameters
    ----------
    outputs : sequence of scalars
        Formulas whose sums are computed.
    condition : Node
        Condition under which a row counts.
    columns, inputs : sequence of Node
        Symbols of the columns of the table, and of the inputs.
    """

    def __init__(
        self, outputs: Sequence[GraphScalar], condition: Node, columns: Sequence[Node], inputs: Sequence[Node]
    ) -> None:
        self._count, self._kind = len(outputs), vector(DOUBLE, LANES)
        given = {node.place for node in (*columns, *inputs)}
        of_rows = {node.place for node in columns}
        nodes = needed([condition, *(x for x in outputs if isinstance(x, Node))], given)
        for node in nodes:
            if any(x.place in of_rows for x in node.nodes):
                of_rows.add(node.place)
        users = [x for node in nodes if node.place in of_rows for x in node.nodes]
        fixed = {x.place: x for x in (*users, *(x for x in outputs if isinstance(x, Node))) if x.place not in of_rows}

        def body(table: Value, numbers: Value, results: Value, blocks: Value, sets: Value) -> None:
            rows, source, out = Array(table, self._kind, align=8), Array(numbers, DOUBLE), Array(results, DOUBLE)

            def one(place: Value) -> None:
                lines = place.function
                own = {node.place: source[sets * k + place].spread(LANES) for k, node in enumerate(inputs)}
                own |= dict(zip(fixed, written(lines, own, [*fixed.values()], self._kind), strict=True))

                def add(block: Value, *totals: Value) -> list[Value]:
                    row = own | {node.place: rows[blocks * k + block] for k, node in enumerate(columns)}
                    (holds,) = written(lines, row, [condition], self._kind)

                    def added() -> list[Value]:
                        values = written(lines, row, outputs, self._kind)
                        return [total + holds.choose(x, 0.0) for total, x in zip(totals, values, strict=True)]

                    return [block + 1, *lines.either(holds.any(), totals, added)]

                zeros = [lines.constant(self._kind, 0.0) for _ in outputs]
                start = [lines.constant(INTEGER, 0), *zeros]
                _, *totals = lines.repeat(start, lambda block, *_: block.is_("lt", blocks), add)
                for k, total in enumerate(totals):
                    out[sets * k + place] = _sum_of_lanes(total)

            sets.function.count(sets, one)

        module = Module()
        module.function("sums", "void", [POINTER, POINTER, POINTER, INTEGER, INTEGER], body)
        self._sums = function_of(module, "sums")

    @staticmethod
    def table(columns: Doubles) -> Doubles:
        """Return the columns (n, rows) as a table, with rows of zeros up to a multiple of the length of a vector."""
        count = columns.shape[1]
        return np.ascontiguousarray(np.pad(columns, ((0, 0), (0, -count % LANES))))

    def __call__(self, table: Doubles, inputs: Doubles) -> Doubles:
        """Return the sums (outputs, sets) for inputs (n, sets)."""
        numbers = np.ascontiguousarray(inputs)
        results = np.empty((self._count, numbers.shape[1]))
        arrays = table, numbers, results
        self._sums(*(array.ctypes.data for array in arrays), table.shape[1] // LANES, numbers.shape[1])
        return results


def _sum_of_lanes(total: Value) -> Value:
    lanes = [total.lane(k) for k in range(LANES)]
    while len(lanes) > 1:
        lanes = [a + b for a, b in zip(lanes[::2], lanes[1::2], strict=True)]
    return lanes[0]
