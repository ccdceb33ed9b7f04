"""Checks of settings that integration and closed form share."""

from __future__ import annotations

import os
import sys

from poinsot.integration.formulations import DEFAULT_FORMULATION, FORMULATIONS, Formulation, formulations
from poinsot.integration.settings import RunSettings, checked_tolerance
from poinsot.printable import quoted

__all__ = [
    "checked_device",
    "checked_formulation",
    "checked_settings",
    "checked_threads",
]


def checked_settings(
    formulation: str | Formulation | None, tolerance: float | None, threads: int | None, progress: bool | None
) -> RunSettings:
    """Return the settings of a run in double precision; progress is shown on a terminal by default."""
    shown = sys.stderr.isatty() if progress is None else progress
    form, error = checked_formulation(formulation), checked_tolerance(tolerance, "double")
    return RunSettings(form, error, threads=checked_threads(threads), progress=shown)


def checked_threads(threads: int | None) -> int:
    """Return the number of threads of an ensemble; default: all cores of the process."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    if not isinstance(threads, int) or isinstance(threads, bool) or threads < 1:
        raise ValueError(f"threads must be a positive whole number, got {quoted(threads)}.")
    return threads


def checked_device(device: str) -> str:
    """Return the device that integrates an ensemble."""
    if device not in ("cpu", "cuda"):
        raise ValueError(f"device must be 'cpu' or 'cuda', got {quoted(device)}.")
    return device


def checked_formulation(formulation: str | Formulation | None) -> Formulation:
    """Return a formulation by its name, or the user's own."""
    if formulation is None:
        return FORMULATIONS[DEFAULT_FORMULATION]
    if isinstance(formulation, Formulation):
        if FORMULATIONS.get(formulation.name, formulation) is not formulation:
            kind = type(formulation).__name__
            raise ValueError(
                f"formulation must have a name of its own, got {kind} with the name {quoted(formulation.name)}."
            )
        return formulation
    known = formulations()
    if not isinstance(formulation, str) or formulation not in known:
        raise ValueError(
            f"formulation must be one of {', '.join(FORMULATIONS)} or a Formulation, got {quoted(formulation)}."
        )
    return known[formulation]
