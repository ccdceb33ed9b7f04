"""STK attitude files (.a): quaternions with or without rates, and Euler angles."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import (
    AttitudeTable,
    calendar_of,
    dated_calendar,
    rates_per_second,
    table_of,
)
from poinsot.files.keys import Entry, Keys
from poinsot.files.rows import TextRows
from poinsot.files.untrusted import read_text
from poinsot.printable import quoted, shortened
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.calendar import Calendar

__all__ = ["read_stk_attitude", "write_stk_attitude"]

FORMATS = {
    "ATTITUDETIMEQUATERNIONS": ("QUATERNION", adm.QUATERNION),
    "ATTITUDETIMEQUATSCALARFIRST": ("QUATERNION", ("QC", "Q1", "Q2", "Q3")),
    "ATTITUDETIMEQUATANGVELS": ("QUATERNION/ANGVEL", adm.QUATERNION + adm.ANGVEL),
    "ATTITUDETIMEEULERANGLES": ("EULER_ANGLE", adm.ANGLES),
}
"""Formats, each as the type of CCSDS message that has the same meaning, and its columns after the time."""

AXES = {"ICRF": "ICRF", "J2000": "ICRF", "TEMEOFDATE": "TEME", "TRUEOFDATE": "TOD", "MEANOFDATE": "MOD"}
"""Inertial axes of STK, and their names in poinsot."""

KEYWORDS = Keys(
    frozenset(
        ("BEGIN", "NUMBEROFATTITUDEPOINTS", "SCENARIOEPOCH", "COORDINATEAXES", "TIMEFORMAT", "SEQUENCE"),
    ),
    frozenset(
        (
            *("INTERPOLATIONMETHOD", "INTERPOLATIONORDER", "BLOCKINGFACTOR", "CENTRALBODY", "MESSAGELEVEL"),
            *("ATTITUDEDEVIATIONS", "COORDINATEAXESEPOCH"),
        )
    ),
)
"""Keywords before the rows, in capitals."""

WRITTEN_AXES = {"ICRF": "ICRF", "J2000": "J2000", "EME2000": "J2000"}
WRITTEN_AXES |= {"TEME": "TEMEOfDate", "TOD": "TrueOfDate", "MOD": "MeanOfDate"}

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


@checked
def read_stk_attitude(path: str | Path, *, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in an STK attitude file (.a).

    The reader supports AttitudeTimeQuaternions, AttitudeTimeQuatScalarFirst, AttitudeTimeQuatAngVels and
    AttitudeTimeEulerAngles. The quaternions rotate the reference axes into the body axes, which is poinsot's
    convention, with the scalar last, or first if its name contains ScalarFirst. Rates are degrees per second along the
    body axes. Euler angles are degrees about axes that rotate with the body.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    calendar : Calendar, optional
        Calendar of the times. Default: seconds from the ScenarioEpoch.

    Returns
    -------
    AttitudeTable
        Attitudes, with rates in radians per unit of the calendar.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or is not a complete file of this kind, its axes rotate, the norm of a quaternion
        differs from 1 by more than a thousandth, times do not increase, or astropy is not installed.

    Examples
    --------
    >>> pt.files.read_stk_attitude("m.a").quaternion.shape
    (9, 4)
    """
    rows, kind = _parsed(read_text(path), shortened(path))
    axes = rows.word("CoordinateAxes")
    if axes.upper() not in AXES:
        raise ValueError(f"CoordinateAxes in {rows.name} must be one of {', '.join(AXES)}, got {quoted(axes)}.")
    if kind.startswith("EULER"):
        rows.metadata["EULER_ROT_SEQ"] = rows.word("Sequence")
    own = _calendar(rows.word("ScenarioEpoch"), rows.name)
    calendar = own if calendar is None else calendar
    (seconds,) = rows.stacked("time").T
    rows.check_rising(seconds)
    return adm.read_attitudes(rows, kind, calendar.converted(seconds, own), calendar, (AXES[axes.upper()], "SC_BODY_1"))


def _parsed(text: str, name: str) -> tuple[TextRows, str]:
    """Return the keywords, in capitals, and the rows, and the type of attitude."""
    numbered = ((count, " ".join(line.split())) for count, line in enumerate(text.splitlines(), start=1))
    lines = ((count, line) for count, line in numbered if line and not line.startswith("#"))
    _, opening = next(lines, (0, ""))
    if not re.fullmatch(r"stk\.v\.\d+(\.\d+)*", opening, re.IGNORECASE):
        raise ValueError(f"{name} must begin with stk.v. and a version, got {quoted(opening)}.")
    rows, data_format, entries = TextRows(name), "", list[Entry]()
    for count, line in lines:
        key, _, value = line.partition(" ")
        if key.upper().startswith("ATTITUDETIME"):
            data_format = key
            break
        if not re.fullmatch(r"\w+", key) or re.fullmatch(r"END\s+\w+", line, re.IGNORECASE):
            raise ValueError(f"{name}, line {count} must be a keyword and its value, got {quoted(line)}.")
        entries.append(Entry(key.upper(), value.strip("\"' "), f"{name}, line {count}"))
    rows.metadata |= {entry.key: entry.value for entry in entries}
    if rows.metadata.get("BEGIN", "").upper() != "ATTITUDE":
        raise ValueError(f"{name} must have a block BEGIN Attitude, got none.")
    if data_format.upper() not in FORMATS:
        known = "AttitudeTimeQuaternions, -QuatScalarFirst, -QuatAngVels or -EulerAngles"
        raise ValueError(f"{name} must hold {known}, got {quoted(data_format) if data_format else 'none'}.")
    _check_keywords(rows, entries)
    kind, columns = FORMATS[data_format.upper()]
    rows.columns = ("time", *columns)
    _read_rows(rows, lines)
    return rows, kind


