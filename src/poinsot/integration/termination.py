"""Reasons why an integration stops before its end, and interruption by Ctrl-C."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # `signal` makes members of enumerations, in the time of a short run

import numpy as np

from poinsot.taylor.queue import LONGEST_STEP

__all__ = ["INTERRUPTED", "REASONS", "HeldInterrupts", "reason", "reason_of_speed"]

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
