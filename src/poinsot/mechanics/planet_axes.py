"""Axes fixed in a planet, as formulas of fields that turn with it see them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable

from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Dated
from poinsot.mechanics.frame import Frame

__all__ = ["PlanetAxes"]


class PlanetAxes(Dated, Frame):
    """Axes fixed in a planet: a frame, and formulas of the time; `RotationModel` is one."""

    @abstractmethod
    def to_planet(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        """Return the components along the axes of the planet of a vector given in space."""

    @abstractmethod
    def to_space(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        """Return the components in space of a vector given along the axes of the planet."""
