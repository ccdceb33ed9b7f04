"""Light curves in the format of DAMIT, the database of asteroid models from inversion techniques."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.files.observations.julian_rows import JulianRows, calendar_before
from poinsot.files.observations.readings_csv import present_values, several
from poinsot.files.untrusted import read_text
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Orbit
from poinsot.observables.light_curve import LightCurve, Outline
from poinsot.observables.readings import Readings
from poinsot.orbits.attractors import attractor_mu
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.orbits.planets import AU
from poinsot.orbits.theories import PLANETS_TO_ICRF
from poinsot.printable import quoted, shortened
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar, julian_dates
from poinsot.shapes.scattering import ScatteringLaw

__all__ = ["curves_in", "read_damit", "write_damit"]

COLUMNS = ("brightness", "Sun x", "Sun y", "Sun z", "Earth x", "Earth y", "Earth z")

CALIBRATED = "calibrated"
"""Attribute of readings with the flag of the light curve."""

FLAGS = {"0": False, "1": True}
"""Meaning of the flag of a light curve."""

OTHER_SCALES = ("UTC", "TAI", "GPS")
"""Scales that differ from TDB by half a minute or more."""

SCALES = ("TDB", "TT", "TAI", "UTC")

DECIMALS, MAX_DECIMALS, ROUNDING = 12, 16, 2e-14
"""Decimals of written coordinates in au: 12 if they restore a coordinate up to its rounding, else 16."""

MAX_DISTANCE = 1e6
"""au."""

LIGHT_SECONDS_PER_AU = 499.004783836
"""Light time of an astronomical unit, s (IAU 2012, Resolution B2)."""

LIGHT_TIME_STEPS = 4
"""Iterations of the light time, each of which reduces its error by v/c, at most 1e-3."""

SAME_PLACE = 1e-5
"""Largest distance, in au, between two positions at one time."""


@checked
def read_damit(
    path: str | Path,
    shape: Outline | Sequence[Outline],
    law: ScatteringLaw,
    *,
    calendar: Calendar | None = None,
    scale: str | None = None,
    sigma: ArrayLike | None = None,
    au: float = AU,
) -> list[Readings]:
    """Return the light curves in a file of DAMIT (lc.txt).

    The file contains the number of curves, for each curve a line with the number of data and a flag (0: relative, 1:
    calibrated), and a line for each datum: Julian date, brightness reduced to unit distances, position of the Sun and
    position of the Earth relative to the asteroid in au along the ecliptic axes of J2000. The Julian dates are
    corrected for light time. The unit of brightness is arbitrary: one for each relative curve, and one for all
    calibrated curves.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    shape : Mesh, Ellipsoid or Facets, or two of these
        Surface of the asteroid, as in `LightCurve`.
    law : ScatteringLaw
        Law of reflection; all curves have the same object.
    calendar : Calendar, optional
        Calendar of the times, in TDB or TT. Default: days of TDB from the midnight before the first datum.
    scale : {"TDB", "TT", "TAI", "UTC"}, optional
        Time scale of the Julian dates; any calendar is then possible. Default: TDB.
    sigma : float or array, optional
        Standard deviation of each brightness, as the files contain none.
    au : float
        Astronomical unit in the unit of length of the shape. Default: in km.

    Returns
    -------
    list of Readings
        One for each curve, of a `LightCurve` of the kind "relative". Its orbits along the ICRF pass through the
        positions of the file and are defined between the first and the last datum, or within a day of a single datum.
        `attributes["calibrated"]` is the flag.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or is in another format, incomplete or too long, a number is not finite, times fall,
        or the calendar counts in a scale with leap seconds and `scale` is not given.

    Examples
    --------
    >>> law = pt.observables.LommelSeeliger(albedo=0.2)
    >>> curves = pt.files.read_damit("lc.txt", pt.shapes.Ellipsoid((9, 6, 5), density=1.0), law)
    >>> len(curves), curves[0].times.size
    (2, 3)
    """
    name = shortened(path)
    refuse_nonpositive("au", real_array("au", au, ()))
    if scale is not None and scale not in SCALES:
        raise ValueError(f"scale must be one of {', '.join(SCALES)}, got {quoted(scale)}.")
    if scale is None and calendar is not None and calendar.scale in OTHER_SCALES:
        raise ValueError(
            f"calendar must count in TDB as the light curves of DAMIT, got {calendar.scale}. Pass a calendar in TDB, "
            f"or scale='TDB' to convert the dates, or scale='UTC' if the dates in {name} are UTC."
        )
    curves = curves_in(path)
    scale = scale or "TDB"
    counted = calendar or calendar_before(min(rows.dates[0] for rows, _ in curves), "TDB", "d")
    readings = []
    for count, (rows, calibrated) in enumerate(curves, start=1):
        times, numbers = rows.times(scale, counted), np.array(rows.numbers)
        sun, observer = (
            _orbit(times, numbers[:, k : k + 3], rows.places, counted, center, float(au))
            for k, center in ((1, "SUN"), (4, "EARTH"))
        )
        curve = LightCurve(shape, law, sun, observer, kind="relative", light_time=False, astronomical_unit=float(au))
        flag = str(int(calibrated))
        about: dict[str, Any] = {"name": f"curve {count}", "calendar": counted, "attributes": {CALIBRATED: flag}}
        readings.append(Readings(curve, times, numbers[:, 0], sigma, **about))
    return readings


def curves_in(path: str | Path) -> list[tuple[JulianRows, bool]]:
    """Return the rows of each curve in a file, and True if it is calibrated."""
    return list(_curves(read_text(path), shortened(path)))


def _curves(text: str, name: str) -> Iterator[tuple[JulianRows, bool]]:
    """Yield the rows of each curve in a text, and True if it is calibrated."""
    lines = ((f"{name}, line {i}", line.split()) for i, line in enumerate(text.splitlines(), 1) if line.strip())
    place, words = next(lines, (name, []))
    if len(words) != 1 or (total := _whole(words[0])) is None:
        raise ValueError(
            f"{place} must have the number of light curves, as files of DAMIT do, got {quoted(' '.join(words)[:60])}. "
            "Is it another format?"
        )
    for count in range(1, total + 1):
        place, words = next(lines, (name, []))
        points = _whole(words[0]) if len(words) == 2 else None
        if points is None or words[1] not in FLAGS:
            given = quoted(" ".join(words)[:60]) if words else "the end of the file"
            raise ValueError(
                f"{place} must have the number of data of curve {count} of {total} and its flag, 0 or 1, got {given}."
            )
        rows = JulianRows(name, columns=COLUMNS)
        for _ in range(points):
            row = next(lines, None)
            if row is None:
                raise ValueError(
                    f"{name} must have {points} data in curve {count}, got {len(rows.dates)}. Is the file truncated?"
                )
            rows.add_dated(*row)
        yield rows, FLAGS[words[1]]
    if extra := next(lines, None):
        raise ValueError(f"{extra[0]} must follow curve {total}, the last one, with nothing, got more text.")


def _whole(word: str) -> int | None:
    """Return a positive whole number of at most nine digits; None for another word."""
    return int(word) or None if word.isascii() and word.isdigit() and len(word) < 10 else None


def _orbit(times: Array, places: Array, rows: Sequence[str], calendar: Calendar, center: str, au: float) -> Orbit:
    """Return the orbit of the asteroid about an attractor from the positions of the attractor, au, ecliptic axes."""
    distances = np.linalg.norm(places, axis=1)
    wrong = np.flatnonzero(~((distances > 0) & (distances < MAX_DISTANCE)))
    if wrong.size:
        given = ", ".join(f"{x:g}" for x in places[wrong[0]])
        raise ValueError(f"{rows[wrong[0]]} must have a position of the {center.title()} in au, got ({given}).")
    later = np.append(True, np.diff(times) > 0)
    first = np.maximum.accumulate(np.where(later, np.arange(times.size), 0))
    wrong = np.flatnonzero(np.linalg.norm(places - places[first], axis=1) > SAME_PLACE)
    if wrong.size:
        raise ValueError(
            f"{rows[wrong[0]]} must have the position of the {center.title()} of the row before at the same time, got "
            "another position."
        )
    r = -au * (places[later] @ PLANETS_TO_ICRF.T)
    mu = attractor_mu(center, None) * (au / AU) ** 3 * SECONDS[calendar.unit] ** 2
    labels: dict[str, Any] = {"reference_frame": "ICRF", "origin": center, "calendar": calendar}
    if len(r) == 1:
        day = SECONDS["d"] / SECONDS[calendar.unit]
        return Ephemeris.from_pieces(mu, knots=times[0] + [-day, day], coefficients=r[..., None], **labels)
    return Ephemeris.from_pieces(mu, knots=times[later], coefficients=_smooth_pieces(times[later], r), **labels)


def _smooth_pieces(times: Array, positions: Array) -> Array:
    """Return the Chebyshev coefficients, shape (n - 1, 3, 4), of a monotone cubic interpolation, without overshoot.

    Times of light curves are uneven, and positions in files are rounded, so that a spline would oscillate.
    """
    from scipy.interpolate import PchipInterpolator

    half = 0.5 * np.diff(times)[:, None]
    slopes = PchipInterpolator(times, positions)(times, 1)
    (a, b), (da, db) = ((x[:-1], x[1:]) for x in (positions, slopes))
    da, db, step = half * da, half * db, 0.5 * (b - a)
    second, third = (db - da) / 8, (da + db - 2 * step) / 16
    return np.stack([0.5 * (a + b) - second, step - third, second, third], axis=-1)


# ------------------------------------------------------------------ writing


@checked
def write_damit(readings: Readings | Sequence[Readings], path: str | Path, *, overwrite: bool = False) -> Path:
    """Write light curves with their geometry in the format of DAMIT.

    Julian dates are TDB, corrected for light time, with the digits that restore the times. Fluxes are reduced to unit
    distances. Space axes without a name are the ecliptic axes of J2000. Brightness has all digits, and positions have
    12 or 16 decimals of an astronomical unit.

    Parameters
    ----------
    readings : Readings or sequence of Readings
        Readings of a `LightCurve` of the kind "flux" or "relative", with a calendar.
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
        If the readings are no fluxes of a light curve, are absent at a time or have no calendar, or the file exists.

    Examples
    --------
    >>> law = pt.observables.LommelSeeliger(albedo=0.2)
    >>> ball = pt.shapes.Ellipsoid((9, 6, 5), density=1.0)
    >>> curves = pt.files.read_damit("lc.txt", ball, law)
    >>> path = pt.files.write_damit(curves, "again.txt")
    >>> bool(np.all(pt.files.read_damit(path, ball, law)[0].times == curves[0].times))
    True
    """
    curves = several(readings)
    lines = [str(len(curves)), *(line for each in curves for line in _written(each))]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


def _written(readings: Readings) -> Iterator[str]:
    """Yield the lines of one curve."""
    values, curve, calendar = present_values(readings), readings.observable, readings.calendar
    if not isinstance(curve, LightCurve) or curve.kind == "magnitude":
        raise ValueError(f"readings must be fluxes of a LightCurve, got {readings.name}, {quoted(curve)}.")
    if calendar is None:
        raise ValueError(
            f"times of {readings.name} must have a calendar, got none. DAMIT contains Julian dates. "
            "Give the readings, an orbit or the scenario a calendar."
        )
    times = readings.times
    if curve.light_time:
        delay = LIGHT_SECONDS_PER_AU / SECONDS[calendar.unit]
        for _ in range(LIGHT_TIME_STEPS):
            times = readings.times - delay * np.linalg.norm(_places(curve.observer, times, curve), axis=1)
    sun, earth = (_places(orbit, times, curve) for orbit in (curve.sun, curve.observer))
    flag = readings.attributes.get(CALIBRATED, "0")
    if curve.kind == "flux":
        flag, values = "1", values * np.sum(sun * sun, axis=1) * np.sum(earth * earth, axis=1)
    yield f"{values.size} {flag}"
    dates = julian_dates(times, "TDB", calendar)
    for date, value, place in zip(dates, values.tolist(), np.hstack([sun, earth]).tolist(), strict=True):
        yield " ".join((date, repr(value), *map(_coordinate, place)))


def _coordinate(x: float) -> str:
    short = f"{x:.{DECIMALS}f}"
    return short if abs(float(short) - x) <= ROUNDING else f"{x:.{MAX_DECIMALS}f}"


def _places(orbit: Orbit, times: Array, curve: LightCurve) -> Array:
    """Return the positions of an attractor relative to the body along the ecliptic axes, au, shape (n, 3)."""
    frame = orbit.reference_frame
    if frame not in ("ICRF", SPACE_AXES_UNNAMED):
        raise ValueError(f"orbits of a light curve must be along the ICRF for DAMIT, got {quoted(frame)}.")
    axes = PLANETS_TO_ICRF if frame == "ICRF" else np.eye(3)
    position = np.stack([np.broadcast_to(x, times.shape) for x in orbit.position_at(times)], axis=-1)
    return np.asarray(-position @ axes / float(curve.astronomical_unit))
