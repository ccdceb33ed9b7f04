"""Small rotations of an attitude as rotation vectors along the body axes: q exp(theta / 2)."""

from __future__ import annotations

import numpy as np

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.quantities import Array

__all__ = ["cross_matrix", "difference", "jacobian", "rotated", "turn"]

SMALL_ANGLE = 1e-4
"""Angle in radians below which the next term of (a - sin a) / a^3 = 1/6 - a^2/120 is smaller than rounding."""


def rotated(q: Array, theta: Array) -> Array:
    """Return attitudes after rotations by vectors along the body axes, q exp(theta / 2); shapes (..., 4), (..., 3)."""
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    turned = quat.product(q, np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * theta], axis=-1))
    return np.asarray(turned / np.linalg.norm(turned, axis=-1, keepdims=True))


def difference(q: Array, other: Array) -> Array:
    """Return the rotation vector 2 log(q~ other) of the shorter turn from an attitude to another, body axes."""
    return quat.rotation_vector(quat.product(quat.conjugate(q), other))


def cross_matrix(vector: Array) -> Array:
    """Return the matrix [v x] of the cross product with a vector; shape (..., 3) -> (..., 3, 3)."""
    return -np.cross(np.asarray(vector)[..., None, :], np.eye(3))


def turn(theta: Array) -> Array:
    """Return exp(-[theta x]), which carries vectors to the axes after a rotation; shape (..., 3) -> (..., 3, 3)."""
    cross, angle = cross_matrix(theta), np.linalg.norm(theta, axis=-1)[..., None, None]
    return np.asarray(np.eye(3) - np.sinc(angle / np.pi) * cross + _versine(angle) * (cross @ cross))


def jacobian(theta: Array) -> Array:
    """Return the right Jacobian J of the rotation vector: exp((theta + d) / 2) = exp(theta / 2) exp(J d / 2).

    J = 1 - (1 - cos a)/a^2 [theta x] + (a - sin a)/a^3 [theta x]^2 with a = |theta|; shape (..., 3) -> (..., 3, 3).
    """
    cross, angle = cross_matrix(theta), np.linalg.norm(theta, axis=-1)[..., None, None]
    return np.asarray(np.eye(3) - _versine(angle) * cross + sine_defect_ratio(angle) * (cross @ cross))


def _versine(angle: Array) -> Array:
    """Return (1 - cos a) / a^2."""
    return np.asarray(0.5 * np.sinc(angle / (2 * np.pi)) ** 2)


def sine_defect_ratio(angle: Array) -> Array:
    """Return (a - sin a) / a^3."""
    small = angle < SMALL_ANGLE
    regular = np.where(small, 1.0, angle)
    defect: Array = np.asarray(functions.sine_defect(regular))
    return np.where(small, 1 / 6 - angle**2 / 120, defect / regular**3)
