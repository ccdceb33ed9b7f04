"""Attitude of a body at one instant from directions that are known along the body axes and along the space axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_numbers, refuse_nonpositive, refuse_zero
from poinsot.kinematics.attitude import quaternion_from_matrix, rotation, rotation_matrix
from poinsot.quantities import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["AttitudeEstimate", "triad", "wahba"]

MIN_INFORMATION = 1e-12
"""Smallest eigenvalue of the Fisher matrix over its trace, below which the directions determine no attitude."""

NEWTON_STEPS = 4
"""Steps of Newton's method. Each squares the error of the eigenvector, which is at most 1e-3."""


@dataclass(frozen=True, repr=False, eq=False)
class AttitudeEstimate(Summarized):
    """Attitude from directions at one instant, with its covariance.

    Attributes
    ----------
    quaternion : array (..., 4)
        Unit quaternion, body -> space, scalar first. Its first component that is not zero is positive.
    covariance : array (..., 3, 3) or None
        Covariance of the rotation vector theta along the body axes, q_true = q exp(theta / 2), rad^2. None without
        standard deviations.
    residuals : array (..., n, 3)
        Measured unit vectors minus predicted unit vectors, along the body axes.
    loss : array (...) or None
        Half of the sum of |residual|^2 / sigma^2. None without standard deviations.

    Examples
    --------
    >>> found = pt.estimation.wahba([(1, 0, 0), (0, 1, 0)], [(0, 1, 0), (-1, 0, 0)], sigma=1e-3)
    >>> found.quaternion.round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """

    quaternion: Array
    covariance: Array | None
    residuals: Array
    loss: Array | None

    @property
    def attitude(self) -> Rotation:
        """Attitude as a scipy rotation, body -> space."""
        return rotation(self.quaternion)

    @property
    def standard_deviations(self) -> Array | None:
        """Standard deviations of the rotation about each body axis, radians, shape (..., 3)."""
        if self.covariance is None:
            return None
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))

    @property
    def expected_loss(self) -> float:
        """Expectation (2 n - 3) / 2 of the loss of n directions with errors of the stated standard deviations."""
        count: float = self.residuals.shape[-2]
        return count - 1.5

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Attitude from {self.residuals.shape[-2]} directions", {
            "quaternion (body to space)": formatted(self.quaternion),
            "standard deviations (body axes)": formatted(self.standard_deviations, "rad"),
            "loss": "" if self.loss is None else f"{formatted(self.loss)}, expected {self.expected_loss:g}",
        }


@checked
def wahba(body: ArrayLike, space: ArrayLike, sigma: ArrayLike) -> AttitudeEstimate:
    """Return the attitude that fits directions best, the solution of Wahba's problem (Wahba 1965, SIAM Review 7, 409).

    The attitude R minimises the loss sum |b - R^T r|^2 / (2 sigma^2) over the directions b along the body axes and r
    along the space axes. The first approximation is the eigenvector of Davenport's matrix; Newton's method on the
    residuals improves it.

    Parameters
    ----------
    body, space : array (..., n, 3)
        Directions along the body axes and along the space axes, of any nonzero length. Axes before the last two are
        axes of instants or members.
    sigma : float or array (n,) or (..., n)
        Standard deviation of each direction about each axis perpendicular to it, radians; positive.

    Returns
    -------
    AttitudeEstimate
        Attitude with its covariance, the inverse of the Fisher matrix sum (1 - b b^T) / sigma^2 of the QUEST model
        (Shuster and Oh 1981, J. Guid. Control 4, 70).

    Raises
    ------
    ValueError
        If there are fewer than two directions, all directions are collinear, or sigma is not positive.

    Examples
    --------
    >>> stars = [(1, 0, 0), (0, 1, 0), (0, 0.6, 0.8)]
    >>> pt.estimation.wahba(stars, stars, sigma=1e-3).standard_deviations.round(6)
    array([0.000707, 0.000857, 0.000758])
    """
    b, r = _directions(body, space)
    deviations = _deviations(sigma, b)
    weights = deviations**-2.0
    q = _eigenvector(b, r, weights)
    for _ in range(NEWTON_STEPS):
        q = _improved(q, b, r, weights)
    predicted = _seen(q, r)
    residuals = b - predicted
    loss = 0.5 * np.sum(weights * np.sum(residuals**2, axis=-1), axis=-1)
    return AttitudeEstimate(_with_sign(q), _covariance(predicted, weights), residuals, loss)


