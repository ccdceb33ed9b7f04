"""What a scenario can name: the package's bodies, forces, orbits and fields, and the other ways to them.

Classes are found by themselves, and read by their annotated fields: a new force needs no line here.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from poinsot.errors import real_array
from poinsot.files.bodies.fields import read_field
from poinsot.files.bodies.meshes import read_mesh
from poinsot.files.orbits.oem import read_oem
from poinsot.files.orbits.spk import spice_orbit
from poinsot.files.orbits.tle import omm_orbit, tle_orbit
from poinsot.forces.damping import LinearDamping
from poinsot.forces.ellipsoid import EllipsoidGravity
from poinsot.forces.gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from poinsot.forces.mascons import MasconGravity
from poinsot.mechanics.attitude import quaternion_from_matrix
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.frame import RotatingFrame
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.parameters import Parametric, Table, kinds_of
from poinsot.orbits.ephemeris import Ephemeris, PolynomialArc
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.fixed import FixedPosition
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.orbits.lagrange import LagrangePointPath
from poinsot.orbits.planets import planet_orbit
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.orbits.restricted_three_body import ThreeBodyPath
from poinsot.orbits.sums import orbit_sum
from poinsot.orbits.two_body import two_body_orbit
from poinsot.quantities import ANGLES
from poinsot.shapes.assembly import Assembly
from poinsot.shapes.mascons import Mascons
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.solids import Cylinder, Ellipsoid

__all__ = ["Key", "Maker", "kind_of", "makers"]

CLASSES: dict[str, tuple[Any, ...]] = {
    "body": (Body,),
    "force": (
        UniformGravity,
        GravityGradient,
        HarmonicGravity,
        Oblateness,
        MasconGravity,
        EllipsoidGravity,
        LinearDamping,
    ),
    "orbit": (Orbit, FixedPosition, ThreeBodyPath),
    "field": (GravityField,),
}
"""Classes of the package, found with their subclasses."""

FUNCTIONS: dict[str, tuple[Callable[..., Any], ...]] = {
    "body": (
        Body.from_inertia,
        Body.from_stokes,
        Body.from_ratios,
        Body.ellipsoid,
        Body.box,
        Body.cylinder,
        Body.point_masses,
        Body.from_shape,
    ),
    "force": (),
    "orbit": (
        KeplerOrbit.from_elements,
        KeplerOrbit.from_vectors,
        EscapeOrbit.from_elements,
        EscapeOrbit.from_vectors,
        PrecessingOrbit.from_mean_motion,
        two_body_orbit,
        LagrangePointPath,
        planet_orbit,
        tle_orbit,
        omm_orbit,
        orbit_sum,
        Ephemeris.from_table,
        read_oem,
        spice_orbit,
    ),
    "field": (GravityField.from_normalized, read_field),
    "frame": (RotatingFrame,),
    "shape": (Mesh, Mesh.box, Ellipsoid, Cylinder, Mascons, read_mesh, Assembly),
}
"""Other ways to them."""

NOT_FOR_FILES = (PolynomialArc,)

RATES = ("rate", "node_rate", "periapsis_rate", "anomaly_rate", "mean_motion", "omega_body", "omega_space")
TIMES = ("epoch", "time", "time_since_periapsis", "start", "stop", "step", "values", "times", "knots")


@dataclasses.dataclass(frozen=True)
class Key:
    """A key of a table.

    Attributes
    ----------
    kind : str
        "number", "angle", "rate", "time", "text", "texts", "whole", "truth", "file", "files", "orbit", "orbits",
        "field", "shape" or "shapes".
    rank : int
        Of the array of a number: 0 for a scalar, 1 for a vector.
    """

    name: str
    kind: str
    rank: int = 0
    required: bool = True
    default: Any = None
    help: str = ""


@dataclasses.dataclass(frozen=True)
class Maker:
    """A way to make a part of a scenario from the keys of its table."""

    name: str
    call: Callable[..., Any]
    keys: tuple[Key, ...]
    help: str
    takes_calendar: bool = False


@functools.cache
def makers(group: str) -> dict[str, Maker]:
    """Return what a table of a group may name as its type, by name."""
    if group == "part":
        return {name: maker for name, maker in makers("shape").items() if maker.call is not Assembly}
    found = [_of_class(cls) for base in CLASSES.get(group, ()) for cls in _concrete(base)]
    others = list(map(_of_function, FUNCTIONS[group]))
    if group == "orbit":
        others.append(dataclasses.replace(_of_function(stored_ephemeris), name="Ephemeris"))
    if group == "field":
        others.append(dataclasses.replace(_of_function(field_of_shape), name="Shape.field"))
    if group == "shape":
        others = [maker if maker.call is Assembly else _placed(maker) for maker in others]
    return {maker.name: maker for maker in sorted((*found, *others), key=lambda maker: maker.name)}


def kind_of(name: str) -> str:
    """Return what a number of this name is: "angle", "rate", "time", or "number" in the user's own units."""
    kinds = (("angle", ANGLES), ("rate", RATES), ("time", TIMES))
    return next((kind for kind, names in kinds if name in names), "number")


