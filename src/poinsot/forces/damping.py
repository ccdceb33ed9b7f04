"""Dissipative torques."""

from __future__ import annotations

import numpy as np
from typing_extensions import override

from poinsot.functions import Vector
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.quantities import Real

__all__ = ["LinearDamping"]


class LinearDamping(Torque):
    """A torque against the inertial rate, -coefficient * omega.

    Parameters
    ----------
    coefficient : float
        Torque per rate, not negative: the unit of inertia over the unit of time.
    """

    coefficient: Real

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.asarray(self.coefficient) < 0):
            raise ValueError(f"coefficient must not be negative, got {np.min(self.coefficient)}.")

    @override
    def torque(self, instant: Instant) -> Vector:
        return instant.omega_body * -self.coefficient
