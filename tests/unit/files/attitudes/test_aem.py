"""Attitude Ephemeris Messages, laid out as in CCSDS 504.0-B-1 and B-2, with numbers from scipy's rotations."""

import contextlib
import dataclasses
import re

import numpy as np
import pytest

import poinsot as pt
from tumbling import BODY, CALENDAR, MOTION, NAMED, START, TIMES, check, columns, dated

KINDS = [f"{what}{rate}" for what in ("QUATERNION", "EULER_ANGLE") for rate in ("", "/DERIVATIVE", "/ANGVEL", "/RATE")]

TAGS = {"Q": ("Q1", "Q2", "Q3", "QC"), "E": ("ANGLE_1", "ANGLE_2", "ANGLE_3")}
MORE = {"": (), "ANGVEL": ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"), "RATE": ("r1", "r2", "r3")}


def metadata(kind, version=2, **fields):
    says = {
        "OBJECT_NAME": "TUMBLER",
        "OBJECT_ID": "2026-001A",
        "CENTER_NAME": "EARTH",
        "REF_FRAME_A": "EME2000",
        "REF_FRAME_B": "SC_BODY_1",
        "ATTITUDE_DIR": "A2B" if version == 1 else None,
        "TIME_SYSTEM": "TAI",
        "START_TIME": dated(0),
        "STOP_TIME": dated(10),
        "ATTITUDE_TYPE": kind,
        "QUATERNION_TYPE": "LAST" if version == 1 and kind[0] == "Q" else None,
        "EULER_ROT_SEQ": ("312" if version == 1 else "ZXY") if kind[0] == "E" else None,
        "ANGVEL_FRAME": "SC_BODY_1" if kind.endswith("ANGVEL") else None,
    } | fields
    inner = "".join(f"{key} = {value}\n" for key, value in says.items() if value is not None)
    return f"META_START\nCOMMENT free rotation\n{inner}META_STOP\n\n"


def rows(numbers, times=TIMES, marks=True):
    inner = "".join(f"{dated(t)} {' '.join(f'{x:.16e}' for x in row)}\n" for t, row in zip(times, numbers, strict=True))
    return f"DATA_START\nCOMMENT rows\n{inner}DATA_STOP\n" if marks else inner


def opening(version=2):
    return f"CCSDS_AEM_VERS = {version}.0\nCREATION_DATE = 2026-11-04T17:22:31\nORIGINATOR = NASA/JPL\n\n"


WHOLE = opening() + metadata("QUATERNION/ANGVEL") + rows(columns("QUATERNION/ANGVEL"))


def as_xml(kind, numbers, version=2, **fields):
    pairs = (line.partition(" = ") for line in metadata(kind, version, **fields).splitlines())
    about = "".join(f"<{key}>{value}</{key}>" for key, _, value in pairs if value and not key.startswith("COMMENT"))
    form, _, more = kind.partition("/")
    tags = TAGS[form[0]]
    after = tuple(f"{tag}_DOT" for tag in tags) if more == "DERIVATIVE" else MORE[more]
    unit = {"Q": "", "A": ' units="deg"'}
    inner = "".join(
        f"<attitudeState><any><EPOCH>{dated(t)}</EPOCH>"
        + "".join(f"<{tag}{unit[tag[0]]}>{x:.16e}</{tag}>" for tag, x in zip(tags, row[: len(tags)], strict=True))
        + (
            "<rotationRates>" + "".join(f'<rotation{i} rate="X_RATE">9</rotation{i}>' for i in (1, 2, 3))
            if more == "RATE"
            else ""
        )
        + "".join(f"<{tag}>{x:.16e}</{tag}>" for tag, x in zip(after, row[len(tags) :], strict=True) if more != "RATE")
        + ("</rotationRates>" if more == "RATE" else "")
        + "</any></attitudeState>"
        for t, row in zip(TIMES, numbers, strict=True)
    ).replace(' units="deg">', ">" if version == 1 else ' units="deg">')
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ndm xmlns="urn:ccsds:schema:ndmxml"><aem id="CCSDS_AEM_VERS" '
        f'version="{version}.0"><header/><body><segment><metadata>{about}</metadata><data>{inner}</data></segment>'
        "</body></aem></ndm>"
    )


