"""Multipliers of matrices that are made with known ones, where they meet and apart."""

import numpy as np
import pytest

from poinsot.analysis.multipliers import Multipliers

FORM = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])


def symplectic(blocks, rng):
    """Return a matrix with 2 x 2 blocks of determinant 1, in canonical axes that are mixed."""
    matrix = np.zeros((6, 6))
    for i, block in enumerate(blocks):
        matrix[np.ix_([i, i + 3], [i, i + 3])] = block
    return mixed(matrix, rng)


def mixed(matrix, rng):
    """Return a symplectic matrix in other canonical axes."""
    a, b = rng.normal(size=(2, 3, 3)) / 2
    shear = np.block([[np.eye(3), a + a.T], [np.zeros((3, 3)), np.eye(3)]])
    other = np.block([[np.eye(3), np.zeros((3, 3))], [b + b.T, np.eye(3)]])
    mix = shear @ other
    assert np.allclose(mix.T @ FORM @ mix, FORM, rtol=0, atol=1e-12)
    return mix @ matrix @ np.linalg.inv(mix)


def turned(angle):
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


SHEAR = np.array([[1.0, 3.0], [0.0, 1.0]])
CASES = {
    "circle": ([turned(0.3), turned(1.1), turned(2.5)], (0, 0, 0), (0, 0)),
    "above 1": ([np.diag([1.5, 1 / 1.5]), turned(1.1), turned(2.5)], (1, 0, 0), (0, 0)),
    "below -1": ([np.diag([-1.5, -1 / 1.5]), np.diag([7.0, 1 / 7]), turned(2.5)], (1, 1, 0), (0, 0)),
    "at 1": ([SHEAR, np.diag([1.5, 1 / 1.5]), turned(2.5)], (1, 0, 0), (1, 0)),
    "two at 1": ([SHEAR, 2 * SHEAR - np.eye(2), np.diag([-3.0, -1 / 3])], (0, 1, 0), (2, 0)),
    "at -1": ([-SHEAR, turned(1.1), turned(2.5)], (0, 0, 0), (0, 1)),
    "equal": ([turned(1.1), turned(1.1), turned(2.5)], (0, 0, 0), (0, 0)),
}


@pytest.mark.parametrize("name", CASES)
def test_counts_of_known_matrices(name, rng):
    blocks, outside, at = CASES[name]
    for _ in range(20):
        found = Multipliers(symplectic(blocks, rng))
        assert found.paired
        assert tuple(found.outside) == outside
        assert (found.count_at(1), found.count_at(-1)) == at
        expected = np.sort_complex(np.concatenate([np.linalg.eigvals(block) for block in blocks]))
        np.testing.assert_allclose(np.sort_complex(np.round(found.values, 6)), np.round(expected, 6), rtol=0, atol=2e-6)


@pytest.mark.parametrize("growth", [0.0, 4e-4])
def test_two_slow_pairs_that_grow_together_are_outside(growth, rng):
    """A rotation by 0.006 in two coordinates, with growth in them and decay of their momenta."""
    slow = np.exp(growth) * turned(0.006)
    matrix = np.zeros((6, 6))
    matrix[:2, :2], matrix[3:5, 3:5] = slow, np.linalg.inv(slow).T
    matrix[np.ix_([2, 5], [2, 5])] = turned(0.16)
    for _ in range(20):
        found = Multipliers(mixed(matrix, rng))
        assert tuple(found.outside) == (0, 0, 1 if growth else 0)
        assert np.max(np.abs(found.values)) == pytest.approx(np.exp(growth), abs=1e-8)


def test_composite_pass_where_the_determinants_do(rng):
    """det(M - 1) is the product of 2 - s, det(M + 1) that of s + 2: with the sign of the distances from 1 and -1."""
    for _ in range(50):
        angles = rng.uniform(0, np.pi, 2)
        matrix = symplectic([turned(angles[0]), turned(angles[1]), np.diag([2.0, 0.5]) * rng.choice([-1, 1])], rng)
        found = Multipliers(matrix)
        for sign in (1, -1):
            determinant = np.linalg.det(matrix - sign * np.eye(6))
            assert abs(found.distance(sign, 0)) == pytest.approx(abs(determinant), rel=1e-6, abs=1e-9)


def test_matrix_that_is_not_symplectic_has_its_eigenvalues(rng):
    matrix = rng.normal(size=(6, 6))
    found = Multipliers(matrix)
    assert not found.paired
    values = np.linalg.eigvals(matrix)
    np.testing.assert_allclose(np.sort_complex(found.values), np.sort_complex(values), rtol=0, atol=1e-12)
    count = found.outside @ (1, 1, 2)
    assert count == np.sum(np.abs(values) > 1)
