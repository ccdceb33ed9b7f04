"""Torque of light or air on a mesh as a smooth function of the direction to its source."""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
from typing_extensions import override

from poinsot.algebra.solid_harmonics import SolidHarmonics
from poinsot.checked import checked
from poinsot.errors import real_array
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.gravity_field import norms, whole_degree
from poinsot.quantities import Array
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative, Parametric
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.surface import Surface
from poinsot.shapes.visibility import clear_faces

__all__ = ["DirectionalTorque", "stream_torques"]

MAX_DEGREE = 32
"""Highest degree of the expansion, which has 3267 coefficients in three components."""

MIN_COEFFICIENT = 1e-14
"""Coefficients below this fraction of the mesh area times the radius are set to zero."""

MAX_PAIRS = 4_000_000
"""Largest number of pairs of a direction and a face in one block, which limits memory."""


class DirectionalTorque(Parametric):
    """Torque of a parallel stream of unit pressure on a body, as a smooth function of the stream's direction.

    T(u) = sum_(n <= degree) sum_(m = -n ... n) c_nm Y_nm(u). The unit vector u points towards the source of the stream.
    The coefficients c_nm are vectors along the body axes. Y_nm is the real harmonic with mean square 1 over the sphere,
    with cos(m longitude) for m >= 0 and sin(|m| longitude) for m < 0.

    Parameters
    ----------
    degree : int
        Highest degree of the series, at least 0.
    coefficients : array (3, (degree + 1)^2)
        Coefficients along the body axes, in length^3. Column n^2 + n + m contains c_nm.
    maximum_error, rms_error : float
        Largest and root-mean-square residual of the series, in length^3, over directions that were not used in the fit.
        They document a fit and do not affect the torque.

    Raises
    ------
    ValueError
        If the degree or an error is negative.

    Examples
    --------
    >>> field = pt.forces.DirectionalTorque(1, [(0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0.5, 0)])
    >>> [float(x) for x in field.torque((0, 0.6, 0.8))]
    [0.0, 0.0, 0.6928203230275509]
    """

    degree: int
    coefficients: Annotated[Any, (3, "terms")]
    maximum_error: NotNegative = 0.0
    rms_error: NotNegative = 0.0

    @override
    def __post_init__(self) -> None:
        if isinstance(self.degree, int) and self.degree < 0:
            raise ValueError(f"degree must not be negative, got {self.degree}.")
        super().__post_init__()

    @property
    def terms(self) -> int:
        """Number of harmonics, (degree + 1)^2."""
        return (self.degree + 1) ** 2

    @of_scalars
    def torque(self, direction: Any) -> Vector:
        """Return the torque of unit pressure for a unit vector along the body axes, three scalars of any kind."""
        harmonics, factors = SolidHarmonics(direction, squared=1), norms(self.degree)
        return Vector(self._component(harmonics, factors, row) for row in self.coefficients)

    def _component(self, harmonics: SolidHarmonics, factors: Array, row: Any) -> Scalar:
        total: Scalar = 0.0
        for n in range(self.degree + 1):
            zero = n * n + n
            pairs = [(row[zero + m], row[zero - m] if m else 0.0) for m in range(n + 1)]
            total = total + harmonics.sum([(c * f, s * f) for (c, s), f in zip(pairs, factors[n], strict=False)])
        return total

    @classmethod
    @checked
    def of_emission(cls, mesh: Mesh, degree: int, *, shadows: bool = True) -> Self:
        """Fit the torque of light that a mesh emits at once and diffusely: YORP without thermal inertia.

        T(u) = -2/3 sum of A (n.u) r x n over the illuminated faces (Rubincam 2000, Icarus 148, 2), with r from the
        centre of mass to the centroid of a face.

        Parameters
        ----------
        mesh : Mesh
            Surface of the body. The axes of the mesh are the body axes.
        degree : int
            Degree of the series, from 0 to 32.
        shadows : bool
            True if a face is dark when another face shadows its centroid.

        Returns
        -------
        DirectionalTorque
            The fitted series with its errors.
        """
        return cls._fitted(mesh, degree, shadows, (0.0, 1.0, 0.0))

    @classmethod
    @checked
    def of_stream(
        cls, mesh: Mesh, degree: int, *, specular: float = 0.0, diffuse: float = 0.0, shadows: bool = True
    ) -> Self:
        """Fit the torque of light that a mesh absorbs and reflects, or of a fast, thin gas.

        T(u) = -sum of A c r x [(1 - s) u + 2 (d/3 + s c) n] over the illuminated faces, with c = n.u. Light that is
        absorbed and radiated at once counts as diffuse. For a gas, use s = d = 0: T times density times speed squared
        is then the torque of fully accommodated molecules, with a drag coefficient of 2.

        Parameters
        ----------
        mesh : Mesh
            Surface of the body. The axes of the mesh are the body axes.
        degree : int
            Degree of the series, from 0 to 32.
        specular, diffuse : float
            Fractions s and d of the light that are reflected specularly and diffusely; not negative, and at most 1 in
            total.
        shadows : bool
            True if a face is dark when another face shadows its centroid.

        Returns
        -------
        DirectionalTorque
            The fitted series with its errors.
        """
        s, d = (float(real_array(*share, ())) for share in (("specular", specular), ("diffuse", diffuse)))
        if s < 0 or d < 0 or s + d > 1:
            raise ValueError(
                "specular and diffuse must not be negative and at most 1 together, "
                f"got {s:g} and {d:g}. The rest is absorbed."
            )
        return cls._fitted(mesh, degree, shadows, (1 - s, d, s))

    @classmethod
    def _fitted(cls, mesh: Mesh, degree: int, shadows: bool, shares: tuple[float, float, float]) -> Self:
        """Return the projection on harmonics, by a quadrature that is exact to degree 4 n + 3."""
        degree = whole_degree(degree)
        if not 0 <= degree <= MAX_DEGREE:
            raise ValueError(f"degree must be from 0 to {MAX_DEGREE}, got {degree}.")
        light = Surface(mesh)
        directions, weights = sphere_nodes(2 * (degree + 1))
        torques = stream_torques(light, directions, shadows, *shares)
        coefficients = (weights[:, None] * torques).T @ _harmonics(degree, directions)
        coefficients[np.abs(coefficients) < MIN_COEFFICIENT * light.areas.sum() * mesh.circumscribing_radius] = 0.0
        others = _spiral(4 * (degree + 1) ** 2 + 100)
        left = stream_torques(light, others, shadows, *shares) - _harmonics(degree, others) @ coefficients.T
        lengths = np.linalg.norm(left, axis=-1)
        return cls(degree, coefficients, float(lengths.max()), float(np.sqrt(np.mean(lengths**2))))


