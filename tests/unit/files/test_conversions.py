"""From one file to another, and back, where a result says its own dates."""

import numpy as np
import pytest
from tumbling import MOTION

import poinsot as pt
from poinsot.files.conversions import convert

SCENARIO = """\
calendar = {zero = "2026-11-21", scale = "UTC"}
body.moments = [4, 5, 6]
state = {quaternion = [0.5, -0.5, 0.1, 0.7], omega_body = [0.01, 0.02, 0.05]}
times = {stop = 60, count = 31}
"""


@pytest.fixture
def result(tmp_path):
    (tmp_path / "it.toml").write_text(SCENARIO)
    return pt.save(pt.read_scenario(tmp_path / "it.toml").propagate(progress=False), tmp_path / "it.nc")


@pytest.mark.parametrize("suffix", [".aem", ".a", ".csv", ".bc"])
def test_there_and_back_without_a_date_on_the_command_line(result, tmp_path, suffix):
    for needed in ("astropy", "spiceypy"):
        pytest.importorskip(needed)
    first = convert(result, tmp_path / f"m{suffix}", frame="ICRF")
    second = convert(first, tmp_path / "b.nc", scenario=tmp_path / "it.toml")
    motion, back = pt.load(result), pt.load(second)
    slack = 2e-7 if suffix == ".bc" else 1e-9
    np.testing.assert_allclose(back.times - back.times[0], motion.times, atol=slack)
    angle = (motion.attitude.inv() * back.attitude).magnitude()
    assert np.max(angle) < slack
    np.testing.assert_allclose(back.omega_body, motion.omega_body, atol=slack)


def test_what_is_missing(result, tmp_path):
    with pytest.raises(ValueError, match=r"reference_frame must be given .* or --frame ICRF on the command line"):
        convert(result, tmp_path / "m.aem")
    undated = pt.save(MOTION, tmp_path / "undated.nc")
    with pytest.raises(
        ValueError, match=r"calendar must be given .* or --zero '2026-11-21T00:00:00 UTC' on the command"
    ):
        convert(undated, tmp_path / "m.aem", frame="ICRF")
    kernel = convert(result, tmp_path / "m.bc", frame="ICRF")
    (tmp_path / "m.tsc").unlink()
    with pytest.raises(FileNotFoundError, match=r"m\.bc must have the kernels of its clock and its frame .* no m\.tsc"):
        convert(kernel, tmp_path / "m.csv")
