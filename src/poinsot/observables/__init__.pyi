"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from ..shapes.scattering import (
    AshikhminShirley,
    CookTorrance,
    Hapke,
    Lambert,
    LambertLommelSeeliger,
    LommelSeeliger,
    LunarLambert,
    Minnaert,
    Phong,
    Reflection,
    ScatteringLaw,
)
from .direction_sensors import CoarseSunSensors, VectorSensor
from .readings import Readings
from .star_tracker import Exclusion, StarTracker
from .triaxial_sensors import Gyro, Magnetometer

__all__ = [
    "AshikhminShirley",
    "CoarseSunSensors",
    "CookTorrance",
    "Exclusion",
    "Gyro",
    "Hapke",
    "Lambert",
    "LambertLommelSeeliger",
    "LommelSeeliger",
    "LunarLambert",
    "Magnetometer",
    "Minnaert",
    "Phong",
    "Readings",
    "Reflection",
    "ScatteringLaw",
    "StarTracker",
    "VectorSensor",
]
