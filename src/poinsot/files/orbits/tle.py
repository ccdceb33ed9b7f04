"""Earth satellites from the mean elements of two-line element sets and of CCSDS Orbit Mean-Elements Messages."""

from __future__ import annotations

import contextlib
import csv
import datetime as dt
import itertools
import json
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from poinsot.checked import checked
from poinsot.errors import DATES, level_of_user, optional, real_array
from poinsot.files import ccsds
from poinsot.files.keys import Entry, Keys
from poinsot.files.untrusted import local_name, parsed_xml
from poinsot.orbits.attractors import attractor_radius
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.printable import described, quoted
from poinsot.quantities import Array, Date
from poinsot.records.calendar import Calendar, span_of

__all__ = ["omm_orbit", "tle_orbit"]

MU_WGS72 = 398600.8
"""km3/s2, of the gravity field that SGP4 and the elements are made with."""

POLYNOMIAL_TOLERANCE = 1e-10
"""Tolerance of the polynomials, relative to the distance; SGP4 itself is accurate to a km."""

VELOCITIES_COMPARED = 4001
"""Times at which SGP4's velocity is compared with the derivative of its position."""

MAX_VELOCITY_DIFFERENCE = 0.01
"""km/s. The difference is 4 m/s or less for all sets of Vallado et al. (2006) but object 23333, where it is 312 m/s."""

MAX_CHARACTERS = 1_000_000

LINES = (
    re.compile(
        r"1 (?P<number>[A-Z\d ][\d ]{3}\d)[A-Z ] [\w ]{8} (?P<year>\d\d)(?P<day>[\d ]{2}\d\.\d{8}) "
        r"[ +-]\.\d{8} [ +-]\d{5}[ +-]\d [ +-]\d{5}[ +-]\d (?P<kind>[\d ]) [\d ]{4}\d",
        re.ASCII,
    ),
    re.compile(
        r"2 (?P<number>[A-Z\d ][\d ]{3}\d) [\d ]{2}\d\.\d{4} [\d ]{2}\d\.\d{4} \d{7} [\d ]{2}\d\.\d{4} "
        r"[\d ]{2}\d\.\d{4} [\d ]\d\.\d{8}[\d ]{5}\d",
        re.ASCII,
    ),
)
"""The two lines of a set, column by column."""

ELEMENTS = {
    "MEAN_MOTION": (0, 20),
    "ECCENTRICITY": (0, 1),
    "INCLINATION": (0, 180),
    "RA_OF_ASC_NODE": (-360, 360),
    "ARG_OF_PERICENTER": (-360, 360),
    "MEAN_ANOMALY": (-360, 360),
    "BSTAR": (-10, 10),
}
"""Fields that SGP4 requires in addition to the epoch, and their ranges: revolutions a day, degrees, 1 / radius."""

COMPONENTS = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
"""Components of the covariance, whose entries are CX_X, CY_X and so on."""

UNUSED = {
    "NORAD_CAT_ID": "0",
    "OBJECT_ID": "",
    "CLASSIFICATION_TYPE": "U",
    "ELEMENT_SET_NO": "0",
    "REV_AT_EPOCH": "0",
    "MEAN_MOTION_DOT": "0",
    "MEAN_MOTION_DDOT": "0",
    "EPHEMERIS_TYPE": "0",
}
"""Fields of a message that no position depends on, with values that SGP4's initialisation takes."""

ONLY = {
    "CENTER_NAME": ("EARTH",),
    "REF_FRAME": ("TEME",),
    "TIME_SYSTEM": ("UTC",),
    "EPHEMERIS_TYPE": ("0", "2"),
    "MEAN_ELEMENT_THEORY": ("SGP4", "SGP/SGP4"),
}
"""Allowed values of fields that a message may contain."""

IGNORED = {"GM": MU_WGS72, "REF_FRAME_EPOCH": None}
"""Fields that SGP4 replaces by a constant, and by the epoch of the elements for the axes."""

OTHER_THEORIES = ("SEMI_MAJOR_AXIS", "BTERM", "AGOM")
"""Fields of a message whose elements are for another theory."""

