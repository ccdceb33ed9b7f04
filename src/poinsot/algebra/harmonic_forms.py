"""Products and rotations of harmonic polynomials, which combine the multipoles of two bodies.

A form of degree n is the list of the pairs (c_m, s_m), m = 0 ... n, of the sum over m of c_m Re + s_m Im of
(n - m)! / (2 n - 1)!! Z_nm, with Z_nm the solid harmonics. A harmonic polynomial is determined by its values where
x^2 + y^2 + z^2 = 0. There the factor of (c_m, s_m) is (x + i y)^m z^(n - m). The form of the harmonic part of a product
is therefore the product of these powers with (x + i y) (x - i y) = -z^2, without other factors.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

from poinsot.functions import Scalar
from poinsot.taylor.graph import number, ruled

__all__ = ["Form", "TurnedForms", "coefficients_of", "form_of", "product", "sum_of"]

Form = Sequence[tuple[Scalar, Scalar]]


def form_of(coefficients: Form) -> Form:
    """Return the form of the sum over m of C_m Re Z_nm + S_m Im Z_nm, over (2 n - 1)!!; S_0 does not count."""
    factors = [1 / math.factorial(m) for m in range(len(coefficients))][::-1]
    return [(f * c, f * s if m else 0.0) for m, (f, (c, s)) in enumerate(zip(factors, coefficients, strict=True))]


def coefficients_of(form: Form) -> Form:
    """Return the pairs (C_m, S_m) of which `form_of` makes a form."""
    factors = [math.factorial(m) for m in range(len(form))][::-1]
    return [(f * c, f * s) for f, (c, s) in zip(factors, form, strict=True)]


def product(a: Form, b: Form) -> Form:
    """Return the harmonic part of a product."""
    total: list[tuple[Scalar, Scalar]] = [(0.0, 0.0)] * (len(a) + len(b) - 1)

    def add(order: int, factor: float, c: Scalar, s: Scalar) -> None:
        total[order] = total[order][0] + factor * c, total[order][1] + (factor * s if order else 0.0)

    for (i, (c, s)), (j, (d, t)) in itertools.product(enumerate(a), enumerate(b)):
        add(i + j, 0.5 if i and j else 1.0, c * d - s * t, c * t + s * d)
        if i and j:
            sign = (-1) ** min(i, j)
            add(abs(i - j), 0.5 * sign, c * d + s * t, (s * d - c * t) if i > j else (c * t - s * d))
    return total


class TurnedForms:
    """Forms of a rotated body along fixed axes.

    Derivatives are derivatives by a small rotation, which does not change the degree of a form. They hold for
    orthogonal axes.

    Parameters
    ----------
    axes : three of three scalars
        Axes of the body along the fixed axes.
    turn : three scalars, optional
        Angles of a small rotation of the body about the fixed axes; they are zero and serve derivatives.
    """

    def __init__(self, axes: Sequence[Sequence[Scalar]], turn: Sequence[Scalar] = (0.0, 0.0, 0.0)) -> None:
        entries = [x for axis in axes for x in axis]
        values = [number(x) for x in entries]
        self._angles = list(turn)
        if any(x is not value for x, value in zip(entries, values, strict=True)):
            self._angles = [turn[k] + ruled(0.0, entries, _Turn(k, axes)) for k in range(3)]
        self._x, self._y, self._z = ([(z, 0.0), (x, y)] for x, y, z in (values[:3], values[3:6], values[6:]))
        self._known: dict[tuple[int, int], tuple[Form, Form]] = {}

    def turned(self, form: Form) -> Form:
        """Return a form that is given along the axes of the body."""
        n = len(form) - 1
        columns = [
            (weight, column)
            for m, pair in enumerate(form)
            for weight, column in zip(pair[: m + 1], self._power(n, m), strict=False)
        ]
        values: list[Any] = [
            tuple(sum(weight * column[m][part] for weight, column in columns) for part in (0, 1)) for m in range(n + 1)
        ]
        slopes = [turn_of(values, k) for k in range(3)]

        def ruled_part(m: int, part: int) -> Scalar:
            return ruled(values[m][part], self._angles, lambda k: slopes[k][m][part])

        return [(ruled_part(m, 0), ruled_part(m, 1) if m else 0.0) for m in range(n + 1)]

    def _power(self, n: int, m: int) -> tuple[Form, Form]:
        """Return the real and the imaginary part of (x + i y)^m z^(n - m), x, y, z along the body."""
        if n == 1:
            return (self._x, self._y) if m else (self._z, [(0.0, 0.0)] * 2)
        if (n, m) not in self._known:
            degree = 1 if n < 4 or m % 2 else 2
            order = max(0, m - (n - degree))
            self._known[n, m] = _complex_product(self._power(degree, order), self._power(n - degree, m - order))
        return self._known[n, m]


class _Turn:
    """Derivatives of the angle of a small rotation about a fixed axis by the entries of the body's axes."""

    def __init__(self, k: int, axes: Sequence[Sequence[Scalar]]) -> None:
        self._k, self._axes = k, axes

    def __call__(self, entry: int) -> Scalar:
        axis, l = divmod(entry, 3)
        if l == self._k:
            return 0.0
        m = 3 - self._k - l
        sign = 0.5 if (m - self._k) % 3 == 1 else -0.5
        value: Scalar = sign * number(self._axes[axis][m])
        return value


def turn_of(form: Form, axis: int) -> Form:
    """Return the derivative of a form by the angle of a turn about an axis at rest, 0, 1, 2."""
    n = len(form) - 1
    if axis == 2:
        return [(-m * s, m * c) for m, (c, s) in enumerate(form)]
    out = []
    for m in range(n + 1):
        (c, s), (d, t) = (_two_sided(form, k) for k in (m - 1, m + 1))
        down, up = (n - m + 1) * (0.5 if m else 0.25), (n + m + 1) * (0.5 if m else 0.25)
        if axis == 0:
            out.append((down * s + up * t, -down * c - up * d))
        else:
            out.append((down * c - up * d, down * s - up * t))
    return [(c, s if m else 0.0) for m, (c, s) in enumerate(out)]


def _two_sided(form: Form, m: int) -> tuple[Scalar, Scalar]:
    """Return twice the coefficient of (x + i y)^m, or of (iy - x)^-m for negative m; 0 beyond the degree."""
    if m >= len(form):
        return 0.0, 0.0
    if m == 0:
        return 2 * form[0][0], 0.0
    c, s = form[abs(m)]
    return (c, s) if m > 0 else ((-1) ** m * c, (-1) ** m * -s)


def _complex_product(a: tuple[Form, Form], b: tuple[Form, Form]) -> tuple[Form, Form]:
    (p, q), (r, s) = a, b
    return sum_of(product(p, r), product(q, s), -1), sum_of(product(p, s), product(q, r))


def sum_of(a: Form, b: Form, factor: float = 1.0) -> Form:
    """Return one form and a factor times another one."""
    return [(c + factor * d, s + factor * t) for (c, s), (d, t) in zip(a, b, strict=True)]
