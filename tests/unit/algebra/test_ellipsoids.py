"""Contact of ellipsoids, against the distance of their surfaces by a search for the nearest points."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from poinsot.algebra.ellipsoids import gap
from poinsot.functions import Vector


def number(first, second, turn, separation):
    return gap(first, second, [Vector(axis) for axis in turn.as_matrix().T], Vector(separation))


@pytest.mark.parametrize("seed", range(12))
def test_ellipsoids_grown_by_the_number_touch(seed):
    """The nearest points of both are one: by a search over directions, of which no formula is used."""
    rng = np.random.default_rng(seed)
    first, second = rng.uniform(1, 6, 3), rng.uniform(1, 6, 3) * rng.choice([1.0, 0.1])
    turn, r = Rotation.random(random_state=rng), rng.normal(size=3) * rng.choice([2.0, 20.0])
    factor = 1 + number(first, second, turn, r)

    def room(direction):
        """How far planes across a direction keep the grown bodies apart."""
        u = direction / np.linalg.norm(direction)
        return u @ r - factor * (np.linalg.norm(first * u) + np.linalg.norm(second * turn.inv().apply(u)))

    best = minimize(lambda u: -room(u), r, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-15})
    assert abs(best.fun) < 1e-14 * np.linalg.norm(r)


@pytest.mark.parametrize("distance", [0.5, 3.0, 40.0])
def test_spheres(distance):
    turn, along = Rotation.from_rotvec((0.3, 0.5, -0.2)), np.array([0.6, -0.64, 0.48])
    assert abs(number((2.0,) * 3, (0.5,) * 3, turn, distance * along) - (distance / 2.5 - 1)) < 1e-14 * distance
