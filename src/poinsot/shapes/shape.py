"""Interface of every shape: mass, centre of mass, inertia, gravity field, potential and attraction at a point."""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.display.html_text import formatted, text_table
from poinsot.errors import exactly_one, real_array, real_numbers, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.kinematics.attitude import rotation_matrix, unit_quaternion
from poinsot.mechanics.body import Body
from poinsot.mechanics.gravity_field import GravityField, norms, whole_degree
from poinsot.quantities import Along
from poinsot.records.parameters import Structural

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Shape"]

Array = NDArray[np.float64]

ShapePoints = Annotated[ArrayLike, ("n", 3), Along("axes of the shape")]
ShapeVector = Annotated[ArrayLike, (3,), Along("axes of the shape")]

MAX_DEGREE = 80
"""Largest degree of a field. Beyond it, coefficients that are not normalised leave the range of doubles."""


class Shape(Structural):
    """Mass distribution along its own axes and from its own origin; the base class of all shapes.

    Lengths and mass are in the user's units. Every tensor, field and vector is along the axes of the shape.

    Examples
    --------
    >>> ball = pt.shapes.Ellipsoid((2, 2, 2), mass=1.0).moved((1, 0, 0))
    >>> float(ball.potential((0, 0, 4)))
    0.25
    """

    # ------------------------------------------------------------------ the methods of each kind of shape

    _mass: float
    _center: Array

    @property
    def mass(self) -> float:
        """Mass of the shape."""
        return self._mass

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass relative to the origin of the shape, shape (3,)."""
        return self._center.copy()

    @property
    @abstractmethod
    def inertia(self) -> Array:
        """Inertia tensor about the centre of mass, shape (3, 3)."""

    @property
    @abstractmethod
    def circumscribing_radius(self) -> float:
        """Radius of the smallest sphere about the centre of mass that contains the shape; a bound for an `Assembly`."""

    @abstractmethod
    def support(self, direction: Iterable[Scalar]) -> Scalar:
        """Return the support function: the maximum of x . w over the points x of the shape from the centre of mass.

        Parameters
        ----------
        direction : three scalars, axes of the shape
            Vector w of any length: floats, arrays or nodes of a graph.
        """

    @property
    def ellipsoid_along_axes(self) -> Array | None:
        """Semiaxes of an ellipsoid along the axes, or None for other shapes."""
        return None

    @abstractmethod
    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        """Return the integrals of Z_nm((x - origin) / radius) over the mass, rows n, columns m <= n."""

    @abstractmethod
    def _gravity(self, points: Array) -> tuple[Array, Array]:
        """Return potential (n,) and attraction (n, 3) at points (n, 3) from the centre of mass."""

    @abstractmethod
    def _placed(self, position: Array, matrix: Array) -> Self:
        """Return the shape whose points are matrix x + position."""

    # ------------------------------------------------------------------ derived quantities

    def _repr_html_(self) -> str:
        return text_table(
            repr(self),
            {
                "mass": formatted(self.mass),
                "centre of mass": formatted(self.center_of_mass),
                "principal moments": formatted(np.linalg.eigvalsh(self.inertia)),
                "farthest from the centre of mass": formatted(self.circumscribing_radius),
            },
        )

    @property
    def definition(self) -> tuple[str, dict[str, Any]]:
        """Name of the constructor of the shape, and its arguments by name."""
        names = inspect.signature(type(self)).parameters
        return type(self).__name__, {name: getattr(self, name) for name in names if hasattr(self, name)}

    @property
    def principal_axes(self) -> Rotation:
        """Right-handed rotation principal axes -> axes of the shape, as near as possible to the identity."""
        return Body.from_inertia(self.inertia).principal_axes

    def moved(self, position: ArrayLike = (0, 0, 0), attitude: Rotation | ArrayLike = (1, 0, 0, 0)) -> Self:
        """Return the shape rotated about its origin, then shifted: x -> attitude x + position.

        Parameters
        ----------
        position : array (3,)
            New position of the origin.
        attitude : scipy Rotation or array (4,)
            Rotation about the origin. A quaternion is scalar first.
        """
        matrix = rotation_matrix(real_array("attitude", unit_quaternion(attitude), (4,)))
        return self._placed(real_array("position", position, (3,)), matrix)

    def in_principal_axes(self) -> Self:
        """Return the shape with its centre of mass at the origin and its principal axes along the axes."""
        to_principal = Body.from_inertia(self.inertia).principal_matrix.T
        return self._placed(-to_principal @ self.center_of_mass, to_principal)

    @checked
    def field(self, degree: int, radius: float | None = None) -> GravityField:
        """Return the gravity field about the centre of mass, exact except for rounding.

        C_nm + i S_nm = (2 - [m = 0]) (n - m)! / (n + m)! times the integral of Z_nm over the mass, divided by M R^n.

        Parameters
        ----------
        degree : int
            Largest degree, from 2 to 80.
        radius : float, optional
            Reference radius R of the coefficients. Default: the circumscribing radius, which is also the `extent` of
            the field. For an `Assembly` it is an upper bound.
        """
        degree = whole_degree(degree)
        if not 2 <= degree <= MAX_DEGREE:
            raise ValueError(f"degree must be from 2 to {MAX_DEGREE}, got {degree}.")
        length = self.circumscribing_radius if radius is None else float(real_array("radius", radius, ()))
        refuse_nonpositive("radius", length)
        integrals = self._multipoles(degree, self.center_of_mass, length) / self.mass
        coefficients = integrals * norms(degree) ** 2 / (2 * np.arange(degree + 1)[:, None] + 1)
        coefficients[:2] = np.array([[1], [0]]) * (np.arange(degree + 1) == 0)  # of the centre of mass
        C, S = coefficients.real, coefficients.imag
        return GravityField(degree, self.mass, length, C, S, extent=self.circumscribing_radius)

    def potential(self, points: ArrayLike) -> Array:
        """Return the integral of dm / distance at points (..., 3) relative to the centre of mass; shape (...).

        Times G it is the negative potential energy of a unit mass. The points may lie inside the body.

        Raises
        ------
        ValueError
            If the formula is singular at a point: on a point mass, or an edge of a mesh.
        """
        array, flat = _points(points)
        return np.reshape(self._pull(flat)[0], array.shape[:-1])

    def attraction(self, points: ArrayLike) -> Array:
        """Return the gradient of `potential`, which is the acceleration at points divided by G; shape (..., 3)."""
        array, flat = _points(points)
        return np.reshape(self._pull(flat)[1], array.shape)

    def _pull(self, points: Array) -> tuple[Array, Array]:
        potential, attraction = self._gravity(points)
        lost = np.flatnonzero(~np.isfinite(potential + attraction.sum(axis=-1)))
        if lost.size:
            x, y, z = points[lost[0]]
            raise ValueError(
                f"points must not lie on an edge or a mass point, but ({x:g}, {y:g}, {z:g}) does. "
                "The formula is singular there."
            )
        return potential, attraction


def _points(points: ArrayLike) -> tuple[Array, Array]:
    array = real_numbers("points", points)
    if array.shape[-1:] != (3,):
        raise ValueError(f"points must have shape (..., 3), got shape {array.shape}.")
    return array, array.reshape(-1, 3)


def mass_of(volume: float, mass: float | None, density: float | None) -> float:
    """Return the mass of a homogeneous solid of which exactly one of mass and density is given."""
    name, value = exactly_one("a solid", {"mass": mass, "density": density})
    number = float(real_array(name, value, ()))
    refuse_nonpositive(name, number)
    return number if name == "mass" else number * volume
