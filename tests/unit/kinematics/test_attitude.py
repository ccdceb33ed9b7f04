"""Attitudes: quaternions, matrices, scipy rotations and rates."""

import heyoka as hy
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.kinematics import attitude

HALF_ULP = 2.0**-53
NEAR_A_HALF_TURN = [0.0, *(sign * 10.0**-k for k in (1, 2, 4, 6, 8, 12, 15) for sign in (1, -1))]
AXES = [
    *np.eye(3),
    *-np.eye(3),
    *(np.array(a) / np.linalg.norm(a) for a in ((1, 1, 0), (0, 1, -1), (1, 0, 1), (1, 1, 1), (1, -2, 3), (-3, 2, 1))),
    *(np.array(a) / np.linalg.norm(a) for a in ((1, 1e-8, 0), (1e-9, 1, 1e-9), (-1e-300, 0, 1), (1, 1, 1 + 1e-15))),
]


def about(axis, angle):
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis))])


def test_rotation_matrix_is_scipys(rng):
    rotations = Rotation.random(50, rng=rng)
    q = rotations.as_quat(scalar_first=True)
    assert np.allclose(attitude.rotation_matrix(q), rotations.as_matrix(), rtol=0, atol=6 * HALF_ULP)


def test_rotation_matrix_has_the_body_axes_in_space_as_columns():
    q = about((0, 0, 1), 0.3)
    assert np.allclose(attitude.rotation_matrix(q)[:, 0], [np.cos(0.3), np.sin(0.3), 0], rtol=0, atol=1e-15)
    assert np.allclose(attitude.rotation_matrix(q) @ [1, 2, 3], quat.rotate(q, [1.0, 2.0, 3.0]), rtol=0, atol=1.5e-15)


def test_rotation_matrix_shapes():
    assert attitude.rotation_matrix(np.ones((2, 5, 4))).shape == (2, 5, 3, 3)
    assert attitude.rotation_matrix([1, 0, 0, 0]).tolist() == np.eye(3).tolist()


def test_rotation_matrix_off_the_sphere_is_scaled():
    assert np.allclose(attitude.rotation_matrix([2.0, 0, 0, 0]), 4 * np.eye(3), rtol=0, atol=1e-15)


def test_rotation_matrix_of_symbols():
    q = sympy.symbols("q0:4", real=True)
    A = sympy.Matrix(attitude.rotation_matrix(functions.Vector(q)))
    size = sum(x * x for x in q)
    assert (A * A.T - size**2 * sympy.eye(3)).expand() == sympy.zeros(3, 3)
    assert sympy.expand(A.det() - size**3) == 0


def test_rotation_matrix_of_heyoka_expressions():
    q = [hy.expression(f"q{i}") for i in range(4)]
    compiled = hy.cfunc(attitude.rotation_matrix(functions.Vector(q)).ravel().tolist(), vars=q)
    value = np.array([0.1, -0.7, 0.5, 0.5])
    assert np.allclose(compiled(value).reshape(3, 3), attitude.rotation_matrix(value), rtol=0, atol=1e-15)


def test_paper_matrix_is_the_transpose():
    q = about((0.6, 0, 0.8), 0.7)
    assert np.array_equal(attitude.paper_matrix(q), attitude.rotation_matrix(q).T)
    assert attitude.paper_matrix(np.ones((7, 4)) / 2).shape == (7, 3, 3)
    x_space = np.array([0.3, -1.0, 2.0])
    assert np.allclose(attitude.paper_matrix(q) @ x_space, quat.rotate(quat.conjugate(q), x_space), rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- from a matrix


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_quaternion_from_matrix_at_and_next_to_half_turns(axis):
    for near in NEAR_A_HALF_TURN:
        q = about(axis, np.pi + near)
        q /= np.linalg.norm(q)
        back = attitude.quaternion_from_matrix(attitude.rotation_matrix(q))
        signed = q * np.sign(back @ q)
        assert np.max(np.abs(back - signed)) <= 4 * HALF_ULP, near
        assert np.max(back) >= np.max(np.abs(back)) - 4 * HALF_ULP


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-16, 1e-8, 1e-3, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_quaternion_from_matrix_at_other_angles(axis, angle):
    q = about(axis, angle)
    back = attitude.quaternion_from_matrix(attitude.rotation_matrix(q))
    assert np.max(np.abs(back - np.sign(back @ q) * q)) <= 5 * HALF_ULP


def test_quaternion_from_matrix_keeps_tiny_rotations():
    back = attitude.quaternion_from_matrix(attitude.rotation_matrix(about((0, 0.6, 0.8), 1e-20)))
    assert np.allclose(back[1:], [0, 0.3e-20, 0.4e-20], rtol=1e-15, atol=0)


def test_quaternion_from_matrix_of_exact_half_turns_is_exact():
    for k in range(3):
        matrix = 2 * np.outer(np.eye(3)[k], np.eye(3)[k]) - np.eye(3)
        assert attitude.quaternion_from_matrix(matrix).tolist() == [0, *np.eye(3)[k]]


def test_quaternion_from_matrix_of_a_batch(rng):
    rotations = Rotation.random(40, rng=rng)
    q = attitude.quaternion_from_matrix(rotations.as_matrix().reshape(8, 5, 3, 3)).reshape(40, 4)
    expected = rotations.as_quat(scalar_first=True)
    assert np.allclose(q, np.sign(np.sum(q * expected, axis=-1))[:, None] * expected, rtol=0, atol=6 * HALF_ULP)


# ---------------------------------------------------------------------- scipy rotations


def test_unit_quaternion_of_a_rotation_is_scalar_first():
    q = attitude.unit_quaternion(Rotation.from_rotvec([0, 0, 0.4]))
    assert np.allclose(q, about((0, 0, 1), 0.4), rtol=0, atol=HALF_ULP)


def test_unit_quaternion_is_never_normalised():
    given = np.array([1.0 + 9e-10, 0, 0, 0])
    assert attitude.unit_quaternion(given).tolist() == given.tolist()


def test_unit_quaternion_does_not_share_memory():
    given = np.array([1.0, 0, 0, 0])
    attitude.unit_quaternion(given)[0] = 0.0
    assert given[0] == 1.0


def test_rotation_is_body_to_space():
    q = about((0.6, 0, 0.8), 0.7)
    x = np.array([1.0, 2.0, 3.0])
    assert np.allclose(attitude.rotation(q).apply(x), quat.rotate(q, x), rtol=0, atol=1.5e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 0.3, 3.0, np.pi - 1e-9, np.pi])
