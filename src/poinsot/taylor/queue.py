"""Queues of tasks, and the memory of the threads that work on them.

A `Worker` has its own memory, and a kernel releases the interpreter, so that several threads may share a queue.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.llvm_ir import offset_of
from poinsot.taylor.memory import QUEUE, Context
from poinsot.taylor.tasks import Status

__all__ = ["FOREVER", "LONGEST_STEP", "Kernel", "Output", "Queue", "Worker"]

FOREVER = 2**62
"""A number of steps that no task reaches."""

LONGEST_STEP = 2.0**46
"""Longest step in double precision. Within it no Taylor coefficient underflows unnoticed."""

ALIGNMENT = 64
"""Alignment of the memory of a worker in bytes."""

RECORDS_IN_BLOCK = 1024
"""Records of events that the kernel writes before Python copies them."""

STEPS_IN_BLOCK, MAX_BLOCK_BYTES = 256, 16_000_000
"""Stored steps of the first block, and the most bytes of a block."""

address_of, byte_of = ctypes.addressof, ctypes.c_char.from_buffer

Doubles: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Records: TypeAlias = NDArray[np.void]
RECORD = struct.Struct(f"{QUEUE.itemsize // 8}q")


class Kernel:
    """A compiled kernel, and its workers that wait for another run.

    Attributes
    ----------
    context : Context
    order, lanes, variables, events, conditions
        Sizes of the context.
    blank : bytes
        A task without numbers of its own.
    places : slice
        The four words of 8 bytes of a task that describe its rows, as in an `Output`.
    advance : callable
        Takes a number of steps of a worker, by the address of its memory; returns 1 if tasks are left.
    budget : int
        Number of steps between checks for Ctrl-C.
    """

    advance: Callable[[int, int], int]
    budget: int

    def __init__(self, context: Context) -> None:
        self.context, self.order, self.lanes = context, context.order, context.lanes
        self.variables, self.events, self.conditions = context.variables, context.events, context.conditions
        blank = np.zeros(1, context.task)
        blank["limit"], blank["pause"], blank["branches"], blank["unit"] = LONGEST_STEP, FOREVER, np.nan, 1.0
        first = offset_of(context.task, "count") // 8
        self.blank, self.places = blank.tobytes(), slice(first, first + 4)
        exact = [Fraction(1, n) for n in range(1, self.order + 1)]
        self.reciprocals_of_orders = np.array([0.0, *map(float, exact)])
        self.reciprocals_below = np.array([0.0, *(float(x - Fraction(float(x))) for x in exact)])
        self._idle: list[Worker] = []

    def idle_worker(self) -> Worker:
        """Return a worker whose run is over, or a new one."""
        try:
            return self._idle.pop()
        except IndexError:  # `if self._idle` would be wrong where threads share the list
            return Worker(self)

    def release(self, worker: Worker) -> None:
        """Store a worker whose run is over for another run."""
        worker.forget()
        self._idle.append(worker)


class Output(NamedTuple):
    """Rows of tasks and their times.

    Parameters
    ----------
    times : array (m,)
    rows : array (members, m, variables)
        Both C-contiguous and writable.
    tasks : sequence (n, 4)
        For each task the number of its rows, at least one; 1 for rising times or -1 for falling times; the number of
        its first time; and the number of the row of that time among all rows.
    ends : sequence (n,)
        For each task the last time.
    """

    times: Doubles
    rows: Doubles
    tasks: Sequence[Sequence[int]] | Integers
    ends: Sequence[float] | Doubles

    @classmethod
    def of(
        cls, times: Doubles, rows: Doubles, members: Integers, first: Integers, counts: Integers, stride: Integers
    ) -> Output:
        """Return the output of tasks that write the rows of members, in arrays (n,)."""
        tasks = np.stack([counts, stride, first, members * times.size + first], axis=-1)
        return cls(times, rows, tasks, times[first + stride * (counts - 1)])


class Queue:
    """Tasks that wait for lanes: members that start from some states, each in one direction.

    Workers of several threads may share a queue.

    Parameters
    ----------
    kernel : Kernel
    states : array (n, variables) or (1, variables)
    times : array (n,) or (1,)
        Times of the start.
    parameters : array (n, parameters) or (1, parameters)
    output : Output

    Attributes
    ----------
    tasks : structured array (n,)
        Tasks and, later, their results. Before a run, and where a task has left its lane, one may change `state`,
        `below` (the rounding errors of `state`), `parameters`, `end`, `limit` (the longest step), `pause` (the number
        of steps after which the task leaves its lane) and `torque_scale` (momenta that forces give a body at rest).
        Results are `state`, `time` (two parts), `status`, `steps`, `index` (the number of rows written) and `exponent`
        (of the scale of momenta).
    """

    def __init__(self, kernel: Kernel, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> None:
        count, size = len(output.tasks), len(kernel.blank)
        self._first = first = -(-(QUEUE.itemsize + 8 * count) // size) * size  # the record and numbers are in front
        self._blank, self._memory, self.wide = kernel.blank, bytearray(first + count * size), kernel.context.wide
        tasks = self.tasks = np.ndarray(count, kernel.context.task, self._memory, first)
        self._states, self._parameters, self._times = tasks["state"], tasks["parameters"], tasks["time"][:, 0]
        self._ways, self._ends, self._spans = tasks["way"], tasks["end"], tasks["span"]
        self._places = tasks.view(np.int64).reshape(count, size // 8)[:, kernel.places]
        self._record = np.ndarray(QUEUE.itemsize // 8, np.int64, self._memory)
        self._numbers = np.ndarray(count, np.int64, self._memory, QUEUE.itemsize)
        self._numbers[:] = np.arange(count)
        self.address = address_of(byte_of(self._memory))
        self.fill(states, times, parameters, output)

    def fill(self, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> None:
        """Replace all tasks by as many new ones."""
        count, here = self._numbers.size, self.address
        self._memory[self._first :] = self._blank * count
        self._states[:], self._times[:], self._parameters[:] = states, times, parameters
        self._places[:], self._ends[:] = output.tasks, output.ends
        self._ways[:] = self._places[:, 1]
        self._waiting, self.output, grid, rows = self._numbers, output, output.times, output.rows
        if self._spans.size:
            self._spans[:, 0] = np.abs(np.subtract(output.ends, times))
        if not (grid.flags.c_contiguous and rows.flags.c_contiguous and grid.itemsize == rows.itemsize == 8):
            raise ValueError("times and rows must be C-contiguous arrays of doubles, got others.")
        own, tasks = here + QUEUE.itemsize, here + self._first
        RECORD.pack_into(self._memory, 0, 0, count, own, tasks, _address(grid), _address(rows))

    def close(self) -> None:
        """Remove the tasks that wait."""
        self._waiting = self._waiting[:0]
        self._record[1] = 0

    def put(self, tasks: Integers) -> None:
        """Add tasks that are in no lane and do not wait, by their numbers. No worker may be advancing."""
        self._waiting = np.concatenate([self._waiting[self._record[0] :], tasks])
        self._record[:3] = 0, self._waiting.size, self._waiting.ctypes.data
        self.tasks["status"][tasks] = Status.UNDER_WAY

    def take(self) -> Integers:
        """Remove all tasks that wait, and return their numbers."""
        waiting = self._waiting[self._record[0] :]
        self._record[0] = self._record[1]
        return waiting


class Worker:
    """The memory of one thread that works on queues of tasks.

    Parameters
    ----------
    kernel : Kernel
    stores_steps : bool
        True if `steps` contains the coefficients of all steps; for one lane.
    """

    def __init__(self, kernel: Kernel, stores_steps: bool = False) -> None:
        memory = np.zeros(kernel.context.work.itemsize + ALIGNMENT, np.uint8)
        start = -_address(memory) % ALIGNMENT
        memory = memory[start : start + kernel.context.work.itemsize]
        self._work = work = memory.view(kernel.context.work)
        work["reciprocals_of_orders"] = kernel.reciprocals_of_orders
        work["reciprocals_below"] = kernel.reciprocals_below
        self._kernel, self._address = kernel, _address(memory)
        self._active, self._pause, self._times = work["active"][0], work["pause"][0], work["time"][0, 0]
        self._queue_address, self._record_count, self._stored_count = (
            work[name] for name in ("queue", "record_count", "stored_count")
        )
        self._records, self._blocks = list[Records](), list[Records]()
        if kernel.events:
            self._block = np.empty(RECORDS_IN_BLOCK + kernel.lanes, kernel.context.record)
            work["records"], work["records_limit"] = _address(self._block), RECORDS_IN_BLOCK
        work["stored_limit"] = FOREVER
        self._queues: list[Queue] = []
        if stores_steps:
            self._new_block(STEPS_IN_BLOCK)

    def queue(self, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> Queue:
        """Return a queue, in the memory of the last queue if that has as many tasks."""
        for queue in self._queues:
            if queue.tasks.size == len(output.tasks):
                queue.fill(states, times, parameters, output)
                return queue
        return Queue(self._kernel, states, times, parameters, output)

    def start(self, queue: Queue) -> None:
        """Begin to work on a queue, and remove steps and records of earlier queues."""
        self._queues, self._queue_address[0], self._stored_count[0] = [queue], queue.address, 0
        self._blocks, self._records = self._blocks[-1:], []
        self._active[:] = self._record_count[0] = 0

    def new_records(self) -> Records:
        """Return the records of events since the last call, the records of each task in order."""
        self._copy_records()
        blocks, self._records = self._records, []
        return np.concatenate(blocks) if blocks else np.empty(0, self._kernel.context.record)

    def _copy_records(self) -> None:
        if count := self._record_count[0]:
            self._records.append(self._block[:count].copy())
            self._record_count[0] = 0

    def forget(self) -> None:
        """Drop the references to times and rows."""
        del self._queues[-1].output

    def _new_block(self, count: int) -> None:
        block = np.empty(count, self._kernel.context.step)
        self._blocks.append(block)
        self._work["stored_steps"], self._work["stored_limit"], self._stored_count[0] = _address(block), count, 0

    def advance(self, budget: int | None = None) -> bool:
        """Take at most some steps in each lane, and return True if tasks are left."""
        left = bool(self._kernel.advance(self._address, budget or self._kernel.budget))
        if self._record_count[0] > RECORDS_IN_BLOCK:
            self._copy_records()
        if left and self._blocks and self._stored_count[0] == self._blocks[-1].size:
            most = max(STEPS_IN_BLOCK, MAX_BLOCK_BYTES // self._kernel.context.step.itemsize)
            self._new_block(min(2 * self._blocks[-1].size, most))
        return left

    def note(self) -> Integers:
        """Copy the progress of the tasks in lanes to the queue, and return their numbers."""
        work, tasks = self._work[0], self._queues[-1].tasks
        lanes = np.flatnonzero(work["active"])
        numbers: Integers = work["task"][lanes]
        for name in ("steps", "index"):
            tasks[name][numbers] = work[name][lanes]
        tasks["time"][numbers] = work["time"][:, lanes].T
        return numbers

    def give_up(self, numbers: Integers) -> None:
        """Let tasks in lanes leave them after their next step."""
        self._pause[np.isin(self._work[0]["task"], numbers) & (self._active != 0)] = 0

    def finish(self) -> None:
        """Let all tasks leave their lanes, after one more step if they are not done, and take no others."""
        if 1 in self._active.tolist():  # for one lane five times as fast as `any`
            self._queues[-1].close()
            self._pause[:] = 0
            self.advance(1)

    @property
    def times(self) -> Doubles:
        """The times that the lanes have reached."""
        reached: Doubles = self._times[self._active != 0]
        return reached

    @property
    def steps(self) -> list[Records]:
        """Blocks of stored steps: task, start (two parts), length and coefficients (order + 1, variables) of each."""
        return [*self._blocks[:-1], *(block[: self._stored_count[0]] for block in self._blocks[-1:])]


def _address(array: Doubles | Records | NDArray[np.uint8]) -> int:
    """Return the address of a writable array, in a fifth of the time of `array.ctypes.data`."""
    return address_of(byte_of(array)) if array.size else 0  # type: ignore[arg-type]
