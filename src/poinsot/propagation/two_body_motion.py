"""Quantities of the motion of two bodies about each other."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.dynamics import AnyDynamics
from poinsot.mechanics.each_body import no_attribute
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.pair_dynamics import acceleration as relative_acceleration
from poinsot.mechanics.state import AnyState
from poinsot.mechanics.system import System
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.orbits.elements import OsculatingElements, osculating_elements

__all__ = [
    "OF_ONE_BODY",
    "OF_TWO_BODIES",
    "acceleration",
    "elements_of_orbit",
    "moving",
    "refuse_one_body",
    "refuse_two_bodies",
    "two_bodies",
]

Array = NDArray[np.float64]

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


def elements_of_orbit(system: System, position: Array, velocity: Array) -> OsculatingElements:
    """Return the osculating elements of the secondary's orbit, with the parameter G (m1 + m2)."""
    mu = np.asarray(two_bodies(system).with_axes(position.ndim - 1).mu)
    return osculating_elements(mu, position=position, velocity=velocity)


def acceleration(system: System, state: AnyState, environment: Environment | None = None) -> Array:
    """Return the acceleration of the secondary relative to the primary, space axes; shape (..., 3)."""
    dynamics: AnyDynamics = system.dynamics
    return relative_acceleration(dynamics, state, environment)


def moving(system: System, state: AnyState) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration of the secondary relative to the primary at a state."""
    position, momentum = state.phase["orbit"][..., :3], state.phase["orbit"][..., 3:]
    return position, momentum / np.asarray(two_bodies(system).reduced_mass), acceleration(system, state)
