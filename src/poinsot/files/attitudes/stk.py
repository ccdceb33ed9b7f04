"""STK attitude files (.a): quaternions with or without rates, and Euler angles."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, calendar_of, check_rising, rates_per_second, table_of
from poinsot.files.untrusted import read_text
from poinsot.mechanics.calendar import SECONDS, Calendar
from poinsot.propagation.trajectory import Trajectory

__all__ = ["read_stk_attitude", "write_stk_attitude"]

Array = NDArray[np.float64]

FORMATS = {
    "ATTITUDETIMEQUATERNIONS": ("QUATERNION", adm.QUATERNION),
    "ATTITUDETIMEQUATSCALARFIRST": ("QUATERNION", ("QC", "Q1", "Q2", "Q3")),
    "ATTITUDETIMEQUATANGVELS": ("QUATERNION/ANGVEL", adm.QUATERNION + adm.ANGVEL),
    "ATTITUDETIMEEULERANGLES": ("EULER_ANGLE", adm.ANGLES),
}
"""Formats, each as the type of CCSDS message that has the same meaning, and its columns after the time."""

AXES = {"ICRF": "ICRF", "J2000": "ICRF", "TEMEOFDATE": "TEME", "TRUEOFDATE": "TOD", "MEANOFDATE": "MOD"}
"""Axes that do not rotate, and their names here."""

WRITTEN_AXES = {"TEME": "TEMEOfDate", "TOD": "TrueOfDate", "MOD": "MeanOfDate"}

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


@dataclasses.dataclass
class _File:
    """The keywords of a file, and its rows with the place of each."""

    name: str
    says: dict[str, str]
    data_format: str = ""
    places: list[str] = dataclasses.field(default_factory=list)
    rows: list[list[float]] = dataclasses.field(default_factory=list)

    def word(self, key: str) -> str:
        if not self.says.get(key.upper()):
            raise ValueError(f"{self.name} must have {key}, but it has none.")
        return self.says[key.upper()].strip("\"' ")


# ------------------------------------------------------------------ reading


@checked
def read_stk_attitude(path: str | Path, *, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in an STK attitude file.

    Read are AttitudeTimeQuaternions, AttitudeTimeQuatScalarFirst, AttitudeTimeQuatAngVels and AttitudeTimeEulerAngles.
    Their quaternions turn the reference axes into those of the body, as ours do, with the scalar last (or first, as
    the name says); rates are degrees per second along the body axes; Euler angles are degrees, about axes that turn
    along.

    Parameters
    ----------
    path : str or Path
    calendar : Calendar, optional
        Counts the times; default: from the ScenarioEpoch, in seconds.

    Returns
    -------
    AttitudeTable
        Rates in radians per unit of the calendar.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is no such file or is not whole, its axes rotate, a quaternion is off unit norm by more than a
        thousandth, or times do not rise.
    ImportError
        If astropy is missing.
    """
    file = _parsed(read_text(path), str(path))
    kind, keys = FORMATS[file.data_format.upper()]
    axes = file.word("CoordinateAxes")
    if axes.upper() not in AXES:
        raise ValueError(f"CoordinateAxes in {file.name} must be one of {', '.join(AXES)}, but it is {axes[:40]!r}.")
    sequence = adm.sequence_of(file.word("Sequence"), file.name) if kind.startswith("EULER") else None
    table = np.array(file.rows)
    check_rising(table[:, 0], file.places)
    q, omega, norm_error = adm.attitude_of(
        kind,
        dict(zip(keys, table[:, 1:].T, strict=True)),
        sequence,
        rate_in_a=False,
        body_is_b=True,
        version="2.0",
        places=file.places,
    )
    own = _calendar(file.word("ScenarioEpoch"), file.name)
    calendar = own if calendar is None else calendar
    times = calendar.converted(table[:, 0], own)
    omega = None if omega is None else omega * SECONDS[calendar.unit]
    return AttitudeTable(times, q, omega, calendar, AXES[axes.upper()], norm_error=norm_error)


def _parsed(text: str, name: str) -> _File:
    lines = _lines(text)
    _, opening = next(lines, (0, ""))
    if not re.fullmatch(r"stk\.v\.\d+(\.\d+)*", opening, re.IGNORECASE):
        raise ValueError(f"{name} must begin with stk.v. and a version, but it begins with {opening[:60]!r}.")
    file = _File(name, {})
    for count, line in lines:
        key, _, value = line.partition(" ")
        if key.upper().startswith("ATTITUDETIME"):
            file.data_format = key
            break
        if not re.fullmatch(r"\w+", key) or re.fullmatch(r"END\s+\w+", line, re.IGNORECASE):
            raise ValueError(f"{name}, line {count} must be a keyword and its value, got {line[:60]!r}.")
        file.says[key.upper()] = value.strip()
    _check_keywords(file)
    _read_rows(file, lines, len(FORMATS[file.data_format.upper()][1]))
    return file


def _lines(text: str) -> Iterator[tuple[int, str]]:
    for count, line in enumerate(text.splitlines(), start=1):
        line = " ".join(line.split())
        if line and not line.startswith("#"):
            yield count, line


