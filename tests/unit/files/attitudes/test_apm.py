"""Attitude Parameter Messages, laid out as in CCSDS 504.0-B-1 and B-2."""

import numpy as np
import pytest

import poinsot as pt
from tumbling import BODY, CALENDAR, START, dated

STATE = BODY.state(START.quaternion, omega_body=(0.3, 0.4, 0.5), time=3.5)
NAMED = {"calendar": CALENDAR, "reference_frame": "EME2000"}
ROTATION = STATE.attitude
OMEGA = np.array((0.3, 0.4, 0.5))
QX, QY, QZ, QC = ROTATION.as_quat().tolist()

HEAD = """CCSDS_APM_VERS = 2.0
CREATION_DATE = 2003-09-30T19:23:57
ORIGINATOR = GSFC
COMMENT GEOCENTRIC
OBJECT_NAME = TRMM
OBJECT_ID = 1997-009A
CENTER_NAME = EARTH
TIME_SYSTEM = TAI
EPOCH = 2026-11-21T00:00:03.5
"""

QUAT = f"""QUAT_START
COMMENT attitude
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
Q1 = {QX!r}
Q2 = {QY!r}
Q3 = {QZ!r}
QC = {QC!r}
QUAT_STOP
"""

EARTH_FIXED = QUAT.replace("EME2000", "ITRF1997")

X, Y, Z = np.degrees(OMEGA).tolist()
ANGVEL = f"""ANGVEL_START
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
ANGVEL_FRAME = SC_BODY_1
ANGVEL_X = {X!r} [deg/s]
ANGVEL_Y = {Y!r} [deg/s]
ANGVEL_Z = {Z!r} [deg/s]
ANGVEL_STOP
"""

INERTIA = """INERTIA_START
INERTIA_REF_FRAME = SC_BODY_1
IXX = 5.0 [kg*m**2]
IYY = 6.0 [kg*m**2]
IZZ = 7.0 [kg*m**2]
IXY = -0.3 [kg*m**2]
IXZ = 0.4 [kg*m**2]
IYZ = -0.5 [kg*m**2]
INERTIA_STOP
MAN_START
MAN_EPOCH_START = 2026-11-21T00:00:05
MAN_DURATION = 3 [s]
MAN_REF_FRAME = EME2000
MAN_TOR_X = -1.25 [N*m]
MAN_STOP
"""

WHOLE = HEAD + EARTH_FIXED + QUAT + ANGVEL + INERTIA

DOT = 0.5 * np.array([*(QC * OMEGA + np.cross((QX, QY, QZ), OMEGA)), -np.dot((QX, QY, QZ), OMEGA)])

V1 = HEAD.replace("2.0", "1.0", 1) + (
    "Q_FRAME_A = EME2000\nQ_FRAME_B = SC_BODY_1\nQ_DIR = A2B\n"
    f"QC = {QC!r}\nQ1 = {QX!r}\nQ2 = {QY!r}\nQ3 = {QZ!r}\n"
    + "".join(
        f"{key}_DOT = {value!r} [1/s]\n" for key, value in zip(("Q1", "Q2", "Q3", "QC"), DOT.tolist(), strict=True)
    )
    + "INERTIA_REF_FRAME = SC_BODY_1\nI11 = 5.0 [kg*m**2]\nI22 = 6.0\nI33 = 7.0\nI12 = 0.3\nI13 = -0.4\nI23 = 0.5\n"
    "MAN_EPOCH_START = 2026-11-21T00:00:05\n"
)


@pytest.fixture
def read(reads):
    return reads(pt.files.read_apm, "a.apm")


def check(table, body, rates=True):
    np.testing.assert_allclose(table.attitude.as_matrix()[0], ROTATION.as_matrix(), rtol=0, atol=1e-14)
    assert table.calendar.time(f"{dated(3.5)} TAI") == table.times[0]
    assert (table.reference_frame, table.body_frame) == ("ICRF", "SC_BODY_1")
    if rates:
        np.testing.assert_allclose(table.omega_body[0], OMEGA, rtol=0, atol=1e-14)
    else:
        assert table.omega_body is None
    np.testing.assert_allclose(body.inertia, BODY.inertia, rtol=0, atol=1e-13)


