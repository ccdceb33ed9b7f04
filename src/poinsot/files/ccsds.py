"""Shared by the CCSDS messages: KEY = VALUE lines, frames, time systems, epochs, headers."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from poinsot.files.untrusted import local_name, parsed_xml
from poinsot.mechanics.calendar import SCALES, Calendar

__all__ = [
    "FRAMES",
    "ROTATING",
    "Entry",
    "body_and_reference",
    "dates_of",
    "digits",
    "entries_of",
    "entry",
    "header_entries",
    "kvn_entry",
    "kvn_lines",
    "kvn_metadata",
    "metadata_entries",
    "number",
    "one_message",
    "opened_kvn",
    "opened_xml",
    "times_of",
    "unit_of",
    "word",
    "xml_order",
    "xml_text",
]

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

MOST = 1e15
"""Of any number in a file of attitudes."""

UNITS = (
    (re.compile(r"Q[123C]|EPOCH"), ""),
    (re.compile(r"Q[123C]_DOT"), "1/s"),
    (re.compile(r"ANGLE_[123]_DOT|ANGVEL_[XYZ]|SPIN_ANGLE_VEL|NUTATION_VEL|RATE_[123]|[XYZ]_RATE"), "deg/s"),
    (re.compile(r"ANGLE_[123]|[XYZ]_ANGLE|SPIN_(ALPHA|DELTA|ANGLE)|NUTATION(_PHASE)?|MOMENTUM_\w+"), "deg"),
    (re.compile(r"NUTATION_PER"), "s"),
    (re.compile(r"I(XX|YY|ZZ|XY|XZ|YZ|11|22|33|12|13|23)"), "kg*m**2"),
)

ROTATIONS = {"rotationAngles": "ANGLE", "rotationRates": "RATE"}
"""Elements of version 1, whose parts are rotation1, rotation2, rotation3."""

VERSIONS = ("1.0", "2.0")

SCHEMAS = {"1.0": "ndmxml-1.0-master.xsd", "2.0": "ndmxml-4.0.0-master-4.0.xsd"}

INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"


class Entry(NamedTuple):
    """KEY = VALUE, and where in the file it is."""

    key: str
    value: str
    place: str


# ------------------------------------------------------------------ reading


def opened_kvn(text: str, name: str, message: str) -> tuple[str, Iterator[tuple[int, str]]]:
    """Return the version of a message in KVN and its other lines with their numbers, without comments."""
    lines = kvn_lines(text)
    _, opening = next(lines, (0, ""))
    match = re.fullmatch(rf"CCSDS_{message}_VERS\s*=\s*([12])(\.\d+)?", opening)
    if match is None:
        raise ValueError(
            f"{name} must begin with CCSDS_{message}_VERS = 1.0 or 2.0, but it begins with {opening[:60]!r}."
        )
    return f"{match[1]}.0", lines


def kvn_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines that say something, each after its number."""
    for count, line in enumerate(text.splitlines(), start=1):
        line = line.strip()
        if line and not re.match(r"COMMENT\b", line):
            yield count, line


def kvn_entry(line: str, place: str, rule: str) -> Entry:
    """Return KEY = VALUE [unit], the unit checked and taken away."""
    key, equals, value = line.partition("=")
    key, value = key.strip(), value.strip()
    if not equals or not re.fullmatch(r"\w+", key, re.ASCII):
        raise ValueError(f"{place} must be {rule}, got {line[:60]!r}.")
    match = re.fullmatch(r"(.*?)\s*\[(.*)\]", value)
    if match:
        value = match[1]
        _check_unit(key, match[2], place)
    return Entry(key, value, place)


def kvn_metadata(lines: Iterator[tuple[int, str]], name: str, begin: int) -> dict[str, str]:
    """Return what the lines up to META_STOP say."""
    says: dict[str, str] = {}
    for count, line in lines:
        if line == "META_STOP":
            return says
        said = kvn_entry(line, f"{name}, line {count}", "KEY = VALUE or META_STOP")
        says[said.key] = said.value
    raise ValueError(f"{name}, line {begin} must be followed by META_STOP, but the file ends.")


