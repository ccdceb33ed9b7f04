"""Meshes: boxes, closed surfaces, hollows, and what is refused or repaired."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.shapes.winding import repaired

BOX = pt.shapes.Mesh.from_box((1, 2, 3), mass=6.0)


def joined(*meshes):
    """Vertices and faces of several meshes in one."""
    counts = np.cumsum([0] + [len(m.vertices) for m in meshes])
    return np.concatenate([m.vertices for m in meshes]), np.concatenate(
        [m.faces + n for m, n in zip(meshes, counts[:-1], strict=True)]
    )


def test_a_box_is_the_box_of_the_body():
    assert BOX.volume == 6
    np.testing.assert_allclose(BOX.inertia, pt.Body.from_box(6.0, (1, 2, 3)).inertia, rtol=1e-15)
    np.testing.assert_array_equal(BOX.center_of_mass, 0)
    assert BOX.circumscribing_radius == pytest.approx(np.sqrt(14) / 2, rel=1e-15, abs=0)
    assert type(pt.Body.from_shape(BOX)) is pt.Body
    assert repr(BOX) == "Mesh(8 vertices, 12 faces, mass=6)"


def test_a_regular_tetrahedron_has_three_equal_moments():
    vertices = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])  # edge sqrt(8)
    mesh = pt.shapes.Mesh(vertices, [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], density=1.5)
    assert mesh.volume == pytest.approx(8 / 3, rel=1e-15, abs=0)
    assert mesh.mass == pytest.approx(4, rel=1e-15, abs=0)
    np.testing.assert_allclose(mesh.inertia, 4 * 8 / 20 * np.eye(3), rtol=0, atol=1e-15)  # m edge^2 / 20


def test_a_mesh_far_from_its_origin_loses_only_what_its_vertices_lost():
    far = pt.shapes.Mesh(BOX.vertices + 2.0**20, BOX.faces, mass=6.0)  # whole and half numbers: no rounding there
    np.testing.assert_allclose(far.inertia, BOX.inertia, rtol=1e-14, atol=1e-14)
    np.testing.assert_array_equal(far.center_of_mass, np.full(3, 2.0**20))


def test_vertices_without_faces_do_not_count():
    mesh = pt.shapes.Mesh(np.vstack([BOX.vertices, (1e18, -1e17, 3e18)]), BOX.faces, mass=6.0)
    np.testing.assert_array_equal(mesh.inertia, BOX.inertia)
    assert mesh.circumscribing_radius == BOX.circumscribing_radius
    np.testing.assert_array_equal(mesh.field(4).C, BOX.field(4).C)
    assert pt.shapes.Mesh(mesh.vertices, BOX.faces[:, ::-1], mass=6.0, repair=True).volume == 6


def test_two_closed_surfaces_are_one_body_and_one_wound_inwards_is_a_hollow():
    apart = pt.shapes.Mesh(*joined(BOX, BOX.moved((0, 0, 4))), mass=12.0)
    pair = pt.shapes.Assembly([BOX, BOX.moved((0, 0, 4))])
    np.testing.assert_allclose(apart.inertia, pair.inertia, rtol=1e-14, atol=1e-13)
    cavity = pt.shapes.Mesh.from_box((0.5, 0.5, 0.5), density=1.0)
    vertices, faces = joined(BOX, cavity)
    faces[12:] = faces[12:, ::-1]
    hollow = pt.shapes.Mesh(vertices, faces, density=1.0)
    assert hollow.mass == pytest.approx(6 - 0.125, rel=1e-15, abs=0)
    np.testing.assert_allclose(hollow.inertia, BOX.inertia - cavity.inertia, rtol=1e-14, atol=1e-15)
    point = (0.1, 0.05, 0.2)
    assert hollow.potential(point) == pytest.approx(BOX.potential(point) - cavity.potential(point), rel=1e-13, abs=0)


def test_a_point_on_a_face_is_between_its_two_sides_and_one_on_an_edge_is_refused():
    on, near = BOX.potential((0.5, 0.2, 0.1)), BOX.potential([(0.5 + 1e-9, 0.2, 0.1), (0.5 - 1e-9, 0.2, 0.1)])
    np.testing.assert_allclose(near, on, rtol=1e-8)
    with pytest.raises(ValueError, match=r"points must not lie on an edge or a mass point, but \(0.5, 1, 0\) does"):
        BOX.potential([(5, 0, 0), (0.5, 1, 0)])
    with pytest.raises(ValueError, match="points must not lie on an edge"):
        BOX.attraction((0.5, 1, 1.5))


def test_slivers_and_faces_without_area_do_no_harm():
    vertices = np.vstack([BOX.vertices, (BOX.vertices[0] + BOX.vertices[1]) / 2])
    faces = BOX.faces.tolist()
    k = next(i for i, f in enumerate(faces) if {0, 1} <= set(f))
    while faces[k][:2] not in ([0, 1], [1, 0]):
        faces[k] = faces[k][1:] + faces[k][:1]
    a, b, c = faces[k]
    faces[k] = [a, 8, c]
    split = pt.shapes.Mesh(vertices, [*faces, [8, b, c], [a, b, 8]], mass=6.0)  # the last one is a line
    np.testing.assert_allclose(split.inertia, BOX.inertia, rtol=1e-14, atol=1e-14)
    points = np.array([(0.7, 0.3, 0.2), (2, 2, 2.0), (0.1, 0.2, 0.3)])
    np.testing.assert_allclose(split.potential(points), BOX.potential(points), rtol=1e-14)
    np.testing.assert_allclose(split.attraction(points), BOX.attraction(points), rtol=1e-13, atol=1e-13)


def test_the_rounding_far_away_grows_with_the_square_of_the_distance():
    for distance in (10.0, 100.0, 1000.0):
        point = distance * BOX.circumscribing_radius * np.array((0.6, 0.48, 0.64))
        second = BOX.field(2).inertia_deviator
        unit = np.array((0.6, 0.48, 0.64))
        r = np.linalg.norm(point)
        exact = 6 / r - 1.5 * unit @ second @ unit / r**3
        assert abs(BOX.potential(point) / exact - 1) < 0.5 / distance**4 + 5e-16 * distance**2


def test_open_and_disagreeing_and_inward_surfaces_are_refused():
    vertices, faces = BOX.vertices, BOX.faces
    with pytest.raises(ValueError, match="faces must close the surface, two at every edge, but 1 has the edge"):
        pt.shapes.Mesh(vertices, faces[1:], mass=1)
    with pytest.raises(ValueError, match="two at every edge, but 3 have the edge between"):
        pt.shapes.Mesh(vertices, np.vstack([faces, faces[:1]]), mass=1)
    turned = faces.copy()
    turned[3] = turned[3, ::-1]
    with pytest.raises(ValueError, match=r"faces must all be wound to the same side, but faces .* disagree"):
        pt.shapes.Mesh(vertices, turned, mass=1)
    with pytest.raises(ValueError, match="anticlockwise seen from outside, but they enclose the volume -6"):
        pt.shapes.Mesh(vertices, faces[:, ::-1], mass=1)
    with pytest.raises(ValueError, match="faces must enclose a volume, but they enclose none"):
        pt.shapes.Mesh(vertices * (1, 1, 0), faces, mass=1)
    with pytest.raises(ValueError, match="faces must enclose a volume, but they enclose none"):
        pt.shapes.Mesh(vertices @ np.array([(1, 2, 3), (0, 1, 1), (1, 3, 4)]), faces, mass=1)


def test_bad_arrays_are_refused():
    vertices, faces = BOX.vertices, BOX.faces
    with pytest.raises(ValueError, match="faces must name vertices from 0 to 7, got 8"):
        pt.shapes.Mesh(vertices, np.where(faces == 7, 8, faces), mass=1)
    with pytest.raises(ValueError, match="faces must name vertices from 0 to 7, got -1"):
        pt.shapes.Mesh(vertices, np.where(faces == 7, -1, faces), mass=1)
    with pytest.raises(ValueError, match="vertices must be finite"):
        pt.shapes.Mesh(np.where(vertices == 0.5, np.nan, vertices), faces, mass=1)
    with pytest.raises(TypeError, match="faces must be whole numbers, got float64"):
        pt.shapes.Mesh(vertices, faces.astype(float), mass=1)
    with pytest.raises(ValueError, match=r"faces must have shape \(n, 3\), got shape \(12, 2\)"):
        pt.shapes.Mesh(vertices, faces[:, :2], mass=1)
    with pytest.raises(ValueError, match="faces must not be empty"):
        pt.shapes.Mesh(vertices, np.empty((0, 3), dtype=int), mass=1)
    with pytest.raises(ValueError, match="face 12 names one twice"):
        pt.shapes.Mesh(vertices, np.vstack([faces, (0, 0, 1)]), mass=1)
    with pytest.raises(ValueError, match="a solid must have exactly one of mass, density, got none"):
        pt.shapes.Mesh(vertices, faces)
    with pytest.raises(ValueError, match="exactly one of mass, density, got mass and density"):
        pt.shapes.Mesh(vertices, faces, mass=1, density=1)
    with pytest.raises(ValueError, match="density must be positive"):
        pt.shapes.Mesh(vertices, faces, density=-1)
    with pytest.raises(ValueError, match="sides must be positive"):
        pt.shapes.Mesh.from_box((1, 2, 0), mass=1)


def test_a_surface_with_one_side_is_refused():
    heptahedron = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    heptahedron += [(1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)]  # the projective plane of six vertices
    with pytest.raises(ValueError, match="faces must have two sides, but the surface of face 0 has one"):
        repaired(np.random.default_rng(1).normal(size=(6, 3)), np.array(heptahedron))


def test_repair_turns_faces_and_drops_doubles_and_leaves_hollows(rng):
    vertices, faces = joined(BOX, pt.shapes.Mesh.from_box((0.5, 0.5, 0.5), mass=1.0), BOX.moved((5, 0, 0)))
    faces[12:24] = faces[12:24, ::-1]
    right = pt.shapes.Mesh(vertices, faces, mass=1.0)
    whole = pt.shapes.Mesh(vertices, faces[:, ::-1], mass=1.0, repair=True)
    assert whole.volume == right.volume
    messy = faces.copy()
    chosen = np.r_[rng.permutation(12)[:5], 24 + rng.permutation(12)[:7]]
    messy[chosen] = messy[chosen, ::-1]
    messy = np.vstack([messy, messy[3], messy[30, [1, 2, 0]], (4, 4, 5)])
    mended = pt.shapes.Mesh(vertices, messy, mass=1.0, repair=True)
    assert mended.volume == pytest.approx(right.volume, rel=1e-15, abs=0)
    assert len(mended.faces) == 36
    np.testing.assert_allclose(mended.inertia, right.inertia, rtol=1e-14, atol=1e-14)
    with pytest.raises(ValueError, match="faces must close the surface"):
        pt.shapes.Mesh(vertices, faces[1:], mass=1.0, repair=True)
    with pytest.raises(ValueError, match="faces must not be empty"):
        pt.shapes.Mesh(vertices, [(0, 0, 1)], mass=1.0, repair=True)


SMALL = pt.shapes.Mesh.from_box((0.5, 0.5, 0.5), density=1.0)
TINY = pt.shapes.Mesh.from_box((0.1, 0.1, 0.1), density=1.0)


def nested(*parts):
    """A mesh of boxes, each with the sign of its winding, as vertices and faces."""
    vertices, faces = joined(*(part for part, _ in parts))
    signs = np.repeat([sign for _, sign in parts], 12)
    return vertices, np.where((signs < 0)[:, None], faces[:, ::-1], faces)


WRONG = {
    "adjacent": (nested((BOX, 1), (SMALL.moved((2, 0, 0)), -1)), 6.125),
    "touching": (nested((BOX, 1), (SMALL.moved((0.75, 0, 0)), -1)), 6.125),
    "an overlapping lobe": (nested((BOX, 1), (SMALL.moved((0.6, 0, 0)), -1)), 6.125),
    "the larger of two": (nested((SMALL.moved((2, 0, 0)), 1), (BOX, -1)), 6.125),
    "one with a hollow": (nested((BOX.moved((9, 0, 0)), 1), (BOX, -1), (SMALL, 1)), 11.875),
    "a hollow in a hollow": (nested((BOX, 1), (SMALL, -1), (TINY, -1)), 5.876),
    "all, an island in a hollow": (nested((BOX, -1), (SMALL, 1), (TINY, -1)), 5.876),
}


@pytest.mark.parametrize(("mesh", "volume"), WRONG.values(), ids=WRONG)
def test_a_surface_wound_inwards_is_a_hollow_or_turned(mesh, volume):
    with pytest.raises(
        ValueError, match=r"must be anticlockwise seen from outside.* Pass repair=True to reverse (it|them)\.$"
    ):
        pt.shapes.Mesh(*mesh, density=1.0)
    right = pt.shapes.Mesh(*mesh, density=1.0, repair=True)
    assert right.mass == pytest.approx(volume, rel=1e-14, abs=0)
    turned = right.moved((3, -2, 1), (0.5, 0.1, -0.7, 0.5))  # is refused in no attitude
    assert turned.mass == right.mass
    np.testing.assert_array_equal(pt.shapes.Mesh(right.vertices, right.faces, mass=1.0, repair=True).faces, right.faces)


def test_the_sentence_names_a_face_of_the_surface_that_is_wound_inwards():
    with pytest.raises(
        ValueError,
        match="but the surface of face 12 is wound inwards and lies in no other surface",
    ):
        pt.shapes.Mesh(*WRONG["adjacent"][0], mass=1.0)


def test_a_flat_surface_next_to_a_body_has_no_side():
    sheet = np.array([(3, 0.1, 0.2), (4, 0.3, 0.7), (3.3, 1.1, 0.9)])
    faces = np.vstack([BOX.faces, [(8, 9, 10), (8, 10, 9)]])
    assert pt.shapes.Mesh(np.vstack([BOX.vertices, sheet]), faces, mass=1.0).volume == pytest.approx(
        6, rel=1e-15, abs=0
    )


def test_arrays_of_a_mesh_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        BOX.vertices[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        BOX.faces[0] = 0
