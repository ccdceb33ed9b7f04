"""Energy and vector field of bodies under forces, in physical units and on scalars of any kind."""

from __future__ import annotations

import functools
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.errors import member_array
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import AnyState, Phase
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, EnvironmentOfStates, shared_blocks
from poinsot.mechanics.force import Force, Potential
from poinsot.mechanics.instant import Instant, InstantOfBodies
from poinsot.mechanics.kinetics import Kinetics
from poinsot.mechanics.part import Part, named_parts
from poinsot.printable import quoted
from poinsot.records.members import EveryMember
from poinsot.records.parameters import Parametric
from poinsot.suggestions import suggestion
from poinsot.systems.collection import Collection

__all__ = ["AnyDynamics", "Dynamics", "Start", "Turning", "Vectors", "by_class", "scalars", "stacked"]

Start: TypeAlias = Sequence[Any]
"""Attitude of one body; position, velocity and attitudes of two."""
Vectors: TypeAlias = Mapping[str, ArrayLike | Sequence[ArrayLike] | None]
"""Angular velocities or momenta by name, of which one is given."""

Bodies = TypeVar("Bodies", bound=Parametric)
Moment = TypeVar("Moment", bound=InstantOfBodies)


class Turning(NamedTuple):
    """Attitude of a body and its rates of change.

    Attributes
    ----------
    body : str
        Name of the body; empty for a single body.
    attitude : Attitude
    omega, momentum_rate, torque : Vector
        Along the body axes; the last two times the scale of the instant.
    """

    body: str
    attitude: Attitude
    omega: Vector
    momentum_rate: Vector
    torque: Vector

    @classmethod
    def of(cls, instant: Instant, torque: Vector, body: str = "") -> Turning:
        """Return the rates of a body under a torque along its axes, times the scale of the instant."""
        g, kinetics = instant.scaled_momentum, instant.scaled_kinetics
        gyration = kinetics.gyration(g) if isinstance(kinetics, Kinetics) else functions.cross(g, instant.omega_body)
        return cls(body, instant.attitude, instant.omega_body, Vector(gyration) + torque, torque)

    def rates(self) -> dict[str, Vector]:
        """Return the rates of the quaternion and of the angular momentum, by their names in a phase."""
        begin = f"{self.body}_" if self.body else ""
        q = quat.product(self.attitude.quaternion, quat.pure(self.omega))
        return {f"{begin}quaternion": Vector(0.5 * x for x in q), f"{begin}angular_momentum_body": self.momentum_rate}


