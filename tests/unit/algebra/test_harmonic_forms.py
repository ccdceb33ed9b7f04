"""Products and rotations of harmonic forms, against the polynomials that they stand for."""

from math import prod

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

from poinsot.algebra.harmonic_forms import TurnedForms, coefficients_of, form_of, product, turn_of
from poinsot.algebra.solid_harmonics import SolidHarmonics, derivative
from poinsot.taylor.graph import Graph, gradient

XYZ = sympy.symbols("x y z")
RANDOM = np.random.default_rng(5)
POINT = np.array([0.7, -0.4, 1.1])
TURN = Rotation.from_rotvec([0.7, -0.2, 1.1]).as_matrix()


def random_form(n):
    """Whole numbers, so that polynomials are exact."""
    c, s = RANDOM.integers(-9, 10, (2, n + 1))
    return [(int(c[m]), int(s[m]) if m else 0) for m in range(n + 1)]


def polynomial(form, x=XYZ):
    """Of which the form is, times (2 n - 1)!!."""
    return SolidHarmonics(x).sum(coefficients_of(form))


def odd_factorial(n):
    return prod(range(2 * n - 1, 0, -2))


def value(form, x):
    return float(polynomial(form, tuple(x)))


def slope(form, x):
    return np.array([SolidHarmonics(tuple(x)).sum(derivative(coefficients_of(form), k)) for k in range(3)], dtype=float)


@pytest.mark.parametrize("degrees", [(1, 1), (1, 2), (2, 2), (2, 3), (1, 5)])
def test_a_product_differs_from_its_harmonic_part_by_a_multiple_of_the_squared_radius(degrees):
    a, b = map(random_form, degrees)
    own, other = odd_factorial(degrees[0]) * odd_factorial(degrees[1]), odd_factorial(sum(degrees))
    whole = sympy.nsimplify(sympy.expand(polynomial(a) * polynomial(b)), rational=True) / own
    harmonic = sympy.nsimplify(sympy.expand(polynomial(product(a, b))), rational=True) / other
    rest = sympy.rem(sympy.expand(whole - harmonic), sum(x * x for x in XYZ), XYZ[0])
    assert max(map(abs, sympy.Poly(rest, *XYZ).coeffs())) < 1e-12 * max(map(abs, sympy.Poly(whole, *XYZ).coeffs()))


@pytest.mark.parametrize("n", range(1, 9))
def test_a_turned_form_has_the_values_of_the_body(n):
    form = random_form(n)
    turned = TurnedForms(TURN.T).turned(form)
    assert value(turned, POINT) == pytest.approx(value(form, TURN.T @ POINT), rel=1e-13 * n, abs=0)


@pytest.mark.parametrize("n", range(1, 9))
def test_a_small_turn_is_that_of_the_angular_momentum_operator(n):
    form = random_form(n)
    expected = -np.cross(POINT, slope(form, POINT))
    found = [value(turn_of(form, k), POINT) for k in range(3)]
    assert np.max(np.abs(found - expected)) < 1e-14 * n * np.max(np.abs(slope(form, POINT)))


@pytest.mark.parametrize("n", range(1, 7))
def test_derivatives_by_angles_and_by_the_axes(n):
    """Of the value at a point, by the coefficients of the turned form."""
    form = random_form(n)
    plain = TurnedForms(TURN.T).turned(form)
    expected = np.array([value(turn_of(plain, k), POINT) for k in range(3)])

    def slopes(forms, by):
        value = polynomial(forms.turned(form), tuple(POINT))
        return np.array(gradient(value, by), dtype=float)

    graph = Graph()
    angles = [graph.variable(0.0) for _ in range(3)]
    assert slopes(TurnedForms(TURN.T, angles), angles) == pytest.approx(expected, rel=1e-13, abs=0)
    entries = [graph.variable(x) for x in TURN.T.ravel()]
    by_entries = slopes(TurnedForms(np.reshape(entries, (3, 3))), entries).reshape(3, 3)
    assert np.cross(TURN.T, by_entries).sum(axis=0) == pytest.approx(expected, rel=1e-12, abs=0)


def test_coefficients_and_forms_are_inverse():
    row = [(0.3, 0.0), (0.1, -0.2), (0.05, 0.4), (0.7, 0.2)]
    assert np.allclose(coefficients_of(form_of(row)), row, rtol=1e-15, atol=0)
