"""Brightness of bodies: kinds of arguments, derivatives, closed forms."""

import warnings
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as f
from poinsot.observables import (
    Hapke,
    HenyeyGreenstein,
    Lambert,
    LambertLommelSeeliger,
    LommelSeeliger,
    Minnaert,
    Phong,
    ScatteringLaw,
)
from poinsot.shapes import law_program, reflected_light
from poinsot.shapes.brightness import brightness_of, phase_angle
from poinsot.taylor.graph import Graph, tangents

SUN, OBSERVER = (0.3, -1.2, 0.8), (1.1, 0.4, 0.5)
BOX = pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), density=1.0)
LAWS = (
    LommelSeeliger(0.2),
    Minnaert(0.3, 0.6),
    LambertLommelSeeliger(0.1, 0.5, 0.1, -0.3),
    Hapke(0.33, 1.2, 0.04, -0.3),
    Phong(0.3, 0.4, 3.0),
)


ANGLE = pt.shapes.Mesh(
    [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2))],
    [
        *((0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 5, 4), (6, 7, 8), (6, 8, 9), (6, 9, 10), (6, 10, 11)),
        *((k, (k + 1) % 6, 6 + (k + 1) % 6) for k in range(6)),
        *((k, 6 + (k + 1) % 6, 6 + k) for k in range(6)),
    ],
    density=1.0,
)
"""A prism over the shape of the letter L, whose upright shades its arm."""

LOW_SUN, HIGH_OBSERVER = (-0.9, 0.8, 0.2), (0.6, 1.0, 0.5)


class Coated(ScatteringLaw):
    """A law of the user: a sum of powers with a weight that depends on the phase."""

    weight: float
    power: float

    def brightness(self, light):
        return self.weight * (0.5 + light.cos_phase / 4) * (light.mu0 * light.mu) ** (1 + self.power)


def unit(vector):
    return np.array(vector) / np.linalg.norm(vector)


def plain(mesh, law, sun, observer, stretch=(1, 1, 1)):
    """Sum over the faces of the stretched mesh."""
    corners = np.asarray(mesh.vertices) * stretch
    first, second, third = (corners[mesh.faces[:, k]] for k in range(3))
    vectors = 0.5 * np.cross(second - first, third - first)
    areas = np.linalg.norm(vectors, axis=1)
    sun, observer = unit(sun), unit(observer)
    phase = np.arccos(sun @ observer)
    total = 0.0
    for area, normal in zip(areas, vectors / areas[:, None], strict=True):
        mu0, mu = normal @ sun, normal @ observer
        if mu0 > 0 and mu > 0:
            total += area * law.brightness(pt.observables.Reflection(mu0, mu, phase))
    return total


FORMULAS = {
    "powers": lambda light: light.mu0**3 + light.mu**0.5 + (light.mu0 + light.mu) ** -1.5,
    "elementary functions": lambda light: (
        f.sin(light.mu0) * f.cos(light.mu)
        + f.tan(0.3 * light.mu)
        + f.tanh(light.mu0)
        + f.exp(-light.mu) * f.log(light.mu0)
    ),
    "inverse functions": lambda light: (
        f.asin(0.9 * light.mu0) + f.acos(0.9 * light.mu) * f.atan(light.mu0) + f.atan2(light.mu, light.mu0)
    ),
    "branches": lambda light: (
        f.where(f.less(light.mu0, light.mu), light.mu0, 0.5) + f.abs(light.mu - 0.4) + f.clip(light.mu0, 0.2, 0.6)
    ),
    "tables": lambda light: f.interp(light.mu0, (0.0, 0.4, 1.0), (0.0, 0.3, 0.2)) + f.rint(4 * light.mu),
    "quotients": lambda light: (
        (light.mu0 / (light.mu0 + light.mu) - light.phase / (light.mu0 + light.mu)) / (1 + light.phase) - light.mu
    ),
    "half angles": lambda light: light.half * light.half_view + light.mirror,
    "negative": lambda light: -light.mu0 - (-light.mu) * light.cos_phase,
    "one cosine": lambda light: light.mu0,
    "phase": lambda light: 2 + light.phase,
    "constant": lambda light: 0.7,  # noqa: ARG005
}
"""Formulas of laws, most of which are not physical."""


