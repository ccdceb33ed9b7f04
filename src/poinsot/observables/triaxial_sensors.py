"""Gyros and magnetometers: three components along the axes of a sensor."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import KW_ONLY
from typing import Annotated, Any, ClassVar

from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.errors import refuse_negative
from poinsot.forces.magnetic_fields import MagneticField
from poinsot.functions import Vector
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.observable import Observable
from poinsot.quantities import Along, AngularVelocity, Quantity, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative
from poinsot.records.units import DerivedUnits

__all__ = ["Gyro", "Magnetometer"]

SENSOR_AXES = Along("sensor axes")


class TriaxialSensor(Observable):
    """Sensor of a vector, with three axes that are turned from the body axes.

    Parameters
    ----------
    bias : array (3,), sensor axes
        Reading where the measured vector is zero.
    scale : array (3,)
        Relative errors s of the scale along the body axes.
    alignment : array (3,)
        Rotation vector a, radians, body axes. The components along the body axes are turned by it.
    noise : float
        Standard deviation of each component of a reading.
    """

    components: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    _: KW_ONLY
    bias: Annotated[Any, (3,), SENSOR_AXES] = (0.0, 0.0, 0.0)
    scale: Annotated[Any, (3,)] = (0.0, 0.0, 0.0)
    alignment: Annotated[Any, (3,), Along("body axes"), Quantity("angle")] = (0.0, 0.0, 0.0)
    noise: NotNegative = 0.0

    @of_scalars
    @abstractmethod
    def measured(self, instant: Instant) -> Vector:
        """Return the vector without errors of the sensor, body axes."""

    @override
    def reading(self, instant: Instant) -> Vector:
        turn = quat.exponential(Vector(self.alignment))
        scaled = self.measured(instant) * Vector(1 + x for x in self.scale)
        return Vector(quat.rotate(turn, scaled)) + Vector(self.bias)

    @property
    @override
    def frame(self) -> str:
        return "body"


class Gyro(TriaxialSensor):
    """Rate gyro with three axes: exp(a) (1 + s) omega + bias.

    omega is the inertial angular velocity along the body axes, and exp(a) the rotation by the vector a. The noise of
    a component is white, as `NoisySensors.rate_noise` of sampled controllers.

    Parameters
    ----------
    bias : array (3,), sensor axes
        Reading at rest, radians per unit of time.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 2)), [0.0, 1.0])
    >>> gyro = pt.observables.Gyro(bias=(0.1, 0, 0), alignment=(0.01, 0, 0))
    >>> pt.observe(motion, gyro).values.round(4)
    array([[ 0.1   , -0.02  ,  1.9999],
           [ 0.1   , -0.02  ,  1.9999]])
    """

    _: KW_ONLY
    bias: Annotated[Any, (3,), SENSOR_AXES, Quantity("rate")] = (0.0, 0.0, 0.0)
    noise: Annotated[AngularVelocity, Rule(refuse_negative)] = 0.0

    @override
    def measured(self, instant: Instant) -> Vector:
        return Vector(instant.omega_body)

    @override
    def unit(self, units: DerivedUnits) -> str:
        return units.rate


class Magnetometer(TriaxialSensor):
    """Magnetometer with three axes: exp(a) (1 + s) B + bias.

    B is the field at the position of the body, along the body axes, and exp(a) the rotation by the vector a. The model
    ignores fields of the body itself other than the bias.

    Parameters
    ----------
    field : MagneticField
        Magnetic field along the orbit, in tesla.
    bias : array (3,), sensor axes
        Reading without a field, tesla.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(6871.2, 0, 0))
    >>> axes = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.0)
    >>> field = pt.forces.TiltedDipole(orbit, axes, -3e-5, 0.0, 0.0, 6371.2)
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(1, 0, 0)), [0.0, np.pi / 2])
    >>> (1e9 * pt.observe(motion, pt.observables.Magnetometer(field)).values).round()  # nT
    array([[   -0.,     0., 23916.],
           [   -0., 23916.,     0.]])
    """

    field: MagneticField

    @override
    def measured(self, instant: Instant) -> Vector:
        return self.field.in_body(instant)

    @override
    def unit(self, units: DerivedUnits) -> str:
        return "T"