def test_rotation_angle_keeps_its_digits(angle):
    q = about((0.6, 0, 0.8), 1.1)
    other = quat.product(q, about((0, 1, 0), angle))
    assert attitude.rotation_angle(q, other) == pytest.approx(angle, rel=1e-13, abs=4e-16)
    assert attitude.rotation_angle(q, -other) == pytest.approx(angle, rel=1e-13, abs=4e-16)


def test_rotation_angle_of_batches(rng):
    a, b = Rotation.random(20, rng=rng), Rotation.random(20, rng=rng)
    angles = attitude.rotation_angle(a.as_quat(scalar_first=True), b.as_quat(scalar_first=True))
    assert np.allclose(angles, (a.inv() * b).magnitude(), rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- rates


def motion_of_two_turns(time):
    return quat.product(about((0, 0, 1), 0.7 * time), about((1, 0, 0), -0.3 * time**2))


def numeric_rates(time, step=1e-5):
    """Angular velocity along space and body axes, from the matrices alone."""
    A = attitude.rotation_matrix(motion_of_two_turns(time))
    later, earlier = (attitude.rotation_matrix(motion_of_two_turns(time + h)) for h in (step, -step))
    spin = (later - earlier) / (2 * step) @ A.T
    space = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / 2
    return space, A.T @ space


@pytest.mark.parametrize("time", [0.0, 0.9, 4.0])
def test_rates_are_those_of_the_matrix(time):
    step = 1e-5
    q = motion_of_two_turns(time)
    q_dot = (motion_of_two_turns(time + step) - motion_of_two_turns(time - step)) / (2 * step)
    space, body = numeric_rates(time)
    assert np.allclose(attitude.omega_space(q, q_dot), space, rtol=0, atol=2e-9)
    assert np.allclose(attitude.omega_body(q, q_dot), body, rtol=0, atol=2e-9)


def test_rates_of_a_turn_about_a_body_axis():
    q = about((0.6, 0, 0.8), 0.7)
    q_dot = 0.5 * quat.product(q, [0, 1.0, 2.0, 3.0])
    assert np.allclose(attitude.omega_body(q, q_dot), [1, 2, 3], rtol=0, atol=3e-15)
    assert np.allclose(attitude.omega_space(q, q_dot), quat.rotate(q, [1.0, 2.0, 3.0]), rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- what formulas see


def test_attitude_turns_vectors_both_ways():
    q = about((0.6, 0, 0.8), 0.7)
    seen = attitude.Attitude.from_quaternion(q)
    x = [1.0, 2.0, 3.0]
    assert np.allclose(seen.to_space(x), quat.rotate(q, x), rtol=0, atol=1.5e-15)
    assert np.allclose(seen.to_body(x), quat.rotate(quat.conjugate(q), x), rtol=0, atol=1.5e-15)


def test_attitude_of_arrays_gives_arrays_of_components():
    q = np.stack([about((0, 0, 1), 0.2), about((0, 0, 1), 1.2)])
    seen = attitude.Attitude.from_quaternion(functions.Vector(q.T))
    assert np.allclose(seen.to_space((1, 0, 0))[0], np.cos([0.2, 1.2]), rtol=0, atol=1e-15)
    assert np.allclose(seen.to_body((1, 0, 0))[1], -np.sin([0.2, 1.2]), rtol=0, atol=1e-15)


def test_an_attitude_of_a_matrix_alone_has_no_quaternion():
    with pytest.raises(ValueError, match=r"^attitude must have its quaternion for a formula that reads it, got its"):
        _ = attitude.Attitude(np.eye(3)).quaternion
