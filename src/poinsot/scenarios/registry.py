"""Parts that a scenario can name: every body, force, orbit, shape and gravity field, and the functions that make one.

The registry finds classes among subclasses, also classes of users, and functions in modules. Their annotations define
the keys. A new module of the package requires no entry.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import inspect
import pkgutil
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import filterfalse
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, NamedTuple, Self, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

import poinsot
from poinsot.checked import hint_of, namespace_of
from poinsot.docstrings import parameter_entries
from poinsot.errors import real_array
from poinsot.forces.facets import Facets
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.frame import RotatingFrame
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Force
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import BODIES, TwoBodies
from poinsot.orbits.restricted_three_body import CirclingPair
from poinsot.orbits.rotation import RotationModel
from poinsot.quantities import OR_NUMBER, Along, extras_of, quantity_of
from poinsot.records.calendar import Calendar
from poinsot.records.parameters import Parametric
from poinsot.shapes.assembly import Assembly
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.shape import Shape
from poinsot.shapes.solids import Ellipsoid
from poinsot.subclasses import is_own, subclasses

__all__ = [
    "RENAMED",
    "RENAMED_TYPES",
    "Group",
    "Key",
    "Maker",
    "Planned",
    "default_of",
    "keys_of",
    "known_classes",
    "makers",
]

Group = str | type
"""Kind of a table: one of `BASES`, or the class of a record that is a field of another record."""

BASES: dict[Group, tuple[type, ...]] = {
    "body": (Body, TwoBodies),
    "force": (Force,),
    "orbit": (Orbit, CirclingPair),
    "frame": (RotatingFrame, RotationModel),
    "shape": (Shape,),
    "outline": (Mesh, Ellipsoid, Facets),
    "observable": (Observable,),
}

DEFAULTS: dict[Group, str] = {"body": "Body", "rigid": "Body", "frame": "RotatingFrame"}
"""Default types of tables. The default type of a record is its class."""

PACKAGES = ("control", "forces", "observables", "orbits", "parts", "shapes", "files.bodies", "files.orbits")
"""Their modules have the classes that ship, and functions that make one."""

INSTRUMENTS = "poinsot.observables."
"""Beginning of the names of the modules of observables that a scenario can name."""

RENAMED_TYPES = {"in_metres": "kilometres_to_metres", "orbit_sum": "composite_orbit"}
"""Present types of tables, by the former name in scenario files and results of earlier versions."""

RENAMED = {("Sampled", "phase"): "offset"}
"""Present names of keys, by the present type of their table and the former name. Only present names are written."""


@dataclasses.dataclass(frozen=True)
class Key:
    """A key of a table.

    Attributes
    ----------
    kind : str
        "number", "angle", "rate", "time", "duration", "text", "texts", "whole", "truth", "file", "files", "orbit",
        "orbits", "record", "records" (tables of a group), "record or records", or "named": numbers by name; others are
        in the schema alone. An "orbit" with a group is the name of an orbit or a table of the group.
    rank : int
        Of the array of a number: 0 for a scalar, 1 for a vector.
    choices, limits : tuple
        The words or the ends of names that a text can be, and the least and the largest whole number.
    keys : tuple of Key
        Of a table.
    group : str or type
        What the table is of that a record is made from.
    spread : bool
        Whether a call takes several one by one.
    or_number : bool
        Whether one number can stand for all of an array.
    """

    name: str
    kind: str
    help: str = ""
    rank: int = 0
    required: bool = False
    default: float | str | None = None
    choices: tuple[str, ...] = ()
    limits: tuple[int, int] | None = None
    keys: tuple[Key, ...] = ()
    group: Group = ""
    spread: bool = False
    or_number: bool = False


@dataclasses.dataclass(frozen=True)
class Maker:
    """A way to make a part of a scenario from the keys of its table."""

    name: str
    call: Callable[..., Any]
    keys: tuple[Key, ...]
    help: str
    takes_calendar: bool = False


def makers(group: Group) -> dict[str, Maker]:
    """Return the makers that a table of a group can select as its type. Makers of the package precede others."""
    if group == "part":
        return {name: maker for name, maker in makers("shape").items() if maker.call is not Assembly}
    if group == "rigid":
        return {name: maker for name, maker in makers("body").items() if maker.call is not TwoBodies}
    return _makers(group, tuple(_subclasses(_bases(group))))


def _bases(group: Group) -> tuple[type, ...]:
    return (group,) if isinstance(group, type) else BASES[group]


def default_of(group: Group) -> str | None:
    """Return the default type of a table of a group, or None if the table must state its type."""
    if isinstance(group, type):
        return None if inspect.isabstract(group) else group.__name__
    return DEFAULTS.get(group)


def keys_of(call: Callable[..., Any], *left_out: str) -> tuple[Key, ...]:
    """Return the keys of the arguments of a call but for some that a table has not."""
    maker = _maker(call, call.__name__, left_out)
    return maker.keys if maker else ()


def known_classes() -> tuple[type, ...]:
    """Return all classes that a scenario can name now: a user may define one at any time."""
    return tuple(cls for bases in (*BASES.values(), (Parametric,)) for cls in _subclasses(bases))


@functools.lru_cache(maxsize=64)
def _makers(group: Group, classes: tuple[type, ...]) -> dict[str, Maker]:
    ways: list[tuple[str, Callable[..., Any]]] = [(cls.__name__, cls) for cls in classes if not inspect.isabstract(cls)]
    for cls in filterfalse(inspect.isabstract, classes):
        made = [name for name, found in _members(cls).items() if isinstance(found, classmethod | staticmethod)]
        ways += [(f"{cls.__name__}.{name}", getattr(cls, name)) for name in made if not name.startswith("_")]
    named = (getattr(module, name) for module in _import_all() for name in module.__all__)
    ways += [(thing.__name__, thing) for thing in named if inspect.isfunction(thing)]
    ways += [("Body.from_shape", body_of_shape), ("Shape.field", field_of_shape)]
    found = [maker for name, way in ways if _makes(way, _bases(group)) and (maker := _maker(way, name))]
    if group in ("shape", "outline"):
        found = [maker if _makes(maker.call, (Assembly, Facets)) else _placed(maker) for maker in found]
    if group in ("force", "observable"):
        found = [_on_one_of_two(maker) for maker in found]
    if group == "observable":
        found = [_planned(maker) for maker in found]
    known = {maker.name: maker for maker in sorted(found, key=lambda maker: is_own(maker.call))}
    return {name: known[name] for name in sorted(known)}


def _members(cls: type) -> dict[str, Any]:
    """Return the attributes of a class, with those inherited from abstract classes, of which there are no objects."""
    owners = [each for each in reversed(cls.__mro__) if each is cls or inspect.isabstract(each)]
    return {name: found for owner in owners for name, found in vars(owner).items()}


def _subclasses(bases: tuple[type, ...]) -> Iterator[type]:
    """Yield the public ones of some classes and all their subclasses, each once."""
    _import_all()
    yield from (cls for cls in subclasses(*bases) if _is_public(cls) and cls is not Part)


def _is_public(thing: Any) -> bool:
    if is_own(thing):
        if issubclass(thing, Observable) and not thing.__module__.startswith(INSTRUMENTS):
            return False  # an observable of one of two bodies, or recorded in a file
        return thing.__name__ in sys.modules[thing.__module__].__all__
    return not thing.__name__.startswith("_")


@functools.cache
def _import_all() -> list[Any]:
    """Import and return all modules of the packages, so that their classes are known."""
    folders = {name: [str(Path(place, *name.split("."))) for place in poinsot.__path__] for name in PACKAGES}
    return [
        importlib.import_module(f"poinsot.{name}.{module.name}")
        for name, places in folders.items()
        for module in pkgutil.iter_modules(places)
    ]


def _makes(way: Any, bases: tuple[type, ...]) -> bool:
    """Return True if a class, or the result of a function, belongs to a group."""
    if isinstance(way, type):
        return issubclass(way, bases)
    result = hint_of(_function(way).__annotations__.get("return"), _function(way).__globals__)
    kinds = [one for one in _ways(result) if isinstance(one, type)]
    return any(issubclass(kind, bases) for kind in kinds) or (result is Self and issubclass(way.__self__, bases))


def _function(call: Any) -> Any:
    return inspect.unwrap(getattr(call, "__func__", call))


def _maker(call: Callable[..., Any], name: str, left_out: tuple[str, ...] = ()) -> Maker | None:
    """Return the maker of a call with its arguments as keys; None if a file cannot contain a required argument."""
    hints, entries = _hints(call), parameter_entries(call.__doc__)
    keys, takes_calendar = [], False
    for parameter in inspect.signature(call).parameters.values():
        hint, required = hints.get(parameter.name, Any), parameter.default is parameter.empty
        if parameter.name in left_out:
            continue
        if Calendar in _ways(hint):
            takes_calendar = True
            continue
        kind, rank, group = _kind_of(hint)
        if spread := parameter.kind is parameter.VAR_POSITIONAL:
            kind, group = _several(kind, group)
        if kind:
            default = parameter.default if isinstance(parameter.default, float | int | str) else None
            axes = [f"Along the {extra.axes}." for extra in extras_of(hint) if isinstance(extra, Along)]
            words = " ".join([*entries.get(parameter.name, "").split("\n")[1:], *axes])
            words = " ".join(words.split())
            more: Any = {"group": group, "spread": spread, "or_number": OR_NUMBER in extras_of(hint)}
            keys.append(Key(parameter.name, kind, words, rank, required, default, **more))
        elif required:
            return None
    return Maker(name, call, tuple(keys), (call.__doc__ or "").strip().split("\n", 1)[0], takes_calendar)


def _hints(call: Any) -> dict[str, Any]:
    """Return the type hints of the fields of a record, or of the arguments of a function, by name."""
    if not (isinstance(call, type) and dataclasses.is_dataclass(call)):
        function = _function(inspect.getattr_static(call, "__init__") if isinstance(call, type) else call)
        space = getattr(function, "__globals__", {})
        return {name: hint_of(stated, space) for name, stated in inspect.get_annotations(function).items()}
    owners = {name: (base, hint) for base in call.__mro__[::-1] for name, hint in inspect.get_annotations(base).items()}
    named = inspect.signature(call).parameters
    hints = {name: hint_of(owners[name][1], namespace_of(owners[name][0])) for name in named}
    return {name: hint.type if isinstance(hint, dataclasses.InitVar) else hint for name, hint in hints.items()}


def _ways(hint: Any) -> tuple[Any, ...]:
    """Return the alternatives of a hint without their metadata."""
    if get_origin(hint) is Annotated:
        return _ways(get_args(hint)[0])
    if get_origin(hint) not in (Union, UnionType):
        return (hint,)
    return tuple(way for one in get_args(hint) for way in _ways(one) if way is not type(None))


def _kind_of(hint: Any) -> tuple[str, int, Group]:
    """Return the kind of a key, the rank of its numbers and the group of its tables; no kind if no file can have it."""
    shape = next((extra for extra in extras_of(hint) if isinstance(extra, tuple)), None)
    ways, quantity = _ways(hint), quantity_of(hint)
    is_array = shape is not None or set(_ways(ArrayLike)) <= set(ways)
    if quantity or is_array or float in ways:
        return quantity.kind if quantity else "number", len(shape) if shape is not None else int(is_array), ""
    for way in ways:
        if get_origin(way) in (Sequence, tuple):
            kind, _, of_each = _kind_of(get_args(way)[0])
            if of_each == "outline":
                return "record or records", 0, of_each
            several, together = _several(kind, of_each)
            if kind:
                return several, 0, together
    kinds = ((Path, "file"), (str, "text"), (bool, "truth"), (int, "whole"), ((Orbit, CirclingPair), "orbit"))
    classes = [way for way in ways if isinstance(way, type)]
    found = next((word for cls, word in kinds for way in classes if issubclass(way, cls)), "")
    if found not in ("", "orbit"):
        return found, 0, ""
    group: Group = next((own for way in classes if not issubclass(way, Orbit) and (own := _group_of(way))), "")
    group = "outline" if set(classes) == set(BASES["outline"]) else group
    return found or ("record" if group else ""), 0, group


def _group_of(cls: type) -> Group:
    """Return the group of a class of which a key can have a table."""
    if issubclass(cls, Shape | Body):
        return "shape" if issubclass(cls, Shape) else "rigid"
    return cls if issubclass(cls, Parametric) else ""


def _several(kind: str, group: Group) -> tuple[str, Group]:
    """Return kind and group of several values. Several shapes are the parts of one assembly."""
    return f"{kind}s", "part" if group == "shape" else group


def body_of_shape(shape: Shape) -> Body:
    """Return the body of a shape about its centre of mass, along the shape's axes, as `Body.from_shape` does."""
    return Body.from_shape(shape)


