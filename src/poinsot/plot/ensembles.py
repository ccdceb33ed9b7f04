"""Plots of ensembles: maps over a grid, histograms, and chaos indicators against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from poinsot.analysis.chaos import ChaosIndicators
from poinsot.errors import array_of, real_array
from poinsot.plot.labels import (
    BLACK,
    BLUE,
    COLOURS,
    GREY,
    VERMILION,
    angle_unit_of,
    momentum_label,
    one_rotation,
    rate_unit_of,
    time_unit_of,
)
from poinsot.plot.panels import Axes, Pair, PanelOptions, count_degrees, dress, one_panel, panels, plot
from poinsot.printable import described, quoted
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array

__all__ = ["QUANTITIES", "chaos", "histogram", "map"]

SHADES = 512
TWO_SIDED, ONE_SIDED = "PuOr_r", "cividis"
"""Colour maps of uniform lightness that colour-blind readers can distinguish: white in the middle; dark to light."""
REGULAR_MEGNO = 2.0
"""MEGNO of regular motion."""


BINS = 80

QUANTITIES = {
    "effective_rate": "effective angular velocity 2T/G",
    "rate": "angular velocity",
    "angular_momentum": "angular momentum",
    "turn": "turn of the angular momentum since the first time",
}
"""Quantities with their labels."""


@plot
def map(  # noqa: A001
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    x_label: str = "",
    y_label: str = "",
    label: str = "",
    *,
    center: float | None = None,
    limits: tuple[float, float] | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw a map of an indicator on a grid.

    Parameters
    ----------
    x, y : arrays (n,), (m,)
        Coordinates of the columns and rows of the grid, each strictly monotonic.
    values : array (m, n) or (m n,)
        Values row by row, in the order of the ravelled `np.meshgrid(x, y)`. NaN is drawn grey.
    x_label, y_label, label : str
        Labels of the axes and of the values, with units.
    center : float, optional
        Value that is drawn white, with purple below and orange above on one scale, such as 2 for MEGNO. Default:
        colours from dark to light.
    limits : pair of floats, optional
        Values at the ends of the colour scale. Default: limits that contain 98 % of the values, and the center.
    {options}

    Examples
    --------
    >>> x, y = np.linspace(0, 2, 5), np.linspace(0, 1, 4)
    >>> pt.plot.map(x, y, np.hypot(*np.meshgrid(x, y)), "x [m]", "y [m]", "distance [m]", center=1.0).get_xlabel()
    'x [m]'
    """
    from matplotlib.colors import Normalize

    columns, rows = (_monotonic(name, axis) for name, axis in (("x", x), ("y", y)))
    grid = _grid(values, (rows.size, columns.size))
    center = None if center is None else float(real_array("center", center, ()))
    low, high = _limits(grid, center) if limits is None else _checked_limits(limits, center)
    panel = one_panel((7, 5), **options)
    colours = ONE_SIDED if center is None else _around(center, low, high)
    norm = Normalize(low, high)
    mesh = panel.pcolormesh(columns, rows, grid, norm=norm, cmap=colours, shading="nearest", rasterized=True)
    panel.set_facecolor(GREY)
    panel.set(xlabel=x_label, ylabel=y_label)
    for axis in (panel.xaxis, panel.yaxis):
        count_degrees(axis, axis.get_label_text())
    beyond = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}
    extend = beyond[bool(np.any(grid < low)), bool(np.any(grid > high))]
    panel.figure.colorbar(mesh, ax=panel, label=label, extend=extend)
    return panel


@plot
def chaos(
    found: ChaosIndicators,
    labels: Sequence[str] = (),
    *,
    axes: Pair = None,
    time_unit: str | None = None,
    title: str = "",
) -> NDArray[Any]:
    """Draw the mean MEGNO (left) and the fast Lyapunov indicator (right) against the time since the initial state.

    Parameters
    ----------
    found : ChaosIndicators
        Indicators of one body or of an ensemble at several times. Up to seven members are drawn in different colours.
    labels : sequence of str
        Names of the members.
    {options}

    Examples
    --------
    >>> found = pt.analysis.chaos_indicators(motion.system, motion.initial, motion.times[1:])
    >>> pt.plot.chaos(found, ["free"], time_unit="min")[0].get_xlabel()
    'time from the start [min]'
    """
    megno, fli = np.atleast_2d(found.mean_megno), np.atleast_2d(found.fli)
    if labels and len(labels) != len(megno):
        raise ValueError(f"labels must name each of {len(megno)} members, got {len(labels)}.")
    left, right = drawn = panels(axes, 2, (11, 4), title)
    since = np.broadcast_to(np.abs(found.times - np.reshape(found.start, (-1, 1))), megno.shape)
    unit = time_unit_of(found.system.units, time_unit, since)
    few = len(megno) <= len(COLOURS)
    style: Any = {"linewidth": 1.1} if few else {"linewidth": 0.6, "alpha": 0.4}
    for panel, quantity, values in ((left, "mean MEGNO", megno), (right, "fast Lyapunov indicator", fli)):
        panel.set_prop_cycle(color=COLOURS if few else [BLUE])
        panel.plot(unit.factor * since.T, values.T, label=list(labels) or None, **style)
        dress(panel, f"time from the start{unit.label}", quantity)
    left.axhline(REGULAR_MEGNO, color=GREY, linestyle="--", linewidth=1.0, zorder=0)
    right.set_xscale("log")
    return drawn


