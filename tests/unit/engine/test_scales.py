"""The scales of momenta: powers of two by which they come into their band, and what is along quaternions goes."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.engine import kernels
from poinsot.engine.formulations import FORMULATIONS
from poinsot.engine.kernel_momenta import LEAST, MOST
from poinsot.engine.problem import Problem
from poinsot.engine.scales import Scales
from poinsot.functions import Vector

SYSTEM = pt.System(pt.Body((1.0, 1.3, 1.7)))
START = SYSTEM.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
VARIABLES = kernels.state_vector(Problem(SYSTEM), START, FORMULATIONS["canonical"], "double")
POWERS = np.array([0, 1, -2])
Q = np.array([0.1, 0.8, -0.6, 0.7])
P = np.array([0.3, -0.2, 0.4, 0.1])
"""A quaternion of another norm than 1, and momenta that are not perpendicular to it."""

FACTORS = np.array([2.0**-30, 2.0**30, 1.0])
"""Of momenta that have shrunk, that have grown, and within the band."""

LEFT = np.stack([P - (Q @ P) / (Q @ Q) * Q, P, P], axis=1)
ROUNDING = 4 * np.finfo(float).eps


def check(scales, state):
    np.testing.assert_array_equal(state[:4], np.tile(Q[:, None], 3))
    np.testing.assert_allclose(state[4:] / FACTORS / 2.0**scales.bits, LEFT, rtol=0, atol=ROUNDING)
    sizes = np.linalg.norm(state[4:], axis=0)
    assert np.all((sizes >= LEAST) & (sizes <= MOST))
    assert scales.bits[0] > scales.bits[2] > scales.bits[1]


def state_of(factors):
    return np.vstack([np.tile(Q[:, None], 3), P[:, None] * factors])


def test_momenta_that_have_shrunk_lose_what_is_along_the_quaternion():
    """Those that have grown keep it; each lane has a power of its own."""
    scales, state = Scales(SYSTEM, VARIABLES, POWERS, 3, 19), state_of(FACTORS)
    scales.begin(state, np.arange(3))
    check(scales, state)
    assert scales.bits[2] == 0


def test_parameters_go_with_their_powers_of_the_scale():
    """From the scale that a lane has to another one, as from that of the start."""
    scales, constants = Scales(SYSTEM, VARIABLES, POWERS, 3, 19), np.array([5.0, 7.0, 11.0, 13.0])
    scales.begin(state_of(2.0**-20 * np.ones(3)), np.arange(3))
    state, pars = state_of(FACTORS * 2.0**scales.bits), np.tile(constants[:, None], 3)
    pars[:3] = np.stack([scales.parameters(constants[:3], lane) for lane in range(3)], axis=1)
    scales.rescale(state, pars)
    check(scales, state)
    np.testing.assert_array_equal(pars[:3], constants[:3, None] * 2.0 ** (POWERS[:, None] * scales.bits))
    np.testing.assert_array_equal(pars[3], 13.0)


def test_rows_fit_where_all_of_them_are_within_the_band():
    """Rows that are not there are NaN, and momenta that are zero fit any scale."""
    scales, row = Scales(SYSTEM, VARIABLES, POWERS, 1, 19), np.array([*Q, *P])
    scales.begin(row, np.zeros(1, dtype=int))
    small, large, none = (np.array([*Q, *P * factor]) for factor in (2.0**-10, 2.0**10, 0.0))
    for rows, fit in (
        ([row, row], True),
        ([row, none], True),
        ([row, np.nan * row], True),
        ([row, small, row], False),
        ([large, none], False),
        ([none, small], False),
    ):
        assert scales.fit(np.array(rows), 0) == fit


class Thrust(pt.Torque):
    """A torque about the first body axis."""

    def torque(self, instant):  # noqa: ARG002
        return Vector((1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("forces", "doubtful"),
    [
        ((), (False, False, False, False)),
        ((pt.forces.LinearDamping(0.1),), (True, False, True, False)),
        ((Thrust(),), (True, False, False, False)),  # which gives a body at rest as much
    ],
    ids=["no torque", "damping", "thrust"],
)
def test_steps_are_doubtful_where_torques_may_have_turned_the_body_fast(forces, doubtful):
    """A step turns it by 2 or less: in 3 that is slow; in 0.001, or by steps that are ten times as long soon, fast."""
    scales = Scales(pt.System(SYSTEM.body, *forces), VARIABLES, POWERS, 1, 19)
    scales.begin(np.array([*Q, *P]), np.zeros(1, dtype=int))
    steps = (1e-3, 1e-3), (3.0, 3.0), (3.0, 30.0), (0.0, 0.0)
    assert tuple(scales.doubtful(0, *lengths) for lengths in steps) == doubtful
