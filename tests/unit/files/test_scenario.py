"""Scenario files: every form of every part, and a sentence for everything that is not right."""

import json
import math
import resource
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.files.scenario import parsed_scenario
from poinsot.parts import KaneDamper, ReactionWheel
from poinsot.scenarios.registry import makers
from poinsot.scenarios.schema import quantity, schema
from poinsot.scenarios.system_text import rebuilt_system

ROOT = Path(__file__).parents[3]

SATELLITE = """\
title = "test"
[units]
time = "s"
inertia = "kg m2"
[body]
moments = [400, 500, 600]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0, "0.1 deg/s", 0.001]
[[forces]]
type = "GravityGradient"
orbit = "earth"
[orbits.earth]
type = "KeplerOrbit"
mu = 398600.4418
semimajor_axis = 7000
eccentricity = 0.1
inclination = "30 deg"
node = "45 arcmin"
argument_of_periapsis = 0.2
[times]
stop = "2 h"
count = 11
"""


def scenario(text=SATELLITE, *changes):
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return parsed_scenario(text, "it.toml")


def refusal(call):
    """Return what a call refuses its arguments with; None if it takes them."""
    try:
        call()
    except ValueError as error:
        return str(error)
    return None


def with_state(state, *changes):
    old = SATELLITE[SATELLITE.index("quaternion") : SATELLITE.index("[[forces]]")]
    return scenario(SATELLITE, (old, state + "\n"), *changes).state


# ------------------------------------------------------------------ what is read


def test_parts_of_a_scenario():
    found = scenario()
    degree = math.pi / 180
    assert found.system.units == {"time": "s", "inertia": "kg m2"}
    assert found.system.body.moments.tolist() == [400, 500, 600]
    (force,) = found.system.forces
    assert type(force) is pt.GravityGradient
    wanted = pt.KeplerOrbit(
        398600.4418,
        semimajor_axis=7000,
        eccentricity=0.1,
        inclination=30 * degree,
        node=45 / 60 * degree,
        argument_of_periapsis=0.2,
    )
    assert [float(number) for number in force.orbit.numbers] == pytest.approx(
        [float(x) for x in wanted.numbers], rel=4e-16, abs=0
    )
    assert found.system.body.omega(found.state.angular_momentum_body) == pytest.approx(
        [0, 0.1 * degree, 0.001], rel=4e-16, abs=0
    )
    assert np.array_equal(found.times, np.linspace(0, 7200, 11))
    assert found.provenance["scenario"] == SATELLITE


@pytest.mark.parametrize(
    ("text", "kind", "unit", "value"),
    [
        ("45 deg", "angle", None, math.pi / 4),
        ("-1e1 deg", "angle", None, -math.pi / 18),
        (".5rev", "angle", "s", math.pi),
        ("60 arcmin", "angle", None, math.pi / 180),
        ("3600 arcsec", "angle", None, math.pi / 180),
        ("2 rad", "angle", None, 2.0),
        ("3 mrad", "angle", None, 3e-3),
        ("3 rpm", "rate", "s", 3 * 2 * math.pi / 60),
        ("3 rpm", "rate", "min", 6 * math.pi),
        ("360 deg / d", "rate", "h", 2 * math.pi / 24),
        ("1 rad/s", "rate", "d", 86400.0),
        ("8 h", "time", "s", 28800.0),
        ("90 min", "time", "h", 1.5),
        ("1 d", "time", "d", 1.0),
    ],
)
def test_quantities(text, kind, unit, value):
    assert quantity(text, kind, unit) == pytest.approx(value, rel=1e-15, abs=0)


@given(st.text(max_size=30), st.sampled_from(["angle", "rate", "time"]), st.sampled_from([None, "s", "d"]))
def test_any_text_is_a_quantity_or_refused(text, kind, unit):
    message = refusal(lambda: quantity(text, kind, unit))
    assert message is None or message.startswith("must be ")


def rotation(text, angles):
    """Turns of the axes, one after the other about axes that turn along, in degrees."""
    return Rotation.from_euler(text, angles, degrees=True)


ORBIT = pt.KeplerOrbit(
    398600.4418,
    semimajor_axis=7000,
    eccentricity=0.1,
    inclination=math.pi / 6,
    node=math.pi / 240,
    argument_of_periapsis=0.2,
)


def axes_of_the_orbit(time):
    """Radial, transverse, normal, as columns, from position and velocity."""
    r, v = np.array(ORBIT.position_at(time)), np.array(ORBIT.velocity_at(time))
    h = np.cross(r, v)
    radial, normal = r / np.linalg.norm(r), h / np.linalg.norm(h)
    return np.column_stack([radial, np.cross(normal, radial), normal]), h / (r @ r)


