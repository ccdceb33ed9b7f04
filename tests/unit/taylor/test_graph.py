"""Graphs of formulas: their derivatives and values, on every kind of scalar."""

import gc
import weakref
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot import functions
from poinsot.algebra.solid_harmonics import SolidHarmonics
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.taylor.graph import PARTIALS, Graph, Node, gradient, number, ordered, ruled, tangents

X, Y = 0.3, 0.7
OPERATIONS = {
    "add": lambda x, y: x + y,
    "neg": lambda x, _: -x,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "pow": lambda x, y: x**-1.7 + y**-3,
    "atan2": functions.atan2,
    "eccentric_anomaly": functions.eccentric_anomaly,
    "sine_defect": lambda x, y: functions.sine_defect(x) * functions.sine_defect(3 * y),
    "asinh_defect": lambda x, y: functions.asinh_defect(x) * functions.asinh_defect(4 * y),
}
FORMULAS = {
    **{name: OPERATIONS.get(name, lambda x, y, name=name: getattr(functions, name)(x * y) + x) for name in PARTIALS},
    "sum": lambda x, y: 2 + x + y + x - 1,
    "difference": lambda x, y: 3 - x - (y - x) - y,
    "negative": lambda x, y: -x * y - (-y) * (-x) / -(x + 2),
    "product": lambda x, y: 2 * x * (3 * y) * x,
    "square": lambda x, y: x * x + y,
    "quotient": lambda x, y: x / y + 2 / x - y / 4,  # numbers that are floats: a derivative has 1 / 4
    "whole_power": lambda x, y: x**3 + y**11 + (x * y) ** 0 + x**1,
    "root_as_power": lambda x, y: x**0.5 * y**1.7,
    "power_of_two_variables": lambda x, y: x**y,
    "norm": lambda x, y: functions.norm((x, y, 2.0)),
    "atan2_of_numbers": lambda x, y: functions.atan2(-1.0, x) + functions.atan2(y, -2),
    "where": lambda x, y: functions.where(functions.less(x, y), x * y, x - y),
    "where_other": lambda x, y: functions.where(functions.less(y, x), x * y, 2.5) + x,
    "where_abs": lambda x, y: abs(x - y) * y + functions.sign(x - y) * x,
    "where_limits": lambda x, y: functions.minimum(x, y) * functions.maximum(x * x, y) + functions.clip(x * y, 0.5, 1),
    "where_table": lambda x, y: functions.interp(x * y, (0, 0.2, 0.3), (1, 2, 5)) * x,
    "none": lambda *_: 2.5,
}
each = pytest.mark.parametrize("name", FORMULAS)


def traced(formula, count=2):
    graph = Graph()
    symbols = [graph.symbol(i) for i in range(count)]
    return graph, symbols, formula(*symbols)


def by_gradient(formula, *values):
    """The derivatives of a formula by its arguments, at values of any kind."""
    graph, symbols, output = traced(formula, len(values))
    return graph.evaluated(gradient(output, symbols), dict(zip(symbols, values, strict=True)))


def by_tangents(formula, *values):
    graph, symbols, output = traced(formula, len(values))
    slopes = [tangents([output], {symbol: 1.0})[0] for symbol in symbols]
    return graph.evaluated(slopes, dict(zip(symbols, values, strict=True)))


def differences(formula, *values):
    """The same by differences of numbers with many more digits."""
    orders = np.eye(len(values), dtype=int).tolist()
    return [mpmath.diff(formula, values, tuple(order)) for order in orders]


def close(found, expected, digits):
    return all(abs(a - b) < mpmath.mpf(10) ** -digits * (1 + abs(b)) for a, b in zip(found, expected, strict=True))


@each
@pytest.mark.parametrize("ways", [by_gradient, by_tangents])
def test_derivative_against_forty_digit_differences(ways, name):
    formula = FORMULAS[name]
    with mpmath.workdps(40):
        x, y = mpmath.mpf(X), mpmath.mpf(Y)
        assert close(ways(formula, x, y), differences(formula, x, y), 30)


def test_derivative_of_a_power_of_a_number():
    found = by_gradient(lambda x, y: 2.0**x * y, X, Y)
    assert found == pytest.approx([np.log(2) * 2**X * Y, 2**X], rel=1e-15, abs=0)


def test_derivative_by_an_exponent_of_a_run():
    graph = Graph()
    x, power = graph.symbol("x"), graph.input(0)
    found = graph.evaluated(gradient(x**power, [x, power]), {x: X, power: 1.3})
    assert found == pytest.approx([1.3 * X**0.3, np.log(X) * X**1.3], rel=4e-15, abs=0)


