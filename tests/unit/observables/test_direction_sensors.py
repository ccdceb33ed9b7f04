"""Tests of sensors of directions: targets, fields of view, eclipses, the cosine law, and wrong arguments."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces import Occulter
from poinsot.mechanics.environment import Environment
from poinsot.observables import CoarseSunSensors, VectorSensor

EPS = np.finfo(float).eps
BODY = pt.Body((1.25, 1.0, 0.75))
EARTH = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.0)
"""Orbit of the body about the Earth, km, s; it begins on the first space axis and goes towards the second one."""
AU = 149597870.7
SUN = pt.orbits.FixedPosition(1.327e11, position=(-AU, 0.0, 0.0))
"""The Sun is towards the first space axis."""
SHADOW = Occulter(EARTH, 6378.137)
FIELD = pt.forces.TiltedDipole(
    EARTH, pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.3e-5), -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2
)


def spinning(times, omega=(0, 0, 1.0), attitude=(1, 0, 0, 0)):
    return pt.propagate(pt.System(BODY), BODY.state(attitude, omega_body=omega), times)


def at_rest(times, attitude=(1, 0, 0, 0)):
    return spinning(times, (0, 0, 0), attitude)


def place(times):
    return np.stack(EARTH.position_at(times), axis=-1)


TURNED = Rotation.from_rotvec([0.4, -1.0, 0.3])
TIMES = np.linspace(0.0, 5000.0, 11)


def test_the_reading_is_the_direction_of_the_attractor_along_the_body_axes():
    nadir = -place(TIMES) / np.linalg.norm(place(TIMES), axis=-1, keepdims=True)
    found = pt.observe(at_rest(TIMES, TURNED), VectorSensor(EARTH, bias=(0.1, 0.2, -0.1))).values
    expected = TURNED.inv().apply(nadir) + np.array([0.1, 0.2, -0.1])
    assert np.allclose(found, expected, rtol=0, atol=16 * EPS)


def test_a_target_may_be_a_direction_or_a_field():
    star = np.array([0.3, -2.0, 0.7])
    found = pt.observe(at_rest(TIMES, TURNED), VectorSensor(star)).values
    assert np.allclose(found, TURNED.inv().apply(star / np.linalg.norm(star)), rtol=0, atol=16 * EPS)
    field = np.stack([np.stack(FIELD.in_space(r, t)) for r, t in zip(place(TIMES), TIMES, strict=True)]).astype(float)
    expected = TURNED.inv().apply(field / np.linalg.norm(field, axis=-1, keepdims=True))
    found = pt.observe(at_rest(TIMES, TURNED), VectorSensor(FIELD)).values
    assert np.allclose(found, expected, rtol=0, atol=32 * EPS)


def test_a_target_outside_the_field_of_view_is_not_read():
    times = np.linspace(0, np.pi, 181)
    sensor = VectorSensor(SUN, boresight=(3.0, 0, 0), field_of_view=np.radians(60.5))
    with pytest.warns(UserWarning, match=r"VectorSensor .* outside the field of view at 120\. "):
        values = pt.observe(spinning(times), sensor).values
    assert np.array_equal(np.isnan(values).any(axis=-1), np.degrees(times) > 60.5)


def test_the_earth_covers_the_sun_behind_it():
    times = np.linspace(0.0, float(EARTH.period), 721)
    with pytest.warns(UserWarning, match=r"VectorSensor .* eclipsed at "):
        values = pt.observe(at_rest(times), VectorSensor(SUN, occulters=[SHADOW])).values
    r = place(times)
    to_sun = np.array([AU, 0, 0])
    behind = np.arccos(to_sun @ -r.T / np.linalg.norm(r, axis=-1) / AU) < np.arcsin(6378.137 / 7000.0)
    assert np.array_equal(np.isnan(values).any(axis=-1), behind)
    assert 200 < behind.sum() < 300


def test_a_point_is_covered_where_the_disc_of_a_small_sun_is():
    """`covers` is the limit of `sunlight` for a small Sun: neither has a rule of its own."""
    angles = np.linspace(0, 2 * np.pi, 5000)
    times = angles * float(EARTH.period) / (2 * np.pi)
    instant = pt.Instant(BODY, pt.Attitude.from_quaternion((1, 0, 0, 0)), Environment(times), (0, 0, 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        light = SHADOW.sunlight(instant, SUN, 1e-4)
    assert np.array_equal(SHADOW.covers(instant, SUN), np.asarray(light) < 0.5)


def test_coarse_sensors_follow_the_cosine_law_and_the_eclipse():
    normals = Rotation.from_rotvec([0.1, 0.5, -0.7]).apply(np.vstack([np.eye(3), -np.eye(3)]))
    gain = np.array([1.0, 2.0, 3.0, 1.0, 1.0, 0.5])
    times = np.linspace(0.0, float(EARTH.period), 4001)
    heads = CoarseSunSensors(SUN, normals, gain=gain, occulters=[SHADOW], sun_radius=6.957e5)
    motion = at_rest(times, TURNED)
    with pytest.warns(UserWarning, match=r"CoarseSunSensors .* eclipsed at "):
        values = pt.observe(motion, heads).values
    radiation = pt.forces.RadiationPressure(
        SUN, pt.forces.Facets([1.0], [(1, 0, 0)], [(0, 0, 0)]), [SHADOW], distance=AU, sun_radius=6.957e5
    )
    instant = pt.Instant(BODY, pt.Attitude.from_quaternion((1, 0, 0, 0)), Environment(times), (0, 0, 0))
    visible = np.asarray(radiation.sunlight(instant))
    cosines = np.maximum(normals @ TURNED.inv().apply([1.0, 0, 0]), 0.0)
    lit = ~np.isnan(values).any(axis=-1)
    assert np.array_equal(lit, visible >= 1e-12)
    assert np.allclose(values[lit], visible[lit, None] * gain * cosines, rtol=4e-15, atol=4 * EPS)
    assert np.any((visible > 0.01) & (visible < 0.99))
    assert np.count_nonzero(cosines) == 3
    assert heads.components == tuple(f"head {i}" for i in range(6))


def test_noise_turns_a_direction_and_leaves_its_length():
    readings = pt.observe(at_rest(np.linspace(0, 1, 4000)), VectorSensor((0, 0, 1), noise=1e-3))
    values = readings.simulated(seed=5).values
    assert np.allclose(np.linalg.norm(values, axis=-1), 1, rtol=0, atol=8 * EPS)
    # The turn about the direction itself changes nothing; four deviations of a standard deviation, 1 / sqrt(2 n).
    assert np.allclose(values[:, :2].std(axis=0) / 1e-3, 1, rtol=0, atol=4 / np.sqrt(8000))


def test_members_have_sensors_of_their_own():
    motion = spinning([0.0, 0.5], np.array([(0, 0, 1.0), (0.3, 0, 0.5)]))
    targets = np.array([(1.0, 0, 0), (0, 1.0, 1.0)])
    both = pt.observe(motion, VectorSensor(targets, field_of_view=np.array([3.0, 2.5]))).values
    heads = CoarseSunSensors(pt.orbits.FixedPosition(1.0, position=-targets), [(1, 0, 0), (0, 0, 1)], sun_radius=1e-3)
    currents = pt.observe(motion, heads).values
    for i in range(2):
        alone = pt.observe(motion.isel(member=i), VectorSensor(targets[i])).values
        assert np.allclose(both[i], alone, rtol=0, atol=4 * EPS)
        assert np.allclose(currents[i], np.maximum(alone[:, [0, 2]], 0), rtol=0, atol=4 * EPS)


def test_a_secondary_body_has_sensors_too():
    ball = pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8))
    pair = pt.TwoBodies(ball, ball, G=1.0)
    start = pair.state((4, 0, 0), (0, 1, 0), [(1, 0, 0, 0), TURNED], omega_body=[(0, 0, 0.1), (0, 0, 0)])
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [0.0])
    found = pt.observe(motion, VectorSensor((1, 0, 0)).on("secondary")).values
    assert np.allclose(found[0], TURNED.inv().apply((1, 0, 0)), rtol=0, atol=8 * EPS)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: VectorSensor("sun"),
            r"target must be an Orbit or a MagneticField, got str\.",
        ),
        (lambda: VectorSensor((0, 0, 0)), r"target must not be zero, got all components 0\. It is a direction\."),
        (lambda: VectorSensor((0, 1)), r"target must have shape \(3,\) .* got shape \(2,\)\."),
        (lambda: VectorSensor(SUN, boresight=(0, 0, 0)), r"boresight must not be zero, .*\."),
        (
            lambda: VectorSensor(SUN, field_of_view=60.0),
            r"field_of_view must be from 0 to pi, got 60\. Degrees: np\.radians\(value\)\.",
        ),
        (
            lambda: VectorSensor(SUN, field_of_view=-0.1),
            r"field_of_view must be from 0 to pi, got -0\.1\. Degrees: np\.radians\(value\)\.",
        ),
        (
            lambda: VectorSensor(FIELD, occulters=[SHADOW]),
            r"occulters must be none for a magnetic field, got 1\.",
        ),
        (
            lambda: CoarseSunSensors(SUN, [(1, 1, 0)]),
            r"normals must be a unit vector, got length 1\.414213562\. Divide by the length\.",
        ),
        (lambda: CoarseSunSensors(SUN, [(1, 0, 0)], gain=-1.0), r"gain must not be negative, got -1\.0\."),
        (lambda: CoarseSunSensors(SUN, [(1, 0, 0)], sun_radius=0.0), r"sun_radius must be positive, got 0\.0\."),
    ],
)
def test_wrong_arguments_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}$"):
        make()


def test_the_radius_of_the_sun_has_the_unit_of_its_orbit():
    """An orbit in km and the radius of the Sun in metres shade a body that is in full light."""
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])
    sun, planet = (pt.orbits.FixedPosition(1.0, position=place) for place in ((-1.5e8, 0, 0), (0, 42000.0, 0)))
    occulters = (pt.forces.Occulter(planet, 6378.0),)
    for radius in (6.957e8, 1.5e8):
        heads = pt.observables.CoarseSunSensors(sun, [(1, 0, 0)], occulters=occulters, sun_radius=radius)
        with pytest.raises(ValueError, match=r"sun_radius must be less than the distance .* and 1\.5e\+08\. Give"):
            pt.observe(motion, heads)
    heads = pt.observables.CoarseSunSensors(sun, [(1, 0, 0)], occulters=occulters, sun_radius=6.957e5)
    assert pt.observe(motion, heads).values[0].tolist() == [1.0]
