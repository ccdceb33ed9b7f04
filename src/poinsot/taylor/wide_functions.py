"""Elementary functions of double-double numbers in LLVM's representation: constant terms of Taylor series.

Most functions improve the result of double precision by one step of Newton; sine, cosine and the exponential function
are series after a reduction of the argument. They run once a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from poinsot.taylor import llvm_functions
from poinsot.taylor.decomposition import Operand
from poinsot.taylor.llvm_ir import INTEGER, SELDOM, Value, Wide, WideValue, exact_product

__all__ = ["elementary"]

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


HALF_PI = _in_doubles(PI / 2, 6)
TWO_PI = _in_doubles(2 * PI, 6)
LOG_2_PARTS = _in_doubles(LOG_2, 3)

MAX_ANGLE = 2.0**100
"""Angles beyond which 106 bits hold no digits of the phase: sine and cosine are NaN there. Up to 2^50 errors are a few
2^-106. Beyond, they grow in proportion to the angle and stay far below the rounding error of the angle."""

SINE = [Fraction((-1) ** k, math.factorial(2 * k + 1)) for k in range(14)]
COSINE = [Fraction((-1) ** k, math.factorial(2 * k)) for k in range(15)]
EXPONENTIAL = [Fraction(1, math.factorial(k + 1)) for k in range(10)]
LOGARITHM = [Fraction(2, 2 * k + 1) for k in range(20)]
SINE_DEFECT = [Fraction((-1) ** k, math.factorial(2 * k + 3)) for k in range(20)]

EXP_HALVINGS = 9
"""Number of halvings of the argument of the exponential function before its series."""

MAX_NEWTON_STEPS, CONVERGED = 12, 2.0**-55
"""Of Kepler's equation: the most steps, and the relative change after which the next one would be below rounding."""

NEAR_ONE = 0.25
"""The distance from 1 within which the logarithm is a series."""


def elementary(name: str, operands: Sequence[Operand], values: Sequence[Value]) -> Value:
    """Write an elementary function of the values of operands."""
    lines, kind = values[0].function, Wide(values[0].high.type)
    given = [lines.constant(kind, 0.0).like(value) for value in values]
    if name == "sqrt":
        return given[0].sqrt()
    if name == "pow" and (halves := llvm_functions.halves_of(operands[1])):
        return llvm_functions.power_of_root(given[0], halves)
    own = f"wide_{name}_{given[0].lanes}"
    lines.module.function(own, kind, [kind] * len(given), FUNCTIONS[name], SELDOM)
    return lines.call(kind, own, *given)


