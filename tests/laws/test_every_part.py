"""Laws of every part that is shipped, and of a user's parts; a new one joins by one instance in `kinds/parts.py`."""

from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds.parts import BODY, FREE_OF_LOSS, IDENTITY, OMEGA, PARTS, Boom, Gimbal, started
from poinsot import parts
from poinsot.functions import Vector
from poinsot.mechanics.part import Part
from poinsot.parts import (
    Gyrostat,
    ReactionWheel,
    ReactionWheels,
    SloshPendulum,
    SpringMass,
    VaryingInertia,
)
from poinsot.taylor import kernels

TIMES = np.linspace(0, 20, 21)


QUICK = (Gyrostat, VaryingInertia)
"""Whose second derivatives are quick to compile."""

each_part = pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
each_varied_part = pytest.mark.parametrize(  # variations of the pendulum take long to compile
    "part",
    [pytest.param(p, marks=pytest.mark.slow) if isinstance(p, SloshPendulum) else p for p in PARTS],
    ids=lambda part: type(part).__name__,
)


def test_every_part_is_here():
    shipped = {getattr(parts, name) for name in parts.__all__}
    assert shipped == {type(part) for part in PARTS} - {Boom, Gimbal}


@each_part
def test_formulas_give_the_same_on_all_scalars(part):
    system = pt.System(BODY, part)
    state = started(system)
    expected = {name: np.array(list(rate)) for name, rate in system.rates(system.at(state)).items()}
    for number in (lambda x: mpmath.mpf(float(x)), lambda x: sympy.Float(float(x), 30), lambda x: np.array([x, x])):
        copied: Any = system.dynamics.with_numbers(map(number, system.dynamics.numbers))
        phase = {name: Vector(map(number, values)) for name, values in state.phase.items()}
        attitude = pt.Attitude.from_quaternion(phase.pop("quaternion"))
        g = phase.pop("angular_momentum_body")
        body = copied.body_at(phase, number(0.0))
        instant = pt.Instant(body, attitude, pt.mechanics.Environment(number(0.0)), angular_momentum_body=g)
        for name, rate in copied.rates(instant).items():
            found = np.array([np.ravel(np.array(x, dtype=float))[0] for x in rate])
            np.testing.assert_allclose(found, expected[name], rtol=1e-14, atol=3e-15)  # three times the worst


@each_part
def test_angular_momentum_in_space_is_constant(part):
    system = pt.System(BODY, part)
    start = started(system)
    motion = pt.propagate(system, start, np.linspace(0, 200, 21))
    G = motion.angular_momentum_space
    assert np.max(np.abs(G - G[0])) < 1e-14 * np.linalg.norm(G[0])
    assert not np.allclose(motion.omega_body[-1], motion.omega_body[0], rtol=0, atol=1e-3)


@pytest.mark.parametrize("mover", [part for part in PARTS if part.moves_center_of_mass], ids=lambda p: type(p).__name__)
def test_angular_momentum_of_several_parts_is_constant(mover):
    system = pt.System(BODY, mover, *(part for part in PARTS if not part.moves_center_of_mass))
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
    assert np.max(np.abs(other.quaternion - usual.quaternion)) < 2e-14
    for name, values in other.own.items():
        assert np.max(np.abs(values - usual.own[name])) < 1e-14


def test_quadruple_precision_agrees():
    system = pt.System(BODY, PARTS[1], PARTS[2])
    usual, wide = (pt.propagate(system, started(system), TIMES, precision=p) for p in ("double", "quadruple"))
    for name, values in wide.phase.items():
        np.testing.assert_allclose(usual.phase[name], values, rtol=0, atol=2e-13)


@each_part
def test_a_motion_runs_back_to_its_start(part):
    system = pt.System(BODY, part)
    start = started(system)
    there = pt.propagate(system, start, [0.0, 5.0], dense=True)
    back = pt.propagate(system, there(5.0), [0.0, 5.0])
    for name, values in back.phase.items():
        np.testing.assert_allclose(values[0], there.phase[name][0], rtol=0, atol=1e-13)


@each_part
def test_dense_output_meets_the_times(part):
    system = pt.System(BODY, part)
    motion = pt.propagate(system, started(system), TIMES, dense=True)
    again = pt.propagate(system, motion.initial, [0.0, 7.77])
    state = motion(7.77)
    for name, values in again.phase.items():
        np.testing.assert_allclose(state.phase[name], values[-1], rtol=0, atol=1e-14)


