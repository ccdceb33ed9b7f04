"""Star trackers, and the bright bodies that blind them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import KW_ONLY
from typing import Annotated, Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.errors import array_of, refuse_negative
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import UnitQuaternion, unit_quaternion
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.noise import random_turn
from poinsot.mechanics.observable import Observable
from poinsot.quantities import OR_NUMBER, Along, Array, Quantity, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import HalfTurn, NotNegative, Parametric
from poinsot.records.units import DerivedUnits

__all__ = ["Exclusion", "StarTracker"]


class Exclusion(Parametric):
    """Bright body, such as the Sun, the Earth or the Moon, that blinds a star tracker near its boresight.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body relative to the bright body.
    angle : float
        Smallest angle between the boresight and the limb of the bright body, radians.
    radius : float
        Radius of the bright body, in the unit of length of the orbit; 0: the angle is from its centre.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.327e20, position=(-1.496e11, 0, 0))  # m, s
    >>> pt.observables.Exclusion(sun, np.radians(30.0)).radius
    array(0.)
    """

    orbit: Orbit
    angle: HalfTurn
    radius: NotNegative = 0.0

    @of_scalars
    def margin(self, instant: Instant, boresight: Vector) -> Scalar:
        """Return the angle of a direction, body axes, from the edge of the excluded cone; negative inside."""
        towards = instant.attitude.to_body(-instant.direction(self.orbit))
        sine = functions.minimum(self.radius * instant.inverse_distance(self.orbit), 1.0)
        return functions.angle_between(boresight, towards) - functions.asin(sine) - self.angle


class StarTracker(Observable):
    """Star tracker: the quaternion sensor -> space, q m.

    q is the quaternion body -> space, and m the mounting. The boresight is the third axis of the sensor. A reading with
    noise is q m turned by d about the axes of the sensor, with the angle 2 atan(|d|/2), as
    `NoisySensors.attitude_noise` of sampled controllers. The sign of a reading is the sign of q m.

    Parameters
    ----------
    mounting : array (4,) or Rotation
        Unit quaternion m, sensor -> body, scalar first. Default: the sensor axes are the body axes.
    exclusions : sequence of Exclusion
        Bright bodies. Inside the cone of one of them there is no reading.
    noise : array (3,) or float
        Standard deviation of the turn about each axis of the sensor, radians.

    Raises
    ------
    ValueError
        If the mounting has another norm than 1 or a deviation is negative.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 2)), [0.0, np.pi / 2])
    >>> tracker = pt.observables.StarTracker(noise=(1e-5, 1e-5, 1e-4))
    >>> pt.observe(motion, tracker).values.round(3) + 0.0
    array([[1., 0., 0., 0.],
           [0., 0., 0., 1.]])
    """

    components: ClassVar[tuple[str, ...]] = ("q0", "q1", "q2", "q3")
    _: KW_ONLY
    mounting: UnitQuaternion = (1.0, 0.0, 0.0, 0.0)
    exclusions: tuple[Exclusion, ...] = ()
    noise: Annotated[Any, (3,), OR_NUMBER, Along("sensor axes"), Quantity("angle"), Rule(refuse_negative)] = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mounting", unit_quaternion(self.mounting, "mounting"))
        if array_of("noise", self.noise, "rad").ndim == 0:
            object.__setattr__(self, "noise", [self.noise] * 3)
        super().__post_init__()

    @override
    def reading(self, instant: Instant) -> Vector:
        return Vector(quat.product(Vector(instant.attitude.quaternion), Vector(self.mounting)))

    @override
    def unit(self, units: DerivedUnits) -> str:
        return "1"

    @of_scalars
    def boresight(self) -> Vector:
        """Return the third axis of the sensor, body axes."""
        return Vector(quat.rotate(Vector(self.mounting), Vector((0.0, 0.0, 1.0))))

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        margins = [each.margin(instant, self.boresight()) for each in self.exclusions]
        return {"blinded": functions.less(functools.reduce(functions.minimum, margins), 0.0)} if margins else {}

    @override
    def check_values(self, values: Array) -> None:
        read = values[~np.isnan(values).any(axis=-1)]
        if read.size:
            unit_quaternion(read, "values")

    # ------------------------------------------------------------------ errors

    @property
    @override
    def errors(self) -> tuple[str, ...]:
        return ("x", "y", "z")

    @override
    def difference(self, read: Array, predicted: Array) -> Array:
        """Return the rotation vectors, of length at most pi, from predicted to read attitudes, sensor axes."""
        return quat.rotation_vector(quat.product(quat.conjugate(predicted), read))

    @override
    def disturbed(self, readings: Array, errors: Array) -> Array:
        turn = random_turn(Vector(np.moveaxis(np.asarray(errors), -1, 0)))
        return quat.product(readings, quat.assemble(turn))
