"""Rows that begin with a Julian date, and the calendar that counts their times."""

from __future__ import annotations

import dataclasses
import datetime as dt
import re
from collections.abc import Sequence
from decimal import Decimal

import numpy as np

from poinsot.files.rows import TextRows
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar, times_of_julian_dates

__all__ = ["JulianRows", "calendar_before", "check_not_falling", "iso_text", "julian_date"]

JULIAN_DATE = re.compile(r"\d{1,7}(\.\d{0,40})?", re.ASCII)
"""Text of a Julian date; longer texts cost time and have no more meaning."""

FIRST, LAST = Decimal(1721426), Decimal(5373484)
"""Julian dates of the years 1 to 9999."""

MIDNIGHT = Decimal("0.5")
ORDINAL_OF_ZERO = 1721424
"""Julian day, without its half, of the day before 0001-01-01."""


@dataclasses.dataclass
class JulianRows(TextRows):
    """Rows with a Julian date before their numbers."""

    dates: list[Decimal] = dataclasses.field(default_factory=list)

    def add_dated(self, place: str, texts: Sequence[str]) -> None:
        """Append a row of texts, the first of which is a Julian date."""
        if len(texts) != 1 + len(self.columns):
            given = " ".join(texts)[:100]
            raise ValueError(f"{place} must have JD and {', '.join(self.columns)}, got {quoted(given)}.")
        day = julian_date(texts[0].strip(), place)
        self.add(place, [text.strip() for text in texts[1:]], f"JD {day}")
        if self.dates and day < self.dates[-1]:
            raise ValueError(
                f"{place} must not be earlier than the row before, got JD {day} after JD {self.dates[-1]}."
            )
        self.dates.append(day)

    def times(self, scale: str, calendar: Calendar) -> Array:
        """Return the times of the rows, whose dates are in a time scale."""
        try:
            return times_of_julian_dates(self.dates, scale, calendar)
        except ValueError as error:
            raise ValueError(f"{self.places[0]} to {self.places[-1]}: {error}") from None


def julian_date(text: str, place: str) -> Decimal:
    """Return the Julian date in a text."""
    if not JULIAN_DATE.fullmatch(text):
        raise ValueError(f"{place} must have a Julian date for JD, got {quoted(text)}.")
    day = Decimal(text)
    if not FIRST <= day <= LAST:
        hint = " A modified Julian date is smaller by 2400000.5." if day < FIRST else ""
        raise ValueError(f"{place} must have a Julian date of the years 1 to 9999, got {quoted(text)}.{hint}")
    return day


def iso_text(date: Decimal) -> str:
    """Return a Julian date as "2000-01-01T12:00:00", rounded down to a second."""
    days, rest = divmod(date - MIDNIGHT, 1)
    day = dt.datetime.fromordinal(int(days) - ORDINAL_OF_ZERO)
    return (day + dt.timedelta(seconds=int(rest * SECONDS["d"]))).isoformat()


def calendar_before(date: Decimal, scale: str, unit: str) -> Calendar:
    """Return the calendar that counts from the midnight before a Julian date."""
    return Calendar(f"{iso_text(date)[:10]}T00:00:00", scale, unit)


def check_not_falling(times: Array, places: Sequence[str]) -> None:
    """Raise a ValueError if a row is earlier than the row before."""
    wrong = np.flatnonzero(np.diff(times) < 0)
    if wrong.size:
        i = int(wrong[0]) + 1
        raise ValueError(
            f"{places[i]} must not be earlier than the row before, got t = {times[i]:.15g} after {times[i - 1]:.15g}."
        )