GIVEN = {
    "at_speed": ("speed", (), (3,)),
    "at_speeds": ("speeds", (4,), (3,)),
    "at_rate": ("relative_rate", (3,), (3,)),
    "at_displacement": ("speed", (), (), (3,)),
    "at_angle": ("rate", (), (), (3,)),
    "at_angles": (None, (2,), (2,), (3,)),
    "at_equilibrium": (None, (3,), (3,), ()),
}
"""Methods that make variables: what gives the rate back, and the shapes of what they take."""


@pytest.mark.parametrize(
    ("part", "made"),
    [
        pytest.param(part, name, id=type(part).__name__)
        for part in PARTS
        for name in dir(part)
        if name.startswith("at_")
    ],
)
def test_variables_of_arrays_are_those_of_each(part, made, rng):
    back, *shapes = GIVEN[made]
    given = [rng.uniform(0.2, 1, (2, 3, *shape)) for shape in shapes]
    own = getattr(part, made)(*given)
    assert own.shape == (2, 3, sum(part.variables.values()))
    for i in np.ndindex(2, 3):
        np.testing.assert_allclose(own[i], getattr(part, made)(*(x[i] for x in given)), rtol=0, atol=2e-15)
    if back:  # sums and differences of numbers up to 10
        np.testing.assert_allclose(getattr(part, back)(own, given[-1]), given[-2], rtol=0, atol=1e-14)


def members(part):
    """Three bodies with a part, each with its own values of the variables."""
    system = pt.System(pt.Body([(6.0, 8.0, 10.0), (6.5, 8.0, 9.0), (7.0, 7.5, 10.0)]), part)
    start = system.state(IDENTITY, omega_body=OMEGA)
    own = {name: values * np.array([[1.0], [1.2], [0.8]]) for name, values in start.own.items()}
    return system, system.state(IDENTITY, omega_body=OMEGA, **own)


def one_of(many, i):
    """One of them."""
    system, start = many
    alone = pt.System(pt.Body(system.body.moments[i]), *system.forces)
    return alone, alone.state(IDENTITY, omega_body=OMEGA, **{name: values[i] for name, values in start.own.items()})


@each_part
def test_other_values_of_the_variables_build_no_other_kernel(part, monkeypatch, forget_kernels):
    monkeypatch.setattr(type(part), "check_start", lambda *_: None)  # of wheels that are too fast
    system = pt.System(BODY, part)
    each = [{name: factor * values for name, values in started(system).own.items()} for factor in (1e-6, 1.0, 3e4)]
    starts = [system.state(IDENTITY, omega_body=OMEGA, **own) for own in each]
    built = []
    for start in starts:
        forget_kernels()
        built.append(pt.propagate(system, start, [0.01]))
    monkeypatch.setattr(kernels, "compiled", None)
    for start, expected in zip(starts, built, strict=True):
        motion = pt.propagate(system, start, [0.01])
        for name, values in expected.phase.items():
            np.testing.assert_array_equal(motion.phase[name], values)


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
        assert abs(plain(time).own[part.name][0] - level) < 1e-14


class Kick(pt.Event):
    """An action that turns the body by a tenth faster, and halves the variables of a part if it has some."""

    part: Part
    time: float

    def value(self, instant):
        return instant.time - self.time

    def act(self, body, state):
        faster = 1.1 * np.array(body.omega(state.angular_momentum_body))
        state = body.state(state.attitude, omega_body=faster, time=state.time)
        own = {self.part.name: 0.5 * np.array(list(body.own(self.part)))} if self.part.size else {}
        return pt.State(state.quaternion, state.conjugate_momenta, state.time, own=own)


@each_part
def test_an_action_is_a_new_start(part):
    system = pt.System(BODY, part, ReactionWheel((0, 1, 0), 0.2, 0.01, name="another"))
    start, times = started(system), [2.0, 3.3, 6.0]
    motion = pt.propagate(system, start, times, events=[Kick(part, 3.0)], dense=True)
    before = pt.propagate(system, start, [3.0])
    after = 1.1 * before.omega_body[0]
    own = {name: values[0] * (0.5 if name == part.name else 1.0) for name, values in before.own.items()}
    # Both ends of g = K^-1 omega + h have the variables before: the action makes its state of the body it is given.
    copied: Any = system.dynamics.with_numbers(system.dynamics.numbers)
    body = copied.body_at({n: Vector(v[0]) for n, v in before.own.items()}, 3.0)
    g = np.array(list(body.angular_momentum(Vector(after))))
    state = system.state(before.attitude[0], angular_momentum_body=g, time=3.0, **own)
    again = pt.propagate(system, state, times[1:])
    for name, values in again.phase.items():
        # Three times the worst of shaken starts.
        np.testing.assert_allclose(motion.phase[name][1:], values, rtol=0, atol=3e-14)
        np.testing.assert_allclose(motion(6.0).phase[name], values[-1], rtol=0, atol=3e-14)


