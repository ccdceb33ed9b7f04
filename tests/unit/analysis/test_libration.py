"""Yaw, pitch and roll of one of two bodies relative to their orbit."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

GRAVITY = pt.forces.MutualGravity()
BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
A, B, C = np.array([1.0, 1.05, 1.1]) * 1e-17
SMALL = pt.Body((A, B, C), mass=1e-9)
PAIR = pt.TwoBodies(BALL, SMALL, G=1.0)
N = np.sqrt(PAIR.mu / 64)


def start_with(yaw, pitch, roll, pair=PAIR, rate=(0, 0, 0)):
    """On a circle, the secondary's principal axes turned by three angles from radial, transverse, normal."""
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    return pair.state((4, 0, 0), (0, 4 * N, 0), [(1, 0, 0, 0), turn], omega_body=[(0, 0, 0), rate], frame="orbit")


def read(start, times, pair=PAIR, body="secondary"):
    motion: Any = pt.propagate(pt.System(pair, GRAVITY), start, times)
    return pt.analysis.librations(motion, body)


@pytest.mark.parametrize("turn", [np.eye(3), np.diag([1, -1, -1]), np.diag([-1, 1, -1]), np.diag([-1, -1, 1])])
def test_angles_are_those_of_the_start_whatever_the_names_of_the_ends(turn):
    start = start_with(0.3, -0.2, 0.1)
    ends = start.secondary.attitude * Rotation.from_matrix(turn)
    other = PAIR.state(
        start.position, (0, 4 * N, 0), [start.primary.attitude, ends], omega_body=[(0, 0, 0)] * 2, frame="orbit"
    )
    found = read(other, [0.0, 1.0])
    assert np.allclose([found.yaw[0], found.pitch[0], found.roll[0]], [0.3, -0.2, 0.1], rtol=0, atol=4e-15)
    axis = ends.as_matrix()[:, 0]
    assert found.misalignment[0] == pytest.approx(np.arccos(abs(axis[0])), abs=1e-14)


def test_axes_are_principal_and_sorted():
    """The same body with its axes renamed and turned librates in the same way."""
    turn = Rotation.from_euler("XYZ", [0.4, 0.5, 2.0])
    tensor = turn.as_matrix() @ np.diag([A, B, C]) @ turn.as_matrix().T
    pair = pt.TwoBodies(BALL, pt.Body.from_inertia(tensor, mass=1e-9), G=1.0)
    plain = start_with(0.3, -0.2, 0.1)
    attitudes = [plain.primary.attitude, plain.secondary.attitude * turn.inv()]
    start = pair.state((4, 0, 0), (0, 4 * N, 0), attitudes, omega_body=[(0, 0, 0)] * 2, frame="orbit")
    times = np.linspace(0, 100, 11)
    one, other = read(plain, times), read(start, times, pair)
    for name in ("yaw", "pitch", "roll"):
        assert np.allclose(getattr(one, name), getattr(other, name), rtol=0, atol=1e-12), name


def test_free_frequencies_of_a_small_secondary_on_a_circle():
    """In longitude n sqrt(3 (B - A) / C); across, the roots of the biquadratic equation of satellites."""
    x, y = (C - B) / A, (B - A) / C
    s = (C - A) / B  # of DeBra and Delp: l^4 - l^2 (1 + 3 s + x s) + 4 x s, in units of the mean motion
    across = np.sort(np.sqrt(np.roots([1, -(1 + 3 * s + x * s), 4 * x * s])))
    times = np.linspace(0, 120 * 2 * np.pi / N, 4096)
    found = read(start_with(1e-4, 1e-4, 2e-4), times)
    longitude = pt.analysis.frequencies(found.yaw, times, 1).frequencies / N
    # the squared amplitudes, 1e-8 to 4e-8, shift the frequencies
    assert abs(longitude[0] / np.sqrt(3 * y) - 1) < 1e-7
    lines = np.sort(pt.analysis.frequencies(found.roll, times, 2).frequencies / N)
    assert np.allclose(lines, across, rtol=1e-7, atol=0)
    assert found.amplitude == pytest.approx(1e-4, rel=1e-3)


def test_what_tumbles():
    times = np.linspace(0, 200, 401)
    assert not read(start_with(0.5, 0.0, 0.0), times).tumbles
    assert read(start_with(0.0, 0.0, 0.0, rate=(0, 0, 0.1)), times).tumbles  # circulates in the plane
    assert read(start_with(0.0, 0.0, 0.0, rate=(0.1, 0, 0)), times).tumbles  # rolls
    starts = PAIR.state(
        (4, 0, 0),
        (0, 4 * N, 0),
        [(1, 0, 0, 0)] * 2,
        omega_body=[(0, 0, 0), [(0, 0, 0), (0, 0, 0.1), (0.1, 0, 0)]],
        frame="orbit",
    )
    found = read(starts, times)
    assert found.yaw.shape == (3, 401)
    assert found.tumbles.tolist() == [False, True, True]


def test_the_primary_is_read_as_the_secondary():
    pair = pt.TwoBodies(SMALL, BALL, G=1.0)
    turn = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1])
    start = pair.state((4, 0, 0), (0, 4 * N, 0), [turn, (1, 0, 0, 0)], omega_body=[(0, 0, 0)] * 2, frame="orbit")
    times = np.linspace(0, 100, 11)
    found, other = read(start, times, pair, "primary"), read(start_with(0.3, 0.2, 0.1), times)
    assert np.allclose(found.yaw, other.yaw, rtol=0, atol=1e-13)
    with pytest.raises(ValueError, match="body must be 'primary' or 'secondary', got 'moon'"):
        read(start, times, pair, "moon")
