"""Warning of orbits that go below the surface of the attractor. The orbits are computed all the same."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from poinsot.errors import level_of_user

__all__ = ["warn_below"]


def warn_below(record: Any, orbit: Any, radius: Any, surface: str, consequence: str) -> None:
    """Warn in one sentence, at the user's line, of a periapsis below a radius; of several, tell the lowest.

    Parameters
    ----------
    record : Parametric
        What is made: the orbit itself, or a force.
    orbit : Orbit
        One without a periapsis distance gives no warning.
    radius : float or array (members,)
        In the unit of length.
    surface : str
        What is at the radius.
    consequence : str
        What it means for the result.
    """
    distances, radii = np.broadcast_arrays(np.atleast_1d(getattr(orbit, "periapsis_distance", np.inf)), radius)
    depths = radii - distances
    lowest, count = int(np.argmax(depths)), np.count_nonzero(depths > 0)
    if not count:
        return
    depth, distance, height = (f"{float(x[lowest]):.10g}" for x in (depths, distances, radii))
    whose = "the periapsis is"
    if depths.size > 1:
        whose = f"the periapsis of {count} of {depths.size} members is below {surface}, the lowest, member {lowest},"
        surface = "it"
    warnings.warn(
        f"{type(record).__name__}: {whose} {depth} below {surface} (distance {distance}, radius {height}); "
        f"{consequence}.",
        stacklevel=level_of_user(),
    )
