"""Every wrong input gives one sentence: `{name} must {rule}, got {what}. {hint}`."""

import math
import re
from typing import Annotated, Any

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions
from poinsot.kinematics.attitude import quaternion_from_matrix

NAN, INF = float("nan"), float("inf")
ONE = (1, 0, 0, 0)
BODY = pt.Body((1.25, 1.0, 0.75))
SYSTEM = pt.System(BODY)
STATE = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
FRAME = pt.RotatingFrame(ONE, (0, 0, 1))
ORBIT = pt.KeplerOrbit(1, semimajor_axis=2, eccentricity=0.1)
SEQUENCES = "121, 123, 131, 132, 212, 213, 231, 232, 312, 313, 321, 323"
FOUR = "omega_body, omega_space, angular_momentum_body, angular_momentum_space"


def kepler(**wrong):
    elements = {"mu": 1, "semimajor_axis": 2, "eccentricity": 0.1, "inclination": 0, "node": 0}
    return pt.KeplerOrbit(**(elements | {"argument_of_periapsis": 0} | wrong))


def run(times=(0, 1), **options):
    return pt.propagate(SYSTEM, STATE, times, **options)


def dense(time):
    return run((0, 2), dense=True)(time)


def check(cases, name):
    """Run one case of a table of calls, kinds of error and sentences."""
    call, kind, sentence = cases[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence)}$") as caught:
        call()
    assert issubclass(caught.type, kind)


# ---------------------------------------------------------------------- numbers that are none

NOT_FINITE = {
    "moments": (lambda: pt.Body((1, NAN, 1)), "moments must be finite, got moments[1] = nan."),
    "moments_of_a_member": (
        lambda: pt.Body([(1, 1, 1), (1, 1, INF)]),
        "moments must be finite, got moments[1, 2] = inf.",
    ),
    "tensor": (lambda: pt.Body.from_inertia(np.full((3, 3), NAN)), "tensor must be finite, got tensor[0, 0] = nan."),
    "mass": (lambda: pt.Body.from_box(INF, (1, 1, 1)), "mass must be finite, got mass = inf."),
    "semiaxes": (lambda: pt.Body.from_ellipsoid(1, (1, NAN, 1)), "semiaxes must be finite, got semiaxes[1] = nan."),
    "positions": (
        lambda: pt.Body.from_point_masses((1, 1), ((0, 0, 0), (0, -INF, 0))),
        "positions must be finite, got positions[1, 1] = -inf.",
    ),
    "quaternion": (
        lambda: pt.State((NAN, 0, 0, 0), (0, 1, 0, 0)),
        "quaternion must be finite, got quaternion[0] = nan.",
    ),
    "conjugate_momenta": (
        lambda: pt.State(ONE, (0, INF, 0, 0)),
        "conjugate_momenta must be finite, got conjugate_momenta[1] = inf.",
    ),
    "time": (lambda: pt.State(ONE, (0, 1, 0, 0), NAN), "time must be finite, got time = nan."),
    "angles": (lambda: pt.State.from_euler((0, NAN, 0), (1, 2, 3)), "angles must be finite, got angles[1] = nan."),
    "momenta": (lambda: pt.State.from_euler((0, 1, 0), (1, 2, INF)), "momenta must be finite, got momenta[2] = inf."),
    "attitude": (
        lambda: BODY.state((1, 0, 0, NAN), omega_body=(1, 0, 0)),
        "attitude must be finite, got attitude[3] = nan.",
    ),
    "omega_body": (
        lambda: BODY.state(ONE, omega_body=(1, 0, NAN)),
        "omega_body must be finite, got omega_body[2] = nan.",
    ),
    "angular_momentum_space": (
        lambda: BODY.state(ONE, angular_momentum_space=(INF, 0, 0)),
        "angular_momentum_space must be finite, got angular_momentum_space[0] = inf.",
    ),
    "time_of_body_state": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), time=NAN),
        "time must be finite, got time = nan.",
    ),
    "time_of_body_state_in_a_frame": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), time=NAN, frame=ORBIT.frame),
        "time must be finite, got time = nan.",
    ),
    "projected_quaternion": (
        lambda: pt.mechanics.project_to_tangent((NAN, 0, 0, 0), (0, 1, 0, 0)),
        "quaternion must be finite, got quaternion[0] = nan.",
    ),
    "weight": (lambda: pt.UniformGravity(NAN, (1, 0, 0)), "weight must be finite, got weight = nan."),
    "center_of_mass": (
        lambda: pt.UniformGravity(1, (1, 0, INF)),
        "center_of_mass must be finite, got center_of_mass[2] = inf.",
    ),
    "coefficient": (lambda: pt.forces.LinearDamping(INF), "coefficient must be finite, got coefficient = inf."),
    "eccentricity": (lambda: kepler(eccentricity=NAN), "eccentricity must be finite, got eccentricity = nan."),
    "epoch": (lambda: kepler(epoch=INF), "epoch must be finite, got epoch = inf."),
    "position": (
        lambda: pt.orbits.FixedPosition(1, position=(1, NAN, 0)),
        "position must be finite, got position[1] = nan.",
    ),
    "mu": (lambda: pt.orbits.FixedPosition(NAN, position=(1, 0, 0)), "mu must be finite, got mu = nan."),
    "velocity_of_from_vectors": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(1, 0, 0), velocity=(0, NAN, 0)),
        "velocity must be finite, got velocity[1] = nan.",
    ),
    "rate_of_a_frame": (
        lambda: pt.RotatingFrame(ONE, (0, 0, NAN)),
        "omega_space must be finite, got omega_space[2] = nan.",
    ),
    "times": (lambda: run((0, NAN)), "times must be finite, got times[1] = nan."),
    "infinite_times": (lambda: run((0, INF)), "times must be finite, got times[1] = inf."),
    "tolerance": (lambda: run(tolerance=NAN), "tolerance must be finite, got tolerance = nan."),
    "called_time": (lambda: dense(NAN), "time must be finite, got time = nan."),
    "matrix": (lambda: quaternion_from_matrix(np.full((3, 3), NAN)), "matrix must be finite, got matrix[0, 0] = nan."),
}


