"""C-kernels: read back by SPICE itself, at instants of their clock and through its frames."""

import contextlib

import numpy as np
import pytest
import spiceypy as spice

import poinsot as pt
from poinsot.files.attitudes import ck
from tumbling import BODY, CALENDAR, MOTION, NAMED, START, TIMES


@pytest.fixture(autouse=True)
def nothing_stays_loaded():
    yield
    assert spice.ktotal("ALL") == 0


@pytest.fixture
def kernels(tmp_path):
    return pt.files.write_ck(MOTION, tmp_path / "m.bc", **NAMED)


def matrices(attitude):
    """From space to body, as SPICE has them."""
    return np.swapaxes(attitude.as_matrix(), -1, -2)


def test_spice_finds_attitudes_and_rates_by_the_clock(kernels):
    for path in kernels:
        spice.furnsh(str(path))
    try:
        segment = spice.ckcov(str(kernels[0]), -1000000, True, "SEGMENT", 0.0, "SCLK", spice.cell_double(10))
        first, last = spice.wnfetd(segment, 0)
        found = [spice.ckgpav(-1000000, tick, 0.0, "J2000") for tick in first + 1e6 * (TIMES + ck.COVERAGE_MARGIN)]
    finally:
        spice.kclear()
    assert last - first == pytest.approx(10.002e6, abs=0.2)
    turned, rates, _ = zip(*found, strict=True)
    np.testing.assert_allclose(
        turned, matrices(MOTION.attitude), rtol=0, atol=1e-7
    )  # the zero of the clock, as a float
    np.testing.assert_allclose(rates, MOTION.omega_space, rtol=0, atol=1e-7)


def test_motion_comes_back_through_frames(kernels):
    assert [path.name for path in kernels] == ["m.bc", "m.tsc", "m.tf"]
    table = pt.files.spice_attitude("SC_BODY_1", TIMES, kernels, calendar=CALENDAR)
    np.testing.assert_allclose(
        matrices(table.attitude), matrices(MOTION.attitude), rtol=0, atol=2e-7
    )  # ET: 0.12 microseconds
    np.testing.assert_allclose(table.omega_body, MOTION.omega_body, rtol=0, atol=1e-9)
    assert (table.reference_frame, table.body_frame) == ("ICRF", "SC_BODY_1")
    dates = ["2026-11-21T00:00:02.5 TAI", "2026-11-21T00:00:05 TAI"]
    some = pt.files.spice_attitude("SC_BODY_1", dates, kernels, calendar=CALENDAR)
    np.testing.assert_allclose(some.times, (2.5, 5.0), rtol=0, atol=1e-9)
    assert np.max(some.angle_to(MOTION)) < 2e-7


def test_turns_between_attitudes_at_a_constant_rate(kernels):
    times = np.array([0.1, 3.3, 9.9])
    table = pt.files.spice_attitude("SC_BODY_1", times, kernels, calendar=CALENDAR)
    assert 1e-5 < np.max(table.angle_to(MOTION)) < 1e-2


def test_without_rates_in_hours_and_with_names(tmp_path):
    hours = pt.Calendar("2026-11-21T00:00:00", "UTC", "h")
    motion = pt.free_motion(BODY, START, TIMES)
    names = {"body_frame": "TUMBLER", "spacecraft": -123456}
    kernels = pt.files.write_ck(motion, tmp_path / "m.bc", calendar=hours, reference_frame="J2000", **names)
    table = pt.files.spice_attitude("tumbler", TIMES, kernels, calendar=hours)
    np.testing.assert_allclose(table.omega_body, motion.omega_body, rtol=0, atol=1e-9)
    assert np.max(table.angle_to(motion)) < 1e-9
    kernels = pt.files.write_ck(table, tmp_path / "n.bc", rates=False)
    again = pt.files.spice_attitude("TUMBLER", TIMES, kernels, calendar=hours)
    assert again.omega_body is None
    assert np.max(again.angle_to(motion)) < 2e-9


