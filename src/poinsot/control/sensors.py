"""What a sampled law sees of the motion: all of it, or with noise and in steps."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_negative
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.members import of_scalars
from poinsot.mechanics.parameters import Parametric
from poinsot.quantities import Angle, AngularVelocity, Real, Rule

__all__ = ["NoisySensors", "Sensors"]


class Sensors(Parametric):
    """Ideal sensors of a sampled law. Subclasses add measurement errors.

    Examples
    --------
    >>> pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=0.1).sensors
    Sensors()
    """

    @property
    def draws(self) -> tuple[int, Scalar]:
        """Number of random numbers for each sample, and their seed."""
        return 0, 0.0

    @of_scalars
    def measured(self, instant: Instant, draws: Vector) -> Instant:  # noqa: ARG002
        """Return the instant as a law sees it, from numbers of the standard normal distribution."""
        return instant


LARGEST_SEED = 2.0**52


def _refuse_no_seed(name: str, value: Any, _: str) -> None:
    seeds = np.ravel(value)
    wrong = seeds[(seeds != np.rint(seeds)) | (seeds < 0) | (seeds > LARGEST_SEED)]
    if wrong.size:
        raise ValueError(f"{name} must be a whole number from 0 to 2^52, got {wrong[0]}.")


def _refuse_coarse(name: str, value: Any, _: str) -> None:
    refuse_negative(name, value)
    if np.any(np.asarray(value) > 1):
        raise ValueError(f"{name} must be at most 1 radian, got {np.max(value)}.")


class NoisySensors(Sensors):
    """Sensors of attitude and rate with white noise and quantisation.

    Measured are omega + s n, rounded to multiples of a quantum, and the body axes turned by d = s' n' about themselves,
    by the angle 2 atan(|d|/2); n, n' are three independent numbers each of the standard normal distribution. The four
    components of the measured quaternion are rounded to multiples of half a quantum, and divided by its length. Noise
    depends on seed, member and number of the sample alone, not on threads or output times: the same run gives the same
    noise. Drifts of a gyro are left out.

    Parameters
    ----------
    rate_noise : float
        s, the standard deviation of each component of the rate at a sample.
    attitude_noise : float
        s', radians, that of the turn about each body axis.
    rate_quantum : float
        Of which measured rates are multiples; 0: of none.
    attitude_quantum : float
        Radians, at most 1; 0: no rounding. Small angles are its multiples.
    seed : float
        A whole number from 0 to 2^52.

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
    def draws(self) -> tuple[int, Scalar]:
        return 6, self.seed

    @override
    def measured(self, instant: Instant, draws: Vector) -> Instant:
        omega = instant.omega_body + self.rate_noise * Vector(draws[:3])
        turn = 0.5 * self.attitude_noise * Vector(draws[3:])
        size = functions.sqrt(1 + functions.dot(turn, turn))
        attitude = instant.attitude.turned(Vector((1 / size, *(x / size for x in turn))))
        q = _rounded(attitude.quaternion, 0.5 * self.attitude_quantum)
        seen = Attitude.from_quaternion(q * (1 / functions.norm(q)))
        return Instant(instant.body, seen, instant.environment, _rounded(omega, self.rate_quantum))


def _rounded(numbers: Iterable[Scalar], quantum: Scalar) -> Vector:
    """Return numbers rounded to multiples of a quantum, as they are where it is 0."""
    steps = functions.less(0.0, quantum)
    return Vector(functions.where(steps, functions.rint(x / quantum) * quantum, x) for x in numbers)
