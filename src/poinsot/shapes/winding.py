"""Check of closed surfaces, and check and repair of the orientation of their triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.shapes import polyhedron

__all__ = ["FLAT_TOLERANCE", "check_closed", "check_outwards", "repaired"]

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

FLAT_TOLERANCE = 64 * np.finfo(float).eps
"""Largest volume of a surface without content, relative to the volume of the box around it, by rounding."""

SAMPLED_FACES = 8
"""Number of faces whose centroids decide whether one surface is inside another."""


def check_closed(faces: Faces) -> Faces:
    """Return the two faces at each edge, shape (edges, 2).

    Raises
    ------
    ValueError
        Unless every edge belongs to two faces that run through it in opposite directions.
    """
    sharing, agree = _shared_edges(faces)
    if not agree.all():
        one, other = sharing[np.argmin(agree)]
        raise ValueError(
            f"faces must all be wound to the same side, but faces {one} and {other} disagree. "
            "Pass repair=True to reverse them."
        )
    return sharing


def check_outwards(vertices: Array, faces: Faces, sharing: Faces) -> None:
    """Raise a ValueError if a closed surface is wound inwards and in no other; a hollow is inside another."""
    component, _ = _sides(len(faces), sharing, np.ones(len(sharing), dtype=bool))
    wrong = _Surfaces(vertices, faces, component).wound_wrongly()
    if wrong.any():
        raise ValueError(
            "each closed surface must be anticlockwise seen from outside, or a cavity in another surface, "
            "but the surface of face "
            f"{np.argmax(wrong[component])} is wound inwards and lies in no other surface. Pass repair=True "
            f"to reverse it."
        )


def repaired(vertices: Array, faces: Faces) -> Faces:
    """Return the faces without degenerate and repeated ones, wound to one side.

    Components whose faces disagree are turned outwards. Then each outermost component that is wound inwards is turned,
    together with the components inside it.
    """
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
    if not len(faces):
        return faces
    sharing, agree = _shared_edges(faces)
    component, turned = _sides(len(faces), sharing, agree)
    mixed = np.bincount(component, turned) % np.bincount(component) != 0
    faces = _turned(faces, mixed[component] & turned)
    inwards = _Surfaces(vertices, faces, component).signs < 0
    faces = _turned(faces, (mixed & inwards)[component])
    return _turned(faces, _Surfaces(vertices, faces, component).wound_wrongly()[component])


def _turned(faces: Faces, which: NDArray[np.bool_]) -> Faces:
    return np.where(which[:, None], faces[:, ::-1], faces)


class _Surfaces:
    """Closed surfaces of a mesh, from the number of the surface of each face."""

    def __init__(self, vertices: Array, faces: Faces, component: Faces) -> None:
        order = np.argsort(component, kind="stable")
        self.corners = vertices[faces[order]]
        counts = np.bincount(component)
        self.ends = np.cumsum(counts)
        self.starts = self.ends - counts
        self.low = np.minimum.reduceat(self.corners.min(axis=1), self.starts)
        self.high = np.maximum.reduceat(self.corners.max(axis=1), self.starts)
        a, b, c = np.moveaxis(self.corners - np.repeat(self.low, counts, axis=0)[:, None], 1, 0)
        self.volumes = np.add.reduceat(np.einsum("fi,fi->f", a, np.cross(b, c)), self.starts) / 6
        flat = np.abs(self.volumes) <= FLAT_TOLERANCE * np.prod(self.high - self.low, axis=1)
        self.signs = np.where(flat, 0, np.sign(self.volumes)).astype(int)

    def wound_wrongly(self) -> NDArray[np.bool_]:
        """Return which to turn so that each is wound outwards or a hollow; the largest come first."""
        wrong, signs = np.zeros(len(self.signs), dtype=bool), self.signs.copy()
        for i in np.argsort(-np.abs(self.volumes), kind="stable"):
            if signs[i] < 0 and sum(signs[j] for j in self._overlapping(i) if self._is_inside(i, j)) <= 0:
                turned = [i, *(j for j in self._overlapping(i) if self._is_inside(j, i))]
                wrong[turned] ^= True
                signs[turned] *= -1
        return wrong

    def _overlapping(self, i: int) -> Faces:
        """Return the other surfaces whose boxes overlap the box of surface i."""
        apart = (self.low > self.high[i]).any(axis=1) | (self.high < self.low[i]).any(axis=1)
        apart[i] = True
        return np.flatnonzero(~apart)

    def _is_inside(self, i: int, j: int) -> bool:
        """Return True if most of the sampled face centroids of surface i are inside surface j."""
        chosen = np.linspace(self.starts[i], self.ends[i] - 1, SAMPLED_FACES).astype(int)
        points = self.corners[chosen].mean(axis=1)
        around = polyhedron.winding_numbers(self.corners[self.starts[j] : self.ends[j]], points)
        return bool(np.mean(np.abs(around)) > 0.5)


def _shared_edges(faces: Faces) -> tuple[Faces, NDArray[np.bool_]]:
    """Return the two faces at each edge, shape (edges, 2), and whether they run through it in opposite directions."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(start, end) * (faces.max() + 1) + np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    wrong = np.flatnonzero(counts != 2)
    if wrong.size:
        edge, count = order[first[wrong[0]]], counts[wrong[0]]
        raise ValueError(
            f"faces must close the surface, two at every edge, but {count} {'has' if count == 1 else 'have'} the edge "
            f"between vertices {start[edge]} and {end[edge]}."
        )
    pairs = order.reshape(-1, 2)
    return pairs // 3, start[pairs[:, 0]] != start[pairs[:, 1]]


def _sides(count: int, sharing: Faces, agree: NDArray[np.bool_]) -> tuple[Faces, NDArray[np.bool_]]:
    """Return the component of each face, and True if the face must be turned to agree with the component.

    Each face has two sides, joined across an edge with the sides of its neighbour that look the same way.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, other = sharing.T
    across = np.where(agree, other, other + count)
    back = np.where(agree, other + count, other)
    rows, columns = np.concatenate([one, one + count]), np.concatenate([across, back])
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    front, rear = np.reshape(connected_components(graph, directed=False)[1], (2, count))
    if np.any(front == rear):
        raise ValueError(f"faces must have two sides, but the surface of face {np.argmax(front == rear)} has one.")
    return np.unique(np.minimum(front, rear), return_inverse=True)[1], front > rear
