"""Ellipses with uniform precession of node and periapsis."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import member_array, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.mechanics.environment import Orbit
from poinsot.orbits.angle_reduction import angle_at, mean_motion_of
from poinsot.orbits.conic import ConicBlock, in_plane, plane_of, shown
from poinsot.orbits.frame import OrbitFrame
from poinsot.orbits.kepler import EllipticBlock, KeplerOrbit, LongEllipticBlock, is_circle
from poinsot.quantities import AngularVelocity

__all__ = ["LongPrecessingBlock", "PrecessingBlock", "PrecessingOrbit"]


class PrecessingOrbit(Orbit):
    """Kepler ellipse with secular rates of node, periapsis and mean anomaly.

    The node moves in the plane of the first two space axes, which must be the reference plane of the rates (the equator
    of the attractor, or the Laplace plane). The velocity is the derivative of the position, including the rates. With
    zero rates the orbit is the unperturbed ellipse.

    Parameters
    ----------
    orbit : KeplerOrbit
        Ellipse at its epoch.
    node_rate, periapsis_rate : float
        Rates of the node and of the argument of periapsis, radians per unit of time. The longitude of periapsis
        advances at their sum.
    anomaly_rate : float
        Rate of the mean anomaly in excess of sqrt(mu / a^3), radians per unit of time.

    Raises
    ------
    ValueError
        If the resulting mean motion is not positive.

    Examples
    --------
    >>> ellipse = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1, inclination=0.3)
    >>> orbit = pt.orbits.PrecessingOrbit(ellipse, node_rate=-0.001)
    >>> [round(float(angle), 4) for angle in orbit.angles_at(100.0)]
    [-0.1, 0.3, 0.0]
    """

    orbit: KeplerOrbit
    _: KW_ONLY
    node_rate: AngularVelocity = 0.0
    periapsis_rate: AngularVelocity = 0.0
    anomaly_rate: AngularVelocity = 0.0

    @classmethod
    @checked
    def from_mean_motion(
        cls,
        orbit: KeplerOrbit,
        *,
        mean_motion: AngularVelocity,
        node_rate: AngularVelocity = 0.0,
        periapsis_rate: AngularVelocity = 0.0,
    ) -> PrecessingOrbit:
        """Return the orbit with an observed rate of the mean anomaly, radians per unit of time.

        The rate of the mean longitude is the sum of the three rates.

        Parameters
        ----------
        mean_motion : float
            Rate of the mean anomaly, radians per unit of time.

        Returns
        -------
        PrecessingOrbit
            The precessing ellipse.
        """
        total = member_array("mean_motion", mean_motion, ())
        refuse_nonpositive("mean_motion", total)
        beyond = total[()] - mean_motion_of(cls(orbit).mu, orbit.semimajor_axis)
        return cls(orbit, node_rate=node_rate, periapsis_rate=periapsis_rate, anomaly_rate=beyond.hi)

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_nonpositive("mean_motion", self.mean_motion)

    mu = shown("orbit.mu", "Gravitational parameter of the attractor.")
    epoch = shown("orbit.epoch", "Time at which the angles equal the angles of the ellipse.")
    eccentricity = shown("orbit.eccentricity", "Eccentricity of the ellipse.")
    periapsis_distance = shown("orbit.periapsis_distance", "Periapsis distance a (1 - e).")
    radius = shown("orbit.radius", "Radius of the attractor's surface, in length; 0: a point.")
    parameter = shown("orbit.parameter", "Semi-latus rectum p = a (1 - e^2).")

    @property
    def mean_motion(self) -> Any:
        """Rate of the mean anomaly, radians per unit of time."""
        return self.orbit.mean_motion + self.anomaly_rate

    @property
    def period(self) -> Any:
        """Anomalistic period, the time from periapsis to periapsis."""
        return 2 * np.pi / self.mean_motion

    @property
    def frame(self) -> OrbitFrame:
        """Orbital axes: radial (away from the attractor), transverse, and normal to the precessing plane."""
        return OrbitFrame(self)

    @property
    @override
    def integrated(self) -> bool:
        return self.orbit.elongated

    @cached_property
    def block(self) -> PrecessingBlock | LongPrecessingBlock:
        """True or eccentric anomaly, integrated with the attitude."""
        return LongPrecessingBlock(self) if self.orbit.elongated else PrecessingBlock(self)

    @property
    def directions(self) -> dict[str, NDArray[np.float64]]:
        """Normal of an orbit whose plane is fixed."""
        return {"normal": self.orbit.normal} if not np.any(self.node_rate) else {}

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """Rate of the argument of latitude about the normal for a circle in a fixed plane; None otherwise."""
        if not is_circle(self.orbit):
            return None
        rate = self.mean_motion + self.periapsis_rate
        if np.any(self.node_rate):
            if np.any(self.orbit.inclination):
                return None
            rate = rate + self.node_rate
        return np.asarray(rate)[..., None] * self.orbit.normal

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        return self._in_space(time, *self.orbit.place(self.phase_at(time)))

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        phase = self.phase_at(time)
        (x, y), (dx, dy) = self.orbit.place(phase), self.orbit.slope(phase)
        n, turn = self.mean_motion, self.periapsis_rate
        along = self._in_space(time, n * dx - turn * y, n * dy + turn * x)
        east, north, _ = self._in_space(time, x, y)
        return along + functions.Vector((-self.node_rate * north, self.node_rate * east, 0.0))

    @override
    def inverse_distance_at(self, time: Scalar) -> Scalar:
        return 1 / self.orbit.distance(self.phase_at(time))

    def phase_at(self, time: Scalar) -> Scalar:
        """Return the mean anomaly, radians, to machine precision at any time; for floats modulo two revolutions."""
        rate = mean_motion_of(self.mu, self.orbit.semimajor_axis, self.anomaly_rate)
        return angle_at(self.orbit.mean_anomaly_at_epoch, rate, time, self.epoch)

    def angles_at(self, time: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """Return node, inclination and argument of periapsis, radians, modulo two revolutions."""
        node = angle_at(self.orbit.node, self.node_rate, time, self.epoch)
        periapsis = angle_at(self.orbit.argument_of_periapsis, self.periapsis_rate, time, self.epoch)
        return node, self.orbit.inclination, periapsis

    def _in_space(self, time: Scalar, ahead: Scalar, aside: Scalar) -> functions.Vector:
        return in_plane(plane_of(*self.angles_at(time)), ahead, aside)


class _PrecessingPlane(ConicBlock):
    """Angles, angular velocity and velocity of a precessing ellipse."""

    orbit: PrecessingOrbit

    def angles(self, time: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        return self.orbit.angles_at(time)

    def omega(self, time: Scalar, own: Any) -> functions.Vector:
        """Return the rate of the node about the third space axis plus the other rates about the normal."""
        _, inclination, periapsis = self.angles(time)
        latitude = periapsis + self.true_anomaly(time, own)
        tilted = self.orbit.node_rate * functions.sin(inclination)
        upright = self.orbit.node_rate * functions.cos(inclination) + self.orbit.periapsis_rate
        return functions.Vector(
            (
                tilted * functions.sin(latitude),
                tilted * functions.cos(latitude),
                upright + self.anomaly_rate(time, own),
            )
        )

    def velocity(self, orbit: Orbit, time: Scalar, own: Any) -> functions.Vector:
        """Return r' and omega x r, r' = f' r^2 e sin(f)/p."""
        distance = 1 / self.inverse_distance(orbit, time, own)
        e_sin = self.orbit.eccentricity * self.cosines(time, own)[1]
        upwards = self.anomaly_rate(time, own) * distance * distance * e_sin / self.orbit.parameter
        _, across, along = self.omega(time, own)
        return functions.Vector((upwards, along * distance, -across * distance))

    @property
    def _rate_aside(self) -> Scalar:
        e = self.orbit.eccentricity
        value: Scalar = self.orbit.mean_motion * ((1 - e) * (1 + e)) ** -1.5
        return value


class PrecessingBlock(_PrecessingPlane, EllipticBlock):
    """Block of a precessing ellipse."""


class LongPrecessingBlock(_PrecessingPlane, LongEllipticBlock):
    """Block of an elongated precessing ellipse."""
