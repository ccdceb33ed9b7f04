"""Gravity fields of bodies: their numbers, and what is none."""

import math
import re

import numpy as np
import pytest
from scipy.special import lpmv

import poinsot as pt

RANDOM = np.random.default_rng(5)


def coefficients(degree):
    C, S = np.tril(RANDOM.normal(size=(2, degree + 1, degree + 1)))
    C[0], C[1], S[0], S[1], S[:, 0] = 0, 0, 0, 0, 0
    C[0, 0] = 1
    return C, S


def test_normalisation_goes_both_ways():
    C, S = coefficients(12)
    field = pt.GravityField.from_normalized(2.0, 3.0, C, S)
    again = field.normalized
    assert np.allclose(again, (C, S), rtol=1e-15, atol=0)
    for n, m in ((2, 0), (2, 2), (5, 3), (12, 12)):
        factor = math.sqrt((2 - (m == 0)) * (2 * n + 1) * math.factorial(n - m) / math.factorial(n + m))
        assert field.C[n, m] == pytest.approx(factor * C[n, m], rel=1e-14, abs=0)
        assert field.S[n, m] == pytest.approx(factor * S[n, m], rel=1e-14, abs=0)


def test_normalised_members():
    (C, S), (c, s) = coefficients(4), coefficients(4)
    both = pt.GravityField.from_normalized([2.0, 1.0], 3.0, [C, c], [S, s])
    for member, (mass, one) in enumerate(((2.0, (C, S)), (1.0, (c, s)))):
        alone = pt.GravityField.from_normalized(mass, 3.0, *one)
        assert np.array_equal(both.C[member], alone.C)
        assert np.array_equal(both.S[member], alone.S)
    assert np.allclose(both.normalized[0], [C, c], rtol=1e-15, atol=0)
    assert both.truncated(3).C.shape == (2, 4, 4)
    shared = pt.GravityField.from_normalized(2.0, 3.0, [C, c], S)
    assert shared.S.shape == (5, 5)


@pytest.mark.parametrize("shape", [(5, 4), (5,), (), (2, 2, 5, 5), (3, 5, 4)])
def test_normalised_coefficients_are_squares(shape):
    with pytest.raises(ValueError, match=r"^C must have shape \((\d), \1\) or \(members, \1, \1\), got shape"):
        pt.GravityField.from_normalized(1.0, 1.0, np.zeros(shape), np.zeros(shape))


def test_the_flattening_of_the_earth():
    """C20 of EGM2008, -0.484165143790815e-3 normalised, is J2 = 1.0826e-3."""
    C = np.zeros((3, 3))
    C[2, 0] = -0.484165143790815e-3
    assert pt.GravityField.from_normalized(1.0, 1.0, C, 0 * C).C[2, 0] == pytest.approx(
        -1.0826261738e-3, rel=1e-10, abs=0
    )


@pytest.mark.parametrize("n", [2, 5])
def test_the_power_of_a_degree_is_its_mean_square_over_a_sphere(n):
    """By Gauss's rule in the sine of the latitude and equal weights in longitude, which are exact."""
    field = pt.GravityField(5, 2.0, 0.7, *coefficients(5))
    sines, weights = np.polynomial.legendre.leggauss(n + 1)
    longitudes = 2 * np.pi * np.arange(2 * n + 1) / (2 * n + 1)
    total = 0.0
    for m in range(n + 1):
        wave = field.C[n, m] * np.cos(m * longitudes) + field.S[n, m] * np.sin(m * longitudes)
        total = total + (-1) ** m * lpmv(m, n, sines)[:, None] * wave  # without the sign of Condon and Shortley
    mean = weights @ np.mean((0.7**n * total) ** 2, axis=1) / 2
    assert field.power(n) == pytest.approx(mean, rel=1e-14, abs=0)


