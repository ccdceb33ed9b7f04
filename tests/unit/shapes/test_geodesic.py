"""Geodesic spheres: Euler's formula, orientation, areas."""

import numpy as np
import pytest

from poinsot.shapes.geodesic import geodesic_sphere
from poinsot.shapes.winding import check_closed


@pytest.mark.parametrize(("faces", "parts"), [(20, 1), (1, 1), (100, 2), (320, 4), (1280, 8)])
def test_a_geodesic_sphere_is_closed_and_even(faces, parts):
    points, triangles = geodesic_sphere(faces)
    assert len(triangles) == 20 * parts**2
    assert len(points) == 10 * parts**2 + 2
    check_closed(triangles)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, rtol=1e-15, atol=0)
    first, second, third = np.moveaxis(points[triangles], 1, 0)
    vectors = 0.5 * np.cross(second - first, third - first)
    assert np.all(np.sum(vectors * (first + second + third), axis=1) > 0)
    areas = np.linalg.norm(vectors, axis=1)
    assert areas.max() < 2 * areas.min()