def field_of_shape(shape: Shape, degree: int, radius: float | None = None) -> GravityField:
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


PLACE = (
    Key("position", "number", "Position of the origin of the shape, along the body axes.", 1),
    Key("quaternion", "number", "Rotation before the shift, scalar first, from the shape's axes to the body axes.", 1),
    Key("matrix", "number", "Rotation before the shift, as a matrix instead of a quaternion.", 2),
)


def _placed(maker: Maker) -> Maker:
    """Return the maker of a shape that can be moved."""

    def call(position: Any = (0, 0, 0), quaternion: Any = None, matrix: Any = None, **fields: Any) -> Any:
        if quaternion is not None and matrix is not None:
            raise ValueError("matrix must not be given together with quaternion, got both.")
        faces = np.asarray(fields.get("faces", ()))
        if faces.size and np.all(faces == np.rint(faces)) and np.all(np.abs(faces) < 2**53):
            fields["faces"] = faces.astype(np.int64)
        shape = maker.call(**fields)
        if matrix is not None:
            quaternion_from_matrix(real_array("matrix", matrix, (3, 3)))
            return shape._placed(real_array("position", position, (3,)), np.asarray(matrix))
        if quaternion is None and not np.any(position):
            return shape
        return shape.moved(position, (1, 0, 0, 0) if quaternion is None else quaternion)

    return dataclasses.replace(maker, call=call, keys=(*maker.keys, *PLACE))


