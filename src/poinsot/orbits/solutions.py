"""Orbits without a closed form: integrated paths and planetary theories, provided by the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from poinsot.mechanics.environment import OrbitBlock

__all__ = ["Solutions", "engine"]


class Solutions(Protocol):
    """The functions that the engine hands down."""

    def path(self, block: OrbitBlock, start: Sequence[Any]) -> Callable[[Any], NDArray[Any]]:
        """Return a function of the time since the start: the variables of a block, first axis, by their rates."""

    def planet_theory(self, number: int, threshold: float) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
        """Return VSOP2013: millennia of TDB from J2000, shape (1, n), to heliocentric positions, ICRF, au, (3, n)."""

    def moon_theory(self, threshold: float) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
        """Return ELP2000-82B: centuries of TDB from J2000, shape (1, n), to geocentric positions, km, (3, n)."""


engine: Callable[[], Solutions]
"""Imports the engine; set by the package itself, which stands above both."""
