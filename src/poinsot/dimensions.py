"""Arrays with named dimensions, of xarray and pandas: their axes in the order in which the package takes axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.printable import quoted

__all__ = ["check_components", "in_order", "names_of"]

LABELS = {"axis": ("1", "2", "3"), "principal_axis": ("1", "2", "3"), "parameter": ("0", "1", "2", "3")}
"""Dimensions of components in the package's datasets, and the labels of the components in their order."""

COMPONENTS = (*LABELS, "body", "coordinate")

MEMBERS, TIMES, OTHER, FIRST_OF_COMPONENTS = range(4)
"""Places of dimensions among others."""


def names_of(value: Any) -> tuple[Any, ...] | None:
    """Return the names of the dimensions of an array of xarray or pandas; None for another array."""
    kind = type(value)
    if hasattr(kind, "get_axis_num"):
        return tuple(value.dims)
    if hasattr(kind, "iloc") and hasattr(kind, "to_numpy"):
        return tuple(axis.name for axis in value.axes)
    return None


def in_order(name: str, value: Any, names: Sequence[Any]) -> NDArray[Any]:
    """Return an array with named dimensions as members, times, another dimension and components, in this order.

    Components with the labels of a dataset of the package are in the order of these labels. Dimensions without names
    stay at their places.

    Raises
    ------
    ValueError
        If the names of several dimensions do not determine their order.
    """
    array = np.asarray(value)
    for place, own in enumerate(names):
        labels = [str(label) for label in _labels(value, place)]
        if own in LABELS and sorted(labels) == [*LABELS[own]]:
            array = np.take(array, np.argsort(labels), axis=place)
    if None in names:
        return array
    places = [_place(own) for own in names]
    if len(set(places)) < len(places):
        raise ValueError(
            f"{name} must have dimensions whose names determine their order, such as member, time and axis, got "
            f"{quoted(tuple(names))}. Rename them, or pass np.asarray({name})."
        )
    return np.transpose(array, np.argsort(places))


def check_components(name: str, names: Sequence[Any], count: int) -> None:
    """Raise a ValueError if a vector or a table with other dimensions of components than `count` is given."""
    places = [_place(own) for own in names if own is not None]
    most = sum(place >= OTHER for place in places)
    if sum(place >= FIRST_OF_COMPONENTS for place in places) > count or (len(places) == len(names) and most < count):
        rule = f"{count or 'no'} dimension{'s' * (count != 1)} of components"
        raise ValueError(f"{name} must have {rule}, got an array with the dimensions {quoted(tuple(names))}.")


def _place(own: Any) -> int:
    """Return the place of a dimension among others."""
    if own == "member":
        return MEMBERS
    if own == "time" or str(own).startswith("time_"):
        return TIMES
    if own in COMPONENTS:
        return FIRST_OF_COMPONENTS + COMPONENTS.index(own)
    return FIRST_OF_COMPONENTS if str(own).startswith("component_") else OTHER


def _labels(value: Any, place: int) -> Sequence[Any]:
    """Return the labels along a dimension; none if it has no labels."""
    if hasattr(type(value), "iloc"):
        return list(value.axes[place])
    coordinates, own = getattr(value, "coords", {}), value.dims[place]
    return coordinates[own].values.tolist() if own in coordinates else ()