@pytest.mark.parametrize("name", NOT_FINITE)
def test_numbers_must_be_finite(name):
    call, sentence = NOT_FINITE[name]
    check({name: (call, ValueError, sentence)}, name)


NOT_REAL = {
    "words": (lambda: pt.Body("abc"), "moments must be real numbers, got str 'abc'."),
    "digits_in_words": (
        lambda: pt.Body(("1", "1", "1")),
        "moments must be real numbers, got tuple ('1', '1', '1').",
    ),
    "nothing": (lambda: pt.Body(None), "moments must be real numbers, got NoneType None."),
    "truths": (lambda: pt.Body((True, True, True)), "moments must be real numbers, got tuple (True, True, True)."),
    "array_of_truths": (
        lambda: pt.Body(np.array([True, True, True])),
        "moments must be real numbers, got ndarray array([ True,  True,  True]).",
    ),
    "complex": (lambda: pt.Body((1j, 1, 1)), "moments must be real numbers, got tuple (1j, 1, 1)."),
    "complex_array": (
        lambda: pt.Body(np.array([1 + 0j, 1, 1])),
        "moments must be real numbers, got ndarray array([1.+0.j, 1.+0.j, 1.+0.j]).",
    ),
    "ragged": (lambda: pt.Body(((1, 2), (1,))), "moments must be real numbers, got tuple ((1, 2), (1,))."),
    "long": (
        lambda: pt.Body("a" * 1000),
        f"moments must be real numbers, got str '{'a' * 196}....",
    ),
    "word_for_mass": (lambda: pt.Body.from_cylinder("1", 1, 1), "mass must be real numbers, got str '1'."),
    "truth_for_mass": (lambda: pt.Body.from_cylinder(True, 1, 1), "mass must be real numbers, got bool True."),
    "word_for_time": (lambda: pt.State(ONE, (0, 1, 0, 0), "0"), "time must be real numbers, got str '0'."),
    "truth_for_time": (lambda: pt.State(ONE, (0, 1, 0, 0), True), "time must be real numbers, got bool True."),
    "word_for_time_in_a_frame": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), time="a", frame=ORBIT.frame),
        "time must be real numbers, got str 'a'.",
    ),
    "word_for_attitude": (
        lambda: BODY.state("x", omega_body=(1, 0, 0)),
        "attitude must be real numbers, got str 'x'.",
    ),
    "word_for_projected": (
        lambda: pt.mechanics.project_to_tangent("a", (0, 1, 0, 0)),
        "quaternion must be real numbers, got str 'a'.",
    ),
    "word_for_weight": (lambda: pt.UniformGravity("1", (1, 0, 0)), "weight must be real numbers, got str '1'."),
    "truth_for_weight": (
        lambda: pt.UniformGravity(True, (1, 0, 0)),
        "weight must be real numbers, got bool True.",
    ),
    "complex_for_weight": (
        lambda: pt.UniformGravity(1j, (1, 0, 0)),
        "weight must be real numbers, got complex 1j.",
    ),
    "word_for_mu": (lambda: kepler(mu="earth"), "mu must be real numbers, got str 'earth'."),
    "truth_for_eccentricity": (
        lambda: kepler(eccentricity=False),
        "eccentricity must be real numbers, got bool False.",
    ),
    "word_for_times": (lambda: run("abc"), "times must be real numbers, got str 'abc'."),
    "nothing_for_times": (lambda: run(None), "times must be real numbers, got NoneType None."),
    "truths_for_times": (lambda: run([False, True]), "times must be real numbers, got list [False, True]."),
    "words_for_times": (lambda: run(["0", "1"]), "times must be real numbers, got list ['0', '1']."),
    "complex_for_times": (lambda: run([0, 1j]), "times must be real numbers, got list [0, 1j]."),
    "word_for_tolerance": (lambda: run(tolerance="a"), "tolerance must be real numbers, got str 'a'."),
    "truth_for_tolerance": (lambda: run(tolerance=True), "tolerance must be real numbers, got bool True."),
    "word_for_called_time": (lambda: dense("a"), "time must be real numbers, got str 'a'."),
    "truth_for_called_time": (lambda: dense(True), "time must be real numbers, got bool True."),
    "word_for_epoch": (lambda: pt.RotatingFrame(ONE, (0, 0, 1), "a"), "epoch must be real numbers, got str 'a'."),
    "word_for_matrix": (lambda: quaternion_from_matrix("a"), "matrix must be real numbers, got str 'a'."),
}


@pytest.mark.parametrize("name", NOT_REAL)
def test_numbers_must_be_real(name):
    call, sentence = NOT_REAL[name]
    check({name: (call, TypeError, sentence)}, name)


# ---------------------------------------------------------------------- shapes

