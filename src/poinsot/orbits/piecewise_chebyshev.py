"""Piecewise Chebyshev polynomials of vectors: fit to functions and tables, and evaluation.

A piece is a row of Chebyshev coefficients, shape (3, terms), of s in [-1, 1].
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from poinsot.quantities import Array

__all__ = ["fitted", "interpolated", "powers", "values"]

DEGREE = 12
"""Degree of the fitted polynomials. In a kernel a degree costs a product of series for each component, and a knot some
ten microseconds."""

CHECKS = np.array([-0.985, -0.83, -0.62, -0.31, -0.07, 0.19, 0.43, 0.71, 0.9, 0.993])
FUNCTION_ROUNDING = 1e-10
"""Largest error of a fit that halving does not improve, relative to the distance: rounding errors of the function."""
MIN_IMPROVEMENT = 8
"""Smallest factor by which halving reduces the error of a smooth function."""
CHECK_TIMES = 4096
"""Number of times, evenly over the span, at which a converged fit is compared with its function; at least a hundredth
of this number in each piece."""
ERROR_MARGIN = 2.0
"""Estimated error over the largest difference at the times of comparison: between these may be a larger one."""
MAX_CONVERGENCE_RATIO = 0.5
"""Ratio of the errors of consecutive orders of interpolation above which the orders do not converge. If it is small,
the next order measures the error: in 300 tables of ellipses the true error was larger by at most 30 times the ratio."""
MAX_HALVINGS = 40
"""Largest number of halvings of a piece."""
MAX_PIECES = 200_000
MAX_INTERVALS = 4096
ROWS_OF_ORDERS = (2, 4, 6)


def values(coefficients: Array, half_lengths: Array, s: Array, order: int) -> Array:
    """Return the derivatives of an order with respect to time at one s in each piece, shape (..., 3)."""
    derived: Array = np.asarray(chebyshev.chebder(coefficients, order, axis=-1))
    polynomials = chebyshev.chebvander(s, derived.shape[-1] - 1).reshape(*np.shape(s), derived.shape[-1])
    return np.asarray(np.einsum("...ik,...k->...i", derived, polynomials) / half_lengths[..., None] ** order)


def powers(coefficients: Array) -> Array:
    """Return the coefficients of the powers of s, shape (3, terms), from Chebyshev coefficients.

    No digits are lost if the coefficients decrease faster than powers of two, as in a converged piece.
    """
    return np.asarray(coefficients @ _powers_of_chebyshev(coefficients.shape[-1]))


@functools.cache
def _powers_of_chebyshev(terms: int) -> Array:
    """Return the coefficients of the powers in each polynomial, one row each."""
    return np.stack(
        [np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, terms - 1 - k)) for k, row in enumerate(np.eye(terms))]
    )


class _ChebyshevFit(NamedTuple):
    """Pieces in the order of time; `broken` pieces miss the function after the last halving."""

    left: Array
    coefficients: Array
    error: Array
    broken: NDArray[np.bool_]


def fitted(
    position: Callable[[Array], Array], start: float, stop: float, tolerance: float
) -> tuple[Array, Array, float]:
    """Return knots, coefficients and largest error of a fit to a function, in pieces halved until they converge.

    A jump of the function becomes a knot: the pieces on each side of it are fitted to the function on that side.

    Parameters
    ----------
    position : callable
        Times (n,) to positions (n, 3).
    start, stop : float
    tolerance : float
        Relative to the largest distance in a piece.

    Raises
    ------
    ValueError
        If it takes too many pieces.
    """
    fit = _halved(position, start, stop, tolerance)
    jumps = _jumps(position, fit, stop, tolerance)
    if jumps:
        ends = [start, *itertools.chain(*jumps), stop]
        sides = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]
        parts = zip(*(_halved(position, a, b, tolerance) for a, b in sides), strict=True)
        fit = _ChebyshevFit(*map(np.concatenate, parts))
    return np.array([start, *fit.left[1:], stop]), fit.coefficients, ERROR_MARGIN * float(np.max(fit.error))


def _halved(position: Callable[[Array], Array], start: float, stop: float, tolerance: float) -> _ChebyshevFit:
    """Return the pieces of a function that is smooth except at jumps."""
    left, right, before = np.array([start]), np.array([stop]), np.array([np.inf])
    done: list[_ChebyshevFit] = []
    for halving in range(MAX_HALVINGS + 1):
        coefficients, error, size = _fits(position, left, right)
        good = (error <= tolerance * size) | ((error > before / MIN_IMPROVEMENT) & (error <= FUNCTION_ROUNDING * size))
        shortest = 0.5 * (right - left) <= 4 * np.spacing(np.maximum(abs(left), abs(right)))
        if np.any(good):
            allowed = np.maximum(tolerance * size[good], 4 * error[good])
            error[good] = _worst(position, coefficients[good], left[good], right[good], CHECK_TIMES >> halving)
            good[good] = error[good] <= allowed
        ended = good | (halving == MAX_HALVINGS) | shortest
        done.append(_ChebyshevFit(left[ended], coefficients[ended], error[ended], ~good[ended]))
        if np.all(ended):
            break
        if sum(len(part.left) for part in done) + 2 * np.sum(~ended) > MAX_PIECES:
            raise ValueError(
                f"start and stop must be so near that {MAX_PIECES} polynomials suffice, got "
                f"[{start:.10g}, {stop:.10g}]. Shorten the span, or loosen the tolerance."
            )
        middle = 0.5 * (left[~ended] + right[~ended])
        left, right = np.concatenate([left[~ended], middle]), np.concatenate([middle, right[~ended]])
        before = np.tile(error[~ended], 2)
    whole = _ChebyshevFit(*map(np.concatenate, zip(*done, strict=True)))
    order = np.argsort(whole.left)
    return _ChebyshevFit(whole.left[order], whole.coefficients[order], whole.error[order], whole.broken[order])


def _jumps(
    position: Callable[[Array], Array], fit: _ChebyshevFit, stop: float, tolerance: float
) -> list[tuple[float, float]]:
    """Return the neighbouring times between which the function jumps, one pair for each run of broken pieces."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], fit.broken, [False]])))
    knots = np.append(fit.left, stop)
    found = []
    for before, after in knots[edges].reshape(-1, 2):
        a, b = float(before), float(after)
        low, high = position(np.array([a, b]))
        if np.linalg.norm(high - low) <= max(tolerance, FUNCTION_ROUNDING) * np.linalg.norm(high):
            continue
        while a < (middle := 0.5 * (a + b)) < b:
            (between,) = position(np.array([middle]))
            if np.linalg.norm(between - low) > np.linalg.norm(high - between):
                b, high = middle, between
            else:
                a, low = middle, between
        found.append((a, b))
    return found


