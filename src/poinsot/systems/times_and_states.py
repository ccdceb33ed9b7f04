"""Times, states and members of a system, checked."""

from __future__ import annotations

import warnings
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import level_of_user, real_array, real_numbers, reals_or_nan
from poinsot.kinematics.state import AnyState, Bodies, changed
from poinsot.mechanics.force import PotentialOn, TorqueOn
from poinsot.printable import quoted, shortened
from poinsot.records.calendar import holds_dates
from poinsot.records.members import common_axis
from poinsot.suggestions import nearest
from poinsot.systems.collection import Collection
from poinsot.systems.system import System

__all__ = ["broadcast_members", "check_bodies", "check_span", "checked_time", "checked_times", "common_members"]

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


def common_members(system: System | Collection, state: AnyState) -> tuple[int, ...]:
    """Return () for one body, (members,) for an ensemble."""
    return common_axis("state and system", {state.shape, state.time.shape, system.members})


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
