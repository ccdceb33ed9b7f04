"""Integration of the equations of motion by Taylor's method."""

from __future__ import annotations

import functools
import sys
import time as clock
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.engine import kernels
from poinsot.engine.ensemble import Ensemble, integrate_members
from poinsot.engine.event_detection import Recorded
from poinsot.engine.problem import Problem
from poinsot.engine.progress import bar
from poinsot.engine.state_vector import Coordinates
from poinsot.engine.termination import INTERRUPTED, TRIES, reason
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.functions import Vector
from poinsot.mechanics.event import Event
from poinsot.mechanics.shared_orbits import tracked_orbits
from poinsot.mechanics.state import Phase, State, changed, state_of
from poinsot.mechanics.system import System
from poinsot.propagation.arguments import (
    broadcast_members,
    check_kinds,
    check_span,
    checked_formulation,
    checked_threads,
    checked_times,
    checked_tolerance,
    members_of,
)
from poinsot.propagation.event_record import checked_events, crossings
from poinsot.propagation.trajectory import Method, Run, Trajectory, versions
from poinsot.quantities import Times

__all__ = ["propagate"]

STEPS_AT_A_TIME = 20_000
"""Steps between two looks at the keyboard: some tens of milliseconds."""

Array = NDArray[Any]


@checked
def propagate(
    system: System,
    state: State,
    times: Times,
    *,
    events: Sequence[Event] = (),
    formulation: str | None = None,
    tolerance: float | None = None,
    dense: bool = False,
    precision: str = "double",
    threads: int | None = None,
    progress: bool | None = None,
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
    formulation : {"lie_poisson", "canonical", "euler_angles"}, optional
        The variables integrated; results look the same. Default: the fastest, "lie_poisson", (q, g). The others
        have g from their own: the rate about an axis of small moment loses I_max / I_min roundings of theirs.
    tolerance : float, optional
        Relative error per step; default: the rounding unit of the precision, which is the smallest.
    dense : bool
        Keep the Taylor polynomials, so that `motion(t)` gives the state at any time in between.
    precision : {"double", "extended", "quadruple"}
        Of the arithmetic. Results are rounded to double.
    threads : int, optional
        For an ensemble; default: all the cores that the process may use.
    progress : bool, optional
        Show a bar of a run that lasts; default: of an ensemble, on a terminal.

    Raises
    ------
    PropagationError
        If the run becomes singular; it carries the time reached and the partial trajectory.
    PropagationInterrupted
        On Ctrl-C (a KeyboardInterrupt), with the same two.
    """
    check_kinds("propagate(system, state, times)", {"system": (system, System), "state": (state, State)})
    t = checked_times(times, system)
    chosen = checked_formulation(formulation)
    asked = checked_tolerance(tolerance, precision)
    problem = Problem(system, checked_events(events))
    check_span(problem, state, t)
    members = members_of(problem, state)
    if members:
        shown = sys.stderr.isatty() if progress is None else progress
        _check_single(dense, precision)
        state = broadcast_members(state, members)
        variables = kernels.coordinates(problem, state, chosen, precision)
        return _propagate_members(problem, state, t, variables, asked, checked_threads(threads), shown)
    variables = kernels.coordinates(problem, state, chosen, precision)
    start, origin = variables.from_state(_in_precision(state, precision)), float(state.time)
    ends = np.append(t, origin)
    with (
        bar("time", float(np.ptp(ends)), bool(progress)) as report,
        kernels.integrator(problem, variables, precision, asked) as borrowed,
    ):
        engine = borrowed.engine
        began = clock.perf_counter()
        rising = np.sort(t)
        middle = int(np.searchsorted(rising, origin))
        grids = (rising[middle:], rising[:middle][::-1])
        halves = [_Half(borrowed, origin, start, grid, precision, dense, report) for grid in grids]
        for half in halves:
            if not any(other.stopped == INTERRUPTED for other in halves):
                half.run()
        wall_time = clock.perf_counter() - began
        steps = sum(half.steps for half in halves)
        run = Run(Method.TAYLOR, chosen, precision, float(engine.tol), engine.order, steps, wall_time, versions())
    motion = _join(problem, state, t, halves, variables, run, dense)
    for half in halves:
        if half.stopped:
            raise half.error(motion) from half.cause
    return motion


def _propagate_members(
    problem: Problem,
    state: State,
    t: Array,
    variables: Coordinates,
    tolerance: float,
    threads: int,
    progress: bool,
) -> Trajectory:
    count = members_of(problem, state)[0]
    done = Ensemble(count, t.size, variables.formulation, variables.axes.size if tracked_orbits(problem) else 0)
    integrate_members(problem, state, np.sort(t), variables, tolerance, threads, progress, done)
    name, steps = variables.formulation.name, int(done.steps.sum())
    run = Run(Method.TAYLOR_OF_MEMBERS, name, "double", done.tolerance, done.order, steps, done.wall_time, versions())
    order = slice(None, None, 1 if _rises(t) else -1)
    phase = changed(done.phase, lambda x: x[:, order])
    environment = (
        functools.partial(variables.environment, problem, t, done.comoving[:, order]) if done.comoving.size else None
    )
    failures = dict(sorted(done.failures.items()))
    motion = Trajectory(problem.system, state, t, lambda: phase, run, failures=failures, environment=environment)
    motion.events = crossings(problem.system, problem.events, variables, done.happened, _rises(t))
    if done.interrupted:
        message = f"propagation was interrupted: {done.finished} of {len(done.steps)} members are done."
        raise PropagationInterrupted(message, float(t[-1]), motion)
    return motion


class _Half:
    """The integration in one direction, in chunks of steps between which an interrupt is heard."""

    def __init__(
        self,
        borrowed: kernels.Borrowed,
        origin: float,
        start: Array,
        grid: Array,
        precision: str,
        dense: bool,
        report: Callable[[float], None],
    ) -> None:
        self.report = report
        self.kind: Any = kernels.PRECISIONS[precision]
        self.borrowed, self.engine = borrowed, borrowed.engine
        self.origin, self.start, self.grid, self.dense = origin, start, grid, dense
        self.last = float(grid[-1]) if grid.size else origin
        self.rows: list[Array] = []
        self.pieces: list[Any] = []
        self.bits: list[int] = []
        self.variables = borrowed.variables
        self.closely, self.tries = False, 0
        self.steps, self.reached, self.stopped = 0, origin, ""
        self.happened: list[Recorded] = []
        self.cause: BaseException | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return what evaluates the polynomials, without the integrator."""
        return {name: value for name, value in vars(self).items() if name not in ("borrowed", "engine", "report")}

    def run(self) -> None:
        """Integrate to the last time of the grid, or to where it stops."""
        if not self.grid.size:
            return
        self._limit_steps(0)
        self._place((self.kind(self.origin), self.kind(0.0)), self._typed(self.start))
        watch = self.borrowed.watch
        if watch is not None:
            watch.records = self.happened
        try:
            while not self._advance():
                pass
        except KeyboardInterrupt:
            self.stopped = INTERRUPTED
        if watch is not None:
            watch.records, self.cause = [], watch.error
        if self.pieces:
            self._read_pieces()

    def _place(self, time: Any, state: Array) -> None:
        self.engine.dtime, self.engine.state[:] = time, state
        self.borrowed.begin(self.last >= self.origin)

    def _limit_steps(self, tries: int) -> None:
        self.tries = tries
        self.borrowed.limit_steps(np.array([abs(self.last - self.origin)]), tries)

    def _mark(self) -> Callable[[], None]:
        """Return what brings the run back to where it is."""
        time, state = self.engine.dtime, self.borrowed.scales.outward(self.engine.state.copy(), 0)
        lists: tuple[list[Any], ...] = (self.rows, self.pieces, self.bits, self.happened)
        counts = [len(one) for one in lists]

        def back() -> None:
            self._place(time, state)
            for one, count in zip(lists, counts, strict=True):
                del one[count:]

        return back

    def _advance(self) -> bool:
        """Take a chunk of steps, again if momenta left their band in it; return whether it was the last."""
        back, most = self._mark(), STEPS_AT_A_TIME
        if self.closely:
            most = self.borrowed.sound_steps(self.kind(self.last), most)
            back()
        result, rows = self._step(most)
        outcome, steps = self.borrowed.outcome(result[0]), result[3]
        if outcome == "step_limit" and self.engine.time == self.last:
            outcome = "time_limit"
        doubtful = self.borrowed.doubtful(0, result, rows)
        if self._goes_back(doubtful, back):
            return False
        if outcome == "err_nf_state":
            back()
        self.closely = doubtful
        self.borrowed.rescale()
        at_end = outcome == "time_limit"
        if at_end and self.borrowed.watch is not None:
            self.borrowed.watch.look(self.engine)
            outcome = self.borrowed.watch.stopped[0] or outcome
        before, self.reached = self.reached, self.last if at_end else float(self.engine.time)
        self.steps += steps
        advance, ahead = abs(self.reached - before), abs(self.last - self.reached)
        self.report(advance)
        if outcome == "event":
            self._keep_end()
        if most == STEPS_AT_A_TIME or outcome != "step_limit":
            self.stopped = reason(outcome, advance, self.reached, ahead, STEPS_AT_A_TIME)
        return at_end or outcome == "event" or bool(self.stopped)

    def _goes_back(self, doubtful: bool, back: Callable[[], None]) -> bool:
        """Go back to the start of a chunk that must be taken again, closely or for a lost zero; return whether so."""
        if doubtful and not self.closely:
            self.closely = True
        elif not self.borrowed.overlooked():
            if self.tries:
                self._limit_steps(0)
            return False
        elif self.tries == TRIES:
            self.borrowed.settle()
            self._limit_steps(0)
            return False
        else:
            self._limit_steps(self.tries + 1)
        back()
        return True

    def _step(self, most: int) -> tuple[Any, Array]:
        """Take steps; return the engine's result, and variables on the way."""
        self.borrowed.certain(self.closely)
        return self._step_dense(most) if self.dense else self._step_on_grid(most)

    def _step_dense(self, most: int) -> tuple[Any, Array]:
        result = self.engine.propagate_until(
            self.kind(self.last), max_steps=most, c_output=True, **self.borrowed.limits
        )
        if (piece := result[4]) is None:
            return result, self.engine.state[None]
        self.pieces.append(piece)
        self.bits.append(int(self.borrowed.scales.bits[0]))
        return result, piece.tcs[:, :, 0]

    def _step_on_grid(self, most: int) -> tuple[Any, Array]:
        ahead = self._typed(self.grid[sum(map(len, self.rows)) :])
        here = self._typed([self.engine.time])
        between = here[: int(ahead[0] != here[0])]  # the engine wants a grid that starts where it is
        result = self.engine.propagate_grid(np.concatenate([between, ahead]), max_steps=most, **self.borrowed.limits)
        rows = result[5][len(between) :]
        self.rows.append(self.borrowed.scales.outward(np.asarray(rows, dtype=float), 0))
        return result, rows

    def _keep_end(self) -> None:
        """Keep the row at which an event ends the motion: the engine leaves it out."""
        ahead = self.grid[sum(map(len, self.rows)) :]
        if not self.dense and ahead.size and ahead[0] == self.reached:
            self.rows.append(self.borrowed.scales.outward(np.array(self.engine.state[None], dtype=float), 0))

    def _typed(self, values: Any) -> Array:
        return np.asarray(values) if self.kind is np.float64 else np.array([self.kind(x) for x in values])

    def error(self, motion: Trajectory) -> BaseException:
        """Return what to raise about a half that stopped."""
        kind = PropagationInterrupted if self.stopped == INTERRUPTED else PropagationError
        message = f"propagation stopped at t = {self.reached:.10g} of {self.last:.10g}: {self.stopped}"
        return kind(message, self.reached, motion)

    def _read_pieces(self) -> None:
        inside = np.abs(self.grid - self.origin) <= abs(self.reached - self.origin)
        self.rows = [self.evaluate(self.grid[inside]).copy()]

    def evaluate(self, times: Array) -> Array:
        """Return the variables at times within this half, from its Taylor polynomials, until the next call."""
        if len(self.pieces) == 1:
            return self._evaluated(0, times)
        ends = np.array([float(piece.bounds[1]) for piece in self.pieces])
        sign = np.sign(self.last - self.origin) or 1.0
        which = np.minimum(np.searchsorted(sign * ends, sign * times), len(ends) - 1)
        out = np.empty((times.size, self.start.size))
        for i in np.unique(which):
            chosen = which == i
            out[chosen] = self._evaluated(i, times[chosen])
        return out

    def _evaluated(self, number: int, times: Array) -> Array:
        rows = np.asarray(self.pieces[number](self._typed(times)), dtype=float)
        return self.variables.rescaled(rows, -self.bits[number])


def _join(
    problem: Problem,
    state: State,
    t: Array,
    halves: list[_Half],
    variables: Coordinates,
    run: Run,
    dense: bool,
) -> Trajectory:
    """Put the two halves into the order of the requested times; rows that were not reached are left out."""
    later, earlier = halves
    count = [sum(map(len, half.rows)) for half in halves]
    rows = _stacked([*(part[::-1] for part in reversed(earlier.rows)), *later.rows], variables.size)
    times = np.concatenate([earlier.grid[: count[1]][::-1], later.grid[: count[0]]])
    if not _rises(t):
        rows, times = rows[::-1], times[::-1]
    dense_output = functools.partial(_phase_at, halves, variables)
    interpolant = (dense_output, halves[1].reached, halves[0].reached) if dense else None
    environment = None
    if tracked_orbits(problem):
        environment = functools.partial(variables.environment, problem, times, rows[:, variables.formulation.size :])
    motion = Trajectory(
        problem.system, state, times, lambda: variables.to_phase(times, rows), run, interpolant, environment=environment
    )
    found = [(0, record) for half in halves for record in half.happened]
    motion.events = crossings(problem.system, problem.events, variables, found, _rises(t))
    return motion


def _rises(times: Array) -> bool:
    return times.size < 2 or bool(times[0] < times[1])


def _stacked(parts: list[Array], size: int) -> Array:
    """Return the parts one below the other, without a copy where there is only one."""
    parts = [part for part in parts if len(part)]
    return parts[0] if len(parts) == 1 else np.concatenate([np.empty((0, size)), *parts])


def _phase_at(halves: list[_Half], variables: Coordinates, times: Array) -> Phase:
    """Return q and the momenta at times, from the polynomials of both halves."""
    if not halves[1].pieces and halves[0].pieces:
        return variables.to_phase(times, halves[0].evaluate(times))
    out = np.empty((times.size, variables.size))
    for half, chosen in zip(halves, (times >= halves[0].origin, times < halves[0].origin), strict=True):
        if np.any(chosen):
            out[chosen] = half.evaluate(times[chosen]) if half.pieces else half.start
    return variables.to_phase(times, out)


def _in_precision(state: State, precision: str) -> State:
    if precision == "double":
        return state
    kind = kernels.PRECISIONS[precision]
    return state_of(changed(state.phase, lambda array: Vector(map(kind, array))), state.time)


def _check_single(dense: bool, precision: str) -> None:
    if dense or precision != "double":
        what = "dense=True" if dense else f"precision={precision!r}"
        raise ValueError(f"an ensemble must be propagated without {what}, got it. Propagate members one by one.")