@each_part
def test_members_and_actions_on_them_are_as_if_alone(part):
    many = members(part)
    motion = pt.propagate(*many, TIMES[:6], events=[Kick(part, 3.3)])
    assert not motion.failures
    for i in range(3):
        single = pt.propagate(*one_of(many, i), TIMES[:6], events=[Kick(part, 3.3)])
        np.testing.assert_allclose(motion.quaternion[i], single.quaternion, rtol=0, atol=1e-13)
        np.testing.assert_allclose(motion.energy[i], single.energy, rtol=1e-13)
        for name, values in single.own.items():
            np.testing.assert_allclose(motion.own[name][i], values, rtol=0, atol=1e-13)


def test_an_action_may_name_no_part_that_is_not_there():
    class Wrong(Kick):
        def act(self, body, state):  # noqa: ARG002
            return pt.State(state.quaternion, state.conjugate_momenta, state.time, own={"other": (0.0,)})

    system = pt.System(BODY, PARTS[1])
    with pytest.raises(pt.PropagationError, match="must return variables of parts of the system, got some of 'other'"):
        pt.propagate(system, started(system), TIMES, events=[Wrong(PARTS[1], 3.3)])


# ---------------------------------------------------------------------- variational equations

FIRST = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Central differences of order six: truncation h^6, rounding of starts 1e-16 / h, in quadruple precision."""
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.5, node=0.2, argument_of_periapsis=0.3)


def differences(function, h=1e-3):
    return sum(c * (function(k * h) - function(-k * h)) for k, c in FIRST) / h


def attracted(part):
    """A part in a body on a circle: gravity pulls at the variables of some."""
    return pt.System(BODY, part, pt.GravityGradient(CIRCLE))


NUMBERS = slice(None, None, 4)
"""Of the numbers of a part, those by which the motion is differentiated: each adds a vector to the kernel."""


def names_of(part):
    return [f"forces[0].{name}" for name, _ in part.number_names()][NUMBERS]


def displaced(system, state, x):
    """The state at tangent coordinates x from another one."""
    places = np.cumsum([6, *(values.size for values in state.own.values())])
    own = {name: v + step for (name, v), step in zip(state.own.items(), np.split(x, places)[1:-1], strict=True)}
    turned = state.attitude * Rotation.from_rotvec(x[:3])
    return system.state(turned, angular_momentum_body=state.angular_momentum_body + x[3:6], **own)


def displacement(motion, reference):
    turn = (reference.attitude.inv() * motion.attitude).as_rotvec()
    names = [name for name in motion.phase if name != "quaternion"]
    return np.concatenate([turn, *(motion.phase[n] - reference.phase[n] for n in names)], axis=-1)[-1]


def end(system, state, x):
    return pt.propagate(system, displaced(system, state, x), [1.7], precision="quadruple")


@pytest.mark.samples
@each_varied_part
def test_state_transition_is_the_derivative_by_start_and_parameters(part):
    system = attracted(part)
    state, names = started(system), names_of(part)
    # Bounds are three times the worst of 20 starts shaken by an ulp, with 2, 4 and 8 lanes.
    found = pt.analysis.state_transition(system, state, [0.3, 1.7], names)
    k = 6 + part.size
    assert found.matrix.shape == (2, k, k)
    assert found.sensitivity.shape == (2, k, len(names))
    reference, numbers = end(system, state, np.zeros(k)), np.array(list(part.numbers), dtype=float)
    for name, values in pt.propagate(system, state, [1.7]).phase.items():  # by the other kernel
        np.testing.assert_allclose(values, reference.phase[name], rtol=0, atol=4e-14)
    step = 5e-4 if isinstance(part, ReactionWheels) else 1e-3  # dry friction is steep about rest

    def column(x, p):
        # By the numbers alone: an axis that is not of length one is none of a wheel, but a number of the formula.
        moved = lambda h: attracted(part.with_numbers(numbers + h * p))  # noqa: E731
        return differences(lambda h: displacement(end(moved(h), state, h * x), reference), step)

    # Sums and differences of all columns; a rounding of a displaced start counts a thousand times.
    for x in np.random.default_rng(1).choice([-1.0, 1.0], (3, k)):
        np.testing.assert_allclose(found.matrix[-1] @ x, column(x, 0 * numbers), rtol=0, atol=6e-11)
    sizes = np.zeros(numbers.size)
    sizes[NUMBERS] = 0.5 * numbers[NUMBERS] + 0.1 * (numbers[NUMBERS] == 0)
    sensitivity = found.sensitivity[-1] @ sizes[NUMBERS]
    np.testing.assert_allclose(sensitivity, column(np.zeros(k), sizes), rtol=0, atol=7e-12)
    there = pt.propagate(system, state, [0.0, 1.7], dense=True)(1.7)
    back = pt.analysis.state_transition(system, there, [0.0], names)
    np.testing.assert_allclose(back.matrix[0] @ found.matrix[-1], np.eye(k), rtol=0, atol=1e-13)


@pytest.mark.samples
@each_varied_part
def test_variational_equations_of_members_are_those_of_each_alone(part):
    many = members(part)
    found, spectra = pt.analysis.state_transition(*many, [1.7]), pt.analysis.lyapunov_spectrum(*many, [5.0])
    for i in range(3):
        single = pt.analysis.state_transition(*one_of(many, i), [1.7])
        np.testing.assert_allclose(found.matrix[i], single.matrix, rtol=0, atol=6e-15)
        # The unit of a displacement is of the largest of the members; the volume has none.
        sums = (np.sum(pt.analysis.lyapunov_spectrum(*one_of(many, i), [5.0]).exponents), np.sum(spectra.exponents[i]))
        assert abs(sums[0] - sums[1]) < 1e-13


@pytest.mark.parametrize(
    "part",
    [p if isinstance(p, QUICK) else pytest.param(p, marks=pytest.mark.slow) for p in PARTS],
    ids=lambda part: type(part).__name__,
)
def test_second_derivatives_leave_a_third_order_error(part):
    system, name = pt.System(BODY, part), next(iter(part.number_names()))[0]
    state, k = started(system), 6 + part.size
    found = pt.analysis.state_transition(system, state, [1.7], [f"forces[0].{name}"], order=2)
    first = np.concatenate([found.matrix, found.sensitivity], axis=-1)[0]
    direction = np.cos(np.arange(k + 1)) / 3
    reference, numbers = end(system, state, np.zeros(k)), np.array(list(part.numbers), dtype=float)

    def error(h):
        x = h * direction
        changed = part.with_numbers(numbers + x[-1] * np.eye(numbers.size)[0])
        expanded = first @ x + 0.5 * np.einsum("ijk,j,k->i", found.second[0], x, x)
        return np.max(np.abs(displacement(end(pt.System(BODY, changed), state, x[:-1]), reference) - expanded))

    assert error(4e-3) / error(2e-3) == pytest.approx(8, rel=0.1)
    assert error(1e-3) < 1e-9


# ---------------------------------------------------------------------- what does not work with parts yet


def test_planar_motion_refuses_parts():
    system = pt.System(pt.Body((6, 8, 10)), Gyrostat((0, 0, 1)))
    with pytest.raises(ValueError, match="formulation 'planar' must be for a body without parts, got Gyrostat"):
        pt.propagate(system, system.state(IDENTITY, omega_body=(0, 0, 1)), TIMES, formulation="planar")


def test_gravity_does_work_on_parts():
    # On a circular orbit H - n . G is constant, whatever the parts do without loss: torque, pull and rates agree.
    spring = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 20.0)
    system = pt.System(BODY, spring, pt.GravityGradient(CIRCLE))
    motion = pt.propagate(system, started(system), TIMES)
    assert np.max(np.abs(motion.drift["jacobi_energy"])) < 1e-14


@each_part
def test_files_bring_back_the_motion_of_every_part(part, tmp_path):
    system = pt.System(BODY, part)
    motion = pt.propagate(system, started(system), TIMES)
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert isinstance(read.system, pt.System) is (type(part).__module__.partition(".")[0] == "poinsot")
    for name in motion.dataset.variables:
        np.testing.assert_array_equal(read.dataset[name].values, motion.dataset[name].values, err_msg=name)


@pytest.mark.parametrize("part", [part for part in PARTS if part.size], ids=lambda part: type(part).__name__)
def test_equilibria_refuse_parts_with_variables(part):
    with pytest.raises(ValueError, match=f"system must have no parts with variables, got {type(part).__name__}"):
        pt.analysis.equilibria(pt.System(BODY, part))


def test_equilibria_refuse_a_part_that_changes_with_time():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    system = pt.System(BODY, Boom(0.2, 0.1), pt.GravityGradient(orbit))
    with pytest.raises(ValueError, match="system must look the same from the frame at all times"):
        pt.analysis.equilibria(system, orbit.frame)
