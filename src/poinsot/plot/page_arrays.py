"""Arrays of the 3D page: encoding, and selection among very many stored times."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.quantities import Array

__all__ = ["PageTimes", "packed", "rows_of"]

MAX_PAGE_BYTES = 3.0e6
"""Largest size of the numbers of a page in bytes; as text they are 4 MB."""

PANEL_COLUMNS = 1024
"""Number of columns of a plot of very many times, each with the least and the largest value."""

WIDE, NARROW = "<f4", "<i2"
"""Encodings of numbers: single precision, or 16-bit fractions of the largest value for very many numbers."""


@dataclass(frozen=True)
class PageTimes:
    """Stored times that a page contains, in increasing order, and the encoding of its numbers."""

    every: Array
    at: NDArray[np.intp]
    kind: str

    @property
    def times(self) -> Array:
        """Times on the page."""
        return self.every[self.at]

    @property
    def are_all(self) -> bool:
        """True if the page contains all stored times."""
        return self.at.size == self.every.size

    def encoded(self, arrays: Mapping[str, Array]) -> dict[str, Any]:
        """Return the encoded times of the page and the encoded arrays at these times, from all stored values."""
        values = {name: packed(array[self.at], self.kind) for name, array in arrays.items()}
        return {"times": _base64(self.times, "<f8"), "arrays": values}

    def envelope(self, values: Array) -> dict[str, Any]:
        """Return the least and the largest of all stored values in each column of a plot."""
        forwards = slice(None, None, 1 if self.every[-1] > self.every[0] else -1)
        times, values = self.every[forwards], values[forwards]
        edges = np.linspace(times[0], times[-1], PANEL_COLUMNS, endpoint=False)
        first = np.searchsorted(times, edges)
        return {
            "low": packed(np.minimum.reduceat(values, first), NARROW),
            "high": packed(np.maximum.reduceat(values, first), NARROW),
        }


def rows_of(times: Array, rates: Iterable[Array], arrays: Mapping[str, Array], sharing: int = 1) -> PageTimes:
    """Return the times of a page for the arrays of a motion: all times, or times at equal rotations.

    Parameters
    ----------
    times : array (n,)
        Stored times.
    rates : iterable of arrays (n,)
        Angular velocity of each body at these times.
    arrays : mapping
        Arrays (n, k) of the motion.
    sharing : int
        Number of motions that share the page.
    """
    rate, numbers = np.max(list(rates), axis=0), sum(values.shape[-1] for values in arrays.values())
    budget = MAX_PAGE_BYTES / sharing
    order = np.arange(times.size)[:: 1 if times[-1] > times[0] else -1]
    if times.size * (8 + 4 * numbers) <= budget:
        return PageTimes(times, order, WIDE)
    most = int(budget / (8 + 2 * numbers))
    if times.size <= most:
        return PageTimes(times, order, NARROW)
    dt, rate = np.diff(times[order]), rate[order]
    turned = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * dt)
    reached = np.append(0.0, turned / (turned[-1] or 1.0)) + (times[order] - times[order[0]]) / np.sum(dt)
    nearest = np.searchsorted(reached, np.linspace(0, reached[-1], most))
    return PageTimes(times, order[np.unique(np.append(nearest.clip(0, times.size - 1), times.size - 1))], NARROW)


def packed(values: Array, kind: str = WIDE) -> dict[str, Any]:
    """Return rows as numbers of a kind and their scale, which may exceed the range of single precision."""
    largest = float(np.max(np.abs(values), initial=0.0)) or 1.0
    scale = largest / (1 if kind == WIDE else np.iinfo(kind).max)
    scaled = values / scale
    return {"scale": scale, "kind": kind[1:], "data": _base64(scaled if kind == WIDE else np.rint(scaled), kind)}


def _base64(values: Array, kind: str) -> str:
    """Return numbers as text in base 64."""
    return base64.b64encode(values.astype(kind).tobytes()).decode()
