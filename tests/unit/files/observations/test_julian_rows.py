"""Rows that begin with a Julian date."""

from decimal import Decimal

import numpy as np
import pytest
from astropy.time import Time

from poinsot.files.observations.julian_rows import JulianRows, calendar_before, check_not_falling, iso_text, julian_date
from poinsot.records.calendar import Calendar


@pytest.mark.parametrize("date", ["2086303", "2299160.5", "2451545.0", "2455817.735937", "5373483.999"])
def test_texts_of_julian_dates_are_those_of_astropy(date):
    expected = Time(date, format="jd", scale="tt")
    assert iso_text(Decimal(date)) == expected.isot[:19]
    assert calendar_before(Decimal(date), "TT", "h") == Calendar(f"{expected.isot[:10]}T00:00:00", "TT", "h")


@pytest.mark.parametrize(
    "text", ["nan", "inf", "-1", "1e6", "2_455_817", "24558170.5", "2455817," + "0" * 50, "٢٤٥٥٨١٧", ""]
)
def test_what_is_no_julian_date(text):
    with pytest.raises(ValueError, match=r"^here must have a Julian date for JD, got "):
        julian_date(text, "here")


def test_modified_julian_dates_are_explained():
    sentence = (
        r"^here must have a Julian date of the years 1 to 9999, got '55817\.5'\. A modified Julian date is smaller"
    )
    with pytest.raises(ValueError, match=sentence):
        julian_date("55817.5", "here")


def test_rows_rise_or_repeat_a_time():
    rows = JulianRows("it", columns=("a",))
    for date in ("2455817.5", "2455817.5", "2455818"):
        rows.add_dated(f"line {date}", [date, "1"])
    assert rows.times("TDB", Calendar("2011-09-13", "TDB", "h")).tolist() == [0, 0, 12]
    with pytest.raises(ValueError, match=r"^last must not be earlier than the row before, got JD 2455817\.6 after JD"):
        rows.add_dated("last", ["2455817.6", "1"])
    with pytest.raises(ValueError, match=r"^last must have JD and a, got '2455819'\.$"):
        rows.add_dated("last", ["2455819"])
    check_not_falling(np.array([1.0, 1.0, 2.0]), ["a", "b", "c"])
    with pytest.raises(ValueError, match=r"^c must not be earlier than the row before, got t = 1 after 2\.$"):
        check_not_falling(np.array([1.0, 2.0, 1.0]), ["a", "b", "c"])
