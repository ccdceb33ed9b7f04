"""The looped kernel against heyoka's integrator, against mpmath's Taylor coefficients, and against itself."""

import platform
import subprocess
import sys
import threading
from types import SimpleNamespace

import heyoka as hy
import llvmlite.binding
import mpmath
import numpy as np
import pytest

from poinsot.taylor import memory, object_cache, recurrences, rescaling
from poinsot.taylor.decomposition import (
    Coefficient,
    Decomposition,
    Function,
    Invariant,
    Momenta,
    Product,
    Quotient,
    Select,
    Sum,
    Time,
    Variable,
)
from poinsot.taylor.kernels import Code, KernelProgram, compiled, order_of
from poinsot.taylor.memory import Rolled
from poinsot.taylor.queue import FOREVER, STEPS_IN_BLOCK, Output, Queue, Worker
from poinsot.taylor.rescaling import MAX_MOMENTUM, MIN_MOMENTUM
from poinsot.taylor.tasks import Status

EPS = np.finfo(float).eps
TOLERANCE = EPS
ORDER = order_of(TOLERANCE)
MU = 398600.4418
MOTION = np.sqrt(MU / 7000.0**3)


class Symbol:
    """An operation of a decomposition under construction, with the operators of numbers."""

    def __init__(self, operations, operation):
        self.operations, self.place = operations, len(operations)
        operations.append(operation)

    def of(self, operation):
        return Symbol(self.operations, operation)

    def function(self, name, *others, slopes):
        """Return a function of this one and others, whose slopes may need the function itself."""
        result = self.of(None)
        arguments = tuple(map(operand, (self, *others)))
        self.operations[result.place] = Function(name, arguments, tuple(map(operand, slopes(result))))
        return result

    def __add__(self, other):
        if isinstance(other, Symbol):
            return self.of(Sum(((Coefficient(), self.place), (Coefficient(), other.place))))
        return self.of(Sum(((Coefficient(), self.place),), (operand(other),)))

    __radd__ = __add__

    def __sub__(self, other):
        return self + -1.0 * other

    def __neg__(self):
        return -1.0 * self

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if isinstance(other, Symbol):
            return self.of(Product(self.place, other.place))
        return self.of(Sum(((operand(other), self.place),)))

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self.of(Quotient(self.place, operand(other))) if isinstance(other, Symbol) else self * (1.0 / other)

    def __rtruediv__(self, other):
        return self.of(Quotient(operand(other), self.place))

    def __pow__(self, exponent):
        if exponent == 2:
            return self * self
        return self.function("pow", exponent, slopes=lambda own: (exponent * own / self, 0.0))


def operand(given):
    """Return what stands for a symbol or a number in an operation."""
    if isinstance(given, Symbol):
        return given.place
    return given if isinstance(given, Coefficient) else Coefficient(float(given))


def sine_and_cosine(angle):
    sine, cosine = angle.of(None), angle.of(None)
    angle.operations[sine.place] = Function("sin", (angle.place,), (cosine.place,))
    angle.operations[cosine.place] = Function("cos", (angle.place,), ((-sine).place,))
    return sine, cosine


def of_eccentric_anomaly(eccentricity, mean_anomaly):
    """Return sine and cosine of the eccentric anomaly, and itself."""
    anomaly = mean_anomaly.of(None)
    sine, cosine = sine_and_cosine(anomaly)
    slope = 1.0 / (1.0 - eccentricity * cosine)
    slopes = ((sine * slope).place, slope.place)
    anomaly.operations[anomaly.place] = Function(
        "eccentric_anomaly", (operand(eccentricity), mean_anomaly.place), slopes
    )
    return sine, cosine, anomaly


def decomposed(variables, rates, parameters=0, **others):
    """Return the decomposition of rates that are written as a function of the states and the time."""
    operations = []
    states = [Symbol(operations, Variable(place)) for place in range(variables)]
    found = tuple(map(operand, rates(states, Symbol(operations, Time()))))
    return Decomposition(tuple(operations), found, parameters, **others)


def heyoka_system(variables, rates):
    states = list(hy.make_vars(*[f"x{i}" for i in range(variables)]))
    return list(zip(states, rates(states, hy.time), strict=True))


def rigid_body(moments, torque):
    """Return the rates of (q, omega) as a function of states and time."""

    def rates(states, time):
        q0, q1, q2, q3, w1, w2, w3 = states
        a, b, c = moments
        tau = torque(states[:4], time)
        return [
            0.5 * (-1.0 * (q1 * w1) - q2 * w2 - q3 * w3),
            0.5 * (q0 * w1 + q2 * w3 - q3 * w2),
            0.5 * (q0 * w2 - q1 * w3 + q3 * w1),
            0.5 * (q0 * w3 + q1 * w2 - q2 * w1),
            ((b - c) / a) * (w2 * w3) + tau[0] * (1 / a),
            ((c - a) / b) * (w3 * w1) + tau[1] * (1 / b),
            ((a - b) / c) * (w1 * w2) + tau[2] * (1 / c),
        ]

    return rates


