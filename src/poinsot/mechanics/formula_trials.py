"""Trials of formulas on arrays, which refuse a Python `if` and betray a wrong shape, before a kernel is built."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, orbits_of, sample_time
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, Load, Potential, derived_torque
from poinsot.mechanics.formula_errors import use_functions
from poinsot.mechanics.instant import Instant, RateUnknownError
from poinsot.mechanics.parameters import described
from poinsot.mechanics.part import Part

__all__ = ["PAIR", "trial", "try_event", "try_force", "try_pair_force"]

PAIR = np.array([1.0, 1.0])
RATES = np.array([[0.0, 0.2], [0.0, 0.4], [0.0, 0.6]])
ATTITUDES = np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]])


def try_force(force: Force, body: Body) -> float:
    """Run the formula of a force once on arrays of two values, which the body is made of.

    Return the torque on the body at rest, which is the first value; of a potential the difference of the energies, if
    that is larger.
    """
    name = type(force).__name__
    formula = _of_part if isinstance(force, Part) else _of_potential if isinstance(force, Potential) else _of_torque
    torque, change = _tried(name, formula, force, trial(force, body))
    with np.errstate(all="ignore"):
        at_rest = np.linalg.norm([np.atleast_1d(component)[0] for component in torque])
    return float(np.max(np.nan_to_num([at_rest, change], posinf=0.0)))


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
            if _components(vector) != 3:
                name = type(twin).__name__
                raise WrongSizeError(f"the {what} of {name} must be three components, got {_size(vector)}.")
        return load

    _tried(type(force).__name__, load, force, instant)


def try_event(event: Event, instant: Instant) -> None:
    """Run the formulas of an event once, at an instant of arrays of two values."""
    _tried(type(event).__name__, _of_event, event, instant)


def trial(record: Any, body: Body) -> Instant:
    """Return an instant for the trial of a formula, of a body that is made of arrays of two values."""
    environment = Environment(sample_time(orbits_of(record)) + 0.25 * PAIR)
    return Instant(body, Attitude.from_quaternion(Vector(ATTITUDES.T)), environment, RATES)


def _tried(name: str, formula: Callable[[Any, Any], Any], record: Any, instant: Instant) -> Any:
    """Return what a formula gives, or raise the sentence about what it does not allow."""
    twin = record.with_numbers(np.ravel(number)[0] * PAIR for number in record.numbers)
    try:
        with np.errstate(all="ignore"):
            return formula(twin, instant)
    except WrongSizeError as error:
        raise TypeError(str(error)) from None
    except RateUnknownError as error:
        raise TypeError(f"{error} Write {name} as a Torque.") from None
    except AttributeError as error:
        if isinstance(error.obj, Instant) or "of two bodies" in str(error):
            raise TypeError(f"the formula of {name} must be for the bodies of its system, but {error}") from None
        raise
    except (TypeError, ValueError) as error:
        if "positional argument" in str(error):
            raise TypeError(f"the formula of {name} must take one argument, the instant, but {error}.") from error
        if "truth value" in str(error):
            raise TypeError(
                f"the formula of {name} must not branch with `if` on a value, but it does. "
                "Write poinsot.functions.where(condition, a, b)."
            ) from None
        raise TypeError(use_functions(f"the formula of {name}", "arrays", error)) from error


class WrongSizeError(TypeError):
    """A formula gives another number of components than it must."""


def _of_potential(potential: Potential, instant: Instant) -> tuple[Any, Any]:
    """Return the torque, and the difference of the energies."""
    energy = _one("energy", potential, potential.energy(instant.without_rates))
    return derived_torque(potential, instant), np.ptp(energy)


def _of_torque(force: Any, instant: Instant) -> tuple[Any, float]:
    torque = force.torque(instant)
    if _components(torque) != 3 or any(_components(x) != 1 for x in torque):
        name = type(force).__name__
        raise WrongSizeError(f"the torque of {name} must be three components along the body axes, got {_size(torque)}.")
    return torque, 0.0


def _of_part(part: Part, instant: Instant) -> tuple[Any, float]:
    rates = part.rates(instant, Vector(0.0 * PAIR for _ in range(part.size)))
    if _components(rates) != part.size:
        count = f"{part.size} scalars, one for each of its variables"
        raise WrongSizeError(f"the rates of {type(part).__name__} must be {count}, got {_size(rates)}.")
    return (0.0, 0.0, 0.0), 0.0


def _of_event(event: Event, instant: Instant) -> None:
    _one("value", event, event.value(instant))
    _one("condition", event, event.condition(instant))


def _one(what: str, record: Any, value: Any) -> Any:
    if _components(value) != 1:
        raise WrongSizeError(f"the {what} of {type(record).__name__} must be one scalar, got {_size(value)}.")
    return value


def _components(value: Any) -> int:
    """Return how many scalars a formula returned; 0 for none."""
    if isinstance(value, Vector | tuple | list) or (isinstance(value, np.ndarray) and value.shape not in ((), (2,))):
        return len(value)
    return 0 if value is None else 1


def _size(value: Any) -> str:
    count = _components(value)
    return {0: "None", 1: "a scalar"}.get(count, f"{count} components")
