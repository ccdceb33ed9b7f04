"""The period map of a rotation relative to a frame, and its derivatives."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.analysis.transition_matrix import state_transition
from poinsot.errors import PropagationError
from poinsot.integration.state_vector import factors_of_parts
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.frame import Frame
from poinsot.mechanics.part import jumps_at
from poinsot.mechanics.state import AnyState, State, changed, state_with
from poinsot.mechanics.system import System
from poinsot.printable import quoted

__all__ = ["MAX_ITERATIONS", "Passage", "PeriodMap", "Point", "carried"]

Array = NDArray[Any]

Point = tuple[Array, Array]
"""A unit quaternion body -> frame; and an angular momentum, body axes, with the variables of parts behind it."""

PERIODICITY_TOLERANCE = 1e-9
"""Largest change of a torque or rate from one period to the next, relative to its size."""
MAX_ITERATIONS = 40
MAX_STEP = 0.3
"""Of Newton's method, radians; of the momentum, what turns the body by so much in a period."""
MAX_LAST_STEP = 1e-7
"""The error after a step is of the order of its square."""
FAMILY_TOLERANCE = 1e-10
"""Singular values below this, of the largest, are those of a direction in which there is another such motion."""
MAX_GROWTH = 1e9
"""Largest growth of displacements in a period. Beyond it rounding moves the end by more than the last step."""


@dataclasses.dataclass(frozen=True)
class Passage:
    """One period from a point: where it leads, and its derivatives, as displacements.

    Attributes
    ----------
    end : Point
    change : array (k,)
        From the start to the end.
    matrix : array (k, k)
        The derivative of the end by the start.
    slope : array (k, p)
        That by the named numbers.
    """

    end: Point
    change: Array
    matrix: Array
    slope: Array


