"""One driver for one body, for ensembles and for variations, forwards and backwards: it hands rows to a sink."""

from __future__ import annotations

import functools
import os
import threading
import time as clock
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.engine import kernels
from poinsot.engine.event_detection import Recorded
from poinsot.engine.integration import BatchStepper, DenseStepper, Integration, Polynomials, ScalarStepper, Stepper
from poinsot.engine.problem import Problem
from poinsot.engine.progress import bar
from poinsot.engine.state_vector import StateVector
from poinsot.engine.termination import INTERRUPTED, HeldInterrupts
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.functions import Vector
from poinsot.mechanics.state import Phase, State, changed, state_of

__all__ = [
    "BOTH_WAYS",
    "DenseOutput",
    "Driver",
    "Memory",
    "OneMotion",
    "Report",
    "Rows",
    "Sink",
    "Stop",
    "allowed_threads",
]

SLAB_BYTES = 8_000_000
"""The most that a thread holds of its members' variables before it hands them over."""

BATCHES_IN_A_SLAB = 16

BOTH_WAYS = (True, False)
"""Forwards, then backwards."""

VARIATIONS = ("vectors", "pairs", "exponents")

Array = NDArray[Any]


class Rows:
    """Variables along times by name, converted when they are asked for.

    `quaternion`, the momenta that are integrated and the variables of parts; `orbits`, those of all orbits; of
    variations `vectors`, `pairs` and `exponents`. Shapes (members, n, ...), of one body (n, ...).
    """

    def __init__(self, variables: StateVector, times: Array, values: Array) -> None:
        self._variables, self._times, self._values = variables, times, values

    @functools.cached_property
    def phase(self) -> Phase:
        """The quaternion and the momenta."""
        return self._variables.to_phase(self._times, self._values)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Which vectors each of the `pairs` is of."""
        return self._variables.variations.pairs if self._variables.variations else []

    @functools.cached_property
    def _variations(self) -> dict[str, Array]:
        variations, values = self._variables.variations, self._values[..., self._variables.tangent]
        return dict(zip(VARIATIONS, variations.read(values), strict=True)) if variations else {}

    def __getitem__(self, name: str) -> Array:
        if name == "orbits":
            return self._values[..., self._variables.along_orbits]
        return self._variations[name] if name in VARIATIONS else self.phase[name]


class Sink(Protocol):
    """What rows are handed to."""

    def take(self, members: NDArray[np.int_], times: Array, rows: Rows) -> None:
        """Keep what there is to keep of some members, shapes (members, n, ...), NaN where they did not get.

        Several threads call it, each for other members. Of one body rows have shape (n, ...), at times reached.
        """


class Memory:
    """Keeps what is integrated of an ensemble, NaN where members did not get, and rows of further names.

    Parameters
    ----------
    variables : StateVector
    members : int
    times : array (n,)
    **others : tuple of int
        Name -> shape of its rows.
    """

    def __init__(self, variables: StateVector, members: int, times: Array, **others: tuple[int, ...]) -> None:
        self.times, shape = times, (members, times.size)
        self.phase = {name: np.full((*shape, size), np.nan) for name, size in variables.sizes.items()}
        self.rows = self.phase | {name: np.full((*shape, *own), np.nan) for name, own in others.items()}

    def take(self, members: NDArray[np.int_], times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Keep the rows of some members."""
        for name, kept in self.rows.items():
            kept[members] = rows[name]


