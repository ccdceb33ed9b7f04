"""Noise of sensors from standard normal numbers: white noise of numbers, and random turns of attitudes."""

from __future__ import annotations

from poinsot import functions
from poinsot.functions import Scalar, Vector

__all__ = ["random_turn", "with_white_noise"]


def with_white_noise(values: Vector, deviation: Scalar | Vector, normals: Vector) -> Vector:
    """Return values with independent errors of a standard deviation, the same for all or one for each value."""
    return values + normals * deviation


def random_turn(deviation: Scalar | Vector, normals: Vector) -> Vector:
    """Return the unit quaternion of a turn by d = deviation normals about three axes, with the angle 2 atan(|d|/2)."""
    half = normals * (0.5 * deviation)
    size = functions.sqrt(1 + functions.dot(half, half))
    return Vector((1 / size, *(x / size for x in half)))
