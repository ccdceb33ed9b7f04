"""Lines of signals whose lines are known."""

import re

import numpy as np
import pytest

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


def test_lines_that_are_closer_than_half_a_bin_are_one():
    times = np.arange(2048) * 0.25
    rates = np.array([1.0, 1 + 0.2 * 2 * np.pi / 512])
    strongest = pt.analysis.frequencies(waves(times, rates) @ [1.0, 0.5], times, count=5)
    gaps = np.diff(np.sort(strongest.frequencies)) * 512 / (2 * np.pi)
    assert np.all(gaps >= 0.5)


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
def test_a_real_line_beside_the_highest_frequency(samples, bins, phase):
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
    times = EVEN.copy()
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
            lambda: pt.analysis.frequencies(SIGNAL, shifted()),
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
