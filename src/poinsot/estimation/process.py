"""Processes of a filter: how attitude, other variables and their covariance change between measurements.

The errors of an estimate are theta, a rotation vector along the body axes with q_true = q exp(theta / 2), and the
differences of the other variables.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot.analysis.reading_partials import observed_partials
from poinsot.analysis.transition_matrix import state_transition
from poinsot.errors import real_numbers, refuse_negative
from poinsot.estimation.rotation_vectors import cross_matrix, jacobian, rotated, sine_defect_ratio, turn
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.observables.readings import Readings
from poinsot.quantities import Array
from poinsot.systems.system import System

__all__ = ["Estimate", "GyroProcess", "Process", "Step", "SystemProcess"]

NOISE_TOLERANCE = 1e-11
"""Relative change of the covariance of the noise at which the number of quadrature nodes is sufficient."""

UNIT_BODY = System(Body((1.0, 1.0, 1.0)))
"""Body whose angular momentum is its angular velocity, for readings of attitude and angular velocity."""

MAX_NODES = 256
"""Largest number of quadrature nodes in a step."""


class Estimate(NamedTuple):
    """Attitude and other variables at a time.

    Attributes
    ----------
    time : float
    quaternion : array (4,)
        Attitude, body -> space.
    others : array (k - 3,)
        Other variables: the bias of a gyro, or angular momentum along the body axes and variables of parts.
    """

    time: float
    quaternion: Array
    others: Array

    def corrected(self, error: Array) -> Estimate:
        """Return the estimate plus an error (theta, differences of the others)."""
        return Estimate(self.time, rotated(self.quaternion, error[:3]), self.others + error[3:])


class Step(NamedTuple):
    """Prediction over a step: the estimate at its end, the transition matrix of errors, and the added covariance."""

    estimate: Estimate
    transition: Array
    noise: Array


class Process(ABC):
    """Model of the motion between the measurements of a filter; the base class of processes."""

    @property
    @abstractmethod
    def lengths(self) -> Mapping[str, int]:
        """Names of the variables other than the attitude, with their lengths."""

    @abstractmethod
    def steps(self, estimate: Estimate, stop: float) -> Iterator[Step]:
        """Yield the steps from an estimate to a later time."""

    @abstractmethod
    def predicted(self, estimate: Estimate, readings: Readings, place: int) -> tuple[Array, Array]:
        """Return the predicted reading at a place of readings, with its derivatives by the errors of the estimate."""


class GyroProcess(Process):
    """Process whose angular velocity is measured by a gyro: measured = omega + bias + noise, bias' = noise.

    A sample holds from its time to the time of the next sample. The transition matrix and the covariance of the noise
    are exact for a constant angular velocity (Farrenkopf 1978, J. Guid. Control 1, 282, for one axis).

    Parameters
    ----------
    readings : Readings
        Angular velocities along the body axes, (n, 3), at increasing times.
    white_noise : float
        Square root of the spectral density of the noise of the angular velocity, rad / sqrt(time).
    bias_walk : float
        Square root of the spectral density of the rate of the bias, rad / time^(3/2).

    Raises
    ------
    ValueError
        If the readings are not angular velocities at increasing times, or a density is negative.
    """

    def __init__(self, readings: Readings, white_noise: float, bias_walk: float) -> None:
        times, values = readings.times, readings.values
        if values is None or values.shape != (times.size, 3):
            shape = "none" if values is None else f"shape {values.shape}"
            raise ValueError(f"readings must have values of shape ({times.size}, 3), got {shape}.")
        if np.any(np.diff(times) <= 0):
            raise ValueError("readings must have increasing times, got others. Sort them.")
        for name, value in (("white_noise", white_noise), ("bias_walk", bias_walk)):
            refuse_negative(name, value)
        self.readings, self.white_noise, self.bias_walk = readings, float(white_noise), float(bias_walk)
        self._times, self._omega = times, values

    @property
    @override
    def lengths(self) -> Mapping[str, int]:
        return {"bias": 3}

    @override
    def steps(self, estimate: Estimate, stop: float) -> Iterator[Step]:
        inside = (self._times > estimate.time) & (self._times < stop)
        for end in (*self._times[inside], stop):
            omega, duration = self._omega_at(estimate), end - estimate.time
            quaternion = rotated(estimate.quaternion, omega * duration)
            noise = noise_of_step(omega, duration, self.white_noise, self.bias_walk)
            estimate = Estimate(float(end), quaternion, estimate.others)
            yield Step(estimate, transition_of_step(omega, duration), noise)

    @override
    def predicted(self, estimate: Estimate, readings: Readings, place: int) -> tuple[Array, Array]:
        omega = self._omega_at(estimate)
        state = UNIT_BODY.body.state(estimate.quaternion, omega_body=omega, time=estimate.time)
        values, columns = _of_state(UNIT_BODY, state, readings, place)
        return values, columns * np.repeat((1.0, -1.0), 3)  # omega is the sample minus the bias

    def _omega_at(self, estimate: Estimate) -> Array:
        """Return the angular velocity of the sample that holds at the time of an estimate, without the bias."""
        number = np.searchsorted(self._times, estimate.time, side="right") - 1
        if number < 0:
            raise ValueError(
                f"readings must begin at or before the first time of the filter, {estimate.time:g}, got "
                f"{self._times[0]:g}. Start the filter later."
            )
        return np.asarray(self._omega[number] - estimate.others)


class SystemProcess(Process):
    """Process that follows the equations of motion of a system, with white noise of the torque.

    Parameters
    ----------
    system : System
        System of one body, without random numbers of sensors.
    torque_noise : float or array (3,)
        Spectral density of the torque along each body axis, torque^2 times time.
    """

    def __init__(self, system: System, torque_noise: ArrayLike = 0.0) -> None:
        self.system = system
        refuse_negative("torque_noise", torque_noise)
        self._density = np.broadcast_to(real_numbers("torque_noise", torque_noise), 3)

    @property
    @override
    def lengths(self) -> Mapping[str, int]:
        return {"angular_momentum_body": 3} | {part.name: part.size for part in self.system.parts if part.size}

    @override
    def steps(self, estimate: Estimate, stop: float) -> Iterator[Step]:
        start, nodes = self._state(estimate), 8
        while True:
            noise, before, step = self._step(start, stop, nodes)
            if np.max(np.abs(noise - before)) <= NOISE_TOLERANCE * np.max(np.abs(noise)) or nodes >= MAX_NODES:
                yield step._replace(noise=noise)
                return
            nodes *= 2

    def _step(self, start: State, stop: float, nodes: int) -> tuple[Array, Array, Step]:
        """Return the covariance of the noise with `nodes` nodes and with half of them, and the step."""
        first, length = float(start.time), stop - float(start.time)
        rules = [np.polynomial.legendre.leggauss(n) for n in (nodes, nodes // 2)]
        places = [first + 0.5 * length * (1 + x) for x, _ in rules]
        times = np.unique(np.concatenate([*places, [stop]]))
        found = state_transition(self.system, start, times)
        last = found.matrix[-1]
        sums = []
        for (_, weights), at in zip(rules, places, strict=True):
            to_nodes = np.swapaxes(found.matrix[np.searchsorted(times, at)], -1, -2)
            from_nodes = np.linalg.solve(to_nodes, np.broadcast_to(last.T, to_nodes.shape))[:, 3:6]
            sums.append(0.5 * length * np.einsum("n,nai,a,naj->ij", weights, from_nodes, self._density, from_nodes))
        end = found.motion.isel(time=-1)
        others = np.concatenate([end.angular_momentum_body, *end.own.values()])
        return sums[0], sums[1], Step(Estimate(stop, end.quaternion, others), last, sums[0])

    @override
    def predicted(self, estimate: Estimate, readings: Readings, place: int) -> tuple[Array, Array]:
        return _of_state(self.system, self._state(estimate), readings, place)

    def _state(self, estimate: Estimate) -> State:
        names, sizes = [*self.lengths], np.cumsum([*self.lengths.values()])[:-1]
        parts = dict(zip(names, np.split(estimate.others, sizes), strict=True))
        momentum = parts.pop("angular_momentum_body")
        own: dict[str, Any] = parts
        return self.system.state(estimate.quaternion, angular_momentum_body=momentum, time=estimate.time, **own)


def _of_state(system: System, state: State, readings: Readings, place: int) -> tuple[Array, Array]:
    """Return a reading of a state, with its derivatives by the coordinates of the state."""
    found = observed_partials(system, state, readings.isel(time=[place]))
    return found.values[0], found.by_start[0]


# ---------------------------------------------------------------------- steps of a gyro


def transition_of_step(omega: Array, duration: float) -> Array:
    """Return the transition matrix exp(F dt) of the errors (theta, bias), F = [[-[omega x], -1], [0, 0]].

    Parameters
    ----------
    omega : array (3,)
        Angular velocity without bias along the body axes, constant during the step.
    duration : float
        Duration dt of the step.
    """
    found = np.eye(6)
    found[:3, :3] = turn(omega * duration)
    found[:3, 3:] = -jacobian(omega * duration) * duration
    return found


def noise_of_step(omega: Array, duration: float, white_noise: float, bias_walk: float) -> Array:
    """Return the covariance that a step adds, the integral of exp(F s) diag(sv^2, su^2) exp(F s)^T over the step.

    With the unit vector u of omega, a = |omega| dt and P = 1 - u u^T, the integral of J J^T s^2 is
    dt^3 (u u^T / 3 + 2 P (a - sin a)/a^3), and the integral of J s is dt^2 (u u^T / 2 + P (1 - cos a)/a^2) minus
    dt^2 (a - sin a)/a^2 [u x].
    """
    rotation = omega * duration
    angle = np.linalg.norm(rotation)
    along = np.zeros((3, 3)) if angle == 0 else np.outer(rotation, rotation) / angle**2
    across, ratio = np.eye(3) - along, sine_defect_ratio(np.asarray(angle))
    versine = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    squares = duration**3 * (along / 3 + 2 * ratio * across)
    firsts = duration**2 * (along / 2 + versine * across - ratio * cross_matrix(rotation))
    found = np.zeros((6, 6))
    found[:3, :3] = white_noise**2 * duration * np.eye(3) + bias_walk**2 * squares
    found[:3, 3:] = -(bias_walk**2) * firsts
    found[3:, :3] = found[:3, 3:].T
    found[3:, 3:] = bias_walk**2 * duration * np.eye(3)
    return found
