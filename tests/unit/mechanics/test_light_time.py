"""Tests of the light time: published equation on straight lines, units, members."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.mechanics.light_time import emission_time, speed_of_light
from poinsot.records.units import DerivedUnits


class Line(pt.Orbit):
    mu: float
    start: pt.SpaceVector
    speed: pt.SpaceVector

    def position_at(self, time):
        return pt.functions.Vector(self.start[i] + self.speed[i] * time for i in range(3))

    def velocity_at(self, time):
        return pt.functions.Vector(self.speed[i] + 0 * time for i in range(3))


CASES = [
    ((223710318.6, 22588004.7, -32500917.9), (-17.278, 60.022, -63.888), 242.19534142061718),
    ((33987190.1, 175668528.0, 126226425.3), (-44.0, -39.56, -18.241), 269.6402894868475),
    ((-23089495.4, -220920810.9, 13755012.6), (23.572, -6.574, 60.0), 257.64770412823486),
]
"""Position in km at time 0, velocity in km/s, time of emission for the time 1000 s; computed with 50 digits."""


@pytest.mark.parametrize(("start", "speed", "expected"), CASES)
def test_straight_lines(start, speed, expected):
    found = emission_time(Line(1.0, start, speed), np.array([1000.0]), 299792.458)
    assert np.allclose(found, expected, rtol=0, atol=4 * np.spacing(1000.0))


def test_members_of_the_orbit():
    line = Line(1.0, np.array([case[0] for case in CASES]), np.array([case[1] for case in CASES]))
    found = emission_time(line, np.array([0.0, 1000.0]), 299792.458)
    assert found.shape == (3, 2)
    assert np.allclose(found[:, 1], [case[2] for case in CASES], rtol=0, atol=4 * np.spacing(1000.0))


@pytest.mark.parametrize(
    ("units", "expected"),
    [
        ({"time": "s", "inertia": "kg m2"}, 299792458.0),
        ({"time": "s", "inertia": "kg km2"}, 299792.458),
        ({"time": "d", "inertia": "kg km2"}, 299792.458 * 86400),
        ({"time": "h", "inertia": "1", "length": "au"}, 299792458.0 * 3600 / 149597870700.0),
    ],
)
def test_the_speed_of_light_in_units(units, expected):
    assert abs(speed_of_light(DerivedUnits(units)) / expected - 1) < 1e-15


@pytest.mark.parametrize(
    "units",
    [{"time": "1", "inertia": "kg km2"}, {"time": "s", "inertia": "1"}, {"time": "s", "inertia": "kg furlong2"}],
)
def test_unknown_units(units):
    with pytest.raises(ValueError, match=r"light_time must have known units of time and length .* or light_time=False"):
        speed_of_light(DerivedUnits(units))
