"""The context of a kernel: its sizes, the memory of a worker, and the interface of the parts of a kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from poinsot.taylor.layouts import Batch, Single
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Array, Structure, Value, Wide, WideValue, vector

__all__ = ["QUEUE", "Body", "Context", "Field", "Part", "Types", "Work"]

QUEUE = np.dtype([(name, "i8") for name in ("next", "count", "members", "tasks", "times", "rows")])
"""The record of a queue: counts and addresses."""

Field = tuple[str, str, tuple[int, ...]]
"""A field of a structure in memory: name, NumPy type and shape."""


@dataclass(frozen=True)
class Context:
    """Sizes of a kernel.

    Parameters
    ----------
    order : int
        Degree of the Taylor polynomials.
    wide : bool
        Whether numbers are double-double.
    variables, parameters : int
        Numbers of state variables and of parameters of a member.
    layout : Batch or Single
        Places of the Taylor coefficients.
    """

    order: int
    wide: bool
    variables: int
    parameters: int
    layout: Batch | Single

    @property
    def lanes(self) -> int:
        """Members in a vector."""
        return self.layout.lanes

    @property
    def words(self) -> int:
        """Doubles in a number."""
        return 1 + self.wide

    @property
    def kind(self) -> str:
        """Type of a vector of doubles, one for each lane."""
        return vector(DOUBLE, self.lanes)

    @property
    def whole(self) -> str:
        """Type of a vector of integers."""
        return vector(INTEGER, self.lanes)

    @property
    def number(self) -> str:
        """Type of a vector of numbers in the precision of the kernel."""
        return Wide(self.kind) if self.wide else self.kind


class Types(NamedTuple):
    """Structures in memory: the memory of a worker, and a task."""

    work: np.dtype[np.void]
    task: np.dtype[np.void]


class Work(Structure):
    """The memory of a worker, seen by the functions of a kernel.

    Fields of lanes are vectors with one element for each lane. A function of all lanes reads whole vectors (`doubles`,
    `integers`, `numbers`); a function of one lane reads elements (`array`).
    """

    def __init__(self, address: Value, context: Context, types: Types) -> None:
        super().__init__(address, types.work)
        self.context, self._task = context, types.task
        self.lines = address.function

    def doubles(self, name: str) -> Array:
        """Return a field as vectors of doubles."""
        return self.array(name, self.context.kind)

    def integers(self, name: str) -> Array:
        """Return a field as vectors of integers."""
        return self.array(name, self.context.whole)

    def numbers(self, name: str) -> Array:
        """Return a field as vectors of numbers in the precision of the kernel."""
        return self.array(name, self.context.number)

    @property
    def active(self) -> Value:
        """Mask of the lanes that have a task."""
        return self.integers("active")[0].is_("ne", 0)

    def states(self, n: Value | int) -> Array:
        """Return the coefficients of order n of the state variables."""
        return self.context.layout.states(self.address, n)

    def queue(self) -> Structure:
        """Return the record of the queue."""
        return Structure(self.array("queue", POINTER)[0], QUEUE)

    def task(self, lane: Value) -> Structure:
        """Return the task of a lane."""
        tasks = Array(self.queue().array("tasks", POINTER)[0], f"[{self._task.itemsize} x i8]")
        return Structure(tasks.at(self.array("task", INTEGER)[lane]), self._task)

    def in_unit(self, rate: Value) -> Value:
        """Return a rate, per unit of time of the Taylor coefficients.

        In quadruple precision the unit is about the radius of convergence, so that powers of it neither overflow nor
        lose digits at order 38. Rates have the unit 1 in double precision.
        """
        return rate.times_power_of_two(self.doubles("unit")[0]) if self.context.wide else rate

    def per_unit(self, time: Value) -> Value:
        """Return a time in that unit, or a rate from one in that unit."""
        return time.times_power_of_two(1.0 / self.doubles("unit")[0]) if self.context.wide else time

    def over_order(self, n: Value) -> Callable[[Value], Value]:
        """Return the division by n, by 1/n in two parts: the rounding of one would have the same sign at every step."""
        parts = ("reciprocals_of_orders", "reciprocals_below")
        high, low = (self.array(name)[n].spread(self.context.lanes) for name in parts)
        if self.context.wide:
            return lambda value: value * WideValue(high, low)
        return lambda value: value.fma(high, value * low)

    def ahead(self, target: Value) -> Value:
        """Return the time from the start of the step to a time."""
        time = self.doubles("time")
        if self.context.wide:
            return WideValue(target, target.like(0.0)) - WideValue(time[0], time[1])
        return (target - time[0]) - time[1]

    def for_each(self, which: Value, name: str) -> None:
        """Call a function of one lane for the lanes of a mask."""
        lines = self.lines
        with lines.when(which.any()):
            flags = self.integers("flags")
            flags[0] = which.to_integer()

            def one(lane: Value) -> None:
                with lines.when(flags.of(INTEGER)[lane].is_("ne", 0)):
                    lines.run(name, self.address, lane)

            lines.count(self.context.lanes, one)


Body = Callable[[Work, Value], None]
"""The body of a function of one lane: it writes the instructions for the memory of a worker and a lane."""


class Part:
    """A part of a kernel: its fields in memory, its functions, and what it does where lanes change their tasks.

    Attributes
    ----------
    polynomials : dict
        Vectors of doubles in the memory of a worker that stand in front, and their shapes without lanes.
    of_tasks_and_lanes : sequence of Field
        Fields of a task that a lane copies when it takes the task, and copies back when it leaves the task.
    of_tasks, of_lanes, of_workers : sequence of Field
        Fields of tasks alone, of lanes alone, and of a worker.
    functions, seldom : dict
        Functions of one lane by their names: those of steps, and those that run once a task or less.
    """

    polynomials: Mapping[str, tuple[int, ...]] = {}
    of_tasks_and_lanes: Sequence[Field] = ()
    of_tasks: Sequence[Field] = ()
    of_lanes: Sequence[Field] = ()
    of_workers: Sequence[Field] = ()
    functions: Mapping[str, Body] = {}
    seldom: Mapping[str, Body] = {}

    def __init__(self, context: Context) -> None:
        self.context = context

    def taken(self, work: Work, task: Structure, lane: Value) -> None:
        """Write what a lane does when it has taken a task."""

    def stayed(self, work: Work, lane: Value) -> None:
        """Write what a lane does that stays in its task although it has stopped in `leave`."""

    def left(self, work: Work, task: Structure, lane: Value) -> None:
        """Write what a lane does before it copies its fields back to its task."""
