"""Tests of observers on the ground: geometry of a sphere, ERFA and astropy, limits, and wrong arguments."""

import erfa
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import GCRS, ITRS, AltAz, CartesianRepresentation, EarthLocation
from astropy.time import Time
from astropy.utils import iers

import poinsot as pt
from poinsot.orbits import GroundStation, KeplerOrbit, RotationModel

RATE = 7.292115e-5
UPRIGHT = RotationModel(0.0, np.pi / 2, -np.pi / 2, rate=RATE)
"""Planet whose axes are the space axes at the time 0."""

ORBIT = KeplerOrbit(398600.4418, semimajor_axis=26_600.0, eccentricity=0.7, inclination=1.1, node=0.4)
WGS84 = {"equatorial_radius": 6378.137}
PLACES = [(0.0, 0.0, 0.0), (0.84, 0.2, 0.5), (-1.2, -2.8, 3.1), (np.pi / 2, 0.0, 0.1)]


def stacked(vector, times):
    return np.stack(np.broadcast_arrays(*vector, times)[:3], axis=-1)


def station(place, orbit=ORBIT, rotation=UPRIGHT, **others):
    latitude, longitude, height = place
    return GroundStation(orbit, rotation, latitude=latitude, longitude=longitude, height=height, **WGS84 | others)


@pytest.mark.parametrize("place", PLACES)
def test_the_place_agrees_with_erfa(place):
    latitude, longitude, height = place
    expected = erfa.gd2gc(1, longitude, latitude, 1e3 * height) / 1e3
    # ERFA uses the same ellipsoid; its sums have roundings of the size of the radius.
    assert np.allclose(list(station(place).place()), expected, rtol=0, atol=4e-12)


def test_the_elevation_on_a_sphere_has_its_closed_form():
    times, radius, latitude, longitude = np.linspace(0, 86400, 97), 6378.137, 0.7, -0.3
    seen = station((latitude, longitude, 0.0), flattening=0.0)
    place = stacked(ORBIT.position_at(times), times)
    r = np.linalg.norm(place, axis=-1)
    declination, hour = np.arcsin(place[:, 2] / r), RATE * times + longitude - np.arctan2(place[:, 1], place[:, 0])
    cosine = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(hour)
    expected = np.arctan2(cosine - radius / r, np.sqrt(1 - cosine**2))
    # Angles of the Earth's rotation are up to 6.3; the sine from the cosine loses half the digits near 0 and pi.
    assert np.allclose(seen.elevation_at(times), expected, rtol=0, atol=3e-13)
    hidden = seen.hidden_at(times)["below the minimum elevation"]
    assert np.array_equal(hidden, expected < 0)
    assert 10 < np.count_nonzero(hidden) < 87


@pytest.mark.parametrize("place", PLACES[1:3])
def test_the_elevation_agrees_with_astropy(place):
    latitude, longitude, height = place
    with iers.conf.set_temp("auto_download", False):
        date = Time("2020-03-01T05:00:00", scale="utc")
        calendar = pt.Calendar("2020-03-01T05:00:00", "UTC")
        earth = RotationModel.earth(calendar=calendar, ut1_minus_utc=float(date.ut1.jd2 - date.utc.jd2) * 86400)
        seen = station(place, rotation=earth)
        location = EarthLocation.from_geodetic(longitude * u.rad, latitude * u.rad, height * u.km)
        for seconds in (0.0, 7000.0, 15000.0):
            when = date + seconds * u.s
            altaz, geocentre = AltAz(obstime=when, location=location), ORBIT.position_at(seconds)

            def elevation(itrs, when=when, altaz=altaz):
                above = itrs - np.array([x.to_value(u.km) for x in location.geocentric])
                seen_from = ITRS(CartesianRepresentation(above * u.km), obstime=when, location=location)
                return seen_from.transform_to(altaz).alt.rad

            found = seen.elevation_at(seconds)
            along_planet = np.array([float(x) for x in earth.to_planet(geocentre, seconds)])
            assert found == pytest.approx(elevation(along_planet), rel=0, abs=1e-12)
            # The model has no nutation, at most 19 arcseconds, nor polar motion, at most 1 arcsecond, which the
            # parallax of a body at the distance d from the station enlarges by r / d.
            gcrs = GCRS(CartesianRepresentation(np.array(geocentre, dtype=float) * u.km), obstime=when)
            itrs = gcrs.transform_to(ITRS(obstime=when)).cartesian.xyz.to_value(u.km)
            enlarged = np.linalg.norm(itrs) * float(seen.inverse_distance_at(seconds))
            bound = np.radians(20 / 3600) * max(1.0, enlarged)
            assert found == pytest.approx(elevation(itrs), rel=0, abs=bound)


