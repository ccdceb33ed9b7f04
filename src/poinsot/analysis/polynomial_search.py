"""Search for all zeros of a torque whose components are polynomials of fourth degree in the quaternion.

Torques of gravity gradients, uniform fields and constant rotors in a uniformly turning frame are such polynomials.
RP^3 is covered by cells, each in a ball of coordinates x about its centre c, q ~ (c, c e1, c e2, c e3) (1, x). With Y
the inverse of the derivative at c, Y torque(x) = y + x + terms of second to fourth degree, which the norms of their
coefficients bound. A ball is decided if this cannot vanish in it, or is a contraction with its zero, the only one, in
the ball or a larger one (Banach). The cell of any other ball is divided into eight.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.quantities import Array

__all__ = ["zeros_of_quartics"]

POLYNOMIAL_TOLERANCE = 1e-9
"""Largest difference of torques from polynomials, relative to their size."""
FIRST_CELLS = 4
"""Number of cells along each edge of the four cubes that cover RP^3."""
MAX_CELLS = 20000
"""Largest number of cells at one level; isolated zeros require fewer."""
MIN_CELL = 2.0**-16
CORNERS = np.array(list(itertools.product((-1, 1), repeat=3)))
MONOMIALS = list(itertools.combinations_with_replacement(range(4), 4))


@np.errstate(all="ignore")
def zeros_of_quartics(torque: Callable[[Array], Array], attitudes: Array) -> tuple[Array, bool]:
    """Return unit quaternions near zeros of a torque, (n, 4) -> (n, 3), and True if every zero is near one of them.

    Zeros are missing if the torque at the given attitudes (at least 40) is no such polynomial, or if zeros are not
    isolated. A zero may occur several times.
    """
    coefficients = _coefficients(torque, attitudes)
    if coefficients is None:
        return np.empty((0, 4)), False
    found, half_edge = [], 1 / FIRST_CELLS
    edge = np.arange(half_edge - 1, 1, 2 * half_edge)
    cube = np.stack(np.meshgrid(edge, edge, edge), axis=-1).reshape(-1, 3)
    cells = np.concatenate([np.insert(cube, face, 1, axis=1) for face in range(4)])
    while 0 < len(cells) <= MAX_CELLS and half_edge > MIN_CELL:
        starts, undecided = _decided(coefficients, cells, half_edge)
        found.append(starts)
        half_edge /= 2
        inside = np.stack([np.insert(CORNERS, face, 0, axis=1) for face in range(4)])
        cells = cells[undecided]
        cells = (cells[:, None] + half_edge * inside[np.argmax(cells == 1, axis=1)]).reshape(-1, 4)
    starts = np.concatenate(found)
    return starts / np.linalg.norm(starts, axis=-1, keepdims=True), not len(cells)


def _coefficients(torque: Callable[[Array], Array], attitudes: Array) -> Array | None:
    """Return the symmetric coefficients of the torque's components, (3, 4, 4, 4, 4); None if it is no quartic."""
    values = torque(attitudes)
    terms = np.stack([np.prod(attitudes[:, places], axis=1) for places in MONOMIALS], axis=1)
    found = np.linalg.lstsq(terms, values, rcond=None)[0]
    if not np.max(np.abs(terms @ found - values)) <= POLYNOMIAL_TOLERANCE * np.max(np.abs(values)):
        return None
    out = np.zeros((4, 4, 4, 4, 3))
    for places, value in zip(MONOMIALS, found, strict=True):
        orders = set(itertools.permutations(places))
        for order in orders:
            out[order] = value / len(orders)
    return np.moveaxis(out, -1, 0)


def _decided(coefficients: Array, cells: Array, half_edge: float) -> tuple[Array, Array]:
    """Return quaternions near zeros, a row for each cell with a zero, and a mask of the undecided cells."""
    length = np.linalg.norm(cells, axis=1)
    reach = np.sqrt(3) * half_edge
    radius = np.tan(reach / np.maximum(1, length - reach))
    centers = cells / length[:, None]
    axes = np.stack([quat.product(centers, unit) for unit in np.eye(4)], axis=-1)
    twice = np.einsum("kabij,na,nb->nkij", coefficients, centers, centers, optimize=True)
    twice = np.einsum("nkij,nia,njb->nkab", twice, axes, axes, optimize=True)
    value, slope, bend = twice[:, :, 0, 0], 4 * twice[:, :, 0, 1:], 6 * twice[:, :, 1:, 1:].reshape(-1, 3, 9)
    beyond = _norm(coefficients.reshape(1, 3, -1))

    inverse = _inverse(slope)
    offset = np.einsum("nij,nj->ni", inverse, value)
    size, second = np.linalg.norm(offset, axis=1), _norm(inverse @ bend)
    third = fourth = _norm(inverse) * beyond

    def rest(x: Array) -> Array:
        """Return a bound of the nonlinear terms at a distance."""
        return np.asarray(second * x**2 + 4 * third * x**3 + fourth * x**4)

    empty = np.linalg.norm(value, axis=1) > _norm(slope) * radius + _norm(bend) * radius**2 + beyond * (
        4 * radius**3 + radius**4
    )
    empty |= size > radius + rest(radius)
    single = np.zeros(len(cells), dtype=bool)
    for x in (radius, 1.5 * radius, 2 * radius):
        single |= size <= x * (1 - (2 * second * x + 12 * third * x**2 + 4 * fourth * x**3))
    single &= ~empty
    next_to = axes[single, :, 0] - np.einsum("nij,nj->ni", axes[single, :, 1:], offset[single])
    return next_to, ~(empty | single)


def _inverse(matrices: Array) -> Array:
    """Return inverses (n, 3, 3), which are not finite for singular matrices."""
    a, b, c = np.moveaxis(matrices, 1, 0)
    adjugate = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    return np.asarray(adjugate / np.einsum("ni,ni->n", a, adjugate[..., 0])[:, None, None])


def _norm(matrices: Array) -> Array:
    """Return a bound of the spectral norms of matrices (n, 3, m)."""
    squares = matrices @ np.swapaxes(matrices, -1, -2)
    return np.asarray(np.sqrt(np.max(np.sum(np.abs(squares), axis=-1), axis=-1)))
