"""Sample states at which the formulas of a system are tried."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.mechanics.collection import Collection
from poinsot.mechanics.environment import sample_time

__all__ = ["samples", "time_scale"]

Array = NDArray[np.float64]


def samples(system: Collection, count: int = 6) -> tuple[Array, Array, Array]:
    """Return unit quaternions (n, 4), times (n,) and rates (n, 3), always the same."""
    random = np.random.default_rng(20061027)
    q = random.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    scale = time_scale(system)
    farthest = min([3.0, *(np.log10(np.min(orbit.sample_reach) / scale) for orbit in system.orbits)])
    times = random.uniform(-1, 1, count) * 10.0 ** np.linspace(-1, farthest, count)  # near and far, for what switches
    return q, _within(system.span, sample_time(system.orbits) + times * scale), random.normal(size=(count, 3))


def _within(limits: tuple[float, float], times: Array) -> Array:
    first, last = limits
    return first + np.mod(times - first, last - first) if np.isfinite(last - first) else times


def time_scale(system: Collection) -> float:
    """Return the time in which the fastest orbit turns by about a radian; 1 without one."""
    rates = [
        np.max(functions.norm(orbit.velocity_at(t)) * orbit.inverse_distance_at(t))
        for orbit in system.orbits
        for t in [orbit.sample_time]
    ]
    return 1 / float(np.max(rates, initial=0.0) or 1.0)
