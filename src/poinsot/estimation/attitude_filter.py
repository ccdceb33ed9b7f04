"""Multiplicative extended Kalman filter of the attitude, and its smoother."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times
from poinsot.errors import real_array
from poinsot.estimation.process import Estimate, Process, SystemProcess
from poinsot.estimation.residuals import difference_slopes, differences
from poinsot.estimation.rotation_vectors import difference, jacobian
from poinsot.kinematics.attitude import rotation, unit_quaternion
from poinsot.kinematics.state import State
from poinsot.observables.readings import Readings
from poinsot.quantities import Array
from poinsot.systems.system import System

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Filtered", "Smoothed", "kalman_filter"]


class FilterNode(NamedTuple):
    """Estimate at a time before and after the measurements there.

    Attributes
    ----------
    transition : array (k, k)
        Transition matrix of errors from the last node.
    predicted, corrected : Estimate
        Estimates before and after the measurements.
    predicted_covariance, covariance : array (k, k)
        Their covariances.
    """

    transition: Array
    predicted: Estimate
    predicted_covariance: Array
    corrected: Estimate
    covariance: Array


class FilterUpdate(NamedTuple):
    """Measurement at a time: its innovation with covariance, and True if it was used."""

    time: float
    readings: int
    innovation: Array
    innovation_covariance: Array
    used: bool

    @property
    def nis(self) -> float:
        """Normalised innovation squared, z S^-1 z."""
        return float(self.innovation @ np.linalg.solve(self.innovation_covariance, self.innovation))


class History(Summarized):
    """Estimates at times with their covariances.

    Attributes
    ----------
    times : array (n,)
        Times of the estimates.
    quaternion : array (n, 4)
        Attitudes, body -> space.
    own : dict of array (n, ...)
        Other variables by name: the bias of a gyro, or angular momentum and variables of parts.
    covariance : array (n, k, k)
        Covariances of the errors (theta, differences of the other variables), theta along the body axes, rad.
    """

    _title = ""

    def __init__(self, estimates: Sequence[Estimate], covariance: Array, lengths: Mapping[str, int]) -> None:
        self.times = np.array([each.time for each in estimates])
        self.quaternion = np.array([each.quaternion for each in estimates])
        others = np.array([each.others for each in estimates])
        sizes = np.cumsum([*lengths.values()])[:-1]
        self.own = dict(zip(lengths, np.split(others, sizes, axis=1), strict=True))
        self.covariance = covariance

    @property
    def attitude(self) -> Rotation:
        """Attitudes as a scipy rotation, body -> space."""
        return rotation(self.quaternion)

    @property
    def standard_deviations(self) -> Array:
        """Standard deviations of the errors, (n, k)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        last = self.standard_deviations[-1]
        return self._title, {
            "times": formatted_times(self.times),
            "attitude, standard deviations at the end": formatted(last[:3], "rad"),
            **{f"{name} at the end": formatted(values[-1]) for name, values in self.own.items()},
        }


class Smoothed(History):
    """Estimates that use the measurements at all times."""

    _title = "Smoothed attitudes"


class Filtered(History):
    """Estimates of a Kalman filter, each from the measurements up to its time.

    Attributes
    ----------
    updates : tuple of FilterUpdate
        Measurements with their innovations.
    """

    _title = "Attitudes of a Kalman filter"

    def __init__(
        self, nodes: Sequence[FilterNode], updates: Sequence[FilterUpdate], lengths: Mapping[str, int]
    ) -> None:
        super().__init__([each.corrected for each in nodes], np.array([each.covariance for each in nodes]), lengths)
        self._nodes, self.updates, self._lengths = tuple(nodes), tuple(updates), lengths

    @property
    def nis(self) -> Array:
        """Normalised innovations squared of the updates; each is chi-square distributed if the model is right."""
        return np.array([each.nis for each in self.updates])

    @property
    def refused(self) -> tuple[FilterUpdate, ...]:
        """Measurements whose innovations the gate refused."""
        return tuple(each for each in self.updates if not each.used)

    def smoothed(self) -> Smoothed:
        """Return the estimates that use all measurements (Rauch, Tung and Striebel 1965, AIAA J. 3, 1445).

        Covariances are carried between the axes of the predicted, filtered and smoothed attitudes by the right Jacobian
        of the rotation vector, as the reset of the filter does.
        """
        *_, last = self._nodes
        estimates, covariances = [last.corrected], [last.covariance]
        for node, after in zip(self._nodes[-2::-1], self._nodes[:0:-1], strict=True):
            estimate, covariance = _smoothed(node, after, estimates[-1], covariances[-1])
            estimates.append(estimate)
            covariances.append(covariance)
        return Smoothed(estimates[::-1], np.array(covariances[::-1]), self._lengths)


def _smoothed(node: FilterNode, after: FilterNode, later: Estimate, covariance: Array) -> tuple[Estimate, Array]:
    gain = np.linalg.solve(after.predicted_covariance, after.transition @ node.covariance).T
    theta = difference(after.predicted.quaternion, later.quaternion)
    error = gain @ np.concatenate([theta, later.others - after.predicted.others])
    others = np.eye(len(error) - 3)
    carried = block_diag(np.linalg.inv(jacobian(theta)), others)
    to_smoothed = block_diag(jacobian(error[:3]), others)
    change = carried @ covariance @ carried.T - after.predicted_covariance
    total = node.covariance + gain @ change @ gain.T
    return node.corrected.corrected(error), to_smoothed @ total @ to_smoothed.T


class Measurement(NamedTuple):
    """Innovation of a reading with its derivatives by the errors and the covariance of its noise."""

    innovation: Array
    derivatives: Array
    noise: Array


