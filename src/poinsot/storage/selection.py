"""Indices of members and times, as in NumPy and xarray."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.errors import array_of
from poinsot.printable import described, quoted
from poinsot.storage.zarr_group import JoinedArrays, StoredArray

__all__ = [
    "Chosen",
    "Index",
    "checked_index",
    "refuse_other_names",
    "rows_of",
]

Index = int | slice | ArrayLike
Chosen = int | NDArray[np.intp]


def checked_index(name: str, index: Any, count: int) -> Chosen:
    """Return an index of an axis of a given length as a whole number or an array of them, none negative."""
    if isinstance(index, slice):
        return _of_slice(name, index, count)
    given = array_of(name, index)
    if given.dtype == bool and given.shape == (count,):
        return np.flatnonzero(given)
    if given.dtype.kind not in "iu" or given.ndim > 1:
        raise TypeError(
            f"{name} must be a whole number, a slice, an array of whole numbers, or one of {count} truth values, "
            f"got {described(index)}."
        )
    outside = given[(given < -count) | (given >= count)]
    if outside.size:
        raise IndexError(f"{name} must lie within [{-count}, {count - 1}], got {outside.flat[0]}.")
    chosen = np.where(given < 0, given + count, given).astype(np.intp)
    return chosen if chosen.ndim else int(chosen)


def refuse_other_names(argument: str, names: Any, known: Collection[str]) -> None:
    """Raise an error unless `names` is a collection of known names."""
    if isinstance(names, str) or not isinstance(names, Collection):
        raise TypeError(f"{argument} must be a list of names, got {described(names)}.")
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise ValueError(f"{argument} must be some of {', '.join(known)}, got {quoted(name)}.")


def _of_slice(name: str, index: slice, count: int) -> Chosen:
    try:
        return np.arange(count)[index]
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a slice of whole numbers, got {quoted(index)}.") from None


def rows_of(values: Any, members: Chosen | slice | None, at: Any) -> NDArray[Any]:
    """Return the rows of some members, None for one body, at some times; read no other rows of a store."""
    if members is None:
        return np.asarray(values[at])
    if isinstance(values, StoredArray | JoinedArrays):
        return values.members(members, at)
    rows = values[members]
    return np.asarray(rows[at] if isinstance(members, int) else rows[:, at])
