"""The tables and keys of a scenario, as pydantic checks them and a JSON Schema tells them to editors."""

from __future__ import annotations

import datetime as dt
import functools
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, Literal, Union

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    Tag,
    ValidationInfo,
    WithJsonSchema,
    create_model,
)

from poinsot.engine.formulations import formulations
from poinsot.engine.kernels import PRECISIONS
from poinsot.errors import real_numbers
from poinsot.files.scenarios.quantities import quantity
from poinsot.files.scenarios.registry import Group, Key, Maker, default_of, keys_of, known_classes, makers
from poinsot.mechanics.force import Force
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.printable import quoted

__all__ = ["MOST_TIMES", "STARTS", "STATE", "converted", "scenario_model", "schema", "short"]

STRICT = ConfigDict(extra="forbid", protected_namespaces=())

LARGEST_WHOLE = 2**53

MOST_TIMES = 10_000_000

UNITS = (
    Key("time", "text", "Such as s; one of s, min, h, d where rates or times have a unit.", default="1"),
    Key("inertia", "text", "Such as kg m2.", default="1"),
    Key("length", "text", "Of two bodies, such as m.", default="1"),
)

CALENDAR = (
    Key("zero", "text", "The date of t = 0, such as 2026-11-21T00:00:00.", required=True),
    Key("scale", "text", "Of that date: UTC, TAI, GPS, TT, TDB, TCB or TCG.", required=True),
    Key("unit", "text", "Of time: s, min, h or d.", default="s"),
)

ROTATION = (
    Key("quaternion", "number", "Unit quaternion, scalar first, body to space (or to the frame).", 1),
    Key("conjugate_momenta", "number", "Q, with a quaternion: the canonical pair.", 1),
    Key("matrix", "number", "Active rotation matrix, body to space (or to the frame).", 2),
    Key("euler_angles", "angle", "Angles of q = r_i(a1) r_j(a2) r_k(a3), by the sequence.", 1),
    Key("euler_momenta", "number", "The canonical momenta of the Euler angles.", 1),
    Key("sequence", "text", "Of the Euler angles, such as 313 or 321.", default="313"),
    Key("roll_pitch_yaw", "angle", "From forward, against the normal, down of the orbit that is the frame.", 1),
    Key("omega_body", "rate", "Rate along the body axes; with a frame, relative to it.", 1),
    Key("omega_space", "rate", "Rate along the space axes; with a frame, relative to it and along it.", 1),
    Key("angular_momentum_body", "number", "Angular momentum along the body axes.", 1),
    Key("angular_momentum_space", "number", "Angular momentum along the space axes.", 1),
)

FRAME = Key("frame", "text", "Axes of the change; default: those of space.", choices=("orbit",))
STARTS = {name: keys_of(getattr(TwoBodies, name), "self", "time") for name in ("synchronous", "doubly_synchronous")}
"""The keys of starts of two bodies that need no position and no attitudes, by the name of the method."""

STATE = (
    *ROTATION,
    Key("frame", "text", 'An orbit (radial, transverse, normal), a table under frames, or "orbit" of two bodies.'),
    Key("time", "time", "The time of the state.", default=0.0),
    Key("own", "named", "Variables of parts, by the name of the part; default: at rest in the body.", 1),
    Key("position", "number", "Of two bodies: of the secondary from the primary, along the space axes.", 1),
    Key("velocity", "number", "Of two bodies: of the secondary relative to the primary, along the space axes.", 1),
    Key("primary", "table", "Of two bodies: attitude, and rate or momentum, of the primary.", keys=ROTATION),
    Key("secondary", "table", "Of two bodies: the same of the secondary.", keys=ROTATION),
    Key("elements", "table", "Of two bodies, in place of both: of their orbit.", keys=keys_of(KeplerOrbit, "mu")),
    *(
        Key(name, "table", "Of two bodies, in place of all others but time and kick.", keys=STARTS[name])
        for name in STARTS
    ),
    Key(
        "kick",
        "table",
        "Of two bodies: an impact at the start.",
        keys=(*keys_of(TwoBodies.kick, "self", "state"), FRAME),
    ),
)

