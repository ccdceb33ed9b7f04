"""Integration of the equations of motion by Taylor's method."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from typing_extensions import Unpack

from poinsot.checked import checked
from poinsot.engine import kernels
from poinsot.engine.formulations import Formulation
from poinsot.engine.problem import Problem
from poinsot.mechanics.event import Event
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System
from poinsot.printable import quoted
from poinsot.propagation.arguments import (
    broadcast_members,
    check_bodies,
    check_span,
    check_starts,
    checked_device,
    checked_formulation,
    checked_threads,
    checked_times,
    checked_tolerance,
    members_of,
)
from poinsot.propagation.chunks import Chunking, in_chunks, plan_of
from poinsot.propagation.ensemble_of_motions import EnsembleOfMotions
from poinsot.propagation.integrator import Integrator
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Times

__all__ = ["propagate"]


@checked
def propagate(
    system: System,
    state: State,
    times: Times,
    *,
    events: Sequence[Event] = (),
    formulation: str | Formulation | None = None,
    tolerance: float | None = None,
    dense: bool = False,
    precision: str = "double",
    threads: int | None = None,
    progress: bool | None = None,
    device: str = "cpu",
    **chunking: Unpack[Chunking],
) -> Trajectory:
    """Return the motion of a system from a state, at the given times.

    Also without forces this is an integration; `free_motion` has the closed form.

    The integration runs outwards from the state's time in both directions. Arrays of states, moments or
    parameters with a member axis make an ensemble: all results gain that axis first.

    Parameters
    ----------
    system : System
    state : State
        Its time may be anywhere.
    times : array (n,)
        Strictly monotonic, up or down; the results are in this order. Dates where an orbit has a calendar.
    events : list of Event
        What to watch for: `motion.events` has the times and the states of each.
    formulation : {"lie_poisson", "canonical", "euler_angles", "planar"} or Formulation, optional
        The variables integrated; results look the same. Default: the fastest, "lie_poisson", (q, g). The others
        have g from their own: the rate about an axis of small moment loses I_max / I_min roundings of theirs.
        "planar": one angle, for a body that turns about its third axis alone.
    tolerance : float, optional
        Relative error per step. Default, and the least: the rounding unit of the precision, 2.2e-16 in double.
    dense : bool
        Keep the Taylor polynomials, so that `motion(t)` gives the state at any time in between.
    precision : {"double", "extended", "quadruple"}
        Of the arithmetic. Results are rounded to double.
    threads : int, optional
        For an ensemble; default: all the cores that the process may use.
    progress : bool, optional
        Show a bar of a run that lasts; default: of an ensemble, on a terminal.
    device : {"cpu", "cuda"}
        Where an ensemble is integrated: "cuda", on a GPU of NVIDIA (`pip install 'poinsot[cuda]'`).
    **chunking
        `out`, `chunk`, `variables`, `reduce`, `client`: an ensemble in chunks of members, to a store or on a cluster;
        docs/stores.md and docs/cluster.md.

    Raises
    ------
    PropagationError
        If the run becomes singular; it carries the time reached and the partial trajectory.
    PropagationInterrupted
        On Ctrl-C (a KeyboardInterrupt), after the steps under way, with the same two. Ctrl-C again is heard at once.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> top = pt.System(body, pt.UniformGravity(0.5, (1, 0, 0)), units={"time": "s"})
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 3.0))
    >>> motion = pt.propagate(top, start, np.linspace(0, 10, 101))
    >>> motion.omega_body.shape, bool(np.ptp(motion.energy) < 1e-13)
    ((101, 3), True)
    """
    t = checked_times(times, system)
    chosen = checked_formulation(formulation)
    asked = checked_tolerance(tolerance, precision)
    problem = Problem(system, events)
    check_bodies(system, state)
    check_span(problem, state, t)
    members, plan = members_of(problem, state), plan_of(**chunking) if chunking else None
    if plan and not members:
        raise ValueError("out, chunk, reduce and client must be given for an ensemble, got one body. Save its motion.")
    if members:
        _check_single(dense, precision)
        state = broadcast_members(state, members)
    check_starts(problem, state)
    variables = kernels.state_vector(problem, state, chosen, precision)
    where = checked_device(device)
    cores = checked_threads(plan.threads(threads) if plan else threads) if members else 1
    shown = bool(members) and sys.stderr.isatty() if progress is None else progress
    integrator = Integrator(
        problem, variables, asked, precision=precision, threads=cores, progress=shown, dense=dense, device=where
    )
    if not (plan and plan.client):  # whose workers have devices of their own
        integrator.check_device(bool(members))
    if members and plan:
        result: Trajectory = in_chunks(EnsembleOfMotions(integrator, state, t, plan.provenance), plan, shown)
        return result
    motion, report = integrator.motion(state, t)
    if members:
        report.check("propagation", float(t[-1]), motion)
    else:
        report.check_one(float(t[-1]), motion)
    return motion


def _check_single(dense: bool, precision: str) -> None:
    if dense or precision != "double":
        what = "dense=True" if dense else f"precision={quoted(precision)}"
        raise ValueError(f"an ensemble must be propagated without {what}, got it. Propagate members one by one.")
