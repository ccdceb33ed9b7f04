"""States of a motion at any time, from its dense output."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import real_numbers
from poinsot.mechanics.part import jumps_at
from poinsot.mechanics.state import Phase, State, changed, state_of
from poinsot.mechanics.system import System
from poinsot.quantities import Times

__all__ = ["Dense", "dense_states"]

Dense = tuple[Callable[[NDArray[np.float64]], Phase], float, float]
"""Dense output: a function of times, and the first and the last time at which it is defined."""


def dense_states(dense: Dense | None, system: System, time: Times) -> State:
    """Return the state at a time, or a batch of states at an array of times."""
    if dense is None:
        raise ValueError(
            "a trajectory must have dense output to be called, got none. Propagate one motion with dense=True."
        )
    interpolant, first, last = dense
    time = time if system.calendar is None else system.calendar.time(time)
    t = real_numbers("time", time, system.units["time"])
    if t.size and (t.min() < first or t.max() > last):
        outside = t.min() if t.min() < first else t.max()
        raise ValueError(f"time must lie within [{first:.15g}, {last:.15g}], got {outside:.15g}.")
    phase = changed(interpolant(t.ravel()), lambda x: x.reshape(*t.shape, x.shape[-1]))
    return state_of(phase, t, jumps_at(system.dynamics.jumping, t))  # type: ignore[return-value]
