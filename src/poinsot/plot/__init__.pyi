"""The public names of poinsot.plot, by the module of each, as `make face` writes them."""

from .continuation import branch
from .frequencies import spectrum
from .geometry import herpolhode, poinsot_construction, polhode
from .libration import librations
from .maps import chaos, map  # noqa: A004
from .pair_orbit import mutual_orbit
from .sections import section
from .sphere import momentum_sphere
from .state_transition import uncertainty
from .time_series import (

__all__ = [
    "(",
    "branch",
    "chaos",
    "herpolhode",
    "librations",
    "map  # noqa: A004",
    "momentum_sphere",
    "mutual_orbit",
    "poinsot_construction",
    "polhode",
    "section",
    "spectrum",
    "uncertainty",
]
