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

from poinsot.engine import kernels
from poinsot.engine.event_detection import Recorded
from poinsot.engine.problem import Problem
from poinsot.engine.progress import bar
from poinsot.engine.state_vector import Coordinates
from poinsot.engine.termination import INTERRUPTED, TRIES, reason
from poinsot.mechanics.formulations import Formulation
from poinsot.mechanics.state import State

__all__ = ["Ensemble", "EnsembleOutput", "allowed_threads", "integrate_members"]

STEPS_AT_A_TIME = 5_000
"""Steps of a batch between two looks at the keyboard: some hundredths of a second."""

SLAB_BYTES = 8_000_000
"""The most that a thread holds of its members' variables before it hands them over."""

BATCHES_IN_A_SLAB = 16

Array = NDArray[np.float64]


class EnsembleOutput(ABC):
    """The output of an ensemble, filled in by threads.

    Attributes
    ----------
    failures : dict
        Member -> why it stopped.
    steps : array (members,)
    happened : list
        Pairs of a member and what was recorded of an event.
    finished : int
        How many members are done; the others of an interrupted run have nothing here.
    """

    ways: tuple[bool, ...] = (True, False)
    """Whether forwards, backwards, or both."""

    def __init__(self, members: int) -> None:
        self.failures: dict[int, str] = {}
        self.happened: list[tuple[int, Recorded]] = []
        self.steps = np.zeros(members, dtype=int)
        self.finished = 0
        self.order, self.tolerance = 0, 0.0
        self.wall_time = 0.0
        self.interrupted = False

    @abstractmethod
    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        """Keep what there is to keep of some members' variables, shape (members, n, size); NaN where they did not get.

        `variables` are of those members.
        """


class Ensemble(EnsembleOutput):
    """The motions of an ensemble.

    Attributes
    ----------
    phase : dict of arrays (members, n, 4) and (members, n, 3 or 4)
        NaN where a member did not get.
    carried : array (members, n, any)
        The variables of the axes, kept if they are those of orbits without formulas on symbols.
    """

    def __init__(self, members: int, times: int, formulation: Formulation, comoving: int = 0) -> None:
        super().__init__(members)
        self.phase = formulation.to_phase(np.full((members, times, formulation.size), np.nan))
        self.comoving = np.full((members, times, comoving), np.nan)

    def take(self, members: NDArray[np.int_], times: Array, rows: Array, variables: Coordinates) -> None:
        """Keep q, the momenta and the variables of the axes."""
        for name, values in variables.to_phase(times, rows).items():
            self.phase[name][members] = values
        self.comoving[members] = rows[..., variables.comoving][..., : self.comoving.shape[-1]]


