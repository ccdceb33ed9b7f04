"""Energy, torque and vector field of a body under forces, in physical units and on scalars of any kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.functions import Scalar, Vector
from poinsot.lazy import cached_property
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.collection import Collection
from poinsot.mechanics.environment import Environment, EnvironmentOfStates, shared_blocks
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.part import CompositeBody, Part, named_parts
from poinsot.mechanics.state import State
from poinsot.printable import quoted
from poinsot.taylor.graph import Graph, gradient

__all__ = ["Dynamics", "Turning", "by_class", "scalars", "stacked"]


class Turning(NamedTuple):
    """How a body turns.

    Attributes
    ----------
    body : str
        What names in a phase begin with; empty for the one body of a system.
    attitude : Attitude
    omega, momentum_rate, torque : Vector
        Along the body axes; the last two times the scale of the instant.
    """

    body: str
    attitude: Attitude
    omega: Vector
    momentum_rate: Vector
    torque: Vector

    def rates(self) -> dict[str, Vector]:
        """Return the rates of the quaternion and of the angular momentum, by their names in a phase."""
        begin = f"{self.body}_" if self.body else ""
        q = quat.product(self.attitude.quaternion, quat.pure(self.omega))
        return {f"{begin}quaternion": Vector(0.5 * x for x in q), f"{begin}angular_momentum_body": self.momentum_rate}


class Dynamics(Collection):
    """The mechanics of a body and the forces on it, which `System` describes and checks."""

    body: Body
    forces: tuple[Force, ...]
    units: dict[str, str]

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """What is integrated along: `inner_blocks`, and the paths of orbits without a formula for kernels."""
        paths, _ = shared_blocks(self.orbits, lambda orbit: orbit.integrated)
        return (*self.inner_blocks, *paths)

    @property
    def inner_blocks(self) -> tuple[Block, ...]:
        """What is integrated along of the bodies: parts with variables."""
        return tuple([part for part in self.parts if part.size]) if self.parts else ()

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """What moves inside the body or on it, among the forces and within them."""
        return tuple(named_parts(self.forces).values())

    @property
    def jumping(self) -> tuple[Part, ...]:
        """The parts whose variables get new values at samples, in the order in which they do at one time."""
        return tuple([part for part in self.parts if part.jump is not None]) if self.parts else ()

    # ------------------------------------------------------------------ energy

    @checked
    def kinetic_energy(self, state: State) -> Any:
        """Return the kinetic energy of a state, eq. (9); shape (...)."""
        twin = self.beside(state.shape)
        with np.errstate(over="ignore"):
            return twin.kinetic_at(twin.at(state))

    @checked
    def potential_energy(self, state: State, environment: Environment | None = None) -> Any:
        """Return the sum of the energies of the potentials at a state; shape (...)."""
        shape = state.shape
        twin = self.beside(shape)
        return np.broadcast_to(twin.potential_at(twin.at(state, environment)), shape)[()]

    def validity(self, state: State, environment: Environment | None = None) -> dict[str, NDArray[np.bool_]]:
        """Return, by name, whether a formula is used at a state where it need not hold; each of shape (...)."""
        return self._of_forces(lambda force: force.validity, np.logical_or, state, environment)

    def relative_errors(self, state: State, environment: Environment | None = None) -> dict[str, NDArray[np.float64]]:
        """Return estimates of the relative errors of formulas, by their names in `validity`; each of shape (...)."""
        return self._of_forces(lambda force: force.relative_errors, np.maximum, state, environment)

    def limits(self, state: State, environment: Environment | None = None) -> dict[str, NDArray[np.bool_]]:
        """Return, by name, whether a quantity of a part or of a control law is at its limit; each of shape (...)."""
        return self._of_forces(lambda force: force.limits, np.logical_or, state, environment)

    def _of_forces(
        self, formula: Callable[[Force], Any], both: Any, state: State, environment: Environment | None
    ) -> dict[str, Any]:
        """Return what forces say at a state, by name; both of two that say the same name."""
        shape = state.shape
        twin = self.beside(shape)
        instant = twin.at(state, environment)
        out: dict[str, Any] = {}
        for name, value in (item for force in twin.forces for item in formula(force)(instant).items()):
            out[name] = both(np.broadcast_to(value, shape), out.get(name, value))
        return out

    @checked
    def omega_body(self, state: State) -> Any:
        """Return the inertial angular velocity along the body axes; shape (..., 3)."""
        return np.stack(list(self.beside(state.shape).at(state).omega_body), axis=-1)

    def speed(self, state: State) -> Any:
        """Return how fast the fastest of the bodies turns; shape (...)."""
        return np.hypot.reduce(self.omega_body(state), axis=-1)  # squares may overflow

    @checked
    def energy(self, state: State) -> Any:
        """Return kinetic plus potential energy, the Hamiltonian where there is one; shape (...)."""
        shape = state.shape
        twin = self.beside(shape)
        instant = twin.at(state)
        with np.errstate(over="ignore"):
            return twin.kinetic_at(instant) + np.broadcast_to(twin.potential_at(instant), shape)[()]

    # ------------------------------------------------------------------ equations of motion

    @checked
    def torque_body(self, state: State, environment: Environment | None = None) -> Any:
        """Return the sum of all torques at a state along the body axes; shape (..., 3)."""
        shape = state.shape
        twin = self.beside(shape)
        torque = twin.torque_at(twin.at(state, environment))
        return stacked(torque, shape)

    @checked
    def torques_body(self, state: State, environment: Environment | None = None) -> dict[str, NDArray[np.float64]]:
        """Return the torque of each force at a state along the body axes, by its class; each of shape (..., 3).

        Of several forces of one class the second one is "RadiationPressure 2", and so on.
        """
        shape = state.shape
        twin = self.beside(shape)
        return by_class(twin.each_torque_at(twin.at(state, environment)), shape)

    def at(self, state: State, environment: Environment | None = None) -> Instant:
        """Return the instant of a state, for formulas."""
        bodies = [
            (Attitude.from_quaternion(scalars(each.quaternion)), scalars(each.angular_momentum_body))
            for each in state.of_bodies.values()
        ]
        own = {name: scalars(values) for name, values in state.own.items()}
        twin = self.beside(state.shape) if any(record.member_axis for record in self.records) else self
        environment = environment or EnvironmentOfStates(state.time, len(state.shape))
        return twin.instant(bodies, own, environment)

    def instant(
        self,
        bodies: Sequence[tuple[Attitude, Vector]],
        own: Mapping[str, Vector],
        environment: Environment,
        scales: Sequence[Scalar] = (1, 1),
    ) -> Instant:
        """Return the instant of attitudes and angular momenta, times the scales, and of other variables by name."""
        ((attitude, g),) = bodies
        body = self.body_at(own, environment.time)
        return Instant(body, attitude, environment, angular_momentum_body=g, scale=scales[0])

    def body_at(self, own: Mapping[str, Vector], time: Scalar) -> Body:
        """Return the body with its parts, whose variables have values by the name of the part, at a time."""
        if not self.parts:
            return self.body
        self.check_variables({name: len(vector) for name, vector in own.items()})
        values = {part.name: own.get(part.name, Vector(())) for part in self.parts}
        return CompositeBody.of(self.body, self.parts, values, time)

    def check_variables(self, counts: Mapping[str, int]) -> None:
        """Raise a ValueError unless a state contains the variables of each part, counted by the name of the part."""
        for part in self.parts:
            if (count := counts.get(part.name, 0)) != part.size:
                raise ValueError(
                    f"state must have the {part.size} variables of the part {quoted(part.name)}, got {count}. "
                    "Make it by system.state(...)."
                )

    def rates(self, instant: Instant) -> dict[str, Vector]:
        """Return the vector field by block, in physical units.

        q' = q (0, omega)/2, g' = g x omega + tau along the body axes, times the scale of the instant; own' under the
        name of each part; and of the orbits whose variables the environment has, `orbits[0]` and so on.
        """
        turnings, blocks = self.changes(instant)
        return {name: value for each in turnings for name, value in each.rates().items()} | blocks

    def changes(self, instant: Instant) -> tuple[tuple[Turning, ...], dict[str, Vector]]:
        """Return how the bodies turn, and the time derivatives of all other variables by block."""
        return (self.turning(instant, self.torque_at(instant)),), self.block_rates(instant)

    def turning(self, instant: Instant, torque: Vector, body: str = "") -> Turning:
        """Return how a body turns under a torque along its axes, times the scale of the instant."""
        g = instant.scaled_momentum
        gyration = functions.cross(g, instant.omega_body) if self.parts else instant.scaled_kinetics.gyration(g)
        return Turning(body, instant.attitude, instant.omega_body, Vector(gyration) + torque, torque)

    def block_rates(self, instant: Instant) -> dict[str, Vector]:
        """Return the time derivatives of the variables of parts, by the name of the part, and of orbits."""
        moving = [part for part in self.parts if part.size]
        pulls = self._pulls(instant, moving)
        rates = {part.name: Vector(part.rates(instant, pulls[part.name])) for part in moving}
        return rates | self.orbit_rates(instant.environment)

    def orbit_rates(self, environment: Environment) -> dict[str, Vector]:
        """Return the time derivatives of the variables of orbits that the environment has."""
        orbits = (block.rates_at(environment.time, own) for block, own in environment.blocks)
        return {f"orbits[{i}]": Vector(each) for i, each in enumerate(orbits)}

    def _pulls(self, instant: Instant, moving: list[Part]) -> dict[str, Vector]:
        """Return minus the derivatives of the sum of the potentials by the variables of parts."""
        if not moving:
            return {}
        graph = Graph()
        own = {part.name: Vector(map(graph.variable, instant.own(part))) for part in moving}
        body = self.body_at(own, instant.time)
        energy = self.potential_at(Instant(body, instant.attitude, instant.environment))
        slopes = iter(graph.finished(gradient(energy, [x for each in own.values() for x in each])))
        return {part.name: Vector(-next(slopes) for _ in range(part.size)) for part in moving}

    def torque_at(self, instant: Instant) -> Vector:
        """Return the sum of all torques along the body axes, those of potentials derived, times the scale."""
        return sum((torque for _, torque in self.each_torque_at(instant)), start=functions.Vector((0.0, 0.0, 0.0)))

    def each_torque_at(self, instant: Instant) -> Iterator[tuple[Force, Vector]]:
        """Yield each force that has a torque, and this along the body axes, times the scale."""
        for force in self.forces:
            if isinstance(force, Potential):
                yield force, derived_torque(force, instant)
            elif isinstance(force, Torque):
                yield force, Vector(instant.scale * component for component in force.torque(instant))

    def kinetic_at(self, instant: Instant) -> Scalar:
        """Return the kinetic energy."""
        return instant.body.kinetic_energy(instant.angular_momentum_body)

    def potential_at(self, instant: Instant) -> Scalar:
        """Return the sum of the energies of the potentials."""
        return sum(force.energy(instant) for force in self.forces if isinstance(force, Potential))

    # ------------------------------------------------------------------ parameters

    @property
    @override
    def records(self) -> tuple[Parametric, ...]:
        return (self.body, *self.forces)

    @override
    def with_records(self, records: Iterable[Any]) -> Self:
        twin = object.__new__(type(self))
        body, *forces = records
        vars(twin).update(body=body, forces=tuple(forces), units=self.units)
        return twin


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
    return functions.Vector(np.moveaxis(np.asarray(array), -1, 0))
