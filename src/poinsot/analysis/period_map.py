"""The period map of a rotation relative to a frame, and its derivatives."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.analysis.transition_matrix import state_transition
from poinsot.errors import PropagationError
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.frame import Frame
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System

__all__ = ["ROUNDS", "Passage", "PeriodMap", "Point"]

Array = NDArray[Any]

Point = tuple[Array, Array]
"""A unit quaternion body -> frame and an angular momentum, body axes."""

SAME = 1e-9
"""By how much a torque or a rate, relative to its size, may change from one period to the next."""
ROUNDS = 40
LARGEST_STEP = 0.3
"""Of Newton's method, radians; of the momentum, what turns the body by so much in a period."""
SETTLED = 1e-7
"""The error after a step is of the order of its square."""
FIRM = 1e-10
"""Singular values below this, of the largest, are those of a direction in which there is another such motion."""
GROWTH = 1e9
"""Of displacements in a period, beyond which rounding moves the end by more than what counts as settled."""


@dataclasses.dataclass(frozen=True)
class Passage:
    """One period from a point: where it leads, and its derivatives, as displacements.

    Attributes
    ----------
    end : Point
    change : array (6,)
        From the start to the end.
    matrix : array (6, 6)
        What becomes of small displacements.
    slope : array (6, p)
        The displacement of the end by the named numbers.
    """

    end: Point
    change: Array
    matrix: Array
    slope: Array


class PeriodMap:
    """The motion over one period.

    Displacements of points are rotation vectors and momenta times period / largest moment, shape (..., 6), radians.
    """

    def __init__(self, system: System, frame: Frame, time: float, period: float) -> None:
        self.system, self.frame, self.time, self.period = system, frame, time, period
        self.momentum = float(np.max(system.body.moments)) / period

    @property
    def units(self) -> Array:
        """What displacements are multiplied by to become rotation vectors and momenta, (6,)."""
        return np.array([1.0] * 3 + [self.momentum] * 3)

    # ------------------------------------------------------------------ points

    def displaced(self, point: Point, x: Array) -> Point:
        """Return the point at a displacement from one."""
        from scipy.spatial.transform import Rotation

        p, g = point
        turned = rotation(p) * Rotation.from_rotvec(x[:3])
        return turned.as_quat(scalar_first=True), g + self.momentum * x[3:]

    def displacement(self, point: Point, other: Point) -> Array:
        """Return what leads from one point to another."""
        turn = rotation(point[0]).inv() * rotation(other[0])
        return np.concatenate([turn.as_rotvec(), (other[1] - point[1]) / self.momentum])

    def point(self, state: State) -> Point:
        """Return the point of a state at the start."""
        to_frame = quat.conjugate(self.frame.quaternion(self.time))
        return quat.product(to_frame, state.quaternion), np.asarray(state.angular_momentum_body)

    def state(self, point: Point) -> State:
        """Return the state of a point at the start."""
        to_space = quat.product(self.frame.quaternion(self.time), point[0])
        return self.system.body.state(to_space, angular_momentum_body=point[1], time=self.time)

    def passage(self, point: Point, names: Sequence[str] = ()) -> Passage:
        """Return what a period does, with the derivatives by named numbers of the system."""
        end = self.time + self.period
        try:
            found = state_transition(self.system, self.state(point), [end], names, progress=False)
        except PropagationError as error:
            raise ValueError(f"guess must lead to a motion without end, but {error}") from None
        to_frame = quat.conjugate(self.frame.quaternion(end))
        there = quat.product(to_frame, found.motion.quaternion[0]), found.motion.angular_momentum_body[0]
        matrix = found.matrix[0] * self.units / self.units[:, None]
        growth = float(np.max(np.abs(matrix)))
        if not growth < GROWTH:
            raise ValueError(
                "guess must lead to a motion that depends smoothly on its start, but over the period "
                f"{self.period:.6g} small displacements grow {growth:.1g} times. Choose a shorter period."
            )
        slope = found.sensitivity[0] / self.units[:, None]
        return Passage(there, self.displacement(point, there), matrix, slope)

    # ------------------------------------------------------------------ the motion that repeats itself

    def settled(self, guess: State) -> tuple[Point, Array]:
        """Return where Newton's method leads, and the derivative of the motion over the period there."""
        point = self.point(guess)
        for _ in range(ROUNDS):
            passage = self.passage(point)
            step = np.linalg.lstsq(np.eye(6) - passage.matrix, passage.change, rcond=FIRM)[0]
            missed, size = (largest_part(x) for x in (passage.change, step))
            point = self.displaced(point, step * (LARGEST_STEP / max(size, LARGEST_STEP)))
            if max(missed, size) < SETTLED:
                return point, self.passage(point).matrix
        raise ValueError(
            f"guess must be near a motion that repeats itself, but after {ROUNDS} steps of Newton's method it still "
            f"misses itself by {missed:.2g} rad in a period. Start nearer, or elsewhere."
        )

    # ------------------------------------------------------------------ checks

    def check(self, angular_momentum_body: Array) -> None:
        """Refuse a system or a frame that does not repeat itself."""
        self._check_system(angular_momentum_body)
        self._check_frame()

    def _check_frame(self) -> None:
        """Refuse a frame whose angular velocity along its own axes does not repeat itself."""
        here, there = (
            quat.rotate(quat.conjugate(self.frame.quaternion(times)), self.frame.omega_space(times))
            for times in self._times()
        )
        change, fastest = np.max(np.abs(there - here)), np.max(np.abs(here))
        if change > self._slack * fastest:
            raise ValueError(
                f"frame must turn in the same way in every period, but its angular velocity changes by "
                f"{change / fastest:.2g} of its size. A RotatingFrame turns at a constant rate."
            )

    def _check_system(self, g: Array) -> None:
        """Refuse a system whose torques, seen from the frame, do not repeat themselves."""
        first, last = self.system.span
        if self.time < first or self.time + 2 * self.period > last:
            raise ValueError(
                f"period must fit twice into the span of the orbits, [{first!r}, {last!r}], got {self.period!r}, "
                f"from {self.time!r}."
            )
        attitudes = np.random.default_rng(20061027).normal(size=(4, 1, 4))
        attitudes /= np.linalg.norm(attitudes, axis=-1, keepdims=True)
        here, there = (self._torques(times, attitudes, g) for times in self._times())
        change, size = np.max(np.abs(there - here)), np.max(np.abs(here))
        if not change <= self._slack * size:
            raise ValueError(
                f"system must repeat itself in the frame after the period {self.period:.6g}, but its torque changes "
                f"by {change / size:.2g} of its size. Name the period of the orbit, and the frame that turns with its "
                "node."
            )

    def _torques(self, times: Array, attitudes: Array, g: Array) -> Array:
        q = quat.product(self.frame.quaternion(times), attitudes).reshape(-1, 4)
        state = self.system.body.state(
            q, angular_momentum_body=np.broadcast_to(g, (len(q), 3)), time=np.tile(times, len(attitudes))
        )
        return np.asarray(self.system.torque_body(state))

    def _times(self) -> tuple[Array, Array]:
        """Return times in one period and in the next."""
        times = self.time + self.period * np.array([0.0, 0.13, 0.37, 0.71])
        return times, times + self.period

    @property
    def _slack(self) -> float:
        return SAME + 10 * float(np.spacing(abs(self.time) + self.period)) / self.period


def largest_part(x: Array) -> float:
    """Return the larger of the sizes of the turn and of the change of momentum of a displacement."""
    return float(np.max(np.linalg.norm(x.reshape(2, 3), axis=-1)))