def opened_xml(text: str, name: str, message: str) -> tuple[str, list[ET.Element]]:
    """Return the version of the one message of a kind in XML, and its segments."""
    root = one_message(text, name, message.lower())
    version = root.get("version", "")
    if not re.fullmatch(r"[12](\.\d+)?", version):
        raise ValueError(f"{name} must be of version 1.0 or 2.0, but it says {version[:20]!r}.")
    return f"{version[0]}.0", [part for part in root.iter() if local_name(part) == "segment"]


def one_message(text: str, name: str, tag: str) -> ET.Element:
    """Return the one element of a tag in a text in XML."""
    messages = [part for part in parsed_xml(text, name).iter() if local_name(part) == tag]
    if len(messages) != 1:
        raise ValueError(f"{name} must hold one {tag} element, but it holds {len(messages)}.")
    return messages[0]


def entries_of(element: ET.Element, place: str) -> Iterator[Entry]:
    """Yield the leaves of an element, with their units checked; the rotations of version 1 as ANGLE_i and RATE_i."""
    for part in element.iter():
        kind = ROTATIONS.get(local_name(part))
        leaves = [(f"{kind}_{i}", leaf) for i, leaf in enumerate(part, start=1)] if kind else [(local_name(part), part)]
        for key, leaf in leaves:
            if len(leaf) == 0 and not key.startswith("rotation"):
                if leaf.get("units"):
                    _check_unit(key, leaf.get("units", ""), place)
                yield Entry(key, (leaf.text or "").strip(), place)


def _check_unit(key: str, unit: str, place: str) -> None:
    """Refuse a unit that is said and is not the one of the standard."""
    right = unit_of(key)
    if unit and right is not None and unit.strip().lower() not in ((right,) if right else ("", "n/a")):
        raise ValueError(f"{place} must have {key} in {right or 'no unit'}, but it is in {unit[:20]!r}.")


def unit_of(key: str) -> str | None:
    """Return the unit of a key in the standard, "" if it has none, None if the key is not known."""
    return next((unit for pattern, unit in UNITS if pattern.fullmatch(key)), None)


def number(said: Entry) -> float:
    """Return a value as a number of sensible size."""
    try:
        value = float(said.value)
    except ValueError:
        value = np.inf
    if not abs(value) < MOST:
        raise ValueError(f"{said.place} must have a number for {said.key}, got {said.value[:60]!r}.")
    return value


def body_and_reference(first: str, second: str, place: str) -> tuple[str, str, bool]:
    """Return the names of the body's and of the reference axes, of which one does not rotate and one is the body.

    The third is whether the body is the second one.
    """
    names = [part.strip().upper().replace(" ", "") for part in (first, second)]
    inertial = [name in FRAMES for name in names]
    turning = next((name for name in names if ROTATING.match(name) or ORBITAL.match(name)), None)
    if turning is not None or sum(inertial) != 1 or not all(re.fullmatch(r"[!-~]{1,80}", name) for name in names):
        given = f"{turning[:40]} rotates" if turning else f"{first[:40]!r} and {second[:40]!r}"
        raise ValueError(
            f"{place} must lead between the body and a frame that does not rotate ({', '.join(FRAMES)}), but {given}."
        )
    body_second = inertial[0]
    body, reference = (names[1], names[0]) if body_second else (names[0], names[1])
    return body, FRAMES[reference], body_second


def times_of(
    epochs: list[str], places: list[str], system: str, calendar: Calendar | None, name: str
) -> tuple[NDArray[np.float64], Calendar]:
    """Return the times of epochs, and the calendar that counts them: by default from the first one, in seconds."""
    scale = system.upper()
    if scale not in SCALES:
        raise ValueError(f"TIME_SYSTEM in {name} must be one of {', '.join(SCALES)}, but it is {system[:40]!r}.")
    if calendar is not None and not isinstance(calendar, Calendar):
        raise TypeError(f"calendar must be a Calendar, got {type(calendar).__name__}.")
    try:
        calendar = Calendar(epochs[0].removesuffix("Z"), scale) if calendar is None else calendar
        return np.asarray(calendar.time([_epoch(text, scale) for text in epochs])), calendar
    except ValueError as error:
        place, reason = _first_wrong(epochs, places, scale, calendar) or (places[0], error)
        raise ValueError(f"{place}: {reason}") from None


