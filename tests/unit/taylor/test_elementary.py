"""Double-double arithmetic and its elementary functions against mpmath, over their domains and at special values."""

import ctypes
import functools
import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from poinsot.taylor.decomposition import Coefficient
from poinsot.taylor.elementary import elementary
from poinsot.taylor.llvm_ir import (
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    Module,
    Wide,
    WideValue,
    vector,
)
from poinsot.taylor.object_cache import machine_code

COUNT = 64
UNIT = mpf(2) ** -106


@pytest.fixture(autouse=True)
def many_digits():
    with mpmath.workprec(700):
        yield


def written(name, *arguments):
    return elementary(name, (0,) * len(arguments), arguments)


OPERATIONS: dict[str, Any] = {
    "sum": (lambda a, b: a + b, lambda a, b: a + b, 2),
    "difference": (lambda a, b: a - b, lambda a, b: a - b, 2),
    "product": (lambda a, b: a * b, lambda a, b: a * b, 2),
    "quotient": (lambda a, b: a / b, lambda a, b: a / b, 2),
    "third": (lambda a: a * Fraction(1, 3), lambda a: a / 3, 1),
    "difference from a number": (lambda a: 1.0 - a, lambda a: 1 - a, 1),
    "number over it": (lambda a: 1.0 / a, lambda a: 1 / a, 1),
    "sum of products": (
        lambda a, b: a.product_added(b, b.product_added(b, a)).normalized(),
        lambda a, b: a * b + b * b + a,
        2,
    ),
    "larger": (lambda a, b: a.larger(b), max, 2),
    "absolute value": (abs, abs, 1),
}


