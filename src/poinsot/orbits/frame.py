"""The moving axes of an orbit."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import real_numbers
from poinsot.mechanics.attitude import quaternion_from_matrix
from poinsot.mechanics.frame import Frame
from poinsot.mechanics.sky import Orbit

__all__ = ["OrbitFrame"]


class OrbitFrame(Frame):
    """Radial (away from the attractor), transverse (forward), normal (along r x v).

    Its angular velocity is h / r^2 along the normal, which is exact while the plane of the orbit is fixed.
    """

    def __init__(self, orbit: Orbit) -> None:
        self.orbit = orbit

    def quaternion(self, time: ArrayLike) -> NDArray[np.float64]:  # noqa: D102
        r, v = self._vectors(time)
        radial = r / np.linalg.norm(r, axis=-1, keepdims=True)
        normal = np.cross(r, v)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        return quaternion_from_matrix(np.stack([radial, np.cross(normal, radial), normal], axis=-1))

    def omega_space(self, time: ArrayLike) -> NDArray[np.float64]:  # noqa: D102
        r, v = self._vectors(time)
        return np.asarray(np.cross(r, v) / np.sum(r * r, axis=-1, keepdims=True))

    def _vectors(self, time: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        t = real_numbers("time", time)
        return tuple(
            np.stack(np.broadcast_arrays(*x), axis=-1) for x in (self.orbit.position_at(t), self.orbit.velocity_at(t))
        )  # type: ignore[return-value]
