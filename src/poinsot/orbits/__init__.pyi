"""The public names of poinsot.orbits, by the module of each, as `make face` writes them."""

from .elements import OsculatingElements, osculating_elements
from .ephemeris import Ephemeris, in_metres
from .escape import EscapeOrbit
from .fixed import FixedPosition
from .kepler import KeplerOrbit
from .lagrange import LagrangePointPath, RotatingPosition
from .planets import planet_orbit
from .precessing import PrecessingOrbit
from .restricted_three_body import ThreeBodyPath
from .rotation import NutatingRotation, RotationModel
from .sums import orbit_sum
from .two_body import two_body_orbit

__all__ = [
    "Ephemeris",
    "EscapeOrbit",
    "FixedPosition",
    "KeplerOrbit",
    "LagrangePointPath",
    "NutatingRotation",
    "OsculatingElements",
    "PrecessingOrbit",
    "RotatingPosition",
    "RotationModel",
    "ThreeBodyPath",
    "in_metres",
    "orbit_sum",
    "osculating_elements",
    "planet_orbit",
    "two_body_orbit",
]
