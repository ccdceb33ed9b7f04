"""Runs on kernels: one body or many, in double or quadruple precision."""

from __future__ import annotations

import contextvars
import platform
import time as clock
import weakref
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.display.progress import bar
from poinsot.integration import equations
from poinsot.integration.dense_output import Action, DenseOutput, KeptSteps
from poinsot.integration.event_log import NotedEvents
from poinsot.integration.runs import BOTH_WAYS, Job, Rows, Run, Stop
from poinsot.integration.saltation import Jump, NoDerivative
from poinsot.integration.scaling import torque_scale
from poinsot.integration.segments import Legs
from poinsot.integration.starts import low_parts, unit_of_time
from poinsot.integration.tangent_vectors import STEPS_AT_A_TIME
from poinsot.integration.termination import INTERRUPTED, REASONS, reason
from poinsot.taylor import kernels
from poinsot.taylor.evaluation import WideReplay
from poinsot.taylor.kernel_program import KernelProgram
from poinsot.taylor.kernels import Code, Output, Status
from poinsot.taylor.layouts import Layout
from poinsot.taylor.lowering import Constants, Program
from poinsot.taylor.replay import Replay, wide
from poinsot.taylor.square_roots import StartRoots

__all__ = ["LoopedRun", "constants_of"]

SLAB_BYTES = 16_000_000
"""The most that a thread holds of its members' variables before it hands them over."""

SLAB_OF_EVENTS = 4096
"""The most members of a slab whose events Python goes through before it hears Ctrl-C."""

HANDED_BYTES = 1_000_000
"""What of it is handed over at a time: what is computed of it then stays in the cache, in memory that is there."""

NEGLIGIBLE = {"double": 1e-9, "quadruple": 1e-18}
"""The part of the size of a square root that counts for nothing when squared, by precision."""

NONE, NO_TASKS = np.empty(0, dtype=int), np.empty((0, 4), dtype=int)

ROUNDING = {"double": 2.0**-52, "quadruple": 2.0**-104}
"""The distance from 1 to the next number, by precision: the smallest tolerance."""

NEVER: Any = (lambda: None), ()
"""The kernel of the last run and which constants were zero in it, where there was none."""

QUIET = contextvars.Context()
"""In copies of it nothing warns of constants that are not finite, which stop the run with a sentence.

To enter `np.errstate` takes ten times as long.
"""

QUIET.run(np.seterr, all="ignore")

UNDER_WAY, DONE, PAUSED, EVENT, ENDED = map(
    int, (Status.UNDER_WAY, Status.DONE, Status.PAUSED, Status.EVENT, Status.ENDED)
)

WHY = {
    Status.NOT_FINITE: REASONS["not_finite"],
    Status.STALLED: REASONS["rounding"],
    Status.HELD: REASONS["switch"],
}

Array = NDArray[Any]


def constants_of(job: Job) -> Constants:
    """Return the constants of a job; raise a RuntimeError where no kernel can run."""
    if job.device == "cpu" and not kernels.available():
        raise RuntimeError(
            f"the processor must multiply and add in one instruction (FMA), got {platform.machine()} without it. "
            "Closed forms run here, as pt.free_motion does."
        )
    return equations.looped_constants(job.problem.between_knots(), job.variables)


def _zeros(job: Job, constants: Constants, numbers: Sequence[Any], values: Sequence[Any]) -> tuple[int, ...]:
    """Return which constants are zero throughout: none that may change at knots, or where tangent vectors may jump."""
    return () if constants.jumps or job.problem.knots.size else constants.zeros(values, numbers)


def _values(replay: Replay | WideReplay, numbers: Sequence[Any]) -> Sequence[Any]:
    """Return what a replay gives for numbers: a list of floats if all are scalars, else a tuple that has arrays."""
    values = replay(numbers)
    return values if np.ndarray in map(type, numbers) else [*map(float, values)]


@dataclass(frozen=True, slots=True, weakref_slot=True)
class Ready:
    """A kernel, and what gives its parameters.

    These are behind the constants in what a replay gives for numbers; those of roots depend on starts.
    """

    code: Code
    values: Replay | WideReplay
    roots: StartRoots