def test_blocks_of_version_2(read):
    table, body = read(WHOLE)
    check(table, body)
    state = table.state(body)
    np.testing.assert_allclose(abs(state.conjugate_momenta), abs(STATE.conjugate_momenta), rtol=0, atol=1e-13)
    check(*read(HEAD + QUAT + INERTIA), rates=False)
    assert read(HEAD + QUAT)[1] is None
    with pytest.warns(
        UserWarning,
        match=r"a\.apm, line 19 should have INERTIA_REF_FRAME SC_BODY_1, got 'INSTRUMENT_A'\. The block is ignored\.$",
    ):
        assert read(HEAD + QUAT + INERTIA.replace("SC_BODY_1", "INSTRUMENT_A"))[1] is None
    hours = pt.Calendar("2026-11-21T00:00:00", "TAI", "h")
    again, _ = read(WHOLE, calendar=hours)
    assert again.times[0] == pytest.approx(3.5 / 3600, rel=1e-15, abs=0)
    np.testing.assert_allclose(again.omega_body[0], 3600 * OMEGA, rtol=1e-14)


def test_angular_velocity_the_other_way_round_and_along_the_other_frame(read):
    along = np.degrees(ROTATION.apply(OMEGA))
    other = ANGVEL.replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = EME2000")
    for component, value in zip((X, Y, Z), along.tolist(), strict=True):
        other = other.replace(repr(component), repr(value))
    check(*read(HEAD + QUAT + other + INERTIA))
    swapped = ANGVEL.replace("FRAME_A = EME2000\nREF_FRAME_B = SC_BODY_1", "FRAME_A = SC_BODY_1\nREF_FRAME_B = EME2000")
    swapped = swapped.replace("ANGVEL_X = ", "ANGVEL_X = -").replace("ANGVEL_Y = ", "ANGVEL_Y = -")
    check(*read(HEAD + QUAT + swapped.replace("ANGVEL_Z = ", "ANGVEL_Z = -") + INERTIA))


@pytest.mark.parametrize("frame", ["EME2000", "J2000", "ICRF", "gcrf", "Eme 2000"])
@pytest.mark.parametrize("body", ["SC_BODY_1", "sc_body_1", "Sc_Body_1"])
def test_names_of_axes_in_any_case_and_by_their_aliases(read, frame, body):
    head, body_line = ANGVEL.replace("EME2000", frame).replace("SC_BODY_1", body), INERTIA.replace("SC_BODY_1", body)
    check(*read(HEAD + QUAT + head + body_line))
    check(*read(HEAD + head + body_line + QUAT))
    check(*read(HEAD + head.replace(f"REF_FRAME_A = {frame}", "REF_FRAME_A = TEME") + QUAT + body_line))


EULER = "EULER_START\nREF_FRAME_A = J2000\nREF_FRAME_B = SC_BODY_1\nEULER_ROT_SEQ = XYZ\n" + "".join(
    f"ANGLE_{i} = {a!r} [deg]\n" for i, a in enumerate(ROTATION.as_euler("XYZ", degrees=True).tolist(), start=1)
)
AHEAD = [(ROTATION * type(ROTATION).from_rotvec(h * OMEGA)).as_euler("XYZ", degrees=True) for h in (1e-5, -1e-5)]
EULER_DOT = "".join(
    f"ANGLE_{i}_DOT = {a!r} [deg/s]\n" for i, a in enumerate(((AHEAD[0] - AHEAD[1]) / 2e-5).tolist(), start=1)
)