def test_other_frames_of_spice():
    """The ecliptic of 2000, tilted by 84381.448 arcseconds about the first axis, at rest."""
    table = pt.files.spice_attitude("ECLIPJ2000", [0.0, 1e6], [])
    tilt = np.radians(84381.448 / 3600)
    np.testing.assert_allclose(table.attitude.as_rotvec(), [(tilt, 0, 0)] * 2, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(table.omega_body, 0)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"frame": "FOO"}, r"^frame must be a frame that SPICE defines, got 'FOO'\.$"),
        ({"frame": 3}, r"^frame must be a text, got int 3\.$"),
        ({"reference_frame": "BAR"}, r"^reference_frame must be a frame that SPICE defines, got 'BAR'\.$"),
        (
            {"reference_frame": "IAU_EARTH"},
            r"^reference_frame must be a frame that does not rotate, got 'IAU_EARTH'\.$",
        ),
        (
            {"times": [9.0, 11.0]},
            r"^kernels must say the attitude of 'SC_BODY_1' at 2026 NOV 21 00:00:43\.182 TDB, got SPICE\(NOFRAME",
        ),
        ({"times": [3.0, 2.0]}, r"^times must rise"),
        ({"calendar": "UTC"}, r"^calendar must be a Calendar, got str\.$"),
        ({"kernels": ["none.bc"]}, r"^No such file: none\.bc$"),
    ],
)
def test_bad_questions(kernels, change, sentence):
    asked = {"frame": "SC_BODY_1", "times": TIMES, "kernels": kernels, "calendar": CALENDAR} | change
    with pytest.raises((TypeError, ValueError, OSError), match=sentence):
        pt.files.spice_attitude(asked.pop("frame"), asked.pop("times"), asked.pop("kernels"), **asked)


@pytest.mark.parametrize("content", [b"", b"nonsense", b"DAF/CK  " + bytes(5000), b"KPL/FK\n\\begindata\nFRAME_X = ("])
def test_files_that_are_no_kernels(kernels, content):
    kernels[0].write_bytes(content)
    with pytest.raises(ValueError, match=r"must be a SPICE kernel|TDB, got SPICE|got a broken first record"):
        pt.files.spice_attitude("SC_BODY_1", TIMES, kernels, calendar=CALENDAR)


@pytest.mark.parametrize("place", [8, 12])
def test_sizes_at_which_spice_would_crash(kernels, place):
    content = bytearray(kernels[0].read_bytes())
    content[place] = 200
    kernels[0].write_bytes(content)
    with pytest.raises(
        ValueError, match=r"m\.bc must be a whole SPICE kernel of the kind 'DAF/CK', got a broken first record"
    ):
        pt.files.spice_attitude("SC_BODY_1", TIMES, kernels, calendar=CALENDAR)


def test_truncated_kernel(kernels):
    kernels[0].write_bytes(kernels[0].read_bytes()[:2048])
    with pytest.raises(ValueError, match="got SPICE"):
        pt.files.spice_attitude("SC_BODY_1", TIMES, kernels, calendar=CALENDAR)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"path": "m.ck"}, r"^path must end in \.bc, got 'm\.ck'\.$"),
        ({"reference_frame": "TEME"}, r"^reference_frame must be the ICRF for a C-kernel, got TEME\.$"),
        ({"body_frame": "J2000"}, r"^reference_frame and body_frame must be the body and a frame"),
        ({"body_frame": "two words"}, r"^body_frame must be up to 26 letters"),
        ({"spacecraft": 5}, r"^spacecraft must be a negative number above -2000000, got 5\.$"),
        ({"motion": pt.free_motion(BODY, START, [0.0])}, r"^motion must have two times or more for a C-kernel"),
    ],
)
def test_bad_arguments(tmp_path, change, sentence):
    given = {"motion": MOTION, "path": "m.bc", **NAMED} | change
    with pytest.raises(ValueError, match=sentence):
        pt.files.write_ck(given.pop("motion"), tmp_path / given.pop("path"), **given)
    assert not list(tmp_path.iterdir())


