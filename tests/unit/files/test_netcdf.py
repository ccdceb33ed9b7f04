"""Results in files: back to the bit, run again to the bit, and refused where they are not whole."""

import copy
import dataclasses
import json
import os
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from in_order import in_order
from poinsot import functions as fn
from poinsot.files.scenario import parsed_scenario, repetition
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, SpringMass
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.scenario_of_motion import scenario_of

BODY = pt.Body((400.0, 500.0, 600.0))
OBLIQUE = pt.Body.from_inertia([[3, 0.1, 0], [0.1, 4, 0.2], [0, 0.2, 5]])
KEPLER = pt.KeplerOrbit(
    398600.4418, semimajor_axis=7000.0, eccentricity=0.2, inclination=0.5, node=0.7, argument_of_periapsis=0.2
)
PATH = pt.orbits.ThreeBodyPath(
    398600.0, 4900.0, separation=384400.0, position=(450000.0, 0, 10000.0), velocity=(0, -0.18, 0)
)
BOTH = pt.GravityGradient(PATH.from_primary), pt.GravityGradient(PATH.from_secondary)
TIMES = np.linspace(0, 5828, 41)
MANY = np.random.default_rng(3).normal(size=(3, 3)) * 0.01


class Magnet(pt.Potential):
    """A class from outside the package."""

    moment_body: pt.mechanics.Vector

    def energy(self, instant):
        return -fn.dot(self.moment_body, instant.attitude.to_body((0, 0, 1.0)))


class Gimbal(pt.Part):
    """A part from outside the package: a rotor whose axis a spring holds in the body."""

    spin: float
    variables = {"angle": 1, "momentum": 1}  # noqa: RUF012
    momenta = frozenset({"momentum"})

    def momentum(self, own, time):  # noqa: ARG002
        return fn.Vector((self.spin * fn.cos(own[0]), self.spin * fn.sin(own[0]), own[1]))

    def spinning_inertia(self, own):  # noqa: ARG002
        return ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.3))

    def internal_energy(self, own, time):  # noqa: ARG002
        return own[1] * own[1] / 0.6 + own[0] * own[0]

    def rates(self, instant, generalised_force):  # noqa: ARG002
        angle, p = instant.own(self)
        w1, w2, w3 = instant.omega_body
        return fn.Vector((p / 0.3 - w3, self.spin * (w2 * fn.cos(angle) - w1 * fn.sin(angle)) - 2 * angle))


class Relaxed(pt.Event):
    """A user's own event on the variables of a part."""

    name = "relaxed"

    def value(self, instant):
        return instant.own(SPRING)[0]


WHEEL = ReactionWheel((0.6, 0, 0.8), 10.0, 1e-4, 1e-4)
OTHER = ReactionWheel((0, 1.0, 0), 20.0, name="other")
DAMPER, SPRING = KaneDamper(30.0, 0.01), SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0, 0.003)


def with_parts(*forces, body=BODY, omega=(0.001, 0.002, 0.003), times=TIMES / 10, time=0.0, own=None, **options):
    system = pt.System(body, *forces, units={"time": "s", "inertia": "kg m2"})
    state = system.state((0.5, 0.5, -0.5, 0.5), omega_body=omega, time=time, **(own or {}))
    return pt.propagate(system, state, times, progress=False, **options)


def start(body=BODY, omega=(0.001, 0.002, 0.003), **options):
    return body.state((0.5, 0.5, -0.5, 0.5), omega_body=omega, **options)


def run(body, *forces, times=TIMES, state=None, units=None, **options):
    return pt.propagate(pt.System(body, *forces, units=units), state or start(body), times, progress=False, **options)


ROUND = pt.Body.from_shape(pt.shapes.Ellipsoid((1.2, 1.1, 0.9), mass=3.0))
LONG = pt.Body.from_inertia([[0.1, 0.01, 0], [0.01, 0.12, 0.02], [0, 0.02, 0.15]], mass=0.5)
PAIR = pt.TwoBodies(ROUND, LONG, G=0.9)
SI = {"time": "s", "inertia": "kg m2", "length": "m"}


def two(*forces, pair=PAIR, rate=(0.0, 0.1, 0.4), time=0.0, times=TIMES / 500, **options):
    turns, spins = [(0.8, 0.0, 0.6, 0.0), (0.5, 0.5, -0.5, 0.5)], [(0.1, 0.2, 1.0), rate]
    state = pair.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), turns, omega_body=spins, time=time)
    return pt.propagate(pt.System(pair, *forces, units=SI), state, times, progress=False, **options)


def unattracted(**options):
    with pytest.warns(UserWarning, match="They pass each other on a straight line"):
        return two(**options)


