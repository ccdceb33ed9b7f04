"""Pictures against time: what they draw, in which units, of one motion and of ensembles."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.mechanics.frame import from_roll_pitch_yaw, roll_pitch_yaw

ORBIT = pt.KeplerOrbit(398600.4418, 7000.0, 0.1, 0.9, 0.3, 0.5, 0.2)
BODY = pt.Body((400.0, 500.0, 600.0))
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT), units={"time": "s", "inertia": "kg m2"})
TIMES = np.linspace(0, 6000, 61)
PLOTS = {
    "quaternions": pt.plot_quaternions,
    "euler": pt.plot_euler_angles,
    "level": lambda motion: pt.plot_roll_pitch_yaw(motion, ORBIT),
    "rates": pt.plot_rates,
    "momentum": pt.plot_angular_momentum,
    "drift": pt.plot_drift,
    "difference": lambda motion: pt.plot_difference(motion, motion),
}


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def motion():
    return pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001)), TIMES)


@pytest.fixture(scope="module")
def members():
    rates = np.linspace([0.001, 0.002, 0.001], [0.0011, 0.0021, 0.0012], 21)
    return pt.propagate(SYSTEM, BODY.state(np.tile([0.5, 0.5, 0.5, 0.5], (21, 1)), omega_body=rates), TIMES)


def curves(axes):
    return [line.get_ydata() for panel in np.atleast_1d(axes) for line in panel.lines]


def labels(axes):
    return [panel.get_ylabel() for panel in np.atleast_1d(axes)]


@pytest.mark.parametrize("name", PLOTS)
def test_units_and_names_are_on_the_axes(name, motion):
    axes = np.atleast_1d(PLOTS[name](motion))
    assert all(panel.get_xlabel() == "time [s]" for panel in axes)
    assert all(panel.get_ylabel() for panel in axes)
    assert all(panel.get_xlim() == (0, 6000) for panel in axes)
    if name != "difference":
        assert all(panel.get_legend() for panel in axes)


@pytest.mark.parametrize("name", PLOTS)
def test_an_ensemble_is_its_median_between_bands(name, members):
    axes = np.atleast_1d(PLOTS[name](members))
    assert all(len(panel.collections) == 2 * len(panel.lines) for panel in axes)


def test_medians_and_bands_are_those_of_the_members(members):
    axes = pt.plot_rates(members)
    assert np.allclose(curves(axes)[2], np.median(members.omega_body[..., 2], axis=0))
    wide, narrow = (path.get_paths()[0].get_extents() for path in axes[0].collections[:2])
    low, high = np.percentile(members.omega_body[..., 0], [5, 95], axis=0)
    assert (wide.y0, wide.y1) == pytest.approx((low.min(), high.max()))
    assert wide.y0 < narrow.y0 < narrow.y1 < wide.y1


def test_failed_members_are_left_out(members):
    import copy

    failed = copy.copy(members)
    failed.__dict__["_pair"] = (members.quaternion.copy(), members.conjugate_momenta.copy())
    failed._pair[0][3, 40:] = np.nan
    drawn = curves(pt.plot_quaternions(failed))[0]
    assert np.allclose(drawn, np.median(np.delete(members.quaternion, 3, axis=0)[..., 0], axis=0))


def test_components_are_those_of_the_motion(motion):
    expected = {
        pt.plot_quaternions: (motion.quaternion, motion.conjugate_momenta),
        pt.plot_rates: (motion.omega_body, motion.omega_space),
        pt.plot_angular_momentum: (motion.angular_momentum_body, motion.angular_momentum_space),
    }
    for plot, parts in expected.items():
        assert np.array_equal(np.array(curves(plot(motion))).T, np.concatenate(parts, axis=-1))


@pytest.mark.parametrize("degrees", [True, False])
def test_angles_do_not_jump_and_come_back_to_the_attitude(motion, degrees):
    axes = pt.plot_euler_angles(motion, "321", degrees=degrees)
    angles = np.array(curves(axes)).T
    assert labels(axes) == [f"Euler angles 3-2-1 [{'deg' if degrees else 'rad'}]"]
    assert np.max(np.abs(np.diff(angles, axis=0))) < (180 if degrees else np.pi)
    back = Rotation.from_euler("ZYX", angles, degrees=degrees)
    assert np.max((back.inv() * motion.attitude).magnitude()) < 1e-14


def test_roll_pitch_yaw_by_hand(motion):
    """Axes forward, against the normal, down, from position and velocity; SciPy's own angles."""
    r, v = (np.stack(list(part(TIMES)), axis=-1) for part in (ORBIT.position_at, ORBIT.velocity_at))
    down = -r / np.linalg.norm(r, axis=-1, keepdims=True)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v), axis=-1, keepdims=True)
    level = np.stack([np.cross(-normal, down), -normal, down], axis=-1)
    assert np.all(np.sum(level[..., 0] * v, axis=-1) > 0)
    expected = (Rotation.from_matrix(level).inv() * motion.attitude).as_euler("ZYX")[:, ::-1]
    found = motion.relative_to(ORBIT.frame).roll_pitch_yaw
    assert np.max(np.abs(np.sin(0.5 * (found - expected)))) < 1e-13
    assert np.max(np.abs(found)) <= np.pi
    drawn = np.array(curves(pt.plot_roll_pitch_yaw(motion, ORBIT))).T
    assert np.allclose(np.sin(np.radians(drawn)), np.sin(expected), atol=1e-12)


def test_attitudes_from_roll_pitch_yaw_are_theirs(rng):
    angles = rng.uniform(-1, 1, (50, 3)) * (np.pi, 1.5, np.pi)
    assert np.allclose(roll_pitch_yaw(from_roll_pitch_yaw(angles)), angles, atol=1e-14)
    down = Rotation.from_quat(from_roll_pitch_yaw((0, 0, 0)), scalar_first=True).apply((0, 0, 1))
    assert np.allclose(down, (-1, 0, 0), atol=1e-15)


def test_drifts_are_on_a_log_axis():
    free = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), TIMES)
    panel = pt.plot_drift(free)
    assert panel.get_yscale() == "log"
    names = [text.get_text() for text in panel.get_legend().get_texts()]
    assert names == ["$|q| - 1$", "$H$", "$G1$", "$G2$", "$G3$"]
    assert np.allclose(curves(panel)[1], np.maximum(np.abs(free.drift["energy"]), 1e-17))


def test_difference_is_the_angle_between_attitudes(motion):
    turned = pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.00101)), TIMES)
    drawn = curves(pt.plot_difference(motion, turned, degrees=True))[0]
    expected = np.degrees((motion.attitude.inv() * turned.attitude).magnitude())
    assert np.allclose(drawn[1:], expected[1:], rtol=1e-9)


def test_bad_input(motion):
    other = pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001)), TIMES[:9])
    with pytest.raises(
        ValueError, match=r"other must have the times of motion, but 9 times from 0 to 800 and 61 times"
    ):
        pt.plot_difference(motion, other)
    with pytest.raises(TypeError, match=r"orbit must be an Orbit, but OrbitFrame came"):
        pt.plot_roll_pitch_yaw(motion, ORBIT.frame)
    for plot in PLOTS.values():
        with pytest.raises(TypeError, match=r"motion must be a Trajectory, but State came"):
            plot(motion.initial)
