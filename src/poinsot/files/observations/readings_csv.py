"""Readings as comma-separated values with named columns: gyros, star trackers, light curves."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.files.attitudes.attitude_table import stated_calendar, statement_of
from poinsot.files.keys import Entry, Keys
from poinsot.files.observations.julian_rows import check_not_falling
from poinsot.files.rows import TextRows, number
from poinsot.files.untrusted import read_text
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import quoted, shortened
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar
from poinsot.suggestions import nearest

__all__ = ["read_gyro_csv", "read_readings_csv", "write_readings_csv"]

KEYS = Keys(frozenset(("readings", "time", "time_unit", "unit", "frame", "sigma")), ("observable",))

TIME, VALUE, SIGMA = "t", "value", "sigma"
"""Names of the columns of readings of one number; the columns of several numbers have the names of the components."""

OF_RECORDING = ("t_s", "wx", "wy", "wz")
"""Names of the columns of a recording of a gyroscope: the time in s, and rates in rad/s."""

OF_CUTS = ("file", "cut_start_s", "cut_end_s", "keep")
"""Names of the columns of a table of cuts: the recording, the first and the last time in s, and "false" to omit it."""


@checked
def read_readings_csv(
    path: str | Path,
    observable: Observable,
    *,
    columns: Sequence[str] | None = None,
    sigma: ArrayLike | None = None,
    calendar: Calendar | None = None,
) -> Readings:
    """Return the readings of an observable in a CSV file whose first line names its columns.

    The columns are the time, the components of the reading, and optionally their standard deviations. The reader
    ignores other columns. Comment lines before the names may state `# time: d from 2012-10-10T00:00:00 TDB`, `# unit:
    mag`, `# frame: body`, `# readings: NAME` and `# sigma: 0.02`. An empty cell is the absence of a reading.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    observable : Observable
        Instrument of the readings.
    columns : sequence of str, optional
        Names of the columns in the file: the time, each component, and optionally each standard deviation. Default:
        t and the names of the components, or t and value, with sigma_NAME or sigma if the file has these columns.
    sigma : float or array, optional
        Standard deviation of each value, if the file states none.
    calendar : Calendar, optional
        Calendar of the times. Default: the calendar that the file states, or none.

    Returns
    -------
    Readings
        Readings in the order of the file.

    Raises
    ------
    OSError, TypeError, ValueError, ImportError
        If the file cannot be read or lacks a column, a row is incomplete or not finite, times fall, or calendars
        differ and astropy is not installed.

    Examples
    --------
    >>> class Rates(pt.Observable):
    ...     components = ("x", "y", "z")
    ...     def reading(self, instant):
    ...         return instant.omega_body
    >>> pt.files.read_readings_csv("gyro.csv", Rates(), columns=["t_s", "wx", "wy", "wz"]).values.shape
    (3, 3)
    """
    name = shortened(path)
    own = () if columns is None else tuple(columns)
    rows, values = _parsed(read_text(path), name, observable, own)
    stated, times = rows.metadata, values[:, 0]
    check_not_falling(times, rows.places)
    if "time" in stated:
        counted = stated_calendar(stated["time"], f"time in {name}")
        times = times if calendar is None else calendar.converted(times, counted)
        calendar = calendar or counted
    count = max(len(observable.components), 1)
    readings, errors = values[:, 1 : 1 + count], values[:, 1 + count :]
    if errors.size or "sigma" in stated:
        if sigma is not None:
            raise ValueError(f"sigma must not be given for {name}, which states it, got both.")
        sigma = errors if errors.size else number("sigma", stated["sigma"], name)
    attributes = {"time_units": stated.get("time_unit") or "1"} if calendar is None else {}
    attributes |= {key: stated[own] for key, own in (("units", "unit"), ("frame", "frame")) if stated.get(own)}
    given: dict[str, Any] = {"name": stated.get("readings", ""), "calendar": calendar, "attributes": attributes}
    if not observable.components:
        readings = readings[:, 0]
        sigma = errors[:, 0] if errors.size else sigma
    try:
        return Readings(observable, times, readings, sigma, **given)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


@checked
def read_gyro_csv(
    path: str | Path, gyro: Observable, *, cuts: str | Path | None = None, sigma: ArrayLike | None = None
) -> list[Readings]:
    """Return the recording of a gyroscope, such as the one of a phone, whole or cut into several arcs.

    The first line of the file names the columns t_s, wx, wy and wz: seconds, and rad/s along the axes of the gyroscope.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    gyro : Observable
        Instrument of the readings, such as `Gyro`.
    cuts : str or Path, optional
        CSV file with the columns file, cut_start_s, cut_end_s and keep. A row is an arc of the recording whose name,
        without its ending, is equal to `file` or ends in an underscore and `file`. Rows with keep = false are omitted.
    sigma : float or array, optional
        Standard deviation of each value. Default: `noise` of the observable.

    Returns
    -------
    list of Readings
        Readings of each arc in the order of the cuts, or of the whole recording, in s and rad/s.

    Raises
    ------
    OSError, TypeError, ValueError
        If a file cannot be read or lacks a column, or an arc contains no reading.

    Examples
    --------
    >>> gyro = pt.observables.Gyro(noise=0.05)
    >>> [len(each) for each in pt.files.read_gyro_csv("gyro.csv", gyro)]
    [3]
    """
    whole = read_readings_csv(path, gyro, columns=OF_RECORDING, sigma=sigma)
    attributes = {"units": "rad s-1", "frame": "body", **whole.attributes, "time_units": "s"}

    def arc(name: str, some: NDArray[np.bool_] | slice) -> Readings:
        part = whole.isel(time=some)
        return Readings(gyro, part.times, part.values, part.sigma, name=name, attributes=attributes)

    if cuts is None:
        return [arc(Path(path).stem, slice(None))]
    found: list[Readings] = []
    for place, name, first, last in _cuts(read_text(cuts), shortened(cuts), Path(path).stem):
        inside = (whole.times >= first) & (whole.times <= last)
        if not inside.any():
            raise ValueError(
                f"{place} must have readings between cut_start_s and cut_end_s, got none of {shortened(path)} from "
                f"{first:.10g} to {last:.10g}."
            )
        found.append(arc(f"{name} {len(found) + 1}", inside))
    if not found:
        raise ValueError(f"{shortened(cuts)} must have a cut of {quoted(Path(path).stem)} to keep, got none.")
    return found


def _cuts(text: str, name: str, recording: str) -> Iterator[tuple[str, str, float, float]]:
    """Yield place, name, start and end of each cut of a recording to keep."""
    for place, (file, start, stop, keep) in _rows_of_cuts(text, name):
        if keep.lower() not in ("", "true", "false"):
            raise ValueError(f"{place} must have true, false or nothing for keep, got {quoted(keep)}.")
        if file and keep.lower() != "false" and f"_{recording}".endswith(f"_{file}"):
            yield place, file, number("cut_start_s", start, place), number("cut_end_s", stop, place)


def _rows_of_cuts(text: str, name: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the place of each row and its cells in the columns of cuts."""
    try:
        columns, *rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines())] or [[]]
    except csv.Error as error:
        raise ValueError(f"{name} must be comma-separated values: {error}.") from None
    if missing := [each for each in OF_CUTS if each not in columns]:
        raise ValueError(f"{name}, line 1 must name the columns {', '.join(OF_CUTS)}, got no {quoted(missing[0])}.")
    for count, cells in enumerate(rows, start=2):
        place = f"{name}, line {count}"
        if cells and len(cells) != len(columns):
            raise ValueError(f"{place} must have {len(columns)} cells, got {len(cells)}.")
        if cells:
            yield place, [cells[columns.index(each)] for each in OF_CUTS]


