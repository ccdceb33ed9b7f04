"""Gravity of an attractor on a body made of point masses, to all degrees."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.forces.point_masses import beyond_the_first, inertia_of_points, paired_sum
from poinsot.forces.same_body import refuse_other_inertia
from poinsot.functions import Scalar
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Potential
from poinsot.mechanics.instant import Instant
from poinsot.quantities import Along
from poinsot.records.parameters import ArrayLength
from poinsot.taylor.graph import ruled

__all__ = ["MasconGravity"]


class MasconGravity(Potential):
    """Exact gravity of an attractor on a rigid set of point masses, without the terms independent of the attitude.

    U = -mu sum_i m_i (1 / |r + x_i| - 1 / r + s_i / r + |x_i|^2 / (2 r^3)), s_i = r . x_i / r^2. The terms after the
    first add up to a constant, because the positions are relative to the centre of mass; they avoid cancellation at
    large distances. The formula is valid unless the attractor is at one of the points.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the centre of mass about the attractor, with the attractor's `mu`.
    masses : array (n,)
        Masses of the points, in the unit of mass of the moments. A negative mass represents a cavity.
    positions : array (n, 3), body axes
        Positions relative to the centre of mass, in the unit of length of the orbit.

    Raises
    ------
    ValueError
        `System` raises it if the centre of mass is off the origin by more than 1e-12 of the farthest distance, or the
        inertia tensor differs from the body's by more than 1e-9 of the largest moment.

    Examples
    --------
    >>> masses, positions = (1, 1, 1), ((1, 0, 0), (-0.5, 0.75, 0), (-0.5, -0.75, 0))
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(3, 1, 0))
    >>> body = pt.Body.from_point_masses(masses, positions)
    >>> system = pt.System(body, pt.forces.MasconGravity(orbit, masses, positions))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(4)
    array([ 0.    ,  0.    , -0.0278])
    """

    formula = (
        "U = -(mu*sum(masses[i]*(1/norm(x + positions[i]) - 1/r + dot(x, positions[i])/r**3 + "
        "norm(positions[i])**2/(2*r**3)), i))"
    )
    moves_orbit: ClassVar[bool] = False
    orbit: Orbit
    masses: Annotated[Any, ("count",)]
    positions: Annotated[Any, ("count", 3), Along("body axes")]

    count = ArrayLength("positions", "Number of points.")

    @override
    def energy(self, instant: Instant) -> Scalar:
        inverse = instant.inverse_distance(self.orbit)
        away: Any = 2 * inverse * instant.attitude.to_body(instant.direction(self.orbit))
        terms = [
            mass * _beyond_the_first(functions.dot(x, away) + functions.dot(x, x) * (inverse * inverse))
            for mass, x in zip(self.masses, self.positions, strict=True)
        ]
        return inverse * -self.orbit.mu * paired_sum(terms)

    @override
    def check(self, body: Body) -> None:
        own = inertia_of_points("positions", self.masses, self.positions)
        hint = "Body.from_point_masses(masses, positions) has the right one."
        refuse_other_inertia("masses and positions", own, body.inertia, body, hint)


def _beyond_the_first(x: Scalar) -> Scalar:
    value, slope = beyond_the_first(x)
    return ruled(value, (x,), lambda _: slope)
