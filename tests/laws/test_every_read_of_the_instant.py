"""Whatever a formula reads of the instant acts as its energy says, in all formulations and axes, or is refused."""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.algebra import quaternion as quat
from poinsot.parts import SpringMass

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.5, node=0.2, argument_of_periapsis=0.3)
BODY = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
SPRING = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 20.0)
VECTOR = fn.Vector((0.3, -0.5, 0.7))
TIMES = np.linspace(0, 3, 4)

OF_ATTITUDE = {
    "matrix": lambda a: a.matrix[0][1] * a.matrix[2][0] + 2 * a.matrix[1, 2],
    "quaternion": lambda a: a.quaternion[0] * a.quaternion[2] + 2 * a.quaternion[1] ** 2,
    "to_body": lambda a: a.to_body((0.2, 0.9, -0.4))[0] ** 2,
    "to_space": lambda a: a.to_space(VECTOR)[1],
    "turned": lambda a: a.turned(fn.Vector((0.8, 0.0, 0.6, 0.0))).to_body((0.2, 0.9, -0.4))[0] ** 2,
}
TURNING = {
    **{f"attitude.{name}": lambda i, read=read: read(i.attitude) for name, read in OF_ATTITUDE.items()},
    "position": lambda i: fn.dot(i.attitude.to_body(i.position(ORBIT)), VECTOR),
    "velocity": lambda i: fn.dot(i.attitude.to_body(i.velocity(ORBIT)), VECTOR),
    "direction": lambda i: fn.dot(i.attitude.to_body(i.direction(ORBIT)), VECTOR),
    "environment": lambda i: fn.dot(i.attitude.to_body(i.environment.position(ORBIT)), VECTOR),
    "inertia": lambda i: fn.dot(i.inertia[1], i.attitude.to_body(i.direction(ORBIT))),
    "body": lambda i: i.body.moment_about(i.attitude.to_body(i.direction(ORBIT))),
    "acted_on": lambda i: i.acted_on.moment_about(i.attitude.to_body(i.direction(ORBIT))),
    "without_rates": lambda i: fn.dot(i.without_rates.attitude.to_body(i.without_rates.velocity(ORBIT)), VECTOR),
    "own": lambda i: i.own(SPRING)[0] * i.attitude.matrix[0, 0],
    "time": lambda i: fn.cos(i.time) * i.attitude.quaternion[3] * i.attitude.quaternion[0],
    "inverse_distance": lambda i: i.inverse_distance(ORBIT) * i.attitude.matrix[1, 0],
}
RATES = {
    "omega_body": lambda i: i.omega_body[0],
    "angular_momentum_body": lambda i: i.angular_momentum_body[0],
    "scaled_momentum": lambda i: i.scaled_momentum[0],
}
OF_THE_FIELD = {"scaled_kinetics", "scale", "shape"}
"""The kinetics and the scale of momenta, for equations of motion, and the shape of the scalars, for those of members.

A formula reads `body.omega` and `body.angular_momentum`.
"""
OF_CLOSED_RULES = {"at_rest", "components", "seen_from", "turn"}
"""The turn of one body relative to another, for the closed derivatives of mutual gravity, and the scalars of both."""
each_turning = pytest.mark.parametrize("name", TURNING)


class Read(pt.Potential):
    """An energy of what one read gives."""

    name: str

    def energy(self, instant):
        return 0.7 * {**TURNING, **RATES}[self.name](instant)


class ReadByTorque(pt.Torque):
    """A torque of what one read gives."""

    name: str

    def torque(self, instant):
        return {**TURNING, **RATES}[self.name](instant) * VECTOR


def system_of(*forces):
    """A system in which all reads have a meaning, and in which comoving axes are used where they can be."""
    return pt.System(BODY, SPRING, pt.GravityGradient(ORBIT), *forces)


def started(system):
    return system.state((0.1, 0.7, -0.1, 0.7), omega_body=(0.4, -0.9, 0.3), time=0.3, spring_mass=(0.1, 0.2))


def test_every_read_is_here():
    system = system_of()
    offered = {name for name in dir(system.at(started(system))) if not name.startswith("_")}
    named = {name.partition(".")[0] for name in TURNING}
    assert offered == named | set(RATES) | OF_THE_FIELD | {"of_bodies"}  # the instants of bodies by name
    of_attitude = {name for name in dir(pt.Attitude) if not name.startswith("_")}
    assert of_attitude == set(OF_ATTITUDE) | OF_CLOSED_RULES | {"from_quaternion"}  # and the flag comoving


