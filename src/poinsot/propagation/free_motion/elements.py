r"""Constants of a torque-free rotation, which correspond to the elements of an orbit.

The momentum circles one of the two stable principal axes, called 3 here, with the intermediate axis 2 and the
other stable axis 1; signs are chosen so that g1 >= 0 and g3 >= 0 at the start. With c_i = 1/I_i and

    r = (c1 - c2)/(c1 - c3),  r' = 1 - r,  s = sign(c2 - c3),
    P3 = g3^2 + r g2^2,  P1 = g1^2 + r' g2^2,  G^2 = g1^2 + g2^2 + g3^2,

Euler's equations have the solution, with u = lambda t + u0,

    g1 = sqrt(P1) cn u,  g2 = s sqrt(P1/r') sn u,  g3 = sqrt(P3) dn u,
    m = r P1/(r' P3),  1 - m = (r' g3^2 - r g1^2)/(r' P3),  lambda = |c1 - c3| sqrt(r' P3)

(Landau and Lifshitz, Mechanics, Sec. 37, with the differences that cancel near the separatrix written out in
the components). With M = AGM(1, sqrt(1 - m)), the axis 3 precesses about the momentum at the mean rate

    Omega = G (c1 - (c1 - c2) S/2),  S = sum of Q_n,  Q_0 = 1,  Q_{n+1} = e_n Q_n/2,
    e_n = (p_n^2 - a_n b_n)/(p_n^2 + a_n b_n),  p_{n+1} = (p_n^2 + a_n b_n)/(2 p_n),  p_0^2 = 1/r',

a_n and b_n the means of M: the complete elliptic integral of the third kind (DLMF 19.8.7) of the precession.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.double_double import DoubleDouble, pick
from poinsot.functions import Vector
from poinsot.kinematics.state import State
from poinsot.mechanics.kinetics import turned
from poinsot.quantities import Array

__all__ = ["Elements", "elements_of"]

Integers = NDArray[np.int_]
Flags = NDArray[np.bool_]

MAX_AGM_STEPS = 64
"""Rounds of the arithmetic-geometric mean. Six suffice for 1 - m above 1e-9; each factor 1/4 of r' needs one more."""

MIN_MOMENTUM = 1e-145
"""The largest component of the momentum is of the order of one; a square of what is smaller has too few digits."""

MEANS_TOLERANCE = 1e-17
"""Relative difference of the two means below which the next round ends below 1e-33."""


@dataclass(frozen=True)
class Elements:
    """Constants and initial phase of a free rotation; scalars, or arrays of shape (members,).

    Attributes
    ----------
    axes : array (..., 3, 3)
        Columns: the axes 1, 2, 3 in body axes.
    is_long : bool
        Whether the axis 3 is that of the smallest moment.
    r, r_other : DoubleDouble
        r and r' = 1 - r.
    moments : tuple of 3
        I1, I2, I3.
    momentum : tuple of 3 DoubleDouble
        g1, g2, g3 at the start, divided by `scale`; (0, 0, 1) for a body at rest.
    scale : float
        A power of two, or zero for a body at rest.
    P1, P3, G : DoubleDouble
        Of the scaled momentum.
    m, m_other : DoubleDouble
        The parameter m of the elliptic functions, and 1 - m.
    mean, mean_other : DoubleDouble
        AGM(1, sqrt(1 - m)) = pi / (2 K) and AGM(1, sqrt(m)) = pi / (2 K').
    rate : DoubleDouble
        lambda.
    precession : DoubleDouble
        Omega, the mean rate of the precession.
    """

    axes: NDArray[np.float64]
    is_long: Flags
    r: DoubleDouble
    r_other: DoubleDouble
    moments: tuple[Array, Array, Array]
    momentum: tuple[DoubleDouble, DoubleDouble, DoubleDouble]
    scale: Array
    P1: DoubleDouble
    P3: DoubleDouble
    G: DoubleDouble
    m: DoubleDouble
    m_other: DoubleDouble
    mean: DoubleDouble
    mean_other: DoubleDouble
    rate: DoubleDouble
    precession: DoubleDouble

    @property
    def _member_axes(self) -> dict[str, int]:
        return {field.name: 2 if field.name == "axes" else 0 for field in fields(self)}

    def _with_values(self, **values: Any) -> Elements:
        return Elements(**values)

    @property
    def sense(self) -> Array:
        """Sign s: +1 for a rotation about the axis of the largest moment, -1 about the axis of the smallest."""
        return np.where(self.is_long, -1.0, 1.0)[()]

    @property
    def winding(self) -> DoubleDouble:
        """Mean rate of the momentum about the axis 3, pi lambda / (2 K)."""
        return self.rate * self.mean


