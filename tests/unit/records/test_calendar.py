"""Dates and times: leap seconds, scales, precision, bad input, and no network."""

import datetime as dt
import fractions
import socket
import subprocess
import sys
from decimal import Decimal

import numpy as np
import pytest
from astropy.time import Time
from astropy.utils import iers
from hypothesis import given
from hypothesis import strategies as st

from poinsot.records.calendar import Calendar, julian_dates, span_of, times_of_julian_dates

J2000 = Calendar("2000-01-01T12:00:00", "TDB")
LEAP = Calendar("2016-12-31T23:59:58", "UTC")


def test_numbers_are_times_already():
    assert J2000.time(12.5) == 12.5
    assert isinstance(J2000.time(3), float)
    np.testing.assert_array_equal(J2000.time([1, 2.5]), [1.0, 2.5])


def test_leap_second_is_a_second_like_any_other():
    dates = ["2016-12-31T23:59:59 UTC", "2016-12-31T23:59:60Z", "2016-12-31T23:59:60.25Z", "2017-01-01T00:00:00 UTC"]
    np.testing.assert_array_equal(LEAP.time(dates), [1.0, 2.0, 2.25, 3.0])
    np.testing.assert_array_equal(LEAP.date([2.0, 3.0]).isot, ["2016-12-31T23:59:60.000", "2017-01-01T00:00:00.000"])
    assert LEAP.date(2.0).scale == "utc"


@pytest.mark.parametrize(
    ("date", "seconds"),
    [
        ("2017-01-01T00:00:00 UTC", 0.0),
        ("2017-01-01T00:00:37 TAI", 0.0),  # TAI - UTC after the leap second of 2016
        ("2017-01-01T00:00:18 GPS", 0.0),  # TAI - GPS = 19 s
        ("2017-01-01T00:01:09.184 TT", 0.0),  # TT - TAI = 32.184 s
        ("2016-12-31T23:59:59 UTC", -2.0),
        ("2017-001T00:00:01 UTC", 1.0),
        ("2016-366T23:59:60.5 utc", -0.5),
        ("2017-01-01 UTC", 0.0),
        ("2017-01-01 00:01Z", 60.0),
    ],
)
def test_scales(date, seconds):
    assert Calendar("2017-01-01T00:00:00", "UTC").time(date) == pytest.approx(seconds, abs=2e-10)


def test_barycentric_time_swings_by_less_than_two_milliseconds():
    # TDB - TT = 1.657 ms sin g + 0.022 ms sin(L - L_J) (Explanatory Supplement 2.222-1), to 30 microseconds.
    dates = [f"2020-{month:02}-03T00:00:00" for month in range(1, 13)]
    tdb, tt = (np.array(J2000.time([f"{date} {scale}" for date in dates])) for scale in ("TDB", "TT"))
    days = tdb / 86400
    g = np.radians(357.53 + 0.98560028 * days)
    expected = 0.001657 * np.sin(g) + 0.000022 * np.sin(np.radians(246.11 + 0.90251792 * days))
    np.testing.assert_allclose(tt - tdb, expected, rtol=0, atol=3e-5)