def stream_torques(
    light: Surface, directions: Array, shadows: bool, along: float, diffuse: float, specular: float
) -> Array:
    """Return the torques (n, 3) of unit pressure from unit vectors (n, 3), by sums over all faces.

    Parameters
    ----------
    along, diffuse, specular : float
        Shares of the light that press along the stream, are emitted diffusely, and are reflected specularly.
    """
    torques, turns = np.empty_like(directions), np.cross(light.centers, light.normals)
    rows = max(1, MAX_PAIRS // len(light.areas))
    for start in range(0, len(directions), rows):
        u = directions[start : start + rows]
        cosines = u @ light.normals.T
        caught = light.areas * cosines * clear_faces(light, [u], shadows=shadows)
        pushed = along * np.cross(caught @ light.centers, u)
        torques[start : start + rows] = -pushed - (2 / 3 * diffuse * caught + 2 * specular * caught * cosines) @ turns
    return torques


def sphere_nodes(rows: int) -> tuple[Array, Array]:
    """Return unit vectors (n, 3) and weights, of sum 1, of a mean over the sphere: exact to degree 2 rows - 1."""
    heights, weights = np.polynomial.legendre.leggauss(rows)
    longitudes = np.pi * (np.arange(2 * rows) + 0.5) / rows
    across = np.sqrt(1 - heights**2)[:, None]
    x, y = across * np.cos(longitudes), across * np.sin(longitudes)
    places = np.stack([x, y, np.broadcast_to(heights[:, None], x.shape)], axis=-1)
    return places.reshape(-1, 3), np.repeat(weights / (4 * rows), 2 * rows)


def _spiral(count: int) -> Array:
    """Return unit vectors, about evenly over the sphere."""
    heights = 1 - (2 * np.arange(count) + 1) / count
    turns = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - heights**2)
    return np.stack([across * np.cos(turns), across * np.sin(turns), heights], axis=-1)


def _harmonics(degree: int, directions: Array) -> Array:
    """Return the normalised harmonics of unit vectors (n, 3), one column for each coefficient."""
    harmonics, factors = SolidHarmonics(tuple(directions.T), squared=1), norms(degree)
    values = np.empty((len(directions), (degree + 1) ** 2))
    for n in range(degree + 1):
        for m in range(n + 1):
            real, imaginary = harmonics.pair(n, m)
            values[:, n * n + n - m] = factors[n, m] * imaginary
            values[:, n * n + n + m] = factors[n, m] * real
    return values
