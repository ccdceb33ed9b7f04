"""A system with parts: its states, its rates, and what is refused."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.part import Part
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, ReactionWheels, SpringMass

BODY = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
WHEEL = ReactionWheel((0.6, 0, 0.8), 0.1)
SPRING = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0)
OMEGA = np.array([0.1, -0.2, 0.3])
IDENTITY = (1, 0, 0, 0)
EARTH_ORBIT = pt.KeplerOrbit(1, semimajor_axis=10, eccentricity=0.0, inclination=0.5, node=0, argument_of_periapsis=0)


def test_parts_start_at_rest_in_the_body():
    system = pt.System(BODY, WHEEL, KaneDamper(0.4, 0.1), SPRING)
    state = system.state(IDENTITY, omega_body=OMEGA)
    np.testing.assert_allclose(state.angular_momentum_body, BODY.angular_momentum(OMEGA), rtol=1e-14)
    np.testing.assert_allclose(system.omega_body(state), OMEGA, rtol=1e-14)
    np.testing.assert_allclose(WHEEL.speed(state.own["reaction_wheel"], OMEGA), 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(SPRING.speed(state.own["spring_mass"], OMEGA), 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        system.kinetic_energy(state), BODY.kinetic_energy(BODY.angular_momentum(OMEGA)), rtol=1e-15
    )


def test_a_part_adds_its_momentum():
    system = pt.System(BODY, WHEEL, Gyrostat((0.1, 0.2, 0.3)))
    own = WHEEL.at_speed(7.0, OMEGA)
    state = system.state(IDENTITY, omega_body=OMEGA, reaction_wheel=own)
    g = BODY.angular_momentum(OMEGA) + 0.7 * WHEEL.axis + (0.1, 0.2, 0.3)
    np.testing.assert_allclose(state.angular_momentum_body, g, rtol=1e-14)
    again = system.state(IDENTITY, angular_momentum_body=g, reaction_wheel=own)
    np.testing.assert_allclose(system.omega_body(again), OMEGA, rtol=1e-13)


def test_members_have_their_own_values():
    wheels = ReactionWheel((0.6, 0, 0.8), [0.1, 0.2, 0.3])
    system = pt.System(BODY, wheels)
    state = system.state(IDENTITY, omega_body=OMEGA, reaction_wheel=[[0.5], [0.6], [0.7]])
    for i, moment in enumerate((0.1, 0.2, 0.3)):
        one = pt.System(BODY, ReactionWheel((0.6, 0, 0.8), moment))
        alone = one.state(IDENTITY, omega_body=OMEGA, reaction_wheel=[0.5 + 0.1 * i])
        np.testing.assert_allclose(state.angular_momentum_body[i], alone.angular_momentum_body, rtol=1e-15)
        np.testing.assert_allclose(system.energy(state)[i], one.energy(alone), rtol=1e-15)


def test_gravity_pulls_on_a_mass_on_a_spring():
    # The mass is one of two points on a rod through the attractor: the tide on their distance is 2 mu x / r^3.
    spring = SpringMass(2.0, 5.0, (0.9, 0, 0), (1, 0, 0), 0.0)
    system = pt.System(
        pt.Body((4.0, 6.0, 8.0)), pt.GravityGradient(pt.orbits.FixedPosition(7.0, position=(10.0, 0, 0))), spring
    )
    state = system.state(IDENTITY, omega_body=(0, 0, 0), spring_mass=(0.25, 0.0))
    reduced, distance = 2.0 * 3.0 / 5.0, 0.9 * 5 / 3 + 0.25
    rates = system.rates(system.at(state))["spring_mass"]
    np.testing.assert_allclose(list(rates), (0, reduced * 2 * 7.0 * distance / 10.0**3), rtol=1e-14, atol=1e-16)


class Pendulum(Part):
    """A part that is written wrongly in one way."""

    wrong: str
    variables = {"angle": 1, "momentum": 1}  # noqa: RUF012

    def momentum(self, own, time):  # noqa: ARG002
        return Vector((0.0, 0.0)) if self.wrong == "momentum" else Vector((own[1], 0.0, 0.0))

    def inertia(self, own, time):  # noqa: ARG002
        return ((1.0, 0.0), (0.0, 1.0)) if self.wrong == "inertia" else ((0.0,) * 3,) * 3

    def rates(self, instant, generalised_force):  # noqa: ARG002
        angle, momentum = instant.own(self)
        if self.wrong == "if" and angle > 0:
            momentum = -momentum
        return Vector((momentum,)) if self.wrong == "rates" else Vector((momentum, -angle))


@pytest.mark.parametrize(
    ("forces", "error", "sentence"),
    [
        (
            [WHEEL, WHEEL],
            ValueError,
            "the parts of a system must have different names, got two named 'reaction_wheel'.",
        ),
        (
            [SPRING, SpringMass(1, 10, (0, 0, 1), (1, 0, 0), 1, name="other")],
            ValueError,
            "a system must have at most one part that moves the centre of mass, got SpringMass and SpringMass.",
        ),
        (
            [ReactionWheel((1, 0, 0), 6.5)],
            ValueError,
            "parts must have less inertia than the body with its parts locked",
        ),
        (
            [SPRING, pt.UniformGravity(1, (0, 0, 1))],
            ValueError,
            "UniformGravity must act on a body whose centre of mass",
        ),
        ([Pendulum("momentum")], TypeError, "the momentum of Pendulum must be 3 scalars, got 2."),
        ([Pendulum("inertia")], TypeError, "the inertia of Pendulum must be 9 scalars, got 4."),
        (
            [Pendulum("rates")],
            TypeError,
            "the rates of Pendulum must be 2 scalars, one for each of its variables, got a scalar.",
        ),
        ([Pendulum("if")], TypeError, "the formula of Pendulum must not branch with `if` on a value, but it does."),
    ],
)
def test_parts_that_do_not_fit_are_refused(forces, error, sentence):
    with pytest.raises(error) as caught:
        pt.System(BODY, *forces)
    assert str(caught.value).startswith(sentence)


def test_a_force_that_knows_the_body_refuses_a_part_that_changes_it():
    semiaxes = np.sqrt(np.array([12, 8, 4]) / 4)
    gravity = pt.forces.EllipsoidGravity(EARTH_ORBIT, 10.0, semiaxes)
    pt.System(pt.Body((6, 8, 10)), gravity, WHEEL)
    with pytest.raises(ValueError, match="mass and semiaxes must agree with the inertia of the body"):
        pt.System(pt.Body((6, 8, 10)), gravity, SPRING)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"omega_body": OMEGA, "spoke": [1.0]}, "own must name parts with variables, reaction_wheel, got 'spoke'."),
        (
            {"angular_momentum_body": OMEGA},
            "own must name all parts where a momentum is given, got none of 'reaction_wheel'.",
        ),
        ({"omega_body": OMEGA, "reaction_wheel": [1.0, 2.0]}, "reaction_wheel must have shape (1,) or (members, 1)"),
    ],
)
def test_states_that_do_not_fit_are_refused(given, sentence):
    with pytest.raises(ValueError) as caught:
        pt.System(BODY, WHEEL).state(IDENTITY, **given)
    assert str(caught.value).startswith(sentence)


def test_a_state_of_the_body_alone_is_refused():
    with pytest.raises(ValueError, match="state must have the 1 variables of the part 'reaction_wheel', got 0"):
        pt.System(BODY, WHEEL).energy(BODY.state(IDENTITY, omega_body=OMEGA))


# ---------------------------------------------------------------------- what is conserved

SYMMETRIC = pt.Body((6, 6, 10))
SPACE = {f"angular_momentum_space_{i}" for i in (1, 2, 3)}
ENERGY_AND_G3 = {"energy", "angular_momentum_space_3"}
OF_WHEEL = {"angular_momentum_reaction_wheel"}


@pytest.mark.parametrize(
    ("body", "forces", "expected"),
    [
        (BODY, [Gyrostat((0.1, 0.2, 0.3))], {"energy"} | SPACE),
        (SYMMETRIC, [Gyrostat((0, 0, 0.3))], {"energy", "angular_momentum_body_3"} | SPACE),
        (SYMMETRIC, [Gyrostat((0.1, 0, 0.3))], {"energy"} | SPACE),
        (BODY, [WHEEL], {"energy"} | SPACE | OF_WHEEL),
        (BODY, [Gyrostat((0.1, 0.2, 0.3)), pt.UniformGravity(0.3, (0.1, 0.2, 0.3))], ENERGY_AND_G3),
        (
            SYMMETRIC,
            [Gyrostat((0, 0, 0.3)), pt.UniformGravity(0.3, (0, 0, 1))],
            ENERGY_AND_G3 | {"angular_momentum_body_3"},
        ),
        (BODY, [Gyrostat((0.1, 0.2, 0.3)), pt.GravityGradient(EARTH_ORBIT)], {"jacobi_energy"}),
        (BODY, [ReactionWheel((1, 0, 0), 0.1, friction=0.1)], SPACE),
        (BODY, [ReactionWheel((1, 0, 0), 0.1, torque=0.1)], SPACE),
        (BODY, [KaneDamper(0.4, 0.0)], {"energy"} | SPACE),
        (BODY, [KaneDamper(0.4, 0.1)], SPACE),
        (BODY, [SPRING, WHEEL, Gyrostat((0, 0, 1)), pt.GravityGradient(EARTH_ORBIT)], {"jacobi_energy"} | OF_WHEEL),
        (BODY, [WHEEL, pt.UniformGravity(0.3, (0.1, 0.2, 0.3))], ENERGY_AND_G3 | OF_WHEEL),
        (BODY, [WHEEL, pt.forces.LinearDamping(0.1)], OF_WHEEL),
    ],
)
def test_integrals(body, forces, expected):
    assert {integral.name for integral in pt.System(body, *forces).integrals} == expected


class Brake(pt.Torque):
    """A torque that reads the variables of a part, which is among its fields."""

    wheel: ReactionWheel
    gain: float

    def torque(self, instant):
        (momentum,) = instant.own(self.wheel)
        return -self.gain * momentum * Vector(self.wheel.axis)


def test_a_part_that_a_torque_knows_is_one_part():
    body, wheel = pt.Body((6.0, 8.0, 10.0)), ReactionWheel((0, 0, 1), 0.1, torque=0.02)
    known: Any = ((wheel, Brake(wheel, 0.3)), (Brake(wheel, 0.3), wheel), (Brake(wheel, 0.3),))
    for forces in known:
        system = pt.System(body, *forces)
        assert [part.name for part in system.parts] == ["reaction_wheel"]
        motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [10.0])
        # g' = -gain p, p' = torque: g = -gain torque t^2 / 2.
        assert abs(motion.angular_momentum_body[0, 2] + 0.3 * 0.02 * 50) < 1e-14
    other = ReactionWheel((0, 0, 1), 0.2)
    refused: Any = ((wheel, wheel), (wheel, Brake(other, 0.3)), (wheel, other))
    for forces in refused:
        with pytest.raises(ValueError, match="the parts of a system must have different names, got two named"):
            pt.System(body, *forces)


# ---------------------------------------------------------------------- laws within parts


class Held(pt.Torque):
    value: pt.BodyVector

    def torque(self, instant):  # noqa: ARG002
        return Vector(self.value)


AXES = [(0.6, 0, 0.8), (0, 0.6, -0.8), (0.8, -0.6, 0), (0, 1, 0)]


def test_wheels_follow_a_law_that_is_sampled():
    feedback, period = pt.control.QuaternionFeedback(0.5, 2.0, limit=10.0), 0.7
    wheels = ReactionWheels(AXES, 0.1, pt.control.Sampled(feedback, period), 5.0, 1e3)
    system = pt.System(BODY, wheels)
    assert [part.name for part in system.parts] == ["reaction_wheels", "sampled"]
    start = system.state((0.8, 0.6, 0, 0), omega_body=OMEGA)
    motion = pt.propagate(system, start, period * np.arange(1, 6))

    state = start
    for i in range(5):
        held = pt.System(BODY, ReactionWheels(AXES, 0.1, Held(law_torque(state, feedback, wheels)), 5.0, 1e3))
        own = state.own["reaction_wheels"]
        begin = held.state(
            state.attitude, angular_momentum_body=state.angular_momentum_body, time=state.time, reaction_wheels=own
        )
        end = pt.propagate(held, begin, [period * (i + 1)], dense=True)
        np.testing.assert_allclose(motion.quaternion[i], end.quaternion[0], rtol=0, atol=1e-13)
        np.testing.assert_allclose(motion.own["reaction_wheels"][i], end.own["reaction_wheels"][0], rtol=0, atol=1e-13)
        state = end(end.times[0])


def law_torque(state, law, wheels):
    """The torque that a law wants of a body with wheels."""
    system = pt.System(BODY, wheels)
    own = {**state.own, "sampled": np.zeros(3)}
    given = system.state(state.attitude, angular_momentum_body=state.angular_momentum_body, time=state.time, **own)
    return np.array(list(law.torque(system.at(given))))


def test_orbits_of_a_law_of_a_part_are_those_of_the_system():
    wheels = ReactionWheels(AXES, 0.1, pt.control.OrbitPointing(0.5, 2.0, 10.0, EARTH_ORBIT), 5.0, 1e3)
    system = pt.System(BODY, wheels, pt.GravityGradient(EARTH_ORBIT))
    assert system.orbits == (EARTH_ORBIT, EARTH_ORBIT)
    start = system.state((0.96, 0.28, 0, 0), omega_body=(0, 0, 0), frame=EARTH_ORBIT.frame)
    motion = pt.propagate(system, start, [0.0, 400.0])
    # The wheels alone lead it to the axes of the orbit, but for what gravity holds against them.
    assert motion.relative_to(EARTH_ORBIT.frame).attitude[-1].magnitude() < 0.01  # from 0.57


def test_a_state_with_variables_of_other_parts_raises_an_error():
    damped, rigid = pt.System(BODY, pt.parts.KaneDamper(0.1, 0.05)), pt.System(BODY)
    state = damped.state((1, 0, 0, 0), omega_body=OMEGA)
    misspelled = pt.State(state.quaternion, state.conjugate_momenta, own={"kane_dampr": (1.0, 2.0, 3.0)})
    rule, remedy = "state must have variables of the parts of the system, ", "Make it by system.state(...)."
    for system, start, words in [
        (rigid, state, f"none, got 'kane_damper'. {remedy}"),
        (damped, misspelled, f"kane_damper, got 'kane_dampr'. Did you mean 'kane_damper'? {remedy}"),
    ]:
        with pytest.raises(ValueError) as caught:
            pt.propagate(system, start, [1.0])
        assert str(caught.value) == rule + words
    with pytest.raises(ValueError, match=r"^own must name parts .*, got 'kane_dampr'\. Did you mean 'kane_damper'\?$"):
        damped.state((1, 0, 0, 0), omega_body=OMEGA, kane_dampr=(1.0, 2.0, 3.0))
