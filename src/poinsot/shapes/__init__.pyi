"""Shapes, of which bodies and gravity fields are made, by the module of each; imported when they are used first."""

from .assembly import Assembly
from .mascons import Mascons
from .mesh import Mesh
from .shape import Shape
from .solids import Cylinder, Ellipsoid

__all__ = [
    "Assembly",
    "Cylinder",
    "Ellipsoid",
    "Mascons",
    "Mesh",
    "Shape",
]
