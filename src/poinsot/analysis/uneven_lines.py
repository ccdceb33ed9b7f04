"""Lines of a signal at uneven times, by least squares.

The model is a sum of lines a exp(i nu t), or its real part and a mean, with weights 1/sigma^2. The highest maxima of
the least-squares spectrum of the residual (Lomb 1976, Ap&SS 39, 447; with the mean, Zechmeister and Kuerster 2009, A&A
496, 577) are candidates for the next line, since gaps make maxima at aliases as high as the maximum of the line. Each
candidate is fitted together with all lines by the Gauss-Newton method, and several of the best sets of lines are
continued. At the end each line is tried at its other maxima.

Standard errors follow from the inverse of the normal matrix. For one line and even times they are the errors of
Montgomery and O'Donoghue (1999, Delta Scuti Star Newsletter 13, 28): sqrt(6/N) sigma/(pi T a) for the frequency in
cycles.
"""

from __future__ import annotations

import copy
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

__all__ = ["ALIASES", "UnevenLines", "fitted_lines", "grid_size"]

Array = NDArray[Any]

FALSE_ALARM = 1e-3
"""Probability that noise alone makes a line."""
GRID_SPACING = 0.2
"""Distance of the frequencies of a spectrum, in turns over the run."""
MIN_DISTANCE = 0.5
"""Smallest distance of two lines, and smallest frequency of a line of a real signal, in turns over the run."""
MIN_STANDARD_ERRORS = 4
"""Smallest amplitude of a line, in standard errors."""
CANDIDATES = 10
"""Number of maxima of a spectrum that are tried as a line."""
MIN_RELATIVE_POWER = 0.4
"""Smallest power of a candidate relative to the highest maximum."""
SETS = 3
"""Number of sets of lines that are continued."""
ALIASES = 4
"""Number of other frequencies that are listed for each line."""
NEAR = 2
"""Distance from a line, in turns over the run, within which the residual contains no other line if it is resolved."""
MAX_ITERATIONS = 30
MAX_STEP = 0.2
"""Largest step of a frequency, in turns over the run."""
TOLERANCE = 1e-9
"""Relative change of the sum of squares at which iterations end."""
SAMPLES_PER_BLOCK = 2048
"""Number of samples whose waves are in memory at a time."""


class UnevenLines(NamedTuple):
    """Lines of one signal, the strongest first, with the attributes of `LineSpectrum`."""

    frequencies: Array
    amplitudes: Array
    errors: Array
    resolved: Array
    residual: float
    aliases: Array
    alias_chi2: Array


def grid_size(run: float, highest: float, is_real: bool) -> int:
    """Return the number of frequencies of a spectrum."""
    return int(np.ceil(highest * run / (2 * np.pi) / GRID_SPACING)) * (1 if is_real else 2) + 1


def fitted_lines(signal: Array, t: Array, sigma: Array | None, highest: float, count: int) -> UnevenLines:
    """Return at most `count` lines of one signal at ascending times, with frequencies up to the highest one."""
    fit = _Fit(signal, t, sigma, highest)
    others = count - fit.has_mean
    fit = _improved(_searched(fit, others))
    return fit.result()


