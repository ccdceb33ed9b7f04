"""Observables in scenarios: tables, readings along the motion, files and commands."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

import poinsot as pt
from poinsot.cli import app
from poinsot.files.scenario import read_scenario

TEXT = """\
title = "a top"
[units]
time = "s"
inertia = "kg m2"
[body]
moments = [1.25, 1.0, 0.75]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0.1, 1, 0.2]
[orbits.STATION]
type = "FixedPosition"
mu = 1.0
position = [3, 0, 0]
[times]
stop = 10
count = 11
"""

OBSERVED = """\
[[observe]]
name = "beacon"
type = "ScenarioBeacon"
position = [0, 0, 1]
station = "STATION"
sigma = 0.01
[[observe]]
type = "ScenarioRates"
noise = 0.05
times = ["0.5 s", "1 s", "9.5 s"]
"""


class ScenarioBeacon(pt.Observable):
    position: pt.BodyVector
    station: pt.Orbit

    def unit(self, units):  # noqa: ARG002
        return "km"

    def reading(self, instant):
        place = instant.position(self.station) + instant.attitude.to_space(self.position)
        return pt.functions.norm(place)


class ScenarioRates(pt.Observable):
    components = ("x", "y", "z")
    noise: float = 0.0

    def reading(self, instant):
        return instant.omega_body


@pytest.fixture
def top(tmp_path):
    path = tmp_path / "top.toml"
    path.write_text(TEXT + OBSERVED)
    return path


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "400"})
    assert result.exit_code == code, (result.output, result.exception)
    assert "Traceback" not in result.output
    return result


def test_readings_of_a_scenario_are_those_of_observe(top):
    scenario = read_scenario(top)
    assert "observes: beacon, ScenarioRates" in repr(scenario)
    motion = scenario.propagate(progress=False)
    beacon, rates = scenario.observe(motion)
    own = ScenarioBeacon((0, 0, 1), pt.orbits.FixedPosition(1.0, position=(3, 0, 0)))
    assert np.array_equal(beacon.values, pt.observe(motion, own).values)
    assert (beacon.name, float(beacon.sigma), rates.name, float(rates.sigma)) == ("beacon", 0.01, "ScenarioRates", 0.05)
    assert rates.times.tolist() == [0.5, 1.0, 9.5]
    assert rates.values.shape == (3, 3)
    noisy = scenario.observe(motion, noise=3)
    assert np.array_equal(noisy[0].values, beacon.simulated(3).values)
    assert np.array_equal(noisy[1].values, rates.simulated(4).values)


def test_observables_of_ensembles_vary(top):
    text = top.read_text() + "[ensemble]\nmembers = 4\nseed = 1\n"
    text += '[[ensemble.spread]]\nof = "observe[0].position"\nsize = 0.1\n'
    text += '[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'
    top.write_text(text)
    beacon, rates = read_scenario(top).observe()
    assert (beacon.values.shape, rates.values.shape) == ((4, 11), (4, 3, 3))
    assert np.unique(beacon.values[:, 0]).size == 4


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            ("ScenarioBeacon", "ScenarioBecon"),
            r"line 19: observe\[0\]\.type must name a known type, got 'ScenarioBecon'",
        ),
        (
            ('station = "STATION"', 'station = "STATON"'),
            r"observe\[0\]\.station must be the name of a table under orbits, "
            r"got 'STATON'\. Did you mean 'STATION'\?",
        ),
        (
            ("position = [0, 0, 1]", "positon = [0, 0, 1]"),
            r"unknown key 'positon' in observe\[0\]\. Did you mean 'position'",
        ),
        (("position = [0, 0, 1]\n", ""), r"observe\[0\]\.position must be given, got none"),
        (("position = [0, 0, 1]", "position = [0, 1]"), r"observe\[0\]\.position must have shape \(3,\)"),
        (("sigma = 0.01", "sigma = 0"), r"line 22: observe\[0\]\.sigma must be positive, got 0\.0\. Give the standard"),
        (("sigma = 0.01", 'sigma = "a"'), r"observe\[0\]\.sigma must be a number in your own units, got 'a'"),
        (("noise = 0.05", "noise = 0.05\nname = 'beacon'"), r"observe\[1\]\.name must differ from the names of other"),
        (('times = ["0.5 s", "1 s", "9.5 s"]', "times = []"), r"observe\[1\]\.times must have shape \(n,\), n > 0"),
        (('type = "ScenarioRates"\n', ""), r"observe\[1\]\.type must be given, got none\. Known types are"),
    ],
)
def test_errors_name_the_key(top, change, sentence):
    text = top.read_text().replace(*change)
    assert text != top.read_text()
    top.write_text(text)
    with pytest.raises(ValueError, match=sentence):
        read_scenario(top)


def test_the_body_of_two_is_named(top):
    top.write_text(top.read_text().replace("noise", 'on = "secondary"\nnoise'))
    plan = read_scenario(top).plans[1]
    assert repr(plan.observable) == "ScenarioRates(noise=0.05).on('secondary')"


def test_dates_of_readings(top):
    text = top.read_text().replace('["0.5 s", "1 s", "9.5 s"]', '["2026-11-21T00:00:05 UTC"]')
    top.write_text(text + '[calendar]\nzero = "2026-11-21T00:00:00"\nscale = "UTC"\n')
    plans = read_scenario(top).plans
    assert plans[1].times.tolist() == [5.0]
    assert plans[1].calendar == pt.Calendar("2026-11-21T00:00:00", "UTC")


# ---------------------------------------------------------------------- the command


def test_observe_writes_readings(top, tmp_path):
    assert call("observe", top).stdout == f"{tmp_path}/top.readings.nc\n"
    beacon, rates = pt.files.read_readings(tmp_path / "top.readings.nc")
    expected = read_scenario(top).observe()
    assert np.array_equal(beacon.values, expected[0].values)
    assert np.array_equal(rates.values, expected[1].values)
    assert beacon.attributes["title"] == "a top"
    assert "already exists; use --overwrite or --out PATH." in call("observe", top, code=2).stderr
    call("observe", top, "--overwrite", "--noise", 3)
    assert np.array_equal(
        pt.files.read_readings(tmp_path / "top.readings.nc")[0].values, expected[0].simulated(3).values
    )
    with xarray.open_dataset(tmp_path / "top.readings.nc") as data:
        assert data["readings_0_values"].attrs["long_name"] == "beacon"


def test_a_result_is_observed(top, tmp_path):
    call("run", top)
    call("observe", tmp_path / "top.nc", "--out", tmp_path / "again.nc")
    found = pt.files.read_readings(tmp_path / "again.nc")
    assert np.array_equal(found[0].values, read_scenario(top).observe()[0].values)


SEVERAL = """
[ensemble]
members = 6
seed = 1
[[ensemble.spread]]
of = "state.omega_body"
size = 0.1
"""


def test_results_have_readings_at_the_output_times_as_variables(top, tmp_path):
    call("run", top)
    motion = pt.load(tmp_path / "top.nc")
    expected = read_scenario(top).observe()[0].values
    assert np.array_equal(motion.column("scenario_beacon"), expected)
    assert "scenario_rates" not in motion.dataset  # at other times


def test_readings_of_an_ensemble_fill_a_store(top, tmp_path):
    top.write_text(top.read_text().replace('times = ["0.5 s", "1 s", "9.5 s"]\n', "") + SEVERAL)
    store = tmp_path / "readings.zarr"
    assert call("observe", top, "--out", store).stdout == f"{store}\n"
    expected = read_scenario(top).observe()
    data = pt.load(store)
    assert "quaternion" not in data
    for name, readings in zip(("scenario_beacon", "scenario_rates"), expected, strict=True):
        assert np.array_equal(data[name], readings.values)
    assert "already exists; use --overwrite or --resume." in call("observe", top, "--out", store, code=2).stderr
    call("observe", top, "--out", store, "--resume")
    found = json.loads(call("observe", top, "--out", store, "--overwrite", "--json").stdout)
    assert found == {"files": [str(store)], "variables": ["scenario_beacon", "scenario_rates"]}
    for options, rule in {("--noise", 3): "without --noise", ("--format", "csv"): "of the format nc"}.items():
        assert f"must be for readings {rule}, got" in call("observe", top, "--out", store, *options, code=2).stderr
    assert "--resume must go with --out NAME.zarr" in call("observe", top, "--resume", code=2).stderr
    call("run", top)
    result = tmp_path / "top.nc"
    assert "must be for readings of a scenario, got" in call("observe", result, "--out", store, code=2).stderr
    top.write_text(TEXT + OBSERVED + SEVERAL)
    assert "must be for readings at the output times" in call("observe", top, "--out", store, code=2).stderr
    top.write_text(TEXT + OBSERVED)
    assert "must be for readings of an ensemble" in call("observe", top, "--out", store, code=2).stderr


def test_csv_has_a_file_for_each_observable(top, tmp_path):
    lines = call("observe", top, "--format", "csv").stdout.splitlines()
    assert lines == [f"{tmp_path}/top.{name}.readings.csv" for name in ("beacon", "ScenarioRates")]
    station = pt.orbits.FixedPosition(1.0, position=(3, 0, 0))
    back = pt.files.read_readings_csv(lines[0], ScenarioBeacon((0, 0, 1), station))
    assert np.array_equal(back.values, read_scenario(top).observe()[0].values)
    assert "pt.files.read_readings_csv" in call("info", lines[0]).stdout


def test_json_and_info(top, tmp_path):
    found = json.loads(call("observe", top, "--json").stdout)
    assert found["files"] == [f"{tmp_path}/top.readings.nc"]
    assert [(each["name"], each["absent"]) for each in found["readings"]] == [("beacon", 0), ("ScenarioRates", 0)]
    output_text = call("info", tmp_path / "top.readings.nc").stdout
    assert output_text.splitlines()[0] == "Readings top.readings.nc"
    assert "  Readings of beacon\n" in output_text
    facts = json.loads(call("info", tmp_path / "top.readings.nc", "--json").stdout)
    assert (facts["kind"], facts["readings"][0]["units"]) == ("readings", "km")


def test_plots_of_readings(top, tmp_path):
    top.write_text(top.read_text().partition("[[observe]]\ntype")[0])
    call("observe", top)
    path = tmp_path / "top.readings.nc"
    assert call("plot", path).stdout == f"{tmp_path}/top.readings-readings.png\n"
    call("plot", path, tmp_path / "a.png", "--kind", "phased", "--period", "3.5", "--with", path)
    call("plot", path, tmp_path / "b.png", "--kind", "phase_plane", "--period", "3.5,2", "--time", "1:9")
    wrong = {
        ("--kind", "polhode"): "--kind must be one of readings, phased, phase_plane for readings, got 'polhode'.",
        ("--kind", "phased"): "--period must be given for --kind phased, got none.",
        ("--period", "3"): "--period must go with --kind phased or phase_plane, got --kind readings.",
        ("--kind", "phased", "--period", "3,4"): "--period must be 1 numbers for --kind phased, got '3,4'.",
        ("--kind", "phased", "--period", "x"): "--period must be numbers separated by commas, got 'x'.",
        ("--with", path): f"--with must go with a result, got the readings {path}.",
        ("--part", "a"): f"--part must go with a result, got the readings {path}.",
    }
    for options, sentence in wrong.items():
        assert sentence in call("plot", path, tmp_path / "c.png", *options, code=2).stderr
    call("run", top)
    assert (
        "--period must go with readings, got the result"
        in call("plot", tmp_path / "top.nc", "--period", "3", code=2).stderr
    )


LIGHT = """\
[[observe]]
type = "LightCurve"
shape = { type = "Ellipsoid", semiaxes = [3, 2, 1], mass = 1 }
law = { type = "Lambert", albedo = 0.2 }
sun = "STATION"
observer = "STATION"
kind = "relative"
light_time = false
"""


def test_pictures_of_a_result_with_a_light_curve(top, tmp_path):
    """The plane of the sky, and arrows to the Sun and to the observer in the scene and in the animation."""
    path = tmp_path / "lit.toml"
    path.write_text(TEXT + LIGHT)
    call("run", path)
    result = tmp_path / "lit.nc"
    assert call("plot", result, "--kind", "sky").stdout == f"{tmp_path}/lit-sky.png\n"
    call("view", result)
    assert 'data-part="observer" checked' in (tmp_path / "lit.html").read_text()
    call("animate", result, "--seconds", "0.1")
    plain = call("run", top)
    assert plain.exit_code == 0
    sentence = "--kind sky must be of a scenario with a light curve, [[observe]] type = 'LightCurve', got none."
    assert sentence in call("plot", tmp_path / "top.nc", "--kind", "sky", code=2).stderr
    call("view", tmp_path / "top.nc")
    assert 'data-part="observer"' not in (tmp_path / "top.html").read_text()


ASTEROID = """\
title = "asteroid"
[units]
inertia = "kg km2"
[calendar]
zero = "2026-11-21T00:00:00"
scale = "TDB"
[body]
type = "Body.from_shape"
shape = { type = "Ellipsoid", semiaxes = [0.9, 0.6, 0.5], density = 2e12 }
[state]
quaternion = [1, 0, 0, 0]
omega_body = ["0 deg/h", "10 deg/h", "120 deg/h"]
[orbits.SUN]
type = "planet_orbit"
body = "mars"
attractor = "sun"
start = "2026-11-21T00:00:00 TDB"
stop = "2026-11-22T00:00:00 TDB"
[orbits.EARTH]
type = "planet_orbit"
body = "mars"
attractor = "earth"
start = "2026-11-21T00:00:00 TDB"
stop = "2026-11-22T00:00:00 TDB"
[times]
start = "1 h"
stop = "5 h"
count = 9
[[observe]]
name = "night 1"
type = "LightCurve"
shape = { type = "Ellipsoid", semiaxes = [0.9, 0.6, 0.5], density = 2e12 }
law = { type = "LommelSeeliger", albedo = 0.2 }
sun = "SUN"
observer = "EARTH"
kind = "KIND"
sigma = 0.02
"""


def test_light_curves_in_the_formats_of_asteroids(tmp_path):
    shape, law = pt.shapes.Ellipsoid((0.9, 0.6, 0.5), density=2e12), pt.observables.LommelSeeliger(albedo=0.2)
    calendar = pt.Calendar("2026-11-21T00:00:00", "TDB")
    path = tmp_path / "asteroid.toml"
    path.write_text(ASTEROID.replace("KIND", "relative"))
    scenario = read_scenario(path)
    (seen,) = scenario.observe()
    assert call("observe", path, "--format", "damit").stdout == f"{tmp_path}/asteroid.lc.txt\n"
    (back,) = pt.files.read_damit(tmp_path / "asteroid.lc.txt", shape, law, calendar=calendar)
    assert np.array_equal(back.values, seen.values)
    late = seen.times - back.times
    assert np.all((late > 60) & (late < 2000))  # light time of Mars
    model = pt.observe(pt.propagate(scenario.system, scenario.state, back.times), back.observable)
    np.testing.assert_allclose(model.values, seen.values, rtol=1e-8, atol=0)  # positions are rounded to 0.15 m
    info = call("info", tmp_path / "asteroid.lc.txt").stdout.splitlines()
    assert info[:2] == ["Light curves, DAMIT: 1, 0 of which are calibrated", "  data: 9"]
    assert "must be magnitudes, in mag, for ALCDEF" in call("observe", path, "--format", "alcdef", code=2).stderr
    path.write_text(ASTEROID.replace("KIND", "magnitude"))
    assert "must be fluxes of a LightCurve" in call("observe", path, "--format", "damit", "--overwrite", code=2).stderr
    assert call("observe", path, "--format", "alcdef").stdout == f"{tmp_path}/asteroid.alcdef.txt\n"
    (mags,) = pt.files.read_alcdef(tmp_path / "asteroid.alcdef.txt", scenario.plans[0].observable, calendar=calendar)
    (seen,) = read_scenario(path).observe()
    assert np.array_equal(mags.values, seen.values)
    assert mags.sigma.tolist() == [0.02] * 9
    np.testing.assert_allclose(mags.times, seen.times, rtol=0, atol=2e-10)
    assert call("info", tmp_path / "asteroid.alcdef.txt").stdout.startswith("Light curves, ALCDEF: 1\n")


def test_shapes_and_spins_are_described(tmp_path):
    mesh = pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0)
    assert "Shape: 8 vertices, 12 faces" in call("info", pt.files.write_damit_shape(mesh, tmp_path / "s.txt")).stdout
    (tmp_path / "spin.txt").write_text("251 -63 5.27\n2433827.771536 10\n")
    assert "pole: longitude 251 deg, latitude -63 deg" in call("info", tmp_path / "spin.txt").stdout


def test_what_observe_refuses(top, tmp_path):
    bare = tmp_path / "bare.toml"
    bare.write_text(TEXT)
    assert "bare.toml must have a table [[observe]], got none." in call("observe", bare, code=2).stderr
    assert (
        "--format must be one of nc, csv, damit, alcdef, got 'txt'."
        in call("observe", top, "--format", "txt", code=2).stderr
    )
    assert "must be magnitudes, in mag, for ALCDEF" in call("observe", top, "--format", "alcdef", code=2).stderr
    assert not [*tmp_path.glob("*.txt")]
    assert (
        "--out must end in .csv for the format csv, got a.nc."
        in call("observe", top, "--format", "csv", "--out", tmp_path / "a.nc", code=2).stderr
    )
    assert "No such file" in call("observe", tmp_path / "none.toml", code=2).stderr


def test_a_propagation_that_stops_writes_nothing(top, tmp_path):
    text = top.read_text().replace("[times]", "[run]\nformulation = 'euler_angles'\n[times]")
    text = text.replace("omega_body = [0.1, 1, 0.2]", "omega_body = [1, 0, 0]").replace(
        "[1.25, 1.0, 0.75]", "[1, 1, 1]"
    )
    top.write_text(text.replace("quaternion = [1, 0, 0, 0]", "quaternion = [0.6, 0.8, 0, 0]"))
    assert "No readings were written." in call("observe", top, code=3).stderr
    assert not Path(tmp_path / "top.readings.nc").exists()
