"""Measure the way of a system through calls of the package: `python -m tools.walk`.

A profile hook records the calls of functions of poinsot whose arguments contain the system or the run. Consecutive
calls in one module are one stay, and a return is a stay in a module that was visited before. Only the calling thread is
recorded. `python -m tools.walk CASE` prints the modules of the stays of the first and the second call of one case.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FrameType, MemberDescriptorType
from typing import Any

import numpy as np

import poinsot as pt

__all__ = ["CASES", "walk"]

CLASSES = {"System", "Dynamics", "Problem", "Run"}
"""Names of the classes of the package that are the system or the run. An instance of a subclass counts, too."""

MAX_DEPTH = 4
"""Largest number of attributes and elements between an argument and the system or the run."""

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)))
START = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 3.0))
STARTS = BODY.state((1, 0, 0, 0), omega_body=np.linspace((0.1, 0.2, 3.0), (0.2, 0.3, 3.1), 8))
TIMES = np.linspace(1.0, 10.0, 10)


def walk(call: Callable[[], object]) -> list[str]:
    """Return the names of the modules of the stays during a call, in order; neighbours differ."""
    stays = [""]
    first_instructions: dict[object, int] = {}

    def note(frame: FrameType, kind: str, _: object) -> None:
        module = frame.f_globals.get("__name__", "")
        if kind != "call" or not _is_own(module) or module == stays[-1]:
            return
        if first_instructions.setdefault(frame.f_code, frame.f_lasti) != frame.f_lasti:  # a generator resumes
            return
        if _reaches_system(_arguments(frame)):
            stays.append(module)

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return stays[1:]


def _is_own(module: str) -> bool:
    return module.partition(".")[0] == "poinsot"


def _arguments(frame: FrameType) -> list[Any]:
    code, given = frame.f_code, frame.f_locals
    packed = sum(bool(code.co_flags & flag) for flag in (inspect.CO_VARARGS, inspect.CO_VARKEYWORDS))
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount + packed]
    return [given[name] for name in names if name in given]


def _reaches_system(values: Iterable[Any]) -> bool:
    """Return whether the system or the run is among objects, their attributes or their elements."""
    seen: set[int] = set()
    for _ in range(MAX_DEPTH + 1):
        fresh = {id(value): value for value in values if id(value) not in seen}
        if any(_is_sought(value.__class__) for value in fresh.values()):
            return True
        seen |= fresh.keys()
        values = [part for value in fresh.values() for part in _parts(value)]
    return False


@functools.cache
def _is_sought(kind: type) -> bool:
    return any(_is_own(base.__module__) and base.__name__ in CLASSES for base in kind.__mro__)


def _parts(value: Any) -> Iterator[Any]:
    """Yield the elements of a collection, and the stored attributes of an object of the package."""
    if isinstance(value, tuple | list | dict):
        yield from value.values() if isinstance(value, dict) else value
    if _is_own(value.__class__.__module__):
        yield from getattr(value, "__dict__", {}).values()
        for slot in _slots(value.__class__):
            with contextlib.suppress(AttributeError):
                yield slot.__get__(value)


@functools.cache
def _slots(kind: type) -> list[MemberDescriptorType]:
    return [slot for base in kind.__mro__ for slot in vars(base).values() if isinstance(slot, MemberDescriptorType)]


def _propagate_to_store() -> None:
    with tempfile.TemporaryDirectory() as folder:
        pt.propagate(TOP, STARTS, TIMES, threads=1, out=Path(folder) / "ensemble.zarr")


CASES: dict[str, Callable[[], object]] = {
    "propagate": lambda: pt.propagate(TOP, START, TIMES),
    "event": lambda: pt.propagate(TOP, START, TIMES, events=[pt.events.RateCrossing((1, 0, 0))]),
    "ensemble": lambda: pt.propagate(TOP, STARTS, TIMES, threads=1),
    "out": _propagate_to_store,
    "chaos_indicators": lambda: pt.analysis.chaos_indicators(TOP, START, TIMES),
}
"""Calls for a heavy top: one body, one event, an ensemble of 8 members, this ensemble in a store, tangent vectors."""


def _rows() -> Iterator[tuple[object, ...]]:
    """Yield case, call, stays, modules and returns. A new process without stored object code runs each case."""
    for case in CASES:
        with tempfile.TemporaryDirectory() as folder:
            program, environment = [sys.executable, "-m", "tools.walk", case], os.environ | {"POINSOT_CACHE": folder}
            done = subprocess.run(program, env=environment, check=True, capture_output=True, text=True)  # noqa: S603
        for call, stays in zip(("first", "second"), json.loads(done.stdout), strict=True):
            yield case, call, len(stays), len({*stays}), len(stays) - len({*stays})


if __name__ == "__main__":
    if sys.argv[1:]:
        print(json.dumps([walk(CASES[sys.argv[1]]) for _ in range(2)]))
    else:
        for row in [("case", "call", "stays", "modules", "returns"), *_rows()]:
            print("{:18}{:8}{:>7}{:>9}{:>9}".format(*row))
