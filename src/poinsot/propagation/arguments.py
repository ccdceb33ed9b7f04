"""Checks of the arguments that integration and closed form share."""

from __future__ import annotations

import os
import sys
import warnings

import numpy as np

from poinsot.errors import level_of_user
from poinsot.integration.formulations import DEFAULT_FORMULATION, FORMULATIONS, Formulation, formulations
from poinsot.integration.problem import Problem
from poinsot.integration.settings import RunSettings, checked_tolerance
from poinsot.kinematics.state import AnyState, Bodies, changed
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import PotentialOn, TorqueOn
from poinsot.mechanics.part import Part
from poinsot.printable import quoted, shortened
from poinsot.suggestions import nearest
from poinsot.systems.system import System

__all__ = [
    "broadcast_members",
    "check_bodies",
    "check_starts",
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


def check_starts(problem: Problem, state: AnyState) -> None:
    """Raise the error of a part or an event that does not accept an initial state."""
    records: tuple[Part | Event, ...] = (*problem.dynamics.parts, *problem.events)
    if [record for record in records if record.checks_start]:
        expanded = problem.broadcast_to(state.shape)
        instant = expanded.dynamics.at(state)
        for part in expanded.dynamics.parts:
            part.check_start(instant)
        for event in expanded.events:
            event.check_start(instant)


def check_bodies(system: System, state: AnyState) -> None:
    """Raise an error unless system and state have the same number of bodies and the system moves alone.

    Warn of two bodies that nothing holds together.
    """
    if not system.dynamics.moves_alone:
        raise ValueError(
            f"system must be the system of both bodies, got {quoted(system)} as one of two, which does not "
            f"move alone. Take "
            "motion.system of the pair."
        )
    needed = system.dynamics.check_bodies(state)
    sizes = {name: np.shape(values)[-1] for name, values in state.own.items() if name != "orbit" or needed == 1}
    names = [part.name for part in system.parts]
    if unknown := next((name for name in sizes if name not in names), None):
        raise ValueError(
            f"state must have variables of the parts of the system, {', '.join(map(shortened, names)) or 'none'}, got "
            f"{quoted(unknown)}.{nearest(unknown, names)} Make it by system.state(...)."
        )
    if names:
        system.dynamics.check_variables(sizes)
    if needed > 1 and all(isinstance(force, PotentialOn | TorqueOn) for force in system.forces):
        warnings.warn(
            f"system should have a force between its two bodies, got {', '.join(map(repr, system.forces)) or 'none'}. "
            "They pass each other on a straight line: MutualGravity() attracts them.",
            stacklevel=level_of_user(),
        )


def broadcast_members(state: Bodies, members: tuple[int, ...]) -> Bodies:
    """Return a state for each member."""
    phase = changed(state.phase, lambda x: np.broadcast_to(x, (*members, x.shape[-1])))
    jumped = changed(state.jumped, lambda x: np.broadcast_to(x, members))
    return type(state).computed(phase, np.broadcast_to(state.time, members), jumped)


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
