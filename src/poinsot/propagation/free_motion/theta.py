r"""Attitude of a free rotation by theta functions: two of them are its Cayley-Klein parameters.

In axes with the momentum along the third, the quaternion (w, x, y, z) of the axes 1, 2, 3 is proportional to

    w + i z = exp(i mu t/2) theta_4(zeta),   x + i y = s exp(i mu t/2) theta_1(zeta),

zeta = pi (u + i v0)/(2 K), nome exp(-2 pi K'/K), s the sense of the motion; for s = +1 the theta functions are
conjugated. The pole is v0 = F(asin sqrt(r') | 1 - m), and mu = Omega - s pi lambda/(2 K). That quaternions of the
free body are such quotients is Jacobi's discovery (1850, J. reine angew. Math. 39, 293).

Where the nome is large, near the separatrix, the same functions are summed in the complementary nome
exp(-pi K/(2 K')), by Jacobi's imaginary transformation (DLMF 20.7.30-33), in x = pi u/(4 K'). On the separatrix
one term is left of the series, a hyperbolic function.

The momentum along the axes 1, 2, 3 is that of Euler's equations, by the theta functions of a real argument (DLMF
22.2): each component has the rounding of its own amplitude, which for a slender body is far below |g|.

What grows with time is reduced in twice the double precision: its error does not grow.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.double_double import PI, DoubleDouble, pick
from poinsot.propagation.free_motion.elements import Elements
from poinsot.quantities import Array

__all__ = ["Theta", "is_near_separatrix", "theta_functions"]

Complex = NDArray[np.complex128]
Integers = NDArray[np.int_]
Flags = NDArray[np.bool_]
Numbers = TypeVar("Numbers", Array, Complex)
Coefficients = tuple[Complex | float, Complex | float, Array | float]
Place = TypeVar("Place")
"""Reduced argument of the functions."""

MAX_OMITTED_TERM = 2.0**-56
"""Size of the first omitted term of a series that begins with one."""

LIMITING_ARGUMENT = 1e3
"""Argument at which hyperbolic functions have their limits, for a body that rotates about its middle axis."""


def is_near_separatrix(elements: Elements) -> Flags:
    """Return True where the complementary nome is the smaller one, K > 2 K'."""
    return np.asarray(elements.mean_other.hi > 2 * elements.mean.hi)[()]


def theta_functions(elements: Elements, near: bool) -> Near | Far:
    """Return the functions of rotations that are all near the separatrix or all far from it."""
    with np.errstate(all="ignore"):  # what is not defined on the separatrix or for a symmetric body is replaced
        return Near(elements) if near else Far(elements)


class Theta(ABC, Generic[Place]):
    """Theta functions of rotations after their initial states; results have shape (..., times)."""

    def __init__(self, elements: Elements) -> None:
        from scipy.special import elliprf

        e = elements
        G2, P1, P3, r, r_other = (number.hi for number in (e.G * e.G, e.P1, e.P3, e.r, e.r_other))
        g1, g2, g3 = (component.hi for component in e.momentum)
        turning, triaxial = P1 > 0, r > 0
        sine = e.sense * g2 * np.sqrt(r_other / P1)
        flatness = np.where(triaxial, g3 * g3 / P3, 1.0)
        self.e = e
        self.sense = _column(e.sense)
        self.start = np.where(turning, sine * elliprf(g1 * g1 / P1, flatness, 1.0), 0.0)
        self.pole = np.where(triaxial, np.sqrt(r_other) * elliprf(r, r * G2 / P3, 1.0), np.inf)
        self.before_pole = np.where(turning, np.sqrt(P3 / G2) * elliprf(P1 / G2, P1 / r_other / G2, 1.0), np.inf)
        self.half_turns = ((e.precession - e.winding * e.sense) / PI).scaled(0.25)  # mu/2 in turns
        self._prepare()
        self.amplitudes = np.stack(
            [
                e.scale * np.sqrt(P1),
                e.scale * e.sense * np.sqrt(np.where(turning, (e.P1 / e.r_other).hi, 0.0)),
                e.scale * np.sqrt(P3),
            ],
            axis=-1,
        )
        alpha, _, common = self._at(self._place(DoubleDouble(np.zeros((*np.shape(g1), 1)))))
        self.first_angle = np.angle(alpha) + common

    @abstractmethod
    def _prepare(self) -> None:
        """Find the coefficients of the series."""

    @abstractmethod
    def _place(self, elapsed: DoubleDouble) -> Place:
        """Return the argument of the functions, reduced to a period."""

    @abstractmethod
    def _at(self, place: Place) -> Coefficients:
        """Return theta_4 and theta_1 up to a common factor, and a common phase; shapes (..., times)."""

    @abstractmethod
    def _elliptic(self, place: Place) -> tuple[Array, Array, Array]:
        """Return cn u, sn u and dn u; shapes (..., times)."""

    def first(self) -> Array:
        """Return the initial quaternions: the shortest rotation from the momentum to the third axis."""
        g1, g2, g3 = (component.hi for component in self.e.momentum)
        return _unit(np.stack(np.broadcast_arrays(self.e.G.hi + g3, g2, -g1, 0.0), axis=-1))

    def motion(self, elapsed: DoubleDouble) -> tuple[Array, Array]:
        """Return the quaternions of the axes 1, 2, 3 after some times, and the momentum along them."""
        place = self._place(elapsed)
        alpha, beta, common = self._at(place)
        momenta = np.stack(self._elliptic(place), axis=-1) * self.amplitudes[..., None, :]
        angle = _radians(_columns(self.half_turns) * elapsed) - self.sense * (common - self.first_angle)
        c, s = np.cos(angle), np.sin(angle)
        ar, ai, br, bi = alpha.real, -self.sense * alpha.imag, self.sense * beta.real, -beta.imag
        return _unit(np.stack([c * ar - s * ai, c * br - s * bi, c * bi + s * br, c * ai + s * ar], axis=-1)), momenta


