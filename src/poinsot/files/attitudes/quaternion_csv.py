"""Quaternions as comma-separated values, whose first lines say their order and direction."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, check_rising, table_of
from poinsot.files.untrusted import read_text
from poinsot.mechanics.calendar import SECONDS, Calendar
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.propagation.trajectory import Trajectory

__all__ = ["read_quaternion_csv", "write_quaternion_csv"]

Array = NDArray[np.float64]

ORDERS = {"scalar first": ("QC", "Q1", "Q2", "Q3"), "scalar last": adm.QUATERNION}

DIRECTIONS = {"body to reference": True, "reference to body": False}
"""Whether the quaternion turns components along the body into those along the reference frame."""

RATE = "rad per unit of time, inertial, along the body axes"

EXAMPLE = "# order: scalar first, # direction: body to reference"


@checked
def read_quaternion_csv(path: str | Path, *, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in a CSV file that says the order and the direction of its quaternions.

    Comment lines before the names of the columns must say `# order: scalar first` (or `scalar last`) and
    `# direction: body to reference` (x_reference = q x_body q~, Hamilton product) or `reference to body`. They may say
    `# reference_frame: ICRF`, `# body_frame: SC_BODY_1` and `# time: s from 2026-11-21T00:00:00 UTC`. The columns are
    the time, the four of the quaternion and, where `# rate: rad per unit of time, inertial, along the body axes` stands
    above, three rates.

    Parameters
    ----------
    path : str or Path
    calendar : Calendar, optional
        Counts the times; default: the one that the file says, or none.

    Returns
    -------
    AttitudeTable

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file does not say what its numbers are, a row is not whole, a quaternion is off unit norm by more than a
        thousandth, or times do not rise.
    ImportError
        If astropy is missing and the file has dates.
    """
    name = str(path)
    says, rows, places = _parsed(read_text(path), name)
    order = _said(says, "order", ORDERS, name)
    to_reference = _said(says, "direction", DIRECTIONS, name)
    table = np.array(rows)
    check_rising(table[:, 0], places)
    columns = dict(zip(ORDERS[order], table[:, 1:5].T, strict=True))
    q, _, norm_error = adm.attitude_of(
        "QUATERNION",
        columns,
        None,
        rate_in_a=False,
        body_is_b=DIRECTIONS[to_reference],
        version="2.0",
        places=places,
    )
    omega = table[:, 5:] if table.shape[1] > 5 else None
    times, own = table[:, 0], _calendar(says, name)
    if own is not None and calendar is not None and calendar != own:
        times = calendar.converted(times, own)
        omega = None if omega is None else omega * (SECONDS[calendar.unit] / SECONDS[own.unit])
    return AttitudeTable(
        times,
        q,
        omega,
        calendar or own,
        says.get("reference_frame", SPACE_AXES_UNNAMED),
        says.get("body_frame", "SC_BODY_1"),
        norm_error,
    )


def _parsed(text: str, name: str) -> tuple[dict[str, str], list[list[float]], list[str]]:
    says: dict[str, str] = {}
    columns: list[str] = []
    rows: list[list[float]] = []
    places: list[str] = []
    for count, line in enumerate(text.splitlines(), start=1):
        place = f"{name}, line {count}"
        if line.startswith("#"):
            key, _, value = line[1:].partition(":")
            says[key.strip().lower()] = value.strip()
        elif line.strip() and not columns:
            columns = _columns(line, says, place)
        elif line.strip():
            rows.append(_numbers(line, columns, place))
            places.append(place)
    if not rows:
        raise ValueError(f"{name} must have the names of columns and rows, but it has no rows.")
    return says, rows, places