def gravity(q, _):
    q0, q1, q2, q3 = q
    return [0.0 * q0, 0.5 * (q0**2 - q1**2 - q2**2 + q3**2), -1.0 * (q0 * q1 + q2 * q3)]


def gravity_gradient(q, time):
    """Return the torque on a satellite on a planar elliptic orbit; the distance is a power on purpose."""
    q0, q1, q2, q3 = q
    if isinstance(time, Symbol):
        sine, cosine, _ = of_eccentric_anomaly(0.2, MOTION * time)
    else:
        anomaly = hy.kepE(0.2, MOTION * time)
        sine, cosine = hy.sin(anomaly), hy.cos(anomaly)
    x, y, r = cosine - 0.2, np.sqrt(0.96) * sine, 7000.0 * (1.0 - 0.2 * cosine)
    b = [
        x * (q0**2 + q1**2 - q2**2 - q3**2) + 2.0 * (y * (q1 * q2 + q0 * q3)),
        2.0 * (x * (q1 * q2 - q0 * q3)) + y * (q0**2 - q1**2 + q2**2 - q3**2),
        2.0 * (x * (q1 * q3 + q0 * q2) + y * (q2 * q3 - q0 * q1)),
    ]
    scale = (3 * MU * 7000.0**2) * r**-5.0
    return [100.0 * (scale * (b[1] * b[2])), -200.0 * (scale * (b[2] * b[0])), 100.0 * (scale * (b[0] * b[1]))]


SYSTEMS = {
    "top": (rigid_body((1.25, 1.0, 0.75), gravity), 100.0),
    "satellite": (rigid_body((400.0, 500.0, 600.0), gravity_gradient), 4 * 2 * np.pi / MOTION),
}
DECOMPOSITIONS = {name: decomposed(7, rates) for name, (rates, _) in SYSTEMS.items()}
RATES = {"top": (0.5, -0.9, 0.7), "satellite": (3e-4, -1e-3, 2e-3)}


def starts(name, count=1):
    """Return states (count, 7) around one."""
    generator = np.random.default_rng(3)
    q = [0.5, -0.7, 0.1, 0.5] + 0.05 * generator.standard_normal((count, 4))
    omega = RATES[name] * (1 + 0.3 * generator.standard_normal((count, 3)))
    return np.hstack([q / np.linalg.norm(q, axis=1, keepdims=True), omega])


def integrated(code, states, times, *, origin=0.0, parameters=None, budget=10**6, change=None):
    """Run members from an origin outwards to rising times; return rows (members, m, variables) and the tasks."""
    members, times = len(states), np.asarray(times, dtype=float)
    place, m = int(np.searchsorted(times, origin)), len(times)
    ways = [way for way, some in ((1, place < m), (-1, place > 0)) if some]
    rows = np.full((members, m, code.variables), np.nan)
    way = np.repeat(ways, members)
    output = Output.of(
        times,
        rows,
        np.tile(np.arange(members), len(ways)),
        np.where(way > 0, place, place - 1),
        np.where(way > 0, m - place, place),
        way,
    )
    numbers = np.zeros((members, 0)) if parameters is None else parameters
    queue = Queue(
        code,
        np.tile(states, (len(ways), 1)),
        np.full(way.size, origin),
        np.tile(numbers, (len(ways), 1)),
        output,
    )
    if change is not None:
        change(queue.tasks)
    run = Worker(code, stores_steps=code.lanes == 1)
    run.start(queue)
    while run.advance(budget):
        pass
    return rows, queue.tasks, run


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("layout", ["batch", "single"])
def test_states_and_steps_are_those_of_heyoka(name, layout):
    rates, end = SYSTEMS[name]
    start = starts(name)
    judge = hy.taylor_adaptive(heyoka_system(7, rates), start[0], tol=TOLERANCE, compact_mode=True)
    _, shortest, longest, steps, _ = judge.propagate_until(end)[:5]
    assert judge.order == ORDER
    rows, tasks, run = integrated(compiled(DECOMPOSITIONS[name], ORDER, 8, layout), start, [end])
    assert tasks["status"][0] == Status.DONE
    assert abs(tasks["steps"][0] - steps) <= 0.01 * steps
    if layout == "single":
        lengths = np.concatenate(run.steps)["length"][:-1]
        np.testing.assert_allclose([np.min(lengths), np.max(lengths)], [shortest, longest], rtol=0.01)
    # Rounding of 260 steps grows linearly on a regular motion, and the two differ by the ways of both.
    np.testing.assert_allclose(rows[0, 0], judge.state, rtol=0, atol=6e-13)
    np.testing.assert_array_equal(tasks["state"][0], rows[0, 0])
    np.testing.assert_array_equal(tasks["time"][0], [end, 0.0])


