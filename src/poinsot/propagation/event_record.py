"""What happened on the way of a motion: the times of its events, and the states there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.engine.event_detection import Recorded
from poinsot.engine.state_vector import StateVector
from poinsot.html_text import Summarized, rounded, told
from poinsot.mechanics.event import Event
from poinsot.mechanics.parameters import described
from poinsot.mechanics.state import Phase, State, changed, state_of
from poinsot.mechanics.system import System
from poinsot.propagation.selection import Chosen, numbers_of_members

__all__ = ["EventRecord", "checked_events", "crossings", "crossings_of_members"]

Array = NDArray[Any]

BLOCK = 65_536
"""Events converted together."""


@dataclass(frozen=True, eq=False, repr=False)
class EventRecord(Summarized):
    """The zeros of one event along a motion, in the order of its times; of an ensemble member after member.

    Attributes
    ----------
    event : Event
    system : System
    times : array (k,)
    states : State
        Those at these times; of an event that acts, before it does.
    directions : array (k,)
        1 where the value rises with time, -1 where it falls.
    members : array (k,)
        Whose they are; zeros for one body.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.6, 2.5))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.1))
    >>> motion = pt.propagate(pt.System(body), start, [20.0], events=[pt.events.SpinFlip((0, 1, 0))])
    >>> motion.events[0]
    EventRecord of SpinFlip(axis=[0.0, 1.0, 0.0]): 1
      times: 7.97365
      directions: 0 rising, 1 falling
    """

    event: Event
    system: System
    times: Array
    states: State
    directions: Array
    members: Array

    def __len__(self) -> int:
        return self.times.size

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        rising, falling = (int(np.sum(self.directions == sign)) for sign in (1, -1))
        return f"EventRecord of {rounded(repr(self.event))}: {len(self)}", {
            "times": told(self.times, self.system.units["time"]) or "none",
            "directions": f"{rising} rising, {falling} falling" if len(self) else "",
            "members": f"{np.unique(self.members).size}" if np.any(self.members) else "",
        }

    @checked
    def member(self, member: int) -> EventRecord:
        """Return those of one member."""
        chosen = self.members == member
        states = state_of(changed(self.states.phase, lambda x: x[chosen]), self.times[chosen])
        return EventRecord(
            self.event, self.system, self.times[chosen], states, self.directions[chosen], self.members[chosen]
        )

    @property
    def omega_body(self) -> Array:
        """The inertial angular velocity along the body axes; shape (k, 3)."""
        numbers = (number[self.members] if number.ndim else number for number in self.system.numbers)
        return np.asarray(self.system.with_numbers(numbers).omega_body(self.states))


def crossings_of_members(found: EventRecord, members: Chosen, system: System) -> EventRecord:
    """Return those of some members, numbered anew, with the numbers of their event; `system` is theirs."""
    whose = np.atleast_1d(members)
    first, last = np.searchsorted(found.members, whose, "left"), np.searchsorted(found.members, whose, "right")
    counts = last - first
    rows = np.repeat(last - np.cumsum(counts), counts) + np.arange(np.sum(counts))
    states = state_of(changed(found.states.phase, lambda x: x[rows]), found.times[rows])
    event, again = numbers_of_members(found.event, members), np.repeat(np.arange(whose.size), counts)
    return EventRecord(event, system, found.times[rows], states, found.directions[rows], again)


def checked_events(events: Any) -> tuple[Event, ...]:
    """Return the events, or raise a TypeError."""
    if isinstance(events, Event) or not isinstance(events, Sequence):
        raise TypeError(f"events must be a list of Event, got {described(events)}.")
    for i, event in enumerate(events):
        if not isinstance(event, Event):
            raise TypeError(f"events must be a list of Event, but events[{i}] is {described(event)}.")
    return tuple(events)


def crossings(
    system: System, events: Sequence[Event], variables: StateVector, found: list[tuple[int, Recorded]], rising: bool
) -> tuple[EventRecord, ...]:
    """Return what happened of each event, from pairs of a member and a record."""
    members = np.array([member for member, _ in found], dtype=int)
    numbers = np.array([record[0] for _, record in found], dtype=int)
    times = np.array([record[2] for _, record in found], dtype=float)
    directions = np.array([record[3] for _, record in found], dtype=int)
    rows = np.empty((len(found), variables.size))
    for i, (_, record) in enumerate(found):
        rows[i] = record[4]
    blocks = [slice(first, first + BLOCK) for first in range(0, max(len(found), 1), BLOCK)]
    parts = [_phase(variables, members[block], times[block], rows[block]) for block in blocks]
    phase = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    out = []
    for number, event in enumerate(events):
        mine = np.flatnonzero(numbers == number)
        mine = mine[np.lexsort((times[mine] if rising else -times[mine], members[mine]))]
        states = state_of({name: values[mine] for name, values in phase.items()}, times[mine])
        out.append(EventRecord(event, system, times[mine], states, directions[mine], members[mine]))
    return tuple(out)


def _phase(variables: StateVector, members: Array, times: Array, rows: Array) -> Phase:
    if variables.of_one:
        return variables.to_phase(times, rows)
    return changed(variables.of_members(members).to_phase(times[:, None], rows[:, None, :]), lambda x: x[:, 0])