def _parsed(text: str, name: str, observable: Observable, given: tuple[str, ...]) -> tuple[TextRows, Array]:
    """Return the rows of a text and the numbers in the columns of time, components and standard deviations."""
    rows, header, found = TextRows(name), list[Entry](), list[int]()
    numbers = list[list[float]]()
    for count, line in enumerate(text.splitlines(), start=1):
        place = f"{name}, line {count}"
        if line.startswith("#"):
            header += KEYS.in_comment(line, place, bool(found))
        elif line.strip() and not found:
            rows.metadata |= {key: entry.value for key, entry in KEYS.by_key(header).items()}
            rows.columns = tuple(column.strip() for column in line.split(","))
            found = _places_of_columns(rows.columns, observable, given, place)
        elif line.strip():
            cells = [cell.strip() for cell in line.split(",")]
            if len(cells) != len(rows.columns):
                raise ValueError(f"{place} must have {len(rows.columns)} cells, got {len(cells)}.")
            rows.places.append(place)
            numbers.append([_cell(rows.columns[i], cells[i], place, k) for k, i in enumerate(found)])
    if not numbers:
        raise ValueError(f"{name} must have the names of columns and rows, got no rows.")
    return rows, np.array(numbers)


def _cell(column: str, text: str, place: str, k: int) -> float:
    """Return a cell as a number: NaN if a reading is absent, which a time cannot be."""
    return number(column, text, place) if text or k == 0 else np.nan


