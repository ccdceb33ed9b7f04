"""Laws of scattering as public names: an observable that reads brightness contains a law."""

from poinsot.shapes.scattering import (
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