def test_rows_and_lower_degrees():
    field = pt.GravityField(4, 2.0, 3.0, *coefficients(4), extent=3.5)
    lower = field.truncated(3)
    assert (lower.degree, lower.mass, lower.radius, lower.extent) == (3, 2.0, 3.0, 3.5)
    assert lower.row(3) == field.row(3) == [(field.C[3, m], field.S[3, m]) for m in range(4)]


def test_the_deviator_is_that_of_the_body():
    body = pt.Body.from_stokes(
        C20=-0.1, C22=0.02, C21=0.01, S21=-0.03, S22=0.015, polar_moment_factor=0.4, mass=2.0, radius=3.0
    )
    C, S = np.zeros((2, 3, 3))
    C[2], S[2] = (-0.1, 0.01, 0.02), (0, -0.03, 0.015)
    expected = body.inertia - np.trace(body.inertia) / 3 * np.eye(3)
    assert np.allclose(pt.GravityField(2, 2.0, 3.0, C, S).inertia_deviator, expected, rtol=0, atol=3e-14)
    both = pt.GravityField(2, [2.0, 1.0], 3.0, [C, 0 * C], [S, S])
    assert np.allclose(both.inertia_deviator[0], expected, rtol=0, atol=3e-14)
    assert both.inertia_deviator[1, 0, 1] == -2 * 9 * 0.015
    assert np.allclose(pt.GravityField(2, 2.0, 3.0, [C, 0 * C], S).inertia_deviator[0], expected, rtol=0, atol=2e-14)


C, S = coefficients(2)
ONE_OFF = C.copy()
ONE_OFF[1, 1] = 1e-3
DOUBLE, SINE = C.copy(), S.copy()
DOUBLE[0, 0], SINE[2, 0] = 2, 1e-9


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ((1, 1.0, 1.0, C[:2, :2], S[:2, :2]), "degree must be at least 2, got 1."),
        ((2, 0.0, 1.0, C, S), "mass must be positive, got 0.0."),
        ((2, 1.0, -1.0, C, S), "radius must be positive, got -1.0."),
        ((2, 1.0, 1.0, C, S, -2.0), "extent must not be negative, got -2.0. 0 means unknown."),
        ((3, 1.0, 1.0, C, S), "C must have shape (4, 4) or (members, 4, 4), got shape (3, 3)."),
        ((2, 1.0, 1.0, DOUBLE, S), "C_00 must be 1, or 0 where it is left out, got 2."),
        ((2, 1.0, 1.0, [C, 0 * C, DOUBLE], S), "C_00 must be 1, or 0 where it is left out, got 2."),
        ((2, 1.0, 1.0, C, SINE), "S must be zero in order 0, but S_20 is not."),
        ((2, 1.0, 1.0, C, [S, SINE]), "S must be zero in order 0, but S_20 is not."),
        (
            (2, 1.0, 1.0, ONE_OFF, S),
            "C and S must be zero in degree 1, but they are not. Refer them to the centre of mass.",
        ),
    ],
)
def test_what_is_no_field(wrong, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.GravityField(*wrong)


@pytest.mark.parametrize("degree", [1, 5])
def test_what_is_no_lower_degree(degree):
    with pytest.raises(ValueError, match=rf"^degree must be from 2 to 4, the degree of the field, got {degree}\.$"):
        pt.GravityField(4, 1.0, 1.0, *coefficients(4)).truncated(degree)


@pytest.mark.parametrize(("degree", "came"), [(3.0, "float 3.0"), (True, "bool True"), ("3", "str '3'")])
def test_a_degree_is_a_whole_number(degree, came):
    field = pt.GravityField(4, 1.0, 1.0, *coefficients(4))
    for ask in (field.truncated, pt.shapes.Ellipsoid((1, 2, 3), mass=1.0).field):
        with pytest.raises(
            TypeError, match=f"^{re.escape(f'degree must be a whole number of at most 63 bits, got {came}.')}$"
        ):
            ask(degree)
    assert field.truncated(np.int64(3)).degree == 3