def elements_of(moments: Array, principal: Array, state: State) -> Elements:
    """Return the elements of rotations from states; `principal` contains the principal axes in columns."""
    with np.errstate(all="ignore"):  # what is not defined for a symmetric body or one at rest is replaced
        return _elements(moments, principal, state)


def _elements(moments: Array, principal: Array, state: State) -> Elements:
    g, exponent, at_rest = _scaled_momentum(principal, state)
    size = _exponent(moments)
    moments = np.broadcast_to(np.ldexp(moments, -size[..., None]), (*np.shape(exponent), 3))
    order = np.argsort(moments, axis=-1, kind="stable")
    a, b, c = _along(np.take_along_axis(moments, order, axis=-1))
    r, r_other = _ratios(a, b, c)
    g = _chosen(order, g)
    gap = r_other * (g[2] * g[2]) - r * (g[0] * g[0])
    is_long = (gap.hi < 0) | ((gap.hi == 0) & (r.hi > 0.5))
    order = np.where(np.asarray(is_long)[..., None], order[..., ::-1], order)
    r, r_other = pick(is_long, r_other, r), pick(is_long, r, r_other)
    g = (pick(is_long, g[2], g[0]), g[1], pick(is_long, g[0], g[2]))
    I1, I2, I3 = np.where(is_long, c, a)[()], b, np.where(is_long, a, c)[()]
    signs = _signs(order, g)
    g = (g[0] * signs[0], g[1] * signs[1], g[2] * signs[2])
    axes = principal @ (np.eye(3)[order].swapaxes(-1, -2) * np.stack(signs, axis=-1)[..., None, :])

    squares = [x * x for x in g]
    P1, P3 = squares[0] + r_other * squares[1], squares[2] + r * squares[1]
    G = (squares[0] + squares[1] + squares[2]).sqrt()
    round_ = r.hi == 0  # symmetric about the axis 3, or spherical
    m = pick(round_, 0.0, r * P1 / (r_other * P3))
    m_other = pick(round_, 1.0, pick(is_long, -gap, gap) / (r_other * P3))
    mean, total = _mean_and_sum(m_other.sqrt(), (1 / r_other).sqrt())
    mean_other = _mean(m.sqrt())
    spread = DoubleDouble.difference(I3, I1) / (DoubleDouble(I1) * I3)
    rate = pick(is_long, -spread, spread) * (r_other * P3).sqrt()
    precession = G * (1 / DoubleDouble(I1) - (DoubleDouble.difference(I2, I1) / (DoubleDouble(I1) * I2) * total) * 0.5)
    scale, pace = (np.where(at_rest, 0.0, np.exp2(power))[()] for power in (exponent, exponent - size))
    return Elements(
        axes, is_long, r, r_other, (np.ldexp(I1, size), np.ldexp(I2, size), np.ldexp(I3, size)), g, scale, P1, P3, G,
        m, m_other, mean, mean_other, rate.scaled(pace), precession.scaled(pace),
    )  # fmt: skip