OF_TWO = {
    "two bodies": lambda: two(
        pt.forces.MutualGravity(),
        pt.forces.LinearDamping(1e-3).on("primary"),
        pt.forces.ThirdBody(pt.KeplerOrbit(1e-4, semimajor_axis=100.0, eccentricity=0.1)),
        pt.UniformGravity(1e-3, (1, 0, 0)).on("secondary"),
    ),
    "two bodies, canonical and backwards": lambda: two(
        pt.forces.MutualGravity(), times=-TIMES / 500, time=0.5, formulation="canonical"
    ),
    "two bodies of members": lambda: two(
        pt.forces.MutualGravity(),
        pair=pt.TwoBodies(ROUND, pt.Body((0.1, 0.12, 0.15), mass=[0.4, 0.5, 0.6]), G=0.9),
        rate=50 * MANY,
    ),
    "two bodies with other masses": lambda: two(
        pt.forces.MutualGravity(), pair=pt.TwoBodies(ROUND, LONG, G=[0.9, 1.0], masses=[[3.1, 0.5], [3.2, 0.6]])
    ),
    "two bodies, no forces": lambda: unattracted(dense=True),
}
OF_PARTS = {
    "wheels and a damper": lambda: with_parts(
        WHEEL, OTHER, DAMPER, pt.GravityGradient(KEPLER), time=5.5, own={"other": [0.3]}
    ),
    "part without variables": lambda: with_parts(Gyrostat((0.3, -0.2, 0.5)), body=OBLIQUE, omega=(0.1, 0.2, 0.3)),
    "mass on a spring": lambda: with_parts(SPRING, pt.GravityGradient(KEPLER), own={"spring_mass": (0.1, 0.0)}),
    "parts, orbit integrated along": lambda: with_parts(WHEEL, *BOTH, times=TIMES, formulation="canonical"),
    "parts of members": lambda: with_parts(
        WHEEL, DAMPER, own={"reaction_wheel": [[0.1], [0.2], [0.3]], "kane_damper": MANY}, omega=MANY
    ),
    "wheels of members": lambda: with_parts(ReactionWheel((0, 0, 1), np.array([10.0, 20.0, 30.0]))),
}
MOTIONS = (
    OF_PARTS
    | OF_TWO
    | {
        "in orbit": lambda: run(BODY, pt.GravityGradient(KEPLER), units={"time": "s", "inertia": "kg m2"}),
        "backwards, from within": lambda: run(
            BODY, pt.GravityGradient(KEPLER), times=TIMES[::-1], state=start(time=100.5), formulation="canonical"
        ),
        "dense": lambda: run(BODY, pt.GravityGradient(KEPLER), dense=True, tolerance=1e-10),
        "closed form": lambda: pt.free_motion(BODY, start(), TIMES, units={"time": "h"}),
        "ensemble": lambda: run(BODY, state=start(omega=MANY)),
        "ensemble of bodies": lambda: pt.free_motion(pt.Body(np.add(BODY.moments, [[0], [1], [2]])), start(), TIMES),
        "oblique, damped": lambda: run(
            OBLIQUE, pt.forces.LinearDamping(1e-4), pt.UniformGravity(1e-6, (1, 0.1, 0)), state=start(OBLIQUE)
        ),
        "orbit integrated along": lambda: run(BODY, *BOTH, times=10 * TIMES),
        "escape": lambda: run(
            BODY,
            pt.GravityGradient(
                pt.orbits.EscapeOrbit(
                    398600.4,
                    periapsis_distance=7000.0,
                    eccentricity=1.0,
                    inclination=0.1,
                    node=0.2,
                    argument_of_periapsis=0.3,
                )
            ),
        ),
        "own gravity": lambda: run(
            pt.Body.from_ellipsoid(2.0, (1, 2, 3)),
            pt.forces.EllipsoidGravity(KEPLER, 2.0, (1, 2, 3)),
            state=start(pt.Body.from_ellipsoid(2.0, (1, 2, 3))),
        ),
    }
)


NOT_IN_DATASETS = {"digest", "scenario", "scenario_of", "store"}


def why_not(motion):
    """Why a motion that was read cannot be run again."""
    stored: Any = motion.system
    return stored.not_rerunnable


def assert_same(a, b):
    """The datasets of two motions are the same to the bit, with all their attributes."""
    a, b = a.dataset, b.dataset
    assert set(a.variables) == set(b.variables)
    assert a.attrs == b.attrs
    for name in a.variables:
        assert a[name].dims == b[name].dims
        assert a[name].attrs == b[name].attrs
        assert a[name].values.tobytes() == b[name].values.tobytes(), name


@pytest.fixture(scope="module")
def motions():
    return {name: make() for name, make in MOTIONS.items()}


@pytest.mark.samples
@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("name", MOTIONS)
def test_back_to_the_bit(motions, name, suffix, tmp_path):
    motion = motions[name]
    path = pt.save(motion, tmp_path / f"it{suffix}")
    read = pt.load(path)
    assert_same(motion, read)
    assert isinstance(read.system, pt.System)
    for orbit in [force.orbit for force in read.system.forces if hasattr(force, "orbit")]:
        own = next(force.orbit for force in motion.system.forces if hasattr(force, "orbit"))
        assert type(orbit) is type(own)
    assert type(read) is type(motion)
    bodies: Any = zip(read.system.of_bodies.values(), motion.system.of_bodies.values(), strict=True)
    for one, own in bodies:
        np.testing.assert_array_equal(one.mass, own.mass)
        assert (one.shape is None) is (own.shape is None)
    assert pt.save(read, tmp_path / f"again{suffix}").exists()
    assert_same(motion, pt.load(tmp_path / f"again{suffix}"))


