"""What a kernel does at samples: steps end at the next one, where variables get new values, and the loop goes on."""

from __future__ import annotations

import functools
import math
from typing import Any

from poinsot.taylor.draws import UNUSED, uniform, words
from poinsot.taylor.formula_code import written
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Module, Record, Value, Wide
from poinsot.taylor.llvm_ir import Function as Lines
from poinsot.taylor.updates import Jumps, Update

__all__ = ["Sampling"]

NO_JUMPS = Jumps([], [], [], 0)

OF_TASKS = ("numbers", "periods", "phases")


class Sampling:
    """The part of a kernel that jumps.

    Attributes
    ----------
    count : int
        How many parts jump.
    targets : list of str
        The time at which a step ends for the next jump, by its name in the memory of a run.
    of_tasks : list
        The fields that a lane and a task have for it: of each sample its number, the time between two and that of
        number 0, and the key of the numbers drawn.
    """

    def __init__(self, kernel: Any, jumps: Jumps | None) -> None:
        self._kernel, self._jumps, self._lanes = kernel, jumps or NO_JUMPS, kernel.lanes
        self.count = count = len(self._jumps.updates)
        self.targets = ["sample"] if count else []
        self.of_tasks = [*((name, "f8", (count,)) for name in OF_TASKS), ("keys", "i8", (count,))]

    def define(self, module: Module) -> None:
        """Write the functions that it needs."""
        if self.count:
            module.function("next_sample", "void", [POINTER, INTEGER], self._next_sample)
            module.function("jump", "void", [POINTER, INTEGER], self._jump)

    def take(self, work: Record, lane: Value) -> None:
        """Look ahead to the next samples of a lane."""
        if self.count:
            lane.function.run("next_sample", work.address, lane)

    def target(self, work: Record) -> Value:
        """Return the time at which a step ends at the latest: the end of the task, or a sample before it."""
        end = work.array("end", self._kernel.kind)[0]
        return end.smaller(work.array("sample", self._kernel.kind)[0]) if self.count else end

    def step(self, lines: Lines, work: Record) -> None:
        """Let the lanes jump that have come to a sample."""
        if self.count:
            kind = self._kernel.kind
            time, active = work.array("time", kind), work.array("active", self._kernel.whole)[0].is_("ne", 0)
            due = active & time[0].is_("eq", work.array("sample", kind)[0]) & time[1].is_("eq", 0.0)
            self._kernel.for_each(lines, work, due, "jump")

    def _next_sample(self, address: Value, lane: Value) -> None:
        """Set the time of the next sample of a lane."""
        work = Record(address, self._kernel.work)
        times = [self._time(work, lane + j * self._lanes) for j in range(self.count)]
        work.array("sample")[lane] = functools.reduce(Value.smaller, times)

    @staticmethod
    def _time(work: Record, place: Value) -> Value:
        number, period, phase = (work.array(name)[place] for name in OF_TASKS)
        return number * period + phase

    def _jump(self, address: Value, lane: Value) -> None:
        """Give the variables of a lane their new values, one part after another."""
        work, lines = Record(address, self._kernel.work), address.function
        time = work.array("time")[lane]
        for j, update in enumerate(self._jumps.updates):
            place = lane + j * self._lanes
            with lines.when(self._time(work, place).is_("eq", time)):
                self._update(work, lane, update, place)
                number = work.array("numbers")
                number[place] = number[place] + 1.0
        for i in range(len(self._kernel.watch.conditions)):  # what switches now does so with the sample
            work.array("branches")[lane + i * self._lanes] = math.nan
        lines.run("next_sample", address, lane)

    def _update(self, work: Record, lane: Value, update: Update, place: Value) -> None:
        """Give some variables of a lane their new values."""
        jumps, size = self._jumps, self._kernel.variables
        states = self._kernel.layout.states(work.address, 0).of(DOUBLE)
        below = work.array("below")
        number = Wide(DOUBLE) if self._kernel.wide else DOUBLE
        parameters = work.array("parameters", self._kernel.number).of(DOUBLE)
        known = {
            node.place: parameters[lane + (jumps.first + i) * self._lanes] for i, node in enumerate(jumps.constants)
        }
        known |= {node.place: states[lane + k * self._lanes] for k, node in enumerate(jumps.own[:size])}
        known[jumps.own[size].place] = work.array("time", self._kernel.number).of(DOUBLE)[lane]
        drawn = self._drawn(work, place, len(update.draws))
        zero = lane.function.constant(number, 0.0)
        known |= {node.place: zero.like(each) for node, each in zip(update.draws, drawn, strict=True)}
        for k, value in zip(update.places, written(lane.function, known, update.values, number), strict=True):
            states[lane + k * self._lanes] = value
            below[lane + k * self._lanes] = 0.0

    @staticmethod
    def _drawn(work: Record, place: Value, count: int) -> list[Value]:
        """Return uniform numbers for the next sample of a lane."""
        key, number = work.array("keys", INTEGER)[place], work.array("numbers")[place].to_integer()
        found = words(key, number, count) if count else []
        return [uniform((word >> UNUSED).to_double()) for word in found]