class Far(Theta[Complex]):
    """Far from the separatrix: by the nome exp(-pi K'/K) = ahead * behind, at most exp(-pi/2)."""

    def _prepare(self) -> None:
        mean = self.e.mean.hi
        self.turns = _columns((self.e.winding / PI).scaled(0.5))
        self.start_turns = _column(mean * self.start / (2 * np.pi))
        self.ahead, self.behind = (_column(np.exp(-2 * mean * v)) for v in (self.before_pole, self.pole))
        self.nome = self.ahead * self.behind
        self.terms = _terms(self.nome, lambda n: 2 * n * n - n)
        self.real_terms = _terms(self.nome, lambda n: n * n)
        self.at_zero = self._theta(np.ones_like(self.nome, dtype=complex))

    def _place(self, elapsed: DoubleDouble) -> Complex:
        z = _radians(self.turns * elapsed + self.start_turns)
        return np.cos(z) + 1j * np.sin(z)

    def _theta(self, w: Complex) -> tuple[Array, Array, Array, Array]:
        """Return theta_1 and theta_2 of z, without 2 nome^(1/4), theta_3 and theta_4; w = exp(i z)."""
        first, second, power = w.imag, w.real, w
        third = fourth = np.ones_like(second)
        for n in range(1, np.max(self.real_terms) + 1):
            power, sign, counts = power * w, (-1) ** n, n <= self.real_terms
            even = counts * 2 * self.nome ** (n * n) * power.real
            power = power * w
            size = counts * self.nome ** (n * n + n)
            first, second = first + sign * size * power.imag, second + size * power.real
            third, fourth = third + even, fourth + sign * even
        return first, second, third, fourth

    def _elliptic(self, place: Complex) -> tuple[Array, Array, Array]:
        (first, second, third, fourth), (_, of2, of3, of4) = self._theta(place), self.at_zero
        return of4 / of2 * second / fourth, of3 / of2 * first / fourth, of4 / of3 * third / fourth

    def _at(self, place: Complex) -> Coefficients:
        w = place
        square, power = w * w, w
        alpha, beta = 1.0, w.conj() - self.behind * w
        for n in range(1, np.max(self.terms) + 1):
            size = (n <= self.terms) * (-self.ahead) ** n * self.nome ** (2 * n * n - n)
            even, power = power * w, power * square
            alpha = alpha + size * (even.conj() + self.behind ** (2 * n) * even)
            beta = beta + size * self.nome ** (2 * n) * (power.conj() - self.behind ** (2 * n + 1) * power)
        return alpha + 0j * w, 1j * np.sqrt(self.ahead) * beta, 0.0


NearPlace = tuple[Array, Array, Array, Array, Array]


