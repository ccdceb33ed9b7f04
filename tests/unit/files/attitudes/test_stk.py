"""STK attitude files: rows that AGI publishes as examples, and files made from scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from tumbling import BODY, CALENDAR, MOTION, NAMED, START, TIMES, check, columns

HEAD = """stk.v.5.0
# comment
BEGIN Attitude
NumberOfAttitudePoints  41
ScenarioEpoch           21 Nov 2026 00:00:00.000000000
BlockingFactor          20
InterpolationOrder      1
CentralBody             Earth
CoordinateAxes          J2000
"""


def rows(numbers):
    return "".join(f"{t:.9e} {' '.join(f'{x:.16e}' for x in row)}\n" for t, row in zip(TIMES, numbers, strict=True))


def whole(name, numbers, more=""):
    return f"{HEAD}{more}{name}\n\n{rows(numbers)}END Attitude\n"


QUATERNIONS = columns("QUATERNION")
WHOLE = whole("AttitudeTimeQuatAngVels", columns("QUATERNION/ANGVEL"))


@pytest.fixture
def read(reads):
    return reads(pt.files.read_stk_attitude, "a.a")


def test_formats(read):
    for text, rate in (
        (WHOLE, 1e-13),
        (WHOLE.replace("Attitude", "ATTITUDE").replace("\n", "\r\n"), 1e-13),
        (whole("AttitudeTimeQuaternions", QUATERNIONS), None),
        (whole("AttitudeTimeQuaternions", QUATERNIONS).replace("END Attitude\n", ""), None),
        (whole("AttitudeTimeQuatScalarFirst", QUATERNIONS[:, [3, 0, 1, 2]]), None),
        (whole("AttitudeTimeEulerAngles", columns("EULER_ANGLE"), "Sequence 312\n"), None),
    ):
        table = read(text)
        check(table, 1e-12, rate)
        assert (table.reference_frame, table.calendar) == ("ICRF", pt.Calendar("2026-11-21T00:00:00.000000000", "UTC"))


def test_published_rows_say_the_direction(read):
    """The example of AttitudeTimeQuatAngVels: six degrees a second about z, by rates and quaternions."""
    text = """stk.v.5.0
