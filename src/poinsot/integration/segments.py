"""The legs of a run from one knot of its tables to the next, each with the parameters of its piece."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.tasks import Status

__all__ = ["Legs"]

BLOCK, KEPT = 256, 1024
"""Pieces whose parameters are computed together where all tasks are of one body, and how many are kept."""

Integers = NDArray[np.int_]


class Legs:
    """The pieces that tasks go through.

    Parameters
    ----------
    knots : array (k,)
    tasks : structured array (n,)
        Their ends and parameters are set to those of their first leg.
    members, steps : arrays (n,)
        Of each task, 1 or -1 for its direction.
    origins : array (n,)
        The times at which they start.
    parameters : callable
        Times and members to their parameters between the knots around, shape (m, parameters).
    held : list of int
        The parameters that stay as at the start.
    alike : bool
        Whether all tasks are of one body.
    """

    def __init__(
        self,
        knots: NDArray[Any],
        tasks: NDArray[Any],
        members: Integers,
        steps: Integers,
        origins: NDArray[Any],
        parameters: Callable[[NDArray[Any], Integers], NDArray[Any]],
        held: list[int],
        alike: bool,
    ) -> None:
        self._knots, self._tasks, self._members, self._steps = knots, tasks, members, steps
        self._parameters, self._alike, self._known = parameters, alike, dict[int, NDArray[Any]]()
        self._ends, pieces = tasks["end"].copy(), [knots.searchsorted(origins, side) for side in ("right", "left")]
        self._pieces = np.clip(np.where(steps > 0, *pieces), 1, knots.size - 1)
        self._held: list[int] = []
        self._enter(np.arange(members.size))
        self._held, self._values = held, tasks["parameters"][:, held]

    def go_on(self, stop: bool) -> Integers:
        """Return the tasks that are done with a leg but not with their last one: in their next one unless all stop."""
        through: Integers = np.flatnonzero((self._tasks["status"] == Status.DONE) & (self._tasks["end"] != self._ends))
        self._tasks["status"][through] = Status.UNDER_WAY
        if not stop and through.size:
            self._pieces[through] += self._steps[through]
            self._enter(through)
        return through

    def _enter(self, chosen: Integers) -> None:
        """Set the parameters of tasks, and where they leave their piece; the first and the last one have no end."""
        pieces, knots, ends = self._pieces[chosen], self._knots, self._ends[chosen]
        if self._alike:
            parameters = np.array([self._of_piece(piece) for piece in pieces.tolist()])
        else:
            parameters = self._computed(pieces, self._members[chosen])
        if self._held:
            parameters[:, self._held] = self._values[chosen]
        self._tasks["parameters"][chosen], self._tasks["branches"][chosen] = parameters, np.nan
        later = np.minimum(ends, np.where(pieces < knots.size - 1, knots[pieces], np.inf))
        earlier = np.maximum(ends, np.where(pieces > 1, knots[pieces - 1], -np.inf))
        self._tasks["end"][chosen] = np.where(self._steps[chosen] > 0, later, earlier)

    def _computed(self, pieces: Integers, members: Integers) -> NDArray[Any]:
        return self._parameters(0.5 * (self._knots[pieces - 1] + self._knots[pieces]), members)

    def _of_piece(self, piece: int) -> NDArray[Any]:
        if piece not in self._known:
            first = piece // BLOCK * BLOCK
            block = np.arange(max(first, 1), min(first + BLOCK, self._knots.size))
            if len(self._known) >= KEPT:
                self._known.clear()
            self._known.update(zip(block.tolist(), self._computed(block, np.zeros_like(block)), strict=True))
        return self._known[piece]
