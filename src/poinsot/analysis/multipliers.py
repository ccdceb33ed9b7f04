"""Floquet's multipliers of a period map, accurate where they coincide.

A symplectic matrix has its multipliers in pairs m, 1/m. Where two of them meet, at 1 or at -1, rounding e moves each by
sqrt(e), but their sum m + 1/m by e only: the sums are the roots of a polynomial whose coefficients are smooth
(Broucke 1969, AIAA J. 7, 1003, for the 4 x 4 matrix). A sum passes 2 where another branch crosses, -2 where the period
doubles, and two sums meet where two pairs leave the unit circle. In an odd number of multipliers one is 1, which
belongs to a constant such as the momentum of a wheel without friction. The multipliers of other matrices pass 1, -1 or
the circle one by one.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from poinsot.immutable import cached_property
from poinsot.quantities import Array

__all__ = ["MULTIPLIER_TOLERANCE", "Multipliers"]

MULTIPLIER_TOLERANCE = 1e-6
"""Angle and growth per period below which a multiplier counts as 1, for multipliers that may meet."""
UNPAIRED_TOLERANCE = 1e-13
"""Growth per period below which a multiplier without a reciprocal partner counts as 1: it is exact to rounding."""
PALINDROME_TOLERANCE = 1e-9
"""Relative tolerance of the symmetry of the characteristic polynomial of a symplectic matrix."""
ROUNDING_PER_NORM = 2e-15
"""Tolerance of this symmetry divided by the norm of the matrix; rounding causes at most 8e-16 in 40 matrices."""
COEFFICIENT_ROUNDING = 1e-12
"""Rounding error of a coefficient of that polynomial, relative to its upper bound."""
MEETING_ROUNDING = 3e-15
"""Relative distance below which two sums away from 2 and -2 are equal.

Rounding separates a double multiplier with one eigenvector by 1.7e-16 at most in 2,000 matrices of norms below 5, and
by 4.5e-16 in 99 of 100 of norms to 95. Two pairs at an angle of 0.006 that grow by 4e-4 are 9e-15 apart.
"""


class Multipliers:
    """Eigenvalues of a matrix.

    Parameters
    ----------
    matrix : array (k, k)
    paired : bool, optional
        True if the eigenvalues are pairs m, 1/m. Default: True for a symplectic matrix.
    """

    def __init__(self, matrix: Array, paired: bool | None = None) -> None:
        self._raw = np.linalg.eigvals(matrix).astype(complex)
        single: Any = np.argmin(np.abs(self._raw - 1)) if len(matrix) % 2 else []
        pairs = np.delete(self._raw, single)
        polynomial = np.poly(pairs)
        tolerance = max(PALINDROME_TOLERANCE, ROUNDING_PER_NORM * float(np.linalg.norm(matrix, 2)))
        mirrored = np.max(np.abs(polynomial - polynomial[::-1])) <= tolerance * np.max(np.abs(polynomial))
        self.paired = bool(mirrored) if paired is None else paired
        self._unit = 2.0 if self.paired else 1.0
        self._roots = _sums(pairs) if self.paired else self._raw

    @cached_property
    def values(self) -> Array:
        """All multipliers, complex; a multiplier that is 1 or -1 up to rounding is exactly 1 or -1."""
        roots = _parted(self._roots) if self.paired else self._roots.copy()
        for sign in (1, -1):
            away = np.abs(roots - sign * self._unit)
            nearest = np.argsort(away)[: self.count_at(sign)]
            # The product of several slow multipliers is below rounding, though each one is accurate.
            roots[nearest[away[nearest] < COEFFICIENT_ROUNDING * (2 + np.max(np.abs(roots))) ** 2]] = sign * self._unit
        return np.append(_pairs(roots), np.ones(self._raw.size % 2)) if self.paired else roots

    @cached_property
    def outside(self) -> Array:
        """Numbers of multipliers outside the unit circle: real above 1, real below -1, complex pairs; (3,)."""
        out = self.values[np.log(np.abs(self.values)) > (MULTIPLIER_TOLERANCE if self.paired else UNPAIRED_TOLERANCE)]
        real = out[out.imag == 0].real
        return np.array([np.sum(real > 0), np.sum(real < 0), np.sum(out.imag > 0)])

    def count_at(self, sign: int) -> int:
        """Return the number of pairs, or multipliers, that are 1 or -1 up to rounding."""
        largest = float(np.prod(self._unit + np.abs(self._roots)))
        return int(np.argmin(np.abs(self._about(sign)) < COEFFICIENT_ROUNDING * largest))

    def distance(self, sign: int, known: int) -> float:
        """Return the product of the distances from 1 or -1, except for a known number of multipliers that are there.

        The product changes its sign where one more multiplier passes.
        """
        return float(self._about(sign)[known])

    def apart(self, known: int) -> float:
        """Return a function that changes its sign where one more complex pair than the known number leaves the circle.

        For pairs m, 1/m it is the discriminant of the sums, two of which meet.
        """
        if self.paired:
            return float(np.prod([(a - b) ** 2 for a, b in itertools.combinations(self._roots, 2)]).real)
        growth = np.sort(np.log(np.abs(self._raw[self._raw.imag > MULTIPLIER_TOLERANCE])))[::-1]
        return float(growth[known]) - UNPAIRED_TOLERANCE if known < growth.size else -UNPAIRED_TOLERANCE

    def _about(self, sign: int) -> Array:
        """Return the coefficients of the polynomial of the roots about 1 or -1, constant first."""
        return np.asarray(np.poly(self._roots - sign * self._unit).real[::-1])


def _sums(values: Array) -> Array:
    """Return m + 1/m of each pair, from the larger multiplier, which is more accurate."""
    left, sums = list(range(len(values))), []
    own, weight = values + 1 / values, np.abs(values) ** 2
    while left:
        first = left.pop(int(np.argmax(weight[left])))
        pair = [first, left.pop(int(np.argmin(np.abs(own[left] - own[first]))))]
        sums.append(np.average(own[pair], weights=weight[pair]))
    return np.array(sums)


def _parted(sums: Array) -> Array:
    """Return sums, real where they are a rounding away from two real sums."""
    third = np.max(np.abs(sums[:, None] - sums), axis=-1)
    width = np.sqrt(MEETING_ROUNDING * np.prod(np.abs(sums) + 2) / np.maximum(third, COEFFICIENT_ROUNDING))
    return np.where(np.abs(sums.imag) < width, sums.real, sums).astype(complex)


def _pairs(sums: Array) -> Array:
    """Return m and 1/m of each sum, on the unit circle for a real sum between -2 and 2."""
    root = np.sqrt((sums / 2) ** 2 - 1)
    larger = np.where(np.abs(sums / 2 + root) >= np.abs(sums / 2 - root), sums / 2 + root, sums / 2 - root)
    circle = (sums.imag == 0) & (np.abs(sums.real) <= 2)
    return np.concatenate([larger, np.where(circle, larger.conj(), 1 / larger)])
