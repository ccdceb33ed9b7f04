"""Earth satellites from two-line elements and mean-elements messages: published vectors, axes, age, bad input."""

import contextlib
import importlib.resources
import json
import re
import sys
import warnings

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import GCRS, TEME, CartesianRepresentation
from astropy.time import Time
from astropy.utils import iers
from hypothesis import given, settings
from hypothesis import strategies as st
from sgp4 import api

import poinsot as pt
from poinsot.files.orbits.tle import _in_icrf

# Vallado, Crawford, Hujsak and Kelso, "Revisiting Spacetrack Report #3", AIAA 2006-6753: elements, and positions in km
# at minutes from the epoch, of its verification output.
VANGUARD = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)
PUBLISHED = {
    VANGUARD: {
        0: (7022.46529266, -1400.08296755, 0.03995155),
        360: (-7154.03120202, -3783.17682504, -3536.19412294),
        1440: (-938.55923943, -6268.18748831, -4294.02924751),
        4320: (-9060.47373569, 4658.70952502, 813.68673153),
    },
    (  # near the Earth, with drag
        "1 06251U 62025E   06176.82412014  .00008885  00000-0  12808-3 0  3985",
        "2 06251  58.0579  54.0425 0030035 139.1568 221.1854 15.56387291  6774",
    ): {
        0: (3988.31022699, 5498.96657235, 0.90055879),
        120: (-3935.69800083, 409.10980837, 5471.33577327),
        960: (-4990.91637950, -2303.42547880, 3920.86335598),
    },
    (  # far from the Earth, where Sun and Moon are felt; before the epoch
        "1 04632U 70093B   04031.91070959 -.00000084  00000-0  10000-3 0  9955",
        "2 04632  11.4628 273.1101 1450506 207.6000 143.9350  1.20231981 44145",
    ): {
        0: (2334.11450085, -41920.44035349, -0.03867437),
        -5184: (-29020.02587128, 13819.84419063, -5713.33679183),
        -4896: (-15129.94694545, -36907.74526221, -3487.56256701),
    },
}
MESSAGE = {  # the fields of VANGUARD's elements, as a message says them
    "OBJECT_NAME": "VANGUARD 1",
    "OBJECT_ID": "1958-002B",
    "CENTER_NAME": "EARTH",
    "REF_FRAME": "TEME",
    "TIME_SYSTEM": "UTC",
    "MEAN_ELEMENT_THEORY": "SGP4",
    "EPOCH": "2000-06-27T18:50:19.733568",
    "MEAN_MOTION": "10.82419157",
    "ECCENTRICITY": "0.1859667",
    "INCLINATION": "34.2682",
    "RA_OF_ASC_NODE": "348.7242",
    "ARG_OF_PERICENTER": "331.7664",
    "MEAN_ANOMALY": "19.3264",
    "NORAD_CAT_ID": "799500005",
    "BSTAR": "0.28098E-4",
}
DAY = 86400.0


def checked(line):
    """A line with the right checksum, as the rules of the format say it."""
    return line[:68] + str(sum(int(c) if c.isdigit() else int(c == "-") for c in line[:68]) % 10)


def place(orbit, times):
    return np.stack(orbit.position_at(np.atleast_1d(times)), axis=-1)


@pytest.mark.parametrize("lines", PUBLISHED)
def test_published_positions(lines):
    minutes = np.array(list(PUBLISHED[lines]), dtype=float)
    first, last = min(60 * minutes.min(), 0), max(60 * minutes.max(), 0)
    jump = r"^the position relative to EARTH must be continuous .* got a jump of 6\.4445 at t = -307216\.76"
    with pytest.warns(UserWarning, match=jump) if "04632" in lines[0] else contextlib.nullcontext():
        orbit = pt.files.tle_orbit(lines, first, last)
    expected = np.array(list(PUBLISHED[lines].values()))
    # Published to 1e-8 km; the polynomials add 1e-10 of the distance.
    np.testing.assert_allclose(place(orbit, 60 * minutes), expected, rtol=0, atol=2e-8 + 2e-10 * 42000)


