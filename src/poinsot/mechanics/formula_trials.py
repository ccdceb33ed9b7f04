"""Trials of formulas on arrays, which refuse a Python `if` and betray a wrong shape, before a kernel is built."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.dynamics import Dynamics
from poinsot.mechanics.environment import Environment, orbits_of, sample_time
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, Load, Potential, derived_torque
from poinsot.mechanics.formula_errors import FormulaError, use_functions
from poinsot.mechanics.instant import Instant, RateUnknownError
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import described, message_of

__all__ = [
    "ATTITUDES",
    "PAIR",
    "RATES",
    "body_in_rotation",
    "on_pairs",
    "trial",
    "try_event",
    "try_formulas",
    "try_pair_force",
]

PAIR = np.array([1.0, 1.0])
RATES = np.array([[0.0, 0.2], [0.0, 0.4], [0.0, 0.6]])
ATTITUDES = np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]])


def try_formulas(system: Dynamics) -> None:
    """Run the formula of each force once on arrays of two values.

    Raises
    ------
    TypeError
        If a formula does not return what it must.
    """
    body = on_pairs(system)
    for force in system.forces:
        _try_force(force, body)


def on_pairs(system: Dynamics) -> Body:
    """Return the first member's body with its parts, on arrays of two values for trials of formulas."""
    twin = system.with_numbers(number.item(0) * PAIR for number in system.numbers)
    return body_in_rotation(twin, 0.25 * PAIR, Vector(RATES))


def body_in_rotation(system: Dynamics, time: Scalar, omega: Vector) -> Body:
    """Return the body with its parts at their initial values for an angular velocity."""
    own = {part.name: Vector(x + 0.0 * time for x in part.start(time, omega)) for part in system.parts}
    return system.body_at(own, time)


def _try_force(force: Force, body: Body) -> None:
    """Run the formula of a force once on arrays of two values, which the body is made of."""
    formula = _of_part if isinstance(force, Part) else _of_potential if isinstance(force, Potential) else _of_torque
    _try(type(force).__name__, formula, force, trial(force, body))


def try_pair_force(force: Force, instant: Instant, derived: Callable[[Any, Any], Any]) -> None:
    """Run the formula of a force on two bodies once, at an instant of arrays of two values."""

    def load(twin: Any, at: Any) -> Any:
        if isinstance(twin, Potential):
            _one("energy", twin, twin.energy(at.without_rates))
            return derived(twin.energy, at)
        load = twin.load(at)
        if not isinstance(load, Load):
            raise WrongSizeError(f"the load of {type(twin).__name__} must be a poinsot.Load, got {described(load)}.")
        for what, vector in (("force", load.force), ("first torque", load.torques[0]), ("second", load.torques[1])):
            _several(f"the {what} of {type(twin).__name__} must be three components", vector, 3)
        return load

    _try(type(force).__name__, load, force, instant)


def try_event(event: Event, instant: Instant) -> None:
    """Run the formulas of an event once, at an instant of arrays of two values."""
    _try(type(event).__name__, _of_event, event, instant)


def trial(record: Any, body: Body) -> Instant:
    """Return an instant for the trial of a formula, of a body that is made of arrays of two values."""
    environment = Environment(sample_time(orbits_of(record)) + 0.25 * PAIR)
    return Instant(body, Attitude.from_quaternion(Vector(ATTITUDES.T)), environment, RATES)


def _try(name: str, formula: Callable[[Any, Any], Any], record: Any, instant: Instant) -> None:
    """Run a formula at an instant, and raise the sentence about what it does not allow."""
    twin = record.with_numbers(number.item(0) * PAIR for number in record.numbers)
    try:
        with np.errstate(all="ignore"):
            formula(twin, instant)
    except WrongSizeError as error:
        raise TypeError(str(error)) from None
    except RateUnknownError as error:
        kind = "PairLoad" if isinstance(instant.acted_on, TwoBodies) else "Torque"
        raise TypeError(f"{error} Write {name} as a {kind}.") from None
    except (AttributeError, FormulaError) as error:
        missing = error.__cause__ or error
        if _is_of_other_bodies(missing):
            raise TypeError(
                f"the formula of {name} must be for the bodies of its system, but {message_of(missing)}"
            ) from None
        raise
    except (TypeError, ValueError) as error:
        if "positional argument" in str(error):
            raise TypeError(
                f"the formula of {name} must take one argument, the instant, but {message_of(error)}."
            ) from error
        if "truth value" in str(error):
            raise TypeError(
                f"the formula of {name} must not branch with `if` on a value, but it does. "
                "Write poinsot.functions.where(condition, a, b)."
            ) from None
        raise FormulaError(use_functions(f"the formula of {name}", error)) from error


def _is_of_other_bodies(error: BaseException) -> bool:
    """Whether a formula of one body asks for what two bodies have, or the other way round."""
    if not isinstance(error, AttributeError):
        return False
    return "of two bodies" in str(error) or (isinstance(error.obj, Instant) and hasattr(PairInstant, str(error.name)))


class WrongSizeError(TypeError):
    """A formula gives another number of components than it must."""


def _of_potential(potential: Potential, instant: Instant) -> None:
    _one("energy", potential, potential.energy(instant.without_rates))
    derived_torque(potential, instant)


def _of_torque(force: Any, instant: Instant) -> None:
    torque = force.torque(instant)
    rule = f"the torque of {type(force).__name__} must be three components along the body axes"
    _several(rule, torque, 3)


def _of_part(part: Part, instant: Instant) -> None:
    rates = part.rates(instant, Vector(0.0 * PAIR for _ in range(part.size)))
    rule = f"the rates of {type(part).__name__} must be {part.size} scalars, one for each of its variables"
    _several(rule, rates, part.size)


def _of_event(event: Event, instant: Instant) -> None:
    _one("value", event, event.value(instant))
    _one("condition", event, event.condition(instant))


def _one(what: str, record: Any, value: Any) -> None:
    if _components(value) != 1:
        raise WrongSizeError(f"the {what} of {type(record).__name__} must be one scalar, got {_size(value)}.")


def _several(rule: str, vector: Any, count: int) -> None:
    """Raise an error unless a formula returned as many scalars as it must."""
    if _components(vector) != count:
        raise WrongSizeError(f"{rule}, got {_size(vector)}.")
    for x in vector:
        if _components(x) != 1:
            raise WrongSizeError(f"{rule}, got one that is {_size(x)}.")


def _components(value: Any) -> int:
    """Return how many scalars a formula returned; 0 for none."""
    if isinstance(value, Vector | tuple | list) or (isinstance(value, np.ndarray) and value.shape not in ((), (2,))):
        return len(value)
    return int(_is_scalar(value))


def _is_scalar(value: Any) -> bool:
    """Whether formulas compute with a value: a real number, an array of them, a condition, or a node."""
    return hasattr(type(value), "__neg__") and np.asarray(value).dtype.kind in "biufO"


def _size(value: Any) -> str:
    count = _components(value)
    if count == 0 and value is not None:
        return described(value)
    return {0: "None", 1: "a scalar"}.get(count, f"{count} components")
