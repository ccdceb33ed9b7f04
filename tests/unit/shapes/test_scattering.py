"""Laws of scattering: reciprocity, energy, exact formulas, kinds of scalars, messages."""

import warnings
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from poinsot import functions
from poinsot.observables import (
    AshikhminShirley,
    CookTorrance,
    Hapke,
    HenyeyGreenstein,
    IsotropicPhase,
    Lambert,
    LambertLommelSeeliger,
    LommelSeeliger,
    LunarLambert,
    Minnaert,
    Phong,
    Reflection,
    ScatteringLaw,
)


class Velvet(ScatteringLaw):
    """A law of the user that is physical."""

    albedo: float

    def brightness(self, light):
        return self.albedo * functions.sqrt(light.mu0 * light.mu) * light.mu0 * light.mu


share, small = st.floats(0, 1), st.floats(0.02, 1)
LAWS = st.one_of(
    st.builds(Lambert, share),
    st.builds(LommelSeeliger, share),
    st.builds(LunarLambert, st.floats(0, 0.6), share),
    st.builds(Minnaert, st.floats(0, 0.5), st.floats(1.0, 2.0)),
    st.builds(Hapke, st.floats(0, 0.9), share, small, st.floats(-0.3, 0.3), st.floats(0, 0.8)),
    st.builds(Phong, st.floats(0, 0.5), st.floats(0, 0.5), st.floats(0.5, 40)),
    st.builds(CookTorrance, st.floats(0, 0.5), st.floats(0, 0.5), st.floats(0.1, 0.5), st.floats(0, 0.5)),
    st.builds(AshikhminShirley, share, share, st.floats(1, 40)),
    st.builds(Velvet, share),
)
"""Laws with an albedo; the law of Kaasalainen et al. has none."""

cosine = st.floats(1e-3, 1)


def phase_of(mu0, mu, azimuth):
    return np.arccos(np.clip(mu0 * mu + np.sqrt((1 - mu0**2) * (1 - mu**2)) * np.cos(azimuth), -1, 1))


@given(LAWS, cosine, cosine, st.floats(0, np.pi))
def test_laws_are_reciprocal_and_not_negative(law, mu0, mu, azimuth):
    phase = phase_of(mu0, mu, azimuth)
    there, back = law.brightness(Reflection(mu0, mu, phase)), law.brightness(Reflection(mu, mu0, phase))
    assert there >= 0
    assert there == pytest.approx(back, rel=1e-12, abs=1e-300)


@given(LAWS, st.floats(0.1, 1))
def test_a_surface_reflects_at_most_the_light_that_arrives(law, mu0):
    """The sum over 100 x 100 directions of lobes of width 0.15 is exact to 1e-3."""
    nodes, weights = np.polynomial.legendre.leggauss(100)
    mu, azimuth = 0.5 * (1 + nodes)[:, None], 0.5 * np.pi * (1 + nodes)
    reflected = law.brightness(Reflection(mu0, mu, phase_of(mu0, mu, azimuth))) / mu0
    total = 0.5 * np.pi * weights @ np.broadcast_to(reflected, (100, 100)) @ weights
    assert total <= np.pi * (1 + 1e-3)


@given(st.floats(-1, 1), st.floats(0.1, 2), cosine, cosine, st.floats(0, np.pi))
def test_the_law_without_albedo_is_reciprocal(c, d, mu0, mu, azimuth):
    law, phase = LambertLommelSeeliger(abs(c), 0.5, d, c), phase_of(mu0, mu, azimuth)
    there, back = law.brightness(Reflection(mu0, mu, phase)), law.brightness(Reflection(mu, mu0, phase))
    assert there == pytest.approx(back, rel=1e-12, abs=1e-300)


