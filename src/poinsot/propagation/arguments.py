"""The arguments that integration and closed form have in common, checked."""

from __future__ import annotations

import os
import sys
import warnings
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import level_of_user, real_array, real_numbers, reals_or_nan
from poinsot.integration.formulations import DEFAULT_FORMULATION, FORMULATIONS, Formulation, formulations
from poinsot.integration.problem import Problem
from poinsot.integration.run import ROUNDING
from poinsot.mechanics.calendar import holds_dates
from poinsot.mechanics.collection import Collection
from poinsot.mechanics.force import PotentialOn, TorqueOn
from poinsot.mechanics.members import common_axis
from poinsot.mechanics.state import AnyState, Bodies, changed
from poinsot.mechanics.system import System
from poinsot.printable import quoted, shortened
from poinsot.suggestions import nearest

__all__ = [
    "RunSettings",
    "broadcast_members",
    "check_bodies",
    "check_span",
    "check_starts",
    "checked_device",
    "checked_formulation",
    "checked_threads",
    "checked_time",
    "checked_times",
    "checked_tolerance",
    "common_members",
]


@dataclass(frozen=True)
class RunSettings:
    """Checked settings of a run in double precision."""

    formulation: Formulation
    tolerance: float
    threads: int
    progress: bool

    @classmethod
    def of(
        cls, formulation: str | Formulation | None, tolerance: float | None, threads: int | None, progress: bool | None
    ) -> RunSettings:
        """Return settings as `propagate` interprets its arguments; progress is shown on a terminal by default."""
        return cls(
            checked_formulation(formulation),
            checked_tolerance(tolerance, "double"),
            checked_threads(threads),
            sys.stderr.isatty() if progress is None else progress,
        )


OWN_TIME = " Give the state its own: body.state(..., time=...)."


def checked_times(times: ArrayLike, system: System | None = None) -> NDArray[np.float64]:
    """Return strictly monotonic times, of a system also from dates and quantities; shape (n,), n > 0."""
    t = reals_or_nan("times", *_in_unit(times, system))
    if t.ndim != 1 or t.size == 0:
        if t.ndim == 0:
            raise ValueError(f"times must have shape (n,), got the number {t}. Write [{t}].")
        real_array("times", t, (None,))
        raise ValueError("times must not be empty, got shape (0,).")
    before, after = t[:-1], t[1:]
    onward = after > before if t.size > 1 and t[1] > t[0] else after < before
    if (t.size > 1 and not onward[onward.argmin()]) or not (isfinite(t[0]) and isfinite(t[-1])):
        real_numbers("times", t)
        i = int(onward.argmin())
        relation = f"= times[{i + 1}] = {t[i]}" if t[i] == t[i + 1] else f"= {t[i]} and times[{i + 1}] = {t[i + 1]}"
        raise ValueError(f"times must be strictly monotonic, but times[{i}] {relation}.")
    return t


def checked_time(name: str, time: ArrayLike, system: System) -> NDArray[np.float64]:
    """Return a time of a system as a number, also from a date or a quantity."""
    number, unit = _in_unit(time, system)
    return real_array(name, number, (), unit)


def _in_unit(time: ArrayLike, system: System | None) -> tuple[ArrayLike, str | None]:
    """Return times, those of a system also from dates, and the unit of time."""
    if system is None:
        return time, None
    calendar = system.calendar
    return calendar.time(time) if calendar and holds_dates(time) else time, system.units["time"]


def check_span(system: System | Collection, state: AnyState, times: NDArray[np.float64]) -> None:
    """Refuse times at which an orbit or a table is not known."""
    first, last = system.span
    if last - first == np.inf:
        return
    for name, values, hint in (("times", times, ""), ("the state's time", np.ravel(state.time), OWN_TIME)):
        outside = values[(values < first) | (values > last)]
        if outside.size:
            raise ValueError(
                f"{name} must lie within the span of orbits, fields and tables, [{quoted(first)}, {quoted(last)}], got "
                f"{quoted(float(outside[0]))}.{hint}"
            )


