"""Simulated measurements: the readings of observables along a motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

from poinsot.checked import checked
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import described
from poinsot.propagation.propagate import propagated_again
from poinsot.propagation.readings_along import values_along
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.units import DerivedUnits
from poinsot.systems.times_and_states import checked_times

__all__ = ["checked_observables", "observe"]


@overload
def observe(motion: Trajectory, observable: Observable | Readings, /, *, times: Times | None = ...) -> Readings: ...


@overload
def observe(
    motion: Trajectory,
    first: Observable | Readings,
    second: Observable | Readings,
    /,
    *others: Observable | Readings,
    times: Times | None = ...,
) -> tuple[Readings, ...]: ...


@overload
def observe(
    motion: Trajectory, *observables: Observable | Readings, times: Times | None = ...
) -> Readings | tuple[Readings, ...]: ...


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
    values = values_along(motion, observable, t, propagated_again)
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
