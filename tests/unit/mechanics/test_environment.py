"""The axes that follow an orbit which is given by the formulas of its position and its velocity."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions as fn

TILT = 0.4


class Circle(pt.Orbit):
    """A circle of radius 2 about an axis that is tilted by 0.4 about the first space axis."""

    mu: float
    rate: float

    def position_at(self, time):
        c, s = fn.cos(self.rate * time), fn.sin(self.rate * time)
        return fn.Vector((2 * c, 2 * np.cos(TILT) * s, 2 * np.sin(TILT) * s))

    def velocity_at(self, time):
        c, s = self.rate * fn.cos(self.rate * time), self.rate * fn.sin(self.rate * time)
        return fn.Vector((-2 * s, 2 * np.cos(TILT) * c, 2 * np.sin(TILT) * c))


class Wave(pt.Orbit):
    """A path that leaves the plane of its circle, so that its axes turn about the radius, too."""

    mu: float

    def position_at(self, time):
        return fn.Vector((fn.cos(time), fn.sin(time), 0.3 * fn.sin(2 * time)))

    def velocity_at(self, time):
        return fn.Vector((-fn.sin(time), fn.cos(time), 0.6 * fn.cos(2 * time)))


class Rest(pt.Orbit):
    """A position that stays."""

    mu: float

    def position_at(self, time):  # noqa: ARG002
        return fn.Vector((1.0, 0.2, 0.3))

    def velocity_at(self, time):  # noqa: ARG002
        return fn.Vector((0.0, 0.0, 0.0))


TIMES = np.linspace(-3.0, 5.0, 9)


def test_the_frame_of_a_circle_turns_at_its_rate_about_its_axis():
    frame, plane = Circle(1.0, 0.7).frame, Rotation.from_rotvec((TILT, 0, 0))
    expected = plane * Rotation.from_rotvec(np.multiply.outer(0.7 * TIMES, (0, 0, 1)))
    # Rounding: the angle 0.7 t, at most 3.5, in a few operations of 1e-16 each.
    assert np.max((frame.attitude(TIMES) * expected.inv()).magnitude()) < 1e-14
    omega = 0.7 * plane.apply((0, 0, 1))
    assert np.max(np.abs(frame.omega_space(TIMES) - omega)) < 1e-14
    assert frame.quaternion(0.5).shape == (4,)
    assert frame.omega_space(0.5).shape == (3,)


def test_the_frame_of_a_path_out_of_a_plane_turns_as_its_attitude_does():
    frame, h = Wave(1.0).frame, 1e-4
    turn = (frame.attitude(TIMES + h) * frame.attitude(TIMES - h).inv()).as_rotvec() / (2 * h)
    # The third derivative of the rotation vector, below 100 here, times h^2 / 6.
    assert np.max(np.abs(turn - frame.omega_space(TIMES))) < 2e-7
    matrix = frame.attitude(TIMES).as_matrix()
    position = np.stack(Wave(1.0).position_at(TIMES), axis=-1)
    normal = np.cross(position, np.stack(Wave(1.0).velocity_at(TIMES), axis=-1))
    for i, along in enumerate((position, np.cross(normal, position), normal)):
        unit = along / np.linalg.norm(along, axis=-1, keepdims=True)
        assert np.max(np.abs(matrix[..., i] - unit)) < 1e-14  # some tens of roundings


def test_a_motion_is_seen_from_the_frame_of_a_user_s_orbit():
    orbit, body = Circle(1.0, 0.7), pt.Body((1.0, 1.2, 1.5))
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, [0.0, 0.5])
    relative = motion.relative_to(orbit.frame)
    assert np.max(np.abs(relative.quaternion[0] - (1, 0, 0, 0))) < 1e-15
    assert np.max(np.abs(relative.omega_body[0])) < 1e-15


def test_a_position_that_stays_has_no_axes():
    message = "position and velocity must span a plane for axes of the orbit, got parallel ones."
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        Rest(1.0).frame.quaternion(0.0)
