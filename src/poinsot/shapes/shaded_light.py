"""Reflected light of meshes whose faces hide each other, alone or before and behind a second body."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.shapes.law_program import LawFormula
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.reflected_light import LightOfPlates, Shares
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Neighbour
from poinsot.shapes.visibility import clear_faces, clear_parts

__all__ = ["LightOfShadedMesh", "Shadows"]

Array = NDArray[np.float64]

Shadows: TypeAlias = Literal["exact", "centroids"]
"""Exact clear areas, or whole faces by their centroids."""


class LightOfShadedMesh(LightOfPlates):
    """Light of a mesh, of which only the parts count that no face hides from the Sun and from the observer.

    Under a stretch D shadows of parallel light stay shadows: the clear share of a face is the share on the mesh without
    a stretch in the directions D^-1 s and D^-1 e. For a second mesh at x -> M x + r under the same stretch, the
    position is D^-1 r and the matrix is D^-1 M D.
    """

    def __init__(self, mesh: Mesh, formula: LawFormula, shadows: Shadows, other: Mesh | None = None) -> None:
        super().__init__(mesh, formula)
        self._exact, self._surface = shadows == "exact", Surface(mesh)
        self._other = None if other is None else Surface(other)
        if other is not None:
            self.placed = 12

    @override
    def shares(self, vectors: Array, stretch: Array) -> Shares | None:
        if self._other is None and not self._surface.below.any():
            return None  # a convex mesh
        neighbour = None
        if self._other is not None:
            matrices = vectors[9:].T.reshape(-1, 3, 3) * (stretch / stretch[:, None])
            neighbour = Neighbour(self._other, vectors[6:9].T / stretch, matrices)
        images = [vectors[k : k + 3].T / stretch for k in (0, 3)]
        lengths = [np.linalg.norm(image, axis=1, keepdims=True) for image in images]
        units = [image / length for image, length in zip(images, lengths, strict=True)]
        if self._exact:
            return ExactShares(self._surface, units, lengths, neighbour, stretch)
        return SharesByCentroids(clear_faces(self._surface, units, neighbour))


class SharesByCentroids(Shares):
    """Shares of 1 and 0 by the centroids of the faces."""

    def __init__(self, clear: NDArray[np.bool_]) -> None:
        self.values = clear.astype(float)

    @override
    def slopes(self, weights: Array) -> Array:
        raise ValueError(
            'shadows must be "exact" for partial derivatives, got "centroids". The brightness jumps where a shadow '
            "passes the centroid of a face."
        )


class ExactShares(Shares):
    """Clear areas over the areas of the faces."""

    def __init__(
        self, surface: Surface, units: list[Array], lengths: list[Array], neighbour: Neighbour | None, stretch: Array
    ) -> None:
        self._parts, areas = clear_parts(surface, units, neighbour), surface.areas
        self.values = np.divide(self._parts.areas, areas, out=np.zeros_like(self._parts.areas), where=areas > 0)
        self._lengths, self._stretch, self._areas, self._placed = lengths, stretch, areas, neighbour is not None

    @override
    def slopes(self, weights: Array) -> Array:
        weights = np.divide(weights, self._areas, out=np.zeros_like(weights), where=self._areas > 0)
        found = self._parts.slopes(weights)
        changes = [
            slope / (length * self._stretch) for slope, length in zip(found.directions, self._lengths, strict=True)
        ]
        if self._placed:
            matrix = found.matrix * (self._stretch / self._stretch[:, None])
            changes += [found.position / self._stretch, matrix.reshape(-1, 9)]
        return np.concatenate(changes, axis=1).T
