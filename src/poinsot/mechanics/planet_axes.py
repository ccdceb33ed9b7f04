"""Axes fixed in a planet, as formulas of fields that turn with it see them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.functions import Scalar, Vector
from poinsot.kinematics.frame import Frame
from poinsot.mechanics.environment import Dated
from poinsot.quantities import Times
from poinsot.records.members import of_scalars, of_times

__all__ = ["PlanetAxes"]


class PlanetAxes(Dated, Frame):
    """Axes fixed in a planet: a frame, and formulas of the time; `RotationModel` is one."""

    @of_times
    @abstractmethod
    @override
    def quaternion(self, time: Times) -> NDArray[np.float64]: ...

    @of_times
    @abstractmethod
    @override
    def omega_space(self, time: Times) -> NDArray[np.float64]: ...

    @of_scalars
    @abstractmethod
    def to_planet(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        """Return the components along the axes of the planet of a vector given in space."""

    @of_scalars
    @abstractmethod
    def to_space(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        """Return the components in space of a vector given along the axes of the planet."""