def _check_keywords(rows: TextRows, entries: list[Entry]) -> None:
    time_format = rows.metadata.get("TIMEFORMAT", "EpSec")
    if time_format.upper() != "EPSEC":
        raise ValueError(f"TimeFormat in {rows.name} must be EpSec, got {quoted(time_format)}.")
    for key in ("CoordinateAxes", "ScenarioEpoch"):
        rows.word(key)
    KEYWORDS.by_key(entries)


def _read_rows(rows: TextRows, lines: Iterator[tuple[int, str]]) -> None:
    whole = False
    for count, line in lines:
        whole = line.upper() == "END ATTITUDE"
        if whole:
            break
        rows.add(f"{rows.name}, line {count}", line.split())
    after = next(lines, None)
    if after:
        raise ValueError(f"{rows.name}, line {after[0]} must be absent after END Attitude, got {quoted(after[1])}.")
    if not rows.numbers:
        raise ValueError(f"{rows.name} must have rows, got none.")
    stated, found = rows.metadata.get("NUMBEROFATTITUDEPOINTS"), len(rows.numbers)
    if stated != str(found) and not (stated is None and whole):
        end = "END Attitude" if stated is None else f"NumberOfAttitudePoints rows, {quoted(stated)}"
        raise ValueError(f"{rows.name} must have {end}, got the end after {found} rows. The file is not whole.")


def _calendar(text: str, name: str) -> Calendar:
    """Return the calendar of seconds from a date such as 1 Jul 2005 12:00:00.00, or 2005-07-01T12:00:00.00, in UTC."""
    match = re.fullmatch(r"(\d{1,2}) ([A-Za-z]{3})\w* (\d{4}) (\d\d:\d\d:\d\d(\.\d*)?)", text, re.ASCII)
    date = text
    if match and match[2].capitalize() in MONTHS:
        date = f"{match[3]}-{MONTHS.index(match[2].capitalize()) + 1:02d}-{int(match[1]):02d}T{match[4]}"
    return dated_calendar(date, "UTC", "s", f"ScenarioEpoch in {name}", "1 Jul 2005 12:00:00.00", text)


# ------------------------------------------------------------------ writing


@checked
def write_stk_attitude(
    motion: Trajectory | AttitudeTable,
    path: str | Path,
    *,
    calendar: Calendar | None = None,
    reference_frame: str | None = None,
    central_body: str = "Earth",
    rates: bool = True,
    overwrite: bool = False,
) -> Path:
    """Write the attitudes of a motion, or of a table, as an STK attitude file.

    The file contains AttitudeTimeQuatAngVels: seconds from the ScenarioEpoch, q1, q2, q3, q0, and degrees per second
    along the body axes. Without rates it contains AttitudeTimeQuaternions.

    Parameters
    ----------
    motion, calendar, reference_frame, rates, overwrite
        Same as in `write_aem`; the ScenarioEpoch is the date of t = 0.
    path : str or Path
        Name of the file. STK expects the ending .a.
    central_body : str
        Name of the central body.

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
    >>> path = pt.files.write_stk_attitude(motion, "new.a", calendar=calendar, reference_frame="ICRF")
    >>> path.read_text().splitlines()[4]
    'ScenarioEpoch 21 Nov 2026 00:00:00.000000000'
    """
    table = table_of(motion, calendar, reference_frame)
    frame = ccsds.FRAMES[table.reference_frame]
    axes = WRITTEN_AXES.get(table.reference_frame, WRITTEN_AXES.get(frame))
    if axes is None:
        raise ValueError(f"reference_frame must be a name that STK defines, got {table.reference_frame}.")
    zero = calendar_of(table).date(0.0).utc
    zero.precision = 9
    begin = Calendar(str(zero.isot), "UTC")
    year, month, day, clock = re.split("[-T]", begin.zero)
    times = begin.converted(table.times, calendar_of(table))
    columns = [times[:, None], table.quaternion[:, [1, 2, 3, 0]]]
    omega = rates_per_second(table, rates)
    if omega is not None:
        columns.append(np.degrees(omega))
    lines = (
        "stk.v.8.0",
        "# q1 q2 q3 q0: x_reference = q x_body q~ (Hamilton product); rates in deg/s along the body axes",
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {times.size}",
        f"ScenarioEpoch {int(day)} {MONTHS[int(month) - 1]} {year} {clock}",
        "InterpolationOrder 1",
        f"CentralBody {ccsds.word('central_body', central_body)}",
        f"CoordinateAxes {axes}",
        "AttitudeTimeQuaternions" if omega is None else "AttitudeTimeQuatAngVels",
        *(" ".join(map(repr, row)) for row in np.concatenate(columns, axis=1).tolist()),
        "END Attitude",
    )
    return write_text(path, "\n".join(lines) + "\n", overwrite)


class Stk(AttitudeFormat):
    """Attitude files of STK."""

    title = "STK"
    suffixes = (".a",)
    in_python = "pt.files.read_stk_attitude({path!r})"
    conventions = (
        "scalar last; the keyword QuatScalarFirst states the other order",
        "as in poinsot (reference axes rotated into body axes)",
        "deg/s along the body axes",
    )
    read, write = staticmethod(read_stk_attitude), staticmethod(write_stk_attitude)
    mark = re.compile(rb"\A\s*stk\.v", re.IGNORECASE)
