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
from poinsot.parts import (
    ControlMomentGyro,
    GimballedRotor,
    Gyrostat,
    KaneDamper,
    MomentumWheel,
    MovingMasses,
    ReactionWheel,
    ReactionWheels,
    SloshPendulum,
    SpringMass,
    VaryingInertia,
)

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


def instant(body, part, own, omega, time=0.0):
    """What a formula of a part sees, and the body with it."""
    composite = CompositeBody.of(body, [part], {part.name: Vector(own)}, time)
    return Instant(
        composite, pt.Attitude.from_quaternion((1, 0, 0, 0)), pt.mechanics.Environment(time), omega
    ), composite


def judged(body, part, own, expected, time=0.0):
    """Compare a part at rates OMEGA with g, kinetic and internal energy, and rates of its variables."""
    omega = numbers(OMEGA)[:, 0]
    seen, composite = instant(body, part, own, omega, time)
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


# ---------------------------------------------------------------------- wheels with motors


@pytest.mark.parametrize(
    ("wanted", "motor"), [(R(4), R(-1, 12)), (R(5), R(1, 6)), (R(100), R(1, 2)), (R(-100), -R(1, 2))]
)
def test_momentum_wheel(wanted, motor):
    # Gain 1/4, within 1/2, at the speed 13/3.
    energy, tensor, moment = rotor()
    speed, friction = R(13, 3), R(1, 7)
    g, _, total, (_, p_rate) = lagrange(energy, 0, motor - friction * D, 0, speed)
    wheel = MomentumWheel(numbers(AXIS)[:, 0], moment, float(wanted), 0.25, 0.5, float(friction))
    own = wheel.at_speed(float(speed), numbers(OMEGA)[:, 0])
    judged(pt.Body.from_inertia(tensor), wheel, own, {"g": g, "energy": total, "rates": (p_rate,)})


class Wanted(pt.Torque):
    """A law that wants one torque."""

    value: pt.BodyVector

    def torque(self, instant):  # noqa: ARG002
        return Vector(self.value)


WHEELS = np.array([(0.6, 0, 0.8), (0, 0.6, -0.8), (0.8, -0.6, 0), (0, 1, 0)])
BIG = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
TORQUE = np.array([0.3, -0.2, 0.5])


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_wheels_give_the_least_torques_that_add_up(count):
    wheels = ReactionWheels(WHEELS[:count], 0.1, Wanted(TORQUE), 10.0, 1e9, friction=0.2)
    omega = np.array([0.2, -0.1, 0.3])
    own = wheels.at_speeds(2.0 + np.arange(count), omega)
    np.testing.assert_allclose(wheels.speeds(own, omega), 2.0 + np.arange(count), rtol=1e-14)
    seen, composite = instant(BIG, wheels, own, omega)
    motors = np.array(list(wheels.rates(seen, Vector(())))) + 0.2 * (2.0 + np.arange(count))
    np.testing.assert_allclose(motors, -np.linalg.pinv(WHEELS[:count].T) @ TORQUE, rtol=0, atol=2e-15 * 10)
    g = BIG.inertia @ omega + 0.1 * (2.0 + np.arange(count)) @ WHEELS[:count]
    np.testing.assert_allclose(list(composite.angular_momentum(omega)), g, rtol=0, atol=1e-14)
    speeds = np.array([2.0, 3.0, 4.0, 5.0])[:count]
    energy = omega @ BIG.inertia @ omega / 2 + 0.1 * speeds @ WHEELS[:count] @ omega + 0.05 * speeds @ speeds
    np.testing.assert_allclose(composite.kinetic_energy(Vector(g)), energy, rtol=1e-14)


@pytest.mark.parametrize(
    ("part", "wanted", "motor"),
    [
        (0.0, 0.3, 0.3), (0.0, 0.9, 0.5), (0.0, -0.9, -0.5),  # of the largest torque
        (0.975, 0.9, 0.25), (0.975, -0.9, -0.5), (-0.975, -0.9, -0.25), (-0.975, 0.9, 0.5),  # near the largest speed
        (1.0, 0.9, 0.0), (1.0, 0.1, 0.0), (1.0, -0.4, -0.4), (-1.0, -0.9, 0.0), (-1.0, 0.4, 0.4),  # at it
    ],
)  # fmt: skip
def test_a_wheel_at_its_largest_speed_can_only_brake(part, wanted, motor):
    wheels = ReactionWheels([(1, 0, 0)], 0.1, Wanted((-wanted, 0, 0)), 0.5, 40.0, dry_friction=0.01)
    seen, _ = instant(BIG, wheels, wheels.at_speeds([40.0 * part], (0, 0, 0)), (0, 0, 0))
    (rate,) = wheels.rates(seen, Vector(()))
    assert abs(rate + 0.01 * np.sign(part) - motor) < 1e-14


