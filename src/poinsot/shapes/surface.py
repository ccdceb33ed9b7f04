"""Surface of a mesh as edges and faces in their planes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.shapes.boxes import Boxes
from poinsot.shapes.clipping import inside, lines_of
from poinsot.shapes.mesh import Mesh

__all__ = ["Cuts", "Surface", "bases_of"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]

MAX_PAIRS = 4_000_000
"""Largest number of pairs of a face and a vertex in one block."""

HEIGHT_ROUNDING = 1e-12
"""Rounding error of a height over a face, in radii of the mesh."""


class Cuts(NamedTuple):
    """Segments in which other faces cut or touch faces from above, in ascending order of the faces that are cut.

    Attributes
    ----------
    faces, others : array (n,)
    beyond : array (n,)
        The face across the edge with which the other face touches, or the other face itself.
    ends : array (2, 3, n)
        Both ends in the plane of the face, from its centroid, with the height zero. The part of the face behind the
        other face is on the left.
    """

    faces: Integers
    others: Integers
    beyond: Integers
    ends: Array


class Surface:
    """Faces and edges of a mesh; positions are relative to the centre of mass.

    Attributes
    ----------
    vertices : array (v, 3)
    faces : array (f, 3) of int
    corners : array (f, 3, 3)
    areas : array (f,)
    normals, centers : array (f, 3)
        The normal of a degenerate triangle is zero, so that it is never illuminated.
    radius : float
        Largest distance of a vertex of a face from the centre of mass.
    low : float
        Rounding error of heights over a face.
    bases : array (f, 2, 3)
        Two axes in the plane of each face.
    flat_corners : array (3, 2, f)
        Corners of the faces along these axes, from the centroids.
    lines : array (3, 3, f)
        Edges of the faces, as in `lines_of`.
    edges, sides : array (e, 2) of int
        Vertices of each edge, and the two faces at the edge. The first one contains the vertices in this order.
    across : array (f, 3) of int
        Faces across the edges that begin at the corners of each face.
    below : bool array (f,)
        True for faces that have a vertex above their plane.
    convex : bool array (e,)
        True for edges at which the surface is not concave; the others have no visible shadows.
    cuts : Cuts
        Segments in which faces of intersecting surfaces cut other faces.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.vertices, self.faces = mesh.vertices - mesh.center_of_mass, mesh.faces
        self.corners, self.areas = self.vertices[self.faces], mesh.face_areas
        self.normals = np.nan_to_num(mesh.face_normals)
        self.centers = mesh.face_centers - mesh.center_of_mass
        self.radius = mesh.circumscribing_radius
        self.low = HEIGHT_ROUNDING * self.radius
        self.bases = bases_of(self.normals)
        self.flat_corners = np.einsum("fij,fkj->kif", self.bases, self.corners - self.centers[:, None])
        self.lines = lines_of(self.flat_corners)
        self.edges, self.sides, self.across = _edges(self.faces)
        self.below = self._faces_below()
        self.convex = self._convex_edges()
        self.cuts = self._cuts()

    def _faces_below(self) -> Flags:
        offsets = np.einsum("fi,fi->f", self.normals, self.centers)
        below = np.zeros(len(self.areas), dtype=bool)
        rows = max(1, MAX_PAIRS // len(self.vertices))
        for start in range(0, len(self.areas), rows):
            part = slice(start, start + rows)
            heights = self.normals[part] @ self.vertices.T - offsets[part, None]
            below[part] = (heights > self.low).any(axis=1)
        return below

    def _convex_edges(self) -> Flags:
        one, other = self.sides.T
        opposite = self.faces[other].sum(axis=1) - self.edges.sum(axis=1)
        rise = np.einsum("ei,ei->e", self.normals[one], self.vertices[opposite] - self.centers[one])
        return np.asarray(rise <= self.low)

    def _cuts(self) -> Cuts:
        low, high = self.corners.min(axis=1), self.corners.max(axis=1)
        some, start = np.flatnonzero(self.below), np.zeros(len(self.areas), dtype=np.int64)
        which, other = Boxes(start, low, high, self.radius).overlapping(start[some], low[some], high[some])
        face = some[which]
        apart = (self.faces[face][:, :, None] != self.faces[other][:, None, :]).all(axis=(1, 2))
        face, other = face[apart], other[apart]
        heights = np.einsum("pi,pki->kp", self.normals[face], self.corners[other] - self.centers[face][:, None])
        heights[np.abs(heights) <= self.low] = 0.0
        touches = np.sum(heights == 0, axis=0) == 2  # with an edge
        crosses = (heights.max(axis=0) > 0) & (touches | (heights.min(axis=0) < 0))
        face, other, heights, touches = face[crosses], other[crosses], heights[:, crosses], touches[crosses]
        up = heights > 0
        alone = np.argmax(up == (up.sum(axis=0) == 1), axis=0)  # the corner on its side of the plane
        pair, ends = np.arange(len(face)), []
        for there in ((alone + 1) % 3, (alone + 2) % 3):
            share = heights[alone, pair] / (heights[alone, pair] - heights[there, pair])
            one, two = self.corners[other, alone], self.corners[other, there]
            ends.append(one + share[:, None] * (two - one))
        along = np.cross(self.normals[face], self.normals[other])
        backwards = np.einsum("pi,pi->p", ends[1] - ends[0], along) < 0
        ends = np.where(backwards[:, None], ends[::-1], ends) - self.centers[face]
        flat = np.zeros((2, 3, len(face)))
        flat[:, :2] = np.einsum("pji,kpi->kjp", self.bases[face], ends)
        begin, end = inside(self.lines[..., face], flat[0, :2], (flat[1] - flat[0])[:2], self.low)
        order = np.flatnonzero(end > begin)
        order = order[np.argsort(face[order], kind="stable")]
        beyond = np.where(touches, self.across[other, (alone + 1) % 3], other)
        return Cuts(face[order], other[order], beyond[order], flat[..., order])


def _edges(faces: Integers) -> tuple[Integers, Integers, Integers]:
    """Return the vertices and faces of the edges of closed surfaces, and the faces across the edges of each face."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    pairs = np.lexsort((np.maximum(start, end), np.minimum(start, end))).reshape(-1, 2)
    across = np.empty_like(start)
    across[pairs] = pairs[:, ::-1] // 3
    return np.stack([start[pairs[:, 0]], end[pairs[:, 0]]], axis=-1), pairs // 3, across.reshape(-1, 3)


def bases_of(normals: Array) -> Array:
    """Return two unit vectors in the planes of normals (n, 3), anticlockwise about them; shape (n, 2, 3)."""
    first = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=-1)])
    lengths = np.linalg.norm(first, axis=-1, keepdims=True)
    first = np.divide(first, lengths, out=np.zeros_like(first), where=lengths > 0)
    return np.stack([first, np.cross(normals, first)], axis=-2)
