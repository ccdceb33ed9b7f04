"""Moons and Mercury on precessing ellipses, and their Cassini states in 64 bits of mantissa; knows nothing of poinsot.

    python tests/oracles/cassini_worlds.py    print the numbers that `poinsot verify` holds (a minute)

Euler's and Newton's equations of the matrix and its six small motions, by extrapolation of the midpoint rule, and
Newton's method on what is left over after the period.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

YEAR = 365.25
DEGREE = np.pi / 180
LONG = np.longdouble


@dataclass
class World:
    """A body with moments over M R^2 on an ellipse whose node turns; days, radians, km."""

    moments: tuple[float, float, float]
    mu: float
    a: float
    e: float
    i: float
    rate: float  # of the longitude, seen from the node
    node_rate: float
    spin: float = 1.0
    node: float = 0.0
    periapsis: float = np.pi / 4  # from the node; the body is there at t = 0

    @property
    def turns(self):
        return 1 if self.spin % 1 == 0 else 2

    @property
    def period(self):
        return 2 * (LONG(np.pi) + 1.2246467991473532e-16) / self.rate * self.turns

    @property
    def gradient(self):
        return self.mu / self.a**3

    @property
    def flattening(self):
        return (self.moments[2] - self.moments[0]) / self.moments[2]

    @property
    def longitude_constant(self):
        """3 (B - A)/C."""
        return 3 * (self.moments[1] - self.moments[0]) / self.moments[2]

    @property
    def plane(self):
        """The directions to the periapsis, a quarter turn on, and normal, at t = 0, as columns."""
        return about(2, self.node) @ about(0, self.i) @ about(2, self.periapsis)


def of_field(J2, C22, c):
    return c - J2 - 2 * C22, c - J2 + 2 * C22, c


def of_ratios(beta, gamma):
    """(A, B, 1) from beta = (1 - A)/B and gamma = B - A."""
    A = (1 - beta * gamma) / (1 + beta)
    return A, A + gamma, 1.0


def world(moments, gm, a, e, i, rate, node_years, spin=1.0):
    """gm in km3/s2, i in degrees, the sidereal rate in degrees per day; the node moves backwards."""
    node_rate = -2 * np.pi / (node_years * YEAR)
    return World(moments, gm * 86400.0**2, a, e, i * DEGREE, rate * DEGREE - node_rate, node_rate, spin)


WORLDS = {
    "Europa": world(of_field(435.5e-6, 131.5e-6, 0.346), 126686534.0, 671100.0, 0.0094, 0.466, 101.3747242, 30.184),
    "Io": world(of_field(554e-6 * 10 / 3, 554e-6, 0.377), 126686534.0, 421800.0, 0.0041, 0.036, 203.4889583, 7.42),
    "Titan": world(of_field(3.15e-5, 1.1235e-5, 0.31), 37931206.0, 1221870.0, 0.0288, 0.32, 22.5769749, 703.0),
    "Moon": world(of_ratios(6.31e-4, 2.28e-4), 398600.4418, 384399.0, 0.0549, 5.145, 13.176358, 18.6),
    "Mercury": world(of_field(6e-5, 1e-5, 0.34), 132712440018.0, 57909050.0, 0.2056, 8.6, 360 / 87.969, 328e3, 1.5),
}


def about(axis, angle):
    """The active rotation matrix about a coordinate axis, of the angle's own precision."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3, dtype=np.result_type(np.float64, angle))
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[j, i], matrix[i, j] = np.sin(angle), -np.sin(angle)
    return matrix


def skew(a):
    """The matrix of the vector product with a from the left."""
    return np.array([[0 * a[0], -a[2], a[1]], [a[2], 0 * a[0], -a[0]], [-a[1], a[0], 0 * a[0]]])


# ---------------------------------------------------------------------- first theory


def hansen(k, m, e):
    """X_k^(-3, m): the mean of (a/r)^3 cos(m f - k M) over the anomaly M."""
    E = np.arange(400) * 2 * np.pi / 400
    r = 1 - e * np.cos(E)
    f = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(E / 2), np.sqrt(1 - e) * np.cos(E / 2))
    return np.mean(np.cos(m * f - k * (E - e * np.sin(E))) / r**2)


def peale(world):
    """Return the tilt x of a Cassini state and the frequency in longitude, both to the order of the flattening.

    The state balances C p n W sin(i + x) and the slope of the mean energy; p n is the spin, W the rate of the node,
    x the tilt from the normal of the orbit away from the pole, w the periapsis from the node. The energy is
    (3/2) mu/a^3 times (C - (A + B)/2) X(0, 0) sin^2 x/2 - (B - A)/2 Z, where Z = (1 + cos x)^2/4 X(2p, 2) +
    sin^2 x/2 cos 2w X(2p, 0) and X(k, m) = X_k^(-3, m). Peale (1969) has no term in w, which for Mercury can be half a
    percent. The frequency in longitude is the root of 3 (B - A)/C mu/a^3 Z.
    """
    A, B, C = world.moments
    k, e = round(2 * world.spin), world.e
    oblate, direct, still = hansen(0, 0, e), hansen(k, 2, e), np.cos(2 * world.periapsis) * hansen(k, 0, e)

    def balance(x):
        s, c = np.sin(x), np.cos(x)
        slope = (C - (A + B) / 2) * oblate * s * c + (B - A) / 4 * ((1 + c) * direct - 2 * c * still) * s
        return C * world.spin * world.rate * world.node_rate * np.sin(world.i + x) + 1.5 * world.gradient * slope

    second = balance(1e-9) * balance(0.3) > 0  # state 1 does not exist
    x = brentq(balance, -0.3, -world.i) if second else brentq(balance, 1e-9, 0.3)
    Z = (1 + np.cos(x)) ** 2 / 4 * direct + np.sin(x) ** 2 / 2 * still
    return x, np.sqrt(world.longitude_constant * world.gradient * Z)


