"""SPICE kernels: loaded and unloaded again, with errors in one sentence."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from poinsot.mechanics.calendar import Calendar

__all__ = ["ET", "check_inertial", "loaded", "sentences"]

ET = Calendar("2000-01-01T12:00:00", "TDB")

SUMMARIES = {"DAF/SPK": (2, 6), "DAF/CK": (2, 6), "DAF/PCK": (2, 5)}
"""Double precision and integer numbers in the summary of a segment."""

INERTIAL_CLASS = 1

MOST_OF_TEXT = 16 * 1024 * 1024
"""Bytes of a kernel in text, which SPICE reads line by line."""


@contextlib.contextmanager
def loaded(spice: Any, kernels: Sequence[str | Path]) -> Iterator[None]:
    """Load kernels, and unload them in the end."""
    with contextlib.ExitStack() as stack:
        for path in map(Path, kernels):
            if not path.is_file():
                raise FileNotFoundError(f"kernels must be files, but there is no {path}.")
            _check_shape(path)
            with sentences(spice, f"{path} must be a SPICE kernel"):
                stack.callback(spice.unload, str(path))
                spice.furnsh(str(path))
        yield


def _check_shape(path: Path) -> None:
    """Refuse a binary kernel whose summaries are of a size that its kind does not have, at which SPICE may crash."""
    with path.open("rb") as stream:
        head = stream.read(96)
    if not head.startswith((b"DAF/", b"DAS/", b"NAIF/DAF")) and (b"\0" in head or path.stat().st_size > MOST_OF_TEXT):
        raise ValueError(
            f"{path} must be a SPICE kernel, binary or text of at most {MOST_OF_TEXT} bytes, but it is none."
        )
    if not head.startswith(b"DAF/"):
        return
    kind, order = head[:8].decode("ascii", "replace").strip(), "<" if head[88:96] == b"LTL-IEEE" else ">"
    sizes = struct.unpack(f"{order}2i", head[8:16]) if len(head) == 96 else None
    if sizes is None or (kind in SUMMARIES and sizes != SUMMARIES[kind]):
        raise ValueError(f"{path} must be a whole SPICE kernel of the kind {kind!r}, but its first record is broken.")


@contextlib.contextmanager
def sentences(spice: Any, rule: str) -> Iterator[None]:
    """Say an error of SPICE as one sentence."""
    try:
        yield
    except spice.utils.exceptions.SpiceyError as error:
        reason = getattr(error, "short", "") or str(error).strip().splitlines()[0]
        raise ValueError(f"{rule}, but SPICE says {reason}.") from None


def check_inertial(spice: Any, frame: str) -> None:
    """Refuse a frame that rotates or is unknown."""
    number = spice.namfrm(frame) if isinstance(frame, str) and frame else 0
    if not number:
        raise ValueError(f"frame must be one that SPICE knows, but {frame!r} came.")
    if spice.frinfo(number)[1] != INERTIAL_CLASS:
        raise ValueError(f"frame must be one that does not rotate, but {frame!r} came.")
