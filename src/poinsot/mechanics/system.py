"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.checked import checked
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.axes import SPACE_AXES, Axes
from poinsot.mechanics.body import Body
from poinsot.mechanics.branch_exploration import BRANCHES, ExploredEnvironment, opened
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Environment, frames_of
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.formula_errors import use_functions
from poinsot.mechanics.formulations import FORMULATIONS
from poinsot.mechanics.instant import Instant, RateUnknownError
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.parameters import described, union_of_knots
from poinsot.mechanics.probing import common_axes, orbits_of, sample_time, samples, space_axes, span
from poinsot.mechanics.state import State

__all__ = ["System"]

AT_REST = Vector((0.0, 0.0, 0.0))

SAME_KNOT = 64
"""Roundings of a time by which two tables may miss each other's knots."""


class System:
    """A rigid body under forces.

    Parameters
    ----------
    body : Body
    *forces : Potential or Torque
        The package's or the user's own. None: torque-free motion.
    units : mapping, optional
        The units of the numbers given, for results and pictures: `{"time": "s", "inertia": "kg m2"}`. They
        are names only; all numbers must be consistent. Without them quantities are dimensionless.

    Raises
    ------
    TypeError
        If an argument is not what its name says, or a formula does not return what it must.
    """

    def __init__(self, body: Body, *forces: Force, units: Mapping[str, str] | None = None) -> None:
        if not isinstance(body, Body):
            raise TypeError(f"body must be a Body, got {described(body)}. The order is System(body, *forces).")
        self.body = body
        self.forces = forces
        self.units = _checked_units({} if units is None else units)
        for force in forces:
            _check_force(force)
        _check_skies(self)
        self.units = _dated_units(self.units, units, self.calendar)
        for force in forces:
            force.check(body)
        self._trial_push = sum(_try_formula(force, body) for force in forces)

    def __repr__(self) -> str:
        return f"System({', '.join(map(repr, (self.body, *self.forces)))})"

    # ------------------------------------------------------------------ energy

    @checked
    def kinetic_energy(self, state: State) -> Any:
        """Return the kinetic energy of a state, eq. (9); shape (...)."""
        g = state.angular_momentum_body
        return self.beside(g.shape[:-1]).body.kinetic_energy(_scalars(g))

    @checked
    def potential_energy(self, state: State, environment: Environment | None = None) -> Any:
        """Return the sum of the energies of the potentials at a state, in the world at its time; shape (...)."""
        shape = state.quaternion.shape[:-1]
        twin = self.beside(shape)
        return np.broadcast_to(twin.potential_at(twin.at(state, environment)), shape)[()]

    def validity(self, state: State, environment: Environment | None = None) -> dict[str, NDArray[np.bool_]]:
        """Return, by name, whether a formula is used at a state where it need not hold; each of shape (...)."""
        shape = state.quaternion.shape[:-1]
        twin = self.beside(shape)
        instant = twin.at(state, environment)
        found = [force.validity(instant) for force in twin.forces]
        out: dict[str, NDArray[np.bool_]] = {}
        for name, condition in (item for each in found for item in each.items()):
            out[name] = np.broadcast_to(condition, shape) | out.get(name, False)
        return out

    @checked
    def omega_body(self, state: State) -> Any:
        """Return the inertial angular velocity along the body axes; shape (..., 3)."""
        g = state.angular_momentum_body
        return np.stack(list(self.beside(g.shape[:-1]).body.omega(_scalars(g))), axis=-1)

    @checked
    def energy(self, state: State) -> Any:
        """Return kinetic plus potential energy, the Hamiltonian where there is one; shape (...)."""
        return self.kinetic_energy(state) + self.potential_energy(state)

    @functools.cached_property
    def integrals(self) -> tuple[Integral, ...]:
        """What the motion conserves; empty where nothing is (such as the paper's Sec. 6.2)."""
        return integrals_of(self)

    # ------------------------------------------------------------------ equations of motion

    def derivatives(
        self,
        formulation: str,
        variables: Any,
        time: Scalar,
        *,
        scale: Scalar = 1,
        axes: Axes = SPACE_AXES,
    ) -> list[Scalar]:
        """Return the time derivatives of the variables of a formulation, as symbolic expressions.

        `variables` and `time` are heyoka or SymPy expressions, in the order of the formulation's blocks, then
        of the axes that the attitude refers to. Momenta are multiplied by `scale`.
        """
        chosen = FORMULATIONS[formulation]
        own, comoving = variables[: chosen.size], variables[chosen.size :]
        environment = axes.environment(time, comoving)

        def torque_of(attitude: Attitude, omega: Vector) -> Vector:
            return self.torque_at(Instant(self.body, attitude, environment, omega), scale)

        rates = chosen.derivatives(own, self.body.kinetics(scale), torque_of, axes.omega(time, comoving))
        return [*rates, *axes.rates(time, comoving)]

    @checked
    def torque_body(self, state: State, environment: Environment | None = None) -> Any:
        """Return the sum of all torques at a state along the body axes, in the world at its time; shape (..., 3)."""
        shape = state.quaternion.shape[:-1]
        twin = self.beside(shape)
        torque = twin.torque_at(twin.at(state, environment))
        return np.stack([np.broadcast_to(component, shape) for component in torque], axis=-1)

    def at(self, state: State, environment: Environment | None = None) -> Instant:
        """Return the instant of a state, for formulas."""
        attitude, g = Attitude.from_quaternion(_scalars(state.quaternion)), _scalars(state.angular_momentum_body)
        return Instant(self.body, attitude, environment or Environment(state.time), angular_momentum_body=g)

    def torque_at(self, instant: Instant, scale: Scalar = 1) -> Vector:
        """Return the sum of all torques along the body axes, those of potentials derived, times a scale."""
        total = functions.Vector((0.0, 0.0, 0.0))
        for force in self.forces:
            if isinstance(force, Potential):
                total = total + derived_torque(force, instant, scale)
            elif isinstance(force, Torque):
                torque = force.torque(instant)
                total = total + Vector(scale * component for component in torque)
        return total

    def potential_at(self, instant: Instant) -> Scalar:
        """Return the sum of the energies of the potentials."""
        return sum(force.energy(instant) for force in self.forces if isinstance(force, Potential))

    @checked
    def momentum_scale(self, state: State) -> Any:
        """Return the size of the angular momentum that the motion from a state will have, roughly; shape (...).

        The larger of |g| and what the forces would give a body at rest; 1 where all is zero.
        """
        largest = np.maximum(np.linalg.norm(state.angular_momentum_body, axis=-1), self.push)
        return np.where(largest > 0, largest, 1.0)

    @functools.cached_property
    def push(self) -> Any:
        """The momentum that differences of energies, and torques, at sample states stand for; shape (...)."""
        branching = any(_branches(_Alike(force, self.body)) for force in self.forces)
        strongest = self._trial_push
        if branching or self.members:
            q, t, _ = samples(self, BRANCHES)
            skies = [Environment(t), *[ExploredEnvironment(t)] * branching]
            strongest = functools.reduce(np.maximum, [self._strongest_push(q, environment) for environment in skies])
        return np.sqrt(np.max(self.body.moments, axis=-1) * strongest)

    def _strongest_push(self, q: NDArray[np.float64], environment: Environment) -> Any:
        """Return the largest energy, over the least, or torque of each member's forces on a body at rest."""
        twin = self.beside_samples
        instant = Instant(twin.body, Attitude.from_quaternion(_scalars(q)), environment, AT_REST)
        with np.errstate(all="ignore"):
            pushes = [np.atleast_1d(_push_of(force, instant)) for force in twin.forces]
        return sum(np.nan_to_num(np.max(push, axis=-1), posinf=0.0) for push in pushes)

    # ------------------------------------------------------------------ parameters

    @functools.cached_property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations, without any real number."""
        return (self.body.structure, *(force.structure for force in self.forces))

    @functools.cached_property
    def members(self) -> tuple[int, ...]:
        """The shape of the member axis of the numbers: () for one body, (members,) for an ensemble."""
        shapes = {number.shape for number in self.numbers if number.shape}
        if len(shapes) > 1:
            counts = " and ".join(str(shape[0]) for shape in sorted(shapes))
            raise ValueError(f"body and forces must have equally many members, got {counts}.")
        return shapes.pop() if shapes else ()

    @functools.cached_property
    def common_axes(self) -> Axes | None:
        """The axes of the one orbit that all forces share; None if there is none."""
        return common_axes(self)

    @functools.cached_property
    def space_axes(self) -> Axes:
        """The space axes, with variables of orbits whose formulas do not run on symbols."""
        return space_axes(self)

    @functools.cached_property
    def numbers(self) -> tuple[NDArray[np.float64], ...]:
        """The real parameters of body and forces, in the order in which `with_numbers` takes them."""
        return tuple(number for part in (self.body, *self.forces) for number in part.numbers)

    @functools.cached_property
    def knots(self) -> NDArray[np.float64]:
        """Times, ascending, at which the tables of its orbits change their polynomials; of equal ones, the first."""
        knots = union_of_knots(self.forces)
        return (
            knots if not knots.size else knots[np.diff(knots, prepend=-np.inf) > SAME_KNOT * np.spacing(np.abs(knots))]
        )

    @functools.cached_property
    def span(self) -> tuple[float, float]:
        """The first and the last time at which all its orbits are known."""
        return span(self)

    @property
    def calendar(self) -> Any:
        """What its times mean as dates; None where no orbit has a calendar."""
        return next((orbit.calendar for orbit in orbits_of(self) if orbit.calendar is not None), None)

    def between_knots(self, time: ArrayLike | None = None) -> System:
        """Return the system between the knots around a time, by default the first two."""
        if not self.knots.size:
            return self
        time = 0.5 * (self.knots[0] + self.knots[1]) if time is None else time
        twin = object.__new__(System)
        twin.body, twin.forces = self.body, tuple(force.between_knots(time) for force in self.forces)
        twin.units = self.units
        return twin

    @functools.cached_property
    def beside_samples(self) -> System:
        """The system with numbers that broadcast against a row of samples, members first."""
        return self.with_numbers(number[..., None] for number in self.numbers)

    def watching(self, events: Iterable[Event]) -> System:
        """Return the system with events beside its forces: no force, but with numbers and orbits of their own."""
        twin = object.__new__(System)
        twin.body, twin.forces, twin.units = self.body, (*self.forces, *events), self.units
        _check_skies(twin)
        for event in twin.events:
            _try_formula(event, self.body)
            event.check(self.body)
        twin.__dict__["push"] = self.push
        return twin

    @property
    def events(self) -> list[Event]:
        """What is watched for."""
        return [event for event in self.forces if isinstance(event, Event)]

    def beside(self, shape: tuple[int, ...]) -> System:
        """Return the system with numbers that broadcast against arrays of a shape, members first."""
        return self.with_numbers(
            np.reshape(number, (*number.shape, *(1,) * (len(shape) - number.ndim))) for number in self.numbers
        )

    def with_numbers(self, scalars: Iterable[Scalar]) -> System:
        """Return the same system on other scalars: runtime parameters, symbols, arrays."""
        twin, scalars = object.__new__(System), iter(scalars)
        twin.body = self.body.with_numbers(scalars)
        twin.forces = tuple(force.with_numbers(scalars) for force in self.forces)
        twin.units = self.units
        return twin


def _scalars(array: ArrayLike) -> Vector:
    """Return the last axis of an array as the scalars of a formula."""
    return functions.Vector(np.moveaxis(np.asarray(array), -1, 0))


def _checked_units(units: Mapping[str, str]) -> dict[str, str]:
    if not isinstance(units, Mapping):
        raise TypeError(f'units must be a mapping such as {{"time": "s"}}, got {described(units)}.')
    for key, unit in units.items():
        if key not in ("time", "inertia"):
            raise ValueError(f"units must name 'time' and 'inertia', got {key!r}.")
        if not isinstance(unit, str):
            raise TypeError(f"units must be words, but units[{key!r}] = {unit!r}.")
    return {"time": units.get("time", "1"), "inertia": units.get("inertia", "1")}


def _dated_units(checked: dict[str, str], given: Mapping[str, str] | None, calendar: Any) -> dict[str, str]:
    """Return the units with the calendar's of time; refuse another one."""
    if calendar is None:
        return checked
    if given is not None and checked["time"] not in ("1", calendar.unit):
        raise ValueError(
            f"units['time'] must be {calendar.unit!r}, in which the calendar of the orbits counts, got "
            f"{checked['time']!r}."
        )
    return {**checked, "time": calendar.unit}


