"""Radiation pressure of sunlight on the facets of a body, and eclipses by occulters."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.forces.facets import Facets
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative, Parametric, Positive

__all__ = [
    "ASTRONOMICAL_UNIT",
    "PRESSURE",
    "SUN_RADIUS",
    "Occulter",
    "RadiationPressure",
    "Sunlight",
    "visible_fraction",
]

PRESSURE = 1361.0 / 299_792_458.0
"""N/m2 at an astronomical unit: the nominal solar irradiance (IAU 2015, Resolution B3) over the speed of light."""

ASTRONOMICAL_UNIT, SUN_RADIUS = 149_597_870_700.0, 6.957e8
"""Metres (IAU 2012, Resolution B2; 2015, Resolution B3)."""

SMOOTHED_PART = 1e-9
"""Part of the smaller disc within which the overlap of a contact is made smooth. The area begins as a power 3/2, whose
second derivative is infinite, so that a step that starts at the contact would have no length."""


class Occulter(Parametric):
    """Sphere that can eclipse the Sun as seen from the body.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body relative to the centre of the sphere. Other forces can use the same orbit.
    radius : float
        Radius of the sphere, in the unit of length of the orbit; positive. A periapsis below it causes a warning.

    Raises
    ------
    ValueError
        If the radius is not positive.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(3.986004418e14, semimajor_axis=7e6, eccentricity=0.0)
    >>> float(pt.forces.Occulter(orbit, radius=6.378137e6).radius)
    6378137.0
    """

    orbit: Orbit
    radius: Positive

    def __post_init__(self) -> None:
        super().__post_init__()
        warn_below(self, self.orbit, self.radius, "the surface", "inside the sphere nothing is seen")

    @of_scalars
    def covers(self, instant: Instant, target: Orbit) -> Any:
        """Return the condition that this sphere covers the centre of a farther attractor as seen from the body."""
        angle = functions.angle_between(instant.direction(self.orbit), instant.direction(target))
        sine = functions.minimum(self.radius * instant.inverse_distance(self.orbit), 1.0)
        return functions.less(angle, functions.asin(sine))

    @of_scalars
    def sunlight(self, instant: Instant, sun: Orbit, sun_radius: Scalar) -> Scalar:
        """Return the fraction of the Sun's disc that this sphere leaves visible, from 0 in the umbra to 1.

        Both bodies are plane discs with the angular radii a and b, whose centres are separated by the angle c
        (Montenbruck and Gill 2000, Satellite Orbits, Sec. 3.4.2). The overlap is the sum of two circular segments, each
        with half the angle at its centre, which avoids cancellation where the discs touch.
        """
        here, there = instant.direction(self.orbit), instant.direction(sun)
        sine_a, sine_b = sun_radius * instant.inverse_distance(sun), self.radius * instant.inverse_distance(self.orbit)
        cosines = functions.sqrt((1 - sine_a * sine_a) * (1 - sine_b * sine_b))
        aligned = functions.dot(here, there)
        touches = functions.less(cosines - sine_a * sine_b, aligned)
        covers = functions.less(cosines + sine_a * sine_b, aligned)

        def where_partial(value: Scalar, other: Scalar) -> Scalar:
            return functions.where(touches, functions.where(covers, other, value), other)

        across = functions.cross(here, there)
        sine = functions.sqrt(where_partial(functions.dot(across, across), 1.0))
        a, b, c = functions.asin(sine_a), functions.asin(sine_b), functions.atan2(sine, aligned)
        product, smooth = (a + b + c) * (a + b - c) * (c + a - b) * (c + b - a), 8 * SMOOTHED_PART * (a * b) * (a * b)
        height = functions.sqrt(where_partial(product + smooth * (smooth / (product + smooth)), 1.0))
        of_sun, of_sphere = (functions.atan2(height, c * c + x) for x in (a * a - b * b, b * b - a * a))
        ratio = (b / a) * (b / a)
        overlap = functions.sine_defect(2 * of_sun) + ratio * functions.sine_defect(2 * of_sphere)
        deepest = functions.where(functions.less(sine_a, sine_b), 0.0, 1 - ratio)
        partial = 1 - overlap / (2 * functions.pi)
        return functions.where(touches, functions.where(covers, deepest, partial), 1.0)


def visible_fraction(instant: Instant, sun: Orbit, occulters: Iterable[Occulter], sun_radius: Scalar) -> Scalar:
    """Return the fraction of the Sun's disc that occulters leave visible, from 0 to 1."""
    seen: Scalar = 1.0
    for occulter in occulters:
        seen = seen * occulter.sunlight(instant, sun, sun_radius)
    return seen


