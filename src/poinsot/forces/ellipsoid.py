"""Gravity of an attractor on a homogeneous ellipsoid, to all degrees."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_nonpositive
from poinsot.forces.same_body import refuse_other_inertia
from poinsot.functions import Scalar
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Potential
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.quantities import BodyVector, Rule
from poinsot.records.parameters import Positive
from poinsot.taylor.graph import number

__all__ = ["EllipsoidGravity"]

LAGUERRE_STEPS = 3
"""Number of iterations from 1 to the root of the cubic. The root is exact beyond 1.2 times the longest semiaxis."""

NODES = (
    (0.028493679839790433, 0.00019919367776667182),
    (0.08265024157537047, 0.0015777274154757867),
    (0.16005817516270754, 0.0056152998696684855),
    (0.256394994958856, 0.013512262566013273),
    (0.3662718776192695, 0.02541309449886375),
    (0.4835412595725345, 0.03994364398460304),
    (0.6016416551199844, 0.05427261809507331),
    (0.7139650102763953, 0.06472833400069564),
    (0.8142265655323051, 0.06780522554561355),
    (0.8968167385212248, 0.061249045092475564),
    (0.9571160770219719, 0.044867479219144885),
    (0.9917649012701784, 0.020816076034606053),
)
"""Places and weights that integrate v^(3/2) times a polynomial of degree 23 from 0 to 1 exactly: Gauss and Jacobi."""


class EllipsoidGravity(Potential):
    """Exact gravity of an attractor on a homogeneous ellipsoid, without the terms that do not depend on the attitude.

    U = -3/4 mu M int_L^inf (1 - sum_i x_i^2 / (T + e_i)) dT / sqrt(prod_i (T + e_i)) + mu M / r, with x the position of
    the attractor along the body axes, e_i = a_i^2 minus the mean of the a_i^2, and L the largest T at which the bracket
    vanishes (Kellogg 1929, Foundations of Potential Theory). Gauss quadrature with 12 nodes in L / T computes the
    integral. The relative error of the torque is below 1e-14 from 1.2 times the longest semiaxis outwards; at smaller
    distances it grows with the flattening.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor, with the attractor's `mu`. A periapsis below the longest semiaxis causes
        a warning, and a result counts the times with the attractor inside the ellipsoid, where the formula is not
        valid.
    mass : float
        Mass of the body, in the unit of mass of the moments.
    semiaxes : array (3,), body axes
        Semiaxes in any order, in the unit of length of the orbit.

    Raises
    ------
    ValueError
        If the mass or a semiaxis is not positive. `System` raises it if the inertia tensor differs from the body's by
        more than 1e-9 of the largest moment.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(3, 1, 0))
    >>> gravity = pt.forces.EllipsoidGravity(orbit, mass=1.0, semiaxes=(1, 0.8, 0.5))
    >>> system = pt.System(pt.Body.from_ellipsoid(1.0, (1, 0.8, 0.5)), gravity)
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(6)
    array([0.     , 0.     , 0.00217])
    """

    moves_orbit: ClassVar[bool] = False
    orbit: Orbit
    mass: Positive
    semiaxes: Annotated[BodyVector, Rule(refuse_nonpositive)]

    def __post_init__(self) -> None:
        super().__post_init__()
        longest = np.max(self.semiaxes, axis=-1)
        consequence = "inside the ellipsoid the field outside is continued inwards"
        warn_below(self, self.orbit, longest, "the end of the longest semiaxis", consequence)

    @override
    def energy(self, instant: Instant) -> Scalar:
        inverse = instant.inverse_distance(self.orbit)
        size = inverse * inverse
        e, n = self._excesses(), instant.attitude.to_body(instant.direction(self.orbit))
        squares, pairs = [x * x for x in n], (e[1] * e[2], e[2] * e[0], e[0] * e[1])
        linear = size * functions.dot(e, squares)
        mixed = size * size * functions.dot(pairs, squares)
        shape = size * size * sum(pairs), size * size * size * (e[0] * pairs[0])
        return inverse * (-0.75 * self.orbit.mu * self.mass) * _beyond_the_sphere(linear, mixed, *shape)

    def _excesses(self) -> functions.Vector:
        """Return the squared semiaxes minus their mean, without loss of digits for nearly equal semiaxes."""
        a, b, c = self.semiaxes
        ab, bc, ca = (a - b) * (a + b), (b - c) * (b + c), (c - a) * (c + a)
        return functions.Vector(((ab - ca) / 3, (bc - ab) / 3, (ca - bc) / 3))

    @override
    def check(self, body: Body) -> None:
        square = np.asarray(self.semiaxes) ** 2
        moments = np.asarray(self.mass)[..., None] / 5 * (np.sum(square, axis=-1, keepdims=True) - square)
        own = moments[..., None] * np.eye(3)
        hint = "Body.from_ellipsoid(mass, semiaxes) has the right one."
        refuse_other_inertia("mass and semiaxes", own, body.inertia, body, hint)

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        place = instant.attitude.to_body(instant.position(self.orbit))
        outwards = sum((x / a) * (x / a) for x, a in zip(place, self.semiaxes, strict=True))
        return {"inside_ellipsoid": functions.less(outwards, 1)}


def _beyond_the_sphere(q1: Scalar, q2: Scalar, e2: Scalar, e3: Scalar) -> Scalar:
    """Return r times the integral, less 4/3, from sum n_i^2 d_i, sum n_i^2 d_j d_k, sum d_j d_k, d_1 d_2 d_3.

    With d = e / r^2, l = L / r^2, v = L / T and y = v / l, the product under the root is T^3 (1 + x), x = y^2 (e2 +
    e3 y): the d_i sum up to zero. Every term is as small as the d_i.
    """
    l = _largest_root(number(e2 + q1), number(e3 - q2))  # no derivative: the integrand is zero where it begins
    inverse = 1 / l
    second, third = e2 * inverse * inverse, e3 * inverse * inverse * inverse
    excesses = [v * v * second + v * v * v * third for v, _ in NODES]
    powers = [(1 + x) ** -1.5 for x in excesses]
    straight = sum(w * power for (_, w), power in zip(NODES, powers, strict=True))
    bent = inverse * sum(w * v * power for (v, w), power in zip(NODES, powers, strict=True))
    rest = sum(
        w * l / v * x * (power - (l / v - 1) / (1 + x + functions.sqrt(1 + x)))
        for (v, w), power, x in zip(NODES, powers, excesses, strict=True)
    )
    root = functions.sqrt(inverse)
    short = (inverse - 1) / (root + 1)
    return root * inverse * inverse * (q1 * straight - q2 * bent + rest) - 2 / 3 * short * short * (root + 2)


def _largest_root(a: Scalar, b: Scalar) -> Scalar:
    """Return the largest root of l^3 - l^2 + a l + b, which has real roots, one near 1, by Laguerre's method."""
    l: Scalar = 1.0
    for _ in range(LAGUERRE_STEPS):
        value, slope, bend = ((l - 1) * l + a) * l + b, (3 * l - 2) * l + a, 3 * l - 1
        l = l - 3 * value / (slope + functions.sqrt(4 * slope * slope - 12 * value * bend))
    return l
