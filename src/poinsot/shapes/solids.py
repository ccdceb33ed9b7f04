"""Homogeneous solids with a centre and axes of symmetry: ellipsoid and cylinder."""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Iterable
from math import factorial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import real_array, real_numbers, refuse_nonpositive
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.body import Body
from poinsot.shapes import cubature
from poinsot.shapes.geodesic import geodesic_sphere
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.polyhedron import volume_and_center
from poinsot.shapes.shape import Shape, ShapeVector, mass_of

__all__ = ["Cylinder", "Ellipsoid"]

Array = NDArray[np.float64]


FEWEST_FACES = 20
"""Smallest number of faces of the mesh of an ellipsoid, an icosahedron."""


class Solid(Shape):
    """A homogeneous solid about a centre of symmetry, which `moved` carries along with its axes."""

    def __init__(self, volume: float, mass: float | None, density: float | None) -> None:
        refuse_nonpositive("volume", real_numbers("volume", volume))
        self.volume = volume
        self._mass = mass_of(volume, mass, density)
        self._center, self._axes = np.zeros(3), np.eye(3)

    @property
    def inertia(self) -> Array:
        return np.asarray(self._axes @ self._own_body().inertia @ self._axes.T)

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        name, arguments = super().definition
        return name, {**arguments, "position": self._center, "matrix": self._axes}

    @abstractmethod
    def _own_body(self) -> Body:
        """Return the body about the centre, along the axes of symmetry."""

    @abstractmethod
    def _own_support(self, direction: Vector) -> Scalar:
        """Return the support function for a vector along the axes of symmetry."""

    @override
    def support(self, direction: Iterable[Scalar]) -> Scalar:
        w = tuple(direction)
        return self._own_support(Vector(functions.dot(axis, w) for axis in self._axes.T))

    @abstractmethod
    def _own_rule(self, degree: int) -> tuple[Array, Array]:
        """Return weights (k,) of sum 1 and points (k, 3) about the centre: means exact to the degree."""

    @abstractmethod
    def _own_gravity(self, points: Array) -> tuple[Array, Array]:
        """Return potential and attraction at points from the centre along the axes of symmetry."""

    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        weights, points = self._own_rule(degree)
        places = points @ self._axes.T + self._center
        return cubature.multipoles(self.mass * weights, (places - origin) / radius, degree)

    def _gravity(self, points: Array) -> tuple[Array, Array]:
        potential, attraction = self._own_gravity(points @ self._axes)
        return potential, attraction @ self._axes.T

    def _placed(self, position: Array, matrix: Array) -> Self:
        moved = copy.copy(self)
        moved._center, moved._axes = matrix @ self._center + position, matrix @ self._axes
        return moved