def check_starts(problem: Problem, state: AnyState) -> None:
    """Let each part and each event refuse a start."""
    if problem.events or [part for part in problem.dynamics.parts if part.checks_start]:
        twin = problem.beside(state.shape)
        instant = twin.dynamics.at(state)
        for part in twin.dynamics.parts:
            part.check_start(instant)
        for event in twin.events:
            event.check_start(instant)


def check_bodies(system: System, state: AnyState) -> None:
    """Refuse a state of one body for a system of two, the other way round, and one of two bodies alone.

    Warn of two bodies that nothing holds together.
    """
    if not system.dynamics.moves_alone:
        raise ValueError(
            f"system must be the system of both bodies, got {quoted(system)} as one of two, which does not "
            f"move alone. Take "
            "motion.system of the pair."
        )
    needed, given = len(system.of_bodies), len(state.body_names)
    if given != needed:
        made = "System.state or TwoBodies.state" if needed > 1 else "System.state or Body.state"
        words = {1: "one body", 2: "two bodies"}
        raise ValueError(f"state must be of {words[needed]}, as its system is, got {words[given]}. Take {made}.")
    sizes = {name: np.shape(values)[-1] for name, values in state.own.items() if name != "orbit" or needed == 1}
    names = [part.name for part in system.parts]
    if unknown := next((name for name in sizes if name not in names), None):
        raise ValueError(
            f"state must have variables of the parts of the system, {', '.join(map(shortened, names)) or 'none'}, got "
            f"{quoted(unknown)}.{nearest(unknown, names)} Make it by system.state(...)."
        )
    system.dynamics.check_variables(sizes)
    if needed > 1 and all(isinstance(force, PotentialOn | TorqueOn) for force in system.forces):
        warnings.warn(
            f"system should have a force between its two bodies, got {', '.join(map(repr, system.forces)) or 'none'}. "
            "They pass each other on a straight line: MutualGravity() attracts them.",
            stacklevel=level_of_user(),
        )


def common_members(system: System | Collection, state: AnyState) -> tuple[int, ...]:
    """Return () for one body, (members,) for an ensemble."""
    return common_axis("state and system", {state.shape, state.time.shape, system.members})


def broadcast_members(state: Bodies, members: tuple[int, ...]) -> Bodies:
    """Return a state for each member."""
    phase = changed(state.phase, lambda x: np.broadcast_to(x, (*members, x.shape[-1])))
    jumped = changed(dict(state.jumped), lambda x: np.broadcast_to(x, members))
    return type(state).computed(phase, np.broadcast_to(state.time, members), jumped)


def checked_threads(threads: int | None) -> int:
    """Return how many threads an ensemble may use; default: all cores of the process."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    if not isinstance(threads, int) or isinstance(threads, bool) or threads < 1:
        raise ValueError(f"threads must be a positive whole number, got {quoted(threads)}.")
    return threads


def checked_device(device: str) -> str:
    """Return where an ensemble is integrated."""
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


def checked_tolerance(tolerance: float | None, precision: str) -> float:
    """Return a tolerance for the engine: by default the rounding unit, in double precision that of order 20.

    At order p the powers n > p of a step are left out, e^(-2 n) of the state. Along a motion odd ones cancel in the
    energy, even ones add up: e^-40 at orders 18 and 19, which long runs show, e^-44 at order 20.
    """
    if not isinstance(precision, str) or precision not in ROUNDING:
        remedy = " Use 'quadruple', which has 32 digits." * (precision == "extended")
        raise ValueError(f"precision must be 'double' or 'quadruple', got {quoted(precision)}.{remedy}")
    least = ROUNDING[precision]
    if tolerance is None:
        return least
    value = float(real_array("tolerance", tolerance, ()))
    if not 0 < value < 1:
        raise ValueError(f"tolerance must be between 0 and 1, got {value}.")
    if value < least:
        raise ValueError(
            f"tolerance must be at least the rounding unit of {precision} precision, {least}, got {value}. "
            "Leave it out for that."
        )
    return value
