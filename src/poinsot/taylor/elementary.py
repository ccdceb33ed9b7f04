"""Elementary functions of vectors in LLVM's representation: the same bits in vectors of any length.

In double precision sine, cosine, the eccentric anomaly and powers with a half of an integer are vectors' own; the
others call the C library for each number.

In quadruple precision most functions improve the result of double precision by one step of Newton; sine, cosine and the
exponential function are series after a reduction of the argument. They are constant terms of Taylor series and run once
a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from poinsot.taylor.decomposition import Coefficient, Number, Operand
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, SELDOM, Value, WideValue, exact_product

__all__ = ["elementary", "rough_exp2", "rough_log2"]

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
"""Largest double of a power that is a product of roots."""

MAX_ITERATIONS, KEPLER_TOLERANCE = 60, 2.0**-14
"""Limits of the iteration of Kepler's equation: steps, and the relative change after which the next change would be
below rounding."""


PI = Fraction(
    "3.141592653589793238462643383279502884197169399375105820974944592307816406286208998628034825342117067982"
)
"""pi to 102 digits."""

LOG_2 = Fraction(
    "0.693147180559945309417232121458176568075500134360255254120680009493393621969694715605863326996418687"
)
"""The natural logarithm of 2 to 99 digits."""


def _in_doubles(number: Fraction, count: int) -> list[float]:
    """Return a number as the sum of doubles, each the rest to double precision."""
    parts = list[float]()
    for _ in range(count):
        parts.append(float(number))
        number -= Fraction(parts[-1])
    return parts


WIDE_HALF_PI = _in_doubles(PI / 2, 6)
TWO_PI = _in_doubles(2 * PI, 6)
LOG_2_PARTS = _in_doubles(LOG_2, 3)

MAX_ANGLE = 2.0**100
"""Angles beyond which 106 bits hold no digits of the phase: sine and cosine are NaN there. Up to 2^50 errors are a few
2^-106. Beyond, they grow in proportion to the angle and stay far below the rounding error of the angle."""

WIDE_SINE = [Fraction((-1) ** k, math.factorial(2 * k + 1)) for k in range(14)]
WIDE_COSINE = [Fraction((-1) ** k, math.factorial(2 * k)) for k in range(15)]
EXPONENTIAL = [Fraction(1, math.factorial(k + 1)) for k in range(10)]
LOGARITHM = [Fraction(2, 2 * k + 1) for k in range(20)]
WIDE_SINE_DEFECT = [Fraction((-1) ** k, math.factorial(2 * k + 3)) for k in range(20)]

EXP_HALVINGS = 9
"""Number of halvings of the argument of the exponential function before its series."""

MAX_NEWTON_STEPS, WIDE_KEPLER_TOLERANCE = 12, 2.0**-55
"""Limits of the iteration of Kepler's equation in quadruple precision."""

MAX_SERIES_DISTANCE = 0.25
"""The distance from 1 within which the logarithm is a series."""


def elementary(name: str, operands: Sequence[Operand], values: Sequence[Value]) -> Value:
    """Write an elementary function of the values of operands, in the precision of these."""
    first = values[0]
    match name:
        case "sqrt":
            return first.sqrt()
        case "pow" if halves := _halves_of(operands[1]):
            return _power_of_root(first, halves)
        case _ if isinstance(first, WideValue):
            own = f"wide_{name}_{first.lanes}"
            return first.function.call_defined(first.type, own, WIDE_FUNCTIONS[name], *values, attributes=SELDOM)
        case "sin" | "cos":
            return _sine_and_cosine(first).part(int(name == "cos"))
        case "eccentric_anomaly":
            return _eccentric_anomaly(*values)
        case "sine_defect":
            return _defect(first, first - _sine_and_cosine(first).part(0), SINE_DEFECT)
        case "asinh_defect":
            angle = _each("asinh", [first])
            return _defect(angle, first - angle, list(map(abs, SINE_DEFECT)))
    return _each(name, values)


def _halves_of(exponent: Operand) -> int:
    """Return twice an exponent if a power is a product of roots, otherwise 0."""
    if isinstance(exponent, Coefficient) and exponent.parameter is None:
        halves = 2 * exponent.number
        return int(halves) if halves == int(halves) and abs(halves) <= MAX_HALVES else 0
    return 0


