"""Bodies with parts: the motions of other programs, and closed forms."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import poinsot as pt
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

CASES = json.loads((Path(__file__).parent / "spacecraft_parts.json").read_text())["cases"]
IDENTITY = (1, 0, 0, 0)


def largest(difference):
    return np.max(np.abs(difference))


each_formulation = pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])


# ---------------------------------------------------------------------- other programs


@each_formulation
def test_gyrostat(formulation):
    case = CASES["gyrostat_constant_wheel_speed"]
    speeds = np.array(case["wheel_inertias"]) * case["wheel_speeds"]
    system = pt.System(pt.Body.from_inertia(case["inertia"]), Gyrostat(speeds @ np.array(case["wheel_axes"])))
    start = system.state(case["quaternion0"], omega_body=case["omega_body0"])
    motion = pt.propagate(system, start, case["times"], formulation=formulation)
    assert largest(motion.quaternion - case["quaternion"]) < case["error"]
    assert largest(motion.omega_body - case["omega_body"]) < case["error"]


@each_formulation
def test_four_reaction_wheels(formulation):
    case = CASES["reaction_wheels"]
    columns = ("wheel_axes", "wheel_inertias", "viscous_friction", "motor_torques")
    rows = zip(*(case[column] for column in columns), strict=True)
    wheels = [ReactionWheel(*row, name=f"wheel_{i}") for i, row in enumerate(rows)]
    system = pt.System(pt.Body.from_inertia(case["inertia"]), *wheels)
    omega = np.array(case["omega_body0"])
    own = {w.name: w.at_speed(speed, omega) for w, speed in zip(wheels, case["wheel_speeds0"], strict=True)}
    start = system.state(case["quaternion0"], omega_body=omega, **own)
    motion = pt.propagate(system, start, case["times"], formulation=formulation)
    speeds = np.stack([w.speed(motion.own[w.name], motion.omega_body) for w in wheels], axis=-1)
    assert largest(motion.quaternion - case["quaternion"]) < case["error"]
    assert largest(motion.omega_body - case["omega_body"]) < case["error"]
    # The speeds are near 100: a unit in the last place is 1.4e-14, and the printed error leaves six.
    assert largest(speeds - case["wheel_speeds"]) < 3 * case["error"]


@each_formulation
def test_kane_damper_brings_the_minor_axis_to_a_flat_spin(formulation):
    case = CASES["kane_damper"]
    damper = KaneDamper(case["damper_inertia"], case["damper_coefficient"])
    system = pt.System(pt.Body.from_inertia(case["inertia"]), damper)
    omega = np.array(case["omega_body0"])
    start = system.state(
        case["quaternion0"], omega_body=omega, kane_damper=damper.at_rate(case["relative_rate0"], omega)
    )
    motion = pt.propagate(system, start, case["times"], formulation=formulation)
    slips = damper.relative_rate(motion.own["kane_damper"], motion.omega_body)
    assert largest(motion.quaternion - case["quaternion"]) < case["error"]
    assert largest(motion.omega_body - case["omega_body"]) < case["error"]
    assert largest(slips - case["relative_rate"]) < case["error"]


def hub_and_mass(hub_inertia, hub_mass, mass, place, line, stiffness, damping):
    """Newton's and Euler's equations of a free hub and a mass on a line in it, (A, omega, rho, rho').

    F is the force on the mass, r its place from the hub's centre of mass: J omega' + omega x J omega = -r x F,
    (m M/(m + M)) r'' = F, and F along the line is that of spring and dashpot. No momenta, no tensor of the whole.
    """
    reduced = mass * hub_mass / (mass + hub_mass)

    def rates(_, y):
        A, w, rho, speed = y[:9].reshape(3, 3), y[9:12], y[12], y[13]
        r = place + rho * line
        known = np.cross(w, np.cross(w, r)) + 2 * speed * np.cross(w, line)  # r'' without omega' and rho''
        across = np.cross(np.eye(3), r)  # rows e x r: omega' x r = omega' @ across
        matrix = np.zeros((4, 4))
        matrix[:3, :3] = hub_inertia + reduced * np.cross(r, across).T
        matrix[:3, 3] = reduced * np.cross(r, line)
        matrix[3] = reduced * np.array([*(across @ line), 1.0])
        push = -stiffness * rho - damping * speed
        right = [*(-np.cross(w, hub_inertia @ w) - reduced * np.cross(r, known)), push - reduced * known @ line]
        *w_rate, acceleration = np.linalg.solve(matrix, right)
        return np.concatenate([(A @ np.cross(w, np.eye(3)).T).ravel(), w_rate, [speed, acceleration]])

    return rates


@each_formulation
def test_a_mass_on_a_spring_moves_by_newtons_equations(formulation):
    hub_inertia = np.array([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 7.0)])
    hub_mass, mass, stiffness, damping = 9.0, 1.2, 5.0, 0.4
    place, line = np.array([0.4, -0.3, 1.1]), np.array([2.0, 3.0, 6.0]) / 7
    omega, rho, speed, times = np.array([0.4, -0.9, 0.5]), 0.15, -0.2, np.linspace(0, 20, 9)
    y = solve_ivp(
        hub_and_mass(hub_inertia, hub_mass, mass, place, line, stiffness, damping),
        (0, 20), [*np.eye(3).ravel(), *omega, rho, speed], "DOP853", times, rtol=3e-14, atol=1e-14,
    ).y.T  # fmt: skip

    reduced = mass * hub_mass / (mass + hub_mass)
    inertia = hub_inertia + reduced * (place @ place * np.eye(3) - np.outer(place, place))
    spring = SpringMass(mass, mass + hub_mass, hub_mass / (mass + hub_mass) * place, line, stiffness, damping)
    system = pt.System(pt.Body.from_inertia(inertia), spring)
    start = system.state(IDENTITY, omega_body=omega, spring_mass=spring.at_displacement(rho, speed, omega))
    motion = pt.propagate(system, start, times, formulation=formulation)
    # The other integration leaves 1e-13 at its tolerance of 3e-14: ten times that.
    assert largest(motion.attitude.as_matrix() - y[:, :9].reshape(-1, 3, 3)) < 1e-12
    assert largest(motion.omega_body - y[:, 9:12]) < 1e-13
    assert largest(motion.own["spring_mass"][:, 0] - y[:, 12]) < 1e-12
    assert largest(spring.speed(motion.own["spring_mass"], motion.omega_body) - y[:, 13]) < 1e-12


# ---------------------------------------------------------------------- Newton's and Euler's equations

HUB = np.array([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 7.0)])
HUB_MASS = 9.0
OMEGA = np.array([0.4, -0.9, 0.5])


def spread(x):
    return x @ x * np.eye(3) - np.outer(x, x)


def integrated(rates, start, times, **options):
    return solve_ivp(rates, (times[0], times[-1]), start, "DOP853", times, rtol=3e-14, atol=1e-14, **options).y.T


def turning(A, w):
    return (A @ np.cross(w, np.eye(3)).T).ravel()


class Thrust(pt.Torque):
    """Of a force through the centre of mass at rest of a body with a pendulum, against its rod."""

    tank: SloshPendulum
    acceleration: float

    def torque(self, instant):
        moved = self.tank.displacement(instant.own(self.tank))
        return pt.functions.cross(moved, self.tank.direction) * (self.tank.mass * self.acceleration)


@pytest.mark.parametrize("thrust", [0.0, 0.3])
def test_a_pendulum_swings_by_newtons_equations(thrust):
    """In space axes X = A y with |X - A r| = l: no angles, and the pull of the rod is an unknown."""
    mass, length, pivot = 1.2, 0.7, np.array([0.4, -0.3, 0.6])
    reduced, total = mass * HUB_MASS / (mass + HUB_MASS), mass + HUB_MASS
    down, across = np.array([0, 0.6, 0.8]), np.array([1.0, 0, 0])

    def rates(_, y):
        A, w, X, V = y[:9].reshape(3, 3), y[9:12], y[12:15], y[15:18]
        rod, W = X - A @ pivot, A @ w
        speed = V - np.cross(W, A @ pivot)
        # reduced X'' = pull rod - reduced / HUB_MASS F, J w' + w x J w = -A^T (A pivot x pull rod) + c x A^T F with the
        # force F = -total thrust d through the centre c at rest, and rod . rod'' + rod' . rod' = 0.
        lever = np.cross(pivot, A.T @ rod)
        matrix = np.zeros((4, 4))
        matrix[:3, :3], matrix[:3, 3] = HUB, lever
        matrix[3, :3], matrix[3, 3] = -lever, rod @ rod / reduced
        centripetal = np.cross(W, np.cross(W, A @ pivot))
        pushed = total * thrust / HUB_MASS * (A @ down)
        known = np.cross(mass / total * (pivot + length * down), -total * thrust * down) - np.cross(w, HUB @ w)
        *w_rate, pull = np.linalg.solve(matrix, [*known, rod @ (centripetal - pushed) - speed @ speed])
        return np.concatenate([turning(A, w), w_rate, V, pull * rod / reduced + pushed])

    angles, swing = np.array([0.4, -0.3]), np.array([-0.5, 0.7])
    (ca, cb), (sa, sb) = np.cos(angles), np.sin(angles)
    sideways = np.cross(down, across)
    e = ca * cb * down + sa * cb * across + sb * sideways
    speed = swing[0] * cb * (ca * across - sa * down) + swing[1] * (cb * sideways - sb * (ca * down + sa * across))
    X = pivot + length * e
    times = np.linspace(0, 20, 9)
    y = integrated(rates, [*np.eye(3).ravel(), *OMEGA, *X, *(length * speed + np.cross(OMEGA, X))], times)

    hanging = pivot + length * down
    inertia = HUB + reduced * spread(hanging)
    part = SloshPendulum(mass, total, pivot - mass / total * hanging, down, across, length, mass * thrust * length)
    system = pt.System(pt.Body.from_inertia(inertia), part, Thrust(part, thrust))
    start = system.state(IDENTITY, omega_body=OMEGA, slosh_pendulum=part.at_angles(angles, swing, OMEGA))
    motion = pt.propagate(system, start, times)
    places = motion.attitude.apply(hanging + np.stack(list(part.displacement(motion.own["slosh_pendulum"].T)), axis=-1))
    # The other integration keeps its rod's length to 1e-12 only, which leaves 6e-12: three times that.
    assert largest(motion.omega_body - y[:, 9:12]) < 1e-11
    assert largest(places - y[:, 12:15]) < 2e-11
    assert largest(motion.attitude.as_matrix() - y[:, :9].reshape(-1, 3, 3)) < 2e-11


def test_a_mass_that_is_moved_takes_the_work_of_its_actuator():
    """The force on the mass is reduced mass times its acceleration; its work is what the energy changes by."""
    mass, begin, duration = 1.2, 2.0, 9.0
    reduced, total = mass * HUB_MASS / (mass + HUB_MASS), mass + HUB_MASS
    first, step = np.array([0.4, -0.3, 0.6]), np.array([0.5, 1.1, -0.4])
    progress = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])

    def moved(t):
        x = (np.clip(t, begin, begin + duration) - begin) / duration
        return [first + progress(x) * step, *(progress.deriv(k)(x) / duration**k * step for k in (1, 2))]

    def rates(t, y):
        A, w = y[:9].reshape(3, 3), y[9:12]
        place, v, a = moved(t)
        known = np.cross(w, np.cross(w, place)) + 2 * np.cross(w, v) + a
        matrix = HUB + reduced * spread(place)
        w_rate = np.linalg.solve(matrix, -np.cross(w, HUB @ w) - reduced * np.cross(place, known))
        force = reduced * (known + np.cross(w_rate, place))
        return np.concatenate([turning(A, w), w_rate, [force @ v]])

    times = [0.0, 4.0, 7.0, 10.0, 14.0]
    y = integrated(rates, [*np.eye(3).ravel(), *OMEGA, 0.0], times, max_step=0.25)
    inertia = HUB + reduced * spread(first)
    center = mass / total * first
    part = MovingMasses([mass], total, [first - center], [first + step - center], begin, duration)
    system = pt.System(pt.Body.from_inertia(inertia), part)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=OMEGA), times)
    assert largest(motion.omega_body - y[:, 9:12]) < 1e-12
    assert largest(motion.attitude.as_matrix() - y[:, :9].reshape(-1, 3, 3)) < 1.5e-12
    assert abs(motion.energy[-1] - motion.energy[0]) > 0.1
    assert abs(motion.energy[-1] - motion.energy[0] - y[-1, 12]) < 3e-14


def test_inertia_given_as_a_function_of_time_moves_by_eulers_equations():
    change, begin, duration = np.array([(0.5, 0.8, 0.2), (0.8, 1.7, -0.6), (0.2, -0.6, 0.9)]), 1.0, 7.0
    progress = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])

    def rates(t, y):
        A, w = y[:9].reshape(3, 3), y[9:]
        x = (np.clip(t, begin, begin + duration) - begin) / duration
        now, pace = HUB + progress(x) * change, progress.deriv()(x) / duration * change
        return np.concatenate([turning(A, w), np.linalg.solve(now, -np.cross(w, now @ w) - pace @ w)])

    times = np.linspace(0, 20, 9)
    y = integrated(rates, [*np.eye(3).ravel(), *OMEGA], times, max_step=0.25)
    system = pt.System(pt.Body.from_inertia(HUB), VaryingInertia(change, begin, duration))
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=OMEGA), times)
    assert largest(motion.omega_body - y[:, 9:]) < 1e-12
    assert largest(motion.attitude.as_matrix() - y[:, :9].reshape(-1, 3, 3)) < 1e-12


@pytest.mark.parametrize("given", [True, False])
def test_a_rotor_in_a_gimbal_moves_by_eulers_equations(given):
    """The body's torque is minus that on the rotor: (H e)' in space, and the moment of gimbal and rotor about m."""
    momentum, moment, stiffness, damping, rate = 1.7, 0.4, 2.0, 0.3, 0.6
    m, s = np.array([0.6, 0, 0.8]), np.array([-0.8, 0, 0.6])
    t = np.cross(m, s)

    def rates(_, y):
        A, w, angle, speed = y[:9].reshape(3, 3), y[9:12], y[12], y[13]
        h = momentum * (np.cos(angle) * s + np.sin(angle) * t)
        across = np.cross(m, h)
        if given:
            w_rate = np.linalg.solve(HUB, -np.cross(w, HUB @ w + h) - rate * across)
            return np.concatenate([turning(A, w), w_rate, [rate, 0.0]])
        # HUB has gimbal and rotor locked; (w', angle''): total momentum, and that of the gimbal about m.
        matrix = np.zeros((4, 4))
        matrix[:3, :3], matrix[:3, 3] = HUB, moment * m
        matrix[3, :3], matrix[3, 3] = moment * m, moment
        total = HUB @ w + h + moment * speed * m
        right = [*(-np.cross(w, total) - speed * across), w @ across - stiffness * angle - damping * speed]
        solved = np.linalg.solve(matrix, right)
        return np.concatenate([turning(A, w), solved[:3], [speed, solved[3]]])

    times = np.linspace(0, 20, 9)
    y = integrated(rates, [*np.eye(3).ravel(), *OMEGA, 0.3, 0.2], times)
    part: Any = GimballedRotor(m, s, momentum, moment, 0.0, stiffness, damping)
    part = ControlMomentGyro(m, s, momentum, rate) if given else part
    system = pt.System(pt.Body.from_inertia(HUB), part)
    own = (0.3,) if given else part.at_angle(0.3, 0.2, OMEGA)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=OMEGA, **{part.name: own}), times)
    assert largest(motion.omega_body - y[:, 9:12]) < 1e-12
    assert largest(motion.own[part.name][:, 0] - y[:, 12]) < 1e-12
    assert largest(motion.attitude.as_matrix() - y[:, :9].reshape(-1, 3, 3)) < 1e-12


def test_wheels_that_brake_a_body_saturate_as_stated():
    """I w' = -w x (I w + sum J s a) - sum J s' a and J (s' + a . w') = motor - friction."""
    axes = np.array([(0.6, 0, 0.8), (0, 0.6, -0.8), (0.8, -0.6, 0), (0, 1, 0)])
    J, most, fastest, viscous, dry = (
        np.array([0.1, 0.2, 0.15, 0.1]),
        0.25,
        np.array([8.0, 5.0, 30.0, 9.0]),
        0.004,
        0.002,
    )
    gain, start = 1.1, np.array([1.0, -2.0, 3.0, 8.6])

    def motors(w, s):
        wanted = np.linalg.pinv(axes.T) @ (gain * w)
        high, low = (most * np.minimum(1, 20 * (1 - sign * s / fastest)) for sign in (1, -1))
        return np.clip(wanted, -low, high) - viscous * s - dry * np.clip(1000 * s / fastest, -1, 1)

    def rates(_, y):
        A, w, s = y[:9].reshape(3, 3), y[9:12], y[12:]
        torque = motors(w, s)
        # sum J s' a = sum (torque - J a . w') a
        w_rate = np.linalg.solve(HUB - (J * axes.T) @ axes, -np.cross(w, HUB @ w + (J * s) @ axes) - torque @ axes)
        return np.concatenate([turning(A, w), w_rate, torque / J - axes @ w_rate])

    times = np.linspace(0, 20, 9)
    y = integrated(rates, [*np.eye(3).ravel(), *OMEGA, *start], times, max_step=0.1)
    wheels = ReactionWheels(axes, J, pt.forces.LinearDamping(gain), most, fastest, viscous, dry)
    system = pt.System(pt.Body.from_inertia(HUB), wheels)
    own = wheels.at_speeds(start, OMEGA)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=OMEGA, reaction_wheels=own), times)
    speeds = wheels.speeds(motion.own["reaction_wheels"], motion.omega_body)
    assert np.max(np.abs(speeds) / fastest) > 0.96  # one is near its largest speed
    assert np.max(np.abs(np.linalg.pinv(axes.T) @ (gain * OMEGA))) > most  # and motors are at their largest torque
    # Steps of the other integration go over the switches, which leaves 1e-11 of the speeds, and less of the body's.
    assert largest(motion.omega_body - y[:, 9:12]) < 1e-11
    assert largest(speeds - y[:, 12:]) < 1e-10


# ---------------------------------------------------------------------- flat spin

SPINNER = np.array([2.0, 3.0, 4.0])


@pytest.mark.parametrize(
    "part",
    [
        KaneDamper(0.3, 0.15),
        SpringMass(1, 20, (0.9, 0.2, 0), (0, 0, 1), 0.3, 0.2),
        SloshPendulum(1, 20, (0, 0, 0.8), (1, 0, 0), (0, 0, 1), 0.3, 0.05, 0.1),
        ReactionWheel((0, 1, 0), 0.2, 0.05),
    ],
    ids=lambda part: type(part).__name__,
)
def test_any_damper_brings_the_minor_axis_to_a_flat_spin(part):
    system = pt.System(pt.Body(SPINNER), part)
    start = system.state(IDENTITY, omega_body=(1.0, 0.02, 0.01))
    times = np.linspace(0, 3000, 301)
    motion = pt.propagate(system, start, times)
    g = np.linalg.norm(start.angular_momentum_body)
    assert motion.energy[0] > 0.99 * g**2 / (2 * SPINNER[0])
    assert np.all(np.diff(motion.energy) < 1e-15)
    assert abs(motion.energy[-1] - g**2 / (2 * SPINNER[2])) < 5e-15
    assert abs(abs(motion.omega_body[-1, 2]) - g / SPINNER[2]) < 3e-15


# ---------------------------------------------------------------------- gyrostats, closed forms


def test_axial_gyrostat_nutates_faster_by_its_rotor():
    # A w' = ((C - A) w3 + h) (-w2, w1) for a body of revolution with its rotor along the axis.
    A, C, h = 3.0, 4.0, 1.7
    omega = np.array([0.3, -0.1, 0.5])
    system, times = pt.System(pt.Body((A, A, C)), Gyrostat((0, 0, h))), np.linspace(0, 100, 101)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=omega), times)
    turned = complex(*omega[:2]) * np.exp(1j * ((C - A) * omega[2] + h) / A * times)
    # 74 rad of nutation, whose rate is known to a rounding: 1e-14, and as much by each of about 100 steps.
    assert largest(motion.omega_body - np.stack([turned.real, turned.imag, np.full(101, 0.5)], axis=-1)) < 1e-13


def test_zhukovskys_gyrostat_with_a_rotor_along_a_principal_axis():
    # Volterra's case h = (h, 0, 0): w2^2 and w3^2 are quadratic in w1, and t = int I1 dw1 / ((I2 - I3) w2 w3).
    I1, I2, I3, h = 2.0, 3.0, 4.0, 0.8
    start = np.array([0.2, 0.9, 0.7])

    def squares(w1):
        x, c = w1 - start[0], 2 * I1 / (I2 - I3)
        mean = (w1 + start[0]) / 2
        return (
            start[1] ** 2 + c / I2 * ((I3 - I1) * mean - h) * x,
            start[2] ** 2 + c / I3 * ((I1 - I2) * mean + h) * x,
        )

    system = pt.System(pt.Body((I1, I2, I3)), Gyrostat((h, 0, 0)))
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=start), [0.0, 0.5, 1.0])
    for time, (w1, w2, w3) in zip(motion.times[1:], motion.omega_body[1:], strict=True):
        np.testing.assert_allclose((w2**2, w3**2), squares(w1), rtol=1e-14)
        passed = quad(lambda w: I1 / ((I2 - I3) * np.sqrt(np.prod(squares(w)))), start[0], w1, epsabs=1e-14)[0]
        assert abs(passed - time) < 2e-14


def test_a_gyrostat_turns_forever_about_any_axis_to_which_its_rotor_is_fitted():
    # (I w + h) x w = 0 for h = (c - I) w.
    omega, moments = np.array([0.3, -0.4, 0.5]), np.array([2.0, 3.0, 4.0])
    system = pt.System(pt.Body(moments), Gyrostat((3.3 - moments) * omega))
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=omega), [0.0, 10.0])
    assert largest(motion.omega_body - omega) < 1e-14


# ---------------------------------------------------------------------- one axis, closed forms


def test_a_motor_turns_wheel_and_body_apart():
    inertia, moment, torque, time = 4.0, 0.2, 0.03, 25.0
    wheel = ReactionWheel((0, 0, 1), moment, torque=torque)
    system = pt.System(pt.Body((3.0, 3.5, inertia)), wheel)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=(0, 0, 0.1)), [0.0, time])
    rate = -torque / (inertia - moment)
    assert abs(motion.omega_body[-1, 2] - (0.1 + rate * time)) < 1e-15
    speed = wheel.speed(motion.own["reaction_wheel"], motion.omega_body)[-1]
    np.testing.assert_allclose(speed, (torque / moment - rate) * time, rtol=1e-15)


def test_the_slip_of_a_sphere_decays_at_one_rate():
    inertia, moment, friction, slip, time = 4.0, 0.5, 0.3, 0.7, 3.0
    damper = KaneDamper(moment, friction)
    system = pt.System(pt.Body((3.0, 3.5, inertia)), damper)
    own = damper.at_rate((0, 0, slip), (0, 0, 0.1))
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=(0, 0, 0.1), kane_damper=own), [0.0, time])
    left = damper.relative_rate(motion.own["kane_damper"], motion.omega_body)[-1, 2]
    np.testing.assert_allclose(
        left, slip * np.exp(-friction * (1 / moment + 1 / (inertia - moment)) * time), rtol=1e-13
    )


def test_a_mass_on_a_spring_oscillates_with_its_reduced_mass():
    # Along a line through the centre of mass of a body at rest: mu rho'' = -k rho - c rho'.
    mass, total, stiffness, damping, time = 2.0, 5.0, 3.0, 0.4, 7.0
    spring = SpringMass(mass, total, (0.5, 0, 0), (1, 0, 0), stiffness, damping)
    system = pt.System(pt.Body((3.0, 3.5, 4.0)), spring)
    start = system.state(IDENTITY, omega_body=(0, 0, 0), spring_mass=(0.3, 0.0))
    motion = pt.propagate(system, start, [0.0, time])
    mu = mass * (total - mass) / total
    decay = damping / (2 * mu)
    pace = np.sqrt(stiffness / mu - decay**2)
    expected = 0.3 * np.exp(-decay * time) * (np.cos(pace * time) + decay / pace * np.sin(pace * time))
    assert abs(motion.own["spring_mass"][-1, 0] - expected) < 2e-16
    assert largest(motion.omega_body) == 0


# ---------------------------------------------------------------------- energy


def test_energy_goes_where_friction_takes_it():
    body = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
    wheel, damper = ReactionWheel((0.6, 0, 0.8), 0.1, 0.02, 0.01), KaneDamper(0.4, 0.1)
    spring = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0, 0.3)
    system = pt.System(body, wheel, damper, spring)
    start = system.state(IDENTITY, omega_body=(0.4, -0.9, 0.3), spring_mass=(0.2, 0.1), reaction_wheel=[0.3])
    nodes, weights = np.polynomial.legendre.leggauss(80)
    times = 5 * (nodes + 1)
    motion = pt.propagate(system, start, [0.0, *times, 10.0])
    own, omega = motion.own, motion.omega_body
    speed, slip = wheel.speed(own["reaction_wheel"], omega), damper.relative_rate(own["kane_damper"], omega)
    power = wheel.torque * speed - wheel.friction * speed**2 - damper.coefficient * np.sum(slip**2, axis=-1)
    power -= spring.damping * spring.speed(own["spring_mass"], omega) ** 2
    assert abs(motion.energy[-1] - motion.energy[0]) > 0.1
    # Eighty nodes integrate ten units of a smooth power to rounding; the energies are near 5.
    assert abs(motion.energy[-1] - motion.energy[0] - 5 * weights @ power[1:-1]) < 1e-14


def test_energy_of_gimbals_pendulums_and_servos_goes_where_motors_and_friction_take_it():
    body = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
    axes = (0.6, 0, 0.8), (-0.8, 0, 0.6)
    gyro, rotor = ControlMomentGyro(*axes, 0.7, 0.3), GimballedRotor(*axes, 0.9, 0.3, 0.1, 1.5, 0.2)
    servo = MomentumWheel((0, 1, 0), 0.1, 3.0, 0.05, 10.0, 0.02)
    pendulum = SloshPendulum(1, 10, (0.3, 0.2, 0.4), (0, 0.6, -0.8), (1, 0, 0), 0.5, 1.5, 0.1)
    system = pt.System(body, gyro, rotor, servo, pendulum)
    omega = np.array([0.4, -0.9, 0.3])
    own = {
        "slosh_pendulum": pendulum.at_angles((0.3, -0.2), (0.5, 0.1), omega),
        "gimballed_rotor": rotor.at_angle(0.2, 0.1, omega),
    }
    nodes, weights = np.polynomial.legendre.leggauss(80)
    times = 5 * (nodes + 1)
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=omega, **own), [0.0, *times, 10.0])
    own, omega = motion.own, motion.omega_body
    power = gyro.gimbal_rate * gyro.gimbal_torque(own["control_moment_gyro"], omega)
    rate = rotor.rate(own["gimballed_rotor"], omega)
    power += rotor.torque * rate - rotor.damping * rate**2
    speed = servo.speed(own["momentum_wheel"], omega)
    power += servo.gain * (servo.commanded_speed - speed) * speed - servo.friction * speed**2
    first, second = pendulum.angle_rates(own["slosh_pendulum"].T, omega.T)
    reach = np.cos(own["slosh_pendulum"][:, 1])
    power -= pendulum.damping * ((reach * first) ** 2 + second**2)
    assert abs(motion.energy[-1] - motion.energy[0]) > 0.05
    # As above.
    assert abs(motion.energy[-1] - motion.energy[0] - 5 * weights @ power[1:-1]) < 2e-14
