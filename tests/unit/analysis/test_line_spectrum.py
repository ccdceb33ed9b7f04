"""Lines of signals whose lines are known."""

import re
import warnings

import numpy as np
import pytest
from scipy.optimize import least_squares

import poinsot as pt

PI = np.longdouble("3.14159265358979323846264338")
DECADES = np.array([1.0, 2.3, -0.7, 3.14159, 0.11, -5.2, 7.7, -11.3, 13.0, -17.77, 0.5])


def waves(times, rates):
    """exp(i rates t), shape (times, rates), right to rounding."""
    turns = np.multiply.outer(np.asarray(times, np.longdouble), np.asarray(rates, np.longdouble))
    return np.exp(1j * np.asarray(turns % (2 * PI), float))


def assert_same_lines(found, rates, amplitudes, rtol):
    np.testing.assert_allclose(found.frequencies, rates, rtol=rtol, atol=0)
    np.testing.assert_allclose(found.amplitudes, amplitudes, rtol=1e3 * rtol, atol=0)


@pytest.fixture
def rng():
    return np.random.default_rng(20)


def test_amplitudes_over_ten_decades(rng):
    times = np.arange(2**14) * 0.125
    amplitudes = 10.0 ** -np.arange(11) * np.exp(1j * rng.uniform(0, 6, 11))
    found = pt.analysis.frequencies(waves(times, DECADES) @ amplitudes, times, count=20)
    assert len(found.frequencies) == 11  # and then it stops
    assert np.all(np.abs(found.frequencies - DECADES) < 8 * found.errors)  # rounding is no white noise
    np.testing.assert_allclose(found.frequencies[:7], DECADES[:7], rtol=1e-14)
    assert np.all(found.errors < 1e-16 / np.abs(amplitudes) + 2.3e-16 * np.abs(DECADES))
    np.testing.assert_allclose(found.amplitudes, amplitudes, rtol=1e-12, atol=2e-16)
    assert found.residual < 1e-15


@pytest.mark.parametrize("apart", [0.7, 1.0, 2.5, 6.0])
@pytest.mark.parametrize("ratio", [0.95, 0.1, 1e-3])
def test_close_pairs(apart, ratio):
    times = np.arange(2048) * 0.25
    rates = np.array([1.0, 1 + apart * 2 * np.pi / 512])
    found = pt.analysis.frequencies(waves(times, rates) @ [1.0, ratio * 1j], times, count=2)
    assert_same_lines(found, rates, [1.0, ratio * 1j], rtol=5e-13 / ratio)
    assert np.all(np.abs(found.frequencies - rates) < 5 * found.errors)


def test_a_pair_a_fifth_of_a_turn_apart_without_noise():
    times = np.arange(2048) * 0.25
    rates = np.array([1.0, 1 + 0.2 * 2 * np.pi / 512])
    found = pt.analysis.frequencies(waves(times, rates) @ [1.0, 0.5], times, count=5)
    np.testing.assert_allclose(found.frequencies[:2], rates, rtol=1e-11)
    assert np.all(found.resolved[:2])


def fitted_pair(signal, times, start):
    """Frequencies of the least squares of two lines, by SciPy, from an independent sum of waves."""

    def rest(rates):
        columns = np.exp(1j * np.outer(times, rates))
        off = columns @ np.linalg.lstsq(columns, signal, rcond=None)[0] - signal
        return np.concatenate([off.real, off.imag])

    return least_squares(rest, start, xtol=1e-15, ftol=1e-15).x


@pytest.mark.parametrize("noise", [1e-2, 1e-6, 0.0])
@pytest.mark.parametrize("apart", [0.6, 0.8, 1.0, 1.25])
def test_pairs_of_any_phases_are_found_to_the_noise(rng, noise, apart):
    times, turn = np.linspace(0, 100, 256), 2 * np.pi / 100
    rates = np.array([20.7, 20.7 + apart]) * turn
    for _ in range(12):
        white = rng.normal(size=256) + 1j * rng.normal(size=256)
        signal = waves(times, rates) @ np.exp(1j * rng.uniform(0, 6.3, 2)) + noise * white / np.sqrt(2)
        found = pt.analysis.frequencies(signal, times, count=2)
        order = np.argsort(found.frequencies)
        assert np.all(found.resolved)
        assert np.all(np.abs(found.frequencies[order] - rates) < 5 * found.errors[order] + 1e-14)
        fitted = fitted_pair(signal, times, rates + 0.1 * turn * np.array([-1, 1]))
        assert np.all(np.abs(found.frequencies[order] - fitted) < 5 * found.errors[order] + 1e-10)


