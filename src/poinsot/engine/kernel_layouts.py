"""Where Taylor coefficients are in the memory of a kernel, and the loops of the inner sums.

There are two layouts: vectors hold members ("batch"), or inner sums of one member ("single"). Both add in one order.
"""

from __future__ import annotations

import collections
from collections.abc import Callable, Sequence
from typing import Any, Literal

from poinsot.engine.llvm_ir import DOUBLE, Array, Value, host_features, vector
from poinsot.engine.taylor_schedule import InnerSum, Row, Schedule

__all__ = ["Batch", "Layout", "Single"]

WIDTH, WIDE = 4, 8
"""Numbers in a vector, and in a wide one."""

FIRST_CACHE = 32768
"""Bytes of coefficients up to which wide vectors are faster."""

Layout = Literal["batch", "single"]


class Batch:
    """Vectors hold members: coefficients of the states and of what inner sums read, order by order."""

    def __init__(self, schedule: Schedule, variables: int, order: int, lanes: int | None) -> None:
        states = {row: schedule.state_of(row) for row in schedule.rows}
        stored = [row for row, place in states.items() if place is None]
        self._kept = {row: variables + i for i, row in enumerate(stored)}
        self._places = self._kept | {row: place for row, place in states.items() if place is not None}
        self._stride = variables + len(stored)
        rows = (order + 1) * self._stride
        if lanes is None:
            lanes = WIDE if host_features().get("avx512f") and 8 * WIDE * rows <= FIRST_CACHE else WIDTH
        self.lanes, self.size = lanes, rows * lanes
        self._kind = vector(DOUBLE, lanes)
        self._groups = _parts(schedule.groups, _registers(lanes))

    def states(self, memory: Value, n: Value | int) -> Array:
        """Return the coefficients of the states of some order."""
        return Array(Array(memory, self._kind).at(n * self._stride), self._kind)

    def keep(self, memory: Value, n: Value, row: Row, value: Value) -> None:
        """Store what inner sums of higher orders read."""
        if row in self._kept:
            self.states(memory, n)[self._kept[row]] = value

    def inner_sums(self, memory: Value, n: Value) -> Callable[[int], Value]:
        """Write the inner sums of an order."""
        sums: dict[int, Value] = {}
        for group in self._groups:
            sums |= dict(zip((inner.place for inner in group), self._sums(memory, n, group), strict=True))
        return sums.__getitem__

    def _sums(self, memory: Value, n: Value, group: Sequence[InnerSum]) -> list[Value]:
        pairs = [(self._places[inner.first], self._places[inner.second]) for inner in group]
        starts = [self.states(memory, 1).address, self.states(memory, n - 1).address]
        return _multiplied(n, starts, self._stride, self._kind, pairs)


class Single:
    """Vectors hold inner sums of one member: each coefficient is stored once for each place where it is read."""

    lanes = 1

    def __init__(self, schedule: Schedule, variables: int, order: int) -> None:
        inner = [inner for group in schedule.groups for inner in group]
        self._count = -(-len(inner) // WIDTH) * WIDTH
        self._index = {one.place: i for i, one in enumerate(inner)}
        self._places: dict[Row, list[int]] = {}
        for i, one in enumerate(inner):
            self._places.setdefault(one.first, []).append(i)
            self._places.setdefault(one.second, []).append(self._count + i)
        self._variables, self._stride = variables, 2 * self._count
        self._open: dict[int, Value] = {}
        self._left: dict[int, int] = {}
        self._filled = collections.Counter(place // WIDTH for places in self._places.values() for place in places)
        self._sums = (order + 1) * self._stride
        self._states = self._sums + self._count
        self.size = self._states + (order + 1) * variables

    def states(self, memory: Value, n: Value | int) -> Array:
        """Return the coefficients of the states of some order."""
        return Array(Array(memory, DOUBLE).at(n * self._variables + self._states), DOUBLE)

    def keep(self, memory: Value, n: Value, row: Row, value: Value) -> None:
        """Store what inner sums of higher orders read, vectors as soon as they are complete."""
        for place in self._places.get(row, ()):
            block = place // WIDTH
            vector_of = self._open.setdefault(block, n.function.constant(vector(DOUBLE, WIDTH), 0.0))
            self._open[block] = vector_of.with_lane(place % WIDTH, value)
            self._left[block] = self._left.get(block, self._filled[block]) - 1
            if not self._left[block]:
                Array(Array(memory, DOUBLE).at(n * self._stride), vector(DOUBLE, WIDTH))[block] = self._open.pop(block)
                del self._left[block]

    def inner_sums(self, memory: Value, n: Value) -> Callable[[int], Value]:
        """Write the inner sums of an order."""
        whole = Array(memory, DOUBLE)
        starts = [whole.at(self._stride), whole.at((n - 1) * self._stride)]
        kind, blocks = vector(DOUBLE, WIDTH), list(range(self._count // WIDTH))
        found = Array(whole.at(self._sums), kind)
        for part in _parts([blocks], _registers(WIDTH)):
            pairs = [(block, block + len(blocks)) for block in part]
            for block, total in zip(part, _multiplied(n, starts, self._stride // WIDTH, kind, pairs), strict=True):
                found[block] = total
        return lambda place: found.of(DOUBLE)[self._index[place]]


def _multiplied(
    n: Value, starts: Sequence[Value], stride: int, kind: str, pairs: Sequence[tuple[int, int]]
) -> list[Value]:
    """Write sum_{j=1..n-1} a_j b_{n-j} for pairs of places in an order, in one loop over j."""

    def body(j: Value, up: Value, down: Value, *totals: Value) -> list[Value]:
        first, second = Array(up, kind), Array(down, kind)
        firsts = {a: first[a] for a in sorted({a for a, _ in pairs})}
        seconds = {b: second[b] for b in sorted({b for _, b in pairs})}
        sums = [firsts[a].fma(seconds[b], total) for (a, b), total in zip(pairs, totals, strict=True)]
        return [j + 1, first.at(stride), second.at(-stride), *sums]

    nothing = [n.function.constant(kind, 0.0)] * len(pairs)
    carried = n.function.repeat([n.like(1), *starts, *nothing], lambda j, *_: j.is_("lt", n), body)
    return carried[3:]


def _parts(groups: Sequence[Sequence[Any]], most: int) -> list[Sequence[Any]]:
    """Return groups cut into parts of about equal length."""
    parts = []
    for group in groups:
        count = -(-len(group) // most)
        parts += [group[i * len(group) // count : (i + 1) * len(group) // count] for i in range(count)]
    return parts


def _registers(lanes: int) -> int:
    """Return how many vectors may be summed up at a time."""
    own, count = (8, 24) if host_features().get("avx512f") else (4, 12)
    return max(count // -(-lanes // own), 1)
