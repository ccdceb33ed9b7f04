"""The commands about scenarios and results, as a user runs them."""

import inspect
import json
import os
import re
import shutil
import signal
import threading
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import forked
import poinsot as pt
from poinsot.cli import app, plots
from poinsot.cli.plots import KINDS, OF_TWO, ONLY_OF_TWO
from poinsot.files import scenario as scenarios
from poinsot.plot.ensembles import QUANTITIES
from poinsot.propagation.column_reader import MotionRows

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
WIDE = {"COLUMNS": "400"}

TOP = """\
title = "a top"
body.moments = [1.25, 1.0, 0.75]
state = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 1, 0.2]}
forces = [{type = "UniformGravity", weight = 0.5, center_of_mass = [1, 0, 0]}]
times = {stop = 10, count = 101}
"""


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], env=WIDE)
    assert result.exit_code == code, (result.output, result.exception)
    assert "\x1b" not in result.output
    assert "Traceback" not in result.output
    return result


@pytest.fixture
def top(tmp_path):
    path = tmp_path / "top.toml"
    path.write_text(TOP)
    return path


# ------------------------------------------------------------------ run


LONG = {"apophis_ensemble", "cubesat"}  # `make docs` runs all for the gallery


@pytest.mark.samples
@pytest.mark.parametrize(
    "example",
    [pytest.param(one, marks=[pytest.mark.slow] * (one.stem in LONG)) for one in EXAMPLES],
    ids=lambda example: example.stem,
)
def test_example_runs_and_says_what_it_is(example, tmp_path):
    result = call("run", example, "--out", tmp_path)
    motion = pt.load(tmp_path / f"{example.stem}.nc")
    assert result.stdout == f"{tmp_path / example.stem}.nc\n"
    assert motion.provenance["scenario"] == example.read_text()
    assert motion.provenance["title"]
    assert not motion.failures
    assert np.max(np.abs(motion.norm_error)) < 1e-12


def test_examples_are_what_others_published():
    """JEOD's state after eight hours, and the satellite of the paper in 42 digits."""
    jeod = scenarios.read_scenario(EXAMPLES[0].with_name("jeod_run_10a.toml")).propagate()
    assert jeod.times[-1] == 28800
    wanted = (-1.97989570839746e-05, -0.001080027400090759, -0.0007098670173048437)
    np.testing.assert_allclose(jeod.omega_body[-1], wanted, rtol=0, atol=7e-16)
    paper = scenarios.read_scenario(EXAMPLES[0].with_name("paper_satellite.toml")).propagate()
    q = (0.763082132724031, 0.423729419181828, 0.457167932594955, 0.170752802155719)
    np.testing.assert_allclose(paper.quaternion[-1], q, rtol=0, atol=2e-12)


def test_result_is_repeated_to_the_bit_in_another_process(top, tmp_path):
    call("run", top)
    code = "from poinsot.cli import app; app()"
    done = forked.run(code, "run", tmp_path / "top.nc", "--out", tmp_path / "again")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [str(tmp_path / "again" / "top.nc"), "The two results agree bit for bit."]
    assert done.stderr == ""
    assert (
        pt.load(tmp_path / "again" / "top.nc").quaternion.tobytes() == pt.load(tmp_path / "top.nc").quaternion.tobytes()
    )


def test_result_is_repeated_next_to_itself(top, tmp_path):
    call("run", top)
    assert call("run", tmp_path / "top.nc").stdout == f"{tmp_path}/top-again.nc\nThe two results agree bit for bit.\n"
    assert "top-again.nc already exists" in call("run", tmp_path / "top.nc", code=2).stderr
    assert pt.load(tmp_path / "top-again.nc").quaternion.tobytes() == pt.load(tmp_path / "top.nc").quaternion.tobytes()


def test_partial_result_is_repeated_as_far_as_it_goes(top, tmp_path, monkeypatch):
    right = pt.propagate

    def stopped(*arguments, **options):
        motion = right(*arguments, **options)
        half = pt.Trajectory(
            motion.system,
            motion.initial,
            motion.times[:50],
            MotionRows({name: values[:50] for name, values in motion.phase.items()}),
            motion.run,
        )
        raise pt.PropagationError("it stopped.", 5.0, half)

    monkeypatch.setattr(scenarios, "propagate", stopped)
    call("run", top, code=3)
    monkeypatch.undo()
    result = call("run", tmp_path / "top.partial.nc")
    assert result.stdout.splitlines()[1] == "The two results agree bit for bit at all output times of the original."
    assert pt.load(tmp_path / "top.partial-again.nc").times.size == 101


