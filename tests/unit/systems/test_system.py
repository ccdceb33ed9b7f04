"""A body and the forces on it: energies, parameters, structure, formulas of a user."""

import itertools
import pickle
from typing import Annotated, Any

import numpy as np
import pytest

import formulas
import poinsot as pt
from poinsot import functions


class Spring(pt.Potential):
    """stiffness / 2 * (a . s3 in body axes)^2"""

    stiffness: float
    axis: pt.mechanics.Vector

    def energy(self, instant):
        return 0.5 * self.stiffness * functions.dot(self.axis, instant.attitude.to_body((0, 0, 1))) ** 2


class Push(pt.Torque):
    """A torque about the first body axis, as a plain tuple with zeros."""

    strength: float

    def torque(self, instant):
        return (self.strength * instant.omega_body[0], 0.0, 0)


class Choice(pt.Potential):
    """Structure decides by a Python `if`, which is allowed."""

    degree: int
    factor: float

    def energy(self, instant):
        u = instant.attitude.to_body((0, 0, 1))[0]
        return self.factor * (u if self.degree == 1 else u**2)


class Table(pt.Potential):
    """A parameter of a shape of its own."""

    coefficients: Annotated[Any, (3, 3)]

    def energy(self, instant):
        u = instant.attitude.to_body((0, 0, 1))
        return sum(self.coefficients[i, j] * u[i] * u[j] for i in range(3) for j in range(3))


# ---------------------------------------------------------------------- energy


def test_energy_of_the_top_at_a_state(body, start):
    top = pt.System(body, pt.UniformGravity(0.5, (1.0, 0.2, -0.3)))
    height = start.attitude.apply([1.0, 0.2, -0.3])[2]
    omega = np.array([0.4, -0.3, 0.6])
    assert top.kinetic_energy(start) == pytest.approx(0.5 * np.sum([1.25, 1.0, 0.75] * omega**2), rel=1e-14, abs=0)
    assert top.potential_energy(start) == pytest.approx(0.5 * height, rel=1e-14, abs=0)
    assert top.energy(start) == pytest.approx(top.kinetic_energy(start) + top.potential_energy(start), rel=1e-15, abs=0)


def test_energies_of_several_states_have_their_shape(body, top):
    state = body.state((1, 0, 0, 0), omega_body=np.arange(15.0).reshape(5, 3))
    for energy in (top.kinetic_energy, top.potential_energy, top.energy):
        assert energy(state).shape == (5,)


def test_potentials_add(body, start):
    gravity, spring = pt.UniformGravity(0.5, (1, 0, 0)), Spring(2.0, (0, 1, 0))
    both = pt.System(body, gravity, spring).potential_energy(start)
    one, other = (pt.System(body, force).potential_energy(start) for force in (gravity, spring))
    assert both == pytest.approx(one + other, rel=1e-15, abs=0)


def test_a_system_without_forces_has_no_potential_energy(body, start):
    assert pt.System(body).potential_energy(start) == 0
    assert pt.System(body).energy(start) == pt.System(body).kinetic_energy(start)


def test_a_torque_has_no_potential_energy(body, start):
    assert pt.System(body, pt.forces.LinearDamping(0.1)).potential_energy(start) == 0


def test_energy_of_a_moving_attractor_depends_on_the_time(satellite):
    states = [satellite.body.state((1, 0, 0, 0), omega_body=(0, 0, 1), time=t) for t in (0.0, 1.0)]
    assert abs(np.diff([satellite.potential_energy(s) for s in states])[0]) > 1e-3


# ---------------------------------------------------------------------- parameters and structure


def test_a_second_diagnostic_makes_no_records(satellite, start, monkeypatch):
    first = pt.System(satellite.body, *satellite.forces)
    made, with_numbers = [], pt.Body.with_numbers

    def counted(*given):
        made.append(given)
        return with_numbers(*given)

    monkeypatch.setattr(pt.Body, "with_numbers", counted)
    energy, torque, rate = first.energy(start), first.torque_body(start), first.omega_body(start)
    assert len(made) == 1
    assert (first.energy(start), first.torque_body(start).tolist(), first.omega_body(start).tolist()) == (
        energy,
        torque.tolist(),
        rate.tolist(),
    )
    assert len(made) == 1
    several = pt.State(np.stack([start.quaternion] * 3), np.stack([start.conjugate_momenta] * 3))
    assert np.allclose(first.energy(several), energy, rtol=1e-14, atol=0)
    assert len(made) == 2


def test_structure_holds_no_number(body):
    one = pt.System(body, pt.UniformGravity(0.5, (1, 0, 0)))
    other = pt.System(pt.Body((1, 2, 2.5)), pt.UniformGravity(1.5, (0, 2, 0)))
    assert one.dynamics.structure == other.dynamics.structure
    assert hash(one.dynamics.structure) == hash(other.dynamics.structure)


