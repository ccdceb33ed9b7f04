"""The two-body ellipse."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.mechanics import euler
from poinsot.mechanics.axes import Axes
from poinsot.mechanics.quaternion import assemble
from poinsot.mechanics.sky import Orbit, Sky
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
            refuse_nonpositive(name, getattr(self, name))
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
        refuse_nonpositive("mu", mu)
        if not np.any(r):
            raise ValueError("position must not be zero, but the body is at the attractor.")
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
        return functions.sqrt(self.mu / self.semimajor_axis**3)

    @property
    def period(self) -> Any:
        """The time of one revolution."""
        return 2 * np.pi / self.mean_motion

    @property
    def parameter(self) -> Any:
        """The semi-latus rectum p = a (1 - e^2)."""
        return self.semimajor_axis * (1 - self.eccentricity) * (1 + self.eccentricity)

    @property
    def frame(self) -> OrbitFrame:
        """The moving axes radial (away from the attractor), transverse, normal."""
        return OrbitFrame(self)

    @property
    def normal(self) -> NDArray[np.float64]:
        """The unit vector along the orbital angular momentum, space axes."""
        return np.stack(np.broadcast_arrays(*self._axes()[2]), axis=-1)

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """On a circle (to rounding), the mean motion about the normal; None otherwise."""
        return (
            np.asarray(self.mean_motion)[..., None] * self.normal
            if np.all(np.asarray(self.eccentricity) < 1e-14)
            else None
        )

    @property
    def directions(self) -> dict[str, NDArray[np.float64]]:  # noqa: D102
        return {"normal": self.normal}

    @property
    def axes(self) -> KeplerAxes:
        """The axes radial, transverse, normal, with the true anomaly integrated along."""
        return KeplerAxes(self)

    # ------------------------------------------------------------------ motion

    def position_at(self, time: Scalar) -> functions.Vector:  # noqa: D102
        a, e = self.semimajor_axis, self.eccentricity
        cosine, sine = self._eccentric_circle(time)
        ahead, aside = a * (cosine - e), a * self._ratio * sine
        return functions.Vector(ahead * p + aside * s for p, s in zip(*self._axes()[:2], strict=True))

    def velocity_at(self, time: Scalar) -> functions.Vector:  # noqa: D102
        cosine, sine = self._eccentric_circle(time)
        speed = self.semimajor_axis * self.mean_motion / (1 - self.eccentricity * cosine)
        ahead, aside = -speed * sine, speed * self._ratio * cosine
        return functions.Vector(ahead * p + aside * s for p, s in zip(*self._axes()[:2], strict=True))

    def inverse_distance_at(self, time: Scalar) -> Scalar:  # noqa: D102
        return 1 / (self.semimajor_axis * (1 - self.eccentricity * self._eccentric_circle(time)[0]))

    def mean_anomaly_at(self, time: Scalar) -> Scalar:
        """Return the mean anomaly, radians, not reduced."""
        e, f = self.eccentricity, self.true_anomaly
        E = f - 2 * functions.atan2(e * functions.sin(f), 1 + self._ratio + e * functions.cos(f))
        return (E - e * functions.sin(E)) + self.mean_motion * (time - self.epoch)

    def _eccentric_circle(self, time: Scalar) -> tuple[Scalar, Scalar]:
        E = functions.eccentric_anomaly(self.eccentricity, self.mean_anomaly_at(time))
        return functions.cos(E), functions.sin(E)

    @property
    def _ratio(self) -> Scalar:
        return functions.sqrt((1 - self.eccentricity) * (1 + self.eccentricity))

    def _axes(self) -> tuple[functions.Vector, ...]:
        """Return the directions to the periapsis, a quarter turn on, and normal, along space."""
        angles = functions.Vector((self.node, self.inclination, self.argument_of_periapsis))
        columns = euler.rotation_matrix_from_angles(angles).T
        return tuple(functions.Vector(column) for column in columns)


class KeplerAxes(Axes):
    """Radial, transverse, normal axes; their variable is f - M, the true less the mean anomaly.

    f itself would grow with every revolution and loosen the engine's step control, which looks at the
    largest variable.
    """

    orbit: KeplerOrbit

    size = 1

    def start(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        e, mean = self.orbit.eccentricity, self.orbit.mean_anomaly_at(time)
        E = functions.eccentric_anomaly(e, mean)
        beta = e / (1 + np.sqrt((1 - e) * (1 + e)))
        return np.asarray(E - mean + 2 * np.arctan2(beta * np.sin(E), 1 - beta * np.cos(E)))[..., None]

    def sky(self, time: Scalar, variables: Any) -> Sky:
        return _KeplerSky(time, self, variables)

    def rates(self, time: Scalar, variables: Any) -> list[Scalar]:
        return [self._rate(time, variables) - self.orbit.mean_motion]

    def omega(self, time: Scalar, variables: Any) -> functions.Vector:
        return functions.Vector((0.0, 0.0, self._rate(time, variables)))

    def quaternion(self, time: NDArray[np.float64], variables: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return p of the paper's Sec. 6.2, which is (12) with node, inclination and argument of latitude."""
        orbit = self.orbit
        half = 0.5 * (orbit.argument_of_periapsis + self.true_anomaly(time, [variables[..., 0]]))
        (c, s), (cn, sn), (ci, si) = ((np.cos(x), np.sin(x)) for x in (half, 0.5 * orbit.node, 0.5 * orbit.inclination))
        k0, k1, k2, k3 = cn * ci, cn * si, sn * si, sn * ci  # of the plane
        return assemble((k0 * c - k3 * s, k1 * c + k2 * s, k2 * c - k1 * s, k3 * c + k0 * s))

    def true_anomaly(self, time: Scalar, variables: Any) -> Scalar:
        return variables[0] + self.orbit.mean_anomaly_at(time)

    def inverse_distance(self, time: Scalar, variables: Any) -> Scalar:
        """Return 1/r = (1 + e cos f) / (a (1 - e^2))."""
        return (1 + self._e_cos(time, variables)) / self.orbit.parameter

    def _rate(self, time: Scalar, variables: Any) -> Scalar:
        """Return f' = sqrt(mu / p^3) (1 + e cos f)^2, p = a (1 - e^2)."""
        closeness = 1 + self._e_cos(time, variables)
        return closeness * closeness * functions.sqrt(self.orbit.mu / self.orbit.parameter**3)

    def _e_cos(self, time: Scalar, variables: Any) -> Scalar:
        return self.orbit.eccentricity * functions.cos(self.true_anomaly(time, variables))


class _KeplerSky(Sky):
    """The world along radial, transverse, normal axes: the attractor is straight down."""

    def __init__(self, time: Scalar, axes: KeplerAxes, variables: Any) -> None:
        super().__init__(time)
        self._axes, self._variables = axes, variables

    def inverse_distance(self, orbit: Orbit) -> Scalar:  # noqa: ARG002
        return self._axes.inverse_distance(self.time, self._variables)

    def direction(self, orbit: Orbit) -> functions.Vector:  # noqa: ARG002
        return functions.CarriedVector((1.0, 0.0, 0.0))

    def position(self, orbit: Orbit) -> functions.Vector:
        return functions.CarriedVector((1 / self.inverse_distance(orbit), 0.0, 0.0))

    def velocity(self, orbit: Orbit) -> functions.Vector:
        own = self._axes.orbit
        speed = functions.sqrt(own.mu / own.parameter)
        upwards = own.eccentricity * functions.sin(self._axes.true_anomaly(self.time, self._variables))
        return functions.CarriedVector((speed * upwards, speed * own.parameter * self.inverse_distance(orbit), 0.0))
