"""One body at one instant: the one argument of every formula."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from poinsot.functions import Scalar, Vector
from poinsot.immutable import Immutable, cached_property
from poinsot.kinematics.attitude import Attitude, matrix_of
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, Orbit, OrbitBlock
from poinsot.quantities import Array

if TYPE_CHECKING:
    from poinsot.mechanics.block import Block
    from poinsot.mechanics.kinetics import CompositeKinetics, Kinetics

__all__ = ["Instant", "InstantOfBodies"]


class InstantOfBodies(Immutable):
    """Base of the instants of one and of two bodies: the time, and positions on orbits at this time."""

    environment: Environment

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of the scalars: () of one state, (members, ...) of states of members."""

    @property
    @abstractmethod
    def of_bodies(self) -> dict[str, Instant]:
        """Instants of the rigid bodies by name; the name of a single body is empty."""

    @property
    def time(self) -> Scalar:
        """Time of the instant."""
        return self.environment.time

    def position(self, orbit: Orbit) -> Vector:
        """Return the position of the body relative to the attractor of an orbit, space axes."""
        return self.environment.position(self._of_members(orbit))

    def velocity(self, orbit: Orbit) -> Vector:
        """Return the velocity of the body relative to the attractor of an orbit, space axes."""
        return self.environment.velocity(self._of_members(orbit))

    def direction(self, orbit: Orbit) -> Vector:
        """Return the unit vector from the attractor of an orbit to the body, space axes."""
        return self.environment.direction(self._of_members(orbit))

    def inverse_distance(self, orbit: Orbit) -> Scalar:
        """Return 1 / r, with the distance r of the body from the attractor of an orbit."""
        return self.environment.inverse_distance(self._of_members(orbit))

    def _of_members(self, orbit: Orbit) -> Orbit:
        """Return an orbit whose numbers broadcast against the scalars of the instant."""
        return orbit.with_axes(len(self.shape)) if orbit.member_axis else orbit


class Instant(InstantOfBodies):
    """Instant of a rotating body: the attitude, rates and environment that a formula of a force, part or event may use.

    Parameters
    ----------
    body : Body
        The body with its parts.
    attitude : Attitude
        Attitude of the body.
    environment : Environment
        Time, and positions on the orbits at this time.
    omega_body, angular_momentum_body : vector, optional
        Inertial angular velocity (radians per unit of time) and angular momentum along the body axes. Either one
        determines the other. Without both, formulas may depend on time, attitude and orbits only, as energies do.
    scale : scalar
        Factor of the momenta in the scaled vector field of a system, and of the given angular momentum.

    Examples
    --------
    >>> body, environment = pt.Body((1.25, 1.0, 0.75)), pt.mechanics.Environment(time=0.0)
    >>> attitude = pt.Attitude.from_quaternion((1, 0, 0, 0))
    >>> instant = pt.Instant(body, attitude, environment, angular_momentum_body=(0.5, 0, 1.5))
    >>> [float(x) for x in instant.omega_body]
    [0.4, 0.0, 2.0]
    """

    def __init__(
        self,
        body: Body,
        attitude: Attitude,
        environment: Environment,
        omega_body: Iterable[Scalar] | None = None,
        angular_momentum_body: Iterable[Scalar] | None = None,
        scale: Scalar = 1,
    ) -> None:
        self._body, self._attitude, self.environment, self.scale = body, attitude, environment, scale
        self._omega_body, self._momentum = omega_body, angular_momentum_body

    @cached_property
    @override
    def shape(self) -> tuple[int, ...]:
        return shape_of(self.time, self._attitude.components, self._omega_body, self._momentum)

    @cached_property
    def body(self) -> Body:
        """The body, with its parts."""
        return self._body.with_axes(len(self.shape)) if self._body.member_axis else self._body

    @property
    @override
    def of_bodies(self) -> dict[str, Instant]:
        return {"": self}

    @property
    def acted_on(self) -> Body:
        """Argument `body` of the action of an event: the body with its parts."""
        return self.body

    @property
    def attitude(self) -> Attitude:
        """The attitude."""
        return self._attitude

    @property
    def without_rates(self) -> Instant:
        """Same instant without angular velocity, for formulas of energies."""
        return Instant(self.body, self.attitude, self.environment)

    @cached_property
    def omega_body(self) -> Vector:
        """Inertial angular velocity along the body axes."""
        if self._omega_body is not None:
            return Vector(self._omega_body)
        if self._momentum is None:
            raise RateUnknownError(
                "an energy must depend on time, attitude, orbits and parts alone, got an angular velocity or momentum."
            )
        return Vector(self.scaled_kinetics.omega(Vector(self._momentum)))

    @cached_property
    def angular_momentum_body(self) -> Vector:
        """Angular momentum along the body axes."""
        if self._momentum is None:
            return Vector(self.body.angular_momentum(self.omega_body))
        momentum: Vector = Vector(self._momentum) / self.scale
        return momentum

    @cached_property
    def scaled_kinetics(self) -> Kinetics | CompositeKinetics:
        """The matrix that multiplies the angular momentum, times the scale, to give the angular velocity."""
        return self.body.kinetics(self.scale)

    @property
    def scaled_momentum(self) -> Vector:
        """The angular momentum times the scale."""
        return Vector(self._momentum) if self._momentum is not None else Vector(self.angular_momentum_body * self.scale)

    @cached_property
    def inertia(self) -> Array:
        """Inertia tensor along the body axes, (3, 3) scalars."""
        return matrix_of(self.body.tensor())

    def own(self, block: Block) -> Vector:
        """Return the variables of a part of the system, or of the block of an orbit."""
        return self.environment.own(block) if isinstance(block, OrbitBlock) else self.body.own(block)


def shape_of(time: Scalar, *vectors: Iterable[Scalar] | None) -> tuple[int, ...]:
    """Return the shape of a time together with the scalars of vectors, of which some may be None."""
    scalars = (time, *(x for vector in vectors if vector is not None for x in vector))
    return np.broadcast_shapes(*(x.shape for x in scalars if isinstance(x, np.ndarray)))


class RateUnknownError(TypeError):
    """A formula that must depend on the attitude alone asks for a rate."""
