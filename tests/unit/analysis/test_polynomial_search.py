"""Zeros of quartic torques: all of known ones, wherever they lie among the cells, and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from poinsot.analysis.polynomial_search import zeros_of_quartics

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
