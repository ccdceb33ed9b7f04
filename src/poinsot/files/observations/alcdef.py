"""Light curves of asteroids in the exchange format ALCDEF."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.errors import level_of_user
from poinsot.files.observations.julian_rows import JulianRows, calendar_before, iso_text
from poinsot.files.observations.readings_csv import present_values, several
from poinsot.files.rows import number
from poinsot.files.untrusted import read_text
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import described, quoted, shortened
from poinsot.records.calendar import Calendar, julian_dates

__all__ = ["blocks_in", "read_alcdef", "write_alcdef"]

DELIMITERS = {"PIPE": "|", "TAB": "\t", "COMMA": ",", "SEMICOLON": ";"}

START, END, END_OF_DATA, DATA = "STARTMETADATA", "ENDMETADATA", "ENDDATA", "DATA"

EPOCH = "EPOCH"
"""Key that a block may repeat for its comparison stars; the first one is stored."""

KEY = re.compile(r"[A-Z][A-Z0-9]{0,30}")

CORRECTED = ("AVERAGE", "POINT")
"""Values of LTCAPP of times from which the light time is subtracted."""

NO_METADATA: Mapping[str, str] = {}

MAX_CHARACTERS = 255
"""Longest line of the standard."""


class AlcdefBlock(NamedTuple):
    """One light curve: its metadata, and its rows with the number of columns in the first one."""

    rows: JulianRows
    place: str


@checked
def read_alcdef(path: str | Path, observable: Observable, *, calendar: Calendar | None = None) -> list[Readings]:
    """Return the light curves in an ALCDEF file, version 2 of the standard.

    A file contains one block for each light curve: `STARTMETADATA`, lines `KEY=VALUE`, `ENDMETADATA`, and lines
    `DATA=JD|magnitude|error|airmass`, of which the last two numbers are optional. The Julian dates are UTC; their times
    are counted by the calendar, in whose scale they differ by about 69 s for TDB.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    observable : Observable
        Observable with one number, such as a `LightCurve` of magnitudes. The file contains no geometry.
    calendar : Calendar, optional
        Calendar of the times. Default: days of TDB from the midnight before the first datum.

    Returns
    -------
    list of Readings
        One for each block. `attributes` contains the metadata by the keys of the file.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or is not ALCDEF, a block is incomplete, a number is not finite, times fall, the
        light time is already subtracted (LTCAPP) from times of an observable with a light time of its own, or astropy
        is not installed.

    Examples
    --------
    >>> class Magnitude(pt.Observable):
    ...     def reading(self, instant):
    ...         return 7.3 + instant.omega_body[0]
    >>> curves = pt.files.read_alcdef("alcdef.txt", Magnitude(), calendar=pt.Calendar("2011-09-13", "TDB", "d"))
    >>> curves[0].attributes["OBJECTNAME"]
    'Ceres'
    """
    if observable.components:
        raise ValueError(
            f"observable must read one number, got the components {', '.join(observable.components)}. ALCDEF contains "
            "magnitudes."
        )
    blocks = blocks_in(path)
    counted = calendar or calendar_before(min(block.rows.dates[0] for block in blocks), "TDB", "d")
    return [_readings(block, observable, counted, i) for i, block in enumerate(blocks, start=1)]


def _readings(block: AlcdefBlock, observable: Observable, calendar: Calendar, count: int) -> Readings:
    rows = block.rows
    applied = rows.metadata.get("LTCAPP", "NONE").upper()
    if applied in CORRECTED and getattr(observable, "light_time", False):
        raise ValueError(
            f"LTCAPP of {block.place} must be NONE for an observable with light_time=True, got {quoted(applied)}. Pass "
            "an observable with light_time=False."
        )
    values = np.array(rows.numbers)
    sigma = values[:, 1] if values.shape[1] > 1 else None
    if sigma is not None and not np.all(sigma > 0):
        warnings.warn(
            f"errors of {block.place} should be positive, got {np.min(sigma):g}. The readings have no sigma.",
            stacklevel=level_of_user(),
        )
        sigma = None
    name = " ".join(filter(None, (rows.metadata.get("OBJECTNAME"), rows.metadata.get("SESSIONDATE")))) or str(count)
    attributes = {**rows.metadata, "units": "mag"}
    return Readings(
        observable,
        rows.times("UTC", calendar),
        values[:, 0],
        sigma,
        name=name,
        calendar=calendar,
        attributes=attributes,
    )


# ------------------------------------------------------------------ blocks


def blocks_in(path: str | Path) -> list[AlcdefBlock]:
    """Return the light curves in a file, each with at least one datum."""
    return list(_blocks(read_text(path), shortened(path)))


def _blocks(text: str, name: str) -> Iterator[AlcdefBlock]:
    reader = _Reader(name)
    for count, line in enumerate(text.splitlines(), start=1):
        if line.strip() and not line.startswith("#"):
            yield from reader.take(line.strip("\r\n"), f"{name}, line {count}")
    yield from reader.ended(f"{name} must end after a block of data")


class _Reader:
    """Reader of the lines of a file, which completes one block after the other."""

    def __init__(self, name: str) -> None:
        self._name, self._within, self._ends = name, "", list[bool]()
        self._block: AlcdefBlock | None = None

    def take(self, line: str, place: str) -> Iterator[AlcdefBlock]:
        """Read one line, and yield the block that it ends."""
        word = line.strip().upper()
        if word == START:
            yield from self.ended(f"{place} must follow a block of data") if self._block else ()
            rows = JulianRows(f"the block from {place}", columns=())
            self._block, self._within = AlcdefBlock(rows, f"the block from {place}"), START
            return
        if self._block is None and not self._ends:
            raise ValueError(
                f"{place} must begin a block of ALCDEF with {START}, got {quoted(line[:60])}. Is it another format?"
            )
        if word == END and self._within == START:
            self._within = END
        elif word == END_OF_DATA and self._within == END:
            yield from self.ended(place, ended=True)
        elif self._block is None or "=" not in line:
            raise ValueError(f"{place} must be KEY=VALUE, {START} or {END_OF_DATA}, got {quoted(line[:60])}.")
        else:
            self._take_pair(self._block, line, place)

    def _take_pair(self, block: AlcdefBlock, line: str, place: str) -> None:
        key, _, value = line.partition("=")
        key, value, metadata = key.strip().upper(), value.strip(" "), block.rows.metadata
        if key == DATA:
            if self._within != END:
                raise ValueError(f"{place} must follow {END}, got {quoted(line[:60])}.")
            _add_datum(block.rows, value, place)
        elif self._within != START:
            raise ValueError(f"{place} must be {DATA}=..., {END_OF_DATA} or {START}, got {quoted(line[:60])}.")
        elif not KEY.fullmatch(key):
            raise ValueError(f"{place} must have a key of capital letters and digits, got {quoted(key[:60])}.")
        elif key == "COMMENT" and key in metadata:
            metadata[key] += f"\n{value}"
        elif key in metadata and key != EPOCH and metadata[key] != value:
            raise ValueError(f"{place} must not repeat {key}, got {quoted(value)} after {quoted(metadata[key])}.")
        else:
            metadata.setdefault(key, value)

    def ended(self, what: str, ended: bool = False) -> Iterator[AlcdefBlock]:
        """Yield the block that ends here, which has at least one datum; either all blocks have ENDDATA, or none."""
        block, self._block = self._block, None
        if block is None:
            if not self._ends:
                raise ValueError(f"{self._name} must have a block of ALCDEF that begins with {START}, got none.")
            return
        if self._within == START:
            raise ValueError(f"{what}, got no {END} in {block.place}. Is the file truncated?")
        if not block.rows.dates:
            raise ValueError(f"{block.place} must have lines {DATA}=JD|magnitude, got none.")
        if self._ends and self._ends[0] != ended:
            raise ValueError(
                f"{block.place} must end with {END_OF_DATA} as others do, got none. Is the file truncated?"
            )
        self._ends.append(ended)
        yield block


def _add_datum(rows: JulianRows, value: str, place: str) -> None:
    """Append a datum: date and magnitude, and the error if the first datum has one; the airmass is checked alone."""
    stated = rows.metadata.get("DELIMITER", "PIPE").upper()
    if stated not in DELIMITERS:
        raise ValueError(f"DELIMITER of {rows.name} must be one of {', '.join(DELIMITERS)}, got {quoted(stated)}.")
    cells = [cell.strip() for cell in value.split(DELIMITERS[stated])]
    while len(cells) > 2 and not cells[-1]:
        cells.pop()
    if not 2 <= len(cells) <= 4:
        raise ValueError(
            f"{place} must have JD, magnitude and optionally error and airmass, separated by {stated}, got "
            f"{quoted(value[:60])}."
        )
    if len(cells) == 4:
        number("airmass", cells.pop(), place)
    rows.columns = rows.columns or ("magnitude", "error")[: len(cells) - 1]
    rows.add_dated(place, cells)


# ------------------------------------------------------------------ writing


@checked
def write_alcdef(
    readings: Readings | Sequence[Readings],
    path: str | Path,
    *,
    metadata: Mapping[str, str] = NO_METADATA,
    overwrite: bool = False,
) -> Path:
    """Write magnitudes as light curves in the format ALCDEF 2.

    Keys of the `attributes` of readings from a file are written again. Julian dates are UTC, with the digits that
    restore times to 1e-10 s.

    Parameters
    ----------
    readings : Readings or sequence of Readings
        Magnitudes with a calendar; one block for each.
    path : str or Path
        Name of the file.
    metadata : mapping of str
        Values by key for all blocks, such as {"OBJECTNUMBER": "433", "OBJECTNAME": "Eros", "CONTACTNAME": "A. Name"}.
    overwrite : bool
        True to replace an existing file.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError, ImportError
        If the readings are no magnitudes, are absent at a time or have no calendar, a key or value of the metadata is
        invalid, the file exists, or astropy is not installed.

    Examples
    --------
    >>> class Magnitude(pt.Observable):
    ...     def reading(self, instant):
    ...         return 7.3 + instant.omega_body[0]
    >>> curves = pt.files.read_alcdef("alcdef.txt", Magnitude())
    >>> path = pt.files.write_alcdef(curves, "again.txt")
    >>> path.read_text().splitlines()[0]
    'STARTMETADATA'
    """
    for entry in metadata.items():
        if not all(isinstance(word, str) for word in entry):
            raise TypeError(f"metadata must be texts by text, got {' and '.join(map(described, entry))}.")
    lines = [line for each in several(readings) for line in _block_of(each, metadata)]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


def _block_of(readings: Readings, metadata: Mapping[str, str]) -> Iterator[str]:
    values, calendar, observable = present_values(readings), readings.calendar, readings.observable
    if observable.components or readings.attributes.get("units") != "mag":
        unit = readings.attributes.get("units", "none")
        raise ValueError(f"readings must be magnitudes, in mag, for ALCDEF, got {readings.name} in the unit {unit}.")
    if calendar is None:
        raise ValueError(
            f"times of {readings.name} must have a calendar, got none. ALCDEF contains Julian dates. "
            "Give the readings, an orbit or the scenario a calendar."
        )
    dates = julian_dates(readings.times, "UTC", calendar)
    own = {key: value for key, value in readings.attributes.items() if KEY.fullmatch(key)}
    known = _defaults(readings, dates) | own | dict(metadata) | {"DELIMITER": "PIPE"}
    yield START
    for key, value in known.items():
        for each in value.split("\n") if key == "COMMENT" else (value,):
            if not KEY.fullmatch(key) or not each.isprintable() or len(f"{key}={each}") > MAX_CHARACTERS:
                raise ValueError(
                    f"metadata must be keys of capital letters and values of one line of at most {MAX_CHARACTERS} "
                    f"characters, got {quoted(key)}: {quoted(each)}."
                )
            yield f"{key}={each}"
    yield END
    columns = [dates, map(repr, values.tolist())]
    if readings.sigma is not None:
        columns.append(map(repr, np.broadcast_to(readings.sigma, values.shape).tolist()))
    yield from (f"{DATA}={'|'.join(row)}" for row in zip(*columns, strict=True))
    yield END_OF_DATA


def _defaults(readings: Readings, dates: Sequence[str]) -> dict[str, str]:
    """Return the metadata that the standard requires, of an unnamed object."""
    middle = iso_text(Decimal(dates[len(dates) // 2]))
    corrected = getattr(readings.observable, "light_time", True) is False
    return {
        "OBJECTNUMBER": "0",
        "OBJECTNAME": readings.name,
        "SESSIONDATE": middle[:10],
        "SESSIONTIME": middle[11:19],
        "CONTACTNAME": "NONE",
        "OBSERVERS": "NONE",
        "FILTER": "C",
        "MAGBAND": "C",
        "DIFFERMAGS": "FALSE",
        "STANDARD": "NONE",
        "LTCAPP": "POINT" if corrected else "NONE",
        "REDUCEDMAGS": "NONE",
    }
