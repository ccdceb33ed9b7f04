"""Variables that get new values at samples: the formulas of these, and the times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.draws import key_of
from poinsot.algebra.program import Node
from poinsot.mechanics.part import Jump, Part

__all__ = ["Clock", "Jumps", "Update"]

Array = NDArray[Any]


class Update(NamedTuple):
    """The new values of some variables, at their places, and the symbols of the uniform numbers drawn for them."""

    places: list[int]
    values: list[Any]
    draws: list[Node]


@dataclass(frozen=True, eq=False)
class Jumps:
    """The formulas of all updates, in the order in which they are done at one time.

    Parameters
    ----------
    own : list of Node
        The variables and, behind them, the time.
    updates : list of Update
    constants : list of Node
        What they need that is the same all the way: parameters of a kernel, the first of them number `first`.
    first : int
    """

    own: list[Node]
    updates: list[Update]
    constants: list[Node]
    first: int


class Clock:
    """The samples of members, at the times number * period + phase, rounded twice.

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
        self.periods, self.phases = (
            np.array([np.broadcast_to(x, numbers.shape) for x in each], dtype=float).T
            for each in ([jump.period for jump in jumps], [jump.phase for jump in jumps])
        )
        seeds = np.array([np.broadcast_to(jump.seed, numbers.shape) for jump in jumps], dtype=float).T
        self.keys = key_of(seeds, numbers[:, None])
        done = [jumped.get(part.name, False) for part in parts if part.jump is not None]
        self._jumped = np.array([np.broadcast_to(each, numbers.shape) for each in done]).T

    def first(self, times: Array, members: Array) -> Array:
        """Return the numbers of the first samples of members that start at times, shape (n, jumps)."""
        samples = Jump(self.periods[members], self.phases[members])
        found: Array = samples.first(times[:, None])
        return found + (self._jumped[members] & samples.falls_on(times[:, None]))

    def times(self, numbers: Array, members: Array) -> Array:
        """Return the times of samples of members, shape (..., jumps)."""
        times: Array = numbers * self.periods[members] + self.phases[members]
        return times

    def set(self, tasks: Array, times: Array, members: Array) -> None:
        """Let tasks of members that start at times begin with their first samples."""
        tasks["numbers"], tasks["keys"] = self.first(times, members), self.keys[members].view(np.int64)
        tasks["periods"], tasks["phases"] = self.periods[members], self.phases[members]