def test_attitudes_and_rates():
    degree = math.pi / 180
    matrix = rotation("ZXZ", [10, 20, 30]).as_matrix()
    ways = {
        "quaternion = [0.5, 0.5, 0.5, 0.5]": Rotation.from_quat([0.5, 0.5, 0.5, 0.5]).as_matrix(),
        f"matrix = {matrix.tolist()}": matrix,
        'euler_angles = ["10 deg", "20 deg", "30 deg"]': matrix,
        'euler_angles = ["10 deg", "20 deg", "30 deg"]\nsequence = "321"': rotation("ZYX", [10, 20, 30]).as_matrix(),
    }
    for attitude, wanted in ways.items():
        state = with_state(f'{attitude}\nomega_space = ["1 deg/s", 0, 0]\ntime = "1 min"')
        np.testing.assert_allclose(state.attitude.as_matrix(), wanted, rtol=0, atol=7e-16)
        omega = np.array(state.angular_momentum_body) / [400, 500, 600]
        np.testing.assert_allclose(wanted @ omega, [degree, 0, 0], rtol=0, atol=2.1e-17)
        assert state.time == 60


def test_roll_pitch_yaw_from_the_orbit():
    """Forwards, against the normal, down; yaw about down first, then pitch, then roll; rates relative to the frame."""
    state = with_state(
        'roll_pitch_yaw = ["10 deg", "20 deg", "30 deg"]\nomega_body = [0.001, 0, 0]\nframe = "earth"\ntime = 500'
    )
    axes, turn = axes_of_the_orbit(500.0)
    nadir = np.column_stack([axes[:, 1], -axes[:, 2], -axes[:, 0]])
    wanted = nadir @ rotation("ZYX", [30, 20, 10]).as_matrix()
    np.testing.assert_allclose(state.attitude.as_matrix(), wanted, rtol=0, atol=1e-15)
    omega = wanted @ (np.array(state.angular_momentum_body) / [400, 500, 600])
    np.testing.assert_allclose(omega, turn + wanted @ [0.001, 0, 0], rtol=0, atol=1e-17)


def test_states_relative_to_the_orbit_and_to_a_turntable():
    axes, turn = axes_of_the_orbit(500.0)
    state = with_state('quaternion = [1, 0, 0, 0]\nomega_space = [0, 0, 0]\nframe = "earth"\ntime = 500')
    np.testing.assert_allclose(state.attitude.as_matrix(), axes, rtol=0, atol=1e-15)
    np.testing.assert_allclose(state.angular_momentum_space, axes @ ([400, 500, 600] * (axes.T @ turn)), rtol=1e-12)
    table = '[frames.table]\nattitude = [1, 0, 0, 0]\nomega_space = [0, 0, "1 rpm"]\n[times]'
    turned = with_state(
        'quaternion = [1, 0, 0, 0]\nomega_body = [0, 0, 0]\nframe = "table"\ntime = 10', ("[times]", table)
    )
    np.testing.assert_allclose(turned.attitude.as_matrix(), rotation("Z", 60).as_matrix(), rtol=0, atol=1e-15)
    np.testing.assert_allclose(turned.angular_momentum_body, [0, 0, 600 * 2 * math.pi / 60], rtol=1e-15)


def test_canonical_pairs():
    pair = with_state("quaternion = [0.5, 0.5, 0.5, 0.5]\nconjugate_momenta = [1, -1, 1, -1]\ntime = 3")
    assert pair.quaternion.tolist() == [0.5] * 4
    assert pair.conjugate_momenta.tolist() == [1, -1, 1, -1]
    euler = with_state('euler_angles = ["45 deg", 1.0, 2.0]\neuler_momenta = [0.1, 0.2, 0.3]\nsequence = "321"')
    same = pt.State.from_euler((math.pi / 4, 1, 2), (0.1, 0.2, 0.3), "321")
    assert euler.conjugate_momenta.tolist() == same.conjugate_momenta.tolist()


TIMES = {
    "stop = 1\ncount = 5": np.linspace(0, 1, 5),
    "start = 10\nstop = 0\nstep = -2.5": [10, 7.5, 5, 2.5, 0],
    'start = "1 min"\nstop = "2 min"\nstep = "20 s"': [60, 80, 100, 120],
    "values = [3, 1, -2]": [3, 1, -2],
    'periods = 2\norbit = "earth"\ncount = 3': np.linspace(0, 2 * ORBIT.period, 3),
}


@pytest.mark.parametrize("times", TIMES)
def test_times(times):
    found = scenario(SATELLITE, ('stop = "2 h"\ncount = 11', times)).times
    np.testing.assert_allclose(found, TIMES[times], rtol=1e-15)


