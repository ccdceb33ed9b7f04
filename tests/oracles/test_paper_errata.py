"""The paper's errata E1 to E15: what is printed fails, and what ships holds (docs/paper.md)."""

import functools
import itertools
import json
import pkgutil
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import formulas
import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector, cross, dot
from poinsot.kinematics import attitude, euler
from poinsot.kinematics.state import State

REFERENCE = json.loads((Path(__file__).parent / "paper_cases.json").read_text())


def real(names):
    return Vector(sp.symbols(names, real=True))


def gradient(scalar, variables):
    return Vector(sp.diff(scalar, variable) for variable in variables)


def simplest(expression):
    return sp.expand(sp.numer(sp.together(formulas.rational(expression))))


def is_zero(expressions, *constraints):
    """Whether each expression vanishes identically, or where the polynomial constraint does."""
    rests = (simplest(expression) for expression in expressions)
    return all(rest == 0 or (constraints and sp.reduced(rest, constraints)[1] == 0) for rest in rests)


def are_equal(left, right, *constraints):
    return is_zero([a - b for a, b in zip(left, right, strict=True)], *constraints)


def shipped_momentum(quaternion, momenta):
    """Return g of a `State`, run on symbols."""
    return State.computed({"quaternion": quaternion, "conjugate_momenta": momenta}, 0.0).angular_momentum_body


def printed_dot(a, b):
    return quat.product(a, b)[0]


q, Q = real("q:4"), real("Q:4")
UNIT = quat.dot(q, q) - 1
ANGLES, MOMENTA = real("phi theta psi"), real("Phi Theta Psi")
x, omega, centre = real("x1:4"), real("omega1:4"), real("c1:4")
I0, weight, mu = sp.symbols("I0 weight mu", positive=True)
MOMENTS = Vector(sp.symbols("I1:4", positive=True))
FREE = formulas.copied(pt.System(pt.Body((1, 1, 1))), MOMENTS)
TOP = formulas.copied(pt.System(pt.Body((1, 1, 1)), pt.UniformGravity(1, (1, 0, 0))), (*MOMENTS, weight, *centre))
SATELLITE = formulas.copied(
    pt.System(pt.Body((1, 1, 1)), pt.GravityGradient(pt.orbits.FixedPosition(1, position=(1, 0, 0)))),
    (*MOMENTS, *x, mu),
)

ROOT = np.sqrt(2.0)
PAPER_MOMENTS = (1.25, 1.0, 0.75)
BODY = pt.Body(PAPER_MOMENTS)
FREE_BODY = pt.System(BODY)
PAPER_TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)))
PRINTED = pt.State((0.5, -1 / ROOT, 0, 0.5), (0.3, -0.6 * ROOT, 0.1 * ROOT, -1.5))
PRINTED_ANGLES, PRINTED_MOMENTA = (np.pi / 4, 3 * np.pi / 2, np.pi / 4), (0.5, 0.6, 0.4)
EULER = pt.State.from_euler(PRINTED_ANGLES, PRINTED_MOMENTA)
ORBIT = pt.KeplerOrbit(
    398600.4418,
    semimajor_axis=7000,
    eccentricity=0.2,
    inclination=np.pi / 6,
    node=np.pi / 4,
    argument_of_periapsis=np.pi / 12,
)
KEPLER_BODY = pt.Body((400, 500, 600))
KEPLER = pt.System(KEPLER_BODY, pt.GravityGradient(ORBIT))
NUMBERS = dict(zip(MOMENTS, map(sp.Rational, ("5/4", "1", "3/4")), strict=True)) | {
    weight: sp.Rational(1, 2),
    **dict(zip(centre, (1, 0, 0), strict=True)),
}


def flow(equations, variables, start, times, event=None):
    """Integrate equations as they are printed, with no function of the package at work."""
    rates = sp.lambdify([tuple(variables)], [rate.xreplace(NUMBERS) for rate in equations], cse=True)
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    return solve_ivp(lambda _, y: rates(y), (0, times[-1]), start, t_eval=times, events=event, **options)


def hamiltonian_flow(energy, positions, momenta):
    return [*gradient(energy, momenta), *(-gradient(energy, positions))]


def equation_6(reciprocal_of_I0):
    turning = quat.product(quat.conjugate(q), Q)
    return quat.dot(quat.component_product(Vector((reciprocal_of_I0, *(1 / m for m in MOMENTS))), turning), turning) / 8


