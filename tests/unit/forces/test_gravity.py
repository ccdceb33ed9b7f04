"""Gravity on a body with a fixed point, and of a distant attractor."""

import re

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from poinsot import functions

TURN = Rotation.from_rotvec([0.7, -0.2, 1.1])
BODY = pt.Body((1.25, 1.0, 0.75))
TENSOR = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.2], [-0.1, 0.2, 2.5]])
OBLIQUE = pt.Body.from_inertia(TENSOR)


def torque(body, force, time=0.0):
    """The derived torque at TURN along the body axes, by SymPy."""
    symbols = sympy.symbols("q0:4", real=True)
    system = pt.System(body, force)
    copied = formulas.copied(system, (sympy.Float(float(x), 30) for x in system.dynamics.numbers))
    components = formulas.torque(copied, symbols, (0, 0, 0), time)
    values = dict(zip(symbols, TURN.as_quat(scalar_first=True), strict=True))
    return np.array([float(sympy.sympify(x).subs(values)) for x in components])


def energy(body, force, turn=TURN, time=0.0):
    return pt.System(body, force).potential_energy(body.state(turn, omega_body=(0, 0, 0), time=time))


# ---------------------------------------------------------------------- uniform


def test_uniform_gravity_is_weight_times_height():
    arm = np.array([0.3, -1.0, 0.6])
    assert energy(BODY, pt.UniformGravity(0.5, arm)) == pytest.approx(0.5 * TURN.apply(arm)[2], rel=1e-14, abs=0)


def test_uniform_gravity_is_least_with_the_centre_of_mass_below():
    force = pt.UniformGravity(0.5, (0, 0, 2.0))
    assert energy(BODY, force, Rotation.identity()) == 1.0
    assert energy(BODY, force, Rotation.from_rotvec([np.pi, 0, 0])) == pytest.approx(-1.0, rel=1e-15, abs=0)


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
POINT = pt.orbits.FixedPosition(7.0, position=POSITION)


@pytest.mark.parametrize(("body", "tensor"), [(BODY, np.diag([1.25, 1.0, 0.75])), (OBLIQUE, TENSOR)])
def test_gravity_gradient_energy_and_torque(body, tensor):
    u = TURN.inv().apply(POSITION) / 13
    strength = 3 * 7.0 / 13**3
    assert energy(body, pt.GravityGradient(POINT)) == pytest.approx(strength / 2 * (u @ tensor @ u), rel=1e-14, abs=0)
    expected = strength * np.cross(u, tensor @ u)
    assert np.allclose(torque(body, pt.GravityGradient(POINT)), expected, rtol=0, atol=1e-16)


def test_gravity_gradient_follows_the_orbit(orbit):
    for time in (0.0, 1.3, -4.0):
        r = np.array(orbit.position_at(time), dtype=float)
        u = TURN.inv().apply(r) / np.linalg.norm(r)
        expected = 1.5 * 2.0 / np.linalg.norm(r) ** 3 * np.sum(np.array([1.25, 1.0, 0.75]) * u * u)
        assert energy(BODY, pt.GravityGradient(orbit), time=time) == pytest.approx(expected, rel=1e-13, abs=0)


def test_gravity_gradient_is_the_attraction_of_far_point_masses():
    """The difference between two attitudes of -mu sum m / |R + A x|, up to (x / R)^2."""
    points = np.array([[1.0, 0.2, 0], [0, 0.8, -0.3], [0.1, 0, 0.4]])
    points, masses = np.concatenate([points, -points]), np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])
    body = pt.Body.from_point_masses(masses, points)
    R = 100 * np.array([0.6, 0.0, 0.8])

    def attraction(turn):
        return -7.0 * np.sum(masses / np.linalg.norm(R + turn.apply(points), axis=-1))

    force, other = pt.GravityGradient(pt.orbits.FixedPosition(7.0, position=R)), Rotation.from_rotvec([-1.0, 0.4, 0.3])
    difference = energy(body, force, TURN) - energy(body, force, other)
    assert difference == pytest.approx(attraction(TURN) - attraction(other), rel=1e-3)
    assert abs(difference) > 1e-6


# ---------------------------------------------------------------------- of an oblate attractor

POLE = np.array([0.3, -0.2, 0.9])


def oblate(j2=0.4, radius=9.0, pole=POLE, orbit=POINT):
    return pt.forces.Oblateness(orbit, j2, radius, pole)


