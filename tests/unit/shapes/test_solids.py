"""Ellipsoids, cylinders, mass points and assemblies."""

import numpy as np
import pytest

import poinsot as pt


def test_solids_have_the_moments_that_bodies_of_that_name_have():
    ellipsoid, cylinder = pt.shapes.Ellipsoid((1, 2, 3), density=2.0), pt.shapes.Cylinder(1.5, 4.0, mass=3.0)
    assert ellipsoid.mass == pytest.approx(16 * np.pi, rel=1e-15, abs=0)
    assert cylinder.volume == pytest.approx(9 * np.pi, rel=1e-15, abs=0)
    np.testing.assert_array_equal(ellipsoid.inertia, pt.Body.from_ellipsoid(ellipsoid.mass, (1, 2, 3)).inertia)
    np.testing.assert_array_equal(cylinder.inertia, pt.Body.from_cylinder(3.0, 1.5, 4.0).inertia)
    assert ellipsoid.circumscribing_radius == 3
    assert cylinder.circumscribing_radius == 2.5
    assert repr(ellipsoid) == "Ellipsoid([1.0, 2.0, 3.0], mass=50.2655)"
    assert repr(cylinder) == "Cylinder(1.5, 4, mass=3)"


def test_mass_points_are_those_of_the_body():
    masses, positions = [1.0, 2.0, 3.0], [(0, 0, 1), (1, 2, 0), (-1, 0, 0.5)]
    points = pt.shapes.Mascons(masses, positions)
    np.testing.assert_allclose(
        points.inertia, pt.Body.from_point_masses(masses, positions).inertia, rtol=1e-14, atol=1e-15
    )
    assert points.mass == 6
    assert repr(points) == "Mascons(3 points, mass=6)"
    assert pt.shapes.Mascons([2.0], [(1, 1, 1)]).inertia.tolist() == np.zeros((3, 3)).tolist()
    with pytest.raises(ValueError, match="points must not lie on an edge or a mass point"):
        points.potential(points.positions[1] - points.center_of_mass)


def test_two_half_boxes_are_a_box():
    half = pt.shapes.Mesh.from_box((1, 2, 1.5), mass=3.0)
    parts = pt.shapes.Assembly([half.moved((0, 0, 0.75)), half.moved((0, 0, -0.75))])
    whole = pt.shapes.Mesh.from_box((1, 2, 3), mass=6.0)
    np.testing.assert_allclose(parts.inertia, whole.inertia, rtol=1e-15)
    np.testing.assert_allclose(parts.field(8, 1.0).normalized, whole.field(8, 1.0).normalized, rtol=0, atol=1e-15)
    points = np.array([(0.7, 0.3, 0.2), (2, 2, 2.0)])
    np.testing.assert_allclose(parts.potential(points), whole.potential(points), rtol=1e-14)
    assert parts.circumscribing_radius >= whole.circumscribing_radius
    assert repr(parts).startswith("Assembly([Mesh(8 vertices")


def test_an_assembly_of_a_moved_sphere_has_the_theorem_of_steiner():
    ball = pt.shapes.Ellipsoid((1, 1, 1), mass=5.0)
    pair = pt.shapes.Assembly([ball.moved((0, 0, 2)), ball.moved((0, 0, -2))])
    across = 2 * (2 / 5 * 5 + 5 * 4)
    np.testing.assert_allclose(pair.inertia, np.diag([across, across, 4.0]), rtol=1e-15)
    field = pair.field(4, radius=2.0)  # spheres pull as their centres
    np.testing.assert_allclose(field.C[[2, 3, 4], 0], [1, 0, 1], rtol=0, atol=2e-15)


def test_spheres_of_different_mass_pull_as_their_centres():
    masses, places = np.array((1.0, 2.0, 5.0)), np.array([(0.0, 0, 3), (3, 0, 0), (-1, -2, 0)])
    balls = [pt.shapes.Ellipsoid((1, 1, 1), mass=m).moved(x) for m, x in zip(masses, places, strict=True)]
    pair, points = pt.shapes.Assembly(balls), np.array([(4.0, 1, 2), (-3, 3, -1), (0, 0, 0.5)])
    centres = pt.shapes.Mascons(masses, places)
    np.testing.assert_allclose(pair.potential(points), centres.potential(points), rtol=1e-15)
    np.testing.assert_allclose(pair.attraction(points), centres.attraction(points), rtol=1e-14)
    np.testing.assert_allclose(pair.field(6, 3.0).normalized, centres.field(6, 3.0).normalized, rtol=0, atol=1e-16)


