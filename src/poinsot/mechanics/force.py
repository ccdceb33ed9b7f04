"""Forces on a body: potentials (one energy formula) and torques (one torque formula).

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method
its physics. The base class makes it a frozen dataclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, NamedTuple

from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.kinematics.attitude import Attitude, matrix_of, rotation_matrix
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.two_bodies import check_name_of_body
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Parametric
from poinsot.taylor.graph import Graph, Node, gradient

__all__ = ["Load", "PairLoad", "Potential", "Torque"]


class Force(Parametric, ABC):
    """Base of the forces on bodies: potentials, torques, loads on two bodies, and parts."""

    formula: ClassVar[str] = ""
    """Formula of the class in Python, for readers. By default the traced formula is shown if it is short."""

    def check(self, body: Any) -> None:
        """Raise a ValueError if the force is that on another body, one or two; a system asks once, when it is made."""

    @of_scalars
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return, by name, whether the formula is used where it need not hold: a result counts these times."""
        return {}

    @of_scalars
    def relative_errors(self, instant: Instant) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return estimates of the relative error of the formula, by the names in `validity` that they cause."""
        return {}

    @of_scalars
    def limits(self, instant: Instant, torque: Vector | None = None) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return, by name, whether a quantity is at its limit: the summary of a motion counts these times.

        `torque` is the torque of a control law that a sample holds; by default the torque at the instant.
        """
        return {}

    def on(self, body: str) -> Force:  # noqa: ARG002
        """Return the same force on one of two bodies, "primary" or "secondary"."""
        raise TypeError(f"a force on one of two bodies must be a Potential or a Torque, got {type(self).__name__}.")


class Potential(Force):
    """Conservative force, given by its potential energy; poinsot derives the torque.

    A subclass defines `energy(instant)`, a formula of body-frame vectors. The torque is N = -(dU / d rotation), along
    the body axes.

    Examples
    --------
    >>> class Magnet(pt.Potential):
    ...     moment: pt.BodyVector
    ...     field: pt.SpaceVector
    ...     def energy(self, instant):
    ...         return -pt.functions.dot(self.moment, instant.attitude.to_body(self.field))
    >>> system = pt.System(pt.Body((1, 2, 2.5)), Magnet((1, 0, 0), (0, 0, 2)))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0)))
    array([ 0., -2.,  0.])
    """

    moves_orbit: ClassVar[bool] = True
    """True if the energy contains every term that depends on the position of the body."""

    @of_scalars
    @abstractmethod
    def energy(self, instant: Instant) -> Scalar:
        """Return the potential energy. `instant.attitude.to_body(u)` transforms a space vector u to the body axes."""

    @override
    def on(self, body: str) -> Potential:
        self.refuse_moved_orbit()
        return PotentialOn(self, body)

    def refuse_moved_orbit(self) -> None:
        """Raise a ValueError if the energy leaves out what moves the orbit of two bodies."""
        if not self.moves_orbit:
            raise ValueError(
                f"{type(self).__name__} must be for one body, whose orbit is given, got one of two: it leaves out "
                "parts that move their orbit. Take ThirdBody(orbit)."
            )


class Torque(Force):
    """Torque without a potential, given by one formula with three components along the body axes.

    A subclass defines `torque(instant)`. The torque N enters the equation g' = g x omega + N.

    Examples
    --------
    >>> class Spring(pt.Torque):
    ...     stiffness: float
    ...     def torque(self, instant):
    ...         return pt.functions.cross((0, 0, self.stiffness), instant.attitude.to_body((0, 0, 1)))
    >>> Spring(0.2)
    Spring(stiffness=0.2)
    """

    @of_scalars
    @abstractmethod
    def torque(self, instant: Instant) -> Any:
        """Return the torque along the body axes, three scalars."""

    @override
    def on(self, body: str) -> PairLoad:
        return TorqueOn(self, body)


class Load(NamedTuple):
    """Force and torques on two bodies.

    Attributes
    ----------
    force : Vector
        Force on the secondary, space axes. The opposite force acts on the primary.
    torques : two of Vector
        Torques on primary and secondary, each about the centre of mass and along the axes of the body.

    Examples
    --------
    >>> nothing = pt.functions.Vector((0.0, 0.0, 0.0))
    >>> pt.mechanics.Load(pt.functions.Vector((0.0, -0.5, 0.0)), (nothing, nothing)).force[1]
    -0.5
    """

    force: Vector
    torques: tuple[Vector, Vector]


NOTHING = Vector((0.0, 0.0, 0.0))


class PairLoad(Force):
    """Force and torques on two bodies without a potential, given by one formula.

    A subclass defines `load(instant)`. The force F accelerates the separation: F = reduced mass times relative
    acceleration.

    Examples
    --------
    >>> class Drag(pt.mechanics.PairLoad):
    ...     friction: float
    ...     def load(self, instant):
    ...         nothing = pt.functions.Vector((0.0, 0.0, 0.0))
    ...         return pt.mechanics.Load(-self.friction * instant.relative_velocity, (nothing, nothing))
    >>> Drag(0.2)
    Drag(friction=0.2)
    """

    @of_scalars
    @abstractmethod
    def load(self, instant: PairInstant) -> Load:
        """Return the load of the force at an instant of two bodies."""


