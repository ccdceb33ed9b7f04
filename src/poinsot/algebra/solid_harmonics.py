"""Solid harmonics, the polynomials of expansions of gravity fields, and their derivatives.

Z_nm = r^n P_nm(sin latitude) exp(i m longitude), not normalised, without the sign (-1)^m. A derivative of a sum of
degree n is a sum of degree n - 1, so that a torque costs as much as an energy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from poinsot.functions import Scalar
from poinsot.taylor.graph import number, ruled

__all__ = ["SolidHarmonics", "exterior_field"]

Coefficients = Sequence[tuple[Scalar, Scalar]]
"""(C_n0, S_n0), ..., (C_nn, S_nn) of one degree n, scalars of any kind."""


class SolidHarmonics:
    """Solid harmonics of a vector, each computed at its first use.

    Parameters
    ----------
    vector : three scalars
        Components of the vector, scalars of any kind.
    squared : scalar, optional
        Square of the length, if it is known: 1 for a direction. Derivatives are derivatives of the polynomials, and
        hold along a sphere.
    """

    def __init__(self, vector: Sequence[Scalar], squared: Scalar | None = None) -> None:
        self.vector = tuple(vector)
        self._x, self._y, self._z = x, y, z = tuple(map(number, self.vector))
        self.squared = x * x + y * y + z * z if squared is None else number(squared)
        self._known: dict[tuple[int, int], tuple[Scalar, Scalar]] = {(0, 0): (1.0, 0.0)}

    def pair(self, n: int, m: int) -> tuple[Scalar, Scalar]:
        """Return the real and the imaginary part of Z_nm of the values of the vector, 0 <= m <= n."""
        if (n, m) not in self._known:
            self._known[n, m] = self._next_of_diagonal(n) if n == m else self._next_of_column(n, m)
        return self._known[n, m]

    def _next_of_diagonal(self, n: int) -> tuple[Scalar, Scalar]:
        (a, b), k = self.pair(n - 1, n - 1), 2 * n - 1
        if n == 1:
            return self._x, self._y
        return k * (self._x * a - self._y * b), k * (self._x * b + self._y * a)

    def _next_of_column(self, n: int, m: int) -> tuple[Scalar, Scalar]:
        rise, fall = (2 * n - 1) / (n - m), (n + m - 1) / (n - m)
        before = [rise * (self._z * part) for part in self.pair(n - 1, m)]
        if n - 2 < m:
            return before[0], before[1]
        further = [fall * (self.squared * part) for part in self.pair(n - 2, m)]
        return before[0] - further[0], before[1] - further[1]

    def sum(self, coefficients: Coefficients) -> Scalar:
        """Return the sum over m of C_m Re Z_nm + S_m Im Z_nm, n the degree of the coefficients."""
        if len(coefficients) == 1:
            return coefficients[0][0]
        values = [(number(c), number(s)) for c, s in coefficients]

        def slope(k: int) -> Scalar:
            if k < 3:
                return self._value(derivative(values, k))
            m, part = divmod(k - 3, 2)
            return self.pair(len(values) - 1, m)[part]

        return ruled(self._value(values), (*self.vector, *(x for pair in coefficients for x in pair)), slope)

    def _value(self, coefficients: Coefficients) -> Scalar:
        total: Scalar = 0.0
        n = len(coefficients) - 1
        for m, weights in enumerate(coefficients):
            for weight, part in zip(weights[: m + 1], self.pair(n, m), strict=False):
                total = total + weight * part
        return total


def derivative(coefficients: Coefficients, component: int) -> Coefficients:
    """Return the coefficients, of degree n - 1, of the derivative of a sum along x, y or z (0, 1, 2).

    With D = d/dx + i d/dy: D Z_nm = -Z_(n-1)(m+1), D* Z_nm = (n + m)(n + m - 1) Z_(n-1)(m-1) and
    d/dz Z_nm = (n + m) Z_(n-1)m, where Z_(n-1)(-1) = -Z*_(n-1)1 / (n (n - 1)).
    """
    return _gathered(coefficients, component, _parts, len(coefficients) - 1)


def exterior_field(coefficients: Coefficients, component: int) -> Coefficients:
    """Return the coefficients, of degree n + 1, of minus the derivative of an exterior sum along x, y or z.

    Exterior harmonics are E_nm = Z_nm / r^(2n + 1). With D = d/dx + i d/dy: D E_nm = -E_(n+1)(m+1),
    D* E_nm = (n - m + 1)(n - m + 2) E_(n+1)(m-1) and d/dz E_nm = -(n - m + 1) E_(n+1)m, where
    E_n(-1) = -E*_n1 / (n (n + 1)) (Cunningham 1970).
    """
    return _gathered(coefficients, component, _exterior_parts, len(coefficients) + 1)


Parts = Callable[[int, int, Scalar, Scalar, int], Sequence[tuple[int, Scalar, Scalar]]]


def _gathered(coefficients: Coefficients, component: int, parts: Parts, count: int) -> Coefficients:
    """Return the coefficients of as many orders of the parts that a derivative of each term has."""
    n = len(coefficients) - 1
    found: list[tuple[Scalar, Scalar]] = [(0.0, 0.0)] * count
    for m, (c, s) in enumerate(coefficients):
        for order, more_c, more_s in parts(n, m, c, s if m else 0.0, component):
            if 0 <= order < count:
                here_c, here_s = found[order]
                found[order] = here_c + more_c, here_s + more_s if order else 0.0
    return found


def _exterior_parts(n: int, m: int, c: Scalar, s: Scalar, component: int) -> Sequence[tuple[int, Scalar, Scalar]]:
    """Return orders and coefficients of minus the derivative of c Re E_nm + s Im E_nm."""
    fall = n - m + 1
    if component == 2:
        return [(m, fall * c, fall * s)]
    down, up = -0.5 * fall * (fall + 1), 0.5 if m else 1.0
    if component == 0:
        return [(m + 1, up * c, up * s), (m - 1, down * c, down * s)]
    return [(m + 1, -up * s, up * c), (m - 1, down * s, -down * c)]


def _parts(n: int, m: int, c: Scalar, s: Scalar, component: int) -> Sequence[tuple[int, Scalar, Scalar]]:
    """Return orders and coefficients of the derivative of c Re Z_nm + s Im Z_nm."""
    if component == 2:
        return [(m, (n + m) * c, (n + m) * s)]
    down, up = 0.5 * (n + m) * (n + m - 1), -0.5 if m else -1.0
    if component == 0:
        return [(m + 1, up * c, up * s), (m - 1, down * c, down * s)]
    return [(m + 1, -up * s, up * c), (m - 1, down * s, -down * c)]
