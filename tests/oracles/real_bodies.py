"""Gravity of a point on points of mass and on ellipsoids, to as many digits as asked for; knows nothing of poinsot."""

import mpmath
import numpy as np
from scipy.special import factorial, lpmv


def coefficients(masses, points, radius, degree):
    """C and S, not normalised, by their definition as sums over the mass."""
    rho, longitude = np.linalg.norm(points, axis=-1), np.arctan2(points[:, 1], points[:, 0])
    C, S = np.zeros((2, degree + 1, degree + 1))
    for n in range(degree + 1):
        for m in range(n + 1):
            factor = (1 if m == 0 else 2) * factorial(n - m) / factorial(n + m) * (-1) ** m
            legendre = factor * lpmv(m, n, points[:, 2] / rho) * (rho / radius) ** n * masses / np.sum(masses)
            C[n, m], S[n, m] = legendre @ np.cos(m * longitude), legendre @ np.sin(m * longitude)
    return C, S


def many_digits(values):
    return [mpmath.mpf(float(x)) for x in values]


def torque_on_points(mu, position, masses, points):
    """The sum of x times the attraction at r + x, in the working precision; the body is at the position."""
    total = [mpmath.mpf(0)] * 3
    for mass, point in zip(many_digits(masses), map(many_digits, points), strict=True):
        place = [r + x for r, x in zip(many_digits(position), point, strict=True)]
        pull = [-mpmath.mpf(mu) * mass * c / mpmath.sqrt(sum(x * x for x in place)) ** 3 for c in place]
        total = [t + c for t, c in zip(total, cross(point, pull), strict=True)]
    return np.array(total, dtype=float)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class Ellipsoid:
    """A homogeneous one, its potential by Carlson's integrals (DLMF 19.33(ii)) from the confocal ellipsoid on."""

    def __init__(self, mass, semiaxes):
        self.mass, self.semiaxes = mpmath.mpf(mass), many_digits(semiaxes)

    def _confocal(self, place):
        """The squared semiaxes of the confocal ellipsoid through a place outside."""
        a, b, c = squares = [x * x for x in self.semiaxes]
        x, y, z = (value * value for value in place)
        polynomial = [1, a + b + c - x - y - z]
        polynomial += [a * b + b * c + c * a - x * (b + c) - y * (c + a) - z * (a + b)]
        polynomial += [a * b * c - x * b * c - y * c * a - z * a * b]
        roots = mpmath.polyroots(polynomial, maxsteps=500, extraprec=400)
        return [square + max(map(mpmath.re, roots)) for square in squares]

    def _integrals(self, place):
        a, b, c = self._confocal(place)
        whole = 2 * mpmath.elliprf(a, b, c)
        return whole, [2 * mpmath.elliprd(*axes) / 3 for axes in ((b, c, a), (c, a, b), (a, b, c))]

    def energy(self, mu, place):
        """The energy of the ellipsoid in the field of a point at a place along its axes."""
        place = many_digits(place)
        whole, parts = self._integrals(place)
        return -0.75 * mu * self.mass * (whole - sum(x * x * part for x, part in zip(place, parts, strict=True)))

    def torque(self, mu, place):
        """Minus the torque of the pull on the point about the centre of the ellipsoid."""
        place = many_digits(place)
        pull = [-1.5 * mu * self.mass * x * part for x, part in zip(place, self._integrals(place)[1], strict=True)]
        return np.array([-float(c) for c in cross(place, pull)])
