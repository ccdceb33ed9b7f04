"""CCSDS Attitude Ephemeris Messages (504.0-B), versions 1.0 and 2.0, in KVN and XML."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, calendar_of, check_rising, rates_per_second, table_of
from poinsot.files.untrusted import local_name, read_text
from poinsot.mechanics.calendar import SECONDS, Calendar
from poinsot.propagation.trajectory import Trajectory

__all__ = ["read_aem", "write_aem"]

NEEDED = ("REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM", "ATTITUDE_TYPE")

XML_ROWS = {
    ("1.0", "QUATERNION"): "quaternionState",
    ("1.0", "QUATERNION/DERIVATIVE"): "quaternionDerivative",
    ("2.0", "QUATERNION"): "quaternionEphemeris",
    ("2.0", "QUATERNION/ANGVEL"): "quaternionAngVel",
}

XML_RATES = {"QUATERNION/DERIVATIVE": "quaternionRate", "QUATERNION/ANGVEL": "angVel"}


@dataclasses.dataclass
class _Segment:
    """One block of a message: what it says of itself, and its rows with the place of each in the file."""

    name: str
    says: dict[str, str]
    places: list[str] = dataclasses.field(default_factory=list)
    epochs: list[str] = dataclasses.field(default_factory=list)
    rows: list[dict[str, float]] = dataclasses.field(default_factory=list)

    def add(self, place: str, epoch: str, row: dict[str, float]) -> None:
        if "NUTATION_PER" in row:
            adm.checked_period(row["NUTATION_PER"], place)
        self.places.append(place)
        self.epochs.append(epoch)
        self.rows.append(row)


# ------------------------------------------------------------------ reading


@checked
def read_aem(path: str | Path, *, segment: int | None = None, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in a CCSDS Attitude Ephemeris Message, version 1 or 2, KVN or XML.

    All types of attitude are read: quaternions in either order, Euler angles in any sequence, spin, with their
    derivatives and angular velocities, from A to B or from B to A. Of version 1 the columns of /RATE and /NUTATION are
    passed over, because the standard does not say what they are; so are interpolation and usable times.

    Parameters
    ----------
    path : str or Path
    segment : int, optional
        Which one of several, from 0. Segments of one object that follow each other are read as one table.
    calendar : Calendar, optional
        Counts the times; default: from the first epoch, in seconds, in the time system of the message.

    Returns
    -------
    AttitudeTable
        Rates in radians per unit of the calendar. One of the two frames of the message must be one that does not
        rotate (named as `read_oem` names them), the other is the body.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is no such message or is not whole, a frame rotates, a quaternion is off unit norm by more than a
        thousandth, times do not rise, or segments differ.
    ImportError
        If astropy is missing.
    """
    name, text = str(path), read_text(path)
    version, segments = _segments_of_xml(text, name) if text.lstrip().startswith("<") else _segments_of_kvn(text, name)
    chosen, tables = _chosen(segments, segment, name), list[AttitudeTable]()
    for part in chosen:
        tables.append(_table_of(part, version, calendar))
        calendar = tables[-1].calendar
    for i, (before, after) in enumerate(itertools.pairwise(zip(chosen, tables, strict=True))):
        _check_continued(before, after, f"{i} and {i + 1}", len(tables))
    return tables[0] if len(tables) == 1 else _joined(tables)


def _table_of(segment: _Segment, version: str, calendar: Calendar | None) -> AttitudeTable:
    says, name, kind = segment.says, segment.name, segment.says["ATTITUDE_TYPE"]
    first, second = says["REF_FRAME_A"], says["REF_FRAME_B"]
    if _direction(segment, version) == "B2A":
        first, second = second, first
    body, reference, body_is_b = ccsds.body_and_reference(first, second, f"REF_FRAME_A and REF_FRAME_B in {name}")
    sequence = adm.sequence_of(says.get("EULER_ROT_SEQ", ""), name) if kind.startswith("EULER") else None
    times, calendar = ccsds.times_of(segment.epochs, segment.places, says["TIME_SYSTEM"], calendar, name)
    _check_times(times, segment, calendar)
    q, omega, norm_error = adm.attitude_of(
        kind,
        {key: np.array([row[key] for row in segment.rows]) for key in segment.rows[0]},
        sequence,
        rate_in_a=_rate_frame(segment, first, second) == "A",
        body_is_b=body_is_b,
        version=version,
        places=segment.places,
    )
    omega = None if omega is None else omega * SECONDS[calendar.unit]
    return AttitudeTable(times, q, omega, calendar, reference, body, norm_error)


