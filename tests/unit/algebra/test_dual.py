"""Derivatives of formulas, carried through by the rules of calculus."""

import heyoka as hy
import mpmath
import numpy as np
import pytest
import sympy

from poinsot import functions
from poinsot.algebra import dual

X, Y = 0.3, 0.7
FORMULAS = {
    "sum": lambda x, y: 2 + x + y + x - 1,
    "difference": lambda x, y: 3 - x - (y - x) - y,
    "negative": lambda x, y: -x * y,
    "product": lambda x, y: 2 * x * y * x,
    "square": lambda x, y: x * x + y,
    "quotient": lambda x, y: x / y + 2 / x - y / 3,
    "integer_power": lambda x, y: x**3 + y**-2,
    "real_power": lambda x, y: x**0.5 * y**1.7,
    "power_of_two_variables": lambda x, y: x**y,
    "power_of_a_number": lambda x, y: 2.0**x * y,
    "norm": lambda x, y: functions.norm((x, y, 2.0)),
    "atan2": lambda x, y: functions.atan2(x, y) + functions.atan2(-1.0, x),
    "where": lambda x, y: functions.where(functions.less(x, y), x * y, x - y),
    "where_other": lambda x, y: functions.where(functions.less(y, x), x * y, x - y),
    **{
        name: lambda x, y, name=name: getattr(functions, name)(x * y) + x
        for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "asin", "acos", "atan")
    },
    "where_abs": lambda x, y: abs(x - y) * y + functions.sign(x - y) * x,
    "where_limits": lambda x, y: functions.minimum(x, y) * functions.maximum(x * x, y) + functions.clip(x * y, 0.5, 1),
    "where_table": lambda x, y: functions.interp(x * y, (0, 0.2, 0.3), (1, 2, 5)) * x,
    "power_zero": lambda x, y: (x * y) ** 0 + x**1,
}


def gradient(formula, x, y):
    seeds = dual.seeded((x, y), "u")
    result = formula(*seeds)
    return [dual.partial(result, "u", index) for index in range(2)]


@pytest.mark.parametrize("name", FORMULAS)
def test_derivative_against_forty_digit_differences(name):
    formula = FORMULAS[name]
    with mpmath.workdps(40):
        x, y = mpmath.mpf(X), mpmath.mpf(Y)
        expected = [float(mpmath.diff(formula, (x, y), order)) for order in ((1, 0), (0, 1))]
    assert gradient(formula, X, Y) == pytest.approx(expected, rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("name", [name for name in FORMULAS if not name.startswith("where")])
def test_derivative_in_symbols(name):
    formula, (x, y) = FORMULAS[name], sympy.symbols("x y", positive=True)
    expected = [sympy.diff(formula(x, y), symbol) for symbol in (x, y)]
    for found, exact in zip(gradient(formula, x, y), expected, strict=True):
        assert float((sympy.sympify(found) - exact).subs({x: X, y: Y})) == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("name", FORMULAS)
def test_derivative_of_heyoka_expressions(name):
    x, y = hy.make_vars("x", "y")
    found = [hy.expression(0.0) + component for component in gradient(FORMULAS[name], x, y)]
    values = hy.cfunc(found, vars=[x, y])(np.array([X, Y]))
    assert np.allclose(values, gradient(FORMULAS[name], X, Y), rtol=1e-14, atol=1e-15)


def test_derivative_of_arrays():
    x = np.array([0.3, 0.4, 0.5])
    found = gradient(lambda x, y: functions.sin(x) * y, x, 2.0)
    assert np.allclose(found[0], 2 * np.cos(x), rtol=1e-15)


def test_value_is_carried_along():
    x, y = dual.seeded((X, Y), "u")
    assert (functions.exp(x) * y).value == np.exp(X) * Y


def test_derivative_of_a_constant_is_zero():
    assert dual.partial(2.5, "u", 0) == 0
    assert dual.partial(dual.seeded((X, Y), "u")[0], "other", 0) == 0


def test_vectors_of_duals():
    u = functions.Vector((1.0, 2.0, 3.0))
    seeds = dual.seeded((X, Y, 0.1), "u")
    result = functions.dot(2 * (u * seeds), functions.cross(u, seeds) + u)
    numbers = functions.Vector((X, Y, 0.1))
    expected = functions.dot(2 * (u * numbers), functions.cross(u, numbers) + u)
    assert result.value == pytest.approx(expected, rel=1e-15)
    assert (X * seeds)[1].value == X * Y
    assert (seeds[0] * u)[2].value == 3 * X


def test_a_dual_has_no_truth():
    with pytest.raises(TypeError):
        bool(dual.seeded((X,), "u")[0])


@pytest.mark.parametrize(("e", "M"), [(0.1, 0.7), (0.6, -2.0), (0.9, 3.0)])
def test_eccentric_anomaly_by_eccentricity_and_by_mean_anomaly(e, M):
    given = dual.seeded((e, M), "x")
    found = functions.eccentric_anomaly(*given)
    h = 1e-5
    by_e, by_M = (
        (functions.eccentric_anomaly(e + de, M + dM) - functions.eccentric_anomaly(e - de, M - dM)) / (2 * h)
        for de, dM in ((h, 0.0), (0.0, h))
    )
    assert dual.partial(found, "x", 0) == pytest.approx(by_e, rel=1e-8)
    assert dual.partial(found, "x", 1) == pytest.approx(by_M, rel=1e-8)