class OneMotion:
    """Keeps the rows of one body, at the times that it reached."""

    times: Array
    rows: Rows

    @property
    def phase(self) -> Phase:
        """What is integrated."""
        return self.rows.phase

    def take(self, members: NDArray[np.int_], times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Keep them as they are, to be converted when they are asked for."""
        self.times, self.rows = times, rows


class Stop(NamedTuple):
    """Where a motion stopped before its end, and why."""

    why: str
    time: float
    last: float
    cause: BaseException | None

    @property
    def sentence(self) -> str:
        """What is said about it."""
        return f"propagation stopped at t = {self.time:.10g} of {self.last:.10g}: {self.why}"


@dataclass
class Report:
    """What is known about a run.

    Attributes
    ----------
    steps : array (members,)
    stops : dict
        Member -> why and where it stopped.
    events : list
        Pairs of a member and what was recorded of an event.
    finished : int
        How many members are done; of the others of an interrupted run there are no rows.
    order, tolerance
        Of the integrator.
    wall_time : float
        Seconds; of one body without the building of the integrator.
    interrupted : bool
    dense : DenseOutput or None
    """

    steps: NDArray[np.int_]
    stops: dict[int, Stop] = field(default_factory=dict)
    events: list[tuple[int, Recorded]] = field(default_factory=list)
    finished: int = 0
    order: int = 0
    tolerance: float = 0.0
    wall_time: float = 0.0
    interrupted: bool = False
    dense: DenseOutput | None = None

    @property
    def failures(self) -> dict[int, str]:
        """Member -> the sentence about it."""
        return {member: stop.sentence for member, stop in sorted(self.stops.items())}

    def check(self, what: str, last: float, result: object) -> None:
        """Raise what tells of Ctrl-C and has the result of the members that are done, if there was one."""
        if self.interrupted:
            message = f"{what} was interrupted: {self.finished} of {len(self.steps)} members are done."
            raise PropagationInterrupted(message, last, result)

    def check_one(self, last: float, result: object) -> None:
        """Raise what tells why one body stopped, if it did, and has the result up to there."""
        at_end = [Stop(INTERRUPTED, last, last, None)] if self.interrupted else []
        for stop in [*self.stops.values(), *at_end]:
            kind = PropagationInterrupted if stop.why == INTERRUPTED else PropagationError
            raise kind(stop.sentence, stop.time, result) from stop.cause

    def add(self, later: Report) -> None:
        """Count what a later piece of the same motions took; the first stop of a member stays."""
        self.steps, self.wall_time = self.steps + later.steps, self.wall_time + later.wall_time
        self.order, self.tolerance, self.stops = later.order, later.tolerance, later.stops | self.stops


class DenseOutput:
    """A motion at any time between the two that it has reached, from its Taylor polynomials."""

    def __init__(self, variables: StateVector, origin: float, start: Array, kind: Any) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.parts = {forwards: Polynomials(variables, kind, forwards) for forwards in BOTH_WAYS}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """The earliest time and the latest."""
        later, earlier = (self.reached.get(forwards, self._origin) for forwards in BOTH_WAYS)
        return earlier, later

    def __call__(self, times: Array) -> Phase:
        """Return q and the momenta."""
        later, earlier = self.parts.values()
        if later.pieces and not earlier.pieces:
            return self._variables.to_phase(times, later.at(times))
        out = np.empty((times.size, self._variables.size))
        for part, chosen in ((later, times >= self._origin), (earlier, times < self._origin)):
            if np.any(chosen):
                out[chosen] = part.at(times[chosen]) if part.pieces else self._start
        return self._variables.to_phase(times, out)


@dataclass(frozen=True)
class Driver:
    """Integrates a problem in given variables.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    tolerance : float
        Relative, of a step.
    precision : str
        Of one body; an ensemble has double precision.
    threads : int
        At most, for an ensemble.
    progress : bool
        Whether to show a bar of a run that lasts.
    dense : bool
        Whether to keep the polynomials, of one body.
    """

    problem: Problem
    variables: StateVector
    tolerance: float
    _: KW_ONLY
    precision: str = "double"
    threads: int = 1
    progress: bool = False
    dense: bool = False

    def run(self, state: State, times: Array, sink: Sink, ways: tuple[bool, ...] = BOTH_WAYS) -> Report:
        """Integrate from a state outwards to all the times, which are monotonic; on Ctrl-C what is finished is kept.

        A state with one time is that of one body, one with times those of an ensemble.
        """
        kind = _Members if state.time.ndim else _OneBody
        run = kind(self, state, times, sink, ways)
        with HeldInterrupts(run.interrupt):
            run.go()
        return run.report


class _Run:
    """One run of a driver."""

    def __init__(self, driver: Driver, state: State, times: Array, sink: Sink, ways: tuple[bool, ...]) -> None:
        self.driver, self.state, self.times, self.sink, self.ways = driver, state, times, sink, ways
        self.turn = slice(None, None, 1 if times[0] <= times[-1] else -1)
        self.rising, self.origins = times[self.turn], state.time.reshape(-1)
        self.report, self.stop = Report(np.zeros(self.origins.size, dtype=int)), False
        start = driver.variables.from_state(_in_precision(state, driver.precision))
        self.starts = start.reshape(-1, start.shape[-1])

    def interrupt(self) -> None:
        """Let the run stop after the chunks of steps that are under way, and keep what it has."""
        self.stop = self.report.interrupted = True

    def kernel(self, lanes: int) -> AbstractContextManager[kernels.Kernel]:
        """Provide the kernel."""
        own = self.driver
        return kernels.kernel_of(own.problem, own.variables, own.precision, own.tolerance, lanes)

    def integrations(
        self, stepper: Callable[[bool], Stepper], members: NDArray[np.int_]
    ) -> Iterator[tuple[Integration, NDArray[np.int_]]]:
        """Yield the integration of members in each direction, and where in the rising times each of them starts."""
        origins, starts = self.origins[members], self.starts[members]
        places = self.rising.searchsorted(origins)
        for forwards in self.ways:
            grids = [self.rising[place:] if forwards else self.rising[:place][::-1] for place in places]
            if any(grid.size for grid in grids):
                yield Integration(stepper(forwards), members, starts, origins, grids, forwards), places

    def book(self, integrations: list[Integration]) -> None:
        """Note what happened to members."""
        out = self.report
        for part in integrations:
            out.steps[part.members] += part.steps
            for lane, member in enumerate(part.members.tolist()):
                out.events += [(member, record) for record in part.events[lane]]
                if part.failed[lane]:
                    stop = Stop(part.failed[lane], float(part.reached[lane]), float(part.lasts[lane]), part.cause)
                    out.stops.setdefault(member, stop)


class _OneBody(_Run):
    """What is computed before Ctrl-C or a failure is kept."""

    def go(self) -> None:
        own, out = self.driver, self.report
        kind, origin = kernels.PRECISIONS[own.precision], float(self.origins[0])
        ends = (origin, float(self.times[0]), float(self.times[-1]))
        dense = out.dense = DenseOutput(own.variables, origin, self.starts[0], kind) if own.dense else None

        def stepper(forwards: bool) -> Stepper:
            return DenseStepper(kernel, kind, dense.parts[forwards]) if dense else ScalarStepper(kernel, kind)

        parts: list[Integration] = []
        with bar("time", max(ends) - min(ends), own.progress) as told, self.kernel(1) as kernel:
            out.order, out.tolerance = kernel.engine.order, float(kernel.engine.tol)
            if self.stop:  # while the integrator was built
                raise KeyboardInterrupt
            began = clock.perf_counter()
            for part, _ in self.integrations(stepper, kernels.FIRST):
                parts.append(part)
                self._integrate(part, told)
                if self.stop:
                    break
            out.wall_time = clock.perf_counter() - began
        self.book(parts)
        if dense:
            dense.reached = {part.forwards: float(part.reached[0]) for part in parts}
        self._hand_over({part.forwards: part.rows(0) for part in parts})

    def _integrate(self, part: Integration, told: Callable[[float], None]) -> None:
        before = part.reached[0]
        try:
            for _ in part.chunks():
                told(abs(part.reached[0] - before))
                before = part.reached[0]
                if self.stop:
                    part.failed[0] = part.failed[0] or INTERRUPTED
        except KeyboardInterrupt:  # where it is not held
            part.failed[0] = INTERRUPTED
            part.take_events()
        if part.failed[0] == INTERRUPTED:
            self.interrupt()

    def _hand_over(self, rows: dict[bool, Array]) -> None:
        """Give the rows of both directions in the order of the times."""
        nothing = np.empty((0, self.starts.shape[1]))
        later, earlier = (rows.get(forwards, nothing) for forwards in BOTH_WAYS)
        place = int(np.searchsorted(self.rising, self.origins[0]))
        times = self.rising[place - len(earlier) : place + len(later)][self.turn]
        whole = (np.concatenate([earlier[::-1], later]) if len(earlier) else later)[self.turn]
        self.sink.take(kernels.FIRST, times, Rows(self.driver.variables, times, whole))


class _Members(_Run):
    """Slabs of members, taken by threads one after another; on Ctrl-C the members that are finished are kept."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.width = kernels.LANES if np.ndim(self.driver.variables.scale) else 1
        self._lock = threading.Lock()
        self._slabs = self._cut()

    def go(self) -> None:
        own, count = self.driver, self.origins.size
        threads = min(own.threads, -(-count // self.width))
        began = clock.perf_counter()
        with bar("members", count, own.progress) as told, ThreadPoolExecutor(threads) as pool:
            workers = []
            try:
                workers += [pool.submit(self.serve, told) for _ in range(threads)]
                while wait(workers, timeout=1.0).not_done:
                    pass
            except KeyboardInterrupt:
                self.interrupt()
            for worker in workers:
                worker.result()
        self.report.wall_time = clock.perf_counter() - began

    def _cut(self) -> Iterator[NDArray[np.int_]]:
        """Yield the members in slabs, fast rotators first: lanes of a batch take about equally many steps."""
        own, count = self.driver, self.origins.size
        speed = np.linalg.norm(own.problem.system.omega_body(self.state), axis=-1)
        order = np.argsort(-np.broadcast_to(speed, (count,)), kind="stable")
        row = self.times.size * own.variables.size * self.width * 8
        slab = self.width * int(np.clip(SLAB_BYTES // row, 1, BATCHES_IN_A_SLAB))
        yield from (order[i : i + slab] for i in range(0, count, slab))

    def serve(self, told: Callable[[float], None]) -> None:
        """Integrate slab after slab, until none is left."""
        try:
            with self.kernel(self.width) as kernel:
                self.report.order, self.report.tolerance = kernel.engine.order, float(kernel.engine.tol)
                while not self.stop:
                    with self._lock:
                        slab = next(self._slabs, None)
                    if slab is None:
                        return
                    self._integrate(kernel, slab, told)
        except BaseException:  # the other threads would go on to the end before anyone hears of it
            self.stop = True
            raise

    def _integrate(self, kernel: kernels.Kernel, slab: NDArray[np.int_], told: Callable[[float], None]) -> None:
        variables = self.driver.variables
        stepper = BatchStepper(kernel) if self.width > 1 else ScalarStepper(kernel, np.float64)
        rows = np.full((slab.size, self.times.size, variables.size), np.nan)
        finished = 0
        for first in range(0, slab.size, self.width):
            members = slab[first : first + self.width]
            if self.stop or not self._integrate_batch(stepper, members, rows[first : first + members.size, self.turn]):
                break
            finished = first + members.size
            told(members.size)
        kept = slab[:finished]
        self.sink.take(kept, self.times, Rows(variables.of_members(kept), self.times, rows[:finished]))

    def _integrate_batch(self, stepper: Stepper, members: NDArray[np.int_], rows: Array) -> bool:
        """Put the variables of members at the rising times into rows (members, n, size); return whether all are there.

        The integration goes outwards from their start.
        """
        done = []
        for part, places in self.integrations(lambda _: stepper, members):
            for _ in part.chunks():
                if INTERRUPTED in part.failed:  # within an action
                    self.interrupt()
                if self.stop and not part.finished:
                    return False
            done.append(part)
            for lane, place in enumerate(places):
                found = part.rows(lane)
                if part.forwards:
                    rows[lane, place : place + len(found)] = found
                else:
                    rows[lane, place - len(found) : place] = found[::-1]
        with self._lock:
            self.report.finished += members.size
            self.book(done)
        return True


def _in_precision(state: State, precision: str) -> State:
    if precision == "double":
        return state
    kind = kernels.PRECISIONS[precision]
    return state_of(changed(state.phase, lambda array: Vector(map(kind, array))), state.time)


def allowed_threads() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
