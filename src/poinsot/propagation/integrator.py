"""How motions of a system are integrated: what is decided before the first step, once for all members."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.integration.formulations import Formulation
from poinsot.integration.problem import Problem
from poinsot.integration.runs import Memory, OneMotion, Report
from poinsot.mechanics.state import AnyState
from poinsot.mechanics.system import System
from poinsot.propagation.driver import Driver
from poinsot.propagation.event_record import KnownEvents, crossings
from poinsot.propagation.memory import refuse_larger_than_memory
from poinsot.propagation.pair_trajectory import trajectory_class
from poinsot.propagation.run_record import Method, Run
from poinsot.propagation.selection import numbers_of_members, system_of_members
from poinsot.propagation.trajectory import Trajectory

__all__ = ["Integrator"]


class Integrator(Driver):
    """A driver whose rows become motions."""

    @property
    def system(self) -> System:
        """The system."""
        return self.problem.system

    @property
    def formulation(self) -> Formulation:
        """The chart of attitude and momentum."""
        return self.variables.formulation

    def of_members(self, members: slice) -> Integrator:
        """Return the same for some members of an ensemble: what is decided stays."""
        events = [numbers_of_members(event, members) for event in self.problem.events]
        problem = Problem(system_of_members(self.system, members), events)
        variables: Any = self.variables.of_members(members)  # type: ignore[arg-type]  # it only indexes
        return dataclasses.replace(self, problem=problem, variables=variables)

    def telling(self, progress: Progress) -> Integrator:
        """Return the same that tells how much is done."""
        return dataclasses.replace(self, progress=progress)

    def motion(self, state: AnyState, times: NDArray[np.float64]) -> tuple[Trajectory, Report]:
        """Return the motion from a state, or that of the members from theirs, and what is known about the run."""
        members = state.time.shape
        if members:
            numbers = sum(self.variables.sizes.values()) + sum(size for (size,) in self._of_orbits.values())
            refuse_larger_than_memory(members[0], times.size, numbers)
        kept = Memory(self.variables, members[0], times, **self._of_orbits) if members else OneMotion()
        report = self.run(state, times, kept)
        motion = self.trajectory(state, kept, report)
        if self.problem.events:
            rising = bool(times[0] <= times[-1])
            found = crossings(self.system, self.problem.events, self.variables, report.events, rising)
            motion._complete(event_source=KnownEvents(found))
        return motion, report

    def trajectory(self, state: AnyState, kept: Any, report: Report) -> Trajectory:
        """Return the motion of rows that a sink has kept."""
        problem, variables, many = self.problem, self.variables, bool(state.time.ndim)
        method = Method.TAYLOR_OF_MEMBERS if many else Method.TAYLOR
        return trajectory_class(problem.system)(
            problem.system,
            state,
            kept.times,
            lambda: kept.phase,
            Run.of(report, method, variables.formulation.name, self.precision),
            (report.dense, *report.dense.ends) if report.dense else None,
            report.failures if many else {},
            (lambda: variables.environment(problem, kept.times, kept.rows["orbits"])) if self._of_orbits else None,
        )

    @property
    def _of_orbits(self) -> dict[str, tuple[int]]:
        """The shape of the variables of orbits that a motion has; none where no orbit is integrated in any axes."""
        if not [orbit for orbit in self.problem.orbits if orbit.integrated]:
            return {}
        along = self.variables.along_orbits
        return {"orbits": (along.stop - along.start,)}