def _direction(segment: _Segment, version: str) -> str:
    """Return A2B or B2A; version 2 knows only the first and need not say it."""
    said = segment.says.get("ATTITUDE_DIR", "" if version < "2" else "A2B").upper()
    if said not in ("A2B", "B2A"):
        raise ValueError(f"ATTITUDE_DIR in {segment.name} must be A2B or B2A, but it is {said[:20]!r}.")
    return said


def _rate_frame(segment: _Segment, first: str, second: str) -> str:
    """Return whether angular velocities are along the frame from which the attitude leads, A, or along the other, B."""
    if not segment.says["ATTITUDE_TYPE"].endswith("ANGVEL"):
        return "B"
    said = segment.says.get("ANGVEL_FRAME", "").upper()
    names = {said, segment.says.get(said, said).upper()}
    if second.upper() in names:
        return "B"
    if first.upper() in names:
        return "A"
    raise ValueError(
        f"ANGVEL_FRAME in {segment.name} must be one of the frames {first}, {second}, but it is {said[:40]!r}."
    )


def _check_times(times: Any, segment: _Segment, calendar: Calendar) -> None:
    check_rising(times, segment.places)
    said = segment.says.get("STOP_TIME")
    if said and times.size > 1:
        stop = ccsds.times_of(
            [said], [f"STOP_TIME in {segment.name}"], segment.says["TIME_SYSTEM"], calendar, segment.name
        )
        if times[-1] + (times[-1] - times[-2]) < stop[0][0]:
            raise ValueError(
                f"the rows of {segment.name} must reach STOP_TIME = {said}, but the last is of {segment.epochs[-1]}. "
                "The file is not whole."
            )


def _chosen(segments: list[_Segment], index: int | None, name: str) -> list[_Segment]:
    if not segments:
        raise ValueError(f"{name} must have a segment with rows, but it has none.")
    for i, segment in enumerate(segments):
        if not segment.rows:
            raise ValueError(f"segment {i} of {name} must have rows, but it has none.")
    if index is None:
        return segments
    if not 0 <= index < len(segments):
        raise ValueError(f"segment must be a number from 0 to {len(segments) - 1}, got {index}.")
    return [segments[index]]


def _check_continued(
    before: tuple[_Segment, AttitudeTable], after: tuple[_Segment, AttitudeTable], which: str, count: int
) -> None:
    (segment, first), (_, second) = before, after
    differing = [
        what
        for what, same in (
            ("OBJECT_ID", segment.says.get("OBJECT_ID") == after[0].says.get("OBJECT_ID")),
            ("frames", (first.body_frame, first.reference_frame) == (second.body_frame, second.reference_frame)),
            ("order in time", first.times[-1] <= second.times[0]),
        )
        if not same
    ]
    if differing:
        raise ValueError(
            f"the segments of {segment.name} must follow each other to be read as one, but {which} differ in "
            f"{differing[0]}. Say which one: segment=0 to {count - 1}."
        )


def _joined(tables: list[AttitudeTable]) -> AttitudeTable:
    """Return several tables as one, an attitude that ends one and begins the next taken once."""
    keep = [slice(int(i > 0 and table.times[0] == tables[i - 1].times[-1]), None) for i, table in enumerate(tables)]
    kept = list(zip(tables, keep, strict=True))
    rates = [table.omega_body[part] for table, part in kept if table.omega_body is not None]
    return dataclasses.replace(
        tables[0],
        times=np.concatenate([table.times[part] for table, part in kept]),
        quaternion=np.concatenate([table.quaternion[part] for table, part in kept]),
        omega_body=np.concatenate(rates) if len(rates) == len(tables) else None,
        norm_error=max(table.norm_error for table in tables),
    )


# ------------------------------------------------------------------ KVN


def _segments_of_kvn(text: str, name: str) -> tuple[str, list[_Segment]]:
    version, lines = ccsds.opened_kvn(text, name, "AEM")
    segments: list[_Segment] = []
    columns: tuple[str, ...] = ()
    for count, line in lines:
        place = f"{name}, line {count}"
        if line == "META_START":
            segments.append(_Segment(name, ccsds.kvn_metadata(lines, name, count)))
            columns = _columns(segments[-1], version)
        elif line == "DATA_START":
            _read_block(lines, segments, columns, place)
        elif segments:
            _read_row(line, segments[-1], columns, place)
        elif "=" not in line:
            raise ValueError(f"{place} must come after META_START, but {line[:60]!r} comes before.")
    return version, segments


def _columns(segment: _Segment, version: str) -> tuple[str, ...]:
    """Return the columns of the rows in KVN that a segment will have, its metadata checked."""
    kind = _kind(segment)
    first = segment.says.get("QUATERNION_TYPE", "" if version < "2" else "LAST").upper()
    if kind.startswith("QUATERNION") and first not in ("FIRST", "LAST"):
        raise ValueError(f"QUATERNION_TYPE in {segment.name} must be FIRST or LAST, but it is {first[:20]!r}.")
    return adm.kvn_columns(kind, first == "FIRST")


