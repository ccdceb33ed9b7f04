"""What happened on the way of a motion: the times of its events, and the states there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, rounded, told
from poinsot.functions import Scalar
from poinsot.integration.event_log import Recorded
from poinsot.integration.state_vector import StateVector
from poinsot.mechanics.event import Event
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.state import AnyState, Phase, changed, state_of
from poinsot.mechanics.system import System
from poinsot.printable import printable
from poinsot.propagation.selection import Chosen, numbers_of_members

__all__ = ["EventRecord", "EventSource", "EventsOfMembers", "KnownEvents", "StoredEvent", "crossings"]

Array = NDArray[Any]

BLOCK = 65_536
"""Events converted together."""


@dataclass(frozen=True, eq=False, repr=False)
class EventRecord(Summarized):
    """Record of all zeros of one event along a motion, in the order of the times, and for an ensemble member by member.

    Attributes
    ----------
    event : Event
        The event.
    system : System
        System of the motion.
    times : array (k,)
        Times of the zeros.
    states : State
        States at these times. For an event with `act`, the states before the action.
    directions : array (k,)
        1 if the value rises with time, -1 if it falls.
    members : array (k,)
        Number of the member of each zero; 0 for one body.

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
    states: AnyState
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
        """Return the record of one member."""
        return self._rows(self.members == member)

    def _rows(self, chosen: Array) -> EventRecord:
        """Return some of them, by their places or by which they are."""
        states = type(self.states).computed(changed(self.states.phase, lambda x: x[chosen]), self.times[chosen])
        own = self.times[chosen], states, self.directions[chosen], self.members[chosen]
        return EventRecord(self.event, self.system, *own)

    @property
    def omega_body(self) -> Array:
        """Inertial angular velocity at the events along the body axes, shape (k, 3)."""
        numbers = (number[self.members] if number.ndim else number for number in self.system.dynamics.numbers)
        return np.asarray(self.system.dynamics.with_numbers(numbers).omega_body(self.states))


class StoredEvent(Event):
    """An event of which a store has what it is called, and not its formula.

    Parameters
    ----------
    name : str
        Its kind.
    said : str
        How it shows itself.
    """

    name: str
    said: str

    @override
    def __repr__(self) -> str:
        return printable(self.said, kept="\n")

    @property
    @override
    def kind(self) -> str:
        return self.name

    @override
    def value(self, instant: Instant) -> Scalar:
        raise ValueError(f"{self.name} must have its formula to be computed, got none in the store.")


class EventSource(Protocol):
    """What has the records of events, which are made when they are asked for."""

    @property
    def watched(self) -> list[Event]:
        """The events."""

    @property
    def counts(self) -> list[int]:
        """How often each of them happened."""

    def of_members(self, members: Chosen | None) -> tuple[EventRecord, ...]:
        """Return what happened to some members, None: to all; others may be among them."""


class KnownEvents(NamedTuple):
    """Records that are in memory; see `EventSource`."""

    records: tuple[EventRecord, ...] = ()

    @property
    def watched(self) -> list[Event]:
        """The events."""
        return [found.event for found in self.records]

    @property
    def counts(self) -> list[int]:
        """How often each of them happened."""
        return [len(found) for found in self.records]

    def of_members(self, _: Chosen | None) -> tuple[EventRecord, ...]:
        """Return all of them."""
        return self.records


class EventsOfMembers:
    """Those of some members of an ensemble, numbered anew; see `EventSource`.

    Parameters
    ----------
    whole : EventSource
    members : int or array of int
    system : System
        Theirs.
    """

    def __init__(self, whole: EventSource, members: Chosen, system: System) -> None:
        self._whole, self._members, self._system = whole, members, system

    @property
    def watched(self) -> list[Event]:
        """The events, with the numbers of these members."""
        return [numbers_of_members(event, self._members) for event in self._whole.watched]

    @property
    def counts(self) -> list[int]:
        """How often each of them happened."""
        return [len(found) for found in self.of_members(None)]

    def of_members(self, _: Chosen | None) -> tuple[EventRecord, ...]:
        """Return what happened to all of these."""
        whole = self._whole.of_members(self._members)
        return tuple(_of_members(found, self._members, self._system) for found in whole)


def _of_members(found: EventRecord, members: Chosen, system: System) -> EventRecord:
    """Return those of some members, numbered anew, with the numbers of their event; `system` is theirs."""
    whose = np.atleast_1d(members)
    first, last = np.searchsorted(found.members, whose, "left"), np.searchsorted(found.members, whose, "right")
    counts = last - first
    rows = np.repeat(last - np.cumsum(counts), counts) + np.arange(np.sum(counts))
    event, again = numbers_of_members(found.event, members), np.repeat(np.arange(whose.size), counts)
    return replace(found._rows(rows), event=event, system=system, members=again)


def crossings(
    system: System, events: Sequence[Event], variables: StateVector, found: list[tuple[int, Recorded]], rising: bool
) -> tuple[EventRecord, ...]:
    """Return what happened of each event, from pairs of a member and a record."""
    members = np.array([member for member, _ in found], dtype=int)
    numbers = np.array([record[0] for _, record in found], dtype=int)
    times = np.array([record[1] for _, record in found], dtype=float)
    directions = np.array([record[2] for _, record in found], dtype=int)
    rows = np.empty((len(found), variables.size))
    for i, (_, record) in enumerate(found):
        rows[i] = record[3]
    blocks = [slice(first, first + BLOCK) for first in range(0, max(len(found), 1), BLOCK)]
    parts = [_phase(variables, members[block], times[block], rows[block]) for block in blocks]
    phase = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.lexsort((times if rising else -times, members))
    of_all = (EventRecord(event, system, times, state_of(phase, times), directions, members) for event in events)
    return tuple(each._rows(order[numbers[order] == number]) for number, each in enumerate(of_all))


def _phase(variables: StateVector, members: Array, times: Array, rows: Array) -> Phase:
    if variables.of_one:
        return variables.to_phase(times, rows)
    return changed(variables.of_members(members).to_phase(times[:, None], rows[:, None, :]), lambda x: x[:, 0])