def rough_hapke(mu0, mu, phase, w, b0, h, g, roughness):
    """Hapke (1984), eqs. 47 to 51, written out for i <= e and i > e."""
    mp = mpmath
    i, e, t = mp.acos(mu0), mp.acos(mu), mp.tan(roughness)
    psi = mp.acos(max(-1, min(1, (mp.cos(phase) - mu0 * mu) / (mp.sin(i) * mp.sin(e)))))
    chi, f, half = 1 / mp.sqrt(1 + mp.pi * t**2), mp.exp(-2 * mp.tan(psi / 2)), mp.sin(psi / 2) ** 2

    def e1(x):
        return mp.exp(-2 / (mp.pi * t * mp.tan(x)))

    def e2(x):
        return mp.exp(-1 / (mp.pi * t**2 * mp.tan(x) ** 2))

    def eta(x):
        return chi * (mp.cos(x) + mp.sin(x) * t * e2(x) / (2 - e1(x)))

    if i <= e:
        d = 2 - e1(e) - psi / mp.pi * e1(i)
        mu0e = chi * (mu0 + mp.sin(i) * t * (mp.cos(psi) * e2(e) + half * e2(i)) / d)
        mue = chi * (mu + mp.sin(e) * t * (e2(e) - half * e2(i)) / d)
        below = 1 - f + f * chi * mu0 / eta(i)
    else:
        d = 2 - e1(i) - psi / mp.pi * e1(e)
        mu0e = chi * (mu0 + mp.sin(i) * t * (e2(i) - half * e2(e)) / d)
        mue = chi * (mu + mp.sin(e) * t * (mp.cos(psi) * e2(i) + half * e2(e)) / d)
        below = 1 - f + f * chi * mu / eta(e)
    shadowing = mue / eta(e) * mu0 / eta(i) * chi / below
    return w / 4 * mu * mu0e / (mu0e + mue) * hapke_bracket(mu0e, mue, phase, w, b0, h, g) * shadowing


def hapke_bracket(mu0, mu, phase, w, b0, h, g):
    surge = b0 / (1 + mpmath.tan(phase / 2) / h)
    single = (1 - g**2) / (1 + 2 * g * mpmath.cos(phase) + g**2) ** mpmath.mpf("1.5")
    root = mpmath.sqrt(1 - w)
    multiple = (1 + 2 * mu0) / (1 + 2 * mu0 * root) * (1 + 2 * mu) / (1 + 2 * mu * root)
    return (1 + surge) * single + multiple - 1


def hapke(mu0, mu, phase, w, b0, h, g):
    return w / 4 * mu * mu0 / (mu0 + mu) * hapke_bracket(mu0, mu, phase, w, b0, h, g)


def phong(mu0, mu, phase, diffuse, specular, n):
    return mu0 * mu * (diffuse + specular * (n + 2) / 2 * max(0, 2 * mu0 * mu - mpmath.cos(phase)) ** n)


def halves(mu0, mu, phase):
    """Return n . h and v . h of the direction h midway between Sun and observer."""
    return (mu0 + mu) / mpmath.sqrt(2 * (1 + mpmath.cos(phase))), mpmath.sqrt((1 + mpmath.cos(phase)) / 2)


def cook_torrance(mu0, mu, phase, diffuse, specular, m, f0):
    nh, vh = halves(mu0, mu, phase)
    angle = mpmath.acos(min(1, nh))
    slopes = mpmath.exp(-(mpmath.tan(angle) ** 2) / m**2) / (mpmath.pi * m**2 * mpmath.cos(angle) ** 4)
    masking = min(1, 2 * nh * mu / vh, 2 * nh * mu0 / vh)
    sine = mpmath.sin(mpmath.acos(vh)) * (1 - mpmath.sqrt(f0)) / (1 + mpmath.sqrt(f0))  # refraction
    inside, outside = mpmath.asin(sine), mpmath.acos(vh)
    across = mpmath.sin(outside - inside) / mpmath.sin(outside + inside)
    along = mpmath.tan(outside - inside) / mpmath.tan(outside + inside)
    return diffuse * mu0 * mu + mpmath.pi * specular * slopes * masking * (across**2 + along**2) / 8


def ashikhmin_shirley(mu0, mu, phase, rho, f0, n):
    nh, vh = halves(mu0, mu, phase)
    fresnel = f0 + (1 - f0) * (1 - vh) ** 5
    diffuse = mpmath.mpf(28) / 23 * rho * (1 - f0) * (1 - (1 - mu0 / 2) ** 5) * (1 - (1 - mu / 2) ** 5)
    return mu0 * mu * (diffuse + (n + 1) / 8 * nh**n * fresnel / (vh * max(mu0, mu)))


def kaasalainen(mu0, mu, phase, c, a, d, k):
    return (a * mpmath.exp(-phase / d) + k * phase + 1) * mu0 * mu * (1 / (mu0 + mu) + c)


