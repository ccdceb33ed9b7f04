"""Axes fixed in a planet: their formulas, their digits, and what is refused."""

import mpmath
import numpy as np
import pytest

import poinsot as pt
from poinsot.orbits import RotationModel
from poinsot.orbits.rotation import NutatingRotation

FIELDS = {"rate": 0.7, "right_ascension_rate": 0.02, "declination_rate": -0.03, "epoch": 0.4}
PLAIN = RotationModel(1.1, 0.6, -2.0, acceleration=0.01, **FIELDS)
PERIODIC = NutatingRotation(
    1.1, 0.6, -2.0, **FIELDS, terms=2, periodic=[(0.02, 0.03, -0.05, 1.0, 0.9), (0.01, -0.02, 0.03, 0.2, -1.3)]
)
each_model = pytest.mark.parametrize("model", [PLAIN, PERIODIC], ids=["plain", "periodic"])


def by_hand(model, time):
    """The matrix planet -> space, a product of three turns, on numbers of 40 digits."""

    def about(axis, angle):
        c, s = mpmath.cos(angle), mpmath.sin(angle)
        rows = {3: ((c, -s, 0), (s, c, 0), (0, 0, 1)), 1: ((1, 0, 0), (0, c, -s), (0, s, c))}
        return mpmath.matrix(rows[axis])

    since = mpmath.mpf(time) - float(model.epoch)
    alpha = float(model.right_ascension) + float(model.right_ascension_rate) * since
    delta = float(model.declination) + float(model.declination_rate) * since
    meridian = float(model.prime_meridian) + float(model.rate) * since + float(model.acceleration) * since**2 / 2
    for a, d, w, phase, rate in getattr(model, "periodic", ()):
        angle = float(phase) + float(rate) * since
        alpha, delta = alpha + float(a) * mpmath.sin(angle), delta + float(d) * mpmath.cos(angle)
        meridian += float(w) * mpmath.sin(angle)
    quarter = mpmath.pi / 2
    return about(3, alpha + quarter) * about(1, quarter - delta) * about(3, meridian)


@each_model
def test_the_frame_is_a_product_of_three_turns(model):
    with mpmath.workdps(40):
        for time in (0.4, 3.0, -55.0):
            expected = np.array(by_hand(model, time).tolist(), dtype=float)
            # Three times the worst, here and below.
            assert np.max(np.abs(model.attitude(time).as_matrix() - expected)) < 4e-15
            columns = np.array([list(axis) for axis in model.axes_at(time)], dtype=float).T
            assert np.max(np.abs(columns - expected)) < 4e-15


@each_model
def test_angular_velocity_is_that_of_the_matrix(model):
    with mpmath.workdps(40):
        for time in (0.4, 3.0, -55.0):
            slope = mpmath.matrix(3, 3)
            for i in range(3):
                for j in range(3):
                    slope[i, j] = mpmath.diff(lambda t, i=i, j=j: by_hand(model, t)[i, j], time)
            turning = np.array((slope * by_hand(model, time).T).tolist(), dtype=float)
            expected = (turning[2, 1], turning[0, 2], turning[1, 0])
            assert np.max(np.abs(model.omega_space(time) - expected)) < 5e-15


@each_model
def test_vectors_go_to_the_planet_and_back(model):
    vector, time = (0.3, -1.2, 0.7), 12.5
    there = list(model.to_planet(vector, time))
    assert np.allclose(there, model.attitude(time).inv().apply(vector), rtol=0, atol=1.5e-15)
    assert np.allclose(list(model.to_space(there, time)), vector, rtol=0, atol=1e-15)


def test_digits_stay_over_a_thousand_years():
    mars, time = RotationModel.iau("mars"), 3.15576e10 + 0.123
    with mpmath.workdps(40):
        expected = np.array(by_hand(mars, time).tolist(), dtype=float)
    assert np.max(np.abs(mars.attitude(time).as_matrix() - expected)) < 3e-15


def test_arrays_of_times_and_members():
    many = RotationModel((1.1, 1.2), 0.6, -2.0, **FIELDS)
    times = np.linspace(0, 3, 4)
    assert PERIODIC.quaternion(times).shape == (4, 4)
    assert PERIODIC.omega_space(times).shape == (4, 3)
    assert np.array_equal(PERIODIC.quaternion(times)[2], PERIODIC.quaternion(times[2]))
    assert many.quaternion(1.0).shape == (2, 4)
    assert np.array_equal(many.quaternion(1.0)[0], RotationModel(1.1, 0.6, -2.0, **FIELDS).quaternion(1.0))
    assert many.omega_space(1.0).shape == (2, 3)


def test_states_relative_to_the_planet():
    body = pt.Body((1, 2, 2.5))
    at_rest = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), time=3.0, frame=PLAIN)
    assert np.allclose(at_rest.quaternion, PLAIN.quaternion(3.0), rtol=0, atol=1e-15)
    rate = at_rest.attitude.apply(body.omega(at_rest.angular_momentum_body))
    assert np.allclose(rate, PLAIN.omega_space(3.0), rtol=0, atol=1e-15)


def test_what_is_refused():
    with pytest.raises(ValueError, match=r"^body must be one of sun, mercury, .*titan, got 'vulcan'\.$"):
        RotationModel.iau("vulcan")
    with pytest.raises(ValueError, match=r"^reference_frame must be ICRF or TEME, got 'MOD'\.$"):
        RotationModel.earth(reference_frame="MOD")
    with pytest.raises(TypeError, match="calendar must be a Calendar, got str"):
        RotationModel.iau("mars", calendar="J2000")