@checked
def triad(body: ArrayLike, space: ArrayLike, sigma: ArrayLike | None = None) -> AttitudeEstimate:
    """Return the attitude from two directions, of which it fits the first exactly (Black 1964, AIAA J. 2, 1350).

    Parameters
    ----------
    body, space : array (..., 2, 3)
        Two directions along the body axes and along the space axes, of any nonzero length.
    sigma : float or array (2,), optional
        Standard deviation of each direction about each axis perpendicular to it, radians; positive.

    Returns
    -------
    AttitudeEstimate
        Attitude; with sigma also its covariance (Shuster and Oh 1981, J. Guid. Control 4, 70).

    Raises
    ------
    ValueError
        If the number of directions is not two, they are collinear, or sigma is not positive.

    Examples
    --------
    >>> found = pt.estimation.triad([(0, 0, 1), (1, 0, 0.1)], [(0, 0, 1), (0, 1, 0)])
    >>> found.attitude.as_euler("xyz", degrees=True).round(6)
    array([ 0.,  0., 90.])
    """
    b, r = _directions(body, space)
    if b.shape[-2] != 2:
        raise ValueError(f"body must have two directions, got {b.shape[-2]}. Take wahba for more.")
    for name, vectors in (("body", b), ("space", r)):
        turn = np.cross(vectors[..., 0, :], vectors[..., 1, :])
        if np.any(np.sum(turn**2, axis=-1) < MIN_INFORMATION):
            raise ValueError(
                f"{name} must have two directions that are not collinear, got {vectors.reshape(-1, 2, 3)[0].tolist()}. "
                "The rotation about them is unknown."
            )
    matrix = _frame(r) @ np.swapaxes(_frame(b), -1, -2)
    q = quaternion_from_matrix(matrix)
    residuals = b - _seen(q, r)
    if sigma is None:
        return AttitudeEstimate(_with_sign(q), None, residuals, None)
    deviations = _deviations(sigma, b)
    loss = 0.5 * np.sum(np.sum(residuals**2, axis=-1) / deviations**2, axis=-1)
    return AttitudeEstimate(_with_sign(q), _covariance_of_triad(b, deviations), residuals, loss)


# ---------------------------------------------------------------------- arguments


def _directions(body: ArrayLike, space: ArrayLike) -> tuple[Array, Array]:
    found = []
    for name, value in (("body", body), ("space", space)):
        array = real_numbers(name, value)
        if array.ndim < 2 or array.shape[-1] != 3 or array.shape[-2] < 2:
            raise ValueError(f"{name} must have shape (..., n, 3) with at least 2 directions, got shape {array.shape}.")
        refuse_zero(name, array)
        found.append(array / np.linalg.norm(array, axis=-1, keepdims=True))
    b, r = found
    if b.shape[-2] != r.shape[-2]:
        raise ValueError(
            f"body and space must have the same number of directions, got {b.shape[-2]} and {r.shape[-2]}."
        )
    b, r = np.broadcast_arrays(b, r)
    return b, r


def _deviations(sigma: ArrayLike, b: Array) -> Array:
    array = real_numbers("sigma", sigma)
    refuse_nonpositive("sigma", array)
    try:
        return np.broadcast_to(array, b.shape[:-1])
    except ValueError:
        rule = f"must be one number or one for each of the {b.shape[-2]} directions"
        raise ValueError(f"sigma {rule}, got shape {array.shape}.") from None


# ---------------------------------------------------------------------- Wahba's problem


