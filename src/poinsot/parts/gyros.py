"""Rotors in gimbals: control-moment gyroscopes, and gyroscopes with a spring and a damper."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer
from poinsot.mechanics.part import Part
from poinsot.quantities import AngularVelocity, Real
from poinsot.records.members import Components, of_arrays, of_scalars
from poinsot.records.parameters import BodyUnitVector, NotNegative, Positive

__all__ = ["ControlMomentGyro", "GimballedRotor", "refuse_oblique"]

PERPENDICULAR_TOLERANCE = 1e-9
"""Largest cosine of the angle between perpendicular axes."""


def refuse_oblique(name: str, axis: Any, other_name: str, other: Any) -> None:
    """Raise a ValueError for unit vectors that are not perpendicular."""
    cosine = np.max(np.abs(np.sum(other * axis, axis=-1)))
    if cosine > PERPENDICULAR_TOLERANCE:
        raise ValueError(f"{name} must be perpendicular to {other_name}, got a cosine of {cosine:.3g}.")


class Gimbal(Part):
    """Rotor at a constant speed relative to a gimbal, which turns about an axis fixed in the body."""

    gimbal_axis: BodyUnitVector
    spin_axis: BodyUnitVector
    rotor_momentum: Real

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_oblique("spin_axis", self.spin_axis, "gimbal_axis", self.gimbal_axis)

    @override
    @abstractmethod
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector: ...

    @of_scalars
    def spin(self, angle: Scalar) -> functions.Vector:
        """Return the momentum of the rotor along its axis at an angle of the gimbal, body axes."""
        c, s = functions.cos(angle), functions.sin(angle)
        first = functions.Vector(self.spin_axis)
        axis: functions.Vector = first * c + functions.cross(self.gimbal_axis, first) * s
        return functions.Vector(self.rotor_momentum * x for x in axis)

    @of_scalars
    def torque_of_turning(self, angle: Scalar, omega: functions.Vector) -> Scalar:
        """Return the torque about the gimbal axis that aligns the rotor with the angular velocity of the body."""
        return functions.dot(omega, functions.cross(self.gimbal_axis, self.spin(angle)))


class ControlMomentGyro(Gimbal):
    """Single-gimbal control-moment gyroscope with a prescribed gimbal rate.

    h = H (cos(angle) s + sin(angle) m x s), angle' = gimbal_rate, with the unit vector m along the gimbal axis and s
    along the rotor axis at angle 0. The torque on the body is H gimbal_rate, perpendicular to both axes, plus the
    gyroscopic torque of h in the rotating body. The model ignores the momentum of the gimbal and the change of the
    inertia tensor with the angle, both small compared with H. The energy is (g - h) . omega / 2 plus the potential
    energies, without the work of the motors.

    Parameters
    ----------
    gimbal_axis, spin_axis : array (3,), body axes
        Perpendicular unit vectors m and s.
    rotor_momentum : float
        Momentum H, axial moment of inertia times speed relative to the gimbal. The body's inertia tensor includes the
        rotor, locked.
    gimbal_rate : float
        Angular velocity of the gimbal relative to the body, in angle per time.

    Raises
    ------
    ValueError
        If an axis is not a unit vector, or the axes are not perpendicular.

    Examples
    --------
    >>> gyro = pt.parts.ControlMomentGyro((0, 0, 1), (1, 0, 0), rotor_momentum=2.0, gimbal_rate=0.1)
    >>> system = pt.System(pt.Body((125.0, 100.0, 75.0)), gyro)
    >>> motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [1.0])
    >>> motion.omega_body.round(4)  # about -H gimbal_rate / I along the second axis
    array([[ 0.0001, -0.002 , -0.    ]])
    """

    formula = (
        "h = rotor_momentum*(cos(alpha)*spin_axis + sin(alpha)*(cross(gimbal_axis, spin_axis))); "
        "rate(alpha) = gimbal_rate"
    )
    gimbal_rate: AngularVelocity
    variables: ClassVar[Mapping[str, int]] = {"angle": 1}

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return self.spin(own[0])

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        return functions.Vector((self.gimbal_rate,))

    @of_arrays(own=(1,), omega_body=(3,))
    def gimbal_torque(self, own: Components, omega_body: Components) -> Any:
        """Return the torque of the gimbal motor that maintains the gimbal rate in the rotating body, shape (...).

        The mechanical power of the motor is this torque times the gimbal rate.
        """
        return -self.torque_of_turning(own[0], omega_body)


class GimballedRotor(Gimbal):
    """Rotor in a gimbal with motor torque, spring and damper: a gyroscopic damper, or a rate gyroscope.

    h = H e(angle) + p m, angle' = p / J - omega . m and p' = omega . (m x H e) + torque - stiffness angle - damping
    angle'. Here p is the inertial angular momentum of gimbal and rotor along the gimbal axis m, and e the axis of the
    rotor. The inertia tensor of gimbal and rotor does not depend on the angle in this model. The energy excludes the
    work of the rotor's motor.

    Parameters
    ----------
    gimbal_axis, spin_axis : array (3,), body axes
        Perpendicular unit vectors; the second is the rotor axis at angle 0.
    rotor_momentum : float
        Momentum H, axial moment of inertia times speed relative to the gimbal.
    moment : float
        Moment of inertia J of gimbal and rotor about the gimbal axis, positive. The body's inertia tensor includes
        both, locked.
    torque : float
        Constant torque of the motor on the gimbal.
    stiffness, damping : float
        Torque per angle and per angular velocity of the gimbal relative to the body, not negative.

    Raises
    ------
    ValueError
        If an axis is not a unit vector, the axes are not perpendicular, or a number is out of range.

    Examples
    --------
    >>> gyro = pt.parts.GimballedRotor((0, 0, 1), (1, 0, 0), rotor_momentum=2.0, moment=0.1, stiffness=5.0, damping=1.0)
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), gyro)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0, 1, 0))
    >>> motion = pt.propagate(system, start, [0.0, 50.0])
    >>> bool(motion.energy[1] < motion.energy[0])
    True
    """

    formula = (
        "h = k + p*gimbal_axis; "
        "k = rotor_momentum*(cos(alpha)*spin_axis + sin(alpha)*(cross(gimbal_axis, spin_axis))); "
        "rate(alpha) = sigma; sigma = p/moment - dot(gimbal_axis, omega); "
        "rate(p) = dot(omega, cross(gimbal_axis, k)) + torque - stiffness*alpha - damping*sigma"
    )
    moment: Positive
    torque: Real = 0.0
    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    variables: ClassVar[Mapping[str, int]] = {"angle": 1, "momentum": 1}
    momenta: ClassVar[frozenset[str]] = frozenset({"momentum"})

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        return functions.Vector((0.0, self.moment * functions.dot(self.gimbal_axis, omega_body)))

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        angle, p = own
        return functions.Vector(x + p * y for x, y in zip(self.spin(angle), self.gimbal_axis, strict=True))

    @override
    def spinning_inertia(self, own: functions.Vector) -> Matrix:
        return outer(self.gimbal_axis, self.gimbal_axis) * self.moment

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        angle, p = own
        value: Scalar = p * p / (2 * self.moment) + self.stiffness / 2 * (angle * angle)
        return value

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        angle, p = instant.own(self)
        omega = instant.omega_body
        rate = p * (1 / self.moment) - functions.dot(self.gimbal_axis, omega)
        held = self.torque - self.stiffness * angle - self.damping * rate
        return functions.Vector((rate, self.torque_of_turning(angle, omega) + held))

    @of_arrays(angle=(), rate=(), omega_body=(3,))
    def at_angle(self, angle: Scalar, rate: Scalar, omega_body: Components) -> Any:
        """Return the variables, shape (..., 2), for a gimbal angle, its rate and the body's angular velocity."""
        return functions.Vector((angle, self.moment * (rate + functions.dot(self.gimbal_axis, omega_body))))

    @of_arrays(own=(2,), omega_body=(3,))
    def rate(self, own: Components, omega_body: Components) -> Any:
        """Return the angular velocity of the gimbal relative to the body, shape (...)."""
        return own[1] / self.moment - functions.dot(self.gimbal_axis, omega_body)
