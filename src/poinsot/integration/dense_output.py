"""A motion at any time, from the Taylor polynomials of its steps."""

from __future__ import annotations

import ctypes
import functools
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.state_vector import StateVector, blocks_of
from poinsot.mechanics.state import Phase
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Module, Value, machine_code, vector
from poinsot.taylor.llvm_ir import Array as Memory

__all__ = ["Action", "DenseOutput", "KeptSteps", "Side"]

Array = NDArray[Any]
Side = Literal["left", "right"]


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
        As `Worker.steps` has them, one at least.
    """

    def __init__(self, blocks: Sequence[NDArray[Any]]) -> None:
        self._blocks = [block for block in blocks if block.size] or list(blocks[:1])
        self._starts, self._low = np.concatenate([block["start"] for block in self._blocks]).T.copy()
        self._per_unit = np.concatenate([block["per_unit"] for block in self._blocks])

    def __reduce__(self) -> Any:  # a copy has addresses of its own
        return type(self), (self._blocks,)

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self._starts.size

    @functools.cached_property
    def _addresses(self) -> NDArray[np.int64]:
        """Where the coefficients of each step are in memory."""
        each = [(block["coefficients"].ctypes.data, block.itemsize, block.size) for block in self._blocks]
        return np.concatenate([first + size * np.arange(count) for first, size, count in each])

    def at(self, times: Array, side: Side = "left") -> Array:
        """Return the variables at times, at ends of steps those of the step on a side; shape (n, size)."""
        sign = -1.0 if self._starts[-1] < self._starts[0] else 1.0
        ends = np.concatenate([[-np.inf], sign * self._starts[1:], [np.inf]])
        if side == "right":
            ends = np.nextafter(ends, -np.inf)
        _, orders, size = self._blocks[0]["coefficients"].shape
        arrays = ends, self._starts, self._low, self._per_unit, self._addresses, np.ascontiguousarray(times)
        return _compiled(orders, size)(sign, *arrays)


@functools.cache
def _compiled(orders: int, size: int) -> Callable[..., Array]:
    """Return the evaluation of steps at times as machine code, for coefficients of one shape."""

    def body(count: Value, steps: Value, sign: Value, *arrays: Value) -> None:
        lines = count.function
        ends, starts, low, per_unit, _, times, _ = (Memory(array, DOUBLE) for array in arrays)
        addresses, out = Memory(arrays[4], POINTER), Memory(arrays[6], DOUBLE)

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
            (which,) = lines.either(~within, [which], lambda: found(time))  # as a rule it is that of the time before
            ahead = ((times[place] - starts[which]) - low[which]) * per_unit[which]
            _horner(addresses[which], ahead, (orders, size), out.at(place * size))
            return [place + 1, which]

        lines.repeat([lines.constant(INTEGER, 0)] * 2, lambda place, _: place.is_("lt", count), one)

    module, pointers = Module(), 7
    module.function("evaluate", "void", [INTEGER, INTEGER, DOUBLE, *[POINTER] * pointers], body)
    engine = machine_code(str(module))
    types: list[Any] = [ctypes.c_int64, ctypes.c_int64, ctypes.c_double, *[ctypes.c_void_p] * pointers]
    function = ctypes.CFUNCTYPE(None, *types)(engine.get_function_address("evaluate"))

    def evaluate(sign: float, *arrays: Array, engine: Any = engine) -> Array:  # noqa: ARG001
        _, starts, *_, times = arrays
        out = np.empty((times.size, size))
        function(times.size, starts.size, sign, *(array.ctypes.data for array in (*arrays, out)))
        return out

    return evaluate


def _horner(step: Value, ahead: Value, shape: tuple[int, int], out: Value) -> None:
    """Write the values of the polynomials of a step, of as many variables side by side as there are."""
    orders, size = shape
    firsts = [0]
    while firsts[-1] < size:
        firsts.append(firsts[-1] + next(lanes for lanes in (8, 4, 2, 1) if lanes <= size - firsts[-1]))
    kinds = {first: vector(DOUBLE, behind - first) for first, behind in itertools.pairwise(firsts)}

    def vectors(numbers: Value) -> list[Memory]:
        return [Memory(Memory(numbers, DOUBLE).at(first), kind, align=8) for first, kind in kinds.items()]

    def row(order: Value | int) -> list[Value]:
        return [each[0] for each in vectors(Memory(step, DOUBLE).at(order * size))]

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


class Action(NamedTuple):
    """The variables after an event has acted at a time; times that differ by no more than `near` are the same.

    Attributes
    ----------
    since, until : float
        The times of the last sample before the action and of the first one after it: rows at earlier times are the
        variables before both, and rows at later times those after both.
    """

    time: Any
    near: Any
    row: Array
    since: Any = -np.inf
    until: Any = np.inf

    def at(self, times: Any) -> Any:
        """Return whether rows at times are the variables after the action."""
        return (np.abs(times - self.time) <= self.near) & (times >= self.since) & (times < self.until)


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
    actions : sequence of Action
        The actions of events in each direction, in their order.
    """

    def __init__(self, variables: StateVector, origin: float, start: Array) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.last: Array | None = None
        self.actions: Sequence[Action] = ()
        self.parts: Mapping[bool, Steps] = {}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """The earliest time and the latest."""
        return self.reached.get(False, self._origin), self.reached.get(True, self._origin)

    def __call__(self, times: Array) -> Phase:
        """Return q and the momenta."""
        rows = self._at(times)
        if self.actions:
            self._put_actions(times, rows)
        for block in blocks_of(times.size):
            self._variables.make_physical(times[block], rows[block])
        return self._variables.phase_of(rows)

    def _put_actions(self, times: Array, rows: Array) -> None:
        """Put the variables after actions into rows at their times."""
        known = self._after_actions
        behind = known.time.searchsorted(times)
        for places in (np.maximum(behind - 1, 0), np.minimum(behind, known.time.size - 1)):
            some = Action(*(each[places] for each in known))
            here = some.at(times)
            rows[here] = some.row[here]

    @functools.cached_property
    def _after_actions(self) -> Action:
        """The last ones of actions at one time, by times that rise."""
        last = [
            one
            for one, following in itertools.zip_longest(self.actions, self.actions[1:])
            if following is None or abs(following.time - one.time) > following.near
        ]
        order = np.argsort([one.time for one in last])
        return Action(*(np.array(each, dtype=float)[order] for each in zip(*last, strict=True)))

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