KEYS = Keys(
    frozenset(("EPOCH", *ELEMENTS, *ONLY, *IGNORED, *OTHER_THEORIES)),
    frozenset(
        (
            *("CCSDS_OMM_VERS", "OBJECT_NAME", *ccsds.HEADER, *UNUSED),
            *("MASS", "SOLAR_RAD_AREA", "SOLAR_RAD_COEFF", "DRAG_AREA", "DRAG_COEFF", "COV_REF_FRAME"),
            *(f"C{a}_{b}" for a, b in itertools.combinations_with_replacement(COMPONENTS[::-1], 2)),
            # Fields that Space-Track adds to its messages.
            *("SEMIMAJOR_AXIS", "PERIOD", "APOAPSIS", "PERIAPSIS", "OBJECT_TYPE", "RCS_SIZE", "COUNTRY_CODE"),
            *("LAUNCH_DATE", "SITE", "DECAY_DATE", "DECAYED", "FILE", "GP_ID", "TLE_LINE0", "TLE_LINE1", "TLE_LINE2"),
        )
    ),
    repeated=("COMMENT",),
)
"""Fields of a message."""

FRAMES = ("TEME", "ICRF")

MESSAGE = "message"
"""The name of a message in errors."""


@checked
def tle_orbit(
    lines: str | Sequence[str],
    start: Date,
    stop: Date,
    *,
    max_age: float = 14.0,
    reference_frame: str = "TEME",
    calendar: Calendar | None = None,
) -> Ephemeris:
    """Return the position of an Earth satellite from a two-line element set, by SGP4.

    Parameters
    ----------
    lines : str or sequence of str
        The two lines, optionally preceded by a line with the name, as one text or one by one.
    start, stop : float, str or astropy.time.Time
        Ends of the span: times of the calendar, or dates with their time scale.
    max_age : float
        Largest distance of the span from the epoch of the set, days. The errors of SGP4 grow to kilometres within days.
    reference_frame : {"TEME", "ICRF"}
        Axes of the result: true equator and mean equinox of date, the axes of SGP4; or the axes of planetary
        ephemerides, which require astropy.
    calendar : Calendar, optional
        Calendar in seconds. Default: from the epoch of the set, in UTC. Orbits of one system must share one calendar.

    Returns
    -------
    Ephemeris
        Position in km and velocity in km/s, with the `mu` of WGS-72, 398600.8 km3/s2. Time is elapsed time: a minute of
        SGP4 is 60 s also at a leap second of UTC. The velocity is the derivative of SGP4's position. SGP4's own
        velocity differs by metres per second; a warning reports a difference of more than 10 m/s. SGP4's position jumps
        where the perturbed inclination of a deep-space orbit crosses 0.2 rad; a warning gives time and size.

    Raises
    ------
    ValueError, ImportError
        If a line is invalid, the span is too far from the epoch, SGP4 stops in the span (a satellite that decays), or
        the package sgp4 is not installed.

    Examples
    --------
    >>> lines = (
    ...     "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    ...     "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
    ... )
    >>> pt.files.tle_orbit(lines, 0.0, 600.0).origin
    'EARTH'
    """
    first, second = _set_of(lines)
    satellite = optional("sgp4.api", "two-line element sets").Satrec.twoline2rv(first, second)
    return _orbit(satellite, _epoch_of(first), start, stop, max_age, reference_frame, calendar)


