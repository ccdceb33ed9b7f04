"""Attributes that only motions of two bodies or only motions of one body have."""

from __future__ import annotations

from typing import cast

from poinsot.kinematics.each_body import no_attribute
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.systems.system import System

__all__ = [
    "OF_ONE_BODY",
    "OF_TWO_BODIES",
    "refuse_one_body",
    "refuse_two_bodies",
    "two_bodies",
]

OF_TWO_BODIES = frozenset(
    ("position", "momentum", "velocity", "acceleration", "distance", "elements", "orbit_frame", "primary", "secondary")
)
"""Attributes of a motion of two bodies."""

OF_ONE_BODY = frozenset(
    (
        *("quaternion", "conjugate_momenta", "angular_momentum_body", "omega_body", "omega_space", "attitude"),
        *("own", "euler", "relative_to", "torques_body", "forces_space"),
    )
)
"""Attributes of the motion of one body, also of `primary` and `secondary`."""


def two_bodies(system: System) -> TwoBodies:
    """Return the two bodies of a system."""
    return cast(TwoBodies, system.body)


def refuse_one_body(system: System, name: str) -> None:
    """Raise an AttributeError for a quantity of two bodies if the motion is of one body."""
    if len(system.of_bodies) == 1:
        raise AttributeError(f"a motion of one body has no {name}: it belongs to a motion of two bodies.")


def refuse_two_bodies(system: System, name: str) -> None:
    """Raise an AttributeError for a quantity of one body if the motion is of two bodies."""
    if len(system.of_bodies) > 1:
        raise AttributeError(no_attribute("a motion", name))
