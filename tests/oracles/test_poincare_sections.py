"""Sections against closed curves, integrals and the published section of Hyperion."""

import numpy as np
import pytest

import poinsot as pt

N = np.sqrt(2.0 / 27)
"""The mean motion of the orbits."""
HYPERION = pt.Body.from_ratios(beta=0.47, gamma=0.26)  # (B - A)/C = 0.26


def orbit_of(eccentricity, inclination=0.4):
    return pt.KeplerOrbit(
        2.0,
        semimajor_axis=3.0,
        eccentricity=eccentricity,
        inclination=inclination,
        node=0.3,
        argument_of_periapsis=0.7,
        true_anomaly=0.5,
        epoch=2.0,
    )


def spin_orbit(eccentricity, body=HYPERION, inclination=0.4):
    return pt.System(body, pt.GravityGradient(orbit_of(eccentricity, inclination)))


def test_on_a_circle_the_points_lie_on_the_curves_of_a_pendulum():
    """theta'' = -(3/2) gamma sin 2(theta - f): (theta' - 1)^2 - (3/2) gamma cos 2 theta at each passage."""
    section = pt.analysis.spin_orbit_section(spin_orbit(0.0), np.linspace(0, 3, 17), N * np.linspace(0.2, 2.0, 17), 100)
    # On a circle the passage is of the same place of the orbit, where theta - f is the angle itself.
    energy = (section.y / N - 1) ** 2 - 1.5 * 0.26 * np.cos(2 * section.x)
    assert np.ptp(section.x) > 3
    assert np.max(np.abs(energy - energy[:, :1])) < 5e-13


@pytest.mark.parametrize("formulation", ["planar", "lie_poisson"])
def test_points_are_those_of_another_integration(formulation):
    from scipy.integrate import solve_ivp

    e, orbit = 0.1, orbit_of(0.1)
    section = pt.analysis.spin_orbit_section(
        spin_orbit(e), [0.4, 2.8], N * np.array([0.6, 2.9]), 5, formulation=formulation
    )

    def rates(E, x):  # by the eccentric anomaly, from the periapsis; n = 1
        r = 1 - e * np.cos(E)
        f = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(E / 2), np.sqrt(1 - e) * np.cos(E / 2))
        return r * x[1], -1.5 * 0.26 / r**2 * np.sin(2 * (x[0] - f))

    for k, start in enumerate([(0.4, 0.6), (2.8, 2.9)]):
        turns = 2 * np.pi * np.arange(6)
        found = solve_ivp(rates, (0, turns[-1]), start, t_eval=turns, rtol=1e-13, atol=1e-13, method="DOP853").y
        assert np.max(np.abs(np.exp(2j * section.x[k]) - np.exp(2j * found[0]))) < 1e-9
        assert np.max(np.abs(section.y[k] / N - found[1])) < 8e-11
    assert np.allclose(section.motion.times, 2.0 + (np.arange(6) - phase()) * orbit.period, rtol=1e-14, atol=0)


def phase():
    """The mean anomaly at the epoch, in turns."""
    E = 2 * np.arctan(np.sqrt(0.9 / 1.1) * np.tan(0.25))
    return (E - 0.1 * np.sin(E)) / (2 * np.pi)


def drifts(angle, rate, resonance, revolutions=600):
    """How far angle - resonance * (mean anomaly) moves, over many revolutions, radians."""
    orbit, looks = orbit_of(0.1, 0.0), np.arange(4 * revolutions + 1)
    start = pt.analysis.spin_orbit_section(
        spin_orbit(0.1, inclination=0.0), angle, N * np.asarray(rate), 1
    ).motion.initial
    motion = pt.propagate(
        spin_orbit(0.1, inclination=0.0),
        start,
        np.ravel(start.time)[0] + looks * orbit.period / 4,
        formulation="planar",
        tolerance=1e-12,
    )
    theta = 2 * np.arctan2(motion.quaternion[..., 3], motion.quaternion[..., 0])
    return np.ptp(np.unwrap(theta - resonance * looks * np.pi / 2, axis=-1), axis=-1)


@pytest.mark.parametrize(
    ("resonance", "angle", "rate"),
    [(0.5, np.pi / 2, 0.875), (1, 0.0, 0.575), (2, 0.0, 2.325), (2.25, np.pi / 2, 1.975)],
)
def test_hyperion_has_islands_at_these_states(resonance, angle, rate):
    """Wisdom, Peale and Mignard (1984), Fig. 2: regular libration about 1:2, 1:1, 2:1 and 9:4."""
    assert drifts([angle], [rate], resonance)[0] < np.pi


