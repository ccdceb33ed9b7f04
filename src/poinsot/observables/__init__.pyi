"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from .scattering import (
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
    "Reflection",
    "ScatteringLaw",
]