# ---------------------------------------------------------------------- the motion


def position(world, t):
    """The place of the body seen from the attractor, space axes, in the precision of the time."""
    M = world.rate * t
    E = M
    for _ in range(12):
        E = E - (E - world.e * np.sin(E) - M) / (1 - world.e * np.cos(E))
    e = np.asarray(world.e, dtype=np.result_type(np.float64, t))
    along = world.a * np.array([np.cos(E) - e, np.sqrt(1 - e**2) * np.sin(E), 0 * E])
    one = 1 + 0 * e
    return about(2, world.node * one + world.node_rate * t) @ (
        about(0, world.i * one) @ (about(2, world.periapsis * one) @ along)
    )


def rates(world):
    """The equations of matrix, rate and 6 small motions (rotation vector and change of the rate, body axes)."""

    def function(t, y):
        inertia = np.array(world.moments, dtype=y.dtype)
        A, omega = y[:9].reshape(3, 3), y[9:12]
        turn, change = y[12:30].reshape(3, 6), y[30:].reshape(3, 6)
        r = A.T @ position(world, t)
        strength = 3 * world.mu / np.sum(r * r) ** 2.5
        pulled = inertia * r
        seen = skew(r) @ turn  # the change of r along the turned axes
        twist = strength * (skew(r) @ (inertia[:, None] * seen) - skew(pulled) @ seen)
        gyration = skew(inertia * omega) @ change - skew(omega) @ (inertia[:, None] * change)
        return np.concatenate(
            [
                (A @ skew(omega)).ravel(),
                (skew(inertia * omega) @ omega + strength * skew(r) @ pulled) / inertia,
                (change - skew(omega) @ turn).ravel(),
                ((gyration + twist) / inertia[:, None]).ravel(),
            ]
        )

    return function


def start(A, omega):
    """Variables of a motion and of its small motions, from matrix and rate in body axes."""
    one = np.eye(6, dtype=np.asarray(A).dtype)
    return np.concatenate([np.ravel(A), omega, one[:3].ravel(), one[3:].ravel()])


def extrapolated(function, t, y, step, columns=8):
    """Return y a step later, by Gragg's midpoint rule extrapolated to zero (Bulirsch and Stoer)."""
    table = []
    for k in range(1, columns + 1):
        h, n = step / (2 * k), 2 * k
        before, here = y, y + h * function(t, y)
        for i in range(1, n):
            before, here = here, before + 2 * h * function(t + i * h, here)
        row = [(before + here + h * function(t + step, here)) / 2]
        for j in range(1, k):
            row.append(row[-1] + (row[-1] - table[-1][j - 1]) / ((LONG(k) / (k - j)) ** 2 - 1))
        table.append(row)
    return table[-1][-1]


def reference(world, steps=96):
    """Return the angles of the mean third axis to the normal and to the pole, and the frequencies, ascending."""
    x, _ = peale(world)
    lean = about(2, world.node) @ about(0, x) @ about(2, -world.node)
    A, omega = LONG(1) * (lean @ world.plane), np.array([0, 0, world.spin * world.rate], dtype=LONG)
    omega = omega + A.T @ np.array([0, 0, world.node_rate], dtype=LONG)
    period, function = world.period, rates(world)
    for _ in range(5):
        y, axes, h = start(A, omega), [], period / (steps * world.turns)
        for k in range(steps * world.turns):
            axes.append(about(2, -world.node_rate * k * h) @ y[:9].reshape(3, 3)[:, 2])
            y = extrapolated(function, k * h, y, h)
        left = A.T @ about(2, -world.node_rate * period) @ y[:9].reshape(3, 3)
        left = np.concatenate([(left - left.T)[[2, 0, 1], [1, 2, 0]] / 2, y[9:12] - omega])
        units = np.array([1, 1, 1] + [1 / period] * 3, dtype=LONG)
        matrix = y[12:].reshape(6, 6) * units / units[:, None]
        step = np.linalg.solve((np.eye(6) - matrix).astype(float), (left / units).astype(float)) * units
        A, omega = A @ exponential(step[:3]), omega + step[3:]
        mean, normal = np.mean(axes, axis=0), LONG(1) * world.plane[:, 2]
    angles = [float(angle(mean, d)) for d in (normal, np.eye(3, dtype=LONG)[2])]
    multipliers = np.linalg.eigvals(matrix.astype(float))
    return angles, np.sort(np.abs(np.angle(multipliers)))[::2] / float(period)


def angle(a, b):
    return np.arctan2(np.sqrt(np.sum((skew(a) @ b) ** 2)), a @ b)


def exponential(turn):
    """The rotation matrix of a small rotation vector, by its series."""
    S, term, total = skew(turn), np.eye(3, dtype=LONG), np.eye(3, dtype=LONG)
    for k in range(1, 25):
        term = term @ S / k
        total = total + term
    return total


if __name__ == "__main__":
    for name in ("Moon", "Mercury", "Titan", "Europa"):
        print(name, *reference(WORLDS[name]))
