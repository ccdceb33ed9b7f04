"""Points of the motion of two bodies, and their displacements.

A displacement has shape (18,): rotation vector and change of angular momentum of the primary, along its axes; rotation
vector and change of angular momentum of the secondary; changes of position and momentum along the space axes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.kinematics.attitude import rotation, rotation_matrix
from poinsot.kinematics.state import PairState, Phase, named, state_of
from poinsot.mechanics.two_bodies import TwoBodies, upright
from poinsot.quantities import Array
from poinsot.systems.system import System

__all__ = ["PairPoint", "cross_matrix", "refuse_open", "symmetry_axis", "units_of_pair"]

EQUAL_MOMENTS = 1e-12
"""Largest relative difference of equal moments."""


@dataclasses.dataclass(frozen=True, eq=False)
class PairPoint:
    """Attitudes (2, 4), angular momenta along the body axes (2, 3), position and momentum (3,)."""

    attitudes: Array
    momenta: Array
    position: Array
    momentum: Array

    @classmethod
    def of(cls, state: PairState) -> PairPoint:
        """Return the point of a state."""
        each = list(state.of_bodies.values())
        attitudes, momenta = ([getattr(s, name) for s in each] for name in ("quaternion", "angular_momentum_body"))
        return cls(np.array(attitudes), np.array(momenta), np.array(state.position), np.array(state.momentum))

    def state(self, time: Any) -> PairState:
        """Return the state at a time."""
        phase: Phase = {}
        for body, q, g in zip(("primary", "secondary"), self.attitudes, self.momenta, strict=True):
            phase |= {named(body, "quaternion"): q, named(body, "angular_momentum_body"): g}
        found: Any = state_of(phase | {"orbit": np.concatenate([self.position, self.momentum])}, np.asarray(time))
        return found  # type: ignore[no-any-return]

    def displaced(self, x: Array) -> PairPoint:
        """Return the point at a displacement from this one."""
        from scipy.spatial.transform import Rotation

        turned = rotation(self.attitudes) * Rotation.from_rotvec(np.array([x[:3], x[6:9]]))
        momenta = self.momenta + np.array([x[3:6], x[9:12]])
        return PairPoint(turned.as_quat(scalar_first=True), momenta, self.position + x[12:15], self.momentum + x[15:])

    def displacement(self, other: PairPoint) -> Array:
        """Return the displacement to another point."""
        turns = (rotation(self.attitudes).inv() * rotation(other.attitudes)).as_rotvec()
        own = np.hstack([turns, other.momenta - self.momenta])
        return np.concatenate([*own, other.position - self.position, other.momentum - self.momentum])

    def turned(self, turn: Any) -> PairPoint:
        """Return the point after a rotation of space, given as a rotation of scipy."""
        attitudes = quat.product(turn.as_quat(scalar_first=True), self.attitudes)
        return PairPoint(attitudes, self.momenta, turn.apply(self.position), turn.apply(self.momentum))

    def spun(self, turns: Any) -> PairPoint:
        """Return the point after rotations of both bodies about their axes of symmetry."""
        attitudes = (rotation(self.attitudes) * turns).as_quat(scalar_first=True)
        return PairPoint(attitudes, turns.inv().apply(self.momenta), self.position, self.momentum)

    # ------------------------------------------------------------------ symmetries and conserved quantities

    @property
    def total(self) -> Array:
        """Total angular momentum, space axes."""
        return np.asarray(np.cross(self.position, self.momentum) + rotation(self.attitudes).apply(self.momenta).sum(0))

    def by_displacement(self) -> Array:
        """Return the derivative of the total angular momentum by displacements, (3, 18)."""
        out = np.zeros((3, 18))
        for i, (turn, g) in enumerate(zip(rotation_matrix(self.attitudes), self.momenta, strict=True)):
            out[:, 6 * i : 6 * i + 3] = -turn @ cross_matrix(g)
            out[:, 6 * i + 3 : 6 * i + 6] = turn
        out[:, 12:15], out[:, 15:] = -cross_matrix(self.momentum), cross_matrix(self.position)
        return out

    def turning(self, about: Array) -> Array:
        """Return the displacement per angle of a rotation of space about an axis, (18,)."""
        out = np.zeros(18)
        for i, turn in enumerate(rotation_matrix(self.attitudes)):
            out[6 * i : 6 * i + 3] = turn.T @ about
        out[12:15], out[15:] = np.cross(about, self.position), np.cross(about, self.momentum)
        return out

    def spinning(self, axes: Sequence[Array | None]) -> Array:
        """Return the displacements per angle of spins about axes of symmetry, (18, n)."""
        out = []
        for i, (axis, g) in enumerate(zip(axes, self.momenta, strict=True)):
            if axis is not None:
                column = np.zeros(18)
                column[6 * i : 6 * i + 3], column[6 * i + 3 : 6 * i + 6] = axis, np.cross(g, axis)
                out.append(column)
        return np.reshape(out, (-1, 18)).T

    def spin_momenta(self, axes: Sequence[Array | None]) -> Array:
        """Return the derivatives of the momenta about axes of symmetry by displacements, (n, 18)."""
        out = np.zeros((2, 18))
        for i, axis in enumerate(axes):
            out[i, 6 * i + 3 : 6 * i + 6] = 0 if axis is None else axis
        return out[[axis is not None for axis in axes]]

    def free(self, about: Array, axes: Sequence[Array | None], units: Array) -> Array:
        """Return a basis of displacements, divided by units, across symmetries and with equal conserved quantities.

        The symmetries are the rotation about the total angular momentum and spins about axes of symmetry. The shape is
        (18, 14), two less for each axis of symmetry.
        """
        rows = np.vstack([self.by_displacement(), self.spin_momenta(axes)]) * units
        columns = np.vstack([self.turning(about), self.spinning(axes).T]) / units
        both = np.concatenate([x / np.linalg.norm(x, axis=1, keepdims=True) for x in (rows, columns)])
        return np.asarray(np.linalg.svd(both)[2][len(both) :].T)


def refuse_open(system: System[TwoBodies], guess: PairState) -> None:
    """Raise an error for an ensemble, and for two bodies that do not conserve energy and angular momentum."""
    if system.members or guess.shape:
        raise ValueError("system and guess must be single ones, got an ensemble. Take the members one by one.")
    symbols = [integral.symbol for integral in system.integrals]
    if symbols != ["H", "G1", "G2", "G3"]:
        raise ValueError(
            "system must conserve the energy and the angular momentum of two bodies, got integrals "
            f"{', '.join(symbols) or 'none'}. Leave out perturbers and forces without a potential."
        )


def units_of_pair(system: Any, distance: float, rate: float) -> Array:
    """Return the sizes of displacements at a distance and an angular velocity of the orbit."""
    own = [[1.0] * 3 + [float(np.max(body.moments)) * rate] * 3 for body in system.of_bodies.values()]
    momentum = float(system.body.reduced_mass) * distance * rate
    return np.array([*own[0], *own[1], *[distance] * 3, *[momentum] * 3])


def symmetry_axis(body: Any) -> Array | None:
    """Return the axis of symmetry of a body, along its axes; None if no two moments are equal."""
    small, middle, large = np.sort(np.asarray(body.moments))
    axes = rotation_matrix(upright(body))  # rows are the principal axes by ascending moments
    if middle - small <= EQUAL_MOMENTS * large:
        return np.asarray(axes[2])
    return np.asarray(axes[0]) if large - middle <= EQUAL_MOMENTS * large else None


def cross_matrix(vector: Array) -> Array:
    """Return the matrix of x -> vector x x."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
