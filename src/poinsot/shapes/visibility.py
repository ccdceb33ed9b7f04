"""Parts of the faces of meshes that a distant light reaches and a distant observer sees."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.errors import real_numbers, refuse_zero
from poinsot.shapes.clipping import turn
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Boundary, Neighbour, Scene

__all__ = ["ClearParts", "Slopes", "clear_faces", "clear_parts", "illuminated_areas", "illuminated_faces"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]

BLOCK_FACES = 30_000
"""Number of faces of all epochs in one block, whose arrays stay in the cache."""


class Slopes(NamedTuple):
    """Derivatives of a weighted sum of areas at each epoch.

    Attributes
    ----------
    directions : list of arrays (n, 3)
        Derivatives by the unit vectors of the directions.
    position : array (n, 3)
        Derivatives by the position of the neighbour.
    matrix : array (n, 3, 3)
        Derivatives by the matrix of the neighbour.
    """

    directions: list[Array]
    position: Array
    matrix: Array


class ClearParts:
    """Parts of the faces of a surface that no face hides along any of several directions.

    Parts of the edges of the face and of the edges of shadows bound each clear part. Integrals over the clear part and
    derivatives of its area are sums over these edges.

    Attributes
    ----------
    areas : array (n, faces)
        Areas of the parts.
    """

    def __init__(
        self, surface: Surface, count: int, areas: Array, neighbour: Neighbour | None, boundaries: list[Boundary]
    ) -> None:
        self.areas, self._boundaries = areas, boundaries
        self._surface, self._directions, self._neighbour = surface, count, neighbour

    @property
    def centers(self) -> Array:
        """Centroids of the parts along the axes of the mesh, (n, faces, 3); the centroid of a face that is hidden."""
        surface = self._surface
        centers = np.broadcast_to(surface.centers, (*self.areas.shape, 3)).copy()
        moments = np.zeros((2, self.areas.size))
        for rows, faces, edges, lengths, firsts in self._boundaries:
            turns = np.where(edges.views < 0, 1, -1) * turn(edges.starts, edges.spans) / 3
            cells = rows * len(surface.areas) + faces
            for k in range(2):
                values = turns * (edges.starts[k] * lengths + edges.spans[k] * firsts)
                moments[k] += np.bincount(cells, values, self.areas.size)
        flat = np.divide(
            moments.reshape(2, *self.areas.shape),
            self.areas,
            where=self.areas > 0,
            out=np.zeros((2, *self.areas.shape)),
        )
        centers += np.einsum("knf,fki->nfi", flat, surface.bases)
        return centers

    def slopes(self, weights: Array) -> Slopes:
        """Return the derivatives of the sum of areas times weights (n, faces).

        When a direction d changes by dd, the shadow of a point at height h over the plane with normal n moves by
        -(h/(n.d)) (dd - d (n.dd)/(n.d)), which is linear along an edge. The area changes by the integral of the
        component of this velocity into the shadow.
        """
        count, other = len(self.areas), self._neighbour
        directions = [np.zeros((count, 3)) for _ in range(self._directions)]
        position, matrix = np.zeros((count, 3)), np.zeros((count, 3, 3))
        for rows, faces, edges, lengths, firsts in self._boundaries:
            turns = weights[rows, faces] * edges.turns
            changes = -(edges.lifts[0] * lengths + edges.lifts[1] * firsts) * turns
            for k, slope in enumerate(directions):
                slope += _sums(changes * (edges.views == k), rows, count)
            if other is not None:
                turns *= edges.others >= len(self._surface.faces)
                position += _sums(lengths * turns, rows, count)
                arms = edges.places[0] * lengths + edges.places[1] * firsts - lengths * other.positions.T[:, rows]
                arms = np.einsum("nji,in->jn", np.linalg.inv(other.matrices)[rows], arms)
                for k in range(3):
                    matrix[:, :, k] += _sums(turns * arms[k], rows, count)
        return Slopes(directions, position, matrix)


def clear_faces(
    surface: Surface, directions: Sequence[Array], neighbour: Neighbour | None = None, shadows: bool = True
) -> Flags:
    """Return True where no face hides the centroid of a face along any of several directions; shape (n, faces).

    Parameters
    ----------
    directions : sequence of arrays (n, 3)
        Unit vectors to the light and, optionally, to the observer.
    neighbour : Neighbour, optional
        Another body, which may hide faces.
    shadows : bool
        False if every face that is oriented towards all directions is clear.
    """
    clear = np.empty((len(directions[0]), len(surface.areas)), dtype=bool)
    for part in _blocks(surface, len(clear)):
        scene = Scene(surface, directions, neighbour, part)
        clear[part] = scene.facing
        if shadows:
            rows, faces = scene.exposed
            for view in scene.views:
                hidden = view.hides(rows, faces)
                clear[part][rows[hidden], faces[hidden]] = False
                rows, faces = rows[~hidden], faces[~hidden]
    return clear


def clear_parts(surface: Surface, directions: Sequence[Array], neighbour: Neighbour | None = None) -> ClearParts:
    """Return the parts of the faces that no face hides along any of several directions, as in `clear_faces`."""
    areas = np.empty((len(directions[0]), len(surface.areas)))
    found = []
    for part in _blocks(surface, len(areas)):
        areas[part], boundary = Scene(surface, directions, neighbour, part).parts()
        found.append(boundary._replace(rows=boundary.rows + part.start))
    return ClearParts(surface, len(directions), areas, neighbour, found)


def _blocks(surface: Surface, count: int) -> list[slice]:
    """Return blocks of epochs."""
    rows = max(1, BLOCK_FACES // len(surface.areas))
    return [slice(start, min(start + rows, count)) for start in range(0, count, rows)]


@checked
def illuminated_faces(
    mesh: Mesh, directions: ArrayLike, shadows: bool = True, to_observer: ArrayLike | None = None
) -> Flags:
    """Return True for each face of a mesh whose centroid receives light from a direction, and is seen.

    Edges and corners of other faces also block the light and the line of sight.

    Parameters
    ----------
    mesh : Mesh
        Surface with its faces.
    directions : array (..., 3)
        Directions to the light, axes of the shape, of any nonzero length.
    shadows : bool
        True to include shadows of other faces. With False, all faces oriented towards the light are illuminated.
    to_observer : array (..., 3), optional
        Directions to a distant observer, who sees the centroid. None if it does not matter who sees it.

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
    units, shape = _unit_directions(directions, to_observer)
    return clear_faces(Surface(mesh), units, shadows=shadows).reshape(*shape, len(mesh.faces))


