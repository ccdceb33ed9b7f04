"""The peers, each as its own user would write it.

A peer is a module with `TITLE`, `PACKAGES`, `LEVELS` (its sweep, loose to tight), `SHORT_LEVELS`, `SOLVES` (kinds of
problems) and `prepare(problem, level)`, which returns a function of nothing that integrates and returns (q, end).
"""

import importlib
import importlib.util
from importlib import metadata

NAMES = (
    "poinsot_taylor",
    "heyoka_by_hand",
    "numbalsoda_dop853",
    "diffrax_dopri8",
    "scipy_dop853",
    "mujoco_rk4",
    "basilisk_rkf78",
)


def available():
    """Return the peers that can be imported here, by name, and why the others cannot."""
    found, missing = {}, {}
    for name in NAMES:
        try:
            found[name] = importlib.import_module(f"benchmarks.peers.{name}")
        except (ImportError, OSError) as problem:
            missing[name] = str(problem).splitlines()[0]
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
