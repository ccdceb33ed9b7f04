"""Reduction of angles linear in time, without loss of digits after many revolutions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from poinsot import functions
from poinsot.algebra.double_double import PI, SPLITTER, DoubleDouble
from poinsot.algebra.program import number
from poinsot.functions import Scalar

__all__ = ["angle_at", "angle_nearby", "elapsed", "mean_motion_of"]

FULL = PI.scaled(4.0)
"""Two turns, which leave the half angles of a quaternion, and so its sign, as they are."""

LONG = np.longdouble
LONG_FULL = LONG(FULL.hi) + LONG(FULL.lo)
LONG_ENOUGH = 1e-18
FEW_RADIANS = 1e3
"""An angle that long doubles of 64 bits hold to 1e-16."""


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
        return start + getattr(rate, "hi", rate) * (time - epoch)
    rate = rate if isinstance(rate, DoubleDouble) else _wide(rate)
    total = rate * (_wide(here) - _wide(epoch)) + _wide(start)
    if not whole:
        total = total - FULL * np.floor(total.hi / FULL.hi + 0.5)
    angle = _narrow(total, start, here)
    return angle if here is time else angle + rate.hi * (time - here)


def angle_nearby(start: Scalar, squared_rate: Callable[[Any], Any], time: Scalar, epoch: Scalar) -> Any:
    """Return the same from long doubles, which is faster, where these leave no more than rounding; else None.

    The rate is the square root of a function of the kind of number to compute it in.
    """
    if np.finfo(LONG).eps > LONG_ENOUGH or not _plain(start, time, epoch):
        return None
    kind, rate = np.result_type(np.float64, start, time), np.sqrt(squared_rate(LONG))
    since = np.asarray(time, dtype=kind) - epoch
    near = np.asarray(start + np.asarray(rate, dtype=kind) * since, dtype=float)
    if not np.max(np.abs(near), initial=0.0) < FEW_RADIANS:
        return None
    turns = np.rint(near / FULL.hi)
    if kind == LONG:
        return start + rate * since - LONG_FULL * turns
    return _reduced(start, rate, DoubleDouble.difference(time, epoch), turns)


def _reduced(start: Scalar, rate: Any, since: DoubleDouble, turns: Any) -> Any:
    """Return start + rate (time - epoch) modulo two turns: the product is that of the time modulo two periods."""
    period, fast = LONG_FULL / rate, np.asarray(rate, dtype=float)[()]
    short = _few_bits(np.asarray(period, dtype=float)[()])
    rest = since.hi - turns * short  # exact, as a few turns have few bits too
    late = since.lo - turns * np.asarray(period - short, dtype=float)[()]
    slow = np.asarray(rate - fast, dtype=float)[()]
    angle = DoubleDouble.product(fast, rest)
    whole = DoubleDouble.difference(angle.hi, -start)
    return whole.hi + (whole.lo + (angle.lo + (fast * late + slow * rest)))


def elapsed(start: Scalar, time: Scalar, epoch: Scalar) -> Scalar:
    """Return start + (time - epoch), of floats rounded once."""
    return angle_at(start, 1.0, time, epoch, whole=True)


def _plain(*scalars: Scalar) -> bool:
    """Whether all are floats or arrays of floats: no symbols, no numbers with digits of their own."""
    return all(isinstance(x, int | float | np.ndarray | np.generic) and np.asarray(x).dtype != object for x in scalars)


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
