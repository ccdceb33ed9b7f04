"""Torque-free motion in closed form."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, cast

import numpy as np
from typing_extensions import Unpack, override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.double_double import DoubleDouble
from poinsot.integration.equations import state_vector
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.settings import RunSettings
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.state import AnyState, Phase, State
from poinsot.mechanics.body import Body
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.free_motion.elements import Elements, elements_of
from poinsot.propagation.free_motion.theta import is_near_separatrix, theta_functions
from poinsot.propagation.integrator import Integrator
from poinsot.propagation.stored_motion import ensemble_of_motions
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.members import members_of
from poinsot.storage.chunk_plan import Chunking, plan_of
from poinsot.storage.chunk_run import run_in_chunks
from poinsot.storage.memory import refuse_larger_than_memory
from poinsot.storage.run_record import Method, RunRecord, versions
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, check_bodies, checked_times, common_members

__all__ = ["free_motion"]

ATTITUDES_PER_BLOCK = 8192
"""Number of attitudes computed together: their intermediate results stay in the second cache of a processor."""

SIZES = {"quaternion": 4, "angular_momentum_body": 3}
"""Number of scalars of each state variable."""


@checked
def free_motion(
    body: Body, state: State, times: Times, *, units: Mapping[str, str] | None = None, **chunking: Unpack[Chunking]
) -> Trajectory:
    """Return the torque-free motion of a body from a state, at the given times, in closed form.

    The cost and the accuracy do not depend on the time: rates are computed from the given state in twice the double
    precision, so the error does not grow with time, up to phases of 1e15 radians. The attitude is expressed by theta
    functions with a constant angular momentum in space, and elliptic elements as in Landau and Lifshitz, Mechanics,
    Sec. 37, in forms that are also accurate near the separatrix and for symmetric bodies.

    Parameters
    ----------
    body : Body
        Body with moments of shape (3,), or (members, 3) for an ensemble, in any order.
    state : State
        Initial state, or one for each member. Its time need not be one of `times`.
    times : array (n,)
        Times of the results, strictly increasing or strictly decreasing.
    units : mapping, optional
        Units of the given numbers, as in `System`.
    **chunking
        `out`, `chunk`, `variables`, `reduce` and `client`, as in `propagate`.

    Returns
    -------
    Trajectory
        Motion at the times. For one body, `motion(t)` gives the state at any time.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> pt.free_motion(body, start, [0.0, 1e6]).omega_body.round(4)
    array([[ 0.1   ,  1.    ,  0.2   ],
           [-0.5134, -0.605 ,  0.6802]])
    """
    system = System(body, units=units)
    t = checked_times(times, system)
    check_bodies(system, state)
    members, plan = common_members(system, state), plan_of(**chunking)
    if plan:
        if not members:
            raise ValueError("out, chunk, reduce and client must be given for an ensemble, got one body.")
        states = broadcast_members(state, members)
        closed_form = _closed_form(system, states)
        whole = closed_form.motion_without_rows(states, t, plan.provenance)
        compute = partial(closed_form.motion_of_members, states, t)
        ensemble = ensemble_of_motions(whole, closed_form.variables, (), closed_form.settings, compute)
        return cast("Trajectory", run_in_chunks(ensemble, plan, sys.stderr.isatty()))
    began = clock.perf_counter()
    if members:
        refuse_larger_than_memory(members[0], t.size, sum(SIZES.values()))
        phase = _ensemble(body, broadcast_members(state, members), t)
        interpolant = None
    else:
        rotation = _Rotation(elements_of(body.moments, body.principal_matrix, state), state)
        phase = rotation.phase(t)
        interpolant = (rotation.phase, -np.inf, np.inf)
    run = _run_record(clock.perf_counter() - began)
    return Trajectory(system, state, t, MotionRows(phase), run, interpolant)


class _ClosedForm(Integrator):
    """Closed form in place of an integration."""

    @override
    def motion(self, state: AnyState, times: Array) -> tuple[Trajectory, Report]:
        body, start = self.system.of_bodies[""], state.of_bodies[""]
        motion, done = free_motion(body, start, times, units=self.system.units), state.time.size
        if callable(self.settings.progress):
            self.settings.progress(done)
        return motion, Report(np.zeros(done, dtype=int), finished=done)

    @override
    def run_record(self, report: Report, many: bool) -> RunRecord:
        return _run_record(np.nan)


def _run_record(wall_time: float) -> RunRecord:
    return RunRecord(Method.CLOSED_FORM, "theta functions", "double", 0.0, 0, 0, wall_time, versions())


def _closed_form(system: System, state: State) -> _ClosedForm:
    problem, settings = Problem(system), RunSettings(FORMULATIONS["lie_poisson"], 0.0)
    return _ClosedForm(problem, state_vector(problem, state, settings.formulation, "double"), settings)


class _Rotation:
    """Free rotation, or several rotations that are all near the separatrix or all far from it."""

    def __init__(self, elements: Elements, state: State) -> None:
        self.theta = theta_functions(elements, bool(np.all(is_near_separatrix(elements))))
        self.time = state.time
        axes = quaternion_from_matrix(elements.axes)
        start = quat.product(quat.product(state.quaternion, axes), quat.conjugate(self.theta.first()))
        # Row k is what the k-th component of the theta functions' quaternion adds to q.
        rows = quat.product(start[..., None, :], np.eye(4))
        self.to_q = quat.product(rows, quat.conjugate(axes)[..., None, :])
        self.to_g = np.swapaxes(elements.axes, -1, -2)

    def phase(self, times: Array) -> Phase:
        """Return q and g at times; shapes (..., n, 4) and (..., n, 3)."""
        shape = (*np.shape(self.time), times.size)
        q, g = np.empty((*shape, 4)), np.empty((*shape, 3))
        for i in range(0, times.size, ATTITUDES_PER_BLOCK):
            block = slice(i, i + ATTITUDES_PER_BLOCK)
            elapsed = DoubleDouble.difference(times[block], np.asarray(self.time)[..., None])
            turned, along = self.theta.motion(elapsed)
            q[..., block, :], g[..., block, :] = turned @ self.to_q, along @ self.to_g
        return {"quaternion": q, "angular_momentum_body": g}


def _ensemble(body: Body, state: State, times: Array) -> Phase:
    """Return q and g of all members; shapes (members, n, 4) and (members, n, 3)."""
    shape = (len(state.quaternion), times.size)
    phase = {name: np.empty((*shape, size)) for name, size in SIZES.items()}
    for chosen, rotation in _rotations(body, state, max(1, ATTITUDES_PER_BLOCK // times.size)):
        for name, values in rotation.phase(times).items():
            phase[name][chosen] = values
    return phase


def _rotations(body: Body, state: State, at_once: int) -> Iterator[tuple[Any, _Rotation]]:
    """Yield numbers of members and their rotations."""
    moments = np.broadcast_to(body.moments, (*state.time.shape, 3))
    for i in range(0, len(moments), at_once):
        block = np.arange(i, min(i + at_once, len(moments)))
        elements = elements_of(moments[block], body.principal_matrix, members_of(state, block))
        near = is_near_separatrix(elements)
        for side in (near, ~near):
            if np.any(side):
                yield block[side], _Rotation(members_of(elements, side), members_of(state, block[side]))