@pytest.mark.parametrize("name", SYSTEMS)
def test_any_number_of_lanes_and_both_layouts_give_the_same_bits(name):
    times = np.linspace(0.0, SYSTEMS[name][1], 23)[1:]
    states = starts(name, 9)
    found = [
        integrated(compiled(DECOMPOSITIONS[name], ORDER, lanes, layout), states, times)[0]
        for lanes, layout in [(8, "batch"), (4, "batch"), (2, "batch"), (1, "batch"), (1, "single")]
    ]
    assert np.all(np.isfinite(found[0]))
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


def gravity_with_an_integral(q, _):
    q0, q1, q2, q3 = q
    norm = q0.of(Invariant(tuple(x.place for x in q)))
    return [0.0 * q0, 0.5 * (norm - 2.0 * (q1**2 + q2**2)), -1.0 * (q0 * q1 + q2 * q3)]


def test_an_integral_is_a_sum_of_squares_that_does_not_change():
    """A quaternion of another norm, whose square the rates need."""
    own = decomposed(7, rigid_body((1.25, 1.0, 0.75), gravity_with_an_integral))
    states, end = starts("top", 9) * ([1.3] * 4 + [1.0] * 3), SYSTEMS["top"][1]
    expected = integrated(compiled(DECOMPOSITIONS["top"], ORDER, 8, "batch"), states, [end])[0]
    wide = integrated(compiled(own, ORDER, 8, "batch"), states, [end])[0]
    np.testing.assert_allclose(wide, expected, rtol=0, atol=6e-13)
    for lanes, layout in [(2, "batch"), (1, "single")]:
        np.testing.assert_array_equal(integrated(compiled(own, ORDER, lanes, layout), states, [end])[0], wide)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("layout", ["batch", "single"])
def test_optimization_changes_no_bit(layout, name, monkeypatch):
    times, states = np.linspace(0.0, SYSTEMS[name][1], 23)[1:], starts(name, 3)
    found = []
    for level in (0, 1, 2):
        monkeypatch.setattr(object_cache, "CODE_GENERATION", level)
        code = Code(KernelProgram(DECOMPOSITIONS[name], ORDER, 8, layout))
        found.append(integrated(code, states, times)[0])
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="needs an x86 processor")
def test_a_processor_without_fused_multiply_add_gives_the_same_bits(monkeypatch):
    times, states = [5.0], starts("top", 3)
    expected = integrated(Code(KernelProgram(DECOMPOSITIONS["top"], ORDER, 2, "batch")), states, times)[0]
    without = SimpleNamespace(flatten=lambda: "-fma,-fma4,-avx")
    monkeypatch.setattr(llvmlite.binding, "get_host_cpu_name", lambda: "x86-64")
    monkeypatch.setattr(llvmlite.binding, "get_host_cpu_features", lambda: without)
    found = integrated(Code(KernelProgram(DECOMPOSITIONS["top"], ORDER, 2, "batch")), states, times)[0]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("order", [ORDER, ORDER - 1, 4, 3, 2])
def test_loops_over_inner_sums_change_no_bit(order, name, monkeypatch):
    """Each block of straight-line code is cut after one operation, too."""
    times, states = np.linspace(0.0, SYSTEMS[name][1], 23)[1:], starts(name, 3)
    expected = integrated(Code(KernelProgram(DECOMPOSITIONS[name], order, 1, "single")), states, times)[0]
    monkeypatch.setattr(memory, "MIN_ROLLED", 0)
    monkeypatch.setattr(recurrences, "MAX_UNCUT", 0)
    monkeypatch.setattr(recurrences, "MAX_BLOCK", 1)
    program = KernelProgram(DECOMPOSITIONS[name], order, 1, "single")
    assert isinstance(program.context.layout, Rolled)
    assert "label %never" in str(program.module)
    np.testing.assert_array_equal(integrated(Code(program), states, times)[0], expected)


