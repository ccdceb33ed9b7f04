"""The public names of poinsot.parts, by the module of each, as `make face` writes them."""

from .dampers import KaneDamper
from .gyros import ControlMomentGyro, GimballedRotor
from .pendulums import SloshPendulum
from .prescribed_motion import MovingMasses, VaryingInertia
from .rotors import Gyrostat, MomentumWheel, ReactionWheel
from .springs import SpringMass
from .tides import CreepingTide
from .wheels import ReactionWheels

__all__ = [
    "ControlMomentGyro",
    "CreepingTide",
    "GimballedRotor",
    "Gyrostat",
    "KaneDamper",
    "MomentumWheel",
    "MovingMasses",
    "ReactionWheel",
    "ReactionWheels",
    "SloshPendulum",
    "SpringMass",
    "VaryingInertia",
]
