"""The paper's equations, one by one, as exact identities in the functions that ship (docs/paper.md)."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector, cross, dot, norm
from poinsot.kinematics import attitude, euler
from poinsot.kinematics.state import State


def real(names):
    return Vector(sp.symbols(names, real=True))


def gradient(scalar, variables):
    return Vector(sp.diff(scalar, variable) for variable in variables)


def exact(expression):
    """Return the expression with rational numbers, and one symbol for |x|, which saves square roots."""
    rational = formulas.rational(expression)
    return rational.subs(norm(x), distance) if rational.has(*x) else rational


def numerator(expression):
    return sp.expand(sp.numer(sp.together(exact(expression))))


def assert_zero(expressions, *constraints):
    """Each expression vanishes identically, or where the polynomial constraints do."""
    basis = sp.groebner(constraints, order="grevlex").exprs if len(constraints) > 1 else constraints
    for expression in map(numerator, expressions):
        rest = sp.reduced(expression, basis, order="grevlex")[1] if basis and expression != 0 else expression
        assert rest == 0, rest


def assert_equal(left, right, *constraints):
    assert_zero([a - b for a, b in zip(left, right, strict=True)], *constraints)


def assert_trigonometric(left, right):
    """Two lists of functions of the Euler angles are equal, as polynomials in cosines and sines."""
    for a, b in zip(left, right, strict=True):
        difference = exact(a - b)
        arguments = {call.args[0] for call in difference.atoms(sp.cos, sp.sin)}
        if not arguments <= set(ANGLES):  # half angles
            doubles = {angle: 2 * half for angle, half in zip(ANGLES, HALVES, strict=True)}
            difference = sp.expand_trig(difference.subs(doubles))
        difference = difference.xreplace(COSINES_AND_SINES)
        assert not difference.has(*HALVES, *ANGLES)
        assert_zero([difference], *CIRCLES)


q, Q, p, P = real("q:4"), real("Q:4"), real("p:4"), real("P:4")
ANGLES, MOMENTA, HALVES = real("phi theta psi"), real("Phi Theta Psi"), real("half1:4")
COSINES, SINES = real("cos1:4"), real("sin1:4")
CIRCLES = [c**2 + s**2 - 1 for c, s in zip(COSINES, SINES, strict=True)]
COSINES_AND_SINES = {
    call(angle): symbol
    for angles in (ANGLES, HALVES)
    for call, symbols in ((sp.cos, COSINES), (sp.sin, SINES))
    for angle, symbol in zip(angles, symbols, strict=True)
}
phi, theta, psi = ANGLES
Phi, Theta, Psi = MOMENTA
x, axis, omega, g, centre = real("x1:4"), real("a1:4"), real("omega1:4"), real("g1:4"), real("c1:4")
weight, mu, distance, I0 = sp.symbols("weight mu distance I0", positive=True)
MOMENTS = Vector(sp.symbols("I1:4", positive=True))
FOUR_MOMENTS = Vector((I0, *MOMENTS))
"""The paper's four moments; I0 is arbitrary."""
FIRST, SECOND, THIRD = Vector((1, 0, 0)), Vector((0, 1, 0)), Vector((0, 0, 1))
UNIT_Q, UNIT_P, UNIT_AXIS = quat.dot(q, q) - 1, quat.dot(p, p) - 1, dot(axis, axis) - 1
TANGENT_P = quat.dot(p, P)

FREE = formulas.copied(pt.System(pt.Body((1, 1, 1))), MOMENTS)
TOP = formulas.copied(pt.System(pt.Body((1, 1, 1)), pt.UniformGravity(1, (1, 0, 0))), (*MOMENTS, weight, *centre))
SATELLITE = formulas.copied(
    pt.System(pt.Body((1, 1, 1)), pt.GravityGradient(pt.orbits.FixedPosition(1, position=(1, 0, 0)))),
    (*MOMENTS, mu, *x),
)
BODY = FREE.body
SYSTEMS = pytest.mark.parametrize("system", [FREE, TOP, SATELLITE], ids=["free", "top", "satellite"])

ROOT = np.sqrt(2.0)
GM, SEMIMAJOR_AXIS, ECCENTRICITY, INCLINATION, NODE, PERIGEE = 398600.4418, 7000, 0.2, np.pi / 6, np.pi / 4, np.pi / 12
ORBIT = pt.KeplerOrbit(
    GM,
    semimajor_axis=SEMIMAJOR_AXIS,
    eccentricity=ECCENTRICITY,
    inclination=INCLINATION,
    node=NODE,
    argument_of_periapsis=PERIGEE,
)
SEED = 2006


def q_dot():
    """Any q' that keeps |q|: a four-vector without its part along q."""
    free = real("d:4")
    return free - quat.dot(q, free) * q


def shipped(name, quaternion, momenta):
    """Return a property of `State`, run on symbols."""
    return getattr(State.computed({"quaternion": quaternion, "conjugate_momenta": momenta}, 0.0), name)


def rotation_of_equation_2(sine, cosine):
    across = cross(axis, x)
    return dot(x, axis) * axis + across * sine + cross(across, axis) * cosine


def random_states(count):
    rng = np.random.default_rng(SEED)
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    return pt.State(quaternions, pt.mechanics.project_to_tangent(quaternions, rng.normal(size=(count, 4))))


# ---------------------------------------------------------------------- Sec. 2: rotations and quaternions


def test_equation_1_splits_a_vector_along_and_across_an_axis():
    across, inward = cross(axis, x), cross(cross(axis, x), axis)
    assert_equal(dot(x, axis) * axis + inward, x, UNIT_AXIS)
    assert_zero([dot(axis, across), dot(across, inward), dot(inward, axis)])