def integrate_members(
    problem: Problem,
    state: State,
    times: Array,
    variables: Coordinates,
    tolerance: float,
    threads: int,
    progress: bool,
    out: EnsembleOutput,
) -> None:
    """Integrate members from their states to all the times, which rise; what is finished is kept on Ctrl-C."""
    work = _Work(problem, state, times, variables, tolerance, out)
    threads = min(threads, -(-len(out.steps) // work.width))
    began = clock.perf_counter()
    with bar("members", len(out.steps), progress) as report, ThreadPoolExecutor(threads) as pool:
        workers = []
        try:
            workers += [pool.submit(work.serve, report) for _ in range(threads)]
            while wait(workers, timeout=1.0).not_done:
                pass
        except KeyboardInterrupt:
            work.interrupt()
        for worker in workers:
            worker.result()
    out.wall_time = clock.perf_counter() - began


class _Work:
    """Slabs of members, taken by the threads one after another."""

    def __init__(
        self,
        problem: Problem,
        state: State,
        times: Array,
        variables: Coordinates,
        tolerance: float,
        out: EnsembleOutput,
    ) -> None:
        self.problem, self.state, self.times, self.variables, self.out = problem, state, times, variables, out
        self.tolerance, self.width = tolerance, kernels.LANES
        self.starts = np.broadcast_to(variables.from_state(state), (len(out.steps), variables.size))
        self.stop = False
        self._lock = threading.Lock()
        self._slabs = self._cut()

    def _cut(self) -> Iterator[NDArray[np.int_]]:
        """Yield the members in slabs, fast rotators first: lanes of a batch take about equally many steps."""
        speed = np.linalg.norm(self.problem.system.omega_body(self.state), axis=-1)
        order = np.argsort(-np.broadcast_to(speed, (len(self.out.steps),)), kind="stable")
        row = self.times.size * self.variables.size * self.width * 8
        slab = self.width * int(np.clip(SLAB_BYTES // row, 1, BATCHES_IN_A_SLAB))
        yield from (order[i : i + slab] for i in range(0, order.size, slab))

    def serve(self, report: Callable[[float], None]) -> None:
        """Integrate slab after slab, until none is left."""
        lent = kernels.integrator(self.problem, self.variables, "double", self.tolerance, self.width)
        try:
            with lent as borrowed:
                self.out.order, self.out.tolerance = borrowed.engine.order, float(borrowed.engine.tol)
                while not self.stop:
                    with self._lock:
                        slab = next(self._slabs, None)
                    if slab is None:
                        return
                    self._integrate(borrowed, slab, report)
        except BaseException:  # the other threads would go on to the end before anyone hears of it
            self.stop = True
            raise

    def interrupt(self) -> None:
        """Let all threads stop, and keep the members that are finished."""
        self.stop, self.out.interrupted = True, True

    def _integrate(self, borrowed: kernels.Borrowed, slab: NDArray[np.int_], report: Callable[[float], None]) -> None:
        rows = np.full((slab.size, self.times.size, self.variables.size), np.nan)
        finished = 0
        for first in range(0, slab.size, self.width):
            members = slab[first : first + self.width]
            try:
                self._both_ways(borrowed, members, rows[first : first + members.size])
            except KeyboardInterrupt:  # within an action
                self.interrupt()
            if self.stop:
                break
            finished = first + members.size
            report(members.size)
        kept = slab[:finished]
        self.out.take(kept, self.times, rows[:finished], self.variables.of_members(kept))

    def _both_ways(self, borrowed: kernels.Borrowed, members: NDArray[np.int_], rows: Array) -> None:
        """Put the variables of members at all times into rows (members, n, size), outwards from their start."""
        origins = self.state.time[members]
        middles = np.searchsorted(self.times, origins)
        batches = []
        for forwards in self.out.ways:
            grids = [self.times[m:] if forwards else self.times[:m][::-1] for m in middles]
            batch = _Batch(borrowed, members, self.starts[members], origins, grids, forwards)
            batch.run(lambda: self.stop)
            batches.append(batch)
            for lane, m in enumerate(middles):
                found = batch.rows(lane)
                if forwards:
                    rows[lane, m : m + len(found)] = found
                else:
                    rows[lane, m - len(found) : m] = found[::-1]
        if not self.stop:
            self._book(members, batches)

    def _book(self, members: NDArray[np.int_], batches: list[_Batch]) -> None:
        """Note what happened to members that are finished."""
        with self._lock:
            self.out.finished += members.size
            for batch in batches:
                self.out.steps[members] += batch.steps
                for lane, member in enumerate(members.tolist()):
                    self.out.happened += [(member, record) for record in batch.happened[lane]]
                    if batch.failed[lane]:
                        self.out.failures.setdefault(member, batch.failure(lane))


class _Batch:
    """Members in the lanes of an engine, in one direction, each with its own start and its own times.

    The engine moves all its lanes. Those that are done, or that nobody has, repeat one that is not, and nothing is
    taken from them.

    Parameters
    ----------
    borrowed : Borrowed
    members : array (count,)
        As many as there are lanes, or fewer.
    starts, origins : arrays (count, size) and (count,)
    grids : list of arrays
        The times of each, outwards from its origin.
    forwards : bool
    limits : array (count,), optional
        How many steps of each to take at most.
    """

    def __init__(
        self,
        borrowed: kernels.Borrowed,
        members: NDArray[np.int_],
        starts: Array,
        origins: Array,
        grids: list[Array],
        forwards: bool,
        limits: NDArray[np.int_] | None = None,
    ) -> None:
        self.borrowed, self.engine = borrowed, borrowed.engine
        self.members, self.starts, self.origins, self.grids = members, starts, origins, grids
        self.forwards, self.limits = forwards, limits
        self.most = borrowed.steps_at_a_time(STEPS_AT_A_TIME, first=True)
        self.steps, self.reached = np.zeros(members.size, dtype=int), origins.copy()
        self.failed = [""] * members.size
        self.happened: list[list[Recorded]] = [[] for _ in members]
        self._broken: list[int] = []
        self._closely, self._tries = False, 0
        self._rows: list[list[Array]] = [[np.empty((0, starts.shape[1]))] for _ in members]

    def rows(self, lane: int) -> Array:
        """Return the variables of a lane at the times of its grid that it reached; shape (n, size)."""
        return np.concatenate(self._rows[lane])

    def failure(self, lane: int) -> str:
        """Return the sentence about a lane that failed."""
        last = self.grids[lane][-1]
        return f"propagation stopped at t = {self.reached[lane]:.10g} of {last:.10g}: {self.failed[lane]}"

    def run(self, stop: Callable[[], bool]) -> None:
        """Integrate every lane over its grid, a chunk of steps at a time."""
        ahead = list(self.grids)
        for lane, grid in enumerate(self.grids):
            if grid.size and grid[0] == self.origins[lane]:
                self._rows[lane].append(self.starts[lane : lane + 1])
                ahead[lane] = grid[1:]
        if self._under_way(ahead):
            self._begin()
        while (under_way := self._under_way(ahead)) and not stop():
            self._advance(ahead, under_way)
        if self._broken:
            self._find_where(self._broken, stop)

    def _begin(self) -> None:
        lanes = np.minimum(np.arange(self.engine.batch_size), self.members.size - 1)
        self._limit_steps(0)
        self._place(lanes, (self.origins[lanes], np.zeros(lanes.size)), self.starts[lanes].T)

    def _place(self, lanes: NDArray[np.int_], time: tuple[Array, Array], state: Array) -> None:
        """Put the members of some lanes into the engine's, with states in the scale of the start."""
        self.engine.state[:] = state
        self.engine.set_dtime(*map(list, time))
        self.borrowed.begin(self.forwards, self.members[lanes])
        if self.borrowed.watch is not None:
            self.borrowed.watch.records = []

    def _limit_steps(self, tries: int) -> None:
        self._tries = tries
        lanes = np.minimum(np.arange(self.engine.batch_size), self.members.size - 1)
        spans = [
            abs(grid[-1] - here) if grid.size else 0.0 for grid, here in zip(self.grids, self.origins, strict=True)
        ]
        self.borrowed.limit_steps(np.array(spans)[lanes], tries)

    def _mark(self, longest: int, idle: NDArray[np.int_]) -> Callable[[], None]:
        """Return what brings the engine back to where it is."""
        lanes = np.minimum(np.arange(self.engine.batch_size), self.members.size - 1)
        lanes[idle] = longest
        time = (self.engine.dtime[0].copy(), self.engine.dtime[1].copy())
        state = self.engine.state.copy()
        for lane in map(int, np.flatnonzero(self.borrowed.scales.bits)):
            state[:, lane] = self._outward(state[:, lane], lane)

        def back() -> None:
            self._place(lanes, time, state)
            if idle.size:
                self._repeat(longest, idle)

        return back

    def _outward(self, rows: Array, lane: int) -> Array:
        return self.borrowed.scales.outward(rows, lane)

    def _under_way(self, ahead: list[Array]) -> list[int]:
        """Return the lanes that have something ahead."""
        lanes = [lane for lane, grid in enumerate(ahead) if grid.size]
        return lanes if self.limits is None else [lane for lane in lanes if self.steps[lane] < self.limits[lane]]

    def _find_where(self, lanes: list[int], stop: Callable[[], bool]) -> None:
        """Find when states were finite last, by the same steps again but the last: the engine loses the time too."""
        again = _Batch(
            self.borrowed,
            self.members[lanes],
            self.starts[lanes],
            self.origins[lanes],
            [self.grids[lane] for lane in lanes],
            self.forwards,
            self.steps[lanes],
        )
        again.run(stop)
        self.reached[lanes] = again.reached

    def _advance(self, ahead: list[Array], under_way: list[int]) -> None:
        """Take a chunk of steps, and leave what remains of the grids; all, if it is to be taken again."""
        longest = max(under_way, key=lambda lane: ahead[lane].size)
        idle = np.setdiff1d(np.arange(self.engine.batch_size), under_way)
        if idle.size:
            self._repeat(longest, idle)
        now = np.array(self.engine.time)
        most = self.most if self.limits is None else min(self.most, int(np.min((self.limits - self.steps)[under_way])))
        back, ends = self._mark(longest, idle), now.copy()
        near = [lane for lane in under_way if not _has_room(ahead[lane], now[lane], ahead[longest].size)]
        if near:
            ends[near] = [ahead[lane][0] for lane in near]
        else:
            table = np.tile(np.append(now[longest], ahead[longest])[:, None], self.engine.batch_size)
            for lane in under_way:
                table[:, lane] = _padded(ahead[lane], now[lane], ahead[longest].size)
            ends = table[-1]
        taken = most
        if self._closely:
            taken = min(self.borrowed.sound_steps(ends, most), most)
            back()
        self.borrowed.certain(self._closely)
        if near:
            self.engine.propagate_until(list(ends), max_steps=taken, write_tc=True)
            found = np.full((1, *self.engine.state.shape), np.nan)
        else:
            _, found = self.engine.propagate_grid(table, max_steps=taken, **self.borrowed.limits)
        results = self.engine.propagate_res
        doubtful = any(self.borrowed.doubtful(lane, results[lane], found[:, :, lane]) for lane in under_way)
        if self._goes_back(doubtful, under_way, back):
            return
        for lane in under_way:
            rows = self._outward(found[-ahead[lane].size :, :, lane], lane)
            ahead[lane] = self._read(lane, ahead[lane], rows, now[lane], most, taken == most)
        self._take_events()
        self.borrowed.rescale()
        self.most, self._closely = self.borrowed.steps_at_a_time(STEPS_AT_A_TIME), doubtful

    def _goes_back(self, doubtful: bool, under_way: list[int], back: Callable[[], None]) -> bool:
        """Go back to the start of a chunk that must be taken again, closely or for a lost zero; return whether so."""
        if doubtful and not self._closely:
            self._closely = True
        elif not (overlooked := [lane for lane in under_way if self.borrowed.overlooked(lane)]):
            if self._tries:
                self._limit_steps(0)
            return False
        elif self._tries == TRIES:
            for lane in overlooked:
                self.borrowed.settle(lane)
            self._limit_steps(0)
            return False
        else:
            self._limit_steps(self._tries + 1)
        back()
        return True

    def _repeat(self, busy: int, idle: NDArray[np.int_]) -> None:
        """Let lanes that are done repeat one that is not."""
        high, low = (np.array(part) for part in self.engine.dtime)  # the engine's time has two parts
        high[idle], low[idle] = high[busy], low[busy]
        self.engine.set_dtime(list(high), list(low))
        self.engine.state[:, idle] = self.engine.state[:, [busy]]
        self.borrowed.repeat(busy, idle)

    def _read(self, lane: int, ahead: Array, rows: Array, before: float, most: int, judged: bool) -> Array:
        """Keep what a chunk of steps has brought to a lane, and return what remains of its grid.

        Whether the steps lead anywhere is `judged` by a full chunk alone.
        """
        outcome, _, _, steps = self.engine.propagate_res[lane]
        ended, reached = self.borrowed.outcome(outcome, lane), float(self.engine.time[lane])
        self.steps[lane] += steps
        if ended == "err_nf_state":
            self._broken.append(lane)
            self._rows[lane].append(rows[np.all(np.isfinite(rows), axis=-1)])
            self.failed[lane] = reason(ended, 0.0, before, 0.0, most)
            return ahead[:0]
        sign = 1 if self.forwards else -1
        passed = int(np.searchsorted(sign * ahead, sign * reached, side="right"))
        self._rows[lane].append(self._whole(lane, ahead, rows[:passed]))
        self.reached[lane] = reached
        if passed == ahead.size and ended in ("time_limit", "step_limit"):
            ended = self._look_at_end(lane)
        if ended == INTERRUPTED:
            raise KeyboardInterrupt
        if ended == "step_limit" and not judged:
            ended = "success"
        self.failed[lane] = reason(ended, abs(reached - before), reached, abs(ahead[-1] - reached), most)
        return ahead[:0] if self.failed[lane] or ended == "event" else ahead[passed:]

    def _whole(self, lane: int, times: Array, rows: Array) -> Array:
        """Return rows with those that the engine leaves out of its last step: where it stops, and beside failures."""
        for row in np.flatnonzero(np.isnan(rows[:, 0])):
            self.engine.update_d_output([times[row]] * self.engine.batch_size)
            rows[row] = self._outward(self.engine.d_output[:, lane], lane)
        return rows

    def _look_at_end(self, lane: int) -> str:
        """Let happen what is due at the end of a lane, and return how it ended."""
        watch = self.borrowed.watch
        if watch is None:
            return "time_limit"
        watch.look(self.engine, lane)
        return watch.stopped[lane] or "time_limit"

    def _take_events(self) -> None:
        if self.borrowed.watch is not None:
            for record in self.borrowed.watch.records:
                self.happened[record[1]].append(record)
            self.borrowed.watch.records = []


def _has_room(ahead: Array, here: float, length: int) -> bool:
    """Whether the idle points that make a grid as long have room before its first time."""
    idle, ulp = length - ahead.size, np.spacing(max(abs(here), abs(ahead[0])))
    return idle == 0 or bool(abs(ahead[0] - here) > 2 * (idle + 1) * ulp)


def _padded(ahead: Array, here: float, length: int) -> Array:
    """Return a grid of length + 1 that starts here and ends with the times ahead; the points between are idle."""
    idle = length - ahead.size
    return np.concatenate([here + (ahead[0] - here) * np.arange(idle + 1) / (idle + 1), ahead])


def allowed_threads() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
