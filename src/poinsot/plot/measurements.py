"""Plots of readings: against time, folded with a period, and over the phases of two periods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from poinsot.errors import real_array, refuse_nonpositive
from poinsot.observables.readings import Readings
from poinsot.plot.curves import STYLES, bands_in_words, covered, draw_curve, scale, within_window
from poinsot.plot.labels import COLOURS, GREY, Unit, bracketed, in_words, time_unit_of
from poinsot.plot.panels import Axes, PanelOptions, dress, one_panel, plot
from poinsot.plot.time_axis import axis_of
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar

__all__ = ["phase_plane", "phased", "readings"]

MAGNITUDE = "mag"
"""Unit of readings that are drawn upside down, because a brighter body has a smaller magnitude."""
POINT_MARGIN = 0.02
"""Margin on either side of points, as fraction of the time span."""
GAP = 10.0
"""Interval between readings, in median intervals, beyond which a curve is interrupted."""
MAX_NAMED = 12
"""Largest number of curves with names in the legend."""
SIZE, SQUARE = (8.0, 4.0), (6.6, 5.4)
"""Inches of figures."""
POINT, SMALL_POINT, FEW_POINTS = 3.5, 2.0, 200
"""Sizes of points, and the number of points of one curve up to which they are large."""
MAX_POINTS = 1000
"""Largest number of readings of one curve that are drawn as points by default."""
CELLS = 60
"""Number of cells of the model along each side of a phase plane."""
BRIGHTNESS = "cividis"
"""Colour map of uniform lightness that colour-blind readers can distinguish, from dark to bright."""

SeveralReadings = Readings | Sequence[Readings]


@plot
def readings(
    readings: SeveralReadings,
    *,
    points: bool | None = None,
    time_unit: str | None = None,
    window: ArrayLike | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw readings against time. Magnitudes are upside down, so that a brighter body is higher.

    Parameters
    ----------
    readings : Readings, or sequence of these
        Readings in one unit, such as the light curves of several nights. Components of vectors and quaternions are
        separate curves. Error bars show the standard deviations `sigma`. Readings of an ensemble are drawn as the
        median of the members with bands between the quartiles and between the 5th and the 95th percentile.
    points : bool, optional
        True to draw points, False to draw curves, which are interrupted where readings are more than ten median
        intervals apart. Default: points for at most 1000 readings with `sigma`, and curves for other readings.
    {options}

    Raises
    ------
    TypeError, ValueError
        If readings contain no values, or differ in their units.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return pt.functions.norm(instant.omega_body)
    >>> pt.plot.readings(pt.observe(motion, Rate()), time_unit="s").get_xlabel()
    'time [s]'
    """
    found = _listed("readings", readings)
    _common_unit(found)
    calendar, times = _calendar(found), np.sort(np.concatenate([each.times for each in found]))
    times = times[within_window(times, calendar, window, "readings")]
    axis = axis_of(times, _time_units(found), calendar, time_unit)
    panel = one_panel(SIZE, **options)
    curves = list(_curves(found))
    covers = (
        covered([curve.values for curve in curves], slice(None), log=False) if len(found) == 1 else [0] * len(curves)
    )
    for number, (curve, below) in enumerate(zip(curves, covers, strict=True)):
        shown = (curve.times >= times[0]) & (curve.times <= times[-1])
        look = _look(number, curves) | {"linestyle": STYLES[below % len(STYLES)]}
        _draw(panel, axis.places(curve.times[shown]), curve.only(shown), points, **look)
    _finish(panel, axis.places(times), found)
    axis.mark(panel)
    dress(panel, axis.label, _label(found))
    if members := [curve.values for curve in curves if curve.values.ndim > 1]:
        panel.figure.supxlabel(bands_in_words(members[0]), fontsize="small", color="#404040")
    return panel


