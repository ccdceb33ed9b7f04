"""Light on meshes against numbers of another program, made without this package."""

import json
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.shapes.daily_shadows import DailyShadows
from poinsot.shapes.surface import Surface
from poinsot.shapes.visibility import clear_parts
from unit.shapes.test_visibility import rough

CASES = json.loads((Path(__file__).parent / "yorp_cases.json").read_text())["cases"]
CONVEX, SHADED = CASES["yorp_convex"], CASES["self_shadowed_mesh"]


def mesh_of(case):
    return pt.shapes.Mesh(case["vertices"], case["faces"], density=1.0)


def clear_part(light, sun):
    """Return the areas and the centroids of the illuminated parts."""
    parts = clear_parts(light, [sun[None]])
    return parts.areas[0], parts.centers[0]


def emitted(light, areas, centers, sun):
    """-2/3 sum A (n.s) r x n."""
    return -2 / 3 * (areas * (light.normals @ sun)) @ np.cross(centers, light.normals)


@pytest.mark.parametrize("case", SHADED["cases"], ids=lambda case: str(case["sun"]))
def test_shadows_of_an_angled_body(case):
    mesh, sun = mesh_of(SHADED), np.array(case["sun"])
    light, bound = Surface(mesh), 20 * SHADED["estimated_error_of_reference"]
    lit = pt.shapes.illuminated_faces(mesh, sun)
    assert list(lit) == case["facet_lit_by_centroid"]
    whole = emitted(light, light.areas * lit, light.centers, sun)
    assert np.max(np.abs(whole - case["torque_by_centroid"])) < bound
    areas, centers = clear_part(light, sun)
    assert np.array_equal(pt.shapes.illuminated_areas(mesh, sun), areas)
    assert np.max(np.abs(areas - case["lit_areas_exact"])) < bound
    assert np.max(np.abs(emitted(light, areas, centers, sun) - case["torque_exact"])) < bound


def test_means_over_rotation_and_orbit_without_thermal_inertia():
    expected, bound = np.array(CONVEX["mean_torque_spin_obliquity"]), 20 * CONVEX["estimated_error_of_reference"]
    found = pt.analysis.yorp_coefficients(mesh_of(CONVEX), np.radians(CONVEX["obliquity_deg"]), shadows=False)
    assert np.max(np.abs(found.spin - expected[:, 0])) < bound
    assert np.max(np.abs(found.tilt - expected[:, 1])) < bound


def test_convex_meshes_have_the_same_means_with_shadows():
    mesh, obliquities = mesh_of(CONVEX), np.radians(CONVEX["obliquity_deg"])
    found = pt.analysis.yorp_coefficients(mesh, obliquities)
    closed = pt.analysis.yorp_coefficients(mesh, obliquities, shadows=False)
    for name in ("spin", "tilt", "late", "error"):
        assert np.array_equal(getattr(found, name), getattr(closed, name))
    assert not found.error.any()


def test_absorbed_light_has_no_mean():
    """Light from opposite sides finds the same outline, and its torques cancel."""
    light = Surface(mesh_of(SHADED))
    for direction in np.random.default_rng(3).normal(size=(5, 3)):
        sun = direction / np.linalg.norm(direction)
        torques = []
        for u in (sun, -sun):
            areas, centers = clear_part(light, u)
            torques.append(-np.cross((areas * (light.normals @ u)) @ centers, u))
        assert np.max(np.abs(torques)) > 0.01
        assert np.max(np.abs(np.sum(torques, axis=0))) < 1e-14


def sampled_means(mesh, obliquity, filtered, phases=1024, longitudes=128):
    """Spin and obliquity components by the light on each face in time, filtered harmonic by harmonic."""
    light = Surface(mesh)
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


