"""Attitude and angular velocity of a body relative to a moving frame, and Euler angles along a motion."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.display.html_text import Summarized, formatted, formatted_times
from poinsot.errors import level_of_user
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import rotation
from poinsot.kinematics.frame import Frame, roll_pitch_yaw
from poinsot.kinematics.state import AnyState
from poinsot.quantities import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


@dataclass(frozen=True, repr=False, eq=False)
class RelativeMotion(Summarized):
    """Attitude and angular velocity of the body relative to a frame.

    Attributes
    ----------
    times : array (n,)
    quaternion : array (n, 4)
        Body -> frame, scalar first.
    """

    times: Array
    quaternion: Array
    _omega_body: Array

    @property
    def omega_body(self) -> Array:
        """Angular velocity relative to the frame, along the body axes; shape (n, 3)."""
        return self._omega_body.copy()

    @property
    def attitude(self) -> Rotation:
        """Attitudes as a scipy rotation, body -> frame."""
        return rotation(self.quaternion)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return "Motion relative to a frame", {
            "times": formatted_times(self.times),
            "quaternion (body to frame)": formatted(self.quaternion),
            "omega (relative to the frame, body axes)": formatted(self.omega_body),
        }

    @property
    def roll_pitch_yaw(self) -> Array:
        """Roll, pitch and yaw in radians, for the frame of an orbit: see `roll_pitch_yaw`; shape (n, 3)."""
        return roll_pitch_yaw(self.quaternion)

    @property
    def omega_frame(self) -> Array:
        """Angular velocity relative to the frame, along the frame's axes; shape (n, 3)."""
        return quat.rotate(self.quaternion, self.omega_body)


def relative_motion(times: Array, quaternion: Array, omega_body: Array, frame: Frame) -> RelativeMotion:
    """Return attitude and angular velocity relative to a frame."""
    frame_omega = quat.rotate(quat.conjugate(quaternion), frame.omega_space(times))
    relative = quat.product(quat.conjugate(frame.quaternion(times)), quaternion)
    return RelativeMotion(times, relative, omega_body - frame_omega)


def euler_angles(q: Array, state: AnyState, sequence: str) -> tuple[Array, Array]:
    """Return Euler angles of states and their momenta, NaN at singular attitudes, with one warning."""
    sine = euler.sine_of_attitudes(q, sequence)
    if sentence := euler.singularity(sine, sequence, q):
        warnings.warn(sentence, stacklevel=level_of_user())
    regular = sine >= euler.SINGULAR_SINE
    if np.all(regular):
        return state.of_bodies[""].euler(sequence)
    angles, momenta = np.full((2, *q.shape[:-1], 3), np.nan)
    angles[regular] = euler.angles_from_quaternion(q[regular], sequence)
    g = state.of_bodies[""].angular_momentum_body
    momenta[regular] = euler.momenta_from_angular_momentum(angles[regular], g[regular], sequence)
    return angles, momenta