def test_result_of_a_body_with_parts_is_repeated_too(tmp_path):
    wheel, damper = pt.parts.ReactionWheel((0, 0, 1), 0.1, 1e-4, 2e-3), pt.parts.KaneDamper(0.4, 0.3)
    system = pt.System(pt.Body((6, 8, 10)), wheel, damper)
    state = system.state((1, 0, 0, 0), omega_body=(0.8, 0.02, 0.05), reaction_wheel=[2.0])
    pt.save(pt.propagate(system, state, [0, 1, 2.5]), tmp_path / "it.nc")
    assert "The two results agree bit for bit." in call("run", tmp_path / "it.nc", "--out", tmp_path / "b").stdout
    assert "ReactionWheel" in call("info", tmp_path / "it.nc").stdout
    of_parts = ("plot", tmp_path / "it.nc", "--kind", "part_variables")
    assert call(*of_parts, code=2).stderr == "poinsot: --part must be one of reaction_wheel, kane_damper, got none.\n"
    assert call(*of_parts, "--part", "kane_damper").stdout == f"{tmp_path}/it-part_variables.png\n"


def test_result_of_python_is_repeated_too(tmp_path):
    body = pt.Body((1.25, 1.0, 0.75))
    state = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.2))
    pt.save(pt.propagate(pt.System(body), state, [0, 1, 2.5]), tmp_path / "it.nc")
    assert "The two results agree bit for bit." in call("run", tmp_path / "it.nc", "--out", tmp_path / "b").stdout
    assert call("info", tmp_path / "it.nc", "--scenario").stdout.startswith("# Written for a system made in Python.")


def test_result_that_differs_is_reported(top, tmp_path, monkeypatch):
    call("run", top)
    right = pt.propagate

    def other(system, state, times, **options):
        return right(system, state, times, **(options | {"tolerance": 1e-6}))

    monkeypatch.setattr(scenarios, "propagate", other)
    result = call("run", tmp_path / "top.nc", "--out", tmp_path / "b", code=1)
    assert "The quaternions and momenta differ by up to" in result.stdout
    assert "Packages with different versions: none." in result.stdout


def test_outputs_are_those_that_the_scenario_names(top, tmp_path):
    top.write_text(TOP + '[outputs]\nresult = "a b.zarr"\nplot = "p.png"\nview = "v.html"\n')
    pytest.importorskip("zarr")
    lines = call("run", top, "--out", tmp_path / "new" / "folder").stdout.splitlines()
    assert lines == [str(tmp_path / "new" / "folder" / name) for name in ("a b.zarr", "p.png", "v.html")]
    assert (tmp_path / "new" / "folder" / "p.png").stat().st_size > 5000


def test_out_names_the_file_of_the_result(top, tmp_path):
    top.write_text(TOP + '[outputs]\nresult = "a.nc"\nplot = "p.png"\n')
    lines = call("run", top, "--out", tmp_path / "new" / "y.nc").stdout.splitlines()
    assert lines == [str(tmp_path / "new" / name) for name in ("y.nc", "p.png")]
    wrong = call("run", top, "--out", top, code=2)
    assert f"--out must be a folder, NAME.nc or NAME.zarr, got the file {top}." in wrong.stderr
    for name in ("y.h5", "y.NC", "y.txt"):
        wrong = call("run", top, "--out", tmp_path / name, code=2)
        assert f"--out must be a folder, NAME.nc or NAME.zarr, got the file {tmp_path / name}." in wrong.stderr
        assert not (tmp_path / name).exists()


def test_missing_table_is_named(top):
    top.write_text(TOP.replace("state = {", "stat = {"))
    assert "unknown key 'stat'" in call("run", top, code=2).stderr
    top.write_text("\n".join(line for line in TOP.splitlines() if not line.startswith("state")))
    assert call("run", top, code=2).stderr == f"poinsot: {top}: missing table [state].\n"


@pytest.mark.parametrize("there", ["top.nc", "top.partial.nc", "p.png"])
def test_nothing_is_replaced_without_a_message(top, tmp_path, there):
    top.write_text(TOP + '[outputs]\nplot = "p.png"\n')
    (tmp_path / there).write_text("mine")
    result = call("run", top, code=2)
    assert f"{there} already exists; use --overwrite or --out DIR." in result.stderr
    assert (tmp_path / there).read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2
    call("run", top, "--overwrite")


def test_run_that_stops_keeps_what_it_has(tmp_path):
    """Euler angles end where the second one is zero."""
    path = tmp_path / "top.toml"
    text = TOP.replace("[0.1, 1, 0.2]", "[1, 0, 0]").replace("[1, 0, 0, 0]", "[0.8, -0.6, 0, 0]")
    path.write_text(text.replace("forces = [", "# ") + 'run = {formulation = "euler_angles"}\n')
    result = call("run", path, code=3)
    assert "propagation stopped at t = " in result.stderr
    assert f"The output times reached so far are in {tmp_path / 'top.partial.nc'}." in result.stderr
    motion = pt.load(tmp_path / "top.partial.nc")
    assert 0 < motion.times.size < 101
    assert motion.provenance["scenario"] == path.read_text()
    assert not (tmp_path / "top.nc").exists()


