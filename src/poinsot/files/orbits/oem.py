"""Orbits from CCSDS Orbit Ephemeris Messages, in KVN or XML."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.errors import level_of_user
from poinsot.files import ccsds
from poinsot.files.keys import Keys
from poinsot.files.rows import TextRows
from poinsot.files.untrusted import read_text
from poinsot.orbits.attractors import attractor_mu, attractor_radius
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.printable import quoted, shortened
from poinsot.records.calendar import Calendar, checked_calendar

__all__ = ["read_oem"]

NEEDED = ("CENTER_NAME", "REF_FRAME", "TIME_SYSTEM")

METADATA = Keys(
    frozenset((*NEEDED, "OBJECT_ID", "STOP_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "REF_FRAME_EPOCH")),
    frozenset(("OBJECT_NAME", "START_TIME", "INTERPOLATION", "INTERPOLATION_DEGREE")),
    repeated=("COMMENT",),
)

ACCELERATION = ("X_DDOT", "Y_DDOT", "Z_DDOT")

MAX_DISTANCE, MAX_SPEED = 1e13, 299792.458
"""km, a light-year; km/s."""

COMPONENTS = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")


@checked
def read_oem(
    path: str | Path, mu: float | None = None, *, segment: int | None = None, calendar: Calendar | None = None
) -> Ephemeris:
    """Return the orbit in a CCSDS Orbit Ephemeris Message, version 1 to 3, KVN or XML.

    Positions and velocities are interpolated as in `Ephemeris.from_table`. The reader ignores the interpolation that
    the message proposes, accelerations and covariances.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    mu : float, optional
        Gravitational parameter of the centre, km3/s2. Default: the value of DE440 for Sun, planets and Moon.
    segment : int, optional
        Index of a segment, from 0. Segments that share an epoch and its state are read as one.
    calendar : Calendar, optional
        Calendar in seconds. Default: from the first epoch in the time system of the message. Orbits of one system must
        share one calendar.

    Returns
    -------
    Ephemeris
        Position in km and velocity in km/s relative to the centre of the message, along its frame: "ICRF" (also for
        GCRF, EME2000 or J2000), "TEME", "TOD", "MOD" or "MCI". Its span is the usable span of the message.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or is not a complete message of this kind, its frame rotates or is unknown, its times
        do not increase or contain a gap, its segments do not join, or astropy is not installed.

    Examples
    --------
    >>> pt.files.read_oem("m.oem").span  # s
    (0.0, 120.0)
    """
    text, name = read_text(path), shortened(path)
    _, segments = ccsds.segments_of(text, name, "OEM", "123", NEEDED, METADATA, lambda *_: COMPONENTS, ACCELERATION)
    rows = _joined(ccsds.chosen(segments, segment, name))
    if rows.metadata.get("REF_FRAME_EPOCH") and ccsds.axes_name(rows.metadata["REF_FRAME"]) != "ICRF":
        epoch = rows.metadata["REF_FRAME_EPOCH"][:40]
        warnings.warn(
            f"REF_FRAME_EPOCH in {name} should be absent, got {epoch!r}. It is ignored: the axes are the axes of date.",
            stacklevel=level_of_user(),
        )
    center, frame = rows.metadata["CENTER_NAME"], rows.metadata["REF_FRAME"].upper().replace(" ", "")
    if frame not in ccsds.FRAMES:
        rule = "a frame that does not rotate" if ccsds.ROTATING.match(frame) else f"one of {', '.join(ccsds.FRAMES)}"
        raise ValueError(f"REF_FRAME in {name} must be {rule}, got {quoted(frame)}.")
    mu = attractor_mu(center, mu)
    table = rows.stacked(*COMPONENTS)
    wrong = np.flatnonzero((np.abs(table) >= [MAX_DISTANCE] * 3 + [MAX_SPEED] * 3).any(axis=1))
    if wrong.size:
        raise ValueError(f"{rows.places[wrong[0]]} must have km and km/s, got {rows.numbers[wrong[0]]}.")
    times, calendar = ccsds.times_of(rows, None if calendar is None else checked_calendar(calendar))
    labels: dict[str, Any] = {
        "reference_frame": ccsds.FRAMES[frame],
        "radius": attractor_radius(center),
        "origin": center.upper(),
        "calendar": calendar,
    }
    usable = [ccsds.stated_time(rows, key, calendar) for key in ("USEABLE_START_TIME", "USEABLE_STOP_TIME")]
    try:
        whole = Ephemeris.from_table(mu, times=times, positions=table[:, :3], velocities=table[:, 3:], **labels)
        return _within(whole, usable, table, labels)
    except ValueError as error:
        raise ValueError(f"{rows.places[0]} to {rows.places[-1].removeprefix(f'{name}, ')}: {error}") from None


def _within(
    whole: Ephemeris, usable: list[float | None], table: NDArray[np.float64], labels: dict[str, Any]
) -> Ephemeris:
    """Return the part of an ephemeris between two times, with a row of its own at each that is between rows."""
    first, last = (end if asked is None else asked for end, asked in zip(whole.span, usable, strict=True))
    if (first, last) == whole.span:
        return whole
    if not whole.span[0] <= first < last <= whole.span[1]:
        raise ValueError(f"the usable times must lie within the times of the rows, {whole.span}, got {(first, last)}.")
    inside = (whole.knots > first) & (whole.knots < last)
    ends = np.array([first, last])
    edge = np.stack([*whole.position_at(ends), *whole.velocity_at(ends)], axis=-1)
    rows = np.concatenate([edge[:1], table[inside], edge[1:]])
    times = np.concatenate([ends[:1], whole.knots[inside], ends[1:]])
    return Ephemeris.from_table(float(whole.mu), times=times, positions=rows[:, :3], velocities=rows[:, 3:], **labels)


def _joined(segments: list[TextRows]) -> TextRows:
    """Return all segments as one, if each begins with the state with which the one before ends."""
    whole = segments[0]
    for i, after in enumerate(segments[1:], start=1):
        same = {
            key: whole.metadata.get(key) == after.metadata.get(key) for key in ("OBJECT_ID", "REF_FRAME_EPOCH", *NEEDED)
        }
        state = f"the state at {after.epochs[0]}"
        same[state] = (whole.epochs[-1], whole.numbers[-1]) == (after.epochs[0], after.numbers[0])
        ccsds.check_continued(segments, i, same)
        stop = {key: after.metadata.get(key, "") for key in ("STOP_TIME", "USEABLE_STOP_TIME")}
        joined = {key: getattr(whole, key)[:-1] + getattr(after, key) for key in ("places", "epochs", "numbers")}
        whole = dataclasses.replace(whole, metadata=whole.metadata | stop, **joined)
    return whole
