"""Period maps of one body and of two, and their derivatives: Newton's method finds their fixed points.

The map of one body is relative to a frame. The map of two bodies is up to a turn about the total angular momentum.
Periodic motions of two bodies come in families, by energy and angular momentum: Newton's method conserves both from
the guess, and converges to the nearest of the motions that differ by turns of space and by times. The period is one of
the unknowns. The turn, and spins about axes of symmetry, are the ones that lead closest back to the point.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.analysis.pair_point import PairPoint, symmetry_axis, units_of_pair
from poinsot.analysis.transition_matrix import state_transition
from poinsot.errors import PropagationError
from poinsot.integration.scaling import orbital_rate
from poinsot.integration.state_vector import factors_of_parts
from poinsot.kinematics.attitude import rotation
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import AnyState, PairState, State, changed, state_with
from poinsot.mechanics.part import jumps_at
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.systems.system import System

__all__ = ["FAMILY_TOLERANCE", "MAX_LAST_STEP", "PairPeriodMap", "PeriodMap", "Point", "largest_component"]

Point = tuple[Array, Array]
"""A unit quaternion body -> frame, and an angular momentum, body axes, with the variables of parts behind it."""
Unknown = TypeVar("Unknown")

PERIODICITY_TOLERANCE = 1e-9
"""Largest change of a torque or rate from one period to the next, relative to its size."""
MAX_ITERATIONS = 40
MAX_STEP = 0.3
"""Largest step of Newton's method, radians. A momentum counts by the angle that it turns the body in a period."""
MAX_LAST_STEP = 1e-7
"""Largest step after which Newton's method has converged: the error is of the order of its square."""
FAMILY_TOLERANCE = 1e-10
"""Relative size of singular values in whose direction another periodic motion exists."""
REST_TOLERANCE = 1e-6
"""Largest rate in rotating axes at a relative equilibrium, relative to the rates in space."""
MAX_GROWTH = 1e9
"""Largest growth of displacements in a period. Beyond it rounding moves the end by more than the last step."""


@dataclasses.dataclass(frozen=True)
class Passage:
    """End of one period from a point, and its derivatives as displacements.

    Attributes
    ----------
    end : Point
    change : array (k,)
        Displacement from the start to the end.
    matrix : array (k, k)
        Derivative of the end by the start.
    slope : array (k, p)
        Derivative of the end by the named numbers.
    """

    end: Point
    change: Array
    matrix: Array
    slope: Array


