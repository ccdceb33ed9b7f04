"""The program of a kernel: steps of all lanes, each with a loop over the orders."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np

from poinsot.taylor import llvm_functions
from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.detection import Watch
from poinsot.taylor.layouts import ROLLED_FROM, Batch, Layout, Rolled, Single
from poinsot.taylor.llvm_ir import (
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    Module,
    Record,
    Value,
    Wide,
    WideArray,
    WideValue,
    vector,
)
from poinsot.taylor.llvm_ir import Function as Lines
from poinsot.taylor.recurrences import HigherOrder, ZerothOrder
from poinsot.taylor.rescaling import Rescaling
from poinsot.taylor.sampling import Sampling
from poinsot.taylor.schedule import Schedule
from poinsot.taylor.tasks import QUEUE, Status, Tasks
from poinsot.taylor.updates import Jumps

__all__ = ["QUEUE", "KernelProgram", "Status"]

AT_ONCE = 8
"""Polynomials that are evaluated side by side: their sums stay in registers."""

WIDE_ORDERS = 24
"""Orders that are summed in double-double arithmetic: terms of order n are e^(-2 n) of the variables at the end of a
step, so that rounding errors of higher orders are below 2^-120."""

SHORTEST_UNIT, SHORTER = 2.0**-400, 2.0**-20
"""Of the unit of time of Taylor coefficients: a step whose coefficients overflow is repeated in a shorter unit."""

STALLED = 2.0**-100
"""The shortest step over the time in quadruple precision, some rounding errors: shorter steps lead to a singularity."""

IN_REGISTERS = 12
"""States of one body of which the last coefficients stay in registers from order to order."""


class KernelProgram:
    """The text of a kernel and the types of its memory."""

    def __init__(
        self,
        decomposition: Decomposition,
        order: int,
        lanes: int,
        layout: Layout,
        wide: bool = False,
        jumps: Jumps | None = None,
    ) -> None:
        self.schedule, self.order, self.wide = Schedule(decomposition), order, wide
        self.variables, self.parameters = len(decomposition.rates), decomposition.parameters
        self.layout: Batch | Single
        if layout == "batch":
            self.layout = Batch(self.schedule, self.variables, order, lanes, wide)
        else:
            kind = Rolled if self.schedule.sums >= ROLLED_FROM else Single
            self.layout = kind(self.schedule, self.variables, order, wide)
        lanes = self.lanes = self.layout.lanes
        self.kind, self.whole = vector(DOUBLE, lanes), vector(INTEGER, lanes)
        self.number = Wide(self.kind) if wide else self.kind
        self.words = 1 + wide
        self.momenta = Rescaling(self, decomposition.momenta)
        self.watch, self.sampling = Watch(self, decomposition), Sampling(self, jumps)
        # What happens at the end is seen in one step more.
        self._arrives = bool(self.watch.events or self.sampling.count)
        self.tasks = Tasks(self)
        self.work, self.task, self.step = self._work_type(), self.tasks.type, self.tasks.step
        self.module = Module()
        for part in (self.tasks, self.momenta, self.watch, self.sampling):
            part.define(self.module)
        self.module.function("evaluate", "void", [POINTER, POINTER, self.number], self._evaluate)
        self.module.function("advance", INTEGER, [POINTER, INTEGER], self._advance)

    def _work_type(self) -> np.dtype[Any]:
        """Return the type of the memory of a run; vectors come first, as they are aligned."""
        lanes = self.lanes
        sizes = {
            "coefficients": (-(-self.layout.size // 8) * 8,),
            "following": ((self.words + 1) * self.variables, lanes),
            "row": ((self.words + 1) * self.variables, lanes),
            "zeros": (self.words * len(self.schedule.zeros), lanes),
            "reciprocals": (self.words * len(self.schedule.reciprocals), lanes),
            **self.watch.polynomials,
        }
        doubles = ("output_time", "least", "most", "outward", "shift", "sample")
        integers = ("active", "flags", "task", "switched")
        return np.dtype(
            [
                *((name, "f8", size) for name, size in sizes.items()),
                *((name, kind, (*shape, lanes)) for name, kind, shape in self.tasks.fields),
                *((name, "f8", (lanes,)) for name in doubles),
                *((name, "i8", (lanes,)) for name in integers),
                ("reciprocals_of_orders", "f8", (self.order + 1,)),
                ("reciprocals_below", "f8", (self.order + 1,)),
                *((name, "i8") for name in ("notes", "notes_most", "noted")),
                *((name, "i8") for name in ("queue", "kept", "kept_most", "kept_count")),
            ]
        )

    def in_unit(self, work: Record, value: Value) -> Value:
        """Return a rate, per unit of time of the Taylor coefficients.

        In quadruple precision the unit is about the radius of convergence, so that powers of it neither overflow nor
        lose digits at order 38. Rates have the unit 1 in double precision.
        """
        return value.times_power_of_two(work.array("unit", self.kind)[0]) if self.wide else value

    def per_unit(self, work: Record, value: Value) -> Value:
        """Return a time in that unit, or a rate from one in that unit."""
        return value.times_power_of_two(1.0 / work.array("unit", self.kind)[0]) if self.wide else value

    def over_order(self, work: Record, n: Value) -> Callable[[Value], Value]:
        """Return the division by n, by 1/n in two parts: the rounding of one would have the same sign at every step."""
        parts = ("reciprocals_of_orders", "reciprocals_below")
        high, low = (work.array(name)[n].spread(self.lanes) for name in parts)
        if self.wide:
            return lambda value: value * WideValue(high, low)
        return lambda value: value.fma(high, value * low)

    def _moved(self, address: Value) -> tuple[Array, Array]:
        """Return the states in the memory that `evaluate` has written, and the rounding errors of their sums."""
        rounded = Array(Array(address, self.kind).at(self.words * self.variables), self.kind)
        return WideArray(address, self.kind, self.variables) if self.wide else Array(address, self.kind), rounded

    def ahead(self, work: Record, target: Value) -> Value:
        """Return the time from the start of the step to a time."""
        time = work.array("time", self.kind)
        if self.wide:
            return WideValue(target, target.like(0.0)) - WideValue(time[0], time[1])
        return (target - time[0]) - time[1]

    def _evaluate(self, address: Value, out: Value, h: Value) -> None:
        """Write the polynomials of the states at a time after the start of the step, and rounding errors of their sums.

        The rounding errors of the step before are added (Kahan), so that errors of many steps do not add up in
        variables that change slowly.
        """
        result, rounded = self._moved(out)
        work = Record(address, self.work)
        h, below = self.per_unit(work, h), work.array("below", self.kind)
        for first in range(0, self.variables, AT_ONCE):
            places = range(first, min(first + AT_ONCE, self.variables))

            def body(n: Value, *sums: Value, places: range = places) -> list[Value]:
                states = self.layout.states(address, n)
                return [n - 1, *(total.fma(h, states[k]) for k, total in zip(places, sums, strict=True))]

            def small(n: Value, *sums: Value, places: range = places) -> list[Value]:
                states = self.layout.states(address, n)
                return [n - 1, *(total.fma(h.high, states[k].high) for k, total in zip(places, sums, strict=True))]

            highest = self.layout.states(address, self.order)
            start = [h.function.constant(INTEGER, self.order - 1), *(highest[k] for k in places)]
            if self.wide:
                rough = [start[0], *(value.high for value in start[1:])]
                n, *sums = h.function.repeat(rough, lambda n, *_: n.is_("ge", WIDE_ORDERS), small)
                start = [n, *map(h.like, sums)]
            _, *sums = h.function.repeat(start, lambda n, *_: n.is_("ge", 1), body)
            lowest = self.layout.states(address, 0)
            for k, total in zip(places, sums, strict=True):
                change, before = total.fma(h, below[k]), lowest[k]
                after = before + change
                gained = after - before
                result[k] = after
                rounded[k] = ((before - (after - gained)) + (change - gained)).high

    def _coefficients(self, lines: Lines, work: Record) -> None:
        """Write the Taylor coefficients of the states."""
        outputs, first = ZerothOrder(self, work).outputs(), self.layout.states(work.address, 1)
        for i, rate in enumerate(outputs[: self.variables]):
            first[i] = self.in_unit(work, rate)
        self.watch.store(work, lines.constant(INTEGER, 0), outputs[self.variables :])

        def order(n: Value, *states: Value) -> list[Value]:
            outputs = HigherOrder(self, work, n, states).outputs()
            with lines.when(n.is_("lt", self.order)) if self.watch.count else nullcontext():
                following, over = self.layout.states(work.address, n + 1), self.over_order(work, n + 1)
                found = [self.in_unit(work, over(rate)) for rate in outputs[: self.variables]]
                for i, value in enumerate(found):
                    following[i] = value
            self.watch.store(work, n, outputs[self.variables :])
            return [n + 1, *(found if states else ())]

        orders = self.order + bool(self.watch.count)
        in_registers = isinstance(self.layout, Single) and self.variables <= IN_REGISTERS and not self.watch.count
        carried = [self.in_unit(work, rate) for rate in outputs[: self.variables]] if in_registers else []
        lines.repeat([lines.constant(INTEGER, 1), *carried], lambda n, *_: n.is_("lt", orders), order)

    def _length(self, work: Record) -> Value:
        """Return the length of a step: e^-2 of the radius of convergence by the last two coefficients (Jorba, Zou)."""
        orders = (0, self.order - 1, self.order)
        largest = []
        for order, least in zip(orders, (1.0, 1e-300, 1e-300), strict=True):
            states = self.layout.states(work.address, order)
            sizes = [abs(states[k].high) for k in range(self.variables)]
            largest.append(llvm_functions.rough_log2(_in_pairs(sizes, Value.larger).larger(least)))
        radius = [(largest[0] - high) * (1 / n) for n, high in zip(orders[1:], largest[1:], strict=True)]
        length = llvm_functions.rough_exp2(
            radius[0].smaller(radius[1]) + (-0.7 / (self.order - 1) - 2.0) / math.log(2.0)
        )
        return self.in_unit(work, length).smaller(work.array("limit", self.kind)[0])

    def _step(self, lines: Lines, work: Record) -> None:
        """Write a step of all lanes."""
        self.sampling.step(lines, work)
        self._coefficients(lines, work)
        active, target = work.array("active", self.whole)[0].is_("ne", 0), self.sampling.target(work)
        left, length = self.ahead(work, target), self._length(work)
        last = length.is_("ge", abs(left.high))
        h, cut, waits, stops = self.watch.look(
            lines, work, last.choose(left, length.intrinsic("copysign", left.high)), active
        )
        at_sample = cut & h.is_("eq", left) if self.sampling.count else lines.constant(last.type, 0)
        last, arrived = (last & ~cut) | at_sample, ~waits & left.is_("eq", 0.0)
        address, states = work.array("following").address, self.layout.states(work.address, 0)
        following, rounded = self._moved(address)
        lines.run("evaluate", work.address, address, h)
        moved = [following[k] for k in range(self.variables)]
        finite = _in_pairs([value.high * 0.0 for value in moved], Value.__add__).is_("eq", 0.0)
        finite = self.watch.defined(work, finite) | waits
        goes = active & finite & ~waits & ~arrived
        seen = active & finite if self.sampling.count else goes
        if self.lanes == 1:
            with lines.when(work.array("kept", INTEGER)[0].is_("ne", 0) & goes):
                lines.run("keep_step", work.address, h.high)
        self._rows(lines, work, seen, h, last & goes, target)
        below = work.array("below", self.kind)
        for k, value in enumerate(moved):
            states[k] = goes.choose(value, states[k])
            below[k] = goes.choose(rounded[k], below[k])
        stalled = self._move(work, goes, last, h, target)
        done = arrived if self._arrives else last
        if self.wide:
            again = self._overflows(work, length, goes, finite)
            finite, done = finite | again, done & ~again
        steps = work.array("steps", self.whole)
        steps[0] = steps[0] + goes.to_integer()
        paused = steps[0].is_("ge", work.array("pause", self.whole)[0])
        held = self.watch.held(work, waits)
        going = finite & ~done & ~stalled & ~paused & ~held & ~stops
        status = work.array("status", self.whole)
        status[0] = _chosen(
            work.array("active", self.whole)[0] * 0,
            (paused, Status.PAUSED),
            (held, Status.HELD),
            (stops, Status.EVENT),
            (stalled, Status.STALLED),
            (done, Status.DONE),
            (~finite, Status.NOT_FINITE),
        )
        self.for_each(lines, work, active & (~going | self.momenta.misfit(work, moved)), "leave")

    def _overflows(self, work: Record, length: Value, goes: Value, finite: Value) -> Value:
        """Choose the unit of time of the next step; return where coefficients may have overflowed in a long unit."""
        unit = work.array("unit", self.kind)
        again = ~finite & unit[0].is_("gt", SHORTEST_UNIT)
        unit[0] = goes.choose(_power_of_two_near(length * math.e**2), again.choose(unit[0] * SHORTER, unit[0]))
        return again

    def _move(self, work: Record, goes: Value, last: Value, h: Value, target: Value) -> Value:
        """Write the time after a step, in two parts; return where it did not move."""
        time = work.array("time", self.kind)
        high, low = time[0], time[1]
        if self.wide:
            before = WideValue(high, low)
            reached = before + h
            work.array("time", self.number)[0] = goes.choose(last.choose(reached.like(target), reached), before)
            return goes & ~last & abs(h.high).is_("le", STALLED * abs(high))
        total = high + h
        part = total - high
        rest = ((high - (total - part)) + (h - part)) + low
        later = total + rest
        time[0] = goes.choose(last.choose(target, later), high)
        time[1] = goes.choose(last.choose(low * 0.0, rest - (later - total)), low)
        return goes & ~last & total.is_("eq", high)

    def _rows(self, lines: Lines, work: Record, goes: Value, h: Value, last: Value, target: Value) -> None:
        """Write the rows of the output times within a step; of one up to a sample the next step writes the last.

        Times are compared, and not their distances from the start of the step, which may be equal after rounding.
        """
        row, _ = self._moved(work.array("row").address)

        def due() -> list[Value]:
            ahead = self.ahead(work, work.array("output_time", self.kind)[0])
            within = abs(ahead).is_("le", abs(h))
            if self.sampling.count:
                within = within & ~(last & work.array("output_time", self.kind)[0].is_("ge", target))
            return [ahead, goes & within]

        def write(ahead: Value, which: Value) -> list[Value]:
            lines.run("evaluate", work.address, row.address, which.choose(ahead, 0.0))
            for k in self.momenta.scaled:
                row[k] = self.momenta.outwards(work, k, row[k])
            self.for_each(lines, work, which, "write_row")
            return due()

        lines.repeat(due(), lambda _, which: which.any(), write)

    def for_each(self, lines: Lines, work: Record, which: Value, name: str) -> None:
        """Call a function for some lanes."""
        with lines.when(which.any()):
            flags = work.array("flags", self.whole)
            flags[0] = which.to_integer()

            def one(lane: Value) -> None:
                with lines.when(flags.of(INTEGER)[lane].is_("ne", 0)):
                    lines.run(name, work.address, lane)

            lines.count(self.lanes, one)

    def _advance(self, address: Value, budget: Value) -> Value:
        """Take steps until all is done, the budget is used or no room is left; return whether something is to do."""
        work, lines = Record(address, self.work), address.function

        def fill(lane: Value) -> None:
            with lines.when(work.array("active", INTEGER)[lane].is_("eq", 0)):
                lines.run("take", address, lane)

        lines.count(self.lanes, fill)

        def going(left: Value) -> Value:
            room = work.array("kept_count", INTEGER)[0].is_("lt", work.array("kept_most", INTEGER)[0])
            if self.watch.events:
                room = room & work.array("noted", INTEGER)[0].is_("le", work.array("notes_most", INTEGER)[0])
            return left.is_("gt", 0) & room & work.array("active", self.whole)[0].is_("ne", 0).any()

        def body(left: Value) -> list[Value]:
            self._step(lines, work)
            return [left - 1]

        lines.repeat([budget], going, body)
        return work.array("active", self.whole)[0].is_("ne", 0).any().to_integer()


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


def _chosen(value: Value, *cases: tuple[Value, int]) -> Value:
    """Return the number of the last case that holds, or a value."""
    for mask, number in cases:
        value = mask.choose(value.like(number), value)
    return value
