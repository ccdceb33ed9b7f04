"""The comoving axes of an orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.errors import real_numbers
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.frame import Frame

__all__ = ["OrbitFrame"]


class OrbitFrame(Frame):
    """Radial (away from the attractor), transverse (forward), normal to the plane of the orbit.

    The axes are those in which a motion along the orbit is integrated; where the plane itself turns, their
    angular velocity has its rates too. The sign of the quaternion does not jump.
    """

    def __init__(self, orbit: Orbit) -> None:
        self.orbit = orbit
        self._block: Any = orbit.block

    @override
    def quaternion(self, time: ArrayLike) -> NDArray[np.float64]:
        return self._quaternion(*self._start(time))

    @override
    def omega_space(self, time: ArrayLike) -> NDArray[np.float64]:
        t, variables = self._start(time)
        omega = self._block.omega(t, np.moveaxis(variables, -1, 0))
        return quat.rotate(self._quaternion(t, variables), np.stack(np.broadcast_arrays(*omega), axis=-1))

    def _quaternion(self, time: NDArray[np.float64], own: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self._block.quaternion(time, own))

    def _start(self, time: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        t = real_numbers("time", time)
        return t, self._block.start_at(t)
