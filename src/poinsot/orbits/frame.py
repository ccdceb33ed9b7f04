"""Comoving axes of an orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.errors import real_numbers
from poinsot.kinematics.frame import Frame
from poinsot.mechanics.environment import Orbit
from poinsot.records.members import with_times

__all__ = ["OrbitFrame"]


class OrbitFrame(Frame):
    """Radial (away from the attractor), transverse (forward), normal to the plane of the orbit.

    A motion along the orbit is integrated in these axes. The angular velocity includes the rotation of the plane. The
    sign of the quaternion does not jump.
    """

    def __init__(self, orbit: Orbit) -> None:
        self.orbit = orbit

    @property
    @override
    def member_axis(self) -> tuple[int, ...]:
        return self.orbit.member_axis

    @override
    def quaternion(self, time: ArrayLike) -> NDArray[np.float64]:
        block, t, variables = self._start(time)
        return np.asarray(block.quaternion(t, variables))

    @override
    def omega_space(self, time: ArrayLike) -> NDArray[np.float64]:
        block, t, variables = self._start(time)
        omega = block.omega(t, np.moveaxis(variables, -1, 0))
        return quat.rotate(block.quaternion(t, variables), np.stack(np.broadcast_arrays(*omega), axis=-1))

    def _start(self, time: ArrayLike) -> tuple[Any, NDArray[np.float64], NDArray[np.float64]]:
        """Return the block of the orbit, and its variables at times that broadcast against its numbers."""
        orbit, t = with_times(self.orbit, real_numbers("time", time))
        return orbit.block, t, orbit.block.start_at(t)
