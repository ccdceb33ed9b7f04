"""What happened on the way of a motion: the times of its events, and the states there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.engine.event_detection import Recorded
from poinsot.engine.state_vector import Coordinates
from poinsot.mechanics.event import Event
from poinsot.mechanics.parameters import described
from poinsot.mechanics.state import State, computed_state
from poinsot.mechanics.system import System

__all__ = ["Crossings", "checked_events", "crossings"]

Array = NDArray[Any]

BLOCK = 65_536
"""Events converted together."""


@dataclass(frozen=True, eq=False, repr=False)
class Crossings:
    """The zeros of one event along a motion, in the order of its times; of an ensemble member after member.

    Attributes
    ----------
    event : Event
    system : System
    times : array (k,)
    states : State
        Those at these times; of an event that acts, before it does.
    slopes : array (k,)
        1 where the value rises with time, -1 where it falls.
    members : array (k,)
        Whose they are; zeros for one body.
    """

    event: Event
    system: System
    times: Array
    states: State
    slopes: Array
    members: Array

    def __len__(self) -> int:
        return self.times.size

    def __repr__(self) -> str:
        return f"Crossings of {self.event!r}: {len(self)}"

    @checked
    def of(self, member: int) -> Crossings:
        """Return those of one member."""
        chosen = self.members == member
        states = computed_state(
            self.states.quaternion[chosen], self.states.conjugate_momenta[chosen], self.times[chosen]
        )
        return Crossings(self.event, self.system, self.times[chosen], states, self.slopes[chosen], self.members[chosen])

    @property
    def omega_body(self) -> Array:
        """The inertial angular velocity along the body axes; shape (k, 3)."""
        numbers = (number[self.members] if number.ndim else number for number in self.system.numbers)
        return np.asarray(self.system.with_numbers(numbers).omega_body(self.states))


def checked_events(events: Any) -> tuple[Event, ...]:
    """Return the events, or raise a TypeError."""
    if isinstance(events, Event) or not isinstance(events, Sequence):
        raise TypeError(f"events must be a list of Event, got {described(events)}.")
    for i, event in enumerate(events):
        if not isinstance(event, Event):
            raise TypeError(f"events must be a list of Event, but events[{i}] is {described(event)}.")
    return tuple(events)


def crossings(
    system: System, events: Sequence[Event], variables: Coordinates, found: list[tuple[int, Recorded]], rising: bool
) -> tuple[Crossings, ...]:
    """Return what happened of each event, from pairs of a member and a record."""
    members = np.array([member for member, _ in found], dtype=int)
    numbers = np.array([record[0] for _, record in found], dtype=int)
    times = np.array([record[2] for _, record in found], dtype=float)
    slopes = np.array([record[3] for _, record in found], dtype=int)
    rows = np.empty((len(found), variables.size))
    for i, (_, record) in enumerate(found):
        rows[i] = record[4]
    q, Q = np.empty((2, len(found), 4))
    for first in range(0, len(found), BLOCK):
        part = slice(first, first + BLOCK)
        q[part], Q[part] = _canonical(variables, members[part], times[part], rows[part])
    out = []
    for number, event in enumerate(events):
        mine = np.flatnonzero(numbers == number)
        mine = mine[np.lexsort((times[mine] if rising else -times[mine], members[mine]))]
        states = computed_state(q[mine], Q[mine], times[mine])
        out.append(Crossings(event, system, times[mine], states, slopes[mine], members[mine]))
    return tuple(out)


def _canonical(variables: Coordinates, members: Array, times: Array, rows: Array) -> tuple[Array, Array]:
    if not (np.ndim(variables.scale) or any(np.ndim(number) for number in variables.axes.numbers)):
        return variables.to_canonical(times, rows)
    q, Q = variables.of_members(members).to_canonical(times[:, None], rows[:, None, :])
    return q[:, 0], Q[:, 0]
