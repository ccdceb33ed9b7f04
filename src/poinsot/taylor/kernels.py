"""Kernels: compiled Taylor integrators of decompositions, which fit the instruction cache.

The whole run is compiled: steps with a loop over the orders, rows at given times, and members that take one another's
lanes. Both layouts, in vectors of any length, give the same bits.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext

import numpy as np

from poinsot.taylor.decomposition import Decomposition, Schedule
from poinsot.taylor.detection import Detection
from poinsot.taylor.elementary import rough_exp2, rough_log2
from poinsot.taylor.llvm_ir import (
    ATTRIBUTES,
    DOUBLE,
    INTEGER,
    POINTER,
    SELDOM,
    Array,
    Module,
    Value,
    WideValue,
)
from poinsot.taylor.memory import Body, Context, Layout, Single, Work, layout_of
from poinsot.taylor.object_cache import function_of
from poinsot.taylor.queue import Kernel
from poinsot.taylor.recurrences import HigherOrder, ZerothOrder
from poinsot.taylor.rescaling import Rescaling
from poinsot.taylor.sampling import SAMPLE, Jumps, Sampling
from poinsot.taylor.tasks import Status, Tasks

__all__ = ["ROUNDING", "Code", "KernelProgram", "compiled", "order_of"]

ROUNDING = {"double": 2.0**-52, "quadruple": 2.0**-104}
"""Distance from 1 to the next number, by precision: the smallest tolerance."""

MAX_KERNELS = 128
"""Largest number of kernels in the cache."""

BUDGET, SMALL_SYSTEM = 20_000, 25
"""Steps between checks for Ctrl-C, hundredths of a second, and the inner sums of a system with so many steps."""

SUMS_IN_REGISTERS = 8
"""Polynomials that are evaluated together: their sums stay in registers."""

WIDE_ORDERS = 24
"""Orders that are summed in double-double arithmetic: terms of order n are e^(-2 n) of the variables at the end of a
step, so that rounding errors of higher orders are below 2^-120."""

SHORTEST_UNIT, UNIT_FACTOR = 2.0**-400, 2.0**-20
"""The shortest unit of time of Taylor coefficients, and the factor by which it becomes shorter to repeat a step whose
coefficients overflow."""

SHORTEST_STEP = 2.0**-100
"""The shortest step over the time in quadruple precision, some rounding errors: shorter steps lead to a singularity."""

MAX_STATES_IN_REGISTERS = 12
"""The most states of one body whose last coefficients stay in registers from order to order."""


class KernelProgram:
    """The program of a kernel.

    Attributes
    ----------
    context : Context
    sums : int
        Number of inner sums of an order, which measures the time of a step.
    module : Module
        The functions. `advance` takes steps of a worker.
    """

    def __init__(
        self,
        decomposition: Decomposition,
        order: int,
        lanes: int,
        layout: Layout,
        wide: bool = False,
        jumps: Jumps | None = None,
    ) -> None:
        schedule = Schedule(decomposition)
        places = layout_of(layout, schedule, len(decomposition.rates), order, lanes, wide)
        self.context = context = Context(decomposition, order, wide, places)
        self._schedule, self.sums = schedule, schedule.sums
        self._rescaling = Rescaling(context, decomposition.momenta)
        self._detection = Detection(context, decomposition, (SAMPLE,) if jumps else ())
        self._sampling = Sampling(context, jumps, self._detection.forget_branches)
        self._tasks = Tasks(context, (self._detection, self._sampling, self._rescaling))
        # Zeros and samples at the end of a task are found in one step more.
        self._arrives = bool(context.events or jumps)
        context.task, context.step, context.record = self._tasks.type, self._tasks.step, self._detection.record
        context.work = self._work_type()
        self.module = Module()
        for part in (self._tasks, self._rescaling, self._detection, self._sampling):
            for functions, attributes in ((part.functions, ATTRIBUTES), (part.seldom, SELDOM)):
                for name, body in functions.items():
                    self._define(name, INTEGER, body, attributes)
        if context.lanes == 1:
            self._define("store_step", DOUBLE, self._tasks.store_step, ATTRIBUTES)
        self.module.function("evaluate", "void", [POINTER, POINTER, context.number], self._evaluate)
        self.module.function("advance", INTEGER, [POINTER, INTEGER], self._advance)

    def _define(self, name: str, argument: str, body: Body, attributes: str) -> None:
        """Define a function of the memory of a worker and another argument."""
        written = lambda address, given: body(Work(address, self.context), given)  # noqa: E731
        self.module.function(name, "void", [POINTER, argument], written, attributes)

    def _work_type(self) -> np.dtype[np.void]:
        """Return the type of the memory of a worker; vectors come first, as they are aligned."""
        context, parts = self.context, (self._detection, self._sampling, self._rescaling, self._tasks)
        size = (context.words + 1) * context.variables
        sizes = {"following": size, "row": size, "zeros": context.words * len(self._schedule.zeros)}
        sizes["reciprocals"] = context.words * len(self._schedule.reciprocals)
        vectors = [(name, "f8", (size,)) for name, size in sizes.items()]
        of_lanes = [*vectors, *self._tasks.fields, *(field for part in parts for field in part.of_lanes)]
        return np.dtype(
            [
                ("coefficients", "f8", (-(-context.layout.size // 8) * 8,)),
                *((name, kind, (*shape, context.lanes)) for name, kind, shape in of_lanes),
                *((name, "f8", (context.order + 1,)) for name in ("reciprocals_of_orders", "reciprocals_below")),
                *(field for part in parts for field in part.of_workers),
            ]
        )

    def _moved(self, address: Value) -> tuple[Array, Array]:
        """Return the states that `evaluate` has written to memory, and the rounding errors of their sums."""
        kind, size = self.context.kind, self.context.variables
        rounded = Array(Array(address, kind).at(self.context.words * size), kind)
        return Array(address, self.context.number, size), rounded

    def _evaluate(self, address: Value, out: Value, h: Value) -> None:
        """Write the polynomials of the states at a time after the start of the step, and rounding errors of their sums.

        The rounding errors of the step before are added (Kahan), so that errors of many steps do not add up in
        variables that change slowly.
        """
        (result, rounded), work = self._moved(out), Work(address, self.context)
        h, below = work.per_unit(h), work.doubles("below")
        for first in range(0, self.context.variables, SUMS_IN_REGISTERS):
            places = range(first, min(first + SUMS_IN_REGISTERS, self.context.variables))

            def lower(h: Value, n: Value, *sums: Value, places: range = places) -> list[Value]:
                states, wide = work.states(n), isinstance(h, WideValue)
                terms = (states[k] if wide else states[k].high for k in places)
                return [n - 1, *(total.fma(h, term) for total, term in zip(sums, terms, strict=True))]

            highest = work.states(self.context.order)
            start = [h.function.constant(INTEGER, self.context.order - 1), *(highest[k] for k in places)]
            if self.context.wide:
                rough = [start[0], *(value.high for value in start[1:])]
                small = functools.partial(lower, h.high)
                n, *sums = h.function.repeat(rough, lambda n, *_: n.is_("ge", WIDE_ORDERS), small)
                start = [n, *map(h.like, sums)]
            _, *sums = h.function.repeat(start, lambda n, *_: n.is_("ge", 1), functools.partial(lower, h))
            lowest = work.states(0)
            for k, total in zip(places, sums, strict=True):
                change, before = total.fma(h, below[k]), lowest[k]
                after = before + change
                gained = after - before
                result[k] = after
                rounded[k] = ((before - (after - gained)) + (change - gained)).high

    def _coefficients(self, work: Work) -> None:
        """Write the Taylor coefficients of the states."""
        lines, size, detection = work.lines, self.context.variables, self._detection
        outputs, first = ZerothOrder(work, self._schedule).outputs(), work.states(1)
        for i, rate in enumerate(outputs[:size]):
            first[i] = work.in_unit(rate)
        detection.store(work, lines.constant(INTEGER, 0), outputs[size:])

        def order(n: Value, *states: Value) -> list[Value]:
            outputs = HigherOrder(work, self._schedule, n, states).outputs()
            with lines.when(n.is_("lt", self.context.order)) if detection.count else nullcontext():
                following, over = work.states(n + 1), work.over_order(n + 1)
                found = [work.in_unit(over(rate)) for rate in outputs[:size]]
                for i, value in enumerate(found):
                    following[i] = value
            detection.store(work, n, outputs[size:])
            return [n + 1, *(found if states else ())]

        orders = self.context.order + bool(detection.count)
        single = isinstance(self.context.layout, Single)
        in_registers = single and size <= MAX_STATES_IN_REGISTERS and not detection.count
        carried = [work.in_unit(rate) for rate in outputs[:size]] if in_registers else []
        lines.repeat([lines.constant(INTEGER, 1), *carried], lambda n, *_: n.is_("lt", orders), order)

    def _length(self, work: Work) -> Value:
        """Return the length of a step: e^-2 of the radius of convergence by the last two coefficients (Jorba, Zou)."""
        orders = (0, self.context.order - 1, self.context.order)
        largest = []
        for order, least in zip(orders, (1.0, 1e-300, 1e-300), strict=True):
            states = work.states(order)
            sizes = [abs(states[k].high) for k in range(self.context.variables)]
            largest.append(rough_log2(_in_pairs(sizes, Value.larger).larger(least)))
        radius = [(largest[0] - high) * (1 / n) for n, high in zip(orders[1:], largest[1:], strict=True)]
        length = rough_exp2(radius[0].smaller(radius[1]) + (-0.7 / (self.context.order - 1) - 2.0) / math.log(2.0))
        return work.in_unit(length).smaller(work.doubles("limit")[0])

    def _step(self, work: Work) -> None:
        """Write a step of all lanes."""
        context, lines = self.context, work.lines
        self._sampling.step(work)
        self._coefficients(work)
        active, target = work.active, self._sampling.target(work)
        left, length = work.ahead(target), self._length(work)
        last = length.is_("ge", abs(left.high))
        cut = self._detection.cut(work, last.choose(left, length.intrinsic("copysign", left.high)), active)
        h, waits = cut.length, cut.waits
        at_sample = cut.early & h.is_("eq", left) if self._sampling.count else lines.constant(last.type, 0)
        last, arrived = (last & ~cut.early) | at_sample, ~waits & left.is_("eq", 0.0)
        address, states = work.array("following").address, work.states(0)
        following, rounded = self._moved(address)
        lines.run("evaluate", work.address, address, h)
        moved = [following[k] for k in range(context.variables)]
        finite = _in_pairs([value.high * 0.0 for value in moved], Value.__add__).is_("eq", 0.0)
        finite = self._detection.defined(work, finite) | waits
        moves = active & finite & ~waits & ~arrived
        seen = active & finite if self._sampling.count else moves
        self._tasks.store_steps(work, moves, h)
        self._rows(work, seen, h, last & moves, target)
        below = work.doubles("below")
        for k, value in enumerate(moved):
            states[k] = moves.choose(value, states[k])
            below[k] = moves.choose(rounded[k], below[k])
        stalled = self._move(work, moves, last, h, target)
        done = arrived if self._arrives else last
        if context.wide:
            again = self._overflows(work, length, moves, finite)
            finite, done = finite | again, done & ~again
        steps = work.integers("steps")
        steps[0] = steps[0] + moves.to_integer()
        paused = steps[0].is_("ge", work.integers("pause")[0])
        held = self._detection.held(work, waits)
        going = finite & ~done & ~stalled & ~paused & ~held & ~cut.stops
        status = work.integers("status")
        status[0] = _last_of(
            work.integers("active")[0] * 0,
            (paused, Status.PAUSED),
            (held, Status.HELD),
            (cut.stops, Status.EVENT),
            (stalled, Status.STALLED),
            (done, Status.DONE),
            (~finite, Status.NOT_FINITE),
        )
        work.for_each(active & (~going | self._rescaling.misfit(work, moved)), "leave")

    @staticmethod
    def _overflows(work: Work, length: Value, moves: Value, finite: Value) -> Value:
        """Choose the unit of time of the next step; return where coefficients may have overflowed in a long unit."""
        unit = work.doubles("unit")
        again = ~finite & unit[0].is_("gt", SHORTEST_UNIT)
        unit[0] = moves.choose(_power_of_two_near(length * math.e**2), again.choose(unit[0] * UNIT_FACTOR, unit[0]))
        return again

    @staticmethod
    def _move(work: Work, moves: Value, last: Value, h: Value, target: Value) -> Value:
        """Write the time after a step, in two parts; return where it did not move."""
        time = work.doubles("time")
        high, low = time[0], time[1]
        if isinstance(h, WideValue):
            before = WideValue(high, low)
            reached = before + h
            work.numbers("time")[0] = moves.choose(last.choose(reached.like(target), reached), before)
            return moves & ~last & abs(h.high).is_("le", SHORTEST_STEP * abs(high))
        total = high + h
        part = total - high
        rest = ((high - (total - part)) + (h - part)) + low
        later = total + rest
        time[0] = moves.choose(last.choose(target, later), high)
        time[1] = moves.choose(last.choose(low * 0.0, rest - (later - total)), low)
        return moves & ~last & total.is_("eq", high)

    def _rows(self, work: Work, seen: Value, h: Value, last: Value, target: Value) -> None:
        """Write the rows of the output times within a step; at a sample the next step writes the row.

        Times are compared, and not their distances from the start of the step, which may be equal after rounding.
        """
        lines, (row, _) = work.lines, self._moved(work.array("row").address)

        def due() -> list[Value]:
            ahead = work.ahead(work.doubles("output_time")[0])
            within = abs(ahead).is_("le", abs(h))
            if self._sampling.count:
                within = within & ~(last & work.doubles("output_time")[0].is_("ge", target))
            return [ahead, seen & within]

        def write(ahead: Value, which: Value) -> list[Value]:
            lines.run("evaluate", work.address, row.address, which.choose(ahead, 0.0))
            for k in self.context.scaled:
                row[k] = work.unscaled(k, row[k])
            work.for_each(which, "write_row")
            return due()

        lines.repeat(due(), lambda _, which: which.any(), write)

    def _advance(self, address: Value, budget: Value) -> Value:
        """Take steps until all tasks are done, the budget is used or no room is left; return 1 if tasks are left."""
        work, lines = Work(address, self.context), address.function
        lines.count(self.context.lanes, functools.partial(self._tasks.fill, work))

        def going(left: Value) -> Value:
            room = self._detection.has_room(work, self._tasks.has_room(work))
            return left.is_("gt", 0) & room & work.active.any()

        def body(left: Value) -> list[Value]:
            self._step(work)
            return [left - 1]

        lines.repeat([budget], going, body)
        return work.active.any().to_integer()


def _power_of_two_near(value: Value) -> Value:
    """Return the power of two below a positive number, within 2^-500 to 2^500."""
    bits = value.larger(2.0**-500).smaller(2.0**500).as_bits() >> 52
    return (bits << 52).as_double()


def _in_pairs(values: Sequence[Value], operation: Callable[[Value, Value], Value]) -> Value:
    """Combine values in a tree, which is short."""
    while len(values) > 1:
        halves = [operation(a, b) for a, b in zip(values[::2], values[1::2], strict=False)]
        values = halves + list(values[len(values) & ~1 :])
    return values[0]


def _last_of(value: Value, *cases: tuple[Value, int]) -> Value:
    """Return the number of the last case that holds, or a value."""
    for mask, number in cases:
        value = mask.choose(value.like(number), value)
    return value


# ---------------------------------------------------------------------- machine code


class Code(Kernel):
    """A kernel as machine code of the processor."""

    def __init__(self, program: KernelProgram) -> None:
        super().__init__(program.context)
        self.budget = max(BUDGET * SMALL_SYSTEM // max(program.sums, SMALL_SYSTEM), 1)
        self.advance = function_of(program.module, "advance")


@functools.lru_cache(MAX_KERNELS)
def order_of(tolerance: float, wide: bool = False) -> int:
    """Return the order of the Taylor polynomials for a tolerance (Jorba and Zou 2005), in quadruple precision 4 more.

    At order 38, of the smallest tolerance there, truncation errors of a free body are three times its rounding errors.
    """
    return max(2, math.ceil(1.0 - 0.5 * math.log(tolerance))) + 4 * wide


@functools.lru_cache(MAX_KERNELS)
def compiled(
    decomposition: Decomposition, order: int, lanes: int, layout: Layout = "batch", wide: bool = False
) -> Code:
    """Return the kernel of a decomposition with polynomials of an order; lanes, of the layout "batch", 1, 2, 4 or 8."""
    return Code(KernelProgram(decomposition, order, lanes, layout, wide))
