"""The motion of an ensemble in a store: its arrays are read when they are asked for."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.engine import kernels
from poinsot.engine.formulations import formulation_of
from poinsot.engine.problem import Problem
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.event import Event
from poinsot.mechanics.state import RIGID, Phase, State, state_of
from poinsot.mechanics.system import System
from poinsot.propagation.chunks import reduced
from poinsot.propagation.ensemble_store import EnsembleStore
from poinsot.propagation.event_record import EventRecord, StoredEvent
from poinsot.propagation.pair_trajectory import trajectory_class
from poinsot.propagation.run_record import Run
from poinsot.propagation.trajectory import ORBIT, Trajectory
from poinsot.propagation.zarr_group import JoinedArrays

if TYPE_CHECKING:
    pass

__all__ = [
    "events_in",
    "events_of",
    "failures_in",
    "motion_in",
    "phase_in",
    "result_in",
    "run_in",
    "times_in",
    "told_events",
    "told_run",
]


def motion_in(store: EnsembleStore, system: System, initial: State, run: Run) -> Trajectory | None:
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
    motion.store = store
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


def told_events(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Return what a store says of events; `events_in` reads it."""
    return [{"name": event.kind, "said": repr(event), "terminal": event.terminal} for event in events]


def events_in(store: EnsembleStore) -> list[StoredEvent]:
    """Return what a store says of the events that were watched for."""
    told = store.attributes.get("events", [])
    return [StoredEvent(str(one["name"]), str(one["said"]), terminal=bool(one["terminal"])) for one in told]


def events_of(store: EnsembleStore, events: Sequence[Event], system: System) -> tuple[EventRecord, ...]:
    """Return what happened of each event in the chunks that are whole."""
    chunks = [arrays for arrays, _ in store.asides()] if events else []
    return tuple(_event(event, f"event_{i}", chunks, system) for i, event in enumerate(events)) if chunks else ()


def _event(event: Event, name: str, chunks: Sequence[Mapping[str, Any]], system: System) -> EventRecord:
    def whole(key: str) -> Any:
        return np.concatenate([np.asarray(arrays[key]) for arrays in chunks])

    times, states = whole(f"{name}_time"), f"{name}_state_"
    phase = {key.removeprefix(states): whole(key) for key in chunks[0] if key.startswith(states)}
    own = state_of(phase, times), whole(f"{name}_direction"), whole(f"{name}_member")
    return EventRecord(event, system, times, *own)


def _environment(store: EnsembleStore, system: System, initial: State, run: Run, times: Any) -> Environment:
    problem = Problem(system)
    variables = kernels.state_vector(problem, initial, formulation_of(run.formulation), run.precision)
    return variables.environment(problem, times, np.asarray(store.arrays["carried"]))
