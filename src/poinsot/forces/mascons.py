"""Gravity of a point on a body made of points of mass, to all degrees."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.program import ruled
from poinsot.errors import real_numbers
from poinsot.forces.points import beyond_the_first, inertia_of_points, paired_sum
from poinsot.forces.same_body import refuse_other_inertia
from poinsot.functions import Scalar
from poinsot.lazy import cached_property
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Potential
from poinsot.mechanics.instant import Instant
from poinsot.quantities import Along

__all__ = ["MasconGravity"]


class MasconGravity(Potential):
    """An attractor's gravity on points of mass that move as one body, exactly, less what no attitude changes.

    U = -mu sum_i m_i (1 / |r + x_i| - 1 / r + s_i / r + |x_i|^2 / (2 r^3)), s_i = r . x_i / r^2: the terms after the
    first are a constant together, for the points are about their centre of mass, and leave nothing that cancels where
    the attractor is far. It holds wherever the attractor is not at one of the points.

    Parameters
    ----------
    orbit : Orbit
        Where the centre of mass is; `mu` is the orbit's.
    masses : array (n,)
        In the unit of the moments. A hole is a negative mass.
    positions : array (n, 3), body axes
        From the centre of mass, in the unit of the orbit.

    Raises
    ------
    ValueError
        By `System`, if the centre of mass is off the origin by more than 1e-12 of the farthest point, or the inertia is
        not the body's to 1e-9 of the largest moment.

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

    def __post_init__(self) -> None:
        shape = real_numbers("positions", self.positions).shape
        if len(shape) < 2:
            raise ValueError(f"positions must have shape (n, 3) or (members, n, 3), got shape {shape}.")
        super().__post_init__()

    @property
    def count(self) -> int:
        """The number of points."""
        return int(np.shape(self.positions)[-2])

    @cached_property
    @override
    def structure(self) -> tuple[Any, ...]:
        return (*super().structure, self.count)

    @override
    def energy(self, instant: Instant) -> Scalar:
        inverse = instant.inverse_distance(self.orbit)
        away = 2 * inverse * instant.attitude.to_body(instant.direction(self.orbit))
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