@functools.cache
def compiled(name, lanes=8):
    """Return a function of arrays of high parts and low parts, each (arguments, n), to arrays of both parts."""
    count = OPERATIONS[name][2] if name in OPERATIONS else 1 + (name in ("atan2", "eccentric_anomaly", "pow"))
    module, kind = Module(), vector(DOUBLE, lanes)

    def body(given, results, blocks):
        parts, out = Array(given, kind), Array(results, kind)

        def one(i):
            operands = [WideValue(*(parts[blocks * (2 * k + half) + i] for half in (0, 1))) for k in range(count)]
            found = OPERATIONS[name][0](*operands) if name in OPERATIONS else written(name, *operands)
            for half, part in enumerate(found.parts):
                out[blocks * half + i] = part

        blocks.function.count(blocks, one)

    module.function("evaluate", "void", [POINTER, POINTER, INTEGER], body)
    engine = machine_code(str(module))
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)(
        engine.get_function_address("evaluate")
    )

    def evaluated(parts, engine=engine):  # noqa: ARG001
        given, results = aligned(parts.size), aligned(2 * parts.shape[-1])
        given[:] = parts.ravel()
        function(given.ctypes.data, results.ctypes.data, parts.shape[-1] // lanes)
        return results.reshape(2, -1).copy()

    return evaluated


def aligned(size):
    memory = np.zeros(8 * size + 64, np.uint8)
    start = -memory.ctypes.data % 64
    return memory[start : start + 8 * size].view(float)


def parts_of(*arguments):
    """Return numbers as two doubles each, (arguments, 2, n)."""
    high = np.array([[float(x) for x in each] for each in arguments])
    low = [
        [float(x - mpf(h)) for x, h in zip(each, row, strict=True)] for each, row in zip(arguments, high, strict=True)
    ]
    return np.stack([high, np.array(low)], axis=1)


def numbers(parts):
    return [mpf(float(high)) + mpf(float(low)) for high, low in parts.T]


def with_low_parts(values, rng):
    """Return numbers of 32 digits near doubles, as the sum of two doubles."""
    wide = [
        mpf(float(x)) * (1 + mpf(u) * mpf(2) ** -54)
        for x, u in zip(values, rng.uniform(-1, 1, len(values)), strict=True)
    ]
    return numbers(parts_of(wide)[0])


def powers(rng, least, most):
    return 10 ** rng.uniform(least, most, COUNT)


def signs(rng):
    return rng.choice([-1, 1], COUNT)


def near_quarters(rng):
    return np.pi / 2 * rng.integers(-50, 50, COUNT) + 1e-10 * rng.standard_normal(COUNT)


def anomaly(e, mean):
    reduced = mean - 2 * mpmath.pi * mpmath.nint(mean / (2 * mpmath.pi))
    size, E = abs(reduced), mpmath.pi
    for _ in range(300):
        change = (E - e * mpmath.sin(E) - size) / (1 - e * mpmath.cos(E))
        E -= change
        if abs(change) < E * mpf(2) ** -220:
            break
    return mpmath.sign(reduced) * E


FUNCTIONS: dict[str, Any] = {
    "sin": (mpmath.sin, 4, [lambda r: (signs(r) * powers(r, -20, 14),), lambda r: (near_quarters(r),)]),
    "cos": (mpmath.cos, 4, [lambda r: (signs(r) * powers(r, -20, 14),), lambda r: (near_quarters(r),)]),
    "tan": (mpmath.tan, 12, [lambda r: (signs(r) * powers(r, -20, 3),), lambda r: (near_quarters(r),)]),
    "exp": (mpmath.exp, 5, [lambda r: (signs(r) * powers(r, -20, 0),), lambda r: (r.uniform(-600, 700, COUNT),)]),
    "tanh": (mpmath.tanh, 26, [lambda r: (signs(r) * powers(r, -20, 2),), lambda r: (r.uniform(-1, 1, COUNT),)]),
    "log": (
        mpmath.log,
        17,
        [
            lambda r: (powers(r, -280, 300),),
            lambda r: (1 + signs(r) * powers(r, -15.9, -0.05),),
            lambda r: (r.uniform(0.5, 2, COUNT),),
        ],
    ),
    "asinh": (mpmath.asinh, 16, [lambda r: (signs(r) * powers(r, -20, 5),), lambda r: (signs(r) * powers(r, 5, 300),)]),
    "atan": (
        mpmath.atan,
        5,
        [lambda r: (signs(r) * powers(r, -20, 20),), lambda r: (signs(r) * powers(r, -200, 300),)],
    ),
    "asin": (
        mpmath.asin,
        9,
        [
            lambda r: (r.uniform(-1, 1, COUNT),),
            lambda r: (signs(r) * (1 - powers(r, -15.9, -1)),),
            lambda r: (powers(r, -20, -1),),
        ],
    ),
    "acos": (
        mpmath.acos,
        9,
        [
            lambda r: (r.uniform(-1, 1, COUNT),),
            lambda r: (signs(r) * (1 - powers(r, -15.9, -1)),),
            lambda r: (powers(r, -20, -1),),
        ],
    ),
    "atan2": (
        mpmath.atan2,
        5,
        [
            lambda r: (signs(r) * powers(r, -20, 20), signs(r) * powers(r, -20, 20)),
            lambda r: (signs(r) * powers(r, -100, 100), signs(r) * powers(r, -100, 100)),
        ],
    ),
    "sine_defect": (
        lambda x: x - mpmath.sin(x),
        12,
        [lambda r: (signs(r) * powers(r, -20, 2),), lambda r: (r.uniform(-4, 4, COUNT),)],
    ),
    "asinh_defect": (
        lambda x: x - mpmath.asinh(x),
        60,
        [lambda r: (signs(r) * powers(r, -20, 5),), lambda r: (r.uniform(-4, 4, COUNT),)],
    ),
    "eccentric_anomaly": (
        anomaly,
        8,
        [
            lambda r: (r.uniform(0, 0.99, COUNT), r.uniform(-20, 20, COUNT)),
            lambda r: (1 - powers(r, -15, -1), signs(r) * powers(r, -12, 0.4)),
            lambda r: (r.uniform(0, 1, COUNT), np.pi * signs(r) + 1e-14 * r.standard_normal(COUNT)),
        ],
    ),
    "pow": (
        mpmath.power,
        17,
        [
            lambda r: (powers(r, -10, 10), r.uniform(-9, 9, COUNT)),
            lambda r: (1 + 0.1 * r.standard_normal(COUNT), r.uniform(-30, 30, COUNT)),
        ],
    ),
}
"""Reference, bound and arguments. A bound is three times the largest relative error of 256 arguments of each kind and
four seeds, in units of 2^-106; errors of general powers are also relative to 1 + |y log x|."""


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 8))])
def test_elementary_functions(name, seed):
    reference, bound, kinds = FUNCTIONS[name]
    for kind in kinds:
        rng = np.random.default_rng(seed)
        arguments = [with_low_parts(values, rng) for values in kind(rng)]
        if name in ("asin", "acos"):
            arguments = [[max(min(x, mpf(1)), mpf(-1)) for x in arguments[0]]]
        for found, *given in zip(numbers(compiled(name)(parts_of(*arguments))), *arguments, strict=True):
            expected = reference(*given)
            scale = abs(expected) * (1 + abs(given[1] * mpmath.log(given[0])) if name == "pow" else 1)
            error = abs(found - expected)
            if name == "eccentric_anomaly":
                error = abs(error - 2 * mpmath.pi * mpmath.nint(error / (2 * mpmath.pi)))
            assert error <= bound * UNIT * scale, (name, given)


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_phases_of_large_angles_have_the_digits_of_the_angle(name):
    rng = np.random.default_rng(3)
    angles = with_low_parts(signs(rng) * powers(rng, 14, 30), rng)
    for found, angle in zip(numbers(compiled(name)(parts_of(angles))), angles, strict=True):
        assert abs(found - getattr(mpmath, name)(angle)) < UNIT * (4 + abs(angle) * mpf(2) ** -45)
    beyond = compiled(name)(parts_of([mpf(2) ** 101] * 8))
    assert np.all(np.isnan(beyond[0]))


