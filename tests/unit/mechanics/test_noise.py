"""Tests of the noise of sensors: the turn by normal numbers, and white noise of numbers."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from poinsot.functions import Vector
from poinsot.mechanics.noise import random_turn, with_white_noise

ROUNDING = 4 * np.finfo(float).eps


@pytest.mark.parametrize("deviation", [1e-9, 0.02, 3.0])
def test_the_turn_has_the_axis_of_the_numbers_and_twice_the_angle_of_half_their_length(deviation):
    normals = np.array([0.3, -1.2, 0.7])
    d = deviation * normals
    angle = 2 * np.arctan(np.linalg.norm(d) / 2)
    expected = Rotation.from_rotvec(angle * d / np.linalg.norm(d)).as_quat(scalar_first=True)
    found = np.array(random_turn(deviation, Vector(normals)))
    assert np.allclose(found, expected, rtol=ROUNDING, atol=ROUNDING * deviation)


def test_each_axis_may_have_a_deviation_of_its_own():
    deviations, normals = Vector((0.1, 0.2, 0.3)), Vector((1.0, -1.0, 2.0))
    assert list(random_turn(deviations, normals)) == list(random_turn(1.0, Vector((0.1, -0.2, 0.6))))
    assert np.allclose(list(with_white_noise(normals, deviations, normals)), [1.1, -1.2, 2.6], rtol=ROUNDING, atol=0)
