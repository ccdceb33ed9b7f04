"""The world around the body: where it is with respect to what attracts it, and the instant."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.errors import scalar
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.parameters import Parametric

if TYPE_CHECKING:
    from poinsot.mechanics.frame import Frame

__all__ = ["SPACE_AXES_UNNAMED", "Axes", "Environment", "Orbit", "frames_of"]

SPACE_AXES_UNNAMED = "space axes"
"""The reference frame of an orbit whose axes have no other name than the user's."""


OF_DATE = "TEME"
"""Axes that move among the stars, by 50 arcseconds a year: nobody means them by chance."""


class Orbit(Parametric, ABC):
    """The position of the body relative to one attractor, space axes; it owns that attractor's `mu`.

    Subclasses declare a field `mu` and give position and velocity as formulas of the time.
    """

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        for name, formula in list(vars(cls).items()):
            if name.endswith("_at") and not name.startswith("_"):
                setattr(cls, name, _of_time(formula))

    if TYPE_CHECKING:

        @property
        def mu(self) -> Any:
            """Gravitational parameter of the attractor."""

    @abstractmethod
    def position_at(self, time: Scalar) -> Vector:
        """Return the three components of the position of the body from the attractor."""

    @abstractmethod
    def velocity_at(self, time: Scalar) -> Vector:
        """Return the three components of its velocity."""

    def inverse_distance_at(self, time: Scalar) -> Scalar:
        """Return one over the length of the position."""
        return 1 / functions.norm(self.position_at(time))

    @property
    def closed_form(self) -> bool:
        """Whether the formulas run on symbols."""
        return True

    @property
    def tracked(self) -> bool:
        """Whether a kernel integrates the variables of `axes` along also in the space axes."""
        return not self.closed_form

    @property
    def sample_time(self) -> Any:
        """A time at which the attractor is felt, for trials of formulas; shape () or (members,)."""
        return 0.0

    @property
    def sample_reach(self) -> Any:
        """How far from that time formulas may be tried; shape () or (members,)."""
        return np.inf

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time at which the body's place is known."""
        return -np.inf, np.inf

    @property
    def reference_frame(self) -> str:
        """The name of the space axes."""
        return SPACE_AXES_UNNAMED

    @property
    def origin(self) -> str:
        """The name of the attractor."""
        return "attractor"

    @property
    def calendar(self) -> Any:
        """What times mean as dates; None if they are no more than numbers."""
        return None

    @property
    def axes(self) -> Axes | None:
        """Axes carried along by the orbit, cheaper to integrate in than the space axes; None if it has none."""
        return None

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """The angular velocity, space axes, about which the position turns unchanged; None if it does not."""
        return None

    @property
    def directions(self) -> dict[str, NDArray[np.float64]]:
        """Directions in space that the orbit singles out, by name: candidates for an integral."""
        return {}

    @property
    def frame(self) -> Frame:
        """The axes that follow this orbit."""
        raise ValueError(f"orbit must move to have a frame, but {type(self).__name__} has no velocity.")


def _of_time(formula: Callable[..., Any]) -> Callable[..., Any]:
    """Return a formula of the time that checks it."""

    @functools.wraps(formula)
    def checked(self: Any, time: Any) -> Any:
        return formula(self, scalar("time", time))

    return checked


def frames_of(orbits: Iterable[Orbit]) -> list[str]:
    """Return the names of the space axes of orbits: without a name they go with any but those of date."""
    names = dict.fromkeys(orbit.reference_frame for orbit in orbits)
    if OF_DATE not in names:
        names.pop(SPACE_AXES_UNNAMED, None)
    return list(names)


class Environment:
    """The world at one instant, as a formula sees it.

    Parameters
    ----------
    time : scalar
        The time.
    """

    def __init__(self, time: Any) -> None:
        self.time = scalar("time", time)

    def position(self, orbit: Orbit) -> Vector:
        """Return the position of the body from the attractor of that orbit, space axes."""
        return orbit.position_at(self.time)

    def velocity(self, orbit: Orbit) -> Vector:
        """Return the velocity of the body relative to the attractor of that orbit, space axes."""
        return orbit.velocity_at(self.time)

    def inverse_distance(self, orbit: Orbit) -> Scalar:
        """Return 1 / r of the body from the attractor of that orbit."""
        return orbit.inverse_distance_at(self.time)

    def direction(self, orbit: Orbit) -> Vector:
        """Return the unit vector from the attractor of that orbit to the body, space axes."""
        inverse = self.inverse_distance(orbit)
        return Vector(x * inverse for x in self.position(orbit))


class Axes(Parametric, ABC):
    """Axes with `size` variables of their own, which are integrated along with the body."""

    size = 0

    @abstractmethod
    def start(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the variables at a time; shape (..., size)."""

    @abstractmethod
    def environment(self, time: Scalar, variables: Any) -> Environment:
        """Return the world at an instant, its vectors along these axes."""

    @abstractmethod
    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:
        """Return the time derivatives of the variables."""

    @abstractmethod
    def omega(self, time: Scalar, variables: Any) -> Vector | None:
        """Return the angular velocity of the axes, along themselves; None if they are at rest."""

    @abstractmethod
    def quaternion(self, time: NDArray[np.float64], variables: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the unit quaternions axes -> space; shape (..., 4)."""

    def environment_in_space(self, orbit: Orbit, time: Scalar, variables: Any) -> Environment | None:  # noqa: ARG002
        """Return the world along the space axes for an orbit that these axes follow; None if they follow none."""
        return None