def test_ctrl_c_keeps_what_there_is(tmp_path, monkeypatch):
    path = tmp_path / "long.toml"
    path.write_text(TOP.replace("stop = 10, count = 101", "stop = 1e9, step = 1e3"))
    right = pt.propagate

    def interrupted(system, state, times, **options):
        right(system, state, times[:2])  # builds the integrator
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        return right(system, state, times, **options)

    monkeypatch.setattr(scenarios, "propagate", interrupted)
    result = call("run", path, code=130)
    assert f"The output times reached so far are in {tmp_path / 'long.partial.nc'}." in result.stderr
    assert 0 < pt.load(tmp_path / "long.partial.nc").times.size < 1_000_001


def test_threads_and_failures_of_members(top, tmp_path):
    spread = '[ensemble]\nmembers = 5\nseed = 1\n[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'
    top.write_text(TOP + spread)
    call("run", top, "--threads", 1)
    call("run", top, "--threads", 2, "--out", tmp_path / "b")
    one, two = (pt.load(path) for path in (tmp_path / "top.nc", tmp_path / "b" / "top.nc"))
    assert one.quaternion.shape == (5, 101, 4)
    assert one.quaternion.tobytes() == two.quaternion.tobytes()
    for command in (("plot", tmp_path / "top.nc", "--kind", "polhode"), ("view", tmp_path / "top.nc")):
        assert call(*command, code=2).stderr.endswith("got an ensemble of 5 members. Take one: --member 0.\n")
        message = call(*command, "--member", 5, code=2).stderr
        assert message == "poinsot: --member must lie within [-5, 4], got 5.\n"
    call("plot", tmp_path / "top.nc", "--kind", "attitude_error")  # from the median attitude, which one motion has not
    alone = ("plot", tmp_path / "top.nc", tmp_path / "one.png", "--kind", "attitude_error", "--member", "0")
    assert "must be given for one motion, got none. Only members have a median attitude." in call(*alone, code=2).stderr


def test_members_that_stop_are_reported_and_end_in_their_own_status(top, tmp_path):
    spread = '[ensemble]\nmembers = 12\nseed = 1\n[[ensemble.spread]]\nof = "state.turn"\nsize = 0\n'
    text = TOP.replace("[0.1, 1, 0.2]", "[1, 0, 0]").replace("[1, 0, 0, 0]", "[0.8, -0.6, 0, 0]")
    top.write_text(text.replace("forces = [", "# ") + 'run = {formulation = "euler_angles"}\n' + spread)
    message = call("run", top, code=3).stderr.splitlines()
    assert message[0] == "12 of 12 members stopped before the last time."
    assert message[1].startswith("member 0: propagation stopped at t = ")
    assert len(message) == 12
    assert message[-1] == "... and 2 more, which `motion.failures` lists."
    assert "at the last time: 0 of 12 members" in call("info", tmp_path / "top.nc").stdout


def test_what_would_be_refused_after_a_run_is_refused_before(top, tmp_path):
    spread = '[ensemble]\nmembers = 5\nseed = 1\n[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'
    top.write_text(TOP + '[outputs]\nview = "v.html"\n' + spread)
    assert "v.html must be of one motion" in call("run", top, code=2).stderr
    top.write_text(TOP + spread.replace("= 5", "= 100_000"))
    usage = shutil._ntuple_diskusage(10**9, 10**9 - 10**8, 10**8)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(shutil, "disk_usage", lambda _: usage)
        message = call("run", top, code=2).stderr
    assert f"{tmp_path} must have room for some 1515 MB, but 100 MB are free." in message
    assert [path.name for path in tmp_path.iterdir()] == ["top.toml"]


def test_warnings_are_sentences(tmp_path):
    path = tmp_path / "low.toml"
    path.write_text(
        EXAMPLES[0].with_name("paper_satellite.toml").read_text().replace("mu =", "radius = 6378.137\nmu =")
    )
    result = call("run", path)
    assert result.stderr.startswith("warning: ")
    assert "below the surface" in result.stderr


# ------------------------------------------------------------------ the other commands


def test_new_scenario_runs_as_it_is_and_with_everything_that_it_offers(tmp_path):
    path = tmp_path / "mine.toml"
    assert call("new", path).stdout == f"{path}\n"
    call("run", path)
    assert "already exists; use --overwrite." in call("new", path, code=2).stderr
    offered = re.sub(r"(?m)^# (?=\w+ = |\[)", "", path.read_text())
    without = re.sub(r"(?m)^(moments|quaternion) = .*\n", "", offered)  # of which another form is offered
    (tmp_path / "all.toml").write_text(without)
    found = pt.files.read_scenario(tmp_path / "all.toml")
    assert np.array_equal(found.system.body.inertia, pt.Body.from_box(100, (1, 1.5, 2)).inertia)
    assert found.state.conjugate_momenta.shape == (100, 4)
    assert set(found.outputs) == {"result", "plot", "view"}


