"""From one file to another, and back, where a result says its own dates."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt
from poinsot.files.conversions import convert
from tumbling import MOTION

SCENARIO = """\
calendar = {zero = "2026-11-21", scale = "UTC"}
body.moments = [4, 5, 6]
state = {quaternion = [0.5, -0.5, 0.1, 0.7], omega_body = [0.01, 0.02, 0.05]}
times = {stop = 60, count = 31}
"""


@pytest.fixture
def result(tmp_path):
    (tmp_path / "it.toml").write_text(SCENARIO)
    return pt.save(pt.files.read_scenario(tmp_path / "it.toml").propagate(progress=False), tmp_path / "it.nc")


@pytest.mark.parametrize("suffix", [".aem", ".xml", ".a", ".csv", ".bc"])
def test_there_and_back_without_a_date_on_the_command_line(result, tmp_path, suffix):
    for needed in ("astropy", "spiceypy"):
        pytest.importorskip(needed)
    first = convert(result, tmp_path / f"m{suffix}", frame="ICRF")
    second = convert(first, tmp_path / "b.nc", scenario=tmp_path / "it.toml")
    motion, back = pt.load(result), pt.load(second)
    times, slack = (2e-7, 2e-7) if suffix == ".bc" else (1e-9, 1e-14)
    np.testing.assert_allclose(back.times, motion.times, rtol=0, atol=times)
    assert back.provenance == {"calendar": pt.Calendar("2026-11-21", "UTC"), "reference_frame": "ICRF"}
    angle = (motion.attitude.inv() * back.attitude).magnitude()
    assert np.max(angle) < slack
    np.testing.assert_allclose(back.omega_body, motion.omega_body, rtol=0, atol=slack)
    shown = pt.plot.difference(motion, back, angle_unit="rad")  # whose times are rounded
    assert np.max(shown.lines[0].get_ydata()) < slack
    plt.close(shown.figure)
    again = pt.files.read_aem(convert(second, tmp_path / "again.aem"))  # with dates and axes that nobody says again
    assert np.max(again.angle_to(back)) < slack


def test_the_zero_that_is_stated_counts_the_times(result, tmp_path):
    pytest.importorskip("astropy")
    aem, undated = convert(result, tmp_path / "m.aem", frame="ICRF"), tmp_path / "undated.toml"
    undated.write_text(SCENARIO.partition("\n")[2] + 'units.time = "s"\n')
    first = pt.load(convert(aem, tmp_path / "0.nc", scenario=undated))
    later = pt.load(convert(aem, tmp_path / "1.nc", scenario=undated, zero="2026-11-20T23:59:00 UTC"))
    table = pt.files.read_quaternion_csv(convert(aem, tmp_path / "m.csv", zero="2026-11-20T23:59:00 UTC"))
    np.testing.assert_allclose(first.times, pt.load(result).times, rtol=0, atol=1e-9)
    for counted in (later, table):
        np.testing.assert_allclose(counted.times, first.times + 60, rtol=0, atol=1e-9)
    assert later.provenance["calendar"] == table.calendar == pt.Calendar("2026-11-20T23:59:00", "UTC")
    without_unit = tmp_path / "without_unit.toml"
    without_unit.write_text(SCENARIO.partition("\n")[2])
    assert "calendar" not in pt.load(convert(aem, tmp_path / "2.nc", scenario=without_unit)).provenance


def test_what_a_conversion_has_no_use_for_is_refused(result, tmp_path):
    with pytest.raises(ValueError, match=r"^scenario must go with attitudes that become a result, got other"):
        convert(result, tmp_path / "m.csv", scenario=tmp_path / "it.toml")
    for given in ({"zero": "2026-11-21 UTC"}, {"frame": "ICRF"}):
        with pytest.raises(ValueError, match=rf"^{next(iter(given))} must go with attitudes, got two results\.$"):
            convert(result, tmp_path / "m.zarr", **given)


def test_what_is_missing(result, tmp_path):
    with pytest.raises(ValueError, match=r"^reference_frame must be given .* Pass reference_frame=\'ICRF\' for"):
        convert(result, tmp_path / "m.aem")
    undated = pt.save(MOTION, tmp_path / "undated.nc")
    with pytest.raises(
        ValueError, match=r"^calendar must be given .* calendar=Calendar\('2026-11-21T00:00:00', 'UTC'\)\.$"
    ):
        convert(undated, tmp_path / "m.aem", frame="ICRF")
    kernel = convert(result, tmp_path / "m.bc", frame="ICRF")
    (tmp_path / "m.tsc").unlink()
    with pytest.raises(FileNotFoundError, match=r"m\.bc must have the kernels of its clock and its frame .* no m\.tsc"):
        convert(kernel, tmp_path / "m.csv")
