"""Light curves: the brightness of a rotating body in the light of the Sun."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Annotated, Any, ClassVar, TypeAlias, cast

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import level_of_user, refuse_nonpositive
from poinsot.forces.facets import Facets
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.light_time import METRES
from poinsot.mechanics.observable import Observable
from poinsot.printable import described, quoted
from poinsot.quantities import Array, Real, Rule
from poinsot.records.parameters import NotNegative, Positive, Structural
from poinsot.records.units import DerivedUnits, length_of_inertia
from poinsot.shapes.brightness import Companion, Shadows, brightness_of
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.scattering import ScatteringLaw
from poinsot.shapes.solids import Ellipsoid

__all__ = ["LightCurve"]

KINDS = {"flux": "1", "magnitude": "mag", "relative": "1"}
"""Kinds of readings, with their units."""

SHADOWS: dict[str, Shadows] = {"exact": "exact", "centroids": "centroids", "none": False}
"""Shadows of a mesh: of exact areas, of whole faces by their centroids, or none."""

ASTRONOMICAL_UNIT = METRES["au"] / METRES["km"]
"""Astronomical unit in km, the unit of length of most orbits."""

SUN_MAGNITUDE = -26.76
"""Apparent magnitude of the Sun in the V band at 1 au."""

UNIT_TOLERANCE = 1e-3
"""Largest relative error of an astronomical unit in the unit of length of a system."""

Outline: TypeAlias = Mesh | Ellipsoid | Facets


class Surfaces(Structural):
    """Surfaces of one body or of two bodies that reflect light, along the body axes of each.

    Attributes
    ----------
    each : tuple of Mesh, Ellipsoid or Facets
        Shape of the body, or shapes of primary and secondary.
    areas : tuple of float
        Area of the surface of each: a quarter of it is the mean projected area of a convex body.
    """

    each: tuple[Outline, ...]
    areas: tuple[float, ...]

    def __init__(self, shape: Outline | Sequence[Outline] | Surfaces) -> None:
        given: Any = shape.each if isinstance(shape, Surfaces) else shape
        each: tuple[Any, ...] = tuple(given) if isinstance(given, list | tuple) else (given,)
        if not 1 <= len(each) <= 2:
            raise ValueError(f"shape must be one shape, or two for two bodies, got {len(each)}.")
        for one in each:
            if not isinstance(one, Mesh | Ellipsoid | Facets):
                raise TypeError(f"shape must be a Mesh, an Ellipsoid or Facets, got {described(one)}.")
            if isinstance(one, Facets) and one.member_axis:
                raise ValueError(f"shape must be the same for all members, got facets of {one.member_axis[0]} members.")
        self.each = each
        self.areas = tuple(map(_surface, each))

    def __repr__(self) -> str:
        return repr(self.each[0]) if len(self.each) == 1 else repr(self.each)


def _surface(shape: Outline) -> float:
    if isinstance(shape, Ellipsoid):
        return _area_of_ellipsoid(np.asarray(shape.semiaxes))
    return float(np.sum(shape.face_areas if isinstance(shape, Mesh) else shape.areas))


def _radius(shape: Outline) -> float:
    """Return the radius of a sphere about the origin of the body axes that contains a surface."""
    if isinstance(shape, Ellipsoid):
        return float(np.max(shape.semiaxes))
    points = shape.vertices if isinstance(shape, Mesh) else shape.positions
    return float(np.max(np.linalg.norm(points, axis=-1), initial=0.0))


def _area_of_ellipsoid(semiaxes: Array) -> float:
    """Return the area of an ellipsoid: the mean of 4 pi |det D D^-1 n| over the directions n, by quadrature."""
    cosines, weights = np.polynomial.legendre.leggauss(64)
    angles = (np.arange(128) + 0.5) * (np.pi / 64)
    sines = np.sqrt(1 - cosines**2)[:, None]
    n = np.stack(
        [sines * np.cos(angles), sines * np.sin(angles), np.broadcast_to(cosines[:, None], (64, 128))], axis=-1
    )
    lengths = np.linalg.norm(np.prod(semiaxes) * n / semiaxes, axis=-1)
    return float(2 * np.pi * np.sum(weights * lengths.mean(axis=1)))


def _refuse_kind(name: str, value: Any, _: str) -> None:
    if value not in KINDS:
        raise ValueError(f"{name} must be {', '.join(map(quoted, KINDS))}, got {quoted(value)}.")


def _refuse_shadows(name: str, value: Any, _: str) -> None:
    if value not in SHADOWS:
        raise ValueError(f"{name} must be {', '.join(map(quoted, SHADOWS))} or False, got {quoted(value)}.")


class LightCurve(Observable):
    """Brightness of a body, or of two bodies, in the light of the Sun, for a distant observer.

    With the brightness B of the body (an area, relative to a white Lambert plate), its distances r from the Sun and d
    from the observer and the astronomical unit au, the flux relative to the flux of the Sun at 1 au and the magnitude
    are

    F = B / pi (au / (r d))^2,    m = sun_magnitude - 2.5 log10(F).

    Parameters
    ----------
    shape : Mesh, Ellipsoid or Facets, or two of these
        Surface along the body axes; for two bodies the surfaces of primary and secondary.
    law : ScatteringLaw
        Law of scattering of the surface.
    sun, observer : Orbit
        Orbits of the body relative to the Sun and to the observer, space axes. `FixedPosition` is a fixed direction.
    secondary_law : tuple of ScatteringLaw
        Law of the secondary of two bodies. Default: `law`.
    kind : {"flux", "magnitude", "relative"}
        Kind of the readings: F, m, or the brightness B divided by a quarter of the area of the surface, which is the
        mean projected area of a convex body; it does not depend on distances.
    stretch : array (3,)
        Factors by which the shape is stretched along the body axes. The moments of inertia do not change.
    shadows : {"exact", "centroids", "none"} or False
        Shadows and occultations of faces of a mesh by other faces and by the mesh of the other body: by exact areas, or
        of whole faces by their centroids, which has no partial derivatives. False or "none" for none. Facets and
        ellipsoids neither shadow nor hide another body.
    light_time : bool
        True to show the body as it was when the light left it. False for times that are corrected already.
    sun_magnitude : float
        Apparent magnitude of the Sun at 1 au.
    astronomical_unit : float
        Astronomical unit in the unit of length of shape and orbits. Default: in km.
    noise : float
        Standard deviation of a reading.

    Raises
    ------
    TypeError, ValueError
        If the shape or the kind is unknown, a factor of the stretch is not positive, or one shape has a secondary law.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.0, position=(1.5e8, 0, 0))
    >>> earth = pt.orbits.FixedPosition(1.0, position=(3e7, 1e7, 0))
    >>> ball = pt.shapes.Ellipsoid((1, 1, 1), density=2e12)
    >>> law = pt.observables.LommelSeeliger(albedo=0.2)
    >>> curve = pt.observables.LightCurve(ball, law, sun, earth, kind="magnitude", light_time=False)
    >>> body = pt.Body.from_shape(ball)
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1e-4))
    >>> motion = pt.propagate(pt.System(body), start, [0.0, 3600.0])
    >>> pt.observe(motion, curve).values.round(3)
    array([14.824, 14.824])
    """

    shape: Annotated[Outline | Sequence[Outline], Surfaces]
    law: ScatteringLaw
    sun: Orbit
    observer: Orbit
    _: KW_ONLY
    secondary_law: tuple[ScatteringLaw, ...] = ()
    kind: Annotated[str, Rule(_refuse_kind)] = "flux"
    stretch: Annotated[Any, (3,), Rule(refuse_nonpositive)] = (1.0, 1.0, 1.0)
    shadows: Annotated[str | bool, str, Rule(_refuse_shadows)] = "exact"
    light_time: bool = True
    sun_magnitude: Real = SUN_MAGNITUDE
    astronomical_unit: Positive = ASTRONOMICAL_UNIT
    noise: NotNegative = 0.0

    not_finite: ClassVar[str] = "zero flux"

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", Surfaces(self.shape))
        if isinstance(self.secondary_law, ScatteringLaw):
            object.__setattr__(self, "secondary_law", (self.secondary_law,))
        if isinstance(self.shadows, bool):
            if self.shadows:
                _refuse_shadows("shadows", self.shadows, "")
            object.__setattr__(self, "shadows", "none")
        super().__post_init__()
        if len(self.secondary_law) >= len(self._surfaces.each) and self.secondary_law:
            raise ValueError(
                "secondary_law must be one law, for the second of two shapes, got the numbers of laws and shapes "
                f"{len(self.secondary_law)} and {len(self._surfaces.each)}. Leave it out for one shape."
            )
        each = self._surfaces.each
        if len(each) > 1 and self.shadows != "none" and not all(isinstance(one, Mesh) for one in each):
            kinds = " and ".join(type(one).__name__ for one in each)
            warnings.warn(
                f"the shapes of two bodies should be meshes, got {kinds}. "
                "The light curve has no eclipses. Take Ellipsoid.mesh(faces), or shadows=False.",
                stacklevel=level_of_user(),
            )

    @property
    def _surfaces(self) -> Surfaces:
        return cast("Surfaces", self.shape)

    @property
    @override
    def has_unknown_factor(self) -> bool:
        return self.kind == "relative"

    @property
    @override
    def light_path(self) -> Orbit | None:
        return self.observer if self.light_time else None

    @override
    def check_times(self, times: Array) -> None:
        radius = np.max(self.stretch, axis=-1) * max(map(_radius, self._surfaces.each))
        limit = radius[..., None] if np.ndim(radius) else radius
        for name, orbit in (("sun", self.sun), ("observer", self.observer)):
            distances = np.asarray(functions.norm(orbit.position_at(times)), dtype=float)
            inside = np.broadcast_to(
                distances < limit, np.broadcast_shapes(distances.shape, np.shape(limit), times.shape)
            )
            if self.kind != "relative" and inside.any():
                place = np.unravel_index(np.argmax(inside), inside.shape)
                raise ValueError(
                    f"{name} must be outside of the body, got the distance "
                    f"{np.broadcast_to(distances, inside.shape)[place]:.6g} at the time {times[place[-1]]:.10g}, below "
                    f'the radius {np.max(radius):.6g}. A direction alone needs kind="relative".'
                )

    @override
    def unit(self, units: DerivedUnits) -> str:
        known = units.length if units.length in METRES else length_of_inertia(units.inertia, METRES)
        expected, given = METRES["au"] / METRES.get(known, np.nan), np.ravel(self.astronomical_unit)
        if self.kind != "relative" and np.any(np.abs(given / expected - 1) > UNIT_TOLERANCE):
            raise ValueError(
                f"astronomical_unit must be {expected:.10g} for lengths in {known}, got {quoted(float(given[0]))}."
            )
        return KINDS[self.kind]

    @override
    def reading(self, instant: Any) -> Scalar:
        shapes, laws = self._surfaces.each, (self.law, *(self.secondary_law or (self.law,)))
        bodies = [instant.primary, instant.secondary] if len(shapes) > 1 else [instant]
        companions: list[Companion | None] = [None]
        if len(bodies) > 1:
            apart = instant.separation
            places = (*bodies, shapes[1], apart), (*bodies[::-1], shapes[0], -1 * apart)
            companions = [_companion(*each) for each in places]
        light = [self._light(*each) for each in zip(bodies, shapes, laws[: len(shapes)], companions, strict=True)]
        total: Scalar = sum(light[1:], start=light[0])
        if self.kind == "magnitude":
            magnitude: Scalar = self.sun_magnitude - 2.5 / np.log(10.0) * functions.log(total)
            return magnitude
        return total

    def _light(self, instant: Any, shape: Outline, law: ScatteringLaw, companion: Companion | None) -> Scalar:
        """Return the flux of one body, or its brightness over the mean projected area of all."""
        to_sun, to_observer = (
            instant.attitude.to_body(-Vector(instant.position(orbit))) for orbit in (self.sun, self.observer)
        )
        shadows = SHADOWS[str(self.shadows)]
        brightness = brightness_of(shape, law, to_sun, to_observer, self.stretch, shadows, companion)
        if self.kind == "relative":
            return brightness * (4 / sum(self._surfaces.areas))
        reach = self.astronomical_unit * instant.inverse_distance(self.sun) * instant.inverse_distance(self.observer)
        flux: Scalar = brightness / functions.pi * reach * reach
        return flux


def _companion(own: Any, other: Any, shape: Outline, position: Vector) -> Companion | None:
    """Return the second mesh along the axes of a body, for its position from the body in space axes."""
    if not isinstance(shape, Mesh):
        return None
    columns = [own.attitude.to_body(other.attitude.to_space(Vector(axis))) for axis in np.eye(3).tolist()]
    rows = [[column[k] for column in columns] for k in range(3)]
    return Companion(shape, own.attitude.to_body(position), rows)
