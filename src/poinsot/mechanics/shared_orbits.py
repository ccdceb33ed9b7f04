"""The orbits of a system, and the blocks that several of them view."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from poinsot.mechanics.environment import Orbit, OrbitBlock
from poinsot.mechanics.parameters import same

__all__ = ["Views", "name_of_orbit", "orbits_of", "sample_time", "viewed", "views"]

Views = tuple[int | None, ...]
"""For each of some orbits the number of the block that it views."""


def orbits_of(record: Any) -> Iterator[Orbit]:
    """Yield the orbits among the parts of a system, of a record and of their parts."""
    for part in record.parts:
        if isinstance(part, Orbit):
            yield part
        else:
            yield from orbits_of(part)


def sample_time(record: Any) -> float:
    """Return a time at which the orbits of a system or of a force are felt; of members the first one's."""
    return next((float(t) for orbit in orbits_of(record) for t in np.ravel(orbit.sample_time)[:1] if t), 0.0)


def views(orbits: Iterable[Orbit], wanted: Callable[[Orbit], bool]) -> Views:
    """Return the number of the block that each orbit views, one for orbits on one path; None if it is not wanted."""
    blocks: list[OrbitBlock] = []
    out = []
    for orbit in orbits:
        block = orbit.block if wanted(orbit) else None
        out.append(None if block is None else next((i for i, b in enumerate(blocks) if same(b, block)), len(blocks)))
        if block is not None and out[-1] == len(blocks):
            blocks.append(block)
    return tuple(out)


def viewed(orbits: Sequence[Orbit], views: Views) -> tuple[OrbitBlock, ...]:
    """Return the blocks that orbits view, each of the first that does."""
    count = len({number for number in views if number is not None})
    return tuple(block for i in range(count) if (block := orbits[views.index(i)].block) is not None)


def name_of_orbit(number: int) -> str:
    """Return the name of the block of that number among those of orbits; no part has such a name."""
    return f"orbits[{number}]"