@pytest.mark.parametrize(("body", "tensor"), [(BODY, np.diag([1.25, 1.0, 0.75])), (OBLIQUE, TENSOR)])
def test_torque_of_an_oblate_attractor_as_it_is_published(body, tensor):
    """3 mu/r^3 n x In + mu J2 R^2 / (2 r^5) {30 s (k x In + n x Ik) + (15 - 105 s^2) n x In - 6 k x Ik}."""
    n, k = TURN.inv().apply(POSITION) / 13, TURN.inv().apply(POLE) / np.linalg.norm(POLE)
    s = n @ k
    across = 30 * s * (np.cross(k, tensor @ n) + np.cross(n, tensor @ k))
    flat = across + (15 - 105 * s**2) * np.cross(n, tensor @ n) - 6 * np.cross(k, tensor @ k)
    expected = 7.0 * 0.4 * 9.0**2 / (2 * 13**5) * flat
    assert np.allclose(torque(body, oblate()), expected, rtol=0, atol=2e-17)
    assert np.linalg.norm(expected) > 1e-4


def test_energy_of_an_oblate_attractor_is_that_of_its_second_derivatives():
    """-tr(W'' I)/2 for W = -mu/r (1 - J2 (R/r)^2 P2(s)), up to a multiple of tr I, which no attitude changes."""
    x, k, moments = (sympy.Matrix(sympy.symbols(names, real=True)) for names in ("x1:4", "k1:4", "A B C"))
    mu, j2, radius, r = sympy.symbols("mu J2 R r", positive=True)
    distance, s = sympy.sqrt(x.dot(x)), x.dot(k) / sympy.sqrt(x.dot(x))
    W = -mu / distance * (1 - j2 * (radius / distance) ** 2 * (3 * s**2 - 1) / 2)
    expected = -(sympy.hessian(W, list(x)) * sympy.diag(*moments)).trace() / 2
    system = pt.System(BODY, pt.GravityGradient(POINT), oblate())
    system = formulas.copied(system, iter((*moments, mu, *x, mu, *x, j2, radius, *k)))
    shipped = sympy.nsimplify(formulas.potential(system, functions.Vector((1, 0, 0, 0)), 0), rational=True)
    f, height = j2 * radius**2 / r**2, x.dot(k) / r
    no_attitude = -mu / (2 * r**3) * sum(moments) * (1 + f * (3 - 15 * height**2) / 2)
    rest = (shipped - expected).subs(sympy.sqrt(k.dot(k)), 1).subs(distance, r) + no_attitude
    numerator = sympy.expand(sympy.numer(sympy.together(rest.subs(x.dot(x), r**2))))
    assert sympy.reduced(numerator, [x.dot(x) - r**2, k.dot(k) - 1], *x, *k)[1] == 0


def test_without_flattening_there_is_nothing():
    assert energy(BODY, oblate(0.0)) == 0
    assert np.array_equal(torque(BODY, oblate(0.0)), np.zeros(3))


def test_only_the_line_of_the_pole_counts():
    expected = energy(BODY, oblate())
    for factor in (-1.0, 1e-3, 250.0):
        assert energy(BODY, oblate(pole=factor * POLE)) == pytest.approx(expected, rel=2e-15, abs=0)
    assert abs(energy(BODY, oblate(pole=(0.3, 0.2, 0.9))) / expected - 1) > 1e-3


def test_flattening_and_radius_come_together():
    assert energy(BODY, oblate(1.6, 4.5)) == pytest.approx(energy(BODY, oblate(0.4, 9.0)), rel=1e-15, abs=0)


def test_members_with_their_own_flattening_and_pole():
    poles, flattenings = np.array([POLE, (0, 0, 1.0), (1.0, 0, 0)]), np.array([0.4, -0.2, 0.0])
    start = BODY.state(TURN, omega_body=(0.1, 0.3, -0.2))
    together = pt.propagate(pt.System(BODY, oblate(flattenings, pole=poles)), start, [0.0, 30.0])
    for i in range(3):
        alone = pt.propagate(pt.System(BODY, oblate(flattenings[i], pole=poles[i])), start, [0.0, 30.0])
        assert np.allclose(together.quaternion[i], alone.quaternion, rtol=0, atol=1e-13)


CIRCLE = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1)