WRONG_SHAPE = {
    "moments": (lambda: pt.Body((1, 1)), "moments must have shape (3,) or (members, 3), got shape (2,)."),
    "one_moment": (lambda: pt.Body(1.0), "moments must have shape (3,) or (members, 3), got shape ()."),
    "moments_of_rank_3": (
        lambda: pt.Body(np.ones((2, 2, 3))),
        "moments must have shape (3,) or (members, 3), got shape (2, 2, 3).",
    ),
    "no_members": (
        lambda: pt.Body(np.empty((0, 3))),
        "moments must have shape (3,) or (members, 3), got shape (0, 3).",
    ),
    "tensor": (lambda: pt.Body.from_inertia((1, 2, 3)), "tensor must have shape (3, 3), got shape (3,)."),
    "semiaxes": (lambda: pt.Body.from_ellipsoid(1, (1, 1)), "semiaxes must have shape (3,), got shape (2,)."),
    "mass": (lambda: pt.Body.from_cylinder((1, 2), 1, 1), "mass must have shape (), got shape (2,)."),
    "positions": (
        lambda: pt.Body.from_point_masses((1, 1), ((1, 0, 0),)),
        "positions must have shape (2, 3), got shape (1, 3).",
    ),
    "no_masses": (
        lambda: pt.Body.from_point_masses((), np.empty((0, 3))),
        "masses must not be empty, got shape (0,).",
    ),
    "quaternion": (
        lambda: pt.State((1, 0, 0), (0, 1, 0, 0)),
        "quaternion must have shape (4,) or (members, 4), got shape (3,).",
    ),
    "conjugate_momenta": (
        lambda: pt.State(ONE, (0, 1, 0)),
        "conjugate_momenta must have shape (4,) or (members, 4), got shape (3,).",
    ),
    "unequal_members": (
        lambda: pt.State([ONE] * 3, [(0, 1, 0, 0)] * 2),
        "conjugate_momenta must have as many members as quaternion, got 2 and 3.",
    ),
    "unequal_times": (
        lambda: pt.State([ONE] * 3, [(0, 1, 0, 0)] * 3, (0, 1)),
        "time must have as many members as quaternion, got 2 and 3.",
    ),
    "angles": (
        lambda: pt.State.from_euler((0, 1), (1, 2, 3)),
        "angles must have shape (3,) or (members, 3), got shape (2,).",
    ),
    "matrix_for_attitude": (
        lambda: BODY.state(np.eye(3), omega_body=(1, 0, 0)),
        "attitude must be a quaternion or a Rotation, got a matrix. Write Rotation.from_matrix(matrix).",
    ),
    "omega_body": (
        lambda: BODY.state(ONE, omega_body=(1, 0)),
        "omega_body must have shape (3,) or (members, 3), got shape (2,).",
    ),
    "projected": (
        lambda: pt.mechanics.project_to_tangent((1, 0, 0), (0, 1, 0, 0)),
        "quaternion must have shape (4,) or (members, 4), got shape (3,).",
    ),
    "projected_momenta": (
        lambda: pt.mechanics.project_to_tangent(ONE, (0, 1, 0)),
        "conjugate_momenta must have shape (4,) or (members, 4), got shape (3,).",
    ),
    "swapped_parameters": (
        lambda: pt.UniformGravity((1, 0, 0), 0.5),
        "center_of_mass must have shape (3,) or (members, 3) along the body axes, got shape ().",
    ),
    "position_of_from_vectors": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(1, 0), velocity=(0, 1, 0)),
        "position must have shape (3,), got shape (2,).",
    ),
    "rate_of_a_frame": (
        lambda: pt.RotatingFrame(ONE, (0, 1)),
        "omega_space must have shape (3,) or (members, 3), got shape (2,).",
    ),
    "one_time": (lambda: run(3.0), "times must have shape (n,), got the number 3.0. Write [3.0]."),
    "times_of_rank_2": (lambda: run([[0, 1]]), "times must have shape (n,), got shape (1, 2)."),
    "two_tolerances": (lambda: run(tolerance=(1e-3, 1e-4)), "tolerance must have shape (), got shape (2,)."),
    "matrix": (lambda: quaternion_from_matrix(np.eye(2)), "matrix must have shape (..., 3, 3), got shape (2, 2)."),
    "no_matrix": (lambda: quaternion_from_matrix(3.0), "matrix must have shape (..., 3, 3), got shape ()."),
}


@pytest.mark.parametrize("name", WRONG_SHAPE)
def test_shapes_must_be_the_stated_ones(name):
    call, sentence = WRONG_SHAPE[name]
    check({name: (call, ValueError, sentence)}, name)


# ---------------------------------------------------------------------- values

