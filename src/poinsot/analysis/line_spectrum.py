"""The frequencies of a motion: its decomposition into lines, and their drift.

An evenly sampled signal is taken apart into lines a exp(i nu t) as by Laskar (1990, Icarus 88, 266; 1993, Physica D
67, 257): the highest maximum of the windowed spectrum of the residual gives the next line. His frequency of a single
line, the maximum itself, is that of the least squares of the difference in the windowed inner product. Here all
lines found so far are fitted together in that sense, by Gauss and Newton's method, so that close lines do not bias
each other.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.errors import array_of, real_array, refuse_nonpositive
from poinsot.html_text import PER_TIME, Summarized, told
from poinsot.printable import kind_of
from poinsot.quantities import Times

__all__ = ["LineSpectrum", "diffusion", "frequencies"]

Array = NDArray[Any]

POWER = 3
"""Of the window (1 + cos pi x)^POWER; its main lobe reaches to POWER + 1 bins, farther lines fade as bins^-7."""
APART = 0.5
"""Lines closer than this, in bins, are not told from each other."""
WORSE = 2
"""A line that makes the frequencies of others less certain by more than this is noise beside them."""
CLUSTER = 16
"""Lines with gaps below this, in bins, are stepped together; others interact through the residual."""
NOTCH = 2
"""Bins about a line that the fit has emptied."""
NEIGHBOURS = 16
"""Bins about a line, beyond those, in which the noise is measured."""
NOT_NOISE = 1e-3
"""The probability that noise alone makes a line."""
ROUNDS = 10
LONGEST_STEP = 0.25
"""Of a frequency, in bins."""
FOLLOWED = 1 / 3
"""A line in the second half of a run may be one of the first half if it is at least so strong, relatively."""
IN_A_HALF = 8
"""Lines that are fitted in each half."""
EVEN = 1e-9
"""Tolerance for uneven times, in steps, besides their rounding."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class LineSpectrum(Summarized):
    """The lines of a signal, the strongest first: the sum of amplitudes * exp(i frequencies t), or its real part.

    Of an array of signals every attribute has their axes first; where a signal has fewer lines than another, NaN.

    Attributes
    ----------
    frequencies : array (lines,)
        Radians per unit of time; of a complex signal with a sign, of a real one not negative.
    amplitudes : complex array (lines,)
        In the unit of the signal; the phase is that at t = 0.
    errors : array (lines,)
        The standard error of each frequency, from the residual of the signal in the bins about the line, be it noise
        or lines that were left out. Zero for the mean of a real signal.
    residual : float
        The RMS residual, weighted by the window.

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
    residual: Any

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Lines of a signal: {self.frequencies.shape[-1]}", {
            "frequencies": told(self.frequencies, PER_TIME),
            "standard errors": told(self.errors, PER_TIME),
            "amplitudes": told(np.abs(self.amplitudes)),
            "residual": told(self.residual),
        }


@checked
def frequencies(signal: ArrayLike, times: Times, count: int = 10) -> LineSpectrum:
    """Return the lines of an evenly sampled signal: frequencies, amplitudes and the errors of the frequencies.

    All lines together minimise the mean of w |signal - sum of a exp(i nu t)|^2, of a real signal |signal - Re sum|^2,
    with the window w = (1 + cos pi x)^3, x from -1 to 1 along the samples.

    Parameters
    ----------
    signal : array (..., n)
        Real or complex: an angle, q0 + i q3, G1 + i G2, exp(i theta). Of several signals each is decomposed alone.
    times : array (n,) or float
        Evenly spaced, or the step between them, the first sample then being at t = 0.
    count : int
        The most lines. There are fewer if the residual is white noise or rounding.

    Raises
    ------
    TypeError, ValueError
        If the signal is not of finite numbers, has fewer than 8 samples for each line and 32 in all, or times are
        not even. That no frequency is beyond pi/step, and so seen at another, is not checked.

    Examples
    --------
    >>> times = np.linspace(0, 100, 1001)
    >>> pt.analysis.frequencies(np.exp(-1.5j * times), times, 1).frequencies.round(9)
    array([-1.5])
    """
    refuse_nonpositive("count", count)
    signals, t = _checked(signal, times, count)
    rows = [_decomposed(row, t, count) for row in signals.reshape(-1, t.size)]
    most = max(len(row[0]) for row in rows)
    padded = [[np.pad(x, (0, most - len(x)), constant_values=np.nan) for x in row[:3]] for row in rows]
    nu, amplitudes, errors = (np.reshape(x, (*signals.shape[:-1], most)) for x in zip(*padded, strict=True))
    return LineSpectrum(nu, amplitudes, errors, np.reshape([row[3] for row in rows], signals.shape[:-1])[()])


@checked
def diffusion(signal: ArrayLike, times: Times, count: int = 1) -> Array:
    """Return the relative change of the strongest frequencies of a signal from one half of a run to the other.

    nu2/nu1 - 1, of a regular motion no more than the errors of the frequencies, is Laskar's (1993) sign of chaos. A
    line of the first half is followed to the nearest of the second that has at least a third of its amplitude. A mean,
    and what is slower than one turn in half the run, is not followed.

    Parameters
    ----------
    signal, times
        As for `frequencies`.
    count : int
        How many lines to follow.

    Returns
    -------
    array (..., count)
        NaN where there are fewer lines.

    Raises
    ------
    TypeError, ValueError
        As `frequencies`, of each half.

    Examples
    --------
    >>> times = np.linspace(0, 100, 1001)
    >>> pt.analysis.diffusion(np.cos(2 * times + 1e-4 * times**2), times).round(4)
    array([0.005])
    """
    refuse_nonpositive("count", count)
    lines = max(count, IN_A_HALF)
    signals, t = _checked(signal, times, lines, halves=2)
    half = t.size // 2
    slowest = 2 * np.pi / (t[half] - t[0])
    drifts = np.full((*signals.shape[:-1], count), np.nan)
    for member in np.ndindex(signals.shape[:-1]):
        parts = (slice(None, half), slice(-half, None))
        first, second = (_decomposed(signals[member][part], t[part], lines)[:2] for part in parts)
        drift = _followed(_faster(first, slowest), _faster(second, slowest))[:count]
        drifts[member][: drift.size] = drift
    return drifts


# ---------------------------------------------------------------------- the fit


class _Fit:
    """The lines of one signal, on centred samples: turns per sample and complex amplitudes at the centre.

    The turns are kept as multiples of 2^-26 and the rest, or their rounding would be seen in the residual.
    """

    def __init__(self, signal: Array) -> None:
        n = signal.size
        self.signal, self.n, self.is_real = signal, n, not np.iscomplexobj(signal)
        self.x = (2 * np.arange(n) - (n - 1)) / n
        self.window = (1 + np.cos(np.pi * self.x)) ** POWER
        self.coarse, self.fine, self.amplitudes, self.rest = np.empty(0), np.empty(0), np.empty(0, complex), signal
        self.noise = np.finfo(float).eps * np.max(np.abs(signal))

    @property
    def turns(self) -> Array:
        """The frequencies, turns per sample."""
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
        """Indices of the lines, those that are near each other together."""
        order = np.argsort(self.turns)
        gaps = np.flatnonzero(np.diff(self.turns[order]) > CLUSTER / self.n) + 1
        return [cluster for cluster in np.split(order, gaps) if cluster.size]

    @property
    def crowded(self) -> bool:
        """Whether two lines, or one of a real signal and its mirror image at the other sign, are not told apart."""
        mirrored = -self.turns[self.turns != 0] if self.is_real else self.turns[:0]
        turns = np.sort(np.concatenate([self.turns, mirrored]) % 1)
        return bool(np.min(np.diff(turns, append=turns[0] + 1)) * self.n < APART)

    @property
    def residual(self) -> float:
        """The RMS residual."""
        return float(np.sqrt(np.average(np.abs(self.rest) ** 2, weights=self.window)))

    def add(self, turns: float) -> None:
        """Add a line and fit all of them, until no one changes the signal by more than rounding."""
        coarse = np.rint(turns * 2**26) / 2**26
        self.coarse, self.fine = np.append(self.coarse, coarse), np.append(self.fine, turns - coarse)
        self.amplitudes = np.append(self.amplitudes, 0.0)
        clusters = self.clusters
        for _ in range(ROUNDS):
            if max([self._step(cluster) for cluster in clusters]) <= self.noise:
                break
        self.rest = self.signal - self.sum_of(np.arange(self.fine.size))

    def _step(self, cluster: Array) -> float:
        """Take one step of Gauss and Newton's with some lines; return by how much it changes the signal."""
        columns = self.columns(cluster)
        weighted = self.window * columns.conj()
        real, imaginary, turn = np.split(_inverse((weighted @ columns.T).real) @ (weighted @ self.rest).real, 3)
        moved = np.maximum(np.abs(real + 1j * imaginary), np.abs(turn * self.amplitudes[cluster]))
        longest = LONGEST_STEP / self.n
        self.rest = self.rest + self.sum_of(cluster)
        self.amplitudes[cluster] += real + 1j * imaginary
        self.fine[cluster] += np.clip(turn / (np.pi * self.n), -longest, longest)
        self.rest -= self.sum_of(cluster)
        return float(np.max(moved))

    def strongest(self, barred: Array) -> tuple[float, bool]:
        """Return the highest maximum of the spectrum of the residual, in turns, and whether it is a line."""
        height = np.abs(np.fft.fft(self.window * self.rest))
        open_bins = np.flatnonzero(~barred)
        if open_bins.size == 0:
            return 0.0, False
        at = int(open_bins[np.argmax(height[open_bins])])
        noise = np.sqrt(np.quantile(height**2, 0.25) * np.log(self.n / NOT_NOISE) / np.log(4 / 3))
        is_line = height[at] > max(noise, self.noise * np.sum(self.window))
        if at == 0 and self.is_real:
            return 0.0, bool(is_line)
        before, here, after = np.log(np.take(height, [at - 1, at, at + 1], mode="wrap") + np.finfo(float).tiny)
        bend = before - 2 * here + after
        turns = (at + (np.clip((before - after) / (2 * bend), -0.5, 0.5) if bend < 0 else 0.0)) / self.n
        if self.is_real:
            turns = min(turns, 0.5 - APART / self.n)  # at 0.5 a line and its mirror image are one
        return turns - (1 if turns >= 0.5 and not self.is_real else 0), bool(is_line)

    def errors(self) -> Array:
        """Return the standard errors of the frequencies, radians per sample."""
        power = np.abs(np.fft.fft(self.window * self.x * self.rest, 2 * self.n)) ** 2
        density = np.mean(power.reshape(-1, 2), axis=1) / np.sum((self.window * self.x) ** 2)
        bins = np.arange(
            self.n // 2 + 1 if self.is_real else self.n
        )  # whole ones alone may be zeros of a line far away
        apart = np.min(np.abs(_reduced(bins[:, None] / self.n - self.turns)) * self.n, axis=1, initial=np.inf)
        bins = bins[apart > NOTCH] if np.any(apart > NOTCH) else bins
        errors = np.empty(self.turns.size)
        for cluster in self.clusters:
            columns = self.columns(cluster)
            weighted = self.window * columns
            spread = _inverse((weighted.conj() @ columns.T).real)
            variance = np.diag(spread @ (weighted.conj() @ weighted.T).real @ spread)[2 * cluster.size :]
            variance = np.where(variance < 0, np.inf, variance)  # lines that rounding does not tell apart
            for line, scale in zip(cluster, variance * (1 if self.is_real else 0.5), strict=True):
                near = np.argsort(np.abs(_reduced(bins / self.n - self.turns[line])))[:NEIGHBOURS]
                errors[line] = np.sqrt(np.median(density[bins[near]]) / np.log(2) * scale) * 2 / self.n
        return np.hypot(errors, 2 * np.pi * np.finfo(float).eps * np.abs(self.turns))


