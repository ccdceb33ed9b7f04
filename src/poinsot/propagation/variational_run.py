"""Integration of motions together with their variational equations, of one body or of an ensemble."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import member_array, refuse_nonpositive, refuse_other_members
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS, Formulation
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.rows import Sink
from poinsot.integration.run import BOTH_WAYS, Run
from poinsot.integration.settings import RunSettings
from poinsot.integration.state_vector import StateVector
from poinsot.integration.variational import Variations
from poinsot.kinematics.state import AnyState
from poinsot.mechanics.environment import shared_blocks
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.members import members_of
from poinsot.storage.run_record import Method, RunRecord
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, check_bodies, check_span, checked_times, common_members

__all__ = ["MAX_COORDINATES_TOGETHER", "Derivatives", "UserUnits", "VariationalRun"]

MAX_COORDINATES_TOGETHER = 12
"""The most coordinates whose vectors are integrated together: the equations of more compile for many seconds."""


class Derivatives(NamedTuple):
    """Derivatives by numbers of the system, which are integrated together with tangent vectors.

    Parameters
    ----------
    inputs : tuple of tuples of int
        Indices of the numbers of the system that change together, for each derivative.
    order : {1, 2}
        Order of the derivatives.
    sizes : array of int (inputs,) or (members, inputs)
        Binary exponents of typical changes of the inputs. Default: changes by one.
    """

    inputs: tuple[tuple[int, ...], ...] = ()
    order: int = 1
    sizes: NDArray[np.int_] | tuple[()] = ()

    @property
    def _member_axes(self) -> dict[str, int]:
        return {"sizes": 1}

    def _with_values(self, **values: Any) -> Derivatives:
        return self._replace(**values)


NO_DERIVATIVES = Derivatives()


class UserUnits(NamedTuple):
    """Units in which a user gives and reads tangent vectors, as factors for the variables of a run.

    Parameters
    ----------
    weights : array (members, k)
        Values of the variables for vectors of size one.
    momentum : array (members,)
        Angular momentum that is compared with a rotation by one radian.
    """

    weights: Array
    momentum: Array

    @property
    def _member_axes(self) -> dict[str, int]:
        return {"weights": 1, "momentum": 0}

    def _with_values(self, **values: Any) -> UserUnits:
        return self._replace(**values)

    def multiplied(self, vectors: Array) -> Array:
        """Return vectors of the user as initial values of a run; shape (members, count, k)."""
        return vectors * self.weights[:, None]

    def divided(self, members: NDArray[np.int_], vectors: Array) -> Array:
        """Return vectors of a run in the user's units; shape (members, ..., count, k) of some members."""
        weights = self.weights[members]
        return vectors / weights.reshape(len(weights), *(1,) * (vectors.ndim - 2), -1)


