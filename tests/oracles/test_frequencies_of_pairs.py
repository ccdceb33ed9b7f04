"""Librations of a synchronous secondary, read from motions, against the linear equations of the plane."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt

MOSHUP = (2.353e12, (708.5, 680.5, 591.5)), (0.135e12, (297.5, 225.0, 171.5))


def moments_of(mass, axes):
    squares = np.square(axes)
    return mass / 5 * (np.sum(squares) - squares)


def linear(G, primary, secondary, distance):
    """Return mean motion and frequencies of small motions of distance and libration in the plane.

    The primary is round about the normal: V(r, d) = -G m1 m2 / r - G (m1 (tr I2 - 3 I(d)) + m2 K) / (2 r^3) with
    I(d) = A cos^2 d + B sin^2 d, and the angular momentum mu r^2 n + C (n + d') is constant.
    """
    (m1, I1), (m2, (A, B, C)) = primary, secondary
    mu, K = m1 * m2 / (m1 + m2), np.sum(I1) - 3 * I1[0]
    r, S = distance, m1 * (B + C - 2 * A) + m2 * K
    first = G * m1 * m2 / r**2 + 1.5 * G * S / r**4
    n = np.sqrt(first / (mu * r))
    rr = -2 * G * m1 * m2 / r**3 - 6 * G * S / r**5
    dd = 3 * G * m1 * (B - A) / r**3
    # mu x'' = (mu n^2 - V_rr) x + 2 mu r n f', mu (r^2 f'' + 2 r n x') = dd d, C (f'' + d'') = -dd d, f of the orbit
    M, D, K = np.diag([mu, mu * r**2, C]).astype(float), np.zeros((3, 3)), np.zeros((3, 3))
    M[2, 1] = C
    D[0, 1], D[1, 0] = -2 * mu * r * n, 2 * mu * r * n
    K[0, 0], K[1, 2], K[2, 2] = rr - mu * n**2, -dd, dd
    system = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    values = np.linalg.eigvals(system).imag
    return n, np.sort(values[values > 1e-3 * n])


def measured(G, primary, secondary, distance, orbits=60):
    """Return the frequencies of distance and of the angle to the line of centres, after a small push of both."""
    (m1, I1), (m2, I2) = primary, secondary
    n, _ = linear(G, primary, secondary, distance)
    pair = pt.TwoBodies(pt.Body(I1, mass=m1), pt.Body(I2, mass=m2), G=G)
    facing = (np.cos(1e-5), 0, 0, np.sin(1e-5))
    start = pair.state(
        (distance * (1 + 1e-5), 0, 0),
        (0, n * distance / (1 + 1e-5), 0),
        [(1, 0, 0, 0), facing],
        omega_body=[(0, 0, 3 * n), (0, 0, n)],
    )
    times = np.linspace(0, orbits * 2 * np.pi / n, 40 * orbits)
    motion: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, times)
    seen = motion.secondary.attitude.inv().apply(motion.position)
    found = pt.analysis.frequencies(-np.arctan2(seen[:, 1], seen[:, 0]), times, 2)
    return np.sort(found.frequencies) / n


def test_librations_of_the_moonlet_of_moshup():
    """The primary, as round as its equator is on the mean: 2% of its moments would move the libration by 1e-4."""
    (m1, (a, b, c)), (m2, axes) = MOSHUP
    round_one = np.sqrt((a * a + b * b) / 2)
    primary, secondary = (m1, moments_of(m1, (round_one, round_one, c))), (m2, moments_of(m2, axes))
    n, exact = linear(6.6743e-11, primary, secondary, 2548.0)
    found = measured(6.6743e-11, primary, secondary, 2548.0)
    assert found == pytest.approx(exact / n, rel=1e-8, abs=0)  # the square of the amplitude, 2e-5, times ten
    assert 2 * np.pi / n / 3600 == pytest.approx(17.4, abs=0.2)  # Ostro et al. 2006


@pytest.mark.parametrize(("a_to_b", "ratio"), [(np.sqrt(2), 1.0), (np.sqrt(13 / 11), 0.5)])
def test_librations_in_resonance_with_the_orbit(a_to_b, ratio):
    """3 (a^2 - b^2)/(a^2 + b^2) is 1 at a/b = sqrt 2 and 1/4 at 1.087, with a heavy round primary far away."""
    primary, secondary = (1.0, (0.4, 0.4, 0.4)), (1e-6, moments_of(1e-6, (a_to_b, 1.0, 0.8)))
    n, exact = linear(1.0, primary, secondary, 100.0)
    assert np.min(np.abs(exact / n - ratio)) < 0.02  # repelled by that of the distance where they meet
    assert np.min(np.abs(measured(1.0, primary, secondary, 100.0) - ratio)) < 0.02
