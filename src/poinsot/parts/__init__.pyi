"""The public names of poinsot.parts, by the module of each, as `make face` writes them."""

from .dampers import KaneDamper
from .rotors import Gyrostat, ReactionWheel
from .springs import SpringMass

__all__ = [
    "Gyrostat",
    "KaneDamper",
    "ReactionWheel",
    "SpringMass",
]
