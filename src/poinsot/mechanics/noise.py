"""Noise of attitude sensors: turns by small random vectors."""

from __future__ import annotations

from poinsot import functions
from poinsot.functions import Vector

__all__ = ["random_turn"]


def random_turn(errors: Vector) -> Vector:
    """Return the unit quaternion of a turn by a vector d of errors about three axes, with the angle 2 atan(|d|/2)."""
    half = 0.5 * errors
    size = functions.sqrt(1 + functions.dot(half, half))
    return Vector((1 / size, *(x / size for x in half)))
