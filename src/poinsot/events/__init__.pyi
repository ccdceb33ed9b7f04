"""The public names of poinsot.events, by the module of each, as `make face` writes them."""

from .impact import Impact
from .pair_events import Contact, DistanceCrossing, LibrationExtreme, PairApsis
from .standard_events import AndoyerCrossing, Apsis, AtTime, AttractorCrossing, AxisCrossing, RateCrossing, SpinFlip

__all__ = [
    "AndoyerCrossing",
    "Apsis",
    "AtTime",
    "AttractorCrossing",
    "AxisCrossing",
    "Contact",
    "DistanceCrossing",
    "Impact",
    "LibrationExtreme",
    "PairApsis",
    "RateCrossing",
    "SpinFlip",
]
