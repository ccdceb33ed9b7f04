"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from ..shapes.scattering import (
    AshikhminShirley,
    CookTorrance,
    Hapke,
    HenyeyGreenstein,
    IsotropicPhase,
    Lambert,
    LambertLommelSeeliger,
    LommelSeeliger,
    LunarLambert,
    Minnaert,
    PhaseFunction,
    Phong,
    Reflection,
    ScatteringLaw,
)
from .direction_sensors import CoarseSunSensors, VectorSensor
from .doppler import DopplerBandwidth, DopplerEdges
from .light_curve import LightCurve
from .ranging import Range, RangeRate
from .readings import Readings
from .star_tracker import Exclusion, StarTracker
from .triaxial_sensors import Gyro, Magnetometer

__all__ = [
    "AshikhminShirley",
    "CoarseSunSensors",
    "CookTorrance",
    "DopplerBandwidth",
    "DopplerEdges",
    "Exclusion",
    "Gyro",
    "Hapke",
    "HenyeyGreenstein",
    "IsotropicPhase",
    "Lambert",
    "LambertLommelSeeliger",
    "LightCurve",
    "LommelSeeliger",
    "LunarLambert",
    "Magnetometer",
    "Minnaert",
    "PhaseFunction",
    "Phong",
    "Range",
    "RangeRate",
    "Readings",
    "Reflection",
    "ScatteringLaw",
    "StarTracker",
    "VectorSensor",
]
