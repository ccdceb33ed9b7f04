"""Mutual gravity of two bodies made of point masses, to all degrees."""

from __future__ import annotations

import functools
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.forces.point_masses import beyond_the_first, inertia_of_points, paired_sum
from poinsot.forces.same_body import (
    deviator,
    refuse_no_sphere,
    refuse_one_body,
    refuse_other_inertia,
    refuse_other_mass,
)
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Potential
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.quantities import Along
from poinsot.records.parameters import ArrayLength
from poinsot.taylor.graph import number, ruled

__all__ = ["MutualMascons"]


class MutualMascons(Potential):
    """Exact mutual gravity of two rigid sets of point masses.

    V = -G sum_ij m_i m_j / |r + x_j - x_i|, with x_i relative to the centre of the primary and x_j relative to the
    centre of the secondary. A point can represent a sphere: a spherical body is a single point at the origin. The cost
    is proportional to the number of pairs of points.

    Parameters
    ----------
    primary_masses, secondary_masses : array (n,)
        Masses of the points, in the unit of mass of the bodies. A negative mass represents a cavity.
    primary_positions, secondary_positions : array (n, 3), body axes
        Positions relative to the centre of mass of each body, in the unit of the separation.

    Raises
    ------
    ValueError
        `System` raises it if the mass of a set, or the non-spherical part of its inertia tensor, differs from the
        body's by more than 1e-9, or the centre of mass is off the origin by more than 1e-12 of the farthest distance.

    Examples
    --------
    >>> bone = pt.shapes.Mascons((1.0, 1.0, 1.0), ((1, 0, 0), (-0.5, 0.75, 0), (-0.5, -0.75, 0)))
    >>> pair = pt.TwoBodies(pt.Body.from_shape(bone), pt.Body.from_ellipsoid(0.5, (0.2, 0.2, 0.2)), G=1.0)
    >>> gravity = pt.forces.MutualMascons(bone.masses, bone.positions, (0.5,), ((0, 0, 0),))
    """

    formula = (
        "U = -(G*sum(sum(primary_masses[i]*secondary_masses[j]"
        "/norm(x + secondary_positions[j] - primary_positions[i]), j), i))"
    )
    primary_masses: Annotated[Any, ("primary_count",)]
    primary_positions: Annotated[Any, ("primary_count", 3), Along("body axes")]
    secondary_masses: Annotated[Any, ("secondary_count",)]
    secondary_positions: Annotated[Any, ("secondary_count", 3), Along("body axes")]

    primary_count = ArrayLength("primary_positions", "Number of points of the primary.")
    secondary_count = ArrayLength("secondary_positions", "Number of points of the secondary.")

    @classmethod
    @checked
    def of_shapes(cls, pair: TwoBodies) -> MutualMascons:
        """Return the mutual gravity of two bodies, each defined by `Mascons` or a sphere.

        Parameters
        ----------
        pair : TwoBodies
            The two bodies.

        Returns
        -------
        MutualMascons
            The gravity with the points of both bodies.
        """
        masses = np.moveaxis(pair.masses, -1, 0)
        sets = [_points(name, body, mass) for (name, body), mass in zip(pair.bodies.items(), masses, strict=True)]
        return cls(*sets[0], *sets[1])

    @property
    def sets(self) -> dict[str, tuple[Any, Any]]:
        """Masses and positions of the two bodies, by name."""
        return {
            "primary": (self.primary_masses, self.primary_positions),
            "secondary": (self.secondary_masses, self.secondary_positions),
        }

    @override
    def check(self, body: Any) -> None:
        refuse_one_body(self, body)
        hint = "Take both from one shape along the same axes and in the same units."
        for mass, (name, (masses, positions)) in zip(body.each_mass, self.sets.items(), strict=True):
            refuse_other_mass(f"{name}_masses", np.sum(masses, axis=-1), mass, hint)
            own, given = body.bodies[name].inertia, inertia_of_points(f"{name}_positions", masses, positions)
            named = f"{name}_masses and {name}_positions"
            refuse_other_inertia(named, deviator(given), deviator(own), body.bodies[name], hint)

    @override
    def energy(self, instant: Any) -> Scalar:
        ones, others = (list(zip(*each, strict=True)) for each in self.sets.values())
        first, second = instant.attitudes
        inverse, separation = 1 / instant.distance, instant.separation
        near, far, rows = first.to_body(separation), second.to_body(separation), _rows(second, first)
        behind = [functions.dot(x, x) - 2 * functions.dot(near, x) for _, x in ones]
        ahead = [functions.dot(y, y) + 2 * functions.dot(far, y) for _, y in others]
        turned = [Vector(2 * functions.dot(row, y) for row in rows) for _, y in others]
        terms = [  # |r + y - x|^2 = r^2 + a + b - 2 x . y
            m * n * _beyond_the_first(inverse, a + b - functions.dot(x, y))
            for (m, x), a in zip(ones, behind, strict=True)
            for (n, _), b, y in zip(others, ahead, turned, strict=True)
        ]
        (first_mass, first_spread), (second_mass, second_spread) = map(_zeroth_and_second, self.sets.values())
        spread = first_mass * second_spread + second_mass * first_spread
        linear = inverse * (first_mass * second_mass - 0.5 * inverse * inverse * spread)
        value: Scalar = -instant.pair.G * (linear + paired_sum(terms))
        return value


def _beyond_the_first(inverse: Scalar, excess: Scalar) -> Scalar:
    """Return 1 / sqrt(r^2 + e) - 1 / r + e / (2 r^3) of 1 / r and e."""
    u, size = number(inverse), number(inverse) * number(inverse)
    x = number(excess) * size
    value, slope = beyond_the_first(x)
    slopes = 1.5 * x - 2 * slope, size * u * slope
    return ruled(u * value, (inverse, excess), slopes.__getitem__)


def _zeroth_and_second(points: tuple[Any, Any]) -> tuple[Scalar, Scalar]:
    masses, positions = points
    return sum(masses), sum(m * functions.dot(x, x) for m, x in zip(masses, positions, strict=True))


def _rows(body: Attitude, seen_from: Attitude) -> list[Vector]:
    """Return the rotation matrix from the axes of a body to the axes of another one, by rows with their derivatives."""
    axes, turn = body.seen_from(seen_from)
    columns = [[ruled(x, turn, functools.partial(_slope, axis, i)) for i, x in enumerate(axis)] for axis in axes]
    return [Vector(row) for row in zip(*columns, strict=True)]


def _slope(axis: Vector, i: int, k: int) -> Scalar:
    """Return the derivative of component i of an axis by the angle of a rotation about e_k: e_k x axis."""
    if i == k:
        return 0.0
    other = number(axis[3 - i - k])
    value: Scalar = other if (k - i) % 3 == 1 else -other
    return value


def _points(name: str, body: Body, mass: Any) -> tuple[Any, Any]:
    """Return masses and positions of a body that is made of points, or is a sphere."""
    if hasattr(body.shape, "positions"):
        return body.shape.masses, body.shape.positions - body.shape.center_of_mass
    refuse_no_sphere(name, body, "Mascons")
    return mass[..., None], np.zeros((1, 3))
