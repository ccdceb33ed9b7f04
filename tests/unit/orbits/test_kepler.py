"""The two-body ellipse against an independent solution and against Newton's equation."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import poinsot as pt
from in_order import in_order

MU, A = 2.0, 1.5
ELEMENTS = {
    "ellipse": (0.3, 0.4, 1.1, -0.7, 2.0),
    "slender": (0.95, 1.2, -2.1, 0.7, 0.3),
    "circular": (0.0, 0.4, 1.1, 0.0, 2.0),
    "equatorial": (0.3, 0.0, 0.0, 0.5, -1.0),
    "circular_equatorial": (0.0, 0.0, 0.0, 0.0, 0.6),
    "polar": (0.3, np.pi / 2, 2.0, 0.5, 3.0),
    "retrograde": (0.3, 2.9, 0.2, 0.5, 1.0),
    "retrograde_equatorial": (0.3, np.pi, 0.0, 0.5, 1.0),
    "at_apoapsis": (0.3, 0.4, 1.1, -0.7, np.pi),
}
EPOCH = 0.25
ORBITS = {name: in_order(pt.KeplerOrbit, MU, A, *elements, EPOCH) for name, elements in ELEMENTS.items()}
PERIOD = 2 * np.pi * np.sqrt(A**3 / MU)
TIMES = EPOCH + PERIOD * np.array([-2.6, -0.5, -1e-9, 0.0, 0.1, 0.5, 0.75, 1.0, 13.3])


def array(vector):
    return np.array([float(x) for x in vector])


def independent_position_and_velocity(elements, time):
    """Position and velocity by a bracketing solution of Kepler's equation and the conic r = p / (1 + e cos f)."""
    e, inclination, node, periapsis, anomaly = elements
    half_turns = round(anomaly / (2 * np.pi))
    E0 = 2 * np.arctan(np.sqrt((1 - e) / (1 + e)) * np.tan((anomaly - 2 * np.pi * half_turns) / 2))
    M = np.remainder(E0 - e * np.sin(E0) + np.sqrt(MU / A**3) * (time - EPOCH), 2 * np.pi)
    E = brentq(lambda x: x - e * np.sin(x) - M, -1e-9, 2 * np.pi + 1e-9, xtol=1e-15, rtol=1e-15)
    f = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(E / 2), np.sqrt(1 - e) * np.cos(E / 2))
    p = A * (1 - e * e)
    r = p / (1 + e * np.cos(f)) * np.array([np.cos(f), np.sin(f), 0])
    v = np.sqrt(MU / p) * np.array([-np.sin(f), e + np.cos(f), 0])
    turn = Rotation.from_euler("ZXZ", [node, inclination, periapsis])
    return turn.apply(r), turn.apply(v)


@pytest.mark.parametrize("name", ELEMENTS)
def test_position_and_velocity_against_an_independent_solution(name):
    orbit = ORBITS[name]
    for time in TIMES:
        r, v = independent_position_and_velocity(ELEMENTS[name], time)
        fastest = np.sqrt(MU / A * (1 + ELEMENTS[name][0]) / (1 - ELEMENTS[name][0]))
        assert np.allclose(array(orbit.position_at(time)), r, rtol=0, atol=3e-14 * A * max(fastest, 1))
        assert np.allclose(array(orbit.velocity_at(time)), v, rtol=0, atol=3e-13 * fastest)


@pytest.mark.parametrize("span", [1.0, 100.0, 1e4])
def test_mean_anomaly_is_rounded_once(span):
    orbit, times = ORBITS["ellipse"], np.random.default_rng(3).uniform(-span, span, 300)
    with mp.workdps(40):
        rate, start, full = mp.sqrt(mpf(MU) / mpf(A) ** 3), mpf(float(orbit.mean_anomaly_at_epoch)), 4 * mp.pi
        for found, time in zip(orbit.phase_at(times).tolist(), times.tolist(), strict=True):
            turns = (found - start - rate * (mpf(time) - EPOCH)) / full
            missed = float(abs(turns - mp.nint(turns)) * full)
            assert missed <= 0.51 * np.spacing(max(abs(found), 0.25))  # half a unit, and what is rounded before it


