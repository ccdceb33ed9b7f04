"""Axes fixed in planets, against SPICE with the constants as NAIF writes them, and against ERFA for the Earth."""

from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.orbits import RotationModel

spice = pytest.importorskip("spiceypy")
erfa = pytest.importorskip("erfa")
astropy_time = pytest.importorskip("astropy.time")

BODIES = {
    "sun": 10,
    "mercury": 199,
    "venus": 299,
    "earth": 399,
    "moon": 301,
    "mars": 499,
    "jupiter": 599,
    "io": 501,
    "europa": 502,
    "ganymede": 503,
    "callisto": 504,
    "saturn": 699,
    "titan": 606,
    "uranus": 799,
    "neptune": 899,
    "pluto": 999,
}
TIMES = np.array([0.0, 1e3, -4e6, 8.4e8])
"""Seconds of TDB from J2000."""


@pytest.fixture(scope="module")
def kernels():
    spice.furnsh(str(Path(__file__).parent / "rotation_models.tpc"))
    yield
    spice.kclear()


def axes(model, times):
    """The matrices space -> planet."""
    return np.swapaxes(model.attitude(times).as_matrix(), -1, -2)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("body", BODIES)
def test_matrix_and_rates_are_those_of_spice(body):
    model = RotationModel.iau(body)
    for time in TIMES:
        rates = spice.tisbod("J2000", BODIES[body], time)
        expected = rates[:3, :3]
        # SPICE reduces no angle: W has its rounding, twice, and the products of periodic terms theirs.
        turned = abs(float(model.rate)) * abs(time)
        assert np.max(np.abs(axes(model, time) - expected)) < 5e-15 + 8e-16 * turned
        omega = model.omega_space(time)
        cross = expected.T @ rates[3:, :3]  # A~ dA = -[omega x]
        assert np.max(np.abs(cross + np.cross(np.eye(3), -omega).T)) < 1e-14 * np.linalg.norm(omega) * (1 + turned)


@pytest.mark.parametrize(
    ("scale", "second"),
    [("UTC", 1.0), ("TCB", 1 - 1.550519768e-8), ("TCG", 1 - 6.969290134e-10)],  # IAU 2006 B3 and 2000 B1.9
)
def test_another_calendar_tells_the_same_instants(scale, second):
    zero = "1986-06-01T00:00:00"
    calendar = pt.Calendar(zero, scale, "h")
    date = "2026-08-03T04:05:06 UTC"
    for body in ("mars", "moon"):
        here, there = RotationModel.iau(body), RotationModel.iau(body, calendar=calendar)
        seconds = here.calendar.time(date)
        # TDB swings by 1.7 ms about TT, the scale in which days of UTC are counted.
        assert np.max(np.abs(axes(here, seconds) - axes(there, calendar.time(date)))) < 3.4e-3 * here.rate
        assert np.allclose(
            3600 * second * here.omega_space(seconds), there.omega_space(calendar.time(date)), rtol=1e-9, atol=0
        )


def matrix_of_erfa(calendar, time, ut1_minus_utc):
    """Of precession and sidereal time, without nutation and the bias of the frame."""
    date = calendar.date(time)
    _, precession, _ = erfa.bp06(date.tt.jd1, date.tt.jd2)
    angle = erfa.gmst06(date.utc.jd1, date.utc.jd2 + ut1_minus_utc / 86400, date.tt.jd1, date.tt.jd2)
    return erfa.rz(angle, precession), erfa.rz(angle, np.eye(3))


@pytest.mark.filterwarnings("ignore:.*dubious year")
@pytest.mark.parametrize(
    ("zero", "scale"),
    [
        ("2000-01-01T12:00:00", "UTC"),
        ("2000-01-01T12:00:00", "TCG"),
        ("2026-06-01T00:00:00", "UTC"),
        ("1975-03-01T00:00:00", "UTC"),
    ],
)
def test_earth_is_that_of_erfa(zero, scale):
    calendar, arcsecond = pt.Calendar(zero, scale), np.pi / 648000
    for days in (0.0, 100.25, 1000.75):
        expected, of_date = matrix_of_erfa(calendar, 86400 * days, 0.3)
        model = RotationModel.earth(calendar=calendar, ut1_minus_utc=0.3)
        leaps = 1.6e-4 if days and zero[:4] == "1975" else 0.0  # two leap seconds within 1000 days, which UT1 has not
        assert np.max(np.abs(axes(model, 86400 * days) - expected)) < 0.02 * arcsecond + leaps
        model = RotationModel.earth(calendar=calendar, ut1_minus_utc=0.3, reference_frame="TEME")
        assert np.max(np.abs(axes(model, 86400 * days) - of_date)) < 0.02 * arcsecond + leaps


LEAP_DAYS = [
    ("2016-12-30T23:59:00", -36.0),
    ("2016-12-31T00:00:00", -36.0),
    ("2016-12-31T12:00:00", -36.0),
    ("2016-12-31T23:59:00", -36.0),
    ("2016-12-31T23:59:60", -36.0),
    ("2017-01-01T00:00:00", -37.0),
    ("2017-01-01T00:01:00", -37.0),
]
"""Dates around a leap second, and UTC - TAI there (IERS Bulletin C 52)."""


@pytest.mark.parametrize(("zero", "utc_minus_tai"), LEAP_DAYS)
@pytest.mark.parametrize("frame", ["TEME", "ICRF"])
def test_the_earth_turns_evenly_through_a_leap_second(zero, utc_minus_tai, frame):
    """UT1 - TAI, -36.4 s in all rows, runs through the leap second; the difference UT1 - UTC jumps there."""
    calendar, ut1_minus_tai, arcsecond = pt.Calendar(zero, "UTC"), -36.4, np.pi / 648000
    offset = ut1_minus_tai - utc_minus_tai
    model = RotationModel.earth(calendar=calendar, ut1_minus_utc=offset, reference_frame=frame)
    for at in ("2016-12-31T18:00:00", "2016-12-31T23:59:60.5", "2017-01-20T00:00:00"):
        tai = astropy_time.Time(at, scale="utc").tai
        terrestrial = tai.jd1, tai.jd2 + 32.184 / 86400
        angle = erfa.gmst06(tai.jd1, tai.jd2 + ut1_minus_tai / 86400, *terrestrial)
        expected = erfa.rz(angle, np.eye(3) if frame == "TEME" else erfa.bp06(*terrestrial)[1])
        found = axes(model, calendar.time(at + " UTC"))
        assert np.max(np.abs(found - expected)) < 0.02 * arcsecond  # as in the test above


def test_rates_of_the_earth_are_the_published_ones():
    sidereal, stellar = RotationModel.earth(reference_frame="TEME"), RotationModel.earth()
    assert abs(float(sidereal.rate) - 7.292115855e-5) < 1e-13  # with the precession in right ascension, 7.086e-12
    assert abs(np.linalg.norm(stellar.omega_space(0.0)) - 7.292115147e-5) < 1e-13
