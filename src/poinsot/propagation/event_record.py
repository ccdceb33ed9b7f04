"""Records of the events along a motion: times, states and directions of the zeros."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, rounded
from poinsot.immutable import cached_property
from poinsot.integration.report import Recorded
from poinsot.integration.state_vector import StateVector
from poinsot.kinematics.state import AnyState, Phase, changed, state_of
from poinsot.mechanics.event import Event
from poinsot.quantities import Array
from poinsot.records.members import members_of
from poinsot.storage.selection import Chosen
from poinsot.systems.system import System

__all__ = ["NO_EVENTS", "EventRecord", "EventRecords", "crossings"]

Integers = NDArray[np.int_]

EVENTS_PER_BLOCK = 65_536
"""Number of events converted together."""


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
    directions: Integers
    members: Integers

    def __len__(self) -> int:
        return self.times.size

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        rising, falling = (int(np.sum(self.directions == sign)) for sign in (1, -1))
        return f"EventRecord of {rounded(repr(self.event))}: {len(self)}", {
            "times": formatted(self.times, self.system.units["time"]) or "none",
            "directions": f"{rising} rising, {falling} falling" if len(self) else "",
            "members": f"{np.unique(self.members).size}" if np.any(self.members) else "",
        }

    @checked
    def member(self, member: int) -> EventRecord:
        """Return the record of one member."""
        return self._rows(self.members == member)

    def _rows(self, chosen: Integers | NDArray[np.bool_]) -> EventRecord:
        """Return the record of some zeros, chosen by places or by truth values."""
        states = state_of(changed(self.states.phase, lambda x: x[chosen]), self.times[chosen])
        own = self.times[chosen], states, self.directions[chosen], self.members[chosen]
        return EventRecord(self.event, self.system, *own)

    @property
    def omega_body(self) -> Array:
        """Inertial angular velocity at the events along the body axes, shape (k, 3)."""
        numbers = (number[self.members] if number.ndim else number for number in self.system.dynamics.numbers)
        return np.asarray(self.system.dynamics.with_numbers(numbers).omega_body(self.states))


class EventRecords:
    """Records of the events along a motion, which are made on first access.

    Parameters
    ----------
    watched : callable
        Returns the events that were detected.
    read : callable
        Returns the records of some members, None for all. The records may contain further members.
    counts : callable, optional
        Returns the number of zeros of each event. Default: the lengths of the records.
    """

    def __init__(
        self,
        watched: Callable[[], Sequence[Event]],
        read: Callable[[Chosen | None], tuple[EventRecord, ...]],
        counts: Callable[[], list[int]] | None = None,
    ) -> None:
        self._watched, self._read, self._counts = watched, read, counts

    @classmethod
    def of(cls, records: tuple[EventRecord, ...]) -> EventRecords:
        """Return records in memory."""
        return cls(lambda: [found.event for found in records], lambda _: records)

    def __reduce__(self) -> tuple[Callable[..., EventRecords], tuple[tuple[EventRecord, ...]]]:
        return EventRecords.of, (self.records,)

    @property
    def watched(self) -> list[Event]:
        """Detected events."""
        return list(self._watched())

    @cached_property
    def records(self) -> tuple[EventRecord, ...]:
        """Records of all members."""
        return self._read(None)

    @property
    def counts(self) -> list[int]:
        """Number of zeros of each event."""
        return [len(found) for found in self.records] if self._counts is None else self._counts()

    @property
    def ends(self) -> list[tuple[str, int, float]]:
        """Kind, number of zeros and first time of each terminal event that ended the motion, or members of it."""
        counted = enumerate(zip(self.watched, self.counts, strict=True))
        ended = [(number, event.kind, count) for number, (event, count) in counted if event.terminal and count]
        return [(kind, count, float(self.records[number].times[0])) for number, kind, count in ended]

    def of_members(self, members: Chosen, system: System) -> EventRecords:
        """Return the records of some members, which are renumbered; `system` is the system of these members."""
        return EventRecords(
            lambda: [members_of(event, members) for event in self._watched()],
            lambda _: tuple(_of_members(found, members, system) for found in self._read(members)),
        )


NO_EVENTS = EventRecords.of(())


def _of_members(found: EventRecord, members: Chosen, system: System) -> EventRecord:
    """Return the record of some members, which are renumbered, with the numbers of their event and their system."""
    whose = np.atleast_1d(members)
    first, last = np.searchsorted(found.members, whose, "left"), np.searchsorted(found.members, whose, "right")
    counts = last - first
    rows = np.repeat(last - np.cumsum(counts), counts) + np.arange(np.sum(counts))
    event, again = members_of(found.event, members), np.repeat(np.arange(whose.size), counts)
    return replace(found._rows(rows), event=event, system=system, members=again)


def crossings(
    system: System, events: Sequence[Event], variables: StateVector, found: list[tuple[int, Recorded]], rising: bool
) -> tuple[EventRecord, ...]:
    """Return the record of each event, from pairs of a member and a zero."""
    members = np.array([member for member, _ in found], dtype=int)
    numbers = np.array([record[0] for _, record in found], dtype=int)
    times = np.array([record[1] for _, record in found], dtype=float)
    directions = np.array([record[2] for _, record in found], dtype=int)
    rows = np.empty((len(found), variables.size))
    for i, (_, record) in enumerate(found):
        rows[i] = record[3]
    blocks = [slice(first, first + EVENTS_PER_BLOCK) for first in range(0, max(len(found), 1), EVENTS_PER_BLOCK)]
    parts = [_phase(variables, members[block], times[block], rows[block]) for block in blocks]
    phase = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.lexsort((times if rising else -times, members))

    def found_of(event: Event, chosen: Integers) -> EventRecord:
        states = state_of(changed(phase, lambda x: x[chosen]), times[chosen])
        return EventRecord(event, system, times[chosen], states, directions[chosen], members[chosen])

    return tuple(found_of(event, order[numbers[order] == number]) for number, event in enumerate(events))


def _phase(variables: StateVector, members: Integers, times: Array, rows: Array) -> Phase:
    if variables.of_one:
        return variables.to_phase(times, rows)
    return changed(members_of(variables, members).to_phase(times[:, None], rows[:, None, :]), lambda x: x[:, 0])