@pytest.mark.parametrize("name", OPERATIONS)
def test_arithmetic(name):
    _, reference, count = OPERATIONS[name]
    rng = np.random.default_rng(4)
    arguments = [with_low_parts(signs(rng) * powers(rng, -3, 3), rng) for _ in range(count)]
    for found, *given in zip(numbers(compiled(name)(parts_of(*arguments))), *arguments, strict=True):
        size = sum(map(abs, given)) + sum(x * x for x in given) if name == "sum of products" else 0
        # Derived bounds of the algorithms: 3 units, 10 of a quotient (Joldes, Muller and Popescu 2017).
        assert abs(found - reference(*given)) <= 10 * UNIT * max(abs(reference(*given)), size)


@pytest.mark.parametrize("name", ["sin", "exp", "log", "atan2", "eccentric_anomaly", "quotient"])
def test_lanes_do_not_change_a_bit(name):
    rng = np.random.default_rng(5)
    count = 1 + (name in ("atan2", "eccentric_anomaly", "quotient"))
    parts = parts_of(*(with_low_parts(rng.uniform(0.1, 0.9, COUNT), rng) for _ in range(count)))
    expected = compiled(name)(parts)
    for lanes in (1, 2, 4):
        assert np.array_equal(compiled(name, lanes)(parts), expected)


SPECIAL = {
    "exp": {-math.inf: 0.0, math.inf: math.inf, -800.0: 0.0, 800.0: math.inf, 0.0: 1.0},
    "log": {0.0: -math.inf, -1.0: math.nan, math.inf: math.inf, 1.0: 0.0},
    "tanh": {math.inf: 1.0, -math.inf: -1.0, 0.0: 0.0, 300.0: 1.0, math.nan: math.nan},
    "atan": {math.inf: math.pi / 2, -math.inf: -math.pi / 2, 0.0: 0.0},
    "asin": {0.0: 0.0, 1.5: math.nan},
    "acos": {1.0: 0.0, -1.5: math.nan},
    "asinh": {0.0: 0.0},
    "sin": {0.0: 0.0, math.nan: math.nan, math.inf: math.nan},
    "sine_defect": {0.0: 0.0},
}


