"""The picture of the librations of one of two bodies."""

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

TIMES = np.linspace(0, 8, 161)


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


def motion_of(rate: Any) -> Any:
    first, second = pt.Body.from_ellipsoid(50.0, (1.0, 0.9, 0.7)), pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3))
    pair = pt.TwoBodies(first, second, G=1.0)
    attitudes = [(1, 0, 0, 0), (np.cos(0.1), np.sin(0.1), 0, 0)]
    rates = [np.broadcast_to((0, 0, 1.0), np.shape(rate)), rate]
    start = pair.state((4.0, 0, 0), (0, 3.3, 0.5), attitudes, omega_body=rates, frame="orbit")
    return pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, TIMES)


def test_angles_turn_the_axes_of_the_orbit_into_those_of_the_body():
    """The long axis is the first; axes of the orbit from position and velocity."""
    motion = motion_of((0.0, 0.0, 0.2))
    panel = pt.plot.librations(motion)
    assert panel.get_ylabel() == "librations of the secondary [deg]"
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["roll", "pitch", "yaw"]
    radial = motion.position / motion.distance[:, None]
    normal = np.cross(motion.position, motion.velocity)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    orbit = Rotation.from_matrix(np.stack([radial, np.cross(normal, radial), normal], axis=-1))
    drawn = Rotation.from_euler("ZYX", np.array([line.get_ydata() for line in panel.lines[::-1]]).T, degrees=True)
    found = orbit * drawn
    # Axes of a homogeneous ellipsoid may be turned by half a turn.
    turns = [Rotation.from_rotvec(np.pi * np.array(v)) for v in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
    assert min(np.max((motion.secondary.attitude.inv() * found * turn).magnitude()) for turn in turns) < 1e-12


def test_lines_are_broken_where_angles_begin_anew():
    yaw = pt.plot.librations(motion_of((0.0, 0.0, 0.2)), "primary").lines[2].get_ydata()
    jumps = np.abs(np.diff(yaw))
    assert np.nanmax(jumps) < 60
    assert np.any(np.isnan(yaw))


def test_an_ensemble_is_its_median_between_bands():
    panel = pt.plot.librations(motion_of(np.linspace((0, 0, -0.1), (0, 0, 0.1), 5)))
    assert (len(panel.lines), len(panel.collections)) == (3, 6)


def test_another_body_is_refused():
    with pytest.raises(ValueError, match=r"^body must be 'primary' or 'secondary', got 'moon'\.$"):
        pt.plot.librations(motion_of((0.0, 0.0, 0.2)), "moon")
