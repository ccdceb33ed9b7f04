"""Why an integration stops before its end."""

from __future__ import annotations

import numpy as np

__all__ = ["INTERRUPTED", "reason"]

INTERRUPTED = "it was interrupted."


def reason(outcome: str, advance: float, reached: float, steps: int) -> str:
    """Return why the integration cannot go on; empty if it can, or is at its end.

    `outcome` says how a chunk of steps ended, `advance` is the time it covered.
    """
    if outcome == "time_limit":
        return ""
    if outcome == "step_limit":
        stuck = advance <= steps * np.spacing(abs(reached))
        return "the step size fell to rounding. The equations are singular there." if stuck else ""
    if outcome == "err_nf_state":
        return "the state became non-finite. A force is singular there."
    if outcome == "switch":
        return "the branches of a `where` lead back to its switch from both sides. Make the formula smooth there."
    return "sin(theta) fell below 1e-6. The Euler angles 3-1-3 are singular there; use another formulation."
