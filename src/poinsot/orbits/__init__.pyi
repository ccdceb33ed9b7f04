"""The public names of poinsot.orbits, by the module of each, as `make face` writes them."""

from .ephemeris import Ephemeris
from .escape import EscapeBlock, EscapeOrbit
from .fixed import FixedPosition
from .kepler import EccentricBlock, EllipticBlock, KeplerBlock, KeplerOrbit, LongEllipticBlock
from .lagrange import LagrangePointPath, RotatingPosition
from .planets import planet_orbit
from .precessing import LongPrecessingBlock, PrecessingBlock, PrecessingOrbit
from .restricted_three_body import SynodicBlock, ThreeBodyPath
from .sums import orbit_sum
from .two_body import two_body_orbit

__all__ = [
    "EccentricBlock",
    "EllipticBlock",
    "Ephemeris",
    "EscapeBlock",
    "EscapeOrbit",
    "FixedPosition",
    "KeplerBlock",
    "KeplerOrbit",
    "LagrangePointPath",
    "LongEllipticBlock",
    "LongPrecessingBlock",
    "PrecessingBlock",
    "PrecessingOrbit",
    "RotatingPosition",
    "SynodicBlock",
    "ThreeBodyPath",
    "orbit_sum",
    "planet_orbit",
    "two_body_orbit",
]
