"""Light curves in the format of DAMIT."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.observables import LightCurve, LommelSeeliger, Readings

TEXT = """2
3 0
2433915.386080481 1.021246e+00 -1.49250950 -0.20313009 -0.25692782 -0.49091309 -0.15648988 -0.25691486
2433915.401539481 1.018429e+00 -1.49243437 -0.20332590 -0.25693732 -0.49085471 -0.15642099 -0.25692433
2433915.401539481 1.030696e+00 -1.49243437 -0.20332590 -0.25693732 -0.49085471 -0.15642099 -0.25692433

1 1
2434000.5 0.9 -1.5 -0.2 -0.3 -0.5 -0.1 -0.2
"""
ROWS = [line.split() for line in TEXT.splitlines() if len(line.split()) == 8]
SHAPE, LAW = pt.shapes.Ellipsoid((17.0, 5.5, 5.0), density=2e12), LommelSeeliger(albedo=0.2)
DAYS = pt.Calendar("1951-09-25T00:00:00", "TDB", "d")
AU = 149597870.7


@pytest.fixture
def read(reads):
    return lambda text, **options: reads(pt.files.read_damit, "lc.txt")(text, SHAPE, LAW, **options)


def seen_along_ecliptic(orbit, time):
    """Position of the attractor from the body in au along the ecliptic axes, from the position along the ICRF."""
    obliquity = np.radians(84381.406 / 3600)  # IAU 2006
    c, s = np.cos(obliquity), np.sin(obliquity)
    x, y, z = (-float(x) / AU for x in orbit.position_at(time))
    return np.array([x, c * y + s * z, c * z - s * y])


def test_curves(read):
    first, second = read(TEXT, calendar=DAYS)
    assert first.times.tolist() == [0.886080481, 0.901539481, 0.901539481]
    assert first.values.tolist() == [1.021246, 1.018429, 1.030696]
    assert (first.sigma, first.name, first.attributes["calibrated"]) == (None, "curve 1", "0")
    assert (second.times.tolist(), second.attributes["calibrated"]) == ([86.0], "1")
    curve = first.observable
    assert (curve.kind, curve.light_time, curve.law) == ("relative", False, LAW)
    assert second.observable.law is LAW


def test_the_geometry_passes_through_the_data(read):
    for curve, rows in zip(read(TEXT, calendar=DAYS), (ROWS[:3], ROWS[3:]), strict=True):
        for time, row in zip(curve.times, rows, strict=True):
            # The ecliptic of VSOP2013 is within 0.07 arcseconds, 3.4e-7 rad, of the ecliptic of the IAU.
            for orbit, place in ((curve.observable.sun, row[2:5]), (curve.observable.observer, row[5:])):
                found = seen_along_ecliptic(orbit, time)
                np.testing.assert_allclose(found, np.array(place, dtype=float), rtol=0, atol=6e-7)


def test_the_geometry_is_smooth_between_the_data(read):
    (curve,) = read(
        "1\n4 0\n" + "".join(f"{2433915.5 + t} 1 {-1.5 + t**2} 0 0 -0.5 {0.1 * t} 0\n" for t in (0, 0.1, 0.101, 0.3))
    )
    t = np.linspace(0, 0.3, 301)
    x = np.array([seen_along_ecliptic(curve.observable.sun, time)[0] for time in t])
    assert np.all(np.diff(x) >= 0)
    assert np.max(np.abs(x + 1.5 - t**2)) < 0.3**2 / 8  # a chord of the longest interval is as far off


@given(
    rows=st.lists(
        st.tuples(st.integers(0, 10**9), st.floats(1e-3, 1e3), *[st.floats(0.1, 5).map(lambda x: round(x, 9))] * 6),
        min_size=1,
        max_size=6,
        unique_by=lambda row: row[0],
    ),
    curves=st.integers(1, 3),
    unit=st.sampled_from(["s", "h", "d"]),
)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_what_was_read_comes_back(tmp_path_factory, rows, curves, unit):
    folder = tmp_path_factory.mktemp("damit")
    lines = [" ".join((f"{2450000 + count * 1e-7:.7f}", *map(repr, row))) for count, *row in sorted(rows)]
    (folder / "a.txt").write_text("\n".join([str(curves), *[f"{len(rows)} 1", *lines] * curves]))
    calendar = pt.Calendar("1995-10-09T12:00:00", "TDB", unit)
    first = pt.files.read_damit(folder / "a.txt", SHAPE, LAW, calendar=calendar)
    pt.files.write_damit(first, folder / "b.txt")
    again = pt.files.read_damit(folder / "b.txt", SHAPE, LAW, calendar=calendar)
    before, after = ((folder / name).read_text().split() for name in ("a.txt", "b.txt"))
    np.testing.assert_allclose(list(map(float, after)), list(map(float, before)), rtol=1e-12, atol=0)
    for one, other in zip(first, again, strict=True):
        assert np.array_equal(one.times, other.times)
        assert np.array_equal(one.values, other.values)
        for name in ("sun", "observer"):
            read, back = (np.array(getattr(each.observable, name).position_at(one.times[-1])) for each in (one, other))
            # Rows 1e-7 d apart change by up to 5 au: some roundings of the polynomials between them.
            np.testing.assert_allclose(back, read, rtol=0, atol=1e-12 * np.linalg.norm(read))
        assert one.attributes == other.attributes


def test_scales(read):
    """UTC was 8 s behind TAI in 1972, so that TDB is 8 s + 32.184 s ahead, within 2 ms; see Calendar."""
    late = TEXT.replace("2433915", ["2441317", "5"][0]).replace("2434000", "2441500")
    for unit in ("s", "d"):
        calendar = pt.Calendar("1972-01-01T00:00:00", "UTC", unit)
        with pytest.raises(
            ValueError, match=r"^calendar must count in TDB as the light curves of DAMIT, got UTC\. Pass"
        ):
            read(late, calendar=calendar)
        tdb, utc = (read(late, calendar=calendar, scale=scale)[1].times[0] for scale in ("TDB", "UTC"))
        seconds = {"s": 1, "d": 86400}[unit]
        assert seconds * (utc - tdb) == pytest.approx(42.184 + 1, rel=0, abs=2e-3)  # a leap second on 1972-06-30
    with pytest.raises(ValueError, match=r"^scale must be one of TDB, TT, TAI, UTC, got 'UT1'\.$"):
        read(TEXT, scale="UT1")
    assert read(TEXT, calendar=pt.Calendar("1951-09-25T00:00:00", "TT", "d"))[0].times.size == 3


BEGINNING = TEXT.partition("\n\n")[0]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", r"lc\.txt must have the number of light curves, as files of DAMIT do, got ''\. Is it another format\?$"),
        ("STARTMETADATA\n", r"lc\.txt, line 1 must have the number of light curves, .* got 'STARTMETADATA'\. Is it"),
        ("8 12\n0 0 0\n", r"line 1 must have the number of light curves, as files of DAMIT do, got '8 12'"),
        ("0\n", r"line 1 must have the number of light curves"),
        (TEXT[2:], r"line 1 must have the number of light curves, as files of DAMIT do, got '3 0'"),
        (
            BEGINNING,
            r"lc\.txt must have the number of data of curve 2 of 2 and its flag, 0 or 1, got the end of the file",
        ),
        (TEXT.replace("1 1\n", "1 2\n"), r"line 7 must have the number of data of curve 2 of 2 .*, got '1 2'\.$"),
        (TEXT.replace("3 0\n", "2 0\n"), r"line 5 must have the number of data of curve 2 of 2 .*, got '2433915\.40"),
        (TEXT.replace("3 0\n", "4 0\n"), r"line 7 must have JD and brightness, Sun x, .* Earth z, got '1 1'\.$"),
        (
            TEXT.replace("1 1\n", "999999999 1\n"),
            r"lc\.txt must have 999999999 data in curve 2, got 1\. Is the file trunc",
        ),
        (TEXT + "1 2 3\n", r"line 9 must follow curve 2, the last one, with nothing, got more text\.$"),
        (TEXT.replace("0.9 ", "one "), r"line 8 must have a number for brightness, got 'one'\.$"),
        (TEXT.replace("0.9 ", "nan "), r"line 8 must have a number for brightness, got 'nan'\.$"),
        (TEXT.replace("0.9 ", "1e999 "), r"line 8 must have a number for brightness, got '1e999'\.$"),
        (
            TEXT.replace("2434000.5", "34000.5"),
            r"line 8 must have a Julian date of the years 1 to 9999, got '34000\.5'\. A",
        ),
        (
            TEXT.replace(".386080481", ".486080481"),
            r"line 4 must not be earlier than the row before, got JD 2433915\.401",
        ),
        (TEXT.replace("-1.5 -0.2 -0.3", "0 0 0"), r"line 8 must have a position of the Sun in au, got \(0, 0, 0\)\.$"),
        (
            TEXT.replace("-0.5 -0.1 -0.2", "1e9 0 0"),
            r"line 8 must have a position of the Earth in au, got \(1e\+09, 0, 0",
        ),
        (
            TEXT.replace("1.030696e+00 -1.49243437", "1.030696e+00 -1.48"),
            r"line 5 must have the position of the Sun of the row before at the same time, got another position\.$",
        ),
    ],
)
def test_bad_files_end_in_one_sentence(read, content, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        read(content)
    assert "\n" not in str(caught.value)


def test_arguments_are_checked(read):
    with pytest.raises(ValueError, match=r"^au must be positive, got 0\.0"):
        read(TEXT, au=0)
    with pytest.raises(ValueError, match=r"^sigma must be positive"):
        read(TEXT, sigma=0)
    assert float(read(TEXT, sigma=0.02)[0].sigma) == 0.02


def test_fluxes_are_written_at_unit_distances_and_without_light_time(tmp_path):
    """A body 2 au from the Sun and 1.5 au from the observer: F r^2 d^2, 499.004784 s earlier for each au."""
    sun, earth = (pt.orbits.FixedPosition(1.0, position=(-d * AU, 0, 0)) for d in (2.0, 1.5))
    curve = LightCurve(SHAPE, LAW, sun, earth)
    made = Readings(curve, [0.0, 100.0], [1e-20, 2e-20], calendar=pt.Calendar("2000-01-01T12:00:00", "TDB"))
    lines = pt.files.write_damit(made, tmp_path / "lc.txt").read_text().splitlines()
    assert lines[:2] == ["1", "2 1"]
    day, value, *place = map(float, lines[3].split())
    assert 86400 * (day - 2451545) == pytest.approx(100 - 1.5 * 499.004784, rel=0, abs=5e-5)  # 4e-10 d of a Julian date
    assert value == pytest.approx(2e-20 * 2.0**2 * 1.5**2, rel=1e-14, abs=0)
    np.testing.assert_allclose(place, [2, 0, 0, 1.5, 0, 0], rtol=0, atol=1e-12)


def test_what_is_not_a_flux(tmp_path):
    sun = pt.orbits.FixedPosition(1.0, position=(AU, 0, 0))
    light, mags = LightCurve(SHAPE, LAW, sun, sun), LightCurve(SHAPE, LAW, sun, sun, kind="magnitude")
    wrong = {
        r"^readings must not be empty, got none\.$": [],
        "^readings must be fluxes of a LightCurve, got LightCurve, LightCurve": [
            Readings(mags, [0.0], [1.0], calendar=DAYS)
        ],
        "^readings must be fluxes of a LightCurve, got Gyro, Gyro": [
            Readings(pt.observables.Gyro(), [0.0], [[1.0, 2, 3]], calendar=DAYS)
        ],
        "^times of LightCurve must have a calendar, got none": [Readings(light, [0.0], [1.0])],
        r"^readings must be present at all times, got none of": [Readings(light, [0.0], [np.nan], calendar=DAYS)],
        r"^readings must have values to be written, got a plan": [Readings(light, [0.0], calendar=DAYS)],
    }
    for sentence, readings in wrong.items():
        with pytest.raises(ValueError, match=sentence):
            pt.files.write_damit(readings, tmp_path / "lc.txt")
    assert not re.findall("lc", str([*tmp_path.iterdir()]))
