"""Rigid assemblies of several shapes."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.functions import Scalar
from poinsot.mechanics.body import inertia_of_spread
from poinsot.printable import described
from poinsot.shapes.shape import Shape

__all__ = ["Assembly"]

Array = NDArray[np.float64]


class Assembly(Shape):
    """Several shapes as one rigid body, each at the place and attitude set by `moved`.

    Parameters
    ----------
    parts : sequence of Shape
        Shapes of the assembly. Overlaps are not checked: their mass counts twice.

    Raises
    ------
    ValueError
        If the sequence is empty.

    Examples
    --------
    >>> ball = pt.shapes.Ellipsoid((1, 1, 1), mass=1.0)
    >>> pair = pt.shapes.Assembly([ball.moved((-1, 0, 0)), ball.moved((1, 0, 0))])
    >>> pair.inertia.diagonal()
    array([0.8, 2.8, 2.8])
    """

    @checked
    def __init__(self, parts: Sequence[Shape]) -> None:
        self.parts = tuple(parts)
        if not self.parts:
            raise ValueError("parts must not be empty, got none.")
        for part in self.parts:
            if not isinstance(part, Shape):
                raise TypeError(f"parts must be shapes, got {described(part)}.")
        self._mass = sum(part.mass for part in self.parts)
        self._center = np.asarray(sum(part.mass * part.center_of_mass for part in self.parts) / self._mass)

    def __repr__(self) -> str:
        return f"Assembly([{', '.join(map(repr, self.parts))}])"

    @property
    @override
    def inertia(self) -> Array:
        center, total = self.center_of_mass, np.zeros((3, 3))
        for part in self.parts:
            arm = part.center_of_mass - center
            total += part.inertia + part.mass * inertia_of_spread(np.outer(arm, arm))
        return total

    @property
    def circumscribing_radius(self) -> float:
        """Radius of the sphere about the centre of mass that contains the circumscribing spheres of the parts.

        It is an upper bound of the radius of the smallest sphere that contains the parts.
        """
        center = self.center_of_mass
        return max(float(np.linalg.norm(p.center_of_mass - center)) + p.circumscribing_radius for p in self.parts)

    @override
    def support(self, direction: Iterable[Scalar]) -> Scalar:
        w, center = tuple(direction), self.center_of_mass
        each = (part.support(w) + functions.dot(part.center_of_mass - center, w) for part in self.parts)
        return functools.reduce(functions.maximum, each)

    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        return np.asarray(sum(part._multipoles(degree, origin, radius) for part in self.parts))

    def _gravity(self, points: Array) -> tuple[Array, Array]:
        center = self.center_of_mass
        each = zip(*(part._gravity(points + center - part.center_of_mass) for part in self.parts), strict=True)
        potential, attraction = (np.sum(values, axis=0) for values in each)
        return potential, attraction

    def _placed(self, position: Array, matrix: Array) -> Assembly:
        return Assembly([part._placed(position, matrix) for part in self.parts])
