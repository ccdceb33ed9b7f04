"""Square roots of what is zero at the start, such as the length of the rate of a body at rest.

A series of sqrt(s) about s = 0 does not exist. There the kernel takes sqrt(s + e^2), e a billionth of the size of the
root: what a motion from rest makes of the difference is of the size e^2, below rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.replay import Replay, wide
from poinsot.engine.discontinuities import lane_of
from poinsot.engine.heyoka_expressions import Expressions
from poinsot.engine.kernel_momenta import SMALL
from poinsot.engine.lowering import TIME, Program

__all__ = ["Roots", "StartRoots"]

NEGLIGIBLE = 1e-9
"""The part of the size of a root that counts for nothing when squared."""


class Roots:
    """The square roots in the equations of one integrator.

    Parameters
    ----------
    roots : list
        What is under each root, and the number of its parameter.
    made : Expressions
        Of the integrator.
    momenta : slice or list of int
        Where the momenta are among them.
    kind : type
        Of the numbers.
    """

    def __init__(self, roots: list[tuple[Any, int]], made: Expressions, momenta: slice | list[int], kind: Any) -> None:
        self._places = [place for _, place in roots]
        self._momenta = momenta
        self._look = made.compiled([argument for argument, _ in roots], kind) if roots else None

    def begin(self, engine: Any) -> None:
        """Set the parameters for the time and the state of an integrator, of all its lanes."""
        if self._look is None:
            return
        for lane, time in enumerate(np.ravel(engine.time)):
            state, pars = np.array(lane_of(engine.state, lane)), lane_of(engine.pars, lane)
            known = np.ascontiguousarray(pars[: self._look.nparams])
            moving = state.copy()
            kind = state.dtype.type
            moving[self._momenta] += kind(SMALL)
            here, there = (self._look(np.append(x, time), pars=known) for x in (state, moving))
            pars[self._places] = np.where((here == kind(0)) & (there > kind(0)), kind(NEGLIGIBLE**2) * there, kind(0))


class StartRoots:
    """The square roots in the equations of members, whose parameters depend on their starts.

    Parameters
    ----------
    program : Program
    size : int
        How many variables there are.

    Attributes
    ----------
    places : list of int
        The numbers of the parameters.
    """

    def __init__(self, program: Program, size: int) -> None:
        self.places = [root.parameter for root in program.roots]
        symbols = [root.argument.graph.symbol(name) for root in program.roots[:1] for name in (*range(size), TIME)]
        self._under = Replay([root.argument for root in program.roots], np.asarray, symbols)

    def set(
        self,
        table: NDArray[np.float64],
        numbers: Sequence[Any],
        starts: NDArray[np.float64],
        times: NDArray[np.float64],
        momenta: slice | list[int],
    ) -> None:
        """Set the parameters of members, shape (members, parameters), for their starts, shape (members, size)."""
        moving = starts.copy()
        moving[:, momenta] += SMALL
        given = [*map(wide, numbers)]
        resting, turning = (self._under([*rows.T, times, *given]) for rows in (starts, moving))
        for place, here, there in zip(self.places, resting, turning, strict=True):
            table[:, place] = np.where((here == 0) & (there > 0), NEGLIGIBLE**2 * there, 0.0)