def test_the_body_is_at_the_difference_of_two_positions_at_members_of_stations():
    both = station((np.array([0.1, 0.9]), 0.4, np.array([0.0, 2.0])))
    times = np.array([0.0, 500.0, 4000.0])
    for i, one in enumerate((station((0.1, 0.4, 0.0)), station((0.9, 0.4, 2.0)))):
        ground = UPRIGHT.to_space(one.place(), times)
        expected = stacked(ORBIT.position_at(times), times) - stacked(ground, times)
        assert np.allclose(stacked(one.position_at(times), times), expected, rtol=1e-15, atol=1e-11)
        for formula in ("position_at", "velocity_at"):
            members = np.stack([np.asarray(x) for x in getattr(both, formula)(times)], axis=-1)[i]
            assert np.allclose(members, stacked(getattr(one, formula)(times), times), rtol=1e-14, atol=1e-11)
        assert np.allclose(both.elevation_at(times)[i], one.elevation_at(times), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"place": (48.0, 0.0, 0.0)}, r"latitude must be from -pi/2 to pi/2, got 48\. Degrees: np\.radians\(value\)\."),
        (
            {"place": PLACES[0], "minimum_elevation": 10.0},
            r"minimum_elevation must be from -pi/2 to pi/2, got 10\. Degrees: np\.radians\(value\)\.",
        ),
        (
            {"place": PLACES[0], "flattening": 298.257},
            r"flattening must be from 0 to 0\.99, got 298\.257\. The Earth's is 1 / 298\.257223563\.",
        ),
        (
            {"place": PLACES[0], "equatorial_radius": 0.0},
            r"equatorial_radius must be positive, got 0\.0\.",
        ),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=rf"^{message}$"):
        station(**arguments)


def test_the_orbit_and_the_rotation_have_one_frame_and_calendar():
    in_teme = RotationModel(0.0, 1.0, 0.0, rate=RATE, reference_frame="TEME")
    moon = pt.orbits.Ephemeris.from_function(
        1.0,
        position=lambda t: np.stack([1e5 + t, 0 * t, 0 * t], axis=-1),
        start=0.0,
        stop=1.0,
        reference_frame="ICRF",
    )
    with pytest.raises(
        ValueError, match=r"^orbit and rotation must have one reference frame, got 'ICRF' and 'TEME'\.$"
    ):
        station(PLACES[0], orbit=moon, rotation=in_teme)
    assert station(PLACES[0], orbit=moon).reference_frame == "ICRF"
    dates = [pt.Calendar(day, "TDB") for day in ("2020-01-01", "2021-01-01")]
    dated = pt.orbits.Ephemeris.from_function(
        1.0,
        position=lambda t: np.stack([1e5 + t, 0 * t, 0 * t], axis=-1),
        start=0.0,
        stop=1.0,
        reference_frame="ICRF",
        calendar=dates[0],
    )
    with pytest.raises(ValueError, match=r"^orbit and rotation must have one calendar, got "):
        station(PLACES[0], orbit=dated, rotation=RotationModel.iau("earth", calendar=dates[1]))


def test_kilometres_of_an_ephemeris_and_metres_of_the_default_radius_are_refused():
    moon = pt.orbits.planet_orbit("moon", "earth", 0.0, 86400.0)
    earth = RotationModel.iau("earth")
    with pytest.raises(ValueError, match=r"^equatorial_radius must be .* got 6378137 for mu = 398600\.4\d+\. It is 6"):
        GroundStation(moon, earth, latitude=0.1, longitude=0.2)
    assert float(GroundStation(moon, earth, latitude=0.1, longitude=0.2, **WGS84).elevation_at(0.0)) < np.pi / 2
    in_metres = pt.orbits.kilometres_to_metres(moon)
    assert GroundStation(in_metres, earth, latitude=0.1, longitude=0.2).origin == "ground station"


def test_a_radius_in_another_unit_than_the_orbit_is_warned_of():
    with pytest.warns(
        UserWarning, match=r"GroundStation: the periapsis is .* below the surface .*; give lengths in one unit\."
    ):
        station(PLACES[0], equatorial_radius=6_378_137.0)
