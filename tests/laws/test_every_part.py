"""What holds for every part that is shipped, and for a user's own; a new one joins by one instance in `PARTS`."""

import mpmath
import numpy as np
import pytest
import sympy

import poinsot as pt
from poinsot import parts
from poinsot.functions import Vector
from poinsot.mechanics.part import Part
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, SpringMass

BODY = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
OMEGA = np.array([0.4, -0.9, 0.3])
IDENTITY = (1, 0, 0, 0)
TIMES = np.linspace(0, 20, 21)


class Boom(Part):
    """A user's part: two tip masses that a motor runs out, a given change of inertia without variables."""

    mass: float
    speed: float

    def inertia(self, own, time):  # noqa: ARG002
        square = self.mass * (1 + self.speed * time) ** 2
        return ((0.0, 0.0, 0.0), (0.0, square, 0.0), (0.0, 0.0, square))


class Gimbal(Part):
    """A user's part: a rotor whose axis a spring holds in the body, its angle a variable."""

    spin: float
    stiffness: float
    variables = {"angle": 1, "momentum": 1}  # noqa: RUF012
    momenta = frozenset({"momentum"})
    moment = 0.3

    def momentum(self, own, time):  # noqa: ARG002
        angle, p = own
        return Vector((self.spin * pt.functions.cos(angle), self.spin * pt.functions.sin(angle), p))

    def spinning_inertia(self, own):  # noqa: ARG002
        return ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, self.moment))

    def internal_energy(self, own, time):  # noqa: ARG002
        angle, p = own
        return p * p / (2 * self.moment) + self.stiffness * angle * angle / 2

    def rates(self, instant, pull):  # noqa: ARG002
        # H = (g - h) . K (g - h) / 2 + internal: angle' = dH/dp, p' = -dH/d angle.
        angle, p = instant.own(self)
        w1, w2, w3 = instant.omega_body
        twist = self.spin * (w2 * pt.functions.cos(angle) - w1 * pt.functions.sin(angle))
        return Vector((p / self.moment - w3, twist - self.stiffness * angle))


PARTS = (
    Gyrostat((0.3, -0.2, 0.5)),
    ReactionWheel((0.6, 0, 0.8), 0.1, 0.02, 0.01),
    KaneDamper(0.4, 0.1),
    SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0, 0.3),
    Boom(0.2, 0.1),
    Gimbal(0.7, 1.5),
)
FREE_OF_LOSS = (
    Gyrostat((0.3, -0.2, 0.5)),
    ReactionWheel((0.6, 0, 0.8), 0.1),
    KaneDamper(0.4, 0.0),
    SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0),
    Gimbal(0.7, 1.5),
)
each_part = pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)


def started(system, **own):
    """A state in which no variable is zero."""
    at_rest = system.state(IDENTITY, omega_body=OMEGA).own
    moved = {name: values + 0.1 + 0.05 * np.arange(values.shape[-1]) for name, values in at_rest.items()}
    return system.state(IDENTITY, omega_body=OMEGA, **{**moved, **own})


def test_every_part_is_here():
    shipped = {getattr(parts, name) for name in parts.__all__}
    assert shipped == {type(part) for part in PARTS} - {Boom, Gimbal}


@each_part
def test_formulas_give_the_same_on_all_scalars(part):
    system = pt.System(BODY, part)
    state = started(system)
    expected = {name: np.array(list(rate)) for name, rate in system.rates(system.at(state)).items()}
    for number in (lambda x: mpmath.mpf(float(x)), lambda x: sympy.Float(float(x), 30), lambda x: np.array([x, x])):
        twin = system.with_numbers(map(number, system.numbers))
        phase = {name: Vector(map(number, values)) for name, values in state.phase.items()}
        attitude = pt.Attitude.from_quaternion(phase.pop("quaternion"))
        g = phase.pop("angular_momentum_body")
        body = twin.body_at(phase, number(0.0))
        instant = pt.Instant(body, attitude, pt.Environment(number(0.0)), angular_momentum_body=g)
        for name, rate in twin.rates(instant).items():
            found = np.array([np.ravel(np.array(x, dtype=float))[0] for x in rate])
            np.testing.assert_allclose(found, expected[name], rtol=1e-14, atol=1e-15)


@each_part
def test_angular_momentum_in_space_is_constant(part):
    system = pt.System(BODY, part)
    start = started(system)
    motion = pt.propagate(system, start, np.linspace(0, 200, 21))
    G = motion.angular_momentum_space
    assert np.max(np.abs(G - G[0])) < 1e-14 * np.linalg.norm(G[0])
    assert not np.allclose(motion.omega_body[-1], motion.omega_body[0])


def test_angular_momentum_of_several_parts_is_constant():
    system = pt.System(BODY, *PARTS)
    motion = pt.propagate(system, started(system), np.linspace(0, 200, 21))
    G = motion.angular_momentum_space
    assert np.max(np.abs(G - G[0])) < 1e-14 * np.linalg.norm(G[0])


@pytest.mark.parametrize("part", FREE_OF_LOSS, ids=lambda part: type(part).__name__)
def test_without_loss_the_energy_is_constant(part):
    system = pt.System(BODY, part)
    assert "energy" in {integral.name for integral in system.integrals}
    motion = pt.propagate(system, started(system), np.linspace(0, 200, 21))
    # Rounding of about 2000 steps at most, each below a unit in the last place: its root times 2.2e-16.
    assert np.max(np.abs(motion.drift["energy"])) < 5e-14


