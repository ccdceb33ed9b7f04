"""A body and the forces on it: its energy, its equations of motion and its integrals."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.checked import checked
from poinsot.display.formulas import SystemSummary, system_html, system_latex
from poinsot.errors import member_array
from poinsot.functions import Vector
from poinsot.lazy import cached_property
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body, started
from poinsot.mechanics.branch_exploration import BRANCHES, conditions, on_branches
from poinsot.mechanics.dynamics import Dynamics, scalars, stacked
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Force, PairLoad, Potential, Torque
from poinsot.mechanics.formula_trials import on_pairs, sample_torque, trial, try_event
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.integrals import Integral, integrals_of
from poinsot.mechanics.part import CompositeBody, Part, check_parts
from poinsot.mechanics.probing import sample_times, samples
from poinsot.mechanics.state import Phase, State, changed, state_of, state_with
from poinsot.mechanics.symbolic_formula import summary_of_system
from poinsot.mechanics.units import checked_units, dated_units
from poinsot.printable import described, nearest, quoted
from poinsot.taylor.graph import Graph

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from poinsot.mechanics.frame import Frame

__all__ = ["System"]

OF_EVERY_RUN = attrgetter("orbits", "knots", "span")
"""What every run asks for: computed with the system."""

SMALLEST, LARGEST = 2.0**-512, 2.0**512
"""Of a scale of momenta: the squares of others would underflow, and count as zero, or overflow."""

AT_REST = 1e-9
"""Of the rate of a variable whose part has no momentum: what is slower is at rest, and its rate mostly rounding."""


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

    numbering: NDArray[np.int_] | None = None
    """Which members of an ensemble they are that it has the numbers of; None of all."""

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
        self.sample_torque = sample_torque(self)

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
        return np.arange(count) if known is None or known.size != count else known

    @cached_property
    def body_on_pairs(self) -> Body:
        """The first member's body with its parts, on arrays of two values for trials of formulas."""
        return on_pairs(self)

    def momentum_scale(self, state: State) -> Any:
        """Return the size of the angular momentum that the motion from a state will have, roughly; shape (...).

        The larger of |g| and what the forces would give a body at rest; 1 where all is zero.
        """
        return self._momentum_scale(state, self.torque_scale)

    def momentum_scale_of_members(self, state: State) -> Any:
        """Return the same for one body as for it among members: from the samples of torques that members have."""
        return self._momentum_scale(state, self._scale(self._strongest_at_samples(self.known(_branches))))

    def _momentum_scale(self, state: State, largest: Any) -> Any:
        each = [state.angular_momentum_body]
        for part in self.parts:
            each += [state.own[part.name][..., place] for place in part.momentum_places]
        largest = _largest(largest, *[_length(*_columns(momenta)) for momenta in each])
        return _smallest(largest + (largest < SMALLEST), LARGEST)

    @property
    def rigid_bodies(self) -> tuple[Body, ...]:
        """The bodies: one or two."""
        return (self.body,)

    def momentum_ratios(self, state: State) -> dict[str, Any]:  # noqa: ARG002
        """Return the factors that scale the angular momenta of the bodies to the size of the first."""
        return {"": 1.0}

    def sizes_of_blocks(self, state: State) -> dict[str, NDArray[np.float64]]:
        """Return the sizes of the variables of parts, or their change while the body rotates by a radian; (..., k).

        A part at rest goes as far as one without momentum in a body that turns as fast, about any axis. Those of parts
        that are angular momenta alone are left out.
        """
        names = [part.name for part in self.parts if part.momenta < set(part.variables)]
        if not names:
            return {}
        twin, g = self.beside(state.shape), np.linalg.norm(state.angular_momentum_body, axis=-1)
        without = {"quaternion": state.quaternion, **changed(state.own, np.zeros_like)}
        turning = [state_of(without | {"angular_momentum_body": g[..., None] * axis}, state.time) for axis in np.eye(3)]
        with np.errstate(all="ignore"):
            speed = np.asarray(self.speed(state))[..., None]
            fastest = np.where(speed > 0, speed, 1.0)
            each = [twin.block_rates(twin.at(start)) for start in (state, *turning)]
        sizes = {}
        for name in names:
            here, *there = (np.abs(np.stack(np.broadcast_arrays(*rates[name]), axis=-1)) for rates in each)
            farthest = np.max(there, axis=0)
            changes = np.where(here > AT_REST * farthest, here, farthest) / fastest
            sizes[name] = np.maximum(np.abs(state.own[name]), changes)
        return sizes

    @cached_property
    def torque_scale(self) -> Any:
        """The angular momentum that differences of energies, and torques, at samples stand for; shape (...)."""
        branching = self.known(_branches)
        one = not branching and not self.members
        return self._scale(self.sample_torque if one else self._strongest_at_samples(branching))

    def _scale(self, torque: Any) -> Any:
        return np.sqrt(_largest(*_columns(self.body.moments)) * torque)

    def _strongest_at_samples(self, branching: bool) -> Any:
        with np.errstate(all="ignore"):
            graph, sizes = self.traced_sizes()
            found = [graph.evaluated(sizes), *[on_branches(graph, sizes)] * branching]
            return functools.reduce(np.maximum, map(self._summed, found))

    def _summed(self, sizes: list[Any]) -> Any:
        """Return the sum of the largest torques, and of the largest energies over the least, of each member."""
        ranges = (
            np.max(size, axis=-1) - (np.min(size, axis=-1) if isinstance(force, Potential) else 0.0)
            for force, size in zip(self.forces, map(np.atleast_1d, sizes), strict=True)
        )
        return sum(np.nan_to_num(each, posinf=0.0) for each in ranges)

    def traced_sizes(self) -> tuple[Graph, list[Any]]:
        """Return the energies of potentials, or the sizes of torques, on a body at rest at samples, and their graph."""
        (q, _, _), t = samples(self, BRANCHES), sample_times(self, BRANCHES)
        graph, twin, at_rest = Graph(), self.beside((*self.members, BRANCHES)), Vector((0.0, 0.0, 0.0))
        time = graph.variable(t)
        body = twin.body_at({part.name: part.start(time, at_rest) for part in twin.parts}, time)
        instant = Instant(body, Attitude.from_quaternion(Vector(q.T)), Environment(time), at_rest)
        with np.errstate(all="ignore"):
            return graph, [_size(force, instant) for force in twin.forces]

    @property
    def _displaced(self) -> Body:
        """The body with parts that are nowhere at zero, for forces that know the body."""
        own = {part.name: Vector((1.0,) * part.size) for part in self.parts}
        parts = self.with_numbers(self.numbers).parts
        return CompositeBody.of(self.body, parts, own, 0.0) if parts else self.body


def _columns(array: NDArray[np.float64]) -> Any:
    """Return the components of one vector as numbers, in a tenth of NumPy's time, or those of members as arrays."""
    return array.tolist() if array.ndim == 1 else array.T


def _combined(of_numbers: Callable[..., Any], of_arrays: Callable[..., Any], *operands: Any) -> Any:
    """Combine numbers, or those of members in arrays: NumPy takes a microsecond for three numbers."""
    return functools.reduce(of_arrays, operands) if np.ndarray in map(type, operands) else of_numbers(*operands)


_largest = functools.partial(_combined, max, np.maximum)
_smallest = functools.partial(_combined, min, np.minimum)
_length = functools.partial(_combined, math.hypot, np.hypot, 0.0)  # a single component has a sign, its length none


def _size(force: Any, instant: Instant) -> Any:
    if isinstance(force, Part):
        return 0.0
    if isinstance(force, Potential):
        return force.energy(instant)
    return functions.norm(force.torque(instant))


def _branches(system: System) -> bool:
    """Whether the formula of a force has a condition on the time or an orbit."""
    return bool(conditions(system.traced_sizes()[1]))
