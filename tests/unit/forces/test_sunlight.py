"""Torques of light on meshes through smooth fields, against sums over faces."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

import poinsot as pt
from unit.shapes.test_visibility import bumpy, random_directions, sphere_points

MESH = bumpy(150)


def summed(mesh, u, specular=0.0, diffuse=0.0, along=1.0):
    """The torque of light by a sum over faces, from the corners as they are."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    doubled = np.cross(b - a, c - a)
    areas = np.linalg.norm(doubled, axis=-1) / 2
    n = doubled / (2 * areas[:, None])
    cosines = (n @ u)[:, None]
    push = along * (1 - specular) * u + 2 * (diffuse / 3 + specular * cosines) * n
    force = -areas[:, None] * cosines * push
    lit = pt.shapes.illuminated_faces(mesh, u)
    return np.sum(lit[:, None] * np.cross((a + b + c) / 3 - mesh.center_of_mass, force), axis=0)


FIELDS = {
    "emission": (pt.forces.DirectionalTorque.of_emission(MESH, 8), {"diffuse": 1.0, "along": 0.0}),
    "stream": (
        pt.forces.DirectionalTorque.of_stream(MESH, 8, specular=0.3, diffuse=0.2),
        {"specular": 0.3, "diffuse": 0.2},
    ),
}


@pytest.mark.parametrize("kind", ["stream", pytest.param("emission", marks=pytest.mark.slow)])
def test_a_field_is_off_the_sum_over_faces_by_the_error_that_it_states(kind):
    field, shares = FIELDS[kind]
    directions = random_directions(300, seed=8)
    sums = np.array([summed(MESH, u, **shares) for u in directions])
    off = np.linalg.norm(np.stack(field.torque(directions.T), axis=-1) - sums, axis=-1)
    size = np.sqrt(np.mean(np.sum(sums**2, axis=-1)))
    assert 0.005 * size < field.rms_error < 0.05 * size
    # Both are samples of the same error, by some 300 and 400 directions.
    assert abs(np.sqrt(np.mean(off**2)) / field.rms_error - 1) < 0.2
    assert 0.5 * field.maximum_error < off.max() < 2 * field.maximum_error


def test_the_error_falls_with_the_degree():
    errors = [pt.forces.DirectionalTorque.of_emission(MESH, n).rms_error for n in (1, 2, 4, 8)]
    assert np.all(np.diff(errors) < 0)


def test_coefficients_are_those_of_normalised_harmonics():
    rows = np.arange(16.0) * [[1], [-2], [3]]
    field = pt.forces.DirectionalTorque(3, rows)
    direction = random_directions(1)[0]
    colatitude, longitude = np.arccos(direction[2]), np.arctan2(direction[1], direction[0])
    expected = 0.0
    for n in range(4):
        for m in range(-n, n + 1):
            value = np.sqrt(4 * np.pi) * (-1) ** m * sph_harm_y(n, abs(m), colatitude, longitude)
            real = value.real if m == 0 else np.sqrt(2) * (value.real if m > 0 else value.imag)
            expected += rows[0, n * n + n + m] * real
    np.testing.assert_allclose(list(field.torque(direction)), expected * np.array([1, -2, 3]), rtol=1e-13)


def test_a_box_feels_nothing():
    box = pt.shapes.Mesh.from_box((1, 2, 3), density=1.0).moved((0.3, 0.1, -0.2))
    for field in (
        pt.forces.DirectionalTorque.of_emission(box, 3),
        pt.forces.DirectionalTorque.of_stream(box, 3, specular=0.2),
    ):
        assert not field.coefficients.any()
        assert field.maximum_error < 1e-14


def test_the_torque_is_that_of_the_field_and_falls_with_the_square_of_the_distance():
    field = FIELDS["emission"][0]
    body = pt.Body.from_shape(MESH)
    torques = []
    for place in ((4.0, -1.0, 2.0), (8.0, -2.0, 4.0)):
        sun = pt.orbits.FixedPosition(1.0, position=place)
        system = pt.System(body, pt.forces.Yorp(sun, field, pressure=0.3, distance=2.0, sun_radius=0.1))
        turn = Rotation.from_rotvec((0.3, -0.8, 0.5))
        torques.append(system.torque_body(body.state(turn, omega_body=(0, 0, 1))))
        to_sun = turn.inv().apply(-np.array(place) / np.linalg.norm(place))
        expected = 0.3 * 4 / np.dot(place, place) * np.array(list(field.torque(to_sun)))
        np.testing.assert_allclose(torques[-1], expected, rtol=1e-13)
    np.testing.assert_allclose(torques[0], 4 * torques[1], rtol=1e-13)


def test_drag_on_a_mesh_is_that_on_its_facets():
    points, faces = sphere_points(40)
    lumpy = pt.shapes.Mesh(points * (1.4, 1.0, 0.8) * (1 + 0.2 * points[:, :1]), faces, density=1.0)
    field, body = pt.forces.DirectionalTorque.of_stream(lumpy, 12), pt.Body.from_shape(lumpy)
    air = pt.forces.ExponentialAtmosphere(0.3, 2.0, 0.5, omega_space=(0, 0, 0.1))
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.1, inclination=0.4)
    facets = pt.forces.Facets.from_mesh(lumpy, drag=1.7)
    torques = []
    for turn in Rotation.random(5, np.random.default_rng(2)):
        start = body.state(turn, omega_body=(0, 0, 1), time=0.3)
        smooth, exact = (
            pt.System(body, force).torque_body(start)
            for force in (pt.forces.MeshDrag(orbit, air, field, 1.7), pt.forces.AtmosphericDrag(orbit, air, facets))
        )
        speed = np.linalg.norm(orbit.velocity_at(0.3)) + 0.1 * 2.2
        pressure = 0.5 * 1.7 * air.reference_density * np.exp(0.4) * speed**2  # at most: the distance is above 1.8
        torques.append((smooth, exact))
        assert np.linalg.norm(smooth - exact) < 2 * pressure * field.maximum_error
    smooths, exacts = np.swapaxes(np.array(torques), 0, 1)
    assert np.linalg.norm(smooths - exacts) < 0.4 * np.linalg.norm(exacts)


def test_a_torque_from_a_mesh_is_that_of_its_field():
    sun = pt.orbits.FixedPosition(1.0, position=(4.0, -1.0, 2.0))
    made = pt.forces.Yorp.from_mesh(sun, MESH, 8, pressure=0.3, distance=2.0, sun_radius=0.1)
    assert np.array_equal(made.field.coefficients, FIELDS["emission"][0].coefficients)
    assert (made.pressure, made.distance) == (0.3, 2.0)
    dark = pt.forces.Yorp.from_mesh(sun, MESH, 8, shadows=False, sun_radius=0.1)
    assert np.max(np.abs(dark.field.coefficients - made.field.coefficients)) > 0.01 * np.max(dark.field.coefficients)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: pt.forces.DirectionalTorque(-1, np.ones((3, 0))), "degree must not be negative, got -1."),
        (lambda: pt.forces.DirectionalTorque.of_emission(MESH, 33), "degree must be from 0 to 32, got 33."),
        (
            lambda: pt.forces.DirectionalTorque(2, np.ones((3, 4))),
            r"coefficients must have shape \(3, 9\) or \(members, 3, 9\), got shape \(3, 4\).",
        ),
        (
            lambda: pt.forces.DirectionalTorque.of_stream(MESH, 2, specular=0.7, diffuse=0.4),
            "specular and diffuse must not be negative and at most 1 together, got 0.7 and 0.4. The rest is absorbed.",
        ),
    ],
)
def test_what_is_no_field_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        call()