@each
def test_value_is_that_of_the_formula(name):
    graph, symbols, output = traced(FORMULAS[name])
    (found,) = graph.evaluated([output], dict(zip(symbols, (X, Y), strict=True)))
    assert found == pytest.approx(FORMULAS[name](X, Y), rel=4e-15, abs=0)


@pytest.mark.parametrize("name", [name for name in FORMULAS if not name.startswith(("where", "ecc"))])
def test_derivative_in_symbols(name):
    formula, (x, y) = FORMULAS[name], sympy.symbols("x y", positive=True)
    expected = [sympy.diff(formula(x, y), symbol) for symbol in (x, y)]
    for found, exact in zip(by_gradient(formula, x, y), expected, strict=True):
        assert float((sympy.sympify(found) - exact).subs({x: X, y: Y})) == pytest.approx(0, abs=1e-13)


@each
def test_derivative_of_arrays_and_long_doubles(name):
    x = np.array([0.3, 0.4, 0.5])
    found = np.array([np.broadcast_to(row, 3) for row in by_gradient(FORMULAS[name], x, Y)])
    assert np.allclose(found.T, [by_gradient(FORMULAS[name], each, Y) for each in x], rtol=4e-15, atol=1e-15)
    wide = by_gradient(FORMULAS[name], np.longdouble(X), np.longdouble(Y))
    with mpmath.workdps(40):
        digits = -int(np.log10(np.finfo(np.longdouble).eps)) - 2
        assert close(
            [mpmath.mpf(str(x)) for x in wide], differences(FORMULAS[name], mpmath.mpf(X), mpmath.mpf(Y)), digits
        )


ONE = {
    "sin": functions.sin,
    "atan": functions.atan,
    "tanh": functions.tanh,
    "exp of sin": lambda u: functions.exp(functions.sin(u)),
    "root": lambda u: functions.sqrt(1 + u * u),
    "log": lambda u: functions.log(2 + u**2),
    "cube": lambda u: functions.cos(u) ** 3,
    "power": lambda u: (1.5 + functions.sin(u)) ** -0.7,
    "negative": lambda u: -u,
    "numbers": lambda u: 3 - 0.5 * u / 8,
    "number over": lambda u: 2 / (2 + functions.cos(u)),
}
TWO = {
    "add": lambda u, v: u + v,
    "sub": lambda u, v: u - v,
    "mul": lambda u, v: u * v,
    "div": lambda u, v: u / (1 + v * v),
    "where": lambda u, v: functions.where(functions.less(u, v), u * v, u - 2 * v),
    "atan2": lambda u, v: functions.atan2(u, 2 + functions.cos(v)),
}
TREES = st.recursive(
    st.sampled_from([0, 1]),
    lambda trees: (
        st.tuples(st.sampled_from(sorted(ONE)), trees) | st.tuples(st.sampled_from(sorted(TWO)), trees, trees)
    ),
    max_leaves=12,
)


def built(tree, scalars):
    if not isinstance(tree, tuple):
        return scalars[tree]
    name, *operands = tree
    operations: dict[str, Any] = {**ONE, **TWO}
    return operations[name](*(built(operand, scalars) for operand in operands))


@settings(max_examples=60, deadline=None)
@given(tree=TREES)
def test_derivatives_of_any_formula(tree):
    def formula(*scalars):
        return built(tree, scalars)

    with mpmath.workdps(40):
        values = mpmath.mpf("0.31"), mpmath.mpf("-0.72")
        expected = differences(formula, *values)
        assert close(by_gradient(formula, *values), expected, 28)
        assert close(by_tangents(formula, *values), expected, 28)


# ---------------------------------------------------------------------- second derivatives


def smooth(x, y):
    return functions.sin(x * y) / (1 + x * x) + functions.sqrt(y) * functions.exp(x - y) + x**3


