"""What a run is given and what comes of it, whichever kernel integrates: jobs, rows and where they go, reports."""

from __future__ import annotations

import functools
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import KW_ONLY, dataclass, field
from threading import Lock
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.integration.event_log import Recorded
from poinsot.integration.problem import Problem
from poinsot.integration.samples import Clock
from poinsot.integration.state_vector import StateVector
from poinsot.integration.termination import INTERRUPTED, reason_of_speed
from poinsot.lazy import cached_property
from poinsot.mechanics.state import AnyState, Phase
from poinsot.printable import quoted

__all__ = ["BOTH_WAYS", "Job", "Memory", "OneMotion", "Report", "Rows", "Run", "Sink", "Stop", "allowed_threads"]

BOTH_WAYS = (True, False)
"""Forwards, then backwards."""

VARIATIONS = ("vectors", "pairs", "exponents")

Array = NDArray[Any]
Members = NDArray[np.int_]


class Rows:
    """Variables along times by name, converted when they are asked for.

    `quaternion`, the momenta that are integrated and the variables of parts; `orbits`, those of all orbits; of
    variations `vectors`, `pairs` and `exponents`. Shapes (members, n, ...), of one body (n, ...).
    """

    def __init__(self, variables: StateVector, times: Array, values: Array) -> None:
        self._variables, self._times, self._values = variables, times, values

    @cached_property
    def phase(self) -> Phase:
        """The quaternion and the momenta."""
        return self._variables.to_phase(self._times, self._values)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Which vectors each of the `pairs` is of."""
        return self._variables.variations.pairs if self._variables.variations else []

    @cached_property
    def _variations(self) -> dict[str, Array]:
        variations, values = self._variables.variations, self._values[..., self._variables.tangent_vectors]
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
    kernel : str
    lanes : int
    interrupted : bool
    dense : callable or None
    """

    steps: NDArray[np.int_]
    stops: dict[int, Stop] = field(default_factory=dict)
    events: list[tuple[int, Recorded]] = field(default_factory=list)
    finished: int = 0
    order: int = 0
    tolerance: float = 0.0
    wall_time: float = 0.0
    kernel: str = "looped"
    lanes: int = 1
    interrupted: bool = False
    dense: Any = None

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

    def put(self, members: NDArray[np.int_], found: Report) -> None:
        """Take what is known of the run of some of the members."""
        self.steps[members], self.finished = found.steps, self.finished + found.finished
        self.stops |= {int(members[i]): stop for i, stop in found.stops.items()}
        self.wall_time, self.interrupted = self.wall_time + found.wall_time, found.interrupted
        self.kernel, self.lanes, self.order, self.tolerance = found.kernel, found.lanes, found.order, found.tolerance

    def add(self, later: Report) -> None:
        """Count what a later piece of the same motions took; the first stop of a member stays."""
        self.steps, self.wall_time = self.steps + later.steps, self.wall_time + later.wall_time
        self.kernel, self.lanes = later.kernel, later.lanes
        self.order, self.tolerance, self.stops = later.order, later.tolerance, later.stops | self.stops


@dataclass(eq=False)
class Job:
    """A problem to be integrated in given variables.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    tolerance : float
    precision : str
        Of one body; an ensemble has double precision.
    threads : int
        At most, for an ensemble.
    progress : bool or callable
        Whether to show a bar of a run that lasts, or what is told of it.
    dense : bool
        Whether to keep the polynomials, of one body.
    device : {"cpu", "cuda"}
        The second of an ensemble alone.
    """

    problem: Problem
    variables: StateVector
    tolerance: float
    _: KW_ONLY
    precision: str = "double"
    threads: int = 1
    progress: Progress = False
    dense: bool = False
    device: str = "cpu"


class Run(ABC):
    """One run of a job, from a state outwards to times, in a direction or both."""

    def __init__(self, job: Job, state: AnyState, times: Array, sink: Sink, ways: tuple[bool, ...]) -> None:
        self.job, self.state, self.times, self.sink, self.ways = job, state, times, sink, ways
        self.turn = slice(None, None, 1 if times[0] <= times[-1] else -1)
        self.rising, self.origins = times[self.turn].copy(), state.time.reshape(-1)
        self.report, self.stop, self.lock = Report(np.zeros(self.origins.size, dtype=int)), False, Lock()
        start = job.variables.from_state(state)
        self.starts = start.reshape(-1, start.shape[-1])
        jumping = job.problem.dynamics.jumping
        self.clock = Clock(jumping, job.problem.dynamics.numbered(self.origins.size), state.jumped) if jumping else None
        if jumping and self.rising[0] < self.origins.max() and False in ways:
            raise ValueError(
                f"times must not be before the state's where {quoted(jumping[0].name)} is sampled, got "
                f"{self.rising[0]} "
                f"before {self.origins.max()}. Such motions run forwards only."
            )

    def interrupt(self) -> None:
        """Let the run stop after the chunks of steps that are under way, and keep what it has."""
        self.stop = self.report.interrupted = True

    def reason(self, member: int, why: str) -> str:
        """Return why a member stopped, by what a kernel says and how fast it turned at its start."""
        power = self.report.order if self.job.precision == "double" else 2  # which has a unit of time of its own
        return reason_of_speed(why, float(self.speeds[member]), power)

    @functools.cached_property
    def speeds(self) -> Array:
        """How fast the members turn at their starts."""
        with np.errstate(over="ignore"):
            return np.broadcast_to(self.job.problem.dynamics.speed(self.state), self.origins.shape)

    def on_threads(self, count: int, slabs: Iterator[Members], serve: Callable[[Iterator[Members]], None]) -> None:
        """Let so many threads serve slabs of members until none is left, and hear Ctrl-C until all have returned."""
        if count == 1:
            self._work(slabs, serve)
            return
        with ThreadPoolExecutor(count) as pool:
            workers = []
            try:
                workers += [pool.submit(self._work, slabs, serve) for _ in range(count)]
                while wait(workers, timeout=1.0).not_done:
                    pass
            except KeyboardInterrupt:
                self.interrupt()
            for worker in workers:
                worker.result()

    def _work(self, slabs: Iterator[Members], serve: Callable[[Iterator[Members]], None]) -> None:
        try:
            serve(self._shared(slabs))
        except BaseException:  # the other threads would go on to the end before anyone hears of it
            self.stop = True
            raise

    def _shared(self, slabs: Iterator[Members]) -> Iterator[Members]:
        """Yield what other threads leave of some slabs, until the run is to stop."""
        while not self.stop:
            with self.lock:
                members = next(slabs, None)
            if members is None:
                return
            yield members

    @abstractmethod
    def go(self) -> None:
        """Integrate."""


def allowed_threads() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
