"""Orbit Ephemeris Messages: laid out as in CCSDS 502.0-B-3, with positions from Kepler's equation solved here."""

import datetime as dt
import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.files import untrusted as strangers

MU, AXIS, ECCENTRICITY = 398600.4418, 9000.0, 0.2
BEGIN = dt.datetime(2026, 11, 21)
STEP, COUNT = 120, 121


def states(times):
    """Positions and velocities along an ellipse tilted about x, km and km/s; shape (n, 6)."""
    motion = np.sqrt(MU / AXIS**3)
    anomaly = mean = motion * np.asarray(times, dtype=float)
    for _ in range(50):
        anomaly = anomaly - (anomaly - ECCENTRICITY * np.sin(anomaly) - mean) / (1 - ECCENTRICITY * np.cos(anomaly))
    root, rate = np.sqrt(1 - ECCENTRICITY**2), motion / (1 - ECCENTRICITY * np.cos(anomaly))
    x, y = AXIS * (np.cos(anomaly) - ECCENTRICITY), AXIS * root * np.sin(anomaly)
    u, v = -AXIS * rate * np.sin(anomaly), AXIS * root * rate * np.cos(anomaly)
    return np.stack([x, 0.8 * y, 0.6 * y, u, 0.8 * v, 0.6 * v], axis=-1)


def dated(seconds):
    return (BEGIN + dt.timedelta(seconds=float(seconds))).isoformat(timespec="milliseconds")


def lines(first=0, last=COUNT - 1, accelerations=False, dates=dated):
    times = STEP * np.arange(first, last + 1)
    tail = " 0.001 -0.002 0.003" if accelerations else ""
    return "".join(
        f"{dates(t)} " + " ".join(f"{c:.12f}" for c in row) + tail + "\n"
        for t, row in zip(times, states(times), strict=True)
    )


def metadata(**fields):
    says = {
        "OBJECT_NAME": "MARS GLOBAL SURVEYOR",
        "OBJECT_ID": "1996-062A",
        "CENTER_NAME": "EARTH",
        "REF_FRAME": "EME2000",
        "TIME_SYSTEM": "UTC",
        "START_TIME": dated(0),
        "STOP_TIME": dated(STEP * (COUNT - 1)),
        "INTERPOLATION": "HERMITE",
        "INTERPOLATION_DEGREE": "7",
    } | fields
    inner = "".join(f"{key} = {value}\n" for key, value in says.items() if value is not None)
    return f"META_START\n{inner}META_STOP\n\nCOMMENT This block begins after trajectory correction maneuver TCM-3.\n"


OPENING = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-04T17:22:31\nORIGINATOR = NASA/JPL\n\n"
COVARIANCE = "COVARIANCE_START\nEPOCH = 2026-11-21T00:00:00\nCOV_REF_FRAME = RTN\n1\n2 3\nCOVARIANCE_STOP\n"
WHOLE = OPENING + metadata() + lines() + COVARIANCE


def as_xml(**fields):
    message = {
        key: value
        for key, _, value in (line.partition(" = ") for line in metadata(**fields).splitlines())
        if value and key != "COMMENT"
    }
    inner = "".join(f"<{key}>{value}</{key}>" for key, value in message.items())
    names = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
    rows = "".join(
        f"<stateVector><EPOCH>{date}</EPOCH>"
        + "".join(
            f'<{name} units="{"km/s" if "DOT" in name else "km"}">{c}</{name}>'
            for name, c in zip(names, components, strict=True)
        )
        + "<X_DDOT>1</X_DDOT></stateVector>"
        for date, *components in (line.split() for line in lines().splitlines())
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<ndm xmlns="urn:ccsds:schema:ndmxml"><oem id="CCSDS_OEM_VERS" '
        f'version="2.0"><header/><body><segment><metadata>{inner}</metadata><data>{rows}<covarianceMatrix><EPOCH>'
        "2026-11-21T00:00:00</EPOCH></covarianceMatrix></data></segment></body></oem></ndm>"
    )


@pytest.fixture
def read(reads):
    return reads(pt.files.read_oem, "a.oem")


def apart(orbit, times, offset=0.0):
    """The largest errors of position and velocity."""
    expected = states(times)
    got = np.stack([*orbit.position_at(times + offset), *orbit.velocity_at(times + offset)], axis=-1)
    return np.max(np.abs(got - expected)[:, :3]), np.max(np.abs(got - expected)[:, 3:])


