"""Equations of motion of one body with its parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.immutable import ReadOnlyDict, cached_property
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import State, state_with
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body, started
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Force, PairLoad, Potential, Torque, derived_torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import CompositeBody, Part, check_parts
from poinsot.printable import described, quoted
from poinsot.systems.dynamics import Dynamics, Start, Turning, Vectors, scalars, stacked
from poinsot.taylor.graph import Graph, gradient

__all__ = ["BodyDynamics"]


class BodyDynamics(Dynamics[Body, Instant]):
    """Equations of motion of one body: q' = q (0, omega) / 2, g' = g x omega + torques, and the rates of its parts."""

    measures: ClassVar[tuple[str, ...]] = ("time", "inertia")

    @staticmethod
    @override
    def bodies_of(body: Body) -> Mapping[str, Body]:
        return ReadOnlyDict({"": body})

    @staticmethod
    @override
    def check_kinds(body: Body, forces: Iterable[Force]) -> None:
        for force in forces:
            if isinstance(force, PairLoad):
                force.check(body)
            if not isinstance(force, Potential | Torque | Part):
                hint = " Give them one by one: System(body, *forces)." if isinstance(force, list | tuple) else ""
                raise TypeError(f"a force must be a Potential, a Torque or a Part, got {described(force)}.{hint}")

    @override
    def check_forces(self) -> None:
        check_parts(self.body, self.forces)
        body = self.body
        if self.parts:
            own = {part.name: Vector((1.0,) * part.size) for part in self.parts}  # no variable is zero
            body = CompositeBody.of(body, self.with_numbers(self.numbers).parts, own, 0.0)
        for force in self.forces:
            force.check(body)

    @cached_property
    @override
    def inner_blocks(self) -> tuple[Block, ...]:
        return tuple([part for part in self.parts if part.size]) if self.parts else ()

    @override
    def name_of_body(self, body: str | None) -> str:
        if body:
            raise ValueError(f"body must not be given for a system of one body, got {quoted(body)}. Leave it out.")
        return ""

    # ------------------------------------------------------------------ states

    @override
    def state(
        self, place: Start, vectors: Vectors, time: ArrayLike, frame: Frame | str | None, own: Mapping[str, ArrayLike]
    ) -> State:
        if len(place) != 1:
            raise TypeError(
                f"state() of one body must have one argument without a name, the attitude, got {len(place) or 'none'}."
            )
        values = self.given_parts(**own)
        q, name, along = started(place[0], dict(vectors), time, frame)
        counts = [array.shape[:-1] for array in values.values()]
        shape = np.broadcast_shapes(along.shape[:-1], np.shape(time), self.members, *counts)
        if not name.startswith("omega"):
            if left := [part.name for part in self.parts if part.size and part.name not in values]:
                raise ValueError(
                    f"own must name all parts where a momentum is given, got none of {quoted(left[0])}. Give "
                    f"omega_body."
                )
            return state_with(q, along, time, values)
        twin, rate = self.broadcast_to(shape), scalars(along)
        for part in twin.parts:
            if part.size and part.name not in values:
                values[part.name] = stacked(part.start(np.asarray(time, dtype=float), rate), shape)
        values = {part.name: values[part.name] for part in self.parts if part.size}
        body = twin.body_at({name: scalars(array) for name, array in values.items()}, cast("Scalar", time))
        return state_with(q, stacked(body.angular_momentum(rate), shape), time, values)

    # ------------------------------------------------------------------ formulas

    @override
    def instant(
        self,
        bodies: Sequence[tuple[Attitude, Vector]],
        own: Mapping[str, Vector],
        environment: Environment,
        scales: Sequence[Scalar] = (1, 1),
    ) -> Instant:
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

    def body_in_rotation(self, time: Scalar, omega: Vector) -> Body:
        """Return the body with its parts at their initial values for an angular velocity."""
        own = {part.name: Vector(x + 0.0 * time for x in part.start(time, omega)) for part in self.parts}
        return self.body_at(own, time)

    @override
    def changes(self, instant: Instant) -> tuple[tuple[Turning, ...], dict[str, Vector]]:
        return (Turning.of(instant, self.torque_at(instant)),), self.block_rates(instant)

    def block_rates(self, instant: Instant) -> dict[str, Vector]:
        """Return the time derivatives of the variables of parts, by the name of the part, and of orbits."""
        moving = [part for part in self.parts if part.size]
        pulls = self._pulls(instant, moving)
        rates = {part.name: Vector(part.rates(instant, pulls[part.name])) for part in moving}
        return rates | self.orbit_rates(instant.environment)

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

    @override
    def kinetic_at(self, instant: Instant) -> Scalar:
        return instant.body.kinetic_energy(instant.angular_momentum_body)

    def torque_at(self, instant: Instant) -> Vector:
        """Return the sum of all torques along the body axes, times the scale."""
        return sum((torque for _, torque in self.each_torque_at(instant)), start=functions.Vector((0.0, 0.0, 0.0)))

    @override
    def each_torque_at(self, instant: Instant, body: str = "") -> Iterator[tuple[Force, Vector]]:
        for force in self.forces:
            if isinstance(force, Potential):
                yield force, derived_torque(force, instant)
            elif isinstance(force, Torque):
                yield force, Vector(instant.scale * component for component in force.torque(instant))

    @override
    def each_force_at(self, instant: Instant, body: str) -> Iterator[tuple[Force, Vector]]:
        raise TypeError(
            "system must be of two bodies to have forces along the space axes, got one body, whose orbit is given."
        )