def test_polynomials_keep_sgp4():
    orbit = pt.files.tle_orbit(VANGUARD, 0, 3 * DAY)
    satellite = api.Satrec.twoline2rv(*VANGUARD)
    times = np.linspace(0, 3 * DAY, 4001)
    exact = np.array([satellite.sgp4_tsince(t / 60)[1] for t in times])
    assert np.max(np.linalg.norm(place(orbit, times) - exact, axis=-1)) < 4e-6
    assert orbit.error < 8e-6
    speeds = np.array([satellite.sgp4_tsince(t / 60)[2] for t in times])
    # SGP4's velocities differ by a metre per second from the derivatives of its positions.
    assert np.max(np.linalg.norm(np.stack(orbit.velocity_at(times), axis=-1) - speeds, axis=-1)) < 1.3e-3
    differences = np.stack(orbit.velocity_at(times), axis=-1) - derivatives(satellite, times)
    assert np.max(np.linalg.norm(differences, axis=-1)) < 1.5e-6


def derivatives(satellite, times):
    before, after = (np.array([satellite.sgp4_tsince((t + h) / 60)[1] for t in times]) for h in (-0.5, 0.5))
    return after - before


def verification_sets():
    """The sets of Vallado et al. (2006) that the package sgp4 brings, each with its first and last minute."""
    text = (importlib.resources.files("sgp4") / "SGP4-VER.TLE").read_text()
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    for first, second in zip(rows[::2], rows[1::2], strict=True):
        begin, end, _ = map(float, second[69:].split())
        yield (checked(first[:69]), checked(second[:69])), begin, end


def directly(satellite, times):
    errors, places, speeds = satellite.sgp4_array(
        np.full(times.size, satellite.jdsatepoch), satellite.jdsatepochF + times / DAY
    )
    return errors, places, speeds


JUMPS = {"04632": (-307216.7622, 6.444503), "14128": (124172.9042, 1.677008), "20413": (110586.4934, 1667.688)}
"""Seconds from the epoch and km, in the span of the verification; found by bisection of direct calls."""

STOPS = {"33334": 0.0, "33333": 1200.0, "28872": 3000.0, "29141": 25300.0, "22312": 29000.0, "28350": 88000.0}
"""Seconds from the epoch before which SGP4 is left: it has an error later, or at once."""


@pytest.mark.parametrize(("lines", "first", "last"), list(verification_sets()))
def test_every_set_of_the_verification_against_sgp4(lines, first, last):
    number = lines[0][2:7]
    span = 60 * first, min(60 * last, STOPS.get(number, np.inf))
    if span[0] >= span[1] or first > 1e6:  # 33334 has no position at all, 20413 none after 3500 years
        with pytest.raises(ValueError, match=r"^start and stop must be times at which SGP4 has a position, got "):
            pt.files.tle_orbit(lines, 60 * first, 60 * last, max_age=1e6)
        return
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        orbit = pt.files.tle_orbit(lines, *span, max_age=1e6)
    satellite = api.Satrec.twoline2rv(*lines)
    times = np.linspace(*span, 20011)
    errors, places, speeds = directly(satellite, times)
    assert not np.any(errors)
    # The error is twice the largest difference at 4096 times or more.
    assert np.max(np.linalg.norm(place(orbit, times) - places, axis=-1)) < orbit.error < 1.1e-4
    assert orbit.velocity_jump < 0.02
    apart = np.linalg.norm(np.stack(orbit.velocity_at(times), axis=-1) - speeds, axis=-1)
    message_text = [str(warning.message) for warning in caught]
    if number in JUMPS:
        time, size = JUMPS[number]
        knot = orbit.knots[np.argmin(abs(orbit.knots - time))]
        _, (before, after), _ = directly(satellite, knot + np.array([-1e-6, 1e-6]))
        assert np.linalg.norm(after - before) == pytest.approx(size, rel=1e-4, abs=0)
        assert orbit.position_jump == pytest.approx(size, rel=1e-5, abs=0)
        assert len(message_text) == 1
        assert f"got a jump of {size:.6g} at t = {knot:.10g} (20" in message_text[0]
    else:
        assert orbit.position_jump < orbit.error
    if np.max(apart) > 0.01:
        sentence = (
            r"the velocity of SGP4 must be within 0\.01 km/s of the derivative of its position, got (\S+) km/s at t = "
            r"\S+\. velocity_at returns the derivative\."
        )
        (found,) = (re.fullmatch(sentence, one) for one in message_text)
        assert float(found[1]) == pytest.approx(np.max(apart), rel=0.01, abs=0)
        assert number in ("23333", "22312", "29141", "33333")
    elif number not in JUMPS:
        assert message_text == []
    smooth = times[2:-2][abs(times[2:-2] - JUMPS.get(number, (np.inf,))[0]) > 2.0]
    ahead = {k: directly(satellite, smooth + k)[1] for k in (-2, -1, 1, 2)}
    derivative = (8 * (ahead[1] - ahead[-1]) - (ahead[2] - ahead[-2])) / 12
    apart = np.linalg.norm(np.stack(orbit.velocity_at(smooth), axis=-1) - derivative, axis=-1)
    if number not in STOPS:  # SGP4 limits elements, or is nearly singular, before its errors
        assert np.max(apart) < 6.5e-6  # three times the worst of the sets


