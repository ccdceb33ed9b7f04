"""Readings as comma-separated values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.observables.readings import Readings

DAYS = pt.Calendar("2012-10-10T00:00:00", "TDB", "d")


class Rates(pt.Observable):
    components = ("x", "y", "z")
    noise: float = 0.0

    def reading(self, instant):
        return instant.omega_body


class Brightness(pt.Observable):
    def reading(self, instant):
        return instant.omega_body[0]


PHONE = "t_s,wx,wy,wz\n0.5,1,2,3\n0.625,1.5,2.5,-3.5\n0.625,1.5,,-3.5\n"
NAMES = ["t_s", "wx", "wy", "wz"]


@pytest.fixture
def read(reads):
    return reads(pt.files.read_readings_csv, "a.csv")


def test_named_columns(read):
    found = read(PHONE, Rates(noise=0.05), columns=NAMES)
    assert found.times.tolist() == [0.5, 0.625, 0.625]
    np.testing.assert_array_equal(found.values, [[1, 2, 3], [1.5, 2.5, -3.5], [1.5, np.nan, -3.5]])
    assert (float(found.sigma), found.calendar) == (0.05, None)
    turned = read("z, y ,x,t\n3,2,1,0.5\n", Rates())
    assert turned.values.tolist() == [[1, 2, 3]]
    assert turned.sigma is None


def test_standard_deviations(read):
    text = "t,value,sigma\n1,2,0.5\n2,3,0.25\n"
    assert read(text, Brightness()).sigma.tolist() == [0.5, 0.25]
    assert read(text.replace("sigma", "error"), Brightness(), columns=["t", "value", "error"]).sigma.tolist() == [
        0.5,
        0.25,
    ]
    assert float(read("# sigma: 0.5\n" + text.replace(",sigma", ",other"), Brightness()).sigma) == 0.5
    assert float(read(text.replace(",sigma", ",other"), Brightness(), sigma=2.0).sigma) == 2
    rates = read("t,x,y,z,sigma_x,sigma_y,sigma_z\n1,2,3,4,0.1,0.2,0.3\n", Rates())
    assert rates.sigma.tolist() == [[0.1, 0.2, 0.3]]


def test_calendars(read):
    text = "# time: h from 2012-10-10T00:00:00 UTC\n# unit: mag\n# readings: night 1\nt,value\n12,2\n13,3\n"
    own = read(text, Brightness())
    assert own.calendar == pt.Calendar("2012-10-10T00:00:00", "UTC", "h")
    assert (own.name, own.attributes["units"]) == ("night 1", "mag")
    later = read(text, Brightness(), calendar=DAYS)
    seconds = 12 * 3600 + 35 + 32.184  # TDB is within 2 ms of TT
    np.testing.assert_allclose(86400 * later.times, [seconds, seconds + 3600], rtol=0, atol=2e-3)
    assert read("# time_unit: min\nt,value\n1,2\n", Brightness()).attributes["time_units"] == "min"


numbers = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e14, max_value=1e14)


@given(
    rows=st.lists(st.tuples(numbers, numbers, numbers, numbers), min_size=1, max_size=5),
    sigma=st.one_of(st.none(), st.floats(1e-9, 1e9)),
    dated=st.booleans(),
    each=st.booleans(),
)
@settings(max_examples=50, deadline=None)
def test_readings_come_back_bit_for_bit(tmp_path_factory, rows, sigma, dated, each):
    table = np.array(sorted(rows))
    values = np.where(np.abs(table[:, 1:]) < 1e-3, np.nan, table[:, 1:])
    errors = np.abs(table[:, 1:]) + 1e-3 if each else sigma
    calendar = DAYS if dated else None
    made = Readings(
        Rates(), table[:, 0], values, errors, name="a, b", calendar=calendar, attributes={"units": "rad s-1"}
    )
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    back = pt.files.read_readings_csv(pt.files.write_readings_csv(made, path), Rates())
    assert np.array_equal(back.times, made.times)
    assert np.array_equal(back.values, made.values, equal_nan=True)
    assert (back.sigma is None) == (made.sigma is None)
    assert made.sigma is None or np.array_equal(back.sigma, made.sigma)
    assert (back.name, back.calendar, back.attributes) == (made.name, made.calendar, made.attributes)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", r"a\.csv must have the names of columns and rows, got no rows\.$"),
        ("t,value\n", r"a\.csv must have the names of columns and rows, got no rows\.$"),
        ("v 1 2 3\nf 1 2 3\n", r"a\.csv, line 1 must name the column 't' once, got none\."),
        ("t,valeu\n1,2\n", r"line 1 must name the column 'value' once, got none\. Did you mean 'valeu'\?"),
        ("t,value,t\n1,2,3\n", r"line 1 must name the column 't' once, got several\."),
        ("t,value\n1,2\n3\n", r"line 3 must have 2 cells, got 1\.$"),
        ("t,value\n1,2\n,3\n", r"line 3 must have a number for t, got ''\.$"),
        ("t,value\n1,2\n2,x\n", r"line 3 must have a number for value, got 'x'\.$"),
        ("t,value\n1,2\n2,inf\n", r"line 3 must have a number for value, got 'inf'\.$"),
        ("t,value\n1,2\n2,nan\n", r"line 3 must have a number for value, got 'nan'\.$"),
        (
            "t,value\n1,2\n0.5,3\n",
            r"line 3 must not be earlier than the row before, got t = 0\.5 after 1\.$",
        ),
        ("# time: d from yesterday TDB\nt,value\n1,2\n", r"time in .*a\.csv must be a date such as"),
        ("t,value\n# time: d from 2012-10-10 TDB\n1,2\n", r"line 2 must come before the names of the columns"),
        ("# sigma: 1\n# sigma: 2\nt,value\n1,2\n", r"line 2 must not repeat sigma, got '2' after '1'\."),
        ("t,value,sigma\n1,2,0\n", r"a\.csv: sigma must be positive, got 0\.0\."),
        ("t,value,sigma\n1,2,\n", r"a\.csv: sigma must be finite"),
    ],
)
def test_bad_files_end_in_one_sentence(read, content, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        read(content, Brightness())
    assert "\n" not in str(caught.value)


def test_wrong_columns(read):
    for columns in (["t_s", "wx"], ["t_s", "wx", "wy", "wz", "wz"], ["t_s", "wx", "wx", "wz"]):
        with pytest.raises(ValueError, match=r"^columns must be 4 or 7 different names: the time, x, y, z and their"):
            read(PHONE, Rates(), columns=columns)
    with pytest.raises(ValueError, match=r"^sigma must not be given for .*a\.csv, which states it, got both\.$"):
        read("# sigma: 1\nt,value\n1,2\n", Brightness(), sigma=1.0)


def test_what_is_not_written(tmp_path):
    plan = Readings(Brightness(), [0.0, 1.0])
    with pytest.raises(ValueError, match=r"^readings must have values to be written, got a plan of measurements\.$"):
        pt.files.write_readings_csv(plan, tmp_path / "a.csv")
    several = Readings(Brightness(), [0.0, 1.0], [[1.0, 2.0], [3.0, 4.0]])
    with pytest.raises(ValueError, match=r"^readings must be of one body, got 2 members\. Take"):
        pt.files.write_readings_csv(several, tmp_path / "a.csv")
    path = pt.files.write_readings_csv(several.isel(member=1), tmp_path / "a.csv")
    with pytest.raises(FileExistsError):
        pt.files.write_readings_csv(several.isel(member=1), path)
    assert pt.files.read_readings_csv(path, Brightness()).values.tolist() == [3, 4]


def test_arcs_of_a_recording(tmp_path):
    rows = [(0.5 * k, 0.1 * k, 1.0, -0.2) for k in range(9)]
    recording, cuts = tmp_path / "phone_round1_b.csv", tmp_path / "cuts.csv"
    recording.write_text("t_s,wx,wy,wz\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    cuts.write_text(
        "file,segment,cut_start_s,cut_end_s,keep,comment\nround1_a,0,0,4,,\nround1_b,0,0,1,false,hand\n"
        'round1_b,1,1.0,2.1,,"spin, fast"\nround1_b,2,3,4,true,\n'
    )
    gyro = pt.observables.Gyro(noise=0.05)
    first, second = pt.files.read_gyro_csv(recording, gyro, cuts=cuts)
    assert first.times.tolist() == [1.0, 1.5, 2.0]
    assert second.times.tolist() == [3.0, 3.5, 4.0]
    assert second.values[:, 0].tolist() == [0.1 * k for k in (6, 7, 8)]
    assert (first.name, float(first.sigma)) == ("round1_b 1", 0.05)
    assert first.attributes == {"units": "rad s-1", "frame": "body", "time_units": "s"}
    (whole,) = pt.files.read_gyro_csv(recording, gyro, sigma=0.1)
    assert (len(whole), float(whole.sigma), whole.name) == (9, 0.1, "phone_round1_b")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('"' + "a" * 200_000, r"must be comma-separated values: field larger than field limit \(131072\)\."),
        ("file,cut_start_s\n", "line 1 must name the columns file, cut_start_s, cut_end_s, keep, got no 'cut_end_s'"),
        ("file,cut_start_s,cut_end_s,keep\na,0\n", r"line 2 must have 4 cells, got 2\."),
        ("file,cut_start_s,cut_end_s,keep\na,0,x,\n", "line 2 must have a number for cut_end_s, got 'x'"),
        ("file,cut_start_s,cut_end_s,keep\na,0,1,no\n", "line 2 must have true, false or nothing for keep, got 'no'"),
        ("file,cut_start_s,cut_end_s,keep\na,7,8,\n", "line 2 must have readings between .* from 7 to 8"),
        ("file,cut_start_s,cut_end_s,keep\nb,0,1,\n", "must have a cut of 'a' to keep, got none"),
    ],
)
def test_wrong_cuts(tmp_path, content, message):
    (tmp_path / "a.csv").write_text("t_s,wx,wy,wz\n0,1,2,3\n1,1,2,3\n")
    (tmp_path / "cuts.csv").write_text(content)
    with pytest.raises(ValueError, match=message):
        pt.files.read_gyro_csv(tmp_path / "a.csv", pt.observables.Gyro(), cuts=tmp_path / "cuts.csv")
