"""Gravitational parameters and radii of the Sun, the planets and the Moon."""

from __future__ import annotations

from poinsot.printable import quoted

__all__ = ["MU", "attractor_mu", "attractor_radius"]

MU = {
    "SUN": 132712440041.27942,
    "MERCURY": 22031.868551400003,
    "VENUS": 324858.592,
    "EARTH": 398600.43550702266,
    "MOON": 4902.8001184575496,
    "MARS": 42828.37362069909,
    "JUPITER": 126686531.9003704,
    "SATURN": 37931206.23436167,
    "URANUS": 5793951.256527211,
    "NEPTUNE": 6835103.145462294,
    "PLUTO": 869.6138177608748,
    "EARTH BARYCENTER": 403503.23562548019,
    "MARS BARYCENTER": 42828.375815756102,
    "JUPITER BARYCENTER": 126712764.09999998,
    "SATURN BARYCENTER": 37940584.841799997,
    "URANUS BARYCENTER": 5794556.3999999985,
    "NEPTUNE BARYCENTER": 6836527.1005803989,
    "PLUTO BARYCENTER": 975.5,
}
"""Gravitational parameters of DE440, km3/s2 (Park et al. 2021; NAIF's gm_de440.tpc). Barycenters include the moons."""

RADIUS = {
    "SUN": 695700.0,
    "MERCURY": 2440.53,
    "VENUS": 6051.8,
    "EARTH": 6378.1366,
    "MOON": 1737.4,
    "MARS": 3396.19,
    "JUPITER": 71492.0,
    "SATURN": 60268.0,
    "URANUS": 25559.0,
    "NEPTUNE": 24764.0,
    "PLUTO": 1188.3,
}
"""Equatorial radii, km; IAU working group on cartographic coordinates (Archinal et al. 2018)."""

NAMES = {
    "MERCURY BARYCENTER": "MERCURY",
    "VENUS BARYCENTER": "VENUS",
    "EARTH-MOON BARYCENTER": "EARTH BARYCENTER",
    "EARTH MOON BARYCENTER": "EARTH BARYCENTER",
}
"""Further names of attractors."""


def attractor_mu(name: str, mu: float | None) -> float:
    """Return `mu` if it is given, otherwise the gravitational parameter of a named attractor, km3/s2."""
    if mu is not None:
        return mu
    known = NAMES.get(name.upper(), name.upper())
    if known not in MU:
        raise ValueError(
            f"mu must be given for an attractor that is not the Sun, a planet or the Moon, got {quoted(name)}."
        )
    return MU[known]


def attractor_radius(name: str) -> float:
    """Return the equatorial radius of a named attractor, km; 0, a point, for a barycentre or an unknown name."""
    return RADIUS.get(NAMES.get(name.upper(), name.upper()), 0.0)
