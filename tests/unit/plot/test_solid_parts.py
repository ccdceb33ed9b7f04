"""Surfaces of the drawn parts of a body."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.plot.solid_parts import MAX_BALLS, surfaces, triangles

SHAPES = {
    "ellipsoid": (pt.shapes.Ellipsoid((3.0, 2.0, 1.0), mass=1.0), (3.0, 2.0, 1.0)),
    "cylinder": (pt.shapes.Cylinder(2.0, 5.0, mass=1.0), (2.0, 2.0, 2.5)),
    "mesh": (pt.shapes.Mesh.from_box((2.0, 4.0, 6.0), mass=1.0), (1.0, 2.0, 3.0)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_extents(name):
    """The grids have points on the axes."""
    shape, semiaxes = SHAPES[name]
    body = pt.Body.from_shape(shape)
    for points in (np.concatenate(surfaces(body, 1.0)), triangles(body).reshape(-1, 3)):
        np.testing.assert_allclose(np.max(points, axis=0), semiaxes, rtol=1e-15)
        np.testing.assert_allclose(np.min(points, axis=0), np.negative(semiaxes), rtol=1e-15)


def test_triangles_point_outwards():
    for shape, _ in SHAPES.values():
        corners = triangles(pt.Body.from_shape(shape))
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.all(np.sum(normals * corners.mean(axis=1), axis=-1) > -1e-12)


def test_balls_of_the_heaviest_mass_points():
    random = np.random.default_rng(2)
    masses = random.uniform(1.0, 2.0, MAX_BALLS + 7)
    shape = pt.shapes.Mascons(masses, random.normal(size=(masses.size, 3)))
    corners = triangles(pt.Body.from_shape(shape))
    balls = corners.reshape(MAX_BALLS, -1, 3)
    heaviest = np.sort(np.argsort(masses)[-MAX_BALLS:])
    centres = 0.5 * (balls.max(axis=1) + balls.min(axis=1)) + shape.center_of_mass
    distances = np.linalg.norm(centres[:, None] - shape.positions[heaviest][None], axis=-1)
    assert np.max(np.min(distances, axis=0)) < 1e-2
    largest = np.max(balls.max(axis=1) - balls.min(axis=1)) / 2
    share = np.cbrt(masses.max() / masses.sum())
    assert largest == pytest.approx(0.6 * shape.circumscribing_radius * share, rel=1e-2, abs=0)
