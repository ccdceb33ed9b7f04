"""The public names of poinsot.control, by the module of each, as `make face` writes them."""

from .feedback import OrbitPointing, QuaternionFeedback, RateDamping
from .sampled import Sampled
from .sensors import NoisySensors, Sensors

__all__ = [
    "NoisySensors",
    "OrbitPointing",
    "QuaternionFeedback",
    "RateDamping",
    "Sampled",
    "Sensors",
]
