"""What is read from a motion, against time; of an ensemble the median, and bands that hold most of the members."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.attitude import rotation_angle
from poinsot.mechanics.parameters import came
from poinsot.mechanics.sky import Orbit
from poinsot.motion.trajectory import Trajectory
from poinsot.pictures.labels import BLACK, BLUE, GREEN, VERMILION, bracketed, momentum_unit, rate_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "plot_angular_momentum",
    "plot_difference",
    "plot_drift",
    "plot_euler_angles",
    "plot_quaternions",
    "plot_rates",
    "plot_roll_pitch_yaw",
]

Array = NDArray[np.float64]

COLOURS = (BLACK, BLUE, VERMILION, GREEN, "#CC79A7", "#E69F00", "#56B4E9")
STYLES = ("-", "--", "-.", ":")
BANDS = ((5, 95, 0.15), (25, 75, 0.25))
"""Percentiles between which a band lies, and its opacity."""
FLOOR = 1e-17
"""The smallest value on the log axis of relative drifts, below the rounding of a float."""


def plot_quaternions(motion: Trajectory, title: str = "") -> NDArray[Any]:
    """Draw the four components of q (left) and of Q (right) against time, as in the paper's figures.

    Parameters
    ----------
    motion : Trajectory
        Units on the axes are those of its system. Of an ensemble the median of the members is drawn, with bands
        between the quartiles and between the 5th and the 95th percentile, as in all pictures against time.
    title : str
        Above both panels.

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
        title,
    )


def plot_euler_angles(motion: Trajectory, sequence: str = "313", *, degrees: bool = False, title: str = "") -> Axes:
    """Draw Euler angles, without jumps by whole turns.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    sequence : str
        Any of the 12, as `State.euler` takes it.
    degrees : bool
        On the axis; radians otherwise.
    title : str

    Returns
    -------
    matplotlib Axes
    """
    motion = _checked(motion)
    angles, _ = motion.euler(sequence)
    names = [f"$\\alpha_{i + 1}$ about axis {axis}" for i, axis in enumerate(sequence)]
    return _single(motion, f"Euler angles {'-'.join(sequence)}", _angles(names, angles, degrees), title, degrees)


def plot_roll_pitch_yaw(motion: Trajectory, orbit: Orbit, *, degrees: bool = True, title: str = "") -> Axes:
    """Draw roll, pitch and yaw from the axes of an orbit.

    They turn axes along the transverse direction (forward), opposite to the normal, and down into the body axes: yaw
    about the third, then pitch about the second, then roll about the first.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    orbit : Orbit
        With a frame: radial, transverse, normal.
    degrees : bool
        On the axis; radians otherwise.
    title : str

    Returns
    -------
    matplotlib Axes
    """
    motion = _checked(motion)
    if not isinstance(orbit, Orbit):
        raise TypeError(f"orbit must be an Orbit, but {came(orbit)} came.")
    angles = motion.relative_to(orbit.frame).roll_pitch_yaw
    return _single(
        motion, "from the axes of the orbit", _angles(("roll", "pitch", "yaw"), angles, degrees), title, degrees
    )


def plot_rates(motion: Trajectory, title: str = "") -> NDArray[Any]:
    """Draw the inertial angular velocity along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    motion = _checked(motion)
    unit = rate_label(motion.system.units)
    return _panels(
        motion,
        {
            f"rate along the body axes{unit}": _named(r"$\omega_{}$", motion.omega_body, 1),
            f"rate along the space axes{unit}": _named(r"$\omega_{{s{}}}$", motion.omega_space, 1),
        },
        title,
    )


def plot_angular_momentum(motion: Trajectory, title: str = "") -> NDArray[Any]:
    """Draw the angular momentum along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
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
            f"momentum along the body axes{unit}": _named("$g_{}$", motion.angular_momentum_body, 1),
            f"momentum along the space axes{unit}": _named("$G_{}$", motion.angular_momentum_space, 1),
        },
        title,
    )


def plot_drift(motion: Trajectory, title: str = "") -> Axes:
    """Draw how far the conserved quantities, |q| - 1 among them, are from where they started, on a log axis.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    title : str

    Returns
    -------
    matplotlib Axes
        Values below 1e-17 are drawn there.
    """
    motion = _checked(motion)
    drifts = {"$|q| - 1$": motion.norm_error, **motion.drift}
    symbols = {integral.name: f"${integral.symbol}$" for integral in motion.system.integrals}
    curves = {symbols.get(name, name): np.maximum(np.abs(drift), FLOOR) for name, drift in drifts.items()}
    panel = _single(motion, "relative drift", curves, title)
    panel.set_yscale("log")
    return panel