def test_a_cylinder_near_its_surface_is_refused_and_one_next_to_it_is_not():
    cylinder = pt.shapes.Cylinder(1.0, 2.0, mass=1.0)
    with pytest.raises(ValueError, match="points must not lie on the surface of a cylinder, but one lies 1 from"):
        cylinder.potential((1.0, 0, 0.3))
    cylinder.potential([(1.01, 0, 0.3), (0.99, 0, 0.3), (0.5, 0, 1.0), (0.2, 0, 1e-12)])


def test_a_needle_and_a_disc_pull_as_their_mass_points():
    for solid in (pt.shapes.Cylinder(0.01, 2.0, mass=1.0), pt.shapes.Cylinder(1.0, 0.02, mass=1.0)):
        weights, places = solid._own_rule(80)
        points = np.array([(1.5, 2.0, 0.3), (3.0, -5.0, 4.0), (0.0, 0.0, 7.0)])
        mass_points = pt.shapes.Mascons(weights, places)
        np.testing.assert_allclose(solid.potential(points), mass_points.potential(points), rtol=2e-11)
        np.testing.assert_allclose(solid.attraction(points), mass_points.attraction(points), rtol=1e-12, atol=1e-13)


def test_bad_solids_are_refused():
    with pytest.raises(ValueError, match="semiaxes must be positive"):
        pt.shapes.Ellipsoid((1, 2, -3), mass=1)
    with pytest.raises(ValueError, match="radius must be positive"):
        pt.shapes.Cylinder(0, 1, mass=1)
    with pytest.raises(ValueError, match="height must be positive"):
        pt.shapes.Cylinder(1, 0, mass=1)
    with pytest.raises(ValueError, match="exactly one of mass, density"):
        pt.shapes.Ellipsoid((1, 2, 3))
    with pytest.raises(ValueError, match="masses must not be empty"):
        pt.shapes.Mascons([], np.empty((0, 3)))
    with pytest.raises(ValueError, match="masses must be positive"):
        pt.shapes.Mascons([1, -1], np.zeros((2, 3)))
    with pytest.raises(ValueError, match="parts must not be empty"):
        pt.shapes.Assembly([])
    with pytest.raises(TypeError, match="parts must be a list, each a Shape, got list"):
        pt.shapes.Assembly([pt.Body((1, 2, 3))])


@pytest.mark.parametrize("given", [{"mass": 1.0}, {"density": 1.0}], ids=["mass", "density"])
@pytest.mark.parametrize("size", [1e-200, 1e-120, 1e120, 1e200])
def test_sizes_whose_volume_overflows_or_vanishes_are_refused(size, given):
    cylinder, ellipsoid = pt.shapes.Cylinder, pt.shapes.Ellipsoid
    rule = r"^volume must be (finite, got volume = inf|positive, got 0\.0)\.$"
    with pytest.raises(ValueError, match=rule):
        cylinder(size, size, **given)
    with pytest.raises(ValueError, match=rule):
        ellipsoid((size, size, size), **given)


@pytest.mark.parametrize("semiaxes", [(1, 1, 1), (3, 2, 1), (1, 0.4, 0.35)])
def test_the_mesh_of_an_ellipsoid_has_its_mass_volume_and_place(semiaxes):
    """Moments differ by the square of the lengths of edges, and so by a number over the number of faces."""
    ellipsoid = pt.shapes.Ellipsoid(semiaxes, density=2.0).moved((0.3, -0.2, 1.0), (0.5, 0.5, -0.5, 0.5))
    errors = []
    for faces in (320, 1280):
        mesh = ellipsoid.mesh(faces)
        assert len(mesh.faces) == faces
        assert mesh.mass == ellipsoid.mass
        assert mesh.volume == pytest.approx(ellipsoid.volume, rel=1e-13, abs=0)
        np.testing.assert_allclose(mesh.center_of_mass, ellipsoid.center_of_mass, rtol=0, atol=1e-14)
        assert mesh.face_areas.max() < 2.5 * mesh.face_areas.min()
        errors.append(np.abs(np.linalg.eigvalsh(mesh.inertia) / np.linalg.eigvalsh(ellipsoid.inertia) - 1).max())
    assert errors[0] < 5 / 320
    assert errors[1] < 0.3 * errors[0]


def test_the_mesh_of_an_ellipsoid_has_at_least_twenty_faces():
    with pytest.raises(ValueError, match=r"faces must be at least 20, got 19\."):
        pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).mesh(19)
