"""A Taylor integrator of a decomposition as machine code that fits the instruction cache: a loop over the orders.

The whole run is compiled: steps, rows at given times, and members that take one another's lanes. Both layouts, in
vectors of any length, give the same bits. A `Run` has its own memory and releases the interpreter, so that threads may
each have one.
"""

from __future__ import annotations

import ctypes
import functools
import math
import platform
import struct
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.kernel_program import QUEUE, KernelProgram, Status
from poinsot.taylor.layouts import Layout
from poinsot.taylor.llvm_functions import LIBRARY
from poinsot.taylor.llvm_ir import host_features, machine_code

__all__ = ["CACHED", "ROUNDING", "Code", "Output", "Queue", "Run", "Status", "available", "compiled", "order_of"]

ROUNDING = {"double": 2.0**-52, "quadruple": 2.0**-104}
"""Distance from 1 to the next number, by precision: the smallest tolerance."""

CACHED = 128
"""Kernels that are kept."""

BUDGET, SMALL_SYSTEM = 20_000, 25
"""Steps between checks for Ctrl-C, hundredths of a second: in a system of so many inner sums, in larger ones fewer."""

FOREVER = 2**62

LONGEST_STEP = 2.0**46
"""Longest step in double precision. Within it no Taylor coefficient underflows unnoticed."""

ALIGNMENT = 64

NOTES = 1024
"""Notes of events before they are put aside."""

STEPS_KEPT, BLOCK_BYTES = 256, 16_000_000
"""Room for steps at first, and the most that a block of them takes."""

address_of, byte_of = ctypes.addressof, ctypes.c_char.from_buffer

Doubles = NDArray[np.float64]
RECORD = struct.Struct(f"{QUEUE.itemsize // 8}q")


class Code:
    """A compiled kernel.

    Attributes
    ----------
    order, lanes : int
    wide : bool
        Whether numbers are double-double.
    variables, parameters : int
        How many a member has.
    conditions : tuple of int
        The parameters that hold them.
    blank : bytes
        A task without numbers of its own.
    places : slice
        Where a task has those of an `Output`, words of 8 bytes.
    """

    def __init__(self, kernel: KernelProgram) -> None:
        self.order, self.lanes, self.wide = kernel.order, kernel.lanes, kernel.wide
        self.variables, self.parameters = kernel.variables, kernel.parameters
        self.work, self.task, self.step, self.note = kernel.work, kernel.task, kernel.step, kernel.watch.note
        self.events, self.conditions = kernel.watch.events, kernel.watch.conditions
        blank = np.zeros(1, self.task)
        blank["limit"], blank["pause"], blank["branches"], blank["unit"] = LONGEST_STEP, FOREVER, np.nan, 1.0
        fields: Any = self.task.fields
        first = fields["count"][1] // 8
        self.blank, self.places = blank.tobytes(), slice(first, first + 4)
        self.idle: list[Run] = []
        exact = [Fraction(1, n) for n in range(1, kernel.order + 1)]
        self.reciprocals_of_orders = np.array([0.0, *map(float, exact)])
        self.reciprocals_below = np.array([0.0, *(float(x - Fraction(float(x))) for x in exact)])
        self.budget = max(BUDGET * SMALL_SYSTEM // max(kernel.schedule.sums, SMALL_SYSTEM), 1)
        self.load(str(kernel.module))

    def idle_run(self) -> Run:
        """Return the memory of a run that is over, or new one."""
        try:
            return self.idle.pop()
        except IndexError:  # `if self.idle` would be wrong where threads share the list
            return Run(self)

    def keep(self, run: Run) -> None:
        """Take the memory of a run that is over, without its rows."""
        run.forget()
        self.idle.append(run)

    def load(self, text: str) -> None:
        """Compile LLVM's representation."""
        self._engine = machine_code(text, LIBRARY)
        address = self._engine.get_function_address("advance")
        self.advance = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64)(address)


class Output(NamedTuple):
    """Where rows go, and at what times.

    Parameters
    ----------
    times : array (m,)
    rows : array (members, m, variables)
        Both C-contiguous and writable.
    tasks : sequence (n, 4)
        Of each task: how many rows it writes, at least one; whether at later ones of the times (1) or at earlier ones
        (-1); the first of these; and where the row of that is among all rows.
    ends : sequence (n,)
        Of each task the last time.
    """

    times: Doubles
    rows: Doubles
    tasks: Any
    ends: Any

    @classmethod
    def of(cls, times: Doubles, rows: Doubles, members: Any, first: Any, counts: Any, stride: Any) -> Output:
        """Return that of tasks that write the rows of members, in arrays (n,)."""
        tasks = np.stack([counts, stride, first, members * times.size + first], axis=-1)
        return cls(times, rows, tasks, times[first + stride * (counts - 1)])


