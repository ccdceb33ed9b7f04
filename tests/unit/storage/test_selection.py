"""Some members and times of a motion: what belongs to a member comes along."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt

MASSES = np.array([0.4, 0.45, 0.5, 0.55])
PRIMARY = pt.Body((2.0, 2.5, 3.0), mass=3.0)
PAIR = pt.TwoBodies(PRIMARY, pt.Body((0.1, 0.12, 0.15), mass=MASSES), G=1.0)
RATES = np.linspace(0.3, 0.5, 4)[:, None] * [0.0, 0.1, 1.0]
START = PAIR.state(
    (6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), [(0.8, 0, 0.6, 0), (0.5, 0.5, -0.5, 0.5)], omega_body=[(0.1, 0.2, 1.0), RATES]
)


class Extreme(pt.Event):
    """The distance of two bodies is an extreme, plus a number of each member."""

    offset: float

    def value(self, instant):
        return pt.functions.dot(instant.separation, instant.relative_velocity) - self.offset


@pytest.fixture(scope="module")
def motion() -> Any:
    damping = pt.forces.LinearDamping(np.array([0.0, 1e-3, 2e-3, 3e-3])).on("secondary")
    system = pt.System(PAIR, pt.forces.MutualGravity(), damping)
    events = [Extreme(np.array([0.0, 0.1, 0.2, 0.3]))]
    return pt.propagate(system, START, np.linspace(0, 40, 5), events=events)


def coefficient(motion):
    return motion.system.forces[1].force.coefficient


def test_a_member_of_two_bodies_has_its_own_numbers(motion):
    for i, mass in enumerate(MASSES):
        one = motion.member(i)
        assert one.system.members == ()
        assert one.system.body.secondary.mass == mass
        assert one.system.body.primary.mass == 3.0
        assert one.system.body.masses.tolist() == [3.0, mass]
        assert coefficient(one) == 1e-3 * i
        assert np.array_equal(one.initial.secondary.angular_momentum_body, START.secondary.angular_momentum_body[i])
        for name in ("position", "momentum", "velocity", "kinetic_energy", "potential_energy"):
            assert np.array_equal(getattr(one, name), getattr(motion, name)[i]), name
        assert np.array_equal(one.secondary.quaternion, motion.secondary.quaternion[i])
        assert np.array_equal(one.primary.omega_body, motion.primary.omega_body[i])


def test_some_members_and_times_of_two_bodies(motion):
    few = motion.isel(member=[3, 1], time=slice(1, 4))
    assert few.system.body.secondary.mass.tolist() == [0.55, 0.45]
    assert few.system.body.masses.tolist() == [[3.0, 0.55], [3.0, 0.45]]
    assert coefficient(few).tolist() == [3e-3, 1e-3]
    assert np.array_equal(few.position, motion.position[[3, 1], 1:4])
    assert np.array_equal(few.secondary.omega_body, motion.secondary.omega_body[[3, 1], 1:4])
    assert np.array_equal(few[0].distance, motion[3].distance[1:4])


def test_events_of_two_bodies_go_with_their_members(motion):
    (found,) = motion.events
    assert np.unique(found.members).size == 4
    for i in range(4):
        own, one = found.member(i), motion.member(i).events[0]
        assert one.event.offset == [0.0, 0.1, 0.2, 0.3][i]
        assert np.array_equal(one.times, own.times)
        assert np.array_equal(one.states.position, own.states.position)
        assert np.array_equal(one.states.secondary.quaternion, own.states.secondary.quaternion)
        values = np.sum(one.states.position * one.states.momentum, axis=-1)
        mass = 3.0 * MASSES[i] / (3.0 + MASSES[i])
        assert np.allclose(values / mass, one.event.offset, rtol=0, atol=1e-14)


def test_a_state_of_two_bodies_at_one_time(motion):
    there = motion.isel(member=2, time=3)
    assert isinstance(there, pt.PairState)
    assert np.array_equal(there.position, motion.position[2, 3])
    assert there.time == motion.times[3]
    assert motion.isel(time=3).shape == (4,)


def test_a_member_of_one_body_has_its_own_mass():
    body = pt.Body((1.0, 1.1, 1.2), mass=MASSES)
    start = body.state((1, 0, 0, 0), omega_body=RATES)
    heavy = pt.System(body, pt.UniformGravity(MASSES, (0.1, 0, 0)))
    motion: Any = pt.propagate(heavy, start, [0.0, 1.0])
    assert motion.member(3).system.body.mass == 0.55


def test_a_body_that_all_pairs_share_keeps_its_semiaxes():
    """They are three numbers of one body, not one of each of three members."""
    squares, masses = np.array([1.2, 1.3, 1.4, 1.5])[:, None] * (1.0, 1.2, 1.5), np.full(4, 2.0)
    pair = pt.TwoBodies(pt.Body.from_ellipsoid(5.0, (3, 2, 1)), pt.Body(0.1 * squares, mass=masses), G=1.0)
    start = pair.synchronous(distance=20.0, primary_rate=1.0)
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [1.0], progress=False)
    for one in motion:
        assert np.array_equal(one.system.body.primary.semiaxes, (3, 2, 1))
        assert one.system.body.primary.mass == 5.0
