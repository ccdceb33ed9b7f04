"""Axes of time: numbers in the unit that suits their span, or dates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from poinsot.plot.labels import Unit, time_unit_of
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["TimeAxis", "axis_of", "instant", "time_axis"]

DATES = ["%Y", "%Y-%m", "%m-%d", "%H:%M", "%H:%M", "%H:%M:%S.%f"]
FIRST_DATES = ["%Y", "%Y", "%Y-%m-%d", "%m-%d", "%H:%M", "%H:%M:%S"]
"""Formats of ticks at years, months, days, hours, minutes and seconds, and of ticks where a longer unit begins."""
WHOLE = re.compile(r"\.0*$")
"""Zero decimals at the end of a date with whole seconds."""
MAX_DATES = 7
"""Ticks of an axis of dates: 36 months, 72 hours, 180 minutes and seconds have so many of their largest intervals."""
UNIX_EPOCH = 2440587.5
"""1970-01-01 as a Julian date."""


@dataclass(frozen=True)
class TimeAxis:
    """Axis of times.

    Attributes
    ----------
    unit : Unit
        Unit of the numbers on the axis.
    label : str
    calendar : Calendar, optional
        Calendar of an axis of dates.
    """

    unit: Unit
    label: str
    calendar: Calendar | None = None

    def places(self, times: ArrayLike) -> Array:
        """Return the coordinates of times on the axis."""
        times = np.asarray(times, dtype=float)
        if self.calendar is None:
            return np.asarray(self.unit.factor * times)
        import matplotlib.dates as mdates

        dates: Any = mdates
        date = self.calendar.date(times)
        return np.asarray(date.jd1 - UNIX_EPOCH + date.jd2 + dates.date2num(np.datetime64("1970-01-01")))

    def mark(self, panel: Axes) -> None:
        """Write dates at the ticks of an axis of dates."""
        if self.calendar is None:
            return
        import matplotlib.dates as mdates

        dates: Any = mdates
        locator = dates.AutoDateLocator(minticks=3, maxticks=MAX_DATES)
        written = {"formats": DATES, "zero_formats": FIRST_DATES, "show_offset": False}
        panel.xaxis.set_major_locator(locator)
        panel.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator, **written))


def time_axis(motion: Trajectory, chosen: str | None, times: ArrayLike | None = None) -> TimeAxis:
    """Return the axis of some or all times of a motion: dates for a calendar, unless a unit is chosen."""
    return axis_of(motion.times if times is None else times, motion.system.units, motion.calendar, chosen)


def axis_of(times: ArrayLike, units: Mapping[str, str], calendar: Calendar | None, chosen: str | None) -> TimeAxis:
    """Return the axis of times in the unit of time of `units`: dates for a calendar, unless a unit is chosen."""
    times = np.asarray(times, dtype=float)
    if chosen == "date" and calendar is None:
        raise ValueError(
            "time_unit must not be 'date' without a calendar of the times, got 'date'. An orbit or a scenario with a "
            "calendar has one."
        )
    if calendar is not None and (chosen == "date" or (chosen is None and find_spec("astropy") is not None)):
        return TimeAxis(Unit(1.0, "date"), f"date, from {_dated(calendar, float(times[0]))}", calendar)
    unit = time_unit_of(units, chosen, times)
    since = "" if calendar is None else f" since {WHOLE.sub('', calendar.zero)} {calendar.scale}"
    return TimeAxis(unit, f"time{unit.label}{since}")


def instant(motion: Trajectory, time: float, chosen: str | None) -> str:
    """Return a time of a motion as text: "time 12.5 s", "2029-04-13T21:46:00 TDB"."""
    axis = time_axis(motion, chosen)
    if axis.calendar is not None:
        return _dated(axis.calendar, time)
    written = "" if axis.unit.written == "1" else f" {axis.unit.written}"
    return f"time {axis.unit.factor * time:.6g}{written}"


def _dated(calendar: Calendar, time: float) -> str:
    """Return the date of a time, to the second: "2029-04-13T21:46:00 TDB"."""
    date = calendar.date(time)
    return f"{date.strftime('%Y-%m-%dT%H:%M:%S')} {date.scale.upper()}"
