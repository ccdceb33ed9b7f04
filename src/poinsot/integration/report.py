"""Report of a run: steps, events, reasons why motions stopped before their end, and interruption by Ctrl-C."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # `signal` makes members of enumerations, in the time of a short run
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.taylor.queue import LONGEST_STEP

if TYPE_CHECKING:
    from poinsot.integration.rows import DenseOutput

__all__ = ["INTERRUPTED", "REASONS", "HeldInterrupts", "Recorded", "Report", "Stop", "reason", "reason_of_speed"]

INTERRUPTED = "it was interrupted."

REASONS = {
    "rounding": "the step size fell to rounding. The equations are singular there.",
    "not_finite": "the state became non-finite. A force is singular there.",
    "zeno": "an event acts again and again without end. Let it act less often, or make it terminal.",
    "switch": "the branches of a `where` lead back to its switch from both sides. Make the formula smooth there.",
    "angles": ("sin(theta) fell below 1e-6. The Euler angles 3-1-3 are singular there; use another formulation."),
}

MAX_CHUNKS_AHEAD = 1e9
"""Largest number of chunks of steps ahead of a run; at a microsecond per step they take most of a year."""


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


def reason(advance: float, reached: float, ahead: float, steps: int) -> str:
    """Return the reason why the integration cannot go on; empty if it can.

    The last steps covered the time `advance` up to the time `reached`; the time `ahead` is left.
    """
    if advance <= steps * np.spacing(abs(reached)):
        return REASONS["rounding"]
    if ahead > MAX_CHUNKS_AHEAD * advance:
        slow = advance > 0.5 * steps * LONGEST_STEP
        why = "Count in a longer unit of time" if slow else "The body turns too fast"
        return f"the steps became so short, {advance / steps:.1g}, that it would not end. {why}."
    return ""


def reason_of_speed(why: str, speed: float, power: int) -> str:
    """Return the reason of a stop, or the angular velocity as the reason if a power of it overflows."""
    if why != REASONS["not_finite"] or speed <= float(np.finfo(float).max) ** (1 / power):
        return why
    rate = f"the body turns so fast, {speed:.1g}, that powers of its rate overflow."
    return f"the state became non-finite: {rate} Count in a shorter unit of time."


class HeldInterrupts:
    """Context in which Ctrl-C stops a run after its current steps and raises nothing, so that results stay complete.

    Ctrl-C again raises at once, since the run may not come to an end by itself. In another thread than the main one,
    or where the program handles Ctrl-C itself, Ctrl-C raises at once, too.

    Attributes
    ----------
    stop : bool
        True if the run is to stop after the current steps, with the rows computed so far.
    heard : bool
        True if the reason is Ctrl-C.
    """

    def __init__(self) -> None:
        self.stop = self.heard = False

    def interrupt(self) -> None:
        """Stop the run because of Ctrl-C."""
        self.stop = self.heard = True

    def __enter__(self) -> None:
        self._holds = _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler
        if self._holds:
            try:
                _signal.signal(_signal.SIGINT, self._hear)
            except ValueError:  # in another thread than the main one
                self._holds = False

    def _hear(self, *_: object) -> None:
        _signal.signal(_signal.SIGINT, _signal.default_int_handler)
        self.interrupt()

    def __exit__(self, *_: object) -> None:
        if self._holds:
            _signal.signal(_signal.SIGINT, _signal.default_int_handler)