class LoopedRun(Run):
    """One on a looped kernel.

    Attributes
    ----------
    code : Code
    parameters : array (members, parameters)
        Those of members that have no knots.
    push : array () or (members,)
        The momenta that forces give a body at rest.
    jumps : bool
        Whether tangent vectors may jump on the way.
    """

    kernel_name = "looped"

    def __init__(self, constants: Constants, *given: Any) -> None:
        super().__init__(*given)
        job, self._constants, self.jumps = self.job, constants, constants.jumps
        self.wide = job.precision == "quadruple"
        self.starts_below = low_parts(job.variables, self.state, self.starts) if self.wide else None
        self.units = unit_of_time(self.speeds)[:, None] if self.wide else None
        self.one = not self.state.time.ndim
        self._numbers = equations.numbers_of(job.problem.between_knots(), job.variables)
        self.ready, self.parameters = self._with_parameters()
        self.code = self.ready.code
        self.push = np.asarray(torque_scale(job.problem.dynamics) * job.variables.scale)
        self.report.order, self.report.tolerance = self.code.order, job.tolerance
        self.report.kernel, self.report.lanes = self.kernel_name, self.code.lanes

    def _with_parameters(self) -> tuple[Ready, Array]:
        """Return the kernel, which depends on which constants are zero, and the parameters of members."""
        job, constants = self.job, self._constants
        layout: tuple[Layout, int] = ("single", 1) if self.origins.size == 1 else ("batch", equations.LANES)
        order = kernels.order_of(job.tolerance or ROUNDING[job.precision], self.wide)
        kind = job.device, order, layout, self.wide
        last, zeros = constants.latest.get(kind, NEVER)
        ready = last()
        found, parameters = QUIET.copy().run(self._found, ready)
        if ready is None or found != zeros:
            ready = equations.known((constants, found, kind), lambda: self._made(found, order, *layout))
            constants.latest[kind] = weakref.ref(ready), found
            _, parameters = QUIET.copy().run(self._found, ready)
        return ready, parameters

    def _found(self, ready: Ready | None) -> tuple[tuple[int, ...], Any]:
        """Return which constants are zero, and the parameters of members for a kernel, if one is given."""
        numbers = self._numbers
        values = _values(self._constants.values if ready is None else ready.values, numbers)
        zeros = _zeros(self.job, self._constants, numbers, values)
        return zeros, ready and self._table(ready, values, numbers)

    def _made(self, zeros: tuple[int, ...], order: int, layout: Layout, lanes: int) -> Ready:
        smooth, variables, whole = self.job.problem.between_knots(), self.job.variables, self._constants.whole_program()
        program = whole if whole and not zeros else equations.looped_program(smooth, variables, zeros)
        code = self.compiled(program, order, layout, lanes)
        values = program.wide_values() if self.wide else program.values(wide)
        return Ready(code, values, StartRoots(program, variables.size))

    def compiled(self, program: Program, order: int, layout: Layout, lanes: int) -> Code:
        """Return the kernel of a program."""
        given = program.decomposition, order, lanes, layout
        if program.jumps:
            return Code(KernelProgram(*given, self.wide, program.jumps))
        return kernels.compiled(*given, self.wide)

    def _table(self, ready: Ready, values: Sequence[Any], numbers: Sequence[Any], members: Any = slice(None)) -> Array:
        """Return the parameters of members at their start, shape (n, parameters), from what the replay gives."""
        origins, columns = self.origins[members], values[self._constants.count :]
        if self.wide:  # behind the high parts of all values are the low parts
            count = len(values) // 2
            columns = [*values[self._constants.count : count], *values[count + self._constants.count :]]
            if any(isinstance(column, np.ndarray) for column in columns):
                columns = tuple(columns)
        table = np.empty((origins.size, len(columns)))
        if isinstance(columns, list):
            table[:] = columns
        else:
            for place, column in enumerate(columns):
                table[:, place] = column
        if ready.roots.places:
            ready.roots.set(
                table,
                numbers,
                self.starts[members],
                origins,
                self.job.variables.momenta,
                NEGLIGIBLE[self.job.precision],
            )
        return table

    def numbers_around(self, times: Array, members: NDArray[np.int_]) -> list[Any]:
        """Return the numbers of members, between the knots around times."""
        return equations.numbers_around(self.job.problem, self.job.variables, self._numbers, times, members)

    @property
    def counting(self) -> Replay:
        """What is positive where zeros of events count, of variables, time and numbers."""
        smooth, variables = self.job.problem.between_knots(), self.job.variables
        key = "counting", smooth.structure, variables.structure
        replay: Replay = equations.known(key, lambda: equations.counting(smooth, variables))
        return replay

    def parameters_around(self, times: Array, members: NDArray[np.int_]) -> Array:
        """Return the parameters of members, shape (n, parameters), between the knots around times."""
        own = self.numbers_around(times, members)
        with np.errstate(all="ignore"):
            return self._table(self.ready, _values(self.ready.values, own), own, members)

    @override
    def go(self) -> None:
        began = clock.perf_counter()
        if self.one:
            self._go_on_one_body()
        else:
            self._go_on_members()
        self.report.wall_time = clock.perf_counter() - began

    # ------------------------------------------------------------------ one body

    def _go_on_one_body(self) -> None:
        """Integrate; what is computed before Ctrl-C or a failure is kept."""
        job, origin = self.job, float(self.origins[0])
        rows = np.empty((1, self.rising.size, self.code.variables))
        kernel = kernels.Run(self.code, keeps_steps=True) if job.dense else self.code.idle_run()
        tasks = _Tasks(self, kernel, equations.FIRST, rows)
        ends = (origin, float(self.times[0]), float(self.times[-1]))
        with bar("time", max(ends) - min(ends), job.progress) as told:
            tasks.run(told)
        chosen = tasks.reached
        times = self.rising[chosen][self.turn]
        self.sink.take(equations.FIRST, times, Rows(job.variables, times, rows[0, chosen][self.turn]))
        tasks.book()
        if job.dense:
            dense = self.report.dense = DenseOutput(job.variables, origin, self.starts[0])
            kept = kernel.kept
            parts: dict[bool, list[Any]] = {way: [kept[0][:0]] for way in BOTH_WAYS}
            for block in kept:
                for k, way in enumerate(tasks.forwards):
                    own = block["task"] == k
                    parts[way].append(block if own.all() else block[own])
            dense.parts = {way: KeptSteps(blocks) for way, blocks in parts.items()}
            dense.actions = tasks.actions
            if self.clock is not None and tasks.queue.tasks.size:
                dense.last = tasks.queue.tasks["state"][0].copy()
            dense.reached = dict(zip(tasks.forwards, tasks.queue.tasks["time"][:, 0].tolist(), strict=True))
        else:
            self.code.keep(kernel)

    # ------------------------------------------------------------------ members

    def _go_on_members(self) -> None:
        """Integrate slabs of members on threads; on Ctrl-C the members that are finished are kept."""
        job, count = self.job, self.origins.size
        threads = max(min(job.threads, -(-count // self.code.lanes)), 1)
        with bar("members", count, job.progress) as told:
            self.on_threads(threads, self._cut(self.fast_first(), threads), lambda slabs: self._serve(slabs, told))

    def fast_first(self) -> NDArray[np.int_]:
        """Return the members, fast rotators first."""
        return np.argsort(-self.speeds, kind="stable")

    def _cut(self, order: NDArray[np.int_], threads: int) -> Iterator[NDArray[np.int_]]:
        """Yield members in slabs, fast rotators first and ever fewer, so that all threads end at the same time."""
        lanes, row = self.code.lanes, self.times.size * self.job.variables.size * 8
        most = min(max(SLAB_BYTES // row, 1), SLAB_OF_EVENTS if self.job.problem.events else order.size)
        while order.size:
            fair = -(-order.size // (2 * threads)) if threads > 1 else order.size
            size = min(max(fair, 2 * lanes), most)
            yield order[:size]
            order = order[size:]

    def _serve(self, slabs: Iterable[NDArray[np.int_]], told: Callable[[float], None]) -> None:
        """Integrate slab after slab; the rows of small ones are handed over together."""
        kernel, done = kernels.Run(self.code), list[tuple[NDArray[np.int_], Array]]()
        for members in slabs:
            done.append(self.integrate(kernel, members, told))
            if sum(rows.nbytes for _, rows in done) >= HANDED_BYTES:
                self.hand_over(done)
                done.clear()
        if done:
            self.hand_over(done)

    def integrate(
        self, kernel: Any, members: NDArray[np.int_], told: Callable[[float], None]
    ) -> tuple[NDArray[np.int_], Array]:
        """Integrate some members; return those that are finished, and their rows at the rising times."""
        rows = np.full((members.size, self.times.size, self.job.variables.size), np.nan)
        tasks = _Tasks(self, kernel, members, rows)
        tasks.run(told)
        kept = tasks.finished
        with self.lock:
            self.report.finished += int(kept.sum())
            tasks.book()
        return (members, rows) if kept.all() else (members[kept], rows[kept])

    def hand_over(self, done: Sequence[tuple[NDArray[np.int_], Array]]) -> None:
        """Hand over members and their rows."""
        members, rows = done[0] if len(done) == 1 else map(np.concatenate, zip(*done, strict=True))
        count = max(HANDED_BYTES * len(rows) // max(rows.nbytes, 1), 1)
        for first in range(0, members.size, count):
            some = slice(first, first + count)
            variables = self.job.variables.of_members(members[some])
            self.sink.take(members[some], self.times, Rows(variables, self.times, rows[some, self.turn]))


class _Tasks:
    """Members, each in each direction, in the queue of one thread.

    Parameters
    ----------
    run : LoopedRun
    kernel : Run
        Its memory.
    members : array (n,)
    rows : array (n, times, size)
        Where rows go, at the rising times.
    """

    def __init__(self, run: LoopedRun, kernel: Any, members: NDArray[np.int_], rows: Array) -> None:
        self._run, self._kernel, self._members, self._told = run, kernel, members, 0.0
        self._rows = rows
        self._judged: tuple[Array, Array] | None = None
        self._hopeless: dict[int, str] = {}
        output = self._of_one() if run.one else self._of_many()
        chosen = slice(None) if run.one else members[self.own]
        self.queue = kernel.queue(run.starts[chosen], run.origins[chosen], run.parameters[chosen], output)
        if run.starts_below is not None and run.units is not None:
            self.queue.tasks["below"] = run.starts_below[chosen]
            self.queue.tasks["unit"] = run.units[chosen]
        self.queue.tasks["push"] = run.push if run.push.ndim == 0 else run.push[chosen]
        if run.clock is not None:
            run.clock.set(self.queue.tasks, run.origins[chosen], members[self.own])
        self._legs = self._legs_of(members[self.own]) if run.job.problem.knots.size else None
        self._noted = self._noted_of(members[self.own]) if run.code.events else None

    def _noted_of(self, members: NDArray[np.int_]) -> NotedEvents:
        run, job = self._run, self._run.job
        given = job.problem, job.variables, run.counting, self.queue, members
        return NotedEvents(*given, run.numbers_around, run.interrupt, lambda: run.stop)

    def _legs_of(self, members: NDArray[np.int_]) -> Legs:
        run, roots, tasks = self._run, self._run.ready.roots.places, self.queue.tasks
        knots, origins = run.job.problem.knots, run.origins[members]
        return Legs(knots, tasks, members, tasks["stride"], origins, run.parameters_around, roots, run.one)

    def _of_many(self) -> Output:
        """Return where the rows of tasks go, and set the member of each; a row at the start is written."""
        run, members, ways = self._run, self._members, self._run.ways
        origins = run.origins[members]
        places = run.rising.searchsorted(origins)
        there = (run.rising.take(places, mode="clip") == origins) & (True in ways) & (run.clock is None)
        self._rows[there, places[there]] = run.starts[members[there]]
        first, table = places + there, np.empty((members.size, 2, 4), np.int64)
        table[:, :, 0], table[:, :, 3] = np.arange(members.size)[:, None], (1, -1)
        table[:, 0, 1], table[:, 0, 2] = first, (run.rising.size - first) * (True in ways)
        table[:, 1, 1], table[:, 1, 2] = places - 1, places * (False in ways)
        self.own, first, counts, stride = table[table[:, :, 2] > 0].T.copy()
        return Output.of(run.rising, self._rows, self.own, first, counts, stride)

    def _of_one(self) -> Output:
        """Return the same for one body, where plain numbers are faster."""
        run, rising, ways, tasks = self._run, self._run.rising, self._run.ways, []
        place = first = bisect_left(rising, origin := run.origins[0])
        if True in ways and run.clock is None and place < rising.size and rising[place] == origin:
            self._rows[0, place], first = run.starts[0], place + 1
        if True in ways and first < rising.size:
            tasks.append((rising.size - first, 1, first, first))
        if False in ways and place:
            tasks.append((place, -1, place - 1, place - 1))
        self._place, self._first, self.forwards = place, first, [task[1] > 0 for task in tasks]
        self.own = np.zeros(len(tasks), dtype=np.int64)
        ends = [rising[-1 if forwards else 0] for forwards in self.forwards]
        return Output(rising, self._rows, tasks or NO_TASKS, ends)

    def run(self, told: Callable[[float], None]) -> None:
        """Take steps until all is done or the run is to stop."""
        variations, tasks, kernel = self._run.job.variables.variations, self.queue.tasks, self._kernel
        kernel.start(self.queue)
        if variations is not None:
            tasks["pause"] = STEPS_AT_A_TIME[variations.order] // 10
        while True:
            while kernel.advance():
                self._watch(told)
                if self._run.stop:
                    break
            kernel.finish()
            waiting = self._waiting()
            self._tell(told)
            if self._run.stop or not waiting:
                return
            self.queue.put(np.concatenate(waiting))

    def _waiting(self) -> list[NDArray[np.int_]]:
        """Do what is due where tasks have left their lanes, and return those that go on."""
        status, waiting = self.queue.tasks["status"], []
        paused = PAUSED in status.tolist()  # of few tasks in a twentieth of the time
        if self._noted is not None:
            waiting.append(self._happen(self._noted))
        elif self._run.jumps:
            waiting.append(self._jump(np.flatnonzero(status == EVENT)))
        if paused:
            self._without_end(np.flatnonzero(status == PAUSED))
        if self._hopeless:
            status[list(self._hopeless)] = Status.GIVEN_UP
        if self._legs is not None:
            waiting.append(self._legs.go_on(self._run.stop))
        if paused:
            waiting.append(self._rescaled(np.flatnonzero(status == PAUSED)))
        return [tasks for tasks in waiting if tasks.size]

    def _happen(self, noted: NotedEvents) -> NDArray[np.int_]:
        """Let happen what the kernel has noted of events; return the tasks that go on behind one."""
        notes = self._kernel.happened()
        if self._run.stop and not self._run.one:  # members under way are not kept
            status = self.queue.tasks["status"][notes["task"]]
            notes = notes[(status != UNDER_WAY) & (status != PAUSED)]
        stopped = noted.take(notes)
        self._hopeless |= noted.failed
        return np.setdiff1d(stopped, list(noted.failed)) if noted.failed else stopped

    def _jump(self, stopped: NDArray[np.int_]) -> NDArray[np.int_]:
        """Let tangent vectors jump where formulas have switched, and return the tasks that go on behind that."""
        job, tasks, places = self._run.job, self.queue.tasks, list(self._run.code.conditions)
        saltation: Any = equations.saltation_of(job.problem, job.variables)
        for k in stopped.tolist():
            task, time = tasks[k], tasks["time"][k, :1]
            inputs = self._run.numbers_around(time, self._members[self.own[[k]]])
            numbers = [float(np.ravel(number)[0]) for number in inputs]
            jump = Jump(saltation, task["state"], time[0], numbers, float(task["near"]))
            before, behind = task["branches"].copy(), task["behind"].copy()
            task["branches"][:], task["parameters"][places] = behind, behind
            task["below"][job.variables.tangent_vectors] = 0.0
            try:
                task["state"][job.variables.tangent_vectors] = jump.across(before, behind)
            except NoDerivative as error:
                self._hopeless[k] = str(error)
        return np.setdiff1d(stopped, list(self._hopeless))

    def _rescaled(self, paused: NDArray[np.int_]) -> NDArray[np.int_]:
        """Rescale the vectors of tangents of tasks that have paused, and return these."""
        variables, tasks = self._run.job.variables, self.queue.tasks
        if variables.variations is None or not paused.size or self._run.stop:
            return NONE
        states = tasks["state"][paused]
        variables.variations.rescale(states[:, variables.tangent_vectors])
        tasks["state"][paused], tasks["below"][paused] = states, 0.0
        tasks["pause"][paused] += STEPS_AT_A_TIME[variables.variations.order]
        return paused

    def _watch(self, told: Callable[[float], None]) -> None:
        """Tell how far tasks are, and give up those whose steps lead nowhere."""
        for k in self._without_end(self._kernel.note()):
            self._kernel.give_up(np.array([k]))
        self._tell(told)

    def _without_end(self, numbers: NDArray[np.int_]) -> list[int]:
        """Note which of some tasks take steps that lead nowhere, and return them."""
        tasks = self.queue.tasks
        if self._judged is None:
            self._judged = tasks["time"][:, 0].copy(), tasks["steps"].copy()
        times, counts = self._judged
        due, hopeless = numbers[tasks["steps"][numbers] - counts[numbers] >= kernels.BUDGET], list[int]()
        for k in due.tolist():
            task, steps = tasks[k], int(tasks["steps"][k] - counts[k])
            time = float(task["time"][0])
            left, advance = abs(float(task["end"]) - time), abs(time - float(times[k]))
            if why := reason(advance, time, left, steps):
                self._hopeless[k] = why
                hopeless.append(k)
        times[due], counts[due] = tasks["time"][due, 0], tasks["steps"][due]
        return hopeless

    def _tell(self, told: Callable[[float], None]) -> None:
        if not self._run.job.progress:
            return
        tasks = self.queue.tasks
        if self._run.one:
            done = float(np.sum(np.abs(tasks["time"][:, 0] - self._run.origins[0])))
        else:
            done = float(np.sum(self.finished))
        told(done - self._told)
        self._told = done

    # ------------------------------------------------------------------ what has become of them

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Which members have come to an end, or stopped before."""
        status = self.queue.tasks["status"]
        under_way = (status == UNDER_WAY) | (status == PAUSED)
        left: NDArray[np.int_] = np.bincount(self.own[under_way], minlength=self._members.size)
        finished: NDArray[np.bool_] = left == 0
        return finished

    @property
    def actions(self) -> list[Action]:
        """The actions of events, task after task."""
        return [] if self._noted is None else [action for of_task in self._noted.actions for action in of_task]

    @property
    def reached(self) -> slice:
        """Which of the rising times one body has reached."""
        first, last = self._place, self._first
        for forwards, count in zip(self.forwards, self.queue.tasks["index"].tolist(), strict=True):
            first, last = (first, last + count) if forwards else (first - count, last)
        return slice(first, last)

    def book(self) -> None:
        """Note what happened to members that are finished, and to one body in any case."""
        report, tasks, noted = self._run.report, self.queue.tasks, self._noted
        chosen: Any = range(tasks.size)
        stopped, status = chosen, tasks["status"]
        if self._run.one:  # `add.at` is slow to begin
            report.steps[0] = sum(tasks["steps"].tolist())
        else:
            finished = self.finished[self.own]
            chosen = np.flatnonzero(finished)
            stopped = np.flatnonzero(finished & (status != DONE) & (status != ENDED))
            np.add.at(report.steps, self._members[self.own[chosen]], tasks["steps"][chosen])
        if noted is not None:
            report.events += [(self._member(k), record) for k in chosen for record in noted.records[k]]
        for k in stopped:
            if status[k] not in (DONE, ENDED):
                why, time = self._run.reason(self._member(k), self._why(k, int(status[k]))), float(tasks["time"][k, 0])
                stop = Stop(why, time, float(self.queue.output.ends[k]), noted.causes.get(k) if noted else None)
                report.stops.setdefault(self._member(k), stop)

    def _member(self, k: int) -> int:
        return int(self._members[self.own[k]])

    def _why(self, k: int, status: int) -> str:
        """Return why a task stopped before its end."""
        return self._hopeless[k] if status == Status.GIVEN_UP else WHY.get(Status(status), INTERRUPTED)
