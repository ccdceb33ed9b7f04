"""Laws of scattering: reciprocity, energy, exact formulas, kinds of scalars, messages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from poinsot import functions
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
