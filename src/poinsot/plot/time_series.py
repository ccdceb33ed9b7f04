"""Time series of a motion; of an ensemble the median, and bands that hold most of the members."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.mechanics import frame
from poinsot.mechanics.attitude import rotation_angle, rotation_matrix
from poinsot.mechanics.calendar import SECONDS
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.euler import SINGULAR_SINE, angles_from_quaternion, axes_of
from poinsot.mechanics.parameters import described
from poinsot.mechanics.shared_orbits import orbits_of, same
from poinsot.plot.labels import (
    BLACK,
    BLUE,
    GREEN,
    VERMILION,
    Unit,
    angle_unit_of,
    bracketed,
    energy_unit,
    momentum_unit,
    rate_unit_of,
    time_label,
    time_unit_of,
)
from poinsot.plot.panels import one_panel, panels
from poinsot.propagation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Pair = Sequence[Axes] | NDArray[Any] | None

__all__ = [
    "angular_momentum",
    "angular_velocity",
    "difference",
    "different_orbits",
    "drift",
    "euler_angles",
    "quaternions",
    "roll_pitch_yaw",
]

Array = NDArray[np.float64]

COLOURS = (BLACK, BLUE, VERMILION, GREEN, "#CC79A7", "#E69F00", "#56B4E9")
STYLES = ("-", "--", "-.", ":")
BANDS = ((5, 95, 0.15), (25, 75, 0.25))
"""Percentiles between which a band lies, and its opacity."""
FLOOR = 0.5 * np.finfo(float).eps
"""The smallest value on the log axis of relative drifts: the rounding of a float."""
PLAIN = (-4, 5)
"""Powers of ten between which numbers on the axes are written without one."""
COLUMNS = 1500
"""Of a panel, in each of which a curve is drawn through its first, least, largest and last sample."""
SAME_INSTANT = 5e-7
"""Seconds: times in files of dates are rounded by less, to a nanosecond or to what SPICE counts."""
WIDE, NARROW = (11.0, 4.0), (8.0, 4.0)
"""Inches of figures with two panels and with one."""
MARKUP = re.compile(r"\\[a-z]+|[${}_^]")
SAMPLE, CHARACTER = 0.4, 0.06
"""Inches of a legend: of a sample of a line, and of a letter."""
TURN = 2 * np.pi
LOCKED = np.radians(85)
"""Of pitch, from which on roll and yaw tell little."""
EDGE = 1e-6
"""Radians beyond half a turn where angles begin anew, or rounding would do it over and over at half a turn."""
BROKEN = 0.4
"""Of a turn: by more an angle jumps from one sample to the next where it begins anew."""


@checked
def quaternions(
    motion: Trajectory, *, axes: Pair = None, time_unit: str | None = None, title: str = ""
) -> NDArray[Any]:
    """Draw the four components of q (left) and of Q (right) against time, as in the paper's figures.

    Parameters
    ----------
    motion : Trajectory
        Units on the axes are those of its system. Of an ensemble the median of the members is drawn, with bands
        between the quartiles and between the 5th and the 95th percentile, as in all pictures against time.
    axes : pair of matplotlib Axes, optional
        Where to draw; default: a new figure.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
        Their figure is `axes[0].figure`, for `savefig`.

    Raises
    ------
    TypeError
        If it is no trajectory.
    """
    motion = _checked(motion)
    momenta = f"conjugate momenta $Q${bracketed(momentum_unit(motion.system.units))}"
    return _panels(
        motion,
        {
            "Euler parameters $q$": _named("$q_{}$", motion.quaternion, 0),
            momenta: _named("$Q_{}$", motion.conjugate_momenta, 0),
        },
        panels(axes, 2, WIDE, title),
        time_unit,
    )


@checked
def euler_angles(
    motion: Trajectory,
    sequence: str = "313",
    *,
    ax: Axes | None = None,
    angle_unit: str = "deg",
    time_unit: str | None = None,
    title: str = "",
) -> Axes:
    """Draw Euler angles, without jumps by whole turns.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble, whose members start within half a turn of each other.
    sequence : str
        Any of the 12, as `State.euler` takes it.
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    angle_unit : {"deg", "rad", "mrad", "arcmin", "arcsec", "rev"}
        Of the axis.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    matplotlib Axes
        With gaps where the angles are not defined, within 1e-6 of their singularity.

    Raises
    ------
    ValueError
        If they are defined nowhere.
    """
    motion = _checked(motion)
    angles = _euler_angles(motion.quaternion, sequence)
    names = [f"$\\alpha_{i + 1}$ about axis {axis}" for i, axis in enumerate(sequence)]
    unit = angle_unit_of(angle_unit)
    label = f"Euler angles {'-'.join(sequence)}{unit.label}"
    return _single(motion, label, _angles(names, angles, unit), one_panel(ax, NARROW, title), time_unit)


@checked
def roll_pitch_yaw(
    motion: Trajectory,
    orbit: Orbit | None = None,
    *,
    ax: Axes | None = None,
    angle_unit: str = "deg",
    time_unit: str | None = None,
    title: str = "",
) -> Axes:
    """Draw roll, pitch and yaw from the axes of an orbit, of one motion within half a turn.

    They turn axes along the transverse direction (forward), opposite to the normal, and down into the body axes: yaw
    about the third, then pitch about the second, then roll about the first. Near a pitch of 90 degrees (gimbal lock,
    shaded beyond 85) roll and yaw turn fast against each other; at it only pitch is drawn.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble, whose members start within half a turn of each other.
    orbit : Orbit, optional
        With a frame: radial, transverse, normal. By default the orbit of the system, if there is one and no other.
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    angle_unit : {"deg", "rad", "mrad", "arcmin", "arcsec", "rev"}
        Of the axis.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    TypeError, ValueError
        If it is no orbit, has no frame, or the system has none or several and none is named.
    """
    motion = _checked(motion)
    if not isinstance(orbit, Orbit | None):
        raise TypeError(f"orbit must be an Orbit, got {described(orbit)}.")
    frame = (_only_orbit(motion) if orbit is None else orbit).frame
    angles = _roll_pitch_yaw(motion.relative_to(frame).quaternion)
    names, unit = ("roll", "pitch", "yaw"), angle_unit_of(angle_unit)
    panel, label = one_panel(ax, NARROW, title), f"attitude relative to the orbital frame{unit.label}"
    if angles.ndim > 2:
        return _single(motion, label, _angles(names, angles, unit), panel, time_unit)
    angles = np.pi + EDGE - np.mod(np.pi + EDGE - angles, TURN)
    before = len(panel.lines)
    _single(motion, label, dict(zip(names, unit.factor * angles.T, strict=True)), panel, time_unit)
    _break(panel.lines[before:], BROKEN * TURN * unit.factor)
    times = time_unit_of(motion.system.units, time_unit).factor * motion.times
    _shade(panel, times, np.abs(angles[:, 1]) > LOCKED, "near gimbal lock")
    return panel


@checked
def angular_velocity(
    motion: Trajectory,
    *,
    axes: Pair = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
    title: str = "",
) -> NDArray[Any]:
    """Draw the inertial angular velocity along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    axes : pair of matplotlib Axes, optional
        Where to draw; default: a new figure.
    rate_unit : str, optional
        "deg/s", "mrad/h", "rpm", ...; an angle alone is per unit of time of the system. Default: "rad".
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    motion = _checked(motion)
    unit = rate_unit_of(motion.system.units, rate_unit)
    body, space = unit.factor * motion.omega_body, unit.factor * motion.omega_space
    return _panels(
        motion,
        {
            f"angular velocity, body axes{unit.label}": _named(r"$\omega_{}$", body, 1),
            f"angular velocity, space axes{unit.label}": _named(r"$\omega_{{s{}}}$", space, 1),
        },
        panels(axes, 2, WIDE, title),
        time_unit,
    )


