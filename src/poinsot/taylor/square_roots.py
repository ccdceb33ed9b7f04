"""Square roots of what is zero at the start, such as the length of the rate of a body at rest.

A series of sqrt(s) about s = 0 does not exist. There the kernel computes sqrt(s + e^2), e a billionth of the size of
the root. In a motion from rest the difference is of the size e^2, below the rounding error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.graph import Evaluator, wide
from poinsot.taylor.lowering import TIME, Program
from poinsot.taylor.rescaling import MOMENTUM_SCALE

__all__ = ["StartRoots"]


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
        self._under = Evaluator([root.argument for root in program.roots], np.asarray, symbols)

    def set(
        self,
        table: NDArray[np.float64],
        numbers: Sequence[Any],
        starts: NDArray[np.float64],
        times: NDArray[np.float64],
        momenta: slice | list[int],
        negligible: float,
    ) -> None:
        """Set the parameters of members, shape (members, parameters), for their starts, shape (members, size).

        The part `negligible` of the size of a root counts for nothing when squared.
        """
        moving = starts.copy()
        moving[:, momenta] += MOMENTUM_SCALE
        given = [*map(wide, numbers)]
        resting, turning = (self._under([*rows.T, times, *given]) for rows in (starts, moving))
        for place, here, there in zip(self.places, resting, turning, strict=True):
            table[:, place] = np.where((here == 0) & (there > 0), negligible**2 * there, 0.0)
