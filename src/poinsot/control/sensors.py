"""Sensor models of sampled control laws: ideal, or with noise and quantisation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_negative
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.noise import random_turn
from poinsot.quantities import Angle, AngularVelocity, Real, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Parametric

__all__ = ["NoisySensors", "Sensors"]


class Sensors(Parametric):
    """Ideal sensors of a sampled control law, without noise; base class of sensor models.

    Examples
    --------
    >>> pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=0.1).sensors
    Sensors()
    """

    @property
    def draws(self) -> tuple[int, Any]:
        """Number of random numbers per sample, and their seed."""
        return 0, 0.0

    @of_scalars
    def measured(self, instant: Instant, draws: Vector) -> Instant:  # noqa: ARG002
        """Return the instant as the control law measures it, from standard normal random numbers."""
        return instant


MAX_SEED = 2.0**52


def _refuse_no_seed(name: str, value: Any, _: str) -> None:
    seeds = np.ravel(value)
    wrong = seeds[(seeds != np.rint(seeds)) | (seeds < 0) | (seeds > MAX_SEED)]
    if wrong.size:
        raise ValueError(f"{name} must be a whole number from 0 to 2^52, got {wrong[0]}.")


def _refuse_coarse(name: str, value: Any, _: str) -> None:
    refuse_negative(name, value)
    if np.any(np.asarray(value) > 1):
        raise ValueError(f"{name} must be at most 1 radian, got {np.max(value)}.")


class NoisySensors(Sensors):
    """Attitude and angular-velocity sensors with white noise and quantisation.

    The measured angular velocity is omega + s n, rounded to multiples of a quantum. The measured attitude is rotated by
    d = s' n' in body axes, with the angle 2 atan(|d|/2). n and n' each contain three independent standard normal
    numbers. The components of the measured quaternion are rounded to multiples of half a quantum and normalised. The
    noise depends only on the seed, the member and the sample number, not on threads or output times, so a run is
    reproducible. The model ignores gyroscope drift.

    Parameters
    ----------
    rate_noise : float
        Standard deviation s of each component of the angular velocity at a sample, in angle per time.
    attitude_noise : float
        Standard deviation s' of the rotation about each body axis, radians.
    rate_quantum : float
        Quantum of the measured angular velocity, in angle per time; 0: no rounding.
    attitude_quantum : float
        Quantum of small attitude angles, radians, at most 1; 0: no rounding.
    seed : float
        Integer from 0 to 2^52.

    Examples
    --------
    >>> sensors = pt.control.NoisySensors(rate_noise=1e-3, seed=7)
    >>> law = pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=0.1, sensors=sensors)
    >>> system = pt.System(pt.Body((10, 12, 8)), law)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    >>> bool(abs(pt.propagate(system, start, [10.0]).omega_body).max() < 1e-3)
    True
    """

    rate_noise: Annotated[AngularVelocity, Rule(refuse_negative)] = 0.0
    attitude_noise: Annotated[Angle, Rule(refuse_negative)] = 0.0
    rate_quantum: Annotated[AngularVelocity, Rule(refuse_negative)] = 0.0
    attitude_quantum: Annotated[Angle, Rule(_refuse_coarse)] = 0.0
    seed: Annotated[Real, Rule(_refuse_no_seed)] = 0.0

    @property
    @override
    def draws(self) -> tuple[int, Any]:
        return 6, self.seed

    @override
    def measured(self, instant: Instant, draws: Vector) -> Instant:
        omega = instant.omega_body + self.rate_noise * Vector(draws[:3])
        attitude = instant.attitude.turned(random_turn(Vector(draws[3:]) * self.attitude_noise))
        q = _rounded(attitude.quaternion, 0.5 * self.attitude_quantum)
        seen = Attitude.from_quaternion(q * (1 / functions.norm(q)))
        return Instant(instant.body, seen, instant.environment, _rounded(omega, self.rate_quantum))


def _rounded(numbers: Iterable[Scalar], quantum: Scalar) -> Vector:
    """Return numbers rounded to multiples of a quantum; a quantum of 0 leaves them unchanged."""
    steps = functions.less(0.0, quantum)
    return Vector(functions.where(steps, functions.rint(x / quantum) * quantum, x) for x in numbers)