@pytest.mark.filterwarnings("ignore:system should have a force between its two bodies")
@pytest.mark.parametrize("name", MOTIONS)
def test_again_to_the_bit(motions, name, tmp_path):
    read = pt.load(pt.save(motions[name], tmp_path / "it.nc"))
    again = repetition(read, "it")
    assert again.run.get("dense", False) is (name in ("dense", "two bodies, no forces"))
    assert_same(motions[name], again.propagate(progress=False))


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("name", OF_PARTS)
def test_the_variables_of_parts_are_in_the_file(motions, name, suffix, tmp_path):
    motion = motions[name]
    read = pt.load(pt.save(motion, tmp_path / f"it{suffix}"))
    assert list(read.own) == list(motion.own) == [part.name for part in motion.system.parts if part.size]
    for part, values in motion.own.items():
        np.testing.assert_array_equal(read.own[part], values, err_msg=part)
        np.testing.assert_array_equal(read.initial.own[part], motion.initial.own[part], err_msg=part)
        np.testing.assert_array_equal(motion.dataset[f"own_{part}"], values)
    for measured in ("omega_body", "kinetic_energy", "potential_energy"):
        np.testing.assert_array_equal(getattr(read, measured), getattr(motion, measured), err_msg=measured)


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_events_come_back(suffix, tmp_path):
    events = [Relaxed(), pt.events.AtTime(5.0, terminal=True), pt.events.AtTime(1e6)]
    motion = with_parts(SPRING, times=np.linspace(0, 10, 5), own={"spring_mass": (0.1, 0.0)}, events=events)
    assert [len(found) > 1 for found in motion.events] == [True, False, False]
    first = pt.load(pt.save(motion, tmp_path / f"it{suffix}"))
    again = pt.load(pt.save(first, tmp_path / f"again{suffix}"))
    for read in (first, again):
        assert_same(motion, read)
        assert str(read).splitlines()[-2:] == str(motion).splitlines()[-2:]  # how often, and that one was terminal
        for found, own in zip(read.events, motion.events, strict=True):
            assert (repr(found.event), found.event.kind) == (repr(own.event), own.event.kind)
            assert found.event.terminal is own.event.terminal
            assert found.states.phase.keys() == own.states.phase.keys()
            arrays = zip(found.states.phase.values(), own.states.phase.values(), strict=True)
            assert all(np.array_equal(one, other) for one, other in arrays)
            for name in ("times", "directions", "members"):
                assert np.array_equal(getattr(found, name), getattr(own, name))
                assert getattr(found, name).dtype == getattr(own, name).dtype


def test_events_that_do_not_go_together_are_refused(tmp_path):
    motion = with_parts(SPRING, times=np.linspace(0, 10, 5), own={"spring_mass": (0.1, 0.0)}, events=[Relaxed()])
    with xarray.open_dataset(pt.save(motion, tmp_path / "it.nc")) as data:
        read = pt.load(data.load().assign(event_0_direction=("other", [1, 1])))
        assert "Relaxed" in str(read)
        with pytest.raises(
            ValueError, match=r"^event_0_direction must have a row for each event, of shape \(\d+,\), got"
        ):
            read.events  # noqa: B018 - it is read here
        with pytest.raises(ValueError, match=r"^events must be a list of names, got "):
            pt.load(data.assign_attrs(events="{"))


def test_the_variables_of_parts_say_what_they_are(motions):
    data = motions["mass on a spring"].dataset
    assert data["own_spring_mass"].dims == ("time", "component_spring_mass")
    assert list(data["component_spring_mass"].values) == list(SPRING.variables)
    assert "units" not in data["own_spring_mass"].attrs  # a length and a momentum
    data = motions["wheels and a damper"].dataset
    assert data["own_kane_damper"].attrs["units"] == "kg m2 s-1"
    assert list(data["component_kane_damper"].values) == ["momentum_1", "momentum_2", "momentum_3"]


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("many", [False, True])
def test_parts_of_others_are_named_and_not_run(many, suffix, tmp_path):
    own = {"gimbal": [(0.1, 0.2), (0.3, 0.1)] if many else (0.1, 0.2)}
    motion = with_parts(Gimbal(0.7), WHEEL, times=np.linspace(0, 5, 6), own=own)
    read = pt.load(pt.save(motion, tmp_path / f"it{suffix}"))
    assert why_not(read) == "the classes of a scenario must be the package's own, got Gimbal."
    assert_same(motion, read)
    assert_same(motion, pt.load(pt.save(read, tmp_path / f"again{suffix}")))
    some, known = (read[1], motion[1]) if many else (read.isel(time=[1, 3]), motion.isel(time=[1, 3]))
    for name in ("omega_body", "omega_space", "kinetic_energy", "energy"):
        np.testing.assert_array_equal(getattr(some, name), getattr(known, name), err_msg=name)
    with pytest.raises(ValueError, match="omega_body must have the parts of the body to be computed"):
        read.system.omega_body(read.initial)


