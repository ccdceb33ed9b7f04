"""Frequencies read off motions, against Jacobi's and the pendulum's periods and the linear theory of satellites."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import poinsot as pt

CIRCLE = pt.KeplerOrbit(1.0, 1.0, 0.0, 0.0, 0.0, 0.0)
PHOBOS = (0.3615, 0.4265, 0.5024)


def rates_of_free_rotation(moments, momentum):
    """The mean rate of the third axis about the momentum and the rate of the momentum in the body, I1 < I2 < I3."""
    I1, I2, I3 = moments
    G2, T2 = np.dot(momentum, momentum), np.dot(momentum, np.divide(momentum, moments))
    across, along = T2 * I3 - G2, G2 - T2 * I1  # short-axis mode
    k2 = (I2 - I1) * across / ((I3 - I2) * along)
    rate = np.sqrt((I3 - I2) * along / (I1 * I2 * I3))
    sn, cn, _, _ = ellipj(4 * ellipk(k2) * np.arange(400) / 400, k2)
    g1, g2 = np.sqrt(I1 * across / (I3 - I1)) * cn, np.sqrt(I2 * across / (I3 - I2)) * sn
    return np.sqrt(G2) * np.mean((g1**2 / I1 + g2**2 / I2) / (g1**2 + g2**2)), 2 * np.pi * rate / (4 * ellipk(k2))


@pytest.mark.parametrize("momentum", [(0.3, 0.5, 2.0), (0.5, 1.2, 1.5), (0.1, 2.0, 0.9)])
@pytest.mark.parametrize("moved", [pt.free_motion, lambda body, *rest: pt.propagate(pt.System(body), *rest)])
def test_free_rotation(momentum, moved):
    body = pt.Body((2.0, 2.5, 3.5))
    upright = Rotation.align_vectors([[0, 0, 1.0]], [momentum])[0]
    times = np.linspace(0, 900, 2**14)
    motion = moved(body, body.state(upright, angular_momentum_body=momentum), times)
    q, g = motion.quaternion, motion.angular_momentum_body
    precession, rotation = rates_of_free_rotation(body.moments, momentum)
    for signal, expected in (
        (q[:, 0] + 1j * q[:, 3], (precession - rotation) / 2),
        (q[:, 1] + 1j * q[:, 2], (precession + rotation) / 2),
        (g[:, 0] + 1j * g[:, 1], rotation),
    ):
        found = pt.frequencies(signal, times, count=3)
        assert found.frequencies[0] == pytest.approx(expected, rel=2e-13, abs=0)
    known = pt.FreeRotation(body, motion.initial)
    assert 2 * np.pi / known.precession_period == pytest.approx(precession, rel=1e-14)
    assert 2 * np.pi / known.rotation_period == pytest.approx(rotation, rel=1e-14)


@pytest.mark.parametrize("amplitude", [1e-4, 1e-2, 0.5])
def test_libration_of_phobos_on_a_circle(amplitude):
    phobos = pt.Body(PHOBOS)
    system = pt.System(phobos, pt.GravityGradient(CIRCLE))
    start = phobos.state((np.cos(amplitude / 2), 0, 0, np.sin(amplitude / 2)), omega_body=(0, 0, 1.0))
    times = np.linspace(0, 400, 4096)
    q = pt.propagate(system, start, times).relative_to(CIRCLE.frame).quaternion
    found = pt.frequencies(2 * np.arctan2(q[:, 3], q[:, 0]), times, count=6)
    pendulum = np.pi / (2 * ellipk(np.sin(amplitude) ** 2))  # of its small oscillations
    exact = np.sqrt(3 * (PHOBOS[1] - PHOBOS[0]) / PHOBOS[2]) * pendulum
    assert found.frequencies[0] == pytest.approx(exact, rel=1e-17 / amplitude + 2e-15, abs=0)


def test_librations_of_a_satellite_are_those_of_linear_theory():
    radial, along, normal = PHOBOS
    k_roll, k_yaw = (normal - radial) / along, (normal - along) / radial
    fast, slow = np.sqrt(-np.roots([1, 1 + 3 * k_roll + k_roll * k_yaw, 4 * k_roll * k_yaw]))
    satellite = pt.Body(PHOBOS)
    system = pt.System(satellite, pt.GravityGradient(CIRCLE))
    tilts = np.array([1e-4, -1e-4, 2e-4, -2e-4])
    start = satellite.state(Rotation.from_rotvec(tilts[:, None] * np.ones(3)), omega_space=(0, 0, 1.0))
    times = np.linspace(0, 800, 4096)
    q = pt.propagate(system, start, times, progress=False).relative_to(CIRCLE.frame).quaternion
    found = pt.frequencies(np.moveaxis(q[..., 1:], -1, 0), times, count=10).frequencies  # axis, tilt, line
    smallest = found.reshape(3, 2, 2, -1).mean(axis=2)
    smallest = (4 * smallest[:, 0] - smallest[:, 1]) / 3  # they grow with the square of the tilt, here in both senses
    np.testing.assert_allclose(np.sort(smallest[0, :2]), np.sort([slow, fast]), rtol=1e-12)
    np.testing.assert_allclose(np.sort(smallest[1, :2]), np.sort([slow, fast]), rtol=1e-12)
    pitch = np.sqrt(3 * (along - radial) / normal)
    assert smallest[2, 0] == pytest.approx(pitch, rel=1e-12)
    resting = next(e for e in pt.equilibria(system, CIRCLE.frame) if e.stability == "lyapunov")
    np.testing.assert_allclose(resting.frequencies, np.sort([slow, pitch, fast]), rtol=1e-13)


def test_chaos_of_hyperion_drifts_and_its_regular_motions_do_not():
    ellipse = pt.KeplerOrbit(1.0, 1.0, 0.123233, 0.0, 0.0, 0.0)
    hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)
    rates = np.array([0.3, 3.2, 1.0, 1.5, 2.0, 2.3])  # at the periapsis; the first librates, the second circulates
    spins = rates[:, None] * (0, 0, 1.0)
    start = hyperion.state(np.broadcast_to((1.0, 0, 0, 0), (6, 4)), omega_space=spins)
    times = np.arange(2048) * ellipse.period / 16
    motion = pt.propagate(pt.System(hyperion, pt.GravityGradient(ellipse)), start, times, progress=False)
    turning = (motion.quaternion[..., 0] + 1j * motion.quaternion[..., 3]) ** 2  # exp(i theta)
    drift = np.abs(pt.diffusion(turning, times)[:, 0])
    assert np.all(drift[:2] < 1e-7)
    assert np.all(drift[2:] > 1e-3)