def with_slopes():
    """Return elementary functions of u = 0.4 + 0.3 t + 0.1 t^2 and v = 0.5 - 0.2 t for both: symbols and mpmath's."""
    mp = mpmath

    def symbols(u, v):
        one = u * 0.0 + 1.0
        sine, cosine = sine_and_cosine(u)
        root = lambda a: a.function("sqrt", slopes=lambda own: (0.5 / own,))  # noqa: E731
        square = u * u + v * v
        return {
            "sqrt": root(u),
            "exp": u.function("exp", slopes=lambda own: (own,)),
            "log": u.function("log", slopes=lambda _: (1.0 / u,)),
            "sin": sine,
            "cos": cosine,
            "tan": u.function("tan", slopes=lambda own: (own * own + 1.0,)),
            "tanh": u.function("tanh", slopes=lambda own: (one - own * own,)),
            "asin": u.function("asin", slopes=lambda _: (1.0 / root(one - u * u),)),
            "acos": u.function("acos", slopes=lambda _: (-1.0 / root(one - u * u),)),
            "atan": u.function("atan", slopes=lambda _: (1.0 / (one + u * u),)),
            "asinh": u.function("asinh", slopes=lambda _: (1.0 / root(one + u * u),)),
            "sine_defect": u.function("sine_defect", slopes=lambda _: (one - cosine,)),
            "asinh_defect": u.function("asinh_defect", slopes=lambda _: (one - 1.0 / root(one + u * u),)),
            "atan2": u.function("atan2", v, slopes=lambda _: (v / square, -u / square)),
            "pow -2.5": u**-2.5,
            "pow 3": u**3.0,
            "pow 0.7": u**0.7,
            "pow of a parameter": u ** Coefficient(2.0, 0),
            "of a parameter and a constant slope": u.function("exp", slopes=lambda own: (own,)) * Coefficient(-2.0, 0),
            "eccentric anomaly": of_eccentric_anomaly(v, u)[2],
            "quotient": v / u,
            "quotient of itself": u / u,
            "of a number": 3.0 / u,
            "time": 1.0 * v.of(Time()),
        }

    def anomaly(e, m):
        return mp.findroot(lambda E: E - e * mp.sin(E) - m, m)

    exact = {
        "sqrt": lambda u, _: mp.sqrt(u),
        "exp": lambda u, _: mp.exp(u),
        "log": lambda u, _: mp.log(u),
        "sin": lambda u, _: mp.sin(u),
        "cos": lambda u, _: mp.cos(u),
        "tan": lambda u, _: mp.tan(u),
        "tanh": lambda u, _: mp.tanh(u),
        "asin": lambda u, _: mp.asin(u),
        "acos": lambda u, _: mp.acos(u),
        "atan": lambda u, _: mp.atan(u),
        "asinh": lambda u, _: mp.asinh(u),
        "sine_defect": lambda u, _: u - mp.sin(u),
        "asinh_defect": lambda u, _: u - mp.asinh(u),
        "atan2": lambda u, v: mp.atan(u / v),
        "pow -2.5": lambda u, _: u ** mp.mpf(-2.5),
        "pow 3": lambda u, _: u**3,
        "pow 0.7": lambda u, _: u ** mp.mpf(0.7),
        "pow of a parameter": lambda u, _: u ** (2 * mp.mpf(0.3)),
        "of a parameter and a constant slope": lambda u, _: -2 * mp.mpf(0.3) * mp.exp(u),
        "eccentric anomaly": lambda u, v: anomaly(v, u),
        "quotient": lambda u, v: v / u,
        "quotient of itself": lambda *_: mp.mpf(1),
        "of a number": lambda u, _: 3 / u,
        "time": lambda _, v: (mp.mpf(0.5) - v) / mp.mpf(0.2),
    }
    return symbols, exact


@pytest.fixture(scope="module")
def coefficients():
    """The Taylor coefficients that the kernel gives to the functions, at t = 0, by their names."""
    symbols, exact = with_slopes()

    def rates(_, time):
        found = symbols(0.1 * (time * time) + 0.3 * time + 0.4, -0.2 * time + 0.5)
        assert list(found) == list(exact)
        return found.values()

    code = compiled(decomposed(len(exact), rates, parameters=1), ORDER, 1)
    _, _, run = integrated(code, np.zeros((1, len(exact))), [1e-3], parameters=np.array([[0.3]]))
    orders = np.arange(1, ORDER + 1)[:, None]
    return dict(zip(exact, (orders * run.steps[0]["coefficients"][0, 1:]).T, strict=True))


@pytest.mark.parametrize("name", with_slopes()[1])
def test_taylor_coefficients_of_functions(name, coefficients):
    function = with_slopes()[1][name]
    with mpmath.workdps(80):
        number = mpmath.mpf

        def along(t):
            return function(number(0.1) * t * t + number(0.3) * t + number(0.4), -number(0.2) * t + number(0.5))

        exact = np.array([float(c) for c in mpmath.taylor(along, 0, ORDER - 1)])
    # Where the last coefficients count as much as the first: the recurrences keep that norm, times 18 additions each.
    radius = 0.7
    weights = radius ** np.arange(ORDER)
    error = np.abs(coefficients[name] - exact) * weights
    assert np.max(error) <= 18 * EPS * np.max(np.abs(exact) * weights)


def test_members_run_both_ways_on_ragged_times_and_take_one_anothers_lanes():
    """17 members from their own starts in 4 lanes, each as if alone."""
    name, count = "top", 17
    code, alone = (compiled(DECOMPOSITIONS[name], ORDER, lanes) for lanes in (4, 1))
    generator = np.random.default_rng(5)
    times = np.sort(generator.uniform(-30.0, 30.0, 200))
    states, origins = starts(name, count), generator.uniform(-25.0, 25.0, count)
    places = np.searchsorted(times, origins)
    counts = np.minimum(generator.integers(1, 60, (2, count)), [times.size - places, places])
    rows = np.full((count, times.size, 7), np.nan)
    members, way = np.tile(np.arange(count), 2), np.repeat([1, -1], count)
    first = np.concatenate([places, places - 1])
    output = Output.of(times, rows, members, first, counts.ravel(), way)
    queue = Queue(code, states[members], origins[members], np.zeros((2 * count, 0)), output)
    run = Worker(code)
    run.start(queue)
    assert not run.advance()
    np.testing.assert_array_equal(queue.tasks["status"], Status.DONE)
    np.testing.assert_array_equal(queue.tasks["index"], counts.ravel())
    np.testing.assert_array_equal(queue.tasks["time"][:, 0], times[first + way * (counts.ravel() - 1)])
    np.testing.assert_array_equal(queue.tasks["time"][:, 1], 0.0)
    for member in range(count):
        low, high = places[member] - counts[1, member], places[member] + counts[0, member]
        own, _, _ = integrated(alone, states[member : member + 1], times[low:high], origin=origins[member])
        np.testing.assert_array_equal(rows[member, low:high], own[0])
        assert np.all(np.isnan(np.delete(rows[member], np.s_[low:high], axis=0)))


