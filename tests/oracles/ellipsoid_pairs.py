"""The gravity between two homogeneous ellipsoids, exactly, by quadrature; knows nothing of poinsot.

The field of the first one outside of it is in Carlson's symmetric integrals; it is integrated over the second one by
Gauss's rules in a ball, n nodes each along radius and height and 2 n around, which converge exponentially where the
ellipsoids are apart. G is 1; vectors are in space, and an attitude is the matrix body -> space.
"""

import numpy as np
from scipy.special import elliprd, elliprf, roots_jacobi, roots_legendre


def field(mass, semiaxes, x):
    """Potential (n,) and attraction (n, 3) of an ellipsoid along the axes at points x (n, 3) outside."""
    squares = np.asarray(semiaxes, dtype=float) ** 2
    lifted = squares + confocal(squares, x)[:, None]
    a, b, c = lifted.T
    first = elliprf(a, b, c)
    second = np.stack([elliprd(b, c, a), elliprd(c, a, b), elliprd(a, b, c)], axis=-1) / 3
    potential = -1.5 * mass * (first - np.sum(x * x * second, axis=-1))
    return potential, -3 * mass * x * second


def confocal(squares, x):
    """The largest root of sum x_i^2 / (a_i^2 + t) = 1, by Newton's method from above it in terms that are convex."""
    t = np.sum(x * x, axis=-1) - np.min(squares)
    for _ in range(100):
        parts = x * x / (squares + t[:, None])
        value, slope = np.sum(parts, axis=-1), np.sum(parts / (squares + t[:, None]), axis=-1)
        step = value * (1 - value) / slope  # Newton's step of 1 / value, which is nearly straight
        t = t - step
        if np.max(np.abs(step / (squares.max() + np.abs(t)))) < 1e-16:
            break
    return t


def ball(n):
    """Weights (k,), of sum 1, and points (k, 3) of the unit ball."""
    radii, shells = roots_jacobi(n, 0, 2)
    heights, zones = roots_legendre(n)
    angles = np.pi * (np.arange(2 * n) + 0.5) / n
    r, z, angle = np.meshgrid((1 + radii) / 2, heights, angles, indexing="ij")
    weights = np.broadcast_to((shells[:, None] * zones)[..., None], r.shape).ravel()
    across = r * np.sqrt(1 - z * z)
    points = np.stack([across * np.cos(angle), across * np.sin(angle), r * z], axis=-1).reshape(-1, 3)
    return weights / weights.sum(), points


def gravity(masses, semiaxes, separation, attitudes, nodes=16):
    """Potential energy, force on the second one, and both torques about the centres."""
    weights, points = ball(nodes)
    first, second = attitudes
    levers = (points * semiaxes[1]) @ second.T
    potential, attraction = field(masses[0], semiaxes[0], (separation + levers) @ first)
    shares = masses[1] * weights
    pulls = shares[:, None] * (attraction @ first.T)
    force, torque = pulls.sum(axis=0), np.cross(levers, pulls).sum(axis=0)
    return float(shares @ potential), force, -torque - np.cross(separation, force), torque
