"""Reduction of angles linear in time, without loss of digits after many revolutions."""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot import functions
from poinsot.double_double import PI, SPLITTER, DoubleDouble, exact_sum
from poinsot.functions import Scalar
from poinsot.taylor.graph import number

__all__ = ["NearbyAngle", "angle_at", "elapsed", "mean_motion_of"]

FULL = PI.scaled(4.0)
"""Two turns. They change neither the half angles of a quaternion nor its sign."""

MAX_TURN_PAIRS = 80
"""Largest number of pairs of turns that `NearbyAngle` reduces: beyond it the omitted products exceed rounding."""


def mean_motion_of(mu: Scalar, semimajor_axis: Scalar, beyond: Scalar = 0.0) -> Any:
    """Return sqrt(mu / a^3) + beyond; of floats as a DoubleDouble."""
    if _plain(mu, semimajor_axis, beyond):
        a = _wide(semimajor_axis)
        return (_wide(mu) / (a * a * a)).sqrt() + _wide(beyond)
    return functions.sqrt(mu / semimajor_axis**3) + beyond


def angle_at(start: Scalar, rate: Any, time: Scalar, epoch: Scalar, whole: bool = False) -> Scalar:
    """Return start + rate (time - epoch), radians.

    For floats, a sum of 32 digits is reduced to [-2 pi, 2 pi], unless `whole` is True. At any time, the error is the
    rounding of the result and of `start`.
    """
    here = number(time)
    if not _plain(start, here, epoch) or not (isinstance(rate, DoubleDouble) or _plain(rate)):
        plain: Scalar = start + getattr(rate, "hi", rate) * (time - epoch)
        return plain
    rate = rate if isinstance(rate, DoubleDouble) else _wide(rate)
    total = rate * (_wide(here) - _wide(epoch)) + _wide(start)
    if not whole:
        total = total - FULL * np.floor(total.hi / FULL.hi + 0.5)
    angle = _narrow(total, start, here)
    value: Scalar = angle if here is time else angle + rate.hi * (time - here)
    return value


class NearbyAngle:
    """Angle start + rate (time - epoch) of doubles, faster than `angle_at` within some pairs of turns of zero.

    The constants of the reduction are computed once, with 32 digits.

    Parameters
    ----------
    start, epoch : scalars
    rate : DoubleDouble or scalar
    """

    def __init__(self, start: Scalar, rate: Any, epoch: Scalar) -> None:
        self._is_known = isinstance(rate, DoubleDouble) and _are_doubles(start, epoch)
        if self._is_known:
            period, ahead = FULL / rate, start / rate
            self._period, self._fast, self._few = period.hi, rate.hi, _few_bits(rate.hi)
            self._short, self._slow = _few_bits(period.hi), (rate.hi - self._few) + rate.lo
            self._rest = (period - self._short).hi
            self._zero = DoubleDouble.difference(epoch, ahead.hi) - ahead.lo  # when the angle is zero

    def at(self, time: Scalar) -> Any:
        """Return the angle at a time less whole pairs of turns; None where it is not known to rounding."""
        if not (self._is_known and _are_doubles(time)):
            return None
        since, below = exact_sum(time, -self._zero.hi)
        turns = np.rint(since / self._period)
        if not np.maximum.reduce(np.abs(turns), axis=None, initial=0.0) < MAX_TURN_PAIRS:
            return None
        # The time modulo two periods gives the product modulo two turns.
        rest = since - turns * self._short  # exact, as a few turns have few bits too
        late, most = (below - self._zero.lo) - turns * self._rest, _few_bits(rest)
        return self._few * most + (self._fast * ((rest - most) + late) + self._slow * most)


def elapsed(start: Scalar, time: Scalar, epoch: Scalar) -> Scalar:
    """Return start + (time - epoch), of floats rounded once."""
    return angle_at(start, 1.0, time, epoch, whole=True)


def _plain(*scalars: Scalar) -> bool:
    """Return True if all scalars are floats or arrays of floats, not symbols or numbers of another precision."""
    kinds = int, float, np.ndarray, np.generic
    return False not in [isinstance(x, kinds) and np.asarray(x).dtype != object for x in scalars]


def _are_doubles(*scalars: Scalar) -> bool:
    """Return True if all scalars are numbers of double precision."""
    return _plain(*scalars) and np.result_type(np.float64, *map(np.asarray, scalars)) == np.float64


def _few_bits(x: Any) -> Any:
    """Return a float rounded to 26 bits (Veltkamp)."""
    scaled = SPLITTER * x
    return scaled - (scaled - x)


def _wide(x: Any) -> DoubleDouble:
    """Return a float or a long double without rounding."""
    high = np.asarray(x, dtype=np.float64)[()]
    return DoubleDouble(high, np.asarray(x - high, dtype=np.float64)[()])


def _narrow(x: DoubleDouble, *like: Any) -> Any:
    kind = np.result_type(np.float64, *like)
    return np.asarray(x.hi, dtype=kind)[()] + x.lo
