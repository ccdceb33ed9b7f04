"""Orbits of the circular restricted three-body problem."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import KW_ONLY
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import assemble
from poinsot.errors import refuse_nonpositive, scalar
from poinsot.functions import Scalar
from poinsot.immutable import Immutable, cached_property
from poinsot.kinematics.frame import RotatingFrame
from poinsot.mechanics.environment import Environment, Orbit, OrbitBlock
from poinsot.orbits.conic import shown
from poinsot.orbits.fixed import components
from poinsot.orbits.universal import refuse_symbols
from poinsot.quantities import Along, Real, Time
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Parametric
from poinsot.taylor.graph import number
from poinsot.taylor.paths import Path

__all__ = ["CirclingPair", "SynodicBlock", "ThreeBodyPath", "ThreeBodyView"]


SynodicVector = Annotated[Any, (3,), Along("synodic axes")]
"""Three components along the axes from the primary to the secondary, along the secondary's velocity, and normal."""


Seen = TypeVar("Seen", bound=Orbit)


class CirclingPair(Immutable, Generic[Seen]):
    """Two attractors on circles about each other; the primary is the heavier one."""

    if TYPE_CHECKING:
        mu_primary: Any
        mu_secondary: Any
        separation: Any
        epoch: Any

    @abstractmethod
    def _seen_from(self, attractor: str) -> Seen:
        """Return the orbit of the body about the primary or the secondary."""

    @property
    def from_primary(self) -> Seen:
        """Orbit of the body about the primary."""
        return self._seen_from("primary")

    @property
    def from_secondary(self) -> Seen:
        """Orbit of the body about the secondary."""
        return self._seen_from("secondary")

    @property
    def frame(self) -> RotatingFrame:
        """Synodic axes: from the primary to the secondary, along its velocity, and normal."""
        return RotatingFrame((1, 0, 0, 0), np.multiply.outer(self.mean_motion, (0.0, 0.0, 1.0)), self.epoch)

    @property
    def mass_ratio(self) -> Any:
        """Mass of the secondary over the mass of both, mu."""
        return self.mu_secondary / (self.mu_primary + self.mu_secondary)

    @property
    def mean_motion(self) -> Any:
        """Mean motion of the attractors, sqrt((mu1 + mu2)/separation^3), radians per unit of time."""
        return functions.sqrt((self.mu_primary + self.mu_secondary) / self.separation**3)

    def _check_pair(self) -> None:
        for name in ("mu_primary", "mu_secondary", "separation"):
            refuse_nonpositive(name, getattr(self, name))
        secondary, primary = np.broadcast_arrays(self.mu_secondary, self.mu_primary)
        if np.any(secondary > primary):
            wrong = np.argmax(secondary > primary)
            raise ValueError(
                f"mu_secondary must not exceed mu_primary, got {secondary.flat[wrong]} and {primary.flat[wrong]}. "
                "The primary is the heavier one."
            )


class ThreeBodyPath(CirclingPair["ThreeBodyView"], Parametric):
    """Path of a body in the circular restricted three-body problem, such as a halo or Lyapunov orbit.

    At the epoch the secondary is in the direction of the first space axis from the primary; the orbital motion is about
    the third axis, as in `LagrangePointPath`. A body on the path requires both attractors:
    `GravityGradient(path.from_primary)` and `GravityGradient(path.from_secondary)`. A compiled kernel integrates
    position and velocity once for both, together with the attitude. Outside a kernel they are integrated alone, in
    quadruple precision. After a collision the position is NaN.

    Parameters
    ----------
    mu_primary, mu_secondary : float
        Gravitational parameters, in length^3 / time^2.
    separation : float
        Distance between the attractors, in length.
    position, velocity : array (3,), synodic axes
        Position relative to the barycentre and velocity relative to the rotating axes at the epoch. The axes point from
        primary to secondary, along the secondary's velocity, and along the normal.
    epoch : float
        Time of the initial position.

    Raises
    ------
    ValueError
        If a parameter is not positive, the secondary is more massive than the primary, or the body is at an attractor.

    Notes
    -----
    The attractors are point masses (Szebehely 1967, Theory of Orbits).

    Examples
    --------
    >>> path = pt.orbits.ThreeBodyPath(0.9, 0.1, separation=1.0, position=(0.5, 0.6, 0), velocity=(0, 0.1, 0))
    >>> round(float(path.jacobi_constant), 4)
    2.9987
    >>> [round(float(x), 4) for x in path.from_primary.position_at(1.0)]
    [-0.2275, 0.6629, 0.0]
    """

    mu_primary: Real
    mu_secondary: Real
    _: KW_ONLY
    separation: Real
    position: SynodicVector
    velocity: SynodicVector
    epoch: Time = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_pair()
        x, y, z, *_ = self._start
        for name, along in (("secondary", x), ("primary", x + 1)):
            if np.any(abs(along) + abs(y) + abs(z) < 4 * np.finfo(float).eps):
                raise ValueError(f"position must be apart from both attractors, got a body at the {name}.")

    @override
    def _seen_from(self, attractor: str) -> ThreeBodyView:
        return ThreeBodyView(self, attractor=attractor)

    @property
    def jacobi_constant(self) -> Any:
        """Jacobi constant C = x^2 + y^2 + 2 (1 - mu)/d1 + 2 mu/d2 - v^2, in units of separation and mean motion."""
        x, y, _, *velocity = start = self._start
        x, mu, inverse = x + (1 - self.mass_ratio), self.mass_ratio, _inverse_distances(start)
        potential = 0.5 * (x * x + y * y) + (1 - mu) * inverse["primary"] + mu * inverse["secondary"]
        return 2 * potential - functions.dot(velocity, velocity)

    @of_scalars
    def variables_at(self, time: Scalar) -> functions.Vector:
        """Return position and velocity relative to the secondary along the synodic axes, in normalised units.

        The units are the separation and the mean motion.
        """
        time = scalar("time", time)
        here = number(time)
        refuse_symbols(type(self).__name__, here, self.epoch, *self._start, variable="path")
        now = functions.Vector(self._path(here - self.epoch))
        if here is time:
            return now
        rates = SynodicBlock(self).rates_at(here, now)
        return functions.Vector(x + rate * (time - here) for x, rate in zip(now, rates, strict=True))

    @cached_property
    def _path(self) -> Path:
        return Path(SynodicBlock(self), self._start)

    @property
    def _start(self) -> tuple[Any, ...]:
        x, y, z = (x / self.separation for x in components(self.position))
        velocity = (v / (self.separation * self.mean_motion) for v in components(self.velocity))
        return x - (1 - self.mass_ratio), y, z, *velocity


