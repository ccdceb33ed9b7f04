"""The motion of an ensemble in a store: its arrays are read when they are asked for."""

from __future__ import annotations

import dataclasses
import functools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from poinsot.integration import equations
from poinsot.integration.formulations import formulation_of
from poinsot.integration.problem import Problem
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.event import Event
from poinsot.mechanics.state import RIGID, AnyState, Phase, state_of
from poinsot.mechanics.system import System
from poinsot.printable import described
from poinsot.propagation.ensemble_store import EnsembleStore
from poinsot.propagation.event_record import EventRecord, StoredEvent
from poinsot.propagation.pair_trajectory import trajectory_class
from poinsot.propagation.reductions import reduced
from poinsot.propagation.run_record import Run
from poinsot.propagation.selection import Chosen
from poinsot.propagation.trajectory import ORBIT, Trajectory
from poinsot.propagation.zarr_group import JoinedArrays

__all__ = [
    "StoredEvents",
    "crossings_in",
    "events_in",
    "failures_in",
    "motion_in",
    "phase_in",
    "result_in",
    "run_in",
    "times_in",
    "told_crossings",
    "told_events",
    "told_run",
]


def motion_in(store: EnsembleStore, system: System, initial: AnyState, run: Run) -> Trajectory | None:
    """Return the motion of a system; None if the store does not have its whole states."""
    phase = phase_in(store)
    if phase is None:
        return None
    times, environment = np.array(store.arrays[times_in(store)]), None
    if "carried" in store.arrays:
        environment = functools.partial(_environment, store, system, initial, run, times)
    motion = trajectory_class(system)(
        system, initial, times, lambda: phase, run, failures=failures_in(store), environment=environment
    )
    motion._complete(store=store)
    return motion


def result_in(store: EnsembleStore) -> Any:
    """Return what is in a store without whole states: what reductions have made, or the variables that are kept."""
    return store.dataset() if store.sharded else reduced(store)


def phase_in(store: EnsembleStore) -> Phase | None:
    """Return what the motion is made of, none of it read; None if a part of it is not stored."""
    names = str(store.attributes.get("state_variables", "")).split()
    stored = {name: name if name in RIGID or name in ORBIT else f"own_{name}" for name in names}
    arrays: Any = store.sharded
    there = all(name in arrays and arrays[name].kind != "int64" for name in stored.values())
    if not names or not there or times_in(store) not in store.arrays:
        return None
    found: dict[str, Any] = {name: store.arrays[key] for name, key in stored.items() if name not in ORBIT}
    if ORBIT[0] in stored:
        found["orbit"] = JoinedArrays([store.arrays[name] for name in ORBIT])
    return found


def times_in(store: EnsembleStore) -> str:
    """Return the name of the times of the states; empty if these are at different ones."""
    names = str(store.attributes.get("state_variables", "")).split()
    along = {
        about.dims[1]
        for name in (*names, *(f"own_{name}" for name in names), "carried")
        if (about := store.sharded.get(name)) is not None
    }
    return along.pop() if len(along) == 1 else ""


def run_in(store: EnsembleStore, run: Run) -> Run:
    """Return how the chunks that are whole were computed."""
    told = [about["run"] for _, about in store.asides()]
    if not told:
        return run
    each = {name: told[0][name] for name in ("order", "tolerance", "kernel", "lanes")}
    return dataclasses.replace(run, **each, steps=sum(one["steps"] for one in told))


def told_run(run: Run) -> dict[str, Any]:
    """Return what a chunk says of how it was computed; `run_in` reads it."""
    return {name: getattr(run, name) for name in ("order", "tolerance", "steps", "kernel", "lanes")}


def failures_in(store: EnsembleStore) -> dict[int, str]:
    """Return why members stopped, of the chunks that are whole."""
    return {int(member): str(why) for _, about in store.asides() for member, why in about["failures"].items()}


def told_events(events: Sequence[Event]) -> dict[str, str]:
    """Return what files say of events; `events_in` reads it."""
    told = [{"name": event.kind, "said": repr(event), "terminal": event.terminal} for event in events]
    return {"events": json.dumps(told)} if told else {}


