"""The user's events on an integrator: they are recorded, act on the state and end a motion.

Their functions are scaled by parameters of the kernel, as those of discontinuities are, so that they change a motion by
rounding only. What happens at the instant of another event is found there, and not left to the engine's rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.program import Node
from poinsot.engine.dense_output import Action
from poinsot.engine.discontinuities import (
    LARGE,
    NEVER,
    SMALL,
    alarm,
    blind,
    event_class,
    lane_of,
    look_ahead,
    set_alarm,
    time_scale,
)
from poinsot.engine.kernel_watch import AT_ONCE
from poinsot.engine.problem import Problem
from poinsot.engine.state_vector import StateVector
from poinsot.engine.termination import INTERRUPTED
from poinsot.mechanics.event import Event
from poinsot.mechanics.parameters import kinds_of, of_each
from poinsot.mechanics.state import State, changed, state_of
from poinsot.printable import described, message_of, quoted

__all__ = ["ZENO", "EventDetection", "Recorded", "acted", "refuse_constant_events", "told"]

ZENO = 1e-5
"""Actions are without end where the time between them shrinks from one to the next, by this at last."""

LARGEST = float(np.sqrt(np.finfo(float).max))
"""Momenta above this have rates that overflow."""

LIFT = 1e-100
"""Of values that are exactly zero; others do not change by it."""

POLISHES = 4
"""Evaluations of a function at most for the time of its zero."""

Recorded = tuple[int, int, float, int, NDArray[Any]]
"""Number of the event, lane, time, sign of the rate in time, variables."""


class EventDetection:
    """The user's events of one integrator.

    Parameters
    ----------
    events : sequence of Event
        Of which only the structure is looked at.
    functions : list of expressions
        The values of the events.
    look : compiled function
        Of variables and time: the values, their derivatives along the motion, what is positive where their zeros
        count, and the derivatives of the attitude.
    first : int
        The number of the first parameter that nothing else has.
    lanes : int
    kind : type
        Of the numbers.

    Attributes
    ----------
    records : list of Recorded
        What happened, until the integration takes it.
    actions : list of (int, Action)
        The lanes of actions and what these have made, until the integration takes it.
    stopped : list
        For each lane "", or why it must not go on: "event", "zeno", or the sentence about an action; or why a chunk of
        steps must end: "act" where the momenta want another scale now, "held" before an action.
    error : BaseException or None
        The last one that an action raised.
    scales : Scales
        Those of the momenta, the kernel's.
    spans : array (lanes,)
        The times that the run takes.
    rehearsing, certain : bool
        Whether actions must wait, and whether steps begin with momenta in the band of their scale.
    """

    def __init__(
        self,
        events: Sequence[Event],
        functions: list[Any],
        look: Any,
        first: int,
        lanes: int,
        kind: Any,
    ) -> None:
        self.records: list[Recorded] = []
        self.actions: list[tuple[int, Action]] = []
        self.stopped = [""] * lanes
        self.error: BaseException | None = None
        self.scales: Any = None
        self.rehearsing, self.certain = False, True
        self.settle: Callable[[Any, int], object] = lambda _engine, _lane: None
        self._events, self._lanes, self._look = events, lanes, look
        self._scales, self._lifts = first + np.arange(2 * len(events)).reshape(2, -1)
        self._sizes, self._last = np.zeros((2, lanes, len(events)))
        self._paces, self.spans = np.zeros(lanes), np.zeros(lanes)
        self._since, self._longest = np.zeros((2, lanes, len(events)))
        self._members: NDArray[np.int_] = np.zeros(lanes, dtype=int)
        self._follows = np.zeros(lanes, dtype=bool)
        self._sides, self._way = np.zeros((lanes, len(events)), dtype=int), 1
        self._directions = np.array([event.direction for event in events])
        places_of_each = zip(functions, self._scales, self._lifts, strict=True)
        scaled = [hy.par[scale] * function + hy.par[lift] for function, scale, lift in places_of_each]
        stop, pass_by = event_class(lanes, kind), event_class(lanes, kind, terminal=False)
        ways = {-1: hy.event_direction.negative, 0: hy.event_direction.any, 1: hy.event_direction.positive}
        self._alarm = first + 2 * len(events)
        self.passed: list[Any] = []
        self.stops = [stop(0.1 * (f**2 - LARGE**2), callback=self._growing(i)) for i, f in enumerate(scaled)]
        for i, (event, f) in enumerate(zip(events, scaled, strict=True)):
            if event.terminal or event.acts:
                self.stops.append(stop(f, callback=self._reaching(i), direction=ways[event.direction]))
            else:
                self.passed.append(pass_by(f, callback=self._passing(i), direction=ways[event.direction]))
        if any(event.acts for event in events):
            self.stops.append(stop(alarm(self._alarm), callback=self._coming_back()))

    def begin(
        self, engine: Any, problem: Problem, variables: StateVector, forwards: bool, members: NDArray[np.int_]
    ) -> None:
        """Fit the scales to the state of an integrator; a zero where it stands is no event."""
        self._way = 1 if forwards else -1
        self._problem, self._variables, self._members = problem, variables, members
        self._follows[:], self.error = False, None
        self._last[:] = np.ravel(engine.time).astype(float)[:, None]
        self._since[:], self.stopped[:], self.rehearsing = 0.0, [""] * self._lanes, False
        for lane in range(self._lanes):
            self._fit(engine, lane)
            self._set_alarm(engine, lane, NEVER)

    def go_on(self) -> None:
        """Forget that a chunk of steps had to end."""
        self.stopped = ["" if why in ("act", "held") else why for why in self.stopped]

    def repeat(self, busy: int, idle: NDArray[np.int_]) -> None:
        """Let lanes follow another one: nothing is recorded of them, and no event acts on them."""
        for own in (self._sizes, self._last, self._paces, self._since, self._longest, self._sides):
            own[idle] = own[busy]
        self._follows[idle] = True

    def look(self, engine: Any, lane: int = 0, found: tuple[int, int] | None = None) -> bool:
        """Let happen what is due at the time of a lane, to rounding; return whether the motion goes on.

        `found` is the number and the direction of an event that the engine has found there.
        """
        if self._follows[lane]:
            return True
        values, rates, counting = self._evaluate(engine, lane)
        time = float(np.ravel(engine.time)[lane])
        directions = {i: int(np.sign(rate)) for i, rate in enumerate(rates) if np.isfinite(rate)}
        due = {i for i in directions if abs(values[i]) <= self._near(lane, time) * abs(rates[i])}
        due = {i for i in due if self._events[i].direction in (0, directions[i])}
        if found:
            due.add(found[0])
            directions[found[0]] = found[1]
        for i in due:
            self._sides[lane, i] = directions[i] * self._way
        self._lift(engine, lane, [*due])
        due = {i for i in due if counting[i] > 0}
        new = [i for i in sorted(due) if self._is_new(i, lane, time)]
        return self._let_happen(engine, lane, [(i, directions[i]) for i in new], time)

    def _let_happen(self, engine: Any, lane: int, new: list[tuple[int, int]], time: float) -> bool:
        """Record events with their directions, and act, in the order of the list; return whether the motion goes on."""
        events = [self._events[i] for i, _ in new]
        acting = any(event.acts for event in events)
        if acting and (self.rehearsing or not (self.certain or self.scales.fits(engine.state, lane))):
            self.stopped[lane] = "held"
            return False
        for (i, direction), event in zip(new, events, strict=True):
            row = self.scales.outward(np.array(lane_of(engine.state, lane)), lane)
            near = self._near(lane, time)
            self.records.append((i, lane, time, direction, row))
            if event.acts:
                self._act(engine, lane, i, time)
                after = self.scales.outward(np.array(lane_of(engine.state, lane)), lane)
                self.actions.append((lane, Action(time, near, after)))
        if acting and not (self.stopped[lane] or self.scales.fits(engine.state, lane)):
            self.stopped[lane] = "act"
        if any(event.terminal for event in events):
            self.stopped[lane] = self.stopped[lane] or "event"
        return not self.stopped[lane]

    def overlooked(self, engine: Any, lane: int) -> bool:
        """Return whether a value has changed its sign unseen, since this was asked last or the start."""
        values, rates, _ = self._evaluate(engine, lane)
        near = self._near(lane, float(np.ravel(engine.time)[lane]))
        beyond = np.abs(values) > near * np.abs(rates)
        signs = np.nan_to_num(np.sign(values)).astype(int)
        missed = beyond & (signs * self._sides[lane] < 0) & (self._directions * self._way * signs >= 0)
        self._sides[lane, beyond] = signs[beyond]
        return bool(np.any(missed))

    # ------------------------------------------------------------------ events

    # The engine copies what it is given, but for plain functions.

    def _passing(self, number: int) -> Callable[..., None]:
        def passed(engine: Any, time: Any, direction: int, lane: int = 0) -> None:
            self._sides[lane, number] = direction * self._way
            if self._follows[lane]:
                return
            time, counts = self._polished(engine, lane, number, time)
            if counts and self._is_new(number, lane, float(time)):
                row = self.scales.outward(np.array(lane_of(engine.d_output, lane)), lane)
                self.records.append((number, lane, float(time), direction, row))

        return passed

    def _polished(self, engine: Any, lane: int, number: int, time: Any) -> tuple[Any, bool]:
        """Return the time of a zero and whether it counts.

        The time is that of the function itself: close zeros drown in the rounding of the engine's polynomial.
        """
        for _ in range(POLISHES):
            values, rates, counting = self._values_at(engine, lane, time)
            value, rate = float(values[number]), float(rates[number])
            if abs(value) <= self._near(lane, float(time)) * abs(rate) or rate == 0:
                break
            step = value / rate
            if not abs(step) < abs(np.ravel(engine.last_h)[lane]):
                break
            time -= step
        return time, bool(counting[number] > 0)

    def _reaching(self, number: int) -> Callable[..., bool]:
        def reached(engine: Any, direction: int, lane: int = 0) -> bool:
            due = self._due(engine, lane, number, direction * self._way) if self._events[number].acts else None
            goes_on = self.look(engine, lane, (number, direction))
            if due is not None:
                self._set_alarm(engine, lane, due)
            return goes_on

        return reached

    def _coming_back(self) -> Callable[..., bool]:
        def come(engine: Any, _: int, lane: int = 0) -> bool:
            self._set_alarm(engine, lane, NEVER)
            return self.look(engine, lane)

        return come

    def _due(self, engine: Any, lane: int, number: int, side: int) -> float | None:
        """Return when the next zero of an event comes if the engine may miss it, so soon after the one here."""
        _, rates, _ = self._evaluate(engine, lane)
        scaled = abs(float(rates[number])) * float(lane_of(engine.pars, lane)[self._scales[number]])
        ahead = blind(engine, lane, scaled, float(self._paces[lane])) * self._way

        def is_behind(time: Any) -> bool:
            return bool(self._values_at(engine, lane, time)[0][number] * side > 0)

        return look_ahead(is_behind, np.ravel(engine.time)[lane], ahead)[1]

    def _values_at(self, engine: Any, lane: int, time: Any) -> tuple[NDArray[Any], ...]:
        """Return values, rates and conditions at a time within the last step."""
        engine.update_d_output([time] * self._lanes if self._lanes > 1 else time)
        return self._evaluate_at(engine, lane, lane_of(engine.d_output, lane), time)[:3]

    def _set_alarm(self, engine: Any, lane: int, time: float) -> None:
        if any(event.acts for event in self._events):
            set_alarm(engine, lane, self._alarm, time if time != NEVER else NEVER * self._way)

    def _growing(self, number: int) -> Callable[..., bool]:
        def grown(engine: Any, _: int, lane: int = 0) -> bool:
            self._sizes[lane, number] *= LARGE / SMALL**2
            self._set_scales(engine, lane)
            return True

        return grown

    def _is_new(self, number: int, lane: int, time: float) -> bool:
        """Whether the event has not just happened, and note that it has."""
        since, near = abs(time - self._last[lane, number]), self._near(lane, time)
        self._last[lane, number] = time
        if since <= near:
            return False
        if since >= self._since[lane, number]:
            self._longest[lane, number] = since
        elif self._events[number].acts and since < ZENO * self._longest[lane, number]:
            self.stopped[lane] = "zeno"
        self._since[lane, number] = since
        return True

    def _near(self, lane: int, time: float) -> float:
        return AT_ONCE * max(abs(time), float(self._paces[lane]))

    def _act(self, engine: Any, lane: int, number: int, time: float) -> None:
        """Give the state that an event returns to a lane, or note why not: the engine must see no exception."""
        own = lane_of(engine.state, lane)
        try:
            own[: self._variables.along_orbits.start] = self._acted(own, lane, number, time)
        except KeyboardInterrupt:
            self.stopped[lane] = INTERRUPTED
        except Exception as error:
            self.error, self.stopped[lane] = error, told(self._events[number], error)
        else:
            self.settle(engine, lane)
            self._fit(engine, lane)

    def _acted(self, own: NDArray[Any], lane: int, number: int, time: float) -> NDArray[Any]:
        """Return the variables of the state that an event returns."""
        variables, member = self._variables, int(self._members[lane])
        row = self.scales.outward(np.asarray(own, dtype=float), lane)
        inward: NDArray[Any] = self.scales.inward(acted(self._problem, variables, number, member, time, row), lane)
        return inward

    # ------------------------------------------------------------------ sizes

    def _fit(self, engine: Any, lane: int) -> None:
        values, rates, _ = self._evaluate(engine, lane)
        self._sizes[lane] = np.maximum(np.abs(values), np.abs(rates) * self._paces[lane])
        if np.any(flat := self._sizes[lane] == 0):
            aside, *_ = self._evaluate(engine, lane, aside=0.1)
            self._sizes[lane, flat] = np.abs(aside[flat])
        at_zero = np.abs(values) <= self._near(lane, float(np.ravel(engine.time)[lane])) * np.abs(rates)
        self._sides[lane] = np.nan_to_num(np.sign(np.where(at_zero, rates * self._way, values)))
        self._set_scales(engine, lane)
        self._lift(engine, lane, np.flatnonzero(at_zero))

    def _lift(self, engine: Any, lane: int, numbers: Any) -> None:
        """Put exact zeros where a lane stands just behind it: in a step the engine finds them again, and no other."""
        lifts = np.zeros(self._lifts.size)
        lifts[numbers] = LIFT * self._sides[lane, numbers]
        lane_of(engine.pars, lane)[self._lifts] = lifts

    def _set_scales(self, engine: Any, lane: int) -> None:
        sizes = self._sizes[lane]
        sizes[~((sizes > 0) & np.isfinite(sizes))] = 1.0
        lane_of(engine.pars, lane)[self._scales] = np.exp2(np.round(np.log2(SMALL / sizes)))

    def _evaluate(self, engine: Any, lane: int, aside: float = 0.0) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Return values, rates and conditions where a lane is, and note its pace; or `aside` of that."""
        row, time = lane_of(engine.state, lane), np.ravel(engine.time)[lane]
        if aside:
            shift = aside * np.cos(np.arange(1, row.size + 2))
            row, time = row + shift[:-1], time + shift[-1]
        *found, turning = self._evaluate_at(engine, lane, row, time)
        if not aside:
            self._paces[lane] = min(time_scale(turning), self.spans[lane])
        return found[0], found[1], found[2]

    def _evaluate_at(self, engine: Any, lane: int, row: NDArray[Any], time: Any) -> tuple[NDArray[Any], ...]:
        """Return values, rates, conditions and the derivatives of the attitude for variables and a time."""
        inputs, n = np.empty(row.size + 1, dtype=row.dtype), len(self._events)
        inputs[:-1], inputs[-1] = row, time
        pars = lane_of(engine.pars, lane)[: self._look.nparams]
        found = self._look(inputs, pars=np.ascontiguousarray(pars)).astype(float, copy=False)
        return found[:n], found[n : 2 * n], found[2 * n : 3 * n], found[3 * n :]


