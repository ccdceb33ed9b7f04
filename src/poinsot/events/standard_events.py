"""Standard events: crossings of directions, angular velocities, angular momenta, apsides and times."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.event import Event
from poinsot.mechanics.instant import Instant
from poinsot.quantities import Angle, AngularVelocity, Rule, Time
from poinsot.records.parameters import BodyDirection, SpaceDirection

__all__ = ["AndoyerCrossing", "Apsis", "AtTime", "AttractorCrossing", "AxisCrossing", "RateCrossing", "SpinFlip"]


def _refuse_other_angle(name: str, angle: Any, hint: str) -> None:
    wrong = np.atleast_1d(angle)[(np.atleast_1d(angle) <= 0) | (np.atleast_1d(angle) >= np.pi)]
    if wrong.size:
        raise ValueError(f"{name} must be in (0, pi), got {wrong[0]}. {hint}")


HalfOpening = Annotated[Angle, Rule(_refuse_other_angle, "Along the direction itself nothing crosses.")]


class AxisCrossing(Event):
    """Crossing of a cone or plane about a direction in space by a body axis.

    Parameters
    ----------
    axis : array (3,), body axes
        Body axis, of any length except zero.
    target : array (3,), space axes
        Axis of the cone, of any length except zero.
    angle : float
        Half-opening angle of the cone, radians, in (0, pi). Default: the plane, pi/2. The event function rises where
        the axis approaches the target.

    Raises
    ------
    ValueError
        If a vector is zero or the angle is not in (0, pi).

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> event = pt.events.AxisCrossing((1, 0, 0), target=(0, 1, 0), angle=np.pi / 3)
    >>> pt.propagate(pt.System(body), start, [3.0], events=[event]).events[0].times.round(4)
    array([0.5236, 2.618 ])
    """

    axis: BodyDirection
    target: SpaceDirection
    angle: HalfOpening = field(default=np.pi / 2, kw_only=True)

    @override
    def value(self, instant: Instant) -> Scalar:
        axis, target = functions.Vector(self.axis), functions.Vector(self.target)
        size = functions.norm(axis) * functions.norm(target)
        return functions.dot(axis, instant.attitude.to_body(target)) - size * functions.cos(self.angle)


class AttractorCrossing(Event):
    """Crossing of a cone or plane about the direction to an attractor by a body axis.

    Parameters
    ----------
    axis : array (3,), body axes
        Body axis, of any length except zero.
    orbit : Orbit
        Orbit of the body about the attractor.
    angle : float
        Half-opening angle of the cone about the direction to the attractor, radians, in (0, pi). Default: the plane,
        pi/2. The event function rises where the axis approaches the direction.

    Raises
    ------
    ValueError
        If the axis is zero or the angle is not in (0, pi).

    Examples
    --------
    >>> body, orbit = pt.Body((1.0, 1.6, 2.5)), pt.orbits.FixedPosition(1.0, position=(-1, 0, 0))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> event = pt.events.AttractorCrossing((0, 1, 0), orbit)
    >>> pt.propagate(pt.System(body), start, [5.0], events=[event]).events[0].times.round(4)
    array([3.1416])
    """

    axis: BodyDirection
    orbit: Orbit
    angle: HalfOpening = field(default=np.pi / 2, kw_only=True)

    @override
    def value(self, instant: Instant) -> Scalar:
        axis, outwards = functions.Vector(self.axis), instant.attitude.to_body(instant.direction(self.orbit))
        return -functions.dot(axis, outwards) - functions.norm(axis) * functions.cos(self.angle)


class RateCrossing(Event):
    """Crossing of a value by the inertial angular velocity along a body axis.

    Parameters
    ----------
    axis : array (3,), body axes
        Body axis, of any length except zero.
    rate : float
        Value of the angular velocity, radians per unit of time.

    Raises
    ------
    ValueError
        If the axis is zero.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.1))
    >>> motion = pt.propagate(pt.System(body), start, [20.0], events=[pt.events.RateCrossing((0, 0, 1), rate=0.2)])
    >>> motion.events[0].omega_body[:, 2].round(4)
    array([0.2, 0.2, 0.2])
    """

    axis: BodyDirection
    rate: AngularVelocity = field(default=0.0, kw_only=True)

    @override
    def value(self, instant: Instant) -> Scalar:
        axis = functions.Vector(self.axis)
        return functions.dot(axis, instant.omega_body) - functions.norm(axis) * self.rate


class SpinFlip(Event):
    """Sign change of the angular momentum along a body axis.

    Parameters
    ----------
    axis : array (3,), body axes
        Body axis, of any length except zero.

    Raises
    ------
    ValueError
        If the axis is zero.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.1))  # about the unstable axis
    >>> motion = pt.propagate(pt.System(body), start, [20.0], events=[pt.events.SpinFlip((0, 1, 0), direction=-1)])
    >>> motion.events[0].times.round(2)
    array([7.97])
    """

    axis: BodyDirection

    @override
    def value(self, instant: Instant) -> Scalar:
        return functions.dot(functions.Vector(self.axis), instant.angular_momentum_body)


class AndoyerCrossing(Event):
    """Crossing of a value by Andoyer's angle g, for sections in the plane (l, L).

    With G the angular momentum, s the third body axis and k the pole, sin g and cos g are proportional to k . (G x s)
    |G| and (k . G)(G . s) - (k . s) G^2. The event function is proportional to G^2 sin(g - angle), and the event
    requires cos(g - angle) > 0. It rises where g increases.

    Parameters
    ----------
    angle : float
        Value of g, radians.
    pole : array (3,), space axes
        Axis that defines the angles g and h, of any length except zero. `Andoyer` uses the third space axis.

    Raises
    ------
    ValueError
        If the pole is zero.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = pt.Andoyer(l=0.1, g=-0.2, h=0.3, L=0.5, G=1.0, H=0.4).state()
    >>> motion = pt.propagate(pt.System(body), start, [2.0], events=[pt.events.AndoyerCrossing(direction=1)])
    >>> motion.events[0].times.round(4)
    array([0.3187])
    """

    angle: Angle = field(default=0.0, kw_only=True)
    pole: SpaceDirection = field(default=(0.0, 0.0, 1.0), kw_only=True)

    @override
    def value(self, instant: Instant) -> Scalar:
        return self._sine_and_cosine(instant)[0]

    @override
    def condition(self, instant: Instant) -> Scalar:
        return self._sine_and_cosine(instant)[1]

    def _sine_and_cosine(self, instant: Instant) -> tuple[Scalar, Scalar]:
        G = instant.angular_momentum_body
        k, axis = instant.attitude.to_body(self.pole), functions.Vector((0.0, 0.0, 1.0))
        sine = functions.dot(k, functions.cross(G, axis)) * functions.norm(G)
        cosine = functions.dot(k, G) * G[2] - k[2] * functions.dot(G, G)
        c, s = functions.cos(self.angle), functions.sin(self.angle)
        return sine * c - cosine * s, cosine * c + sine * s


class Apsis(Event):
    """Apsis of a given orbit: the periapsis where the event function rises, the apoapsis where it falls.

    The event function is the rate of change of the distance from the attractor, up to a positive factor.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor.

    Examples
    --------
    >>> body, orbit = pt.Body((1.0, 1.6, 2.5)), pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.3)
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> motion = pt.propagate(pt.System(body), start, [7.0], events=[pt.events.Apsis(orbit, direction=-1)])
    >>> motion.events[0].times.round(4)  # of the apoapsis
    array([3.1416])
    """

    orbit: Orbit

    @override
    def value(self, instant: Instant) -> Scalar:
        return functions.dot(instant.position(self.orbit), instant.velocity(self.orbit))


class AtTime(Event):
    """Event at a given time, for actions at that time.

    Parameters
    ----------
    time : float
        Time of the event.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> pt.propagate(pt.System(body), start, [3.0], events=[pt.events.AtTime(1.0)]).events[0].times
    array([1.])
    """

    time: Time

    @override
    def value(self, instant: Instant) -> Scalar:
        return instant.time - self.time