def test_equation_1_in_quaternion_products():
    split = -quat.product(quat.pure(axis), quat.product(quat.pure(axis), quat.pure(x)))
    assert_equal(split, (0, *x), UNIT_AXIS)


def test_equation_2_is_a_proper_rotation_at_the_rate_of_its_angle():
    sine, cosine = real("S C")
    circle = sine**2 + cosine**2 - 1
    turned = rotation_of_equation_2(sine, cosine)
    matrix = sp.Matrix([turned]).jacobian(list(x))
    assert_zero(matrix * matrix.T - sp.eye(3), UNIT_AXIS, circle)
    assert_zero([matrix.det() - 1], UNIT_AXIS, circle)
    rate = [cosine * sp.diff(component, sine) - sine * sp.diff(component, cosine) for component in turned]
    assert_equal(rate, cross(axis, turned), UNIT_AXIS)


def test_equation_3_is_equation_2():
    sine, cosine = real("S C")
    across = cross(axis, x)
    euler_rodrigues = x + across * sine + cross(axis, across) * (1 - cosine)
    assert_equal(rotation_of_equation_2(sine, cosine), euler_rodrigues, UNIT_AXIS)


def test_product_is_the_one_of_the_paper():
    vector, other = Vector(q[1:]), Vector(p[1:])
    paper = (q[0] * p[0] - dot(vector, other), *(q[0] * other + p[0] * vector + cross(vector, other)))
    assert_equal(quat.product(q, p), paper)


def test_product_is_associative_and_not_commutative():
    assert_equal(quat.product(quat.product(q, p), Q), quat.product(q, quat.product(p, Q)))
    assert tuple(quat.product(quat.pure(FIRST), quat.pure(SECOND))) == (0, 0, 0, 1)
    assert tuple(quat.product(quat.pure(SECOND), quat.pure(FIRST))) == (0, 0, 0, -1)


def test_conjugation_reverses_products():
    assert_equal(quat.conjugate(quat.product(p, q)), quat.product(quat.conjugate(q), quat.conjugate(p)))


def test_norm_is_multiplicative_and_gives_the_inverse():
    assert_zero([quat.norm(quat.product(p, q)) ** 2 - quat.norm(p) ** 2 * quat.norm(q) ** 2])
    assert_equal(quat.product(q, quat.conjugate(q)), (quat.norm(q) ** 2, 0, 0, 0))
    assert_equal(quat.product(quat.conjugate(q), q), (1, 0, 0, 0), UNIT_Q)


def test_symbolic_arrays_give_what_formula_vectors_give():
    assert tuple(quat.product(np.array(p), np.array(q))) == tuple(quat.product(p, q))


def test_theorem_1_the_product_turns_by_the_full_angle():
    c, s = real("c s")
    unit = Vector((c, *(axis * s)))
    half_way = quat.product(unit, quat.pure(x))
    assert_equal(half_way, (-dot(axis, x) * s, *(x * c + cross(axis, x) * s)))
    turned = rotation_of_equation_2(sine=2 * c * s, cosine=c**2 - s**2)
    assert_zero([quat.product(half_way, quat.conjugate(unit))[0]])
    assert_equal(quat.rotate(unit, x), turned, UNIT_AXIS, c**2 + s**2 - 1)


def test_theorem_1_euler_parameters_are_those_of_scipy():
    rng = np.random.default_rng(SEED)
    axes, angles = rng.normal(size=(50, 3)), rng.uniform(0, np.pi, 50)
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    parameters = np.concatenate([np.cos(angles / 2)[:, None], axes * np.sin(angles / 2)[:, None]], axis=-1)
    scipys = attitude.unit_quaternion(Rotation.from_rotvec(axes * angles[:, None]))
    assert np.max(attitude.rotation_angle(parameters, scipys)) < 3e-15
    vectors = rng.normal(size=(50, 3))
    assert np.allclose(
        quat.rotate(parameters, vectors), attitude.rotation(parameters).apply(vectors), rtol=0, atol=1e-14
    )


def test_proposition_1_rate_of_a_rotated_vector():
    rate, turned = q_dot(), quat.rotate(q, x)
    velocity = [dot(gradient(component, q), rate) for component in turned]
    assert_equal(velocity, cross(attitude.omega_space(q, rate), turned), UNIT_Q)


def test_proposition_1_difference_of_a_product_and_its_conjugate():
    a, b = Vector(p[1:]), Vector(q[1:])
    difference = quat.product(p, q) - quat.product(quat.conjugate(q), quat.conjugate(p))
    assert_equal(difference, (0, *(2 * (p[0] * b + q[0] * a + cross(a, b)))))


def test_matrix_of_section_2_is_the_paper_matrix():
    p0, p1, p2, p3 = p
    printed = [
        [p1**2 - p2**2 - p3**2 + p0**2, 2 * (p1 * p2 + p0 * p3), 2 * (p1 * p3 - p0 * p2)],
        [2 * (p2 * p1 - p3 * p0), p2**2 - p3**2 - p1**2 + p0**2, 2 * (p2 * p3 + p1 * p0)],
        [2 * (p3 * p1 + p2 * p0), 2 * (p3 * p2 - p1 * p0), p3**2 - p1**2 - p2**2 + p0**2],
    ]
    rows = attitude.paper_matrix(p)
    for i, unit in enumerate((FIRST, SECOND, THIRD)):
        assert_equal(rows[i], printed[i])
        assert_equal(rows[i], quat.rotate(p, unit))
        vector = Vector(p[1:])
        assert_equal(rows[i], unit + 2 * p[0] * cross(vector, unit) + 2 * cross(vector, cross(vector, unit)), UNIT_P)


