"""Dissipation."""

from __future__ import annotations

import numpy as np

from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Sky
from poinsot.mechanics.force import Torque

__all__ = ["LinearDamping"]


class LinearDamping(Torque):
    """A torque against the inertial rate, -coefficient * omega.

    Parameters
    ----------
    coefficient : float
        Torque per rate, not negative: the unit of inertia over the unit of time.
    """

    coefficient: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.asarray(self.coefficient) < 0):
            raise ValueError(f"coefficient must not be negative, but {np.min(self.coefficient)} came.")

    def torque(self, body: Body, attitude: Attitude, omega_body: Vector, sky: Sky) -> Vector:  # noqa: ARG002, D102
        return -self.coefficient * omega_body
