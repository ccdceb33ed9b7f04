"""Continuation of periodic motions in a parameter, also around folds, with their stability and bifurcations.

A step along the tangent of the curve of motions predicts the next motion, and Newton's method, at right angles to the
tangent, corrects it: pseudo-arclength continuation (Doedel, Keller and Kernevez 1991, Int. J. Bifurc. Chaos 1, 493).
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from typing_extensions import override

from poinsot.analysis.bifurcations import CROSSING_TOLERANCE, Bifurcation, bifurcations
from poinsot.analysis.continuation_problem import ContinuationProblem, CurvePoint, NamedFunction, NotConvergedError
from poinsot.analysis.period_map import FAMILY_TOLERANCE, Point
from poinsot.analysis.periodic import PeriodicMotion
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, rounded
from poinsot.display.progress import ReportProgress, bar
from poinsot.errors import PropagationInterrupted, real_array
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import AnyState
from poinsot.quantities import Array
from poinsot.systems.named_parameters import NamedNumber
from poinsot.systems.system import System, is_of_two_bodies

__all__ = ["Bifurcation", "Branch", "continue_motion"]

FIRST_STEP, SMALLEST_STEP, LARGEST_STEP = 0.01, 1e-5, 0.1
"""Lengths along the curve, in radians and in the range of the parameter."""
EASY, HARD = 3, 5
"""Numbers of corrections: with at most `EASY` the next step is longer, from `HARD` on it is shorter."""
MAX_CORRECTION = 0.5
"""Largest correction, relative to the step: a larger one leads to another branch."""
MIN_TANGENT_COSINE = 0.98
"""Smallest cosine of the angle between the tangents at two consecutive points."""
MAX_POINTS = 2000
"""Largest number of points of a branch."""
MAX_FIRST_CORRECTION = 10.0
"""Largest correction, relative to the first step on a branch that crosses: only the plane of the branch is known."""
SINGULAR_TOLERANCE = 1e-8
"""Largest singular value, relative to the largest one, that is zero at a located bifurcation."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Branch(Summarized):
    """Periodic motions along a curve of a parameter, in the order of the curve; the parameter need not be monotonic.

    Attributes
    ----------
    parameter : str
        Full name of the parameter.
    values : array (n,)
        Values of the parameter.
    motions : list of PeriodicMotion
        Periodic motion at each value.
    bifurcations : list of Bifurcation
        Bifurcations, in the order of the curve.
    ending : str
        Reason for which the branch ends.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    >>> facing = moon.body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> libration = pt.analysis.periodic_motion(moon, facing, orbit.period)
    >>> branch = pt.analysis.continue_motion(libration, "eccentricity", 0.03)
    >>> branch.values[[0, -1]], branch.stable[[0, -1]]
    (array([0.02, 0.03]), array([ True, False]))
    """

    parameter: str
    values: Array
    motions: list[PeriodicMotion]
    bifurcations: list[Bifurcation]
    ending: str

    @property
    def state(self) -> AnyState:
        """Initial states of the motions, as one State of n members."""
        states = [motion.state for motion in self.motions]
        phase = {name: np.array([state.phase[name] for state in states]) for name in states[0].phase}
        return type(states[0]).computed(phase, np.array([state.time for state in states]))

    @property
    def periods(self) -> Array:
        """Periods of the motions, (n,)."""
        return np.array([motion.period for motion in self.motions])

    @property
    def multipliers(self) -> Array:
        """Floquet multipliers of the motions, complex (n, k); k = 6 without parts."""
        return np.array([motion.multipliers for motion in self.motions])

    @property
    def stable(self) -> Array:
        """True if no solution of the linear equations grows, (n,)."""
        return np.array([motion.stable for motion in self.motions])

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        unit = self.motions[0].system.units["time"]
        return f"Branch of periodic motions along {self.parameter}", {
            "motions": f"{len(self.motions)}, {int(np.sum(self.stable))} stable",
            "values": f"{self.values[0]:.6g} ... {self.values[-1]:.6g}",
            "periods": f"{self.periods[0]:.6g} ... {self.periods[-1]:.6g}" + (f" {unit}" if unit != "1" else ""),
            "bifurcations": rounded(", ".join(f"{each.kind} at {each.value:.6g}" for each in self.bifurcations)),
            "ending": self.ending,
        }


