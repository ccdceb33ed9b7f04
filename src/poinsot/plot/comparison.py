"""Angles between two attitudes, and standard deviations of attitude and momentum, against time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from poinsot.algebra import quaternion as quat
from poinsot.analysis.transition_matrix import StateTransition
from poinsot.errors import real_array
from poinsot.kinematics.attitude import rotation_angle, unit_quaternion
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import State
from poinsot.mechanics.two_bodies import BODIES
from poinsot.plot.curves import CurveOptions, PairOptions, SeparatePairOptions, against_time, in_one_panel, reached
from poinsot.plot.labels import angle_unit_of, bracketed, momentum_label, one_member, one_rotation
from poinsot.plot.panels import Axes, plot
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS
from poinsot.records.units import DerivedUnits

__all__ = ["attitude_error", "difference", "median_attitude", "uncertainty"]

MIN_ANGLE = 0.5 * np.finfo(float).eps
"""Smallest angle on a log axis: the unit roundoff of a float."""
SAME_INSTANT = 5e-7
"""Largest difference of equal times, seconds. Files of dates round times to a nanosecond or to a SPICE tick."""
MEDIAN_ITERATIONS = 10
"""Number of iterations for a median attitude."""
MIN_MEDIAN_ANGLE = 1e-9
"""Angle to the median, radians, below which the weights of members do not increase."""


@plot
def attitude_error(
    motion: Trajectory,
    other: Trajectory | Frame | ArrayLike | None = None,
    *,
    angle_unit: str | None = None,
    **options: Unpack[SeparatePairOptions],
) -> NDArray[Any]:
    """Draw the rotation from a reference to the attitude: its angle (left) and its rotation vector, body axes (right).

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble, whose median and bands are drawn.
    other : Trajectory, Frame, Rotation or array (4,) or (n, 4), optional
        Reference: another motion with the rules of `difference`; a frame such as `orbit.frame`; one attitude, or one
        for each time. Default for an ensemble: its median attitude, which minimises the sum of the angles to the
        members.
    {options}

    Raises
    ------
    ValueError
        If the times of the reference differ, or the reference of a single motion is missing.

    Examples
    --------
    >>> angle, vector = pt.plot.attitude_error(motion, (1, 0, 0, 0))
    >>> angle.get_ylabel()
    'angle to the reference [deg]'
    """
    drawn, q, reference = _against_reference(reached(one_rotation(motion)), other)
    turn = quat.product(quat.conjugate(reference), q)
    turn = np.where(turn[..., :1] < 0, -turn, turn)
    size = np.linalg.norm(turn[..., 1:], axis=-1)
    angle = 2 * np.arctan2(size, turn[..., 0])
    vector = np.where(size > 0, angle / np.where(size > 0, size, 1.0), 2.0)[..., None] * turn[..., 1:]
    unit, reference_name = angle_unit_of(angle_unit, angle), "median attitude" if other is None else "reference"
    curves = {
        f"angle to the {reference_name}{unit.label}": {"": unit.factor * angle},
        f"rotation vector from it, body axes{unit.label}": {
            rf"$\theta_{i + 1}$": unit.factor * vector[..., i] for i in range(3)
        },
    }
    past_half_a_turn = np.linalg.norm(np.diff(vector, axis=-2, prepend=vector[..., :1, :]), axis=-1) > np.pi
    [_, vectors] = curves.values()
    return against_time(drawn, curves, breaks=dict.fromkeys(vectors, past_half_a_turn), **options)


@plot
def difference(
    motion: Trajectory, other: Trajectory, *, angle_unit: str | None = None, **options: Unpack[CurveOptions]
) -> Axes:
    """Draw the angle of the rotation from one attitude to another, at the same times, on a log axis.

    Parameters
    ----------
    motion, other : Trajectory
        Motions or ensembles of one body, or both of two bodies, at equal times. Dates in files are rounded, so times
        half a microsecond apart count as equal. Other times require dense output of `motion` over the times of `other`.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel. A zero angle is drawn at the smallest nonzero angle.

    Raises
    ------
    ValueError
        If the times differ and there is no dense output.

    Examples
    --------
    >>> exact = pt.free_motion(motion.system.body, motion.initial, motion.times, units=motion.system.units)
    >>> pt.plot.difference(motion, exact, angle_unit="arcsec").get_ylabel()
    'difference of attitude [arcsec]'
    """
    reached(motion), reached(other, "other")
    same_times = _at_same_times(motion, other)
    first, second = (motion if same_times else motion(other.times)).of_bodies, other.of_bodies
    if first.keys() != second.keys():
        one_rotation(motion), one_rotation(other, "other")
    angles = {body: _angle_between(first[body], each) for body, each in second.items()}
    unit = angle_unit_of(angle_unit, np.stack(list(angles.values())))
    curves = {body: unit.factor * each for body, each in angles.items()}
    label = f"difference of attitude{unit.label}"
    return in_one_panel(motion if same_times else other, label, curves, log=True, **options)


@plot
def uncertainty(
    transition: StateTransition,
    initial: ArrayLike,
    of_parameters: ArrayLike | None = None,
    *,
    angle_unit: str | None = None,
    **options: Unpack[PairOptions],
) -> NDArray[Any]:
    """Draw the standard deviations of the rotation vector (left) and of the angular momentum (right), body axes.

    For two bodies both are drawn for each, together with the standard deviations of the relative position and momentum,
    space axes.

    Parameters
    ----------
    transition : StateTransition
        Transition of a motion, not of an ensemble. The coordinates of parts are not drawn.
    initial : array (k, k)
        Covariance at the initial time, as in `StateTransition.covariance`.
    of_parameters : array (p, p), optional
        Covariance of the parameters, as in `StateTransition.covariance`.
    {options}

    Returns
    -------
    array (2,) or (4,) of matplotlib Axes
        Two panels for one body, four for two bodies.

    Raises
    ------
    TypeError, ValueError
        If the transition is of an ensemble or of planar motion.

    Examples
    --------
    >>> transition = pt.analysis.state_transition(motion.system, motion.initial, motion.times)
    >>> start = np.diag([1e-3] * 3 + [1e-2] * 3) ** 2  # of the rotation vector, rad, and of the angular momentum
    >>> attitude, momentum = pt.plot.uncertainty(transition, start, angle_unit="arcsec", time_unit="min")
    >>> attitude.get_xlabel()
    'time [min]'
    """
    coordinates = transition.coordinates
    if not coordinates[0].endswith("theta_1"):
        raise ValueError(f"transition must be in space, from theta_1 on, got {coordinates[0]}. Leave formulation out.")
    motion = one_member(transition.motion, "transition.motion")
    covariance = transition.covariance(real_array("initial", initial, (None, None)), of_parameters)
    deviations = dict(zip(coordinates, np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)).T, strict=True))
    turned = [each for name, each in deviations.items() if name.endswith(("theta_1", "theta_2", "theta_3"))]
    angle, units = angle_unit_of(angle_unit, turned), motion.system.units
    curves = {
        rf"$1\sigma$ of the attitude{angle.label}": _deviations_of("theta", deviations, r"\theta", angle.factor),
        rf"$1\sigma$ of the angular momentum{momentum_label(units)}": _deviations_of("g", deviations, "g"),
    }
    if len(motion.of_bodies) > 1:
        lengths = bracketed(units["length"]), bracketed(DerivedUnits(units).linear_momentum)
        curves |= {
            rf"$1\sigma$ of the position{lengths[0]}": _deviations_of("position", deviations, "r"),
            rf"$1\sigma$ of the momentum{lengths[1]}": _deviations_of("momentum", deviations, "p"),
        }
    return against_time(motion, curves, log=True, **options)


def median_attitude(q: Array) -> Array:
    """Return the attitudes with the least sum of angles to members (members, n, 4), without jumps of sign; (n, 4).

    Weiszfeld's iteration: means of q q^T, which has no sign, weighted by one over the angle.
    """
    rows = np.nan_to_num(np.swapaxes(q, 0, 1))
    weights = np.any(rows, axis=-1).astype(float)
    there, median = weights, np.empty(rows.shape[1:])
    for _ in range(MEDIAN_ITERATIONS):
        median = np.linalg.eigh(np.swapaxes(weights[..., None] * rows, -1, -2) @ rows)[1][..., -1]
        near = np.abs(np.vecdot(rows, median[:, None]))
        weights = there / np.maximum(2 * np.arccos(np.minimum(near, 1.0)), MIN_MEDIAN_ANGLE)
    turns = np.vecdot(median[1:], median[:-1]) < 0
    return np.asarray(median * np.where(np.append(False, np.logical_xor.accumulate(turns)), -1, 1)[:, None])


def _against_reference(motion: Trajectory, other: Any) -> tuple[Trajectory, Array, Array]:
    """Return the motion that gives the times, its attitudes, and the attitudes of the reference."""
    if isinstance(other, Trajectory):
        reached(one_rotation(other, "other"), "other")
        if _at_same_times(motion, other):
            return motion, motion.quaternion, other.quaternion
        return other, motion(other.times).quaternion, other.quaternion
    if isinstance(other, Frame):
        return motion, motion.quaternion, other.quaternion(motion.times)
    if other is not None:
        reference = unit_quaternion(other, "other")
        if reference.ndim > 1 and len(reference) != motion.times.size:
            raise ValueError(
                f"other must have one attitude, or one for each of {motion.times.size} times, got {len(reference)}."
            )
        return motion, motion.quaternion, reference
    if not motion.is_ensemble:
        raise ValueError("other must be given for one motion, got none. Only members have a median attitude.")
    return motion, motion.quaternion, median_attitude(motion.quaternion)


def _angle_between(one: State | Trajectory, other: Trajectory) -> Array:
    """Return the angles between attitudes; the smallest nonzero angle replaces zero angles."""
    angle = np.asarray(rotation_angle(one.quaternion, other.quaternion))
    smallest = np.min(angle, where=angle > 0, initial=np.inf)
    return np.where(angle > 0, angle, smallest if np.isfinite(smallest) else MIN_ANGLE)


def _at_same_times(motion: Trajectory, other: Trajectory) -> bool:
    """Return True if two motions have the same times; raise an error if they differ and dense output is missing."""
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


def _deviations_of(kind: str, deviations: dict[str, Array], symbol: str, factor: float = 1.0) -> dict[str, Array]:
    """Return the curves of the coordinates of a kind, of each body, by their label."""
    named = {name: name.rpartition(".") for name in deviations}
    return {
        rf"{body} $\sigma_{{{symbol}_{short[-1]}}}$".strip(): factor * deviations[name]
        for name, (body, _, short) in named.items()
        if short[:-2] == kind and body in ("", *BODIES)
    }