def _columns(line: str, says: dict[str, str], place: str) -> list[str]:
    columns = [column.strip().lower() for column in line.split(",")]
    names = "t,q0,q1,q2,q3 or t,q0,q1,q2,q3,omega_1,omega_2,omega_3"
    shape = "".join(column[:1] for column in columns)
    if shape not in ("tqqqq", "tqqqqooo"):
        raise ValueError(f"{place} must name the columns, such as {names}, got {line[:80]!r}.")
    if len(columns) == 8 and says.get("rate") != RATE:
        raise ValueError(f"{place} must come after a line that says what rates are, '# rate: {RATE}', got none.")
    return columns


def _numbers(line: str, columns: list[str], place: str) -> list[float]:
    texts = line.split(",")
    if len(texts) != len(columns):
        raise ValueError(f"{place} must have {len(columns)} numbers, got {line[:100]!r}.")
    return [ccsds.number(ccsds.Entry(key, text.strip(), place)) for key, text in zip(columns, texts, strict=True)]


def _said(says: dict[str, str], key: str, known: Mapping[str, object], name: str) -> str:
    value = says.get(key)
    if value not in known:
        given = "it does not" if value is None else f"it says {value[:40]!r}"
        raise ValueError(f"{name} must say its {key}, {' or '.join(known)}, but {given}. Write {EXAMPLE}.")
    return str(value)


def _calendar(says: dict[str, str], name: str) -> Calendar | None:
    if "time" not in says:
        return None
    match = re.fullmatch(r"(\w+) from (\S+) (\w+)", says["time"])
    try:
        calendar = Calendar(match[2], match[3], match[1]) if match else Calendar("", "UTC")
        calendar.date(0.0)
        return calendar
    except ValueError:
        raise ValueError(
            f"time in {name} must be such as 's from 2026-11-21T00:00:00 UTC', but it is {says['time'][:60]!r}."
        ) from None


# ------------------------------------------------------------------ writing


@checked
def write_quaternion_csv(
    motion: Trajectory | AttitudeTable,
    path: str | Path,
    *,
    calendar: Calendar | None = None,
    reference_frame: str | None = None,
    body_frame: str | None = None,
    rates: bool = True,
    overwrite: bool = False,
) -> Path:
    """Write the attitudes of a motion, or of a table, as comma-separated values that say what they are.

    Numbers have all their digits: reading them gives them back.

    Parameters
    ----------
    motion : Trajectory or AttitudeTable
    path : str or Path
    calendar : Calendar, optional
        What instant t = 0 is and the unit of the times; default: that of the system's orbits or of the table, if any.
    reference_frame, body_frame : str, optional
        Names that the file says; default: those of the motion, if any.
    rates : bool
        Whether angular velocities go along.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is not what its name says, the motion is an ensemble, or the file exists.
    """
    table = table_of(motion, calendar, reference_frame, body_frame, dated=False)
    columns, names = [table.times, *table.quaternion.T], "t,q0,q1,q2,q3"
    says = {
        "order": "scalar first",
        "direction": "body to reference",
        "convention": "x_reference = q x_body q~, Hamilton product",
        "reference_frame": ccsds.word("reference_frame", table.reference_frame),
        "body_frame": ccsds.word("body_frame", table.body_frame),
    }
    if table.calendar is not None:
        says["time"] = f"{table.calendar.unit} from {table.calendar.zero} {table.calendar.scale}"
    if rates and table.omega_body is not None:
        says["rate"] = RATE
        columns, names = columns + list(table.omega_body.T), f"{names},omega_1,omega_2,omega_3"
    lines = [f"# {key}: {value}" for key, value in says.items()] + [names]
    lines += [",".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


class QuaternionCsv(AttitudeFormat):
    """Tables that say their own conventions."""

    title = "table"
    suffixes = (".csv",)
    in_python = "pt.files.read_quaternion_csv({path!r})"
    conventions = ("said in the file", "said in the file", "as ours")
    read, write = staticmethod(read_quaternion_csv), staticmethod(write_quaternion_csv)

    @staticmethod
    @override
    def sniff(head: bytes) -> bool:
        return b"# direction:" in head
