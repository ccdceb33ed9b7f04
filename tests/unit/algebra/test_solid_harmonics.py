"""Solid harmonics and their derivatives, on the functions that ship."""

import numpy as np
import pytest
import sympy
from scipy.special import lpmv

from poinsot.algebra.solid_harmonics import SolidHarmonics, derivative, exterior_field
from poinsot.taylor.graph import Graph, gradient

XYZ = sympy.symbols("x y z", real=True)
POINTS = np.random.default_rng(3).normal(size=(3, 40)) * [[1.0], [0.6], [1.4]]


def exact(polynomial):
    """A polynomial with its coefficients, fractions of powers of two, freed from rounding."""
    terms = sympy.Poly(sympy.expand(polynomial), *XYZ).as_dict()
    numerators = {powers: 2**10 * float(c) for powers, c in terms.items()}
    assert all(abs(n - round(n)) < 1e-12 * max(abs(n), 1) for n in numerators.values())
    return sum(
        sympy.Rational(round(n), 2**10) * sympy.prod(x**k for x, k in zip(XYZ, powers, strict=True))
        for powers, n in numerators.items()
    )


PAIRS = {(n, m): [exact(part) for part in SolidHarmonics(XYZ).pair(n, m)] for n in range(7) for m in range(n + 1)}


def unit_row(n, m, part):
    """The coefficients of degree n that are zero but for one."""
    return [tuple(float((k, p) == (m, part)) for p in (0, 1)) for k in range(n + 1)]


@pytest.mark.parametrize("n", range(9))
def test_values_are_those_of_legendre_functions(n):
    """r^n P_nm(z / r) (cos, sin)(m longitude), without the phase (-1)^m that SciPy's have."""
    r, longitude = np.linalg.norm(POINTS, axis=0), np.arctan2(POINTS[1], POINTS[0])
    harmonics, at_one = SolidHarmonics(POINTS), SolidHarmonics(POINTS / r, squared=1)
    for m in range(n + 1):
        legendre = (-1) ** m * lpmv(m, n, POINTS[2] / r)
        expected = np.array([legendre * np.cos(m * longitude), legendre * np.sin(m * longitude)])
        size = np.max(np.abs(legendre))
        assert np.allclose(
            np.broadcast_arrays(*harmonics.pair(n, m), r)[:2] / r**n, expected, rtol=0, atol=2e-14 * size
        )
        assert np.allclose(np.broadcast_arrays(*at_one.pair(n, m), r)[:2], expected, rtol=0, atol=2e-14 * size)


@pytest.mark.parametrize("key", PAIRS)
def test_each_is_a_solution_of_laplaces_equation(key):
    for polynomial in PAIRS[key]:
        assert sympy.expand(sum(sympy.diff(polynomial, x, 2) for x in XYZ)) == 0


@pytest.mark.parametrize("n", range(1, 7))
def test_a_derivative_is_a_sum_of_one_degree_less(n):
    for m in range(n + 1):
        for part in (0, 1) if m else (0,):
            for k, x in enumerate(XYZ):
                shipped = sum(
                    sympy.Rational(weight) * PAIRS[n - 1, order][p]
                    for order, weights in enumerate(derivative(unit_row(n, m, part), k))
                    for p, weight in enumerate(weights)
                )
                assert sympy.expand(shipped - sympy.diff(PAIRS[n, m][part], x)) == 0


@pytest.mark.parametrize("n", range(6))
def test_the_slope_of_an_exterior_harmonic_is_one_of_the_next_degree(n):
    """-d/dx of Z / r^(2n+1), times r^(2n+3): (2n + 1) x Z - r^2 dZ/dx."""
    squared = sum(x * x for x in XYZ)
    for m in range(n + 1):
        for part in (0, 1) if m else (0,):
            for k, x in enumerate(XYZ):
                shipped = sum(
                    sympy.Rational(weight) * PAIRS[n + 1, order][p]
                    for order, weights in enumerate(exterior_field(unit_row(n, m, part), k))
                    for p, weight in enumerate(weights)
                )
                own = PAIRS[n, m][part]
                assert sympy.expand(shipped - (2 * n + 1) * x * own + squared * sympy.diff(own, x)) == 0


def test_a_sum_is_derived_by_its_variables():
    """Against differences of polynomials of degree 5, exact but for rounding."""
    random = np.random.default_rng(1)
    row = [(c, s) for c, s in random.normal(size=(6, 2))]
    graph = Graph()
    vector = list(map(graph.variable, POINTS[:, 0]))
    traced = SolidHarmonics(vector).sum(row)
    value, *slopes = graph.evaluated([traced, *gradient(traced, vector)])
    assert value == pytest.approx(SolidHarmonics(POINTS[:, 0]).sum(row), rel=1e-14, abs=0)
    for k in range(3):
        line = sympy.Symbol("t")
        moved = [sympy.Float(float(x), 40) + (line if i == k else 0) for i, x in enumerate(POINTS[:, 0])]
        slope = float(sympy.diff(sympy.expand(SolidHarmonics(moved).sum(row)), line).subs(line, 0))
        assert slopes[k] == pytest.approx(slope, rel=1e-13, abs=0)


def test_what_no_variable_moves_has_no_derivative():
    assert isinstance(SolidHarmonics(POINTS[:, 0]).sum([(0.3, 0.0)]), float)
    vector = list(map(Graph().variable, POINTS[:, 0]))
    assert gradient(SolidHarmonics(vector).sum([(0.3, 0.0)]), vector) == [0, 0, 0]