def _decomposed(signal: Array, t: Array, count: int) -> tuple[Array, Array, Array, float]:
    """Return frequencies, amplitudes at t = 0, errors and residual of one signal."""
    fit = _fitted(signal, count)
    step = (t[-1] - t[0]) / (t.size - 1)
    backwards = np.sign(fit.turns) if fit.is_real else np.ones(fit.turns.size)
    nu = 2 * np.pi * fit.turns / step
    amplitudes = fit.amplitudes * np.exp(-1j * nu * (t[0] + t[-1]) / 2)
    errors = fit.errors() / step
    order = np.argsort(-np.abs(amplitudes))
    if fit.is_real:
        nu, amplitudes = np.abs(nu), np.where(backwards < 0, amplitudes.conj(), amplitudes)
    return nu[order], amplitudes[order], errors[order], fit.residual


def _fitted(signal: Array, count: int) -> _Fit:
    fit = _Fit(signal)
    bins = np.arange(fit.n) / fit.n
    barred = bins > 0.5 if fit.is_real else np.zeros(fit.n, bool)
    errors = np.empty(0)
    while fit.turns.size < count:
        turns, is_line = fit.strongest(barred)
        if not is_line:
            break
        before = fit.coarse, fit.fine, fit.amplitudes, fit.rest
        residual = fit.residual
        fit.add(turns)
        after = fit.errors()
        if fit.crowded or fit.residual > residual or np.any(after[:-1] > WORSE * errors):
            fit.coarse, fit.fine, fit.amplitudes, fit.rest = before
            barred |= np.abs(_reduced(bins - turns)) * fit.n < POWER + 1
        else:
            errors = after
    return fit


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
        strong = second[0][second[1] >= FOLLOWED * size]
        candidates = strong if strong.size else second[0][:1]
        if candidates.size:
            drift[line] = candidates[np.argmin(np.abs(candidates - nu))] / nu - 1
    return drift