def test_a_jump_is_a_knot_and_a_warning():
    lines = next(lines for lines, *_ in verification_sets() if lines[0][2:7] == "20413")
    sentence = (
        "the position relative to EARTH must be continuous from start to stop, got a jump of 1667.69 at t = "
        "110586.4934 (2005-12-31T01:43:06.494 UTC). The orbit jumps there too. End it before, or begin it after the "
        "jump."
    )
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        orbit = pt.files.tle_orbit(lines, DAY, 3 * DAY)
    assert len(orbit.knots) < 10
    before = pt.files.tle_orbit(lines, DAY, 110586.0)
    after = pt.files.tle_orbit(lines, 110587.0, 3 * DAY)
    for part in (before, after):
        times = np.linspace(*part.span, 101)
        np.testing.assert_allclose(place(part, times), place(orbit, times), rtol=0, atol=orbit.error + part.error)


def test_what_an_orbit_says_of_itself():
    orbit = pt.files.tle_orbit(VANGUARD, 0, 1000)
    assert (orbit.mu, orbit.reference_frame, orbit.origin) == (398600.8, "TEME", "EARTH")
    assert orbit.calendar == pt.Calendar("2000-06-27T18:50:19.733568", "UTC")


def test_lines_as_text_with_a_name():
    text = "VANGUARD 1\r\n" + "\r\n".join(VANGUARD) + "\r\n\r\n"
    assert place(pt.files.tle_orbit(text, 0, 1000), 0)[0, 0] == place(pt.files.tle_orbit(VANGUARD, 0, 1000), 0)[0, 0]


def test_axes_of_the_icrf():
    times = np.linspace(0, 3 * DAY, 7)
    orbit = pt.files.tle_orbit(VANGUARD, 0, 3 * DAY, reference_frame="ICRF")
    inertial, of_date = place(orbit, times), place(pt.files.tle_orbit(VANGUARD, 0, 3 * DAY), times)
    np.testing.assert_allclose(np.linalg.norm(inertial, axis=-1), np.linalg.norm(of_date, axis=-1), rtol=1e-14)
    with iers.conf.set_temp("auto_download", False), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dates = orbit.calendar.date(times)
        through = TEME(CartesianRepresentation(of_date.T * units.km), obstime=dates)
        expected = through.transform_to(GCRS(obstime=dates)).cartesian.xyz.to_value("km").T
    # Through the rotating Earth, with its measured UT1 and pole, by another theory of precession.
    assert np.max(np.linalg.norm(inertial - expected, axis=-1)) < 1e-4
    assert np.max(np.linalg.norm(of_date - expected, axis=-1)) > 0.5
    # Vallado et al. (2006), Eq. C-5: J2000 by the nutation of 1980.
    assert np.linalg.norm(inertial[-1] - (-9059.9413786, 4659.6972000, 813.9588875)) < 3e-3


