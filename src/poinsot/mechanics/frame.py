"""Moving axes: their attitude and their angular velocity at any time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.errors import real_array, real_numbers
from poinsot.mechanics.attitude import rotation, unit_quaternion
from poinsot.mechanics.euler import angles_from_quaternion, quaternion_from_angles
from poinsot.mechanics.parameters import described
from poinsot.quantities import AngularVelocities, Time, Times

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Frame", "RotatingFrame", "from_roll_pitch_yaw", "roll_pitch_yaw"]

LEVEL = np.array([0.5, -0.5, -0.5, 0.5])
"""Forward, opposite to the normal, down -> radial, transverse, normal."""


class Frame(ABC):
    """Axes that move in space; attitudes and rates relative to them go in and come out by name.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> orbit.frame.omega_space(0.0)  # of the axes radial, transverse, normal
    array([0., 0., 1.])
    """

    @abstractmethod
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        """Return the unit quaternion frame -> space, x_space = q x_frame q~; shape (..., 4)."""

    @abstractmethod
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        """Return the angular velocity of the frame, space axes; shape (..., 3)."""

    def attitude(self, time: Times) -> Rotation:
        """Return the scipy rotation frame -> space."""
        return rotation(self.quaternion(time))


def checked_frame(frame: Any) -> Frame:
    """Return the frame, or raise a TypeError."""
    if not isinstance(frame, Frame):
        raise TypeError(f"frame must be a Frame, got {described(frame)}. An orbit has one: orbit.frame.")
    return frame


def roll_pitch_yaw(quaternion: ArrayLike) -> NDArray[np.float64]:
    """Return roll, pitch and yaw, radians, of attitudes body -> radial, transverse, normal of an orbit; (..., 3).

    They lead from axes forward (transverse), opposite to the normal, and down to the body axes: yaw about the third,
    then pitch about the second, then roll about the first.
    """
    angles = angles_from_quaternion(quat.product(quat.conjugate(LEVEL), np.asarray(quaternion)), "321")
    return np.asarray(np.pi - np.mod(np.pi - angles[..., ::-1], 2 * np.pi))


def from_roll_pitch_yaw(angles: ArrayLike) -> NDArray[np.float64]:
    """Return the attitude body -> radial, transverse, normal with roll, pitch and yaw, radians; (..., 4)."""
    turn = quaternion_from_angles(np.asarray(angles)[..., ::-1], "321")
    return np.asarray(quat.product(LEVEL, turn))


class RotatingFrame(Frame):
    """Axes that turn at a constant rate.

    Parameters
    ----------
    attitude : scipy Rotation or array (4,)
        Frame -> space at the epoch.
    omega_space : array (3,)
        Its constant angular velocity, space axes, radians per unit of time.
    epoch : float
        The time of `attitude`.

    Examples
    --------
    >>> turning = pt.RotatingFrame((1, 0, 0, 0), omega_space=(0, 0, 0.5))
    >>> turning.quaternion(np.pi).round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """

    def __init__(self, attitude: Rotation | ArrayLike, omega_space: AngularVelocities, epoch: Time = 0.0) -> None:
        self._start = unit_quaternion(attitude)
        self._omega = real_array("omega_space", omega_space, (3,))
        self._epoch = float(real_array("epoch", epoch, ()))

    @override
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        half = 0.5 * (real_numbers("time", time) - self._epoch)
        rate = np.linalg.norm(self._omega)
        turned: Any = np.stack(
            np.broadcast_arrays(np.cos(rate * half), *(half * np.sinc(rate * half / np.pi) * w for w in self._omega)),
            axis=-1,
        )
        return quat.product(turned, self._start)

    @override
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        return np.broadcast_to(self._omega, (*real_numbers("time", time).shape, 3))