def test_rows_are_those_of_heyoka():
    rates, _ = SYSTEMS["top"]
    start, times = starts("top"), np.linspace(-20.03, 30.0, 501)
    rows, _, _ = integrated(compiled(DECOMPOSITIONS["top"], ORDER, 2), start, times, origin=1.5)
    judge = hy.taylor_adaptive(heyoka_system(7, rates), start[0], time=1.5, tol=TOLERANCE, compact_mode=True)
    later = judge.propagate_grid(np.append(1.5, times[times > 1.5]))[5][1:]
    judge.time, judge.state[:] = 1.5, start[0]
    earlier = judge.propagate_grid(np.append(1.5, times[times <= 1.5][::-1]))[5][1:]
    np.testing.assert_allclose(rows[0], np.concatenate([earlier[::-1], later]), rtol=0, atol=1e-14)


def test_a_member_that_fails_ends_alone():
    """x' = x^2 + sqrt(y), y' = -1: infinite where x is large at the start, not finite where y becomes negative.

    Coefficients grow as powers of x, up to the inverse of a rounding of the time: from 50 on none of them overflows.
    """
    decomposition = decomposed(
        2, lambda x, _: [x[0] * x[0] + x[1].function("sqrt", slopes=lambda own: (0.5 / own,)), -1.0]
    )
    states = np.array([[-1.0, 9.0], [2.0, 9.0], [-1.0, -1.0], [-2.0, 9.0], [-1.5, 9.0]])
    rows, tasks, _ = integrated(compiled(decomposition, ORDER, 2), states, [50.5, 51.0], origin=50.0)
    expected = [Status.DONE, Status.STALLED, Status.NOT_FINITE, Status.DONE, Status.DONE]
    np.testing.assert_array_equal(tasks["status"], expected)
    np.testing.assert_array_equal(tasks["index"], [2, 0, 0, 2, 2])
    np.testing.assert_array_equal(np.isnan(rows[:, 0, 0]), [False, True, True, False, False])
    np.testing.assert_array_equal(tasks["state"][2], states[2])
    assert 50.3 < tasks["time"][1, 0] < 50.5
    assert tasks["state"][1, 0] > 1e12
    np.testing.assert_array_equal([tasks["time"][2, 0], tasks["steps"][2]], [50.0, 0])
    alone, _, _ = integrated(compiled(decomposition, ORDER, 2), states[[0, 3, 4]], [50.5, 51.0], origin=50.0)
    np.testing.assert_array_equal(rows[[0, 3, 4]], alone)


@pytest.mark.parametrize("budget", [1, 7, 50])
def test_the_budget_changes_no_bit(budget):
    times, states = np.linspace(-20.0, 30.0, 40), starts("top", 5)
    code = compiled(DECOMPOSITIONS["top"], ORDER, 4)
    at_once, tasks, _ = integrated(code, states, times)
    rows, again, _ = integrated(code, states, times, budget=budget)
    np.testing.assert_array_equal(rows, at_once)
    np.testing.assert_array_equal(again["steps"], tasks["steps"])


def test_tasks_that_pause_go_on_when_they_are_put_back():
    code, times = compiled(DECOMPOSITIONS["top"], ORDER, 4), np.linspace(0.0, 30.0, 40)[1:]
    rows, tasks, _ = integrated(code, starts("top", 6), times)
    again, numbers = np.full_like(rows, np.nan), np.zeros(6, dtype=int)
    queue = Queue(
        code,
        starts("top", 6),
        np.zeros(6),
        np.zeros((6, 0)),
        Output.of(times, again, np.arange(6), numbers, numbers + 39, numbers + 1),
    )
    queue.tasks["pause"][:4], run = 10, Worker(code)
    run.start(queue)
    run.advance()
    paused = np.flatnonzero(queue.tasks["status"] == Status.PAUSED)
    np.testing.assert_array_equal(paused, range(4))
    np.testing.assert_array_equal(queue.tasks["steps"][paused], 10)
    assert np.all(np.isnan(again[paused, -1]))
    queue.tasks["pause"] = FOREVER
    queue.put(paused)
    assert not run.advance()
    np.testing.assert_array_equal(again, rows)
    np.testing.assert_array_equal(queue.tasks["steps"], tasks["steps"])