def test_the_equinox_of_1982_stays_with_the_sidereal_time_of_1982():
    """At geostationary distance in 2020, when it is 40 mas from that of today's theory: 8 m."""
    places = 42164.0 * np.eye(3)
    dates = Time(["2020-01-01T00:00:00"] * 3, scale="utc")
    with iers.conf.set_temp("auto_download", False), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        through = TEME(CartesianRepresentation(places.T * units.km), obstime=dates)
        expected = through.transform_to(GCRS(obstime=dates)).cartesian.xyz.to_value("km").T
    assert np.max(np.linalg.norm(_in_icrf(places, dates) - expected, axis=-1)) < 3e-4


def test_dates_and_another_calendar():
    own = pt.files.tle_orbit(VANGUARD, "2000-06-28T00:00:00 UTC", "2000-06-28T12:00:00 UTC")
    calendar = pt.Calendar("2000-06-28T00:00:00", "TDB")
    other = pt.files.tle_orbit(VANGUARD, 3600, "2000-06-28T12:00:00 TDB", calendar=calendar)
    for date in ("2000-06-28T02:00:00 UTC", "2000-06-28T11:00:00 TDB"):
        here, there = place(own, own.calendar.time(date)), place(other, calendar.time(date))
        np.testing.assert_allclose(here, there, rtol=0, atol=3e-6)


def test_leap_second_takes_a_second():
    # The same elements with an epoch 12 h before the leap second at the end of 2016.
    lines = tuple(checked(line.replace("00179.78495062", "16366.50000000")) for line in VANGUARD)
    before = pt.files.tle_orbit(lines, "2016-12-31T23:59:50 UTC", "2017-01-01T00:00:10 UTC")
    assert before.span == pytest.approx((43190, 43211), abs=1e-9)
    assert np.linalg.norm(np.diff(place(before, np.array([43199.5, 43200.5])), axis=0)) == pytest.approx(5.4, abs=2.5)


def test_a_body_in_that_orbit():
    orbit = pt.files.tle_orbit(VANGUARD, 0, 6001)
    body = pt.Body((400.0, 500.0, 600.0))
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3))
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, np.linspace(0, 6000, 5))
    dates = orbit.calendar.date(np.linspace(0, 6000, 5))
    dated = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, dates)
    np.testing.assert_array_equal(dated.quaternion, motion.quaternion)
    spoken = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, [f"{date} UTC" for date in dates.isot])
    np.testing.assert_allclose(spoken.times, motion.times, rtol=0, atol=6e-4)
    still = pt.KeplerOrbit.from_vectors(
        398600.8, position=place(orbit, 0)[0], velocity=np.stack(orbit.velocity_at(np.array([0.0])), axis=-1)[0]
    )
    near = pt.propagate(pt.System(body, pt.GravityGradient(still)), start, np.linspace(0, 6000, 5))
    np.testing.assert_allclose(motion.omega_body, near.omega_body, rtol=0, atol=2e-5)


# ------------------------------------------------------------------ messages


def as_xml(fields):
    inner = "".join(f"<{key}>{value}</{key}>" for key, value in fields.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?><ndm xmlns="urn:ccsds:schema:ndmxml"><omm id="CCSDS_OMM_VERS">'
        f"<header><ORIGINATOR/></header><body><segment><metadata/><data>{inner}</data></segment></body></omm></ndm>"
    )


def as_csv(fields):
    return ",".join(fields) + "\n" + ",".join(fields.values()) + "\n"


def as_kvn(fields):
    return "CCSDS_OMM_VERS = 2.0\nCOMMENT a = b\n" + "".join(f"{key} = {value}\n" for key, value in fields.items())


def as_json(fields):
    return json.dumps(
        [{key: float(v) if re.fullmatch(r"[\d.E-]+", v) and "." in v else v for key, v in fields.items()}]
    )