@pytest.mark.parametrize(
    "text",
    [
        WHOLE,
        WHOLE.replace("\n", "\r\n"),
        OPENING + metadata() + lines(accelerations=True),
        OPENING.replace("2.0", "1.0") + metadata(INTERPOLATION=None, INTERPOLATION_DEGREE=None) + lines(),
        as_xml(),
        OPENING + metadata() + lines(dates=lambda t: dated(t).replace("11-21", "325") + "Z"),
    ],
    ids=["kvn", "windows", "accelerations", "version 1", "xml", "day of year"],
)
def test_rows_come_back_and_what_is_between(read, text):
    orbit = read(text)
    assert (orbit.reference_frame, orbit.origin) == ("ICRF", "EARTH")
    assert orbit.mu == pytest.approx(398600.435507, rel=1e-11, abs=0)
    assert orbit.span == (0.0, STEP * (COUNT - 1))
    assert orbit.calendar.date(0.0).isot == "2026-11-21T00:00:00.000"
    at_rows, at_rows_speed = apart(orbit, STEP * np.arange(COUNT))
    assert at_rows < 1e-10
    assert at_rows_speed < 2e-11
    between, between_speed = apart(orbit, np.linspace(0, STEP * (COUNT - 1), 3001))
    assert between < 1e-8
    assert between_speed < 1e-9
    assert between / 5 < orbit.error < 5 * between


@pytest.mark.parametrize(
    ("system", "ahead_of_utc"), [("UTC", 0), ("TAI", 37), ("GPS", 18), ("TT", 69.184), ("TDB", 69.184)]
)
def test_time_systems(read, system, ahead_of_utc):
    orbit = read(OPENING + metadata(TIME_SYSTEM=system) + lines())
    assert orbit.calendar.scale == system
    assert orbit.calendar.time("2026-11-21T00:00:00 UTC") == pytest.approx(ahead_of_utc, abs=2e-3)


def test_leap_second_between_rows(read):
    def dates(t):  # UTC, which has 86401 s on 2016-12-31
        late = dt.datetime(2016, 12, 31, 22) + dt.timedelta(seconds=float(t))
        if late < dt.datetime(2017, 1, 1):
            return late.isoformat()
        return (
            "2016-12-31T23:59:60"
            if late.second + late.minute == 0 and late.hour == 0
            else (late - dt.timedelta(seconds=1)).isoformat()
        )

    orbit = read(OPENING + metadata(START_TIME=None, STOP_TIME=None) + lines(dates=dates))
    assert "T23:59:60 " in lines(dates=dates)
    assert apart(orbit, np.linspace(0, STEP * (COUNT - 1), 3001))[0] < 1e-8


def test_usable_times_are_the_span(read):
    orbit = read(OPENING + metadata(USEABLE_START_TIME=dated(300), USEABLE_STOP_TIME=dated(13001)) + lines())
    assert orbit.span == (300.0, 13001.0)
    assert apart(orbit, np.linspace(300, 13001, 3001))[0] < 1e-8
    with pytest.raises(ValueError, match="usable times must lie within the times of the rows"):
        read(OPENING + metadata(USEABLE_START_TIME=dated(-300)) + lines())


def test_an_epoch_of_axes_of_date_gives_a_warning(read):
    fields = {"REF_FRAME": "TEME", "REF_FRAME_EPOCH": "2026-11-21T00:00:00"}
    sentence = (
        r"^REF_FRAME_EPOCH in \S+a\.oem should be absent, got '2026-11-21T00:00:00'\. It is ignored: the axes "
        r"are the axes of date\.$"
    )
    with pytest.warns(UserWarning, match=sentence):
        assert read(OPENING + metadata(**fields) + lines()).reference_frame == "TEME"
    assert read(OPENING + metadata(**fields | {"REF_FRAME": "GCRF"}) + lines()).reference_frame == "ICRF"


def test_another_calendar(read):
    calendar = pt.Calendar("2026-11-20T23:00:00", "UTC")
    orbit = read(WHOLE, calendar=calendar)
    assert orbit.calendar is calendar
    assert apart(orbit, np.linspace(0, STEP * (COUNT - 1), 301), offset=3600)[0] < 1e-8


@pytest.mark.parametrize(("name", "mu"), [("MARS", 42828.37), ("Jupiter Barycenter", 126712764.1), ("MOON", 4902.8)])
def test_centre_names(read, name, mu):
    orbit = read(OPENING + metadata(CENTER_NAME=name) + lines())
    assert orbit.mu == pytest.approx(mu, rel=1e-6)
    assert orbit.origin == name.upper()


# ------------------------------------------------------------------ segments


def test_segments_that_share_a_state_are_one(read):
    orbit = read(OPENING + metadata() + lines(0, 50) + COVARIANCE + metadata() + lines(50))
    assert len(orbit.knots) == COUNT
    assert apart(orbit, np.linspace(0, STEP * (COUNT - 1), 3001))[0] < 1e-8