NO_BODY = "No rigid body has these moments."
IMPOSSIBLE_BODIES = {
    "negative_moment": (lambda: pt.Body((1, -1, 1)), "moments must be positive, got -1.0."),
    "diagonal_tensor": (
        lambda: pt.Body(np.diag([1.0, 2.0, 2.5])),
        "moments must be the three principal ones, got a tensor. Write Body.from_inertia(tensor).",
    ),
    "tensor": (
        lambda: pt.Body([[10.0, 0.3, 0.2], [0.3, 12.0, 0.1], [0.2, 0.1, 8.0]]),
        "moments must be the three principal ones, got a tensor. Write Body.from_inertia(tensor).",
    ),
    "zero_moment": (lambda: pt.Body((1, 0, 1)), "moments must be positive, got 0.0."),
    "triangle": (
        lambda: pt.Body((3, 1, 1.5)),
        f"moments must satisfy the triangle inequality, but 3.0 > 1.0 + 1.5. {NO_BODY}",
    ),
    "triangle_by_a_hair": (
        lambda: pt.Body((1, 2, 3.0001)),
        f"moments must satisfy the triangle inequality, but 3.0001 > 1.0 + 2.0. {NO_BODY}",
    ),
    "triangle_of_a_member": (
        lambda: pt.Body([(1, 1, 1), (1, 4, 1)]),
        f"moments must satisfy the triangle inequality, but 4.0 > 1.0 + 1.0. {NO_BODY}",
    ),
    "triangle_of_a_tensor": (
        lambda: pt.Body.from_inertia(np.diag((1, 1, 3))),
        f"moments must satisfy the triangle inequality, but 3.0 > 1.0 + 1.0. {NO_BODY}",
    ),
    "tensor_not_symmetric": (
        lambda: pt.Body.from_inertia([[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]),
        "tensor must be symmetric, but it differs from its transpose by 0.1.",
    ),
    "ellipsoid": (lambda: pt.Body.from_ellipsoid(1, (1, 0, 1)), "semiaxes must be positive, got 0.0."),
    "mass_of_ellipsoid": (lambda: pt.Body.from_ellipsoid(-1, (1, 1, 1)), "mass must be positive, got -1.0."),
    "box": (lambda: pt.Body.from_box(1, (1, -1, 1)), "sides must be positive, got -1.0."),
    "radius": (lambda: pt.Body.from_cylinder(1, 0, 1), "radius must be positive, got 0.0."),
    "height": (lambda: pt.Body.from_cylinder(1, 1, -2), "height must be positive, got -2.0."),
    "mass_of_cylinder": (lambda: pt.Body.from_cylinder(0, 1, 1), "mass must be positive, got 0.0."),
    "point_masses": (
        lambda: pt.Body.from_point_masses((1, -3), ((1, 0, 0), (0, 1, 0))),
        "masses must be positive, got -3.0.",
    ),
    "one_point": (lambda: pt.Body.from_point_masses((1,), ((1, 0, 0),)), "moments must be positive, got 0.0."),
}


@pytest.mark.parametrize("name", IMPOSSIBLE_BODIES)
def test_bodies_must_be_possible(name):
    call, sentence = IMPOSSIBLE_BODIES[name]
    check({name: (call, ValueError, sentence)}, name)


DIVIDE = "Divide by the norm, or pass a Rotation."
OFF_THE_SPHERE = {
    "state": (
        lambda: pt.State((1.0003, 0, 0, 0), (0, 1, 0, 0)),
        f"quaternion must have unit norm, but |q| = 1.0003. {DIVIDE}",
    ),
    "state_by_a_hair": (
        lambda: pt.State((1 + 2e-9, 0, 0, 0), (0, 1, 0, 0)),
        f"quaternion must have unit norm, but |q| = 1.000000002. {DIVIDE}",
    ),
    "member": (
        lambda: pt.State([ONE, (0.5, 0, 0, 0)], (0, 0, 0, 0)),
        f"quaternion must have unit norm, but |q| = 0.5. {DIVIDE}",
    ),
    "zero": (
        lambda: pt.State((0, 0, 0, 0), (0, 1, 0, 0)),
        f"quaternion must have unit norm, but |q| = 0. {DIVIDE}",
    ),
    "body_state": (
        lambda: BODY.state((3, 4, 0, 0), omega_body=(1, 0, 0)),
        f"attitude must have unit norm, but |q| = 5. {DIVIDE}",
    ),
    "frame": (
        lambda: pt.RotatingFrame((3, 4, 0, 0), (0, 0, 1)),
        f"attitude must have unit norm, but |q| = 5. {DIVIDE}",
    ),
    "projection_of_nothing": (
        lambda: pt.mechanics.project_to_tangent((0, 0, 0, 0), (0, 1, 0, 0)),
        "quaternion must not be zero, got |q| = 0.",
    ),
    "matrix_scaled": (
        lambda: quaternion_from_matrix(2 * np.eye(3)),
        "matrix must be a rotation (orthogonal, determinant +1), but A A^T differs from 1 by 3.",
    ),
    "matrix_reflected": (
        lambda: quaternion_from_matrix(-np.eye(3)),
        "matrix must be a rotation (orthogonal, determinant +1), but its determinant is -1.",
    ),
    "matrix_by_a_hair": (
        lambda: quaternion_from_matrix(np.eye(3) * (1 + 1e-8)),
        "matrix must be a rotation (orthogonal, determinant +1), but A A^T differs from 1 by 2e-08.",
    ),
}


@pytest.mark.parametrize("name", OFF_THE_SPHERE)
def test_attitudes_must_be_rotations(name):
    call, sentence = OFF_THE_SPHERE[name]
    check({name: (call, ValueError, sentence)}, name)


PRINTED = ((0.5, -(2**-0.5), 0, 0.5), (0.3, -0.848528, 0.141421, -1.5))
"""The paper's state to six digits, whose momenta are not tangent."""


def test_the_papers_six_digits_are_refused_and_the_hint_works():
    sentence = (
        "conjugate_momenta must be tangent to the unit sphere, but |q . Q| = 5.54e-08 |Q|. "
        "Pass project_to_tangent(quaternion, conjugate_momenta), which preserves the angular momentum."
    )
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.State(*PRINTED)
    state = pt.State(PRINTED[0], pt.mechanics.project_to_tangent(*PRINTED))
    q, Q = map(np.array, PRINTED)
    g = 0.5 * (q[0] * Q[1:] - Q[0] * q[1:] - np.cross(q[1:], Q[1:]))
    assert np.allclose(state.angular_momentum_body, g, rtol=0, atol=1e-15)
    assert abs(q @ state.conjugate_momenta) < 1e-15


@pytest.mark.parametrize("members", [1, 3])
def test_momenta_of_a_member_must_be_tangent(members):
    Q = np.zeros((members, 4))
    Q[-1] = (1, 0, 0, 0)
    with pytest.raises(ValueError, match=r"^conjugate_momenta must be tangent .* but \|q \. Q\| = 1 \|Q\|\. Pass "):
        pt.State(ONE, Q)


def test_momenta_just_inside_the_slack_are_taken():
    assert pt.State(ONE, (0.99e-9, 1, 0, 0)).conjugate_momenta[0] == 0.99e-9
    with pytest.raises(ValueError, match="tangent"):
        pt.State(ONE, (1.01e-9, 1, 0, 0))


FORCES_AND_ORBITS = {
    "weight": (
        lambda: pt.UniformGravity(-1.5, (1, 0, 0)),
        "weight must not be negative, got -1.5. Gravity acts along -s3; turn center_of_mass.",
    ),
    "parabola": (
        lambda: kepler(eccentricity=1.0),
        "eccentricity must be in [0, 1), got 1.0. A Kepler orbit is an ellipse.",
    ),
    "hyperbola": (
        lambda: kepler(eccentricity=1.5),
        "eccentricity must be in [0, 1), got 1.5. A Kepler orbit is an ellipse.",
    ),
    "negative_eccentricity": (
        lambda: kepler(eccentricity=-0.1),
        "eccentricity must be in [0, 1), got -0.1. A Kepler orbit is an ellipse.",
    ),
    "eccentricity_of_a_member": (
        lambda: kepler(eccentricity=[0.1, 1.2]),
        "eccentricity must be in [0, 1), got 1.2. A Kepler orbit is an ellipse.",
    ),
    "mu": (lambda: kepler(mu=0), "mu must be positive, got 0.0."),
    "semimajor_axis": (lambda: kepler(semimajor_axis=-2), "semimajor_axis must be positive, got -2.0."),
    "fixed_point_at_zero": (
        lambda: pt.orbits.FixedPosition(1, position=(0, 0, 0)),
        "position must not be zero, got all components 0. The body would be at the attractor.",
    ),
    "mu_of_a_fixed_point": (lambda: pt.orbits.FixedPosition(-1, position=(1, 0, 0)), "mu must be positive, got -1.0."),
    "frame_of_a_fixed_point": (
        lambda: pt.orbits.FixedPosition(1, position=(1, 0, 0)).frame,
        "orbit must move to have a frame, but FixedPosition has no velocity.",
    ),
    "radial_vectors": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(1, 2, 3), velocity=(-1, -2, -3)),
        "position and velocity must span a plane, but they are parallel.",
    ),
    "no_velocity": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(1, 2, 3), velocity=(0, 0, 0)),
        "position and velocity must span a plane, but they are parallel.",
    ),
    "no_position": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(0, 0, 0), velocity=(0, 1, 0)),
        "position must not be zero, got all components 0. The body would be at the attractor.",
    ),
    "hyperbolic_vectors": (
        lambda: pt.KeplerOrbit.from_vectors(1, position=(1, 0, 0), velocity=(0, 2, 0)),
        "position and velocity must belong to an ellipse, but the orbital energy is 1 >= 0.",
    ),
    "repelling_mu_of_vectors": (
        lambda: pt.KeplerOrbit.from_vectors(-1, position=(1, 0, 0), velocity=(0, 1, 0)),
        "mu must be positive, got -1.0.",
    ),
}