@checked
def omm_orbit(
    message: str | Mapping[str, Any],
    start: Date,
    stop: Date,
    *,
    max_age: float = 14.0,
    reference_frame: str = "TEME",
    calendar: Calendar | None = None,
) -> Ephemeris:
    """Return the position of an Earth satellite from a CCSDS Orbit Mean-Elements Message for SGP4.

    Parameters
    ----------
    message : str or mapping
        Text of a message about one satellite, in XML, KVN, CSV or JSON, or a mapping of its fields by name.
    start, stop, max_age, reference_frame, calendar
        Same as in `tle_orbit`.

    Returns
    -------
    Ephemeris
        Position in km and velocity in km/s, as from `tle_orbit`.

    Raises
    ------
    ValueError, ImportError
        If a field is missing or wrong, the elements are not for SGP4, `tle_orbit` raises an error, or the package sgp4
        is not installed.

    Examples
    --------
    >>> fields = dict(EPOCH="2000-06-27T18:50:19.73", MEAN_MOTION=10.824, ECCENTRICITY=0.186, INCLINATION=34.27)
    >>> fields |= dict(RA_OF_ASC_NODE=348.7, ARG_OF_PERICENTER=331.8, MEAN_ANOMALY=19.3, BSTAR=2.8e-5)
    >>> pt.files.omm_orbit(fields, 0.0, 600.0).reference_frame
    'TEME'
    """
    fields = _checked_fields(_fields_of(message))
    satellite = optional("sgp4.api", "mean elements").Satrec()
    fields["EPOCH"] = _epoch_of_message(fields["EPOCH"])
    optional("sgp4.omm", "mean elements").initialize(satellite, fields)
    epoch = Calendar(fields["EPOCH"], "UTC")
    return _orbit(satellite, epoch, start, stop, max_age, reference_frame, calendar)


def _orbit(
    satellite: Any,
    epoch: Calendar,
    start: Date,
    stop: Date,
    max_age: float,
    reference_frame: str,
    calendar: Calendar | None,
) -> Ephemeris:
    if reference_frame not in FRAMES:
        raise ValueError(f"reference_frame must be one of {', '.join(FRAMES)}, got {quoted(reference_frame)}.")
    calendar = epoch if calendar is None else calendar
    first, last = span_of(calendar, start, stop)
    ages, most = epoch.converted(np.array([first, last]), calendar) / 86400, float(real_array("max_age", max_age, ()))
    oldest = ages[np.argmax(np.abs(ages))]
    if abs(oldest) > most:
        raise ValueError(
            f"start and stop must be at most {most:.6g} days from the epoch {epoch.zero} UTC of the elements, got "
            f"{abs(oldest):.6g} days {'after' if oldest > 0 else 'before'} it. Take newer elements, or say how old they"
            " may be: max_age."
        )

    def along_axes(times: Array) -> tuple[Array, Array]:
        elapsed = epoch.converted(times, calendar)
        places, velocities = _propagated(satellite, elapsed, epoch)
        if reference_frame == "TEME":
            return places, velocities
        dates = epoch.date(elapsed)
        return _in_icrf(places, dates), _in_icrf(velocities, dates)

    orbit = Ephemeris.from_function(
        MU_WGS72,
        position=lambda times: along_axes(times)[0],
        start=first,
        stop=last,
        tolerance=POLYNOMIAL_TOLERANCE,
        reference_frame=reference_frame,
        origin="EARTH",
        calendar=calendar,
        radius=attractor_radius("EARTH"),
    )
    times = np.linspace(first, last, VELOCITIES_COMPARED)
    _warn_of_velocity(times, np.stack([*orbit.velocity_at(times)], axis=-1) - along_axes(times)[1])
    return orbit


def _warn_of_velocity(times: Array, differences: Array) -> None:
    """Warn where the derivative of SGP4's position, which is the velocity of the orbit, is far from SGP4's velocity."""
    sizes = np.linalg.norm(differences, axis=-1)
    worst = int(np.argmax(sizes))
    if sizes[worst] > MAX_VELOCITY_DIFFERENCE:
        warnings.warn(
            f"the velocity of SGP4 must be within {MAX_VELOCITY_DIFFERENCE} km/s of the derivative of its position, "
            f"got {sizes[worst]:.3g} km/s at t = {times[worst]:.10g}. velocity_at returns the derivative.",
            stacklevel=level_of_user(),
        )


def _propagated(satellite: Any, seconds: Array, epoch: Calendar) -> tuple[Array, Array]:
    """Return the positions and velocities at seconds from the epoch, km and km/s, TEME."""
    days, rest = np.divmod(seconds / 86400, 1)
    errors, places, velocities = satellite.sgp4_array(satellite.jdsatepoch + days, satellite.jdsatepochF + rest)
    if np.any(errors):
        i = int(np.argmax(errors != 0))
        reason = optional("sgp4.api", "mean elements").SGP4_ERRORS.get(int(errors[i]), f"error {errors[i]}")
        raise ValueError(
            f"start and stop must be times at which SGP4 has a position, got {seconds[i]:.6g} s from the epoch "
            f"{epoch.zero} UTC: {reason}."
        )
    return np.asarray(places), np.asarray(velocities)