BEGIN Attitude
ScenarioEpoch           1 Jun 2002 12:00:00.000000000
CoordinateAxes J2000
AttitudeTimeQuatAngVels
0.000000000000e+000 -2.4e-017 0.000000000000e+000 0.000000000000e+000 1.000000e+000 4.8e-017 -4.0e-17 6.000000e+000
1.000000000000e+001 -2.1e-017 1.2e-017 5.000000000000e-001 8.660254037844e-001 3.6e-017 2.4e-17 6.000000e+000
2.000000000000e+001 -1.2e-017 2.1e-017 8.660254037844e-001 5.000000000000e-001 2.1e-017 -1.1e-17 6.000000e+000
END Attitude
"""
    table = read(text)
    turned = (table.attitude[0].inv() * table.attitude[1]).as_rotvec() / 10
    np.testing.assert_allclose(turned, table.omega_body[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(table.omega_body[0], (0, 0, np.pi / 30), rtol=0, atol=1e-15)
    assert table.calendar.zero == "2002-06-01T12:00:00.000000000"


def test_euler_sequence_is_about_axes_that_turn_along(read):
    text = HEAD.replace("41", "1") + "Sequence 321\nAttitudeTimeEulerAngles\n0 30 45 60\nEND Attitude\n"
    expected = Rotation.from_euler("ZYX", (30, 45, 60), degrees=True)
    np.testing.assert_allclose(read(text).attitude.as_matrix()[0], expected.as_matrix(), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"a\.a must begin with stk\.v\. and a version, got ''"),
        (WHOLE.replace("BEGIN Attitude", "BEGIN Ephemeris"), r"a\.a must have a block BEGIN Attitude"),
        (
            WHOLE.replace("QuatAngVels", "YPRAngles"),
            r"must hold AttitudeTimeQuaternions, .*, got 'AttitudeTimeYPRAngles'",
        ),
        (HEAD, r"must hold AttitudeTimeQuaternions, .*, got none"),
        (HEAD + "END Attitude\n", r"a\.a, line 10 must be a keyword and its value"),
        (WHOLE.replace("J2000", "Fixed"), r"CoordinateAxes in .*a\.a must be one of ICRF, .*, got 'Fixed'"),
        (WHOLE + WHOLE.partition("\n")[2], r"a\.a, line 55 must be absent after END Attitude, got 'BEGIN Attitude'\.$"),
        (
            WHOLE.replace("CentralBody ", "CoordinateAxes ICRF\nCentralBody "),
            r"a\.a, line 10 must not repeat COORDINATEAXES, got 'J2000' after 'ICRF'\. Remove one of them\.$",
        ),
        (WHOLE.replace("CoordinateAxes", "Axes"), r"a\.a must have CoordinateAxes, got none"),
        (WHOLE.replace("ScenarioEpoch", "Epoch"), r"a\.a must have ScenarioEpoch, got none"),
        (WHOLE.replace("21 Nov", "31 Nov"), r"ScenarioEpoch in .* must be a date such as 1 Jul 2005"),
        (WHOLE.replace("21 Nov", "21 Foo"), r"ScenarioEpoch in .* must be a date such as 1 Jul 2005 12:00:00\.00"),
        (WHOLE.replace("CentralBody", "TimeFormat"), r"TimeFormat in .* must be EpSec, got 'Earth'"),
        (
            WHOLE[:3000],
            r"a\.a(, line \d+ must have numbers for time, Q1, .*| must have NumberOfAttitudePoints rows, '41')",
        ),
        (
            WHOLE.replace("  41", "  42"),
            r"a\.a must have NumberOfAttitudePoints rows, '42', got .* 41 rows\. The file is not",
        ),
        (
            WHOLE.replace("NumberOfAttitudePoints  41\n", "").replace("END", ""),
            r"line 52 must have numbers for time, Q1, Q2, Q3, QC, ANGVEL_X",
        ),
        (WHOLE.replace("e-01 ", "e-01x ", 1), r"a\.a, line 12 must have a number for Q"),
        (WHOLE.replace("e-01 ", "e+00 ", 1), r"a\.a, line 12 must have a quaternion of unit norm"),
        (
            WHOLE.replace("2.500000000e-01 ", "0 ", 1),
            r"line 13 must be later than the row before, got t = 0 after t = 0\.",
        ),
        (whole("AttitudeTimeEulerAngles", columns("EULER_ANGLE")), r"a\.a must have Sequence, got none"),
        (b"\xff\xfe", r"must be text in UTF-8"),
    ],
)
def test_bad_files(read, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(text)


@pytest.mark.parametrize("rates", [True, False])
def test_written_motion_comes_back(tmp_path, rates):
    path = pt.files.write_stk_attitude(MOTION, tmp_path / "m.a", **NAMED, rates=rates)
    table = pt.files.read_stk_attitude(path, calendar=CALENDAR)
    check(table, 2e-15, 1e-15 if rates else None)
    assert pt.files.read_stk_attitude(path).calendar == pt.Calendar("2026-11-20T23:59:23.000000000", "UTC")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        pt.files.write_stk_attitude(MOTION, path, **NAMED)


def test_days_and_axes(tmp_path):
    days = pt.Calendar("2026-11-21T00:00:00", "UTC", "d")
    motion = pt.free_motion(BODY, START, TIMES / 864)
    path = pt.files.write_stk_attitude(
        motion, tmp_path / "m.a", calendar=days, reference_frame="TEME", central_body="Mars"
    )
    assert "CentralBody Mars\nCoordinateAxes TEMEOfDate\n" in path.read_text()
    table = pt.files.read_stk_attitude(path)
    np.testing.assert_allclose(table.times, 100 * TIMES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(table.omega_body, motion.omega_body / 86400, rtol=1e-14)
    with pytest.raises(ValueError, match=r"^reference_frame must be a name that STK defines, got MCI\.$"):
        pt.files.write_stk_attitude(motion, tmp_path / "n.a", calendar=days, reference_frame="MCI")
