"""Attitude tables as motions to compare with."""

import dataclasses
import re

import numpy as np
import pytest

import poinsot as pt
from tumbling import BODY, CALENDAR, MOTION, START, TIMES

SYSTEM = pt.System(BODY)


def table(**fields):
    return pt.files.AttitudeTable(
        **{"times": TIMES, "quaternion": MOTION.quaternion, "omega_body": MOTION.omega_body} | fields
    )


def test_trajectory_with_rates_is_the_motion():
    read = table().trajectory(SYSTEM)
    np.testing.assert_allclose(read.conjugate_momenta, MOTION.conjugate_momenta, rtol=0, atol=1e-13)
    assert max(np.max(np.abs(drift)) for drift in read.drift.values()) < 1e-14
    assert (read.run.method, read.run.formulation) == ("table", "given rates")
    assert read.dataset["quaternion"].shape == (41, 4)
    assert "differentiated" not in repr(read)


def test_rates_from_attitudes_whatever_the_signs_of_the_quaternions(rng):
    signs = rng.choice([-1.0, 1.0], size=(41, 1))
    read = table(quaternion=signs * MOTION.quaternion, omega_body=None).trajectory(SYSTEM)
    np.testing.assert_allclose(read.omega_body, MOTION.omega_body, rtol=0, atol=4e-6)
    assert read.run.formulation == "differentiated attitudes"
    fine = np.linspace(0, 10, 401)
    read = pt.files.AttitudeTable(fine, MOTION(fine).quaternion).trajectory(SYSTEM)
    np.testing.assert_allclose(read.omega_body, SYSTEM.omega_body(MOTION(fine)), rtol=0, atol=1e-10)
    few = pt.files.AttitudeTable(fine[:4], MOTION(fine[:4]).quaternion).trajectory(SYSTEM)
    np.testing.assert_allclose(few.omega_body, SYSTEM.omega_body(MOTION(fine[:4])), rtol=0, atol=1e-5)
    with pytest.raises(ValueError, match=r"^a table without rates must have 4 rows or more, got 3\.$"):
        pt.files.AttitudeTable(fine[:3], MOTION(fine[:3]).quaternion).trajectory(SYSTEM)


def test_state_starts_the_same_motion():
    again = pt.free_motion(BODY, table().state(BODY, 7), TIMES)
    assert np.max(table().angle_to(again)) < 1e-13