def test_an_interrupted_run_goes_on_later():
    code, times, states = compiled(DECOMPOSITIONS["top"], ORDER, 4), np.linspace(0.0, 30.0, 40)[1:], starts("top", 20)
    rows, _, _ = integrated(code, states, times)
    again, zeros = np.full_like(rows, np.nan), np.zeros(20, dtype=int)
    output = Output.of(times, again, np.arange(20), zeros, zeros + 39, zeros + 1)
    queue, run = Queue(code, states, np.zeros(20), np.zeros((20, 0)), output), Worker(code)
    run.start(queue)
    assert run.advance(20)
    assert np.all((run.times > 5.0) & (run.times < 15.0))
    run.finish()
    assert run.times.size == 0
    np.testing.assert_array_equal(queue.tasks["status"], [Status.PAUSED] * 4 + [Status.UNDER_WAY] * 16)
    np.testing.assert_array_equal(queue.tasks["steps"], [21] * 4 + [0] * 16)
    reached = np.searchsorted(times, queue.tasks["time"][:, 0], side="right")
    np.testing.assert_array_equal(queue.tasks["index"], reached)
    np.testing.assert_array_equal(np.isnan(again[:, :, 0]), np.arange(39) >= reached[:, None])
    queue.put(np.arange(20))
    run.start(queue)
    assert not run.advance()
    np.testing.assert_array_equal(again, rows)


def test_rows_must_be_contiguous():
    code, rows, zeros = (
        compiled(DECOMPOSITIONS["top"], ORDER, 4),
        np.zeros((2, 1, 14))[:, :, ::2],
        np.zeros(1, dtype=int),
    )
    output = Output.of(np.array([1.0]), rows, zeros, zeros, zeros + 1, zeros + 1)
    with pytest.raises(ValueError, match="times and rows must be C-contiguous"):
        Queue(code, starts("top"), np.zeros(1), np.zeros((1, 0)), output)


def test_a_parameter_selects_one_of_two_values():
    """x' = 2 p_1 where p_0 is not zero, x elsewhere; y' = x or 0.5, the other way round."""
    operations = (Variable(0), Select(0, Coefficient(2.0, 1), 0), Select(0, 0, Coefficient(0.5)))
    code = compiled(Decomposition(operations, (1, 2), 2), ORDER, 2)
    parameters = np.array([[0.0, 0.3], [1.0, 0.3], [-2.0, -0.1]])
    rows, _, _ = integrated(code, np.full((3, 2), 0.5), [2.0], parameters=parameters)
    expected = [[0.5 * np.exp(2.0), 1.5], [1.7, 2.7], [0.1, 1.1]]
    np.testing.assert_allclose(rows[:, 0], expected, rtol=4 * EPS)


def test_what_has_no_recurrence_is_refused():
    with pytest.raises(TypeError, match="operation must be one with a recurrence, got"):
        compiled(Decomposition((Variable(0), object()), (1,), 0), ORDER, 1)


def test_no_step_is_longer_than_the_limit():
    def limited(tasks):
        tasks["limit"] = [0.1, 0.2]

    _, tasks, _ = integrated(compiled(DECOMPOSITIONS["top"], ORDER, 2), starts("top", 2), [10.0], change=limited)
    np.testing.assert_array_equal(np.abs(tasks["steps"] - [100, 50]) <= 1, True)


def test_the_time_is_compensated():
    """x' = cos(t) far from t = 0, where the time has few digits left."""
    decomposition = decomposed(1, lambda x, t: [sine_and_cosine(t)[1] + 0.0 * x[0]])
    start = 2.0**32
    _, _, run = integrated(compiled(decomposition, ORDER, 1), np.zeros((1, 1)), [start + 300.0], origin=start)
    steps = np.concatenate(run.steps)
    ends = np.longdouble(steps["start"][1:, 0]) - steps["start"][:-1, 0] - steps["length"][:-1]
    np.testing.assert_allclose(np.float64(ends) + np.diff(steps["start"][:, 1]), 0.0, rtol=0, atol=1e-20)


