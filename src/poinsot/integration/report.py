"""Report of a run: steps, events, and why motions stopped before their end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.integration.termination import INTERRUPTED

if TYPE_CHECKING:
    from poinsot.integration.dense_motion import DenseOutput

__all__ = ["Recorded", "Report", "Stop"]


class Recorded(NamedTuple):
    """Occurrence of an event: its number, its time, the sign of its rate, and the variables."""

    number: int
    time: float
    direction: int
    row: NDArray[np.float64]


class Stop(NamedTuple):
    """Reason why a motion stopped before its end, the time reached, and the time requested."""

    why: str
    time: float
    last: float
    cause: BaseException | None

    @property
    def sentence(self) -> str:
        """Error message."""
        return f"propagation stopped at t = {self.time:.10g} of {self.last:.10g}: {self.why}"


@dataclass
class Report:
    """Record of a run.

    Attributes
    ----------
    steps : array (members,)
        Number of steps.
    stops : dict
        Member -> reason and time of its stop.
    events : list
        Pairs of a member and the record of an event.
    finished : int
        Number of finished members. After an interruption, the other members have no rows.
    order, tolerance
        Order and tolerance of the Taylor polynomials.
    wall_time : float
        Duration in seconds; for one body without the compilation of the kernel.
    kernel : str
        "looped" on a processor, "cuda" on a GPU.
    lanes : int
        Members in a vector.
    interrupted : bool
    dense : DenseOutput or None
    """

    steps: NDArray[np.int_]
    stops: dict[int, Stop] = field(default_factory=dict)
    events: list[tuple[int, Recorded]] = field(default_factory=list)
    finished: int = 0
    order: int = 0
    tolerance: float = 0.0
    wall_time: float = 0.0
    kernel: str = "looped"
    lanes: int = 1
    interrupted: bool = False
    dense: DenseOutput | None = None

    @property
    def failures(self) -> dict[int, str]:
        """Error message of each member that failed."""
        return {member: stop.sentence for member, stop in sorted(self.stops.items())}

    @property
    def totals(self) -> tuple[float, int, int, float, str, int]:
        """Tolerance, order, steps of all members together, wall time, kernel and lanes."""
        return self.tolerance, self.order, sum(self.steps.tolist()), self.wall_time, self.kernel, self.lanes

    def check(self, what: str, last: float, result: object) -> None:
        """Raise a PropagationInterrupted with the result of the finished members after an interruption."""
        if self.interrupted:
            message = f"{what} was interrupted: {self.finished} of {len(self.steps)} members are done."
            raise PropagationInterrupted(message, last, result)

    def check_one(self, last: float, result: object) -> None:
        """Raise the reason why one body stopped, if it did, with the result up to that time."""
        at_end = [Stop(INTERRUPTED, last, last, None)] if self.interrupted else []
        stops: Sequence[Stop] = [*self.stops.values(), *at_end]
        for stop in stops:
            kind = PropagationInterrupted if stop.why == INTERRUPTED else PropagationError
            raise kind(stop.sentence, stop.time, result) from stop.cause

    def put(self, members: NDArray[np.int_], found: Report) -> None:
        """Insert the report of some of the members."""
        self.steps[members], self.finished = found.steps, self.finished + found.finished
        self.stops |= {int(members[i]): stop for i, stop in found.stops.items()}
        self.wall_time, self.interrupted = self.wall_time + found.wall_time, found.interrupted
        self.kernel, self.lanes, self.order, self.tolerance = found.kernel, found.lanes, found.order, found.tolerance

    def add(self, later: Report) -> None:
        """Add the report of a later part of the same motions; the first stop of a member stays."""
        self.steps, self.wall_time = self.steps + later.steps, self.wall_time + later.wall_time
        self.kernel, self.lanes = later.kernel, later.lanes
        self.order, self.tolerance, self.stops = later.order, later.tolerance, later.stops | self.stops