def test_schema_is_json():
    assert json.loads(call("new", "--schema").stdout)["title"] == "poinsot scenario"


def test_info(top, tmp_path):
    call("run", top)
    output_text = call("info", tmp_path / "top.nc").stdout
    for words in ("a top", "UniformGravity", "times: 101", "drift: energy", "llvmlite", "can be run again: yes"):
        assert words in output_text
    assert call("info", tmp_path / "top.nc", "--scenario").stdout == TOP
    message = call("info", top).stdout
    for words in ("a top", "body: Body(", "force: UniformGravity(", "start: quaternion (1, 0, 0, 0), ", "times: 101"):
        assert words in message


def test_json_has_the_numbers_of_a_result(top, tmp_path):
    output_text = json.loads(call("run", top, "--json").stdout)
    path = tmp_path / "top.nc"
    motion = pt.load(path)
    assert output_text["result"] == str(path)
    assert output_text["summary"]["norm_error"] == motion.summary["norm_error"]
    assert output_text["summary"]["steps"] == motion.run.steps
    again = json.loads(call("run", path, "--json").stdout)
    assert again["same"]
    message = json.loads(call("info", path, "--json").stdout)
    assert (message["kind"], message["title"], message["rerunnable"]) == ("result", "a top", True)
    assert message["times"] == {"count": 101, "first": 0.0, "last": 10.0}
    assert message["summary"] == {**motion.summary, "wall_time": None}
    assert message["lines"]["force"] == ["UniformGravity(weight=0.5, center_of_mass=[1.0, 0.0, 0.0])"]
    of_scenario = json.loads(call("info", top, "--json").stdout)
    assert (of_scenario["kind"], of_scenario["times"]["count"]) == ("scenario", 101)


def test_one_member_and_one_time(top, tmp_path):
    top.write_text(
        TOP + '[ensemble]\nmembers = 3\nseed = 1\n[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'
    )
    call("run", top)
    path = tmp_path / "top.nc"
    motion = pt.load(path).member(1)
    output_text = call("info", path, "--member", 1, "--time", 3.14).stdout
    assert "  members: " not in output_text
    (written,) = re.findall(r"at t = 3\.1: angular velocity \((.*)\)", output_text)
    np.testing.assert_allclose([float(x) for x in written.split(",")], motion.omega_body[31], rtol=1e-8)
    outside = call("info", path, "--member", 1, "--time", 1e9, code=2).stderr
    assert "--time must lie within the times of the result, 0 ... " in outside
    assert outside.endswith(", got 1000000000.\n")
    assert "--time must go with --member" in call("info", path, "--time", 3, code=2).stderr
    assert "--time must go with a result" in call("info", top, "--time", 3, code=2).stderr
    assert "--member must go with a result" in call("info", top, "--member", 3, code=2).stderr
    call("convert", path, tmp_path / "one.nc", "--member", 1)
    assert np.array_equal(pt.load(tmp_path / "one.nc").quaternion, motion.quaternion)
    call("convert", path, tmp_path / "one.csv", "--member", 1)
    assert (
        "--member must go with a result"
        in call("convert", tmp_path / "one.csv", tmp_path / "x.nc", "--scenario", top, "--member", 1, code=2).stderr
    )


def test_pictures_and_pages_of_some_times(top, tmp_path, monkeypatch):
    call("run", top)
    path, seen = tmp_path / "top.nc", []

    def watch(motion, path, *_):
        seen.append(motion.times)
        return path

    monkeypatch.setattr(plots, "viewed", watch)
    for window, first, count in (("2:3", 20, 11), ("2:", 20, 81), (":3", 0, 31), (":", 0, 101)):
        call("view", path, f"--time={window}")
        assert np.array_equal(seen[-1], pt.load(path).times[first : first + count])
    call("plot", path, tmp_path / "coarse.png", "--dpi", 40, "--time", "2:3")
    call("plot", path, tmp_path / "fine.png", "--dpi", 80, "--time", "2:3")
    wide = [int.from_bytes((tmp_path / name).read_bytes()[16:20]) for name in ("coarse.png", "fine.png")]
    assert wide[1] == pytest.approx(2 * wide[0], abs=2)
    for window, message in (("5", "must be FROM:TO"), ("a:b", "must be FROM:TO"), ("20:30", "must meet times")):
        assert f"--time {message}" in call("plot", path, "--time", window, code=2).stderr


WITH_ANOTHER = ("attitude_error", "difference")