def test_usable_times_of_one_out_of_two(read):
    first = metadata(STOP_TIME=dated(50 * STEP), USEABLE_STOP_TIME=dated(48 * STEP)) + lines(0, 50)
    second = metadata(USEABLE_START_TIME=dated(52 * STEP), USEABLE_STOP_TIME=dated(100 * STEP)) + lines(50)
    orbit = read(OPENING + first + second)
    assert orbit.span == (0.0, 100.0 * STEP)
    assert apart(orbit, np.linspace(0, 100 * STEP, 3001))[0] < 1e-8


@pytest.mark.parametrize(
    ("second", "reason"),
    [
        (metadata(START_TIME=None) + lines(51), r"the state at 2026-11-21T01:42:00\.000"),
        (metadata(START_TIME=None) + lines(52), r"the state at 2026-11-21T01:44:00\.000"),
        (metadata(START_TIME=None, REF_FRAME="TEME") + lines(50), "REF_FRAME"),
        (metadata(START_TIME=None, CENTER_NAME="MOON") + lines(50), "CENTER_NAME"),
        (metadata(START_TIME=None, TIME_SYSTEM="TAI") + lines(50), "TIME_SYSTEM"),
        (metadata(START_TIME=None, OBJECT_ID="1998-067A") + lines(50), "OBJECT_ID"),
    ],
)
def test_other_segments_are_chosen_from(read, second, reason):
    text = OPENING + metadata(STOP_TIME=None) + lines(0, 50) + second
    with pytest.raises(
        ValueError,
        match=rf"read as one, got 0 and 1, which differ in {reason}\. Say .* segment=0 to 1\.$",
    ):
        read(text)
    assert read(text, segment=0).span == (0.0, 50 * STEP)
    assert read(text, segment=1).knots[0] == 0.0
    for wrong in (2, -1):
        with pytest.raises(ValueError, match="segment must be a number from 0 to 1"):
            read(text, segment=wrong)
    for kind in (True, 0.0):
        with pytest.raises(TypeError, match=f"segment must be a whole number of at most 63 bits, got .* {kind}"):
            read(text, segment=kind)


# ------------------------------------------------------------------ bad input

