"""The gravity field of a body in spherical harmonics along its own axes."""

from __future__ import annotations

import operator
from typing import Annotated, Any

import numpy as np

from poinsot.checked import checked
from poinsot.errors import member_array, real_numbers, refuse_negative
from poinsot.functions import Scalar
from poinsot.printable import kind_of, quoted
from poinsot.quantities import Array, Real, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Matrix, Parametric, Positive

__all__ = ["GravityField", "norms", "whole_degree"]

C00_TOLERANCE = 1e-9
"""Largest difference of C_00 from 1: some tables define it as a ratio of two constants."""


class GravityField(Parametric):
    """Gravity field of a body about its centre of mass, as unnormalised spherical harmonic coefficients.

    V = G M / r sum_n (radius / r)^n sum_m P_nm(sin latitude) (C_nm cos(m longitude) + S_nm sin(m longitude)), with P_nm
    without the sign (-1)^m, and longitude and latitude along the body axes. The term of degree 0 is 1 and the terms of
    degree 1 are 0.

    Parameters
    ----------
    degree : int
        Largest degree n, at least 2.
    mass : float
        Mass M of the body in the user's unit; 1 if moments of inertia are divided by M R^2.
    radius : float
        Reference radius of the coefficients.
    C, S : array (degree + 1, degree + 1)
        Coefficients, with degrees n as rows and orders m as columns. C_00 is 1 or 0, and S_n0 is 0. Entries above the
        diagonal are ignored.
    extent : float, optional
        Radius of a sphere about the centre of mass that contains the body, preferably the smallest one. The series need
        not converge inside it, and a run counts the times at which an attractor is inside. 0 means unknown: nothing is
        counted.

    Raises
    ------
    ValueError
        If the degree is below 2, mass or radius is not positive, the extent is negative, C_00 is neither 1 nor 0, or
        S_n0 or a coefficient of degree 1 is not zero.

    Examples
    --------
    >>> field = pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).field(degree=4)
    >>> round(float(field.C[2, 0]), 4)
    -0.1222
    """

    degree: int
    mass: Positive
    radius: Positive
    C: Annotated[Any, ("orders", "orders")]
    S: Annotated[Any, ("orders", "orders")]
    extent: Annotated[Real, Rule(refuse_negative, "0 means unknown.")] = 0.0

    def __post_init__(self) -> None:
        if isinstance(self.degree, int) and self.degree < 2:
            raise ValueError(f"degree must be at least 2, got {self.degree}.")
        super().__post_init__()
        first = np.ravel(self.C[..., 0, 0])
        wrong = first[(np.abs(first - 1) > C00_TOLERANCE) & (first != 0)]
        if wrong.size:
            raise ValueError(f"C_00 must be 1, or 0 where it is left out, got {wrong[0]:g}.")
        zonal = np.argwhere(self.S[..., 0])
        if zonal.size:
            raise ValueError(f"S must be zero in order 0, but S_{zonal[0, -1]}0 is not.")
        if np.any(self.C[..., 1, :2]) or np.any(self.S[..., 1, 1]):
            raise ValueError("C and S must be zero in degree 1, but they are not. Refer them to the centre of mass.")

    @property
    def orders(self) -> int:
        """The number of orders, degree + 1."""
        return self.degree + 1

    @of_scalars
    def row(self, n: int) -> list[tuple[Scalar, Scalar]]:
        """Return the pairs (C_nm, S_nm) of one degree, m = 0 ... n."""
        return [(self.C[n, m], self.S[n, m]) for m in range(n + 1)]

    @of_scalars
    def power(self, n: int) -> Scalar:
        """Return the mean square of the terms of a degree at unit distance, relative to the mean square of degree 0."""
        squares = sum((c * c + s * s) / norm**2 for (c, s), norm in zip(self.row(n), norms(n)[n], strict=True))
        value: Scalar = self.radius ** (2 * n) * squares
        return value

    @classmethod
    @checked
    def from_normalized(cls, mass: Real, radius: Real, C: Matrix, S: Matrix, extent: Real = 0.0) -> GravityField:
        """Return the field with fully normalised coefficients, the convention of most tables.

        Every argument may have members. A coefficient C_nm is sqrt((2 - [m = 0]) (2 n + 1) (n - m)! / (n + m)!) times
        the fully normalised coefficient.
        """
        rows = (real_numbers("C", C).shape or (0,))[-1]
        c, s = (member_array(name, value, (rows, rows)) for name, value in (("C", C), ("S", S)))
        factors = norms(rows - 1)
        fields: Any = (rows - 1, mass, radius, c * factors, s * factors, extent)
        return cls(*fields)

    @property
    def normalized(self) -> tuple[Array, Array]:
        """Fully normalised coefficients C and S."""
        factors = norms(self.degree)
        return np.divide(self.C, factors), np.divide(self.S, factors)

    @checked
    def truncated(self, degree: int) -> GravityField:
        """Return the field up to a lower degree."""
        degree = whole_degree(degree)
        if not 2 <= degree <= self.degree:
            raise ValueError(f"degree must be from 2 to {self.degree}, the degree of the field, got {degree}.")
        degrees = slice(degree + 1)
        C, S = self.C[..., degrees, degrees], self.S[..., degrees, degrees]
        return GravityField(degree, self.mass, self.radius, C, S, self.extent)

    @property
    def inertia_deviator(self) -> Array:
        """Inertia tensor minus its mean, which a gravity field does not determine; shape (..., 3, 3).

        In units of mass radius^2, I11, I22 and I33 minus their mean are C20/3 - 2 C22, C20/3 + 2 C22 and -2/3 C20. The
        products are I12 = -2 S22, I13 = -C21 and I23 = -S21.
        """
        both = np.broadcast_arrays(self.C[..., 2, :3], self.S[..., 2, :3])
        (c20, c21, c22), (_, s21, s22) = (np.moveaxis(x, -1, 0) for x in both)
        rows = [(c20 / 3 - 2 * c22, -2 * s22, -c21), (-2 * s22, c20 / 3 + 2 * c22, -s21), (-c21, -s21, -2 * c20 / 3)]
        tensor = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        return np.asarray(np.asarray(self.mass * self.radius**2)[..., None, None] * tensor)


def whole_degree(degree: Any) -> int:
    """Return a degree as an int, or raise a TypeError."""
    try:
        if not isinstance(degree, bool):
            return operator.index(degree)
    except TypeError:
        pass
    raise TypeError(f"degree must be an int, got {kind_of(degree)} {quoted(degree)}.")


def norms(degree: int) -> Array:
    """Return the factors by which normalised coefficients become plain ones, 1 right of the diagonal."""
    factors = np.ones((degree + 1, degree + 1))
    for n in range(degree + 1):
        factors[n, 0] = np.sqrt(2 * n + 1)
        falling = 1.0
        for m in range(1, n + 1):
            falling /= (n - m + 1) * (n + m)
            factors[n, m] = np.sqrt(2 * (2 * n + 1) * falling)
    return factors
