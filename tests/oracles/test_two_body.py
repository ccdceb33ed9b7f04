"""Orbits of every kind against 50-digit solutions, and attitudes along them against an independent integration."""

import mpmath
import numpy as np
import pytest

import poinsot as pt
from in_order import in_order
from oracles import two_body as oracle
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.precessing import PrecessingOrbit

EPS = np.finfo(float).eps
MU, EPOCH = 1.7, 0.25
ELLIPSES = (0.0, 1e-3, 0.3, 0.7, 0.9, 0.999, 1 - 1e-9, 1 - 1e-12)
ESCAPES = (1.0, 1 + 1e-12, 1 + 1e-6, 1.01, 1.5, 3.0, 100.0)


def floats(vector):
    return np.array([float(x) for x in vector])


def off(vector, exact):
    """The length of the error of a vector, from differences of many digits."""
    return float(mpmath.norm([mpmath.mpf(float(x)) - y for x, y in zip(vector, exact, strict=True)]))


def size(exact):
    return float(mpmath.norm(exact))


# ---------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("revolutions", [0, 1e-6, 0.4, -1e3, 1e6, -1e6])
@pytest.mark.parametrize("eccentricity", ELLIPSES)
def test_ellipse_at_any_time_is_right_to_rounding_of_the_reduced_phase(eccentricity, revolutions):
    random = np.random.default_rng(3)
    for anomaly in (0.0, *random.uniform(-3, 3, 4)):
        elements = (MU, 1.3, eccentricity, *random.uniform(-3, 3, 3), anomaly, EPOCH)
        orbit = in_order(pt.KeplerOrbit, *elements)
        time = EPOCH + revolutions * orbit.period * random.uniform(0.9, 1)
        with mpmath.workdps(oracle.DIGITS):
            exact = oracle.ellipse(elements, time)
            r, v = size(exact.position), size(exact.velocity)
            # One rounding of the time since the periapsis, now and at the epoch, moves the body by this.
            phase = abs(float(exact.since)) + abs(orbit.mean_anomaly_at_epoch / orbit.mean_motion)
            assert off(orbit.position_at(time), exact.position) < 16 * EPS * (r + v * phase)
            assert off(orbit.velocity_at(time), exact.velocity) < 16 * EPS * (v + MU / r**2 * phase)


def test_a_million_revolutions_of_a_satellite_move_it_by_less_than_a_tenth_of_a_micrometre():
    elements = (3.986004418e14, 6.8e6, 0.01, 0.9, 1.0, 0.3, 0.5, 7e8)
    orbit = in_order(pt.KeplerOrbit, *elements)
    time = 7e8 + 1e6 * orbit.period
    with mpmath.workdps(oracle.DIGITS):
        assert off(orbit.position_at(time), oracle.ellipse(elements, time).position) < 5e-8


@pytest.mark.parametrize("after", [0.0, 1e-8, -1e-3, 1.0, -10.0, 1e3, -1e7, 1e9])
@pytest.mark.parametrize("eccentricity", ESCAPES)
def test_parabola_and_hyperbola_are_right_to_rounding(eccentricity, after):
    random = np.random.default_rng(4)
    for since in (0.0, 1.0, -1e3, 1e6):
        elements = (MU, 1.3, eccentricity, *random.uniform(-3, 3, 3), since, EPOCH)
        orbit, time = in_order(EscapeOrbit, *elements), EPOCH + after * random.uniform(0.5, 1)
        with mpmath.workdps(oracle.DIGITS):
            exact = oracle.escape(elements, time)
            r, v = size(exact.position), size(exact.velocity)
            assert off(orbit.position_at(time), exact.position) < 16 * EPS * (r + v * abs(float(exact.since)))
            assert off(orbit.velocity_at(time), exact.velocity) < 8 * EPS * v
            assert abs(float(orbit.inverse_distance_at(time)) * r - 1) < 8 * EPS


def test_there_is_no_jump_from_ellipse_to_hyperbola():
    angles = (0.3, 1.0, -0.4)
    for time in (-7.0, -0.3, 1e-3, 2.0, 40.0):
        parabola = floats(in_order(EscapeOrbit, MU, 1.3, 1.0, *angles).position_at(time))
        for step in (2.0**-52, 2.0**-46, 2.0**-40, 2.0**-30):
            below = floats(in_order(pt.KeplerOrbit, MU, 1.3 / step, 1 - step, *angles).position_at(time))
            above = floats(in_order(EscapeOrbit, MU, 1.3, 1 + step, *angles).position_at(time))
            r = np.linalg.norm(parabola)
            middle = (below + above) / 2
            assert np.linalg.norm(middle - parabola) < r * (8 * EPS + (step * r) ** 2)
            assert np.linalg.norm(above - below) < r * (8 * EPS + 2 * step * r)