def _fits(position: Callable[[Array], Array], left: Array, right: Array) -> tuple[Array, Array, Array]:
    """Return the coefficients of the pieces, their errors at times between, and the largest distances."""
    nodes = _nodes(DEGREE + 1)
    s = np.concatenate([nodes, CHECKS])
    times = 0.5 * (left + right)[:, None] + 0.5 * (right - left)[:, None] * s
    times[:, 0], times[:, nodes.size - 1] = left, right
    found = position(times.ravel()).reshape(*times.shape, 3)
    coefficients = _through(found[:, : nodes.size])
    between = np.einsum("nik,sk->nsi", coefficients, chebyshev.chebvander(CHECKS, DEGREE))
    error = np.linalg.norm(between - found[:, nodes.size :], axis=-1).max(axis=-1)
    return coefficients, error, np.linalg.norm(found, axis=-1).max(axis=-1)


def _worst(position: Callable[[Array], Array], coefficients: Array, left: Array, right: Array, count: int) -> Array:
    """Return the largest differences of pieces from their function at times that the fit did not use."""
    s = 2 * np.mod(np.arange(1, max(count, CHECK_TIMES // 100) + 1) * GOLDEN, 1.0) - 1
    worst = np.zeros(len(left))
    for i in range(0, s.size, CHECK_TIMES // 100):
        some = s[i : i + CHECK_TIMES // 100]
        times = 0.5 * (left + right)[:, None] + 0.5 * (right - left)[:, None] * some
        found = position(times.ravel()).reshape(*times.shape, 3)
        between = np.einsum("nik,sk->nsi", coefficients, chebyshev.chebvander(some, DEGREE))
        worst = np.maximum(worst, np.linalg.norm(between - found, axis=-1).max(axis=-1))
    return worst


GOLDEN = 0.5 * (5**0.5 - 1)
"""Golden ratio minus 1. The fractional parts of its multiples are spread evenly."""


def interpolated(times: Array, positions: Array, velocities: Array) -> tuple[Array, float, float]:
    """Return the coefficients (n - 1, 3, terms) between the rows of a table, the error, and a difference.

    The error follows from the largest difference from an interpolation through two more rows.

    Raises
    ------
    ValueError
        If there are fewer than two rows.
    """
    found: list[tuple[Array, float]] = []
    for rows in ROWS_OF_ORDERS:
        if rows > times.size:
            break
        coefficients = _hermite(times, positions, velocities, rows)
        if rows + 1 > times.size:
            found = found or [(coefficients, np.nan)]
            break
        finer = _hermite(times, positions, velocities, min(rows + 2, times.size))
        difference = np.linalg.norm(_at_checks(coefficients) - _at_checks(finer), axis=-1)
        found.append((coefficients, float(np.max(difference))))
    differences = [difference for _, difference in found]
    best = int(np.argmin(differences))
    coefficients, difference = found[best]
    ratio = difference / max(differences[best - 1], np.finfo(float).tiny) if best else MAX_CONVERGENCE_RATIO
    return coefficients, ERROR_MARGIN * max(1.0, 20 * min(ratio, MAX_CONVERGENCE_RATIO)) * difference, difference


def _hermite(times: Array, positions: Array, velocities: Array, rows: int) -> Array:
    """Return the coefficients of each interval, from the rows around it with their derivatives."""
    count = times.size - 1
    coefficients = np.empty((count, 3, 2 * rows))
    for first in range(0, count, MAX_INTERVALS):
        interval = np.arange(first, min(first + MAX_INTERVALS, count))
        around = np.clip(interval - rows // 2 + 1, 0, times.size - rows)[:, None] + np.arange(rows)
        coefficients[interval] = _hermite_block(times[around], positions[around], velocities[around], times, interval)
    return coefficients


def _hermite_block(t: Array, r: Array, v: Array, times: Array, interval: NDArray[np.int_]) -> Array:
    middle, half = 0.5 * (t[:, :1] + t[:, -1:]), 0.5 * (t[:, -1:] - t[:, :1])
    degree = 2 * t.shape[1] - 1
    s = (t - middle) / half
    slopes = np.moveaxis(chebyshev.chebval(s, chebyshev.chebder(np.eye(degree + 1), axis=0)), 0, -1)
    matrix = np.concatenate([chebyshev.chebvander(s, degree), slopes], axis=1)
    wide = np.linalg.solve(matrix, np.concatenate([r, v * half[..., None]], axis=1))
    ends = (times[interval][:, None] - middle, times[interval + 1][:, None] - middle)
    near = 0.5 * ((ends[1] + ends[0]) + (ends[1] - ends[0]) * _nodes(degree + 1)) / half
    return _through(np.einsum("nsk,nki->nsi", chebyshev.chebvander(near, degree), wide))


def _nodes(count: int) -> Array:
    """Return the extrema of a Chebyshev polynomial, from -1 to 1, both ends exact."""
    nodes = -np.cos(np.pi * np.arange(count) / (count - 1))
    return np.asarray(0.5 * (nodes - nodes[::-1]))


def _through(samples: Array) -> Array:
    """Return the coefficients (n, 3, count) of polynomials through values at the nodes, (n, count, 3)."""
    inverse = np.linalg.inv(chebyshev.chebvander(_nodes(samples.shape[1]), samples.shape[1] - 1))
    return np.asarray(np.einsum("ks,nsi->nik", inverse, samples))


def _at_checks(coefficients: Array) -> Array:
    return np.asarray(np.einsum("nik,sk->nsi", coefficients, chebyshev.chebvander(CHECKS, coefficients.shape[-1] - 1)))
