"""Many bodies at once: members side by side in the lanes of the processor, batches on all its cores."""

from __future__ import annotations

import os
import threading
import time as clock
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.state import State, computed_state
from poinsot.mechanics.system import System
from poinsot.motion import kernels
from poinsot.motion.coordinates import Coordinates
from poinsot.motion.progress import bar
from poinsot.motion.stops import reason
from poinsot.motion.watch import Recorded

__all__ = ["Ensemble", "Outcome", "allowed_threads", "integrate_members"]

STEPS_AT_A_TIME = 5_000
"""Steps of a batch between two looks at the keyboard: some hundredths of a second."""

SLAB_BYTES = 8_000_000
"""The most that a thread holds of its members' variables before it hands their q and Q over."""

BATCHES_IN_A_SLAB = 16

NEAR = 1e6
"""Roundings of a time between which and the next one the engine's grid has no room."""

Array = NDArray[np.float64]


class Outcome(ABC):
    """The output of an ensemble, filled in by threads.

    Attributes
    ----------
    failures : dict
        Member -> why it stopped.
    steps : array (members,)
    happened : list
        Pairs of a member and what was recorded of an event.
    """

    def __init__(self, members: int) -> None:
        self.failures: dict[int, str] = {}
        self.happened: list[tuple[int, Recorded]] = []
        self.steps = np.zeros(members, dtype=int)
        self.order, self.tolerance = 0, 0.0
        self.wall_time = 0.0
        self.interrupted = False

    @abstractmethod
    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        """Keep what there is to keep of some members' variables, shape (members, n, size); NaN where they did not get.

        `variables` are of those members.
        """


class Ensemble(Outcome):
    """The motions of an ensemble.

    Attributes
    ----------
    quaternion, conjugate_momenta : array (members, n, 4)
        NaN where a member did not get.
    carried : array (members, n, any)
        The variables of the axes, kept if they are those of orbits without formulas on symbols.
    """

    def __init__(self, members: int, times: int, carried: int) -> None:
        super().__init__(members)
        self.quaternion = np.full((members, times, 4), np.nan)
        self.conjugate_momenta = np.full((members, times, 4), np.nan)
        self.carried = np.full((members, times, carried), np.nan)

    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        """Keep q, Q and the variables of the axes."""
        self.quaternion[members], self.conjugate_momenta[members] = variables.to_canonical(times, rows)
        self.carried[members] = rows[..., variables.carried][..., : self.carried.shape[-1]]