def plot_difference(motion: Trajectory, other: Trajectory, *, degrees: bool = False, title: str = "") -> Axes:
    """Draw the angle of the rotation from one attitude to another, at the same times, on a log axis.

    Parameters
    ----------
    motion, other : Trajectory
        Each one or an ensemble, at equal times.
    degrees : bool
        On the axis; radians otherwise.
    title : str

    Returns
    -------
    matplotlib Axes
        No angle at all is drawn as the smallest one.

    Raises
    ------
    ValueError
        If their times differ.
    """
    motion, other = _checked(motion), _checked(other, "other")
    if not np.array_equal(motion.times, other.times):
        raise ValueError(
            f"other must have the times of motion, but {_span(other)} and {_span(motion)} came. "
            "Propagate to the same times."
        )
    angle = np.asarray(rotation_angle(motion.quaternion, other.quaternion))
    angle = np.degrees(angle) if degrees else angle
    angle = np.maximum(angle, np.min(angle[angle > 0], initial=np.inf) if np.any(angle > 0) else FLOOR)
    panel = _single(motion, f"difference of attitude{_angle_unit(degrees)}", {"": angle}, title)
    panel.set_yscale("log")
    return panel


def _checked(motion: Any, name: str = "motion") -> Trajectory:
    if not isinstance(motion, Trajectory):
        raise TypeError(f"{name} must be a Trajectory, but {came(motion)} came.")
    return motion


def _span(motion: Trajectory) -> str:
    return f"{motion.times.size} times from {motion.times[0]:.6g} to {motion.times[-1]:.6g}"


def _named(pattern: str, values: Array, first: int) -> dict[str, Array]:
    """Return the components of vectors by name."""
    return {pattern.format(i + first): values[..., i] for i in range(values.shape[-1])}


def _angles(names: Sequence[str], angles: Array, degrees: bool) -> dict[str, Array]:
    unwrapped = np.unwrap(angles, axis=-2)
    return dict(zip(names, np.moveaxis(np.degrees(unwrapped) if degrees else unwrapped, -1, 0), strict=True))


def _angle_unit(degrees: bool) -> str:
    return " [deg]" if degrees else " [rad]"


def _single(
    motion: Trajectory, label: str, curves: Mapping[str, Array], title: str, degrees: bool | None = None
) -> Axes:
    unit = "" if degrees is None else _angle_unit(degrees)
    panel: Axes = _panels(motion, {label + unit: curves}, title)[0]
    return panel


def _panels(motion: Trajectory, panels: Mapping[str, Mapping[str, Array]], title: str) -> NDArray[Any]:
    """Draw panels side by side, each with its label and its named curves."""
    import matplotlib.pyplot as plt

    width = 11 if len(panels) > 1 else 8
    figure, axes = plt.subplots(1, len(panels), figsize=(width, 4), layout="constrained", sharex=True, squeeze=False)
    for panel, (label, curves) in zip(axes[0], panels.items(), strict=True):
        for number, (name, values) in enumerate(curves.items()):
            _draw(panel, motion.times, values, name, number)
        _dress(panel, motion, label, len([name for name in curves if name]))
    if title:
        figure.suptitle(title)
    return np.asarray(axes[0])


def _draw(panel: Axes, times: Array, values: Array, name: str, number: int) -> None:
    style: Any = {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number // len(COLOURS) % len(STYLES)]}
    if values.ndim == 1:
        panel.plot(times, values, linewidth=1.1, label=name, **style)
        return
    known = values[~np.any(np.isnan(values), axis=-1)]
    for low, high, opacity in BANDS:
        edges = np.percentile(known, [low, high], axis=0)
        panel.fill_between(times, *edges, color=style["color"], alpha=opacity, linewidth=0)
    panel.plot(times, np.median(known, axis=0), linewidth=1.1, label=name, **style)


def _dress(panel: Axes, motion: Trajectory, label: str, names: int) -> None:
    panel.set_xlabel(f"time{bracketed(motion.system.units['time'])}")
    panel.set_ylabel(label)
    panel.set_xlim(np.min(motion.times), np.max(motion.times))
    panel.margins(y=0.08)
    panel.grid(alpha=0.25)
    if names:
        panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(names, 4), frameon=False)
