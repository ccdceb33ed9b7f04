"""Events of two bodies: apsides, distances, contact, extremes of a libration."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any

from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.mechanics.body import Body
from poinsot.mechanics.event import Event
from poinsot.mechanics.two_bodies import TwoBodies, check_name_of_body, gap_between, refuse_overlap
from poinsot.printable import quoted
from poinsot.quantities import BodyVector, Rule
from poinsot.records.parameters import Positive

__all__ = ["Contact", "DistanceCrossing", "LibrationExtreme", "PairApsis"]

Semiaxes = Annotated[BodyVector, Rule(refuse_nonpositive)]


class PairApsis(Event):
    """Apsis of the mutual orbit of two bodies: periapsis where the event function rises, apoapsis where it falls.

    The event function is the rate of change of the distance, up to a positive factor.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(ball, ball, G=1.0)
    >>> start = pair.state((3, 0, 0), (0, 0.9, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
    >>> system, apoapsis = pt.System(pair, pt.forces.MutualGravity()), pt.events.PairApsis(direction=-1)
    >>> motion = pt.propagate(system, start, [40.0], events=[apoapsis])
    >>> np.linalg.norm(motion.events[0].states.position, axis=-1).round(6)
    array([4.643312])
    """

    @override
    def value(self, instant: Any) -> Scalar:
        return functions.dot(instant.separation, instant.momentum)


class DistanceCrossing(Event):
    """Crossing of a distance between the centres of two bodies: rising at an escape, falling at an approach.

    Parameters
    ----------
    distance : float
        Distance between the centres, in the unit of the separation; positive.

    Raises
    ------
    ValueError
        If the distance is not positive.

    Examples
    --------
    >>> pt.events.DistanceCrossing(20.0, direction=1, terminal=True)  # an escape
    DistanceCrossing(distance=20.0, direction=1, terminal=True)
    """

    distance: Positive

    @override
    def value(self, instant: Any) -> Scalar:
        value: Scalar = instant.distance - self.distance
        return value


class Contact(Event):
    """Contact of two ellipsoids, which by default stops the integration.

    The event function is the common scale factor of both ellipsoids about their centres at which they touch, minus one
    (see `algebra.ellipsoids`).

    Parameters
    ----------
    primary, secondary : array (3,), body axes
        Semiaxes of each body in the unit of the separation; three equal semiaxes define a sphere.
        `Contact.of_shapes(pair)` uses the shapes of the bodies.
    direction : {-1, 0, 1}
        1: only where the event function rises with time, -1: only where it falls, 0: both. Default: -1, at an approach.
    terminal : bool
        True if the integration stops at the event. Default: True.

    Raises
    ------
    ValueError
        If a semiaxis is not positive. `propagate` raises it if the ellipsoids overlap in the initial state.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(ball, ball, G=1.0)
    >>> start = pair.state((3, 0, 0), (0, 0, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
    >>> system, contact = pt.System(pair, pt.forces.MutualGravity()), pt.events.Contact((1, 1, 1), (1, 1, 1))
    >>> motion = pt.propagate(system, start, [1.0, 2.0, 3.0, 4.0], events=[contact])
    >>> motion.times, motion.events[0].times.round(4)
    (array([1., 2.]), array([2.8238]))
    """

    primary: Semiaxes
    secondary: Semiaxes
    direction: int = field(default=-1, kw_only=True)
    terminal: bool = field(default=True, kw_only=True)

    @classmethod
    @checked
    def of_shapes(cls, pair: TwoBodies) -> Contact:
        """Return the contact event of two bodies that are defined by shapes or by `Body.from_ellipsoid`.

        An ellipsoid is used with its semiaxes along the body axes, any other shape with its circumscribed sphere.

        Parameters
        ----------
        pair : TwoBodies
            The two bodies.

        Returns
        -------
        Contact
            The event, which stops the integration.

        Raises
        ------
        ValueError
            If a body is not defined by a shape.
        """
        return cls(*(_semiaxes(name, body) for name, body in pair.bodies.items()))

    @override
    def value(self, instant: Any) -> Scalar:
        return gap_between((self.primary, self.secondary), instant.attitudes, instant.separation)

    @override
    def check_start(self, instant: Any) -> None:
        refuse_overlap(self.value(instant))


class LibrationExtreme(Event):
    """Extreme of the libration of one of two bodies, relative to the line of centres.

    The event function is (omega - r x v / r^2) . (r x p). At a falling zero the libration angle is a maximum, at a
    rising zero a minimum. A circulating body produces no such event in general.

    Parameters
    ----------
    body : {"secondary", "primary"}
        Librating body.

    Raises
    ------
    ValueError
        If the body is unknown.

    Examples
    --------
    >>> pt.events.LibrationExtreme(direction=-1)
    LibrationExtreme(body='secondary', direction=-1)
    """

    body: str = field(default="secondary", kw_only=True)

    def __post_init__(self) -> None:
        check_name_of_body(self.body)
        super().__post_init__()

    @override
    def value(self, instant: Any) -> Scalar:
        each, r = getattr(instant, self.body), instant.separation
        normal = functions.cross(r, instant.momentum)
        line = functions.cross(r, instant.relative_velocity) / functions.dot(r, r)
        return functions.dot(each.attitude.to_space(each.omega_body) - line, normal)


def _semiaxes(name: str, body: Body) -> Any:
    if body.semiaxes is not None:
        return body.semiaxes
    if body.shape is None:
        raise ValueError(f"{name} must be made of a shape, got {quoted(body)}. Write Contact(semiaxes, semiaxes).")
    return (body.shape.circumscribing_radius,) * 3
