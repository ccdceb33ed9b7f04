"""Every reader and writer of attitudes: any table comes back, and any text is a result or one sentence."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import poinsot as pt
from tumbling import BODY, MOTION, NAMED, START

CLOCKS = [
    pt.Calendar("2026-11-21T00:00:00", "TAI"),
    pt.Calendar("2016-12-31T23:59:58.25", "UTC"),
    pt.Calendar("2000-001T12:00:00", "TDB", "h"),
    pt.Calendar("2010-02-03T04:05:06", "GPS", "d"),
]


def write_one(table, path, **options):
    """An APM of the first row."""
    state = table.state(BODY, 0)
    return pt.files.write_apm(
        BODY, state, path, calendar=table.calendar, reference_frame=table.reference_frame, **options
    )


def read_one(path, calendar=None):
    return pt.files.read_apm(path, calendar=calendar)[0]


WAYS: dict[str, Any] = {
    "aem": (pt.files.write_aem, pt.files.read_aem, {}),
    "aem 1": (pt.files.write_aem, pt.files.read_aem, {"version": "1.0"}),
    "aem.xml": (pt.files.write_aem, pt.files.read_aem, {}),
    "aem 1.xml": (pt.files.write_aem, pt.files.read_aem, {"version": "1.0"}),
    "apm": (write_one, read_one, {}),
    "apm.xml": (write_one, read_one, {}),
    "apm 1": (write_one, read_one, {"version": "1.0"}),
    "a": (pt.files.write_stk_attitude, pt.files.read_stk_attitude, {}),
    "csv": (pt.files.write_quaternion_csv, pt.files.read_quaternion_csv, {}),
}


@st.composite
def tables(draw):
    count = draw(st.integers(1, 5))
    parts = st.floats(-1, 1).filter(lambda x: x == 0 or abs(x) > 1e-150)
    q = np.array(draw(st.lists(st.tuples(parts, parts, parts, parts), min_size=count, max_size=count)))
    q[np.linalg.norm(q, axis=1) < 1e-3] = (0, 0, -1, 0)
    steps = draw(st.lists(st.floats(1e-6, 1e5), min_size=count, max_size=count))
    calendar = draw(st.sampled_from(CLOCKS))
    unit = {"s": 1, "h": 3600, "d": 86400}[calendar.unit]
    times = (np.cumsum(steps) + draw(st.floats(-1e6, 1e6))) / unit
    rates = draw(
        st.lists(
            st.tuples(*[st.floats(-100, 100).filter(lambda x: x == 0 or abs(x) > 1e-100)] * 3),
            min_size=count,
            max_size=count,
        )
    )
    omega = np.array(rates) * unit
    return pt.files.AttitudeTable(times, q / np.linalg.norm(q, axis=1)[:, None], omega, calendar, "ICRF", "BODY")


@pytest.mark.parametrize("way", WAYS)
@given(table=tables())
@settings(max_examples=25, deadline=None)
def test_any_table_comes_back(tmp_path_factory, way, table):
    write, read, options = WAYS[way]
    path = tmp_path_factory.mktemp("round") / f"m.{way}"
    back = read(write(table, path, **options), calendar=table.calendar)
    count = 1 if way.startswith("apm") else table.times.size
    unit = {"s": 1, "h": 3600, "d": 86400}[table.calendar.unit]
    np.testing.assert_allclose(back.times * unit, table.times[:count] * unit, rtol=1e-15, atol=2e-9)
    np.testing.assert_allclose(back.quaternion, table.quaternion[:count], rtol=0, atol=7e-16)
    # An APM goes by way of the momenta along principal axes: 1.1e-15 of the rate in 3,000 rows.
    allowed = 16 * np.finfo(float).eps * np.linalg.norm(table.omega_body, axis=1, keepdims=True)[:count]
    assert np.all(np.abs(back.omega_body - table.omega_body[:count]) <= allowed)


# ------------------------------------------------------------------ any text


@pytest.fixture(scope="module")
def texts(tmp_path_factory):
    few = pt.files.AttitudeTable(MOTION.times[:4], MOTION.quaternion[:4], MOTION.omega_body[:4], **NAMED)
    folder = tmp_path_factory.mktemp("base")
    return {way: write(few, folder / f"m.{way}", **options).read_text() for way, (write, _, options) in WAYS.items()}


NOISE = (
    "META_START\n",
    "DATA_STOP\n",
    "\n",
    "nan",
    "-",
    "e300",
    "1e-320",
    "=",
    "[deg]",
    "</a>",
    "<!ENTITY a 'b'>",
    ",",
    "#",
)


@pytest.mark.parametrize("way", WAYS)
@given(data=st.data())
@settings(max_examples=80, deadline=None)
@example(data=None)
def test_any_change_is_a_result_or_a_sentence(tmp_path_factory, texts, way, data):
    text = texts[way]
    if data is not None:
        at, gone = data.draw(st.integers(0, len(text))), data.draw(st.integers(0, 60))
        other = st.sampled_from(sorted(texts)).flatmap(lambda other: st.just(texts[other][at : at + 40]))
        noise = data.draw(st.text(max_size=12) | st.floats().map(str) | st.sampled_from(NOISE) | other)
        text = text[:at] + noise + text[at + gone :]
    path = tmp_path_factory.mktemp("any") / f"m.{way}"
    path.write_bytes(text.encode(errors="surrogatepass"))
    message = "nothing, but a result"
    try:
        table = WAYS[way][1](path)
        assert np.all(np.isfinite(table.quaternion))
        assert np.all(np.diff(table.times) > 0)
    except (ValueError, UserWarning) as problem:
        message = str(problem)
    assert re.fullmatch(r".*, (but|got) .*", message), message
    assert len(message) < 800


@pytest.mark.parametrize(
    "read", [pt.files.read_aem, pt.files.read_apm, pt.files.read_stk_attitude, pt.files.read_quaternion_csv]
)
def test_files_that_are_none(tmp_path, read):
    with pytest.raises(FileNotFoundError, match=r"^No such file: .*none\.x$"):
        read(tmp_path / "none.x")
    with pytest.raises(ValueError, match=r"must be a file, got a folder or a device\.$"):
        read(tmp_path)
    (tmp_path / "bomb.xml").write_text('<!DOCTYPE a [<!ENTITY b "bb"><!ENTITY c "&b;&b;&b;">]><aem>&c;</aem>')
    with pytest.raises(ValueError, match="must "):
        read(tmp_path / "bomb.xml")


def test_one_format_to_another(tmp_path):
    first = pt.files.write_aem(MOTION, tmp_path / "m.aem", **NAMED)
    second = pt.files.write_stk_attitude(pt.files.read_aem(first), tmp_path / "m.a")
    third = pt.files.write_quaternion_csv(pt.files.read_stk_attitude(second), tmp_path / "m.csv")
    kernels = pt.files.write_ck(pt.files.read_quaternion_csv(third), tmp_path / "m.bc")
    last = pt.files.spice_attitude("SC_BODY_1", MOTION.times, kernels, calendar=NAMED["calendar"])
    assert np.max(last.angle_to(pt.free_motion(BODY, START, MOTION.times))) < 2e-7