# ---------------------------------------------------------------------- arguments


def _checked(signal: ArrayLike, times: Times, lines: int, halves: int = 1) -> tuple[Array, Array]:
    """Return signals (..., n), real or complex, and ascending times (n,)."""
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
    return (values, t) if _refuse_uneven(t) > 0 else (values[..., ::-1], t[::-1])


def _refuse_uneven(t: Array) -> float:
    """Return the step of even times."""
    step = float(t[-1] - t[0]) / (t.size - 1)
    off = np.abs(t - (t[0] + step * np.arange(t.size)))
    worst = int(np.argmax(off))
    if step == 0 or off[worst] > EVEN * abs(step) + 8 * np.finfo(float).eps * np.max(np.abs(t)):
        raise ValueError(
            f"times must be evenly spaced, but times[{worst}] = {t[worst]} is {off[worst]:.3g} from even ones. "
            "Propagate at np.linspace(...)."
        )
    return step


def _numbers(signal: ArrayLike) -> Array:
    """Return a signal as finite floats or complex numbers."""
    values = array_of("signal", signal)
    if values.dtype.kind not in "iufc":
        raise TypeError(f"signal must be real or complex numbers, got {kind_of(signal)}.")
    values = values.astype(complex if values.dtype.kind == "c" else float)
    if not np.all(np.isfinite(values)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise ValueError(f"signal must be finite, but signal[{', '.join(map(str, where))}] = {values[where]}.")
    return values
