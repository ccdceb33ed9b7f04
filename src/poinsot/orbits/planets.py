"""Positions of Sun, Moon and planets from the theories VSOP2013 and ELP2000."""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot.checked import checked
from poinsot.orbits.attractors import MU, attractor_radius
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.orbits.theories import JULIAN_CENTURY, moon_position, planet_position
from poinsot.printable import quoted
from poinsot.quantities import Array, Date
from poinsot.records.calendar import Calendar, span_of

__all__ = ["planet_orbit"]

J2000 = Calendar("2000-01-01T12:00:00", "TDB")

PLANETS = ("mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune", "pluto")

WITH_MOONS = ("mars", "jupiter", "saturn", "uranus", "neptune", "pluto")

BODIES = ("sun", "moon", *PLANETS)

AU = 149597870.7
"""km."""

FIRST, LAST = -60 * JULIAN_CENTURY, 60 * JULIAN_CENTURY
"""Years -4000 and 8000, the validity range of VSOP2013, in seconds."""

MOON_IN_EARTH_AND_MOON = MU["MOON"] / MU["EARTH BARYCENTER"]

POLYNOMIAL_TOLERANCE = 1e-12
"""Relative error of the fitted polynomials. The theories are accurate to 1e-7 at best."""


@checked
def planet_orbit(body: str, attractor: str, start: Date, stop: Date, *, calendar: Calendar = J2000) -> Ephemeris:
    """Return the position of the Sun, the Moon or a planet relative to another one, without a data file.

    The planets follow VSOP2013 (Simon et al. 2013, A&A 557, A49) and the Moon ELP2000-82B (Chapront-Touze and Chapront
    1983, A&A 124, 50), both without the smallest terms. The positions differ from DE440 by some km from Mercury to Mars
    and by less than 1 km for the Moon; see docs/ephemerides.md.

    Parameters
    ----------
    body, attractor : str
        Two of "sun", "moon", "mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune", "pluto".
        From Mars outwards, the name is the barycentre of the planet and its moons, with the `mu` of both.
    start, stop : float, str or astropy.time.Time
        First and last time: times of the calendar, or dates with a time scale. The years must be within -4000 to 8000.
    calendar : Calendar, optional
        Dates of the times, counted in seconds. Default: TDB from 2000-01-01T12:00:00. All orbits of a system share one
        calendar.

    Returns
    -------
    Ephemeris
        Positions in km and velocities in km/s along the ICRF axes, with the attractor's `mu` from DE440 in km3/s2.

    Raises
    ------
    ValueError
        If a name is unknown, both are the same, or the time span is empty or out of range.

    Examples
    --------
    >>> mars = pt.orbits.planet_orbit("mars", "sun", "2026-01-01T00:00:00 TDB", "2026-01-11T00:00:00 TDB")
    >>> mars.origin, mars.reference_frame
    ('SUN', 'ICRF')
    """
    body, attractor = _checked("body", body), _checked("attractor", attractor)
    if body == attractor:
        raise ValueError(f"body and attractor must be two, but both are {quoted(body)}.")
    first, last = span_of(calendar, start, stop)
    between = J2000.converted(np.array([first, last]), calendar)
    if between[0] < FIRST or between[1] > LAST:
        raise ValueError(f"start and stop must be in the years -4000 to 8000, got {quoted(start)} and {quoted(stop)}.")
    name = attractor.upper() + (" BARYCENTER" if attractor in WITH_MOONS else "")

    def position(times: Array) -> Array:
        return _between(body, attractor, J2000.converted(times, calendar)).T

    return Ephemeris.from_function(
        MU[name],
        position=position,
        start=first,
        stop=last,
        tolerance=POLYNOMIAL_TOLERANCE,
        reference_frame="ICRF",
        origin=name,
        calendar=calendar,
        radius=attractor_radius(attractor),
    )


def _checked(argument: str, name: Any) -> str:
    if not isinstance(name, str) or name.lower() not in BODIES:
        raise ValueError(f"{argument} must be one of {', '.join(BODIES)}, got {quoted(name)}.")
    return name.lower()


def _between(body: str, attractor: str, seconds: Array) -> Array:
    """Return the position of one body from another, km; shape (3, n)."""
    if {body, attractor} == {"earth", "moon"}:
        return moon_position(seconds) * (1 if body == "moon" else -1)
    return _heliocentric(body, seconds) - _heliocentric(attractor, seconds)


def _heliocentric(body: str, seconds: Array) -> Array:
    """Return the position of a body from the Sun, km; shape (3, n)."""
    if body == "sun":
        return np.zeros((3, seconds.size))
    if body in ("earth", "moon"):
        share = -MOON_IN_EARTH_AND_MOON if body == "earth" else 1 - MOON_IN_EARTH_AND_MOON
        return AU * planet_position("earth", seconds) + share * moon_position(seconds)
    return AU * planet_position(body, seconds)
