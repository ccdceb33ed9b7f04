"""Attitudes: unit quaternions, rotation matrices, scipy rotations, and the rates between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.quaternion import components
from poinsot.checked import checked
from poinsot.errors import member_array, real_numbers
from poinsot.functions import Scalar, Vector
from poinsot.immutable import Immutable, cached_property
from poinsot.quantities import Array, Rule

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "Attitude",
    "UnitQuaternion",
    "omega_body",
    "omega_space",
    "paper_matrix",
    "quaternion_from_matrix",
    "rotation_angle",
    "rotation_matrix",
    "unit_quaternion",
]

NORM_TOLERANCE = 1e-9
"""Largest difference of |q| from 1 in an argument."""


def rotation_matrix(q: ArrayLike) -> Array:
    """Return the active matrix A, x_space = A x_body; shape (..., 4) -> (..., 3, 3).

    Its columns are the body axes in space. For |q| = 1 it is a rotation, otherwise |q|^2 times one.
    """
    q0, q1, q2, q3 = components(q)
    s0, s1, s2, s3 = q0 * q0, q1 * q1, q2 * q2, q3 * q3
    rows = (
        (s0 + s1 - s2 - s3, 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)),
        (2 * (q1 * q2 + q0 * q3), s0 - s1 + s2 - s3, 2 * (q2 * q3 - q0 * q1)),
        (2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), s0 - s1 - s2 + s3),
    )
    if isinstance(q, functions.Vector):
        return matrix_of(rows)
    return np.stack([np.stack(np.broadcast_arrays(*map(np.asarray, row)), axis=-1) for row in rows], axis=-2)


def paper_matrix(q: ArrayLike) -> Array:
    """Return the matrix R that the paper prints, x_body = R x_space: the transpose of the active one (E2)."""
    return np.swapaxes(rotation_matrix(q), -1, -2)


def quaternion_from_matrix(matrix: ArrayLike) -> NDArray[np.float64]:
    """Return the unit quaternion of an active rotation matrix; shape (..., 3, 3) -> (..., 4).

    The largest component is taken from the diagonal, and is positive; the others from the off-diagonal
    sums and differences, so that no digits are lost at any angle (the paper's diagonal relations alone
    leave the signs open, erratum E13).

    Raises
    ------
    ValueError
        If the matrix is not a rotation to 1e-9.
    """
    A = real_numbers("matrix", matrix)
    if A.shape[-2:] != (3, 3):
        raise ValueError(f"matrix must have shape (..., 3, 3), got shape {A.shape}.")
    defect = np.max(np.abs(A @ np.swapaxes(A, -1, -2) - np.eye(3)), initial=0.0)
    if not defect <= NORM_TOLERANCE or np.any(np.linalg.det(A) < 0):
        raise ValueError(
            "matrix must be a rotation (orthogonal, determinant +1), but "
            + (f"A A^T differs from 1 by {defect:.2g}." if not defect <= NORM_TOLERANCE else "its determinant is -1.")
        )
    d1, d2, d3 = A[..., 0, 0], A[..., 1, 1], A[..., 2, 2]
    s1, s2, s3 = A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]
    t1, t2, t3 = A[..., 2, 1] + A[..., 1, 2], A[..., 0, 2] + A[..., 2, 0], A[..., 1, 0] + A[..., 0, 1]
    # Row k is 4 q_k (q0, q1, q2, q3): four ways to the same quaternion.
    ways = np.stack(
        [
            np.stack([1 + d1 + d2 + d3, s1, s2, s3], axis=-1),
            np.stack([s1, 1 + d1 - d2 - d3, t3, t2], axis=-1),
            np.stack([s2, t3, 1 - d1 + d2 - d3, t1], axis=-1),
            np.stack([s3, t2, t1, 1 - d1 - d2 + d3], axis=-1),
        ],
        axis=-2,
    )
    largest = np.argmax(np.diagonal(ways, axis1=-2, axis2=-1), axis=-1)
    best = np.take_along_axis(ways, largest[..., None, None], axis=-2)[..., 0, :]
    return np.asarray(best / np.linalg.norm(best, axis=-1, keepdims=True))


def unit_quaternion(attitude: Rotation | ArrayLike, name: str = "attitude") -> NDArray[np.float64]:
    """Return the quaternion of a scipy `Rotation`, or the given unit quaternion, scalar first.

    Raises
    ------
    ValueError
        If a quaternion is off the unit sphere by more than 1e-9. It is never normalised.
    """
    if hasattr(attitude, "as_quat"):
        return np.asarray(attitude.as_quat(scalar_first=True), dtype=float)
    q = real_numbers(name, attitude)
    if q.shape[-2:] == (3, 3):
        raise ValueError(
            f"{name} must be a quaternion or a Rotation, got a matrix. Write Rotation.from_matrix(matrix)."
        )
    q = member_array(name, q, (4,))
    norms = np.atleast_1d(np.linalg.norm(q, axis=-1))
    worst = norms[np.argmax(np.abs(norms - 1))]
    if abs(worst - 1) > NORM_TOLERANCE:
        raise ValueError(f"{name} must have unit norm, but |q| = {worst:.10g}. Divide by the norm, or pass a Rotation.")
    return q


def _refuse_other_norm(name: str, value: Any, _: str) -> None:
    unit_quaternion(value, name)


UnitQuaternion = Annotated[Any, (4,), Rule(_refuse_other_norm)]
"""Annotation of a parameter that is a unit quaternion, scalar first."""


def rotation(q: ArrayLike) -> Rotation:
    """Return the scipy `Rotation` body -> space of unit quaternions, shape (4,) or (n, 4)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(np.asarray(q), scalar_first=True)


