"""Gravitational parameters and radii of attractors by name."""

import pytest

from poinsot.orbits.attractors import attractor_mu, attractor_radius

PUBLISHED = {"earth": (398600.4418, 6378.1366), "SUN": (132712440041.9, 695700.0), "Moon": (4902.8, 1737.4)}
"""km3/s2, from the IERS conventions (2010), Table 1.1, and IAU resolution 2015 B3; km, from Archinal et al. (2018)."""


@pytest.mark.parametrize("name", PUBLISHED)
def test_numbers_of_attractors(name):
    mu, radius = PUBLISHED[name]
    assert attractor_mu(name, None) == pytest.approx(mu, rel=1e-5, abs=0)
    assert attractor_radius(name) == pytest.approx(radius, rel=1e-5, abs=0)
    assert attractor_mu(name, 2.5) == 2.5


def test_barycentres():
    assert attractor_mu("Earth-Moon barycenter", None) == pytest.approx(
        attractor_mu("Earth", None) + attractor_mu("Moon", None), rel=1e-7, abs=0
    )
    assert attractor_radius("Earth-Moon barycenter") == 0.0


def test_unknown_attractor():
    with pytest.raises(ValueError, match="mu must be given for an attractor that is not the Sun, a planet or the Moon"):
        attractor_mu("Vulcan", None)
