"""Trials of formulas on arrays, which refuse a Python `if` and betray a wrong shape, before a kernel is built."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot.functions import Vector
from poinsot.kinematics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, orbits_of, sample_time
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, Load, Potential, derived_torque
from poinsot.mechanics.instant import Instant, RateUnknownError
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.pair_instant import AnyInstant, PairInstant
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import TwoBodies, mean_motion
from poinsot.printable import described, message_of
from poinsot.records.formula_errors import FormulaError, use_functions
from poinsot.records.parameters import Parametric
from poinsot.suggestions import holder_of
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.dynamics import AnyDynamics
from poinsot.systems.pair_dynamics import PairDynamics

__all__ = ["ATTITUDES", "RATES", "try_event", "try_formulas", "try_observable"]

PAIR = np.array([1.0, 1.0])
RATES = np.array([[0.0, 0.2], [0.0, 0.4], [0.0, 0.6]])
ATTITUDES = np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]])
ATTITUDES_OF_PAIR = np.array(
    [[[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]], [[0.1, 0.7, -0.1, 0.7], [0.5, 0.5, 0.5, -0.5]]]
)


def try_formulas(dynamics: AnyDynamics) -> None:
    """Run the formula of each force on arrays of two values: of one body, once for all systems of a structure.

    Raises
    ------
    TypeError
        If a formula does not return what it must.
    """
    if isinstance(dynamics, PairDynamics):
        for force in dynamics.forces:
            _try_pair_force(force, _trial_of_pair(dynamics, force))
    elif isinstance(dynamics, BodyDynamics):
        _try_forces(dynamics)


def try_event(dynamics: AnyDynamics, event: Event) -> None:
    """Run the formulas of an event on arrays of two values, or raise a TypeError."""
    _try_record(dynamics, event, _of_event)


def try_observable(dynamics: AnyDynamics, observable: Observable) -> None:
    """Run the formula of an observable on arrays of two values, or raise a TypeError."""
    _try_record(dynamics, observable, _of_observable)


def _try_record(dynamics: AnyDynamics, record: Parametric, formula: Callable[[Any, Any], Any]) -> None:
    if isinstance(dynamics, PairDynamics):
        _try(type(record).__name__, formula, record, _trial_of_pair(dynamics, record))
    elif isinstance(dynamics, BodyDynamics):
        if "body on pairs" not in dynamics.results:
            dynamics.results["body on pairs"] = _on_pairs(dynamics)
        _try(type(record).__name__, formula, record, _trial(record, dynamics.results["body on pairs"]))


def _try_forces(dynamics: BodyDynamics) -> None:
    if "formulas are valid" in dynamics.alike:
        return
    body = _on_pairs(dynamics)
    for force in dynamics.forces:
        _try_force(force, body)
    dynamics.alike["formulas are valid"] = True


def _on_pairs(system: BodyDynamics) -> Body:
    """Return the first member's body with its parts, on arrays of two values for trials of formulas."""
    twin = system.with_numbers(number.item(0) * PAIR for number in system.numbers)
    return twin.body_in_rotation(0.25 * PAIR, Vector(RATES))


def _try_force(force: Force, body: Body) -> None:
    """Run the formula of a force once on arrays of two values, which the body is made of."""
    formula = _of_part if isinstance(force, Part) else _of_potential if isinstance(force, Potential) else _of_torque
    _try(type(force).__name__, formula, force, _trial(force, body))


def _try_pair_force(force: Force, instant: PairInstant) -> None:
    """Run the formula of a force on two bodies once, at an instant of arrays of two values."""

    def load(twin: Any, at: Any) -> Any:
        if isinstance(twin, Potential):
            _one("energy", twin, twin.energy(at.without_rates))
            return PairDynamics.derived_load(twin.energy, at)  # type: ignore[arg-type]
        load = twin.load(at)
        if not isinstance(load, Load):
            raise WrongSizeError(
                f"the load of {type(twin).__name__} must be a poinsot.mechanics.Load, got {described(load)}."
            )
        for what, vector in (("force", load.force), ("first torque", load.torques[0]), ("second", load.torques[1])):
            _several(f"the {what} of {type(twin).__name__} must be three components", vector, 3)
        return load

    _try(type(force).__name__, load, force, instant)


def _trial(record: Parametric, body: Body) -> Instant:
    """Return an instant for the trial of a formula, of a body that is made of arrays of two values."""
    return Instant(body, Attitude.from_quaternion(Vector(ATTITUDES.T)), _environment(record), RATES)


def _environment(record: Parametric) -> Environment:
    """Return the environment of a trial, at a time within the spans of the orbits of a record."""
    orbits = list(orbits_of(record))
    time = sample_time(orbits)
    room = min((float(np.min(orbit.span[1])) for orbit in orbits), default=np.inf) - time
    return Environment(time + min(0.25, 0.5 * room) * PAIR)


def _trial_of_pair(dynamics: PairDynamics, record: Parametric) -> PairInstant:
    """Return an instant for the trial of a formula, of the first member's bodies on arrays of two values."""
    twin = dynamics.with_numbers(np.ravel(number)[0] * PAIR for number in dynamics.numbers).body
    attitudes = [Attitude.from_quaternion(Vector(q.T)) for q in ATTITUDES_OF_PAIR]
    n = mean_motion(twin, dynamics.sample_distance)
    position = Vector(dynamics.sample_distance * x for x in np.array([[0.6, 0.0], [0.8, -0.6], [0.0, 0.8]]))
    momentum = Vector(0.5 * twin.reduced_mass * dynamics.sample_distance * n * x for x in (-0.8, 0.6, 0.1))
    own = [Vector(body.angular_momentum(Vector(n * x for x in (0.1, 0.2, 0.9)))) for body in twin.bodies.values()]
    return PairInstant(twin, attitudes, position, _environment(record), momentum, own)


def _try(name: str, formula: Callable[[Any, Any], Any], record: Parametric, instant: AnyInstant) -> None:
    """Run a formula at an instant, or raise an error that explains a forbidden operation."""
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
    """Return True if a formula of one body reads an attribute of two bodies, or the other way round."""
    if not isinstance(error, AttributeError):
        return False
    return "of two bodies" in str(error) or (
        isinstance(holder_of(error), Instant) and hasattr(PairInstant, str(error.name))
    )


class WrongSizeError(TypeError):
    """Error of a formula that returns a wrong number of components."""


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


def _of_observable(observable: Observable, instant: Instant) -> None:
    reading = observable.reading(instant)
    if names := observable.components:
        _several(f"the reading of {type(observable).__name__} must be {len(names)} scalars", reading, len(names))
    else:
        _one("reading", observable, reading)


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
    """Return True for a value that formulas accept: a real number, an array of numbers, a condition, or a node."""
    return hasattr(type(value), "__neg__") and np.asarray(value).dtype.kind in "biufO"


def _size(value: Any) -> str:
    count = _components(value)
    if count == 0 and value is not None:
        return described(value)
    return {0: "None", 1: "a scalar"}.get(count, f"{count} components")