@pytest.fixture
def read(reads):
    return reads(pt.files.read_aem, "a.aem")


def ignored_rates(kind):
    """The warning of columns that version 1 does not define, if there are any."""
    sentence = r"a\.aem should have rates that the standard defines, got rates of /RATE, which are ignored\.$"
    return pytest.warns(UserWarning, match=sentence) if kind.endswith("RATE") else contextlib.nullcontext()


def rate_tolerance(kind):
    return {"": None, "RATE": None, "ANGVEL": 1e-13, "DERIVATIVE": 1e-8}[kind.partition("/")[2]]


# ------------------------------------------------------------------ reading


@pytest.mark.parametrize("body_is_b", [True, False])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("form", ["kvn", "xml"])
def test_types_of_version_2_in_both_directions(read, kind, body_is_b, form):
    frames = {} if body_is_b else {"REF_FRAME_A": "SC_BODY_1", "REF_FRAME_B": "EME2000"}
    numbers = columns(kind, body_is_b)
    if kind.endswith("ANGVEL"):  # along B, which is EME2000 then
        frames["ANGVEL_FRAME"] = frames.get("REF_FRAME_B", "SC_BODY_1")
    text = opening() + metadata(kind, **frames) + rows(numbers) if form == "kvn" else as_xml(kind, numbers, **frames)
    with ignored_rates(kind):
        table = read(text)
    check(table, 1e-12, rate_tolerance(kind))
    assert (table.reference_frame, table.body_frame) == ("ICRF", "SC_BODY_1")
    assert table.calendar == pt.Calendar("2026-11-21T00:00:00.000000", "TAI")
    assert table.norm_error < 1e-14


@pytest.mark.parametrize("kind", [kind for kind in KINDS if not kind.endswith(("ANGVEL", "EULER_ANGLE/DERIVATIVE"))])
@pytest.mark.parametrize("body_is_b", [True, False])
@pytest.mark.parametrize("direction", ["A2B", "B2A"])
@pytest.mark.parametrize("first", [True, False])
def test_types_of_version_1_in_all_directions_and_orders(read, kind, body_is_b, direction, first):
    numbers, fields = columns(kind, body_is_b), {"ATTITUDE_DIR": direction}
    names = ("EME2000", "SC_BODY_1") if body_is_b == (direction == "A2B") else ("SC_BODY_1", "EME2000")
    fields |= dict(zip(("REF_FRAME_A", "REF_FRAME_B"), names, strict=True))
    if kind[0] == "Q" and first:
        fields["QUATERNION_TYPE"] = "FIRST"
        numbers = (
            numbers[:, [3, 0, 1, 2, 7, 4, 5, 6] if kind.endswith("DERIVATIVE") else [3, 0, 1, 2, 4, 5, 6]][
                :, : numbers.shape[1]
            ]
            if numbers.shape[1] > 4
            else numbers[:, [3, 0, 1, 2]]
        )
    with ignored_rates(kind):
        table = read(opening(1) + metadata(kind, 1, **fields) + rows(numbers, marks=first))
    check(table, 1e-12, rate_tolerance(kind))


def test_euler_angles_of_version_1_in_xml(read):
    numbers = columns("EULER_ANGLE")
    text = as_xml("EULER_ANGLE", numbers, 1)
    for i, axis in enumerate("ZXY", start=1):
        text = text.replace(f"<ANGLE_{i}>", f'<rotation{i} angle="{axis}_ANGLE" units="deg">')
        text = text.replace(f"</ANGLE_{i}>", f"</rotation{i}>")
    text = text.replace('<rotation1 angle="Z', '<rotationAngles><rotation1 angle="Z')
    text = text.replace("</rotation3></any>", "</rotation3></rotationAngles></any>")
    check(read(text), 1e-12, None)


