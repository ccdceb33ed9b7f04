"""The formulas of the shipped parts against the Lagrangian of the point masses they are made of.

The kinetic energy of every system here is that of points which move as the part says, less that of their centre of
mass: no tensor, no reduced mass. With T(omega, x', x): g = dT/d omega, p = dT/dx', p' = dT/dx + generalised force.
"""

import numpy as np
import pytest
import sympy

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import CompositeBody
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, SpringMass

R = sympy.Rational
OMEGA = sympy.Matrix([R(3, 10), R(-7, 10), R(11, 10)])
W = sympy.Matrix(sympy.symbols("w1:4"))
POINTS = [
    (R(3, 2), sympy.Matrix([R(1, 2), R(-1, 3), R(1, 4)])),
    (R(2), sympy.Matrix([R(-2, 5), R(3, 4), R(-1, 2)])),
    (R(5, 2), sympy.Matrix([R(1, 5), R(1, 3), R(2, 3)])),
    (R(1), sympy.Matrix([R(-3, 4), R(-1, 2), R(-1, 5)])),
]
"""Of the body: masses and places."""

S, D = sympy.symbols("x v")
"""A coordinate of a part, and its rate."""


def kinetic_energy(moving):
    """Of masses, places and velocities relative to the body, about their centre of mass."""
    total = sum(m for m, _, _ in moving)
    center = sum((m * x for m, x, _ in moving), sympy.zeros(3, 1)) / total
    drift = sum((m * v for m, _, v in moving), sympy.zeros(3, 1)) / total
    velocities = [v - drift + W.cross(x - center) for _, x, v in moving]
    return sum(m * v.dot(v) for (m, _, _), v in zip(moving, velocities, strict=True)) / 2


def inertia_of(points):
    """About the centre of mass: the Hessian of the kinetic energy of points at rest relative to each other."""
    energy = kinetic_energy([(m, x, sympy.zeros(3, 1)) for m, x in points])
    return numbers(sympy.hessian(energy, list(W)))


def numbers(expressions):
    return np.array(expressions, dtype=float)


def centred(points):
    total = sum(m for m, _ in points)
    center = sum((m * x for m, x in points), sympy.zeros(3, 1)) / total
    return [(m, x - center) for m, x in points]


def instant(body, part, own, omega):
    """What a formula of a part sees, and the body with it."""
    composite = CompositeBody.of(body, [part], {part.name: Vector(own)}, 0.0)
    return Instant(composite, pt.Attitude.from_quaternion((1, 0, 0, 0)), pt.Environment(0.0), omega), composite


