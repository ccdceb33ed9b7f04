"""Calls that a user's type checker must accept: fields take a number, or an array of one for each member."""

import numpy as np

import poinsot as pt

TWO = np.array([1.0, 2.0])


def orbits_of_members() -> list[pt.Orbit]:
    """Return orbits of two members each."""
    ellipse = pt.KeplerOrbit(mu=1.0, semimajor_axis=TWO, eccentricity=0.1 * TWO, inclination=0.2 * TWO, epoch=TWO)
    return [
        ellipse,
        pt.KeplerOrbit.from_elements(TWO, semimajor_axis=1.0, eccentricity=0.1, mean_anomaly=TWO),
        pt.orbits.EscapeOrbit(1.0, periapsis_distance=TWO, eccentricity=1.5, time_since_periapsis=TWO),
        pt.orbits.PrecessingOrbit(ellipse, node_rate=0.1 * TWO),
        pt.orbits.RotatingPosition(1.0, position=(1, 0, 0), rate=TWO),
        pt.orbits.ThreeBodyPath(1.0, 0.1, separation=TWO, position=(0.3, 0.2, 0), velocity=(0, 0, 0)).from_primary,
    ]


def forces_of_members() -> list[pt.Potential | pt.Torque]:
    """Return forces of two members each."""
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    plate = pt.forces.Facets([1.0], [(0, 0, 1)], [(0.1, 0, 0)])
    return [
        pt.UniformGravity(TWO, (1, 0, 0)),
        pt.forces.LinearDamping(TWO),
        pt.forces.RadiationPressure(orbit, plate, pressure=TWO, distance=1.0, sun_radius=0.1),
        pt.forces.Oblateness(orbit, j2=TWO, equatorial_radius=0.1, pole=(0, 0, 1)),
    ]
