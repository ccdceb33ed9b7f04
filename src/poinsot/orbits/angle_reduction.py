"""Reduction of angles linear in time, without loss of digits after many revolutions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot import functions
from poinsot.double_double import PI, SPLITTER, DoubleDouble, exact_sum
from poinsot.functions import Scalar
from poinsot.taylor.graph import number

__all__ = ["NearbyAngle", "angle_at", "elapsed", "mean_motion_of"]

FULL = PI.scaled(4.0)
"""Two turns, which leave the half angles of a quaternion, and so its sign, as they are."""

LONG = np.longdouble
LONG_FULL = LONG(FULL.hi) + LONG(FULL.lo)
LONG_ENOUGH = 1e-18
FEW_TURNS = 80
"""Pairs of turns after which long doubles of 64 bits hold an angle to 1e-16."""


def mean_motion_of(mu: Scalar, semimajor_axis: Scalar, beyond: Scalar = 0.0) -> Any:
    """Return sqrt(mu / a^3) + beyond; of floats as a DoubleDouble."""
    if _plain(mu, semimajor_axis, beyond):
        a = _wide(semimajor_axis)
        return (_wide(mu) / (a * a * a)).sqrt() + _wide(beyond)
    return functions.sqrt(mu / semimajor_axis**3) + beyond


def angle_at(start: Scalar, rate: Any, time: Scalar, epoch: Scalar, whole: bool = False) -> Scalar:
    """Return start + rate (time - epoch), radians.

    Of floats it is reduced to [-2 pi, 2 pi] unless it is asked for as a whole, from a sum of some 32 digits:
    its error is the rounding of the result and of `start`, at any time.
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
    """The angle start + rate (time - epoch), faster than `angle_at` where long doubles leave no more than rounding.

    What the reduction needs of the rate is computed once.

    Parameters
    ----------
    start, epoch : scalars
    squared_rate : callable
        Returns the square of the rate in a kind of number.
    """

    def __init__(self, start: Scalar, squared_rate: Callable[[Any], Any], epoch: Scalar) -> None:
        self._start, self._epoch = start, epoch
        self._is_known = np.finfo(LONG).eps <= LONG_ENOUGH and _plain(start, epoch)
        if self._is_known:
            self._is_long = np.result_type(np.float64, np.asarray(start)) == LONG
            self._rate = np.sqrt(squared_rate(LONG))
            period, fast, ahead = LONG_FULL / self._rate, _wide(self._rate), _wide(start / self._rate)
            self._period, self._fast, self._few = _rounded(period), fast.hi, _few_bits(fast.hi)
            self._short, self._slow = _few_bits(self._period), (fast.hi - self._few) + fast.lo
            self._rest = _rounded(period - self._short)
            self._zero = DoubleDouble.difference(epoch, ahead.hi) - ahead.lo  # when the angle is zero

    def at(self, time: Scalar) -> Any:
        """Return the angle at a time less whole pairs of turns; None where it is not known to rounding."""
        if not (self._is_known and _plain(time)):
            return None
        if self._is_long or getattr(time, "dtype", None) == LONG:
            angle = self._start + self._rate * (np.asarray(time, dtype=LONG) - self._epoch)
            turns = np.rint(_rounded(angle) / FULL.hi)
            return angle - LONG_FULL * turns if _are_few(turns) else None
        since, below = exact_sum(time, -self._zero.hi)
        turns = np.rint(since / self._period)
        if not _are_few(turns):
            return None
        # The product modulo two turns is that of the time modulo two periods.
        rest = since - turns * self._short  # exact, as a few turns have few bits too
        late, most = (below - self._zero.lo) - turns * self._rest, _few_bits(rest)
        return self._few * most + (self._fast * ((rest - most) + late) + self._slow * most)


def _are_few(turns: Any) -> bool:
    return bool(np.maximum.reduce(np.abs(turns), axis=None, initial=0.0) < FEW_TURNS)


def _rounded(x: Any) -> Any:
    """Return long doubles as doubles."""
    return np.asarray(x, dtype=float)[()]


def elapsed(start: Scalar, time: Scalar, epoch: Scalar) -> Scalar:
    """Return start + (time - epoch), of floats rounded once."""
    return angle_at(start, 1.0, time, epoch, whole=True)


def _plain(*scalars: Scalar) -> bool:
    """Return True if all scalars are floats or arrays of floats, not symbols or numbers of another precision."""
    kinds = int, float, np.ndarray, np.generic
    return False not in [isinstance(x, kinds) and np.asarray(x).dtype != object for x in scalars]


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
