"""Rows of numbers in a text, each with its place for errors, and the metadata of the text."""

from __future__ import annotations

import dataclasses

import numpy as np

from poinsot.printable import quoted
from poinsot.quantities import Array

__all__ = ["TextRows", "number"]

MAX_NUMBER = 1e15
"""Largest number in a file of attitudes or orbits."""


@dataclasses.dataclass
class TextRows:
    """Rows in one file or one segment of it; `epochs` are the dates before their numbers, if they have dates."""

    name: str
    metadata: dict[str, str] = dataclasses.field(default_factory=dict)
    columns: tuple[str, ...] = ()
    places: list[str] = dataclasses.field(default_factory=list)
    epochs: list[str] = dataclasses.field(default_factory=list)
    numbers: list[list[float]] = dataclasses.field(default_factory=list)

    def add(self, place: str, texts: list[str], epoch: str = "") -> None:
        """Append a row, which must have a number in each column."""
        if len(texts) != len(self.columns):
            given = " ".join([epoch, *texts]).strip()[:100]
            time = "a time and " if epoch else ""
            raise ValueError(f"{place} must have {time}numbers for {', '.join(self.columns)}, got {quoted(given)}.")
        self.numbers.append([number(key, text, place) for key, text in zip(self.columns, texts, strict=True)])
        self.places.append(place)
        self.epochs.append(epoch)

    def word(self, key: str) -> str:
        """Return the value of a required key of the metadata, whose spelling in the text may be in capitals."""
        value = self.metadata.get(key) or self.metadata.get(key.upper())
        if not value:
            raise ValueError(f"{self.name} must have {key}, got none.")
        return value

    def stacked(self, *keys: str, factor: float = 1.0) -> Array:
        """Return columns times a factor, shape (n, number of keys)."""
        return factor * np.array(self.numbers)[:, [self.columns.index(key) for key in keys]]

    def check_rising(self, times: Array) -> None:
        """Raise a ValueError unless each row is later than the row before."""
        wrong = np.flatnonzero(np.diff(times) <= 0)
        if wrong.size:
            i = int(wrong[0]) + 1
            before, row = (self.epochs[k] or f"t = {times[k]:.15g}" for k in (i - 1, i))
            raise ValueError(f"{self.places[i]} must be later than the row before, got {row} after {before}.")


def number(key: str, text: str, place: str) -> float:
    """Return a text as a number of sensible size."""
    try:
        value = float(text)
    except ValueError:
        value = np.inf
    if not abs(value) < MAX_NUMBER:
        raise ValueError(f"{place} must have a number for {key}, got {quoted(text)}.")
    return value