class _Fit:
    """Fit of lines to samples: frequencies in turns over the run, complex amplitudes at the middle of the run."""

    def __init__(self, signal: Array, t: Array, sigma: Array | None, highest: float) -> None:
        self.is_real = not np.iscomplexobj(signal)
        self.center, self.run = (t[0] + t[-1]) / 2, t[-1] - t[0]
        self.x = (t - self.center) / self.run
        self.is_weighted = sigma is not None
        self.weights = np.ones(t.size) if sigma is None else 1 / sigma**2
        self.highest = highest * self.run / (2 * np.pi)
        self.signal = signal
        self.turns, self.amplitudes = np.empty(0), np.empty(0, complex)
        self.mean = np.average(signal, weights=self.weights) if self.is_real else 0.0
        self.rest = signal - self.mean
        error = np.sqrt(self.squares / np.sum(self.weights) / t.size)
        self.has_mean = bool(self.is_real and abs(self.mean) > MIN_STANDARD_ERRORS * error)

    @property
    def squares(self) -> float:
        """Weighted sum of the squares of the residual."""
        return float(np.sum(self.weights * np.abs(self.rest) ** 2))

    @property
    def rounding(self) -> float:
        """Sum of squares that rounding of the signal and of the phases of the lines makes."""
        phases = np.pi * np.max(np.abs(self.turns), initial=0.0)
        error = np.finfo(float).eps * np.max(np.abs(self.signal)) * (4 + phases)
        return float(np.sum(self.weights) * error**2)

    @property
    def unknowns(self) -> int:
        """Number of real unknowns."""
        return 3 * self.turns.size + self.is_real

    @property
    def data(self) -> int:
        """Number of real data."""
        return self.rest.size * (1 if self.is_real else 2)

    @property
    def variance(self) -> float:
        """Variance of data of unit weight: of the residual, and not below 1 if the user stated standard deviations."""
        own = self.squares / max(self.data - self.unknowns, 1)
        return max(own, 1.0) if self.is_weighted else own

    def waves(self) -> Array:
        """Return exp(2 pi i turns x), shape (lines, n)."""
        waves: Array = np.exp(2j * np.pi * np.multiply.outer(self.turns, self.x))
        return waves

    def columns(self, waves: Array) -> Array:
        """Return the derivatives of the model by the parts of the amplitudes, the turns and the mean."""
        columns = np.concatenate([waves, 1j * waves, 2j * np.pi * self.amplitudes[:, None] * self.x * waves])
        return np.concatenate([columns.real, np.ones((1, self.x.size))]) if self.is_real else columns

    def model(self, waves: Array) -> Array:
        """Return the sum of the lines and the mean."""
        total = self.amplitudes @ waves
        return total.real + self.mean if self.is_real else total

    def with_lines(self, turns: Array) -> _Fit | None:
        """Return the fit of lines that starts at given frequencies, or None if the data do not determine it."""
        fit = copy.copy(self)
        fit.turns = np.array(turns, dtype=float)
        fit.amplitudes = np.zeros(fit.turns.size, complex)
        lines, before = fit.turns.size, np.inf
        for iteration in range(MAX_ITERATIONS):
            waves = fit.waves()
            columns = fit.columns(waves)
            if iteration == 0:  # amplitudes alone
                columns = np.concatenate([columns[: 2 * lines], columns[3 * lines :]])
            fit.rest = fit.signal - fit.model(waves)
            step = _solved(columns, fit.weights, fit.rest)
            if step is None:
                return None
            fit.amplitudes = fit.amplitudes + step[:lines] + 1j * step[lines : 2 * lines]
            if iteration:
                fit.turns = fit.turns + np.clip(step[2 * lines : 3 * lines], -MAX_STEP, MAX_STEP)
            if fit.is_real:
                fit.mean = fit.mean + step[-1]
            now = fit.squares
            if (iteration > 1 and abs(before - now) <= TOLERANCE * now) or now <= fit.rounding:
                break
            before = now
        fit.rest = fit.signal - fit.model(fit.waves())
        return fit if fit._is_valid() else None

    def _is_valid(self) -> bool:
        """Return True if lines are apart and within the spectrum."""
        size = np.abs(self.turns) if self.is_real else self.turns
        gaps = np.diff(np.sort(size))
        slow = self.is_real and np.any(size < MIN_DISTANCE)
        return not (slow or np.any(np.abs(size) > self.highest + 1) or np.any(gaps < MIN_DISTANCE))

    @property
    def is_above_noise(self) -> bool:
        """True if each amplitude exceeds its standard error."""
        return bool(np.all(np.abs(self.amplitudes) > MIN_STANDARD_ERRORS * self.errors()[0]))

    def errors(self) -> tuple[Array, Array]:
        """Return standard errors of the amplitudes and of the turns."""
        columns = self.columns(self.waves())
        covariance = np.linalg.pinv((self.weights * columns.conj() @ columns.T).real, hermitian=True) * self.variance
        real, imaginary, turns = np.sqrt(np.maximum(np.diag(covariance), 0))[: 3 * self.turns.size].reshape(3, -1)
        return np.maximum(real, imaginary), turns

    def power(self, signal: Array, turns: Array) -> Array:
        """Return the decrease of the sum of squares of a signal by a line at frequencies with an even spacing."""
        fine = math.isqrt(turns.size - 1) + 1  # frequencies are sums of a coarse and a fine part
        coarse = np.arange(0, turns.size, fine)
        step = (turns[-1] - turns[0]) / max(turns.size - 1, 1)
        sums, twice = np.zeros((2, coarse.size, fine), complex), np.zeros((coarse.size, fine), complex)
        for start in range(0, self.x.size, SAMPLES_PER_BLOCK):
            part = slice(start, start + SAMPLES_PER_BLOCK)
            x, weights = self.x[part], self.weights[part]
            far = np.exp(-2j * np.pi * np.multiply.outer(turns[0] + step * coarse, x))
            near = np.exp(-2j * np.pi * np.multiply.outer(x, step * np.arange(fine)))
            sums += np.stack([weights * signal[part] * far, weights * far]) @ near
            if self.is_real:
                twice += (weights * far * far) @ (near * near)
        (signals, window), twice = sums.reshape(2, -1)[:, : turns.size], twice.ravel()[: turns.size]
        total = float(np.sum(self.weights))
        if not self.is_real:
            return np.asarray(np.abs(signals) ** 2 / total)
        return _real_power(signals, window, twice, total, float(np.sum(self.weights * signal)))

    def grid(self) -> Array:
        """Return the frequencies of a spectrum, in turns over the run."""
        last = int(np.ceil(self.highest / GRID_SPACING))
        first = int(np.ceil(MIN_DISTANCE / GRID_SPACING)) if self.is_real else -last
        return np.arange(first, last + 1) * GRID_SPACING

    def maxima(self, signal: Array) -> tuple[Array, Array]:
        """Return the frequencies of the highest maxima of the spectrum of a signal, and their powers."""
        turns = self.grid()
        power = self.power(signal, turns)
        padded = np.concatenate([[-np.inf], power, [-np.inf]])
        top = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] > padded[2:]))
        top = top[np.argsort(-power[top])][:CANDIDATES]
        top = top[power[top] > MIN_RELATIVE_POWER * np.max(power)]
        return turns[top], power[top]

    def chance(self, power: float, squares: float, turns: float) -> float:
        """Return the probability that noise alone makes such a decrease of squares in a range of frequencies.

        The range is in turns over the run (Baluev 2008, MNRAS 385, 1279, eq. (6) and (15)).
        """
        rest = max(1 - power / squares, np.finfo(float).tiny)
        level = -max(self.data - self.unknowns - 3, 1) / 2 * np.log(rest)
        return float(turns * np.sqrt(max(level, 1.0)) * np.exp(-max(level, 0.0)))

    def result(self) -> UnevenLines:
        """Return the lines with errors and aliases, the strongest line first."""
        _, errors = self.errors()
        resolved, larger = self._resolved()
        aliases, excesses = np.full((2, self.turns.size, ALIASES), np.nan)
        for line in range(self.turns.size):
            found, excess = self.aliases_of(line)
            aliases[line, : found.size], excesses[line, : found.size] = found, excess
        nu = 2 * np.pi * self.turns / self.run
        amplitudes = self.amplitudes * np.exp(-1j * nu * self.center)
        if self.is_real:
            amplitudes, nu = np.where(nu < 0, amplitudes.conj(), amplitudes), np.abs(nu)
        errors = 2 * np.pi * errors * np.where(resolved, 1.0, larger) / self.run
        rows: list[Array] = [nu, amplitudes, errors, resolved, 2 * np.pi * aliases / self.run, excesses]
        if self.has_mean:
            mean = (0.0, complex(self.mean), 0.0, True, np.full(ALIASES, np.nan), np.full(ALIASES, np.nan))
            rows = [np.concatenate([row, np.asarray(own)[None]]) for row, own in zip(rows, mean, strict=True)]
        order = np.argsort(-np.abs(rows[1]))
        nu, amplitudes, errors, resolved, aliases, excesses = (row[order] for row in rows)
        residual = float(np.sqrt(self.squares / np.sum(self.weights)))
        return UnevenLines(nu, amplitudes, errors, resolved, residual, aliases, excesses)

    def _resolved(self) -> tuple[Array, Array]:
        """Return the resolved lines, and the factor by which the residual near a line exceeds the noise."""
        resolved, larger = np.ones(self.turns.size, bool), np.ones(self.turns.size)
        if self.squares <= self.rounding:
            return resolved, larger
        offsets = np.arange(-NEAR, NEAR + GRID_SPACING / 2, GRID_SPACING)
        for line, turns in enumerate(self.turns):
            near = abs(turns) + offsets if self.is_real else turns + offsets
            power = float(np.max(self.power(self.rest, near)))
            resolved[line] = self.chance(power, self.squares, 2 * NEAR) > FALSE_ALARM
            larger[line] = np.sqrt(max(power / self.variance / (1 if self.is_real else 0.5), 1.0))
        return resolved, larger

    def aliases_of(self, line: int) -> tuple[Array, Array]:
        """Return other frequencies of a line, and the increases of the sum of squares over the variance."""
        fits = self.moved(line)
        excesses = np.array([fit.squares - self.squares for fit in fits]) / max(self.variance, np.finfo(float).tiny)
        order = np.argsort(excesses)[:ALIASES]
        turns = np.array([fit.turns[line] for fit in fits])[order]
        return np.abs(turns) if self.is_real else turns, excesses[order]

    def moved(self, line: int) -> list[_Fit]:
        """Return the fits with a line at each of the other maxima of its spectrum."""
        own = self.amplitudes[line] * np.exp(2j * np.pi * self.turns[line] * self.x)
        fits: list[_Fit] = []
        for turns in self.maxima(self.rest + (own.real if self.is_real else own))[0]:
            if abs(turns - self.turns[line]) < MIN_DISTANCE:
                continue
            fit = self.with_lines(np.where(np.arange(self.turns.size) == line, turns, self.turns))
            if fit and abs(fit.turns[line] - self.turns[line]) > MIN_DISTANCE:
                fits.append(fit)
        return fits


