"""Zeros of quartic torques: all of known ones, wherever they lie among the cells, and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from poinsot.analysis.polynomial_search import _coefficients, _decided, zeros_of_quartics

RANDOM = Rotation.random(100, np.random.default_rng(5))
ATTITUDES = RANDOM.as_quat(scalar_first=True)


def matrices(attitudes):
    return Rotation.from_quat(attitudes, scalar_first=True).as_matrix()


def gradient(inertia, weights, attitudes):
    """The sum over the frame's axes u of weight u x I u, in body axes, which turns principal axes along the frame's."""
    axes = matrices(attitudes)
    return sum(w * np.cross(axes[:, i], axes[:, i] @ inertia) for i, w in enumerate(weights))


@pytest.mark.parametrize("turn", range(6))
def test_all_of_24_are_found_wherever_they_are(turn):
    """Twelve half-turned pairs: the ways to lay three axes along three others, shifted among the cells."""
    axes = RANDOM[turn].as_matrix()
    inertia = axes @ np.diag((1.0, 1.6, 2.1)) @ axes.T
    expected = np.array(
        [(way * Rotation.from_matrix(axes.T)).as_quat(scalar_first=True) for way in Rotation.create_group("O")]
    )
    found, complete = zeros_of_quartics(lambda p: gradient(inertia, (3.0, 0.0, -1.0), p), ATTITUDES)
    assert complete
    near = np.abs(found @ expected.T)
    assert np.all(np.max(near, axis=0) > 0.999)
    assert np.all(np.max(near, axis=1) > 0.99)  # and none elsewhere


def test_a_torque_without_zeros_has_none():
    found, complete = zeros_of_quartics(lambda p: matrices(p)[:, 0] + (0.0, 0.0, 1.1), ATTITUDES)
    assert complete
    assert not len(found)


def test_families_and_other_functions_are_not_complete():
    inertia = np.diag((1.0, 1.0, 2.0))
    for torque in (
        lambda p: gradient(inertia, (3.0, 0.0, -1.0), p),
        lambda p: np.zeros((len(p), 3)),
        lambda p: matrices(p)[:, 0] ** 3,
        lambda p: np.full((len(p), 3), np.nan),
    ):
        _, complete = zeros_of_quartics(torque, ATTITUDES)
        assert not complete


HALF_EDGE = 1 / 16
CELL = np.array([[1.0, 0.0, 0.0, 0.0]])


def decided(first, steep=1.0):
    """What is found in the cell about the identity, for a torque of which the first component is a polynomial in x_1.

    The others are x_2 and x_3, times their steepness; `first` are coefficients by power.
    """

    def torque(q):
        x = q[:, 1:] / q[:, :1]
        values = np.stack([np.polynomial.polynomial.polyval(x[:, 0], first), steep * x[:, 1], steep * x[:, 2]], axis=1)
        return values * q[:, :1] ** 4

    starts, undecided = _decided(_coefficients(torque, ATTITUDES), CELL, HALF_EDGE)
    return len(starts), bool(undecided[0])


@pytest.mark.parametrize("power", [2, 3, 4])
@pytest.mark.parametrize("value", [2.5 * HALF_EDGE, 1e-3])
def test_a_cell_is_not_empty_if_terms_of_higher_degree_make_a_zero_in_it(power, value):
    """The linear terms alone have theirs outside: at 2.5 half edges, or nowhere near, where all is nearly flat."""
    zero, slope = 0.9 * HALF_EDGE, 1.0 if value > 1e-2 else 1e-3
    first = np.zeros(power + 1)
    first[:2] = value, slope
    first[power] = -(value + slope * zero) / zero**power
    assert decided(first, slope) == (0, True)


@pytest.mark.parametrize("power", [2, 3, 4])
def test_a_cell_with_two_zeros_is_divided(power):
    first = np.zeros(power + 1)
    first[1], first[power] = 1.0, -1 / (0.9 * HALF_EDGE) ** (power - 1)
    assert decided(first) == (0, True)


def test_a_cell_with_one_zero_and_one_without_are_done():
    assert decided([0.3 * HALF_EDGE, 1.0]) == (1, False)
    assert decided([5 * HALF_EDGE, 1.0]) == (0, False)
