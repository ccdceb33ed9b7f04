"""Estimate of time and memory of a run, from a timed sample."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted_times, rounded
from poinsot.kinematics.state import AnyState
from poinsot.propagation.arguments import checked_threads
from poinsot.propagation.propagate import propagate
from poinsot.quantities import Times
from poinsot.records.members import members_of
from poinsot.storage.chunk_plan import Chunking
from poinsot.storage.memory import available_memory
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, checked_times, common_members

__all__ = ["RunEstimate", "estimate_run"]

MIN_SAMPLE_SECONDS = 0.3
"""Shortest sample from which the whole is estimated, seconds."""

FIRST_SAMPLE_MEMBERS = 16
"""Number of members of the first sample for each thread: two batches."""


@dataclass(frozen=True, eq=False, repr=False)
class RunEstimate(Summarized):
    """Estimated time and memory of a run of `propagate`.

    Attributes
    ----------
    system : System
        System of the run.
    members : int
        Number of members; 1 for one body.
    times : array (n,)
        Times of the results.
    bytes : int
        Size of the state variables of the motions in double precision: the default size of a store, and the memory of a
        result in memory.
    memory : int
        Bytes that this process may use. A larger result requires a store, `out=`.
    threads : int
        Number of threads.
    seconds : float
        Duration on this machine with these threads, without compilation.
    compilation : float
        Seconds of compilation in the first run of this kind of system in each process.
    sampled : int
        Number of members in the timed sample.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (1, 2, 3), 1000))
    >>> found = pt.analysis.estimate_run(pt.System(body), start, range(100))
    >>> found.members, found.bytes, found.seconds_on(workers=2) < found.seconds
    (1000, 5600000, True)
    """

    system: System
    members: int
    times: NDArray[np.float64]
    bytes: int
    memory: int
    threads: int
    seconds: float
    compilation: float
    sampled: int

    @checked
    def seconds_on(self, workers: int, threads: int | None = None) -> float:
        """Return the duration in seconds with several workers, each with this processor and number of threads."""
        if workers < 1 or (threads is not None and threads < 1):
            raise ValueError(f"workers and threads must be positive, got {workers} and {threads}.")
        return self.seconds * self.threads / (workers * (self.threads if threads is None else threads))

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        fits = "fits into memory" if 2 * self.bytes < self.memory else "is more than memory has room for: give out="
        more = (f"{n}: {_duration(self.seconds_on(n))}" for n in (2, 10, 100))
        return f"Estimate of a run of {rounded(repr(self.system))}", {
            "members": str(self.members),
            "times": formatted_times(self.times, self.system.units["time"]),
            "result": f"{_size(self.bytes)}, {fits} ({_size(self.memory)})",
            "time here": f"{_duration(self.seconds)} on {self.threads} thread{'s' * (self.threads > 1)}",
            "time on workers like this machine": ", ".join(more) if self.members > 1 else "",
            "compilation": f"{_duration(self.compilation)}, once in each process",
            "sample": f"{self.sampled} members",
        }


@checked
def estimate_run(
    system: System, state: AnyState, times: Times, *, threads: int | None = None, **options: Any
) -> RunEstimate:
    """Estimate time and memory of `propagate` with the same arguments from a timed sample of members and times.

    Parameters
    ----------
    system, state, times, threads
        Same as in `propagate`.
    **options
        Other arguments of `propagate`, except the destination of results.

    Returns
    -------
    RunEstimate
        Estimated seconds, bytes and threads.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (1, 2, 3), 1000))
    >>> pt.analysis.estimate_run(pt.System(body), start, range(100))
    Estimate of a run of System(Body(moments=[1.25, 1.0, 0.75]))
      members: 1000
      times: 100, 0 ... 99
      result: 5.6 MB, fits into memory ...
      ...
    """
    if where := sorted(options.keys() & Chunking.__annotations__):
        raise TypeError(f"{where[0]} must be given to propagate alone, got it for an estimate, which stores nothing.")
    t, members = checked_times(times, system), common_members(system, state)
    count, cores = members[0] if members else 1, checked_threads(threads) if members else 1
    whole = (system, broadcast_members(state, members)) if members else (system, state)
    origin = float(np.mean(state.time))

    def run(some: int, rows: int) -> tuple[float, int]:
        """Return the duration of a sample of members up to some of the times, seconds, and the bytes of a row."""
        who = np.linspace(0, count - 1, some).astype(int)
        given = (members_of(whole[0], who), members_of(whole[1], who)) if members else whole
        began = clock.perf_counter()
        motion = propagate(*given, t[:rows], **options | {"threads": threads, "progress": False})
        return clock.perf_counter() - began, sum(8 * x.shape[-1] for x in motion.phase.values())

    some, rows = min(FIRST_SAMPLE_MEMBERS * cores, count), max(t.size // 64, min(t.size, 2))
    first, _ = run(some, rows)
    seconds, row = run(some, rows)
    compilation = max(first - seconds, 0.0)
    while seconds < MIN_SAMPLE_SECONDS and (some, rows) != (count, t.size):
        some, rows = (some, min(4 * rows, t.size)) if rows < t.size else (min(4 * some, count), rows)
        seconds, row = run(some, rows)
    span, sampled = (float(np.max(np.abs(part - origin))) for part in (t, t[:rows]))
    share = sampled / span if span > 0 and sampled > 0 else rows / t.size
    size = count * t.size * row
    timing = (seconds * count / (some * share), compilation, some)
    return RunEstimate(system, count, t, size, available_memory(), cores, *timing)


def _size(count: float) -> str:
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} TB"


def _duration(seconds: float) -> str:
    for most, unit in ((120, "s"), (7200, "min"), (172_800, "h")):
        if seconds < most:
            return f"{seconds / {'s': 1, 'min': 60, 'h': 3600}[unit]:.2g} {unit}"
    return f"{seconds / 86_400:.3g} days"
