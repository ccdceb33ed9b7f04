"""Quaternions as comma-separated values."""

import numpy as np
import pytest

import poinsot as pt
from tumbling import CALENDAR, MOTION, NAMED, TIMES, check, columns

SAYS = "# order: scalar first\n# direction: body to reference\n"
RATE = "# rate: rad per unit of time, inertial, along the body axes\n"


def text(numbers, says=SAYS, names="t,q0,q1,q2,q3"):
    inner = "".join(
        f"{','.join(map(repr, (t, *row)))}\n" for t, row in zip(TIMES.tolist(), numbers.tolist(), strict=True)
    )
    return f"{says}{names}\n{inner}"


LAST = columns("QUATERNION")
FIRST = LAST[:, [3, 0, 1, 2]]
WITH_RATES = np.concatenate([FIRST, MOTION.omega_body], axis=1)
WHOLE = text(WITH_RATES, SAYS + RATE, "t,q0,q1,q2,q3,omega_1,omega_2,omega_3")


@pytest.fixture
def read(reads):
    return reads(pt.files.read_quaternion_csv, "a.csv")


def test_orders_and_directions(read):
    check(read(text(FIRST)), 1e-14, None)
    check(read(text(LAST, SAYS.replace("first", "last"), "time,qx,qy,qz,qw")), 1e-14, None)
    check(read(text(FIRST * [1, -1, -1, -1], SAYS.replace("body to reference", "reference to body"))), 1e-14, None)
    table = read(WHOLE)
    check(table, 1e-14, 0)
    assert (table.calendar, table.reference_frame) == (None, "space axes")


def test_calendars(read):
    dated = "# time: h from 2026-11-21T00:00:00 TAI\n"
    table = read(dated + WHOLE)
    assert table.calendar == pt.Calendar("2026-11-21T00:00:00", "TAI", "h")
    seconds = read(dated + WHOLE, calendar=CALENDAR)
    np.testing.assert_allclose(seconds.times, 3600 * TIMES, rtol=1e-14)
    np.testing.assert_allclose(seconds.omega_body, MOTION.omega_body / 3600, rtol=1e-14)
    assert read(WHOLE, calendar=CALENDAR).calendar is CALENDAR


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (text(FIRST, ""), r"a\.csv must say its order, scalar first or scalar last, got none\. Write # order"),
        (
            text(FIRST, SAYS[:22]),
            r"a\.csv must say its direction, body to reference or reference to body, got none",
        ),
        (text(FIRST, SAYS.replace("first", "middle")), r"must say its order, .*, got 'scalar middle'"),
        (
            text(FIRST, names="t,q1,q2,q3,q0"),
            r"line 3 must name the components of the quaternion in the order 1, 2, 3 or x, y, z, scalar first, "
            r"got 't,q1,",
        ),
        (
            text(LAST, SAYS.replace("first", "last"), "t,qw,qx,qy,qz"),
            r"line 3 must name the components of the quaternion",
        ),
        (
            WHOLE.replace("omega_1,omega_2", "omega_2,omega_1"),
            r"line 4 must name the components of the angular velocity in the order 1, 2, 3",
        ),
        (
            SAYS.replace("scalar first", "scalar last") + WHOLE,
            r"a\.csv, line 3 must not repeat order, got 'scalar first'",
        ),
        (
            "# reference_fram: ICRF\n" + WHOLE,
            r"line 1 must have a key of the format, got 'reference_fram'\. Did you mean",
        ),
        (
            "# convention: JPL\n" + WHOLE,
            r"a\.csv must have the convention 'x_reference = q x_body q~, Ham.*, got 'JPL'\.$",
        ),
        (
            WHOLE + "# direction: reference to body\n",
            r"line 46 must come before the names of the columns, got '# direct",
        ),
        (WHOLE.replace(RATE, ""), r"line 3 must follow a line that defines the rates"),
        (WHOLE.replace(RATE, "# rate: deg\n"), r"line 4 must follow a line that defines the rates"),
        (WHOLE.replace("t,q0", "q0,t"), r"line 4 must name the columns, such as t,q0,q1,q2,q3 or"),
        (SAYS, r"a\.csv must have the names of columns and rows, got no rows"),
        (text(FIRST)[:-30], r"a\.csv, line 44 must have numbers for t|must have a number|quaternion of unit norm"),
        (text(FIRST).replace("0.25,", "0.0,", 1), r"a\.csv, line 5 must be later than the row before"),
        (text(FIRST).replace("0.25,", "inf,", 1), r"a\.csv, line 5 must have a number for t, got 'inf'"),
        (text(2 * FIRST), r"a\.csv, line \d+ must have a quaternion of unit norm"),
        ("# time: fortnights from now\n" + WHOLE, r"time in .*a\.csv must be a date such as s from 2026"),
        (b"\x00", r"must be text in UTF-8"),
    ],
)
def test_bad_files(read, content, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(content)


def test_written_motion_comes_back_with_all_digits(tmp_path):
    path = pt.files.write_quaternion_csv(MOTION, tmp_path / "m.csv")
    table = pt.files.read_quaternion_csv(path)
    assert np.array_equal(table.times, TIMES)
    assert np.array_equal(table.omega_body, MOTION.omega_body)
    np.testing.assert_allclose(table.quaternion, MOTION.quaternion, rtol=0, atol=1e-15)
    assert (table.calendar, table.reference_frame, table.body_frame) == (None, "space axes", "SC_BODY_1")
    named = pt.files.write_quaternion_csv(MOTION, tmp_path / "n.csv", **NAMED, body_frame="HUBBLE", rates=False)
    table = pt.files.read_quaternion_csv(named)
    assert (table.calendar, table.reference_frame, table.body_frame) == (CALENDAR, "ICRF", "HUBBLE")
    assert table.omega_body is None
    with pytest.raises(FileExistsError, match="overwrite=True"):
        pt.files.write_quaternion_csv(MOTION, path)