@pytest.mark.parametrize("written", [dict, as_xml, as_csv, as_kvn, as_json])
def test_messages_say_what_lines_say(written):
    orbit = pt.files.omm_orbit(written(MESSAGE), 0, DAY)
    times = np.linspace(0, DAY, 50)
    np.testing.assert_allclose(
        place(orbit, times), place(pt.files.tle_orbit(VANGUARD, 0, DAY), times), rtol=0, atol=5e-6
    )
    assert orbit.calendar == pt.Calendar("2000-06-27T18:50:19.733568", "UTC")


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"GM": "398600.4415"}, "GM should be 398600.8 for SGP4, got '398600.4415', which is ignored."),
        (
            {"REF_FRAME_EPOCH": "2000-06-27"},
            "REF_FRAME_EPOCH should be absent for SGP4, got '2000-06-27', which is ignored.",
        ),
        ({"WEATHER": "fine"}, "message should have a key of the format, got 'WEATHER', which is ignored."),
    ],
)
def test_fields_that_are_ignored_give_a_warning(fields, sentence):
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        orbit = pt.files.omm_orbit(MESSAGE | fields, 0, 1000)
    np.testing.assert_array_equal(place(orbit, 500.0), place(pt.files.omm_orbit(MESSAGE, 0, 1000), 500.0))


def test_fields_of_the_standard_and_of_space_track_pass():
    fields = {
        "GM": "398600.8",
        "MASS": "1.5",
        "CX_X": "1",
        "CZ_DOT_Y": "2",
        "SEMIMAJOR_AXIS": "8000",
        "TLE_LINE1": "1 0",
    }
    orbit = pt.files.omm_orbit(MESSAGE | fields | {"USER_DEFINED_A": "b"}, 0, 1000)
    np.testing.assert_array_equal(place(orbit, 500.0), place(pt.files.omm_orbit(MESSAGE, 0, 1000), 500.0))


def test_units_and_day_of_year_in_a_message():
    fields = MESSAGE | {"INCLINATION": "34.2682 [deg]", "EPOCH": "2000-179T18:50:19.733568"}
    orbit = pt.files.omm_orbit(as_kvn(fields), 0, 1000)
    np.testing.assert_allclose(place(orbit, 0)[0], PUBLISHED[VANGUARD][0], rtol=0, atol=5e-6)


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (MESSAGE | {"BSTAR": ""}, "message must have the field BSTAR, got none"),
        (MESSAGE | {"EPHEMERIS_TYPE": "4"}, "EPHEMERIS_TYPE must be 0 or 2 for SGP4, got '4'"),
        (
            MESSAGE | {"MEAN_ELEMENT_THEORY": "DSST"},
            "MEAN_ELEMENT_THEORY must be SGP4 or SGP/SGP4 for SGP4, got 'DSST'",
        ),
        (as_kvn(MESSAGE | {"INCLINATION": "0.598 [rad]"}), "message, line 12 must have INCLINATION in deg, got 'rad'"),
        (
            as_kvn(MESSAGE | {"MEAN_MOTION": "7.87e-4 [rad/s]"}),
            "message, line 10 must have MEAN_MOTION in rev/day, got",
        ),
        (
            as_xml(MESSAGE).replace("<BSTAR>", '<BSTAR units="1/m">'),
            "message must have BSTAR in 1/ER, got '1/m'",
        ),
        (
            as_xml(MESSAGE).replace("<BSTAR>", "<BSTAR>1e-5</BSTAR><BSTAR>"),
            "message must not repeat BSTAR, got '0.28098E",
        ),
        (as_json(MESSAGE)[:-2] + ', "BSTAR": 1e-5}]', "message must not repeat BSTAR, got '1e-05' after '2.8098e-05'"),
        (
            as_csv(MESSAGE).replace("BSTAR", "BSTAR,BSTAR").rstrip() + ",1e-5",
            "message must not repeat BSTAR, got '1e-5'",
        ),
        (as_csv(MESSAGE).rstrip() + ",1e-5", "message must have a value for each of the 15 columns, got 16 values"),
        (
            MESSAGE | {"BTERM": "0.01"},
            "BTERM must be absent from elements for SGP4, got '0.01'. SGP4 uses MEAN_MOTION and",
        ),
        (MESSAGE | {"SEMI_MAJOR_AXIS": "8000"}, "SEMI_MAJOR_AXIS must be absent from elements for SGP4, got '8000'"),
        (
            MESSAGE | {"REFFRAME": "ICRF"},
            "message must have a key of the format, got 'REFFRAME'. Did you mean 'REF_FRAME'",
        ),
        (MESSAGE | {"REF_FRAME": "ICRF"}, "REF_FRAME must be TEME for SGP4, got 'ICRF'"),
        (MESSAGE | {"TIME_SYSTEM": "TDB"}, "TIME_SYSTEM must be UTC"),
        (MESSAGE | {"CENTER_NAME": "MARS"}, "CENTER_NAME must be EARTH"),
        (MESSAGE | {"INCLINATION": "steep"}, "INCLINATION must be a number from 0 to 180, got 'steep'"),
        (MESSAGE | {"ECCENTRICITY": "1.5"}, "ECCENTRICITY must be a number from 0 to 1, got '1.5'"),
        (MESSAGE | {"ECCENTRICITY": "0.9"}, "start and stop must be times at which SGP4 has a position, got .* s from"),
        (MESSAGE | {"MEAN_ANOMALY": "nan"}, "MEAN_ANOMALY must be a number from -360 to 360, got 'nan'"),
        (MESSAGE | {"RA_OF_ASC_NODE": "1e9"}, "RA_OF_ASC_NODE must be a number from -360 to 360"),
        (MESSAGE | {"EPOCH": "yesterday"}, "epoch must be a date"),
        (MESSAGE | {"EPOCH": "2000-06-27T18:50:19.7335681"}, "EPOCH must have at most six digits"),
        (
            as_xml(MESSAGE).replace("<ndm", '<!DOCTYPE ndm [<!ENTITY a "b">]><ndm', 1),
            "message must be XML without a document",
        ),
        (as_xml(MESSAGE)[:-9], "message must be well-formed XML, got "),
        (as_json(MESSAGE)[:-3], "message must be JSON where it begins with a bracket"),
        ("[1, 2]", "message must be the fields of a satellite by name"),
        (as_csv(MESSAGE) + ",".join(MESSAGE.values()), "message must be about one satellite, got 2"),
        (as_kvn(MESSAGE) * 2, "message, line 18 must not repeat CCSDS_OMM_VERS, got '2.0' after '2.0'. Remove one of"),
        ("", "message must be about one satellite, got 0"),
        ("x" * 1_000_001, "message must be about one satellite, got 1000001 characters"),
    ],
)
def test_bad_messages(message, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}"):
        pt.files.omm_orbit(message, 0, 1000)