@pytest.mark.parametrize("mean", [0.0, 0.3])
@pytest.mark.parametrize("turns", [0.6, 0.75, 1.0, 1.5])
def test_a_slow_cosine_is_no_mean(rng, turns, mean):
    times, turn = np.linspace(0, 100, 256), 2 * np.pi / 100
    for _ in range(12):
        signal = mean + np.cos(turns * turn * times + rng.uniform(0, 6.3)) + 1e-6 * rng.normal(size=256)
        found = pt.analysis.frequencies(signal, times, count=1 + (mean > 0))
        assert found.resolved[0]
        assert abs(found.frequencies[0] - turns * turn) < 5 * found.errors[0] < 1e-3 * turn
        np.testing.assert_array_equal(found.frequencies[1:], [0.0] * (mean > 0))


@pytest.mark.parametrize("real", [False, True])
@pytest.mark.parametrize("noise", [1e-2, 1e-6, 0.0])
def test_one_line_in_the_place_of_two_is_not_resolved(rng, real, noise):
    """Its standard error covers the nearest of the two, of any ratio of amplitudes from 1 to 30."""
    off = []
    for _ in range(60):
        turns = 20.7 + np.array([0, rng.uniform(0.5, 2.0)])
        amplitudes = np.array([1.0, 30 ** -rng.uniform(0, 1)]) * np.exp(1j * rng.uniform(0, 6.3, 2))
        white = rng.normal(size=256) + 1j * rng.normal(size=256)
        signal = waves(np.arange(256), 2 * np.pi * turns / 256) @ amplitudes + noise * white
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = pt.analysis.frequencies(signal.real if real else signal, 1.0, count=1)
        if found.resolved[0]:  # where noise hides the second line
            assert noise == 1e-2
            continue
        off.append(np.min(np.abs(found.frequencies[0] - 2 * np.pi * turns / 256)) / found.errors[0])
    assert len(off) > 50
    assert np.max(off) < 3


def test_a_slow_cosine_with_a_mean_as_one_line_is_not_resolved():
    times = np.arange(256)
    signal = 1 + 0.7 * np.cos(2 * np.pi * 0.8 / 256 * times + 1.0)
    with pytest.warns(UserWarning, match="frequencies should be resolved"):
        found = pt.analysis.frequencies(signal, times, count=1)
    assert not found.resolved[0]
    nearest = np.min(np.abs(found.frequencies[0] - 2 * np.pi * np.array([0.0, 0.8]) / 256))
    assert nearest < 3 * found.errors[0]


def test_unresolved_lines_cause_one_warning_and_a_row_of_the_summary():
    times = np.arange(256)
    pair = waves(times, 2 * np.pi * np.array([20.7, 21.7]) / 256) @ [1.0, 0.5j]
    sentence = (
        "frequencies should be resolved, but 1 of 2 lines are not, with standard errors of up to 0.25 turns over the "
        "run: another line is closer than about two turns, or the line drifts. Propagate for a longer time, or raise "
        "count."
    )
    with pytest.warns(UserWarning, match="^" + re.escape(sentence) + "$") as caught:
        found = pt.analysis.frequencies([pair, waves(times, [1.0])[:, 0]], times, count=1)
    assert len(caught) == 1
    np.testing.assert_array_equal(found.resolved, [[False], [True]])
    assert "not resolved: " in repr(found)
    assert "not resolved" not in repr(pt.analysis.frequencies(pair, times, count=2))


def test_a_signal_with_fewer_lines_has_none_resolved_beyond_them():
    times = np.arange(256)
    one, two = waves(times, [1.0]) @ [1.0], waves(times, [1.0, 2.0]) @ [1.0, 0.5]
    found = pt.analysis.frequencies([one, two], times, count=2)
    np.testing.assert_array_equal(found.resolved[1], [True, True])
    assert np.isnan(found.frequencies[0, -1])
    assert not found.resolved[0, -1]