def literal_equation_7(system, reciprocal_of_I0):
    """Return the right-hand sides of (7) as printed: q' and Q' with the whole gradient of U."""
    energy = equation_6(reciprocal_of_I0) + formulas.potential(system, q, 0)
    return Vector(sp.diff(energy, variable) for variable in Q), -gradient(energy, q)


def equation_10(third_term):
    _, theta, psi = ANGLES
    Phi, Theta, Psi = MOMENTA
    I1, I2, _ = MOMENTS
    across = (Phi - Psi * sp.cos(theta)) / sp.sin(theta)
    return (
        (sp.sin(psi) ** 2 / I1 + sp.cos(psi) ** 2 / I2) * across**2 / 2
        + third_term
        + (sp.cos(psi) ** 2 / I1 + sp.sin(psi) ** 2 / I2) * Theta**2 / 2
        + (1 / I1 - 1 / I2) * across * Theta * sp.sin(psi) * sp.cos(psi)
    )


def phase(state):
    return [*state.quaternion, *state.conjugate_momenta]


def attitude_error(quaternions, system, start, times):
    unit = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
    return attitude.rotation_angle(unit, pt.propagate(system, start, times).quaternion)


def exact_phase(state):
    """Return the initial data of Sec. 6.1 with exact square roots, checked against the given state."""
    root = sp.sqrt(2)
    quaternion = Vector((sp.Rational(1, 2), -1 / root, sp.Integer(0), sp.Rational(1, 2)))
    momenta = Vector((sp.Rational(3, 10), -3 * root / 5, root / 10, -sp.Rational(3, 2)))
    assert np.allclose([float(v) for v in (*quaternion, *momenta)], phase(state), rtol=0, atol=1e-15)
    return quaternion, momenta


# ---------------------------------------------------------------------- E1: the dot product


def test_E1_the_printed_dot_product_makes_the_kinetic_energy_negative():
    quaternion, momenta = exact_phase(PRINTED)
    turning = quat.product(quat.conjugate(quaternion), momenta)
    weighted = quat.component_product(Vector((0, *(1 / NUMBERS[m] for m in MOMENTS))), turning)
    assert sp.nsimplify(printed_dot(weighted, turning) / 8) == -sp.Rational(2467, 6000)
    assert sp.nsimplify(quat.dot(weighted, turning) / 8) == sp.Rational(2467, 6000)
    assert abs(FREE_BODY.kinetic_energy(PRINTED) - 2467 / 6000) < 1e-15


def test_E1_proposition_3_needs_the_euclidean_dot_product():
    weights, other = Vector((I0, *MOMENTS)), real("b:4")
    inner = quat.product(q, other)
    claimed = 2 * quat.product(quat.conjugate(q), quat.component_product(weights, inner))
    euclidean, printed = (form(inner, quat.component_product(weights, inner)) for form in (quat.dot, printed_dot))
    assert are_equal(gradient(euclidean, other), claimed)
    assert not are_equal(gradient(printed, other), claimed)
    mixed = quat.component_product(Vector((I0, *(-MOMENTS))), inner)
    assert are_equal(gradient(printed, other), 2 * quat.product(quat.conjugate(q), mixed))


def test_E1_the_euclidean_dot_product_is_the_real_part_of_p_times_q_conjugate():
    other = real("b:4")
    assert is_zero([quat.dot(q, other) - quat.product(q, quat.conjugate(other))[0]])
    assert not is_zero([quat.dot(q, other) - printed_dot(q, other)])


# ---------------------------------------------------------------------- E2: the matrix


def test_E2_the_printed_matrix_turns_the_other_way():
    quarter_turn = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    first = np.array([1.0, 0, 0])
    assert np.allclose(quat.rotate(quarter_turn, first), [0, 1, 0], rtol=0, atol=1e-15)
    assert np.allclose(attitude.rotation_matrix(quarter_turn) @ first, [0, 1, 0], rtol=0, atol=1e-15)
    assert np.allclose(attitude.paper_matrix(quarter_turn) @ first, [0, -1, 0], rtol=0, atol=1e-15)


def test_E2_the_printed_matrix_is_that_of_the_inverse_operator():
    printed = [dot(row, x) for row in attitude.paper_matrix(q)]
    assert are_equal(printed, quat.rotate(quat.conjugate(q), x))
    assert not are_equal(printed, quat.rotate(q, x), UNIT)


