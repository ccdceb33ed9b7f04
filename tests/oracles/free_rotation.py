"""Torque-free rotation to 40 digits and more: a Taylor series of Euler's equations in integers; knows no closed form.

The equations are q' = q (0, omega) / 2 and g' = g x omega with omega_i = g_i / I_i, quaternion scalar first and
x_space = q x_body q~. The initial g is Im(q~ Q) / 2 of the given doubles, evaluated exactly; q is taken as given.
`free_cases.py` writes the reference motions of `free_cases.json` with it, `load_cases` reads them.
"""

import json
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, log
from operator import mul
from pathlib import Path

from mpmath import mp, mpf

CASES = Path(__file__).with_name("free_cases.json")
STORED_DIGITS = 30
SPARE_DIGITS = 6
STEP_BITS = 16


@dataclass(frozen=True)
class FreeCase:
    """One torque-free motion: its exact input in doubles, and attitude and momentum in 30 digits at time t."""

    group: str
    name: str
    moments: tuple[float, float, float]
    q: tuple[float, float, float, float]
    Q: tuple[float, float, float, float]
    t: float
    delta: float
    """(G^2 - 2 T I2) / G^2, I2 the middle moment; 0 on the separatrix, positive around the axis of the largest."""
    phase: float
    """|omega| t at the start."""
    input_rounding: float
    """The turn of the attitude, in radians, when Q changes by half a unit in the last place: the largest of a few."""
    input_rounding_g: float
    """The same for |difference of g| / |g|."""
    q_t: tuple[mpf, mpf, mpf, mpf]
    """The attitude at t, with the norm of q."""
    g_t: tuple[mpf, mpf, mpf]
    """The momentum at t along the body axes."""


def load_cases(*groups, path=CASES):
    """Return the stored cases as a list of `FreeCase`, of the named groups or of all."""
    with path.open() as file:
        lines = json.load(file)
    return [_case(line) for line in lines if not groups or line["group"] in groups]


def attitude_error(q, reference):
    """Return the angle in radians of the rotation between two quaternions of any norm and sign, as a float.

    2 atan2(|Im(p~ q)|, |Re(p~ q)|) in 50 digits, so that an angle of 1e-25 has all its digits.
    """
    with mp.workdps(50):
        scalar, *vector = product(conjugate([mpf(x) for x in reference]), [mpf(x) for x in q])
        return float(2 * mp.atan2(length(vector), abs(scalar)))


def momentum_error(g, reference):
    """Return |g - reference| / |reference| as a float; |g| itself where the reference is zero."""
    with mp.workdps(50):
        size = length([mpf(x) for x in reference])
        off = length([mpf(x) - mpf(y) for x, y in zip(g, reference, strict=True)])
        return float(off / size if size else off)


def initial_momentum(q, Q):
    """Return Im(q~ Q) / 2 of doubles or fractions as three fractions, without rounding."""
    return [x / 2 for x in product(conjugate([Fraction(x) for x in q]), [Fraction(x) for x in Q])[1:]]


def angular_velocity(moments, g):
    """Return g_i / I_i at the working precision of mpmath."""
    return [exact(x) / exact(moment) for x, moment in zip(g, moments, strict=True)]


def separatrix_distance(moments, g):
    """Return (G^2 - 2 T I2) / G^2 of doubles or fractions as a fraction."""
    middle = Fraction(sorted(moments)[1])
    squares = [Fraction(x) ** 2 for x in g]
    return sum(s * (1 - middle / Fraction(moment)) for s, moment in zip(squares, moments, strict=True)) / (
        sum(squares) or 1
    )


def solve(moments, q, Q, t, digits=40):
    """Return (q(t), g(t)) in mpmath numbers, right to 10^-digits, g relative to |g|.

    Two integrations, the second with more digits, a higher order and other steps, have to agree.
    """
    g = initial_momentum(q, Q)
    working = digits + digits_lost(moments, g, t)
    coarse = _integrated(moments, q, g, t, working)
    while True:
        working += SPARE_DIGITS
        fine = _integrated(moments, q, g, t, working)
        if _agree(coarse, fine, digits):
            return fine
        coarse = fine


def solve_long(moments, q, Q, t, digits=40):
    """Return (q(t), g(t)) as `solve` does, for times of any length: one period is integrated, the others are equal.

    After one period of the body components the attitude has gained a rotation about the space momentum, the same in
    every period; its angle times the number of periods, and the integration of the rest, give the motion at t.
    Raises ValueError where 4 K / lambda is infinite: on the separatrix, and so on a sphere.
    """
    g = initial_momentum(q, Q)
    guard = digits + 2 * digits_lost(moments, g, t)
    with mp.workdps(guard + SPARE_DIGITS):
        T = period(moments, g)
        periods = mp.nint(exact(t) / T)
        gained, rest = _turn_of_one_period(moments, q, Q, T, guard), exact(t) - periods * T
        angle = periods * gained.angle
        turn = [mp.cos(angle / 2), *(mp.sin(angle / 2) * x for x in gained.axis)]
        q_rest, g_rest = solve(moments, q, Q, fraction(rest), digits + 5)
        return product(turn, q_rest), g_rest


