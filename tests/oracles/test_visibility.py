"""Clear areas, brightness and its derivatives against numbers computed with 50 digits by independent code."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Neighbour
from poinsot.shapes.visibility import clear_parts

DATA = json.loads((Path(__file__).parent / "brightness_cases.json").read_text())


def unit(direction):
    return np.array(direction) / np.linalg.norm(direction)


def mesh_of(record):
    return pt.shapes.Mesh(record["vertices"], record["faces"], density=1.0)


def lommel_seeliger(normals, s, e):
    """Return mu0 mu/(mu0 + mu)/4 of each face, and its derivatives by mu0 and mu."""
    mu0, mu = normals @ s, normals @ e
    lit = (mu0 > 0) & (mu > 0)
    whole = np.where(lit, mu0 + mu, 1.0)
    return tuple(np.where(lit, value, 0.0) / 4 for value in (mu0 * mu / whole, (mu / whole) ** 2, (mu0 / whole) ** 2))


@pytest.mark.parametrize(
    "case", [case for case in DATA["cases"] if case["shadows"]], ids=lambda case: f"{case['mesh']} {case['to_sun']}"
)
def test_brightness_with_exact_shadows(case):
    surface = Surface(mesh_of(DATA["meshes"][case["mesh"]]))
    s, e = unit(case["to_sun"]), unit(case["to_observer"])
    parts = clear_parts(surface, [s[None], e[None]])
    areas = parts.areas[0]
    np.testing.assert_allclose(areas, case["areas"], rtol=0, atol=1e-14 * surface.areas.max())
    albedo = DATA["laws"]["lambert"]["parameters"]["albedo"]
    lambert = albedo * areas @ (np.maximum(surface.normals @ s, 0) * np.maximum(surface.normals @ e, 0))
    assert lambert == pytest.approx(case["brightness"]["lambert"], rel=1e-13, abs=0)
    law, by_mu0, by_mu = (
        DATA["laws"]["lommel_seeliger"]["parameters"]["w"] * x for x in lommel_seeliger(surface.normals, s, e)
    )
    assert areas @ law == pytest.approx(case["brightness"]["lommel_seeliger"], rel=1e-13, abs=0)
    if "by_rotation_vector" in case:
        slopes = parts.slopes(law[None]).directions
        by_sun = (areas * by_mu0) @ surface.normals + slopes[0][0]
        by_observer = (areas * by_mu) @ surface.normals + slopes[1][0]
        found = np.cross(by_sun, s) + np.cross(by_observer, e)  # s and e turn by -theta
        expected = case["by_rotation_vector"]["lommel_seeliger"]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("case", DATA["pair"]["cases"], ids=lambda case: case["kind"])
def test_mutual_shadows_and_occultations(case):
    meshes = list(map(mesh_of, DATA["pair"]["meshes"]))
    axes = [Rotation.from_quat(unit(q), scalar_first=True).as_matrix() for q in case["quaternions"]]
    for own, other, sign in ((0, 1, 1), (1, 0, -1)):
        s, e = axes[own].T @ unit(case["to_sun"]), axes[own].T @ unit(case["to_observer"])
        position = sign * axes[own].T @ case["secondary_from_primary"]
        neighbour = Neighbour(Surface(meshes[other]), position[None], (axes[own].T @ axes[other])[None])
        surface = Surface(meshes[own])
        areas = clear_parts(surface, [s[None], e[None]], neighbour).areas[0]
        light = DATA["pair"]["w"][own] * lommel_seeliger(surface.normals, s, e)[0]
        assert areas @ light == pytest.approx(case["brightness_of_each"][own], rel=1e-13, abs=1e-16)
        assert surface.areas @ light == pytest.approx(case["without_the_other"][own], rel=1e-13, abs=0)
