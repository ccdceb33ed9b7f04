"""Integrated variables of a run: rows at the times, the arrays that receive them, and dense output."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.immutable import cached_property
from poinsot.integration.state_vector import StateVector, blocks_of
from poinsot.kinematics.state import Phase
from poinsot.quantities import Array
from poinsot.taylor.dense_output import StoredSteps

__all__ = ["Action", "DenseOutput", "Memory", "OneMotion", "Rows", "Sink"]

VARIATIONS = ("vectors", "pairs", "exponents")
"""Names of the rows of tangent vectors, of second derivatives and of binary exponents."""

Members = NDArray[np.int_]
Time = TypeVar("Time", bound=float | Array)


class Rows:
    """Integrated variables along times by name, converted on access.

    The names are the names of a phase (`quaternion`, the integrated momenta, the variables of parts), `orbits` for the
    variables of all orbits, and `vectors`, `pairs` and `exponents` of variations. Shapes: (members, n, ...), or
    (n, ...) for one body.
    """

    def __init__(self, variables: StateVector, times: Array, values: Array) -> None:
        self._variables, self._times, self._values = variables, times, values

    @cached_property
    def phase(self) -> Phase:
        """Quaternion, momenta and variables of parts."""
        return self._variables.to_phase(self._times, self._values)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Numbers of the two vectors that each of the `pairs` belongs to."""
        return self._variables.variations.pairs if self._variables.variations else []

    @cached_property
    def _variations(self) -> dict[str, Array]:
        variations, values = self._variables.variations, self._values[..., self._variables.tangent_vectors]
        return dict(zip(VARIATIONS, variations.read(values), strict=True)) if variations else {}

    def __getitem__(self, name: str) -> Array:
        if name == "orbits":
            return self._values[..., self._variables.along_orbits]
        return self._variations[name] if name in VARIATIONS else self.phase[name]


class Sink(Protocol):
    """Receiver of rows."""

    def take(self, members: Members, times: Array, rows: Rows) -> None:
        """Store the rows of some members, shapes (members, n, ...), NaN at times that they did not reach.

        Several threads call it, each for other members. Rows of one body have shape (n, ...), at the times reached.
        """


class Memory:
    """Arrays of the integrated variables of an ensemble, NaN at times that a member did not reach.

    Parameters
    ----------
    variables : StateVector
    members : int
    times : array (n,)
    **others : tuple of int
        Further rows: name -> shape.
    """

    def __init__(self, variables: StateVector, members: int, times: Array, **others: tuple[int, ...]) -> None:
        self.times, shape = times, (members, times.size)
        self.phase = {name: np.full((*shape, size), np.nan) for name, size in variables.sizes.items()}
        self.rows = self.phase | {name: np.full((*shape, *own), np.nan) for name, own in others.items()}

    def take(self, members: Members, times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Store the rows of some members."""
        for name, array in self.rows.items():
            array[members] = rows[name]


class OneMotion:
    """Rows of one body at the times that it reached, converted on access."""

    times: Array
    rows: Rows

    @property
    def phase(self) -> Phase:
        """Integrated variables."""
        return self.rows.phase

    def take(self, members: Members, times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Store the rows."""
        self.times, self.rows = times, rows


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

    @cached_property
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
