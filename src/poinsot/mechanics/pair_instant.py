"""Two bodies at one instant: the one argument of formulas of a pair."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, TypeAlias

from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.each_body import OfTwoBodies
from poinsot.mechanics.environment import Environment, Orbit
from poinsot.mechanics.instant import Instant, InstantOfBodies, RateUnknownError, shape_of
from poinsot.mechanics.two_bodies import BODIES, TwoBodies

__all__ = ["AnyInstant", "PairInstant"]


class PairInstant(OfTwoBodies, InstantOfBodies):
    """Instant of two bodies: the attitudes, separation and momenta that a formula of a pair may use.

    Parameters
    ----------
    pair : TwoBodies
        The two bodies.
    attitudes : two of Attitude
        Attitudes of primary and secondary.
    separation : vector
        Position of the secondary's centre of mass relative to the primary's, space axes.
    environment : Environment
        Time, and positions of the barycentre on the orbits at this time.
    momentum : vector, optional
        Reduced mass times the relative velocity, space axes.
    angular_momenta : two of vectors, optional
        Angular momenta of the bodies, each about the centre of mass and along the axes of the body. Without momenta,
        formulas may depend on time, attitudes and separation only, as energies do.
    scales : two scalars
        Factors of the angular momenta in the scaled vector field.

    Examples
    --------
    >>> ball = pt.Body.from_ellipsoid(2.0, (1, 1, 1))
    >>> upright = pt.Attitude.from_quaternion((1, 0, 0, 0))
    >>> pair, environment = pt.TwoBodies(ball, ball, 1.0), pt.mechanics.Environment(0.0)
    >>> instant = pt.mechanics.PairInstant(pair, (upright, upright), (3, 0, 4), environment)
    >>> float(instant.distance), [float(x) for x in instant.primary.attitude.to_body(instant.separation)]
    (5.0, [3.0, 0.0, 4.0])
    """

    _one: ClassVar[type] = Instant
    _noun: ClassVar[str] = "an instant"

    @checked
    def __init__(
        self,
        pair: TwoBodies,
        attitudes: Sequence[Attitude],
        separation: Iterable[Scalar],
        environment: Environment,
        momentum: Iterable[Scalar] | None = None,
        angular_momenta: Sequence[Iterable[Scalar] | None] = (None, None),
        scales: Sequence[Scalar] = (1, 1),
    ) -> None:
        self.attitudes, self.environment = tuple(attitudes), environment
        self.separation, self._relative = Vector(separation), momentum
        self.angular_momenta, self.scales = tuple(angular_momenta), tuple(scales)
        self.pair = pair.with_axes(len(self.shape)) if pair.member_axis else pair

    @cached_property
    @override
    def shape(self) -> tuple[int, ...]:
        attitudes = (each.components for each in self.attitudes)
        return shape_of(self.environment.time, self.separation, self._relative, *attitudes, *self.angular_momenta)

    @property
    def acted_on(self) -> TwoBodies:
        """Argument `body` of the action of an event: the two bodies."""
        return self.pair

    @property
    @override
    def of_bodies(self) -> dict[str, Instant]:
        return {"primary": self.primary, "secondary": self.secondary}

    @cached_property
    def primary(self) -> Instant:
        """The primary: as one body, where orbits refer to its own centre of mass."""
        return self._of(0)

    @cached_property
    def secondary(self) -> Instant:
        """The secondary, likewise."""
        return self._of(1)

    @cached_property
    def distance(self) -> Scalar:
        """The length of the separation."""
        return functions.norm(self.separation)

    @cached_property
    def from_barycenter(self) -> tuple[Vector, Vector]:
        """The positions of primary and secondary from the barycentre of both, space axes."""
        first, second = self._levers
        return first * self.separation, second * self.separation

    @property
    def _levers(self) -> tuple[Any, Any]:
        (first, second), total = self.pair.each_mass, self.pair.total_mass
        return -second / total, first / total

    @cached_property
    def momentum(self) -> Vector:
        """The relative velocity times the reduced mass, space axes."""
        if self._relative is None:
            raise RateUnknownError(
                "an energy must depend on time, attitudes, separation and orbits alone, got a velocity or momentum."
            )
        return Vector(self._relative)

    @cached_property
    def relative_velocity(self) -> Vector:
        """The velocity of the secondary relative to the primary, space axes."""
        return Vector(component / self.pair.reduced_mass for component in self.momentum)

    @property
    def without_rates(self) -> PairInstant:
        """Same instant without velocities and momenta, for formulas of energies."""
        return PairInstant(self.pair, self.attitudes, self.separation, self.environment)

    def with_attitude(self, number: int, attitude: Attitude) -> PairInstant:
        """Return the same without rates, and with another attitude of the primary, 0, or the secondary, 1."""
        attitudes = [attitude if place == number else own for place, own in enumerate(self.attitudes)]
        return PairInstant(self.pair, attitudes, self.separation, self.environment)

    def with_separation(self, separation: Vector) -> PairInstant:
        """Return the same without rates, and with another separation."""
        return PairInstant(self.pair, self.attitudes, separation, self.environment)

    def _of(self, number: int) -> Instant:
        """Return one of the bodies."""
        body = self.pair.bodies[BODIES[number]]
        place = _Displaced(self, self._levers[number])
        momentum, scale = self.angular_momenta[number], self.scales[number]
        return Instant(body, self.attitudes[number], place, angular_momentum_body=momentum, scale=scale)


class _Displaced(Environment):
    """The environment of one of the bodies, away from the barycentre by a part of the separation."""

    def __init__(self, instant: PairInstant, lever: Scalar) -> None:
        base = instant.environment
        super().__init__(base.time, base.blocks)
        self._base, self._instant, self._lever = base, instant, lever

    @override
    def position(self, orbit: Orbit) -> Vector:
        place: Vector = Vector(self._base.position(orbit)) + self._lever * self._instant.separation
        return place

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        velocity: Vector = Vector(self._base.velocity(orbit)) + self._lever * self._instant.relative_velocity
        return velocity

    @override
    def inverse_distance(self, orbit: Orbit) -> Scalar:
        return 1 / functions.norm(self.position(orbit))

    @override
    def direction(self, orbit: Orbit) -> Vector:
        inverse = self.inverse_distance(orbit)
        return Vector(x * inverse for x in self.position(orbit))


AnyInstant: TypeAlias = Instant | PairInstant
"""Instant of one or of two bodies."""
