"""Columns of CCSDS Attitude Data Messages (504.0-B-2, annex F), for AEM and APM.

The quaternion from A to B rotates the axes of A into the axes of B, so that x_A = q x_B q~. Euler angles rotate A into
B by three successive rotations, each about an axis of the rotated frame: q = r_i(a1) r_j(a2) r_k(a3). The angular
velocity is the angular velocity of B relative to A.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from xml.etree import ElementTree as ET

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.errors import level_of_user
from poinsot.files import ccsds
from poinsot.files.attitudes.attitude_table import AttitudeTable
from poinsot.files.rows import TextRows
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import omega_body
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar

NORM_TOLERANCE = 1e-3
"""Tolerance of |q| - 1 in a file of few digits."""

MIN_PERIOD = 1e-9
"""Shortest period, seconds."""

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


def read_attitudes(
    rows: TextRows,
    kind: str,
    times: Array,
    calendar: Calendar | None,
    frames: tuple[str, str],
    *,
    body_is_b: bool = True,
    rate_in_a: bool = False,
    version: str = "2.0",
) -> AttitudeTable:
    """Return the attitudes of rows of one type from A to B, body -> reference, with their rates if the rows have them.

    Programs differ in the meaning of RATE in version 1: rates of angles or angular velocity. Version 1 does not define
    NUTATION either. These columns are ignored with a warning.

    `frames` are the names of the reference frame and of the body, which `body_is_b` or is A; `rate_in_a` is whether
    angular velocities are along A.
    """
    form, _, more = kind.partition("/")
    sequence = _sequence_of(rows) if form == "EULER_ANGLE" else ""
    raw = _quaternions(rows, form, sequence)
    norms = np.linalg.norm(raw, axis=-1)
    error = np.abs(norms - 1)
    worst = int(np.argmax(error))
    if not error[worst] <= NORM_TOLERANCE:
        place, norm = rows.places[worst], norms[worst]
        raise ValueError(f"{place} must have a quaternion of unit norm to {NORM_TOLERANCE}, got |q| = {norm:.6g}.")
    q, omega = raw / norms[:, None], None
    if form == "SPIN" and (not more or version >= "2"):
        omega = _spin_rate(q, rows, more)
    elif form == "SPIN" or more == "RATE":
        warn_of_undefined(rows.name, more)
    elif more == "ANGVEL":
        given = rows.stacked(*ANGVEL, factor=np.pi / 180)
        omega = quat.rotate(quat.conjugate(q), given) if rate_in_a else given
    elif more == "DERIVATIVE":
        omega = _derived_rate(raw, rows, sequence)
    if not body_is_b:
        q, omega = quat.conjugate(q), None if omega is None else -quat.rotate(q, omega)
    if omega is not None and calendar is not None:
        omega = omega * SECONDS[calendar.unit]
    return AttitudeTable(times, q, omega, calendar, *frames, float(error[worst]))


XML_GROUPS = {"quaternion": QUATERNION, "quaternionRate": QUATERNION_DOT, "angVel": ANGVEL}
"""Elements that contain the components of a quaternion, and of its rate together with the quaternion."""


def append_values(parent: ET.Element, values: Mapping[str, float | str], version: str) -> None:
    """Append values by their keys to an element in XML. Version 1 has the scalar of a quaternion first."""
    groups = {tag: keys for tag, keys in XML_GROUPS.items() if "QC" in values and keys[0] in values}
    inside = {key for keys in groups.values() for key in keys}
    for key, value in values.items():
        if key not in inside:
            ccsds.append_value(parent, key, value)
    for tag, keys in groups.items():
        group = ET.SubElement(parent, tag)
        for key in (keys[-1], *keys[:-1]) if version < "2" and len(keys) == 4 else keys:
            ccsds.append_value(group, key, values[key])


def warn_of_undefined(place: str, what: str) -> None:
    """Warn of columns whose meaning the standard does not define."""
    warnings.warn(
        f"{place} should have rates that the standard defines, got rates of /{what}, which are ignored.",
        stacklevel=level_of_user(),
    )


def _sequence_of(rows: TextRows) -> str:
    """Return a sequence of rotations, 321 or ZYX, as digits."""
    text = rows.metadata.get("EULER_ROT_SEQ", "")
    sequence = text.upper().translate(str.maketrans("XYZ", "123"))
    if sequence not in euler.SEQUENCES:
        raise ValueError(f"{rows.name} must have a sequence of three axes in EULER_ROT_SEQ, got {quoted(text)}.")
    return sequence


def _quaternions(rows: TextRows, form: str, sequence: str) -> Array:
    if form == "QUATERNION":
        return rows.stacked("QC", "Q1", "Q2", "Q3")
    if form == "EULER_ANGLE":
        return np.asarray(euler.quaternion_from_angles(rows.stacked(*ANGLES, factor=np.pi / 180), sequence))
    alpha, delta, angle = rows.stacked(*SPIN[:3]).T
    angles = np.radians(np.stack([alpha + 90, 90 - delta, angle], axis=-1))
    return np.asarray(euler.quaternion_from_angles(angles, "313"))


def _derived_rate(q: Array, rows: TextRows, sequence: str) -> Array:
    if not sequence:
        q_dot = rows.stacked("QC_DOT", "Q1_DOT", "Q2_DOT", "Q3_DOT")
        return np.asarray(omega_body(q, q_dot) / quat.dot(q, q)[..., None])
    rates = rows.stacked(*(f"{key}_DOT" for key in ANGLES), factor=np.pi / 180)
    axes = euler.rotation_axes(rows.stacked(*ANGLES, factor=np.pi / 180), sequence)
    return np.asarray(sum(rates[..., i, None] * axis for i, axis in enumerate(axes)))


def _spin_rate(q: Array, rows: TextRows, nutation: str) -> Array:
    """Return the rate about the spin axis, the third of B, plus the rate of this axis about the momentum (annex F5)."""
    spin: Array = rows.stacked("SPIN_ANGLE_VEL", factor=np.pi / 180) * np.array([0.0, 0.0, 1.0])
    if not nutation:
        return spin
    if nutation == "NUTATION":
        tilt, phase = rows.stacked("NUTATION", "NUTATION_PHASE", factor=np.pi / 180).T
        momentum = np.stack([np.sin(tilt) * np.cos(phase), -np.sin(tilt) * np.sin(phase), np.cos(tilt)], axis=-1)
        (period,) = rows.stacked("NUTATION_PER").T
        wrong = np.flatnonzero(~(period > MIN_PERIOD))
        if wrong.size:
            place, given = rows.places[wrong[0]], period[wrong[0]]
            raise ValueError(f"{place} must have a positive NUTATION_PER, got {given}.")
        turning: Array = 2 * np.pi / period
    else:
        alpha, delta, turning = rows.stacked("MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL", factor=np.pi / 180).T
        in_a = np.stack([np.cos(delta) * np.cos(alpha), np.cos(delta) * np.sin(alpha), np.sin(delta)], axis=-1)
        momentum = quat.rotate(quat.conjugate(q), in_a)
    return np.asarray(spin + turning[:, None] * momentum)
