"""The page that the search lists first for each frequent query."""

from __future__ import annotations

import re

__all__ = ["FIRST_RESULTS", "with_index_entries"]

FIRST_RESULTS = {
    "ensembles": "ensemble, monte carlo",
    "forces": "torque, torques, force, potential",
    "gravity": "gravity gradient, gravity",
    "surfaces": "eclipse, drag, radiation pressure, solar radiation pressure, shadow",
    "magnetic": "magnetic field, magnetorquer, b-dot, igrf",
    "yorp": "yorp",
    "tides": "tides, tidal torque",
    "parts": "reaction wheel, momentum wheel, moving parts",
    "control": "control, attitude control, kalman filter",
    "ephemerides": "two-line elements, tle, spice, ephemeris",
    "events": "event, events",
    "frequencies": "frequency, frequencies, spectrum",
    "chaos": "chaos, lyapunov exponent, megno",
    "equilibria": "equilibrium, equilibria",
    "state_transition": "state transition, covariance",
    "periodic": "periodic motion, periodic orbit",
    "two_bodies": "binary asteroid, two bodies",
    "shapes": "inertia tensor, mesh, shape",
    "files": "ccsds, aem, attitude files",
    "stores": "store, zarr",
    "view": "3d view, animation, plot",
    "accuracy": "accuracy, error",
    "limits": "limits",
    "install": "install, installation",
    "free_rotation": "free rotation, torque-free motion",
    "theory/conventions": "quaternion, quaternions, euler angles, convention, units",
    "generated/api/poinsot.propagate": "propagate, attitude",
    "generated/api/poinsot.free_motion": "euler-poinsot motion",
    "generated/api/poinsot.save": "save",
    "generated/api/poinsot.load": "load",
    "generated/api/poinsot.Body": "body, moment of inertia",
}
"""Queries by the page that a reader means, which the search lists first."""


def with_index_entries(page: str, content: list[str], suffix: str) -> None:
    """Add a main index entry for each query to the page that the search lists first."""
    if queries := FIRST_RESULTS.get(page):
        rst = suffix == ".rst"
        entry = ".. index:: ! {}\n" if rst else "```{{index}} ! {}\n```\n"
        entries = "".join(map(entry.format, queries.split(", ")))
        heading = r"\A" if rst else r"^# .*\n"
        content[0] = re.sub(heading, lambda found: f"{found[0]}\n{entries}\n", content[0], count=1, flags=re.MULTILINE)
