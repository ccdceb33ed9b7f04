"""Feedback of attitude and rate: torques of an ideal actuator on the body."""

from __future__ import annotations

import functools
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import UnitQuaternion
from poinsot.mechanics.block import default_name
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Gain, Positive

__all__ = ["OrbitPointing", "QuaternionFeedback", "RateDamping"]

UNLIMITED = 1e100
"""Limit of a torque that no torque reaches."""

HALF_TURN_RANGE = 0.2
"""Four times the square of the scalar part below which another component determines the quaternion."""


class _Limited:
    """Control law with a limit of each component of the torque."""

    if TYPE_CHECKING:
        limit: Scalar

        def torque(self, instant: Instant) -> Vector: ...

    @of_scalars
    def within(self, torque: Iterable[Scalar]) -> Vector:
        """Return a torque with each component within the limit."""
        return Vector(functions.clip(component, -self.limit, self.limit) for component in torque)

    @of_scalars
    def limits(self, instant: Instant, torque: Vector | None = None) -> Mapping[str, Scalar]:
        """Return, by name, True if a component of the torque is at the limit."""
        given = self.torque(instant) if torque is None else torque
        largest = functools.reduce(functions.maximum, map(abs, given))
        return {f"{default_name(type(self))}_at_limit": largest >= self.limit}


class _Feedback(_Limited, Torque):
    """Torque against errors of attitude and rate, u_i = clip(-kp q_i - kd w_i, -limit, limit)."""

    formula = "N = clip(-(kp*epsilon) - kd*nu, -limit, limit)"
    kp: Gain
    kd: Gain
    limit: Positive

    @of_scalars
    @abstractmethod
    def deviations(self, instant: Instant) -> tuple[Vector, Vector]:
        """Return the vector part of the quaternion target -> body with a positive scalar part, and the rate's error."""

    @override
    def torque(self, instant: Instant) -> Vector:
        turn, rate = self.deviations(instant)
        wanted = (-self.kp * x - self.kd * y for x, y in zip(turn, rate, strict=True))
        return self.within(wanted)


class QuaternionFeedback(_Feedback):
    """Proportional-derivative attitude control towards a target fixed in space.

    u_i = clip(-kp q_i - kd w_i, -limit, limit) along the body axes, with q the quaternion target -> body with positive
    q0, so that the rotation is the shorter one. At an error of exactly half a turn, q retains the sign of the state's
    quaternion. The gain kp multiplies half the angle: small errors obey I s^2 + kd s + kp/2 = 0 (Wie 1998, Space
    Vehicle Dynamics and Control, Sec. 7.3). The actuator is ideal, and gyroscopic torques are not compensated.

    Parameters
    ----------
    kp : float
        Torque per component of the vector part of the error quaternion. A negative gain causes a warning.
    kd : float
        Torque per angular velocity. A negative gain causes a warning.
    limit : float
        Largest torque about each body axis, positive. Default: no effective limit.
    target : array (4,)
        Target attitude, a unit quaternion body -> space. Default: the space axes.

    Examples
    --------
    >>> law = pt.control.QuaternionFeedback(kp=0.6, kd=4.0, limit=0.05)
    >>> system = pt.System(pt.Body((10, 12, 8)), law)
    >>> system.torque_body(system.state((0.8, 0.6, 0, 0), omega_body=(0, 0, 0.01)))
    array([-0.05,  0.  , -0.04])
    """

    limit: Positive = UNLIMITED
    target: UnitQuaternion = (1.0, 0.0, 0.0, 0.0)

    @override
    def deviations(self, instant: Instant) -> tuple[Vector, Vector]:
        q = quat.product(quat.conjugate(Vector(self.target)), Vector(instant.attitude.quaternion))
        return _shorter(q), instant.omega_body