def _eigenvector(b: Array, r: Array, weights: Array) -> Array:
    """Return the eigenvector of the largest eigenvalue of Davenport's matrix, sum w right(b)^T left(r)."""
    shares = weights / np.sum(weights, axis=-1, keepdims=True)
    profile = np.einsum("...n,...ni,...nj->...ij", shares, r, b)
    matrix = np.empty((*profile.shape[:-2], 4, 4))
    matrix[..., 0, 0] = trace = np.trace(profile, axis1=-2, axis2=-1)
    matrix[..., 0, 1:] = matrix[..., 1:, 0] = np.einsum("...n,...ni->...i", shares, np.cross(b, r))
    matrix[..., 1:, 1:] = profile + np.swapaxes(profile, -1, -2) - trace[..., None, None] * np.eye(3)
    return np.asarray(np.linalg.eigh(matrix)[1][..., -1])


def _improved(q: Array, b: Array, r: Array, weights: Array) -> Array:
    """Return the attitude after a step of Newton's method.

    Products of residuals with directions, not of directions with directions, keep all digits where the weights of
    directions differ much.
    """
    predicted = _seen(q, r)
    gradient = np.einsum("...n,...ni->...i", weights, np.cross(predicted, b - predicted))
    aligned = np.einsum("...ni,...ni->...n", b, predicted)
    products = np.einsum("...n,...ni,...nj->...ij", weights, b, predicted)
    total = np.sum(weights * aligned, axis=-1)
    hessian = total[..., None, None] * np.eye(3) - 0.5 * (products + np.swapaxes(products, -1, -2))
    theta = -np.linalg.pinv(hessian, hermitian=True) @ gradient[..., None]
    turned = quat.product(q, _exponential(theta[..., 0]))
    return np.asarray(turned / np.linalg.norm(turned, axis=-1, keepdims=True))


def _seen(q: Array, r: Array) -> Array:
    """Return directions r along the body axes."""
    return np.asarray(r @ rotation_matrix(q))


def _covariance(predicted: Array, weights: Array) -> Array:
    """Return the inverse of the Fisher matrix J^T J, from the singular values of J, the rows [b x] / sigma."""
    rows = np.cross(predicted[..., :, None, :], np.eye(3)) * np.sqrt(weights)[..., None, None]
    values, axes = np.linalg.svd(rows.reshape(*rows.shape[:-3], -1, 3), full_matrices=False)[1:]
    weak = values[..., -1] ** 2 < MIN_INFORMATION * np.sum(values**2, axis=-1)
    if np.any(weak):
        axis = axes[weak][0][-1]
        axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
        raise ValueError(
            "directions must not all be collinear, but the rotation about the body axis "
            f"({', '.join(f'{x:.3g}' for x in axis)}) is unknown. Add a direction away from this axis."
        )
    scaled = axes / values[..., None]
    return np.asarray(np.swapaxes(scaled, -1, -2) @ scaled)


# ---------------------------------------------------------------------- TRIAD


def _frame(vectors: Array) -> Array:
    """Return the triad of two directions as the columns of matrices."""
    first, turn = vectors[..., 0, :], np.cross(vectors[..., 0, :], vectors[..., 1, :])
    second = turn / np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.stack([first, second, np.cross(first, second)], axis=-1)


def _covariance_of_triad(b: Array, deviations: Array) -> Array:
    one, two = b[..., 0, :], b[..., 1, :]
    s1, s2 = deviations[..., 0, None, None] ** 2, deviations[..., 1, None, None] ** 2
    mixed = one[..., :, None] * two[..., None, :]
    square = one[..., :, None] * one[..., None, :]
    aligned = np.sum(one * two, axis=-1)[..., None, None]
    turn = np.sum(np.cross(one, two) ** 2, axis=-1)[..., None, None]
    return np.asarray(
        s1 * np.eye(3) + (s1 * aligned * (mixed + np.swapaxes(mixed, -1, -2)) + (s2 - s1) * square) / turn
    )


# ---------------------------------------------------------------------- quaternions


def _exponential(theta: Array) -> Array:
    """Return the unit quaternion exp(theta / 2) of a rotation vector."""
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * theta], axis=-1)


def _with_sign(q: Array) -> Array:
    """Return quaternions of which the first component that is not zero is positive."""
    first = np.take_along_axis(q, np.argmax(q != 0, axis=-1)[..., None], axis=-1)
    return np.asarray(q * np.sign(first))
