"""Geodesic spheres: triangles with vertices on the unit sphere, of nearly equal areas."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

__all__ = ["geodesic_sphere"]

FACES_OF_ICOSAHEDRON = 20
"""Number of faces of the icosahedron, whose faces are divided."""


def geodesic_sphere(faces: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (n, 3) and faces (20 k^2, 3), k from 1, of the geodesic sphere nearest to a number of faces.

    Each edge of an icosahedron is divided into k parts, and the points are projected to the unit sphere. Faces are
    anticlockwise seen from outside.
    """
    parts = max(1, round((faces / FACES_OF_ICOSAHEDRON) ** 0.5))
    corners, triangles = _icosahedron()
    numbers = [(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    place = {number: k for k, number in enumerate(numbers)}
    i, j = np.array(numbers).T
    weights = np.stack([parts - i - j, i, j], axis=1)
    upward = [(place[i, j], place[i + 1, j], place[i, j + 1]) for i, j in numbers if i + j < parts]
    downward = [(place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]) for i, j in numbers if i + j < parts - 1]
    points = np.einsum("pc,fcx->fpx", weights, corners[triangles]).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    _, first, shared = np.unique(points.round(9) + 0.0, axis=0, return_index=True, return_inverse=True)
    cells = np.array(upward + downward) + len(numbers) * np.arange(len(triangles))[:, None, None]
    return points[first], shared.reshape(-1)[cells].reshape(-1, 3)


def _icosahedron() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices of an icosahedron, on the unit sphere, and its faces."""
    golden = (1 + 5**0.5) / 2
    signs = itertools.product((1.0, -1.0), repeat=2)
    corners = np.array([np.roll((0.0, a, b * golden), k) for a, b in signs for k in range(3)])
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    near = corners @ corners.T > 0.4  # cosines of neighbours are 1 / sqrt(5)
    found = []
    for a, b, c in itertools.combinations(range(len(corners)), 3):
        if near[a, b] and near[b, c] and near[a, c]:
            outwards = np.linalg.det(corners[[a, b, c]]) > 0
            found.append((a, b, c) if outwards else (a, c, b))
    return corners, np.array(found)