@pytest.mark.parametrize("name", FORCES_AND_ORBITS)
def test_forces_and_orbits_must_be_physical(name):
    call, sentence = FORCES_AND_ORBITS[name]
    check({name: (call, ValueError, sentence)}, name)


# ---------------------------------------------------------------------- choices and times

CHOICES = {
    "sequence_of_letters": (lambda: STATE.euler("zxz"), f"sequence must be one of {SEQUENCES}, got 'zxz'."),
    "sequence_that_repeats": (lambda: STATE.euler("113"), f"sequence must be one of {SEQUENCES}, got '113'."),
    "sequence_of_from_euler": (
        lambda: pt.State.from_euler((0, 1, 0), (1, 2, 3), "12"),
        f"sequence must be one of {SEQUENCES}, got '12'.",
    ),
    "formulation": (
        lambda: run(formulation="quaternion"),
        "formulation must be one of lie_poisson, canonical, euler_angles, planar or a Formulation, got 'quaternion'.",
    ),
    "precision": (
        lambda: run(precision="half"),
        "precision must be 'double' or 'quadruple', got 'half'.",
    ),
    "zero_tolerance": (lambda: run(tolerance=0), "tolerance must be between 0 and 1, got 0.0."),
    "negative_tolerance": (lambda: run(tolerance=-1e-9), "tolerance must be between 0 and 1, got -1e-09."),
    "large_tolerance": (lambda: run(tolerance=1), "tolerance must be between 0 and 1, got 1.0."),
    "no_times": (lambda: run([]), "times must not be empty, got shape (0,)."),
    "equal_times": (lambda: run([0, 1, 2, 2, 3]), "times must be strictly monotonic, but times[2] = times[3] = 2.0."),
    "equal_first_times": (lambda: run([1, 1]), "times must be strictly monotonic, but times[0] = times[1] = 1.0."),
    "times_that_turn": (
        lambda: run([0, 2, 1.5]),
        "times must be strictly monotonic, but times[1] = 2.0 and times[2] = 1.5.",
    ),
    "falling_times_that_turn": (
        lambda: run([0, -2, -1.5]),
        "times must be strictly monotonic, but times[1] = -2.0 and times[2] = -1.5.",
    ),
    "singular_angles": (
        lambda: pt.State.from_euler((1, 0, 0), (1, 2, 3)),
        "the second angle of sequence 313 must stay away from its singularity, but |sin| = 0 there. Use sequence 123.",
    ),
    "singular_attitude": (
        lambda: pt.State(ONE, (0, 1, 0, 0)).euler("212"),
        "the second angle of sequence 212 must stay away from its singularity, but |sin| = 0 there. Use sequence 123.",
    ),
    "singular_angles_of_three_axes": (
        lambda: pt.State.from_euler((1, np.pi / 2, 0), (1, 2, 3), "123"),
        "the second angle of sequence 123 must stay away from its singularity, but |cos| = 6.1e-17 there. "
        "Use sequence 121.",
    ),
    "nothing_given": (lambda: BODY.state(ONE), f"state must have exactly one of {FOUR}, got none."),
    "two_given": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), angular_momentum_space=(1, 0, 0)),
        f"state must have exactly one of {FOUR}, got omega_body and angular_momentum_space.",
    ),
    "momentum_with_a_frame": (
        lambda: BODY.state(ONE, angular_momentum_body=(1, 0, 0), frame=FRAME),
        "a rate relative to a frame must be omega_body or omega_space, got angular_momentum_body.",
    ),
    "called_without_dense_output": (
        lambda: run()(0.5),
        "a trajectory must have dense output to be called, got none. Propagate one motion with dense=True.",
    ),
    "called_outside": (lambda: dense(2.5), "time must lie within [0, 2], got 2.5."),
    "units": (lambda: pt.System(BODY, units={"mass": "kg"}), "units must name 'time' and 'inertia', got 'mass'."),
}