class OrbitPointing(_Feedback):
    """Proportional-derivative attitude control in the orbital frame, with feedforward of the orbital rate.

    The torque equals the torque of `QuaternionFeedback` with attitude and angular velocity relative to the radial,
    transverse and normal axes. These rotate at h/r^2 about the normal; the law ignores precession of the orbital plane.

    Parameters
    ----------
    kp : float
        Torque per component of the vector part of the error quaternion. A negative gain causes a warning.
    kd : float
        Torque per angular velocity relative to the orbital frame. A negative gain causes a warning.
    limit : float
        Largest torque about each body axis, positive.
    orbit : Orbit
        Orbit that defines the radial, transverse and normal axes.
    target : array (4,)
        Target attitude, a unit quaternion body -> radial, transverse, normal. Default: aligned with these axes.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> law = pt.control.OrbitPointing(kp=2.0, kd=5.0, limit=1.0, orbit=orbit)
    >>> system = pt.System(pt.Body((1, 2, 2.5)), law)
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0.9))).round(12)
    array([0. , 0. , 0.5])
    """

    orbit: Orbit
    target: UnitQuaternion = (1.0, 0.0, 0.0, 0.0)

    @override
    def deviations(self, instant: Instant) -> tuple[Vector, Vector]:
        position, velocity = instant.position(self.orbit), instant.velocity(self.orbit)
        radial, across = instant.direction(self.orbit), functions.cross(position, velocity)
        normal = across * (1 / functions.norm(across))
        axes = (radial, functions.cross(normal, radial), normal)
        inverse = instant.inverse_distance(self.orbit)
        rate = instant.attitude.to_body(across * (inverse * inverse))
        q = _quaternion_of([instant.attitude.to_body(axis) for axis in axes])  # body -> frame
        return _shorter(quat.product(quat.conjugate(Vector(self.target)), q)), instant.omega_body - rate


class RateDamping(_Limited, Torque):
    """Damping torque with a limit, u_i = clip(-gain w_i, -limit, limit) along the body axes.

    Parameters
    ----------
    gain : float
        Torque per inertial angular velocity. A negative gain causes a warning.
    limit : float
        Largest torque about each body axis, positive. Default: no effective limit.

    Examples
    --------
    >>> system = pt.System(pt.Body((10, 12, 8)), pt.control.RateDamping(2.0, limit=0.05))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0.01, 0, -0.3)))
    array([-0.02,  0.  ,  0.05])
    """

    formula = "N = clip(-(gain*omega), -limit, limit)"
    gain: Gain
    limit: Positive = UNLIMITED

    @override
    def torque(self, instant: Instant) -> Vector:
        return self.within(-self.gain * component for component in instant.omega_body)


def _quaternion_of(matrix: Any) -> Vector:
    """Return the quaternion of the rows of a matrix, scalars of any kind, at any angle (Shepperd's method)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    # Row k is 4 q_k (q0, q1, q2, q3).
    ways = (
        (1 + a + e + i, h - f, c - g, d - b),
        (h - f, 1 + a - e - i, b + d, c + g),
        (c - g, b + d, 1 - a + e - i, f + h),
        (d - b, c + g, f + h, 1 - a - e + i),
    )
    best, largest = Vector(ways[1]), ways[1][1]
    for k in (2, 3):
        better = functions.less(largest, ways[k][k])
        best, largest = _chosen(better, ways[k], best), functions.where(better, ways[k][k], largest)
    best = _chosen(functions.less(HALF_TURN_RANGE, ways[0][0]), ways[0], best)
    size = functions.norm(best)
    return Vector(x / size for x in best)


def _chosen(condition: Scalar, vector: Any, other: Any) -> Vector:
    return Vector(functions.where(condition, x, y) for x, y in zip(vector, other, strict=True))


def _shorter(quaternion: Any) -> Vector:
    """Return the vector part of q or -q, whichever has a positive scalar part."""
    sign = functions.where(functions.less(quaternion[0], 0.0), -1.0, 1.0)
    return Vector(sign * component for component in quaternion[1:])
