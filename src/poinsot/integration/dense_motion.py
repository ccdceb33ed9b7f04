"""Motion at any time, from the Taylor polynomials of its steps and the actions of events."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.state_vector import StateVector, blocks_of
from poinsot.mechanics.state import Phase
from poinsot.taylor.dense_output import StoredSteps

__all__ = ["Action", "DenseOutput"]

Array = NDArray[np.float64]
Time = TypeVar("Time", bound=float | Array)


class Action(NamedTuple, Generic[Time]):
    """Variables after the action of an event at a time; times that differ by at most `near` are equal.

    Attributes
    ----------
    since, until : float
        The times of the last sample before the action and of the first sample after it. Rows at earlier times contain
        the variables before both, and rows at later times the variables after both.
    """

    time: Time
    near: Time
    row: Array
    since: Time
    until: Time

    def at(self, times: float | Array) -> NDArray[np.bool_]:
        """Return True at times whose rows contain the variables after the action."""
        return (np.abs(times - self.time) <= self.near) & (times >= self.since) & (times < self.until)


class DenseOutput:
    """Motion at any time between its ends; variables that jump are right-continuous.

    Parameters
    ----------
    variables : StateVector
    origin : float
        The time of the start.
    start : array (size,)

    Attributes
    ----------
    last : array (size,) or None
        The variables at the latest time, for a motion that may jump there.
    actions : sequence of Action
        The actions of events in each direction, in their order.
    """

    def __init__(self, variables: StateVector, origin: float, start: Array) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.last: Array | None = None
        self.actions: Sequence[Action[float]] = ()
        self.parts: Mapping[bool, StoredSteps] = {}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """Earliest and latest time."""
        return self.reached.get(False, self._origin), self.reached.get(True, self._origin)

    def __call__(self, times: Array) -> Phase:
        """Return quaternion, momenta and variables of parts at times."""
        rows = self._at(times)
        if self.actions:
            self._put_actions(times, rows)
        for block in blocks_of(times.size):
            self._variables.make_physical(times[block], rows[block])
        return self._variables.phase_of(rows)

    def _put_actions(self, times: Array, rows: Array) -> None:
        """Write the variables after actions into the rows at their times."""
        known = self._after_actions
        behind = known.time.searchsorted(times)
        for places in (np.maximum(behind - 1, 0), np.minimum(behind, known.time.size - 1)):
            some = Action(*(each[places] for each in known))
            here = some.at(times)
            rows[here] = some.row[here]

    @functools.cached_property
    def _after_actions(self) -> Action[Array]:
        """Last action at each time, in the order of time."""
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
