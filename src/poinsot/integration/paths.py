"""Paths of orbits, integrated for numbers."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.double_double import DoubleDouble
from poinsot.integration.equations import known
from poinsot.integration.looped_runs import ROUNDING
from poinsot.mechanics.environment import OrbitBlock
from poinsot.taylor import kernels
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph
from poinsot.taylor.kernels import Code
from poinsot.taylor.lowering import TIME, Events, simplified
from poinsot.taylor.queue import Output, Queue, Worker

__all__ = ["path"]

Array = NDArray[Any]

WIDE_ORDERS = 8
"""Orders that are summed in double-double arithmetic. Terms of order n are e^(-2 n) of the variables at the end of a
step, so that rounding errors of higher orders are below 1e-22."""


COLLISION = 2.0**-53
"""Steps shorter than this part of the time lead so close to an attractor that rounding errors change the energy."""


class Path:
    """The variables of the block of an orbit from a start, of one body or of members, in quadruple precision.

    A time has the same result in any order of calls: the steps begin at the start.

    Parameters
    ----------
    block : OrbitBlock
        Its rates do not depend on the time.
    start : sequence of scalars or arrays
    """

    def __init__(self, block: OrbitBlock, start: Sequence[Any]) -> None:
        self._block, self._given = block, start
        self._start = np.array(np.broadcast_arrays(*start, *block.numbers)[: block.size])
        self._members = np.arange(self._start[0].size).reshape(self._start[0].shape)
        self._branches: dict[int, _Branch] = {}

    def __reduce__(self) -> Any:  # a copy integrates anew
        return type(self), (self._block, self._given)

    def __call__(self, elapsed: Any) -> Array:
        """Return the variables at times since the start that broadcast with the members; NaN beyond a collision."""
        member, time = np.broadcast_arrays(self._members, elapsed)
        kind = np.result_type(self._start, time)
        out = np.array([np.broadcast_to(x, time.shape) for x in self._start], dtype=kind)
        for direction, chosen in ((1, ~(time <= 0)), (-1, time < 0)):
            if np.any(chosen):
                far = np.max(np.abs(time[chosen]), where=np.isfinite(time[chosen]), initial=0)
                found = self._branch(direction, float(far)).at(member[chosen], time[chosen])
                out[:, chosen] = found.hi.astype(kind) + found.lo
        return out

    def _branch(self, direction: int, far: float) -> _Branch:
        reached = self._branches.get(direction)
        if reached is None or reached.far < far:
            far = far if reached is None else 2 * far  # so that a loop over times integrates few times
            self._branches[direction] = reached = self._integrated(direction, far)
        return reached

    def _integrated(self, direction: int, far: float) -> _Branch:
        members = self._members.size
        kernel = known(("path", self._block.structure), lambda: _kernel(self._block))
        parameters = np.array(np.broadcast_arrays(*kernel.values(self._block.numbers), self._start[0].ravel())[:-1])
        parameters = parameters.T.reshape(members, -1)
        start = self._start.reshape(len(self._start), -1).T
        states = start.astype(float)
        first, counts, stride = np.zeros(members, int), np.ones(members, int), np.full(members, direction)
        rows = np.empty((members, 1, len(self._start)))
        output = Output.of(np.array([direction * far]), rows, np.arange(members), first, counts, stride)
        queue = Queue(kernel.code, states, np.zeros(1), parameters, output)
        queue.tasks["below"] = start - states
        run = Worker(kernel.code, stores_steps=True)
        run.start(queue)
        while run.advance():
            pass
        return _Branch.of(far, np.concatenate(run.steps), queue.tasks["time"])


path = Path
"""As orbits know it."""


class _Kernel(NamedTuple):
    """The kernel of a block, and the computation of its parameters from the numbers of the block."""

    code: Code
    values: WideEvaluator


def _kernel(block: OrbitBlock) -> _Kernel:
    graph = Graph()
    twin, variables = block.with_numbers(map(graph.input, itertools.count())), [*map(graph.symbol, range(block.size))]
    program = simplified(list(twin.rates_at(graph.symbol(TIME), variables)), (), Events())
    order = kernels.order_of(ROUNDING["quadruple"], True)
    code = kernels.compiled(program.decomposition, order, 1, "single", True)
    return _Kernel(code, WideEvaluator(program.parameters))


@dataclass(frozen=True)
class _Branch:
    """Taylor series forwards or backwards, ordered by member.

    The last one of each member is NaN, for times after the last that the integration reached.
    """

    far: float
    firsts: NDArray[np.int_]
    begins: DoubleDouble
    per_unit: NDArray[np.float64]
    series: list[DoubleDouble]

    @classmethod
    def of(cls, far: float, steps: Array, ends: Array) -> _Branch:
        """Return the branch from the steps of all members, and the times that these reached, (members, 2)."""
        collided = np.abs(steps["length"]) <= COLLISION * np.abs(steps["start"][:, 0])
        ends = ends.copy()
        for step in steps[collided][::-1]:  # the first one of each member last
            ends[step["task"]] = step["start"]
        steps = steps[np.abs(steps["start"][:, 0]) < np.abs(ends[steps["task"], 0])]
        lengths = np.bincount(steps["task"], minlength=len(ends))
        last = np.zeros(len(ends), steps.dtype)
        last["task"], last["start"] = np.arange(len(ends)), ends
        last["per_unit"], last["coefficients"] = 1.0, np.nan
        steps = np.concatenate([steps, last])
        steps = steps[np.argsort(steps["task"], kind="stable")]
        parts = (np.moveaxis(steps[name], 0, -1).copy() for name in ("coefficients", "below"))
        series = [DoubleDouble(high, low) for high, low in zip(*parts, strict=True)]
        return cls(
            far, np.cumsum([0, *(lengths + 1)]), DoubleDouble(*steps["start"].T.copy()), steps["per_unit"], series
        )

    def at(self, member: NDArray[np.int_], time: Array) -> DoubleDouble:
        """Return the variables of members at times, shape (variables, n)."""
        place, after = self.firsts[member], self.firsts[member + 1]
        while np.any(after - place > 1):
            middle = (place + after) // 2
            later = np.abs(self.begins.hi[middle]) < np.abs(time)
            place, after = np.where(later, middle, place), np.where(later, after, middle)
        high, begin = time.astype(float), DoubleDouble(self.begins.hi[place], self.begins.lo[place])
        elapsed = DoubleDouble(high, (time - high).astype(float)) - begin
        since = elapsed.scaled(self.per_unit[place])
        total: Any = 0.0
        for coefficients in self.series[:WIDE_ORDERS:-1]:
            total = total * since.hi + coefficients.hi[:, place]
        for coefficients in self.series[WIDE_ORDERS::-1]:
            total = since * total + DoubleDouble(coefficients.hi[:, place], coefficients.lo[:, place])
        found: DoubleDouble = total
        return found
