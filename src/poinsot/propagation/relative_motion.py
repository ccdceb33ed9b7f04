"""Attitude and rate of a body relative to a frame that turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.display.html_text import Summarized, told, told_times
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.frame import roll_pitch_yaw

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class RelativeMotion(Summarized):
    """Attitude and rate of the body relative to a frame.

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
        """The rate relative to the frame, along the body axes; shape (n, 3)."""
        return self._omega_body.copy()

    @property
    def attitude(self) -> Rotation:
        """The attitudes as a scipy rotation, body -> frame."""
        return rotation(self.quaternion)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return "Motion relative to a frame", {
            "times": told_times(self.times),
            "quaternion (body to frame)": told(self.quaternion),
            "omega (relative to the frame, body axes)": told(self.omega_body),
        }

    @property
    def roll_pitch_yaw(self) -> Array:
        """Roll, pitch and yaw, radians, if the frame is an orbit's: see `roll_pitch_yaw`; shape (n, 3)."""
        return roll_pitch_yaw(self.quaternion)

    @property
    def omega_frame(self) -> Array:
        """The rate relative to the frame, along the frame's axes; shape (n, 3)."""
        return quat.rotate(self.quaternion, self.omega_body)
