"""Brightness of meshes that a companion shadows and hides, and of degenerate triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.observables import Lambert, LommelSeeliger
from poinsot.shapes.brightness import Companion, brightness_of
from poinsot.taylor.graph import Graph, tangents
from unit.shapes.test_visibility import boxes, rough

SUN, OBSERVER = (0.3, -1.2, 0.8), (1.1, 0.4, 0.5)
MESH, OTHER = rough(1), rough(6)
POSITION, TURN = np.array([0.9, -3.4, 2.6]), Rotation.from_rotvec((0.4, 1.0, -0.3)).as_matrix()
LAWS = (Lambert(0.4), LommelSeeliger(0.2))
FACTORS = np.array([1.3, 0.7, 0.9])


def stretched(mesh, factors):
    """Return the mesh with its centre of mass at the origin and stretched coordinates."""
    return pt.shapes.Mesh((mesh.vertices - mesh.center_of_mass) * factors, mesh.faces, mass=1.0)


def test_a_stretched_companion_is_the_mesh_of_stretched_vertices():
    companions = [Companion(other, POSITION, TURN) for other in (OTHER, stretched(OTHER, FACTORS))]
    found = brightness_of(MESH, LAWS[1], SUN, OBSERVER, FACTORS, "exact", companions[0])
    expected = brightness_of(stretched(MESH, FACTORS), LAWS[1], SUN, OBSERVER, shadows="exact", companion=companions[1])
    assert found == pytest.approx(expected, rel=1e-12, abs=0)
    assert found < 0.95 * brightness_of(MESH, LAWS[1], SUN, OBSERVER, FACTORS, "exact")


def test_centroids_count_whole_faces():
    lit = pt.shapes.illuminated_faces(MESH, SUN, to_observer=OBSERVER)
    sun, observer = (np.array(d) / np.linalg.norm(d) for d in (SUN, OBSERVER))
    expected = 0.4 * MESH.face_areas[lit] @ ((MESH.face_normals @ sun) * (MESH.face_normals @ observer))[lit]
    found = brightness_of(MESH, LAWS[0], SUN, OBSERVER, shadows="centroids")
    assert found == pytest.approx(expected, rel=1e-13, abs=0)


def derivatives(value, place):
    """Return the derivatives of a graph and the differences of its value at the numbers of a place."""
    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(len(place))]
    slopes = [tangents([value(symbols)], {x: 1.0})[0] for x in symbols]
    found = np.array(graph.evaluated(slopes, dict(zip(symbols, place, strict=True))))
    expected = [(value(list(place + h)) - value(list(place - h))) / 2e-6 for h in 1e-6 * np.eye(len(place))]
    return found, np.array(expected)


def test_derivatives_by_the_place_of_a_companion_are_differences():
    place = np.array([*SUN, *OBSERVER, *FACTORS, *POSITION, *TURN.ravel()])

    def value(x):
        companion = Companion(OTHER, x[9:12], (x[12:15], x[15:18], x[18:]))
        return brightness_of(MESH, LAWS[1], x[:3], x[3:6], x[6:9], "exact", companion)

    found, expected = derivatives(value, place)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).max())
    assert np.abs(expected[9:]).max() > 1e-3


@pytest.mark.parametrize("shadows", ["exact", "centroids"])
def test_arrays_of_members_and_times_are_as_single_calls(shadows):
    rng = np.random.default_rng(1)
    sun, observer = rng.normal(size=(3, 4, 5)), rng.normal(size=(3, 4, 5))
    middle = rng.uniform(0.8, 1.2, (4, 1))
    heights = POSITION[1] + rng.uniform(0, 1, 5)
    companion = Companion(OTHER, [POSITION[0], heights, POSITION[2]], TURN)
    found = np.asarray(brightness_of(MESH, LAWS[1], sun, observer, (1.0, middle, 1.1), shadows, companion))
    assert found.shape == (4, 5)
    for k, n in np.ndindex(4, 5):
        own = Companion(OTHER, [POSITION[0], float(heights[n]), POSITION[2]], TURN)
        factors = (1.0, float(middle[k, 0]), 1.1)
        one = brightness_of(MESH, LAWS[1], sun[:, k, n], observer[:, k, n], factors, shadows, own)
        assert found[k, n] == pytest.approx(one, rel=1e-12, abs=1e-15)


def test_degenerate_triangles_have_no_brightness():
    box = boxes((0, 0, 0))
    a, b, c = box.faces[4]
    vertices = np.concatenate([box.vertices, [(box.vertices[a] + box.vertices[b]) / 2]])
    faces = np.concatenate([np.delete(box.faces, 4, axis=0), [(a, 8, c), (8, b, c), (a, b, 8)]])
    split = pt.shapes.Mesh(vertices, faces, mass=1.0)
    for shadows in (False, "exact", "centroids"):
        found = brightness_of(split, LAWS[1], SUN, OBSERVER, FACTORS, shadows)
        assert found == pytest.approx(brightness_of(box, LAWS[1], SUN, OBSERVER, FACTORS), rel=1e-13, abs=0)
        slopes, _ = derivatives(
            lambda x, shadows=shadows: brightness_of(split, LAWS[1], x[:3], OBSERVER, FACTORS, shadows), np.array(SUN)
        )
        assert np.all(np.isfinite(slopes))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from(["exact", "centroids"]))
def test_sun_and_observer_can_be_exchanged(seed, shadows):
    """The clear parts do not depend on the order of the directions, and the laws are reciprocal."""
    mesh, (sun, observer) = rough(seed, 14), np.random.default_rng(seed).normal(size=(2, 3))
    for law in LAWS:
        found = brightness_of(mesh, law, sun, observer, FACTORS, shadows)
        swapped = brightness_of(mesh, law, observer, sun, FACTORS, shadows)
        assert found == pytest.approx(swapped, rel=1e-12, abs=1e-15)
        assert -1e-15 <= found <= brightness_of(mesh, law, sun, observer, FACTORS) * (1 + 1e-12)
