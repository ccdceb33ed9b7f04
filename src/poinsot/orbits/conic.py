"""Conic orbits about a focus: plane, constructor from vectors, and the integrated anomaly."""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import assemble
from poinsot.checked import checked
from poinsot.errors import exactly_one, member_array, refuse_negative, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.kinematics import euler
from poinsot.mechanics.environment import Orbit, OrbitBlock
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.orbits.frame import OrbitFrame
from poinsot.orbits.from_cartesian import OrbitPoint, orbit_point
from poinsot.quantities import Angle, Inclination, Real, Rule, Time
from poinsot.records.members import of_scalars

__all__ = ["ConicBlock", "ConicOrbit", "Named", "Radius", "check_surface", "in_plane", "plane_of", "shown"]


Radius = Annotated[Real, Rule(refuse_negative, "A point has the radius 0.")]
"""Radius of an attractor's surface."""


Named = tuple[str, Any]
"""An element with its name."""


def _given(elements: dict[str, Any]) -> Named:
    """Return the only element that is not None."""
    name, value = exactly_one("elements", elements)
    return name, member_array(name, value, ())


def shown(path: str, doc: str) -> Any:
    """Return a property that shows an attribute of a field, such as "orbit.mu"."""
    return property(operator.attrgetter(path), doc=doc)


def plane_of(node: Scalar, inclination: Scalar, argument_of_periapsis: Scalar) -> tuple[functions.Vector, ...]:
    """Return the directions to the periapsis, a quarter turn on, and normal, along space."""
    angles = functions.Vector((node, inclination, argument_of_periapsis))
    return tuple(functions.Vector(column) for column in euler.rotation_matrix_from_angles(angles).T)


def in_plane(directions: Sequence[functions.Vector], ahead: Scalar, aside: Scalar) -> functions.Vector:
    """Return a vector of a plane, given along the first two of its directions, along space."""
    return functions.Vector(ahead * p + aside * s for p, s in zip(*directions[:2], strict=True))


def check_surface(orbit: Any) -> None:
    """Warn of a periapsis below the radius of an orbit's attractor."""
    warn_below(orbit, orbit, orbit.radius, "the surface", "the motion is computed as if the attractor were a point")


