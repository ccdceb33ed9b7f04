"""Periodic motions followed while a parameter changes, round folds too, with what happens to their stability.

Displacements x of a point and the parameter u obey x(period) - x = 0: a curve in seven dimensions. Its tangent is in
the null space of (matrix - 1, derivative by u), from the state-transition matrix and the sensitivity of the motion.
From each point a step along the tangent predicts the next one, and Newton's method, at right angles to the tangent,
corrects it: pseudo-arclength continuation (Doedel, Keller and Kernevez 1991, Int. J. Bifurc. Chaos 1, 493).
"""

from __future__ import annotations

import dataclasses
import sys
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.analysis.period_map import FIRM, SETTLED, PeriodMap, Point, largest_part
from poinsot.analysis.periodic import PeriodicMotion, recognised
from poinsot.errors import PropagationInterrupted, real_array, refuse_nonpositive
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.frame import Frame, checked_frame
from poinsot.mechanics.parameters import came
from poinsot.mechanics.replaced import NamedNumber
from poinsot.mechanics.state import State, computed_state
from poinsot.mechanics.system import System
from poinsot.motion.arguments import check_kinds

__all__ = ["Bifurcation", "Branch", "continue_motion"]

Array = NDArray[Any]

FIRST_STEP, SMALLEST_STEP, LARGEST_STEP = 0.01, 1e-5, 0.1
"""Along the curve: radians, and the way of the parameter from its start to its end as one."""
EASY, HARD = 3, 5
"""Rounds of the corrector: with so few the next step is longer, with so many shorter."""
ROUNDS = 8
FARTHEST = 0.5
"""Of a step, how far the corrector may go: farther is another branch."""
STRAIGHT = 0.98
"""The cosine of the angle between the tangents at two neighbouring points."""
MOST = 2000
"""Points."""
APART = 1e-6
"""Multipliers closer to 1 or -1, or to each other, belong to families and symmetries, not to bifurcations."""
PAIRED = 1e-9
"""By how much the characteristic polynomial of a matrix of potentials may differ from its mirror image, relatively."""
DIFFERENCE = 1e-5
"""Of the parameter, for the derivatives of period and frame, which have formulas."""
PATIENCE = 1.0
"""Seconds without a message."""


@dataclasses.dataclass(frozen=True, eq=False)
class Bifurcation:
    """Where a multiplier leaves or enters the unit circle, or the branch turns round.

    Attributes
    ----------
    kind : {"fold", "branching", "doubling", "collision", "torus"}
        "fold": the parameter is extreme, two motions meet. "branching": a multiplier passes 1 elsewhere, and another
        branch crosses. "doubling": one passes -1. "collision": two pairs of a system of potentials meet on the unit
        circle and leave it, or come back (Krein). "torus": a complex pair of another system passes the circle.
    value : float
        Of the parameter.
    motion : PeriodicMotion
    after : int
        The point of the branch before it.
    """

    kind: str
    value: float
    motion: PeriodicMotion
    after: int


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """Periodic motions along a curve, in its order; the parameter need not be monotonic.

    Attributes
    ----------
    parameter : str
        Its full name.
    values : array (n,)
    motions : list of PeriodicMotion
    bifurcations : list of Bifurcation
    ending : str
        Why it ends.
    """

    parameter: str
    values: Array
    motions: list[PeriodicMotion]
    bifurcations: list[Bifurcation]
    ending: str

    @property
    def state(self) -> State:
        """Where the motions start, as one State of n members."""
        states = [motion.state for motion in self.motions]
        parts = ([s.quaternion for s in states], [s.conjugate_momenta for s in states], [s.time for s in states])
        return computed_state(*(np.array(part) for part in parts))

    @property
    def periods(self) -> Array:
        """Of the motions, (n,)."""
        return np.array([motion.period for motion in self.motions])

    @property
    def multipliers(self) -> Array:
        """Floquet's, complex (n, 6)."""
        return np.array([motion.multipliers for motion in self.motions])

    @property
    def stable(self) -> Array:
        """Whether the linear equations let nothing grow, (n,)."""
        return np.array([motion.stable for motion in self.motions])

    def __repr__(self) -> str:
        found = ", ".join(f"{each.kind} at {each.value:.6g}" for each in self.bifurcations)
        return (
            f"Branch(parameter={self.parameter!r}, {self.values[0]:.6g} ... {self.values[-1]:.6g}, "
            f"motions={len(self.motions)}, stable={int(np.sum(self.stable))}, bifurcations=[{found}], "
            f"ending={self.ending!r})"
        )