# ------------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        (VANGUARD[:1], "lines must be the two lines of one set, perhaps after its name, got 1 lines"),
        (VANGUARD * 2, "lines must be the two lines of one set, perhaps after its name, got 4 lines"),
        (VANGUARD[::-1], "line 1 must have the 69 columns of line 1 of a set, got '2 00005"),
        ((VANGUARD[0][:-1] + "4", VANGUARD[1]), "line 1 must end in its checksum 3, got 4"),
        (
            (VANGUARD[0], VANGUARD[1].replace("34.2682", "34.2683")),
            "line 2 must end in its checksum 8, got 7",
        ),
        (
            (VANGUARD[0], checked(VANGUARD[1].replace("00005", "00006"))),
            "lines must be of one satellite, got 00005 and",
        ),
        ((VANGUARD[0][:60], VANGUARD[1]), "line 1 must have the 69 columns"),
        (
            (checked(VANGUARD[0][:62] + "4" + VANGUARD[0][63:]), VANGUARD[1]),
            "lines must be elements for SGP4, got type 4",
        ),
        ((checked(VANGUARD[0].replace("00179", "00379")), VANGUARD[1]), "line 1 must have an epoch within its year"),
        ("", "lines must be the two lines of one set, perhaps after its name, got 0 lines"),
        ("x" * 1_000_001, "lines must be one set of elements, got 1000001 characters"),
    ],
)
def test_bad_lines(lines, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}"):
        pt.files.tle_orbit(lines, 0, 1000)


def test_lines_of_another_kind():
    with pytest.raises(TypeError, match=r"^lines must be a text or a list, each a text, got int 5\.$"):
        pt.files.tle_orbit(5, 0, 1000)
    with pytest.raises(TypeError, match=r"^message must be a text or a mapping, got list\.$"):
        pt.files.omm_orbit([], 0, 1000)


