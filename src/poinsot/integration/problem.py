"""Integration problem: a system together with the events to detect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any, ClassVar

from typing_extensions import override

from poinsot.immutable import cached_property
from poinsot.mechanics.event import Event
from poinsot.records.members import common_axis
from poinsot.systems.collection import Collection, knots_of, results_of
from poinsot.systems.dynamics import AnyDynamics
from poinsot.systems.formula_trials import try_event
from poinsot.systems.system import System

__all__ = ["Problem"]

SHARED = ("structure", "alike", "numbers", "members", "orbits", "_dated", "knots", "span")
"""Attributes that a problem without events shares with its system, which stores them for the next run."""

SHARED_OF = attrgetter(*SHARED)


class Problem(Collection):
    """A system together with events, with the numbers and orbits of both.

    Parameters
    ----------
    system : System
    events : sequence of Event

    Attributes
    ----------
    dynamics : Dynamics
        Equations of motion of the system. A copy on other scalars has equations, but no system.
    """

    system: System
    dynamics: AnyDynamics
    events: tuple[Event, ...]
    _seals: ClassVar[bool] = False

    def __init__(self, system: System, events: Sequence[Event] = ()) -> None:
        dynamics = system.dynamics
        super().__init__((dynamics, *events))
        shared = dict(zip(SHARED, SHARED_OF(dynamics), strict=True))
        if events:
            shared |= _with_events(dynamics, EventCollection(tuple(events)))
        vars(self).update(shared, system=system, dynamics=dynamics, events=tuple(events))
        if events:
            self.refuse_other_axes()
            for event in events:
                try_event(dynamics, event)

    _member_axes: ClassVar[Mapping[str, int]] = {"system": 0, "events": 0}

    def _with_values(self, system: System, events: tuple[Event, ...]) -> Problem:
        return Problem(system, events)

    @property
    def smooth(self) -> Problem:
        """The problem between the first two knots of its tables; the problem itself if it has none."""
        return self._between_first_knots if self.knots.size else self  # a problem that refers to itself is garbage

    @cached_property
    def _between_first_knots(self) -> Problem:
        return self.between_knots()

    @override
    def with_records(self, records: Iterable[Any]) -> Problem:
        twin = object.__new__(Problem)
        dynamics, *events = records = tuple(records)
        Collection.__init__(twin, records)
        vars(twin).update(dynamics=dynamics, events=tuple(events))
        return twin


class EventCollection(Collection):
    """The events of a problem, without the system."""

    @override
    def with_records(self, records: Iterable[Event]) -> EventCollection:
        return EventCollection(tuple(records))


def _with_events(dynamics: AnyDynamics, events: EventCollection) -> dict[str, Any]:
    """Return the shared attributes of a system together with events, without a second look at the system."""
    structure = (dynamics.structure, *events.structure)
    (first, last), (begin, end) = dynamics.span, events.span
    return {
        "structure": structure,
        "alike": results_of(structure),
        "numbers": dynamics.numbers + events.numbers,
        "members": common_axis("body and forces", {dynamics.members, events.members}),
        "orbits": dynamics.orbits + events.orbits,
        "_dated": dynamics._dated + events._dated,
        "knots": knots_of((dynamics, *events.records)),
        "span": (max(first, begin), min(last, end)),
    }
