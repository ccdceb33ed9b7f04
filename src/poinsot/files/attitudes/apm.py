"""CCSDS Attitude Parameter Messages (504.0-B), versions 1.0 and 2.0, in KVN and XML: one attitude, and the inertia."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_table import AttitudeTable, rates_per_second, table_of
from poinsot.files.ccsds import Entry
from poinsot.files.rows import Rows, number
from poinsot.files.untrusted import local_name, read_text
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.state import State
from poinsot.printable import quoted, shortened

__all__ = ["read_apm", "write_apm"]

FORMS = {"QUAT": "QUATERNION", "EULER": "EULER_ANGLE", "SPIN": "SPIN"}
"""Blocks that are an attitude, each with the type that a row of an ephemeris would have."""

XML_BLOCKS = {
    "quaternionState": "QUAT",
    "eulerAngleState": "EULER",
    "eulerElementsThree": "EULER",
    "angularVelocity": "ANGVEL",
    "spin": "SPIN",
    "eulerElementsSpin": "SPIN",
    "inertia": "INERTIA",
    "spacecraftParameters": "INERTIA",
    "maneuverParameters": "MAN",
}

V1_BLOCKS = (
    ("QUAT", re.compile(r"Q_(FRAME_[AB]|DIR)|Q[123C](_DOT)?")),
    ("EULER", re.compile(r"EULER_\w+|RATE_FRAME|[XYZ]_(ANGLE|RATE)")),
    ("SPIN", re.compile(r"SPIN_\w+|NUTATION\w*")),
    ("INERTIA", re.compile(r"INERTIA_REF_FRAME|I[123]{2}")),
    ("MAN", re.compile(r"MAN_\w+")),
)

TENSOR = {"IXX": (0, 0), "IYY": (1, 1), "IZZ": (2, 2), "IXY": (0, 1), "IXZ": (0, 2), "IYZ": (1, 2)}

TO_DIGITS, TO_LETTERS = str.maketrans("XYZ", "123"), str.maketrans("123", "XYZ")
"""Version 1 has I11 for IXX."""

V1_TENSOR = {key.translate(TO_DIGITS) for key in TENSOR}


class _Block(NamedTuple):
    """What one logical block says, by the keys of version 2; directions are always from A to B."""

    kind: str
    said: dict[str, Entry]
    place: str

    def text(self, key: str) -> str:
        if key not in self.said or not self.said[key].value:
            raise ValueError(f"{self.place} must have {key}, got none.")
        return self.said[key].value

    def number(self, key: str) -> float:
        return number(key, self.text(key), self.said[key].place)

    def frames(self) -> tuple[str, str]:
        return self.text("REF_FRAME_A"), self.text("REF_FRAME_B")


# ------------------------------------------------------------------ reading


@checked
def read_apm(path: str | Path, *, calendar: Calendar | None = None) -> tuple[AttitudeTable, Body | None]:
    """Return the attitude in a CCSDS Attitude Parameter Message (504.0-B), and the body if it says its inertia.

    `table.state(body)` is then the state from which a propagation starts. The attitude is that of the first block of
    quaternion, Euler angles or spin between the body and a frame that does not rotate; its rate is that of the block
    or of an ANGVEL block beside it. Manoeuvres and the rates of version 1 in Euler blocks are passed over.

    Parameters
    ----------
    path : str or Path
        KVN or XML, version 1 or 2.
    calendar : Calendar, optional
        Counts the times; default: from the epoch of the message, in seconds, in its time system.

    Returns
    -------
    AttitudeTable
        Of one row.
    Body or None
        With moments in kg m2 about the axes of the attitude; None if the inertia is missing or along other axes.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read; the file is no such message, has no attitude between the body and a frame that does
        not rotate, a quaternion is off unit norm by more than a thousandth, or no rigid body has the inertia; or
        astropy is missing.

    Examples
    --------
    >>> table, body = pt.files.read_apm("m.apm")
    >>> body, table.state(body).time
    (Body(moments=[1.25, 1.0, 0.75]), array(0.))
    """
    text, name = read_text(path), shortened(path)
    version, header, blocks = _of_xml(text, name) if ccsds.is_xml(text) else _of_kvn(text, name)
    epoch = _Block("", header, name)
    epoch.text("EPOCH")
    system = {"TIME_SYSTEM": epoch.text("TIME_SYSTEM")}
    times, calendar = ccsds.times_of(Rows(name, system, (), [header["EPOCH"].place], [header["EPOCH"].value]), calendar)
    block, (body_frame, frame, body_is_b) = _attitude_block(blocks, name)
    kind, columns, rate_in_a = _row(block, blocks)
    says = {key: entry.value for key, entry in block.said.items()}
    row = Rows(block.place, says, tuple(columns), [block.place], [""], [list(columns.values())])
    conventions = {"body_is_b": body_is_b, "rate_in_a": rate_in_a}
    frames = (frame, body_frame)
    table = adm.read_attitudes(row, kind, times, calendar, frames, **conventions, version=version)
    return table, _body(blocks, body_frame, version)


def _attitude_block(blocks: list[_Block], name: str) -> tuple[_Block, tuple[str, str, bool]]:
    reason = ValueError(f"{name} must have an attitude (quaternion, Euler angles or spin), got none.")
    for block in blocks:
        if block.kind in FORMS:
            try:
                return block, ccsds.body_and_reference(*block.frames(), block.place)
            except ValueError as error:
                reason = error
    raise reason


def _row(block: _Block, blocks: list[_Block]) -> tuple[str, dict[str, float], bool]:
    """Return the type and the columns of the row that an ephemeris would have, and whether its rate is along A."""
    form = FORMS[block.kind]
    kinds = [kind for kind in adm.COLUMNS if kind.startswith(f"{form}/") and not kind.endswith(("ANGVEL", "RATE"))]
    kind = next((kind for kind in kinds if all(key in block.said for key in adm.COLUMNS[kind])), form)
    columns = {key: block.number(key) for key in adm.COLUMNS[kind]}
    a, b = block.frames()
    beside = next((other for other in blocks if other.kind == "ANGVEL" and set(other.frames()) == {a, b}), None)
    if kind != form or form == "SPIN" or beside is None:
        return kind, columns, False
    along = beside.text("ANGVEL_FRAME")
    if along not in (a, b):
        raise ValueError(f"{beside.place} must have ANGVEL_FRAME {a} or {b}, got {quoted(along)}.")
    sign = 1 if beside.frames() == (a, b) else -1
    columns |= {key: sign * beside.number(key) for key in adm.ANGVEL}
    return f"{form}/ANGVEL", columns, along == a


def _body(blocks: list[_Block], body_frame: str, version: str) -> Body | None:
    """Return the body; version 1 gives the entries of the tensor, version 2 the products of inertia."""
    for block in blocks:
        if block.kind == "INERTIA" and block.text("INERTIA_REF_FRAME").upper() == body_frame:
            tensor = np.empty((3, 3))
            for key, (i, j) in TENSOR.items():
                tensor[i, j] = tensor[j, i] = block.number(key) * (1 if i == j or version < "2" else -1)
            try:
                return Body.from_inertia(tensor)
            except ValueError as error:
                raise ValueError(f"{block.place}: {error}") from None
    return None


# ------------------------------------------------------------------ KVN


def _of_kvn(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, lines = ccsds.opened_kvn(text, name, "APM")
    header: dict[str, Entry] = {}
    blocks: list[_Block] = []
    found: dict[str, list[Entry]] = {}
    rule = "KEY = VALUE" if version < "2" else "KEY = VALUE or the start of a block"
    for count, line in lines:
        match = re.fullmatch(r"(QUAT|EULER|ANGVEL|SPIN|INERTIA|MAN)_START", line)
        if match and version >= "2":
            said = ccsds.kvn_block(lines, name, count, f"{match[1]}_STOP")
            blocks.append(_Block(match[1], said, f"{name}, line {count}"))
            continue
        entry = ccsds.kvn_entry(line, f"{name}, line {count}", rule)
        kinds = (kind for kind, pattern in V1_BLOCKS if version < "2" and pattern.fullmatch(entry.key))
        if kind := next(kinds, None):
            found.setdefault(kind, []).append(entry)
        else:
            header[entry.key] = entry
    return version, header, blocks + [_from_v1(kind, entries) for kind, entries in found.items()]


def _from_v1(kind: str, entries: list[Entry]) -> _Block:
    """Return a block of version 1 by the keys of version 2."""
    said = {re.sub(r"^(Q|EULER|SPIN)_FRAME_", "REF_FRAME_", entry.key): entry for entry in entries}
    block = _Block(kind, said, entries[0].place)
    if kind == "INERTIA":
        renamed = {key.translate(TO_LETTERS) if key in V1_TENSOR else key: entry for key, entry in said.items()}
        return block._replace(said=renamed)
    if kind == "EULER":
        _number_angles(block, entries)
    if kind in FORMS:
        key = "Q_DIR" if kind == "QUAT" else f"{kind}_DIR"
        direction = block.text(key).upper()
        if direction not in ("A2B", "B2A"):
            raise ValueError(f"{said[key].place} must have {key} A2B or B2A, got {quoted(direction)}.")
        if direction == "B2A":
            block.frames()
            said["REF_FRAME_A"], said["REF_FRAME_B"] = said["REF_FRAME_B"], said["REF_FRAME_A"]
    return block


def _number_angles(block: _Block, entries: list[Entry]) -> None:
    """Name the angles X_ANGLE, Y_ANGLE, Z_ANGLE, which may come twice, by their place in the sequence."""
    given = [entry for entry in entries if re.fullmatch(r"[XYZ]_ANGLE", entry.key)]
    sequence = block.text("EULER_ROT_SEQ").upper().translate(TO_DIGITS)
    axes = "".join(entry.key[0] for entry in given).translate(TO_DIGITS)
    if given and axes != sequence:
        raise ValueError(f"{block.place} must have its angles in the order {quoted(sequence)}, got {quoted(axes)}.")
    block.said.update({f"ANGLE_{i}": entry for i, entry in enumerate(given, start=1)})


# ------------------------------------------------------------------ XML


def _of_xml(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, segments = ccsds.opened_xml(text, name, "APM")
    if len(segments) != 1:
        raise ValueError(f"{name} must hold one segment, got {len(segments)}.")
    header: dict[str, Entry] = {}
    blocks: list[_Block] = []
    for part in (child for half in segments[0] for child in half):
        kind, place = XML_BLOCKS.get(local_name(part)), f"{name}, {local_name(part)[:40]}"
        entries = list(ccsds.entries_of(part, place))
        said = {entry.key: entry for entry in entries}
        header |= {key: entry for key, entry in said.items() if kind is None or key == "EPOCH"}
        if kind and entries:
            blocks.append(_from_v1(kind, entries) if version < "2" else _Block(kind, said, place))
    return version, header, blocks


# ------------------------------------------------------------------ writing


@checked
def write_apm(
    body: Body,
    state: State,
    path: str | Path,
    *,
    calendar: Calendar,
    reference_frame: str,
    body_frame: str = "SC_BODY_1",
    object_name: str = "UNKNOWN",
    object_id: str = "UNKNOWN",
    center_name: str | None = None,
    originator: str = "POINSOT",
    version: str = "2.0",
    overwrite: bool = False,
) -> Path:
    """Write a body and its state as a CCSDS Attitude Parameter Message (504.0-B); return its path.

    Attitude and rate as `write_aem` writes them, and the inertia about the body axes.

    Parameters
    ----------
    body : Body
        With moments in kg m2.
    state : State
    path, version, overwrite, originator
        As of `write_aem`.
    calendar : Calendar
        What instant t = 0 is, and the unit of time.
    reference_frame : str
        The name of the space axes, such as "ICRF".
    body_frame, object_name, object_id, center_name : str

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is not what its name says, there are several members, or the file exists.

    Examples
    --------
    >>> body, calendar = pt.Body((5.0, 6.0, 7.0)), pt.Calendar("2026-11-21T00:00:00", "UTC")
    >>> state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0.1))
    >>> path = pt.files.write_apm(body, state, "new.apm", calendar=calendar, reference_frame="ICRF")
    >>> pt.files.read_apm(path)[0].omega_body.round(12).tolist()
    [[0.0, 0.0, 0.1]]
    """
    if state.quaternion.ndim > 1 or body.inertia.ndim > 2:
        raise ValueError("state must be one state of one body, got an ensemble.")
    row = AttitudeTable(state.time[None], state.quaternion[None], body.omega(state.angular_momentum_body)[None])
    table = table_of(row, calendar, reference_frame, body_frame)
    ccsds.body_and_reference(table.reference_frame, table.body_frame, "reference_frame and body_frame")
    (epoch,), system = ccsds.dates_of(calendar, table.times)
    metadata = {"OBJECT_NAME": object_name, "OBJECT_ID": object_id, "CENTER_NAME": center_name, "TIME_SYSTEM": system}
    blocks = _written_blocks(table, body.inertia, version)

    def kvn(said: list[str]) -> list[str]:
        lines = ["COMMENT x_A = q x_B q~ (Hamilton product), QC the scalar", *said, f"EPOCH = {epoch}"]
        for kind, block in blocks:
            numbers = {key: ccsds.digits(value) for key, value in block.items() if not isinstance(value, str)}
            units = {key: f" [{unit}]" for key in numbers if (unit := ccsds.unit_of(key))}
            inner = [f"{key} = {numbers.get(key, value)}{units.get(key, '')}" for key, value in block.items()]
            lines += inner if version < "2" else [f"{kind}_START", *inner, f"{kind}_STOP"]
        return lines

    return ccsds.write_message(
        path, overwrite, "APM", version, originator, metadata, kvn, lambda: _data(version, epoch, blocks)
    )


def _written_blocks(table: AttitudeTable, inertia: Any, version: str) -> list[tuple[str, dict[str, Any]]]:
    """Return the blocks with the keys of a version; rates per second."""
    q, omega = table.quaternion[0], np.asarray(rates_per_second(table, True))[0]
    quaternion = dict(zip(adm.QUATERNION, q[[1, 2, 3, 0]].tolist(), strict=True))
    tensor = {key: float(inertia[place]) for key, place in TENSOR.items()}
    a, b = table.reference_frame, table.body_frame
    if version < "2":
        dot = 0.5 * quat.product(q, quat.pure(omega))[[1, 2, 3, 0]]
        rate = dict(zip(adm.QUATERNION_DOT, dot.tolist(), strict=True))
        products = {key.translate(TO_DIGITS): value for key, value in tensor.items()}
        attitude = {"Q_FRAME_A": a, "Q_FRAME_B": b, "Q_DIR": "A2B"} | quaternion | rate
        return [("QUAT", attitude), ("INERTIA", {"INERTIA_REF_FRAME": b} | products)]
    frames = {"REF_FRAME_A": a, "REF_FRAME_B": b}
    rate = dict(zip(adm.ANGVEL, np.degrees(omega).tolist(), strict=True))
    products = {key: value if key[1] == key[2] else -value for key, value in tensor.items()}
    return [
        ("QUAT", frames | quaternion),
        ("ANGVEL", frames | {"ANGVEL_FRAME": b} | rate),
        ("INERTIA", {"INERTIA_REF_FRAME": b} | products),
    ]


def _data(version: str, epoch: str, blocks: list[tuple[str, dict[str, Any]]]) -> ET.Element:
    data = ET.Element("data")
    if version >= "2":
        ccsds.element(data, "EPOCH", epoch)
    tags = {"QUAT": "quaternionState", "ANGVEL": "angularVelocity"}
    tags["INERTIA"] = "spacecraftParameters" if version < "2" else "inertia"
    for kind, said in blocks:
        block = ET.SubElement(data, tags[kind])
        if version < "2" and kind == "QUAT":
            ccsds.element(block, "EPOCH", epoch)
        for group, keys in _groups(said, version):
            parent = ET.SubElement(block, group) if group else block
            for key in keys:
                unit = ccsds.unit_of(key) if not key.startswith("Q") else ""
                ccsds.element(parent, key, said[key], **({"units": unit} if unit else {}))
    return data


def _groups(said: dict[str, Any], version: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the keys of a block, those of the quaternion and its derivative under elements of their own."""
    yield "", tuple(key for key in said if key not in adm.QUATERNION + adm.QUATERNION_DOT)
    for group, keys in (("quaternion", adm.QUATERNION), ("quaternionRate", adm.QUATERNION_DOT)):
        if keys[0] in said:
            yield group, ccsds.xml_order(keys, version)