@each_turning
def test_torque_is_that_of_the_energy(name):
    system = system_of(Read(name))
    state = started(system)
    step = 1e-4
    found = []
    for axis in np.eye(3):
        turns = [np.append(np.cos(h / 2), np.sin(h / 2) * axis) for h in (step, -step)]
        turned = system.state(
            quat.product(state.quaternion, turns), omega_body=(0, 0, 0), time=state.time, spring_mass=(0.1, 0.2)
        )
        energy = system.potential_energy(turned)
        found.append(-(energy[0] - energy[1]) / (2 * step))
    # The difference quotient misses h^2/6 of a third derivative below 10.
    np.testing.assert_allclose(system.torque_body(state), found, rtol=0, atol=10 * step**2)
    assert np.linalg.norm(system.torque_body(state) - system_of().torque_body(state)) > 0.01


@each_turning
def test_comoving_axes_give_the_same_or_refuse(name):
    system = system_of(Read(name))
    state = started(system)
    here, time = system.at(state), float(state.time)
    block = ORBIT.block
    own = block.start_at(np.array(time))
    to_axes = quat.conjugate(block.quaternion(np.array(time), own))
    attitude = pt.Attitude.from_quaternion(fn.Vector(quat.product(to_axes, state.quaternion)), comoving=True)
    there = pt.Instant(
        here.body, attitude, pt.mechanics.Environment(time, [(block, fn.Vector(own))], comoving=True), here.omega_body
    )
    if name.startswith("attitude") or name in ("own", "time", "inverse_distance"):
        with pytest.raises(fn.NotComoving):
            system.dynamics.potential_at(there)
    else:
        np.testing.assert_allclose(system.dynamics.potential_at(there), system.dynamics.potential_at(here), rtol=1e-14)
        np.testing.assert_allclose(
            list(system.dynamics.torque_at(there)), list(system.dynamics.torque_at(here)), rtol=0, atol=1e-14
        )


def test_every_formulation_gives_one_motion():
    forces = pt.GravityGradient(ORBIT), Read("attitude.matrix"), ReadByTorque("attitude.quaternion")
    system = pt.System(pt.Body((6, 8, 10)), *forces)
    start = system.state((0.1, 0.7, -0.1, 0.7), omega_body=(0.4, -0.9, 0.3))
    wide = pt.propagate(system, start, TIMES, precision="quadruple")  # in space axes
    for formulation in ("lie_poisson", "canonical", "euler_angles"):
        motion = pt.propagate(system, start, TIMES, formulation=formulation)
        np.testing.assert_allclose(motion.quaternion, wide.quaternion, rtol=0, atol=1e-14)


class ByQuaternion(pt.Potential):
    weight: float

    def energy(self, instant):
        a, b, c, d = instant.attitude.quaternion
        return self.weight * (a * a + d * d - b * b - c * c + a * b)


class ByMatrix(pt.Potential):
    weight: float

    def energy(self, instant):
        matrix = instant.attitude.matrix
        return self.weight * (matrix[2, 2] + (matrix[2, 1] - matrix[1, 2]) / 4)


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_variational_equations_of_the_quaternion_are_those_of_the_matrix(order):
    start = BODY.state((0.1, 0.7, -0.1, 0.7), omega_body=(0.4, -0.9, 0.3))
    one, other = (
        pt.analysis.state_transition(pt.System(BODY, force(0.3)), start, TIMES, order=order)
        for force in (ByQuaternion, ByMatrix)
    )
    assert np.ptp(other.matrix[-1]) > 1
    np.testing.assert_allclose(one.matrix, other.matrix, rtol=0, atol=1e-14 * np.max(np.abs(other.matrix)))
    if order == 2:
        np.testing.assert_allclose(one.second, other.second, rtol=0, atol=1e-14 * np.max(np.abs(other.second)))


@pytest.mark.parametrize("name", RATES)
def test_an_energy_of_rates_is_refused(name):
    with pytest.raises(TypeError, match=r"got an angular velocity or momentum. Write Read as a Torque"):
        system_of(Read(name))
    assert np.all(np.isfinite(system_of(ReadByTorque(name)).torque_body(started(system_of()))))
