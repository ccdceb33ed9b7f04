"""Indicators of chaos from the growth of tangent vectors.

The length of a tangent vector is |u|, u = (rotation vector, change of angular momentum / unit), body axes. The unit
affects the indicators at finite times, not their limits.
"""

from __future__ import annotations

import dataclasses
import itertools
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack, override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times, rounded
from poinsot.display.progress import bar
from poinsot.errors import PropagationInterrupted
from poinsot.integration.report import Report
from poinsot.integration.rows import Memory, Rows
from poinsot.integration.scaling import fastest_rates
from poinsot.kinematics.state import AnyState, changed
from poinsot.printable import quoted
from poinsot.propagation.arguments import checked_settings
from poinsot.propagation.dataset import dataset_of_result
from poinsot.propagation.ensemble_of_results import Analysis, analysed_in_chunks
from poinsot.propagation.variational_run import MAX_COORDINATES_TOGETHER, UserUnits, VariationalRun
from poinsot.quantities import Array, Times
from poinsot.records.members import members_of
from poinsot.records.units import DerivedUnits
from poinsot.storage.chunk_plan import Chunking, plan_of
from poinsot.storage.run_record import RunRecord
from poinsot.systems.system import System
from poinsot.systems.times_and_states import checked_times

if TYPE_CHECKING:
    import xarray

__all__ = ["ChaosIndicators", "LyapunovSpectrum", "chaos_indicators", "lyapunov_spectrum"]

FOUND = ("growth", "fli", "megno", "mean_megno", "gali")

SAMPLES_PER_TURN = 8
"""Number of samples of the growth in 2 pi of the fastest angle, for the integrals of MEGNO."""

MAX_STEPS = 1e8
"""Largest number of sampling steps, each of which stores some numbers."""

ORTHOGONALISATION_ANGLE = 10.0
"""Advance of the fastest angle between two orthogonalisations of the vectors, radians."""

