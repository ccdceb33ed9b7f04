"""scipy.integrate.solve_ivp, DOP853, with a NumPy right-hand side."""

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.problems import ellipse

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12)
SHORT_LEVELS = (1e-10,)


def _free(_t, _q):
    return np.zeros(3)


def _to_body(q, vector):
    s, v = q[0], q[1:]
    return vector + 2 * np.cross(v, np.cross(v, vector) - s * vector)


def _top(problem):
    center, down = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -problem.weight])
    return lambda _t, q: np.cross(center, _to_body(q, down))


def _satellite(problem):
    o, moments = ellipse(), np.array(problem.moments)
    P, L = o.a * np.array(o.to_periapsis), o.a * np.sqrt(1 - o.e**2) * np.array(o.to_latus_rectum)

    def torque(t, q):
        M = o.mean_motion * t
        E = M
        for _ in range(20):
            step = (E - o.e * np.sin(E) - M) / (1 - o.e * np.cos(E))
            E = E - step
            if abs(step) < 1e-15 * max(1.0, abs(E)):
                break
        x = P * (np.cos(E) - o.e) + L * np.sin(E)
        r = np.sqrt(x @ x)
        u = _to_body(q, x / r)
        return 3 * o.mu / r**3 * np.cross(u, moments * u)

    return torque


def prepare(problem, level):
    """Return one integration at a relative and absolute tolerance."""
    moments = np.array(problem.moments)
    torque = {"free": lambda _: _free, "top": _top, "satellite": _satellite}[problem.kind](problem)

    def rates(t, y):
        q, w = y[:4], y[4:]
        q_dot = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([q_dot, (torque(t, q) - np.cross(w, moments * w)) / moments])

    def run():
        span, absolute = (0.0, problem.end), level * problem.smallest
        found = solve_ivp(rates, span, problem.initial, "DOP853", rtol=level, atol=absolute)
        return found.y[:4, -1], problem.end

    return run
