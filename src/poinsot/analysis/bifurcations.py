"""Bifurcations between two consecutive periodic motions of a branch.

Multipliers outside the unit circle are counted at both ends: real multipliers above 1, real ones below -1, and complex
pairs. If one bifurcation explains the change of the counts, the root of its test function is found. Otherwise the
segment is halved.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np
from typing_extensions import override

from poinsot.analysis.continuation_problem import ContinuationProblem, CurvePoint, NotConvergedError
from poinsot.analysis.multipliers import Multipliers
from poinsot.analysis.periodic import PeriodicMotion
from poinsot.display.html_text import Summarized, formatted
from poinsot.quantities import Array

__all__ = ["CROSSING_TOLERANCE", "Bifurcation", "bifurcations"]

CROSSING_TOLERANCE = 1e-6
"""Largest singular value, relative to the largest one, of the direction of a branch that crosses."""
MIN_SEGMENT = 1e-10
"""Shortest length of a segment along the curve. Events within it are one event."""
LOCATION_TOLERANCE = 1e-15
"""Tolerance of the location of an event, relative to its distance."""
MAX_NODES, MIN_SPACING = 5, 0.01
"""Largest number of nodes of a prediction, and their smallest distance as fraction of the segment."""
TANGENT_ROUNDING = 1e-9
"""Component of the tangent along the parameter below which its sign is rounding."""
SIGNS = {"branching": 1, "doubling": -1}
COUNTS = np.array([1, 1, 2])
"""Numbers of multipliers outside the unit circle: one for a real multiplier, two for a complex pair."""
EVENTS = {
    (0, 0, 0): "none",
    (1, 0, 0): "branching",
    (0, 1, 0): "doubling",
    (0, 0, 1): "apart",
    (2, 0, -1): "none",
    (0, 2, -1): "none",
}
"""Kinds of bifurcation by the changes of the counts, of either sign; two real multipliers may become complex."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Bifurcation(Summarized):
    """Point of a branch at which a Floquet multiplier crosses the unit circle, or at which the branch folds.

    Attributes
    ----------
    kind : {"fold", "branching", "doubling", "collision", "torus", "unresolved"}
        "fold": two motions meet at an extreme value of the parameter. "branching": a multiplier passes 1 elsewhere, and
        another branch crosses. "doubling": a multiplier passes -1. "collision": two pairs of multipliers of a
        conservative system meet on the unit circle and leave it or return to it (Krein). "torus": a complex pair of
        another system passes the circle. "unresolved": one or more of these in the interval, where no motion was found
        or they cannot be distinguished.
    value : float
        Value of the parameter.
    interval : (float, float)
        Interval of the parameter that contains the bifurcation; both ends are `value` except for "unresolved".
    change : int
        Change of the number of multipliers outside the unit circle.
    motion : PeriodicMotion
        Periodic motion at the bifurcation.
    tangent : array (k + 1,)
        Direction of the branch: rotation vector, angular momentum, variables of parts, value of the parameter.
    after : int
        Index of the point of the branch before the bifurcation.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    >>> facing = moon.body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> libration = pt.analysis.periodic_motion(moon, facing, orbit.period)
    >>> branch = pt.analysis.continue_motion(libration, "eccentricity", 0.03)
    >>> [(found.kind, round(float(found.value), 4), found.change) for found in branch.bifurcations]
    [('doubling', 0.0269, 1)]
    """

    kind: str
    value: float
    interval: tuple[float, float]
    change: int
    motion: PeriodicMotion
    tangent: Array
    after: int

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        unit = self.motion.system.units["time"]
        return f"Bifurcation: {self.kind}", {
            "value": formatted(self.value),
            "interval": formatted(self.interval) if self.kind == "unresolved" else "",
            "multipliers more outside the unit circle": formatted(self.change),
            "period": formatted(self.motion.period, unit),
            "point of the branch before it": formatted(self.after),
        }


def bifurcations(problem: ContinuationProblem, a: CurvePoint, b: CurvePoint, after: int) -> Iterator[Bifurcation]:
    """Yield the bifurcations between two consecutive points, in order."""
    segment = _Segment(problem, a, b, after)
    yield from segment.explained(0.0, segment.length)