def test_active_matrix_turns_as_the_product_does():
    assert_equal([dot(row, x) for row in attitude.rotation_matrix(q)], quat.rotate(q, x))
    assert_equal(pt.Attitude.from_quaternion(q).to_space(x), quat.rotate(q, x))
    assert_equal(pt.Attitude.from_quaternion(q).to_body(x), quat.rotate(quat.conjugate(q), x))


def test_diagonal_of_the_matrix_gives_the_squares():
    r11, r22, r33 = np.diagonal(attitude.paper_matrix(p))
    squares = (r11 + r22 + r33 + 1, r11 - r22 - r33 + 1, r22 - r33 - r11 + 1, r33 - r11 - r22 + 1)
    assert_equal(squares, [4 * component**2 for component in p], UNIT_P)


@pytest.mark.parametrize("exact_quaternion", [(1, 0, 0, 0), (2, 3, 6, 0), (1, 4, 4, 4), (-1, 2, 2, 4), (0, -3, 0, 4)])
def test_quaternion_from_matrix_inverts_exact_rotations(exact_quaternion):
    integers = np.array(exact_quaternion)
    length = np.sqrt(integers @ integers)
    assert length == int(length)
    found = attitude.quaternion_from_matrix(attitude.rotation_matrix(integers) / length**2)
    assert min(np.max(np.abs(found - sign * integers / length)) for sign in (1, -1)) < 4e-16


# ---------------------------------------------------------------------- Sec. 3: the canonical quaternion variables


def test_proposition_2_equation_4_body_rate():
    rate = q_dot()
    body, space = attitude.omega_body(q, rate), attitude.omega_space(q, rate)
    assert_equal(space, quat.rotate(q, body), UNIT_Q)
    assert_zero([quat.product(quat.conjugate(q), rate)[0]], UNIT_Q)
    for row in attitude.rotation_matrix(q):
        velocity = [dot(gradient(component, q), rate) for component in row]
        assert_equal(velocity, cross(Vector(row), body), UNIT_Q)


def test_kinetic_energy_before_equation_5():
    assert_zero([BODY.kinetic_energy(BODY.angular_momentum(omega)) - dot(omega, MOMENTS * omega) / 2])
    assert_equal(quat.component_product(p, 1 / q[0] * q), [a * b / q[0] for a, b in zip(p, q, strict=True)])


def test_equation_5_kinetic_energy_of_a_rate():
    rate = q_dot()
    turning = quat.product(quat.conjugate(q), rate)
    paper = 2 * quat.dot(turning, quat.component_product(FOUR_MOMENTS, turning))
    momentum = BODY.angular_momentum(attitude.omega_body(q, rate))
    assert_zero([paper - BODY.kinetic_energy(momentum)], UNIT_Q)


def test_proposition_3_gradient_of_the_quadratic_form():
    def form(a, b):
        return quat.dot(quat.product(a, b), quat.component_product(FOUR_MOMENTS, quat.product(a, b)))

    weighted = quat.component_product(FOUR_MOMENTS, quat.product(p, q))
    assert_equal(gradient(form(p, q), q), 2 * quat.product(quat.conjugate(p), weighted))
    assert_equal(gradient(form(p, q), p), 2 * quat.product(weighted, quat.conjugate(q)))


def test_conjugate_momentum_is_the_gradient_of_equation_5_and_2qg():
    rate = real("d:4")
    turning = quat.product(quat.conjugate(q), rate)
    kinetic_energy = 2 * quat.dot(turning, quat.component_product(FOUR_MOMENTS, turning))
    momentum = gradient(kinetic_energy, rate)
    assert_equal(momentum, 4 * quat.product(q, quat.component_product(FOUR_MOMENTS, turning)))
    # With q' = q (0, omega)/2 it is what Body.state builds, 2 q (0, I omega), whatever I0.
    tangent = dict(zip(rate, quat.product(q, quat.pure(omega)) / 2, strict=True))
    shipped_momentum = 2 * quat.product(q, quat.pure(BODY.angular_momentum(omega)))
    assert_equal([component.subs(tangent) for component in momentum], shipped_momentum, UNIT_Q)


def test_body_state_has_the_conjugate_momentum_of_section_3():
    rng = np.random.default_rng(SEED)
    moments, attitudes, rates = np.array([1.25, 1.0, 0.75]), random_states(20).quaternion, rng.normal(size=(20, 3))
    rate = quat.product(attitudes, quat.pure(rates)) / 2
    turning = quat.product(quat.conjugate(attitudes), rate)
    paper = 4 * quat.product(attitudes, quat.component_product([7.0, *moments], turning))
    state = pt.Body(moments).state(attitudes, omega_body=rates)
    assert np.max(np.abs(state.conjugate_momenta - paper)) < 1e-14


def test_inverse_of_the_conjugate_momentum():
    momenta = 2 * quat.product(q, quat.pure(g))
    turning = quat.product(quat.conjugate(q), momenta)
    paper = quat.product(q, quat.component_product(Vector(1 / m for m in FOUR_MOMENTS), turning)) / 4
    assert_equal(formulas.rates(FREE, "canonical", [*q, *momenta], 0)[:4], paper, UNIT_Q)
    assert_equal(attitude.omega_body(q, paper), BODY.omega(g), UNIT_Q)