def sums_over_rays(mesh, obliquity, later, longitudes=160, phases=180):
    """Return spin and tilt by rays from the centroids, for light that is emitted later by a part of a turn.

    The second result is the spread of four sums, which contain every fourth longitude.
    """
    corners = (mesh.vertices - mesh.center_of_mass)[mesh.faces]
    a, p, q = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals, centers = np.cross(p, q), corners.mean(axis=1)
    areas = np.linalg.norm(normals, axis=1) / 2
    normals /= 2 * areas[:, None]
    turns = -2 / 3 * areas[:, None] * np.cross(centers, normals)
    angles = 2 * np.pi * np.arange(phases) / phases
    c, s = np.cos(angles), np.sin(angles)
    torques = np.empty((longitudes, 2))
    for k, longitude in enumerate(2 * np.pi * (np.arange(longitudes) + 0.37) / longitudes):
        offset = 2 * np.pi * 0.6180339887 * k / phases  # each longitude meets other phases
        cx, cy = np.cos(offset), np.sin(offset)
        x, y, z = np.cos(longitude), np.sin(longitude) * np.cos(obliquity), np.sin(longitude) * np.sin(obliquity)
        x, y = cx * x + cy * y, cx * y - cy * x
        suns = np.stack([c * x + s * y, c * y - s * x, np.full(phases, z)], axis=-1)
        light = np.maximum(suns @ normals.T, 0)
        h = np.cross(suns[:, None], q)
        scale = np.einsum("dfi,fi->df", h, p)
        for face, center in enumerate(centers):
            g = np.cross(center - a, p)
            u, v = np.einsum("dfi,fi->df", h, center - a) / scale, suns @ g.T / scale
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (np.einsum("fi,fi->f", q, g) / scale > 1e-9)
            hit[:, face] = False
            light[hit.any(axis=1), face] = 0
        torque = np.roll(light, round(later * phases), axis=0) @ turns
        across = np.mean((c + 1j * s) * (torque[:, 0] + 1j * torque[:, 1]))
        torques[k] = torque[:, 2].mean(), (across * (cx + 1j * cy)).imag  # the change of obliquity is along y
    means = torques.mean(axis=0)
    return means, np.abs(torques.reshape(-1, 4, 2).mean(axis=0) - means).max(axis=0)


@pytest.mark.parametrize(("seed", "obliquity"), [(1, 0.3), (2, 1.1), (4, 2.4)])
def test_means_with_shadows_equal_sums_over_rays(seed, obliquity):
    mesh = rough(seed, 16)
    found = pt.analysis.yorp_coefficients(mesh, [obliquity])
    (spin, tilt), spread = sums_over_rays(mesh, obliquity, 0.0)
    (_, late), later_spread = sums_over_rays(mesh, obliquity, 0.25)
    unshaded = pt.analysis.yorp_coefficients(mesh, [obliquity], shadows=False)
    assert abs(unshaded.spin[0] - spin) > 10 * (found.error[0] + spread[0])
    assert abs(found.spin[0] - spin) < found.error[0] + spread[0]
    assert abs(found.tilt[0] - tilt) < found.error[0] + spread[1]
    assert abs(found.late[0] - late) < found.error[0] + later_spread[1]
    assert abs(late) > 10 * (found.error[0] + later_spread[1])


def test_the_error_contains_the_difference_from_many_latitudes():
    """Sums over 6000 longitudes leave less than 1/100 of the error of 128 longitudes, the power -3/2 of the number."""
    outside, longitudes = [], 2 * np.pi * (np.arange(6000) + 0.29) / 6000
    for seed in range(40):
        mesh, obliquity = rough(seed, 12), np.random.default_rng(seed).uniform(0, np.pi)
        found = pt.analysis.yorp_coefficients(mesh, [obliquity])
        bare = pt.analysis.yorp_coefficients(mesh, [obliquity], shadows=False)
        light = Surface(mesh)
        torques = -2 / 3 * light.areas[:, None] * np.cross(light.centers, light.normals)
        sines = np.sin(obliquity) * np.sin(longitudes)
        order = np.argsort(sines)
        along, across = DailyShadows(light, np.eye(3), torques).torques(sines[order])
        right = (np.sin(longitudes) * np.cos(obliquity) / np.sqrt(1 - sines**2))[order]
        lost = np.array([np.mean(along), np.mean(across.real * right), -np.mean(across.imag * right)])
        wanted = np.array([bare.spin[0], bare.tilt[0], bare.late[0]]) - lost
        off = np.abs(wanted - [found.spin[0], found.tilt[0], found.late[0]])
        outside += list(off > found.error[0] + 1e-14)
        assert found.error[0] < 1e-6 * np.linalg.norm(torques, axis=1).sum()
    assert len(outside) == 120
    assert not any(outside)


def test_late_is_the_tilt_of_light_a_quarter_of_a_turn_later():
    mesh = mesh_of(CONVEX)
    for obliquity in (0.4, 1.2, 2.5):
        found = pt.analysis.yorp_coefficients(mesh, [obliquity], shadows=False)
        later = sampled_means(mesh, obliquity, lambda k: np.exp(-0.5j * np.pi * k))
        # 128 longitudes and 1024 phases leave 1e-6, as below
        assert abs(found.late[0] - later[1]) < 1e-6
        assert abs(later[1]) > 1e-3
        # the lag of a large parameter is an eighth of a turn, the sum of the tilt and the late tilt
        lagged = found.with_lag(1e9)
        assert abs(lagged.tilt[0] * 1e9 - found.tilt[0] - found.late[0]) < 1e-8


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
