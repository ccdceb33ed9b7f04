"""Tables and keys of a scenario, which pydantic checks and a JSON Schema describes to editors."""

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

from poinsot.errors import real_numbers
from poinsot.integration.formulations import formulations
from poinsot.integration.settings import PRECISIONS
from poinsot.mechanics.force import Force
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.printable import quoted
from poinsot.quantities import ANGLE_UNITS, NAMED_RATES
from poinsot.records.calendar import SECONDS
from poinsot.scenarios.registry import Group, Key, Maker, default_of, keys_of, known_classes, makers

__all__ = ["MAX_TIMES", "STARTS", "STATE", "converted", "quantity", "scenario_model", "schema", "short"]

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)\s*(?P<unit>[A-Za-z]+(\s*/\s*[A-Za-z]+)?)\s*"
)

EXAMPLES = {"angle": "'45 deg'", "rate": "'0.1 deg/s'", "time": "'8 h'"}

STRICT = ConfigDict(extra="forbid", protected_namespaces=())

MAX_INTEGER = 2**53

MAX_TIMES = 10_000_000

UNITS = (
    Key("time", "text", "Unit of time, such as s. Values with units require s, min, h or d.", default="1"),
    Key("inertia", "text", "Unit of moments of inertia, such as kg m2.", default="1"),
    Key("length", "text", "Unit of length for two bodies, such as m.", default="1"),
)

CALENDAR = (
    Key("zero", "text", "Date of t = 0, such as 2026-11-21T00:00:00.", required=True),
    Key("scale", "text", "Time scale of the date: UTC, TAI, GPS, TT, TDB, TCB or TCG.", required=True),
    Key("unit", "text", "Unit of time: s, min, h or d.", default="s"),
)

ROTATION = (
    Key("quaternion", "number", "Unit quaternion, scalar first, body to space (or to the frame).", 1),
    Key("conjugate_momenta", "number", "Conjugate momenta Q of the quaternion q.", 1),
    Key("matrix", "number", "Active rotation matrix, body to space (or to the frame).", 2),
    Key("euler_angles", "angle", "Euler angles a1, a2, a3 with q = r_i(a1) r_j(a2) r_k(a3) for the sequence ijk.", 1),
    Key("euler_momenta", "number", "Conjugate momenta of the Euler angles.", 1),
    Key("sequence", "text", "Sequence of the Euler angles, such as 313 or 321.", default="313"),
    Key(
        "roll_pitch_yaw",
        "angle",
        "Roll, pitch and yaw from the level axes of the orbit in `frame`: forward, opposite to the normal, down.",
        1,
    ),
    Key("omega_body", "rate", "Angular velocity along the body axes, relative to the frame if there is one.", 1),
    Key("omega_space", "rate", "Angular velocity along the space axes, or relative to a frame and along its axes.", 1),
    Key("angular_momentum_body", "number", "Angular momentum along the body axes.", 1),
    Key("angular_momentum_space", "number", "Angular momentum along the space axes.", 1),
)

FRAME = Key("frame", "text", "Axes of the velocity change; default: space axes.", choices=("orbit",))
STARTS = {name: keys_of(getattr(TwoBodies, name), "self", "time") for name in ("synchronous", "doubly_synchronous")}
"""The keys of starts of two bodies that need no position and no attitudes, by the name of the method."""

STATE = (
    *ROTATION,
    Key(
        "frame",
        "text",
        'Frame of attitude and angular velocity: an orbit, a table of [frames], or "orbit" of two bodies.',
    ),
    Key("time", "time", "Time of the state.", default=0.0),
    Key("own", "named", "Variables of parts by the name of the part. Default: at rest relative to the body.", 1),
    Key("position", "number", "Position of the secondary relative to the primary, along the space axes.", 1),
    Key("velocity", "number", "Velocity of the secondary relative to the primary, along the space axes.", 1),
    Key("primary", "table", "Attitude, and angular velocity or momentum, of the primary.", keys=ROTATION),
    Key("secondary", "table", "Attitude, and angular velocity or momentum, of the secondary.", keys=ROTATION),
    Key(
        "elements",
        "table",
        "Elements of the mutual orbit of two bodies, instead of position and velocity.",
        keys=keys_of(KeplerOrbit, "mu"),
    ),
    *(
        Key(
            name,
            "table",
            "Equilibrium state of two bodies, instead of all other keys except time and kick.",
            keys=STARTS[name],
        )
        for name in STARTS
    ),
    Key(
        "kick",
        "table",
        "Impulsive velocity change of one of two bodies at the start.",
        keys=(*keys_of(TwoBodies.kick, "self", "state"), FRAME),
    ),
)

