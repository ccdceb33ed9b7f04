"""The motion of two bodies over a period, up to a turn about the total angular momentum.

Such motions come in families, by energy and angular momentum: Newton's method keeps both as they are in the guess, and
takes the nearest of those that differ by turns of space and by times. The period is one of the unknowns; the turn, and
spins about axes of symmetry, are those that lead closest back.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.analysis.pair_point import PairPoint, symmetry_axis, units_of_pair
from poinsot.analysis.period_map import FAMILY_TOLERANCE, MAX_ITERATIONS, MAX_LAST_STEP, MAX_STEP, carried
from poinsot.integration.scaling import orbital_rate
from poinsot.mechanics.state import PairState
from poinsot.mechanics.system import System
from poinsot.mechanics.two_bodies import TwoBodies

__all__ = ["PairPassage", "PairPeriodMap"]

Array = NDArray[Any]

REST_TOLERANCE = 1e-6
"""Largest rate in rotating axes at a relative equilibrium, relative to the rates in space."""


@dataclasses.dataclass(frozen=True)
class PairPassage:
    """One period from a point; displacements are over units.

    Attributes
    ----------
    turn : float
        About the total angular momentum, in (-pi, pi].
    change : array (18,)
        From the start to the end, without the turn and spins.
    matrix : array (18, 18)
        The derivative of the end by the start, at the same turn and spins.
    slope : array (18, 2 + n)
        That by the number of periods, by the turn, and by the spins.
    """

    turn: float
    change: Array
    matrix: Array
    slope: Array


class PairPeriodMap:
    """The motion of two bodies over a period."""

    def __init__(self, system: System[TwoBodies], guess: PairState) -> None:
        self.system, self.time, self.start = system, float(guess.time), PairPoint.of(guess)
        self.units = units_of_pair(
            system, float(np.linalg.norm(guess.position)), float(orbital_rate(system.dynamics, guess))
        )
        self.axes = tuple(map(symmetry_axis, system.of_bodies.values()))

    def about(self, point: PairPoint) -> Array:
        """Return the direction of the total angular momentum."""
        return np.asarray(point.total / np.linalg.norm(point.total))

    def passage(self, point: PairPoint, period: float) -> PairPassage:
        """Return what a period does."""
        from scipy.spatial.transform import Rotation

        last, matrix, _ = carried(self.system, point.state(self.time), period, (), self.units)
        end, about = PairPoint.of(last), self.about(point)
        turn = _angle(about, point.position, end.position)
        back = Rotation.from_rotvec(-turn * about)
        end = end.turned(back)
        unspun = Rotation.from_rotvec([-x for x in self._spins(point, end)])
        end = end.spun(unspun)
        for own, each in zip((slice(0, 6), slice(6, 12)), unspun.inv().as_matrix(), strict=True):
            matrix[own] = np.kron(np.eye(2), each) @ matrix[own]
        matrix[12:] = np.kron(np.eye(2), back.as_matrix()) @ matrix[12:]
        flow = period * self._flow(end)
        slope = np.column_stack([flow, -end.turning(about), -end.spinning(self.axes)]) / self.units[:, None]
        return PairPassage(turn, point.displacement(end) / self.units, matrix, slope)

    def _spins(self, point: PairPoint, end: PairPoint) -> list[Array]:
        """Return the rotation vector of each body about its axis of symmetry, along its axes."""
        turns = quat.product(quat.conjugate(point.attitudes), end.attitudes)
        return [
            np.zeros(3) if axis is None else 2 * np.arctan2(turn[1:] @ axis, turn[0]) * axis
            for axis, turn in zip(self.axes, turns, strict=True)
        ]

    def _flow(self, point: PairPoint) -> Array:
        """Return the displacement per time."""
        turnings, own = self.system.dynamics.changes(self.system.dynamics.at(point.state(self.time)))
        values = [x for each in turnings for x in (*each.omega, *each.momentum_rate)]
        return np.array([*values, *own["orbit"]], dtype=float)

    def _energy_slope(self, point: PairPoint) -> Array:
        """Return the derivative of the energy by displacements."""
        flow = self._flow(point)
        own = [
            (np.cross(g, w) - rate, w) for g, (w, rate) in zip(point.momenta, flow[:12].reshape(2, 2, 3), strict=True)
        ]
        return np.concatenate([*own[0], *own[1], -flow[15:], flow[12:15]])

    def reduced(self, point: PairPoint, matrix: Array) -> Array:
        """Return the derivative among motions of the same energy and momenta, up to symmetries and times.

        (12, 12), two less for each axis of symmetry; (14, 14) of a relative equilibrium, along which no symmetry stops.
        """
        flow = self._flow(point)
        basis = point.free(self.about(point), self.axes, self.units)
        along, up = basis.T @ (flow / self.units), basis.T @ (self._energy_slope(point) * self.units)
        if np.linalg.norm(along) > REST_TOLERANCE * np.linalg.norm(flow / self.units):
            both = np.array([along / np.linalg.norm(along), up / np.linalg.norm(up)])
            basis = basis @ np.linalg.svd(both)[2][2:].T
        return np.asarray(basis.T @ matrix @ basis)

    def settled(self, period: float) -> tuple[PairPoint, float, PairPassage]:
        """Return where Newton's method leads, with the period and what it does there."""
        point = self.start
        for _ in range(MAX_ITERATIONS):
            passage = self.passage(point, period)
            x, longer = self._step(point, passage)
            missed, size = (float(np.max(np.linalg.norm(y.reshape(6, 3), axis=1))) for y in (passage.change, x))
            size = max(size, abs(longer))
            share = MAX_STEP / max(size, MAX_STEP)
            point, period = point.displaced(share * x * self.units), period * (1 + share * longer)
            if max(missed, size) < MAX_LAST_STEP:
                return point, period, self.passage(point, period)
        raise ValueError(
            f"guess must be near a motion that repeats itself up to a turn, but after {MAX_ITERATIONS} steps of "
            f"Newton's method it still misses itself by {missed:.2g} rad in a period. Start nearer, or elsewhere."
        )

    def _step(self, point: PairPoint, passage: PairPassage) -> tuple[Array, float]:
        """Return the shortest displacement to a motion that repeats itself, and the change of the period, relative.

        What is conserved is equal at the end, whatever the start, so that its derivatives there are no equations; in
        place of them it is that of the guess.
        """
        rows = self._conserved_slopes(point)
        sizes = np.linalg.norm(rows, axis=1)
        ends = self._conserved_slopes(point.displaced(passage.change * self.units)) / sizes[:, None]
        others = np.linalg.svd(ends)[2][len(ends) :]
        slopes = others @ np.hstack([np.eye(18) - passage.matrix, -passage.slope])
        held = np.hstack([rows / sizes[:, None], np.zeros((len(rows), passage.slope.shape[1]))])
        missing = (self._conserved(self.start) - self._conserved(point)) / sizes
        right = np.concatenate([others @ passage.change, missing])
        step = np.linalg.lstsq(np.vstack([slopes, held]), right, rcond=FAMILY_TOLERANCE)[0]
        return step[:18], float(step[18])

    def _conserved(self, point: PairPoint) -> Array:
        """Return the angular momentum, the energy and the momenta of spins."""
        spins = [g @ axis for g, axis in zip(point.momenta, self.axes, strict=True) if axis is not None]
        return np.array([*point.total, self.system.energy(point.state(self.time)), *spins], dtype=float)

    def _conserved_slopes(self, point: PairPoint) -> Array:
        """Return their derivatives by displacements over units."""
        rows = [point.by_displacement(), self._energy_slope(point), point.spin_momenta(self.axes)]
        return np.vstack(rows) * self.units


def _angle(about: Array, a: Array, b: Array) -> float:
    """Return the angle from one vector to another about a unit vector."""
    return float(np.arctan2(about @ np.cross(a, b), a @ b - (a @ about) * (b @ about)))
