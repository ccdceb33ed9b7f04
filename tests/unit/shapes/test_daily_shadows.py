"""Means over a rotation of the torques that faces lose in shadow, against rays at many phases."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.shapes.daily_shadows import DailyShadows
from poinsot.shapes.surface import Surface
from unit.shapes.test_visibility import boxes, bumpy, rough

PHASES = 1000


def open_lid():
    """Return a hollow prism, whose rim surrounds the pole of the sky for the faces of its floor."""
    turns = np.pi * np.arange(6) / 3
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    corners = [np.column_stack([r * ring, np.full(6, z)]) for r, z in ((1, 0), (1, 1), (0.8, 1), (0.8, 0.2))]
    vertices = np.concatenate([*corners, [(0, 0, 0)], [(0, 0, 0.2)]])
    faces = []
    for k in range(6):
        n = (k + 1) % 6
        for low in (0, 6, 12):
            a, b, c, d = low + k, low + n, low + 6 + n, low + 6 + k
            faces += [(a, b, c), (a, c, d)]
        faces += [(24, n, k), (25, 18 + k, 18 + n)]
    return pt.shapes.Mesh(vertices, np.array(faces), mass=1.0)


def axes_about(pole):
    """Return a rotation matrix whose third row has a direction."""
    third = np.array(pole, dtype=float) / np.linalg.norm(pole)
    first = np.cross((0.3, 0.5, 0.7), third)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(third, first), third])


def met(vertices, faces, suns):
    """Return whether rays from the centroids meet other faces, by the method of Moeller and Trumbore."""
    corners = vertices[faces]
    a, p, q = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    h = np.cross(suns[:, None], q)
    scale = np.einsum("dfi,fi->df", h, p)
    hit = np.zeros(scale.shape, dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for face, center in enumerate(corners.mean(axis=1)):
            s = center - a
            g = np.cross(s, p)
            u = np.einsum("dfi,fi->df", h, s) / scale
            v = suns @ g.T / scale
            distance = np.einsum("fi,fi->f", q, g) / scale
            some = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 1e-9)
            some[:, face] = False
            hit[:, face] = some.any(axis=1)
    return hit


def sampled(vertices, faces, center, sine, pole):
    """Return the lost torques at one latitude by sums over phases, and the bound of the error of the sums."""
    axes = axes_about(pole)
    corners = (vertices - center)[faces] @ axes.T
    turns = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(turns, axis=1) / 2
    normals = turns / (2 * areas[:, None])
    torques = -2 / 3 * areas[:, None] * np.cross(corners.mean(axis=1), normals)
    phases = 2 * np.pi * (np.arange(PHASES) + 0.37) / PHASES
    cosine = np.sqrt(1 - sine**2)
    suns = np.stack([cosine * np.cos(phases), cosine * np.sin(phases), np.full(PHASES, sine)], axis=-1)
    facing = np.maximum(suns @ normals.T, 0)
    hit = met(corners.reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3), suns) & (facing > 0)
    light = facing * hit
    across = light @ (torques[:, 0] + 1j * torques[:, 1]) * np.exp(-1j * phases)
    # a jump moves by at most one phase; the light is at most 1; kinks add 1/2 of the squared step at most
    jumps = np.count_nonzero(hit != np.roll(hit, 1, axis=0), axis=0)
    bound = (jumps + 1e-2) @ np.linalg.norm(torques, axis=1) / PHASES
    return np.mean(light @ torques[:, 2]), np.mean(across), bound


MESHES = {
    "rough": rough(1),
    "bumpy": bumpy(24, 0.9),
    "boxes apart": boxes((0, 0, 0), (3, 0, 0), (0, 3, 0.5)),
    "boxes that touch and intersect": boxes((0, 0, 0), (1, 0, 0), (0.5, 0.5, 0.5)),
    "lid": open_lid(),
}


@pytest.mark.parametrize("pole", [(0, 0, 1), (0.36, -0.48, 0.8)], ids=str)
@pytest.mark.parametrize("name", MESHES)
def test_lost_torques_equal_sums_over_rays(name, pole):
    mesh = MESHES[name]
    light, axes = Surface(mesh), axes_about(pole)
    torques = -2 / 3 * light.areas[:, None] * (np.cross(light.centers, light.normals) @ axes.T)
    sines = np.array([-0.999, -0.71, -0.123, 1e-12, 0.4, 0.93])
    along, across = DailyShadows(light, axes, torques).torques(sines)
    assert np.max(np.abs(along) + np.abs(across)) > 1e-3
    for sine, one, other in zip(sines, along, across, strict=True):
        mean, first, bound = sampled(mesh.vertices, mesh.faces, mesh.center_of_mass, sine, pole)
        assert abs(one - mean) < bound
        assert abs(other - first) < bound


def test_latitudes_in_blocks_give_the_same_torques(monkeypatch):
    mesh = rough(2)
    light, axes = Surface(mesh), np.eye(3)
    shadows = DailyShadows(light, axes, np.cross(light.centers, light.normals))
    sines = np.linspace(-0.9, 0.9, 31)
    whole = shadows.torques(sines)
    monkeypatch.setattr("poinsot.shapes.daily_shadows.MAX_PAIRS", 1)
    for one, other in zip(whole, shadows.torques(sines), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-15)


def test_convex_meshes_lose_nothing():
    light = Surface(pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0))
    shadows = DailyShadows(light, axes_about((1, 2, 2)), np.ones((12, 3)))
    along, across = shadows.torques(np.linspace(-0.9, 0.9, 7))
    assert not along.any()
    assert not across.any()
