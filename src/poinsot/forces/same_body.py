"""Checks that mass and inertia of a force agree with the body."""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot.mechanics.body import Body
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import quoted
from poinsot.quantities import Array

__all__ = ["deviator", "refuse_no_sphere", "refuse_one_body", "refuse_other_inertia", "refuse_other_mass"]

SAME_INERTIA = 1e-9
"""Tolerance between the inertia tensors of body and force, relative to the largest moment: far above rounding."""


def refuse_other_inertia(name: str, own: Array, bodys: Array, body: Body, hint: str) -> None:
    """Raise a ValueError if the tensors of force and body differ; each (3, 3) or (members, 3, 3)."""
    if own.ndim == bodys.ndim == 3 and len(own) != len(bodys):
        return  # for which the system raises an error
    apart = np.max(np.abs(own - bodys), axis=(-2, -1)) / np.max(body.moments, axis=-1)
    if np.any(apart > SAME_INERTIA):
        raise ValueError(
            f"{name} must agree with the inertia of the body, but the tensors differ by {np.max(apart):.2g} of its "
            f"largest moment. {hint}"
        )


def refuse_other_mass(name: str, own: Any, bodys: Any, hint: str) -> None:
    """Raise a ValueError if the masses of force and body differ; each of shape () or (members,)."""
    if np.ndim(own) == np.ndim(bodys) == 1 and len(own) != len(bodys):
        return  # for which the system raises an error
    wrong = np.flatnonzero(np.abs(np.asarray(own) / bodys - 1) > SAME_INERTIA)
    if wrong.size:
        given, asked = (float(np.ravel(x)[wrong[0] if np.ndim(x) else 0]) for x in (own, bodys))
        raise ValueError(f"{name} must have the mass of the body, {asked:.10g}, got {given:.10g}. {hint}")


def refuse_no_sphere(name: str, body: Body, shape: str) -> None:
    """Raise a ValueError if a body that is not made of some shape has unequal moments."""
    if np.ptp(body.moments, axis=-1).any():
        raise ValueError(f"{name} must be made of {shape}, by Body.from_shape, or be a sphere, got {quoted(body)}.")


def refuse_one_body(force: Any, body: Any) -> None:
    """Raise a ValueError if a force between two bodies is on one."""
    if not isinstance(body, TwoBodies):
        raise ValueError(f"{type(force).__name__} must act between TwoBodies, got one body.")


def deviator(tensor: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) less their mean."""
    mean = np.trace(tensor, axis1=-2, axis2=-1) / 3
    return np.asarray(tensor - np.asarray(mean)[..., None, None] * np.eye(3))
