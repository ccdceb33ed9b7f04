"""How the angular momentum of a body becomes its angular velocity."""

from __future__ import annotations

from typing import Annotated, Any

from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.quaternion import Array, assemble, components
from poinsot.functions import Scalar
from poinsot.mechanics.parameters import Parametric, Vector

__all__ = ["Kinetics", "ObliqueKinetics"]


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
    def of(cls, moments: ArrayLike) -> Kinetics:
        """Return the kinetics of principal moments, scalars of any kind."""
        a, b, c = components(moments)
        return cls.unchecked(
            reciprocals=assemble([1 / a, 1 / b, 1 / c], moments),
            twists=assemble([(b - c) / (b * c), (c - a) / (c * a), (a - b) / (a * b)], moments),
        )

    def omega(self, g: ArrayLike) -> Array:
        """Return the angular velocity I^-1 g; shape (..., 3)."""
        return quat.component_product(g, self.reciprocals)

    def half_omega(self, g: ArrayLike) -> Array:
        """Return omega / 2, which turns a quaternion: q' = q (0, omega/2); shape (..., 3)."""
        return quat.component_product(g, [0.5 * reciprocal for reciprocal in components(self.reciprocals)])

    def gyration(self, g: ArrayLike) -> Array:
        """Return g x omega, the change of g seen from the turning body; shape (..., 3)."""
        g1, g2, g3 = components(g)
        t1, t2, t3 = components(self.twists)
        return assemble([t1 * (g2 * g3), t2 * (g3 * g1), t3 * (g1 * g2)], g)

    def kinetic_energy(self, g: ArrayLike) -> Scalar:
        """Return g . omega / 2, eq. (9); shape (...)."""
        return 0.5 * quat.dot(g, self.omega(g))


class ObliqueKinetics(Kinetics):
    """The same for body axes that are not principal; `axes` has the principal axes as its columns."""

    axes: Annotated[Any, (3, 3)]

    @override
    def omega(self, g: ArrayLike) -> Array:
        return turned(self.axes, super().omega(turned(self.axes.T, g)))

    @override
    def half_omega(self, g: ArrayLike) -> Array:
        return turned(self.axes, super().half_omega(turned(self.axes.T, g)))

    @override
    def gyration(self, g: ArrayLike) -> Array:
        return turned(self.axes, super().gyration(turned(self.axes.T, g)))


def turned(matrix: Array, vector: ArrayLike) -> Array:
    """Return the product of a (3, 3) matrix and vectors, scalars of any kind; shape (..., 3)."""
    x = components(vector)
    return assemble([functions.dot(matrix[i], x) for i in range(3)], vector)
