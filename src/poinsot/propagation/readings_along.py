"""Readings of observables along motions: instants between rows, absent readings, members that are read apart."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import level_of_user
from poinsot.kinematics.state import AnyState, changed, state_of
from poinsot.mechanics.environment import Environment, orbits_of
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.pair_instant import AnyInstant
from poinsot.printable import quoted
from poinsot.propagation.recorded import RecordedSystem
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar
from poinsot.records.members import expanded, members_of
from poinsot.records.units import DerivedUnits
from poinsot.systems.collection import Collection
from poinsot.systems.formula_trials import try_observable
from poinsot.systems.system import System

__all__ = [
    "AbsentCounts",
    "Propagation",
    "ReadingsOfMembers",
    "absent_counts",
    "absent_readings",
    "hidden_readings",
    "readings_without_rows",
    "refuse_other_unit",
    "refuse_unfit",
    "states_at",
    "values_along",
    "warn_of_absent",
    "with_readings",
]

Propagation = Callable[[Trajectory, Array], Trajectory]
"""Function that returns a motion at other times, ascending, from the same initial state."""


class AbsentCounts(NamedTuple):
    """Number of readings, and numbers of absent readings by reason."""

    total: int
    by_reason: dict[str, int]

    def __add__(self, other: AbsentCounts) -> AbsentCounts:  # type: ignore[override]
        reasons = [*self.by_reason, *other.by_reason]
        return AbsentCounts(
            self.total + other.total,
            {name: self.by_reason.get(name, 0) + other.by_reason.get(name, 0) for name in reasons},
        )


def values_along(
    motion: Trajectory,
    observable: Observable,
    times: Array,
    again: Propagation,
    add: Callable[[AbsentCounts], None] | None = None,
) -> Array:
    """Return the readings at times, NaN where there is none, with one warning about the reasons.

    The result has the shape (n,) or (n, components), with members first. `again` propagates the motion to times that
    are not among its rows, and `add` is called in place of a warning.
    """
    refuse_unfit(motion.system, observable, (len(motion),) if motion.is_ensemble else (), times)
    seen = observable.time_of_body(times, DerivedUnits(motion.system.units))
    parts = [_read(each, own, at, again) for each, own, at in _parts(motion, observable, seen)]
    values = parts[0].values if len(parts) == 1 else np.concatenate([part.values for part in parts])
    hidden = hidden_readings(observable, times, values.shape[: values.ndim - bool(observable.components)])
    for where in hidden.values():
        values[where] = np.nan
    counts = absent_counts(observable, [*parts, ReadingsOfMembers(np.empty(0), hidden)])
    if add is None:
        warn_of_absent(observable, counts)
    else:
        add(counts)
    return values


def hidden_readings(observable: Observable, times: Array, shape: tuple[int, ...]) -> dict[str, NDArray[np.bool_]]:
    """Return, by reason, True where an observer does not see the body at the times of readings of a shape."""
    found: dict[str, NDArray[np.bool_]] = {}
    for orbit in orbits_of(observable):
        for reason, hidden in orbit.hidden_at(times).items():
            where = np.broadcast_to(np.asarray(hidden, dtype=bool), shape)
            found[reason] = found[reason] | where if reason in found else where
    return found


def refuse_unfit(system: System, observable: Observable, members: tuple[int, ...], times: Array) -> None:
    """Raise an error for an observable that does not fit a system of members, or times at which an orbit is unknown."""
    Collection((*system.dynamics.records, observable)).refuse_other_axes()
    for orbit in orbits_of(observable):
        if orbit.calendar is not None:
            refuse_other_unit(orbit.calendar, system)
    if not isinstance(system, RecordedSystem):
        try_observable(system.dynamics, observable)
    if observable.member_axis and members and observable.member_axis != members:
        raise ValueError(
            f"the observable must have as many members as the motion, {members[0]}, got {observable.member_axis[0]}."
        )
    first, last = Collection((observable,)).span
    outside = times[(times < first) | (times > last)]
    if outside.size:
        raise ValueError(
            f"times must lie within the span of the orbits of {type(observable).__name__}, [{quoted(first)}, "
            f"{quoted(last)}], got {quoted(float(outside[0]))}."
        )
    observable.check_times(times)


def refuse_other_unit(calendar: Calendar, system: System) -> None:
    """Raise a ValueError for a calendar of readings that counts in another unit than the system."""
    unit = system.units["time"]
    if unit not in ("1", calendar.unit):
        raise ValueError(
            f"the calendar of readings must count in the unit of time of the system, {quoted(unit)}, got one that "
            f"counts {quoted(calendar.unit)}. Give both the same unit."
        )


class ReadingsOfMembers(NamedTuple):
    """Readings of some members, and the reasons why readings are absent where the motion has rows."""

    values: Array
    absent: dict[str, NDArray[np.bool_]]


def _parts(motion: Trajectory, observable: Observable, seen: Array) -> Iterator[tuple[Trajectory, Observable, Array]]:
    """Yield motions, observables and times of the body that are read together: all members if they share the times.

    Members of a store are read chunk by chunk.
    """
    store = motion.store
    if seen.ndim == 2:
        for i, at in enumerate(seen):
            one = slice(i, i + 1)
            yield motion.isel(member=one) if motion.is_ensemble else motion, members_of(observable, one), at
    elif store is not None and store.chunk < len(motion):
        for first in range(0, len(motion), store.chunk):
            some = slice(first, first + store.chunk)
            yield motion.isel(member=some), members_of(observable, some), seen
    else:
        yield motion, observable, seen


def _read(motion: Trajectory, observable: Observable, seen: Array, again: Propagation) -> ReadingsOfMembers:
    """Return the readings at times of the body, which all members share."""
    if np.array_equal(seen, motion.times):
        return _evaluated(motion, observable, motion._reader.state, motion.environment)
    wanted, place = np.unique(seen, return_inverse=True)
    state, environment = states_at(motion, wanted, again)
    found = _evaluated(motion, observable, state, environment)
    rows, axis = (
        np.searchsorted(wanted, np.asarray(environment.time)),
        found.values.ndim - 1 - bool(observable.components),
    )
    full = np.full((*found.values.shape[:axis], wanted.size, *found.values.shape[axis + 1 :]), np.nan)
    full[(slice(None),) * axis + (rows,)] = found.values
    absent = {name: np.zeros(full.shape[: axis + 1], dtype=bool) for name in found.absent}
    for name, where in found.absent.items():
        absent[name][..., rows] = where
    return ReadingsOfMembers(np.take(full, place, axis), {name: where[..., place] for name, where in absent.items()})


def states_at(motion: Trajectory, times: Array, again: Propagation) -> tuple[AnyState, Environment]:
    """Return the states at the ascending times that the motion reaches, with the environment at these times."""
    if motion._dense is not None and motion._dense[1] <= times[0] and times[-1] <= motion._dense[2]:
        return motion(times), Environment(times)
    among = np.isin(motion.times, times)
    there = among.sum() == times.size
    rows = motion.isel(time=np.flatnonzero(among)) if there else again(motion, times)
    return rows._reader.state, rows.environment


def _evaluated(
    motion: Trajectory, observable: Observable, state: AnyState, environment: Environment
) -> ReadingsOfMembers:
    """Return the readings of states, NaN where the instrument has none."""
    if observable.member_axis and not motion.is_ensemble:
        state = state_of(changed(state.phase, lambda rows: rows[None]), state.time)
    instant: Any = motion.system.at(state, environment)
    shape = np.broadcast_shapes(observable.member_axis + (1,) * bool(observable.member_axis), instant.shape)
    expanded_observable = observable.with_numbers(expanded(number, len(shape)) for number in observable.numbers)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reading = expanded_observable.reading(instant)
    scalars = list(reading) if observable.components else [reading]
    columns = [np.array(np.broadcast_to(np.asarray(x, dtype=float), shape)) for x in scalars]
    values = np.stack(columns, axis=-1)
    absent = absent_readings(expanded_observable, instant, values)
    values[np.logical_or.reduce([*absent.values(), np.zeros(shape, dtype=bool)])] = np.nan
    return ReadingsOfMembers(values if observable.components else values[..., 0], absent)


def absent_readings(observable: Observable, instant: Any, values: Array) -> dict[str, NDArray[np.bool_]]:
    """Return, by reason, True where an instrument has no reading of an instant of the motion.

    Parameters
    ----------
    observable : Observable
        Observable whose numbers broadcast against the instant.
    instant : Instant or PairInstant
        States at several times.
    values : array (..., components)
        Readings, which are absent where one is not finite.
    """
    shape = values.shape[:-1]
    there = np.broadcast_to(_is_there(instant), shape)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reasons = observable.validity(instant)
    absent = {name: np.broadcast_to(np.asarray(where, dtype=bool), shape) & there for name, where in reasons.items()}
    known = np.logical_or.reduce([*absent.values(), np.zeros(shape, dtype=bool)])
    infinite = there & ~known & ~np.isfinite(values).all(axis=-1)
    return {**absent, observable.not_finite: infinite} if infinite.any() else absent


def _is_there(instant: AnyInstant) -> NDArray[np.bool_]:
    """Return True at the times that a motion reached."""
    first = next(iter(next(iter(instant.of_bodies.values())).attitude.components))
    return np.asarray(np.isfinite(np.asarray(first, dtype=float)))


def absent_counts(observable: Observable, parts: list[ReadingsOfMembers]) -> AbsentCounts:
    """Return the numbers of absent readings by reason."""
    count = len(observable.components) or 1
    found = AbsentCounts(0, {})
    for part in parts:
        reasons = {name: int(where.sum()) for name, where in part.absent.items()}
        found += AbsentCounts(part.values.size // count, reasons)
    return found


def warn_of_absent(observable: Observable, counts: AbsentCounts) -> None:
    """Warn of absent readings, with the number of each reason."""
    reasons = ", ".join(f"{name} at {count}" for name, count in counts.by_reason.items() if count)
    if reasons:
        warnings.warn(
            f"{type(observable).__name__} must have a reading at each time, but it has none at some of {counts.total} "
            f"times: {reasons}. These values are NaN.",
            stacklevel=level_of_user(),
        )


def with_readings(
    motion: Trajectory,
    observables: Mapping[str, Observable],
    again: Propagation,
    add: Callable[[str, AbsentCounts], None] | None = None,
) -> Trajectory:
    """Return a motion whose columns contain the readings of observables, by name."""
    values = {
        name: values_along(motion, each, motion.times, again, partial(add, name) if add else None)
        for name, each in observables.items()
    }
    return motion.with_observables(observables, values)


def readings_without_rows(motion: Trajectory, observables: Mapping[str, Observable]) -> dict[str, Array]:
    """Return readings of observables that are NaN at all times of all members, which need no memory."""
    shape = (len(motion), motion.times.size)
    return {
        name: np.broadcast_to(np.nan, (*shape, len(each.components)) if each.components else shape)
        for name, each in observables.items()
    }
