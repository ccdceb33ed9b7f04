"""A motion as a file has it, whose forces are not at hand."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.immutable import Immutable
from poinsot.mechanics.body import Body
from poinsot.mechanics.dynamics import Dynamics
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.integrals import Integral
from poinsot.mechanics.state import AnyState, Phase, State
from poinsot.mechanics.system import System
from poinsot.printable import printable
from poinsot.propagation.dataset import StoredPart
from poinsot.propagation.event_record import EventsOfMembers
from poinsot.propagation.pair_trajectory import PairTrajectory
from poinsot.propagation.run_record import Run
from poinsot.propagation.selection import Chosen, numbers_of_members, state_of_members
from poinsot.propagation.trajectory import Rows, Trajectory

__all__ = ["Record", "StoredEnvironment", "StoredSystem", "StoredTrajectory", "stored_trajectory_class"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Record(Immutable):
    """What forces alone can tell of a motion, as it was when they were there."""

    potential_energy: Array
    integrals: Mapping[str, Array]
    drift: Mapping[str, Array]
    summary: Mapping[str, Any] = field(default_factory=dict)
    omega_body: Array | None = None
    kinetic_energy: Array | None = None
    """Of a body with parts: without their formulas they do not follow from the state."""


class StoredSystem(Immutable):
    """A body under forces of which a file has no more than their names: it cannot be run.

    Attributes
    ----------
    body : Body
    units : mapping
    not_rerunnable : str
        Why, in a sentence.
    integrals : tuple of Integral
        Those of the motion by name; their values are in the motion.
    parts : tuple of StoredPart
    """

    forces = ()
    records = ()
    orbits = ()
    members = ()
    calendar = None

    def __init__(
        self,
        body: Body,
        units: Mapping[str, str],
        written: str,
        reason: str,
        integrals: tuple[Integral, ...],
        parts: tuple[StoredPart, ...] = (),
    ) -> None:
        self.parts = parts
        self.body, self.integrals, self.not_rerunnable, self._written = body, integrals, reason, written
        self._free = System(body, units=units)
        self.units, self.of_bodies = self._free.units, self._free.of_bodies

    def __repr__(self) -> str:
        return printable(self._written, kept="\n")

    def of_members(self, members: Chosen) -> StoredSystem:
        """Return the body of some members."""
        body = numbers_of_members(self._free.body, members)
        parts = tuple(part.of_members(members) for part in self.parts)
        return StoredSystem(body, self.units, self._written, self.not_rerunnable, self.integrals, parts)

    @property
    def dynamics(self) -> StoredSystem:
        """The system itself, which has no equations of motion."""
        return self

    @property
    def jumping(self) -> tuple[StoredPart, ...]:
        """Parts whose variables jump, as a file describes them."""
        return tuple(part for part in self.parts if part.jump is not None)

    @property
    def numbers(self) -> tuple[Array, ...]:
        """Numbers of the body."""
        return self._free.dynamics.numbers

    def with_numbers(self, numbers: Iterable[Any]) -> Dynamics[Any, Any]:
        """Return the torque-free motion of the body with other numbers in their places."""
        self._refuse_parts("omega_body")
        return self._free.dynamics.with_numbers(numbers)

    def omega_body(self, state: State) -> Any:
        """Return the inertial angular velocity along the body axes; shape (..., 3)."""
        self._refuse_parts("omega_body")
        return self._free.omega_body(state)

    def validity(self, *_: Any) -> dict[str, Any]:
        """Return nothing: the ranges of its formulas are not known."""
        return {}

    def limits(self, *_: Any) -> dict[str, Any]:
        """Return nothing: the limits of its parts and control laws are not known."""
        return {}

    def torques_body(self, *_: Any) -> dict[str, Any]:
        """Return an empty dictionary: the formulas of the forces are unknown."""
        return {}

    forces_space = torques_body

    def kinetic_energy(self, state: State) -> Any:
        """Return the kinetic energy of a state; shape (...)."""
        self._refuse_parts("kinetic_energy")
        return self._free.kinetic_energy(state)

    def _refuse_parts(self, name: str) -> None:
        if self.parts:
            raise ValueError(
                f"{name} must have the parts of the body to be computed, got a file without. The motion has its values."
            )


class StoredEnvironment(Environment):
    """The environment at the times of a motion: orbits integrated along as they were stored."""

    def __init__(self, time: Array, values: Array) -> None:
        super().__init__(time)
        self._values = values

    @property
    @override
    def orbit_values(self) -> Array:
        return self._values


class StoredTrajectory(Trajectory):
    """A trajectory whose potential energy, integrals, drift and summary are those of its file."""

    def __init__(
        self,
        system: StoredSystem,
        initial: AnyState,
        times: Array,
        phase: Phase,
        run: Run,
        record: Record,
        environment: StoredEnvironment | None = None,
    ) -> None:
        known: Any = system
        super().__init__(
            known, initial, times, lambda: phase, run, environment=None if environment is None else lambda: environment
        )
        self._record = record

    @override
    def _made_of(self, members: Chosen | None, rows: Rows, times: Array, phase: Phase) -> StoredTrajectory:
        system: Any = self.system
        initial, known, source = self.initial, self._record, self.event_source
        if members is not None:
            system, initial = system.of_members(members), state_of_members(initial, members)
            source = EventsOfMembers(source, members, system)
        integrals, drift = (
            {name: rows(values) for name, values in each.items()} for each in (known.integrals, known.drift)
        )
        omega, kinetic = known.omega_body, known.kinetic_energy
        record = Record(
            rows(known.potential_energy),
            integrals,
            drift,
            omega_body=None if omega is None else rows(omega),
            kinetic_energy=None if kinetic is None else rows(kinetic),
        )
        values = self.environment.orbit_values
        environment = None if values is None else StoredEnvironment(times, rows(values))
        motion = type(self)(system, initial, times, phase, self.run, record, environment)
        motion._complete(event_source=source)
        return motion

    @property
    @override
    def omega_body(self) -> Array:
        return super().omega_body if self._record.omega_body is None else np.asarray(self._record.omega_body)

    @property
    @override
    def kinetic_energy(self) -> Array:
        return (
            super().kinetic_energy if self._record.kinetic_energy is None else np.asarray(self._record.kinetic_energy)
        )

    @property
    @override
    def potential_energy(self) -> Array:
        return np.asarray(self._record.potential_energy)

    @override
    def _at_hand(self, names: Collection[str]) -> dict[str, Array]:
        known, alone = self._record, ("potential_energy", "omega_body", "kinetic_energy")
        held = {name: values for name in alone if (values := getattr(known, name)) is not None}
        held |= {f"integral_{name}": values for name, values in known.integrals.items()}
        held |= {f"drift_{name}": values for name, values in known.drift.items()}
        return super()._at_hand(names) | {name: np.asarray(held[name]) for name in names if name in held}

    @property
    @override
    def summary(self) -> dict[str, Any]:
        return super().summary if self.store is not None else self._recorded_summary or super().summary

    @override
    def _summary_with(self, errors: Mapping[str, Array]) -> dict[str, Any]:
        return self._recorded_summary or super()._summary_with(errors)

    @property
    def _recorded_summary(self) -> dict[str, Any]:
        """What the file says, which has no wall time."""
        return self._told_run | dict(self._record.summary) if self._record.summary else {}


class StoredPairTrajectory(StoredTrajectory, PairTrajectory):
    """The same of two bodies."""


def stored_trajectory_class(system: StoredSystem) -> type[StoredTrajectory]:
    """Return the class of the motions of a system in a file."""
    return StoredTrajectory if len(system.of_bodies) == 1 else StoredPairTrajectory
