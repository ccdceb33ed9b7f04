"""Systems, parts and events from a file that describes them without their formulas."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.functions import Scalar
from poinsot.immutable import Immutable
from poinsot.kinematics.state import AnyState
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.event import Event
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.pair_instant import AnyInstant
from poinsot.mechanics.part import Jump
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import printable, shortened
from poinsot.quantities import Array
from poinsot.records.formula_errors import FormulaError
from poinsot.records.units import DerivedUnits
from poinsot.systems.dynamics import AnyDynamics
from poinsot.systems.integrals import Integral
from poinsot.systems.system import System

__all__ = ["RecordedEvent", "RecordedObservable", "RecordedPart", "RecordedSystem", "recorded_integral"]


class RecordedPart(NamedTuple):
    """Part of a body in a file: its variables, with the number of scalars of each."""

    name: str
    variables: Mapping[str, int]
    momenta: frozenset[str]
    jump: Jump | None = None

    @property
    def size(self) -> int:
        """Number of scalars."""
        return sum(self.variables.values())

    @property
    def _member_axes(self) -> dict[str, int]:
        return {"jump": 0}

    def _with_values(self, jump: Jump | None) -> RecordedPart:
        return self._replace(jump=jump)


class RecordedSystem(Immutable):
    """System from a file that contains the names of its forces only. It cannot be integrated.

    Attributes
    ----------
    body : Body or TwoBodies
        Body with the numbers in the file.
    units : mapping
        Units of the system.
    not_rerunnable : str
        Reason why the forces are unknown.
    integrals : tuple of Integral
        Integrals of the motion. The motion contains their values.
    parts : tuple of RecordedPart
        Parts of the body.
    """

    forces = ()
    records = ()
    orbits = ()
    members = ()
    calendar = None
    moves_alone = False

    def __init__(
        self,
        body: Body | TwoBodies,
        units: Mapping[str, str],
        text: str,
        reason: str,
        integrals: tuple[Integral, ...],
        parts: tuple[RecordedPart, ...] = (),
    ) -> None:
        self.parts = parts
        self.body, self.integrals, self.not_rerunnable, self._text = body, integrals, reason, text
        self._free = System(body, units=units)
        self.units, self.of_bodies = self._free.units, self._free.of_bodies

    def __repr__(self) -> str:
        return printable(self._text, unescaped="\n")

    _member_axes: ClassVar[Mapping[str, int]] = {"body": 0, "parts": 0}

    def _with_values(self, body: Body | TwoBodies, parts: tuple[RecordedPart, ...]) -> RecordedSystem:
        return RecordedSystem(body, self.units, self._text, self.not_rerunnable, self.integrals, parts)

    @property
    def jumping(self) -> tuple[RecordedPart, ...]:
        """Parts whose variables jump."""
        return tuple(part for part in self.parts if part.jump is not None)

    @property
    def dynamics(self) -> RecordedSystem:
        """System itself: its equations of motion are unknown."""
        return self

    @property
    def numbers(self) -> tuple[Array, ...]:
        """Numbers of the body."""
        return self._free.dynamics.numbers

    def with_numbers(self, numbers: Iterable[Array]) -> AnyDynamics:
        """Return the body without forces, with the given numbers."""
        self._refuse_parts("omega_body")
        return self._free.dynamics.with_numbers(numbers)

    def at(self, state: AnyState, environment: Environment | None = None) -> AnyInstant:
        """Return the instant of a state, the argument of formulas."""
        self._refuse_parts("an instant")
        return self._free.at(state, environment)

    def omega_body(self, state: AnyState) -> Array:
        """Return the inertial angular velocity along the body axes; shape (..., 3)."""
        self._refuse_parts("omega_body")
        return np.asarray(self._free.omega_body(state))

    def kinetic_energy(self, state: AnyState) -> Array:
        """Return the kinetic energy of a state; shape (...)."""
        self._refuse_parts("kinetic_energy")
        return np.asarray(self._free.kinetic_energy(state))

    def validity(self, *_: AnyState | Environment) -> dict[str, NDArray[np.bool_]]:
        """Return an empty dictionary: the formulas, with ranges of validity and limits, are unknown."""
        return {}

    limits = validity

    def torques_body(self, *_: AnyState | Environment | str) -> dict[str, Array]:
        """Return an empty dictionary: the formulas of the forces are unknown."""
        return {}

    forces_space = torques_body

    @staticmethod
    def formula_missing(name: str) -> ValueError:
        """Return the error for a quantity that requires the formulas of the forces."""
        return _formula_missing(name)

    def _refuse_parts(self, name: str) -> None:
        if self.parts:
            raise ValueError(
                f"{name} must have the parts of the body to be computed, got a file without. The motion has its values."
            )


class RecordedEvent(Event):
    """Event from a file that contains its kind and its text, but no formula.

    Parameters
    ----------
    name : str
        Kind of the event.
    text : str
        `repr` of the event.
    """

    name: str
    text: str

    @override
    def __repr__(self) -> str:
        return printable(self.text, unescaped="\n")

    @property
    @override
    def kind(self) -> str:
        return self.name

    @override
    def value(self, instant: Instant) -> Scalar:
        raise ValueError(f"{self.name} must have its formula to be computed, got none in the store.")


class RecordedObservable(Observable):
    """Observable from a file that contains its text, but no formula.

    Parameters
    ----------
    text : str
        `repr` of the observable.
    names, error_names : str
        Names of the numbers of a reading and of an error, separated by spaces.
    unit_of_readings, axes : str
        Unit of the readings, and axes of the components.
    reason : str
        Reason why the file does not contain what makes the observable again.
    """

    text: str
    names: str
    error_names: str
    unit_of_readings: str = ""
    axes: str = ""
    reason: str = "it contains the text alone"

    @override
    def __repr__(self) -> str:
        return printable(self.text, unescaped="\n")

    @property
    def components(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the numbers of a reading."""
        return tuple(self.names.split())

    @property
    @override
    def errors(self) -> tuple[str, ...]:
        return tuple(self.error_names.split())

    @override
    def unit(self, units: DerivedUnits) -> str:
        return self.unit_of_readings

    @property
    @override
    def frame(self) -> str:
        return self.axes

    @override
    def reading(self, instant: Instant) -> NoReturn:
        raise FormulaError(
            f"{shortened(self.text)} must have a formula to be read, got none from its file: {self.reason}"
        )


def _formula_missing(name: str) -> ValueError:
    """Return the error for a quantity that requires the formulas of the forces."""
    return ValueError(f"{name} must have its forces to be computed, got none in the file. The motion has its values.")


def recorded_integral(name: str, attributes: Mapping[str, object]) -> Integral:
    """Return an integral from a file that contains its values along a motion."""

    def unknown(_: AnyState) -> NoReturn:
        raise _formula_missing(name)

    symbol, meaning = str(attributes.get("symbol", name)), str(attributes.get("long_name", name))
    return Integral(name, symbol, meaning, unknown, attributes.get("kind") == "energy")
