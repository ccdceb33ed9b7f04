"""Attitudes computed or measured elsewhere, as a table in time."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked, checked_fields
from poinsot.display.html_text import Summarized, formatted, formatted_times
from poinsot.errors import real_array
from poinsot.files.ccsds import FRAMES
from poinsot.kinematics.attitude import omega_body, rotation, rotation_angle, unit_quaternion
from poinsot.kinematics.state import State, changed, state_of
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.printable import quoted
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar
from poinsot.records.units import PER_TIME
from poinsot.storage.run_record import Method, RunRecord, versions
from poinsot.systems.system import System

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "AttitudeTable",
    "calendar_of",
    "dated_calendar",
    "rates_per_second",
    "stated_calendar",
    "statement_of",
    "table_of",
]

MIN_ROWS = 4
"""Smallest number of rows from which a spline computes the rates."""

SAME_TIME = 2e-9
"""Seconds: files of dates have nine digits of a second."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class AttitudeTable(Summarized):
    """Table of attitudes at times, as read from a file or written to one: x_space = q x_body q~.

    Parameters
    ----------
    times : array (n,)
        Increasing times.
    quaternion : array (n, 4)
        Unit quaternions body -> reference frame, scalar first, Hamilton product.
    omega_body : array (n, 3), optional
        Inertial angular velocity along the body axes, radians per unit of the times.
    calendar : Calendar, optional
        Date of t = 0 and unit of the times.
    reference_frame, body_frame : str
        Names of the inertial reference axes and of the body axes.
    norm_error : float
        Largest | |q| - 1 | in the file. The readers divide quaternions by their norm.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> table = pt.files.AttitudeTable([0.0, 1.0], [(1, 0, 0, 0), (0, 0, 0, 1)])
    >>> float(table.attitude.magnitude()[1])  # rad
    3.141592653589793
    """

    times: Array
    quaternion: Array
    omega_body: Array | None = None
    calendar: Calendar | None = None
    reference_frame: str = SPACE_AXES_UNNAMED
    body_frame: str = "SC_BODY_1"
    norm_error: float = 0.0

    def __post_init__(self) -> None:
        times = real_array("times", self.times, (None,))
        if not times.size:
            raise ValueError("times must not be empty, got shape (0,).")
        wrong = np.flatnonzero(np.diff(times) <= 0)
        if wrong.size:
            i = int(wrong[0])
            raise ValueError(f"times must rise, got times[{i + 1}] = {times[i + 1]} after {times[i]}.")
        object.__setattr__(self, "times", times)
        q = unit_quaternion(real_array("quaternion", self.quaternion, (times.size, 4)), "quaternion")
        object.__setattr__(self, "quaternion", q)
        if self.omega_body is not None:
            object.__setattr__(self, "omega_body", real_array("omega_body", self.omega_body, (times.size, 3)))
        object.__setattr__(self, "norm_error", float(real_array("norm_error", self.norm_error, ())))
        checked_fields(self)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        calendar, rate = self.calendar, PER_TIME if self.calendar is None else f"rad {self.calendar.unit}-1"
        return f"Attitudes of {self.body_frame} in {self.reference_frame}", {
            "times": formatted_times(self.times, "" if calendar is None else calendar.unit),
            "calendar": "" if calendar is None else f"t = 0 at {calendar.zero} {calendar.scale}",
            "rates": "none" if self.omega_body is None else formatted(self.omega_body, rate),
            "norm error in the file": f"{self.norm_error:.3g}",
        }

    @property
    def attitude(self) -> Rotation:
        """Attitudes body -> reference frame as a scipy rotation."""
        return rotation(self.quaternion)

    @checked
    def state(self, body: Body, row: int = 0) -> State:
        """Return the state of a body in one row, in the units of the table, as an initial state of a propagation."""
        if not -self.times.size <= row < self.times.size:
            raise ValueError(f"row must be below {self.times.size}, the number of rows, got {row}.")
        return body.state(self.quaternion[row], omega_body=self._rates()[row], time=self.times[row])

    @checked
    def trajectory(self, system: System) -> Trajectory:
        """Return the table as a motion of a system, for plots, files and the drift of conserved quantities.

        The momenta follow from the system's body and the angular velocities of the table. If the table lacks these, the
        method fits a spline of fifth degree to the quaternions, which requires several rows in each turn of the body.
        The motion retains the calendar and the name of the axes.

        Raises
        ------
        TypeError, ValueError
            If the first argument is not a system of one body, its orbits are along other axes, or there are no rates
            and fewer than four rows.
        """
        if system.members:
            raise ValueError(f"system must be of one body, got {system.members[0]} members.")
        (times, unit), q = self._times_of(system), self.quaternion
        phase = {"quaternion": q, "angular_momentum_body": system.of_bodies[""].angular_momentum(unit * self._rates())}
        given = "differentiated attitudes" if self.omega_body is None else "given rates"
        run = RunRecord(Method.TABLE, given, "double", 0.0, 0, 0, 0.0, versions())
        known: dict[str, Any] = {}
        if self.calendar is not None and system.calendar is None and system.units["time"] in SECONDS:
            known["calendar"] = dataclasses.replace(self.calendar, unit=system.units["time"])
        if self.reference_frame != SPACE_AXES_UNNAMED:
            known["reference_frame"] = self.reference_frame
        initial = state_of(changed(phase, lambda x: x[0]), times[0])
        return Trajectory(system, initial, times, MotionRows(phase), run, provenance=known)

    @checked
    def angle_to(self, motion: Trajectory) -> Array:
        """Return the angles in [0, pi] between the attitudes of the table and of a motion at the same instants; (n,).

        Raises
        ------
        TypeError, ValueError
            If the argument is not a motion of one body, is along other axes, or has neither the times of the table nor
            dense output.
        """
        _refuse_several(motion)
        times, unit = self._times_of(motion.system, motion.calendar)
        slack = SAME_TIME / (unit * (SECONDS[self.calendar.unit] if self.calendar else 1))
        same = times.shape == motion.times.shape and np.all(np.abs(times - motion.times) <= slack)
        return np.asarray(rotation_angle(self.quaternion, motion.quaternion if same else motion(times).quaternion))

    def _times_of(self, system: System, calendar: Calendar | None = None) -> tuple[Array, float]:
        """Return the times by the calendar and in the unit of a system, and that unit in units of the table."""
        calendar = calendar or system.calendar
        named = (orbit.reference_frame for orbit in system.orbits if orbit.reference_frame != SPACE_AXES_UNNAMED)
        frame = next(named, SPACE_AXES_UNNAMED)
        if frame != self.reference_frame and SPACE_AXES_UNNAMED not in (frame, self.reference_frame):
            raise ValueError(f"the table must be along the axes of the system, {frame}, got {self.reference_frame}.")
        if self.calendar is None:
            return self.times, 1.0
        own = SECONDS[self.calendar.unit]
        if calendar is None:
            unit = SECONDS.get(system.units["time"], own) / own
            return self.times / unit, unit
        return np.asarray(calendar.converted(self.times, self.calendar)), SECONDS[calendar.unit] / own

    def _rates(self) -> Array:
        if self.omega_body is not None:
            return self.omega_body
        if self.times.size < MIN_ROWS:
            raise ValueError(f"a table without rates must have {MIN_ROWS} rows or more, got {self.times.size}.")
        from scipy.interpolate import make_interp_spline

        turned = quat.dot(self.quaternion[1:], self.quaternion[:-1]) < 0  # q and -q are one attitude
        signs = np.cumprod(np.where(np.append(False, turned), -1.0, 1.0))
        q = self.quaternion * signs[:, None]
        spline = make_interp_spline(self.times, q, k=5 if self.times.size > 5 else 3)
        return omega_body(q, spline.derivative()(self.times))


