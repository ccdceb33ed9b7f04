"""Write `free_cases.json`: reference motions of free bodies near and far from every degeneracy of the closed form.

    PYTHONPATH=tests python -m oracles.free_cases                write all groups, one after the other (an hour)
    PYTHONPATH=tests python -m oracles.free_cases random long    write these groups and keep the others
    PYTHONPATH=tests python -m oracles.free_cases --check        compare the file with the elliptic functions

An answer is right in all its 30 digits, those of g relative to |g|: it is an integration in integers that agrees to
33 digits with a second one of more digits, higher order and other steps. Beyond a phase of 2000 it is the turn of one
period, integrated so, times the number of periods. `--check` compares every answer with the elliptic functions and
integrals of mpmath, and the multiplied period with the integration of the whole time where that is short enough.
"""

import argparse
import json
from fractions import Fraction
from itertools import permutations
from itertools import product as combinations

import numpy as np
from mpmath import mp, mpf

from oracles.free_rotation import (
    CASES,
    STORED_DIGITS,
    angular_velocity,
    attitude_error,
    conjugate,
    digits_lost,
    elliptic_elements,
    exact,
    initial_momentum,
    length,
    load_cases,
    momentum_error,
    product,
    separatrix_distance,
    solve,
    solve_long,
)

SEED = 20060101
INTEGRATED_PHASE = 2000
NUDGES = 2
ORDERS = list(permutations(range(3)))
UNITS = [sign * np.eye(4)[n] for n in range(4) for sign in (1, -1)]
HALVES = [np.array(signs) / 2 for signs in combinations((1, -1), repeat=4)]
AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
SMALL = [float(f"1e-{n}") for n in range(3, 16)]
# I1 (I2 - I3) / (I3 (I1 - I2)) is the square of n / d: g = (n, any, d) is on the separatrix, in doubles
SEPARATRICES = [((6, 4, 3), (1, 1)), ((9, 8, 4), (3, 1)), ((25, 13, 12), (5, 12))]


# The groups: each yields name, moments, q, Q and t.


def random(rng):
    for n in range(300):
        moments, q, g = body(rng, ORDERS[n % 6]), any_attitude(rng), any_momentum(rng) * log_uniform(rng, 0.1, 10)
        yield "triaxial", moments, q, momenta(q, g), time(moments, g, either_sign(rng) * log_uniform(rng, 0.1, 1e3))


def separatrix(rng):
    distances = [10.0**-n for n in range(1, 16)]
    for n, (distance, side, near, plain) in enumerate(combinations(distances, (1, -1), (True, False), (True, False))):
        moments = wide_body(rng, ORDERS[n % 6])
        q = rng.choice(UNITS) if plain else any_attitude(rng)
        g = near_separatrix(rng, moments, side * distance, near)
        Q = nearest_to_separatrix(rng, moments, q, momenta(q, g), side * distance)
        t = time(moments, g, either_sign(rng) * log_uniform(rng, 1e2, 1e3))
        yield f"{'near' if near else 'far from'} the unstable axis, {side * distance:.0e}", moments, q, Q, t
    yield from on_separatrix(rng)