TIMES = (
    Key("start", "time", "First time. Default: the time of the state.", default=0.0),
    Key("stop", "time", "Last time."),
    Key("count", "whole", "Number of times from start to stop.", limits=(1, MAX_TIMES)),
    Key("step", "duration", "Interval between the times from start to stop."),
    Key("periods", "number", "Number of revolutions of an orbit, instead of stop."),
    Key("orbit", "orbit", "Orbit that defines the revolutions."),
    Key("values", "time", "List of all times, instead of the other keys.", 1),
)

OUTPUTS = (
    Key(
        "result", "output", "File of the result. Default: the name of the scenario with .nc.", choices=(".nc", ".zarr")
    ),
    Key("plot", "output", "File of a plot.", choices=(".png", ".pdf", ".svg")),
    Key("view", "output", "File of a 3D view.", choices=(".html",)),
)

PLACE = "Path of the distributed number, such as state.omega_body. state.turn rotates the attitude about body axes."
NEAR = "Distribution around the value in this file. isotropic: uniformly random attitudes, for state.turn."

SPREAD = (
    Key("of", "text", PLACE, required=True),
    Key("distribution", "text", NEAR, default="normal", choices=("normal", "uniform", "isotropic")),
    Key("size", "any", "Standard deviation or half width: one number, or one per component."),
)

ENSEMBLE = (
    Key("members", "whole", "Number of members.", required=True, limits=(1, 1_000_000)),
    Key(
        "seed",
        "whole",
        "Seed of the random numbers, which makes the members reproducible.",
        required=True,
        limits=(0, 2**63 - 1),
    ),
    Key("spread", "tables", "Distributed quantities.", required=True, keys=SPREAD),
)