class Sunlight(Torque):
    """Torque of sunlight from one direction, behind occulters.

    Parameters
    ----------
    sun : Orbit
        Orbit of the body relative to the Sun.
    occulters : sequence of Occulter
        Spheres between the body and the Sun, nearer than the Sun.
    pressure : float
        Pressure on an absorbing surface at `distance`. Default: 4.54e-6 N/m2, which is 1361 W/m2 over the speed of
        light.
    distance : float
        Distance from the Sun at which `pressure` applies. Default: the astronomical unit in metres; other units of
        length require another value.
    sun_radius : float
        Radius of the Sun, in the unit of `distance`. Default: 6.957e8 metres.
    """

    if TYPE_CHECKING:

        @property
        def sun(self) -> Orbit:
            """Orbit of the body relative to the Sun."""

        @property
        def occulters(self) -> tuple[Occulter, ...]:
            """Spheres nearer than the Sun."""

        @property
        def pressure(self) -> Any:
            """Radiation pressure on an absorbing surface at the reference distance."""

        @property
        def distance(self) -> Any:
            """Reference distance of the pressure."""

        @property
        def sun_radius(self) -> Any:
            """Radius of the Sun, in the unit of the distance."""

    def __post_init__(self) -> None:
        super().__post_init__()
        nearest: Any = getattr(self.sun, "periapsis_distance", np.inf)
        if np.any(nearest < self.sun_radius):
            raise ValueError(
                f"sun_radius must be less than the distance of the Sun, got {np.max(self.sun_radius):g} and "
                f"{np.min(nearest):g}. Give distance and sun_radius in the unit of the orbit."
            )

    @of_scalars
    def sunlight(self, instant: Instant) -> Scalar:
        """Return the visible fraction of the Sun's disc, from 0 to 1."""
        return visible_fraction(instant, self.sun, self.occulters, self.sun_radius)

    @override
    def torque(self, instant: Instant) -> Vector:
        nearness = self.distance * instant.inverse_distance(self.sun)
        pressure = self.pressure * (nearness * nearness) * self.sunlight(instant)
        torque: Vector = self._torque_from(instant.attitude.to_body(-instant.direction(self.sun))) * pressure
        return torque

    @abstractmethod
    def _torque_from(self, towards: Vector) -> Vector:
        """Return the torque of unit pressure from a unit vector, all along the body axes."""


class RadiationPressure(Sunlight):
    """Torque of sunlight on facets.

    F_i = -P A_i c ((1 - s_i) u + 2 (d_i / 3 + s_i c) n_i) acts at the position of facet i, with u towards the Sun, c =
    max(0, n_i . u), and the specular and diffuse fractions s and d. P = pressure (distance / r)^2 times the visible
    fraction of the Sun's disc; the fractions of several occulters are multiplied. Absorbed light is not reradiated with
    a net force. The model ignores shadows between facets, light from the planet, and thermal emission.

    Parameters
    ----------
    facets : Facets
        Areas, normals, positions and reflectivities of the surface.

    Raises
    ------
    ValueError
        If the pressure is negative, a length is not positive, or the body is inside the Sun.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.327e20, position=(-1.496e11, 0, 0))  # m, s; the Sun is towards +x
    >>> plate = pt.forces.Facets([1.0], [(1, 0, 0)], [(0, 0.1, 0)], specular=1.0)
    >>> system = pt.System(pt.Body((1, 1, 1)), pt.forces.RadiationPressure(sun, plate))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(10)
    array([0.000e+00, 0.000e+00, 9.079e-07])
    """

    formula = (
        "N = -(k*sum(areas[i]*c[i]*(cross(positions[i], (1 - specular[i])*e + "
        "2*(diffuse[i]/3 + specular[i]*c[i])*normals[i])), i)); c[i] = max(0, dot(normals[i], e)); e = -u; "
        "k = pressure*(distance/r)**2*f"
    )
    sun: Orbit
    facets: Facets
    occulters: tuple[Occulter, ...] = ()
    pressure: NotNegative = PRESSURE
    distance: Positive = ASTRONOMICAL_UNIT
    sun_radius: Positive = SUN_RADIUS

    @override
    def _torque_from(self, towards: Vector) -> Vector:
        facets = self.facets
        along = [1 - share for share in facets.specular]
        across = [share * (2 / 3) for share in facets.diffuse]
        mirrored = [2 * share for share in facets.specular]
        torque: Vector = facets.torque(towards, along, across, mirrored)
        return torque