FORMULAS = [
    (Lambert, (0.3,), lambda mu0, mu, _, albedo: albedo * mu0 * mu),
    (LommelSeeliger, (0.2,), lambda mu0, mu, _, w: w / 4 * mu0 * mu / (mu0 + mu)),
    (LambertLommelSeeliger, (0.1, 0.5, 0.1, -0.3), kaasalainen),
    (Minnaert, (0.3, 0.6), lambda mu0, mu, _, albedo, k: albedo * mu0**k * mu**k),
    (LunarLambert, (0.25, 0.7), lambda mu0, mu, _, a, L: a * mu * (2 * L * mu0 / (mu0 + mu) + (1 - L) * mu0)),
    (Hapke, (0.33, 1.2, 0.04, -0.3), hapke),
    (Hapke, (0.33, 1.2, 0.04, -0.3, 0.35), rough_hapke),
    (Hapke, (0.6, 0.3, 0.1, 0.2, 0.05), rough_hapke),
    (Phong, (0.3, 0.4, 20.0), phong),
    (CookTorrance, (0.3, 0.5, 0.3, 0.2), cook_torrance),
    (AshikhminShirley, (0.4, 0.3, 30.0), ashikhmin_shirley),
]
ANGLES = [(0.3, 0.8, 1.0), (0.95, 0.7, 2.0), (0.8, 0.3, 1.0), (0.05, 0.9, 3.0), (0.6, 0.6, 1e-3), (0.5, 0.02, 0.1)]
"""Cosines of incidence and emission, and the azimuth between both planes."""


@pytest.mark.parametrize(("law", "numbers", "formula"), FORMULAS, ids=lambda x: getattr(x, "__name__", ""))
def test_formulas_have_fifteen_digits(law, numbers, formula):
    """Angles of the plane of light near 1e-3 are wrong by 1e-13 of themselves, as the cosines are rounded."""
    with mpmath.workdps(40):
        for mu0, mu, azimuth in ANGLES:
            sines = mpmath.sqrt((1 - mpmath.mpf(mu0) ** 2) * (1 - mpmath.mpf(mu) ** 2))
            phase = float(mpmath.acos(mu0 * mpmath.mpf(mu) + sines * mpmath.cos(azimuth)))
            exact = formula(*map(mpmath.mpf, (mu0, mu, phase, *numbers)))
            found = law(*numbers).brightness(Reflection(mu0, mu, phase))
            assert found == pytest.approx(float(exact), rel=1e-14, abs=0)
            wide = law(*numbers).with_numbers(mpmath.mpf(float(x)) for x in law(*numbers).numbers)
            value = wide.brightness(Reflection(*map(mpmath.mpf, (mu0, mu, phase))))
            assert mpmath.almosteq(value, exact, rel_eps=1e-15)


def test_laws_are_for_arrays_and_members():
    law = Hapke([0.2, 0.3], 1.2, 0.04, -0.3, 0.1)
    mu0, mu = np.array([0.3, 0.6, 0.9]), 0.5
    values: Any = law.with_axes(2).brightness(Reflection(mu0, mu, 0.7))
    assert values.shape == (2, 3)
    alone = Hapke(0.3, 1.2, 0.04, -0.3, 0.1).brightness(Reflection(0.9, mu, 0.7))
    assert values[1, 2] == pytest.approx(alone, rel=1e-15, abs=0)


def test_without_roughness_the_surface_is_smooth():
    light = Reflection(0.4, 0.7, 0.9)
    smooth, nearly = (Hapke(0.33, 1.2, 0.04, -0.3, angle).brightness(light) for angle in (0.0, 1e-9))
    assert nearly == pytest.approx(smooth, rel=1e-14, abs=0)


def test_phase_functions_multiply_the_law_of_lommel_and_seeliger():
    """The mean over the sphere of the function of Henyey and Greenstein is 1."""
    light = Reflection(0.4, 0.7, 0.9)
    plain = LommelSeeliger(0.3).brightness(light)
    assert LommelSeeliger(0.3, IsotropicPhase()).brightness(light) == plain
    g = -0.4
    factor = (1 - g**2) / (1 + 2 * g * np.cos(0.9) + g**2) ** 1.5
    function = HenyeyGreenstein(g)
    assert LommelSeeliger(0.3, function).brightness(light) == pytest.approx(factor * plain, rel=1e-14, abs=0)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    mean = 0.5 * weights @ np.asarray(function.value(Reflection(1.0, 1.0, np.arccos(nodes))))
    assert mean == pytest.approx(1.0, rel=1e-13, abs=0)
    with pytest.raises(TypeError, match="phase must be a PhaseFunction, got"):
        LommelSeeliger(0.3, 0.5)