def _places_of_columns(
    columns: tuple[str, ...], observable: Observable, given: tuple[str, ...], place: str
) -> list[int]:
    """Return the places of the columns of the time, the components and, if there are any, the standard deviations."""
    components = observable.components or (VALUE,)
    errors = tuple(f"{SIGMA}_{error}" for error in observable.errors) or (SIGMA,)
    wanted = given or (TIME, *components)
    lengths = (1 + len(components), 1 + len(components) + len(errors))
    if len(wanted) not in lengths or len(set(wanted)) < len(wanted):
        raise ValueError(
            f"columns must be {lengths[0]} or {lengths[1]} different names: the time, {', '.join(components)} and "
            f"their standard deviations, got {', '.join(map(quoted, wanted))}."
        )
    for column in wanted:
        if columns.count(column) != 1:
            known = nearest(column, columns)
            times = "none" if column not in columns else "several"
            raise ValueError(f"{place} must name the column {quoted(column)} once, got {times}.{known}")
    if not given and set(errors) <= set(columns):
        wanted = (*wanted, *errors)
    return [columns.index(column) for column in wanted]


@checked
def write_readings_csv(readings: Readings, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write readings of one body as comma-separated values with named columns.

    Numbers are written with all digits, so that `read_readings_csv` restores them exactly.

    Parameters
    ----------
    readings : Readings
        Readings with values.
    path : str or Path
        Name of the file.
    overwrite : bool
        True to replace an existing file.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If the readings are a plan or of an ensemble, or the file exists.

    Examples
    --------
    >>> class Rates(pt.Observable):
    ...     components = ("x", "y", "z")
    ...     def reading(self, instant):
    ...         return instant.omega_body
    >>> path = pt.files.write_readings_csv(pt.observe(motion, Rates()), "rates.csv")
    >>> path.read_text().splitlines()[-1][:4]
    '20.0'
    """
    values, observable = values_of_one_body(readings), readings.observable
    components, errors = observable.components or (VALUE,), observable.errors
    names, columns = [TIME, *components], [readings.times[:, None], values.reshape(readings.times.size, -1)]
    stated = {"readings": readings.name, "observable": repr(observable)}
    if readings.calendar is not None:
        stated["time"] = statement_of(readings.calendar)
    elif readings.attributes["time_units"] != "1":
        stated["time_unit"] = readings.attributes["time_units"]
    stated |= {own: readings.attributes.get(key, "") for key, own in (("units", "unit"), ("frame", "frame"))}
    if readings.sigma is not None and readings.sigma.ndim == 0:
        stated["sigma"] = repr(float(readings.sigma))
    elif readings.sigma is not None:
        names += [f"{SIGMA}_{error}" for error in errors] or [SIGMA]
        full = np.broadcast_to(readings.sigma, (readings.times.size, *((len(errors),) if errors else ())))
        columns.append(full.reshape(readings.times.size, -1))
    lines = [f"# {key}: {' '.join(value.split())}" for key, value in stated.items() if value] + [",".join(names)]
    rows = np.concatenate(columns, axis=1).tolist()
    lines += [",".join("" if value != value else repr(value) for value in row) for row in rows]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


def several(readings: Readings | Sequence[Readings]) -> list[Readings]:
    """Return one or several readings as a list, which must not be empty."""
    found = [readings] if isinstance(readings, Readings) else list(readings)
    if not found:
        raise ValueError("readings must not be empty, got none.")
    return found


def values_of_one_body(readings: Readings) -> Array:
    """Return the values of readings; refuse a plan and an ensemble."""
    if readings.values is None:
        raise ValueError("readings must have values to be written, got a plan of measurements.")
    if readings.is_ensemble:
        raise ValueError(
            f"readings must be of one body, got {len(readings.values)} members. Take readings.isel(member=0)."
        )
    return readings.values


def present_values(readings: Readings) -> Array:
    """Return the values of readings of one body, none of which is NaN; files of light curves cannot omit one."""
    values = values_of_one_body(readings)
    absent = np.flatnonzero(np.isnan(values).reshape(readings.times.size, -1).any(axis=1))
    if absent.size:
        raise ValueError(
            f"readings must be present at all times, got none of {readings.name} at t = "
            f"{readings.times[absent[0]]:.10g}. Take readings.isel(time=~np.isnan(readings.values))."
        )
    return values
