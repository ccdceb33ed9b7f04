"""Why an integration stops before its end."""

from __future__ import annotations

import numpy as np

__all__ = ["INTERRUPTED", "LONGEST", "TRIES", "reason"]

INTERRUPTED = "it was interrupted."

REASONS = {
    "err_nf_state": "the state became non-finite. A force is singular there.",
    "haste": "an event acts again and again without end. Let it act less often, or make it terminal.",
    "switch": "the branches of a `where` lead back to its switch from both sides. Make the formula smooth there.",
    "angles": ("sin(theta) fell below 1e-6. The Euler angles 3-1-3 are singular there; use another formulation."),
}

HOPELESS = 1e9
"""Chunks of steps that a run may have ahead of it; at a microsecond a step, so many take most of a year."""


LONGEST = 2.0**46
"""The longest step in double precision: of Taylor coefficients that underflow none is missed in it."""


TRIES = 4
"""How often a chunk of steps is taken again for a zero that was lost; a function that still has none jumped over it."""


def reason(outcome: str, advance: float, reached: float, ahead: float, steps: int) -> str:
    """Return why the integration cannot go on; empty if it can, or is at its end.

    `outcome` says how a chunk of steps ended, by a name or in a sentence of its own; `advance` is the time that it
    covered, `ahead` what is left.
    """
    if outcome in ("time_limit", "event", "act", "held", "success"):
        return ""
    if outcome == "step_limit":
        if advance <= steps * np.spacing(abs(reached)):
            return "the step size fell to rounding. The equations are singular there."
        if ahead > HOPELESS * advance:
            slow = advance > 0.5 * steps * LONGEST
            why = "Count in a longer unit of time" if slow else "The body turns too fast"
            return f"the steps became so short, {advance / steps:.1g}, that it would not end. {why}."
        return ""
    return REASONS.get(outcome, outcome)
