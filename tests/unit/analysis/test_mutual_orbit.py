"""Periods, apsides, elements and axes of the orbit of two bodies, against Kepler's ellipse and epicycles."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt

GRAVITY = pt.forces.MutualGravity()
BALLS = pt.TwoBodies(pt.Body((0.4, 0.4, 0.4), mass=0.9), pt.Body((0.1, 0.1, 0.1), mass=0.1), G=1.0)
DISC = pt.Body((0.3, 0.3, 0.4), mass=1.0)
SPECK = pt.Body((1e-9, 1e-9, 1e-9), mass=1e-6)
SAME, AT_REST = [(1.0, 0.0, 0.0, 0.0)] * 2, [(0.0, 0.0, 0.0)] * 2


def ellipse(e, steps, revolutions=30, **kwargs):
    """Spheres on an ellipse with a period of 2 pi, out of the axes, at steps that fit no revolution."""
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=e, inclination=2.0, node=0.3, true_anomaly=1.0)
    start = BALLS.state_on(orbit, SAME, omega_body=AT_REST)
    times = np.arange(0, revolutions * 2 * np.pi, 2 * np.pi / (steps + 0.3))
    motion: Any = pt.propagate(pt.System(BALLS, GRAVITY), start, times, **kwargs)
    return motion, orbit


@pytest.mark.parametrize(
    ("e", "steps", "error"), [(0.1, 12, 1.2e-7), (0.1, 24, 2e-9), (0.1, 48, 3e-11), (0.3, 48, 3e-10)]
)
def test_periods_between_samples_are_off_by_the_sixth_power_of_the_step(e, steps, error):
    found = pt.analysis.revolutions(ellipse(e, steps)[0])
    assert found.periods.shape == (29,)
    assert error / 5 < np.max(np.abs(found.periods / (2 * np.pi) - 1)) < error
    assert found.variation < 2 * error * 2 * np.pi
    # a longitude that oscillates by 2 e tilts a straight line by about 12 e over the square of the angle
    assert abs(found.mean_period / (2 * np.pi) - 1) < 12 * e / (30 * 2 * np.pi) ** 2 * 2 * np.pi


@pytest.mark.parametrize("e", [0.0, 0.1, 0.3])
def test_periods_of_dense_output_are_accurate_to_rounding(e):
    motion, _ = ellipse(e, 40, dense=True)
    found = pt.analysis.revolutions(motion)
    assert found.times[0] == motion.times[0]
    # a time near 200 has roundings of 3e-14; the worst of 20 shaken runs is 6e-13
    assert np.max(np.abs(found.periods - 2 * np.pi)) < 2e-12


def test_revolutions_of_an_ensemble_are_those_of_its_members():
    starts = BALLS.state(np.array([[1.0, 0, 0], [1.2, 0, 0]]), (0, 1, 0.1), SAME, omega_body=AT_REST)
    motions: Any = pt.propagate(pt.System(BALLS, GRAVITY), starts, np.linspace(0, 40, 401))
    found = pt.analysis.revolutions(motions)
    assert found.times.shape[0] == 2
    for i in range(2):
        alone = pt.analysis.revolutions(motions[i])
        assert np.array_equal(found.times[i][: alone.times.size], alone.times)
        assert np.all(np.isnan(found.times[i][alone.times.size :]))
        assert found.mean_period[i] == alone.mean_period
        a = 1 / (2 / (1.0, 1.2)[i] - 1.01)
        assert np.allclose(alone.periods, 2 * np.pi * a**1.5, rtol=1e-9, atol=0)
    assert np.array_equal(found.variation, np.nanmax(found.periods, axis=1) - np.nanmin(found.periods, axis=1))


def test_backward_motions_and_those_too_short_or_too_coarse():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
    start, system = BALLS.state_on(orbit, SAME, omega_body=AT_REST), pt.System(BALLS, GRAVITY)
    back: Any = pt.propagate(system, start, np.linspace(0, -40, 401))
    assert np.allclose(pt.analysis.revolutions(back).periods, -2 * np.pi, rtol=1e-9, atol=0)
    short: Any = pt.propagate(system, start, np.linspace(0, 3, 31))
    found = pt.analysis.revolutions(short)
    assert found.periods.size == 0
    assert np.isnan(found.variation)
    coarse: Any = pt.propagate(system, start, np.linspace(0, 40, 41))
    with pytest.raises(ValueError, match=r"times must be at least eight in each revolution, got a step of 1\.2"):
        pt.analysis.revolutions(coarse)


@pytest.mark.parametrize("push", [1e-6, 1e-4])
@pytest.mark.parametrize("distance", [4.0, 10.0])
def test_apsides_turn_with_orbital_less_epicyclic_frequency(push, distance):
    """U / mu = -M/r - k/r^3 across the axis of a spheroid: n^2 = U'/r and kappa^2 = U'' + 3 n^2."""
    pair = pt.TwoBodies(DISC, SPECK, G=1.0)
    k, M, r = 0.5 * (0.4 - 0.3) * (1 + 1e-6), 1 + 1e-6, distance
    n, kappa = np.sqrt(M / r**3 + 3 * k / r**5), np.sqrt(M / r**3 - 3 * k / r**5)
    start = pair.kick(pair.synchronous(distance=r, primary_rate=0.5), (push, 0, 0), frame="orbit")
    motion: Any = pt.propagate(pt.System(pair, GRAVITY), start, np.linspace(0, 40 * 2 * np.pi / n, 1201))
    rate = pt.analysis.apsidal_precession(motion)
    e = push / (n * r)
    # the rate changes with the square of the eccentricity, here by a few e^2; 1e-9 of the mean motion is the fit's
    assert abs(rate / (n - kappa) - 1) < 5 * e**2 + 1e-9 * n / (n - kappa)


