"""The public names of poinsot.orbits, by the module of each, as `make face` writes them."""

from .composite import composite_orbit
from .elements import OsculatingElements, osculating_elements
from .ephemeris import Ephemeris, kilometres_to_metres
from .escape import EscapeOrbit
from .fixed import FixedPosition
from .ground_station import GroundStation
from .kepler import KeplerOrbit
from .lagrange import LagrangePointPath, RotatingPosition
from .planets import planet_orbit
from .precessing import PrecessingOrbit
from .restricted_three_body import ThreeBodyPath
from .rotation import NutatingRotation, RotationModel
from .two_body import two_body_orbit

__all__ = [
    "Ephemeris",
    "EscapeOrbit",
    "FixedPosition",
    "GroundStation",
    "KeplerOrbit",
    "LagrangePointPath",
    "NutatingRotation",
    "OsculatingElements",
    "PrecessingOrbit",
    "RotatingPosition",
    "RotationModel",
    "ThreeBodyPath",
    "composite_orbit",
    "kilometres_to_metres",
    "osculating_elements",
    "planet_orbit",
    "two_body_orbit",
]
