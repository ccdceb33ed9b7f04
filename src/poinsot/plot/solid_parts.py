"""Surfaces of a drawn body: the parts of its shape, or the homogeneous ellipsoid with its moments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from poinsot.analysis.polhodes import principal
from poinsot.forces.facets import Facets
from poinsot.mechanics.body import Body
from poinsot.printable import described
from poinsot.quantities import Array
from poinsot.shapes.assembly import Assembly
from poinsot.shapes.mascons import Mascons
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.shape import Shape
from poinsot.shapes.solids import Cylinder, Ellipsoid

__all__ = ["extents", "facet_corners", "gyration_radii", "parts_of", "surfaces", "triangles", "triangles_of"]

AROUND = np.linspace(0, 2 * np.pi, 121)
UP = np.linspace(0, np.pi, 61)[:, None]
SPHERE = np.stack([np.sin(UP) * np.cos(AROUND), np.sin(UP) * np.sin(AROUND), np.cos(UP) + 0 * AROUND], axis=-1)
TUBE = np.stack([np.cos(AROUND), np.sin(AROUND), 1 + 0 * AROUND], axis=-1)

MAX_BALLS = 300
"""Largest number of mass points drawn as balls, the heaviest ones."""


def parts_of(shape: Shape | None) -> list[Any] | None:
    """Return the parts of a shape; None without a shape, or if a part is of another kind."""
    parts = [] if shape is None else list(_parts(shape))
    drawable = all(isinstance(part, Cylinder | Ellipsoid | Mascons | Mesh) for part in parts)
    return parts if parts and drawable else None


def _parts(shape: Shape) -> Iterator[Shape]:
    if isinstance(shape, Assembly):
        for part in shape.parts:
            yield from _parts(part)
    else:
        yield shape


def gyration_radii(body: Body) -> tuple[Array, Array]:
    """Return the root of twice the mass times the mean squares along the principal axes, and these axes as columns.

    The sides of the homogeneous ellipsoid and box with the moments of the body are proportional to the radii.
    """
    moments, axes = principal(body)
    return np.sqrt(np.maximum(np.sum(moments) - 2 * moments, 0)), axes


def extents(body: Body, mass: float) -> Array:
    """Return the semiaxes of the homogeneous ellipsoid of a mass with the moments of the body; shape (3,)."""
    return np.asarray(np.sqrt(2.5 / mass) * gyration_radii(body)[0])


def surfaces(body: Body, mass: float) -> list[Array]:
    """Return points on each part of a body from its centre of mass, along the body axes; each (n, 3)."""
    parts = parts_of(body.shape)
    if parts is None:
        return [(SPHERE * extents(body, mass)).reshape(-1, 3) @ gyration_radii(body)[1].T]
    points = (part.positions if isinstance(part, Mascons) else _triangles(part, 1, 1).reshape(-1, 3) for part in parts)
    return [each - body.shape.center_of_mass for each in points]


def triangles(body: Body, mass: float = 1.0) -> Array:
    """Return the surface of a body from its centre of mass, along its axes, as triangles outwards; (m, 3, 3)."""
    parts = parts_of(body.shape)
    if parts is None:
        return np.asarray(_grid(SPHERE[::3, ::5] * extents(body, mass)) @ gyration_radii(body)[1].T)
    return np.asarray(np.concatenate([_triangles(part) for part in parts]) - body.shape.center_of_mass)


def triangles_of(shape: Shape | Facets) -> Array:
    """Return the surface of a shape from its centre of mass, or facets as squares, as triangles outwards; (m, 3, 3)."""
    if isinstance(shape, Facets):
        corners = facet_corners(shape)
        return np.concatenate([corners[:, :3], corners[:, [2, 3, 0]]])
    parts = parts_of(shape)
    if parts is None:
        raise ValueError(f"shape must be of solids or facets to be drawn, got {described(shape)}.")
    return np.asarray(np.concatenate([_triangles(part, 1, 1) for part in parts]) - shape.center_of_mass)


def facet_corners(facets: Facets) -> Array:
    """Return the corners of facets, drawn as squares or as the sides of a box, anticlockwise; shape (n, 4, 3)."""
    sides = _sides(facets)
    first = np.cross(facets.normals, np.eye(3)[np.argmin(np.abs(facets.normals), axis=-1)])
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    across = np.stack([first, np.cross(facets.normals, first)], axis=1)
    reach = np.where(np.isnan(sides[:, :1]), np.sqrt(facets.areas)[:, None, None], np.abs(across) @ sides)
    half = 0.5 * reach * across
    return np.stack([facets.positions + i * half[:, 0] + j * half[:, 1] for i, j in SQUARE], axis=1)


SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _sides(facets: Facets) -> Array:
    """Return the lengths of the sides of a box that facets belong to, as a column; NaN for other facets."""
    sides = np.full((facets.count, 3, 1), np.nan)
    normals, areas = facets.normals[:6], np.asarray(facets.areas[:6])
    box = np.repeat(np.eye(3), 2, axis=0) * np.array([1, -1] * 3)[:, None]
    if np.array_equal(normals, box) and np.array_equal(areas[::2], areas[1::2]):
        lengths = np.sqrt(np.prod(areas[::2])) / areas[::2]
        between = np.diag(facets.positions[:6:2] - facets.positions[1:6:2])
        if np.allclose(lengths, between, rtol=1e-6):
            sides[:6] = lengths[:, None]
    return sides


def _triangles(part: Any, down: int = 3, around: int = 5) -> Array:
    """Return the triangles of a part, with every so many of the points of a sphere and of a circle; (m, 3, 3)."""
    if isinstance(part, Mesh):
        return np.asarray(part.vertices[part.faces])
    if isinstance(part, Mascons):
        heaviest = np.argsort(part.masses)[-MAX_BALLS:]
        radii = 0.6 * part.circumscribing_radius * np.cbrt(part.masses[heaviest] / np.sum(part.masses))
        ball = _grid(SPHERE[::10, ::15])
        return np.concatenate([place + r * ball for place, r in zip(part.positions[heaviest], radii, strict=True)])
    if isinstance(part, Ellipsoid):
        own = _grid(SPHERE[::down, ::around] * part.semiaxes)
    else:
        rim = TUBE[::around] * (part.radius, part.radius, 0)
        ends = np.array([1, 1, -1, -1])[:, None, None] * (0, 0, part.height / 2)
        own = _grid(np.stack([0 * rim, rim, rim, 0 * rim]) + ends)
    return np.asarray(part.center_of_mass + own @ part._axes.T)


def _grid(points: Array) -> Array:
    """Return the triangles of a grid of points, rows from above down, columns about the third axis; (m, 3, 3)."""
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(each, axis=-2).reshape(-1, 3, 3) for each in ((a, b, c), (a, c, d))])