def period(moments, g):
    """Return 4 K(m) / lambda, the period of the body components, at the working precision of mpmath."""
    if separatrix_distance(moments, g) == 0:
        raise ValueError(f"g must be off the separatrix of {moments}, but g = {[float(x) for x in g]} is on it.")
    rate, m, _ = elliptic_elements(moments, g)
    return 4 * mp.ellipk(m) / rate


def elliptic_elements(moments, g):
    """Return lambda, m and the axes (i, j, k): the components go as cn, sn and dn of lambda t + u0 | m.

    j is the middle axis and k the one that keeps its sign: of the least moment where G^2 < 2 T I2, else the largest.
    """
    axes = sorted(range(3), key=lambda axis: moments[axis], reverse=True)
    i, j, k = axes if separatrix_distance(moments, g) < 0 else axes[::-1]
    Ii, Ij, Ik = (exact(moments[axis]) for axis in (i, j, k))
    gi, gj, gk = (exact(g[axis]) for axis in (i, j, k))
    about_k = gj**2 * (1 / Ij - 1 / Ii) + gk**2 * (1 / Ik - 1 / Ii)
    about_i = gi**2 * (1 / Ii - 1 / Ik) + gj**2 * (1 / Ij - 1 / Ik)
    squared_rate = (1 / Ik - 1 / Ij) * about_k
    return mp.sqrt(squared_rate), (1 / Ii - 1 / Ij) * about_i / squared_rate, (i, j, k)


def digits_lost(moments, g, t):
    """Return how many decimal digits the motion may lose until t, generously.

    Twice those of the phase, and the larger of two: those of the smallest component, as the integers have a fixed
    point; those of the growth exp(rate t) near the unstable axis, which ends where the body has left it.
    """
    with mp.workdps(20):
        sizes = [abs(exact(x)) for x in g if x != 0]
        if not sizes:
            return 1
        phase = abs(exact(t)) * length(angular_velocity(moments, g))
        smallest = mp.log10(max(sizes) / min(sizes))
        growth = _digits_of_growth(moments, g, t, phase) if len(sizes) > 1 else 0
        return ceil(8 + 2 * mp.log10(1 + phase) + max(smallest, growth))


def product(p, q):
    """The Hamilton product."""
    p0, p1, p2, p3 = p
    q0, q1, q2, q3 = q
    return [
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 + p2 * q0 + p3 * q1 - p1 * q3,
        p0 * q3 + p3 * q0 + p1 * q2 - p2 * q1,
    ]


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


def length(x):
    return mp.sqrt(sum(y**2 for y in x))


def exact(x):
    """The mpmath number of a double or fraction, at the working precision."""
    x = Fraction(x)
    return mpf(x.numerator) / x.denominator


def fraction(x):
    """The fraction that an mpmath number is."""
    sign, mantissa, exponent, _ = x._mpf_
    return (-1) ** sign * int(mantissa) * Fraction(2) ** int(exponent)


@dataclass
class _Turn:
    axis: list
    angle: mpf


def _turn_of_one_period(moments, q, Q, T, digits):
    """The rotation about the space momentum that one period adds to the attitude."""
    q_T, g_T = solve(moments, q, Q, fraction(T), digits)
    g = [exact(x) for x in initial_momentum(q, Q)]
    start = [exact(x) for x in q]
    _, *momentum = product(product(start, [0, *g]), conjugate(start))
    axis = [x / length(momentum) for x in momentum]
    scalar, *vector = product(q_T, conjugate(start))
    along = sum(x * n for x, n in zip(vector, axis, strict=True))
    across = length([x - along * n for x, n in zip(vector, axis, strict=True)])
    if max(across, length([x - y for x, y in zip(g, g_T, strict=True)]) / length(g)) > mpf(10) ** (3 - digits):
        raise ArithmeticError(f"g and its direction must return after a period, but the turn is off by {across}.")
    return _Turn(axis, 2 * mp.atan2(along, scalar))


def _digits_of_growth(moments, g, t, phase):
    least, middle, largest = (exact(moment) for moment in sorted(moments))
    G = length([exact(x) for x in g])
    rate = G / middle * mp.sqrt((largest - middle) * (middle - least) / (largest * least))
    growth = rate * abs(exact(t)) / mp.log(10)
    distance = abs(exact(separatrix_distance(moments, g)))
    return min(growth, mp.log10((1 + phase) / distance)) if distance else growth


