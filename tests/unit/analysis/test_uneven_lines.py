"""Lines of signals at uneven times, against SciPy, closed forms of the standard errors, and simulated nights."""

import re

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.signal import lombscargle

import poinsot as pt
from poinsot.analysis.uneven_lines import _Fit

TURN = 2 * np.pi


def nights(rng, count=10, samples=40, hours=7.0):
    """Times in days of observations in consecutive nights."""
    return np.concatenate([day + np.sort(rng.uniform(0, hours / 24, samples)) for day in range(count)])


def sum_of(times, cycles, amplitudes):
    return (np.exp(1j * TURN * np.outer(times, cycles)) @ amplitudes).real


@pytest.fixture
def rng():
    return np.random.default_rng(40)


def test_the_spectrum_is_the_least_squares_spectrum_with_a_mean(rng):
    times, sigma = nights(rng, 4), rng.uniform(0.5, 2.0, 160)
    signal = 3 + sum_of(times, [2.2], [0.7]) + sigma * rng.normal(size=160)
    fit = _Fit(signal, times, sigma, TURN * 20)
    turns, squares = fit.grid(), fit.squares
    reference = lombscargle(
        times, signal, TURN * turns / fit.run, weights=1 / sigma**2, floating_mean=True, normalize=True
    )
    np.testing.assert_allclose(fit.power(fit.rest, turns) / squares, reference, rtol=0, atol=1e-11)


