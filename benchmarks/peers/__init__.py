"""The peers, each as its own user would write it.

A peer is a module with `LEVELS` (its sweep, loose to tight), `SHORT_LEVELS`, `SOLVES` (kinds of problems) and
`prepare(problem, level)`, which returns a function of nothing that integrates and returns (q, end).
"""

import importlib
from importlib import metadata

from benchmarks.measure import in_a_line

TITLES = {
    "poinsot_taylor": "poinsot",
    "heyoka_by_hand": "heyoka by hand",
    "numbalsoda_dop853": "numbalsoda DOP853",
    "diffrax_dopri8": "diffrax Dopri8",
    "scipy_dop853": "scipy DOP853",
    "mujoco_rk4": "MuJoCo RK4",
    "basilisk_rkf78": "Basilisk RKF78",
}
NEEDS = {
    "numbalsoda_dop853": "numbalsoda",
    "diffrax_dopri8": "diffrax",
    "mujoco_rk4": "mujoco",
    "basilisk_rkf78": "bsk",
    "basilisk_facets": "bsk",
}


def available(names=tuple(TITLES)):
    """Import these peers; return those that are here, by name, and why the others are not."""
    found, missing = {}, {}
    for name in names:
        try:
            if name in NEEDS:
                metadata.version(NEEDS[name])  # what a removed package leaves behind may still be imported
            found[name] = importlib.import_module(f"benchmarks.peers.{name}")
        except ModuleNotFoundError as problem:
            missing[name] = f"{problem.name} is not installed"
        except Exception as problem:  # packages that do not fit together or to this machine raise anything
            missing[name] = in_a_line(problem)
    return found, missing


def versions(packages):
    """Return the versions of the packages that are installed."""
    out = {}
    for package in packages:
        try:
            out[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            out[package] = "not installed"
    return out