def _agree(coarse, fine, digits):
    with mp.workdps(digits + 10):
        off = [max(abs(x - y) for x, y in zip(a, b, strict=True)) for a, b in zip(coarse, fine, strict=True)]
        return max(off[0], off[1] / (length(fine[1]) or 1)) < mpf(10) ** -digits


def _integrated(moments, q, g, t, digits):
    """The motion at t by Taylor steps, in integers that count units of 2^-bits.

    Momentum is counted in a power of two near the largest component. Time is counted in units near the step, so that
    the terms of the series fall from 1 to 2^-bits: in smaller units they would vanish, in larger ones overflow.
    """
    bits = ceil(digits * log(10, 2))
    momentum_unit = _power_of_two(max(abs(x) for x in g))
    rates = [momentum_unit / Fraction(moment) for moment in moments]
    rate_unit = _power_of_two(max(rates))

    def integers(numbers):
        return [floor(Fraction(x) * 2**bits) for x in numbers]

    state = integers([*q, *(x / momentum_unit for x in g)])
    (left,) = integers([abs(Fraction(t)) * rate_unit])
    direction, doublings = (1 if t > 0 else -1), 0
    while left and any(g):
        time_unit = direction * Fraction(2) ** doublings / rate_unit
        series = _series(state, integers(rate * time_unit for rate in rates), bits)
        step = _step(series)
        covered = step << (bits - STEP_BITS + doublings)
        if covered >= left:
            state = [_sum(coefficients, left, bits + doublings) for coefficients in series]
            break
        state = [_sum(coefficients, step, STEP_BITS) for coefficients in series]
        left -= covered
        doublings += (step > 0.8 * 2**STEP_BITS) - (step < 0.3 * 2**STEP_BITS)
    with mp.workprec(bits + 10):
        values = [mp.ldexp(mpf(x), -bits) for x in state]
        return values[:4], [x * exact(momentum_unit) for x in values[4:]]


def _power_of_two(x):
    """The power of two next above a fraction, 1 for zero."""
    x = Fraction(x)
    if x == 0:
        return Fraction(1)
    return Fraction(2) ** (x.numerator.bit_length() - x.denominator.bit_length() + 1)


def _series(state, rates, bits):
    """The Taylor coefficients of q (4) and g (3); the order makes the work for a given accuracy least."""
    c1, c2, c3 = rates
    q0, q1, q2, q3, g1, g2, g3 = series = [[x] for x in state]
    omega = [[c * x[0] >> bits] for c, x in zip(rates, series[4:], strict=True)]
    for n in range(ceil(bits * log(2) / 2) + 4):
        v1, v2, v3 = (w[::-1] for w in omega)
        h2, h3 = g2[::-1], g3[::-1]
        half, whole = 2 * (n + 1) << bits, n + 1 << 2 * bits
        terms = (
            (-_dot(q1, v1) - _dot(q2, v2) - _dot(q3, v3)) // half,
            (_dot(q0, v1) + _dot(q2, v3) - _dot(q3, v2)) // half,
            (_dot(q0, v2) + _dot(q3, v1) - _dot(q1, v3)) // half,
            (_dot(q0, v3) + _dot(q1, v2) - _dot(q2, v1)) // half,
            _dot(g2, h3) * (c3 - c2) // whole,
            _dot(g1, h3) * (c1 - c3) // whole,
            _dot(g1, h2) * (c2 - c1) // whole,
        )
        for coefficients, term in zip(series, terms, strict=True):
            coefficients.append(term)
        for w, c, x in zip(omega, rates, series[4:], strict=True):
            w.append(c * x[-1] >> bits)
    return series


def _dot(a, b):
    return sum(map(mul, a, b))


def _step(series):
    """The step, in units of 2^-STEP_BITS, for which the last two terms come to one unit of the result."""
    order = len(series[0]) - 1
    size = max(max(abs(x[n]) for x in series).bit_length() / n for n in (order, order - 1))
    return floor(2 ** (STEP_BITS - size))


def _sum(coefficients, step, shift):
    total = 0
    for x in reversed(coefficients):
        total = (total * step >> shift) + x
    return total


def _case(line):
    with mp.workdps(STORED_DIGITS + 5):
        numbers = {key: tuple(mpf(x) for x in line[key]) for key in ("q_t", "g_t")}
    inputs = {key: tuple(line[key]) for key in ("moments", "q", "Q")}
    return FreeCase(**{**line, **inputs, **numbers})
