"""The public names of poinsot.forces, by the module of each, as `make face` writes them."""

from .damping import LinearDamping
from .ellipsoid import EllipsoidGravity
from .gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from .mascons import MasconGravity
from .mutual_gravity import MutualGravity, MutualHarmonics
from .mutual_mascons import MutualMascons
from .third_body import ThirdBody
from .tides import LibrationDamping, TidalFriction, TidalTorque, pseudo_synchronous_rate

__all__ = [
    "EllipsoidGravity",
    "GravityGradient",
    "HarmonicGravity",
    "LibrationDamping",
    "LinearDamping",
    "MasconGravity",
    "MutualGravity",
    "MutualHarmonics",
    "MutualMascons",
    "Oblateness",
    "ThirdBody",
    "TidalFriction",
    "TidalTorque",
    "UniformGravity",
    "pseudo_synchronous_rate",
]
