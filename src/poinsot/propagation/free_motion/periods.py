"""State of a torque-free rotation from its two periods.

With the principal axes 1, 2, 3 in cyclic order and the circled axis third, c_i = 1/I_i, and the angular momentum G at
the angle theta from the axis 3,

    g = G (sin theta sin psi, sin theta cos psi, cos theta),
    2 T/G^2 = c_3 + sin^2 theta (d_1 sin^2 psi + d_2 cos^2 psi),  d_i = c_i - c_3.

theta is largest where the momentum is in the plane of the axis 3 and the intermediate axis. With this largest angle N,
between 0 and 90 degrees, and d the d_i of the intermediate axis, 2 T/G^2 - c_3 = d sin^2 N. The ratio of the periods
depends on N alone and increases with N, from

    P_psi/P_phi = s + sqrt(I_1 I_2/((I_3 - I_1)(I_3 - I_2))),  s = 1 (short axis) or -1 (long axis),

in steady rotation to infinity on the separatrix.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.errors import member_array, refuse_nonpositive, refuse_other_members
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.euler import quaternion_from_angles
from poinsot.kinematics.state import State, state_with
from poinsot.mechanics.body import Body
from poinsot.printable import quoted
from poinsot.propagation.free_motion.elements import elements_of
from poinsot.quantities import Array, Times

__all__ = ["MODES", "cyclic_order", "least_ratio", "state_with_periods"]

MODES = ("short-axis", "long-axis")
"""Modes with two periods."""

MIN_TANGENT, MAX_TANGENT = 1e-9, 1e8
"""Tangents of the largest nutation N between which N is searched."""
BISECTIONS = 60
"""Number of bisections of the logarithm of tan N, which reach its last digit."""


def state_with_periods(
    body: Body,
    mode: str,
    rotation_period: Any,
    precession: tuple[str, Any],
    momentum_axes: Array,
    rotation_angle: Any,
    time: Times,
) -> State:
    """Return the state with two periods, and with the angle psi of the rotation about the circled axis.

    Parameters
    ----------
    body : Body
        Body with moments of shape (3,) or (members, 3).
    mode : {"short-axis", "long-axis"}
        Mode of the rotation.
    rotation_period : float or array (members,)
        P_psi of the circled axis.
    precession : name and float or array (members,)
        "precession_period" of the circled axis, P_phi, or "long_axis_precession_period".
    momentum_axes : array (4,) or (members, 4)
        Attitude of axes whose third axis is along the angular momentum and whose first axis is the line of nodes.
    rotation_angle : float or array (members,)
        psi, the angle about the circled axis from the line of nodes to the principal axis 1, radians.
    time : float
        Time of the state.

    Raises
    ------
    ValueError
        If an argument is invalid, or no body of these moments has these periods in this mode.
    """
    given = {"rotation_period": rotation_period, precession[0]: precession[1], "rotation_angle": rotation_angle}
    P_psi, P_phi, psi = (member_array(name, value, ()) for name, value in given.items())
    refuse_nonpositive("rotation_period", P_psi)
    refuse_nonpositive(precession[0], P_phi)
    if mode not in MODES:
        raise ValueError(f"mode must be one of {', '.join(MODES)}, got {quoted(mode)}.")
    moments = np.asarray(body.moments, dtype=float)
    counts = dict(zip(given, (P_psi.shape, P_phi.shape, psi.shape), strict=True))
    refuse_other_members(body=moments.shape[:-1], direction=momentum_axes.shape[:-1], **counts)
    if precession[0] != "precession_period" and mode == "short-axis":
        P_phi = 1 / (1 / P_phi + 1 / P_psi)
    order = cyclic_order(moments, mode)
    I = np.take_along_axis(moments, order, axis=-1)
    tangent = _largest_nutation(I, np.asarray(P_psi / P_phi), mode)
    theta, psi = np.broadcast_arrays(_nutation(I, tangent, psi), psi)
    sine = np.sin(theta)
    direction = np.stack([sine * np.sin(psi), sine * np.cos(psi), np.cos(theta)], axis=-1)
    unit = elements_of(I, np.eye(3), _state_of(direction))
    g = direction * np.asarray(2 * np.pi / unit.precession.hi / P_phi)[..., None]
    principal = np.asarray(body.principal_matrix) @ np.swapaxes(np.eye(3)[order], -1, -2)
    nodes = quaternion_from_angles(np.stack([0 * theta, theta, psi], axis=-1), "313")
    along_body = quat.conjugate(quaternion_from_matrix(principal))
    q = quat.product(quat.product(momentum_axes, nodes), along_body)
    return state_with(q, np.vecdot(principal, g[..., None, :]), time)


def cyclic_order(moments: Array, mode: str) -> NDArray[np.int_]:
    """Return the indices of the principal axes in cyclic order with the circled axis third."""
    third = (np.argmax if mode == "short-axis" else np.argmin)(moments, axis=-1)
    order = (np.asarray(third)[..., None] + [1, 2, 0]) % 3
    I = np.take_along_axis(moments, order, axis=-1)
    same = np.any(I[..., :2] == I[..., 2:], axis=-1)
    if np.any(same):
        which, other = ("largest", "long-axis") if mode == "short-axis" else ("smallest", "short-axis")
        raise ValueError(
            f"mode must be possible for the body, got {mode} for moments {np.atleast_2d(moments[same])[0].tolist()}, "
            f"of which the two {which} are equal. Use mode='{other}' if the third differs."
        )
    return order


def _differences(I: Array) -> tuple[Array, Array]:
    """Return |c_1 - c_3| and |c_2 - c_3|."""
    first, second, third = np.moveaxis(I, -1, 0)
    return np.abs(third - first) / (first * third), np.abs(third - second) / (second * third)


def _nutation(I: Array, tangent: Array, psi: Array) -> Array:
    """Return theta at an angle psi, from the tangent of the largest theta."""
    d1, d2 = _differences(I)
    across = np.where(d1 < d2, np.cos(psi), np.sin(psi)) ** 2  # weight of the axis that is not the intermediate one
    d = np.minimum(d1, d2)
    return np.asarray(np.arctan2(tangent * np.sqrt(d), np.sqrt(d + across * np.abs(d1 - d2) * (1 + tangent**2))))


def least_ratio(I: Array, mode: str) -> Array:
    """Return P_psi/P_phi of an infinitesimal nutation; the circled axis is the third."""
    first, second, third = np.moveaxis(I, -1, 0)
    across = (third - first) * (third - second)
    root = np.sqrt(first * second / across)
    return np.asarray(1 + root if mode == "short-axis" else third * (first + second - third) / (across * (1 + root)))


def _state_of(momentum: Array) -> State:
    return State.computed({"quaternion": np.eye(4)[0], "angular_momentum_body": momentum}, 0.0)


def _largest_nutation(I: Array, ratio: Array, mode: str) -> Array:
    """Return the tangent of the largest nutation at which the periods have a ratio."""
    I, ratio = np.broadcast_arrays(I, ratio[..., None])
    ratio = ratio[..., 0]
    low, high = (np.full(ratio.shape, np.log(tangent)) for tangent in (MIN_TANGENT, MAX_TANGENT))
    lowest, highest = least_ratio(I, mode), _ratio(I, high)
    if np.any(wrong := ~((ratio > lowest) & (ratio < highest))):
        least, most, got, own = (np.atleast_1d(x[wrong])[0] for x in (lowest, highest, ratio, I))
        raise ValueError(
            f"rotation_period must be between {least:.6g} and {most:.4g} times the precession_period for moments "
            f"{own.tolist()} in the {mode} mode, got {got:.6g} times. Other moments or the other mode have another "
            "range."
        )
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        below = _ratio(I, middle) < ratio
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(np.exp((low + high) / 2))


def _ratio(I: Array, log_tangent: Array) -> Array:
    """Return P_psi/P_phi at a largest nutation."""
    d1, d2 = _differences(I)
    tangent = np.exp(log_tangent)
    momentum = np.stack([np.where(d1 < d2, tangent, 0.0), np.where(d1 < d2, 0.0, tangent), np.ones_like(tangent)], -1)
    e = elements_of(I, np.eye(3), _state_of(momentum))
    return np.asarray(e.precession.hi / e.winding.hi)
