"""Integration of the equations of motion by Taylor's method."""

from __future__ import annotations

import functools
import platform
import time as clock
from collections.abc import Callable
from importlib import metadata
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import PropagationError, real_array
from poinsot.mechanics.formulations import DEFAULT_FORMULATION, FORMULATIONS, Formulation
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System
from poinsot.motion import kernels
from poinsot.motion.trajectory import Run, Trajectory

__all__ = ["propagate"]

STEPS_AT_A_TIME = 20_000
"""Steps between two looks at the keyboard: some tens of milliseconds."""

Array = NDArray[Any]


def propagate(
    system: System,
    state: State,
    times: ArrayLike,
    *,
    formulation: str | None = None,
    tolerance: float | None = None,
    dense: bool = False,
    precision: str = "double",
) -> Trajectory:
    """Return the motion of a system from a state, at the given times.

    The integration runs outwards from the state's time in both directions.

    Parameters
    ----------
    system : System
    state : State
        One state; its time may be anywhere.
    times : array (n,)
        Strictly monotonic, up or down; the results are in this order.
    formulation : {"lie_poisson", "canonical", "euler_angles"}, optional
        The variables integrated; results look the same. Default: the fastest, "lie_poisson".
    tolerance : float, optional
        Relative error per step; default: the rounding unit of the precision.
    dense : bool
        Keep the Taylor polynomials, so that `motion(t)` gives the state at any time in between.
    precision : {"double", "extended", "quadruple"}
        Of the arithmetic. Results are rounded to double.

    Raises
    ------
    PropagationError
        If the run becomes singular; it carries the time reached and the partial trajectory.
    """
    _check_order(system, state)
    t = _checked_times(times)
    chosen = _checked_formulation(formulation)
    asked = _checked_tolerance(tolerance, precision)
    start, origin = chosen.from_state(state), float(state.time)
    with kernels.integrator(system, chosen.name, precision, asked) as engine:
        began, order, tolerance = clock.perf_counter(), engine.order, float(engine.tol)
        rising = np.sort(t)
        middle = int(np.searchsorted(rising, origin))
        halves = [
            _Half(engine, origin, start, rising[middle:], precision, dense).run(),
            _Half(engine, origin, start, rising[:middle][::-1], precision, dense).run(),
        ]
    run = Run(
        "Taylor",
        chosen.name,
        precision,
        tolerance,
        order,
        sum(half.steps for half in halves),
        clock.perf_counter() - began,
        _versions(),
    )
    motion = _join(system, state, t, halves, chosen, run, dense)
    for half in halves:
        if half.stopped:
            raise PropagationError(
                f"propagation stopped at t = {half.reached:.10g} of {half.last:.10g}: {half.stopped}",
                half.reached,
                motion,
            )
    return motion


class _Half:
    """The integration in one direction, in chunks of steps between which an interrupt is heard."""

    def __init__(self, engine: Any, origin: float, start: Array, grid: Array, precision: str, dense: bool) -> None:
        self.kind: Any = kernels.PRECISIONS[precision]
        self.engine, self.origin, self.start, self.grid, self.dense = engine, origin, start, grid, dense
        self.last = float(grid[-1]) if grid.size else origin
        self.rows: list[Array] = []
        self.pieces: list[Any] = []
        self.steps, self.reached, self.stopped = 0, origin, ""

    def run(self) -> _Half:
        """Integrate to the last time of the grid, or to where it stops."""
        if not self.grid.size:
            return self
        self.engine.time = self.kind(self.origin)
        self.engine.state[:] = [self.kind(x) for x in self.start]
        if self.engine.with_events:
            self.engine.reset_cooldowns()
        advance = self._advance_dense if self.dense else self._advance_on_grid
        while not self._finished(*advance()):
            pass
        if self.pieces:
            self._read_pieces()
        return self

    def _advance_dense(self) -> tuple[Any, int]:
        outcome, _, _, steps, piece, _ = self.engine.propagate_until(
            self.kind(self.last), max_steps=STEPS_AT_A_TIME, c_output=True
        )
        if piece is not None:
            self.pieces.append(piece)
        return outcome, steps

    def _advance_on_grid(self) -> tuple[Any, int]:
        ahead = [self.kind(x) for x in self.grid[sum(map(len, self.rows)) :]]
        here = self.engine.time
        between = [] if ahead[0] == here else [here]  # the engine wants a grid that starts where it is
        outcome, _, _, steps, _, rows = self.engine.propagate_grid(np.array(between + ahead), max_steps=STEPS_AT_A_TIME)
        self.rows.append(np.asarray(rows[len(between) :], dtype=float))
        return outcome, steps

    def _finished(self, outcome: Any, steps: int) -> bool:
        before, self.reached = self.reached, float(self.engine.time)
        self.steps += steps
        name = outcome.name
        if name == "time_limit":
            return True
        if name == "step_limit":
            stuck = abs(self.reached - before) <= STEPS_AT_A_TIME * np.spacing(max(abs(before), abs(self.reached)))
            self.stopped = "the step size fell to rounding. The equations are singular there." if stuck else ""
        elif name == "err_nf_state":
            self.stopped = "the state became non-finite. A force is singular there."
        else:
            self.stopped = (
                "sin(theta) fell below 1e-6. The Euler angles 3-1-3 are singular there; use another formulation."
            )
        return bool(self.stopped)

    def _read_pieces(self) -> None:
        inside = np.abs(self.grid - self.origin) <= abs(self.reached - self.origin)
        self.rows = [self.evaluate(self.grid[inside])]

    def evaluate(self, times: Array) -> Array:
        """Return the variables at times within this half, from its Taylor polynomials."""
        ends = np.array([float(piece.bounds[1]) for piece in self.pieces])
        sign = np.sign(self.last - self.origin) or 1.0
        which = np.minimum(np.searchsorted(sign * ends, sign * times), len(ends) - 1)
        out = np.empty((times.size, self.start.size))
        for i in np.unique(which):
            chosen = which == i
            out[chosen] = np.asarray(self.pieces[i](np.array([self.kind(x) for x in times[chosen]])), dtype=float)
        return out


