"""What a scenario can name: the package's bodies, forces, orbits and fields, and the other ways to them.

Classes are found by themselves, and read by their annotated fields: a new force needs no line here.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

from poinsot.files.orbits.tle import omm_orbit, tle_orbit
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Potential, Torque
from poinsot.mechanics.frame import RotatingFrame
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.parameters import Parametric, Table, kinds_of
from poinsot.mechanics.sky import Orbit
from poinsot.orbits.ephemeris import PolynomialArc
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.orbits.lagrange import LagrangePoint
from poinsot.orbits.planets import planet_orbit
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.orbits.restricted import ThreeBodyOrbit
from poinsot.orbits.sums import orbit_sum
from poinsot.orbits.two_body import two_body_orbit

__all__ = ["Key", "Maker", "kind_of", "makers"]

CLASSES: dict[str, tuple[Any, ...]] = {
    "body": (Body,),
    "force": (Potential, Torque),
    "orbit": (Orbit, ThreeBodyOrbit),
    "field": (GravityField,),
}
"""Bases whose subclasses in the package are found."""

FUNCTIONS: dict[str, tuple[Callable[..., Any], ...]] = {
    "body": (
        Body.from_inertia,
        Body.from_stokes,
        Body.from_ratios,
        Body.ellipsoid,
        Body.box,
        Body.cylinder,
        Body.point_masses,
    ),
    "force": (),
    "orbit": (
        KeplerOrbit.from_elements,
        KeplerOrbit.from_vectors,
        EscapeOrbit.from_elements,
        EscapeOrbit.from_vectors,
        PrecessingOrbit.from_mean_motion,
        two_body_orbit,
        LagrangePoint,
        planet_orbit,
        tle_orbit,
        omm_orbit,
        orbit_sum,
    ),
    "field": (GravityField.from_normalized,),
    "frame": (RotatingFrame,),
}
"""Other ways to them."""

NOT_FOR_FILES = (PolynomialArc,)

ANGLES = (
    *("inclination", "node", "argument_of_periapsis", "true_anomaly", "mean_anomaly", "eccentric_anomaly"),
    *("euler_angles", "roll_pitch_yaw", "turn"),
)
RATES = ("rate", "node_rate", "periapsis_rate", "anomaly_rate", "mean_motion", "omega_body", "omega_space")
TIMES = ("epoch", "time", "time_since_periapsis", "start", "stop", "step", "values")


@dataclasses.dataclass(frozen=True)
class Key:
    """A key of a table.

    Attributes
    ----------
    kind : str
        "number", "angle", "rate", "time", "text", "texts", "whole", "truth", "orbit", "orbits" or "field".
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
    found = [_of_class(cls) for base in CLASSES.get(group, ()) for cls in _concrete(base)]
    return {maker.name: maker for maker in (*found, *map(_of_function, FUNCTIONS[group]))}


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
    if annotation.endswith("Orbit"):
        return Key(name, "orbit", 0, *rest)
    if "str" in annotation:
        return Key(name, "texts" if "Sequence" in annotation else "text", 0, *rest)
    rank = {"tensor": 2, "positions": 2, "C": 2, "S": 2}.get(name, 1) if "ArrayLike" in annotation else 0
    return Key(name, kind_of(name), rank, *rest)


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