@pytest.mark.parametrize("real", [False, True])
@pytest.mark.parametrize("bins", [5, 60])
def test_errors_under_noise_are_standard_errors(rng, real, bins):
    times = np.arange(512) * 0.1
    rates = np.array([2.2, 2.2 + bins * 2 * np.pi / 51.2])
    off = []
    for _ in range(100):
        noise = rng.normal(size=512) + 1j * rng.normal(size=512)
        signal = waves(times, rates) @ [1.0, 0.2] + 0.05 * noise
        found = pt.analysis.frequencies(signal.real if real else signal, times, count=3)
        off.append((found.frequencies[:2] - rates) / found.errors[:2])
    true_over_estimated = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.all((true_over_estimated > 0.85) & (true_over_estimated < 1.25))
    assert np.all(np.abs(np.mean(off, axis=0)) < 0.35)


@pytest.mark.parametrize("real", [False, True])
def test_errors_from_lines_that_were_left_out(rng, real):
    times = np.arange(1024) * 0.125
    off = []
    for _ in range(30):
        order = np.arange(0 if real else -10, 12)
        rates = rng.uniform(1.7, 2.0) + order * rng.uniform(1.0, 1.1)
        signal = waves(times, rates) @ (0.3 ** np.abs(order) * np.exp(1j * rng.uniform(0, 6, order.size)))
        found = pt.analysis.frequencies(signal.real if real else signal, times, count=5)
        off.append(np.min(np.abs(found.frequencies[:, None] - rates), axis=1) / found.errors)
    assert np.max(off) < 3
    assert np.all(np.median(off, axis=0)[1:] > 0.1)


def test_noise_alone_has_no_lines(rng):
    noise = rng.normal(size=(20, 4096)) + 1j * rng.normal(size=(20, 4096))
    assert pt.analysis.frequencies(noise, 1.0).frequencies.shape == (20, 0)


def test_a_real_signal():
    times = np.arange(4096) * 0.25
    rates = [1.3, 0.0, 0.04, 3.0]
    amplitudes = np.array([np.exp(0.4j), 0.5, -1e-3j, 1e-8])
    found = pt.analysis.frequencies((waves(times, rates) @ amplitudes).real, times, count=4)
    np.testing.assert_allclose(found.frequencies, rates, rtol=1e-9)
    np.testing.assert_allclose(found.frequencies[:3], rates[:3], rtol=1e-14)
    np.testing.assert_allclose(found.amplitudes, amplitudes, rtol=0, atol=5e-13)
    assert found.errors[1] == 0


@pytest.mark.parametrize("samples", [256, 257])
@pytest.mark.parametrize("bins", [0.3, 0.5, 1.2, 3.0])
@pytest.mark.parametrize("phase", [0.3, 1.5])
def test_a_real_line_near_the_highest_frequency(samples, bins, phase):
    """It and its mirror image at the other sign are 2 bins apart."""
    turns = 0.5 - bins / samples
    found = pt.analysis.frequencies(np.cos(2 * np.pi * turns * np.arange(samples) + phase), 1.0, count=3)
    assert found.frequencies[0] == pytest.approx(2 * np.pi * turns, rel=1e-13, abs=0)
    assert found.amplitudes[0] == pytest.approx(np.exp(1j * phase), rel=1e-10, abs=0)
    assert found.residual < 1e-13


def test_a_real_line_that_is_one_with_its_mirror_image_is_none():
    found = pt.analysis.frequencies(np.cos(np.pi * np.arange(256)), 1.0, count=3)
    assert np.all(np.abs(found.amplitudes) < 0.01)
    assert np.all(found.frequencies < np.pi * (1 - 0.5 / 256))


def test_signals_side_by_side_are_those_alone(rng):
    times = np.linspace(3.0, 83.0, 401)
    signals = waves(times, [1.0, -2.0, 0.3]) @ rng.normal(size=(3, 2, 3)).reshape(3, 6)
    signals = signals.T.reshape(2, 3, 401)
    signals[0, 1] = 0.0
    together = pt.analysis.frequencies(signals, times, count=5)
    assert together.residual.shape == (2, 3)
    alone = pt.analysis.frequencies(signals[1, 2], times, count=5)
    lines = alone.frequencies.size
    np.testing.assert_array_equal(together.frequencies[1, 2, :lines], alone.frequencies)
    np.testing.assert_array_equal(together.errors[1, 2, :lines], alone.errors)
    assert np.all(np.isnan(together.frequencies[0, 1]))
    drift = pt.analysis.diffusion(signals[1], times)
    np.testing.assert_array_equal(drift[2], pt.analysis.diffusion(signals[1, 2], times))


