"""Integrated paths of orbits without a closed form, provided by the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from poinsot.mechanics.environment import OrbitBlock

__all__ = ["Solutions", "engine"]


class Solutions(Protocol):
    """The functions that the engine hands down."""

    def path(self, block: OrbitBlock, start: Sequence[Any]) -> Callable[[Any], NDArray[Any]]:
        """Return a function of the time since the start: the variables of a block, first axis, by their rates."""


engine: Callable[[], Solutions]
"""Imports the engine; set by the package itself, which stands above both."""
