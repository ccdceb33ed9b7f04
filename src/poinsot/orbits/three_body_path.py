"""The path of a small body beside two attractors on circles, for numbers: Taylor series, one after another.

In the axes that turn with the attractors, origin at the secondary, units of their separation and mean motion, with
mu the mass ratio and d1, d2 the distances from primary and secondary,

    x'' - 2 y' = x + 1 - mu - (1 - mu) (x + 1)/d1^3 - mu x/d2^3
    y'' + 2 x' = y - (1 - mu) y/d1^3 - mu y/d2^3
    z'' = -(1 - mu) z/d1^3 - mu z/d2^3

(Szebehely 1967, Theory of Orbits, Sec. 1.5, moved to the secondary). The coefficients follow from each other by the
rules for products and powers of series.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ThreeBodyPath"]

Array = NDArray[Any]

ORDER = 24

CAUTION = 0.7
"""The part of the length at which a series' last terms fall to a rounding; what is cut off is then negligible."""

LONGEST = 1.0
"""The most that a series is used for, radians of the attractors."""


class ThreeBodyPath:
    """Position and velocity at any phase of the attractors, of one body or of members; it grows as it is asked.

    Parameters
    ----------
    mass_ratio : scalar or array
    start : six scalars or arrays
        Position and velocity at the phase zero. Long doubles are kept.
    """

    def __init__(self, mass_ratio: Any, start: Any) -> None:
        self._given = mass_ratio, start
        numbers = np.broadcast_arrays(mass_ratio, *start)
        self._members = np.arange(numbers[0].size).reshape(numbers[0].shape)
        mu, *state = (np.ravel(number) for number in numbers)
        self._branches = [_Branch(np.asarray(mu), np.array(state), direction) for direction in (1, -1)]
        self._lock = threading.Lock()

    def __reduce__(self) -> Any:  # a copy grows anew
        return type(self), self._given

    def at(self, phase: Any) -> Array:
        """Return the six at phases, radians, that broadcast with the members; NaN beyond a collision."""
        member, phase = np.broadcast_arrays(self._members, phase)
        shape, member, phase = phase.shape, member.ravel(), phase.ravel()
        out = np.empty((6, phase.size), dtype=self._branches[0].state.dtype)
        with self._lock:
            for branch, chosen in zip(self._branches, (~(phase < 0), phase < 0), strict=True):
                if np.any(chosen):
                    out[:, chosen] = branch.at(member[chosen], phase[chosen])
        return out.reshape(6, *shape)


class _Branch:
    """The path forwards or backwards, by its series; each member has its own lengths of them."""

    def __init__(self, mass_ratio: Array, state: Array, direction: int) -> None:
        self.mass_ratio, self.state, self.direction = mass_ratio, state, direction
        self.ends = [np.zeros_like(state[0])]
        self.series: list[Array] = []
        self.collided = np.zeros(state.shape[1], dtype=bool)

    def at(self, member: NDArray[np.int_], phase: Array) -> Array:
        """Return the six of members at phases."""
        farthest = np.zeros_like(self.state[0])
        np.maximum.at(farthest, member, np.abs(phase))
        while not self.series or np.any((np.abs(self.ends[-1]) < farthest) & ~self.collided):
            self._step()
        out = np.full((6, phase.size), np.nan, dtype=self.state.dtype)
        for i, series in enumerate(self.series):
            begin, end = self.ends[i][member], self.ends[i + 1][member]
            chosen = (np.abs(begin) <= np.abs(phase)) & (np.abs(phase) <= np.abs(end))
            if np.any(chosen):
                out[:, chosen] = _sum(series[:, :, member[chosen]], (phase - begin)[chosen])
        return out

    def _step(self) -> None:
        with np.errstate(all="ignore"):
            series = _series(self.mass_ratio, self.state)
            lengths = self._lengths(series)
            end = self.ends[-1] + self.direction * lengths
            self.collided = self.collided | ~(np.abs(end) > np.abs(self.ends[-1]))
            end = np.where(self.collided, self.ends[-1], end)
            state = _sum(series, end - self.ends[-1])
        self.state = np.where(self.collided, self.state, state)
        self.ends.append(end)
        self.series.append(series)

    def _lengths(self, series: Array) -> Array:
        """Return how far each series holds to a rounding of the position, by its last two terms."""
        terms = np.max(np.abs(series[:, :3]), axis=1)
        enough = np.finfo(series.dtype).eps * terms[0]
        lengths = [CAUTION * (enough / terms[k]) ** (1 / k) for k in (ORDER - 1, ORDER)]
        return np.asarray(np.min([np.full_like(enough, LONGEST), *lengths], axis=0))


def _series(mass_ratio: Array, state: Array) -> Array:
    """Return the coefficients of the six, shape (ORDER + 1, 6, members)."""
    series = np.zeros((ORDER + 1, *state.shape), dtype=state.dtype)
    series[0] = state
    place = series[:, :3]
    weights = np.stack([1 - mass_ratio, mass_ratio])
    squares, cubes = np.empty((2, ORDER, *weights.shape), dtype=state.dtype)  # of the distances, and one over
    both = np.empty((ORDER, 1, *mass_ratio.shape), dtype=state.dtype)
    for k in range(ORDER):
        squares[k] = (place[: k + 1] * place[k::-1]).sum(axis=(0, 1))
        squares[k, 0] += 2 * place[k, 0] + (k == 0)
        cubes[k] = squares[0] ** -1.5 if k == 0 else _next_of_power(squares, cubes, k)
        pull = weights * cubes[k]
        both[k] = pull.sum(axis=0)
        x, y, _, u, v, _ = series[k]
        change = -(both[: k + 1] * place[k::-1]).sum(axis=0)
        change[0] += x + 2 * v + weights[0] * (k == 0) - pull[0]
        change[1] += y - 2 * u
        series[k + 1, :3], series[k + 1, 3:] = series[k, 3:] / (k + 1), change / (k + 1)
    return series


def _next_of_power(base: Array, power: Array, k: int) -> Array:
    """Return the k-th coefficient of base^(-3/2) from those before it."""
    j = np.arange(1, k + 1).reshape(-1, 1, 1)
    return np.asarray(((-0.5 * j - k) * base[1 : k + 1] * power[k - 1 :: -1]).sum(axis=0) / (k * base[0]))


def _sum(series: Array, length: Array) -> Array:
    total: Array = series[-1]
    for coefficient in series[-2::-1]:
        total = total * length + coefficient
    return total