def _join(
    system: System,
    state: State,
    t: Array,
    halves: list[_Half],
    formulation: Formulation,
    run: Run,
    dense: bool,
) -> Trajectory:
    """Put the two halves into the order of the requested times; rows that were not reached are left out."""
    later, earlier = (np.concatenate([np.empty((0, formulation.size)), *half.rows]) for half in halves)
    rows = np.concatenate([earlier[::-1], later])
    times = np.concatenate([halves[1].grid[: len(earlier)][::-1], halves[0].grid[: len(later)]])
    if t.size > 1 and t[0] > t[1]:
        rows, times = rows[::-1], times[::-1]
    interpolant = (_interpolant(halves, formulation), halves[1].reached, halves[0].reached) if dense else None
    return Trajectory(system, state, times, formulation.to_canonical(rows), run, interpolant)


def _interpolant(halves: list[_Half], formulation: Formulation) -> Callable[[Array], tuple[Array, Array]]:
    def canonical_at(times: Array) -> tuple[Array, Array]:
        out = np.empty((times.size, formulation.size))
        for half, chosen in zip(halves, (times >= halves[0].origin, times < halves[0].origin), strict=True):
            if np.any(chosen):
                out[chosen] = half.evaluate(times[chosen]) if half.pieces else half.start
        return formulation.to_canonical(out)

    return canonical_at


def _check_order(system: Any, state: Any) -> None:
    for name, value, kind in (("system", system, System), ("state", state, State)):
        if not isinstance(value, kind):
            raise TypeError(
                f"{name} must be a {kind.__name__}, but {type(value).__name__} came. "
                "The order is propagate(system, state, times)."
            )
    if state.quaternion.ndim != 1 or state.time.ndim != 0:
        raise ValueError(f"state must be one state, but a batch of {len(np.atleast_1d(state.time))} came.")


def _checked_times(times: ArrayLike) -> NDArray[np.float64]:
    t = real_array("times", times, (None,))
    if t.size == 0:
        raise ValueError("times must not be empty, but shape (0,) came.")
    steps = np.diff(t)
    wrong = np.flatnonzero(steps * (steps[0] if t.size > 1 else 1) <= 0)
    if wrong.size:
        i = int(wrong[0])
        relation = f"= times[{i + 1}] = {t[i]}" if steps[i] == 0 else f"= {t[i]} and times[{i + 1}] = {t[i + 1]}"
        raise ValueError(f"times must be strictly monotonic, but times[{i}] {relation}.")
    return t


def _checked_formulation(name: str | None) -> Formulation:
    name = DEFAULT_FORMULATION if name is None else name
    if name not in FORMULATIONS:
        raise ValueError(f"formulation must be one of {', '.join(FORMULATIONS)}, but {name!r} came.")
    return FORMULATIONS[name]


def _checked_tolerance(tolerance: float | None, precision: str) -> float:
    if precision not in kernels.PRECISIONS:
        raise ValueError(f"precision must be one of {', '.join(kernels.PRECISIONS)}, but {precision!r} came.")
    if not kernels.available(precision):
        raise ValueError(
            f"precision must be one that the engine has on this machine, but {precision!r} came. Use 'double'."
        )
    if tolerance is None:
        return 0.0
    value = float(real_array("tolerance", tolerance, ()))
    if not 0 < value < 1:
        raise ValueError(f"tolerance must be between 0 and 1, but {value} came.")
    return value


@functools.cache
def _versions() -> dict[str, str]:
    packages = {name: metadata.version(name) for name in ("poinsot", "heyoka", "numpy", "scipy")}
    return {**packages, "python": platform.python_version()}