@checked
def angular_momentum(
    motion: Trajectory, *, axes: Pair = None, time_unit: str | None = None, title: str = ""
) -> NDArray[Any]:
    """Draw the angular momentum along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    axes : pair of matplotlib Axes, optional
        Where to draw; default: a new figure.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    motion = _checked(motion)
    unit = bracketed(momentum_unit(motion.system.units))
    return _panels(
        motion,
        {
            f"angular momentum, body axes{unit}": _named("$g_{}$", motion.angular_momentum_body, 1),
            f"angular momentum, space axes{unit}": _named("$G_{}$", motion.angular_momentum_space, 1),
        },
        panels(axes, 2, WIDE, title),
        time_unit,
    )


@checked
def drift(motion: Trajectory, *, ax: Axes | None = None, time_unit: str | None = None, title: str = "") -> Axes:
    """Plot the drift of the integrals of motion, on a log axis.

    They are the norm of q, q . Q, which is zero, and what the forces conserve, whose value at the start is named.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    matplotlib Axes
        Values below half the rounding of a float, 1.1e-16, are drawn there.
    """
    motion = _checked(motion)
    size = np.nanmax(np.linalg.norm(motion.conjugate_momenta, axis=-1), initial=0.0) or 1.0
    drifts = {"$|q| - 1$": motion.norm_error, r"$q \cdot Q\,/\,|Q|$": motion.tangency_error / size}
    names = _names_of_integrals(motion)
    drifts |= {names[key]: drift for key, drift in motion.drift.items()}
    curves = {
        name: np.where(np.isnan(drift), drift, np.maximum(np.abs(drift), FLOOR)) for name, drift in drifts.items()
    }
    panel = _single(motion, "relative drift", curves, one_panel(ax, NARROW, title), time_unit)
    panel.set_yscale("log")
    panel.set_ylim(bottom=0.8 * FLOOR)
    return panel


@checked
def difference(
    motion: Trajectory,
    other: Trajectory,
    *,
    ax: Axes | None = None,
    angle_unit: str = "deg",
    time_unit: str | None = None,
    title: str = "",
) -> Axes:
    """Draw the angle of the rotation from one attitude to another, at the same times, on a log axis.

    Parameters
    ----------
    motion, other : Trajectory
        Each one or an ensemble, at equal times (in files of dates they are rounded: half a microsecond apart is equal);
        or `motion` has dense output over the times of `other`.
    ax : matplotlib Axes, optional
        Where to draw; default: a new figure.
    angle_unit : {"deg", "rad", "mrad", "arcmin", "arcsec", "rev"}
        Of the axis.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Of the axis, where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    matplotlib Axes
        No angle at all is drawn as the smallest one.

    Raises
    ------
    ValueError
        If their times differ, and there is no dense output.
    """
    motion, other = _checked(motion), _checked(other, "other")
    unit = angle_unit_of(angle_unit)
    angle = np.asarray(rotation_angle(_attitudes_at(motion, other), other.quaternion))
    smallest = np.min(angle, where=angle > 0, initial=np.inf)
    angle = unit.factor * np.where(angle > 0, angle, smallest if np.isfinite(smallest) else FLOOR)
    label = f"difference of attitude{unit.label}"
    panel = _single(other, label, {"": angle}, one_panel(ax, NARROW, title), time_unit)
    panel.set_yscale("log")
    return panel


# ---------------------------------------------------------------------- what is drawn


def _checked(motion: Any, name: str = "motion") -> Trajectory:
    if not isinstance(motion, Trajectory):
        raise TypeError(f"{name} must be a Trajectory, got {described(motion)}.")
    if not motion.times.size:
        raise ValueError(f"{name} must have times to draw, but it has none.")
    if np.all(np.any(np.isnan(motion.quaternion), axis=(-2, -1))):
        raise ValueError(f"{name} must have a member that reached its last time, but none did.")
    return motion


def _span(motion: Trajectory) -> str:
    return f"{motion.times.size} times from {motion.times[0]:.6g} to {motion.times[-1]:.6g}"


def _attitudes_at(motion: Trajectory, other: Trajectory) -> Array:
    """Return the quaternions of a motion at the times of another one."""
    slack = SAME_INSTANT / SECONDS.get(motion.system.units["time"], np.inf)
    if motion.times.shape == other.times.shape and np.all(np.abs(motion.times - other.times) <= slack):
        return motion.quaternion
    if not motion.has_dense_output:
        raise ValueError(
            f"other must have the same times, got {_span(other)} and {_span(motion)}. "
            "Compute both at the same times, or the first with dense output."
        )
    return np.asarray(motion(other.times).quaternion)


def different_orbits(motion: Trajectory) -> list[Orbit]:
    """Return the orbits of a system, each once, in the order of its forces."""
    orbits: list[Orbit] = []
    for orbit in orbits_of(motion.system):
        if not any(same(orbit, known) for known in orbits):
            orbits.append(orbit)
    return orbits


def _only_orbit(motion: Trajectory) -> Orbit:
    """Return the orbit of a system."""
    orbits = different_orbits(motion)
    if len(orbits) != 1:
        raise ValueError(
            f"orbit must be named where the system has not exactly one, but it has {len(orbits) or 'none'}. "
            "Pass roll_pitch_yaw(motion, orbit)."
        )
    return orbits[0]


def _names_of_integrals(motion: Trajectory) -> dict[str, str]:
    """Return what the integrals are called in a legend, of one body with their value at the start."""
    names, units, values = {}, motion.system.units, motion.integrals
    for integral in motion.system.integrals:
        letter, index = integral.symbol[0], integral.symbol[1:]
        symbol = f"{letter}_{{{index}}}" if index.isalnum() else integral.symbol.replace(".", r" \cdot ")
        value = ""
        if motion.quaternion.ndim == 2:
            unit = energy_unit(units) if integral.is_energy else momentum_unit(units)
            value = f" = {values[integral.name][0]:.5g}" + ("" if unit == "1" else bracketed(unit))
        names[integral.name] = f"${symbol}${value}"
    return names


def _named(pattern: str, values: Array, first: int) -> dict[str, Array]:
    """Return the components of vectors by name."""
    return {pattern.format(i + first): values[..., i] for i in range(values.shape[-1])}


def _euler_angles(q: Array, sequence: str) -> Array:
    """Return the angles of unit quaternions, NaN where they are not defined; shape (..., 3)."""
    first, _, third = axes_of(sequence)
    across = np.delete(rotation_matrix(q)[..., first, :], third, axis=-1)  # of the third axis from the first
    defined = np.linalg.norm(across, axis=-1) > 2 * SINGULAR_SINE
    if not np.any(defined):
        angles_from_quaternion(q, sequence)
    angles = np.full((*q.shape[:-1], 3), np.nan)
    angles[defined] = angles_from_quaternion(q[defined], sequence)
    return angles


def _roll_pitch_yaw(q: Array) -> Array:
    """Return the angles of attitudes in the axes of an orbit; roll and yaw are NaN where they are not defined."""
    down = rotation_matrix(quat.product(quat.conjugate(frame.LEVEL), q))
    defined = np.hypot(down[..., 0, 0], down[..., 1, 0]) > 2 * SINGULAR_SINE
    angles = np.full((*q.shape[:-1], 3), np.nan)
    angles[..., 1] = np.arcsin(np.clip(-down[..., 2, 0], -1, 1))
    if np.any(defined):
        angles[defined] = frame.roll_pitch_yaw(q[defined])
    return angles


def _angles(names: Sequence[str], angles: Array, unit: Unit) -> dict[str, Array]:
    return dict(zip(names, unit.factor * _unwrapped(np.moveaxis(angles, -1, 0)), strict=True))


def _unwrapped(angles: Array) -> Array:
    """Return angles (..., n) without jumps by whole turns, also across gaps, from starts near those of the first."""
    known = ~np.isnan(angles)
    begin = np.argmax(known, axis=-1)[..., None]
    latest = np.maximum(np.maximum.accumulate(np.where(known, np.arange(angles.shape[-1]), 0), axis=-1), begin)
    smooth = np.unwrap(np.take_along_axis(angles, latest, axis=-1), axis=-1)
    start = smooth[..., :1]
    start = start - TURN * np.trunc(start / TURN)
    if angles.ndim == 3:
        reference = np.nan_to_num(start[:, np.argmax(np.all(known, axis=(0, 2)))])[:, None]
        start = start - TURN * np.round((start - reference) / TURN)
    return np.asarray(np.where(known, smooth - smooth[..., :1] + start, np.nan))


# ---------------------------------------------------------------------- how it is drawn


def _single(motion: Trajectory, label: str, curves: Mapping[str, Array], panel: Axes, time_unit: str | None) -> Axes:
    _panels(motion, {label: curves}, np.array([panel]), time_unit)
    return panel


def _panels(
    motion: Trajectory, drawn: Mapping[str, Mapping[str, Array]], axes: NDArray[Any], time_unit: str | None
) -> NDArray[Any]:
    """Draw named curves into panels, each with its label, and return the panels."""
    unit = time_unit_of(motion.system.units, time_unit)
    times, label = unit.factor * motion.times, time_label(motion, unit)
    for panel, (quantity, curves) in zip(axes, drawn.items(), strict=True):
        for number, (name, values) in enumerate(curves.items(), len(panel.lines)):
            style = {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number // len(COLOURS) % len(STYLES)]}
            _draw(panel, times, values, label=name, **style)
        panel.set(xlabel=label, ylabel=quantity)
        _dress(panel, times.size)
    members = [values for curves in drawn.values() for values in curves.values() if values.ndim > 1]
    if members:
        axes[0].figure.supxlabel(_bands_in_words(members[0]), fontsize="small", color="#404040")
    return axes


def _draw(panel: Axes, times: Array, values: Array, **style: Any) -> None:
    style |= {"linewidth": 1.1, "marker": "o" if times.size == 1 else None}
    if values.ndim == 1:
        panel.plot(*_seen(times, values), **style)
        return
    known = _complete(values)
    for low, high, opacity in BANDS:
        _draw_band(panel, times, np.percentile(known, [low, high], axis=0), color=style["color"], alpha=opacity)
    panel.plot(*_seen(times, np.median(known, axis=0)), **style)


def _draw_band(panel: Axes, times: Array, edges: Array, **style: Any) -> None:
    """Fill what lies between two edges, shape (2, n)."""
    starts = _columns(times)
    if starts.size < times.size:
        edges = np.stack([np.minimum.reduceat(edges[0], starts), np.maximum.reduceat(edges[1], starts)])
    if times.size == 1:
        panel.vlines(times, *edges, linewidth=8, **style)
    else:
        panel.fill_between(times[starts], *edges, linewidth=0, **style)


def _break(lines: Iterable[Any], jump: float) -> None:
    """Lift the pen where curves jump."""
    for line in lines:
        x, y = (np.asarray(each, dtype=float) for each in line.get_data())
        after = np.flatnonzero(np.abs(np.diff(y)) > jump) + 1
        line.set_data(np.insert(x, after, x[after]), np.insert(y, after, np.nan))


def _shade(panel: Axes, times: Array, where: NDArray[np.bool_], label: str) -> None:
    """Shade the times at which something is so, if there are any."""
    if not np.any(where):
        return
    edges = np.concatenate([times[:1], (times[1:] + times[:-1]) / 2, times[-1:]])
    begin, end = (np.flatnonzero(np.diff([0, *where, 0]) == sign) for sign in (1, -1))
    style: Any = {"linewidth": 0, "color": BLACK, "alpha": 0.12, "label": label}
    bars = list(zip(edges[begin], edges[end] - edges[begin], strict=True))
    panel.broken_barh(bars, (0, 1), transform=panel.get_xaxis_transform(), **style)
    _legend(panel)


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


def _dress(panel: Axes, count: int) -> None:
    panel.margins(x=0 if count > 1 else None, y=0.08)
    panel.ticklabel_format(scilimits=PLAIN, useMathText=True)
    panel.grid(alpha=0.25)
    _legend(panel)


def _legend(panel: Axes) -> None:
    names = panel.get_legend_handles_labels()[1]
    if not names:
        return
    figure: Any = panel.get_figure(root=True)
    width = panel.get_position().width * figure.get_figwidth()
    longest = max(len(MARKUP.sub("", name)) for name in names)
    room = max(1, int(width / (SAMPLE + CHARACTER * longest)))
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(len(names), 4, room), frameon=False)
