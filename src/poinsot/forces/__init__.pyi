"""The public names of poinsot.forces, by the module of each, as `make face` writes them."""

from .atmosphere import Atmosphere, ExponentialAtmosphere
from .atmosphere_table import TabulatedAtmosphere
from .damping import LinearDamping
from .directional_torque import DirectionalTorque
from .drag import AtmosphericDrag, MeshDrag
from .ellipsoid import EllipsoidGravity
from .facets import Facets
from .gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from .magnetic_fields import IGRF, MagneticField, MagneticHarmonics, SecularHarmonics, TiltedDipole
from .magnetic_torques import BDot, EddyCurrents, MagneticMoment
from .mascons import MasconGravity
from .mutual_gravity import MutualGravity, MutualHarmonics
from .mutual_mascons import MutualMascons
from .radiation import Occulter, RadiationPressure
from .sunlight import MeshRadiation, Yorp
from .third_body import ThirdBody
from .tides import LibrationDamping, TidalFriction, TidalTorque, pseudo_synchronous_rate

__all__ = [  # noqa: RUF022
    "Atmosphere",
    "AtmosphericDrag",
    "BDot",
    "DirectionalTorque",
    "EddyCurrents",
    "EllipsoidGravity",
    "ExponentialAtmosphere",
    "Facets",
    "GravityGradient",
    "HarmonicGravity",
    "IGRF",
    "LibrationDamping",
    "LinearDamping",
    "MagneticField",
    "MagneticHarmonics",
    "MagneticMoment",
    "MasconGravity",
    "MeshDrag",
    "MeshRadiation",
    "MutualGravity",
    "MutualHarmonics",
    "MutualMascons",
    "Oblateness",
    "Occulter",
    "RadiationPressure",
    "SecularHarmonics",
    "TabulatedAtmosphere",
    "ThirdBody",
    "TidalFriction",
    "TidalTorque",
    "TiltedDipole",
    "UniformGravity",
    "Yorp",
    "pseudo_synchronous_rate",
]