def test_times_start_with_the_state():
    assert scenario(SATELLITE, ("[[forces]]", "time = 600\n[[forces]]")).times[0] == 600


def test_dates():
    pytest.importorskip("astropy")
    calendar = '[calendar]\nzero = "2026-11-21T00:00:00"\nscale = "UTC"\n[body]'
    changes = (
        ("[body]", calendar),
        (
            'stop = "2 h"\ncount = 11',
            'start = "2026-11-21T00:00:37 TAI"\nstop = "2026-11-22T00:00:00 UTC"\nstep = "12 h"',
        ),
        ("[[forces]]", 'time = "2026-11-21T01:00:00 UTC"\n[[forces]]'),
        (
            "[times]",
            '[orbits.sun]\ntype = "planet_orbit"\nbody = "earth"\nattractor = "sun"\n'
            'start = -10\nstop = "2026-11-23T00:00:00 UTC"\n[times]',
        ),
        ("[orbits.earth]", '[[forces]]\ntype = "GravityGradient"\norbit = "sun"\n[orbits.earth]'),
    )
    found = scenario(SATELLITE, *changes)
    assert found.times.tolist() == [0, 43200, 86400]
    assert found.state.time == 3600
    sun = found.system.forces[1].orbit
    assert sun.span == (-10.0, 2 * 86400.0)
    assert sun.origin == "SUN"


def test_unit_of_time_is_that_of_the_orbits():
    pytest.importorskip("astropy")
    environment = (
        '[orbits.earth]\ntype = "planet_orbit"\nbody = "moon"\nattractor = "earth"\nstart = 0\nstop = 10000\n[times]'
    )
    own = SATELLITE[SATELLITE.index("[orbits.earth]") : SATELLITE.index("[times]") + 7]
    assert scenario(SATELLITE, (own, environment)).system.calendar.unit == "s"
    with pytest.raises(ValueError, match=r"line 10: in forces, units\['time'\] must be 's', .*, got 'min'\."):
        scenario(SATELLITE, (own, environment), ('"s"', '"min"'))


def test_every_form_of_a_body():
    point = "masses = [1, 1, 1, 1, 2]\npositions = [[1, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -2, 0], [0, 0, 0.5]]"
    bodies = {
        'type = "Body.from_inertia"\ntensor = [[4, 0.1, 0], [0.1, 5, 0], [0, 0, 6]]': pt.Body.from_inertia(
            [[4, 0.1, 0], [0.1, 5, 0], [0, 0, 6]]
        ),
        'type = "Body.from_stokes"\nC20 = -0.01\nC22 = 0.002\npolar_moment_factor = 0.4\nmass = 2': pt.Body.from_stokes(
            -0.01, 0.002, 0.4, mass=2
        ),
        'type = "Body.from_ratios"\nbeta = 0.47\ngamma = 0.26': pt.Body.from_ratios(beta=0.47, gamma=0.26),
        'type = "Body.from_ellipsoid"\nmass = 5\nsemiaxes = [1, 2, 3]': pt.Body.from_ellipsoid(5, (1, 2, 3)),
        'type = "Body.from_box"\nmass = 5\nsides = [1, 2, 3]': pt.Body.from_box(5, (1, 2, 3)),
        'type = "Body.from_cylinder"\nmass = 5\nradius = 1\nheight = 3': pt.Body.from_cylinder(5, 1, 3),
        f'type = "Body.from_point_masses"\n{point}': pt.Body.from_point_masses(
            [1, 1, 1, 1, 2], [[1, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -2, 0], [0, 0, 0.5]]
        ),
        'type = "Body.from_shape"\nshape = {type = "Ellipsoid", mass = 5, semiaxes = [1, 2, 3]}': (
            pt.Body.from_ellipsoid(5, (1, 2, 3))
        ),
    }
    assert len(bodies) == sum(name.startswith("Body.") for name in makers("body"))
    for text, body in bodies.items():
        found = scenario(SATELLITE, ("moments = [400, 500, 600]", text)).system.body
        assert np.array_equal(found.inertia, body.inertia)


def test_attractors_next_to_each_other_share_their_path():
    text = """
[orbits.path]
type = "ThreeBodyPath"
mu_primary = 1.0
mu_secondary = 0.01
separation = 1.0
position = [1.2, 0, 0.1]
velocity = [0, -0.2, 0]
[times]"""
    both = '[[forces]]\ntype = "GravityGradient"\norbit = "path.from_primary"\n[orbits.earth]'
    found = scenario(
        SATELLITE, ('orbit = "earth"', 'orbit = "path.from_secondary"'), ("[orbits.earth]", both), ("[times]", text)
    )
    first, second = (force.orbit for force in found.system.forces)
    assert first.path is second.path
    assert (first.attractor, second.attractor) == ("secondary", "primary")


