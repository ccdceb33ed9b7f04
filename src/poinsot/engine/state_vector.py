"""The variables of an integration: a formulation, the axes it refers to, and the scale of its momenta."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.engine.formulations import Formulation
from poinsot.engine.problem import Problem
from poinsot.mechanics.axes import SpaceAxes, TrackingEnvironment
from poinsot.mechanics.environment import Axes, Environment, Orbit
from poinsot.mechanics.shared_orbits import same, tracked_orbits
from poinsot.mechanics.state import Phase, State

if TYPE_CHECKING:
    from poinsot.engine.variational import Variations

__all__ = ["SMALL", "Coordinates", "IntegratedEnvironment"]

Array = NDArray[np.float64]

SMALL = 0.1
"""The size given to the momenta: below that of q, so that the engine's step control, which looks at the
largest variable, keeps its grip on the attitude."""

BLOCK = 8192
"""Rows converted together: their intermediate results stay in the processor's cache."""


@dataclass(frozen=True)
class Coordinates:
    """Variables of a kernel: those of the formulation, of the axes, and of the variational equations, in this order."""

    formulation: Formulation
    axes: Axes
    scale: Any
    variations: Variations | None = None

    @property
    def size(self) -> int:
        """The number of variables."""
        return self.formulation.size + self.axes.size + (self.variations.size if self.variations else 0)

    @property
    def comoving(self) -> slice:
        """Where the variables of the axes are."""
        return slice(self.formulation.size, self.formulation.size + self.axes.size)

    @property
    def variational(self) -> slice:
        """Where the variables of the variational equations are."""
        return slice(self.comoving.stop, None)

    @property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations of axes and variational equations."""
        variations = self.variations and replace(self.variations, initial=None)
        return (*self.axes.structure, variations)

    @functools.cached_property
    def _momenta(self) -> list[int]:
        """Where momenta are, and components of tangent vectors that scale with them."""
        own = self.formulation.momenta
        along = self.variations.momenta if self.variations else []
        return [*range(own.start, own.stop), *(self.variational.start + place for place in along)]

    def rescaled(self, rows: Array, bits: int) -> Array:
        """Return rows of variables with the scale of their momenta multiplied by 2^bits; shape (..., size)."""
        if not bits:
            return rows
        rows = rows.copy()
        rows[..., [place for place in self._momenta if place < rows.shape[-1]]] *= rows.dtype.type(2.0) ** bits
        return rows

    def of_members(self, members: NDArray[np.int_]) -> Coordinates:
        """Return the variables of some members of an ensemble."""

        def chosen(number: Any) -> Any:
            return number[members] if np.ndim(number) else number

        axes = self.axes.with_numbers(map(chosen, self.axes.numbers))
        return Coordinates(self.formulation, axes, chosen(self.scale), self.variations)

    def from_state(self, state: State) -> Array:
        """Return the variables of a state; shape (..., size)."""
        own = self._from_state(state)
        self.formulation.check_variables(own)
        if self.variations is None:
            return own
        start = self.variations.start()
        return np.concatenate([own, np.broadcast_to(start, (*own.shape[:-1], start.shape[-1]))], axis=-1)

    def _from_state(self, state: State) -> Array:
        own = self.formulation.from_state(state)
        own[..., self.formulation.momenta] *= np.expand_dims(np.array(self.scale, dtype=own.dtype), -1)
        if not self.axes.size:
            return own
        axes = self.axes.with_numbers(map(np.longdouble, self.axes.numbers))  # to round once, at the end
        comoving = axes.start(state.time)
        self._turn(own, quat.conjugate(axes.quaternion(state.time, comoving)))
        high = np.asarray(comoving, dtype=np.float64)
        low = np.asarray(comoving - high, dtype=np.float64)
        comoving = high.astype(own.dtype) + low.astype(own.dtype)
        return np.concatenate([own, np.broadcast_to(comoving, (*own.shape[:-1], axes.size))], axis=-1)

    def _turn(self, own: Array, turn: Array) -> None:
        for block in self.formulation.quaternions:
            own[..., block] = quat.product(turn, own[..., block])

    def to_phase(self, times: Array, variables: Array) -> Phase:
        """Return q and the momenta of the variables along the times; shapes (..., n, 4) and (..., n, 3 or 4)."""
        if variables.ndim == 3 or len(times) <= BLOCK:
            return self._converted(times, variables)
        blocks = [slice(i, i + BLOCK) for i in range(0, len(times), BLOCK)]
        parts = [self._converted(times[block], variables[block]) for block in blocks]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _converted(self, times: Array, variables: Array) -> Phase:
        own, comoving = variables[..., : self.formulation.size].copy(), variables[..., self.comoving]
        own[..., self.formulation.momenta] /= np.expand_dims(self.scale, (-1, -2))
        if self.axes.size:
            axes = self.axes
            if variables.ndim == 3:  # members first: their numbers go beside the times
                axes = axes.with_numbers(number[..., None] for number in axes.numbers)
            self._turn(own, axes.quaternion(times, comoving))
        return self.formulation.to_phase(own)

    def environment(self, problem: Problem, times: Array, comoving: Array) -> Environment:
        """Return the world at the times, with the variables of the axes there, shape (..., n, axes.size)."""
        return IntegratedEnvironment(
            times, problem.beside(comoving.shape[:-1]), self.axes, np.moveaxis(comoving, -1, 0)
        )


class IntegratedEnvironment(TrackingEnvironment):
    """The world at the times of a motion, along the space axes: orbits that were integrated along as they came out.

    `carried` are the variables of the axes, shape (..., n, size).
    """

    def __init__(self, times: Array, problem: Problem, axes: Axes, comoving: Array) -> None:
        own: Any = problem.space_axes if isinstance(axes, SpaceAxes) else problem.common_axes
        super().__init__(times, own, comoving)
        self._orbits = tracked_orbits(problem)
        self.comoving = np.moveaxis(comoving, 0, -1)

    def _of(self, orbit: Orbit) -> Environment:
        if not orbit.tracked:
            return Environment(self.time)
        path: Any = orbit.axes
        paths: Iterator[tuple[Orbit, Any]] = ((own, own.axes) for own in self._orbits)
        integrated = next((own for own, axes in paths if same(axes, path)), None)
        return Environment(self.time) if integrated is None else super()._of(integrated)
