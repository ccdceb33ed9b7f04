"""A motion at any time, from the Taylor polynomials of its steps."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.engine import looped_kernel
from poinsot.engine.llvm_ir import DOUBLE, INTEGER, POINTER, Module, Value, machine_code
from poinsot.engine.llvm_ir import Array as Memory
from poinsot.engine.state_vector import BLOCK, StateVector
from poinsot.mechanics.state import Phase

__all__ = ["DenseOutput", "KeptSteps", "Side"]

Array = NDArray[Any]
Side = Literal["left", "right"]

AT_ONCE = 8
"""Polynomials that are evaluated side by side: their sums stay in registers."""


class Steps(Protocol):
    """The polynomials of the steps in one direction."""

    @property
    def empty(self) -> bool:
        """Whether there are none."""

    def at(self, times: Array, side: Side = "left") -> Array:
        """Return the variables at times, at ends of steps those of the step on a side; shape (n, size)."""


class KeptSteps:
    """The steps of a looped kernel in one direction.

    Parameters
    ----------
    blocks : list of structured arrays (n,)
        As `looped_kernel.Run.kept` has them, one at least.
    """

    def __init__(self, blocks: Sequence[NDArray[Any]]) -> None:
        blocks = [block for block in blocks if block.size] or blocks[:1]
        self._starts, self._low = np.concatenate([block["start"] for block in blocks]).T.copy()
        self._firsts = np.cumsum([0, *(block.size for block in blocks[:-1])])
        self._coefficients = [block["coefficients"] for block in blocks]  # (n, order + 1, size)

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self._starts.size

    def at(self, times: Array, side: Side = "left") -> Array:
        """Return the variables at times, at ends of steps those of the step on a side; shape (n, size)."""
        sign = np.sign(self._starts[-1] - self._starts[0])
        which = np.searchsorted(sign * self._starts[1:], sign * times, side)
        ahead = (times - self._starts[which]) - self._low[which]
        _, orders, size = self._coefficients[0].shape
        evaluate = _compiled(orders, size) if looped_kernel.available() else _evaluated
        if len(self._coefficients) == 1:
            return evaluate(self._coefficients[0], which, ahead)
        blocks, out = np.searchsorted(self._firsts, which, "right") - 1, np.empty((times.size, size))
        if blocks.size and blocks.min() == blocks.max():  # as most of a few thousand times in order are
            return evaluate(self._coefficients[blocks[0]], which - self._firsts[blocks[0]], ahead)
        for block in np.unique(blocks).tolist():
            chosen = blocks == block
            out[chosen] = evaluate(self._coefficients[block], which[chosen] - self._firsts[block], ahead[chosen])
        return out


def _evaluated(coefficients: Array, which: Array, ahead: Array) -> Array:
    """Return the values of polynomials, chosen by their numbers, at times since the start of each."""
    total: Array = coefficients[which, -1]
    for order in range(coefficients.shape[1] - 2, -1, -1):
        total = total * ahead[:, None] + coefficients[which, order]
    return total


@functools.cache
def _compiled(orders: int, size: int) -> Callable[[Array, Array, Array], Array]:
    """Return the same as machine code, for coefficients of one shape: ten times as fast."""

    def body(count: Value, coefficients: Value, stride: Value, which: Value, ahead: Value, out: Value) -> None:
        def one(place: Value) -> None:
            step = Memory(coefficients, DOUBLE).at(Memory(which, INTEGER)[place] * stride)
            h, values = Memory(ahead, DOUBLE)[place], Memory(Memory(out, DOUBLE).at(place * size), DOUBLE)
            for k in range(0, size, AT_ONCE):
                group = range(k, min(k + AT_ONCE, size))
                for i, value in zip(group, _horner(step, h, (orders, size), group), strict=True):
                    values[i] = value

        count.function.count(count, one)

    module, kinds = Module(), [INTEGER, POINTER, INTEGER, POINTER, POINTER, POINTER]
    module.function("evaluate", "void", kinds, body)
    engine = machine_code(str(module), ())
    types = [ctypes.c_int64 if kind == INTEGER else ctypes.c_void_p for kind in kinds]
    function = ctypes.CFUNCTYPE(None, *types)(engine.get_function_address("evaluate"))

    def evaluate(coefficients: Array, which: Array, ahead: Array, engine: Any = engine) -> Array:  # noqa: ARG001
        out = np.empty((which.size, size))
        stride, arrays = coefficients.strides[0] // 8, (which, ahead, out)
        function(which.size, coefficients.ctypes.data, stride, *(array.ctypes.data for array in arrays))
        return out

    return evaluate


def _horner(step: Value, h: Value, shape: tuple[int, int], group: range) -> list[Value]:
    """Write Horner's scheme for some of the polynomials of a step."""
    orders, size = shape

    def row(order: Value | int) -> list[Value]:
        numbers = Memory(Memory(step, DOUBLE).at(order * size), DOUBLE)
        return [numbers[i] for i in group]

    def lower(order: Value, *totals: Value) -> list[Value]:
        return [order - 1, *(total.fma(h, number) for total, number in zip(totals, row(order), strict=True))]

    start = [h.function.constant(INTEGER, orders - 2), *row(orders - 1)]
    return h.function.repeat(start, lambda order, *_: order.is_("ge", 0), lower)[1:]


class DenseOutput:
    """A motion at any time between the two that it has reached; what jumps is right-continuous.

    Parameters
    ----------
    variables : StateVector
    origin : float
        The time of the start.
    start : array (size,)

    Attributes
    ----------
    last : array (size,) or None
        The variables at the latest time, of a motion that may jump there.
    """

    def __init__(self, variables: StateVector, origin: float, start: Array) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.last: Array | None = None
        self.parts: Mapping[bool, Steps] = {}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """The earliest time and the latest."""
        return self.reached.get(False, self._origin), self.reached.get(True, self._origin)

    def __call__(self, times: Array) -> Phase:
        """Return q and the momenta."""
        if times.size <= BLOCK:
            return self._variables.to_phase(times, self._at(times))
        parts = [self(times[i : i + BLOCK]) for i in range(0, times.size, BLOCK)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _at(self, times: Array) -> Array:
        """Return the variables."""
        later, earlier = self.parts[True], self.parts[False]
        if self.last is not None:
            there = (times == self.reached[True])[:, None]
            return np.where(there, self.last, self._start if later.empty else later.at(times, "right"))
        if earlier.empty and not later.empty:
            return later.at(times)
        out = np.empty((times.size, self._variables.size))
        for part, chosen in ((later, times >= self._origin), (earlier, times < self._origin)):
            if np.any(chosen):
                out[chosen] = self._start if part.empty else part.at(times[chosen])
        return out