def equation_6(quaternion, momenta, reciprocal_of_I0):
    turning = quat.product(quat.conjugate(quaternion), momenta)
    reciprocals = Vector((reciprocal_of_I0, *(1 / m for m in MOMENTS)))
    return quat.dot(quat.component_product(reciprocals, turning), turning) / 8


def test_equation_6_is_the_shipped_kinetic_energy():
    momentum = shipped("angular_momentum_body", q, Q)
    assert_zero([equation_6(q, Q, 0) - BODY.kinetic_energy(momentum)])
    on_tangent = 2 * quat.product(q, quat.pure(g))
    assert_zero([equation_6(q, on_tangent, 1 / I0) - BODY.kinetic_energy(g)], UNIT_Q)


def test_equation_6_second_form_and_its_counterpart_after_equation_17():
    turning = quat.product(quat.conjugate(Q), q)
    reciprocals = Vector(1 / m for m in FOUR_MOMENTS)
    second = quat.dot(quat.component_product(reciprocals, turning), turning) / 8
    assert_zero([equation_6(q, Q, 1 / I0) - second])


def equation_7(force):
    """Return the right-hand sides of (7) with I0^-1 = 0 and a given -dU/dq."""
    reciprocals = Vector((0, *(1 / m for m in MOMENTS)))
    turning = quat.component_product(reciprocals, quat.product(quat.conjugate(q), Q))
    returning = quat.component_product(reciprocals, quat.product(quat.conjugate(Q), q))
    return [*(quat.product(q, turning) / 4), *(force - quat.product(Q, returning) / 4)]


def test_equation_7_is_hamiltonian_in_the_shipped_kinetic_energy():
    kinetic_energy = BODY.kinetic_energy(shipped("angular_momentum_body", q, Q))
    hamiltonian = [*gradient(kinetic_energy, Q), *(-gradient(kinetic_energy, q))]
    assert_equal(hamiltonian, equation_7(Vector((0, 0, 0, 0))))
    assert_equal(hamiltonian, formulas.rates(FREE, "canonical", [*q, *Q], 0))


@SYSTEMS
def test_equation_7_with_the_tangent_part_of_the_force_is_canonical(system):
    slope = gradient(formulas.potential(system, q, 0), q)
    tangent_force = quat.dot(q, slope) * q - slope
    assert_equal(formulas.rates(system, "canonical", [*q, *Q], 0), equation_7(tangent_force), UNIT_Q)


@SYSTEMS
def test_equation_7_in_angular_momentum_is_lie_poisson(system):
    slope = gradient(formulas.potential(system, q, 0), q)
    torque = -quat.imaginary(quat.product(quat.conjugate(q), slope)) / 2
    momentum_rate = cross(g, g / MOMENTS) + torque
    attitude_rate = quat.product(q, quat.pure(g / MOMENTS)) / 2
    assert_equal(formulas.rates(system, "lie_poisson", [*q, *g], 0), [*attitude_rate, *momentum_rate], UNIT_Q)


# ---------------------------------------------------------------------- Sec. 4: Euler's angles


def test_the_twelve_sequences_of_section_4():
    symmetric = ["121", "131", "232", "212", "313", "323"]
    asymmetric = ["123", "132", "231", "213", "312", "321"]
    assert sorted(euler.SEQUENCES) == sorted(symmetric + asymmetric)


def body_axes_in_space():
    return [Vector(column) for column in np.asarray(euler.rotation_matrix_from_angles(ANGLES)).T]


def test_angles_of_section_4_from_node_and_inclination():
    b1, _, b3 = body_axes_in_space()
    node = sp.cos(phi) * FIRST + sp.sin(phi) * SECOND
    assert_trigonometric([dot(THIRD, b3)], [sp.cos(theta)])
    assert_trigonometric(cross(THIRD, b3), node * sp.sin(theta))
    assert_trigonometric(b1, node * sp.cos(psi) + cross(b3, node) * sp.sin(psi))


def test_composition_of_three_rotations_is_the_matrix_of_the_angles():
    node = sp.cos(phi) * FIRST + sp.sin(phi) * SECOND
    _, _, b3 = body_axes_in_space()
    turns = [
        Vector((sp.cos(angle / 2), *(about * sp.sin(angle / 2))))
        for angle, about in ((phi, THIRD), (theta, node), (psi, b3))
    ]
    composed = quat.product(turns[2], quat.product(turns[1], turns[0]))
    assert_trigonometric(composed, euler.quaternion_from_angles(ANGLES))


@pytest.mark.parametrize("sequence", euler.SEQUENCES)
def test_angles_turn_vectors_as_their_quaternion_does(sequence):
    matrix = euler.rotation_matrix_from_angles(ANGLES, sequence)
    of_quaternion = attitude.rotation_matrix(euler.quaternion_from_angles(ANGLES, sequence))
    assert_trigonometric(matrix.ravel(), of_quaternion.ravel())


def test_momenta_of_section_4_are_projections_of_the_angular_momentum():
    space = Vector(dot(row, g) for row in euler.rotation_matrix_from_angles(ANGLES))
    node = sp.cos(phi) * FIRST + sp.sin(phi) * SECOND
    projections = (dot(space, THIRD), dot(space, node), g[2])
    assert_trigonometric(euler.momenta_from_angular_momentum(ANGLES, g), projections)


