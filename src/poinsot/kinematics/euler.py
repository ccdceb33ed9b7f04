"""Euler angles of the 12 sequences and their canonical momenta (paper, Secs. 4 and 5).

A sequence such as "313" names the body axes of three successive rotations: q = r_i(a1) r_j(a2) r_k(a3),
a1 about the space axis i, a2 about the line of nodes, a3 about the body axis k. The momentum of an angle is
the projection of the angular momentum on its axis, so that P . da/dt = g . omega.

Ranges: a1 in [0, 4 pi), a3 in [0, 2 pi), a2 in (0, pi) where the outer axes are equal ("313") and in
(-pi/2, pi/2) where they differ ("123"). a1 and a1 + 2 pi are the same attitude, with opposite signs of q.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.quaternion import assemble, components
from poinsot.functions import Kind, Scalar, Vector
from poinsot.kinematics.attitude import matrix_of
from poinsot.printable import quoted
from poinsot.quantities import Array

SEQUENCES = tuple("".join(s) for s in itertools.product("123", repeat=3) if s[0] != s[1] and s[1] != s[2])

SINGULAR_SINE = 1e-6
"""Below this |sin| of the angle between the outer axes, angles and momenta are not defined."""


def axes_of(sequence: str) -> tuple[int, int, int]:
    """Return the three axes as indices 0, 1, 2."""
    if sequence not in SEQUENCES:
        raise ValueError(f"sequence must be one of {', '.join(SEQUENCES)}, got {quoted(sequence)}.")
    i, j, k = (int(digit) - 1 for digit in sequence)
    return i, j, k


def quaternion_from_angles(angles: ArrayLike, sequence: str = "313") -> Array:
    """Return the quaternion r_i(a1) r_j(a2) r_k(a3); for "313" eq. (12). Shape (..., 3) -> (..., 4)."""
    first, second, third = map(_about, axes_of(sequence), components(angles))
    return assemble(tuple(quat.product(quat.product(first, second), third)), angles)


def angles_from_quaternion(q: ArrayLike, sequence: str = "313") -> NDArray[np.float64]:
    """Return the angles of unit quaternions, in the ranges above; for "313" eq. (13). (..., 4) -> (..., 3).

    Raises
    ------
    ValueError
        At the singular angle, where only the sum or the difference of the outer angles is defined.
    """
    q = np.asarray(q, dtype=float)
    _refuse_singular(sine_of_attitudes(q, sequence), sequence, q)
    near, far, symmetric, parity = _split(q, sequence)
    half_sum, half_difference = np.arctan2(near[1], near[0]), np.arctan2(parity * far[1], far[0])
    middle = 2 * np.arctan2(np.hypot(*far), np.hypot(*near))
    first, third = half_sum + half_difference, half_sum - half_difference
    if not symmetric:
        middle, third = middle - np.pi / 2, -parity * third
    third, turns = _reduced(third, 2 * np.pi)
    return np.stack([_reduced(first - 2 * np.pi * turns, 4 * np.pi)[0], middle, third], axis=-1)


def sine_of_attitudes(q: Array, sequence: str) -> NDArray[np.float64]:
    """Return the sine of the angle between the outer axes of a sequence at unit quaternions, not negative."""
    first, second, *_ = _split(q, sequence)
    near, far = np.hypot(*first), np.hypot(*second)
    sine: NDArray[np.float64] = 2 * near * far / (near**2 + far**2)
    return sine


def most_regular(q: Array) -> str:
    """Return the sequence whose smallest sine at unit quaternions (..., 4) is the largest."""
    return max(SEQUENCES, key=lambda sequence: float(np.nanmin(sine_of_attitudes(q, sequence), initial=1.0)))


def _split(q: Array, sequence: str) -> tuple[tuple[Array, Array], tuple[Array, Array], bool, int]:
    """Return components of q about the sum and the difference of the outer angles, and whether the outer axes agree.

    The last value is the parity of the axes.
    """
    i, j, k = axes_of(sequence)
    symmetric = i == k
    if symmetric:
        k = 3 - i - j
    else:  # r_k(a3) is r_i(-parity a3) seen from axes turned by 90 degrees about j
        quarter = np.zeros(4)
        quarter[[0, j + 1]] = 1.0
        q = quat.product(q, quarter)
    return (q[..., 0], q[..., i + 1]), (q[..., j + 1], q[..., k + 1]), symmetric, _parity(i, j, k)


def rotation_matrix_from_angles(angles: Vector, sequence: str = "313") -> Array:
    """Return the active matrix (3, 3) of three angles, scalars of any kind: its rows are s1, s2, s3 in body axes."""
    (i, j, k), (a1, a2, a3) = axes_of(sequence), angles
    rows = (_turn(k, -a3, _turn(j, -a2, _turn(i, -a1, unit))) for unit in np.eye(3))
    return matrix_of(rows)


def rotation_axes(angles: ArrayLike, sequence: str = "313") -> tuple[Array, Array, Array]:
    """Return the three rotation axes along the body axes, each of shape (..., 3)."""
    (i, j, k), (_, a2, a3) = axes_of(sequence), components(angles)
    unit = np.eye(3)
    first = _turn(k, -a3, _turn(j, -a2, unit[i]))
    nodes = _turn(k, -a3, unit[j])
    third = [0 * a3 + x for x in unit[k]]
    return assemble(first, angles), assemble(nodes, angles), assemble(third, angles)


def angular_momentum_from_momenta(angles: ArrayLike, momenta: ArrayLike, sequence: str = "313") -> Array:
    """Return g in body axes from angles and momenta; for "313" eq. (8). Shapes (..., 3)."""
    _, nodes, third = rotation_axes(angles, sequence)
    p1, p2, p3 = components(momenta)
    cosine, sine = outer_cosine_and_sine(components(angles)[1], sequence)
    across = functions.cross(components(third), components(nodes))  # first = cosine third + sine across
    along = (p1 - cosine * p3) / sine
    return assemble(
        [p3 * a + p2 * b + along * c for a, b, c in zip(components(third), components(nodes), across, strict=True)],
        third,
    )


def angle_rates(angles: ArrayLike, omega_body: ArrayLike, sequence: str = "313") -> list[Scalar]:
    """Return the rates a' of the angles from the angular velocity in body axes, omega = sum a_i' e_i."""
    _, nodes, third = rotation_axes(angles, sequence)
    cosine, sine = outer_cosine_and_sine(components(angles)[1], sequence)
    across = functions.cross(components(third), components(nodes))
    first = functions.dot(across, components(omega_body)) / sine
    return [first, quat.dot(nodes, omega_body), quat.dot(third, omega_body) - cosine * first]


def momenta_from_angular_momentum(angles: ArrayLike, g_body: ArrayLike, sequence: str = "313") -> Array:
    """Return the projections of g on the three axes; for "313" the exact lift of (15) (erratum E6)."""
    axes = rotation_axes(angles, sequence)
    return assemble([quat.dot(axis, g_body) for axis in axes], g_body)


def outer_cosine_and_sine(middle: Kind, sequence: str) -> tuple[Kind, Kind]:
    """Return cosine and sine of the angle between the first and the third axis, the sine along third x nodes."""
    i, j, k = axes_of(sequence)
    cosine, sine = functions.cos(middle), functions.sin(middle)
    parity: Any = _parity(i, j, k)
    return (cosine, sine) if i == k else (parity * sine, -parity * cosine)


def refuse_singular_angles(angles: NDArray[np.float64], sequence: str) -> None:
    """Raise a ValueError where the outer axes are parallel."""
    sine = np.abs(outer_cosine_and_sine(angles[..., 1], sequence)[1])
    _refuse_singular(sine, sequence, quaternion_from_angles(angles, sequence))


def singularity(sine: NDArray[np.float64], sequence: str, q: Array) -> str:
    """Return a sentence about singular attitudes of a sequence, which names a regular one, or nothing."""
    smallest = float(np.nanmin(sine, initial=1.0))
    if smallest >= SINGULAR_SINE:
        return ""
    i, _, k = axes_of(sequence)
    regular = most_regular(q)
    least = float(np.nanmin(sine_of_attitudes(q, regular), initial=1.0))
    hint = f"Use sequence {regular}." if least >= SINGULAR_SINE else "No sequence is regular at all these attitudes."
    return (
        f"the second angle of sequence {sequence} must stay away from its singularity, but "
        f"|{'sin' if i == k else 'cos'}| = {smallest:.2g} there. {hint}"
    )


def _refuse_singular(sine: NDArray[np.float64], sequence: str, q: Array) -> None:
    if sentence := singularity(sine, sequence, q):
        raise ValueError(sentence)


def _about(axis: int, angle: Scalar) -> Vector:
    """Return the quaternion of a rotation about a coordinate axis."""
    parts: list[Scalar] = [functions.cos(0.5 * angle), 0.0, 0.0, 0.0]
    parts[axis + 1] = functions.sin(0.5 * angle)
    return Vector(parts)


def _turn(axis: int, angle: Scalar, vector: Any) -> list[Scalar]:
    """Return the vector turned about a coordinate axis."""
    c, s = functions.cos(angle), functions.sin(angle)
    y, z = (axis + 1) % 3, (axis + 2) % 3
    turned = list(vector)
    turned[y], turned[z] = c * vector[y] - s * vector[z], s * vector[y] + c * vector[z]
    return turned


def _parity(i: int, j: int, k: int) -> int:
    return (i - j) * (j - k) * (k - i) // 2


def _reduced(angle: Any, period: float) -> tuple[Any, Any]:
    """Return the angle in [0, period) and the number of periods taken away."""
    turns = np.floor(angle / period)
    reduced = angle - period * turns
    over = reduced >= period  # an angle just below zero rounds up to a whole period
    return np.where(over, 0.0, reduced), turns + over
