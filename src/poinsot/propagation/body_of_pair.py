"""Systems of the single bodies in a system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from poinsot.mechanics.body import Body
from poinsot.mechanics.body_dynamics import BodyDynamics
from poinsot.mechanics.pair_dynamics import PairDynamics
from poinsot.mechanics.system import System

__all__ = ["body_systems"]


class OneOfTwo(BodyDynamics):
    """One of two bodies, whose rotation is read from a motion of both. The forces belong to the system of both."""

    measures: ClassVar[tuple[str, ...]] = PairDynamics.measures
    moves_alone: ClassVar[bool] = False


def body_systems(system: System) -> Mapping[str, System]:
    """Return the system of each rigid body by name: the system itself if it has one body."""
    if len(system.of_bodies) == 1:
        return {"": system}
    return {name: _system_of(body, system.units) for name, body in system.of_bodies.items()}


def _system_of(body: Body, units: Mapping[str, str]) -> System[Body]:
    return System._of(OneOfTwo(body, ()), units)
