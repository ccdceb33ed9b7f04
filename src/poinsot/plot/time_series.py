"""Time series of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.mechanics import frame
from poinsot.mechanics.attitude import rotation_angle, rotation_matrix
from poinsot.mechanics.calendar import SECONDS
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.euler import SINGULAR_SINE, angles_from_quaternion, axes_of
from poinsot.mechanics.parameters import same
from poinsot.mechanics.state import State
from poinsot.mechanics.units import DerivedUnits
from poinsot.plot.curves import against_time, lift_pen, reached, shade
from poinsot.plot.labels import (
    Unit,
    angle_unit_of,
    bracketed,
    momentum_label,
    one_rotation,
    rate_unit_of,
    time_unit_of,
)
from poinsot.plot.panels import Pair, plot
from poinsot.propagation.dataset import components
from poinsot.propagation.pair_trajectory import PairTrajectory
from poinsot.propagation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "angular_momentum",
    "angular_velocity",
    "difference",
    "different_orbits",
    "distance",
    "drift",
    "euler_angles",
    "part_variables",
    "quaternions",
    "roll_pitch_yaw",
    "torques",
]

Array = NDArray[np.float64]

FLOOR = 0.5 * np.finfo(float).eps
"""The smallest value on the log axis of relative drifts: the rounding of a float."""
SAME_INSTANT = 5e-7
"""Seconds: times in files of dates are rounded by less, to a nanosecond or to what SPICE counts."""
TURN = 2 * np.pi
LOCKED = np.radians(85)
"""Of pitch, from which on roll and yaw tell little."""
EDGE = 1e-6
"""Radians beyond half a turn where angles begin anew, or rounding would do it over and over at half a turn."""
BROKEN = 0.4
"""Of a turn: by more an angle jumps from one sample to the next where it begins anew."""


@plot
def quaternions(
    motion: Trajectory, *, axes: Pair = None, time_unit: str | None = None, title: str = ""
) -> NDArray[Any]:
    """Draw the four components of q (left) and of Q (right) against time, as in the paper's figures.

    Parameters
    ----------
    motion : Trajectory
        Of an ensemble the median of the members is drawn, with bands between the quartiles and between the 5th and the
        95th percentile, as in all plots against time.
    {options}

    Returns
    -------
    array (2,) of matplotlib Axes
        Their figure is `axes[0].figure`, for `savefig`. Units are those of the system.

    Examples
    --------
    >>> left, right = pt.plot.quaternions(motion, time_unit="min")
    >>> left.get_xlabel()
    'time [min]'
    """
    momenta = f"conjugate momenta $Q${momentum_label(one_rotation(motion).system.units)}"
    curves = {
        "Euler parameters $q$": _named("$q_{}$", motion.quaternion, 0),
        momenta: _named("$Q_{}$", motion.conjugate_momenta, 0),
    }
    return against_time(reached(motion), curves, axes, time_unit, title)


@plot
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
    {options}

    Returns
    -------
    matplotlib Axes
        With gaps where the angles are not defined, within 1e-6 of their singularity.

    Raises
    ------
    ValueError
        If they are defined nowhere.

    Examples
    --------
    >>> pt.plot.euler_angles(motion, "321", angle_unit="mrad").get_ylabel()
    'Euler angles 3-2-1 [mrad]'
    """
    angles, unit = _euler_angles(reached(one_rotation(motion)).quaternion, sequence), angle_unit_of(angle_unit)
    names = [f"$\\alpha_{i + 1}$ about axis {axis}" for i, axis in enumerate(sequence)]
    label = f"Euler angles {'-'.join(sequence)}{unit.label}"
    panel: Axes = against_time(motion, {label: _angles(names, angles, unit)}, ax, time_unit, title)[0]
    return panel


@plot
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
    {options}

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    TypeError, ValueError
        If it is no orbit, has no frame, or the system has none or several and none is named.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1)  # km, s
    >>> pt.plot.roll_pitch_yaw(motion, orbit).get_ylabel()
    'attitude relative to the orbital frame [deg]'
    """
    orbit = _only_orbit(one_rotation(motion)) if orbit is None else orbit
    relative, unit = reached(one_rotation(motion)).relative_to(orbit.frame), angle_unit_of(angle_unit)
    angles = _roll_pitch_yaw(relative.quaternion)
    names, label = ("roll", "pitch", "yaw"), f"attitude relative to the orbital frame{unit.label}"
    single = angles.ndim == 2
    if single:
        angles = np.pi + EDGE - np.mod(np.pi + EDGE - angles, TURN)
    curves = dict(zip(names, unit.factor * angles.T, strict=True)) if single else _angles(names, angles, unit)
    panel: Axes = against_time(motion, {label: curves}, ax, time_unit, title)[0]
    if single:
        lift_pen(panel.lines[-3:], BROKEN * TURN * unit.factor)
        times = time_unit_of(motion.system.units, time_unit).factor * motion.times
        shade(panel, times, np.abs(angles[:, 1]) > LOCKED, "near gimbal lock")
    return panel


@plot
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
        One, or an ensemble. Of two bodies the primary's is left and the secondary's right, each along its body axes.
    {options}

    Returns
    -------
    array (2,) of matplotlib Axes

    Examples
    --------
    >>> pt.plot.angular_velocity(motion, rate_unit="deg/h")[0].get_ylabel()
    'angular velocity, body axes [deg h⁻¹]'
    """
    unit, bodies = rate_unit_of(motion.system.units, rate_unit), motion.of_bodies
    curves = {
        f"angular velocity{_of(body) or ', body axes'}{unit.label}": _named(
            r"$\omega_{}$", unit.factor * each.omega_body, 1
        )
        for body, each in bodies.items()
    }
    if len(bodies) == 1:
        in_space = _named(r"$\omega_{{s{}}}$", unit.factor * motion.omega_space, 1)
        curves[f"angular velocity, space axes{unit.label}"] = in_space
    return against_time(reached(motion), curves, axes, time_unit, title)


