"""CCSDS Attitude Parameter Messages (504.0-B), versions 1.0 and 2.0, in KVN and XML: one attitude, and the inertia."""

from __future__ import annotations

import dataclasses
import re
import warnings
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.errors import level_of_user
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_table import AttitudeTable, calendar_of, rates_per_second, table_of
from poinsot.files.keys import Entry, Keys
from poinsot.files.rows import TextRows, number
from poinsot.files.untrusted import local_name, read_text
from poinsot.kinematics.attitude import rotation_angle
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.printable import quoted, shortened
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar

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

HEADER = ("TIME_SYSTEM", "EPOCH")
ABOUT = (*ccsds.HEADER, "OBJECT_NAME", "OBJECT_ID", "CENTER_NAME")

FRAMES = ("REF_FRAME_A", "REF_FRAME_B")
SPIN = tuple(sorted({key for kind, keys in adm.COLUMNS.items() if kind.startswith("SPIN") for key in keys}))

V2_KEYS = {
    "QUAT": (*FRAMES, *adm.COLUMNS["QUATERNION/DERIVATIVE"]),
    "EULER": (*FRAMES, "EULER_ROT_SEQ", *adm.COLUMNS["EULER_ANGLE/DERIVATIVE"]),
    "ANGVEL": (*FRAMES, "ANGVEL_FRAME", *adm.ANGVEL),
    "SPIN": (*FRAMES, *SPIN),
    "INERTIA": ("INERTIA_REF_FRAME", "IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"),
    "MAN": (),
}
"""Keys of the blocks of version 2."""

V1_KEYS = {
    "QUAT": ("Q_FRAME_A", "Q_FRAME_B", "Q_DIR", *V2_KEYS["QUAT"][2:]),
    "EULER": ("EULER_FRAME_A", "EULER_FRAME_B", "EULER_DIR", "EULER_ROT_SEQ", *adm.ANGLES),
    "SPIN": ("SPIN_FRAME_A", "SPIN_FRAME_B", "SPIN_DIR", *adm.COLUMNS["SPIN/NUTATION"]),
    "INERTIA": ("INERTIA_REF_FRAME", "I11", "I22", "I33", "I12", "I13", "I23"),
    "MAN": (),
}
"""Keys of the blocks of version 1, which name their blocks."""

AXIS_ANGLES, AXIS_RATES = ("X_ANGLE", "Y_ANGLE", "Z_ANGLE"), ("X_RATE", "Y_RATE", "Z_RATE")
"""Keys of version 1 that come twice in a sequence such as 313."""

MANEUVERS = (
    *("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME", "MAN_TOR_X", "MAN_TOR_Y", "MAN_TOR_Z", "MAN_DELTA_MASS"),
    *("MAN_TOR_1", "MAN_TOR_2", "MAN_TOR_3"),
)

USED = frozenset(key for keys in (*V1_KEYS.values(), *V2_KEYS.values(), AXIS_ANGLES, HEADER) for key in keys)
"""Keys with an influence on the result, in some block of some version."""

SAME_ATTITUDE, SAME_RATE = 1e-3, 1e-2
"""Radians, and relative: blocks with few digits that state one attitude and one angular velocity."""

TENSOR = {"IXX": (0, 0), "IYY": (1, 1), "IZZ": (2, 2), "IXY": (0, 1), "IXZ": (0, 2), "IYZ": (1, 2)}

TO_DIGITS, TO_LETTERS = str.maketrans("XYZ", "123"), str.maketrans("123", "XYZ")
"""Version 1 has I11 for IXX."""

V1_TENSOR = {key.translate(TO_DIGITS) for key in TENSOR}


class _Block(NamedTuple):
    """Logical block with the keys of version 2. Its direction is from A to B."""

    kind: str
    found: dict[str, Entry]
    place: str

    def text(self, key: str) -> str:
        if key not in self.found or not self.found[key].value:
            raise ValueError(f"{self.place} must have {key}, got none.")
        return self.found[key].value

    def number(self, key: str) -> float:
        return number(key, self.text(key), self.found[key].place)

    def frames(self) -> tuple[str, str, bool]:
        """Return the names of the body's and of the reference axes, and whether the body is B."""
        return ccsds.body_and_reference(self.text("REF_FRAME_A"), self.text("REF_FRAME_B"), self.place)


class _Attitude(NamedTuple):
    """The attitude of one block, with its angular velocity if the block has one."""

    block: _Block
    table: AttitudeTable

    @property
    def is_whole(self) -> bool:
        """True if the angular velocity has all components. SPIN without nutation states one along its axis."""
        return self.block.kind != "SPIN" or "NUTATION_VEL" in self.block.found or "NUTATION_PER" in self.block.found


