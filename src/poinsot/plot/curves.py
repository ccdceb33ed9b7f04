"""Curves against time; of an ensemble the median, and bands that hold most of the members."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.plot.labels import BLACK, COLOURS, time_label, time_unit_of
from poinsot.plot.panels import dress, panels
from poinsot.propagation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

__all__ = ["against_time", "lift_pen", "reached", "shade"]

Array = NDArray[np.float64]

STYLES = ("-", "--", "-.", ":")
BANDS = ((5, 95, 0.15), (25, 75, 0.25))
"""Percentiles between which a band lies, and its opacity."""
PLAIN = (-4, 5)
"""Powers of ten between which numbers on the axes are written without one."""
COLUMNS = 1500
"""Of a panel, in each of which a curve is drawn through its first, least, largest and last sample."""
SIZES = {1: (8.0, 4.0), 2: (11.0, 4.0), 4: (17.0, 4.2)}
"""Inches of figures, by the number of their panels."""


def reached(motion: Trajectory, name: str = "motion") -> Trajectory:
    """Return a motion of one body or two that has something to draw; refuse any other."""
    if not motion.times.size:
        raise ValueError(f"{name} must have times to draw, but it has none.")
    if not np.any(np.all(motion.reached, axis=-1)):
        raise ValueError(f"{name} must have a member that reached its last time, but none did.")
    return motion


def against_time(
    motion: Trajectory,
    drawn: Mapping[str, Mapping[str, Array]],
    given: Any,
    time_unit: str | None,
    title: str,
    log: bool = False,
) -> NDArray[Any]:
    """Draw named curves over the times of a motion, by the label of their panel, and return the panels."""
    unit = time_unit_of(motion.system.units, time_unit)
    times, label = unit.factor * motion.times, time_label(motion, unit)
    axes = panels(given, len(drawn), SIZES[len(drawn)], title)
    for panel, (quantity, curves) in zip(axes, drawn.items(), strict=True):
        for number, (name, values) in enumerate(curves.items(), len(panel.lines)):
            style = {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number // len(COLOURS) % len(STYLES)]}
            _draw(panel, times, values, label=name, **style)
        panel.margins(x=0 if times.size > 1 else None, y=0.08)
        if log:
            panel.set_yscale("log")
        else:
            panel.ticklabel_format(scilimits=PLAIN, useMathText=True)
        dress(panel, label, quantity)
    members = [values for curves in drawn.values() for values in curves.values() if values.ndim > 1]
    if members:
        axes[0].figure.supxlabel(_bands_in_words(members[0]), fontsize="small", color="#404040")
    return axes


def lift_pen(lines: Iterable[Line2D], jump: float) -> None:
    """Break lines where they jump."""
    for line in lines:
        x, y = (np.asarray(each, dtype=float) for each in line.get_data())
        after = np.flatnonzero(np.abs(np.diff(y)) > jump) + 1
        line.set_data(np.insert(x, after, x[after]), np.insert(y, after, np.nan))


def shade(panel: Axes, times: Array, where: NDArray[np.bool_], label: str) -> None:
    """Shade the times at which something is so, if there are any."""
    if not np.any(where):
        return
    edges = np.concatenate([times[:1], (times[1:] + times[:-1]) / 2, times[-1:]])
    begin, end = (np.flatnonzero(np.diff([0, *where, 0]) == sign) for sign in (1, -1))
    style: Any = {"linewidth": 0, "color": BLACK, "alpha": 0.12, "label": label}
    bars = list(zip(edges[begin], edges[end] - edges[begin], strict=True))
    panel.broken_barh(bars, (0, 1), transform=panel.get_xaxis_transform(), **style)
    dress(panel, panel.get_xlabel(), panel.get_ylabel())


def _draw(panel: Axes, times: Array, values: Array, **style: Any) -> None:
    style |= {"linewidth": 1.1, "marker": "o" if times.size == 1 else None}
    if values.ndim > 1:
        values = _complete(values)
        for low, high, opacity in BANDS:
            _draw_band(panel, times, np.percentile(values, [low, high], axis=0), color=style["color"], alpha=opacity)
        values = np.median(values, axis=0)
    panel.plot(*_seen(times, values), **style)


def _draw_band(panel: Axes, times: Array, edges: Array, **style: Any) -> None:
    """Fill what lies between two edges, shape (2, n)."""
    if times.size == 1:
        panel.vlines(times, *edges, linewidth=8, **style)
        return
    starts = _columns(times)
    low, high = np.minimum.reduceat(edges[0], starts), np.maximum.reduceat(edges[1], starts)
    panel.fill_between(times[starts], low, high, linewidth=0, **style)


def _complete(values: Array) -> Array:
    """Return the members that have a value at every time, or all if none has."""
    complete = ~np.any(np.isnan(values), axis=-1)
    return values[complete] if np.any(complete) else values


def _bands_in_words(values: Array) -> str:
    drawn, all_of_them = len(_complete(values)), len(values)
    members = f"{drawn} members" if drawn == all_of_them else f"the {drawn} of {all_of_them} members that did not stop"
    bands = " and ".join(f"{low} to {high} %" for low, high, _ in reversed(BANDS))
    return f"Median of {members}, and bands from {bands} of them."


def _columns(times: Array) -> NDArray[np.int64]:
    """Return where each column of a panel begins, or each sample where they are few."""
    if times.size <= 4 * COLUMNS:
        return np.arange(times.size)
    column = np.floor(COLUMNS * (times - times[0]) / (times[-1] - times[0]))
    return np.append(0, np.flatnonzero(np.diff(column)) + 1)


def _seen(times: Array, values: Array) -> tuple[Array, Array]:
    """Return the samples that can be told apart in a picture: of each column the first, least, largest and last."""
    starts = _columns(times)
    if starts.size == times.size:
        return times, values
    column = np.repeat(np.arange(starts.size), np.diff(np.append(starts, times.size)))
    sorted_within = np.lexsort((values, column))
    ends = np.append(starts[1:], times.size) - 1
    kept = np.unique(np.concatenate([starts, ends, sorted_within[starts], sorted_within[ends]]))
    return times[kept], values[kept]
