"""Integrated solutions of vector fields against closed forms with 40 digits."""

import copy
import pickle

import mpmath as mp
import numpy as np
import pytest

from poinsot.functions import Vector
from poinsot.records.parameters import Parametric
from poinsot.taylor.paths import Path

EPS = np.finfo(float).eps


class Oscillator(Parametric):
    """Harmonic oscillator, x' = v, v' = -w^2 x."""

    rate: float
    size = 2

    def rates_at(self, _, own):
        x, v = own
        return Vector((v, -(self.rate * self.rate) * x))


class Fall(Parametric):
    """Radial fall on an attractor, r'' = -mu / r^2, from rest: collision at pi/2 sqrt(r^3 / (2 mu))."""

    mu: float
    size = 2

    def rates_at(self, _, own):
        r, v = own
        return Vector((v, -self.mu / (r * r)))


def exact(rate, time):
    """Position and velocity from x = 1, v = 0, and the unit in their last places."""
    with mp.workdps(40):
        angle = mp.mpf(float(rate)) * mp.mpf(float(time))
        return float(mp.cos(angle)), float(-mp.mpf(float(rate)) * mp.sin(angle))


@pytest.mark.parametrize("time", [0.0, 1e-3, 0.7, -0.7, 40.0, -40.0])
def test_a_solution_is_rounded_once(time):
    """The error after six periods is that of the result: half a unit in the last place."""
    rate = 1.1
    found = Path(Oscillator(rate), (1.0, 0.0))(np.float64(time))
    assert np.all(np.abs(found - exact(rate, time)) <= 0.5 * np.spacing(np.abs(exact(rate, time))) + 1e-22)


def test_members_have_parameters_and_times_of_their_own():
    rates, times = np.array([0.5, 1.0, 2.0]), np.array([-3.0, 0.0, 5.0])
    found = Path(Oscillator(rates), (1.0, 0.0))(times)
    assert found.shape == (2, 3)
    for i in range(3):
        np.testing.assert_allclose(found[:, i], exact(rates[i], times[i]), rtol=EPS, atol=1e-22)
    grid = Path(Oscillator(rates), (1.0, 0.0))
    assert grid(times[:, None]).shape == (2, 3, 3)
    assert np.array_equal(grid(times[:, None])[:, 2], Path(Oscillator(rates), (1.0, 0.0))(np.full(3, 5.0)))


def test_a_time_has_the_same_bits_in_any_order_of_calls():
    times = np.array([0.3, 17.0, 2.5, 60.0])
    one, another = Path(Oscillator(1.1), (1.0, 0.0)), Path(Oscillator(1.1), (1.0, 0.0))
    whole = one(times)
    each = np.stack([another(time) for time in times], axis=-1)
    assert np.array_equal(whole, each)
    assert np.array_equal(one(times[::-1])[:, ::-1], whole)


def test_results_have_the_precision_of_the_time():
    if np.finfo(np.longdouble).eps == EPS:
        pytest.skip("long doubles are doubles on this processor")
    time = np.longdouble(1) / 3
    found = Path(Oscillator(1.0), (1.0, 0.0))(time)
    assert found.dtype == np.longdouble
    with mp.workdps(40):
        high, low = float(time), float(time - np.longdouble(float(time)))
        cosine = mp.cos(mp.mpf(high) + mp.mpf(low))
        error = mp.mpf(float(found[0])) + mp.mpf(float(found[0] - np.longdouble(float(found[0])))) - cosine
    assert abs(error) < float(np.finfo(np.longdouble).eps)


def test_beyond_a_collision_a_solution_is_nan():
    collision = np.pi / 2 * np.sqrt(0.5)
    path = Path(Fall(1.0), (1.0, 0.0))
    found = path(np.array([0.9 * collision, -0.9 * collision, 1.1 * collision, -1.1 * collision]))
    assert np.all(np.isfinite(found[:, :2]))
    assert np.all(np.isnan(found[:, 2:]))
    r, v = found[:, 0]
    assert 0.5 * v * v - 1 / r == pytest.approx(-1.0, abs=8 * EPS / r)


def test_copies_integrate_again_to_the_same_bits():
    path = Path(Oscillator(1.1), (1.0, 0.0))
    before = path(np.float64(9.0))
    assert np.array_equal(copy.deepcopy(path)(np.float64(9.0)), before)
    assert np.array_equal(pickle.loads(pickle.dumps(path))(np.float64(9.0)), before)


def test_fields_that_differ_in_their_parameters_share_a_kernel(monkeypatch):
    Path(Oscillator(1.1), (1.0, 0.0))(np.float64(1.0))
    monkeypatch.setattr("poinsot.taylor.kernels.compiled", None)
    found = Path(Oscillator(0.3), (1.0, 0.0))(np.float64(1.0))
    np.testing.assert_allclose(found, exact(0.3, 1.0), rtol=EPS)


class Coupled(Parametric):
    """The same equations with a structural field."""

    rate: float
    tripled: bool = False
    size = 2

    def rates_at(self, _, own):
        x, v = own
        return Vector((v, -(self.rate * self.rate) * x * (9 if self.tripled else 1)))


def test_fields_of_another_structure_have_a_kernel_of_their_own():
    slow, fast = (Path(Coupled(1.0, tripled), (1.0, 0.0))(np.float64(0.5)) for tripled in (False, True))
    assert slow[0] == pytest.approx(np.cos(0.5), rel=4 * EPS, abs=0)
    assert fast[0] == pytest.approx(np.cos(1.5), rel=4 * EPS, abs=0)