ENSEMBLE = """\
[ensemble]
members = 4000
seed = 7
[[ensemble.spread]]
of = "body.moments"
distribution = "uniform"
size = [10, 0, 20]
[[ensemble.spread]]
of = "state.omega_body"
size = "0.01 deg/s"
[[ensemble.spread]]
of = "state.turn"
size = ["2 deg", 0, 0]
[[ensemble.spread]]
of = "orbits.earth.inclination"
size = "1 deg"
"""


def test_ensemble_has_the_spread_that_it_says():
    degree = math.pi / 180
    found = scenario(SATELLITE + ENSEMBLE)
    moments, omega = found.system.body.moments, found.system.body.omega(found.state.angular_momentum_body)
    inclination = found.system.forces[0].orbit.inclination
    assert moments.shape == (4000, 3)
    assert np.all(moments[:, 1] == 500)
    assert np.all(np.abs(moments - [400, 500, 600]) <= [10, 0, 20])
    assert np.std(moments[:, 0]) == pytest.approx(10 / math.sqrt(3), rel=0.03)
    assert np.std(omega, axis=0) == pytest.approx(0.01 * degree, rel=0.05)
    assert np.mean(omega, axis=0) == pytest.approx([0, 0.1 * degree, 0.001], abs=5e-6)
    turned = found.state.attitude.as_rotvec()
    assert np.std(turned[:, 0]) == pytest.approx(2 * degree, rel=0.05)
    assert np.all(np.abs(turned[:, 1:]) < 1e-15)
    assert np.std(inclination) == pytest.approx(degree, rel=0.05)
    assert np.mean(inclination) == pytest.approx(30 * degree, abs=0.06 * degree)


def test_isotropic_attitudes_have_no_direction():
    """Means of axes, of their squares, and of the angle, pi/2 + 2/pi."""
    text = '[ensemble]\nmembers = 20000\nseed = 3\n[[ensemble.spread]]\nof = "state.turn"\n'
    turned = scenario(SATELLITE + text + 'distribution = "isotropic"\n').state.attitude
    axes = turned.apply((0, 0, 1))
    np.testing.assert_allclose(np.mean(axes, axis=0), 0, rtol=0, atol=0.02)
    np.testing.assert_allclose(np.mean(axes**2, axis=0), 1 / 3, rtol=0, atol=0.01)
    assert np.mean(turned.magnitude()) == pytest.approx(math.pi / 2 + 2 / math.pi, abs=0.02)
    for spread, sentence in {
        'distribution = "isotropic"\nsize = 1': "size must not be given together with isotropic, got both.",
        'distribution = "uniform"': "size must be given, got none.",
    }.items():
        with pytest.raises(ValueError, match=rf"ensemble\.spread\[0\]\.{sentence}"):
            scenario(SATELLITE + text + spread)
    with pytest.raises(
        ValueError, match=r"spread\[0\]\.of must be state\.turn if it is isotropic, got 'body\.moments'"
    ):
        scenario(SATELLITE + text.replace("state.turn", "body.moments") + 'distribution = "isotropic"\n')


def test_turn_is_about_the_body_axes():
    spread = '[ensemble]\nmembers = 5\nseed = 1\n[[ensemble.spread]]\nof = "state.turn"\nsize = [0, "9 deg", 0]\n'
    base = Rotation.from_quat([0.1, 0.5, 0.5, 0.7], scalar_first=True)
    quaternion = base.as_quat(scalar_first=True).tolist()
    found = scenario(SATELLITE + spread, ("[1, 0, 0, 0]", str(quaternion))).state
    turned = (base.inv() * found.attitude).as_rotvec()
    assert np.all(np.abs(turned[:, 1]) > 1e-3)
    assert np.all(np.abs(turned[:, ::2]) < 1e-15)


def test_seed_makes_the_same_members_again():
    first, second = scenario(SATELLITE + ENSEMBLE), scenario(SATELLITE + ENSEMBLE)
    other = scenario(SATELLITE + ENSEMBLE.replace("seed = 7", "seed = 8"))
    assert np.array_equal(first.state.quaternion, second.state.quaternion)
    assert not np.any(first.system.body.moments[:, 0] == other.system.body.moments[:, 0])


def test_closed_form_and_integration_agree():
    free = SATELLITE[: SATELLITE.index("[[forces]]")] + SATELLITE[SATELLITE.index("[times]") :]
    exact = scenario(free + '[run]\nmethod = "closed form"\n').propagate()
    integrated = scenario(free + '[run]\nformulation = "canonical"\ntolerance = 1e-14\n').propagate()
    assert (exact.run.method, integrated.run.formulation, integrated.run.tolerance) == (
        "closed form",
        "canonical",
        1e-14,
    )
    np.testing.assert_allclose(exact.quaternion, integrated.quaternion, rtol=0, atol=1e-12)


