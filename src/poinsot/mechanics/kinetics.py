"""Angular velocity of a body from its angular momentum."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any

from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.quaternion import assemble, components
from poinsot.functions import Scalar
from poinsot.quantities import Array
from poinsot.records.members import of_arrays
from poinsot.records.parameters import Parametric, Vector

__all__ = ["CompositeKinetics", "Kinetics", "Matrix", "ObliqueKinetics", "mixed_spread", "outer", "product", "spread"]

Matrix = functions.Vector
"""Three rows, each a vector of three scalars of any kind."""


class Kinetics(Parametric):
    """The rate of a body along its principal axes, by constants that need no division on the way.

    Parameters
    ----------
    reciprocals : array (3,)
        1 / I.
    twists : array (3,)
        (I2 - I3) / (I2 I3) and its cyclic permutations: g x omega = (twist1 g2 g3, twist2 g3 g1, ...).
    """

    reciprocals: Vector
    twists: Vector

    @classmethod
    def of(cls, moments: ArrayLike, member_axis: tuple[int, ...] = ()) -> Kinetics:
        """Return the kinetics of principal moments, scalars of any kind, or of the moments of members."""
        a, b, c = components(moments)
        return cls.unchecked(
            reciprocals=assemble([1 / a, 1 / b, 1 / c], moments),
            twists=assemble([(b - c) / (b * c), (c - a) / (c * a), (a - b) / (a * b)], moments),
            member_axis=member_axis,
        )

    @of_arrays(native=True, g=(3,))
    def omega(self, g: ArrayLike) -> Array:
        """Return the angular velocity I^-1 g; shape (..., 3)."""
        return quat.component_product(g, self.reciprocals)

    @of_arrays(native=True, g=(3,))
    def half_omega(self, g: ArrayLike) -> Array:
        """Return omega / 2, which turns a quaternion: q' = q (0, omega/2); shape (..., 3)."""
        halves = assemble([0.5 * reciprocal for reciprocal in components(self.reciprocals)], self.reciprocals)
        return quat.component_product(g, halves)

    @of_arrays(native=True, g=(3,))
    def gyration(self, g: ArrayLike) -> Array:
        """Return g x omega, the change of g seen from the turning body; shape (..., 3)."""
        g1, g2, g3 = components(g)
        t1, t2, t3 = components(self.twists)
        return assemble([t1 * (g2 * g3), t2 * (g3 * g1), t3 * (g1 * g2)], g)

    @of_arrays(native=True, g=(3,))
    def kinetic_energy(self, g: ArrayLike) -> Scalar:
        """Return g . omega / 2, eq. (9); shape (...)."""
        energy: Scalar = 0.5 * quat.dot(g, self.omega(g))
        return energy


class ObliqueKinetics(Kinetics):
    """The same for body axes that are not principal; `axes` has the principal axes as its columns.

    The axes are orthogonal but for rounding. Neither |g| nor the energy depends on that where I^-1 is symmetric to the
    last bit and the gyration is the vector product: along principal axes both would drift in one direction.
    """

    axes: Annotated[Any, (3, 3)]

    @override
    def omega(self, g: ArrayLike) -> Array:
        return turned(self._inverse(components(self.reciprocals)), g)

    @override
    def half_omega(self, g: ArrayLike) -> Array:
        return turned(self._inverse([0.5 * reciprocal for reciprocal in components(self.reciprocals)]), g)

    @override
    def gyration(self, g: ArrayLike) -> Array:
        return assemble(functions.cross(components(g), components(self.omega(g))), g)

    def _inverse(self, reciprocals: Iterable[Scalar]) -> list[list[Scalar]]:
        """Return axes diag(reciprocals) axes^T, symmetric to the last bit."""
        entries: dict[tuple[int, int], Scalar] = {}
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            products = [x * y for x, y in zip(self.axes[i], self.axes[j], strict=True)]
            entries[i, j] = entries[j, i] = functions.dot(products, reciprocals)
        return [[entries[i, j] for j in range(3)] for i in range(3)]


class CompositeKinetics:
    """The rate of a body with parts, omega = K (g - h), for a symmetric K^-1 on scalars of any kind.

    K^-1 = L D L^T is factorised here; where its entries are parameters of a run, that is done once. g, h and K^-1 are
    multiplied by `scale`.
    """

    def __init__(self, inverse: Matrix, momentum: functions.Vector, scale: Scalar = 1) -> None:
        (a, _, _), (b, c, _), (d, e, f) = inverse
        self._l21, self._l31 = b / a, d / a
        rest, below = c - self._l21 * b, e - self._l31 * b
        self._l32 = below / rest
        last = f - self._l31 * d - self._l32 * below
        self._reciprocals = tuple(1 / (scale * pivot) for pivot in (a, rest, last))
        self.momentum = scale * momentum

    def omega(self, g: ArrayLike) -> Array:
        """Return the angular velocity K (g - h); shape (..., 3)."""
        x, y, z = functions.Vector(components(g)) - self.momentum
        y = y - self._l21 * x
        z = z - self._l31 * x - self._l32 * y
        a, b, c = self._reciprocals
        z = c * z
        y = b * y - self._l32 * z
        return assemble([a * x - self._l21 * y - self._l31 * z, y, z], g)

    def half_omega(self, g: ArrayLike) -> Array:
        """Return omega / 2, which turns a quaternion: q' = q (0, omega/2); shape (..., 3)."""
        return assemble([0.5 * component for component in components(self.omega(g))], g)

    def kinetic_energy(self, g: ArrayLike) -> Scalar:
        """Return (g - h) . omega / 2, without the internal energies of the parts; shape (...)."""
        return 0.5 * functions.dot(functions.Vector(components(g)) - self.momentum, components(self.omega(g)))


def product(matrix: Matrix, vector: Iterable[Scalar]) -> functions.Vector:
    """Return the product of a matrix and a vector."""
    x = tuple(vector)
    return functions.Vector(functions.dot(row, x) for row in matrix)


def outer(u: Iterable[Scalar], v: Iterable[Scalar]) -> functions.Vector:
    """Return the matrix u v^T."""
    v = functions.Vector(v)
    return functions.Vector(x * v for x in u)


def spread(arm: Iterable[Scalar]) -> functions.Vector:
    """Return |x|^2 1 - x x^T, the inertia tensor of a unit mass at x."""
    arm = functions.Vector(arm)
    square, products = functions.dot(arm, arm), outer(arm, arm)
    return functions.Vector(
        functions.Vector((square if i == j else 0.0) - products[i][j] for j in range(3)) for i in range(3)
    )


def mixed_spread(a: functions.Vector, b: functions.Vector) -> functions.Vector:
    """Return 2 a.b 1 - (a b^T + b a^T), the part of spread(a + x b) that is linear in x."""
    between, along = outer(a, b) + outer(b, a), 2 * functions.dot(a, b)
    return functions.Vector(
        functions.Vector((along if i == j else 0.0) - between[i][j] for j in range(3)) for i in range(3)
    )


def turned(matrix: Sequence[Sequence[Scalar]] | Array, vector: ArrayLike) -> Array:
    """Return the product of a (3, 3) matrix and vectors, scalars of any kind; shape (..., 3)."""
    x = components(vector)
    return assemble([functions.dot(matrix[i], x) for i in range(3)], vector)