@pytest.mark.parametrize("sequence", euler.SEQUENCES)
def test_momenta_are_conjugate_to_their_angles(sequence):
    # dT = g . domega for a kinetic energy T(omega), so that dT/d(rate) is the gradient of g . omega at fixed g.
    rates = real("rate1:4")
    parameters = euler.quaternion_from_angles(ANGLES, sequence)
    parameter_rates = Vector(dot(gradient(component, ANGLES), rates) for component in parameters)
    conjugate = gradient(dot(g, attitude.omega_body(parameters, parameter_rates)), rates)
    assert_trigonometric(euler.momenta_from_angular_momentum(ANGLES, g, sequence), conjugate)


def equation_8():
    across = (Phi - Psi * sp.cos(theta)) / sp.sin(theta)
    return Vector(
        (across * sp.sin(psi) + Theta * sp.cos(psi), across * sp.cos(psi) - Theta * sp.sin(psi), Psi),
    )


def test_equation_8_angular_momentum_from_the_momenta():
    assert_trigonometric(euler.angular_momentum_from_momenta(ANGLES, MOMENTA), equation_8())


@pytest.mark.parametrize("sequence", euler.SEQUENCES)
def test_equation_8_in_every_sequence_inverts_the_projections(sequence):
    momenta = euler.momenta_from_angular_momentum(ANGLES, g, sequence)
    assert_trigonometric(euler.angular_momentum_from_momenta(ANGLES, momenta, sequence), g)


def test_equation_9_kinetic_energy_of_an_angular_momentum():
    (g1, g2, g3), (I1, I2, I3) = g, MOMENTS
    assert_zero([BODY.kinetic_energy(g) - (g1**2 / I1 + g2**2 / I2 + g3**2 / I3) / 2])


def equation_10():
    """The kinetic part of (10), with Psi^2 / I3."""
    I1, I2, I3 = MOMENTS
    across = (Phi - Psi * sp.cos(theta)) / sp.sin(theta)
    return (
        (sp.sin(psi) ** 2 / I1 + sp.cos(psi) ** 2 / I2) * across**2 / 2
        + Psi**2 / I3 / 2
        + (sp.cos(psi) ** 2 / I1 + sp.sin(psi) ** 2 / I2) * Theta**2 / 2
        + (1 / I1 - 1 / I2) * across * Theta * sp.sin(psi) * sp.cos(psi)
    )


def test_equation_10_is_equation_9_in_the_momenta():
    momentum = euler.angular_momentum_from_momenta(ANGLES, MOMENTA)
    assert_trigonometric([BODY.kinetic_energy(momentum)], [equation_10()])


def test_equation_10_has_the_shipped_equations_of_motion():
    paper = [*gradient(equation_10(), MOMENTA), *(-gradient(equation_10(), ANGLES))]
    assert_trigonometric(formulas.rates(FREE, "euler_angles", [*ANGLES, *MOMENTA], 0), paper)


@pytest.mark.parametrize("system", [TOP, SATELLITE], ids=["top", "satellite"])
def test_potential_of_equation_10_adds_its_gradient_to_the_shipped_equations(system):
    orientation = pt.Attitude(euler.rotation_matrix_from_angles(ANGLES))
    potential = system.dynamics.potential_at(pt.Instant(system.body, orientation, pt.mechanics.Environment(0)))
    rates, free = (formulas.rates(s, "euler_angles", [*ANGLES, *MOMENTA], 0) for s in (system, FREE))
    assert_trigonometric([a - b for a, b in zip(rates, free, strict=True)], [0, 0, 0, *(-gradient(potential, ANGLES))])


# ---------------------------------------------------------------------- Sec. 5: from three angles to four parameters


def equation_12():
    half_sum, half_difference = (phi + psi) / 2, (phi - psi) / 2
    return Vector(
        (
            sp.cos(theta / 2) * sp.cos(half_sum),
            sp.sin(theta / 2) * sp.cos(half_difference),
            sp.sin(theta / 2) * sp.sin(half_difference),
            sp.cos(theta / 2) * sp.sin(half_sum),
        )
    )


def equation_14():
    half_sum, half_difference = (phi + psi) / 2, (phi - psi) / 2
    c, s = sp.cos(theta / 2), sp.sin(theta / 2)
    return Vector(
        (
            -(Phi + Psi) * sp.sin(half_sum) / c - 2 * Theta * s * sp.cos(half_sum),
            -(Phi - Psi) * sp.sin(half_difference) / s + 2 * Theta * c * sp.cos(half_difference),
            (Phi - Psi) * sp.cos(half_difference) / s + 2 * Theta * c * sp.sin(half_difference),
            (Phi + Psi) * sp.cos(half_sum) / c - 2 * Theta * s * sp.sin(half_sum),
        )
    )


def equation_15(parameters, momenta):
    p0, p1, p2, p3 = parameters
    P0, P1, P2, P3 = momenta
    near, far = (p0**2 + p3**2) ** 0.5, (p1**2 + p2**2) ** 0.5
    return (
        (-p3 * P0 - p2 * P1 + p1 * P2 + p0 * P3) / 2,
        (-p0 * P0 + p1 * P1 + p2 * P2 - p3 * P3) / (4 * far * near),
        (-p3 * P0 + p2 * P1 - p1 * P2 + p0 * P3) / 2,
    )


def shipped_parameters_and_momenta():
    """Return q and Q as `State.from_euler` makes them, on symbols."""
    parameters = euler.quaternion_from_angles(ANGLES)
    momentum = euler.angular_momentum_from_momenta(ANGLES, MOMENTA)
    return parameters, 2 * quat.product(parameters, quat.pure(momentum))


TANGENTS_OF_QUARTER_ANGLES = [("1/2", "1/3", "-2/5"), ("3", "2/7", "5/2"), ("-4/3", "3/5", "1/4")]


