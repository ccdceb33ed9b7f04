"""Orbits from CCSDS Orbit Ephemeris Messages, in KVN or XML."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.ccsds import FRAMES, ROTATING
from poinsot.files.untrusted import local_name, read_text
from poinsot.mechanics.calendar import SCALES, Calendar, checked_calendar
from poinsot.orbits.attractors import attractor_mu, attractor_radius
from poinsot.orbits.ephemeris import Ephemeris

__all__ = ["read_oem"]

NEEDED = ("CENTER_NAME", "REF_FRAME", "TIME_SYSTEM")

MOST_DISTANCE, MOST_SPEED = 1e13, 299792.458
"""km, a light-year; km/s."""

COMPONENTS = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")

UNITS = dict.fromkeys(COMPONENTS[:3], "km") | dict.fromkeys(COMPONENTS[3:], "km/s")


@dataclasses.dataclass
class _Segment:
    """One block of a message: what it says of itself, and its rows with the place of each in the file."""

    name: str
    says: dict[str, str]
    places: list[str] = dataclasses.field(default_factory=list)
    epochs: list[str] = dataclasses.field(default_factory=list)
    rows: list[list[float]] = dataclasses.field(default_factory=list)

    def add(self, place: str, epoch: str, components: list[str]) -> None:
        try:
            row = [float(component) for component in components]
            Calendar(epoch.removesuffix("Z"), "TT")
        except ValueError:
            row = []
        if len(row) != 6 or not max(map(abs, row[:3])) < MOST_DISTANCE or not max(map(abs, row[3:])) < MOST_SPEED:
            given = " ".join([epoch, *components])[:100]
            raise ValueError(f"{self.name}, {place} must have a time, three km and three km/s, got {given!r}.")
        self.places.append(place)
        self.epochs.append(epoch)
        self.rows.append(row)


@checked
def read_oem(
    path: str | Path, mu: float | None = None, *, segment: int | None = None, calendar: Calendar | None = None
) -> Ephemeris:
    """Return the orbit in a CCSDS Orbit Ephemeris Message, version 1 to 3, KVN or XML.

    Positions and velocities are interpolated as by `Ephemeris.from_table`; the interpolation that the message
    proposes, accelerations and covariances are passed over.

    Parameters
    ----------
    path : str or Path
    mu : float, optional
        Gravitational parameter of the centre, km3/s2; default: that of DE440 for Sun, planets and Moon.
    segment : int, optional
        Which one of several, from 0. Segments that share an epoch and its state are read as one.
    calendar : Calendar, optional
        Counts seconds; default: from the first epoch, in the time system of the message. Orbits of one system
        share one.

    Returns
    -------
    Ephemeris
        km and km/s from the centre of the message, along its frame: "ICRF" (also where the message says GCRF,
        EME2000 or J2000), "TEME", "TOD", "MOD" or "MCI". Its span is the usable one of the message.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is no such message or is not whole, its frame rotates or is unknown, its times do not rise or
        have a gap, or its segments do not join.
    ImportError
        If astropy is missing.
    """
    name = str(path)
    text = read_text(path)
    segments = _segments_of_xml(text, name) if text.lstrip().startswith("<") else _segments_of_kvn(text, name)
    chosen = _chosen(segments, segment, name)
    frame, system = _checked_metadata(chosen, name)
    mu = attractor_mu(chosen.says["CENTER_NAME"], mu)
    calendar = Calendar(chosen.epochs[0].removesuffix("Z"), system) if calendar is None else checked_calendar(calendar)
    times = calendar.time([_epoch(text, system) for text in chosen.epochs])
    _check_rising(times, chosen)
    table = np.asarray(chosen.rows)
    labels: dict[str, Any] = {
        "reference_frame": frame,
        "radius": attractor_radius(chosen.says["CENTER_NAME"]),
        "origin": chosen.says["CENTER_NAME"].upper(),
        "calendar": calendar,
    }
    stop, *usable = _said(chosen, ("STOP_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME"), calendar, system)
    try:
        _check_whole(times, chosen, stop)
        whole = Ephemeris.from_table(mu, times=times, positions=table[:, :3], velocities=table[:, 3:], **labels)
        return _within(whole, usable, table, labels)
    except ValueError as error:
        raise ValueError(f"{name}, {chosen.places[0]} to {chosen.places[-1]}: {error}") from None


def _epoch(text: str, system: str) -> str:
    return f"{text.removesuffix('Z')} {system}"


def _said(segment: _Segment, keys: tuple[str, ...], calendar: Calendar, system: str) -> list[float | None]:
    """Return the times that the metadata say, None for those that they do not say."""
    texts = (segment.says.get(key) for key in keys)
    return [calendar.time(_epoch(text, system)) if text else None for text in texts]


def _check_whole(times: NDArray[np.float64], segment: _Segment, stop: float | None) -> None:
    if stop is not None and times.size > 1 and times[-1] + (times[-1] - times[-2]) < stop:
        raise ValueError(
            f"the rows must reach STOP_TIME = {segment.says['STOP_TIME']}, but the last is of {segment.epochs[-1]}. "
            "The file is not whole."
        )


def _within(
    whole: Ephemeris, usable: list[float | None], table: NDArray[np.float64], labels: dict[str, Any]
) -> Ephemeris:
    """Return the part of an ephemeris between two times, with a row of its own at each that is between rows."""
    first, last = (end if asked is None else asked for end, asked in zip(whole.span, usable, strict=True))
    if (first, last) == whole.span:
        return whole
    if not whole.span[0] <= first < last <= whole.span[1]:
        raise ValueError(
            f"the usable times must lie within those of the rows, {whole.span}, but they are {(first, last)}."
        )
    inside = (whole.knots > first) & (whole.knots < last)
    ends = np.array([first, last])
    edge = np.stack([*whole.position_at(ends), *whole.velocity_at(ends)], axis=-1)
    rows = np.concatenate([edge[:1], table[inside], edge[1:]])
    times = np.concatenate([ends[:1], whole.knots[inside], ends[1:]])
    return Ephemeris.from_table(float(whole.mu), times=times, positions=rows[:, :3], velocities=rows[:, 3:], **labels)


def _check_rising(times: NDArray[np.float64], segment: _Segment) -> None:
    wrong = np.flatnonzero(np.diff(times) <= 0)
    if wrong.size:
        i = int(wrong[0]) + 1
        raise ValueError(
            f"{segment.name}, {segment.places[i]} must be later than the row before, but {segment.epochs[i]} follows "
            f"{segment.epochs[i - 1]}."
        )


def _checked_metadata(segment: _Segment, name: str) -> tuple[str, str]:
    """Return the frame, by the name it has here, and the time system."""
    frame = segment.says["REF_FRAME"].upper().replace(" ", "")
    if ROTATING.match(frame):
        raise ValueError(f"REF_FRAME in {name} must be a frame that does not rotate, but it is {frame[:40]}.")
    if frame not in FRAMES:
        raise ValueError(f"REF_FRAME in {name} must be one of {', '.join(FRAMES)}, but it is {frame[:40]!r}.")
    system = segment.says["TIME_SYSTEM"].upper()
    if system not in SCALES:
        raise ValueError(f"TIME_SYSTEM in {name} must be one of {', '.join(SCALES)}, but it is {system[:40]!r}.")
    return FRAMES[frame], system


# ------------------------------------------------------------------ segments


def _chosen(segments: list[_Segment], index: int | None, name: str) -> _Segment:
    if not segments:
        raise ValueError(f"{name} must have a segment with rows, but it has none.")
    for i, segment in enumerate(segments):
        missing = [key for key in NEEDED if not segment.says.get(key)]
        if missing:
            raise ValueError(f"segment {i} of {name} must have {missing[0]}, but it has none.")
        if not segment.rows:
            raise ValueError(f"segment {i} of {name} must have rows, but it has none.")
    if index is None:
        return _joined(segments, name)
    if not 0 <= index < len(segments):
        raise ValueError(f"segment must be a number from 0 to {len(segments) - 1}, got {index}.")
    return segments[index]


def _joined(segments: list[_Segment], name: str) -> _Segment:
    """Return all segments as one, if each begins with the state with which the one before ends."""
    whole = segments[0]
    for i, after in enumerate(segments[1:], start=1):
        differing = [key for key in ("OBJECT_ID", *NEEDED) if whole.says.get(key) != after.says.get(key)]
        if not differing and (whole.epochs[-1], whole.rows[-1]) != (after.epochs[0], after.rows[0]):
            differing = [f"the state at {after.epochs[0]}"]
        if differing:
            raise ValueError(
                f"the segments of {name} must continue each other to be read as one, but {i - 1} and {i} differ in "
                f"{differing[0]}. Say which one: segment=0 to {len(segments) - 1}."
            )
        stop = {key: after.says.get(key, "") for key in ("STOP_TIME", "USEABLE_STOP_TIME")}
        parts = ((getattr(part, field) for part in (whole, after)) for field in ("places", "epochs", "rows"))
        whole = _Segment(name, whole.says | stop, *(first[:-1] + second for first, second in parts))
    return whole


# ------------------------------------------------------------------ KVN


def _segments_of_kvn(text: str, name: str) -> list[_Segment]:
    lines = ccsds.kvn_lines(text)
    _, opening = next(lines, (0, ""))
    if not re.fullmatch(r"CCSDS_OEM_VERS\s*=\s*[123](\.\d+)?", opening):
        raise ValueError(
            f"{name} must begin with CCSDS_OEM_VERS = 1.0, 2.0 or 3.0, but it begins with {opening[:60]!r}."
        )
    segments: list[_Segment] = []
    for number, line in lines:
        if line == "META_START":
            segments.append(_Segment(name, ccsds.kvn_metadata(lines, name, number)))
        elif line == "COVARIANCE_START":
            _skip_covariance(lines, f"{name}, line {number}")
        elif segments:
            epoch, *components = line.split()
            segments[-1].add(f"line {number}", epoch, components[:6] if len(components) == 9 else components)
        elif "=" not in line:
            raise ValueError(f"{name}, line {number} must come after META_START, but {line[:60]!r} comes before.")
    return segments


def _skip_covariance(lines: Iterator[tuple[int, str]], begin: str) -> None:
    if not any(line == "COVARIANCE_STOP" for _, line in lines):
        raise ValueError(f"{begin} must be followed by COVARIANCE_STOP, but the file ends.")


# ------------------------------------------------------------------ XML


def _segments_of_xml(text: str, name: str) -> list[_Segment]:
    found = [part for part in ccsds.one_message(text, name, "oem").iter() if local_name(part) == "segment"]
    return [_segment_of_xml(part, name, i) for i, part in enumerate(found)]


def _segment_of_xml(element: ET.Element, name: str, index: int) -> _Segment:
    segment = _Segment(name, {})
    for part in element.iter():
        if local_name(part) == "metadata":
            segment.says |= {local_name(entry): (entry.text or "").strip() for entry in part}
        elif local_name(part) == "stateVector":
            place = f"segment {index}, state vector {len(segment.rows)}"
            fields = {local_name(entry): entry for entry in part}
            for key, unit in UNITS.items():
                if key in fields and fields[key].get("units", unit) != unit:
                    raise ValueError(
                        f"{name}, {place} must have {key} in {unit}, but it is in {fields[key].get('units')!r}."
                    )
            texts = {key: (entry.text or "").strip() for key, entry in fields.items()}
            segment.add(place, texts.get("EPOCH", ""), [texts.get(key, "none") for key in COMPONENTS])
    return segment
