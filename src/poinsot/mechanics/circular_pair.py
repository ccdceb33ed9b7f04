"""Circular orbits of two bodies to second degree of their gravity."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import exactly_one, member_array, refuse_nonpositive, refuse_other_members
from poinsot.mechanics.attitude import quaternion_from_matrix
from poinsot.mechanics.body import Body

__all__ = ["circular_orbit", "mean_motion", "upright"]

Array = NDArray[Any]

MAX_ITERATIONS = 100
"""Largest number of iterations of Newton's method, which needs less than ten near Kepler's third law."""


def circular_orbit(pair: Any, what: str, given: dict[str, Any], primary_turns: bool) -> tuple[Array, Array]:
    """Return distance and rate of the circular orbit with the one of distance, period and rate that is given.

    w^2 = G M / r^3 + 3 G M / (2 r^5) (s1 / m1 + s2 / m2), s = tr I - 3 A with A the moment about the line of centres:
    the least one, or the mean of the two smaller ones where the primary turns by itself.
    """
    name, value = exactly_one(what, given)
    value = member_array(name, value, ())
    refuse_nonpositive(name, value)
    mass, mu = (np.moveaxis(np.asarray(pair.masses), -1, 0), np.asarray(pair.mu))
    first, second = (np.moveaxis(np.sort(body.moments, axis=-1), -1, 0) for body in pair.bodies.values())
    along = (first[0] + first[1]) / 2 if primary_turns else first[0]
    spread = (sum(first) - 3 * along) / mass[0] + (sum(second) - 3 * second[0]) / mass[1]
    excess = 1.5 * mu * spread
    refuse_other_members(**{name: value.shape, "pair": np.shape(excess)})
    if name == "distance":
        return value, np.sqrt(mu / value**3 + excess / value**5)
    rate = value if name == "rate" else 2 * np.pi / value
    return _distance(mu, excess, rate), rate


def _distance(mu: Array, excess: Array, rate: Array) -> Array:
    """Return r of w^2 r^5 = mu r^2 + k, by Newton's method from where w^2 r^5 is more than twice each of the others."""
    r = np.maximum((2 * mu / rate**2) ** (1 / 3), (2 * excess / rate**2) ** (1 / 5))
    for _ in range(MAX_ITERATIONS):
        step = (rate**2 * r**5 - mu * r**2 - excess) / (5 * rate**2 * r**4 - 2 * mu * r)
        r = r - step
        if np.all(np.abs(step) <= np.spacing(r)):
            break
    return np.asarray(r)


def mean_motion(pair: Any, distance: Any) -> Any:
    """Return the mean motion sqrt(G M / r^3) of two point masses on a circular orbit."""
    return np.sqrt(pair.G * pair.total_mass / distance**3)


def upright(body: Body) -> Array:
    """Return the attitude with the axis of the least moment along the first space axis, the largest's along the third.

    The rotation is the identity for moments in ascending order.
    """
    order = np.argsort(np.asarray(body.moments), axis=-1, kind="stable")
    axes = np.swapaxes(body.principal_matrix, -1, -2)  # rows
    shape = np.broadcast_shapes(axes.shape[:-2], order.shape[:-1])
    axes, order = np.broadcast_to(axes, (*shape, 3, 3)), np.broadcast_to(order, (*shape, 3))
    long, short = (np.take_along_axis(axes, order[..., i, None, None], axis=-2)[..., 0, :] for i in (0, 2))
    return quaternion_from_matrix(np.stack([long, np.cross(short, long), short], axis=-2))