@pytest.mark.parametrize("tangents", TANGENTS_OF_QUARTER_ANGLES)
def test_section_5_brackets_of_the_four_parameters_are_those_of_the_sphere(tangents):
    parameters, momenta = shipped_parameters_and_momenta()
    place = dict(zip(MOMENTA, map(sp.Rational, ("2/3", "-5/7", "3/2")), strict=True))
    for angle, half, t in zip(ANGLES, HALVES, map(sp.Rational, tangents), strict=True):
        place |= {sp.cos(half): (1 - t**2) / (1 + t**2), sp.sin(half): 2 * t / (1 + t**2), angle: 2 * half}

    def value(expression):
        return sp.expand_trig(exact(expression).subs({angle: place[angle] for angle in ANGLES})).subs(place)

    to_parameters, to_momenta = (
        (sp.Matrix(variables).jacobian([*ANGLES, *MOMENTA]).applyfunc(value)) for variables in (parameters, momenta)
    )
    p_, P_ = (sp.Matrix(variables).applyfunc(value) for variables in (parameters, momenta))
    symplectic = sp.Matrix(sp.BlockMatrix([[sp.zeros(3), sp.eye(3)], [-sp.eye(3), sp.zeros(3)]]))
    assert to_parameters * symplectic * to_parameters.T == sp.zeros(4)
    assert to_parameters * symplectic * to_momenta.T == sp.eye(4) - p_ * p_.T
    assert to_momenta * symplectic * to_momenta.T == P_ * p_.T - p_ * P_.T


def test_equation_11_with_equation_13_gives_equation_14():
    p0, p1, p2, p3 = p
    far, near = sp.sqrt(p1**2 + p2**2), sp.sqrt(p0**2 + p3**2)
    equation_13 = (
        sp.atan2(p1 * p3 + p0 * p2, p0 * p1 - p2 * p3),
        2 * sp.atan2(far, near),
        sp.atan2(p1 * p3 - p0 * p2, p0 * p1 + p2 * p3),
    )
    halves = {far: sp.sin(theta / 2), near: sp.cos(theta / 2)}  # on the sphere
    values = dict(zip(p, equation_12(), strict=True))
    lifted = [
        sum(
            sp.factor(sp.diff(angle, parameter)) * momentum
            for angle, momentum in zip(equation_13, MOMENTA, strict=True)
        )
        for parameter in p
    ]
    lifted = [component.subs(halves).subs(values) for component in lifted]
    assert_trigonometric(lifted, equation_14())


def test_equation_12_is_the_quaternion_of_the_angles():
    assert_trigonometric(euler.quaternion_from_angles(ANGLES), equation_12())


def test_equation_13_and_the_cosine_sine_pairs_give_the_shipped_angles():
    state = random_states(200)
    p0, p1, p2, p3 = state.quaternion.T
    root = np.sqrt((p1**2 + p2**2) * (p0**2 + p3**2))
    pairs = [
        ((p0 * p1 - p2 * p3) / root, (p1 * p3 + p0 * p2) / root),
        (p0**2 + p3**2 - p1**2 - p2**2, 2 * root),
        ((p0 * p1 + p2 * p3) / root, (p1 * p3 - p0 * p2) / root),
    ]
    angles = euler.angles_from_quaternion(state.quaternion)
    for (cosine, sine), angle in zip(pairs, angles.T, strict=True):
        assert np.max(np.hypot(np.cos(angle) - cosine, np.sin(angle) - sine)) < 1e-14
    assert np.max(np.abs(np.tan(angles[:, 1] / 2) * np.hypot(p0, p3) - np.hypot(p1, p2))) < 3e-15
    assert np.max(np.abs(euler.quaternion_from_angles(angles) - state.quaternion)) < 3e-15


def test_equation_14_is_the_momentum_of_from_euler():
    _, momenta = shipped_parameters_and_momenta()
    assert_trigonometric(momenta, equation_14())


def test_equations_12_and_14_in_numbers_are_from_euler():
    rng = np.random.default_rng(SEED)
    angles = np.column_stack([rng.uniform(0, 4 * np.pi, 40), rng.uniform(0.2, 2.9, 40), rng.uniform(0, 2 * np.pi, 40)])
    momenta = rng.normal(size=(40, 3))
    variables = (*ANGLES, *MOMENTA)
    paper = sp.lambdify(variables, [*equation_12(), *equation_14()])(*angles.T, *momenta.T)
    state = pt.State.from_euler(angles, momenta)
    assert np.max(np.abs(np.array(paper).T - np.hstack([state.quaternion, state.conjugate_momenta]))) < 4e-14


def test_combinations_of_equations_12_and_14():
    (p0, p1, p2, p3), (P0, P1, P2, P3) = shipped_parameters_and_momenta()
    paper = (p0 * P3 - p3 * P0, p1 * P2 - p2 * P1, p1 * P1 + p2 * P2)
    assert_trigonometric(paper, (Phi + Psi, Phi - Psi, Theta * sp.sin(theta)))


def test_equation_15_on_the_sphere_is_the_shipped_projection():
    parameters, momenta = shipped_parameters_and_momenta()
    momentum = shipped("angular_momentum_body", parameters, momenta)
    assert_trigonometric(euler.momenta_from_angular_momentum(ANGLES, momentum), MOMENTA)
    state = random_states(200)
    printed = np.array(equation_15(state.quaternion.T, state.conjugate_momenta.T)).T
    angles, found = state.euler()
    assert np.max(np.abs(found - printed) * np.sin(angles[:, 1:2])) < 1e-14