def continue_motion(
    motion: PeriodicMotion,
    parameter: str,
    to: float,
    *,
    period: Callable[[System], float] | None = None,
    frame: Callable[[System], Frame] | None = None,
    progress: bool | None = None,
) -> Branch:
    """Follow a periodic motion while a named number of its system changes, round folds too.

    It ends where the parameter is `to`, or is back where it began, or where no next motion is found; the branch says
    which. Bifurcations between its points are located to about 1e-9 of the way of the parameter.

    Parameters
    ----------
    motion : PeriodicMotion
        Of `periodic_motion`, or that of a `CassiniState`.
    parameter : str
        "forces[0].orbit.eccentricity", or the end of it where that says which, as in `state_transition`.
    to : float
        The last value.
    period : function of a System, optional
        The period, if it changes with the parameter: `lambda system: system.forces[0].orbit.period`.
    frame : function of a System, optional
        The frame, likewise.
    progress : bool, optional
        Whether to show where it is after a second. Default: on a terminal.

    Raises
    ------
    ValueError
        If there is no such number, or with another value the system does not repeat itself after the period.
    PropagationInterrupted
        On Ctrl-C; its `trajectory` is the branch so far.
    """
    check_kinds("continue_motion(motion, parameter, to)", {"motion": (motion, PeriodicMotion)})
    family = _Family(motion, parameter, float(real_array("to", to, ())), period, frame)
    curve = _Curve(family, family.first(motion))
    with _messages(sys.stderr.isatty() if progress is None else progress) as tell:
        try:
            ending = curve.follow(tell)
        except KeyboardInterrupt:
            branch = curve.branch("it was interrupted")
            raise PropagationInterrupted(
                f"the continuation was interrupted at {family.number.name} = {branch.values[-1]:.6g}.",
                float(motion.state.time),
                branch,
            ) from None
    return curve.branch(ending)


@dataclasses.dataclass(frozen=True)
class _Place:
    """A periodic motion on the curve; the tangent is (x, u), of length one."""

    once: PeriodMap
    point: Point
    u: float
    matrix: Array
    tangent: Array
    rounds: int

    def motion(self) -> PeriodicMotion:
        return recognised(self.once, self.point, self.matrix)


class _LostError(Exception):
    """The corrector found nothing near."""


# ---------------------------------------------------------------------- the family of systems


