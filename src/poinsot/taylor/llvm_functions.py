"""Elementary functions of vectors in LLVM's representation: the same bits in vectors of any length.

Sine, cosine, the eccentric anomaly and powers with a half of an integer are vectors' own; the others call the C library
for each number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from poinsot.taylor.decomposition import Coefficient, Operand
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Value

__all__ = [
    "LIBRARY",
    "each",
    "eccentric_anomaly",
    "elementary",
    "halves_of",
    "power_of_root",
    "rough_exp2",
    "rough_log2",
]

LIBRARY = ("acos", "asin", "asinh", "atan", "atan2", "cos", "exp", "log", "log2", "pow", "sin", "tan", "tanh")
"""The functions of the C library that kernels may call."""

HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)
"""pi/2 in three parts, each the rest to double precision."""

MAX_REDUCED_ANGLE = 2.0**48
"""Angles beyond which the C library reduces them: the number of quarter turns must have fewer than 51 bits."""

SINE = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
COSINE = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
"""Coefficients of sine and cosine of fdlibm, up to pi/4."""

SINE_DEFECT = tuple((-1.0) ** k / math.factorial(2 * k + 3) for k in range(12))
"""x - sin x over x^3, in powers of x^2; up to 2."""

ROUNDING_SHIFT = 6755399441055744.0
"""1.5 2^52: a number with this added and taken away again is rounded to an integer, the low bits of the sum."""

MAX_HALVES = 16
"""Twice the powers that are products of roots."""

MAX_ITERATIONS, CONVERGED = 60, 2.0**-14
"""Of Kepler's equation; the relative change after which the next one would be below rounding."""


def elementary(name: str, operands: Sequence[Operand], values: Sequence[Value]) -> Value:
    """Write an elementary function of the values of operands."""
    match name:
        case "sqrt":
            return values[0].sqrt()
        case "sin" | "cos":
            return _sine_and_cosine(values[0]).part(int(name == "cos"))
        case "eccentric_anomaly":
            return eccentric_anomaly(*values)
        case "sine_defect" | "asinh_defect":
            return _defect(name, values[0])
        case "pow" if halves := halves_of(operands[1]):
            return power_of_root(values[0], halves)
    return each(name, values)


def halves_of(exponent: Operand) -> int:
    """Return twice an exponent if a power is a product of roots, otherwise 0."""
    if isinstance(exponent, Coefficient) and exponent.parameter is None:
        halves = 2 * exponent.number
        return int(halves) if halves == int(halves) and abs(halves) <= MAX_HALVES else 0
    return 0


def each(name: str, arguments: Sequence[Value]) -> Value:
    """Call the C library for each number."""
    lanes, kind = arguments[0].lanes, arguments[0].type
    if lanes == 1:
        return arguments[0].function.call(DOUBLE, name, *arguments)
    own = f"each_{name}"

    def body(*vectors: Value) -> Value:
        lines, result = vectors[0].function, vectors[0]
        for lane in range(lanes):
            number = lines.call(DOUBLE, name, *(value.lane(lane) for value in vectors))
            result = result.with_lane(lane, number)
        return result

    lines = arguments[0].function
    lines.module.function(own, kind, [kind] * len(arguments), body)
    return lines.call(kind, own, *arguments)


def power_of_root(x: Value, halves: int) -> Value:
    """Return x^(halves / 2)."""
    whole, factors = abs(halves) // 2, [x.sqrt()] if halves % 2 else []
    while whole:
        factors += [x] if whole % 2 else []
        whole //= 2
        x = x * x if whole else x
    result = math.prod(factors[1:], start=factors[0])
    return result if halves > 0 else 1.0 / result


