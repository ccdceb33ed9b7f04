"""Composite orbits: the orbit about a distant attractor as the sum of several orbits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import real_array
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Orbit, frames_of
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.printable import described
from poinsot.quantities import Date
from poinsot.records.calendar import Calendar

__all__ = ["composite_orbit"]

POLYNOMIAL_TOLERANCE = 1e-12


def composite_orbit(*orbits: Orbit, start: Date = None, stop: Date = None) -> Ephemeris:
    """Return the orbit of the first body about the last attractor, as the sum of the positions.

    Each orbit after the first is the orbit of the preceding attractor. For example, `composite_orbit(satellite, earth)`
    of a satellite about the Earth and the Earth about the Sun is the orbit of the satellite about the Sun. The function
    does not check that the attractors match.

    Parameters
    ----------
    *orbits : Orbit
        Two or more orbits along the same axes, in the same units, with one calendar. Orbits whose axes are unnamed, or
        without a calendar, combine with any other orbit.
    start, stop : float, str or astropy.time.Time, optional
        First and last time. Default: the time span common to all orbits.

    Returns
    -------
    Ephemeris
        The sum, with the `mu` and the origin of the last orbit.

    Raises
    ------
    ValueError
        If the axes or calendars differ, or the time span is empty or unbounded.

    Examples
    --------
    >>> earth = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> moon = pt.KeplerOrbit(3e-6, semimajor_axis=2.57e-3, eccentricity=0.055)
    >>> float(pt.orbits.composite_orbit(moon, earth, start=0.0, stop=1.0).mu)
    1.0
    """
    for orbit in orbits:
        if not isinstance(orbit, Orbit):
            raise TypeError(f"orbits must be Orbits, got {described(orbit)}.")
    if len(orbits) < 2:
        raise ValueError(f"orbits must be two or more, got {len(orbits)}.")
    frame = _common("reference frame", frames_of(orbit.reference_frame for orbit in orbits)) or SPACE_AXES_UNNAMED
    calendar = _common("calendar", (orbit.calendar for orbit in orbits if orbit.calendar is not None))
    first, last = _span(orbits, calendar, start, stop)

    def position(times: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([sum(parts) for parts in zip(*(orbit.position_at(times) for orbit in orbits), strict=True)], -1)

    return Ephemeris.from_function(
        cast("float", orbits[-1].mu),
        position=position,
        start=first,
        stop=last,
        tolerance=POLYNOMIAL_TOLERANCE,
        reference_frame=frame,
        origin=orbits[-1].origin,
        calendar=calendar,
    )


def _common(name: str, values: Iterable[Any]) -> Any:
    """Return the single value of a property of the orbits; None without any value."""
    known = list(dict.fromkeys(values))
    if len(known) > 1:
        raise ValueError(f"orbits must have one {name} to be added, got {' and '.join(map(_named, known))}.")
    return known[0] if known else None


def _named(value: Any) -> str:
    """Return the date of the zero of a calendar, or the name of a frame."""
    return f"the one from {value.zero} {value.scale}" if isinstance(value, Calendar) else str(value)


def _span(orbits: Iterable[Orbit], calendar: Calendar | None, start: Any, stop: Any) -> tuple[float, float]:
    spans = [orbit.span for orbit in orbits]
    common = max(span[0] for span in spans), min(span[1] for span in spans)
    first, last = (
        known if asked is None else float(real_array(name, asked if calendar is None else calendar.time(asked), ()))
        for known, name, asked in zip(common, ("start", "stop"), (start, stop), strict=True)
    )
    if not (np.isfinite(first) and np.isfinite(last) and first < last):
        raise ValueError(
            f"orbits must be known at common times with an end, but they are from {first} to {last}. "
            "Say start and stop."
        )
    return first, last
