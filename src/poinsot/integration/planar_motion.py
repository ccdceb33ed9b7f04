"""Whether a motion turns the body about its third axis alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.integration.formulations import FLAT
from poinsot.mechanics.body_dynamics import BodyDynamics
from poinsot.mechanics.dynamics import AnyDynamics, stacked
from poinsot.mechanics.probing import time_scale
from poinsot.mechanics.state import AnyState, State

__all__ = ["refuse_spatial_motion"]


def refuse_spatial_motion(system: AnyDynamics, state: AnyState) -> None:
    """Raise a ValueError if the motion of a system from a state does not turn about the third body axis alone."""
    if not isinstance(system, BodyDynamics):
        raise ValueError("formulation 'planar' must be for one body, got two. Use the default formulation.")
    state = state.of_bodies[""]
    if system.parts:
        raise ValueError(
            f"formulation 'planar' must be for a body without parts, got {type(system.parts[0]).__name__}. "
            "Use the default formulation."
        )
    vectors = {"angular momentum": state.angular_momentum_body, "inertia tensor": system.body.inertia[..., 2]}
    for name, along in (vectors | {"torque": _torques(system, state)}).items():
        aside = np.max(np.abs(along[..., :2]), initial=0.0)
        if aside > FLAT * np.max(np.abs(along), initial=0.0):
            raise ValueError(
                "formulation 'planar' must be for a body that turns about its third axis alone, but its "
                f"{name} has components along the others, up to {aside:.2g}. Use the default formulation."
            )


def _torques(system: BodyDynamics, state: State) -> NDArray[np.float64]:
    """Return torques along the body axes at attitudes turned about the third one and at other times; shape (n, 3)."""
    first, last = system.span
    torques = []
    for angle in np.arange(5) * 1.3:
        turned = quat.product(state.quaternion, (np.cos(angle), 0, 0, np.sin(angle)))
        time = np.clip(state.time + angle**3 * time_scale(system), first, last)
        here = State.computed({"quaternion": turned, "conjugate_momenta": np.zeros_like(turned)}, time)
        twin = system.beside(here.shape)
        torques.append(stacked(twin.torque_at(twin.at(here)), here.shape))
    return np.reshape(torques, (-1, 3))
