"""Dense output: the Taylor polynomials of the steps in one direction, evaluated at many times by compiled code."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Array, Module, Value, vector
from poinsot.taylor.object_cache import function_of
from poinsot.taylor.queue import Doubles, Integers, Records

__all__ = ["Side", "StoredSteps"]

Side = Literal["left", "right"]


class StoredSteps:
    """Steps of a kernel in one direction.

    Parameters
    ----------
    blocks : list of structured arrays (n,)
        Blocks of steps of a worker, at least one.
    """

    def __init__(self, blocks: Sequence[Records]) -> None:
        self._blocks = [block for block in blocks if block.size] or list(blocks[:1])
        self._starts, self._low = np.concatenate([block["start"] for block in self._blocks]).T.copy()
        self._per_unit = np.concatenate([block["per_unit"] for block in self._blocks])

    def __reduce__(self) -> tuple[type[StoredSteps], tuple[list[Records]]]:  # a copy has addresses of its own
        return type(self), (self._blocks,)

    @property
    def empty(self) -> bool:
        """True if there are no steps."""
        return not self._starts.size

    @functools.cached_property
    def _addresses(self) -> Integers:
        """Addresses of the coefficients of each step."""
        each = [(block["coefficients"].ctypes.data, block.itemsize, block.size) for block in self._blocks]
        return np.concatenate([first + size * np.arange(count) for first, size, count in each])

    def at(self, times: Doubles, side: Side = "left") -> Doubles:
        """Return the variables at times, at ends of steps by the step on one side; shape (n, size)."""
        sign = -1.0 if self._starts[-1] < self._starts[0] else 1.0
        ends = np.concatenate([[-np.inf], sign * self._starts[1:], [np.inf]])
        if side == "right":
            ends = np.nextafter(ends, -np.inf)
        _, orders, size = self._blocks[0]["coefficients"].shape
        out = np.empty((times.size, size))
        arrays = ends, self._starts, self._low, self._per_unit, self._addresses, np.ascontiguousarray(times), out
        _compiled(orders, size)(times.size, self._starts.size, sign, *(array.ctypes.data for array in arrays))
        return out


@functools.cache
def _compiled(orders: int, size: int) -> Callable[..., int]:
    """Return the compiled evaluation for coefficients of one shape, which finds the step of each time."""

    def body(count: Value, steps: Value, sign: Value, *arrays: Value) -> None:
        lines = count.function
        ends, starts, low, per_unit, _, times, _ = (Array(array, DOUBLE) for array in arrays)
        addresses, out = Array(arrays[4], POINTER), Array(arrays[6], DOUBLE)

        def halve(time: Value, first: Value, behind: Value) -> list[Value]:
            middle = (first + behind) >> 1
            after = ends[middle].is_("lt", time)
            return [after.choose(middle, first), after.choose(behind, middle)]

        def found(time: Value) -> list[Value]:
            whole = [lines.constant(INTEGER, 0), steps]
            return lines.repeat(whole, lambda a, b: (b - a).is_("gt", 1), functools.partial(halve, time))[:1]

        def one(place: Value, which: Value) -> list[Value]:
            time = times[place] * sign
            within = ends[which].is_("lt", time) & time.is_("le", ends[which + 1])
            (which,) = lines.either(~within, [which], lambda: found(time))  # usually the step of the previous time
            ahead = ((times[place] - starts[which]) - low[which]) * per_unit[which]
            _horner(addresses[which], ahead, (orders, size), out.at(place * size))
            return [place + 1, which]

        lines.repeat([lines.constant(INTEGER, 0)] * 2, lambda place, _: place.is_("lt", count), one)

    module = Module()
    module.function("evaluate", "void", [INTEGER, INTEGER, DOUBLE, *[POINTER] * 7], body)
    return function_of(module, "evaluate")


def _horner(step: Value, ahead: Value, shape: tuple[int, int], out: Value) -> None:
    """Write the values of the polynomials of a step, for all variables side by side."""
    orders, size = shape
    firsts = [0]
    while firsts[-1] < size:
        firsts.append(firsts[-1] + next(lanes for lanes in (8, 4, 2, 1) if lanes <= size - firsts[-1]))
    kinds = {first: vector(DOUBLE, behind - first) for first, behind in itertools.pairwise(firsts)}

    def vectors(numbers: Value) -> list[Array]:
        return [Array(Array(numbers, DOUBLE).at(first), kind, align=8) for first, kind in kinds.items()]

    def row(order: Value | int) -> list[Value]:
        return [each[0] for each in vectors(Array(step, DOUBLE).at(order * size))]

    def lower(order: Value, *totals: Value) -> list[Value]:
        return [
            order - 1,
            *(total.fma(h, number) for total, h, number in zip(totals, lengths, row(order), strict=True)),
        ]

    lengths = [ahead.spread(behind - first) for first, behind in itertools.pairwise(firsts)]
    start = [ahead.function.constant(INTEGER, orders - 2), *row(orders - 1)]
    _, *values = ahead.function.repeat(start, lambda order, *_: order.is_("ge", 0), lower)
    for place, value in zip(vectors(out), values, strict=True):
        place[0] = value
