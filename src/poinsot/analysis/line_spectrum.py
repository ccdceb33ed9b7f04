"""Frequencies of a motion: decomposition of a signal into lines, and the drift of the lines.

A signal at uneven times is decomposed by least squares, see `uneven_lines.py`.

An evenly sampled signal is decomposed into lines a exp(i nu t) as by Laskar (1990, Icarus 88, 266; 1993, Physica D 67,
257): the highest maximum of the windowed spectrum of the residual gives the next line. Laskar's frequency of a single
line, the maximum itself, minimises the squares of the difference in the windowed inner product. Here all lines found
so far are fitted together in this sense, by the Gauss-Newton method, so that close lines do not bias each other. A
pair of lines in the place of one is fitted from the best pair of a grid of frequencies, since the maximum of the
residual about one line lies too far from both lines for the Gauss-Newton method to converge to them.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
import itertools
import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.analysis.uneven_lines import fitted_lines, grid_size
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import array_of, level_of_user, real_array, real_numbers, refuse_nonpositive
from poinsot.printable import kind_of
from poinsot.quantities import AngularVelocity, Times
from poinsot.records.units import PER_TIME

__all__ = ["LineSpectrum", "diffusion", "frequencies"]

Array = NDArray[Any]

WINDOW_POWER = 3
"""Power of the window (1 + cos pi x)^p; its main lobe reaches to p + 1 bins, farther lines fade as bins^-7."""
MIN_LINE_DISTANCE = 0.1
"""Smallest distance of two lines, in bins."""
MIN_STANDARD_ERRORS = 4
"""Smallest amplitude and distance of close lines, in standard errors."""
MAX_ERROR_GROWTH = 2
"""Largest growth of standard errors of other lines by a line whose residual is no noise."""
SLOW_LINE_BINS = 2
"""Frequency in bins below which the standard error of a line of a real signal includes an unknown mean."""
GRID_SPACING = 0.25
"""Distance in bins between the frequencies from which the fit of a pair starts."""
MAX_LINE_ERROR = 0.01
"""Largest standard error, in bins, of an unresolved line that causes no warning."""
MIN_RELATIVE_AMPLITUDE = 1e-3
"""Smallest amplitude, relative to the strongest line, of an unresolved line that causes a warning."""
CLUSTER_GAP = 16
"""Gap in bins below which lines are fitted in one step; other lines interact through the residual."""
NOTCH_BINS = 2
"""Number of bins about a line that the fit has emptied."""
NOISE_BINS = 16
"""Number of bins about a line, beyond the notch, in which the noise is measured."""
FALSE_ALARM = 1e-3
"""Probability that noise alone makes a line."""
MAX_ITERATIONS = 10
MAX_FREQUENCY_STEP = 0.25
"""Largest step of a frequency, in bins."""
MIN_STRENGTH_RATIO = 1 / 3
"""Smallest relative amplitude in the second half of a run at which a line may continue one of the first half."""
LINES_PER_HALF = 8
"""Number of lines fitted in each half of a run."""
UNEVENNESS_TOLERANCE = 1e-9
"""Tolerance of uneven times, in steps, in addition to their rounding."""
EXCLUDED = 16
"""Increase of the sum of squares, in units of the variance of the noise, that excludes an alias."""
MAX_GRID = 2**20
"""Largest number of frequencies of the spectrum of a signal at uneven times."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class LineSpectrum(Summarized):
    """Line spectrum of a signal, the strongest line first: sum of amplitudes * exp(i frequencies t), or its real part.

    For an array of signals, every attribute gains their axes first, and rows of signals with fewer lines end in NaN.

    Attributes
    ----------
    frequencies : array (lines,)
        Radians per unit of time, signed for a complex signal and not negative for a real one.
    amplitudes : complex array (lines,)
        Amplitudes in the unit of the signal, with the phase at t = 0.
    errors : array (lines,)
        Standard error of each frequency. The error of a resolved line follows from the residual of the signal in the
        bins about the line, which contains noise and omitted lines, and is zero for the mean of a real signal. The
        error of an unresolved line also covers the shift that the fit of a pair in its place causes.
    resolved : bool array (lines,)
        False if the residual within two turns over the run of a line exceeds the noise around it: another line is too
        close, or frequency or amplitude change during the run. False for absent lines.
    residual : float
        RMS residual, weighted by the window, or by 1/sigma^2 for uneven times.
    aliases : array (lines, 4) or None
        For uneven times the best other frequencies of each line, if the samples have a maximum of the spectrum there:
        fits of all lines with this line at the alias.
    alias_chi2 : array (lines, 4) or None
        Increase of the sum of squares by an alias, in units of the variance of the noise. A small one, such as below 9,
        does not exclude the alias.

    Examples
    --------
    >>> times = np.linspace(0, 100, 1001)
    >>> found = pt.analysis.frequencies(np.cos(2 * times) + 0.1 * np.cos(3.5 * times), times, 2)
    >>> found.frequencies.round(9), np.abs(found.amplitudes).round(9)
    (array([2. , 3.5]), array([1. , 0.1]))
    """

    frequencies: Array
    amplitudes: Array
    errors: Array
    resolved: Array
    residual: Any
    aliases: Array | None = None
    alias_chi2: Array | None = None

    @property
    def _unresolved(self) -> int:
        return int(np.count_nonzero(~self.resolved & np.isfinite(self.frequencies)))

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Lines of a signal: {self.frequencies.shape[-1]}", {
            "frequencies": formatted(self.frequencies, PER_TIME),
            "standard errors": formatted(self.errors, PER_TIME),
            "not resolved": formatted(self.frequencies[~self.resolved & np.isfinite(self.frequencies)], PER_TIME)
            if self._unresolved
            else "",
            "amplitudes": formatted(np.abs(self.amplitudes)),
            "residual": formatted(self.residual),
            "aliases not excluded": ""
            if self.aliases is None or self.alias_chi2 is None or not np.any(self.alias_chi2 < EXCLUDED)
            else formatted(self.aliases[self.alias_chi2 < EXCLUDED], PER_TIME),
        }


