"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.axes import SPACE_AXES, Axes
from poinsot.mechanics.body import Body
from poinsot.mechanics.collection import Collection
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.formula_trials import try_force
from poinsot.mechanics.formulations import FORMULATIONS
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.parameters import Parametric, described
from poinsot.mechanics.state import State
from poinsot.mechanics.units import checked_units, dated_units

__all__ = ["System"]


class System(Collection):
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
        self.units = checked_units(units)
        for force in forces:
            _check_force(force)
        self.refuse_other_axes()
        self.units = dated_units(self.units, units, self.calendar)
        for force in forces:
            force.check(body)
        self.sample_torque = sum(try_force(force, body) for force in forces)

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

    # ------------------------------------------------------------------ parameters

    @property
    @override
    def parts(self) -> tuple[Parametric, ...]:
        return (self.body, *self.forces)

    @override
    def with_parts(self, parts: Iterable[Any]) -> System:
        twin = object.__new__(System)
        twin.body, *forces = parts
        twin.forces, twin.units = tuple(forces), self.units
        return twin


def _scalars(array: ArrayLike) -> Vector:
    """Return the last axis of an array as the scalars of a formula."""
    return functions.Vector(np.moveaxis(np.asarray(array), -1, 0))


def _check_force(force: Any) -> None:
    if isinstance(force, type):
        raise TypeError(f"a force must be an instance, got the class {force.__name__}. Write {force.__name__}(...).")
    if not isinstance(force, Potential | Torque):
        raise TypeError(f"a force must be a Potential or a Torque, got {described(force)}.")
