"""Gravity: on a body with a fixed point, and of a distant attractor."""

from __future__ import annotations

import numpy as np

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Potential
from poinsot.mechanics.parameters import Vector
from poinsot.mechanics.sky import Orbit, Sky

__all__ = ["GravityGradient", "UniformGravity"]


class UniformGravity(Potential):
    """Uniform gravity along -s3 on a body with a fixed point: the heavy top.

    U = weight * height of the centre of mass (paper, eq. (18) with the sign of erratum E8).

    Parameters
    ----------
    weight : float
        M g >= 0.
    center_of_mass : array (3,)
        From the fixed point, body axes. The paper's printed sign is a centre of mass at minus this.
    """

    weight: float
    center_of_mass: Vector

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.asarray(self.weight) < 0):
            raise ValueError(
                f"weight must not be negative, but {np.min(self.weight)} came. "
                "Gravity acts along -s3; turn center_of_mass."
            )

    def energy(self, body: Body, attitude: Attitude, sky: Sky) -> Scalar:  # noqa: ARG002, D102
        up = attitude.to_body((0, 0, 1))
        return self.weight * functions.dot(self.center_of_mass, up)


class GravityGradient(Potential):
    """The attitude-dependent part of an attractor's gravity on an extended body, to second degree.

    U = 3 mu J / (2 r^3) with J the moment of inertia about the direction to the attractor (eq. (20), from
    MacCullagh's formula (19)).

    Parameters
    ----------
    orbit : Orbit
        Where the body is; `mu` is the orbit's. Moments in mass length^2 with the length of the orbit give
        energies in mass length^2 / time^2.
    """

    orbit: Orbit

    def energy(self, body: Body, attitude: Attitude, sky: Sky) -> Scalar:  # noqa: D102
        radial, inverse = attitude.to_body(sky.direction(self.orbit)), sky.inverse_distance(self.orbit)
        return inverse * inverse * inverse * (1.5 * self.orbit.mu) * body.moment_about(radial)