def _polynomial(x: WideValue, coefficients: Sequence[Fraction]) -> WideValue:
    total = x.like(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = total * x + x.like(coefficient)
    return total


def _chosen(mask: Value, yes: Value | float, no: Value) -> WideValue:
    return WideValue(*mask.choose(no.like(yes), no).parts)


def _less_multiples(x: WideValue, count: Value, parts: Sequence[float]) -> WideValue:
    """Return x less a whole number of times the sum of some doubles."""
    for part in parts:
        high, low = exact_product(count, count.like(part))
        x = x - WideValue(high, low)
    return x


def _reduced(x: WideValue, parts: Sequence[float]) -> tuple[WideValue, Value]:
    """Return x less the nearest multiple of an angle that is a sum of doubles, and which multiple modulo 4."""
    turns = x.high.like(0.0)
    for _ in range(2):  # the first count may be rounded
        count = (x.high * (1.0 / parts[0])).rint()
        x = _less_multiples(x, count, parts)
        turns = turns + (count - 4.0 * (count * 0.25).rint())
    return x, turns - 4.0 * (turns * 0.25).rint()


def _sine_and_cosine(x: WideValue) -> tuple[WideValue, WideValue]:
    r, quarter = _reduced(x, HALF_PI)
    r = _chosen(abs(x.high).is_("lt", MAX_ANGLE), r, r.like(math.nan))
    square = r * r
    s, c = r * _polynomial(square, SINE), _polynomial(square, COSINE)
    size = abs(quarter)  # 0, 1 or 2
    odd = size.is_("eq", 1.0)
    sine, cosine = _chosen(odd, c, s), _chosen(odd, s, c)
    negative_sine = quarter.is_("eq", -1.0) | size.is_("eq", 2.0)
    negative_cosine = quarter.is_("eq", 1.0) | size.is_("eq", 2.0)
    return _chosen(negative_sine, -sine, sine), _chosen(negative_cosine, -cosine, cosine)


def _sin(x: WideValue) -> Value:
    return _chosen(x.is_("eq", 0.0), x, _sine_and_cosine(x)[0])


def _cos(x: WideValue) -> Value:
    return _sine_and_cosine(x)[1]


def _tan(x: WideValue) -> Value:
    sine, cosine = _sine_and_cosine(x)
    return sine / cosine


def _expm1_of_small(r: WideValue) -> WideValue:
    """Return exp(r) - 1 for |r| below 0.4: that of r / 512, doubled nine times."""
    r = r.times_power_of_two(2.0**-EXP_HALVINGS)
    small = r * _polynomial(r, EXPONENTIAL)
    for _ in range(EXP_HALVINGS):
        small = small.times_power_of_two(2.0) + small * small
    return small


def _exp(x: WideValue) -> WideValue:
    clamped = x.high.larger(-2000.0).smaller(2000.0)
    inside = clamped.is_("eq", x.high)
    x = WideValue(clamped, inside.choose(x.low, 0.0))
    count = (x.high * (1.0 / LOG_2_PARTS[0])).rint()
    result = _expm1_of_small(_less_multiples(x, count, LOG_2_PARTS)) + 1.0
    left = count.to_integer()
    for _ in range(3):  # powers of two that no exponent holds come in several parts
        some = left.larger(-1000).smaller(1000)
        left = left - some
        result = result.times_power_of_two(((some + 1023) << 52).as_double())
    finite = (result.high * 0.0).is_("eq", 0.0)
    return WideValue(result.high, finite.choose(result.low, 0.0))


def _tanh(x: WideValue) -> Value:
    size = _chosen(abs(x.high).is_("lt", 50.0), abs(x), x.like(50.0))
    small = _expm1_of_small(_chosen(size.high.is_("lt", 0.15), size.times_power_of_two(2.0), x.like(0.0)))
    near = small / (small + 2.0)
    far = 1.0 - 2.0 / (_exp(size.times_power_of_two(2.0)) + 1.0)
    found = _chosen(size.high.is_("lt", 0.15), near, far)
    signed = _chosen(x.is_("lt", 0.0), -found, found)
    return _chosen(x.high.is_("eq", x.high), signed, x)


def _logarithm_of_one_and(u: WideValue, whole: WideValue) -> WideValue:
    """Return log(1 + u) with its relative accuracy for small u; `whole` is 1 + u."""
    s = u / (u + 2.0)
    near = s * _polynomial(s * s, LOGARITHM)
    bits = whole.high.as_bits()
    exponent = (((bits >> 52) & 0x7FF) - 1023).larger(-1000).smaller(1000)
    power = ((1023 - exponent) << 52).as_double()
    scaled = whole.times_power_of_two(power)
    first = scaled.like(llvm_functions.each("log", [scaled.high]))
    far = first + (scaled * _exp(-first) - 1.0)
    far = far + exponent.to_double() * far.like(LOG_2)
    found = _chosen(abs(u.high).is_("lt", NEAR_ONE), near, far)
    in_double = llvm_functions.each("log", [whole.high])  # of zero, infinity and negative numbers
    regular = whole.is_("gt", 0.0) & whole.high.is_("lt", math.inf)
    return _chosen(regular, found, found.like(in_double))


def _log(x: WideValue) -> Value:
    return _logarithm_of_one_and(x - 1.0, x)


def _asinh(x: WideValue) -> WideValue:
    size = abs(x)
    moderate = size.high.is_("lt", 2.0**500)
    small = _chosen(moderate, size, x.like(1.0))
    square = small * small
    root = (square + 1.0).sqrt()
    of_moderate = _logarithm_of_one_and(small + square / (root + 1.0), small + root)
    large = _chosen(moderate, x.like(1.0), size)
    of_large = _logarithm_of_one_and(large, large) + large.like(LOG_2)
    found = _chosen(moderate, of_moderate, of_large)
    signed = _chosen(x.is_("lt", 0.0), -found, found)
    return _chosen(x.is_("eq", 0.0), x, signed)


def _atan2(y: WideValue, x: WideValue) -> WideValue:
    """Return atan2(y, x)."""
    first = llvm_functions.each("atan2", [y.high, x.high])
    largest = abs(y.high).larger(abs(x.high))
    exponent = (((largest.as_bits() >> 52) & 0x7FF) - 1023).larger(-1000).smaller(1000)
    power = ((1023 - exponent) << 52).as_double()
    y, x = y.times_power_of_two(power), x.times_power_of_two(power)
    sine, cosine = _sine_and_cosine(x.like(first))
    change = (y * cosine - x * sine) / (x * x + y * y).sqrt()
    regular = largest.is_("gt", 0.0) & largest.is_("lt", math.inf)
    found = x.like(first) + change
    return _chosen(regular & (change.high * 0.0).is_("eq", 0.0), found, x.like(first))


def _atan(x: WideValue) -> Value:
    return _atan2(x, x.like(1.0))


def _cosine_of_asin(x: WideValue) -> WideValue:
    return ((1.0 - x) * (1.0 + x)).sqrt()


def _asin(x: WideValue) -> Value:
    return _atan2(x, _cosine_of_asin(x))


def _acos(x: WideValue) -> Value:
    return _atan2(_cosine_of_asin(x), x)


def _sine_defect_of(x: WideValue, sine: WideValue) -> WideValue:
    square = x * x
    return _chosen(square.is_("lt", 4.0), x * square * _polynomial(square, SINE_DEFECT), x - sine)


def _sine_defect(x: WideValue) -> Value:
    return _sine_defect_of(x, _sine_and_cosine(x)[0])


def _asinh_defect(x: WideValue) -> Value:
    """Return x - asinh x, which is sinh u - u for u = asinh x."""
    angle = _asinh(x)
    square = angle * angle
    near = angle * square * _polynomial(square, [abs(coefficient) for coefficient in SINE_DEFECT])
    return _chosen(square.is_("lt", 4.0), near, x - angle)


def _eccentric_anomaly(e: WideValue, mean_anomaly: WideValue) -> Value:
    """Return the solution of Kepler's equation by Newton's method from the solution in double precision.

    One step is enough unless 1 - e is so small that the eccentricity in double precision is another one.
    """
    r, _ = _reduced(mean_anomaly, TWO_PI)
    size, rest = abs(r), 1.0 - e
    first = llvm_functions.eccentric_anomaly(e.high, size.high.smaller(math.nextafter(math.pi, 0.0)))

    def step(anomaly: WideValue, left: Value, going: Value) -> list[Value]:
        sine, _ = _sine_and_cosine(anomaly)
        half, _ = _sine_and_cosine(anomaly.times_power_of_two(0.5))
        slope = rest + e * (half * half).times_power_of_two(2.0)
        excess = (rest * anomaly - size) + e * _sine_defect_of(anomaly, sine)
        change = excess / slope
        again = going & abs(change.high).is_("gt", anomaly.high * CONVERGED)
        return [_chosen(going, anomaly - change, anomaly), left - 1, again]

    found, *_ = e.function.repeat(
        [size.like(first), e.function.constant(INTEGER, MAX_NEWTON_STEPS), size.is_("gt", 0.0)],
        lambda _, left, going: left.is_("gt", 0) & going.any(),
        step,
    )
    found = _chosen(size.is_("gt", 0.0), found, size)
    return _chosen(r.is_("lt", 0.0), -found, found)


def _pow(x: WideValue, y: WideValue) -> Value:
    first = llvm_functions.each("pow", [x.high, y.high])
    size = abs(x)
    regular = size.is_("gt", 0.0) & abs(first).is_("gt", 0.0) & (first * 0.0).is_("eq", 0.0)
    size = _chosen(regular, size, x.like(1.0))
    found = _exp(y * _logarithm_of_one_and(size - 1.0, size))
    signed = _chosen(first.is_("lt", 0.0), -found, found)
    return _chosen(regular, signed, x.like(first))


FUNCTIONS: Mapping[str, Callable[..., Value]] = {
    function.__name__[1:]: function
    for function in (
        _sin,
        _cos,
        _tan,
        _exp,
        _tanh,
        _log,
        _asinh,
        _atan2,
        _atan,
        _asin,
        _acos,
        _sine_defect,
        _asinh_defect,
        _eccentric_anomaly,
        _pow,
    )
}
"""The functions by their names in `poinsot.functions`."""
