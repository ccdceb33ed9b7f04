"""Attitude files judged by readers that are not ours: ccsds-ndm, Orekit where it is installed, parsers written here.

The conventions are those that the standard prints: M(Q1, Q2, Q3, QC) of CCSDS 504.0-B-2, annex F2, turns components
along A into those along B. The motion is a steady rotation about a fixed axis, in closed form.
"""

import datetime as dt
import math
import shutil

import numpy as np
import pytest

import poinsot as pt

AXIS = np.array((2.0, -3.0, 6.0)) / 7
RATE, TILT = 0.31, np.array((0.5, -0.5, 0.1, 0.7))
TIMES = np.linspace(0.0, 12.0, 25)
SPHERE = pt.Body((2.0, 2.0, 2.0))
MOTION = pt.free_motion(SPHERE, SPHERE.state(TILT, omega_body=RATE * AXIS), TIMES)
NAMED = {"calendar": pt.Calendar("2026-11-21T00:00:00", "TAI"), "reference_frame": "EME2000"}


def cross_matrix(v):
    return np.array([(0, -v[2], v[1]), (v[2], 0, -v[0]), (-v[1], v[0], 0)])


def space_to_body(t):
    """By Rodrigues' formula: the start, then a turn about an axis of the body."""
    w, x, y, z = TILT
    start = np.eye(3) + 2 * w * cross_matrix((x, y, z)) + 2 * cross_matrix((x, y, z)) @ cross_matrix((x, y, z))
    K = cross_matrix(AXIS)
    turn = np.eye(3) + math.sin(RATE * t) * K + (1 - math.cos(RATE * t)) * K @ K
    return (start @ turn).T


def matrix_of_the_standard(q1, q2, q3, qc):
    return np.array(
        [
            (q1**2 - q2**2 - q3**2 + qc**2, 2 * (q1 * q2 + q3 * qc), 2 * (q1 * q3 - q2 * qc)),
            (2 * (q1 * q2 - q3 * qc), -(q1**2) + q2**2 - q3**2 + qc**2, 2 * (q2 * q3 + q1 * qc)),
            (2 * (q1 * q3 + q2 * qc), 2 * (q2 * q3 - q1 * qc), -(q1**2) - q2**2 + q3**2 + qc**2),
        ]
    )


def check_quaternion(quaternion, t):
    found = matrix_of_the_standard(quaternion.q1, quaternion.q2, quaternion.q3, quaternion.qc)
    np.testing.assert_allclose(found, space_to_body(t), rtol=0, atol=1e-14)


def instant(text):
    return (dt.datetime.fromisoformat(text[:26]) - dt.datetime(2026, 11, 21)).total_seconds()


def test_example_of_the_standard():
    """Annex F2.2: B is A turned by 90 degrees about z, so that the x axis of B is (0, 1, 0) in A."""
    np.testing.assert_allclose(
        matrix_of_the_standard(0, 0, 0.5**0.5, 0.5**0.5) @ (1, 0, 0), (0, -1, 0), rtol=0, atol=1e-15
    )


def parsed(path):
    io = pytest.importorskip("ccsds_ndm.ndm_io")
    return io.NdmIo().from_path(path)


@pytest.mark.parametrize(("version", "ending"), [("1.0", "aem"), ("1.0", "xml"), ("2.0", "xml")])
def test_ephemeris_read_by_ccsds_ndm(tmp_path, version, ending):
    message = parsed(pt.files.write_aem(MOTION, tmp_path / f"m.{ending}", **NAMED, version=version))
    (segment,) = message.body.segment
    about = segment.metadata
    assert (about.ref_frame_a, about.ref_frame_b) == ("EME2000", "SC_BODY_1")
    assert getattr(about.time_system, "value", about.time_system) == "TAI"
    assert len(segment.data.attitude_state) == TIMES.size
    for t, state in zip(TIMES, segment.data.attitude_state, strict=True):
        row = state.quaternion_derivative if version < "2" else state.quaternion_ang_vel
        assert instant(row.epoch) == pytest.approx(t, abs=1e-6)
        check_quaternion(row.quaternion, t)
        if version >= "2":
            rates = [row.ang_vel.angvel_x.value, row.ang_vel.angvel_y.value, row.ang_vel.angvel_z.value]
            np.testing.assert_allclose(np.radians(rates), RATE * AXIS, rtol=0, atol=1e-15)
        else:
            q, dot = row.quaternion, row.quaternion_rate
            vector, change = np.array((q.q1, q.q2, q.q3)), [dot.q1_dot.value, dot.q2_dot.value, dot.q3_dot.value]
            expected = 0.5 * RATE * (q.qc * AXIS + np.cross(vector, AXIS))
            np.testing.assert_allclose(change, expected, rtol=0, atol=1e-15)
            assert dot.qc_dot.value == pytest.approx(-0.5 * RATE * vector @ AXIS, abs=1e-15)


