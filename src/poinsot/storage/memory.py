"""Memory that this process may still use."""

from __future__ import annotations

import contextlib
import ctypes
import mmap
import os
import sys
from collections.abc import Iterator
from pathlib import Path

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

__all__ = ["available_memory", "refuse_larger_than_memory"]

PROC, CGROUPS = Path("/proc"), Path("/sys/fs/cgroup")

ASSUMED_BYTES = 2 * 1024**3
"""Available memory in bytes on a system that does not report it."""

MIN_CHECKED_BYTES = 128 * 1024**2
"""Smallest amount of memory for which the available memory is queried: a query takes a millisecond."""


def available_memory() -> int:
    """Return the number of bytes that machine, cgroups and limits allow this process to use in addition."""
    return max(min([*_of_machine(), *_of_cgroups(), *_of_limits()], default=ASSUMED_BYTES), 0)


def refuse_larger_than_memory(members: int, times: int, numbers: int) -> None:
    """Raise a ValueError, before anything is computed, if motions of so many numbers at a time have no room."""
    needed = 8 * members * times * numbers
    if needed > MIN_CHECKED_BYTES and needed > (free := available_memory()):
        raise ValueError(
            f"motions must fit into the memory that this process may use, {free / 1e9:.3g} GB, got {members} members "
            f"at {times} times, which take {needed / 1e9:.3g} GB. Write them to a store on disk: out='run.zarr'."
        )


def _of_machine() -> Iterator[int]:
    for line in _text(PROC / "meminfo").splitlines():
        if line.startswith("MemAvailable:"):
            yield 1024 * int(line.split()[1])
    if sys.platform == "darwin":  # which lends the memory of other programs to files, and does not report how much
        yield os.sysconf("SC_PHYS_PAGES") * mmap.PAGESIZE // 2
    if sys.platform == "win32":
        status = _MemoryStatus(ctypes.sizeof(_MemoryStatus))
        if ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):
            yield int(status.available)


class _MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX of Windows."""

    _fields_ = (
        *(("length", ctypes.c_uint32), ("load", ctypes.c_uint32)),
        *((name, ctypes.c_uint64) for name in ("physical", "available", "page_total", "page_available")),
        *((name, ctypes.c_uint64) for name in ("virtual", "virtual_available", "extended")),
    )


def _of_limits() -> Iterator[int]:
    if resource is None:
        return
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    sizes = _text(PROC / "self" / "statm").split()
    if most != resource.RLIM_INFINITY and sizes:
        yield most - int(sizes[0]) * mmap.PAGESIZE


def _of_cgroups() -> Iterator[int]:
    """Yield the memory that each cgroup of the process leaves, for versions 1 and 2 of cgroups."""
    for line in _text(PROC / "self" / "cgroup").splitlines():
        _, controllers, place = line.split(":", 2)
        if not controllers:
            yield from _left(CGROUPS, place, "memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
            yield from _left(CGROUPS / "memory", place, *names)


def _left(root: Path, place: str, limit: str, usage: str, cache: str) -> Iterator[int]:
    own = root / place.strip("/")
    for folder in (own, *own.parents):
        with contextlib.suppress(ValueError):  # "max": no limit
            most = int(_text(folder / limit))
            stat = dict(line.split() for line in _text(folder / "memory.stat").splitlines())
            yield most - int(_text(folder / usage)) + int(stat.get(cache, 0))
        if folder == root:
            return


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""
