"""Orbits from SPICE kernels."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import optional
from poinsot.mechanics.calendar import Calendar, span_of
from poinsot.orbits.attractors import attractor_mu
from poinsot.orbits.ephemeris import Ephemeris

__all__ = ["spice_orbit"]

ET = Calendar("2000-01-01T12:00:00", "TDB")

TOLERANCE = 1e-12

INERTIAL_CLASS = 1


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
    with _loaded(spice, kernels):
        target_id, center_id = _number(spice, "target", target), _number(spice, "center", center)
        if target_id == center_id:
            raise ValueError(f"target and center must be two, but both are {target!r}.")
        _check_inertial(spice, frame)
        origin = str(spice.bodc2s(center_id))
        mu = _pool_mu(spice, center_id) if mu is None else mu
        mu = attractor_mu(origin, mu)

        def position(times: NDArray[np.float64]) -> NDArray[np.float64]:
            et = ET.converted(times, calendar)
            with _sentences(spice, f"kernels must cover {target!r} from {center!r} at all times from start to stop"):
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
        )


@contextlib.contextmanager
def _loaded(spice: Any, kernels: Sequence[str | Path]) -> Iterator[None]:
    if isinstance(kernels, str | Path):
        raise TypeError(f"kernels must be a list of paths, but {str(kernels)!r} came.")
    with contextlib.ExitStack() as stack:
        for path in map(Path, kernels):
            if not path.is_file():
                raise FileNotFoundError(f"kernels must be files, but there is no {path}.")
            with _sentences(spice, f"{path} must be a SPICE kernel"):
                stack.callback(spice.unload, str(path))
                spice.furnsh(str(path))
        yield


@contextlib.contextmanager
def _sentences(spice: Any, rule: str) -> Iterator[None]:
    """Say an error of SPICE as one sentence."""
    try:
        yield
    except spice.utils.exceptions.SpiceyError as error:
        reason = getattr(error, "short", "") or str(error).strip().splitlines()[0]
        raise ValueError(f"{rule}, but SPICE says {reason}.") from None


def _number(spice: Any, name: str, body: str | int) -> int:
    try:
        return int(spice.bods2c(str(body)))
    except spice.utils.exceptions.SpiceyError:
        raise ValueError(f"{name} must be a body that SPICE knows, but {body!r} came.") from None


def _check_inertial(spice: Any, frame: str) -> None:
    number = spice.namfrm(frame) if isinstance(frame, str) and frame else 0
    if not number:
        raise ValueError(f"frame must be one that SPICE knows, but {frame!r} came.")
    if spice.frinfo(number)[1] != INERTIAL_CLASS:
        raise ValueError(f"frame must be one that does not rotate, but {frame!r} came.")


def _pool_mu(spice: Any, center: int) -> float | None:
    return float(spice.bodvcd(center, "GM", 1)[1][0]) if spice.bodfnd(center, "GM") else None