@pytest.mark.parametrize(
    "message",
    ["[]", "{", '{"gimbal": {}}', '{"gimbal": {"variables": {"angle": -1}, "momenta": []}}'],
)
def test_parts_that_a_dataset_does_not_say_are_refused(motions, message):
    data = motions["parts of members"].dataset.assign_attrs(parts=message)
    with pytest.raises(ValueError, match="the dataset must have parts by name with their variables, got"):
        pt.load(data)


def test_a_text_of_other_parts_is_refused(motions, tmp_path):
    motion = motions["wheels and a damper"]
    with xarray.open_dataset(pt.save(motion, tmp_path / "it.nc"), decode_cf=False) as data:
        text = data.attrs["scenario"].replace('"other"', '"another"')
        assert text != data.attrs["scenario"]
        read = pt.load(data.assign_attrs(scenario=text))
    assert "must describe the saved body, got another body" in why_not(read)


def test_a_scenario_with_parts_is_run_again_from_its_result(tmp_path):
    text = """
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
[[forces]]
type = "KaneDamper"
moment = 0.4
coefficient = 0.3
[times]
stop = 10
count = 3
[ensemble]
members = 3
seed = 1
[[ensemble.spread]]
of = "state.own.reaction_wheel"
size = 0.1
"""
    motion = parsed_scenario(text, "it.toml").propagate(progress=False)
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert read.provenance["scenario"] == text
    assert_same(motion, read)
    assert_same(motion, repetition(read, "it").propagate(progress=False))


def test_datasets_that_xarray_opens_are_read_too(motions, tmp_path):
    with xarray.open_dataset(pt.save(motions["in orbit"], tmp_path / "it.nc"), decode_cf=False) as data:
        read = pt.load(data)
        assert_same(motions["in orbit"], read)
        assert repr(read.system) == repr(motions["in orbit"].system)
    bare: Any = pt.load(motions["in orbit"].dataset)
    assert bare.system.not_rerunnable == (
        "the dataset names its forces and has nothing that makes them again. `save` writes that."
    )


def test_orbits_are_where_they_were_integrated(motions, tmp_path):
    motion = motions["orbit integrated along"]
    read: Any = pt.load(pt.save(motion, tmp_path / "it.nc"))
    for here, there in zip(motion.system.forces, read.system.forces, strict=True):
        own, other = motion.environment.position(here.orbit), read.environment.position(there.orbit)
        assert np.array_equal(np.array(own), np.array(other))


def test_scenario_is_preserved_with_its_comments_and_its_seed(tmp_path):
    text = """
    # a comment
    title = "spread"
    body.moments = [1, 2, 2.5]
    state = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 1, 0.2]}
    times = {stop = 10, count = 5}
    ensemble = {members = 3, seed = 42, spread = [{of = "state.omega_body", size = 0.01}]}
    """
    scenario = parsed_scenario(text, "it.toml")
    motion = scenario.propagate(progress=False)
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert read.provenance == {
        "title": "spread",
        "seed": 42,
        "scenario": text,
        "scenario_of": "state, times and system",
    }
    assert_same(motion, read)
    assert_same(motion, repetition(read, "it.nc").propagate(progress=False))


def test_text_of_a_system_has_all_digits():
    orbit = pt.orbits.PrecessingOrbit(
        pt.KeplerOrbit(
            1 / 3,
            semimajor_axis=0.1 + 0.2,
            eccentricity=1e-17,
            inclination=-0.0,
            node=np.pi,
            argument_of_periapsis=5e-324,
        ),
        node_rate=1e-300,
        periapsis_rate=2 / 3,
    )
    motion = run(
        pt.Body((1 / 3, 0.3, 0.3)), pt.GravityGradient(orbit), times=[0.0], state=start(pt.Body((1 / 3, 0.3, 0.3)))
    )
    from poinsot.scenarios.system_text import rebuilt_system

    again = rebuilt_system(scenario_of(motion.system, motion.run).text, "it")
    for own, other in zip(motion.system.dynamics.numbers, again.dynamics.numbers, strict=True):
        assert own.tobytes() == other.tobytes()


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(1.0, 1.9), min_size=3, max_size=3),
    st.floats(0, 0.99),
    st.tuples(st.floats(-2 * np.pi, 2 * np.pi), *[st.floats(-1e3, 1e3)] * 3),
    st.floats(-1e6, 1e6),
)
def test_any_system_comes_back_from_its_text(moments, eccentricity, angles, epoch):
    from poinsot.scenarios.system_text import rebuilt_system

    orbit = in_order(pt.KeplerOrbit, 1e3, 2.0, eccentricity, *angles, epoch)
    system = pt.System(pt.Body(moments), pt.GravityGradient(orbit), pt.forces.Oblateness(orbit, 1e-3, 0.01, (0, 1, 2)))
    motion = pt.Trajectory(system, start(), TIMES, MotionRows({}), MOTION_RUN)
    again: Any = rebuilt_system(scenario_of(motion.system, motion.run).text, "it")
    assert [x.tobytes() for x in again.dynamics.numbers] == [x.tobytes() for x in system.dynamics.numbers]
    assert again.forces[0].orbit is again.forces[1].orbit


