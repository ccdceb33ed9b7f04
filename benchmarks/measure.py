"""Times that can be compared: pinned, interleaved, and counted only for results that are right."""

import os
import re
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

ALLOWED = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []


def pin(cores):
    """Keep this process, and the threads that it starts from now on, on the first cores it was given."""
    if ALLOWED:
        os.sched_setaffinity(0, ALLOWED[:cores])


def in_a_line(problem):
    """Return an exception as one line of a report, without the folders of this machine."""
    first = next(iter(str(problem).splitlines()), "")
    return type(problem).__name__ + ": " + re.sub(r"/\S*/", "", first)


def computed_by(run):
    """Return how a run was computed, as one line: everything that its record has but counts, times and versions."""
    left_out = ("steps", "wall_time", "versions")
    facts = {f.name: getattr(run, f.name) for f in fields(run) if f.name not in left_out}
    return ", ".join(
        f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}" for name, value in facts.items()
    )


@dataclass
class Contender:
    """One way to solve one problem.

    `prepare` returns what is timed; it runs before every repeat and is not timed. `judge` returns the error of
    a result; a result beyond `limit` is not counted. On one core the time is that of the processor, which other work
    on the machine interrupts but does not lengthen; on several it is that of the clock.
    """

    prepare: Callable[[], Callable[[], Any]]
    judge: Callable[[Any], float]
    limit: float = 1e-2
    cores: int = 1
    seconds: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    busy: list[float] = field(default_factory=list)  # processor seconds in a second
    trouble: str = ""

    def once(self):
        """Run once; keep the time if the result is right."""
        pin(self.cores)
        run = self.prepare()
        began, used = time.perf_counter(), time.process_time()
        result = run()
        took, used = time.perf_counter() - began, time.process_time() - used
        found = self.judge(result)
        if found <= self.limit:
            self.seconds.append(used if self.cores == 1 else took)
            self.errors.append(found)
            self.busy.append(used / took)
        else:
            self.trouble = f"error {found:.1e} rad: not counted"

    def outcome(self):
        """Return median, error and number of repeats, or why there is none."""
        if not self.seconds:
            return {"trouble": self.trouble}
        return {
            "seconds": statistics.median(self.seconds),
            "error": max(self.errors),
            "busy": statistics.median(self.busy),
            "repeats": len(self.seconds),
        }


def interleaved(contenders, repeats, budget):
    """Run all contenders in turn, round after round, and return their outcomes by name.

    The first round warms up and compiles and does not count; a contender that has used its budget of seconds
    (but has run once) leaves the later rounds to the others.
    """
    for contender in contenders.values():
        _try(contender)
        contender.seconds.clear()
        contender.errors.clear()
        contender.busy.clear()
    for turn in range(repeats):
        for contender in contenders.values():
            if not contender.trouble and (turn == 0 or sum(contender.seconds) < budget):
                _try(contender)
    return {name: contender.outcome() for name, contender in contenders.items()}


def _try(contender):
    try:
        contender.once()
    except Exception as problem:  # a peer that fails is a line of the report
        contender.trouble = in_a_line(problem)