def _check_force(force: Any) -> None:
    if isinstance(force, type):
        raise TypeError(f"a force must be an instance, got the class {force.__name__}. Write {force.__name__}(...).")
    if not isinstance(force, Potential | Torque):
        raise TypeError(f"a force must be a Potential or a Torque, got {described(force)}.")


def _check_skies(system: System) -> None:
    """Refuse orbits along different space axes, or with different calendars."""
    orbits = list(orbits_of(system))
    frames = frames_of(orbits)
    calendars = dict.fromkeys(orbit.calendar for orbit in orbits if orbit.calendar is not None)
    for what, found in (("reference frame", frames), ("calendar", calendars)):
        if len(found) > 1:
            first, second, *_ = found
            hint = " Make one, and give calendar= to all." if what == "calendar" else ""
            if SPACE_AXES_UNNAMED in found:
                hint = " Give reference_frame= to the one or the other."
            raise ValueError(f"the orbits of a system must have one {what}, got {first} and {second}.{hint}")


def _try_formula(force: Force, body: Body) -> float:
    """Run the formula once on arrays of two values, which refuse a Python `if` and betray a wrong shape.

    Return the torque on the body at rest, which is the first value; of a potential the difference of the energies, if
    that is larger.
    """
    name = type(force).__name__
    try:
        with np.errstate(all="ignore"):
            value, torque = _formula_on_pairs(force, body)
    except RateUnknownError as error:
        raise TypeError(f"{error} Write {name} as a Torque.") from None
    except (TypeError, ValueError) as error:
        if "positional argument" in str(error):
            raise TypeError(f"the formula of {name} must take one argument, the instant, but {error}.") from error
        if "truth value" in str(error):
            raise TypeError(
                f"the formula of {name} must not branch with `if` on a value, but it does. "
                "Write poinsot.functions.where(condition, a, b)."
            ) from None
        raise TypeError(use_functions(f"the formula of {name}", "arrays", error)) from error
    if isinstance(force, Potential | Event):
        if _components(value) != 1:
            what = "value" if isinstance(force, Event) else "energy"
            raise TypeError(f"the {what} of {name} must be one scalar, got {_size(value)}.")
    elif _components(value) != 3 or any(_components(x) != 1 for x in value):
        raise TypeError(f"the torque of {name} must be three components along the body axes, got {_size(value)}.")
    with np.errstate(all="ignore"):
        at_rest = np.linalg.norm([np.atleast_1d(component)[0] for component in torque])
        change = np.ptp(value) if isinstance(force, Potential) else 0.0
    return float(np.max(np.nan_to_num([at_rest, change], posinf=0.0)))


