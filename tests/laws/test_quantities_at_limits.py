"""The summary of a motion counts the times at which wheels and control laws are at their limits."""

import re

import numpy as np
import pytest

import poinsot as pt

BODY = pt.Body((10.0, 12.0, 8.0))
AXES = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1] / np.sqrt(3)])
LAW = pt.control.QuaternionFeedback(kp=0.6, kd=4.0, limit=0.05)
WHEELS = pt.parts.ReactionWheels(AXES, 1e-3, LAW, [0.02, 0.03, 1.0, 0.01], [60.0, 600.0, 900.0, 300.0])
CIRCLE = pt.KeplerOrbit(1e-4, semimajor_axis=1.0, eccentricity=0.0)
FIELD = pt.forces.TiltedDipole(
    pt.orbits.FixedPosition(1.0, position=(6871.2, 0, 0)),
    pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.0),
    *(-3e-5, 0.0, 0.0, 6371.2),
)
TIMES = np.linspace(0, 150, 301)


def run(force, rate=(0.001, 0.0, 0.03), **options):
    system = pt.System(BODY, force)
    return pt.propagate(system, system.state((0.8, 0.6, 0, 0), omega_body=rate), TIMES, progress=False, **options)


def counts(motion):
    """Entries of the summary about limits, by name."""
    rows = {name: text for name, text in motion.summary.items() if "_limit" in name}
    assert all(f"  {name}: {text}" in str(motion) for name, text in rows.items())
    assert all(motion.dataset.attrs[name] == text for name, text in rows.items())
    return {
        name: int(re.fullmatch(rf"(\d+) of {motion.quaternion[..., 0].size} times", rows[name])[1]) for name in rows
    }


def feedback(motion):
    q = motion.quaternion
    return -0.6 * q[..., 1:] * np.where(q[..., :1] < 0, -1, 1) - 4.0 * motion.omega_body


def orbit_pointing(motion):
    seen = motion.relative_to(CIRCLE.frame)
    q = seen.quaternion
    return -0.6 * q[..., 1:] * np.where(q[..., :1] < 0, -1, 1) - 4.0 * seen.omega_body


@pytest.mark.parametrize(
    ("law", "wanted"),
    [
        (LAW, feedback),
        (pt.control.OrbitPointing(kp=0.6, kd=4.0, limit=0.05, orbit=CIRCLE), orbit_pointing),
        (pt.control.RateDamping(2.0, limit=0.05), lambda motion: -2.0 * motion.omega_body),
    ],
    ids=lambda x: type(x).__name__,
)
def test_laws_of_torques(law, wanted):
    motion = run(law)
    expected = np.count_nonzero(np.any(np.abs(wanted(motion)) >= 0.05, axis=-1))
    (found,) = counts(motion).values()
    assert 0 < expected < TIMES.size
    assert found == expected


def test_a_law_without_a_limit_leaves_no_row():
    assert counts(run(pt.control.QuaternionFeedback(kp=0.6, kd=4.0))) == {}


def test_a_sampled_law_counts_the_torque_that_it_holds():
    motion = run(pt.control.Sampled(LAW, period=7.0))
    held = np.any(np.abs(motion.own["sampled"]) >= 0.05, axis=-1)
    now = np.any(np.abs(feedback(motion)) >= 0.05, axis=-1)
    assert counts(motion) == {"quaternion_feedback_at_limit": np.count_nonzero(held)}
    assert np.count_nonzero(held) != np.count_nonzero(now)


def test_magnetorquers():
    """The field is 3e-5 T (6371.2 km / 6871.2 km)^3 along the pole, and constant in space."""
    motion = run(pt.forces.BDot(1e5, FIELD, 0.1), rate=(0.03, 0.0, 0.05))
    field = motion.attitude.inv().apply((0, 0, 3e-5 * (6371.2 / 6871.2) ** 3))
    at = np.any(1e5 * np.abs(np.cross(field, motion.omega_body)) >= 0.1, axis=-1)
    assert 0 < np.count_nonzero(at) < TIMES.size
    assert counts(motion) == {"b_dot_at_limit": np.count_nonzero(at)}


def of_wheels(motion):
    """Torque and speed limits of each wheel, by a pseudo-inverse and the formula of the docstring."""
    p, omega = motion.own["reaction_wheels"], motion.omega_body
    speeds = (p / 1e-3 - omega @ AXES.T) / WHEELS.largest_speeds
    motors = -np.clip(feedback(motion), -0.05, 0.05) @ np.linalg.pinv(AXES.T).T
    full = np.asarray(WHEELS.largest_torques)
    limit = full * np.minimum(1, 20 * (1 - np.sign(motors) * speeds))
    short = np.abs(motors) >= limit
    return short & (limit >= full), short & (limit < full)


def expected_of_wheels(motion):
    rows = dict[str, int]()
    for kind, at in zip(("torque", "speed"), of_wheels(motion), strict=True):
        for wheel in range(4):
            rows[f"reaction_wheels_{wheel}_at_{kind}_limit"] = int(np.count_nonzero(at[..., wheel]))
    rows["quaternion_feedback_at_limit"] = int(np.count_nonzero(np.any(np.abs(feedback(motion)) >= 0.05, axis=-1)))
    return {name: count for name, count in rows.items() if count}


def test_wheels():
    motion = run(WHEELS)
    expected = expected_of_wheels(motion)
    assert any("speed" in name for name in expected)
    assert any("torque" in name for name in expected)
    assert counts(motion) == expected


def test_wheels_of_an_ensemble():
    ensemble = run(WHEELS, rate=[(0.001, 0.0, 0.03), (0.0, 0.0, 0.0), (0.02, 0.01, 0.0)])
    assert counts(ensemble) == expected_of_wheels(ensemble)
    alone = [counts(ensemble.member(i)) for i in range(3)]
    assert counts(ensemble) == {name: sum(rows.get(name, 0) for rows in alone) for name in counts(ensemble)}


def test_limits_of_members():
    motion = run(pt.control.RateDamping(2.0, limit=[0.05, 0.02]))
    at = np.any(np.abs(2.0 * motion.omega_body) >= np.array([0.05, 0.02])[:, None, None], axis=-1)
    assert counts(motion) == {"rate_damping_at_limit": np.count_nonzero(at)}


def test_a_saved_motion_has_the_rows(tmp_path):
    motion = run(WHEELS)
    loaded = pt.load(pt.save(motion, tmp_path / "wheels.nc"))
    assert counts(loaded) == counts(motion)
