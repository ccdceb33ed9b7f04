"""Plane and shape of a two-body orbit from position and velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import real_array, refuse_nonpositive, refuse_zero

__all__ = ["OrbitPoint", "orbit_point", "orbit_points"]

Array = NDArray[Any]


@dataclass(frozen=True)
class OrbitPoint:
    """A body on its orbit at one instant, or arrays of them.

    Attributes
    ----------
    mu, distance, energy : float
        Gravitational parameter, distance from the attractor, energy by mass.
    climb : float
        The product r . v.
    e_cos, e_sin : float
        e cos f and e sin f, with f the true anomaly.
    parameter : float
        The semi-latus rectum.
    inclination, node, latitude : float
        Radians; the node of an orbit in the equator is at zero.
    """

    mu: Any
    distance: Any
    energy: Any
    climb: Any
    e_cos: Any
    e_sin: Any
    parameter: Any
    inclination: Any
    node: Any
    latitude: Any

    @property
    def eccentricity(self) -> Any:
        """Length of the eccentricity vector."""
        return np.hypot(self.e_cos, self.e_sin)

    def plane(self, true_anomaly: Any) -> dict[str, Any]:
        """Return the three angles of the plane and of the periapsis in it."""
        periapsis = self.latitude - true_anomaly
        return {"inclination": self.inclination, "node": self.node, "argument_of_periapsis": periapsis}


def orbit_point(mu: Any, position: ArrayLike, velocity: ArrayLike) -> OrbitPoint:
    """Return the orbit at a position and velocity, space axes, shape (3,).

    Raises
    ------
    ValueError
        If `mu` is not positive, the position is zero or the two vectors are parallel.
    """
    mu = float(real_array("mu", mu, ()))
    r, v = real_array("position", position, (3,)), real_array("velocity", velocity, (3,))
    refuse_nonpositive("mu", mu)
    refuse_zero("position", r, "The body would be at the attractor.")
    if not np.linalg.norm(np.cross(r, v)) > 1e-12 * np.linalg.norm(r) * np.linalg.norm(v):
        raise ValueError("position and velocity must span a plane, but they are parallel.")
    return orbit_points(mu, r, v)


def orbit_points(mu: Any, r: Array, v: Array) -> OrbitPoint:
    """Return the orbits at positions and velocities, space axes, shapes (..., 3)."""
    h = np.cross(r, v)
    distance, size = np.sqrt(np.vecdot(r, r)), np.sqrt(np.vecdot(h, h))
    p = size * size / mu
    # e cos f and e sin f from the distance and the radial speed: exact zeros on a circle stay zeros.
    climb = np.vecdot(r, v)
    e_cos, e_sin = np.vecdot(h, h) / (mu * distance) - 1, size * climb / (mu * distance)
    energy = np.vecdot(v, v) / 2 - mu / distance
    orientation = _orientation(r / distance[..., None], h / size[..., None])
    return OrbitPoint(mu, distance, energy, climb, e_cos, e_sin, p, *orientation)


def _orientation(radial: Array, normal: Array) -> tuple[Any, Any, Any]:
    """Return inclination, node and argument of latitude."""
    # The cross product of nearly parallel vectors has lost digits.
    normal = normal - np.vecdot(normal, radial)[..., None] * radial
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    across = np.hypot(normal[..., 0], normal[..., 1])
    node = np.where(across > 0, np.arctan2(normal[..., 0], -normal[..., 1]), 0.0)[()]
    along_node = np.stack([np.cos(node), np.sin(node), 0 * node], axis=-1)
    latitude = np.arctan2(np.vecdot(radial, np.cross(normal, along_node)), np.vecdot(radial, along_node))
    return np.arctan2(across, normal[..., 2]), node, latitude