@pytest.mark.parametrize(
    ("orbit", "pole", "expected"),
    [
        (POINT, POLE, ["energy"]),
        (POINT, POSITION, ["energy", "angular_momentum_space_attractor"]),
        (CIRCLE, CIRCLE.normal, ["jacobi_energy"]),
        (CIRCLE, POLE, []),
    ],
    ids=["anywhere", "over the pole", "equatorial circle", "inclined circle"],
)
def test_integrals_about_an_oblate_attractor(orbit, pole, expected):
    start = BODY.state(TURN, omega_body=(0.1, 0.3, -0.2))
    system = pt.System(BODY, pt.GravityGradient(orbit), oblate(0.3, 0.9, pole, orbit))
    motion = pt.propagate(system, start, np.linspace(0, 10, 21))
    assert list(motion.drift) == expected
    assert all(np.max(np.abs(drift)) < 5e-14 for drift in motion.drift.values())


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"radius": 0.0}, "equatorial_radius must be positive, got 0.0."),
        (
            {"pole": (0, 0, 0)},
            "pole must not be zero, got all components 0. It is a direction.",
        ),
        ({"pole": (0, 1)}, "pole must have shape (3,) or (members, 3) along the space axes, got shape (2,)."),
        ({"j2": np.nan}, "j2 must be finite, got j2 = nan."),
    ],
)
def test_what_is_no_oblate_attractor(wrong, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        oblate(**wrong)


# ---------------------------------------------------------------------- of several attractors

ELLIPSE = pt.KeplerOrbit(
    1.1, semimajor_axis=1.3, eccentricity=0.3, inclination=0.7, node=-0.4, argument_of_periapsis=1.9, true_anomaly=0.3
)
SEVERAL = {
    "two at rest": [pt.GravityGradient(POINT), pt.GravityGradient(pt.orbits.FixedPosition(3.0, position=(0, 5.0, 0)))],
    "an orbit and a point": [pt.GravityGradient(ELLIPSE), pt.GravityGradient(POINT)],
    "two orbits": [pt.GravityGradient(ELLIPSE), pt.GravityGradient(CIRCLE)],
    "an oblate one and two others": [
        oblate(radius=0.9, orbit=ELLIPSE),
        pt.GravityGradient(CIRCLE),
        pt.GravityGradient(POINT),
    ],
}


@pytest.mark.parametrize("forces", SEVERAL.values(), ids=SEVERAL)
@pytest.mark.parametrize("body", [BODY, OBLIQUE], ids=["principal axes", "oblique axes"])
def test_attractors_add(body, forces):
    state = body.state(TURN, omega_body=(0.1, 0.3, -0.2), time=0.9)
    together, alone = pt.System(body, *forces), [pt.System(body, force) for force in forces]
    energies = [system.potential_energy(state) for system in alone]
    assert together.potential_energy(state) == pytest.approx(sum(energies), rel=1e-15, abs=0)
    assert np.allclose(
        together.torque_body(state), sum(system.torque_body(state) for system in alone), rtol=1e-14, atol=1e-16
    )
    assert all(np.linalg.norm(system.torque_body(state)) > 1e-3 for system in alone)


def test_an_attractor_in_two_halves_is_one():
    halves, whole = (
        [pt.GravityGradient(pt.orbits.FixedPosition(mu, position=POSITION)) for mu in masses]
        for masses in ((3.5, 3.5), (7.0,))
    )
    start = BODY.state(TURN, omega_body=(0.1, 0.3, -0.2))
    two, one = (pt.propagate(pt.System(BODY, *forces), start, [0.0, 50.0]) for forces in (halves, whole))
    assert np.allclose(two.quaternion, one.quaternion, rtol=0, atol=1e-13)


def circle(semimajor_axis, mu, **others):
    return pt.GravityGradient(
        pt.KeplerOrbit(
            mu, semimajor_axis=semimajor_axis, eccentricity=0.0, inclination=0.4, node=1.1, **others
        )  # n^2 = mu / a^3, normal of CIRCLE
    )


def at_rest(position):
    return pt.GravityGradient(pt.orbits.FixedPosition(0.8, position=position))


INTEGRALS = {
    "at rest on one line": (
        [at_rest((1.0, 2, 2)), at_rest((-2.0, -4, -4))],
        ["energy", "angular_momentum_space_attractor"],
    ),
    "at rest anywhere": ([at_rest((1.0, 2, 2)), at_rest((2.0, -1, 2))], ["energy"]),
    "turning together": ([circle(1.5, 2.0), circle(3.0, 16.0, true_anomaly=0.8)], ["jacobi_energy"]),
    "turning at other rates": ([circle(1.5, 2.0), circle(3.0, 15.0)], []),
    "one at rest over the orbit": ([circle(1.5, 2.0), at_rest(1.7 * CIRCLE.normal)], ["jacobi_energy"]),
    "one at rest next to it": ([circle(1.5, 2.0), at_rest((1.0, 2, 2))], []),
    "one at rest, one on a circle": ([at_rest((1.0, 2, 2)), circle(1.5, 2.0)], []),
}


@pytest.mark.parametrize("case", INTEGRALS)
def test_integrals_of_several_attractors(case):
    forces, expected = INTEGRALS[case]
    start = BODY.state(TURN, omega_body=(0.1, 0.3, -0.2))
    motion = pt.propagate(pt.System(BODY, *forces), start, np.linspace(0, 10, 21))
    assert list(motion.drift) == expected
    assert all(np.max(np.abs(drift)) < 5e-14 for drift in motion.drift.values())


# ---------------------------------------------------------------------- damping


def test_linear_damping_stops_a_sphere_exponentially():
    sphere = pt.Body((2.0, 2.0, 2.0))
    state = sphere.state(TURN, omega_body=(0.4, -0.3, 0.6))
    motion = pt.propagate(pt.System(sphere, pt.forces.LinearDamping(0.5)), state, [0.0, 3.0])
    assert np.allclose(motion.omega_body[1], np.exp(-0.75) * np.array([0.4, -0.3, 0.6]), rtol=0, atol=1e-15)