def _solved(columns: Array, weights: Array, rest: Array) -> Array | None:
    """Return the solution of the normal equations, or None if they are singular."""
    weighted = weights * columns.conj()
    normal, right = (weighted @ columns.T).real, (weighted @ rest).real
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0):
        return None
    try:
        factor = cho_factor(normal / np.outer(size, size))
    except np.linalg.LinAlgError:
        return None
    solved: Array = cho_solve(factor, right / size) / size
    return solved


def _real_power(signal: Array, window: Array, twice: Array, total: float, mean: float) -> Array:
    """Return the decrease of the sum of squares by a cosine, a sine and a mean beyond the decrease by the mean.

    The sums of exp(-i nu t) are weighted by the signal, by one, and by one at twice the frequency.
    """
    c, s = window.real, -window.imag
    yc, ys = signal.real - mean * c / total, -signal.imag - mean * s / total
    cc = (total + twice.real) / 2 - c * c / total
    ss = (total - twice.real) / 2 - s * s / total
    cs = -twice.imag / 2 - c * s / total
    determinant = cc * ss - cs * cs
    safe = determinant > 1e-9 * total**2
    power = (ss * yc**2 - 2 * cs * yc * ys + cc * ys**2) / np.where(safe, determinant, 1.0)
    return np.where(safe, power, 0.0)


