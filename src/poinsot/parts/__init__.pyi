"""Parts: what moves inside a body or on it, by the module of each; imported when they are used first."""

from .dampers import KaneDamper
from .rotors import Gyrostat, ReactionWheel
from .springs import SpringMass

__all__ = [
    "Gyrostat",
    "KaneDamper",
    "ReactionWheel",
    "SpringMass",
]