class _Alike:
    """A force on a body, equal to another one of the same structure: their formulas are one."""

    def __init__(self, force: Force, body: Body) -> None:
        self.force, self.body = force, body
        self._structure = force.structure, body.structure

    def __hash__(self) -> int:
        return hash(self._structure)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Alike) and self._structure == other._structure


@functools.lru_cache(1024)
def _branches(alike: _Alike) -> bool:
    """Whether the formula of a force has a condition on the time or an orbit."""
    system = object.__new__(System)
    system.body, system.forces, system.units = alike.body, (alike.force,), {}
    q, t, _ = samples(system, BRANCHES)
    environment = ExploredEnvironment(t)
    system._strongest_push(q, environment)
    return bool(environment.asked)


def _push_of(force: Any, instant: Instant) -> Any:
    if isinstance(force, Potential):
        energy = np.atleast_1d(opened(force.energy(instant)))
        return energy - np.min(energy, axis=-1, keepdims=True)
    return opened(functions.norm(force.torque(instant)))


def _formula_on_pairs(force: Any, body: Body) -> tuple[Any, Any]:
    """Return what the formula gives, and the torque, none of an event."""
    pair = np.array([1.0, 1.0])
    body = body.with_numbers(np.ravel(number)[0] * pair for number in body.numbers)
    force = force.with_numbers(np.ravel(number)[0] * pair for number in force.numbers)
    attitude = Attitude.from_quaternion(Vector(np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]]).T))
    environment = Environment(sample_time(force) + 0.25 * pair)
    if isinstance(force, Potential):
        instant = Instant(body, attitude, environment)
        energy = force.energy(instant)
        return energy, derived_torque(force, instant) if _components(energy) == 1 else ()
    instant = Instant(body, attitude, environment, np.array([[0.0, 0.2], [0.0, 0.4], [0.0, 0.6]]))
    if isinstance(force, Event):
        return force.value(instant), ()
    torque = force.torque(instant)
    return torque, torque


def _components(value: Any) -> int:
    """Return how many scalars a formula returned; 0 for none."""
    if isinstance(value, Vector | tuple | list) or (isinstance(value, np.ndarray) and value.shape not in ((), (2,))):
        return len(value)
    return 0 if value is None else 1


def _size(value: Any) -> str:
    count = _components(value)
    return {0: "None", 1: "a scalar"}.get(count, f"{count} components")
