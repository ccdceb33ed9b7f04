"""Illuminated faces of a mesh under a distant light, and their illuminated areas."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.errors import real_numbers, refuse_zero
from poinsot.shapes.mesh import Mesh

__all__ = ["Lighting", "illuminated_areas", "illuminated_faces", "ray_hits"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MAX_PAIRS = 4_000_000
"""Largest number of pairs of faces, or of a face pair and a direction, in one block."""

CONE_MARGIN = 1e-5
"""Widening of the cones around faces, in cosines, because their axes have 24 bits."""

MAX_SHADED = 20_000
"""Largest number of faces of a mesh with shadows, which the search for pairs limits."""

HEIGHT_ROUNDING = 1e-12
"""Rounding error of a height over a face, in radii of the mesh."""


class Lighting:
    """Faces of a mesh under a distant light; positions are relative to the centre of mass."""

    def __init__(self, mesh: Mesh) -> None:
        self.vertices, self.faces = mesh.vertices - mesh.center_of_mass, mesh.faces
        self.corners = self.vertices[self.faces]
        self.areas, self.normals = (
            mesh.face_areas,
            np.nan_to_num(mesh.face_normals),
        )  # a degenerate triangle is never illuminated
        self.centers = mesh.face_centers - mesh.center_of_mass
        self._low = HEIGHT_ROUNDING * mesh.circumscribing_radius

    def illuminated(self, directions: Array, shadows: bool = True) -> Flags:
        """Return True where light from unit vectors (n, 3) reaches the centroids of the faces; shape (n, faces)."""
        facing = directions @ self.normals.T > 0
        if shadows:
            if len(self.areas) > MAX_SHADED:
                rule = f"must have at most {MAX_SHADED} faces where shadows are computed"
                raise ValueError(f"mesh {rule}, got {len(self.areas)}. Take a coarser one, or shadows=False.")
            for face, other in self.hidden():
                self._shade(facing, directions, face, other)
        return facing

    def illuminated_parts(self, direction: Array) -> tuple[Array, Array]:
        """Return the areas of the parts that the light reaches, (faces,), and their centroids, (faces, 3)."""
        areas, centers = np.zeros(len(self.areas)), self.centers.copy()
        facing = np.flatnonzero(self.normals @ direction > 0)
        for face in facing:
            along = _basis(self.normals[face])
            pieces = [(self.corners[face] - self.centers[face]) @ along.T]
            for shadow in self._shadows(face, facing, direction):
                pieces = _without(pieces, shadow @ along.T)
            areas[face], middle = _area_and_center(pieces)
            centers[face] += middle @ along
        return areas, centers

    def hidden(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Yield pairs of faces, of which the second has a corner above the first and looks away from its centroid.

        A ray that leaves the body meets such a face last, wherever else it entered.
        """
        offsets = np.einsum("fi,fi->f", self.normals, self.centers)
        rows = max(1, MAX_PAIRS // (3 * len(self.areas)))
        for start in range(0, len(self.areas), rows):
            part = slice(start, start + rows)
            heights = np.einsum("ai,fki->afk", self.normals[part], self.corners) - offsets[part, None, None]
            above = (heights > self._low).any(axis=2)
            behind = self.centers[part] @ self.normals.T < offsets
            first, second = np.nonzero(above & behind)
            yield first + start, second

    def _shade(self, lit: Flags, directions: Array, face: NDArray[np.int64], other: NDArray[np.int64]) -> None:
        """Set faces whose centroids are hidden to False. Rays that miss a cone around the other face are skipped."""
        rows = max(1, MAX_PAIRS // max(1, len(directions)))
        for start in range(0, len(face), rows):
            one, two = face[start : start + rows], other[start : start + rows]
            seen = self.corners[two] - self.centers[one][:, None]
            axes, cosines = _cones(seen)
            near = directions.astype(np.float32) @ axes.T.astype(np.float32) > (cosines - CONE_MARGIN).astype(
                np.float32
            )
            ray, pair = np.nonzero(near & lit[:, one])
            hit = ray_hits(directions[ray], seen[pair])
            lit[ray[hit], one[pair[hit]]] = False

    def _shadows(self, face: np.signedinteger[Any], facing: NDArray[np.int64], direction: Array) -> Iterator[Array]:
        """Yield the shadows of other faces in the plane of one, from its centroid: convex polygons (n, 3)."""
        normal = self.normals[face]
        for corners in self.corners[facing[facing != face]] - self.centers[face]:
            heights = corners @ normal
            heights[np.abs(heights) <= self._low] = 0.0  # at an edge of both: no corner is cut twice
            if heights.max() > 0:
                over = _upper(corners, heights) if heights.min() < 0 else corners
                yield over - np.outer(over @ normal / (direction @ normal), direction)


@checked
def illuminated_faces(mesh: Mesh, directions: ArrayLike, shadows: bool = True) -> Flags:
    """Return True for each face of a mesh whose centroid receives light from a direction.

    Edges and corners of other faces also block the light.

    Parameters
    ----------
    mesh : Mesh
        Surface with its faces.
    directions : array (..., 3)
        Directions to the light, axes of the shape, of any nonzero length.
    shadows : bool
        True to include shadows of other faces. With False, all faces oriented towards the light are illuminated.

    Returns
    -------
    bool array (..., faces)
        True for each illuminated face.

    Raises
    ------
    ValueError
        If a direction is zero.

    Examples
    --------
    >>> pt.shapes.illuminated_faces(pt.shapes.Mesh.from_box((1, 1, 1), mass=1.0), (0, 0, 1)).sum()
    np.int64(2)
    """
    units = _unit_directions(directions)
    return np.asarray(
        Lighting(mesh).illuminated(units.reshape(-1, 3), shadows).reshape(*units.shape[:-1], len(mesh.faces))
    )


@checked
def illuminated_areas(mesh: Mesh, directions: ArrayLike) -> Array:
    """Return the exact areas of the parts of faces that a distant light reaches.

    The function subtracts the shadows of all other faces one by one. The time grows as the square of the number of
    faces; a mesh of several hundred faces takes a second for each direction.

    Parameters
    ----------
    mesh : Mesh
        Surface with its faces.
    directions : array (..., 3)
        Directions to the light, axes of the shape, of any nonzero length.

    Returns
    -------
    array (..., faces)
        Illuminated area of each face.

    Raises
    ------
    ValueError
        If a direction is zero.

    Examples
    --------
    >>> pt.shapes.illuminated_areas(pt.shapes.Mesh.from_box((1, 1, 1), mass=1.0), (0, 3, 4)).sum()
    np.float64(2.0)
    """
    units, light = _unit_directions(directions), Lighting(mesh)
    areas = [light.illuminated_parts(direction)[0] for direction in units.reshape(-1, 3)]
    return np.reshape(areas, (*units.shape[:-1], len(mesh.faces)))


def _unit_directions(directions: ArrayLike) -> Array:
    """Return directions of any length as unit vectors (..., 3)."""
    array = real_numbers("directions", directions)
    if array.shape[-1:] != (3,):
        raise ValueError(f"directions must have shape (..., 3), got shape {array.shape}.")
    refuse_zero("directions", array)
    return _unit(array)


def ray_hits(directions: Array, corners: Array) -> Flags:
    """Return True where rays (n, 3) from the origin meet triangles (n, 3, 3), from either side.

    The three volumes of a ray with the edges have the sign of the volume of the triangle (Moeller and Trumbore 1997, J.
    Graphics Tools 2, 21). A volume of zero, where a ray meets an edge, counts as either sign: the volume at an edge of
    two triangles is the same for both, so that no ray passes between them.
    """
    turns = np.cross(corners, np.roll(corners, -1, axis=1))
    volumes = np.einsum("nki,ni->nk", turns, directions)
    volumes *= np.sign(np.einsum("ni,ni->n", turns[:, 0], corners[:, 2]))[:, None]
    return np.asarray((volumes >= 0).all(axis=1) & (volumes > 0).any(axis=1))


def _cones(corners: Array) -> tuple[Array, Array]:
    """Return the axes (n, 3) and cosines (n,) of cones from the origin around triangles (n, 3, 3)."""
    units = _unit(corners)
    axes = _unit(units.sum(axis=1))
    cosines = np.einsum("nki,ni->nk", units, axes).min(axis=1)
    return axes, np.where(cosines > 0, cosines, -1.0)  # a wider cone is not convex


def _unit(vectors: Array) -> Array:
    """Return vectors over their lengths, zero where the length is."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))


def _basis(normal: Array) -> Array:
    """Return two unit vectors in the plane of a normal, (2, 3), anticlockwise about it."""
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def _upper(polygon: Array, heights: Array) -> Array:
    """Return the part of a convex polygon where heights at its corners, which are linear between them, are positive."""
    after, heights_after = np.roll(polygon, -1, axis=0), np.roll(heights, -1)
    corners: list[Array] = []
    for here, there, a, b in zip(polygon, after, heights, heights_after, strict=True):
        if a >= 0:
            corners.append(here)
        if a * b < 0:
            corners.append(here + (there - here) * (a / (a - b)))
    return np.reshape(corners, (-1, polygon.shape[1]))


def _without(pieces: list[Array], cut: Array) -> list[Array]:
    """Return convex polygons without a convex polygon, all anticlockwise."""
    edges = np.roll(cut, -1, axis=0) - cut
    left: list[Array] = []
    for piece in pieces:
        if any((_sides(piece, start, edge) <= 0).all() for start, edge in zip(cut, edges, strict=True)):
            left.append(piece)
            continue
        rest = piece
        for start, edge in zip(cut, edges, strict=True):
            side = _sides(rest, start, edge)
            if (side < 0).any():
                left.append(_upper(rest, -side))
                rest = _upper(rest, side)
    return left


def _sides(polygon: Array, start: Array, edge: Array) -> Array:
    """Return how far the corners of a polygon are to the left of an edge, times its length."""
    away = polygon - start
    return np.asarray(edge[0] * away[:, 1] - edge[1] * away[:, 0])


def _area_and_center(pieces: list[Array]) -> tuple[float, Array]:
    """Return the area of polygons together, and its centroid; the origin of no area."""
    area, moment = 0.0, np.zeros(2)
    for piece in pieces:
        after = np.roll(piece, -1, axis=0)
        turns = (piece[:, 0] * after[:, 1] - piece[:, 1] * after[:, 0]) / 2
        area += turns.sum()
        moment += turns @ (piece + after) / 3
    return area, moment / area if area > 0 else np.zeros(2)
