"""Plane and shape of a two-body orbit from position and velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import real_array, refuse_nonpositive, refuse_zero

__all__ = ["Passage", "passage"]


@dataclass(frozen=True)
class Passage:
    """A body on its orbit at one instant.

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

    mu: float
    distance: float
    energy: float
    climb: float
    e_cos: float
    e_sin: float
    parameter: float
    inclination: float
    node: float
    latitude: float

    @property
    def eccentricity(self) -> float:
        """The length of the eccentricity vector."""
        return float(np.hypot(self.e_cos, self.e_sin))

    def plane(self, true_anomaly: float) -> dict[str, float]:
        """Return the three angles of the plane and of the periapsis in it."""
        periapsis = self.latitude - true_anomaly
        return {"inclination": self.inclination, "node": self.node, "argument_of_periapsis": periapsis}


def passage(mu: Any, position: ArrayLike, velocity: ArrayLike) -> Passage:
    """Return what position and velocity, space axes, shape (3,), say about the orbit.

    Raises
    ------
    ValueError
        If `mu` is not positive, the position is zero or the two vectors are parallel.
    """
    mu = float(real_array("mu", mu, ()))
    r, v = real_array("position", position, (3,)), real_array("velocity", velocity, (3,))
    refuse_nonpositive("mu", mu)
    refuse_zero("position", r, "The body would be at the attractor.")
    distance, h = float(np.linalg.norm(r)), np.cross(r, v)
    size = float(np.linalg.norm(h))
    if not size > 1e-12 * distance * float(np.linalg.norm(v)):
        raise ValueError("position and velocity must span a plane, but they are parallel.")
    p = size * size / mu
    # e cos f and e sin f from the distance and the radial speed: exact zeros on a circle stay zeros.
    e_cos, e_sin = float(h @ h / (mu * distance) - 1), size * float(r @ v) / (mu * distance)
    energy = float(v @ v / 2 - mu / distance)
    return Passage(mu, distance, energy, float(r @ v), e_cos, e_sin, p, *_orientation(r / distance, h / size))


def _orientation(radial: NDArray[np.float64], normal: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return inclination, node and argument of latitude."""
    normal = normal - (normal @ radial) * radial  # of vectors nearly parallel their product has lost digits
    normal /= np.linalg.norm(normal)
    across = float(np.hypot(normal[0], normal[1]))
    node = float(np.arctan2(normal[0], -normal[1])) if across > 0 else 0.0
    along_node = np.array([np.cos(node), np.sin(node), 0.0])
    latitude = float(np.arctan2(radial @ np.cross(normal, along_node), radial @ along_node))
    return float(np.arctan2(across, normal[2])), node, latitude