@pytest.mark.parametrize(("version", "ending"), [("1.0", "apm"), ("1.0", "xml"), ("2.0", "xml")])
def test_parameters_read_by_ccsds_ndm(tmp_path, version, ending):
    body = pt.Body.from_inertia([[5.0, 0.3, -0.4], [0.3, 6.0, 0.5], [-0.4, 0.5, 7.0]])
    state = body.state(TILT, omega_body=RATE * AXIS, time=2.5)
    data = parsed(pt.files.write_apm(body, state, tmp_path / f"m.{ending}", **NAMED, version=version)).body.segment.data
    if version < "2":
        check_quaternion(data.quaternion_state.quaternion, 0.0)
        assert instant(data.quaternion_state.epoch) == 2.5
        inertia = data.spacecraft_parameters
        assert [inertia.i11.value, inertia.i12.value, inertia.i23.value] == pytest.approx([5.0, 0.3, 0.5], abs=1e-14)
    else:
        check_quaternion(data.quaternion_state[0].quaternion, 0.0)
        assert instant(data.epoch) == 2.5
        inertia = data.inertia[0]  # I = [[IXX, -IXY, -IXZ], ...], annex F6
        assert [inertia.ixx.value, inertia.ixy.value, inertia.iyz.value] == pytest.approx([5.0, -0.3, -0.5], abs=1e-14)


# ------------------------------------------------------------------ Orekit


@pytest.fixture(scope="module")
def orekit(tmp_path_factory):
    """Orekit with the leap seconds of erfa; it needs Java, and is skipped without."""
    module = pytest.importorskip("orekit_jpype")
    if shutil.which("java") is None:
        pytest.skip("no Java")
    import erfa

    months = ("JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC")
    folder = tmp_path_factory.mktemp("orekit")
    (folder / "tai-utc.dat").write_text(
        "".join(
            f" {year} {months[month - 1]}  1 =JD {sum(erfa.cal2jd(int(year), int(month), 1)):9.1f}  "
            f"TAI-UTC= {ahead:5.1f}       S + (MJD - 41317.) X 0.0      S\n"
            for year, month, ahead in erfa.leap_seconds.get()
            if year >= 1972
        )
    )
    module.initVM()
    from orekit_jpype.pyhelpers import setup_orekit_data

    setup_orekit_data(str(folder), from_pip_library=False)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("ending", ["aem", "xml"])
@pytest.mark.parametrize("rates", [True, False])
@pytest.mark.usefixtures("orekit")
def test_ephemeris_read_by_orekit(tmp_path, version, ending, rates):
    from java.io import File
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder

    path = pt.files.write_aem(MOTION, tmp_path / f"m.{ending}", **NAMED, version=version, rates=rates)
    message = ParserBuilder().buildAemParser().parseMessage(DataSource(File(str(path))))
    states = message.getSegments().get(0).getData().getAngularCoordinates()
    assert states.size() == TIMES.size
    first = states.get(0).getDate()
    for i, t in enumerate(TIMES):
        state = states.get(i)
        assert state.getDate().durationFrom(first) == pytest.approx(t, abs=2e-9)
        matrix = np.array([list(row) for row in state.getRotation().getMatrix()])
        np.testing.assert_allclose(matrix, space_to_body(t), rtol=0, atol=1e-14)
        rate = state.getRotationRate()
        expected = RATE * AXIS if rates else np.zeros(3)
        np.testing.assert_allclose([rate.getX(), rate.getY(), rate.getZ()], expected, rtol=0, atol=1e-14)


HEAD = """CCSDS_AEM_VERS = {version}.0
CREATION_DATE = 2026-11-21T00:00:00
ORIGINATOR = TEST
META_START
OBJECT_NAME = A
OBJECT_ID = 2026-001A
REF_FRAME_A = {a}
REF_FRAME_B = {b}
{more}TIME_SYSTEM = TAI
START_TIME = 2026-11-21T00:00:00
STOP_TIME = 2026-11-21T00:00:01
ATTITUDE_TYPE = {kind}
META_STOP
DATA_START
2026-11-21T00:00:00 {row}
2026-11-21T00:00:01 {row}
DATA_STOP
"""

QUATERNION = "0.1 -0.5 0.7 0.5"
DOT = "-0.02 0.03 0.05 -0.036"

ROWS = [
    ("1", "QUATERNION", "ATTITUDE_DIR = A2B\nQUATERNION_TYPE = LAST\n", QUATERNION),
    ("1", "QUATERNION", "ATTITUDE_DIR = B2A\nQUATERNION_TYPE = FIRST\n", QUATERNION),
    ("1", "QUATERNION/DERIVATIVE", "ATTITUDE_DIR = B2A\nQUATERNION_TYPE = FIRST\n", f"{QUATERNION} {DOT}"),
    ("1", "EULER_ANGLE", "ATTITUDE_DIR = B2A\nEULER_ROT_SEQ = 312\n", "30 -50 70"),
    ("2", "QUATERNION/DERIVATIVE", "", f"{QUATERNION} {DOT}"),
    ("2", "QUATERNION/ANGVEL", "ANGVEL_FRAME = SC_BODY_1\n", f"{QUATERNION} 1 -2 3"),
    ("2", "EULER_ANGLE/DERIVATIVE", "EULER_ROT_SEQ = ZXZ\n", "30 50 70 1 -2 3"),
    ("2", "EULER_ANGLE/DERIVATIVE", "EULER_ROT_SEQ = ZYX\n", "30 50 70 1 -2 3"),
    ("2", "SPIN", "", "20 80 45 1"),
    ("2", "SPIN/NUTATION", "", "20 80 45 1 10 700 30"),
    ("2", "SPIN/NUTATION_MOM", "", "20 80 45 1 0 70 0.5"),
]