def test_rates_of_another_block(read):
    """Before, the rates of any block but the first and ANGVEL were lost."""
    table, _ = read(HEAD + QUAT + EULER + EULER_DOT + "EULER_STOP\n")
    np.testing.assert_allclose(table.omega_body[0], OMEGA, rtol=0, atol=1e-9)
    dots = "".join(
        f"{key}_DOT = {value!r} [1/s]\n" for key, value in zip(("Q1", "Q2", "Q3", "QC"), DOT.tolist(), strict=True)
    )
    table, _ = read(HEAD + EULER + "EULER_STOP\n" + QUAT.replace("QUAT_STOP", dots + "QUAT_STOP"))
    np.testing.assert_allclose(table.omega_body[0], OMEGA, rtol=0, atol=1e-14)
    axis = ROTATION.apply((0, 0, 1))
    around = (ROTATION * type(ROTATION).identity()).as_euler("ZXZ", degrees=True)[2]
    spin = (
        "SPIN_START\nREF_FRAME_A = EME2000\nREF_FRAME_B = SC_BODY_1\n"
        f"SPIN_ALPHA = {np.degrees(np.arctan2(axis[1], axis[0]))}\nSPIN_DELTA = {np.degrees(np.arcsin(axis[2]))}\n"
        f"SPIN_ANGLE = {around}\nSPIN_ANGLE_VEL = 2\nSPIN_STOP\n"
    )
    table, _ = read(HEAD + QUAT + spin)
    np.testing.assert_allclose(table.omega_body[0], (0, 0, np.radians(2)), rtol=0, atol=1e-14)
    for text in (QUAT + spin + ANGVEL, spin + ANGVEL + QUAT):  # ANGVEL has all components
        np.testing.assert_allclose(read(HEAD + text)[0].omega_body[0], OMEGA, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            QUAT + EULER.replace("ANGLE_1 = -", "ANGLE_1 = ") + "EULER_STOP\n",
            r"line 19 must state the attitude of \S+, line 10, got one that is \S+ rad away\. Remove one of the "
            r"blocks\.$",
        ),
        (
            QUAT + ANGVEL + EULER + EULER_DOT.replace("ANGLE_1_DOT = -", "ANGLE_1_DOT = ") + "EULER_STOP\n",
            r"line 27 must state the angular velocity of \S+, line 19, got one that differs by \S+ %\. Remove "
            r"one of them",
        ),
        (QUAT + ANGVEL + ANGVEL.replace("ANGVEL_X = ", "ANGVEL_X = 9"), r"line 27 must state the angular velocity of"),
        (EULER + EULER_DOT.partition("\n")[2] + "EULER_STOP\n", r"a\.apm, line 10 must have ANGLE_1_DOT, got none\.$"),
        (QUAT + INERTIA + INERTIA, r"line 34 must not repeat the inertia of \S+, line 19, got two blocks\. Remove one"),
        (
            QUAT.replace("QUAT_STOP", "ANGVEL_X = 1\nQUAT_STOP"),
            r"line 18 must have a key of its block and version, got 'ANGVEL_X'\. Move it to its block, or remove it\.$",
        ),
        (
            QUAT.replace("QUAT_STOP", "Q_DIR = B2A\nQUAT_STOP"),
            r"line 18 must have a key of its block and version, got 'Q_DIR'",
        ),
        (
            QUAT.replace("QUAT_STOP", "Q1_DOTT = 0\nQUAT_STOP"),
            r"line 18 must have a key of the format, got 'Q1_DOTT'\. Did you mean 'Q1_DOT'\?$",
        ),
        (
            QUAT.replace("QUAT_STOP", "Q1 = 0.25\nQUAT_STOP"),
            r"line 18 must not repeat Q1, got '0\.25' after '\S+'\. Remove one of them\.$",
        ),
        ("EPOCH = 2026-11-21T00:00:04\n" + QUAT, r"line 10 must not repeat EPOCH, got '2026-11-21T00:00:04' after "),
    ],
)
def test_statements_that_disagree_or_have_no_place(read, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(HEAD + text)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            QUAT + ANGVEL.replace("EME2000", "ITRF2000"),
            r"line 19 should be about SC_BODY_1 in axes that do not rotate, got 'ITRF2000' and 'SC_BODY_1'\. "
            r"Its rates are "
            r"ignored\.$",
        ),
        (
            QUAT + QUAT.replace("SC_BODY_1", "CAMERA"),
            r"line 19 should be about SC_BODY_1 in ICRF, got CAMERA in ICRF\. The block is ignored\.$",
        ),
        (
            "FOO_BAR = 7\n" + QUAT,
            r"a\.apm, line 10 should have a key of the format, got 'FOO_BAR', which is ignored\.$",
        ),
        (
            "OBJECT_NAMES = 7\n" + QUAT,
            r"line 10 should have a key of the format, got 'OBJECT_NAMES', which is ignored\. Did you mean "
            r"'OBJECT_NAME'\?$",
        ),
    ],
)
def test_what_is_ignored_gives_a_warning(read, text, sentence):
    with pytest.warns(UserWarning, match=sentence):
        table, _ = read(HEAD + text)
    assert table.omega_body is None
    np.testing.assert_allclose(table.attitude.as_matrix()[0], ROTATION.as_matrix(), rtol=0, atol=1e-14)