@pytest.mark.parametrize(
    "sequence", ["XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]
)
def test_every_sequence_of_euler_angles(read, sequence):
    kind = "EULER_ANGLE/DERIVATIVE"
    numbers = columns(kind, sequence=sequence)
    check(read(opening() + metadata(kind, EULER_ROT_SEQ=sequence) + rows(numbers)), 1e-12, 1e-6)


@pytest.mark.parametrize("kind", ["QUATERNION/ANGVEL", "EULER_ANGLE/ANGVEL"])
@pytest.mark.parametrize("name", ["EME2000", "REF_FRAME_A"])
def test_angular_velocity_along_the_first_frame(read, kind, name):
    numbers = columns(kind, rate_in_a=True)
    check(read(opening() + metadata(kind, ANGVEL_FRAME=name) + rows(numbers)), 1e-12)


def test_spin_as_in_the_example_of_the_standard(read):
    """Annex F5.4: attitude at the epoch, and 300 s later by the model that the rates belong to; four digits."""
    from scipy.spatial.transform import Rotation

    spin, momentum = (0.0, 80.0, 45.0, 1.0), (0.0, 70.0, 0.01)
    text = opening() + metadata("SPIN/NUTATION_MOM", STOP_TIME=None) + rows([spin + momentum], [0.0])
    table = read(text)
    np.testing.assert_allclose(table.quaternion[0], (0.3812, 0.0805, 0.0334, 0.9204), rtol=0, atol=5e-5)

    def model(seconds):  # from A to F, whose third axis is the momentum, and the three rotations from F
        tilted = Rotation.from_quat((0.0, np.sin(np.radians(10)), 0.0, np.cos(np.radians(10))))
        return tilted * Rotation.from_euler("ZXZ", [-90 + 0.01 * seconds, 10, -135 + seconds], degrees=True)

    np.testing.assert_allclose(model(0.0).as_matrix(), table.attitude.as_matrix()[0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(abs(model(300.0).as_quat()), (0.0584, 0.0650, 0.6263, 0.7747), rtol=0, atol=5e-5)
    rate = (model(-1e-3).inv() * model(1e-3)).as_rotvec() / 2e-3
    np.testing.assert_allclose(table.omega_body[0], rate, rtol=0, atol=1e-11)

    along_body = model(0.0).inv().apply((np.cos(np.radians(70)), 0.0, np.sin(np.radians(70))))
    tilt, phase = np.degrees(np.arccos(along_body[2])), np.degrees(np.arctan2(-along_body[1], along_body[0]))
    same = (*spin, tilt, 36000.0, phase)
    text = opening() + metadata("SPIN/NUTATION", STOP_TIME=None) + rows([same], [0.0])
    np.testing.assert_allclose(read(text).omega_body[0], rate, rtol=0, atol=1e-11)
    old = text.replace("VERS = 2", "VERS = 1").replace("TIME_SYSTEM", "ATTITUDE_DIR = A2B\nTIME_SYSTEM")
    with pytest.warns(UserWarning, match=r"a\.aem should have rates that the standard defines, got rates of /NUTATION"):
        assert read(old).omega_body is None
    with pytest.raises(ValueError, match=r"line 19 must have a positive NUTATION_PER, got 0\.0"):
        read(text.replace("3.6000000000000000e+04", "0"))


def test_spin_axis_and_rate(read):
    numbers = [(268.62511, 68.448486, 159.69509, -109.96528), (268.63990, 68.432197, 145.93720, -109.96493)]
    table = read(opening() + metadata("SPIN", STOP_TIME=None) + rows(numbers, [0.0, 0.125]))
    for row, axis in zip(numbers, table.attitude.apply((0, 0, 1)), strict=True):
        a, d = np.radians(row[:2])
        np.testing.assert_allclose(axis, (np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), np.sin(d)), rtol=0, atol=1e-15)
    np.testing.assert_allclose(table.omega_body[:, 2], np.radians([-109.96528, -109.96493]), rtol=1e-15)
    turned = (table.attitude[0].inv() * table.attitude[1]).as_rotvec() / 0.125
    np.testing.assert_allclose(turned[2], table.omega_body[0, 2], rtol=1e-3)


def test_another_calendar_and_utc(read):
    hours = pt.Calendar("2026-11-20T23:00:00", "TAI", "h")
    table = read(WHOLE, calendar=hours)
    np.testing.assert_allclose(table.times, 1 + TIMES / 3600, rtol=1e-14)
    np.testing.assert_allclose(table.omega_body, 3600 * MOTION.omega_body, rtol=1e-14)
    assert read(WHOLE.replace("= TAI", "= UTC")).calendar.time("2026-11-21T00:00:37 TAI") == 0.0


# ------------------------------------------------------------------ segments


def parts(cut=20, second=None, **fields):
    numbers = columns("QUATERNION/ANGVEL")
    first = metadata("QUATERNION/ANGVEL", STOP_TIME=None) + rows(numbers[: cut + 1], TIMES[: cut + 1])
    after = metadata(second or "QUATERNION/ANGVEL", START_TIME=None, STOP_TIME=None, **fields)
    return opening() + first + after + rows(columns(second or "QUATERNION/ANGVEL")[cut:], TIMES[cut:])


def test_segments_that_follow_each_other_are_one(read):
    check(read(parts()), 1e-12)
    assert read(parts(), segment=1).times.size == 21
    with pytest.raises(ValueError, match="segment must be a number from 0 to 1, got 2"):
        read(parts(), segment=2)


def disagreeing(numbers, kind="QUATERNION/ANGVEL"):
    """Two segments of which the second begins at the last epoch of the first with other numbers."""
    first = metadata("QUATERNION/ANGVEL", STOP_TIME=None) + rows(columns("QUATERNION/ANGVEL")[:21], TIMES[:21])
    return opening() + first + metadata(kind, START_TIME=None, STOP_TIME=None) + rows(numbers[20:], TIMES[20:])


@pytest.mark.parametrize("what", ["attitude", "rate"])
def test_segments_that_disagree_at_an_epoch_are_chosen_from(read, what):
    numbers = columns("QUATERNION/ANGVEL").copy()
    if what == "attitude":
        numbers[20, :4] = numbers[25, :4]
    else:
        numbers[20, 4] += 0.01
    sentence = (
        r"0 and 1, which differ in the attitude and the rate at 2026-11-21T00:00:05\.0+\. Say which one: segment=0 to"
    )
    with pytest.raises(ValueError, match=sentence):
        read(disagreeing(numbers))
    assert read(disagreeing(numbers), segment=0).times.size == 21
    assert read(disagreeing(numbers), segment=1).times.size == 21
    numbers[20] = columns("QUATERNION/ANGVEL")[20]
    check(read(disagreeing(numbers * np.repeat((-1, 1), (4, 3)))), 1e-12)  # of both signs


def test_segments_with_and_without_rates_are_chosen_from(read):
    text = disagreeing(columns("QUATERNION"), "QUATERNION")
    with pytest.raises(
        ValueError, match=r"0 and 1, which differ in the presence of rates\. Say which one: segment=0 to 1"
    ):
        read(text)
    assert read(text, segment=0).omega_body.shape == (21, 3)
    assert read(text, segment=1).omega_body is None


def test_xml_rows_with_more_than_their_type(read):
    text = as_xml("QUATERNION/ANGVEL", columns("QUATERNION/ANGVEL"), ANGVEL_FRAME=None)
    with pytest.raises(
        ValueError, match=r"segment 0, row 0 must have numbers for Q1, Q2, Q3, QC, got 'ANGVEL_X' as well\.$"
    ):
        read(text.replace("<ATTITUDE_TYPE>QUATERNION/ANGVEL", "<ATTITUDE_TYPE>QUATERNION"))
    with pytest.raises(
        ValueError, match=r"segment 0 must have a key of the format, got 'attitudeStat'\. Did you mean 'att"
    ):
        read(text.replace("attitudeState>", "attitudeStat>", 2))


def version_1_rotations(axes="ZXY", order=(1, 2, 3)):
    tags = dict(zip(order, axes, strict=True))
    text = as_xml("EULER_ANGLE", columns("EULER_ANGLE"), 1)

    def rotations(match):
        leaves = {i: match[i] for i in (1, 2, 3)}
        inner = "".join(f'<rotation{i} angle="{tags[i]}_ANGLE" units="deg">{leaves[i]}</rotation{i}>' for i in order)
        return f"<rotationAngles>{inner}</rotationAngles>"

    return re.sub(r"<ANGLE_1>(.*?)</ANGLE_1><ANGLE_2>(.*?)</ANGLE_2><ANGLE_3>(.*?)</ANGLE_3>", rotations, text)


def test_rotations_of_version_1_are_read_by_their_numbers_and_axes(read):
    check(read(version_1_rotations()), 1e-12, None)
    check(read(version_1_rotations("YZX", (3, 1, 2))), 1e-12, None)
    with pytest.raises(ValueError, match=r"row 0 must have its angles in the order 'ZXY', got 'XZY'\.$"):
        read(version_1_rotations("XZY"))


def test_segments_that_differ_are_chosen_from(read):
    with pytest.raises(ValueError, match=r"0 and 1, which differ in frames\. Say which one: segment=0 to 1\.$"):
        read(parts(REF_FRAME_A="TEME"))
    body, *rest = parts().split("META_START")
    with pytest.raises(ValueError, match=r"0 and 1, which differ in order in time\."):
        read("META_START".join([body, rest[1], rest[0]]))
    with pytest.raises(ValueError, match=r"0 and 1, which differ in OBJECT_ID\."):
        read(parts(OBJECT_ID="1998-067A"))


# ------------------------------------------------------------------ bad files

ROWS = rows(columns("QUATERNION/ANGVEL")).splitlines(keepends=True)
HEAD = opening() + metadata("QUATERNION/ANGVEL")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"a\.aem must begin with CCSDS_AEM_VERS = 1\.0 or 2\.0, got ''"),
        (WHOLE.replace("AEM_VERS = 2.0", "OEM_VERS = 2.0"), r"must begin with CCSDS_AEM_VERS"),
        (WHOLE.replace("AEM_VERS = 2.0", "AEM_VERS = 3.0"), r"must begin with CCSDS_AEM_VERS"),
        (opening(), r"a\.aem must have a segment with rows, got none"),
        (HEAD, r"segment 0 of .*a\.aem must have rows, got none"),
        (opening() + "".join(ROWS), r"a\.aem, line 5 must come after META_START"),
        (HEAD + "".join(ROWS[:-1]), r"a\.aem, line 19 must be followed by DATA_STOP, got the end of the file"),
        (HEAD[:-20], r"a\.aem, line 5 must be followed by META_STOP|must be KEY = VALUE or META_STOP"),
        (HEAD + "".join(ROWS[:20]) + "DATA_STOP\n", r"must reach STOP_TIME = .* The file is not whole\.$"),
        (HEAD + "".join(ROWS[5:]) + "DATA_STOP\n", r"must reach START_TIME = .* The file is not whole\.$"),
        (HEAD + "".join(ROWS[:2] + ROWS[:1:-1]), r"a\.aem, line \d+ must"),
        (HEAD + ROWS[0] + ROWS[3] + ROWS[2] + ROWS[-1], r"a\.aem, line 21 must be later than the row before"),
        (HEAD + ROWS[0] + ROWS[3] + ROWS[3] + ROWS[-1], r"a\.aem, line 21 must be later than the row before"),
        (WHOLE.replace(" 5.0", " nan ", 1), r"a\.aem, line \d+ must have a"),
        (
            WHOLE.replace("e-01 ", "e-01 nan ", 1),
            r"a\.aem, line 21 must have a time and numbers for Q1, Q2, Q3, QC, ANGVEL_X",
        ),
        (WHOLE.replace("e-01 ", "q ", 1), r"a\.aem, line 21 must have a number for Q\d, got"),
        (WHOLE.replace("e-01 ", "e+300 ", 1), r"a\.aem, line 21 must have a number for Q1"),
        (
            WHOLE.replace("e-01 ", "e-00 ", 1),
            r"a\.aem, line 21 must have a quaternion of unit norm to 0\.001, got \|q\|",
        ),
        (WHOLE.replace("T00:00:05.0", "T00:61:05.0", 1), r"a\.aem, line 41: epoch must be a date"),
        (
            WHOLE.replace("EME2000", "ITRF2000"),
            r"be the body and a frame that does not rotate .* 'ITRF2000', which rot",
        ),
        (WHOLE.replace("EME2000", "LVLH"), r"got 'LVLH', which rotates"),
        (
            WHOLE.replace("EME2000", "FOO"),
            r"REF_FRAME_A and REF_FRAME_B in .*a\.aem must be the body .* 'FOO' and 'SC_BODY_1'",
        ),
        (WHOLE.replace("SC_BODY_1", "TEME"), r"must be the body and a frame that does not rotate"),
        (
            WHOLE.replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = FOO"),
            r"ANGVEL_FRAME in .* must be one of the frames",
        ),
        (WHOLE.replace("ANGVEL_FRAME = SC_BODY_1\n", ""), r"ANGVEL_FRAME in .* must be one of the frames .* got ''"),
        (WHOLE.replace("REF_FRAME_A", "FRAME"), r"segment 0 of .*a\.aem must have REF_FRAME_A, got none"),
        (WHOLE.replace("QUATERNION/ANGVEL", "MATRIX"), r"ATTITUDE_TYPE in .* must be one of QUATERNION, .* 'MATRIX'"),
        (WHOLE.replace("= TAI", "= SCLK"), r"TIME_SYSTEM in .*a\.aem must be one of UTC, .* 'SCLK'"),
        (WHOLE.replace("VERS = 2.0", "VERS = 1.0"), r"QUATERNION_TYPE in .*a\.aem must be LAST or FIRST, got ''"),
        (
            WHOLE.replace("VERS = 2.0", "VERS = 1.0").replace("META_STOP", "QUATERNION_TYPE = LAST\nMETA_STOP"),
            r"ATTITUDE_DIR in .*a\.aem must be A2B or B2A, got ''",
        ),
        (
            HEAD.replace("QUATERNION/ANGVEL", "EULER_ANGLE") + rows(columns("EULER_ANGLE")),
            r"sequence of three axes in EULER",
        ),
        (
            HEAD.replace("QUATERNION/ANGVEL", "EULER_ANGLE\nEULER_ROT_SEQ = 331") + rows(columns("EULER_ANGLE")),
            r"sequence of three axes in EULER_ROT_SEQ, got '331'",
        ),
        (
            as_xml("EULER_ANGLE", columns("EULER_ANGLE")).replace('"deg"', '"rad"', 1),
            r"row 0 must have ANGLE_1 in deg, .* 'rad'",
        ),
        (
            as_xml("QUATERNION", columns("QUATERNION")).replace("<QC>", "<QD>", 1).replace("</QC>", "</QD>", 1),
            r"row 0 must have QC",
        ),
        (
            as_xml("QUATERNION", columns("QUATERNION")).replace('version="2.0"><h', 'version="5.0"><h'),
            r"must be of version 1\.0 or 2",
        ),
        (as_xml("QUATERNION", columns("QUATERNION"))[:-5], r"a\.aem must be well-formed XML, got "),
        (
            as_xml("QUATERNION", columns("QUATERNION")).replace("<ndm", '<!DOCTYPE x [<!ENTITY a "b">]><ndm', 1),
            r"must be XML without a document type",
        ),
        ("<ndm/>", r"a\.aem must hold one aem element, got 0"),
        (b"\xff\xfe\xfa", r"a\.aem must be text in UTF-8"),
    ],
)
def test_bad_files(read, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(text)


def test_norms_of_few_digits_are_preserved_as_a_number(read):
    numbers = np.round(columns("QUATERNION"), 4)
    table = read(opening() + metadata("QUATERNION") + rows(numbers))
    assert 1e-6 < table.norm_error < 1e-4
    np.testing.assert_allclose(np.linalg.norm(table.quaternion, axis=1), 1, rtol=0, atol=1e-15)


# ------------------------------------------------------------------ writing


@pytest.mark.parametrize("ending", ["aem", "xml"])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("rates", [True, False])
def test_written_motion_comes_back(tmp_path, ending, version, rates):
    path = pt.files.write_aem(MOTION, tmp_path / f"m.{ending}", **NAMED, rates=rates, version=version)
    table = pt.files.read_aem(path)
    check(table, 1e-14, 1e-14 if rates else None)
    assert np.max(table.angle_to(MOTION)) < 1e-14
    again = pt.files.write_aem(table, tmp_path / f"n.{ending}", version=version)
    check(pt.files.read_aem(again), 1e-14, 1e-14 if rates else None)
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"m.{ending}", f"n.{ending}"]


