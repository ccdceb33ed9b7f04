"""Light curves in the format ALCDEF."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.observables.readings import Readings

DAYS = pt.Calendar("2011-09-13T00:00:00", "TDB", "d")

HEAD = """STARTMETADATA
OBJECTNUMBER=1
OBJECTNAME=Ceres
MPCDESIG={}
SESSIONDATE=2011-09-13
LTCAPP=NONE
COMMENT=first line
COMMENT=second = line
DELIMITER=PIPE
COMPMAG1=+7.091
EPOCH=J2000.0
EPOCH=J2000.0
ENDMETADATA
""".format(" ")
ROWS = "DATA=2455817.735937|7.328|0.004\nDATA=2455817.736235|7.317|0.003\n"
TEXT = f"{HEAD}{ROWS}ENDDATA\n"


class Magnitude(pt.Observable):
    light_time: bool = True

    def reading(self, instant):
        return instant.omega_body[0]


OBSERVABLE = Magnitude()


@pytest.fixture
def read(reads):
    return lambda text, observable=OBSERVABLE, **options: reads(pt.files.read_alcdef, "a.txt")(
        text, observable, **options
    )


def test_a_block(read):
    (found,) = read(TEXT, calendar=DAYS)
    # 2455817.735937 UTC is 05:39:44.9568, and TT is 34 s + 32.184 s ahead; TDB is within 2 ms of TT.
    assert 86400 * found.times[0] == pytest.approx(5 * 3600 + 39 * 60 + 44.9568 + 66.184, rel=0, abs=2e-3)
    assert 86400 * np.diff(found.times)[0] == pytest.approx(86400 * 0.000298, rel=0, abs=1e-8)
    assert found.values.tolist() == [7.328, 7.317]
    assert found.sigma.tolist() == [0.004, 0.003]
    assert (found.name, found.attributes["units"]) == ("Ceres 2011-09-13", "mag")
    assert found.attributes["COMMENT"] == "first line\nsecond = line"
    assert found.attributes["MPCDESIG"] == ""


def test_the_default_calendar_counts_days_from_a_midnight(read):
    assert read(TEXT)[0].calendar == DAYS


@pytest.mark.parametrize(
    ("word", "mark"), [("PIPE", "|"), ("TAB", "\t"), ("COMMA", ","), ("SEMICOLON", ";"), ("pipe", "|")]
)
def test_delimiters_and_optional_columns(read, word, mark):
    text = TEXT.replace("PIPE", word)
    rows = {
        "": ROWS,
        "without errors": ROWS.replace("|0.004", "").replace("|0.003", ""),
        "with airmass": ROWS.replace("|0.004", "|0.004|1.2").replace("|0.003", "|0.003|1.3"),
        "with an empty airmass": ROWS.replace("|0.004", "|0.004|").replace("|0.003", "|0.003|"),
    }
    for name, each in rows.items():
        (found,) = read(text.replace(ROWS, each.replace("|", mark)), calendar=DAYS)
        assert found.values.tolist() == [7.328, 7.317]
        assert (found.sigma is None) == (name == "without errors")


def test_blocks_need_no_end_of_data(read):
    found = read(HEAD + ROWS + HEAD + ROWS.replace("817", "818"), calendar=DAYS)
    assert [each.times[0] // 1 for each in found] == [0, 1]


def test_errors_of_zero_are_unknown(read):
    with pytest.warns(UserWarning, match=r"^errors of the block from .* should be positive, got 0\. The readings have"):
        (found,) = read(TEXT.replace("0.003", "0.000"))
    assert found.sigma is None


def test_times_without_light_time(read):
    corrected = TEXT.replace("LTCAPP=NONE", "LTCAPP=POINT")
    with pytest.raises(ValueError, match=r"must be NONE for an observable with light_time=True, got 'POINT'\. Pass"):
        read(corrected)
    assert read(corrected, Magnitude(light_time=False))[0].times.size == 2


@given(
    rows=st.lists(
        st.tuples(st.integers(-(10**9), 10**9), st.floats(-30, 30), st.floats(1e-4, 9)), min_size=1, max_size=6
    ),
    blocks=st.integers(1, 3),
)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_what_was_read_comes_back_bit_for_bit(tmp_path_factory, rows, blocks):
    folder = tmp_path_factory.mktemp("alcdef")
    times, values, sigma = np.array(sorted(rows)).T
    times = times * 1e-6  # d, up to 1000
    made = [
        Readings(Magnitude(), times, values + i, sigma, name=f"night {i}", calendar=DAYS, attributes={"units": "mag"})
        for i in range(blocks)
    ]
    first = pt.files.read_alcdef(pt.files.write_alcdef(made, folder / "a.txt"), Magnitude(), calendar=DAYS)
    again = pt.files.read_alcdef(pt.files.write_alcdef(first, folder / "b.txt"), Magnitude(), calendar=DAYS)
    for one, other, third in zip(made, first, again, strict=True):
        assert np.array_equal(one.values, other.values)
        assert np.array_equal(one.sigma, other.sigma)
        # Two roundings of a time up to 1000 d have 1.1e-13 d each, and dates are counted in steps of 1e-10 s.
        np.testing.assert_allclose(86400 * other.times, 86400 * one.times, rtol=0, atol=2e-8)
        np.testing.assert_allclose(86400 * third.times, 86400 * other.times, rtol=0, atol=2e-8)
        assert np.array_equal(third.values, other.values)
        assert third.attributes == other.attributes


def test_dates_of_six_decimals_come_back_bit_for_bit(tmp_path, read):
    found = read(TEXT)
    text = pt.files.write_alcdef(found, tmp_path / "b.txt", metadata={"CONTACTNAME": "A. Name"}).read_text()
    assert ROWS in text
    assert "CONTACTNAME=A. Name\n" in text
    assert "COMMENT=first line\nCOMMENT=second = line\n" in text
    again = pt.files.read_alcdef(tmp_path / "b.txt", Magnitude())
    assert np.array_equal(again[0].times, found[0].times)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", r"a\.txt must have a block of ALCDEF that begins with STARTMETADATA, got none\.$"),
        ("147\n21 0\n", r"a\.txt, line 1 must begin a block of ALCDEF with STARTMETADATA, got '147'\. Is it another"),
        (HEAD.replace("ENDMETADATA\n", ""), r"must end after a block of data, got no ENDMETADATA in the block from"),
        (HEAD, r"a\.txt, line 1 must have lines DATA=JD\|magnitude, got none\.$"),
        (TEXT + HEAD + ROWS, r"must end with ENDDATA as others do, got none\. Is the file truncated\?$"),
        (TEXT.replace("ENDMETADATA\n", ""), r"line 13 must follow ENDMETADATA, got 'DATA=2455817"),
        (HEAD.replace("ENDMETADATA\n", "") + TEXT, r"line 13 must follow a block of data, got no ENDMETADATA"),
        (TEXT.replace("|7.328", "|x"), r"line 14 must have a number for magnitude, got 'x'\.$"),
        (TEXT.replace("|0.004", "|nan"), r"line 14 must have a number for error, got 'nan'\.$"),
        (TEXT.replace("|0.003", ""), r"line 15 must have JD and magnitude, error, got '2455817\.736235 7\.317'\.$"),
        (TEXT.replace("|", ","), r"line 14 must have JD, magnitude and optionally error and airmass, separated by"),
        (TEXT.replace("2455817.735937", "2455817.x"), r"line 14 must have a Julian date for JD, got '2455817\.x'\.$"),
        (
            TEXT.replace("2455817.", "55817."),
            r"must have a Julian date of the years 1 to 9999, got '55817\.735937'\. A",
        ),
        (TEXT.replace("735937", "836235"), r"line 15 must not be earlier than the row before, got JD .*6235 after JD"),
        (TEXT.replace("2455817", "2415817"), r"must have|1960 or later in UTC"),
        (TEXT.replace("PIPE", "BAR"), r"DELIMITER of the block from .* must be one of PIPE, TAB, .*, got 'BAR'\.$"),
        (TEXT.replace("MPCDESIG= ", "OBJECTNAME=Vesta"), r"line 4 must not repeat OBJECTNAME, got 'Vesta' after"),
        (TEXT.replace("MPCDESIG= ", "MPC DESIG=1"), r"line 4 must have a key of capital letters and digits, got"),
        (TEXT.replace("MPCDESIG= ", "no pair"), r"line 4 must be KEY=VALUE, STARTMETADATA or ENDDATA, got 'no pair'"),
        (TEXT.replace("ENDDATA", "FILTER=R"), r"line 16 must be DATA=\.\.\., ENDDATA or STARTMETADATA, got 'FILTER=R'"),
        (TEXT + "FILTER=R\n", r"line 17 must be KEY=VALUE, STARTMETADATA or ENDDATA, got 'FILTER=R'\.$"),
    ],
)
def test_bad_files_end_in_one_sentence(read, content, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        read(content)
    assert "\n" not in str(caught.value)


class Rates(pt.Observable):
    components = ("x", "y", "z")

    def reading(self, instant):
        return instant.omega_body


def test_what_is_not_a_magnitude(read, tmp_path):
    with pytest.raises(ValueError, match=r"^observable must read one number, got the components x, y, z\."):
        read(TEXT, Rates())
    times, mags = [0.0, 1.0], {"units": "mag"}
    wrong = {
        r"^readings must not be empty, got none\.$": [],
        "^readings must be magnitudes, in mag, for ALCDEF, got a in the unit none": [
            Readings(Magnitude(), times, times, name="a", calendar=DAYS)
        ],
        "^times of a must have a calendar, got none": [Readings(Magnitude(), times, times, name="a", attributes=mags)],
        r"^readings must be present at all times, got none of a at t = 1\.": [
            Readings(Magnitude(), times, [1.0, np.nan], name="a", calendar=DAYS, attributes=mags)
        ],
    }
    for sentence, readings in wrong.items():
        with pytest.raises(ValueError, match=sentence):
            pt.files.write_alcdef(readings, tmp_path / "a.txt")
    whole = [Readings(Magnitude(), times, times, calendar=DAYS, attributes=mags)]
    for metadata in ({"a b": "c"}, {"FILTER": "R\nV"}, {"FILTER": "R" * 300}):
        with pytest.raises(ValueError, match=re.escape("metadata must be keys of capital letters and values of one")):
            pt.files.write_alcdef(whole, tmp_path / "a.txt", metadata=metadata)
