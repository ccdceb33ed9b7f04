"""Times of the samples of parts that jump."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.part import Jump, Part
from poinsot.taylor.draws import key_of

__all__ = ["Clock"]

Array = NDArray[Any]


class Clock:
    """Samples of members at the times number * period + offset, rounded twice.

    Parameters
    ----------
    parts : sequence of Part
        Those that jump.
    numbers : array (members,)
        The numbers of the members, which determine their noise.
    jumped : mapping
        The name of a part to an array (members,) of truth values: whether its sample at the start is done.
    """

    def __init__(self, parts: Sequence[Part], numbers: Array, jumped: Mapping[str, Array]) -> None:
        jumps = [part.jump for part in parts if part.jump is not None]
        self.periods, self.offsets = (
            np.array([np.broadcast_to(x, numbers.shape) for x in each], dtype=float).T
            for each in ([jump.period for jump in jumps], [jump.offset for jump in jumps])
        )
        seeds = np.array([np.broadcast_to(jump.seed, numbers.shape) for jump in jumps], dtype=float).T
        self.keys = key_of(seeds, numbers[:, None])
        done = [jumped.get(part.name, False) for part in parts if part.jump is not None]
        self._jumped = np.array([np.broadcast_to(each, numbers.shape) for each in done]).T

    def first(self, times: Array, members: Array) -> Array:
        """Return the numbers of the first samples of members that start at times, shape (n, jumps)."""
        samples = Jump(self.periods[members], self.offsets[members])
        found: Array = samples.first(times[:, None])
        return found + (self._jumped[members] & samples.falls_on(times[:, None]))

    def set(self, tasks: Array, times: Array, members: Array) -> None:
        """Set the first samples of tasks of members that start at times."""
        tasks["numbers"], tasks["keys"] = self.first(times, members), self.keys[members].view(np.int64)
        tasks["periods"], tasks["offsets"] = self.periods[members], self.offsets[members]
