"""Solutions of autonomous equations at any time, integrated in double-double arithmetic."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from poinsot.double_double import DoubleDouble
from poinsot.functions import Vector
from poinsot.taylor import kernels
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph, Node
from poinsot.taylor.kernels import MAX_KERNELS, ROUNDING, Code
from poinsot.taylor.lowering import TIME, simplified
from poinsot.taylor.queue import Doubles, Integers, Output, Queue, Records, Worker

__all__ = ["Path", "VectorField"]

Reals: TypeAlias = NDArray[np.floating]
"""An array of doubles or of long doubles."""

DOUBLE_DOUBLE_ORDERS = 8
"""Orders that are summed in double-double arithmetic. Terms of order n are e^(-2 n) of the variables at the end of a
step, so that rounding errors of higher orders are below 1e-22."""

COLLISION_STEP = 2.0**-53
"""Steps shorter than this part of the time lead so close to a singularity that rounding errors change the path."""


class VectorField(Protocol):
    """Time derivatives of variables as formulas of the variables and of real parameters."""

    @property
    def structure(self) -> Hashable:
        """Key of the formulas: fields with equal keys differ in their parameters alone."""

    @property
    def numbers(self) -> tuple[Doubles, ...]:
        """The real parameters, each of shape () or (members,)."""

    @property
    def size(self) -> int:
        """Number of variables."""

    def with_numbers(self, scalars: Iterable[Node]) -> VectorField:
        """Return the field with each parameter replaced by the next scalar."""

    def rates_at(self, time: Node, own: Sequence[Node]) -> Vector:
        """Return the time derivatives of the variables."""


class Path:
    """Solution of a vector field at any time, for one initial state or for members, in quadruple precision.

    The steps begin at the initial state. The result at a time therefore does not depend on earlier calls.

    Parameters
    ----------
    field : VectorField
        Its rates must not depend on the time.
    start : sequence of scalars or arrays (members,)
        The initial variables.
    """

    def __init__(self, field: VectorField, start: Sequence[Doubles]) -> None:
        self._field, self._given = field, start
        self._start = np.array(np.broadcast_arrays(*start, *field.numbers)[: field.size])
        self._members = np.arange(self._start[0].size).reshape(self._start[0].shape)
        self._branches: dict[int, _Branch] = {}

    def __reduce__(self) -> tuple[type[Path], tuple[VectorField, Sequence[Doubles]]]:  # a copy integrates again
        return type(self), (self._field, self._given)

    def __call__(self, elapsed: Reals) -> Reals:
        """Return the variables, first axis, at times since the start; NaN beyond a singularity.

        The times broadcast with the members.
        """
        member, time = np.broadcast_arrays(self._members, elapsed)
        kind = np.result_type(self._start, time)
        out = np.array([np.broadcast_to(x, time.shape) for x in self._start], dtype=kind)
        for direction, chosen in ((1, ~(time <= 0)), (-1, time < 0)):
            if np.any(chosen):
                far = _not_less(np.max(np.abs(time[chosen]), where=np.isfinite(time[chosen]), initial=0))
                found = self._branch(direction, far).at(member[chosen], time[chosen])
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
        code, evaluator = _compiled(_Equations(self._field.structure, self._field))
        parameters = np.array(np.broadcast_arrays(*evaluator(self._field.numbers), self._start[0].ravel())[:-1])
        parameters = parameters.T.reshape(members, -1)
        start = self._start.reshape(len(self._start), -1).T
        states = start.astype(float)
        first, counts, stride = np.zeros(members, int), np.ones(members, int), np.full(members, direction)
        rows = np.empty((members, 1, len(self._start)))
        output = Output.of(np.array([direction * far]), rows, np.arange(members), first, counts, stride)
        queue = Queue(code, states, np.zeros(1), parameters, output)
        queue.tasks["below"] = start - states
        run = Worker(code, stores_steps=True)
        run.start(queue)
        while run.advance():
            pass
        return _Branch.of(far, np.concatenate(run.steps), queue.tasks["time"])


def _not_less(time: np.floating) -> float:
    """Return the smallest double that is not less than a time, which may be a long double."""
    rounded = float(time)
    return rounded if rounded >= time else float(np.nextafter(rounded, np.inf))


@dataclass(frozen=True)
class _Equations:
    """The formulas of a vector field, equal for fields that differ in their parameters alone."""

    structure: Hashable
    field: VectorField = field(compare=False)


@functools.lru_cache(MAX_KERNELS)
def _compiled(equations: _Equations) -> tuple[Code, WideEvaluator]:
    """Return the kernel that integrates a vector field, and the evaluator of its parameters."""
    graph, field = Graph(), equations.field
    traced, variables = field.with_numbers(map(graph.input, itertools.count())), [*map(graph.symbol, range(field.size))]
    program = simplified(list(traced.rates_at(graph.symbol(TIME), variables)))
    order = kernels.order_of(ROUNDING["quadruple"], True)
    code = kernels.compiled(program.decomposition, order, 1, "single", True)
    return code, WideEvaluator(program.parameters)


@dataclass(frozen=True)
class _Branch:
    """Taylor series forwards or backwards in time, ordered by member.

    The last series of each member is NaN, for times after the last time that the integration reached.

    Attributes
    ----------
    far : float
        The longest time since the start that the branch was integrated for.
    firsts : array (members + 1,)
        The place of the first series of each member.
    begins : DoubleDouble (n,)
        The time since the start at which each series begins.
    per_unit : array (n,)
        The inverse of the unit of time of each series.
    series : list of DoubleDouble (variables, n)
        The coefficients of each order.
    """

    far: float
    firsts: Integers
    begins: DoubleDouble
    per_unit: Doubles
    series: list[DoubleDouble]

    @classmethod
    def of(cls, far: float, steps: Records, ends: Doubles) -> _Branch:
        """Return the branch from the steps of all members, and the times that these reached, (members, 2)."""
        collided = np.abs(steps["length"]) <= COLLISION_STEP * np.abs(steps["start"][:, 0])
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

    def at(self, member: Integers, time: Reals) -> DoubleDouble:
        """Return the variables of members at times, shape (variables, n)."""
        place, after = self.firsts[member], self.firsts[member + 1]
        while np.any(after - place > 1):
            middle = (place + after) // 2
            later = np.abs(self.begins.hi[middle]) < np.abs(time)
            place, after = np.where(later, middle, place), np.where(later, after, middle)
        high, begin = time.astype(float), DoubleDouble(self.begins.hi[place], self.begins.lo[place])
        elapsed = DoubleDouble(high, (time - high).astype(float)) - begin
        since = elapsed.scaled(self.per_unit[place])
        tail = np.zeros(time.shape)
        for coefficients in self.series[:DOUBLE_DOUBLE_ORDERS:-1]:
            tail = tail * since.hi + coefficients.hi[:, place]
        total = DoubleDouble(tail)
        for coefficients in self.series[DOUBLE_DOUBLE_ORDERS::-1]:
            total = since * total + DoubleDouble(coefficients.hi[:, place], coefficients.lo[:, place])
        return total