class ThreeBodyView(Orbit):
    """Path of a body near two attractors, relative to one of them.

    The formulas require numbers; a kernel integrates the path with the attitude.

    Parameters
    ----------
    path : ThreeBodyPath
    attractor : {"primary", "secondary"}
    """

    path: ThreeBodyPath
    _: KW_ONLY
    attractor: str

    @property
    def mu(self) -> Any:
        """Gravitational parameter of the attractor."""
        return getattr(self.path, f"mu_{self.attractor}")

    frame = shown("path.frame", "Synodic axes: from the primary to the secondary, along its velocity, and normal.")

    @cached_property
    def block(self) -> SynodicBlock:
        """Path, integrated with the attitude."""
        return SynodicBlock(self.path)

    @property
    @override
    def closed_form(self) -> bool:
        return False

    @property
    @override
    def sample_time(self) -> Any:
        return self.path.epoch

    @property
    def sample_reach(self) -> Any:
        """Half a revolution of the attractors, in which no path becomes chaotic."""
        return np.pi / self.path.mean_motion

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        return self._environment(time).position(self)

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        return self._environment(time).velocity(self)

    @override
    def inverse_distance_at(self, time: Scalar) -> Scalar:
        return self._environment(time).inverse_distance(self)

    def _environment(self, time: Scalar) -> Environment:
        return Environment(time, [(self.block, self.path.variables_at(time))], {id(self): 0})


class SynodicBlock(OrbitBlock):
    """Position and velocity from the secondary along the axes that turn with the attractors: the comoving axes.

    Their units are the separation and the mean motion: the variables are of the size of a quaternion or below, for the
    engine's step control looks at the largest one.
    """

    path: ThreeBodyPath
    variables: ClassVar[Mapping[str, int]] = {"position": 3, "velocity": 3}

    @override
    def start_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack(np.broadcast_arrays(*self.path.variables_at(time)), axis=-1)

    @override
    def rates_at(self, time: Scalar, own: Any) -> functions.Vector:
        x, y, z, u, v, w = own
        mu, n = self.path.mass_ratio, self.path.mean_motion
        far, near = (inverse * inverse * inverse for inverse in _inverse_distances(own).values())
        of_primary = (1 - mu) * far
        both = of_primary + mu * near
        ahead = x - both * x + (1 - mu) - of_primary + 2 * v
        return functions.Vector((n * u, n * v, n * w, n * ahead, n * (y - both * y - 2 * u), -(n * (both * z))))

    @override
    def omega(self, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector((0.0, 0.0, self.path.mean_motion))

    @override
    def quaternion(self, time: NDArray[np.float64], own: Any) -> NDArray[np.float64]:
        half: Any = 0.5 * self._phase(time)
        return assemble((np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)))

    @override
    def to_space(self, vector: Any, time: Scalar, own: Any) -> functions.Vector:
        (x, y, z), phase = vector, self._phase(time)
        c, s = functions.cos(phase), functions.sin(phase)
        return functions.Vector((c * x - s * y, s * x + c * y, z))

    @override
    def inverse_distance(self, orbit: Any, time: Scalar, own: Any) -> Scalar:
        return _inverse_distances(own)[orbit.attractor] / self.path.separation

    @override
    def direction(self, orbit: Any, time: Scalar, own: Any) -> functions.Vector:
        inverse = _inverse_distances(own)[orbit.attractor]
        return functions.Vector(x * inverse for x in self._place(orbit, own))

    @override
    def position(self, orbit: Any, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector(x * self.path.separation for x in self._place(orbit, own))

    @override
    def velocity(self, orbit: Any, time: Scalar, own: Any) -> functions.Vector:
        (x, y, _), (u, v, w) = self._place(orbit, own), own[3:]
        speed = self.path.separation * self.path.mean_motion
        return functions.Vector((speed * (u - y), speed * (v + x), speed * w))

    def _place(self, orbit: Any, own: Any) -> tuple[Scalar, ...]:
        x, y, z = own[:3]
        return (x + 1 if orbit.attractor == "primary" else x), y, z

    def _phase(self, time: Scalar) -> Scalar:
        """Return the angle of the axes, radians."""
        value: Scalar = self.path.mean_motion * (time - self.path.epoch)
        return value


def _inverse_distances(own: Any) -> dict[str, Scalar]:
    """Return one over the distances from the attractors."""
    x, y, z = own[:3]
    across = y * y + z * z
    return {"primary": ((x + 1) * (x + 1) + across) ** -0.5, "secondary": (x * x + across) ** -0.5}
