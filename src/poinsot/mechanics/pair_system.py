"""Two bodies and the forces on them: energy, equations of motion, integrals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.lazy import cached_property
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.circular_pair import mean_motion
from poinsot.mechanics.dynamics import Turning, by_class, stacked
from poinsot.mechanics.environment import Environment, orbits_of, sample_time
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, Load, PairLoad, Potential, PotentialOn, TorqueOn, torque_of
from poinsot.mechanics.formula_trials import PAIR, try_event, try_pair_force
from poinsot.mechanics.integrals import Integral
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.pair_integrals import integrals_of_pair
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.part import parts_of
from poinsot.mechanics.state import PairState, State
from poinsot.mechanics.system import System
from poinsot.mechanics.two_bodies import BODIES, TwoBodies, check_name_of_body
from poinsot.printable import described, quoted
from poinsot.taylor.graph import Graph, gradient

__all__ = ["ORBIT", "OfOneBody", "PairSystem", "TwoBodies"]

NOTHING = Vector((0.0, 0.0, 0.0))


class RelativeOrbit(Block):
    """Position and momentum of the secondary relative to the primary."""

    variables: ClassVar[Mapping[str, int]] = {"position": 3, "momentum": 3}


ORBIT = RelativeOrbit(name="orbit")


class PairSystem(System, of=TwoBodies):
    """Two rigid bodies under forces: what `System(TwoBodies(...), *forces)` makes.

    Parameters
    ----------
    body : TwoBodies
    *forces : Potential or PairLoad
        Those of one body on one of the two: `force.on("secondary")`.
    units : mapping, optional
        As for `System`, and that of `length`: `{"time": "s", "inertia": "kg m2", "length": "m"}`.
    """

    measures: ClassVar[tuple[str, ...]] = ("time", "inertia", "length")
    body_names: ClassVar[tuple[str, ...]] = BODIES
    body: Any

    # ------------------------------------------------------------------ what it is made of

    @property
    def pair(self) -> TwoBodies:
        """The two bodies."""
        pair: TwoBodies = self.body
        return pair

    @property
    @override
    def rigid_bodies(self) -> tuple[Body, ...]:
        return tuple(self.pair.bodies.values())

    @property
    @override
    def inner_blocks(self) -> tuple[Block, ...]:
        return (ORBIT,)

    @override
    def _check_kinds(self) -> None:
        for force in self.forces:
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
    def _check(self) -> None:
        for force in self.forces:
            force.check(self.pair)
            try_pair_force(force, self._trial(force), self.derived_load)

    @override
    def try_event(self, event: Event) -> None:
        try_event(event, self._trial(event))

    def _trial(self, record: Force | Event) -> PairInstant:
        """Return the first member's bodies on arrays of two values, for trials of formulas."""
        twin = self.with_numbers(np.ravel(number)[0] * PAIR for number in self.numbers).pair
        attitudes = [Attitude.from_quaternion(Vector(q.T)) for q in ATTITUDES]
        n = mean_motion(twin, self.sample_distance)
        position = Vector(self.sample_distance * x for x in np.array([[0.6, 0.0], [0.8, -0.6], [0.0, 0.8]]))
        momentum = Vector(0.5 * twin.reduced_mass * self.sample_distance * n * x for x in (-0.8, 0.6, 0.1))
        own = [Vector(body.angular_momentum(Vector(n * x for x in (0.1, 0.2, 0.9)))) for body in twin.bodies.values()]
        environment = Environment(sample_time(orbits_of(record)) + 0.25 * PAIR)
        return PairInstant(twin, attitudes, position, environment, momentum, own)

    @cached_property
    def sample_distance(self) -> float:
        """A distance at which formulas may be tried: several times the size of the bodies."""
        sizes = [
            np.sqrt(np.max(np.asarray(body.moments).reshape(-1, 3)[0]) / np.ravel(mass)[0])
            for body, mass in zip(self.pair.bodies.values(), self.pair.each_mass, strict=True)
        ]
        return 8.0 * float(sum(sizes))

    # ------------------------------------------------------------------ states

    @override
    def state(self, *arguments: Any, **named: Any) -> PairState:
        """Return the state of the two bodies: see `TwoBodies.state`."""
        return self.pair.state(*arguments, **named)

    @override
    def omega_body(self, state: State, body: str | None = None) -> Any:
        """Return the inertial angular velocity of one body along its axes; shape (..., 3)."""
        instant: Any = self.beside(state.shape).at(state)
        return stacked((instant.primary, instant.secondary)[place_of(body)].omega_body, state.shape)

    @override
    def torque_body(self, state: State, environment: Environment | None = None, body: str | None = None) -> Any:
        """Return the sum of all torques on one body, "primary" or "secondary", along its axes; shape (..., 3)."""
        return self._total(self.torques_body(state, environment, body), state)

    @override
    def torques_body(self, state: State, environment: Environment | None = None, body: str | None = None) -> Any:
        """Return the torque of each force on one body along its axes, by the class of the force; each (..., 3)."""
        place = place_of(body)
        return self._by_class(state, environment, lambda load: load.torques[place])

    def force_space(self, state: State, environment: Environment | None = None, body: str | None = None) -> Any:
        """Return the sum of all forces on one body along the space axes; shape (..., 3): see `forces_space`."""
        return self._total(self.forces_space(state, environment, body), state)

    def forces_space(self, state: State, environment: Environment | None = None, body: str | None = None) -> Any:
        """Return each force on one body along the space axes, by its class; each of shape (..., 3).

        The forces on the two bodies are opposite. An attractor outside of the pair also accelerates the barycentre;
        its force here is the force relative to the barycentre.
        """
        if place_of(body):
            return self._by_class(state, environment, lambda load: load.force)
        return self._by_class(state, environment, lambda load: Vector(0.0 - component for component in load.force))

    def _by_class(
        self, state: State, environment: Environment | None, part: Callable[[Load], Vector]
    ) -> dict[str, NDArray[np.float64]]:
        twin = self.beside(state.shape)
        each = twin.each_load_at(twin.at(state, environment))
        return by_class(((force, part(load)) for force, load in each), state.shape)

    @staticmethod
    def _total(each: dict[str, NDArray[np.float64]], state: State) -> NDArray[np.float64]:
        return sum(each.values(), start=np.zeros((*state.shape, 3)))

    @override
    def speed(self, state: State) -> Any:
        instant: Any = self.beside(state.shape).at(state)
        return np.maximum(*(functions.norm(each.omega_body) for each in (instant.primary, instant.secondary)))

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
        return PairInstant(self.pair, attitudes, orbit[:3], environment, orbit[3:], momenta, scales)

    @override
    def kinetic_at(self, instant: Any) -> Scalar:
        """Return the kinetic energy of the relative motion, p^2 / (2 mu), and of both rotations."""
        turning = sum(
            each.body.kinetic_energy(each.angular_momentum_body) for each in (instant.primary, instant.secondary)
        )
        return functions.dot(instant.momentum, instant.momentum) / (2 * instant.pair.reduced_mass) + turning

    @override
    def changes(self, instant: Any) -> tuple[tuple[Turning, ...], dict[str, Vector]]:
        load = self.load_at(instant)
        each = zip((instant.primary, instant.secondary), load.torques, BODIES, strict=True)
        orbit = {ORBIT.name: Vector((*instant.relative_velocity, *load.force))}
        return tuple(self.turning(*one) for one in each), orbit | self.orbit_rates(instant.environment)

    def load_at(self, instant: Any) -> Load:
        """Return the force on the secondary, space axes, and both torques, body axes and times the scales."""
        force, first, second = self.derived_load(self.potential_at, instant)
        total = [force, first, second]
        for loading in (force for force in self.forces if isinstance(force, PairLoad)):
            load = loading.load(instant)
            torques = (scale * Vector(torque) for scale, torque in zip(instant.scales, load.torques, strict=True))
            total = [x + y for x, y in zip(total, (Vector(load.force), *torques), strict=True)]
        return Load(total[0], (total[1], total[2]))

    def each_load_at(self, instant: Any) -> Iterator[tuple[Force, Load]]:
        """Yield each force, or the force of one body that acts on one of the two, and its load."""
        for force in self.forces:
            if isinstance(force, PairLoad):
                load = force.load(instant)
            else:
                whole, *torques = self.derived_load(force.energy, instant)  # type: ignore[attr-defined]
                load = Load(whole, (torques[0], torques[1]))
            yield force.force if isinstance(force, PotentialOn | TorqueOn) else force, load

    def acceleration(self, state: PairState, environment: Environment | None = None) -> NDArray[np.float64]:
        """Return that of the secondary relative to the primary at a state, space axes; shape (..., 3)."""
        twin = self.beside(state.shape)
        force = twin.load_at(twin.at(state, environment)).force
        return np.stack([np.broadcast_to(x / twin.pair.reduced_mass, state.shape) for x in force], axis=-1)

    @staticmethod
    def derived_load(energy: Any, instant: PairInstant) -> tuple[Vector, Vector, Vector]:
        """Return force and torques of an energy, a function of an instant: its derivatives."""
        graph = Graph()
        separation = Vector(map(graph.variable, instant.separation))
        slopes = graph.finished(gradient(energy(instant.with_separation(separation)), list(separation)))

        def of_attitude(number: int) -> Vector:
            return torque_of(
                lambda attitude: energy(instant.with_attitude(number, attitude)),
                instant.attitudes[number],
                instant.scales[number],
            )

        return -Vector(slopes), of_attitude(0), of_attitude(1)

    @cached_property
    @override
    def integrals(self) -> tuple[Integral, ...]:
        return integrals_of_pair(self)


def place_of(body: str | None) -> int:
    """Return 0 for the primary and 1 for the secondary, or raise a ValueError."""
    return BODIES.index(check_name_of_body(body))


def _of_one_body(name: str, system: Any) -> Any:
    if isinstance(system, PairSystem) or not getattr(system, "moves_alone", True):
        raise TypeError(
            f"{name} must be a System of one body, got one of two bodies. These have propagate, state_transition, "
            "chaos_indicators, lyapunov_spectrum, periodic_motion and pair_equilibria."
        )
    return system


OfOneBody = Annotated[System, _of_one_body]
"""A system of one body, said by an annotation."""

ATTITUDES = np.array([[[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]], [[0.1, 0.7, -0.1, 0.7], [0.5, 0.5, 0.5, -0.5]]])
