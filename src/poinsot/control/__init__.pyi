"""The public names of poinsot.control, by the module of each, as `make face` writes them."""

from .feedback import OrbitPointing, QuaternionFeedback, RateDamping
from .sampled import Sampled

__all__ = [
    "OrbitPointing",
    "QuaternionFeedback",
    "RateDamping",
    "Sampled",
]