@pytest.mark.parametrize("revolutions", [0.3, -1e3, 1e6])
def test_precessing_ellipse_after_a_million_revolutions(revolutions):
    elements, rates = (MU, 1.3, 0.3, 0.4, 1.1, -0.7, 0.5, EPOCH), (-3e-3, 7e-3, 1e-3)
    orbit = in_order(PrecessingOrbit, in_order(pt.KeplerOrbit, *elements), *rates)
    time = EPOCH + revolutions * orbit.period
    with mpmath.workdps(oracle.DIGITS):
        mu, a, e, i, node, periapsis, f, epoch = map(mpmath.mpf, elements)
        E = 2 * mpmath.atan(mpmath.sqrt((1 - e) / (1 + e)) * mpmath.tan(f / 2))
        n, t = mpmath.sqrt(mu / a**3), mpmath.mpf(float(time)) - epoch
        M = E - e * mpmath.sin(E) + (n + mpmath.mpf(rates[2])) * t
        M -= 2 * mpmath.pi * mpmath.nint(M / (2 * mpmath.pi))
        angles = (i, node + mpmath.mpf(rates[0]) * t, periapsis + mpmath.mpf(rates[1]) * t)
        exact = oracle.two_body(mu, a * (1 - e), e, angles, M / n)
        assert off(orbit.position_at(time), exact.position) < 16 * EPS * size(exact.position)


@pytest.mark.parametrize("eccentricity", [0.3, 0.999])
def test_forty_digits_of_an_ellipse(eccentricity):
    elements = (MU, 1.3, eccentricity, 0.4, 1.1, -0.7, 0.5, EPOCH)
    with mpmath.workdps(40):
        orbit = in_order(pt.KeplerOrbit, *elements).with_numbers(map(mpmath.mpf, (*elements, 0.0)))
        found = orbit.position_at(mpmath.mpf(2.75))
    with mpmath.workdps(oracle.DIGITS):
        exact = oracle.ellipse(elements, 2.75).position
        assert max(abs(x - y) for x, y in zip(found, exact, strict=True)) < mpmath.mpf(10) ** -36


@pytest.mark.parametrize("eccentricity", [1.0, 1 + 1e-12, 1.5])
def test_forty_digits_of_an_escape(eccentricity):
    elements = (MU, 1.3, eccentricity, 0.4, 1.1, -0.7, -2.0, EPOCH)
    with mpmath.workdps(40):
        orbit = in_order(EscapeOrbit, *elements).with_numbers(map(mpmath.mpf, (*elements, 0.0)))
        found = orbit.position_at(mpmath.mpf(12.75))
    with mpmath.workdps(oracle.DIGITS):
        exact = oracle.escape(elements, 12.75).position
        assert max(abs(x - y) for x, y in zip(found, exact, strict=True)) < mpmath.mpf(10) ** -37


# ---------------------------------------------------------------------- the attitude along them

MOMENTS, OMEGA = (1.0, 1.2, 1.5), (0.1, 0.2, 0.3)
BODY = pt.Body(MOMENTS)
TIMES = np.linspace(-4.0, 9.0, 14)
START = BODY.state((0.6, 0.8, 0, 0), omega_body=OMEGA, time=TIMES[0])


def compare(motion_along, tolerance=2e-10, **path):
    reference, rates = oracle.attitude_along(
        MOMENTS, MU, START.attitude.as_matrix(), OMEGA, (TIMES[0], TIMES[-1]), TIMES, **path
    )
    motion = pt.propagate(pt.System(BODY, pt.GravityGradient(motion_along)), START, TIMES)
    assert np.max(np.abs(motion.attitude.as_matrix() - reference)) < tolerance
    assert np.max(np.abs(motion.omega_body - rates)) < tolerance
    free = pt.propagate(pt.System(BODY), START, TIMES)
    assert np.max(np.abs(motion.omega_body - free.omega_body)) > 0.05


@pytest.mark.parametrize("eccentricity", [1.0, 1 + 1e-12, 1.4, 6.0])
def test_gravity_gradient_along_a_parabola_and_hyperbolas(eccentricity):
    with mpmath.workdps(oracle.DIGITS):
        exact = oracle.two_body(
            *map(mpmath.mpf, (MU, 0.8, eccentricity)),
            angles=(0.4, 1.1, -0.7),
            since=mpmath.mpf(TIMES[0]) - mpmath.mpf(0.5),
        )
    orbit = EscapeOrbit(
        MU,
        periapsis_distance=0.8,
        eccentricity=eccentricity,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        time_since_periapsis=-0.5,
        epoch=0.0,
    )
    compare(orbit, orbit=(floats(exact.position), floats(exact.velocity)))


@pytest.mark.parametrize("rates", [(0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1), (0.3, -0.2, 0.1)])
def test_gravity_gradient_along_a_precessing_ellipse(rates):
    ellipse = pt.KeplerOrbit.from_elements(
        MU,
        semimajor_axis=1.3,
        eccentricity=0.3,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        mean_anomaly=0.9,
        epoch=EPOCH,
    )
    path = oracle.precessing_position(MU, 1.3, 0.3, 0.4, 1.1, -0.7, 0.9, EPOCH, rates)
    compare(in_order(PrecessingOrbit, ellipse, *rates), path=path)
