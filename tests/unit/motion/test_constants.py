"""Constants: parameters that meet variables in every function give the same torque as numbers do."""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3))

FORMULAS = {
    "where on a parameter": lambda k, z: fn.where(fn.less(k, 1.0), z, 2 * z),
    "where on a variable": lambda k, z: fn.where(fn.less(z, 5.0), k * z, z),
    "where of parameters": lambda k, z: fn.where(fn.less(-5.0, z), k, 0.0) * z,
    "less of a parameter and a variable": lambda k, z: fn.where(fn.less(-7 * k, z), z * z, z),
    "atan2 of a parameter and a variable": lambda k, z: fn.atan2(k + 2, z),
    "atan2 of a variable and a parameter": lambda k, z: fn.atan2(z, k),
    "powers": lambda k, z: (2 + z) ** k + k ** (2 + z),
    "divisions": lambda k, z: k / (2 + z) + (2 + z) / k + 1 / k + k / 2,
    "differences": lambda k, z: (k - z) * (z - k) + (1 - k) * (z - 0) + (k - 0) * z,
    "functions": lambda k, z: fn.sin(k) * fn.sqrt(2 + z) + fn.exp(-k * z) + fn.log(2 + k) * z,
}


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical", "euler_angles"])
@pytest.mark.parametrize("name", FORMULAS)
def test_energy_is_conserved_with_the_torque_of_the_kernel(name, formulation):
    class Formula(pt.Potential):
        k: float

        def energy(self, body, attitude, sky):  # noqa: ARG002
            return 0.3 * FORMULAS[name](self.k, attitude.to_body((0, 0.6, 0.8))[2])

    motion = pt.propagate(pt.System(BODY, Formula(0.7)), START, np.linspace(0, 3, 7), formulation=formulation)
    assert np.ptp(motion.potential_energy) > 1e-3
    assert np.max(np.abs(motion.drift["energy"])) < 1e-13