@pytest.mark.parametrize("name", CHOICES)
def test_choices_must_be_among_those_there_are(name):
    call, sentence = CHOICES[name]
    check({name: (call, ValueError, sentence)}, name)


# ---------------------------------------------------------------------- kinds

NO_FRAME = "An orbit has one: orbit.frame."


class Undeclared(pt.Potential):
    table: dict

    def energy(self, instant):  # noqa: ARG002
        return 0.0


class Anything(pt.Potential):
    thing: Any

    def energy(self, instant):  # noqa: ARG002
        return 0.0


class Degree(pt.Potential):
    degree: int
    table: Annotated[Any, (2, 2)]

    def energy(self, instant):
        return 0.0 * instant.attitude.to_body((0, 0, 1))[0]


DECLARED = (
    "must be declared as float, Vector, BodyVector, SpaceVector, Annotated[Any, shape], int, bool, str, Orbit or "
    "tuple[Orbit, ...], got"
)
KINDS = {
    "state_before_system": (
        lambda: pt.propagate(STATE, SYSTEM, (0, 1)),
        "system must be a System, got State. The order is propagate(system, state, times).",
    ),
    "body_for_system": (
        lambda: pt.propagate(BODY, STATE, (0, 1)),
        "system must be a System, got Body. The order is propagate(system, state, times).",
    ),
    "times_before_state": (
        lambda: pt.propagate(SYSTEM, (0, 1), STATE),
        "state must be a State or a PairState, got tuple. The order is propagate(system, state, times).",
    ),
    "force_before_body": (
        lambda: pt.System(pt.UniformGravity(1, (1, 0, 0)), BODY),
        "body must be a Body or TwoBodies, got UniformGravity. The order is System(body, *forces).",
    ),
    "class_for_body": (
        lambda: pt.System(pt.Body),
        "body must be a Body or TwoBodies, got the class Body. The order is System(body, *forces).",
    ),
    "class_for_force": (
        lambda: pt.System(BODY, pt.UniformGravity),
        "a force must be an instance, got the class UniformGravity. Write UniformGravity(...).",
    ),
    "word_for_force": (
        lambda: pt.System(BODY, "gravity"),
        "a force must be a Potential, a Torque or a Part, got str.",
    ),
    "list_of_forces": (
        lambda: pt.System(BODY, [1.0]),
        "a force must be a Potential, a Torque or a Part, got list. Give them one by one: System(body, *forces).",
    ),
    "orbit_for_force": (
        lambda: pt.System(BODY, ORBIT),
        "a force must be a Potential, a Torque or a Part, got KeplerOrbit.",
    ),
    "sequence_as_a_number": (lambda: STATE.euler(313), "sequence must be a text, got int 313."),
    "formulation_as_a_list": (
        lambda: run(formulation=["canonical"]),
        "formulation must be a text or a Formulation, got list.",
    ),
    "precision_as_a_list": (lambda: run(precision=["double"]), "precision must be a text, got list."),
    "number_for_orbit": (lambda: pt.GravityGradient(3), "orbit must be an Orbit, got int."),
    "class_for_orbit": (
        lambda: pt.GravityGradient(pt.KeplerOrbit),
        "orbit must be an Orbit, got the class KeplerOrbit.",
    ),
    "frame_of_state": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), frame=3),
        f"frame must be a Frame, got int. {NO_FRAME}",
    ),
    "orbit_for_frame_of_state": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), frame=ORBIT),
        f"frame must be a Frame, got KeplerOrbit. {NO_FRAME}",
    ),
    "class_for_frame_of_state": (
        lambda: BODY.state(ONE, omega_body=(1, 0, 0), frame=pt.RotatingFrame),
        f"frame must be a Frame, got the class RotatingFrame. {NO_FRAME}",
    ),
    "frame": (lambda: run().relative_to(3), f"frame must be a Frame, got int. {NO_FRAME}"),
    "orbit_for_frame": (lambda: run().relative_to(ORBIT), f"frame must be a Frame, got KeplerOrbit. {NO_FRAME}"),
    "class_for_frame": (
        lambda: run().relative_to(pt.RotatingFrame),
        f"frame must be a Frame, got the class RotatingFrame. {NO_FRAME}",
    ),
    "dict_as_a_field": (lambda: Undeclared({}), f"Undeclared.table {DECLARED} <class 'dict'>."),
    "any_as_a_field": (lambda: Anything(1.0), f"Anything.thing {DECLARED} typing.Any."),
    "float_for_int": (lambda: Degree(2.0, np.eye(2)), "degree must be an int, got float."),
    "truth_for_int": (lambda: Degree(True, np.eye(2)), "degree must be an int, got bool."),
    "unit_that_is_no_name": (
        lambda: pt.System(BODY, units={"time": 3}),
        "units must be words, but units['time'] = 3.",
    ),
}


@pytest.mark.parametrize("name", KINDS)
def test_arguments_must_be_of_their_kind(name):
    call, sentence = KINDS[name]
    check({name: (call, TypeError, sentence)}, name)


def test_a_table_has_its_declared_shape():
    with pytest.raises(
        ValueError, match=r"^table must have shape \(2, 2\) or \(members, 2, 2\), got shape \(3, 2\)\.$"
    ):
        Degree(2, np.ones((3, 2)))


# ---------------------------------------------------------------------- formulas


def potential(formula):
    """A potential by a function of its one parameter and of s3 along the body axes."""

    class Formula(pt.Potential):
        size: float

        def energy(self, instant):
            return formula(self.size, instant.attitude.to_body((0, 0, 1)))

    return Formula(2.0)


