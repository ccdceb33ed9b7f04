"""Rotors: at a constant speed, or driven and braked by a motor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer
from poinsot.mechanics.parameters import BodyUnitVector, NotNegative, Positive
from poinsot.mechanics.part import Part
from poinsot.quantities import BodyVector, Real

__all__ = ["Gyrostat", "ReactionWheel"]


class Gyrostat(Part):
    """Rotors whose speeds relative to the body are held constant: Zhukovsky's and Volterra's gyrostat.

    omega = I^-1 (g - h). The energy of the motors that hold the speeds is left out: T = (g - h) . omega / 2.

    Parameters
    ----------
    rotor_momentum : array (3,), body axes
        h, the sum over rotors of axial moment times relative speed times unit axis. The body's inertia tensor is that
        with the rotors locked.

    Examples
    --------
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.parts.Gyrostat((0, 0, 0.5)))
    >>> system.state((1, 0, 0, 0), omega_body=(0, 0, 2)).angular_momentum_body  # I omega + h
    array([0., 0., 2.])
    """

    rotor_momentum: BodyVector

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return functions.Vector(self.rotor_momentum)


class ReactionWheel(Part):
    """A balanced wheel on an axis fixed in the body, turned by a motor and braked by viscous friction.

    p' = torque - friction (p / moment - axis . omega), p the wheel's inertial angular momentum along its axis.

    Parameters
    ----------
    axis : array (3,), body axes
        Unit vector along the wheel's axis.
    moment : float
        Moment of inertia about the axis, positive. The body's inertia tensor is that with the wheel locked.
    friction : float
        Torque per speed relative to the body, not negative.
    torque : float
        Of the motor on the wheel, constant.
    name : str
        Of the wheel; several of a system need different ones.

    Raises
    ------
    ValueError
        If the axis is no unit vector, the moment is not positive, or the friction is negative.

    Examples
    --------
    >>> wheel = pt.parts.ReactionWheel((0, 0, 1), moment=0.1, torque=0.02)
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheel)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    >>> pt.propagate(system, start, [10.0]).omega_body.round(4)  # the body turns the other way
    array([[ 0.    ,  0.    , -0.3077]])
    """

    axis: BodyUnitVector
    moment: Positive
    friction: NotNegative = 0.0
    torque: Real = 0.0
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
        return own[0] * own[0] / (2 * self.moment)

    @override
    def rates(self, instant: Instant, pull: functions.Vector) -> functions.Vector:
        (p,) = instant.own(self)
        slip = p * (1 / self.moment) - functions.dot(self.axis, instant.omega_body)
        return functions.Vector((self.torque - self.friction * slip,))

    def at_speed(self, speed: ArrayLike, omega_body: ArrayLike) -> NDArray[np.float64]:
        """Return the variables, shape (..., 1), for a speed relative to the body and the body's angular velocity."""
        along = np.sum(self.axis * np.asarray(omega_body, dtype=float), axis=-1)
        return np.asarray(self.moment * (np.asarray(speed, dtype=float) + along))[..., None]

    def speed(self, own: ArrayLike, omega_body: ArrayLike) -> NDArray[np.float64]:
        """Return the speed relative to the body, shape (...), from the variables and the body's angular velocity."""
        along = np.sum(self.axis * np.asarray(omega_body), axis=-1)
        return np.asarray(np.asarray(own)[..., 0] / self.moment - along)