def test_E2_the_printed_matrix_misplaces_the_satellite_of_section_6_2():
    orbital = euler.quaternion_from_angles([ORBIT.node, ORBIT.inclination, ORBIT.argument_of_periapsis])
    radial = np.array(ORBIT.position_at(0.0)) / np.linalg.norm(ORBIT.position_at(0.0))
    assert np.allclose(attitude.rotation_matrix(orbital)[:, 0], radial, rtol=0, atol=1e-15)
    assert np.allclose(radial, [0.52451905, 0.84150635, 0.12940952], rtol=0, atol=5e-9)
    misplaced = attitude.paper_matrix(orbital)[:, 0]
    assert np.allclose(misplaced, [0.52451905, -0.77451905, 0.35355339], rtol=0, atol=5e-9)


# ---------------------------------------------------------------------- E3: the angle of proper rotation


def test_E3_the_first_body_axis_lies_in_the_plane_of_the_node_and_its_normal_to_b3():
    rng = np.random.default_rng(3)
    phi, theta, psi = angles = rng.uniform(0, [[2 * np.pi], [np.pi], [2 * np.pi]], (3, 1000))
    b1, _, b3 = np.moveaxis(attitude.rotation_matrix(euler.quaternion_from_angles(angles.T)), -1, 0)
    node = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=-1)
    inclination = np.arccos(b3[:, 2])
    assert np.allclose(inclination, theta, rtol=0, atol=1e-12)

    def error(normal):
        formula = node * np.cos(psi)[:, None] + np.cross(normal, node) * np.sin(psi)[:, None]
        return np.max(np.linalg.norm(formula - b1, axis=-1)), np.max(np.abs(np.sum(formula * b3, axis=-1)))

    assert error(b3)[0] < 2e-15
    assert min(error(np.array([0.0, 0, 1]))) > 0.9


# ---------------------------------------------------------------------- E4: the Hamiltonian in Euler variables

PRINTED_TERM, CORRECTED_TERM = MOMENTA[2] ** 2 / 2, MOMENTA[2] ** 2 / (2 * MOMENTS[2])


def test_E4_value_of_the_hamiltonian_at_the_initial_data():
    values = dict(zip((*ANGLES, *MOMENTA), (*PRINTED_ANGLES, *PRINTED_MOMENTA), strict=True)) | NUMBERS
    printed, corrected = (float(equation_10(term).subs(values)) for term in (PRINTED_TERM, CORRECTED_TERM))
    assert abs(printed - 0.3845) < 1e-15
    assert abs(corrected - 2467 / 6000) < 1e-15
    assert abs(FREE_BODY.kinetic_energy(EULER) - corrected) < 1e-15


def test_E4_flow_of_the_printed_hamiltonian_goes_astray():
    times, start = [1, 2, 3], np.concatenate(EULER.euler())

    def error(term):
        equations = hamiltonian_flow(equation_10(term), ANGLES, MOMENTA)
        angles = flow(equations, (*ANGLES, *MOMENTA), start, times).y[:3]
        return attitude_error(euler.quaternion_from_angles(angles.T), FREE_BODY, EULER, times)

    assert np.allclose(error(PRINTED_TERM), [0.1328, 0.2697, 0.4180], rtol=0, atol=1e-4)
    assert np.max(error(CORRECTED_TERM)) < 1e-12


# ---------------------------------------------------------------------- E5: Hamilton's systems of Sec. 5


def test_E5_angles_move_with_the_gradient_in_the_momenta():
    rates = formulas.rates(FREE, "euler_angles", [*ANGLES, *MOMENTA], 0)
    energy = equation_10(CORRECTED_TERM)
    values = dict(zip((*ANGLES, *MOMENTA), map(sp.Rational, (1, 2, 3, 4, 5, 6)), strict=True)) | NUMBERS

    def differs(gradients):
        return max(abs((a - b).subs(values).evalf()) for a, b in zip(rates, gradients, strict=True))

    assert differs([*gradient(energy, MOMENTA), *(-gradient(energy, ANGLES))]) < 2e-14
    assert differs([*gradient(energy, ANGLES), *(-gradient(energy, ANGLES))]) > 0.1


def test_E5_the_lifted_momenta_move_with_the_gradient_in_the_parameters():
    energy, times = FREE.body.kinetic_energy(shipped_momentum(q, Q)), [1.0]

    def error(variables):
        equations = [*gradient(energy, Q), *(-gradient(energy, variables))]
        return attitude_error(flow(equations, (*q, *Q), phase(EULER), times).y[:4].T, FREE_BODY, EULER, times)[0]

    assert error(q) < 1e-12
    assert abs(error(Q) - 0.1459) < 1e-4


