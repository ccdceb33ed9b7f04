"""A homogeneous polyhedron with triangular faces."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.errors import array_of, real_array, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.mechanics.body import inertia_of_spread
from poinsot.records.parameters import Points
from poinsot.shapes import polyhedron
from poinsot.shapes.shape import Shape, ShapePoints, mass_of
from poinsot.shapes.support import extreme_points, support_of_points
from poinsot.shapes.winding import FLAT_TOLERANCE, check_closed, check_outwards, repaired

__all__ = ["Mesh"]

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


class Mesh(Shape):
    """Homogeneous polyhedron inside a closed surface of triangles, with exact integrals for this polyhedron.

    The relative error of the potential grows with distance as 1e-15 times the square of the distance divided by the
    circumscribing radius. The series of `field` is more accurate at large distances.

    Parameters
    ----------
    vertices : array (n, 3), axes of the shape
        Positions of the vertices relative to the origin of the shape.
    faces : array (m, 3) of int
        Indices of the three vertices of each triangle, from 0, anticlockwise seen from outside. Several closed surfaces
        form one body. A surface inside another one that is wound inwards is a cavity. Overlaps count twice.
    mass, density : float
        Mass or density; exactly one of the two.
    repair : bool
        True to remove degenerate and repeated faces, to reverse inconsistent faces, and to reverse closed surfaces that
        are wound inwards and not inside another one, together with the surfaces inside them.

    Raises
    ------
    ValueError
        If an edge does not belong to exactly two faces, both faces pass through it in the same direction, a closed
        surface is wound inwards and not inside another one, or no volume is enclosed. Intersections of surfaces are not
        checked.

    Examples
    --------
    >>> box = pt.shapes.Mesh.from_box((1, 2, 3), density=2.0)
    >>> box.mass
    12.0
    """

    @checked
    def __init__(
        self,
        vertices: ShapePoints,
        faces: Points,
        *,
        mass: float | None = None,
        density: float | None = None,
        repair: bool = False,
    ) -> None:
        self.vertices = real_array("vertices", vertices, (None, 3))
        self.faces = _faces(faces, len(self.vertices))
        if repair:
            self.faces = repaired(self.vertices, self.faces)
        _check_faces(self.faces)
        sharing = check_closed(self.faces)
        self.vertices.flags.writeable = self.faces.flags.writeable = False
        self.volume, self._center = polyhedron.volume_and_center(self.vertices, self.faces)
        self._check_volume()
        check_outwards(self.vertices, self.faces, sharing)
        self._mass = mass_of(self.volume, mass, density)

    @staticmethod
    @checked
    def from_box(sides: ArrayLike, *, mass: float | None = None, density: float | None = None) -> Mesh:
        """Return the box about the origin with full side lengths (a, b, c) along the axes."""
        lengths = real_array("sides", sides, (3,))
        refuse_nonpositive("sides", lengths)
        corners = np.array([(i >> 2, i >> 1 & 1, i & 1) for i in range(8)]) - 0.5
        quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return Mesh(corners * lengths, triangles, mass=mass, density=density)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces, mass={self.mass:g})"

    @property
    @override
    def inertia(self) -> Array:
        density = self.mass / self.volume
        return inertia_of_spread(density * polyhedron.second_moments(self.vertices - self._center, self.faces))

    @property
    @override
    def circumscribing_radius(self) -> float:
        used = self.vertices[np.unique(self.faces)]
        return float(np.linalg.norm(used - self._center, axis=-1).max())

    @cached_property
    def _extremes(self) -> Array:
        """Vertices of the convex hull from the centre of mass."""
        return extreme_points(self.vertices[np.unique(self.faces)] - self._center)

    @override
    def support(self, direction: Iterable[Scalar]) -> Scalar:
        return support_of_points(self._extremes, tuple(direction))

    @property
    def face_areas(self) -> Array:
        """Areas of the faces, shape (m,)."""
        return np.asarray(0.5 * np.linalg.norm(self._face_vectors, axis=-1))

    @property
    def face_normals(self) -> Array:
        """Outward unit normals of the faces along the axes of the shape, shape (m, 3); NaN for a flat triangle."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self._face_vectors / np.linalg.norm(self._face_vectors, axis=-1, keepdims=True))

    @property
    def face_centers(self) -> Array:
        """Centroids of the faces relative to the origin of the shape, along its axes, shape (m, 3)."""
        return np.asarray(self.vertices[self.faces].mean(axis=1))

    @property
    def _face_vectors(self) -> Array:
        """Normals of the faces, with twice the areas as lengths."""
        first, second, third = np.moveaxis(self.vertices[self.faces], 1, 0)
        return np.cross(second - first, third - first)

    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        integrals = polyhedron.multipoles((self.vertices - origin) / radius, self.faces, degree)
        return integrals * (self.mass / self.volume * radius**3)

    def _gravity(self, points: Array) -> tuple[Array, Array]:
        potential, attraction = polyhedron.gravity(self.vertices - self._center, self.faces, points)
        return self.mass / self.volume * potential, self.mass / self.volume * attraction

    def _placed(self, position: Array, matrix: Array) -> Mesh:
        return Mesh(self.vertices @ matrix.T + position, self.faces, mass=self.mass)

    def _check_volume(self) -> None:
        if abs(self.volume) <= FLAT_TOLERANCE * np.prod(np.ptp(self.vertices[self.faces], axis=(0, 1))):
            raise ValueError("faces must enclose a volume, but they enclose none.")
        if self.volume < 0:
            raise ValueError(
                f"faces must be anticlockwise seen from outside, but they enclose the volume {self.volume:.3g}. "
                "Pass repair=True to reverse them."
            )


def _faces(faces: Any, vertices: int) -> Faces:
    array = array_of("faces", faces)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces must have shape (n, 3), got shape {array.shape}.")
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces must be whole numbers, got {array.dtype}.")
    wrong = array[(array < 0) | (array >= vertices)]
    if wrong.size:
        raise ValueError(f"faces must name vertices from 0 to {vertices - 1}, got {wrong[0]}.")
    return array.astype(np.int64)


def _check_faces(faces: Faces) -> None:
    if not len(faces):
        raise ValueError("faces must not be empty, got none.")
    doubled = np.flatnonzero((faces == np.roll(faces, 1, axis=1)).any(axis=1))
    if doubled.size:
        raise ValueError(
            f"faces must have three vertices each, but face {doubled[0]} names one twice. repair=True drops it."
        )