@checked
def frequencies(
    signal: ArrayLike,
    times: Times,
    count: int = 10,
    *,
    sigma: ArrayLike | None = None,
    highest: AngularVelocity | None = None,
) -> LineSpectrum:
    """Return the line spectrum of a signal: frequencies, amplitudes and errors of the frequencies.

    All lines together minimise the mean of w |signal - sum of a exp(i nu t)|^2, or of w |signal - Re sum|^2 for a real
    signal. For even times w is the window (1 + cos pi x)^3, x from -1 to 1 along the samples, and two lines closer than
    about two turns over the run are fitted as a pair if the noise allows it. For uneven times w is 1/sigma^2, and lines
    are at least half a turn over the run apart. A warning names strong unresolved lines, whose errors are large.

    Parameters
    ----------
    signal : array (..., n)
        Real or complex signal: an angle, q0 + i q3, G1 + i G2, exp(i theta). Each signal of an array is decomposed
        alone.
    times : array (n,) or float
        Times with any spacing and gaps, or the time step, with the first sample at t = 0.
    count : int
        Largest number of lines, a mean included. The result contains fewer if the residual is white noise or rounding.
    sigma : float or array (..., n), optional
        Standard deviations of the samples, which then are fitted as at uneven times. Without them, and where the
        residual exceeds them, errors follow from the residual.
    highest : float, optional
        Highest frequency of a line, radians per unit of time, for uneven times. Default: pi/(median step).

    Returns
    -------
    LineSpectrum
        Lines, the strongest first.

    Raises
    ------
    TypeError, ValueError
        If the signal is not finite or has fewer than 8 samples per line or 32 in all, or sigma is not positive.
        Aliasing of frequencies beyond pi/step of even times cannot be detected.

    Examples
    --------
    >>> times = np.linspace(0, 100, 1001)
    >>> pt.analysis.frequencies(np.exp(-1.5j * times), times, 1).frequencies.round(9)
    array([-1.5])
    """
    refuse_nonpositive("count", count)
    signals, t = _samples(signal, times, count)
    even = sigma is None and highest is None and _evenness(t)[0]
    found = _lines(*_ascending(signals, t), count) if even else _uneven_lines(signals, t, count, sigma, highest)
    _warn_of_merged(found, np.ptp(t) / (2 * np.pi))
    return found


def lines_of(signal: ArrayLike, times: Times, count: int) -> LineSpectrum:
    """Return the lines of an evenly sampled signal without a warning of unresolved lines."""
    return _lines(*_checked(signal, times, count), count)


