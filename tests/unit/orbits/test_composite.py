"""Sums of orbits: a satellite about what attracts its planet."""

import numpy as np
import pytest

import poinsot as pt

SATELLITE = pt.KeplerOrbit(
    398600.4418, semimajor_axis=7000.0, eccentricity=0.01, inclination=0.9, node=0.3, argument_of_periapsis=0.5
)
EARTH = pt.KeplerOrbit(
    1.32712440041e11, semimajor_axis=1.495978707e8, eccentricity=0.0167, inclination=0.4, argument_of_periapsis=1.8
)
ZERO = pt.Calendar("2026-01-01", "TDB")


def place(orbit, times):
    return np.stack(orbit.position_at(times), axis=-1)


def tabulated(orbit, **labels):
    return pt.orbits.Ephemeris.from_function(
        orbit.mu, position=lambda times: place(orbit, times), start=0.0, stop=6000.0, **labels
    )


def test_positions_and_velocities_add():
    total = pt.orbits.composite_orbit(SATELLITE, EARTH, start=-3000.0, stop=9000.0)
    times = np.linspace(-3000, 9000, 777)
    np.testing.assert_allclose(place(total, times), place(SATELLITE, times) + place(EARTH, times), rtol=0, atol=5e-4)
    speeds = (np.stack(orbit.velocity_at(times), axis=-1) for orbit in (total, SATELLITE, EARTH))
    whole, near, far = speeds
    np.testing.assert_allclose(whole, near + far, rtol=0, atol=5e-5)
    assert total.mu == EARTH.mu
    assert total.span == (-3000.0, 9000.0)


def test_labels_and_the_common_span():
    near = tabulated(SATELLITE, reference_frame="ICRF", origin="EARTH", calendar=ZERO)
    far = tabulated(EARTH, reference_frame="ICRF", origin="SUN", calendar=ZERO)
    total = pt.orbits.composite_orbit(near, far)
    assert (total.reference_frame, total.origin, total.calendar) == ("ICRF", "SUN", ZERO)
    assert total.span == (0.0, 6000.0)
    from_elements = pt.orbits.composite_orbit(SATELLITE, far)
    assert (from_elements.reference_frame, from_elements.calendar) == ("ICRF", ZERO)
    assert pt.orbits.composite_orbit(near, far, stop="2026-01-01T00:01:00 TDB").span == (0.0, 60.0)


@pytest.mark.parametrize(
    ("orbits", "options", "error", "sentence"),
    [
        ((SATELLITE,), {}, ValueError, "orbits must be two or more, got 1"),
        ((SATELLITE, 3), {}, TypeError, "orbits must be Orbits, got int"),
        (
            (SATELLITE, EARTH),
            {},
            ValueError,
            "orbits must be known at common times with an end, but they are from -inf",
        ),
        ((SATELLITE, EARTH), {"start": 1.0, "stop": 0.0}, ValueError, "orbits must be known at common times"),
        ((SATELLITE, EARTH), {"start": "2026-01-01Z"}, TypeError, "start must be real numbers, got str"),
        (
            (tabulated(SATELLITE, reference_frame="TEME"), tabulated(EARTH, reference_frame="ICRF")),
            {},
            ValueError,
            "orbits must have one reference frame to be added, got TEME and ICRF",
        ),
        (
            (tabulated(SATELLITE, calendar=ZERO), tabulated(EARTH, calendar=pt.Calendar("2026-01-01", "UTC"))),
            {},
            ValueError,
            "orbits must have one calendar to be added, got the one from ",
        ),
    ],
)
def test_bad_input(orbits, options, error, sentence):
    with pytest.raises(error, match=f"^{sentence}"):
        pt.orbits.composite_orbit(*orbits, **options)
