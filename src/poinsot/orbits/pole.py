"""Directions by longitude and latitude along named space axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.errors import member_array, refuse_other_members
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.euler import quaternion_from_angles
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.orbits.theories import PLANETS_TO_ICRF
from poinsot.printable import quoted

__all__ = ["REFERENCE_FRAMES", "pole_attitude"]

REFERENCE_FRAMES = {"space": SPACE_AXES_UNNAMED, "equatorial": "ICRF", "ecliptic": "ICRF"}
"""Name of the space axes of a result, for each name of the axes of a longitude and a latitude."""

ECLIPTIC = quaternion_from_matrix(PLANETS_TO_ICRF)
"""Attitude of the ecliptic and equinox of J2000 in the ICRF."""


def pole_attitude(longitude: Any, latitude: Any, angle: Any, axes: str) -> NDArray[np.float64]:
    """Return the quaternion of R3(longitude) R2(90 deg - latitude) R3(angle), body -> space.

    The third body axis has the longitude and the latitude along the axes "space", "equatorial" (right ascension and
    declination) or "ecliptic". The space axes of the result are the ICRF for the latter two.

    Raises
    ------
    ValueError
        If the axes are unknown, or the numbers of members differ.
    """
    if axes not in REFERENCE_FRAMES:
        raise ValueError(f"axes must be one of {', '.join(REFERENCE_FRAMES)}, got {quoted(axes)}.")
    given = {"longitude": longitude, "latitude": latitude, "angle": angle}
    first, second, third = (member_array(name, value, ()) for name, value in given.items())
    refuse_other_members(longitude=first.shape, latitude=second.shape, angle=third.shape)
    angles = np.stack(np.broadcast_arrays(first, np.pi / 2 - second, third), axis=-1)
    q = quaternion_from_angles(angles, "323")
    return np.asarray(quat.product(ECLIPTIC, q) if axes == "ecliptic" else q)