def _concrete(base: Any) -> Iterator[type[Parametric]]:
    """Yield a class and its subclasses, those of the package of which there can be instances by parameters."""
    own = base.__module__.partition(".")[0] == "poinsot" and not base.__name__.startswith("_")
    if own and not inspect.isabstract(base) and base not in NOT_FOR_FILES:
        kinds = kinds_of(base).values()
        if not any(isinstance(kind, type) and issubclass(kind, Table) for kind in kinds):
            yield base
    for subclass in base.__subclasses__():
        yield from _concrete(subclass)


def _of_class(cls: type[Parametric]) -> Maker:
    said = _described(cls.__doc__)
    keys = tuple(
        _key_of_field(field, kinds_of(cls)[field.name], said.get(field.name, ""))
        for field in dataclasses.fields(cls)  # type: ignore[arg-type]
    )
    return Maker(cls.__name__, cls, keys, _first_line(cls.__doc__))


def _key_of_field(field: Any, kind: Any, said: str) -> Key:
    required = field.default is dataclasses.MISSING
    rest = (required, None if required else field.default, said)
    if isinstance(kind, tuple):
        return Key(field.name, kind_of(field.name), len(kind), *rest)
    words = {int: "whole", bool: "truth", str: "text"}
    if kind in words:
        return Key(field.name, words[kind], 0, *rest)
    return Key(field.name, "field" if issubclass(kind, GravityField) else "orbit", 0, *rest)


def _of_function(call: Callable[..., Any]) -> Maker:
    said = _described(call.__doc__)
    parameters = inspect.signature(call).parameters.values()
    keys = tuple(_key_of_parameter(p, said.get(p.name, "")) for p in parameters if "Calendar" not in str(p.annotation))
    return Maker(call.__qualname__, call, keys, _first_line(call.__doc__), len(keys) < len(parameters))


def _key_of_parameter(parameter: inspect.Parameter, said: str) -> Key:
    annotation, name = str(parameter.annotation), parameter.name
    required = parameter.default is inspect.Parameter.empty
    rest = (required, None if required else parameter.default, said)
    if parameter.kind is inspect.Parameter.VAR_POSITIONAL:
        return Key(name, "orbits", 0, True, None, said)
    if name in WORDS or annotation.endswith("Orbit"):
        return Key(name, WORDS.get(name, "orbit"), 0, *rest)
    if "str" in annotation:
        return Key(name, "texts" if "Sequence" in annotation else "text", 0, *rest)
    if annotation.partition(" ")[0] in ("int", "bool"):
        return Key(name, "whole" if annotation.startswith("int") else "truth", 0, *rest)
    rank = RANKS.get(name, 1) if "ArrayLike" in annotation else 0
    return Key(name, kind_of(name), rank, *rest)


WORDS = {"path": "file", "kernels": "files", "shape": "shape", "parts": "shapes"}
"""Kinds of parameters by their names."""

