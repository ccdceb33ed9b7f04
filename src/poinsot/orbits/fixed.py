"""Positions fixed relative to the attractor."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.errors import refuse_zero
from poinsot.functions import Scalar
from poinsot.kinematics.frame import Frame
from poinsot.mechanics.environment import Orbit
from poinsot.quantities import Rule, SpaceVector
from poinsot.records.parameters import Positive

__all__ = ["FixedPosition", "HeldPosition", "components"]


class HeldPosition(Orbit):
    """Body at a constant distance from the attractor, given by `mu` and the position at one time."""

    mu: Positive
    _: KW_ONLY
    position: Annotated[SpaceVector, Rule(refuse_zero, "The body would be at the attractor.")]

    @property
    def periapsis_distance(self) -> Any:
        """Constant distance."""
        return np.linalg.norm(self.position, axis=-1)


class FixedPosition(HeldPosition):
    """Body at rest relative to an attractor.

    Parameters
    ----------
    mu : float
        Gravitational parameter of the attractor, in length^3 / time^2.
    position : array (3,), space axes
        Position of the body relative to the attractor, in length.

    Raises
    ------
    ValueError
        If the body is at the attractor.

    Examples
    --------
    >>> pt.orbits.FixedPosition(4902.8, position=(-384400.0, 0, 0))  # km, s
    FixedPosition(mu=4902.8, position=[-384400.0, 0.0, 0.0])
    """

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        return components(self.position)

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        return functions.Vector((0.0, 0.0, 0.0))

    @property
    @override
    def frame(self) -> Frame:
        raise ValueError(f"orbit must move to have a frame, but {type(self).__name__} has no velocity.")

    @property
    @override
    def directions(self) -> dict[str, NDArray[np.float64]]:
        return {"attractor": np.asarray(self.position)}


def components(vector: Any) -> functions.Vector:
    """Return the three components of a field, scalars of any kind or arrays of members."""
    return functions.Vector(quat.components(vector))