@pytest.mark.parametrize("weighted", [False, True])
def test_lines_have_the_least_squares(rng, weighted):
    times, cycles = nights(rng), np.array([1.57, 1.75, 3.14])
    sigma = rng.uniform(0.02, 0.06, times.size)
    signal = 19 + sum_of(times, cycles, [0.3, 0.12j, 0.05]) + sigma * rng.normal(size=times.size)
    found = pt.analysis.frequencies(signal, times, 4, sigma=sigma if weighted else None, highest=TURN * 10)

    def rest(unknowns):
        real, imaginary, rates = unknowns[1:].reshape(3, 3)
        model = unknowns[0] + sum_of(times, rates, real + 1j * imaginary)
        return (signal - model) / (sigma if weighted else 1)

    solved = least_squares(rest, [19, 0.3, 0, 0.05, 0, 0.12, 0, *cycles], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    mean, (real, imaginary, rates) = solved.x[0], solved.x[1:].reshape(3, 3)
    jacobian = np.asarray(solved.jac)
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    variance = 2 * solved.cost / (times.size - 10)
    errors = np.sqrt(np.diag(covariance)[-3:] * (max(variance, 1) if weighted else variance))
    np.testing.assert_allclose(found.frequencies / TURN, [0, *rates], rtol=1e-7, atol=0)
    np.testing.assert_allclose(found.amplitudes, [mean, *(real + 1j * imaginary)], rtol=1e-5, atol=0)
    np.testing.assert_allclose(found.errors / TURN, [0, *errors], rtol=1e-4, atol=0)
    assert np.all(found.resolved)


def test_errors_of_even_times_are_those_of_montgomery_and_odonoghue(rng):
    n, step, a, sigma = 2000, 0.05, 0.4, 0.1
    times = step * np.arange(n)
    signal = a * np.cos(TURN * 1.3 * times + 0.4) + sigma * rng.normal(size=n)
    found = pt.analysis.frequencies(signal, times, 1, sigma=sigma)
    assert found.aliases is not None
    expected = np.sqrt(6 / n) * sigma / (np.pi * n * step * a)
    # 1/sqrt(2 n) = 2 % is the standard error of the residual's RMS; the mean and the ends change 1/n
    np.testing.assert_allclose(found.errors / TURN, expected, rtol=0.06, atol=0)


def test_errors_are_standard_errors(rng):
    cycles, amplitudes = np.array([1.57, 2.2]), np.array([0.3, 0.15])
    off = []
    for _ in range(60):
        times = nights(rng, 5, 16)
        phases = np.exp(1j * rng.uniform(0, TURN, 2))
        signal = 15 + sum_of(times, cycles, amplitudes * phases) + 0.04 * rng.normal(size=80)
        found = pt.analysis.frequencies(signal, times, 3, highest=TURN * 5)
        nearest = np.argmin(np.abs(found.frequencies[:, None] / TURN - cycles), axis=0)
        off.append((found.frequencies[nearest] / TURN - cycles) / (found.errors[nearest] / TURN))
    good = np.abs(off) < 10  # an alias is farther
    assert np.mean(good) > 0.97
    spread = np.sqrt(np.mean(np.square(off), axis=0, where=good))
    assert np.all((spread > 0.72) & (spread < 1.28))  # three standard errors of the spread of 60 numbers
    assert np.all(np.abs(np.mean(off, axis=0, where=good)) < 0.39)


def test_noise_alone_has_no_lines(rng):
    lines = 0
    for _ in range(100):
        found = pt.analysis.frequencies(rng.normal(size=120), nights(rng, 6, 20), 2, highest=TURN * 8)
        lines += found.frequencies.size
    assert lines <= 2  # 0.1 expected


def test_signals_without_noise_are_exact_over_five_decades(rng):
    times, cycles, amplitudes = nights(rng, 12), np.array([1.3, 2.7, 0.4, 5.1, 3.3]), 10.0 ** -np.arange(5)
    found = pt.analysis.frequencies(sum_of(times, cycles, amplitudes), times, 8, highest=TURN * 10)
    np.testing.assert_allclose(found.frequencies / TURN, cycles, rtol=1e-12, atol=0)
    np.testing.assert_allclose(found.amplitudes, amplitudes, rtol=1e-10, atol=1e-13)
    assert found.residual < 1e-14


def test_complex_signals_have_signed_frequencies(rng):
    times, cycles = nights(rng), np.array([1.3, -2.7, 0.02])
    noise = rng.normal(size=(2, times.size)).T @ (1, 1j)
    signal = np.exp(1j * TURN * np.outer(times, cycles)) @ [1.0, 0.5j, 0.2] + 0.02 * noise
    found = pt.analysis.frequencies(signal, times, 5, highest=TURN * 5)
    assert np.all(np.abs(found.frequencies / TURN - cycles) < 4 * found.errors / TURN)
    np.testing.assert_allclose(found.amplitudes, [1.0, 0.5j, 0.2], rtol=0, atol=0.02)


def test_aliases_of_one_night_a_day_are_listed_with_what_excludes_them(rng):
    times = nights(rng, 8, 25)
    signal = sum_of(times, [1.7], [0.3]) + 0.02 * rng.normal(size=200)
    found = pt.analysis.frequencies(signal, times, 1, highest=TURN * 6)
    alias_rates = np.sort(found.aliases[0][np.isfinite(found.aliases[0])]) / TURN
    assert np.min(np.abs(alias_rates - 0.7)) < 0.01
    assert np.min(np.abs(alias_rates - 2.7)) < 0.01
    assert np.all(np.nan_to_num(found.alias_chi2[0], nan=np.inf) > 100)
    assert "aliases not excluded" not in repr(found)


def test_aliases_that_the_noise_does_not_exclude_are_in_the_summary(rng):
    times = nights(rng, 3, 40, hours=2.0)
    signal = sum_of(times, [1.7], [0.1]) + 0.1 * rng.normal(size=120)
    found = pt.analysis.frequencies(signal, times, 1, highest=TURN * 6)
    candidates = np.append(found.aliases[0], found.frequencies) / TURN
    assert np.nanmin(np.abs(candidates - 1.7)) < 0.05
    assert np.nanmin(found.alias_chi2[0]) < 16
    assert "aliases not excluded: " in repr(found)


def test_light_curve_of_apophis_with_daily_gaps(rng):
    """Lines of both periods of Pravec et al. (2014), 27.38 h and 263 h, in magnitudes with 0.03 mag of noise."""
    precession, rotation = 24 / 27.38, 24 / 263
    cycles = 2 * np.array([precession - rotation, precession, precession - 2 * rotation, 2 * (precession - rotation)])
    wrong = 0
    for _ in range(8):
        times = nights(rng)
        amplitudes = np.array([0.3, 0.12, 0.08, 0.05]) * np.exp(1j * rng.uniform(0, TURN, 4))
        signal = 19 + sum_of(times, cycles, amplitudes) + 0.03 * rng.normal(size=times.size)
        found = pt.analysis.frequencies(signal, times, 6, highest=TURN * 8)
        nearest = np.argmin(np.abs(found.frequencies[:, None] / TURN - cycles), axis=0)
        off = np.abs(found.frequencies[nearest] / TURN - cycles) / (found.errors[nearest] / TURN)
        wrong += found.frequencies.size != 5 or np.max(off) > 4.5
    assert wrong == 0


def test_order_of_times_and_repeated_times_do_not_matter(rng):
    times = np.round(nights(rng, 6), 2)
    signal = 2 + sum_of(times, [1.7], [0.3]) + 0.02 * rng.normal(size=times.size)
    assert np.any(np.diff(times) == 0)
    found, order = pt.analysis.frequencies(signal, times, 2, highest=30.0), rng.permutation(times.size)
    shuffled = pt.analysis.frequencies(signal[order], times[order], 2, highest=30.0)
    np.testing.assert_allclose(shuffled.frequencies, found.frequencies, rtol=1e-10, atol=0)
    np.testing.assert_allclose(shuffled.amplitudes, found.amplitudes, rtol=1e-8, atol=0)


def test_each_signal_of_an_array_is_decomposed_alone(rng):
    times = nights(rng, 6)
    signals = np.stack([sum_of(times, [1.7], [0.3]), 4 + sum_of(times, [2.2, 3.1], [0.2, 0.1])])
    signals += 0.01 * rng.normal(size=signals.shape)
    sigma = np.array([[0.01], [0.02]]) * np.ones(times.size)
    found = pt.analysis.frequencies(signals, times, 3, sigma=sigma, highest=TURN * 5)
    assert found.frequencies.shape == found.resolved.shape == (2, 3)
    assert found.aliases.shape == found.alias_chi2.shape == (2, 3, 4)
    assert not np.any(found.resolved[0, 1:])
    for i in range(2):
        one = pt.analysis.frequencies(signals[i], times, 3, sigma=sigma[i], highest=TURN * 5)
        np.testing.assert_array_equal(found.frequencies[i, : one.frequencies.size], one.frequencies)
        np.testing.assert_array_equal(found.aliases[i, : one.frequencies.size], one.aliases)
        np.testing.assert_array_equal(found.residual[i], one.residual)


def test_a_drifting_line_is_not_resolved(rng):
    times = nights(rng, 20, 30)
    signal = np.cos(TURN * (1.7 * times + 2e-3 * times**2)) + 0.02 * rng.normal(size=600)
    with pytest.warns(UserWarning, match="frequencies should be resolved"):
        found = pt.analysis.frequencies(signal, times, 1, highest=TURN * 4)
    assert not found.resolved[0]
    assert abs(found.frequencies[0] / TURN - 1.74) < 0.1


SIGNAL = np.cos(np.arange(100.0))
TIMES = np.arange(100.0) ** 1.01


@pytest.mark.parametrize(
    ("arguments", "error", "sentence"),
    [
        (
            {"sigma": 0.0},
            ValueError,
            "sigma must be positive, got 0.0. Give the standard deviation of a sample.",
        ),
        (
            {"sigma": np.ones(99)},
            ValueError,
            "sigma must have the shape of the signal, (100,), got shape (99,).",
        ),
        ({"highest": -1.0}, ValueError, "highest must be positive, got -1.0."),
        (
            {"highest": 1e5},
            ValueError,
            "highest must be below 12712.1 for a run of 103.655, got 100000. "
            "A spectrum has at most 1048576 frequencies.",
        ),
        ({"times": np.ones(100)}, ValueError, "times must differ, got 100 times 1.0."),
        ({"times": [*TIMES[:-1], np.nan]}, ValueError, "times must be finite, got times[99] = nan."),
        (
            {"signal": [*SIGNAL[:-1], np.nan]},
            ValueError,
            "signal must be finite, but signal[99] = nan. Omit absent samples together with their times.",
        ),
        (
            {"signal": SIGNAL[:20], "times": TIMES[:20]},
            ValueError,
            "signal must have at least 32 samples along its last axis for 1 lines in the run, got shape (20,).",
        ),
    ],
)
def test_wrong_arguments(arguments, error, sentence):
    given = {"signal": SIGNAL, "times": TIMES, "count": 1}
    with pytest.raises(error, match="^" + re.escape(sentence) + "$"):
        pt.analysis.frequencies(**(given | arguments))