def acted(
    problem: Problem, variables: StateVector, number: int, member: int, time: float, row: NDArray[Any]
) -> NDArray[Any]:
    """Return the variables of the state that an event of a member returns; those of parts that it leaves out stay."""
    variables = variables.of_members(member)
    phase = variables.to_phase(np.array([time]), row[None])
    state, system = state_of(changed(phase, np.ravel), np.array(time)), problem.system
    event, *records = (_of_member(record, member) for record in (problem.events[number], *system.records))
    body = system.with_records(records).at(state).acted_on
    after = event.act(body, state)
    if type(after) is not type(state) or after.shape:
        what = described(after) if type(after) is not type(state) else "one of several members"
        kind = "State of one body" if type(state) is State else "PairState"
        raise TypeError(f"an action must return a {kind}, got {what}.")
    if other := sorted(set(after.own) - set(state.own)):
        raise ValueError(f"an action must return variables of parts of the system, got some of {quoted(other[0])}.")
    after = state_of({**state.own, **after.phase}, after.time)
    largest = max(float(np.max(np.abs(values))) for values in after.phase.values())
    if largest > LARGEST:
        raise ValueError(f"an action must return momenta whose squares are finite, got {largest:.3g}.")
    new: NDArray[Any] = variables.with_state(row, after, np.array(time))
    return new


def refuse_constant_events(events: Sequence[Event], values: Sequence[Any], formulation: str) -> None:
    """Raise a ValueError if the value of an event, a scalar of a kernel, is the same all the way."""
    for event, value in zip(events, values, strict=True):
        if not (isinstance(value, Node) and value.varies):
            raise ValueError(
                f"the value of {type(event).__name__} must depend on the motion, but it is constant in the variables "
                f"of {quoted(formulation)}."
            )


def _of_member(record: Any, member: int) -> Any:
    """Return a record with the numbers of one member."""
    fields = {}
    for name, kind in kinds_of(type(record)).items():
        value = getattr(record, name)
        if isinstance(kind, tuple):
            fields[name] = value[member] if np.ndim(value) > len(kind) else value
        else:
            fields[name] = of_each(value, lambda inner: _of_member(inner, member))
    return type(record).unchecked(**fields)


def told(event: Event, error: Exception) -> str:
    """Return the sentence about an action that failed."""
    text = f"{type(event).__name__}.act failed with {type(error).__name__}: {message_of(error)}"
    return text.rstrip(": .") + "."