TIMES = (
    Key("start", "time", "The first time; default: that of the state.", default=0.0),
    Key("stop", "time", "The last time."),
    Key("count", "whole", "How many times, with start and stop.", limits=(1, MOST_TIMES)),
    Key("step", "duration", "The distance of the times, with start and stop."),
    Key("periods", "number", "In place of stop: so many revolutions of an orbit."),
    Key("orbit", "orbit", "The orbit of these revolutions."),
    Key("values", "time", "The times themselves, in place of all others.", 1),
)

OUTPUTS = (
    Key("result", "output", "Default: the name of this file, with .nc.", choices=(".nc", ".zarr")),
    Key("plot", "output", choices=(".png", ".pdf", ".svg")),
    Key("view", "output", choices=(".html",)),
)

PLACE = "The number to vary by its place, such as state.omega_body; state.turn turns the attitude about body axes."
NEAR = "Around the value in this file; isotropic: any attitude, of state.turn."

SPREAD = (
    Key("of", "text", PLACE, required=True),
    Key("distribution", "text", NEAR, default="normal", choices=("normal", "uniform", "isotropic")),
    Key("size", "any", "Standard deviation, or half the width: a number, or one for each component."),
)

ENSEMBLE = (
    Key("members", "whole", "How many.", required=True, limits=(1, 1_000_000)),
    Key("seed", "whole", "Makes the same members again.", required=True, limits=(0, 2**63 - 1)),
    Key("spread", "tables", "What differs between them.", required=True, keys=SPREAD),
)


def _scenario(charts: tuple[str, ...]) -> tuple[Key, ...]:
    methods = ("integration", "closed form")
    run = (
        Key("method", "text", "The closed form is for no forces.", default=methods[0], choices=methods),
        Key("formulation", "text", "The variables integrated.", default="lie_poisson", choices=charts),
        Key("tolerance", "number", "Relative error in a step; default: truncation below rounding."),
        Key("precision", "text", "Of the arithmetic.", default="double", choices=tuple(PRECISIONS)),
        Key("dense", "truth", "Integrate as for dense output; the file has the times alone.", default=False),
    )
    return (
        Key("title", "text", "One line that tells what this is.", default=""),
        Key("units", "table", "Names of the units of the numbers in this file.", keys=UNITS),
        Key("calendar", "table", "What the time 0 is as a date.", keys=CALENDAR),
        Key("body", "body", "The rigid body, or two that attract each other.", required=True),
        Key("state", "table", "The start: attitude, and rate or momentum, at a time.", required=True, keys=STATE),
        Key("forces", "force", "What turns a body, or moves two; none: free motion."),
        Key("orbits", "tables of orbits", "Where the body is, by name."),
        Key("frames", "tables of frames", "Axes that turn, by name."),
        Key("times", "table", "The times at which the motion is wanted.", required=True, keys=TIMES),
        Key("run", "table", "How to compute.", keys=run),
        Key("outputs", "table", "Names of the files to write.", keys=OUTPUTS),
        Key("ensemble", "table", "Many members, spread around this one.", keys=ENSEMBLE),
    )


def schema() -> dict[str, Any]:
    """Return the JSON Schema of scenarios, for editors."""
    found = scenario_model().model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **found, "title": "poinsot scenario"}


def scenario_model() -> type[BaseModel]:
    """Return the model of a whole file, with what can be named now."""
    return _scenario_model(known_classes(), tuple(formulations()))


@functools.lru_cache(maxsize=1)
def _scenario_model(_: tuple[type, ...], charts: tuple[str, ...]) -> type[BaseModel]:
    doc = "A body, its state, the forces on it, and the times at which its motion is wanted."
    model: type[BaseModel] = _table("Scenario", _scenario(charts), doc)
    return model