def _lines(signals: Array, t: Array, count: int) -> LineSpectrum:
    rows = [_decomposed(row, t, count) for row in signals.reshape(-1, t.size)]
    return _spectrum_of(rows, signals.shape[:-1])


def _uneven_lines(
    signals: Array, t: Array, count: int, sigma: ArrayLike | None, highest: AngularVelocity | None
) -> LineSpectrum:
    """Return the lines of signals at times in any order with any spacing."""
    order, run = np.argsort(t, kind="stable"), float(np.ptp(t))
    times = t[order]
    if run == 0:
        raise ValueError(f"times must differ, got {t.size} times {t[0]}.")
    steps = np.diff(times)
    limit = float(np.pi / np.median(steps[steps > 0]) if highest is None else real_array("highest", highest, ()))
    refuse_nonpositive("highest", limit)
    if not limit * run >= np.pi or not np.isfinite(limit):
        raise ValueError(
            f"highest must be finite, and times the run of the times, {run:.6g}, at least pi, got {limit:.6g}. "
            "A slower line has less than half a cycle in the run."
        )
    if (size := grid_size(run, limit, not np.iscomplexobj(signals))) > MAX_GRID:
        raise ValueError(
            f"highest must be below {limit * MAX_GRID / size:.6g} for a run of {run:.6g}, got {limit:.6g}. "
            f"A spectrum has at most {MAX_GRID} frequencies."
        )
    weights = None if sigma is None else _sigmas(sigma, signals.shape)[..., order].reshape(-1, t.size)
    rows = [
        fitted_lines(row, times, None if weights is None else weights[i], limit, count)
        for i, row in enumerate(signals[..., order].reshape(-1, t.size))
    ]
    return _spectrum_of(rows, signals.shape[:-1])