def test_bilinear_angular_momentum_after_equation_15():
    p0, p1, p2, p3 = p
    P0, P1, P2, P3 = P
    printed = (
        (-p1 * P0 + p0 * P1 + p3 * P2 - p2 * P3) / 2,
        (-p2 * P0 - p3 * P1 + p0 * P2 + p1 * P3) / 2,
        (-p3 * P0 + p2 * P1 - p1 * P2 + p0 * P3) / 2,
    )
    assert_equal(shipped("angular_momentum_body", p, P), printed)


def test_equation_16_and_the_tangent_condition():
    parameters, momenta = shipped_parameters_and_momenta()
    assert_trigonometric([quat.dot(parameters, parameters), quat.dot(parameters, momenta)], [1, 0])


def test_equation_17_angular_momentum_in_the_body():
    half = quat.product(quat.conjugate(p), P) / 2
    assert_equal(half[1:], shipped("angular_momentum_body", p, P))
    assert_zero([2 * half[0] - TANGENT_P])
    parameters, momenta = shipped_parameters_and_momenta()
    assert_trigonometric(shipped("angular_momentum_body", parameters, momenta), equation_8())


def test_angular_momentum_in_space_after_equation_17():
    p0, p1, p2, p3 = p
    P0, P1, P2, P3 = P
    printed = (
        (-p1 * P0 + p0 * P1 - p3 * P2 + p2 * P3) / 2,
        (-p2 * P0 + p3 * P1 + p0 * P2 - p1 * P3) / 2,
        (-p3 * P0 - p2 * P1 + p1 * P2 + p0 * P3) / 2,
    )
    space = shipped("angular_momentum_space", p, P)
    assert_equal(space, printed)
    assert_equal(space, quat.rotate(p, shipped("angular_momentum_body", p, P)), UNIT_P)


def test_both_sets_of_momenta_are_the_same():
    # Q of Sec. 3 for a rate, and P of Sec. 5 for the angular momentum of that rate.
    parameters, momenta = shipped_parameters_and_momenta()
    rate = quat.product(parameters, quat.pure(BODY.omega(equation_8()))) / 2
    turning = quat.product(quat.conjugate(parameters), rate)
    of_section_3 = 4 * quat.product(parameters, quat.component_product(FOUR_MOMENTS, turning))
    assert_trigonometric(of_section_3, momenta)


# ---------------------------------------------------------------------- Sec. 6: applications


def test_gravity_of_section_6_in_body_axes():
    q0, q1, q2, q3 = q
    printed = (2 * (q1 * q3 - q0 * q2), 2 * (q0 * q1 + q2 * q3), q0**2 - q1**2 - q2**2 + q3**2)
    force = pt.Attitude.from_quaternion(q).to_body(-weight * THIRD)
    assert_equal(force, [-weight * component for component in printed])
    assert_equal(force, quat.rotate(quat.conjugate(q), -weight * THIRD))


def test_equation_18_energy_of_the_top_is_minus_the_work_of_gravity():
    force = pt.Attitude.from_quaternion(q).to_body(-weight * THIRD)
    assert_zero([formulas.potential(TOP, q, 0) + dot(centre, force)])


def test_equation_18_torque_of_the_top_is_that_of_its_weight():
    orientation = pt.Attitude.from_quaternion(q)
    force = orientation.to_body(-weight * THIRD)
    assert_equal(
        TOP.dynamics.torque_at(pt.Instant(TOP.body, orientation, pt.mechanics.Environment(0), omega)),
        cross(centre, force),
    )


def test_initial_state_of_section_6():
    printed = pt.State((0.5, -1 / ROOT, 0, 0.5), (0.3, -0.6 * ROOT, 0.1 * ROOT, -1.5))
    angles = pt.State.from_euler((np.pi / 4, -np.pi / 2, np.pi / 4), (-0.5, -0.6, -0.4))
    assert np.max(np.abs(printed.quaternion - angles.quaternion)) < 1e-15
    assert np.max(np.abs(printed.conjugate_momenta - angles.conjugate_momenta)) < 1e-14
    energy = pt.System(pt.Body((1.25, 1, 0.75))).energy(printed)
    assert abs(energy - 2467 / 6000) < 1e-15


def test_equation_19_differs_from_the_shipped_energy_by_what_the_attitude_does_not_change():
    mass = sp.Symbol("mass", positive=True)
    moment = BODY.moment_about(pt.Attitude.from_quaternion(q).to_body(x / norm(x)))
    maccullagh = -mu * (mass / distance + (sum(MOMENTS) - 3 * moment) / (2 * distance**3))
    difference = sp.expand(exact(maccullagh - formulas.potential(SATELLITE, q, 0)))
    assert not difference.has(*q)


