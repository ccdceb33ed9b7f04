"""Orbits that go below the surface of what attracts: they are computed, and it is said."""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import Any

import numpy as np

__all__ = ["warn_below"]


def warn_below(name: str, periapsis_distance: Any, radius: Any, surface: str, consequence: str) -> None:
    """Warn in one sentence, at the user's line, of a periapsis below a radius; of several, tell the lowest.

    Parameters
    ----------
    name : str
        Of the class whose construction it is.
    periapsis_distance, radius : float or array (members,)
        In the unit of length.
    surface : str
        What is at the radius.
    consequence : str
        What it means for the result.
    """
    distances, radii = np.broadcast_arrays(np.atleast_1d(periapsis_distance), radius)
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
        f"{name}: {whose} {depth} below {surface} (distance {distance}, radius {height}); {consequence}.",
        stacklevel=_level_of_user(),
    )


def _level_of_user() -> int:
    """Return the stack level, as seen by the caller, of the first line outside the package."""
    frame: FrameType | None = sys._getframe(1)
    level = 1
    while frame and frame.f_globals.get("__name__", "").partition(".")[0] == __name__.partition(".")[0]:
        frame, level = frame.f_back, level + 1
    return level
