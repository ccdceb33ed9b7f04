"""Moving axes: their attitude and their angular velocity at any time."""

from __future__ import annotations

import copy
import functools
from abc import abstractmethod
from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.display.html_text import text_table
from poinsot.errors import member_array, real_numbers, reals_or_nan, refuse_other_members
from poinsot.immutable import Immutable
from poinsot.kinematics.attitude import quaternion_from_matrix, rotation, unit_quaternion
from poinsot.kinematics.euler import angles_from_quaternion, quaternion_from_angles
from poinsot.printable import described, kind_of
from poinsot.quantities import AngularVelocities, Time, Times
from poinsot.records.formula_errors import explain_formulas
from poinsot.records.members import expanded, with_times
from poinsot.records.parameters import listed
from poinsot.subclasses import is_own

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Frame", "RelativeOrbitFrame", "RotatingFrame", "from_roll_pitch_yaw", "roll_pitch_yaw"]

LEVEL = np.array([0.5, -0.5, -0.5, 0.5])
"""Forward, opposite to the normal, down -> radial, transverse, normal."""


OF_TIME = {"quaternion": 4, "omega_space": 3}
"""The functions of the time that a frame has, and how many components the values of each have."""

MIN_SINE = 1e-12
"""Smallest sine of the angle between two directions that span a plane."""


class Frame(Immutable):
    """Moving axes, to which attitudes and angular velocities can be referred; the base class of all frames.

    A subclass defines the quaternion and the angular velocity of the axes as functions of time.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> orbit.frame.omega_space(0.0)  # of the axes radial, transverse, normal
    array([0., 0., 1.])
    """

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        explain_formulas(cls)
        for name, length in OF_TIME.items():
            if not is_own(cls) and isinstance(function := vars(cls).get(name), FunctionType):
                setattr(cls, name, _with_shape(function, length))

    @property
    def member_axis(self) -> tuple[int, ...]:
        """The shape of the member axis of the axes' numbers: (members,), or () for one frame."""
        return ()

    @abstractmethod
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        """Return the unit quaternion q frame -> space, x_space = q x_frame q~, shape (..., 4).

        Times of shape (n,) are common to all members, and the result then has shape (members, n, 4).
        """

    @abstractmethod
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        """Return the angular velocity of the frame, space axes; shape (..., 3)."""

    @property
    def _described(self) -> dict[str, str]:
        """Arguments of the axes, as text."""
        return {name: listed(value) for name, value in vars(self).items() if not name.startswith("_")}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={text}' for name, text in self._described.items())})"

    def _repr_html_(self) -> str:
        return text_table(type(self).__name__, self._described)

    def attitude(self, time: Times) -> Rotation:
        """Return the scipy rotation frame -> space at given times."""
        return rotation(real_numbers("quaternion(time)", self.quaternion(time)))


def _with_shape(function: Callable[..., Any], length: int) -> Callable[..., Any]:
    """Return a function of a frame of the user's own that raises an error for values of another shape."""

    @functools.wraps(function)
    def shaped(frame: Frame, time: Times) -> NDArray[np.float64]:
        name = f"{kind_of(frame)}.{function.__name__}(time)"
        values = reals_or_nan(name, function(frame, time))
        times = np.shape(time)
        if values.shape[-1:] != (length,) or not _broadcasts(values.shape[:-1], times):
            needed = ", ".join(map(str, (*times, length)))
            raise ValueError(
                f"{name} must have shape ({needed}{',' * (not times)}) at times of shape {times}, got shape "
                f"{values.shape}."
            )
        return values

    return shaped


def _broadcasts(*shapes: tuple[int, ...]) -> bool:
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        return False
    return True


def checked_frame(frame: Any) -> Frame:
    """Return the frame, or raise a TypeError."""
    if not isinstance(frame, Frame):
        raise TypeError(f"frame must be a Frame, got {described(frame)}. An orbit has one: orbit.frame.")
    return frame


