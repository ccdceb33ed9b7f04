"""What is integrated: a system, and beside it the events to watch for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import attrgetter
from typing import Any, ClassVar

from typing_extensions import override

from poinsot.mechanics.collection import Collection
from poinsot.mechanics.dynamics import AnyDynamics
from poinsot.mechanics.event import Event
from poinsot.mechanics.formula_trials import try_event
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

    Attributes
    ----------
    dynamics : Dynamics
        Equations of motion of the system. A twin on other scalars has them, and no system.
    """

    system: System
    dynamics: AnyDynamics
    events: tuple[Event, ...]
    _seals: ClassVar[bool] = False

    def __init__(self, system: System, events: Sequence[Event] = ()) -> None:
        vars(self).update(system=system, dynamics=system.dynamics, events=tuple(events))
        if not events:
            vars(self).update(zip(SHARED, SHARED_OF(self.dynamics), strict=True))
            return
        self.refuse_other_axes()
        for event in events:
            try_event(self.dynamics, event)

    @property
    @override
    def records(self) -> tuple[Any, ...]:
        return (self.dynamics, *self.events)

    @override
    def with_records(self, records: Iterable[Any]) -> Problem:
        twin = object.__new__(Problem)
        dynamics, *events = records
        vars(twin).update(dynamics=dynamics, events=tuple(events))
        return twin
