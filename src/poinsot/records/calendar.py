"""The dates that the times of an orbit stand for."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime as dt
import decimal
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import DATES, optional, real_numbers
from poinsot.immutable import Immutable
from poinsot.printable import kind_of, quoted, shortened
from poinsot.quantities import MAX_AXES

__all__ = [
    "SCALES",
    "Calendar",
    "attributes_of_time",
    "checked_calendar",
    "holds_dates",
    "julian_dates",
    "leap_second_gone",
    "span_of",
    "times_of_julian_dates",
]

SCALES = {"UTC": "tai", "TAI": "tai", "GPS": "tai", "TT": "tt", "TDB": "tdb", "TCB": "tcb", "TCG": "tcg"}
"""Scales, each with the uniform one in which its time is counted."""

SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
"""Units of time."""

GPS_BEHIND_TAI = 19
"""Seconds by which GPS time is behind TAI."""

DIGITS_OF_SECOND = 10
"""Number of stored decimal digits of a second."""

MAX_SECONDS = 1e12
"""Largest distance of a date from the zero of the calendar, seconds."""

FIRST_YEAR_OF_UTC = 1960
FIRST_JULIAN_DATE_OF_UTC = Decimal("2436934.5")

JULIAN_DATE_OF_YEAR_1 = Decimal("1721424.5")
"""Julian date of the day before 0001-01-01, of which Python counts the days that follow."""

JULIAN_DIGITS = 50
"""Decimal digits of the arithmetic of Julian dates."""

JULIAN_DECIMALS_OF_SECOND = 26
"""Decimals to which seconds since a zero within a day are rounded, as no decimal number is a third of a day."""

MIN_DECIMALS, MAX_DECIMALS, MAX_DECIMALS_CONVERTED = 6, 32, 16
"""Numbers of decimals of a written Julian date. Conversions between scales are exact to 16 decimals."""

_DATE = r"(?P<year>\d{4})-(?P<day>\d\d-\d\d|\d{3})"
_CLOCK = r"(?P<clock>\d\d:\d\d(:\d\d(\.\d*)?)?)"
_EPOCH = re.compile(rf"{_DATE}([T ]{_CLOCK})?( *(?P<scale>[A-Za-z0-9]+))?", re.ASCII)


@dataclasses.dataclass(frozen=True)
class Calendar(Immutable):
    """Calendar that converts between dates and times: the date of time 0, its time scale and the unit of time.

    `time(epoch)` converts dates to times, and `date(time)` converts times to dates. Dates require astropy; numbers do
    not. UTC includes the leap seconds that astropy contains and assumes no later ones. It begins in 1960.

    Parameters
    ----------
    zero : str
        Date of t = 0, such as "2000-01-01T12:00:00", or with the day of the year "2000-001T12:00:00".
    scale : {"UTC", "TAI", "GPS", "TT", "TDB", "TCB", "TCG"}
        Time scale of `zero`. Time is counted in this scale, except that a calendar with a UTC or GPS date counts in
        TAI, so that a leap second has the length of any other second.
    unit : {"s", "min", "h", "d"}
        Unit of time; a day has 86400 s.

    Raises
    ------
    ValueError
        If the date is invalid, or the scale or the unit is unknown.

    Examples
    --------
    >>> calendar = pt.Calendar("2000-01-01T12:00:00", "TDB", "d")
    >>> calendar.time("2000-01-02T12:00:00 TDB")
    1.0
    """

    zero: str
    scale: str
    unit: str = "s"

    def __post_init__(self) -> None:
        for name, value, known in (("scale", self.scale, SCALES), ("unit", self.unit, SECONDS)):
            if not isinstance(value, str) or value not in known:
                raise ValueError(f"{name} must be one of {', '.join(known)}, got {quoted(value)}.")
        if not isinstance(self.zero, str):
            raise TypeError(f"zero must be text such as '2026-11-21T00:00:00', got {quoted(self.zero)}.")
        date, scale = _read(self.zero)
        if scale:
            raise ValueError(
                f"zero must be a date without a scale, got {quoted(self.zero)}. The scale is its own field."
            )
        object.__setattr__(self, "zero", date)

    def time(self, epoch: Any) -> Any:
        """Return the time of a date, or of an array of dates.

        Parameters
        ----------
        epoch : str, astropy.time.Time, datetime with a time zone, float, or array of these
            Date with its time scale: "2026-11-21T00:00:00 UTC", "... TDB". A final Z means UTC. A number is already a
            time and is returned unchanged.

        Returns
        -------
        float or array
            Time since `zero`, accurate to half a nanosecond within 50 days of zero and to 0.1 microseconds within 30
            years.

        Raises
        ------
        ValueError
            If a date is invalid or lacks a time scale.
        ImportError
            If a date is given and astropy is not installed.
        """
        if _is_instant(epoch):
            times = self._counted(epoch)
        elif isinstance(epoch, str | DATES):
            times = self._of_texts([_text(epoch)])[0]
        elif holds_dates(epoch):
            times = self._of_array(_rectangular(epoch))
        else:
            times = real_numbers("epoch", epoch, self.unit)
        return float(times) if np.ndim(times) == 0 else times

    def date(self, time: Any) -> Any:
        """Return the dates of times as an `astropy.time.Time` in the scale of this calendar (TAI for GPS)."""
        times = real_numbers("time", time, self.unit)
        if np.any(np.abs(times) > MAX_SECONDS / SECONDS[self.unit]):
            raise ValueError(f"time must be within 30000 years of {self.zero} to be a date, got {quoted(time)}.")
        seconds = times * SECONDS[self.unit]
        counted = SCALES[self.scale]
        with _offline() as astropy:
            passed = astropy.TimeDelta(seconds, format="sec", scale=counted)
            instant = getattr(self._origin(astropy), counted) + passed
            return instant.utc if self.scale == "UTC" else instant

    def converted(self, times: NDArray[np.float64], calendar: Calendar) -> NDArray[np.float64]:
        """Return the times of this calendar at the instants that another calendar denotes by `times`."""
        return times if calendar == self else np.asarray(self.time(calendar.date(times)))

    def _of_array(self, epochs: NDArray[Any]) -> NDArray[np.float64]:
        if epochs.dtype.kind in "UM":
            return self._of_texts(epochs.astype(str).ravel().tolist()).reshape(epochs.shape)
        return np.array([self.time(epoch) for epoch in epochs.ravel()]).reshape(epochs.shape)

    def _of_texts(self, texts: list[str]) -> NDArray[np.float64]:
        """Return the times of dates, those of one scale at once."""
        read = [_read(text) for text in texts]
        times = np.empty(len(texts))
        for scale in {scale for _, scale in read}:
            if scale is None:
                text = next(text for text, (_, none) in zip(texts, read, strict=True) if none is None)
                raise ValueError(
                    f"epoch must state its time scale, got {quoted(text)}. Write '{shortened(text.strip())} UTC', or "
                    f"TDB, TT."
                )
            chosen = [i for i, (_, other) in enumerate(read) if other == scale]
            with _offline() as astropy:
                times[chosen] = self._counted(_instant(astropy, [read[i][0] for i in chosen], scale))
        return times

    def _counted(self, instants: Any) -> Any:
        """Return the time between zero and instants."""
        counted = SCALES[self.scale]
        with _offline() as astropy:
            passed = getattr(instants, counted) - getattr(self._origin(astropy), counted)
        # The first part is whole days or their half, so that its product is exact; the second has some 1e-12 s of
        # rounding in it, without which whole seconds stay whole.
        return np.round(passed.jd1 * 86400 + passed.jd2 * 86400, DIGITS_OF_SECOND) / SECONDS[self.unit]

    def _origin(self, astropy: Any) -> Any:
        return _instant(astropy, self.zero, self.scale)


def checked_calendar(calendar: Any) -> Calendar:
    """Return a calendar of an orbit in km and km/s, which must count seconds."""
    if not isinstance(calendar, Calendar):
        raise TypeError(f"calendar must be a Calendar, got {kind_of(calendar)}.")
    if calendar.unit != "s":
        raise ValueError(f"calendar must count seconds for an orbit in km and km/s, got {calendar}.")
    return calendar


def attributes_of_time(calendar: Calendar | None) -> dict[str, str]:
    """Return the attributes of the times. The unit names no date, because a decoded date has fewer digits."""
    if calendar is None:
        return {"long_name": "time"}
    counted = {"tai": "TAI", "tt": "TT", "tdb": "TDB", "tcb": "TCB", "tcg": "TCG"}[SCALES[calendar.scale]]
    return {
        "long_name": f"time since {calendar.zero} {calendar.scale}, counted in {counted}",
        "epoch": calendar.zero,
        "scale": calendar.scale,
        "counted_in": counted,
    }


def leap_second_gone(instants: Any) -> Any:
    """Return the part of a leap second that has passed since midnight, in days of 86400 s; zero on all other days.

    The Julian date of UTC counts a day with a leap second as one day, so that its fraction runs slowly on that day.
    The Julian date of UT1 is the Julian date of UTC plus this part plus UT1 - UTC.

    Parameters
    ----------
    instants : astropy.time.Time
        In any scale.
    """
    with _offline():
        erfa = optional("erfa", "dates")
        year, month, day, fraction = erfa.jd2cal(instants.utc.jd1, instants.utc.jd2)
        start, noon = (erfa.dat(year, month, day, part) for part in (0.0, 0.5))
        era, midnight = erfa.cal2jd(year, month, day)
        *tomorrow, _ = erfa.jd2cal(era, midnight + 1)
        leap = np.round(erfa.dat(*tomorrow, 0.0) - (2 * noon - start), 6)  # without the rate of UTC before 1972
    return fraction * leap / 86400


def span_of(calendar: Any, start: Any, stop: Any) -> tuple[float, float]:
    """Return the times of two instants, the second later than the first, in seconds of a calendar."""
    first, last = (checked_calendar(calendar).time(instant) for instant in (start, stop))
    if np.ndim(first) or np.ndim(last):
        raise ValueError(f"start and stop must be single instants, got {quoted(start)} and {quoted(stop)}.")
    if not first < last:
        raise ValueError(f"stop must be later than start, got {quoted(stop)} and {quoted(start)}.")
    return first, last


def times_of_julian_dates(dates: Sequence[Decimal], scale: str, calendar: Calendar) -> NDArray[np.float64]:
    """Return the times of Julian dates in a time scale, correctly rounded if the calendar counts in this scale."""
    with decimal.localcontext() as context:
        context.prec = JULIAN_DIGITS
        if _counts_in(calendar, scale):
            zero, day = _julian_zero(calendar), Decimal(SECONDS["d"])
            seconds = [round((date - zero) * day, JULIAN_DECIMALS_OF_SECOND) for date in dates]
            return np.array([float(passed / SECONDS[calendar.unit]) for passed in seconds])
        if scale == "UTC" and dates and min(dates) < FIRST_JULIAN_DATE_OF_UTC:
            raise ValueError(f"Julian dates must be in {FIRST_YEAR_OF_UTC} or later in UTC, got {min(dates)}.")
        whole = [float(date // 1) for date in dates]
        rest = [float(date % 1) for date in dates]
    with _offline() as astropy:
        instants = astropy.Time(whole, rest, format="jd", scale=scale.lower())
        return np.asarray(calendar.time(instants)).reshape(len(dates))


def julian_dates(times: NDArray[np.float64], scale: str, calendar: Calendar) -> list[str]:
    """Return the Julian dates of times in a time scale as texts with the fewest decimals that restore the times."""
    with decimal.localcontext() as context:
        context.prec = JULIAN_DIGITS
        if _counts_in(calendar, scale):
            most, zero, day = MAX_DECIMALS, _julian_zero(calendar), Decimal(SECONDS["d"]) / SECONDS[calendar.unit]
            exact = [zero + Decimal(time) / day for time in times.tolist()]
        else:
            most = MAX_DECIMALS_CONVERTED
            with _offline():
                instants = getattr(calendar.date(times), scale.lower())
            exact = [Decimal(a) + Decimal(b) for a, b in zip(instants.jd1.tolist(), instants.jd2.tolist(), strict=True)]
        return _shortest(exact, times, most, lambda dates: times_of_julian_dates(dates, scale, calendar))


def _shortest(
    exact: list[Decimal], times: NDArray[np.float64], most: int, read: Callable[[list[Decimal]], NDArray[np.float64]]
) -> list[str]:
    """Return decimal numbers as texts with the fewest decimals from which `read` restores the times."""
    texts, missing = [""] * len(exact), np.arange(len(exact))
    for decimals in range(MIN_DECIMALS, most + 1):
        for i in missing:
            texts[i] = f"{exact[i]:.{decimals}f}"
        if missing.size:
            missing = missing[read([Decimal(texts[i]) for i in missing]) != times[missing]]
    return texts


def _counts_in(calendar: Calendar, scale: str) -> bool:
    """Return True if a calendar begins and counts in a scale without leap seconds."""
    return calendar.scale == scale and SCALES[scale].upper() == scale


def _julian_zero(calendar: Calendar) -> Decimal:
    """Return the Julian date of the time 0 of a calendar, in its scale."""
    day, _, clock = calendar.zero.partition("T")
    hours, minutes, seconds = clock.split(":")
    passed = 3600 * int(hours) + 60 * int(minutes) + Decimal(seconds)
    return JULIAN_DATE_OF_YEAR_1 + dt.date.fromisoformat(day).toordinal() + passed / SECONDS["d"]


def _is_instant(value: Any) -> bool:
    module = sys.modules.get("astropy.time")  # without which there is no Time
    return module is not None and isinstance(value, module.Time)


def holds_dates(values: Any) -> bool:
    """Return True for a date, and for a list or an array that begins with a date."""
    first = values
    for _ in range(MAX_AXES):  # a list may contain itself
        if isinstance(first, np.ndarray) and first.size:
            first = first.flat[0]  # a row of a matrix is a matrix
        elif isinstance(first, list | tuple) and first:
            first = first[0]
    return isinstance(first, str | DATES) or _is_instant(first)


def _text(date: Any) -> str:
    """Return a date as text: in UTC if it has a time zone, else without a scale."""
    if isinstance(date, dt.datetime) and date.tzinfo is not None:
        return date.astimezone(dt.UTC).replace(tzinfo=None).isoformat() + " UTC"
    return date.isoformat() if isinstance(date, dt.date) else str(date)


def _rectangular(epochs: Any) -> NDArray[Any]:
    try:
        return np.asarray(epochs)
    except ValueError:
        raise ValueError(f"epoch must be an array of dates, got rows of unequal length: {quoted(epochs)}.") from None


def _read(text: Any) -> tuple[str, str | None]:
    """Return a date in full, "2000-01-01T12:00:00", and its scale if it says one."""
    match = _EPOCH.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise ValueError(f"epoch must be a date such as '2026-11-21T00:00:00 UTC', got {quoted(text)}.")
    scale = "UTC" if match["scale"] in ("Z", "z") else match["scale"] and match["scale"].upper()
    if scale is not None and scale not in SCALES:
        raise ValueError(f"epoch must be in one of the scales {', '.join(SCALES)}, got {quoted(text)}.")
    if scale == "UTC" and int(match["year"]) < FIRST_YEAR_OF_UTC:
        raise ValueError(f"epoch must be in {FIRST_YEAR_OF_UTC} or later in UTC, got {quoted(text)}. Say it in TT.")
    day = match["day"] if "-" in match["day"] else _month_and_day(match["year"], match["day"], text)
    clock = match["clock"] or "00:00"
    return f"{match['year']}-{day}T{clock}" + (":00" if len(clock) == 5 else ""), scale


def _month_and_day(year: str, day: str, text: str) -> str:
    with contextlib.suppress(ValueError, OverflowError):
        date = dt.date(int(year), 1, 1) + dt.timedelta(int(day) - 1)
        if date.year == int(year):
            return date.strftime("%m-%d")
    raise ValueError(f"epoch must be a date that exists, got {quoted(text)}.")


def _instant(astropy: Any, dates: Any, scale: str) -> Any:
    """Return one date or several, in full and of one scale, as an astropy Time."""
    try:
        instants = astropy.Time(dates, format="isot", scale="tai" if scale == "GPS" else scale.lower())
    except (ValueError, optional("erfa", "dates").ErfaWarning):
        raise ValueError(f"epoch must be a date that exists in {scale}, got {quoted(dates)}.") from None
    behind = astropy.TimeDelta(GPS_BEHIND_TAI, format="sec", scale="tai")
    return instants + behind if scale == "GPS" else instants


@contextlib.contextmanager
def _offline() -> Iterator[Any]:
    """Give `astropy.time` with the tables that it brings, and without its warning of leap seconds to come."""
    astropy = optional("astropy.time", "dates")
    tables = optional("astropy.utils.iers", "dates")
    with tables.conf.set_temp("auto_download", False), warnings.catch_warnings():
        kind = optional("erfa", "dates").ErfaWarning
        warnings.filterwarnings("error", category=kind)  # a second after the end of a day
        warnings.filterwarnings("ignore", message=".*dubious year", category=kind)
        yield astropy
