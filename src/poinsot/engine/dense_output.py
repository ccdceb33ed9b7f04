"""A motion at any time, from the Taylor polynomials of its steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.engine.state_vector import StateVector
from poinsot.mechanics.state import Phase

__all__ = ["DenseOutput", "KeptSteps"]

Array = NDArray[Any]


class Steps(Protocol):
    """The polynomials of the steps in one direction."""

    @property
    def empty(self) -> bool:
        """Whether there are none."""

    def at(self, times: Array) -> Array:
        """Return the variables at times; shape (n, size)."""


class KeptSteps:
    """The steps of a looped kernel in one direction.

    Parameters
    ----------
    steps : structured array (n,)
        As `looped_kernel.Run.kept` has them.
    """

    def __init__(self, steps: NDArray[Any]) -> None:
        self._starts, self._low = steps["start"].T.copy()
        self._ends = self._starts + steps["length"]
        self._coefficients = steps["coefficients"]  # (n, order + 1, size)

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self._ends.size

    def at(self, times: Array) -> Array:
        """Return the variables at times; shape (n, size)."""
        sign = 1.0 if self._ends[-1] >= self._starts[0] else -1.0
        which = np.minimum(np.searchsorted(sign * self._ends, sign * times), self._ends.size - 1)
        ahead = ((times - self._starts[which]) - self._low[which])[:, None]
        total: Array = self._coefficients[which, -1]
        for order in range(self._coefficients.shape[1] - 2, -1, -1):
            total = total * ahead + self._coefficients[which, order]
        return total


class DenseOutput:
    """A motion at any time between the two that it has reached.

    Parameters
    ----------
    variables : StateVector
    origin : float
        The time of the start.
    start : array (size,)
    """

    def __init__(self, variables: StateVector, origin: float, start: Array) -> None:
        self._variables, self._origin, self._start = variables, origin, np.asarray(start, dtype=float)
        self.parts: Mapping[bool, Steps] = {}
        self.reached: dict[bool, float] = {}

    @property
    def ends(self) -> tuple[float, float]:
        """The earliest time and the latest."""
        return self.reached.get(False, self._origin), self.reached.get(True, self._origin)

    def __call__(self, times: Array) -> Phase:
        """Return q and the momenta."""
        later, earlier = self.parts[True], self.parts[False]
        if earlier.empty and not later.empty:
            return self._variables.to_phase(times, later.at(times))
        out = np.empty((times.size, self._variables.size))
        for part, chosen in ((later, times >= self._origin), (earlier, times < self._origin)):
            if np.any(chosen):
                out[chosen] = self._start if part.empty else part.at(times[chosen])
        return self._variables.to_phase(times, out)
