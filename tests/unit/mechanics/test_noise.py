"""Tests of the noise of attitude sensors: the turn by a vector of errors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from poinsot.functions import Vector
from poinsot.mechanics.noise import random_turn

ROUNDING = 4 * np.finfo(float).eps


@pytest.mark.parametrize("deviation", [1e-9, 0.02, 3.0])
def test_the_turn_has_the_axis_of_the_errors_and_twice_the_angle_of_half_their_length(deviation):
    d = deviation * np.array([0.3, -1.2, 0.7])
    angle = 2 * np.arctan(np.linalg.norm(d) / 2)
    expected = Rotation.from_rotvec(angle * d / np.linalg.norm(d)).as_quat(scalar_first=True)
    found = np.array(random_turn(Vector(d)))
    assert np.allclose(found, expected, rtol=ROUNDING, atol=ROUNDING * deviation)
