"""Light on meshes: rays, whole faces by their centroids, and exactly lit areas."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import poinsot as pt
from poinsot.shapes import illumination
from poinsot.shapes.illumination import Lighting, ray_hits


def sphere_points(count):
    """Points about evenly on the unit sphere, and the triangles between them, anticlockwise seen from outside."""
    heights = 1 - (2 * np.arange(count) + 1) / count
    turns, across = np.pi * (3 - np.sqrt(5)) * np.arange(count), np.sqrt(1 - heights**2)
    points = np.stack([across * np.cos(turns), across * np.sin(turns), heights], axis=-1)
    faces = ConvexHull(points).simplices.astype(np.int64)
    inwards = np.linalg.det(points[faces]) < 0
    faces[inwards] = faces[inwards][:, [0, 2, 1]]
    return points, faces


def bumpy(count, depth=0.5):
    """A body with two hollows and a hump."""
    points, faces = sphere_points(count)
    centers, sizes = (
        np.array([(0.6, 0.0, 0.8), (-0.8, 0.6, 0.0), (0.0, -0.8, 0.6)]),
        depth * np.array([-1.3, -0.9, 1.0]),
    )
    radii = np.exp(np.exp(-6 * (1 - points @ centers.T)) @ sizes)
    return pt.shapes.Mesh(radii[:, None] * points, faces, density=1.0)


def random_directions(count, seed=1):
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def blocked(mesh, face, direction):
    """Whether another face is met, by solving for the place on the ray: no face is left out beforehand."""
    corners = mesh.vertices[mesh.faces]
    start, (a, b, c) = corners[face].mean(axis=0), np.moveaxis(np.delete(corners, face, axis=0), 1, 0)
    matrices = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=-1)
    u, v, t = np.linalg.solve(matrices, (start - a)[..., None])[..., 0].T
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-12)))


def test_faces_are_lit_where_no_other_face_is_met():
    mesh = bumpy(60, 0.8)
    normals, count = Lighting(mesh).normals, np.intp(0)
    for direction in random_directions(12):
        lit = pt.shapes.illuminated_faces(mesh, direction)
        facing = normals @ direction > 0
        assert list(lit) == [bool(facing[f]) and not blocked(mesh, f, direction) for f in range(len(lit))]
        assert np.array_equal(pt.shapes.illuminated_faces(mesh, direction, shadows=False), facing)
        count += np.count_nonzero(facing & ~lit)
    assert count > 10


def test_lit_areas_cover_the_silhouette_once():
    """Of rays at the nodes of a grid each that meets the body comes to one lit place."""
    mesh = bumpy(40, 0.9)
    light, corners = Lighting(mesh), mesh.vertices[mesh.faces]
    shaded = 0.0
    for direction in random_directions(8, seed=4):
        first = np.linalg.svd(direction[None])[2][1]
        flat = corners @ np.stack([first, np.cross(direction, first)], axis=-1)
        grid = np.linspace(-2.5, 2.5, 300)
        places = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
        met = np.zeros(len(places), dtype=bool)
        for a, b, c in flat[light.normals @ direction > 0]:
            left = np.array([(0, 1), (-1, 0)])  # of an edge: a quarter turn
            turns = [(places - p) @ ((q - p) @ left) >= 0 for p, q in ((a, b), (b, c), (c, a))]
            met |= np.all(turns, axis=0)
        silhouette = met.sum() * (grid[1] - grid[0]) ** 2
        areas = pt.shapes.illuminated_areas(mesh, direction)
        cosines = light.normals @ direction
        # The outline is near 8 long and crosses 500 cells; each is off by up to half, at random.
        assert abs(areas @ cosines - silhouette) < 5 * np.sqrt(500) / 2 * (grid[1] - grid[0]) ** 2
        assert np.all(areas <= light.areas * (1 + 1e-12))
        shaded += (light.areas - areas) @ np.maximum(cosines, 0)
    assert shaded > 0.05


def test_a_convex_body_has_no_shadows():
    points, faces = sphere_points(100)
    mesh, directions = pt.shapes.Mesh(points * (1.3, 1.0, 0.7), faces, mass=1.0), random_directions(20)
    lit = pt.shapes.illuminated_faces(mesh, directions)
    assert np.array_equal(lit, pt.shapes.illuminated_faces(mesh, directions, shadows=False))
    areas = pt.shapes.illuminated_areas(mesh, directions[0])
    np.testing.assert_allclose(areas, Lighting(mesh).areas * lit[0], rtol=0, atol=1e-15)


def test_a_ray_that_meets_an_edge_hits_both_its_triangles():
    square = np.array([(1.0, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)])
    halves = square[[[0, 1, 2], [0, 2, 3]]]
    for direction in ((1.0, 0, 0), (1.0, 0.3, 0.3), (1.0, 1, 1)):  # on the diagonal, and at its end
        assert ray_hits(np.array([direction] * 2), halves).all()
    assert not ray_hits(np.array([(-1.0, 0, 0)] * 2), halves).any()
    assert not ray_hits(np.array([(1.0, 1.0 + 1e-15, 0)] * 2), halves).any()


def test_no_ray_passes_between_triangles():
    points, faces = sphere_points(50)
    ends = points[faces] + np.array([0.2, -0.1, 0.3])
    for share in np.linspace(0, 1, 7):  # towards places on edges, to rounding
        for direction in (share * ends[:, 0] + (1 - share) * ends[:, 1]).reshape(-1, 3):
            assert ray_hits(np.broadcast_to(direction, (len(ends), 3)), ends).any()


def test_faces_inside_another_surface_are_dark():
    outside, inside = (pt.shapes.Mesh.from_box((side,) * 3, density=1.0) for side in (2.0, 1.0))
    vertices = np.concatenate([outside.vertices, inside.vertices])
    both = pt.shapes.Mesh(vertices, np.concatenate([outside.faces, inside.faces + 8]), density=1.0)
    direction = (0.3, 0.5, 0.8)
    assert list(np.flatnonzero(pt.shapes.illuminated_faces(both, direction)) >= 12) == [False] * 6
    np.testing.assert_allclose(pt.shapes.illuminated_areas(both, direction)[12:], 0, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("directions", "sentence"),
    [
        ((1, 0), r"directions must have shape \(\.\.\., 3\), got shape \(2,\)\."),
        ((0, 0, 0), "directions must not be zero"),
    ],
)
def test_directions_that_are_none_are_refused(directions, sentence):
    for call in (pt.shapes.illuminated_faces, pt.shapes.illuminated_areas):
        with pytest.raises(ValueError, match=f"^{sentence}"):
            call(pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0), directions)


def test_directions_of_any_length_and_number_are_the_same():
    mesh, directions = bumpy(30), random_directions(6)
    together = pt.shapes.illuminated_faces(mesh, 7 * directions.reshape(2, 3, 3))
    assert together.shape == (2, 3, len(mesh.faces))
    assert np.array_equal(together[1, 2], pt.shapes.illuminated_faces(mesh, directions[5]))
    areas = pt.shapes.illuminated_areas(mesh, 7 * directions.reshape(2, 3, 3))
    np.testing.assert_allclose(areas[0, 1], pt.shapes.illuminated_areas(mesh, directions[1]), rtol=1e-12)


def test_shadows_of_too_many_faces_are_refused(monkeypatch):
    monkeypatch.setattr(illumination, "MAX_SHADED", 11)
    box = pt.shapes.Mesh.from_box((1, 1, 1), mass=1.0)
    sentence = (
        r"^mesh must have at most 11 faces where shadows are computed, got 12\. Take a coarser one, or shadows=False\.$"
    )
    with pytest.raises(ValueError, match=sentence):
        pt.shapes.illuminated_faces(box, (1, 0, 0))
    assert pt.shapes.illuminated_faces(box, (1, 0, 0), shadows=False).sum() == 2
