"""Every orbit that is shipped."""

import numpy as np

import poinsot as pt
from poinsot.orbits.ephemeris import PolynomialArc

ANGLES = {"inclination": 0.7, "node": -0.4, "argument_of_periapsis": 1.9, "epoch": 0.2}
ELLIPSE = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.3, true_anomaly=0.3, **ANGLES)
PATH = pt.orbits.ThreeBodyPath(
    3.1, 0.4, separation=2.5, position=(1.9, 0.7, 0.3), velocity=(-0.2, 0.1, 0.15), epoch=0.7
)


def along(times):
    """A helix that widens."""
    t = np.asarray(times)
    return np.stack([(1 + 0.1 * t) * np.cos(t), (1 + 0.1 * t) * np.sin(t), 0.3 + 0.2 * t], axis=-1)


ORBITS = {
    "circle": pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.0, true_anomaly=0.3, **ANGLES),
    "ellipse": ELLIPSE,
    "long ellipse": pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.8, true_anomaly=2.0, **ANGLES),
    "precessing ellipse": pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=-0.03, periapsis_rate=0.07, anomaly_rate=0.01),
    "parabola": pt.orbits.EscapeOrbit(
        1.1, periapsis_distance=0.9, eccentricity=1.0, time_since_periapsis=-1.0, **ANGLES
    ),
    "hyperbola": pt.orbits.EscapeOrbit(
        1.1, periapsis_distance=0.9, eccentricity=1.7, time_since_periapsis=0.5, **ANGLES
    ),
    "at rest": pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7)),
    "turning": pt.orbits.RotatingPosition(0.9, position=(0.8, -0.5, 0.7), rate=0.6, epoch=0.2),
    "table": pt.orbits.Ephemeris.from_function(2.0, position=along, start=-1.0, stop=3.0),
    "piece of a table": PolynomialArc(
        2.0, terms=3, middle=1.0, half_length=2.0, coefficients=[(1.0, 0.3, -0.1), (0.2, 0.5, 0.2), (0.4, -0.2, 0.3)]
    ),
    "from a ground station": pt.orbits.GroundStation(
        ELLIPSE,
        pt.orbits.RotationModel(0.3, 1.1, 0.7, rate=0.9, right_ascension_rate=0.02),
        latitude=0.6,
        longitude=-1.1,
        height=0.01,
        equatorial_radius=0.2,
        flattening=0.1,
    ),
    "near two attractors, from the larger": PATH.from_primary,
    "near two attractors, from the smaller": PATH.from_secondary,
}
