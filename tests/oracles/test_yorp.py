"""Light on meshes against numbers of another program, made without this package."""

import json
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.shapes.illumination import Lighting

CASES = json.loads((Path(__file__).parent / "yorp_cases.json").read_text())["cases"]
CONVEX, SHADED = CASES["yorp_convex"], CASES["self_shadowed_mesh"]


def mesh_of(case):
    return pt.shapes.Mesh(case["vertices"], case["faces"], density=1.0)


def emitted(light, areas, centers, sun):
    """-2/3 sum A (n.s) r x n."""
    return -2 / 3 * (areas * (light.normals @ sun)) @ np.cross(centers, light.normals)


@pytest.mark.parametrize("case", SHADED["cases"], ids=lambda case: str(case["sun"]))
def test_shadows_of_an_angled_body(case):
    mesh, sun = mesh_of(SHADED), np.array(case["sun"])
    light, bound = Lighting(mesh), 20 * SHADED["estimated_error_of_reference"]
    lit = pt.shapes.lit_faces(mesh, sun)
    assert list(lit) == case["facet_lit_by_centroid"]
    whole = emitted(light, light.areas * lit, light.centers, sun)
    assert np.max(np.abs(whole - case["torque_by_centroid"])) < bound
    areas, centers = light.lit_parts(sun)
    assert np.array_equal(pt.shapes.lit_areas(mesh, sun), areas)
    assert np.max(np.abs(areas - case["lit_areas_exact"])) < bound
    assert np.max(np.abs(emitted(light, areas, centers, sun) - case["torque_exact"])) < bound


def test_means_over_rotation_and_orbit_without_thermal_inertia():
    expected, bound = np.array(CONVEX["mean_torque_spin_obliquity"]), 20 * CONVEX["estimated_error_of_reference"]
    found = pt.analysis.yorp_coefficients(mesh_of(CONVEX), np.radians(CONVEX["obliquity_deg"]), shadows=False)
    assert np.max(np.abs(found.spin - expected[:, 0])) < bound
    assert np.max(np.abs(found.tilt - expected[:, 1])) < bound


def test_means_by_sums_are_those_of_the_closed_form():
    expected = np.array(CONVEX["mean_torque_spin_obliquity"])
    found = pt.analysis.yorp_coefficients(mesh_of(CONVEX), np.radians(CONVEX["obliquity_deg"]))  # it has no shadows
    # Sixteen faces have kinks, which 30 latitudes blur: twice as many leave an eighth.
    assert np.max(np.abs(found.spin - expected[:, 0])) < 1e-4
    assert np.max(np.abs(found.tilt - expected[:, 1])) < 2e-5


def test_absorbed_light_has_no_mean():
    """Light from opposite sides finds the same outline, and its torques cancel."""
    light = Lighting(mesh_of(SHADED))
    for direction in np.random.default_rng(3).normal(size=(5, 3)):
        sun = direction / np.linalg.norm(direction)
        torques = []
        for u in (sun, -sun):
            areas, centers = light.lit_parts(u)
            torques.append(-np.cross((areas * (light.normals @ u)) @ centers, u))
        assert np.max(np.abs(torques)) > 0.01
        assert np.max(np.abs(np.sum(torques, axis=0))) < 1e-14


def sampled_means(mesh, obliquity, filtered, phases=1024, longitudes=128):
    """Spin and obliquity components by the light on each face in time, filtered harmonic by harmonic."""
    light = Lighting(mesh)
    turns = -2 / 3 * light.areas[:, None] * np.cross(light.centers, light.normals)
    angles = 2 * np.pi * np.arange(phases) / phases
    total = np.zeros(3)
    for longitude in 2 * np.pi * (np.arange(longitudes) + 0.5) / longitudes:
        sun = np.array(
            [np.cos(longitude), np.sin(longitude) * np.cos(obliquity), np.sin(longitude) * np.sin(obliquity)]
        )
        c, s = np.cos(angles), np.sin(angles)
        in_body = np.stack([c * sun[0] + s * sun[1], c * sun[1] - s * sun[0], 0 * c + sun[2]], axis=-1)
        absorbed = np.maximum(in_body @ light.normals.T, 0)
        spectrum = np.fft.rfft(absorbed, axis=0)
        emitted_light = np.fft.irfft(spectrum * filtered(np.arange(len(spectrum)))[:, None], phases, axis=0)
        torque = emitted_light @ turns
        in_space = np.stack([c * torque[:, 0] - s * torque[:, 1], s * torque[:, 0] + c * torque[:, 1], torque[:, 2]])
        total += in_space.mean(axis=1) / longitudes
    return total[2], total[1]  # the change of obliquity is along y: the node is x


@pytest.mark.parametrize("parameter", [0.0, 0.3, 2.0])
def test_thermal_lag_is_a_filter_of_the_light_on_each_face(parameter):
    mesh, obliquity = mesh_of(CONVEX), 0.7
    still = pt.analysis.yorp_coefficients(mesh, [obliquity], shadows=False)
    late = still.with_lag(parameter)
    spin, tilt = sampled_means(mesh, obliquity, lambda k: 1 / (1 + np.sqrt(2j * k) * parameter / 2))
    # The brute force of the reference, with more samples, is off by 1e-7: ten times that.
    assert abs(late.tilt[0] - tilt) < 1e-6
    assert abs(late.spin[0] - spin) < 1e-6
    assert np.array_equal(late.spin, still.spin)
    assert parameter == 0 or abs(late.tilt[0] - still.tilt[0]) > 1e-3
    part = still.with_lag(parameter, albedo=0.4)
    np.testing.assert_allclose(part.tilt, 0.4 * still.tilt + 0.6 * late.tilt, rtol=2e-15)
