"""Indicators of chaos drawn: over a grid as a map, and against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.analysis.chaos import ChaosIndicators
from poinsot.checked import checked
from poinsot.errors import array_of, real_array
from poinsot.mechanics.parameters import described
from poinsot.plot.labels import BLACK, BLUE, GREEN, GREY, VERMILION, bracketed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["chaos", "map"]

Array = NDArray[np.float64]

COLOURS = (BLACK, BLUE, VERMILION, GREEN, "#CC79A7", "#E69F00", "#56B4E9")
TWO_SIDED, ONE_SIDED = "PuOr_r", "cividis"
"""Maps of even lightness that all eyes tell apart: white in the middle, and dark to light."""
REGULAR = 2.0
"""MEGNO of regular motion."""


@checked
def map(  # noqa: A001
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    x_label: str = "",
    y_label: str = "",
    label: str = "",
    *,
    centre: float | None = None,
    limits: tuple[float, float] | None = None,
    title: str = "",
) -> Axes:
    """Draw a map of an indicator over a grid.

    Parameters
    ----------
    x, y : arrays (n,), (m,)
        Where the columns and the rows of the grid are, each strictly monotonic.
    values : array (m, n) or (m n,)
        Row after row, as the members of `np.meshgrid(x, y)`, ravelled, come. NaN is drawn grey.
    x_label, y_label, label : str
        Of the axes and of the values, with their units.
    centre : float, optional
        A value that is drawn white, with purple below and orange above: 2 for MEGNO. Default: dark to light.
    limits : pair of floats, optional
        Values at the ends of the colours. Default: what holds 98 % of the values, and the centre.
    title : str

    Returns
    -------
    matplotlib Axes
    """
    columns, rows = (_monotonic(name, axis) for name, axis in (("x", x), ("y", y)))
    grid = _grid(values, (rows.size, columns.size))
    centre = None if centre is None else float(real_array("centre", centre, ()))
    low, high = _limits(grid, centre) if limits is None else _checked_limits(limits, centre)
    return _drawn(columns, rows, grid, (low, high, centre), (x_label, y_label, label), title)


@checked
def chaos(found: ChaosIndicators, labels: Sequence[str] = (), title: str = "") -> NDArray[Any]:
    """Draw the mean MEGNO (left) and the fast Lyapunov indicator (right) against the time from the start.

    Parameters
    ----------
    found : ChaosIndicators
        Of one body or an ensemble at several times; up to seven members have colours of their own.
    labels : sequence of str
        What the members are called.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    if not isinstance(found, ChaosIndicators):
        raise TypeError(f"found must be ChaosIndicators, got {described(found)}.")
    curves = [np.atleast_2d(part) for part in (found.mean_megno, found.fli)]
    if labels and len(labels) != len(curves[0]):
        raise ValueError(f"labels must name each of {len(curves[0])} members, got {len(labels)}.")
    left, right = panels = _panels(2, (11, 4))
    since = np.broadcast_to(np.abs(found.times - np.reshape(found.start, (-1, 1))), curves[0].shape)
    for panel, values in zip(panels, curves, strict=True):
        for i, (time, curve) in enumerate(zip(since, values, strict=True)):
            panel.plot(time, curve, **_style(i, len(values)), label=labels[i] if labels else None)
        panel.set_xlabel(f"time from the start{bracketed(found.system.units['time'])}")
        panel.grid(alpha=0.25)
        if labels:
            panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(len(labels), 4), frameon=False)
    left.axhline(REGULAR, color=GREY, linestyle="--", linewidth=1.0, zorder=0)
    left.set_ylabel("mean MEGNO")
    right.set_xscale("log")
    right.set_ylabel("fast Lyapunov indicator")
    if title:
        left.figure.suptitle(title)
    return panels


def _style(i: int, members: int) -> dict[str, Any]:
    if members > len(COLOURS):
        return {"color": BLUE, "linewidth": 0.6, "alpha": 0.4}
    return {"color": COLOURS[i], "linewidth": 1.1}


def _panels(count: int, size: tuple[float, float]) -> NDArray[Any]:
    import matplotlib.pyplot as plt

    from poinsot.plot.figure import TextFigure

    options: Any = {"figsize": size, "layout": "constrained", "squeeze": False}
    axes = plt.subplots(1, count, FigureClass=TextFigure, **options)[1]
    return np.asarray(axes[0])


def _drawn(
    x: Array,
    y: Array,
    grid: Array,
    scale: tuple[float, float, float | None],
    labels: tuple[str, str, str],
    title: str,
) -> Axes:
    from matplotlib.colors import Normalize, TwoSlopeNorm

    low, high, centre = scale
    panel: Axes = _panels(1, (7, 5))[0]
    norm = Normalize(low, high) if centre is None else TwoSlopeNorm(centre, low, high)
    colours = ONE_SIDED if centre is None else TWO_SIDED
    mesh = panel.pcolormesh(x, y, grid, norm=norm, cmap=colours, shading="nearest", rasterized=True)
    panel.set_facecolor(GREY)
    panel.set_xlabel(labels[0])
    panel.set_ylabel(labels[1])
    panel.set_title(title)
    bar = panel.figure.colorbar(mesh, ax=panel, label=labels[2], extend=_beyond(grid, low, high))
    if centre is not None:
        bar.set_ticks(sorted({low, centre, high, 0.5 * (low + centre), 0.5 * (centre + high)}))
    return panel


def _beyond(grid: Array, low: float, high: float) -> str:
    below, above = bool(np.any(grid < low)), bool(np.any(grid > high))
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")


def _limits(grid: Array, centre: float | None) -> tuple[float, float]:
    """Return what holds nearly all of the values and has the centre inside."""
    known = grid[np.isfinite(grid)]
    low, high = (float(end) for end in np.percentile(known, [1, 99]))
    middle = low if centre is None else centre
    room = 0.1 * max(high - low, abs(middle), 1e-300)
    return (low, max(high, low + room)) if centre is None else (min(low, centre - room), max(high, centre + room))


def _checked_limits(limits: tuple[float, float], centre: float | None) -> tuple[float, float]:
    low, high = real_array("limits", limits, (2,))
    inside = low < high if centre is None else low < centre < high
    if not inside:
        around = "" if centre is None else f" around {centre:g}"
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