MOTION_RUN = pt.free_motion(BODY, start(), [0.0]).run


# ------------------------------------------------------------------ what cannot be run again


def test_forces_of_others_are_named_and_not_run(tmp_path):
    motion = run(BODY, Magnet((1, 2, 3)), *BOTH, state=start(time=5.0))
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert why_not(read) == "the classes of a scenario must be the package's own, got Magnet."
    for name in ("quaternion", "omega_space", "kinetic_energy", "potential_energy", "energy", "norm_error"):
        assert np.array_equal(getattr(read, name), getattr(motion, name)), name
    assert_same(motion, read)
    with pytest.raises(TypeError, match="system must be a System, got RecordedSystem"):
        pt.propagate(read.system, read.initial, TIMES)
    with pytest.raises(ValueError, match=r"it\.nc cannot be run again: .* got Magnet"):
        repetition(read, "it.nc")
    again = pt.load(pt.save(read, tmp_path / "again.nc"))
    assert_same(motion, again)


def test_integrals_of_forces_of_others_are_those_of_the_file(tmp_path):
    motion = run(BODY, Magnet((1, 2, 3)))
    read = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert set(read.integrals) == {"energy", "angular_momentum_space_3"}
    for name in read.integrals:
        assert np.array_equal(read.integrals[name], motion.integrals[name])
        assert np.array_equal(read.drift[name], motion.drift[name])
    with pytest.raises(ValueError, match="energy must have its forces to be computed"):
        read.system.integrals[0].value(read.initial)


def test_the_absolute_tangency_error_of_an_older_file_is_not_shown(tmp_path):
    """Files of version 0.2 contain q . Q in units of momentum under the same name."""
    motion = run(BODY, Magnet((1, 2, 3)))
    data = motion.dataset
    assert "tangency error (relative)" in repr(pt.load(pt.save(motion, tmp_path / "new.nc")))
    old = data.tangency_error.copy(data=np.full(data.tangency_error.shape, 1e18))
    old.attrs |= {"long_name": "q . Q", "units": "kg m2 s-1"}
    read = pt.load(data.assign(tangency_error=old).assign_attrs(tangency_error=1e18))
    assert "tangency" not in repr(read)
    assert "norm error" in repr(read)
    assert np.array_equal(read.tangency_error, motion.tangency_error)


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("many", [False, True])
def test_forces_of_others_on_two_bodies_are_named_and_not_run(many, suffix, tmp_path):
    masses = [[3.1, 0.5], [3.2, 0.6]] if many else (3.1, 0.5)
    pair = pt.TwoBodies(ROUND, LONG, G=0.9, masses=masses)
    motion: Any = two(pt.forces.MutualGravity(), Magnet((1e-3, 2e-3, 3e-3)).on("secondary"), pair=pair)
    read: Any = pt.load(pt.save(motion, tmp_path / f"it{suffix}"))
    assert why_not(read) == "the classes of a scenario must be the package's own, got Magnet."
    assert_same(motion, read)
    assert_same(motion, pt.load(pt.save(read, tmp_path / f"again{suffix}")))
    for name in ("position", "velocity", "distance", "energy", "angular_momentum_space", "norm_error"):
        assert np.array_equal(getattr(read, name), getattr(motion, name)), name
    assert np.array_equal(read.secondary.omega_space, motion.secondary.omega_space)
    assert read.system.body.primary.mass == motion.system.body.primary.mass
    assert read.system.body.primary.shape.semiaxes.tolist() == [1.2, 1.1, 0.9]
    some, known = (read[1], motion[1]) if many else (read.isel(time=[1, 3]), motion.isel(time=[1, 3]))
    for name in ("position", "velocity", "energy", "kinetic_energy"):
        np.testing.assert_array_equal(getattr(some, name), getattr(known, name), err_msg=name)
    with pytest.raises(AttributeError, match=r"has no quaternion\. Read primary\.quaternion"):
        read.quaternion  # noqa: B018


def test_one_of_two_bodies_is_not_saved_alone(motions, tmp_path):
    with pytest.raises(ValueError, match="motion must be the motion of both bodies, got the motion of one body"):
        pt.save(motions["two bodies"].primary, tmp_path / "it.nc")