def _scaled_momentum(principal: Array, state: State) -> tuple[tuple[DoubleDouble, ...], Integers, Flags]:
    """Return g, or Im(q~ Q) / 2, along the principal axes, its largest component between 1/2 and 1, without rounding.

    Components that are next to nothing are zero. Also the exponent of the power of two that was taken out, and
    whether the momentum is zero, which makes it (0, 0, 1).
    """
    held = state.phase.get("angular_momentum_body")
    momenta = state.conjugate_momenta if held is None else held
    first = _exponent(momenta)
    body: Any = Vector(map(DoubleDouble, _along(np.ldexp(momenta, -first[..., None]))))
    if held is None:
        q = Vector(map(DoubleDouble, _along(state.quaternion)))
        body, first = quat.imaginary(quat.product(quat.conjugate(q), body)), first - 1
    g = turned(np.swapaxes(principal, -1, -2), body)
    high = np.stack([x.hi for x in g], axis=-1)
    second, at_rest = _exponent(high), np.all(high == 0, axis=-1)
    g1, g2, g3 = (x.scaled(np.exp2(-second)[()]) for x in g)
    g1, g2, g3 = (pick(np.abs(x.hi) < MIN_MOMENTUM, 0.0, x) for x in (g1, g2, g3))
    return (g1, g2, pick(at_rest, 1.0, g3)), first + second, at_rest


def _exponent(numbers: Array) -> Integers:
    """Return the exponent of the power of two above the largest number along the last axis; 0 where all are zero."""
    exponents: Integers = np.frexp(np.max(np.abs(numbers), axis=-1))[1]
    return exponents


def _ratios(a: Array, b: Array, c: Array) -> tuple[DoubleDouble, DoubleDouble]:
    """Return (1/a - 1/b)/(1/a - 1/c) and (1/b - 1/c)/(1/a - 1/c) of moments a <= b <= c; 0 and 1 for a sphere."""
    all_ = DoubleDouble.difference(c, a) * b
    return (
        pick(a == c, 0.0, DoubleDouble.difference(b, a) * c / all_),
        pick(a == c, 1.0, DoubleDouble.difference(c, b) * a / all_),
    )


def _signs(order: Integers, g: tuple[DoubleDouble, ...]) -> tuple[Array, Array, Array]:
    """Return the signs of the axes that make g1 and g3 positive and the axes right-handed."""
    parity = np.linalg.det(np.eye(3)[order]).round()
    first, third = (np.where(x.hi < 0, -1.0, 1.0) for x in (g[0], g[2]))
    return first[()], (parity * first * third)[()], third[()]


def _mean(small: DoubleDouble) -> DoubleDouble:
    """Return AGM(1, small), which is 0 for small = 0."""
    a, b = DoubleDouble(np.ones_like(small.hi)[()]), small
    done: Flags = small.hi == 0
    for _ in range(MAX_AGM_STEPS):
        ends = abs(a.hi - b.hi) <= MEANS_TOLERANCE * a.hi
        a, b = pick(done, a, (a + b).scaled(0.5)), (a * b).sqrt()
        done = done | ends
        if np.all(done):
            break
    return pick(small.hi == 0, 0.0, a)


def _mean_and_sum(small: DoubleDouble, p: DoubleDouble) -> tuple[DoubleDouble, DoubleDouble]:
    """Return AGM(1, small), which is 0 for small = 0, and the sum of Q_n, which is then 2."""
    a, b, term, total = DoubleDouble(np.ones_like(small.hi)[()]), small, DoubleDouble(1.0), DoubleDouble(1.0)
    done: Flags = small.hi == 0
    for _ in range(MAX_AGM_STEPS):
        square, product = p * p, a * b
        term = (term * ((square - product) / (square + product))).scaled(0.5)
        total, p = pick(done, total, total + term), (p + product / p).scaled(0.5)
        ends = (abs(a.hi - b.hi) <= MEANS_TOLERANCE * a.hi) & (abs(term.hi) <= MEANS_TOLERANCE**2)
        a, b = pick(done, a, (a + b).scaled(0.5)), product.sqrt()
        done = done | ends  # the rounds of others do not change it
        if np.all(done):
            break
    return pick(small.hi == 0, 0.0, a), pick(small.hi == 0, 2.0, total)


def _along(array: Array) -> tuple[Array, ...]:
    return tuple(np.moveaxis(np.asarray(array), -1, 0))


def _chosen(order: Integers, g: tuple[DoubleDouble, ...]) -> tuple[DoubleDouble, ...]:
    high, low = (np.take_along_axis(np.stack(np.broadcast_arrays(*part), axis=-1), order, axis=-1) for part in
                 ([x.hi for x in g], [x.lo for x in g]))  # fmt: skip
    return tuple(map(DoubleDouble, _along(high), _along(low)))