class _On(Force):
    """A force of one body on one of two."""

    force: Force
    body: str

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name_of_body(self.body)

    @override
    def __repr__(self) -> str:
        return f"{self.force!r}.on({self.body!r})"

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        name, fields = self.force.definition
        return name, fields | {"on": self.body}

    @override
    def check(self, body: Any) -> None:
        if not hasattr(body, self.body):
            raise ValueError(f"a system of one body must have forces without `on`, got {quoted(self)}. Leave it out.")
        self.force.check(getattr(body, self.body))

    @override
    def validity(self, instant: Any) -> Mapping[str, Scalar]:
        return self.force.validity(getattr(instant, self.body))

    @override
    def relative_errors(self, instant: Any) -> Mapping[str, Scalar]:
        return self.force.relative_errors(getattr(instant, self.body))

    @override
    def limits(self, instant: Any, torque: Vector | None = None) -> Mapping[str, Scalar]:
        return self.force.limits(getattr(instant, self.body), torque)


class PotentialOn(_On, Potential):
    """A potential of one body on one of two; made by `potential.on("secondary")`."""

    force: Potential

    @override
    def energy(self, instant: Any) -> Scalar:
        return self.force.energy(getattr(instant, self.body))


class TorqueOn(_On, PairLoad):
    """A torque of one body on one of two; made by `torque.on("secondary")`."""

    force: Torque

    @override
    def load(self, instant: Any) -> Load:
        torque = Vector(self.force.torque(getattr(instant, self.body)))
        return Load(NOTHING, (torque, NOTHING) if self.body == "primary" else (NOTHING, torque))


class _Recorder(Attitude):
    """An attitude of which all that a formula reads is a variable."""

    def __init__(self, attitude: Attitude) -> None:
        self._attitude, self.comoving = attitude, attitude.comoving
        self.graph = Graph()
        self.seen: list[list[Node]] = []

    @cached_property
    def turn(self) -> Vector:  # type: ignore[override]
        return Vector(self.graph.variable(0.0) for _ in range(3))

    @property
    @override
    def at_rest(self) -> Attitude:
        return self._attitude

    @property
    @override
    def components(self) -> Iterable[Scalar]:
        return self._attitude.components

    @cached_property
    @override
    def matrix(self) -> Array:
        return matrix_of(map(self.to_body, UNITS))

    @cached_property
    @override
    def quaternion(self) -> Vector:
        return self._read(self._attitude.quaternion)

    @override
    def to_body(self, vector: Iterable[Scalar]) -> Vector:
        return self._read(self._attitude.to_body(vector))

    @override
    def to_space(self, vector: Iterable[Scalar]) -> Vector:
        x = Vector(vector)
        return self._in_space(functions.dot(self.to_body(self._in_space(unit)), x) for unit in UNITS)

    @override
    def turned(self, quaternion: Vector) -> Attitude:
        own = quat.product(self.quaternion, Vector(quaternion))
        return Attitude(self.matrix @ rotation_matrix(quaternion), self.comoving, own)

    def _read(self, scalars: Vector) -> Vector:
        self.seen.append(list(map(self.graph.variable, scalars)))
        return Vector(self.seen[-1])


UNITS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def derived_torque(potential: Potential, instant: Instant) -> Vector:
    """Return the torque of a potential along the body axes, times the scale of the instant."""

    def energy(attitude: Attitude) -> Scalar:
        return potential.energy(Instant(instant.body, attitude, instant.environment))

    return torque_of(energy, instant.attitude, instant.scale)


def torque_of(energy: Callable[[Attitude], Scalar], attitude: Attitude, scale: Scalar) -> Vector:
    """Return the torque of an energy that depends on an attitude: the sum over u of u_body x dV/du_body, times a scale.

    A space vector u turns in body axes as u' = u x omega, so that V' = -tau . omega; the quaternion turns as
    q' = q (0, omega)/2, and gives -vec(q~ dV/dq)/2.
    """
    recorder = _Recorder(attitude)
    value = energy(recorder)
    by = [*recorder.turn, *(x for each in recorder.seen for x in each)]
    slopes = iter(recorder.graph.finished(gradient(value, by)))
    total = Vector(-scale * next(slopes) for _ in range(3))
    for each in recorder.seen:
        seen = Vector(x.value for x in each)
        slope = [scale * next(slopes) for _ in each]
        total = total + (functions.cross(seen, slope) if len(seen) == 3 else _turning(seen, slope))
    return total


def _turning(quaternion: Vector, slope: list[Scalar]) -> Vector:
    return Vector(-0.5 * x for x in quat.imaginary(quat.product(quat.conjugate(quaternion), Vector(slope))))
