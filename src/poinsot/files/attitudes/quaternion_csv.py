"""Quaternions as comma-separated values, whose first lines state order and direction."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files import ccsds
from poinsot.files.attitudes import adm
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, stated_calendar, statement_of, table_of
from poinsot.files.keys import Entry, Keys
from poinsot.files.rows import TextRows
from poinsot.files.untrusted import read_text
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.printable import quoted, shortened
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.calendar import SECONDS, Calendar

__all__ = ["read_quaternion_csv", "write_quaternion_csv"]

ORDERS = {"scalar first": ("QC", "Q1", "Q2", "Q3"), "scalar last": adm.QUATERNION}

DIRECTIONS = {"body to reference": True, "reference to body": False}
"""True if the quaternion rotates components along the body into components along the reference frame."""

CONVENTION = "x_reference = q x_body q~, Hamilton product"

RATE = "rad per unit of time, inertial, along the body axes"

OMEGA = ("omega_1", "omega_2", "omega_3")

KEYS = Keys(frozenset(("order", "direction", "reference_frame", "body_frame", "time", "rate", "convention")))

EXAMPLE = "# order: scalar first, # direction: body to reference"


@checked
def read_quaternion_csv(path: str | Path, *, calendar: Calendar | None = None) -> AttitudeTable:
    """Return the attitudes in a CSV file that states the order and the direction of its quaternions.

    Comment lines before the names of the columns must state `# order: scalar first` (or `scalar last`) and `#
    direction: body to reference` (x_reference = q x_body q~, Hamilton product) or `reference to body`. They may state
    `# reference_frame: ICRF`, `# body_frame: SC_BODY_1` and `# time: s from 2026-11-21T00:00:00 UTC`. The columns are
    the time, the four components of the quaternion and, after `# rate: rad per unit of time, inertial, along the body
    axes`, three components of the angular velocity.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    calendar : Calendar, optional
        Calendar of the times. Default: the calendar that the file states, or none.

    Returns
    -------
    AttitudeTable
        Attitudes, with rates if the file contains them.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or does not state the meaning of its numbers, a row is incomplete, the norm of a
        quaternion differs from 1 by more than a thousandth, times do not increase, or the file contains dates and
        astropy is not installed.

    Examples
    --------
    >>> pt.files.read_quaternion_csv("m.csv").omega_body.shape
    (9, 3)
    """
    name = shortened(path)
    rows = _parsed(read_text(path), name)
    own, (times,) = None, rows.stacked("t").T
    if "time" in rows.metadata:
        own = stated_calendar(rows.metadata["time"], f"time in {name}")
    rows.check_rising(times)
    factor = 1.0
    if own is not None and calendar is not None and calendar != own:
        times, factor = calendar.converted(times, own), SECONDS[calendar.unit] / SECONDS[own.unit]
    reference = rows.metadata.get("reference_frame") or SPACE_AXES_UNNAMED
    reference = reference if reference in ccsds.FRAMES else ccsds.FRAMES.get(reference.upper(), reference)
    frames = (reference, rows.metadata.get("body_frame") or "SC_BODY_1")
    body_is_b = DIRECTIONS[rows.metadata["direction"]]
    table = adm.read_attitudes(rows, "QUATERNION", times, calendar or own, frames, body_is_b=body_is_b)
    if len(rows.columns) == 5:
        return table
    return dataclasses.replace(table, omega_body=rows.stacked(*OMEGA, factor=factor))


def _parsed(text: str, name: str) -> TextRows:
    rows, header = TextRows(name), list[Entry]()
    for count, line in enumerate(text.splitlines(), start=1):
        place = f"{name}, line {count}"
        if line.startswith("#"):
            header += KEYS.in_comment(line, place, bool(rows.columns))
        elif line.strip() and not rows.columns:
            rows.metadata |= {key: entry.value for key, entry in KEYS.by_key(header).items()}
            rows.columns = _columns(line, rows.metadata, name, place)
        elif line.strip():
            rows.add(place, [text.strip() for text in line.split(",")])
    if not rows.numbers:
        raise ValueError(f"{name} must have the names of columns and rows, got no rows.")
    return rows


def _columns(line: str, stated: dict[str, str], name: str, place: str) -> tuple[str, ...]:
    """Return the columns by their names in this package, and check the statements of the file about them."""
    for key, known in (("order", ORDERS), ("direction", DIRECTIONS)):
        if stated.get(key) not in known:
            given = quoted(stated[key]) if key in stated else "none"
            raise ValueError(f"{name} must say its {key}, {' or '.join(known)}, got {given}. Write {EXAMPLE}.")
    if "Hamilton" not in stated.get("convention", CONVENTION):
        raise ValueError(f"{name} must have the convention {quoted(CONVENTION)}, got {quoted(stated['convention'])}.")
    names = [column.strip().lower() for column in line.split(",")]
    shape = "".join(column[:1] for column in names)
    if shape not in ("tqqqq", "tqqqqooo"):
        example = "t,q0,q1,q2,q3 or t,q0,q1,q2,q3,omega_1,omega_2,omega_3"
        raise ValueError(f"{place} must name the columns, such as {example}, got {quoted(line)}.")
    ends = [column[-1:] for column in names]
    vector = ends[2:5] if stated["order"] == "scalar first" else ends[1:4]
    for what, three in (("quaternion", vector), ("angular velocity", ends[5:])):
        if three and not _are_ordered("".join(three)):
            raise ValueError(
                f"{place} must name the components of the {what} in the order 1, 2, 3 or x, y, z, {stated['order']}, "
                f"got {quoted(line)}."
            )
    rates = OMEGA if len(shape) == 8 else ()
    if rates and stated.get("rate") != RATE:
        raise ValueError(f"{place} must follow a line that defines the rates, '# rate: {RATE}', got none.")
    return ("t", *ORDERS[stated["order"]], *rates)


def _are_ordered(ends: str) -> bool:
    """Return True if the last characters of three names number a vector in order, such as x, y, z. w is the scalar."""
    return "".join(sorted(set(ends))) == ends and "w" not in ends and (ends.isalpha() or ends.isdigit())


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
    """Write the attitudes of a motion, or of a table, as comma-separated values with their conventions.

    Numbers are written with all digits, so that reading the file restores them exactly.

    Parameters
    ----------
    motion, path, rates, overwrite
        Same as in `write_aem`.
    calendar, reference_frame, body_frame : optional
        Calendar and axes that the file states. Default: the calendar and axes of the motion, if any.

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
    >>> path = pt.files.write_quaternion_csv(motion, "new.csv")
    >>> path.read_text().splitlines()[6]
    't,q0,q1,q2,q3,omega_1,omega_2,omega_3'
    """
    table = table_of(motion, calendar, reference_frame, body_frame, dated=False)
    columns, names = [table.times[:, None], table.quaternion], "t,q0,q1,q2,q3"
    stated = {
        "order": "scalar first",
        "direction": "body to reference",
        "convention": CONVENTION,
        "reference_frame": ccsds.word("reference_frame", table.reference_frame),
        "body_frame": ccsds.word("body_frame", table.body_frame),
    }
    if table.calendar is not None:
        stated["time"] = statement_of(table.calendar)
    if rates and table.omega_body is not None:
        stated["rate"] = RATE
        columns, names = [*columns, table.omega_body], ",".join((names, *OMEGA))
    lines = [f"# {key}: {value}" for key, value in stated.items()] + [names]
    lines += [",".join(map(repr, row)) for row in np.concatenate(columns, axis=1).tolist()]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


class QuaternionCsv(AttitudeFormat):
    """Tables that state their conventions."""

    title = "table"
    suffixes = (".csv",)
    in_python = "pt.files.read_quaternion_csv({path!r})"
    conventions = ("stated in the file", "stated in the file", "as in poinsot")
    read, write = staticmethod(read_quaternion_csv), staticmethod(write_quaternion_csv)
    mark = re.compile(rb"# direction:")