FREE = """\
body.moments = [4, 5, 6]
state = {quaternion = [0.5, -0.5, 0.1, 0.7], omega_body = [0.1, 1, 0.2]}
times = {stop = 10, count = 101}
forces = [{type = "GravityGradient", orbit = "o"}]
orbits.o = {type = "KeplerOrbit.from_vectors", mu = 1e-12, position = [1, 0, 0], velocity = [0, 1e-6, 0]}
"""


def test_every_plot_of_the_package_is_a_kind():
    first = {name: next(iter(inspect.signature(getattr(pt.plot, name)).parameters)) for name in pt.plot.__all__}
    assert set(KINDS) == {name for name, each in first.items() if each in ("motion", "body", "ensemble")}


@pytest.fixture(scope="module")
def free(tmp_path_factory):
    folder = tmp_path_factory.mktemp("free")
    (folder / "free.toml").write_text(FREE)
    call("run", folder / "free.toml")
    call("run", folder / "free.nc", "--out", folder / "b")
    return folder


@pytest.mark.parametrize("kind", KINDS)
def test_every_plot_has_a_file_of_its_kind_or_is_not_of_one_body(free, kind):
    more = ("--with", free / "b" / "free.nc") if kind in WITH_ANOTHER else ()
    arguments = ("plot", free / "free.nc", "--kind", kind, *more)
    if kind in {"part_variables", "histogram", "sky", *ONLY_OF_TWO}:
        call(*arguments, code=2)
        return
    assert call(*arguments).stdout == f"{free}/free-{kind}.png\n"
    assert (free / f"free-{kind}.png").stat().st_size > 5000
    assert "--overwrite" in call(*arguments, code=2).stderr


