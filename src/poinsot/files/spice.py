"""SPICE kernels: the accepted types, and the process that reads them."""

from __future__ import annotations

import contextlib
import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import optional
from poinsot.files.reader_process import Answer, ReaderProcess
from poinsot.files.untrusted import read_bytes
from poinsot.printable import quoted, shortened
from poinsot.records.calendar import Calendar

__all__ = ["ET", "Kernels", "loaded"]

ET = Calendar("2000-01-01T12:00:00", "TDB")

SUMMARIES = {b"DAF/SPK": (2, 6), b"DAF/CK": (2, 6), b"DAF/PCK": (2, 5)}
"""Double precision and integer numbers in the summary of a segment, by the kind of a binary kernel."""

TEXT = re.compile(rb"KPL/(FK|IK|LSK|PCK|SCLK)\s")

META = b"KPL/MK"
"""The begin of a kernel in text that does nothing but load others."""

INDEX = b"KERNELS_TO_LOAD"
"""The variable by which a kernel in text names others."""

MAX_TEXT_BYTES = 16 * 1024 * 1024
"""Bytes of a kernel in text, which SPICE reads line by line."""

SECONDS_PER_TIME = 2e-4
"""Processor time for each time of a question, seconds: ten times the usual time."""

SECONDS_PER_BYTE = 1e-6
"""Processor time for each byte of a kernel, seconds."""


class Kernels:
    """Kernels that are loaded in a separate process. `size` is the size of their files in bytes."""

    def __init__(self, process: ReaderProcess, paths: list[Path]) -> None:
        self._process = process
        self.size = sum(path.stat().st_size for path in paths)
        for path in paths:
            self.ask("load", str(path))

    def ask(self, function: str, *values: Any, times: NDArray[np.float64] | None = None) -> Answer:
        """Return the answer of a function of `spice_reader`, at times if the function requires them."""
        arrays = [] if times is None else [np.atleast_1d(np.asarray(times, dtype=float))]
        seconds = SECONDS_PER_TIME * sum(array.size for array in arrays) + SECONDS_PER_BYTE * self.size
        return self._process.call(function, *values, arrays=arrays, seconds=seconds)


@contextlib.contextmanager
def loaded(kernels: Sequence[str | Path]) -> Iterator[Kernels]:
    """Load kernels in a process that ends with the context."""
    optional("spiceypy", "SPICE kernels")
    paths = [_checked(Path(kernel)) for kernel in kernels]
    named = ", ".join(map(str, paths[:3])) + (", ..." if len(paths) > 3 else "") or "kernels"
    process = ReaderProcess(
        "poinsot.files.spice_reader", f"{named} must be whole SPICE kernels, got others: ", files=len(paths) + 1
    )
    with contextlib.closing(process):
        yield Kernels(process, paths)


def _checked(path: Path) -> Path:
    """Return the path of a kernel: an SPK, CK or PCK, or a text of frames, clocks, constants or leap seconds."""
    if not path.is_file():
        raise FileNotFoundError(f"No such file: {shortened(path)}")
    with path.open("rb") as stream:
        head = stream.read(96)
    if head.startswith(b"DAF/"):
        kind, order = head[:8].rstrip(), "<" if head[88:96] == b"LTL-IEEE" else ">"
        sizes = struct.unpack(f"{order}2i", head[8:16]) if len(head) == 96 else None
        if kind not in SUMMARIES or sizes != SUMMARIES[kind]:
            given = kind.decode("ascii", "replace")
            raise ValueError(
                f"{shortened(path)} must be a whole SPICE kernel of the kind {quoted(given)}, got a broken first "
                "record."
            )
    elif head.startswith(META):
        raise ValueError(
            f"{shortened(path)} must be a kernel that loads no others, got a meta-kernel. Name the kernels "
            f"that it loads."
        )
    elif not TEXT.match(head):
        raise ValueError(
            f"{shortened(path)} must be a SPICE kernel: SPK, CK, PCK, or a text that begins with KPL/ and FK, IK, "
            "LSK, PCK or "
            f"SCLK, got {quoted(head)}."
        )
    elif INDEX in read_bytes(path, MAX_TEXT_BYTES).upper():
        raise ValueError(
            f"{shortened(path)} must be a kernel that loads no others, got one that does. Name all of them."
        )
    return path