def table_of(
    motion: Any,
    calendar: Calendar | None = None,
    reference_frame: str | None = None,
    body_frame: str | None = None,
    *,
    dated: bool = True,
) -> AttitudeTable:
    """Return the table that a writer writes, with increasing times. A dated table has a calendar and a frame."""
    own: AttitudeTable = motion
    if isinstance(motion, Trajectory):
        _refuse_several(motion)
        order = np.argsort(motion.times)
        q, omega = motion.quaternion[order], motion.omega_body[order]
        own = AttitudeTable(motion.times[order], q, omega, motion.calendar, motion.reference_frame)
    if calendar is not None and own.calendar is not None and calendar != own.calendar:
        raise ValueError(f"calendar must be the calendar of the motion, {own.calendar}, got {calendar}.")
    calendar = calendar or own.calendar
    unit = motion.system.units["time"] if isinstance(motion, Trajectory) else "1"
    if calendar is not None and unit not in ("1", calendar.unit):
        raise ValueError(
            f"calendar must count {quoted(unit)} as the system does, got one that counts {quoted(calendar.unit)}."
        )
    frame = _named(own.reference_frame, reference_frame, dated)
    table = dataclasses.replace(own, calendar=calendar, reference_frame=frame, body_frame=body_frame or own.body_frame)
    if dated:
        calendar_of(table)
    return table