def judged(body, part, own, expected):
    """Compare a part at rates OMEGA with g, kinetic and internal energy, and rates of its variables."""
    omega = numbers(OMEGA)[:, 0]
    seen, composite = instant(body, part, own, omega)
    g = composite.angular_momentum(omega)
    np.testing.assert_allclose(list(g), expected["g"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(list(composite.omega(g)), omega, rtol=0, atol=1e-14)
    np.testing.assert_allclose(composite.kinetic_energy(g), expected["energy"], rtol=1e-14)
    rates = part.rates(seen, Vector((0.0,) * part.size))
    np.testing.assert_allclose(list(rates), expected["rates"], rtol=0, atol=1e-14)


def lagrange(energy, potential, force, x, v):
    """g, p, the whole energy and the rates (x', p') from a Lagrangian in omega, x and x'."""
    at = {**dict(zip(W, OMEGA, strict=True)), S: x, D: v}
    g = numbers([sympy.diff(energy, w).subs(at) for w in W])
    p = float(sympy.diff(energy, D).subs(at))
    p_rate = float((sympy.diff(energy - potential, S) + force).subs(at))
    return g, p, float((energy + potential).subs(at)), (float(v), p_rate)


# ---------------------------------------------------------------------- a mass on a spring


@pytest.mark.parametrize("damping", [R(0), R(1, 4)])
def test_spring_mass(damping):
    mass, stiffness, x, v = R(1, 3), R(7, 5), R(2, 9), R(-5, 7)
    line = sympy.Matrix([R(2, 7), R(3, 7), R(6, 7)])
    *points, (_, relaxed) = centred([*POINTS, (mass, sympy.Matrix([R(1, 2), R(3, 5), R(-1, 3)]))])
    at_rest = [(m, place, sympy.zeros(3, 1)) for m, place in points]
    energy = kinetic_energy([*at_rest, (mass, relaxed + S * line, D * line)])
    g, p, total, rates = lagrange(energy, stiffness * S**2 / 2, -damping * D, x, v)

    body = pt.Body.from_inertia(inertia_of([*points, (mass, relaxed)]))
    whole = float(mass + sum(m for m, _ in points))
    vectors = numbers(relaxed)[:, 0], numbers(line)[:, 0]
    part = SpringMass(float(mass), whole, *vectors, float(stiffness), float(damping))
    own = part.at_displacement(float(x), float(v), numbers(OMEGA)[:, 0])
    np.testing.assert_allclose(own, (float(x), p), rtol=1e-14)
    np.testing.assert_allclose(part.speed(own, numbers(OMEGA)[:, 0]), float(v), rtol=1e-13)
    judged(body, part, own, {"g": g, "energy": total, "rates": rates})
    tensor = inertia_of([*points, (mass, relaxed + x * line)])
    _, composite = instant(body, part, own, (0, 0, 0))
    np.testing.assert_allclose(composite.inertia, tensor, rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- rotors


AXIS = sympy.Matrix([R(2, 3), R(-1, 3), R(2, 3)])
ACROSS = sympy.Matrix([R(1, 3), R(-2, 3), R(-2, 3)])
HUB = sympy.Matrix([R(1, 5), R(-1, 2), R(3, 10)])


def ring(mass, radius):
    """Three masses on a circle about an axis: the least that is dynamically symmetric; masses and arms."""
    other, root = AXIS.cross(ACROSS), sympy.sqrt(3)
    return [(mass, radius * (c * ACROSS + s * other)) for c, s in ((1, 0), (-R(1, 2), root / 2), (-R(1, 2), -root / 2))]


def rotor():
    """The Lagrangian of body and ring, its tensor with the ring locked, and the ring's moment about its axis."""
    arms = ring(R(1, 6), R(3, 5))
    moving = [(m, x, sympy.zeros(3, 1)) for m, x in POINTS]
    moving += [(m, HUB + arm, D * AXIS.cross(arm)) for m, arm in arms]
    locked = inertia_of([*POINTS, *((m, HUB + arm) for m, arm in arms)])
    return kinetic_energy(moving), locked, float(3 * R(1, 6) * R(3, 5) ** 2)


def test_reaction_wheel():
    energy, tensor, moment = rotor()
    speed, torque, friction = R(13, 3), R(3, 8), R(1, 7)
    g, p, total, (_, p_rate) = lagrange(energy, 0, torque - friction * D, 0, speed)
    wheel = ReactionWheel(numbers(AXIS)[:, 0], moment, float(friction), float(torque))
    own = wheel.at_speed(float(speed), numbers(OMEGA)[:, 0])
    np.testing.assert_allclose(own, (p,), rtol=1e-14)
    np.testing.assert_allclose(wheel.speed(own, numbers(OMEGA)[:, 0]), float(speed), rtol=1e-14)
    judged(pt.Body.from_inertia(tensor), wheel, own, {"g": g, "energy": total, "rates": (p_rate,)})


def test_gyrostat_is_a_rotor_at_constant_speed():
    energy, tensor, moment = rotor()
    speed = R(13, 3)
    g, *_ = lagrange(energy, 0, 0, 0, speed)
    h = moment * float(speed) * numbers(AXIS)[:, 0]
    at_rest = float(energy.subs({**dict(zip(W, OMEGA, strict=True)), D: 0}))
    judged(pt.Body.from_inertia(tensor), Gyrostat(h), (), {"g": g, "energy": at_rest, "rates": ()})


# ---------------------------------------------------------------------- a sphere in fluid


def test_kane_damper():
    # An octahedron of points has the inertia of a sphere. Kane's equations: I' = I - J 1 and slip s,
    # I' omega' = (I' omega) x omega + k s, J (omega' + s' + omega x s) = -k s.
    slip = sympy.Matrix([R(1, 2), R(-2, 3), R(1, 7)])
    arms = [sign * R(1, 2) * sympy.eye(3)[:, i] for i in range(3) for sign in (1, -1)]
    mass, k = R(1, 5), 0.37
    moving = [(m, x, sympy.zeros(3, 1)) for m, x in POINTS]
    moving += [(mass, HUB + arm, slip.cross(arm)) for arm in arms]
    energy = kinetic_energy(moving)
    at = dict(zip(W, OMEGA, strict=True))
    g = numbers([sympy.diff(energy, w).subs(at) for w in W])
    tensor = inertia_of([*POINTS, *((mass, HUB + arm) for arm in arms)])
    moment = float(mass)
    s, w = numbers(slip)[:, 0], numbers(OMEGA)[:, 0]

    body, damper = pt.Body.from_inertia(tensor), KaneDamper(moment, k)
    own = damper.at_rate(s, w)
    np.testing.assert_allclose(damper.relative_rate(own, w), s, rtol=1e-14)
    rest = tensor - moment * np.eye(3)
    w_rate = np.linalg.solve(rest, np.cross(rest @ w, w) + k * s)
    s_rate = -k * s / moment - np.cross(w, s) - w_rate
    judged(body, damper, own, {"g": g, "energy": float(energy.subs(at)), "rates": moment * (w_rate + s_rate)})
    g_rate = np.cross(g, w)
    np.testing.assert_allclose(rest @ w_rate, g_rate - moment * (w_rate + s_rate), rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda: ReactionWheel((1, 1, 0), 0.1),
            "axis must be a unit vector, got length 1.414213562.",
        ),
        (lambda: ReactionWheel((1, 0, 0), 0.0), "moment must be positive, got 0.0."),
        (lambda: ReactionWheel((1, 0, 0), 0.1, -0.2), "friction must not be negative, got -0.2."),
        (lambda: KaneDamper(-0.1, 0.2), "moment must be positive, got -0.1."),
        (lambda: KaneDamper(0.1, -0.2), "coefficient must not be negative, got -0.2."),
        (lambda: SpringMass(2, 1, (0, 0, 1), (1, 0, 0), 1), "mass must be less than total_mass, got 2.0 and 1.0."),
        (lambda: SpringMass(1, 2, (0, 0, 1), (1, 1, 0), 1), "direction must be a unit vector, got length 1.414213562."),
        (lambda: SpringMass(1, 2, (0, 0, 1), (1, 0, 0), -1), "stiffness must not be negative, got -1.0."),
        (lambda: SpringMass(1, 2, (0, 0, 1), (1, 0, 0), 1, -2), "damping must not be negative, got -2.0."),
        (lambda: KaneDamper(0.1, 0.2, name="a b"), "name must be a word such as 'kane_damper'"),
        (lambda: KaneDamper(0.1, 0.2, name="time"), "name must be a word such as 'kane_damper'"),
    ],
)
def test_wrong_parts_are_refused(make, sentence):
    with pytest.raises(ValueError) as caught:
        make()
    assert str(caught.value).startswith(sentence)