ON = Key("on", "text", "Body of a two-body system on which the force acts, or which is observed.", choices=BODIES)


def _on_one_of_two(maker: Maker) -> Maker:
    """Return the maker of a force or an observable of one body that can be put on one of two; others as they are."""
    if getattr(maker.call, "on", None) is Force.on:
        return maker

    def call(on: str | None = None, **fields: Any) -> Any:
        record = maker.call(**fields)
        return record if on is None else record.on(on)

    call.__module__ = maker.call.__module__  # whose it is
    return dataclasses.replace(maker, call=call, keys=(*maker.keys, ON))


PLAN = (
    Key("name", "text", "Name of the readings. Default: the type."),
    Key("times", "time", "List of the times of the readings. Default: the output times.", 1),
    Key("sigma", "number", "Standard deviation of a reading. Default: the noise of the observable.", 1, or_number=True),
)
"""Keys of an observable in a scenario that belong to its readings."""


class Planned(NamedTuple):
    """An observable, and the arguments of its readings by name."""

    observable: Observable
    plan: dict[str, Any]


def _planned(maker: Maker) -> Maker:
    """Return the maker of an observable with the keys of its readings, unless a field has the name of one."""
    own = {key.name for key in maker.keys}
    keys = tuple(key for key in PLAN if key.name not in own)

    def call(**fields: Any) -> Planned:
        plan = {key.name: fields.pop(key.name) for key in keys if key.name in fields}
        return Planned(maker.call(**fields), plan)

    call.__module__ = maker.call.__module__  # whose it is
    return dataclasses.replace(maker, call=call, keys=(*maker.keys, *keys))