def test_E5_brackets_are_needed_for_all_pairs_of_indices():
    # All brackets with i <= j are as asked for, {p2; P1} is not zero, and the lifted flow is not Hamilton's.
    q1, q2, Q1, Q2 = sp.symbols("q1 q2 Q1 Q2")

    def bracket(f, h):
        return dot(gradient(f, (q1, q2)), gradient(h, (Q1, Q2))) - dot(gradient(f, (Q1, Q2)), gradient(h, (q1, q2)))

    low, high = (q1, q2), (Q1 + 3 * Q2, Q2)
    assert bracket(*low) == bracket(*high) == 0
    assert [bracket(low[i], high[j]) for i, j in ((0, 0), (0, 1), (1, 1))] == [1, 0, 1]
    assert bracket(low[1], high[0]) == 3
    energy = (high[0] ** 2 + high[1] ** 2) / 2
    assert sp.expand(bracket(low[1], energy) - high[1]) != 0


# ---------------------------------------------------------------------- E6: the momentum of the inclination


def far_and_near(quaternion):
    q0, q1, q2, q3 = quaternion
    return sp.sqrt(q1**2 + q2**2), sp.sqrt(q0**2 + q3**2)


def equation_13():
    far, near = far_and_near(q)
    half_sum, half_difference = sp.atan2(q[3], q[0]), sp.atan2(q[2], q[1])
    return Vector((half_sum + half_difference, 2 * sp.atan2(far, near), half_sum - half_difference))


def printed_Theta():
    far, near = far_and_near(q)
    return (-q[0] * Q[0] + q[1] * Q[1] + q[2] * Q[2] - q[3] * Q[3]) / (4 * far * near)


def algebraic(functions_of_the_angles):
    """Return functions of the angles (13) without cosines of arc tangents."""
    return Vector(sp.nsimplify(sp.expand_trig(f), rational=True) for f in functions_of_the_angles)


def shipped_lift():
    """Return the projections of g = Im(q~ Q)/2 that `State.euler` returns, as functions on all of R^8."""
    momenta = euler.momenta_from_angular_momentum(equation_13(), shipped_momentum(q, Q))
    return algebraic(momenta)


@functools.cache
def brackets_of_shipped():
    """Return those of all pairs of the three angles and the three momenta."""
    shipped = (*equation_13(), *shipped_lift())
    return [[bracket(f, h) for h in shipped] for f in shipped]


def bracket(f, h):
    return dot(gradient(f, q), gradient(h, Q)) - dot(gradient(f, Q), gradient(h, q))


EXACT_POINTS = [
    dict(zip((*q, *Q), map(sp.Rational, numbers), strict=True))
    for numbers in (
        ("3/7", "5/3", "4", "4/7", "2", "-1", "1/3", "5"),
        ("8/9", "-7/2", "12", "-5/3", "-2/5", "3", "11", "1/7"),
        ("-20", "21/5", "-4", "21", "1", "2/3", "-3", "13/4"),
    )
]
"""Places off the sphere and off the tangent condition where both square roots are rational."""


@pytest.mark.parametrize("place", EXACT_POINTS)
def test_E6_places_are_off_the_sphere_with_rational_roots(place):
    assert all(root.subs(place).is_rational for root in far_and_near(q))
    assert quat.dot(q, q).subs(place) != 1
    assert quat.dot(q, Q).subs(place) != 0


def test_E6_the_shipped_momentum_of_the_inclination_is_the_exact_lift():
    far, near = far_and_near(q)
    exact_lift = (near / far * (q[1] * Q[1] + q[2] * Q[2]) - far / near * (q[0] * Q[0] + q[3] * Q[3])) / 2
    assert sp.simplify(shipped_lift()[1] - exact_lift) == 0


@pytest.mark.parametrize("place", EXACT_POINTS)
def test_E6_shipped_angles_and_momenta_have_canonical_brackets_everywhere(place):
    shipped = brackets_of_shipped()
    for i, j in itertools.product(range(3), repeat=2):
        assert sp.simplify(shipped[i][j + 3].xreplace(place)) == int(i == j)
        assert sp.simplify(shipped[i][j].xreplace(place)) == 0
        assert sp.simplify(shipped[i + 3][j + 3].xreplace(place)) == 0


