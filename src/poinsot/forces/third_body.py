"""Gravity of a third body on two bodies that attract each other."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Potential
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import quoted

__all__ = ["ThirdBody"]


class ThirdBody(Potential):
    """Tidal force and torque of a third body on two bodies and their orbit, such as the Sun or a planet in a flyby.

    U = -mu sum_i [m_i (1/d_i - 1/R + R.x_i/R^3) + (tr I_i - 3 u_i.I_i u_i)/(2 d_i^3)], where R is the position of the
    barycentre relative to the third body, R + x_i the position of body i, and d_i and u_i its distance and direction.
    The code evaluates the round bracket without cancellation: with q = (2 R.x + x^2)/R^2 and s = sqrt(1 + q) = d/R, R
    (1/d - 1/R + R.x/R^3) = q^2 (s + 2)/(2 s (1 + s)^2) - x^2/(2 R^2).

    Parameters
    ----------
    orbit : Orbit
        Orbit of the barycentre about the third body, with the third body's `mu`. The pair does not perturb this orbit.

    Raises
    ------
    ValueError
        `System` raises it for a single body, which requires `GravityGradient`.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> sun = pt.orbits.KeplerOrbit(400.0, semimajor_axis=20.0, eccentricity=0.1)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity(), pt.forces.ThirdBody(sun))
    >>> system.integrals
    ()
    """

    formula = (
        "U = -(mu*sum(m[i]*(1/norm(d[i]) - 1/norm(R)) + "
        "(trace(I[i]) - 3*(dot(n[i], I[i]*n[i])))/(2*norm(d[i])**3), i, 1, 2)); d[i] = R + y[i]; n[i] = d[i]/norm(d[i])"
    )
    orbit: Orbit

    @override
    def check(self, body: Any) -> None:
        if not isinstance(body, TwoBodies):
            raise ValueError(f"ThirdBody must act on TwoBodies, got {quoted(body)}. On one body: GravityGradient.")

    @override
    def energy(self, instant: Any) -> Scalar:
        inverse, outwards = instant.inverse_distance(self.orbit), instant.direction(self.orbit)
        bodies = zip(instant.pair.each_mass, (instant.primary, instant.secondary), instant.from_barycenter, strict=True)
        total: Scalar = 0.0
        for mass, each, position in bodies:
            place = position * inverse
            square = functions.dot(place, place)
            q = 2 * functions.dot(outwards, place) + square
            s = functions.sqrt(1 + q)
            monopole = q * q * (s + 2) / (2 * s * (1 + s) * (1 + s)) - 0.5 * square
            direction = each.attitude.to_body((outwards + place) / s)
            spread = sum(each.body.moments) - 3 * each.body.moment_about(direction)
            total = total + mass * monopole + inverse * inverse / (2 * s * s * s) * spread
        value: Scalar = -self.orbit.mu * inverse * total
        return value