class PeriodMap:
    """The motion over one period.

    Displacements of points have shape (k,), k = 6 and the variables of parts: a rotation vector, momenta times period /
    largest moment, other variables over about ten times the size that they have from the start.

    Attributes
    ----------
    units : array (k,)
        What turns displacements into rotation vectors, momenta and variables.
    """

    def __init__(self, system: System, frame: Frame, start: State, period: float) -> None:
        self.system, self.frame, self.start, self.period = system, frame, start, period
        self.time = float(start.time)
        momentum = float(np.max(system.of_bodies[""].moments)) / period
        factors = itertools.chain.from_iterable(factors_of_parts(system.dynamics, start).values())
        own = (momentum if factor is None else 1 / factor for factor in factors)
        self.units = np.array([1.0] * 3 + [momentum] * 3 + [*own])

    # ------------------------------------------------------------------ points

    def displaced(self, point: Point, x: Array) -> Point:
        """Return the point at a displacement from one."""
        from scipy.spatial.transform import Rotation

        p, rest = point
        turned = rotation(p) * Rotation.from_rotvec(x[:3])
        return turned.as_quat(scalar_first=True), rest + self.units[3:] * x[3:]

    def displacement(self, point: Point, other: Point) -> Array:
        """Return what leads from one point to another."""
        turn = rotation(point[0]).inv() * rotation(other[0])
        return np.concatenate([turn.as_rotvec(), (other[1] - point[1]) / self.units[3:]])

    def point(self, state: State) -> Point:
        """Return the point of a state at the start."""
        to_frame = quat.conjugate(self.frame.quaternion(self.time))
        return quat.product(to_frame, state.quaternion), self._rest(state)

    def state(self, point: Point, time: float | None = None) -> State:
        """Return the state of a point at a time, by default at the start."""
        time = self.time if time is None else time
        return self._state(quat.product(self.frame.quaternion(time), point[0]), point[1], time)

    def _state(self, q: Array, rest: Array, time: Any) -> State:
        sizes = {part.name: part.size for part in self.system.parts if part.size}
        g, *values = np.split(rest, list(itertools.accumulate(sizes.values(), initial=3)), axis=-1)
        state = state_with(q, g, time, dict(zip(sizes, values, strict=False)))
        jumped = jumps_at(self.system.dynamics.jumping, time)  # the end of a period is a row
        return State.computed(state.phase, state.time, jumped)

    def _rest(self, state: State) -> Array:
        own = [state.own[part.name] for part in self.system.parts if part.size]
        return np.concatenate([state.angular_momentum_body, *own], axis=-1)

    def flow(self, end: Point) -> Array:
        """Return the displacement per time at the end of the period, seen from the axes that the frame has there."""
        instant = self.system.dynamics.at(self.state(end, self.time + self.period))
        rates = self.system.dynamics.rates(instant) | {"quaternion": instant.omega_body}
        return np.asarray(np.concatenate([list(map(float, values)) for values in rates.values()]) / self.units)

    def passage(self, point: Point, names: Sequence[str] = ()) -> Passage:
        """Return what a period does, with the derivatives by named numbers of the system."""
        last, matrix, slope = carried(self.system, self.state(point), self.period, names, self.units)
        to_frame = quat.conjugate(self.frame.quaternion(self.time + self.period))
        there = quat.product(to_frame, last.quaternion), self._rest(last)
        return Passage(there, self.displacement(point, there), matrix, slope)

    # ------------------------------------------------------------------ the motion that repeats itself

    def settled(self, guess: State) -> tuple[Point, Array]:
        """Return where Newton's method leads, and the derivative of the motion over the period there."""
        point = self.point(guess)
        for _ in range(MAX_ITERATIONS):
            passage = self.passage(point)
            step = np.linalg.lstsq(np.eye(self.units.size) - passage.matrix, passage.change, rcond=FAMILY_TOLERANCE)[0]
            missed, size = (largest_part(x) for x in (passage.change, step))
            point = self.displaced(point, step * (MAX_STEP / max(size, MAX_STEP)))
            if max(missed, size) < MAX_LAST_STEP:
                return point, self.passage(point).matrix
        raise ValueError(
            f"guess must be near a motion that repeats itself, but after {MAX_ITERATIONS} steps of Newton's method "
            f"it still misses itself by {missed:.2g} rad in a period. Start nearer, or elsewhere."
        )

    # ------------------------------------------------------------------ checks

    def check(self) -> None:
        """Refuse a frame whose angular velocity does not repeat itself, or a system whose torques do not in the frame.

        Of a system with parts also the rates of their variables and the angular velocity at the momenta of the start.
        """
        first, last = self.system.span
        if self.time < first or self.time + 2 * self.period > last:
            raise ValueError(
                f"period must fit twice into the span of the orbits, [{quoted(first)}, {quoted(last)}], got "
                f"{quoted(self.period)}, "
                f"from {quoted(self.time)}."
            )
        for name, change in self._changes(self._vectors_of_system):
            raise ValueError(
                f"system must repeat itself in the frame after the period {self.period:.6g}, but its {name} changes "
                f"by {change:.2g} of its size. Name the period of the orbit, and the frame that turns with its node."
            )
        for _, change in self._changes(self._omega_of_frame):
            raise ValueError(
                f"frame must turn in the same way in every period, but its angular velocity changes by "
                f"{change:.2g} of its size. A RotatingFrame turns at a constant rate."
            )

    def _changes(self, vectors: Callable[[Array], dict[str, Array]]) -> Iterator[tuple[str, float]]:
        """Yield which vectors, as functions of time, change from one period to the next, and by which share."""
        times = self.time + self.period * np.array([0.0, 0.13, 0.37, 0.71])
        slack = PERIODICITY_TOLERANCE + 10 * float(np.spacing(abs(self.time) + self.period)) / self.period
        here, there = (vectors(each) for each in (times, times + self.period))
        for name, values in here.items():
            change, size = np.max(np.abs(there[name] - values)), np.max(np.abs(values))
            if not change <= slack * size:
                yield name, change / size

    def _omega_of_frame(self, times: Array) -> dict[str, Array]:
        """Return the angular velocity of the frame along its own axes."""
        to_frame = quat.conjugate(self.frame.quaternion(times))
        return {"angular velocity": quat.rotate(to_frame, self.frame.omega_space(times))}

    def _vectors_of_system(self, times: Array) -> dict[str, Array]:
        """Return torque, angular velocity and rates of parts, at some attitudes in the frame."""
        attitudes = np.random.default_rng(20061027).normal(size=(4, 1, 4))
        attitudes /= np.linalg.norm(attitudes, axis=-1, keepdims=True)
        q = quat.product(self.frame.quaternion(times), attitudes).reshape(-1, 4)
        rest = self._rest(self.start)
        state = self._state(q, np.broadcast_to(rest, (len(q), rest.size)), np.tile(times, len(attitudes)))
        vectors = {"torque": np.asarray(self.system.torque_body(state))}
        if self.system.parts:
            vectors["angular velocity"] = np.asarray(self.system.omega_body(state))
            _, rates = self.system.dynamics.changes(self.system.dynamics.at(state))
            vectors |= {name: np.stack(np.broadcast_arrays(*values)) for name, values in rates.items()}
        return vectors


def carried(
    system: System, start: AnyState, period: float, names: Sequence[str], units: Array
) -> tuple[Any, Array, Array]:
    """Return the state a period after another, and its derivatives by that one and by named numbers, over units."""
    end = float(start.time) + period
    try:
        found = state_transition(system, start, [end], names, progress=False)
    except PropagationError as error:
        raise ValueError(f"guess must lead to a motion without end, but {error}") from None
    matrix = found.matrix[0] * units / units[:, None]
    growth = float(np.max(np.abs(matrix)))
    if not growth < MAX_GROWTH:
        raise ValueError(
            "guess must lead to a motion that depends smoothly on its start, but over the period "
            f"{period:.6g} small displacements grow {growth:.1g} times. Choose a shorter period."
        )
    return (
        type(start).computed(changed(found.motion.phase, lambda x: x[0]), end),
        matrix,
        found.sensitivity[0] / units[:, None],
    )


def largest_part(x: Array) -> float:
    """Return the largest of the sizes of the turn, of the change of momentum and of those of the variables of parts."""
    return float(max(*np.linalg.norm(x[:6].reshape(2, 3), axis=-1), *np.abs(x[6:])))
