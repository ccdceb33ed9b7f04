"""The dataset of a motion has the numbers that its properties have, in whatever blocks of rows they are computed."""

import numpy as np
import pytest

import poinsot as pt
from kinds.forces_in_files import FIRST, OF_ONE, OF_TWO, PAIR, RUN, label
from kinds.parts import BODY, PARTS
from poinsot.kinematics.state import state_of
from poinsot.propagation import column_reader
from poinsot.propagation.column_reader import MotionRows

ROWS = 101
RANDOM = np.random.default_rng(7)
TIMES = np.linspace(0.0, 40.0, ROWS)
QUATERNIONS = [q / np.linalg.norm(q, axis=-1, keepdims=True) for q in RANDOM.normal(size=(2, ROWS, 4))]
VECTORS = RANDOM.normal(size=(4, ROWS, 3))


@pytest.fixture(autouse=True)
def any_body(monkeypatch):
    """It is not asked whether the body of a force is the one that turns."""
    for force in OF_ONE:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


def motion_of(system, rows):
    """Return a motion through states that nothing has computed."""
    start = state_of({name: values[0] for name, values in rows.phase.items()}, TIMES[0])
    return pt.Trajectory(system, start, TIMES, MotionRows(rows.phase), RUN)


def assert_blocks_are_joined(motion, monkeypatch):
    whole = motion.dataset
    for name in motion.variable_names:
        if not name.startswith("drift_"):
            assert np.array_equal(whole[name].values, motion.column(name), equal_nan=True), name
    for rows in (40, 7):
        monkeypatch.setattr(column_reader, "ROWS_PER_BLOCK", rows)
        assert motion.dataset.identical(whole)
        assert all(np.array_equal(x, whole[f"drift_{name}"], equal_nan=True) for name, x in motion.drift.items())


@pytest.mark.parametrize("force", OF_ONE, ids=label)
def test_of_one_body(force, monkeypatch):
    system = pt.System(FIRST, force)
    own = {part.name: RANDOM.normal(size=(ROWS, part.size)) for part in system.parts if part.size}
    rows = system.state(QUATERNIONS[0], omega_body=VECTORS[0], time=TIMES, **own)
    assert_blocks_are_joined(motion_of(system, rows), monkeypatch)


@pytest.mark.parametrize("part", PARTS, ids=label)
def test_of_a_body_with_a_part(part, monkeypatch):
    system = pt.System(BODY, part)
    own = {each.name: 0.1 * RANDOM.normal(size=(ROWS, each.size)) for each in system.parts if each.size}
    rows = system.state(QUATERNIONS[0], omega_body=VECTORS[0], time=TIMES, **own)
    assert_blocks_are_joined(motion_of(system, rows), monkeypatch)


@pytest.mark.parametrize("force", OF_TWO, ids=label)
def test_of_two_bodies(force, monkeypatch):
    place = VECTORS[2] + np.array([5.0, 0, 0])
    rows = PAIR.state(place, VECTORS[3], QUATERNIONS, omega_body=list(VECTORS[:2]), time=TIMES)
    assert_blocks_are_joined(motion_of(pt.System(PAIR, force), rows), monkeypatch)


def test_of_an_ensemble_with_a_member_that_failed(monkeypatch):
    body = pt.Body([(1.0, 1.3, 1.6), (1.1, 1.3, 1.6)])
    system = pt.System(body, pt.UniformGravity([0.5, 0.7], (1.0, 0.2, -0.3)))
    motion = pt.propagate(system, body.state((1, 0, 0, 0), omega_body=VECTORS[0][:2]), TIMES)
    motion.phase["quaternion"].flags.writeable = True
    motion.phase["quaternion"][1, 60:] = np.nan
    assert_blocks_are_joined(motion, monkeypatch)


def test_an_orbit_is_where_it_is_for_all_times_together(monkeypatch):
    """The anomalies of all times are improved until the last one is exact, which another block need not have."""
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.97)
    system, times = pt.System(FIRST, pt.GravityGradient(orbit)), np.linspace(0.0, 90.0, 3001)
    start = system.body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.1, 0.2, 0.3))
    phase = {name: np.repeat(values[None], times.size, axis=0) for name, values in start.phase.items()}
    motion = pt.Trajectory(system, start, times, MotionRows(phase), RUN)
    monkeypatch.setattr(column_reader, "ROWS_PER_BLOCK", 100)
    assert np.array_equal(motion.dataset["potential_energy"], motion.potential_energy)
