"""What the commands say of files of others, of files that are wrong, and in whose words."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import poinsot as pt
from poinsot.cli import app

BODY = pt.Body((4.0, 5.0, 6.0))
START = BODY.state((0.5, -0.5, 0.1, 0.7), omega_body=(0.01, 0.02, 0.05))
TETRAHEDRON = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
FIELD = """\
modelname x
earth_gravity_constant 1.0
radius 2.5
max_degree 2
errors no
norm fully_normalized
end_of_head
gfc 0 0 1 0
gfc 2 0 -1e-3 0
gfc 2 1 0 0
gfc 2 2 1e-4 0
"""


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "400"})
    assert result.exit_code == code, (result.output, result.exception)
    return result


def refused(*arguments):
    message = call(*arguments, code=2).stderr
    assert message.startswith("poinsot: ")
    assert message.count("\n") == 1
    return message.removeprefix("poinsot: ").rstrip("\n")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    motion = pt.free_motion(BODY, START, np.linspace(0, 600, 31), units={"time": "s", "inertia": "kg m2"})
    pt.save(motion, "sat.nc")
    return tmp_path


def test_files_of_attitudes_are_described_with_their_reader(folder):
    pytest.importorskip("astropy")
    message = ("--zero", "2026-11-21T00:00:00 UTC", "--frame", "ICRF")
    for end, kind, reader in (
        ("aem", "Attitudes, CCSDS AEM", "read_aem"),
        ("a", "Attitudes, STK", "read_stk_attitude"),
        ("csv", "Attitudes, table", "read_quaternion_csv"),
    ):
        call("convert", "sat.nc", f"sat.{end}", *message)
        output_text = call("info", f"sat.{end}").stdout.splitlines()
        assert output_text[0] == f"{kind}: SC_BODY_1 in ICRF"
        assert output_text[1] == "  times: 31, 0 ... 600 s"
        assert "2026-11-21T00:00:00" in output_text[2]
        assert output_text[3] == "  rates: in the file"
        assert output_text[-1] == f"  in Python: pt.files.{reader}('sat.{end}')"
        assert f"sat.{end} must contain a scenario, got none." in refused("info", f"sat.{end}", "--scenario")
    (folder / "any.txt").write_text((folder / "sat.aem").read_text())
    assert "pt.files.read_aem('any.txt')" in call("info", "any.txt").stdout
    named = {"calendar": pt.Calendar("2026-11-21T00:00:00", "UTC"), "reference_frame": "ICRF"}
    pt.files.write_apm(BODY, START, "one.xml", **named)
    output_text = call("info", "one.xml").stdout
    assert output_text.startswith("One attitude, CCSDS APM: SC_BODY_1 in ICRF\n")
    assert "body: Body(moments=[4.0, 5.0, 6.0])" in output_text


@pytest.mark.usefixtures("folder")
def test_kernels_are_described():
    pytest.importorskip("spiceypy")
    call("convert", "sat.nc", "sat.bc", "--zero", "2026-11-21T00:00:00 UTC", "--frame", "ICRF")
    output_text = call("info", "sat.bc").stdout
    assert output_text.startswith("Attitudes, SPICE CK: ")
    assert "times: 31, " in output_text
    assert call("info", "sat.tsc").stdout.startswith("Kernel of SPICE: sat.tsc\n")


def test_shapes_and_fields_are_described_with_their_reader(folder):
    (folder / "it.obj").write_text(TETRAHEDRON)
    output_text = call("info", "it.obj").stdout
    assert output_text.startswith("Shape: 4 vertices, 4 faces, closed\n  volume: 1, ")
    assert "pt.files.read_mesh('it.obj', density=...)" in output_text
    (folder / "it.gfc").write_text(FIELD)
    assert call("info", "it.gfc").stdout.splitlines() == [
        "Gravity field: degree 2, reference radius 2.5",
        "  in Python: pt.files.read_field('it.gfc', mass=...)",
    ]


def test_a_store_without_whole_states_has_no_motion(folder):
    system = pt.System(pt.Body((1.25, 1.0, 0.75)))
    starts = system.body.state([(1, 0, 0, 0)] * 3, omega_body=(0.1, 0.2, 1))
    pt.propagate(system, starts, [0.0, 1.0, 2.0], out=folder / "some.zarr", variables=["quaternion"])
    pt.propagate(
        system, starts, [0.0, 1.0, 2.0], out=folder / "less.zarr", reduce=lambda data: data[["norm_error"]].max("time")
    )
    for name in ("some.zarr", "less.zarr"):
        assert call("info", name).stdout.startswith(f"Dataset {name}\n")
        for command in ("run", "plot", "view"):
            assert refused(command, name).startswith(f"{name} must have a motion, quaternions and momenta at the same ")


def test_a_reduction_that_is_not_whole_says_how_far_it_is(folder):
    system = pt.System(pt.Body((1.25, 1.0, 0.75)))
    starts = system.body.state([(1, 0, 0, 0)] * 5, omega_body=(0.1, 0.2, 1))
    pt.propagate(system, starts, [1.0], out=folder / "it.zarr", chunk=2, reduce=lambda data: data[["norm_error"]])
    shutil.rmtree(folder / "it.zarr" / "chunks" / "000001")
    lines = call("info", "it.zarr").stdout.splitlines()
    assert lines[1:3] == ["  store: it.zarr, 2 of 3 chunks of 2 members", "  members: 3 of 5 are done"]
    output_text = json.loads(call("info", "it.zarr", "--json").stdout)
    assert (output_text["members"], output_text["finished"]) == (5, 3)


def test_a_file_of_no_kind_raises_an_error_with_the_known_kinds(folder):
    (folder / "x.doc").write_text("")
    assert refused("info", "x.doc").startswith("x.doc must be a result (.nc, .zarr), a scenario (.toml), attitudes")
    assert refused("run", "x.doc") == "x.doc must be a scenario, .toml, or a result, .nc or .zarr, but it is none."
    for command in ("plot", "view", "animate"):
        assert refused(command, "x.toml").endswith("`poinsot run x.toml` writes one.")
        assert refused(command, "x.aem").endswith("`poinsot convert x.aem NAME.nc --scenario ...` writes one.")


@pytest.mark.usefixtures("folder")
def test_words_are_those_of_the_command_line():
    aem = ("convert", "sat.nc", "sat.aem")
    assert refused(*aem).endswith("got none. Pass --frame ICRF for axes of the ICRF.")
    assert refused(*aem, "--frame", "ICRF").endswith("the instant of t = 0: --zero '2026-11-21T00:00:00 UTC'.")
    assert refused(*aem, "--frame", "X", "--zero", "2026-11-21T00:00:00 UTC").startswith("--frame must be one of ICRF")
    for zero in ("2026", "2026-11-21T00:00:00 X", "yesterday UTC"):
        assert "--zero must be " in refused(*aem, "--frame", "ICRF", "--zero", zero)
    call("convert", "sat.nc", "sat.csv")
    assert refused("convert", "sat.csv", "x.nc").startswith("--scenario must be given for sat.csv")
    assert refused("convert", "sat.nc", "sat.csv") == ("sat.csv already exists; use --overwrite.")
    assert refused("convert", "sat.nc", "./sat.nc", "--overwrite") == (
        "sat.nc must be another file than the one to convert, but it is the same."
    )
    assert "\n" not in refused("convert", "sat.nc", "x.doc")
    assert refused("convert", "sat.nc", "x.zarr", "--frame", "ICRF") == (
        "--frame must go with attitudes, got two results."
    )
    assert refused("convert", "sat.nc", "x.zarr", "--zero", "2026-11-21 UTC").startswith(
        "--zero must go with attitudes"
    )
    call("new", "top.toml")
    assert refused("convert", "sat.nc", "x.csv", "--scenario", "top.toml").startswith("--scenario must go with ")
    assert refused("convert", "sat.csv", "x.nc", "--scenario", "no.toml") == ("No such file: no.toml")


def test_a_table_of_somebody_is_compared_with_a_motion(folder):
    pytest.importorskip("astropy")
    (folder / "sat.toml").write_text(
        "[body]\nmoments = [4, 5, 6]\n[units]\ntime = 's'\n[calendar]\nzero = '2026-11-21'\nscale = 'UTC'\n"
    )
    call("convert", "sat.nc", "sat.xml", "--zero", "2026-11-21T00:00:00 UTC", "--frame", "ICRF")
    call("convert", "sat.xml", "theirs.nc", "--scenario", "sat.toml")
    call("plot", "sat.nc", "--kind", "difference", "--with", "theirs.nc")
    assert (folder / "sat-difference.png").stat().st_size > 10_000
    pt.save(pt.free_motion(BODY, START, [0, 1, 2]), "other.nc")
    message = refused("plot", "sat.nc", "x.png", "--kind", "difference", "--with", "other.nc")
    assert message.startswith("--with must have the same times, got 3 times from 0 to 2 and 31 times from 0 to 600")
    assert message.endswith(". Compute both at the same times, or the first with dense output.")


@pytest.mark.usefixtures("folder")
def test_options_of_other_pictures_are_refused_before_the_result_is_read():
    for option, kinds in (
        (
            ("--angle-unit", "rad"),
            "attitude_error or difference or euler_angles or histogram or librations or roll_pitch_yaw",
        ),
        (("--orbit", 1), "roll_pitch_yaw"),
        (("--with", "sat.nc"), "attitude_error or difference"),
    ):
        output_text = refused("plot", "sat.nc", "--kind", "angular_velocity", *option)
        assert output_text == f"{option[0]} must go with --kind {kinds}, got --kind angular_velocity."
    pt.save(pt.free_motion(BODY, START, [0]), "instant.nc")
    assert refused("view", "sat.nc", "both.html", "--with", "no.nc") == "No such file: no.nc"
    assert refused("view", "sat.nc", "both.html", "--with", "instant.nc").startswith(
        "--with must be motions at two times"
    )
    call("view", "sat.nc", "both.html", "--with", "sat.nc")
    assert "the other motion" in Path("both.html").read_text()
    assert refused("view", "instant.nc") == "the result must have two times or more, got 1."
    assert refused("plot", "sat.nc", "--kind", "difference").startswith("--with must be another result")
    assert refused("plot", "sat.nc", "--kind", "difference", "--with", "no.nc") == ("No such file: no.nc")
    for command in ("run", "info", "plot", "view"):
        assert refused(command, "no.nc") == "No such file: no.nc"


@pytest.mark.parametrize(
    "command",
    [
        ("new", "{}.toml"),
        ("plot", "sat.nc", "{}.png"),
        ("view", "sat.nc", "{}.html"),
        ("animate", "sat.nc", "{}.gif"),
        ("convert", "sat.nc", "{}.csv"),
        ("convert", "sat.nc", "{}.zarr"),
    ],
    ids=lambda command: command[0],
)
def test_names_that_cannot_be_written_are_sentences(folder, command):
    *most, last = command
    (folder / last.format("there")).mkdir()
    assert refused(*most, last.format("no/x")) == "No such folder: no"
    there = last.format("there")
    ending = (
        "already exists; use --overwrite." if there.endswith(".zarr") else "must be the name of a file, got a folder."
    )
    assert refused(*most, there) == f"{there} {ending}"
    assert last.format("a" * 300) in refused(*most, last.format("a" * 300))
    assert {path.name for path in folder.iterdir()} == {"sat.nc", last.format("there")}


@pytest.mark.parametrize("command", ["run", "plot", "view", "animate", "info", "convert"])
def test_names_that_cannot_be_read_are_sentences(folder, command):
    more = ("x.csv",) if command == "convert" else ()
    (folder / "folder.nc").mkdir()
    (folder / "cut.nc").write_bytes((folder / "sat.nc").read_bytes()[:3000])
    for name in ("none.nc", "folder.nc", "cut.nc", "no/none.nc"):
        assert name in refused(command, name, *more)
    output_text = refused(command, "a\n\x1b]0;b\x07.nc", *more)
    assert r"a\n\x1b]0;b\x07.nc" in output_text


def test_folders_of_results(folder):
    call("new", "top.toml")
    (folder / "file").write_text("")
    assert "--out must be a folder" in call("run", "top.toml", "--out", "file", code=2).stderr
    assert refused("run", "top.toml", "--out", "file/below")
    assert refused("paper", "--out", "file/below")