def test_the_clock_of_the_times():
    later = np.linspace(100.0, 151.1, 512)
    rates, amplitudes = [1.3, -0.7], [2.0, 0.5j]
    signal = waves(later, rates) @ amplitudes
    assert_same_lines(pt.analysis.frequencies(signal, later, count=2), rates, amplitudes, rtol=1e-13)
    assert_same_lines(pt.analysis.frequencies(signal[::-1], later[::-1], count=2), rates, amplitudes, rtol=1e-13)
    assert_same_lines(
        pt.analysis.frequencies(signal, 0.1, count=2), rates, waves([100.0], rates)[0] * amplitudes, rtol=1e-13
    )


def test_the_drift_of_a_frequency():
    times = np.arange(4096) * 0.25
    regular = waves(times, [1.0, 0.37, 0.0]) @ [1.0, 0.9, 3.0]  # the mean is not followed
    np.testing.assert_allclose(pt.analysis.diffusion(regular, times, count=2), [0, 0], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(pt.analysis.diffusion(np.ones(640), 0.1), [np.nan])
    late = times >= times[times.size // 2]
    moved = np.where(late, np.exp(1.1j * times) + 0.1 * np.exp(1j * times), np.exp(1j * times))
    np.testing.assert_allclose(
        pt.analysis.diffusion(moved, times), 0.1, rtol=1e-14
    )  # not to the weak line that is nearer
    sweep = np.exp(1j * (times + 2e-6 * times**2))  # the halves are centred half a run apart
    np.testing.assert_allclose(pt.analysis.diffusion(sweep, times), 4e-6 * 512, rtol=3e-3)


EVEN = np.arange(100) * 0.1
SIGNAL = np.cos(EVEN)


def with_nan():
    signal = np.zeros((2, 100))
    signal[1, 7] = np.nan
    return signal


def shifted():
    times = 0.1 * np.arange(2 * EVEN.size)
    times[40] += 0.01
    return times


@pytest.mark.parametrize(
    ("call", "error", "sentence"),
    [
        (
            lambda: pt.analysis.frequencies(with_nan(), 0.1),
            ValueError,
            "signal must be finite, but signal[1, 7] = nan.",
        ),
        (lambda: pt.analysis.frequencies(["a"], 0.1), TypeError, "signal must be real or complex numbers, got list."),
        (
            lambda: pt.analysis.frequencies(SIGNAL, EVEN, count=20),
            ValueError,
            "signal must have at least 160 samples along its last axis for 20 lines in the run, got shape (100,).",
        ),
        (
            lambda: pt.analysis.diffusion(SIGNAL, EVEN),
            ValueError,
            "signal must have at least 128 samples along its last axis for 8 lines in each half, got shape (100,).",
        ),
        (
            lambda: pt.analysis.diffusion(np.tile(SIGNAL, 2), shifted()),
            ValueError,
            "times must be evenly spaced, but times[40] = 4.01 is 0.01 from even ones. Propagate at np.linspace(...).",
        ),
        (
            lambda: pt.analysis.frequencies(SIGNAL, EVEN[:-1]),
            ValueError,
            "times must be as many as the samples, got 99 for 100",
        ),
        (lambda: pt.analysis.frequencies(SIGNAL, 0.0), ValueError, "times, as a step, must be positive, got 0.0."),
        (lambda: pt.analysis.frequencies(SIGNAL, 1j), TypeError, "times must be real numbers, got complex 1j."),
        (lambda: pt.analysis.frequencies(SIGNAL, 0.1, count=0), ValueError, "count must be positive, got 0."),
        (
            lambda: pt.analysis.frequencies(SIGNAL, 0.1, count=2.0),
            TypeError,
            "count must be a whole number of at most 63 bits, got float 2.0.",
        ),
    ],
)
def test_bad_input_is_one_sentence(call, error, sentence):
    with pytest.raises(error, match="^" + re.escape(sentence)):
        call()