class PeriodMap:
    """Map of the motion of one body over one period.

    Displacements of points have shape (k,), k = 6 and the variables of parts: a rotation vector, momenta times period /
    largest moment, other variables divided by about ten times their initial size.

    Attributes
    ----------
    units : array (k,)
        Factors from displacements to rotation vectors, momenta and variables.
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
        """Return the displacement from one point to another."""
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
        """Return the passage of a period, with the derivatives by named numbers of the system."""
        last, matrix, slope = _after_period(self.system, self.state(point), self.period, names, self.units)
        to_frame = quat.conjugate(self.frame.quaternion(self.time + self.period))
        there = quat.product(to_frame, last.quaternion), self._rest(last)
        return Passage(there, self.displacement(point, there), matrix, slope)

    # ------------------------------------------------------------------ fixed point

    def fixed_point(self, guess: State) -> tuple[Point, Array]:
        """Return the fixed point to which Newton's method converges, and the derivative of the map there."""
        point = _converged(self._improved, self.point(guess), "repeats itself")
        return point, self.passage(point).matrix

    def _improved(self, point: Point) -> tuple[Point, float, float]:
        """Return the point after a step of Newton's method, and the sizes of the error before it and of the step."""
        passage = self.passage(point)
        slope = np.eye(self.units.size) - passage.matrix
        step = np.asarray(np.linalg.lstsq(slope, passage.change, rcond=FAMILY_TOLERANCE)[0], dtype=float)
        missed, size = (largest_component(x) for x in (passage.change, step))
        return self.displaced(point, step * (MAX_STEP / max(size, MAX_STEP))), missed, size

    # ------------------------------------------------------------------ checks

    def check(self) -> None:
        """Raise an error if the angular velocity of the frame, or a torque in the frame, is not periodic.

        For a system with parts the rates of their variables and the angular velocity at the initial momenta are
        checked, too.
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
        """Yield the names of vectors that change from one period to the next, with the relative changes."""
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


# ---------------------------------------------------------------------- two bodies


@dataclasses.dataclass(frozen=True)
class PairPassage:
    """End of one period from a point of two bodies; displacements are divided by units.

    Attributes
    ----------
    turn : float
        Angle of the turn about the total angular momentum, in (-pi, pi].
    change : array (18,)
        Displacement from the start to the end, without the turn and spins.
    matrix : array (18, 18)
        Derivative of the end by the start, at the same turn and spins.
    slope : array (18, 2 + n)
        Derivative of the end by the number of periods, by the turn, and by the spins.
    """

    turn: float
    change: Array
    matrix: Array
    slope: Array


class PairPeriodMap:
    """Map of the motion of two bodies over a period."""

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
        """Return the passage of a period."""
        from scipy.spatial.transform import Rotation

        last, matrix, _ = _after_period(self.system, point.state(self.time), period, (), self.units)
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

        Its shape is (12, 12), two less for each axis of symmetry. It is (14, 14) at a relative equilibrium, where the
        flow coincides with symmetries.
        """
        flow = self._flow(point)
        basis = point.free(self.about(point), self.axes, self.units)
        along, up = basis.T @ (flow / self.units), basis.T @ (self._energy_slope(point) * self.units)
        if np.linalg.norm(along) > REST_TOLERANCE * np.linalg.norm(flow / self.units):
            both = np.array([along / np.linalg.norm(along), up / np.linalg.norm(up)])
            basis = basis @ np.linalg.svd(both)[2][2:].T
        return np.asarray(basis.T @ matrix @ basis)

    def fixed_point(self, period: float) -> tuple[PairPoint, float, PairPassage]:
        """Return the fixed point to which Newton's method converges, its period, and the passage of this period."""
        point, period = _converged(self._improved, (self.start, period), "repeats itself up to a turn")
        return point, period, self.passage(point, period)

    def _improved(self, here: tuple[PairPoint, float]) -> tuple[tuple[PairPoint, float], float, float]:
        """Return point and period after a step of Newton's method, and the sizes of the error and of the step."""
        point, period = here
        passage = self.passage(point, period)
        x, longer = self._step(point, passage)
        missed, size = (float(np.max(np.linalg.norm(y.reshape(6, 3), axis=1))) for y in (passage.change, x))
        size = max(size, abs(longer))
        share = MAX_STEP / max(size, MAX_STEP)
        return (point.displaced(share * x * self.units), period * (1 + share * longer)), missed, size

    def _step(self, point: PairPoint, passage: PairPassage) -> tuple[Array, float]:
        """Return the shortest displacement to a periodic motion, and the relative change of the period.

        Conserved quantities are equal at the end for any start, so that their derivatives there are no equations. The
        equations that replace them demand the values of the guess.
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
        """Return the derivatives of the conserved quantities by displacements divided by units."""
        rows = [point.by_displacement(), self._energy_slope(point), point.spin_momenta(self.axes)]
        return np.vstack(rows) * self.units


# ---------------------------------------------------------------------- both


def _converged(improved: Callable[[Unknown], tuple[Unknown, float, float]], guess: Unknown, kind: str) -> Unknown:
    """Return the unknown to which steps of Newton's method converge from a guess.

    A step returns the improved unknown, and the sizes of the error before it and of the step.
    """
    for _ in range(MAX_ITERATIONS):
        guess, missed, size = improved(guess)
        if max(missed, size) < MAX_LAST_STEP:
            return guess
    raise ValueError(
        f"guess must be near a motion that {kind}, but after {MAX_ITERATIONS} steps of Newton's method it still "
        f"misses itself by {missed:.2g} rad in a period. Start nearer, or elsewhere."
    )


def _after_period(
    system: System, start: AnyState, period: float, names: Sequence[str], units: Array
) -> tuple[Any, Array, Array]:
    """Return the state after a period, and its derivatives by the start and by named numbers, divided by units."""
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


def largest_component(x: Array) -> float:
    """Return the largest of the angle of the turn, the change of momentum and the changes of variables of parts."""
    return float(max(*np.linalg.norm(x[:6].reshape(2, 3), axis=-1), *np.abs(x[6:])))


def _angle(about: Array, a: Array, b: Array) -> float:
    """Return the angle from one vector to another about a unit vector."""
    return float(np.arctan2(about @ np.cross(a, b), a @ b - (a @ about) * (b @ about)))
