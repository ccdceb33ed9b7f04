"""Directions in the space of unknowns that data do not determine, with names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from poinsot.quantities import Array

__all__ = ["Determined", "NullDirection", "determined"]

MIN_SINGULAR_VALUE = 1e-10
"""Smallest singular value, over the largest, of a determined direction, for columns of length one."""

SMALL_SHARE = 1e-6
"""Share of an unknown in a null direction below which the direction does not contain it."""

STEMS = {"theta": "attitude", "g": "angular momentum", "omega": "angular velocity"}


class NullDirection(NamedTuple):
    """Change of unknowns that changes no reading.

    Attributes
    ----------
    text : str
        Description, such as "moments and angular momentum by one common factor".
    vector : array (n,)
        The change of the unknowns, of length one.
    """

    text: str
    vector: Array


class Determined(NamedTuple):
    """Covariance of the unknowns with the directions that are not determined.

    Attributes
    ----------
    covariance : array (n, n)
        Covariance within the determined subspace.
    standard_deviations : array (n,)
        Standard deviations; infinite for unknowns that a null direction contains.
    null_directions : tuple of NullDirection
    """

    covariance: Array
    standard_deviations: Array
    null_directions: tuple[NullDirection, ...]


def determined(derivatives: Array, labels: Sequence[str], values: Array) -> Determined:
    """Return the covariance of unknowns from whitened derivatives (m, n), and the null directions.

    Parameters
    ----------
    derivatives : array (m, n)
        Derivatives of whitened residuals, or the square root of an information matrix.
    labels : sequence of str
        Names of the unknowns.
    values : array (n,)
        Values of the unknowns, for the description of common factors.
    """
    sizes = np.linalg.norm(derivatives, axis=0)
    scales = np.where(sizes > 0, sizes, 1.0)
    _, singular, axes = np.linalg.svd(derivatives / scales, full_matrices=True)
    full = np.zeros(len(labels))
    full[: singular.size] = singular
    known = full > MIN_SINGULAR_VALUE * full.max(initial=0.0)
    root = axes[known] / full[known][:, None] / scales
    covariance = root.T @ root
    basis = axes[~known] / scales
    inside = np.linalg.norm(axes[~known], axis=0) > SMALL_SHARE
    deviations = np.where(inside, np.inf, np.sqrt(np.diagonal(covariance)))
    return Determined(covariance, deviations, tuple(_named(basis, labels, values)) if len(basis) else ())


def _named(basis: Array, labels: Sequence[str], values: Array) -> list[NullDirection]:
    """Return null directions: common factors first, then sparse combinations."""
    basis = np.linalg.svd(basis, full_matrices=False)[2]
    found = []
    factor = _common_factor(basis, values)
    if factor is not None:
        found.append(NullDirection(f"{_listed(factor, labels)} by one common factor", factor))
        left = basis - np.outer(basis @ factor, factor)
        _, sizes, rows = np.linalg.svd(left, full_matrices=False)
        basis = rows[sizes > 0.5]
    for row in _echelon(basis):
        vector = row / np.linalg.norm(row)
        terms = [f"{vector[i]:.3g} {labels[i]}" for i in np.flatnonzero(np.abs(vector) > SMALL_SHARE).tolist()]
        found.append(
            NullDirection(labels[int(np.argmax(np.abs(vector)))] if len(terms) == 1 else " + ".join(terms), vector)
        )
    return found


def _common_factor(basis: Array, values: Array) -> Array | None:
    """Return the null direction along the values of some unknowns; None without such a direction.

    The unknowns are those that every direction along the values of unknowns contains: the projection of the values on
    the null space equals the values there.
    """
    inside = np.ones(len(values), dtype=bool)
    for _ in range(len(values)):
        along = np.where(inside, values, 0.0)
        projected = basis.T @ (basis @ along)
        same = np.abs(projected - along) <= SMALL_SHARE * np.linalg.norm(along)
        if np.all(same[inside]) or not inside.any():
            break
        worst = np.abs(projected - along) / np.where(values == 0, 1.0, np.abs(values))
        inside &= worst < np.max(worst[inside])
    along = np.where(inside, values, 0.0)
    if np.count_nonzero(along) < 2:
        return None
    projected = basis.T @ (basis @ along)
    unit: Array = along / np.linalg.norm(along)
    return unit if np.linalg.norm(projected - along) <= SMALL_SHARE * np.linalg.norm(along) else None


def _echelon(basis: Array) -> Array:
    """Return a basis in reduced row echelon form, whose vectors have few components."""
    rows, first = np.array(basis), 0
    for column in range(rows.shape[1]):
        if first == len(rows):
            break
        pivot = first + int(np.argmax(np.abs(rows[first:, column])))
        if abs(rows[pivot, column]) < 1e-3:
            continue
        rows[[first, pivot]] = rows[[pivot, first]]
        rows[first] /= rows[first, column]
        others = np.arange(len(rows)) != first
        rows[others] -= np.outer(rows[others, column], rows[first])
        first += 1
    return rows


def _listed(vector: Array, labels: Sequence[str]) -> str:
    """Return the names of the unknowns of a direction in words, without indices."""
    stems = []
    for i in np.flatnonzero(vector).tolist():
        stem = re.sub(r"(\[\d+\])+$|_\d$", "", labels[i]).removeprefix("body.")
        stems.append(STEMS.get(stem, stem))
    *others, last = dict.fromkeys(stems)
    return f"{', '.join(others)} and {last}" if others else last