class _Family:
    """The problem at each value of the parameter, 0 <= u <= 1 from the start to the end."""

    def __init__(self, motion: PeriodicMotion, parameter: str, to: float, period: Any, frame: Any) -> None:
        self.number = NamedNumber(motion.system, parameter)
        self.start, self.span = self.number.value, to - self.number.value
        if not self.span:
            raise ValueError(f"to must be another value than that of {self.number.name}, but {to!r} came.")
        for name, function in (("period", period), ("frame", frame)):
            if function is not None and not callable(function):
                raise TypeError(f"{name} must be a function of a System, but {came(function)} came.")
        self._time = float(motion.state.time)
        self._period = period or (lambda _: motion.period)
        self._frame = frame or (lambda _: motion.frame)
        self._fixed = period is None and frame is None

    def value(self, u: float) -> float:
        return self.start + u * self.span

    def once(self, u: float) -> PeriodMap:
        """Return the map over the period."""
        system = self.number.system(self.value(u))
        period = float(real_array("period", self._period(system), ()))
        refuse_nonpositive("period", period)
        return PeriodMap(system, checked_frame(self._frame(system)), self._time, period)

    def first(self, motion: PeriodicMotion) -> _Place:
        """Return where the curve begins, with its tangent towards the end."""
        once = self.once(0.0)
        once.check(motion.state.angular_momentum_body)
        try:
            return self.corrected(once.point(motion.state), 0.0, np.eye(7)[6], SMALLEST_STEP)
        except _LostError:
            raise ValueError(
                f"motion must repeat itself after the period and in the frame of {self.number.name} = "
                f"{self.start:.6g}, but it does not. The functions period and frame must return its own there."
            ) from None

    def equations(self, once: PeriodMap, point: Point, u: float) -> tuple[Array, Array]:
        """Return what a period changes, (6,), and minus its derivative by displacement and u, (6, 7)."""
        passage = once.passage(point, self.number.name)
        assert passage.slope is not None  # noqa: S101
        slope = passage.slope * self.span
        if not self._fixed:
            slope = slope + self._slope_of_times_and_axes(once, point, passage.end, passage.matrix, u)
        return passage.change, np.column_stack([np.eye(6) - passage.matrix, -slope])

    def _slope_of_times_and_axes(self, once: PeriodMap, point: Point, end: Point, matrix: Array, u: float) -> Array:
        """Return what changes of the period and of the frame with u add to the displacement of the end."""
        ends = max(u - DIFFERENCE, 0.0), min(u + DIFFERENCE, 1.0)  # beyond there may be no system
        around, apart = [self.once(end) for end in ends], ends[1] - ends[0]
        first, last = (
            _turn(*(each.frame.quaternion(each.time + share * each.period) for each in around)) / apart
            for share in (0, 1)
        )
        longer = (around[1].period - around[0].period) / apart
        there = once.time + once.period
        to_space = quat.product(once.frame.quaternion(there), end[0])
        state = once.system.body.state(to_space, angular_momentum_body=end[1], time=there)
        omega, g = once.system.omega_body(state), end[1]
        flow = np.concatenate([omega, np.cross(g, omega) + once.system.torque_body(state)]) / once.units
        begun, ended = (
            np.concatenate([rotation(p).inv().apply(w), np.zeros(3)]) for p, w in ((point[0], first), (end[0], last))
        )
        return np.asarray(matrix @ begun + flow * longer - ended)

    # ------------------------------------------------------------------ corrector

    def corrected(self, point: Point, u: float, row: Array, farthest: float = np.inf) -> _Place:
        """Return the place on the curve near a point, in the plane through it at right angles to a row."""
        gone = np.zeros(7)
        for rounds in range(1, ROUNDS + 1):
            once = self.once(u)
            change, slopes = self.equations(once, point, u)
            step = _solution(slopes, row, np.append(change, 0.0))
            step[6] *= row[6] != 1  # the parameter is given
            gone += step
            if not np.linalg.norm(gone) < farthest:
                raise _LostError
            point, u = once.displaced(point, step[:6]), u + step[6]
            if max(largest_part(change), largest_part(step[:6]), abs(step[6])) < SETTLED:
                once = self.once(u)
                _, slopes = self.equations(once, point, u)
                tangent = _solution(slopes, row, np.eye(7)[6])
                return _Place(once, point, u, np.eye(6) - slopes[:, :6], tangent / np.linalg.norm(tangent), rounds)
        raise _LostError


def _solution(slopes: Array, row: Array, right: Array) -> Array:
    return np.asarray(np.linalg.lstsq(np.vstack([slopes, row]), right, rcond=FIRM)[0])


def _turn(a: Array, b: Array) -> Array:
    """Return the rotation vector from axes a to axes b, along a."""
    return np.asarray((rotation(a).inv() * rotation(b)).as_rotvec())


# ---------------------------------------------------------------------- the curve


