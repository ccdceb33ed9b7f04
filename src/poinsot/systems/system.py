"""A body or two bodies and the forces on them: the one argument that describes the physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import TypeIs, TypeVar

from poinsot.checked import checked
from poinsot.display.formulas import SystemSummary, system_html, system_latex
from poinsot.functions import Vector
from poinsot.immutable import Immutable, cached_property, read_only
from poinsot.kinematics.state import AnyState, State
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, Orbit
from poinsot.mechanics.force import Force
from poinsot.mechanics.pair_instant import AnyInstant
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import described
from poinsot.records.calendar import Calendar
from poinsot.records.units import DerivedUnits, checked_units, dated_units
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.body_integrals import integrals_of_body
from poinsot.systems.dynamics import AnyDynamics, Dynamics, by_class
from poinsot.systems.formula_trials import try_formulas
from poinsot.systems.integrals import Integral
from poinsot.systems.pair_dynamics import PairDynamics
from poinsot.systems.pair_integrals import integrals_of_pair
from poinsot.systems.symbolic_formula import summary_of_system

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from poinsot.kinematics.frame import Frame

__all__ = ["OfOneBody", "OfTwoBodies", "System", "is_of_two_bodies"]

CONTENTS = ("body", "of_bodies", "forces", "parts", "orbits", "members", "span", "calendar")
"""Attributes of a system that belong to its equations of motion."""

CONTENTS_OF = attrgetter(*CONTENTS)

OF_EVERY_RUN = attrgetter("structure", "alike", "numbers", "knots", "inner_blocks", "jumping")
"""Quantities that every run requires: computed with the system."""

Bodies = TypeVar("Bodies", bound=Body | TwoBodies, default=Body | TwoBodies, covariant=True)


class System(Immutable, Generic[Bodies]):
    """One or two rigid bodies together with the forces and parts that act on them.

    poinsot derives the equations of motion q' = q (0, omega) / 2, g' = g x omega + sum of torques, with omega = I^-1 g
    for a body without parts, and detects the conserved quantities.

    Parameters
    ----------
    body : Body or TwoBodies
        The body, or two bodies that attract each other.
    *forces : Potential, Torque, Part or PairLoad
        Forces and parts, built in or user-defined. Without any, the rotation is torque-free. For two bodies, a force
        acts between both, or on one of them: `force.on("secondary")`.
    units : mapping, optional
        Units of the given numbers, for labels of results and plots: `{"time": "s", "inertia": "kg m2"}`, for two bodies
        also `"length": "m"`. poinsot does not convert numbers, so all must be consistent. Without units, quantities are
        dimensionless. Plots convert units if the time is in s, min, h, d or yr and momenta and torques are products of
        powers such as "kg km2".

    Raises
    ------
    TypeError
        If an argument is invalid, or a formula returns a value of another shape or type.

    Examples
    --------
    >>> top = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1, 0, 0)))
    >>> [integral.symbol for integral in top.integrals]
    ['H', 'G3']
    """

    dynamics: Dynamics[Bodies, Any]
    units: dict[str, str]
    body: Bodies
    """The body, or the two bodies."""
    of_bodies: dict[str, Body]
    """Rigid bodies by name, "primary" and "secondary"; the name of a single body is empty."""
    forces: tuple[Force, ...]
    """Forces and parts in the given order."""
    parts: tuple[Part, ...]
    """Moving parts among the forces and within them."""
    orbits: tuple[Orbit, ...]
    """Orbits of the forces, in the order of the forces."""
    members: tuple[int, ...]
    """Shape of the member axis of the numbers: () for a single system, (members,) for an ensemble."""
    span: tuple[float, float]
    """First and last time at which all orbits, fields and tables are known."""
    calendar: Calendar | None
    """Calendar of the times; None if no orbit and no rotation model has a calendar."""
    _seals: ClassVar[bool] = False

    def __init__(self, body: Bodies, *forces: Force, units: Mapping[str, str] | None = None) -> None:
        equations = _equations_of(body)
        names_of_units = checked_units(units, equations.measures)
        for force in forces:
            if isinstance(force, type):
                name = force.__name__
                raise TypeError(f"a force must be an instance, got the class {name}. Write {name}(...).")
        equations.check_kinds(body, forces)
        dynamics = equations(body, forces)
        dynamics.refuse_other_axes()
        OF_EVERY_RUN(dynamics)
        dated = read_only(dated_units(names_of_units, units, dynamics.calendar))
        vars(self).update(zip(CONTENTS, CONTENTS_OF(dynamics), strict=True), dynamics=dynamics, units=dated)
        dynamics.check_forces()
        try_formulas(dynamics)

    @classmethod
    def _of(cls, dynamics: Dynamics[Bodies, Any], units: Mapping[str, str]) -> Self:
        """Return the system of equations of motion that are valid."""
        system = object.__new__(cls)
        vars(system).update(dynamics=dynamics, units=read_only(units))
        return system

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return contents of a system of members, which are read from its equations of motion at first use."""
            if name not in CONTENTS:
                return super().__getattr__(name)
            value = vars(self)[name] = getattr(self.dynamics, name)
            return value

    @property
    def definition(self) -> tuple[Dynamics[Bodies, Any], Mapping[str, str]]:
        """The equations of motion and the units, from which the contents follow."""
        return self.dynamics, self.units

    def __repr__(self) -> str:
        return f"System({', '.join(map(repr, (self.body, *self.forces)))})"

    def _repr_html_(self) -> str:
        return system_html(self._summary())

    def _repr_latex_(self) -> str:
        return system_latex(self._summary())

    def _summary(self) -> SystemSummary:
        return summary_of_system(self.body, self.forces, self.units, self.integrals)

    _member_axes: ClassVar[Mapping[str, int]] = {"dynamics": 0}

    def _with_values(self, dynamics: Dynamics[Bodies, Any]) -> Self:
        return self._of(dynamics, self.units)

    @cached_property
    def integrals(self) -> tuple[Integral, ...]:
        """Integrals of the motion; empty if there are none (for example in Sec. 6.2 of the paper)."""
        dynamics: AnyDynamics = self.dynamics
        if isinstance(dynamics, PairDynamics):
            return integrals_of_pair(dynamics)
        return integrals_of_body(dynamics) if isinstance(dynamics, BodyDynamics) and dynamics.moves_alone else ()

    # ------------------------------------------------------------------ states

    @checked
    def state(
        self,
        attitude: Rotation | ArrayLike | None = None,
        *of_pair: ArrayLike | Sequence[Rotation | ArrayLike],
        omega_body: ArrayLike | None = None,
        omega_space: ArrayLike | None = None,
        angular_momentum_body: ArrayLike | None = None,
        angular_momentum_space: ArrayLike | None = None,
        time: ArrayLike = 0.0,
        frame: Frame | Literal["orbit"] | None = None,
        **own: ArrayLike,
    ) -> State:
        """Return the state of the body with its parts, g = K^-1 omega + h, or the state of two bodies.

        Parameters
        ----------
        attitude, omega_body, omega_space, angular_momentum_body, angular_momentum_space, time, frame
            Same as in `Body.state`: an attitude and exactly one of the four vectors. Momenta are the total momenta of
            body and parts.
        *of_pair
            For two bodies, the first three arguments are `position`, `velocity` and `attitudes`, by place or by name,
            and all arguments are the same as in `TwoBodies.state`.
        **own : array (k,) or (members, k)
            Variables of parts, each under the name of its part. Default: at rest relative to the body.

        Quantities of astropy are converted to the units of the system, if these have names.

        Raises
        ------
        ValueError
            If a momentum is given without the variables of all parts, or a variable belongs to no part.
        """
        vectors = {
            "omega_body": omega_body,
            "omega_space": omega_space,
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        units = DerivedUnits(self.units)
        place = () if attitude is None else (attitude, *of_pair)
        if of_pair:
            place = tuple(map(units.converted, ("position", "velocity", "attitudes"), place))
        vectors, own = ({name: units.converted(name, value) for name, value in each.items()} for each in (vectors, own))
        return self.dynamics.state(place, vectors, units.converted("time", time), frame, own)  # type: ignore[return-value]

    def at(self, state: AnyState, environment: Environment | None = None) -> AnyInstant:
        """Return the instant of a state, the argument of formulas."""
        instant: AnyInstant = self.dynamics.at(state, environment)
        return instant

    def rates(self, instant: AnyInstant) -> dict[str, Vector]:
        """Return the vector field at an instant by block, in physical units.

        q' = q (0, omega)/2 and g' = g x omega + torques along the body axes, the rates of the parts under their names,
        and r' and p' of the relative orbit of two bodies under "orbit".
        """
        return self.dynamics.rates(instant)

    # ------------------------------------------------------------------ energy

    @checked
    def kinetic_energy(self, state: AnyState) -> Any:
        """Return the kinetic energy of a state, eq. (9); shape (...)."""
        twin = self.dynamics.broadcast_to(state.shape)
        with np.errstate(over="ignore"):
            return twin.kinetic_at(twin.at(state))

    @checked
    def potential_energy(self, state: AnyState, environment: Environment | None = None) -> Any:
        """Return the sum of the energies of the potentials at a state; shape (...)."""
        shape = state.shape
        twin = self.dynamics.broadcast_to(shape)
        return np.broadcast_to(np.asarray(twin.potential_at(twin.at(state, environment))), shape)[()]

    @checked
    def energy(self, state: AnyState) -> Any:
        """Return kinetic plus potential energy, the Hamiltonian where there is one; shape (...)."""
        return self.dynamics.energy(state)

    # ------------------------------------------------------------------ angular velocity, torques and forces

    @checked
    def omega_body(self, state: AnyState, body: str | None = None) -> NDArray[np.float64]:
        """Return the inertial angular velocity along the body axes; shape (..., 3).

        For two bodies, `body` is "primary" or "secondary".
        """
        return self.dynamics.omega_body(state, body)

    @checked
    def torque_body(
        self, state: AnyState, environment: Environment | None = None, body: str | None = None
    ) -> NDArray[np.float64]:
        """Return the sum of all torques at a state along the body axes; shape (..., 3).

        For two bodies, `body` is "primary" or "secondary".
        """
        return _sum_of(self.torques_body(state, environment, body), state)

    @checked
    def torques_body(
        self, state: AnyState, environment: Environment | None = None, body: str | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Return the torque of each force at a state along the body axes, by its class; each of shape (..., 3).

        The second of several forces of one class is "RadiationPressure 2", and so on. For two bodies, `body` is
        "primary" or "secondary".
        """
        twin, name = self.dynamics.broadcast_to(state.shape), self.dynamics.name_of_body(body)
        return by_class(twin.each_torque_at(twin.at(state, environment), name), state.shape)

    @checked
    def force_space(
        self, state: AnyState, environment: Environment | None = None, body: str | None = None
    ) -> NDArray[np.float64]:
        """Return the sum of all forces on one of two bodies along the space axes; shape (..., 3)."""
        return _sum_of(self.forces_space(state, environment, body), state)

    @checked
    def forces_space(
        self, state: AnyState, environment: Environment | None = None, body: str | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Return each force on one of two bodies along the space axes, by its class; each of shape (..., 3).

        The forces on the two bodies are opposite. An attractor outside of the pair also accelerates the barycentre;
        its force here is the force relative to the barycentre.
        """
        twin, name = self.dynamics.broadcast_to(state.shape), self.dynamics.name_of_body(body)
        return by_class(twin.each_force_at(twin.at(state, environment), name), state.shape)

    # ------------------------------------------------------------------ validity of formulas

    @checked
    def validity(self, state: AnyState, environment: Environment | None = None) -> dict[str, NDArray[np.bool_]]:
        """Return, by name, whether a formula is used at a state outside of its range; each of shape (...)."""
        return self._of_forces(lambda force: force.validity, np.logical_or, state, environment)

    @checked
    def relative_errors(
        self, state: AnyState, environment: Environment | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Return estimates of the relative errors of formulas, by their names in `validity`; each of shape (...)."""
        return self._of_forces(lambda force: force.relative_errors, np.maximum, state, environment)

    @checked
    def limits(self, state: AnyState, environment: Environment | None = None) -> dict[str, NDArray[np.bool_]]:
        """Return, by name, whether a quantity of a part or of a control law is at its limit; each of shape (...)."""
        return self._of_forces(lambda force: force.limits, np.logical_or, state, environment)

    def _of_forces(
        self,
        formula: Callable[[Force], Callable[[Any], Mapping[str, Any]]],
        both: np.ufunc,
        state: AnyState,
        environment: Environment | None,
    ) -> dict[str, NDArray[Any]]:
        """Return values of the forces at a state by name; both of two values with the same name."""
        shape = state.shape
        twin = self.dynamics.broadcast_to(shape)
        instant = twin.at(state, environment)
        out = dict[str, NDArray[Any]]()
        for name, value in (item for force in twin.forces for item in formula(force)(instant).items()):
            out[name] = both(np.broadcast_to(value, shape), out.get(name, value))
        return out


def _equations_of(body: Body | TwoBodies) -> Any:
    """Return the class of the equations of motion of one or of two bodies."""
    if isinstance(body, TwoBodies):
        return PairDynamics
    if isinstance(body, Body):
        return BodyDynamics
    raise TypeError(f"body must be a Body or TwoBodies, got {described(body)}. The order is System(body, *forces).")


def is_of_two_bodies(system: System) -> TypeIs[System[TwoBodies]]:
    """Return True for a system of two bodies."""
    return isinstance(system.body, TwoBodies)


def _of_one_body(name: str, system: System) -> System:
    if is_of_two_bodies(system) or not system.dynamics.moves_alone:
        raise TypeError(
            f"{name} must be a System of one body, got one of two bodies. These have propagate, state_transition, "
            "chaos_indicators, lyapunov_spectrum, periodic_motion and pair_equilibria."
        )
    return system


def _of_two_bodies(name: str, system: System) -> System:
    if not is_of_two_bodies(system):
        raise TypeError(
            f"{name} must be a System of two bodies, got one of one body. Write System(TwoBodies(...), ...)."
        )
    return system


OfOneBody = Annotated[System[Body], _of_one_body]
OfTwoBodies = Annotated[System[TwoBodies], _of_two_bodies]
"""Annotations of arguments that are systems of one body or of two bodies."""


def _sum_of(each: Mapping[str, NDArray[np.float64]], state: AnyState) -> NDArray[np.float64]:
    return sum(each.values(), start=np.zeros((*state.shape, 3)))