def test_user_defined_keys_pass(read):
    check(*read(HEAD + "USER_DEFINED_MASS = 7\n" + QUAT + ANGVEL + INERTIA))


def test_attitude_from_the_body_and_derivatives(read):
    text = QUAT.replace("EME2000", "X").replace("SC_BODY_1", "EME2000").replace("X\n", "SC_BODY_1\n")
    for x in (QX, QY, QZ):
        text = text.replace(repr(x), repr(-x))
    rates = zip(("Q1", "Q2", "Q3", "QC"), (DOT * [-1, -1, -1, 1]).tolist(), strict=True)
    dots = "".join(f"{key}_DOT = {value!r} [1/s]\n" for key, value in rates)
    check(*read(HEAD + text.replace("QUAT_STOP", dots + "QUAT_STOP") + INERTIA))


@pytest.mark.parametrize("sequence", ["ZXZ", "XYZ", "YXY"])
def test_euler_blocks(read, sequence):
    ahead = (ROTATION * type(ROTATION).from_rotvec(h * OMEGA) for h in (1e-5, -1e-5))
    plus, minus = (rotation.as_euler(sequence, degrees=True) for rotation in ahead)
    angles, rates = ROTATION.as_euler(sequence, degrees=True), (plus - minus) / 2e-5
    block = f"EULER_START\nREF_FRAME_A = EME2000\nREF_FRAME_B = SC_BODY_1\nEULER_ROT_SEQ = {sequence}\n"
    block += "".join(f"ANGLE_{i} = {a!r} [deg]\n" for i, a in enumerate(angles.tolist(), start=1))
    dots = "".join(f"ANGLE_{i}_DOT = {a!r} [deg/s]\n" for i, a in enumerate(rates.tolist(), start=1))
    check(*read(HEAD + block + "EULER_STOP\n" + ANGVEL + INERTIA))
    table, body = read(HEAD + block + dots + "EULER_STOP\n" + INERTIA)
    np.testing.assert_allclose(table.omega_body[0], OMEGA, rtol=0, atol=1e-9)
    check(pt.files.AttitudeTable(table.times, table.quaternion, None, table.calendar, "ICRF"), body, rates=False)

    digits = sequence.translate(str.maketrans("XYZ", "123"))
    old = f"EULER_FRAME_A = SC_BODY_1\nEULER_FRAME_B = EME2000\nEULER_DIR = B2A\nEULER_ROT_SEQ = {digits}\n"
    old += "RATE_FRAME = EULER_FRAME_A\n"
    old += "".join(f"{axis}_ANGLE = {a!r} [deg]\n" for axis, a in zip(sequence, angles.tolist(), strict=True))
    old += "".join(f"{axis}_RATE = 1.0 [deg/s]\n" for axis in sequence)
    inertia = V1[V1.index("INERTIA_REF") :]
    with pytest.warns(UserWarning, match=r"a\.apm, line 10 should have rates that the standard defines, got rates of"):
        check(*read(HEAD.replace("2.0", "1.0", 1) + old + inertia), rates=False)
    with pytest.raises(ValueError, match=r"must have its angles in the order '\d{3}', got '\d{3}'"):
        read(HEAD.replace("2.0", "1.0", 1) + old.replace(digits, "231" if digits != "231" else "132"))


def test_spin_block(read):
    block = "SPIN_START\nREF_FRAME_A = EME2000\nREF_FRAME_B = SC_BODY_1\nSPIN_ALPHA = 0\nSPIN_DELTA = 80 [deg]\n"
    block += "SPIN_ANGLE = 45\nSPIN_ANGLE_VEL = 1 [deg/s]\nSPIN_STOP\n"
    table, _ = read(HEAD + block)
    np.testing.assert_allclose(table.quaternion[0], (0.3812, 0.0805, 0.0334, 0.9204), rtol=0, atol=5e-5)
    np.testing.assert_allclose(table.omega_body[0], (0, 0, np.radians(1)), rtol=0, atol=1e-16)


