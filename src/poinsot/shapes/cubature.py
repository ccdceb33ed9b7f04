"""Cubature rules that integrate polynomials exactly, and multipoles of point masses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.solid_harmonics import SolidHarmonics

__all__ = ["MAX_POINTS", "ball", "cylinder", "gravity_of_points", "multipoles", "triangle"]

Array = NDArray[np.float64]

MAX_POINTS = 4096
"""Largest number of points in one block, whose harmonics fit in the processor caches."""


def triangle(degree: int) -> tuple[Array, Array]:
    """Return weights (k,), of sum 1, and barycentric points (k, 3): means over a triangle, exact to the degree."""
    from scipy.special import roots_jacobi, roots_legendre

    (slow, across), (fast, along) = roots_jacobi(degree // 2 + 1, 1, 0), roots_legendre(degree // 2 + 1)
    u, v = (grid.ravel() for grid in np.meshgrid((1 + slow) / 2, (1 + fast) / 2, indexing="ij"))
    return np.outer(across, along).ravel() / 4, np.stack([u, (1 - u) * v, (1 - u) * (1 - v)], axis=-1)


def ball(degree: int) -> tuple[Array, Array]:
    """Return weights (k,), of sum 1, and points (k, 3): means over the unit ball, exact to the degree."""
    from scipy.special import roots_jacobi, roots_legendre

    squares, shells = roots_jacobi(degree // 4 + 1, 0, 0.5)  # means over a sphere are polynomials of r^2
    heights, zones = roots_legendre(degree // 2 + 1)
    radius, height, angle = np.meshgrid(np.sqrt((1 + squares) / 2), heights, _circle(degree), indexing="ij")
    across = radius * np.sqrt(1 - height * height)
    return _rule(np.outer(shells, zones), (across * np.cos(angle), across * np.sin(angle), radius * height))


def cylinder(degree: int) -> tuple[Array, Array]:
    """Return points and weights over the cylinder of radius 1 about the third axis between heights -1 and 1."""
    from scipy.special import roots_legendre

    squares, rings = roots_legendre(degree // 4 + 1)  # means over a ring are polynomials of rho^2
    heights, zones = roots_legendre(degree // 2 + 1)
    square, height, angle = np.meshgrid((1 + squares) / 2, heights, _circle(degree), indexing="ij")
    across = np.sqrt(square)
    return _rule(np.outer(rings, zones), (across * np.cos(angle), across * np.sin(angle), height))


def _circle(degree: int) -> Array:
    return 2 * np.pi * np.arange(degree + 1) / (degree + 1)


def _rule(weights: Array, coordinates: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    around = coordinates[0].shape[-1]
    return np.repeat(weights.ravel() / (around * weights.sum()), around), np.stack(
        [np.ravel(part) for part in coordinates], axis=-1
    )


def multipoles(masses: Array, points: Array, degree: int) -> NDArray[np.complex128]:
    """Return the sums of masses (k,) times the solid harmonics Z_nm of points (k, 3), rows n, columns m <= n."""
    total = np.zeros((degree + 1, degree + 1), dtype=complex)
    for start in range(0, len(masses), MAX_POINTS):
        part = slice(start, start + MAX_POINTS)
        harmonics = SolidHarmonics(tuple(points[part].T))
        for n in range(degree + 1):
            for m in range(n + 1):
                real, imaginary = map(np.asarray, harmonics.pair(n, m))
                total[n, m] += np.sum(masses[part] * real) + 1j * np.sum(masses[part] * imaginary)
    return total


def gravity_of_points(masses: Array, positions: Array, points: Array) -> tuple[Array, Array]:
    """Return potential (n,) and attraction (n, 3) of mass points at points (n, 3)."""
    potential, attraction = np.empty(len(points)), np.empty((len(points), 3))
    rows = max(1, 16 * MAX_POINTS // len(masses))
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        away = positions - points[part, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            distances = np.linalg.norm(away, axis=-1)
            potential[part] = np.sum(masses / distances, axis=-1)
            attraction[part] = np.einsum("nk,nki->ni", masses / distances**3, away)
    return potential, attraction
