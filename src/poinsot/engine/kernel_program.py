"""The program of a kernel: a loop over the orders in each step, steps, rows, and members that take others' lanes."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from poinsot.engine import llvm_functions
from poinsot.engine.decomposition import Decomposition
from poinsot.engine.jumps import Jumps
from poinsot.engine.kernel_jumps import Sampling
from poinsot.engine.kernel_layouts import Batch, Layout, Single
from poinsot.engine.kernel_watch import Watch
from poinsot.engine.llvm_ir import DOUBLE, INTEGER, POINTER, SELDOM, Array, Module, Record, Value, vector
from poinsot.engine.llvm_ir import Function as Lines
from poinsot.engine.taylor_recurrences import HigherOrder, ZerothOrder
from poinsot.engine.taylor_schedule import Schedule

__all__ = ["QUEUE", "KernelProgram", "Momenta", "Status"]

AT_ONCE = 8
"""Polynomials that are evaluated side by side: their sums stay in registers."""

IN_REGISTERS = 12
"""States of one body of which the last coefficients stay in registers from order to order."""

QUEUE = np.dtype([(name, "i8") for name in ("next", "count", "members", "tasks", "times", "rows")])

DOUBLES = ("end", "limit", "way", "shortest", "longest", "near")
INTEGERS = ("steps", "pause", "index", "bits", "which", "rising")
"""What a lane takes of a task as it is."""


class Status(IntEnum):
    """How a task stands."""

    UNDER_WAY = 0
    DONE = 1
    NOT_FINITE = 2
    STALLED = 3
    PAUSED = 4
    GIVEN_UP = 5
    HELD = 6
    EVENT = 7
    ENDED = 8


class Momenta(NamedTuple):
    """Momenta that are rescaled by a power of two where their norm leaves a band as a step begins.

    Parameters
    ----------
    places : tuple of int
        Of the state variables whose norm it is.
    scaled : tuple of int
        Of all that go with the scale.
    powers : tuple of int
        To which power of the scale each parameter goes.
    least, most, size : float
        The band, and the size that they are given.
    bits : (int, int)
        The range of the scale over that of the start, powers of two.
    """

    places: tuple[int, ...] = ()
    scaled: tuple[int, ...] = ()
    powers: tuple[int, ...] = ()
    least: float = 0.0
    most: float = math.inf
    size: float = 1.0
    bits: tuple[int, int] = (0, 0)


class KernelProgram:
    """The text of a kernel and the types of its memory."""

    def __init__(
        self,
        decomposition: Decomposition,
        order: int,
        lanes: int,
        layout: Layout,
        momenta: Momenta,
        jumps: Jumps | None = None,
    ) -> None:
        self.schedule, self.order, self.momenta = Schedule(decomposition), order, momenta
        self.variables, self.parameters = len(decomposition.rates), decomposition.parameters
        self.layout: Batch | Single = (
            Batch(self.schedule, self.variables, order, lanes)
            if layout == "batch"
            else Single(self.schedule, self.variables, order)
        )
        lanes = self.lanes = self.layout.lanes
        self.kind, self.whole = vector(DOUBLE, lanes), vector(INTEGER, lanes)
        self.watch, self.sampling = Watch(self, decomposition), Sampling(self, jumps)
        # What happens at the end is seen in one step more.
        self._arrives = bool(self.watch.events or self.sampling.count)
        self.work, self.task, self.step = self._work_type(), self._task_type(), self._step_type()
        self.module = Module()
        self.module.function("take", "void", [POINTER, INTEGER], self._take, SELDOM)
        self.module.function("leave", "void", [POINTER, INTEGER], self._leave, SELDOM)
        self.module.function("write_row", "void", [POINTER, INTEGER], self._write_row)
        if momenta.places:
            self.module.function("fit", "void", [POINTER, INTEGER], self._fit, SELDOM)
        self.watch.define(self.module)
        self.sampling.define(self.module)
        self.module.function("evaluate", "void", [POINTER, POINTER, self.kind], self._evaluate)
        if lanes == 1:
            self.module.function("keep_step", "void", [POINTER, DOUBLE], self._keep_step)
        self.module.function("advance", INTEGER, [POINTER, INTEGER], self._advance)

    def _work_type(self) -> np.dtype[Any]:
        """Return the type of the memory of a run; vectors come first, as they are aligned."""
        lanes = self.lanes
        sizes = {
            "coefficients": (-(-self.layout.size // 8) * 8,),
            "following": (2 * self.variables, lanes),
            "row": (2 * self.variables, lanes),
            "below": (self.variables, lanes),
            "parameters": (self.parameters, lanes),
            "zeros": (len(self.schedule.zeros), lanes),
            "reciprocals": (len(self.schedule.reciprocals), lanes),
            "time": (2, lanes),
            **self.watch.fields,
            **self.sampling.fields,
        }
        doubles = (
            "end",
            "output_time",
            "limit",
            "least",
            "most",
            "outward",
            "way",
            "shortest",
            "longest",
            "near",
            "shift",
        )
        integers = (
            "active",
            "status",
            "flags",
            "steps",
            "pause",
            "task",
            "index",
            "bits",
            "which",
            "rising",
            "switched",
        )
        return np.dtype(
            [
                *((name, "f8", size) for name, size in sizes.items()),
                *((name, "f8", (lanes,)) for name in doubles),
                *((name, "i8", (lanes,)) for name in integers),
                ("reciprocals_of_orders", "f8", (self.order + 1,)),
                ("reciprocals_below", "f8", (self.order + 1,)),
                *((name, "i8") for name in ("notes", "notes_most", "noted")),
                *((name, "i8") for name in ("queue", "kept", "kept_most", "kept_count")),
            ]
        )

    def _task_type(self) -> np.dtype[Any]:
        doubles, integers = ("push", *DOUBLES), ("status", "count", "stride", "first", "place", *INTEGERS)
        return np.dtype(
            [
                ("state", "f8", (self.variables,)),
                ("below", "f8", (self.variables,)),
                ("parameters", "f8", (self.parameters,)),
                ("time", "f8", (2,)),
                ("sides", "f8", (self.watch.events,)),
                ("branches", "f8", (2, len(self.watch.conditions))),
                *self.sampling.of_tasks,
                *((name, "f8") for name in doubles),
                *((name, "i8") for name in integers),
            ]
        )

    def _step_type(self) -> np.dtype[Any]:
        coefficients = (self.order + 1, self.variables)
        return np.dtype([("task", "i8"), ("start", "f8", (2,)), ("length", "f8"), ("coefficients", "f8", coefficients)])

    def over_order(self, work: Record, n: Value) -> Callable[[Value], Value]:
        """Return the division by n, by 1/n in two parts: the rounding of one would have the same sign at every step."""
        parts = ("reciprocals_of_orders", "reciprocals_below")
        high, low = (work.array(name)[n].spread(self.lanes) for name in parts)
        return lambda value: value.fma(high, value * low)

    def _evaluate(self, address: Value, out: Value, h: Value) -> None:
        """Write the polynomials of the states at a time after the start of the step, and what their sums round off.

        What was rounded off before is added (Kahan): errors of many steps do not add up in what changes slowly.
        """
        result, below = Array(out, self.kind), Record(address, self.work).array("below", self.kind)
        for first in range(0, self.variables, AT_ONCE):
            places = range(first, min(first + AT_ONCE, self.variables))

            def body(n: Value, *sums: Value, places: range = places) -> list[Value]:
                states = self.layout.states(address, n)
                return [n - 1, *(total.fma(h, states[k]) for k, total in zip(places, sums, strict=True))]

            highest = self.layout.states(address, self.order)
            start = [h.function.constant(INTEGER, self.order - 1), *(highest[k] for k in places)]
            _, *sums = h.function.repeat(start, lambda n, *_: n.is_("ge", 1), body)
            lowest = self.layout.states(address, 0)
            for k, total in zip(places, sums, strict=True):
                change, before = total.fma(h, below[k]), lowest[k]
                after = before + change
                gained = after - before
                result[k] = after
                result[self.variables + k] = (before - (after - gained)) + (change - gained)

    def _coefficients(self, lines: Lines, work: Record) -> None:
        """Write the Taylor coefficients of the states."""
        outputs, first = ZerothOrder(self, work).outputs(), self.layout.states(work.address, 1)
        for i, rate in enumerate(outputs[: self.variables]):
            first[i] = rate
        self.watch.store(work, lines.constant(INTEGER, 0), outputs[self.variables :])

        def order(n: Value, *states: Value) -> list[Value]:
            outputs = HigherOrder(self, work, n, states).outputs()
            with lines.when(n.is_("lt", self.order)) if self.watch.count else nullcontext():
                following, over = self.layout.states(work.address, n + 1), self.over_order(work, n + 1)
                found = [over(rate) for rate in outputs[: self.variables]]
                for i, value in enumerate(found):
                    following[i] = value
            self.watch.store(work, n, outputs[self.variables :])
            return [n + 1, *(found if states else ())]

        orders = self.order + bool(self.watch.count)
        in_registers = isinstance(self.layout, Single) and self.variables <= IN_REGISTERS and not self.watch.count
        carried = outputs[: self.variables] if in_registers else []
        lines.repeat([lines.constant(INTEGER, 1), *carried], lambda n, *_: n.is_("lt", orders), order)

    def _length(self, work: Record) -> Value:
        """Return the length of a step: e^-2 of the radius of convergence by the last two coefficients (Jorba, Zou)."""
        orders = (0, self.order - 1, self.order)
        largest = []
        for order, least in zip(orders, (1.0, 1e-300, 1e-300), strict=True):
            states = self.layout.states(work.address, order)
            sizes = [abs(states[k]) for k in range(self.variables)]
            largest.append(llvm_functions.rough_log2(_in_pairs(sizes, Value.larger).larger(least)))
        radius = [(largest[0] - high) * (1 / n) for n, high in zip(orders[1:], largest[1:], strict=True)]
        return llvm_functions.rough_exp2(
            radius[0].smaller(radius[1]) + (-0.7 / (self.order - 1) - 2.0) / math.log(2.0)
        ).smaller(work.array("limit", self.kind)[0])

    def _step(self, lines: Lines, work: Record) -> None:
        """Write a step of all lanes."""
        self.sampling.step(lines, work)
        self._coefficients(lines, work)
        time, active = work.array("time", self.kind), work.array("active", self.whole)[0].is_("ne", 0)
        target = self.sampling.target(work)
        left = (target - time[0]) - time[1]
        length = self._length(work)
        last = length.is_("ge", abs(left))
        h, cut, waits, stops = self.watch.look(
            lines, work, last.choose(left, length.intrinsic("copysign", left)), active
        )
        last, arrived = last & ~cut, ~waits & left.is_("eq", 0.0)
        following, states = work.array("following", self.kind), self.layout.states(work.address, 0)
        lines.run("evaluate", work.address, following.address, h)
        moved = [following[k] for k in range(self.variables)]
        finite = _in_pairs([value * 0.0 for value in moved], Value.__add__).is_("eq", 0.0)
        finite = (finite & self.watch.defined(work)) | waits if self.watch.events else finite | waits
        goes = active & finite & ~waits & ~arrived
        seen = active & finite if self.sampling.count else goes
        if self.lanes == 1:
            with lines.when(work.array("kept", INTEGER)[0].is_("ne", 0) & goes):
                lines.run("keep_step", work.address, h)
        self._rows(lines, work, seen, h, last & goes)
        below = work.array("below", self.kind)
        for k, value in enumerate(moved):
            states[k] = goes.choose(value, states[k])
            below[k] = goes.choose(following[self.variables + k], below[k])
        stalled = self._move(work, goes, last, h, target)
        paused = self._count(work, goes, ~last & ~cut, abs(h))
        held = self.watch.held(work, waits)
        done = arrived if self._arrives else last
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
        self.for_each(lines, work, active & (~going | self._misfit(work, moved)), "leave")

    def _move(self, work: Record, goes: Value, last: Value, h: Value, target: Value) -> Value:
        """Write the time after a step, in two parts; return where it did not move."""
        time = work.array("time", self.kind)
        high, low = time[0], time[1]
        total = high + h
        part = total - high
        rest = ((high - (total - part)) + (h - part)) + low
        later = total + rest
        time[0] = goes.choose(last.choose(target, later), high)
        time[1] = goes.choose(last.choose(low * 0.0, rest - (later - total)), low)
        return goes & ~last & total.is_("eq", high)

    def _count(self, work: Record, goes: Value, whole: Value, length: Value) -> Value:
        """Count the steps and book their lengths; return where it is time to pause."""
        steps, counted = work.array("steps", self.whole), goes & whole
        shortest, longest = work.array("shortest", self.kind), work.array("longest", self.kind)
        steps[0] = steps[0] + goes.to_integer()
        shortest[0] = counted.choose(shortest[0].smaller(length), shortest[0])
        longest[0] = counted.choose(longest[0].larger(length), longest[0])
        return steps[0].is_("ge", work.array("pause", self.whole)[0])

    def _misfit(self, work: Record, states: Sequence[Value]) -> Value:
        """Return where the norm of the momenta is out of the band."""
        if not self.momenta.places:
            return states[0].is_("lt", -math.inf)
        square = self._norm([states[k] for k in self.momenta.places])
        least, most = work.array("least", self.kind)[0], work.array("most", self.kind)[0]
        return (square.is_("lt", least) & square.is_("gt", 0.0)) | square.is_("gt", most)

    @staticmethod
    def _norm(momenta: Sequence[Value]) -> Value:
        """Return the square of a norm."""
        return functools.reduce(lambda total, m: m.fma(m, total), momenta[1:], momenta[0] * momenta[0])

    def _rows(self, lines: Lines, work: Record, goes: Value, h: Value, last: Value) -> None:
        """Write the rows of the output times within a step; of one up to a sample the next step writes the last."""
        time, row = work.array("time", self.kind), work.array("row", self.kind)

        def due() -> list[Value]:
            ahead = (work.array("output_time", self.kind)[0] - time[0]) - time[1]
            within = abs(ahead).is_("le", abs(h))
            if self.sampling.count:
                within = within & ~(last & ahead.is_("eq", h))
            return [ahead, goes & within]

        def write(ahead: Value, which: Value) -> list[Value]:
            lines.run("evaluate", work.address, row.address, which.choose(ahead, 0.0))
            for k in self.momenta.scaled:
                row[k] = row[k] * work.array("outward", self.kind)[0]
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

    def _write_row(self, address: Value, lane: Value) -> None:
        """Write a row of a lane, and turn to its next output time."""
        work, lines = Record(address, self.work), address.function
        queue, task = Record(work.array("queue", POINTER)[0], QUEUE), self._task(work, lane)
        index, rows = work.array("index", INTEGER), Array(queue.array("rows", POINTER)[0], DOUBLE)
        place = task.array("place", INTEGER)[0] + index[lane] * task.array("stride", INTEGER)[0]
        out = rows.at(place * self.variables)
        self._copy(lines, self.variables, work.array("row"), lane, Array(out, DOUBLE))
        index[lane] = index[lane] + 1
        self._look_ahead(work, task, lane)

    def _look_ahead(self, work: Record, task: Record, lane: Value) -> None:
        """Set the next output time of a lane, infinity if it has none."""
        lines, index = lane.function, work.array("index", INTEGER)[lane]
        queue = Record(work.array("queue", POINTER)[0], QUEUE)
        times = Array(queue.array("times", POINTER)[0], DOUBLE)

        def ahead() -> list[Value]:
            return [times[task.array("first", INTEGER)[0] + index * task.array("stride", INTEGER)[0]]]

        none = [lines.constant(DOUBLE, math.inf)]
        (following,) = lines.either(index.is_("lt", task.array("count", INTEGER)[0]), none, ahead)
        work.array("output_time")[lane] = following

    def _task(self, work: Record, lane: Value) -> Record:
        queue = Record(work.array("queue", POINTER)[0], QUEUE)
        tasks = Array(queue.array("tasks", POINTER)[0], f"[{self.task.itemsize} x i8]")
        return Record(tasks.at(work.array("task", INTEGER)[lane]), self.task)

    def _copy(self, lines: Lines, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy the numbers of a lane to memory without gaps."""

        def one(k: Value) -> None:
            out[k] = source[k * self.lanes + lane]

        lines.count(count, one)

    def _spread(self, lines: Lines, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy numbers to those of a lane."""

        def one(k: Value) -> None:
            out[k * self.lanes + lane] = source[k]

        lines.count(count, one)

    def _take(self, address: Value, lane: Value) -> None:
        """Give a lane the next task of the queue, if there is one."""
        work, lines = Record(address, self.work), address.function
        queue = Record(work.array("queue", POINTER)[0], QUEUE)
        place = lines.new(INTEGER, f"atomicrmw add ptr {queue.array('next').address.name}, i64 1 monotonic")
        work.array("active", INTEGER)[lane] = 0
        with lines.when(place.is_("lt", queue.array("count", INTEGER)[0])):
            work.array("active", INTEGER)[lane] = 1
            work.array("switched", INTEGER)[lane] = 0
            work.array("task", INTEGER)[lane] = Array(queue.array("members", POINTER)[0], INTEGER)[place]
            task = self._task(work, lane)
            for count, name, out in (
                (self.variables, "state", self.layout.states(address, 0).of(DOUBLE)),
                (self.variables, "below", work.array("below")),
                (self.parameters, "parameters", work.array("parameters")),
                (2, "time", work.array("time")),
                (self.watch.events, "sides", work.array("sides")),
                (len(self.watch.conditions), "branches", work.array("branches")),
            ):
                self._spread(lines, count, task.array(name), lane, out)
            for name in DOUBLES:
                work.array(name)[lane] = task.array(name)[0]
            for name in INTEGERS:
                work.array(name, INTEGER)[lane] = task.array(name, INTEGER)[0]
            self._look_ahead(work, task, lane)
            self.sampling.take(work, task, lane)
            if self.momenta.places:
                self._scale_states(work, lane, work.array("bits", INTEGER)[lane])
                self._scale_parameters(work, task, lane)
                lines.run("fit", address, lane)

    def _leave(self, address: Value, lane: Value) -> None:
        """Let a lane leave its task and take another one, or rescale its momenta."""
        work, lines = Record(address, self.work), address.function
        status = work.array("status", INTEGER)[lane]
        with lines.when(status.is_("ne", 0)):
            task = self._task(work, lane)
            if self.momenta.places:
                self._scale_states(work, lane, 0 - work.array("bits", INTEGER)[lane])
            self._copy(lines, self.variables, self.layout.states(address, 0).of(DOUBLE), lane, task.array("state"))
            self._copy(lines, self.variables, work.array("below"), lane, task.array("below"))
            self._copy(lines, 2, work.array("time"), lane, task.array("time"))
            self._copy(lines, self.watch.events, work.array("sides"), lane, task.array("sides"))
            self._copy(lines, len(self.watch.conditions), work.array("branches"), lane, task.array("branches"))
            for i, place in enumerate(self.watch.conditions):
                held = work.array("parameters")[lane + place * self.lanes]
                task.array("branches")[len(self.watch.conditions) + i] = held
            self.sampling.leave(work, task, lane)
            for name in ("shortest", "longest", "near"):
                task.array(name)[0] = work.array(name)[lane]
            for name in ("status", "steps", "index", "bits", "which", "rising"):
                task.array(name, INTEGER)[0] = work.array(name, INTEGER)[lane]
            lines.run("take", address, lane)
        if self.momenta.places:
            with lines.when(status.is_("eq", 0)):
                lines.run("fit", address, lane)

    def _scale_states(self, work: Record, lane: Value, bits: Value) -> None:
        """Multiply what goes with the scale of momenta by a power of two."""
        states, factor = self.layout.states(work.address, 0).of(DOUBLE), _power_of_two(bits)
        for array in (states, work.array("below")):
            for k in self.momenta.scaled:
                array[lane + k * self.lanes] = array[lane + k * self.lanes] * factor

    def _scale_parameters(self, work: Record, task: Record, lane: Value) -> None:
        """Set the parameters and the limits of the band for the scale of a lane."""
        least, most, (fewest, largest) = self.momenta.least, self.momenta.most, self.momenta.bits
        bits = work.array("bits", INTEGER)[lane]
        source, out = task.array("parameters"), work.array("parameters")
        for first, count, power in _runs(self.momenta.powers):

            def scale(i: Value, first: int = first, power: int = power) -> None:
                number = source[i + first]
                for _ in range(abs(power)):
                    number = number * _power_of_two(bits if power > 0 else 0 - bits)
                out[(i + first) * self.lanes + lane] = number

            if power:
                lane.function.count(count, scale)
        work.array("outward")[lane] = _power_of_two(0 - bits)
        # No other scale is better at the ends of its range, or where forces give a body at rest as much.
        pushed = (task.array("push")[0] * _power_of_two(bits)).is_("ge", least)
        zero = lane.function.constant(DOUBLE, 0.0)
        work.array("least")[lane] = (pushed | bits.is_("ge", largest)).choose(zero, least**2)
        infinite = lane.function.constant(DOUBLE, math.inf)
        work.array("most")[lane] = bits.is_("le", fewest).choose(infinite, most**2)

    def _fit(self, address: Value, lane: Value) -> None:
        """Choose the scale of a lane anew if its momenta are out of the band."""
        work, lines = Record(address, self.work), address.function
        states = self.layout.states(address, 0).of(DOUBLE)
        momenta = [states[lane + k * self.lanes] for k in self.momenta.places]
        square, task = self._norm(momenta), self._task(work, lane)
        bits = work.array("bits", INTEGER)[lane]
        low = square.is_("lt", work.array("least")[lane]) & square.is_("gt", 0.0)
        size = _in_pairs([abs(m) for m in momenta], Value.larger)
        size = size.larger(task.array("push")[0] * _power_of_two(bits))
        misfit = (low | square.is_("gt", work.array("most")[lane])) & size.is_("lt", math.inf)
        with lines.when(misfit):
            change = (math.log2(self.momenta.size) - lines.call(DOUBLE, "log2", size)).intrinsic("rint").to_integer()
            fewest, most = self.momenta.bits
            chosen = (bits + change).larger(fewest).smaller(most)
            work.array("bits", INTEGER)[lane] = chosen
            self._scale_states(work, lane, chosen - bits)
            self._scale_parameters(work, task, lane)

    def _keep_step(self, address: Value, h: Value) -> None:
        """Keep the coefficients of a step, in the scale of the start."""
        work, lines = Record(address, self.work), address.function
        count = work.array("kept_count", INTEGER)
        steps = Array(work.array("kept", POINTER)[0], f"[{self.step.itemsize} x i8]")
        step = Record(steps.at(count[0]), self.step)
        count[0] = count[0] + 1
        step.array("task", INTEGER)[0] = work.array("task", INTEGER)[0]
        step.array("length")[0] = h
        for part in (0, 1):
            step.array("start")[part] = work.array("time")[part]

        def order(n: Value) -> None:
            states = self.layout.states(address, n)
            out = Array(step.array("coefficients").at(n * self.variables), DOUBLE)
            for k in range(self.variables):
                out[k] = states[k] * work.array("outward")[0] if k in self.momenta.scaled else states[k]

        lines.count(self.order + 1, order)

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


def _runs(keys: Sequence[Any]) -> list[tuple[int, int, Any]]:
    """Return where equal neighbours begin, how many they are, and what they are: what is done to them is one loop."""
    groups = [(key, len(list(group))) for key, group in itertools.groupby(keys)]
    starts = itertools.accumulate((count for _, count in groups), initial=0)
    return [(first, count, key) for first, (key, count) in zip(starts, groups, strict=False)]


def _power_of_two(bits: Value) -> Value:
    return ((bits + 1023) << 52).as_double()


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
