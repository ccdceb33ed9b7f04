"""Integration of the equations of motion by Taylor's method."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import cast

from typing_extensions import Unpack

from poinsot.checked import checked
from poinsot.display.progress import Progress
from poinsot.errors import PropagationError
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS, Formulation
from poinsot.integration.problem import Problem
from poinsot.integration.report import Report
from poinsot.integration.settings import RunSettings, checked_tolerance
from poinsot.kinematics.state import AnyState, Bodies
from poinsot.mechanics.event import Event
from poinsot.mechanics.observable import Observable, observables_by_name
from poinsot.propagation.arguments import checked_device, checked_formulation, checked_threads
from poinsot.propagation.columns import refuse_names_of_columns
from poinsot.propagation.integrator import Integrator
from poinsot.propagation.readings_along import (
    AbsentCounts,
    readings_without_rows,
    refuse_unfit,
    warn_of_absent,
    with_readings,
)
from poinsot.propagation.recorded import RecordedEvent, RecordedSystem
from poinsot.propagation.stored_motion import ensemble_of_motions
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.members import members_of
from poinsot.storage.chunk_plan import Chunking, Plan, plan_of
from poinsot.storage.chunk_run import run_in_chunks
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, check_bodies, check_span, checked_times, common_members

__all__ = ["propagate", "propagated_again"]


@checked
def propagate(
    system: System,
    state: AnyState,
    times: Times,
    *,
    events: Sequence[Event] = (),
    observables: Sequence[Observable] = (),
    formulation: str | Formulation | None = None,
    tolerance: float | None = None,
    dense: bool = False,
    precision: str = "double",
    threads: int | None = None,
    progress: bool | None = None,
    device: str = "cpu",
    **chunking: Unpack[Chunking],
) -> Trajectory:
    """Integrate the motion of a system from a state and return it at the given times.

    The integration runs forwards and backwards from the time of the state, by Taylor series at machine precision. If
    states, moments or parameters contain an axis of members, the run is an ensemble, and all results gain that axis
    first. For a free body, `free_motion` gives the closed form.

    Parameters
    ----------
    system : System
        Body with forces and parts.
    state : State or PairState
        Initial state. Its time need not be one of `times`.
    times : array (n,)
        Times of the results, strictly increasing or strictly decreasing; dates if an orbit has a calendar.
    events : list of Event
        Events to detect. `motion.events` contains the times and states of each.
    observables : list of Observable
        Observables whose readings are variables of the motion, such as `motion.column("light_curve")`. An ensemble in
        chunks may store the readings alone: `variables=["light_curve"]`.
    formulation : {"lie_poisson", "canonical", "euler_angles", "planar"} or Formulation, optional
        Integrated variables. Default: "lie_poisson", (q, g), the fastest. The other formulations derive g from their
        variables, which amplifies rounding errors in the angular velocity about the axis of smallest moment by up to
        I_max / I_min. "planar" integrates one angle, for a body that rotates about its third axis only.
    tolerance : float, optional
        Relative error per step. Default and minimum: the rounding unit of the precision, 2.2e-16 in double precision.
    dense : bool
        True to store the Taylor polynomials, so that `motion(t)` gives the state at any time in the interval.
    precision : {"double", "quadruple"}
        Precision of the arithmetic: 16 or 32 digits. Results are rounded to double precision.
    threads : int, optional
        Number of threads of an ensemble. Default: all cores available to the process.
    progress : bool, optional
        True to show a progress bar during a long run. Default: True for an ensemble on a terminal.
    device : {"cpu", "cuda"}
        Device that integrates an ensemble. "cuda" means an NVIDIA GPU and requires cupy (`pip install
        'poinsot[cuda]'`). This code has not been run on a GPU yet: tests compile it for the processor and find equal
        bits.
    **chunking
        `out`, `chunk`, `variables`, `reduce`, `client`: integrate an ensemble in chunks of members, to a store or on a
        cluster (docs/stores.md and docs/cluster.md).

    Returns
    -------
    Trajectory
        Motion at the times. With `reduce`, its reduced dataset.

    Raises
    ------
    PropagationError
        If the motion becomes singular. The error contains the time reached and the partial trajectory.
    PropagationInterrupted
        On Ctrl-C (a KeyboardInterrupt), after the current steps, with the same attributes. A second Ctrl-C stops at
        once.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> top = pt.System(body, pt.UniformGravity(0.5, (1, 0, 0)), units={"time": "s"})
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 3.0))
    >>> motion = pt.propagate(top, start, np.linspace(0, 10, 101))
    >>> motion.omega_body.shape, bool(np.ptp(motion.energy) < 1e-13)
    ((101, 3), True)
    """
    chosen, asked = checked_formulation(formulation), checked_tolerance(tolerance, precision)
    problem, t = Problem(system, events), checked_times(times, system)
    check_span(problem, state, t)
    members, plan = common_members(problem, state), plan_of(**chunking) if chunking else None
    check_bodies(system, state)
    if plan and not members:
        raise ValueError("out, chunk, reduce and client must be given for an ensemble, got one body. Save its motion.")
    state = _of_members(state, members, dense) if members else state
    if problem.checks_start:
        problem.check_start(state)
    instruments = _checked_observables(observables, system, members, t)
    variables = equations.state_vector(problem, state, chosen, precision)
    where = checked_device(device)
    cores = checked_threads(plan.threads(threads) if plan else threads) if members else 1
    shown = bool(members) and sys.stderr.isatty() if progress is None else progress
    integrator = Integrator(problem, variables, RunSettings(chosen, asked, precision, cores, shown, dense, where))
    if not (plan and plan.client):  # whose workers have devices of their own
        integrator.check_device(bool(members))
    if members and plan:
        return _propagated_in_chunks(integrator, state, t, instruments, plan)
    motion, report = integrator.motion(state, t)
    if members and report.interrupted:
        report.check("propagation", float(t[-1]), motion)
    if not members and (report.stops or report.interrupted):
        report.check_one(float(t[-1]), motion)
    again = partial(propagated_again, threads=cores)
    return with_readings(motion, instruments, again) if instruments else motion


def _of_members(state: Bodies, members: tuple[int, ...], dense: bool) -> Bodies:
    """Return a state for each member; raise a ValueError for dense output."""
    if dense:
        raise ValueError("an ensemble must be propagated without dense=True, got it. Propagate members one by one.")
    return broadcast_members(state, members)


def _checked_observables(
    observables: Sequence[Observable], system: System, members: tuple[int, ...], times: Array
) -> dict[str, Observable]:
    """Return observables by name; raise an error for one that does not fit the system, the members or the times."""
    found = observables_by_name(observables)
    refuse_names_of_columns(system, found)
    for each in found.values():
        refuse_unfit(system, each, members, times)
        if each.member_axis and not members:
            raise ValueError("observables must have the same numbers for one body, got members. Use pt.observe.")
    return found


def _propagated_in_chunks(
    integrator: Integrator, state: AnyState, times: Array, observables: Mapping[str, Observable], plan: Plan
) -> Trajectory:
    """Return the motions of an ensemble that is integrated in chunks of members."""
    whole = integrator.motion_without_rows(state, times, plan.provenance)
    integrate = partial(integrator.motion_of_members, state, times)
    absent: dict[str, AbsentCounts] = {}
    if observables:
        whole = whole.with_observables(observables, readings_without_rows(whole, observables))
        add = None if plan.client else partial(_add_absent, absent)  # workers warn themselves
        integrate = partial(_observed_members, integrator, state, times, observables, add)
    ensemble = ensemble_of_motions(
        whole, integrator.variables, integrator.problem.events, integrator.settings, integrate
    )
    result = cast("Trajectory", run_in_chunks(ensemble, plan, bool(integrator.settings.progress)))
    for name, counts in absent.items():
        warn_of_absent(observables[name], counts)
    return result


def _add_absent(absent: dict[str, AbsentCounts], name: str, counts: AbsentCounts) -> None:
    """Add the numbers of absent readings of a chunk."""
    absent[name] = absent.get(name, AbsentCounts(0, {})) + counts


def _observed_members(
    integrator: Integrator,
    state: AnyState,
    times: Array,
    observables: Mapping[str, Observable],
    add: Callable[[str, AbsentCounts], None] | None,
    members: slice,
    progress: Progress,
) -> tuple[Trajectory, Report]:
    """Return the motions of some members of an ensemble with readings, and the report of their run."""
    motion, report = integrator.motion_of_members(state, times, members, progress)
    if report.interrupted:
        return motion.with_observables(observables, readings_without_rows(motion, observables)), report
    some = {name: members_of(each, members) for name, each in observables.items()}
    again = partial(propagated_again, threads=integrator.settings.threads)
    return with_readings(motion, some, again, add), report


def propagated_again(motion: Trajectory, times: Array, threads: int | None = None) -> Trajectory:
    """Return the motion at other times, by another propagation from its initial state."""
    system, run = motion.system, motion.run
    events = [record.event for record in motion.events]
    formulas = isinstance(system, RecordedSystem) or any(isinstance(event, RecordedEvent) for event in events)
    if formulas or not system.dynamics.moves_alone:
        raise ValueError(
            "times must be among the times of a motion without formulas, such as a motion from a file, got others. "
            "Propagate the system, or choose some of motion.times."
        )
    integrated = run.formulation in FORMULATIONS
    try:
        return propagate(
            system,
            motion.initial,
            times,
            events=events,
            formulation=run.formulation if integrated else None,
            tolerance=run.tolerance if integrated else None,
            precision=run.precision,
            threads=threads,
            progress=False,
        )
    except PropagationError as error:
        stopped: Trajectory = error.trajectory
        return stopped
