"""The gravity between two bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from typing_extensions import override

from poinsot import functions
from poinsot.algebra.harmonic_forms import Form, TurnedForms, coefficients_of, form_of, product
from poinsot.algebra.solid_harmonics import SolidHarmonics
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.force import Potential
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.two_bodies import TwoBodies

__all__ = ["MutualGravity", "MutualHarmonics"]


class MutualGravity(Potential):
    """The gravity of two bodies to second degree, complete: it moves the orbit and turns both.

    V = -G m1 m2 / r - G / (2 r^3) (m1 (tr I2 - 3 u.I2 u) + m2 (tr I1 - 3 u.I1 u)), u the direction between the centres.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity())
    >>> [integral.symbol for integral in system.integrals]
    ['H', 'G1', 'G2', 'G3']
    """

    @override
    def check(self, body: Any) -> None:
        _refuse_one(self, body)

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
        return -pair.G * inverse * (masses[0] * masses[1] + 0.5 * inverse * inverse * second)


class MutualHarmonics(Potential):
    """The gravity of two bodies."""

    primary: GravityField
    secondary: GravityField
    degree: int

    @override
    def energy(self, instant: Any) -> Scalar:
        pair, inverse = instant.pair, 1 / instant.distance
        first, second = instant.attitudes
        masses, direction = pair.each_mass, inverse * instant.separation
        axes = [first.to_body(axis) for axis in second.matrix.T]
        near, far = first.to_body(direction), -second.to_body(direction)
        total = 1 + self._terms(self.primary, self.secondary, inverse, near, axes, 0)
        total = total + self._terms(self.secondary, self.primary, inverse, far, list(zip(*axes, strict=True)), 1)
        return -pair.G * masses[0] * masses[1] * inverse * total

    def _terms(
        self,
        own: GravityField,
        other: GravityField,
        inverse: Scalar,
        direction: Vector,
        axes: Sequence[Sequence[Scalar]],
        least: int,
    ) -> Scalar:
        """Return the terms in which the degree of a body is that of the other one, plus the least, or larger."""
        turned, ratio = TurnedForms(axes), other.radius / own.radius
        forms: dict[int, Form] = {n: form_of(own.row(n)) for n in range(2, self.degree + 1)}
        total = dict(forms)
        for l in range(2, (self.degree - least) // 2 + 1):
            factor = (-ratio) ** l
            form = turned.turned([(factor * c, factor * s) for c, s in form_of(other.row(l))])
            for k in range(l + least, self.degree - l + 1):
                total[k + l] = _sum(total[k + l], product(forms[k], form))
        harmonics, size = SolidHarmonics(direction, squared=1), own.radius * inverse
        return sum(size**n * harmonics.sum(coefficients_of(form)) for n, form in total.items())


def _sum(a: Form, b: Form) -> Form:
    return [(c + d, s + t) for (c, s), (d, t) in zip(a, b, strict=True)]


def _refuse_one(force: Potential, body: Any) -> None:
    if not isinstance(body, TwoBodies):
        raise ValueError(f"{type(force).__name__} must act between TwoBodies, got {body!r}.")
