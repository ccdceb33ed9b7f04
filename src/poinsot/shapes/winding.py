"""Whether triangles close a surface, all seen from the same side; and turning those that do not agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["check_closed", "repaired"]

Faces = NDArray[np.int64]


def check_closed(faces: Faces) -> None:
    """Raise a ValueError unless every edge belongs to two faces that run through it in opposite directions."""
    sharing, agree = _shared_edges(faces)
    if not agree.all():
        one, other = sharing[np.argmin(agree)]
        raise ValueError(
            f"faces must all be wound to the same side, but faces {one} and {other} disagree. repair=True turns them."
        )


def repaired(vertices: NDArray[np.float64], faces: Faces) -> Faces:
    """Return the faces without those of no area by their indices, without doubles, and wound to one side.

    Components whose faces disagree are turned outwards; all are turned together if their volume is negative then.
    """
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
    if not len(faces):
        return faces
    sharing, agree = _shared_edges(faces)
    component, turned = _sides(len(faces), sharing, agree)
    a, b, c = np.moveaxis((vertices - vertices[faces[0, 0]])[faces], 1, 0)
    volumes = np.einsum("fi,fi->f", a, np.cross(b, c))
    mixed = np.bincount(component, turned) % np.bincount(component) != 0
    inwards = np.bincount(component, np.where(turned, -volumes, volumes)) < 0
    turned = mixed[component] & (turned ^ inwards[component])
    turned ^= np.sum(np.where(turned, -volumes, volumes)) < 0
    return np.where(turned[:, None], faces[:, ::-1], faces)


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
    """Return the component of each face, and whether it must be turned to agree with the others in it.

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
