"""Gravity on a body with a fixed point, and of a distant attractor."""

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.sky import Sky

TURN = Rotation.from_rotvec([0.7, -0.2, 1.1])
BODY = pt.Body((1.25, 1.0, 0.75))
TENSOR = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.2], [-0.1, 0.2, 2.5]])
OBLIQUE = pt.Body.from_inertia(TENSOR)


def torque(body, force, time=0.0):
    """The derived torque at TURN along the body axes, by SymPy."""
    symbols = sympy.symbols("q0:4", real=True)
    system = pt.System(body, force)
    twin = system.with_numbers(sympy.Float(float(x), 30) for x in system.numbers)
    attitude = Attitude.from_quaternion(functions.Vector(symbols))
    components = twin.torque_at(attitude, functions.Vector((0, 0, 0)), Sky(time))
    values = dict(zip(symbols, TURN.as_quat(scalar_first=True), strict=True))
    return np.array([float(sympy.sympify(x).subs(values)) for x in components])


def energy(body, force, turn=TURN, time=0.0):
    return pt.System(body, force).potential_energy(body.state(turn, omega_body=(0, 0, 0), time=time))


# ---------------------------------------------------------------------- uniform


def test_uniform_gravity_is_weight_times_height():
    arm = np.array([0.3, -1.0, 0.6])
    assert energy(BODY, pt.UniformGravity(0.5, arm)) == pytest.approx(0.5 * TURN.apply(arm)[2], rel=1e-14)


def test_uniform_gravity_is_least_with_the_centre_of_mass_below():
    force = pt.UniformGravity(0.5, (0, 0, 2.0))
    assert energy(BODY, force, Rotation.identity()) == 1.0
    assert energy(BODY, force, Rotation.from_rotvec([np.pi, 0, 0])) == pytest.approx(-1.0, rel=1e-15)


def test_torque_of_uniform_gravity_is_arm_cross_weight():
    arm, down = np.array([0.3, -1.0, 0.6]), TURN.inv().apply([0, 0, -1])
    assert np.allclose(torque(BODY, pt.UniformGravity(0.5, arm)), np.cross(arm, 0.5 * down), rtol=0, atol=1e-15)


def test_weight_may_be_zero():
    assert energy(BODY, pt.UniformGravity(0.0, (1, 0, 0))) == 0


def test_a_small_swing_has_the_period_of_a_pendulum():
    """Hanging about the first axis: I1 theta'' = -weight * arm * theta."""
    state = BODY.state(Rotation.from_rotvec([np.pi - 1e-5, 0, 0]), omega_body=(0, 0, 0))
    period = 2 * np.pi * np.sqrt(1.25 / (0.5 * 2.0))
    motion = pt.propagate(pt.System(BODY, pt.UniformGravity(0.5, (0, 0, 2.0))), state, [0, period / 2, period])
    angles = (Rotation.from_rotvec([np.pi, 0, 0]).inv() * motion.attitude).as_rotvec()[:, 0]
    assert np.allclose(angles, [-1e-5, 1e-5, -1e-5], rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- gradient

POSITION = np.array([3.0, -4.0, 12.0])
POINT = pt.FixedPoint(POSITION, 7.0)


@pytest.mark.parametrize(("body", "tensor"), [(BODY, np.diag([1.25, 1.0, 0.75])), (OBLIQUE, TENSOR)])
def test_gravity_gradient_energy_and_torque(body, tensor):
    u = TURN.inv().apply(POSITION) / 13
    strength = 3 * 7.0 / 13**3
    assert energy(body, pt.GravityGradient(POINT)) == pytest.approx(strength / 2 * (u @ tensor @ u), rel=1e-14)
    expected = strength * np.cross(u, tensor @ u)
    assert np.allclose(torque(body, pt.GravityGradient(POINT)), expected, rtol=0, atol=1e-16)


def test_gravity_gradient_follows_the_orbit(orbit):
    for time in (0.0, 1.3, -4.0):
        r = np.array(orbit.position_at(time), dtype=float)
        u = TURN.inv().apply(r) / np.linalg.norm(r)
        expected = 1.5 * 2.0 / np.linalg.norm(r) ** 3 * np.sum(np.array([1.25, 1.0, 0.75]) * u * u)
        assert energy(BODY, pt.GravityGradient(orbit), time=time) == pytest.approx(expected, rel=1e-13)


def test_gravity_gradient_is_the_attraction_of_far_point_masses():
    """The difference between two attitudes of -mu sum m / |R + A x|, up to (x / R)^2."""
    points = np.array([[1.0, 0.2, 0], [0, 0.8, -0.3], [0.1, 0, 0.4]])
    points, masses = np.concatenate([points, -points]), np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])
    body = pt.Body.point_masses(masses, points)
    R = 100 * np.array([0.6, 0.0, 0.8])

    def attraction(turn):
        return -7.0 * np.sum(masses / np.linalg.norm(R + turn.apply(points), axis=-1))

    force, other = pt.GravityGradient(pt.FixedPoint(R, 7.0)), Rotation.from_rotvec([-1.0, 0.4, 0.3])
    difference = energy(body, force, TURN) - energy(body, force, other)
    assert difference == pytest.approx(attraction(TURN) - attraction(other), rel=1e-3)
    assert abs(difference) > 1e-6


def test_two_attractors_add(body, start):
    other = pt.FixedPoint((0, 5.0, 0), 3.0)
    both = pt.System(body, pt.GravityGradient(POINT), pt.GravityGradient(other)).potential_energy(start)
    separate = (pt.System(body, pt.GravityGradient(point)).potential_energy(start) for point in (POINT, other))
    assert both == pytest.approx(sum(separate), rel=1e-15)


# ---------------------------------------------------------------------- damping


def test_linear_damping_stops_a_sphere_exponentially():
    sphere = pt.Body((2.0, 2.0, 2.0))
    state = sphere.state(TURN, omega_body=(0.4, -0.3, 0.6))
    motion = pt.propagate(pt.System(sphere, pt.LinearDamping(0.5)), state, [0.0, 3.0])
    assert np.allclose(motion.omega_body[1], np.exp(-0.75) * np.array([0.4, -0.3, 0.6]), rtol=0, atol=1e-15)