def calendar_of(table: AttitudeTable) -> Calendar:
    """Return the calendar of a table, which must have one."""
    if table.calendar is None:
        raise ValueError(
            "calendar must be given for a motion without one, got none. It states the instant of t = 0: "
            "calendar=Calendar('2026-11-21T00:00:00', 'UTC')."
        )
    return table.calendar


def rates_per_second(table: AttitudeTable, wanted: bool) -> Array | None:
    """Return the rates of a dated table in radians per second, None if it has none or they are not wanted."""
    if table.omega_body is None or not wanted:
        return None
    return np.asarray(table.omega_body / SECONDS[calendar_of(table).unit])


def dated_calendar(date: str, scale: str, unit: str, name: str, example: str, given: str) -> Calendar:
    """Return the calendar that a text names, whose date exists."""
    try:
        calendar = Calendar(date, scale, unit)
        calendar.date(0.0)
        return calendar
    except ValueError:
        raise ValueError(f"{name} must be a date such as {example}, got {quoted(given)}.") from None


def stated_calendar(statement: str, name: str) -> Calendar:
    """Return the calendar that a line of a file states, such as "s from 2026-11-21T00:00:00 UTC"."""
    match = re.fullmatch(r"(\w+) from (\S+) (\w+)", statement)
    unit, date, scale = match.groups() if match else ("s", "", "UTC")
    return dated_calendar(date, scale, unit, name, "s from 2026-11-21T00:00:00 UTC", statement)


def statement_of(calendar: Calendar) -> str:
    """Return the line from which `stated_calendar` makes the calendar again."""
    return f"{calendar.unit} from {calendar.zero} {calendar.scale}"


def _named(own: str, given: str | None, dated: bool) -> str:
    """Return the name of the reference frame, as given if it is the one of the motion."""
    if given is not None and own != SPACE_AXES_UNNAMED and FRAMES.get(given, given) != FRAMES.get(own, own):
        raise ValueError(
            f"reference_frame must be the reference frame of the motion, {quoted(own)}, got {quoted(given)}."
        )
    if dated and given is None and own == SPACE_AXES_UNNAMED:
        raise ValueError(
            "reference_frame must be given for a motion whose space axes have no name, got none. "
            "Pass reference_frame='ICRF' for axes of the ICRF."
        )
    if dated and (given or own) not in FRAMES:
        raise ValueError(f"reference_frame must be one of {', '.join(FRAMES)}, got {quoted(given or own)}.")
    return given or own


def _refuse_several(motion: Trajectory) -> None:
    if len(motion.of_bodies) > 1:
        raise ValueError("motion must be of one body, got two. Take motion.primary or motion.secondary.")
    if motion.quaternion.ndim == 3:
        raise ValueError(f"motion must be of one body, got an ensemble of {len(motion.quaternion)} members.")