@pytest.mark.parametrize("place", EXACT_POINTS)
def test_E6_the_printed_momentum_has_its_bracket_only_on_the_sphere(place):
    printed = bracket(equation_13()[1], printed_Theta()).subs(place)
    assert sp.simplify(printed * quat.dot(q, q).subs(place)) == 1


def test_E6_the_flow_of_the_printed_momentum_leaves_the_sphere():
    far, near = far_and_near(q)
    square = quat.dot(q, q)
    assert sp.simplify(bracket(square, printed_Theta()) - (far**2 - near**2) / (2 * far * near)) == 0
    assert all(sp.simplify(bracket(square, momentum)) == 0 for momentum in shipped_lift())


def test_E6_the_top_integrated_with_each_momentum():
    times = [1, 2, 3]
    angles, (Phi, lift, Psi) = equation_13(), shipped_lift()
    momentum = algebraic(euler.angular_momentum_from_momenta(angles, MOMENTA))
    height = dot(centre, algebraic(euler.rotation_matrix_from_angles(angles)[2]))
    hamiltonian = (TOP.body.kinetic_energy(momentum) + weight * height).subs(NUMBERS)

    def run(Theta):
        energy = hamiltonian.xreplace(dict(zip(MOMENTA, (Phi, Theta, Psi), strict=True)))
        quaternions = flow(hamiltonian_flow(energy, q, Q), (*q, *Q), phase(PRINTED), times).y[:4].T
        return np.sum(quaternions**2, axis=-1) - 1, attitude_error(quaternions, PAPER_TOP, PRINTED, times)

    excess, error = run(lift)
    assert np.max(np.abs(excess)) < 4e-14
    assert np.max(error) < 1e-12
    excess, error = run(printed_Theta())
    assert np.allclose(excess, [0.106, 0.265, 0.438], rtol=0, atol=1e-3)
    assert np.allclose(error, [0.0125, 0.0311, 0.0378], rtol=0, atol=1e-4)


# ---------------------------------------------------------------------- E7 and E15: I0 and the tangent condition


@pytest.mark.parametrize(("system", "degree"), [(FREE, 0), (TOP, 2), (SATELLITE, 4)])
def test_E7_the_literal_equations_move_q_dot_Q_by_the_degree_of_the_potential(system, degree):
    q_rate, Q_rate = literal_equation_7(system, 1 / I0)
    assert is_zero([quat.dot(q_rate, Q) + quat.dot(q, Q_rate) + degree * formulas.potential(system, q, 0)])
    slope = gradient(formulas.potential(system, q, 0) + 0 * q[0], q)
    assert is_zero([quat.dot(q, slope) - degree * formulas.potential(system, q, 0)])


@pytest.mark.parametrize("system", [FREE, TOP, SATELLITE])
def test_E7_the_shipped_equations_keep_q_dot_Q_and_the_norm(system):
    rates = formulas.rates(system, "canonical", [*q, *Q], 0)
    q_rate, Q_rate = Vector(rates[:4]), Vector(rates[4:])
    assert is_zero([quat.dot(q_rate, Q) + quat.dot(q, Q_rate)])
    assert is_zero([quat.dot(q, q_rate)])


@pytest.mark.parametrize("system", [FREE, TOP])
def test_E7_a_finite_fourth_moment_stretches_the_quaternion(system):
    q_rate, _ = literal_equation_7(system, 1 / I0)
    assert is_zero([quat.dot(q, q_rate) - quat.dot(q, q) * quat.dot(q, Q) / (4 * I0)])


@pytest.mark.parametrize("system", [FREE, TOP])
def test_E7_the_fourth_moment_acts_on_the_angular_momentum_only_through_the_norm(system):
    q_rate, Q_rate = literal_equation_7(system, 1 / I0)
    momentum = shipped_momentum(q, Q)
    rate = shipped_momentum(q_rate, Q) + shipped_momentum(q, Q_rate)
    slope = gradient(formulas.potential(system, q, 0) + 0 * q[0], q)
    torque = -quat.imaginary(quat.product(quat.conjugate(q), slope)) / 2
    assert are_equal(rate, cross(momentum, system.body.omega(momentum)) + torque)
    # The same torque as the package's on the sphere, and |q|^2 times it off the sphere.
    shipped = formulas.torque(system, q, omega)
    assert are_equal(torque, quat.dot(q, q) * shipped, UNIT)