ROWS = lines().splitlines(keepends=True)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", r"a\.oem must begin with CCSDS_OEM_VERS = 1\.0 or 2\.0 or 3\.0, got ''"),
        ("CCSDS_AEM_VERS = 1.0\n", r"must begin with CCSDS_OEM_VERS"),
        (OPENING.replace("2.0", "7.0"), r"must begin with CCSDS_OEM_VERS"),
        (OPENING, r"a\.oem must have a segment with rows, got none"),
        (OPENING + metadata(), r"segment 0 of .*a\.oem must have rows, got none"),
        (OPENING + lines(), r"a\.oem, line 5 must come after META_START"),
        (OPENING + "META_START\n", r"a\.oem, line 5 must be followed by META_STOP, got the end of the file"),
        (OPENING + "META_START\n" + lines(), r"a\.oem, line 6 must be KEY = VALUE or META_STOP"),
        (WHOLE.replace("COVARIANCE_STOP", ""), r"must be followed by COVARIANCE_STOP, got the end of the file"),
        (
            OPENING + metadata() + "".join(ROWS[::-1]),
            r"a\.oem, line 19 must be later than the row before, got 2026-11-21",
        ),
        (OPENING + metadata() + ROWS[0] + "".join(ROWS), r"a\.oem, line 19 must be later than the row before"),
        (
            OPENING + metadata() + "".join(ROWS[:60]),
            r"the rows of .* must reach STOP_TIME = .* The file is not whole\.$",
        ),
        (
            OPENING + metadata() + "".join(ROWS[2:]),
            r"the rows of .* must reach START_TIME = 2026-11-21T00:00:00\.000, got a first row of "
            r"2026-11-21T00:04:00\.000\. The file is not whole\.$",
        ),
        (
            OPENING + metadata(START_TIME=dated(2.5 * STEP)) + "".join(ROWS),
            r"the rows of .* must lie between START_TIME and STOP_TIME, got a first row of 2026-11-21T00:00:00\.000, "
            r"and START_TIME = 2026-11-21T00:05:00\.000\.$",
        ),
        (
            OPENING + metadata(STOP_TIME=dated(40 * STEP)) + "".join(ROWS),
            r"the rows of .* must lie between START_TIME and STOP_TIME, got a last row of 2026-11-21T04:00:00\.000, "
            r"and STOP_TIME = 2026-11-21T01:20:00\.000\.$",
        ),
        (WHOLE[:9000], r"a\.oem, line \d+ must have a time and numbers for X, Y, Z, .*, got '2026"),
        (OPENING + metadata() + "".join(ROWS[:40] + ROWS[60:]), r"line 18 to line 118: times must have no gaps"),
        (OPENING + metadata(STOP_TIME=None) + ROWS[0], r"line 17 to line 17: times must be two or more"),
        (WHOLE.replace(" -7", " 3e5.7", 1), r"must have a number for X, got '3e5"),
        (OPENING + metadata() + ROWS[0][:-1] + " 0 0\n", r"a\.oem, line 18 must have a time and numbers for X"),
        (
            OPENING + metadata() + ROWS[0].replace(" ", " nan ", 1),
            r"a\.oem, line 18 must have a time and numbers for X",
        ),
        (OPENING + metadata() + f"{dated(0)} 7e6 0 0 0 7.5e6 0\n" * 2, r"line 18 must have km and km/s, got"),
        (OPENING + metadata(REF_FRAME="ITRF-97") + lines(), r"must be a frame that does not rotate, got 'ITRF-97'"),
        (
            OPENING + metadata(REF_FRAME="FOO") + lines(),
            r"REF_FRAME in .*a\.oem must be one of ICRF, .*, got 'FOO'",
        ),
        (OPENING + metadata(REF_FRAME=None) + lines(), r"segment 0 of .*a\.oem must have REF_FRAME, got none"),
        (OPENING + metadata(TIME_SYSTEM="SCLK") + lines(), r"TIME_SYSTEM in .*a\.oem must be one of UTC, .* 'SCLK'"),
        (
            OPENING + metadata(CENTER_NAME="CERES") + lines(),
            r"mu must be given for an attractor that is not .* 'CERES'",
        ),
        (OPENING + metadata() + lines(dates=lambda t: dated(t)[:-9]), r"a\.oem, line 18: epoch must be a date such as"),
        (
            OPENING + metadata() + lines(dates=lambda t: dated(t).replace("11-21", "11-31")),
            "epoch must be a date that ex",
        ),
        (OPENING + metadata(STOP_TIME="soon") + lines(), r"epoch must be a date such as"),
        (b"\x00\x01\x02", r"a\.oem must be text in UTF-8, got other bytes"),
        (b"\xff\xfe\xfa", r"a\.oem must be text in UTF-8"),
        (
            as_xml().replace("<ndm", '<!DOCTYPE x SYSTEM "file:///etc/passwd"><ndm'),
            r"must be XML without a document type",
        ),
        (as_xml()[:-5], r"a\.oem must be well-formed XML, got "),
        (
            as_xml().replace('units="km/s"', 'units="m/s"', 1),
            r"segment 0, row 0 must have X_DOT in km/s, got 'm/s'",
        ),
        (as_xml().replace("<X ", "<W ").replace("</X>", "</W>"), r"segment 0, row 0 must have X, got none"),
        ("<ndm/>", r"a\.oem must hold one oem element, got 0"),
    ],
)
def test_bad_files(read, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read(text)


def test_files_that_are_none(tmp_path, monkeypatch):
    with pytest.raises(FileNotFoundError, match=r"^No such file: .*none\.oem$"):
        pt.files.read_oem(tmp_path / "none.oem")
    with pytest.raises(ValueError, match=r"must be a file, got a folder or a device\.$"):
        pt.files.read_oem(tmp_path)
    with pytest.raises(ValueError, match=r"^/dev/zero must be a file, got a folder or a device\.$"):
        pt.files.read_oem("/dev/zero")
    monkeypatch.setattr(strangers, "MAX_MESSAGE_BYTES", 100)
    (tmp_path / "long.oem").write_text(WHOLE)
    with pytest.raises(ValueError, match=r"long\.oem must have at most 100 bytes, got more\.$"):
        pt.files.read_oem(tmp_path / "long.oem")


SMALL = OPENING + metadata(STOP_TIME=None) + lines(0, 4) + COVARIANCE


@given(st.data())
@settings(max_examples=200, deadline=None)
@example(None)
def test_any_change_is_a_result_or_a_sentence(tmp_path_factory, data):
    text = SMALL
    if data is not None:
        base = data.draw(st.sampled_from([SMALL, as_xml(STOP_TIME=None)[:1500] + as_xml()[-150:]]))
        at, gone = data.draw(st.integers(0, len(base))), data.draw(st.integers(0, 60))
        noise = data.draw(
            st.text(max_size=12) | st.floats().map(str) | st.sampled_from(["META_START\n", "\n" + ROWS[9]])
        )
        text = base[:at] + noise + base[at + gone :]
    path = tmp_path_factory.mktemp("oem") / "a.oem"
    path.write_bytes(text.encode(errors="surrogatepass"))
    message = "nothing, but a result"
    try:
        orbit = pt.files.read_oem(path, mu=1.0)
        assert np.all(np.isfinite(np.stack(orbit.position_at(np.array(orbit.span)))))
    except (ValueError, UserWarning) as problem:
        message = str(problem)
    assert re.search(", (but|got) ", message)
