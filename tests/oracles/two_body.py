"""Two-body motion in 50 digits, each conic by its own textbook equation, and rigid bodies along; without poinsot."""

import math
from dataclasses import dataclass

import mpmath
import numpy as np
from mpmath import mpf
from scipy.integrate import solve_ivp

DIGITS = 100
"""Digits to work with, of which Kepler's equation next to a parabola loses many."""


@dataclass(frozen=True)
class Place:
    """Position and velocity in space, and the phase that led to them: the time since the nearest periapsis."""

    position: list
    velocity: list
    since: object


def turned(angle, axis, vector):
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    x, y, z = vector
    return [c * x - s * y, s * x + c * y, z] if axis == 3 else [x, c * y - s * z, s * y + c * z]


def in_space(vector, inclination, node, periapsis):
    vector = turned(mpf(periapsis), 3, vector)
    return turned(mpf(node), 3, turned(mpf(inclination), 1, vector))


def root(function, slope, start):
    """Newton's method until the step is negligible."""
    x = start
    for _ in range(2000):
        step = function(x) / slope(x)
        x -= step
        if abs(step) <= mpmath.mpf(10) ** (-DIGITS // 2) * abs(x):
            return x
    raise ArithmeticError("no convergence")


def eccentric_anomaly(e, M):
    """E of an ellipse, M in [-pi, pi], from the far end, where Newton's method is monotonic."""
    if M == 0:
        return mpf(0)
    return root(lambda E: E - e * mpmath.sin(E) - M, lambda E: 1 - e * mpmath.cos(E), mpmath.sign(M) * mpmath.pi)


def hyperbolic_anomaly(e, N):
    if N == 0:
        return mpf(0)
    far = min(mpmath.asinh(abs(N) / (e - 1)), (6 * abs(N) / e) ** (mpf(1) / 3))
    H = root(lambda H: e * mpmath.sinh(H) - H - abs(N), lambda H: e * mpmath.cosh(H) - 1, far)
    return mpmath.sign(N) * H


def on_ellipse(mu, q, e, since):
    a = q / (1 - e)
    n = mpmath.sqrt(mu / a**3)
    E = eccentric_anomaly(e, n * since)
    b, slope = a * mpmath.sqrt(1 - e * e), 1 - e * mpmath.cos(E)
    r = [a * (mpmath.cos(E) - e), b * mpmath.sin(E), mpf(0)]
    return r, [-a * n * mpmath.sin(E) / slope, b * n * mpmath.cos(E) / slope, mpf(0)]


def on_hyperbola(mu, q, e, since):
    a = q / (e - 1)
    n = mpmath.sqrt(mu / a**3)
    H = hyperbolic_anomaly(e, n * since)
    b, slope = a * mpmath.sqrt(e * e - 1), e * mpmath.cosh(H) - 1
    r = [a * (e - mpmath.cosh(H)), b * mpmath.sinh(H), mpf(0)]
    return r, [-a * n * mpmath.sinh(H) / slope, b * n * mpmath.cosh(H) / slope, mpf(0)]


def on_parabola(mu, q, since):
    """Barker's equation, D + D^3/3 = sqrt(mu/(2 q^3)) t with D = tan(f/2)."""
    W = 3 * mpmath.sqrt(mu / (2 * q**3)) * since / 2
    y = mpmath.cbrt(abs(W) + mpmath.sqrt(W * W + 1))
    D = mpmath.sign(W) * (y - 1 / y)
    rate = mpmath.sqrt(mu / (2 * q**3)) / (1 + D * D)
    return [q * (1 - D * D), 2 * q * D, mpf(0)], [-2 * q * D * rate, 2 * q * rate, mpf(0)]


def two_body(mu, q, e, angles, since):
    """Place at a time since a periapsis; all numbers exact, q the periapsis distance."""
    if e == 1:
        r, v = on_parabola(mu, q, since)
    else:
        r, v = (on_ellipse if e < 1 else on_hyperbola)(mu, q, e, since)
    return Place(in_space(r, *angles), in_space(v, *angles), since)


def ellipse(elements, time):
    """Place on the ellipse of (mu, a, e, inclination, node, periapsis, true anomaly, epoch), doubles."""
    mu, a, e, inclination, node, periapsis, f, epoch = map(mpf, elements)
    E = 2 * mpmath.atan2(mpmath.sqrt(1 - e) * mpmath.sin(f / 2), mpmath.sqrt(1 + e) * mpmath.cos(f / 2))
    n = mpmath.sqrt(mu / a**3)
    M = E - e * mpmath.sin(E) + n * (mpf(time) - epoch)
    M -= 2 * mpmath.pi * mpmath.nint(M / (2 * mpmath.pi))
    return two_body(mu, a * (1 - e), e, (inclination, node, periapsis), M / n)


def escape(elements, time):
    """Place on the orbit of (mu, q, e, inclination, node, periapsis, time since periapsis, epoch), doubles."""
    mu, q, e, inclination, node, periapsis, since, epoch = map(mpf, elements)
    return two_body(mu, q, e, (inclination, node, periapsis), since + (mpf(time) - epoch))


# ---------------------------------------------------------------------- a rigid body under gravity gradient


def attitude_along(moments, mu, matrix, omega, span, times, *, orbit=None, path=None):
    """Rotation matrices and body rates at the times, by DOP853.

    The path is either an orbit, position and velocity at the start, integrated by Newton's law together with the
    attitude, or a function time -> position.
    """
    moments = np.asarray(moments)

    def rates(t, y):
        A, w = y[:9].reshape(3, 3), y[9:12]
        r, v = (path(t), None) if path else (y[12:15], y[15:])
        R, W = np.linalg.norm(r), np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        n = A.T @ r / R
        torque = 3 * mu / R**3 * np.cross(n, moments * n)
        own = [*(A @ W).ravel(), *((np.cross(moments * w, w) + torque) / moments)]
        return own if path else [*own, *v, *(-mu * r / R**3)]

    start = [*np.ravel(matrix), *omega, *([] if path else np.ravel(orbit))]
    solution = solve_ivp(rates, span, start, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13)
    return solution.y[:9].T.reshape(-1, 3, 3), solution.y[9:12].T


def precessing_position(mu, a, e, inclination, node, periapsis, M, epoch, rates):
    """The function time -> position on an ellipse with (node, periapsis, mean anomaly beyond Kepler) rates, floats."""

    def position(t):
        anomaly = M + (math.sqrt(mu / a**3) + rates[2]) * (t - epoch)
        E = anomaly
        for _ in range(100):
            E -= (E - e * math.sin(E) - anomaly) / (1 - e * math.cos(E))
        x, y = a * (math.cos(E) - e), a * math.sqrt(1 - e * e) * math.sin(E)
        u, h = periapsis + rates[1] * (t - epoch), node + rates[0] * (t - epoch)
        p, q = math.cos(u) * x - math.sin(u) * y, math.sin(u) * x + math.cos(u) * y
        q, z = math.cos(inclination) * q, math.sin(inclination) * q
        return np.array([math.cos(h) * p - math.sin(h) * q, math.sin(h) * p + math.cos(h) * q, z])

    return position