def test_angles_to_a_motion_at_its_times_and_between_them():
    turned = pt.free_motion(BODY, BODY.state(START.quaternion, omega_body=(0.3, 0.4, 0.5001)), TIMES)
    expected = (MOTION.attitude.inv() * turned.attitude).magnitude()
    np.testing.assert_allclose(table().angle_to(turned), expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(table(quaternion=-MOTION.quaternion).angle_to(MOTION), 0, rtol=0, atol=1e-14)
    between = pt.files.AttitudeTable(TIMES[:-1] + 0.1, MOTION(TIMES[:-1] + 0.1).quaternion)
    assert np.max(between.angle_to(MOTION)) < 1e-14
    alone = table().trajectory(SYSTEM)
    assert np.max(table().angle_to(alone)) < 1e-13
    with pytest.raises(ValueError, match=r"^a trajectory must have dense output to be called"):
        between.angle_to(alone)


def test_calendars_and_frames_of_orbits_are_honoured():
    circle, times = (
        pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.0, inclination=1.0),
        np.linspace(0, 600, 31),
    )
    r, v = (np.stack(list(part(times)), axis=-1) for part in (circle.position_at, circle.velocity_at))
    orbit = pt.orbits.Ephemeris.from_table(
        circle.mu, times=times, positions=r, velocities=v, reference_frame="TEME", calendar=CALENDAR
    )
    system = pt.System(BODY, pt.GravityGradient(orbit))
    motion = table().trajectory(system)
    hours = pt.Calendar("2026-11-20T23:00:00", "TAI", "h")
    late = table(times=1 + TIMES / 3600, quaternion=motion.quaternion, omega_body=None, calendar=hours)
    assert np.max(late.angle_to(motion)) < 1e-14
    read = late.trajectory(system)
    np.testing.assert_allclose(read.times, TIMES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(read.omega_body, MOTION.omega_body, rtol=0, atol=4e-6)
    given = dataclasses.replace(late, omega_body=3600 * MOTION.omega_body)
    np.testing.assert_allclose(given.trajectory(system).omega_body, MOTION.omega_body, rtol=0, atol=1e-14)
    seconds = given.trajectory(pt.System(BODY, units={"time": "s"}))  # which has no calendar, but a unit
    np.testing.assert_allclose(seconds.times, 3600 + TIMES, rtol=1e-14)
    np.testing.assert_allclose(seconds.omega_body, MOTION.omega_body, rtol=0, atol=1e-14)
    np.testing.assert_allclose(given.trajectory(SYSTEM).omega_body, 3600 * MOTION.omega_body, rtol=1e-12)
    with pytest.raises(ValueError, match=r"^the table must be along the axes of the system, TEME, got ICRF\.$"):
        table(reference_frame="ICRF").angle_to(motion)


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"times": TIMES[::-1]}, r"^times must rise, got times\[1\] = 9\.75 after 10\.0\.$"),
        ({"times": []}, r"^times must"),
        ({"quaternion": 1.1 * MOTION.quaternion}, r"^quaternion must have unit norm, but \|q\| = 1\.1"),
        ({"quaternion": MOTION.quaternion[:3]}, r"^quaternion must have shape \(41, 4\)"),
        ({"omega_body": MOTION.quaternion}, r"^omega_body must have shape \(41, 3\)"),
        ({"times": np.full(41, np.nan)}, r"^times must be finite"),
        ({"calendar": "UTC"}, r"^calendar must be a Calendar, got str\.$"),
    ],
)
def test_bad_tables(fields, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        table(**fields)


def test_bad_systems_and_motions():
    with pytest.raises(TypeError, match=r"^system must be a System, got ObliqueBody\.$"):
        table().trajectory(BODY)
    many = pt.System(pt.Body(np.array([(1.0, 1.0, 1.0)] * 2)))
    with pytest.raises(ValueError, match=r"^system must be of one body, got 2 members\.$"):
        table().trajectory(many)
    with pytest.raises(TypeError, match=r"^motion must be a Trajectory"):
        table().angle_to(START)


def pair_motion():
    bodies = (pt.Body.from_ellipsoid(50.0, (1.0, 0.9, 0.7)), pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3)))
    pair = pt.TwoBodies(*bodies, G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity())
    return pt.propagate(system, pair.synchronous(distance=4.0, primary_rate=2.0), [0.0, 1.0])


WRITERS = {
    "aem": lambda motion: pt.files.write_aem(
        motion, "a.aem", calendar=pt.Calendar("2026-11-21T00:00:00", "TAI"), reference_frame="ICRF"
    ),
    "ck": lambda motion: pt.files.write_ck(
        motion, "a.bc", calendar=pt.Calendar("2026-11-21T00:00:00", "TDB"), reference_frame="ICRF", spacecraft=-1
    ),
    "quaternion csv": lambda motion: pt.files.write_quaternion_csv(motion, "a.csv"),
    "stk attitude": lambda motion: pt.files.write_stk_attitude(
        motion, "a.a", calendar=pt.Calendar("2026-11-21T00:00:00", "UTC"), reference_frame="ICRF"
    ),
}


@pytest.mark.parametrize("writer", WRITERS)
def test_a_motion_of_two_bodies_is_refused(writer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = "motion must be of one body, got two. Take motion.primary or motion.secondary."
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        WRITERS[writer](pair_motion())
    assert not list(tmp_path.iterdir())
