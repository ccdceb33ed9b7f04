"""heyoka by hand: two bodies to second degree, typed out, in units in which distance, mass and G are one."""

import heyoka as hy
import numpy as np


def prepare(pair, start, end, compact=False):
    """Return what integrates to the end and returns the position, in the units of the pair."""
    m1, m2 = (float(m) for m in pair.masses)
    length, mass = float(np.linalg.norm(start.position)), m1 + m2
    period = np.sqrt(length**3 / (pair.G * mass))
    moments = [tuple(np.asarray(body.moments) / (mass * length**2)) for body in pair.bodies.values()]
    masses = m1 / mass, m2 / mass
    velocity = start.momentum / (m1 * m2 / mass)
    own = []
    for body, state in zip(pair.bodies.values(), (start.primary, start.secondary), strict=True):
        own += [*state.quaternion, *(state.angular_momentum_body / body.moments * period)]
    initial = [*(start.position / length), *(velocity * period / length), *own]
    engine = hy.taylor_adaptive(_equations(masses, moments), initial, compact_mode=compact)

    def run():
        engine.time, engine.state[:] = 0.0, initial
        engine.propagate_until(end / period)
        return engine.state[:3] * length

    return run


def _equations(masses, moments):
    r, v = hy.make_vars("x", "y", "z"), hy.make_vars("vx", "vy", "vz")
    square = hy.sum([x * x for x in r])
    distance5, distance7 = square**-2.5, square**-3.5
    force = [-masses[0] * masses[1] * x * square**-1.5 for x in r]
    own = []
    for k, (I, other) in enumerate(zip(moments, masses[::-1], strict=True)):
        q = hy.make_vars(*(f"q{k}{i}" for i in range(4)))
        w = hy.make_vars(*(f"w{k}{i}" for i in range(3)))
        rows = _to_body(*q)
        u = [hy.sum([a * x for a, x in zip(row, r, strict=True)]) for row in rows]
        along = [moment * x for moment, x in zip(I, u, strict=True)]
        about = hy.sum([a * x for a, x in zip(along, u, strict=True)])
        turned = [hy.sum([rows[i][j] * along[i] for i in range(3)]) for j in range(3)]
        for j in range(3):
            force[j] += other * (7.5 * about * distance7 * r[j] - distance5 * (3 * turned[j] + 1.5 * sum(I) * r[j]))
        torque = [3 * other * distance5 * x for x in _cross(u, along)]
        gyration = _cross([moment * x for moment, x in zip(I, w, strict=True)], w)
        own += list(zip(q, _turning(q, w), strict=True))
        own += [(w[i], (gyration[i] + torque[i]) / I[i]) for i in range(3)]
    mu = masses[0] * masses[1]
    return [*zip(r, v, strict=True), *((v[j], force[j] / mu) for j in range(3)), *own]


def _to_body(a, b, c, d):
    return (
        (a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)),
        (2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)),
        (2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d),
    )


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _turning(q, w):
    a, b, c, d = q
    x, y, z = w
    return (
        0.5 * (-b * x - c * y - d * z),
        0.5 * (a * x + c * z - d * y),
        0.5 * (a * y + d * x - b * z),
        0.5 * (a * z + b * y - c * x),
    )