class ConicOrbit(Orbit):
    """Conic with a focus at the attractor, in a plane fixed in space.

    Parameters
    ----------
    mu : float
        Gravitational parameter of the attractor, in length^3 / time^2.
    inclination, node, argument_of_periapsis : float
        3-1-3 Euler angles of the orbital plane and of the periapsis, radians, relative to the space axes.
    epoch : float
        Time to which the anomaly or the time since periapsis refers.
    radius : float
        Radius of the attractor's surface, in length. A periapsis below it causes a warning with the depth. 0: a point.
    """

    if TYPE_CHECKING:
        # Fields of the subclasses; numbers of any kind.
        eccentricity: Any
        inclination: Any
        node: Any
        argument_of_periapsis: Any
        radius: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        check_surface(self)

    @classmethod
    @checked
    def from_vectors(
        cls, mu: float, *, position: ArrayLike, velocity: ArrayLike, epoch: Time = 0.0, radius: float = 0.0
    ) -> Self:
        """Return the orbit through a position and velocity at the epoch.

        The position is reproduced to machine precision. The velocity error of a parabola or hyperbola is up to r/q
        roundings, which is the effect of rounding the eccentricity at the distance r. Undefined angles are zero: the
        node of an equatorial orbit, the argument of periapsis of a circular orbit.

        Parameters
        ----------
        position, velocity : array (3,), space axes
            Position in length and velocity in length per time of the body relative to the attractor.
        epoch : float
            Time of the position and velocity.

        Returns
        -------
        KeplerOrbit or EscapeOrbit
            An orbit of the class.

        Raises
        ------
        ValueError
            If the two vectors are parallel, or the orbit is of the other class (`two_body_orbit` handles all orbits).
        """
        here = orbit_point(mu, position, velocity)
        shape, anomaly = cls._shape_of(here)
        elements = shape | here.plane(anomaly) | {"epoch": epoch, "radius": radius}
        return cls(here.mu, **elements)

    @classmethod
    @checked
    def from_elements(
        cls,
        mu: Real,
        *,
        periapsis_distance: Real | None = None,
        semimajor_axis: Real | None = None,
        eccentricity: Real,
        inclination: Inclination = 0.0,
        node: Angle = 0.0,
        argument_of_periapsis: Angle = 0.0,
        true_anomaly: Angle | None = None,
        mean_anomaly: Angle | None = None,
        eccentric_anomaly: Angle | None = None,
        epoch: Time = 0.0,
        radius: Real = 0.0,
    ) -> Self:
        """Return the orbit with one of two lengths and one of three anomalies at the epoch.

        A `KeplerOrbit` stores the true anomaly. Its rounding error changes the position on an ellipse of eccentricity e
        by up to 1/sqrt(1 - e) roundings. A hyperbola has a < 0, the mean anomaly M = sqrt(mu/|a|^3) (t - t_p), and the
        hyperbolic anomaly H as eccentric anomaly, M = e sinh H - H. A parabola requires the periapsis distance and the
        true anomaly.

        Parameters
        ----------
        periapsis_distance, semimajor_axis : float, optional
            Exactly one of the two, in length.
        eccentricity : float
            Eccentricity, in [0, 1) for a `KeplerOrbit`, at least 1 for an `EscapeOrbit`.
        true_anomaly, mean_anomaly, eccentric_anomaly : float, optional
            Exactly one of the three at the epoch, radians.

        Returns
        -------
        KeplerOrbit or EscapeOrbit
            An orbit of the class.

        Raises
        ------
        ValueError
            If the number of given lengths or anomalies is not exactly one, or they contradict the eccentricity.
        """
        lengths = {"periapsis_distance": periapsis_distance, "semimajor_axis": semimajor_axis}
        anomalies = {"true_anomaly": true_anomaly, "mean_anomaly": mean_anomaly, "eccentric_anomaly": eccentric_anomaly}
        e, (length, anomaly) = member_array("eccentricity", eccentricity, ()), map(_given, (lengths, anomalies))
        if length[0] == "periapsis_distance":
            refuse_nonpositive(*length)
        elements = cls._shape_from(e, length, anomaly, member_array("mu", mu, ()))
        elements |= {"inclination": inclination, "node": node, "argument_of_periapsis": argument_of_periapsis}
        elements |= {"epoch": epoch, "radius": radius}
        return cls(mu, **elements)

    @classmethod
    @abstractmethod
    def _shape_from(cls, e: Any, length: Named, anomaly: Named, mu: Any) -> dict[str, Any]:
        """Return the elements in the plane of the orbit, by name, from a length and an anomaly with their names."""

    @classmethod
    @abstractmethod
    def _shape_of(cls, here: OrbitPoint) -> tuple[dict[str, Any], float]:
        """Return the elements in the plane of the orbit, by name, and the true anomaly in radians."""

    @property
    @abstractmethod
    def parameter(self) -> Any:
        """Semi-latus rectum p."""

    @property
    def frame(self) -> OrbitFrame:
        """Orbital axes: radial (away from the attractor), transverse and normal."""
        return OrbitFrame(self)

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit vector along the orbital angular momentum, space axes."""
        return np.stack(np.broadcast_arrays(*self.plane[2]), axis=-1)

    @property
    @override
    def directions(self) -> dict[str, NDArray[np.float64]]:
        return {"normal": self.normal}

    @property
    def plane(self) -> tuple[functions.Vector, ...]:
        """Unit vectors to the periapsis, 90 degrees ahead of it, and along the normal, space axes."""
        return plane_of(self.node, self.inclination, self.argument_of_periapsis)

    @of_scalars
    def in_space(self, ahead: Scalar, aside: Scalar) -> functions.Vector:
        """Return a vector of the plane, given along the first two of its directions."""
        return in_plane(self.plane, ahead, aside)


class ConicBlock(OrbitBlock):
    """Block of one variable that defines the true anomaly; the comoving axes are radial, transverse and normal."""

    orbit: Any
    variables: ClassVar[Mapping[str, int]] = {"anomaly": 1}

    @abstractmethod
    def true_anomaly(self, time: Scalar, own: Any) -> Any:
        """Return the true anomaly, radians, up to whole pairs of turns."""

    def cosines(self, time: Scalar, own: Any) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of the true anomaly."""
        f = self.true_anomaly(time, own)
        return functions.cos(f), functions.sin(f)

    def closeness(self, time: Scalar, own: Any) -> Scalar:
        """Return p/r = 1 + e cos f."""
        value: Scalar = 1 + self.orbit.eccentricity * self.cosines(time, own)[0]
        return value

    @override
    def omega(self, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector((0.0, 0.0, self.anomaly_rate(time, own)))

    def quaternion(self, time: NDArray[np.float64], own: Any) -> NDArray[np.float64]:
        """Return p of the paper's Sec. 6.2, which is (12) with node, inclination and argument of latitude."""
        node, inclination, periapsis = self.angles(time)
        half = 0.5 * (periapsis + self.true_anomaly(time, [own[..., 0]]))
        c, s, cn, sn = np.cos(half), np.sin(half), np.cos(0.5 * node), np.sin(0.5 * node)
        ci, si = np.cos(0.5 * inclination), np.sin(0.5 * inclination)
        k0, k1, k2, k3 = cn * ci, cn * si, sn * si, sn * ci  # of the plane
        return assemble((k0 * c - k3 * s, k1 * c + k2 * s, k2 * c - k1 * s, k3 * c + k0 * s))

    @override
    def to_space(self, vector: Any, time: Scalar, own: Any) -> functions.Vector:
        upwards, onwards, aside = vector
        cosine, sine = self.cosines(time, own)
        along = upwards * cosine - onwards * sine, upwards * sine + onwards * cosine, aside
        directions = plane_of(*self.angles(time))
        return functions.Vector(functions.dot(along, components) for components in zip(*directions, strict=True))

    def angles(self, time: Scalar) -> tuple[Any, Any, Any]:  # noqa: ARG002
        """Return node, inclination and argument of periapsis, radians."""
        return self.orbit.node, self.orbit.inclination, self.orbit.argument_of_periapsis

    @override
    def inverse_distance(self, orbit: Orbit, time: Scalar, own: Any) -> Scalar:
        value: Scalar = self.closeness(time, own) / self.orbit.parameter
        return value

    @override
    def direction(self, orbit: Orbit, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector((1.0, 0.0, 0.0))

    @override
    def position(self, orbit: Orbit, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector((1 / self.inverse_distance(orbit, time, own), 0.0, 0.0))

    def velocity(self, orbit: Orbit, time: Scalar, own: Any) -> functions.Vector:
        """Return sqrt(mu / p) (e sin f, 1 + e cos f, 0)."""
        path = self.orbit
        speed = functions.sqrt(path.mu / path.parameter)
        upwards = path.eccentricity * self.cosines(time, own)[1]
        forwards = speed * path.parameter * self.inverse_distance(orbit, time, own)
        return functions.Vector((speed * upwards, forwards, 0.0))

    def anomaly_rate(self, time: Scalar, own: Any) -> Scalar:
        """Return f' = sqrt(mu / p^3) (1 + e cos f)^2."""
        closeness = self.closeness(time, own)
        return closeness * closeness * self._rate_aside

    @property
    def _rate_aside(self) -> Scalar:
        """Rate of the true anomaly at 90 degrees from the periapsis."""
        value: Scalar = functions.sqrt(self.orbit.mu / self.orbit.parameter**3)
        return value