MAX_SAMPLE_GROUPS = 4
"""Number of groups with common samples among members whose rates differ by less than a factor of two."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class ChaosIndicators(Summarized):
    """Chaos indicators from the growth of tangent vectors; arrays (n,) along the times, (members, n) for an ensemble.

    Attributes
    ----------
    system : System
        System that was integrated.
    times : array (n,)
        Times of the indicators.
    start : float or array (members,)
        Time of the initial state.
    momentum_unit : float or array (members,)
        Angular momentum that is compared with a rotation by one radian.
    units : array (k,) or (members, k)
        Units of the norm |u|, u = (rotation vector, change of angular momentum, body axes, variables of parts) / units:
        1 for angles, `momentum_unit` for momenta, and about ten times their size for other variables.
    vectors : array (count, k)
        Initial tangent vectors u, with k = 6 without parts, 18 for two bodies (see `StateTransition.coordinates`), and
        2 for planar motion, where u is along the third axis.
    growth : array
        Growth ln |u(t)| / |u(0)| of the first vector.
    fli : array
        Fast Lyapunov indicator: the largest growth so far, at least 0 (Froeschle et al. 1997, CMDA 67, 41).
    megno : array
        MEGNO Y = 2/T int (d ln |u| / dt) t dt, with the time T since the initial state (Cincotta and Simo 2000, A&AS
        147, 205).
    mean_megno : array
        Mean of Y since the initial state: 2 for regular motion, less near a stable periodic motion, T lyapunov / 2 for
        chaos.
    gali : array
        GALI, the volume of the unit vectors, which decays exponentially in chaos down to rounding (Skokos et al. 2007,
        Physica D 231, 30).
    failures : dict
        Map from the number of a failed member to the reason; its rows are NaN from the time of failure.
    run : RunRecord
        Method, number of steps, tolerance and versions.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> found = pt.analysis.chaos_indicators(pt.System(body), start, [500.0])
    >>> found.lyapunov.round(3), found.units.round(2)
    (array([0.014]), array([1. , 1. , 1. , 1.7, 1.7, 1.7]))
    """

    system: System
    times: Array
    start: Any
    momentum_unit: Any
    units: Array
    vectors: Array
    growth: Array
    fli: Array
    megno: Array
    mean_megno: Array
    gali: Array
    failures: dict[int, str]
    run: RunRecord

    @property
    def lyapunov(self) -> Array:
        """Growth divided by the time since the initial state, which tends to the maximal Lyapunov exponent; 1/time."""
        since = np.abs(self.times - np.asarray(self.start)[..., None])
        return np.asarray(self.growth / np.where(since > 0, since, np.nan))

    @property
    def dataset(self) -> xarray.Dataset:
        """Indicators as an xarray Dataset along `time`, with units and provenance."""
        units, along = DerivedUnits(self.system.units), ("time",)
        found = {
            "growth": (along, self.growth, "1", "ln |u(t)| / |u(0)| of the first tangent vector"),
            "fli": (along, self.fli, "1", "fast Lyapunov indicator"),
            "megno": (along, self.megno, "1", "MEGNO"),
            "mean_megno": (along, self.mean_megno, "1", "mean MEGNO since the start"),
            "gali": (along, self.gali, "1", f"GALI_{len(self.vectors)}"),
            "lyapunov": (along, self.lyapunov, units.per_time, "maximal Lyapunov exponent"),
            "initial_time": ((), self.start, units.time, "time of the start"),
            "momentum_unit": ((), self.momentum_unit, units.momentum, "unit of momenta in tangent vectors"),
            "unit": (("coordinate",), self.units, "", "units of the coordinates of tangent vectors"),
            "tangent_vector": (("vector", "coordinate"), self.vectors, "1", "tangent vectors at the start"),
        }
        attributes = self.run.attributes(self.failures)
        return dataset_of_result("Indicators of chaos", self.system, self.times, found, {}, attributes)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        last = np.atleast_1d(self.mean_megno[..., np.argmax(np.abs(self.times - np.mean(self.start)))])
        units = DerivedUnits(self.system.units)
        return f"Chaos indicators of {rounded(repr(self.system))}", {
            "times": formatted_times(self.times, units.time),
            "members": f"{last.size}, {len(self.failures)} failed" if self.mean_megno.ndim == 2 else "",
            "mean MEGNO at the last time": formatted(last),
            "fast Lyapunov indicator": formatted(self.fli),
            "maximal Lyapunov exponent": formatted(np.atleast_1d(self.lyapunov[..., -1]), units.per_time),
        }


@checked
def chaos_indicators(
    system: System,
    state: AnyState,
    times: Times,
    *,
    vectors: int = 1,
    momentum_unit: ArrayLike | None = None,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **chunking: Unpack[Chunking],
) -> ChaosIndicators:
    """Return Lyapunov exponent, FLI, MEGNO and GALI of a motion, or of each member of an ensemble.

    Parameters
    ----------
    system, state, formulation, tolerance, threads, progress
        Same as in `propagate`, with angular velocities in radians per unit of time. "planar" is a fast formulation for
        bodies that rotate about their third axis only.
    times : array (n,)
        Times of the indicators, all after the time of the state or all before it.
    vectors : int
        Number k of tangent vectors, initially orthogonal. `gali` is the GALI_k; GALI_2 is similar to the SALI.
    momentum_unit : float or array (members,), optional
        Angular momentum that is compared with a rotation by one radian. Default: the largest principal moment of the
        body times the angular velocity of its fastest orbit, or times its initial angular velocity without orbits. For
        two bodies: the largest moment of the primary times the orbital rate. The unit of the secondary is smaller in
        the ratio of the largest moments.
    **chunking
        Same as in `propagate`; the result is then the dataset of the indicators.

    Returns
    -------
    ChaosIndicators
        Indicators at the times.

    Raises
    ------
    ValueError
        If times lie on both sides of the time of the state.
    PropagationError
        If a single body stops. For an ensemble, `failures` contains the reason.
    PropagationInterrupted
        On Ctrl-C. Its `trajectory` contains the indicators, NaN for unfinished members.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> pt.analysis.chaos_indicators(pt.System(body), start, [500.0])
    Chaos indicators of System(Body(moments=[1.25, 1.0, 0.75]))
      times: 1, 500 ... 500
      mean MEGNO at the last time: 2.00...
      ...
    """
    if plan := plan_of(**chunking):
        given = {"vectors": vectors, "formulation": formulation, "tolerance": tolerance, "threads": threads}
        t, varied = checked_times(times, system), {"momentum_unit": momentum_unit}
        analysis = Analysis(chaos_indicators, system, state, t, given, varied)
        return cast("ChaosIndicators", analysed_in_chunks(plan, analysis, progress))
    run = VariationalRun.of(system, state, times, checked_settings(formulation, tolerance, threads, progress))
    if not 1 <= vectors <= run.size:
        raise ValueError(f"vectors must be a whole number from 1 to {run.size}, got {vectors}.")
    _check_one_way(np.sort(run.times), run.state.time)
    starts, rates = run.state.time, fastest_rates(system, run.state)
    units, directions = run.user_units(rates, momentum_unit), _directions(vectors, run.size)
    report = Report(np.zeros(starts.size, dtype=int))
    parts = {name: np.full((starts.size, run.times.size), np.nan) for name in FOUND}
    for who, step in _groups_of_steps(2 * np.pi / (SAMPLES_PER_TURN * rates), starts.size, run.times):
        some, own = run if who.size == starts.size else members_of(run, who), members_of(units, who)
        out = _Indicators(starts[who], _refined(run.times, starts[who], step), run.times, own)
        report.put(who, some.integrate(own.multiplied(directions), out.fine, out, ways=out.ways))
        for name, values in out.parts.items():
            parts[name][who] = values
        if report.interrupted:
            break
    result = ChaosIndicators(
        system,
        run.times,
        starts if run.is_ensemble else float(starts[0]),
        units.momentum if run.is_ensemble else units.momentum[0],
        (units.weights if run.is_ensemble else units.weights[0]) / run.units,
        directions,
        **{name: part if run.is_ensemble else part[0] for name, part in parts.items()},
        failures=run.failures(report),
        run=run.run(report),
    )
    run.check(report, result)
    return result


class _Indicators:
    """Indicators of an ensemble at some of the times of a run, in their order."""

    def __init__(self, starts: Array, fine: Array, wanted: Array, units: UserUnits) -> None:
        self.fine, self._starts, self._units = fine, starts, units
        self._wanted = np.searchsorted(fine, wanted)
        self._forwards = bool(np.max(wanted) > np.min(starts))
        self.ways = (self._forwards,)  # times between the starts of members belong to the earlier members
        self.parts = {name: np.full((len(starts), wanted.size), np.nan) for name in FOUND}

    def take(self, members: NDArray[np.int_], times: Array, rows: Rows) -> None:
        """Compute the indicators of some members."""
        if not members.size:
            return
        u, bits = self._units.divided(members, rows["vectors"]), rows["exponents"]
        lengths = np.sqrt(np.einsum("...k,...k->...", u, u))  # a norm along few components takes several times as long
        since = (times - self._starts[members, None]) * (1 if self._forwards else -1)
        growth = np.where(since > 0, np.log(lengths[..., 0]) + bits[..., 0] * np.log(2), 0.0)
        outwards = slice(None, None, 1 if self._forwards else -1)
        growth, since = growth[:, outwards], np.maximum(since, 0.0)[:, outwards]
        megno, mean = _megno(since, growth)
        fli = np.maximum.accumulate(np.maximum(growth, 0.0), axis=-1)
        for name, values in {"growth": growth, "fli": fli, "megno": megno, "mean_megno": mean}.items():
            self.parts[name][members] = values[:, outwards][:, self._wanted]
        self.parts["gali"][members] = _volume(u[:, self._wanted] / lengths[:, self._wanted, :, None])


def _megno(since: Array, growth: Array) -> tuple[Array, Array]:
    """Return Y and its mean along times since the start, with 2/T int t dg = 2 g - 2/T int g dt."""
    steps = np.diff(since, axis=-1, prepend=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        megno = np.where(since > 0, 2 * growth - 2 * _integral(steps, growth) / since, 0.0)
        return megno, np.where(since > 0, _integral(steps, megno) / since, 0.0)


def _integral(steps: Array, values: Array) -> Array:
    """Return the integral from zero, where the values are zero, by trapezoids; shape (members, n)."""
    sums = values.copy()
    sums[:, 1:] += values[:, :-1]
    return np.cumsum(0.5 * sums * steps, axis=-1)


def _volume(vectors: Array) -> Array:
    """Return the volume spanned by vectors; shape (..., count, k) to (...)."""
    triangle = np.linalg.qr(np.swapaxes(vectors, -1, -2), mode="r")
    return np.asarray(np.abs(np.prod(np.diagonal(triangle, axis1=-2, axis2=-1), axis=-1)))


# ---------------------------------------------------------------------- Lyapunov spectrum


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Summarized):
    """Lyapunov exponents of a motion since its initial state; for an ensemble the axis of the members is first.

    Attributes
    ----------
    system : System
        System that was integrated.
    times : array (n,)
        Times of the exponents.
    exponents : array (n, k)
        Exponents in 1/time in the order of the vectors, the largest first in the limit. k = 6, 18 for two bodies, or 2
        for planar motion. If all torques derive from potentials, each exponent has its opposite in the limit.
    failures : dict
        Map from the number of a failed member to the reason; its rows are NaN from the time of failure.
    run : RunRecord
        Method, number of steps, tolerance and versions.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> pt.analysis.lyapunov_spectrum(pt.System(body), start, [50.0, 100.0]).exponents.shape
    (2, 6)
    """

    system: System
    times: Array
    exponents: Array
    failures: dict[int, str]
    run: RunRecord

    @property
    def dataset(self) -> xarray.Dataset:
        """Exponents as an xarray Dataset along `time` and `vector`, with units and provenance."""
        unit = DerivedUnits(self.system.units).per_time
        found = {"exponents": (("time", "vector"), self.exponents, unit, "Lyapunov exponents")}
        attributes = self.run.attributes(self.failures)
        return dataset_of_result("Lyapunov spectrum", self.system, self.times, found, {}, attributes)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        members, units = self.exponents.ndim == 3, DerivedUnits(self.system.units)
        return f"Lyapunov spectrum of {rounded(repr(self.system))}", {
            "times": formatted_times(self.times, units.time),
            "members": f"{len(self.exponents)}, {len(self.failures)} failed" if members else "",
            "exponents at the last time": formatted(self.exponents[..., -1:, :].ravel(), units.per_time),
        }


@checked
def lyapunov_spectrum(
    system: System,
    state: AnyState,
    times: Times,
    *,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **chunking: Unpack[Chunking],
) -> LyapunovSpectrum:
    """Return all Lyapunov exponents, by repeated orthogonalisation of tangent vectors (Benettin et al. 1980).

    Parameters
    ----------
    system, state, formulation, tolerance, threads, progress
        Same as in `propagate`; all members of an ensemble must have one initial time.
    times : array (n,)
        Increasing times, all after the time of the state.
    **chunking
        Same as in `propagate`; the result is then the dataset of the spectrum.

    Returns
    -------
    LyapunovSpectrum
        Exponents at the times.

    Raises
    ------
    ValueError
        If times do not increase from the time of the state, or the system has a digital controller.
    PropagationError
        If a single body stops. For an ensemble, `failures` contains the reason.
    PropagationInterrupted
        On Ctrl-C. Its `trajectory` contains the spectrum at the times that all members have reached.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> damped = pt.System(body, pt.forces.LinearDamping(0.01))
    >>> found = pt.analysis.lyapunov_spectrum(damped, start, [50.0])
    >>> np.allclose(np.sum(found.exponents), -0.01 * np.sum(1 / body.moments))  # the divergence
    True
    """
    if system.dynamics.jumping:
        raise ValueError(
            f"system must have no digital controller, got {quoted(system.dynamics.jumping[0].name)}: a spectrum "
            "begins anew on the way, and so would its memory. Take chaos_indicators."
        )
    settings: dict[str, Any] = {"formulation": formulation, "tolerance": tolerance, "threads": threads}
    run, plan = _spectral_run(system, state, times, **settings), plan_of(**chunking)
    step = float(
        np.min(ORTHOGONALISATION_ANGLE / fastest_rates(system, run.state))
    )  # shared by all members, also in chunks
    if plan:
        analysis = Analysis(_spectrum, system, state, run.times, settings | {"step": step})
        return cast("LyapunovSpectrum", analysed_in_chunks(plan, analysis, progress))
    return _exponents(run, step, progress)


def _spectrum(
    system: System, state: AnyState, times: Array, *, step: float, progress: bool | None, **settings: Any
) -> LyapunovSpectrum:
    """Return the exponents of some members of an ensemble, with the step of all members."""
    return _exponents(_spectral_run(system, state, times, **settings), step, progress)


def _spectral_run(system: System, state: AnyState, times: Times, **settings: Any) -> VariationalRun:
    """Return the run of a spectrum; raise an error for several initial times, and for times that do not increase."""
    run = VariationalRun.of(system, state, times, checked_settings(**settings, progress=False))
    start = float(run.state.time[0])
    if np.any(run.state.time != start):
        other = run.state.time[run.state.time != start][0]
        raise ValueError(f"state must have one time for a spectrum, got {start:.10g} and {other:.10g}.")
    if run.times[0] <= start or run.times[0] > run.times[-1]:
        raise ValueError(
            f"times must rise from the state's time, {start:.10g}, got [{run.times[0]:.10g}, ... {run.times[-1]:.10g}]."
        )
    return run


def _exponents(run: VariationalRun, step: float, progress: bool | None) -> LyapunovSpectrum:
    """Return the exponents from vectors that are orthonormalised at least after each step."""
    vectors, start, exponents = _OrthonormalVectors(run), float(run.state.time[0]), list[Array]()

    def result() -> LyapunovSpectrum:
        found = np.stack(exponents, axis=1) if exponents else np.empty((len(run.state.time), 0, run.size))
        times = run.times[: len(exponents)]
        found = found if run.is_ensemble else found[0]
        return LyapunovSpectrum(run.system, times, found, vectors.failures, run.run(vectors.report))

    stops, shown = _refined(run.times, run.state.time, step), sys.stderr.isatty() if progress is None else progress
    try:
        with bar("time", float(stops[-1]) - start, shown) as advance:
            for stop in stops:
                before, report, end = vectors.time, *vectors.integrated(stop)
                run.check(report, result())
                vectors.orthonormalise(end)
                advance(float(stop - before))
                if stop == run.times[len(exponents)]:
                    exponents.append(vectors.growth / (stop - start))
    except KeyboardInterrupt:
        sentence = f"the integration was interrupted at t = {vectors.time:.10g} of {run.times[-1]:.10g}."
        raise PropagationInterrupted(sentence, vectors.time, result()) from None
    return result()


class _OrthonormalVectors:
    """As many tangent vectors as coordinates, which are integrated and orthonormalised in turn.

    Vectors with many coordinates are integrated one by one, each along its own copy of the motion.

    Attributes
    ----------
    growth : array (members, k)
        Logarithm of the growth of each vector, orthogonal to the vectors before it.
    report : Report
        Report of all integrations.
    time : float
        Time up to which the vectors are integrated.
    """

    def __init__(self, run: VariationalRun) -> None:
        k, members = run.size, len(run.state.time)
        self._run, self._copies = run, 1 if k <= MAX_COORDINATES_TOGETHER else k
        self._along = run if self._copies == 1 else run.repeated(self._copies)
        self._state, count = self._along.state, members * self._copies
        system, variables = self._along.system, self._along.variables
        self._units = self._along.user_units(fastest_rates(system, self._state))
        first = variables.from_state(self._state)[:, None]
        self._first = variables.to_phase(self._state.time[:, None], first)
        self._vectors: Array = np.broadcast_to(_directions(k, k), (members, k, k))
        self.growth, self.report = np.zeros((members, k)), Report(np.zeros(count, dtype=int))

    @property
    def time(self) -> float:
        return float(self._state.time[0])

    @property
    def failures(self) -> dict[int, str]:
        """Reasons why members stopped."""
        return {copy // self._copies: why for copy, why in self._run.failures(self.report).items()}

    def integrated(self, stop: float) -> tuple[Report, Memory]:
        """Integrate motions and vectors to a time; return the report and the rows there."""
        count, k = len(self._state.time), self._run.size
        together = k // self._copies
        rows = {"vectors": (together, k), "exponents": (together,)}
        end = Memory(self._along.variables, count, np.array([stop]), **rows)
        report = self._along.integrate(self._scaled, end.times, end, self._state)
        self.report.add(report)
        return report, end

    def orthonormalise(self, end: Memory) -> None:
        """Continue from the end of an integration, with orthonormal vectors."""
        stopped = list(self.report.stops)
        for (
            name,
            values,
        ) in end.phase.items():  # members that stopped continue from their initial state; their growth stays NaN
            values[stopped] = self._first[name][stopped]
        end.rows["vectors"][stopped, 0] = self._scaled[stopped]
        ends = self._units.divided(np.arange(len(self._state.time)), end.rows["vectors"][:, 0])
        turned, triangle = np.linalg.qr(np.swapaxes(ends.reshape(self._vectors.shape), -1, -2))
        sizes = np.abs(np.diagonal(triangle, axis1=-2, axis2=-1))
        self._vectors = np.swapaxes(turned, -1, -2)
        bits = end.rows["exponents"].reshape(self.growth.shape)
        self.growth = self.growth + np.log(sizes) + bits * np.log(2)
        each = changed(end.phase, lambda x: np.repeat(x[:: self._copies, 0], self._copies, 0))
        self._state = type(self._state).computed(each, end.times[0] + 0 * self._state.time)

    @property
    def _scaled(self) -> Array:
        """Vectors as initial values of an integration; shape (members, count, k)."""
        k = self._run.size
        return self._units.multiplied(self._vectors.reshape(-1, k // self._copies, k))


# ---------------------------------------------------------------------- samples and vectors


def _directions(count: int, k: int) -> Array:
    """Return perpendicular unit vectors, always the same, none along an axis."""
    return np.asarray(np.linalg.qr(np.random.default_rng(20061027).normal(size=(k, k)))[0][:count])


def _groups_of_steps(steps: Array, members: int, times: Array) -> Iterator[tuple[NDArray[np.int_], float]]:
    """Yield groups of members with similar steps, and one step for each group, which is not longer than any of these.

    The step does not depend on other members: it is the range of the times multiplied by 2 to the power of a multiple
    of 1/4, or the step that all members share.
    """
    if not steps.ndim:
        yield np.arange(members), float(steps)
        return
    length = float(np.ptp(times) or np.max(np.abs(times)) or 1.0)
    classes = np.floor(MAX_SAMPLE_GROUPS * np.log2(steps / length))
    for each in np.unique(classes):
        yield np.flatnonzero(classes == each), length * float(np.exp2(each / MAX_SAMPLE_GROUPS))


def _refined(times: Array, starts: Array, step: float) -> Array:
    """Return increasing times, with further times from the starts on, that are at most a step apart.

    Members with one initial time have the same times, whenever other members start.
    """
    times = np.sort(times)
    far = max(times[-1], np.max(starts)) - min(times[0], np.min(starts))
    if far > MAX_STEPS * step:
        raise ValueError(
            f"times must be at most {MAX_STEPS:.0e} steps of {step:.3g} from the state's time, got {far:.3g}. "
            "A step is a part of a turn of the body: is it as fast as that?"
        )
    pieces = [np.linspace(a, b, max(int(np.ceil((b - a) / step)), 1) + 1)[:-1] for a, b in itertools.pairwise(times)]
    before = times[0] - step * np.arange(1, max(np.ceil((times[0] - np.min(starts)) / step), 1))
    behind = times[-1] + step * np.arange(1, max(np.ceil((np.max(starts) - times[-1]) / step), 1))
    return np.unique(np.concatenate([before, *pieces, times[-1:], behind]))


def _check_one_way(times: Array, starts: Array) -> None:
    if times[0] < np.max(starts) and times[-1] > np.min(starts):
        raise ValueError(
            f"times must all lie after the state's time or all before, got [{times[0]:.10g}, {times[-1]:.10g}] "
            f"from {starts[0]:.10g}."
        )
