"""Euler angles and librations against time: wrapped, with gaps at jumps, and with gimbal lock shaded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Unpack

from poinsot.algebra import quaternion as quat
from poinsot.analysis.libration import librations as librations_of
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.kinematics.euler import SINGULAR_SINE, angles_from_quaternion, axes_of, outer_cosine_and_sine
from poinsot.kinematics.frame import LEVEL, Frame
from poinsot.mechanics.environment import Orbit
from poinsot.plot.curves import SeparateCurveOptions, in_one_panel, jumps, reached
from poinsot.plot.labels import angle_unit_of, different_orbits, one_rotation
from poinsot.plot.panels import Axes, count_degrees, plot
from poinsot.propagation.trajectory import OfTwoBodies, Trajectory
from poinsot.quantities import Array

__all__ = ["euler_angles", "librations", "roll_pitch_yaw"]

TURN = 2 * np.pi
LOCKED = np.radians(5)
"""Distance from gimbal lock, radians, within which the first and the third angle vary rapidly."""
WRAP_TOLERANCE = 1e-6
"""Angle beyond half a turn, radians, at which angles are wrapped, because rounding must not wrap half a turn."""
MAX_CHANGE = 0.4
"""Fraction of a turn: a larger change between two samples interrupts the curve."""


@plot
def euler_angles(
    motion: Trajectory,
    sequence: str = "313",
    frame: Frame | None = None,
    *,
    angle_unit: str | None = None,
    **options: Unpack[SeparateCurveOptions],
) -> Axes:
    """Draw Euler angles relative to the space axes or to a frame.

    The angles of one motion are drawn in the interval of half a turn on either side. Gimbal lock is shaded within 5
    degrees. The first and the third angle vary rapidly there with opposite signs; at gimbal lock itself only the second
    angle is drawn.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble whose initial attitudes are within half a turn of each other.
    sequence : str
        One of the 12 sequences of `State.euler`.
    frame : Frame, optional
        Frame to which the angles refer, such as `orbit.frame`. Default: the space axes.
    {options}

    Examples
    --------
    >>> pt.plot.euler_angles(motion, "321", angle_unit="mrad").get_ylabel()
    'Euler angles 3-2-1 [mrad]'
    """
    one_rotation(motion)
    q = reached(motion).quaternion if frame is None else reached(motion).relative_to(frame).quaternion
    names = [f"$\\alpha_{i}$ about axis {axis}" for i, axis in enumerate(sequence, 1)]
    label = f"Euler angles {'-'.join(sequence)}" + (" from the frame" if frame is not None else "")
    return _draw(motion, q, sequence, names, label, angle_unit, **options)


@plot
def roll_pitch_yaw(
    motion: Trajectory,
    orbit: Orbit | None = None,
    *,
    angle_unit: str | None = None,
    **options: Unpack[SeparateCurveOptions],
) -> Axes:
    """Draw roll, pitch and yaw relative to the axes of an orbit.

    The angles of one motion are drawn in the interval of half a turn on either side. The reference axes are transverse
    (forward), opposite to the normal, and down. Yaw about the third axis, then pitch about the second, then roll about
    the first lead to the body axes. Gimbal lock is drawn as in `euler_angles`, which supports other sequences:
    `euler_angles(motion, "313", orbit.frame)`.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble whose initial attitudes are within half a turn of each other.
    orbit : Orbit, optional
        Orbit whose frame is radial, transverse, normal. Default: the only orbit of the system.
    {options}

    Raises
    ------
    TypeError, ValueError
        If the orbit is not an orbit or lacks a frame, or the system contains none or several and none is given.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1)  # km, s
    >>> pt.plot.roll_pitch_yaw(motion, orbit).get_ylabel()
    'attitude relative to the orbital frame [deg]'
    """
    motion = reached(one_rotation(motion))
    orbit = _only_orbit(motion) if orbit is None else orbit
    level = quat.product(quat.conjugate(LEVEL), motion.relative_to(orbit.frame).quaternion)
    label = "attitude relative to the orbital frame"
    return _draw(motion, level, "321", ["yaw", "pitch", "roll"], label, angle_unit, **options)


@plot
def librations(
    motion: OfTwoBodies,
    body: str = "secondary",
    *,
    angle_unit: str | None = None,
    **options: Unpack[SeparateCurveOptions],
) -> Axes:
    """Draw yaw, pitch and roll of one of two bodies relative to their orbit.

    The angles of one motion are drawn in the interval of half a turn on either side.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble.
    body : {"secondary", "primary"}
        Body whose principal axes are drawn, oriented as in `pt.analysis.librations`.
    {options}

    Examples
    --------
    >>> pt.plot.librations(pair_motion, angle_unit="rad").get_ylabel()
    'librations of the secondary [rad]'
    """
    reached(motion)
    found = librations_of(motion, body)
    angles = {name: getattr(found, name) for name in ("roll", "pitch", "yaw")}
    unit = angle_unit_of(angle_unit, list(angles.values()))
    curves = {name: unit.factor * each for name, each in angles.items()}
    breaks = {name: jumps(each, MAX_CHANGE * TURN) for name, each in angles.items()}
    return in_one_panel(motion, f"librations of the {body}{unit.label}", curves, breaks=breaks, **options)


def _draw(
    motion: Trajectory,
    q: Array,
    sequence: str,
    names: Sequence[str],
    label: str,
    unit: str | None,
    **options: Unpack[SeparateCurveOptions],
) -> Axes:
    """Draw the angles of a sequence for attitudes; names list yaw, pitch and roll in the order of their rotations."""
    angles, locked = _angles(q, sequence)
    if motion.is_ensemble:
        angles = np.moveaxis(_unwrapped(np.moveaxis(angles, -1, 0)), 0, -1)
    shown = angle_unit_of(unit, angles)
    curves = {name: shown.factor * angles[..., i] for i, name in enumerate(names)}
    if "roll" in curves:
        curves = dict(reversed(curves.items()))
    shaded = {"near gimbal lock": np.any(np.reshape(locked, (-1, locked.shape[-1])), axis=0)}
    breaks = {name: jumps(angles[..., i], MAX_CHANGE * TURN) for i, name in enumerate(names)}
    panel = in_one_panel(motion, label + shown.label, curves, breaks=breaks, shaded=shaded, **options)
    parts: Sequence[Any] = panel.child_axes or [panel]
    for part in parts:
        count_degrees(part.yaxis, panel.get_ylabel())
    return panel


def _angles(q: Array, sequence: str) -> tuple[Array, NDArray[np.bool_]]:
    """Return the angles of unit quaternions within half a turn, shape (..., 3), and which are near gimbal lock.

    The second angle is always defined. The first and the third angle are NaN where they are undefined.
    """
    first, _, third = axes_of(sequence)
    row = rotation_matrix(q)[..., first, :]  # components of the body axes along the first axis
    along, across = row[..., third], np.linalg.norm(np.delete(row, third, axis=-1), axis=-1)
    parity, _ = outer_cosine_and_sine(np.pi / 2, sequence)
    angles = np.full((*q.shape[:-1], 3), np.nan)
    angles[..., 1] = np.arctan2(across, along) if first == third else np.arctan2(np.round(parity) * along, across)
    defined = across > 2 * SINGULAR_SINE
    if np.any(defined):
        angles[defined] = angles_from_quaternion(q[defined], sequence)
    return np.pi + WRAP_TOLERANCE - np.mod(np.pi + WRAP_TOLERANCE - angles, TURN), across < np.sin(LOCKED)


def _unwrapped(angles: Array) -> Array:
    """Return angles (..., members, n) without jumps by whole turns, also across gaps, from starts near each other."""
    known = ~np.isnan(angles)
    begin = np.argmax(known, axis=-1)[..., None]
    latest = np.maximum(np.maximum.accumulate(np.where(known, np.arange(angles.shape[-1]), 0), axis=-1), begin)
    smooth = np.unwrap(np.take_along_axis(angles, latest, axis=-1), axis=-1)
    start = smooth[..., :1]
    reference = np.nan_to_num(start[:, np.argmax(np.all(known, axis=(0, 2)))])[:, None]
    return np.asarray(np.where(known, smooth - TURN * np.round((start - reference) / TURN), np.nan))


def _only_orbit(motion: Trajectory) -> Orbit:
    """Return the orbit of a system."""
    orbits = different_orbits(motion)
    if len(orbits) != 1:
        raise ValueError(
            f"orbit must be named where the system has not exactly one, but it has {len(orbits) or 'none'}. "
            "Pass roll_pitch_yaw(motion, orbit)."
        )
    return orbits[0]