def _in_icrf(places: Array, dates: Any) -> Array:
    """Turn positions from TEME to the Earth by its sidereal time of 1982, and to the ICRF by today's rotation.

    Elements are fitted to what is seen from the Earth with that sidereal time (Vallado et al. 2006, AIAA 2006-6753);
    the mean equinox of today is elsewhere, by up to 60 mas in 2030. UTC stands for UT1: their difference cancels.
    """
    erfa = optional("erfa", "positions along the ICRF")
    instants, turned_at = (dates.tt.jd1, dates.tt.jd2), (dates.utc.jd1, dates.utc.jd2)
    apart = erfa.gmst82(*turned_at) - erfa.gmst00(*turned_at, *instants) - erfa.ee00b(*instants)
    turned = erfa.rxp(erfa.rz(apart, np.eye(3)), places)
    return np.asarray(erfa.trxp(erfa.pnm00b(*instants), turned))


# ------------------------------------------------------------------ two-line element sets


def _set_of(lines: str | Sequence[str]) -> tuple[str, str]:
    """Return the two lines of the one set, checked."""
    if isinstance(lines, str):
        if len(lines) > MAX_CHARACTERS:
            raise ValueError(f"lines must be one set of elements, got {len(lines)} characters.")
        lines = lines.splitlines()
    if not isinstance(lines, Sequence) or not all(isinstance(line, str) for line in lines):
        raise TypeError(f"lines must be the two lines of a set as text, got {described(lines)}.")
    given = [line.rstrip() for line in lines if line.strip()]
    if len(given) == 3:
        given = given[1:]  # after the name
    if len(given) != 2:
        raise ValueError(f"lines must be the two lines of one set, perhaps after its name, got {len(given)} lines.")
    numbers = [_checked_line(line, i) for i, line in enumerate(given)]
    if numbers[0] != numbers[1]:
        raise ValueError(f"lines must be of one satellite, got {numbers[0].strip()} and {numbers[1].strip()}.")
    return given[0], given[1]


def _checked_line(line: str, index: int) -> str:
    """Return the number of the satellite."""
    match = LINES[index].fullmatch(line)
    if match is None:
        raise ValueError(f"line {index + 1} must have the 69 columns of line {index + 1} of a set, got {quoted(line)}.")
    checksum = sum(int(c) if c.isdigit() else c == "-" for c in line[:68]) % 10
    if checksum != int(line[68]):
        raise ValueError(f"line {index + 1} must end in its checksum {checksum}, got {line[68]}.")
    if index == 0 and match["kind"] == "4":
        raise ValueError("lines must be elements for SGP4, got type 4, which is for SGP4-XP.")
    return match["number"]


def _epoch_of(line: str) -> Calendar:
    """Return the calendar from the epoch of a first line, whose digits are whole microseconds."""
    year, day, part = int(line[18:20]), int(line[20:23]), int(line[24:32])
    january = dt.datetime(1900 + year if year >= 57 else 2000 + year, 1, 1)
    date = january + dt.timedelta(days=day - 1, microseconds=part * 864)
    if date.year != january.year:
        raise ValueError(f"line 1 must have an epoch within its year, got day {line[20:32].strip()}.")
    return Calendar(date.isoformat(timespec="microseconds"), "UTC")


# ------------------------------------------------------------------ orbit mean-elements messages


def _fields_of(message: str | Mapping[str, Any]) -> dict[str, str]:
    if isinstance(message, Mapping):
        wrong = [x for item in message.items() for x in item if not isinstance(x, str | int | float | DATES | None)]
        if wrong:
            raise TypeError(f"message must be a mapping of texts and numbers, got {described(wrong[0])} in it.")
        found = [_entries_of_fields(message.items())]
    elif len(message) > MAX_CHARACTERS:
        raise ValueError(f"message must be about one satellite, got {len(message)} characters.")
    else:
        found = _entries_of_text(message.strip().lstrip("\ufeff"))
    if len(found) != 1:
        raise ValueError(f"message must be about one satellite, got {len(found)}.")
    return {key: entry.value for key, entry in KEYS.by_key(found[0]).items()}


