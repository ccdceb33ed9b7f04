"""The circular orbit of two bodies: distance and rate."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.mechanics.circular_pair import circular_orbit, mean_motion

PAIR = pt.TwoBodies(pt.Body((0.3, 0.5, 0.6), mass=3.0), pt.Body((0.01, 0.02, 0.025), mass=0.5), G=1.3)


@pytest.mark.parametrize("distance", [1.2, 3.0, 1e3])
@pytest.mark.parametrize("primary_turns", [False, True])
def test_distance_of_the_rate_of_a_distance(distance, primary_turns):
    r, rate = circular_orbit(PAIR, "orbit", {"distance": distance, "period": None, "rate": None}, primary_turns)
    assert r == distance
    for name, value in (("rate", rate), ("period", 2 * np.pi / rate)):
        given = {"distance": None, "period": None, "rate": None, name: value}
        found, again = circular_orbit(PAIR, "orbit", given, primary_turns)
        np.testing.assert_allclose(found, distance, rtol=4e-15)
        np.testing.assert_allclose(again, rate, rtol=1e-15)


def test_rate_has_the_quadrupole_of_both_bodies():
    """w^2 = G M / r^3 + 3 G M / (2 r^5) (s1 / m1 + s2 / m2), s = tr I - 3 A, written out for the numbers."""
    _, rate = circular_orbit(PAIR, "orbit", {"distance": 2.0}, False)
    spread = (1.4 - 3 * 0.3) / 3.0 + (0.055 - 3 * 0.01) / 0.5
    np.testing.assert_allclose(rate**2, 1.3 * 3.5 / 8 + 1.5 * 1.3 * 3.5 / 32 * spread, rtol=1e-15)
    np.testing.assert_allclose(mean_motion(PAIR, 2.0) ** 2, 1.3 * 3.5 / 8, rtol=1e-15)
