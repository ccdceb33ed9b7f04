"""Curves of equal energy of a free body, in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import poinsot as pt
from poinsot.analysis import polhodes

triangle = st.tuples(st.floats(0.1, 1), st.floats(0.1, 1), st.floats(0.1, 1)).map(
    lambda a: np.array([a[1] + a[2], a[0] + a[2], a[0] + a[1]])
)
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1)


@given(triangle, directions)
def test_energy_curves_go_through_their_point_and_keep_energy(moments, direction):
    n = np.array(direction) / np.linalg.norm(direction)
    curve, D = polhodes.energy_curve(moments, n), n**2 @ (1 / moments)
    assert np.all(np.isfinite(curve))
    assert np.allclose(np.linalg.norm(curve, axis=-1), 1, rtol=0, atol=1e-14)
    assert np.allclose(curve**2 @ (1 / moments), D, rtol=1e-14, atol=0)
    k = polhodes.axis_encircled(moments, D)
    assert np.all(curve[:, k] * np.copysign(1, n[k] + 0.0) >= 0)


@pytest.mark.parametrize("gap", [0, 1e-15, 1e-13, 1e-10, 1e-6])
@pytest.mark.parametrize("small", [True, False])
def test_curves_of_nearly_symmetric_bodies(gap, small):
    moments = np.array([1.0, 1.0 + gap, 0.6 if small else 1.7])
    settled, _ = polhodes.principal(pt.Body(moments))
    assert (settled[0] == settled[1]) == (gap < 1e-14)
    assert len(polhodes.separatrices(settled)) == (0 if gap < 1e-14 else 2)
    d = 1 / settled
    for k in range(3):
        for n in polhodes.energy_curves(settled, k):
            assert np.allclose(np.linalg.norm(n, axis=-1), 1, rtol=0, atol=1e-14)
            assert np.allclose(n**2 @ d, n[0] ** 2 @ d, rtol=1e-14, atol=0)


def test_radii_of_the_herpolhode_are_the_extremes_along_the_polhode(rng):
    for _ in range(20):
        moments, g = rng.uniform(1, 1.9, 3), rng.normal(size=3)
        G = np.linalg.norm(g)
        omega = G * polhodes.energy_curve(moments, g / G) / moments
        height = np.sum(moments * omega**2, axis=-1) / G
        rho = np.sqrt(np.sum(omega**2, axis=-1) - height**2)
        assert np.allclose(polhodes.herpolhode_radii(moments, g), (np.min(rho), np.max(rho)), rtol=0, atol=1e-7 * G)


def test_smaller_radius_on_a_separatrix_is_zero():
    moments = np.array([2.0, 2.5, 3.5])
    g = polhodes.separatrices(moments)[0][40]
    small, large = polhodes.herpolhode_radii(moments, g)
    assert small < 1e-8 < large