def _kind(segment: _Segment) -> str:
    missing = [key for key in NEEDED if not segment.says.get(key)]
    if missing:
        raise ValueError(f"a segment of {segment.name} must have {missing[0]}, but it has none.")
    kind = "/".join(segment.says["ATTITUDE_TYPE"].upper().replace(" ", "_").split("/"))
    if kind not in adm.COLUMNS:
        raise ValueError(
            f"ATTITUDE_TYPE in {segment.name} must be one of {', '.join(adm.COLUMNS)}, but it is {kind[:40]!r}."
        )
    segment.says["ATTITUDE_TYPE"] = kind
    return kind


def _read_block(
    lines: Iterator[tuple[int, str]], segments: list[_Segment], columns: tuple[str, ...], begin: str
) -> None:
    if not segments:
        raise ValueError(f"{begin} must come after META_START, but 'DATA_START' comes before.")
    for count, line in lines:
        if line == "DATA_STOP":
            return
        _read_row(line, segments[-1], columns, f"{segments[-1].name}, line {count}")
    raise ValueError(f"{begin} must be followed by DATA_STOP, but the file ends.")


def _read_row(line: str, segment: _Segment, columns: tuple[str, ...], place: str) -> None:
    epoch, *texts = line.split()
    if len(texts) != len(columns):
        raise ValueError(f"{place} must have a time and {', '.join(columns)}, got {line[:100]!r}.")
    row = {key: ccsds.number(ccsds.Entry(key, text, place)) for key, text in zip(columns, texts, strict=True)}
    segment.add(place, epoch, row)


# ------------------------------------------------------------------ XML


def _segments_of_xml(text: str, name: str) -> tuple[str, list[_Segment]]:
    version, elements = ccsds.opened_xml(text, name, "AEM")
    return version, [_segment_of_xml(element, name, i) for i, element in enumerate(elements)]


def _segment_of_xml(element: ET.Element, name: str, index: int) -> _Segment:
    segment = _Segment(name, {})
    columns: tuple[str, ...] = ()
    for part in element.iter():
        tag = local_name(part)
        if tag == "metadata":
            segment.says |= {said.key: said.value for said in ccsds.entries_of(part, f"{name}, segment {index}")}
            columns = adm.COLUMNS[_kind(segment)]
        elif tag == "attitudeState":
            _add_state(segment, part, columns, f"{name}, segment {index}, row {len(segment.rows)}")
    return segment


def _add_state(segment: _Segment, element: ET.Element, columns: tuple[str, ...], place: str) -> None:
    said = {entry.key: entry for entry in ccsds.entries_of(element, place)}
    missing = [key for key in ("EPOCH", *columns) if key not in said]
    if missing or not columns:
        raise ValueError(f"{place} must have {', '.join(missing) or 'metadata before it'}, but it has none.")
    segment.add(place, said["EPOCH"].value, {key: ccsds.number(said[key]) for key in columns})


# ------------------------------------------------------------------ writing


@checked
def write_aem(
    motion: Trajectory | AttitudeTable,
    path: str | Path,
    *,
    calendar: Calendar | None = None,
    reference_frame: str | None = None,
    body_frame: str | None = None,
    object_name: str = "UNKNOWN",
    object_id: str = "UNKNOWN",
    center_name: str | None = None,
    originator: str = "POINSOT",
    rates: bool = True,
    version: str = "2.0",
    overwrite: bool = False,
) -> Path:
    """Write the attitudes of a motion, or of a table, as a CCSDS Attitude Ephemeris Message; return its path.

    The quaternion leads from REF_FRAME_A, the space axes, to REF_FRAME_B, the body, scalar last: the annex F of the
    standard turns the axes of A into those of B, so that Q1, Q2, Q3, QC are q1, q2, q3, q0. Rates go along as
    QUATERNION/ANGVEL along the body, in version 1 as QUATERNION/DERIVATIVE.

    Parameters
    ----------
    motion : Trajectory or AttitudeTable
    path : str or Path
        XML if it ends in .xml, KVN otherwise.
    calendar : Calendar, optional
        What instant t = 0 is and the unit of the times; default: that of the system's orbits or of the table.
    reference_frame : str, optional
        The name of the space axes, such as "ICRF"; default: that of the system's orbits or of the table.
    body_frame, object_name, object_id, center_name, originator : str
        Names in the message; the body frame is "SC_BODY_1" where neither says another one.
    rates : bool
        Whether angular velocities go along.
    version : {"2.0", "1.0"}
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is not what its name says, the motion is an ensemble, or the file exists.
    """
    table = table_of(motion, calendar, reference_frame, body_frame)
    header = ccsds.header_entries("AEM", version, originator)
    ccsds.body_and_reference(table.reference_frame, table.body_frame, "reference_frame and body_frame")
    kind, columns, rows = _written_rows(table, rates, version)
    dates, system = ccsds.dates_of(calendar_of(table), table.times)
    quaternions = kind.startswith("QUATERNION") and version < "2"
    metadata = ccsds.metadata_entries(
        {
            "OBJECT_NAME": object_name,
            "OBJECT_ID": object_id,
            "CENTER_NAME": center_name,
            "REF_FRAME_A": table.reference_frame,
            "REF_FRAME_B": table.body_frame,
            "ATTITUDE_DIR": "A2B" if version < "2" else None,
            "TIME_SYSTEM": system,
            "START_TIME": dates[0],
            "STOP_TIME": dates[-1],
            "ATTITUDE_TYPE": kind,
            "QUATERNION_TYPE": "LAST" if quaternions else None,
            "ANGVEL_FRAME": table.body_frame if kind.endswith("ANGVEL") else None,
        }
    )
    written = _as_xml if Path(path).suffix.lower() == ".xml" else _as_kvn
    return write_text(path, written(version, header, metadata, kind, columns, dates, rows), overwrite)