@plot
def histogram(
    ensemble: Trajectory,
    quantity: str = "effective_rate",
    *,
    angle_unit: str | None = None,
    rate_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw a histogram of a quantity of the members at the last time, with its 5th and 95th percentile.

    The plot shows the medians at the first and at the last time. Members that stopped earlier are omitted.

    Parameters
    ----------
    ensemble : Trajectory
        Ensemble of one body. From a store, only the first and the last time are read.
    quantity : {"effective_rate", "rate", "angular_momentum", "turn"}
        "effective_rate": 2T/G with the kinetic energy T and the magnitude G of the angular momentum. "rate": magnitude
        of the angular velocity. "angular_momentum": G. "turn": angle between the angular momenta at the first and the
        last time.
    {options}

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (0.1, 0, 2), 100))
    >>> tops = pt.propagate(pt.System(body, pt.UniformGravity(0.5, (1, 0, 0))), start, [0, 10])
    >>> pt.plot.histogram(tops, "turn").get_ylabel()
    'members'
    """
    motion = one_rotation(ensemble, "ensemble")
    if not motion.is_ensemble:
        raise ValueError("ensemble must have members, got the motion of one body.")
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity must be one of {', '.join(QUANTITIES)}, got {quoted(quantity)}.")
    first, last = motion.isel(time=[0]), motion.isel(time=[motion.times.size - 1])
    before, after = _values(quantity, first, first), _values(quantity, last, first)
    after = after[np.isfinite(after)]
    if not after.size:
        raise ValueError("ensemble must have members at the last time, got none.")
    factor, written = 1.0, momentum_label(motion.system.units)
    if quantity != "angular_momentum":
        unit = angle_unit_of(angle_unit, after) if quantity == "turn" else None
        unit = unit or rate_unit_of(motion.system.units, rate_unit, after)
        factor, written = unit.factor, unit.label
    panel = one_panel((6.4, 3.6), **options)
    panel.hist(factor * after, bins=BINS, color=BLUE, alpha=0.8)
    for level in (5, 95):
        panel.axvline(factor * float(np.percentile(after, level)), color=BLACK, lw=0.8, ls=":")
    panel.axvline(factor * float(np.median(after)), color=BLACK, lw=1.2, label="median, between 5 and 95 %")
    if quantity != "turn":
        start = factor * float(np.nanmedian(before))
        panel.axvline(start, color=VERMILION, lw=1.2, ls="--", label="median at the first time")
    dress(panel, f"{QUANTITIES[quantity]}{written}", "members")
    return panel


def _values(quantity: str, motion: Trajectory, first: Trajectory) -> Array:
    """Return a quantity of each member at the single time of a motion."""
    if quantity == "rate":
        return np.asarray(np.linalg.norm(motion.omega_body, axis=-1)[:, 0])
    if quantity == "turn":
        one, other = (each.angular_momentum_space[:, 0] for each in (first, motion))
        across = np.linalg.norm(np.cross(one, other), axis=-1)
        return np.asarray(np.arctan2(across, np.vecdot(one, other)))
    size = np.linalg.norm(motion.angular_momentum_body, axis=-1)[:, 0]
    return np.asarray(size if quantity == "angular_momentum" else 2 * motion.kinetic_energy[:, 0] / size)


def _around(center: float, low: float, high: float) -> Any:
    """Return colours from one value to another on a straight scale, white at the center."""
    import matplotlib as mpl
    from matplotlib.colors import ListedColormap

    both = mpl.colormaps[TWO_SIDED].resampled(SHADES)
    reach = max(center - low, high - center)
    return ListedColormap(both(0.5 + 0.5 * (np.linspace(low, high, SHADES) - center) / reach))


def _limits(grid: Array, center: float | None) -> tuple[float, float]:
    """Return limits that contain nearly all of the values, with the center inside."""
    known = grid[np.isfinite(grid)]
    low, high = (float(end) for end in np.percentile(known, [1, 99]))
    middle = low if center is None else center
    room = 0.1 * max(high - low, abs(middle), 1e-300)
    return (low, max(high, low + room)) if center is None else (min(low, center - room), max(high, center + room))


def _checked_limits(limits: tuple[float, float], center: float | None) -> tuple[float, float]:
    low, high = real_array("limits", limits, (2,))
    inside = low < high if center is None else low < center < high
    if not inside:
        around = "" if center is None else f" around {center:g}"
        raise ValueError(f"limits must rise{around}, got ({low:g}, {high:g}).")
    return float(low), float(high)


def _monotonic(name: str, axis: ArrayLike) -> Array:
    found = real_array(name, axis, (None,))
    steps = np.diff(found)
    if found.size < 2 or np.any(steps * steps[0] <= 0):
        raise ValueError(f"{name} must be strictly monotonic with two values at least, got {found}.")
    return found


def _grid(values: ArrayLike, shape: tuple[int, int]) -> Array:
    found = array_of("values", values)
    if found.dtype.kind not in "iuf":
        raise TypeError(f"values must be real numbers, got {described(values)}.")
    if found.shape not in (shape, (shape[0] * shape[1],)):
        raise ValueError(
            f"values must have shape {shape} or ({shape[0] * shape[1]},), got shape {found.shape}. "
            "Take one time, as in mean_megno[:, -1]."
        )
    if not np.any(np.isfinite(found)):
        raise ValueError("values must have something to draw, but all are NaN.")
    return np.reshape(found.astype(float), shape)