def events_in(attributes: Mapping[str, Any]) -> list[StoredEvent]:
    """Return what a file says of the events that were watched for."""
    said = attributes.get("events", "[]")
    try:
        told = json.loads(said)
        return [StoredEvent(str(one["name"]), str(one["said"]), terminal=bool(one["terminal"])) for one in told]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise ValueError(f"events must be a list of names, got {described(said)}.") from None


def told_crossings(motion: Trajectory, first: int = 0) -> dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]]:
    """Return what happened along a motion as variables of a file; `first` is the number of its first member."""
    told: dict[str, Any] = {}
    for number, found in enumerate(motion.events):
        name = f"event_{number}"
        told[f"{name}_time"] = (name,), found.times, {}
        told[f"{name}_member"] = (name,), found.members + first, {}
        told[f"{name}_direction"] = (name,), found.directions, {}
        for key, values in found.states.phase.items():
            told[f"{name}_state_{key}"] = (name, f"{name}_{key}_axis"), values, {}
    return told


Table = Mapping[str, Any]
"""Arrays by the names of `told_crossings`; what is empty may be missing."""


class StoredEvents:
    """What happened along a motion, which is read when it is asked for; see `EventSource`.

    Parameters
    ----------
    events : sequence of Event
    motion : Trajectory
    tables : callable
        Yields the tables that have what happened to some members, None: to all.
    """

    def __init__(
        self, events: Sequence[Event], motion: Trajectory, tables: Callable[[Chosen | None], Iterable[Table]]
    ) -> None:
        self._events, self._system, self._tables = events, motion.system, tables
        self._sizes = {name: rows.shape[-1] for name, rows in motion.phase.items()}

    @property
    def watched(self) -> list[Event]:
        """The events."""
        return list(self._events)

    @property
    def counts(self) -> list[int]:
        """How often each of them happened, by the sizes of the arrays."""
        names = [f"event_{number}_time" for number in range(len(self._events))]
        tables = list(self._tables(None)) if names else []
        return [sum(len(one[name]) for one in tables if name in one) for name in names]

    def of_members(self, members: Chosen | None) -> tuple[EventRecord, ...]:
        """Return what happened to some members, None: to all; others may be among them."""
        tables = list(self._tables(members)) if self._events else []
        return tuple(self._record(event, f"event_{number}", tables) for number, event in enumerate(self._events))

    def _record(self, event: Event, name: str, tables: Sequence[Table]) -> EventRecord:
        def whole(key: str, *shape: int, kind: type = float) -> Any:
            of_key = [
                _checked(f"{name}_{key}", table[f"{name}_{key}"], (len(table[f"{name}_time"]), *shape))
                for table in tables
                if f"{name}_time" in table
            ]
            return np.concatenate([np.empty((0, *shape), kind), *of_key])

        times = whole("time")
        states = state_of({key: whole(f"state_{key}", size) for key, size in self._sizes.items()}, times)
        own = whole("direction", kind=int), whole("member", kind=int)
        return EventRecord(event, self._system, times, states, *own)


def _checked(name: str, stored: Any, shape: tuple[int, ...]) -> Any:
    values = np.asarray(stored)
    if values.shape != shape:
        raise ValueError(f"{name} must have a row for each event, of shape {shape}, got {values.shape}.")
    return values


def crossings_in(store: EnsembleStore, members: Chosen | None) -> Iterator[Table]:
    """Yield what chunks of a store have of what happened to some members, None: to all."""
    chunks = np.flatnonzero(store.whole)
    if members is not None and store.chunk:
        chunks = np.intersect1d(chunks, np.atleast_1d(members) // store.chunk)
    for number in chunks.tolist():
        yield store.aside(number)[0]


def _environment(store: EnsembleStore, system: System, initial: AnyState, run: Run, times: Any) -> Environment:
    problem = Problem(system)
    variables = equations.state_vector(problem, initial, formulation_of(run.formulation), run.precision)
    return variables.environment(problem, times, np.asarray(store.arrays["carried"]))
