"""How motions of a system are integrated: what is decided before the first step, once for all members."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from poinsot.cuda.run import CudaRun, check_device
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.rows import Memory, OneMotion, Sink
from poinsot.integration.run import Run
from poinsot.integration.settings import RunSettings
from poinsot.integration.state_vector import StateVector
from poinsot.mechanics.state import AnyState, Phase
from poinsot.mechanics.system import System
from poinsot.propagation.columns import ORBIT_VARIABLES
from poinsot.propagation.event_record import NO_EVENTS, EventRecords, crossings
from poinsot.propagation.row_source import ComputedRows
from poinsot.propagation.trajectory import Trajectory
from poinsot.storage.memory import refuse_larger_than_memory
from poinsot.storage.run_record import Method, RunRecord

__all__ = ["Integrator"]


class ArraysByName(Protocol):
    """Arrays by name."""

    def __getitem__(self, name: str, /) -> NDArray[np.float64]:
        """Return an array."""


class SinkRows(Protocol):
    """Rows of a sink."""

    times: NDArray[np.float64]

    @property
    def phase(self) -> Phase:
        """State variables by name."""

    @property
    def rows(self) -> ArraysByName:
        """State variables and further rows by name."""


@dataclass(eq=False)
class Integrator:
    """Integration of a problem in given variables, whose rows become motions.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    settings : RunSettings
    """

    problem: Problem
    variables: StateVector
    settings: RunSettings

    @property
    def system(self) -> System:
        """The system."""
        return self.problem.system

    _member_axes: ClassVar[Mapping[str, int]] = {"problem": 0, "variables": 0}

    def _with_values(self, **values: Any) -> Self:
        return dataclasses.replace(self, **values)

    def check_device(self, members: bool) -> None:
        """Raise a ValueError for a run that the device does not support, or a computer without the device."""
        if self.settings.device == "cuda":
            check_device(self.problem, self.variables, members, self.settings.precision)

    def run(self, state: AnyState, times: NDArray[np.float64], sink: Sink) -> Report:
        """Integrate from a state outwards to all the times, which are monotonic; on Ctrl-C finished rows remain.

        A state with one time belongs to one body, a state with an array of times to an ensemble.
        """
        self.check_device(bool(state.time.ndim))
        kind = CudaRun if self.settings.device == "cuda" else Run
        return kind(self.problem, self.variables, state, times, sink, self.settings).integrate()

    def motion(self, state: AnyState, times: NDArray[np.float64]) -> tuple[Trajectory, Report]:
        """Return the motion from a state, or that of the members from theirs, and what is known about the run."""
        members = state.time.shape
        if members:
            numbers = sum(self.variables.sizes.values()) + sum(size for (size,) in self._of_orbits.values())
            refuse_larger_than_memory(members[0], times.size, numbers)
        kept = Memory(self.variables, members[0], times, **self._of_orbits) if members else OneMotion()
        report = self.run(state, times, kept)
        return self.trajectory(state, kept, report, times), report

    def trajectory(self, state: AnyState, kept: SinkRows, report: Report, times: NDArray[np.float64]) -> Trajectory:
        """Return the motion from the rows of a sink."""
        problem, variables, many, events = self.problem, self.variables, bool(state.time.ndim), NO_EVENTS
        method = Method.TAYLOR_OF_MEMBERS if many else Method.TAYLOR
        if problem.events:
            rising = bool(times[0] <= times[-1])
            events = EventRecords.of(crossings(problem.system, problem.events, variables, report.events, rising))
        columns = (lambda: {ORBIT_VARIABLES: kept.rows["orbits"]}) if self._of_orbits else dict
        return Trajectory(
            problem.system,
            state,
            kept.times,
            ComputedRows(lambda: kept.phase, columns, events),
            RunRecord.of(report.totals, method, variables.formulation.name, self.settings.precision),
            (report.dense, *report.dense.ends) if report.dense else None,
            report.failures if many else {},
        )

    @property
    def _of_orbits(self) -> dict[str, tuple[int]]:
        """The shape of the variables of orbits that a motion has; none where no orbit is integrated in any axes."""
        if not [orbit for orbit in self.problem.orbits if orbit.integrated]:
            return {}
        along = self.variables.along_orbits
        return {"orbits": (along.stop - along.start,)}
