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
from poinsot.errors import refuse_negative
from poinsot.functions import Scalar
from poinsot.mechanics import euler
from poinsot.mechanics.environment import Orbit, OrbitBlock
from poinsot.mechanics.members import of_scalars
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.orbits.frame import OrbitFrame
from poinsot.orbits.from_cartesian import OrbitPoint, orbit_point
from poinsot.quantities import Real, Rule, Time

__all__ = ["ConicBlock", "ConicOrbit", "Radius", "check_surface", "in_plane", "plane_of", "shown"]


Radius = Annotated[Real, Rule(refuse_negative, "A point has the radius 0.")]
"""Radius of an attractor's surface."""


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
    """A conic with a focus at the attractor, in a plane fixed in space."""

    if TYPE_CHECKING:
        # Fields or properties of the subclasses; numbers of any kind.
        eccentricity: Any
        inclination: Any
        node: Any
        argument_of_periapsis: Any
        radius: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        check_surface(self)

    @classmethod
    def from_vectors(
        cls, mu: float, *, position: ArrayLike, velocity: ArrayLike, epoch: Time = 0.0, radius: float = 0.0
    ) -> Self:
        """Return the orbit through a position and velocity at the epoch.

        The position is reproduced to machine precision. The velocity error of a parabola or hyperbola is up to r/q
        roundings, which is the effect of rounding the eccentricity at the distance r. Undefined angles are zero: the
        node of an equatorial orbit, the argument of periapsis of a circular orbit.

        Parameters
        ----------
        mu : float
            Gravitational parameter of the attractor, in length^3 / time^2.
        position, velocity : array (3,), space axes
            Position in length and velocity in length per time of the body relative to the attractor.
        epoch : float
            Time of the position and velocity.
        radius : float
            Radius of the attractor's surface, in length; 0: a point.

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
    @abstractmethod
    def _shape_of(cls, here: OrbitPoint) -> tuple[dict[str, Any], float]:
        """Return the elements in the plane of the orbit, by name, and the true anomaly in radians."""

    @property
    @abstractmethod
    def parameter(self) -> Any:
        """The semi-latus rectum."""

    @property
    def frame(self) -> OrbitFrame:
        """The moving axes radial (away from the attractor), transverse, normal."""
        return OrbitFrame(self)

    @property
    def normal(self) -> NDArray[np.float64]:
        """The unit vector along the orbital angular momentum, space axes."""
        return np.stack(np.broadcast_arrays(*self.plane[2]), axis=-1)

    @property
    @override
    def directions(self) -> dict[str, NDArray[np.float64]]:
        return {"normal": self.normal}

    @property
    def plane(self) -> tuple[functions.Vector, ...]:
        """The directions to the periapsis, a quarter turn on, and normal, along space."""
        return plane_of(self.node, self.inclination, self.argument_of_periapsis)

    @of_scalars
    def in_space(self, ahead: Scalar, aside: Scalar) -> functions.Vector:
        """Return a vector of the plane, given along the first two of its directions."""
        return in_plane(self.plane, ahead, aside)


class ConicBlock(OrbitBlock):
    """One variable that stands for the true anomaly; the comoving axes are radial, transverse, normal."""

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
        """The rate of the true anomaly a quarter turn from the periapsis."""
        value: Scalar = functions.sqrt(self.orbit.mu / self.orbit.parameter**3)
        return value