# ---------------------------------------------------------------------- rotors in gimbals


def gimbal():
    """The Lagrangian of body and a spherical rotor whose axis turns, for the angle S and rate D; and the tensor."""
    moment, spin = R(1, 5), R(9, 2)
    axis = sympy.cos(S) * ACROSS + sympy.sin(S) * AXIS.cross(ACROSS)
    arms = [sign * R(1, 2) * sympy.eye(3)[:, i] for i in range(3) for sign in (1, -1)]
    turning = spin * axis + D * AXIS
    moving = [(m, x, sympy.zeros(3, 1)) for m, x in POINTS]
    moving += [(moment, HUB + arm, turning.cross(arm)) for arm in arms]
    tensor = inertia_of([*POINTS, *((moment, HUB + arm) for arm in arms)])
    at_rest = sympy.expand(kinetic_energy(moving)).subs(D, 0)
    return kinetic_energy(moving), tensor, float(moment), float(moment * spin), at_rest


def test_gimballed_rotor():
    energy, tensor, moment, momentum, _ = gimbal()
    angle, rate, torque, stiffness, damping = R(2, 5), R(-3, 7), R(1, 3), R(5, 4), R(1, 6)
    g, p, _, rates = lagrange(energy, stiffness * S**2 / 2, torque - damping * D, angle, rate)
    axes = numbers(AXIS)[:, 0], numbers(ACROSS)[:, 0]
    gyro = GimballedRotor(*axes, momentum, moment, float(torque), float(stiffness), float(damping))
    own, w = gyro.at_angle(float(angle), float(rate), numbers(OMEGA)[:, 0]), numbers(OMEGA)[:, 0]
    np.testing.assert_allclose(own, (float(angle), p), rtol=1e-14)
    np.testing.assert_allclose(gyro.rate(own, w), float(rate), rtol=1e-14)
    # Without what the rotor's motor gives: the terms of the Lagrangian that have its speed.
    gimbal_alone = w @ tensor @ w / 2 + moment * float(rate) * axes[0] @ w + moment * float(rate) ** 2 / 2
    expected = {"g": g, "energy": gimbal_alone + float(stiffness * angle**2 / 2), "rates": rates}
    judged(pt.Body.from_inertia(tensor), gyro, own, expected)


def test_control_moment_gyro():
    _, tensor, _, momentum, energy = gimbal()
    angle, w = R(2, 5), numbers(OMEGA)[:, 0]
    at = {**dict(zip(W, OMEGA, strict=True)), S: angle}
    g = numbers([sympy.diff(energy, x).subs(at) for x in W])
    gyro = ControlMomentGyro(numbers(AXIS)[:, 0], numbers(ACROSS)[:, 0], momentum, 0.3)
    judged(pt.Body.from_inertia(tensor), gyro, (float(angle),), {"g": g, "energy": w @ tensor @ w / 2, "rates": (0.3,)})
    np.testing.assert_allclose(
        gyro.gimbal_torque((float(angle),), w), -float(sympy.diff(energy, S).subs(at)), rtol=1e-13
    )


# ---------------------------------------------------------------------- given motions