class _Curve:
    """Places one after another, and what lies between them."""

    def __init__(self, family: _Family, first: _Place) -> None:
        self.family, self.places = family, [first]
        self.found: list[Bifurcation] = []

    def branch(self, ending: str) -> Branch:
        values = np.array([self.family.value(place.u) for place in self.places])
        return Branch(self.family.number.name, values, [place.motion() for place in self.places], self.found, ending)

    def follow(self, tell: Callable[[str], None]) -> str:
        """Go along the curve and return why it ends."""
        size, name = FIRST_STEP, self.family.number.name
        while len(self.places) < MOST:
            here = self.places[-1]
            try:
                place, last = self._next(here, size)
            except (_LostError, ValueError) as why:
                if size < SMALLEST_STEP:
                    reason = str(why) or "no motion is near the one predicted."
                    return f"beyond {name} = {self.family.value(here.u):.6g}: {reason}"
                size /= 2
                continue
            place.once.check(place.point[1])
            self.found += self._between(here, place)
            self.places.append(place)
            tell(f"{len(self.places)} motions, {name} = {self.family.value(place.u):.6g}")
            if last is not None:
                return f"{name} = {self.family.value(last):.6g}" + ("" if last else ", where it began")
            size = min(size * (1.5 if place.rounds <= EASY else 0.7 if place.rounds >= HARD else 1.0), LARGEST_STEP)
        return f"it has {MOST} motions"

    def _next(self, here: _Place, size: float) -> tuple[_Place, float | None]:
        """Return the next place, and the end of the way if it is there."""
        row, last, ahead = here.tangent, None, here.u + size * here.tangent[6]
        if not 0 < ahead < 1 and here.tangent[6]:
            last = float(ahead >= 1)
            size, row = (last - here.u) / here.tangent[6], np.eye(7)[6]
        step = size * here.tangent
        point = here.once.displaced(here.point, step[:6])
        u = here.u + step[6] if last is None else last
        place = self.family.corrected(point, u, row, max(FARTHEST * size, SMALLEST_STEP))
        tangent = place.tangent * (1 if place.tangent @ here.tangent > 0 else -1)
        if tangent @ here.tangent < STRAIGHT:
            raise _LostError
        return dataclasses.replace(place, tangent=tangent), last

    # ------------------------------------------------------------------ bifurcations

    def _between(self, a: _Place, b: _Place) -> Iterator[Bifurcation]:
        for kind, test in TESTS.items():
            if not test(a) * test(b) < 0:
                continue
            place = self._located(a, b, test)
            if kind == "collision" and not _on_circle(place.matrix):
                continue
            yield Bifurcation(kind, self.family.value(place.u), place.motion(), len(self.places) - 1)
            if kind == "fold":  # where a multiplier is 1 too
                return

    def _located(self, a: _Place, b: _Place, test: Callable[[_Place], float]) -> _Place:
        """Return the place between two at which a test vanishes; where it is not found, the nearer end."""
        from scipy.optimize import brentq

        way = np.append(a.once.displacement(a.point, b.point), b.u - a.u) @ a.tangent
        seen = {0.0: a, float(way): b}

        def value(s: float) -> float:
            if s not in seen:
                step = s * a.tangent
                seen[s] = self.family.corrected(a.once.displaced(a.point, step[:6]), a.u + step[6], a.tangent)
                aligned = seen[s].tangent * np.sign(seen[s].tangent @ a.tangent)
                seen[s] = dataclasses.replace(seen[s], tangent=aligned)
            return test(seen[s])

        try:
            return seen[brentq(value, 0.0, float(way), xtol=1e-12, rtol=1e-12)]
        except (_LostError, ValueError):
            return min((a, b), key=lambda place: abs(test(place)))


def _fold(place: _Place) -> float:
    return float(place.tangent[6])


def _beside(sign: int) -> Callable[[_Place], float]:
    """Return the determinant of matrix - sign, zero where a multiplier is always there."""

    def test(place: _Place) -> float:
        distances = np.linalg.eigvals(place.matrix) - sign
        return float(np.prod(distances).real) if np.min(np.abs(distances)) > APART else 0.0

    return test


def _collision(place: _Place) -> float:
    """Return the discriminant of the sums of reciprocal multipliers, if there are such: negative if two are complex."""
    sums = _sums(place.matrix)
    if sums is None:
        return 0.0
    a, b, c = sums
    return float(((a - b) ** 2 * (b - c) ** 2 * (c - a) ** 2).real)


def _torus(place: _Place) -> float:
    """Return the logarithm of the largest modulus of complex multipliers, without a potential."""
    multipliers = np.linalg.eigvals(place.matrix)
    complex_ones = multipliers[np.abs(multipliers.imag) > APART]
    if not complex_ones.size or _sums(place.matrix) is not None:
        return 0.0
    return float(np.max(np.log(np.abs(complex_ones))))


def _sums(matrix: Array) -> Array | None:
    """Return the three m + 1/m of multipliers that come in pairs m, 1/m; None if they do not."""
    c = np.poly(matrix)
    if np.max(np.abs(c - c[::-1])) > PAIRED * np.max(np.abs(c)):
        return None
    return np.asarray(np.roots([1, c[1], c[2] - 3, c[3] - 2 * c[1]]))


def _on_circle(matrix: Array) -> bool:
    """Whether the two sums that are nearest to each other are of multipliers on the unit circle."""
    sums = _sums(matrix)
    if sums is None:
        return False
    pairs = [(sums[i], sums[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    near = min(pairs, key=lambda pair: abs(pair[0] - pair[1]))
    return bool(abs(np.mean(near).real) < 2)


TESTS: dict[str, Callable[[_Place], float]] = {
    "fold": _fold,
    "branching": _beside(1),
    "doubling": _beside(-1),
    "collision": _collision,
    "torus": _torus,
}
"""What vanishes at each kind of bifurcation."""


@contextmanager
def _messages(wanted: bool) -> Iterator[Callable[[str], None]]:
    """Show where the continuation is, once it takes longer than a second."""
    if not wanted:
        yield lambda _: None
        return
    from rich.console import Console

    began, status = clock.perf_counter(), Console(stderr=True).status("")

    def tell(text: str) -> None:
        if clock.perf_counter() - began > PATIENCE:
            status.start()
            status.update(text)

    try:
        yield tell
    finally:
        status.stop()