@plot
def angular_momentum(
    motion: Trajectory, *, axes: Pair = None, time_unit: str | None = None, title: str = ""
) -> NDArray[Any]:
    """Draw the angular momentum along the body axes (left) and along the space axes (right), that of parts included.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    {options}

    Returns
    -------
    array (2,) of matplotlib Axes

    Examples
    --------
    >>> [panel.get_ylabel() for panel in pt.plot.angular_momentum(motion)]
    ['angular momentum, body axes [kg m² s⁻¹]', 'angular momentum, space axes [kg m² s⁻¹]']
    """
    unit = momentum_label(one_rotation(motion).system.units)
    curves = {
        f"angular momentum, body axes{unit}": _named("$g_{}$", motion.angular_momentum_body, 1),
        f"angular momentum, space axes{unit}": _named("$G_{}$", motion.angular_momentum_space, 1),
    }
    return against_time(reached(motion), curves, axes, time_unit, title)


@plot
def part_variables(
    motion: Trajectory, part: str = "", *, ax: Axes | None = None, time_unit: str | None = None, title: str = ""
) -> Axes:
    """Draw the variables of a part, `motion.own`.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    part : str, optional
        The name of a part with variables. Default: the one that the system has.
    {options}

    Returns
    -------
    matplotlib Axes
        With a unit where all variables are angular momenta.

    Raises
    ------
    ValueError
        If the system has no such part, or several and none is named.

    Examples
    --------
    >>> system = pt.System(pt.Body((6.0, 8.0, 10.0)), pt.parts.KaneDamper(0.4, 0.3), units={"time": "s"})
    >>> start = system.state((1, 0, 0, 0), omega_body=(0.8, 0.02, 0.05))
    >>> pt.plot.part_variables(pt.propagate(system, start, range(100))).get_ylabel()
    'variables of kane_damper [s⁻¹]'
    """
    own = {each.name: each for each in one_rotation(motion).system.parts if each.size}
    if not part and len(own) == 1:
        [part] = own
    if not own:
        raise ValueError("motion must be of a body with a part that has variables, got one without.")
    if part not in own:
        raise ValueError(f"part must be one of {', '.join(own)}, got {part or 'none'}.")
    names, values = components(own[part]), np.moveaxis(motion.own[part], -1, 0)
    momenta = set(own[part].momenta) == set(own[part].variables)
    label = f"variables of {part}" + (momentum_label(motion.system.units) if momenta else "")
    curves = {name.replace("_", " "): value for name, value in zip(names, values, strict=True)}
    panel: Axes = against_time(reached(motion), {label: curves}, ax, time_unit, title)[0]
    return panel


@plot
def distance(motion: PairTrajectory, *, ax: Axes | None = None, time_unit: str | None = None, title: str = "") -> Axes:
    """Draw the distance of the centres of mass of two bodies.

    Parameters
    ----------
    motion : PairTrajectory
        One, or an ensemble.
    {options}

    Returns
    -------
    matplotlib Axes

    Examples
    --------
    >>> pt.plot.distance(pair_motion, time_unit="h").get_ylabel()
    'distance of the centres of mass [m]'
    """
    label = f"distance of the centres of mass{bracketed(motion.system.units['length'])}"
    panel: Axes = against_time(reached(motion), {label: {"": motion.distance}}, ax, time_unit, title)[0]
    return panel


@plot
def torques(motion: Trajectory, *, ax: Axes | None = None, time_unit: str | None = None, title: str = "") -> Axes:
    """Draw the size of the torque of each force, on a log axis.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble, with forces. Torques between the body and its parts are not drawn.
    {options}

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    TypeError, ValueError
        If there are no forces.

    Examples
    --------
    >>> top = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1, 0, 0)), pt.forces.LinearDamping(0.01))
    >>> falling = pt.propagate(top, top.state((1, 0, 0, 0), omega_body=(0, 0.1, 2)), np.linspace(0, 9, 91))
    >>> [line.get_label() for line in pt.plot.torques(falling).lines]
    ['UniformGravity', 'LinearDamping']
    """
    found = one_rotation(motion).torques_body
    if not found:
        raise ValueError("motion must have forces to draw their torques, got one without, or of a file without theirs.")
    sizes = {name: np.linalg.norm(torque, axis=-1) for name, torque in found.items()}
    shown = {name: np.where(size > 0, size, np.nan) for name, size in sizes.items()}
    unit = bracketed(DerivedUnits(motion.system.units).energy)
    panel: Axes = against_time(reached(motion), {f"torque{unit}": shown}, ax, time_unit, title, log=True)[0]
    return panel