@pytest.mark.parametrize("name", FORMULAS)
def test_any_formula_is_a_law(name):
    kind = type("Written", (ScatteringLaw,), {"brightness": lambda _, light: FORMULAS[name](light)})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        law = kind()
    expected = plain(BOX, law, SUN, OBSERVER)
    assert brightness_of(BOX, law, SUN, OBSERVER) == pytest.approx(expected, rel=1e-13, abs=0)
    epochs = reflected_light.MIN_COMPILED // len(BOX.faces) + 1
    long = brightness_of(BOX, law, np.repeat(SUN, epochs).reshape(3, -1), OBSERVER)
    np.testing.assert_allclose(long, expected, rtol=1e-13, atol=0)
    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(6)]
    total = brightness_of(BOX, law, symbols[:3], symbols[3:])
    slopes = [tangents([total], {x: 1.0})[0] for x in symbols]
    place = np.array([*SUN, *OBSERVER])
    found = graph.evaluated(slopes, dict(zip(symbols, place, strict=True)))
    for k in range(6):
        change = 1e-6 * np.eye(6)[k]
        high, low = (plain(BOX, law, *np.split(place + sign * change, 2)) for sign in (1, -1))
        assert found[k] == pytest.approx((high - low) / 2e-6, rel=1e-7, abs=1e-8 * abs(expected))


@pytest.mark.parametrize("law", [*LAWS, Coated(0.4, 0.2)], ids=lambda law: type(law).__name__)
def test_a_stretched_mesh_is_the_mesh_of_stretched_vertices(law):
    stretch = (1.3, 0.7, 0.9)
    found = brightness_of(BOX, law, SUN, OBSERVER, stretch)
    assert found == pytest.approx(plain(BOX, law, SUN, OBSERVER, stretch), rel=1e-13, abs=0)


SHAPES = {
    "mesh": (BOX, SUN, OBSERVER, False),
    "ellipsoid": (pt.shapes.Ellipsoid((3.0, 2.0, 1.5), mass=1.0), SUN, OBSERVER, False),
    "shadows": (ANGLE, LOW_SUN, HIGH_OBSERVER, "exact"),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("law", [*LAWS[:-1], Coated(0.4, 0.2)], ids=lambda law: type(law).__name__)
def test_derivatives_are_quotients_of_differences(shape, law):
    """Central differences with an extrapolation leave h^4 times a fifth derivative, and the rounding over h."""
    solid, sun, observer, shadows = SHAPES[shape]
    place = np.array([*sun, *observer, 1.1, 0.9, 1.2, *map(float, law.numbers)])

    def value(x):
        return brightness_of(solid, law.with_numbers(x[9:]), x[:3], x[3:6], x[6:9], shadows)

    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(len(place))]
    outputs = [value(symbols)]
    slopes = [tangents(outputs, {x: 1.0})[0] for x in symbols]
    found = graph.evaluated([*outputs, *slopes], dict(zip(symbols, place, strict=True)))
    assert found[0] == pytest.approx(value(list(place)), rel=1e-14, abs=0)
    for k in np.flatnonzero(place):
        slope = found[1 + k]
        change = np.zeros(len(place))
        change[k] = h = 1e-3 * abs(place[k])
        each = [(value(list(place + n * change)) - value(list(place - n * change))) / (2 * n * h) for n in (1, 2)]
        quotient = (4 * each[0] - each[1]) / 3
        assert slope == pytest.approx(quotient, rel=1e-7, abs=1e-9 * abs(found[0]))


