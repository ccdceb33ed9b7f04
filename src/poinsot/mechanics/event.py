"""Events: zeros of a formula along a motion, and changes of the state there.

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method the
formula. The base class makes it a frozen dataclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import field
from typing import Any

from typing_extensions import override

from poinsot.functions import Scalar
from poinsot.kinematics.state import PairState, State
from poinsot.mechanics.body import Body
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.two_bodies import TwoBodies, check_name_of_body
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Parametric, kinds_of, listed

__all__ = ["Event"]


class Event(Parametric, ABC):
    """Event at the zeros of a scalar formula along a motion; the base class of all events.

    A subclass defines `value(instant)`. A subclass that also defines `act` changes the state at the event, and the
    motion continues from the state that `act` returns.

    Parameters
    ----------
    direction : {-1, 0, 1}
        1 for zeros at which the value rises with time, -1 for zeros at which it falls, 0 for both. The sign refers to
        increasing time, also in a run backwards.
    terminal : bool
        True if the motion ends at the event.

    Raises
    ------
    ValueError
        If the direction is another number, or a terminal event also defines `act`.

    Examples
    --------
    >>> class Slow(pt.Event):
    ...     rate: float
    ...     def value(self, instant):
    ...         return pt.functions.norm(instant.omega_body) - self.rate
    >>> Slow(0.5, direction=-1)
    Slow(rate=0.5, direction=-1)
    """

    direction: int = field(default=0, kw_only=True)
    terminal: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.direction not in (-1, 0, 1):
            raise ValueError(f"direction must be -1, 0 or 1, got {self.direction}.")
        if self.terminal and self.acts:
            raise ValueError(f"{type(self).__name__} must either act or be terminal, but it does both.")

    def __repr__(self) -> str:
        defaults: dict[str, Any] = {"direction": 0, "terminal": False}
        names = [name for name in kinds_of(type(self)) if name not in defaults]
        names += [name for name, default in defaults.items() if getattr(self, name) != default]
        return f"{type(self).__name__}({', '.join(f'{name}={listed(getattr(self, name))}' for name in names)})"

    @of_scalars
    @abstractmethod
    def value(self, instant: Instant) -> Scalar:
        """Return the scalar whose zeros are the events."""

    @of_scalars
    def condition(self, instant: Instant) -> Scalar:  # noqa: ARG002
        """Return a scalar that is positive where a zero of the value counts as an event. By default all zeros count."""
        return 1.0

    def act(self, body: Body, state: State) -> State:  # noqa: ARG002
        """Return the state from which the motion continues.

        For an ensemble, `body` and the fields of the event belong to one member. For two bodies, `act` receives a
        `TwoBodies` and a `PairState`. If the system has parts, `body` includes them: `body.state` accepts the angular
        velocity of body and parts together, and `body.own(part)` and `state.own` contain the variables of the parts.
        The variables of a part remain unchanged if the returned state does not contain them.
        """
        return state

    @property
    def acts(self) -> bool:
        """True if the event changes the state."""
        return type(self).act is not Event.act

    @property
    def kind(self) -> str:
        """Name of the class, for summaries."""
        return type(self).__name__

    @property
    def checks_start(self) -> bool:
        """True if a motion must not begin at some instants."""
        return type(self).check_start is not Event.check_start

    @of_scalars
    def check_start(self, instant: Instant) -> None:
        """Raise a ValueError if a motion must not begin at this instant. Ensembles pass an instant of arrays."""

    def on(self, body: str) -> Event:
        """Apply the event to one of two bodies, "primary" or "secondary"."""
        return EventOn(self, body, direction=self.direction, terminal=self.terminal)


class EventOn(Event):
    """An event of one body at one of two; made by `event.on("secondary")`."""

    event: Event
    body: str

    def __post_init__(self) -> None:
        check_name_of_body(self.body)
        super().__post_init__()

    @override
    def __repr__(self) -> str:
        return f"{self.event!r}.on({self.body!r})"

    @override
    def value(self, instant: Any) -> Scalar:
        return self.event.value(getattr(instant, self.body))

    @override
    def condition(self, instant: Any) -> Scalar:
        return self.event.condition(getattr(instant, self.body))

    @override
    def check_start(self, instant: Any) -> None:
        self.event.check_start(getattr(instant, self.body))

    @override
    def act(self, body: TwoBodies, state: PairState) -> PairState:  # type: ignore[override]
        each = dict(state.of_bodies)
        each[self.body] = self.event.act(body.bodies[self.body], each[self.body])
        return PairState(state.position, state.momentum, **each)

    @property
    @override
    def acts(self) -> bool:
        return self.event.acts

    @property
    @override
    def kind(self) -> str:
        return f"{self.event.kind} of the {self.body}"