@plot
def drift(motion: Trajectory, *, ax: Axes | None = None, time_unit: str | None = None, title: str = "") -> Axes:
    """Plot the drift of the integrals of motion, on a log axis.

    They are the norm of q, q . Q, which is zero, and what the forces conserve, whose value at the start is named. Of
    two bodies each has its q and Q.

    Parameters
    ----------
    motion : Trajectory
        One, or an ensemble.
    {options}

    Returns
    -------
    matplotlib Axes
        Values below half the rounding of a float, 1.1e-16, are drawn there.

    Examples
    --------
    >>> pt.plot.drift(motion).get_ylabel()
    'relative drift'
    """
    reached(motion)
    drifts = {}
    for body, each in motion.of_bodies.items():
        size = np.nanmax(np.linalg.norm(each.conjugate_momenta, axis=-1), initial=0.0) or 1.0
        drifts[f"$|q| - 1${_of(body)}"] = each.norm_error
        drifts[rf"$q \cdot Q\,/\,|Q|${_of(body)}"] = each.tangency_error / size
    names = _names_of_integrals(motion)
    drifts |= {names[key]: drift for key, drift in motion.drift.items()}
    curves = {
        name: np.where(np.isnan(drift), drift, np.maximum(np.abs(drift), FLOOR)) for name, drift in drifts.items()
    }
    panel: Axes = against_time(motion, {"relative drift": curves}, ax, time_unit, title, log=True)[0]
    panel.set_ylim(bottom=0.8 * FLOOR)
    return panel


@plot
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
        Each one or an ensemble, or both of two bodies, at equal times (in files of dates they are rounded: half a
        microsecond apart is equal); or `motion` has dense output over the times of `other`.
    {options}

    Returns
    -------
    matplotlib Axes
        No angle at all is drawn as the smallest one.

    Raises
    ------
    ValueError
        If their times differ, and there is no dense output.

    Examples
    --------
    >>> exact = pt.free_motion(motion.system.body, motion.initial, motion.times, units=motion.system.units)
    >>> pt.plot.difference(motion, exact, angle_unit="arcsec").get_ylabel()
    'difference of attitude [arcsec]'
    """
    reached(motion), reached(other, "other")
    unit, alike = angle_unit_of(angle_unit), _at_same_times(motion, other)
    first, second = (motion if alike else motion(other.times)).of_bodies, other.of_bodies
    if first.keys() != second.keys():
        one_rotation(motion), one_rotation(other, "other")
    angles = {body: unit.factor * _angle_between(first[body], each) for body, each in second.items()}
    curves = {f"difference of attitude{unit.label}": angles}
    panel: Axes = against_time(motion if alike else other, curves, ax, time_unit, title, log=True)[0]
    return panel


# ---------------------------------------------------------------------- what is drawn


def _of(body: str) -> str:
    """Return what is said of which body something is: nothing where there is but one."""
    return body and f" of the {body}"


def _angle_between(one: State | Trajectory, other: Trajectory) -> Array:
    """Return the angle of the rotation from one attitude to another; where there is none, the smallest one."""
    angle = np.asarray(rotation_angle(one.quaternion, other.quaternion))
    smallest = np.min(angle, where=angle > 0, initial=np.inf)
    return np.where(angle > 0, angle, smallest if np.isfinite(smallest) else FLOOR)


def _at_same_times(motion: Trajectory, other: Trajectory) -> bool:
    """Return whether two motions have the same times; refuse others where the first has no dense output."""
    slack = SAME_INSTANT / SECONDS.get(motion.system.units["time"], np.inf)
    if motion.times.shape == other.times.shape and np.all(np.abs(motion.times - other.times) <= slack):
        return True
    if not motion.has_dense_output:
        theirs, ours = (f"{x.times.size} times from {x.times[0]:.6g} to {x.times[-1]:.6g}" for x in (other, motion))
        raise ValueError(
            f"other must have the same times, got {theirs} and {ours}. "
            "Compute both at the same times, or the first with dense output."
        )
    return False


def different_orbits(motion: Trajectory) -> list[Orbit]:
    """Return the orbits of a system, each once, in the order of its forces."""
    orbits: list[Orbit] = []
    for orbit in motion.system.orbits:
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
    names, units, values = {}, DerivedUnits(motion.system.units), motion.integrals
    for integral in motion.system.integrals:
        letter, index = integral.symbol[0], integral.symbol[1:]
        symbol = f"{letter}_{{{index}}}" if index.isalnum() else integral.symbol.replace(".", r" \cdot ")
        value = ""
        if not motion.is_ensemble:
            unit = units.energy if integral.is_energy else units.momentum
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
