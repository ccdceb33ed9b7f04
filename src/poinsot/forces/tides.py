"""Friction in two bodies that attract each other: tides with a time lag, and damped librations."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Vector
from poinsot.mechanics.force import Load, PairLoad
from poinsot.mechanics.parameters import NotNegative, Positive
from poinsot.mechanics.two_bodies import BODIES, check_name_of_body

__all__ = ["LibrationDamping", "TidalFriction"]


class Friction(PairLoad):
    """Friction in one of two bodies: a force along the separation's motion as that body sees it.

    The force on the secondary and the torque on the body are those of one internal force, and keep the angular momentum
    of the pair.
    """

    body: str

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name_of_body(self.body)

    def _load(self, instant: Any, across: Any, along: Any) -> Load:
        """Return the load of a force -across (v - omega x r) - along (r.v) r, where v and r are of the separation."""
        each = getattr(instant, self.body)
        r, v = instant.separation, instant.relative_velocity
        omega = each.attitude.to_space(each.omega_body)
        force = -across * (v - functions.cross(omega, r)) - along * functions.dot(r, v) * r
        torque = each.attitude.to_body(-functions.cross(r, force))
        nothing = Vector((0.0, 0.0, 0.0))
        return Load(force, (torque, nothing) if self.body == BODIES[0] else (nothing, torque))


class TidalFriction(Friction):
    """The friction of the tide that one of two bodies has from the other, with a constant time lag.

    F = -3 K dt / r^10 [2 r (r.v) + r^2 (v - omega x r)] on the secondary and -r x F on the body, where r is the
    separation, v its rate, omega that of the body and K = k2 G m^2 R^5 with the mass m of the other one (Mignard 1979,
    Moon and Planets 20, 301). Energy goes at the rate 3 K dt / r^10 [2 (r.v)^2 + r^2 |v - omega x r|^2]; the angular
    momentum of the pair stays. The bulge without lag, which has the energy -K / (2 r^6), is not in it.

    Parameters
    ----------
    body : {"primary", "secondary"}
        In which the tide is. Tides in both are two forces.
    love_number : float
        k2 of the body.
    radius : float
        R of the body.
    time_lag : float
        By which the bulge is late; about 1 / (Q w) for a quality Q at the frequency w of the tide.

    Raises
    ------
    ValueError
        If the body is another one, the radius is not positive, or another number is negative.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> tide = pt.forces.TidalFriction("secondary", love_number=0.1, radius=1.0, time_lag=0.01)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity(), tide)
    >>> [integral.symbol for integral in system.integrals]
    ['G1', 'G2', 'G3']
    """

    love_number: NotNegative
    radius: Positive
    time_lag: NotNegative

    @override
    def load(self, instant: Any) -> Load:
        masses = instant.pair.each_mass
        other = masses[1 - BODIES.index(self.body)]
        inverse = 1 / functions.dot(instant.separation, instant.separation)
        bulge = 3 * self.love_number * instant.pair.G * (other * other) * self.radius**5 * self.time_lag
        across = bulge * (inverse * inverse) * (inverse * inverse)
        return self._load(instant, across, 2 * across * inverse)


class LibrationDamping(Friction):
    """A torque against the rate at which one of two bodies turns relative to the line of centres.

    torque = -coefficient (omega - r x v / r^2) without its part along r, and the opposite torque on the orbit, by a
    force across r: the angular momentum of the pair stays. Turns about the line of centres are not damped, as no force
    at the other body could be.

    Parameters
    ----------
    body : {"primary", "secondary"}
    coefficient : float
        Torque per rate, not negative.

    Raises
    ------
    ValueError
        If the body is another one, or the coefficient is negative.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.LibrationDamping("secondary", 0.1))
    >>> start = system.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0), (0.5, 0, 2.5)])
    >>> float(system.load_at(system.at(start)).torques[1][2])
    -0.2
    """

    coefficient: NotNegative

    @override
    def load(self, instant: Any) -> Load:
        inverse = 1 / functions.dot(instant.separation, instant.separation)
        across = self.coefficient * inverse
        return self._load(instant, across, -across * inverse)