@checked
def continue_motion(
    motion: PeriodicMotion | Bifurcation,
    parameter: str | Callable[[float], System],
    to: float,
    *,
    start: float | None = None,
    period: Callable[[System], float] | None = None,
    frame: Callable[[System], Frame] | None = None,
    progress: bool | None = None,
) -> Branch:
    """Follow a periodic motion while a parameter of its system changes, also around folds, or follow a crossing branch.

    The branch ends where the parameter reaches `to`, where it returns to its beginning, or where Newton's method finds
    no further motion; `ending` gives the reason. The branch contains a bifurcation wherever the number of multipliers
    outside the unit circle changes.

    Parameters
    ----------
    motion : PeriodicMotion or Bifurcation
        Result of `periodic_motion`, or `motion` of a `CassiniState`. A "branching" or "doubling" bifurcation of another
        branch gives the branch that crosses it or has twice the period, on the side of `to`. Of two branches that are
        mirror images the function returns one.
    parameter : str or function of a float
        Name such as "forces[0].orbit.eccentricity", or its unambiguous end, as in `state_transition`. Alternatively a
        function that returns the system at a value: `lambda ratio: System(Body.from_ratios(ratio, 0.1), gravity)`.
    to : float
        Last value of the parameter.
    start : float, optional
        Value of the parameter for the given motion; required if the parameter is a function.
    period, frame : function of a System, optional
        Functions that return the period and the frame if they depend on the parameter, such as `lambda system:
        system.forces[0].orbit.period`.
    progress : bool, optional
        True to show a progress bar during a long run. Default: True on a terminal.

    Returns
    -------
    Branch
        Periodic motions, bifurcations and the reason of the end.

    Raises
    ------
    ValueError
        If the parameter does not exist, or the system with another value is not periodic.
    PropagationInterrupted
        On Ctrl-C. Its `trajectory` contains the branch so far.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    >>> facing = moon.body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> libration = pt.analysis.periodic_motion(moon, facing, orbit.period)
    >>> branch = pt.analysis.continue_motion(libration, "eccentricity", 0.03)
    >>> branch.ending
    'forces[0].orbit.eccentricity = 0.03'
    """
    origin = motion.motion if isinstance(motion, Bifurcation) else motion
    if is_of_two_bodies(origin.system):
        raise ValueError(
            "motion must be of one body, got one of two bodies. Take their values one after another: "
            "motion = periodic_motion(system, motion.state, motion.period)."
        )
    turns = 2 if isinstance(motion, Bifurcation) and motion.kind == "doubling" else 1
    problem = ContinuationProblem(
        _parameter(motion, parameter, start), float(real_array("to", to, ())), origin, period, frame, turns
    )
    places = _crossing(problem, motion) if isinstance(motion, Bifurcation) else [_first(problem, motion)]
    curve = _Curve(problem, places)
    with bar(problem.name, 1.0, sys.stderr.isatty() if progress is None else progress) as report:
        try:
            ending = curve.follow(report)
        except KeyboardInterrupt:
            branch = curve.branch("it was interrupted")
            raise PropagationInterrupted(
                f"the continuation was interrupted at {problem.name} = {branch.values[-1]:.6g}.",
                float(origin.state.time),
                branch,
            ) from None
    return curve.branch(ending)


def _parameter(
    motion: PeriodicMotion | Bifurcation, parameter: Any, start: float | None
) -> NamedNumber | NamedFunction:
    if isinstance(motion, Bifurcation):
        start, motion = motion.value, motion.motion
    if not callable(parameter):
        return NamedNumber(motion.system, parameter)
    if start is None:
        raise ValueError("start must be the value at which parameter returns the system of the motion, got None.")
    return NamedFunction(parameter, float(real_array("start", start, ())))


def _first(problem: ContinuationProblem, motion: PeriodicMotion, firm: float = FAMILY_TOLERANCE) -> CurvePoint:
    """Return the first point of the curve, with its tangent towards the end."""
    mapping = problem.mapping(0.0)
    mapping.check()
    try:
        return problem.corrected(
            mapping.point(motion.state.of_bodies[""]), 0.0, problem.by_parameter, SMALLEST_STEP, firm
        )
    except NotConvergedError:
        raise ValueError(
            f"motion must repeat itself after the period and in the frame of {problem.name} = "
            f"{problem.start:.6g}, but it does not. The functions period and frame must return its own there."
        ) from None


# ---------------------------------------------------------------------- crossing branches


