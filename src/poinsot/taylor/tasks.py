"""Tasks of a kernel: lanes take them from a queue, write their rows, and leave them with a status."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Array, Structure, Value, WideValue
from poinsot.taylor.memory import Context, KernelPart, Work

__all__ = ["Status", "Tasks"]


class Status(IntEnum):
    """Why a lane leaves its task. If several reasons hold, the kernel chooses the one that comes last in this table.

    | status | reason | how the run continues |
    |---|---|---|
    | UNDER_WAY | the task waits or is in a lane | the kernel integrates it |
    | PAUSED | the task has taken `pause` steps | with a larger `pause`, after a look at its progress |
    | HELD | conditions switch without end: the motion leads back from both sides | the task failed |
    | EVENT | an event or a switch with `stops` is at the start of the step | after its action or jump |
    | STALLED | a step does not change the time | the task failed |
    | DONE | the time is `end` | with the next interval between breakpoints, if there is one |
    | NOT_FINITE | variables or values of events are not finite | the task failed |

    The kernel itself sets no other status. A run gives a task up (GIVEN_UP) if its steps lead nowhere or an action
    fails, and ends it (ENDED) at a terminal event.
    """

    UNDER_WAY = 0
    DONE = 1
    NOT_FINITE = 2
    STALLED = 3
    PAUSED = 4
    GIVEN_UP = 5
    HELD = 6
    EVENT = 7
    ENDED = 8


class Tasks(KernelPart):
    """The functions of a kernel that take and leave tasks.

    Parameters
    ----------
    context : Context
    parts : sequence of KernelPart
        Parts with fields of tasks and of lanes.

    Attributes
    ----------
    fields : list
        Fields that tasks and lanes have in common, in one order. A lane copies all of them when it takes a task, and
        copies those behind the parameters and the pause back when it leaves the task.
    type, step : structured types
        Task, and stored step.
    """

    of_lanes = [*((name, "i8", ()) for name in ("active", "flags", "task")), ("output_time", "f8", ())]  # noqa: RUF012
    of_workers = [(name, "i8", ()) for name in ("queue", "stored_steps", "stored_limit", "stored_count")]  # noqa: RUF012

    def __init__(self, context: Context, parts: Sequence[KernelPart]) -> None:
        super().__init__(context)
        self._parts = parts
        numbers = context.words * context.parameters
        self.fields = [
            ("parameters", "f8", (numbers,)),
            ("pause", "i8", ()),
            ("below", "f8", (context.variables,)),
            ("time", "f8", (2,)),
            ("unit", "f8", (context.words - 1,)),
            *(field for part in parts for field in part.of_tasks_and_lanes),
            *((name, "f8", ()) for name in ("end", "limit", "way")),
            *((name, "i8", ()) for name in ("steps", "index", "status")),
        ]
        self._taken = np.dtype(self.fields).itemsize // 8
        self._given_back = self._taken - numbers - 1
        self.type = np.dtype(
            [
                ("state", "f8", (context.variables,)),
                *self.fields,
                *(field for part in parts for field in part.of_tasks),
                *((name, "i8", ()) for name in ("count", "stride", "first", "place")),
            ]
        )
        self.step = np.dtype(
            [
                ("task", "i8"),
                ("start", "f8", (2,)),
                *((name, "f8") for name in ("length", "per_unit")),
                ("coefficients", "f8", (context.order + 1, context.variables)),
                ("below", "f8", (context.wide * (context.order + 1), context.variables)),
            ]
        )
        self.functions = {"write_row": self._write_row}
        self.seldom = {"take": self._take, "leave": self._leave}

    def store_steps(self, work: Work, moved: Value, h: Value) -> None:
        """Store a step of the only lane if it moves and the worker stores steps."""
        if self.context.lanes == 1:
            with work.lines.when(work.array("stored_steps", INTEGER)[0].is_("ne", 0) & moved):
                work.lines.run("store_step", work.address, h.high)

    def has_room(self, work: Work) -> Value:
        """Return the mask where there is room for another stored step."""
        return work.array("stored_count", INTEGER)[0].is_("lt", work.array("stored_limit", INTEGER)[0])

    def fill(self, work: Work, lane: Value) -> None:
        """Take a task in a lane that has none."""
        with work.lines.when(work.array("active", INTEGER)[lane].is_("eq", 0)):
            work.lines.run("take", work.address, lane)

    def _write_row(self, work: Work, lane: Value) -> None:
        """Write a row of a lane, and find its next output time."""
        task, index = work.task(lane), work.array("index", INTEGER)
        rows = Array(work.queue().array("rows", POINTER)[0], DOUBLE)
        place = task.array("place", INTEGER)[0] + index[lane] * task.array("stride", INTEGER)[0]
        out = rows.at(place * self.context.variables)
        self._copy(self.context.variables, work.array("row"), lane, Array(out, DOUBLE))
        index[lane] = index[lane] + 1
        self._look_ahead(work, task, lane)

    @staticmethod
    def _look_ahead(work: Work, task: Structure, lane: Value) -> None:
        """Set the next output time of a lane, infinity after the last output time."""
        lines, index = lane.function, work.array("index", INTEGER)[lane]
        times = Array(work.queue().array("times", POINTER)[0], DOUBLE)

        def ahead() -> list[Value]:
            return [times[task.array("first", INTEGER)[0] + index * task.array("stride", INTEGER)[0]]]

        none = [lines.constant(DOUBLE, math.inf)]
        (following,) = lines.either(index.is_("lt", task.array("count", INTEGER)[0]), none, ahead)
        work.array("output_time")[lane] = following

    def _copy(self, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy the numbers of a lane to memory without gaps."""
        lanes = self.context.lanes
        lane.function.count(count, lambda k: out.__setitem__(k, source[k * lanes + lane]))

    def _spread(self, count: int, source: Array, lane: Value, out: Array) -> None:
        """Copy numbers to the memory of a lane."""
        lanes = self.context.lanes
        lane.function.count(count, lambda k: out.__setitem__(k * lanes + lane, source[k]))

    def _take(self, work: Work, lane: Value) -> None:
        """Take the next task of the queue in a lane, if there is one."""
        lines, queue = work.lines, work.queue()
        place = lines.new(INTEGER, f"atomicrmw add ptr {queue.array('next').address.name}, i64 1 monotonic")
        work.array("active", INTEGER)[lane] = 0
        with lines.when(place.is_("lt", queue.array("count", INTEGER)[0])):
            work.array("active", INTEGER)[lane] = 1
            work.array("task", INTEGER)[lane] = Array(queue.array("members", POINTER)[0], INTEGER)[place]
            task, size, lanes = work.task(lane), self.context.variables, self.context.lanes
            states = work.states(0).of(DOUBLE)
            self._spread(size, task.array("state"), lane, states.high)
            self._spread(self._taken, task.array("parameters", INTEGER), lane, work.array("parameters", INTEGER))
            if self.context.wide:
                self._spread(size, task.array("below"), lane, states.low)
                below = work.array("below")
                lines.count(size, lambda k: below.__setitem__(k * lanes + lane, 0.0))
            self._look_ahead(work, task, lane)
            for part in self._parts:
                part.taken(work, task, lane)

    def _leave(self, work: Work, lane: Value) -> None:
        """Leave the task of a lane and take another one if it has a status; otherwise let the parts change the lane."""
        status = work.array("status", INTEGER)[lane]
        with work.lines.when(status.is_("ne", Status.UNDER_WAY)):
            task, states = work.task(lane), work.states(0).of(DOUBLE)
            for part in self._parts:
                part.left(work, task, lane)
            self._copy(self.context.variables, states.high, lane, task.array("state"))
            self._copy(self._given_back, work.array("below", INTEGER), lane, task.array("below", INTEGER))
            if self.context.wide:
                self._copy(self.context.variables, states.low, lane, task.array("below"))
            work.lines.run("take", work.address, lane)
        with work.lines.when(status.is_("eq", Status.UNDER_WAY)):
            for part in self._parts:
                part.stayed(work, lane)

    def store_step(self, work: Work, h: Value) -> None:
        """Store the coefficients of a step of the only lane, in the scale of the start."""
        count = work.array("stored_count", INTEGER)
        step = Structure.of(work.array("stored_steps", POINTER)[0], count[0], self.context.step)
        count[0] = count[0] + 1
        step.array("task", INTEGER)[0] = work.array("task", INTEGER)[0]
        step.array("length")[0] = h
        step.array("per_unit")[0] = work.per_unit(h.like(1.0))
        for part in (0, 1):
            step.array("start")[part] = work.array("time")[part]

        def order(n: Value) -> None:
            states = work.states(n)
            out, low = (
                Array(step.array(name).at(n * self.context.variables), DOUBLE) for name in ("coefficients", "below")
            )
            for k in range(self.context.variables):
                value = work.unscaled(k, states[k])
                out[k] = value.high
                if isinstance(value, WideValue):
                    low[k] = value.low

        work.lines.count(self.context.order + 1, order)
