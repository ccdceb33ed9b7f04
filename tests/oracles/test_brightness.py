"""Brightness of meshes and ellipsoids against numbers computed with 50 digits by independent code."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.observables import (
    AshikhminShirley,
    CookTorrance,
    Hapke,
    Lambert,
    LambertLommelSeeliger,
    LommelSeeliger,
    LunarLambert,
    Minnaert,
    Phong,
)
from poinsot.shapes.brightness import Companion, brightness_of
from poinsot.taylor.graph import Graph, tangents

CASES = json.loads((Path(__file__).parent / "brightness_cases.json").read_text())
NUMBERS = {name: law["parameters"] for name, law in CASES["laws"].items()}
LAWS = {
    "lambert": Lambert(**NUMBERS["lambert"]),
    "lommel_seeliger": LommelSeeliger(albedo=NUMBERS["lommel_seeliger"]["w"]),
    "ls_lambert": LambertLommelSeeliger(**NUMBERS["ls_lambert"]),
    "minnaert": Minnaert(**NUMBERS["minnaert"]),
    "lunar_lambert": LunarLambert(**NUMBERS["lunar_lambert"]),
    "hapke": Hapke(**NUMBERS["hapke"]),
    "hapke_rough": Hapke(**NUMBERS["hapke"], roughness=NUMBERS["hapke_rough"]["theta"]),
    "phong": Phong(**NUMBERS["phong"]),
    "cook_torrance": CookTorrance(**NUMBERS["cook_torrance"]),
    "ashikhmin_shirley": AshikhminShirley(**NUMBERS["ashikhmin_shirley"]),
}
MESHES = {name: pt.shapes.Mesh(mesh["vertices"], mesh["faces"], density=1.0) for name, mesh in CASES["meshes"].items()}
SHADED = [case for case in CASES["cases"] if case["shadows"]]
ELLIPSOIDS = [(law, case) for case in CASES["ellipsoids"] for law in case["brightness"]]


@pytest.mark.parametrize("law", LAWS)
def test_meshes(law):
    for case in CASES["cases"]:
        found = brightness_of(*given(case, law), shadows=shadows_of(case))
        assert found == pytest.approx(case["brightness"][law], rel=1e-14, abs=0)


def test_derivatives_by_the_rotation_vector():
    checked = 0
    for case in CASES["cases"]:
        for law, reference in case.get("by_rotation_vector", {}).items():
            shape, scattering, to_sun, to_observer = given(case, law)
            found = by_rotation(shape, scattering, to_sun, to_observer, shadows_of(case))
            assert np.max(np.abs(found - reference)) < 2e-14 * np.max(np.abs(reference))
            checked += 1
    assert checked == 12


@pytest.mark.parametrize("case", SHADED, ids=lambda case: f"{case['mesh']} {case['to_sun']}")
def test_areas_that_are_illuminated_and_seen(case):
    mesh = MESHES[case["mesh"]]
    areas = pt.shapes.illuminated_areas(mesh, case["to_sun"], to_observer=case["to_observer"])
    np.testing.assert_allclose(areas, case["areas"], rtol=0, atol=1e-14 * mesh.face_areas.max())


@pytest.mark.parametrize("case", CASES["pair"]["cases"], ids=lambda case: case["kind"])
def test_mutual_shadows_and_occultations(case):
    meshes = [pt.shapes.Mesh(mesh["vertices"], mesh["faces"], density=1.0) for mesh in CASES["pair"]["meshes"]]
    laws = [LommelSeeliger(albedo=w) for w in CASES["pair"]["w"]]
    axes = [Rotation.from_quat(q, scalar_first=True).as_matrix() for q in case["quaternions"]]
    for own, other, sign in ((0, 1, 1), (1, 0, -1)):
        position = sign * axes[own].T @ case["secondary_from_primary"]
        companion = Companion(meshes[other], position, axes[own].T @ axes[other])
        directions = [axes[own].T @ case[name] for name in ("to_sun", "to_observer")]
        found = brightness_of(meshes[own], laws[own], *directions, shadows="exact", companion=companion)
        assert found == pytest.approx(case["brightness_of_each"][own], rel=1e-13, abs=1e-16)
        alone = brightness_of(meshes[own], laws[own], *directions)
        assert alone == pytest.approx(case["without_the_other"][own], rel=1e-13, abs=0)


def given(case, law):
    return MESHES[case["mesh"]], LAWS[law], case["to_sun"], case["to_observer"]


def shadows_of(case):
    return "exact" if case["shadows"] else False


@pytest.mark.parametrize(("law", "case"), ELLIPSOIDS, ids=lambda x: x if isinstance(x, str) else "")
def test_ellipsoids(law, case):
    shape = pt.shapes.Ellipsoid(case["semi_axes"], density=1.0)
    found = brightness_of(shape, LAWS[law], case["to_sun"], case["to_observer"])
    assert found == pytest.approx(case["brightness"][law], rel=4e-14, abs=0)


def by_rotation(shape, law, to_sun, to_observer, shadows):
    """Derivatives by the rotation vector theta along the body axes of a body that turns by theta: dv = v x theta."""
    graph = Graph()
    symbols = [graph.symbol(name) for name in ("sx", "sy", "sz", "ex", "ey", "ez")]
    brightness = brightness_of(shape, law, symbols[:3], symbols[3:], shadows=shadows)
    values = dict(zip(symbols, [*to_sun, *to_observer], strict=True))
    changes = []
    for axis in np.eye(3):
        seeds = np.concatenate([np.cross(vector, axis) for vector in (to_sun, to_observer)])
        changes += tangents([brightness], dict(zip(symbols, map(float, seeds), strict=True)))
    return np.array(graph.evaluated(changes, values))