def test_existing_files_stay(tmp_path):
    (tmp_path / "m.tf").write_text("precious")
    with pytest.raises(FileExistsError, match=r"m\.tf already exists; overwrite=True"):
        pt.files.write_ck(MOTION, tmp_path / "m.bc", **NAMED)
    assert [path.name for path in tmp_path.iterdir()] == ["m.tf"]
    pt.files.write_ck(MOTION, tmp_path / "m.bc", **NAMED, overwrite=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.bc", "m.tf", "m.tsc"]


# ------------------------------------------------------------------ at its own instants


def test_its_own_instants(kernels):
    table = ck.read_ck(kernels[0])
    assert table.times.size == TIMES.size
    np.testing.assert_allclose(CALENDAR.time(table.calendar.date(table.times)), TIMES, rtol=0, atol=2e-7)
    back = pt.files.AttitudeTable(TIMES, table.quaternion, table.omega_body, CALENDAR)
    assert np.max(back.angle_to(MOTION)) < 3e-7
    np.testing.assert_allclose(table.omega_body, MOTION.omega_body, rtol=0, atol=1e-9)
    assert (table.reference_frame, table.body_frame) == ("ICRF", "SC_BODY_1")


def test_kernels_of_others_are_read_to_their_ends(kernels, tmp_path):
    """One with the ticks of our clock, relative to the ecliptic, whose first attitude is a turn of 90 degrees."""
    path = tmp_path / "o.bc"
    for kernel in kernels[1:]:
        path.with_suffix(kernel.suffix).write_bytes(kernel.read_bytes())
    ticks = np.array([1e6, 2e6, 3e6])
    turns = np.sqrt(0.5) * np.array([(1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 0, 1)])
    handle = spice.ckopn(str(path), "others", 0)
    no_rates = np.zeros((3, 3))
    spice.ckw03(handle, 1e6, 3e6, -1000000, "ECLIPJ2000", False, "others", 3, ticks, turns, no_rates, 1, ticks[:1])
    spice.ckcls(handle)
    table = ck.read_ck(path)
    assert table.reference_frame == "ECLIPJ2000"
    assert table.omega_body is None
    np.testing.assert_allclose(np.diff(table.times), 1, rtol=0, atol=3e-7)
    np.testing.assert_allclose(table.attitude.as_matrix()[0], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], rtol=0, atol=1e-14)


def test_rates_at_some_times_only_are_an_error(kernels, monkeypatch):
    turns = np.tile((1.0, 0.0, 0.0, 0.0), (3, 1))
    path = kernels[0].with_name("two.bc")
    handle = spice.ckopn(str(path), "two", 0)
    for first, with_rates in ((1e6, True), (5e6, False)):
        ticks = first + 1e6 * np.arange(3)
        span = (first, first + 2e6)
        spice.ckw03(
            handle, *span, -1000000, "J2000", with_rates, "two", 3, ticks, turns, 0.1 + 0 * turns[:, 1:], 1, ticks[:1]
        )
    spice.ckcls(handle)
    two = [path, *kernels[1:]]
    for block in (ck.TIMES_PER_CALL, 2):
        monkeypatch.setattr(ck, "TIMES_PER_CALL", block)
        with pytest.raises(
            ValueError,
            match=r"^kernels must have rates of 'SC_BODY_1' at all times or at none, got rates at 2026-11-21T"
            r"00:00:01\.5\S+"
            r" and none at 2026-11-21T00:00:05\.5\S+ Ask for the times with rates and the times without rates in two "
            r"calls\.$",
        ):
            pt.files.spice_attitude("SC_BODY_1", [1.5, 2.0, 5.5, 6.0], two, calendar=CALENDAR)
    first_part = pt.files.spice_attitude("SC_BODY_1", [1.5, 2.0], two, calendar=CALENDAR)
    np.testing.assert_allclose(first_part.omega_body, 0.1, rtol=1e-12)
    assert pt.files.spice_attitude("SC_BODY_1", [5.5, 6.0], two, calendar=CALENDAR).omega_body is None


def test_what_is_missing_is_reported(kernels):
    kernels[2].unlink()
    with pytest.raises(
        FileNotFoundError, match=r"m\.bc must have the kernels of its clock and its frame .* no m\.tf\."
    ):
        ck.read_ck(kernels[0])


def test_blocks_of_times_give_the_same_as_all_together(kernels, monkeypatch):
    def table():
        return pt.files.spice_attitude("SC_BODY_1", TIMES, kernels, calendar=CALENDAR)

    whole = table()
    monkeypatch.setattr(ck, "TIMES_PER_CALL", 3)
    np.testing.assert_array_equal(table().quaternion, whole.quaternion)
    np.testing.assert_array_equal(table().omega_body, whole.omega_body)
    assert len(TIMES) > 2 * ck.TIMES_PER_CALL


def test_blocks_of_times_are_reported(kernels, monkeypatch):
    warned = []

    def noted(what, total, wanted):
        warned.append((what, total, wanted))
        return contextlib.nullcontext(warned.append)

    monkeypatch.setattr(ck, "TIMES_PER_CALL", 3)
    monkeypatch.setattr(ck, "bar", noted)
    pt.files.spice_attitude("SC_BODY_1", TIMES[:8], kernels, calendar=CALENDAR, progress=True)
    assert warned == [("times", 8, True), 3, 3, 2]
