"""Light and sight on meshes: rays, whole faces by their centroids, and exact clear areas with derivatives."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.shapes import visibility
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Neighbour, ray_hits
from poinsot.shapes.visibility import clear_faces, clear_parts


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
    """Return True if a ray meets another face, by solution for its parameter, with all faces."""
    corners = mesh.vertices[mesh.faces]
    start, (a, b, c) = corners[face].mean(axis=0), np.moveaxis(np.delete(corners, face, axis=0), 1, 0)
    matrices = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=-1)
    u, v, t = np.linalg.solve(matrices, (start - a)[..., None])[..., 0].T
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-12)))


def test_faces_are_lit_where_no_other_face_is_met():
    mesh = bumpy(60, 0.8)
    normals, count = Surface(mesh).normals, np.intp(0)
    for direction in random_directions(12):
        lit = pt.shapes.illuminated_faces(mesh, direction)
        facing = normals @ direction > 0
        assert list(lit) == [bool(facing[f]) and not blocked(mesh, f, direction) for f in range(len(lit))]
        assert np.array_equal(pt.shapes.illuminated_faces(mesh, direction, shadows=False), facing)
        count += np.count_nonzero(facing & ~lit)
    assert count > 10


def test_lit_areas_cover_the_silhouette_once():
    """Each ray from a node of a grid that meets the body ends at one illuminated place."""
    mesh = bumpy(40, 0.9)
    light, corners = Surface(mesh), mesh.vertices[mesh.faces]
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
    np.testing.assert_allclose(areas, Surface(mesh).areas * lit[0], rtol=0, atol=1e-15)


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
        ((1, 0), r"must have shape \(\.\.\., 3\), got shape \(2,\)\."),
        ((0, 0, 0), "must not be zero"),
    ],
)
def test_directions_that_are_none_are_refused(directions, sentence):
    box = pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0)
    for call in (pt.shapes.illuminated_faces, pt.shapes.illuminated_areas):
        with pytest.raises(ValueError, match=f"^directions {sentence}"):
            call(box, directions)
        with pytest.raises(ValueError, match=f"^to_observer {sentence}"):
            call(box, (1, 0, 0), to_observer=directions)


def test_directions_of_shapes_that_do_not_fit_are_refused():
    sentence = (
        r"^to_observer must have a shape that fits directions, got \(4, 3\) and \(2, 3\)\. "
        "Pass as many directions to the observer as to the light, or one\\.$"
    )
    for call in (pt.shapes.illuminated_faces, pt.shapes.illuminated_areas):
        with pytest.raises(ValueError, match=sentence):
            call(pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0), np.ones((2, 3)), to_observer=np.ones((4, 3)))


def test_directions_of_any_length_and_number_are_the_same():
    mesh, directions = bumpy(30), random_directions(6)
    together = pt.shapes.illuminated_faces(mesh, 7 * directions.reshape(2, 3, 3))
    assert together.shape == (2, 3, len(mesh.faces))
    assert np.array_equal(together[1, 2], pt.shapes.illuminated_faces(mesh, directions[5]))
    areas = pt.shapes.illuminated_areas(mesh, 7 * directions.reshape(2, 3, 3))
    np.testing.assert_allclose(areas[0, 1], pt.shapes.illuminated_areas(mesh, directions[1]), rtol=1e-12)


def rough(seed, count=22):
    """Return a mesh with random radii: most faces have shadows of several others."""
    points, faces = sphere_points(count)
    radii = np.exp(0.35 * np.random.default_rng(seed).normal(size=count))
    return pt.shapes.Mesh(radii[:, None] * points, faces, mass=1.0)


def boxes(*lows):
    """Return a mesh of equal boxes: edges are parallel to the axes, and boxes may touch or intersect."""
    box = pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), mass=1.0)
    vertices = np.concatenate([box.vertices + low for low in lows])
    return pt.shapes.Mesh(vertices, np.concatenate([box.faces + 8 * k for k in range(len(lows))]), mass=1.0)


def uncovered_area(triangle, shades):
    """Return the area of a triangle outside convex polygons, by the exact integral of the length across slabs.

    Between the heights of all corners and of all crossings of edges the uncovered length across is linear.
    """
    polygons = [triangle, *shades]
    starts = np.concatenate(polygons)
    spans = np.concatenate([np.roll(p, -1, axis=0) - p for p in polygons])
    turns = spans[:, None, 0] * spans[None, :, 1] - spans[:, None, 1] * spans[None, :, 0]
    away = starts[None] - starts[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (away[..., 0] * spans[None, :, 1] - away[..., 1] * spans[None, :, 0]) / turns
        crossings = (starts[:, None, 1] + share * spans[:, None, 1])[(share > 0) & (share < 1)]
    levels = np.concatenate([starts[:, 1], crossings])
    levels = np.unique(np.clip(levels, triangle[:, 1].min(), triangle[:, 1].max()))
    total = 0.0
    for y, height in zip((levels[1:] + levels[:-1]) / 2, np.diff(levels), strict=True):
        sections = []
        for polygon in polygons:
            here, there = polygon, np.roll(polygon, -1, axis=0)
            met = (here[:, 1] > y) != (there[:, 1] > y)
            here, there = here[met], there[met]
            x = here[:, 0] + (y - here[:, 1]) / (there[:, 1] - here[:, 1]) * (there[:, 0] - here[:, 0])
            sections.append((x.min(), x.max()) if len(x) else (np.inf, np.inf))
        reached, end = sections[0] if np.isfinite(sections[0][0]) else (0.0, 0.0)  # a slab as thin as rounding
        for first, last in sorted(sections[1:]):
            total += max(min(first, end) - reached, 0) * height
            reached = max(reached, min(last, end))
        total += max(end - reached, 0) * height
    return total


def above(corners, heights):
    """Return the part of a polygon with positive heights."""
    left = []
    for k in range(len(corners)):
        a, b = heights[k - 1], heights[k]
        if a * b < 0:
            left.append(corners[k - 1] + (corners[k] - corners[k - 1]) * a / (a - b))
        if b >= 0:
            left.append(corners[k])
    return np.array(left)


def areas_across_slabs(mesh, directions):
    """Return the areas of faces outside the shadows of all others along several directions."""
    normals, corners = np.nan_to_num(mesh.face_normals), mesh.vertices[mesh.faces]
    fronts = [normals @ d > 0 for d in directions]
    areas = np.zeros(len(normals))
    for f in np.flatnonzero(np.all(fronts, axis=0)):
        origin, n = corners[f, 0], normals[f]
        x = (corners[f, 1] - origin) / np.linalg.norm(corners[f, 1] - origin)
        along = np.stack([x, np.cross(n, x)], axis=-1)
        own, shades = (corners[f] - origin) @ along, []
        for d, front in zip(directions, fronts, strict=True):
            for k in np.flatnonzero(front):
                place = corners[k] - origin
                heights = place @ n
                heights[np.abs(heights) < 1e-12] = 0.0
                if k != f and heights.max() > 0:
                    place = above(place, heights)
                    shade = (place - np.outer(place @ n / (n @ d), d)) @ along
                    if np.all(shade.max(axis=0) > own.min(axis=0)) and np.all(shade.min(axis=0) < own.max(axis=0)):
                        shades.append(shade)
        areas[f] = uncovered_area(own, shades)
    return areas


PAIRS = list(zip(random_directions(6, 21), random_directions(6, 22), strict=True))
ALIGNED = [np.array(d) / np.linalg.norm(d) for d in ((1, 0, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (-1, 2, -3))]
ALIGNED_PAIRS = [(s, e) for s in ALIGNED for e in ALIGNED]
SHAPES = {
    "a rough body": (rough(1), PAIRS),
    "another rough body": (rough(3), PAIRS),
    "the observer at the Sun": (rough(2), [(s, s) for s, _ in PAIRS]),
    "boxes apart": (boxes((0, 0, 0), (2.0, 0, 0), (0, 4.0, 0)), PAIRS[:3] + ALIGNED_PAIRS),
    "boxes that touch": (boxes((0, 0, 0), (0.5, 0, 3.0)), PAIRS[:3] + ALIGNED_PAIRS),
    "boxes with edges in planes of faces": (
        boxes((-0.5, -1.0, -1.5), (-1.5, -1.5, -2.0), (-0.5, -1.0, -0.5), (0.5, -2.0, -1.5)),
        PAIRS[:3] + ALIGNED_PAIRS,
    ),
    "boxes that intersect": (boxes((0, 0, 0), (0.7, 0.9, 0.8), (-0.5, 1.2, 0.3)), PAIRS[:3] + ALIGNED_PAIRS),
}


@pytest.mark.parametrize("name", SHAPES)
def test_clear_areas_are_the_areas_across_slabs(name):
    """Rounding of a shadow grows as the inverse cosine of the direction, and light on the face falls as the cosine."""
    mesh, pairs = SHAPES[name]
    surface, shaded = Surface(mesh), 0
    for directions in pairs:
        areas = pt.shapes.illuminated_areas(mesh, directions[0], to_observer=directions[1])
        cosines = np.min([surface.normals @ d for d in directions], axis=0)
        expected = areas_across_slabs(mesh, directions)
        np.testing.assert_allclose(areas * cosines, expected * cosines, rtol=0, atol=1e-14 * surface.areas.max())
        shaded += int(np.count_nonzero((expected > 0) & (expected < 0.999 * surface.areas)))
    assert shaded > 3


def test_faces_are_clear_where_light_and_sight_come_to_the_centroid():
    mesh = bumpy(60, 0.8)
    s, e = random_directions(5, 3), random_directions(5, 4)
    together = pt.shapes.illuminated_faces(mesh, s, to_observer=e)
    assert np.array_equal(together, pt.shapes.illuminated_faces(mesh, s) & pt.shapes.illuminated_faces(mesh, e))
    assert pt.shapes.illuminated_faces(mesh, s, to_observer=e[0]).shape == together.shape


def test_blocks_of_epochs_do_not_matter(monkeypatch):
    mesh, s, e = bumpy(60, 0.8), random_directions(7, 3), random_directions(7, 4)
    surface, weights = Surface(mesh), np.random.default_rng(1).random((7, len(mesh.faces)))
    whole = clear_parts(surface, [s, e])
    monkeypatch.setattr(visibility, "BLOCK_FACES", 2 * len(mesh.faces))
    parts = clear_parts(surface, [s, e])
    np.testing.assert_allclose(parts.areas, whole.areas, rtol=0, atol=1e-15)
    np.testing.assert_allclose(parts.centers, whole.centers, rtol=0, atol=1e-13)
    for one, other in zip(parts.slopes(weights).directions, whole.slopes(weights).directions, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


def test_no_directions_have_no_areas():
    mesh, none = bumpy(30), np.zeros((0, 3))
    assert pt.shapes.illuminated_areas(mesh, none).shape == (0, len(mesh.faces))
    assert pt.shapes.illuminated_faces(mesh, none, to_observer=none).shape == (0, len(mesh.faces))
    assert clear_parts(Surface(mesh), [none, none]).slopes(np.zeros((0, len(mesh.faces)))).directions[0].shape == (0, 3)


def difference(function, step=1e-6):
    """Return the derivative of a function of three numbers at zero, by central differences."""
    return np.array([(function(h) - function(-h)) / (2 * step) for h in step * np.eye(3)])


@pytest.mark.parametrize("seed", range(4))
def test_slopes_are_differences_of_areas(seed):
    """The second derivative of an area jumps where a shadow passes a corner: such directions are rare."""
    mesh, rng = rough(seed), np.random.default_rng(seed)
    surface, weights = Surface(mesh), rng.random((1, len(mesh.faces)))
    s, e = random_directions(1, 30 + seed), random_directions(1, 40 + seed)

    def total(directions):
        return (clear_parts(surface, [d / np.linalg.norm(d) for d in directions]).areas * weights).sum()

    slopes = clear_parts(surface, [s, e]).slopes(weights).directions
    for k in range(2):
        expected = difference(lambda h, k=k: total([s + h * (k == 0), e + h * (k == 1)]))
        np.testing.assert_allclose(slopes[k][0], expected, rtol=0, atol=1e-8 * np.abs(expected).max() + 1e-9)
        assert abs(slopes[k][0] @ (s, e)[k][0]) <= 1e-12 * np.abs(expected).max()  # the length does not matter


def two_bodies(count=4):
    """Return two meshes, places of the second one, and directions along which one mesh is before the other.

    The matrices contain a stretch.
    """
    rng = np.random.default_rng(11)
    positions = 3.2 * random_directions(count, 12)
    matrices = Rotation.random(count, rng=5).as_matrix() * rng.uniform(0.8, 1.2, (count, 1, 3))
    s, e = (positions * rng.choice([-1, 1], (count, 1)) + 0.5 * random_directions(count, k) for k in (13, 14))
    return (rough(5), rough(6)), positions, matrices, [d / np.linalg.norm(d, axis=1, keepdims=True) for d in (s, e)]


def test_a_neighbour_hides_what_it_hides_as_a_part_of_one_mesh():
    (mesh, other), positions, matrices, directions = two_bodies()
    surface, neighbour = Surface(mesh), Neighbour(Surface(other), positions, matrices)
    areas = clear_parts(surface, directions, neighbour).areas
    clear, lost = clear_faces(surface, directions, neighbour), 0.0
    for k, (position, matrix) in enumerate(zip(positions, matrices, strict=True)):
        own = mesh.vertices - mesh.center_of_mass
        vertices = np.concatenate([own, (other.vertices - other.center_of_mass) @ matrix.T + position])
        one = Surface(pt.shapes.Mesh(vertices, np.concatenate([mesh.faces, other.faces + len(own)]), mass=1.0))
        units, count = [d[k : k + 1] for d in directions], len(mesh.faces)
        np.testing.assert_allclose(areas[k], clear_parts(one, units).areas[0, :count], rtol=0, atol=1e-13)
        assert np.array_equal(clear[k], clear_faces(one, units)[0, :count])
        lost += np.sum(clear_parts(surface, units).areas - areas[k])
    assert lost > 0.1


def test_slopes_of_a_neighbour_are_differences_of_areas():
    (mesh, other), positions, matrices, (s, e) = two_bodies()
    surface, shading = Surface(mesh), Surface(other)
    for k in range(len(s)):
        weights = np.random.default_rng(k).random((1, len(surface.areas)))
        given = [s[k], e[k], positions[k], *matrices[k].T]

        def parts(sun, observer, position, *columns):
            units = [(d / np.linalg.norm(d))[None] for d in (sun, observer)]
            return clear_parts(surface, units, Neighbour(shading, position[None], np.transpose(columns)[None]))

        found = parts(*given).slopes(weights)
        for i, slope in enumerate([*found.directions, found.position, *found.matrix.transpose(2, 0, 1)]):

            def total(h, i=i, given=given, weights=weights, parts=parts):
                return (parts(*(x + h * (i == j) for j, x in enumerate(given))).areas * weights).sum()

            expected = difference(total)
            np.testing.assert_allclose(slope[0], expected, rtol=0, atol=1e-7 * np.abs(expected).max() + 1e-9)


def test_bodies_side_by_side_have_the_shadows_of_each_alone():
    (mesh, other), *_ = two_bodies()
    surface, direction = Surface(mesh), np.array([(0, 0.6, 0.8)])
    neighbour = Neighbour(Surface(other), np.array([(9.0, 0, 0)]), np.eye(3)[None])
    alone = clear_parts(surface, [direction]).areas
    np.testing.assert_allclose(clear_parts(surface, [direction], neighbour).areas, alone, rtol=0, atol=1e-15)


def test_degenerate_triangles_are_harmless():
    """A vertex on an edge, and a triangle without area between the edge and the vertex, change no area."""
    mesh = boxes((0, 0, 0), (2.0, 0, 0))
    a, b = mesh.faces[4, :2]  # an edge of the first box
    middle = len(mesh.vertices)
    vertices = np.concatenate([mesh.vertices, [(mesh.vertices[a] + mesh.vertices[b]) / 2]])
    c = mesh.faces[4, 2]
    faces = np.concatenate([np.delete(mesh.faces, 4, axis=0), [(a, middle, c), (middle, b, c), (a, b, middle)]])
    split = pt.shapes.Mesh(vertices, faces, mass=1.0)
    assert np.sum(split.face_areas == 0) == 1
    for s, e in PAIRS + ALIGNED_PAIRS:
        areas = pt.shapes.illuminated_areas(mesh, s, to_observer=e)
        others = pt.shapes.illuminated_areas(split, s, to_observer=e)
        np.testing.assert_allclose(others[:23], np.delete(areas, 4), rtol=0, atol=1e-13)
        np.testing.assert_allclose(others[23:].sum(), areas[4], rtol=0, atol=1e-13)
        assert others[25] == 0
