"""How motions of a system are integrated: what is decided before the first step, once for all members."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.engine.driver import Driver
from poinsot.engine.formulations import Formulation
from poinsot.engine.problem import Problem
from poinsot.engine.progress import Progress
from poinsot.engine.runs import Memory, OneMotion, Report
from poinsot.engine.state_vector import StateVector
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System
from poinsot.propagation.event_record import KnownEvents, crossings
from poinsot.propagation.pair_trajectory import trajectory_class
from poinsot.propagation.run_record import Method, Run
from poinsot.propagation.selection import numbers_of_members, system_of_members
from poinsot.propagation.trajectory import Trajectory

__all__ = ["Integrator"]


@dataclass(frozen=True)
class Integrator:
    """A problem in given variables, and how it is integrated.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    formulation : Formulation
    tolerance : float
    precision : str
    threads : int
    dense : bool
    device : str
    """

    problem: Problem
    variables: StateVector
    formulation: Formulation
    tolerance: float
    precision: str = "double"
    threads: int = 1
    dense: bool = False
    device: str = "cpu"

    @property
    def system(self) -> System:
        """The system."""
        return self.problem.system

    def of_members(self, members: slice) -> Integrator:
        """Return the same for some members of an ensemble: what is decided stays."""
        events = [numbers_of_members(event, members) for event in self.problem.events]
        problem = Problem(system_of_members(self.system, members), events)
        variables: Any = self.variables.of_members(members)  # type: ignore[arg-type]  # it only indexes
        return dataclasses.replace(self, problem=problem, variables=variables)

    def motion(self, state: State, times: NDArray[np.float64], progress: Progress = False) -> tuple[Trajectory, Report]:
        """Return the motion from a state, or that of the members from theirs, and what is known about the run."""
        members, along = state.time.shape, self._along
        of_orbits = {"orbits": (along,)} if along else {}
        kept = Memory(self.variables, members[0], times, **of_orbits) if members else OneMotion()
        report = self._driver(progress).run(state, times, kept)
        motion = self.trajectory(state, kept, report)
        if self.problem.events:
            rising = bool(times[0] <= times[-1])
            found = crossings(self.system, self.problem.events, self.variables, report.events, rising)
            motion.event_source = KnownEvents(found)
        return motion, report

    def trajectory(self, state: State, kept: Any, report: Report) -> Trajectory:
        """Return the motion of rows that a sink has kept."""
        problem, many = self.problem, bool(state.time.ndim)
        method = Method.TAYLOR_OF_MEMBERS if many else Method.TAYLOR
        return trajectory_class(self.system)(
            self.system,
            state,
            kept.times,
            lambda: kept.phase,
            Run.of(report, method, self.formulation.name, self.precision),
            (report.dense, *report.dense.ends) if report.dense else None,
            report.failures if many else {},
            functools.partial(self.variables.environment, problem, kept.times, kept.rows["orbits"])
            if self._along
            else None,
        )

    @property
    def _along(self) -> int:
        """How many variables of orbits integrated along a motion has; 0 where no orbit is integrated."""
        along = self.variables.along_orbits
        return along.stop - along.start if any(orbit.integrated for orbit in self.problem.orbits) else 0

    def _driver(self, progress: Progress = False) -> Driver:
        return Driver(
            self.problem,
            self.variables,
            self.tolerance,
            precision=self.precision,
            threads=self.threads,
            progress=progress,
            dense=self.dense,
            device=self.device,
        )
