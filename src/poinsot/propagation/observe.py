"""Simulated measurements: the readings of observables along a motion."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.errors import PropagationError, level_of_user
from poinsot.kinematics.state import AnyState, changed, state_of
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Environment
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.pair_instant import AnyInstant
from poinsot.observables.readings import Readings
from poinsot.printable import described, quoted
from poinsot.propagation.propagate import propagate
from poinsot.propagation.recorded import RecordedEvent, RecordedSystem
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Times
from poinsot.records.members import expanded, members_of
from poinsot.records.units import DerivedUnits
from poinsot.systems.collection import Collection
from poinsot.systems.formula_trials import try_observable
from poinsot.systems.system import System
from poinsot.systems.times_and_states import checked_times

__all__ = ["absent_readings", "checked_observables", "observe", "refuse_unfit"]

Array = NDArray[np.float64]


@checked
def observe(
    motion: Trajectory, *observables: Observable | Readings, times: Times | None = None
) -> Readings | tuple[Readings, ...]:
    """Return the readings of observables along a motion.

    At times between the rows of the motion, the body is read from the dense output of the motion, or from another
    propagation from its initial state. Readings with light time show the body as it was when the light left it.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body or of two bodies, or an ensemble. Of two bodies, `observable.on("secondary")` is the
        observable of one of them.
    *observables : Observable or Readings
        Instruments, or readings without values, which give times and standard deviations: a plan of measurements.
    times : array (n,), optional
        Times of the readings, dates if an orbit has a calendar. Default: the times of the motion, or of the plan.

    Returns
    -------
    Readings or tuple of Readings
        Readings of each observable. For an ensemble, or an observable whose numbers have an axis of members, that axis
        is first. A reading is NaN where the motion has no row or the instrument has no reading.

    Raises
    ------
    TypeError, ValueError
        If an argument is not an observable, the observable does not fit the bodies, or a time is outside of the span of
        an orbit, or the motion cannot be propagated to a time between its rows.

    Warns
    -----
    UserWarning
        Once for each observable, with the reasons why readings are absent.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 2)), [0.0, 1.0])
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return pt.functions.norm(instant.omega_body)
    >>> pt.observe(motion, Rate()).values
    array([2., 2.])
    """
    found = tuple([_observed(motion, each, times) for each in checked_observables(observables)])
    return found[0] if len(found) == 1 else found


def checked_observables(given: Sequence[Observable | Readings]) -> Sequence[Observable | Readings]:
    """Return observables or readings, of which there must be one at least; raise a TypeError for others."""
    if not given:
        raise TypeError("observe must have at least one observable after the motion, got none.")
    for each in given:
        if isinstance(each, type):
            name = each.__name__
            raise TypeError(f"observable must be an instance, got the class {name}. Write {name}(...).")
        if not isinstance(each, Observable | Readings):
            raise TypeError(f"observable must be an Observable or Readings, got {described(each)}.")
    return given


def _observed(motion: Trajectory, given: Observable | Readings, times: Times | None) -> Readings:
    """Return the readings of one observable, or of a plan."""
    plan = given if isinstance(given, Readings) else None
    observable = given if isinstance(given, Observable) else given.observable
    if motion._pair is not None:
        motion, observable = motion._pair, observable.on(motion._body)
    if plan is not None and times is not None:
        raise ValueError("times must not be given for readings, which have times, got both. Leave them out.")
    if plan is not None:
        t = _converted(plan, motion)
    else:
        t = motion.times if times is None else checked_times(times, motion.system)
    values = values_along(motion, observable, t)
    sigma, name = (plan.sigma, plan.name) if plan else (None, "")
    return Readings(
        observable, t, values, sigma, name=name, calendar=motion.calendar, attributes=_attributes(motion, observable)
    )


def _converted(plan: Readings, motion: Trajectory) -> Array:
    """Return the times of a plan as times of the motion."""
    if plan.calendar is None or motion.calendar is None:
        return plan.times
    return motion.calendar.converted(plan.times, plan.calendar)


def _attributes(motion: Trajectory, observable: Observable) -> dict[str, str]:
    """Return units, frame and provenance of readings of a motion."""
    units = motion.system.units
    frame = "" if motion.reference_frame == SPACE_AXES_UNNAMED else motion.reference_frame
    about = {
        "units": observable.unit(DerivedUnits(units)),
        "frame": observable.frame,
        "time_units": units["time"],
        "reference_frame": frame,
        "title": str(motion.provenance.get("title") or ""),
        "system": repr(motion.system),
        "initial_state": repr(motion.initial),
        **{f"version_{name}": version for name, version in motion.run.versions.items()},
    }
    return {name: text for name, text in about.items() if text}


# ---------------------------------------------------------------------- values


def values_along(motion: Trajectory, observable: Observable, times: Array) -> Array:
    """Return the readings at times, NaN where there is none, with one warning about the reasons.

    The result has the shape (n,) or (n, components), with members first.
    """
    refuse_unfit(motion.system, observable, (len(motion),) if motion.is_ensemble else (), times)
    seen = observable.time_of_body(times, DerivedUnits(motion.system.units))
    parts = [_read(each, own, at) for each, own, at in _parts(motion, observable, seen)]
    values = parts[0].values if len(parts) == 1 else np.concatenate([part.values for part in parts])
    _warn(observable, parts)
    return values


def refuse_unfit(system: System, observable: Observable, members: tuple[int, ...], times: Array) -> None:
    """Raise an error for an observable that does not fit a system of members, or times at which an orbit is unknown."""
    Collection((*system.dynamics.records, observable)).refuse_other_axes()
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


class _Values(NamedTuple):
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


def _read(motion: Trajectory, observable: Observable, seen: Array) -> _Values:
    """Return the readings at times of the body, which all members share."""
    if np.array_equal(seen, motion.times):
        return _evaluated(motion, observable, motion._reader.state, motion.environment)
    wanted, place = np.unique(seen, return_inverse=True)
    state, environment = _states(motion, wanted)
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
    return _Values(np.take(full, place, axis), {name: where[..., place] for name, where in absent.items()})


def _states(motion: Trajectory, times: Array) -> tuple[AnyState, Environment]:
    """Return the states at those of ascending times that the motion reaches, with the environment at these times."""
    if motion.has_dense_output:
        return motion(times), Environment(times)
    among = np.isin(motion.times, times)
    there = among.sum() == times.size
    rows = motion.isel(time=np.flatnonzero(among)) if there else _propagated(motion, times)
    return rows._reader.state, rows.environment


def _propagated(motion: Trajectory, times: Array) -> Trajectory:
    """Return the motion at other times, by another propagation from its initial state."""
    system, run = motion.system, motion.run
    events = [record.event for record in motion.events]
    formulas = isinstance(system, RecordedSystem) or any(isinstance(event, RecordedEvent) for event in events)
    if formulas or not system.dynamics.moves_alone:
        raise ValueError(
            "times must be among the times of a motion without formulas, such as a motion from a file, got others. "
            "Propagate the system, or choose some of motion.times."
        )
    try:
        return propagate(
            system,
            motion.initial,
            times,
            events=events,
            formulation=run.formulation or None,
            tolerance=run.tolerance or None,
            precision=run.precision,
            progress=False,
        )
    except PropagationError as error:
        stopped: Trajectory = error.trajectory
        return stopped


def _evaluated(motion: Trajectory, observable: Observable, state: AnyState, environment: Environment) -> _Values:
    """Return the readings of states, NaN where the instrument has none."""
    if observable.member_axis and not motion.is_ensemble:
        state = state_of(changed(state.phase, lambda rows: rows[None]), state.time)
    instant: Any = motion.system.at(state, environment)
    shape = np.broadcast_shapes(observable.member_axis + (1,) * bool(observable.member_axis), instant.shape)
    twin = observable.with_numbers(expanded(number, len(shape)) for number in observable.numbers)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reading = twin.reading(instant)
    scalars = list(reading) if observable.components else [reading]
    columns = [np.array(np.broadcast_to(np.asarray(x, dtype=float), shape)) for x in scalars]
    values = np.stack(columns, axis=-1)
    absent = absent_readings(twin, instant, values)
    values[np.logical_or.reduce([*absent.values(), np.zeros(shape, dtype=bool)])] = np.nan
    return _Values(values if observable.components else values[..., 0], absent)


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


def _warn(observable: Observable, parts: list[_Values]) -> None:
    """Warn of absent readings, with the number of each reason."""
    counts: dict[str, int] = {}
    total = 0
    for part in parts:
        count = len(observable.components) or 1
        total += part.values.size // count
        for name, where in part.absent.items():
            counts[name] = counts.get(name, 0) + int(where.sum())
    reasons = ", ".join(f"{name} at {count}" for name, count in counts.items() if count)
    if reasons:
        warnings.warn(
            f"{type(observable).__name__} must have a reading at each time, but it has none at some of {total} times: "
            f"{reasons}. These values are NaN.",
            stacklevel=level_of_user(),
        )