def test_version_1(read):
    check(*read(V1))
    other = V1.replace("Q_DIR = A2B", "Q_DIR = B2A").replace("A = EME2000", "A = SC_BODY_1")
    check(*read(other.replace("Q_FRAME_B = SC_BODY_1", "Q_FRAME_B = EME2000")))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"a\.apm must begin with CCSDS_APM_VERS = 1\.0 or 2\.0, got ''"),
        (HEAD, r"a\.apm must have an attitude \(quaternion, Euler angles or spin\), got none"),
        (HEAD + INERTIA, r"a\.apm must have an attitude"),
        (HEAD + EARTH_FIXED, r"a\.apm, line 10 must be the body and a frame .* got 'ITRF1997', which rotates"),
        (WHOLE.replace("EPOCH = 2026-11-21T00:00:03.5\n", ""), r"a\.apm must have EPOCH, got none"),
        (WHOLE.replace("TIME_SYSTEM = TAI\n", ""), r"a\.apm must have TIME_SYSTEM, got none"),
        (WHOLE.replace("T00:00:03.5", "T00:00:0x"), r"a\.apm, line 9: epoch must be a date"),
        (WHOLE.replace("QUAT_STOP\n", ""), r"must be KEY = VALUE or QUAT_STOP, got 'QUAT_START'"),
        (HEAD + QUAT[:-10], r"a\.apm, line 10 must be followed by QUAT_STOP, got the end of the file"),
        (WHOLE.replace(f"QC = {QC!r}\n", ""), r"a\.apm, line 18 must have QC, got none"),
        (WHOLE.replace(f"QC = {QC!r}", "QC = nan"), r"line 2\d must have a number for QC, got 'nan'"),
        (WHOLE.replace(f"QC = {QC!r}", "QC = 0.1"), r"must have a quaternion of unit norm"),
        (WHOLE.replace("[deg/s]", "[rad/s]", 1), r"must have ANGVEL_X in deg/s, got 'rad/s'"),
        (WHOLE.replace("[kg*m**2]", "[g]", 1), r"must have IXX in kg\*m\*\*2, got 'g'"),
        (WHOLE.replace("IZZ = 7.0", "IZZ = 70.0"), r"a\.apm, line \d+: moments must satisfy the triangle inequality"),
        (
            WHOLE.replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = FOO"),
            r"must have ANGVEL_FRAME EME2000 or SC_BODY_1",
        ),
        (V1.replace("Q_DIR = A2B", "Q_DIR = AB"), r"a\.apm, line 12 must have Q_DIR A2B or B2A, got 'AB'"),
        ("<apm version='2.0'/>", r"a\.apm must hold one segment, got 0"),
        (b"\xff\xfe", r"must be text in UTF-8"),
    ],
)
def test_bad_files(read, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(text)


@pytest.mark.parametrize("ending", ["apm", "xml"])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_written_state_comes_back(tmp_path, ending, version):
    path = pt.files.write_apm(BODY, STATE, tmp_path / f"a.{ending}", **NAMED, version=version)
    check(*pt.files.read_apm(path))
    with pytest.raises(FileExistsError, match="overwrite=True replaces it"):
        pt.files.write_apm(BODY, STATE, path, **NAMED)
    pt.files.write_apm(BODY, STATE, path, **NAMED, version=version, overwrite=True)
    assert len(list(tmp_path.iterdir())) == 1


def test_bad_arguments(tmp_path):
    path = tmp_path / "a.apm"
    with pytest.raises(TypeError, match=r"^state must be a State, got PosixPath\. The order is write_apm\(body, sta"):
        pt.files.write_apm(BODY, path, STATE, **NAMED)
    two = BODY.state(np.array([(1.0, 0, 0, 0)] * 2), omega_body=(0, 0, 1.0))
    with pytest.raises(ValueError, match=r"^state must be one state of one body, got an ensemble\.$"):
        pt.files.write_apm(BODY, two, path, **NAMED)
    with pytest.raises(ValueError, match=r"^reference_frame must be one of ICRF"):
        pt.files.write_apm(BODY, STATE, path, calendar=CALENDAR, reference_frame="LVLH")
    assert not path.exists()
