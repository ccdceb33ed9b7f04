"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.dual import partial, seeded
from poinsot.checked import checked
from poinsot.errors import member_array
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.axes import SPACE_AXES, Axes
from poinsot.mechanics.body import Body, started
from poinsot.mechanics.collection import Collection
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.formula_trials import PAIR, RATES, try_force
from poinsot.mechanics.formulations import FORMULATIONS, Formulation
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.parameters import Parametric, described
from poinsot.mechanics.part import CompositeBody, Part, check_parts
from poinsot.mechanics.state import Phase, State, state_with
from poinsot.mechanics.units import checked_units, dated_units

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from poinsot.mechanics.frame import Frame

__all__ = ["System"]


class System(Collection):
    """A rigid body under forces.

    Parameters
    ----------
    body : Body
    *forces : Potential, Torque or Part
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
        check_parts(body, self.moving_parts)
        for force in forces:
            force.check(self._displaced)
        self.sample_torque = sum(try_force(force, self.body_on_pairs) for force in forces)

    def __repr__(self) -> str:
        return f"System({', '.join(map(repr, (self.body, *self.forces)))})"

    # ------------------------------------------------------------------ energy

    @checked
    def kinetic_energy(self, state: State) -> Any:
        """Return the kinetic energy of a state, eq. (9); shape (...)."""
        instant = self.beside(state.quaternion.shape[:-1]).at(state)
        return instant.body.kinetic_energy(instant.angular_momentum_body)

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
        return np.stack(list(self.beside(state.quaternion.shape[:-1]).at(state).omega_body), axis=-1)

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
        formulation: str | Formulation,
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
        chosen = FORMULATIONS[formulation] if isinstance(formulation, str) else formulation
        comoving = variables[chosen.size :]
        rates, instant = self._traced(chosen, variables, time, scale, axes, self.torque_at)
        return [*rates, *chosen.own_rates(self.own_rates(instant), scale), *axes.rates(time, comoving)]

    def instant_of(self, chosen: Formulation, variables: Any, time: Scalar, scale: Scalar, axes: Axes) -> Instant:
        """Return the instant at variables of a formulation and axes, which are as for `derivatives`."""
        return self._traced(chosen, variables, time, scale, axes, lambda *_: Vector((0.0, 0.0, 0.0)))[1]

    def _traced(
        self,
        chosen: Formulation,
        variables: Any,
        time: Scalar,
        scale: Scalar,
        axes: Axes,
        torque_at: Callable[[Instant, Scalar], Vector],
    ) -> tuple[list[Scalar], Instant]:
        """Return the rates of attitude and angular momentum under a torque, and the instant."""
        own, comoving = variables[: chosen.size], variables[chosen.size :]
        environment, body = axes.environment(time, comoving), self.body_at(chosen.own(own, scale), time)
        seen: list[Instant] = []

        def torque_of(attitude: Attitude, omega: Vector) -> Vector:
            seen.append(Instant(body, attitude, environment, omega))
            return torque_at(seen[0], scale)

        rates = chosen.derivatives(own, body.kinetics(scale), torque_of, axes.omega(time, comoving))
        return rates, seen[0]

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
        body = self.body_at({name: _scalars(values) for name, values in state.own.items()}, state.time)
        return Instant(body, attitude, environment or Environment(state.time), angular_momentum_body=g)

    def body_at(self, own: Mapping[str, Vector], time: Scalar) -> Body:
        """Return the body with its parts, whose variables have values by the name of the part, at a time."""
        if not self.moving_parts:
            return self.body
        values = {part.name: own.get(part.name, Vector(())) for part in self.moving_parts}
        for part in self.moving_parts:
            if len(values[part.name]) != part.size:
                raise ValueError(
                    f"state must have the {part.size} variables of the part {part.name!r}, got "
                    f"{len(values[part.name])}. Make it by system.state(...)."
                )
        return CompositeBody.of(self.body, self.moving_parts, values, time)

    @checked
    def state(
        self,
        attitude: Rotation | ArrayLike,
        *,
        omega_body: ArrayLike | None = None,
        omega_space: ArrayLike | None = None,
        angular_momentum_body: ArrayLike | None = None,
        angular_momentum_space: ArrayLike | None = None,
        time: ArrayLike = 0.0,
        frame: Frame | None = None,
        **own: ArrayLike,
    ) -> State:
        """Return the state of the body with its parts, g = K^-1 omega + h, as `body.state` does without parts.

        Parameters
        ----------
        attitude, omega_body, omega_space, angular_momentum_body, angular_momentum_space, time, frame
            As for `Body.state`: an attitude and exactly one of the four vectors; momenta are those of all together.
        **own : array (k,) or (members, k)
            The variables of parts, each under the name of its part. Default: at rest relative to the body.

        Raises
        ------
        ValueError
            If a momentum is given without the variables of all parts, or variables of no part.
        """
        given = {
            "omega_body": omega_body,
            "omega_space": omega_space,
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        q, name, along = started(attitude, given, time, frame)
        values = self.given_parts(**own)
        counts = [array.shape[:-1] for array in values.values()]
        shape = np.broadcast_shapes(along.shape[:-1], np.shape(time), self.members, *counts)
        if not name.startswith("omega"):
            if left := [part.name for part in self.moving_parts if part.size and part.name not in values]:
                raise ValueError(
                    f"own must name all parts beside a momentum, got none of {left[0]!r}. Give omega_body."
                )
            return state_with(q, along, time, values)
        twin, rate = self.beside(shape), _scalars(along)
        for part in twin.moving_parts:
            if part.size and part.name not in values:
                values[part.name] = _stacked(part.start(np.asarray(time, dtype=float), rate), shape)
        values = {part.name: values[part.name] for part in self.moving_parts if part.size}
        body = twin.body_at({name: _scalars(array) for name, array in values.items()}, time)
        return state_with(q, _stacked(body.angular_momentum(rate), shape), time, values)

    def given_parts(self, **own: ArrayLike) -> Phase:
        """Return the variables of parts that are given at the start, as arrays."""
        sizes = {part.name: part.size for part in self.moving_parts if part.size}
        if unknown := [name for name in own if name not in sizes]:
            known = ", ".join(sizes) or "none"
            raise ValueError(f"own must name parts with variables, {known}, got {unknown[0]!r}.")
        return {name: member_array(name, values, (sizes[name],)) for name, values in own.items()}

    @functools.cached_property
    def moving_parts(self) -> tuple[Part, ...]:
        """What moves inside the body or on it, among the forces."""
        return tuple(force for force in self.forces if isinstance(force, Part))

    @functools.cached_property
    def body_on_pairs(self) -> Body:
        """The first member's body with its parts, on arrays of two values for trials of formulas."""
        twin = self.with_numbers(np.ravel(number)[0] * PAIR for number in self.numbers)
        time, omega = 0.25 * PAIR, Vector(RATES)
        own = {part.name: Vector(x + 0.0 * PAIR for x in part.start(time, omega)) for part in twin.moving_parts}
        return twin.body_at(own, time)

    def body_at_rest(self, time: Scalar) -> Body:
        """Return the body with its parts at rest."""
        at_rest = Vector((0.0, 0.0, 0.0))
        return self.body_at({part.name: part.start(time, at_rest) for part in self.moving_parts}, time)

    @property
    def _displaced(self) -> Body:
        """The body with parts that are nowhere at zero, for forces that know the body."""
        own = {part.name: Vector((1.0,) * part.size) for part in self.moving_parts}
        parts = self.with_numbers(self.numbers).moving_parts
        return CompositeBody.of(self.body, parts, own, 0.0) if parts else self.body

    def rates(self, instant: Instant) -> dict[str, Vector]:
        """Return the time derivatives of quaternion, angular momentum and variables of parts, in physical units.

        q' = q (0, omega)/2, g' = g x omega + tau along the body axes, and own' under the name of each part.
        """
        g, omega, q = instant.angular_momentum_body, instant.omega_body, instant.attitude.quaternion
        return {
            "quaternion": Vector(0.5 * x for x in quat.product(q, quat.pure(omega))),
            "angular_momentum_body": functions.cross(g, omega) + self.torque_at(instant),
            **self.own_rates(instant),
        }

    def own_rates(self, instant: Instant) -> dict[str, Vector]:
        """Return the time derivatives of the variables of the parts, by the name of the part."""
        moving = [part for part in self.moving_parts if part.size]
        if not moving:
            return {}
        pulls = self._pulls(instant, moving)
        return {part.name: Vector(part.rates(instant, pulls[part.name])) for part in moving}

    def _pulls(self, instant: Instant, moving: list[Part]) -> dict[str, Vector]:
        """Return minus the derivatives of the sum of the potentials by the variables of parts."""
        own = {part.name: seeded(instant.own(part), part.name) for part in moving}
        body = self.body_at(own, instant.time)
        energy = self.potential_at(Instant(body, instant.attitude, instant.environment))
        return {part.name: Vector(-partial(energy, part.name, i) for i in range(part.size)) for part in moving}

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


def _stacked(scalars: Iterable[Any], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return scalars, arrays that broadcast to a shape, as the last axis of an array."""
    return np.stack([np.broadcast_to(scalar, shape) for scalar in scalars], axis=-1)


def _scalars(array: ArrayLike) -> Vector:
    """Return the last axis of an array as the scalars of a formula."""
    return functions.Vector(np.moveaxis(np.asarray(array), -1, 0))


def _check_force(force: Any) -> None:
    if isinstance(force, type):
        raise TypeError(f"a force must be an instance, got the class {force.__name__}. Write {force.__name__}(...).")
    if not isinstance(force, Potential | Torque | Part):
        raise TypeError(f"a force must be a Potential, a Torque or a Part, got {described(force)}.")
