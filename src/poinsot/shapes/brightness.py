"""Brightness of bodies: the light that a surface reflects from the Sun towards an observer.

B is the sum of A S over the facets, or the integral of S over a smooth surface, with the areas A and the scattering
law S. B is an area: the brightness relative to a white Lambert plate of unit area that is illuminated and viewed
perpendicularly.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from itertools import chain
from typing import Literal, NamedTuple

import numpy as np

from poinsot import functions
from poinsot.functions import Scalar, Vector, cross, dot, norm
from poinsot.shapes.ellipsoid_light import LightOfEllipsoid
from poinsot.shapes.law_program import LawFormula, law_formula
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.reflected_light import LightOfPlates, LightOfShadedMesh, Plates, ReflectedLight
from poinsot.shapes.scattering import LommelSeeliger, Reflection, ScatteringLaw
from poinsot.shapes.solids import Ellipsoid
from poinsot.taylor.graph import computed, ruled

__all__ = ["Companion", "Shadows", "brightness_of"]

Shadows = Literal[False, "centroids", "exact"]
"""Shadows of the faces of a mesh: none, faces whose centroid is clear, or exact clear areas."""

MAX_LIGHTS = 64
"""Largest number of pairs of a shape and a law whose surfaces are stored."""

SMALL = 1e-100
"""Lower limit of denominators that are zero at single directions."""

DARK = 1e-24
"""Square of the sum of both directions, mapped to the unit sphere, below which the Sun is behind the body."""

NO_STRETCH = (1.0, 1.0, 1.0)


class Companion(NamedTuple):
    """Second mesh and its place, along the axes of the first mesh.

    Attributes
    ----------
    mesh : Mesh
    position : three scalars
        Centre of mass of the second mesh from the centre of mass of the first mesh.
    matrix : three rows of three scalars
        Rotation matrix from the axes of the second mesh to the axes of the first mesh.
    """

    mesh: Mesh
    position: Sequence[Scalar]
    matrix: Sequence[Sequence[Scalar]]


def brightness_of(
    shape: Mesh | Ellipsoid | Plates,
    law: ScatteringLaw,
    to_sun: Sequence[Scalar],
    to_observer: Sequence[Scalar],
    stretch: Sequence[Scalar] = NO_STRETCH,
    shadows: Shadows = False,
    companion: Companion | None = None,
) -> Scalar:
    """Return the brightness B of a body, an area.

    Parameters
    ----------
    shape : Mesh, Ellipsoid or plates
        Surface along the body axes.
    law : ScatteringLaw
        Law of scattering; its numbers are scalars of any kind.
    to_sun, to_observer : three scalars
        Directions from the body along the body axes, of any length.
    stretch : three scalars
        Factors by which the shape is stretched along its axes, x -> stretch x. A companion is stretched alike.
    shadows : False, "centroids" or "exact"
        Shadows of the faces of a mesh on each other. Ellipsoids are convex, and plates do not shadow each other.
    companion : Companion, optional
        Second mesh, which shadows and hides faces of a mesh. Without shadows it has no effect.

    Returns
    -------
    scalar
        Brightness, of the kind of the arguments: a float, an array, or a node of a graph with exact derivatives.
    """
    sun, observer = (Vector(direction) / norm(direction) for direction in (to_sun, to_observer))
    phase, numbers = phase_angle(sun, observer), law.numbers
    if isinstance(shape, Ellipsoid) and type(law) is LommelSeeliger:
        factor = law.factor(Reflection(1.0, 1.0, phase))
        return factor * _lommel_seeliger_integral(shape, sun, observer, stretch)
    formula = law_formula(law)
    inner = [numbers[k] for k in formula.rest_numbers]
    own_phase = phase if formula.uses_phase else 0.0
    light = _light(shape, formula, shadows, companion and companion.mesh)
    place = (*companion.position, *chain.from_iterable(companion.matrix)) if companion and light.placed else ()
    total = computed(light, (*sun, *observer, *place, *stretch, own_phase, *inner))
    brightness: Scalar = formula.factor(phase, numbers) * total
    return brightness


@functools.lru_cache(maxsize=MAX_LIGHTS)
def _light(
    shape: Mesh | Ellipsoid | Plates, formula: LawFormula, shadows: Shadows, other: Mesh | None
) -> ReflectedLight:
    if isinstance(shape, Ellipsoid):
        return LightOfEllipsoid(shape, formula)
    if isinstance(shape, Mesh) and shadows:
        return LightOfShadedMesh(shape, formula, shadows == "exact", other)
    return LightOfPlates(shape, formula)


def phase_angle(sun: Vector, observer: Vector) -> Scalar:
    """Return the angle between two unit vectors, exact near 0 and pi; its derivatives are 0 where it is 0 or pi."""
    difference = observer - sun
    apart, together = norm(difference), norm(sun + observer)
    phase = 2 * functions.atan2(apart, together)
    sine = functions.maximum(0.5 * apart * together, SMALL)

    def slope(k: int) -> Scalar:
        """Return minus the other vector perpendicular to the own one, divided by the sine."""
        own, sign = (sun, 1) if k < 3 else (observer, -1)
        across: Scalar = sign * difference[k % 3] + 0.5 * apart * apart * own[k % 3]
        return -across / sine

    return ruled(phase, (*sun, *observer), slope)


def _lommel_seeliger_integral(shape: Ellipsoid, sun: Vector, observer: Vector, stretch: Sequence[Scalar]) -> Scalar:
    """Return the integral of mu0 mu / (mu0 + mu) over the lit and seen part of an ellipsoid.

    With s' and e', the images of the directions under the map of the ellipsoid to the unit sphere, T = s' + e', and the
    angles lambda and beta of s' and e' from T, it is pi/2 det D |s'| |e'| / |T| (cos lambda + cos beta - sin lambda
    sin beta log(cot(lambda/2) cot(beta/2))) (K. Muinonen and K. Lumme, Astron. Astrophys. 584, A23 (2015)).
    """
    s, e = (on_unit_sphere(shape, direction, stretch) for direction in (sun, observer))
    total, perpendicular = s + e, cross(s, e)
    volume = stretch[0] * stretch[1] * stretch[2] * float(np.prod(shape.semiaxes))
    square, length_s, length_e = dot(total, total), norm(s), norm(e)
    is_dark = functions.less(square, DARK * length_s * length_s)
    length = functions.sqrt(functions.where(is_dark, 1.0, square))
    cos_s, cos_e = dot(s, total) / (length_s * length), dot(e, total) / (length_e * length)
    sines = dot(perpendicular, perpendicular) / (length_s * length_e * length * length)
    cotangents = (1 + cos_s) * (1 + cos_e) / functions.maximum(sines, SMALL)
    bracket = cos_s + cos_e - sines * functions.log(cotangents)
    return functions.where(is_dark, 0.0, 0.5 * functions.pi * volume * length_s * length_e / length * bracket)


def on_unit_sphere(shape: Ellipsoid, direction: Vector, stretch: Sequence[Scalar]) -> Vector:
    """Return a direction mapped by the linear map that takes the stretched ellipsoid to the unit sphere."""
    unstretched = [x / factor for x, factor in zip(direction, stretch, strict=True)]
    return Vector(dot(row, unstretched) for row in shape.to_unit_sphere.tolist())
