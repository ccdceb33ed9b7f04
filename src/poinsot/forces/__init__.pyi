"""Forces: potentials and torques, by the module of each; imported when they are used first."""

from .damping import LinearDamping
from .ellipsoid import EllipsoidGravity
from .gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from .mascons import MasconGravity

__all__ = [
    "EllipsoidGravity",
    "GravityGradient",
    "HarmonicGravity",
    "LinearDamping",
    "MasconGravity",
    "Oblateness",
    "UniformGravity",
]
