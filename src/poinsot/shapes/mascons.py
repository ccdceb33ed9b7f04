"""Mass points (mascons)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.errors import real_array, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.mechanics.body import inertia_of_spread
from poinsot.shapes.cubature import gravity_of_points, multipoles
from poinsot.shapes.shape import Shape, ShapePoints
from poinsot.shapes.support import extreme_points, support_of_points

__all__ = ["Mascons"]

Array = NDArray[np.float64]


class Mascons(Shape):
    """Point masses at rest relative to each other.

    Parameters
    ----------
    masses : array (n,)
        Masses of the points, positive.
    positions : array (n, 3), axes of the shape
        Positions of the points relative to the origin of the shape.

    Raises
    ------
    ValueError
        If the arrays are empty, or a mass is not positive.

    Examples
    --------
    >>> points = pt.shapes.Mascons((1.0, 3.0), ((0, 0, 0), (4, 0, 0)))
    >>> points.center_of_mass
    array([3., 0., 0.])
    """

    def __init__(self, masses: ArrayLike, positions: ShapePoints) -> None:
        self.masses = real_array("masses", masses, (None,))
        refuse_nonpositive("masses", self.masses)
        if not self.masses.size:
            raise ValueError("masses must not be empty, got shape (0,).")
        self.positions = real_array("positions", positions, (self.masses.size, 3))
        self.masses.flags.writeable = self.positions.flags.writeable = False
        self._mass = float(self.masses.sum())
        self._center = np.asarray(self.masses @ self.positions / self._mass)

    def __repr__(self) -> str:
        return f"Mascons({len(self.masses)} points, mass={self.mass:g})"

    @property
    @override
    def inertia(self) -> Array:
        x = self.positions - self.center_of_mass
        return inertia_of_spread(np.einsum("n,ni,nj->ij", self.masses, x, x))

    @property
    @override
    def circumscribing_radius(self) -> float:
        return float(np.linalg.norm(self.positions - self.center_of_mass, axis=-1).max())

    @override
    def support(self, direction: Iterable[Scalar]) -> Scalar:
        return support_of_points(self._extremes, tuple(direction))

    @cached_property
    def _extremes(self) -> Array:
        """Points on the convex hull from the centre of mass."""
        return extreme_points(self.positions - self.center_of_mass)

    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        return multipoles(self.masses, (self.positions - origin) / radius, degree)

    def _gravity(self, points: Array) -> tuple[Array, Array]:
        return gravity_of_points(self.masses, self.positions - self.center_of_mass, points)

    def _placed(self, position: Array, matrix: Array) -> Mascons:
        return Mascons(self.masses, self.positions @ matrix.T + position)