@plot
def phased(
    readings: SeveralReadings,
    period: float,
    model: SeveralReadings | None = None,
    *,
    epoch: float | str = 0.0,
    points: bool | None = True,
    time_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw readings folded with a period, against the phase (t - epoch) / period modulo 1.

    Parameters
    ----------
    readings : Readings, or sequence of these
        Readings in one unit. Magnitudes are upside down.
    period : float
        Period, in the unit of the times; positive.
    model : Readings, or sequence of these, optional
        Computed readings, from `observe`, which are drawn as a grey curve. A model that is not periodic with the
        period is drawn as a curve for each cycle.
    epoch : float or str
        Time of phase 0, or a date with its time scale where the readings have a calendar.
    points : bool, optional
        True to draw points, False to draw a curve for each cycle. None draws points for readings with `sigma` alone.
    {options}

    Raises
    ------
    TypeError, ValueError
        If readings contain no values or differ in their units, or the period is not positive.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return instant.omega_body[0]
    >>> pt.plot.phased(pt.observe(motion, Rate()), 12.5, time_unit="s").get_xlabel()
    'phase, period 12.5 s'
    """
    found, computed = _listed("readings", readings), [] if model is None else _listed("model", model)
    _common_unit([*found, *computed])
    length, start = _positive("period", period), _time_of("epoch", epoch, _calendar(found))
    unit = time_unit_of(_time_units(found), time_unit, [0.0, length])
    panel = one_panel(SIZE, **options)
    curves, clock = list(_curves(found)), (start, length)
    for number, curve in enumerate(_curves(computed)):
        _draw_folded(panel, curve, clock, points=False, color=GREY, label=None if number else "model")
    for number, curve in enumerate(curves):
        _draw_folded(panel, curve, clock, points=points, **_look(number, curves))
    _finish(panel, np.array([0.0, 1.0]), found)
    panel.set_xlim(0, 1)
    dress(panel, f"phase, period {_in_unit(length, unit)}", _label(found))
    return panel


@plot
def phase_plane(
    readings: SeveralReadings,
    periods: ArrayLike,
    model: SeveralReadings | None = None,
    *,
    epoch: float | str = 0.0,
    time_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    r"""Draw readings of a tumbling body over the phases of its two periods, with colours for their values.

    The brightness of a body that rotates freely is a function of the two phases (t - epoch) / P modulo 1 as long as
    the directions to the Sun and to the observer are constant (Pravec et al. 2005, Icarus 173, 108).

    Parameters
    ----------
    readings : Readings, or sequence of these
        Readings of one number, in one unit. Brighter is lighter; the scale of magnitudes is upside down.
    periods : array (2,)
        Period P_psi of the rotation about the axis of the body and period P_phi of its precession about the angular
        momentum, in the unit of the times; positive.
    model : Readings, or sequence of these, optional
        Computed readings at many times, from `observe`, whose means in 60 x 60 cells are the background.
    epoch : float or str
        Time of both phases 0, or a date with its time scale where the readings have a calendar.
    {options}

    Raises
    ------
    TypeError, ValueError
        If readings contain no values, are vectors or an ensemble, or differ in their units.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return instant.omega_body[0]
    >>> pt.plot.phase_plane(pt.observe(motion, Rate()), (12.5, 7.0), time_unit="s").get_xlabel()
    'phase of rotation, $P_\\psi$ = 12.5 s'
    """
    found, computed = _listed("readings", readings), [] if model is None else _listed("model", model)
    unit_of_values = _common_unit([*found, *computed])
    lengths = real_array("periods", periods, (2,))
    refuse_nonpositive("periods", lengths)
    start = _time_of("epoch", epoch, _calendar(found))
    times, values = _one_number("readings", found)
    panel = one_panel(SQUARE, **options)
    colours = BRIGHTNESS + "_r" * (unit_of_values == MAGNITUDE)
    background = _means_in_cells(*_one_number("model", computed), start, lengths) if computed else np.zeros(0)
    both = np.concatenate([values, background.ravel()])
    look: Any = {"cmap": colours, "vmin": np.nanmin(both), "vmax": np.nanmax(both)}
    if computed:
        panel.imshow(background.T, extent=(0, 1, 0, 1), origin="lower", aspect="auto", interpolation="nearest", **look)
    edge: Any = {"edgecolors": "white", "linewidths": 0.4} if computed else {}
    size = (2 * POINT if computed or times.size <= FEW_POINTS else 2 * SMALL_POINT) ** 2
    x, y = _phases(times, start, lengths).T
    drawn = panel.scatter(x, y, size, values, **look, **edge)
    bar = panel.figure.colorbar(drawn, ax=panel, label=_label(found))
    if unit_of_values == MAGNITUDE:
        bar.ax.invert_yaxis()
    panel.set(xlim=(0, 1), ylim=(0, 1))
    unit = time_unit_of(_time_units(found), time_unit, [0.0, *lengths])
    psi, phi = (_in_unit(float(length), unit) for length in lengths)
    dress(panel, rf"phase of rotation, $P_\psi$ = {psi}", rf"phase of precession, $P_\phi$ = {phi}")
    return panel


# ---------------------------------------------------------------------- readings


def _listed(name: str, given: SeveralReadings) -> list[Readings]:
    """Return readings as a list; raise an error if there are none, or if readings contain no values."""
    found = [given] if isinstance(given, Readings) else list(given)
    if not found:
        raise ValueError(f"{name} must contain readings to draw, got none.")
    for each in found:
        if each.values is None or not np.any(np.isfinite(each.values)):
            raise ValueError(f"{name} must contain values to draw, got {quoted(each.name)} without.")
    return found


def _common_unit(found: Sequence[Readings]) -> str:
    """Return the unit of all readings; raise an error if their units or their units of time differ."""
    for attribute in ("units", "time_units"):
        units = list(dict.fromkeys(each.attributes.get(attribute, "") for each in found))
        if len(units) > 1:
            raise ValueError(
                f"readings must have equal {attribute}, got {quoted(units[0])} and {quoted(units[1])}. "
                "Draw them in separate panels."
            )
    return found[0].attributes.get("units", "")


def _time_units(found: Sequence[Readings]) -> dict[str, str]:
    return {"time": found[0].attributes.get("time_units", "1")}


def _calendar(found: Sequence[Readings]) -> Calendar | None:
    """Return the calendar of the first readings that have one."""
    return next((each.calendar for each in found if each.calendar is not None), None)


def _label(found: Sequence[Readings]) -> str:
    """Return the label of an axis of values: the observable, the axes of its components, and the unit."""
    unit, frame = _common_unit(found), found[0].attributes.get("frame", "")
    kinds = dict.fromkeys(in_words(each.observable.definition[0]) for each in found)
    words = "magnitude" if unit == MAGNITUDE else ", ".join(kinds)
    return f"{words}{frame and f', {frame} axes'}{unit and bracketed(unit)}"


@dataclass(frozen=True)
class _DrawnCurve:
    """One component of readings, shape (n,), or (members, n) for an ensemble, in the order of the times."""

    name: str
    times: Array
    values: Array
    sigma: Array | None

    def only(self, shown: NDArray[np.bool_] | NDArray[np.int64]) -> _DrawnCurve:
        """Return a selection of the readings."""
        sigma = None if self.sigma is None else self.sigma[..., shown]
        return _DrawnCurve(self.name, self.times[shown], self.values[..., shown], sigma)


def _curves(found: Sequence[Readings]) -> Iterator[_DrawnCurve]:
    """Yield the components of readings with their names in the legend."""
    named = [in_words(each.name) for each in found]
    numbered = len(set(named)) < len(named)
    for number, each in enumerate(found):
        values = np.asarray(each.values)
        of_components = each.sigma is not None and each.observable.errors == each.observable.components
        sigma = np.broadcast_to(np.asarray(each.sigma), values.shape) if of_components else None
        name = "" if len(found) == 1 else f"{named[number]} {number + 1}" if numbered else named[number]
        order, components = np.argsort(each.times, kind="stable"), each.observable.components
        for i, component in enumerate(components or ("",)):
            own = (..., i) if components else ...
            words = f"{name} {component.replace('_', ' ')}".strip()
            yield _DrawnCurve(words, each.times, values[own], None if sigma is None else sigma[own]).only(order)


def _one_number(name: str, found: Sequence[Readings]) -> tuple[Array, Array]:
    """Return all times and values of readings of one number of one body."""
    if any(curve.values.ndim > 1 for curve in _curves(found)):
        raise ValueError(f"{name} must be of one body, got an ensemble.")
    if components := next((each.observable.components for each in found if each.observable.components), ()):
        raise ValueError(f"{name} must be of one number, got {len(components)} components: {', '.join(components)}.")
    return np.concatenate([each.times for each in found]), np.concatenate([np.asarray(each.values) for each in found])


# ---------------------------------------------------------------------- phases


def _positive(name: str, value: float) -> float:
    number = float(real_array(name, value, ()))
    refuse_nonpositive(name, number)
    return number


def _time_of(name: str, value: float | str, calendar: Calendar | None) -> float:
    """Return a time that is given as a number or, with a calendar, as a date."""
    if isinstance(value, str) and calendar is None:
        raise ValueError(f"{name} must be a number where the readings have no calendar, got {quoted(value)}.")
    return float(real_array(name, value if calendar is None else calendar.time(value), ()))


def _phases(times: Array, epoch: float, periods: ArrayLike) -> Array:
    """Return the phases of times for several periods, between 0 and 1; shape (n, periods)."""
    return np.asarray(np.mod((times[:, None] - epoch) / np.asarray(periods), 1.0))


def _means_in_cells(times: Array, values: Array, epoch: float, periods: Array) -> Array:
    """Return the means of values in the cells of the phase plane, NaN in cells without values; shape (n, n)."""
    known = np.isfinite(values)
    columns, rows = np.floor(CELLS * _phases(times[known], epoch, periods)).astype(int).T
    cells = np.minimum(columns, CELLS - 1) * CELLS + np.minimum(rows, CELLS - 1)
    counts = np.bincount(cells, minlength=CELLS**2)
    sums = np.bincount(cells, values[known], CELLS**2)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan).reshape(CELLS, CELLS)


def _in_unit(length: float, unit: Unit) -> str:
    """Return a period with its unit: "5.27025547 h"."""
    return f"{unit.factor * length:.8g}" + ("" if unit.written == "1" else f" {unit.written}")


# ---------------------------------------------------------------------- drawing


def _look(number: int, curves: Sequence[_DrawnCurve]) -> dict[str, Any]:
    """Return the colour of a curve, and its name if the curves are few."""
    label = curves[number].name if len(curves) <= MAX_NAMED else None
    return {"color": COLOURS[number % len(COLOURS)], "label": label}


def _draw_folded(panel: Axes, curve: _DrawnCurve, clock: tuple[float, float], points: bool | None, **look: Any) -> None:
    """Draw a curve over the phase, in a piece for each cycle."""
    phase = _phases(curve.times, *clock)[:, 0]
    _draw(panel, phase, curve, points, np.diff(phase, prepend=0.0) < 0, **look)


def _draw(
    panel: Axes,
    places: Array,
    curve: _DrawnCurve,
    points: bool | None,
    begin: NDArray[np.bool_] | None = None,
    **look: Any,
) -> None:
    """Draw a curve, or points with error bars, at places on the horizontal axis."""
    if points is None:
        points = curve.sigma is not None and curve.times.size <= MAX_POINTS
    if curve.values.ndim == 1 and points:
        size = POINT if places.size <= FEW_POINTS else SMALL_POINT
        look |= {"fmt": "o", "markersize": size, "elinewidth": 0.8, "linestyle": "none"}
        panel.errorbar(places, curve.values, curve.sigma, **look)
        return
    steps = np.diff(curve.times, prepend=curve.times[:1])
    gaps = steps > GAP * np.median(steps[1:]) if steps.size > 1 else np.zeros(steps.size, dtype=bool)
    draw_curve(panel, places, curve.values, gaps if begin is None else gaps | begin, **look)


def _finish(panel: Axes, places: Array, found: Sequence[Readings]) -> None:
    """Scale a panel; magnitudes are upside down."""
    scale(panel, places, log=False)
    if panel.containers:
        panel.margins(x=POINT_MARGIN)
    if _common_unit(found) == MAGNITUDE and not panel.yaxis_inverted():
        panel.invert_yaxis()