@pytest.mark.parametrize("name", SPECIAL)
def test_special_values(name):
    values = np.array([*SPECIAL[name], *[0.5] * 8])[:8]
    found = compiled(name)(np.stack([[values], np.zeros((1, 8))], axis=1))[0]
    for value, result in zip(values, found, strict=True):
        if value in SPECIAL[name] or math.isnan(value):
            expected = next(y for x, y in SPECIAL[name].items() if x == value or (math.isnan(x) and math.isnan(value)))
            np.testing.assert_equal(result, np.float64(expected))


def test_angles_and_powers_at_special_values():
    y, x = (
        np.array([0.0, 0.0, -0.0, 1.0, -1.0, math.inf, 0.0, 1e-300]),
        np.array([0.0, -1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1e300]),
    )
    found = compiled("atan2")(np.stack([np.stack([y, x]), np.zeros((2, 8))], axis=1))[0]
    np.testing.assert_equal(found, np.arctan2(y, x))
    x, y = (
        np.array([-2.0, -2.0, 0.0, 0.0, 2.0, -2.0, 1.0, 0.0]),
        np.array([9.0, 10.0, 3.0, -3.0, 2000.0, 0.3, 5.0, 0.0]),
    )
    found = compiled("pow")(np.stack([np.stack([x, y]), np.zeros((2, 8))], axis=1))[0]
    with np.errstate(all="ignore"):
        np.testing.assert_equal(found, np.power(x, y))


def test_constant_powers_are_products_of_roots():
    module = Module()

    def body(given):
        x = WideValue(*(Array(given, DOUBLE)[i] for i in (0, 1)))
        found = elementary("pow", (0, Coefficient(-1.5)), [x, x.like(-1.5)])
        for i, part in enumerate(found.parts):
            Array(given, DOUBLE)[i] = part

    module.function("evaluate", "void", [POINTER], body)
    assert "wide_pow" not in module.functions
    engine = machine_code(str(module))
    memory = parts_of([mpf(7) / 10])[0].ravel().copy()
    ctypes.CFUNCTYPE(None, ctypes.c_void_p)(engine.get_function_address("evaluate"))(memory.ctypes.data)
    assert abs(sum(map(mpf, memory.tolist())) / (mpf(7) / 10) ** mpf(-1.5) - 1) < 16 * UNIT


def test_loops_branches_and_memory_hold_double_double_numbers():
    """The sum of 1/k for k from 1 to n, of numbers that go through a loop, a branch, a call and an array."""
    module, wide = Module(), Wide(DOUBLE)
    module.function("reciprocal", wide, [wide], lambda x: 1.0 / x)

    def body(memory, count):
        numbers, lines = Array(memory, Wide(DOUBLE), 4), memory.function

        def add(k, total):
            own = lines.call(wide, "reciprocal", lines.constant(wide, 0.0).like(k.to_double()))
            (term,) = lines.either(k.is_("gt", 0), [own], lambda: [own * 1.0])
            numbers[2] = total + term
            return [k + 1, numbers[2]]

        start = [lines.constant(INTEGER, 1), lines.constant(wide, 0.0)]
        _, total = lines.repeat(start, lambda k, _: k.is_("le", count), add)
        numbers[0] = total.is_("gt", 1.0).choose(total, -total)

    module.function("evaluate", "void", [POINTER, INTEGER], body)
    engine = machine_code(str(module))
    memory = np.zeros(8)
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)(engine.get_function_address("evaluate"))
    function(memory.ctypes.data, 100)
    expected = sum(mpf(1) / k for k in range(1, 101))
    assert abs(mpf(memory[0]) + mpf(memory[4]) - expected) < 400 * UNIT
