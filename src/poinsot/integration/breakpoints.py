"""Times at which the motion of a task is interrupted: knots of tables, and samples of parts that jump."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from poinsot.functions import Scalar
from poinsot.integration.kernel_parameters import KernelParameters
from poinsot.mechanics.part import Jump, Part
from poinsot.quantities import Array
from poinsot.random_numbers import key_of
from poinsot.taylor.tasks import Status

__all__ = ["Clock", "Segments"]

PIECES_AT_A_TIME, MAX_STORED_PIECES = 256, 1024
"""Pieces whose parameters are computed together where all tasks belong to one body, and most pieces stored."""

Integers = NDArray[np.int_]


class Segments:
    """Pieces of tables that tasks pass through.

    Parameters
    ----------
    parameters : KernelParameters
    tasks : structured array (n,)
        Their ends and parameters are set for the first segment.
    members : array (n,)
        Member of each task.
    """

    def __init__(self, parameters: KernelParameters, tasks: NDArray[np.void], members: Integers) -> None:
        self._parameters, self._tasks, self._members = parameters, tasks, members
        self._knots, self._steps, self._known = parameters.problem.knots, tasks["stride"], dict[int, Array]()
        self._ends, origins = tasks["end"].copy(), parameters.origins[members]
        pieces = [self._knots.searchsorted(origins, side) for side in ("right", "left")]
        self._pieces = np.clip(np.where(self._steps > 0, *pieces), 1, self._knots.size - 1)
        self._held: list[int] = []
        self._enter(np.arange(members.size))
        self._held, self._values = parameters.held, tasks["parameters"][:, parameters.held]

    def go_on(self, stop: bool) -> Integers:
        """Return the tasks that have further segments; unless the run stops, they enter the next one."""
        through: Integers = np.flatnonzero((self._tasks["status"] == Status.DONE) & (self._tasks["end"] != self._ends))
        self._tasks["status"][through] = Status.UNDER_WAY
        if not stop and through.size:
            self._pieces[through] += self._steps[through]
            self._enter(through)
        return through

    def _enter(self, chosen: Integers) -> None:
        """Set the parameters of tasks, and the ends of their pieces; the first and the last piece have no end."""
        pieces, knots, ends = self._pieces[chosen], self._knots, self._ends[chosen]
        if self._parameters.origins.size == 1:
            parameters = np.array([self._of_piece(piece) for piece in pieces.tolist()])
        else:
            parameters = self._computed(pieces, self._members[chosen])
        if self._held:
            parameters[:, self._held] = self._values[chosen]
        self._tasks["parameters"][chosen], self._tasks["branches"][chosen] = parameters, np.nan
        later = np.minimum(ends, np.where(pieces < knots.size - 1, knots[pieces], np.inf))
        earlier = np.maximum(ends, np.where(pieces > 1, knots[pieces - 1], -np.inf))
        self._tasks["end"][chosen] = np.where(self._steps[chosen] > 0, later, earlier)

    def _computed(self, pieces: Integers, members: Integers) -> Array:
        return self._parameters.around(0.5 * (self._knots[pieces - 1] + self._knots[pieces]), members)

    def _of_piece(self, piece: int) -> Array:
        if piece not in self._known:
            first = piece // PIECES_AT_A_TIME * PIECES_AT_A_TIME
            block = np.arange(max(first, 1), min(first + PIECES_AT_A_TIME, self._knots.size))
            if len(self._known) >= MAX_STORED_PIECES:
                self._known.clear()
            self._known.update(zip(block.tolist(), self._computed(block, np.zeros_like(block)), strict=True))
        return self._known[piece]


class Clock:
    """Samples of members at the times number * period + offset, rounded twice.

    Parameters
    ----------
    parts : sequence of Part
        Parts that jump.
    numbers : array (members,)
        Numbers of the members, which determine their noise.
    jumped : mapping
        Name of a part -> mask (members,) of the members whose sample at the start is done.
    """

    def __init__(self, parts: Sequence[Part], numbers: Integers, jumped: Mapping[str, NDArray[np.bool_]]) -> None:
        jumps = {part.name: part.jump for part in parts if part.jump is not None}

        def of_members(values: Iterable[Scalar]) -> Array:
            return np.array([np.broadcast_to(np.asarray(x), numbers.shape) for x in values], dtype=np.float64).T

        self._periods = of_members(jump.period for jump in jumps.values())
        self._offsets = of_members(jump.offset for jump in jumps.values())
        self._keys = key_of(of_members(jump.seed for jump in jumps.values()), numbers[:, None]).view(np.int64)
        self._jumped = of_members(jumped.get(name, False) for name in jumps) > 0

    def set(self, tasks: NDArray[np.void], times: Array, members: Integers) -> None:
        """Set the first samples of tasks of members that start at times."""
        samples, times = Jump(self._periods[members], self._offsets[members]), times[:, None]
        tasks["numbers"] = samples.first(times) + (self._jumped[members] & samples.falls_on(times))
        tasks["keys"], tasks["periods"], tasks["offsets"] = self._keys[members], samples.period, samples.offset
