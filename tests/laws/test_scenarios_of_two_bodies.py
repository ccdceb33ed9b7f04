"""Scenarios of two bodies: what they say, what Python says, and a sentence for everything that is not right."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.files.scenario import parsed_scenario, repetition

PAIR = """\
title = "two"
[units]
time = "s"
inertia = "kg m2"
length = "m"
[body]
type = "TwoBodies"
G = 0.9
[body.primary]
moments = [2.0, 2.5, 3.0]
mass = 3.0
[body.secondary]
type = "Body.from_ellipsoid"
mass = 0.5
semiaxes = [0.9, 0.8, 0.7]
[state]
position = [6, 1, 2]
velocity = [-0.1, 0.6, 0.3]
time = "1 min"
[state.primary]
quaternion = [0.8, 0, 0.6, 0]
omega_body = [0, 0, "10 deg/s"]
[state.secondary]
euler_angles = ["10 deg", 0.1, 0.2]
angular_momentum_space = [0, 0.01, 0.1]
[[forces]]
type = "MutualGravity"
[[forces]]
type = "LinearDamping"
coefficient = 1e-3
on = "secondary"
[times]
stop = "70 s"
count = 5
"""

ENSEMBLE = """
[ensemble]
members = 4000
seed = 7
[[ensemble.spread]]
of = "state.velocity"
size = [0.01, 0, 0.02]
[[ensemble.spread]]
of = "state.secondary.turn"
distribution = "isotropic"
[[ensemble.spread]]
of = "state.primary.omega_body"
size = "1 deg/s"
[[ensemble.spread]]
of = "body.primary.mass"
distribution = "uniform"
size = 0.1
[[ensemble.spread]]
of = "forces[1].coefficient"
size = 1e-4
"""


def scenario(*changes, text=PAIR) -> Any:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return parsed_scenario(text, "it.toml")


def test_a_scenario_is_what_python_says():
    found = scenario()
    second = pt.Body.from_ellipsoid(0.5, (0.9, 0.8, 0.7))
    pair = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), second, G=0.9)
    assert found.system.units == {"time": "s", "inertia": "kg m2", "length": "m"}
    for own, wanted in zip(found.system.body.numbers, pair.numbers, strict=True):
        assert own.tobytes() == wanted.tobytes()
    gravity, damping = found.system.forces
    assert isinstance(gravity, pt.forces.MutualGravity)
    assert repr(damping) == "LinearDamping(coefficient=0.001).on('secondary')"
    start = found.state
    assert start.time == 60
    assert np.array_equal(start.position, (6, 1, 2))
    assert np.allclose(start.momentum, np.array((-0.1, 0.6, 0.3)) * 1.5 / 3.5, rtol=4e-16, atol=0)
    assert np.allclose(start.primary.angular_momentum_body, (0, 0, 3 * np.radians(10)), rtol=4e-16, atol=0)
    turn = Rotation.from_euler("ZXZ", (np.radians(10), 0.1, 0.2))
    assert np.allclose(start.secondary.attitude.as_matrix(), turn.as_matrix(), rtol=0, atol=4e-16)
    assert np.allclose(start.secondary.angular_momentum_space, (0, 0.01, 0.1), rtol=0, atol=1e-16)
    motion: Any = pt.propagate(pt.System(pair, *found.system.forces), start, found.times)
    again: Any = found.propagate(progress=False)
    for name, values in motion.phase.items():
        assert np.array_equal(again.phase[name], values), name


def test_a_result_of_a_scenario_is_run_again(tmp_path):
    motion = scenario().propagate(progress=False)
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert read.provenance["scenario"] == PAIR
    again = repetition(read, "it").propagate(progress=False)
    for name, values in motion.phase.items():
        assert read.phase[name].tobytes() == values.tobytes(), name
        assert again.phase[name].tobytes() == values.tobytes(), name


def test_canonical_variables_of_each_body():
    changed = scenario(
        ('omega_body = [0, 0, "10 deg/s"]', "conjugate_momenta = [0.6, 0, -0.8, 0]"),
        ("angular_momentum_space = [0, 0.01, 0.1]", "euler_momenta = [0.1, 0.2, 0.3]"),
    ).state
    assert np.array_equal(changed.primary.conjugate_momenta, (0.6, 0, -0.8, 0))
    same = pt.State.from_euler((np.radians(10), 0.1, 0.2), (0.1, 0.2, 0.3))
    assert np.allclose(changed.secondary.conjugate_momenta, same.conjugate_momenta, rtol=0, atol=2e-16)


STATE = PAIR[PAIR.index("[state]") : PAIR.index("[[forces]]")]
TURNS = PAIR[PAIR.index("[state.primary]") : PAIR.index("[[forces]]")]


@pytest.mark.parametrize("start", ["synchronous", "doubly_synchronous"])
def test_starts_are_those_of_python(start):
    primary = {"primary_rate": "36 deg/h"} if start == "synchronous" else {}
    lines = "".join(f'{name} = "{value}"\n' for name, value in primary.items())
    found = scenario((STATE, f'[state]\ntime = 5\n[state.{start}]\nperiod = "1 h"\n{lines}'))
    rates = {name: np.radians(36) / 3600 for name in primary}
    wanted = getattr(found.system.body, start)(period=3600.0, time=5.0, **rates)
    assert found.state.time == 5
    for name, values in wanted.phase.items():
        assert np.allclose(found.state.phase[name], values, rtol=1e-15, atol=0), name


def test_an_orbit_by_its_elements_and_attitudes_relative_to_it():
    elements = '[state.elements]\nsemimajor_axis = 8\neccentricity = 0.2\ninclination = "30 deg"\ntrue_anomaly = 0.4\n'
    turns = TURNS.replace("angular_momentum_space = [0, 0.01, 0.1]", "omega_body = [0, 0, 0]")
    found = scenario((STATE, f'[state]\nframe = "orbit"\n{elements}{turns}'))
    orbit = pt.KeplerOrbit(0.9 * 3.5, semimajor_axis=8, eccentricity=0.2, inclination=np.pi / 6, true_anomaly=0.4)
    r, v = (np.array(at(0.0)) for at in (orbit.position_at, orbit.velocity_at))
    assert np.allclose(found.state.position, r, rtol=0, atol=1e-14)
    assert np.allclose(found.state.momentum, 1.5 / 3.5 * v, rtol=0, atol=1e-15)
    h = np.cross(r, v)
    normal, radial = h / np.linalg.norm(h), r / np.linalg.norm(r)
    axes = Rotation.from_matrix(np.column_stack([radial, np.cross(normal, radial), normal]))
    turned = axes * Rotation.from_euler("ZXZ", (np.radians(10), 0.1, 0.2))
    assert np.allclose(found.state.secondary.attitude.as_matrix(), turned.as_matrix(), rtol=0, atol=1e-14)
    moments = pt.Body.from_ellipsoid(0.5, (0.9, 0.8, 0.7)).moments
    rate = turned.inv().apply(h / (r @ r))
    assert np.allclose(found.state.secondary.angular_momentum_body, moments * rate, rtol=0, atol=1e-17)


def test_an_impact_at_the_start_and_its_spread():
    kick = '[state.kick]\ndelta_velocity = [0, -0.01, 0]\nframe = "orbit"\n'
    found, without = scenario(("[[forces]]", f"{kick}[[forces]]")).state, scenario().state
    r, p = without.position, without.momentum
    normal = np.cross(r, p) / np.linalg.norm(np.cross(r, p))
    across = np.cross(normal, r) / np.linalg.norm(r)
    assert np.allclose(found.momentum - p, -0.01 * 1.5 / 3.5 * across, rtol=0, atol=1e-16)
    spread = '[ensemble]\nmembers = 3\nseed = 1\nspread = [{of = "state.kick.delta_velocity", size = 0.001}]\n'
    many = scenario(("[[forces]]", f"{kick}body = 'primary'\n[[forces]]"), text=PAIR + spread).state
    assert many.shape == (3,)
    assert np.array_equal(many.position, [r, r, r])
    changes = (many.momentum - p) / (1.5 / 3.5)
    assert np.all(changes @ across > 0.005)
    assert np.all(np.ptp(changes, axis=0) > 0)


def test_attitudes_and_rates_relative_to_a_turntable():
    table = '[frames.table]\nattitude = [1, 0, 0, 0]\nomega_space = [0, 0, "1 rpm"]\n[times]'
    turned = scenario(
        ("[times]", table),
        ('time = "1 min"', 'time = 10\nframe = "table"'),
        ("angular_momentum_space = [0, 0.01, 0.1]", "omega_body = [0, 0, 0]"),
    ).state
    rate = np.array((0, 0, np.pi / 30))
    assert np.allclose(turned.position, (6, 1, 2), rtol=0, atol=1e-14)  # along the axes of space
    axes = Rotation.from_rotvec(10 * rate) * Rotation.from_euler("ZXZ", (np.radians(10), 0.1, 0.2))
    assert np.allclose(turned.secondary.attitude.as_matrix(), axes.as_matrix(), rtol=0, atol=1e-15)
    moments = pt.Body.from_ellipsoid(0.5, (0.9, 0.8, 0.7)).moments
    assert np.allclose(turned.secondary.angular_momentum_body, moments * axes.inv().apply(rate), rtol=0, atol=2e-17)


def test_members_have_the_spread_that_is_stated():
    found = scenario(text=PAIR + ENSEMBLE)
    masses, state = found.system.body.masses, found.state
    assert state.shape == (4000,)
    assert np.array_equal(masses[:, 0], found.system.body.primary.mass)
    assert np.array_equal(masses[:, 1], np.full(4000, 0.5))
    assert 2.9 <= masses[:, 0].min() < 2.901 < 3.099 < masses[:, 0].max() <= 3.1
    velocity = state.momentum / (masses[:, :1] * masses[:, 1:] / masses.sum(axis=1, keepdims=True))
    assert np.allclose(np.std(velocity, axis=0), (0.01, 0, 0.02), rtol=0.05, atol=1e-12)
    assert np.allclose(
        np.std(state.primary.angular_momentum_body / (2, 2.5, 3), axis=0), np.radians(1), rtol=0.05, atol=0
    )
    assert np.allclose(
        np.mean(state.secondary.attitude.as_matrix(), axis=0), 0, rtol=0, atol=0.04
    )  # 5 of 1/sqrt(3 * 4000)
    assert np.std(found.system.forces[1].force.coefficient) == pytest.approx(1e-4, rel=0.05)
    assert np.ptp(state.primary.quaternion, axis=0).max() == 0


WRONG = {
    "line 9: body.primary must have a mass, got Body(moments=[2.0, 2.5, 3.0]). Give it one": ("mass = 3.0\n", ""),
    "line 11: body.primary.mass must be positive, got -3.0.": ("mass = 3.0", "mass = -3.0"),
    "line 14: body.secondary.mass must be positive, got 0.0.": ("mass = 0.5", "mass = 0.0"),
    "line 8: body.G must be positive, got -0.9.": ("G = 0.9", "G = -0.9"),
    "line 8: body.masses must be positive, got [3.0, -0.5].": ("G = 0.9", "masses = [3.0, -0.5]"),
    "line 13: body.secondary.type must name a known type, got 'Body.from_elipsoid'. "
    "Did you mean 'Body.from_ellipsoid'?": ("from_ellipsoid", "from_elipsoid"),
    "line 10: unknown key 'momens' in [body.primary]. Did you mean 'moments'?": (("moments", "momens")),
    "line 12: unknown key 'secundary' in [body]. Did you mean 'secondary'?": (("body.secondary", "body.secundary")),
    "line 6: body.secondary must be given, got none.": (
        '[body.secondary]\ntype = "Body.from_ellipsoid"\nmass = 0.5\nsemiaxes = [0.9, 0.8, 0.7]\n',
        "",
    ),
    "line 7: body.type must name a known type, got 'TwoBody'. Did you mean 'TwoBodies'?": ("TwoBodies", "TwoBody"),
    "line 31: forces[1].on must be 'primary' or 'secondary', got 'secundary'. Did you mean 'secondary'?": (
        ('on = "secondary"', 'on = "secundary"')
    ),
    "line 28: forces[1].on must be given for LinearDamping, which acts on one body, got none.": (
        'on = "secondary"\n',
        "",
    ),
    "line 17: state.position must not be zero": ("[6, 1, 2]", "[0, 0, 0]"),
    "line 17: state.position must have shape": ("[6, 1, 2]", "[6, 1]"),
    "line 18: state.velocity must be finite": ("0.6, 0.3]", "inf, 0.3]"),
    "line 16: state.velocity must be given, got none.": ("velocity = [-0.1, 0.6, 0.3]\n", ""),
    "line 16: state.secondary must be given, got none.": (
        '[state.secondary]\neuler_angles = ["10 deg", 0.1, 0.2]\nangular_momentum_space = [0, 0.01, 0.1]\n',
        "",
    ),
    "line 20: state.primary must have exactly one of quaternion, matrix, euler_angles, roll_pitch_yaw, got none.": (
        "quaternion = [0.8, 0, 0.6, 0]\n",
        "",
    ),
    "line 23: in state.secondary, state must have exactly one of omega_body, omega_space, angular_momentum_body, "
    "angular_momentum_space, got none.": ("angular_momentum_space = [0, 0.01, 0.1]\n", ""),
    "line 21: state.primary.quaternion must have unit norm": ("[0.8, 0,", "[0.9, 0,"),
    "line 20: state.omega_body must not be given together with position, got both.": (
        "[state.primary]",
        "omega_body = [0, 0, 1]\n[state.primary]",
    ),
    "line 25: unknown key 'omgea_body' in [state.secondary]. Did you mean 'omega_body'?": (
        ("angular_momentum_space", "omgea_body")
    ),
    "line 33: run.method must be integration together with forces, got 'closed form'.": (
        ("[times]", '[run]\nmethod = "closed form"\n[times]')
    ),
    "line 17: unknown key 'period' in [state].": (STATE, "[state]\nperiod = 3\n"),
    "line 16: synchronous must have exactly one of distance, period, got none.": (
        STATE,
        "[state.synchronous]\nprimary_rate = 1.0\n",
    ),
    "line 16: state.synchronous.primary_rate must be given, got none.": (STATE, "[state.synchronous]\ndistance = 3\n"),
    "line 18: state.position must not be given together with synchronous, got both.": (
        STATE,
        "[state]\nsynchronous = {distance = 3, primary_rate = 1}\nposition = [1, 2, 3]\n",
    ),
    "line 27: state.kick.body must be 'primary' or 'secondary', got 'moon'.": (
        "[[forces]]",
        "[state.kick]\nbody = 'moon'\ndelta_velocity = [0, 0, 0]\n[[forces]]",
    ),
    "line 17: state.elements.eccentricity must be given, got none.": (
        STATE,
        f"[state]\n[state.elements]\nsemimajor_axis = 8\n{TURNS}",
    ),
    "line 16: in state, masses must have as many members as velocity, got 3 and 2.": (
        ("mass = 3.0", "mass = [3.0, 3.1, 3.2]"),
        ("velocity = [-0.1, 0.6, 0.3]", "velocity = [[-0.1, 0.6, 0.3], [-0.1, 0.6, 0.4]]"),
    ),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_sentences(sentence):
    change = WRONG[sentence]
    with pytest.raises(ValueError) as caught:
        scenario(*(change if isinstance(change[0], tuple) else [change]))
    assert str(caught.value).removeprefix("it.toml, ").startswith(sentence)


ONE = """
[body]
moments = [1, 2, 2.5]
mass = 3.0
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0.1, 1, 0.2]
[times]
stop = 10
count = 5
"""

WRONG_FOR_ONE = {
    "line 6: state.position must be given for two bodies only, got one body.": (
        ("quaternion", "position = [1, 2, 3]\nquaternion"),
    ),
    "line 8: in forces[0], a system of one body must have forces without `on`": (
        ("[times]", '[[forces]]\ntype = "LinearDamping"\ncoefficient = 1e-3\non = "primary"\n[times]'),
    ),
    "line 8: in forces[0], MutualGravity must act between TwoBodies": (
        ("[times]", '[[forces]]\ntype = "MutualGravity"\n[times]'),
    ),
    "line 12: unknown key 'on' in forces[0]": (
        ("[times]", '[[forces]]\ntype = "ReactionWheel"\naxis = [0, 0, 1]\nmoment = 0.1\non = "primary"\n[times]'),
    ),
    "line 9: ensemble.spread[0].of must be the place of a number, got 'state.primary.turn'": (
        (
            "[times]",
            '[ensemble]\nspread = [{of = "state.primary.turn", size = 1}]\nmembers = 3\nseed = 1\n[times]',
        ),
    ),
}


@pytest.mark.parametrize("sentence", WRONG_FOR_ONE)
def test_sentences_about_one_body(sentence):
    with pytest.raises(ValueError) as caught:
        scenario(*WRONG_FOR_ONE[sentence], text=ONE)
    assert str(caught.value).removeprefix("it.toml, ").startswith(sentence)
    assert parsed_scenario(ONE, "it.toml").system.of_bodies[""].mass == 3.0  # type: ignore[attr-defined]


def test_an_ensemble_of_two_bodies_turns_each_by_its_name():
    with pytest.raises(
        ValueError, match=r"of must be state\.primary\.turn or state\.secondary\.turn if it is isotropic"
    ):
        scenario(("state.secondary.turn", "state.position"), ("members = 4000", "members = 4"), text=PAIR + ENSEMBLE)
