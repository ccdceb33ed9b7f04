"""Spins in the format of DAMIT."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt

TEXT = "  251   -63    5.27025\n 2433827.771536  10\n0.5 0.1 -0.5\n0.1\n"
HOURS = pt.Calendar("2000-01-01T12:00:00", "TDB", "h")
OBLIQUITY = np.radians(84381.406 / 3600)
"""Obliquity of the ecliptic of J2000 (IAU 2006)."""


@pytest.fixture
def read(reads):
    return reads(pt.files.read_damit_spin, "spin.txt")


def test_a_spin(read):
    spin = read(TEXT, calendar=HOURS)
    np.testing.assert_allclose(np.degrees([spin.longitude, spin.latitude, spin.angle]), [251, -63, 10], rtol=1e-15)
    assert spin.period == 5.27025
    assert spin.epoch == -425213.483136  # 24 (2433827.771536 - 2451545)
    assert (spin.law.a, spin.law.d, spin.law.k, spin.law.c) == (0.5, 0.1, -0.5, 0.1)
    assert "pole: longitude 251 deg, latitude -63 deg" in repr(spin)


def test_the_default_calendar_counts_hours_from_a_midnight(read):
    spin = read("251 -63 5.27025\n2433827.771536 10\n")
    assert spin.calendar == pt.Calendar("1951-06-30T00:00:00", "TDB", "h")
    assert spin.epoch == pytest.approx(24 * 0.271536, rel=1e-14, abs=0)
    assert spin.law is None


@pytest.mark.parametrize("unit", ["s", "min", "h", "d"])
def test_the_rotation_is_the_formula_of_the_database(read, unit):
    """Durech et al. 2010: Rz(lambda) Ry(90 deg - beta) Rz(phi0 + 2 pi (t - t0)/P), and the ecliptic."""
    spin = read(TEXT, calendar=pt.Calendar("2000-01-01T12:00:00", "TDB", unit))
    days = 1234.5
    per_day = {"s": 86400, "min": 1440, "h": 24, "d": 1}[unit]
    angle = 10 + 360 * days * 24 / 5.27025
    ecliptic = Rotation.from_euler("ZYZ", [251, 90 + 63, angle % 360], degrees=True)
    expected = Rotation.from_euler("X", OBLIQUITY) * ecliptic
    found = Rotation.from_quat(spin.rotation.quaternion(spin.epoch + days * per_day), scalar_first=True)
    # The ecliptic of VSOP2013 is within 0.07 arcseconds of the IAU's, and the angle has 3.5e4 rad.
    assert (expected.inv() * found).magnitude() < 5e-7


numbers = st.floats(-1e3, 1e3).map(lambda x: round(x, 6))


@given(
    pole=st.tuples(numbers, st.floats(-90, 90).map(lambda x: round(x, 6)), numbers),
    period=st.floats(0.01, 1e4).map(lambda x: round(x, 8)),
    days=st.integers(-9000, 9000),
    law=st.one_of(st.none(), st.tuples(numbers, st.floats(1e-3, 10), numbers, st.floats(0, 5))),
    unit=st.sampled_from(["s", "h", "d"]),
)
@settings(max_examples=40, deadline=None)
def test_what_was_read_comes_back_bit_for_bit(tmp_path_factory, pole, period, days, law, unit):
    folder = tmp_path_factory.mktemp("spin")
    longitude, latitude, angle = pole
    lines = [f"{longitude} {latitude} {period}", f"{2451545 + days}.25 {angle}"]
    lines += [] if law is None else [f"{law[0]!r} {law[1]!r} {law[2]!r}", repr(law[3])]
    (folder / "a.txt").write_text("\n".join(lines))
    calendar = pt.Calendar("2000-01-01T12:00:00", "TDB", unit)
    first = pt.files.read_damit_spin(folder / "a.txt", calendar=calendar)
    again = pt.files.read_damit_spin(pt.files.write_damit_spin(first, folder / "b.txt"), calendar=calendar)
    names = ("longitude", "latitude", "period", "epoch", "angle")
    assert [getattr(first, name) for name in names] == [getattr(again, name) for name in names]
    assert repr(first.law) == repr(again.law)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", r"spin\.txt must be a spin of DAMIT in 2 or 4 lines, got 0\.$"),
        ("251 -63 5.27\n", r"spin\.txt must be a spin of DAMIT in 2 or 4 lines, got 1\.$"),
        (TEXT + "1\n", r"spin\.txt must be a spin of DAMIT in 2 or 4 lines, got 5\.$"),
        ("21 0\n2433915.386 1.02\n", r"spin\.txt, line 1 must have lambda, beta, period, got '21 0'\.$"),
        (TEXT.replace("5.27025", "5.27025 0"), r"line 1 must have lambda, beta, period, got '251 -63 5\.27025 0'\.$"),
        (TEXT.replace("5.27025", "0"), r"line 1 must have a positive period in hours, got '0'\.$"),
        (TEXT.replace("-63", "-93"), r"line 1 must have a latitude from -90 to 90 deg, got '-93'\.$"),
        (TEXT.replace("-63", "nan"), r"spin\.txt must have a number for beta, got 'nan'\.$"),
        (TEXT.replace("2433827.771536", "33827.27"), r"line 2 must have a Julian date of the years 1 to 9999, got"),
        (TEXT.replace("0.5 0.1", "0.5 0"), r"spin\.txt: d must be positive, got 0\.0"),
    ],
)
def test_bad_files_end_in_one_sentence(read, content, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        read(content)
    assert "\n" not in str(caught.value)


def test_arguments_are_checked(read):
    spin = read(TEXT)
    with pytest.raises(ValueError, match=r"^period must be positive, got -1\.0"):
        pt.files.DamitSpin(0.0, 0.0, -1.0, 0.0, 0.0, HOURS)
    with pytest.raises(TypeError, match="calendar must be a Calendar"):
        pt.files.DamitSpin(0.0, 0.0, 1.0, 0.0, 0.0, "2000")
    with pytest.raises(AttributeError):
        spin.period = 3.0