def _entries_of_text(text: str) -> list[list[Entry]]:
    """Return the fields of each satellite in a message."""
    if text.startswith("<"):
        segments = [part for part in parsed_xml(text, MESSAGE).iter() if local_name(part) == "segment"]
        return [
            [entry for half in segment for child in half for entry in ccsds.entries_of(child, MESSAGE)]
            for segment in segments
        ]
    if text.startswith(("{", "[")):
        return _entries_of_json(text)
    if "=" in text:
        numbered = enumerate(map(str.strip, text.splitlines()), start=1)
        lines = [(count, line) for count, line in numbered if line and not re.match(r"COMMENT\b", line)]
        return [[ccsds.kvn_entry(line, f"{MESSAGE}, line {count}", "KEY = VALUE") for count, line in lines]]
    return _entries_of_csv(text)


def _entries_of_fields(fields: Iterable[tuple[Any, Any]]) -> list[Entry]:
    return [Entry(str(key), str(value).strip(), MESSAGE) for key, value in fields if value is not None]


def _entries_of_json(text: str) -> list[list[Entry]]:
    try:
        content = json.loads(text, object_pairs_hook=tuple)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"message must be JSON where it begins with a bracket, got an error: {error}.") from None
    found = content if isinstance(content, list) else [content]
    if not all(isinstance(fields, tuple) for fields in found):
        raise ValueError("message must be the fields of a satellite by name, got other JSON.")
    return [_entries_of_fields(fields) for fields in found]


def _entries_of_csv(text: str) -> list[list[Entry]]:
    try:
        rows = [row for row in csv.reader(text.splitlines()) if row]
    except csv.Error as error:
        raise ValueError(f"message must be XML, KVN, CSV or JSON, got an error: {error}.") from None
    names = [name.strip() for name in rows[0]] if rows else []
    for row in rows[1:]:
        if len(row) != len(names):
            raise ValueError(f"message must have a value for each of the {len(names)} columns, got {len(row)} values.")
    return [_entries_of_fields(zip(names, row, strict=True)) for row in rows[1:]]


def _checked_fields(fields: dict[str, str]) -> dict[str, str]:
    for name in ("EPOCH", *ELEMENTS):
        if not fields.get(name):
            raise ValueError(f"message must have the field {name}, got none.")
    for name, (low, high) in ELEMENTS.items():
        with contextlib.suppress(ValueError):
            if low <= float(fields[name]) <= high:
                continue
        raise ValueError(f"{name} must be a number from {low} to {high}, got {quoted(fields[name])}.")
    for name, allowed in ONLY.items():
        if fields.get(name) and fields[name].upper() not in allowed:
            raise ValueError(f"{name} must be {' or '.join(allowed)} for SGP4, got {quoted(fields[name])}.")
    _check_theory(fields)
    return UNUSED | {name: fields[name] for name in ("EPOCH", *ELEMENTS)}


def _check_theory(fields: dict[str, str]) -> None:
    """Raise a ValueError for fields of other theories, and warn of fields that SGP4 cannot use."""
    for name in OTHER_THEORIES:
        if fields.get(name):
            raise ValueError(
                f"{name} must be absent from elements for SGP4, got {quoted(fields[name])}. SGP4 uses MEAN_MOTION and "
                "BSTAR."
            )
    for name, expected in IGNORED.items():
        if fields.get(name) and not _is_number(fields[name], expected):
            warnings.warn(
                f"{name} should be {expected or 'absent'} for SGP4, got {fields[name][:40]!r}, which is ignored.",
                stacklevel=level_of_user(),
            )


def _is_number(text: str, value: float | None) -> bool:
    with contextlib.suppress(ValueError):
        return float(text) == value
    return False


def _epoch_of_message(text: str) -> str:
    """Return the date, with six digits of the second as the package sgp4 needs them."""
    date, _, fraction = Calendar(text.removesuffix("Z"), "UTC").zero.partition(".")
    if len(fraction) > 6 and fraction[6:].strip("0"):
        raise ValueError(f"EPOCH must have at most six digits of a second, got {quoted(text)}.")
    return f"{date}.{fraction[:6].ljust(6, '0')}"