@pytest.mark.parametrize(("lanes", "layout"), [(1, "single"), (1, "batch"), (4, "batch")])
def test_momenta_are_rescaled_where_they_leave_their_band(lanes, layout):
    """m' = -k m + f, k to power 0 and f to power 1 of the scale, and x' = g m, g to power -1.

    Momenta that fall by exp(-25) lose 25 roundings of their rates.
    """
    momenta = Momenta((0, 1), (0, 1), (0, 1, -1))

    def rates(states, _):
        m1, m2, _ = states
        k = Coefficient(-1.0, 0)
        return [k * m1 + Coefficient(1.0, 1), k * m2 - 0.5 * m1, Coefficient(1.0, 2) * m1]

    code = compiled(decomposed(3, rates, 3, momenta=momenta), ORDER, lanes, layout)
    times = np.array([5.0, 15.0, 25.0])
    parameters = np.array([[1.0, 0.0, 0.25], [-1.0, 0.0, 0.25], [1.0, 1e-6, 0.25]])
    states = np.array([[0.8, 0.0, 0.5], [0.05, 0.0, 0.5], [0.8, 0.0, 0.5]])
    rows, tasks, run = integrated(code, states, times, parameters=parameters)
    np.testing.assert_array_equal(tasks["status"], Status.DONE)
    if code.lanes == 1:  # stored steps are in the scale of the start
        (stored,) = run.steps
        first = stored[stored["task"] == 0]
        m = 0.8 * np.exp(-first["start"][:, :1])
        np.testing.assert_allclose(first["coefficients"][:, :2, 0], m * [1, -1], rtol=100 * EPS)
    for row, (k, f, g), (m1, _, x) in zip(rows, parameters, states, strict=True):
        decay = np.exp(-k * times)
        exact = (m1 - f / k) * decay + f / k
        np.testing.assert_allclose(row[:, 0], exact, rtol=100 * EPS)
        np.testing.assert_allclose(row[:, 2], x + g * ((m1 - f / k) * (1 - decay) / k + f / k * times), rtol=4 * EPS)
    sizes = np.ldexp(np.linalg.norm(rows[:, -1, :2], axis=1), tasks["exponent"])
    assert np.all((sizes > MIN_MOMENTUM / 3) & (sizes < 3 * MAX_MOMENTUM))  # they were within as the last step began
    assert np.all(np.abs(tasks["exponent"]) > 10)
    np.testing.assert_array_equal(tasks["state"], rows[:, -1])


def test_momenta_stay_in_their_scale_where_no_other_is_better(monkeypatch):
    """Those that forces give a body at rest keep the scale; so does its range."""
    monkeypatch.setattr(rescaling, "EXPONENT_RANGE", (-3, 5))
    decomposition = decomposed(1, lambda x, _: [-1.0 * x[0]], momenta=Momenta((0,), (0,), ()))
    code = Code(KernelProgram(decomposition, ORDER, 2, "batch"))

    def pushed(tasks):
        tasks["torque_scale"][1] = 0.01

    rows, tasks, _ = integrated(code, np.array([[0.5], [0.5], [0.0], [100.0]]), [20.0], change=pushed)
    np.testing.assert_array_equal(tasks["exponent"], [5, 0, 0, 5])
    np.testing.assert_allclose(rows[:, 0, 0], np.array([0.5, 0.5, 0.0, 100.0]) * np.exp(-20.0), rtol=2e-9, atol=0)


@pytest.mark.parametrize("lanes", [1, 2])
def test_momenta_that_shrink_lose_what_is_along_their_quaternions(lanes):
    """Two quaternions at rest, q' = 0 and Q' = k Q: conjugate momenta that shrink (k < 0) lose their part along q."""
    q = np.array([[0.5, -1.1, 0.2, 0.8], [-0.3, 0.9, 1.2, 0.4]])
    Q = np.array([[0.4, 0.1, -0.3, 0.2], [0.1, 0.6, 0.2, 0.3]])
    places = tuple(range(8, 16))
    momenta = Momenta(places, places, (0,), conjugates=((0, 8), (4, 12)))

    def rates(states, _):
        return [0.0 * x for x in states[:8]] + [Coefficient(1.0, 0) * x for x in states[8:]]

    code = compiled(decomposed(16, rates, 1, momenta=momenta), ORDER, lanes)
    k, time = np.array([[-1.0], [1.0]]), 10.0
    rows, *_ = integrated(code, np.tile([*q.flat, *Q.flat], (2, 1)), [time], parameters=k)
    shares = np.sum(q * Q, axis=1) / np.sum(q * q, axis=1)
    assert np.all(np.abs(shares) > 0.05)
    found = rows[:, 0, 8:].reshape(2, 2, 4) * np.exp(-k * time)[:, :, None]
    np.testing.assert_allclose(found, [Q - shares[:, None] * q, Q], rtol=0, atol=1e-12)  # as the decays above


