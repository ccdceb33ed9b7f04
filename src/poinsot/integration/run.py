"""Run of a problem on its kernel: one body or the members of an ensemble, from their starts outwards to times."""

from __future__ import annotations

import functools
import time as clock
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from threading import Lock
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import bar
from poinsot.integration.breakpoints import Clock, Segments
from poinsot.integration.equations import LANES
from poinsot.integration.event_log import EventLog
from poinsot.integration.kernel_parameters import KernelKind, KernelParameters
from poinsot.integration.problem import Problem
from poinsot.integration.report import INTERRUPTED, REASONS, HeldInterrupts, Report, Stop, reason, reason_of_speed
from poinsot.integration.rows import DenseOutput, Rows, Sink
from poinsot.integration.saltation import NoDerivative, TangentJump
from poinsot.integration.settings import RunSettings
from poinsot.integration.starts import low_parts, unit_of_time
from poinsot.integration.state_vector import StateVector
from poinsot.integration.variational import STEPS_AT_A_TIME
from poinsot.kinematics.state import AnyState
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.members import members_of
from poinsot.taylor import kernels
from poinsot.taylor.dense_output import StoredSteps
from poinsot.taylor.kernels import ROUNDING, KernelProgram
from poinsot.taylor.lowering import Program
from poinsot.taylor.memory import Layout
from poinsot.taylor.queue import Kernel, Output, Queue, Worker
from poinsot.taylor.tasks import Status

__all__ = ["BOTH_WAYS", "Run", "Slab"]

BOTH_WAYS = (True, False)
"""Forwards, then backwards."""

MAX_SLAB_BYTES = 16_000_000
"""Largest size of the rows that a thread holds of its members."""

MAX_SLAB_OF_EVENTS = 4096
"""Most members of a slab with events, which Python handles before it reacts to Ctrl-C."""

BYTES_AT_A_TIME = 1_000_000
"""Size of the rows that a sink receives at a time, so that results computed from them stay in the cache."""

FIRST = np.zeros(1, dtype=int)
NONE, NO_TASKS = np.empty(0, dtype=int), np.empty((0, 4), dtype=int)

Members = NDArray[np.int_]
Tasks = NDArray[np.int_]
"""Numbers of tasks: each is one member in one direction."""


class LaneMemory(Protocol):
    """Memory of one thread whose lanes integrate the tasks of a queue, on a processor or on a GPU."""

    def queue(self, states: Array, times: Array, parameters: Array, output: Output) -> Queue:
        """Return the queue of some tasks."""

    def start(self, queue: Queue) -> None:
        """Turn to a queue."""

    def advance(self) -> bool:
        """Take a number of steps in each lane; return True if tasks are left."""

    def note(self) -> Tasks:
        """Write the progress of the tasks in lanes into the queue, and return their numbers."""

    def give_up(self, numbers: Tasks) -> None:
        """Let tasks leave their lanes after their next step."""

    def finish(self) -> None:
        """Let all tasks leave their lanes."""

    def new_records(self) -> NDArray[np.void]:
        """Return the records of events since the last call."""