def integrate_members(
    system: System,
    state: State,
    times: Array,
    variables: Coordinates,
    tolerance: float,
    threads: int,
    progress: bool,
    out: Outcome,
) -> None:
    """Integrate every member from its state to all the times, which rise; what is finished is kept on Ctrl-C."""
    members = len(out.steps)
    state = computed_state(
        np.broadcast_to(state.quaternion, (members, 4)),
        np.broadcast_to(state.conjugate_momenta, (members, 4)),
        np.broadcast_to(state.time, (members,)),
    )
    work = _Work(system, state, times, variables, tolerance, out)
    threads = min(threads, -(-members // work.width))
    began = clock.perf_counter()
    with bar("members", members, progress) as report, ThreadPoolExecutor(threads) as pool:
        workers = [pool.submit(work.serve, report) for _ in range(threads)]
        try:
            while wait(workers, timeout=1.0).not_done:
                pass
        except KeyboardInterrupt:
            work.stop, out.interrupted = True, True
        for worker in workers:
            worker.result()
    out.wall_time = clock.perf_counter() - began


class _Work:
    """Slabs of members, taken by the threads one after another."""

    def __init__(
        self, system: System, state: State, times: Array, variables: Coordinates, tolerance: float, out: Outcome
    ) -> None:
        self.system, self.state, self.times, self.variables, self.out = system, state, times, variables, out
        self.tolerance, self.width = tolerance, kernels.LANES
        self.starts = np.broadcast_to(variables.from_state(state), (len(out.steps), variables.size))
        self.stop = False
        self._lock = threading.Lock()
        self._slabs = self._cut()

    def _cut(self) -> Iterator[NDArray[np.int_]]:
        """Yield the members in slabs, fast rotators first: lanes of a batch take about equally many steps."""
        speed = np.linalg.norm(self.system.omega_body(self.state), axis=-1)
        order = np.argsort(-np.broadcast_to(speed, (len(self.out.steps),)), kind="stable")
        row = self.times.size * self.variables.size * self.width * 8
        slab = self.width * int(np.clip(SLAB_BYTES // row, 1, BATCHES_IN_A_SLAB))
        yield from (order[i : i + slab] for i in range(0, order.size, slab))

    def serve(self, report: Callable[[float], None]) -> None:
        """Integrate slab after slab, until none is left."""
        lent = kernels.integrator(self.system, self.variables, "double", self.tolerance, self.width)
        with lent as borrowed:
            self.out.order, self.out.tolerance = borrowed.engine.order, float(borrowed.engine.tol)
            while not self.stop:
                with self._lock:
                    slab = next(self._slabs, None)
                if slab is None:
                    return
                self._integrate(borrowed, slab, report)

    def _integrate(self, borrowed: kernels.Borrowed, slab: NDArray[np.int_], report: Callable[[float], None]) -> None:
        rows = np.full((slab.size, self.times.size, self.variables.size), np.nan)
        finished = 0
        for first in range(0, slab.size, self.width):
            members = slab[first : first + self.width]
            lanes = members[np.minimum(np.arange(self.width), members.size - 1)]  # the tail repeats its last member
            found = self._both_ways(borrowed, lanes, members.size)
            if self.stop:
                break
            finished = first + members.size
            rows[first:finished] = found
            report(members.size)
        kept = slab[:finished]
        self.out.take(kept, self.times, rows[:finished], self.variables.of_members(kept))

    def _both_ways(self, borrowed: kernels.Borrowed, lanes: NDArray[np.int_], count: int) -> Array:
        """Return the variables of the first lanes at all times, shape (count, n, size), outwards from their start."""
        origins = self.state.time[lanes]
        middles = np.searchsorted(self.times, origins)
        halves = []
        for forwards in (True, False):
            grids = [self.times[m:] if forwards else self.times[:m][::-1] for m in middles]
            batch = _Batch(borrowed, lanes, self.starts[lanes], origins)
            batch.run(grids, forwards, lambda: self.stop)
            halves.append(batch)
            with self._lock:
                self.out.steps[lanes[:count]] += batch.steps[:count]
                self.out.happened += [(int(lanes[i]), one) for i in range(count) for one in batch.happened[i]]
                self.out.failures |= {int(lanes[i]): why for i, why in enumerate(batch.failed[:count]) if why}
        rows = np.full((count, self.times.size, self.variables.size), np.nan)
        for lane, m in enumerate(middles[:count]):
            later, earlier = (half.rows(lane) for half in halves)
            rows[lane, m : m + len(later)], rows[lane, m - len(earlier) : m] = later, earlier[::-1]
        return rows


class _Batch:
    """The lanes of one batch in one direction, each with its own start and its own remaining times."""

    def __init__(self, borrowed: kernels.Borrowed, members: NDArray[np.int_], starts: Array, origins: Array) -> None:
        self.borrowed, self.engine = borrowed, borrowed.engine
        self.members, self.starts, self.origins = members, starts, origins
        self.width, self.most = len(starts), borrowed.steps_at_a_time(STEPS_AT_A_TIME, first=True)
        self._rows: list[list[Array]] = [[np.empty((0, starts.shape[1]))] for _ in range(self.width)]
        self.steps = np.zeros(self.width, dtype=int)
        self.failed = [""] * self.width
        self.happened: list[list[Recorded]] = [[] for _ in range(self.width)]

    def rows(self, lane: int) -> Array:
        """Return the variables of a lane at the times of its grid that it reached; shape (n, size)."""
        return np.concatenate(self._rows[lane])

    def run(self, grids: list[Array], forwards: bool, stop: Callable[[], bool]) -> None:
        """Integrate every lane over its grid, a chunk of steps at a time."""
        self.engine.state[:] = self.starts.T
        self.engine.set_time(list(self.origins))
        self.borrowed.begin(forwards, self.members)
        self._take_events([])
        for lane, grid in enumerate(grids):
            if grid.size and grid[0] == self.origins[lane]:
                self._rows[lane].append(self.starts[lane : lane + 1])
        ahead = [grid[len(rows) - 1 :] for grid, rows in zip(grids, self._rows, strict=True)]
        ahead = self._reach_near(ahead)
        while any(grid.size for grid in ahead) and not stop():
            ahead = self._advance(ahead)

    def _reach_near(self, ahead: list[Array]) -> list[Array]:
        """Reach first times so near that nothing can be put between, and return what remains of the grids."""
        first = [grid[0] if grid.size else here for grid, here in zip(ahead, self.origins, strict=True)]
        near = np.abs(np.array(first) - self.origins) < NEAR * np.spacing(np.abs(self.origins))
        near &= [grid.size > 0 for grid in ahead]
        if not np.any(near):
            return ahead
        self.engine.propagate_until(list(np.where(near, first, self.origins)))
        for lane in np.flatnonzero(near):
            self._rows[lane].append(self.engine.state[:, lane][None].copy())
        left = [grid[int(reached) :] for grid, reached in zip(ahead, near, strict=True)]
        self._look_at_ends(ahead, left)
        return left

    def _look_at_ends(self, before: list[Array], left: list[Array]) -> None:
        """Take the events of lanes that were under way, and what is due at the ends that they reached."""
        if self.borrowed.watch is None:
            return
        under_way = [lane for lane in range(self.width) if before[lane].size]
        for lane in under_way:
            if not left[lane].size and not self.borrowed.watch.stopped[lane]:
                self.borrowed.watch.look(self.engine, lane)
        self._take_events(under_way)

    def _take_events(self, lanes: list[int]) -> None:
        """Keep the events of some lanes, and forget the others."""
        if self.borrowed.watch is None:
            return
        for record in self.borrowed.watch.records:
            if record[1] in lanes:
                self.happened[record[1]].append(record)
        self.borrowed.watch.records = []

    def _advance(self, ahead: list[Array]) -> list[Array]:
        """Take a chunk of steps and return what remains of the grids."""
        busy = max(range(self.width), key=lambda lane: ahead[lane].size)
        for lane in range(self.width):
            if not ahead[lane].size:
                self._repeat(busy, lane)
        now = np.array(self.engine.time)
        grids = [grid if grid.size else ahead[busy] for grid in ahead]
        table = [_padded(grid, here, ahead[busy].size) for grid, here in zip(grids, now, strict=True)]
        _, found = self.engine.propagate_grid(np.stack(table, axis=-1), max_steps=self.most)
        self.borrowed.rescale()
        reached = np.array(self.engine.time)
        left = [
            self._read(lane, ahead[lane], found[:, :, lane], now[lane], reached[lane])
            if ahead[lane].size
            else ahead[lane]
            for lane in range(self.width)
        ]
        self._look_at_ends(ahead, left)
        self.most = self.borrowed.steps_at_a_time(STEPS_AT_A_TIME)
        return left

    def _repeat(self, busy: int, idle: int) -> None:
        """Let a lane that is done repeat one that is not: the engine moves all of them."""
        high, low = (np.array(part) for part in self.engine.dtime)  # the engine's time has two parts
        high[idle], low[idle] = high[busy], low[busy]
        self.engine.set_dtime(list(high), list(low))
        self.engine.state[:, idle] = self.engine.state[:, busy]
        self.borrowed.repeat(busy, idle)

    def _read(self, lane: int, ahead: Array, found: Array, before: float, reached: float) -> Array:
        outcome, _, _, steps = self.engine.propagate_res[lane]
        passed = int(np.searchsorted(abs(ahead - before), abs(reached - before), side="right"))
        rows = found[len(found) - ahead.size :][:passed]
        if passed and ahead[passed - 1] == reached and np.isnan(rows[-1, 0]):  # the engine leaves out where it stopped
            rows[-1] = self.engine.state[:, lane]
        ended = self.borrowed.outcome(outcome, lane)
        if ended == "err_nf_state":
            rows = rows[np.all(np.isfinite(rows), axis=-1)]
        self._rows[lane].append(rows)
        self.steps[lane] += steps
        advance, left = abs(reached - before), abs(ahead[-1] - reached)
        stopped = reason(ended, advance, reached, left, self.most)
        if ended == "event":
            return ahead[:0]
        if stopped:
            self.failed[lane] = f"propagation stopped at t = {reached:.10g} of {ahead[-1]:.10g}: {stopped}"
        return ahead[len(rows) :] if not stopped else ahead[:0]


def _padded(ahead: Array, here: float, length: int) -> Array:
    """Return a grid of length + 1 that starts here and ends with the times ahead; the points between are idle."""
    idle = length - ahead.size
    return np.concatenate([here + (ahead[0] - here) * np.arange(idle + 1) / (idle + 1), ahead])


def allowed_threads() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
