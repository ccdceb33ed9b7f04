"""The columns of CCSDS Attitude Data Messages (504.0-B-2, annex F), for AEM and APM.

The quaternion from A to B turns the axes of A into those of B, so that x_A = q x_B q~; Euler angles turn A into B by
three successive rotations, each about an axis that the ones before have turned: q = r_i(a1) r_j(a2) r_k(a3). The
angular velocity is that of B relative to A.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.mechanics import euler
from poinsot.mechanics.attitude import omega_body

__all__ = ["COLUMNS", "QUATERNION", "attitude_of", "checked_period", "kvn_columns", "sequence_of"]

Array = NDArray[np.float64]

UNIT_SLACK = 1e-3
"""Tolerance of |q| - 1 in a file of few digits."""

SHORTEST_PERIOD = 1e-9
"""Seconds."""

QUATERNION = ("Q1", "Q2", "Q3", "QC")
QUATERNION_DOT = tuple(f"{key}_DOT" for key in QUATERNION)
ANGLES = ("ANGLE_1", "ANGLE_2", "ANGLE_3")
ANGVEL = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
RATES = ("RATE_1", "RATE_2", "RATE_3")
SPIN = ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL")

COLUMNS = {
    "QUATERNION": QUATERNION,
    "QUATERNION/DERIVATIVE": QUATERNION + QUATERNION_DOT,
    "QUATERNION/ANGVEL": QUATERNION + ANGVEL,
    "QUATERNION/RATE": QUATERNION + RATES,
    "EULER_ANGLE": ANGLES,
    "EULER_ANGLE/DERIVATIVE": ANGLES + tuple(f"{key}_DOT" for key in ANGLES),
    "EULER_ANGLE/ANGVEL": ANGLES + ANGVEL,
    "EULER_ANGLE/RATE": ANGLES + RATES,
    "SPIN": SPIN,
    "SPIN/NUTATION": (*SPIN, "NUTATION", "NUTATION_PER", "NUTATION_PHASE"),
    "SPIN/NUTATION_MOM": (*SPIN, "MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"),
}
"""The numbers in a row of each type of attitude, in their order after the epoch."""


def kvn_columns(kind: str, scalar_first: bool) -> tuple[str, ...]:
    """Return the columns of a row in KVN; version 1 may have the scalars of quaternions first."""
    columns = COLUMNS[kind]
    if not scalar_first or not kind.startswith("QUATERNION"):
        return columns
    groups = [columns[:4], columns[4:]] if len(columns) == 8 else [columns[:4]]
    return tuple(key for group in groups for key in (group[3], *group[:3])) + columns[4 * len(groups) :]


def sequence_of(text: str, place: str) -> str:
    """Return a sequence of rotations, 321 or ZYX, as digits."""
    sequence = text.upper().translate(str.maketrans("XYZ", "123"))
    if sequence not in euler.SEQUENCES:
        raise ValueError(f"{place} must have a sequence of three axes in EULER_ROT_SEQ, got {text[:20]!r}.")
    return sequence


def attitude_of(
    kind: str,
    columns: Mapping[str, Array],
    sequence: str | None,
    *,
    rate_in_a: bool,
    body_is_b: bool,
    version: str,
    places: list[str],
) -> tuple[Array, Array | None, float]:
    """Return quaternions body -> reference (n, 4), rates (n, 3) along the body where they are said, and | |q| - 1 |.

    What version 1 calls RATE is read by some as rates of angles and by others as the angular velocity, and its
    NUTATION is not defined: they are passed over.
    """
    form, _, more = kind.partition("/")
    raw = ATTITUDES[form](columns, sequence)
    q, error = _unit_rows(raw, places)
    omega = None
    if form == "SPIN" and (not more or version >= "2"):
        omega = _spin_rate(q, columns, more)
    elif more == "ANGVEL":
        given = _stacked(columns, ANGVEL, np.pi / 180)
        omega = quat.rotate(quat.conjugate(q), given) if rate_in_a else given
    elif more == "DERIVATIVE":
        omega = _derived_rate(raw, columns, sequence)
    if body_is_b:
        return q, omega, error
    return quat.conjugate(q), None if omega is None else -quat.rotate(q, omega), error


def checked_period(period: float, place: str) -> float:
    """Return a period of nutation that is one."""
    if not period > SHORTEST_PERIOD:
        raise ValueError(f"{place} must have a positive NUTATION_PER, got {period}.")
    return period


def _unit_rows(q: Array, places: list[str]) -> tuple[Array, float]:
    norms = np.linalg.norm(q, axis=-1)
    error = np.abs(norms - 1)
    worst = int(np.argmax(error))
    if not error[worst] <= UNIT_SLACK:
        raise ValueError(
            f"{places[worst]} must have a quaternion of unit norm to {UNIT_SLACK}, but |q| = {norms[worst]:.6g}."
        )
    return q / norms[:, None], float(error[worst])


def _of_quaternion(columns: Mapping[str, Array], _: str | None) -> Array:
    return _stacked(columns, ("QC", "Q1", "Q2", "Q3"))


def _of_angles(columns: Mapping[str, Array], sequence: str | None) -> Array:
    return np.asarray(euler.quaternion_from_angles(_stacked(columns, ANGLES, np.pi / 180), str(sequence)))


def _of_spin(columns: Mapping[str, Array], _: str | None) -> Array:
    alpha, delta, angle = (columns[key] for key in SPIN[:3])
    angles = np.radians(np.stack([alpha + 90, 90 - delta, angle], axis=-1))
    return np.asarray(euler.quaternion_from_angles(angles, "313"))


ATTITUDES = {"QUATERNION": _of_quaternion, "EULER_ANGLE": _of_angles, "SPIN": _of_spin}


def _derived_rate(q: Array, columns: Mapping[str, Array], sequence: str | None) -> Array:
    if sequence is None:
        q_dot = _stacked(columns, ("QC_DOT", "Q1_DOT", "Q2_DOT", "Q3_DOT"))
        return np.asarray(omega_body(q, q_dot) / quat.dot(q, q)[..., None])
    rates = _stacked(columns, tuple(f"{key}_DOT" for key in ANGLES), np.pi / 180)
    axes = euler.rotation_axes(_stacked(columns, ANGLES, np.pi / 180), sequence)
    return np.asarray(sum(rates[..., i, None] * axis for i, axis in enumerate(axes)))


def _spin_rate(q: Array, columns: Mapping[str, Array], nutation: str) -> Array:
    """Return the rate about the spin axis, the third of B, plus that of the axis about the momentum (annex F5)."""
    spin: Array = np.radians(columns["SPIN_ANGLE_VEL"])[:, None] * np.array([0.0, 0.0, 1.0])
    if not nutation:
        return spin
    if nutation == "NUTATION":
        tilt, phase = np.radians(columns["NUTATION"]), np.radians(columns["NUTATION_PHASE"])
        momentum = np.stack([np.sin(tilt) * np.cos(phase), -np.sin(tilt) * np.sin(phase), np.cos(tilt)], axis=-1)
        turning: Array = 2 * np.pi / columns["NUTATION_PER"]
    else:
        alpha, delta = np.radians(columns["MOMENTUM_ALPHA"]), np.radians(columns["MOMENTUM_DELTA"])
        in_a = np.stack([np.cos(delta) * np.cos(alpha), np.cos(delta) * np.sin(alpha), np.sin(delta)], axis=-1)
        momentum, turning = quat.rotate(quat.conjugate(q), in_a), np.radians(columns["NUTATION_VEL"])
    return np.asarray(spin + turning[:, None] * momentum)


def _stacked(columns: Mapping[str, Array], keys: tuple[str, ...], factor: float = 1.0) -> Array:
    return np.asarray(factor * np.stack([columns[key] for key in keys], axis=-1))
