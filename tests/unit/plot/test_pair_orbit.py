"""The picture of the orbit of two bodies: where they are, how large, and how they stand."""

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

SIDES = (1.0, 0.8, 0.6)
TURNS = [Rotation.from_rotvec(v) for v in ([0.3, -0.2, 0.5], [-0.4, 0.7, 0.1])]
TIMES = np.linspace(0, 6, 121)


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


def motion_of(first, second, velocity=(0.2, 2.5, 1.0), units=None, count=None, times=TIMES) -> Any:
    pair = pt.TwoBodies(first, second, G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity(), units=units)
    velocity = np.broadcast_to(velocity, (*(() if count is None else (count,)), 3))
    start = pair.state((4.0, 1.0, 0.5), velocity, TURNS, omega_body=[(0.1, 0.2, 0.3), (0.3, -0.1, 0.5)])
    return pt.propagate(system, start, times)


BALL = pt.Body.from_ellipsoid(3.0, (0.5, 0.5, 0.5))
MADE = {
    "moments": pt.Body.from_inertia(
        TURNS[0].as_matrix() @ np.diag(pt.Body.from_ellipsoid(50.0, SIDES).moments) @ TURNS[0].as_matrix().T, mass=50.0
    ),
    "shape": pt.Body.from_shape(pt.shapes.Ellipsoid(SIDES, mass=50.0).moved((7.0, -3.0, 2.0), TURNS[0])),
}


def outlines(panel):
    return [patch.get_xy() for patch in panel.patches]


@pytest.mark.parametrize("made", MADE)
def test_the_path_and_an_outline_to_scale(made):
    """How far an ellipsoid reaches along any direction of the picture, |diag(sides) R^T d|."""
    motion = motion_of(MADE[made], BALL)
    panel = pt.plot.mutual_orbit(motion)
    r, v = motion.position[0], motion.velocity[0]
    right = r / np.linalg.norm(r)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    up = np.cross(normal, right)
    np.testing.assert_allclose(
        panel.lines[0].get_xydata(), motion.position @ np.stack([right, up], axis=-1), rtol=0, atol=1e-12
    )
    primary, secondary = outlines(panel)
    axes = motion.primary.attitude[-1] * TURNS[0]
    for angle in np.linspace(0, 2 * np.pi, 7):
        along = np.array([np.cos(angle), np.sin(angle)])
        direction = axes.inv().apply(along[0] * right + along[1] * up)
        assert np.max(primary @ along) == pytest.approx(np.linalg.norm(direction * SIDES), rel=2e-3)
        center = motion.position[-1] @ np.stack([right, up], axis=-1) @ along
        assert np.max(secondary @ along) - center == pytest.approx(0.5, rel=2e-3)
    assert panel.get_aspect() == 1


def test_every_part_of_a_shape_has_its_outline():
    parts = [
        pt.shapes.Cylinder(0.3, 2.0, mass=20.0),
        pt.shapes.Mesh.from_box((0.2, 0.4, 0.6), mass=20.0).moved((0.0, 1.0, 0.0)),
        pt.shapes.Mascons((5.0, 2.0, 3.0, 1.0), ((0, 0, 1.2), (1, 0, 1.4), (0, 1, 1.2), (0, 0, 1.6))),
    ]
    body = pt.Body.from_shape(pt.shapes.Assembly(parts))
    motion = motion_of(body, BALL)
    first, *others = outlines(pt.plot.mutual_orbit(motion))
    assert len(others) == 3
    right = motion.position[0] / np.linalg.norm(motion.position[0])
    direction = motion.primary.attitude[-1].inv().apply(right)
    reach = 0.3 * np.hypot(*direction[:2]) + abs(direction[2])
    center = -motion.primary.attitude[-1].apply(body.shape.center_of_mass) @ right
    assert np.max(first[:, 0]) == pytest.approx(center + reach, rel=2e-3)


def test_bodies_that_fall_together_and_points_in_a_row_are_drawn():
    row = pt.shapes.Mascons((1.0, 1.0), ((0, 0, 0), (1, 0, 0)))
    body = pt.Body.from_shape(pt.shapes.Assembly([row, pt.shapes.Ellipsoid(SIDES, mass=20.0)]))
    panel = pt.plot.mutual_orbit(motion_of(body, BALL, (0.0, 0.0, 0.0), times=np.linspace(0, 0.5, 5)))
    assert len(outlines(panel)[0]) == 3  # there and back
    assert np.asarray(panel.lines[0].get_xydata())[0] == pytest.approx((np.sqrt(17.25), 0), abs=1e-12)


def test_names_and_units_are_on_the_picture():
    units = {"time": "h", "inertia": "kg m2", "length": "m"}
    panel = pt.plot.mutual_orbit(motion_of(MADE["moments"], BALL, units=units), time_unit="min", title="Two")
    assert panel.get_ylabel() == "across it, in the plane of the orbit [m]"
    texts = [text.get_text() for text in panel.get_legend().get_texts()]
    assert texts == ["orbit of the secondary", "primary", "secondary at time 360 min"]
    assert panel.figure.get_suptitle() == "Two"


def test_an_ensemble_is_refused():
    sentence = r"^motion must be of one pair, got an ensemble of 3 members\. Take one: motion\.member\(0\)\.$"
    with pytest.raises(ValueError, match=sentence):
        pt.plot.mutual_orbit(motion_of(MADE["moments"], BALL, count=3))