def test_structure_tells_forces_and_integers_apart(body):
    systems = [
        pt.System(body),
        pt.System(body, pt.forces.LinearDamping(0.1)),
        pt.System(body, pt.UniformGravity(0.5, (1, 0, 0))),
        pt.System(body, Choice(1, 1.0)),
        pt.System(body, Choice(2, 1.0)),
        pt.System(body, Choice(1, 1.0), pt.forces.LinearDamping(0.1)),
        pt.System(body, pt.GravityGradient(pt.orbits.FixedPosition(1.0, position=(1, 0, 0)))),
        pt.System(body, pt.GravityGradient(pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0))),
        pt.System(pt.Body.from_inertia([[2, 0.1, 0], [0.1, 2, 0], [0, 0, 2]])),
    ]
    assert len({system.dynamics.structure for system in systems}) == len(systems)


def test_numbers_are_in_the_order_of_declaration(body):
    system = pt.System(body, pt.UniformGravity(0.5, (1, 2, 3)), pt.forces.LinearDamping(0.1))
    assert [float(x) for x in system.dynamics.numbers] == [1.25, 1.0, 0.75, 0.5, 1, 2, 3, 0.1]


def test_with_numbers_puts_each_scalar_in_its_place(body):
    system = pt.System(body, pt.UniformGravity(0.5, (1, 2, 3)), pt.forces.LinearDamping(0.1))
    copied: Any = system.dynamics.with_numbers(iter(range(100, 108)))
    assert list(copied.body.moments) == [100, 101, 102]
    assert copied.forces[0].weight == 103
    assert list(copied.forces[0].center_of_mass) == [104, 105, 106]
    assert copied.forces[1].coefficient == 107


def test_with_its_own_numbers_a_system_is_the_same(satellite, start):
    copied = formulas.copied(satellite, satellite.dynamics.numbers)
    q = functions.Vector(start.quaternion)
    assert formulas.potential(copied, q, 0.7) == pytest.approx(
        satellite.potential_energy(pt.State(start.quaternion, start.conjugate_momenta, 0.7)), rel=1e-14, abs=0
    )


def test_with_numbers_fills_tables_row_by_row(body):
    copied: Any = pt.System(body, Table(np.zeros((3, 3)))).dynamics.with_numbers(itertools.count())
    assert copied.forces[0].coefficients.tolist() == [[3, 4, 5], [6, 7, 8], [9, 10, 11]]


def test_parameters_keep_a_copy():
    arm = np.array([1.0, 0.0, 0.0])
    force = pt.UniformGravity(0.5, arm)
    arm[0] = 9.0
    assert force.center_of_mass[0] == 1.0


def test_repr_names_the_parts(body):
    text = repr(pt.System(body, pt.forces.LinearDamping(0.1)))
    assert text.startswith("System(Body(")
    assert "LinearDamping(" in text


def test_units_are_names_with_a_default(body):
    assert pt.System(body).units == {"time": "1", "inertia": "1"}
    assert pt.System(body, units={"time": "s", "inertia": "kg m2"}).units == {"time": "s", "inertia": "kg m2"}
    assert pt.System(body, units={"time": "s"}).units == {"time": "s", "inertia": "1"}


# ---------------------------------------------------------------------- formulas of a user


@pytest.mark.parametrize(
    "force", [Spring(2.0, (0, 1, 0)), Push(0.3), Choice(1, 0.5), Choice(2, 0.5), Table(np.diag([1.0, 2.0, 3.0]))]
)
def test_a_users_force_is_accepted_and_runs(force, body, start):
    motion = pt.propagate(pt.System(body, force), start, [0.0, 1.0])
    assert np.all(np.isfinite(motion.quaternion))


def test_a_users_torque_may_be_a_tuple_of_numbers_and_components(body, start):
    motion = pt.propagate(pt.System(body, Push(0.3)), start, [0.0, 1e-4])
    change = (motion.angular_momentum_body[1] - motion.angular_momentum_body[0]) / 1e-4
    omega = motion.omega_body[0]
    expected = np.cross(motion.angular_momentum_body[0], omega) + np.array([0.3 * omega[0], 0, 0])
    assert np.allclose(change, expected, rtol=0, atol=1e-4)


def test_a_users_torque_may_be_constant(body):
    class Steady(pt.Torque):
        size: float

        def torque(self, instant):  # noqa: ARG002
            return (0.0, 0.0, self.size)

    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    motion = pt.propagate(pt.System(body, Steady(0.3)), state, [0.0, 2.0])
    assert np.allclose(motion.angular_momentum_body[1], [0, 0, 0.6], rtol=0, atol=1e-15)