WRONG_PAIRS: dict[str, Any] = {
    "must have the variable secondary_moments, got none": lambda data: data.drop_vars("secondary_moments"),
    "must have the variable initial_momentum, got none": lambda data: data.drop_vars("initial_momentum"),
    "must have the variable masses, got none": lambda data: data.drop_vars("masses"),
    "must have the variable secondary_quaternion, got none": lambda data: data.drop_vars("secondary_quaternion"),
    r"must have numbers of shape \(3,\) in position|numbers of shape \(41, 3\) in position": lambda data: data.assign(
        position=("time", data["time"].values)
    ),
    "must have the attribute units_length, got none": lambda data: data.drop_attrs(deep=False).assign_attrs(
        {name: message for name, message in data.attrs.items() if name != "units_length"}
    ),
    "must have the variable quaternion, got none": lambda data: data.assign_attrs(
        state_variables="quaternion angular_momentum_body position momentum"
    ),
}


@pytest.mark.parametrize("sentence", WRONG_PAIRS)
def test_two_bodies_that_are_not_whole_are_refused(motions, sentence):
    with pytest.raises(ValueError, match=f"the dataset {sentence}"):
        pt.load(WRONG_PAIRS[sentence](motions["two bodies"].dataset))


@pytest.mark.parametrize("name", ["masses", "G", "secondary_moments"])
def test_a_text_of_other_two_bodies_is_refused(motions, name, tmp_path):
    with xarray.open_dataset(pt.save(motions["two bodies"], tmp_path / "it.nc"), decode_cf=False) as data:
        read = pt.load(data.assign({name: 1.001 * data[name]}))
    assert "must describe the saved body, got another body" in why_not(read)


def test_tables_of_attitudes_are_not_run(tmp_path, motions):
    motion = motions["in orbit"]
    table = pt.files.AttitudeTable(motion.times, motion.quaternion, motion.omega_body).trajectory(motion.system)
    read = pt.load(pt.save(table, tmp_path / "it.nc"))
    assert why_not(read).endswith("got a table (given rates).")


# ------------------------------------------------------------------ for others


def test_files_of_earlier_versions_that_name_extended_precision_open(motions, tmp_path):
    """Version 0.1 and 0.2 had 64 bits and another kernel in addition to double precision."""
    motion = copy.copy(motions["in orbit"])
    earlier = {"heyoka": "7.13.1", "poinsot": "0.2.0"}
    run = dataclasses.replace(motion.run, precision="extended", kernel="heyoka", versions=earlier, tolerance=1.1e-19)
    motion._complete(run=run)
    found = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert (found.run.precision, found.run.kernel, found.run.versions["heyoka"]) == ("extended", "heyoka", "7.13.1")
    np.testing.assert_array_equal(found.quaternion, motion.quaternion)
    assert "extended" in repr(found)


DATA = Path(__file__).parent / "data"


def test_a_file_of_version_0_2_with_forces_and_parts_of_others_opens():
    """It names the variables of integrated orbits `carried`."""
    path = DATA / "own_force_and_part_0.2.nc"
    read: Any = pt.load(path)
    with xarray.open_dataset(path, decode_cf=False) as data:
        assert data.attrs["version_poinsot"] == "0.2.0"
        assert np.array_equal(read.column("orbit_variables"), data["carried"])
        for name in ("quaternion", "omega_body", "omega_space", "kinetic_energy", "potential_energy"):
            assert np.array_equal(getattr(read, name), data[name]), name
        assert np.array_equal(read.own["spring_mass"], data["own_spring_mass"])
        assert read.summary["norm_error"] == data.attrs["norm_error"]
    assert why_not(read) == "the classes of a scenario must be the package's own, got Magnet."


def test_a_file_of_version_0_2_is_run_again(tmp_path):
    path = DATA / "three_body_path_0.2.nc"
    read: Any = pt.load(path)
    with xarray.open_dataset(path, decode_cf=False) as data:
        values = np.array(data["carried"])
        assert np.array_equal(read.column("orbit_variables"), values)
        assert np.array_equal(read.quaternion, data["quaternion"])
        assert np.array_equal(read.events[0].times, data["event_0_time"])
    again = pt.propagate(read.system, read.initial, read.times, events=[pt.events.SpinFlip((0, 0, 1))], progress=False)
    np.testing.assert_allclose(again.quaternion, read.quaternion, rtol=0, atol=1e-12)
    for force in read.system.forces:
        own, other = np.array(read.environment.position(force.orbit)), np.array(again.environment.position(force.orbit))
        np.testing.assert_allclose(own, other, rtol=1e-12, atol=0)
    new: Any = pt.load(pt.save(read, tmp_path / "it.nc"))
    assert "orbit_variables" in new.dataset
    assert np.array_equal(new.column("orbit_variables"), values)


