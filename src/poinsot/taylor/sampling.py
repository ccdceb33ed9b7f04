"""Sampling in a kernel: a step ends at the next sample, where variables jump to new values."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

from typing_extensions import override

from poinsot.random_numbers import UNUSED_BITS, uniform, words
from poinsot.taylor.evaluation import written
from poinsot.taylor.graph import GraphScalar, Node
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Structure, Value, Wide
from poinsot.taylor.memory import Body, Context, KernelPart, Work

__all__ = ["SAMPLE", "Jumps", "Sampling", "Update"]

SAMPLE = "sample"
"""The field of a lane with the time of its next sample."""

SAMPLE_FIELDS = ("numbers", "periods", "offsets")
"""Fields of the samples of each part: number of the next one, time between two, and time of number 0."""


class Update(NamedTuple):
    """The new values of some variables, at their places, and the symbols of the uniform numbers drawn for them."""

    places: list[int]
    values: list[GraphScalar]
    draws: list[Node]


@dataclass(frozen=True, eq=False)
class Jumps:
    """The formulas of all updates, in the order in which they are done at one time.

    Parameters
    ----------
    own : list of Node
        The variables and, behind them, the time.
    updates : list of Update
    constants : list of Node
        Constants of the formulas: parameters of a kernel, the first of them number `first`.
    first : int
    """

    own: list[Node]
    updates: list[Update]
    constants: list[Node]
    first: int


class Sampling(KernelPart):
    """The part of a kernel that evaluates the formulas of updates between two steps.

    Fields: `SAMPLE_FIELDS`; `keys`, the keys of the numbers drawn; `sample`.

    Parameters
    ----------
    jumped : callable
        Writes the actions after a jump of the variables of a lane.

    Attributes
    ----------
    count : int
        Number of the parts that jump.
    """

    def __init__(self, context: Context, jumps: Jumps | None, jumped: Body) -> None:
        super().__init__(context)
        self._jumped, self.count = jumped, len(jumps.updates) if jumps else 0
        count = (self.count,)
        self.of_tasks_and_lanes = [*((name, "f8", count) for name in SAMPLE_FIELDS), ("keys", "i8", count)]
        self.of_lanes = [(SAMPLE, "f8", ())]
        if jumps:
            self.functions = {"next_sample": self._next_sample, "jump": functools.partial(self._jump, jumps)}

    @override
    def taken(self, work: Work, task: Structure, lane: Value) -> None:
        if self.count:
            lane.function.run("next_sample", work.address, lane)

    def target(self, work: Work) -> Value:
        """Return the time at which a step ends at the latest: the end of the task, or a sample before it."""
        end = work.doubles("end")[0]
        return end.smaller(work.doubles(SAMPLE)[0]) if self.count else end

    def step(self, work: Work) -> None:
        """Update the variables of the lanes that are at a sample."""
        if self.count:
            time, active = work.doubles("time"), work.active
            due = active & time[0].is_("eq", work.doubles(SAMPLE)[0]) & time[1].is_("eq", 0.0)
            work.for_each(due, "jump")

    def _next_sample(self, work: Work, lane: Value) -> None:
        """Set the time of the next sample of a lane."""
        times = [self._time(work, lane + j * self.context.lanes) for j in range(self.count)]
        work.array(SAMPLE)[lane] = functools.reduce(Value.smaller, times)

    @staticmethod
    def _time(work: Work, place: Value) -> Value:
        number, period, offset = (work.array(name)[place] for name in SAMPLE_FIELDS)
        return number * period + offset

    def _jump(self, jumps: Jumps, work: Work, lane: Value) -> None:
        """Update the variables of a lane, one part after another."""
        time = work.array("time")[lane]
        for j, update in enumerate(jumps.updates):
            place = lane + j * self.context.lanes
            with work.lines.when(self._time(work, place).is_("eq", time)):
                self._update(jumps, work, lane, update, place)
                number = work.array("numbers")
                number[place] = number[place] + 1.0
        self._jumped(work, lane)
        work.lines.run("next_sample", work.address, lane)

    def _update(self, jumps: Jumps, work: Work, lane: Value, update: Update, place: Value) -> None:
        """Set some variables of a lane to their new values."""
        size, lanes, below = self.context.variables, self.context.lanes, work.array("below")
        number = Wide(DOUBLE) if self.context.wide else DOUBLE
        states, parameters = work.states(0).of(DOUBLE), work.numbers("parameters").of(DOUBLE)
        known = {node.place: parameters[lane + (jumps.first + i) * lanes] for i, node in enumerate(jumps.constants)}
        known |= {node.place: states[lane + k * lanes] for k, node in enumerate(jumps.own[:size])}
        known[jumps.own[size].place] = work.numbers("time").of(DOUBLE)[lane]
        drawn, zero = self._drawn(work, place, len(update.draws)), lane.function.constant(number, 0.0)
        known |= {node.place: zero.like(each) for node, each in zip(update.draws, drawn, strict=True)}
        for k, value in zip(update.places, written(lane.function, known, update.values, number), strict=True):
            states[lane + k * lanes] = value
            below[lane + k * lanes] = 0.0

    @staticmethod
    def _drawn(work: Work, place: Value, count: int) -> list[Value]:
        """Return uniform numbers for the next sample of a lane."""
        key, number = work.array("keys", INTEGER)[place], work.array("numbers")[place].to_integer()
        found = words(key, number, count) if count else []
        return [uniform((word >> UNUSED_BITS).to_double()) for word in found]