def test_motion_backwards_and_names(tmp_path):
    back = pt.free_motion(BODY, START, TIMES[::-1])
    names = {"body_frame": "INSTRUMENT_A", "object_name": "TUMBLER", "object_id": "2026-001A", "center_name": "SUN"}
    path = pt.files.write_aem(back, tmp_path / "m.aem", calendar=CALENDAR, reference_frame="TEME", **names)
    table = pt.files.read_aem(path)
    check(table, 1e-14, 1e-14)
    assert (table.reference_frame, table.body_frame) == ("TEME", "INSTRUMENT_A")
    assert "OBJECT_ID = 2026-001A\nCENTER_NAME = SUN\n" in path.read_text()


def test_hours_and_leap_seconds(tmp_path):
    calendar = pt.Calendar("2016-12-31T23:00:00", "UTC", "h")
    times = np.array([0.5, 1.0, 1.0 + 0.5 / 3600, 1.0 + 1 / 3600, 2.0])  # 23:59:60 is within
    motion = pt.free_motion(BODY, START, times)
    path = pt.files.write_aem(motion, tmp_path / "m.aem", calendar=calendar, reference_frame="ICRF")
    assert "2016-12-31T23:59:60.500000000 " in path.read_text()
    table = pt.files.read_aem(path, calendar=calendar)
    np.testing.assert_allclose(table.times, times, rtol=0, atol=1e-12)
    np.testing.assert_allclose(table.omega_body, motion.omega_body, rtol=1e-14)


