"""Arithmetic of twice the double precision, against exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from poinsot.double_double import PI, DoubleDouble, pick

WIDE = 2.0**-102
lawful = settings(derandomize=True, deadline=None, database=None)
numbers = st.builds(
    lambda size, fine: DoubleDouble.difference(size, fine * size * 2.0**-54),
    st.floats(1e-8, 1e8) | st.floats(-1e8, -1e-8),
    st.floats(-1, 1),
)


def exact(number):
    return Fraction(float(number.hi)) + Fraction(float(number.lo))


def close(number, expected, size=None):
    return abs(exact(number) - expected) <= WIDE * abs(expected if size is None else size)


@lawful
@given(numbers, numbers)
def test_arithmetic_has_32_digits(a, b):
    x, y = exact(a), exact(b)
    assert close(a + b, x + y, abs(x) + abs(y) if x * y < 0 else None)
    assert close(a - b, x - y, abs(x) + abs(y) if x * y > 0 else None)
    assert close(a * b, x * y)
    assert close(a / b, x / y)


@lawful
@given(numbers, st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-6))
def test_doubles_take_part_on_either_side(a, b):
    x, y = exact(a), Fraction(b)
    assert close(b * a, x * y)
    assert close(a / b, x / y)
    assert close(b / a, y / x)
    assert exact(b - a) == -exact(a - b)
    assert exact(b + a) == exact(a + b)


@lawful
@given(st.floats(-1e300, 1e300), st.floats(-1e300, 1e300))
def test_a_difference_of_doubles_is_exact(a, b):
    assert exact(DoubleDouble.difference(a, b)) == Fraction(a) - Fraction(b)


@lawful
@given(st.floats(-1e100, 1e100), st.floats(-1e100, 1e100))
def test_a_product_of_doubles_is_exact(a, b):
    a, b = (0.0 if abs(x) < 1e-100 else x for x in (a, b))  # its error must not underflow
    assert exact(DoubleDouble(a) * b) == Fraction(a) * Fraction(b)


@lawful
@given(numbers)
def test_square_root(a):
    a = a if a.hi > 0 else -a
    root = exact(a.sqrt())
    assert abs(root * root / exact(a) - 1) <= 2 * WIDE


def test_square_root_of_zero_and_of_a_rounding_error_is_zero():
    assert exact(DoubleDouble(0.0).sqrt()) == 0
    assert exact(DoubleDouble(-1e-40).sqrt()) == 0


def test_arrays_are_done_entry_by_entry():
    a, b = np.array([0.1, 1e5, -3.0]), np.array([7.0, -0.3, 1e-9])
    together = DoubleDouble(a) * b + DoubleDouble.difference(b, a)
    for i in range(3):
        alone = DoubleDouble(a[i]) * b[i] + DoubleDouble.difference(b[i], a[i])
        assert exact(alone) == Fraction(together.hi[i]) + Fraction(together.lo[i])
    chosen = pick(np.array([True, False, True]), DoubleDouble(a), 2.0)
    assert list(chosen.hi) == [0.1, 2.0, -3.0]
    assert list(chosen.lo) == [0.0, 0.0, 0.0]


def test_pi():
    with mp.workdps(40):
        assert abs(mpf(PI.hi) + mpf(PI.lo) - mp.pi) < 3e-33


@pytest.mark.parametrize("power", [2.0**-70, 0.5, 2.0**33])
def test_scaling_by_a_power_of_two_is_exact(power):
    number = DoubleDouble(1.0) / 3.0
    assert exact(number.scaled(power)) == exact(number) * Fraction(power)
