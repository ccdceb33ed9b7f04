"""Functions for formulas on every kind of scalar."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy

import poinsot as pt
from poinsot import functions
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph

EPS = np.finfo(float).eps
ARGUMENT = 0.3
ONE_ARGUMENT = ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "asin", "acos", "atan")
GRAPH = Graph()
X, Y = GRAPH.symbol("x"), GRAPH.symbol("y")
S = sympy.Symbol("s", real=True)


def compiled(formula, *values):
    """Return the value of a formula of X (and Y), compiled in double-double arithmetic."""
    return WideEvaluator([formula], [X, Y][: len(values)])(values)[0]


# ---------------------------------------------------------------------- elementary functions


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_function_of_a_float(name):
    assert getattr(functions, name)(ARGUMENT) == pytest.approx(getattr(math, name)(ARGUMENT), rel=2 * EPS, abs=0)


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_function_of_an_array(name):
    values = np.array([[0.1, 0.2], [0.3, 0.9]])
    expected = [[getattr(math, name)(x) for x in row] for row in values]
    assert np.allclose(getattr(functions, name)(values), expected, rtol=2 * EPS, atol=0)


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_function_of_a_compiled_formula(name):
    value = compiled(getattr(functions, name)(X), ARGUMENT)
    assert value == pytest.approx(getattr(math, name)(ARGUMENT), rel=4 * EPS, abs=0)


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_function_of_a_sympy_expression(name):
    value = getattr(functions, name)(S)
    assert isinstance(value, sympy.Expr)
    assert float(value.subs(S, ARGUMENT)) == pytest.approx(getattr(math, name)(ARGUMENT), rel=2 * EPS, abs=0)


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_function_of_an_mpmath_number_has_all_its_digits(name):
    with mpmath.workdps(40):
        argument = mpmath.mpf(3) / 10
        assert getattr(functions, name)(argument) == getattr(mpmath, name)(argument)


@pytest.mark.parametrize(("y", "x"), [(0.3, 0.4), (0.3, -0.4), (-0.3, -0.4), (-0.3, 0.4)])
def test_atan2_in_all_quadrants_on_every_kind(y, x):
    expected = math.atan2(y, x)
    assert functions.atan2(y, x) == expected
    assert np.asarray(functions.atan2(np.array([y]), np.array([x])))[0] == expected
    assert compiled(functions.atan2(Y, X), x, y) == pytest.approx(expected, rel=4 * EPS, abs=0)
    assert float(functions.atan2(sympy.Float(y), sympy.Float(x))) == pytest.approx(expected, rel=2 * EPS, abs=0)
    assert float(functions.atan2(mpmath.mpf(y), mpmath.mpf(x))) == pytest.approx(expected, rel=2 * EPS, abs=0)


def test_atan2_of_a_number_and_an_expression():
    assert compiled(functions.atan2(1.0, X), -2.0) == pytest.approx(math.atan2(1, -2), rel=4 * EPS, abs=0)
    assert compiled(functions.atan2(X, 1.0), -2.0) == pytest.approx(math.atan2(-2, 1), rel=4 * EPS, abs=0)


# ---------------------------------------------------------------------- choice


@pytest.mark.parametrize(("a", "chosen"), [(0.5, "first"), (1.5, "second"), (1.0, "second")])
def test_where_less_on_every_kind(a, chosen):
    expected = a + 1 if chosen == "first" else a - 1

    def choice(x):
        return functions.where(functions.less(x, 1.0), x + 1, x - 1)

    assert choice(a) == expected
    assert choice(np.array([a, a])).tolist() == [expected, expected]
    assert compiled(choice(X), a) == expected
    assert float(choice(S).subs(S, a)) == expected
    assert choice(mpmath.mpf(a)) == expected


KINDS = {
    "float": lambda: 1.0,
    "array": lambda: np.array([1.0, 2.0]),
    "sympy": lambda: S,
    "mpmath": lambda: mpmath.mpf(1),
    "constant of a run": lambda: Graph().input(0),
    "variable of a kernel": lambda: Graph().symbol("x"),
    "variable about an array": lambda: Graph().variable(np.array([1.0, 2.0])),
    "variable about a variable": lambda: Graph().variable(Graph().variable(1.0)),
}
SIGNS = {
    "x < 1.5": (lambda x: x < 1.5, lambda x: functions.less(x, 1.5)),
    "1.5 < x": (lambda x: 1.5 < x, lambda x: functions.less(1.5, x)),  # noqa: SIM300
    "x > 1.5": (lambda x: x > 1.5, lambda x: functions.less(1.5, x)),
    "x * x < x": (lambda x: x * x < x, lambda x: functions.less(x * x, x)),
}


@pytest.mark.parametrize("sign", SIGNS)
@pytest.mark.parametrize("kind", KINDS)
def test_signs_make_the_conditions_of_less(kind, sign):
    by_sign, by_name = (condition(KINDS[kind]()) for condition in SIGNS[sign])
    if hasattr(by_name, "operands"):
        by_sign, by_name = (repr(x) for x in (by_sign, by_name))
    assert np.array_equal(by_sign, by_name)


def test_less_with_the_expression_on_the_right():
    assert compiled(functions.where(functions.less(1.0, X), X, 0.0), 2.0) == 2.0
    assert compiled(functions.where(functions.less(1.0, X), X, 0.0), 0.5) == 0.0


def test_where_is_elementwise_on_arrays():
    x = np.array([-1.0, 2.0])
    assert np.asarray(functions.where(functions.less(x, 0.0), -x, 10 * x)).tolist() == [1.0, 20.0]


TABLE = (-1.0, 0.25, 1.0, 2.5), (3.0, -1.0, 0.5, 0.75)
WITH_KINKS: dict[str, Any] = {
    "abs": (functions.abs, np.abs),
    "sign": (functions.sign, np.sign),
    "minimum": (lambda x: functions.minimum(x, 0.25), lambda x: np.minimum(x, 0.25)),
    "maximum": (lambda x: functions.maximum(-0.5, x), lambda x: np.maximum(-0.5, x)),
    "clip": (lambda x: functions.clip(x, -0.5, 0.25), lambda x: np.clip(x, -0.5, 0.25)),
    "interp": (lambda x: functions.interp(x, *TABLE), lambda x: np.interp(x, *TABLE)),
}
AROUND_KINKS = (-2.0, -1.0, -0.5, -0.3, 0.0, 0.25, 0.7, 1.0, 2.5, 4.0)
each_kink = pytest.mark.parametrize("name", WITH_KINKS)


@each_kink
def test_a_function_with_kinks_on_every_kind(name):
    own, of_numpy = WITH_KINKS[name]
    expected = of_numpy(np.array(AROUND_KINKS))
    rows = {
        "floats": [own(x) for x in AROUND_KINKS],
        "an array": own(np.array(AROUND_KINKS)),
        "expressions": [compiled(0.0 + own(X), x) for x in AROUND_KINKS],
        "symbols": [own(S).subs(S, x) for x in AROUND_KINKS],
        "many digits": [own(mpmath.mpf(x)) for x in AROUND_KINKS],
    }
    for kind, values in rows.items():
        assert np.allclose(np.array(values, dtype=float), expected, rtol=0, atol=6 * EPS), kind


def test_a_table_that_does_not_ascend_or_match_is_refused():
    with pytest.raises(ValueError, match=r"^values must be as many as places, at least one, got 1 and 2\.$"):
        functions.interp(0.5, (0, 1), (3,))
    with pytest.raises(ValueError, match=r"^places must ascend, got \[0, 1, 1\]\.$"):
        functions.interp(0.5, (0, 1, 1), (3, 4, 5))


def test_pi():
    assert functions.pi == math.pi


# ---------------------------------------------------------------------- in a run


class AboutOneAxis(pt.Torque):
    """A torque about the third axis, by a formula of the time and a parameter."""

    shape: str
    one: float

    def torque(self, instant):
        return functions.Vector((0.0, 0.0, IN_TIME[self.shape][0](instant.time, self.one)))


def half_waves(t):
    turns, rest = divmod(t, math.pi)
    return 2 * turns + 1 - math.cos(rest)


IN_TIME = {  # a formula, and its integral from 0
    "abs": (lambda t, one: abs(functions.sin(one * t)), half_waves),
    "abs of a parameter": (lambda t, one: abs(-one) * t + functions.abs(one), lambda t: t * t / 2 + t),
    "sign": (lambda t, one: functions.sign(one - t), lambda t: 1 - abs(1 - t)),
    "minimum": (lambda t, one: functions.minimum(t, one), lambda t: min(t, 1) ** 2 / 2 + max(t - 1, 0)),
    "maximum": (lambda t, one: functions.maximum(one, t), lambda t: t + max(t - 1, 0) ** 2 / 2),
    "clip": (
        lambda t, one: functions.clip(t, one, 2),
        lambda t: t + ((min(t, 2) - 1) ** 2 / 2 + max(t - 2, 0)) * (t > 1),
    ),
    "interp": (
        lambda t, one: functions.interp(t, (one, 2.0, 4.0), (0.0, 3.0, -one)),
        lambda t: (
            1.5 * max(min(t, 2) - 1, 0) ** 2 + max(min(t, 4) - 2, 0) * 3 - max(min(t, 4) - 2, 0) ** 2 - max(t - 4, 0)
        ),
    ),
    "tanh": (lambda t, one: functions.tanh(one * t), lambda t: math.log(math.cosh(t))),
    "pi": (lambda t, one: one * functions.pi * t, lambda t: math.pi * t * t / 2),
    "powers": (lambda t, one: (one * t) ** 3 + t**4 - t**0 + (t - one) ** 5, lambda t: polynomial(t)),
}


def polynomial(t):
    return t**4 / 4 + t**5 / 5 - t + ((t - 1) ** 6 - 1) / 6


@pytest.mark.parametrize("shape", IN_TIME)
def test_the_integrator_finds_each_kink(shape):
    body, times = pt.Body((1.0, 1.2, 1.5)), np.array([0.0, 0.5, 1.0, 1.7, 2.3, 3.5, 4.4, 6.0])
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0.2))
    motion = pt.propagate(pt.System(body, AboutOneAxis(shape, 1.0)), start, times)
    expected = 0.3 + np.array([IN_TIME[shape][1](t) for t in times])
    assert np.max(np.abs(motion.angular_momentum_body[:, 2] - expected)) < 256 * EPS * np.max(np.abs(expected))


class Slowed(pt.Torque):
    """A push, and quadratic drag against it."""

    push: float
    drag: float

    def torque(self, instant):
        drag = self.drag * functions.norm(instant.omega_body)
        return functions.Vector((0.0, 0.0, self.push)) - drag * instant.omega_body


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e4])
def test_drag_runs_from_rest(unit):
    """omega = sqrt(push / drag) tanh(sqrt(push drag) t / I), in units of time."""
    body, end = pt.Body((1.0, 1.2, 1.5)), 3 * unit
    rest = body.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    states = body.state(np.tile([1.0, 0, 0, 0], (9, 1)), omega_body=np.arange(9)[:, None] * [0, 0, 0.1 / unit])
    system = pt.System(body, Slowed(0.7 / unit**2, 0.4))
    expected = math.sqrt(0.7 / 0.4) / unit * math.tanh(math.sqrt(0.7 * 0.4) * 3 / 1.5)
    for found in (
        pt.propagate(system, rest, [end]).omega_body[0],
        pt.propagate(system, states, [end]).omega_body[0, 0],
    ):
        assert found[2] == pytest.approx(expected, rel=64 * EPS, abs=0)
    still = pt.propagate(pt.System(body, Slowed(0.0, 0.4)), rest, [end])
    assert not np.any(still.omega_body)


class Leaning(pt.Potential):
    """A power of what is zero at the start."""

    power: int

    def energy(self, instant):
        return instant.attitude.to_body((0, 0, 1))[0] ** self.power


@pytest.mark.parametrize("power", [0, 1, 2, 3, 4, 7, 16])
def test_whole_powers_are_no_singularity(power):
    body = pt.Body((1.0, 1.2, 1.5))
    start = body.state((1, 0, 0, 0), omega_body=(0, 0.7, 0.2))
    system = pt.System(body, Leaning(power))
    motion = pt.propagate(system, start, [0.0, 1.0, 2.0])
    assert np.max(np.abs(motion.drift["energy"])) < 64 * EPS
    wide = pt.propagate(system, start, [0.0, 1.0, 2.0], formulation="canonical", precision="quadruple")
    assert np.max(np.abs(motion.quaternion - wide.quaternion)) < 64 * EPS


# ---------------------------------------------------------------------- vectors


def test_dot_cross_and_norm_of_floats():
    a, b = (1.0, 2.0, 3.0), (-4.0, 5.0, 0.5)
    assert functions.dot(a, b) == np.dot(a, b)
    assert list(functions.cross(a, b)) == list(np.cross(a, b))
    assert functions.norm((2.0, 3.0, 6.0)) == 7.0


def test_dot_cross_and_norm_of_symbols():
    a1, a2, a3, b1, b2, b3 = sympy.symbols("a1:4 b1:4", real=True)
    assert functions.dot((a1, a2, a3), (b1, b2, b3)) == a1 * b1 + a2 * b2 + a3 * b3
    product = sympy.Matrix([a1, a2, a3]).cross(sympy.Matrix([b1, b2, b3]))
    assert list(functions.cross((a1, a2, a3), (b1, b2, b3))) == list(product)
    assert functions.norm((a1, a2)) == sympy.sqrt(a1**2 + a2**2)


def test_dot_norm_and_cross_of_compiled_formulas():
    u = (X, 2.0, 3.0 * X)
    assert compiled(functions.dot(u, (1.0, X, 2.0)), 0.5) == 4.5
    assert compiled(functions.norm(u), 1.5) == pytest.approx(math.hypot(1.5, 2.0, 4.5), rel=4 * EPS, abs=0)
    assert compiled(functions.cross(u, (0.0, 0.0, 1.0))[1], 1.5) == -1.5


def test_dot_of_unequal_lengths_is_refused():
    with pytest.raises(ValueError):
        functions.dot((1.0, 2.0), (1.0, 2.0, 3.0))


def test_vector_arithmetic_with_vectors():
    a, b = functions.Vector((1.0, 2.0, 3.0)), functions.Vector((10.0, 20.0, 40.0))
    assert list(a + b) == [11, 22, 43]
    assert list(b - a) == [9, 18, 37]
    assert list(a * b) == [10, 40, 120]
    assert list(b / a) == [10, 10, 40 / 3]
    assert list(-a) == [-1, -2, -3]


def test_vector_arithmetic_with_scalars_on_both_sides():
    a = functions.Vector((1.0, 2.0, 4.0))
    assert list(a + 1) == list(1 + a) == [2, 3, 5]
    assert list(a - 1) == [0, 1, 3]
    assert list(1 - a) == [0, -1, -3]
    assert list(2 * a) == list(a * 2) == [2, 4, 8]
    assert list(a / 2) == [0.5, 1, 2]


def test_vector_is_a_sequence():
    a = functions.Vector((1.0, 2.0, 4.0))
    assert (len(a), a[0], a[-1], tuple(a)) == (3, 1.0, 4.0, (1.0, 2.0, 4.0))
    assert repr(a) == "Vector((1.0, 2.0, 4.0))"


@pytest.mark.parametrize("factor", [np.array([1.0, 2.0, 5.0, 7.0]), np.float64(3.0)])
def test_array_times_vector_is_a_vector_of_arrays(factor):
    a = functions.Vector((1.0, 2.0, 4.0))
    for product in (factor * a, a * factor):
        assert isinstance(product, functions.Vector)
        assert [np.asarray(x).tolist() for x in product] == [(k * factor).tolist() for k in (1, 2, 4)]


@pytest.mark.parametrize("add", [lambda a, x: x + a, lambda a, x: a + x, lambda a, x: x - a, lambda a, x: a - x])
@pytest.mark.parametrize("shape", [(3,), (2,), (4, 3)])
def test_array_is_not_added_to_a_vector(add, shape):
    sentence = f"a Vector must be added to vectors and numbers, got an array of shape {shape}. "
    with pytest.raises(TypeError) as caught:
        add(functions.Vector((1.0, 2.0, 4.0)), np.ones(shape))
    assert str(caught.value) == sentence + "np.stack(vector, axis=-1) converts the vector."
    assert list(add(functions.Vector((1.0, 2.0, 4.0)), np.array(0.0)))  # a number


def test_positions_of_an_orbit_are_subtracted_from_rows_as_an_array():
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=(1, 0, 0), velocity=(0, 1, 0))
    times = np.linspace(0.0, 6.0, 3)  # as many as components
    circle = np.stack([np.cos(times), np.sin(times), 0 * times], axis=-1)
    with pytest.raises(TypeError, match="got an array of shape"):
        circle - orbit.position_at(times)
    assert np.max(np.abs(circle - np.stack(orbit.position_at(times), axis=-1))) < 1e-14


def test_vector_of_expressions_times_a_number_of_each_kind():
    a = functions.Vector((X, 2 * X, 3 * X))
    for factor in (2, 2.0, np.float64(2.0), X + 1.5):
        assert compiled((factor * a)[2], 0.5) == 3.0
        assert compiled((a * factor)[2], 0.5) == 3.0


# ---------------------------------------------------------------------- Kepler's equation


def kepler_at_40_digits(eccentricity, mean_anomaly):
    """E of Kepler's equation for the given doubles, by Newton's method from pi, which is monotonic."""
    with mpmath.workdps(40):
        e, M = mpmath.mpf(eccentricity), mpmath.mpf(mean_anomaly)
        turns = 2 * mpmath.pi * mpmath.nint(M / (2 * mpmath.pi))
        reduced = M - turns
        if reduced == 0:
            return turns
        far = mpmath.pi * mpmath.sign(reduced)
        root = mpmath.findroot(
            lambda E: E - e * mpmath.sin(E) - reduced,
            far,
            solver="newton",
            df=lambda E: 1 - e * mpmath.cos(E),
            maxsteps=300,
            tol=mpmath.mpf(10) ** -75,
        )
        return turns + root


def backward_bound(eccentricity, mean_anomaly, anomaly):
    """Three roundings of E, and what three roundings of M and of e sin E move it."""
    E = float(anomaly)
    slope = 1 - eccentricity * math.cos(E)
    return 3 * EPS * (abs(E) + (abs(mean_anomaly) + eccentricity * abs(math.sin(E))) / slope)


ECCENTRICITIES = (0.0, 1e-9, 0.1, 0.5, 0.9, 0.99, 0.999999)
MEAN_ANOMALIES = (
    *(0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 3.0, math.pi, math.nextafter(math.pi, 4), 3.2, 6.2, 2 * math.pi, 20.0),
    *(1e3, 1e6, 1e9, 1e12),
)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("eccentricity", ECCENTRICITIES)
def test_eccentric_anomaly_against_forty_digits(eccentricity, sign):
    for M in MEAN_ANOMALIES:
        reference = kepler_at_40_digits(eccentricity, sign * M)
        error = abs(float(functions.eccentric_anomaly(eccentricity, sign * M) - reference))
        assert error <= backward_bound(eccentricity, M, reference), (eccentricity, sign * M)


def test_eccentric_anomaly_is_the_mean_anomaly_on_a_circle():
    M = np.linspace(-20.0, 20.0, 41)
    assert np.allclose(functions.eccentric_anomaly(0.0, M), M, rtol=2 * EPS, atol=0)


def test_eccentric_anomaly_at_the_apses_is_exact():
    assert functions.eccentric_anomaly(0.999999, 0.0) == 0.0
    assert functions.eccentric_anomaly(0.7, math.pi) == math.pi
    assert functions.eccentric_anomaly(0.7, -math.pi) == -math.pi


def test_eccentric_anomaly_broadcasts():
    e, M = np.array([0.0, 0.4, 0.9]), np.array([[0.3], [2.0]])
    E = np.asarray(functions.eccentric_anomaly(e, M))
    assert E.shape == (2, 3)
    assert np.allclose(E - e * np.sin(E), M + 0 * e, rtol=0, atol=4 * EPS)


def test_eccentric_anomaly_of_mpmath_numbers_has_forty_digits():
    with mpmath.workdps(40):
        E = functions.eccentric_anomaly(mpmath.mpf("0.3"), mpmath.mpf("1.1"))
        assert abs(E - mpmath.mpf("0.3") * mpmath.sin(E) - mpmath.mpf("1.1")) < mpmath.mpf(10) ** -38


@pytest.mark.parametrize(("eccentricity", "mean_anomaly"), [(0.0, 0.3), (0.5, -1.0), (0.9, 20.0), (0.999, 0.01)])
def test_eccentric_anomaly_of_compiled_formulas_up_to_full_turns(eccentricity, mean_anomaly):
    E = compiled(functions.eccentric_anomaly(X, Y), eccentricity, mean_anomaly)
    reference = kepler_at_40_digits(eccentricity, mean_anomaly)
    bound = 2 * backward_bound(eccentricity, mean_anomaly, reference)
    assert abs(math.remainder(E - float(reference), 2 * math.pi)) <= bound


def test_eccentric_anomaly_of_a_sympy_symbol_is_refused():
    with pytest.raises(TypeError, match=r"^eccentric_anomaly must have numbers, got a SymPy expression\.$"):
        functions.eccentric_anomaly(0.1, S)


NOT_VECTORS = {
    "cross of two": (lambda: functions.cross((1, 2), (1, 2, 3)), ValueError, "cross", "of three scalars, got 2 and 3."),
    "cross of a number": (lambda: functions.cross(1.0, (1, 2, 3)), TypeError, "cross", "of three scalars, got float."),
    "cross of a text": (lambda: functions.cross("abc", (1, 2, 3)), TypeError, "cross", "of three scalars, got str."),
    "dot of others": (
        lambda: functions.dot((1, 2), (1, 2, 3)),
        ValueError,
        "dot",
        "of equally many scalars, at least one, got 2 and 3.",
    ),
    "dot of nothing": (
        lambda: functions.dot((), ()),
        ValueError,
        "dot",
        "of equally many scalars, at least one, got 0 and 0.",
    ),
}


@pytest.mark.parametrize("name", NOT_VECTORS)
def test_products_are_of_two_vectors(name):
    call, kind, function, got = NOT_VECTORS[name]
    with pytest.raises(kind, match=f"^{function} must have two vectors {got}$"):
        call()


def test_a_length_is_of_a_vector():
    with pytest.raises(TypeError, match=r"^norm must have a vector of scalars, got float\.$"):
        functions.norm(1.0)


@pytest.mark.parametrize("value", [None, "x", {}, [[1.0], [1.0, 2.0]]], ids=repr)
@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_elementary_functions_are_of_numbers(name, value):
    with pytest.raises((TypeError, ValueError), match=rf"^{name} must have numbers or arrays of them, got "):
        getattr(functions, name)(value)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-4, 1.0, np.pi / 2, np.pi - 1e-9, np.pi])
def test_the_angle_between_vectors_has_all_digits(angle):
    a = (3.0, 0.0, 0.0)
    b = (0.2 * math.cos(angle), 0.12 * math.sin(angle), 0.16 * math.sin(angle))
    assert functions.angle_between(a, b) == pytest.approx(angle, rel=4 * EPS, abs=4e-17)
    assert functions.angle_between(b, a) == functions.angle_between(a, b)
