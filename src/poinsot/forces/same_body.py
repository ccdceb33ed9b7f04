"""Check that the inertia of a force agrees with that of the body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.body import Body

__all__ = ["deviator", "refuse_other_inertia"]

SAME_INERTIA = 1e-9
"""Tolerance between the inertia tensors of body and force, relative to the largest moment: far above rounding."""

Array = NDArray[np.float64]


def refuse_other_inertia(name: str, own: Array, bodys: Array, body: Body, hint: str) -> None:
    """Raise a ValueError if a tensor of a force is not that of the body; each (3, 3) or (members, 3, 3)."""
    if own.ndim == bodys.ndim == 3 and len(own) != len(bodys):
        return  # which the system refuses
    apart = np.max(np.abs(own - bodys), axis=(-2, -1)) / np.max(body.moments, axis=-1)
    if np.any(apart > SAME_INERTIA):
        raise ValueError(
            f"{name} must agree with the inertia of the body, but the tensors differ by {np.max(apart):.2g} of its "
            f"largest moment. {hint}"
        )


def deviator(tensor: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) less their mean."""
    mean = np.trace(tensor, axis1=-2, axis2=-1) / 3
    return np.asarray(tensor - np.asarray(mean)[..., None, None] * np.eye(3))