@pytest.mark.parametrize("shape", [BOX, pt.shapes.Ellipsoid((3.0, 2.0, 1.5), mass=1.0)], ids=["mesh", "ellipsoid"])
@pytest.mark.parametrize("law", LAWS[:4], ids=lambda law: type(law).__name__)
def test_arrays_of_members_and_times_are_as_single_calls(shape, law):
    generator = np.random.default_rng(1)
    sun, observer = generator.normal(size=(2, 3, 4, 5))
    stretch: Any = [1.0, generator.uniform(0.8, 1.2, (4, 1)), 1.1]
    numbers = [np.asarray(x) * generator.uniform(0.9, 1.0, (4, 1)) for x in law.numbers]
    found: Any = brightness_of(shape, law.with_numbers(numbers), sun, observer, stretch)
    assert found.shape == (4, 5)
    for k, n in np.ndindex(4, 5):
        own = law.with_numbers([float(x[k, 0]) for x in numbers])
        factors = [1.0, float(stretch[1][k, 0]), 1.1]
        one = brightness_of(shape, own, sun[:, k, n], observer[:, k, n], factors)
        assert found[k, n] == pytest.approx(one, rel=1e-12, abs=1e-14)


def test_shadows_darken_a_concave_mesh():
    """The upright, higher by 1, throws a shadow of length 1 on the arm, which is 2 long."""
    kinds = False, "centroids", "exact"
    lit, centroids, exact = (
        np.asarray(brightness_of(ANGLE, Lambert(0.5), (-1.0, 1.0, 0.0), (0.0, 1.0, 0.0), shadows=shadows)).item()
        for shadows in kinds
    )
    assert lit == pytest.approx(0.5 * (1 + 2) / 2**0.5, rel=1e-14, abs=0)
    assert exact == pytest.approx(0.5 * (1 + 1) / 2**0.5, rel=1e-14, abs=0)
    assert centroids in (pytest.approx(lit * n / 6, rel=1e-14, abs=0) for n in range(2, 7))
    convex = [brightness_of(BOX, LAWS[0], SUN, OBSERVER, shadows=shadows) for shadows in kinds]
    np.testing.assert_allclose(convex, convex[0], rtol=1e-15, atol=0)


def test_shadows_under_a_stretch_are_shadows_of_the_stretched_mesh():
    stretch = (1.3, 0.7, 0.9)
    stretched = pt.shapes.Mesh(np.asarray(ANGLE.vertices) * stretch, ANGLE.faces, density=1.0)
    found = brightness_of(ANGLE, LAWS[0], LOW_SUN, HIGH_OBSERVER, stretch, "exact")
    expected = brightness_of(stretched, LAWS[0], LOW_SUN, HIGH_OBSERVER, shadows="exact")
    assert found == pytest.approx(expected, rel=1e-13, abs=0)
    assert found < 0.99 * brightness_of(stretched, LAWS[0], LOW_SUN, HIGH_OBSERVER)


def test_centroids_have_no_derivatives():
    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(3)]
    brightness = brightness_of(ANGLE, LAWS[0], symbols, HIGH_OBSERVER, shadows="centroids")
    (slope,) = tangents([brightness], {symbols[0]: 1.0})
    with pytest.raises(ValueError, match='shadows must be "exact" for derivatives, got "centroids"'):
        graph.evaluated([slope], dict(zip(symbols, LOW_SUN, strict=True)))


@pytest.mark.parametrize("shape", [BOX, pt.shapes.Ellipsoid((3.0, 2.0, 1.5), mass=1.0)], ids=["mesh", "ellipsoid"])
@pytest.mark.parametrize("law", [Lambert(0.3), *LAWS[:4]], ids=lambda law: type(law).__name__)
def test_long_light_curves_are_as_short_ones(shape, law, monkeypatch):
    """Long ones are compiled for laws of arithmetic, if there is a compiler."""
    epochs = reflected_light.MIN_COMPILED // (len(shape.faces) if shape is BOX else 256) + 1
    directions = np.random.default_rng(2).normal(size=(6, epochs))
    graph = Graph()
    numbers = [float(x) for x in law.numbers if x]
    symbols = [graph.symbol(f"x{k}") for k in range(9 + len(numbers))]
    others = iter(symbols[9:])
    brightness = brightness_of(
        shape,
        law.with_numbers(next(others) if x else 0.0 for x in law.numbers),
        symbols[:3],
        symbols[3:6],
        symbols[6:9],
    )
    outputs = [brightness, *(tangents([brightness], {x: 1.0})[0] for x in symbols)]
    values = dict(zip(symbols, [*directions, 1.1, 0.9, 1.2, *numbers], strict=True))
    long = graph.evaluated(outputs, values)
    scale = np.abs(long).max(axis=1, keepdims=True)
    short = graph.evaluated(outputs, {x: value[:50] if np.ndim(value) else value for x, value in values.items()})
    np.testing.assert_allclose(np.array(long)[:, :50] / scale, short / scale, rtol=0, atol=1e-14)
    monkeypatch.setattr(law_program, "CompiledSums", without_compiler)
    monkeypatch.setattr(law_program, "_formulas", {})
    other = brightness_of(shape, law, directions[:3], directions[3:], (1.1, 0.9, 1.2))
    np.testing.assert_allclose(other / scale[0], long[0] / scale[0], rtol=0, atol=1e-14)


