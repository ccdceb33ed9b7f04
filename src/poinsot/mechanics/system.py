"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.display.formulas import SystemSummary, system_html, system_latex
from poinsot.errors import member_array
from poinsot.functions import Vector
from poinsot.lazy import cached_property
from poinsot.mechanics.body import Body, started
from poinsot.mechanics.dynamics import Dynamics, scalars, stacked
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, PairLoad, Potential, Torque
from poinsot.mechanics.formula_trials import on_pairs, trial, try_event, try_formulas
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.members import EveryMember
from poinsot.mechanics.part import CompositeBody, Part, check_parts
from poinsot.mechanics.state import Phase, State, state_with
from poinsot.mechanics.symbolic_formula import summary_of_system
from poinsot.mechanics.units import checked_units, dated_units
from poinsot.printable import described, nearest, quoted

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from poinsot.mechanics.frame import Frame

__all__ = ["System"]

OF_EVERY_RUN = attrgetter("orbits", "knots", "span")
"""What every run asks for: computed with the system."""


class System(Dynamics):
    """Rigid body together with the forces and parts that act on it.

    poinsot derives the equations of motion q' = q (0, omega) / 2, g' = g x omega + sum of torques, with omega = I^-1 g
    for a body without parts, and detects the conserved quantities.

    Parameters
    ----------
    body : Body
        The body, or a `TwoBodies` for two bodies that attract each other.
    *forces : Potential, Torque or Part
        Forces and parts, built in or user-defined. Without any, the rotation is torque-free.
    units : mapping, optional
        Units of the given numbers, for labels of results and plots: `{"time": "s", "inertia": "kg m2"}`. poinsot does
        not convert numbers, so all must be consistent. Without units, quantities are dimensionless. Plots convert units
        if the time is in s, min, h, d or yr and momenta and torques are products of powers such as "kg km2".

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

    measures: ClassVar[tuple[str, ...]] = ("time", "inertia")
    """What its numbers have units of."""
    body_names: ClassVar[tuple[str, ...]] = ("",)
    """What the names of its rigid bodies begin with in a phase."""
    moves_alone: ClassVar[bool] = True
    """Whether its forces are all that moves it."""

    numbering: NDArray[np.int_] | EveryMember = EveryMember()
    """Numbers that the members had in the ensemble from which they were selected."""

    _of: ClassVar[dict[type, type[System]]] = {}

    def __init_subclass__(cls, of: type | None = None) -> None:
        """Let a subclass be what a system of another kind of body is."""
        super().__init_subclass__()
        if of is not None:
            System._of[of] = cls

    def __new__(cls, body: Any = None, *_: Any, **__: Any) -> System:
        """Return a system of the kind that the body asks for, not yet filled."""
        return object.__new__(cls._of.get(type(body), cls))

    def __init__(self, body: Body, *forces: Force, units: Mapping[str, str] | None = None) -> None:
        if not isinstance(body, (Body, *self._of)):
            raise TypeError(
                f"body must be a Body or TwoBodies, got {described(body)}. The order is System(body, *forces)."
            )
        self.body = body
        self.forces = forces
        self.units = checked_units(units, self.measures)
        for force in forces:
            if isinstance(force, type):
                name = force.__name__
                raise TypeError(f"a force must be an instance, got the class {name}. Write {name}(...).")
        self._check_kinds()
        self.refuse_other_axes()
        OF_EVERY_RUN(self)
        self.units = dated_units(self.units, units, self.calendar)
        self._check()

    def _check_kinds(self) -> None:
        """Raise a TypeError for a force of another kind."""
        for force in self.forces:
            if isinstance(force, PairLoad):
                force.check(self.body)
            if not isinstance(force, Potential | Torque | Part):
                hint = " Give them one by one: System(body, *forces)." if isinstance(force, list | tuple) else ""
                raise TypeError(f"a force must be a Potential, a Torque or a Part, got {described(force)}.{hint}")

    def _check(self) -> None:
        """Raise an error for forces that are not of this body, or whose formulas are none."""
        check_parts(self.body, self.forces)
        for force in self.forces:
            force.check(self._displaced)
        self.known(try_formulas)

    def try_event(self, event: Event) -> None:
        """Raise a TypeError for an event whose formulas are none."""
        try_event(event, trial(event, self.body_on_pairs))

    def __repr__(self) -> str:
        return f"System({', '.join(map(repr, (self.body, *self.forces)))})"

    def _repr_html_(self) -> str:
        return system_html(self._summary())

    def _repr_latex_(self) -> str:
        return system_latex(self._summary())

    def _summary(self) -> SystemSummary:
        return summary_of_system(self.body, self.forces, self.units, self.integrals)

    @cached_property
    def integrals(self) -> tuple[Integral, ...]:
        """Integrals of the motion; empty if there are none (for example in Sec. 6.2 of the paper)."""
        return integrals_of(self)

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
        """Return the state of the body with its parts, g = K^-1 omega + h.

        Parameters
        ----------
        attitude, omega_body, omega_space, angular_momentum_body, angular_momentum_space, time, frame
            Same as in `Body.state`: an attitude and exactly one of the four vectors. Momenta are the total momenta of
            body and parts.
        **own : array (k,) or (members, k)
            Variables of parts, each under the name of its part. Default: at rest relative to the body.

        Raises
        ------
        ValueError
            If a momentum is given without the variables of all parts, or a variable belongs to no part.
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
            if left := [part.name for part in self.parts if part.size and part.name not in values]:
                raise ValueError(
                    f"own must name all parts where a momentum is given, got none of {quoted(left[0])}. Give "
                    f"omega_body."
                )
            return state_with(q, along, time, values)
        twin, rate = self.beside(shape), scalars(along)
        for part in twin.parts:
            if part.size and part.name not in values:
                values[part.name] = stacked(part.start(np.asarray(time, dtype=float), rate), shape)
        values = {part.name: values[part.name] for part in self.parts if part.size}
        body = twin.body_at({name: scalars(array) for name, array in values.items()}, time)
        return state_with(q, stacked(body.angular_momentum(rate), shape), time, values)

    def given_parts(self, **own: ArrayLike) -> Phase:
        """Return the variables of parts that are given at the start, as arrays."""
        sizes = {part.name: part.size for part in self.parts if part.size}
        if unknown := [name for name in own if name not in sizes]:
            known = ", ".join(sizes) or "none"
            raise ValueError(
                f"own must name parts with variables, {known}, got {quoted(unknown[0])}.{nearest(unknown[0], sizes)}"
            )
        return {name: member_array(name, values, (sizes[name],)) for name, values in own.items()}

    def numbered(self, count: int) -> NDArray[np.int_]:
        """Return the numbers of as many members in the ensemble that they were chosen from."""
        known = self.numbering
        return np.arange(count) if isinstance(known, EveryMember) or known.size != count else np.atleast_1d(known)

    @property
    def _member_axes(self) -> dict[str, int]:
        own = ("body", "forces", "numbering") if self._draws else ("body", "forces") if self.members else ()
        return dict.fromkeys(own, 0)

    def _with_values(self, body: Body, forces: tuple[Force, ...], **numbering: NDArray[np.int_]) -> System:
        system = System(body, *forces, units=self.units)
        system._complete(**numbering)
        return system

    @property
    def _draws(self) -> bool:
        """True if a part draws random numbers, which depend on the numbering of the members."""
        return any(part.jump and part.jump.draws for part in self.parts)

    @cached_property
    def body_on_pairs(self) -> Body:
        """The first member's body with its parts, on arrays of two values for trials of formulas."""
        return on_pairs(self)

    @property
    def rigid_bodies(self) -> tuple[Body, ...]:
        """The bodies: one or two."""
        return (self.body,)

    @property
    def _displaced(self) -> Body:
        """The body with parts that are nowhere at zero, for forces that know the body."""
        own = {part.name: Vector((1.0,) * part.size) for part in self.parts}
        parts = self.with_numbers(self.numbers).parts
        return CompositeBody.of(self.body, parts, own, 0.0) if parts else self.body
