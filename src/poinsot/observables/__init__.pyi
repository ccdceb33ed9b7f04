"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from .direction_sensors import CoarseSunSensors, VectorSensor
from .readings import Readings
from .star_tracker import Exclusion, StarTracker
from .triaxial_sensors import Gyro, Magnetometer

__all__ = [
    "CoarseSunSensors",
    "Exclusion",
    "Gyro",
    "Magnetometer",
    "Readings",
    "StarTracker",
    "VectorSensor",
]