@checked
def illuminated_areas(mesh: Mesh, directions: ArrayLike, to_observer: ArrayLike | None = None) -> Array:
    """Return the exact areas of the parts of faces that a distant light reaches and a distant observer sees.

    Parameters
    ----------
    mesh : Mesh
        Surface with its faces.
    directions : array (..., 3)
        Directions to the light, axes of the shape, of any nonzero length.
    to_observer : array (..., 3), optional
        Directions to the observer. None for the illuminated area, seen or not.

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
    units, shape = _unit_directions(directions, to_observer)
    return clear_parts(Surface(mesh), units).areas.reshape(*shape, len(mesh.faces))


def _unit_directions(directions: ArrayLike, to_observer: ArrayLike | None) -> tuple[list[Array], tuple[int, ...]]:
    """Return unit vectors (n, 3) to the light and, if there is one, to the observer, and the shape of n."""
    units = []
    for name, given in (("directions", directions), ("to_observer", to_observer)):
        if given is not None:
            array = real_numbers(name, given)
            if array.shape[-1:] != (3,):
                raise ValueError(f"{name} must have shape (..., 3), got shape {array.shape}.")
            refuse_zero(name, array)
            units.append(array / np.linalg.norm(array, axis=-1, keepdims=True))
    try:
        shape = np.broadcast_shapes(*(array.shape for array in units))
    except ValueError:
        raise ValueError(
            f"to_observer must have a shape that fits directions, got {units[1].shape} and {units[0].shape}. "
            "Pass as many directions to the observer as to the light, or one."
        ) from None
    return [np.broadcast_to(array, shape).reshape(-1, 3) for array in units], shape[:-1]


def _sums(vectors: Array, rows: Integers, count: int) -> Array:
    """Return the sums of vectors (3, n) at each epoch, shape (count, 3)."""
    return np.stack([np.bincount(rows, component, count) for component in vectors], axis=-1)
