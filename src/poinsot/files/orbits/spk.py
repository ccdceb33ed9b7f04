"""Orbits from SPICE kernels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.errors import optional
from poinsot.files.spice import ET, check_inertial, loaded, sentences
from poinsot.mechanics.calendar import Calendar, span_of
from poinsot.orbits.attractors import attractor_mu, attractor_radius
from poinsot.orbits.ephemeris import Ephemeris

__all__ = ["spice_orbit"]

TOLERANCE = 1e-12


@checked
def spice_orbit(
    target: str | int,
    center: str | int,
    start: Any,
    stop: Any,
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
        Bodies by their names or numbers in SPICE; the centre is the attractor.
    start, stop : float, str or astropy.time.Time
        The span: times of the calendar, or dates that say their scale.
    kernels : sequence of paths
        Files to load, unloaded again in the end: SPK, and what else they need.
    frame : str
        An inertial frame of SPICE. Its J2000 is the ICRF.
    mu : float, optional
        Gravitational parameter of the centre, km3/s2; default: BODYnnn_GM of the kernels, or that of DE440.
    calendar : Calendar, optional
        Counts seconds; default: TDB from 2000-01-01T12:00:00, which is SPICE's ET. Orbits of one system share one.

    Returns
    -------
    Ephemeris
        km and km/s.

    Raises
    ------
    OSError, ValueError
        If a kernel is missing or no kernel, a body or frame is unknown, the frame rotates, or the kernels do not
        cover the span.
    ImportError
        If spiceypy is missing.
    """
    spice = optional("spiceypy", "SPICE kernels")
    first, last = span_of(calendar, start, stop)
    with loaded(spice, kernels):
        target_id, center_id = _number(spice, "target", target), _number(spice, "center", center)
        if target_id == center_id:
            raise ValueError(f"target and center must be two, but both are {target!r}.")
        check_inertial(spice, frame)
        origin = str(spice.bodc2s(center_id))
        mu = _pool_mu(spice, center_id) if mu is None else mu
        mu = attractor_mu(origin, mu)

        def position(times: NDArray[np.float64]) -> NDArray[np.float64]:
            et = ET.converted(times, calendar)
            with sentences(spice, f"kernels must cover {target!r} from {center!r} at all times from start to stop"):
                return np.asarray(spice.spkpos(str(target_id), et, frame, "NONE", str(center_id))[0])

        return Ephemeris.fit(
            mu,
            position,
            first,
            last,
            tolerance=TOLERANCE,
            reference_frame="ICRF" if frame.upper() == "J2000" else frame.upper(),
            origin=origin,
            calendar=calendar,
            radius=attractor_radius(origin),
        )


def _number(spice: Any, name: str, body: str | int) -> int:
    try:
        return int(spice.bods2c(str(body)))
    except spice.utils.exceptions.SpiceyError:
        raise ValueError(f"{name} must be a body that SPICE knows, but {body!r} came.") from None


def _pool_mu(spice: Any, center: int) -> float | None:
    return float(spice.bodvcd(center, "GM", 1)[1][0]) if spice.bodfnd(center, "GM") else None
