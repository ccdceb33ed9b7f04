"""Where a 12U CubeSat points, and which torque disturbs it: two orbits from a two-line element set, to the last effect.

Gravity, air that turns with the Earth, sunlight with the Earth's shadow, and a residual magnetic moment in the IGRF
disturb it; four wheels in a pyramid, driven by proportional and derivative feedback, hold it to the axes of the orbit.
The satellite and its elements are made up, of ordinary size; kg m^2, m, s. The orbit is SGP4's, along the axes of the
ICRF, Sun and Earth those of VSOP2013. The pictures show the torques, the pointing error and the speeds of the wheels, and
what each effect alone does to the pointing.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt
from poinsot.files import tle_orbit
from poinsot.forces import IGRF, AtmosphericDrag, ExponentialAtmosphere, Facets, MagneticMoment, Occulter
from poinsot.forces import RadiationPressure

ELEMENTS = (
    "1 99999U 26001A   26079.50000000  .00002000  00000-0  10000-3 0  9996",
    "2 99999  97.4000 130.0000 0012000  80.0000 280.0000 15.21900000    10",
)
ORBIT = 86400 / 15.219
DAY = (0.0, 2.2 * ORBIT)

orbit = pt.orbits.in_metres(tle_orbit(ELEMENTS, *DAY, reference_frame="ICRF"))
calendar = orbit.calendar