def _check_keywords(file: _File) -> None:
    if file.says.get("BEGIN", "").upper() != "ATTITUDE":
        raise ValueError(f"{file.name} must have a block BEGIN Attitude, but it has none.")
    if file.data_format.upper() not in FORMATS:
        known = "AttitudeTimeQuaternions, -QuatScalarFirst, -QuatAngVels or -EulerAngles"
        given = repr(file.data_format[:40]) if file.data_format else "none"
        raise ValueError(f"{file.name} must hold {known}, got {given}.")
    time_format = file.says.get("TIMEFORMAT", "EpSec")
    if time_format.upper() != "EPSEC":
        raise ValueError(f"TimeFormat in {file.name} must be EpSec, but it is {time_format[:40]!r}.")


def _read_rows(file: _File, lines: Iterator[tuple[int, str]], columns: int) -> None:
    whole = False
    for count, line in lines:
        if line.upper() == "END ATTITUDE":
            whole = True
            break
        place = f"{file.name}, line {count}"
        texts = line.split()
        if len(texts) != columns + 1:
            raise ValueError(f"{place} must have a time and {columns} numbers, got {line[:100]!r}.")
        file.rows.append([ccsds.number(ccsds.Entry("a column", text, place)) for text in texts])
        file.places.append(place)
    if not file.rows:
        raise ValueError(f"{file.name} must have rows, but it has none.")
    said = file.says.get("NUMBEROFATTITUDEPOINTS")
    if said != str(len(file.rows)) and not (said is None and whole):
        end = "END Attitude" if said is None else f"NumberOfAttitudePoints = {said[:20]} rows"
        raise ValueError(
            f"{file.name} must have {end}, but it ends after {len(file.rows)} rows. The file is not whole."
        )


def _calendar(text: str, name: str) -> Calendar:
    """Return the calendar of seconds from a date such as 1 Jul 2005 12:00:00.00, or 2005-07-01T12:00:00.00, in UTC."""
    match = re.fullmatch(r"(\d{1,2}) ([A-Za-z]{3})\w* (\d{4}) (\d\d:\d\d:\d\d(\.\d*)?)", text, re.ASCII)
    if match and match[2].capitalize() in MONTHS:
        text = f"{match[3]}-{MONTHS.index(match[2].capitalize()) + 1:02d}-{int(match[1]):02d}T{match[4]}"
    try:
        calendar = Calendar(text, "UTC")
        calendar.date(0.0)
        return calendar
    except ValueError:
        raise ValueError(
            f"ScenarioEpoch in {name} must be a date such as 1 Jul 2005 12:00:00.00, but it is {text[:40]!r}."
        ) from None


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
    """Write the attitudes of a motion, or of a table, as an STK attitude file; return its path.

    AttitudeTimeQuatAngVels: seconds from the ScenarioEpoch, q1, q2, q3, q0, degrees per second along the body axes;
    without rates AttitudeTimeQuaternions.

    Parameters
    ----------
    motion : Trajectory or AttitudeTable
    path : str or Path
        STK expects the ending .a.
    calendar : Calendar, optional
        What instant t = 0 is, which becomes the ScenarioEpoch, and the unit of the times; default: that of the
        system's orbits or of the table.
    reference_frame : str, optional
        The name of the space axes, such as "ICRF"; default: that of the system's orbits or of the table.
    central_body : str
    rates : bool
        Whether angular velocities go along.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is not what its name says, the motion is an ensemble, or the file exists.
    """
    table = table_of(motion, calendar, reference_frame)
    epoch, times = _seconds_of(table)
    columns = [times, *table.quaternion[:, [1, 2, 3, 0]].T]
    omega = rates_per_second(table, rates)
    if omega is not None:
        columns += list(np.degrees(omega).T)
    lines = (
        "stk.v.8.0",
        "# q1 q2 q3 q0: x_reference = q x_body q~ (Hamilton product); rates in deg/s along the body axes",
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {times.size}",
        f"ScenarioEpoch {epoch}",
        "InterpolationOrder 1",
        f"CentralBody {ccsds.word('central_body', central_body)}",
        f"CoordinateAxes {_axes(table.reference_frame)}",
        "AttitudeTimeQuaternions" if len(columns) == 5 else "AttitudeTimeQuatAngVels",
        *(" ".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()),
        "END Attitude",
    )
    return write_text(path, "\n".join(lines) + "\n", overwrite)


def _seconds_of(table: AttitudeTable) -> tuple[str, Array]:
    """Return the date of t = 0 in UTC, and the seconds from there."""
    calendar = calendar_of(table)
    zero = calendar.date(0.0).utc
    zero.precision = 9
    begin = Calendar(str(zero.isot), "UTC")
    date, _, clock = begin.zero.partition("T")
    year, month, day = date.split("-")
    return f"{int(day)} {MONTHS[int(month) - 1]} {year} {clock}", begin.converted(table.times, calendar)


def _axes(frame: str) -> str:
    if frame in ("J2000", "EME2000"):
        return "J2000"
    known = ccsds.FRAMES[frame]
    if known not in WRITTEN_AXES and known != "ICRF":
        raise ValueError(f"reference_frame must be one that STK knows, got {frame}.")
    return WRITTEN_AXES.get(known, known)


class Stk(AttitudeFormat):
    """Attitude files of STK."""

    title = "STK"
    suffixes = (".a",)
    in_python = "pt.files.read_stk_attitude({path!r})"
    conventions = (
        "scalar last; QuatScalarFirst as it says",
        "turns the reference axes into those of the body: ours",
        "deg/s along the body",
    )
    read, write = staticmethod(read_stk_attitude), staticmethod(write_stk_attitude)

    @staticmethod
    @override
    def sniff(head: bytes) -> bool:
        return head.lstrip().lower().startswith(b"stk.v")