def test_precession_of_ensembles_and_of_a_circle():
    pair = pt.TwoBodies(DISC, SPECK, G=1.0)
    circle = pair.synchronous(distance=5.0, primary_rate=0.5)
    starts = pair.kick(circle, np.array([[1e-3, 0, 0], [0, 2e-3, 0], [0, 0, 0]]), frame="orbit")
    motions: Any = pt.propagate(pt.System(pair, GRAVITY), starts, np.linspace(0, 2000, 801))
    rates = pt.analysis.apsidal_precession(motions)
    assert rates.shape == (3,)
    assert np.isnan(rates[2])
    assert [pt.analysis.apsidal_precession(motions[i]) for i in range(2)] == rates[:2].tolist()


def test_elements_are_those_of_the_ellipse_at_all_times():
    motion, orbit = ellipse(0.3, 20, revolutions=2)
    found = motion.elements
    for name in ("semimajor_axis", "eccentricity", "inclination", "node"):
        assert np.allclose(getattr(found, name), float(getattr(orbit, name)), rtol=0, atol=1e-13), name
    assert np.allclose(np.exp(1j * found.argument_of_periapsis), 1, rtol=0, atol=1e-12)
    assert np.allclose(found.longitude_of_periapsis, 0.3, rtol=0, atol=1e-12)
    assert np.allclose(found.period, 2 * np.pi, rtol=1e-13, atol=0)
    assert found.true_anomaly[0] == pytest.approx(1.0, abs=7e-15)  # three times the worst of 21 shaken starts


def test_elements_of_members_have_their_own_masses():
    pair = pt.TwoBodies(DISC, pt.Body((0.1, 0.1, 0.1), mass=[0.1, 0.2, 0.3]), G=1.0)
    start = pair.state((4, 0, 0), (0, 0.6, 0), SAME, omega_body=AT_REST)
    motions: Any = pt.propagate(pt.System(pair, GRAVITY), start, np.linspace(0, 3, 4))
    assert np.allclose(
        motions.elements.semimajor_axis[:, 0], 1 / (0.5 - 0.36 / np.array([1.1, 1.2, 1.3])), rtol=1e-14, atol=0
    )
    for i in range(3):
        assert np.array_equal(motions[i].elements.eccentricity, motions.elements.eccentricity[i])