def test_equation_19_is_the_limit_of_point_masses_far_away():
    # Eight masses at the corners of a box: the next term is (size / distance)^2 smaller.
    corners = np.array([(i, 2 * j, 3 * k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
    body = pt.Body.from_point_masses(np.ones(8), corners)
    place = (2e5, 3e5, 6e5)
    gradient_of_gravity = pt.System(body, pt.GravityGradient(pt.orbits.FixedPosition(1.0, position=place)))
    quaternions = [Vector(mpmath.mpf(k) / 7 for k in whole) for whole in ((2, 3, 6, 0), (0, -2, 3, 6))]

    def point_masses(quaternion):
        return -sum(1 / norm(Vector(place) + quat.rotate(quaternion, Vector(corner))) for corner in corners)

    with mpmath.workdps(50):
        exact_symbolic = formulas.copied(
            gradient_of_gravity, map(mpmath.mpf, map(float, gradient_of_gravity.dynamics.numbers))
        )
        shipped_difference, exact_difference = (
            energy(quaternions[0]) - energy(quaternions[1])
            for energy in (lambda quaternion: formulas.potential(exact_symbolic, quaternion, 0), point_masses)
        )
        assert abs(shipped_difference / exact_difference - 1) < 1e-9


def test_moment_about_the_radius_does_not_need_the_fourth_moment():
    radial = quat.product(quat.product(quat.conjugate(q), quat.pure(x)), q)
    paper = quat.dot(radial, quat.component_product(FOUR_MOMENTS, radial))
    assert_zero([paper - BODY.moment_about(pt.Attitude.from_quaternion(q).to_body(x))])


def test_orbital_quaternion_is_equation_12_of_node_inclination_and_latitude():
    latitude = PERIGEE + 0.7
    half_sum, half_difference = (NODE + latitude) / 2, (NODE - latitude) / 2
    c, s = np.cos(INCLINATION / 2), np.sin(INCLINATION / 2)
    orbital = np.array(
        [c * np.cos(half_sum), s * np.cos(half_difference), s * np.sin(half_difference), c * np.sin(half_sum)]
    )
    epoch = 12.5
    orbit = pt.KeplerOrbit(
        GM,
        semimajor_axis=SEMIMAJOR_AXIS,
        eccentricity=ECCENTRICITY,
        inclination=INCLINATION,
        node=NODE,
        argument_of_periapsis=PERIGEE,
        true_anomaly=0.7,
        epoch=epoch,
    )
    place = np.array(orbit.position_at(epoch))
    radial = place / np.linalg.norm(place)
    assert np.max(np.abs(quat.rotate(orbital, [1.0, 0, 0]) - radial)) < 1e-15
    assert attitude.rotation_angle(orbital, orbit.frame.quaternion(epoch)) < 1e-15
    radius = SEMIMAJOR_AXIS * (1 - ECCENTRICITY**2) / (1 + ECCENTRICITY * np.cos(0.7))
    assert abs(np.linalg.norm(place) / radius - 1) < 1e-15


@pytest.mark.parametrize("revolutions", [0.1, 0.37, 1.8])
def test_orbital_quaternion_along_the_ellipse(revolutions):
    # The time from df/dt = h / r^2, by quadrature and not by Kepler's equation.
    time = revolutions * float(ORBIT.period)
    place = np.array(ORBIT.position_at(time))
    radial = place / np.linalg.norm(place)
    along = quat.rotate(quat.conjugate(euler.quaternion_from_angles([NODE, INCLINATION, PERIGEE])), radial)
    anomaly = np.arctan2(along[1], along[0]) % (2 * np.pi)
    e, turns = ECCENTRICITY, np.floor(revolutions)
    area = mpmath.quad(lambda f: (1 - e**2) ** 1.5 / (1 + e * mpmath.cos(f)) ** 2, [0, anomaly])
    assert abs(float(area) / (2 * np.pi) + turns - revolutions) < 1e-14
    assert abs(along[2]) < 1e-15


def test_equation_20_is_the_shipped_energy_along_the_orbit():
    moments, time = np.array([400.0, 500, 600]), 1234.5
    system = pt.System(pt.Body(moments), pt.GravityGradient(ORBIT))
    state = random_states(30)
    space = quat.rotate(ORBIT.frame.quaternion(time), [1.0, 0, 0])
    radial = quat.rotate(quat.conjugate(state.quaternion), space)
    paper = (
        3
        * GM
        / (2 * np.linalg.norm(ORBIT.position_at(time)) ** 3)
        * quat.dot(radial, quat.component_product(moments, radial))
    )
    energy = system.potential_energy(pt.State(state.quaternion, state.conjugate_momenta, time))
    assert np.max(np.abs(energy / paper - 1)) < 1e-14


def test_equation_20_energy_and_torque_on_symbols():
    radial = quat.rotate(quat.conjugate(q), x) / distance
    assert_zero([formulas.potential(SATELLITE, q, 0) - 3 * mu / (2 * distance**3) * dot(radial, MOMENTS * radial)])
    torque = formulas.torque(SATELLITE, q, omega)
    assert_equal(torque, 3 * mu / distance**3 * cross(radial, MOMENTS * radial))


def test_motion_of_section_6_2_multiplies_small_changes():
    # About 4e2-fold in ten periods and 8e4-fold in twenty, for the worst change of the attitude.
    system = pt.System(pt.Body((400, 500, 600)), pt.GravityGradient(ORBIT))
    start, change = np.array([0.5, -1 / ROOT, 0, 0.5]), 1e-9
    momentum = pt.State(start, (0.3, -0.6 * ROOT, 0.1 * ROOT, -1.5)).angular_momentum_body
    turned = [start] + [quat.product(start, [1, *(change / 2 * unit)]) for unit in np.eye(3)]
    states = [system.body.state(attitude_, angular_momentum_body=momentum) for attitude_ in turned]
    times = np.array([0, 10, 20]) * float(ORBIT.period)
    motion, *others = (pt.propagate(system, state, times).quaternion for state in states)
    growth = np.linalg.norm([attitude.rotation_angle(motion, other) / change for other in others], axis=0)
    assert np.allclose(growth[0], np.sqrt(3), rtol=1e-6, atol=0)
    assert 2e2 < growth[1] < 8e2
    assert 4e4 < growth[2] < 1.6e5
