"""CCSDS Attitude Parameter Messages (504.0-B), versions 1.0 and 2.0, in KVN and XML: one attitude, and the inertia."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_table import AttitudeTable, rates_per_second, table_of
from poinsot.files.ccsds import Entry
from poinsot.files.untrusted import local_name, read_text
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import SECONDS, Calendar
from poinsot.mechanics.parameters import described
from poinsot.mechanics.state import State

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

TENSOR = (("IXX", "IXY", "IXZ"), ("IXY", "IYY", "IYZ"), ("IXZ", "IYZ", "IZZ"))


class _Block(NamedTuple):
    """What one logical block says, by the keys of version 2; directions are always from A to B."""

    kind: str
    said: dict[str, Entry]
    place: str

    def text(self, key: str) -> str:
        if not self.said.get(key, Entry(key, "", "")).value:
            raise ValueError(f"{self.place} must have {key}, but it has none.")
        return self.said[key].value

    def number(self, key: str) -> float:
        self.text(key)
        return ccsds.number(self.said[key])

    def frames(self) -> tuple[str, str]:
        return self.text("REF_FRAME_A"), self.text("REF_FRAME_B")


# ------------------------------------------------------------------ reading


@checked
def read_apm(path: str | Path, *, calendar: Calendar | None = None) -> tuple[AttitudeTable, Body | None]:
    """Return the attitude in a CCSDS Attitude Parameter Message, as a table of one row, and the body if it says one.

    `table.state(body)` is then the state from which a propagation starts. The attitude is that of the first block of
    quaternion, Euler angles or spin between the body and a frame that does not rotate; its rate is that of the block
    or of an ANGVEL block beside it. Manoeuvres and the rates of version 1 in Euler blocks are passed over.

    Parameters
    ----------
    path : str or Path
    calendar : Calendar, optional
        Counts the times; default: from the epoch of the message, in seconds, in its time system.

    Returns
    -------
    AttitudeTable
    Body or None
        With moments in kg m2 about the axes of the attitude; None if the inertia is missing or along other axes.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is no such message, has no attitude between the body and a frame that does not rotate, a
        quaternion is off unit norm by more than a thousandth, or no rigid body has the inertia.
    ImportError
        If astropy is missing.
    """
    name, text = str(path), read_text(path)
    read = _of_xml if text.lstrip().startswith("<") else _of_kvn
    version, header, blocks = read(text, name)
    for key in ("EPOCH", "TIME_SYSTEM"):
        if key not in header:
            raise ValueError(f"{name} must have {key}, but it has none.")
    epoch = header["EPOCH"]
    times, calendar = ccsds.times_of([epoch.value], [epoch.place], header["TIME_SYSTEM"].value, calendar, name)
    block, body_frame, frame, body_is_b = _attitude_block(blocks, name)
    kind, columns, rate_in_a = _row(block, blocks)
    q, omega, norm_error = adm.attitude_of(
        kind,
        {key: np.array([value]) for key, value in columns.items()},
        adm.sequence_of(block.text("EULER_ROT_SEQ"), block.place) if block.kind == "EULER" else None,
        rate_in_a=rate_in_a,
        body_is_b=body_is_b,
        version=version,
        places=[block.place],
    )
    omega = None if omega is None else omega * SECONDS[calendar.unit]
    table = AttitudeTable(times, q, omega, calendar, frame, body_frame, norm_error)
    return table, _body(blocks, body_frame, version)


def _attitude_block(blocks: list[_Block], name: str) -> tuple[_Block, str, str, bool]:
    reason = ValueError(f"{name} must have an attitude (quaternion, Euler angles or spin), but it has none.")
    for block in blocks:
        if block.kind in FORMS:
            try:
                return (block, *ccsds.body_and_reference(*block.frames(), block.place))
            except ValueError as error:
                reason = error
    raise reason


def _row(block: _Block, blocks: list[_Block]) -> tuple[str, dict[str, float], bool]:
    """Return the type and the columns of the row that an ephemeris would have, and whether its rate is along A."""
    form = FORMS[block.kind]
    kinds = [kind for kind in adm.COLUMNS if kind.startswith(f"{form}/") and not kind.endswith(("ANGVEL", "RATE"))]
    kind = next((kind for kind in kinds if all(key in block.said for key in adm.COLUMNS[kind])), form)
    columns = {key: block.number(key) for key in adm.COLUMNS[kind]}
    if "NUTATION_PER" in columns:
        adm.checked_period(columns["NUTATION_PER"], block.place)
    a, b = block.frames()
    beside = next((other for other in blocks if other.kind == "ANGVEL" and set(other.frames()) == {a, b}), None)
    if kind != form or form == "SPIN" or beside is None:
        return kind, columns, False
    along = beside.text("ANGVEL_FRAME")
    if along not in (a, b):
        raise ValueError(f"{beside.place} must have ANGVEL_FRAME {a} or {b}, but it is {along[:40]!r}.")
    sign = 1 if beside.frames() == (a, b) else -1
    columns |= {key: sign * beside.number(key) for key in adm.ANGVEL}
    return f"{form}/ANGVEL", columns, along == a


def _body(blocks: list[_Block], body_frame: str, version: str) -> Body | None:
    """Return the body; version 1 gives the entries of the tensor, version 2 the products of inertia."""
    for block in blocks:
        if block.kind == "INERTIA" and block.text("INERTIA_REF_FRAME").upper() == body_frame:
            across = 1 if version < "2" else -1
            tensor = [[(1 if i == j else across) * block.number(TENSOR[i][j]) for j in range(3)] for i in range(3)]
            try:
                return Body.from_inertia(tensor)
            except ValueError as error:
                raise ValueError(f"{block.place}: {error}") from None
    return None


# ------------------------------------------------------------------ KVN


def _of_kvn(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, lines = ccsds.opened_kvn(text, name, "APM")
    return version, *(_blocks_of_v1(lines, name) if version < "2" else _blocks_of_v2(lines, name))


def _blocks_of_v2(lines: Iterator[tuple[int, str]], name: str) -> tuple[dict[str, Entry], list[_Block]]:
    header: dict[str, Entry] = {}
    blocks: list[_Block] = []
    for count, line in lines:
        place = f"{name}, line {count}"
        match = re.fullmatch(r"(QUAT|EULER|ANGVEL|SPIN|INERTIA|MAN)_START", line)
        if match:
            blocks.append(_Block(match[1], _inside(lines, match[1], place), place))
        else:
            said = ccsds.kvn_entry(line, place, "KEY = VALUE or the start of a block")
            header[said.key] = said
    return header, blocks


def _inside(lines: Iterator[tuple[int, str]], kind: str, begin: str) -> dict[str, Entry]:
    said: dict[str, Entry] = {}
    for count, line in lines:
        if line == f"{kind}_STOP":
            return said
        place = f"{begin.rpartition(', line ')[0]}, line {count}"
        entry = ccsds.kvn_entry(line, place, f"KEY = VALUE or {kind}_STOP")
        said[entry.key] = entry
    raise ValueError(f"{begin} must be followed by {kind}_STOP, but the file ends.")


def _blocks_of_v1(lines: Iterator[tuple[int, str]], name: str) -> tuple[dict[str, Entry], list[_Block]]:
    header: dict[str, Entry] = {}
    found: dict[str, list[Entry]] = {}
    for count, line in lines:
        said = ccsds.kvn_entry(line, f"{name}, line {count}", "KEY = VALUE")
        kind = next((kind for kind, pattern in V1_BLOCKS if pattern.fullmatch(said.key)), None)
        if kind is None:
            header[said.key] = said
        else:
            found.setdefault(kind, []).append(said)
    return header, [_from_v1(kind, entries) for kind, entries in found.items()]


def _from_v1(kind: str, entries: list[Entry]) -> _Block:
    """Return a block of version 1 by the keys of version 2."""
    said = {re.sub(r"^(Q|EULER|SPIN)_FRAME_", "REF_FRAME_", entry.key): entry for entry in entries}
    block = _Block(kind, said, entries[0].place)
    if kind == "INERTIA":
        return block._replace(said={_inertia_key(key): entry for key, entry in said.items()})
    if kind == "EULER":
        _number_angles(block, entries)
    if kind in FORMS:
        key = {"QUAT": "Q_DIR"}.get(kind, f"{kind}_DIR")
        direction = block.text(key).upper()
        if direction not in ("A2B", "B2A"):
            raise ValueError(f"{said[key].place} must have {key} A2B or B2A, but it is {direction[:20]!r}.")
        if direction == "B2A":
            block.frames()
            said["REF_FRAME_A"], said["REF_FRAME_B"] = said["REF_FRAME_B"], said["REF_FRAME_A"]
    return block


def _number_angles(block: _Block, entries: list[Entry]) -> None:
    """Name the angles X_ANGLE, Y_ANGLE, Z_ANGLE, which may come twice, by their place in the sequence."""
    given = [entry for entry in entries if re.fullmatch(r"[XYZ]_ANGLE", entry.key)]
    if not given:
        return
    sequence = adm.sequence_of(block.text("EULER_ROT_SEQ"), block.place)
    axes = "".join(str("XYZ".index(entry.key[0]) + 1) for entry in given)
    if axes != sequence:
        raise ValueError(f"{block.place} must have its angles in the order {sequence}, but they come as {axes[:20]}.")
    block.said.update({f"ANGLE_{i}": entry for i, entry in enumerate(given, start=1)})


def _inertia_key(key: str) -> str:
    return f"I{key[1:].translate(str.maketrans('123', 'XYZ'))}" if re.fullmatch(r"I[123]{2}", key) else key


# ------------------------------------------------------------------ XML


def _of_xml(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, segments = ccsds.opened_xml(text, name, "APM")
    if len(segments) != 1:
        raise ValueError(f"{name} must hold one segment, but it holds {len(segments)}.")
    header: dict[str, Entry] = {}
    blocks: list[_Block] = []
    for part in (child for half in segments[0] for child in half):
        kind = XML_BLOCKS.get(local_name(part))
        place = f"{name}, {local_name(part)[:40]}"
        entries = list(ccsds.entries_of(part, place))
        header |= {entry.key: entry for entry in entries if kind is None or entry.key == "EPOCH"}
        if kind and entries:
            said = {entry.key: entry for entry in entries}
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
    """Write a body and its state as a CCSDS Attitude Parameter Message; return its path.

    Attitude and rate as `write_aem` writes them, and the inertia about the body axes.

    Parameters
    ----------
    body : Body
        With moments in kg m2.
    state : State
    path : str or Path
        XML if it ends in .xml, KVN otherwise.
    calendar : Calendar
        What instant t = 0 is, and the unit of time.
    reference_frame : str
        The name of the space axes, such as "ICRF".
    body_frame, object_name, object_id, center_name, originator : str
    version : {"2.0", "1.0"}
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is not what its name says, there are several members, or the file exists.
    """
    table = _one_row(body, state, calendar, reference_frame, body_frame)
    header = ccsds.header_entries("APM", version, originator)
    ccsds.body_and_reference(table.reference_frame, table.body_frame, "reference_frame and body_frame")
    dates, system = ccsds.dates_of(calendar, table.times)
    metadata = ccsds.metadata_entries(
        {"OBJECT_NAME": object_name, "OBJECT_ID": object_id, "CENTER_NAME": center_name, "TIME_SYSTEM": system}
    )
    blocks = _written_blocks(table, body.inertia, version)
    written = _as_xml if Path(path).suffix.lower() == ".xml" else _as_kvn
    return write_text(path, written(version, header, metadata, dates[0], blocks), overwrite)


def _one_row(body: Any, state: Any, calendar: Any, reference_frame: Any, body_frame: str) -> AttitudeTable:
    for name, value, kind in (("body", body, Body), ("state", state, State)):
        if not isinstance(value, kind):
            raise TypeError(
                f"{name} must be a {kind.__name__}, got {described(value)}. The order is write_apm(body, state, path)."
            )
    if state.quaternion.ndim > 1 or body.inertia.ndim > 2:
        raise ValueError("state must be one state of one body, got an ensemble.")
    omega = body.omega(state.angular_momentum_body)
    row = AttitudeTable(state.time[None], state.quaternion[None], omega[None])
    return table_of(row, calendar, reference_frame, body_frame)


def _written_blocks(table: AttitudeTable, inertia: Any, version: str) -> list[tuple[str, dict[str, Any]]]:
    """Return the blocks with the keys of a version; rates per second."""
    q, omega = table.quaternion[0], np.asarray(rates_per_second(table, True))[0]
    quaternion = dict(zip(adm.QUATERNION, map(float, q[[1, 2, 3, 0]]), strict=True))
    frames = {"REF_FRAME_A": table.reference_frame, "REF_FRAME_B": table.body_frame}
    tensor = {TENSOR[i][j]: float(inertia[i, j]) for i in range(3) for j in range(i, 3)}
    if version < "2":
        dot = 0.5 * quat.product(q, quat.pure(omega))[[1, 2, 3, 0]]
        rate = {f"{key}_DOT": float(value) for key, value in zip(adm.QUATERNION, dot, strict=True)}
        named = {"Q_FRAME_A": table.reference_frame, "Q_FRAME_B": table.body_frame, "Q_DIR": "A2B"}
        products = {f"I{key[1:].translate(str.maketrans('XYZ', '123'))}": value for key, value in tensor.items()}
        ordered = {key: products[key] for key in ("I11", "I22", "I33", "I12", "I13", "I23")}
        return [("QUAT", named | quaternion | rate), ("INERTIA", {"INERTIA_REF_FRAME": table.body_frame} | ordered)]
    rate = dict(zip(adm.ANGVEL, map(float, np.degrees(omega)), strict=True))
    products = {key: value if key[1] == key[2] else -value for key, value in tensor.items()}
    ordered = {key: products[key] for key in ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")}
    return [
        ("QUAT", frames | quaternion),
        ("ANGVEL", frames | {"ANGVEL_FRAME": table.body_frame} | rate),
        ("INERTIA", {"INERTIA_REF_FRAME": table.body_frame} | ordered),
    ]


def _as_kvn(version: str, header: Any, metadata: Any, epoch: str, blocks: list[tuple[str, dict[str, Any]]]) -> str:
    lines = [f"{key} = {value}" for key, value in header]
    lines += [
        "COMMENT x_A = q x_B q~ (Hamilton product), QC the scalar",
        *(f"{key} = {value}" for key, value in metadata),
    ]
    lines += [f"EPOCH = {epoch}"]
    for kind, said in blocks:
        inner = [
            f"{key} = {value if isinstance(value, str) else _with_unit(key, value)}" for key, value in said.items()
        ]
        lines += inner if version < "2" else [f"{kind}_START", *inner, f"{kind}_STOP"]
    return "\n".join(lines) + "\n"


def _with_unit(key: str, value: float) -> str:
    unit = ccsds.unit_of(key)
    return f"{ccsds.digits(value)} [{unit}]" if unit else ccsds.digits(value)


def _as_xml(version: str, header: Any, metadata: Any, epoch: str, blocks: list[tuple[str, dict[str, Any]]]) -> str:
    segment = ET.Element("segment")
    about, data = ET.SubElement(segment, "metadata"), ET.SubElement(segment, "data")
    for key, value in metadata:
        ccsds.entry(about, key, value)
    if version >= "2":
        ccsds.entry(data, "EPOCH", epoch)
    tags = {"QUAT": "quaternionState", "ANGVEL": "angularVelocity"}
    tags["INERTIA"] = "spacecraftParameters" if version < "2" else "inertia"
    for kind, said in blocks:
        block = ET.SubElement(data, tags[kind])
        if version < "2" and kind == "QUAT":
            ccsds.entry(block, "EPOCH", epoch)
        for group, keys in _groups(said, version):
            parent = ET.SubElement(block, group) if group else block
            for key in keys:
                unit = ccsds.unit_of(key) if not key.startswith("Q") else ""
                ccsds.entry(parent, key, said[key], **({"units": unit} if unit else {}))
    return ccsds.xml_text("APM", version, header, segment)


def _groups(said: dict[str, Any], version: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the keys of a block, those of the quaternion and its derivative under elements of their own."""
    yield "", tuple(key for key in said if not re.fullmatch(r"Q[123C](_DOT)?", key))
    for group, pattern in (("quaternion", r"Q[123C]"), ("quaternionRate", r"Q[123C]_DOT")):
        keys = tuple(key for key in said if re.fullmatch(pattern, key))
        if keys:
            yield group, ccsds.xml_order(keys, version)
