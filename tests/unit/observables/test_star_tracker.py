"""Tests of star trackers: mounting, blinding, residuals, the noise of controllers, and wrong arguments."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment
from poinsot.observables import Exclusion, Gyro, Readings, StarTracker

EPS = np.finfo(float).eps
BODY = pt.Body((1.25, 1.0, 0.75))
MOUNTING = Rotation.from_rotvec([0.3, -1.0, 0.4])
SUN = pt.orbits.FixedPosition(1.0, position=(-10.0, 0, 0))
"""The Sun is towards the first space axis."""


def spinning(times, omega=(0, 0, 1.0), **others):
    return pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=omega, **others), times)


def test_the_reading_is_the_attitude_times_the_mounting():
    motion = spinning(np.linspace(0, 3, 6), (0.3, 1.0, 0.2))
    expected = motion.attitude * MOUNTING
    read = Rotation.from_quat(pt.observe(motion, StarTracker(mounting=MOUNTING)).values, scalar_first=True)
    assert np.max((read.inv() * expected).magnitude()) < 8 * EPS
    assert np.array_equal(pt.observe(motion, StarTracker()).values, motion.quaternion)


def test_bright_bodies_blind_within_their_cone():
    """The boresight, the first body axis, circles in the plane of the Sun: its angle from the Sun is the time."""
    times = np.linspace(0, np.pi, 181)
    motion = spinning(times)
    tracker = StarTracker(
        mounting=Rotation.from_euler("y", 90, degrees=True), exclusions=[Exclusion(SUN, np.radians(30.5), radius=5.0)]
    )
    # The limb of a sphere at twice its radius is 30 degrees from its centre.
    with pytest.warns(UserWarning, match=r"^StarTracker must have a reading .* blinded at 61\. These .*\.$"):
        values = pt.observe(motion, tracker).values
    assert np.array_equal(np.isnan(values).any(axis=-1), np.degrees(times) < 60.5)


def test_one_of_several_bright_bodies_suffices():
    moon = pt.orbits.FixedPosition(1.0, position=(0, -3.0, 0))
    tracker = StarTracker(exclusions=[Exclusion(SUN, 0.2), Exclusion(moon, 1.0)])
    assert not np.isnan(pt.observe(spinning([0.0]), tracker).values).any()
    turned = pt.propagate(pt.System(BODY), BODY.state(Rotation.from_euler("x", -1.0), omega_body=(0, 0, 0)), [0.0])
    with pytest.warns(UserWarning, match=r"blinded at 1"):
        assert np.isnan(pt.observe(turned, tracker).values).all()


def test_the_residual_is_the_shorter_turn_about_the_sensor_axes():
    tracker, turn = StarTracker(), np.array([[0.1, -0.2, 0.3], [1e-9, 0, 0], [2.0, 0.0, 2.4]])
    predicted = quat.exponential(np.array([(0.4, 1.0, -2.0), (0, 0, 0), (3.0, 0, 0)]))
    read = quat.product(predicted, quat.exponential(turn))
    for sign in (1, -1):
        found = tracker.difference(sign * read, predicted)
        assert np.allclose(found, turn, rtol=1e-14, atol=8 * EPS)
    longer = quat.exponential(np.array([4.0, 0, 0]))
    assert np.allclose(tracker.difference(longer, np.array([1.0, 0, 0, 0])), [4 - 2 * np.pi, 0, 0], rtol=1e-14, atol=0)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(0, 1e3))
def test_errors_turn_an_attitude_about_their_own_direction(seed, size):
    """The residual of a reading with errors d is along d, with the length 2 atan(|d| / 2)."""
    rng = np.random.default_rng(seed)
    q, d = (x / np.linalg.norm(x) for x in (rng.normal(size=4), rng.normal(size=3)))
    tracker = StarTracker()
    read = tracker.disturbed(q, size * d)
    assert np.linalg.norm(read) == pytest.approx(1, rel=8 * EPS, abs=0)
    found = tracker.difference(read, q)
    # The sine of half the angle has the roundings of unit quaternions, which the angle doubles.
    assert np.allclose(found, 2 * np.arctan(size / 2) * d, rtol=0, atol=32 * EPS)
    assert np.allclose(tracker.difference(q, read), -found, rtol=0, atol=32 * EPS)


@pytest.mark.parametrize("noise", [1e-5, 0.3])
def test_noise_has_the_meaning_of_the_sensors_of_controllers(noise):
    """The same normal numbers give the same attitude, and the same rate to the bit."""
    normals = np.array([0.3, -1.7, 0.4, 1.1, -0.2, 0.6])
    sensors = pt.control.NoisySensors(rate_noise=0.02, attitude_noise=noise)
    q = np.array([0.5, -0.5, 0.1, 0.7])
    instant = pt.Instant(BODY, pt.Attitude.from_quaternion(q), Environment(0.0), (0.1, 0.2, 0.3))
    with np.errstate(divide="ignore", invalid="ignore"):  # quanta of zero
        measured = sensors.measured(instant, Vector(normals))
    read = StarTracker(noise=noise).disturbed(q, noise * normals[3:])
    expected = np.array([float(x) for x in measured.attitude.quaternion])
    assert np.allclose(read, expected, rtol=0, atol=2 * EPS)  # which the sensors normalise once more
    gyro = Gyro(noise=0.02)
    rate = gyro.disturbed(np.array([0.1, 0.2, 0.3]), 0.02 * normals[:3])
    assert np.array_equal(rate, [float(x) for x in measured.omega_body])


def test_the_statistics_of_noise_are_those_of_each_axis():
    deviations, count = np.array([1e-4, 2e-4, 1e-3]), 4000
    readings = pt.observe(spinning(np.linspace(0, 1, count)), StarTracker(mounting=MOUNTING, noise=deviations))
    errors = readings.observable.difference(readings.simulated(seed=11).values, readings.values)
    # Relative error 1 / sqrt(2 n) of a standard deviation, 1 / sqrt(n) of a correlation; four deviations.
    assert np.allclose(errors.std(axis=0) / deviations, 1, rtol=0, atol=4 / np.sqrt(2 * count))
    assert np.max(np.abs(np.corrcoef(errors.T) - np.eye(3))) < 4 / np.sqrt(count)
    assert np.allclose(np.linalg.norm(readings.simulated(seed=11).values, axis=-1), 1, rtol=0, atol=8 * EPS)


def test_members_have_trackers_of_their_own():
    angles = np.array([0.2, 3.0])
    motion = spinning([0.0, 1.0], np.array([(0, 0, 1.0), (0, 0.5, 1.0)]))
    mountings = MOUNTING.as_quat(scalar_first=True) * np.ones((2, 1))
    tracker = StarTracker(mounting=mountings, exclusions=[Exclusion(SUN, angles)])
    with pytest.warns(UserWarning, match="blinded at 2"):
        both = pt.observe(motion, tracker).values
    assert both.shape == (2, 2, 4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for i in range(2):
            one = StarTracker(mounting=MOUNTING, exclusions=[Exclusion(SUN, angles[i])])
            alone = pt.observe(motion.isel(member=i), one).values
            assert np.allclose(both[i], alone, rtol=0, atol=4 * EPS, equal_nan=True)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: StarTracker(mounting=(1.0, 0.1, 0, 0)),
            r"mounting must have unit norm, but \|q\| = 1\.004987562\. Divide by the norm, or pass a Rotation\.",
        ),
        (lambda: StarTracker(noise=(1e-5, -1e-5, 0)), r"noise must not be negative, got -1e-05\."),
        (
            lambda: Exclusion(SUN, 30.0),
            r"angle must be from 0 to pi, got 30\. Degrees: np\.radians\(value\)\.",
        ),
        (lambda: Exclusion(SUN, 0.5, radius=-1.0), r"radius must not be negative, got -1\.0\."),
        (
            lambda: Readings(StarTracker(), [0.0, 1.0], [(1.0, 0, 0, 0), (1.0, 0.2, 0, 0)], sigma=1e-3),
            r"values must have unit norm, but \|q\| = 1\.019803903\. Divide by the norm, or pass a Rotation\.",
        ),
    ],
)
def test_wrong_arguments_are_refused(make, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        make()


def test_absent_readings_have_no_norm():
    values = [(1.0, 0, 0, 0), (np.nan,) * 4]
    assert Readings(StarTracker(), [0.0, 1.0], values, sigma=1e-3).values.shape == (2, 4)