class Run:
    """Run of one body, or of members of an ensemble, from a state outwards to times in one direction or in both.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    state : AnyState
        Without an axis of members for one body.
    times : array (n,)
        Monotonic.
    sink : Sink
        Receiver of the rows.
    settings : RunSettings
    ways : tuple of bool
        Directions.

    Attributes
    ----------
    parameters : KernelParameters
        Starts of the members and parameters of the kernel.
    report : Report
    """

    kernel_name: ClassVar[str] = "looped"

    def __init__(
        self,
        problem: Problem,
        variables: StateVector,
        state: AnyState,
        times: Array,
        sink: Sink,
        settings: RunSettings,
        ways: tuple[bool, ...] = BOTH_WAYS,
    ) -> None:
        self.state, self.times, self.sink, self.settings, self.ways = state, times, sink, settings, ways
        self.one, self.turn = not state.time.ndim, slice(None, None, 1 if times[0] <= times[-1] else -1)
        self.rising, origins = times[self.turn].copy(), state.time.reshape(-1)
        start = variables.from_state(state)
        starts = start.reshape(-1, start.shape[-1])
        self.clock: Clock | None = None
        if jumping := problem.dynamics.jumping:
            self.clock = Clock(jumping, problem.dynamics.numbered(origins.size), state.jumped)
            if self.rising[0] < origins.max() and False in ways:
                raise ValueError(
                    f"times must not be before the state's where {quoted(jumping[0].name)} is sampled, got "
                    f"{self.rising[0]} before {origins.max()}. Such motions run forwards only."
                )
        wide = settings.precision == "quadruple"
        order = kernels.order_of(settings.tolerance or ROUNDING[settings.precision], wide)
        layout: tuple[Layout, int] = ("single", 1) if origins.size == 1 else ("batch", LANES)
        kind = KernelKind(order, *layout, wide, self.compiled)
        self.parameters = KernelParameters(problem, variables, starts, origins, kind)
        self.low_parts: tuple[Array, Array] | None = None
        if wide:
            self.low_parts = low_parts(variables, state, starts), unit_of_time(self.speeds)[:, None]
        self.interrupts, self.lock = HeldInterrupts(), Lock()
        self.report = Report(
            np.zeros(origins.size, dtype=int),
            order=order,
            tolerance=settings.tolerance,
            kernel=self.kernel_name,
            lanes=self.parameters.code.lanes,
        )

    @staticmethod
    def compiled(program: Program, kind: KernelKind) -> Kernel:
        """Return the compiled kernel of a program."""
        if program.jumps:
            given = program.decomposition, kind.order, kind.lanes, kind.layout, kind.wide, program.jumps
            return kernels.Code(KernelProgram(*given))
        return kernels.compiled(program.decomposition, kind.order, kind.lanes, kind.layout, kind.wide)

    @functools.cached_property
    def speeds(self) -> Array:
        """Angular velocities of the members at their starts."""
        with np.errstate(over="ignore"):
            speeds = self.parameters.problem.dynamics.speed(self.state)
        return np.broadcast_to(speeds, self.parameters.origins.shape)

    def integrate(self) -> Report:
        """Integrate, hand the rows to the sink, and return the report."""
        began = clock.perf_counter()
        with self.interrupts:
            if self.one:
                self._integrate_one_body()
            else:
                self._integrate_members()
        self.report.wall_time, self.report.interrupted = clock.perf_counter() - began, self.interrupts.heard
        return self.report

    def _integrate_one_body(self) -> None:
        """Integrate; rows that are computed before Ctrl-C or a failure remain."""
        code, origin = self.parameters.code, float(self.parameters.origins[0])
        rows = np.empty((1, self.rising.size, code.variables))
        memory = Worker(code, stores_steps=True) if self.settings.dense else code.idle_worker()
        slab = Slab(self, FIRST, memory, rows)
        ends = (origin, float(self.times[0]), float(self.times[-1]))
        with bar("time", max(ends) - min(ends), self.settings.progress) as show:
            slab.advance(show)
        reached = slab.reached
        times = self.rising[reached][self.turn]
        self.sink.take(FIRST, times, Rows(self.parameters.variables, times, rows[0, reached][self.turn]))
        slab.record()
        if self.settings.dense:
            self.report.dense = slab.dense_output(memory.steps)
        else:
            code.release(memory)

    # ------------------------------------------------------------------ members of an ensemble

    def _integrate_members(self) -> None:
        """Integrate slabs of members on threads; rows of members that are finished before Ctrl-C remain."""
        count = self.parameters.origins.size
        threads = max(min(self.settings.threads, -(-count // self.parameters.code.lanes)), 1)
        with bar("members", count, self.settings.progress) as show:
            self._on_threads(threads, self._slabs(self.fast_first(), threads), show)

    def fast_first(self) -> Members:
        """Return the members, fast rotators first."""
        several = self.parameters.origins.size > 1
        return np.argsort(-self.speeds, kind="stable") if several else np.zeros(1, dtype=np.intp)

    def _slabs(self, order: Members, threads: int) -> Iterator[Members]:
        """Yield members in slabs, fast rotators first, of decreasing size, so that all threads end at the same time."""
        lanes, row = self.parameters.code.lanes, self.times.size * self.parameters.code.variables * 8
        most = min(max(MAX_SLAB_BYTES // row, 1), MAX_SLAB_OF_EVENTS if self.parameters.problem.events else order.size)
        while order.size:
            fair = -(-order.size // (2 * threads)) if threads > 1 else order.size
            size = min(max(fair, 2 * lanes), most)
            yield order[:size]
            order = order[size:]

    def _on_threads(self, count: int, slabs: Iterator[Members], show: Callable[[float], None]) -> None:
        """Let threads integrate slabs of members until none is left; on Ctrl-C wait until all threads have returned."""
        if count == 1:
            self._serve(slabs, show)
            return
        from concurrent.futures import ThreadPoolExecutor, wait

        with ThreadPoolExecutor(count) as pool:
            workers = []
            try:
                workers += [pool.submit(self._serve, slabs, show) for _ in range(count)]
                while wait(workers, timeout=1.0).not_done:
                    pass
            except KeyboardInterrupt:
                self.interrupts.interrupt()
            for worker in workers:
                worker.result()

    def _serve(self, slabs: Iterator[Members], show: Callable[[float], None]) -> None:
        """Integrate slabs that other threads leave, until the run is to stop; small slabs are handed over together."""
        memory, done = Worker(self.parameters.code), list[tuple[Members, Array]]()
        try:
            while (members := self._next_of(slabs)) is not None:
                done.append(self.integrate_slab(memory, members, show))
                if sum(rows.nbytes for _, rows in done) >= BYTES_AT_A_TIME:
                    self.hand_over(done)
                    done.clear()
            if done:
                self.hand_over(done)
        except BaseException:  # otherwise the other threads would go on to the end first
            self.interrupts.stop = True
            raise

    def _next_of(self, slabs: Iterator[Members]) -> Members | None:
        with self.lock:
            return None if self.interrupts.stop else next(slabs, None)

    def integrate_slab(
        self, memory: LaneMemory, members: Members, show: Callable[[float], None]
    ) -> tuple[Members, Array]:
        """Integrate some members; return the finished members, and their rows at the rising times."""
        rows = np.full((members.size, self.times.size, self.parameters.code.variables), np.nan)
        slab = Slab(self, members, memory, rows)
        slab.advance(show)
        finished = slab.finished
        with self.lock:
            self.report.finished += int(finished.sum())
            slab.record()
        return (members, rows) if finished.all() else (members[finished], rows[finished])

    def hand_over(self, done: Sequence[tuple[Members, Array]]) -> None:
        """Hand members and their rows over to the sink."""
        members, rows = done[0] if len(done) == 1 else map(np.concatenate, zip(*done, strict=True))
        count = max(BYTES_AT_A_TIME * len(rows) // max(rows.nbytes, 1), 1)
        for first in range(0, members.size, count):
            some = slice(first, first + count)
            variables = members_of(self.parameters.variables, members[some])
            self.sink.take(members[some], self.times, Rows(variables, self.times, rows[some, self.turn]))


class Slab:
    """Members of a run in the memory of one thread, or one body; each task is one member in one direction.

    Parameters
    ----------
    run : Run
    members : array (n,)
    memory : LaneMemory
    rows : array (n, times, size)
        Variables of the members at the rising times, which the run writes.

    Attributes
    ----------
    queue : Queue
    failed : dict
        Task -> reason why it was given up.
    """

    def __init__(self, run: Run, members: Members, memory: LaneMemory, rows: Array) -> None:
        self.run, self._members, self._memory = run, members, memory
        self.failed: dict[int, str] = {}
        self._shown, parameters = 0.0, run.parameters
        output = self._output_of_one(rows) if run.one else self._output_of_members(rows)
        self.owners = owners = members[self._places]
        chosen = slice(None) if run.one else owners
        origins = parameters.origins[chosen]
        self.queue: Queue = memory.queue(parameters.starts[chosen], origins, parameters.table[chosen], output)
        tasks, torque_scale = self.queue.tasks, parameters.torque_scale
        tasks["torque_scale"] = torque_scale[chosen] if torque_scale.ndim else torque_scale
        if run.low_parts is not None:
            tasks["below"], tasks["unit"] = (each[chosen] for each in run.low_parts)
        if run.clock is not None:
            run.clock.set(tasks, origins, owners)
        self._segments = Segments(parameters, tasks, owners) if parameters.problem.knots.size else None
        self._log: EventLog | None = None
        if parameters.code.events:
            self._log = EventLog(parameters, self.queue, owners, self.failed, run.interrupts)
        self._checked: tuple[Array, NDArray[np.int_]] | None = None

    def _output_of_members(self, rows: Array) -> Output:
        """Return the destinations of the rows of tasks, and write the rows at the start."""
        members, rising, ways = self._members, self.run.rising, self.run.ways
        origins = self.run.parameters.origins[members]
        places = rising.searchsorted(origins)
        there = (rising.take(places, mode="clip") == origins) & (True in ways) & (self.run.clock is None)
        rows[there, places[there]] = self.run.parameters.starts[members[there]]
        first, table = places + there, np.empty((members.size, 2, 4), np.int64)
        table[:, :, 0], table[:, :, 3] = np.arange(members.size)[:, None], (1, -1)
        table[:, 0, 1], table[:, 0, 2] = first, (rising.size - first) * (True in ways)
        table[:, 1, 1], table[:, 1, 2] = places - 1, places * (False in ways)
        self._places, first, counts, stride = table[table[:, :, 2] > 0].T.copy()
        return Output.of(rising, rows, self._places, first, counts, stride)

    def _output_of_one(self, rows: Array) -> Output:
        """Return the destinations of the rows of one body, for which plain numbers are faster."""
        rising, ways, tasks, run = self.run.rising, self.run.ways, [], self.run
        place = first = bisect_left(rising, origin := run.parameters.origins[0])
        if True in ways and run.clock is None and place < rising.size and rising[place] == origin:
            rows[0, place], first = run.parameters.starts[0], place + 1
        if True in ways and first < rising.size:
            tasks.append((rising.size - first, 1, first, first))
        if False in ways and place:
            tasks.append((place, -1, place - 1, place - 1))
        self._at_start, self._places = slice(place, first), np.zeros(len(tasks), dtype=np.int64)
        return Output(rising, rows, tasks or NO_TASKS, [rising[-1 if task[1] > 0 else 0] for task in tasks])

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Mask of the members that have come to their end, or stopped before."""
        status = self.queue.tasks["status"]
        under_way = (status == Status.UNDER_WAY) | (status == Status.PAUSED)
        left: NDArray[np.int_] = np.bincount(self._places[under_way], minlength=self._members.size)
        finished: NDArray[np.bool_] = left == 0
        return finished

    @property
    def reached(self) -> slice:
        """Range of the rising times that one body has reached."""
        queue, first, last = self.queue, self._at_start.start, self._at_start.stop
        for (_, stride, *_), count in zip(queue.output.tasks, queue.tasks["index"].tolist(), strict=True):
            first, last = (first, last + count) if stride > 0 else (first - count, last)
        return slice(first, last)

    def dense_output(self, blocks: Sequence[NDArray[np.void]]) -> DenseOutput:
        """Return the motion of one body at any time, from the polynomials of the steps."""
        tasks, parameters = self.queue.tasks, self.run.parameters
        ways = (tasks["stride"] > 0).tolist()
        parts: dict[bool, list[NDArray[np.void]]] = {way: [blocks[0][:0]] for way in BOTH_WAYS}
        for block in blocks:
            for task, way in enumerate(ways):
                own = block["task"] == task
                parts[way].append(block if own.all() else block[own])
        dense = DenseOutput(parameters.variables, float(parameters.origins[0]), parameters.starts[0])
        dense.parts = {way: StoredSteps(blocks) for way, blocks in parts.items()}
        dense.actions = [action for of_task in self._log.actions for action in of_task] if self._log else []
        if self.run.clock is not None and tasks.size:
            dense.last = tasks["state"][0].copy()
        dense.reached = dict(zip(ways, tasks["time"][:, 0].tolist(), strict=True))
        return dense

    # ------------------------------------------------------------------ tasks in lanes

    def advance(self, show: Callable[[float], None]) -> None:
        """Take steps until all tasks are done or the run is to stop."""
        variations, memory, interrupts = self.run.parameters.variables.variations, self._memory, self.run.interrupts
        memory.start(self.queue)
        if variations is not None:
            self.queue.tasks["pause"] = STEPS_AT_A_TIME[variations.order] // 10
        while True:
            while memory.advance():
                for task in self._check_progress(memory.note()):
                    memory.give_up(np.array([task]))
                self._show(show)
                if interrupts.stop:
                    break
            memory.finish()
            waiting = self._resumed()
            self._show(show)
            if interrupts.stop or not waiting:
                return
            self.queue.put(np.concatenate(waiting))

    def _check_progress(self, numbers: Tasks) -> list[int]:
        """Return tasks whose steps are so short that they would not end, and note the reasons."""
        tasks = self.queue.tasks
        if self._checked is None:
            self._checked = tasks["time"][:, 0].copy(), tasks["steps"].copy()
        times, counts = self._checked
        due, failed = numbers[tasks["steps"][numbers] - counts[numbers] >= kernels.BUDGET], list[int]()
        for k in due.tolist():
            task, steps = tasks[k], int(tasks["steps"][k] - counts[k])
            time = float(task["time"][0])
            left, advance = abs(float(task["end"]) - time), abs(time - float(times[k]))
            if why := reason(advance, time, left, steps):
                self.failed[k] = why
                failed.append(k)
        times[due], counts[due] = tasks["time"][due, 0], tasks["steps"][due]
        return failed

    def _show(self, show: Callable[[float], None]) -> None:
        """Report progress: the time covered by one body, or the number of finished members."""
        if not self.run.settings.progress:
            return
        times, origin = self.queue.tasks["time"][:, 0], self.run.parameters.origins[0]
        done = float(np.sum(np.abs(times - origin) if self.run.one else self.finished))
        show(done - self._shown)
        self._shown = done

    # ------------------------------------------------------------------ tasks that have left their lanes

    def _resumed(self) -> list[Tasks]:
        """Handle tasks that have left their lanes, as `EXITS` states, and return the tasks that go on."""
        self._give_up_failed()
        found, waiting = self.queue.tasks["status"].tolist(), []
        for number, resume in RESUMED:
            if number in found or (self._log is not None and number == EVENT):
                waiting.append(resume(self))
                self._give_up_failed()
        return [tasks for tasks in waiting if tasks.size]

    def _give_up_failed(self) -> None:
        """Set the status of tasks that failed, so that they do not go on."""
        if self.failed:
            self.queue.tasks["status"][list(self.failed)] = Status.GIVEN_UP

    def _resumed_at_events(self) -> Tasks:
        """Record events and apply actions, or let tangent vectors jump at a switch; return the tasks that go on."""
        status = self.queue.tasks["status"]
        if self._log is None:
            self._jump(stopped := np.flatnonzero(status == Status.EVENT))
        else:
            notes = self._memory.new_records()
            if self.run.interrupts.stop and not self.run.one:  # members under way are dropped
                left = status[notes["task"]]
                notes = notes[(left != Status.UNDER_WAY) & (left != Status.PAUSED)]
            stopped = self._log.take(notes)
        return np.setdiff1d(stopped, list(self.failed)) if self.failed else stopped

    def _jump(self, stopped: Tasks) -> None:
        """Let tangent vectors of tasks jump where formulas have switched, or note why they have no derivative."""
        parameters, tasks, saltation = self.run.parameters, self.queue.tasks, self.run.parameters.formulas.saltation
        vectors, conditions = parameters.variables.tangent_vectors, list(parameters.code.conditions)
        if saltation is None:
            return
        for k in stopped.tolist():
            task, time = tasks[k], tasks["time"][k, :1]
            inputs = parameters.inputs_around(time, self.owners[[k]])
            numbers = [float(np.ravel(number)[0]) for number in inputs]
            jump = TangentJump(saltation, task["state"], time[0], numbers, float(task["simultaneity"]))
            before, behind = task["branches"].copy(), task["next_branches"].copy()
            task["branches"][:], task["parameters"][conditions] = behind, behind
            task["below"][vectors] = 0.0
            try:
                task["state"][vectors] = jump.across(before, behind)
            except NoDerivative as error:
                self.failed[k] = str(error)

    def _resumed_at_knots(self) -> Tasks:
        """Set the parameters behind a knot of tables; return the tasks whose last segment is still to come."""
        return NONE if self._segments is None else self._segments.go_on(self.run.interrupts.stop)

    def _resumed_after_pause(self) -> Tasks:
        """Rescale tangent vectors that have grown, and return their tasks, but no task that would not end."""
        variables, tasks = self.run.parameters.variables, self.queue.tasks
        variations, status = variables.variations, tasks["status"]
        self._check_progress(np.flatnonzero(status == Status.PAUSED))
        self._give_up_failed()
        paused = np.flatnonzero(status == Status.PAUSED)
        if variations is None or not paused.size or self.run.interrupts.stop:
            return NONE
        states = tasks["state"][paused]
        variations.rescale(states[:, variables.tangent_vectors])
        tasks["state"][paused], tasks["below"][paused] = states, 0.0
        tasks["pause"][paused] += STEPS_AT_A_TIME[variations.order]
        return paused

    # ------------------------------------------------------------------ report

    def record(self) -> None:
        """Record the steps, events and stops of finished members, and of one body in any case."""
        report, tasks, log, owners = self.run.report, self.queue.tasks, self._log, self.owners
        chosen: Iterable[int] = range(tasks.size)
        stopped, status = chosen, tasks["status"]
        if self.run.one:  # `add.at` is slow to begin
            report.steps[0] = sum(tasks["steps"].tolist())
        else:
            finished = self.finished[self._places]
            chosen = np.flatnonzero(finished)
            stopped = np.flatnonzero(finished & (status != Status.DONE) & (status != Status.ENDED))
            np.add.at(report.steps, owners[chosen], tasks["steps"][chosen])
        if log is not None:
            report.events += [(int(owners[k]), record) for k in chosen for record in log.records[k]]
        for k in stopped:
            if status[k] not in FINISHED:
                why, time = self._reason(k), float(tasks["time"][k, 0])
                stop = Stop(why, time, float(self.queue.output.ends[k]), log.causes.get(k) if log else None)
                report.stops.setdefault(int(owners[k]), stop)

    def _reason(self, task: int) -> str:
        """Return the reason why a task stopped before its end, which may be the angular velocity at the start."""
        status = Status(int(self.queue.tasks["status"][task]))
        why = self.failed[task] if status is Status.GIVEN_UP else EXITS[status].reason
        power = 2 if self.queue.wide else self.run.report.order  # the unit of time in quadruple precision is a period
        return reason_of_speed(why, float(self.run.speeds[self.owners[task]]), power)


class Exit(NamedTuple):
    """Handling of tasks that have left their lanes with one status.

    Attributes
    ----------
    reason : str
        Reason why the motion stops there before its end.
    resume : callable or None
        Method of `Slab` that handles the tasks and returns those which go on.
    """

    reason: str = INTERRUPTED
    resume: Callable[[Slab], Tasks] | None = None


EXITS: dict[Status, Exit] = {
    Status.EVENT: Exit(resume=Slab._resumed_at_events),
    Status.PAUSED: Exit(resume=Slab._resumed_after_pause),
    Status.DONE: Exit(resume=Slab._resumed_at_knots),
    Status.UNDER_WAY: Exit(),
    Status.ENDED: Exit(),
    Status.GIVEN_UP: Exit(),
    Status.NOT_FINITE: Exit(REASONS["not_finite"]),
    Status.STALLED: Exit(REASONS["rounding"]),
    Status.HELD: Exit(REASONS["switch"]),
}
"""Why a task leaves its vector lane, and what handles it, in this order.

EVENT: an event or a switch at which tangent vectors jump. PAUSED: the number of steps after which tangent vectors are
rescaled. DONE: the end of the motion or of a segment between knots of tables. ENDED: a terminal event. GIVEN_UP: a
reason that Python found, such as steps that lead nowhere. NOT_FINITE: a singular force. STALLED: steps of the size of
rounding. HELD: switches that lead back to each other.
"""

EVENT, FINISHED = int(Status.EVENT), (int(Status.DONE), int(Status.ENDED))
RESUMED = [(int(status), leave.resume) for status, leave in EXITS.items() if leave.resume is not None]
"""Handlers of `EXITS` by numbers: to read a member of an enumeration takes a tenth of a microsecond."""
