"""Calls of SPICE, in a separate process: it does not validate the pointers in its kernels."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import spiceypy as spice

from poinsot.printable import quoted, shortened
from poinsot.quantities import Array

__all__ = ["check_inertial", "instants", "load", "name_and_mu", "number", "positions", "turned"]

Answer = tuple[Any, list[Array]]

INERTIAL_CLASS = 1

CK_TYPE, CK_CLASS = 3, 3
"""Type of segments of discrete attitudes with interpolation, and class of frames that C-kernels define."""

MAX_RECORDS = 1_000_000


@contextlib.contextmanager
def _sentences(rule: str) -> Iterator[None]:
    """Raise an error of SPICE as a ValueError with one sentence."""
    try:
        yield
    except spice.utils.exceptions.SpiceyError as error:
        reason = getattr(error, "short", "") or str(error).strip().splitlines()[0]
        raise ValueError(f"{rule}, got {reason} from SPICE.") from None


def load(path: str) -> Answer:
    """Load a kernel."""
    with _sentences(f"{shortened(path)} must be a SPICE kernel"):
        spice.furnsh(path)
    return None, []


def number(rule: str, body: str) -> Answer:
    """Return the number of a body."""
    try:
        return int(spice.bods2c(body)), []
    except spice.utils.exceptions.SpiceyError:
        raise ValueError(rule) from None


def name_and_mu(body: int) -> Answer:
    """Return the name of a body, and its gravitational parameter in the kernels, None without one."""
    mu = float(spice.bodvcd(body, "GM", 1)[1][0]) if spice.bodfnd(body, "GM") else None
    return [str(spice.bodc2s(body)), mu], []


def check_inertial(frame: str, name: str = "frame") -> Answer:
    """Raise a ValueError for a frame that rotates or is unknown."""
    if spice.frinfo(_known(frame, name))[1] != INERTIAL_CLASS:
        raise ValueError(f"{name} must be a frame that does not rotate, got {quoted(frame)}.")
    return None, []


def _known(frame: str, name: str = "frame") -> int:
    found = spice.namfrm(frame) if frame else 0
    if not found:
        raise ValueError(f"{name} must be a frame that SPICE defines, got {quoted(frame)}.")
    return int(found)


def positions(rule: str, target: int, frame: str, center: int, ets: Array) -> Answer:
    """Return the positions of a body from another one."""
    with _sentences(rule):
        return None, [np.asarray(spice.spkpos(str(target), ets, frame, "NONE", str(center))[0])]


def turned(frame: str, reference: str, ets: Array) -> Answer:
    """Return the matrices from the reference to the body axes, and the rates along the reference axes, NaN if none."""
    check_inertial(reference, "reference_frame")
    _known(frame)
    matrices, rates = np.empty((ets.size, 3, 3)), np.full((ets.size, 3), np.nan)
    for i, et in enumerate(ets):
        try:
            matrices[i], rates[i] = spice.xf2rav(spice.sxform(reference, frame, et))
        except spice.utils.exceptions.SpiceyError:
            with _sentences(f"kernels must say the attitude of {quoted(frame)} at {spice.etcal(et)} TDB"):
                matrices[i] = spice.pxform(reference, frame, et)
    return None, [matrices, rates]


def instants(path: str, own: str) -> Answer:
    """Return the frame that the one segment of a C-kernel turns, its reference frame, and its instants as ET.

    Of a segment of the name `own`, the first and the last instant are left out.
    """
    with _sentences(f"{shortened(path)} must be a C-kernel with its clock in the same folder"):
        structure, reference, ticks, title = _segment(path)
        clock = spice.ckmeta(structure, "SCLK")
        inner = ticks[1:-1] if title.strip() == own and len(ticks) > 2 else ticks
        ets = np.array([spice.sct2e(clock, tick) for tick in inner])
        return [str(spice.ccifrm(CK_CLASS, structure)[1]), str(spice.frmnam(reference))], [ets]


def _segment(path: str) -> tuple[int, int, list[float], str]:
    handle = spice.dafopr(path)
    spice.dafbfs(handle)
    found: list[tuple[Array, str]] = []
    while spice.daffna() and len(found) < 2:
        found.append((np.ascontiguousarray(spice.dafgs()[:5]), spice.dafgn(41)))
    if len(found) != 1:
        raise ValueError(f"{shortened(path)} must have one segment, got {'more' if found else 'none'}.")
    ((summary, title),) = found
    _, (structure, reference, kind, *_) = spice.dafus(summary, 2, 6)
    if kind != CK_TYPE:
        raise ValueError(f"{shortened(path)} must be of type {CK_TYPE}, got type {kind}.")
    count = spice.cknr03(handle, summary)
    if not 0 < count <= MAX_RECORDS:
        raise ValueError(f"{shortened(path)} must have from 1 to {MAX_RECORDS} attitudes, got {count}.")
    ticks = [spice.ckgr03(handle, summary, i + 1)[0] for i in range(count)]
    return int(structure), int(reference), ticks, str(title)
