"""The public names of poinsot.mechanics, by the module of each, as `make face` writes them."""

from ..kinematics.frame import Frame
from ..kinematics.state import project_to_tangent
from ..records.parameters import Vector
from .environment import Environment
from .force import Load, PairLoad
from .pair_instant import PairInstant
from .part import Jump

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
