"""Integrations on heyoka's engines from sample to sample: between two of them nothing jumps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.engine.integration import Integration, Stepper
from poinsot.engine.jumps import Clock, Updates
from poinsot.engine.termination import INTERRUPTED

__all__ = ["SampledIntegration"]

Array = NDArray[Any]


class SampledIntegration(Integration):
    """Members in the lanes of an engine, forwards, with jumps at their samples.

    Parameters
    ----------
    stepper, members, starts, origins, grids
        As of `Integration`.
    clock : Clock
    updates : Updates

    Attributes
    ----------
    states : array (count, size)
        The variables where the last leg ended, behind its jump.
    """

    def __init__(
        self,
        stepper: Stepper,
        members: NDArray[np.int_],
        starts: Array,
        origins: Array,
        grids: list[Array],
        clock: Clock,
        updates: Updates,
    ) -> None:
        super().__init__(stepper, members, starts, origins, grids, forwards=True)
        self._clock, self._updates, self.states = clock, updates, starts.copy()
        self._numbers, self._ahead = clock.first(origins, members), list(grids)
        self._rows = [[] for _ in members]
        self._leg: Integration | None = None

    @override
    def chunks(self) -> Iterator[None]:
        """Integrate every lane over its grid; yield after each chunk of steps."""
        while INTERRUPTED not in self.failed:
            for lane in self._under_way():
                self._jump(lane)
            if not (lanes := self._under_way()):
                return
            grids = [self._to_next_sample(lane) for lane in lanes]
            given = self.members[lanes], self.states[lanes], self.reached[lanes], grids
            self._leg = Integration(self._stepper, *given, forwards=True)
            yield from self._leg.chunks()
            self._take(self._leg, lanes, grids)

    def _jump(self, lane: int) -> None:
        """Give the variables of a lane at a sample their new values, and keep what is asked for there."""
        member = self.members[lane]
        for j, time in enumerate(self._clock.times(self._numbers[lane], member)):
            if time == self.reached[lane]:
                self.states[lane] = self._updates(j, self.states[lane], time, self._numbers[lane, j], member)
                self._numbers[lane, j] += 1
        if self._ahead[lane][:1] == self.reached[lane]:
            self._rows[lane].append(self.states[lane : lane + 1].astype(float))
            self._ahead[lane] = self._ahead[lane][1:]

    def _to_next_sample(self, lane: int) -> Array:
        """Return the times up to the next sample, or to the end if that is before."""
        until = min(float(self._clock.times(self._numbers[lane], self.members[lane]).min()), float(self.lasts[lane]))
        ahead = self._ahead[lane]
        return np.append(ahead[ahead < until], until)

    def _samples_around(self, lane: int) -> tuple[float, float]:
        """Return the times of the last sample of a lane that is done and of the next one."""
        done, ahead = (self._clock.times(self._numbers[lane] - back, self.members[lane]) for back in (1, 0))
        return float(done.max()), float(ahead.min())

    def _take(self, leg: Integration, lanes: list[int], grids: list[Array]) -> None:
        """Keep what a leg has brought."""
        self.cause = self.cause or leg.cause
        for k, (lane, grid) in enumerate(zip(lanes, grids, strict=True)):
            rows = leg.rows(k)
            self.steps[lane] += leg.steps[k]
            self.events[lane] += leg.events[k]
            since, until = self._samples_around(lane)
            self.actions[lane] += [each._replace(since=since, until=until) for each in leg.actions[k]]
            self.failed[lane], self.reached[lane] = self.failed[lane] or leg.failed[k], leg.reached[k]
            there = len(rows) == grid.size
            self._rows[lane].append(rows[: grid.size - 1])
            self._ahead[lane] = self._ahead[lane][grid.size - 1 :] if there else self._ahead[lane][:0]
            if there:
                self.states[lane], self.reached[lane] = rows[-1], grid[-1]

    @override
    def take_events(self) -> None:
        """Keep what happened in the last steps."""
        if self._leg is not None:
            self._leg.take_events()
