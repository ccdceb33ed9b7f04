"""Systems of the single bodies in a system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from typing_extensions import override

from poinsot.lazy import cached_property
from poinsot.mechanics.integrals import Integral
from poinsot.mechanics.pair_system import PairSystem
from poinsot.mechanics.system import System

__all__ = ["body_systems"]


class OneOfTwo(System):
    """One of two bodies, whose rotation is read from a motion of both. The forces belong to the system of both."""

    measures: ClassVar[tuple[str, ...]] = PairSystem.measures
    moves_alone: ClassVar[bool] = False

    @cached_property
    @override
    def integrals(self) -> tuple[Integral, ...]:
        return ()


def body_systems(system: System) -> Mapping[str, System]:
    """Return the system of each rigid body by name: the system itself if it has one body."""
    if len(system.body_names) == 1:
        return {"": system}
    each = zip(system.body_names, system.rigid_bodies, strict=True)
    return {name: OneOfTwo(body, units=system.units) for name, body in each}
