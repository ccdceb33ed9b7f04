"""The motions of an ensemble, chunk by chunk."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.integration.report import Report
from poinsot.integration.state_vector import StateVector
from poinsot.mechanics.members import members_of
from poinsot.mechanics.state import AnyState
from poinsot.mechanics.system import System
from poinsot.mechanics.units import DerivedUnits
from poinsot.propagation.columns import ORBIT_VARIABLES, Column, Requirement
from poinsot.propagation.dataset import state_variables
from poinsot.propagation.integrator import Integrator
from poinsot.propagation.scenario_of_motion import with_texts
from poinsot.propagation.stored_motion import (
    crossings_in,
    motion_in,
    run_in,
    stored_events,
    told_crossings,
    told_events,
)
from poinsot.propagation.trajectory import Trajectory
from poinsot.storage.ensemble import ChunkResult, Ensemble, digests
from poinsot.storage.ensemble_store import EnsembleStore
from poinsot.storage.run_record import RunRecord
from poinsot.storage.zarr_group import Described

if TYPE_CHECKING:
    import xarray

__all__ = ["ensemble_of_motions"]

Array = NDArray[np.float64]


def ensemble_of_motions(
    integrator: Integrator, state: AnyState, times: Array, provenance: Mapping[str, Any]
) -> Ensemble[Trajectory | xarray.Dataset]:
    """Return the motions of members from their states, at the same times, as an ensemble in chunks.

    Parameters
    ----------
    integrator : Integrator
        Integrator of all members.
    state : AnyState
        States of all members.
    times : array (n,)
        Times of the motions.
    provenance : mapping
        Entries about the scenario, which a store contains.
    """
    size, variables = state.time.size, integrator.variables
    report = Report(np.zeros(size, dtype=int), tolerance=integrator.settings.tolerance, wall_time=np.nan)
    whole = integrator.trajectory(state, _NoRows(variables, size, times), report, times)
    whole._complete(provenance=provenance)
    run, events, columns = whole.run, integrator.problem.events, whole._reader.table
    described = with_texts(whole.variables(()), whole)
    method = {"method": str(run.method), "formulation": run.formulation, "precision": run.precision}
    problem = {
        "function": "propagate",
        "system": whole.system,
        "states": (dict(state.phase), state.time, *state.jumped.items()),
        "times": times,
        "events": events,
        "settings": (variables.formulation.name, integrator.settings.tolerance, integrator.settings.device),
    }
    return Ensemble(
        members=size,
        last=float(times[-1]),
        problem=digests(problem),
        variables=_described(columns, whole, variables.along_orbits),
        stored=(*state_variables(whole.system, whole.phase), *_required(columns, whole.system, described)),
        member_bytes=8 * times.size * (variables.size + sum(variables.sizes.values())),
        fixed=described.assign_attrs(
            {**method, "tolerance": run.tolerance, "order": 0, "steps": 0, **told_events(events)}
        ),
        compute=functools.partial(_integrated, integrator, state, times),
        open=functools.partial(_opened, integrator, state, run, provenance),
    )


def _required(columns: Mapping[str, Column], system: System, described: xarray.Dataset) -> Iterator[str]:
    """Yield the names of columns that states do not give again: with orbits, and forces that cannot be written."""
    needed = {Requirement.ORBITS}
    if "not_rerunnable" in described.attrs:
        needed |= {Requirement.FORCES, *([Requirement.PARTS] if system.parts else [])}
    return (name for name, column in columns.items() if column.requires & needed)


def _described(columns: Mapping[str, Column], whole: Trajectory, along_orbits: slice) -> dict[str, Described]:
    """Return the description of each column of all members, by name."""
    units, shape = DerivedUnits(whole.system.units), (len(whole), whole.times.size)
    lengths = {name: column.length for name, column in columns.items() if column.axis}
    if ORBIT_VARIABLES in lengths:
        lengths[ORBIT_VARIABLES] = along_orbits.stop - along_orbits.start
    return {
        name: Described(
            ("member", "time", column.axis) if column.axis else ("member", "time"),
            (*shape, lengths[name]) if column.axis else shape,
            "float64",
            column.attributes_in(units),
        )
        for name, column in columns.items()
    }


def _integrated(
    integrator: Integrator, state: AnyState, times: Array, members: slice, names: tuple[str, ...], progress: Progress
) -> ChunkResult:
    """Integrate some members."""
    some = members_of(integrator, members)
    some = dataclasses.replace(some, settings=integrator.settings._replace(progress=progress))
    motion, report = some.motion(members_of(state, members), times)
    rows, extra = motion._reader.read(names), told_crossings(motion, members.start)
    return ChunkResult.of(motion, members.start, rows, extra, report.interrupted)


def _opened(
    integrator: Integrator, state: AnyState, run: RunRecord, provenance: Mapping[str, Any], store: EnsembleStore
) -> Trajectory | xarray.Dataset:
    """Return the motion in a store, which is read on access; the dataset of a store without whole states."""
    system, sizes = integrator.problem.system, integrator.variables.sizes
    events = stored_events(integrator.problem.events, system, sizes, functools.partial(crossings_in, store))
    motion = motion_in(store, system, state, run_in(store, run), events)
    if motion is None:
        return store.dataset()
    motion._complete(provenance=provenance)
    return motion


class _NoRows:
    """Rows of members that are not integrated: not a number at all times, in no memory."""

    def __init__(self, variables: StateVector, members: int, times: Array) -> None:
        self.times, shape = times, (members, times.size)
        self.phase = {name: np.broadcast_to(np.nan, (*shape, size)) for name, size in variables.sizes.items()}
        along = variables.along_orbits
        self.rows = {"orbits": np.broadcast_to(np.nan, (*shape, along.stop - along.start))}