def _searched(fit: _Fit, count: int) -> _Fit:
    """Return the fit of as many lines as the signal determines, at most `count`."""
    sets = [fit]
    while sets[0].turns.size < count and sets[0].squares > sets[0].rounding:
        found: list[_Fit] = []
        for start in sets:
            for turns in start.maxima(start.rest)[0]:
                more = start.with_lines(np.append(start.turns, turns))
                if more and more.is_above_noise and not any(_same(more, other) for other in found):
                    found.append(more)
        found.sort(key=lambda fit: fit.squares)
        before = sets[0]
        many = before.highest * (1 if before.is_real else 2)
        if not found or before.chance(before.squares - found[0].squares, before.squares, many) > FALSE_ALARM:
            break
        sets = found[:SETS]
    return sets[0]


def _same(fit: _Fit, other: _Fit) -> bool:
    return bool(np.all(np.abs(np.sort(fit.turns) - np.sort(other.turns)) < MIN_DISTANCE))


def _improved(fit: _Fit) -> _Fit:
    """Return the best fit with single lines moved to other maxima of their spectra."""
    for _ in range(3 * fit.turns.size):
        moved = [better for line in range(fit.turns.size) for better in fit.moved(line) if better.is_above_noise]
        best = min(moved, key=lambda fit: fit.squares, default=fit)
        if best.squares >= fit.squares * (1 - TOLERANCE):
            break
        fit = best
    return fit
