"""Kepler's equation in universal variables, from the periapsis on, for parabolas and hyperbolas.

With x the universal anomaly, P towards the periapsis q, S a quarter turn on, and S_k = x^k c_k, c_k the Stumpff
functions of -(e - 1) x^2,

    sqrt(mu / q^3) (t - t_p) = x + e S_3,  r = q (1 + e S_2),  r_space = q (1 - S_2) P + q sqrt(1 + e) S_1 S

(Battin 1999, An Introduction to the Mathematics and Methods of Astrodynamics, started at the periapsis). Nothing here
is singular at e = 1, and no two terms cancel.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.taylor.graph import number

__all__ = ["refuse_symbols", "universal_functions", "universal_place", "universal_time"]

STUMPFF_TERMS = 32
"""Terms of the Stumpff series for arguments up to 4, enough for 60 digits."""


def universal_functions(eccentricity: Scalar, anomaly: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return S_1, S_2 and S_3; with H = sqrt(e - 1) x the first is sinh(H)/sqrt(e - 1)."""
    x = anomaly
    y = (eccentricity - 1) * (x * x)
    c2, c3 = _stumpff(y)
    return x * (1 + y * c3), x * x * c2, x * x * x * c3


def universal_time(eccentricity: Scalar, anomaly: Scalar) -> Scalar:
    """Return the time since the periapsis in units of sqrt(q^3 / mu)."""
    return anomaly + eccentricity * universal_functions(eccentricity, anomaly)[2]


def universal_place(eccentricity: Scalar, time: Scalar) -> tuple[Scalar, Scalar]:
    """Return S_1 and S_2 at a time, by Newton's method for x + e S_3 = t, which falls on x from above.

    The last change, below a rounding of x, is applied to the S_k, which at a late time are much steeper than x.
    """
    e = eccentricity
    here = number(time)
    size = abs(here)
    x = _above(e, size)
    enough = 1e-11 if isinstance(x, float | np.ndarray | np.generic) else 1e-2 * functions.sqrt(_rounding())
    for _ in range(60):  # about ten iterations, twice as many for very late times
        step = (universal_time(e, x) - size) / _distance(e, x)
        x = x - step
        if np.all(abs(step) <= enough * abs(x)):  # the next step would be the square of this one
            break
    x = functions.where(functions.less(here, 0), -x, x)
    S1, S2, S3 = universal_functions(e, x)
    change = (time - (x + e * S3)) / (1 + e * S2)  # with the derivatives of the time
    return S1 + (1 + (e - 1) * S2) * change, S2 + S1 * change


def refuse_symbols(name: str, *scalars: Scalar, variable: str = "universal variable") -> None:
    """Raise a TypeError if a scalar is not a number; the message names the variable that a kernel integrates."""
    for scalar in scalars:
        value = number(scalar)
        if functions._engine(value).__name__ == "sympy" or hasattr(value, "apply"):
            raise TypeError(
                f"the formulas of {'an' if name[0] in 'AEIOU' else 'a'} {name} must have numbers, got a symbol. "
                f"In a kernel its {variable} is integrated along: instant.position(orbit) has the position there."
            )


def _rounding() -> Any:
    import mpmath

    return mpmath.eps


def _distance(e: Scalar, x: Scalar) -> Scalar:
    return 1 + e * universal_functions(e, x)[1]


def _above(e: Scalar, t: Scalar) -> Scalar:
    """Return a bound of the solution: the smaller one of a parabola's and a hyperbola's.

    S_3 >= x^3/6 leaves a cubic equation; sinh H - H >= sinh(H)/2 from H = 2.2 on leaves an inverse sinh.
    """
    root = functions.sqrt(2 / e)
    third = _exp_asinh(1.5 * t / root) ** (1 / 3)
    parabolic = root * (third - 1 / third)
    rate = functions.sqrt(e - 1)
    rate = functions.where(functions.less(rate, 1e-100), 1e-100, rate)
    H = functions.log(_exp_asinh(rate * rate * rate * t / (e - 0.5)))
    hyperbolic = functions.where(functions.less(H, 2.2), 2.2, H) / rate
    return functions.where(functions.less(hyperbolic, parabolic), hyperbolic, parabolic)


def _exp_asinh(z: Scalar) -> Scalar:
    return z + functions.sqrt(z * z + 1)


def _stumpff(y: Scalar) -> tuple[Scalar, Scalar]:
    """Return c_2 and c_3 at -y <= 0: (cosh h - 1)/y and (sinh h - h)/(y h), h = sqrt(y)."""
    is_small = functions.less(y, 4)
    small, large = functions.where(is_small, y, 0 * y), functions.where(is_small, 4.0, y)
    c2: Scalar
    c3: Scalar
    c2, c3 = 1, 1
    for k in range(STUMPFF_TERMS, 0, -1):
        c2 = 1 + small / ((2 * k + 1) * (2 * k + 2)) * c2
        c3 = 1 + small / ((2 * k + 2) * (2 * k + 3)) * c3
    h = functions.sqrt(large)
    E = functions.exp(h)
    far2, far3 = (E + 1 / E - 2) / (2 * large), (E - 1 / E - 2 * h) / (2 * large * h)
    return functions.where(is_small, c2 / 2, far2), functions.where(is_small, c3 / 6, far3)
