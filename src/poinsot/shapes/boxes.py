"""Pairs of boxes that overlap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Boxes", "ranges"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

BOX_MARGIN = 1e-9
"""Widening of boxes, relative to the size of the scene."""

MAX_STRIPS = 64
"""Largest number of strips of a scene."""


class Boxes:
    """Boxes of one epoch each, sorted by strips of their second coordinate and, in a strip, by the first one."""

    def __init__(self, rows: Integers, low: Array, high: Array, size: float) -> None:
        """Sort boxes with corners (n, 3). The first two coordinates of other boxes have sizes up to `size`."""
        self._half = 2 * size
        margin = BOX_MARGIN * self._half
        self._low, self._high = low - margin, high + margin
        near = (self._low[:, :2] < self._half) & (self._high[:, :2] > -self._half)
        some = np.flatnonzero(near.all(axis=1))
        low, high = (np.clip(edge[some], -self._half, self._half) for edge in (self._low, self._high))
        width, height, _ = (high - low).T
        self._width = width.max(initial=0.0) / (2 * self._half)
        self._strip = max(2 * height.mean() if len(some) else 0.0, 2 * self._half / MAX_STRIPS)
        first, box, _, keys, _ = self._in_strips(rows[some], low, high)
        self._first = np.zeros(len(rows), dtype=np.int64)
        self._first[some] = first
        order = np.argsort(keys, kind="stable")
        self._boxes, self._keys = some[box[order]], keys[order]

    def overlapping(self, rows: Integers, low: Array, high: Array) -> tuple[Integers, Integers]:
        """Return pairs of one of other boxes and of a box that overlaps it, or is above it along the third axis."""
        first, one, strip, begin, end = self._in_strips(rows, low, high)
        start = np.searchsorted(self._keys, begin - self._width)
        stop = np.searchsorted(self._keys, end, "right")
        each = np.repeat(np.arange(len(one)), stop - start)
        one, strip, other = one[each], strip[each], self._boxes[ranges(start, stop)]
        meets = np.flatnonzero((self._low[other, 1] <= high[one, 1]) & (self._high[other, 1] >= low[one, 1]))
        one, strip, other = one[meets], strip[meets], other[meets]
        meets = (self._high[other, 0] >= low[one, 0]) & (self._high[other, 2] >= low[one, 2])
        meets &= np.maximum(first[one], self._first[other]) == strip  # a pair meets in several strips
        return one[meets], other[meets]

    def _in_strips(self, rows: Integers, low: Array, high: Array) -> tuple[Integers, Integers, Integers, Array, Array]:
        """Return the first strip of each box, the boxes and strips of all their parts, and the keys of their ends."""
        first, last = (((edge[:, 1] + self._half) // self._strip).astype(np.int64) for edge in (low, high))
        box = np.repeat(np.arange(len(rows)), last - first + 1)
        strip = ranges(first, last + 1)
        keys = rows[box] * (2.0 * MAX_STRIPS) + strip
        begin, end = (keys + (edge[box, 0] + self._half) / (2 * self._half) for edge in (low, high))
        return first, box, strip, begin, end


def ranges(first: Integers, last: Integers) -> Integers:
    """Return the numbers from each first to before each last one, in one array."""
    count = last - first
    return np.asarray(np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count))
