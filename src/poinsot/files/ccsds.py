"""Elements of CCSDS messages: KEY = VALUE lines and XML, segments of rows, frames, time systems, epochs, headers."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from poinsot.atomic_write import write_text
from poinsot.files.keys import Entry, Keys
from poinsot.files.rows import TextRows
from poinsot.files.untrusted import local_name, parsed_xml
from poinsot.printable import quoted, shortened
from poinsot.records.calendar import SCALES, Calendar

INERTIAL = {
    "ICRF": ("ICRF", "ICRF1", "ICRF2", "ICRF3", "ICRS", "GCRF", "GCRF1", "GCRF2", "GCRF3", "GCRS", "EME2000", "J2000"),
    "TEME": ("TEME", "TEMEOFDATE", "TEMEOFEPOCH"),
    "TOD": ("TOD", "TOD_EARTH"),
    "MOD": ("MOD", "MOD_EARTH"),
    "MCI": ("MCI",),
}
"""Names of frames that do not rotate. EME2000 is within 0.03 arcseconds of the ICRF, and taken for it."""

FRAMES = {name: frame for frame, names in INERTIAL.items() for name in names}

ROTATING = re.compile(r"ITRF|DTRF|WGS|GRC|TDR|EFG|ECEF|FIXED|IAU_|GTOD|PEF|TIRS")
"""Names of frames that rotate with a planet."""

ORBITAL = re.compile(r"LVLH|RTN|RSW|QSW|TNW|NTW|RIC|VVLH|VNC|EQW|PQW|SEZ|NSW")
"""Names of frames that turn along an orbit."""

UNITS = (
    (re.compile(r"Q[123C]|EPOCH"), ""),
    (re.compile(r"Q[123C]_DOT"), "1/s"),
    (re.compile(r"ANGLE_[123]_DOT|ANGVEL_[XYZ]|SPIN_ANGLE_VEL|NUTATION_VEL|RATE_[123]|[XYZ]_RATE"), "deg/s"),
    (re.compile(r"ANGLE_[123]|[XYZ]_ANGLE|SPIN_(ALPHA|DELTA|ANGLE)|NUTATION(_PHASE)?|MOMENTUM_\w+"), "deg"),
    (re.compile(r"NUTATION_PER"), "s"),
    (re.compile(r"I(XX|YY|ZZ|XY|XZ|YZ|11|22|33|12|13|23)"), "kg*m**2"),
    (re.compile(r"[XYZ]"), "km"),
    (re.compile(r"[XYZ]_DOT"), "km/s"),
    (re.compile(r"MEAN_MOTION"), "rev/day"),
    (re.compile(r"ECCENTRICITY"), ""),
    (re.compile(r"INCLINATION|RA_OF_ASC_NODE|ARG_OF_PERICENTER|MEAN_ANOMALY"), "deg"),
    (re.compile(r"BSTAR"), "1/ER"),
    (re.compile(r"GM"), "km**3/s**2"),
)

ROTATIONS = {"rotationAngles": "ANGLE", "rotationRates": "RATE"}
"""Elements of version 1, whose parts are rotation1, rotation2, rotation3."""

SCHEMAS = {"1.0": "ndmxml-1.0-master.xsd", "2.0": "ndmxml-4.0.0-master-4.0.xsd"}
"""XML schemas of the versions that are written."""

INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"


HEADER = ("CLASSIFICATION", "COMMENT", "CREATION_DATE", "MESSAGE_ID", "ORIGINATOR")
"""Keys of the header of every message, without an influence on the result."""

ROW_TAGS = {"AEM": "attitudeState", "OEM": "stateVector"}
"""Elements of a row in XML."""


# ------------------------------------------------------------------ reading


def is_xml(text: str) -> bool:
    """Return True if a message is in XML."""
    return text.lstrip().startswith("<")


def opened_kvn(text: str, name: str, message: str, versions: str = "12") -> tuple[str, Iterator[tuple[int, str]]]:
    """Return the version of a message in KVN and its other lines with their numbers, without comments."""
    numbered = enumerate(map(str.strip, text.splitlines()), start=1)
    lines = ((count, line) for count, line in numbered if line and not re.match(r"COMMENT\b", line))
    _, opening = next(lines, (0, ""))
    match = re.fullmatch(rf"CCSDS_{message}_VERS\s*=\s*([{versions}])(\.\d+)?", opening)
    if match is None:
        known = " or ".join(f"{version}.0" for version in versions)
        raise ValueError(f"{name} must begin with CCSDS_{message}_VERS = {known}, got {quoted(opening)}.")
    return f"{match[1]}.0", lines


def kvn_entry(line: str, place: str, rule: str) -> Entry:
    """Return KEY = VALUE [unit], the unit checked and taken away."""
    key, equals, value = (part.strip() for part in line.partition("="))
    if not equals or not re.fullmatch(r"\w+", key, re.ASCII):
        raise ValueError(f"{place} must be {rule}, got {quoted(line)}.")
    if value.endswith("]") and "[" in value:
        value, _, unit = value[:-1].partition("[")
        _check_unit(key, unit, place)
    return Entry(key, value.strip(), place)


def kvn_block(lines: Iterator[tuple[int, str]], name: str, begin: int, end: str) -> list[Entry]:
    """Return the entries of the lines up to the end of a block, such as META_STOP."""
    entries: list[Entry] = []
    for count, line in lines:
        if line == end:
            return entries
        entries.append(kvn_entry(line, f"{name}, line {count}", f"KEY = VALUE or {end}"))
    raise ValueError(f"{name}, line {begin} must be followed by {end}, got the end of the file.")


def opened_xml(text: str, name: str, message: str, versions: str = "12") -> tuple[str, list[ET.Element]]:
    """Return the version of the one message of a kind in XML, and its segments."""
    messages = [part for part in parsed_xml(text, name).iter() if local_name(part) == message.lower()]
    if len(messages) != 1:
        raise ValueError(f"{name} must hold one {message.lower()} element, got {len(messages)}.")
    header = (child for part in messages[0] if local_name(part) == "header" for child in part)
    entries = [entry for child in header for entry in entries_of(child, f"{name}, header")]
    Keys((), HEADER, repeated=("COMMENT",)).by_key(entries)
    version = messages[0].get("version", "")
    if not re.fullmatch(rf"[{versions}](\.\d+)?", version):
        known = " or ".join(f"{version}.0" for version in versions)
        raise ValueError(f"{name} must be of version {known}, got {quoted(version)}.")
    return f"{version[0]}.0", [part for part in messages[0].iter() if local_name(part) == "segment"]


def entries_of(element: ET.Element, place: str) -> Iterator[Entry]:
    """Yield the leaves of an element, with their units checked; the rotations of version 1 as ANGLE_i and RATE_i."""
    for part in element.iter():
        kind = ROTATIONS.get(local_name(part))
        leaves = [(local_name(leaf).replace("rotation", f"{kind}_"), leaf) for leaf in part if kind]
        leaves = leaves or [(local_name(part), part)]
        for key, leaf in leaves:
            if len(leaf) == 0 and not key.startswith("rotation"):
                _check_unit(key, leaf.get("units"), place)
                yield Entry(key, (leaf.text or "").strip(), place)


def _check_unit(key: str, unit: str | None, place: str) -> None:
    """Raise a ValueError for a stated unit that differs from the unit of the standard."""
    right = unit_of(key)
    if unit and right is not None and unit.strip().lower() not in ((right.lower(),) if right else ("", "n/a")):
        raise ValueError(f"{place} must have {key} in {right or 'no unit'}, got {quoted(unit)}.")


def unit_of(key: str) -> str | None:
    """Return the unit of a key in the standard, "" if it has none, None if the key is not known."""
    return next((unit for pattern, unit in UNITS if pattern.fullmatch(key)), None)


def axes_name(name: str) -> str:
    """Return the name of axes in capitals without spaces; of several names of inertial axes the first one."""
    plain = name.strip().upper().replace(" ", "")
    return FRAMES.get(plain, plain)


def segments_of(
    text: str,
    name: str,
    message: str,
    versions: str,
    needed: tuple[str, ...],
    metadata: Keys,
    columns_of: Callable[[TextRows, str, bool], tuple[str, ...]],
    ignored_columns: tuple[str, ...] = (),
) -> tuple[str, list[TextRows]]:
    """Return the version of an ephemeris message, and its segments, each with the needed metadata.

    `columns_of` returns the columns of a segment by its metadata, the version, and whether the message is in XML.
    """
    segments: list[TextRows] = []

    def begin(entries: list[Entry]) -> TextRows:
        segment = TextRows(name, {entry.key: entry.value for entry in entries})
        for key in needed:
            if not segment.metadata.get(key):
                raise ValueError(f"segment {len(segments)} of {name} must have {key}, got none.")
        metadata.by_key(entries)
        segment.columns = columns_of(segment, version, is_xml(text))
        segments.append(segment)
        return segment

    header = Keys((), HEADER, elsewhere=metadata.used, repeated=("COMMENT",))
    if is_xml(text):
        version, elements = opened_xml(text, name, message, versions)
        for i, element in enumerate(elements):
            _read_xml(element, f"{name}, segment {i}", ROW_TAGS[message], begin, ignored_columns)
    else:
        version, lines = opened_kvn(text, name, message, versions)
        header.by_key(_read_kvn(lines, name, begin))
    return version, segments


def _read_kvn(lines: Iterator[tuple[int, str]], name: str, begin: Callable[[list[Entry]], TextRows]) -> list[Entry]:
    """Read the segments, and return the entries before the first one."""
    segment, block, begun = None, "", 0
    header: list[Entry] = []
    for count, line in lines:
        place = f"{name}, line {count}"
        marked = re.fullmatch(r"(DATA|COVARIANCE)_(START|STOP)", line)
        if line == "META_START" and not block:
            segment = begin(kvn_block(lines, name, count, "META_STOP"))
        elif marked and segment:
            block, begun = (marked[1], count) if marked[2] == "START" else ("", 0)
        elif segment and block != "COVARIANCE":
            epoch, *texts = line.split()
            accelerations = 3 if len(texts) == 9 and segment.columns[0] == "X" else 0
            segment.add(place, texts[: len(texts) - accelerations], epoch)
        elif not segment and "=" not in line:
            raise ValueError(f"{place} must come after META_START, got {quoted(line)}.")
        elif not segment:
            header.append(kvn_entry(line, place, "KEY = VALUE"))
    if block:
        raise ValueError(f"{name}, line {begun} must be followed by {block}_STOP, got the end of the file.")
    return header


def _read_xml(
    element: ET.Element,
    place: str,
    row_tag: str,
    begin: Callable[[list[Entry]], TextRows],
    ignored_columns: tuple[str, ...],
) -> None:
    parts = [(local_name(part), part) for part in element.iter()]
    about = (child for tag, part in parts if tag == "metadata" for child in part)
    segment = begin([entry for child in about for entry in entries_of(child, place)])
    columns = frozenset(("EPOCH", *segment.columns, *ignored_columns))
    keys = Keys((), columns, repeated=("COMMENT",))
    tags = Keys((row_tag,), ("covarianceMatrix",), repeated=("COMMENT", row_tag))
    for data in (part for tag, part in parts if tag == "data"):
        for part in data:
            tags.check(local_name(part), place)
    for part in (part for tag, part in parts if tag == row_tag):
        row = f"{place}, row {len(segment.numbers)}"
        check_sequence(part, segment.metadata.get("EULER_ROT_SEQ", ""), row)
        entries = list(entries_of(part, row))
        values = {entry.key: entry.value for entry in entries}
        others = values.keys() - columns - {"COMMENT"}
        missing = next((key for key in ("EPOCH", *segment.columns) if not values.get(key)), None)
        if missing:
            raise ValueError(f"{row} must have {missing}, got none.")
        if others:
            raise ValueError(
                f"{row} must have numbers for {', '.join(segment.columns)}, got {quoted(min(others))} as well."
            )
        if len(values) < len(entries):
            keys.by_key(entries)
        segment.add(row, [values[key] for key in segment.columns], values["EPOCH"])


def check_sequence(element: ET.Element, sequence: str, place: str) -> None:
    """Raise a ValueError if rotations of version 1 are about other axes than the axes of the sequence."""
    for part in (part for part in element.iter() if local_name(part) == "rotationAngles"):
        axes = "".join((leaf.get("angle") or "")[:1] for leaf in sorted(part, key=local_name)).upper()
        given = sequence.upper().translate(str.maketrans("123", "XYZ"))
        if axes and axes != given:
            raise ValueError(f"{place} must have its angles in the order {quoted(given)}, got {quoted(axes)}.")


def chosen(segments: list[TextRows], index: int | None, name: str) -> list[TextRows]:
    """Return one of several segments, or all, each of which must have rows."""
    if not segments:
        raise ValueError(f"{name} must have a segment with rows, got none.")
    for i, segment in enumerate(segments):
        if not segment.numbers:
            raise ValueError(f"segment {i} of {name} must have rows, got none.")
    if index is not None and not 0 <= index < len(segments):
        raise ValueError(f"segment must be a number from 0 to {len(segments) - 1}, got {index}.")
    return segments if index is None else [segments[index]]


def check_continued(segments: list[TextRows], i: int, same: Mapping[str, bool]) -> None:
    """Raise a ValueError if a segment differs from the segment before, so that they cannot be joined."""
    differing = [what for what, is_same in same.items() if not is_same]
    if differing:
        raise ValueError(
            f"the segments of {segments[0].name} must continue each other to be read as one, got {i - 1} and {i}, "
            f"which differ in {differing[0]}. Say which one: segment=0 to {len(segments) - 1}."
        )


def body_and_reference(first: str, second: str, place: str) -> tuple[str, str, bool]:
    """Return the names of the body's and of the reference axes, of which one does not rotate and one is the body.

    The third is whether the body is the second one.
    """
    names = [axes_name(part) for part in (first, second)]
    inertial = [name in INERTIAL for name in names]
    turning = next((name for name in names if ROTATING.match(name) or ORBITAL.match(name)), None)
    if turning is not None or sum(inertial) != 1 or not all(re.fullmatch(r"[!-~]{1,80}", name) for name in names):
        given = f"{quoted(turning)}, which rotates" if turning else f"{quoted(first)} and {quoted(second)}"
        known = ", ".join(FRAMES)
        raise ValueError(f"{place} must be the body and a frame that does not rotate ({known}), got {given}.")
    body, reference = names[::-1] if inertial[0] else names
    return body, reference, inertial[0]


def times_of(rows: TextRows, calendar: Calendar | None) -> tuple[NDArray[np.float64], Calendar]:
    """Return the rising times of rows up to STOP_TIME, and the calendar: by default from the first, in seconds."""
    scale = rows.word("TIME_SYSTEM").upper()
    if scale not in SCALES:
        raise ValueError(f"TIME_SYSTEM in {rows.name} must be one of {', '.join(SCALES)}, got {quoted(scale)}.")
    try:
        calendar = Calendar(rows.epochs[0].removesuffix("Z"), scale) if calendar is None else calendar
    except ValueError as error:
        raise ValueError(f"{rows.places[0]}: {error}") from None
    times = _counted(calendar, rows.epochs, rows.places, scale)
    rows.check_rising(times)
    if times.size > 1:
        _check_span(rows, times, calendar)
    return times, calendar


def _check_span(rows: TextRows, times: NDArray[np.float64], calendar: Calendar) -> None:
    """Raise a ValueError unless the rows extend from START_TIME to STOP_TIME, but for the interval between two rows."""
    ends = (("START_TIME", "first", 0, times[0] - times[1]), ("STOP_TIME", "last", -1, times[-1] - times[-2]))
    for key, which, place, interval in ends:
        if (stated := stated_time(rows, key, calendar)) is None:
            continue
        missing = (stated - times[place]) / interval
        if missing > 1.0:
            raise ValueError(
                f"the rows of {rows.name} must reach {key} = {shortened(rows.metadata[key])}, got a {which} row of "
                f"{rows.epochs[place]}. The file is not whole."
            )
        if missing < -1.0:
            raise ValueError(
                f"the rows of {rows.name} must lie between START_TIME and STOP_TIME, got a {which} row of "
                f"{rows.epochs[place]}, and {key} = {shortened(rows.metadata[key])}."
            )


def stated_time(rows: TextRows, key: str, calendar: Calendar) -> float | None:
    """Return a time of the metadata, or None if they do not contain it."""
    epoch, places = rows.metadata.get(key), [f"{key} in {rows.name}"]
    return float(_counted(calendar, [epoch], places, rows.metadata["TIME_SYSTEM"].upper())[0]) if epoch else None


def _counted(calendar: Calendar, epochs: list[str], places: list[str], scale: str) -> NDArray[np.float64]:
    """Return the times of epochs; of several the first that is none is found by halves."""
    try:
        return np.asarray(calendar.time([f"{text.removesuffix('Z')} {scale}" for text in epochs]))
    except ValueError as error:
        if len(epochs) == 1:
            raise ValueError(f"{places[0]}: {error}") from None
    middle = len(epochs) // 2
    halves = (slice(middle), slice(middle, None))
    return np.concatenate([_counted(calendar, epochs[half], places[half], scale) for half in halves])


# ------------------------------------------------------------------ writing


def dates_of(calendar: Calendar, times: Any) -> tuple[list[str], str]:
    """Return the dates of times, to a nanosecond, and their time system."""
    instants = calendar.date(np.atleast_1d(times))
    instants.precision = 9
    dates = [str(date) for date in instants.isot]
    if len(set(dates)) != len(dates):
        raise ValueError("times must be a nanosecond apart or more in a file of dates, got two that are closer.")
    return dates, str(instants.scale).upper()


def word(name: str, text: Any) -> str:
    """Return a text that fits into one line of a message."""
    if not re.fullmatch(r"[ -~]*[!-~][ -~]*", text) or re.search(r"[\[\]<>&=]", text):
        raise ValueError(f"{name} must be printable characters without brackets, & and =, got {quoted(text)}.")
    return str(text.strip())


def digits(value: float) -> str:
    """Return a number with the sixteen digits that the standard allows."""
    return f"{value:.15e}"


def append_value(parent: ET.Element, key: str, value: str | float) -> None:
    """Append an element with a text, or with a number and its unit; components of quaternions are without units."""
    unit = "" if isinstance(value, str) or key.startswith("Q") else unit_of(key)
    ET.SubElement(parent, key, {"units": unit} if unit else {}).text = (
        value if isinstance(value, str) else digits(value)
    )


def write_message(
    path: str | Path,
    overwrite: bool,
    message: str,
    version: str,
    originator: str,
    metadata: Mapping[str, str | None],
    kvn: Callable[[list[str]], list[str]],
    xml: Callable[[], ET.Element],
) -> Path:
    """Write a message of one segment: in XML if its name ends so, in KVN otherwise; return its path.

    Metadata that are None are omitted. `kvn` returns the lines after the header from the lines of the metadata, and
    `xml` returns the element `data`.
    """
    if version not in SCHEMAS:
        raise ValueError(f"version must be '1.0' or '2.0', got {quoted(version)}.")
    now = dt.datetime.now(dt.UTC).strftime("%Y-%m-%dT%H:%M:%S")
    header = {"CREATION_DATE": now, "ORIGINATOR": word("originator", originator)}
    stated = {key: word(key, value) for key, value in metadata.items() if value is not None}
    if Path(path).suffix.lower() != ".xml":
        lines = [f"CCSDS_{message}_VERS = {version}", *(f"{key} = {value}" for key, value in header.items())]
        return write_text(
            path, "\n".join(lines + kvn([f"{key} = {value}" for key, value in stated.items()])) + "\n", overwrite
        )
    root = ET.Element(message.lower(), {"id": f"CCSDS_{message}_VERS", "version": version})
    root.set("xmlns:xsi", INSTANCE)
    root.set("xsi:noNamespaceSchemaLocation", f"https://sanaregistry.org/r/ndmxml_unqualified/{SCHEMAS[version]}")
    head, segment = ET.SubElement(root, "header"), ET.SubElement(ET.SubElement(root, "body"), "segment")
    for parent, entries in ((head, header), (ET.SubElement(segment, "metadata"), stated)):
        for key, value in entries.items():
            append_value(parent, key, value)
    segment.append(xml())
    ET.indent(root)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"
    return write_text(path, text, overwrite)
