"""Tasks of a kernel: lanes take them from a queue, write their rows and leave them, as they are then."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any

import numpy as np

from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, SELDOM, Array, Module, Record, Value, WideValue

__all__ = ["QUEUE", "Status", "Tasks"]

QUEUE = np.dtype([(name, "i8") for name in ("next", "count", "members", "tasks", "times", "rows")])


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


class Tasks:
    """The part of a kernel that turns to tasks.

    Attributes
    ----------
    fields : list
        What lanes have of their tasks, in one order there and here: names, types and shapes. They give back all that
        is behind the parameters and the pause.
    type, step : structured types
        Of a task, and of a step that is kept.
    """

    def __init__(self, kernel: Any) -> None:
        self._kernel = kernel
        self.fields = [
            ("parameters", "f8", (kernel.words * kernel.parameters,)),
            ("pause", "i8", ()),
            ("below", "f8", (kernel.variables,)),
            ("time", "f8", (2,)),
            ("unit", "f8", (kernel.words - 1,)),
            *kernel.watch.of_tasks,
            *kernel.sampling.of_tasks,
            *((name, "f8", ()) for name in ("end", "limit", "way", "near")),
            *((name, "i8", ()) for name in ("steps", "index", "bits")),
            *kernel.watch.marks,
            ("status", "i8", ()),
        ]
        self._taken = np.dtype(self.fields).itemsize // 8
        self._given_back = self._taken - kernel.words * kernel.parameters - 1
        self.type = np.dtype(
            [
                ("state", "f8", (kernel.variables,)),
                *self.fields,
                ("behind", "f8", (len(kernel.watch.conditions),)),
                ("push", "f8"),
                *((name, "i8") for name in ("count", "stride", "first", "place")),
            ]
        )
        coefficients = "coefficients", "f8", (kernel.order + 1, kernel.variables)
        below = "below", "f8", (kernel.wide * (kernel.order + 1), kernel.variables)
        numbers = [("start", "f8", (2,)), ("length", "f8"), ("per_unit", "f8")]
        self.step = np.dtype([("task", "i8"), *numbers, coefficients, below])

    def define(self, module: Module) -> None:
        """Write the functions that it needs."""
        module.function("take", "void", [POINTER, INTEGER], self._take, SELDOM)
        module.function("leave", "void", [POINTER, INTEGER], self._leave, SELDOM)
        module.function("write_row", "void", [POINTER, INTEGER], self._write_row)
        if self._kernel.lanes == 1:
            module.function("keep_step", "void", [POINTER, DOUBLE], self._keep_step)

    def of(self, work: Record, lane: Value) -> Record:
        """Return the task of a lane."""
        tasks = Array(_queue(work).array("tasks", POINTER)[0], f"[{self.type.itemsize} x i8]")
        return Record(tasks.at(work.array("task", INTEGER)[lane]), self.type)

    def _write_row(self, address: Value, lane: Value) -> None:
        """Write a row of a lane, and turn to its next output time."""
        work = Record(address, self._kernel.work)
        task, index = self.of(work, lane), work.array("index", INTEGER)
        rows = Array(_queue(work).array("rows", POINTER)[0], DOUBLE)
        place = task.array("place", INTEGER)[0] + index[lane] * task.array("stride", INTEGER)[0]
        out = rows.at(place * self._kernel.variables)
        self._copy(self._kernel.variables, work.array("row"), lane, Array(out, DOUBLE))
        index[lane] = index[lane] + 1
        self._look_ahead(work, task, lane)

    def _look_ahead(self, work: Record, task: Record, lane: Value) -> None:
        """Set the next output time of a lane, infinity if it has none."""
        lines, index = lane.function, work.array("index", INTEGER)[lane]
        times = Array(_queue(work).array("times", POINTER)[0], DOUBLE)

        def ahead() -> list[Value]:
            return [times[task.array("first", INTEGER)[0] + index * task.array("stride", INTEGER)[0]]]

        none = [lines.constant(DOUBLE, math.inf)]
        (following,) = lines.either(index.is_("lt", task.array("count", INTEGER)[0]), none, ahead)
        work.array("output_time")[lane] = following

    def _states(self, work: Record) -> Any:
        return self._kernel.layout.states(work.address, 0).of(DOUBLE)

    def _copy(self, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy the numbers of a lane to memory without gaps."""

        def one(k: Value) -> None:
            out[k] = source[k * self._kernel.lanes + lane]

        lane.function.count(count, one)

    def _spread(self, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy numbers to those of a lane."""

        def one(k: Value) -> None:
            out[k * self._kernel.lanes + lane] = source[k]

        lane.function.count(count, one)

    def _take(self, address: Value, lane: Value) -> None:
        """Give a lane the next task of the queue, if there is one."""
        work, lines = Record(address, self._kernel.work), address.function
        queue = _queue(work)
        place = lines.new(INTEGER, f"atomicrmw add ptr {queue.array('next').address.name}, i64 1 monotonic")
        work.array("active", INTEGER)[lane] = 0
        with lines.when(place.is_("lt", queue.array("count", INTEGER)[0])):
            work.array("active", INTEGER)[lane] = 1
            work.array("switched", INTEGER)[lane] = 0
            work.array("task", INTEGER)[lane] = Array(queue.array("members", POINTER)[0], INTEGER)[place]
            task = self.of(work, lane)
            self._spread(self._kernel.variables, task.array("state"), lane, self._states(work).high)
            self._spread(self._taken, task.array("parameters", INTEGER), lane, work.array("parameters", INTEGER))
            if self._kernel.wide:
                self._spread(self._kernel.variables, task.array("below"), lane, self._states(work).low)
                below = work.array("below")
                lines.count(self._kernel.variables, lambda k: below.__setitem__(k * self._kernel.lanes + lane, 0.0))
            self._look_ahead(work, task, lane)
            self._kernel.sampling.take(work, lane)
            self._kernel.momenta.take(work, task, lane)

    def _leave(self, address: Value, lane: Value) -> None:
        """Let a lane leave its task and take another one, or rescale its momenta."""
        work, lines = Record(address, self._kernel.work), address.function
        status = work.array("status", INTEGER)[lane]
        with lines.when(status.is_("ne", 0)):
            task = self.of(work, lane)
            self._kernel.momenta.leave(work, lane)
            self._copy(self._kernel.variables, self._states(work).high, lane, task.array("state"))
            self._copy(self._given_back, work.array("below", INTEGER), lane, task.array("below", INTEGER))
            if self._kernel.wide:
                self._copy(self._kernel.variables, self._states(work).low, lane, task.array("below"))
            for i, place in enumerate(self._kernel.watch.conditions):
                task.array("behind")[i] = work.array("parameters")[lane + place * self._kernel.lanes]
            lines.run("take", address, lane)
        with lines.when(status.is_("eq", 0)):
            self._kernel.momenta.fit(work, lane)

    def _keep_step(self, address: Value, h: Value) -> None:
        """Keep the coefficients of a step, in the scale of the start."""
        work, lines = Record(address, self._kernel.work), address.function
        count = work.array("kept_count", INTEGER)
        steps = Array(work.array("kept", POINTER)[0], f"[{self.step.itemsize} x i8]")
        step = Record(steps.at(count[0]), self.step)
        count[0] = count[0] + 1
        step.array("task", INTEGER)[0] = work.array("task", INTEGER)[0]
        step.array("length")[0] = h
        step.array("per_unit")[0] = self._kernel.per_unit(work, h.like(1.0))
        for part in (0, 1):
            step.array("start")[part] = work.array("time")[part]

        def order(n: Value) -> None:
            states = self._kernel.layout.states(address, n)
            out, low = (
                Array(step.array(name).at(n * self._kernel.variables), DOUBLE) for name in ("coefficients", "below")
            )
            for k in range(self._kernel.variables):
                value = self._kernel.momenta.outwards(work, k, states[k])
                out[k] = value.high
                if isinstance(value, WideValue):
                    low[k] = value.low

        lines.count(self._kernel.order + 1, order)


def _queue(work: Record) -> Record:
    return Record(work.array("queue", POINTER)[0], QUEUE)
