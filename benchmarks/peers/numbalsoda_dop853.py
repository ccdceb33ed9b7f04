"""numbalsoda's DOP853 (Fortran), with a right-hand side compiled by numba."""

import functools
import math
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np
from numbalsoda import dop853, lsoda_sig

from benchmarks.problems import ellipse

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14)
SHORT_LEVELS = (1e-10, 1e-14)
MOST_STEPS = 10_000_000


def _free(_problem):
    @numba.njit
    def torque(_t, _q0, _q1, _q2, _q3):
        return 0.0, 0.0, 0.0

    return torque


def _top(problem):
    weight = problem.weight

    @numba.njit
    def torque(_t, q0, q1, q2, q3):
        return 0.0, weight * (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3), -weight * 2 * (q0 * q1 + q2 * q3)

    return torque


def _satellite(problem):
    A, B, C = problem.moments
    o = ellipse()
    mu, a, e, n = o.mu, o.a, o.e, o.mean_motion
    (P1, P2, P3), (L1, L2, L3) = o.to_periapsis, o.to_latus_rectum
    b = a * math.sqrt(1 - e * e)

    @numba.njit
    def torque(t, q0, q1, q2, q3):
        M = n * t
        E = M + e * math.sin(M)
        for _ in range(20):
            step = (E - e * math.sin(E) - M) / (1 - e * math.cos(E))
            E -= step
            if abs(step) < 1e-15 * max(1.0, abs(E)):
                break
        c, s = math.cos(E), math.sin(E)
        r = a * (1 - e * c)
        x, y = a * (c - e) / r, b * s / r
        x1, x2, x3 = x * P1 + y * L1, x * P2 + y * L2, x * P3 + y * L3
        u1 = (q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3) * x1 + 2 * (q1 * q2 + q0 * q3) * x2 + 2 * (q1 * q3 - q0 * q2) * x3
        u2 = 2 * (q1 * q2 - q0 * q3) * x1 + (q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3) * x2 + 2 * (q2 * q3 + q0 * q1) * x3
        u3 = 2 * (q1 * q3 + q0 * q2) * x1 + 2 * (q2 * q3 - q0 * q1) * x2 + (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3) * x3
        K = 3 * mu / (r * r * r)
        return K * (C - B) * u2 * u3, K * (A - C) * u3 * u1, K * (B - A) * u1 * u2

    return torque


@functools.cache
def _solver(problem):
    A, B, C = problem.moments
    torque = {"free": _free, "top": _top, "satellite": _satellite}[problem.kind](problem)

    @numba.cfunc(lsoda_sig)
    def rates(t, u, du, _p):
        q0, q1, q2, q3, w1, w2, w3 = u[0], u[1], u[2], u[3], u[4], u[5], u[6]
        m1, m2, m3 = torque(t, q0, q1, q2, q3)
        du[0] = 0.5 * (-q1 * w1 - q2 * w2 - q3 * w3)
        du[1] = 0.5 * (q0 * w1 + q2 * w3 - q3 * w2)
        du[2] = 0.5 * (q0 * w2 + q3 * w1 - q1 * w3)
        du[3] = 0.5 * (q0 * w3 + q1 * w2 - q2 * w1)
        du[4] = (m1 + (B - C) * w2 * w3) / A
        du[5] = (m2 + (C - A) * w3 * w1) / B
        du[6] = (m3 + (A - B) * w1 * w2) / C

    @numba.njit(nogil=True)
    def solve(address, starts, times, tolerance, smallest):
        out = np.empty((len(starts), 4))
        none = np.zeros(1)
        for i in range(len(starts)):
            rows, good = dop853(address, starts[i], times, none, tolerance, tolerance * smallest, MOST_STEPS)
            out[i] = rows[-1, :4]
            if not good:
                out[i] = np.nan
        return out

    return rates, solve


def prepare(problem, level):
    """Return one integration at a relative and absolute tolerance."""
    rates, solve = _solver(problem)
    starts, times = problem.initial[None].copy(), np.array([0.0, problem.end])
    return lambda: (solve(rates.address, starts, times, level, problem.smallest)[0], problem.end)


def prepare_ensemble(problem, starts, threads, tolerance):
    """Return a run over starts (members, 7), shared among threads without the interpreter's lock."""
    rates, solve = _solver(problem)
    times = np.array([0.0, problem.end])
    shares = np.array_split(starts, 8 * threads)

    def share(chosen):
        return solve(rates.address, chosen, times, tolerance, problem.smallest)

    def run():
        with ThreadPoolExecutor(threads) as pool:
            return np.concatenate(list(pool.map(share, shares)))

    return run