class Ellipsoid(Solid):
    """Homogeneous ellipsoid about the origin with semiaxes along the axes; a sphere has three equal semiaxes.

    Potential and attraction, inside and outside, are Carlson's symmetric elliptic integrals.

    Parameters
    ----------
    semiaxes : array (3,), axes of the shape
        Semiaxes a, b, c, in any order.
    mass, density : float
        Mass or density; exactly one of the two.

    Raises
    ------
    ValueError
        If a number is not positive, or not exactly one of mass and density is given.

    Examples
    --------
    >>> pt.Body.from_shape(pt.shapes.Ellipsoid((3, 2, 1), mass=5.0))
    Body(moments=[5.0, 10.0, 13.0])
    """

    def __init__(self, semiaxes: ShapeVector, *, mass: float | None = None, density: float | None = None) -> None:
        self.semiaxes = real_array("semiaxes", semiaxes, (3,))
        refuse_nonpositive("semiaxes", self.semiaxes)
        self.semiaxes.flags.writeable = False
        with np.errstate(over="ignore"):
            volume = 4 / 3 * np.pi * float(np.prod(self.semiaxes))
        super().__init__(volume, mass, density)

    def __repr__(self) -> str:
        return f"Ellipsoid({self.semiaxes.tolist()}, mass={self.mass:g})"

    @property
    @override
    def circumscribing_radius(self) -> float:
        return float(self.semiaxes.max())

    @override
    def _own_support(self, direction: Vector) -> Scalar:
        return functions.norm(Vector(a * x for a, x in zip(self.semiaxes, direction, strict=True)))

    @property
    @override
    def ellipsoid_along_axes(self) -> Array | None:
        along = np.array_equal(self._axes, np.eye(3)) or np.ptp(self.semiaxes) == 0
        return self.semiaxes if along else None

    @property
    def to_unit_sphere(self) -> Array:
        """Linear map from vectors along the axes of the shape to vectors of the unit sphere, shape (3, 3)."""
        return np.asarray((self._axes / self.semiaxes).T)

    @checked
    def mesh(self, faces: int = 1280) -> Mesh:
        """Return a mesh of triangles with the mass and the volume of the ellipsoid.

        The vertices lie on a slightly larger, similar ellipsoid. For semiaxes 3 : 2 : 1 the areas of the faces differ
        by a factor of up to 2.5, and the moments of inertia differ from the moments of the ellipsoid by 3.5 / faces.

        Parameters
        ----------
        faces : int
            Number of faces; the nearest number 20 k^2 with a whole k is used.

        Returns
        -------
        Mesh
            Closed mesh about the centre of the ellipsoid, along its axes.

        Raises
        ------
        ValueError
            If faces is below 20.

        Examples
        --------
        >>> pt.shapes.Ellipsoid((3, 2, 1), mass=5.0).mesh(300)
        Mesh(162 vertices, 320 faces, mass=5)
        """
        if faces < FEWEST_FACES:
            raise ValueError(f"faces must be at least {FEWEST_FACES}, got {faces}.")
        points, triangles = geodesic_sphere(faces)
        points = points / np.cbrt(self.semiaxes)
        points *= self.semiaxes / np.linalg.norm(points, axis=1, keepdims=True)
        volume, _ = volume_and_center(points, triangles)
        vertices = points * np.cbrt(self.volume / volume) @ self._axes.T + self._center
        return Mesh(vertices, triangles, mass=self.mass)

    def _own_body(self) -> Body:
        return Body.from_ellipsoid(self.mass, self.semiaxes)

    def _own_rule(self, degree: int) -> tuple[Array, Array]:
        weights, points = cubature.ball(degree)
        return weights, points * self.semiaxes

    def _multipoles(self, degree: int, origin: Array, radius: float) -> NDArray[np.complex128]:
        if not np.array_equal(self._axes, np.eye(3)) or np.any(origin != self._center):
            return super()._multipoles(degree, origin, radius)
        total = np.zeros((degree + 1, degree + 1), dtype=complex)
        for n in range(0, degree + 1, 2):
            for m in range(0, n + 1, 2):
                total[n, m] = self.mass * _mean_of_harmonic(n, m, *(self.semiaxes / radius) ** 2)
        return total

    def _own_gravity(self, points: Array) -> tuple[Array, Array]:
        from scipy.special import elliprd, elliprf

        squares = _confocal(points, self.semiaxes)
        a, b, c = squares.T
        factors = np.stack([elliprd(b, c, a), elliprd(c, a, b), elliprd(a, b, c)], axis=-1)
        potential = 1.5 * elliprf(a, b, c) - 0.5 * np.sum(points * points * factors, axis=-1)
        return self.mass * potential, -self.mass * points * factors