def test_a_store_of_version_0_2_opens(tmp_path):
    store = tmp_path / "old.zarr"
    with zipfile.ZipFile(DATA / "three_body_path_0.2.zarr.zip") as packed:
        packed.extractall(store)
    assert (store / "carried").is_dir()
    whole: Any = pt.load(DATA / "three_body_path_0.2.nc")
    read: Any = pt.load(store)
    values = whole.column("orbit_variables")
    assert np.array_equal(read.column("orbit_variables"), values)
    assert np.array_equal(read.dataset["orbit_variables"], values)
    assert np.array_equal(read.member(1).events[0].times, whole.member(1).events[0].times)
    for name in (".nc", ".zarr"):
        again: Any = pt.load(pt.save(read, tmp_path / f"again{name}"))
        assert np.array_equal(again.member(1).column("orbit_variables"), values[1])
        assert np.array_equal(again.quaternion, whole.quaternion)


def test_files_say_units_frames_and_versions(motions, tmp_path):
    path = pt.save(motions["in orbit"], tmp_path / "it.nc")
    with xarray.open_dataset(path, decode_times=False) as data:
        assert data.attrs["Conventions"] == "CF-1.11"
        assert data.attrs["version_llvmlite"] == motions["in orbit"].run.versions["llvmlite"]
        assert data["omega_body"].attrs["units"] == "rad s-1"
        assert data["principal_axes"].attrs["frame"] == "body"
        assert "_FillValue" not in data["quaternion"].encoding
        message = repr(data.attrs) + repr({name: array.attrs for name, array in data.variables.items()})
    assert str(tmp_path) not in message
    assert "wall_time" not in message


@pytest.mark.parametrize(
    "name", ["in orbit", "ensemble of bodies", "orbit integrated along", "mass on a spring", "two bodies of members"]
)
def test_stores_are_what_zarr_reads(motions, name, tmp_path):
    """The package zarr, and xarray upon it, find all that is in a store."""
    pytest.importorskip("zarr")
    motion = motions[name]
    with xarray.open_zarr(pt.save(motion, tmp_path / "it.zarr")) as data:
        expected = motion.dataset
        texts = {name: [*map(str, each.values)] for name, each in expected.coords.items() if each.dtype.kind in "OU"}
        numbers = {
            name: range(len(each)) if name.startswith("component_") else [*map(int, each)]
            for name, each in texts.items()
        }
        about = {name: {**expected[name].attrs, "words": each} for name, each in texts.items()}
        expected = expected.assign_coords({name: (name, [*each], about[name]) for name, each in numbers.items()})
        recorded = {name for name in data.variables if str(name).startswith("recorded_")}  # of parts, for `load`
        assert set(data.variables) - recorded == set(expected.variables)
        assert bool(recorded) is (name in OF_PARTS)
        for key in set(data.variables) - recorded:
            variable = data.variables[key]
            assert np.array_equal(variable.values, expected[key].values)
            assert (variable.dims, variable.attrs) == (expected[key].dims, expected[key].attrs)
        assert set(data.attrs) - {"primary_shape"} == set(expected.attrs) | NOT_IN_DATASETS
        assert_same(pt.load(data.load()), motion)


def test_pandas_through_xarray(motions):
    frame = motions["in orbit"].dataset[["quaternion", "kinetic_energy"]].to_dataframe()
    row = frame.xs((0.0, "2"), level=("time", "parameter"))
    assert row["quaternion"].item() == motions["in orbit"].quaternion[0, 2]


# ------------------------------------------------------------------ sentences


