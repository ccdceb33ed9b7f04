"""Euler angles of the 12 sequences and their momenta."""

import itertools

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import rotation_matrix

SEQUENCES = [a + b + c for a, b, c in itertools.product("123", repeat=3) if a != b and b != c]
SYMMETRIC = [s for s in SEQUENCES if s[0] == s[2]]


def scipys(sequence):
    return sequence.translate(str.maketrans("123", "XYZ"))


def angles_inside(sequence, rng, count=40):
    low, high = (0.1, np.pi - 0.1) if sequence in SYMMETRIC else (0.1 - np.pi / 2, np.pi / 2 - 0.1)
    return np.stack(
        [rng.uniform(0, 4 * np.pi, count), rng.uniform(low, high, count), rng.uniform(0, 2 * np.pi, count)], axis=-1
    )


def test_there_are_twelve_sequences():
    assert sorted(euler.SEQUENCES) == sorted(SEQUENCES)
    assert len(SEQUENCES) == 12


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_quaternion_is_scipys_intrinsic_rotation(sequence, rng):
    angles = angles_inside(sequence, rng)
    expected = Rotation.from_euler(scipys(sequence), angles).as_matrix()
    found = rotation_matrix(euler.quaternion_from_angles(angles, sequence))
    assert np.allclose(found, expected, rtol=0, atol=3e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_quaternion_changes_sign_with_a_full_turn_of_either_outer_angle(sequence):
    q = euler.quaternion_from_angles((0.5, 0.6, 0.7), sequence)
    for turned in ((0.5 + 2 * np.pi, 0.6, 0.7), (0.5, 0.6, 0.7 + 2 * np.pi)):
        assert np.allclose(euler.quaternion_from_angles(turned, sequence), -q, rtol=0, atol=1e-15)


def test_quaternion_of_sequence_313_is_the_papers_formula():
    phi, theta, psi = 0.4, 1.1, -0.7
    expected = [
        np.cos(theta / 2) * np.cos((phi + psi) / 2),
        np.sin(theta / 2) * np.cos((phi - psi) / 2),
        np.sin(theta / 2) * np.sin((phi - psi) / 2),
        np.cos(theta / 2) * np.sin((phi + psi) / 2),
    ]
    assert np.allclose(euler.quaternion_from_angles((phi, theta, psi)), expected, rtol=0, atol=4e-16)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angles_inside_their_ranges_come_back(sequence, rng):
    angles = angles_inside(sequence, rng)
    back = euler.angles_from_quaternion(euler.quaternion_from_angles(angles, sequence), sequence)
    assert np.allclose(back, angles, rtol=0, atol=5e-14)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angles_of_random_quaternions_are_in_their_ranges(sequence, rng):
    q = Rotation.random(500, rng=rng).as_quat(scalar_first=True)
    first, middle, third = euler.angles_from_quaternion(q, sequence).T
    low, high = (0, np.pi) if sequence in SYMMETRIC else (-np.pi / 2, np.pi / 2)
    assert np.all((first >= 0) & (first < 4 * np.pi))
    assert np.all((third >= 0) & (third < 2 * np.pi))
    assert np.all((middle > low) & (middle < high))
    assert first.max() > 2 * np.pi


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("third", [0.0, 1e-17, -1e-17, 1e-16, -1e-16, 2 * np.pi])
def test_sign_of_the_quaternion_survives_a_third_angle_of_zero(sequence, third):
    for first in np.linspace(0.1, 12.0, 60):
        q = euler.quaternion_from_angles((first, 0.8, third), sequence)
        angles = euler.angles_from_quaternion(q, sequence)
        assert np.allclose(euler.quaternion_from_angles(angles, sequence), q, rtol=0, atol=1e-14)
        assert 0 <= angles[2] < 2 * np.pi


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_matrix_of_angles_is_that_of_the_quaternion(sequence):
    angles = np.array([0.4, 0.9, -1.3])
    matrix = np.array(euler.rotation_matrix_from_angles(functions.Vector(angles), sequence), dtype=float)
    assert np.allclose(matrix, rotation_matrix(euler.quaternion_from_angles(angles, sequence)), rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- axes and momenta


def axes_in_space(sequence, angles):
    """The three rotation axes as unit vectors in space, by scipy alone."""
    i, j, k = (int(digit) - 1 for digit in sequence)
    unit = np.eye(3)
    first = Rotation.from_rotvec(angles[0] * unit[i])
    return unit[i], first.apply(unit[j]), (first * Rotation.from_rotvec(angles[1] * unit[j])).apply(unit[k])


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_rotation_axes_along_the_body(sequence):
    angles = np.array([0.4, 0.9, -1.3])
    body_to_space = Rotation.from_euler(scipys(sequence), angles)
    for found, expected in zip(euler.rotation_axes(angles, sequence), axes_in_space(sequence, angles), strict=True):
        assert np.allclose(body_to_space.apply(found), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_momenta_are_projections_of_the_angular_momentum(sequence):
    angles, g = np.array([0.4, 0.9, -1.3]), np.array([0.3, -0.8, 0.5])
    G = Rotation.from_euler(scipys(sequence), angles).apply(g)
    expected = [axis @ G for axis in axes_in_space(sequence, angles)]
    assert np.allclose(euler.momenta_from_angular_momentum(angles, g, sequence), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angular_momentum_from_momenta_is_the_inverse(sequence, rng):
    angles, g = angles_inside(sequence, rng), rng.normal(size=(40, 3))
    momenta = euler.momenta_from_angular_momentum(angles, g, sequence)
    assert np.allclose(euler.angular_momentum_from_momenta(angles, momenta, sequence), g, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_cosine_of_the_outer_axes(sequence):
    angles = np.array([0.4, 0.9, -1.3])
    first, _, third = axes_in_space(sequence, angles)
    cosine, sine = euler.outer_cosine_and_sine(angles[1], sequence)
    assert cosine == pytest.approx(first @ third, abs=1e-15)
    assert cosine**2 + sine**2 == pytest.approx(1, rel=1e-15, abs=0)


def test_momenta_of_sequence_313_in_symbols_are_the_papers():
    phi, theta, psi, g1, g2, g3 = sympy.symbols("phi theta psi g1:4", real=True)
    momenta = euler.momenta_from_angular_momentum(
        functions.Vector((phi, theta, psi)), functions.Vector((g1, g2, g3)), "313"
    )
    expected = (
        g1 * sympy.sin(psi) * sympy.sin(theta) + g2 * sympy.cos(psi) * sympy.sin(theta) + g3 * sympy.cos(theta),
        g1 * sympy.cos(psi) - g2 * sympy.sin(psi),
        g3,
    )
    assert [sympy.simplify(a - b) for a, b in zip(momenta, expected, strict=True)] == [0, 0, 0]


def test_shapes_of_batches():
    angles, g = np.full((6, 3), 0.5), np.ones((6, 3))
    assert euler.quaternion_from_angles(angles).shape == (6, 4)
    assert euler.momenta_from_angular_momentum(angles, g).shape == (6, 3)
    assert euler.angles_from_quaternion(quat.pure(g) / np.sqrt(3) + [0, 0, 0, 0]).shape == (6, 3)