RANKS = dict.fromkeys(("tensor", "positions", "velocities", "vertices", "faces", "matrix", "C", "S", "coefficients"), 2)
"""Of arrays that are no vectors, by the names of their parameters."""


def field_of_shape(shape: Any, degree: int, radius: float | None = None) -> GravityField:
    """Return the gravity field of a shape about its centre of mass, as `Shape.field` does.

    Parameters
    ----------
    degree : int
        From 2 to 80.
    radius : float, optional
        The length to which the coefficients refer; default: the circumscribing radius.
    """
    field: GravityField = shape.field(degree, radius)
    return field


def stored_ephemeris(
    mu: float,
    knots: ArrayLike,
    coefficients: ArrayLike,
    reference_frame: str,
    origin: str,
    error: float | None = None,
    radius: float = 0.0,
    dated: bool = True,
    *,
    calendar: Calendar | None = None,
) -> Ephemeris:
    """Return an ephemeris from what it is made of.

    Parameters
    ----------
    knots : array (n + 1,)
    coefficients : array (n, 3, terms)
        Of Chebyshev's polynomials in each piece, positions from the attractor.
    reference_frame, origin, error, radius
        As the attributes of `Ephemeris`.
    dated : bool
        Whether its times are those of the calendar.
    """
    times = real_array("knots", knots, (None,))
    if times.size < 2 or np.any(np.diff(times) <= 0):
        raise ValueError("knots must be two or more that rise, got others.")
    polynomials = real_array("coefficients", coefficients, (times.size - 1, 3, None))
    if not polynomials.size:
        raise ValueError("coefficients must not be empty, but there are none.")
    labels = (reference_frame, origin, calendar if dated else None)
    pieces = kinds_of(Ephemeris)["pieces"](times, polynomials, math.nan if error is None else float(error), labels)
    return Ephemeris(mu, pieces=pieces, radius=radius)


PLACE = (
    Key("position", "number", 1, False, help="Where the origin of the shape goes, along the body axes."),
    Key("quaternion", "number", 1, False, help="Turns the shape before: scalar first, its axes to the body axes."),
    Key("matrix", "number", 2, False, help="Turns the shape before, as a matrix in place of a quaternion."),
)


def _placed(maker: Maker) -> Maker:
    """Return the maker of a shape that can be moved."""

    def call(position: Any = (0, 0, 0), quaternion: Any = None, matrix: Any = None, **fields: Any) -> Any:
        if quaternion is not None and matrix is not None:
            raise ValueError("matrix must not be beside quaternion, but it is.")
        if "faces" in fields:
            fields["faces"] = _whole(fields["faces"])
        shape = maker.call(**fields)
        if matrix is not None:
            quaternion_from_matrix(real_array("matrix", matrix, (3, 3)))
            return shape._placed(real_array("position", position, (3,)), np.asarray(matrix))
        if quaternion is None and not np.any(position):
            return shape
        return shape.moved(position, (1, 0, 0, 0) if quaternion is None else quaternion)

    return dataclasses.replace(maker, call=call, keys=(*maker.keys, *PLACE))


def _whole(values: Any) -> Any:
    """Return numbers of a file as whole ones; others as they are, to be refused."""
    array = np.asarray(values)
    return array.astype(np.int64) if np.all(array == np.rint(array)) and np.all(np.abs(array) < 2**53) else array


def _first_line(doc: str | None) -> str:
    return (doc or "").strip().split("\n", 1)[0]


def _described(doc: str | None) -> dict[str, str]:
    """Return what a docstring says of its parameters, by name."""
    _, _, section = inspect.cleandoc(doc or "").partition("Parameters\n----------\n")
    section = re.split(r"\n\n[A-Z]\w+\n---", section)[0]
    said: dict[str, str] = {}
    for entry in re.split(r"\n(?=\S)", section):
        heading, _, body = entry.partition("\n")
        names = heading.partition(" : ")[0]
        said |= {name.strip("* "): " ".join(body.split()) for name in names.split(",")}
    return said
