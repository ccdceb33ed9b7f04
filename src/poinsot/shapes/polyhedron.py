"""Integrals over a homogeneous polyhedron of density 1, from its triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.shapes import cubature

__all__ = ["Triangles", "gravity", "multipoles", "second_moments", "volume_and_center", "winding_numbers"]

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


def volume_and_center(vertices: Array, faces: Faces) -> tuple[float, Array]:
    """Return the volume and its centre, from cones with their apex amid the faces."""
    apex = np.mean([vertices[faces].min(axis=(0, 1)), vertices[faces].max(axis=(0, 1))], axis=0)
    corners = (vertices - apex)[faces]
    cones = _cones(corners)
    volume = float(cones.sum())
    return volume, apex + (cones @ corners.sum(axis=1)) / (4 * volume) if volume else apex


def second_moments(vertices: Array, faces: Faces) -> Array:
    """Return the integral of x x^T over the volume, shape (3, 3)."""
    corners = vertices[faces]
    cones, middle = _cones(corners), corners.sum(axis=1)
    return np.asarray((np.einsum("f,fki,fkj->ij", cones, corners, corners) + (cones * middle.T) @ middle) / 20)


def multipoles(vertices: Array, faces: Faces, degree: int) -> NDArray[np.complex128]:
    """Return the integrals of the solid harmonics Z_nm over the volume, rows n, columns m <= n.

    Over a cone from the origin a homogeneous polynomial of degree n has 3 / (n + 3) times its mean over the base, and
    that is a cubature over the triangle.
    """
    weights, places = cubature.triangle(degree)
    total = np.zeros((degree + 1, degree + 1), dtype=complex)
    rows = max(1, cubature.MAX_POINTS // len(weights))
    for start in range(0, len(faces), rows):
        corners = vertices[faces[start : start + rows]]
        points = np.einsum("qk,fki->fqi", places, corners).reshape(-1, 3)
        total += cubature.multipoles(np.outer(_cones(corners), weights).ravel(), points, degree)
    return np.asarray(total * (3 / (np.arange(degree + 1)[:, None] + 3)))


def gravity(vertices: Array, faces: Faces, points: Array) -> tuple[Array, Array]:
    """Return potential (n,) and attraction (n, 3) at points (n, 3), inside or outside.

    Face by face (Werner and Scheeres 1997, CMDA 65, 313): with h the height of the face over the point, S = integral
    of dA / r = sum over edges of (r . m) L - h omega, where m is the outward normal of the edge in the face,
    L = log((r1 + r2 + e) / (r1 + r2 - e)) and omega the solid angle. Then U = sum h S / 2 and grad U = -sum n S.
    """
    triangles = Triangles(vertices, faces)
    potential, attraction = np.empty(len(points)), np.empty((len(points), 3))
    rows = max(1, cubature.MAX_POINTS // len(faces))
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        heights, sheets, _ = triangles.seen_from(points[part])
        potential[part] = np.sum(heights * sheets, axis=-1) / 2
        attraction[part] = -sheets @ triangles.normals
    return potential, attraction


def winding_numbers(corners: Array, points: Array) -> Array:
    """Return how often closed triangles (faces, 3, 3) go around points (n, 3): 1 inside, 0 outside."""
    total, rows = np.zeros(len(points)), max(1, cubature.MAX_POINTS // len(points))
    for start in range(0, len(corners), rows):
        part = corners[start : start + rows].reshape(-1, 3)
        total += Triangles(part, np.arange(len(part)).reshape(-1, 3)).seen_from(points)[2].sum(axis=1)
    return total / (4 * np.pi)


class Triangles:
    """Triangles with their outward unit normals; the normal of a degenerate triangle is zero."""

    def __init__(self, vertices: Array, faces: Faces) -> None:
        self.vertices, self.faces = vertices, faces
        corners = vertices[faces]
        edges = np.roll(corners, -1, axis=1) - corners
        turns = np.cross(edges[:, 0], edges[:, 1])
        self.lengths = np.linalg.norm(edges, axis=-1)
        self.doubled_areas = np.linalg.norm(turns, axis=-1)
        self.normals = _over(turns, self.doubled_areas)
        self.margins = _over(np.cross(edges, self.normals[:, None]), self.lengths)

    def seen_from(self, points: Array) -> tuple[Array, Array, Array]:
        """Return heights of the faces over points (n, 3), the integrals of dA / r and solid angles, each (n, faces).

        A solid angle is positive behind the face. For a point on the face it is 2 pi.
        """
        away = self.vertices - points[:, None]
        distances = np.linalg.norm(away, axis=-1)
        r, d = away[:, self.faces], distances[:, self.faces]
        heights = np.einsum("nfi,fi->nf", r[:, :, 0], self.normals)
        before, after = np.roll(r, 1, axis=2), np.roll(d, -1, axis=2)
        opposite = np.einsum("nfki,nfki->nfk", np.roll(r, -1, axis=2), before)  # of the corners opposite to each
        angles = 2 * np.arctan2(heights * self.doubled_areas, d.prod(axis=2) + np.sum(opposite * d, axis=2))
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithms = 2 * np.arctanh(self.lengths / (d + after))
            edges = np.einsum("nfki,fki->nfk", r, self.margins) * logarithms
        return heights, edges.sum(axis=2) - heights * angles, angles


def _over(vectors: Array, lengths: Array) -> Array:
    """Return vectors over lengths, zero where the length is."""
    return np.divide(vectors, lengths[..., None], out=np.zeros_like(vectors), where=lengths[..., None] > 0)


def _cones(corners: Array) -> Array:
    """Return the signed volumes of the cones from the origin over triangles (faces, 3, 3)."""
    return np.asarray(np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)