def on_separatrix(rng):
    for n, ((moments, (a, c)), b, phase) in enumerate(combinations(SEPARATRICES, (0, 0.75, 2.0**20), (30, 200))):
        order, signs = ORDERS[(n + n // 6) % 6], rng.choice((1, -1), 3)
        moments, g = (placed(x, order) for x in (moments, (a, b, c) * signs))
        q = rng.choice(HALVES if n % 2 else UNITS)
        name = f"on it, {'near' if b > 100 else 'far from'} the unstable axis"
        yield name, moments, q, momenta(q, g), time(moments, g, either_sign(rng) * phase)


def symmetric(rng):
    for unique, prolate in combinations(range(3), (True, False)):
        kind = f"{'prolate' if prolate else 'oblate'} about axis {unique + 1}"
        for off in [0.0, *SMALL] * 2:
            moments = symmetric_body(rng, unique, prolate, off)
            q, g = any_attitude(rng), any_momentum(rng)
            t = time(moments, g, either_sign(rng) * log_uniform(rng, 1, 500))
            yield f"{kind}, off by {off:.0e}", moments, q, momenta(q, g), t
        for place, off in combinations(("across", "along"), (0.0, 1e-9)):
            moments, q = symmetric_body(rng, unique, prolate, off), rng.choice(UNITS)
            g = any_momentum(rng) * (np.arange(3) != unique if place == "across" else np.arange(3) == unique)
            yield f"{kind}, off by {off:.0e}, g {place}", moments, q, momenta(q, g), time(moments, g, 50)
    for name, moments in {"needle": (1.0, 1e-8, 1.0), "disc": (2.0, 1.0, 1.0), "rod": (1.0, 1.0, 1e-3)}.items():
        q, g = any_attitude(rng), any_momentum(rng) * moments
        yield name, np.array(moments), q, momenta(q, g), time(moments, g, 100)


def spherical(rng):
    for n, off in enumerate([0.0, *SMALL] * 3):
        moments = rng.uniform(0.5, 2) * (1 + off * placed((0.0, rng.uniform(0.2, 0.8), 1.0), ORDERS[n % 6]))
        q, g = (rng.choice(UNITS) if n < 1 else any_attitude(rng)), any_momentum(rng)
        t = time(moments, g, either_sign(rng) * log_uniform(rng, 1, 1e3))
        yield f"off by {off:.0e}", moments, q, momenta(q, g), t


def principal(rng):
    offs = [0.0, *SMALL, 1e-20, 1e-100]
    for n, (axis, off, plain) in enumerate(combinations(range(3), offs, (True, False))):
        if not plain and 0 < off < 1e-15:
            continue
        order = ORDERS[n % 6]
        moments, q = wide_body(rng, order), rng.choice(UNITS) if plain else any_attitude(rng)
        g = np.full(3, off) * either_sign(rng) * rng.uniform(0.3, 1, 3)
        g[axis] = either_sign(rng) * rng.uniform(0.5, 2)
        g = placed(g, order)
        t = time(moments, g, either_sign(rng) * log_uniform(rng, 10, 500))
        if axis == 1 and off:
            passages = rng.uniform(0.6, 1.2 if off < 1e-50 else 2.5)
            t = float(passages * -np.log(off) / unstable_rate(moments, g)) * either_sign(rng)
        name = f"{('long', 'intermediate', 'short')[::-1][axis]} axis, off by {off:.0e}"
        yield name, moments, q, momenta(q, g), t


def zero(rng):
    for t in (0.0, 1.0, -1e9, 1e300):
        yield "no momentum", body(rng, ORDERS[0]), any_attitude(rng), np.zeros(4), t
    for phase in (0.0, 1e-300, 1e-15, -1e-8, 1e-5, -1e-2):
        moments, q, g = body(rng, ORDERS[1]), any_attitude(rng), any_momentum(rng)
        yield f"phase {phase:.0e}", moments, q, momenta(q, g), time(moments, g, phase)
    for size, scale in combinations((1e-200, 1e-150, 1e-20, 1.0, 1e20, 1e150, 1e200), (1e-20, 1.0, 1e30)):
        moments, q, g = scale * body(rng, ORDERS[2]), any_attitude(rng), size * any_momentum(rng)
        t = time(moments, g, either_sign(rng) * log_uniform(rng, 1, 200))
        yield f"momentum {size:.0e}, moments {scale:.0e}", moments, q, momenta(q, g), t


def long(rng):
    for n, (phase, side) in enumerate(combinations((1e6, 1e9, None) * 6, (1, -1))):
        moments, q, g = body(rng, ORDERS[n % 6]), any_attitude(rng), any_momentum(rng)
        while side * separatrix_distance(moments, g) < 0.001:
            g = any_momentum(rng)
        if phase is None:
            g, t = g / float(length(g / moments)), 1e9
        else:
            t = time(moments, g, either_sign(rng) * phase)
        yield "t = 1e9" if phase is None else f"phase {phase:.0e}", moments, q, momenta(q, g), t


def named(_rng):
    root = 2**0.5
    for t in (1.0, 10.0, 100.0, 1e3, -1e3, 2e4, 5e4, 1e9):
        yield "paper", (1.25, 1.0, 0.75), (0.5, -(2**-0.5), 0.0, 0.5), (0.3, -0.6 * root, 0.1 * root, -1.5), t
    for t in (1.0, 3.0, 10.0, 30.0, 100.0, -100.0, 300.0, 1e3, 1e6):
        yield "dzhanibekov", (2.0, 2.5, 3.5), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 4.0, 0.02), t


GROUPS = {f.__name__: f for f in (random, separatrix, symmetric, spherical, principal, zero, long, named)}


# Bodies, attitudes and momenta.


def body(rng, order):
    """Moments of a random mass distribution, largest first before the order is applied."""
    a, b, c = np.sort(np.exp(rng.uniform(-1.5, 1.5, 3)))
    return placed((b + c, a + c, a + b), order)


def wide_body(rng, order):
    """Moments far enough apart for a distance of 0.1 from the separatrix on both sides."""
    least, middle = rng.uniform(0.6, 0.7), rng.uniform(0.95, 1.05)
    return rng.uniform(0.5, 2) * placed((rng.uniform(1.4, 1.5), middle, least), order)


def symmetric_body(rng, unique, prolate, off):
    equal = rng.uniform(0.5, 2)
    moments = np.array([equal, equal, equal])
    moments[unique] = equal * (rng.uniform(0.05, 0.9) if prolate else rng.uniform(1.1, 1.95))
    moments[(unique + rng.integers(1, 3)) % 3] = equal * (1 + off)
    return moments


def placed(values, order):
    """The values with the n-th of them at place order[n]."""
    moved = np.empty(3)
    moved[list(order)] = values
    return moved


def any_attitude(rng):
    q = rng.normal(size=4)
    return q / np.sqrt(q @ q)


def any_momentum(rng):
    g = rng.normal(size=3)
    return g / np.sqrt(g @ g)


def momenta(q, g):
    return 2 * np.array(product(q, [0, *g]))


def time(moments, g, phase):
    """The double nearest to phase / |omega|."""
    return float(phase / length(angular_velocity(moments, g)))


def unstable_rate(moments, g):
    least, middle, largest = np.sort(moments)
    return np.sqrt(g @ g * (largest - middle) * (middle - least) / (largest * least)) / middle


def near_separatrix(rng, moments, distance, near):
    """A unit momentum at the distance (G^2 - 2 T I2) / G^2, within about its root of the unstable axis or not."""
    i, j, k = np.argsort(moments)[::-1]
    # (G^2 - 2 T I2) = a gi^2 - b gk^2
    a, b = 1 - moments[j] / moments[i], moments[j] / moments[k] - 1
    g = np.empty(3)
    if near:
        extra = rng.uniform(0, 0.2) * abs(distance)
        g[i], g[k] = np.sqrt((max(distance, 0) + extra) / a), np.sqrt((max(-distance, 0) + extra) / b)
        g[j] = np.sqrt(1 - g[i] ** 2 - g[k] ** 2)
    else:
        g[j] = rng.uniform(0, 0.6)
        across = 1 - g[j] ** 2
        g[i], g[k] = np.sqrt((distance + b * across) / (a + b)), np.sqrt((a * across - distance) / (a + b))
    return g * rng.choice((1, -1), 3)


def nearest_to_separatrix(rng, moments, q, Q, distance):
    """Of 300 momenta some units in the last place from Q, the one whose distance is nearest to the wanted."""
    if abs(distance) > 1e-10:
        return Q
    tries = [Q, *(Q + rng.integers(-3, 4, 4) * np.spacing(Q) * (Q != 0) for _ in range(300))]
    return min(tries, key=lambda Q: abs(separatrix_distance(moments, initial_momentum(q, Q)) - Fraction(distance)))


def log_uniform(rng, low, high):
    return np.exp(rng.uniform(np.log(low), np.log(high)))


def either_sign(rng):
    return rng.choice((1, -1))


# The answers.


def answered(rng, group, name, moments, q, Q, t):
    """The case as it is stored: input in doubles, answers in decimals."""
    moments, q, Q = ([float(x) for x in values] for values in (moments, q, Q))
    g = initial_momentum(q, Q)
    with mp.workdps(30):
        phase = float(abs(exact(t)) * length(angular_velocity(moments, g)))
    motion = solve if phase <= INTEGRATED_PHASE else solve_long
    q_t, g_t = motion(moments, q, Q, t, digits=STORED_DIGITS + 3)
    turns = [motion(moments, q, nudged(rng, Q), t, digits=18) for _ in range(NUDGES)]
    return {
        "group": group,
        "name": name,
        "moments": moments,
        "q": q,
        "Q": Q,
        "t": t,
        "delta": float(separatrix_distance(moments, g)),
        "phase": phase,
        "input_rounding": float(f"{max(attitude_error(turn[0], q_t) for turn in turns):.3g}"),
        "input_rounding_g": float(f"{max(momentum_error(turn[1], g_t) for turn in turns):.3g}"),
        "q_t": [mp.nstr(x, STORED_DIGITS) for x in q_t],
        "g_t": [mp.nstr(x, STORED_DIGITS) for x in g_t],
    }


def nudged(rng, Q):
    """Q with each component moved up or down by half a unit in the last place, as fractions; zeros stay."""
    return [Fraction(x) + int(either_sign(rng)) * Fraction(np.spacing(x)) / 2 * (x != 0) for x in Q]


def write(groups):
    stored = json.loads(CASES.read_text()) if CASES.exists() else []
    for group in groups:
        rng = np.random.default_rng([SEED, list(GROUPS).index(group)])
        inputs = list(GROUPS[group](rng))
        lines = [answered(rng, group, *case) for case in inputs]
        stored = sorted(
            [*(line for line in stored if line["group"] != group), *lines],
            key=lambda line: list(GROUPS).index(line["group"]),
        )
        CASES.write_text("[\n" + ",\n".join(json.dumps(line) for line in stored) + "\n]\n")
        print(f"{group}: {len(lines)} cases", flush=True)


# The check.


def check(groups):
    """Print how far the stored answers are from the elliptic functions, and `solve_long` from `solve`."""
    for group in groups:
        turns, errors = zip(*(_off_closed_form(case) for case in load_cases(group)), strict=True)
        print(f"{group}: {max(turns):.1e} rad, {max(errors):.1e} of |g|, {len(turns)} cases", flush=True)
    off = [_off_whole_time(case) for case in load_cases("random") if 50 < case.phase < 100]
    print(f"multiplied period: {max(off):.1e} rad, {len(off)} cases")


def _off_whole_time(case):
    short, long = (motion(case.moments, case.q, case.Q, case.t) for motion in (solve, solve_long))
    return attitude_error(long[0], short[0])


def _off_closed_form(case):
    with mp.workdps(50 + 4 * digits_lost(case.moments, initial_momentum(case.q, case.Q), case.t)):
        axes, g = closed_form(case.moments, case.q, case.Q, exact(case.t))
        stored = [rotated(case.q_t, axis) for axis in AXES]
        # |A - B| = 2 sqrt(2) sin(angle / 2)
        off = length([x - y for a, b in zip(axes, stored, strict=True) for x, y in zip(a, b, strict=True)])
        return float(2 * mp.asin(off / mp.sqrt(8))), momentum_error(case.g_t, g)


def closed_form(moments, q, Q, t):
    """Return the body axes in space and the momentum g along them, by Jacobi's functions and Legendre's integral.

    Axis k, about which the components go as cn, sn and dn of u = lambda t + u0, turns about the space momentum by
    G t / Ik + G (2 T - G^2 / Ik) / (G^2 - ak^2) (Pi(nu; am u | m) - Pi(nu; am u0 | m)) / lambda.
    """
    fractions = initial_momentum(q, Q)
    g, q = ([exact(x) for x in values] for values in (fractions, q))
    if all(g[a] * g[b] * (moments[a] - moments[b]) == 0 for a, b in ((0, 1), (1, 2), (2, 0))):
        omega = angular_velocity(moments, fractions)
        return [rotated(q, turned(axis, omega, length(omega) * t)) for axis in AXES], g
    *_, k = elliptic_elements(moments, fractions)[2]
    g_t, angle = _jacobi(moments, fractions, t)
    momentum = rotated(q, g)
    body = triad(g_t, AXES[k])
    space = triad(momentum, turned(rotated(q, AXES[k]), momentum, angle))
    return [[dot([b[a] for b in body], [s[c] for s in space]) for c in range(3)] for a in range(3)], g_t


def _jacobi(moments, g, t):
    """The momentum along the body axes at t, and the angle of axis k about the space momentum."""
    rate, m, (i, j, k) = elliptic_elements(moments, g)
    m = mpf(1) if separatrix_distance(moments, g) == 0 else m
    Ii, Ij, Ik = (exact(moments[axis]) for axis in (i, j, k))
    gi, gj, gk = (exact(g[axis]) for axis in (i, j, k))
    about_i = gi**2 * (1 / Ii - 1 / Ik) + gj**2 * (1 / Ij - 1 / Ik)
    about_k = gj**2 * (1 / Ij - 1 / Ii) + gk**2 * (1 / Ik - 1 / Ii)
    ai, ak = mp.sqrt(about_i / (1 / Ii - 1 / Ik)), mp.sqrt(about_k / (1 / Ik - 1 / Ii))
    aj = mp.sqrt(about_i / (1 / Ij - 1 / Ik))
    cyclic = 1 if (j - i) % 3 == 1 else -1
    sign_i, sign_k = (-1 if x < 0 else 1 for x in (gi, gk))
    sign_j = sign_i * sign_k * cyclic * (1 if Ik > Ii else -1)
    am0 = mp.atan2(sign_j * gj / aj, sign_i * gi / ai)
    u = mp.ellipf(am0, m) + rate * t
    sn, cn, dn = (mp.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))
    am = mp.atan2(sn, cn)
    if m < 1:
        am += 2 * mp.pi * mp.nint(u / (4 * mp.ellipk(m)) - am / (2 * mp.pi))
    G, across = length([gi, gj, gk]), gi**2 + gj**2 * (1 / Ik - 1 / Ij) / (1 / Ik - 1 / Ii)
    legendre = third_integral(-(ak**2) * m / across, am, m) - third_integral(-(ak**2) * m / across, am0, m)
    values = {i: sign_i * ai * cn, j: sign_j * aj * sn, k: sign_k * ak * dn}
    return [values[axis] for axis in range(3)], G * t / Ik + G * about_i / across * legendre / rate


