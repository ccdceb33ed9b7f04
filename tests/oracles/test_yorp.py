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
