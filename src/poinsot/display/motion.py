"""Error report, summary and sketches of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from poinsot.display.html_text import curves, formatted, formatted_times, rounded
from poinsot.quantities import Array

__all__ = [
    "MotionDescription",
    "error_report",
    "exceptions",
    "motion_summary",
    "shown_members",
    "sketch_of_members",
    "sketch_of_motion",
]

Record = Mapping[str, str | float]
"""Entries of a summary by name."""

NO_INTEGRALS = "none: this system conserves neither energy nor a momentum"

ERRORS = {"norm_error": "norm error", "tangency_error": "tangency error (relative)"}
"""Errors of states, with their names in a summary."""

ENTRIES = {"method", "formulation", "precision", "tolerance", "order", "steps", "wall_time", "kernel", "lanes"}
ENTRIES |= {*ERRORS, "integrals"}
"""Entries of every summary. Further entries are drifts, formulas outside their validity, and quantities at limits."""


@dataclass(frozen=True)
class MotionDescription:
    """Contents of the summary of a motion.

    Attributes
    ----------
    system : str
        `repr` of the system.
    time_unit : str
        Unit of time, "1" without one.
    times : array (n,)
        Times of the motion.
    record : mapping
        Record of the method and of the errors: `motion.summary`.
    members, failed : int
        Number of members, 0 for one body, and of failed members.
    store : str
        Description of the store, "" without one.
    dense : tuple of float
        First and last time of the dense output, () without one.
    events : sequence of tuples
        Kind of each event and the number of its zeros.
    ends : sequence of tuples
        Kind, number of zeros and first time of each terminal event that ended the motion, or members of it.
    """

    system: str
    time_unit: str
    times: Array
    record: Record
    members: int
    failed: int
    store: str
    dense: tuple[float, ...]
    events: Sequence[tuple[str, int]]
    ends: Sequence[tuple[str, int, float]]


def error_report(errors: Mapping[str, Array], conserves: bool) -> dict[str, str | float]:
    """Return the largest magnitude of each error of a motion, or the statement that nothing is conserved."""
    largest = {name: float(np.fmax.reduce(np.abs(each), axis=None, initial=0.0)) for name, each in errors.items()}
    return {**largest, **({} if conserves else {"integrals": NO_INTEGRALS})}


def exceptions(flags: Mapping[str, NDArray[np.bool_]], errors: Mapping[str, Array]) -> dict[str, str]:
    """Return the number of times at which a formula is outside its validity, or a quantity is at its limit, by name.

    Parameters
    ----------
    flags : mapping
        Truth values along the times.
    errors : mapping
        Relative errors of formulas, for some of the names.
    """
    found = {}
    for name, at in flags.items():
        error = f", error about {100 * np.nanmax(errors[name]):.2g}%" if name in errors else ""
        found[name] = f"{np.count_nonzero(at)} of {at.size} times{error}"
    return found


def motion_summary(motion: MotionDescription) -> tuple[str, dict[str, str]]:
    """Return the title and the lines of the summary of a motion."""
    known, unit = motion.record, motion.time_unit
    steps = f", order {known['order']}, {known['steps']} steps, tolerance {known['tolerance']:.3g}"
    drift = [(name.removeprefix("drift_"), size) for name, size in known.items() if name.startswith("drift_")]
    kernel, lanes, wall_time = known["kernel"], float(known["lanes"]), float(known["wall_time"])
    return f"Trajectory of {rounded(motion.system)}", {
        "times": formatted_times(motion.times, unit),
        "members": f"{motion.members}, {motion.failed} failed" if motion.members else "",
        "store": motion.store,
        "method": str(known["method"]) + (steps if known["steps"] else ""),
        "kernel": f"{kernel}, {lanes:g} lanes" if lanes > 1 else str(kernel),
        "variables": f"{known['formulation']}, {known['precision']} precision",
        "wall time": formatted(wall_time, "s") if np.isfinite(wall_time) else "",
        "dense output": "any time" if motion.dense[:1] == (-np.inf,) else formatted(motion.dense or None, unit),
        **{text: f"{known[name]:.3g}" for name, text in ERRORS.items() if name in known},
        "drift": ", ".join(f"{name} {size:.2g}" for name, size in drift) or str(known.get("integrals", "")),
        "events": ", ".join(f"{kind} {count}" for kind, count in motion.events),
        "ended": "; ".join(
            f"{f'{count} members' if motion.members else f'at t = {formatted(time)}'}, by {kind}"
            for kind, count, time in motion.ends
        ),
        **{name: str(text) for name, text in known.items() if name not in ENTRIES and not name.startswith("drift_")},
    }


def sketch_of_motion(times: Array, lines: Mapping[str, Array], errors: Mapping[str, Array], unit: str) -> str:
    """Return two small plots: of quantities of one motion, and of the largest errors so far."""
    return curves("motion", times, lines, unit) + curves("largest so far", times, errors, unit, errors=True)


def sketch_of_members(name: str, times: Array, members: Mapping[int, Array], unit: str) -> str:
    """Return a small plot of one quantity of some members of an ensemble."""
    return curves(name, times, {f"member {number}": values for number, values in members.items()}, unit)


def shown_members(count: int) -> list[int]:
    """Return the numbers of the members of an ensemble in its small plot: at most five, evenly spaced."""
    return [int(number) for number in np.unique(np.linspace(0, count - 1, 5).astype(int))]