def largest(_, variables):
    return np.max(np.abs(variables)) - 1e6


too_large: Any = largest
too_large.terminal = True


def test_E7_the_literal_top_with_unit_fourth_moment_runs_away():
    case = REFERENCE["cases"]["top_corrected_literalI0=1|printed_qQ_exact_sqrt2"]
    q_rate, Q_rate = literal_equation_7(TOP, sp.Integer(1))
    times = [*(float(row["t"]) for row in case), 5.0]
    run = flow([*q_rate, *Q_rate], (*q, *Q), phase(PRINTED), times, too_large)
    expected = np.array([[float(v) for v in (*row["q"], *row["Q"])] for row in case])
    assert np.max(np.abs(run.y.T - expected)) < 1e-11
    assert abs(run.t_events[0][0] - 4.347) < 5e-4
    error = attitude_error(run.y[:4].T, PAPER_TOP, PRINTED, times[:-1])
    assert abs(error[0] - 7.6e-3) < 1e-4
    assert error[-1] > 0.5


def test_E15_the_literal_top_without_reciprocal_fourth_moment_is_right_but_q_dot_Q_grows():
    case = REFERENCE["cases"]["top_corrected|printed_qQ_exact_sqrt2"]
    q_rate, Q_rate = literal_equation_7(TOP, sp.Integer(0))
    times = [float(row["t"]) for row in case]
    run = flow([*q_rate, *Q_rate], (*q, *Q), phase(PRINTED), times)
    growth = np.sum(run.y[:4] * run.y[4:], axis=0)
    assert np.allclose(growth, [float(row["S_raw"]) for row in case], rtol=0, atol=1e-9)
    assert growth[-1] > 49
    assert np.max(attitude_error(run.y[:4].T, PAPER_TOP, PRINTED, times)) < 1e-10
    shipped = pt.propagate(PAPER_TOP, PRINTED, times, formulation="canonical")
    assert np.max(np.abs(quat.dot(shipped.quaternion, shipped.conjugate_momenta))) < 8e-15
    assert np.max(np.abs(quat.norm(shipped.quaternion) - 1)) < 2e-15


def test_E15_the_shipped_velocity_is_equation_7_with_a_vanishing_reciprocal_only():
    q_rate = formulas.rates(FREE, "canonical", [*q, *Q], 0)[:4]
    assert are_equal(q_rate, literal_equation_7(FREE, sp.Integer(0))[0])
    assert not are_equal(q_rate, literal_equation_7(FREE, 1 / I0)[0])


def test_E7_the_six_printed_digits_are_not_tangent():
    rounded = (0.3, -0.848528, 0.141421, -1.5)
    defect = quat.dot(PRINTED.quaternion, rounded)
    assert abs(defect + 9.717e-8) < 1e-11
    with pytest.raises(ValueError, match="tangent"):
        pt.State(PRINTED.quaternion, rounded)
    q_rate, Q_rate = literal_equation_7(FREE, sp.Integer(1))
    run = flow([*q_rate, *Q_rate], (*q, *Q), [*PRINTED.quaternion, *rounded], [100.0])
    assert abs(quat.norm(run.y[:4, 0]) - np.exp(100 * defect / 4)) < 1e-11
    projected = pt.State(PRINTED.quaternion, pt.mechanics.project_to_tangent(PRINTED.quaternion, rounded))
    assert np.max(np.abs(projected.angular_momentum_body - PRINTED.angular_momentum_body)) < 5e-7
    assert abs(pt.propagate(FREE_BODY, projected, [100.0]).quaternion[0] @ run.y[:4, 0]) > 1 - 1e-5


# ---------------------------------------------------------------------- E8: the sign of the heavy top


def test_E8_the_printed_potential_pulls_upwards():
    orientation = pt.Attitude.from_quaternion(q)
    force = orientation.to_body(Vector((0, 0, -weight)))
    shipped = TOP.dynamics.torque_at(pt.Instant(TOP.body, orientation, pt.mechanics.Environment(0), omega))
    printed = -quat.imaginary(quat.product(quat.conjugate(q), gradient(dot(centre, force), q))) / 2
    assert are_equal(shipped, cross(centre, force))
    assert are_equal(printed, -cross(centre, force), UNIT)
    assert not are_equal(printed, shipped, UNIT)


