"""Bodies and attractors made of points of mass, and an exactly oblate attractor; knows nothing of poinsot.

Vectors are along one set of axes; x is a place seen from the attractor, shape (..., 3).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import factorial, lpmv


@dataclass
class OblateAttractor:
    """The field -mu/r (1 - J2 (R/r)^2 P2(s)), with s the sine of the latitude over the equator of the pole."""

    mu: float
    j2: float
    radius: float
    pole: np.ndarray

    def potential(self, x):
        r, s = self._distance_and_latitude(x)
        return -self.mu / r * (1 - self.j2 * (self.radius / r) ** 2 * (3 * s**2 - 1) / 2)

    def attraction(self, x):
        """The acceleration at x, minus the gradient of the potential."""
        r, s = (part[..., None] for part in self._distance_and_latitude(x))
        flattening = self.j2 * (self.radius / r) ** 2
        n = x / r
        return -self.mu / r**2 * (n + 1.5 * flattening * ((1 - 5 * s**2) * n + 2 * s * self.pole))

    def tides(self, x):
        """The matrix of second derivatives of the potential at one x."""
        r, s = self._distance_and_latitude(x)
        n, k, one = x / r, self.pole, np.eye(3)
        sphere = one - 3 * np.outer(n, n)
        mixed = np.outer(n, k) + np.outer(k, n)
        oblate = (
            3 * np.outer(k, k) - 15 * s * mixed + 7.5 * (7 * s**2 - 1) * np.outer(n, n) + 1.5 * (1 - 5 * s**2) * one
        )
        return self.mu / r**3 * (sphere + self.j2 * (self.radius / r) ** 2 * oblate)

    def _distance_and_latitude(self, x):
        r = np.linalg.norm(x, axis=-1)
        return r, x @ self.pole / r


@dataclass
class PointAttractor:
    """Points of gravitational parameters `mus` at `places`."""

    mus: np.ndarray
    places: np.ndarray

    def potential(self, x):
        return -np.sum(self.mus / np.linalg.norm(x[..., None, :] - self.places, axis=-1), axis=-1)

    def attraction(self, x):
        way = x[..., None, :] - self.places
        return -np.sum(self.mus[:, None] * way / np.linalg.norm(way, axis=-1, keepdims=True) ** 3, axis=-2)


def ringed(mu, fraction, radius, pole, count=24):
    """A point with a ring about the pole that has a fraction of the whole: J2 R^2 = fraction radius^2 / 2."""
    first = np.cross(pole, [1.0, 0, 0])
    first /= np.linalg.norm(first)
    angles = 2 * np.pi * np.arange(count)[:, None] / count
    ring = radius * (np.cos(angles) * first + np.sin(angles) * np.cross(pole, first))
    mus = np.concatenate([[mu * (1 - fraction)], np.full(count, mu * fraction / count)])
    return PointAttractor(mus, np.concatenate([np.zeros((1, 3)), ring]))


def energy_of(attractor, position, masses, points):
    """The energy of points of mass about their centre at a position."""
    return masses @ attractor.potential(position + points)


def torque_of(attractor, position, masses, points):
    """The sum of d x m a(position + d), along the axes of the positions."""
    return masses @ np.cross(points, attractor.attraction(position + points))


def torque_of_tides(attractor, position, inertia):
    """The torque on a body so small that only its inertia counts: d x (-W'' d) summed over its mass."""
    twist = inertia @ attractor.tides(position)
    return np.array([twist[1, 2] - twist[2, 1], twist[2, 0] - twist[0, 2], twist[0, 1] - twist[1, 0]])


def inertia_of(masses, points):
    return np.sum(masses * np.sum(points**2, axis=-1)) * np.eye(3) - points.T @ (masses[:, None] * points)


# ---------------------------------------------------------------------- spherical harmonics


def harmonics(order, x):
    """P_2m(sin latitude) times cos and sin of m longitude, without the phase of Condon and Shortley."""
    r, longitude = np.linalg.norm(x, axis=-1), np.arctan2(x[..., 1], x[..., 0])
    legendre = (-1) ** order * lpmv(order, 2, x[..., 2] / r)
    return legendre * np.cos(order * longitude), legendre * np.sin(order * longitude)


def stokes(masses, points, radius):
    """The coefficients C2m, S2m, not normalised, by their definition as integrals over the mass."""
    weights = masses * np.sum(points**2, axis=-1) / (np.sum(masses) * radius**2)
    coefficients = {}
    for m in range(3):
        factor = (1 if m == 0 else 2) * factorial(2 - m) / factorial(2 + m)
        coefficients[f"C2{m}"], coefficients[f"S2{m}"] = (factor * weights @ part for part in harmonics(m, points))
    return coefficients


def outer_potential(mass, radius, coefficients, x):
    """-M/r (1 + (R/r)^2 sum of the harmonics of second degree)."""
    r = np.linalg.norm(x, axis=-1)
    total = 0.0
    for m in range(3):
        cosines, sines = harmonics(m, x)
        total = total + coefficients[f"C2{m}"] * cosines + coefficients[f"S2{m}"] * sines
    return -mass / r * (1 + (radius / r) ** 2 * total)
