"""Integration problem: a system together with the events to detect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any, ClassVar

from typing_extensions import override

from poinsot.immutable import cached_property
from poinsot.kinematics.state import AnyState
from poinsot.mechanics.event import Event
from poinsot.mechanics.part import Part
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
    checks_start: bool
    """True if a part or an event does not accept every initial state."""
    _seals: ClassVar[bool] = False

    def __init__(self, system: System, events: Sequence[Event] = ()) -> None:
        dynamics = system.dynamics
        super().__init__((dynamics, *events))
        shared = dict(zip(SHARED, SHARED_OF(dynamics), strict=True))
        if events:
            shared |= _with_events(dynamics, Collection(tuple(events)))
        checking: list[Part | Event] = [*dynamics.parts, *events]
        checks_start = True in [record.checks_start for record in checking]
        vars(self).update(shared, system=system, dynamics=dynamics, events=tuple(events), checks_start=checks_start)
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
    def _name_records(self) -> None:
        dynamics, *events = self.records
        vars(self).update(dynamics=dynamics, events=tuple(events))

    def check_start(self, state: AnyState) -> None:
        """Raise the error of a part or an event that does not accept an initial state."""
        expanded = self.broadcast_to(state.shape)
        instant = expanded.dynamics.at(state)
        for part in expanded.dynamics.parts:
            part.check_start(instant)
        for event in expanded.events:
            event.check_start(instant)


def _with_events(dynamics: AnyDynamics, events: Collection) -> dict[str, Any]:
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
