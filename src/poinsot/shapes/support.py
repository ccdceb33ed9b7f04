"""Support functions of points: the largest component of a point along a vector."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.taylor.graph import Number, Primitive, computed

__all__ = ["extreme_points", "support_of_points"]

Array = NDArray[np.float64]

MAX_WRITTEN = 64
"""Largest number of points whose support function is a formula, for scalars of any kind."""

BLOCK = 2**20
"""Number of products of points with vectors that are computed together."""


def extreme_points(points: Array) -> Array:
    """Return the vertices of the convex hull of points (n, 3); all points if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return points


def support_of_points(points: Array, direction: Sequence[Scalar]) -> Scalar:
    """Return the largest of the products x . w of points x (n, 3) with a vector w.

    Scalars other than floats, arrays and nodes of a graph require few points.
    """
    if len(points) > MAX_WRITTEN:
        return computed(SupportOfPoints(points), direction)
    return functools.reduce(functions.maximum, (functions.dot(point, direction) for point in points))


class SupportOfPoints(Primitive):
    """Support function of many points; its gradient is the farthest point."""

    def __init__(self, points: Array) -> None:
        self.points = points

    @override
    def entries(self, numbers: Sequence[int], *variables: Number) -> Mapping[int, Number]:
        vectors = np.stack(np.broadcast_arrays(*variables)).astype(float)
        w = vectors.reshape(3, -1)
        count = max(1, BLOCK // len(self.points))
        parts = (w[:, i : i + count] for i in range(0, w.shape[1], count))
        farthest = self.points[np.concatenate([np.argmax(self.points @ part, axis=0) for part in parts])].T
        found = {k: farthest[k - 1] if k else np.sum(farthest * w, axis=0) for k in numbers}
        return {k: values.reshape(vectors.shape[1:])[()] for k, values in found.items()}