@given(
    st.datetimes(dt.datetime(1975, 1, 1), dt.datetime(2060, 1, 1)),
    st.integers(-40 * 86400 * 10**9, 40 * 86400 * 10**9),
)
def test_differences_are_exact_to_half_a_nanosecond(zero, nanoseconds):
    calendar = Calendar(zero.isoformat(timespec="microseconds"), "TAI")
    later = (zero + dt.timedelta(microseconds=nanoseconds // 1000)).isoformat(timespec="microseconds")
    time = calendar.time(f"{later}{nanoseconds % 1000:03} TAI")
    exact = fractions.Fraction(nanoseconds, 10**9)
    assert abs(fractions.Fraction(time) - exact) < fractions.Fraction(5, 10**10)
    back = calendar.date(time) - Time(f"{later}{nanoseconds % 1000:03}", scale="tai")
    assert abs(back.to_value("s")) < 5e-10


def test_decades_are_right_to_the_rounding_of_a_float():
    # 9496 days between the two dates, and 5 leap seconds.
    assert Calendar("2000-01-01T00:00:00", "UTC").time("2025-12-31T00:00:00 UTC") == 9496 * 86400 + 5


@pytest.mark.parametrize(("unit", "seconds"), [("s", 1), ("min", 60), ("h", 3600), ("d", 86400)])
def test_units(unit, seconds):
    calendar = Calendar("2026-01-01", "TDB", unit)
    assert calendar.time("2026-01-04T12:00:00 TDB") == pytest.approx(3.5 * 86400 / seconds, rel=1e-15, abs=0)
    assert calendar.date(86400 / seconds).isot == "2026-01-02T00:00:00.000"


def test_times_of_another_calendar():
    times = np.array([0.0, 1000.0])
    np.testing.assert_array_equal(J2000.converted(times, J2000), times)
    other = Calendar("2000-01-01T13:00:00", "TDB")
    np.testing.assert_array_equal(J2000.converted(times, other), times + 3600)
    np.testing.assert_allclose(J2000.converted(times, LEAP), J2000.time(LEAP.date(times)), rtol=0)


def test_instants_of_astropy_in_any_shape():
    instants = Time(["2017-01-01T00:00:00", "2017-01-02T00:00:00"], scale="utc")
    np.testing.assert_array_equal(LEAP.time(instants), [3.0, 86403.0])
    np.testing.assert_array_equal(LEAP.time(list(instants)), [3.0, 86403.0])
    assert LEAP.time(instants[0]) == 3.0
    assert LEAP.time(np.array([["2017-01-01Z", "2017-01-02Z"]])).shape == (1, 2)


def test_one_instant_has_one_calendar():
    assert Calendar("2026-01-01", "UTC") == Calendar("2026-001T00:00", "UTC")
    assert hash(Calendar("2026-01-01", "UTC")) == hash(Calendar("2026-01-01T00:00:00", "UTC"))
    assert Calendar("2026-01-01", "UTC") != Calendar("2026-01-01", "TDB")


def test_span():
    assert span_of(LEAP, 0, "2017-01-01Z") == (0.0, 3.0)
    with pytest.raises(ValueError, match=r"^stop must be later than start, got 1 and 2\.$"):
        span_of(LEAP, 2, 1)
    with pytest.raises(ValueError, match=r"^start and stop must be single instants, got \[0, 1\] and 2\.$"):
        span_of(LEAP, [0, 1], 2)
    with pytest.raises(ValueError, match=r"^calendar must count seconds for an orbit in km and km/s, got .*'d'\)"):
        span_of(Calendar("2026-01-01", "UTC", "d"), 0, 1)
    with pytest.raises(TypeError, match=r"^calendar must be a Calendar, got str\.$"):
        span_of("2026-01-01", 0, 1)


@pytest.mark.parametrize(
    ("epoch", "sentence"),
    [
        (
            "2026-11-21T00:00:00",
            r"must state its time scale, got '2026-11-21T00:00:00'\. Write '.* UTC', or TDB, TT\.$",
        ),
        ("2026-11-21T00:00:00 EST", r"must be in one of the scales UTC, TAI, GPS, TT, TDB, TCB, TCG, got .* EST'"),
        ("2026-11-21T00:00:00 UT1", "must be in one of the scales"),
        ("tomorrow", r"must be a date such as '2026-11-21T00:00:00 UTC', got 'tomorrow'\.$"),
        ("2026-11-21T00:00:00+00:00", "must be a date such as"),
        ("", "must be a date such as"),
        ("2026-02-30 UTC", "must be a date that exists in UTC"),
        ("2026-01-01T23:59:60 UTC", "must be a date that exists in UTC"),
        ("2016-12-31T23:59:60 TAI", "must be a date that exists in TAI"),
        ("2025-366 TT", "must be a date that exists"),
        ("2025-000 TT", "must be a date that exists"),
        ("0000-000 TT", "must be a date that exists"),
        ("1959-12-31 UTC", r"must be in 1960 or later in UTC, got '1959-12-31 UTC'\. Say it in TT\.$"),
    ],
)
def test_bad_dates(epoch, sentence):
    with pytest.raises(ValueError, match=f"^epoch {sentence}"):
        J2000.time(epoch)
    with pytest.raises(ValueError, match=f"^epoch {sentence}"):
        J2000.time(["2026-01-01 UTC", epoch])


def test_rows_of_unequal_length():
    with pytest.raises(ValueError, match=r"^epoch must be an array of dates, got rows of unequal length"):
        J2000.time([["2026-01-01 UTC"], ["2026-01-01 UTC", "2026-01-02 UTC"]])
    with pytest.raises(TypeError, match=r"^epoch must be real numbers, got list"):
        J2000.time([[1.0], [2.0, 3.0]])


def test_datetimes_with_a_time_zone():
    east = dt.timezone(dt.timedelta(hours=2))
    dates = [dt.datetime(2017, 1, 1, 2, 0, 0, 500_000, east), dt.datetime(2017, 1, 1, tzinfo=dt.UTC)]
    assert LEAP.time(dates[0]) == 3.5
    np.testing.assert_array_equal(LEAP.time(dates), [3.5, 3.0])


@pytest.mark.parametrize("date", [dt.datetime(2026, 1, 1), dt.date(2026, 1, 1), np.datetime64("2026-01-01T00:00:00.5")])
def test_dates_without_a_scale(date):
    for given_date in (date, [date], np.array([date])):
        with pytest.raises(
            ValueError, match=r"^epoch must state its time scale, got '2026-01-01.*'\. Write '2026-01-01.* UTC'"
        ):
            J2000.time(given_date)


@pytest.mark.parametrize("epoch", [None, dt.timedelta(1), 1j, np.timedelta64(1, "s"), True])
def test_what_is_neither_date_nor_number(epoch):
    with pytest.raises(TypeError, match="epoch must be real numbers"):
        J2000.time(epoch)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("2026-01-01", "EST"), "scale must be one of UTC, TAI, GPS, TT, TDB, TCB, TCG, got 'EST'"),
        (("2026-01-01", None), "scale must be one of"),
        (("2026-01-01", "UTC", "yr"), "unit must be one of s, min, h, d, got 'yr'"),
        (("2026-01-01 UTC", "UTC"), "zero must be a date without a scale"),
        ((5.0, "UTC"), "zero must be text such as '2026-11-21T00:00:00', got 5.0."),
        ((dt.datetime(2026, 1, 1), "UTC"), "zero must be text such as"),
    ],
)
def test_bad_calendars(arguments, sentence):
    with pytest.raises((ValueError, TypeError), match=f"^{sentence}"):
        Calendar(*arguments)


