"""Lagrange points of the circular restricted three-body problem."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.errors import member_array, real_array
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.kinematics.frame import RotatingFrame
from poinsot.orbits.fixed import HeldPosition, components
from poinsot.orbits.restricted_three_body import CirclingPair, ThreeBodyPath
from poinsot.printable import quoted
from poinsot.quantities import AngularVelocity, Time

__all__ = ["LagrangePointPath", "RotatingPosition"]

POINTS = ("L1", "L2", "L3", "L4", "L5")


class RotatingPosition(HeldPosition):
    """Position that rotates with its attractor at a constant rate, as in a synodic frame.

    Parameters
    ----------
    mu : float
        Gravitational parameter of the attractor, in length^3 / time^2.
    position : array (3,), space axes
        Position of the body relative to the attractor at the epoch, in length.
    rate : float
        Angular velocity about the third space axis, radians per unit of time.
    epoch : float
        Time to which the position refers.

    Raises
    ------
    ValueError
        If `mu` is not positive, or the body is at the attractor.

    Examples
    --------
    >>> orbit = pt.orbits.RotatingPosition(1.0, position=(2, 0, 0), rate=0.5)
    >>> [round(float(x), 3) for x in orbit.position_at(np.pi)]
    [0.0, 2.0, 0.0]
    """

    _: KW_ONLY
    rate: AngularVelocity
    epoch: Time = 0.0

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        (x, y, z), (c, s) = components(self.position), self._turn(time)
        return functions.Vector((c * x - s * y, s * x + c * y, z))

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        (x, y, z), (c, s) = components(self.position), self._turn(time)
        return functions.Vector((-self.rate * (s * x + c * y), self.rate * (c * x - s * y), 0 * z))

    @override
    def inverse_distance_at(self, time: Scalar) -> Scalar:
        return 1 / functions.norm(components(self.position))

    @property
    def uniform_rotation(self) -> NDArray[np.float64]:
        """Angular velocity about the third space axis, shape (..., 3)."""
        return np.asarray(np.multiply.outer(self.rate, (0.0, 0.0, 1.0)))

    @property
    def frame(self) -> RotatingFrame:
        """Axes that rotate with the position and equal the space axes at the epoch."""
        return RotatingFrame((1, 0, 0, 0), self.uniform_rotation, self.epoch)

    def _turn(self, time: Scalar) -> tuple[Scalar, Scalar]:
        angle = self.rate * (time - self.epoch)
        return functions.cos(angle), functions.sin(angle)


@dataclass(frozen=True, eq=False)
class LagrangePointPath(CirclingPair[RotatingPosition]):
    """Libration point of two attractors in circular orbits in the plane of the first two space axes.

    At the epoch the secondary is in the direction of the first axis from the primary; the orbital motion is about the
    third axis. A body at the point requires both attractors: `GravityGradient(point.from_primary)` and
    `GravityGradient(point.from_secondary)` (Szebehely 1967, Theory of Orbits).

    Parameters
    ----------
    mu_primary, mu_secondary : float
        Gravitational parameters, in length^3 / time^2.
    separation : float
        Distance between the attractors, in length.
    point : {"L1", "L2", "L3", "L4", "L5"}
        L1 lies between the attractors, L2 beyond the secondary, L3 beyond the primary, L4 ahead of the secondary and L5
        behind it.
    epoch : float
        Time at which the secondary is in the direction of the first axis.

    Raises
    ------
    ValueError
        If a parameter is not positive, the secondary is more massive than the primary, or the point is unknown.

    Examples
    --------
    >>> moon = pt.orbits.LagrangePointPath(398600.4, 4902.8, separation=384400.0, point="L2")  # km, s
    >>> round(float(moon.from_secondary.periapsis_distance))
    64515
    """

    mu_primary: float
    mu_secondary: float
    _: KW_ONLY
    separation: float
    point: str
    epoch: Time = 0.0

    def __post_init__(self) -> None:
        for name in ("mu_primary", "mu_secondary", "separation", "epoch"):
            object.__setattr__(self, name, float(real_array(name, getattr(self, name), ())))
        self._check_pair()
        if not isinstance(self.point, str) or self.point not in POINTS:
            raise ValueError(f"point must be one of {', '.join(POINTS)}, got {quoted(self.point)}.")

    def path(self, *, offset: ArrayLike = (0, 0, 0), velocity: ArrayLike = (0, 0, 0)) -> ThreeBodyPath:
        """Return the path of a freely moving body that starts near the point.

        Parameters
        ----------
        offset, velocity : array (3,) or (members, 3), synodic axes
            Position in length and velocity in length per time, relative to the point at the epoch, along the axes of
            `frame`.

        Returns
        -------
        ThreeBodyPath
            The path in the restricted three-body problem.
        """
        barycenter = np.array((self.mass_ratio * self.separation, 0.0, 0.0))
        place: Any = self._places[0] - barycenter + member_array("offset", offset, (3,))
        return ThreeBodyPath(
            self.mu_primary,
            self.mu_secondary,
            separation=self.separation,
            position=place,
            velocity=velocity,
            epoch=self.epoch,
        )

    @override
    def _seen_from(self, attractor: str) -> RotatingPosition:
        mu, place = getattr(self, f"mu_{attractor}"), self._places[attractor == "secondary"]
        return RotatingPosition(mu, position=place, rate=self.mean_motion, epoch=self.epoch)

    @cached_property
    def _places(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions relative to primary and secondary at the epoch."""
        if self.point in ("L4", "L5"):
            across = np.sqrt(0.75) if self.point == "L4" else -np.sqrt(0.75)
            primary, secondary = (0.5, across, 0.0), (-0.5, across, 0.0)
        else:
            distance = self._distance
            along_primary, along_secondary = {
                "L1": (1 - distance, -distance),
                "L2": (1 + distance, distance),
                "L3": (-distance, -1 - distance),
            }[self.point]
            primary, secondary = (along_primary, 0.0, 0.0), (along_secondary, 0.0, 0.0)
        return self.separation * np.array(primary), self.separation * np.array(secondary)

    @cached_property
    def _distance(self) -> float:
        """Distance from the nearer attractor over the separation: the positive root of Euler's quintic."""
        mu = self.mass_ratio
        quintic = np.polynomial.Polynomial(
            {
                "L1": (-mu, 2 * mu, -mu, 3 - 2 * mu, -(3 - mu), 1),
                "L2": (-mu, -2 * mu, -mu, 3 - 2 * mu, 3 - mu, 1),
                "L3": (-(1 - mu), -2 * (1 - mu), -(1 - mu), 1 + 2 * mu, 2 + mu, 1),
            }[self.point]
        )
        root = np.cbrt(mu / 3) if self.point != "L3" else 1 - 7 / 12 * mu
        slope = quintic.deriv()
        for _ in range(20):
            root -= quintic(root) / slope(root)
        return float(root)
