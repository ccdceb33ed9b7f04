"""Levenberg-Marquardt method on a manifold, for several starts together, with robust losses and bounds.

A problem evaluates whitened residuals and their derivatives at points, and moves points by steps. Nielsen (1999,
Damping parameter in Marquardt's method, IMM-REP-1999-05) gives the step control. The weights of a robust loss follow
from the current residuals (iteratively reweighted least squares).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.optimize import lsq_linear

from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.suggestions import nearest

__all__ = ["LOSSES", "LeastSquares", "Loss", "Minimum", "checked_loss", "minimised"]

Points = TypeVar("Points")

SMALL_GAIN = 1e-4
"""Decrease of the cost over the predicted decrease above which a step is taken."""

FIRST_DAMPING = 1e-3
"""Initial damping, relative to the squares of the scaled columns."""

MAX_DAMPING = 1e16
"""Damping at which no step decreases the cost."""

MAX_FAILURES, FAILURE_GROWTH = 8, 100.0
"""Steps in succession to points without a motion before a start ends, and the growth of the damping at each."""

SMALL_DECREMENT, COST_ROUNDING = 1e-5, 1e-9
"""Decrement in standard deviations below which the rounding of the cost decides no step, and this rounding."""


class Loss(NamedTuple):
    """Loss rho(z) of the square z of a residual, with its derivative, as in `scipy.optimize.least_squares`."""

    value: Callable[[Array], Array]
    slope: Callable[[Array], Array]


def _huber(z: Array) -> Array:
    return np.where(z <= 1, z, 2 * np.sqrt(np.maximum(z, 1)) - 1)


LOSSES: Mapping[str, Loss] = {
    "linear": Loss(lambda z: z, np.ones_like),
    "soft_l1": Loss(lambda z: 2 * z / (1 + np.sqrt(1 + z)), lambda z: (1 + z) ** -0.5),
    "huber": Loss(_huber, lambda z: np.maximum(z, 1) ** -0.5),
    "cauchy": Loss(np.log1p, lambda z: 1 / (1 + z)),
    "arctan": Loss(np.arctan, lambda z: 1 / (1 + z * z)),
}
"""Losses by name. They are 1 at one standard deviation, to first order."""


def checked_loss(loss: str) -> Loss:
    """Return the loss of a name, or raise a ValueError."""
    if loss not in LOSSES:
        raise ValueError(f"loss must be one of {', '.join(LOSSES)}, got {quoted(loss)}.{nearest(loss, LOSSES)}")
    return LOSSES[loss]


class LeastSquares(Protocol[Points]):
    """Residuals of several starts and their derivatives."""

    data: NDArray[np.int_]
    """Number of the datum of each residual, (m,); -1 for residuals of priors, whose loss is linear. The loss takes the
    sum of the squares of a datum."""
    bounds: tuple[Array, Array] | None
    """Lower and upper bounds of the values (n,); None without bounds."""

    def evaluated(self, points: Points) -> tuple[Array, Array]:
        """Return whitened residuals (starts, m) and derivatives (starts, m, n); NaN where a motion has failed."""

    def moved(self, points: Points, steps: Array) -> Points:
        """Return the points after steps (starts, n)."""

    def chosen(self, which: NDArray[np.bool_], points: Points, others: Points) -> Points:
        """Return points where `which` is True and other points elsewhere."""

    def values(self, points: Points) -> Array:
        """Return the values of the unknowns (starts, n); bounds limit them."""


@dataclass
class Minimum(Generic[Points]):
    """Result of a minimisation, for each start.

    Attributes
    ----------
    points : Points
        Points of smallest cost.
    residuals, derivatives : array (starts, m), (starts, m, n)
        Whitened residuals and their derivatives at the points.
    weights : array (starts, m)
        Derivatives of the loss at the residuals, 1 for the linear loss.
    cost : array (starts,)
        Sum of the losses.
    converged : bool array (starts,)
        True if the last step was below the tolerance.
    iterations : int array (starts,)
        Number of steps.
    """

    points: Points
    residuals: Array
    derivatives: Array
    weights: Array
    cost: Array
    converged: NDArray[np.bool_]
    iterations: NDArray[np.int_]


def minimised(
    problem: LeastSquares[Points],
    points: Points,
    loss: str = "linear",
    tolerance: float = 1e-10,
    iterations: int = 50,
    step_taken: Callable[[int, Array], None] | None = None,
) -> Minimum[Points]:
    """Return the points of smallest cost near the given points, one for each start.

    Parameters
    ----------
    problem : LeastSquares
    points : Points
        Starts.
    loss : str
        Key of `LOSSES`.
    tolerance : float
        Decrement, the size of the last step in standard deviations, at which a start has converged. A start has also
        converged if the decrements below 1e-5 no longer halve.
    iterations : int
        Largest number of steps.
    step_taken : callable, optional
        Called after each iteration with its number and the costs. If it raises a KeyboardInterrupt, the result is the
        best of each start so far.
    """
    rho = checked_loss(loss)
    residuals, derivatives = problem.evaluated(points)
    cost, weights = _cost(residuals, problem.data, rho)
    starts, _, n = derivatives.shape
    found = Minimum(
        points, residuals, derivatives, weights, cost, np.zeros(starts, dtype=bool), np.zeros(starts, dtype=int)
    )
    damping, growth = np.full(starts, FIRST_DAMPING), np.full(starts, 2.0)
    scales, failures = np.zeros((starts, n)), np.zeros(starts, dtype=int)
    running, last = np.isfinite(cost), np.full(starts, np.inf)
    try:
        for iteration in range(iterations):
            if not running.any():
                break
            scales = np.fmax(scales, np.linalg.norm(found.derivatives * np.sqrt(found.weights)[..., None], axis=1))
            steps, predicted, decrement = _steps(problem, found, damping, scales, running)
            tried = problem.moved(found.points, steps)
            residuals, derivatives = problem.evaluated(tried)
            cost, weights = _cost(residuals, problem.data, rho)
            with np.errstate(invalid="ignore", divide="ignore"):
                gain = (found.cost - cost) / predicted
            near = (decrement < SMALL_DECREMENT) & (cost <= found.cost * (1 + COST_ROUNDING))
            better = running & ((gain > SMALL_GAIN) | near)
            gain = np.where(near, 1.0, gain)
            found.points = problem.chosen(better, tried, found.points)
            found.residuals = np.where(better[:, None], residuals, found.residuals)
            found.derivatives = np.where(better[:, None, None], derivatives, found.derivatives)
            found.weights = np.where(better[:, None], weights, found.weights)
            found.cost = np.where(better, cost, found.cost)
            found.iterations += running
            failures = np.where(running & ~np.isfinite(cost), failures + 1, 0)
            damping, growth = _damped(damping, growth, gain, better)
            damping = np.where(np.isfinite(cost), damping, damping * FAILURE_GROWTH)
            found.converged |= better & near & ((decrement <= tolerance) | (decrement > 0.5 * last))
            last = decrement
            running &= ~found.converged & (failures < MAX_FAILURES) & (damping < MAX_DAMPING)
            if step_taken is not None:
                step_taken(iteration, found.cost)
    except KeyboardInterrupt:
        found.converged &= ~running
    return found


def _damped(damping: Array, growth: Array, gain: Array, better: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the next damping and its growth at the next rejected step."""
    with np.errstate(invalid="ignore"):
        less = damping * np.maximum(1 / 3, 1 - (2 * np.minimum(gain, 1.0) - 1) ** 3)
    return np.where(better, less, damping * growth), np.where(better, 2.0, growth * 2)


