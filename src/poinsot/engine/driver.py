"""One driver for one body, for ensembles and for variations, forwards and backwards: it hands rows to a sink."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.engine import kernels
from poinsot.engine.cuda_runs import CudaRun, check_device
from poinsot.engine.dense_output import DenseOutput
from poinsot.engine.integration import BatchStepper, DenseStepper, Integration, Polynomials, ScalarStepper, Stepper
from poinsot.engine.jumps import Clock, Updates
from poinsot.engine.looped_runs import LoopedRun, constants_of
from poinsot.engine.progress import bar
from poinsot.engine.runs import BOTH_WAYS, Job, Report, Rows, Run, Sink, Stop
from poinsot.engine.sampled_integration import SampledIntegration
from poinsot.engine.termination import INTERRUPTED, HeldInterrupts
from poinsot.mechanics.state import State

__all__ = ["Driver"]

SLAB_BYTES = 8_000_000
"""The most that a thread holds of its members' variables before it hands them over."""

BATCHES_IN_A_SLAB = 16

GROUP = 128
"""Members whose batches have none of others: ensembles cut between groups have the same batches, and the same bits."""

Array = NDArray[Any]


class Driver(Job):
    """Integrates a job."""

    def run(self, state: State, times: Array, sink: Sink, ways: tuple[bool, ...] = BOTH_WAYS) -> Report:
        """Integrate from a state outwards to all the times, which are monotonic; on Ctrl-C what is finished is kept.

        A state with one time is that of one body, one with times those of an ensemble.
        """
        given, constants, members = (self, state, times, sink, ways), constants_of(self), bool(state.time.ndim)
        self.check_device(members)
        engine_run, looped_run = _Members if members else _OneBody, CudaRun if self.device == "cuda" else LoopedRun
        run = engine_run(*given) if constants is None else looped_run(constants, *given)
        with HeldInterrupts(run.interrupt):
            run.go()
        return run.report

    def check_device(self, members: bool) -> None:
        """Refuse what the device does not do, and a computer without one."""
        if self.device == "cuda":
            check_device(self, members, constants_of(self))


class _EngineRun(Run):
    """One on heyoka's engines."""

    def kernel(self, lanes: int) -> AbstractContextManager[kernels.Kernel]:
        """Provide the kernel."""
        own = self.job
        return kernels.kernel_of(own.problem, own.variables, own.precision, own.tolerance, lanes)

    def integrations(
        self, stepper: Callable[[bool], Stepper], members: NDArray[np.int_]
    ) -> Iterator[tuple[Integration, NDArray[np.int_]]]:
        """Yield the integration of members in each direction, and where in the rising times each of them starts."""
        origins, starts = self.origins[members], self.starts[members]
        places = self.rising.searchsorted(origins)
        each = places.tolist()
        for forwards in self.ways:
            if min(each) < self.rising.size if forwards else max(each) > 0:
                grids = [self.rising[place:] if forwards else self.rising[:place][::-1] for place in each]
                given = stepper(forwards), members, starts, origins, grids
                if self.clock is None:
                    yield Integration(*given, forwards), places
                else:
                    yield SampledIntegration(*given, self.clock, self._updates(self.clock)), places

    def _updates(self, clock: Clock) -> Updates:
        """Return what is done at samples."""
        smooth, variables = self.job.problem.between_knots(), self.job.variables
        key = "updates", smooth.structure, variables.structure
        jumps = kernels.known(key, lambda: kernels.updates(smooth, variables))

        def inputs(time: float, member: int) -> list[Any]:
            around = self.job.problem.between_knots(time)
            numbers = variables.scale, *variables.factors, *around.numbers
            return [x[member] if np.ndim(x) else x for x in numbers]

        return Updates(jumps, inputs, clock)

    def book(self, integrations: list[Integration]) -> None:
        """Note what happened to members."""
        out = self.report
        for part in integrations:
            out.steps[part.members] += part.steps
            for lane, member in enumerate(part.members.tolist() if any(part.failed) or any(part.events) else ()):
                out.events += [(member, record) for record in part.events[lane]]
                if part.failed[lane]:
                    why = self.reason(member, part.failed[lane])
                    stop = Stop(why, float(part.reached[lane]), float(part.lasts[lane]), part.cause)
                    out.stops.setdefault(member, stop)


class _OneBody(_EngineRun):
    """What is computed before Ctrl-C or a failure is kept."""

    def go(self) -> None:
        own, out = self.job, self.report
        kind, origin = kernels.PRECISIONS[own.precision], float(self.origins[0])
        ends = (origin, float(self.times[0]), float(self.times[-1]))
        dense = out.dense = DenseOutput(own.variables, origin, self.starts[0]) if own.dense else None
        polynomials = {forwards: Polynomials(own.variables, kind, forwards) for forwards in BOTH_WAYS}

        def stepper(forwards: bool) -> Stepper:
            return DenseStepper(kernel, kind, polynomials[forwards]) if dense else ScalarStepper(kernel, kind)

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
            dense.parts = polynomials
            dense.reached = {part.forwards: float(part.reached[0]) for part in parts}
            dense.last = next((part.states[0] for part in parts if isinstance(part, SampledIntegration)), None)
            dense.actions = [action for part in parts for action in part.actions[0]]
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
        later, earlier = (rows.get(forwards, self.starts[:0]) for forwards in BOTH_WAYS)
        place = int(self.rising.searchsorted(self.origins[0]))
        times = self.rising[place - len(earlier) : place + len(later)][self.turn]
        whole = (np.concatenate([earlier[::-1], later]) if len(earlier) else later)[self.turn]
        self.sink.take(kernels.FIRST, times, Rows(self.job.variables, times, whole))


class _Members(_EngineRun):
    """Slabs of members, taken by threads one after another; on Ctrl-C the members that are finished are kept."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.width = self.report.lanes = kernels.LANES if np.ndim(self.job.variables.scale) else 1

    def go(self) -> None:
        own, count = self.job, self.origins.size
        threads = min(own.threads, -(-count // self.width))
        began = clock.perf_counter()
        with bar("members", count, own.progress) as told:
            self.on_threads(threads, self._cut(), lambda slabs: self.serve(slabs, told))
        self.report.wall_time = clock.perf_counter() - began

    def _cut(self) -> Iterator[NDArray[np.int_]]:
        """Yield the members in slabs, fast rotators of each group first: lanes of a batch take about as many steps."""
        own, count = self.job, self.origins.size
        speed = np.broadcast_to(own.problem.system.speed(self.state), (count,))
        order = np.lexsort((-speed, np.arange(count) // GROUP))
        row = self.times.size * own.variables.size * self.width * 8
        slab = self.width * int(np.clip(SLAB_BYTES // row, 1, BATCHES_IN_A_SLAB))
        yield from (order[i : i + slab] for i in range(0, count, slab))

    def serve(self, slabs: Iterable[NDArray[np.int_]], told: Callable[[float], None]) -> None:
        """Integrate slab after slab."""
        with self.kernel(self.width) as kernel:
            self.report.order, self.report.tolerance = kernel.engine.order, float(kernel.engine.tol)
            for slab in slabs:
                self._integrate(kernel, slab, told)

    def _integrate(self, kernel: kernels.Kernel, slab: NDArray[np.int_], told: Callable[[float], None]) -> None:
        variables = self.job.variables
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
            part.put(rows, places)
        with self.lock:
            self.report.finished += members.size
            self.book(done)
        return True
