"""Motions of an ensemble: computed in chunks for a store, and read from the store on access."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.integration.report import Report
from poinsot.integration.settings import RunSettings
from poinsot.integration.state_vector import StateVector
from poinsot.kinematics.state import RIGID, Phase, state_of
from poinsot.mechanics.event import Event
from poinsot.printable import described
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.columns import ORBIT_VARIABLES, RENAMED, Column, Requirement
from poinsot.propagation.dataset import state_variables, with_present_names
from poinsot.propagation.event_record import EventRecord, EventRecords
from poinsot.propagation.recorded import RecordedEvent
from poinsot.propagation.scenario_of_motion import with_texts
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.units import DerivedUnits
from poinsot.storage.ensemble import ChunkResult, Ensemble
from poinsot.storage.ensemble_store import EnsembleStore
from poinsot.storage.run_record import RunRecord
from poinsot.storage.zarr_group import Attributes, Described, JoinedArrays, Numbers, StoredArray, Variables
from poinsot.systems.system import System

if TYPE_CHECKING:
    import xarray
from poinsot.storage.fingerprint import digests
from poinsot.storage.reductions import reduced
from poinsot.storage.selection import Chosen

__all__ = [
    "arrays_in",
    "ensemble_of_motions",
    "event_attributes",
    "event_tables",
    "event_variables",
    "events_in",
    "failures_in",
    "phase_in",
    "result_in",
    "run_in",
    "stored_events",
    "times_in",
]


def arrays_in(store: EnsembleStore) -> dict[str, NDArray[np.float64]]:
    """Return the arrays of a store of any version by their present names; they are read when they are indexed."""
    found = {RENAMED.get(name, name): array for name, array in store.arrays.items()}
    return cast("dict[str, NDArray[np.float64]]", found)


def result_in(store: EnsembleStore) -> xarray.Dataset:
    """Return the dataset of a store without the state variables: the stored variables, or the result of reductions."""
    return with_present_names(store.dataset()) if store.sharded else reduced(store)


def phase_in(store: EnsembleStore) -> Phase | None:
    """Return the arrays of the state variables without reading them; None if one of them is not stored."""
    names = str(store.attributes.get("state_variables", "")).split()
    stored = {name: name if name in RIGID or name in ORBIT else f"own_{name}" for name in names}
    arrays = store.sharded
    there = all(name in arrays and arrays[name].kind != "int64" for name in stored.values())
    if not names or not there or times_in(store) not in store.arrays:
        return None
    found: dict[str, StoredArray | JoinedArrays] = {
        name: store.arrays[key] for name, key in stored.items() if name not in ORBIT
    }
    if "position" in stored:
        found["orbit"] = JoinedArrays([store.arrays[name] for name in ORBIT])
    return cast(Phase, found)


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


def event_attributes(events: Sequence[Event]) -> dict[str, str]:
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


def event_variables(events: Sequence[EventRecord], first: int = 0) -> Variables:
    """Return the records of events as variables of a file; `first` is the number of the first member."""
    variables = dict[str, tuple[tuple[str, ...], Numbers, Attributes]]()
    for number, found in enumerate(events):
        name = f"event_{number}"
        variables[f"{name}_time"] = (name,), found.times, {}
        variables[f"{name}_member"] = (name,), found.members + first, {}
        variables[f"{name}_direction"] = (name,), found.directions, {}
        for key, values in found.states.phase.items():
            variables[f"{name}_state_{key}"] = (name, f"{name}_{key}_axis"), values, {}
    return variables


Table = Mapping[str, Numbers | StoredArray]
"""Arrays by the names of `event_variables`; empty arrays may be missing."""

ORBIT = ("position", "momentum")
"""Variables of the orbit of two bodies."""


def stored_events(
    events: Sequence[Event],
    system: System,
    phase: Phase,
    tables: Callable[[Chosen | None], Iterable[Table]],
) -> EventRecords:
    """Return the records of the events along a motion, which are read on access.

    Parameters
    ----------
    events : sequence of Event
        Detected events.
    system : System
        System of the motion.
    phase : mapping
        Rows of the state variables by name, whose last axis contains the scalars.
    tables : callable
        Yields the tables that contain the events of some members, None for all.
    """
    names = [f"event_{number}" for number in range(len(events))]
    sizes = {name: rows.shape[-1] for name, rows in phase.items()}

    def read(members: Chosen | None) -> tuple[EventRecord, ...]:
        found = list(tables(members)) if names else []
        return tuple(_record(event, name, found, system, sizes) for event, name in zip(events, names, strict=True))

    def counts() -> list[int]:
        found = list(tables(None)) if names else []
        return [sum(len(one[f"{name}_time"]) for one in found if f"{name}_time" in one) for name in names]

    return EventRecords(lambda: events, read, counts)


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


def _checked(name: str, stored: Numbers | StoredArray, shape: tuple[int, ...]) -> Numbers:
    values = np.asarray(stored)
    if values.shape != shape:
        raise ValueError(f"{name} must have a row for each event, of shape {shape}, got {values.shape}.")
    return values


def event_tables(store: EnsembleStore, members: Chosen | None) -> Iterator[Table]:
    """Yield the tables of the chunks that contain the events of some members, None for all."""
    chunks = np.flatnonzero(store.whole)
    if members is not None and store.chunk:
        chunks = np.intersect1d(chunks, np.atleast_1d(members) // store.chunk)
    for number in chunks.tolist():
        yield store.extra_of(number)[0]


# ---------------------------------------------------------------------- the ensemble in chunks


def ensemble_of_motions(
    whole: Trajectory,
    variables: StateVector,
    events: Sequence[Event],
    settings: RunSettings,
    integrate: Callable[[slice, Progress], tuple[Trajectory, Report]],
) -> Ensemble[Trajectory | xarray.Dataset]:
    """Return the motions of members from their states, at the same times, as an ensemble in chunks.

    Parameters
    ----------
    whole : Trajectory
        Motion of all members without rows.
    variables : StateVector
        Integrated variables of all members.
    events : sequence of Event
        Events to detect.
    settings : RunSettings
        Settings of the run.
    integrate : callable
        Returns the motion of some members and the report of their run.
    """
    system, state, times, run, table = whole.system, whole.initial, whole.times, whole.run, whole._reader.table
    phase, observables, fixed = whole._rows.phase, whole._rows.observables, whole.variables(())
    names = state_variables(system, phase)
    described = with_texts(fixed, system, run, whole.provenance)
    method = {"method": str(run.method), "formulation": run.formulation, "precision": run.precision}
    problem = {
        "function": "propagate",
        "system": system,
        "states": (dict(state.phase), state.time, *state.jumped.items()),
        "times": times,
        "events": events,
        "settings": (variables.formulation.name, settings.tolerance, settings.device),
    }
    if observables:
        problem["observables"] = tuple(observables.items())
    needed = {Requirement.ORBITS}
    if "not_rerunnable" in described.attrs:  # states do not define energies again
        needed |= {Requirement.FORCES, *([Requirement.PARTS] if system.parts else [])}
    required = (name for name, column in table.items() if column.requires & needed)
    return Ensemble(
        members=state.time.size,
        last=float(times[-1]),
        problem=digests(problem),
        variables=_described(table, whole),
        stored=(*names, *required, *observables),
        member_bytes=8 * times.size * (variables.size + sum(variables.sizes.values())),
        fixed=described.assign_attrs(
            {**method, "tolerance": run.tolerance, "order": 0, "steps": 0, **event_attributes(events)}
        ),
        compute=functools.partial(_integrated, integrate),
        open=functools.partial(_opened, whole, events),
    )


def _described(columns: Mapping[str, Column], whole: Trajectory) -> dict[str, Described]:
    """Return the description of each column of all members, by name."""
    units, shape, found = DerivedUnits(whole.system.units), (whole.initial.time.size, whole.times.size), {}
    for name, column in columns.items():
        length = column.length or (whole._rows.columns[name].shape[-1] if column.axis else 0)
        dims = ("member", "time", *([column.axis] if length else []))
        found[name] = Described(dims, (*shape, *([length] if length else [])), "float64", column.attributes_in(units))
    return found


def _integrated(
    integrate: Callable[[slice, Progress], tuple[Trajectory, Report]],
    members: slice,
    names: tuple[str, ...],
    progress: Progress,
) -> ChunkResult:
    """Integrate some members."""
    motion, report = integrate(members, progress)
    rows, extra = motion._reader.read(names), event_variables(motion._rows.events.records, members.start)
    return ChunkResult.of(motion.failures, motion.run, members.start, rows, extra, report.interrupted)


def _opened(whole: Trajectory, events: Sequence[Event], store: EnsembleStore) -> Trajectory | xarray.Dataset:
    """Return the motion in a store, which is read on access; the dataset of a store without state variables."""
    phase = phase_in(store)
    if phase is None:
        return store.dataset()
    arrays, times = arrays_in(store), np.array(store.arrays[times_in(store)], dtype=float)
    columns = {name: arrays[name] for name in (ORBIT_VARIABLES, *whole._rows.observables) if name in arrays}
    observables = {name: each for name, each in whole._rows.observables.items() if name in columns}
    found = stored_events(events, whole.system, whole._rows.phase, functools.partial(event_tables, store))
    rows = MotionRows(phase, columns, found, store.summary, store, observables)
    run, failures = run_in(store, whole.run), failures_in(store)
    return Trajectory(whole.system, whole.initial, times, rows, run, failures=failures, provenance=whole.provenance)
