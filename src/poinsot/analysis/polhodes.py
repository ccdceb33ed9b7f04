"""Curves of equal energy of a free body, in closed form.

A free body conserves G^2 = sum g_i^2 and 2T = sum g_i^2 / I_i along its principal axes. So the direction n = g/G of
its angular momentum stays on a curve of equal energy of the unit sphere,

    n1^2 + n2^2 + n3^2 = 1,    d1 n1^2 + d2 n2^2 + d3 n3^2 = D,    d_i = 1/I_i,    D = 2T/G^2,

and its angular velocity omega_i = G d_i n_i on the polhode. The curve goes round the short axis (largest moment)
for D < d_middle and round the long axis (smallest moment) for D > d_middle; between them lie the separatrices.
Directions and moments are along the principal axes, in the order of the moments of the body.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from poinsot.mechanics.body import EQUAL_MOMENTS, Body
from poinsot.quantities import Array

__all__ = [
    "TURN",
    "axis_encircled",
    "curve_about",
    "energy_curve",
    "energy_curves",
    "herpolhode_radii",
    "principal",
    "separatrices",
    "spherical",
]

TURN = np.linspace(0, 2 * np.pi, 721)

SPACING = np.radians([15, 30, 45, 60, 75])
"""Angles at which the curves of a family cross the arc from their axis to the intermediate axis."""


def principal(body: Body) -> tuple[Array, Array]:
    """Return the principal moments, and the principal axes as columns in the body axes.

    Moments that differ by rounding are made equal.
    """
    moments = np.array(body.moments, dtype=float)
    for smaller, larger in itertools.pairwise(np.argsort(moments)):
        if moments[larger] - moments[smaller] <= EQUAL_MOMENTS * np.max(moments):
            moments[larger] = moments[smaller]
    return moments, np.asarray(body.principal_axes.as_matrix())


def spherical(moments: Array) -> bool:
    """Return True if the three moments are equal."""
    return bool(np.ptp(moments) == 0)


def axis_encircled(moments: Array, D: float) -> int:
    """Return the axis that the curves of an energy D encircle: the short, the long, or the axis of symmetry."""
    long, middle, short = (int(i) for i in np.argsort(moments))
    if moments[short] == moments[middle]:
        return long
    return short if moments[long] == moments[middle] or D * moments[middle] < 1 else long


def curve_about(k: int, moments: Array, D: float) -> Array:
    """Return the curve of energy D round the axis k, where n_k >= 0; shape (m, 3). The other one is its negative.

    With (i, j, k) cyclic and u from 0 to 2 pi it is n_i = a_i cos u, n_j = a_j sin u, where

        a_i^2 = (D - d_k) / (d_i - d_k),    n_k^2 = (1 - a_i^2) cos^2 u + (1 - a_j^2) sin^2 u,

    and 1 - a_i^2 = (d_i - D) / (d_i - d_k) without cancellation.
    """
    d = 1 / moments
    i, j = (k + 1) % 3, (k + 2) % 3
    cos, sin = np.cos(TURN), np.sin(TURN)
    n = np.empty((TURN.size, 3))
    n[:, i] = np.sqrt((D - d[k]) / (d[i] - d[k])) * cos
    n[:, j] = np.sqrt((D - d[k]) / (d[j] - d[k])) * sin
    n[:, k] = np.sqrt((d[i] - D) / (d[i] - d[k]) * cos**2 + (d[j] - D) / (d[j] - d[k]) * sin**2)
    return n


def energy_curve(moments: Array, n: Array) -> Array:
    """Return the curve of equal energy through a unit vector n, shape (m, 3); n alone for a spherical body."""
    if spherical(moments):
        return n[None]
    d, middle = 1 / moments, np.argsort(moments)[1]
    D = float(d @ n**2)
    k = axis_encircled(moments, D)
    within = float(np.clip(D, *sorted((d[k], d[middle]))))
    return curve_about(k, moments, within) * (1 if n[k] >= 0 else -1)


def energy_curves(moments: Array, k: int) -> Iterator[Array]:
    """Yield evenly spaced curves round both ends of the long or the short axis k; none if another is as long."""
    d, middle = 1 / moments, np.argsort(moments)[1]
    if d[k] == d[middle]:
        return
    for angle in SPACING:
        curve = curve_about(k, moments, d[k] + np.sin(angle) ** 2 * (d[middle] - d[k]))
        yield from (curve, -curve)


def separatrices(moments: Array) -> list[Array]:
    """Return the two great circles D = d_middle of a body of three different moments; none for others.

    n = cos u (a e_short +- b e_long) + sin u e_middle with

        a^2 = (d_long - d_middle) / (d_long - d_short),    b^2 = (d_middle - d_short) / (d_long - d_short).
    """
    long, middle, short = np.argsort(moments)
    d, e = 1 / moments, np.eye(3)
    if d[long] == d[middle] or d[middle] == d[short]:
        return []
    a = np.sqrt((d[long] - d[middle]) / (d[long] - d[short]))
    b = np.sqrt((d[middle] - d[short]) / (d[long] - d[short]))
    across = (a * e[short] + b * e[long], a * e[short] - b * e[long])
    return [np.outer(np.cos(TURN), axis) + np.outer(np.sin(TURN), e[middle]) for axis in across]


def herpolhode_radii(moments: Array, g: Array) -> tuple[float, float]:
    """Return the smallest and the largest distance of omega from the line of G, along the polhode of g.

    With k the axis that the polhode encircles they are G sqrt((D - d_k) (d_i - D)) for the other two axes i.
    """
    d, G = 1 / moments, np.linalg.norm(g)
    D = float(d @ (g / G) ** 2)
    k = axis_encircled(moments, D)
    small, large = np.sort(G * np.sqrt(np.maximum((D - d[k]) * (np.delete(d, k) - D), 0)))
    return float(small), float(large)
