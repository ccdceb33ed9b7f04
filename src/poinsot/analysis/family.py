"""Periodic motions of a family of systems: the corrector of pseudo-arclength continuation.

Displacements x of a point and the parameter u obey x(period) - x = 0: a curve in k + 1 dimensions. Its tangent is in
the null space of (matrix - 1, derivative by u), from the state-transition matrix and the sensitivity of the motion.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.analysis.multipliers import Multipliers
from poinsot.analysis.period_map import FAMILY_TOLERANCE, MAX_LAST_STEP, PeriodMap, Point, largest_part
from poinsot.analysis.periodic import PeriodicMotion, recognised
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.immutable import Immutable, cached_property
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.frame import Frame, checked_frame
from poinsot.mechanics.named_parameters import NamedNumber, named_numbers
from poinsot.mechanics.system import System
from poinsot.printable import described, quoted

__all__ = ["Family", "LostError", "NamedFunction", "Place"]

Array = NDArray[Any]

MAX_ITERATIONS = 8
"""Largest number of iterations of the corrector."""
DIFFERENCE_STEP = 1e-5
"""Step of difference quotients relative to the range of the parameter, for formulas of numbers, period and frame."""


@dataclasses.dataclass(frozen=True)
class Place:
    """A periodic motion on the curve; the tangent is (x, u), of length one."""

    once: PeriodMap
    point: Point
    u: float
    matrix: Array
    tangent: Array
    rounds: int

    def motion(self) -> PeriodicMotion:
        """Return the motion."""
        return recognised(self.once, self.point, self.matrix)

    def to(self, other: Place) -> Array:
        """Return what leads to another place, (k + 1,)."""
        return np.append(self.once.displacement(self.point, other.point), other.u - self.u)

    @cached_property
    def multipliers(self) -> Multipliers:
        """Of its matrix."""
        return Multipliers(self.matrix)


class LostError(Exception):
    """The corrector found nothing near."""


class NamedFunction(Immutable):
    """A function of a number to a system, and the number where it begins; as `NamedNumber` has them."""

    def __init__(self, function: Callable[[float], System], value: float) -> None:
        self.name, self.value = getattr(function, "__name__", "parameter"), value
        self._function = function

    def system(self, value: float) -> System:
        """Return the system at a value, or refuse what comes."""
        found: Any = self._function(value)
        if not isinstance(found, System):
            raise TypeError(f"parameter must return a System, got {described(found)}.")
        return found


class Family:
    """The problem at each value of the parameter, 0 <= u <= 1 from the start to the end.

    Parameters
    ----------
    parameter : NamedNumber or NamedFunction
    to : float
        Its value at the end.
    motion : PeriodicMotion
        Where it begins.
    period, frame : function of a System, or None
        None: those of the motion.
    turns : int
        How many periods make one.

    Attributes
    ----------
    by_parameter : array (k + 1,)
        The direction in which the parameter alone changes.
    """

    def __init__(
        self,
        parameter: NamedNumber | NamedFunction,
        to: float,
        motion: PeriodicMotion,
        period: Callable[[System], float] | None,
        frame: Callable[[System], Frame] | None,
        turns: int = 1,
    ) -> None:
        self.name, self._parameter, self._turns = parameter.name, parameter, turns
        self.start, self.span = parameter.value, to - parameter.value
        if not self.span:
            raise ValueError(f"to must be another value than that of {self.name}, got {quoted(to)}.")
        self._origin = motion.state.of_bodies[""]
        self._period = period or (lambda _: motion.period)
        self._frame = frame or (lambda _: motion.frame)
        self._fixed = period is None and frame is None
        self.by_parameter = np.eye(len(motion.matrix) + 1)[-1]

    def value(self, u: float) -> float:
        """Return the value of the parameter."""
        return self.start + u * self.span

    def once(self, u: float) -> PeriodMap:
        """Return the map over the period."""
        system = self._parameter.system(self.value(u))
        period = float(real_array("period", self._period(system), ()))
        refuse_nonpositive("period", period)
        return PeriodMap(system, checked_frame(self._frame(system)), self._origin, self._turns * period)

    def equations(self, once: PeriodMap, point: Point, u: float) -> tuple[Array, Array]:
        """Return what a period changes, (k,), and minus its derivative by displacement and u, (k, k + 1)."""
        ends = max(u - DIFFERENCE_STEP, 0.0), min(u + DIFFERENCE_STEP, 1.0)  # beyond there may be no system
        names, rates = self._changing(once.system, ends)
        passage = once.passage(point, names)
        slope = passage.slope @ rates
        if not self._fixed:
            slope = slope + self._slope_of_times_and_axes(once, point, passage.end, passage.matrix, ends)
        return passage.change, np.column_stack([np.eye(len(slope)) - passage.matrix, -slope])

    def _changing(self, here: System, ends: tuple[float, float]) -> tuple[list[str], Array]:
        """Return which numbers of the system change with u, and their derivatives."""
        if isinstance(self._parameter, NamedNumber):
            return [self.name], np.array([self.span])
        around = [self._parameter.system(self.value(u)) for u in ends]
        first, last = (np.array(system.dynamics.between_knots().numbers, dtype=float) for system in around)
        if first.shape != last.shape or first.shape != np.shape(here.dynamics.between_knots().numbers):
            raise ValueError("parameter must return systems that differ in numbers alone, got other forces or orbits.")
        rates = (last - first) / (ends[1] - ends[0])
        names = {name: rates[numbers[0]] for name, numbers in named_numbers(here).items() if rates[numbers[0]]}
        return list(names), np.array(list(names.values()))

    def _slope_of_times_and_axes(
        self, once: PeriodMap, point: Point, end: Point, matrix: Array, ends: tuple[float, float]
    ) -> Array:
        """Return what changes of the period and of the frame with u add to the displacement of the end."""
        around, apart = [self.once(end) for end in ends], ends[1] - ends[0]
        first, last = (
            _turn(*(each.frame.quaternion(each.time + share * each.period) for each in around)) / apart
            for share in (0, 1)
        )
        longer = (around[1].period - around[0].period) / apart
        turned = (rotation(p).inv().apply(w) for p, w in ((point[0], first), (end[0], last)))
        begun, ended = (np.append(turn, np.zeros(len(matrix) - 3)) for turn in turned)
        return np.asarray(matrix @ begun + once.flow(end) * longer - ended)

    def corrected(
        self, point: Point, u: float, row: Array, farthest: float = np.inf, firm: float = FAMILY_TOLERANCE
    ) -> Place:
        """Return the place on the curve near a point, in the plane through it at right angles to a row.

        Where a singular value is below `firm`, of the largest, the point stays where it is in that direction.
        """
        gone = np.zeros(row.size)
        for rounds in range(1, MAX_ITERATIONS + 1):
            once = self.once(u)
            change, slopes = self.equations(once, point, u)
            step = _solution(slopes, row, np.append(change, 0.0), firm)
            step[-1] *= row[-1] != 1  # the parameter is given
            gone += step
            if not np.linalg.norm(gone) < farthest:
                raise LostError
            point, u = once.displaced(point, step[:-1]), u + step[-1]
            if max(largest_part(change), largest_part(step[:-1]), abs(step[-1])) < MAX_LAST_STEP:
                once = self.once(u)
                _, slopes = self.equations(once, point, u)
                tangent = _solution(slopes, row, np.eye(row.size)[-1], firm)
                matrix = np.eye(len(slopes)) - slopes[:, :-1]
                return Place(once, point, u, matrix, tangent / np.linalg.norm(tangent), rounds)
        raise LostError


def _solution(slopes: Array, row: Array, right: Array, firm: float) -> Array:
    return np.asarray(np.linalg.lstsq(np.vstack([slopes, row]), right, rcond=firm)[0])


def _turn(a: Array, b: Array) -> Array:
    """Return the rotation vector from axes a to axes b, along a."""
    return np.asarray((rotation(a).inv() * rotation(b)).as_rotvec())