# ------------------------------------------------------------------ what a new class needs


def test_every_public_class_can_be_read():
    """All forces and orbits of the package but those that are tables."""
    public = [getattr(space, name) for space in (pt.forces, pt.orbits) for name in space.__all__]
    forces = [cls.__name__ for cls in public if isinstance(cls, type) and issubclass(cls, pt.Potential | pt.Torque)]
    orbits = [cls.__name__ for cls in public if isinstance(cls, type) and issubclass(cls, pt.Orbit)]
    assert set(forces) - {"Potential", "Torque"} <= set(makers("force"))
    assert set(orbits) - {"Orbit", "Ephemeris"} <= set(makers("orbit"))


def test_a_name_measures_one_thing():
    """As the annotations say it: an epoch that is a time in one class and a plain number in another is forgotten."""
    kinds = {}
    groups = ("body", "force", "orbit", "frame", "shape")

    def own(group):
        return [maker for maker in makers(group).values() if maker.call.__module__.startswith("poinsot.")]

    made = [maker for group in groups for maker in own(group)]
    keys = [key for maker in made for key in maker.keys]
    of_records = {key.group for key in keys if isinstance(key.group, type)}
    keys += [key for group in of_records for maker in own(group) for key in maker.keys]
    for key in (key for key in keys if key.kind not in ("file", "orbit", "record")):
        kinds.setdefault(key.name, set()).add((key.kind, key.rank))
    quantities = {name: {kind for kind, _ in found if kind != "text"} for name, found in kinds.items()}
    assert [name for name, found in quantities.items() if len(found) > 1] == []
    assert kinds["inclination"] == {("angle", 0)}
    assert kinds["epoch"] == {("time", 0)}
    assert kinds["omega_space"] == {("rate", 1)}
    assert kinds["time_since_periapsis"] == {("duration", 0)}


def test_examples_satisfy_the_schema():
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(schema())
    for path in (ROOT / "examples").glob("*.toml"):
        tables = tomllib.loads(path.read_text())
        assert not list(validator.iter_errors(tables)), path
        assert list(validator.iter_errors(tables | {"bodies": 1}))


@pytest.mark.parametrize("name", ["specular", "diffuse", "drag", "accommodation"])
def test_the_schema_allows_one_number_for_all_facets(name):
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(schema())
    for sides, shares, allowed in (([1, 1, 1], 0.2, True), ([1, 1, 1], [0.2] * 6, True), (1, 0.2, False)):
        facets = {"type": "Facets.from_box", "sides": sides, name: shares}
        tables = tomllib.loads(SATELLITE)
        tables["forces"] = [{"type": "RadiationPressure", "sun": "earth", "facets": facets}]
        assert validator.is_valid(tables) == allowed


# ------------------------------------------------------------------ sentences

