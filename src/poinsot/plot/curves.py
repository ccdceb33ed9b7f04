"""Curves against time; an ensemble is drawn as its median with bands that contain most of the members."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import real_array
from poinsot.plot.labels import BLACK, COLOURS, GREY, in_words
from poinsot.plot.panels import PLAIN, Axes, Pair, dress, panels
from poinsot.plot.time_axis import TimeAxis, time_axis
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar

__all__ = [
    "STYLES",
    "CurveOptions",
    "PairOptions",
    "SeparateCurveOptions",
    "SeparatePairOptions",
    "against_time",
    "bands_in_words",
    "covered",
    "draw_curve",
    "in_one_panel",
    "jumps",
    "reached",
    "scale",
    "within_window",
]

Booleans = NDArray[np.bool_]

STYLES = ("-", "--", "-.", ":")
BANDS = ((5, 95, 0.15), (25, 75, 0.25))
"""Percentiles between which a band lies, and its opacity."""
PANEL_COLUMNS = 1500
"""Number of columns of a panel. A curve is drawn through the first, least, largest and last sample of each."""
MAX_TURNING_POINTS = 600
"""Largest number of turning points of a curve; a curve with more is drawn as its envelope."""
POINTS_PER_COLUMN = 4
ENVELOPE_OPACITY = 0.3
"""Opacity of an envelope."""
COVERED = 0.1, 0.005
"""Fraction of samples at which a curve covers an earlier one, and tolerance as fraction of the range of a panel."""
FEW_DECADES = 2.5
MIN_RELATIVE_CHANGE = 1e-9
"""Fraction of the largest value below which the axis does not enlarge changes."""
SIZES = {1: (8.0, 4.0), 2: (11.0, 4.0), 4: (17.0, 4.2)}
"""Inches of figures, by the number of their panels."""
PANEL_GAP = 0.06
"""Gap between the parts of a panel, as fraction of its height."""
MAX_EVENT_LINES = 30
"""Largest number of events drawn as lines over the full height; more events are ticks at the upper edge."""
EVENT_STYLES = (":", "--", "-.", (0, (1, 4)))
EDGE_MARGIN = 0.02
"""Margin on either side of the curves, as fraction of the time span, if an event follows the last time."""


NONE: Mapping[str, Booleans] = {}


class TimeOptions(TypedDict, total=False):
    """Options of all plots of curves against time."""

    time_unit: str | None
    window: ArrayLike | None
    title: str


class CurveOptions(TimeOptions, total=False):
    """Options of plots of curves in one panel."""

    ax: Axes | None


class PairOptions(TimeOptions, total=False):
    """Options of plots of curves in two panels."""

    axes: Pair


class SeparateCurveOptions(CurveOptions, total=False):
    """Options of plots whose curves may be drawn in separate parts of the panel."""

    separate: bool


class SeparatePairOptions(PairOptions, total=False):
    """Options of plots whose curves may be drawn in separate parts of two panels."""

    separate: bool


def reached(motion: Trajectory, name: str = "motion") -> Trajectory:
    """Return a motion of one body or two; raise an error if it contains nothing to draw."""
    if not motion.times.size:
        raise ValueError(f"{name} must contain times to draw, got none.")
    if not np.any(np.all(motion.reached, axis=-1)):
        raise ValueError(f"{name} must have a member that reached its last time, but none did.")
    return motion


def in_one_panel(
    motion: Trajectory, label: str, curves: Mapping[str, Array], *, ax: Axes | None = None, **options: Any
) -> Axes:
    """Draw named curves over the times of a motion in one panel, as `against_time`, and return the panel."""
    panel: Axes = against_time(motion, {label: curves}, axes=ax, **options)[0]
    return panel


def against_time(
    motion: Trajectory,
    drawn: Mapping[str, Mapping[str, Array]],
    *,
    axes: Any = None,
    time_unit: str | None = None,
    window: ArrayLike | None = None,
    separate: bool = False,
    title: str = "",
    log: bool = False,
    breaks: Mapping[str, Booleans] = NONE,
    shaded: Mapping[str, Booleans] = NONE,
) -> NDArray[Any]:
    """Draw named curves over the times of a motion, by the label of their panel, and return the panels.

    `breaks` maps names of curves to the samples at which a piece begins. `shaded` maps labels to the times to shade.
    """
    shown = within_window(motion.times, motion.calendar, window)
    axis = time_axis(motion, time_unit, motion.times[shown])
    times = axis.places(motion.times[shown])
    places = panels(axes, len(drawn), SIZES[len(drawn)], title)
    for panel, (quantity, curves) in zip(places, drawn.items(), strict=True):
        parts = _divided(panel, len(curves)) if separate and len(curves) > 1 else [panel] * len(curves)
        before = len(panel.get_legend_handles_labels()[1])
        covers = [0] * len(curves) if separate else covered(list(curves.values()), shown, log)
        for number, (part, (name, values), below) in enumerate(zip(parts, curves.items(), covers, strict=True), before):
            look = STYLES[(number // len(COLOURS) + below) % len(STYLES)]
            style = {"color": COLOURS[number % len(COLOURS)], "linestyle": look}
            begin = breaks[name][shown] if name in breaks and values.ndim == 1 else np.zeros(times.size, dtype=bool)
            draw_curve(part, times, values[..., shown], begin, label=name if part is panel else None, **style)
            if part is not panel:
                part.set_ylabel(name, rotation=0, ha="left", va="center")
        for part in dict.fromkeys(parts):
            scale(part, times, log)
            for name, where in shaded.items():
                _shade(part, times, where[shown], name)
            _mark_events(part, motion, motion.times[shown], axis)
        axis.mark(panel)
        dress(panel, axis.label, quantity, legend_of=parts[0])
    for panel in places if separate else ():
        _move_label_away(panel)
    members = [values for curves in drawn.values() for values in curves.values() if values.ndim > 1]
    if members:
        places[0].figure.supxlabel(bands_in_words(members[0]), fontsize="small", color="#404040")
    return places


def within_window(times: Array, calendar: Calendar | None, window: ArrayLike | None, name: str = "motion") -> Booleans:
    """Return a mask of the times in a window of times or dates; raise an error if the window contains none."""
    if window is None:
        return np.ones(times.shape, dtype=bool)
    start, stop = real_array("window", window if calendar is None else calendar.time(window), (2,))
    shown = (times >= start) & (times <= stop)
    if not np.any(shown):
        first, last = times[[0, -1]]
        raise ValueError(
            f"window must hold a time of the {name}, which are from {first:.6g} to {last:.6g}, got ({start:.6g}, "
            f"{stop:.6g})."
        )
    return np.asarray(shown)


def covered(curves: Sequence[Array], shown: Booleans | slice, log: bool) -> list[int]:
    """Return the number of earlier curves that each curve of a panel covers where it is drawn."""
    middles = np.array([values if values.ndim == 1 else np.median(_complete(values), axis=0) for values in curves])
    drawn = middles[:, shown]
    drawn = np.log(drawn, where=drawn > 0, out=np.full_like(drawn, np.nan)) if log else drawn
    known = drawn[np.isfinite(drawn)]
    near = COVERED[1] * np.ptp(known) if known.size else 0.0
    return [sum(np.mean(np.abs(drawn[i] - drawn[j]) <= near) > COVERED[0] for j in range(i)) for i in range(len(drawn))]


def _divided(panel: Axes, count: int) -> list[Axes]:
    """Return parts of a panel one below the other, which share its time axis; the panel retains its labels."""
    height = (1 + PANEL_GAP) / count - PANEL_GAP
    parts: list[Axes] = []
    for i in range(count):
        part = panel.inset_axes((0.0, 1 - height - i * (height + PANEL_GAP), 1.0, height), sharex=panel)
        part.tick_params(labelbottom=False, bottom=False)
        part.yaxis.set_label_position("right")
        part.grid(alpha=0.25)
        parts.append(part)
    panel.margins(x=0)
    panel.set_yticks([])
    panel.spines[:].set_visible(False)
    panel.patch.set_visible(False)
    return parts


def _move_label_away(panel: Axes) -> None:
    """Put the label of a panel to the left of the ticks of its parts."""
    figure: Any = panel.get_figure(root=True)
    figure.draw_without_rendering()
    ticks = [
        tick.get_window_extent() for part in panel.child_axes for tick in part.get_yticklabels() if tick.get_text()
    ]
    outermost = min((box.x0 for box in ticks), default=panel.bbox.x0)
    panel.yaxis.labelpad += (panel.bbox.x0 - outermost) * 72 / figure.dpi


def scale(panel: Axes, times: Array, log: bool) -> None:
    """Set the margins of a panel, and the notation of its numbers."""
    panel.margins(x=0 if times.size > 1 else None, y=0.08)
    if log:
        panel.set_yscale("log")
        _count_decades(panel)
    else:
        low, high = panel.get_ylim()
        largest = max(abs(low), abs(high))
        if high - low < MIN_RELATIVE_CHANGE * largest:
            panel.set_ylim(low - 0.5 * largest, high + 0.5 * largest)
        panel.ticklabel_format(axis="y", scilimits=PLAIN, useMathText=True)


def _count_decades(panel: Axes) -> None:
    """Put ticks at 1, 2 and 5 on a log axis of few decades, where the default ticks are too few or too many."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter, StrMethodFormatter

    low, high = np.log10(panel.get_ylim())
    if high - low > FEW_DECADES:
        return
    plain = PLAIN[0] < low and high < PLAIN[1]
    panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}") if plain else LogFormatterSciNotation())
    panel.yaxis.set_minor_formatter(NullFormatter())


