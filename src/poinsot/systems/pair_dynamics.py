"""Equations of motion of two bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.immutable import ReadOnlyDict, cached_property
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import AnyState, PairState
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Force, Load, PairLoad, Potential, PotentialOn, TorqueOn, torque_of
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.part import parts_of
from poinsot.mechanics.two_bodies import BODIES, TwoBodies, check_name_of_body
from poinsot.printable import described, quoted
from poinsot.records.parameters import Parametric
from poinsot.systems.dynamics import Dynamics, Start, Turning, Vectors, stacked
from poinsot.taylor.graph import Graph, gradient

__all__ = ["ORBIT", "PairDynamics", "acceleration"]


class RelativeOrbit(Block):
    """Position and momentum of the secondary relative to the primary."""

    variables: ClassVar[Mapping[str, int]] = {"position": 3, "momentum": 3}


ORBIT = RelativeOrbit(name="orbit")


class PairDynamics(Dynamics[TwoBodies, PairInstant]):
    """Equations of motion of two bodies: the rotation of each, and the relative orbit."""

    measures: ClassVar[tuple[str, ...]] = ("time", "inertia", "length")

    @staticmethod
    @override
    def bodies_of(body: TwoBodies) -> Mapping[str, Body]:
        return ReadOnlyDict(body.bodies)

    @staticmethod
    @override
    def check_kinds(body: TwoBodies, forces: Iterable[Force]) -> None:
        for force in forces:
            for part in parts_of(force) if isinstance(force, Parametric) else ():
                raise TypeError(
                    f"forces on two bodies must have no parts, got {type(part).__name__} in {quoted(force)}."
                )
            if not isinstance(force, Potential | PairLoad):
                raise TypeError(
                    "a force on two bodies must be a Potential, a PairLoad or a force on one of them, got "
                    f'{described(force)}. Write force.on("primary") or force.on("secondary").'
                )
            if isinstance(force, Potential):
                force.refuse_moved_orbit()

    @override
    def check_forces(self) -> None:
        for force in self.forces:
            force.check(self.body)

    inner_blocks: ClassVar[tuple[Block, ...]] = (ORBIT,)

    @override
    def name_of_body(self, body: str | None) -> str:
        return check_name_of_body(body)

    @cached_property
    def sample_distance(self) -> float:
        """Distance for trials of formulas: eight times the sum of the radii of gyration."""
        sizes = [
            np.sqrt(np.max(np.asarray(body.moments).reshape(-1, 3)[0]) / np.ravel(mass)[0])
            for body, mass in zip(self.of_bodies.values(), self.body.each_mass, strict=True)
        ]
        return 8.0 * float(sum(sizes))

    @override
    def state(
        self, place: Start, vectors: Vectors, time: ArrayLike, frame: Frame | str | None, own: Mapping[str, ArrayLike]
    ) -> PairState:
        of_two: Callable[..., PairState] = self.body.state
        return of_two(*place, **vectors, time=time, frame=frame, **own)

    # ------------------------------------------------------------------ formulas

    @override
    def instant(
        self,
        bodies: Sequence[tuple[Attitude, Vector]],
        own: Mapping[str, Vector],
        environment: Environment,
        scales: Sequence[Scalar] = (1, 1),
    ) -> PairInstant:
        attitudes, momenta = zip(*bodies, strict=True)
        orbit = own[ORBIT.name]
        return PairInstant(self.body, attitudes, orbit[:3], environment, orbit[3:], momenta, scales)

    @override
    def kinetic_at(self, instant: PairInstant) -> Scalar:
        """Return the kinetic energy of the relative motion, p^2 / (2 mu), and of both rotations."""
        turning = sum(each.body.kinetic_energy(each.angular_momentum_body) for each in instant.of_bodies.values())
        return functions.dot(instant.momentum, instant.momentum) / (2 * instant.pair.reduced_mass) + turning

    @override
    def changes(self, instant: PairInstant) -> tuple[tuple[Turning, ...], dict[str, Vector]]:
        load = self.load_at(instant)
        each = zip(instant.of_bodies.items(), load.torques, strict=True)
        orbit = {ORBIT.name: Vector((*instant.relative_velocity, *load.force))}
        turnings = tuple(Turning.of(one, torque, body) for (body, one), torque in each)
        return turnings, orbit | self.orbit_rates(instant.environment)

    def load_at(self, instant: PairInstant) -> Load:
        """Return the force on the secondary, space axes, and both torques, body axes and times the scales."""
        derived = self.derived_load(self.potential_at, instant)
        total = [derived.force, *derived.torques]
        for loading in (force for force in self.forces if isinstance(force, PairLoad)):
            load = loading.load(instant)
            torques = (scale * Vector(torque) for scale, torque in zip(instant.scales, load.torques, strict=True))
            total = [x + y for x, y in zip(total, (Vector(load.force), *torques), strict=True)]
        return Load(total[0], (total[1], total[2]))

    def each_load_at(self, instant: PairInstant) -> Iterator[tuple[Force, Load]]:
        """Yield each force, or the force of one body that acts on one of the two, and its load."""
        for force in self.forces:
            load = force.load(instant) if isinstance(force, PairLoad) else self.derived_load(force.energy, instant)  # type: ignore[attr-defined]
            yield force.force if isinstance(force, PotentialOn | TorqueOn) else force, load

    @override
    def each_torque_at(self, instant: PairInstant, body: str) -> Iterator[tuple[Force, Vector]]:
        place = BODIES.index(body)
        return ((force, load.torques[place]) for force, load in self.each_load_at(instant))

    @override
    def each_force_at(self, instant: PairInstant, body: str) -> Iterator[tuple[Force, Vector]]:
        loads = self.each_load_at(instant)
        if body == "secondary":
            return ((force, load.force) for force, load in loads)
        return ((force, Vector(0.0 - component for component in load.force)) for force, load in loads)

    @staticmethod
    def derived_load(energy: Callable[[PairInstant], Scalar], instant: PairInstant) -> Load:
        """Return the load of a potential: force and torques are derivatives of its energy."""
        graph = Graph()
        separation = Vector(map(graph.variable, instant.separation))
        slopes = graph.finished(gradient(energy(instant.with_separation(separation)), list(separation)))

        def of_attitude(number: int) -> Vector:
            return torque_of(
                lambda attitude: energy(instant.with_attitude(number, attitude)),
                instant.attitudes[number],
                instant.scales[number],
            )

        return Load(-Vector(slopes), (of_attitude(0), of_attitude(1)))


def acceleration(
    dynamics: Dynamics[TwoBodies, PairInstant], state: AnyState, environment: Environment | None = None
) -> NDArray[np.float64]:
    """Return the acceleration of the secondary relative to the primary, space axes; shape (..., 3)."""
    twin = dynamics.broadcast_to(state.shape)
    _, rates = twin.changes(twin.at(state, environment))
    return stacked((x / twin.body.reduced_mass for x in rates[ORBIT.name][3:]), state.shape)
