"""Events that `propagate` finds on the way, by the module of each; imported when they are used first."""

from .standard_events import AndoyerCrossing, Apsis, AtTime, AttractorCrossing, AxisCrossing, RateCrossing, SpinFlip

__all__ = [
    "AndoyerCrossing",
    "Apsis",
    "AtTime",
    "AttractorCrossing",
    "AxisCrossing",
    "RateCrossing",
    "SpinFlip",
]