def _power_of_root(x: Value, halves: int) -> Value:
    """Return x^(halves / 2)."""
    whole, factors = abs(halves) // 2, [x.sqrt()] if halves % 2 else []
    while whole:
        factors += [x] if whole % 2 else []
        whole //= 2
        x = x * x if whole else x
    result = math.prod(factors[1:], start=factors[0])
    return result if halves > 0 else 1.0 / result


def _polynomial(x: Value, coefficients: Sequence[Number]) -> Value:
    value = x.like(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = value.fma(x, coefficient)
    return value


def _defect(angle: Value, difference: Value, coefficients: Sequence[Number]) -> Value:
    """Return a defect of an angle: its series in the square of the angle below 2, otherwise a difference.

    They are x - sin x for the angle x, and x - asinh x, which is sinh u - u, for the angle u = asinh x.
    """
    square = angle * angle
    return square.is_("lt", 4.0).choose(angle * square * _polynomial(square, coefficients), difference)


# ---------------------------------------------------------------------- double precision


def _each(name: str, arguments: Sequence[Value]) -> Value:
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

    return arguments[0].function.call_defined(kind, own, body, *arguments)


def _reduced(x: Value, parts: Sequence[float]) -> tuple[Value, Value]:
    """Return x less the nearest multiple of an angle that is given in parts, and which, plus `ROUNDING_SHIFT`."""
    count = x.fma(1.0 / parts[0], ROUNDING_SHIFT)
    rounded = count - ROUNDING_SHIFT
    for part in parts:
        x = (-rounded).fma(part, x)  # the first one is exact
    return x, count


def _sine_and_cosine(x: Value) -> Value:
    both = f"{{{x.type}, {x.type}}}"
    return x.function.call_defined(both, f"sine_and_cosine_{x.lanes}", _written_sine_and_cosine, x)


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
        return [far.choose(_each(name, [x]), value) for name, value in zip(("sin", "cos"), near, strict=True)]

    return lines.struct(*lines.either(far.any(), near, exact))


def _eccentric_anomaly(eccentricity: Value, mean_anomaly: Value) -> Value:
    """Return the eccentric anomaly."""
    given, name = (eccentricity, mean_anomaly), f"eccentric_anomaly_{eccentricity.lanes}"
    return eccentricity.function.call_defined(eccentricity.type, name, _written_eccentric_anomaly, *given)


def _written_eccentric_anomaly(eccentricity: Value, mean_anomaly: Value) -> Value:
    """Solve E - e sin E = M by Danby's method of order four, for E between -pi and pi."""
    lines = mean_anomaly.function
    reduced, _ = _reduced(mean_anomaly, [4.0 * part for part in HALF_PI])
    far = abs(mean_anomaly).is_("gt", MAX_REDUCED_ANGLE)

    def exact() -> list[Value]:
        both = _sine_and_cosine(mean_anomaly)
        return [far.choose(_each("atan2", [both.part(0), both.part(1)]), reduced)]

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
        again = going & abs(change).is_("gt", anomaly * KEPLER_TOLERANCE)
        return [going.choose(anomaly + change, anomaly), left - 1, again]

    anomaly, _, _ = lines.repeat(
        [start, lines.constant(INTEGER, MAX_ITERATIONS), size.is_("ge", 0.0)],
        lambda _, left, going: left.is_("gt", 0) & going.any(),
        step,
    )
    return anomaly.intrinsic("copysign", reduced)


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


# ---------------------------------------------------------------------- quadruple precision


def _less_multiples(x: Value, count: Value, parts: Sequence[float]) -> Value:
    """Return x less a whole number of times the sum of some doubles."""
    for part in parts:
        x = x - WideValue(*exact_product(count, count.like(part)))
    return x


def _wide_reduced(x: Value, parts: Sequence[float]) -> tuple[Value, Value]:
    """Return x less the nearest multiple of an angle that is a sum of doubles, and which multiple modulo 4."""
    turns = x.high.like(0.0)
    for _ in range(2):  # the first count may be rounded
        count = (x.high * (1.0 / parts[0])).rint()
        x = _less_multiples(x, count, parts)
        turns = turns + (count - 4.0 * (count * 0.25).rint())
    return x, turns - 4.0 * (turns * 0.25).rint()


def _wide_sine_and_cosine(x: Value) -> tuple[Value, Value]:
    r, quarter = _wide_reduced(x, WIDE_HALF_PI)
    r = abs(x.high).is_("lt", MAX_ANGLE).choose(r, math.nan)
    square = r * r
    s, c = r * _polynomial(square, WIDE_SINE), _polynomial(square, WIDE_COSINE)
    size = abs(quarter)  # 0, 1 or 2
    odd = size.is_("eq", 1.0)
    sine, cosine = odd.choose(c, s), odd.choose(s, c)
    negative_sine = quarter.is_("eq", -1.0) | size.is_("eq", 2.0)
    negative_cosine = quarter.is_("eq", 1.0) | size.is_("eq", 2.0)
    return negative_sine.choose(-sine, sine), negative_cosine.choose(-cosine, cosine)


def _sin(x: Value) -> Value:
    return x.is_("eq", 0.0).choose(x, _wide_sine_and_cosine(x)[0])


def _tan(x: Value) -> Value:
    sine, cosine = _wide_sine_and_cosine(x)
    return sine / cosine


def _expm1_of_small(r: Value) -> Value:
    """Return exp(r) - 1 for |r| below 0.4: that of r / 512, doubled nine times."""
    r = r.times_power_of_two(2.0**-EXP_HALVINGS)
    small = r * _polynomial(r, EXPONENTIAL)
    for _ in range(EXP_HALVINGS):
        small = small.times_power_of_two(2.0) + small * small
    return small


def _exp(x: Value) -> Value:
    high, low = x.parts
    clamped = high.larger(-2000.0).smaller(2000.0)
    inside = clamped.is_("eq", high)
    x = WideValue(clamped, inside.choose(low, 0.0))
    count = (clamped * (1.0 / LOG_2_PARTS[0])).rint()
    result = _expm1_of_small(_less_multiples(x, count, LOG_2_PARTS)) + 1.0
    left = count.to_integer()
    for _ in range(3):  # powers of two that no exponent holds come in several parts
        some = left.larger(-1000).smaller(1000)
        left = left - some
        result = result.times_power_of_two(((some + 1023) << 52).as_double())
    high, low = result.parts
    return WideValue(high, (high * 0.0).is_("eq", 0.0).choose(low, 0.0))


def _tanh(x: Value) -> Value:
    size = abs(x.high).is_("lt", 50.0).choose(abs(x), 50.0)
    small = _expm1_of_small(size.high.is_("lt", 0.15).choose(size.times_power_of_two(2.0), 0.0))
    near = small / (small + 2.0)
    far = 1.0 - 2.0 / (_exp(size.times_power_of_two(2.0)) + 1.0)
    found = size.high.is_("lt", 0.15).choose(near, far)
    signed = x.is_("lt", 0.0).choose(-found, found)
    return x.high.is_("eq", x.high).choose(signed, x)


def _power_and_exponent(size: Value) -> tuple[Value, Value]:
    """Return the power of two that brings a positive number near 1, and the exponent of its inverse."""
    exponent = (((size.as_bits() >> 52) & 0x7FF) - 1023).larger(-1000).smaller(1000)
    return ((1023 - exponent) << 52).as_double(), exponent


def _logarithm_of_one_and(u: Value, whole: Value) -> Value:
    """Return log(1 + u) with its relative accuracy for small u; `whole` is 1 + u."""
    s = u / (u + 2.0)
    near = s * _polynomial(s * s, LOGARITHM)
    power, exponent = _power_and_exponent(whole.high)
    scaled = whole.times_power_of_two(power)
    first = scaled.like(_each("log", [scaled.high]))
    far = first + (scaled * _exp(-first) - 1.0)
    far = far + exponent.to_double() * far.like(LOG_2)
    found = abs(u.high).is_("lt", MAX_SERIES_DISTANCE).choose(near, far)
    in_double = _each("log", [whole.high])  # of zero, infinity and negative numbers
    regular = whole.is_("gt", 0.0) & whole.high.is_("lt", math.inf)
    return regular.choose(found, in_double)


def _asinh(x: Value) -> Value:
    size = abs(x)
    moderate = size.high.is_("lt", 2.0**500)
    small = moderate.choose(size, 1.0)
    square = small * small
    root = (square + 1.0).sqrt()
    of_moderate = _logarithm_of_one_and(small + square / (root + 1.0), small + root)
    large = moderate.choose(size.like(1.0), size)
    of_large = _logarithm_of_one_and(large, large) + large.like(LOG_2)
    found = moderate.choose(of_moderate, of_large)
    signed = x.is_("lt", 0.0).choose(-found, found)
    return x.is_("eq", 0.0).choose(x, signed)


def _atan2(y: Value, x: Value) -> Value:
    first = x.like(_each("atan2", [y.high, x.high]))
    largest = abs(y.high).larger(abs(x.high))
    power, _ = _power_and_exponent(largest)
    y, x = y.times_power_of_two(power), x.times_power_of_two(power)
    sine, cosine = _wide_sine_and_cosine(first)
    change = (y * cosine - x * sine) / (x * x + y * y).sqrt()
    regular = largest.is_("gt", 0.0) & largest.is_("lt", math.inf)
    found = first + change
    return (regular & (change.high * 0.0).is_("eq", 0.0)).choose(found, first)


def _cosine_of_asin(x: Value) -> Value:
    return ((1.0 - x) * (1.0 + x)).sqrt()


def _sine_defect(x: Value, sine: Value) -> Value:
    return _defect(x, x - sine, WIDE_SINE_DEFECT)


def _asinh_defect(x: Value) -> Value:
    angle = _asinh(x)
    return _defect(angle, x - angle, list(map(abs, WIDE_SINE_DEFECT)))


def _wide_eccentric_anomaly(e: Value, mean_anomaly: Value) -> Value:
    """Return the solution of Kepler's equation by Newton's method from the solution in double precision.

    One step is enough unless 1 - e is so small that the eccentricity in double precision is another one.
    """
    r, _ = _wide_reduced(mean_anomaly, TWO_PI)
    size, rest = abs(r), 1.0 - e
    first = _eccentric_anomaly(e.high, size.high.smaller(math.nextafter(math.pi, 0.0)))

    def step(anomaly: Value, left: Value, going: Value) -> list[Value]:
        sine, _ = _wide_sine_and_cosine(anomaly)
        half, _ = _wide_sine_and_cosine(anomaly.times_power_of_two(0.5))
        slope = rest + e * (half * half).times_power_of_two(2.0)
        excess = (rest * anomaly - size) + e * _sine_defect(anomaly, sine)
        change = excess / slope
        again = going & abs(change.high).is_("gt", anomaly.high * WIDE_KEPLER_TOLERANCE)
        return [going.choose(anomaly - change, anomaly), left - 1, again]

    found, *_ = e.function.repeat(
        [size.like(first), e.function.constant(INTEGER, MAX_NEWTON_STEPS), size.is_("gt", 0.0)],
        lambda _, left, going: left.is_("gt", 0) & going.any(),
        step,
    )
    found = size.is_("gt", 0.0).choose(found, size)
    return r.is_("lt", 0.0).choose(-found, found)


def _pow(x: Value, y: Value) -> Value:
    first = _each("pow", [x.high, y.high])
    size = abs(x)
    regular = size.is_("gt", 0.0) & abs(first).is_("gt", 0.0) & (first * 0.0).is_("eq", 0.0)
    size = regular.choose(size, 1.0)
    found = _exp(y * _logarithm_of_one_and(size - 1.0, size))
    signed = first.is_("lt", 0.0).choose(-found, found)
    return regular.choose(signed, first)


WIDE_FUNCTIONS: Mapping[str, Callable[..., Value]] = {
    "sin": _sin,
    "cos": lambda x: _wide_sine_and_cosine(x)[1],
    "tan": _tan,
    "exp": _exp,
    "tanh": _tanh,
    "log": lambda x: _logarithm_of_one_and(x - 1.0, x),
    "asinh": _asinh,
    "atan2": _atan2,
    "atan": lambda x: _atan2(x, x.like(1.0)),
    "asin": lambda x: _atan2(x, _cosine_of_asin(x)),
    "acos": lambda x: _atan2(_cosine_of_asin(x), x),
    "sine_defect": lambda x: _sine_defect(x, _wide_sine_and_cosine(x)[0]),
    "asinh_defect": _asinh_defect,
    "eccentric_anomaly": _wide_eccentric_anomaly,
    "pow": _pow,
}
"""The functions of double-double numbers by their names in `poinsot.functions`."""