def test_a_users_potential_with_where(body):
    class OneSided(pt.Potential):
        stiffness: float

        def energy(self, instant):
            u = instant.attitude.to_body((0, 0, 1))[2]
            return functions.where(functions.less(u, 0.0), self.stiffness * u**2, 0.0)

    upright, hanging = (body.state(q, omega_body=(0, 0, 0)) for q in ((1, 0, 0, 0), (0, 1, 0, 0)))
    system = pt.System(body, OneSided(3.0))
    assert system.potential_energy(upright) == 0
    assert system.potential_energy(hanging) == 3


def test_torque_is_minus_the_derivative_of_the_energy_along_a_turn(body, start, rng):
    system = pt.System(body, Spring(2.0, (0.3, 1, -0.4)), pt.UniformGravity(0.7, (0.1, -0.5, 1)))
    motion = pt.propagate(system, start, [-1e-4, 0.0, 1e-4])
    g = motion.angular_momentum_body
    torque = (g[2] - g[0]) / 2e-4 - np.cross(g[1], motion.omega_body[1])
    for direction in rng.normal(size=(4, 3)):
        power = torque @ direction
        ahead, back = (
            system.potential_energy(pt.State((start.attitude * turn), (0, 0, 0, 0)))
            for turn in (type(start.attitude).from_rotvec(sign * 1e-5 * direction) for sign in (1, -1))
        )
        assert power == pytest.approx(-(ahead - back) / 2e-5, abs=1e-7)


def test_torques_of_each_force_add_up_to_that_of_all():
    body = pt.Body((1.25, 1.0, 0.75))
    forces = pt.UniformGravity(0.5, (1, 0, 0)), pt.forces.LinearDamping(0.1), pt.forces.LinearDamping(0.3)
    system = pt.System(body, *forces)
    state = system.state((0.5, -0.5, 0.5, 0.5), omega_body=(0.1, -0.2, 0.4))
    found = system.torques_body(state)
    assert list(found) == ["UniformGravity", "LinearDamping", "LinearDamping 2"]
    assert found["LinearDamping 2"] == pytest.approx(-0.3 * np.array([0.1, -0.2, 0.4]), rel=1e-15, abs=0)
    assert sum(found.values()) == pytest.approx(system.torque_body(state), abs=3e-16)
    motion = pt.propagate(system, state, [0.0, 1.0])
    assert np.array_equal(motion.torques_body["UniformGravity"][0], found["UniformGravity"])


def test_systems_of_one_structure_share_results():
    systems = [pt.System(pt.Body(moments), Push(2.0)) for moments in ((1.0, 1.6, 2.5), (1.0, 1.2, 1.4))]
    first, second = (system.dynamics for system in systems)
    assert first.alike is second.alike
    assert pickle.loads(pickle.dumps(systems[0])).dynamics.alike is first.alike
    assert pt.System(systems[0].body, Push(2.0), Push(3.0)).dynamics.alike is not first.alike


def test_results_with_numbers_belong_to_one_system_and_no_pickle_contains_them():
    first, second = (pt.System(pt.Body((1.0, 1.6, 2.5)), Push(push)).dynamics for push in (2.0, 3.0))
    first.results["sum"] = lambda: 2.0  # no pickle can contain a function within a function
    assert "sum" not in second.results
    assert "sum" not in pickle.loads(pickle.dumps(first)).results


@pytest.mark.parametrize(
    ("word", "symbol"),
    [("seconds", "s"), ("sec", "s"), ("Minutes", "min"), ("hours", "h"), ("days", "d"), ("years", "yr"), ("TU", "TU")],
)
def test_words_for_units_of_time(word, symbol):
    assert pt.System(pt.Body((1.0, 1.0, 1.0)), units={"time": word}).units["time"] == symbol


def test_span_and_calendar_of_several_orbits():
    calendar = pt.Calendar("2026-01-01T00:00:00", "TDB")
    circle = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)

    def table(first, last, calendar=None):
        def position(times):
            return np.transpose(circle.position_at(times))

        return pt.orbits.Ephemeris.from_function(1.0, position=position, start=first, stop=last, calendar=calendar)

    body = pt.Body((1.0, 2.0, 3.0))
    several = pt.System(
        body,
        pt.GravityGradient(circle),
        pt.GravityGradient(table(0.0, 3.0, calendar)),
        pt.GravityGradient(table(1.0, 4.0)),
    )
    assert several.span == (1.0, 3.0)
    assert several.calendar == calendar
    assert pt.System(body, pt.GravityGradient(circle)).span == (-np.inf, np.inf)
    assert pt.System(body).calendar is None