def test_old_elements_are_refused_unless_asked_for():
    with pytest.raises(
        ValueError,
        match=r"at most 14 days from the epoch 2000-06-27T18:50:19.733568 UTC of the elements, got "
        r"14.5 days after it\. Take newer elements, or say how old they may be: max_age\.$",
    ):
        pt.files.tle_orbit(VANGUARD, 0, 14.5 * DAY)
    with pytest.raises(ValueError, match=r"got 20 days before it"):
        pt.files.tle_orbit(VANGUARD, -20 * DAY, -19 * DAY)
    assert pt.files.tle_orbit(VANGUARD, 14.4 * DAY, 14.5 * DAY, max_age=15).span == (14.4 * DAY, 14.5 * DAY)


def test_decayed_satellite():
    lines = (  # of the same report, a rocket body on its last day
        "1 22312U 93002D   06094.46235912  .99999999  81888-5  49949-3 0  3953",
        "2 22312  62.1486  77.4698 0308723 267.9229  88.7392 15.95744531 98783",
    )
    sentence = (
        r"^start and stop must be times at which SGP4 has a position, got .* s from the epoch 2006-04-04T.* UTC: mean"
    )
    with pytest.raises(ValueError, match=sentence):
        pt.files.tle_orbit(lines, 0, 3 * DAY)


def test_other_bad_arguments():
    with pytest.raises(ValueError, match=r"^reference_frame must be one of TEME, ICRF, got 'ITRF'\.$"):
        pt.files.tle_orbit(VANGUARD, 0, 1000, reference_frame="ITRF")
    with pytest.raises(ValueError, match=r"^stop must be later than start"):
        pt.files.tle_orbit(VANGUARD, 1000, 0)
    with pytest.raises(ValueError, match=r"^calendar must count seconds"):
        pt.files.tle_orbit(VANGUARD, 0, 1, calendar=pt.Calendar("2000-06-28", "UTC", "d"))


def test_missing_package_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "sgp4.api", None)
    sentence = r"^sgp4 must be installed for {}, got none. `pip install 'poinsot\[sky\]'` brings it\.$"
    with pytest.raises(ImportError, match=sentence.format("two-line element sets")):
        pt.files.tle_orbit(VANGUARD, 0, 1)
    with pytest.raises(ImportError, match=sentence.format("mean elements")):
        pt.files.omm_orbit(MESSAGE, 0, 1)


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_any_change_of_the_text_is_a_result_or_a_sentence(data):
    text = "\n".join(VANGUARD)
    for _ in range(data.draw(st.integers(1, 3))):
        at, gone = data.draw(st.integers(0, len(text))), data.draw(st.integers(0, 3))
        text = text[:at] + data.draw(st.text(st.sampled_from("0123456789 .-+AUZ\n\0é"), max_size=3)) + text[at + gone :]
    if data.draw(st.booleans()):
        text = "\n".join(checked(line) if len(line) == 69 else line for line in text.splitlines())
    outcome(pt.files.tle_orbit, text)


@given(st.text(max_size=300), st.sampled_from([as_xml, as_csv, as_kvn, as_json]), st.data())
@settings(max_examples=50, deadline=None)
def test_any_message_is_a_result_or_a_sentence(noise, written, data):
    text = written(MESSAGE)
    at, gone = data.draw(st.integers(0, len(text))), data.draw(st.integers(0, 40))
    outcome(pt.files.omm_orbit, text[:at] + noise + text[at + gone :])
    key = data.draw(st.sampled_from(sorted(MESSAGE)))
    outcome(
        pt.files.omm_orbit,
        MESSAGE | {key: data.draw(st.text(max_size=20) | st.floats().map(str) | st.integers().map(str))},
    )
    outcome(pt.files.omm_orbit, noise)


def outcome(read, text):
    message_text = "nothing, but a result"
    try:
        assert np.all(np.isfinite(place(read(text, 0, 600), 300.0)))
    except (ValueError, UserWarning) as problem:
        message_text = str(problem)
    assert re.search(", (but|got) ", message_text)