WRONG = {
    "line 6: unknown key 'momens' in [body]. Did you mean 'moments'?": ("moments", "momens"),
    "line 11: forces[0].type must name a known type, got 'GravityGradeint'. Did you mean 'GravityGradient'?": (
        ("GravityGradient", "GravityGradeint")
    ),
    "line 12: forces[0].orbit must be the name of a table under orbits, got 'erth'. Did you mean 'earth'?": (
        ('"earth"', '"erth"')
    ),
    "line 6: body.moments must satisfy the triangle inequality, but 4000.0 > 500.0 + 600.0. "
    "No rigid body has these moments.": ("400", "4000"),
    "line 18: orbits.earth.inclination must be an angle in rad, mrad, deg, arcmin, arcsec, rev, got '30 km'.": (
        ("30 deg", "30 km")
    ),
    "line 16: orbits.earth.semimajor_axis must be a number in your own units, got '7000 km'.": (
        "7000",
        '"7000 km"',
    ),
    "line 9: state.omega_body[1] must be a rate: rpm, or an angle (rad, mrad, deg, arcmin, arcsec, rev) over a time "
    "(s, min, h, d), got '0.1 deg/fortnight'.": ("0.1 deg/s", "0.1 deg/fortnight"),
    "line 9: state.omega_body[1] must be a number where the file does not state its unit of time, got '0.1 deg/s'. "
    "Say units.time: s, min, h, d.": ('time = "s"', 'time = "year"'),
    "line 22: times.stop must be a time in s, min, h, d, got '2 km'.": ("2 h", "2 km"),
    "line 5: body must be one table, got a list. A scenario has one: [body].": ("[body]", "[[body]]"),
    "line 23: times.count must be a whole number, got 1.5.": ("11", "1.5"),
    "line 23: times.count must be at most 10000000, got a large number.": ("11", "9" * 40),
    "line 7: in forces[0], body and forces must have equally many members, got 2 and 3.": (
        "400, 500, 600]\n",
        "[1, 1, 1], [1, 1, 1.5]]\n[[forces]]\ntype = 'LinearDamping'\ncoefficient = [1, 2, 3]\n",
    ),
    "line 13: orbits.earth.mu must be given, got none.": ("mu = 398600.4418\n", ""),
    "line 7: state must have exactly one of quaternion, matrix, euler_angles, roll_pitch_yaw, got none.": (
        ("quaternion = [1, 0, 0, 0]\n", "")
    ),
    "line 7: state must have exactly one of omega_body, omega_space, angular_momentum_body, "
    "angular_momentum_space, got omega_body and omega_space.": (
        "omega_body",
        "omega_space = [0, 0, 0]\nomega_body",
    ),
    "line 8: state.quaternion must have unit norm": ("[1, 0, 0, 0]", "[1, 0, 0, 0.1]"),
    "line 9: state.frame must be the name of a table under orbits, got 'mars'. Known tables are earth.": (
        ("omega_body", 'frame = "mars"\nomega_body')
    ),
    "line 6: body.moments must be finite, got moments[0] = nan.": ("400", "nan"),
    "line 6: body.moments[0] must be a number, got true.": ("400", "true"),
    "line 6: body.moments must be real numbers, got list [400, [500], 600].": ("500", "[500]"),
    "line 18: orbits.earth.inclination must be a number, got the date 2026-01-01.": ('"30 deg"', "2026-01-01"),
    "line 1: title must be text, got 3.": ('"test"', "3"),
    "line 2: unknown key 'unit'. Did you mean 'units'?": ("[units]", "[unit]"),
    "line 22: run.method must be 'integration' or 'closed form', got 'integral'. Did you mean 'integration'?": (
        ("[times]", '[run]\nmethod = "integral"\n[times]')
    ),
    "it.toml, line 22: run.method must be integration together with forces, got 'closed form'.": (
        ("[times]", '[run]\nmethod = "closed form"\n[times]')
    ),
    "line 21: times must have one of stop and periods, or values.": ("stop", "periods = 1\nstop"),
    "line 21: times.orbit must be given together with periods, got none.": ('stop = "2 h"', "periods = 2"),
    "line 21: the text must be TOML, got ": ("[times]", "[times"),
    "line 24: count must be given once, got it twice.": ("count = 11", "count = 11\ncount = 12"),
    "line 21: body must be one table, got [body] again.": ("[times]", "[body]\n[times]"),
    "line 10: forces[0].type must be given, got none. Known types are ": ('type = "GravityGradient"\n', ""),
    "line 22: in times.values, times must be strictly monotonic, but times[1]": (
        'stop = "2 h"\ncount = 11',
        "values = [1, 3, 2]",
    ),
    "line 22: run.tolerance must be at least the rounding unit of double precision, 2.220446049250313e-16, got 1e-60": (
        "[times]",
        "[run]\ntolerance = 1e-60\n[times]",
    ),
    "line 22: run.tolerance must be between 0 and 1, got -1.0.": (
        "[times]",
        "[run]\ntolerance = -1\n[times]",
    ),
    "line 22: calendar.zero must be a date that exists, got '2026-13-01'.": (
        "[times]",
        '[calendar]\nzero = "2026-13-01"\nscale = "UTC"\n[times]',
    ),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_sentences(sentence):
    change = WRONG[sentence]
    with pytest.raises(ValueError) as caught:
        scenario(SATELLITE, change)
    assert str(caught.value).removeprefix("it.toml, ").startswith(sentence.removeprefix("it.toml, "))


WRONG_ENSEMBLES = {
    "ensemble.seed must be at least 0, got -1.": ("seed = 7", "seed = -1"),
    "ensemble.members must be at most 1000000, got 1000001.": ("4000", "1000001"),
    "ensemble.spread[2].of must be the place of a number, got 'state.tern'.": ("turn", "tern"),
    "ensemble.spread[0].size must be one number, or one for each component, got others: ": ("[10, 0, 20]", "[10, 20]"),
    "ensemble.spread[1].size must be a rate": ('"0.01 deg/s"', '"1 deg"'),
    "unknown key 'member' in [ensemble]. Did you mean 'members'?": ("members", "member"),
    "body.moments must satisfy the triangle inequality": ("[10, 0, 20]", "[390, 0, 0]"),
}


@pytest.mark.parametrize("sentence", WRONG_ENSEMBLES)
def test_sentences_of_ensembles(sentence):
    old, new = WRONG_ENSEMBLES[sentence]
    with pytest.raises(ValueError) as caught:
        scenario(SATELLITE + ENSEMBLE.replace(old, new, 1))
    assert str(caught.value).partition(": ")[2].startswith(sentence)


@pytest.mark.parametrize(
    "name", ["../a.nc", "/tmp/a.nc", "a/b.nc", "..", ".nc", "a\\b.nc", "a\nb.nc", "C:a.nc", "a" * 300]
)
def test_names_that_lead_away_are_refused(name):
    with pytest.raises(ValueError, match=r"outputs.result must be the name of a file, without a folder, got .*\."):
        scenario(SATELLITE + f"[outputs]\nresult = {json.dumps(name)}\n")


def test_names_of_other_kinds_are_refused():
    with pytest.raises(ValueError, match=r"outputs.plot must end in .png or .pdf or .svg, got 'a.exe'\."):
        scenario(SATELLITE + '[outputs]\nplot = "a.exe"\n')


def test_orbits_that_need_each_other_are_refused():
    around = '[orbits.a]\ntype = "PrecessingOrbit"\norbit = "b"\n[orbits.b]\ntype = "PrecessingOrbit"\norbit = "a"\n'
    with pytest.raises(
        ValueError, match=r"b.orbit must be an orbit that does not require this orbit, got 'a', which requires it"
    ):
        scenario(SATELLITE.replace('orbit = "earth"', 'orbit = "a"') + around)


def test_files_that_are_no_scenarios(tmp_path):
    files = {
        "empty.toml": b"",
        "bytes.toml": bytes(range(256)),
        "wrong.txt": b"",
        "utf16.toml": SATELLITE.encode("utf-16"),
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=r" must .* (but|got) .*\.$|missing table \[body\]\.$"):
            pt.files.read_scenario(tmp_path / name)
    with pytest.raises(FileNotFoundError, match=r"No such file: .*none\.toml$"):
        pt.files.read_scenario(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="must be a file, got a folder"):
        pt.files.read_scenario(tmp_path.joinpath("folder.toml").mkdir() or tmp_path / "folder.toml")


def test_a_file_of_a_gigabyte_is_refused_at_once(tmp_path):
    path = tmp_path / "large.toml"
    with path.open("wb") as stream:
        stream.truncate(10**9)
    began, before = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ValueError, match="must have at most 4000000 bytes, got more"):
        pt.files.read_scenario(path)
    assert time.process_time() - began < 1
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000