def axes_at(frame: Frame, time: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return quaternion and angular velocity of a frame at the time of a state, or of the state of each member."""
    if not (frame.member_axis and np.ndim(time)):
        return frame.quaternion(time), frame.omega_space(time)
    own = np.asarray(time)[:, None]
    return frame.quaternion(own)[:, 0], frame.omega_space(own)[:, 0]


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
    """Axes that rotate at a constant angular velocity.

    Parameters
    ----------
    attitude : scipy Rotation or array (4,) or (members, 4)
        Rotation frame -> space at the epoch. A quaternion is scalar first.
    omega_space : array (3,) or (members, 3)
        Constant angular velocity of the frame along the space axes, radians per unit of time.
    epoch : float or array (members,)
        Time of `attitude`.

    Examples
    --------
    >>> turning = pt.RotatingFrame((1, 0, 0, 0), omega_space=(0, 0, 0.5))
    >>> turning.quaternion(np.pi).round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """

    def __init__(self, attitude: Rotation | ArrayLike, omega_space: AngularVelocities, epoch: Time = 0.0) -> None:
        self._start = unit_quaternion(attitude)
        self._omega = member_array("omega_space", omega_space, (3,))
        self._epoch = member_array("epoch", epoch, ())[()]
        self._rate = np.apply_along_axis(np.linalg.norm, -1, self._omega)[()]
        counts = {"attitude": self._start.shape[:-1], "omega_space": self._omega.shape[:-1]}
        refuse_other_members(**counts, epoch=self._epoch.shape)

    @property
    @override
    def member_axis(self) -> tuple[int, ...]:
        return np.broadcast_shapes(self._start.shape[:-1], self._rate.shape, self._epoch.shape)

    def with_axes(self, axes: int) -> RotatingFrame:
        """Return the frame with numbers of shape (members, 1, ...) that broadcast against arrays of so many axes."""
        frame = copy.copy(self)
        frame._start, frame._omega = (expanded(vectors, axes, 1) for vectors in (self._start, self._omega))
        frame._epoch, frame._rate = (expanded(numbers, axes) for numbers in (self._epoch, self._rate))
        return frame

    @property
    @override
    def _described(self) -> dict[str, str]:
        own = {"attitude": self._start, "omega_space": self._omega, "epoch": self._epoch}
        return {name: listed(value) for name, value in own.items()}

    @override
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        frame, t = with_times(self, real_numbers("time", time))
        half, rate = 0.5 * (t - frame._epoch), frame._rate
        vector = (half * np.sinc(rate * half / np.pi) * w for w in np.moveaxis(frame._omega, -1, 0))
        turned: Any = np.stack(np.broadcast_arrays(np.cos(rate * half), *vector), axis=-1)
        return quat.product(turned, frame._start)

    @override
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        frame, t = with_times(self, real_numbers("time", time))
        return np.broadcast_to(frame._omega, (*np.broadcast_shapes(frame._rate.shape, np.shape(t)), 3))


class RelativeOrbitFrame(Frame):
    """The axes radial, transverse and normal of one body about another.

    Radial leads from the other body to the one, normal is along position x velocity. The axes turn at h/r^2 about the
    normal, and with the plane of the orbit at r a_n/h about the radial axis, a_n the acceleration along the normal.

    Parameters
    ----------
    motion : function of a time
        Position, velocity and acceleration at it, space axes, each of shape (..., 3).
    """

    def __init__(self, motion: Callable[[Times], tuple[NDArray[np.float64], ...]]) -> None:
        self._motion = motion

    @override
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        position, velocity, _ = self._motion(time)
        rows = _orbit_axes(position, velocity)
        known = np.all(np.isfinite(rows), axis=(-1, -2))
        turns = quaternion_from_matrix(np.swapaxes(np.where(known[..., None, None], rows, np.eye(3)), -1, -2))
        return np.where(known[..., None], turns, np.nan)

    @override
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        position, velocity, acceleration = self._motion(time)
        radial, _, normal = np.moveaxis(_orbit_axes(position, velocity), -2, 0)
        distance = np.linalg.norm(position, axis=-1, keepdims=True)
        h = np.linalg.norm(np.cross(position, velocity), axis=-1, keepdims=True)
        tilting = distance / h * np.vecdot(acceleration, normal)[..., None]
        return np.asarray(h / distance**2 * normal + tilting * radial)


def _orbit_axes(position: NDArray[np.float64], velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return radial, transverse and normal as the rows of matrices; (..., 3, 3)."""
    r, v = (np.linalg.norm(vector, axis=-1, keepdims=True) for vector in (position, velocity))
    radial, across = position / r, np.cross(position, velocity)
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    if np.any(size <= MIN_SINE * r * v):
        raise ValueError("position and velocity must span a plane for axes of the orbit, got parallel ones.")
    normal = across / size
    normal = normal - np.vecdot(normal, radial)[..., None] * radial  # of vectors nearly parallel it has lost digits
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.stack([radial, np.cross(normal, radial), normal], axis=-2)
