"""Chaos indicators of two bodies against their state transition, the divergence, and a map of Dimorphos's attitude."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.analysis import chaos

FIRST, SECOND = pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5)
PAIR = pt.TwoBodies(FIRST, SECOND, G=1.0)
GRAVITY = pt.forces.MutualGravity()
START = PAIR.state(
    (4.0, 1.0, 2.0),
    (-0.1, 0.6, 0.3),
    [(0.8, 0.0, 0.6, 0.0), (0.5, 0.5, -0.5, 0.5)],
    omega_body=[(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)],
)


def test_growth_is_that_of_the_state_transition():
    system, times = pt.System(PAIR, GRAVITY), [5.0, 40.0]
    found = pt.analysis.chaos_indicators(system, START, times, vectors=2)
    matrix = pt.analysis.state_transition(system, START, times).matrix
    moved = np.einsum("nij,j,j->ni", matrix, found.units, found.vectors[0]) / found.units
    # 18 entries of errors of 1e-13, the matrix divided by units of different sizes
    assert found.growth == pytest.approx(np.log(np.linalg.norm(moved, axis=-1)), abs=1e-12)
    assert found.units[9] / found.units[3] == pytest.approx(0.15 / 3.0, rel=1e-12, abs=0)


def test_exponents_are_those_of_the_state_transition():
    """Vectors made perpendicular now and then have the triangle of those that never were."""
    system, times = pt.System(PAIR, GRAVITY), np.array([5.0, 40.0])
    found = pt.analysis.lyapunov_spectrum(system, START, times)
    units = pt.analysis.chaos_indicators(system, START, [1.0]).units
    matrix = pt.analysis.state_transition(system, START, times).matrix * units / units[:, None]
    vectors = chaos._directions(18, 18)
    for i, t in enumerate(times):
        triangle = np.linalg.qr(matrix[i] @ vectors.T, mode="r")
        # the matrix has singular values down to 1e-3 of its largest entries, known to 1e-12
        assert found.exponents[i] * t == pytest.approx(np.log(np.abs(np.diag(triangle))), abs=1e-7)


def test_exponents_of_a_pair_add_up_to_the_divergence():
    for force, divergence in (
        ((), 0.0),
        ((pt.forces.LinearDamping(0.01).on("secondary"),), -0.01 * sum(1 / SECOND.moments)),
    ):
        found = pt.analysis.lyapunov_spectrum(pt.System(PAIR, GRAVITY, *force), START, [30.0])
        assert found.exponents.shape == (1, 18)
        assert np.sum(found.exponents) == pytest.approx(divergence, abs=1e-9)  # shears of 1e5 between two triangles


def test_the_attitude_of_dimorphos_is_chaotic_where_its_librations_are_in_resonance():
    """After the impact of DART it is regular where it is nearly round, and tumbles at a/b between 1.1 and 1.2."""
    ratios, size, mass = np.array([1.03, 1.07, 1.12, 1.17]), 75.5, 2400 * 4 / 3 * np.pi * 75.5**3
    axes = [size * (x * 1.6) ** (1 / 3) * np.array((1, 1 / x, 1 / 1.6)) for x in ratios]
    secondary = pt.Body([pt.Body.from_ellipsoid(mass, each).moments for each in axes], mass=mass)
    pair = pt.TwoBodies(pt.Body.from_ellipsoid(5.26e11, (394, 394, 290)), secondary)
    rate = np.sqrt(pair.G * (5.26e11 + mass) / 1189**3)
    tilted = [(1, 0, 0, 0), (np.cos(0.01), np.sin(0.01), 0, 0)]
    spins = [(0, 0, 2 * np.pi / (2.26 * 3600)), (0, 0, rate)]
    start = pair.state((1189, 0, 0), (0, 1189 * rate - 2.63e-3, 0), tilted, omega_body=spins)
    found = pt.analysis.chaos_indicators(pt.System(pair, GRAVITY), start, [60 * 86400.0])
    assert np.all(found.mean_megno[:2, 0] < 2.1)
    assert np.all(found.mean_megno[2:, 0] > 10)
