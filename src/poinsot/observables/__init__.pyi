"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from ..shapes.scattering import (
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
from .readings import Readings

__all__ = [
    "AshikhminShirley",
    "CookTorrance",
    "Hapke",
    "Lambert",
    "LambertLommelSeeliger",
    "LommelSeeliger",
    "LunarLambert",
    "Minnaert",
    "Phong",
    "Readings",
    "Reflection",
    "ScatteringLaw",
]
