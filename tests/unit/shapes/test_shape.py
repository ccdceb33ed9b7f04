"""What holds for every shape: how it moves, turns and scales, and what a body takes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt

TETRAHEDRON = np.array([(0.0, 0, 0), (1.5, 0.2, 0), (0.1, 1.2, -0.1), (0.3, 0.4, 1.1)])
OUTWARD = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])


def make(kind, scale=1.0):
    if kind == "mesh":
        return pt.shapes.Mesh(scale * TETRAHEDRON, OUTWARD, mass=2.0)
    if kind == "ellipsoid":
        return pt.shapes.Ellipsoid(scale * np.array((0.5, 1.0, 0.75)), mass=2.0)
    if kind == "cylinder":
        return pt.shapes.Cylinder(0.4 * scale, 1.3 * scale, mass=2.0)
    if kind == "mascons":
        return pt.shapes.Mascons([0.5, 1.25, 0.25], scale * np.array([(0.0, 0, 0), (0.5, 0, 1), (1.0, 2.0, 0)]))
    parts = [
        pt.shapes.Mesh.from_box(scale * np.array((1, 2, 0.5)), mass=1.0),
        pt.shapes.Ellipsoid(scale * np.array((0.3, 0.2, 0.4)), mass=0.6).moved(
            scale * np.array((0, 0, 1.0)), (0.5, 0.5, 0.5, 0.5)
        ),
        pt.shapes.Cylinder(0.2 * scale, scale, mass=0.4).moved(scale * np.array((1.5, 0, 0)), (0.6, 0, 0.8, 0)),
    ]
    return pt.shapes.Assembly(parts)


KINDS = ["mesh", "ellipsoid", "cylinder", "mascons", "assembly"]
every_kind = pytest.mark.parametrize("kind", KINDS)
coordinates = st.floats(-3, 3)
rotations = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(rng=np.random.default_rng(seed)))
FEW = settings(max_examples=10, deadline=None)


def close(a, b, tolerance=1e-13):
    np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * max(1e-300, np.max(np.abs(b))))


def away_from(shape, rng, count=8):
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return shape.circumscribing_radius * rng.uniform(1.3, 5, size=(count, 1)) * directions


@every_kind
@FEW
@given(position=st.tuples(coordinates, coordinates, coordinates), rotation=rotations)
def test_a_moved_shape_has_its_tensor_and_its_pull_turned(kind, position, rotation):
    shape = make(kind)
    moved, turn = shape.moved(position, rotation), rotation.as_matrix()
    assert moved.mass == pytest.approx(shape.mass, rel=1e-14, abs=0)
    np.testing.assert_allclose(moved.center_of_mass, turn @ shape.center_of_mass + position, rtol=0, atol=1e-14)
    close(moved.inertia, turn @ shape.inertia @ turn.T)
    assert moved.circumscribing_radius == pytest.approx(shape.circumscribing_radius, rel=1e-14, abs=0)
    points = away_from(shape, np.random.default_rng(1))
    close(moved.potential(points @ turn.T), shape.potential(points))
    close(moved.attraction(points @ turn.T), shape.attraction(points) @ turn.T)


@every_kind
@FEW
@given(position=st.tuples(coordinates, coordinates, coordinates))
def test_a_shift_leaves_the_field_alone(kind, position):
    field, shifted = make(kind).field(8).normalized, make(kind).moved(position).field(8).normalized
    close(shifted, field, 1e-14)


@every_kind
def test_a_quarter_turn_about_the_third_axis_turns_the_orders(kind):
    shape, turn = make(kind), Rotation.from_rotvec((0, 0, np.pi / 2))
    (C, S), (c, s) = shape.field(6).normalized, shape.moved(attitude=turn).field(6).normalized
    wave = (C + 1j * S) * 1j ** np.arange(7)
    close(c + 1j * s, wave, 1e-14)


@every_kind
@FEW
@given(scale=st.floats(1e-3, 1e3))
def test_lengths_scale(kind, scale):
    shape, scaled = make(kind), make(kind, scale)
    close(scaled.inertia, scale**2 * shape.inertia)
    close(scaled.field(5).C, shape.field(5).C, 1e-14)
    points = away_from(shape, np.random.default_rng(2))
    close(scaled.potential(scale * points), shape.potential(points) / scale)
    close(scaled.attraction(scale * points), shape.attraction(points) / scale**2)


@every_kind
def test_degree_two_of_the_field_is_the_inertia_and_lower_ones_are_those_of_the_centre(kind):
    shape = make(kind)
    field = shape.field(4)
    close(field.inertia_deviator, shape.inertia - np.trace(shape.inertia) / 3 * np.eye(3), 1e-14)
    assert field.C[0, 0] == 1
    assert not field.C[1].any()
    assert not field.S[1].any()
    assert field.mass == shape.mass
    assert field.radius == field.extent == shape.circumscribing_radius
    integrals = shape._multipoles(2, shape.center_of_mass, shape.circumscribing_radius)
    assert integrals[0, 0] == pytest.approx(shape.mass, rel=1e-14, abs=0)
    assert np.max(np.abs(integrals[1])) < 1e-15 * shape.mass


@every_kind
def test_a_field_refers_to_the_radius_that_is_asked_for(kind):
    shape = make(kind)
    one, other = shape.field(4, radius=1.0), shape.field(4, radius=2.0)
    close(other.C * 2.0 ** np.arange(5)[:, None], one.C, 1e-15)


@every_kind
def test_the_attraction_is_the_slope_of_the_potential(kind, rng):
    shape, step = make(kind), 1e-3
    for point in away_from(shape, rng, 4):
        steps = step * np.eye(3)
        values = {k: shape.potential(point + k * steps) for k in (-2, -1, 1, 2)}
        slopes = (8 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12 * step)
        close(shape.attraction(point), slopes, 1e-8)


@every_kind
def test_far_away_every_shape_pulls_by_its_tensor(kind):
    shape = make(kind)
    points = 12 * shape.circumscribing_radius * np.array([(0.6, 0, 0.8), (0, 1, 0), (0.48, 0.6, -0.64)])
    near = pt.shapes.Mascons(np.full(2, shape.mass / 2), [(0, 0, 0), (0, 0, 0)]).potential(points)
    spread = np.trace(shape.inertia) / 2
    towards = points / np.linalg.norm(points, axis=1, keepdims=True)
    about = np.einsum("ni,ij,nj->n", towards, shape.inertia, towards)
    second = (2 * spread - 3 * about) / 2 / np.linalg.norm(points, axis=1) ** 3  # MacCullagh's formula
    np.testing.assert_allclose(shape.potential(points), near + second, rtol=1.5 / 12**3)


@every_kind
def test_points_keep_their_shape(kind):
    shape, points = make(kind), np.full((2, 4, 3), 5.0)
    assert shape.potential(points).shape == (2, 4)
    assert shape.attraction(points).shape == (2, 4, 3)
    assert np.ndim(shape.potential((5.0, 5, 5))) == 0
    assert shape.attraction((5.0, 5, 5)).shape == (3,)
    assert shape.potential(np.empty((0, 3))).shape == (0,)


@every_kind
def test_in_principal_axes_the_tensor_is_diagonal_and_the_centre_at_the_origin(kind):
    shape = make(kind).moved((1, -2, 0.5), (0.8, 0.36, 0.48, 0))
    principal, axes = shape.in_principal_axes(), shape.principal_axes.as_matrix()
    np.testing.assert_allclose(principal.center_of_mass, 0, rtol=0, atol=1e-14)
    close(principal.inertia, np.diag(np.diag(principal.inertia)), 1e-14)
    close(axes @ principal.inertia @ axes.T, shape.inertia, 1e-14)
    assert type(principal) is type(shape)
    body = pt.Body.from_shape(principal)
    assert type(body) is pt.Body
    np.testing.assert_allclose(body.moments, np.diag(principal.inertia), rtol=1e-14)


@every_kind
def test_a_body_takes_the_tensor_and_keeps_the_shape(kind):
    shape = make(kind)
    body = pt.Body.from_shape(shape)
    close(body.inertia, shape.inertia, 1e-14)
    assert body.shape is shape
    assert pt.Body((1, 2, 3)).shape is None


def test_a_shape_is_neither_structure_nor_a_number_of_its_body():
    shape = make("ellipsoid")
    body, plain = pt.Body.from_shape(shape), pt.Body.from_ellipsoid(2.0, (0.5, 1.0, 0.75))
    assert body.structure == plain.structure
    np.testing.assert_array_equal(body.numbers, plain.numbers)
    other = pt.Body.from_shape(make("cylinder"))
    assert other.structure == body.structure


def test_a_body_of_something_else_is_refused():
    with pytest.raises(TypeError, match="shape must be a shape, such as a Mesh, got float"):
        pt.Body.from_shape(1.0)
    with pytest.raises(ValueError, match="moments must be positive"):
        pt.Body.from_shape(pt.shapes.Mascons([1, 1], [(0, 0, 1), (0, 0, -1)]))


@every_kind
def test_bad_arguments_are_refused_in_one_sentence(kind):
    shape = make(kind)
    with pytest.raises(ValueError, match="degree must be from 2 to 80, got 81"):
        shape.field(81)
    with pytest.raises(ValueError, match="degree must be from 2 to 80, got 1"):
        shape.field(1)
    with pytest.raises(ValueError, match="radius must be positive, got -1"):
        shape.field(2, radius=-1)
    with pytest.raises(ValueError, match=r"points must have shape \(\.\.\., 3\), got shape \(2,\)"):
        shape.potential((1, 2))
    with pytest.raises(ValueError, match="position must have shape"):
        shape.moved((1, 2))
    with pytest.raises(ValueError, match="attitude must have unit norm"):
        shape.moved(attitude=(1, 1, 0, 0))


def test_high_degrees_stay_finite():
    field = make("mesh").field(80)
    assert np.all(np.isfinite(field.C))
    assert np.max(np.abs(field.normalized)) <= 1


# ---------------------------------------------------------------------- support function


def surface_points(kind):
    """Points that contain the farthest ones along the directions of the test, to 1e-5."""
    angles = np.linspace(0, 2 * np.pi, 721)
    shape = make(kind)
    if kind == "mesh":
        return shape, shape.vertices - shape.center_of_mass
    if kind == "mascons":
        return shape, shape.positions - shape.center_of_mass
    if kind == "cylinder":
        rim = 0.4 * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        return shape, np.concatenate([np.column_stack([rim, np.full(721, z)]) for z in (-0.65, 0.65)])
    u, v = np.meshgrid(angles, angles[:361])
    return shape, np.stack([0.5 * np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), 0.75 * np.cos(v)], -1).reshape(-1, 3)


@pytest.mark.parametrize("kind", ["mesh", "mascons", "cylinder", "ellipsoid"])
def test_the_support_function_is_the_largest_component_of_a_point(kind, rng):
    shape, points = surface_points(kind)
    for direction in rng.normal(size=(6, 3)):
        largest = np.max(points @ direction)
        # Half a step of the angles, 0.25 degrees, shortens a distance by 1e-5 of it at most.
        assert largest == pytest.approx(float(shape.support(direction)), rel=3e-5, abs=0)
        assert largest <= float(shape.support(direction)) * (1 + 1e-14)


@every_kind
@FEW
@given(position=st.tuples(coordinates, coordinates, coordinates), rotation=rotations)
def test_the_support_function_turns_with_the_shape(kind, position, rotation):
    shape, direction = make(kind), np.array([0.3, -1.0, 0.7])
    turned = shape.moved(position, rotation).support(rotation.apply(direction))
    assert float(turned) == pytest.approx(float(shape.support(direction)), rel=1e-13, abs=0)
    assert float(shape.support(-2.0 * direction)) == pytest.approx(
        2 * float(shape.support(-direction)), rel=1e-15, abs=0
    )
    assert float(shape.support(direction)) <= shape.circumscribing_radius * np.linalg.norm(direction) * (1 + 1e-14)


def test_the_support_of_an_assembly_is_the_largest_of_its_parts():
    shape, direction = make("assembly"), np.array([1.0, 0.2, -0.4])
    parts = [float(p.support(direction)) + (p.center_of_mass - shape.center_of_mass) @ direction for p in shape.parts]
    assert float(shape.support(direction)) == pytest.approx(max(parts), rel=1e-15, abs=0)
    times = np.linspace(0, 1, 4)
    moving = [np.cos(times), np.sin(times), 0.3 * times]
    found = shape.support(moving)
    assert np.allclose(found, [float(shape.support(w)) for w in np.transpose(moving)], rtol=1e-15, atol=0)