# ---------------------------------------------------------------------- bodies of any shape

LONG = pt.Body.from_ellipsoid(0.02, (0.3, 0.25, 0.2))
PAIR = pt.TwoBodies(pt.Body.from_ellipsoid(1.0, (1.1, 1.0, 0.8)), LONG, G=1.0)
TILTED = PAIR.state((4, 0, 0), (0, 0.5, 0.1), [(1, 0, 0, 0), (0.8, 0.6, 0, 0)], omega_body=[(0, 0.1, 2), (0, 0.1, 0)])


def test_periods_of_tilted_bodies_between_samples_are_those_of_dense_output():
    """The secondary goes against the primary's spin, which has most of the angular momentum."""
    start = PAIR.state((4, 0, 0), (0, -0.5, 0.1), [(1, 0, 0, 0), (0.8, 0.6, 0, 0)], omega_body=[(0, 0.1, 2), (0, 0, 0)])
    times = np.linspace(0, 300, 2801)
    system = pt.System(PAIR, GRAVITY)
    sampled, dense = (pt.analysis.revolutions(pt.propagate(system, start, times, dense=way)) for way in (False, True))
    assert start.angular_momentum_space[2] > 0.5
    assert len(dense.times) == 6
    assert dense.variation > 0.2
    # 14 samples in each period of the primary's pull, a torque of 1e-3 of the force: 1e-3 times 6e-8
    assert np.allclose(sampled.times, dense.times, rtol=0, atol=1e-10)


def matrices(q):
    return pt.State(q, np.zeros_like(q)).attitude.as_matrix()


def test_the_axes_are_those_of_place_and_velocity_and_their_rate_is_their_derivative():
    motion: Any = pt.propagate(pt.System(PAIR, GRAVITY), TILTED, np.linspace(0, 30, 7), dense=True)
    frame, h = motion.orbit_frame, 1e-4
    here = matrices(frame.quaternion(motion.times))
    normal = np.cross(motion.position, motion.velocity)
    assert np.allclose(here[:, :, 0], motion.position / motion.distance[:, None], rtol=0, atol=1e-15)
    assert np.allclose(here[:, :, 2], normal / np.linalg.norm(normal, axis=1)[:, None], rtol=0, atol=1e-15)
    inner = motion.times[1:-1]
    before, after = (matrices(frame.quaternion(inner + step)) for step in (-h, h))
    spin = (after - before) / (2 * h) @ np.swapaxes(here[1:-1], 1, 2)
    omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    # differences leave the third derivative, h^2/6 times the cube of a rate of 0.13, and roundings over h
    assert np.allclose(frame.omega_space(inner), omega, rtol=0, atol=1e-10)
    assert np.max(np.abs(frame.omega_space(inner)[:, 0])) > 1e-5  # the plane turns


def test_what_was_named_relative_to_the_orbit_is_read_relative_to_it():
    turn, rate = np.array([0.9, 0.1, -0.3, np.sqrt(0.09)]), np.array([0.01, 0.02, -0.03])
    turn /= np.linalg.norm(turn)
    start = BALLS.state((1, 0.2, 0), (0, 1, 0.1), [turn] * 2, omega_body=[rate] * 2, frame="orbit")
    motion: Any = pt.propagate(pt.System(BALLS, GRAVITY), start, [0.0, 1.0])
    for body in (motion.primary, motion.secondary):
        relative = body.relative_to(motion.orbit_frame)
        assert abs(abs(relative.quaternion[0] @ turn) - 1) < 1e-15
        assert np.allclose(relative.omega_body[0], rate, rtol=0, atol=1e-15)


def test_other_times_need_dense_output():
    motion: Any = pt.propagate(pt.System(PAIR, GRAVITY), TILTED, np.linspace(0, 3, 7))
    with pytest.raises(ValueError, match="must have dense output"):
        motion.orbit_frame.quaternion(np.array([0.1]))
