"""The scale of the momenta in an integrator: a power of two, chosen anew on the way where they grow or shrink.

The engine's step control looks at the largest variable where a step begins: momenta above the size of the attitude
loosen it, and it does not see tiny ones. What leaves the integrator is in the scale of the start.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.engine.discontinuities import lane_of
from poinsot.engine.kernel_momenta import BITS, LEAST, MOST, SMALL
from poinsot.engine.state_vector import StateVector
from poinsot.mechanics.force import PairLoad, Torque
from poinsot.mechanics.part import Part
from poinsot.mechanics.system import System

__all__ = ["Scales"]

FAST, STEADY = 32.0, 4.0
"""How large momenta may have been for all that the steps say, from which on they may have left the band unseen."""

Array = NDArray[Any]


class Scales:
    """What the momenta in the lanes of an integrator are multiplied by, besides the scale of their variables.

    Parameters
    ----------
    system : System
    variables : StateVector
    powers : array
        To which power of the scale each of the kernel's parameters goes.
    lanes : int
    order : int
        Of the Taylor polynomials.
    """

    def __init__(self, system: System, variables: StateVector, powers: Array, lanes: int, order: int) -> None:
        self._system, self._variables, self._powers, self._order = system, variables, powers, order
        self._momenta = variables.momenta
        self._has_torques = any(isinstance(force, Torque | PairLoad | Part) for force in system.forces)
        self._is_free = not system.forces
        self.bits, self._members = np.zeros((2, lanes), dtype=int)

    def begin(self, state: Array, members: NDArray[np.int_]) -> None:
        """Choose the scales for a state in the scale of the start, and change it to them."""
        self._members, self.bits[:] = members, 0
        for lane in self._misfits(state):
            self._choose(state, lane)

    def rescale(self, state: Array, pars: Array) -> None:
        """Choose the scales anew of the lanes that have left the band; change state and parameters to them."""
        for lane in self._misfits(state):
            bits = self.bits[lane]
            self._choose(state, lane)
            own = lane_of(pars, lane)[: self._powers.size]
            own *= self._power_of_two(self._powers * (self.bits[lane] - bits), own)

    def _misfits(self, state: Array) -> list[int]:
        """Return the lanes whose momenta are out of the band."""
        return [] if self._all_fit(state) else [lane for lane in range(self.bits.size) if not self.fits(state, lane)]

    def _all_fit(self, state: Array) -> bool:
        return _within(state[None, self._momenta]) if state.ndim > 1 else self.fits(state)

    def all_fit(self, state: Array, rows: Array) -> bool:
        """Whether all momenta are within the band, of a state and of rows (n, size, lanes), and stayed there."""
        if self._has_torques:
            return False
        return self._all_fit(state) and (self._is_free or _within(rows[:, self._momenta]))

    def fits(self, state: Array, lane: int = 0) -> bool:
        """Return whether the momenta of a lane are within the band, or zero."""
        size = math.hypot(*lane_of(state, lane)[self._momenta].tolist())
        return LEAST <= size <= MOST or self._is_at_limit(size, lane)

    def fit(self, rows: Array, lane: int) -> bool:
        """Return whether the momenta of a lane are so in all of some rows, shape (n, size); NaN is no row."""
        sizes = np.sqrt(_squares(rows[:, self._momenta]))
        return all(self._is_at_limit(float(size), lane) for size in sizes[(sizes < LEAST) | (sizes > MOST)])

    def doubtful(self, lane: int, shortest: float, longest: float) -> bool:
        """Whether momenta may have left the band and come back in steps between two lengths.

        Only torques do so quickly. A step turns the body by no more than about a tenth of its order.
        """
        if not (longest > 0 and self._has_torques):
            return False
        most = self._of(self._inertia, lane) * self._order / (5 * shortest)
        may_fall = not self._is_at_limit(0.5 * LEAST, lane) and (most > STEADY or longest > STEADY * shortest)
        return most > FAST or may_fall

    def _is_at_limit(self, size: float, lane: int) -> bool:
        """Whether no other scale is better for momenta out of the band; what forces give a body at rest counts too."""
        if size < LEAST:
            return size == 0 or self.bits[lane] == BITS[1] or self._of(self._push, lane) >= LEAST
        return size > MOST and self.bits[lane] == BITS[0]

    def parameters(self, constants: Array, lane: int) -> Array:
        """Return the kernel's parameters in a lane, from those in the scale of the start."""
        bits = self.bits[lane]
        return constants * self._power_of_two(self._powers * bits, constants) if bits else constants

    def inward(self, row: Array, lane: int) -> Array:
        """Return variables in the scale of a lane, from those in the scale of the start."""
        return self._variables.rescaled(row, int(self.bits[lane]))

    def outward(self, rows: Array, lane: int) -> Array:
        """Return variables of a lane, shape (..., size), in the scale of the start."""
        return self._variables.rescaled(rows, -int(self.bits[lane]))

    @functools.cached_property
    def _push(self) -> Array:
        return np.ravel(self._system.torque_scale * self._variables.scale)

    @functools.cached_property
    def _inertia(self) -> Array:
        """The largest moment of inertia of a body, times the scale of its momenta."""
        scales = self._variables.scales(self._variables.scale)
        each = zip(self._system.rigid_bodies, scales, strict=True)
        return np.ravel(np.max(np.broadcast_arrays(*(np.max(body.moments, axis=-1) * x for body, x in each)), axis=0))

    def _of(self, values: Array, lane: int) -> float:
        """Return what is a lane's of values in the scale of the start, in its own."""
        return float(values[min(self._members[lane], values.size - 1)] * 2.0 ** self.bits[lane])

    def _choose(self, state: Array, lane: int) -> None:
        own = lane_of(state, lane)
        size = max(float(np.max(np.abs(own[self._momenta]))), self._of(self._push, lane))
        if 0 < size < np.inf:
            bits = int(np.clip(self.bits[lane] + round(math.log2(SMALL) - math.log2(size)), *BITS))
            if bits > self.bits[lane]:
                for attitude, momenta in self._variables.conjugates:
                    q = own[attitude].copy()
                    own[momenta] -= (q @ own[momenta]) / (q @ q) * q
            own[:] = self._variables.rescaled(own, bits - int(self.bits[lane]))
            self.bits[lane] = bits

    @staticmethod
    def _power_of_two(exponents: Array, like: Array) -> Array:
        two = like.dtype.type(2.0)
        return np.array([two ** int(n) for n in exponents], dtype=like.dtype)


def _within(momenta: Array) -> bool:
    """Whether all momenta are within the band, shape (n, size, ...); where NaN comes first, no."""
    if not momenta.size:
        return True
    squares: list[float] = _squares(momenta).ravel().tolist()  # of few numbers a list has its least and largest soonest
    return min(squares) >= LEAST**2 and max(squares) <= MOST**2


def _squares(momenta: Array) -> Array:
    columns = np.asarray(momenta, dtype=float).swapaxes(1, -1)
    return np.asarray(np.vecdot(columns, columns))
