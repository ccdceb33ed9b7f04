"""Integration of motions together with their variational equations, of one body or of an ensemble."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.rows import Sink
from poinsot.integration.run import BOTH_WAYS, Run
from poinsot.integration.tangent_vectors import Variations
from poinsot.mechanics.environment import shared_blocks
from poinsot.mechanics.members import members_of
from poinsot.mechanics.state import AnyState
from poinsot.mechanics.system import System
from poinsot.printable import quoted
from poinsot.propagation.arguments import (
    broadcast_members,
    check_bodies,
    check_span,
    checked_formulation,
    checked_threads,
    checked_times,
    checked_tolerance,
    common_members,
)
from poinsot.propagation.run_record import Method, RunRecord

__all__ = ["TOGETHER", "VariationalRun"]

Array = NDArray[np.float64]

TOGETHER = 12
"""The most coordinates whose vectors are integrated together: the equations of more compile for many seconds."""


class VariationalRun:
    """What integrations of variational equations have in common: checked arguments, variables, and the run itself.

    Parameters
    ----------
    system, state, times, formulation, tolerance, threads, progress
        As in `propagate`; the formulation is one with tangent coordinates.
    inputs : sequence of tuples of int
        Of derivatives: which numbers of the system change together.
    sizes : array of int (inputs,) or (members, inputs)
        Binary exponents of about what each of these changes by; by default of one.
    order : {1, 2}
        Of the derivatives.

    Attributes
    ----------
    members : tuple
        () for one body.
    formulation : Formulation
        The chart.
    variables : StateVector
    units : array (k,) or (members, k)
        What the variables multiply each tangent coordinate by.
    size : int
        The number k of tangent coordinates.
    parameters : int
        How many inputs there are.
    """

    def __init__(
        self,
        system: System,
        state: AnyState,
        times: ArrayLike,
        formulation: str | None = None,
        tolerance: float | None = None,
        threads: int | None = None,
        progress: bool | None = None,
        inputs: tuple[tuple[int, ...], ...] = (),
        order: int = 1,
        sizes: Any = (),
    ) -> None:
        self._order, self._sizes = order, np.asarray(sizes, dtype=int)
        self.times = checked_times(times, system)
        check_span(system, state, self.times)
        chosen = checked_formulation(formulation)
        if not chosen.tangent:
            able = ", ".join(name for name, each in FORMULATIONS.items() if each.tangent)
            raise ValueError(f"formulation must be one of {able} for variational equations, got {quoted(chosen.name)}.")
        self._tolerance, self._threads = checked_tolerance(tolerance, "double"), checked_threads(threads)
        self._progress = sys.stderr.isatty() if progress is None else progress
        check_bodies(system, state)
        self.system, self.problem, self.members = system, Problem(system), common_members(system, state)
        self.state = broadcast_members(state, self.members or (1,))
        variables = equations.state_vector(self.problem, self.state, chosen, "double")
        if inputs:  # comoving axes would change with their orbit
            orbits, views = shared_blocks(
                equations.between_first_knots(self.problem).orbits, lambda orbit: not orbit.closed_form
            )
            variables = dataclasses.replace(variables, orbits=orbits, views=views, comoving=False)
        self.formulation = chosen
        self.variables = variables if self.members else members_of(variables, 0)
        self._scaled, self.units = variables.tangent_scales, self.variables.tangent_units
        self.size = len(self._scaled)
        first = 1 + len(variables.factors)  # behind the scales
        self._inputs = tuple(tuple(first + number for number in together) for together in inputs)
        self.parameters = len(inputs)

    def repeated(self, count: int, inputs: tuple[tuple[int, ...], ...] = (), sizes: Any = ()) -> VariationalRun:
        """Return the run of an ensemble that has each member `count` times, with other inputs and their sizes."""
        return self.of_members(np.repeat(np.arange(len(self.state.time)), count), inputs, sizes)

    def of_members(
        self, who: NDArray[np.int_], inputs: tuple[tuple[int, ...], ...] = (), sizes: Any = ()
    ) -> VariationalRun:
        """Return the run of an ensemble of some members, with other inputs and their sizes."""
        return VariationalRun(
            members_of(self.system, who),
            members_of(self.state, who),
            self.times,
            self.formulation.name,
            self._tolerance,
            self._threads,
            self._progress,
            inputs,
            self._order,
            sizes[who] if np.ndim(sizes) > 1 else sizes,
        )

    def integrate(
        self,
        vectors: Array,
        times: Array,
        sink: Sink,
        state: AnyState | None = None,
        ways: tuple[bool, ...] = BOTH_WAYS,
    ) -> Report:
        """Integrate to times with tangent vectors from the start, shape (..., count, k).

        The state is by default that of the run.
        """
        variations = Variations(self._scaled, vectors.shape[-2], self._inputs, self._order, vectors, self._sizes)
        variables = dataclasses.replace(self.variables, variations=variations)
        return Run(
            self.problem,
            variables,
            self.state if state is None else state,
            times,
            sink,
            tolerance=self._tolerance,
            threads=self._threads,
            progress=self._progress,
            ways=ways,
        ).integrate()

    def weights(self, momentum_unit: Any) -> Array:
        """Return by what the variables multiply tangent coordinates of size one; shape (k,) or (members, k).

        Angles are in radians; momenta in a unit, that of a second body smaller as its largest moment is; other
        variables in a power of two about ten times their size.
        """
        scale, unit = (np.asarray(x)[..., None] for x in (self.variables.scale, momentum_unit))
        weights = np.where(self._scaled, scale * unit, np.ones_like(self.units))
        size = len(self.formulation.tangent)
        largest = [np.asarray(np.max(body.moments, axis=-1))[..., None] for body in self.system.of_bodies.values()]
        for i, moments in enumerate(largest[1:], start=1):
            own = slice(i * size + size // 2, (i + 1) * size)
            weights[..., own] = self.units[..., own] * unit * moments / largest[0]
        return weights

    def run(self, report: Report) -> RunRecord:
        """Return how it was computed."""
        return RunRecord.of(report, Method.VARIATIONAL, self.formulation.name)

    def failures(self, report: Report) -> dict[int, str]:
        """Return why members stopped; of one body `check` raises it."""
        return report.failures if self.members else {}

    def check(self, report: Report, result: object) -> None:
        """Raise what tells of Ctrl-C, or why one body stopped, and has the result up to there."""
        last = float(self.times[-1])
        report.check("the integration", last, result)
        if not self.members:
            report.check_one(last, result)