class Dynamics(Collection, Generic[Bodies, Moment]):
    """Equations of motion of one or of two bodies under forces.

    A system describes and checks them. Twins on scalars of another kind have the same equations: symbols for a kernel,
    arrays for an ensemble, long floats for a reference.

    Parameters
    ----------
    body : Body or TwoBodies
    forces : tuple of Force
    """

    measures: ClassVar[tuple[str, ...]]
    """Quantities of the numbers, which have units."""
    moves_alone: ClassVar[bool] = True
    """True if the forces determine the motion."""
    numbering: NDArray[np.int_] | EveryMember = EveryMember()
    """Numbers that the members had in the ensemble from which they were selected."""

    body: Bodies
    of_bodies: Mapping[str, Body]
    """Rigid bodies by name; the name of a single body is empty."""
    forces: tuple[Force, ...]
    parts: tuple[Part, ...]
    """Moving parts among the forces and within them."""
    _seals: ClassVar[bool] = False

    def __init__(self, body: Bodies, forces: tuple[Force, ...]) -> None:
        super().__init__((body, *forces))
        self._name_records()

    @override
    def _name_records(self) -> None:
        body, *forces = self.records
        parts = tuple(named_parts(cast("list[Force]", forces)).values())
        vars(self).update(body=body, of_bodies=self.bodies_of(body), forces=tuple(forces), parts=parts)

    @staticmethod
    @abstractmethod
    def bodies_of(body: Any) -> Mapping[str, Body]:
        """Return the rigid bodies by name; the name of a single body is empty."""

    @staticmethod
    @abstractmethod
    def check_kinds(body: Any, forces: Iterable[Force]) -> None:
        """Raise a TypeError for a force of a class that a system of the body does not accept."""

    @abstractmethod
    def check_forces(self) -> None:
        """Raise an error for forces that belong to other bodies."""

    # ------------------------------------------------------------------ blocks of variables

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Integrated blocks: `inner_blocks`, and the orbits without a formula for kernels."""
        paths, _ = shared_blocks(self.orbits, lambda orbit: orbit.integrated)
        return (*self.inner_blocks, *paths)

    @property
    @abstractmethod
    def inner_blocks(self) -> tuple[Block, ...]:
        """Integrated blocks of the bodies: parts with variables, or the relative orbit."""

    @cached_property
    def jumping(self) -> tuple[Part, ...]:
        """Parts whose variables change at samples, in the order of their updates at one time."""
        return tuple([part for part in self.parts if part.jump is not None]) if self.parts else ()

    def numbered(self, count: int) -> NDArray[np.int_]:
        """Return the numbers of as many members in the ensemble that they were chosen from."""
        known = self.numbering
        return np.arange(count) if isinstance(known, EveryMember) or known.size != count else np.atleast_1d(known)

    @cached_property
    def _member_axes(self) -> dict[str, int]:
        own = ("body", "forces", "numbering") if self._draws else ("body", "forces") if self.members else ()
        return dict.fromkeys(own, 0)

    def _with_values(self, body: Bodies, forces: tuple[Force, ...], **numbering: NDArray[np.int_]) -> Self:
        dynamics = self.with_records((body, *forces))
        dynamics._complete(**numbering)
        return dynamics

    @property
    def _draws(self) -> bool:
        """True if a part draws random numbers, which depend on the numbering of the members."""
        return any(part.jump and part.jump.draws for part in self.parts)

    def check_variables(self, counts: Mapping[str, int]) -> None:
        """Raise a ValueError unless a state contains the variables of each part, counted by the name of the part."""
        for part in self.parts:
            if (count := counts.get(part.name, 0)) != part.size:
                raise ValueError(
                    f"state must have the {part.size} variables of the part {quoted(part.name)}, got {count}. "
                    "Make it by system.state(...)."
                )

    def given_parts(self, **own: ArrayLike) -> Phase:
        """Return the variables of parts that a user gives for an initial state, as arrays."""
        sizes = {part.name: part.size for part in self.parts if part.size}
        if unknown := [name for name in own if name not in sizes]:
            known = ", ".join(sizes) or "none"
            raise ValueError(
                f"own must name parts with variables, {known}, got {quoted(unknown[0])}."
                f"{suggestion(['state()'], unknown[0], sizes)}"
            )
        return {name: member_array(name, values, (sizes[name],)) for name, values in own.items()}

    @abstractmethod
    def state(
        self, place: Start, vectors: Vectors, time: ArrayLike, frame: Frame | str | None, own: Mapping[str, ArrayLike]
    ) -> AnyState:
        """Return the initial state of arguments that a user gives, see `System.state`."""

    # ------------------------------------------------------------------ formulas at an instant

    def check_bodies(self, state: AnyState) -> int:
        """Return the number of bodies, or raise a ValueError if the state has another one."""
        needed, given = len(self.of_bodies), len(state.body_names)
        if given != needed:
            made = "System.state or TwoBodies.state" if needed > 1 else "System.state or Body.state"
            words = {1: "one body", 2: "two bodies"}
            raise ValueError(f"state must be of {words[needed]}, as its system is, got {words[given]}. Take {made}.")
        return needed

    def at(self, state: AnyState, environment: Environment | None = None) -> Moment:
        """Return the instant of a state, for formulas."""
        self.check_bodies(state)
        bodies = [
            (Attitude.from_quaternion(scalars(each.quaternion)), scalars(each.angular_momentum_body))
            for each in state.of_bodies.values()
        ]
        own = {name: scalars(values) for name, values in state.own.items()}
        twin = self.broadcast_to(state.shape) if any(record.member_axis for record in self.records) else self
        environment = environment or EnvironmentOfStates(state.time, len(state.shape))
        return twin.instant(bodies, own, environment)

    @abstractmethod
    def instant(
        self,
        bodies: Sequence[tuple[Attitude, Vector]],
        own: Mapping[str, Vector],
        environment: Environment,
        scales: Sequence[Scalar] = (1, 1),
    ) -> Moment:
        """Return the instant of attitudes and angular momenta, times the scales, and of other variables by name."""

    def rates(self, instant: Moment) -> dict[str, Vector]:
        """Return the vector field by block, in physical units.

        q' = q (0, omega)/2, g' = g x omega + tau along the body axes, times the scale of the instant; own' under the
        name of each part; and the rates of the orbits whose variables the environment has, `orbits[0]` and so on.
        """
        turnings, blocks = self.changes(instant)
        return {name: value for each in turnings for name, value in each.rates().items()} | blocks

    @abstractmethod
    def changes(self, instant: Moment) -> tuple[tuple[Turning, ...], dict[str, Vector]]:
        """Return the rates of the bodies, and the time derivatives of all other variables by block."""

    def orbit_rates(self, environment: Environment) -> dict[str, Vector]:
        """Return the time derivatives of the variables of orbits that the environment has."""
        orbits = (block.rates_at(environment.time, own) for block, own in environment.blocks)
        return {f"orbits[{i}]": Vector(each) for i, each in enumerate(orbits)}

    @abstractmethod
    def kinetic_at(self, instant: Moment) -> Scalar:
        """Return the kinetic energy."""

    def potential_at(self, instant: Moment) -> Scalar:
        """Return the sum of the energies of the potentials."""
        at: Any = instant
        return sum(force.energy(at) for force in self.forces if isinstance(force, Potential))

    @abstractmethod
    def each_torque_at(self, instant: Moment, body: str) -> Iterator[tuple[Force, Vector]]:
        """Yield each force that has a torque on a body, and the torque along the body axes, times the scale."""

    @abstractmethod
    def each_force_at(self, instant: Moment, body: str) -> Iterator[tuple[Force, Vector]]:
        """Yield each force, and its push on a body along the space axes."""

    @abstractmethod
    def name_of_body(self, body: str | None) -> str:
        """Return the name of the body that an argument means, or raise a ValueError."""

    # ------------------------------------------------------------------ values at states

    def speed(self, state: AnyState) -> NDArray[np.float64]:
        """Return the angular speed of the fastest body; shape (...)."""
        each = (self.omega_body(state, name) for name in self.of_bodies)
        return functools.reduce(np.maximum, (np.hypot.reduce(omega, axis=-1) for omega in each))  # squares may overflow

    def omega_body(self, state: AnyState, body: str | None = None) -> NDArray[np.float64]:
        """Return the inertial angular velocity of a body along its axes; shape (..., 3)."""
        instant = self.broadcast_to(state.shape).at(state).of_bodies[self.name_of_body(body)]
        return stacked(instant.omega_body, state.shape)

    def energy(self, state: AnyState) -> NDArray[np.float64]:
        """Return kinetic plus potential energy; shape (...)."""
        shape = state.shape
        twin = self.broadcast_to(shape)
        instant = twin.at(state)
        with np.errstate(over="ignore"):
            total: Any = twin.kinetic_at(instant) + np.broadcast_to(np.asarray(twin.potential_at(instant)), shape)[()]
        return total  # type: ignore[no-any-return]


AnyDynamics: TypeAlias = Dynamics[Any, Any]
"""Equations of motion of one or of two bodies."""


def by_class(each: Iterable[tuple[Force, Vector]], shape: tuple[int, ...]) -> dict[str, NDArray[np.float64]]:
    """Return the vectors of forces as arrays (..., 3), by the class of the force; the second one is "Class 2"."""
    out = dict[str, NDArray[np.float64]]()
    for force, vector in each:
        kind = type(force).__name__
        count = sum(name.partition(" ")[0] == kind for name in out)
        out[f"{kind} {count + 1}" if count else kind] = stacked(vector, shape)
    return out


def stacked(vector: Iterable[Any], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return scalars, arrays that broadcast to a shape, as the last axis of an array."""
    return np.stack([np.broadcast_to(component, shape) for component in vector], axis=-1)


def scalars(array: ArrayLike) -> Vector:
    """Return the last axis of an array as the scalars of a formula."""
    return functions.Vector(quat.components(array))