@pytest.mark.parametrize("frames", [("EME2000", "SC_BODY_1"), ("SC_BODY_1", "EME2000")])
@pytest.mark.parametrize(("version", "kind", "more", "row"), ROWS)
@pytest.mark.usefixtures("orekit")
def test_types_are_read_as_orekit_reads_them(tmp_path, frames, version, kind, more, row):
    from java.io import File
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder

    path = tmp_path / "a.aem"
    path.write_text(HEAD.format(version=version, a=frames[0], b=frames[1], kind=kind, more=more, row=row))
    ours = pt.files.read_aem(path)
    message = ParserBuilder().buildAemParser().parseMessage(DataSource(File(str(path))))
    theirs = message.getSegments().get(0).getData().getAngularCoordinates().get(0)
    matrix = np.array([list(line) for line in theirs.getRotation().getMatrix()])
    np.testing.assert_allclose(ours.attitude.as_matrix()[0].T, matrix, rtol=0, atol=1e-14)
    rate = theirs.getRotationRate()
    if ours.omega_body is not None:
        np.testing.assert_allclose(ours.omega_body[0], [rate.getX(), rate.getY(), rate.getZ()], rtol=0, atol=1e-14)


# ------------------------------------------------------------------ parsers written here


def test_stk_file_by_another_parser(tmp_path):
    text = pt.files.write_stk_attitude(MOTION, tmp_path / "m.a", **NAMED).read_text().splitlines()
    begin = text.index("AttitudeTimeQuatAngVels") + 1
    words = dict(line.split(" ", 1) for line in text[2 : begin - 1])
    assert words["ScenarioEpoch"] == "20 Nov 2026 23:59:23.000000000"  # UTC is 37 s behind TAI
    assert (words["NumberOfAttitudePoints"], words["CoordinateAxes"], text[-1]) == ("25", "J2000", "END Attitude")
    for t, line in zip(TIMES, text[begin:-1], strict=True):
        time, q1, q2, q3, q4, *rates = map(float, line.split())
        assert time == pytest.approx(t, abs=1e-10)
        np.testing.assert_allclose(matrix_of_the_standard(q1, q2, q3, q4), space_to_body(t), rtol=0, atol=1e-14)
        np.testing.assert_allclose(np.radians(rates), RATE * AXIS, rtol=0, atol=1e-15)


def test_csv_by_numpy(tmp_path):
    path = pt.files.write_quaternion_csv(MOTION, tmp_path / "m.csv")
    lines = path.read_text().splitlines()
    header = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    rows = np.genfromtxt(lines[header + 1 :], delimiter=",", names=lines[header].split(","))
    assert rows.dtype.names[:5] == ("t", "q0", "q1", "q2", "q3")
    for row, t in zip(rows, TIMES, strict=True):
        assert row["t"] == t
        found = matrix_of_the_standard(row["q1"], row["q2"], row["q3"], row["q0"])
        np.testing.assert_allclose(found, space_to_body(t), rtol=0, atol=1e-14)
        np.testing.assert_allclose([row[f"omega_{i}"] for i in (1, 2, 3)], RATE * AXIS, rtol=0, atol=1e-15)


def test_c_kernel_by_spice(tmp_path):
    spice = pytest.importorskip("spiceypy")
    kernels = pt.files.write_ck(MOTION, tmp_path / "m.bc", **NAMED, spacecraft=-42)
    for kernel in kernels:
        spice.furnsh(str(kernel))
    try:
        zero = 848491200.0 + 32.184  # TT of the epoch after 2000-01-01T12:00:00, TDB within two milliseconds
        for t in TIMES:
            matrix, rate, _ = spice.ckgpav(-42000, spice.sce2c(-42, zero + t), 5000.0, "J2000")
            np.testing.assert_allclose(matrix, space_to_body(t), rtol=0, atol=2e-3 * RATE)
            np.testing.assert_allclose(matrix @ rate, RATE * AXIS, rtol=0, atol=1e-15)
        ahead, behind = (spice.pxform("J2000", "SC_BODY_1", zero + t) for t in (6.5, 5.5))
    finally:
        spice.kclear()
    axis, angle = spice.raxisa(np.ascontiguousarray(behind @ ahead.T))
    np.testing.assert_allclose(angle * axis, RATE * AXIS, rtol=0, atol=1e-9)