def _written_rows(table: AttitudeTable, rates: bool, version: str) -> tuple[str, tuple[str, ...], Any]:
    """Return type, columns and numbers of the rows, per second."""
    q = table.quaternion[:, [1, 2, 3, 0]]
    omega = rates_per_second(table, rates)
    if omega is None:
        return "QUATERNION", adm.QUATERNION, q
    if version < "2":
        kind, more = "QUATERNION/DERIVATIVE", 0.5 * quat.product(table.quaternion, quat.pure(omega))[:, [1, 2, 3, 0]]
    else:
        kind, more = "QUATERNION/ANGVEL", np.degrees(omega)
    return kind, adm.COLUMNS[kind], np.concatenate([q, more], axis=1)


def _as_kvn(
    _: str, header: Any, metadata: Any, kind: str, columns: tuple[str, ...], dates: list[str], rows: Any
) -> str:
    lines = (
        *(f"{key} = {value}" for key, value in header),
        "",
        "META_START",
        f"COMMENT {kind}: {', '.join(columns)}; x_A = q x_B q~ (Hamilton product), QC the scalar",
        *(f"{key} = {value}" for key, value in metadata),
        "META_STOP",
        "",
        "DATA_START",
        *(f"{date} {' '.join(map(ccsds.digits, row))}" for date, row in zip(dates, rows.tolist(), strict=True)),
        "DATA_STOP",
    )
    return "\n".join(lines) + "\n"


def _as_xml(
    version: str, header: Any, metadata: Any, kind: str, columns: tuple[str, ...], dates: list[str], rows: Any
) -> str:
    segment = ET.Element("segment")
    about, data = ET.SubElement(segment, "metadata"), ET.SubElement(segment, "data")
    for key, value in metadata:
        ccsds.entry(about, key, value)
    for date, row in zip(dates, rows.tolist(), strict=True):
        state = ET.SubElement(ET.SubElement(data, "attitudeState"), XML_ROWS[version, kind])
        ccsds.entry(state, "EPOCH", date)
        _add_row(state, dict(zip(columns, row, strict=True)), kind, version)
    return ccsds.xml_text("AEM", version, header, segment)


def _add_row(state: ET.Element, row: Mapping[str, float], kind: str, version: str) -> None:
    groups: list[tuple[str, tuple[str, ...]]] = [("quaternion", adm.QUATERNION)]
    if kind in XML_RATES:
        groups.append((XML_RATES[kind], adm.COLUMNS[kind][4:]))
    for tag, keys in groups:
        group = ET.SubElement(state, tag)
        for key in ccsds.xml_order(keys, version):
            ccsds.entry(group, key, row[key], **({"units": "deg/s"} if key.startswith("ANGVEL") else {}))


class Aem(AttitudeFormat):
    """Attitude ephemeris messages of the CCSDS."""

    title = "CCSDS AEM"
    suffixes = (".aem", ".xml")
    in_python = "pt.files.read_aem({path!r})"
    conventions = (
        "scalar last: Q1, Q2, Q3, QC are q1, q2, q3, q0; version 1 may say FIRST",
        "the quaternion from A to B turns the axes of A into those of B: A space, B body is ours; version 1 may say "
        "B2A",
        "deg/s along the body (ANGVEL); version 1: derivatives of the quaternion",
    )
    read, write = staticmethod(read_aem), staticmethod(write_aem)

    @staticmethod
    @override
    def sniff(head: bytes) -> bool:
        return re.search(rb"CCSDS_AEM_VERS|<aem[\s>]", head) is not None
