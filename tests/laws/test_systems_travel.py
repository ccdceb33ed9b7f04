"""Every system reaches another process as it is, with forces, orbits, parts, laws and events, also a user's own."""

import pickle
import subprocess
import sys

import cloudpickle
import numpy as np
import pytest

import poinsot as pt
from kinds.records import RECORDS, SYSTEMS
from kinds.results import contents
from public_calls import public_calls

WAYS = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "old pickle": lambda thing: pickle.loads(pickle.dumps(thing, protocol=0)),
    "cloudpickle": lambda thing: pickle.loads(cloudpickle.dumps(thing)),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", RECORDS)
def test_every_record_comes_back_equal(kind, way):
    for record in RECORDS[kind]:
        record.numbers, record.structure, record.knots  # noqa: B018, what it remembers travels or is forgotten
        back = WAYS[way](record)
        assert repr(back) == repr(record)
        assert contents(back.numbers) == contents(record.numbers)
        assert contents(back.knots) == contents(record.knots)


def test_orbits_of_files_have_their_numbers_with_them(tmp_path):
    calls = public_calls(tmp_path)
    for name in ("read_oem", "spice_orbit", "tle_orbit"):
        read, given = calls[name]
        orbit = read(**given)
        packed, (first, last) = pickle.dumps(orbit), orbit.span
        times = np.linspace(first, last, 7)
        expected = np.array(list(orbit.position_at(times)))
        code = "import pickle, sys; orbit, times = pickle.load(sys.stdin.buffer)\n"
        code += "import numpy as np; sys.stdout.buffer.write(np.array(list(orbit.position_at(times))).tobytes())"
        sent = pickle.dumps((pickle.loads(packed), times))
        elsewhere = tmp_path / name
        elsewhere.mkdir()
        run = subprocess.run([sys.executable, "-c", code], input=sent, cwd=elsewhere, capture_output=True, check=True)
        assert run.stdout == expected.tobytes()
        assert str(tmp_path).encode() not in packed


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_system_moves_in_the_same_way_when_it_comes_back(name, way):
    system = pt.System(*SYSTEMS[name], units={"time": "s"})
    start, times = system.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.6, 0.5)), np.linspace(0.0, 2.0, 5)
    there = pt.propagate(system, start, times)
    assert there.integrals is not None
    back, start = WAYS[way]((system, start))
    again = pt.propagate(back, start, times)
    assert {n: x.tobytes() for n, x in there.phase.items()} == {n: x.tobytes() for n, x in again.phase.items()}
    assert repr(back) == repr(system)
    assert back.units == system.units
    assert [integral.name for integral in back.integrals] == [integral.name for integral in system.integrals]


OWN = """
from __future__ import annotations
import sys
from typing import Annotated, Any
import cloudpickle, numpy as np
import poinsot as pt
from poinsot import functions as fn

Axis = pt.BodyVector

class Thruster(pt.Torque):
    along: pt.BodyVector
    strengths: Annotated[Any, (3,)]
    orbit: pt.Orbit
    size: float = 0.1
    def torque(self, instant):
        x, y, z = instant.position(self.orbit)
        wanted = fn.where(fn.less(x, 0.0), self.size, 2 * self.size)
        return wanted * fn.Vector(self.along)

class Damper(pt.Part):
    stiffness: float
    variables = {"angle": 1}
    def rates(self, instant, generalised_force):
        (angle,) = instant.own(self)
        return fn.Vector((-self.stiffness * angle,))

class Tilt(pt.Event):
    def value(self, instant):
        return instant.attitude.to_body((0, 0, 1))[0] - 0.1
    def act(self, body, state):
        return body.state(state.quaternion, angular_momentum_body=0.9 * state.angular_momentum_body, time=state.time)

body = pt.Body((1.0, 1.3, 1.7))
orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
system = pt.System(body, Thruster((0.5, -1.0, 0.8), (1.0, 2.0, 3.0), orbit), Damper(0.3))
start = system.state((1, 0, 0, 0), omega_body=[(0.1, 1.0, 0.2), (0.2, 0.9, 0.1)], damper=[(0.1,), (0.2,)])
def moved(system, start, event):
    return pt.propagate(system, start, np.linspace(0, 9, 4), events=[event])
motion = moved(system, start, Tilt())
assert len(motion.events[0])
cloudpickle.dump((moved, system, start, Tilt(), motion), open(sys.argv[1], "wb"))
"""
BACK = """
import pickle, sys
moved, system, start, event, there = pickle.load(open(sys.argv[1], "rb"))
again = moved(system, start, event)
assert {n: x.tobytes() for n, x in again.phase.items()} == {n: x.tobytes() for n, x in there.phase.items()}
assert again.events[0].times.tobytes() == there.events[0].times.tobytes()
assert repr(again.system) == repr(there.system)
assert type(again.system.forces[0]) is type(there.system.forces[0])
print(len(again.events[0]))
"""


def test_classes_of_a_script_reach_another_process(tmp_path):
    """Its annotations name modules that the other process has not imported."""
    for code in (OWN, BACK):
        done = subprocess.run(
            [sys.executable, "-c", code, tmp_path / "system.pickle"], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 0