def _cost(residuals: Array, data: NDArray[np.int_], rho: Loss) -> tuple[Array, Array]:
    """Return the costs (starts,) and the weights of the residuals (starts, m)."""
    of_data = data >= 0
    numbers: Any = data[of_data]
    squares: Array = np.stack([np.bincount(numbers, row[of_data] ** 2) for row in residuals]).astype(float)
    weights = np.ones_like(residuals)
    weights[:, of_data] = rho.slope(squares)[:, numbers]
    return np.sum(rho.value(squares), axis=1) + np.sum(residuals[:, ~of_data] ** 2, axis=1), weights


def _steps(
    problem: LeastSquares[Points], found: Minimum[Points], damping: Array, scales: Array, running: NDArray[np.bool_]
) -> tuple[Array, Array, Array]:
    """Return steps (starts, n), predicted decreases of the cost and decrements; zero for starts that have ended."""
    starts, _, n = found.derivatives.shape
    steps, predicted, decrements = np.zeros((starts, n)), np.ones(starts), np.zeros(starts)
    limits = None if problem.bounds is None else [each - problem.values(found.points) for each in problem.bounds]
    for i in np.flatnonzero(running):
        root = np.sqrt(found.weights[i])
        J, r = found.derivatives[i] * root[:, None], found.residuals[i] * root
        scale = np.where(scales[i] > 0, scales[i], 1.0)
        rows, right = np.vstack([J / scale, np.sqrt(damping[i]) * np.eye(n)]), np.concatenate([-r, np.zeros(n)])
        if limits is None:
            scaled = lstsq(rows, right, lapack_driver="gelsy")[0]
        else:
            low, high = (each[i] * scale for each in limits)
            scaled = lsq_linear(rows, right, (np.minimum(low, 0.0), np.maximum(high, 1e-300))).x
        steps[i] = scaled / scale
        change = J @ steps[i]
        predicted[i] = -(2 * r @ change + change @ change)
        decrements[i] = np.linalg.norm(change)
    return steps, predicted, decrements
