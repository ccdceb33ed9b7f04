"""Tests of Doppler spectra against values with 50 digits and closed forms, and wrong arguments."""

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment
from poinsot.observables import DopplerBandwidth, DopplerEdges
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
CASES = json.loads((Path(__file__).parents[2] / "oracles" / "radar_cases.json").read_text())["doppler"]
BODY = pt.Body((1.25, 1.0, 0.75))
RADAR = pt.orbits.FixedPosition(1.0, position=(0.3, -2.0, 1.1))
BALL = pt.shapes.Ellipsoid((2.0, 2.0, 2.0), mass=1.0)


def at(q, omega):
    q = np.array(q) / np.linalg.norm(q)
    return pt.Instant(BODY, pt.Attitude.from_quaternion(q), Environment(0.0), omega)


@pytest.mark.parametrize("case", CASES)
def test_bandwidths_agree_with_digits(case):
    radar = pt.orbits.FixedPosition(1.0, position=-np.array(case["to_observer"]))
    instant = at(case["quaternion"], case["omega_body"])
    ellipsoid = pt.shapes.Ellipsoid(case["semi_axes"], mass=1.0)
    points = pt.shapes.Mascons(np.arange(1.0, 13.0), case["vertices"])
    for shape, expected in (
        (ellipsoid, case["bandwidth_of_ellipsoid"]),
        (points, case["bandwidth_of_vertices"]),
        (pt.shapes.Assembly([points, points]), case["bandwidth_of_vertices"]),
    ):
        found = DopplerBandwidth(shape, radar, case["wavelength"]).reading(instant)
        assert found == pytest.approx(expected, rel=16 * EPS, abs=0)


def test_edges_are_the_shifts_of_the_limbs_of_a_turned_and_moved_shape():
    """The box is compared with its eight corners, whose speed towards the radar is (omega x x) . e."""
    turn, q, omega = Rotation.from_rotvec([0.3, 0.2, -0.5]), np.array([0.5, -0.5, 0.1, 0.7]), np.array([0.3, -0.1, 0.9])
    box = pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), mass=1.0).moved((5.0, 1.0, 0.0), turn)
    lower, upper = DopplerEdges(box, RADAR, 0.1).reading(at(q, omega))
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-1.0, 1.0) for z in (-1.5, 1.5)])
    attitude = Rotation.from_quat(q / np.linalg.norm(q), scalar_first=True)
    e = attitude.inv().apply(-np.array([0.3, -2.0, 1.1]) / np.linalg.norm([0.3, -2.0, 1.1]))
    shifts = 20.0 * np.cross(omega, turn.apply(corners)) @ e
    assert np.allclose([lower, upper], [shifts.min(), shifts.max()], rtol=16 * EPS, atol=0)
    assert float(upper) > 0


def test_edges_of_a_body_that_is_no_mirror_image_of_itself_differ():
    """The upper edge is that of the vertex that approaches the radar fastest, from the centre of mass."""
    vertices, omega = np.array([(0.0, 0, 0), (1.5, 0.2, 0), (0.1, 1.2, -0.1), (0.3, 0.4, 1.1)]), (0.2, 0.3, 1.0)
    tetrahedron = pt.shapes.Mesh(vertices, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], mass=1.0)
    lower, upper = DopplerEdges(tetrahedron, RADAR, 0.1).reading(at((1, 0, 0, 0), omega))
    assert upper - lower == DopplerBandwidth(tetrahedron, RADAR, 0.1).reading(at((1, 0, 0, 0), omega))
    e = -np.array([0.3, -2.0, 1.1]) / np.linalg.norm([0.3, -2.0, 1.1])
    shifts = 20.0 * np.cross(omega, vertices - vertices.mean(axis=0)) @ e
    assert np.allclose([lower, upper], [shifts.min(), shifts.max()], rtol=16 * EPS, atol=0)
    assert abs(upper + lower) > 0.01 * (upper - lower)


def test_a_sphere_has_its_closed_form_at_any_time():
    """4 pi d cos(delta) / (lambda P), with the angle delta of the radar from the equator."""
    motion = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.25)), np.linspace(0, 9, 5))
    found = pt.observe(motion, DopplerBandwidth(BALL, RADAR, 0.035, light_time=False)).values
    cosine = np.hypot(0.3, 2.0) / np.linalg.norm([0.3, 2.0, 1.1])
    expected = 4 * np.pi * 4.0 * cosine / (0.035 * 2 * np.pi / 0.25)
    assert np.allclose(found, expected, rtol=1e-14, atol=0)


def test_members_have_radars_of_their_own():
    motion = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=[(0, 0, 0.2), (0.1, 1, 0)]), [0.0, 1.0])
    waves = np.array([0.035, 0.126])
    both = pt.observe(motion, DopplerEdges(BALL, RADAR, waves, light_time=False)).values
    for i in range(2):
        alone = pt.observe(motion.isel(member=i), DopplerEdges(BALL, RADAR, waves[i], light_time=False)).values
        assert np.allclose(both[i], alone, rtol=8 * EPS, atol=0)


@pytest.mark.parametrize("shape", ["ellipsoid", "mesh"])
def test_derivatives_by_the_angular_velocity_agree_with_digits(shape):
    omega, axes, graph = (0.3, -0.1, 0.9), (1.0, 2.0, 3.0), Graph()
    nodes = Vector(map(graph.variable, omega))
    solid = pt.shapes.Ellipsoid(axes, mass=1.0) if shape == "ellipsoid" else pt.shapes.Mesh.from_box(axes, mass=1.0)
    reading = DopplerBandwidth(solid, RADAR, 0.1).reading(at((0.5, -0.5, 0.5, 0.5), nodes))

    to_body = Rotation.from_quat([0.5, -0.5, 0.5, 0.5], scalar_first=True).as_matrix().round().T  # a third of a turn

    def exact(w):
        e = [-mpmath.mpf(x) for x in (0.3, -2.0, 1.1)]
        length = mpmath.sqrt(sum(x * x for x in e))
        e = [sum(int(m) * x for m, x in zip(row, e, strict=True)) / length for row in to_body]
        speed = [e[1] * w[2] - e[2] * w[1], e[2] * w[0] - e[0] * w[2], e[0] * w[1] - e[1] * w[0]]
        parts = [a * v for a, v in zip(axes, speed, strict=True)]
        return 40 * mpmath.sqrt(sum(x * x for x in parts)) if shape == "ellipsoid" else 20 * sum(map(abs, parts))

    with mpmath.workdps(40):
        h = mpmath.mpf(10) ** -15
        for i, node in enumerate(nodes):
            low, high = (exact([mpmath.mpf(x) + (s if j == i else 0) for j, x in enumerate(omega)]) for s in (-h, h))
            (found,) = graph.evaluated(tangents([reading], {node: 1.0}))
            assert found == pytest.approx(float((high - low) / (2 * h)), rel=32 * EPS, abs=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: DopplerEdges(BALL, RADAR, 0.0), r"wavelength must be positive, got 0\.0\."),
        (lambda: DopplerBandwidth((1, 2, 3), RADAR, 0.1), r"shape must be a Shape, got tuple\."),
        (lambda: DopplerBandwidth(BALL, BALL, 0.1), r"observer must be an Orbit, got Ellipsoid\."),
    ],
)
def test_wrong_arguments_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}$"):
        make()
