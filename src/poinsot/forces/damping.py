"""Dissipation."""

from __future__ import annotations

from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Torque
from poinsot.mechanics.sky import Sky

__all__ = ["LinearDamping"]


class LinearDamping(Torque):
    """A torque against the inertial rate, -coefficient * omega.

    Parameters
    ----------
    coefficient : float
        Torque per rate: the unit of inertia over the unit of time.
    """

    coefficient: float

    def torque(self, body: Body, attitude: Attitude, omega_body: Vector, sky: Sky) -> Vector:  # noqa: ARG002, D102
        return -self.coefficient * omega_body
