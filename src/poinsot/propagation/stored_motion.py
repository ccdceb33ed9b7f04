"""The motion of an ensemble in a store, whose arrays are read on access."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.event import Event
from poinsot.mechanics.state import RIGID, AnyState, Phase, state_of
from poinsot.mechanics.system import System
from poinsot.printable import described
from poinsot.propagation.columns import ORBIT_VARIABLES, RENAMED
from poinsot.propagation.dataset import with_present_names
from poinsot.propagation.event_record import NO_EVENTS, EventRecord, EventRecords
from poinsot.propagation.recorded import RecordedEvent
from poinsot.propagation.row_source import StoreRows
from poinsot.propagation.trajectory import Trajectory
from poinsot.storage.ensemble_store import EnsembleStore
from poinsot.storage.reductions import reduced
from poinsot.storage.run_record import RunRecord
from poinsot.storage.selection import Chosen
from poinsot.storage.zarr_group import JoinedArrays

__all__ = [
    "arrays_in",
    "crossings_in",
    "events_in",
    "failures_in",
    "motion_in",
    "phase_in",
    "result_in",
    "run_in",
    "sizes_of",
    "stored_events",
    "times_in",
    "told_crossings",
    "told_events",
]


def motion_in(
    store: EnsembleStore, system: System, initial: AnyState, run: RunRecord, events: EventRecords = NO_EVENTS
) -> Trajectory | None:
    """Return the motion of a system; None if the store does not contain the state variables."""
    phase = phase_in(store)
    if phase is None:
        return None
    arrays, times = arrays_in(store), np.array(store.arrays[times_in(store)], dtype=float)
    columns = {ORBIT_VARIABLES: arrays[ORBIT_VARIABLES]} if ORBIT_VARIABLES in arrays else {}
    return Trajectory(
        system, initial, times, StoreRows(store, phase, columns, events), run, failures=failures_in(store)
    )


def arrays_in(store: EnsembleStore) -> dict[str, NDArray[np.float64]]:
    """Return the arrays of a store of any version by their present names; they are read when they are indexed."""
    found = {RENAMED.get(name, name): array for name, array in store.arrays.items()}
    return cast("dict[str, NDArray[np.float64]]", found)


def result_in(store: EnsembleStore) -> Any:
    """Return the dataset of a store without the state variables: the stored variables, or the result of reductions."""
    return with_present_names(store.dataset()) if store.sharded else reduced(store)


def phase_in(store: EnsembleStore) -> Phase | None:
    """Return the arrays of the state variables, unread; None if one of them is not stored."""
    names = str(store.attributes.get("state_variables", "")).split()
    stored = {name: name if name in RIGID or name in ORBIT else f"own_{name}" for name in names}
    arrays: Any = store.sharded
    there = all(name in arrays and arrays[name].kind != "int64" for name in stored.values())
    if not names or not there or times_in(store) not in store.arrays:
        return None
    found: dict[str, Any] = {name: store.arrays[key] for name, key in stored.items() if name not in ORBIT}
    if "position" in stored:
        found["orbit"] = JoinedArrays([store.arrays[name] for name in ORBIT])
    return found


def times_in(store: EnsembleStore) -> str:
    """Return the name of the times of the states; "" if state variables are stored at different times."""
    names = str(store.attributes.get("state_variables", "")).split()
    along = {
        about.dims[1]
        for name in (*names, *(f"own_{name}" for name in names), ORBIT_VARIABLES, *RENAMED)
        if (about := store.sharded.get(name)) is not None
    }
    return along.pop() if len(along) == 1 else ""


def run_in(store: EnsembleStore, run: RunRecord) -> RunRecord:
    """Return the record of the run that computed the complete chunks."""
    return run.with_chunks([about["run"] for _, about in store.extras()])


def failures_in(store: EnsembleStore) -> dict[int, str]:
    """Return the reasons why members stopped, from the complete chunks."""
    return {int(member): str(why) for _, about in store.extras() for member, why in about["failures"].items()}


def told_events(events: Sequence[Event]) -> dict[str, str]:
    """Return the attributes of a file about its events, which `events_in` reads."""
    described = [{"name": event.kind, "said": repr(event), "terminal": event.terminal} for event in events]
    return {"events": json.dumps(described)} if described else {}


def events_in(attributes: Mapping[str, Any]) -> list[RecordedEvent]:
    """Return the detected events from the attributes of a file."""
    text = attributes.get("events", "[]")
    try:
        each = json.loads(text)
        return [RecordedEvent(str(one["name"]), str(one["said"]), terminal=bool(one["terminal"])) for one in each]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise ValueError(f"events must be a list of names, got {described(text)}.") from None


def told_crossings(motion: Trajectory, first: int = 0) -> dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]]:
    """Return the events of a motion as variables of a file; `first` is the number of its first member."""
    variables: dict[str, Any] = {}
    for number, found in enumerate(motion.events):
        name = f"event_{number}"
        variables[f"{name}_time"] = (name,), found.times, {}
        variables[f"{name}_member"] = (name,), found.members + first, {}
        variables[f"{name}_direction"] = (name,), found.directions, {}
        for key, values in found.states.phase.items():
            variables[f"{name}_state_{key}"] = (name, f"{name}_{key}_axis"), values, {}
    return variables


Table = Mapping[str, Any]
"""Arrays by the names of `told_crossings`; empty arrays may be missing."""

ORBIT = ("position", "momentum")
"""Variables of the orbit of two bodies."""


def stored_events(
    events: Sequence[Event],
    system: System,
    sizes: Mapping[str, int],
    tables: Callable[[Chosen | None], Iterable[Table]],
) -> EventRecords:
    """Return the records of the events along a motion, which are read on access.

    Parameters
    ----------
    events : sequence of Event
        Detected events.
    system : System
        System of the motion.
    sizes : mapping
        Number of scalars of each state variable.
    tables : callable
        Yields the tables that contain the events of some members, None for all.
    """
    names = [f"event_{number}" for number in range(len(events))]

    def read(members: Chosen | None) -> tuple[EventRecord, ...]:
        found = list(tables(members)) if names else []
        return tuple(_record(event, name, found, system, sizes) for event, name in zip(events, names, strict=True))

    def counts() -> list[int]:
        found = list(tables(None)) if names else []
        return [sum(len(one[f"{name}_time"]) for one in found if f"{name}_time" in one) for name in names]

    return EventRecords(lambda: events, read, counts)


def sizes_of(phase: Phase) -> dict[str, int]:
    """Return the number of scalars of each state variable."""
    return {name: rows.shape[-1] for name, rows in phase.items()}


def _record(event: Event, name: str, tables: Sequence[Table], system: System, sizes: Mapping[str, int]) -> EventRecord:
    def whole(key: str, *shape: int, kind: type = float) -> NDArray[Any]:
        each = [
            _checked(f"{name}_{key}", table[f"{name}_{key}"], (len(table[f"{name}_time"]), *shape))
            for table in tables
            if f"{name}_time" in table
        ]
        return np.concatenate([np.empty((0, *shape), kind), *each])

    times = whole("time")
    states = state_of({key: whole(f"state_{key}", size) for key, size in sizes.items()}, times)
    return EventRecord(event, system, times, states, whole("direction", kind=int), whole("member", kind=int))


def _checked(name: str, stored: Any, shape: tuple[int, ...]) -> Any:
    values = np.asarray(stored)
    if values.shape != shape:
        raise ValueError(f"{name} must have a row for each event, of shape {shape}, got {values.shape}.")
    return values


def crossings_in(store: EnsembleStore, members: Chosen | None) -> Iterator[Table]:
    """Yield the tables of the chunks that contain the events of some members, None for all."""
    chunks = np.flatnonzero(store.whole)
    if members is not None and store.chunk:
        chunks = np.intersect1d(chunks, np.atleast_1d(members) // store.chunk)
    for number in chunks.tolist():
        yield store.extra_of(number)[0]
