"""The public names of poinsot.mechanics, by the module of each, as `make face` writes them."""

from .environment import Environment
from .force import Load, PairLoad
from .frame import Frame
from .pair_instant import PairInstant
from .parameters import Vector
from .part import Jump
from .state import project_to_tangent

__all__ = [
    "Environment",
    "Frame",
    "Jump",
    "Load",
    "PairInstant",
    "PairLoad",
    "Vector",
    "project_to_tangent",
]
