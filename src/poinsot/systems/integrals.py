"""Quantities that a motion conserves, found from the formulas of a system.

A quantity is an integral if its time derivative, computed with the torques and energies of the system, vanishes at
sample states up to the rounding of the derivative. The test therefore applies to the forces of a user, too.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from poinsot.functions import Scalar
from poinsot.immutable import Immutable
from poinsot.kinematics.state import AnyState
from poinsot.quantities import Array
from poinsot.systems.branch_exploration import BRANCH_SAMPLES, conditions, on_branches
from poinsot.systems.collection import Collection
from poinsot.taylor.graph import Graph

__all__ = ["EPS", "Integral", "SampledRates", "TracedRates", "component_of", "largest", "shaken", "vanishes"]

SAMPLE_STATES = 6

EPS = float(np.finfo(float).eps)
ROUNDINGS = 64
"""Number of roundings of a rate that count as zero."""


@dataclasses.dataclass(frozen=True)
class Integral(Immutable):
    """A conserved quantity.

    Attributes
    ----------
    name : str
        `energy`, `jacobi_energy`, `angular_momentum_space_3`, `angular_momentum_body_3`, ...
    symbol : str
        `H`, `H-n.G`, `G3`, `g3`, ...
    meaning : str
        Description of at most one line.
    value : callable
        Function of a state that returns the value, shape (...).
    is_energy : bool
        True if the drift is relative to |T| + |U|, False if it is relative to |g|.
    """

    name: str
    symbol: str
    meaning: str
    value: Callable[[AnyState], Array]
    is_energy: bool = False


class TracedRates(NamedTuple):
    """Rates of change at samples, traced in a graph.

    Attributes
    ----------
    rows : sequence of scalars
        Rates, and what they are compared with. Conditions in them are explored on all branches.
    energy_at : function
        Energy of the potentials at fixed attitudes and positions and at a time.
    time : scalar
        Time of the samples, a variable of the graph.
    later : array
        Times of other samples.
    """

    rows: Sequence[Scalar]
    energy_at: Callable[[Scalar], Scalar]
    time: Scalar
    later: Array


class SampledRates:
    """Rates of change of a system at sample states.

    Attributes
    ----------
    rows : list of array (members..., n)
        Values of the traced rows at the samples.
    noise : list of array (members...)
        Largest changes of the rows after changes of the samples by a rounding.
    counts : list of int
        Numbers of samples, which follow each other in the arrays.
    between_times : array (members..., n)
        Changes of the energy between times, and between the branches of conditions on the time.
    """

    def __init__(self, system: Collection, trace: Callable[[Graph, int], TracedRates]) -> None:
        found, branching = _evaluated(system, trace, SAMPLE_STATES, forced=False)
        self.counts = [SAMPLE_STATES, *[BRANCH_SAMPLES] * branching]
        if branching:
            others, _ = _evaluated(system, trace, BRANCH_SAMPLES, forced=True)
            found = np.concatenate((found, others), axis=-1)
        plain, moved = found[..., 0, :], found[..., 1, :]
        self.between_times, *self.rows = plain
        _, *self.noise = largest(moved - plain)


def _evaluated(
    system: Collection, trace: Callable[[Graph, int], TracedRates], count: int, forced: bool
) -> tuple[Array, bool]:
    """Return the change of the energy and the rows, shape (rows, ..., 2, n), and True if formulas have conditions.

    The axis of length two separates the samples and the neighbours a rounding away. With `forced`, the conditions take
    every branch, and the change of the energy is the difference to the other branches.
    """
    graph = Graph()
    traced, n = trace(graph, count), 2 * count
    timed, branching = traced.energy_at(traced.time), bool(conditions(traced.rows))
    if forced:
        here, there = (on_branches(graph, [timed], n, other)[0] for other in (False, True))
        rows = on_branches(graph, traced.rows, n)
    else:
        here, there, *rows = graph.evaluated([timed, traced.energy_at(traced.later), *traced.rows])
    found = np.empty((1 + len(rows), *system.members, n))
    for place, row in enumerate((here - there, *rows)):
        found[place] = row
    return found.reshape(*found.shape[:-1], 2, -1), branching


def shaken(values: Array, random: np.random.Generator) -> Array:
    """Return samples followed by their neighbours about a rounding away."""
    return np.concatenate((values, values * (1 + EPS * random.uniform(-2, 2, values.shape))))


def largest(values: Array) -> Array:
    """Return the largest absolute value over the samples, the last axis."""
    return np.asarray(np.max(np.abs(values), axis=-1))


def vanishes(rate: Array, noise: Array) -> bool:
    """Return True if a rate is zero at all samples up to its rounding."""
    return bool(np.all(largest(rate) <= ROUNDINGS * noise))


def component_of(axes: str, axis: Array, state: AnyState) -> Array:
    """Return the angular momentum of a state along an axis in body or space."""
    return np.asarray(getattr(state, f"angular_momentum_{axes}") @ axis)
