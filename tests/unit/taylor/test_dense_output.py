"""The polynomials of steps at many times: as machine code, in any order of the times."""

import copy
import pickle

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration.state_vector import ROWS_PER_BLOCK
from poinsot.taylor.dense_output import StoredSteps

EPS = np.finfo(float).eps
LENGTHS = np.array([0.5, 0.25, 1.0, 0.125])


def stored(size, orders, sign=1.0):
    """Return steps one after another, with coefficients that fall as those of a Taylor series do."""
    rng = np.random.default_rng(size)
    fields = [("start", "f8", (2,)), ("length", "f8"), ("per_unit", "f8"), ("coefficients", "f8", (orders, size))]
    steps = np.zeros(LENGTHS.size, fields)
    steps["per_unit"] = 1.0
    steps["length"], steps["start"][:, 0] = sign * LENGTHS, sign * np.append(0.0, np.cumsum(LENGTHS)[:-1])
    steps["start"][:, 1] = 1e-17
    steps["coefficients"] = rng.normal(size=(LENGTHS.size, orders, size))
    return steps


def expected(steps, times):
    """Return the values, summed power by power in extended precision, and the sums of the sizes of their terms."""
    first, last = steps["start"][:, 0], steps["start"][:, 0] + steps["length"]
    values, sizes = [], []
    for time in times:
        (k,) = np.flatnonzero((np.minimum(first, last) < time) & (time < np.maximum(first, last)))
        h = np.longdouble(time) - steps["start"][k].astype(np.longdouble).sum()
        terms = steps["coefficients"][k] * h ** np.arange(steps["coefficients"].shape[1])[:, None]
        values.append(terms.sum(axis=0))
        sizes.append(np.abs(terms).sum(axis=0))
    return np.array(values), np.array(sizes)


@pytest.mark.parametrize(("sign", "cut"), [(1.0, 0), (-1.0, 1), (1.0, 3), (-1.0, 4)])
@pytest.mark.parametrize(("size", "orders"), [(1, 3), (7, 19), (8, 19), (17, 24)])
def test_polynomials_at_times_in_any_order(size, orders, sign, cut):
    steps = stored(size, orders, sign)
    blocks = [steps[:cut], steps[cut:]]
    times = sign * np.random.default_rng(1).uniform(0.0, LENGTHS.sum(), 300)
    values, sizes = expected(steps, times)
    # Horner: two roundings an order, and one of the time since the start in each power of it
    bound = 3 * orders * EPS * sizes
    given = StoredSteps(blocks)
    for motion in (given, copy.deepcopy(given), pickle.loads(pickle.dumps(given))):
        assert np.all(np.abs(motion.at(times) - values) <= bound)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_polynomials_at_ends_of_steps_are_those_of_the_side(sign):
    steps = stored(7, 19, sign)
    steps["start"][:, 1] = 0.0
    starts, order = steps["start"][1:, 0], np.array([2, 0, 1, 1])  # a later one first
    given = StoredSteps([steps[:2], steps[2:]])
    at_starts = steps["coefficients"][1:, 0]
    at_ends = (steps["coefficients"] * (sign * LENGTHS)[:, None, None] ** np.arange(19)[:, None]).sum(axis=1)[:-1]
    assert np.array_equal(given.at(starts[order], "right"), at_starts[order])
    assert np.allclose(given.at(starts[order], "left"), at_ends[order], rtol=0, atol=100 * EPS)


def test_a_motion_has_the_same_bits_for_many_times_as_for_few(top, start):
    motion = pt.propagate(top, start, [0.0, 5.0], dense=True)
    times = np.linspace(0.0, 5.0, ROWS_PER_BLOCK + 3)
    many, few = motion(times), motion(times[-5:])
    assert np.array_equal(many.quaternion[-5:], few.quaternion)
    assert np.array_equal(many.angular_momentum_body[-5:], few.angular_momentum_body)


def test_states_stay_when_the_motion_is_called_again(top, start):
    motion = pt.propagate(top, start, [0.0, 5.0], dense=True)
    states = motion([1.0, 2.0])
    before = states.quaternion.copy(), states.angular_momentum_body.copy()
    motion([3.0, 4.0])
    assert np.array_equal(states.quaternion, before[0])
    assert np.array_equal(states.angular_momentum_body, before[1])