class Queue:
    """Tasks that wait for lanes: members that start from some states, each in one direction.

    The runs of several threads may share one.

    Parameters
    ----------
    code : Code
    states : array (n, variables) or (1, variables)
    times : array (n,) or (1,)
        Of the start.
    parameters : array (n, parameters) or (1, parameters)
    output : Output

    Attributes
    ----------
    tasks : structured array (n,)
        What is to do, and later what has been done. Before a run, and where a task has left its lane, one may change
        `state`, `below` (what was rounded off it), `parameters`, `end`, `limit` (the longest step), `pause` (the number
        of steps after which the task leaves its lane) and `push` (momenta that forces give a body at rest). Results are
        `state`, `time` (two parts), `status`, `steps`, `index` (how many rows are written) and `bits` (of the scale of
        momenta).
    """

    def __init__(self, code: Code, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> None:
        count, size = len(output.tasks), len(code.blank)
        self._first = first = -(-(QUEUE.itemsize + 8 * count) // size) * size  # what waits lies in front: one address
        self._blank, self._memory, self.wide = code.blank, bytearray(first + count * size), code.wide
        tasks = self.tasks = np.ndarray(count, code.task, self._memory, first)
        self._states, self._parameters, self._times = tasks["state"], tasks["parameters"], tasks["time"][:, 0]
        self._ways, self._ends, self._spans = tasks["way"], tasks["end"], tasks["span"]
        self._places = tasks.view(np.int64).reshape(count, size // 8)[:, code.places]
        self._record = np.ndarray(QUEUE.itemsize // 8, np.int64, self._memory)
        self._numbers = np.ndarray(count, np.int64, self._memory, QUEUE.itemsize)
        self._numbers[:] = np.arange(count)
        self.address = address_of(byte_of(self._memory))
        self.fill(states, times, parameters, output)

    def fill(self, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> None:
        """Put other tasks, as many, in the place of those that are done."""
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
        """Forget the tasks that wait."""
        self._waiting = self._waiting[:0]
        self._record[1] = 0

    def put(self, tasks: NDArray[np.int_]) -> None:
        """Add tasks that are in no lane and do not wait, by their numbers; no run may be advancing."""
        self._waiting = np.concatenate([self._waiting[self._record[0] :], tasks])
        self._record[:3] = 0, self._waiting.size, self._waiting.ctypes.data
        self.tasks["status"][tasks] = Status.UNDER_WAY

    def take(self) -> NDArray[np.int64]:
        """Return the numbers of all tasks that wait, and let none wait any more."""
        waiting = self._waiting[self._record[0] :]
        self._record[0] = self._record[1]
        return waiting


class Run:
    """The memory of one thread that works on queues of tasks.

    Parameters
    ----------
    code : Code
    keeps_steps : bool
        Whether `kept` has the coefficients of all steps; for one lane.
    """

    def __init__(self, code: Code, keeps_steps: bool = False) -> None:
        memory = np.zeros(code.work.itemsize + ALIGNMENT, np.uint8)
        start = -_address(memory) % ALIGNMENT
        memory = memory[start : start + code.work.itemsize]
        work = memory.view(code.work)
        work["reciprocals_of_orders"] = code.reciprocals_of_orders
        work["reciprocals_below"] = code.reciprocals_below
        self._memory, self._code, self._address = work, code, _address(memory)
        self._active, self._pause, self._times = work["active"][0], work["pause"][0], work["time"][0, 0]
        self._numbers = memory.view(np.int64)[-4:]  # queue, kept, kept_most, kept_count
        self._noted, self._notes = memory.view(np.int64)[-7:-4], list[NDArray[Any]]()  # notes, notes_most, noted
        if code.events:
            self._block = np.empty(NOTES + code.lanes, code.note)
            self._noted[:] = _address(self._block), NOTES, 0
        self._numbers[2], self._blocks = FOREVER, list[NDArray[Any]]()
        self._queue: Any = None
        if keeps_steps:
            self._keep(STEPS_KEPT)

    def queue(self, *given: Any) -> Queue:
        """Return a queue, in the memory of the last one where that has as many tasks."""
        queue: Queue = self._queue
        if queue is None or queue.tasks.size != len(given[-1].tasks):
            return Queue(self._code, *given)
        queue.fill(*given)
        return queue

    def start(self, queue: Queue) -> None:
        """Turn to a queue, and forget what was before."""
        self._queue, self._numbers[0], self._numbers[3] = queue, queue.address, 0
        self._blocks, self._notes = self._blocks[-1:], []
        self._active[:] = self._noted[2] = 0

    def happened(self) -> NDArray[Any]:
        """Return what was noted of events since this was asked last, that of each task in its order."""
        self._put_aside()
        blocks, self._notes = self._notes, []
        return np.concatenate(blocks) if blocks else np.empty(0, self._code.note)

    def _put_aside(self) -> None:
        if self._noted[2]:
            self._notes.append(self._block[: self._noted[2]].copy())
            self._noted[2] = 0

    def forget(self) -> None:
        """Let go of times and rows."""
        del self._queue.output

    def _keep(self, count: int) -> None:
        block = np.empty(count, self._code.step)
        self._blocks.append(block)
        self._numbers[1:] = _address(block), count, 0

    def advance(self, budget: int | None = None) -> bool:
        """Take so many steps at most in each lane; return whether something is left to do."""
        left = bool(self._code.advance(self._address, budget or self._code.budget))
        if self._noted[2] > self._noted[1]:
            self._put_aside()
        if left and self._numbers[3] == self._numbers[2]:
            self._keep(min(2 * self._blocks[-1].size, max(STEPS_KEPT, BLOCK_BYTES // self._code.step.itemsize)))
        return left

    def note(self) -> NDArray[np.int_]:
        """Write how far the tasks in lanes have come into them, and return their numbers."""
        work, tasks = self._memory[0], self._queue.tasks
        lanes = np.flatnonzero(work["active"])
        numbers: NDArray[np.int_] = work["task"][lanes]
        for name in ("steps", "index"):
            tasks[name][numbers] = work[name][lanes]
        tasks["time"][numbers] = work["time"][:, lanes].T
        return numbers

    def give_up(self, numbers: NDArray[np.int_]) -> None:
        """Let tasks in lanes leave them after their next step."""
        self._pause[np.isin(self._memory[0]["task"], numbers) & (self._active != 0)] = 0

    def finish(self) -> None:
        """Let all tasks leave their lanes, after one more step if they are not done, and take no others."""
        if 1 in self._active.tolist():  # of one lane five times as fast as `any`
            self._queue.close()
            self._pause[:] = 0
            self.advance(1)

    @property
    def times(self) -> Doubles:
        """The times that the lanes have reached."""
        reached: Doubles = self._times[self._active != 0]
        return reached

    @property
    def kept(self) -> list[NDArray[Any]]:
        """Blocks of steps: task, start (two parts), length and coefficients (order + 1, variables) of each."""
        return [*self._blocks[:-1], *(block[: self._numbers[3]] for block in self._blocks[-1:])]


def _address(array: Any) -> int:
    """Return where numbers that may be changed are, in a fifth of the time of `array.ctypes.data`."""
    return address_of(byte_of(array)) if array.size else 0


@functools.cache
def available() -> bool:
    """Return whether kernels run here: on processors that multiply and add in one instruction."""
    return platform.machine().lower() in ("arm64", "aarch64") or host_features().get("fma", False)


@functools.lru_cache(CACHED)
def order_of(tolerance: float, wide: bool = False) -> int:
    """Return the order of the Taylor polynomials for a tolerance (Jorba and Zou 2005), in quadruple precision 4 more.

    At order 38, of the smallest tolerance there, truncation errors of a free body are three times its rounding errors.
    """
    return max(2, math.ceil(1.0 - 0.5 * math.log(tolerance))) + 4 * wide


@functools.lru_cache(CACHED)
def compiled(
    decomposition: Decomposition, order: int, lanes: int, layout: Layout = "batch", wide: bool = False
) -> Code:
    """Return the kernel of a decomposition with polynomials of an order; lanes, of the layout "batch", 1, 2, 4 or 8."""
    return Code(KernelProgram(decomposition, order, lanes, layout, wide))