def test_stored_steps_are_the_polynomials_of_the_run():
    code, start, end = compiled(DECOMPOSITIONS["top"], ORDER, 1, "single"), starts("top"), 400.0
    rows, tasks, run = integrated(code, start, [-5.0, end])
    steps = np.concatenate(run.steps)
    assert len(steps) == tasks["steps"].sum() > 2 * STEPS_IN_BLOCK
    forwards = steps[steps["task"] == 0]
    np.testing.assert_array_equal(steps["task"][len(forwards) :], 1)
    np.testing.assert_array_equal(np.sign(steps["length"]), np.where(steps["task"] == 0, 1, -1))
    np.testing.assert_array_equal(forwards["coefficients"][0, 0], start[0])
    powers = forwards["length"][:, None] ** np.arange(ORDER + 1)
    ends = np.einsum("sn,snk->sk", powers, forwards["coefficients"])
    np.testing.assert_allclose(ends[:-1], forwards["coefficients"][1:, 0], rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(ends[-1], rows[0, 1], rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(
        forwards["start"][:, 0] + forwards["length"], np.append(forwards["start"][1:, 0], end), rtol=2 * EPS
    )


def of_angles(function, angles, lanes):
    """Return a function's values, as rates that a step of length one adds to zero."""
    code = compiled(decomposed(2, lambda x, _: [0.0 * x[0], function(x[0])]), 2, lanes)
    return integrated(code, np.stack([angles, np.zeros_like(angles)], axis=1), [1.0])[0][:, 0, 1]


def nearest_to_quarter_turns(count):
    """Return the numbers of the first 60,000 next to multiples of pi/2 that are nearest to them."""
    k = np.arange(1.0, 60_001.0)
    angles = k * (np.pi / 2)
    high = np.float64(np.float32(np.pi / 2))
    rest = (angles - k * high) - k * (np.pi / 2 - high) - k * 6.123233995736766e-17
    return angles[np.argsort(np.abs(rest))[:count]]


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_of_any_angle(name):
    generator = np.random.default_rng(1)
    sizes = 10.0 ** generator.uniform(-10, 20, 900) * generator.choice([-1, 1], 900)
    angles = np.concatenate([nearest_to_quarter_turns(100), sizes, [0.0]])
    found = of_angles(lambda x: sine_and_cosine(x)[name == "cos"], angles, 8)
    with mpmath.workdps(50):
        exact = np.array([float(getattr(mpmath, name)(mpmath.mpf(float(x)))) for x in angles])
    np.testing.assert_allclose(found, exact, rtol=2 * EPS, atol=0)
    np.testing.assert_array_equal(of_angles(lambda x: sine_and_cosine(x)[name == "cos"], angles, 2), found)


@pytest.mark.parametrize("eccentricity", [0.0, 1e-12, 0.2, 0.9, 1 - 1e-6, 1 - 2.0**-53])
def test_eccentric_anomaly(eccentricity):
    generator = np.random.default_rng(1)
    small = 10.0 ** generator.uniform(-18, 0.4, 200) * generator.choice([-1, 1], 200)
    angles = np.concatenate([small, generator.uniform(-3e5, 3e5, 100), [0.0, np.pi, -np.pi]])
    found = of_angles(lambda x: of_eccentric_anomaly(eccentricity, x)[2], angles, 4)
    with mpmath.workdps(60):
        e = mpmath.mpf(eccentricity)
        for angle, value in zip(angles, found, strict=True):
            mean, own = mpmath.mpf(float(angle)), mpmath.mpf(float(value))
            excess = own - e * mpmath.sin(own) - mean
            excess -= 2 * mpmath.pi * mpmath.nint(excess / (2 * mpmath.pi))
            assert abs(value) < 3.15
            assert abs(excess / (1 - e * mpmath.cos(own))) <= 4 * EPS * abs(own), (angle, value)


@pytest.mark.parametrize(("name", "function"), [("sine_defect", mpmath.sin), ("asinh_defect", mpmath.asinh)])
def test_what_an_angle_differs_by(name, function):
    generator = np.random.default_rng(1)
    sizes = np.concatenate([10.0 ** generator.uniform(-50, 6, 300), [1.99, 2.01, 3.6, 3.7, 0.0]])
    angles = sizes * generator.choice([-1, 1], sizes.size)
    found = of_angles(lambda x: x.function(name, slopes=lambda _: (0.0,)), angles, 4)
    with mpmath.workdps(250):
        exact = np.array([float(x - function(x)) for x in map(mpmath.mpf, angles)])
    # Three times the error of asinh, of two roundings, and those of the series.
    np.testing.assert_allclose(found, exact, rtol=10 * EPS, atol=0)


def test_threads_share_a_queue():
    code, times, count = compiled(DECOMPOSITIONS["top"], ORDER, 4), np.linspace(0.0, 20.0, 5)[1:], 60
    expected, _, _ = integrated(code, starts("top", count), times)
    rows, zeros = np.full_like(expected, np.nan), np.zeros(count, dtype=int)
    output = Output.of(times, rows, np.arange(count), zeros, zeros + 4, zeros + 1)
    queue = Queue(code, starts("top", count), np.zeros(count), np.zeros((count, 0)), output)

    def work():
        run = Worker(code)
        run.start(queue)
        while run.advance(20):
            pass

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(rows, expected)


def test_a_kernel_is_compiled_once_for_a_structure():
    again = decomposed(7, SYSTEMS["top"][0])
    assert compiled(again, ORDER, 4) is compiled(DECOMPOSITIONS["top"], ORDER, 4)
    assert compiled(again, ORDER, 4) is not compiled(again, ORDER + 1, 4)


def test_llvmlite_is_imported_where_a_kernel_is_compiled():
    code = "import sys, poinsot.taylor.kernels; sys.exit(any('llvmlite' in name for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