def test_E8_the_two_tops_part():
    times = [1, 10, 50, 100]
    upside_down = pt.System(BODY, pt.UniformGravity(0.5, (-1, 0, 0)))
    motions = [pt.propagate(system, PRINTED, times).quaternion for system in (PAPER_TOP, upside_down)]
    assert np.allclose(np.degrees(attitude.rotation_angle(*motions)), [30.8, 152.4, 62.5, 122.2], rtol=0, atol=0.05)


# ---------------------------------------------------------------------- E9: the initial data


def test_E9_the_two_sets_of_initial_data_have_opposite_momenta():
    assert np.allclose(EULER.quaternion, -PRINTED.quaternion, rtol=0, atol=1e-15)
    assert np.allclose(EULER.conjugate_momenta, PRINTED.conjugate_momenta, rtol=0, atol=1e-14)
    assert attitude.rotation_angle(EULER.quaternion, PRINTED.quaternion) < 1e-15
    assert np.allclose(EULER.angular_momentum_body, -PRINTED.angular_momentum_body, rtol=0, atol=1e-15)
    assert np.allclose(EULER.angular_momentum_body, [0.1 / ROOT, -1.1 / ROOT, 0.4], rtol=0, atol=1e-15)


def test_E9_euler_variables_of_each_set():
    pi = np.pi
    for state, angles, momenta in (
        (PRINTED, (5 * pi / 4, pi / 2, 5 * pi / 4), (-0.5, 0.6, -0.4)),
        (EULER, (5 * pi / 4, pi / 2, 5 * pi / 4), (0.5, -0.6, 0.4)),
    ):
        found, found_momenta = state.euler()
        assert np.allclose(np.mod(found, 2 * pi), angles, rtol=0, atol=1e-14)
        assert np.allclose(found_momenta, momenta, rtol=0, atol=1e-15)


@pytest.mark.parametrize("system", [FREE_BODY, PAPER_TOP])
def test_E9_the_two_motions_are_time_reversals_where_the_energy_does_not_know_time(system):
    times = np.array([1.0, 10, 50, 100])
    forwards, backwards = pt.propagate(system, PRINTED, times), pt.propagate(system, EULER, -times)
    assert np.max(attitude.rotation_angle(forwards.quaternion, backwards.quaternion)) < 1e-12
    apart = attitude.rotation_angle(forwards.quaternion, pt.propagate(system, EULER, times).quaternion)
    assert np.min(apart) > np.radians(86)


def test_E9_the_two_motions_of_the_satellite_are_not_time_reversals():
    times = np.array([0.1, 1, 5]) * float(ORBIT.period)
    forwards, backwards = pt.propagate(KEPLER, PRINTED, times), pt.propagate(KEPLER, EULER, -times)
    apart = attitude.rotation_angle(forwards.quaternion, backwards.quaternion)
    assert np.allclose(apart, [0.0807, 1.727, 2.652], rtol=0, atol=1e-3)


# ---------------------------------------------------------------------- E10 and E11: the satellite's data


def test_E10_only_the_ratio_of_momentum_to_inertia_matters():
    factor = sp.Symbol("factor", positive=True)
    scaled = {moment: factor * moment for moment in MOMENTS} | {momentum: factor * momentum for momentum in Q}
    rates = formulas.rates(SATELLITE, "canonical", [*q, *Q], 0)
    new_rates = [rate.subs(scaled, simultaneous=True) for rate in rates]
    assert are_equal(new_rates, [*rates[:4], *(factor * rate for rate in rates[4:])])


def test_E10_inertia_and_momentum_in_the_same_unit_make_spin_and_orbit_comparable():
    rate = np.linalg.norm(KEPLER_BODY.omega(PRINTED.angular_momentum_body))
    assert abs(rate / ORBIT.mean_motion - 1.5785) < 1e-4
    assert abs(ORBIT.period - 5828.516637686) < 1e-9
    assert abs(1e6 * rate / (2 * np.pi) - 271) < 1  # revolutions per second with I in kg m^2 and Q in kg km^2 / s


def test_E11_the_perigee_is_inside_the_earth_and_the_motion_has_no_integral():
    radius_of_the_earth = 6378.1
    distances = np.linalg.norm(ORBIT.position_at(np.linspace(0, float(ORBIT.period), 101)), axis=0)
    assert abs(distances.min() - 5600) < 1e-9
    assert distances.min() < radius_of_the_earth
    assert KEPLER.integrals == ()
    assert next(integral.name for integral in PAPER_TOP.integrals) == "energy"


