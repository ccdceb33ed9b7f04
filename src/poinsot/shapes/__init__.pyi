"""The public names of poinsot.shapes, by the module of each, as `make face` writes them."""

from .assembly import Assembly
from .mascons import Mascons
from .mesh import Mesh
from .shape import Shape
from .solids import Cylinder, Ellipsoid
from .visibility import illuminated_areas, illuminated_faces

__all__ = [
    "Assembly",
    "Cylinder",
    "Ellipsoid",
    "Mascons",
    "Mesh",
    "Shape",
    "illuminated_areas",
    "illuminated_faces",
]
