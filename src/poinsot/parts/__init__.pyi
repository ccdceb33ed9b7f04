"""The public names of poinsot.parts, by the module of each, as `make face` writes them."""

from .dampers import KaneDamper
from .rotors import Gyrostat, ReactionWheel
from .springs import SpringMass
from .tides import CreepingTide

__all__ = [
    "CreepingTide",
    "Gyrostat",
    "KaneDamper",
    "ReactionWheel",
    "SpringMass",
]
