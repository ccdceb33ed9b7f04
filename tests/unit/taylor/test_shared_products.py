"""Integrals in the place of squares: the same rates for any norm, and only where the sum of squares does not change."""

import numpy as np
import pytest

from decompositions import rates
from poinsot.taylor.decomposition import Invariant, Product
from poinsot.taylor.graph import Graph
from poinsot.taylor.lowering import simplified


def turning(q, rates):
    """Return the rates of a quaternion that turns."""
    q0, q1, q2, q3 = q
    w1, w2, w3 = rates
    return [
        -0.5 * (q1 * w1 + q2 * w2 + q3 * w3),
        0.5 * (q0 * w1 + q2 * w3 - q3 * w2),
        0.5 * (q0 * w2 - q1 * w3 + q3 * w1),
        0.5 * (q0 * w3 + q1 * w2 - q2 * w1),
    ]


def diagonal(q):
    """Return the diagonal of the rotation matrix."""
    s0, s1, s2, s3 = (x * x for x in q)
    return [s0 + s1 - s2 - s3, s0 - s1 + s2 - s3, s0 - s1 - s2 + s3]


def entry(given, q, w):
    return [*turning(q, w), given(0) * diagonal(q)[2], w[0], given(0)]


def whole_diagonal(_, q, w):
    return [*turning(q, w), *diagonal(q)]


def of_rates_with_constants(given, q, w):
    return [*turning(q, [given(0) * w[0], w[1] + given(1), w[2]]), 2 * (given(0) * diagonal(q)[0]) + w[1], w[0], w[0]]


def norm(_, q, w):
    return [*turning(q, w), sum(x * x for x in q), w[0], w[0]]


def difference_of_two(_, q, w):
    return [*turning(q, w), q[0] * q[0] - q[1] * q[1], w[0], w[0]]


def with_products_of_squares(_, q, w):
    return [*turning(q, w), diagonal(q)[2] * w[0], w[0] * (q[0] * q[0]), w[0]]


def decaying(_, q, w):
    return [*[rate - 0.1 * x for rate, x in zip(turning(q, w), q, strict=True)], *diagonal(q)]


def with_another_sign(_, q, w):
    rates = turning(q, w)
    return [-rates[0], *rates[1:], *diagonal(q)]


FORMULAS = {
    entry: (2, 1),
    whole_diagonal: (3, 1),
    of_rates_with_constants: (2, 1),
    norm: (0, 1),
    difference_of_two: (2, 0),
    with_products_of_squares: (2, 1),
    decaying: (4, 0),
    with_another_sign: (4, 0),
}


def program_of(formula):
    graph = Graph()
    states = [graph.symbol(i) for i in range(7)]
    return simplified(formula(graph.input, states[:4], states[4:]))


@pytest.mark.parametrize("formula", FORMULAS)
def test_squares_are_left_out_where_their_sum_is_an_integral(formula):
    operations = program_of(formula).decomposition.operations
    squares = sum(isinstance(x, Product) and x.first == x.second for x in operations)
    assert (squares, sum(isinstance(x, Invariant) for x in operations)) == FORMULAS[formula]


@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.parametrize("length", [1.0, 1.7])
def test_rates_are_those_of_the_formula_whatever_the_norm(formula, length):
    program, numbers = program_of(formula), (0.8, -0.3)
    q, omega = length * np.array([0.5, -0.7, 0.1, 0.5]), np.array([0.4, -0.9, 0.6])
    got = rates(program, [*q, *omega], numbers)
    np.testing.assert_allclose(got, formula(numbers.__getitem__, q, omega), rtol=0, atol=4e-15)


def test_two_bodies_have_an_integral_each():
    graph = Graph()
    states = [graph.symbol(i) for i in range(14)]
    (q, w), (p, v) = ((some[:4], some[4:]) for some in (states[:7], states[7:]))
    rates = [*turning(q, w), *diagonal(p), *turning(p, v), *diagonal(q)]
    operations = simplified(rates).decomposition.operations
    assert sum(isinstance(x, Invariant) for x in operations) == 2
    assert sum(isinstance(x, Product) and x.first == x.second for x in operations) == 6
