"""One file for one thing: a force, an orbit, a part, a shape and an attitude format of a user's, from one file outside.

The file is imported, no more; scenarios, their schema and the command line know what is in it then.
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import poinsot as pt

MINE = '''
import json

import numpy as np

import poinsot as pt
from poinsot import functions
from poinsot.mechanics.part import Part
from poinsot.quantities import Angle, AngularVelocity, Time


class Rowing(pt.Torque):
    """A torque that comes and goes.

    Parameters
    ----------
    strength : array (3,)
        Along the body axes.
    rate : float
        Of the strokes.
    """

    strength: pt.mechanics.Vector
    rate: AngularVelocity
    epoch: Time = 0.0

    def torque(self, instant):
        return functions.sin(self.rate * (instant.time - self.epoch)) * self.strength


class Tether(pt.Orbit):
    """A body at the end of a tether that turns evenly."""

    mu: float
    length: float
    start: Angle
    rate: AngularVelocity = 0.0

    def position_at(self, time):
        angle = self.start + self.rate * time
        return functions.Vector((self.length * functions.cos(angle), self.length * functions.sin(angle), 0 * time))

    def velocity_at(self, time):
        x, y, z = self.position_at(time)
        return functions.Vector((-self.rate * y, self.rate * x, z))


class Flywheel(Part):
    """A rotor of constant speed."""

    spin: pt.mechanics.Vector

    def momentum(self, own, time):
        return functions.Vector(self.spin)


class Ball(pt.shapes.Ellipsoid):
    """A ball."""

    def __init__(self, radius: float, *, mass: float) -> None:
        self.radius = radius
        super().__init__((radius,) * 3, mass=mass)


class Lines(pt.files.AttitudeFormat):
    """One list of numbers in each line: the time and the quaternion."""

    title = "lines of JSON"
    suffixes = (".jsonl",)
    in_python = "mine.Lines().read({path!r})"
    conventions = ("scalar first", "body to space", "none")

    @staticmethod
    def sniff(head):
        return head.startswith(b"[")

    @staticmethod
    def read(path, *, calendar=None):
        rows = np.array([json.loads(line) for line in open(path)])
        return pt.files.AttitudeTable(rows[:, 0], rows[:, 1:])

    @staticmethod
    def write(motion, path, *, calendar, reference_frame, overwrite):
        rows = np.column_stack([motion.times, motion.quaternion])
        open(path, "w").writelines(f"{json.dumps(row.tolist())}\\n" for row in rows)
'''

RUN = """
import json, sys
import mine
from typer.testing import CliRunner
from poinsot.cli import app