def _mean_of_harmonic(n: int, m: int, a2: float, b2: float, c2: float) -> float:
    """Return the mean of Z_nm over an ellipsoid with squared semiaxes, n and m even (Balmino 1994, CMDA 60, 331)."""
    half, order = n // 2, m // 2
    flat, long = c2 - (a2 + b2) / 2, a2 - b2
    terms = (
        long ** (order + 2 * i)
        * flat ** (half - order - 2 * i)
        / (16**i * factorial(half - order - 2 * i) * factorial(order + i) * factorial(i))
        for i in range((half - order) // 2 + 1)
    )
    return float(3 * factorial(half) * factorial(n + m) / (4**order * (n + 3) * factorial(n + 1)) * sum(terms))


def _confocal(points: Array, semiaxes: Array) -> Array:
    """Return the squared semiaxes of the confocal ellipsoids through points, or of the ellipsoid, shape (n, 3).

    With s the smallest of them, f = sum x^2 / (s + excess) is 1. 1 / f is concave, so that Newton's steps rise to it.
    """
    least, x2 = np.min(semiaxes) ** 2, points * points
    excess = np.array((semiaxes - semiaxes.min()) * (semiaxes + semiaxes.min()))
    s = np.maximum(np.max(x2 - excess, axis=-1), least)
    for _ in range(64):
        terms = x2 / (s[:, None] + excess)
        f, slope = terms.sum(axis=-1), np.sum(terms / (s[:, None] + excess), axis=-1)
        step = np.divide(f * (f - 1), slope, out=np.zeros_like(f), where=f > 1)
        s = s + step
        if np.all(step <= 2 * np.finfo(float).eps * s):
            break
    return np.asarray(s[:, None] + excess)


class Cylinder(Solid):
    """Homogeneous circular cylinder about the origin, whose axis is the third axis.

    Potential and attraction are means of closed forms around the axis. Their number is doubled until two means agree to
    1e-12 or to the rounding of the closed forms, which grows with the square of the distance divided by the smaller of
    radius and half the height. Beyond eight circumscribing radii a cubature exact to degree 16 replaces them. Points so
    near the surface that 16384 directions do not suffice raise an error.

    Parameters
    ----------
    radius, height : float
        Radius and full height.
    mass, density : float
        Mass or density; exactly one of the two.

    Raises
    ------
    ValueError
        If a number is not positive, or not exactly one of mass and density is given.

    Examples
    --------
    >>> pt.Body.from_shape(pt.shapes.Cylinder(radius=2.0, height=3.0, mass=4.0))
    Body(moments=[7.0, 7.0, 8.0])
    """

    def __init__(
        self, radius: float, height: float, *, mass: float | None = None, density: float | None = None
    ) -> None:
        self.radius, self.height = float(real_array("radius", radius, ())), float(real_array("height", height, ()))
        refuse_nonpositive("radius", self.radius)
        refuse_nonpositive("height", self.height)
        with np.errstate(over="ignore"):
            volume = float(np.pi * np.square(self.radius) * self.height)
        super().__init__(volume, mass, density)

    def __repr__(self) -> str:
        return f"Cylinder({self.radius:g}, {self.height:g}, mass={self.mass:g})"

    @property
    @override
    def circumscribing_radius(self) -> float:
        return float(np.hypot(self.radius, self.height / 2))

    @override
    def _own_support(self, direction: Vector) -> Scalar:
        x, y, z = direction
        return self.radius * functions.norm((x, y)) + 0.5 * self.height * functions.abs(z)

    def _own_body(self) -> Body:
        return Body.from_cylinder(self.mass, self.radius, self.height)

    def _own_rule(self, degree: int) -> tuple[Array, Array]:
        weights, points = cubature.cylinder(degree)
        return weights, points * (self.radius, self.radius, self.height / 2)

    def _own_gravity(self, points: Array) -> tuple[Array, Array]:
        weights, places = self._own_rule(16)
        potential, attraction = np.empty(len(points)), np.empty((len(points), 3))
        far = np.linalg.norm(points, axis=-1) > 8 * self.circumscribing_radius
        potential[far], attraction[far] = cubature.gravity_of_points(self.mass * weights, places, points[far])
        for i in np.flatnonzero(~far):
            across, along, potential[i] = self._near(np.hypot(*points[i, :2]), points[i, 2])
            outward = points[i, :2] / (np.hypot(*points[i, :2]) or 1.0)
            attraction[i] = *(across * outward), along
        return potential, attraction

    def _near(self, distance: float, height: float) -> Array:
        """Return the attraction away from the axis and along it, and the potential."""
        size, thin = np.hypot(distance, height), min(self.radius, self.height / 2)
        tolerance = max(1e-12, 16 * np.finfo(float).eps * (size / thin) ** 2)
        scales = np.array([1, 1, self.circumscribing_radius + size])
        before = self._around(distance, height, 16)
        for directions in (2**k for k in range(5, 15)):
            now = self._around(distance, height, directions)
            if np.all(np.abs(now - before) * (scales[2] / scales) <= tolerance * now[2]):
                return now
            before = now
        raise ValueError(
            "points must not lie on the surface of a cylinder, but one lies "
            f"{distance:g} from the axis at height {height:g}."
        )

    def _around(self, distance: float, height: float, directions: int) -> Array:
        angle = 2 * np.pi * (np.arange(directions) + 0.5) / directions
        cosine = np.cos(angle)
        outward = self.radius - distance * cosine
        square = outward**2 + (distance * np.sin(angle)) ** 2
        ends: Any = np.array([[self.height / 2 - height], [self.height / 2 + height]])
        wall = np.arcsinh(ends / np.sqrt(square)).sum(axis=0)
        caps = 1 / (np.sqrt(square + ends * ends) + np.abs(ends))
        density = self.mass / self.volume * 2 * np.pi * self.radius
        potential = np.mean(outward * (wall + np.sum(ends * caps, axis=0))) / 2
        return density * np.array([-np.mean(cosine * wall), np.mean(outward * (caps[1] - caps[0])), potential])