@given(st.text() | st.from_regex(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(\.\d+)? (UTC|TDB|TAI|GPS)", fullmatch=True))
def test_any_text_is_a_date_or_a_sentence(text):
    message = "epoch must be finite"
    try:
        assert np.isfinite(J2000.time(text))
    except ValueError as error:
        message = str(error)
    assert message.startswith("epoch must ")


def test_far_dates_come_without_a_warning():
    assert J2000.time("2100-01-01T00:00:00 UTC") == pytest.approx(36524.5 * 86400 + 69.184, abs=0.01)
    assert J2000.date(3e9).scale == "tdb"
    assert LEAP.date(3e9).scale == "utc"
    with pytest.raises(
        ValueError, match=r"^time must be within 30000 years of 2016-12-31T23:59:58 to be a date, got 1e"
    ):
        LEAP.date(1e16)


def test_nothing_is_downloaded_and_the_settings_stay(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a connection was opened")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    before = iers.conf.auto_download
    assert LEAP.time(Time("2017-01-01T00:00:00", scale="utc")) == 3.0
    assert LEAP.time(Time("2017-01-01T00:00:00", scale="ut1")) == pytest.approx(3.0 - 0.59, abs=0.02)  # UT1 - UTC
    assert iers.conf.auto_download == before


def test_numbers_need_no_astropy_and_dates_say_how_to_get_it():
    code = (
        "import sys; sys.modules['astropy'] = None\n"
        "from poinsot.records.calendar import Calendar\n"
        "calendar = Calendar('2026-01-01', 'UTC')\n"
        "assert calendar.time(5.0) == 5.0\n"
        "try: calendar.time('2026-01-02Z')\n"
        "except ImportError as error: print(error)"
    )
    message = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert message == "astropy must be installed for dates, got none. `pip install 'poinsot[sky]'` brings it.\n"


def itself():
    inner = []
    inner.append(inner)
    return inner


@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
def test_times_in_a_matrix_keep_its_shape():
    assert Calendar("2026-11-21T00:00:00", "TAI").time(np.asmatrix([[1.0, 2.0]])).tolist() == [[1.0, 2.0]]


@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
def test_dates_in_a_matrix_are_dates():
    dates = np.asmatrix([["2026-11-21T00:00:01 TAI", "2026-11-21T00:00:02 TAI"]])
    assert Calendar("2026-11-21T00:00:00", "TAI").time(dates).tolist() == [[1.0, 2.0]]


def test_a_list_that_contains_itself_is_no_list_of_dates():
    with pytest.raises(TypeError, match=r"^epoch must be real numbers, got list \[\[\.\.\.\]\]\.$"):
        Calendar("2026-11-21T00:00:00", "TAI").time(itself())


def read_again(times, scale, calendar):
    return times_of_julian_dates([Decimal(text) for text in julian_dates(times, scale, calendar)], scale, calendar)


@given(times=st.lists(st.floats(-1e5, 1e5).filter(lambda t: t == 0 or abs(t) > 1e-9), min_size=1, max_size=5))
@pytest.mark.parametrize("unit", ["s", "min", "h", "d"])
def test_julian_dates_in_the_scale_of_a_calendar_restore_times_exactly(unit, times):
    calendar = Calendar("2012-10-10T01:02:03.5", "TDB", unit)
    assert read_again(np.array(times), "TDB", calendar).tolist() == times


@given(seed=st.integers(0, 2**32))
@pytest.mark.parametrize("calendar", [Calendar("2012-10-10", "TDB", "d"), Calendar("2012-10-10", "UTC", "h"), J2000])
def test_julian_dates_in_another_scale_restore_times_to_a_rounding_of_dates(calendar, seed):
    times = np.random.default_rng(seed).uniform(-500, 500, 5)
    seconds = {"s": 1, "h": 3600, "d": 86400}[calendar.unit]
    # Times are counted in steps of 1e-10 s, and days of 1e-16 have 9e-12 s.
    np.testing.assert_allclose(seconds * read_again(times, "UTC", calendar), seconds * times, rtol=1e-15, atol=1.2e-10)


@pytest.mark.parametrize("scale", ["UTC", "TAI", "TT", "TDB"])
def test_julian_dates_are_those_of_astropy(scale):
    calendar = Calendar("2011-09-13", "TDB", "d")
    (time,) = times_of_julian_dates([Decimal("2455817.735937")], scale, calendar)
    instant = Time(2455817.0, 0.735937, format="jd", scale=scale.lower())
    assert time == pytest.approx((instant.tdb - Time("2011-09-13", scale="tdb")).jd, rel=0, abs=1e-15)
    assert julian_dates(np.array([time]), scale, calendar) == ["2455817.735937"]


def test_utc_differs_from_tdb_by_leap_seconds_and_32_seconds():
    calendar, date = Calendar("2011-09-13", "TDB"), [Decimal("2455817.5")]
    late = times_of_julian_dates(date, "UTC", calendar) - times_of_julian_dates(date, "TDB", calendar)
    assert late[0] == pytest.approx(34 + 32.184, rel=0, abs=2e-3)  # TDB is within 2 ms of TT


def test_julian_dates_of_utc_begin_in_1960():
    with pytest.raises(ValueError, match=r"^Julian dates must be in 1960 or later in UTC, got 2400000\.5\.$"):
        times_of_julian_dates([Decimal("2400000.5")], "UTC", J2000)
