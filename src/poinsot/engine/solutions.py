"""Paths of orbits, integrated for numbers."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.program import Graph
from poinsot.engine.heyoka_expressions import Expressions
from poinsot.engine.kernels import PRECISIONS, available
from poinsot.engine.lowering import TIME, Program, lowered
from poinsot.mechanics.environment import OrbitBlock

__all__ = ["path"]

Array = NDArray[Any]

WIDEST: Any = PRECISIONS["extended" if available("extended") else "double"]


class Path:
    """The variables of the block of an orbit from a start, of one body or of members, integrated as far as was asked.

    A time has the same result whatever was asked before: steps are those of the engine from the start on.

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
                out[:, chosen] = self._branch(direction, WIDEST(far)).at(member[chosen], time[chosen])
        return out

    def _branch(self, direction: int, far: Any) -> _Branch:
        known = self._branches.get(direction)
        if known is None or known.far < far:
            far = far if known is None else 2 * far  # so that a loop over times integrates but a few times
            self._branches[direction] = known = self._integrated(direction, far)
        return known

    def _integrated(self, direction: int, far: Any) -> _Branch:
        engine, program = _integrator(self._block)
        numbers = program.values(functools.partial(np.asarray, dtype=WIDEST))(self._block.numbers)
        table = np.array(np.broadcast_arrays(*numbers, *self._start), dtype=WIDEST).reshape(-1, self._members.size)
        pieces = [
            _pieces(engine, column[: len(numbers)], column[len(numbers) :], direction * far) for column in table.T
        ]
        lengths = [len(times) for times, _ in pieces]
        times, series = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
        return _Branch(far, np.cumsum([0, *lengths]), times, series.T)


path = Path
"""As orbits know it."""


@dataclass(frozen=True)
class _Branch:
    """Taylor series forwards or backwards, those of one member after another's.

    The last one of each member is NaN, for times after the last that the integration reached.
    """

    far: Any
    firsts: NDArray[np.int_]
    begins: Array
    series: Array

    def at(self, member: NDArray[np.int_], time: Array) -> Array:
        """Return the variables of members at times."""
        place, after = self.firsts[member], self.firsts[member + 1]
        while np.any(after - place > 1):
            middle = (place + after) // 2
            later = np.abs(self.begins[middle]) < np.abs(time)
            place, after = np.where(later, middle, place), np.where(later, after, middle)
        since = time - self.begins[place]
        total: Array = self.series[-1][:, place]
        for coefficients in self.series[-2::-1]:
            total = total * since + coefficients[:, place]
        return total


def _integrator(block: OrbitBlock) -> tuple[Any, Program]:
    graph = Graph()
    twin, variables = block.with_numbers(map(graph.input, itertools.count())), [*map(graph.symbol, range(block.size))]
    program = lowered(list(twin.rates_at(graph.symbol(TIME), variables)))
    made, zeros = Expressions(program.decomposition), np.zeros(block.size, WIDEST)
    equations = list(zip(made.symbols, made.rates, strict=True))
    return hy.taylor_adaptive(equations, zeros, tol=np.finfo(WIDEST).eps, fp_type=WIDEST), program


def _pieces(engine: Any, parameters: Array, start: Array, end: Any) -> tuple[Array, Array]:
    """Return where steps begin, (n,), and their coefficients, (n, variables, order + 1); the last are NaN."""
    begins, series = [WIDEST(0)], []

    def keep(engine: Any) -> bool:
        series.append(engine.tc.copy())
        begins.append(engine.time)
        return bool(begins[-1] != begins[-2])  # at a collision steps fall to rounding

    engine.state[:], engine.pars[:], engine.time = start, parameters, WIDEST(0)
    engine.propagate_until(end, callback=keep, write_tc=True)
    return np.array(begins), np.array([*series, np.full_like(engine.tc, np.nan)])
