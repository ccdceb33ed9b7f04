"""Tests of readings along motions."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.observables import Readings


class Rate(pt.Observable):
    components = ("x", "y", "z")

    def reading(self, instant):
        return instant.omega_body


def test_readings_follow_the_motion():
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 0.3, 2)), [0.0, 1.0, 2.5])
    assert np.array_equal(pt.observe(motion, Rate()).values, motion.omega_body)


@pytest.mark.parametrize("sigma", [0.0, -1.0, [0.1, 0.0]])
def test_sigma_is_positive(sigma):
    with pytest.raises(ValueError, match=r"sigma must be positive, got .* Give the standard deviation of a reading\."):
        Readings(Rate(), [0.0, 1.0], np.zeros((2, 3)), sigma)
