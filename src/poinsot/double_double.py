"""Numbers of twice the double precision, as unevaluated sums of two doubles: scalars or arrays.

The error-free sum is Knuth's, the error-free product Dekker's with Veltkamp's splitting (Dekker 1971, Numer.
Math. 18, 224-242).
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["HALF_PI", "PI", "DoubleDouble", "exact_sum", "pick", "sum_of_ordered"]

SPLITTER = 2.0**27 + 1


class DoubleDouble:
    """Sum hi + lo with |lo| of at most half a unit in the last place of hi: 32 digits."""

    __array_ufunc__ = None  # the product of an array and a number calls __rmul__
    __slots__ = ("hi", "lo")

    def __init__(self, hi: Any, lo: Any = 0.0) -> None:
        self.hi, self.lo = hi, lo

    def __reduce__(self) -> tuple[Any, ...]:  # old protocols of pickle support no slots
        return type(self), (self.hi, self.lo)

    @property
    def _member_axes(self) -> dict[str, int]:
        return {"hi": 0, "lo": 0}

    def _with_values(self, *, hi: Any, lo: Any) -> DoubleDouble:
        return DoubleDouble(hi, lo)

    @classmethod
    def difference(cls, a: Any, b: Any) -> DoubleDouble:
        """Return a - b of doubles, exactly."""
        return cls(*exact_sum(a, -b))

    @classmethod
    def product(cls, a: Any, b: Any) -> DoubleDouble:
        """Return a b of doubles, exactly."""
        return cls(*_product(a, b))

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.hi, -self.lo)

    def __add__(self, other: Any) -> DoubleDouble:
        other = _wide(other)
        (high, low), (small, smaller) = exact_sum(self.hi, other.hi), exact_sum(self.lo, other.lo)
        high, low = sum_of_ordered(high, low + small)
        return DoubleDouble(*sum_of_ordered(high, low + smaller))

    __radd__ = __add__

    def __sub__(self, other: Any) -> DoubleDouble:
        return self + (-_wide(other))

    def __rsub__(self, other: Any) -> DoubleDouble:
        return _wide(other) + (-self)

    def __mul__(self, other: Any) -> DoubleDouble:
        other = _wide(other)
        high, low = _product(self.hi, other.hi)
        return DoubleDouble(*sum_of_ordered(high, low + (self.hi * other.lo + self.lo * other.hi)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> DoubleDouble:
        other = _wide(other)
        first = self.hi / other.hi
        high, low = _product(other.hi, first)  # next to self.hi, so that their difference is exact
        rest = ((self.hi - high) - low) + (self.lo - other.lo * first)
        return DoubleDouble(*sum_of_ordered(first, rest / other.hi))

    def __rtruediv__(self, other: Any) -> DoubleDouble:
        return _wide(other) / self

    def scaled(self, power_of_two: Any) -> DoubleDouble:
        """Return the product with a power of two, which is exact."""
        return DoubleDouble(self.hi * power_of_two, self.lo * power_of_two)

    def sqrt(self) -> DoubleDouble:
        """Return the square root; zero for a number that rounding made negative."""
        root = np.sqrt(np.maximum(self.hi, 0.0))
        high, low = _product(root, root)
        correction = (((self.hi - high) - low) + self.lo) / np.where(root > 0, 2 * root, 1.0)
        return DoubleDouble(*sum_of_ordered(root, np.where(root > 0, correction, 0.0)[()]))


PI = DoubleDouble(3.141592653589793, 1.2246467991473532e-16)
HALF_PI = PI.scaled(0.5)


def pick(condition: Any, a: Any, b: Any) -> DoubleDouble:
    """Return a where the condition holds and b elsewhere."""
    a, b = _wide(a), _wide(b)
    return DoubleDouble(np.where(condition, a.hi, b.hi)[()], np.where(condition, a.lo, b.lo)[()])


def _wide(number: Any) -> DoubleDouble:
    return number if isinstance(number, DoubleDouble) else DoubleDouble(number, 0.0)


def exact_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """Return the sum of doubles, and its rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def sum_of_ordered(a: Any, b: Any) -> tuple[Any, Any]:
    """Return the rounded sum and its rounding error, where |a| >= |b|."""
    total = a + b
    return total, b - (total - a)


def _product(a: Any, b: Any) -> tuple[Any, Any]:
    product = a * b
    a1, a2 = _split(a)
    b1, b2 = (a1, a2) if b is a else _split(b)
    return product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2


def _split(a: Any) -> tuple[Any, Any]:
    scaled = SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high
