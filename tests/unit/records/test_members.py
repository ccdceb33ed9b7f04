"""Selection of members: one function for every kind of object."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.double_double import DoubleDouble
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem
from poinsot.mechanics.part import Jump
from poinsot.records.members import EveryMember, members_of

MOMENTS = np.array([[1.25, 1.0, 0.75], [1.3, 1.0, 0.75], [1.35, 1.0, 0.75], [1.4, 1.0, 0.75]])
BODY = pt.Body(MOMENTS)
GRAVITY = pt.UniformGravity([0.1, 0.2, 0.3, 0.4], (1, 0, 0))
CROSSING = pt.events.RateCrossing((1, 0, 0), rate=[0.1, 0.2, 0.3, 0.4])
SYSTEM = pt.System(BODY, GRAVITY, units={"time": "s"})
STATES = BODY.state((1, 0, 0, 0), omega_body=np.arange(12.0).reshape(4, 3), time=[0.0, 1.0, 2.0, 3.0])
SOME = [2, slice(1, 3), np.array([3, 0, 0]), np.array([True, False, False, True])]


def chosen(members):
    return np.arange(4)[members]


@pytest.mark.parametrize("members", SOME, ids=repr)
def test_records_systems_and_states(members):
    system, state = members_of(SYSTEM, members), members_of(STATES, members)
    assert np.array_equal(system.body.moments, MOMENTS[members])
    gravity = members_of(GRAVITY, members)
    assert repr(system.forces[0]) == repr(gravity)
    assert np.array_equal(gravity.weight, np.asarray(GRAVITY.weight)[members])
    assert np.array_equal(gravity.center_of_mass, GRAVITY.center_of_mass)
    assert system.members == np.shape(chosen(members))
    assert system.units == SYSTEM.units
    assert np.array_equal(state.time, chosen(members))
    for name, values in STATES.phase.items():
        assert np.array_equal(state.phase[name], values[members])


@pytest.mark.parametrize("members", SOME, ids=repr)
def test_problems_and_state_vectors(members):
    problem = Problem(SYSTEM, [CROSSING])
    variables = equations.state_vector(problem, STATES, FORMULATIONS["lie_poisson"], "double")
    own = members_of(problem, members)
    assert repr(own.events[0]) == repr(members_of(CROSSING, members))
    assert np.array_equal(members_of(CROSSING, members).rate, np.asarray(CROSSING.rate)[members])
    assert np.array_equal(own.system.body.moments, MOMENTS[members])
    assert np.array_equal(members_of(variables, members).scale, np.asarray(variables.scale)[members])


def test_what_all_members_share_is_the_same_object():
    alone = pt.System(pt.Body(MOMENTS[0]), pt.UniformGravity(0.1, (1, 0, 0)))
    for thing in (alone, alone.body, alone.forces[0], pt.Body(MOMENTS[0]).state((1, 0, 0, 0), omega_body=(0, 0, 1))):
        assert members_of(thing, slice(0, 2)) is thing


def test_numbers_in_two_words_and_jumps():
    both = members_of(DoubleDouble(np.arange(3.0), np.arange(3.0) / 1e20), 2)
    assert (both.hi, both.lo) == (2.0, 2e-20)
    jump = members_of(Jump(np.array([1.0, 2.0]), 0.5, draws=3), 1)
    assert (jump.period, jump.offset, jump.draws) == (2.0, 0.5, 3)


def test_every_member_has_its_own_number():
    assert EveryMember()[5].tolist() == [5]
    assert EveryMember()[3:6].tolist() == [3, 4, 5]
    assert EveryMember()[np.array([7, 2])].tolist() == [7, 2]