# ---------------------------------------------------------------------- E12 and E13: slips


def test_E12_the_conjugate_in_the_proof_of_proposition_1_covers_the_product():
    body_rate = real("w1:4")
    spin = quat.product(quat.product(q, quat.pure(body_rate / 2)), quat.conjugate(q))  # q' q~, a vector
    product = quat.product(spin, quat.pure(x))
    turning = cross(attitude.omega_space(q, quat.product(q, quat.pure(body_rate / 2))), x)
    assert are_equal(product - quat.conjugate(product), (0, *turning))
    printed = product - quat.product(quat.conjugate(spin), quat.pure(x))
    assert not is_zero([printed[0]], UNIT)
    assert is_zero([printed[0] + 2 * dot(quat.imaginary(spin), x)])
    assert not is_zero([2 * product[0]], UNIT)  # the last line, as a product of quaternions, is no vector


def test_E13_the_diagonal_leaves_sixteen_quaternions_of_which_two_are_right():
    components = np.array([1, 4, -4, 4]) / 7
    matrix = attitude.rotation_matrix(components)
    patterns = [np.array(signs) * np.abs(components) for signs in itertools.product((1, -1), repeat=4)]
    diagonals = [np.diag(attitude.rotation_matrix(pattern)) for pattern in patterns]
    assert np.allclose(diagonals, np.diag(matrix), rtol=0, atol=1e-15)
    right = [p for p in patterns if np.allclose(attitude.rotation_matrix(p), matrix, rtol=0, atol=1e-15)]
    assert len(right) == 2
    found = attitude.quaternion_from_matrix(matrix)
    assert any(np.allclose(found, p, rtol=0, atol=1e-15) for p in right)


# ---------------------------------------------------------------------- E14: the Legendre transform


def test_E14_the_exact_legendre_transform_has_a_factor_that_equation_6_rightly_drops():
    rate = real("d:4")
    turning = quat.product(quat.conjugate(q), rate)
    weighted = quat.component_product(Vector((I0, *MOMENTS)), turning)
    momentum = dict(zip(Q, 4 * quat.product(q, weighted), strict=True))
    energy = 2 * quat.dot(turning, weighted)
    of_equation_6 = equation_6(1 / I0).subs(momentum)
    energy, of_equation_6 = (value.subs(NUMBERS).subs(I0, 2) for value in (energy, of_equation_6))
    assert is_zero([energy * quat.dot(q, q) ** 2 - of_equation_6])
    assert not is_zero([energy - of_equation_6])


def test_E14_the_factor_would_break_the_tangent_condition():
    full = equation_6(1 / I0) / quat.dot(q, q) ** 2
    assert is_zero([dot(gradient(full, Q), Q) - dot(q, gradient(full, q)) - 4 * full])
    shipped = FREE.body.kinetic_energy(shipped_momentum(q, Q))
    assert is_zero([dot(gradient(shipped, Q), Q) - dot(q, gradient(shipped, q))])


def test_E14_the_torque_free_motion_with_the_factor_goes_astray():
    full, times = equation_6(sp.Integer(1)) / quat.dot(q, q) ** 2, [1, 10]
    quaternions = flow(hamiltonian_flow(full, q, Q), (*q, *Q), phase(PRINTED), times).y[:4].T
    assert np.allclose(quat.norm(quaternions), [1.162, 3.020], rtol=0, atol=1e-3)
    assert np.allclose(attitude_error(quaternions, FREE_BODY, PRINTED, times), [0.178, 2.27], rtol=0, atol=5e-3)


# ---------------------------------------------------------------------- the page


def test_the_page_names_tests_and_functions_that_exist():
    here = Path(__file__).parent
    page = (here.parents[1] / "docs" / "paper.md").read_text()
    named = {kind: set(re.findall(rf"`{kind}::(\w+)`", page)) for kind in ("equations", "errata")}
    for kind, tests in named.items():
        defined = set(re.findall(r"^def (test_\w+)", (here / f"test_paper_{kind}.py").read_text(), re.MULTILINE))
        assert tests <= defined, tests - defined
    functions = set(
        re.findall(r"`((?:functions|kinematics|mechanics|systems|integration|forces|orbits)\.[\w.]+)`", page)
    )
    assert len(functions) > 20
    for function in functions:
        pkgutil.resolve_name(f"poinsot.{function}")
    assert all(f"**E{number}, " in page for number in range(1, 16))