# ------------------------------------------------------------------ reading


@checked
def read_apm(path: str | Path, *, calendar: Calendar | None = None) -> tuple[AttitudeTable, Body | None]:
    """Return the attitude in a CCSDS Attitude Parameter Message (504.0-B), and the body if it contains its inertia.

    `table.state(body)` is then the initial state of a propagation. The attitude is read from the first block of
    quaternion, Euler angles or spin between the body and an inertial frame. The angular velocity is read from the same
    block, from an ANGVEL block, or from another attitude block of the body, in this order. Redundant blocks must agree.
    The reader ignores maneuvers, and warns of rates and attitudes that it cannot use.

    Parameters
    ----------
    path : str or Path
        Name of a file in KVN or XML, version 1 or 2.
    calendar : Calendar, optional
        Calendar of the times. Default: seconds from the epoch of the message in its time system.

    Returns
    -------
    AttitudeTable
        Table of one row.
    Body or None
        Body with moments in kg m2 about the axes of the attitude. None if the inertia is missing, or if it refers to
        other axes, which gives a warning.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read, is not such a message, contains no attitude between the body and an inertial frame,
        the norm of a quaternion differs from 1 by more than a thousandth, no rigid body has the inertia, or astropy is
        not installed.

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
    times, calendar = ccsds.times_of(
        TextRows(name, system, (), [header["EPOCH"].place], [header["EPOCH"].value]), calendar
    )
    attitudes = _attitudes(blocks, name, times, calendar, version)
    table = attitudes[0].table
    omega = _rate(attitudes, [block for block in blocks if block.kind == "ANGVEL"])
    return dataclasses.replace(table, omega_body=omega), _body(blocks, table.body_frame, version)


def _attitudes(blocks: list[_Block], name: str, times: Array, calendar: Calendar, version: str) -> list[_Attitude]:
    """Return the attitude of the first block that has one, and of the others between the same axes."""
    found: list[_Attitude] = []
    reason = ValueError(f"{name} must have an attitude (quaternion, Euler angles or spin), got none.")
    for block in blocks:
        if block.kind not in FORMS:
            continue
        try:
            body, reference, body_is_b = block.frames()
        except ValueError as error:
            reason = error
            continue
        if found and (body, reference) != (found[0].table.body_frame, found[0].table.reference_frame):
            axes = f"{found[0].table.body_frame} in {found[0].table.reference_frame}"
            _warn(f"{block.place} should be about {axes}, got {body} in {reference}. The block is ignored.")
            continue
        kind, columns = _row(block)
        metadata = {key: entry.value for key, entry in block.found.items()}
        row = TextRows(block.place, metadata, tuple(columns), [block.place], [""], [list(columns.values())])
        frames = (reference, body)
        table = adm.read_attitudes(row, kind, times, calendar, frames, body_is_b=body_is_b, version=version)
        found.append(_Attitude(block, table))
        angle = float(rotation_angle(found[0].table.quaternion, table.quaternion)[0])
        if angle > SAME_ATTITUDE:
            raise ValueError(
                f"{block.place} must state the attitude of {found[0].block.place}, got one that is {angle:.3g} rad "
                "away. Remove one of the blocks."
            )
    if not found:
        raise reason
    return found


def _row(block: _Block) -> tuple[str, dict[str, float]]:
    """Return the type and the columns of the row that an ephemeris would have."""
    form = FORMS[block.kind]
    kinds = [kind for kind in adm.COLUMNS if kind.startswith(f"{form}/")]
    more = {kind: adm.COLUMNS[kind][len(adm.COLUMNS[form]) :] for kind in kinds}
    given = [kind for kind, keys in more.items() if any(key in block.found for key in keys)]
    if len(given) > 1:
        raise ValueError(f"{block.place} must have the keys of one type, got keys of {' and '.join(given)}.")
    kind = given[0] if given else form
    return kind, {key: block.number(key) for key in adm.COLUMNS[kind]}


def _rate(attitudes: list[_Attitude], blocks: list[_Block]) -> Array | None:
    """Return the angular velocity of the first block that states it, with which the others must agree."""
    first = attitudes[0].table
    stated = [(one.block.place, one.table.omega_body, one.is_whole) for one in attitudes]
    separate = [(block.place, _angular_velocity(block, first), True) for block in blocks]
    rates = [(place, omega, whole) for place, omega, whole in (stated[0], *separate, *stated[1:]) if omega is not None]
    rates.sort(key=lambda rate: not rate[2])
    for place, omega, whole in rates[1:]:
        apart = float(np.linalg.norm(omega - rates[0][1]))
        largest = max(float(np.linalg.norm(one)) for one in (omega, rates[0][1]))
        if whole and apart > SAME_RATE * largest:
            raise ValueError(
                f"{place} must state the angular velocity of {rates[0][0]}, got one that differs by "
                f"{100 * apart / largest:.3g} %. Remove one of them."
            )
    return rates[0][1] if rates else None


def _angular_velocity(block: _Block, table: AttitudeTable) -> Array | None:
    """Return the angular velocity in an ANGVEL block, shape (1, 3), along the body; None if it is of other axes."""
    pair = block.text("REF_FRAME_A"), block.text("REF_FRAME_B")
    try:
        body, reference, body_is_b = block.frames()
    except ValueError:
        body, reference, body_is_b = "", "", False
    if body != table.body_frame:
        axes = f"{table.body_frame} in axes that do not rotate"
        _warn(
            f"{block.place} should be about {axes}, got {quoted(pair[0])} and {quoted(pair[1])}. Its rates are ignored."
        )
        return None
    along = ccsds.axes_name(block.text("ANGVEL_FRAME"))
    if along not in (body, reference) or (along == reference != table.reference_frame):
        allowed = " or ".join(pair if reference == table.reference_frame else (body,))
        raise ValueError(f"{block.place} must have ANGVEL_FRAME {allowed}, got {quoted(along)}.")
    degrees = np.array([[block.number(key) for key in adm.ANGVEL]])
    omega = np.pi / 180 * (degrees if body_is_b else -degrees)
    omega = omega if along == body else quat.rotate(quat.conjugate(table.quaternion), omega)
    return np.asarray(omega * SECONDS[calendar_of(table).unit])


def _warn(sentence: str) -> None:
    warnings.warn(sentence, stacklevel=level_of_user())


def _body(blocks: list[_Block], body_frame: str, version: str) -> Body | None:
    """Return the body; version 1 gives the entries of the tensor, version 2 the products of inertia."""
    about = []
    for block in (block for block in blocks if block.kind == "INERTIA"):
        axes = ccsds.axes_name(block.text("INERTIA_REF_FRAME"))
        if axes == body_frame:
            about.append(block)
        else:
            _warn(f"{block.place} should have INERTIA_REF_FRAME {body_frame}, got {axes[:40]!r}. The block is ignored.")
    if not about:
        return None
    block, *others = about
    if others:
        raise ValueError(f"{others[0].place} must not repeat the inertia of {block.place}, got two blocks. Remove one.")
    tensor = np.empty((3, 3))
    for key, (i, j) in TENSOR.items():
        tensor[i, j] = tensor[j, i] = block.number(key) * (1 if i == j or version < "2" else -1)
    try:
        return Body.from_inertia(tensor)
    except ValueError as error:
        raise ValueError(f"{block.place}: {error}") from None


# ------------------------------------------------------------------ KVN


def _of_kvn(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, lines = ccsds.opened_kvn(text, name, "APM")
    header: list[Entry] = []
    blocks: list[_Block] = []
    found: dict[str, list[Entry]] = {}
    rule = "KEY = VALUE" if version < "2" else "KEY = VALUE or the start of a block"
    for count, line in lines:
        match = re.fullmatch(r"(QUAT|EULER|ANGVEL|SPIN|INERTIA|MAN)_START", line)
        if match and version >= "2":
            entries = ccsds.kvn_block(lines, name, count, f"{match[1]}_STOP")
            blocks.append(_block(match[1], entries, f"{name}, line {count}", version))
            continue
        entry = ccsds.kvn_entry(line, f"{name}, line {count}", rule)
        kind = _kind_of_v1(entry.key) if version < "2" else None
        (found.setdefault(kind, []) if kind else header).append(entry)
    blocks += [_block(kind, entries, entries[0].place, version) for kind, entries in found.items()]
    return version, _header(header), blocks


def _header(entries: list[Entry]) -> dict[str, Entry]:
    return Keys(HEADER, ABOUT, elsewhere=USED, repeated=("COMMENT",)).by_key(entries)


def _kind_of_v1(key: str) -> str | None:
    """Return the block to which a key of version 1 belongs."""
    more = {"EULER": ("RATE_FRAME", *AXIS_ANGLES, *AXIS_RATES), "MAN": MANEUVERS}
    return next((kind for kind, keys in V1_KEYS.items() if key in (*keys, *more.get(kind, ()))), None)


def _block(kind: str, entries: list[Entry], place: str, version: str) -> _Block:
    """Return a block by the keys of version 2."""
    keys = (V1_KEYS if version < "2" else V2_KEYS)[kind]
    repeated = ("COMMENT", *(MANEUVERS if kind == "MAN" else ()))
    ignored: tuple[str, ...] = ()
    if version < "2":
        ignored = ("EPOCH", "RATE_FRAME", *adm.RATES)
        repeated = (*repeated, *(AXIS_ANGLES + AXIS_RATES if kind == "EULER" else ()))
    found = Keys(keys, ignored, elsewhere=USED, repeated=repeated).by_key(entries)
    return _from_v1(_Block(kind, found, place), entries) if version < "2" else _Block(kind, found, place)


def _from_v1(block: _Block, entries: list[Entry]) -> _Block:
    """Return a block of version 1 by the keys of version 2."""
    kind = block.kind
    found = {re.sub(r"^(Q|EULER|SPIN)_FRAME_", "REF_FRAME_", key): entry for key, entry in block.found.items()}
    block = block._replace(found=found)
    if kind == "INERTIA":
        renamed = {key.translate(TO_LETTERS) if key in V1_TENSOR else key: entry for key, entry in found.items()}
        return block._replace(found=renamed)
    if kind == "EULER":
        _number_angles(block, entries)
    if kind in FORMS:
        key = "Q_DIR" if kind == "QUAT" else f"{kind}_DIR"
        direction = block.text(key).upper()
        if direction not in ("A2B", "B2A"):
            raise ValueError(f"{found[key].place} must have {key} A2B or B2A, got {quoted(direction)}.")
        if direction == "B2A":
            found["REF_FRAME_A"], found["REF_FRAME_B"] = (
                Entry(other, block.text(other), block.place) for other in ("REF_FRAME_B", "REF_FRAME_A")
            )
    return block


def _number_angles(block: _Block, entries: list[Entry]) -> None:
    """Name the angles X_ANGLE, Y_ANGLE, Z_ANGLE, which may come twice, by their place in the sequence."""
    given = [entry for entry in entries if entry.key in AXIS_ANGLES]
    sequence = block.text("EULER_ROT_SEQ").upper().translate(TO_DIGITS)
    axes = "".join(entry.key[0] for entry in given).translate(TO_DIGITS)
    if given and axes != sequence:
        raise ValueError(f"{block.place} must have its angles in the order {quoted(sequence)}, got {quoted(axes)}.")
    block.found.update({f"ANGLE_{i}": entry for i, entry in enumerate(given, start=1)})
    if any(entry.key in AXIS_RATES for entry in entries):
        adm.warn_of_undefined(block.place, "RATE")


# ------------------------------------------------------------------ XML


def _of_xml(text: str, name: str) -> tuple[str, dict[str, Entry], list[_Block]]:
    version, segments = ccsds.opened_xml(text, name, "APM")
    if len(segments) != 1:
        raise ValueError(f"{name} must hold one segment, got {len(segments)}.")
    header: list[Entry] = []
    blocks: list[_Block] = []
    for part in (child for half in segments[0] for child in half):
        kind, place = XML_BLOCKS.get(local_name(part)), f"{name}, {local_name(part)[:40]}"
        entries = list(ccsds.entries_of(part, place))
        if kind and entries:
            block = _block(kind, entries, place, version)
            ccsds.check_sequence(part, block.text("EULER_ROT_SEQ") if kind == "EULER" else "", place)
            blocks.append(block)
        epochs = {entry.value for entry in header if entry.key == "EPOCH"}
        header += [
            entry
            for entry in entries
            if kind is None or (version < "2" and entry.key == "EPOCH" and entry.value not in epochs)
        ]
    return version, _header(header), blocks


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
    """Write a body and its state as a CCSDS Attitude Parameter Message (504.0-B).

    The message contains attitude and rate with the conventions of `write_aem`, and the inertia about the body axes.

    Parameters
    ----------
    body : Body
        Body with moments in kg m2.
    state : State
        State of the body.
    path, version, overwrite, originator
        Same as in `write_aem`.
    calendar : Calendar
        Date of t = 0 and unit of time.
    reference_frame : str
        Name of the space axes, such as "ICRF".
    body_frame, object_name, object_id, center_name : str
        Names in the message.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is invalid, there are several members, or the file exists.

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

    def kvn(stated: list[str]) -> list[str]:
        lines = ["COMMENT x_A = q x_B q~ (Hamilton product), QC the scalar", *stated, f"EPOCH = {epoch}"]
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
    data, stamped = ET.Element("data"), {"EPOCH": epoch}
    if version >= "2":
        adm.append_values(data, stamped, version)
    tags = {"QUAT": "quaternionState", "ANGVEL": "angularVelocity"}
    tags["INERTIA"] = "spacecraftParameters" if version < "2" else "inertia"
    for kind, values in blocks:
        first = stamped if version < "2" and kind == "QUAT" else {}
        adm.append_values(ET.SubElement(data, tags[kind]), first | values, version)
    return data
