"""Sensors of directions along the body axes: towards the Sun, a planet or a star, or along a magnetic field."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import KW_ONLY
from typing import Annotated, Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.errors import array_of, member_array, refuse_negative, refuse_other_length, refuse_zero
from poinsot.forces.magnetic_fields import MagneticField
from poinsot.forces.radiation import SUN_RADIUS, Occulter, visible_fraction
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.noise import random_turn
from poinsot.mechanics.observable import Observable
from poinsot.orbits.fixed import FixedPosition
from poinsot.quantities import OR_NUMBER, Along, Angle, Array, BodyVector, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import ArrayLength, BodyDirection, HalfTurn, NotNegative, Positive
from poinsot.records.units import DerivedUnits

__all__ = ["CoarseSunSensors", "VectorSensor"]

STAR_DISTANCE = 1e30
"""Distance of a target that is given by its direction, so that the place of the body does not change the direction."""

DARK = 1e-12
"""Visible fraction of the Sun's disc below which the Sun is eclipsed."""


class VectorSensor(Observable):
    """Sensor of the direction towards a target: a Sun sensor, an Earth horizon sensor or a camera of one star.

    The reading is u + bias along the body axes, with the unit vector u towards the attractor of an orbit, towards a
    direction fixed in space, or along a magnetic field. A reading with noise is turned by d about the body axes, with
    the angle 2 atan(|d|/2), so that its length stays.

    Parameters
    ----------
    target : Orbit, MagneticField or array (3,) along the space axes
        Orbit of the body relative to the target, a magnetic field, or a direction from the body.
    boresight : array (3,), body axes
        Axis of the field of view, of any length.
    field_of_view : float
        Largest angle between the boresight and the target, radians. Default: pi, every direction.
    occulters : sequence of Occulter
        Spheres nearer than the target. There is no reading where one covers the centre of the target.
    bias : array (3,), body axes
        Error that is added to the unit vector.
    noise : float
        Standard deviation of the turn about each body axis, radians.

    Raises
    ------
    TypeError, ValueError
        If the target is none of these, a direction is zero, an angle is outside 0 to pi, or a field has occulters.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.327e20, position=(-1.496e11, 0, 0))  # m, s; the Sun is towards +x
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, np.pi / 2])
    >>> pt.observe(motion, pt.observables.VectorSensor(sun)).values.round(3) + 0.0
    array([[ 1.,  0.,  0.],
           [ 0., -1.,  0.]])
    """

    components: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    target: Orbit | MagneticField
    _: KW_ONLY
    boresight: BodyDirection = (0.0, 0.0, 1.0)
    field_of_view: HalfTurn = np.pi
    occulters: tuple[Occulter, ...] = ()
    bias: BodyVector = (0.0, 0.0, 0.0)
    noise: Annotated[Angle, Rule(refuse_negative)] = 0.0

    def __post_init__(self) -> None:
        if array_of("target", self.target).dtype.kind in "iuf":
            direction = member_array("target", self.target, (3,), "space axes")
            refuse_zero("target", direction, "It is a direction.")
            far = STAR_DISTANCE / np.linalg.norm(direction, axis=-1, keepdims=True)
            object.__setattr__(self, "target", FixedPosition(1.0, position=-direction * far))
        super().__post_init__()
        if self.occulters and isinstance(self.target, MagneticField):
            raise ValueError(f"occulters must be none for a magnetic field, got {len(self.occulters)}.")

    @of_scalars
    def direction(self, instant: Instant) -> Vector:
        """Return the unit vector towards the target, body axes."""
        if isinstance(self.target, MagneticField):
            field = self.target.in_body(instant)
            return field / functions.norm(field)
        return Vector(instant.attitude.to_body(-instant.direction(self.target)))

    @override
    def reading(self, instant: Instant) -> Vector:
        return self.direction(instant) + Vector(self.bias)

    @override
    def unit(self, units: DerivedUnits) -> str:
        return "1"

    @property
    @override
    def frame(self) -> str:
        return "body"

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        angle = functions.angle_between(Vector(self.boresight), self.direction(instant))
        own = {"outside the field of view": functions.less(self.field_of_view, angle)}
        if self.occulters and isinstance(self.target, Orbit):
            covers = [occulter.covers(instant, self.target) for occulter in self.occulters]
            own["eclipsed"] = functools.reduce(lambda some, one: functions.where(some, True, one), covers)
        return own

    @override
    def disturbed(self, readings: Array, errors: Array) -> Array:
        turn = random_turn(Vector(np.moveaxis(np.asarray(errors), -1, 0)))
        return quat.rotate(quat.assemble(turn), readings)


class CoarseSunSensors(Observable):
    """Coarse Sun sensors: photodiodes whose readings follow the cosine law.

    Head i reads gain_i f max(0, n_i . u), with the unit vector u towards the Sun and the visible fraction f of its
    disc. There is no reading in the umbra. The model ignores light that the planet reflects and the distance from the
    Sun.

    Parameters
    ----------
    sun : Orbit
        Orbit of the body relative to the Sun.
    normals : array (n, 3), body axes
        Unit normals of the heads.
    gain : array (n,) or float
        Reading of a head that faces the unobstructed Sun.
    occulters : sequence of Occulter
        Spheres between the body and the Sun.
    sun_radius : float
        Radius of the Sun, in the unit of length of its orbit. Default: 6.957e8 metres.
    noise : float
        Standard deviation of each reading.

    Raises
    ------
    ValueError
        If a normal is no unit vector, a number is negative, or the Sun is nearer than its radius.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.327e20, position=(-1.496e11, 0, 0))  # m, s; the Sun is towards +x
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, np.pi / 6])
    >>> heads = pt.observables.CoarseSunSensors(sun, [(1, 0, 0), (-1, 0, 0), (0, -1, 0)])
    >>> pt.observe(motion, heads).values.round(3)
    array([[1.   , 0.   , 0.   ],
           [0.866, 0.   , 0.5  ]])
    """

    sun: Orbit
    normals: Annotated[Any, ("count", 3), Along("body axes"), Rule(refuse_other_length, "Divide by the length.")]
    _: KW_ONLY
    gain: Annotated[Any, ("count",), OR_NUMBER, Rule(refuse_negative)] = 1.0
    occulters: tuple[Occulter, ...] = ()
    sun_radius: Positive = SUN_RADIUS
    noise: NotNegative = 0.0

    count = ArrayLength("normals", "Number of heads.")

    @override
    def check_times(self, times: Array) -> None:
        if not self.occulters:
            return
        distance = np.min(np.asarray(functions.norm(Vector(self.sun.position_at(times))), dtype=float))
        if np.any(distance <= self.sun_radius):
            raise ValueError(
                f"sun_radius must be less than the distance of the Sun, got {np.max(self.sun_radius):g} and "
                f"{distance:g}. Give sun_radius in the unit of the orbit."
            )

    @property
    def components(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the heads."""
        return tuple(f"head {i}" for i in range(self.count))

    @override
    def reading(self, instant: Instant) -> Vector:
        towards = instant.attitude.to_body(-instant.direction(self.sun))
        visible = visible_fraction(instant, self.sun, self.occulters, self.sun_radius)
        cosines = (functions.maximum(functions.dot(normal, towards), 0.0) for normal in self.normals)
        return Vector(gain * visible * cosine for gain, cosine in zip(self.gain, cosines, strict=True))

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        visible = visible_fraction(instant, self.sun, self.occulters, self.sun_radius)
        return {"eclipsed": functions.less(visible, DARK)} if self.occulters else {}