def test_plot_in_other_units_and_as_vectors(top, tmp_path):
    call("run", top)
    call("plot", tmp_path / "top.nc", tmp_path / "a.svg", "--kind", "euler_angles")
    call("plot", tmp_path / "top.nc", tmp_path / "b.svg", "--kind", "euler_angles", "--angle-unit", "arcsec")
    assert (tmp_path / "a.svg").read_bytes().startswith(b"<?xml")
    assert (tmp_path / "a.svg").stat().st_size != (tmp_path / "b.svg").stat().st_size
    call("plot", tmp_path / "top.nc", tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


def test_options_of_plot_that_do_not_fit_are_reported(top, tmp_path):
    call("run", top)
    result = tmp_path / "top.nc"
    for arguments, output_text in (
        (("--kind", "difference"), "--with must be another result"),
        (("--with", result), "--with must go with --kind attitude_error or difference, got --kind quaternions."),
        (("--angle-unit", "rad"), "--angle-unit must go with --kind attitude_error or difference or euler_angles or "),
        (("--time-unit", "h"), "--time-unit must be left out where the unit of time of the system has no known length"),
        (("--member", "1"), "the result must be an ensemble to have members"),
        (("--kind", "part_variables"), "the result must be of a body with a part that has variables, got one without"),
        (("--kind", "roll_pitch_yaw"), "the result must contain an orbit"),
        (("--kind", "nothing"), "one of angular_momentum"),
        ((tmp_path / "x.exe",), "x.exe must end in .png, .pdf, .svg"),
    ):
        assert output_text in call("plot", result, *arguments, code=2).stderr
    top.write_text(TOP.replace("count = 101", "count = 51"))
    call("run", top, "--out", tmp_path / "b")
    other = tmp_path / "b" / "top.nc"
    message = call("plot", result, "--kind", "difference", "--with", other, code=2).stderr
    assert message.startswith("poinsot: --with must have the same times, got 51 times")


def test_orbit_of_roll_pitch_yaw_is_named_where_there_are_several(tmp_path):
    two = FREE.replace('orbit = "o"}', 'orbit = "o"}, {type = "GravityGradient", orbit = "p"}')
    (tmp_path / "two.toml").write_text(
        two + FREE.splitlines()[-1].replace("orbits.o", "orbits.p").replace("1e-6", "8e-7")
    )
    call("run", tmp_path / "two.toml")
    arguments = ("plot", tmp_path / "two.nc", "--kind", "roll_pitch_yaw")
    output_text = "--orbit must name one orbit, got {}. There are 1: KeplerOrbit; 2: KeplerOrbit."
    assert output_text.format("none") in call(*arguments, code=2).stderr
    assert output_text.format(3) in call(*arguments, "--orbit", 3, code=2).stderr
    call(*arguments, "--orbit", 2)


def test_view(top, tmp_path):
    call("run", top)
    assert call("view", tmp_path / "top.nc").stdout == f"{tmp_path}/top.html\n"
    call("view", tmp_path / "top.nc", code=2)


def test_convert(top, tmp_path):
    pytest.importorskip("astropy")
    top.write_text('units = {time = "s"}\n' + TOP)
    call("run", top)
    result, motion = tmp_path / "top.nc", pt.load(tmp_path / "top.nc")
    message = ("--zero", "2026-11-21T00:00:00 UTC", "--frame", "ICRF")
    for suffix in ("aem", "csv", "a"):
        attitudes = tmp_path / f"top.{suffix}"
        call("convert", result, attitudes, *message)
        assert "top" in call("convert", result, attitudes, *message, code=2).stderr
        call("convert", attitudes, tmp_path / f"{suffix}.nc", "--scenario", top)
        back = pt.load(tmp_path / f"{suffix}.nc")
        np.testing.assert_allclose(back.attitude.as_matrix(), motion.attitude.as_matrix(), rtol=0, atol=1e-9)
        np.testing.assert_allclose(back.omega_body, motion.omega_body, rtol=0, atol=1e-9)
    assert "--scenario must be given for" in call("convert", tmp_path / "top.csv", tmp_path / "x.nc", code=2).stderr
    assert "must end in .nc" in call("convert", result, tmp_path / "x.exe", code=2).stderr


def test_help_teaches_and_has_the_exit_codes():
    for command in ("run", "plot", "view", "animate", "info", "convert", "new", "paper", "verify"):
        output_text = " ".join(call(command, "--help").stdout.split())
        assert f"For example: • poinsot {command}" in output_text
        assert "Exit status: 0 (success), " in output_text
        assert "130 (interrupted by Ctrl-C), 143 (terminated by SIGTERM)." in output_text
        assert call(command, "-h").stdout == call(command, "--help").stdout
    assert "1 (the repeated result differs from the original)" in " ".join(call("run", "-h").stdout.split())


def test_wrong_files_end_in_one_sentence(tmp_path):
    (tmp_path / "wrong.toml").write_text(TOP.replace("moments", "momens"))
    (tmp_path / "empty.nc").write_bytes(b"")
    for command in (
        ("run", "wrong.toml"),
        ("info", "wrong.toml"),
        ("run", "empty.nc"),
        ("plot", "empty.nc"),
        ("run", "no.toml"),
    ):
        message = call(command[0], tmp_path / command[1], code=2).stderr
        assert message.startswith("poinsot: ")
        assert message.count("\n") == 1
    assert len(list(tmp_path.iterdir())) == 2


# ------------------------------------------------------------------ stores

SPREAD = '[ensemble]\nmembers = 20\nseed = 1\n[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'


@pytest.fixture
def tops(top):
    top.write_text(TOP.replace("count = 101", "count = 3") + SPREAD)
    return top


def test_an_ensemble_goes_to_a_store_and_on_with_it(tops, tmp_path):
    """With chunks gone the same command goes on; the numbers are those of a run in memory."""
    store, lines = tmp_path / "tops.zarr", ("run", tops, "--out", tmp_path / "tops.zarr")
    assert call(*lines, "--chunk", 8).stdout == f"{store}\n"
    call("run", tops, "--out", tmp_path / "memory")
    whole = pt.load(tmp_path / "memory" / "top.nc")
    found = pt.load(store)
    assert found.provenance["scenario"] == tops.read_text()
    assert found.provenance["seed"] == 1
    assert np.asarray(found.quaternion).tobytes() == whole.quaternion.tobytes()
    assert call(*lines, code=2).stderr == f"poinsot: {store} already exists; use --overwrite or --resume.\n"
    (store / "chunks" / "000001" / "zarr.json").unlink()
    output_text = call("info", store).stdout
    assert "store: tops.zarr, 2 of 3 chunks of 8 members" in output_text
    assert "at the last time: 12 of 20 members" in output_text
    assert json.loads(call("info", store, "--json").stdout)["finished"] == 12
    call(*lines, "--resume")
    assert np.asarray(pt.load(store).quaternion).tobytes() == whole.quaternion.tobytes()
    assert "at the last time" not in call("info", store).stdout
    output_text = call("run", store, "--out", tmp_path / "again").stdout
    assert output_text.endswith("The two results agree bit for bit.\n")
    call(*lines, "--overwrite", "--chunk", 20)
    assert "1 of 1 chunks of 20 members" in call("info", store).stdout
    tops.write_text(tops.read_text().replace("seed = 1", "seed = 2"))
    message = call(*lines, "--resume", code=2).stderr
    assert message.startswith(
        f"poinsot: --out must be a new name or the store of this problem, got {store}, which differs"
    )


def test_a_partial_store_goes_on_by_the_scenario_in_it(tops, tmp_path):
    store = tmp_path / "tops.zarr"
    call("run", tops, "--out", store, "--chunk", 8)
    whole = np.asarray(pt.load(store).quaternion).tobytes()
    tops.unlink()
    for options in ((), ("--out", store)):
        (store / "chunks" / "000001" / "zarr.json").unlink()
        assert call("run", store, "--resume", *options).stdout == f"{store}\n"
        assert np.asarray(pt.load(store).quaternion).tobytes() == whole
    assert [path.name for path in tmp_path.iterdir()] == ["tops.zarr"]


def test_a_store_without_whole_states_is_not_run_again(tops, tmp_path):
    store = tmp_path / "rates.zarr"
    job = pt.files.read_scenario(tops)
    pt.propagate(job.system, job.state, job.times, out=store, variables=["kinetic_energy"])
    for options in ((), ("--resume",)):
        message = call("run", store, *options, code=2).stderr
        assert message.startswith(
            f"poinsot: {store} must have a motion, quaternions and momenta at the same times, got "
        )


def test_closed_forms_go_to_a_store_too(tops, tmp_path):
    tops.write_text(re.sub(r"(?m)^forces.*$", 'run.method = "closed form"', tops.read_text()))
    call("run", tops, "--out", tmp_path / "free.zarr", "--chunk", 8)
    found = pt.load(tmp_path / "free.zarr")
    assert found.provenance["scenario"] == tops.read_text()
    assert found.run.method == "closed form"
    whole = pt.files.read_scenario(tops).propagate()
    assert np.asarray(found.quaternion).tobytes() == whole.quaternion.tobytes()
    assert "It takes no time" in call("run", tops, "--dry-run", code=2).stderr


def test_options_of_stores_are_refused_without_one(tops, tmp_path):
    for option in (("--chunk", 4), ("--resume",)):
        message = call("run", tops, *option, code=2).stderr
        assert message == f"poinsot: {option[0]} must go with an ensemble and --out NAME.zarr, got no store.\n"
    other = tmp_path / "other.zarr"
    other.mkdir()
    (other / "notes.txt").write_text("mine")
    message = call("run", tops, "--out", other, "--overwrite", code=2).stderr
    assert message == f"poinsot: {other} must be the store of an ensemble to be replaced, got another folder.\n"
    assert (other / "notes.txt").exists()
    tops.write_text(TOP)
    message = call("run", tops, "--out", tmp_path / "one.zarr", "--resume", code=2).stderr
    assert message == "poinsot: --resume must go with an ensemble and --out NAME.zarr, got one motion.\n"
    assert call("run", tops, "--out", tmp_path / "one.zarr").stdout == f"{tmp_path}/one.zarr\n"
    assert pt.load(tmp_path / "one.zarr").times.size == 101


def test_the_histogram_of_an_ensemble_is_drawn_from_its_store(tops, tmp_path):
    assert tuple(QUANTITIES) == plots.QUANTITIES
    call("run", tops, "--out", tmp_path / "tops.zarr")
    arguments = ("plot", tmp_path / "tops.zarr", "--kind", "histogram")
    assert call(*arguments, "--quantity", "turn").stdout == f"{tmp_path}/tops-histogram.png\n"
    assert (tmp_path / "tops-histogram.png").stat().st_size > 5000
    message = call(*arguments, "--quantity", "mass", "--overwrite", code=2).stderr
    assert message.startswith(
        "poinsot: --quantity must be one of effective_rate, rate, angular_momentum, turn, got 'mass'"
    )
    message = call(*arguments, "--member", 0, "--overwrite", code=2).stderr
    assert message == "poinsot: the result must have members, got the motion of one body.\n"


def test_a_dry_run_says_what_a_run_takes_and_writes_nothing(tops, tmp_path):
    output_text = call("run", tops, "--dry-run", "--threads", 1).stdout
    assert "  members: 20\n" in output_text
    assert "  result: 3.36 kB, fits into memory" in output_text  # 20 members, 3 times, 7 numbers of 8 bytes
    assert " on 1 thread\n" in output_text
    facts = json.loads(call("run", tops, "--dry-run", "--json").stdout)
    assert (facts["members"], facts["times"], facts["bytes"]) == (20, 3, 20 * 3 * 7 * 8)
    assert 0 < facts["seconds"] < 10
    assert [path.name for path in tmp_path.iterdir()] == ["top.toml"]


def test_workers_of_a_scheduler_fill_a_store(tops, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://", dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        call("run", tops, "--out", tmp_path / "tops.zarr", "--chunk", 8, "--scheduler", address)
    call("run", tops, "--out", tmp_path / "memory")
    whole, found = pt.load(tmp_path / "memory" / "top.nc"), pt.load(tmp_path / "tops.zarr")
    assert np.asarray(found.quaternion).tobytes() == whole.quaternion.tobytes()
    message = call("run", tops, "--out", tmp_path / "x.zarr", "--scheduler", "nowhere", code=2).stderr
    assert message == "poinsot: --scheduler must be an address such as tcp://host:8786, got 'nowhere'.\n"
    message = call("run", tops, "--scheduler", "tcp://127.0.0.1:1", code=2).stderr
    assert message == "poinsot: --scheduler must go with an ensemble and --out NAME.zarr, got no store.\n"
    assert not (tmp_path / "x.zarr").exists()


# ------------------------------------------------------------------ two bodies

BINARY = """\
title = "two"
[body]
type = "TwoBodies"
G = 1.0
primary = {moments = [2.0, 2.5, 3.0], mass = 3.0}
secondary = {moments = [0.1, 0.12, 0.15], mass = 0.5}
[state]
position = [6, 1, 2]
velocity = [-0.1, 0.6, 0.3]
primary = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 0.2, 1]}
secondary = {quaternion = [0.5, 0.5, -0.5, 0.5], omega_body = [0, 0.1, 0.4]}
[[forces]]
type = "MutualGravity"
[times]
stop = 10
count = 11
"""


@pytest.fixture(scope="module")
def binary(tmp_path_factory):
    path = tmp_path_factory.mktemp("binary") / "binary.toml"
    path.write_text(BINARY)
    call("run", path)
    return path.with_suffix(".nc")


def test_two_bodies_run_and_are_repeated(binary, tmp_path):
    result = call("run", binary, "--out", tmp_path)
    assert result.stdout.endswith("The two results agree bit for bit.\n")
    assert list(pt.load(tmp_path / "binary.nc").of_bodies) == ["primary", "secondary"]


def test_a_scenario_of_two_bodies_is_reported(binary):
    output_text = call("info", binary.with_suffix(".toml")).stdout
    assert "start: quaternion of the secondary (0.5, 0.5, -0.5, 0.5), scalar first, body to space" in output_text
    assert "start: position of the secondary (6, 1, 2) (dimensionless)" in output_text
    assert "start: momentum of the orbit (-0.0428571429, 0.257142857, 0.128571429) (dimensionless)" in output_text
    assert "can be run again: yes" in call("info", binary).stdout


@pytest.mark.parametrize("kind", KINDS)
def test_every_plot_is_of_two_bodies_or_asks_for_one(binary, kind, tmp_path):
    other = ("--with", binary) if kind in WITH_ANOTHER else ()
    arguments = "plot", binary, tmp_path / "it.png", "--kind", kind, *other
    if kind in OF_TWO:
        call(*arguments)
    else:
        assert call(*arguments, code=2).stderr == "poinsot: --body must be primary or secondary, got none.\n"
    if kind in ("quaternions", "angular_velocity", "polhode", "difference"):
        call(*arguments, "--body", "secondary", "--overwrite")
        assert (tmp_path / "it.png").exists()


def test_one_of_two_bodies_is_seen_and_converted(binary, tmp_path):
    message = call("convert", binary, tmp_path / "it.csv", code=2).stderr
    assert message == "poinsot: --body must be primary or secondary, got none.\n"
    for command, name in (("view", "it.html"), ("convert", "it.csv")):
        call(command, binary, tmp_path / name, "--body", "primary")
    assert "<title>" in (tmp_path / "it.html").read_text()
    table = pt.files.read_quaternion_csv(tmp_path / "it.csv")
    primary = pt.load(binary).of_bodies["primary"]
    assert np.max(table.angle_to(primary)) < 1e-14
    message = call("plot", binary, tmp_path / "it.png", "--body", "moon", code=2).stderr
    assert message == "poinsot: --body must be primary or secondary, got moon.\n"
    message = call("convert", binary, tmp_path / "it.zarr", "--body", "primary", code=2).stderr
    assert message == "poinsot: --body must go with a result that becomes attitudes, got other files.\n"


def test_one_body_has_no_other(top, tmp_path):
    call("run", top, "--out", tmp_path)
    message = call("view", tmp_path / "top.nc", "--body", "primary", code=2).stderr
    assert message == "poinsot: --body must not be there for a motion of one body, got primary.\n"


def test_two_bodies_have_a_page_and_a_picture_of_their_own(binary, tmp_path):
    assert call("plot", binary).stdout == f"{binary.with_name('binary-mutual_orbit.png')}\n"
    call("plot", binary, tmp_path / "one.png", "--body", "primary")
    call("view", binary, tmp_path / "whole.html")
    assert '"reach"' in (tmp_path / "whole.html").read_text()
    path = tmp_path / "it.toml"
    path.write_text(f'{BINARY}[outputs]\nplot = "it.png"\nview = "it.html"\n')
    call("run", path)
    assert (tmp_path / "it.html").read_bytes() == (tmp_path / "whole.html").read_bytes()
    assert (tmp_path / "it.png").stat().st_size > 5000
    message = call("plot", binary, tmp_path / "no.png", "--kind", "distance", "--body", "primary", code=2).stderr
    assert message == "poinsot: --kind must be a plot of one body, got distance.\n"