@pytest.mark.parametrize(("i", "j"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_second_derivatives_by_a_trace_in_a_trace_and_by_tangents_of_tangents(i, j):
    graph, symbols, output = traced(smooth)
    inner = Graph()
    nested = [inner.variable(symbol) for symbol in symbols]
    (slope,) = inner.evaluated([gradient(smooth(*nested), nested)[i]])
    ways = [gradient(slope, symbols)[j]]
    (changed,) = tangents([output], {symbols[i]: 1.0})
    ways += tangents([changed], {symbols[j]: 1.0})
    with mpmath.workdps(40):
        x, y = mpmath.mpf(X), mpmath.mpf(Y)
        found = graph.evaluated(ways, dict(zip(symbols, (x, y), strict=True)))
        order = np.eye(2, dtype=int)[i] + np.eye(2, dtype=int)[j]
        assert close(found, [mpmath.diff(smooth, (x, y), tuple(order.tolist()))] * 2, 28)


def test_tangents_begin_at_any_node_whatever_it_is_computed_from():
    graph, (x, y), _ = traced(smooth)
    product = x * y
    first, second = graph.symbol("first"), graph.symbol("second")
    (change,) = tangents([functions.sin(product) * x], {product: first})
    (both,) = tangents([functions.sin(product) * x], {x: 1.0, product: first})
    (bend,) = tangents([change], {product: second, first: 0.5})
    found = graph.evaluated([change, both, bend], {x: X, y: Y, first: 2.0, second: 3.0})
    sine, cosine = np.sin(X * Y), np.cos(X * Y)
    expected = [cosine * X * 2.0, cosine * X * 2.0 + sine, (-sine * 3.0 * 2.0 + cosine * 0.5) * X]
    assert found == pytest.approx(expected, rel=1e-15, abs=0)


# ---------------------------------------------------------------------- closed rules


def test_solid_harmonics_have_a_closed_derivative():
    row = [(0.3, 0.0), (-0.2, 0.7), (0.5, 0.1), (0.9, -0.4)]
    place = X, Y, -0.4

    def harmonic(*vector):
        return SolidHarmonics(vector).sum(row) + vector[0] * vector[2]

    _, _, output = traced(harmonic, 3)
    assert "ruled" in {node.name for node in ordered([output])}
    with mpmath.workdps(40):
        exact = [mpmath.mpf(x) for x in place]
        expected = differences(harmonic, *exact)
        assert close(by_gradient(harmonic, *exact), expected, 15)  # weights are floats
        assert close(by_tangents(harmonic, *exact), expected, 15)


def test_rules_of_one_value_are_others():
    _, (x, y), _ = traced(smooth)
    first, second = (ruled(0.0, (x, y), lambda k, each=each: each[k]) for each in ((1.0, 2.0), (3.0, 4.0)))
    assert gradient(first, [x, y]) == [1.0, 2.0]
    assert gradient(second, [x, y]) == [3.0, 4.0]
    assert ruled(2.5, (X, Y), lambda _: 1.0) == 2.5


# ---------------------------------------------------------------------- graphs


@each
def test_the_same_formula_twice_gives_no_new_node(name):
    graph, symbols, output = traced(FORMULAS[name])
    before = {node.place for node in ordered([output])}
    again = FORMULAS[name](*symbols)
    assert again is output or not isinstance(output, Node)
    assert {node.place for node in ordered([again, graph.symbol(0)])} <= before | {symbols[0].place}


def test_composite_and_products_are_the_same_in_either_order():
    _, (x, y), _ = traced(smooth)
    assert x + y is y + x
    assert x * y is y * x
    assert x - y is not y - x


def test_numbers_with_more_digits_are_others():
    graph, (x, _), _ = traced(smooth)
    with mpmath.workdps(40):
        (_, found) = graph.evaluated([0.1 * x, 0.7 * (mpmath.mpf(0.1) * x)], {x: mpmath.mpf(1)})
        assert found == mpmath.mpf(0.7) * mpmath.mpf(0.1)


def test_nodes_of_another_graph_are_constants():
    older, (x, y), _ = traced(smooth)
    newer = Graph()
    u, v = (newer.variable(value) for value in (2.0, 3.0))
    output = u * functions.sin(x) + v * x * y
    assert output.graph is newer
    by_u, by_v = newer.evaluated(gradient(output, [u, v]))
    assert by_u is functions.sin(x)
    assert by_v is x * y
    assert newer.evaluated([output])[0].graph is older


def test_what_does_not_depend_on_a_graph_has_no_derivative_in_it():
    older, (x, y), output = traced(smooth)
    newer = Graph()
    variables = [newer.variable(value) for value in range(40)]  # with places as those of the older nodes
    assert gradient(output, variables) == [0.0] * 40
    assert tangents([output, 2.5], dict.fromkeys(variables, 1.0)) == [0.0, 0.0]
    assert newer.evaluated([output, 2.5, variables[7]]) == [output, 2.5, 7]
    assert gradient(2.5, [x, y]) == [0.0, 0.0]
    assert gradient(output, []) == []
    assert older is not newer


def test_number_of_what_depends_on_variables_alone():
    outer, inner = Graph(), Graph()
    assert number(inner.variable(outer.variable(2.0) + 1) * 3) == 9.0
    assert number(2.5) == 2.5
    symbol = inner.symbol("x")
    assert number(symbol) is symbol
    mixed = inner.variable(2.0) * symbol
    assert number(mixed) is mixed


def test_a_finished_graph_holds_nothing():
    gc.disable()
    try:
        array = np.ones(3)
        alive, graph = weakref.ref(array), Graph()
        variable = graph.variable(array)
        (found,) = graph.finished(gradient(variable * variable, [variable]))
        assert np.array_equal(found, 2 * array)
        del array, variable, graph
        assert alive() is None
    finally:
        gc.enable()


# ---------------------------------------------------------------------- arrays and vectors


def test_nodes_together_with_arrays_and_vectors():
    graph, (x, y), _ = traced(smooth)
    array, vector = np.array([1.0, 2.0]), functions.Vector((1.0, 2.0, 3.0))
    outputs = [array * x, x / array, array - y, np.float64(2) ** x, (x * vector)[2], functions.dot(vector, (x, y, x))]
    found = graph.evaluated(outputs, {x: X, y: Y})
    expected = [array * X, X / array, array - Y, 2**X, X * 3, 4 * X + 2 * Y]
    assert all(np.allclose(a, b, rtol=1e-15, atol=0) for a, b in zip(found, expected, strict=True))


def test_arrays_of_nodes():
    graph = Graph()
    q = functions.Vector(graph.symbol(i) for i in range(4))
    values = dict(zip(q, (0.1, 0.7, -0.5, 0.5), strict=True))
    A, B = rotation_matrix(q), rotation_matrix(np.array(list(values.values())))
    pairs = [(A @ A.T, B @ B.T), (A + 2 * A - A[0], 3 * B - B[0]), (A * q[1], B * 0.7), (q[1] - A, 0.7 - B)]
    pairs += [(np.stack(list(q)), [0.1, 0.7, -0.5, 0.5]), (functions.sin(A), np.sin(B)), (A / q[0], B / 0.1)]
    for traced_array, expected in pairs:
        found = graph.evaluated(list(np.ravel(traced_array)), values)
        assert np.allclose(np.array(found, dtype=float), np.ravel(expected), rtol=0, atol=4e-15)


# ---------------------------------------------------------------------- refusals


def test_a_node_has_no_truth():
    _, (x, y), _ = traced(smooth)
    for condition in (x, x < y, functions.less(x, 2)):
        with pytest.raises(TypeError, match=r"^a formula must not branch with `if` on a value, but it does\.$"):
            bool(condition)
    with pytest.raises(TypeError, match=r"^a formula must compare by < or >"):
        x <= y  # noqa: B015


def test_an_unknown_function_has_no_derivative():
    graph, (x, y), _ = traced(smooth)
    with pytest.raises(TypeError, match=r"^floor must have a derivative, but it has none\.$"):
        gradient(y * graph.applied("floor", x), [x])


def test_a_potential_that_branches_on_the_attitude_is_refused():
    class Branching(pt.Potential):
        def energy(self, instant):
            height = instant.attitude.to_body((0, 0, 1))[2]
            return height if height > 0 else -height

    with pytest.raises(TypeError, match=r"^the formula of Branching must not branch with `if` on a value"):
        pt.System(pt.Body((1.0, 1.2, 1.5)), Branching())


@pytest.mark.parametrize("x", [1e-70, -1e-9, 1e-3, 0.2])
@pytest.mark.parametrize("name", ["sine_defect", "asinh_defect"])
def test_derivatives_of_small_differences_have_all_their_digits(name, x):
    slope = {"sine_defect": lambda x: 1 - mpmath.cos(x), "asinh_defect": lambda x: 1 - 1 / mpmath.sqrt(1 + x * x)}
    found = by_gradient(lambda x: getattr(functions, name)(x), x)[-1]
    with mpmath.workdps(200):
        expected = float(slope[name](mpmath.mpf(x)))
    assert float(found) == pytest.approx(expected, rel=2e-15, abs=0)


@pytest.mark.parametrize("left", [1e-3, 1e-12])
def test_the_slope_of_the_eccentric_anomaly_near_the_periapsis_of_a_long_ellipse(left):
    e, M = 1 - left, 1e-3 * left**1.5
    found = by_gradient(lambda M: functions.eccentric_anomaly(e, M), M)[-1]
    with mpmath.workdps(60):
        E = mpmath.findroot(lambda E: E - e * mpmath.sin(E) - M, M / left)
        expected = float(1 / (1 - e * mpmath.cos(E)))
    assert float(found) == pytest.approx(expected, rel=1e-14, abs=0)
