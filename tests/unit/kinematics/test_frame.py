"""Moving axes: attitude and angular velocity."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.kinematics.frame import from_roll_pitch_yaw, roll_pitch_yaw

OMEGA = np.array([0.3, -0.2, 0.5])
START = Rotation.from_rotvec([0.2, 0.1, -0.4])
ORBITS = {
    "ellipse": pt.KeplerOrbit(
        2.0,
        semimajor_axis=1.5,
        eccentricity=0.6,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        true_anomaly=2.0,
        epoch=0.25,
    ),
    "circle": pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1),
    "equatorial": pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.3, argument_of_periapsis=0.5),
    "retrograde": pt.KeplerOrbit(
        2.0, semimajor_axis=1.5, eccentricity=0.3, inclination=3.0, node=0.2, argument_of_periapsis=0.5
    ),
}
FRAMES = {
    "rotating": pt.RotatingFrame(START, OMEGA, epoch=0.5),
    "at_rest": pt.RotatingFrame(START, (0, 0, 0)),
    **{name: orbit.frame for name, orbit in ORBITS.items()},
}


def test_rotating_frame_turns_about_its_rate():
    frame = pt.RotatingFrame(START, OMEGA, epoch=0.5)
    for time in (-2.0, 0.5, 0.5 + 1e-12, 7.0):
        expected = Rotation.from_rotvec(OMEGA * (time - 0.5)) * START
        assert (expected.inv() * frame.attitude(time)).magnitude() < 4e-15


def test_rotating_frame_at_its_epoch_is_the_given_attitude():
    q = -START.as_quat(scalar_first=True)
    assert pt.RotatingFrame(q, OMEGA, 3.0).quaternion(3.0).tolist() == q.tolist()


def test_rotating_frame_at_rest():
    frame = FRAMES["at_rest"]
    assert np.allclose(frame.quaternion(1e6), START.as_quat(scalar_first=True), rtol=0, atol=1e-16)


@pytest.mark.parametrize("name", FRAMES)
def test_frames_take_one_time_or_many(name):
    frame, times = FRAMES[name], np.linspace(-1, 3, 7)
    assert frame.quaternion(times).shape == (7, 4)
    assert frame.omega_space(times).shape == (7, 3)
    assert frame.quaternion(1.0).shape == (4,)
    assert frame.omega_space(1.0).shape == (3,)
    assert np.allclose(frame.quaternion(times)[3], frame.quaternion(1.0), rtol=0, atol=1e-15)
    assert len(frame.attitude(times)) == 7


@pytest.mark.parametrize("name", FRAMES)
def test_angular_velocity_is_the_derivative_of_the_attitude(name):
    frame, step = FRAMES[name], 1e-5
    for time in (-0.9, 0.4, 2.7):
        A = rotation_matrix(frame.quaternion(time))
        change = rotation_matrix(frame.quaternion(time + step)) - rotation_matrix(frame.quaternion(time - step))
        spin = change / (2 * step) @ A.T
        found = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / 2
        assert np.allclose(frame.omega_space(time), found, rtol=0, atol=3e-8)


@pytest.mark.parametrize("name", ORBITS)
def test_orbit_frame_axes_are_radial_transverse_normal(name):
    orbit = ORBITS[name]
    for time in (-0.9, 0.4, 2.7):
        r, v = np.array(orbit.position_at(time), dtype=float), np.array(orbit.velocity_at(time), dtype=float)
        radial, transverse, normal = rotation_matrix(orbit.frame.quaternion(time)).T
        h = np.cross(r, v)
        assert np.allclose(radial, r / np.linalg.norm(r), rtol=0, atol=1e-14)
        assert np.allclose(normal, h / np.linalg.norm(h), rtol=0, atol=1e-14)
        assert np.allclose(transverse, np.cross(normal, radial), rtol=0, atol=1e-14)
        assert transverse @ v > 0


@pytest.mark.parametrize("name", ORBITS)
def test_orbit_frame_turns_at_h_over_r_squared(name):
    orbit = ORBITS[name]
    h = np.sqrt(orbit.mu * orbit.semimajor_axis * (1 - orbit.eccentricity**2))
    for time in (-0.9, 0.4, 2.7):
        r = np.linalg.norm(np.array(orbit.position_at(time), dtype=float))
        assert np.allclose(orbit.frame.omega_space(time), h / r**2 * orbit.normal, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", FRAMES)
def test_values_relative_to_a_frame_go_in_and_come_out(name, body):
    frame, attitude, rate = FRAMES[name], Rotation.from_rotvec([0.7, -0.2, 1.1]), np.array([0.4, -0.3, 0.6])
    state = body.state(attitude, omega_body=rate, time=0.8, frame=frame)
    relative = pt.propagate(pt.System(body), state, [0.8, 1.0]).relative_to(frame)
    assert (attitude.inv() * relative.attitude[0]).magnitude() < 2e-15
    assert np.allclose(relative.omega_body[0], rate, rtol=0, atol=4e-15)
    assert relative.times.tolist() == [0.8, 1.0]


def test_rate_along_the_frames_axes_goes_in(body):
    frame, attitude = FRAMES["ellipse"], Rotation.from_rotvec([0.7, -0.2, 1.1])
    rate = np.array([0.4, -0.3, 0.6])
    state = body.state(attitude, omega_space=rate, time=0.8, frame=frame)
    relative = pt.propagate(pt.System(body), state, [0.8]).relative_to(frame)
    assert np.allclose(relative.attitude[0].apply(relative.omega_body[0]), rate, rtol=0, atol=2e-15)


def test_a_body_at_rest_in_a_rotating_frame_stays_there():
    frame = pt.RotatingFrame(START, (0, 0, 0.5))
    sphere = pt.Body((1.0, 1.0, 1.0))
    state = sphere.state(Rotation.from_rotvec([0.7, -0.2, 1.1]), omega_body=(0, 0, 0), frame=frame)
    relative = pt.propagate(pt.System(sphere), state, np.linspace(0, 20, 9)).relative_to(frame)
    assert np.max(np.abs(relative.omega_body)) < 1e-14
    assert np.max((relative.attitude[0].inv() * relative.attitude).magnitude()) < 1e-13


def test_a_users_frame_is_a_frame(body):
    class Accelerating(pt.mechanics.Frame):
        def quaternion(self, time):
            half = 0.25 * np.asarray(time, dtype=float) ** 2
            return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)

        def omega_space(self, time):
            time = np.asarray(time, dtype=float)
            return np.stack([0 * time, 0 * time, time], axis=-1)

    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), time=2.0, frame=Accelerating())
    assert np.allclose(body.omega(state.angular_momentum_body), [0, 0, 2.0], rtol=0, atol=1e-15)
    assert np.allclose(state.attitude.apply([1, 0, 0]), [np.cos(2.0), np.sin(2.0), 0], rtol=0, atol=1e-15)


def test_roll_pitch_and_yaw_are_turns_of_scipy(rng):
    """About axes forward, against the normal, and down; columns are these along radial, transverse, normal."""
    level = Rotation.from_matrix([(0, 0, -1), (1, 0, 0), (0, -1, 0)])
    angles = rng.uniform([-3, -1.5, -3], [3, 1.5, 3], (20, 3))
    attitude = level * Rotation.from_euler("ZYX", angles[:, ::-1])
    q = attitude.as_quat(scalar_first=True)
    assert np.max(np.abs(roll_pitch_yaw(q) - angles)) < 1e-13  # pitch is 0.07 from where roll and yaw are one
    assert (
        np.max((attitude.inv() * Rotation.from_quat(from_roll_pitch_yaw(angles), scalar_first=True)).magnitude())
        < 1e-15
    )


WRONG_VALUES = {
    "no value": (None, "must be real numbers, got NoneType None."),
    "text": ("x", "must be real numbers, got str 'x'."),
    "one number": (1.0, "must have shape {needed}, got shape ()."),
    "three components": (np.ones(3), "must have shape {needed}, got shape (3,)."),
    "five components": (np.ones(5), "must have shape {needed}, got shape (5,)."),
    "other times": (np.ones((3, 4)), "must have shape {needed}, got shape (3, 4)."),
}


@pytest.mark.parametrize("kind", WRONG_VALUES)
def test_a_users_frame_raises_an_error_for_values_of_another_shape(body, kind):
    value, words = WRONG_VALUES[kind]
    times = np.linspace(0.0, 1.0, 9)

    class Wrong(pt.mechanics.Frame):
        def quaternion(self, time):  # noqa: ARG002
            return value

        def omega_space(self, time):
            return np.broadcast_to((0.0, 0.0, 0.1), (*np.shape(time), 3))

    message = f"Wrong.quaternion(time) {words}"
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=OMEGA), times)
    one, several = "(4,) at times of shape ()", "(9, 4) at times of shape (9,)"
    calls = {
        several: [lambda: Wrong().attitude(times), lambda: motion.relative_to(Wrong()).quaternion],
        one: [lambda: body.state((1, 0, 0, 0), omega_body=OMEGA, frame=Wrong())],
    }
    for needed, each in calls.items() if kind != "other times" else [(several, calls[several])]:
        for call in each:
            with pytest.raises((TypeError, ValueError)) as caught:
                call()
            assert str(caught.value) == message.format(needed=needed)


def test_a_users_frame_raises_an_error_for_rates_of_another_shape(body):
    class Wrong(pt.mechanics.Frame):
        def quaternion(self, time):
            return np.broadcast_to((1.0, 0.0, 0.0, 0.0), (*np.shape(time), 4))

        def omega_space(self, time):  # noqa: ARG002
            return np.ones(4)

    with pytest.raises(
        ValueError, match=r"^Wrong\.omega_space\(time\) must have shape \(3,\) at times of shape \(\), "
    ):
        body.state((1, 0, 0, 0), omega_body=OMEGA, frame=Wrong())