VALUES = st.one_of(
    st.sampled_from(
        ["0", "-1", "nan", "inf", "1e400", "true", '""', '"deg"', "[]", "{}", "[[1]]", "[1, 2]", "2026-01-01"]
    ),
    st.sampled_from(['"earth"', '"../x"', '"KeplerOrbit.from_vectors"', '"1 deg"', '"x.nc"', "[[], {}]", '["a"]']),
    st.integers().map(str),
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.text(max_size=8).map(json.dumps),
)


TWO_BODIES = [(ROOT / "examples" / f"{name}.toml").read_text() for name in ("didymos", "moshup")]
SPREAD = '[ensemble]\nmembers = 3\nseed = 7\n[[ensemble.spread]]\nof = "state.kick.delta_velocity"\nsize = 1e-4\n'
TEXTS = [SATELLITE + ENSEMBLE.replace("4000", "3"), TWO_BODIES[0] + SPREAD, TWO_BODIES[1]]


@settings(max_examples=450, deadline=None)
@given(st.data())
def test_changed_scenarios_are_read_or_refused_in_a_sentence(data):
    """Any value in the place of another, and lines that are gone, doubled or moved."""
    lines = data.draw(st.sampled_from(TEXTS)).splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(lines) - 1))
        way = data.draw(st.sampled_from(["value", "value", "value", "drop", "double", "move"]))
        key, equals, _ = lines[i].partition(" = ")
        if way == "value" and equals:
            lines[i] = f"{key} = {data.draw(VALUES)}"
        elif way == "double":
            lines.insert(i, lines[i])
        elif way == "move":
            lines.insert(data.draw(st.integers(0, len(lines) - 1)), lines.pop(i))
        elif len(lines) > 1:
            lines.pop(i)
    message = refusal(lambda: parsed_scenario("\n".join(lines), "it.toml"))
    assert message is None or (message.startswith("it.toml") and "\n" not in message)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_bytes_are_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("bytes") / "it.toml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"^.*it\.toml"):
        pt.files.read_scenario(path)


