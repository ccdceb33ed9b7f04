"""Orbit of two bodies along a motion: the period of each revolution and the precession of the apsides."""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any, NamedTuple

import numpy as np
from typing_extensions import override

from poinsot.analysis.line_spectrum import lines_of
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import level_of_user
from poinsot.propagation.trajectory import OfTwoBodies
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array

__all__ = ["Revolutions", "apsidal_precession", "revolutions"]

MAX_STEP = 2 * np.pi / 8
"""Largest step between two times, radians of longitude."""
NEWTON_STEPS = 8
"""Number of steps for the time of a passage; the interpolation is nearly linear there."""
MIN_ECCENTRICITY = 1e-12
"""Smallest eccentricity that is not rounding."""
MAX_RATE_ERROR = 0.01
"""Largest relative error of an unresolved rate that causes no warning."""
ECCENTRICITY_LINES = 2
"""Number of lines of the eccentricity vector: the free one, and the one forced at the orbital frequency."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Revolutions(Summarized):
    """Revolutions of two bodies about each other: passages through the longitude of the first time.

    For an ensemble the axis of the members is first, and rows of members with fewer passages end in NaN.

    Attributes
    ----------
    times : array (k + 1,)
        Times of the passages, including the first time.
    mean_period : float
        Mean period, 2 pi divided by the slope of the straight line fitted to the longitude at all times.

    Examples
    --------
    >>> found = pt.analysis.revolutions(pair_motion)
    >>> bool(np.all(np.abs(found.periods - found.mean_period) <= found.variation))
    True
    """

    times: Array
    mean_period: Any

    @property
    def periods(self) -> Array:
        """Duration of each revolution; shape (k,)."""
        return np.diff(self.times, axis=-1)

    @property
    def variation(self) -> Any:
        """Difference of the longest and the shortest period; NaN without whole revolutions."""
        longest, shortest = (way(self.periods, axis=-1, initial=np.nan) for way in (np.fmax.reduce, np.fmin.reduce))
        return longest - shortest

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Revolutions of two bodies: {self.periods.shape[-1]}", {
            "mean period": formatted(self.mean_period),
            "longest less shortest period": formatted(self.variation),
        }


@checked
def revolutions(motion: OfTwoBodies) -> Revolutions:
    """Return the revolutions of two bodies: the times at which the secondary returns to its first longitude.

    The longitude is the angle of the line of centres about the initial total angular momentum, which is constant
    without external forces. Between the times a polynomial of fifth degree interpolates position, velocity and
    acceleration. With dense output, the times are accurate to machine precision. Otherwise the error relative to the
    period decreases as the sixth power of the step: 6e-8, 9e-10 and 1.4e-11 for an eccentricity of 0.1 and 12, 24 and
    48 times per revolution. For an elongated primary that rotates fast, count the times per half rotation instead.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble, with at least eight times per revolution.

    Returns
    -------
    Revolutions
        Times of the passages and periods.

    Raises
    ------
    ValueError
        If the longitude advances by more than an eighth of a revolution between two times.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(ball, ball, G=0.5)
    >>> start = pair.state((1, 0, 0), (0, 1.1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
    >>> motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, 30, 301), dense=True)
    >>> pt.analysis.revolutions(motion).periods.round(6), round(2 * np.pi / 0.79**1.5, 6)  # a = 1 / (2 - v^2)
    (array([8.948273, 8.948273, 8.948273]), 8.948273)
    """
    if not motion.is_ensemble:
        return Revolutions(_passages(motion), _mean_period(motion))
    rows = [_passages(member) for member in motion]
    most = max(map(len, rows))
    times = np.array([np.pad(row, (0, most - len(row)), constant_values=np.nan) for row in rows])
    return Revolutions(times, np.array([_mean_period(member) for member in motion]))


@checked
def apsidal_precession(motion: OfTwoBodies) -> Any:
    """Return the precession rate of the apsides of two bodies, positive in the direction of the motion.

    The osculating eccentricity vector, as a complex number in the plane normal to the total angular momentum, is a sum
    of lines: a free line, which rotates with the apsides, and forced lines near the orbital frequency. The rate is the
    frequency of the strongest line slower than half the mean motion. The fit uses all times and is valid for any free
    eccentricity, however small.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble, at 48 or more evenly spaced times.

    Returns
    -------
    float or array (members,)
        Radians per unit of time. NaN if there is no such line, as on a circular orbit.

    Raises
    ------
    ValueError
        If the times are not evenly spaced, or fewer than 48.

    Examples
    --------
    >>> disc = pt.Body((0.3, 0.3, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(disc, pt.Body((1e-9, 1e-9, 1e-9), mass=1e-6), G=1.0)
    >>> start = pair.kick(pair.synchronous(distance=10.0, primary_rate=0.5), (0, 1e-4, 0))
    >>> motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, 4000, 801))
    >>> rate = pt.analysis.apsidal_precession(motion)
    >>> (rate / 10**-1.5).round(5)  # 3/2 (C - A) / (m r^2) of the mean motion
    np.float64(0.0015)
    """
    if motion.is_ensemble:
        return np.array([apsidal_precession(member) for member in motion])
    moving = _moving(motion)
    across = moving.x + 1j * moving.y
    speed = moving.vx + 1j * moving.vy
    turning = (np.conj(across) * speed).imag
    vector = -1j * speed * turning / np.asarray(two_bodies(motion.system).mu) - across / motion.distance
    lines = lines_of(vector, motion.times, ECCENTRICITY_LINES)
    mean_motion = abs(moving.longitude[-1] - moving.longitude[0]) / abs(motion.times[-1] - motion.times[0])
    slow = np.flatnonzero(
        (np.abs(lines.frequencies) < mean_motion / 2) & (np.abs(lines.amplitudes) > MIN_ECCENTRICITY)
    )[:1]
    if not slow.size:
        return np.float64(np.nan)
    rate, error = lines.frequencies[slow[0]], lines.errors[slow[0]]
    if not lines.resolved[slow[0]] and error > MAX_RATE_ERROR * abs(rate):
        warnings.warn(
            f"apsidal_precession should be resolved, but its standard error is {error:.2g} at a rate of {rate:.2g}: "
            "another line is close, or the rate changes. Propagate for a longer time.",
            stacklevel=level_of_user(),
        )
    return rate


class _Moving(NamedTuple):
    """Place and velocity across the total angular momentum, and the longitude there."""

    x: Array
    y: Array
    vx: Array
    vy: Array
    longitude: Array


def _axes(motion: OfTwoBodies) -> Array:
    """Return two axes across the angular momentum of the first time, the first one towards the secondary."""
    normal, place = motion.angular_momentum_space[0], motion.position[0]
    normal = normal * np.sign(normal @ np.cross(place, motion.velocity[0]))
    first = place - (place @ normal) / (normal @ normal) * normal
    second = np.cross(normal, first)
    return np.stack([first / np.linalg.norm(first), second / np.linalg.norm(second)], axis=-1)


def _moving(motion: OfTwoBodies) -> _Moving:
    axes = _axes(motion)
    place, speed = (np.moveaxis(vectors @ axes, -1, 0) for vectors in (motion.position, motion.velocity))
    return _Moving(place[0], place[1], speed[0], speed[1], np.unwrap(np.arctan2(place[1], place[0])))


def _mean_period(motion: OfTwoBodies) -> Any:
    since, longitude = motion.times - np.mean(motion.times), _moving(motion).longitude
    with np.errstate(invalid="ignore", divide="ignore"):
        return 2 * np.pi * (since @ since) / np.abs(since @ longitude)


def _passages(motion: OfTwoBodies) -> Array:
    """Return the times of the passages of one motion."""
    way = 1 if motion.times[-1] >= motion.times[0] else -1
    t, moving = motion.times, _moving(motion)
    ax, ay = np.moveaxis(motion.acceleration @ _axes(motion), -1, 0)
    x, y, vx, vy, longitude = moving
    square = x * x + y * y
    rate = (x * vy - y * vx) / square
    change = (x * ay - y * ax) / square - 2 * rate * (x * vx + y * vy) / square
    if np.any(np.abs(rate[1:] * np.diff(t)) > MAX_STEP):
        raise ValueError(
            "times must be at least eight in each revolution, got a step of "
            f"{np.max(np.abs(rate[1:] * np.diff(t))):.3g} radians. Propagate to more times."
        )
    goals = way * 2 * np.pi * np.arange(1, 1 + int(way * longitude[-1] / (2 * np.pi)))
    i = np.clip(np.searchsorted(way * longitude, way * goals) - 1, 0, max(t.size - 2, 0))
    if not goals.size:
        return t[:1].copy()
    h = t[i + 1] - t[i]
    ends = [(longitude[j], h * rate[j], h * h * change[j]) for j in (i, i + 1)]
    polynomial = _quintic(*ends)
    s = (goals - longitude[i]) / (longitude[i + 1] - longitude[i])
    for _ in range(NEWTON_STEPS):
        value, slope = _horner(polynomial, s)
        s = s - (value - goals) / slope
    found = t[i] + s * h
    if motion.has_dense_output:
        found = _polished(motion, found)
    return np.concatenate([t[:1], found])


def _polished(motion: OfTwoBodies, times: Array) -> Array:
    """Return the times of passages by the dense output."""
    axes = _axes(motion)
    for _ in range(2):
        state: Any = motion(times)
        place = state.position @ axes
        speed = state.momentum @ axes / float(two_bodies(motion.system).reduced_mass)
        # near the passage the second component is the longitude times the first
        times = times - place[:, 1] / speed[:, 1]
    return times


def _quintic(start: tuple[Array, Array, Array], end: tuple[Array, Array, Array]) -> list[Array]:
    """Return the coefficients of the polynomial on [0, 1] with values, rates and second derivatives at both ends."""
    a, b, c = start[0], start[1], start[2] / 2
    value, rate, change = end[0] - a - b - c, end[1] - b - 2 * c, end[2] - 2 * c
    third, fifth = 10 * value - 4 * rate + change / 2, 6 * value - 3 * rate + change / 2
    return [a, b, c, third, -15 * value + 7 * rate - change, fifth]


def _horner(coefficients: list[Array], s: Array) -> tuple[Array, Array]:
    """Return a polynomial and its derivative."""
    value, slope = 0 * s, 0 * s
    for coefficient in reversed(coefficients):
        value, slope = value * s + coefficient, slope * s + value
    return value, slope
