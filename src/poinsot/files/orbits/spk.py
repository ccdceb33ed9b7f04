"""Orbits from SPICE kernels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.files.spice import ET, Kernels, loaded
from poinsot.orbits.attractors import attractor_mu, attractor_radius
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.printable import quoted
from poinsot.quantities import Date
from poinsot.records.calendar import Calendar, span_of

__all__ = ["spice_orbit"]

POLYNOMIAL_TOLERANCE = 1e-12

MAX_DISTANCE = 1e100
"""Largest distance, km: above all real ones, and its square does not overflow."""

MAX_TIMES = 100_000
"""Largest number of positions that small kernels compute. Each byte of a kernel allows one more."""


@checked
def spice_orbit(
    target: str | int,
    center: str | int,
    start: Date,
    stop: Date,
    kernels: Sequence[str | Path],
    *,
    frame: str = "J2000",
    mu: float | None = None,
    calendar: Calendar = ET,
) -> Ephemeris:
    """Return the geometric position of a target relative to a centre from SPICE kernels, without light time.

    Parameters
    ----------
    target, center : str or int
        SPICE names or numbers of the two bodies; the centre is the attractor.
    start, stop : float, str or astropy.time.Time
        Ends of the span: times of the calendar, or dates with their time scale.
    kernels : sequence of paths
        All required files: SPK, and text kernels of constants, clocks and frames. Kernels loaded in spiceypy are
        ignored.
    frame : str
        Name of an inertial frame of SPICE, whose J2000 is the ICRF.
    mu : float, optional
        Gravitational parameter of the centre, km3/s2. Default: BODYnnn_GM of the kernels, or the value of DE440.
    calendar : Calendar, optional
        Calendar in seconds. Default: from 2000-01-01T12:00:00 TDB, which is SPICE's ET. Orbits of one system must share
        one calendar.

    Returns
    -------
    Ephemeris
        Position in km and velocity in km/s.

    Raises
    ------
    OSError, ValueError, ImportError
        If a kernel is missing or invalid, a body or frame is unknown, the frame rotates, the kernels do not cover the
        span, or spiceypy is not installed.

    Examples
    --------
    >>> pt.files.spice_orbit(-999, "CERES", 0.5, 2.0, ["m.bsp"], mu=2.0).reference_frame
    'ICRF'
    """
    first, last = span_of(calendar, start, stop)
    with loaded(kernels) as spice:
        target_id, center_id = _body(spice, "target", target), _body(spice, "center", center)
        if target_id == center_id:
            raise ValueError(f"target and center must be two bodies, got {quoted(target)} twice.")
        spice.ask("check_inertial", frame)
        origin, own_mu = spice.ask("name_and_mu", center_id)[0]
        mu = attractor_mu(origin, own_mu if mu is None else mu)
        rule = f"kernels must cover {quoted(target)} from {quoted(center)} at all times from start to stop"

        left = MAX_TIMES + spice.size

        def position(times: NDArray[np.float64]) -> NDArray[np.float64]:
            nonlocal left
            left -= times.size
            if left < 0:
                raise ValueError(
                    "kernels must be smooth between start and stop, got some of which more positions are needed than "
                    "they have numbers. Shorten the span."
                )
            ets = ET.converted(times, calendar)
            found = spice.ask("positions", rule, target_id, frame, center_id, times=ets)[1][0]
            if not np.all(np.abs(found) < MAX_DISTANCE):
                raise ValueError(f"kernels must have positions within {MAX_DISTANCE:g} km, got others.")
            return found

        return Ephemeris.from_function(
            mu,
            position=position,
            start=first,
            stop=last,
            tolerance=POLYNOMIAL_TOLERANCE,
            reference_frame="ICRF" if frame.upper() == "J2000" else frame.upper(),
            origin=origin,
            calendar=calendar,
            radius=attractor_radius(origin),
        )


def _body(spice: Kernels, name: str, body: str | int) -> int:
    return int(spice.ask("number", f"{name} must be a body that SPICE knows, got {quoted(body)}.", str(body))[0])
