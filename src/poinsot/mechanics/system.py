"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.formulations import FORMULATIONS
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.parameters import came
from poinsot.mechanics.sky import Sky
from poinsot.mechanics.state import State

__all__ = ["System"]


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
            raise TypeError(f"body must be a Body, but {came(body)} came. The order is System(body, *forces).")
        self.body = body
        self.forces = forces
        self.units = _checked_units(units or {})
        for force in forces:
            _check_force(force)
        for force in forces:
            _try_formula(force, body)

    def __repr__(self) -> str:
        return f"System({', '.join(map(repr, (self.body, *self.forces)))})"

    # ------------------------------------------------------------------ energy

    def kinetic_energy(self, state: State) -> Any:
        """Return the kinetic energy of a state, eq. (9); shape (...)."""
        return self.with_numbers(self.numbers).body.kinetic_energy(_scalars(state.angular_momentum_body))

    def potential_energy(self, state: State) -> Any:
        """Return the sum of the energies of the potentials at a state; shape (...)."""
        total = self.with_numbers(self.numbers).potential_at(_scalars(state.quaternion), state.time)
        return np.broadcast_to(total, state.quaternion.shape[:-1])[()]

    def energy(self, state: State) -> Any:
        """Return kinetic plus potential energy, the Hamiltonian where there is one; shape (...)."""
        return self.kinetic_energy(state) + self.potential_energy(state)

    @functools.cached_property
    def integrals(self) -> tuple[Integral, ...]:
        """What the motion conserves; empty where nothing is (such as the paper's Sec. 6.2)."""
        return integrals_of(self)

    # ------------------------------------------------------------------ equations of motion

    def derivatives(self, formulation: str, variables: Any, time: Scalar) -> list[Scalar]:
        """Return the time derivatives of the variables of a formulation, as symbolic expressions.

        `variables` and `time` are heyoka or SymPy expressions, in the order of the formulation's blocks.
        """
        sky = Sky(time)
        return FORMULATIONS[formulation].derivatives(
            variables, self.body, lambda attitude, omega: self.torque_at(attitude, omega, sky)
        )

    def torque_at(self, attitude: Attitude, omega_body: Vector, sky: Sky) -> Vector:
        """Return the sum of all torques along the body axes, those of potentials derived."""
        total = functions.Vector((0.0, 0.0, 0.0))
        for force in self.forces:
            if isinstance(force, Potential):
                total = total + derived_torque(force, self.body, attitude, sky)
            elif isinstance(force, Torque):
                total = total + functions.Vector(force.torque(self.body, attitude, omega_body, sky))
        return total

    def potential_at(self, q: Vector, time: Scalar) -> Scalar:
        """Return the potential energy at one quaternion of four scalars."""
        attitude, sky = Attitude.from_quaternion(q), Sky(time)
        return sum(f.energy(self.body, attitude, sky) for f in self.forces if isinstance(f, Potential))

    # ------------------------------------------------------------------ parameters

    @property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations, without any real number."""
        return (self.body.structure, *(force.prepared.structure for force in self.forces))

    @property
    def numbers(self) -> Iterator[NDArray[np.float64]]:
        """The real parameters of body and forces, in the order in which `with_numbers` takes them."""
        for part in (self.body, *self.forces):
            yield from part.prepared.numbers

    def with_numbers(self, scalars: Iterator[Scalar]) -> System:
        """Return the same system on other scalars: runtime parameters, symbols, arrays."""
        twin = object.__new__(System)
        twin.body = self.body.with_numbers(scalars)
        twin.forces = tuple(force.prepared.with_numbers(scalars) for force in self.forces)
        twin.units = self.units
        return twin


def _scalars(array: ArrayLike) -> Vector:
    """Return the last axis of an array as the scalars of a formula."""
    return functions.Vector(np.moveaxis(np.asarray(array), -1, 0))


def _checked_units(units: Mapping[str, str]) -> dict[str, str]:
    for key in units:
        if key not in ("time", "inertia"):
            raise ValueError(f"units must name 'time' and 'inertia', but {key!r} came.")
    return {"time": units.get("time", "1"), "inertia": units.get("inertia", "1")}


def _check_force(force: Any) -> None:
    if isinstance(force, type):
        raise TypeError(
            f"a force must be an instance, but the class {force.__name__} came. Write {force.__name__}(...)."
        )
    if not isinstance(force, Potential | Torque):
        raise TypeError(f"a force must be a Potential or a Torque, but {came(force)} came.")


def _try_formula(force: Force, body: Body) -> None:
    """Run the formula once on arrays of two values, which refuse a Python `if` and betray a wrong shape."""
    pair = np.array([1.0, 1.0])
    body, force = (
        x.prepared.with_numbers(np.ravel(number)[0] * pair for number in x.prepared.numbers) for x in (body, force)
    )
    q = functions.Vector(np.array([[0.5, -0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]]).T)
    omega = functions.Vector(np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]))
    attitude, sky = Attitude.from_quaternion(q), Sky(0.25 * pair)
    name = type(force).__name__
    try:
        with np.errstate(all="ignore"):
            if isinstance(force, Potential):
                _check_scalar(f"the energy of {name}", force.energy(body, attitude, sky))
            elif isinstance(force, Torque):
                _check_three(f"the torque of {name}", force.torque(body, attitude, omega, sky))
    except ValueError as error:
        if "truth value" not in str(error):
            raise
        raise TypeError(
            f"the formula of {name} must not branch with `if` on a value, but it does. "
            "Write poinsot.functions.where(condition, a, b)."
        ) from None


def _check_scalar(name: str, value: Any) -> None:
    if np.shape(value) not in ((), (2,)) or np.asarray(value).dtype == object:
        raise TypeError(f"{name} must be one scalar, but {_size(value)} came.")


def _check_three(name: str, value: Any) -> None:
    if np.ndim(value) == 0 or len(value) != 3 or any(np.shape(x) not in ((), (2,)) for x in value):
        raise TypeError(f"{name} must be three components along the body axes, but {_size(value)} came.")


def _size(value: Any) -> str:
    if value is None:
        return "None"
    return (
        "a scalar"
        if np.shape(value) in ((), (2,)) and np.asarray(value).dtype != object
        else f"{len(value)} components"
    )