@dataclass(frozen=True, eq=False)
class VariationalRun:
    """Checked arguments of integrations of variational equations, and the integrations themselves.

    Attributes
    ----------
    problem : Problem
        System without events.
    state : AnyState
        Initial states; one body has a member axis of length one.
    times : array (n,)
        Times of the results.
    settings : RunSettings
        Formulation with tangent coordinates, tolerance, threads and progress.
    chart : StateVector
        State vector without derivatives by numbers of the system.
    is_ensemble : bool
        False for one body.
    derivatives : Derivatives
        Derivatives by numbers of the system.
    """

    problem: Problem
    state: AnyState
    times: Array
    settings: RunSettings
    chart: StateVector
    is_ensemble: bool
    derivatives: Derivatives = NO_DERIVATIVES

    _member_axes: ClassVar[Mapping[str, int]] = {"problem": 0, "state": 0, "chart": 0, "derivatives": 0}

    def _with_values(self, **values: Any) -> VariationalRun:
        return replace(self, is_ensemble=True, **values)

    @classmethod
    def of(
        cls,
        system: System,
        state: AnyState,
        times: ArrayLike,
        settings: RunSettings,
        derivatives: Derivatives = NO_DERIVATIVES,
    ) -> VariationalRun:
        """Return the run of a system from a state; raise an error for arguments that do not fit."""
        t, chosen = checked_times(times, system), settings.formulation
        check_span(system, state, t)
        if not chosen.tangent:
            able = ", ".join(name for name, each in FORMULATIONS.items() if each.tangent)
            raise ValueError(f"formulation must be one of {able} for variational equations, got {quoted(chosen.name)}.")
        check_bodies(system, state)
        members, problem = common_members(system, state), Problem(system)
        states = broadcast_members(state, members or (1,))
        chart = equations.state_vector(problem, states if members else state, chosen, "double")
        return cls(problem, states, t, settings, chart, bool(members), derivatives)

    @property
    def system(self) -> System:
        """System of the run."""
        return self.problem.system

    @property
    def formulation(self) -> Formulation:
        """Formulation of the run."""
        return self.settings.formulation

    @functools.cached_property
    def variables(self) -> StateVector:
        """State vector of the run, without tangent vectors.

        With derivatives it is not in comoving axes, which would change with their orbit.
        """
        if not self.derivatives.inputs:
            return self.chart
        smooth = self.problem.smooth
        orbits, views = shared_blocks(smooth.orbits, lambda orbit: not orbit.closed_form)
        return replace(self.chart, orbits=orbits, views=views, comoving=False)

    @property
    def units(self) -> Array:
        """Factors by which the variables multiply tangent coordinates; shape (k,) or (members, k)."""
        return self.chart.tangent_units

    @property
    def size(self) -> int:
        """Number k of tangent coordinates."""
        return len(self.chart.tangent_scales)

    def repeated(self, count: int, derivatives: Derivatives = NO_DERIVATIVES) -> VariationalRun:
        """Return the run of an ensemble that contains each member `count` times, with other derivatives."""
        each = np.repeat(np.arange(len(self.state.time)), count)
        return members_of(replace(self, derivatives=derivatives), each)

    def integrate(
        self,
        vectors: Array,
        times: Array,
        sink: Sink,
        state: AnyState | None = None,
        ways: tuple[bool, ...] = BOTH_WAYS,
    ) -> Report:
        """Integrate to times with initial tangent vectors of shape (..., count, k); by default from the run's state."""
        first = 1 + len(self.chart.factors)  # inputs follow the scales
        inputs = tuple(tuple(first + number for number in together) for together in self.derivatives.inputs)
        order, sizes = self.derivatives.order, np.asarray(self.derivatives.sizes, dtype=int)
        variations = Variations(self.chart.tangent_scales, vectors.shape[-2], inputs, order, vectors, sizes)
        variables = replace(self.variables, variations=variations)
        state = self.state if state is None else state
        return Run(self.problem, variables, state, times, sink, self.settings, ways).integrate()

    def user_units(self, rates: Array, momentum_unit: ArrayLike | None = None) -> UserUnits:
        """Return the units of tangent vectors of the user.

        Angles are in radians. Momenta are in `momentum_unit`, by default the largest moment of the first body times the
        rate of the fastest angle. The unit of momenta of a second body is smaller in the ratio of the largest moments.
        The unit of other variables is a power of two, about ten times their size.
        """
        members = self.state.time.shape
        largest = [np.asarray(np.max(body.moments, axis=-1)) for body in self.system.of_bodies.values()]
        given = largest[0] * rates if momentum_unit is None else member_array("momentum_unit", momentum_unit, ())
        refuse_nonpositive("momentum_unit", given)
        refuse_other_members(momentum_unit=given.shape, state=members)
        momentum = np.broadcast_to(given, members)
        unit, units = momentum[:, None], self.units
        weights = np.where(
            self.chart.tangent_scales, np.asarray(self.chart.scale)[..., None] * unit, np.ones_like(units)
        )
        size = len(self.formulation.tangent)
        for i, moments in enumerate(largest[1:], start=1):
            own = slice(i * size + size // 2, (i + 1) * size)
            weights[..., own] = units[..., own] * unit * moments[..., None] / largest[0][..., None]
        return UserUnits(weights, momentum)

    def run(self, report: Report) -> RunRecord:
        """Return the record of the run."""
        return RunRecord.of(report.totals, Method.VARIATIONAL, self.formulation.name)

    def failures(self, report: Report) -> dict[int, str]:
        """Return why members stopped; for one body `check` raises the reason."""
        return report.failures if self.is_ensemble else {}

    def check(self, report: Report, result: object) -> None:
        """Raise an error, with the result up to there, after Ctrl-C or if one body stopped."""
        last = float(self.times[-1])
        report.check("the integration", last, result)
        if not self.is_ensemble:
            report.check_one(last, result)
