"""The motions of an ensemble, chunk by chunk."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.integration.report import Report
from poinsot.mechanics.members import members_of
from poinsot.mechanics.state import AnyState
from poinsot.propagation.chunks import Part
from poinsot.propagation.columns import Requirement, columns_of
from poinsot.propagation.dataset import state_variables
from poinsot.propagation.ensemble_store import EnsembleStore
from poinsot.propagation.integrator import Integrator
from poinsot.propagation.stored_motion import (
    crossings_in,
    motion_in,
    run_in,
    stored_events,
    told_crossings,
    told_events,
    told_run,
)
from poinsot.propagation.system_text import with_texts
from poinsot.propagation.trajectory import Trajectory

if TYPE_CHECKING:
    import xarray

__all__ = ["EnsembleOfMotions"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EnsembleOfMotions:
    """Motions of members from their states, at the same times; see `Ensemble`.

    Parameters
    ----------
    integrator : Integrator
    state : State
        Of all members.
    times : array (n,)
    provenance : mapping
        Of the motions, which a store keeps.
    """

    integrator: Integrator
    state: AnyState
    times: Array
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @functools.cached_property
    def frame(self) -> Trajectory:
        """The motion of all members, without its numbers."""
        motion = self._without_numbers(self.integrator, self.state)
        motion._complete(provenance=self.provenance)
        return motion

    def _without_numbers(self, integrator: Integrator, state: AnyState) -> Trajectory:
        rows = _Nothing(integrator, state, self.times)
        return integrator.trajectory(state, rows, _report(integrator, state), self.times)

    @functools.cached_property
    def _first(self) -> Trajectory:
        """The motion of the first member, without its numbers."""
        return self._without_numbers(members_of(self.integrator, FIRST), members_of(self.state, FIRST))

    @property
    def members(self) -> int:
        """How many there are."""
        return self.state.time.size

    @property
    def member_bytes(self) -> int:
        """Bytes of the rows of a member, as they are integrated and as they are kept."""
        return 8 * self.times.size * (self.integrator.variables.size + sum(self.integrator.variables.sizes.values()))

    @property
    def last(self) -> float:
        """The last time."""
        return float(self.times[-1])

    @functools.cached_property
    def names(self) -> tuple[str, ...]:
        """What a dataset of motions has along the times."""
        return self._first.variable_names

    @functools.cached_property
    def _described(self) -> xarray.Dataset:
        """Start, body and the text of the system."""
        return with_texts(self.frame.variables(()), self.frame)

    @functools.cached_property
    def kept(self) -> tuple[str, ...]:
        """State variables; if the forces cannot be written, also the columns that require them."""
        columns, parts = columns_of(self._first.system, self.names), self.frame.system.parts
        needed = {Requirement.ORBITS}
        if "not_rerunnable" in self._described.attrs:
            needed |= {Requirement.FORCES, *([Requirement.PARTS] if parts else [])}
        own = state_variables(self.frame)
        return (*own, *(name for name in self.names if columns[name].requires & needed))

    @property
    def problem(self) -> Mapping[str, Any]:
        """What the motions are of."""
        own = self.integrator
        return {
            "function": "propagate",
            "system": own.system,
            "states": (dict(self.state.phase), self.state.time, *self.state.jumped.items()),
            "times": self.times,
            "events": own.problem.events,
            "settings": (own.formulation.name, own.tolerance, own.device),
        }

    def fixed(self) -> xarray.Dataset:
        """Return start, body and the text of the system, and how motions are computed."""
        run = self.frame.run
        known = {"method": str(run.method), "formulation": run.formulation, "precision": run.precision}
        told = told_events(self.integrator.problem.events)
        return self._described.assign_attrs({**known, "tolerance": run.tolerance, "order": 0, "steps": 0, **told})

    def empty(self, names: Iterable[str]) -> xarray.Dataset:
        """Return the variables of one member."""
        with np.errstate(all="ignore"):
            return self._first.variables(tuple(names))

    def computed(self, members: slice, names: Iterable[str], progress: Progress) -> Part:
        """Integrate some members."""
        integrator = members_of(self.integrator, members).telling(progress)
        motion, report = integrator.motion(members_of(self.state, members), self.times)
        failures = {str(members.start + member): why for member, why in motion.failures.items()}
        about = {"failures": failures, "run": told_run(motion.run)}
        return Part(motion.variables(tuple(names)), told_crossings(motion, members.start), about, report.interrupted)

    def opened(self, store: EnsembleStore) -> Any:
        """Return the motion in a store, of which is read what is asked for; its dataset if it has no whole states."""
        system, sizes = self.integrator.system, self.integrator.variables.sizes
        events = stored_events(self.integrator.problem.events, system, sizes, functools.partial(crossings_in, store))
        motion = motion_in(store, system, self.state, run_in(store, self.frame.run), events)
        if motion is None:
            return store.dataset()
        motion._complete(provenance=self.provenance)
        return motion


FIRST = slice(0, 1)


class _Nothing:
    """The rows of members that are not integrated, which take no memory."""

    def __init__(self, integrator: Integrator, state: AnyState, times: Array) -> None:
        self.times, shape = times, (state.time.size, times.size)
        variables = integrator.variables
        self.phase = {name: np.broadcast_to(np.nan, (*shape, size)) for name, size in variables.sizes.items()}
        along = variables.along_orbits
        self.rows = {"orbits": np.broadcast_to(np.nan, (*shape, along.stop - along.start))}


def _report(integrator: Integrator, state: AnyState) -> Report:
    return Report(np.zeros(state.time.size, dtype=int), tolerance=integrator.tolerance, wall_time=np.nan)
