"""Residuals of readings with respect to predictions, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.functions import Vector
from poinsot.mechanics.observable import Observable
from poinsot.quantities import Array
from poinsot.taylor.graph import Graph, tangents

__all__ = ["difference_slopes", "differences"]


def differences(observable: Observable, read: Array, predicted: Array) -> Array:
    """Return the errors of readings with respect to predictions, shape (..., errors), also for scalar readings."""
    found = np.asarray(observable.difference(read, predicted))
    return found if observable.errors else found[..., None]


def difference_slopes(observable: Observable, read: Array, predicted: Array, columns: Array) -> Array:
    """Return the derivatives of errors of readings, from the derivatives of the predictions.

    Parameters
    ----------
    observable : Observable
    read, predicted : array (...) or (..., components)
        Readings and predictions.
    columns : array (..., n) or (..., components, n)
        Derivatives of the predictions.

    Returns
    -------
    array (..., errors, n)
        Derivatives of the errors; one error for scalar readings.
    """
    if not observable.components:
        return -columns[..., None, :]
    graph = Graph()
    nodes = Vector(graph.variable(predicted[..., i]) for i in range(predicted.shape[-1]))
    outputs: list[Any] = list(observable.difference(_vector(read), nodes))  # type: ignore[arg-type]
    rows = [tangents(outputs, {node: 1.0}) for node in nodes]
    numbers: Sequence[Any] = graph.finished([x for row in rows for x in row])
    shape = predicted.shape[:-1]
    table = np.stack([np.broadcast_to(np.asarray(x, dtype=float), shape) for x in numbers], axis=-1)
    slopes = np.swapaxes(table.reshape(*shape, len(nodes), len(outputs)), -1, -2)
    return np.asarray(slopes @ columns)


def _vector(values: Array) -> Vector:
    return Vector(values[..., i] for i in range(values.shape[-1]))
