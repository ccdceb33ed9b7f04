"""The looped kernel on a GPU of NVIDIA: one body per thread, in launches of some steps each.

It is the program of the processor's kernel for one lane, in CUDA C, with the same tasks and the same rows. Between
launches tasks wait in the memory of the device, as those that pause do; the threads of a launch take them in turn.
"""

from __future__ import annotations

import functools
import time as clock
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from poinsot.cuda.source import translated
from poinsot.errors import optional
from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.kernels import MAX_KERNELS, KernelProgram
from poinsot.taylor.llvm_ir import offset_of
from poinsot.taylor.queue import FOREVER, Doubles, Integers, Kernel, Output, Queue
from poinsot.taylor.tasks import Status

__all__ = ["CudaCode", "CudaWorker", "check_device", "compiled", "most_members"]

THREADS_PER_BLOCK = 64
"""Number of threads of a block."""

FIRST_LAUNCH_STEPS = 64
"""Number of steps of a task in the first launch."""

MIN_LAUNCH_SECONDS, MAX_LAUNCH_SECONDS = 0.1, 0.4
"""Seconds of a launch below which the next launch takes twice as many steps, and above which half as many.

Ctrl-C takes effect between launches, and drivers of devices with a screen stop launches that take seconds.
"""

MEMORY_SHARE = 0.5
"""Part of the free memory of the device for tasks and rows. The rest contains the coefficients of the threads."""

MAX_BYTES = 2**30
"""Largest number of bytes of tasks and rows at a time, in the memory of the device and of the computer."""

OPTIONS = ("--std=c++17", "--fmad=false")
"""A product and a sum are rounded one by one, as on the processor; where they are not, there is an fma."""

ENTRY = """
extern "C" __global__ void __launch_bounds__({threads}) propagate(char *queue, long long count) {{
if (blockIdx.x * (long long){threads} + threadIdx.x >= count) return;
alignas(16) char work[{size}];
*(char **)(work + {queue}) = queue;
*(long long *)(work + {stored_steps}) = 0;
*(long long *)(work + {stored_count}) = 0;
*(long long *)(work + {stored_limit}) = 1;
*(long long *)(work + {active}) = 0;
for (int n = 1; n <= {order}; n++) {{
  const double high = 1.0 / n;
  *(double *)(work + {reciprocals_of_orders} + 8 * n) = high;
  *(double *)(work + {reciprocals_below} + 8 * n) = fma(-(double)n, high, 1.0) / n;
}}
advance(work, {budget}LL);
}}
"""


