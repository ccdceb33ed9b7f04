"""What is integrated: a system, and beside it the events to watch for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any, ClassVar

from typing_extensions import override

from poinsot.mechanics.collection import Collection
from poinsot.mechanics.event import Event
from poinsot.mechanics.system import System

__all__ = ["Problem"]

SHARED = ("structure", "alike", "numbers", "members", "orbits", "knots", "span")
"""What a problem without events has from its system, which keeps it for the next run."""

SHARED_OF = attrgetter(*SHARED)


class Problem(Collection):
    """A system and events side by side, with the numbers and orbits of both.

    Parameters
    ----------
    system : System
    events : sequence of Event
    """

    system: System
    events: tuple[Event, ...]
    _seals: ClassVar[bool] = False

    def __init__(self, system: System, events: Sequence[Event] = ()) -> None:
        vars(self).update(system=system, events=tuple(events))
        if not events:
            vars(self).update(zip(SHARED, SHARED_OF(system), strict=True))
            return
        self.refuse_other_axes()
        for event in events:
            system.try_event(event)

    _member_axes: ClassVar[Mapping[str, int]] = {"system": 0, "events": 0}

    def _with_values(self, system: System, events: tuple[Event, ...]) -> Problem:
        return Problem(system, events)

    @property
    @override
    def records(self) -> tuple[Any, ...]:
        return (self.system, *self.events)

    @override
    def with_records(self, records: Iterable[Any]) -> Problem:
        twin = object.__new__(Problem)
        system, *events = records
        vars(twin).update(system=system, events=tuple(events))
        return twin