def test_system_alone_needs_neither_state_nor_times():
    text = (
        SATELLITE[: SATELLITE.index("[state]")] + SATELLITE[SATELLITE.index("[[forces]]") : SATELLITE.index("[times]")]
    )
    assert len(rebuilt_system(text, "it").forces) == 1
    with pytest.raises(ValueError, match=r"missing table \[state\]"):
        parsed_scenario(text, "it")


# ------------------------------------------------------------------ parts of a body

WHEELED = """\
[body]
moments = [6, 8, 10]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0.8, 0.02, 0.05]
[state.own]
reaction_wheel = [2.005]
[[forces]]
type = "ReactionWheel"
axis = [0, 0, 1]
moment = 0.1
friction = 1e-4
[[forces]]
type = "KaneDamper"
moment = 0.4
coefficient = 0.3
[times]
stop = 1
count = 3
"""

WHEEL, DAMPER = ReactionWheel((0, 0, 1), 0.1, friction=1e-4), KaneDamper(0.4, 0.3)


def test_a_body_with_parts_starts_at_the_rate_that_is_given():
    """K^-1 omega + h by hand: of the wheel its momentum along the axis, of the damper its moment times the rate."""
    omega, locked = np.array([0.8, 0.02, 0.05]), np.array([6.0, 8.0, 10.0])
    made = scenario(WHEELED)
    momentum = (locked - 0.4) * omega + 0.4 * omega + np.array([0, 0, 2.005 - 0.1 * 0.05])
    np.testing.assert_allclose(made.state.angular_momentum_body, momentum, rtol=1e-15)
    np.testing.assert_allclose(made.system.omega_body(made.state), omega, rtol=1e-14)
    np.testing.assert_array_equal(made.state.own["reaction_wheel"], [2.005])
    np.testing.assert_allclose(made.state.own["kane_damper"], 0.4 * omega, rtol=1e-15)


def test_a_motion_with_parts_is_that_of_the_same_system_in_python():
    system = pt.System(pt.Body((6, 8, 10)), WHEEL, DAMPER)
    start = system.state((1, 0, 0, 0), omega_body=(0.8, 0.02, 0.05), reaction_wheel=[2.005])
    known, motion = pt.propagate(system, start, np.linspace(0, 1, 3)), scenario(WHEELED).propagate()
    for name, values in known.phase.items():
        np.testing.assert_array_equal(motion.phase[name], values, err_msg=name)


@pytest.mark.parametrize(
    ("pair", "g"),
    [
        ("quaternion = [1, 0, 0, 0]\nconjugate_momenta = [0, 2, 4, 6]", (1, 2, 3)),
        ("euler_angles = [0.1, 1.2, 0.3]\neuler_momenta = [0.5, 0.6, 0.4]", None),
    ],
)
def test_a_canonical_pair_goes_with_the_variables_of_all_parts(pair, g):
    begin, end = WHEELED.index("quaternion"), WHEELED.index("[state.own]")
    text = WHEELED[:begin] + pair + "\n" + WHEELED[end:]
    state = scenario(text, ("[2.005]", "[2.005]\nkane_damper = [1, 2, 3]")).state
    np.testing.assert_array_equal(state.own["kane_damper"], [1, 2, 3])
    if g:
        np.testing.assert_array_equal(state.angular_momentum_body, g)
    with pytest.raises(ValueError, match=r"state must have the 3 variables of the part 'kane_damper', got 0"):
        scenario(text)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("reaction_wheel = [1, 2]", r"line 7: state.own.reaction_wheel must have shape \(1,\)"),
        ("wheel = [1]", r"line 6: own must name parts with variables, reaction_wheel, kane_damper, got 'wheel'"),
        ("reaction_wheel = '1'", r"line 7: state.own.reaction_wheel must be a number in your own units, got '1'"),
        ("reaction_wheel = [nan]", r"line 7: state.own.reaction_wheel must"),
    ],
)
def test_wrong_variables_of_parts_are_reported_with_their_place(wrong, message):
    with pytest.raises(ValueError, match=message):
        scenario(WHEELED, ("reaction_wheel = [2.005]", wrong))


def test_an_ensemble_varies_the_variables_of_parts():
    spread = "[ensemble]\nmembers = 3\nseed = 1\n[[ensemble.spread]]\nof = 'state.own.reaction_wheel'\nsize = 0.1\n"
    made = scenario(WHEELED + spread)
    drawn = 2.005 + 0.1 * np.random.default_rng(1).standard_normal((3, 1))
    np.testing.assert_array_equal(made.state.own["reaction_wheel"], drawn)
    np.testing.assert_allclose(made.system.omega_body(made.state), [[0.8, 0.02, 0.05]] * 3, rtol=1e-14)