# ------------------------------------------------------------------ tables


Groups = frozenset[Group]

OUTSIDE: Groups = frozenset()


def _table(name: str, keys: Iterable[Key], doc: str | None = None, inside: Groups = OUTSIDE, **more: Any) -> Any:
    """Return a model of a table, within tables of groups, that refuses keys that it does not know."""
    create: Any = create_model
    return create(name, __config__=STRICT, __doc__=doc, **more, **{key.name: _field(key, inside) for key in keys})


def _one_of(names: Iterable[str]) -> Any:
    literal: Any = Literal
    return literal[tuple(names)]


def _union(group: Group, inside: Groups = OUTSIDE) -> Any:
    """Return a table that says by its type which keys it has.

    Within one of its own group, as a law within a sampled law, it has no table of that group again.
    """
    default, known = default_of(group), makers(group)
    if group in inside:
        known = {name: maker for name, maker in known.items() if not any(key.group in inside for key in maker.keys)}
    models = [Annotated[_made(maker, default, group, inside), Tag(name)] for name, maker in known.items()]
    if len(models) < 2:
        return models[0] if models else type(None)

    def type_of(value: Any) -> Any:
        if isinstance(value, BaseModel):
            return value.type  # type: ignore[attr-defined]
        return value.get("type", default) if isinstance(value, Mapping) else None

    return Annotated[Union[tuple(models)], Discriminator(type_of)]  # noqa: UP007


def _made(maker: Maker, default: str | None, group: Group, inside: Groups) -> Any:
    """Return the model of a table in those of groups: one for all places where it has the same keys."""
    around = inside | {group} if any(key.group for key in maker.keys) else OUTSIDE
    within_one = isinstance(group, type) and issubclass(group, Force)  # where it cannot be on one of two bodies
    return _model(maker, default, "_within_another" if within_one else "", around)


@functools.lru_cache(maxsize=512)
def _model(maker: Maker, default: str | None, ending: str, around: Groups) -> Any:
    kind = (_one_of((maker.name,)), Field(maker.name if maker.name == default else ...))
    return _table(maker.name.replace(".", "_") + ending, maker.keys, maker.help, around, type=kind)


def _field(key: Key, inside: Groups = OUTSIDE) -> Any:
    kinds: dict[str, Callable[[], Any]] = {
        "text": lambda: _one_of(key.choices) if key.choices else StrictStr,
        "texts": lambda: StrictStr | list[StrictStr],
        "whole": lambda: StrictInt,
        "truth": lambda: StrictBool,
        "any": lambda: Any,
        "file": lambda: Annotated[StrictStr, WithJsonSchema({"type": "string", "description": FILE_NAME})],
        "files": lambda: list[StrictStr],
        "output": lambda: Annotated[StrictStr, AfterValidator(functools.partial(_output, key.choices))],
        "record": lambda: _union(key.group, inside),
        "records": lambda: list[_union(key.group, inside)],  # type: ignore[misc]
        "orbit": lambda: Annotated[StrictStr, WithJsonSchema({"type": "string", "description": ORBIT_NAME})],
        "orbits": lambda: list[StrictStr],
        "named": lambda: dict[StrictStr, _number("number", key.rank)],  # type: ignore[misc]
        "body": lambda: _union("body"),
        "force": lambda: list[_union("force")],  # type: ignore[misc]
        "tables of orbits": lambda: dict[StrictStr, _union("orbit")],  # type: ignore[misc]
        "tables of frames": lambda: dict[StrictStr, _union("frame")],  # type: ignore[misc]
        "table": lambda: _table(key.name.capitalize(), key.keys),
        "tables": lambda: list[_table(key.name.capitalize(), key.keys)],  # type: ignore[misc]
    }
    annotation = kinds[key.kind]() if key.kind in kinds else _number(key.kind, key.rank, key.or_number)
    words = f"A name that ends in {' or '.join(key.choices)}. {key.help}" if key.kind == "output" else key.help
    bounds: Any = dict(zip(("ge", "le"), key.limits, strict=True)) if key.limits else {}
    return annotation, Field(... if key.required else key.default, description=words or None, **bounds)