class CudaCode(Kernel):
    """A kernel in CUDA C, its `source`."""

    def __init__(self, program: KernelProgram) -> None:
        super().__init__(program.context)
        work = self.context.work
        places = {name: offset_of(work, name) for name in work.names or ()}
        places |= {"size": work.itemsize, "order": self.order, "threads": THREADS_PER_BLOCK, "budget": FOREVER}
        self.source = translated(str(program.module)) + ENTRY.format_map(places)

    @functools.cached_property
    def _propagate(self) -> Callable[..., None]:
        """The function of the device, compiled when it is first launched."""
        module = optional("cupy", "device='cuda'", "cuda").RawModule(code=self.source, options=OPTIONS)
        function: Callable[..., None] = module.get_function("propagate")
        return function

    def launch(self, queue: Integers, count: int) -> None:
        """Start a number of threads that take tasks of a queue."""
        self._propagate((-(-count // THREADS_PER_BLOCK),), (THREADS_PER_BLOCK,), (queue, np.int64(count)))


@functools.lru_cache(MAX_KERNELS)
def compiled(decomposition: Decomposition, order: int) -> CudaCode:
    """Return the kernel of a decomposition."""
    return CudaCode(KernelProgram(decomposition, order, 1, "batch"))


class CudaWorker:
    """The memory of a device that works on queues of tasks."""

    _tasks: Integers
    _times: Doubles
    _rows: Doubles

    def __init__(self, code: CudaCode) -> None:
        self._cupy, self._code, self._uploaded = optional("cupy", "device='cuda'", "cuda"), code, False

    def queue(self, states: Doubles, times: Doubles, parameters: Doubles, output: Output) -> Queue:
        """Return a queue."""
        return Queue(self._code, states, times, parameters, output)

    def start(self, queue: Queue) -> None:
        """Begin to work on a queue, and forget an earlier queue."""
        self._queue, self._budget, self._uploaded = queue, FIRST_LAUNCH_STEPS, False

    def advance(self) -> bool:
        """Launch the kernel once; return True if tasks are left."""
        if not self._uploaded:
            self._upload()
        if self._going.size:
            began = clock.perf_counter()
            self._launch()
            taken = clock.perf_counter() - began
            if taken < MIN_LAUNCH_SECONDS:
                self._budget *= 2
            elif taken > MAX_LAUNCH_SECONDS:
                self._budget = max(self._budget // 2, 1)
        return bool(self._going.size)

    def _upload(self) -> None:
        """Copy the tasks to the device, with their times and rows."""
        upload, output, tasks = self._cupy.asarray, self._queue.output, self._queue.tasks
        self._going = self._queue.take()
        self._times, self._rows = upload(output.times), upload(output.rows)
        self._tasks, self._uploaded = upload(tasks.view(np.int64).reshape(tasks.size, -1)), True

    def _field(self, name: str) -> Integers:
        """Return the bits of a field of all tasks on the device, shape (n,) or (n, numbers)."""
        kind, first = self._code.context.task[name], offset_of(self._code.context.task, name) // 8
        return self._tasks[:, first : first + kind.shape[0]] if kind.shape else self._tasks[:, first]

    def _launch(self) -> None:
        """Let tasks that are under way take steps, and note the tasks that are not done."""
        upload, download, pause = self._cupy.asarray, self._cupy.asnumpy, self._queue.tasks["pause"]
        self._field("pause")[:] = upload(np.minimum(pause, download(self._field("steps")) + self._budget))
        going = upload(self._going)
        self._field("status")[going] = int(Status.UNDER_WAY)
        arrays = going, self._tasks, self._times, self._rows
        addresses = [array.data.ptr for array in arrays]  # type: ignore[union-attr]
        queue = upload(np.array([0, going.size, *addresses]))
        self._code.launch(queue, going.size)
        status, steps = download(self._field("status")), download(self._field("steps"))
        self._going = self._going[((status == Status.PAUSED) & (steps < pause))[self._going]]

    def note(self) -> Integers:
        """Copy the progress of the tasks from the device, and return the numbers of the tasks under way."""
        tasks, download = self._queue.tasks, self._cupy.asnumpy
        for name in ("status", "steps", "index"):
            tasks[name] = download(self._field(name))
        tasks["time"] = download(self._field("time")).view(float)
        return self._going

    def give_up(self, numbers: Integers) -> None:
        """Let tasks take no more steps."""
        self._field("status")[self._cupy.asarray(numbers)] = int(Status.GIVEN_UP)
        self._going = np.setdiff1d(self._going, numbers)

    def new_records(self) -> NDArray[np.void]:
        """Return the records of events: none, since kernels on a GPU have no events."""
        return np.empty(0, self._code.context.record)

    def finish(self) -> None:
        """Copy tasks and rows from the device, finished or not."""
        tasks = self._queue.tasks
        pause = tasks["pause"].copy()
        tasks.view(np.int64).reshape(tasks.size, -1)[:] = self._cupy.asnumpy(self._tasks)
        tasks["pause"] = pause
        self._queue.output.rows[:] = self._cupy.asnumpy(self._rows)
        del self._tasks, self._times, self._rows
        self._uploaded = False


def check_device() -> None:
    """Raise an error on a computer without cupy or without a device."""
    cupy = optional("cupy", "device='cuda'", "cuda")
    try:
        count = cupy.cuda.runtime.getDeviceCount()
    except cupy.cuda.runtime.CUDARuntimeError:  # there is no driver, or one that is too old
        count = 0
    if not count:
        raise RuntimeError(
            "device='cuda' must have a GPU of NVIDIA with its driver, got none. Leave device out to use the processor."
        )


def most_members(code: CudaCode, times: int) -> int:
    """Return the number of members that fit into the memory of the device, with two tasks and rows at times."""
    free, _ = optional("cupy", "device='cuda'", "cuda").cuda.runtime.memGetInfo()
    each = 8 * times * code.variables + 2 * (code.context.task.itemsize + 8)
    return max(int(min(MEMORY_SHARE * free, MAX_BYTES)) // each, 1)
