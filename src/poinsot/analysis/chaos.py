"""Indicators of chaos: what becomes of neighbours of a motion, to first order.

The distance of a neighbour is |u|, u = (rotation vector, change of angular momentum / unit), body axes. Exponents and
MEGNO do not depend on the unit in the limit of long times; it is about ten times the largest angular momentum of the
ensemble.
"""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.mechanics.samples import orbits_of, time_scale
from poinsot.mechanics.state import State, computed_state
from poinsot.mechanics.system import System
from poinsot.motion.coordinates import Coordinates
from poinsot.motion.ensemble import Ensemble, Outcome
from poinsot.motion.tangent import TangentRun
from poinsot.motion.trajectory import Run

__all__ = ["ChaosIndicators", "LyapunovSpectrum", "chaos_indicators", "lyapunov_spectrum"]

Array = NDArray[np.float64]

SAMPLES = 8
"""Of the growth for MEGNO's integrals, in 2 pi of the fastest angle."""

APART = 3.0
"""Radians of the fastest angle between two orthogonalisations of vectors."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class ChaosIndicators:
    """What the growth of tangent vectors says about motions; arrays (n,) along the times, (members, n) of an ensemble.

    Attributes
    ----------
    times : array (n,)
    growth : array
        ln |u(t)| / |u(0)| of the first vector.
    megno : array
        Y = 2/T int (d ln |u| / dt) t dt, T since the start (Cincotta and Simo 2000, A&AS 147, 205).
    mean_megno : array
        The mean of Y since the start: 2 for regular motion, about T lyapunov / 2 for chaotic.
    gali : array
        The volume that the unit vectors span: decays exponentially in chaos (Skokos et al. 2007, Physica D 231, 30).
    failures : dict
        Member -> why it stopped; NaN from there on.
    run : Run
    """

    times: Array
    start: Any
    growth: Array
    megno: Array
    mean_megno: Array
    gali: Array
    failures: dict[int, str]
    run: Run

    @property
    def lyapunov(self) -> Array:
        """The growth over the time since the start, which tends to the maximal Lyapunov exponent; 1/time."""
        since = np.abs(self.times - np.asarray(self.start)[..., None])
        return np.asarray(self.growth / np.where(since > 0, since, np.nan))

    @property
    def fli(self) -> Array:
        """The largest growth so far, at the times, the fast Lyapunov indicator (Froeschle et al. 1997)."""
        return np.maximum.accumulate(self.growth, axis=-1)

    def __repr__(self) -> str:
        last = np.atleast_1d(self.mean_megno[..., -1])
        return (
            f"ChaosIndicators(times={self.times.size}, members={last.size}, failed={len(self.failures)}, "
            f"mean_megno={np.nanmin(last):.4g} ... {np.nanmax(last):.4g})"
        )


def chaos_indicators(
    system: System,
    state: State,
    times: ArrayLike,
    *,
    vectors: int = 1,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> ChaosIndicators:
    """Return Lyapunov exponent, MEGNO, FLI and GALI of a motion, or of each member of an ensemble.

    Parameters
    ----------
    system, state, formulation, tolerance, threads, progress
        As in `propagate`; "planar" is for bodies that turn about their third axis alone, and fast.
    times : array (n,)
        All after the state's time or all before; none twice.
    vectors : int
        How many tangent vectors, at the start perpendicular to each other: `gali` is GALI_k of them (2: about SALI).

    Raises
    ------
    ValueError
        If times lie on both sides of the state's, or the torques jump where the attitude crosses something.
    PropagationInterrupted
        On Ctrl-C; its `trajectory` are the indicators, NaN where members are not done.
    """
    call = "chaos_indicators(system, state, times)"
    job = TangentRun(call, system, state, times, formulation, tolerance, threads, progress)
    _check_count(vectors, len(job.tangent))
    rising = np.sort(job.times)
    _check_one_way(rising, job.state.time)
    out = _Indicators(
        job, _refined(rising, job.state.time, SAMPLES / (2 * np.pi) * _fastest(system, job.state)), rising
    )
    job.integrate(_directions(vectors, len(job.tangent)), out.fine, out)
    order = slice(None, None, -1 if job.times.size > 1 and job.times[0] > job.times[1] else 1)
    found = [part[:, order] if job.members else part[0, order] for part in out.parts]
    start = job.state.time if job.members else job.state.time[0]
    growth, megno, mean, gali = found
    failures = dict(sorted(out.failures.items()))
    result = ChaosIndicators(job.times, start, growth, megno, mean, gali, failures, job.run(out))
    job.raise_interrupted(out, int(np.sum(np.isfinite(out.parts[0][:, -1]))), result)
    return result


class _Indicators(Outcome):
    """The indicators of an ensemble at some of its times."""

    def __init__(self, job: TangentRun, fine: Array, wanted: Array) -> None:
        members = len(job.state.time)
        super().__init__(members)
        self.fine, self._wanted, self._starts = fine, np.searchsorted(fine, wanted), job.state.time
        self.parts = [np.full((members, wanted.size), np.nan) for _ in range(4)]

    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        assert variables.companion is not None  # noqa: S101
        u, bits = variables.companion.read(rows[..., variables.companions])
        lengths = np.linalg.norm(u, axis=-1)
        growth = np.log(lengths[..., 0]) + bits[..., 0] * np.log(2)
        since = np.abs(times - self._starts[members, None])
        backwards = slice(None, None, 1 if times[-1] > self._starts[members[0]] else -1)
        megno, mean = (x[:, backwards] for x in _megno(since[:, backwards], growth[:, backwards]))
        gali = np.prod(np.linalg.svd(u[:, self._wanted] / lengths[:, self._wanted, :, None], compute_uv=False), axis=-1)
        for part, values in zip(self.parts, (growth, megno, mean), strict=False):
            part[members] = values[:, self._wanted]
        self.parts[3][members] = gali


def _megno(since: Array, growth: Array) -> tuple[Array, Array]:
    """Return Y and its mean along times since the start, with 2/T int t dg = 2 g - 2/T int g dt."""
    with np.errstate(invalid="ignore", divide="ignore"):
        megno = np.where(since > 0, 2 * growth - 2 * _integral(since, growth) / since, 0.0)
        return megno, np.where(since > 0, _integral(since, megno) / since, 0.0)


def _integral(since: Array, values: Array) -> Array:
    """Return the integral from zero, where the values are zero, by trapezoids; shape (members, n)."""
    x, y = (np.concatenate([np.zeros((len(part), 1)), part], axis=-1) for part in (since, values))
    return np.cumsum(0.5 * (y[:, 1:] + y[:, :-1]) * np.diff(x), axis=-1)


# ---------------------------------------------------------------------- the whole spectrum


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum:
    """The exponents of a motion since its start; of an ensemble the members come first.

    Attributes
    ----------
    times : array (n,)
    exponents : array (n, k)
        Largest first, 1/time; k = 6, or 2 of planar motion. Without damping each has its opposite, apart from how far
        the limit is away.
    run : Run
    """

    times: Array
    exponents: Array
    run: Run

    def __repr__(self) -> str:
        return f"LyapunovSpectrum(times={self.times.size}, exponents={self.exponents[..., -1, :].tolist()})"


def lyapunov_spectrum(
    system: System,
    state: State,
    times: ArrayLike,
    *,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> LyapunovSpectrum:
    """Return all Lyapunov exponents, by vectors that are orthogonalised now and then (Benettin et al. 1980).

    Parameters
    ----------
    system, state, formulation, tolerance, threads, progress
        As in `propagate`.
    times : array (n,)
        Rising, all after the state's time.

    Raises
    ------
    ValueError
        If times do not rise from the state's.
    """
    call = "lyapunov_spectrum(system, state, times)"
    job = TangentRun(call, system, state, times, formulation, tolerance, threads, progress)
    start = float(job.state.time[0])
    if np.any(job.state.time != start) or job.times[0] <= start or np.any(np.diff(job.times) < 0):
        raise ValueError(f"times must rise from the state's time, {start:.10g}, but they begin at {job.times[0]:.10g}.")
    k = len(job.tangent)
    stops = _refined(job.times, job.state.time, _fastest(system, job.state) / APART)
    vectors = np.broadcast_to(_directions(k, k), (len(job.state.time), k, k))
    total, now = np.zeros((len(vectors), k)), job.state
    kept: list[Array] = []
    for stop in stops:
        out = _Ends(len(vectors), k)
        job.integrate(vectors, np.array([stop]), out, now)
        job.raise_interrupted(out, 0, LyapunovSpectrum(job.times[: len(kept)], np.array(kept), job.run(out)))
        if out.failures:
            raise ValueError(f"state must lead to a motion without end, but {next(iter(out.failures.values()))}")
        turned, triangle = np.linalg.qr(np.swapaxes(out.vectors, -1, -2))
        vectors = np.swapaxes(turned, -1, -2)
        sizes = np.abs(np.diagonal(triangle, axis1=-2, axis2=-1))
        total = total + np.log(sizes) + out.bits * np.log(2)
        now = computed_state(out.quaternion[:, 0], out.conjugate_momenta[:, 0], np.full(len(vectors), stop))
        if stop == job.times[len(kept)]:
            kept.append(total / (stop - start))
    found = np.stack(kept, axis=1)
    return LyapunovSpectrum(job.times, found if job.members else found[0], job.run(out))


class _Ends(Ensemble):
    """States and tangent vectors at one time."""

    def __init__(self, members: int, k: int) -> None:
        super().__init__(members, 1, 0)
        self.vectors, self.bits = np.full((members, k, k), np.nan), np.zeros((members, k))

    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        assert variables.companion is not None  # noqa: S101
        super().take(members, times, rows, variables)
        u, bits = variables.companion.read(rows[:, 0, variables.companions])
        self.vectors[members], self.bits[members] = u, bits


# ---------------------------------------------------------------------- both


def _directions(count: int, k: int) -> Array:
    """Return perpendicular unit vectors, always the same, none along an axis."""
    return np.asarray(np.linalg.qr(np.random.default_rng(20061027).normal(size=(k, k)))[0][:count])


def _fastest(system: System, state: State) -> float:
    """Return the rate of the fastest angle that a motion needs to be looked at along: the orbit's, else the body's."""
    if any(True for _ in orbits_of(system)):
        return 1 / time_scale(system)
    return float(np.max(system.momentum_scale(state) / np.min(system.body.moments, axis=-1)))


def _refined(times: Array, starts: Array, per_time: float) -> Array:
    """Return rising times with so many more between the starts and them that there are `per_time` in a unit."""
    ends = np.union1d(times, [np.min(starts), np.max(starts)])
    pieces = [
        np.linspace(a, b, max(int(np.ceil((b - a) * per_time)), 1) + 1)[1:-1]
        for a, b in itertools.pairwise(ends)
    ]
    fine = np.union1d(times, np.concatenate(pieces)) if pieces else times
    return np.asarray(fine)


def _check_count(vectors: int, most: int) -> None:
    if not isinstance(vectors, int) or isinstance(vectors, bool) or not 1 <= vectors <= most:
        raise ValueError(f"vectors must be a whole number from 1 to {most}, but {vectors!r} came.")


def _check_one_way(times: Array, starts: Array) -> None:
    if times[0] < np.max(starts) and times[-1] > np.min(starts):
        raise ValueError(
            f"times must all lie after the state's time or all before, but [{times[0]:.10g}, {times[-1]:.10g}] came, "
            f"from {starts[0]:.10g}."
        )