def _output(endings: tuple[str, ...], name: str) -> str:
    """Return the name of a file that does not lead out of its folder."""
    if re.fullmatch(r"\w[\w .+-]*", name) is None or len(name) > 200:
        raise ValueError(f"name must be the name of a file, without a folder, got {short(name)}.")
    if not name.endswith(endings):
        raise ValueError(f"name must end in {' or '.join(endings)}, got {short(name)}.")
    return name


FILE_NAME = "The path of a file, from the folder of this one: in it or below."

ORBIT_NAME = "The name of a table under orbits, or name.from_primary, name.from_secondary."

# ------------------------------------------------------------------ numbers


def _number(kind: str, rank: int = 0, or_number: bool = False) -> Any:
    one: dict[str, Any] = {"type": "number"} if kind == "number" else {"type": ["number", "string"]}
    several: dict[str, Any] = {"type": "array", "items": one if rank < 2 else {"type": "array", "items": one}}
    if rank:
        said = several if rank > 1 else {"type": "array", "items": {"anyOf": [one, several]}}
        said = {"anyOf": [one, said]} if or_number else said
    else:
        said = {"anyOf": [one, several]}
    return Annotated[Any, BeforeValidator(functools.partial(_checked, kind)), WithJsonSchema(said)]


def _checked(kind: str, value: Any, info: ValidationInfo) -> Any:
    """Return the numbers, those with a unit in radians and units of time; dates as they are."""
    name, unit = str(info.field_name), (info.context or {}).get("time_unit")
    first = value[0] if isinstance(value, list) and value else value
    if kind == "time" and isinstance(first, str) and first[4:5] == "-":
        return value  # dates
    try:
        if isinstance(value, dict) and "data" in value:
            return _named_array(name, value, (info.context or {}).get("data"))
        return real_numbers(name, converted(value, kind, unit, name))
    except TypeError as error:
        raise ValueError(str(error)) from None


def _named_array(name: str, value: dict[str, Any], arrays: Mapping[str, Any] | None) -> Any:
    """Return an array that is beside the text, in a result."""
    if arrays is None:
        raise ValueError(f"{name} must be numbers, got the name of an array in a result. Run the result.")
    if value.keys() != {"data"} or not isinstance(value["data"], str) or value["data"] not in arrays:
        raise ValueError(f"{name} must name an array of the file, got {short(value['data'])}.")
    return arrays[value["data"]]


def converted(value: Any, kind: str, unit: str | None, name: str) -> Any:
    """Return a number or nested lists of numbers without texts; refuse anything else among them."""
    if isinstance(value, list):
        return [converted(item, kind, unit, f"{name}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, str) and kind != "number":
        try:
            return quantity(value, "time" if kind == "duration" else kind, unit)
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        rule = "a number in your own units" if isinstance(value, str) else "a number"
        raise ValueError(f"{name} must be {rule}, got {short(value)}.")
    if abs(value) > LARGEST_WHOLE and isinstance(value, int):
        raise ValueError(f"{name} must be at most 2^53 where it is whole, got more. Write it with a decimal point.")
    return value


def short(value: Any) -> str:
    """Return a value as an error sentence shows it."""
    named = {dict: "a table", list: "a list", bool: str(value).lower() if isinstance(value, bool) else ""}
    if type(value) in named:
        return named[type(value)]
    if isinstance(value, dt.date | dt.time):
        return f"the date {value}"
    return quoted(value) if not isinstance(value, int) or abs(value) < 2**64 else "a large number"