def _shade(panel: Axes, times: Array, where: Booleans, label: str) -> None:
    """Shade the times at which a condition holds, if there are any."""
    if not np.any(where):
        return
    edges = np.concatenate([times[:1], (times[1:] + times[:-1]) / 2, times[-1:]])
    begin, end = (np.flatnonzero(np.diff([0, *where, 0]) == sign) for sign in (1, -1))
    style: Any = {"linewidth": 0, "color": BLACK, "alpha": 0.12, "label": label}
    bars = list(zip(edges[begin], edges[end] - edges[begin], strict=True))
    panel.broken_barh(bars, (0, 1), transform=panel.get_xaxis_transform(), **style)


def _mark_events(panel: Axes, motion: Trajectory, times: Array, axis: TimeAxis) -> None:
    """Mark events, few as lines and many as ticks, with their name and number.

    A terminal event stops the motion between its last output time and the next.
    """
    start, stop = np.min(times), np.max(times)
    step = np.max(np.abs(np.diff(times))) if times.size > 1 else np.inf
    for found, style in zip(motion.events, EVENT_STYLES * len(motion.events), strict=False):
        beyond = step if found.event.terminal and motion.times[-1] in (start, stop) else 0
        own = found.times[(found.times >= start - beyond) & (found.times <= stop + beyond)]
        if not own.size:
            continue
        few = own.size <= MAX_EVENT_LINES
        label = in_words(found.event.kind) + (f", {own.size} times" if own.size > 1 else "")
        look: Any = {"colors": GREY, "linewidth": 1.0, "linestyle": style, "label": label, "zorder": 1.5}
        if np.any((own < start) | (own > stop)):
            panel.margins(x=EDGE_MARGIN)
        panel.vlines(axis.places(own), 0 if few else 0.95, 1, transform=panel.get_xaxis_transform(), **look)


