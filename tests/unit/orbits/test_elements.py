"""Osculating elements of a position and a velocity, against the elements of orbits."""

import numpy as np
import pytest

import poinsot as pt

ORBIT = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.7,
    eccentricity=0.3,
    inclination=0.4,
    node=2.9,
    argument_of_periapsis=1.1,
    true_anomaly=0.6,
)


def vectors(orbit, time):
    return {"position": orbit.position_at(time), "velocity": orbit.velocity_at(time)}


def test_elements_of_an_ellipse():
    found = pt.orbits.osculating_elements(2.0, **vectors(ORBIT, 0.0))
    for name in ("semimajor_axis", "eccentricity", "inclination", "node", "argument_of_periapsis", "true_anomaly"):
        wanted = getattr(ORBIT, name, 1.7)
        np.testing.assert_allclose(getattr(found, name), wanted, rtol=1.3e-14)
    np.testing.assert_allclose(found.period, 2 * np.pi * np.sqrt(1.7**3 / 2.0), rtol=1e-14)
    np.testing.assert_allclose(found.longitude_of_periapsis, 2.9 + 1.1 - 2 * np.pi, rtol=1.3e-14)


def test_hyperbola_has_no_period():
    found = pt.orbits.osculating_elements(1.0, position=(1, 0, 0), velocity=(0, 2.0, 0))
    assert found.semimajor_axis == pytest.approx(-0.5, rel=1e-15, abs=0)
    assert np.isnan(found.period)