def test_hyperion_has_none_at_three_halves():
    """All starts near the 3:2 state, at either place, wander through the chaotic sea."""
    angles, rates = (x.ravel() for x in np.meshgrid([0.0, 0.2, np.pi / 2, 1.8], np.linspace(1.2, 1.8, 7)))
    assert np.all(drifts(angles, rates, 1.5) > 4 * np.pi)
    section = pt.analysis.spin_orbit_section(spin_orbit(0.1), 0.0, 1.5 * N, 3000, tolerance=1e-12)
    assert np.max(section.y) > 2.1 * N  # one sea, from below the 1:2 state to above the 2:1 state
    assert np.min(section.y) < 0.45 * N


def test_a_free_body_moves_along_its_curve_of_equal_energy():
    """(G^2 - L^2)(sin^2 l / A + cos^2 l / B) / 2 + L^2 / (2 C) = T (Deprit 1967)."""
    A, B, C = 1.0, 1.7, 2.3
    body = pt.Body((A, B, C))
    start = body.state(
        np.tile([0.5, 0.5, -0.5, 0.5], (9, 1)),
        angular_momentum_body=np.array([[0.3, 0.4, z] for z in np.linspace(-2, 2, 9)]),
    )
    section = pt.analysis.andoyer_section(pt.System(body), start, 120.0)
    G = np.linalg.norm(start.angular_momentum_body, axis=-1)[:, None]
    L, T = section.y * G, pt.System(body).kinetic_energy(start)[:, None]
    found = (G**2 - L**2) * (np.sin(section.x) ** 2 / A + np.cos(section.x) ** 2 / B) / 2 + L**2 / (2 * C)
    seen = np.isfinite(found)
    assert np.sum(seen) > 100
    assert np.max(np.abs((found - T)[seen])) < 4e-15


def test_a_lagrange_top_leaves_points_on_its_curve_of_nutation():
    """p_theta^2 / 2A + (p_phi - p_psi cos)^2 / (2 A sin^2) + p_psi^2 / 2C + m cos theta = E."""
    A, C, m = 1.0, 0.6, 0.8
    body = pt.Body((A, A, C))
    tilts = np.linspace(0.3, 1.5, 7)
    q = np.stack([np.cos(tilts / 2), np.sin(tilts / 2), 0 * tilts, 0 * tilts], axis=-1)
    start = body.state(q, omega_body=[0.1, 0.3, 2.5])
    system = pt.System(body, pt.UniformGravity(m, (0, 0, 1)))
    motion = pt.propagate(system, start, [200.0], events=[pt.events.AxisCrossing((1, 0, 0), (0, 0, 1), direction=1)])

    def nutation(points):
        angles, momenta = points.states.euler("313")
        return angles[:, 1], momenta[:, 1]

    section = pt.analysis.section(motion, nutation, 0, labels=("theta [rad]", "p theta"))
    (_, p) = start.euler("313")
    theta, E = section.x, system.energy(start)[:, None]
    p_phi, p_psi = p[:, :1], p[:, 2:]
    energy = section.y**2 / (2 * A) + (p_phi - p_psi * np.cos(theta)) ** 2 / (2 * A * np.sin(theta) ** 2)
    energy += p_psi**2 / (2 * C) + m * np.cos(theta)
    seen = np.isfinite(theta)
    assert np.min(seen.sum(axis=1)) > 20
    assert np.max(np.abs((energy - E)[seen])) < 3e-14


def test_kovalevskayas_integral_is_that_of_the_start_at_all_points():
    body, c = pt.Body((2.0, 2.0, 1.0)), 0.7
    system = pt.System(body, pt.UniformGravity(c, (1, 0, 0)))
    start = body.state(
        [[np.cos(t), np.sin(t) * 0.6, np.sin(t) * 0.8, 0] for t in np.linspace(0.1, 1.2, 5)], omega_body=[0.4, 0.2, 0.9]
    )
    motion = pt.propagate(system, start, [150.0], events=[pt.events.RateCrossing((0, 1, 0), direction=1)])

    def integral(states):
        """((p + i q)^2 - c (g1 + i g2))^2 for A = B = 2 C = 2, C = 1; g is up, along the body axes."""
        up = states.attitude.inv().apply([0.0, 0.0, 1.0])
        p, q = states.angular_momentum_body[:, 0] / 2, states.angular_momentum_body[:, 1] / 2
        z = (p + 1j * q) ** 2 - c * (up[:, 0] + 1j * up[:, 1])
        return np.abs(z) ** 2

    section = pt.analysis.section(motion, lambda points: (points.omega_body[:, 0], integral(points.states)), 0)
    seen = np.isfinite(section.y)
    assert np.min(seen.sum(axis=1)) > 10
    assert np.max(np.abs((section.y - integral(start)[:, None])[seen])) < 1e-14
