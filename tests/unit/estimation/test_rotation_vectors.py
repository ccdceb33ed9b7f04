"""Tests of rotation vectors, against mpmath and matrix exponentials."""

import mpmath as mp
import numpy as np
import pytest
from scipy.linalg import expm

from poinsot.estimation.process import noise_of_step, transition_of_step
from poinsot.estimation.rotation_vectors import cross_matrix, difference, jacobian, rotated, sine_defect_ratio, turn

SIZES = [0.0, 1e-12, 1e-5, 0.99e-4, 1.01e-4, 0.3, 3.0]
ROUNDING = 2.3e-16


def vector(size):
    return size * np.array([0.6, -0.48, 0.64])


@pytest.mark.parametrize("size", SIZES)
def test_rotations_are_exponentials(size):
    theta = vector(size)
    np.testing.assert_allclose(turn(theta), expm(-cross_matrix(theta)), rtol=0, atol=10 * ROUNDING)
    q = np.array([0.5, -0.5, 0.1, 0.7])
    q /= np.linalg.norm(q)
    np.testing.assert_allclose(difference(q, rotated(q, theta)), theta, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("size", SIZES[1:])
def test_the_defect_of_the_sine_has_all_digits(size):
    with mp.workdps(40):
        a = mp.mpf(size)
        assert float(sine_defect_ratio(np.array(size))) == pytest.approx(
            float((a - mp.sin(a)) / a**3), rel=4e-16, abs=0
        )


@pytest.mark.parametrize("size", SIZES)
def test_the_jacobian_is_the_mean_of_turns(size):
    nodes, weights = np.polynomial.legendre.leggauss(20)
    mean = sum(w / 2 * turn(vector(size) * (1 + x) / 2) for x, w in zip(nodes, weights, strict=True))
    np.testing.assert_allclose(jacobian(vector(size)), mean, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("size", SIZES)
def test_steps_of_a_gyro_are_matrix_exponentials(size):
    omega, duration = vector(size), 0.7
    F = np.zeros((6, 6))
    F[:3, :3], F[:3, 3:] = -cross_matrix(omega), -np.eye(3)
    np.testing.assert_allclose(transition_of_step(omega, duration), expm(F * duration), rtol=0, atol=20 * ROUNDING)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    density = np.diag(np.repeat((0.3**2, 0.2**2), 3))
    each = [expm(F * duration * (1 + x) / 2) for x in nodes]
    noise = sum(w * duration / 2 * E @ density @ E.T for w, E in zip(weights, each, strict=True))
    np.testing.assert_allclose(noise_of_step(omega, duration, 0.3, 0.2), noise, rtol=0, atol=20 * ROUNDING)