def _sigmas(sigma: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return positive standard deviations of the shape of the signals."""
    given = real_numbers("sigma", sigma)
    refuse_nonpositive("sigma", given, "Give the standard deviation of a sample.")
    try:
        return np.broadcast_to(given, shape)
    except ValueError:
        raise ValueError(f"sigma must have the shape of the signal, {shape}, got shape {given.shape}.") from None


def _spectrum_of(rows: Sequence[tuple[Any, ...]], shape: tuple[int, ...]) -> LineSpectrum:
    """Return the spectrum of signals, whose attributes are given for each; absent lines are NaN and not resolved."""
    each = dict(zip([field.name for field in dataclasses.fields(LineSpectrum)], zip(*rows, strict=True), strict=False))
    residual = np.reshape(each.pop("residual"), shape)[()]
    lines = {name: _padded(values, False if name == "resolved" else np.nan, shape) for name, values in each.items()}
    return LineSpectrum(residual=residual, **lines)


def _padded(rows: Sequence[Array], missing: float, shape: tuple[int, ...]) -> Array:
    """Return rows of different lengths as one array (*shape, longest, ...)."""
    longest = max(len(row) for row in rows)
    ends = [(0, 0)] * (rows[0].ndim - 1)
    padded = [np.pad(row, [(0, longest - len(row)), *ends], constant_values=missing) for row in rows]
    return np.reshape(padded, (*shape, longest, *rows[0].shape[1:]))


def _warn_of_merged(found: LineSpectrum, run: float) -> None:
    """Warn of strong unresolved lines; the length of the run is in turns per unit of frequency."""
    turns = found.errors * run
    size = np.abs(found.amplitudes)
    strongest = np.max(size, axis=-1, keepdims=True, initial=0, where=np.isfinite(size))
    merged = ~found.resolved & (turns > MAX_LINE_ERROR) & (size > MIN_RELATIVE_AMPLITUDE * strongest)
    if np.any(merged):
        warnings.warn(
            f"frequencies should be resolved, but {np.count_nonzero(merged)} of {np.count_nonzero(np.isfinite(size))} "
            f"lines are not, with standard errors of up to {np.max(turns[merged]):.2g} turns over the run: another "
            "line is closer than about two turns, or the line drifts. Propagate for a longer time, or raise count.",
            stacklevel=level_of_user(),
        )


@checked
def diffusion(signal: ArrayLike, times: Times, count: int = 1) -> Array:
    """Return the relative change of the strongest frequencies of a signal between the two halves of a run.

    The change nu2/nu1 - 1 of a regular motion does not exceed the errors of the frequencies; a larger one indicates
    chaos (Laskar 1993). The nearest line of the second half with at least a third of the amplitude continues a line of
    the first half. The function ignores a mean, and lines slower than one turn in half the run. Lines closer than about
    two turns over half the run, see `LineSpectrum.resolved`, cause a change without chaos.

    Parameters
    ----------
    signal : array (..., n)
        Real or complex signal, as in `frequencies`.
    times : array (n,) or float
        Evenly spaced times, or the time step.
    count : int
        Number of lines to follow.

    Returns
    -------
    array (..., count)
        Relative changes, NaN for absent lines.

    Raises
    ------
    TypeError, ValueError
        If `frequencies` raises an error for one of the halves.

    Examples
    --------
    >>> times = np.linspace(0, 100, 1001)
    >>> pt.analysis.diffusion(np.cos(2 * times + 1e-4 * times**2), times).round(4)
    array([0.005])
    """
    refuse_nonpositive("count", count)
    lines = max(count, LINES_PER_HALF)
    signals, t = _checked(signal, times, lines, halves=2)
    half = t.size // 2
    slowest = 2 * np.pi / (t[half] - t[0])
    drifts = np.full((*signals.shape[:-1], count), np.nan)
    for member in np.ndindex(signals.shape[:-1]):
        parts = (slice(None, half), slice(-half, None))
        first, second = (_fitted(signals[member][part], lines).lines(t[part])[:2] for part in parts)
        drift = _followed(_faster(first, slowest), _faster(second, slowest))[:count]
        drifts[member][: drift.size] = drift
    return drifts


# ---------------------------------------------------------------------- the fit


class _LineFit:
    """Fit of the lines of one signal on centred samples: turns per sample and complex amplitudes at the centre.

    The turns are stored as multiples of 2^-26 and a remainder, because their rounding would affect the residual.
    """

    def __init__(self, signal: Array) -> None:
        n = signal.size
        self.signal, self.n, self.is_real = signal, n, not np.iscomplexobj(signal)
        self.x = (2 * np.arange(n) - (n - 1)) / n
        self.window = (1 + np.cos(np.pi * self.x)) ** WINDOW_POWER
        self.coarse, self.fine, self.amplitudes, self.rest = np.empty(0), np.empty(0), np.empty(0, complex), signal
        self.noise = np.finfo(float).eps * np.max(np.abs(signal))

    @property
    def turns(self) -> Array:
        """Frequencies, turns per sample."""
        return self.coarse + self.fine

    def waves(self, lines: Array) -> Array:
        """Return exp(2 pi i turns samples) of some lines, shape (lines, n), to machine precision for any turns."""
        block = math.isqrt(self.n)
        starts = np.arange(0, self.n, block) - (self.n - 1) / 2
        coarse, fine = self.coarse[lines, None], self.fine[lines, None]
        far, near = (_wave(coarse, fine, samples) for samples in (starts, np.arange(block)))
        return (far[:, :, None] * near[:, None, :]).reshape(lines.size, starts.size * block)[:, : self.n]

    def columns(self, lines: Array) -> Array:
        """Return the derivatives of some lines by the parts of their amplitudes and by nu times half the run."""
        waves = self.waves(lines)
        columns = np.concatenate([waves, 1j * waves, 1j * self.amplitudes[lines, None] * self.x * waves])
        return columns.real if self.is_real else columns

    def sum_of(self, lines: Array) -> Array:
        """Return the sum of some lines."""
        total: Array = self.amplitudes[lines] @ self.waves(lines)
        return total.real if self.is_real else total

    @property
    def clusters(self) -> list[Array]:
        """Indices of the lines in groups of neighbouring lines."""
        order = np.argsort(self.turns)
        gaps = np.flatnonzero(np.diff(self.turns[order]) > CLUSTER_GAP / self.n) + 1
        return [cluster for cluster in np.split(order, gaps) if cluster.size]

    def gaps(self) -> Array:
        """Return the distance of each line to the nearest line or mirror image, in bins."""
        gaps = np.abs(_reduced(self.turns[:, None] - self.turns)) * self.n
        np.fill_diagonal(gaps, np.inf)
        if self.is_real:
            images = np.abs(_reduced(self.turns[:, None] + self.turns)) * self.n
            gaps = np.minimum(gaps, np.where(self.turns[:, None] * self.turns == 0, np.inf, images))
        nearest: Array = np.min(gaps, axis=1, initial=np.inf)
        return nearest

    @property
    def residual(self) -> float:
        """RMS residual."""
        return float(np.sqrt(np.average(np.abs(self.rest) ** 2, weights=self.window)))

    def with_lines(self, turns: ArrayLike, without: int | None = None) -> _LineFit:
        """Return the fit of all lines and further ones, without one of the present lines."""
        fit, started = copy.copy(self), np.atleast_1d(turns)
        vars(fit).pop("uncertainties", None)
        present = np.arange(self.turns.size) != (-1 if without is None else without)
        coarse = np.rint(started * 2**26) / 2**26
        fit.coarse = np.append(self.coarse[present], coarse)
        fit.fine = np.append(self.fine[present], started - coarse)
        fit.amplitudes = np.append(self.amplitudes[present], np.zeros(started.size))
        if without is not None:
            fit.rest = self.rest + self.sum_of(np.flatnonzero(~present))
        clusters = fit.clusters
        for _ in range(MAX_ITERATIONS):
            if max([fit._step(cluster) for cluster in clusters]) <= fit.noise:
                break
        fit.rest = fit.signal - fit.sum_of(np.arange(fit.fine.size))
        return fit

    def best_on_grid(self, line: int, lines: int, mean: bool = False) -> Array:
        """Return the frequencies on a grid about a line, as many as `lines`, that explain the most in its place.

        With `mean` one of them is zero.
        """
        offsets = np.arange(-WINDOW_POWER - 1, WINDOW_POWER + 1 + GRID_SPACING / 2, GRID_SPACING) / self.n
        turns = self.turns[line] + offsets
        if self.is_real:
            turns = turns[(turns > GRID_SPACING / 2 / self.n) & (turns < 0.5)]
        if mean:
            turns = np.append(turns, 0.0)
        grid = _LineFit(self.signal)
        grid.coarse, grid.fine = turns, np.zeros(turns.size)
        waves = grid.waves(np.arange(turns.size))
        columns = np.concatenate([waves, 1j * waves])
        columns = columns.real if self.is_real else columns
        weighted = self.window * columns.conj()
        target = self.rest + self.sum_of(np.array([line]))
        normal, projected = (weighted @ columns.T).real, (weighted @ target).real
        normal[np.diag_indices_from(normal)] += 1e-12 * np.sum(self.window)
        sets = np.array(list(itertools.combinations(range(turns.size - mean), lines - mean)))
        if mean:
            sets = np.concatenate([sets, np.full((len(sets), 1), turns.size - 1)], axis=1)
        members = np.concatenate([sets, sets + turns.size], axis=1)
        right = projected[members]
        solved = np.linalg.solve(normal[members[:, :, None], members[:, None, :]], right[..., None])[..., 0]
        best: Array = turns[sets[np.argmax(np.sum(right * solved, axis=1))]]
        return best

    def _step(self, cluster: Array) -> float:
        """Take one Gauss-Newton step with some lines; return the change of the signal."""
        columns = self.columns(cluster)
        weighted = self.window * columns.conj()
        real, imaginary, turn = np.split(_inverse((weighted @ columns.T).real) @ (weighted @ self.rest).real, 3)
        moved = np.maximum(np.abs(real + 1j * imaginary), np.abs(turn * self.amplitudes[cluster]))
        longest = MAX_FREQUENCY_STEP / self.n
        self.rest = self.rest + self.sum_of(cluster)
        self.amplitudes[cluster] += real + 1j * imaginary
        self.fine[cluster] += np.clip(turn / (np.pi * self.n), -longest, longest)
        self.rest -= self.sum_of(cluster)
        return float(np.max(moved))

    def strongest(self, barred: Array) -> tuple[float, bool]:
        """Return the highest maximum of the spectrum of the residual, in turns, and True if it is a line."""
        height = np.abs(np.fft.fft(self.window * self.rest))
        open_bins = np.flatnonzero(~barred)
        if open_bins.size == 0:
            return 0.0, False
        at = int(open_bins[np.argmax(height[open_bins])])
        noise = np.sqrt(np.quantile(height**2, 0.25) * np.log(self.n / FALSE_ALARM) / np.log(4 / 3))
        is_line = height[at] > max(noise, self.noise * np.sum(self.window))
        if at == 0 and self.is_real:
            return 0.0, bool(is_line)
        before, here, after = np.log(np.take(height, [at - 1, at, at + 1], mode="wrap") + np.finfo(float).tiny)
        bend = before - 2 * here + after
        turns = (at + (np.clip((before - after) / (2 * bend), -0.5, 0.5) if bend < 0 else 0.0)) / self.n
        if self.is_real:
            turns = min(turns, 0.5 - MIN_LINE_DISTANCE / self.n)  # at 0.5 a line and its mirror image are one
        return turns - (1 if turns >= 0.5 and not self.is_real else 0), bool(is_line)

    @functools.cached_property
    def uncertainties(self) -> _Uncertainties:
        """Standard errors of the lines, and the resolved lines."""
        density = self._density(self.rest)
        bins = np.arange(self.n // 2 + 1 if self.is_real else self.n)
        away = np.abs(_reduced(bins[:, None] / self.n - self.turns)) * self.n
        outside = np.min(away, axis=1, initial=np.inf) > NOTCH_BINS
        outside = outside if np.any(outside) else np.ones(bins.size, bool)
        errors, sizes, noise, notch = np.empty((4, self.turns.size))
        for cluster in self.clusters:
            variances = self._variances(cluster)
            for line, real, imaginary, turn in zip(cluster, *variances, strict=True):
                near = np.argsort(away[outside, line])[:NOISE_BINS]
                noise[line] = np.median(density[bins[outside][near]]) / np.log(2)
                notch[line] = np.max(density[bins[away[:, line] <= NOTCH_BINS]])
                errors[line] = np.sqrt(noise[line] * turn) * 2 / self.n
                sizes[line] = np.sqrt(noise[line] * max(real, imaginary))
        rounded = 2 * np.pi * np.finfo(float).eps * np.abs(self.turns)
        rounding = self._density(np.full(self.n, self.noise))[0] * (1 + np.pi * self.n * np.abs(self.turns)) ** 2
        resolved = notch <= np.maximum(noise * np.log(self.n / FALSE_ALARM), rounding)
        larger = np.sqrt(np.divide(notch, noise, out=np.ones_like(noise), where=noise > 0))
        return _Uncertainties(np.hypot(errors, rounded), sizes, resolved, np.hypot(errors * larger, rounded))

    def _density(self, signal: Array) -> Array:
        """Return the power spectrum of a signal that acts on frequencies, in whole bins.

        It averages two bins, since whole bins alone may be zeros of the spectrum of a line far away.
        """
        power = np.abs(np.fft.fft(self.window * self.x * signal, 2 * self.n)) ** 2
        density: Array = np.mean(power.reshape(-1, 2), axis=1) / np.sum((self.window * self.x) ** 2)
        return density

    def _variances(self, cluster: Array) -> Array:
        """Return variances (3, lines) of both parts of the amplitudes and of the frequencies, by unit noise."""
        columns = self.columns(cluster)
        if self.is_real and 0 < np.min(np.abs(self.turns)) * self.n < SLOW_LINE_BINS:
            columns = np.concatenate([columns, np.ones((1, self.n))])  # mean, which a slow line may contain
        weighted = self.window * columns
        spread = _inverse((weighted.conj() @ columns.T).real)
        variances = np.diag(spread @ (weighted.conj() @ weighted.T).real @ spread)[: 3 * cluster.size]
        variances = np.where(variances < 0, np.inf, variances)  # lines that differ by rounding
        reshaped: Array = variances.reshape(3, -1) * (1 if self.is_real else 0.5)
        return reshaped

    def is_resolved_at(self, turns: float) -> bool:
        """Return True if the lines close to a frequency are resolved."""
        close = np.abs(_reduced(self.turns - turns)) * self.n < 2 * (WINDOW_POWER + 1)
        return bool(np.all(self.uncertainties.resolved[close]))

    def shift(self, line: int) -> float:
        """Return the difference of the frequency of a line from the nearest frequency of a pair in its place.

        The frequency of a mean is uncertain by one turn over the run.
        """
        if self.is_real and self.turns[line] == 0:
            return 2 * np.pi / self.n
        pair = self.with_lines(self.best_on_grid(line, 2), without=line).turns[-2:]
        shifts = _reduced(np.append(pair, -pair if self.is_real else pair) - self.turns[line])
        return float(2 * np.pi * np.min(np.abs(shifts)))

    def lines(self, t: Array) -> tuple[Array, Array, NDArray[np.int_]]:
        """Return the frequencies, the amplitudes at t = 0 and the indices of the lines, the strongest line first."""
        nu = 2 * np.pi * self.turns / ((t[-1] - t[0]) / (t.size - 1))
        amplitudes = self.amplitudes * np.exp(-1j * nu * (t[0] + t[-1]) / 2)
        if self.is_real:
            nu, amplitudes = np.abs(nu), np.where(nu < 0, amplitudes.conj(), amplitudes)
        order = np.argsort(-np.abs(amplitudes))
        return nu[order], amplitudes[order], order

    @property
    def is_certain(self) -> bool:
        """True if close lines exceed the noise and differ by more than their errors."""
        noise = self.uncertainties
        gaps = self.gaps()
        close = gaps < WINDOW_POWER + 1
        return bool(
            np.all(np.abs(self.amplitudes[close]) > MIN_STANDARD_ERRORS * noise.amplitudes[close])
            and np.all(
                gaps[close]
                > np.maximum(MIN_STANDARD_ERRORS * noise.turns[close] * self.n / (2 * np.pi), MIN_LINE_DISTANCE)
            )
        )


@dataclasses.dataclass(frozen=True)
class _Uncertainties:
    """Standard errors of frequencies, radians per sample, and of amplitudes; and the resolved lines.

    `unresolved` contains the standard errors of the frequencies by the residual within the notch.
    """

    turns: Array
    amplitudes: Array
    resolved: Array
    unresolved: Array


def _decomposed(signal: Array, t: Array, count: int) -> tuple[Array, Array, Array, Array, float]:
    """Return frequencies, amplitudes at t = 0, errors, resolved lines and residual of one signal."""
    fit = _fitted(signal, count)
    step, (nu, amplitudes, order) = (t[-1] - t[0]) / (t.size - 1), fit.lines(t)
    found = fit.uncertainties
    errors, resolved = found.turns.copy(), found.resolved
    for line in np.flatnonzero(~resolved):
        errors[line] = max(found.unresolved[line], fit.shift(int(line)))
    return nu, amplitudes, (errors / step)[order], resolved[order], fit.residual


def _fitted(signal: Array, count: int) -> _LineFit:
    """Return the fit of as many lines as the signal determines, at most `count`."""
    fit = _LineFit(signal)
    bins = np.arange(fit.n) / fit.n
    closed = bins > 0.5 if fit.is_real else np.zeros(fit.n, bool)
    refused = np.empty(0)
    while fit.turns.size < count:
        near = np.abs(_reduced(bins[:, None] - refused)) * fit.n < WINDOW_POWER + 1
        turns, is_line = fit.strongest(closed | np.any(near, axis=1))
        if not is_line:
            break
        more = _with_one_more(fit, turns)
        if more is None:
            refused = np.append(refused, turns)
        else:
            fit = more
            refused = refused[np.abs(_reduced(refused - turns)) * fit.n > 2 * (WINDOW_POWER + 1)]
    return fit


def _with_one_more(fit: _LineFit, turns: float) -> _LineFit | None:
    """Return a fit with one more line, which is at a maximum of the residual or in a pair instead of a close line."""
    added, last = fit.with_lines(turns), fit.turns.size
    if added.residual <= fit.residual and added.is_certain and added.is_resolved_at(turns):
        return added
    fits = []
    if fit.is_real and abs(math.remainder(2 * turns, 1)) * fit.n < 2 * (WINDOW_POWER + 1):
        fits.append(added.with_lines(added.best_on_grid(last, 1), without=last))
    away = np.abs(_reduced(fit.turns - turns)) * fit.n
    if np.min(away, initial=np.inf) < 2 * (WINDOW_POWER + 1):
        near = int(np.argmin(away))
        fits.append(fit.with_lines(fit.best_on_grid(near, 2), without=near))
        if (
            fit.is_real
            and np.abs(fit.turns[near]) * fit.n < WINDOW_POWER + 1
            and np.all(np.delete(fit.turns, near) != 0)
        ):
            fits.append(fit.with_lines(fit.best_on_grid(near, 2, mean=True), without=near))
    fits = [fit for fit in fits if fit.is_certain and fit.is_resolved_at(turns)]
    if fits:
        return min(fits, key=lambda fit: fit.residual)
    before, after = fit.uncertainties.turns, added.uncertainties.turns
    if added.residual > fit.residual or not added.is_certain or np.any(after[:last] > MAX_ERROR_GROWTH * before):
        return None
    return added


def _wave(coarse: Array, fine: Array, samples: Array) -> Array:
    wave: Array = np.exp(2j * np.pi * (_reduced(coarse * samples) + fine * samples))  # the first product is exact
    return wave


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a normal matrix of columns of any size; zero where a column vanishes."""
    size = np.sqrt(np.diag(matrix))
    free = np.ix_(size > 0, size > 0)
    scale = np.outer(size, size)[free]
    inverse = np.zeros_like(matrix)
    inverse[free] = np.linalg.pinv(matrix[free] / scale, hermitian=True) / scale
    return inverse


def _reduced(turns: Array) -> Array:
    return turns - np.rint(turns)


# ---------------------------------------------------------------------- halves


def _faster(lines: tuple[Array, ...], slowest: float) -> tuple[Array, ...]:
    fast = np.abs(lines[0]) > slowest
    return lines[0][fast], np.abs(lines[1][fast])


def _followed(first: tuple[Array, ...], second: tuple[Array, ...]) -> Array:
    """Return the relative change of each frequency of the first half."""
    drift = np.full(first[0].size, np.nan)
    for line, (nu, size) in enumerate(zip(*first, strict=True)):
        strong = second[0][second[1] >= MIN_STRENGTH_RATIO * size]
        candidates = strong if strong.size else second[0][:1]
        if candidates.size:
            drift[line] = candidates[np.argmin(np.abs(candidates - nu))] / nu - 1
    return drift


# ---------------------------------------------------------------------- arguments


def _checked(signal: ArrayLike, times: Times, lines: int, halves: int = 1) -> tuple[Array, Array]:
    """Return signals (..., n), real or complex, and ascending even times (n,)."""
    values, t = _samples(signal, times, lines, halves)
    even, worst, off = _evenness(t)
    if not even:
        raise ValueError(
            f"times must be evenly spaced, but times[{worst}] = {t[worst]} is {off:.3g} from even ones. "
            "Propagate at np.linspace(...)."
        )
    return _ascending(values, t)


def _samples(signal: ArrayLike, times: Times, lines: int, halves: int = 1) -> tuple[Array, Array]:
    """Return signals (..., n), real or complex, and their times (n,)."""
    values = _numbers(signal)
    n, needed = values.shape[-1] if values.ndim else 1, halves * max(32, 8 * lines)
    if n < needed or values.size == 0:
        each = "each half" if halves == 2 else "the run"
        raise ValueError(
            f"signal must have at least {needed} samples along its last axis for {lines} lines in {each}, "
            f"got shape {values.shape}."
        )
    if array_of("times", times).ndim == 0:
        step = real_array("times", times, ())
        refuse_nonpositive("times, as a step,", step)
        return values, np.arange(n) * step
    t = real_array("times", times, (None,))
    if t.size != n:
        raise ValueError(f"times must be as many as the samples, got {t.size} for {n}.")
    return values, t


def _ascending(values: Array, t: Array) -> tuple[Array, Array]:
    return (values, t) if t[-1] > t[0] else (values[..., ::-1], t[::-1])


def _evenness(t: Array) -> tuple[bool, int, float]:
    """Return True if times are even, the index of the time farthest from even times, and its distance."""
    step = float(t[-1] - t[0]) / (t.size - 1)
    off = np.abs(t - (t[0] + step * np.arange(t.size)))
    worst = int(np.argmax(off))
    tolerance = UNEVENNESS_TOLERANCE * abs(step) + 8 * np.finfo(float).eps * np.max(np.abs(t))
    return bool(step != 0 and off[worst] <= tolerance), worst, float(off[worst])


def _numbers(signal: ArrayLike) -> Array:
    """Return a signal as finite floats or complex numbers."""
    values = array_of("signal", signal)
    if values.dtype.kind not in "iufc":
        raise TypeError(f"signal must be real or complex numbers, got {kind_of(signal)}.")
    values = values.astype(complex if values.dtype.kind == "c" else float)
    if not np.all(np.isfinite(values)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise ValueError(
            f"signal must be finite, but signal[{', '.join(map(str, where))}] = {values[where]}. "
            "Omit absent samples together with their times."
        )
    return values