@pytest.mark.parametrize("name", ["ellipse", "retrograde", "circular"])
def test_position_against_newtons_equation(name):
    orbit = ORBITS[name]
    solution = solve_ivp(
        lambda _, y: np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3]),
        (EPOCH, EPOCH + 1.7 * PERIOD),
        np.concatenate([array(orbit.position_at(EPOCH)), array(orbit.velocity_at(EPOCH))]),
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
    )
    assert np.allclose(array(orbit.position_at(solution.t[-1])), solution.y[:3, -1], rtol=0, atol=1e-9)
    assert np.allclose(array(orbit.velocity_at(solution.t[-1])), solution.y[3:, -1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ELEMENTS)
def test_true_anomaly_is_the_one_at_the_epoch(name):
    e, inclination, node, periapsis, anomaly = ELEMENTS[name]
    r = A * (1 - e * e) / (1 + e * np.cos(anomaly))
    expected = Rotation.from_euler("ZXZ", [node, inclination, periapsis + anomaly]).apply([r, 0, 0])
    assert np.allclose(array(ORBITS[name].position_at(EPOCH)), expected, rtol=0, atol=1e-14)


def test_distance_of_the_apses():
    orbit = pt.KeplerOrbit(
        MU, semimajor_axis=A, eccentricity=0.3, inclination=0.4, node=1.1, argument_of_periapsis=-0.7
    )
    assert np.linalg.norm(array(orbit.position_at(0.0))) == pytest.approx(A * 0.7, rel=1e-14, abs=0)
    assert np.linalg.norm(array(orbit.position_at(PERIOD / 2))) == pytest.approx(A * 1.3, rel=1e-14, abs=0)


@pytest.mark.parametrize("name", ELEMENTS)
def test_inverse_distance_is_that_of_the_position(name):
    for time in TIMES:
        distance = np.linalg.norm(array(ORBITS[name].position_at(time)))
        assert float(ORBITS[name].inverse_distance_at(time)) * distance == pytest.approx(1, rel=1e-12, abs=0)


def test_period_and_mean_motion():
    orbit = ORBITS["ellipse"]
    assert orbit.period == pytest.approx(PERIOD, rel=1e-15, abs=0)
    assert orbit.mean_motion == pytest.approx(np.sqrt(MU / A**3), rel=1e-15, abs=0)
    here, later = (array(orbit.position_at(t)) for t in (0.7, 0.7 + PERIOD))
    assert np.allclose(here, later, rtol=0, atol=1e-13)


def test_positions_at_many_times():
    times = np.linspace(0, 5, 7)
    x = np.stack(ORBITS["ellipse"].position_at(times))
    assert x.shape == (3, 7)
    assert np.allclose(x[:, 3], array(ORBITS["ellipse"].position_at(times[3])), rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ELEMENTS)
def test_normal_is_along_r_cross_v(name):
    orbit = ORBITS[name]
    h = np.cross(array(orbit.position_at(0.7)), array(orbit.velocity_at(0.7)))
    assert np.allclose(orbit.normal, h / np.linalg.norm(h), rtol=0, atol=1e-13)


def test_uniform_rotation_of_a_circle_alone():
    assert ORBITS["ellipse"].uniform_rotation is None
    assert np.allclose(
        ORBITS["circular"].uniform_rotation, np.sqrt(MU / A**3) * ORBITS["circular"].normal, rtol=1e-14, atol=1e-17
    )


def test_anomaly_and_epoch_are_zero_by_default():
    r, v = (
        array(getattr(pt.KeplerOrbit(MU, semimajor_axis=A, eccentricity=0.3), name)(0.0))
        for name in ("position_at", "velocity_at")
    )
    assert np.allclose(r, [0.7 * A, 0, 0], rtol=0, atol=1e-15)
    assert np.allclose(v, [0, np.sqrt(MU / A * 1.3 / 0.7), 0], rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- from vectors


@pytest.mark.parametrize("name", ELEMENTS)
def test_from_vectors_gives_the_same_motion(name):
    orbit = ORBITS[name]
    epoch = 1.75
    other = pt.KeplerOrbit.from_vectors(
        MU, position=array(orbit.position_at(epoch)), velocity=array(orbit.velocity_at(epoch)), epoch=epoch
    )
    stretch = 1 / (1 - ELEMENTS[name][0])
    for time in epoch + np.array([0.0, -1.0, 0.3, 4.0]):
        assert np.allclose(
            array(other.position_at(time)), array(orbit.position_at(time)), rtol=0, atol=1e-13 * stretch**1.5
        )
    assert other.epoch == epoch


@pytest.mark.parametrize("name", ["ellipse", "slender", "polar", "retrograde", "at_apoapsis"])
def test_from_vectors_gives_the_elements_back(name):
    orbit = ORBITS[name]
    other = pt.KeplerOrbit.from_vectors(
        MU, position=array(orbit.position_at(EPOCH)), velocity=array(orbit.velocity_at(EPOCH)), epoch=EPOCH
    )
    stretch = 1 / (1 - ELEMENTS[name][0])
    assert other.semimajor_axis == pytest.approx(A, rel=1e-14 * stretch, abs=0)
    assert other.eccentricity == pytest.approx(ELEMENTS[name][0], abs=1e-14 * stretch)
    found = np.array([other.inclination, other.node, other.argument_of_periapsis, other.true_anomaly])
    difference = np.remainder(found - ELEMENTS[name][1:] + np.pi, 2 * np.pi) - np.pi
    assert np.max(np.abs(difference)) < 1e-13 * stretch


@pytest.mark.parametrize("direction", [1, -1])
def test_from_vectors_of_an_exact_circle_in_the_equator(direction):
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=(1, 0, 0), velocity=(0, direction, 0))
    assert orbit.eccentricity == 0
    assert (orbit.node, orbit.argument_of_periapsis) == (0, 0)
    assert orbit.inclination == (0 if direction == 1 else np.pi)
    assert orbit.semimajor_axis == 1
    assert np.allclose(orbit.normal, [0, 0, direction], rtol=0, atol=4e-16)


def test_from_vectors_of_an_inclined_circle_has_its_periapsis_at_the_node():
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=(0, 1, 0), velocity=(-0.6, 0, 0.8))
    assert orbit.eccentricity == pytest.approx(0, abs=1e-15)
    assert orbit.argument_of_periapsis == pytest.approx(0, abs=1e-15) or orbit.eccentricity > 0
    assert np.allclose(array(orbit.position_at(0.0)), [0, 1, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("tilt", [1e-300, 1e-15, 1e-8, 1e-3])
def test_from_vectors_next_to_the_equator(tilt):
    r, v = np.array([0.6, 0.8, 0.0]), np.array([-0.7, 0.5, tilt])
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=r, velocity=v)
    assert np.allclose(array(orbit.position_at(0.0)), r, rtol=0, atol=1e-15)
    assert np.allclose(array(orbit.velocity_at(0.0)), v, rtol=0, atol=1e-15)


@pytest.mark.parametrize("excess", [1e-15, 1e-12, 1e-8, 1e-4])
def test_from_vectors_next_to_a_circle(excess):
    r, v = np.array([0.6, 0.8, 0.0]), (1 + excess) * np.array([-0.8, 0.6, 0.0])
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=r, velocity=v)
    assert orbit.eccentricity == pytest.approx(2 * excess, rel=1e-3, abs=8e-16)
    assert np.allclose(array(orbit.position_at(0.0)), r, rtol=0, atol=2e-15)
    assert np.allclose(array(orbit.velocity_at(0.0)), v, rtol=0, atol=2e-15)


def test_from_vectors_with_the_numbers_of_the_earth():
    r, v = np.array([7e6, 1e6, -2e6]), np.array([1e3, 7e3, 2e3])
    orbit = pt.KeplerOrbit.from_vectors(3.986004418e14, position=r, velocity=v, epoch=1e9)
    assert np.allclose(array(orbit.position_at(1e9)), r, rtol=0, atol=1e-8)
    assert np.allclose(array(orbit.velocity_at(1e9)), v, rtol=0, atol=1e-11)
