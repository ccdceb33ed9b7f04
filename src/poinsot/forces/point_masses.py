"""Sums over point masses."""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.quantities import Array

__all__ = ["beyond_the_first", "inertia_of_points", "paired_sum"]

CENTRING_TOLERANCE = 1e-12
"""Tolerance of the centre of mass, relative to the distance of the farthest point, for rounding errors."""


def inertia_of_points(name: str, masses: Any, positions: Any) -> Array:
    """Return the inertia tensor, (3, 3) or (members, 3, 3), or raise a ValueError about points off their centre."""
    m, x = np.asarray(masses)[..., None], np.asarray(positions)
    centre = np.sum(m * x, axis=-2) / np.sum(m, axis=-2)
    farthest = np.max(np.linalg.norm(x, axis=-1), axis=-1)
    off = np.max(np.linalg.norm(centre, axis=-1) / np.where(farthest > 0, farthest, 1.0))
    if not off <= CENTRING_TOLERANCE:
        raise ValueError(
            f"{name} must be from the centre of mass, but it is off the origin by {off:.2g} of the farthest "
            "point. Subtract it."
        )
    products = np.swapaxes(m * x, -1, -2) @ x
    return np.asarray(np.trace(products, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - products)


def beyond_the_first(x: Scalar) -> tuple[Scalar, Scalar]:
    """Return 1 / sqrt(1 + x) - 1 + x / 2 and its derivative, as products without cancellation for small x."""
    root = functions.sqrt(1 + x)
    step, inverse = x / (1 + root), 1 / root  # step = root - 1
    return step * step * (0.5 + inverse), 0.5 * (step * inverse) * (1 + inverse + inverse * inverse)


def paired_sum(terms: list[Scalar]) -> Scalar:
    """Return the sum by pairs, so that the time to build an expression is nearly proportional to its terms."""
    while len(terms) > 1:
        terms = [sum(terms[i + 1 : i + 2], start=terms[i]) for i in range(0, len(terms), 2)]
    return terms[0]
