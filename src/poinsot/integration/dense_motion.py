"""A motion at any time, from the Taylor polynomials of its steps and the actions of events."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.state_vector import StateVector, blocks_of
from poinsot.mechanics.state import Phase
from poinsot.taylor.dense_output import StoredSteps

__all__ = ["Action", "DenseOutput"]

Array = NDArray[np.float64]


class Action(NamedTuple):
    """The variables after an event has acted at a time; times that differ by no more than `near` are the same.

    Attributes
    ----------
    since, until : float
        The times of the last sample before the action and of the first one after it: rows at earlier times are the
        variables before both, and rows at later times those after both.
    """

    time: Any
    near: Any
    row: Array
    since: Any = -np.inf
    until: Any = np.inf

    def at(self, times: Any) -> Any:
        """Return whether rows at times are the variables after the action."""
        return (np.abs(times - self.time) <= self.near) & (times >= self.since) & (times < self.until)


class DenseOutput:
    """A motion at any time between the two that it has reached; what jumps is right-continuous.

    Parameters
    ----------
    variables : StateVector
    origin : float
        The time of the start.
    start : array (size,)

    Attributes
    ----------
    last : array (size,) or None
        The variables at the latest time, of a motion that may jump there.
    actions : sequence of Action
        The actions of events in each direction, in their order.
    """

    def __init__(self, variables: StateVector, origin: float, start: Array) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.last: Array | None = None
        self.actions: Sequence[Action] = ()
        self.parts: Mapping[bool, StoredSteps] = {}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """The earliest time and the latest."""
        return self.reached.get(False, self._origin), self.reached.get(True, self._origin)

    def __call__(self, times: Array) -> Phase:
        """Return q and the momenta."""
        rows = self._at(times)
        if self.actions:
            self._put_actions(times, rows)
        for block in blocks_of(times.size):
            self._variables.make_physical(times[block], rows[block])
        return self._variables.phase_of(rows)

    def _put_actions(self, times: Array, rows: Array) -> None:
        """Put the variables after actions into rows at their times."""
        known = self._after_actions
        behind = known.time.searchsorted(times)
        for places in (np.maximum(behind - 1, 0), np.minimum(behind, known.time.size - 1)):
            some = Action(*(each[places] for each in known))
            here = some.at(times)
            rows[here] = some.row[here]

    @functools.cached_property
    def _after_actions(self) -> Action:
        """The last ones of actions at one time, by times that rise."""
        last = [
            one
            for one, following in itertools.zip_longest(self.actions, self.actions[1:])
            if following is None or abs(following.time - one.time) > following.near
        ]
        order = np.argsort([one.time for one in last])
        return Action(*(np.array(each, dtype=float)[order] for each in zip(*last, strict=True)))

    def _at(self, times: Array) -> Array:
        """Return the variables."""
        later, earlier = self.parts[True], self.parts[False]
        if self.last is not None:
            there = (times == self.reached[True])[:, None]
            return np.where(there, self.last, self._start if later.empty else later.at(times, "right"))
        if earlier.empty and not later.empty:
            return later.at(times)
        out = np.empty((times.size, self._variables.size))
        for part, chosen in ((later, times >= self._origin), (earlier, times < self._origin)):
            if np.any(chosen):
                out[chosen] = self._start if part.empty else part.at(times[chosen])
        return out