def _first_wrong(
    epochs: list[str], places: list[str], scale: str, calendar: Calendar | None
) -> tuple[str, ValueError] | None:
    """Return the place of the first epoch that is none, found by halves, and what is wrong with it."""
    clock, low, high = calendar or Calendar("2000-01-01", "TT"), 0, len(epochs)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _wrong(clock, epochs[low:middle], scale) else (middle, high)
    error = _wrong(clock, epochs[low:high], scale)
    return None if error is None else (places[low], error)


def _wrong(calendar: Calendar, epochs: list[str], scale: str) -> ValueError | None:
    try:
        calendar.time([_epoch(text, scale) for text in epochs])
    except ValueError as error:
        return error
    return None


def _epoch(text: str, scale: str) -> str:
    return f"{text.removesuffix('Z')} {scale}"


# ------------------------------------------------------------------ writing


def dates_of(calendar: Calendar, times: Any) -> tuple[list[str], str]:
    """Return the dates of times, to a nanosecond, and their time system."""
    instants = calendar.date(np.atleast_1d(times))
    instants.precision = 9
    dates = [str(date) for date in instants.isot]
    if len(set(dates)) != len(dates):
        raise ValueError("times must be a nanosecond apart or more in a file of dates, but two of them are closer.")
    return dates, str(instants.scale).upper()


def header_entries(message: str, version: str, originator: str) -> list[tuple[str, str]]:
    """Return the header of a message."""
    if version not in VERSIONS:
        raise ValueError(f"version must be '1.0' or '2.0', got {version!r}.")
    now = dt.datetime.now(dt.UTC).strftime("%Y-%m-%dT%H:%M:%S")
    return [(f"CCSDS_{message}_VERS", version), ("CREATION_DATE", now), ("ORIGINATOR", word("originator", originator))]


def word(name: str, text: Any) -> str:
    """Return a text that fits into one line of a message."""
    if not isinstance(text, str) or not re.fullmatch(r"[ -~]*[!-~][ -~]*", text) or re.search(r"[\[\]<>&=]", text):
        raise ValueError(f"{name} must be printable characters without brackets, & and =, got {text!r}.")
    return text.strip()


def digits(value: float) -> str:
    """Return a number with the sixteen digits that the standard allows."""
    return f"{value:.15e}"


def entry(parent: ET.Element, key: str, value: str | float, **attributes: str) -> ET.Element:
    """Append an element with a text or a number."""
    element = ET.SubElement(parent, key, attributes)
    element.text = value if isinstance(value, str) else digits(value)
    return element


def xml_text(message: str, version: str, header: Iterable[tuple[str, str]], segment: ET.Element) -> str:
    """Return a message of one segment as a text in XML."""
    root = ET.Element(message.lower(), {"id": f"CCSDS_{message}_VERS", "version": version})
    root.set("xmlns:xsi", INSTANCE)
    root.set("xsi:noNamespaceSchemaLocation", f"https://sanaregistry.org/r/ndmxml_unqualified/{SCHEMAS[version]}")
    head = ET.SubElement(root, "header")
    for key, value in list(header)[1:]:
        entry(head, key, value)
    ET.SubElement(root, "body").append(segment)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def metadata_entries(fields: Mapping[str, str | None]) -> list[tuple[str, str]]:
    """Return the metadata that are said."""
    return [(key, word(key, value)) for key, value in fields.items() if value is not None]


def xml_order(keys: tuple[str, ...], version: str) -> tuple[str, ...]:
    """Return the components of a quaternion in the order of the schema: version 1 has the scalar first."""
    return (keys[-1], *keys[:-1]) if version < "2" and keys[-1].startswith("QC") else keys