def _crossing(problem: ContinuationProblem, found: Bifurcation) -> list[CurvePoint]:
    """Return the bifurcation and the next point of the branch that crosses or doubles."""
    if found.kind not in ("branching", "doubling"):
        raise ValueError(f"motion must be a branching or a doubling where it is a Bifurcation, got a {found.kind}.")
    origin = _first(problem, found.motion, CROSSING_TOLERANCE)
    along = found.tangent / np.append(origin.mapping.units, problem.span)
    along *= np.copysign(1 / np.linalg.norm(along), along[-1])
    none = ValueError(f"motion must have a crossing branch, got {found.kind} at {found.value:.9g} with none near.")
    try:
        across = FIRST_STEP * _across(problem, origin.point, along)
    except NotConvergedError:
        raise none from None
    lost = True
    for step in (across, -across):
        try:
            point = origin.mapping.displaced(origin.point, step[:-1])
            following = problem.corrected(point, 0.0, step / FIRST_STEP, MAX_FIRST_CORRECTION * FIRST_STEP)
        except (NotConvergedError, ValueError):
            continue
        if 0 < following.u < 1:
            way = origin.to(following)
            return [dataclasses.replace(origin, tangent=way / np.linalg.norm(way)), following]
        lost = False
    if lost:
        raise none
    to = problem.value(1.0)
    raise ValueError(f"to must be on the side of {problem.start:.9g} to which the branch goes, got {to:.9g}.")


def _across(problem: ContinuationProblem, point: Point, along: Array) -> Array:
    """Return the direction, across a branch, that is in the null space at a point but not at the next point."""
    near = FIRST_STEP * along
    following = problem.corrected(problem.mapping(0.0).displaced(point, near[:-1]), near[-1], along)
    slopes = [problem.equations(problem.mapping(u), x, u)[1] for x, u in ((point, 0.0), (following.point, following.u))]
    sizes = np.linalg.svd(slopes[0], compute_uv=False)
    count = 1 + int(np.sum(sizes < SINGULAR_TOLERANCE * sizes[0]))
    here, there = (
        np.linalg.svd(slope)[2][along.size - k :].T for slope, k in zip(slopes, (count, max(count - 1, 1)), strict=True)
    )
    way = here @ np.linalg.svd(here - there @ (there.T @ here))[2][0]
    way = way - along * (along @ way)
    return np.asarray(way / np.linalg.norm(way))


# ---------------------------------------------------------------------- curve


class _Curve:
    """Consecutive points of the curve, and the bifurcations between them."""

    def __init__(self, problem: ContinuationProblem, places: list[CurvePoint]) -> None:
        self.problem, self.places = problem, places[:1]
        self.found: list[Bifurcation] = []
        for place in places[1:]:
            self._add(place)

    def branch(self, ending: str) -> Branch:
        values = np.array([self.problem.value(place.u) for place in self.places])
        return Branch(self.problem.name, values, [place.motion() for place in self.places], self.found, ending)

    def _add(self, place: CurvePoint) -> None:
        self.found += bifurcations(self.problem, self.places[-1], place, len(self.places) - 1)
        self.places.append(place)

    def follow(self, report: ReportProgress) -> str:
        """Follow the curve and return the reason for its end."""
        size, name = FIRST_STEP, self.problem.name
        while len(self.places) < MAX_POINTS:
            here = self.places[-1]
            try:
                place, last = self._next(here, size)
            except (NotConvergedError, ValueError) as why:
                if size < SMALLEST_STEP:
                    reason = str(why) or "no motion is near the one predicted."
                    return f"beyond {name} = {self.problem.value(here.u):.6g}: {reason}"
                size /= 2
                continue
            place.mapping.check()
            self._add(place)
            report(place.u - here.u, f"{len(self.places)} motions, {name} = {self.problem.value(place.u):.6g}")
            if last is not None:
                return f"{name} = {self.problem.value(last):.6g}" + ("" if last else ", where it began")
            size = min(
                size * (1.5 if place.corrections <= EASY else 0.7 if place.corrections >= HARD else 1.0), LARGEST_STEP
            )
        return f"it has {MAX_POINTS} motions"

    def _next(self, here: CurvePoint, size: float) -> tuple[CurvePoint, float | None]:
        """Return the next point, and the end of the range of u if the point is there."""
        row, last, ahead = here.tangent, None, here.u + size * here.tangent[-1]
        if not 0 < ahead < 1 and here.tangent[-1]:
            last = float(ahead >= 1)
            size, row = (last - here.u) / here.tangent[-1], self.problem.by_parameter
        step = size * here.tangent
        point = here.mapping.displaced(here.point, step[:-1])
        u = here.u + step[-1] if last is None else last
        place = self.problem.corrected(point, u, row, max(MAX_CORRECTION * size, SMALLEST_STEP))
        tangent = place.tangent * (1 if place.tangent @ here.tangent > 0 else -1)
        if tangent @ here.tangent < MIN_TANGENT_COSINE:
            raise NotConvergedError
        return dataclasses.replace(place, tangent=tangent), last
