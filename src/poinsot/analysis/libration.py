"""Librations of one of two bodies relative to their orbit: yaw, pitch and roll of its principal axes."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.kinematics.euler import angles_from_quaternion
from poinsot.mechanics.two_bodies import BODIES, upright
from poinsot.printable import quoted
from poinsot.propagation.trajectory import OfTwoBodies
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array
from poinsot.records.members import expanded

__all__ = ["Librations", "librations"]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Librations(Summarized):
    """Yaw, pitch and roll of a body's principal axes relative to the radial, transverse and normal axes of its orbit.

    The rotation is yaw about the normal, then pitch about the second axis, then roll about the long axis. All angles
    are zero if the long axis (of the least moment) is on the line of centres and the short axis (of the largest moment)
    is normal to the orbit. The signs of the axes are chosen so that the angles at the first time are smallest. Angles
    are in radians; for an ensemble every array gains the axis of the members first.

    Attributes
    ----------
    times : array (n,)
        Times of the motion.
    yaw, roll : array (n,)
        Angles in (-pi, pi]. The yaw is the libration in longitude, the angle of the long axis in the plane of the
        orbit.
    pitch : array (n,)
        Angle in [-pi/2, pi/2], positive if the long axis is below the plane of the orbit.

    Examples
    --------
    >>> found = pt.analysis.librations(pair_motion)
    >>> found.yaw.shape == pair_motion.times.shape, bool(np.all(found.misalignment <= np.pi / 2))
    (True, True)
    """

    times: Array
    yaw: Array
    pitch: Array
    roll: Array

    @property
    def misalignment(self) -> Array:
        """Angle between the long axis and the line of centres, in [0, pi/2]; shape (n,)."""
        along = np.abs(np.cos(self.yaw) * np.cos(self.pitch))
        return np.asarray(np.arctan2(np.hypot(np.sin(self.yaw) * np.cos(self.pitch), np.sin(self.pitch)), along))

    @property
    def amplitude(self) -> Any:
        """Half the range of the yaw."""
        return (np.fmax.reduce(self.yaw, axis=-1) - np.fmin.reduce(self.yaw, axis=-1)) / 2

    @property
    def tumbles(self) -> Any:
        """True if yaw or roll exceeds a right angle at one of the times."""
        return np.any((np.abs(self.yaw) > np.pi / 2) | (np.abs(self.roll) > np.pi / 2), axis=-1)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return "Librations", {
            "yaw": formatted(self.yaw, "rad"),
            "pitch": formatted(self.pitch, "rad"),
            "roll": formatted(self.roll, "rad"),
            "tumbles": formatted(self.tumbles),
        }


@checked
def librations(motion: OfTwoBodies, body: str = "secondary") -> Librations:
    """Return yaw, pitch and roll of one of two bodies relative to their orbit.

    `pt.analysis.frequencies(found.yaw, found.times)` gives the free frequencies of a libration as lines of these
    angles.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble.
    body : {"secondary", "primary"}
        Body whose angles are returned.

    Returns
    -------
    Librations
        Angles at the times of the motion.

    Examples
    --------
    >>> primary, long = pt.Body((0.4, 0.4, 0.4), mass=1.0), pt.Body((1.0e-6, 1.2e-6, 1.5e-6), mass=1e-5)
    >>> pair = pt.TwoBodies(primary, long, G=1.0)
    >>> turned = (np.cos(0.05), 0, 0, np.sin(0.05))
    >>> start = pair.state((4, 0, 0), (0, 0.5, 0), [turned] * 2, omega_body=[(0, 0, 0)] * 2, frame="orbit")
    >>> motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, 400, 801))
    >>> found = pt.analysis.librations(motion)
    >>> found.amplitude.round(3), found.tumbles
    (np.float64(0.121), np.False_)
    """
    if body not in BODIES:
        raise ValueError(f"body must be 'primary' or 'secondary', got {quoted(body)}.")
    relative = getattr(motion, body).relative_to(motion.orbit_frame).quaternion
    axes = expanded(upright(two_bodies(motion.system).bodies[body]), relative.ndim - 1, components=1)
    principal = quat.product(relative, quat.conjugate(axes))
    # a half turn about the axis k exchanges the real part with the component k
    nearest = np.argmax(np.abs(principal[..., :1, :]), axis=-1, keepdims=True)
    turned = quat.product(principal, np.eye(4)[nearest[..., 0]])
    yaw, pitch, roll = np.moveaxis(angles_from_quaternion(turned, "321"), -1, 0)
    return Librations(motion.times, _wrapped(yaw), pitch, _wrapped(roll))


def _wrapped(angle: Array) -> Array:
    return np.asarray(np.pi - np.mod(np.pi - angle, 2 * np.pi))
