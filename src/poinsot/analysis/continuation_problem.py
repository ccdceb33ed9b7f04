"""Equations and corrector of pseudo-arclength continuation of periodic motions in a parameter.

Displacements x of a point and the parameter u obey x(period) - x = 0: a curve in k + 1 dimensions. Its tangent is in
the null space of (matrix - 1, derivative by u), from the state-transition matrix and the sensitivity of the motion.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot.analysis.multipliers import Multipliers
from poinsot.analysis.period_map import FAMILY_TOLERANCE, MAX_LAST_STEP, PeriodMap, Point, largest_component
from poinsot.analysis.periodic import PeriodicMotion, motion_at
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.immutable import Immutable, cached_property
from poinsot.kinematics.attitude import rotation
from poinsot.kinematics.frame import Frame, checked_frame
from poinsot.printable import described, quoted
from poinsot.quantities import Array
from poinsot.systems.named_parameters import NamedNumber, named_numbers
from poinsot.systems.system import System

__all__ = ["ContinuationProblem", "CurvePoint", "NamedFunction", "NotConvergedError"]

MAX_ITERATIONS = 8
"""Largest number of iterations of the corrector."""
DIFFERENCE_STEP = 1e-5
"""Step of difference quotients relative to the range of the parameter, for formulas of numbers, period and frame."""


@dataclasses.dataclass(frozen=True)
class CurvePoint:
    """Periodic motion on the curve; the tangent (x, u) has length one."""

    mapping: PeriodMap
    point: Point
    u: float
    matrix: Array
    tangent: Array
    corrections: int

    def motion(self) -> PeriodicMotion:
        """Return the periodic motion."""
        return motion_at(self.mapping, self.point, self.matrix)

    def to(self, other: CurvePoint) -> Array:
        """Return the displacement to another point of the curve, (k + 1,)."""
        return np.append(self.mapping.displacement(self.point, other.point), other.u - self.u)

    @cached_property
    def multipliers(self) -> Multipliers:
        """Floquet multipliers of the motion."""
        return Multipliers(self.matrix)


class NotConvergedError(Exception):
    """The corrector did not converge to a nearby motion."""


class NamedFunction(Immutable):
    """Function from a number to a system, and its initial number, with the interface of `NamedNumber`."""

    def __init__(self, function: Callable[[float], System], value: float) -> None:
        self.name, self.value = getattr(function, "__name__", "parameter"), value
        self._function = function

    def system(self, value: float) -> System:
        """Return the system at a value; raise an error if the function returns another object."""
        found: Any = self._function(value)
        if not isinstance(found, System):
            raise TypeError(f"parameter must return a System, got {described(found)}.")
        return found


class ContinuationProblem:
    """Equations of periodic motions at each value of the parameter, 0 <= u <= 1 from the start to the end.

    Parameters
    ----------
    parameter : NamedNumber or NamedFunction
    to : float
        Value of the parameter at the end.
    motion : PeriodicMotion
        First motion of the branch.
    period, frame : function of a System, or None
        None for the period and the frame of the motion.
    turns : int
        Number of periods after which the motions of the branch are periodic.

    Attributes
    ----------
    by_parameter : array (k + 1,)
        Direction in which the parameter alone changes.
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

    def mapping(self, u: float) -> PeriodMap:
        """Return the period map at a value of u."""
        system = self._parameter.system(self.value(u))
        period = float(real_array("period", self._period(system), ()))
        refuse_nonpositive("period", period)
        return PeriodMap(system, checked_frame(self._frame(system)), self._origin, self._turns * period)

    def equations(self, mapping: PeriodMap, point: Point, u: float) -> tuple[Array, Array]:
        """Return the change over a period, (k,), and minus its derivative by displacement and u, (k, k + 1)."""
        ends = max(u - DIFFERENCE_STEP, 0.0), min(u + DIFFERENCE_STEP, 1.0)  # outside there may be no system
        names, rates = self._changing(mapping.system, ends)
        passage = mapping.passage(point, names)
        slope = passage.slope @ rates
        if not self._fixed:
            slope = slope + self._slope_of_times_and_axes(mapping, point, passage.end, passage.matrix, ends)
        return passage.change, np.column_stack([np.eye(len(slope)) - passage.matrix, -slope])

    def _changing(self, here: System, ends: tuple[float, float]) -> tuple[list[str], Array]:
        """Return the names of the numbers of the system that change with u, and their derivatives."""
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
        self, mapping: PeriodMap, point: Point, end: Point, matrix: Array, ends: tuple[float, float]
    ) -> Array:
        """Return the derivative of the displacement of the end by u through the period and the frame."""
        around, apart = [self.mapping(end) for end in ends], ends[1] - ends[0]
        first, last = (
            _turn(*(each.frame.quaternion(each.time + share * each.period) for each in around)) / apart
            for share in (0, 1)
        )
        longer = (around[1].period - around[0].period) / apart
        turned = (rotation(p).inv().apply(w) for p, w in ((point[0], first), (end[0], last)))
        begun, ended = (np.append(turn, np.zeros(len(matrix) - 3)) for turn in turned)
        return np.asarray(matrix @ begun + mapping.flow(end) * longer - ended)

    def corrected(
        self, point: Point, u: float, row: Array, farthest: float = np.inf, firm: float = FAMILY_TOLERANCE
    ) -> CurvePoint:
        """Return the point of the curve near a point, in the plane through it at right angles to a row.

        The point does not move in directions whose relative singular value is below `firm`.
        """
        gone = np.zeros(row.size)
        for corrections in range(1, MAX_ITERATIONS + 1):
            mapping = self.mapping(u)
            change, slopes = self.equations(mapping, point, u)
            step = _solution(slopes, row, np.append(change, 0.0), firm)
            step[-1] *= row[-1] != 1  # the parameter is given
            gone += step
            if not np.linalg.norm(gone) < farthest:
                raise NotConvergedError
            point, u = mapping.displaced(point, step[:-1]), u + step[-1]
            if max(largest_component(change), largest_component(step[:-1]), abs(step[-1])) < MAX_LAST_STEP:
                mapping = self.mapping(u)
                _, slopes = self.equations(mapping, point, u)
                tangent = _solution(slopes, row, np.eye(row.size)[-1], firm)
                matrix = np.eye(len(slopes)) - slopes[:, :-1]
                return CurvePoint(mapping, point, u, matrix, tangent / np.linalg.norm(tangent), corrections)
        raise NotConvergedError


def _solution(slopes: Array, row: Array, right: Array, firm: float) -> Array:
    return np.asarray(np.linalg.lstsq(np.vstack([slopes, row]), right, rcond=firm)[0])


def _turn(a: Array, b: Array) -> Array:
    """Return the rotation vector from axes a to axes b, along a."""
    return np.asarray((rotation(a).inv() * rotation(b)).as_rotvec())
