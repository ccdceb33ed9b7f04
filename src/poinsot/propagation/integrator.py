"""Integration of a system whose rows become motions, with decisions that are made once for all members."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from poinsot.cuda.run import CudaRun, check_device
from poinsot.display.progress import Progress
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.rows import Memory, OneMotion, Sink
from poinsot.integration.run import Run
from poinsot.integration.settings import RunSettings
from poinsot.integration.state_vector import StateVector
from poinsot.kinematics.state import AnyState
from poinsot.propagation.column_reader import NO_COLUMNS, MotionRows
from poinsot.propagation.columns import ORBIT_VARIABLES
from poinsot.propagation.event_record import NO_EVENTS, EventRecords, crossings
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.members import members_of
from poinsot.storage.memory import refuse_larger_than_memory
from poinsot.storage.run_record import Method, RunRecord
from poinsot.systems.system import System

__all__ = ["Integrator"]


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
        """System that is integrated."""
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
        """Return the motion from a state, or the motions of members from their states, and the report of the run."""
        problem, members, orbits = self.problem, state.time.shape, self._of_orbits
        sink: Memory | OneMotion = OneMotion()
        if members:
            numbers = sum(self.variables.sizes.values()) + sum(size for (size,) in orbits.values())
            refuse_larger_than_memory(members[0], times.size, numbers)
            sink = Memory(self.variables, members[0], times, **orbits)
        report, events = self.run(state, times, sink), NO_EVENTS
        if problem.events:
            rising = bool(times[0] <= times[-1])
            events = EventRecords.of(crossings(problem.system, problem.events, self.variables, report.events, rising))
        columns = (lambda: {ORBIT_VARIABLES: sink.rows["orbits"]}) if orbits else NO_COLUMNS
        rows, dense = MotionRows(lambda: sink.phase, columns, events), report.dense
        run = self.run_record(report, bool(members))
        polynomials = (dense, *dense.ends) if dense else None
        failures = report.failures if members else {}
        return Trajectory(problem.system, state, sink.times, rows, run, polynomials, failures), report

    def motion_of_members(
        self, state: AnyState, times: NDArray[np.float64], members: slice, progress: Progress
    ) -> tuple[Trajectory, Report]:
        """Return the motions of some members of an ensemble, and the report of their run."""
        some = dataclasses.replace(members_of(self, members), settings=self.settings._replace(progress=progress))
        return some.motion(members_of(state, members), times)

    def motion_without_rows(
        self, state: AnyState, times: NDArray[np.float64], provenance: Mapping[str, Any]
    ) -> Trajectory:
        """Return the motion of all members before the integration, with NaN in all rows, which need no memory."""
        shape = (*state.time.shape, times.size)
        phase = {name: np.broadcast_to(np.nan, (*shape, size)) for name, size in self.variables.sizes.items()}
        orbits = self._of_orbits
        columns = {ORBIT_VARIABLES: np.broadcast_to(np.nan, (*shape, *orbits["orbits"]))} if orbits else NO_COLUMNS
        report = Report(np.zeros(shape[0], dtype=int), tolerance=self.settings.tolerance, wall_time=np.nan)
        run = self.run_record(report, True)
        return Trajectory(self.system, state, times, MotionRows(phase, columns), run, provenance=provenance)

    def run_record(self, report: Report, many: bool) -> RunRecord:
        """Return the record of a run of one body or of many members."""
        method = Method.TAYLOR_OF_MEMBERS if many else Method.TAYLOR
        return RunRecord.of(report.totals, method, self.variables.formulation.name, self.settings.precision)

    @property
    def _of_orbits(self) -> dict[str, tuple[int]]:
        """Shape of the variables of integrated orbits by name; empty without such orbits."""
        if not [orbit for orbit in self.problem.orbits if orbit.integrated]:
            return {}
        along = self.variables.along_orbits
        return {"orbits": (along.stop - along.start,)}