def test_orbits_give_calendar_and_frame(tmp_path):
    begin = pt.Calendar("2026-11-21T00:00:00", "UTC")
    circle, times = (
        pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.0, inclination=1.0),
        np.linspace(0, 600, 31),
    )
    r, v = (np.stack(list(part(times)), axis=-1) for part in (circle.position_at, circle.velocity_at))
    orbit = pt.orbits.Ephemeris.from_table(
        circle.mu, times=times, positions=r, velocities=v, reference_frame="ICRF", calendar=begin
    )
    motion = pt.files.AttitudeTable(TIMES, MOTION.quaternion).trajectory(pt.System(BODY, pt.GravityGradient(orbit)))
    table = pt.files.read_aem(pt.files.write_aem(motion, tmp_path / "m.aem"))
    assert (table.reference_frame, table.calendar.scale) == ("ICRF", "UTC")
    assert np.max(table.angle_to(motion)) < 1e-14
    with pytest.raises(
        ValueError, match=r"^calendar must be the calendar of the motion, Calendar\(.*, got Calendar\(.*\.$"
    ):
        pt.files.write_aem(motion, tmp_path / "n.aem", calendar=CALENDAR)
    with pytest.raises(
        ValueError, match=r"^reference_frame must be the reference frame of the motion, 'ICRF', got 'TEME'\.$"
    ):
        pt.files.write_aem(motion, tmp_path / "n.aem", reference_frame="TEME")


