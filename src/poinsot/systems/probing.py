"""Sample states at which the formulas of a system are tried."""

from __future__ import annotations

from typing import Any

import numpy as np

from poinsot import functions
from poinsot.mechanics.environment import sample_time
from poinsot.quantities import Array
from poinsot.systems.collection import Collection

__all__ = ["sample_times", "samples", "time_scale", "time_scales"]


def samples(system: Collection, count: int = 6) -> tuple[Array, Array, Array]:
    """Return unit quaternions (n, 4), times (n,) and rates (n, 3), always the same."""
    random = np.random.default_rng(20061027)
    q = random.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    uniform, scale = random.uniform(-1, 1, count), time_scale(system)
    farthest = min([3.0, *(np.log10(np.min(orbit.sample_reach) / scale) for orbit in system.orbits)])
    times = uniform * 10.0 ** np.linspace(-1, farthest, count)  # near and far, for what switches
    return q, _within(system.span, sample_time(system.orbits) + times * scale), random.normal(size=(count, 3))


def sample_times(system: Collection, count: int) -> Array:
    """Return times at which each member is tried, its own, near and far; shape (count,) or (members, count)."""
    uniform, scale = np.random.default_rng(20061027).uniform(-1, 1, count), time_scales(system)
    farthest, start = np.full_like(scale, 3.0), np.zeros_like(scale)
    for orbit in reversed(system.orbits):
        farthest = np.minimum(farthest, np.log10(orbit.sample_reach / scale))
        start = np.where(orbit.sample_time != 0, orbit.sample_time, start)
    times = uniform * 10.0 ** np.linspace(-1, farthest, count, axis=-1)
    return _within(system.span, start[..., None] + times * scale[..., None])


def _within(limits: tuple[float, float], times: Array) -> Array:
    first, last = limits
    return first + np.mod(times - first, last - first) if np.isfinite(last - first) else times


def time_scale(system: Collection) -> float:
    """Return the time in which the fastest orbit of all members turns by about a radian; 1 without one."""
    return float(np.min(time_scales(system)))


def time_scales(system: Collection) -> Array:
    """Return the time in which the fastest orbit of each member turns by about a radian; 1 without one."""
    rates: Any = np.zeros(())
    for orbit in (path.with_axes(1) for path in system.orbits):
        t = orbit.sample_time
        rates = np.maximum(rates, np.asarray(functions.norm(orbit.velocity_at(t)) * orbit.inverse_distance_at(t)))
    return 1 / np.where(rates > 0, rates, 1.0)