@each_part
def test_all_formulations_give_one_motion(part):
    system = pt.System(BODY, part)
    start = system.state((0.5, 0.5, 0.5, 0.5), omega_body=OMEGA)
    usual, other = (pt.propagate(system, start, TIMES[:6], formulation=f) for f in ("lie_poisson", "canonical"))
    assert np.max(np.abs(other.quaternion - usual.quaternion)) < 1e-13
    for name, values in other.own.items():
        assert np.max(np.abs(values - usual.own[name])) < 1e-13


def test_extended_precision_agrees():
    system = pt.System(BODY, PARTS[1], PARTS[2])
    usual, wide = (pt.propagate(system, started(system), TIMES, precision=p) for p in ("double", "extended"))
    for name, values in wide.phase.items():
        np.testing.assert_allclose(usual.phase[name], values, rtol=0, atol=2e-13)


@each_part
def test_a_motion_runs_back_to_its_start(part):
    system = pt.System(BODY, part)
    start = started(system)
    there = pt.propagate(system, start, [0.0, 5.0], dense=True)
    back = pt.propagate(system, there(5.0), [0.0, 5.0])
    for name, values in back.phase.items():
        np.testing.assert_allclose(values[0], there.phase[name][0], rtol=0, atol=1e-12)


@each_part
def test_dense_output_meets_the_times(part):
    system = pt.System(BODY, part)
    motion = pt.propagate(system, started(system), TIMES, dense=True)
    again = pt.propagate(system, motion.initial, [0.0, 7.77])
    state = motion(7.77)
    for name, values in again.phase.items():
        np.testing.assert_allclose(state.phase[name], values[-1], rtol=0, atol=1e-13)


@each_part
def test_members_move_as_if_alone(part):
    moments = np.array([(6.0, 8.0, 10.0), (6.5, 8.0, 9.0), (7.0, 7.5, 10.0)])
    many = pt.System(pt.Body(moments), part)
    start = many.state(IDENTITY, omega_body=OMEGA)
    own = {name: values * np.array([[1.0], [1.2], [0.8]]) for name, values in start.own.items()}
    motion = pt.propagate(many, many.state(IDENTITY, omega_body=OMEGA, **own), TIMES[:6])
    for i in range(3):
        alone = pt.System(pt.Body(moments[i]), part)
        mine = {name: values[i] for name, values in own.items()}
        single = pt.propagate(alone, alone.state(IDENTITY, omega_body=OMEGA, **mine), TIMES[:6])
        np.testing.assert_allclose(motion.quaternion[i], single.quaternion, rtol=0, atol=1e-13)
        np.testing.assert_allclose(motion.energy[i], single.energy, rtol=1e-13)
        for name, values in single.own.items():
            np.testing.assert_allclose(motion.own[name][i], values, rtol=0, atol=1e-13)


class Level(pt.Event):
    """The first variable of a part at a level."""

    part: Part
    level: float

    def value(self, instant):
        return instant.own(self.part)[0] - self.level


@pytest.mark.parametrize("part", [part for part in PARTS if part.size], ids=lambda part: type(part).__name__)
def test_events_see_the_variables(part):
    system = pt.System(BODY, part)
    start = started(system)
    plain = pt.propagate(system, start, TIMES, dense=True)
    level = float(np.mean(plain.own[part.name][:2, 0]))
    motion = pt.propagate(system, start, TIMES, events=[Level(part, level)])
    assert len(motion.events[0])
    for time, value in zip(motion.events[0].times, motion.events[0].states.own[part.name][:, 0], strict=True):
        assert abs(value - level) < 1e-13
        assert abs(plain(time).own[part.name][0] - level) < 1e-13


# ---------------------------------------------------------------------- what does not work with parts yet


def test_planar_motion_refuses_parts():
    system = pt.System(pt.Body((6, 8, 10)), Gyrostat((0, 0, 1)))
    with pytest.raises(ValueError, match="formulation 'planar' must be for a body without parts, got Gyrostat"):
        pt.propagate(system, system.state(IDENTITY, omega_body=(0, 0, 1)), TIMES, formulation="planar")


def test_gravity_does_work_on_parts():
    # On a circular orbit H - n . G is constant, whatever the parts do without loss: torque, pull and rates agree.
    orbit = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.5, node=0.2, argument_of_periapsis=0.3
    )
    spring = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 20.0)
    system = pt.System(BODY, spring, pt.GravityGradient(orbit))
    motion = pt.propagate(system, started(system), TIMES)
    assert np.max(np.abs(motion.drift["jacobi_energy"])) < 1e-14


def test_variational_equations_refuse_parts():
    system = pt.System(BODY, PARTS[1])
    with pytest.raises(ValueError, match="variational equations must be those of a body without parts"):
        pt.analysis.state_transition(system, started(system), TIMES)


class Kick(pt.Event):
    """An event that acts."""

    def value(self, instant):
        return instant.time - 1.0

    def act(self, body, state):  # noqa: ARG002
        return state


def test_events_that_act_refuse_parts():
    system = pt.System(BODY, PARTS[1])
    with pytest.raises(ValueError, match="an event that acts must be for a body without parts"):
        pt.propagate(system, started(system), TIMES, events=[Kick()])


@each_part
def test_files_bring_back_the_motion_of_every_part(part, tmp_path):
    system = pt.System(BODY, part)
    motion = pt.propagate(system, started(system), TIMES)
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert isinstance(read.system, pt.System) is (type(part).__module__.partition(".")[0] == "poinsot")
    for name in motion.dataset.variables:
        np.testing.assert_array_equal(read.dataset[name].values, motion.dataset[name].values, err_msg=name)


def test_equilibria_refuse_parts():
    system = pt.System(BODY, PARTS[0])
    with pytest.raises(ValueError, match="system must be without parts, got Gyrostat"):
        pt.analysis.equilibria(system)
