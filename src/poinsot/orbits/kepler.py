"""The two-body ellipse."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.errors import real_array
from poinsot.functions import Scalar
from poinsot.mechanics import euler
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.parameters import Vector
from poinsot.mechanics.sky import Orbit
from poinsot.orbits.frame import OrbitFrame

__all__ = ["KeplerOrbit"]


class KeplerOrbit(Orbit):
    """The elliptic two-body orbit of the body about an attractor.

    Parameters
    ----------
    mu : float
        Gravitational parameter, length cubed over time squared.
    semimajor_axis : float
        Length.
    eccentricity : float
        In [0, 1).
    inclination, node, argument_of_periapsis, true_anomaly : float
        Radians; the anomaly is the one at the epoch. The orbit plane is the third space axis turned by the
        3-1-3 angles (node, inclination, argument of periapsis).
    epoch : float
        The time at which the body is at `true_anomaly`.

    Raises
    ------
    ValueError
        If `mu` or the semimajor axis is not positive, or the eccentricity is outside [0, 1).
    """

    mu: float
    semimajor_axis: float
    eccentricity: float
    inclination: float
    node: float
    argument_of_periapsis: float
    true_anomaly: float = 0.0
    epoch: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("mu", "semimajor_axis"):
            if np.any(getattr(self, name) <= 0):
                raise ValueError(f"{name} must be positive, but {np.min(getattr(self, name))} came.")
        e = np.asarray(self.eccentricity)
        if np.any((e < 0) | (e >= 1)):
            wrong = e[(e < 0) | (e >= 1)].flat[0]
            raise ValueError(f"eccentricity must be in [0, 1), but {wrong} came. A Kepler orbit is an ellipse.")

    @classmethod
    def from_vectors(cls, mu: float, position: ArrayLike, velocity: ArrayLike, epoch: float = 0.0) -> KeplerOrbit:
        """Return the ellipse through a position with a velocity, space axes, shape (3,), at the epoch.

        Angles that the orbit leaves open are zero: the node of an equatorial orbit, the argument of
        periapsis of a circular one.

        Raises
        ------
        ValueError
            If the two vectors are parallel, or the orbit is not an ellipse.
        """
        mu = float(real_array("mu", mu, ()))
        r, v = real_array("position", position, (3,)), real_array("velocity", velocity, (3,))
        distance, h = float(np.linalg.norm(r)), np.cross(r, v)
        if not np.linalg.norm(h) > 1e-12 * distance * np.linalg.norm(v):
            raise ValueError("position and velocity must span a plane, but they are parallel.")
        energy = v @ v / 2 - mu / distance
        if not energy < 0:
            raise ValueError(
                f"position and velocity must belong to an ellipse, but the orbital energy is {energy:.6g} >= 0."
            )
        node = float(np.arctan2(h[0], -h[1])) if np.hypot(h[0], h[1]) > 0 else 0.0
        inclination = float(np.arctan2(np.hypot(h[0], h[1]), h[2]))
        along_node = np.array([np.cos(node), np.sin(node), 0.0])
        across = np.cross(h / np.linalg.norm(h), along_node)
        latitude = float(np.arctan2(r @ across, r @ along_node))
        # e cos f and e sin f from the distance and the radial speed: exact zeros on a circle stay zeros.
        e_cos = h @ h / (mu * distance) - 1
        e_sin = np.linalg.norm(h) * (r @ v) / (mu * distance)
        anomaly = float(np.arctan2(e_sin, e_cos)) if np.hypot(e_cos, e_sin) > 0 else latitude
        eccentricity, semimajor_axis = float(np.hypot(e_cos, e_sin)), float(-mu / (2 * energy))
        return cls(mu, semimajor_axis, eccentricity, inclination, node, latitude - anomaly, anomaly, epoch)

    # ------------------------------------------------------------------ derived

    @property
    def mean_motion(self) -> Any:
        """The mean angular rate sqrt(mu / a^3), radians per unit of time."""
        return np.sqrt(self.mu / np.asarray(self.semimajor_axis) ** 3)

    @property
    def period(self) -> Any:
        """The time of one revolution."""
        return 2 * np.pi / self.mean_motion

    @property
    def frame(self) -> OrbitFrame:
        """The moving axes radial (away from the attractor), transverse, normal."""
        return OrbitFrame(self)

    @property
    def normal(self) -> NDArray[np.float64]:
        """The unit vector along the orbital angular momentum, space axes."""
        return np.asarray(self._axes()[2])

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """On a circle (to rounding), the mean motion about the normal; None otherwise."""
        return self.mean_motion * self.normal if np.all(np.asarray(self.eccentricity) < 1e-14) else None

    @property
    def directions(self) -> dict[str, NDArray[np.float64]]:  # noqa: D102
        return {"normal": self.normal}

    # ------------------------------------------------------------------ motion

    @property
    def prepared(self) -> Any:
        """The ellipse by its constant vectors, which is what the equations need."""
        e, a, f = (np.asarray(x) for x in (self.eccentricity, self.semimajor_axis, self.true_anomaly))
        ratio = np.sqrt((1 - e) * (1 + e))
        E = f - 2 * np.arctan2(e * np.sin(f), 1 + ratio + e * np.cos(f))
        to_periapsis, to_side, _ = self._axes()
        return _Ellipse(
            self.mu,
            a[..., None] * to_periapsis,
            (a * ratio)[..., None] * to_side,
            self.semimajor_axis,
            self.eccentricity,
            self.mean_motion,
            E - e * np.sin(E),
            self.epoch,
        )

    def position_at(self, time: Scalar) -> Any:  # noqa: D102
        return self.prepared.position_at(time)

    def velocity_at(self, time: Scalar) -> Any:  # noqa: D102
        return self.prepared.velocity_at(time)

    def distance_at(self, time: Scalar) -> Scalar:  # noqa: D102
        return self.prepared.distance_at(time)

    def _axes(self) -> tuple[NDArray[Any], ...]:
        angles = np.stack(np.broadcast_arrays(self.node, self.inclination, self.argument_of_periapsis), axis=-1)
        q = euler.quaternion_from_angles(angles)
        return tuple(quat.rotate(q, unit) for unit in np.eye(3))


class _Ellipse(Orbit):
    """The same orbit: r = a P (cos E - e) + b Q sin E, with the vectors a P and b Q in space axes."""

    mu: float
    to_periapsis: Vector
    to_side: Vector
    semimajor_axis: float
    eccentricity: float
    mean_motion: float
    mean_anomaly: float
    epoch: float

    def position_at(self, time: Scalar) -> functions.Vector:
        cosine, sine = self._circle(time)
        ahead = cosine - self.eccentricity
        return functions.Vector(ahead * p + sine * s for p, s in zip(self.to_periapsis, self.to_side, strict=True))

    def velocity_at(self, time: Scalar) -> functions.Vector:
        cosine, sine = self._circle(time)
        rate = self.mean_motion / (1 - self.eccentricity * cosine)
        return functions.Vector(
            rate * (cosine * s - sine * p) for p, s in zip(self.to_periapsis, self.to_side, strict=True)
        )

    def distance_at(self, time: Scalar) -> Scalar:
        return self.semimajor_axis * (1 - self.eccentricity * self._circle(time)[0])

    def _circle(self, time: Scalar) -> tuple[Scalar, Scalar]:
        mean_anomaly = self.mean_anomaly + self.mean_motion * (time - self.epoch)
        E = functions.eccentric_anomaly(self.eccentricity, mean_anomaly)
        return functions.cos(E), functions.sin(E)