found = [CliRunner().invoke(app, call) for call in json.loads(sys.argv[1])]
print(json.dumps([(one.exit_code, one.output) for one in found]))
"""

SCENARIO = """
[units]
time = "s"
[body]
type = "Body.from_shape"
shape = {type = "Ball", radius = 2.0, mass = 5.0}
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0, 0, 0]
[[forces]]
type = "Rowing"
strength = [0, 0, 1]
rate = "30 deg/s"
[[forces]]
type = "GravityGradient"
orbit = "tether"
[orbits.tether]
type = "Tether"
mu = 1
length = 100
start = "90 deg"
[times]
stop = 3
count = 4
"""


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """What the command line says, by its first arguments, where the file is imported."""
    folder = tmp_path_factory.mktemp("mine")
    (folder / "mine.py").write_text(MINE)
    (folder / "it.toml").write_text(SCENARIO)
    (folder / "wrong.toml").write_text(SCENARIO.replace('"Rowing"', '"Rowin"'))
    calls = {
        "new": ["new", "--schema"],
        "run": ["run", "it.toml"],
        "wrong": ["run", "wrong.toml"],
        "info": ["info", "it.nc"],
        "convert": ["convert", "it.nc", "it.jsonl"],
        "table": ["info", "it.jsonl"],
        "help": ["convert", "--help"],
        "other": ["convert", "it.nc", "it.doc"],
        "again": ["run", "it.nc"],
    }
    code = [sys.executable, "-c", RUN, json.dumps(list(calls.values()))]
    done = subprocess.run(code, capture_output=True, text=True, cwd=folder, check=True)
    return folder, dict(zip(calls, json.loads(done.stdout), strict=True))


def test_the_schema_has_them(outputs):
    _, (status, text) = outputs[0], outputs[1]["new"]
    kinds = json.loads(text)["$defs"]
    assert status == 0
    assert kinds["Rowing"]["required"] == ["type", "strength", "rate"]
    assert kinds["Rowing"]["properties"]["strength"]["description"] == "Along the body axes."
    for kind, name in (("Tether", "start"), ("Rowing", "rate"), ("Rowing", "epoch")):
        assert kinds[kind]["properties"][name]["anyOf"][0] == {"type": ["number", "string"]}, name
    assert kinds["Tether"]["properties"]["length"]["anyOf"][0] == {"type": "number"}
    assert kinds["Flywheel"]["required"] == ["type", "spin"]
    assert kinds["Ball"]["required"] == ["type", "radius", "mass"]


def test_a_scenario_runs_with_them(outputs):
    folder, message_text = outputs
    assert message_text["run"] == [0, "it.nc\n"]
    assert "force: Rowing(strength=[0.0, 0.0, 1.0], rate=0.5235987756 rad s-1, epoch=0.0 s)" in message_text["info"][1]
    assert "start=1.570796327 rad" in message_text["info"][1]
    assert "can be run again: yes" in message_text["info"][1]
    assert message_text["again"] == [0, "it-again.nc\nThe two results agree bit for bit.\n"]
    assert tomllib.loads((folder / "it.toml").read_text())["forces"][0]["type"] == "Rowing"


def test_the_motion_is_theirs(outputs):
    """A ball of I = 2/5 m r^2 = 8 under sin(w t): angle (w t - sin(w t))/(I w^2) about the third axis."""
    folder, message_text = outputs
    assert message_text["convert"] == [0, "it.jsonl\n"]
    t, *q = np.array([json.loads(line) for line in (folder / "it.jsonl").read_text().splitlines()]).T
    rate = np.pi / 6
    angle = (rate * t - np.sin(rate * t)) / (8 * rate**2)
    np.testing.assert_allclose(q, [np.cos(angle / 2), 0 * t, 0 * t, np.sin(angle / 2)], rtol=0, atol=1e-14)


def test_the_command_line_names_them(outputs):
    _, message_text = outputs
    assert (
        "wrong.toml, line 11: forces[0].type must name a known type, got 'Rowin'. Did you mean 'Rowing'?"
        in (message_text["wrong"][1])
    )
    assert message_text["table"][1].startswith("Attitudes, lines of JSON: ")
    assert "in Python: mine.Lines().read('it.jsonl')" in message_text["table"][1]
    assert "lines of JSON (.jsonl)" in " ".join(message_text["help"][1].split())
    assert ".jsonl" in message_text["other"][1]


@pytest.mark.parametrize("module", ["mine", "mine.py", "./mine.py"])
def test_the_command_line_imports_the_module(outputs, tmp_path, module):
    folder, _ = outputs
    command = [sys.executable, "-m", "poinsot", "run", "it.toml", "--import", module, "--out", str(tmp_path / "own.nc")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=True)
    assert done.stdout == f"{tmp_path / 'own.nc'}\n"
    assert [each.name for each in tmp_path.iterdir()] == ["own.nc"]


def test_the_command_line_names_a_module_that_does_not_exist(outputs):
    folder, _ = outputs
    command = [sys.executable, "-m", "poinsot", "--import", "yours", "run", "it.toml"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 2
    assert done.stderr == "poinsot: --import must name a module, got 'yours': No module named 'yours'.\n"


def test_a_result_is_read_where_they_are_not_known(outputs):
    folder, _ = outputs
    back: Any = pt.load(folder / "it.nc")
    assert back.quaternion.shape == (4, 4)
    assert "body.shape.type must name a known type, got 'Ball'" in back.system.not_rerunnable


def test_the_recipe_of_a_tippe_top_refuses_a_surface_that_is_no_sphere():
    """Rolling is not holonomic: with another surface the formulas of the page would run and be wrong."""
    page = (Path(__file__).parents[2] / "docs" / "parts.md").read_text()
    (recipe,) = [
        code for code in re.findall(r"```\{code-cell\} ipython3\n(.*?)```", page, re.DOTALL) if "class TippeTop" in code
    ]
    names: dict[str, Any] = {"pt": pt, "np": np, "fn": pt.functions}
    exec(recipe.split("\n\n\nsphere = ")[0], names)
    top, sphere = names["TippeTop"], pt.Body((5.2e-7, 5.2e-7, 5.4e-7))
    pt.System(sphere, top(0.006, [0.015] * 3, 0.003, 0.02))
    message = "semiaxes must be equal, got [0.015 0.015 0.012]. The equations of this part hold for a sphere only."
    egg = pt.Body.from_ellipsoid(0.006, (0.015, 0.015, 0.012))
    for body, semiaxes in ((sphere, (0.015, 0.015, 0.012)), (egg, [0.015] * 3)):
        with pytest.raises(ValueError, match=r"^semiaxes must be equal") as caught:
            pt.System(body, top(0.006, semiaxes, 0.003, 0.02))
        assert str(caught.value) == message