def draw_curve(panel: Axes, times: Array, values: Array, begin: Booleans, **style: Any) -> None:
    """Draw a curve, shape (n,), or the median and bands of members, (members, n), in pieces that begin where stated."""
    style |= {"linewidth": 1.1, "marker": "o" if times.size == 1 else None}
    if values.ndim > 1:
        values = _complete(values)
        for low, high, opacity in BANDS:
            _draw_band(panel, times, np.percentile(values, [low, high], axis=0), color=style["color"], alpha=opacity)
        values = np.median(values, axis=0)
    steps = np.diff(values)
    turning_points = int(np.count_nonzero(steps[1:] * steps[:-1] < 0))
    if turning_points > MAX_TURNING_POINTS:
        columns = _columns(times, min(turning_points // POINTS_PER_COLUMN, PANEL_COLUMNS))
        _draw_envelope(panel, times, values, columns, style["color"], style["label"])
    else:
        panel.plot(*_seen(times, values, begin), **style)


def _draw_envelope(
    panel: Axes, times: Array, values: Array, columns: NDArray[np.int64], color: str, label: str | None
) -> None:
    """Fill the area between the least and the largest value of each column."""
    from matplotlib.colors import to_rgba

    low, high = np.fmin.reduceat(values, columns), np.fmax.reduceat(values, columns)
    middle = 0.5 * (times[columns] + times[np.append(columns[1:], times.size) - 1])
    middle[[0, -1]] = times[[0, -1]]
    look: Any = {"facecolor": to_rgba(color, ENVELOPE_OPACITY), "edgecolor": color, "linewidth": 0.6, "label": label}
    panel.fill_between(middle, low, high, **look)


def _draw_band(panel: Axes, times: Array, edges: Array, **style: Any) -> None:
    """Fill the area between two edges, shape (2, n)."""
    if times.size == 1:
        panel.vlines(times, *edges, linewidth=8, **style)
        return
    starts = _columns(times)
    low, high = np.minimum.reduceat(edges[0], starts), np.maximum.reduceat(edges[1], starts)
    panel.fill_between(times[starts], low, high, linewidth=0, **style)


def jumps(values: Array, limit: float) -> Booleans:
    """Return a mask of the samples whose values differ from the previous sample by more than a limit."""
    return np.asarray(np.abs(np.diff(values, axis=-1, prepend=values[..., :1])) > limit)


def _complete(values: Array) -> Array:
    """Return the members that reach every time, or all members if none does."""
    complete = ~np.any(np.isnan(values), axis=-1)
    return values[complete] if np.any(complete) else values


def bands_in_words(values: Array) -> str:
    """Return the caption of the bands of members."""
    drawn, all_of_them = len(_complete(values)), len(values)
    members = f"{drawn} members" if drawn == all_of_them else f"the {drawn} of {all_of_them} members that did not stop"
    bands = " and ".join(f"{low} to {high} %" for low, high, _ in reversed(BANDS))
    return f"Median of {members}, and bands from {bands} of them."


def _columns(times: Array, count: int = PANEL_COLUMNS) -> NDArray[np.int64]:
    """Return the index of the first sample of each column of a panel, or all indices if the samples are few."""
    if times.size <= 4 * count:
        return np.arange(times.size)
    column = np.floor(count * (times - times[0]) / (times[-1] - times[0]))
    return np.append(0, np.flatnonzero(np.diff(column)) + 1)


def _seen(times: Array, values: Array, begin: Booleans) -> tuple[Array, Array]:
    """Return the first, least, largest and last sample of each column; a plot cannot resolve more.

    A gap precedes each sample at which a new piece of the curve begins.
    """
    starts, piece = _columns(times), np.cumsum(begin)
    shown = np.arange(times.size)
    if starts.size < times.size:
        column = np.repeat(np.arange(starts.size), np.diff(np.append(starts, times.size)))
        sorted_within = np.lexsort((values, column))
        ends = np.append(starts[1:], times.size) - 1
        shown = np.unique(np.concatenate([starts, ends, sorted_within[starts], sorted_within[ends]]))
    x, y, after = times[shown], values[shown], np.flatnonzero(np.diff(piece[shown])) + 1
    return np.insert(x, after, x[after]), np.insert(y, after, np.nan)
