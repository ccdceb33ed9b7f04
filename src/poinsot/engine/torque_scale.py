"""How large momenta become by the torques of a system: what an integration scales them by."""

from __future__ import annotations

import functools
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.branch_exploration import BRANCHES, ExploredEnvironment, opened
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Force, Potential
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import Part
from poinsot.mechanics.probing import samples
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System

__all__ = ["momentum_scale", "torque_scale"]

AT_REST = Vector((0.0, 0.0, 0.0))

_known: WeakKeyDictionary[System, Any] = WeakKeyDictionary()
"""The scales of systems, as long as these live: runs of one system are often short and many."""


def momentum_scale(system: System, state: State) -> Any:
    """Return the size of the angular momentum that the motion from a state will have, roughly; shape (...).

    The larger of |g| and what the forces would give a body at rest; 1 where all is zero.
    """
    own = [state.own[part.name][..., place] for part in system.moving_parts for place in part.momentum_places]
    sizes = [np.linalg.norm(momenta, axis=-1) for momenta in (state.angular_momentum_body, *own)]
    largest = functools.reduce(np.maximum, sizes, torque_scale(system))
    return np.where(largest > 0, largest, 1.0)


def torque_scale(system: System) -> Any:
    """Return the momentum that differences of energies, and torques, at sample states stand for; shape (...)."""
    scale = _known.get(system)
    if scale is None:
        scale = _known[system] = np.sqrt(np.max(system.body.moments, axis=-1) * _strongest(system))
    return scale


def _strongest(system: System) -> Any:
    branching = any(_branches(_Alike(system, force)) for force in system.forces)
    if not branching and not system.members:
        return system.sample_torque
    q, t, _ = samples(system, BRANCHES)
    environments = [Environment(t), *[ExploredEnvironment(t)] * branching]
    return functools.reduce(np.maximum, [_strongest_at(system, q, environment) for environment in environments])


def _strongest_at(system: System, q: NDArray[np.float64], environment: Environment) -> Any:
    """Return the largest energy, over the least, or torque of each member's forces on a body at rest."""
    twin = system.beside_samples
    instant = Instant(twin.body_at_rest(environment.time), Attitude.from_quaternion(Vector(q.T)), environment, AT_REST)
    with np.errstate(all="ignore"):
        sizes = [np.atleast_1d(_size(force, instant)) for force in twin.forces]
    return sum(np.nan_to_num(np.max(size, axis=-1), posinf=0.0) for size in sizes)


def _size(force: Any, instant: Instant) -> Any:
    if isinstance(force, Part):
        return 0.0
    if isinstance(force, Potential):
        energy = np.atleast_1d(opened(force.energy(instant)))
        return energy - np.min(energy, axis=-1, keepdims=True)
    return opened(functions.norm(force.torque(instant)))


class _Alike:
    """One force of a system, equal to another of the same structure: their formulas are one."""

    def __init__(self, system: System, force: Force) -> None:
        self.alone = system.with_parts(
            (system.body, force, *(part for part in system.moving_parts if part is not force))
        )

    def __hash__(self) -> int:
        return hash(self.alone.structure)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Alike) and self.alone.structure == other.alone.structure


@functools.lru_cache(1024)
def _branches(alike: _Alike) -> bool:
    """Whether the formula of a force has a condition on the time or an orbit."""
    q, t, _ = samples(alike.alone, BRANCHES)
    environment = ExploredEnvironment(t)
    _strongest_at(alike.alone, q, environment)
    return bool(environment.asked)