def test_moving_masses():
    at_time, begin, duration = R(7, 2), R(1, 2), R(5)
    part = (at_time - begin) / duration
    progress = 10 * S**3 - 15 * S**4 + 6 * S**5
    x, pace = progress.subs(S, part), sympy.diff(progress, S).subs(S, part) / duration
    masses = [R(1, 3), R(3, 4)]
    before = [sympy.Matrix([R(1, 2), R(3, 5), R(-1, 3)]), sympy.Matrix([R(-1, 4), R(1, 5), R(2, 3)])]
    after = [sympy.Matrix([R(1), R(-1, 5), R(-1, 2)]), sympy.Matrix([R(-1, 2), R(4, 5), R(3, 3)])]
    both = list(zip(masses, before, strict=True))
    total = sum(m for m, _ in [*POINTS, *both])
    center = sum((m * r for m, r in [*POINTS, *both]), sympy.zeros(3, 1)) / total
    moving = [(m, r, sympy.zeros(3, 1)) for m, r in POINTS]
    moved = [a + x * (b - a) for a, b in zip(before, after, strict=True)]
    moving += [(m, r, pace * (b - a)) for m, r, a, b in zip(masses, moved, before, after, strict=True)]
    at = dict(zip(W, OMEGA, strict=True))
    g = numbers([sympy.diff(kinetic_energy(moving), w).subs(at) for w in W])
    tensor = inertia_of([*POINTS, *zip(masses, moved, strict=True)])
    w = numbers(OMEGA)[:, 0]

    body = pt.Body.from_inertia(inertia_of([*POINTS, *both]))
    here, there = ([numbers(r - center)[:, 0] for r in each] for each in (before, after))
    part = MovingMasses(numbers(masses), float(total), here, there, float(begin), float(duration))
    judged(body, part, (), {"g": g, "energy": w @ tensor @ w / 2, "rates": ()}, float(at_time))
    _, composite = instant(body, part, (), (0, 0, 0), float(at_time))
    np.testing.assert_allclose(composite.inertia, tensor, rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- pendulums


@pytest.mark.parametrize("planar", [False, True])
def test_slosh_pendulum(planar):
    mass, length, stiffness, damping = R(1, 3), R(3, 5), R(7, 5), R(2, 9)
    down, across = sympy.Matrix([R(2, 7), R(3, 7), R(6, 7)]), sympy.Matrix([R(3, 7), R(-6, 7), R(2, 7)])
    angles = [S] if planar else [S, sympy.Symbol("y")]
    rates = [D] if planar else [D, sympy.Symbol("u")]
    a, b = [*angles, 0][:2]
    rod = sympy.cos(a) * sympy.cos(b) * down + sympy.sin(a) * sympy.cos(b) * across + sympy.sin(b) * down.cross(across)
    swing = sum((sympy.diff(rod, x) * v for x, v in zip(angles, rates, strict=True)), sympy.zeros(3, 1))
    pivot = sympy.Matrix([R(1, 2), R(3, 5), R(-1, 3)])
    moving = [(m, x, sympy.zeros(3, 1)) for m, x in POINTS]
    energy = kinetic_energy([*moving, (mass, pivot + length * rod, length * swing)])
    potential = stiffness * (1 - rod.dot(down))
    loss = damping * swing.dot(swing) / 2
    known = zip([S, D, *angles[1:], *rates[1:]], [R(3, 5), R(4, 7), R(-2, 5), R(5, 6)], strict=False)
    at = {**dict(zip(W, OMEGA, strict=True)), **dict(known)}
    g = numbers([sympy.diff(energy, w).subs(at) for w in W])
    momenta = [float(sympy.diff(energy, v).subs(at)) for v in rates]
    forces = [sympy.diff(energy - potential, x) - sympy.diff(loss, v) for x, v in zip(angles, rates, strict=True)]
    expected = [*(float(at[v]) for v in rates), *(float(force.subs(at)) for force in forces)]

    *points, (_, hanging) = centred([*POINTS, (mass, pivot + length * down)])
    tensor = inertia_of([*points, (mass, hanging)])
    total, vectors = (
        float(mass + sum(m for m, _ in points)),
        [numbers(x)[:, 0] for x in (hanging - length * down, down, across)],
    )
    part = SloshPendulum(float(mass), total, *vectors, *map(float, (length, stiffness, damping)), planar=planar)
    w = numbers(OMEGA)[:, 0]
    here, speeds = ([float(at[x]) for x in each] for each in (angles, rates))
    own = part.at_angles(here, speeds, w)
    np.testing.assert_allclose(own, [*(float(at[x]) for x in angles), *momenta], rtol=2e-15)
    np.testing.assert_allclose(list(part.angle_rates(own, w)), [float(at[v]) for v in rates], rtol=2e-15)
    all_energy = float((energy + potential).subs(at))
    judged(pt.Body.from_inertia(tensor), part, own, {"g": g, "energy": all_energy, "rates": expected})
    moved = numbers(length * (rod - down).subs(at))[:, 0]
    np.testing.assert_allclose(list(part.displacement(own)), moved, rtol=0, atol=1e-15)


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
        (lambda: MomentumWheel((1, 0, 0), 0.1, 1.0, -0.2, 1.0), "gain must be positive, got -0.2."),
        (
            lambda: ReactionWheels((1, 0, 0), 0.1, Wanted(TORQUE), 1, 1),
            "axes must have shape (n, 3) or (members, n, 3)",
        ),
        (lambda: ReactionWheels(WHEELS, 0.1, Wanted(TORQUE), 0, 1), "largest_torques must be positive, got 0.0."),
        (lambda: ReactionWheels(2 * WHEELS, 0.1, Wanted(TORQUE), 1, 1), "axes must be a unit vector, got length 2."),
        (
            lambda: ReactionWheels([WHEELS, 2 * WHEELS], 0.1, Wanted(TORQUE), 1, 1),
            "axes must be a unit vector, got length 2.",
        ),
        (
            lambda: ReactionWheels([(1, 0, 0), (0, 1, 0), (0.6, 0.8, 0)], 0.1, Wanted(TORQUE), 1, 1),
            "axes must span 3 dimensions, got 3 in 2.",
        ),
        (
            lambda: ControlMomentGyro((1, 0, 0), (0.6, 0.8, 0), 1, 1),
            "spin_axis must be perpendicular to gimbal_axis, got a cosine of 0.6.",
        ),
        (
            lambda: SloshPendulum(1, 9, (0, 0, 1), (0, 0, 1), (0, 0.6, 0.8), 1),
            "across must be perpendicular to direction, got a cosine of 0.8.",
        ),
        (lambda: SloshPendulum(9, 9, (0, 0, 1), (0, 0, 1), (1, 0, 0), 1), "mass must be less than total_mass, got"),
        (lambda: MovingMasses([1, 2], 3, np.eye(3)[:2], np.eye(3)[1:], 0, 1), "total_mass must be more than the sum"),
        (lambda: MovingMasses([1], 3, [(1, 0, 0)], [(2, 0, 0)], 0, 0), "duration must be positive, got 0.0."),
        (lambda: VaryingInertia([(1, 1, 0), (0, 1, 0), (0, 0, 1)], 0, 1), "change must be a symmetric tensor, got"),
        (
            lambda: pt.System(BIG, VaryingInertia(np.diag([0, 0, 9.0]), 0, 1)),
            "the inertia at the end of the transition must be the inertia of a body, got principal moments 5.9",
        ),
        (
            lambda: pt.System(BIG, MovingMasses([1], 10, [(0, 0, 5)], [(0, 0, 6)], 0, 1)),
            "the inertia of the rest, without the masses, must be the inertia of a body, got principal moments",
        ),
        (lambda: KaneDamper(0.1, 0.2, name="a b"), "name must be a word such as 'kane_damper'"),
        (lambda: KaneDamper(0.1, 0.2, name="time"), "name must be a word such as 'kane_damper'"),
    ],
)
def test_wrong_parts_are_refused(make, sentence):
    with pytest.raises(ValueError) as caught:
        make()
    assert str(caught.value).startswith(sentence)


def test_a_wheel_beyond_saturation_at_the_start_is_refused():
    wheels = ReactionWheels(WHEELS, 0.1, Wanted(TORQUE), 10.0, [50.0, 60.0, 70.0, 80.0])
    system = pt.System(BIG, wheels)
    own = wheels.at_speeds([49.0, -59.0, -71.5, 80.0], (0, 0, 0))
    start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0), reaction_wheels=own)
    with pytest.raises(
        ValueError, match=r"the speed of wheel 2 must be at most its largest at the start, 70, got 71\.5\."
    ):
        pt.propagate(system, start, [1.0])
    many = system.state((1, 0, 0, 0), omega_body=(0, 0, 0), reaction_wheels=[0.9 * own, own])
    with pytest.raises(
        ValueError, match=r"the speed of wheel 2 must be at most its largest at the start, 70, got 71\.5\."
    ):
        pt.propagate(system, many, [1.0])
