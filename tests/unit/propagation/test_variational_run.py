"""Runs of variational equations, resolved once."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.propagation.arguments import checked_settings
from poinsot.propagation.variational_run import Derivatives, UserUnits, VariationalRun
from poinsot.records.members import members_of

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)))
ONE = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 3.0))
MANY = BODY.state((1, 0, 0, 0), omega_body=np.linspace((0.1, 0.2, 3.0), (0.2, 0.3, 30.0), 5))
SETTINGS = checked_settings(None, None, 1, False)


def run(state, **derivatives):
    return VariationalRun.of(TOP, state, [1.0, 2.0], SETTINGS, Derivatives(**derivatives))


def test_one_body_has_a_member_axis_of_one_in_its_state_alone():
    alone = run(ONE)
    assert not alone.is_ensemble
    assert alone.state.time.shape == (1,)
    assert alone.units.shape == (6,)
    assert run(MANY).units.shape == (5, 6)


def test_members_have_the_variables_of_the_whole_run():
    whole, who = run(MANY), np.array([3, 1])
    some = members_of(whole, who)
    assert np.array_equal(some.units, whole.units[who])
    assert np.array_equal(some.state.quaternion, whole.state.quaternion[who])


def test_copies_of_members_have_their_own_derivatives():
    sizes = np.arange(10).reshape(5, 2)
    whole = run(MANY, inputs=((0,), (1,)), sizes=sizes)
    copies = whole.repeated(2, Derivatives(((1,),), 1, sizes[:, 1:]))
    assert copies.derivatives.sizes.ravel().tolist() == np.repeat(sizes[:, 1], 2).tolist()
    assert copies.state.time.shape == (10,)
    assert whole.repeated(2).derivatives.inputs == ()
    assert run(ONE).repeated(3).is_ensemble


def test_the_default_unit_of_momenta_is_the_largest_moment_times_the_rate():
    rates = np.arange(1.0, 6.0)
    units = run(MANY).user_units(rates)
    assert np.array_equal(units.momentum, 1.25 * rates)
    assert np.array_equal(units.weights[:, :3], np.ones((5, 3)))
    with pytest.raises(ValueError, match=r"^momentum_unit must be positive"):
        run(MANY).user_units(rates, -1.0)


def test_vectors_in_units_of_the_user_and_back():
    units = UserUnits(np.array([[1.0, 2.0], [1.0, 4.0]]), np.array([2.0, 4.0]))
    vectors = np.array([[1.0, 1.0], [0.0, 3.0]])
    inside = units.multiplied(vectors)
    assert inside.tolist() == [[[1, 2], [0, 6]], [[1, 4], [0, 12]]]
    assert np.array_equal(units.divided(np.array([1]), inside[1:]), vectors[None])
    assert np.array_equal(units.divided(np.array([1]), inside[1:, None]), vectors[None, None])


def test_a_formulation_without_tangent_coordinates_is_refused():
    settings = checked_settings("canonical", None, 1, False)
    with pytest.raises(ValueError, match=r"^formulation must be one of .* for variational equations, got 'canonical'"):
        VariationalRun.of(TOP, ONE, [1.0], settings)
