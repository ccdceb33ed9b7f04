"""The axes along which an integration holds the attitude: fixed in space, or carried along by an orbit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Axes, Environment, Orbit

__all__ = ["SPACE_AXES", "SpaceAxes", "TrackingAxes", "TrackingEnvironment"]

Array = NDArray[np.float64]


class SpaceAxes(Axes):
    """The space axes themselves."""

    @override
    def start(self, time: Array) -> Array:
        return np.empty((*np.shape(time), 0))

    @override
    def environment(self, time: Scalar, variables: Any) -> Environment:
        return Environment(time)

    @override
    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:
        return []

    @override
    def omega(self, time: Scalar, variables: Any) -> Vector | None:
        return None

    @override
    def quaternion(self, time: Array, variables: Array) -> Array:
        return np.array([1.0, 0.0, 0.0, 0.0])

    def along(self, orbits: Sequence[Orbit]) -> SpaceAxes:  # noqa: ARG002
        """Return the axes with the variables of the orbits of another system, shared in the same way."""
        return self


SPACE_AXES = SpaceAxes()


class TrackingAxes(SpaceAxes):
    """The space axes, with the variables of an orbit that is tracked, and of others.

    Parameters
    ----------
    orbit : Orbit
    place : int
        Of the orbit among those of the system.
    offset : int
        Where its variables begin: behind those of the others, or among them where it shares the path of another.
    others : SpaceAxes
        `SPACE_AXES`, or those that track the other orbits.
    """

    orbit: Orbit
    place: int
    offset: int
    others: SpaceAxes

    @property
    def own(self) -> Axes:
        """The axes of the orbit."""
        axes = self.orbit.axes
        assert axes is not None  # noqa: S101
        return axes

    @property
    @override
    def size(self) -> int:  # type: ignore[override]
        return self.others.size + (0 if self._shares else self.own.size)

    @property
    def _shares(self) -> bool:
        return self.offset < self.others.size

    @override
    def start(self, time: Array) -> Array:
        others = self.others.start(time)
        return others if self._shares else np.concatenate([others, self.own.start(time)], axis=-1)

    @override
    def environment(self, time: Scalar, variables: Any) -> Environment:
        return TrackingEnvironment(time, self, variables)

    @override
    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:
        others = self.others.rates(time, variables[: self.others.size])
        return others if self._shares else [*others, *self.own.rates(time, variables[self.offset :])]

    @override
    def environment_in_space(self, orbit: Orbit, time: Scalar, variables: Any) -> Environment | None:
        if orbit is not self.orbit:
            return self.others.environment_in_space(orbit, time, variables)
        return self.own.environment_in_space(orbit, time, variables[self.offset : self.offset + self.own.size])

    @override
    def along(self, orbits: Sequence[Orbit]) -> TrackingAxes:
        return TrackingAxes(orbits[self.place], self.place, self.offset, self.others.along(orbits))


class TrackingEnvironment(Environment):
    """The world along the space axes: each orbit by its variables where it has some, else by its formulas."""

    def __init__(self, time: Scalar, axes: Axes, variables: Any) -> None:
        super().__init__(time)
        self._axes, self._variables = axes, variables

    def _of(self, orbit: Orbit) -> Environment:
        return self._axes.environment_in_space(orbit, self.time, self._variables) or Environment(self.time)

    @override
    def position(self, orbit: Orbit) -> Vector:
        return self._of(orbit).position(orbit)

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        return self._of(orbit).velocity(orbit)

    @override
    def inverse_distance(self, orbit: Orbit) -> Scalar:
        return self._of(orbit).inverse_distance(orbit)

    @override
    def direction(self, orbit: Orbit) -> Vector:
        return self._of(orbit).direction(orbit)
