"""Motions of two bodies as arguments, and the motion of one body out of any."""

from __future__ import annotations

from typing import Annotated

from poinsot.propagation.trajectory import Trajectory

__all__ = ["OfTwoBodies", "is_of_two_bodies", "of_one_body"]


def is_of_two_bodies(motion: Trajectory) -> bool:
    """Return True if a motion contains two bodies."""
    return len(motion.system.of_bodies) > 1


def _of_two_bodies(name: str, motion: Trajectory) -> Trajectory:
    if not is_of_two_bodies(motion):
        raise TypeError(f"{name} must be the motion of two bodies, got the motion of one body.")
    return motion


OfTwoBodies = Annotated[Trajectory, _of_two_bodies]
"""Annotation of a motion of two bodies."""


def of_one_body(motion: Trajectory, body: str | None) -> Trajectory:
    """Return the motion of one body, for a motion of two the body with the given name."""
    known = motion.of_bodies
    if body is None and len(known) == 1:
        return motion
    if body not in known:
        rule = "must be primary or secondary" if len(known) > 1 else "must not be there for a motion of one body"
        raise ValueError(f"body {rule}, got {body or 'none'}.")
    return known[body]