def test_lambert_is_a_case_of_other_laws():
    light = Reflection(0.4, 0.7, 0.9)
    value = Lambert(0.3).brightness(light)
    for law in (Minnaert(0.3, 1.0), LunarLambert(0.3, 0.0), Phong(0.3, 0.0, 2.0), CookTorrance(0.3, 0.0, 0.2, 0.1)):
        assert law.brightness(light) == pytest.approx(value, rel=1e-15, abs=0)


def user_law(formula):
    """Return a law of a user with a formula, made from an albedo."""
    return type("Tinted", (ScatteringLaw,), {"__annotations__": {"albedo": "float"}, "brightness": formula})


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (
            lambda law, light: law.albedo * light.mu0 * light.mu**2,
            r"Tinted\.brightness should be symmetric in mu0 and mu, got a relative difference of 0\.\d+\.",
        ),
        (
            lambda law, light: -law.albedo * light.mu0 * light.mu,
            r"Tinted\.brightness should not be negative, got -0\.\d+\.",
        ),
        (
            lambda law, light: 3 * law.albedo * light.mu0 * light.mu,
            r"Tinted\.brightness should reflect at most the light that arrives, got 1\.5 times this light\.",
        ),
    ],
    ids=["reciprocity", "sign", "energy"],
)
def test_a_law_that_is_not_physical_warns_once(formula, message):
    with pytest.warns(UserWarning, match=message) as found:
        law = user_law(formula)(0.5)
    assert len(found) == 1
    assert found[0].filename == __file__
    with pytest.warns(UserWarning, match=message):
        user_law(formula)([0.1, 0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        law.with_numbers([0.4]).brightness(Reflection(0.5, 0.5, 0.1))
        Velvet(1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Lambert(1.5), r"albedo must be at most 1, got 1\.5\."),
        (lambda: LommelSeeliger(-0.1), r"albedo must not be negative, got -0\.1\."),
        (lambda: LambertLommelSeeliger(0.1, 0.5, 0.0, 0.0), r"d must be positive, got 0\.0\."),
        (lambda: LambertLommelSeeliger(-0.1), r"c must not be negative, got -0\.1\."),
        (lambda: Minnaert(0.1, 0.0), r"k must be positive, got 0\.0\."),
        (lambda: Minnaert(-0.1, 0.5), r"albedo must not be negative, got -0\.1\."),
        (lambda: LunarLambert(0.1, 1.1), r"L must be at most 1, got 1\.1\."),
        (lambda: Hapke(1.1, 1.0, 0.1, 0.0), r"w must be at most 1, got 1\.1\."),
        (lambda: Hapke(0.1, -1.0, 0.1, 0.0), r"b0 must not be negative, got -1\.0\."),
        (lambda: Hapke(0.1, 1.0, 0.0, 0.0), r"h must be positive, got 0\.0\."),
        (lambda: Hapke(0.1, 1.0, 0.1, -1.0), r"g must be between -1 and 1, got -1\. All light goes one way at 1\."),
        (
            lambda: Hapke(0.1, 1.0, 0.1, 0.0, 20.0),
            r"roughness must be from 0 to below pi/2, got 20\. It is the mean slope",
        ),
        (lambda: Hapke(0.1, 1.0, 0.1, 0.0, -0.1), r"roughness must be from 0 to below pi/2, got -0\.1\."),
        (lambda: Phong(0.1, 1.2, 2.0), r"specular must be at most 1, got 1\.2\."),
        (lambda: Phong(0.1, 0.2, 0.0), r"n must be positive, got 0\.0\."),
        (lambda: CookTorrance(0.1, 0.2, 0.0, 0.1), r"m must be positive, got 0\.0\."),
        (lambda: CookTorrance(0.1, 0.2, 0.1, 1.0), r"f0 must be from 0 to below 1, got 1\. The refractive index"),
        (lambda: AshikhminShirley(0.1, 1.5, 2.0), r"f0 must be at most 1, got 1\.5\."),
    ],
)
def test_numbers_out_of_range_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
