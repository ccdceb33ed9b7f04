"""The axes along which an integration holds the attitude: fixed in space, or carried along by an orbit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.functions import Scalar, Vector
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.sky import Sky

__all__ = ["SPACE_AXES", "Axes", "SpaceAxes"]

Array = NDArray[np.float64]


class Axes(Parametric, ABC):
    """Axes with `size` variables of their own, which are integrated along with the body."""

    size = 0

    @abstractmethod
    def start(self, time: Array) -> Array:
        """Return the variables at a time; shape (..., size)."""

    @abstractmethod
    def sky(self, time: Scalar, variables: Any) -> Sky:
        """Return the world at an instant, its vectors along these axes."""

    @abstractmethod
    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:
        """Return the time derivatives of the variables."""

    @abstractmethod
    def omega(self, time: Scalar, variables: Any) -> Vector | None:
        """Return the angular velocity of the axes, along themselves; None if they are at rest."""

    @abstractmethod
    def quaternion(self, time: Array, variables: Array) -> Array:
        """Return the unit quaternions axes -> space; shape (..., 4)."""


class SpaceAxes(Axes):
    """The space axes themselves."""

    def start(self, time: Array) -> Array:  # noqa: D102
        return np.empty((*np.shape(time), 0))

    def sky(self, time: Scalar, variables: Any) -> Sky:  # noqa: ARG002, D102
        return Sky(time)

    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:  # noqa: ARG002, D102
        return []

    def omega(self, time: Scalar, variables: Any) -> Vector | None:  # noqa: ARG002, D102
        return None

    def quaternion(self, time: Array, variables: Array) -> Array:  # noqa: ARG002, D102
        return np.array([1.0, 0.0, 0.0, 0.0])


SPACE_AXES = SpaceAxes()
