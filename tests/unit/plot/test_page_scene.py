"""Dates and round factors of the 3D page."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.plot.page_scene import _round_number, calendar_of


def motion_with(calendar):
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.0)
    ephemeris = pt.orbits.Ephemeris.from_function(
        398600.4418, position=lambda t: np.transpose(orbit.position_at(t)), start=0.0, stop=100.0, calendar=calendar
    )
    body = pt.Body((1.0, 2.0, 3.0))
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0.01), time=10.0)
    return pt.propagate(pt.System(body, pt.GravityGradient(ephemeris)), state, [10.0, 20.0])


@pytest.mark.parametrize(
    ("zero", "milliseconds"),
    [("1970-01-02T00:00:00", 86400e3), ("2000-01-01T12:30:15.25", 946729815.25e3)],
)
def test_time_zero_in_milliseconds_since_1970(zero, milliseconds):
    found = calendar_of(motion_with(pt.Calendar(zero, "TDB")))
    assert found == {"zero": milliseconds, "unit": 1000, "scale": "TDB"}


def test_no_calendar():
    body = pt.Body((1.0, 2.0, 3.0))
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    assert calendar_of(pt.propagate(pt.System(body), state, [0.0, 1.0])) is None


@pytest.mark.parametrize(
    ("least", "number"), [(0.3, 1), (1.0, 1), (1.1, 2), (4.0, 5), (5.1, 10), (100.0, 100), (101, 200)]
)
def test_round_numbers(least, number):
    assert _round_number(least) == number
