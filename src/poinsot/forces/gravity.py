"""Gravity on a body with a fixed point, and gravity of a distant attractor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.solid_harmonics import SolidHarmonics
from poinsot.errors import refuse_negative
from poinsot.forces.same_body import deviator, refuse_other_inertia
from poinsot.functions import Scalar
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Potential
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.quantities import BodyVector, Real, Rule
from poinsot.records.parameters import Positive, SpaceDirection

__all__ = ["GravityGradient", "HarmonicGravity", "Oblateness", "UniformGravity"]


class UniformGravity(Potential):
    """Uniform gravity along -s3 on a body with a fixed point: the heavy top.

    U = weight * height of the centre of mass (paper, eq. (18) with the sign of erratum E8).

    Parameters
    ----------
    weight : float
        Weight M g, not negative.
    center_of_mass : array (3,), body axes
        Position of the centre of mass relative to the fixed point. The sign printed in the paper corresponds to minus
        this vector.

    Raises
    ------
    ValueError
        If the weight is negative. `System` raises it if a part moves the centre of mass.

    Examples
    --------
    >>> top = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(weight=0.5, center_of_mass=(1, 0, 0)))
    >>> top.torque_body(top.state((1, 0, 0, 0), omega_body=(0, 0, 0)))
    array([0. , 0.5, 0. ])
    """

    formula = "U = weight*dot(center_of_mass, s3)"
    weight: Annotated[Real, Rule(refuse_negative, "Gravity acts along -s3; turn center_of_mass.")]
    center_of_mass: BodyVector

    @override
    def energy(self, instant: Instant) -> Scalar:
        up = instant.attitude.to_body((0, 0, 1))
        return self.weight * functions.dot(self.center_of_mass, up)

    @override
    def check(self, body: Body) -> None:
        if body.moves_center_of_mass:
            raise ValueError(
                "UniformGravity must act on a body whose centre of mass stays in it, got a part that moves it. "
                "A body with such a part is free, and falls."
            )


class GravityGradient(Potential):
    """Gravity-gradient torque of a point-mass attractor on an extended body, to second degree.

    U = 3 mu J / (2 r^3), with J the moment of inertia about the direction to the attractor (eq. (20), from MacCullagh's
    formula (19)). U is the attitude-dependent part of the potential energy.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor, with the attractor's `mu`. Moments in mass length^2, with the unit of
        length of the orbit, give energies in mass length^2 / time^2.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(1, 1, 0))
    >>> system = pt.System(pt.Body((1, 2, 2.5)), pt.GravityGradient(orbit))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(4)
    array([0.    , 0.    , 0.5303])
    """

    formula = "U = 3*mu/(2*r**3)*(dot(u, I*u))"
    moves_orbit: ClassVar[bool] = False
    orbit: Orbit

    @override
    def energy(self, instant: Instant) -> Scalar:
        radial, inverse = instant.attitude.to_body(instant.direction(self.orbit)), instant.inverse_distance(self.orbit)
        return inverse * inverse * inverse * (1.5 * self.orbit.mu) * instant.body.attracted_moment(radial)


class HarmonicGravity(Potential):
    """Gravity of an attractor on a body with a known gravity field, to the degree of the field.

    U = -mu M / r sum_(n >= 2) (R / r)^n sum_m P_nm (C_nm cos + S_nm sin), evaluated in the direction from the body to
    the attractor. The series converges if the attractor is outside the smallest sphere about the centre of mass that
    contains the body. To degree 2 the torque equals the torque of `GravityGradient`.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor, with the attractor's `mu`.
    field : GravityField
        Gravity field of the body along the body axes, with the mass in the unit of the moments and lengths in the unit
        of the orbit.

    Raises
    ------
    ValueError
        `System` raises it if the differences between the moments of the body, or its products of inertia, differ from
        the field's by more than 1e-9 of the largest moment.

    Examples
    --------
    >>> shape, orbit = pt.shapes.Ellipsoid((1, 0.8, 0.5), mass=1.0), pt.orbits.FixedPosition(1.0, position=(3, 1, 0))
    >>> system = pt.System(pt.Body.from_shape(shape), pt.forces.HarmonicGravity(orbit, shape.field(degree=8)))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(6)
    array([0.     , 0.     , 0.00217])
    """

    formula = (
        "U = -(mu*mass/r*sum((radius/r)**n*sum(P[n, m]*(C[n, m]*cos(m*phi) + S[n, m]*sin(m*phi)), m, 0, n), "
        "n, 2, degree))"
    )
    moves_orbit: ClassVar[bool] = False
    orbit: Orbit
    field: GravityField

    @override
    def energy(self, instant: Instant) -> Scalar:
        field, inverse = self.field, instant.inverse_distance(self.orbit)
        size = power = field.radius * inverse
        harmonics = SolidHarmonics(instant.attitude.to_body(-instant.direction(self.orbit)), squared=1)
        total: Scalar = 0.0
        for n in range(2, field.degree + 1):
            power = power * size
            total = total + power * harmonics.sum(field.row(n))
        return inverse * (-self.orbit.mu * field.mass) * total

    def __post_init__(self) -> None:
        super().__post_init__()
        consequence = "the series does not converge there"
        warn_below(self, self.orbit, self.field.extent, "the sphere that holds the body", consequence)

    @override
    def check(self, body: Body) -> None:
        hint = "Take body and field from one shape along the same axes, or the body by Body.from_stokes from the field."
        refuse_other_inertia("the field's degree 2", self.field.inertia_deviator, deviator(body.inertia), body, hint)

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        return {"inside_sphere": functions.less(1, self.field.extent * instant.inverse_distance(self.orbit))}


class Oblateness(Potential):
    """Gravity-gradient torque due to the oblateness (J2) of an attractor, to second degree of the body.

    U = 3 mu f / (2 r^3) [5/2 (1 + 3 s^2) J(n) - J(k - 5 s n)], f = j2 (equatorial_radius / r)^2, with n from the
    attractor to the body, k along the pole, s = n . k and J(v) = v . I v. Together with `GravityGradient` it is the
    attitude-dependent part of -tr(W'' I) / 2, with W'' the second derivatives of -mu/r (1 - f P2(s)) (Roithmayr 1990,
    Flight Mechanics/Estimation Theory Symposium). Combine it with any gravity of the same attractor as a point mass.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor, with the attractor's `mu`. The oblateness does not perturb the orbit: a
        `KeplerOrbit` remains an ellipse.
    j2 : float
        -C20 of the attractor, not normalised, which is -sqrt(5) times the normalised coefficient. Positive for an
        oblate attractor.
    equatorial_radius : float
        Reference length of `j2`, positive, in the unit of length of the orbit. A periapsis below it causes a warning.
    pole : array (3,), space axes
        Direction of the attractor's axis, of either sign and any length except zero.

    Raises
    ------
    ValueError
        If the radius is not positive or the pole is zero.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.001)  # km, s
    >>> earth = pt.forces.Oblateness(orbit, j2=1.0826e-3, equatorial_radius=6378.137, pole=(0, 0, 1))
    >>> earth.pole
    array([0., 0., 1.])
    """

    formula = (
        "U = 3*mu/(2*r**3)*j2*(equatorial_radius/r)**2"
        "*(5/2*(1 + 3*c**2)*(dot(u, I*u)) - dot(k - 5*c*u, I*(k - 5*c*u))); "
        "k = pole/norm(pole); c = dot(u, k)"
    )
    moves_orbit: ClassVar[bool] = False
    orbit: Orbit
    j2: Real
    equatorial_radius: Positive
    pole: SpaceDirection

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.any(getattr(self.orbit, "periapsis_distance", np.inf) < getattr(self.orbit, "radius", 0.0)):
            consequence = "the field outside the attractor is continued inwards"
            warn_below(self, self.orbit, self.equatorial_radius, "the equatorial radius", consequence)

    @override
    def energy(self, instant: Instant) -> Scalar:
        radial, inverse = instant.direction(self.orbit), instant.inverse_distance(self.orbit)
        pole = functions.Vector(self.pole) / functions.norm(self.pole)
        height = functions.dot(radial, pole)
        flattening = self.j2 * self.equatorial_radius**2 * (inverse * inverse)
        body, to_body = instant.body, instant.attitude.to_body
        own = body.attracted_moment(to_body(radial)) * (2.5 + 7.5 * (height * height))
        tilted = body.attracted_moment(to_body(pole - radial * (5 * height)))  # no unit vector: times its square
        return inverse * inverse * inverse * flattening * (1.5 * self.orbit.mu) * (own - tilted)
