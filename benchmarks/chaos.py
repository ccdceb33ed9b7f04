"""What maps of chaos cost: MEGNO over a grid of starts of a moon, in the plane of its orbit and in space."""

import time

import numpy as np

import poinsot as pt
from benchmarks.measure import ALLOWED, pin

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
MOON = pt.Body.from_ratios(beta=0.47, gamma=0.26)
SYSTEM = pt.System(MOON, pt.GravityGradient(ORBIT))
ORBITS, TOLERANCE, TILT = 100, 1e-9, 0.1
"""The tilt of the spin axis from the normal of the orbit, in space."""


def chaos_maps(short):
    """Return members, seconds and steps of each map, and how far its MEGNO is from one of ten times the samples."""
    pin(2)
    side = 24 if short else 200
    return {
        "orbits": ORBITS,
        "tolerance": TOLERANCE,
        "cores": min(2, len(ALLOWED) or 2),
        "maps": {
            "planar": _map(side, 0.0, "planar"),
            "three-dimensional": _map(side, TILT, None),
        },
    }


def _map(side, tilt, formulation):
    options = {"formulation": formulation, "tolerance": TOLERANCE, "threads": 2, "progress": False}
    pt.analysis.chaos_indicators(SYSTEM, _starts(4, tilt), [1.0], **options)  # compiles
    start, times = _starts(side, tilt), [ORBITS * ORBIT.period]
    began, used = time.perf_counter(), time.process_time()
    found = pt.analysis.chaos_indicators(SYSTEM, start, times, **options)
    took, used = time.perf_counter() - began, time.process_time() - used
    last = found.mean_megno[:, -1]
    return {
        "members": last.size,
        "seconds": took,
        "busy": used / took,
        "steps": found.run.steps / last.size,
        "chaotic": float(np.mean(last > 4)),
        "error": _error_of_megno(tilt, options),
    }


def _error_of_megno(tilt, options):
    """Return the largest relative error of the mean MEGNO of some members, against samples ten times as dense."""
    start, period = _starts(8, tilt), ORBIT.period
    dense = np.linspace(0, 20 * period, 20 * 8 * 10 + 1)[1:]
    coarse, fine = (
        pt.analysis.chaos_indicators(SYSTEM, start, t, **options).mean_megno[:, -1] for t in (dense[-1:], dense)
    )
    return float(np.max(np.abs(coarse - fine) / np.maximum(2, np.abs(fine))))


def _starts(side, tilt):
    """States on a grid of the angle of the long axis from the periapsis and of the rate about the third axis."""
    angles, rates = np.meshgrid(np.linspace(0, np.pi, side, endpoint=False), np.linspace(0.05, 3, side))
    c, s, rate = np.cos(angles.ravel() / 2), np.sin(angles.ravel() / 2), rates.ravel()
    ct, st = np.cos(tilt / 2), np.sin(tilt / 2)
    return MOON.state(np.stack([c * ct, c * st, s * st, s * ct], axis=-1), omega_body=rate[:, None] * (0, 0, 1.0))
