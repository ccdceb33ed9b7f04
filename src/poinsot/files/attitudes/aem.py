"""CCSDS Attitude Ephemeris Messages (504.0-B), versions 1.0 and 2.0, in KVN and XML."""

from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, calendar_of, rates_per_second, table_of
from poinsot.files.keys import Keys
from poinsot.files.rows import TextRows
from poinsot.files.untrusted import read_text
from poinsot.kinematics.attitude import rotation_angle
from poinsot.printable import quoted, shortened
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.calendar import Calendar

__all__ = ["read_aem", "write_aem"]

NEEDED = ("REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM", "ATTITUDE_TYPE")

SAME_ROW = 1e-6
"""Radians, and the relative difference of rates: rows of seven digits that state one attitude."""

METADATA = Keys(
    frozenset(
        (
            *(*NEEDED, "OBJECT_NAME", "OBJECT_ID", "STOP_TIME", "EULER_ROT_SEQ", "ANGVEL_FRAME"),
            *("ATTITUDE_DIR", "QUATERNION_TYPE"),
        )
    ),
    frozenset(
        (
            *("CENTER_NAME", "START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "RATE_FRAME"),
            *("INTERPOLATION_METHOD", "INTERPOLATION_DEGREE"),
        )
    ),
    repeated=("COMMENT",),
)

XML_ROWS = {
    ("1.0", "QUATERNION"): "quaternionState",
    ("1.0", "QUATERNION/DERIVATIVE"): "quaternionDerivative",
    ("2.0", "QUATERNION"): "quaternionEphemeris",
    ("2.0", "QUATERNION/ANGVEL"): "quaternionAngVel",
}


@checked
def read_aem(path: str | Path, *, segment: int | None = None, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in a CCSDS Attitude Ephemeris Message (504.0-B-1 and B-2, annex F), KVN or XML.

    The reader supports all types of attitude: quaternions in either order, Euler angles in any sequence, and spin, with
    derivatives and angular velocities, from A to B or from B to A. It ignores interpolation and usable times, and in
    version 1 the columns of /RATE and /NUTATION, which the standard does not define.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    segment : int, optional
        Index of a segment, from 0. Default: all segments, which must follow each other, describe one object, agree at
        shared epochs, and either all contain rates or none.
    calendar : Calendar, optional
        Calendar of the times. Default: seconds from the first epoch in the time system of the message.

    Returns
    -------
    AttitudeTable
        Attitudes, with rates along the body axes in radians per unit of the calendar. One of the two frames of the
        message must be inertial (with a name as in `read_oem`); the other is the body.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read, is not a complete message of this kind, a frame rotates, the norm of a quaternion
        differs from 1 by more than a thousandth, times do not increase, segments disagree, or astropy is not installed.

    Examples
    --------
    >>> pt.files.read_aem("m.aem")
    Attitudes of SC_BODY_1 in ICRF
      times: 9, 0 ... 2 s
      ...
    """
    text, name = read_text(path), shortened(path)
    version, segments = ccsds.segments_of(text, name, "AEM", "12", NEEDED, METADATA, _columns)
    parts, tables = ccsds.chosen(segments, segment, name), list[AttitudeTable]()
    for part in parts:
        tables.append(_table_of(part, version, calendar))
        calendar = tables[-1].calendar
    return _joined(parts, tables)


def _columns(segment: TextRows, version: str, in_xml: bool) -> tuple[str, ...]:
    """Return the columns of the rows that a segment will have, by its checked metadata."""
    kind = segment.metadata["ATTITUDE_TYPE"].upper().replace(" ", "_")
    if kind not in adm.COLUMNS:
        known = ", ".join(adm.COLUMNS)
        raise ValueError(f"ATTITUDE_TYPE in {segment.name} must be one of {known}, got {quoted(kind)}.")
    segment.metadata["ATTITUDE_TYPE"] = kind
    if in_xml or not kind.startswith("QUATERNION"):
        return adm.COLUMNS[kind]
    return adm.kvn_columns(kind, _one_of_two(segment, "QUATERNION_TYPE", ("LAST", "FIRST"), version) == "FIRST")


def _one_of_two(segment: TextRows, key: str, known: tuple[str, str], version: str) -> str:
    """Return one of two words of the metadata. Version 2 allows the first one alone, which is its default."""
    given = segment.metadata.get(key, "" if version < "2" else known[0]).upper()
    if given not in known:
        raise ValueError(f"{key} in {segment.name} must be {' or '.join(known)}, got {quoted(given)}.")
    return given


def _table_of(segment: TextRows, version: str, calendar: Calendar | None) -> AttitudeTable:
    metadata, name = segment.metadata, segment.name
    first, second = metadata["REF_FRAME_A"], metadata["REF_FRAME_B"]
    if _one_of_two(segment, "ATTITUDE_DIR", ("A2B", "B2A"), version) == "B2A":
        first, second = second, first
    body, reference, body_is_b = ccsds.body_and_reference(first, second, f"REF_FRAME_A and REF_FRAME_B in {name}")
    times, calendar = ccsds.times_of(segment, calendar)
    conventions = {"rate_in_a": _rate_in_a(segment, first, second), "body_is_b": body_is_b}
    frames = (reference, body)
    return adm.read_attitudes(
        segment, metadata["ATTITUDE_TYPE"], times, calendar, frames, **conventions, version=version
    )


def _rate_in_a(segment: TextRows, first: str, second: str) -> bool:
    """Return True if angular velocities are along the frame from which the attitude leads."""
    if not segment.metadata["ATTITUDE_TYPE"].endswith("ANGVEL"):
        return False
    given = segment.metadata.get("ANGVEL_FRAME", "")
    along = ccsds.axes_name(segment.metadata.get(given.upper(), given))
    if along not in (ccsds.axes_name(first), ccsds.axes_name(second)):
        raise ValueError(
            f"ANGVEL_FRAME in {segment.name} must be one of the frames {first}, {second}, got {quoted(given)}."
        )
    return along != ccsds.axes_name(second)


def _joined(segments: list[TextRows], tables: list[AttitudeTable]) -> AttitudeTable:
    """Return several tables as one, an attitude that ends one and begins the next taken once."""
    first, slices = tables[0], [slice(None)]
    for i, (before, after) in enumerate(itertools.pairwise(tables), start=1):
        same = {
            "OBJECT_ID": segments[i - 1].metadata.get("OBJECT_ID") == segments[i].metadata.get("OBJECT_ID"),
            "frames": (first.body_frame, first.reference_frame) == (after.body_frame, after.reference_frame),
            "order in time": before.times[-1] <= after.times[0],
            "the presence of rates": (before.omega_body is None) == (after.omega_body is None),
            f"the attitude and the rate at {segments[i].epochs[0]}": _same_row(before, after),
        }
        ccsds.check_continued(segments, i, same)
        slices.append(slice(int(after.times[0] == before.times[-1]), None))
    if len(tables) == 1:
        return first
    parts = [(table, part) for table, part in zip(tables, slices, strict=True)]
    rates = [table.omega_body[part] for table, part in parts if table.omega_body is not None]  # of all or of none
    return dataclasses.replace(
        first,
        times=np.concatenate([table.times[part] for table, part in parts]),
        quaternion=np.concatenate([table.quaternion[part] for table, part in parts]),
        omega_body=np.concatenate(rates) if rates else None,
        norm_error=max(table.norm_error for table in tables),
    )


def _same_row(before: AttitudeTable, after: AttitudeTable) -> bool:
    """Return True unless two tables disagree at an epoch that ends the first and begins the second."""
    if before.times[-1] != after.times[0]:
        return True
    if rotation_angle(before.quaternion[-1], after.quaternion[0]) > SAME_ROW:
        return False
    if before.omega_body is None or after.omega_body is None:
        return True
    rates = before.omega_body[-1], after.omega_body[0]
    return float(np.linalg.norm(rates[1] - rates[0])) <= SAME_ROW * float(np.max(np.linalg.norm(rates, axis=-1)))


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
    """Write the attitudes of a motion, or of a table, as a CCSDS Attitude Ephemeris Message (504.0-B).

    The quaternion is from REF_FRAME_A, the space axes, to REF_FRAME_B, the body, scalar last. Annex F rotates the axes
    of A into the axes of B, so that Q1, Q2, Q3, QC are q1, q2, q3, q0. Rates are written as QUATERNION/ANGVEL in
    degrees per second along the body axes, and in version 1 as QUATERNION/DERIVATIVE.

    Parameters
    ----------
    motion : Trajectory or AttitudeTable
        Motion of one body, or a table of attitudes.
    path : str or Path
        Name of the file; the format is XML if it ends in .xml, and KVN otherwise.
    calendar : Calendar, optional
        Date of t = 0 and unit of the times. Default: the calendar of the system's orbits or of the table.
    reference_frame : str, optional
        Name of the space axes, such as "ICRF". Default: the name in the system's orbits or in the table.
    body_frame, object_name, object_id, center_name, originator : str
        Names in the message. The default body frame is the name in the table, or "SC_BODY_1".
    rates : bool
        True to write angular velocities.
    version : {"2.0", "1.0"}
        Version of the standard.
    overwrite : bool
        True to replace an existing file of that name.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is invalid, the motion is an ensemble, or the file exists.

    Examples
    --------
    >>> calendar = pt.Calendar("2026-11-21T00:00:00", "UTC")
    >>> path = pt.files.write_aem(motion, "new.aem", calendar=calendar, reference_frame="ICRF")
    >>> float(np.max(pt.files.read_aem(path).angle_to(motion))) < 1e-14  # rad
    True
    """
    table = table_of(motion, calendar, reference_frame, body_frame)
    ccsds.body_and_reference(table.reference_frame, table.body_frame, "reference_frame and body_frame")
    kind, rows = _written_rows(table, rates, version)
    dates, system = ccsds.dates_of(calendar_of(table), table.times)
    metadata = {
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
        "QUATERNION_TYPE": "LAST" if version < "2" else None,
        "ANGVEL_FRAME": table.body_frame if kind.endswith("ANGVEL") else None,
    }

    def kvn(stated: list[str]) -> list[str]:
        comment = f"COMMENT {kind}: {', '.join(adm.COLUMNS[kind])}; x_A = q x_B q~ (Hamilton product), QC the scalar"
        inner = [f"{date} {' '.join(map(ccsds.digits, row))}" for date, row in zip(dates, rows, strict=True)]
        return ["", "META_START", comment, *stated, "META_STOP", "", "DATA_START", *inner, "DATA_STOP"]

    def xml() -> ET.Element:
        data = ET.Element("data")
        for date, row in zip(dates, rows, strict=True):
            state = ET.SubElement(ET.SubElement(data, "attitudeState"), XML_ROWS[version, kind])
            adm.append_values(state, {"EPOCH": date, **dict(zip(adm.COLUMNS[kind], row, strict=True))}, version)
        return data

    return ccsds.write_message(path, overwrite, "AEM", version, originator, metadata, kvn, xml)


def _written_rows(table: AttitudeTable, rates: bool, version: str) -> tuple[str, list[list[float]]]:
    """Return type and numbers of the rows, per second."""
    q, omega = table.quaternion[:, [1, 2, 3, 0]], rates_per_second(table, rates)
    if omega is None:
        return "QUATERNION", q.tolist()
    if version < "2":
        q_dot = 0.5 * quat.product(table.quaternion, quat.pure(omega))[:, [1, 2, 3, 0]]
        return "QUATERNION/DERIVATIVE", np.concatenate([q, q_dot], axis=1).tolist()
    return "QUATERNION/ANGVEL", np.concatenate([q, np.degrees(omega)], axis=1).tolist()


class Aem(AttitudeFormat):
    """Attitude ephemeris messages of the CCSDS."""

    title = "CCSDS AEM"
    suffixes = (".aem", ".xml")
    in_python = "pt.files.read_aem({path!r})"
    conventions = (
        "scalar last: Q1, Q2, Q3, QC are q1, q2, q3, q0; FIRST is possible in version 1",
        "as in poinsot for A space and B body (axes of A rotated into axes of B); B2A is possible in version 1",
        "deg/s along the body axes (ANGVEL); version 1: derivatives of the quaternion",
    )
    read, write = staticmethod(read_aem), staticmethod(write_aem)
    mark = re.compile(rb"CCSDS_AEM_VERS|<aem[\s>]")
