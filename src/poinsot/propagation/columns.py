"""The columns of a motion's dataset: each computed once, in blocks of times, with integrals and their drifts."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.environment import Dated, within
from poinsot.mechanics.integrals import Integral
from poinsot.mechanics.state import AnyState

__all__ = ["along_times"]

Array = NDArray[np.float64]
EVERY = slice(None)
ENERGIES, PROOF = {"kinetic_energy", "potential_energy"}, ("integral_", "drift_")
BLOCK = 16_384
"""Rows that columns are computed of at once, so that what lies between them stays in the cache."""


class HasColumns(Protocol):
    """A motion, as far as its columns need it."""

    system: Any
    initial: AnyState
    times: Array

    def __len__(self) -> int:
        """Return the number of members."""

    @property
    def is_ensemble(self) -> bool:
        """Whether it has members."""

    @property
    def _state(self) -> AnyState:
        """Its states."""

    @property
    def _columns(self) -> Mapping[str, Callable[[], Array]]:
        """What computes each of the columns but integrals and drifts."""

    @property
    def _momentum_size(self) -> Array:
        """What drifts of momenta are measured against."""

    @property
    def _in_memory(self) -> HasColumns:
        """The same with its arrays in memory."""

    def _at_hand(self, names: Collection[str]) -> dict[str, Array]:
        """Return those of some columns that need not be computed."""

    def _part(self, at: slice) -> HasColumns:
        """Return the motion at some times."""


def along_times(motion: HasColumns, names: Collection[str]) -> dict[str, Array]:
    """Return columns by name."""
    found = motion._at_hand(names)
    left = {*names} - found.keys()
    if not left:
        return found
    drifts = {key: each for each in _integrals(motion, left) if (key := f"drift_{each.name}") in left}
    wanted = left - drifts.keys() | {f"integral_{each.name}" for each in drifts.values()}
    wanted |= ENERGIES if drifts else set()
    along, sizes = (EVERY,) if motion.is_ensemble else (), np.zeros(())
    whole = motion._in_memory
    for at in _blocks(motion):
        part = whole._part(at)
        block = _computed(part, wanted)
        sizes = np.fmax(sizes, _sizes(part, block)) if drifts else sizes
        for name, values in block.items():
            if name not in found:
                shape = [*values.shape]
                shape[len(along)] = motion.times.size
                found[name] = np.empty(shape, values.dtype)
            found[name][*along, at] = values
    for key, each in drifts.items():
        found[key] = _drift(each, motion.initial, found[f"integral_{each.name}"], sizes)
    return {name: found[name] for name in names}


def _integrals(motion: HasColumns, names: Collection[str]) -> tuple[Integral, ...]:
    """Return the integrals, if some of the names are of values or drifts of them."""
    return motion.system.integrals if any(name.startswith(PROOF) for name in names) else ()


def _blocks(motion: HasColumns) -> Iterator[slice]:
    """Return the times in blocks; formulas of orbits and rotation models round by all the times at once, so in one."""
    dated = any(isinstance(each, Dated) for record in motion.system.dynamics.records for each in within(record))
    count, members = max(motion.times.size, 1), max(len(motion), 1) if motion.is_ensemble else 1
    step = count if dated else BLOCK // members or count
    return (slice(first, first + step) for first in range(0, count, step))


def _computed(part: HasColumns, names: Collection[str]) -> dict[str, Array]:
    columns = {name: read() for name, read in part._columns.items() if name in names}
    state = part._state
    proof = {key: each for each in _integrals(part, names) if (key := f"integral_{each.name}") in names}
    return columns | {key: np.asarray(each.value(state)) for key, each in proof.items()}


def _sizes(part: HasColumns, columns: Mapping[str, Array]) -> Array:
    """Return what drifts of energies and of momenta are measured against, the largest; shape (2, ...)."""
    T_and_U = np.abs(columns["kinetic_energy"]) + np.abs(columns["potential_energy"])
    return np.stack([np.fmax.reduce(each, axis=-1, initial=0.0) for each in (T_and_U, part._momentum_size)])


def _drift(integral: Integral, initial: AnyState, values: Array, sizes: Array) -> Array:
    size = sizes[0 if integral.is_energy else 1]
    with np.errstate(invalid="ignore"):
        change: Array = values - np.asarray(integral.value(initial))[..., None]
    change /= np.where(size > 0, size, 1.0)[..., None]
    return change
