"""Rotors at a constant speed, driven by a motor, or controlled to a commanded speed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer
from poinsot.mechanics.part import Part
from poinsot.quantities import BodyVector, Real
from poinsot.records.members import Components, of_arrays, of_scalars
from poinsot.records.parameters import BodyUnitVector, NotNegative, Positive

__all__ = ["Gyrostat", "MomentumWheel", "ReactionWheel"]


class Gyrostat(Part):
    """Gyrostat of Zhukovsky and Volterra: rotors with constant speeds relative to the body.

    omega = I^-1 (g - h). The kinetic energy is (g - h) . omega / 2, without the work of the motors that maintain the
    speeds.

    Parameters
    ----------
    rotor_momentum : array (3,), body axes
        Momentum h, the sum over rotors of axial moment of inertia times relative speed times unit axis. The body's
        inertia tensor includes the rotors, locked.

    Examples
    --------
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.parts.Gyrostat((0, 0, 0.5)))
    >>> system.state((1, 0, 0, 0), omega_body=(0, 0, 2)).angular_momentum_body  # I omega + h
    array([0., 0., 2.])
    """

    formula = "h = rotor_momentum"
    rotor_momentum: BodyVector

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return functions.Vector(self.rotor_momentum)


class Wheel(Part):
    """Balanced wheel on an axis fixed in the body."""

    axis: BodyUnitVector
    moment: Positive
    variables: ClassVar[Mapping[str, int]] = {"momentum": 1}
    momenta: ClassVar[frozenset[str]] = frozenset({"momentum"})

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        return functions.Vector((self.moment * functions.dot(self.axis, omega_body),))

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return functions.Vector(own[0] * component for component in self.axis)

    @override
    def spinning_inertia(self, own: functions.Vector) -> Matrix:
        return outer(self.axis, self.axis) * self.moment

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        value: Scalar = own[0] * own[0] / (2 * self.moment)
        return value

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        (p,) = instant.own(self)
        return functions.Vector((self.torque_at(p * (1 / self.moment) - functions.dot(self.axis, instant.omega_body)),))

    @of_scalars
    @abstractmethod
    def torque_at(self, speed: Scalar) -> Scalar:
        """Return the torque of motor and friction on the wheel at a speed relative to the body."""

    @of_arrays(speed=(), omega_body=(3,))
    def at_speed(self, speed: Scalar, omega_body: Components) -> Any:
        """Return the variables, shape (..., 1), for a speed relative to the body and the body's angular velocity."""
        return functions.Vector((self.moment * (speed + functions.dot(self.axis, omega_body)),))

    @of_arrays(own=(1,), omega_body=(3,))
    def speed(self, own: Components, omega_body: Components) -> Any:
        """Return the speed relative to the body, shape (...), from the variables and the body's angular velocity."""
        return own[0] / self.moment - functions.dot(self.axis, omega_body)


class ReactionWheel(Wheel):
    """Balanced reaction wheel on an axis fixed in the body, with constant motor torque and viscous friction.

    p' = torque - friction (p / moment - axis . omega), with p the inertial angular momentum of the wheel along its
    axis. `ReactionWheels` adds limits, dry friction, and motor torques commanded by a control law.

    Parameters
    ----------
    axis : array (3,), body axes
        Unit vector along the wheel's axis.
    moment : float
        Moment of inertia about the axis, positive. The body's inertia tensor includes the wheel, locked.
    friction : float
        Viscous friction, torque per speed relative to the body; not negative.
    torque : float
        Constant torque of the motor on the wheel.

    Raises
    ------
    ValueError
        If the axis is not a unit vector, the moment is not positive, or the friction is negative.

    Examples
    --------
    >>> wheel = pt.parts.ReactionWheel((0, 0, 1), moment=0.1, torque=0.02)
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheel)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    >>> pt.propagate(system, start, [10.0]).omega_body.round(4)  # the body turns the other way
    array([[ 0.    ,  0.    , -0.3077]])
    """

    formula = "h = p*axis; rate(p) = torque - friction*sigma; sigma = p/moment - dot(axis, omega)"
    friction: NotNegative = 0.0
    torque: Real = 0.0

    @override
    def torque_at(self, speed: Scalar) -> Scalar:
        return self.torque - self.friction * speed


class MomentumWheel(Wheel):
    """Balanced momentum wheel with a servo that maintains a commanded speed within the torque limit of its motor.

    p' = T - friction s, with T = gain (commanded_speed - s) limited to +-largest_torque. Here p is the inertial angular
    momentum of the wheel along its axis and s = p / moment - axis . omega its speed relative to the body. Friction
    causes a steady error of s, the fraction friction / (gain + friction) of the commanded speed. `Gyrostat` maintains
    the speed exactly.

    Parameters
    ----------
    axis : array (3,), body axes
        Unit vector along the wheel's axis.
    moment : float
        Moment of inertia about the axis, positive. The body's inertia tensor includes the wheel, locked.
    commanded_speed : float
        Commanded angular velocity relative to the body, in angle per time.
    gain : float
        Motor torque per speed error, positive.
    largest_torque : float
        Largest torque of the motor, positive.
    friction : float
        Viscous friction, torque per speed relative to the body; not negative.

    Raises
    ------
    ValueError
        If the axis is not a unit vector, the moment, gain or largest torque is not positive, or the friction is
        negative.

    Examples
    --------
    >>> wheel = pt.parts.MomentumWheel((0, 0, 1), moment=0.1, commanded_speed=50.0, gain=0.2, largest_torque=0.5)
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheel)
    >>> motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [30.0])
    >>> wheel.speed(motion.own["momentum_wheel"], motion.omega_body).round(6)
    array([50.])
    """

    formula = (
        "h = p*axis; "
        "rate(p) = clip(gain*(commanded_speed - sigma), -largest_torque, largest_torque) - friction*sigma; "
        "sigma = p/moment - dot(axis, omega)"
    )
    commanded_speed: Real
    gain: Positive
    largest_torque: Positive
    friction: NotNegative = 0.0

    @override
    def torque_at(self, speed: Scalar) -> Scalar:
        motor = functions.clip(self.gain * (self.commanded_speed - speed), -self.largest_torque, self.largest_torque)
        return motor - self.friction * speed
