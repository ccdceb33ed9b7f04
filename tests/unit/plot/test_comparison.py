"""Pictures of how far an attitude is from a reference."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.plot.comparison import median_attitude

BODY = pt.Body((400.0, 500.0, 600.0))
ORBIT = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1, inclination=0.9, node=0.3)
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT), units={"time": "s"})
START = BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001))
TIMES = np.linspace(0, 600, 31)


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def motion():
    return pt.propagate(SYSTEM, START, TIMES, dense=True)


def curves(panel):
    return np.array([line.get_ydata() for line in panel.lines])


def references(motion):
    turned = Rotation.from_rotvec(0.01 * np.stack([TIMES / 60, 0 * TIMES, 1 + 0 * TIMES], axis=-1))
    other = pt.propagate(SYSTEM, BODY.state(START.quaternion, omega_body=(0.001, 0.002, 0.0012)), TIMES)
    return {
        "motion": (other, other.attitude),
        "frame": (ORBIT.frame, ORBIT.frame.attitude(TIMES)),
        "attitude": ((0.6, 0.0, 0.0, 0.8), Rotation.from_quat((0.6, 0.0, 0.0, 0.8), scalar_first=True)),
        "table": (motion.attitude * turned, motion.attitude * turned),
    }


@pytest.mark.parametrize("kind", ["motion", "frame", "attitude", "table"])
def test_angle_and_rotation_vector_are_those_of_scipy(motion, kind):
    other, attitude = references(motion)[kind]
    angle, vector = pt.plot.attitude_error(motion, other, angle_unit="rad")
    turn = attitude.inv() * motion.attitude
    assert angle.get_ylabel() == "angle to the reference [rad]"
    np.testing.assert_allclose(curves(angle)[0], turn.magnitude(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(curves(vector), turn.as_rotvec().T, rtol=0, atol=1e-14)


def test_at_times_of_a_table_the_dense_output_is_compared(motion):
    others = TIMES[:-1] + 7.0
    table = pt.propagate(SYSTEM, motion(7.0), others)
    angle, _ = pt.plot.attitude_error(motion, table, angle_unit="rad", time_unit="s")
    assert np.array_equal(angle.lines[0].get_xdata(), others)
    assert np.max(curves(angle)) < 1e-13


def test_past_half_a_turn_the_vector_begins_anew(motion):
    """Every component at once, however small its own jump is."""
    turn = Rotation.from_rotvec(np.linspace(0, 6, 31)[:, None] * (0.6, 0.0, 0.8))
    reference = motion.attitude * turn.inv()
    _, vector = pt.plot.attitude_error(motion, reference, angle_unit="rad")
    drawn = curves(vector)
    gaps = np.isnan(drawn)
    assert np.array_equal(np.flatnonzero(gaps[0]), [16])
    assert np.all(gaps == gaps[0])
    assert np.nanmax(np.linalg.norm(drawn, axis=0)) < np.pi
    assert drawn[2, :16] == pytest.approx(0.8 * np.linspace(0, 6, 31)[:16], rel=0, abs=1e-14)


def test_an_ensemble_is_drawn_by_the_angle_to_its_median_attitude():
    """Members on both sides of the sphere, half of them with the other sign of q: the angle does not see it."""
    turns = 0.02 * np.linspace(-1, 1, 21)[:, None] * (0.0, 0.6, 0.8)
    attitudes = (START.attitude * Rotation.from_rotvec(turns)).as_quat(scalar_first=True)
    signed = attitudes * np.where(np.arange(21) % 2, -1, 1)[:, None]
    members = pt.propagate(SYSTEM, BODY.state(signed, omega_body=(0.0, 0.0, 0.0)), TIMES[:3])
    angle, _ = pt.plot.attitude_error(members, angle_unit="rad")
    assert angle.get_ylabel() == "angle to the median attitude [rad]"
    assert curves(angle)[0, 0] == pytest.approx(0.01, rel=1e-12, abs=0)  # the median of |-0.02 ... 0.02|
    edges = angle.collections[0].get_paths()[0].get_extents()
    assert edges.y1 == pytest.approx(0.02, rel=1e-2)
    q = curves(pt.plot.quaternions(members)[0])[:, 0]
    assert np.abs(q @ START.quaternion) == pytest.approx(1, abs=1e-3)


def test_the_median_attitude_does_not_follow_outliers():
    """Two of nine members far away move the mean, and hardly the attitude with the least sum of angles."""
    turns = np.zeros((9, 3))
    turns[:, 0] = [0, 0.001, -0.001, 0.002, -0.002, 0, 0, 1.0, 1.2]
    q = Rotation.from_rotvec(turns).as_quat(scalar_first=True)
    median = Rotation.from_quat(median_attitude(q[:, None]), scalar_first=True)
    assert np.max(median.magnitude()) < 0.003
    assert Rotation.from_rotvec(turns).mean().magnitude() > 0.1


def test_the_median_attitude_does_not_jump():
    times = np.linspace(0, 20, 201)
    members = [Rotation.from_rotvec(np.outer(rate * times, (0.0, 0.6, 0.8))) for rate in (0.99, 1.0, 1.01)]
    median = median_attitude(np.stack([each.as_quat(scalar_first=True) for each in members]))
    assert np.all(np.sum(median[1:] * median[:-1], axis=-1) > 0.99)
    assert np.max((Rotation.from_quat(median, scalar_first=True).inv() * members[1]).magnitude()) < 1e-3


def test_bad_references(motion):
    with pytest.raises(ValueError, match=r"^other must be given for one motion, got none\."):
        pt.plot.attitude_error(motion)
    with pytest.raises(ValueError, match=r"^other must have one attitude, or one for each of 31 times, got 2\."):
        pt.plot.attitude_error(motion, [(1, 0, 0, 0)] * 2)
    with pytest.raises(ValueError, match=r"^other must have unit norm"):
        pt.plot.attitude_error(motion, (1, 1, 0, 0))
