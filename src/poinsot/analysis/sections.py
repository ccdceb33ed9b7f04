"""Poincare sections: the states of motions at the crossings of an event, or once in a period.

The points of a regular motion with two degrees of freedom lie on a curve, those of a chaotic one fill an area.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times, rounded
from poinsot.errors import member_array, refuse_nonpositive, refuse_other_members
from poinsot.events.standard_events import AndoyerCrossing, AtTime
from poinsot.kinematics.andoyer import Andoyer
from poinsot.kinematics.euler import quaternion_from_angles
from poinsot.kinematics.state import State, changed, state_of
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.printable import described, quoted
from poinsot.propagation.dataset import dataset_of_result
from poinsot.propagation.ensemble_of_results import Analysis, analysed_in_chunks, taken_out
from poinsot.propagation.event_record import EventRecord
from poinsot.propagation.propagate import propagate
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Angle, Angles, AngularVelocities, Time
from poinsot.records.parameters import same
from poinsot.systems.system import OfOneBody, System
from poinsot.systems.times_and_states import checked_time

if TYPE_CHECKING:
    import xarray

__all__ = ["Section", "andoyer_section", "section", "spin_orbit_section"]

Array = NDArray[Any]

SECTION_TOLERANCE = 64 * np.finfo(float).eps
"""Largest distance from the angle of a section, radians, at which a start lies on the section."""

Coordinates = Callable[[EventRecord], tuple[ArrayLike, ArrayLike]]


@dataclass(frozen=True, eq=False, repr=False)
class Section(Summarized):
    """Points of motions in a plane, member by member, in the order of their times.

    Attributes
    ----------
    x, y : array (members, n)
        Coordinates of the points; NaN after the last point of a member.
    labels : tuple of str
        Names of the coordinates, with units.
    motion : Trajectory
        Motion from which the points were taken. Failed members contain the points before the failure.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> found = pt.analysis.andoyer_section(pt.System(body), start, 100.0)
    >>> found.x.shape, found.labels
    ((1, 15), ('l [rad]', 'L / G'))
    """

    x: Array
    y: Array
    labels: tuple[str, str]
    motion: Trajectory

    @property
    def dataset(self) -> xarray.Dataset:
        """Points as an xarray Dataset along `member` and `point`, with units and provenance."""
        named = [re.fullmatch(r"(.*?)(?: \[(.*)\])?", label) for label in self.labels]
        found = {
            axis: (("point",), values, one[2] or "1", one[1])
            for axis, values, one in zip("xy", (self.x, self.y), named, strict=True)
            if one
        }
        motion = self.motion
        attributes = motion.run.attributes(motion.failures)
        return dataset_of_result("Section of motions", motion.system, motion.times, found, {}, attributes)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Section of {len(self.x)} motion{'s' * (len(self.x) > 1)} of {rounded(repr(self.motion.system))}", {
            "times": formatted_times(self.motion.times, self.motion.system.units["time"]),
            "points": str(int(np.sum(np.isfinite(self.x)))),
            self.labels[0]: formatted(self.x),
            self.labels[1]: formatted(self.y),
        }


@checked
def section(
    motion: Trajectory, coordinates: Coordinates, event: int | None = None, labels: Sequence[str] = ("x", "y")
) -> Section:
    """Return the points of a motion at the times of one of its events, or at all its times.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body or of an ensemble.
    coordinates : callable
        Function of an `EventRecord` that returns x and y, each of shape (k,), from its `states`, `omega_body` and
        `times`.
    event : int, optional
        Index of an event in `motion.events`. Default: the times of the motion, such as one in each revolution.
    labels : two of str
        Names of the two coordinates, with units.

    Returns
    -------
    Section
        Points of each member.

    Raises
    ------
    TypeError, ValueError
        If the motion is not a trajectory or lacks the event, or the coordinates are not two arrays (k,).

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> motion = pt.propagate(pt.System(body), start, range(100))
    >>> pt.analysis.section(motion, lambda points: points.omega_body[:, :2].T, labels=("first rate", "second rate"))
    Section of 1 motion of System(Body(moments=[1.25, 1.0, 0.75]))
      times: 100, 0 ... 99
      points: 100
      ...
    """
    if event is not None and not 0 <= event < len(motion.events):
        raise ValueError(f"event must be below the {len(motion.events)} events of the motion, got {quoted(event)}.")
    if len(labels) != 2:
        raise ValueError(f"labels must be two words, got {quoted(labels)}.")
    points = _all_times(motion) if event is None else motion.events[event]
    found = _coordinates(coordinates, points)
    members = len(motion) if motion.is_ensemble else 1
    counts = np.bincount(points.members, minlength=members)
    place = np.arange(len(points)) - np.repeat(np.cumsum(counts) - counts, counts)
    x, y = np.full((2, members, int(np.max(counts, initial=0))), np.nan)
    x[points.members, place], y[points.members, place] = found
    return Section(x, y, (labels[0], labels[1]), motion)


def _coordinates(coordinates: Coordinates, points: EventRecord) -> list[Array]:
    """Return x and y of points, checked."""
    pair: Any = coordinates(points)
    if not isinstance(pair, Sequence | np.ndarray):
        raise TypeError(f"coordinates must return x and y, got {described(pair)}.")
    found = [np.asarray(x) for x in pair]
    if any(x.dtype.kind not in "iuf" for x in found):
        raise TypeError("coordinates must return real numbers, got others.")
    if len(found) != 2 or any(x.shape != (len(points),) for x in found):
        shapes = " and ".join(str(x.shape) for x in found)
        raise ValueError(f"coordinates must be two arrays of shape ({len(points)},), got {shapes}.")
    return found


def _all_times(motion: Trajectory) -> EventRecord:
    members = len(motion) if motion.is_ensemble else 1
    phase = changed(motion.phase, lambda x: np.reshape(x, (-1, x.shape[-1])))
    times, whose = np.tile(motion.times, members), np.repeat(np.arange(members), motion.times.size)
    got = np.isfinite(next(iter(phase.values()))[:, 0])
    states = state_of(changed(phase, lambda x: x[got]), times[got])
    directions = np.ones(int(got.sum()), dtype=int)
    return EventRecord(AtTime(0.0), motion.system, times[got], states, directions, whose[got])


@checked
def spin_orbit_section(
    system: OfOneBody, angle: Angles, rate: AngularVelocities, revolutions: int, **options: Any
) -> Section:
    """Return the rotation in the plane of an orbit at each periapsis: angle modulo pi, and angular velocity.

    The third body axis is normal to the orbit, and `angle` is between the first body axis and the direction to the
    periapsis (Wisdom, Peale and Mignard 1984, Icarus 58, 137). The motion begins at the periapsis next to the epoch.

    Parameters
    ----------
    system : System
        System whose forces use one Kepler orbit without members; several forces may share it.
    angle : float or array (members,)
        Angle at the first periapsis, radians.
    rate : float or array (members,)
        Inertial angular velocity, radians per unit of time: `1.5 * orbit.mean_motion` for three rotations in two
        revolutions.
    revolutions : int
        Number of revolutions of the orbit.
    **options
        Arguments of `propagate`. The default formulation is "planar".

    Returns
    -------
    Section
        Points with x in [0, pi). With `out` or `reduce`, the dataset of the points row by row, each with its `member`.

    Raises
    ------
    TypeError, ValueError
        If the orbit is of another kind, or a force tilts the spin axis.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.26, gamma=0.1), pt.GravityGradient(orbit))
    >>> pt.analysis.spin_orbit_section(moon, angle=0.1, rate=[1.0, 1.5], revolutions=10)
    Section of 2 motions of System(...)
      times: 11, 0 ... 62.831853
      points: 22
      ...
    """
    orbit, plan = _only_orbit(system), taken_out(options)
    refuse_nonpositive("revolutions", revolutions)
    theta, spin = member_array("angle", angle, ()), member_array("rate", rate, ())
    refuse_other_members(angle=theta.shape, rate=spin.shape)
    theta, spin = np.broadcast_arrays(theta, spin)
    passage = float(orbit.epoch) - float(orbit.mean_anomaly_at_epoch) / float(orbit.mean_motion)
    plane = np.broadcast_arrays(orbit.node, orbit.inclination, orbit.argument_of_periapsis + theta)
    omega = spin[..., None] * (0.0, 0.0, 1.0)
    start = system.body.state(quaternion_from_angles(np.stack(plane, axis=-1), "313"), omega_body=omega, time=passage)
    times: Array = passage + np.arange(revolutions + 1) * float(orbit.period)
    if plan:
        progress = options.pop("progress", None)
        analysis = Analysis(_spin_orbit_section_at, system, start, times, options)
        return cast("Section", analysed_in_chunks(plan, analysis, progress))
    return _spin_orbit_section_at(system, start, times, **options)


def _spin_orbit_section_at(system: OfOneBody, start: State, times: Array, **options: Any) -> Section:
    """Return the angle from the periapsis and the angular velocity at the times of passages of the periapsis."""
    motion = propagate(system, start, times, **{"formulation": "planar", **options})
    orbit = _only_orbit(system)

    def coordinates(points: EventRecord) -> tuple[Array, Array]:
        first_axis = points.states.of_bodies[""].attitude.apply([1.0, 0.0, 0.0])
        along, across = (first_axis @ np.array([float(x) for x in direction]) for direction in orbit.plane[:2])
        return np.mod(np.arctan2(across, along), np.pi), points.omega_body[:, 2]

    unit = system.units["time"]
    named = "angular velocity [rad / unit of time]" if unit == "1" else f"angular velocity [rad/{unit}]"
    return section(motion, coordinates, labels=("angle from the periapsis [rad]", named))


@checked
def andoyer_section(system: OfOneBody, state: State, time: Time, *, angle: Angle = 0.0, **options: Any) -> Section:
    """Return the Andoyer variables l and L/G at the times at which g passes an angle, growing.

    An initial state on the section is its first point.

    Parameters
    ----------
    system : System
        Body with forces; not two bodies.
    state : State
        State of one body or of members. A section of a system with two degrees of freedom requires that all members
        have the same energy and other conserved quantities.
    time : float
        Last time of the motion.
    angle : float
        Value of g on the section, radians.
    **options
        Arguments of `propagate`, without events.

    Returns
    -------
    Section
        Points with x = l in (-pi, pi] and y = L/G. With `out` or `reduce`, the dataset of the points row by row, each
        with its `member`.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> pt.analysis.andoyer_section(pt.System(body), start, 100.0)
    Section of 1 motion of System(Body(moments=[1.25, 1.0, 0.75]))
      times: 1, 100 ... 100
      points: 15
      ...
    """

    def coordinates(points: EventRecord) -> tuple[Array, Array]:
        if not len(points):
            return np.empty(0), np.empty(0)
        variables = Andoyer.from_state(points.states.of_bodies[""])
        return variables.l, variables.L / variables.G

    if plan := taken_out(options):
        progress, end = options.pop("progress", None), checked_time("time", time, system)
        given = options, {"angle": angle}
        analysis = Analysis(_andoyer_section_until, system, state, np.reshape(end, 1), *given)
        return cast("Section", analysed_in_chunks(plan, analysis, progress))
    event = AndoyerCrossing(angle=angle, direction=1)
    times: Any = [time]
    motion = propagate(system, state, times, events=[event], **options)
    points = section(motion, coordinates, 0, labels=("l [rad]", "L / G"))
    return _with_starts(points, Andoyer.from_state(state), event.angle)


def _andoyer_section_until(system: OfOneBody, state: State, times: Array, **options: Any) -> Section:
    return andoyer_section(system, state, times[0], **options)


def _with_starts(found: Section, starts: Andoyer, angle: Angles) -> Section:
    """Return a section with the starts that lie on it as first points: a zero at the start is no event."""
    own = (starts.g - angle, starts.l, starts.L / starts.G)
    off, l, height = (np.broadcast_to(part, len(found.x)) for part in own)
    on = np.abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi) <= SECTION_TOLERANCE
    if not np.any(on):
        return found
    first = np.where(on[:, None], np.stack([l, height], axis=-1), np.nan)
    x, y = (np.column_stack([own, rows]) for own, rows in zip(first.T, (found.x, found.y), strict=True))
    for rows in (x, y):
        rows[~on, :-1] = rows[~on, 1:]
        rows[~on, -1] = np.nan
    return Section(x, y, found.labels, found.motion)


def _only_orbit(system: System) -> KeplerOrbit:
    found = system.orbits
    if not found or not isinstance(found[0], KeplerOrbit) or any(not same(orbit, found[0]) for orbit in found):
        kinds = ", ".join(type(orbit).__name__ for orbit in found) or "none"
        raise TypeError(f"the forces of the system must have one KeplerOrbit, got {kinds}.")
    if any(number.ndim for number in found[0].numbers):
        raise ValueError("the orbit must be one for all members, but it has members.")
    return found[0]
