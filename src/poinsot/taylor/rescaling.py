"""Momenta of a kernel that grow or fall by much: powers of two are taken out of them, for each lane its own."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any

from poinsot.taylor.decomposition import Momenta
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, SELDOM, Array, Module, Record, Value

__all__ = ["BITS", "LEAST", "MOST", "SMALL", "Rescaling"]


SMALL = 0.1
"""The size given to the momenta: below that of q, so that the step control, which looks at the largest variable, keeps
its grip on the attitude."""

LEAST, MOST = SMALL / 16, 1.0
"""The band of momenta where a step begins, outside of which the scale is chosen anew."""

BITS = (-400, 400)
"""The range of the scale over that of the start, powers of two: nothing overflows, and who comes to rest may rest."""


class Rescaling:
    """The part of a kernel that rescales momenta.

    Attributes
    ----------
    scaled : tuple of int
        The state variables that go with the scale.
    """

    def __init__(self, kernel: Any, momenta: Momenta) -> None:
        self._kernel, self._momenta, self._lanes = kernel, momenta, kernel.lanes
        self.scaled = momenta.scaled

    def define(self, module: Module) -> None:
        """Write the function that it needs."""
        if self._momenta.places:
            module.function("fit", "void", [POINTER, INTEGER], self._fit, SELDOM)

    def take(self, work: Record, task: Record, lane: Value) -> None:
        """Turn the variables of a lane from the scale of the start to that of its task."""
        if self._momenta.places:
            self._scale_states(work, lane, work.array("bits", INTEGER)[lane])
            self._scale_parameters(work, task, lane)
            self.fit(work, lane)

    def leave(self, work: Record, lane: Value) -> None:
        """Turn them back."""
        if self._momenta.places:
            self._scale_states(work, lane, 0 - work.array("bits", INTEGER)[lane])

    def fit(self, work: Record, lane: Value) -> None:
        """Rescale a lane if its momenta are out of the band."""
        if self._momenta.places:
            lane.function.run("fit", work.address, lane)

    def outwards(self, work: Record, k: int, value: Value, place: Value | int = 0) -> Value:
        """Return a variable, or a derivative of it, in the scale of the start."""
        return value.times_power_of_two(work.array("outward", str(value.type))[place]) if k in self.scaled else value

    def misfit(self, work: Record, states: Sequence[Value]) -> Value:
        """Return where the norm of the momenta is out of the band."""
        if not self._momenta.places:
            return states[0].is_("lt", -math.inf)
        return self._is_outside(work, [states[k].high for k in self._momenta.places], 0)

    @staticmethod
    def _is_outside(work: Record, momenta: Sequence[Value], place: Value | int) -> Value:
        square = _dot(momenta, momenta)
        least, most = (work.array(name, square.type)[place] for name in ("least", "most"))
        return (square.is_("lt", least) & square.is_("gt", 0.0)) | square.is_("gt", most)

    def _scale_states(self, work: Record, lane: Value, bits: Value) -> None:
        """Multiply what goes with the scale of momenta by a power of two."""
        factor = _power_of_two(bits)
        for array in (self._kernel.layout.states(work.address, 0).of(DOUBLE), work.array("below")):
            for k in self.scaled:
                array[lane + k * self._lanes] = array[lane + k * self._lanes].times_power_of_two(factor)

    def _scale_parameters(self, work: Record, task: Record, lane: Value) -> None:
        """Set the parameters and the limits of the band for the scale of a lane."""
        fewest, largest = BITS
        bits = work.array("bits", INTEGER)[lane]
        source, out = task.array("parameters"), work.array("parameters")
        for first, count, power in _runs(self._momenta.powers):

            def scale(i: Value, first: int = first, power: int = power) -> None:
                number = source[i + first]
                for _ in range(abs(power)):
                    number = number * _power_of_two(bits if power > 0 else 0 - bits)
                out[(i + first) * self._lanes + lane] = number

            if power:
                lane.function.count(count, scale)
                if self._kernel.wide:
                    lane.function.count(count, functools.partial(scale, first=first + self._kernel.parameters))
        work.array("outward")[lane] = _power_of_two(0 - bits)
        # No other scale is better at the ends of its range, or where forces give a body at rest as much.
        pushed = (task.array("push")[0] * _power_of_two(bits)).is_("ge", LEAST)
        zero = lane.function.constant(DOUBLE, 0.0)
        work.array("least")[lane] = (pushed | bits.is_("ge", largest)).choose(zero, LEAST**2)
        infinite = lane.function.constant(DOUBLE, math.inf)
        work.array("most")[lane] = bits.is_("le", fewest).choose(infinite, MOST**2)

    def _fit(self, address: Value, lane: Value) -> None:
        """Choose the scale of a lane anew if its momenta are out of the band."""
        work, lines = Record(address, self._kernel.work), address.function
        states = self._kernel.layout.states(address, 0).of(DOUBLE)
        momenta = [states[lane + k * self._lanes].high for k in self._momenta.places]
        task, bits = self._kernel.tasks.of(work, lane), work.array("bits", INTEGER)[lane]
        pushed = task.array("push")[0] * _power_of_two(bits)
        size = functools.reduce(Value.larger, [*map(abs, momenta), pushed])
        with lines.when(self._is_outside(work, momenta, lane) & size.is_("lt", math.inf)):
            change = (math.log2(SMALL) - lines.call(DOUBLE, "log2", size)).intrinsic("rint").to_integer()
            with lines.when(change.is_("gt", 0)):
                self._drop_normal(states, lane)
            chosen = (bits + change).larger(BITS[0]).smaller(BITS[1])
            work.array("bits", INTEGER)[lane] = chosen
            self._scale_states(work, lane, chosen - bits)
            self._scale_parameters(work, task, lane)

    def _drop_normal(self, states: Array, lane: Value) -> None:
        """Take what is along the quaternions out of their conjugate momenta."""
        for places in self._momenta.conjugates:
            q, Q = ([states[lane + (first + k) * self._lanes] for k in range(4)] for first in places)
            share = _dot(q, Q) / _dot(q, q)
            for k in range(4):
                states[lane + (places[1] + k) * self._lanes] = Q[k] - share * q[k]


def _dot(a: Sequence[Value], b: Sequence[Value]) -> Value:
    pairs = zip(a[1:], b[1:], strict=True)
    return functools.reduce(lambda total, pair: pair[0].fma(pair[1], total), pairs, a[0] * b[0])


def _runs(keys: Sequence[Any]) -> list[tuple[int, int, Any]]:
    """Return where equal neighbours begin, how many they are, and what they are: what is done to them is one loop."""
    groups = [(key, len(list(group))) for key, group in itertools.groupby(keys)]
    starts = itertools.accumulate((count for _, count in groups), initial=0)
    return [(first, count, key) for first, (key, count) in zip(starts, groups, strict=False)]


def _power_of_two(bits: Value) -> Value:
    return ((bits + 1023) << 52).as_double()