def _polynomial(x: Value, coefficients: Sequence[float]) -> Value:
    value = x.like(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = value.fma(x, coefficient)
    return value


def _reduced(x: Value, parts: Sequence[float]) -> tuple[Value, Value]:
    """Return x less the nearest multiple of an angle that is given in parts, and which, plus `ROUNDING`."""
    count = x.fma(1.0 / parts[0], ROUNDING_SHIFT)
    rounded = count - ROUNDING_SHIFT
    for part in parts:
        x = (-rounded).fma(part, x)  # the first one is exact
    return x, count


def _sine_and_cosine(x: Value) -> Value:
    both, name = f"{{{x.type}, {x.type}}}", f"sine_and_cosine_{x.lanes}"
    x.function.module.function(name, both, [x.type], _written_sine_and_cosine)
    return x.function.call(both, name, x)


def _written_sine_and_cosine(x: Value) -> Value:
    lines = x.function
    r, count = _reduced(x, HALF_PI)
    z = r * r
    sine = (r * z).fma(_polynomial(z, SINE), r)
    half = 0.5 * z
    most = 1.0 - half
    cosine = most + (z * z).fma(_polynomial(z, COSINE), (1.0 - most) - half)
    quadrant = count.as_bits()
    odd = (quadrant & 1).is_("eq", 1)
    signs = ((quadrant & 2) << 62, ((quadrant + 1) & 2) << 62)
    values = (odd.choose(cosine, sine), odd.choose(sine, cosine))
    near = [(value.as_bits() ^ sign).as_double() for value, sign in zip(values, signs, strict=True)]
    far = abs(x).is_("gt", MAX_REDUCED_ANGLE)

    def exact() -> list[Value]:
        return [far.choose(each(name, [x]), value) for name, value in zip(("sin", "cos"), near, strict=True)]

    return lines.struct(*lines.either(far.any(), near, exact))


def eccentric_anomaly(eccentricity: Value, mean_anomaly: Value) -> Value:
    """Return the eccentric anomaly."""
    lines, kind, name = eccentricity.function, eccentricity.type, f"eccentric_anomaly_{eccentricity.lanes}"
    lines.module.function(name, kind, [kind, kind], _written_eccentric_anomaly)
    return lines.call(kind, name, eccentricity, mean_anomaly)


def _written_eccentric_anomaly(eccentricity: Value, mean_anomaly: Value) -> Value:
    """Solve E - e sin E = M by Danby's method of order four, for E between -pi and pi."""
    lines = mean_anomaly.function
    reduced, _ = _reduced(mean_anomaly, [4.0 * part for part in HALF_PI])
    far = abs(mean_anomaly).is_("gt", MAX_REDUCED_ANGLE)

    def exact() -> list[Value]:
        both = _sine_and_cosine(mean_anomaly)
        return [far.choose(each("atan2", [both.part(0), both.part(1)]), reduced)]

    (reduced,) = lines.either(far.any(), [reduced], exact)
    size, rest = abs(reduced), 1.0 - eccentricity
    # E - sin E is at least E^3 / pi^2.
    cubic = 1.02 * rough_exp2(rough_log2((math.pi**2 * size).larger(1e-300)) * (1 / 3))
    start = (size + eccentricity).smaller(size / rest).smaller(cubic).smaller(math.pi)

    def step(anomaly: Value, left: Value, going: Value) -> list[Value]:
        both = _sine_and_cosine(0.5 * anomaly)
        twice = 2.0 * both.part(0)
        slope = (eccentricity * twice).fma(both.part(0), rest)
        half, sixth = 0.5 * eccentricity * twice * both.part(1), (1.0 - slope) * (1 / 6)  # second and third derivative
        square = anomaly * anomaly
        near = (anomaly * square) * _polynomial(square, SINE_DEFECT)
        defect = anomaly.is_("lt", 1.5).choose(near, (-twice).fma(both.part(1), anomaly))
        excess = -rest.fma(anomaly, eccentricity.fma(defect, -size))
        change = excess / slope
        change = excess / half.fma(change, slope)
        change = excess / change.fma(sixth.fma(change, half), slope)
        again = going & abs(change).is_("gt", anomaly * CONVERGED)
        return [going.choose(anomaly + change, anomaly), left - 1, again]

    anomaly, _, _ = lines.repeat(
        [start, lines.constant(INTEGER, MAX_ITERATIONS), size.is_("ge", 0.0)],
        lambda _, left, going: left.is_("gt", 0) & going.any(),
        step,
    )
    return anomaly.intrinsic("copysign", reduced)


def _defect(name: str, x: Value) -> Value:
    """Return x - sin x, or x - asinh x, which is sinh u - u for u = asinh x, up to its sign."""
    of_sine = name == "sine_defect"
    angle = x if of_sine else each("asinh", [x])
    square = angle * angle
    near = angle * square * _polynomial(square, [c if of_sine else abs(c) for c in SINE_DEFECT])
    return square.is_("lt", 4.0).choose(near, x - (_sine_and_cosine(x).part(0) if of_sine else angle))


def rough_log2(x: Value) -> Value:
    """Return the logarithm of a positive number to 0.01."""
    bits = x.as_bits()
    exponent = ((bits >> 52) | 0x4330000000000000).as_double() - (2.0**52 + 1023)
    m = ((bits & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000).as_double() - 1.0
    return exponent + (m + 0.3437 * m * (1.0 - m))


def rough_exp2(x: Value) -> Value:
    """Return the power of two to 0.001."""
    x = x.larger(-1000.0).smaller(1000.0)
    rounded = x + ROUNDING_SHIFT
    f = x - (rounded - ROUNDING_SHIFT)
    return _polynomial(f, (1.0, 0.69314718, 0.24022651, 0.0558)) * ((rounded.as_bits() + 1023) << 52).as_double()