def test_nothing_is_replaced_without_a_message(motions, tmp_path):
    for name in ("it.nc", "it.zarr"):
        path = pt.save(motions["in orbit"], tmp_path / name)
        with pytest.raises(FileExistsError, match=rf"{name} already exists; overwrite=True"):
            pt.save(motions["closed form"], path)
        assert_same(motions["in orbit"], pt.load(path))
        pt.save(motions["closed form"], path, overwrite=True)
        assert_same(motions["closed form"], pt.load(path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["it.nc", "it.zarr"]
    other = tmp_path / "other.zarr"
    other.mkdir()
    with pytest.raises(FileExistsError, match="must be a Zarr store to be replaced"):
        pt.save(motions["in orbit"], other, overwrite=True)


def test_what_is_no_result(tmp_path, motions):
    large = tmp_path / "large.nc"
    with large.open("wb") as stream:
        stream.truncate(10**9)
    (tmp_path / "empty.nc").write_bytes(b"")
    (tmp_path / "text.nc").write_text("title = 1")
    (tmp_path / "folder.nc").mkdir()
    (tmp_path / "file.zarr").write_bytes(b"")
    (tmp_path / "folder.zarr").mkdir()
    xarray.Dataset({"x": 1.0}).to_netcdf(tmp_path / "other.nc")
    began = time.process_time()
    for path in tmp_path.iterdir():
        with pytest.raises(ValueError, match=r" must .* (but|got) .*\."):
            pt.load(path)
    assert time.process_time() - began < 1
    with pytest.raises(FileNotFoundError, match=r"No such file: .*gone\.nc"):
        pt.load(tmp_path / "gone.nc")
    with pytest.raises(ValueError, match=r"path must end in \.nc or \.zarr, got 'it\.csv'"):
        pt.load("it.csv")
    with pytest.raises(TypeError, match=r"path must be a path, got int"):
        pt.load(3)
    data = motions["in orbit"].dataset
    with pytest.raises(ValueError, match="the dataset must have the variable initial_time, got none"):
        pt.load(data.drop_vars("initial_time"))
    with pytest.raises(ValueError, match="the dataset must have numbers of shape"):
        pt.load(data.assign(moments=("axis", np.array([1, 2, 3]))))


def test_a_file_that_announces_more_than_it_has_is_refused(motions, tmp_path):
    data = motions["in orbit"].dataset.isel(time=[0])
    path = tmp_path / "it.nc"
    data.drop_dims("time").to_netcdf(path)
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("time", 2_000_000_000)
        file.createVariable("quaternion", "f8", ("time", "parameter"), chunksizes=(1000, 4))
    with pytest.raises(ValueError, match="quaternion is in chunks"):
        pt.load(path)
    with netCDF4.Dataset(path, "a") as file:
        file.renameVariable("quaternion", "other")
        file.createVariable("quaternion", "f8", ("time", "parameter"), contiguous=True)
    with pytest.raises(ValueError, match=r"bytes cannot be the 64\d{9} that it announces"):
        pt.load(path)


def test_a_file_larger_than_memory_is_refused(motions, tmp_path):
    """One with a hole at its end takes little on a disk."""
    path = pt.save(motions["in orbit"], tmp_path / "it.nc")
    os.truncate(path, 2**42)
    with pytest.raises(ValueError, match=rf"it needs {2**42} bytes of memory, of which \d+ are left\.$"):
        pt.load(path)


def changed(content, random):
    """The bytes of a file that was cut off, or had some of its bytes changed or taken out."""
    content, way = bytearray(content), random.integers(3)
    i = int(random.integers(len(content)))
    if way == 0:
        return content[:i]
    if way == 1:
        del content[i : i + int(random.integers(1, 2000))]
        return content
    for k in random.integers(0, len(content), random.integers(1, 40)):
        content[k] = random.integers(256)
    return content


def same_phase(read, motion):
    """Whether two motions are made of the same numbers."""
    return all(np.array_equal(values, read.phase[name]) for name, values in motion.phase.items())


@pytest.mark.parametrize("name", ["in orbit", "two bodies"])
def test_files_that_are_not_whole_end_in_a_sentence_or_are_right(motions, name, tmp_path, rng):
    """Each under a name of its own: the library keeps what it failed to open."""
    good = Path(pt.save(motions[name], tmp_path / "good.nc")).read_bytes()
    refused = 0
    for k in range(60):
        path = tmp_path / f"{k}.nc"
        path.write_bytes(changed(good, rng))
        began = time.process_time()
        try:
            assert same_phase(pt.load(path), motions[name])
        except ValueError:
            refused += 1
        assert time.process_time() - began < 1
    assert refused > 40


@pytest.mark.parametrize("name", ["in orbit", "two bodies"])
def test_stores_that_are_not_whole_end_in_a_sentence_or_are_right(motions, name, tmp_path, rng):
    motion = motions[name]
    refused = 0
    for k in range(25):
        store = Path(pt.save(motion, tmp_path / f"{k}.zarr"))
        files = sorted(path for path in store.rglob("*") if path.is_file())
        path = files[rng.integers(len(files))]
        if rng.integers(2):
            path.unlink()
        else:
            path.write_bytes(changed(path.read_bytes(), rng))
        try:
            assert same_phase(pt.load(store), motion)
        except ValueError:
            refused += 1
    assert refused > 5


OBEYED = "\x1b[31m\x1b]0;owned\x07\x9b2J\r\x08\u202e"
"""A colour, the title of a window, control characters, and a mark that turns the writing."""


@pytest.mark.parametrize("name", ["in orbit", "two bodies"])
def test_no_text_of_a_file_moves_a_terminal(motions, name):
    """Whatever its attributes say, a motion shows itself, its system and its events in printable letters."""
    data = motions[name].dataset
    events = [{"name": f"a{OBEYED}", "message": f"a{OBEYED}", "terminal": False}]
    message = {key: f"{value}{OBEYED}" for key, value in data.attrs.items() if isinstance(value, str)}
    texts = []
    for key, value in (message | {"system": "", "events": json.dumps(events), "not_rerunnable": OBEYED}).items():
        try:
            motion = pt.load(data.assign_attrs({key: value}))
        except ValueError as error:
            texts.append(str(error))
        else:
            texts += map(repr, (motion, motion.system, *motion.events))
    assert sum(text.startswith("Trajectory") for text in texts) > 5
    assert [text for text in texts if not text.replace("\n", "").isprintable()] == []


def test_a_changed_number_is_noticed(motions, tmp_path):
    path = pt.save(motions["in orbit"], tmp_path / "it.nc")
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file["quaternion"][7, 2] = np.nextafter(file["quaternion"][7, 2], 1)
    with pytest.raises(ValueError, match="must have the numbers that were saved, got others: the digest differs"):
        pt.load(path)
