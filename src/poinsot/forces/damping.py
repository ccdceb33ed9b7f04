"""Dissipative torques."""

from __future__ import annotations

from typing_extensions import override

from poinsot.functions import Vector
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.records.parameters import NotNegative

__all__ = ["LinearDamping"]


class LinearDamping(Torque):
    """Linear damping torque, -coefficient * omega, against the inertial angular velocity.

    Parameters
    ----------
    coefficient : float
        Torque per angular velocity, in the unit of inertia per unit of time; not negative.

    Raises
    ------
    ValueError
        If the coefficient is negative.

    Examples
    --------
    >>> system = pt.System(pt.Body((1, 2, 2.5)), pt.forces.LinearDamping(0.1))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 2)))
    array([ 0. ,  0. , -0.2])
    """

    formula = "N = -(coefficient*omega)"
    coefficient: NotNegative

    @override
    def torque(self, instant: Instant) -> Vector:
        return instant.omega_body * -self.coefficient