class _Segment:
    """Curve between two points, over the distance along their chord."""

    def __init__(self, problem: ContinuationProblem, a: CurvePoint, b: CurvePoint, after: int) -> None:
        self.problem, self.after = problem, after
        chord = a.to(b)
        self.length = float(np.linalg.norm(chord))
        self.chord, self.places = chord / self.length, {0.0: a, self.length: b}
        self.paired = a.multipliers.paired and b.multipliers.paired
        self.level = max(abs(a.tangent[-1]), abs(b.tangent[-1])) < TANGENT_ROUNDING

    # ------------------------------------------------------------------ places

    def at(self, distance: float) -> CurvePoint:
        """Return the point of the curve at a distance, predicted from the known points."""
        if distance in self.places:
            return self.places[distance]
        from scipy.interpolate import KroghInterpolator

        nodes = self._nodes(distance)
        near = nodes[0][1]
        curve = KroghInterpolator([s for s, _ in nodes], [near.to(place) for _, place in nodes])
        step, row = curve(distance), curve.derivative(distance)
        point = near.mapping.displaced(near.point, step[:-1])
        place = self.problem.corrected(
            point, near.u + step[-1], row / np.linalg.norm(row), self.length, CROSSING_TOLERANCE
        )
        self.places[distance] = place
        return place

    def _nodes(self, distance: float) -> list[tuple[float, CurvePoint]]:
        first = self.places[0.0]
        known = [(float(first.to(place) @ self.chord), place) for place in self.places.values()]
        chosen: list[tuple[float, CurvePoint]] = []
        for s, place in sorted(known, key=lambda node: abs(node[0] - distance)):
            if all(abs(s - other) >= MIN_SPACING * self.length for other, _ in chosen):
                chosen.append((s, place))
        return chosen[:MAX_NODES]

    def _multipliers(self, place: CurvePoint) -> Multipliers:
        same = place.multipliers.paired == self.paired
        return place.multipliers if same else Multipliers(place.matrix, self.paired)

    # ------------------------------------------------------------------ events

    def explained(self, low: float, high: float) -> Iterator[Bifurcation]:
        """Yield the bifurcations between two distances."""
        a, b = self.places[low], self.places[high]
        kind = self._kind(a, b)
        if kind == "none":
            return
        middle = 0.5 * (low + high)
        try:
            found = None if kind == "several" else self._located(kind, low, high)
            if found is None and high - low > MIN_SEGMENT:
                self.at(middle)
        except (NotConvergedError, ValueError):
            yield self._event("unresolved", a, a, b)
            return
        if found is not None:
            yield self._event(kind, found, a, b)
        elif high - low > MIN_SEGMENT:
            yield from self.explained(low, middle)
            yield from self.explained(middle, high)
        else:
            yield self._event(self._kind_of_short(a, b), a, a, b)

    def _event(self, kind: str, place: CurvePoint, a: CurvePoint, b: CurvePoint) -> Bifurcation:
        change = int(self._change(a, b) @ COUNTS)
        kind = kind if kind != "apart" else "collision" if self.paired else "torus"
        tangent = place.tangent * np.append(place.mapping.units, self.problem.span)
        value, *ends = (self.problem.value(each.u) for each in (place, a, b))
        interval = (min(ends), max(ends)) if kind == "unresolved" else (value, value)
        return Bifurcation(kind, value, interval, change, place.motion(), tangent, self.after)

    def _change(self, a: CurvePoint, b: CurvePoint) -> Array:
        return np.asarray(self._multipliers(b).outside - self._multipliers(a).outside)

    def _turns(self, a: CurvePoint, b: CurvePoint) -> bool:
        return not self.level and bool(a.tangent[-1] * b.tangent[-1] < 0)

    def _kind(self, a: CurvePoint, b: CurvePoint) -> str:
        """Return the one bifurcation that explains the difference of two points, "none" or "several"."""
        change = self._change(a, b)
        if self._turns(a, b):
            return "fold" if list(np.abs(change)) == [1, 0, 0] else "several"
        return EVENTS.get(tuple(change)) or EVENTS.get(tuple(-change), "several")

    def _located(self, kind: str, low: float, high: float) -> CurvePoint | None:
        """Return the point of one bifurcation; None if its test function does not change sign."""
        from scipy.optimize import brentq

        a, b = self.places[low], self.places[high]
        known = int(min(self._multipliers(place).outside[2] for place in (a, b)))
        if kind in SIGNS:
            counts = [self._multipliers(place).count_at(SIGNS[kind]) for place in (a, b)]
            known = min(counts)
            if counts[0] != counts[1]:
                return a if counts[0] > known else b
        test = self._test(kind, known)
        if not test(a) * test(b) < 0:
            return None
        return self.at(brentq(lambda s: test(self.at(s)), low, high, xtol=LOCATION_TOLERANCE, rtol=LOCATION_TOLERANCE))

    def _test(self, kind: str, known: int) -> Callable[[CurvePoint], float]:
        if kind == "fold":
            return lambda place: float(place.tangent[-1])
        if kind == "apart":
            return lambda place: self._multipliers(place).apart(known)
        return lambda place: self._multipliers(place).distance(SIGNS[kind], known)

    def _kind_of_short(self, a: CurvePoint, b: CurvePoint) -> str:
        """Return the kind of bifurcation of a short segment in which no single one explains the difference."""
        change = self._change(a, b)
        (moved,) = np.nonzero(change)
        if moved.size == 1:
            return "fold" if self._turns(a, b) and change[0] % 2 else ("branching", "doubling", "apart")[moved[0]]
        crossed = self._multipliers(a).count_at(1) > self._multipliers(self.places[0.0]).count_at(1)
        return "branching" if crossed and not moved.size else "unresolved"