def _scenario(charts: tuple[str, ...]) -> tuple[Key, ...]:
    methods = ("integration", "closed form")
    run = (
        Key(
            "method",
            "text",
            "Numerical integration, or the closed form of the torque-free motion.",
            default=methods[0],
            choices=methods,
        ),
        Key("formulation", "text", "Variables of the integration.", default="lie_poisson", choices=charts),
        Key("tolerance", "number", "Relative error per step. Default: truncation errors below rounding errors."),
        Key("precision", "text", "Precision of the arithmetic.", default="double", choices=PRECISIONS),
        Key(
            "dense",
            "truth",
            "Integration with the steps of dense output. The file contains only the output times.",
            default=False,
        ),
    )
    return (
        Key("title", "text", "Title of the result and of its plots, one line.", default=""),
        Key("units", "table", "Units of the numbers in this file.", keys=UNITS),
        Key("calendar", "table", "Date of the time 0.", keys=CALENDAR),
        Key("body", "body", "Rigid body, or two bodies that attract each other.", required=True),
        Key(
            "state",
            "table",
            "Initial state: attitude, and angular velocity or angular momentum, at a time.",
            required=True,
            keys=STATE,
        ),
        Key(
            "forces",
            "force",
            "Forces and parts that act on the body or on two bodies. Default: none, a torque-free motion.",
        ),
        Key("observe", "observable", "Instruments whose readings `poinsot observe` writes."),
        Key("orbits", "tables of orbits", "Orbits of the body, by name."),
        Key("frames", "tables of frames", "Rotating axes, by name."),
        Key("times", "table", "Output times.", required=True, keys=TIMES),
        Key("run", "table", "Numerical method and precision.", keys=run),
        Key("outputs", "table", "Names of the output files.", keys=OUTPUTS),
        Key("ensemble", "table", "Ensemble of members with distributed initial values or parameters.", keys=ENSEMBLE),
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
    """Return the model of a table whose type determines its keys.

    Within a table of the same group, such as a law within a sampled law, no further table of this group is allowed.
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
    """Return the model of a table within tables of groups. All places with the same keys share one model."""
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
        "record or records": lambda: _union(key.group, inside) | list[_union(key.group, inside)],  # type: ignore[misc]
        "orbit": lambda: ORBIT | _union(key.group, inside) if key.group else ORBIT,
        "orbits": lambda: list[StrictStr],
        "named": lambda: dict[StrictStr, _number("number", key.rank)],  # type: ignore[misc]
        "body": lambda: _union("body"),
        "force": lambda: list[_union("force")],  # type: ignore[misc]
        "observable": lambda: list[_union("observable")],  # type: ignore[misc]
        "tables of orbits": lambda: dict[StrictStr, _union("orbit")],  # type: ignore[misc]
        "tables of frames": lambda: dict[StrictStr, _union("frame")],  # type: ignore[misc]
        "table": lambda: _table(key.name.capitalize(), key.keys),
        "tables": lambda: list[_table(key.name.capitalize(), key.keys)],  # type: ignore[misc]
    }
    annotation = kinds[key.kind]() if key.kind in kinds else _number(key.kind, key.rank, key.or_number)
    words = f"Name of a file that ends in {' or '.join(key.choices)}. {key.help}" if key.kind == "output" else key.help
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

ORBIT = Annotated[StrictStr, WithJsonSchema({"type": "string", "description": ORBIT_NAME})]

# ------------------------------------------------------------------ numbers


def _number(kind: str, rank: int = 0, or_number: bool = False) -> Any:
    one: dict[str, Any] = {"type": "number"} if kind == "number" else {"type": ["number", "string"]}
    several: dict[str, Any] = {"type": "array", "items": one if rank < 2 else {"type": "array", "items": one}}
    if rank:
        described = several if rank > 1 else {"type": "array", "items": {"anyOf": [one, several]}}
        described = {"anyOf": [one, described]} if or_number else described
    else:
        described = {"anyOf": [one, several]}
    return Annotated[Any, BeforeValidator(functools.partial(_checked, kind)), WithJsonSchema(described)]


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
    """Return an array of a result that the text names."""
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
    if abs(value) > MAX_INTEGER and isinstance(value, int):
        raise ValueError(f"{name} must be at most 2^53 where it is whole, got more. Write it with a decimal point.")
    return value


def quantity(text: str, kind: str, time_unit: str | None) -> float:
    """Return an angle in radians, a rate in radians per unit of time, or a time in units of time.

    The message of a ValueError begins with "must", after which the caller's name of the key is inserted.

    Parameters
    ----------
    text : str
        A number and a unit.
    kind : {"angle", "rate", "time"}
    time_unit : {"s", "min", "h", "d"}, optional
        Unit of numbers without a unit.
    """
    given = quoted(text)
    found = _QUANTITY.fullmatch(text) if len(text) < 100 else None
    if found is None:
        raise ValueError(f"must be a number, alone or with a unit such as {EXAMPLES[kind]}, got {given}.")
    unit = "".join(found["unit"].split())
    angle, _, per = "/".join(NAMED_RATES.get(unit, (unit,))).partition("/")
    angles, times = ", ".join(ANGLE_UNITS), ", ".join(SECONDS)
    known = {
        "angle": (unit in ANGLE_UNITS, f"an angle in {angles}"),
        "time": (unit in SECONDS, f"a time in {times}"),
        "rate": (angle in ANGLE_UNITS and per in SECONDS, f"a rate: rpm, or an angle ({angles}) over a time ({times})"),
    }
    is_known, rule = known[kind]
    if not is_known:
        raise ValueError(f"must be {rule}, got {given}.")
    if kind == "angle":
        return float(found["number"]) * ANGLE_UNITS[unit]
    if time_unit is None:
        hint = f"Say units.time: {times}."
        raise ValueError(f"must be a number where the file does not state its unit of time, got {given}. {hint}")
    if kind == "time":
        return float(found["number"]) * (SECONDS[unit] / SECONDS[time_unit])
    return float(found["number"]) * (ANGLE_UNITS[angle] * SECONDS[time_unit] / SECONDS[per])


def short(value: Any) -> str:
    """Return a value as an error sentence shows it."""
    named = {dict: "a table", list: "a list", bool: str(value).lower() if isinstance(value, bool) else ""}
    if type(value) in named:
        return named[type(value)]
    if isinstance(value, dt.date | dt.time):
        return f"the date {value}"
    return quoted(value) if not isinstance(value, int) or abs(value) < 2**64 else "a large number"
