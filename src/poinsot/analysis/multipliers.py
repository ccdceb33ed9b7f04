"""Floquet's multipliers of a period map, accurate where they coincide.

A symplectic matrix has its multipliers in pairs m, 1/m. Where two of them meet, at 1 or at -1, rounding e moves each by
sqrt(e), but their sum m + 1/m by e only: the sums are the roots of a polynomial whose coefficients are smooth
(Broucke 1969, AIAA J. 7, 1003, for the 4 x 4 matrix). A sum passes 2 where another branch crosses, -2 where the period
doubles, and two sums meet where two pairs leave the unit circle. Among an odd number one more is 1, that of a constant
such as the momentum of a wheel without friction. The multipliers of other matrices pass 1, -1 or the circle alone.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.immutable import cached_property

__all__ = ["MULTIPLIER_TOLERANCE", "Multipliers"]

Array = NDArray[Any]

MULTIPLIER_TOLERANCE = 1e-6
"""Angles and growth per period below this count as zero: where multipliers meet, they are not known better."""
UNPAIRED_TOLERANCE = 1e-13
"""The same of multipliers that do not meet their own reciprocals, and so are known to rounding."""
PALINDROME_TOLERANCE = 1e-9
"""By how much the characteristic polynomial of a symplectic matrix may differ from its mirror image, relatively."""
ROUNDING_PER_NORM = 2e-15
"""The same for each unit of the norm of the matrix: rounding does 8e-16 at most in 40 matrices of norms to 5e7."""
COEFFICIENT_ROUNDING = 1e-12
"""Rounding error of a coefficient of that polynomial, relative to its upper bound."""
MEETING_ROUNDING = 3e-15
"""The same where two sums meet away from 2 and -2.

Rounding takes a double multiplier with one eigenvector apart by 1.7e-16 at most in 2,000 matrices of norms below 5, by
4.5e-16 in 99 of 100 of norms to 95; two pairs at an angle of 0.006 that grow by 4e-4 are 9e-15 apart.
"""


class Multipliers:
    """The eigenvalues of a matrix.

    Parameters
    ----------
    matrix : array (k, k)
    paired : bool, optional
        Whether they come as m, 1/m. Default: what the matrix says.
    """

    def __init__(self, matrix: Array, paired: bool | None = None) -> None:
        self._raw = np.linalg.eigvals(matrix).astype(complex)
        single: Any = np.argmin(np.abs(self._raw - 1)) if len(matrix) % 2 else []
        pairs = np.delete(self._raw, single)
        polynomial = np.poly(pairs)
        alike = max(PALINDROME_TOLERANCE, ROUNDING_PER_NORM * float(np.linalg.norm(matrix, 2)))
        mirrored = np.max(np.abs(polynomial - polynomial[::-1])) <= alike * np.max(np.abs(polynomial))
        self.paired = bool(mirrored) if paired is None else paired
        self._unit = 2.0 if self.paired else 1.0
        self._roots = _sums(pairs) if self.paired else self._raw

    @cached_property
    def values(self) -> Array:
        """All, complex; those that cannot be told from 1 or -1 are it."""
        roots = _parted(self._roots) if self.paired else self._roots.copy()
        for sign in (1, -1):
            away = np.abs(roots - sign * self._unit)
            nearest = np.argsort(away)[: self.count_at(sign)]
            # Several slow ones multiply to less than rounding, though each is known.
            roots[nearest[away[nearest] < COEFFICIENT_ROUNDING * (2 + np.max(np.abs(roots))) ** 2]] = sign * self._unit
        return np.append(_pairs(roots), np.ones(self._raw.size % 2)) if self.paired else roots

    @cached_property
    def outside(self) -> Array:
        """How many are outside the unit circle: real above 1, real below -1, pairs of complex ones; (3,)."""
        out = self.values[np.log(np.abs(self.values)) > (MULTIPLIER_TOLERANCE if self.paired else UNPAIRED_TOLERANCE)]
        real = out[out.imag == 0].real
        return np.array([np.sum(real > 0), np.sum(real < 0), np.sum(out.imag > 0)])

    def count_at(self, sign: int) -> int:
        """Return how many pairs, or multipliers, cannot be told from 1 or from -1."""
        largest = float(np.prod(self._unit + np.abs(self._roots)))
        return int(np.argmin(np.abs(self._about(sign)) < COEFFICIENT_ROUNDING * largest))

    def beside(self, sign: int, known: int) -> float:
        """Return the product of the distances from 1 or -1, but for a known number that are there.

        It changes its sign where one more passes.
        """
        return float(self._about(sign)[known])

    def apart(self, known: int) -> float:
        """Return what changes its sign where complex ones leave the unit circle, but for a known number outside.

        Of pairs m, 1/m it is the discriminant of the sums, two of which meet.
        """
        if self.paired:
            return float(np.prod([(a - b) ** 2 for a, b in itertools.combinations(self._roots, 2)]).real)
        growth = np.sort(np.log(np.abs(self._raw[self._raw.imag > MULTIPLIER_TOLERANCE])))[::-1]
        return float(growth[known]) - UNPAIRED_TOLERANCE if known < growth.size else -UNPAIRED_TOLERANCE

    def _about(self, sign: int) -> Array:
        """Return the coefficients of the polynomial of the roots about 1 or -1, constant first."""
        return np.asarray(np.poly(self._roots - sign * self._unit).real[::-1])


def _sums(values: Array) -> Array:
    """Return m + 1/m of each of the pairs, from the larger of the two, which is known better."""
    left, sums = list(range(len(values))), []
    own, weight = values + 1 / values, np.abs(values) ** 2
    while left:
        first = left.pop(int(np.argmax(weight[left])))
        pair = [first, left.pop(int(np.argmin(np.abs(own[left] - own[first]))))]
        sums.append(np.average(own[pair], weights=weight[pair]))
    return np.array(sums)


def _parted(sums: Array) -> Array:
    """Return sums, real where two real ones could have them as they are rounded."""
    third = np.max(np.abs(sums[:, None] - sums), axis=-1)
    width = np.sqrt(MEETING_ROUNDING * np.prod(np.abs(sums) + 2) / np.maximum(third, COEFFICIENT_ROUNDING))
    return np.where(np.abs(sums.imag) < width, sums.real, sums).astype(complex)


def _pairs(sums: Array) -> Array:
    """Return m and 1/m of each sum; of a real one between -2 and 2 they are on the unit circle."""
    root = np.sqrt((sums / 2) ** 2 - 1)
    larger = np.where(np.abs(sums / 2 + root) >= np.abs(sums / 2 - root), sums / 2 + root, sums / 2 - root)
    circle = (sums.imag == 0) & (np.abs(sums.real) <= 2)
    return np.concatenate([larger, np.where(circle, larger.conj(), 1 / larger)])