def torque(formula):
    """A torque by a function of its one parameter and of omega along the body axes."""

    class Formula(pt.Torque):
        size: float

        def torque(self, instant):
            return formula(self.size, instant.omega_body)

    return Formula(2.0)


def branch(value, a, b):
    return a if value > 0 else b


BRANCH = (
    "the formula of Formula must not branch with `if` on a value, but it does. "
    "Write poinsot.functions.where(condition, a, b)."
)
THREE = "the torque of Formula must be three components along the body axes, got"
FORMULAS = {
    "energy_that_is_a_vector": (
        potential(lambda _, up: up),
        "the energy of Formula must be one scalar, got 3 components.",
    ),
    "energy_that_is_a_tuple": (
        potential(lambda size, up: (size, up[0])),
        "the energy of Formula must be one scalar, got 2 components.",
    ),
    "energy_that_is_nothing": (potential(lambda *_: None), "the energy of Formula must be one scalar, got None."),
    "torque_that_is_a_scalar": (torque(lambda size, _: size), f"{THREE} a scalar."),
    "torque_that_is_a_number": (torque(lambda *_: 0.0), f"{THREE} a scalar."),
    "torque_of_four": (torque(lambda size, _: (size,) * 4), f"{THREE} 4 components."),
    "torque_of_two": (torque(lambda size, _: (size, 0.0)), f"{THREE} 2 components."),
    "torque_that_is_nothing": (torque(lambda *_: None), f"{THREE} None."),
    "if_on_a_parameter": (potential(lambda size, up: branch(size, up[0], up[1])), BRANCH),
    "if_on_a_component": (potential(lambda size, up: branch(up[2], size, 0.0)), BRANCH),
    "max_of_components": (potential(lambda _, up: max(up[0], up[1])), BRANCH),
    "if_on_a_parameter_of_a_torque": (torque(lambda size, omega: branch(size, omega, -omega)), BRANCH),
    "if_on_a_rate": (torque(lambda size, omega: branch(omega[0], size * omega, omega)), BRANCH),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_formulas_must_return_what_they_say_and_not_branch(name):
    force, sentence = FORMULAS[name]
    check({name: (lambda: pt.System(BODY, force), TypeError, sentence)}, name)


RULE = "must use + - * / ** and poinsot.functions alone"
FOREIGN = {
    "math_of_a_parameter": (potential(lambda size, up: math.sin(size) * up[0]), "Formula.energy", "math.sin", "sin"),
    "math_of_a_component": (potential(lambda _, up: math.cos(up[0])), "Formula.energy", "math.cos", "cos"),
    "math_of_a_rate": (torque(lambda _, omega: (math.fabs(omega[0]), 0.0, 0.0)), "Formula.torque", "math.fabs", "abs"),
    "numpy_of_a_vector": (torque(lambda _, omega: np.sin(omega)), "the formula of Formula", "numpy.sin", "sin"),
    "numpy_dot": (potential(lambda _, up: np.dot(up, up)), "the formula of Formula", "numpy.dot", "dot"),
    "numpy_of_what_a_potential_looks_at": (
        potential(lambda _, up: np.arctan2(up[0], up[1])),
        "Formula.energy",
        "numpy.arctan2",
        "atan2",
    ),
}
ON_SYMBOLS = {
    "sin": lambda x, _: np.sin(x),
    "abs": lambda x, _: np.abs(x),
    "sign": lambda x, _: np.sign(x),
    "where": lambda x, _: np.where(functions.less(x, 0), 1.0, 2.0),
    "clip": lambda x, _: np.clip(x, 0, 1),
    "minimum": lambda x, _: np.minimum(x, 0.0),
    "maximum": lambda x, _: np.maximum(0.0, x),
    "interp": lambda x, _: np.interp(x, [0, 1], [1, 2]),
    "tanh": lambda x, _: np.tanh(x),
    "acos": lambda x, _: np.arccos(0.1 * x),
    "norm": lambda _, omega: np.linalg.norm(omega),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_foreign_functions_are_refused_by_the_system(name):
    force, place, foreign, own = FOREIGN[name]
    sentence = f"{place} {RULE}, got {foreign}. Write poinsot.functions.{own}."
    check({name: (lambda: pt.System(BODY, force), TypeError, sentence)}, name)


@pytest.mark.parametrize("own", ON_SYMBOLS)
def test_foreign_functions_are_refused_on_symbols_by_name(own):
    force = torque(lambda size, omega: functions.Vector((ON_SYMBOLS[own](size * omega[0], omega), omega[1], omega[2])))
    with pytest.raises(TypeError, match=rf"{re.escape(RULE)}, got numpy\.[a-z0-9.]+\. ") as caught:
        pt.propagate(pt.System(BODY, force), STATE, (0, 1))
    assert str(caught.value).endswith(f"Write poinsot.functions.{own}.")


@pytest.mark.parametrize("formula", [lambda _, up: float(up[0]), lambda size, up: np.cbrt(size * up[0])])
def test_what_has_no_name_there_is_refused_too(formula):
    with pytest.raises(TypeError, match=re.escape(RULE)):
        pt.System(BODY, potential(formula))


@pytest.mark.parametrize("kind", [ValueError, TypeError])
@pytest.mark.parametrize("words", ["%s", "truth valu %s", "positional argument %s"])
def test_what_a_formula_raises_is_reported_in_printable_letters_of_one_line(kind, words):
    def energy(*_):
        raise kind(words % "\x1b[2J\r\n\x9b\u202egone")

    with pytest.raises(TypeError, match=r"^the formula of Formula must ") as caught:
        pt.System(BODY, potential(energy))
    assert str(caught.value).isprintable()
    assert words % r"\x1b[2J \x9b\u202egone" in str(caught.value)


def test_a_comparison_that_has_no_condition_names_the_one_that_has():
    force = torque(lambda _, omega: functions.Vector((functions.where(omega[0] <= 0, 1.0, 2.0), omega[1], omega[2])))
    with pytest.raises(TypeError, match=r"must compare by < or >, as poinsot\.functions\.less"):
        pt.propagate(pt.System(BODY, force), STATE, (0, 1))


def test_a_foreign_choice_by_a_condition_names_where():
    force = torque(lambda _, omega: functions.Vector((np.where(omega[0] < 0, 1.0, 2.0), omega[1], omega[2])))
    with pytest.raises(TypeError, match=r"got numpy\.where\. Write poinsot\.functions\.where\."):
        pt.propagate(pt.System(BODY, force), STATE, (0, 1))


def test_an_energy_does_not_depend_on_the_rates():
    class Formula(pt.Potential):
        def energy(self, instant):
            return instant.omega_body[0]

    with pytest.raises(
        TypeError, match=r"^an energy must depend on time, attitude, orbits and parts alone, got .* Torque\.$"
    ):
        pt.System(BODY, Formula())


def test_a_formula_takes_the_arguments_of_its_base_class():
    class Formula(pt.Potential):
        def energy(self, body, attitude):  # noqa: ARG002
            return 0.0

    with pytest.raises(TypeError, match=r"^the formula of Formula must take one argument, the instant, but "):
        pt.System(BODY, Formula())


def test_an_if_on_structure_is_no_mistake():
    class Chosen(pt.Potential):
        degree: int
        size: float

        def energy(self, instant):
            up = instant.attitude.to_body((0, 0, 1))[0]
            return self.size * (up if self.degree == 1 else up**2)

    assert np.isfinite(pt.propagate(pt.System(BODY, Chosen(2, 0.5)), STATE, [1.0]).energy[0])


# ---------------------------------------------------------------------- runs that stop


class Pole(pt.Torque):
    instant: float

    def torque(self, instant):
        pole = 1 / (self.instant - instant.time) ** 2
        return functions.Vector((pole, 0 * pole, 0 * pole))


STOPPED = {
    "singular_force": (
        lambda: pt.propagate(pt.System(BODY, Pole(5.25)), STATE, (0, 10)),
        "propagation stopped at t = 5.25 of 10: the step size fell to rounding. The equations are singular there.",
    ),
    "euler_angles": (
        lambda: pt.propagate(
            SYSTEM,
            BODY.state((np.cos(0.2), np.sin(0.2), 0, 0), omega_body=(-0.3, 0, 0)),
            (0, 10),
            formulation="euler_angles",
        ),
        "propagation stopped at t = 1.33333 of 10: sin(theta) fell below 1e-6. "
        "The Euler angles 3-1-3 are singular there; use another formulation.",
    ),
}


@pytest.mark.parametrize("name", STOPPED)
def test_runs_that_stop_say_where_and_why(name):
    call, sentence = STOPPED[name]
    check({name: (call, pt.PropagationError, sentence)}, name)


def test_a_step_of_rounding_size_says_so():
    state = BODY.state(ONE, omega_body=(1e8, 1, 2), time=1e9)
    with pytest.raises(pt.PropagationError) as caught:
        pt.propagate(SYSTEM, state, (1e9, 1e9 + 100))
    assert re.fullmatch(
        r"propagation stopped at t = 1000000\d{3}(\.\d+)? of 1000000100: the step size fell to rounding\. "
        r"The equations are singular there\.",
        str(caught.value),
    )


def test_files_and_pictures_are_of_trajectories(tmp_path):
    motion = pt.propagate(pt.System(BODY), STATE, [0.0, 1.0])
    gone = tmp_path / "gone"
    cases = {
        "order": (
            lambda: pt.save("m.nc", motion),
            TypeError,
            "motion must be a Trajectory, got str. The order is save(motion, path).",
        ),
        "suffix": (
            lambda: pt.save(motion, "motion.txt"),
            ValueError,
            "path must end in .nc or .zarr, got 'motion.txt'.",
        ),
        "folder": (
            lambda: pt.save(motion, gone / "m.nc"),
            FileNotFoundError,
            f"No such folder: {gone}",
        ),
        "picture": (lambda: pt.plot.quaternions(3), TypeError, "motion must be a Trajectory, got int."),
        "units": (
            lambda: pt.System(BODY, units="SI"),
            TypeError,
            'units must be a mapping such as {"time": "s"}, got str.',
        ),
        "omega": (
            lambda: BODY.omega((1, 2)),
            ValueError,
            "angular_momentum_body must have shape (..., 3), got shape (2,).",
        ),
        "energy": (
            lambda: BODY.kinetic_energy((np.nan, 1, 2)),
            ValueError,
            "angular_momentum_body must be finite, got angular_momentum_body[0] = nan.",
        ),
    }
    for name in cases:
        check(cases, name)


RETURNED = {"text": "abc", "complex": 1j, "mapping": {}, "flag": object()}


@pytest.mark.parametrize("name", RETURNED)
def test_formulas_return_real_scalars(name):
    kind = type(RETURNED[name]).__name__
    with pytest.raises(TypeError, match=rf"^the energy of Formula must be one scalar, got {kind}\.$"):
        pt.System(BODY, potential(lambda *_: RETURNED[name]))
    rule = "the torque of Formula must be three components along the body axes"
    with pytest.raises(TypeError, match=rf"^{rule}, got one that is {kind}\.$"):
        pt.System(BODY, torque(lambda *_: (RETURNED[name], 0.0, 0.0)))


class BytesPath:
    def __fspath__(self):
        return b"x.apm"


@pytest.mark.parametrize("path", [BytesPath(), "a\ud800.nc", "a" * 256, b"x.apm", "a\0b"], ids=range(5))
@pytest.mark.parametrize("call", [pt.load, pt.files.read_apm, pt.files.read_aem, pt.files.read_scenario])
def test_a_path_is_a_text_that_the_system_can_encode(call, path):
    with pytest.raises(TypeError, match=r"^path must be a path, got (BytesPath|str '|bytes b')"):
        call(path)
