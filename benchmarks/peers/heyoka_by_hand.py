"""heyoka by hand in (q, omega): equations typed out, numbers as literals, `propagate_until`."""

import functools

import heyoka as hy
import numpy as np

from benchmarks.problems import ENSEMBLE_END, ellipse

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, None)
SHORT_LEVELS = (1e-8, 1e-12, None)


def kinematics(q0, q1, q2, q3, w1, w2, w3):
    """Return the equations of the quaternion."""
    return [
        (q0, 0.5 * (-q1 * w1 - q2 * w2 - q3 * w3)),
        (q1, 0.5 * (q0 * w1 + q2 * w3 - q3 * w2)),
        (q2, 0.5 * (q0 * w2 + q3 * w1 - q1 * w3)),
        (q3, 0.5 * (q0 * w3 + q1 * w2 - q2 * w1)),
    ]


def free(problem):
    """Return the equations of a free body."""
    q0, q1, q2, q3, w1, w2, w3 = hy.make_vars("q0", "q1", "q2", "q3", "w1", "w2", "w3")
    A, B, C = problem.moments
    return [
        *kinematics(q0, q1, q2, q3, w1, w2, w3),
        (w1, (B - C) * w2 * w3 / A),
        (w2, (C - A) * w3 * w1 / B),
        (w3, (A - B) * w1 * w2 / C),
    ]


def top(problem):
    """Return the equations of the top: torque x_c x F, x_c = (1, 0, 0)."""
    q0, q1, q2, q3, w1, w2, w3 = hy.make_vars("q0", "q1", "q2", "q3", "w1", "w2", "w3")
    A, B, C = problem.moments
    F2 = -problem.weight * 2 * (q0 * q1 + q2 * q3)
    F3 = -problem.weight * (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3)
    return [
        *kinematics(q0, q1, q2, q3, w1, w2, w3),
        (w1, (B - C) * w2 * w3 / A),
        (w2, ((C - A) * w3 * w1 - F3) / B),
        (w3, ((A - B) * w1 * w2 + F2) / C),
    ]


def satellite(problem):
    """Return the equations of the satellite: Kepler's equation, position, gravity gradient."""
    q0, q1, q2, q3, w1, w2, w3 = hy.make_vars("q0", "q1", "q2", "q3", "w1", "w2", "w3")
    A, B, C = problem.moments
    o = ellipse()
    E = hy.kepE(o.e, o.mean_motion * hy.time)
    c, s = hy.cos(E), hy.sin(E)
    b = o.a * np.sqrt(1 - o.e * o.e)
    r = o.a * (1 - o.e * c)
    x = [(o.a * (c - o.e) * P + b * s * L) / r for P, L in zip(o.to_periapsis, o.to_latus_rectum, strict=True)]
    to_body = [
        [q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2 * (q1 * q2 + q0 * q3), 2 * (q1 * q3 - q0 * q2)],
        [2 * (q1 * q2 - q0 * q3), q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3, 2 * (q2 * q3 + q0 * q1)],
        [2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3],
    ]
    u = [sum(row[k] * x[k] for k in range(3)) for row in to_body]
    K = 3 * o.mu / r**3
    return [
        *kinematics(q0, q1, q2, q3, w1, w2, w3),
        (w1, (B - C) * (w2 * w3 - K * u[1] * u[2]) / A),
        (w2, (C - A) * (w3 * w1 - K * u[2] * u[0]) / B),
        (w3, (A - B) * (w1 * w2 - K * u[0] * u[1]) / C),
    ]


EQUATIONS = {"free": free, "top": top, "satellite": satellite}


def _options(level):
    return {} if level is None else {"tol": level}


@functools.cache
def _integrator(kind, level, problem):
    return hy.taylor_adaptive(EQUATIONS[kind](problem), np.zeros(7), **_options(level))


def prepare(problem, level):
    """Return one propagation with an integrator that is there already."""
    ta = _integrator(problem.kind, level, problem)

    def run():
        ta.time = 0.0
        ta.state[:] = problem.initial
        ta.propagate_until(problem.end)
        return ta.state[:4].copy(), problem.end

    return run


def energy_drift_of_top(problem, initial, times):
    """Return the largest change of the energy over that of |T| + |U|."""
    ta = _integrator("top", None, problem)
    ta.time, ta.state[:] = 0.0, initial
    q0, q1, q2, q3, *omega = ta.propagate_grid(times)[-1].T
    T = 0.5 * sum(moment * w * w for moment, w in zip(problem.moments, omega, strict=True))
    U = problem.weight * 2 * (q1 * q3 - q0 * q2)
    return float(np.max(np.abs(T + U - T[0] - U[0])) / np.max(np.abs(T) + np.abs(U)))


@functools.cache
def _batch(problem):
    lanes = hy.recommended_simd_size()
    return hy.taylor_adaptive_batch(EQUATIONS[problem.kind](problem), np.zeros((7, lanes)))


def prepare_ensemble(problem, starts):
    """Return a run of heyoka's own ensemble function over starts (members, 7), a multiple of the lanes."""
    ta = _batch(problem)
    lanes = ta.batch_size

    def begin(copy, i):
        copy.set_time(0.0)
        copy.state[:] = starts[i * lanes : (i + 1) * lanes].T
        return copy

    def run():
        done = hy.ensemble_propagate_until_batch(ta, ENSEMBLE_END, len(starts) // lanes, begin)
        return np.concatenate([one[0].state[:4].T for one in done])

    return run