def rotation_angle(q: ArrayLike, other: ArrayLike) -> Array:
    """Return the angle in [0, pi] of the rotation between two attitudes; q and -q are the same."""
    difference = quat.product(quat.conjugate(q), other)
    angle: Array = 2 * np.arctan2(np.linalg.norm(difference[..., 1:], axis=-1), np.abs(difference[..., 0]))
    return angle


def omega_body(q: ArrayLike, q_dot: ArrayLike) -> Array:
    """Return the angular velocity 2 q~ q' in body axes (Prop. 2, eq. (4)); radians per unit of time."""
    return quat.imaginary(2 * quat.product(quat.conjugate(q), q_dot))


def omega_space(q: ArrayLike, q_dot: ArrayLike) -> Array:
    """Return the angular velocity 2 q' q~ in space axes (Prop. 1); radians per unit of time."""
    return quat.imaginary(2 * quat.product(q_dot, quat.conjugate(q)))


class Attitude(Immutable):
    """Attitude of a body in a formula, which transforms vectors between space and body axes.

    Parameters
    ----------
    matrix : array (3, 3) of scalars or None
        Active rotation matrix A, x_space = A x_body. None: the matrix follows from the quaternion.
    comoving : bool
        True if the attitude is relative to moving axes. Formulas then receive vectors of the environment along these
        axes.
    quaternion : four scalars, optional
        Unit quaternion body -> space of the same attitude, scalar first.

    Examples
    --------
    >>> quarter = pt.Attitude.from_quaternion((0.5**0.5, 0, 0, 0.5**0.5))  # about the third axis
    >>> [round(float(x), 3) for x in quarter.to_body((1, 0, 0))]
    [0.0, -1.0, 0.0]
    """

    def __init__(self, matrix: Array | None, comoving: bool = False, quaternion: Any = None) -> None:
        self.comoving, self._quaternion = comoving, quaternion
        if matrix is not None:
            self._matrix = matrix

    @cached_property
    def _matrix(self) -> Array:
        """Rotation matrix of the quaternion, computed at first use."""
        return rotation_matrix(self._quaternion)

    @property
    def components(self) -> Iterable[Scalar]:
        """Four components of the quaternion, or nine of the matrix if the attitude was made without a quaternion."""
        return self._matrix.flat if self._quaternion is None else self._quaternion

    turn: Sequence[Scalar] = (0.0, 0.0, 0.0)
    """Angles of a small turn of `at_rest` about the body axes, which are zero: by which derivatives are taken."""

    @property
    def at_rest(self) -> Attitude:
        """The same attitude, which does not vary with its `turn`."""
        return self

    def seen_from(self, other: Attitude) -> tuple[list[Vector], Vector]:
        """Return the axes of this body along those of another one, and the angles of a small turn about the latter.

        The axes do not vary with the angles, which are zero: a closed rule gives the derivatives of what is turned.
        """
        axes = [other.at_rest.to_body(axis) for axis in self.at_rest.matrix.T]
        rows = zip(*axes, strict=True)
        return axes, Vector(functions.dot(row, self.turn) - own for row, own in zip(rows, other.turn, strict=True))

    @property
    def matrix(self) -> Array:
        """Active rotation matrix A of x_space = A x_body, (3, 3) scalars."""
        matrix: Array = self._along_space(self._matrix)
        return matrix

    @property
    def quaternion(self) -> Any:
        """Unit quaternion body -> space, four scalars, scalar first."""
        if self._quaternion is None:
            raise ValueError(
                "attitude must have its quaternion for a formula that reads it, got its matrix alone. "
                "Make it by Attitude.from_quaternion."
            )
        return self._along_space(self._quaternion)

    def _along_space(self, components: Any) -> Any:
        if self.comoving:
            raise functions.NotComoving
        return components

    @classmethod
    @checked
    def from_quaternion(cls, q: Iterable[Scalar], comoving: bool = False) -> Attitude:
        """Return the attitude of a unit quaternion body -> space, four scalars, scalar first.

        All entries of the matrix are of second degree in q. A potential and its torque therefore remain consistent
        where rounding has moved q off the unit sphere, and the integration conserves the energy.
        """
        return cls(None, comoving, functions.Vector(q))

    def turned(self, quaternion: Vector) -> Attitude:
        """Return the attitude after a further rotation by a unit quaternion, given along the body axes."""
        own = None if self._quaternion is None else quat.product(Vector(self._quaternion), quaternion)
        return Attitude(self._matrix @ rotation_matrix(quaternion), self.comoving, own)

    def to_body(self, vector: Iterable[Scalar]) -> Vector:
        """Return the components of a vector along the body axes, from its components along the space axes."""
        if self.comoving and not isinstance(vector, functions.ComovingVector):
            raise functions.NotComoving
        x = vector.components if isinstance(vector, functions.ComovingVector) else functions.Vector(vector)
        return functions.Vector(functions.dot(self._matrix[:, i], x) for i in range(3))

    def to_space(self, vector: Iterable[Scalar]) -> Vector:
        """Return the components of a vector along the space axes, from its components along the body axes."""
        x = functions.Vector(vector)
        return self._in_space(functions.dot(self._matrix[i], x) for i in range(3))

    def _in_space(self, scalars: Iterable[Scalar]) -> Vector:
        """Return three scalars as a vector in space."""
        return functions.ComovingVector(scalars) if self.comoving else functions.Vector(scalars)


def matrix_of(rows: Iterable[Iterable[Scalar]]) -> Array:
    """Return rows of scalars as an object array of shape (3, 3), whatever the scalars are."""
    out = np.empty((3, 3), dtype=object)
    for i, row in enumerate(rows):
        for j, scalar in enumerate(row):
            out[i, j] = scalar
    return out
