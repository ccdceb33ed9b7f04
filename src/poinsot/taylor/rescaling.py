"""Momenta of a kernel that grow or fall by much: powers of two are taken out of them, for each lane its own.

A lane computes with momenta m 2^e, where e is its scale exponent. The momenta of a task, its rows, its stored steps and
its recorded events are in the scale of the start, e = 0. Parameters are powers of the scale (`Momenta.powers`).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence

from typing_extensions import override

from poinsot.taylor.decomposition import Momenta
from poinsot.taylor.graph import GraphScalar, Node, ordered
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Array, Structure, Value
from poinsot.taylor.memory import Context, KernelPart, Work

__all__ = ["EXPONENT_RANGE", "MAX_MOMENTUM", "MIN_MOMENTUM", "MOMENTUM_SCALE", "Rescaling", "powers_of"]


MOMENTUM_SCALE = 0.1
"""The size given to the momenta: below that of q, so that the step control, which looks at the largest variable, keeps
its grip on the attitude."""

MIN_MOMENTUM, MAX_MOMENTUM = MOMENTUM_SCALE / 16, 1.0
"""The band of momenta where a step begins, outside of which the scale is chosen anew."""

EXPONENT_RANGE = (-400, 400)
"""Range of the scale exponent. Within it nothing overflows, and a body that comes to rest may rest."""


POWERS: Mapping[str, Callable[[float, float, GraphScalar], float]] = {
    "add": lambda a, b, _: a or b,
    "neg": lambda a, _, __: a,
    "mul": lambda a, b, _: a + b,
    "div": lambda a, b, _: a - b,
    "pow": lambda a, _, exponent: a * float(exponent) if not isinstance(exponent, Node) else 0,
    "sqrt": lambda a, _, __: a / 2,
}
"""The power of the result of an operation, from the powers of its operands and its second operand, a number."""


def powers_of(parameters: Sequence[Node]) -> tuple[int, ...]:
    """Return the powers of the first input, the scale of momenta, in parameters: all are homogeneous in it."""
    powers: dict[int, float] = {}
    for node in ordered(parameters):
        if node.name in POWERS:
            first, second = (*node.operands, *node.operands)[:2]
            a, b = (powers[x.place] if isinstance(x, Node) else 0 for x in (first, second))
            powers[node.place] = POWERS[node.name](a, b, second)
        else:
            powers[node.place] = node.name == "input" and node.operands == (0,)
    return tuple([int(powers[node.place]) for node in parameters])


class Rescaling(KernelPart):
    """The part of a kernel that rescales momenta.

    Fields: `exponent`, the scale exponent of a task or a lane; `torque_scale`, the momenta that forces give a body at
    rest; `least` and `most`, the squares of the limits of the band; `outward`, the factor to the scale of the start.
    """

    of_tasks_and_lanes = [("exponent", "i8", ())]  # noqa: RUF012
    of_tasks = [("torque_scale", "f8", ())]  # noqa: RUF012
    of_lanes = [(name, "f8", ()) for name in ("least", "most", "outward")]  # noqa: RUF012

    def __init__(self, context: Context, momenta: Momenta) -> None:
        super().__init__(context)
        self._momenta = momenta
        self.seldom = {"rescale": self._rescale} if momenta.places else {}

    @override
    def taken(self, work: Work, task: Structure, lane: Value) -> None:
        """Convert the variables of a lane from the scale of the start to the scale of its task."""
        if self._momenta.places:
            self._scale_states(work, lane, work.array("exponent", INTEGER)[lane])
            self._scale_parameters(work, task, lane)
            self.stayed(work, lane)

    @override
    def left(self, work: Work, task: Structure, lane: Value) -> None:
        """Convert them back."""
        if self._momenta.places:
            self._scale_states(work, lane, 0 - work.array("exponent", INTEGER)[lane])

    @override
    def stayed(self, work: Work, lane: Value) -> None:
        """Rescale a lane if its momenta are out of the band."""
        if self._momenta.places:
            lane.function.run("rescale", work.address, lane)

    def misfit(self, work: Work, states: Sequence[Value]) -> Value:
        """Return where the norm of the momenta is out of the band."""
        if not self._momenta.places:
            return states[0].is_("lt", -math.inf)
        return self._is_outside(work, [states[k].high for k in self._momenta.places], 0)

    @staticmethod
    def _is_outside(work: Work, momenta: Sequence[Value], place: Value | int) -> Value:
        square = _dot(momenta, momenta)
        least, most = (work.array(name, square.type)[place] for name in ("least", "most"))
        return (square.is_("lt", least) & square.is_("gt", 0.0)) | square.is_("gt", most)

    def _scale_states(self, work: Work, lane: Value, exponent: Value) -> None:
        """Multiply the variables that are proportional to the scale by a power of two."""
        factor, lanes = _power_of_two(exponent), self.context.lanes
        for array in (work.states(0).of(DOUBLE), work.array("below")):
            for k in self.context.scaled:
                array[lane + k * lanes] = array[lane + k * lanes].times_power_of_two(factor)

    def _scale_parameters(self, work: Work, task: Structure, lane: Value) -> None:
        """Set the parameters and the limits of the band for the scale of a lane."""
        exponent, (least, most) = work.array("exponent", INTEGER)[lane], EXPONENT_RANGE
        source, out = task.array("parameters"), work.array("parameters")
        for first, count, power in _runs(self._momenta.powers):

            def scale(i: Value, first: int = first, power: int = power) -> None:
                number = source[i + first]
                for _ in range(abs(power)):
                    number = number * _power_of_two(exponent if power > 0 else 0 - exponent)
                out[(i + first) * self.context.lanes + lane] = number

            if power:
                lane.function.count(count, scale)
                if self.context.wide:
                    lane.function.count(count, functools.partial(scale, first=first + self.context.parameters))
        work.array("outward")[lane] = _power_of_two(0 - exponent)
        # No other scale is better at the ends of its range, or where forces give a body at rest as much.
        pushed = (task.array("torque_scale")[0] * _power_of_two(exponent)).is_("ge", MIN_MOMENTUM)
        zero, infinite = (lane.function.constant(DOUBLE, limit) for limit in (0.0, math.inf))
        work.array("least")[lane] = (pushed | exponent.is_("ge", most)).choose(zero, MIN_MOMENTUM**2)
        work.array("most")[lane] = exponent.is_("le", least).choose(infinite, MAX_MOMENTUM**2)

    def _rescale(self, work: Work, lane: Value) -> None:
        """Choose the scale of a lane anew if its momenta are out of the band."""
        states = work.states(0).of(DOUBLE)
        momenta = [states[lane + k * self.context.lanes].high for k in self._momenta.places]
        task, exponent = work.task(lane), work.array("exponent", INTEGER)[lane]
        pushed = task.array("torque_scale")[0] * _power_of_two(exponent)
        size = functools.reduce(Value.larger, [*map(abs, momenta), pushed])
        with work.lines.when(self._is_outside(work, momenta, lane) & size.is_("lt", math.inf)):
            change = (math.log2(MOMENTUM_SCALE) - work.lines.call(DOUBLE, "log2", size)).rint().to_integer()
            with work.lines.when(change.is_("gt", 0)):
                self._drop_normal(states, lane)
            chosen = (exponent + change).larger(EXPONENT_RANGE[0]).smaller(EXPONENT_RANGE[1])
            work.array("exponent", INTEGER)[lane] = chosen
            self._scale_states(work, lane, chosen - exponent)
            self._scale_parameters(work, task, lane)

    def _drop_normal(self, states: Array, lane: Value) -> None:
        """Remove from conjugate momenta their parts along their quaternions."""
        for places in self._momenta.conjugates:
            q, Q = ([states[lane + (first + k) * self.context.lanes] for k in range(4)] for first in places)
            share = _dot(q, Q) / _dot(q, q)
            for k in range(4):
                states[lane + (places[1] + k) * self.context.lanes] = Q[k] - share * q[k]


def _dot(a: Sequence[Value], b: Sequence[Value]) -> Value:
    pairs = zip(a[1:], b[1:], strict=True)
    return functools.reduce(lambda total, pair: pair[0].fma(pair[1], total), pairs, a[0] * b[0])


def _runs(keys: Sequence[int]) -> list[tuple[int, int, int]]:
    """Return the place of the first of equal neighbours, their count, and their value: one loop computes them."""
    groups = [(key, len(list(group))) for key, group in itertools.groupby(keys)]
    starts = itertools.accumulate((count for _, count in groups), initial=0)
    return [(first, count, key) for first, (key, count) in zip(starts, groups, strict=False)]


def _power_of_two(exponent: Value) -> Value:
    return ((exponent + 1023) << 52).as_double()