class Near(Theta[NearPlace]):
    """Near the separatrix: by the nome p = exp(-length), length = pi K/(2 K') half a period of x or infinite."""

    def _prepare(self) -> None:
        mean, other = self.e.mean, self.e.mean_other
        self.endless = _column(mean.hi == 0)
        still = np.isinf(self.start)
        length = pick(mean.hi == 0, 1.0, (PI * other / mean).scaled(0.5))
        self.length = _columns(length)
        self.rate = _columns(pick(still, 0.0, (self.e.rate * other).scaled(0.5)))
        self.start_x = _column(np.where(still, np.sign(self.start) * LIMITING_ARGUMENT, 0.5 * other.hi * self.start))
        self.drift = _column(np.where(mean.hi == 0, 0.0, 2 / np.pi * mean.hi * self.pole))  # v0/K
        self.nome = np.where(self.endless, 0.0, np.exp(-self.length.hi))
        self.pole_angle = _column(0.5 * other.hi * self.pole)
        self.terms = _terms(self.nome, lambda n: n * n)

    def _place(self, elapsed: DoubleDouble) -> NearPlace:
        x = self.rate * elapsed + self.start_x
        periods = np.where(self.endless, 0.0, np.rint(x.hi / self.length.hi))
        x = (x - self.length * periods).hi
        side = np.where(x < 0, -1.0, 1.0)
        falling = np.exp(-2 * np.abs(x))
        rising = np.exp(np.where(self.endless, -np.inf, 2 * np.abs(x) - self.length.hi))
        return x, side, 1 - 2 * (periods % 2), falling, rising

    def _elliptic(self, place: NearPlace) -> tuple[Array, Array, Array]:
        """Return them by theta functions of i y, y = 2 x, in the nome p^2, all of them times exp(-|y|)."""
        _, side, parity, falling, rising = place
        first, second, third, fourth = self._theta(falling, rising)
        _, of2, of3, of4 = self._theta(np.ones_like(self.nome), self.nome)
        return (
            parity * of2 / of4 * fourth / second,
            side * parity * of3 / of4 * first / second,
            of2 / of3 * third / second,
        )

    def _theta(self, falling: Array, rising: Array) -> tuple[Array, Array, Array, Array]:
        up: Array | float = 1.0
        down, nome = falling**2, self.nome
        first, second, third, fourth = 1 - down, 1 + down, falling, falling
        for n in range(1, np.max(self.terms) + 1):
            up, down, sign, counts = up * rising, down * falling, (-1) ** n, n <= self.terms
            even = counts * nome ** (2 * n * n - 2 * n + 1) * up + counts * nome ** (2 * n * n) * down
            up, down = up * rising, down * falling
            grown, small = counts * nome ** (2 * n * n) * up, counts * nome ** (2 * n * n + 2 * n) * down
            first, second = first + sign * (grown - small), second + grown + small
            third, fourth = third + even, fourth + sign * even
        return first, second, third, fourth

    def _at(self, place: NearPlace) -> Coefficients:
        x, side, parity, falling, rising = place
        v = np.cos(self.pole_angle) + 1j * side * np.sin(self.pole_angle)
        alpha: Complex | float = 0.0
        beta: Complex | float = 0.0
        power = v
        for n in range(np.max(self.terms) + 1):
            size = rising**n * ((n <= self.terms) * self.nome ** (n * n))
            mirrored = falling ** (2 * n + 1) * power.conj()
            alpha, beta = alpha + size * (power + mirrored), beta + (-1) ** n * size * (power - mirrored)
            power = power * v * v
        return alpha, np.asarray(side * parity * beta), -self.drift * x


def _terms(nome: Array, exponent: Callable[[int], int]) -> Integers:
    """Return the number of the last significant term for each member, independent of the other members."""
    return np.asarray(np.argmax([nome ** exponent(n + 1) < MAX_OMITTED_TERM for n in range(10)], axis=0))[()]


def _radians(turns: DoubleDouble) -> Array:
    radians: Array = 2 * np.pi * ((turns.hi - np.rint(turns.hi)) + turns.lo)
    return radians


def _unit(q: Array) -> Array:
    return np.asarray(q / np.sqrt(np.einsum("...i,...i->...", q, q))[..., None])


def _column(number: Numbers) -> Numbers:
    return np.asarray(number)[..., None]


def _columns(number: DoubleDouble) -> DoubleDouble:
    return DoubleDouble(_column(number.hi), _column(number.lo))