@checked
def kalman_filter(
    process: Process | System,
    data: Sequence[Readings],
    state: State | None = None,
    covariance: ArrayLike | None = None,
    *,
    attitude: Rotation | ArrayLike | None = None,
    time: float | None = None,
    torque_noise: ArrayLike | None = None,
    gate: float | None = None,
) -> Filtered:
    """Return the estimates of a multiplicative extended Kalman filter along measurements.

    The attitude changes by rotations q exp(theta / 2). After each update the covariance is carried to the axes of the
    corrected attitude, P <- G P G^T with the right Jacobian of theta (Markley, Cheng, Crassidis and Reynolds 2023, J.
    Guid. Control Dyn. 46, 1860).

    Parameters
    ----------
    process : Process or System
        Motion between measurements: `GyroProcess`, or a system, whose transition matrix `state_transition` computes.
    data : list of Readings
        Measurements with values and standard deviations.
    state : State, optional
        Initial state for a system.
    covariance : array (k, k)
        Covariance of the initial errors: theta along the body axes in radians, then the other variables.
    attitude : Rotation or array (4,), optional
        Initial attitude for a `GyroProcess`, whose initial bias is zero.
    time : float, optional
        Time of the initial attitude. Default: the first time of the measurements.
    torque_noise : float or array (3,), optional
        For a system, the spectral density of the torque along each body axis, torque^2 times time. Default: zero.
    gate : float, optional
        Largest normalised innovation squared of a measurement that is used. Default: all are used.

    Returns
    -------
    Filtered
        Estimates at the ends of all steps, with innovations, and the smoother as a method.
    """
    model, estimate = _start(process, state, attitude, time, torque_noise, data)
    size = 3 + len(estimate.others)
    P = real_array("covariance", covariance, (size, size))
    nodes, updates = [FilterNode(np.eye(size), estimate, P, estimate, P)], list[FilterUpdate]()
    for moment, readings in _in_order(data, estimate.time):
        if moment > estimate.time:
            for step in model.steps(estimate, moment):
                P = step.transition @ P @ step.transition.T + step.noise
                estimate = step.estimate
                nodes.append(FilterNode(step.transition, estimate, P, estimate, P))
        for number, place in readings:
            found = _measurement(model, estimate, data[number], place)
            S = found.derivatives @ P @ found.derivatives.T + found.noise
            update = FilterUpdate(moment, number, found.innovation, S, True)
            if gate is not None and update.nis > gate:
                updates.append(update._replace(used=False))
                continue
            updates.append(update)
            estimate, P = _updated(estimate, P, found, S)
        nodes[-1] = nodes[-1]._replace(corrected=estimate, covariance=P)
    return Filtered(nodes, updates, model.lengths)


def _updated(estimate: Estimate, P: Array, found: Measurement, S: Array) -> tuple[Estimate, Array]:
    """Return estimate and covariance after an update in Joseph's form, in the axes of the corrected attitude."""
    gain = np.linalg.solve(S, found.derivatives @ P).T
    error, left = gain @ found.innovation, np.eye(len(P)) - gain @ found.derivatives
    joseph = left @ P @ left.T + gain @ found.noise @ gain.T
    reset = block_diag(jacobian(error[:3]), np.eye(len(P) - 3))
    return estimate.corrected(error), reset @ joseph @ reset.T


def _measurement(process: Process, estimate: Estimate, readings: Readings, place: int) -> Measurement:
    """Return the innovation of a reading, with its derivatives by the errors of the estimate."""
    observable, sigma = readings.observable, readings.sigma
    if readings.values is None or sigma is None:
        missing = "values" if readings.values is None else "sigma"
        raise ValueError(f"data must have {missing}, but {readings.name} has none. Give {missing}= to its Readings.")
    predicted, columns = process.predicted(estimate, readings, place)
    read = readings.values[place]
    innovation = differences(observable, read, predicted)
    derivatives = -difference_slopes(observable, predicted, predicted, columns)
    full = np.broadcast_to(sigma, (readings.times.size, *((len(innovation),) if observable.errors else ())))
    deviations = np.atleast_1d(full[place])
    return Measurement(innovation, derivatives, np.diag(deviations**2))


def _in_order(data: Sequence[Readings], start: float) -> Iterator[tuple[float, list[tuple[int, int]]]]:
    """Yield the times of all measurements in order, with the numbers of readings and of the places in them."""
    every: dict[float, list[tuple[int, int]]] = {}
    for number, readings in enumerate(data):
        for place, moment in enumerate(readings.times.tolist()):
            every.setdefault(moment, []).append((number, place))
    if every and min(every) < start:
        raise ValueError(
            f"data must begin at or after the initial time {start:g}, got {min(every):g}. Give an earlier start."
        )
    yield from sorted(every.items())


def _start(
    process: Process | System,
    state: State | None,
    attitude: Rotation | ArrayLike | None,
    time: float | None,
    torque_noise: ArrayLike | None,
    data: Sequence[Readings],
) -> tuple[Process, Estimate]:
    """Return the process and the initial estimate."""
    if isinstance(process, System):
        if state is None:
            raise ValueError("state must be given where the process is a system, got none. Give the initial state.")
        model = SystemProcess(process, 0.0 if torque_noise is None else torque_noise)
        others = np.concatenate([state.angular_momentum_body, *state.own.values()])
        return model, Estimate(float(state.time), state.quaternion, others)
    if torque_noise is not None:
        raise ValueError("torque_noise must come with a system as the process, got a gyro. Leave it out.")
    if attitude is None:
        raise ValueError("attitude must be given where the process is a gyro, got none. Give the initial attitude.")
    first = min(float(readings.times[0]) for readings in data) if time is None else time
    return process, Estimate(first, unit_quaternion(attitude), np.zeros(sum(process.lengths.values())))
