"""Parts of edges inside convex polygons and outside all of several polygons, in a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["inside", "lines_of", "positive", "turn", "uncovered"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]


def lines_of(corners: Array) -> Array:
    """Return the factors of x, y and 1 in the distances from the edges of triangles (3, 2, n), shape (3, 3, n)."""
    spans = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(spans[:, 0], spans[:, 1])
    x, y = np.divide(spans, lengths[:, None], out=np.zeros_like(spans), where=lengths[:, None] > 0).transpose(1, 0, 2)
    offsets = np.where(lengths > 0, y * corners[:, 0] - x * corners[:, 1], -1.0)
    return np.stack([-y, x, offsets], axis=1)


def inside(
    lines: Array, starts: Array, spans: Array, tolerance: float | Array, on_lines: bool | Flags = False
) -> tuple[Array, Array]:
    """Return the parameters between which edges are on the left of all of several lines (lines, 3, n).

    Parameters
    ----------
    tolerance : array (n,)
        Largest distance of an edge on a line.
    on_lines : bool array (lines, n)
        True where an edge on a line counts as on its left.
    """
    here = lines[:, 0] * starts[0] + lines[:, 1] * starts[1] + lines[:, 2]
    there = here + lines[:, 0] * spans[0] + lines[:, 1] * spans[1]
    on = np.maximum(np.abs(here), np.abs(there)) <= tolerance
    side = np.where(on_lines, 1.0, -1.0)
    begin, end = positive(np.where(on, side, here), np.where(on, side, there))
    return begin.max(axis=0), end.min(axis=0)


def positive(here: Array, there: Array) -> tuple[Array, Array]:
    """Return the parameters between which a linear function with values at 0 and 1 is positive; 1 and 0 if nowhere."""
    up, down = here >= 0, there >= 0
    share = np.divide(here, here - there, out=np.zeros_like(here), where=up != down)
    return np.where(up, 0.0, np.where(down, share, 1.0)), np.where(down, 1.0, np.where(up, share, 0.0))


def uncovered(count: int, edges: Integers, begin: Array, end: Array) -> tuple[Array, Array]:
    """Return the integrals of 1 and of the parameter over the parts of edges outside all of several intervals.

    Parameters
    ----------
    count : int
        Number of edges, each with parameters from 0 to 1.
    edges, begin, end : array (n,)
        Edge and ends of each interval.
    """
    by_begin, by_end = np.lexsort((begin, edges)), np.lexsort((end, edges))
    rank = np.empty(len(edges), dtype=np.int64)
    rank[by_end] = np.arange(len(edges))
    farthest = end[by_end[np.maximum.accumulate(rank[by_begin])]]  # a later edge has higher ranks
    edges, begin, end = edges[by_begin], begin[by_begin], end[by_begin]
    again = np.flatnonzero(edges[1:] == edges[:-1]) + 1
    begin[again] = np.maximum(begin[again], farthest[again - 1])
    end = np.maximum(end, begin)
    lengths, moments = end - begin, (end - begin) * (end + begin) / 2
    covered, first = (np.bincount(edges, share, count) for share in (lengths, moments))
    return np.asarray(1.0 - covered), np.asarray(0.5 - first)


def turn(one: Array, other: Array) -> Array:
    """Return the turns (n,) from vectors (2, n) to others."""
    return np.asarray(one[0] * other[1] - one[1] * other[0])