def test_nothing_is_overwritten_or_left_half_written(tmp_path, monkeypatch):
    path = tmp_path / "m.aem"
    path.write_text("precious")
    with pytest.raises(FileExistsError, match=r"m\.aem already exists; overwrite=True replaces"):
        pt.files.write_aem(MOTION, path, **NAMED)
    assert path.read_text() == "precious"
    monkeypatch.setattr("pathlib.Path.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        pt.files.write_aem(MOTION, path, **NAMED, overwrite=True)
    assert [file.name for file in tmp_path.iterdir()] == ["m.aem"]
    assert path.read_text() == "precious"
    monkeypatch.undo()
    check(pt.files.read_aem(pt.files.write_aem(MOTION, path, **NAMED, overwrite=True)), 1e-14, 1e-14)
    with pytest.raises(FileNotFoundError, match=r"^No such folder: "):
        pt.files.write_aem(MOTION, tmp_path / "no" / "m.aem", **NAMED)
    with pytest.raises(IsADirectoryError, match=r"must be the name of a file, got a folder\.$"):
        pt.files.write_aem(MOTION, tmp_path, **NAMED, overwrite=True)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"calendar": None}, r"^calendar must be given for a motion without one, got none\."),
        ({"calendar": "UTC"}, r"^calendar must be a Calendar, got str\."),
        ({"reference_frame": None}, r"^reference_frame must be given for a motion whose space axes have no name"),
        ({"reference_frame": "ITRF97"}, r"^reference_frame must be one of ICRF, .*, got 'ITRF97'\.$"),
        ({"version": "3.0"}, r"^version must be '1\.0' or '2\.0', got '3\.0'\.$"),
        ({"object_name": "A\nB"}, r"^OBJECT_NAME must be printable characters"),
        (
            {"body_frame": "ITRF97"},
            r"^reference_frame and body_frame must be the body and .* 'ITRF97', which rotates\.$",
        ),
        ({"body_frame": "TEME"}, r"^reference_frame and body_frame must be the body .* 'ICRF' and 'TEME'\.$"),
        ({"originator": ""}, r"^originator must be printable characters"),
        (
            {"motion": 3},
            r"^motion must be a Trajectory or an AttitudeTable, got int\.",
        ),
    ],
)
def test_bad_arguments(tmp_path, arguments, sentence):
    given = {"motion": MOTION, **NAMED} | arguments
    with pytest.raises((TypeError, ValueError), match=sentence):
        pt.files.write_aem(given.pop("motion"), tmp_path / "m.aem", **given)
    assert not list(tmp_path.iterdir())


def test_ensembles_and_other_units_are_refused(tmp_path):
    states = BODY.state(np.array([(1.0, 0, 0, 0)] * 2), omega_body=(0, 0, 1.0))
    with pytest.raises(ValueError, match=r"^motion must be of one body, got an ensemble of 2 members\.$"):
        pt.files.write_aem(pt.free_motion(BODY, states, TIMES), tmp_path / "m.aem", **NAMED)
    days = pt.free_motion(BODY, START, TIMES, units={"time": "d"})
    with pytest.raises(ValueError, match=r"^calendar must count 'd' as the system does, got one that counts 's'\.$"):
        pt.files.write_aem(days, tmp_path / "m.aem", **NAMED)
    close = pt.files.AttitudeTable([0.0, 1e-10], [(1.0, 0, 0, 0)] * 2, **NAMED)
    with pytest.raises(ValueError, match=r"^times must be a nanosecond apart or more"):
        pt.files.write_aem(close, tmp_path / "m.aem")
    assert dataclasses.replace(close, times=[0.0, 1.0]).times[1] == 1.0