def third_integral(nu, am, m):
    """Legendre's Pi(nu; am | m), the amplitude brought between -pi / 2 and pi / 2."""
    halves = mp.nint(am / mp.pi)
    return (2 * halves * mp.ellippi(nu, m) if halves else 0) + mp.ellippi(nu, am - halves * mp.pi, m)


def rotated(q, x):
    """q x q~ / |q|^2."""
    return [y / length(q) ** 2 for y in product(product(q, [0, *x]), conjugate(q))[1:]]


def turned(x, about, angle):
    """The vector x turned about another one by an angle."""
    size = length(about) or 1
    return rotated([mp.cos(angle / 2), *(mp.sin(angle / 2) * y / size for y in about)], x)


def triad(first, second):
    """Three orthonormal vectors: along the first, along the rest of the second, and their product."""
    a = [x / length(first) for x in first]
    rest = [y - dot(a, second) * x for x, y in zip(a, second, strict=True)]
    b = [x / length(rest) for x in rest]
    return a, b, product([0, *a], [0, *b])[1:]


def dot(x, y):
    return sum(a * b for a, b in zip(x, y, strict=True))


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("groups", nargs="*", default=list(GROUPS))
    arguments.add_argument("--check", action="store_true", help="compare the stored answers, write nothing")
    chosen = arguments.parse_args()
    (check if chosen.check else write)(chosen.groups)