def without_compiler(*_):
    raise ImportError("llvmlite must be installed")


def test_spheres_have_closed_forms():
    ball, phases = pt.shapes.Ellipsoid((1.3, 1.3, 1.3), mass=1.0), np.array([1e-3, 0.4, 1.2, 2.0, 2.6])
    to_observer = [np.cos(phases), np.sin(phases), 0.0]
    lambert = brightness_of(ball, Lambert(0.7), (1.0, 0.0, 0.0), to_observer)
    closed = 0.7 * 1.69 * 2 / 3 * (np.sin(phases) + (np.pi - phases) * np.cos(phases))
    np.testing.assert_allclose(lambert, closed, rtol=1e-13, atol=1e-16)
    dark = brightness_of(ball, LommelSeeliger(0.2), (1.0, 0.0, 0.0), to_observer)
    half = 0.5 * phases
    closed = 0.05 * np.pi * 1.69 / 2 * (1 - np.sin(half) * np.tan(half) * np.log(1 / np.tan(0.5 * half)))
    np.testing.assert_allclose(dark, closed, rtol=1e-13, atol=1e-16)


def test_the_closed_form_of_ellipsoids_includes_the_phase_function():
    ellipsoid, function = pt.shapes.Ellipsoid((3.0, 2.0, 1.5), mass=1.0), HenyeyGreenstein(-0.3)
    plain, scattered = (
        brightness_of(ellipsoid, law, SUN, OBSERVER) for law in (LAWS[0], LommelSeeliger(0.2, function))
    )
    phase = np.arccos(unit(SUN) @ unit(OBSERVER))
    factor = function.value(pt.observables.Reflection(1.0, 1.0, phase))
    assert scattered == pytest.approx(factor * plain, rel=1e-14, abs=0)


def test_opposition_and_new_phase_are_finite():
    ellipsoid = pt.shapes.Ellipsoid((3.0, 2.0, 1.5), mass=1.0)
    opposite = [-x for x in SUN]
    for shape in (BOX, ellipsoid):
        for law in LAWS:
            graph = Graph()
            symbols = [graph.symbol(f"x{k}") for k in range(6)]
            brightness = brightness_of(shape, law, symbols[:3], symbols[3:])
            slopes = [tangents([brightness], {x: 1.0})[0] for x in symbols]
            for observer in (SUN, opposite):
                values = graph.evaluated([brightness, *slopes], dict(zip(symbols, [*SUN, *observer], strict=True)))
                assert np.all(np.isfinite(values))
            assert values[0] == pytest.approx(0.0, rel=0, abs=1e-15)


def test_phase_angles_are_exact_near_opposition():
    sun, observer = pt.functions.Vector((1.0, 0.0, 0.0)), pt.functions.Vector((1.0, 1e-9, 0.0))
    assert phase_angle(sun, observer) == pytest.approx(1e-9, rel=1e-14, abs=0)


def test_plates_are_one_sided():
    plates = pt.forces.Facets([2.0, 3.0], [(0, 0, 1), (0, 0, -1)], [(0, 0, 0), (0, 0, 0)])
    above = brightness_of(plates, Lambert(0.5), (0, 0, 1), (0, 0, 2.0))
    below = brightness_of(plates, Lambert(0.5), (0, 0, -1), (0, 0, -2.0))
    assert (above, below) == (1.0, 1.5)
    assert brightness_of(plates, Lambert(0.5), (0, 0, 1), (0, 0, -1)) == 0
