"""Every instrument that is shipped, with numbers that are not zero, and a motion on which each has readings."""

import numpy as np

import poinsot as pt
from poinsot.observables import (
    CoarseSunSensors,
    DopplerBandwidth,
    DopplerEdges,
    Exclusion,
    Gyro,
    HenyeyGreenstein,
    Lambert,
    LightCurve,
    LommelSeeliger,
    Magnetometer,
    Range,
    RangeRate,
    StarTracker,
    VectorSensor,
)

BODY = pt.Body((1.25, 1.0, 0.75))
ORBIT = pt.KeplerOrbit(398600.4418, semimajor_axis=8000.0, eccentricity=0.1, inclination=0.7, node=0.3)
SUN = pt.orbits.FixedPosition(1.327e11, position=(-1.2e8, 0.8e8, 0.3e8))
"""Units: km, s."""
EARTH = pt.orbits.RotationModel(0.0, 1.3, 0.4, rate=7.292115e-5)
FIELD = pt.forces.TiltedDipole(ORBIT, EARTH, -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2)
SHADOW = pt.forces.Occulter(ORBIT, 6378.137)
STATION = pt.orbits.GroundStation(
    ORBIT, EARTH, latitude=0.4, longitude=0.2, height=0.3, minimum_elevation=-1.5, equatorial_radius=6378.137
)
FAR = pt.orbits.FixedPosition(1.0, position=(3e5, -1e5, 2e5))
ELLIPSOID = pt.shapes.Ellipsoid((3e-3, 2e-3, 1e-3), mass=1.0)
BOX = pt.shapes.Mesh.from_box((3e-3, 2e-3, 1e-3), mass=1.0)
NORMALS = [(0.6, 0.0, 0.8), (-0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (0.0, -0.6, -0.8)]
ERRORS = {"scale": (1e-2, -2e-2, 5e-3), "alignment": (0.3, -0.2, 0.1)}

OBSERVABLES = {
    "gyro": Gyro(bias=(0.01, -0.02, 0.03), **ERRORS, noise=1e-3),
    "magnetometer": Magnetometer(FIELD, bias=(1e-6, -2e-6, 3e-6), **ERRORS, noise=1e-7),
    "star tracker": StarTracker(
        mounting=(0.5, -0.5, 0.1, 0.7),
        exclusions=(Exclusion(SUN, 0.1), Exclusion(ORBIT, 0.1, radius=100.0)),
        noise=1e-4,
    ),
    "sun sensor": VectorSensor(SUN, boresight=(1, 2, 3), field_of_view=3.0, occulters=(SHADOW,), bias=(1e-3, 0, -1e-3)),
    "direction of a field": VectorSensor(FIELD, bias=(1e-3, 2e-3, -1e-3), noise=0.01),
    "coarse sun sensors": CoarseSunSensors(
        SUN, NORMALS, gain=(1.0, 2.0, 0.5, 1.5), occulters=(SHADOW,), sun_radius=6.957e5, noise=0.01
    ),
    "bandwidth": DopplerBandwidth(ELLIPSOID, STATION, 1.3e-4, noise=0.1),
    "edges": DopplerEdges(BOX, STATION, 1.3e-4, light_time=False, noise=0.1),
    "light curve of a mesh": LightCurve(BOX, Lambert(0.3), SUN, STATION, kind="relative", light_time=False, noise=1e-3),
    "light curve of an ellipsoid": LightCurve(
        ELLIPSOID, LommelSeeliger(0.2, HenyeyGreenstein(-0.3)), SUN, FAR, kind="magnitude", noise=0.01
    ),
    "range": Range(STATION, (1e-3, 2e-3, -1e-3), noise=1e-5),
    "range rate": RangeRate(STATION, (1e-3, 2e-3, -1e-3), light_time=False, noise=1e-6),
}

TIMES = np.array([0.0, 0.4, 1.1, 2.0])
SYSTEM = pt.System(BODY, units={"time": "s", "inertia": "kg km2"})
START = BODY.state((0.5, -0.5, 0.1, 0.7), omega_body=(0.2, 1.1, -0.4))
