"""Mutual gravity of two bodies by the multipoles of both."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import comb
from typing import Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.harmonic_forms import Form, TurnedForms, coefficients_of, form_of, product, sum_of
from poinsot.algebra.solid_harmonics import SolidHarmonics
from poinsot.checked import checked
from poinsot.forces.same_body import (
    deviator,
    refuse_no_sphere,
    refuse_one_body,
    refuse_other_inertia,
    refuse_other_mass,
)
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Potential
from poinsot.mechanics.gravity_field import GravityField, whole_degree
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.records.members import of_scalars

__all__ = ["MutualGravity", "MutualHarmonics"]

COUNTED_ERROR = 0.01
"""Smallest estimated error of the force, relative to the force, that the result of a run reports."""


class MutualSeries(Potential):
    """Mutual gravity of two bodies to a total degree."""

    @override
    def check(self, body: Any) -> None:
        refuse_one_body(self, body)

    @of_scalars
    def truncation(self, instant: Any) -> Scalar:
        """Return an estimate of the error of the force between the bodies, relative to it, at a `PairInstant`.

        The mean of the last two degrees over all attitudes is multiplied by (R1 + R2)^2 / r^2 for the next two degrees,
        with the radii R of spheres that contain the bodies. A value above 1 shows that the series is not accurate.
        """
        first, second = self._powers(instant)
        inverse = 1 / (instant.distance * instant.distance)
        last, square = len(first) - 1, 0.0
        for n in range(max(2, last - 1), last + 1):
            degrees = sum(comb(2 * n, 2 * l) * (first[l] * second[n - l]) for l in range(n + 1))
            square = square + (n + 1) * (2 * n + 1) * degrees * inverse**n
        reach = sum(self._reaches(instant))
        value: Scalar = functions.sqrt(square) * (reach * reach * inverse)
        return value

    @override
    def validity(self, instant: Any) -> Mapping[str, Scalar]:
        return {
            "overlapping_spheres": functions.less(instant.distance, sum(self._reaches(instant))),
            "coarse_series": functions.less(COUNTED_ERROR, self.truncation(instant)),
        }

    @override
    def relative_errors(self, instant: Any) -> Mapping[str, Scalar]:
        return {"coarse_series": self.truncation(instant)}

    @abstractmethod
    def _powers(self, instant: Any) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        """Return the mean squares of the terms of each body by degree, at the unit of length, relative to degree 0.

        The mean square of a term of both bodies over all attitudes is C(2 n, 2 l) times the product.
        """

    @abstractmethod
    def _reaches(self, instant: Any) -> Sequence[Scalar]:
        """Return the radii of spheres that contain the bodies."""


class MutualGravity(MutualSeries):
    """Mutual gravity of two extended bodies to second degree, which acts on the orbit and on both attitudes.

    V = -G m1 m2 / r - G / (2 r^3) (m1 (tr I2 - 3 u.I2 u) + m2 (tr I1 - 3 u.I1 u)), MacCullagh's formula for both
    bodies, with u the direction between the centres. A result counts the times at which ellipsoids with the same
    moments may overlap (`overlapping_spheres`) and the times at which the estimated `truncation` is above 1%
    (`coarse_series`).

    Raises
    ------
    ValueError
        `System` raises it for a single body.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity())
    >>> [integral.symbol for integral in system.integrals]
    ['H', 'G1', 'G2', 'G3']
    """

    formula = "U = -(G/r*(m1*m2 + (m2*(trace(I1) - 3*(dot(u, I1*u))) + m1*(trace(I2) - 3*(dot(u, I2*u))))/(2*r**2)))"

    @override
    def energy(self, instant: Any) -> Scalar:
        pair, inverse = instant.pair, 1 / instant.distance
        masses = pair.each_mass
        direction = inverse * instant.separation
        bodies = (instant.primary, instant.secondary)
        spread = [
            sum(each.body.moments) - 3 * each.body.moment_about(each.attitude.to_body(direction)) for each in bodies
        ]
        second = masses[1] * spread[0] + masses[0] * spread[1]
        value: Scalar = -pair.G * inverse * (masses[0] * masses[1] + 0.5 * inverse * inverse * second)
        return value

    @override
    def _powers(self, instant: Any) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        first, second = (
            (1.0, 0.0, 0.1 * sum((a - b) * (a - b) for a, b in itertools.combinations(body.moments, 2)) / (mass * mass))
            for body, mass in _bodies(instant)
        )
        return first, second

    @override
    def _reaches(self, instant: Any) -> Sequence[Scalar]:
        least = [functools.reduce(functions.minimum, body.moments) for body in instant.pair.bodies.values()]
        return [
            functions.sqrt(2.5 * (sum(body.moments) - 2 * moment) / mass)
            for (body, mass), moment in zip(_bodies(instant), least, strict=True)
        ]


class MutualHarmonics(MutualSeries):
    """Mutual gravity of two extended bodies to any total degree, from the gravity fields of both.

    V = -G m1 m2 / r sum_(l1 + l2 <= degree) (-1)^l2 (R1 / r)^l1 (R2 / r)^l2 (2n - 1)!! h(u), n = l1 + l2. The unit
    vector u points from primary to secondary, and h is the harmonic part of h1 h2, with h_l = sum_m (C_lm Re Z_lm +
    S_lm Im Z_lm) / (2l - 1)!! for each body along its axes and the solid harmonics Z (Borderies 1978, Celest. Mech. 18,
    295; Boue 2017, CMDA 128, 261). The expansion converges if the spheres that contain the bodies do not overlap. A
    result counts the times at which they do (`overlapping_spheres`) and the times with a `truncation` above 1%
    (`coarse_series`).

    Parameters
    ----------
    primary, secondary : GravityField
        Gravity fields along the axes of each body, in the units of the masses and of the separation.
    degree : int
        Total degree, from 2 to the lower degree of the two fields.

    Raises
    ------
    ValueError
        If a field has a lower degree. `System` raises it if the mass or degree 2 of a field differs from the body's by
        more than 1e-9.

    Examples
    --------
    >>> pair = pt.TwoBodies(*2 * [pt.Body.from_shape(pt.shapes.Ellipsoid((3, 2, 1), mass=2.0))], G=1.0)
    >>> gravity = pt.forces.MutualHarmonics.of_shapes(pair, degree=4)
    """

    primary: GravityField
    secondary: GravityField
    degree: int

    def __post_init__(self) -> None:
        super().__post_init__()
        most = min(self.primary.degree, self.secondary.degree)
        if not 2 <= self.degree <= most:
            raise ValueError(f"degree must be from 2 to {most}, the lower one of the fields, got {self.degree}.")

    @classmethod
    @checked
    def of_shapes(cls, pair: TwoBodies, degree: int) -> MutualHarmonics:
        """Return the mutual gravity of two bodies, each defined by a shape or a sphere.

        Parameters
        ----------
        pair : TwoBodies
            The two bodies.
        degree : int
            Total degree of the expansion, at least 2.

        Returns
        -------
        MutualHarmonics
            The gravity with the fields of both bodies.
        """
        degree, masses = whole_degree(degree), np.moveaxis(pair.masses, -1, 0)
        bodies = zip(pair.bodies.items(), masses, strict=True)
        primary, secondary = (_field(name, body, mass, degree) for (name, body), mass in bodies)
        return cls(primary, secondary, degree)

    @property
    def fields(self) -> dict[str, GravityField]:
        """Gravity fields of the two bodies, by name."""
        return {"primary": self.primary, "secondary": self.secondary}

    @override
    def check(self, body: Any) -> None:
        super().check(body)
        hint = "Take body and field from one shape along the same axes and in the same units."
        for mass, (name, field) in zip(body.each_mass, self.fields.items(), strict=True):
            refuse_other_mass(f"the field of the {name}", field.mass, mass, hint)
            own, given = deviator(body.bodies[name].inertia), field.inertia_deviator
            refuse_other_inertia(f"degree 2 of the field of the {name}", given, own, body.bodies[name], hint)

    @override
    def energy(self, instant: Any) -> Scalar:
        pair, inverse = instant.pair, 1 / instant.distance
        first, second = instant.attitudes
        masses, direction = pair.each_mass, inverse * instant.separation
        near = self._forms(self.primary, self.secondary, TurnedForms(*second.seen_from(first)), 0)
        far = self._forms(self.secondary, self.primary, TurnedForms(*first.seen_from(second)), 1)
        total = _series(near, self.primary.radius * inverse, first.to_body(direction))
        total = total + _series(far, self.secondary.radius * inverse, -second.to_body(direction))
        value: Scalar = -pair.G * masses[0] * masses[1] * inverse * (1 + total)
        return value

    def _forms(self, own: GravityField, other: GravityField, turned: TurnedForms, above: int) -> dict[int, Form]:
        """Return the sums of terms with l_own >= l_other + above by total degree, along the axes of the own body."""
        ratio = other.radius / own.radius
        forms = {n: form_of(own.row(n)) for n in range(2, self.degree + 1)}
        total = dict(forms)
        for l in range(2, (self.degree - above) // 2 + 1):
            factor = (-ratio) ** l
            form = turned.turned([(factor * c, factor * s) for c, s in form_of(other.row(l))])
            for k in range(l + above, self.degree - l + 1):
                total[k + l] = sum_of(total[k + l], product(forms[k], form))
        return total

    @override
    def _powers(self, instant: Any) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        first, second = ([1.0, 0.0, *map(field.power, range(2, self.degree + 1))] for field in self.fields.values())
        return first, second

    @override
    def _reaches(self, instant: Any) -> Sequence[Scalar]:
        return [functions.where(functions.less(0, f.extent), f.extent, f.radius) for f in self.fields.values()]


def _field(name: str, body: Body, mass: Any, degree: int) -> GravityField:
    if body.shape is not None:
        field: GravityField = dataclasses.replace(body.shape.field(degree), mass=mass)
        return field
    refuse_no_sphere(name, body, "a shape")
    radius, nothing = np.sqrt(2.5 * body.moments[..., 0] / mass), np.zeros((degree + 1, degree + 1))
    return GravityField(degree, mass, radius, nothing, nothing, extent=radius)


def _bodies(instant: Any) -> list[tuple[Body, Scalar]]:
    return list(zip(instant.pair.bodies.values(), instant.pair.each_mass, strict=True))


def _series(forms: Mapping[int, Form], size: Scalar, direction: Vector) -> Scalar:
    harmonics = SolidHarmonics(direction, squared=1)
    return sum(size**n * harmonics.sum(coefficients_of(form)) for n, form in forms.items())
