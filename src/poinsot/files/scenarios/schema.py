"""The tables and keys of a scenario, as pydantic checks them and a JSON Schema tells them to editors."""

from __future__ import annotations

import datetime as dt
import functools
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, Literal, Union

from pydantic import (
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
from poinsot.files.scenarios.registry import DEFAULTS, Key, Maker, known_classes, makers

__all__ = ["converted", "scenario_model", "schema", "short"]

METHOD_NAMES = ("integration", "closed form")

STRICT = ConfigDict(extra="forbid", protected_namespaces=())

LARGEST_WHOLE = 2**53

STATE = (
    Key("quaternion", "number", 1, False, help="Unit quaternion, scalar first, body to space (or to the frame)."),
    Key("conjugate_momenta", "number", 1, False, help="Q, with a quaternion: the canonical pair."),
    Key("matrix", "number", 2, False, help="Active rotation matrix, body to space (or to the frame)."),
    Key("euler_angles", "angle", 1, False, help="Angles of q = r_i(a1) r_j(a2) r_k(a3), by the sequence."),
    Key("euler_momenta", "number", 1, False, help="The canonical momenta of the Euler angles."),
    Key("sequence", "text", 0, False, "313", help="Of the Euler angles, such as 313 or 321."),
    Key(
        "roll_pitch_yaw",
        "angle",
        1,
        False,
        help="From forward, against the normal, down of the orbit that is the frame.",
    ),
    Key("omega_body", "rate", 1, False, help="Rate along the body axes; with a frame, relative to it."),
    Key("omega_space", "rate", 1, False, help="Rate along the space axes; with a frame, relative to it and along it."),
    Key("angular_momentum_body", "number", 1, False, help="Angular momentum along the body axes."),
    Key("angular_momentum_space", "number", 1, False, help="Angular momentum along the space axes."),
    Key("frame", "text", 0, False, help="An orbit (radial, transverse, normal), or a table under frames."),
    Key("time", "time", 0, False, 0.0, help="The time of the state."),
    Key("own", "named", 1, False, help="Variables of parts, by the name of the part; default: at rest in the body."),
)

TIMES = (
    Key("start", "time", 0, False, 0.0, help="The first time; default: that of the state."),
    Key("stop", "time", 0, False, help="The last time."),
    Key("count", "whole", 0, False, help="How many times, with start and stop."),
    Key("step", "duration", 0, False, help="The distance of the times, with start and stop."),
    Key("periods", "number", 0, False, help="In place of stop: so many revolutions of an orbit."),
    Key("orbit", "orbit", 0, False, help="The orbit of these revolutions."),
    Key("values", "time", 1, False, help="The times themselves, in place of all others."),
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
    several, named, frame = _several(_union("force", "field")), _named(_union("orbit", "field")), makers("frame")
    model: type[BaseModel] = _created(
        "Scenario",
        __doc__="A body, its state, the forces on it, and the times at which its motion is wanted.",
        title=(StrictStr, Field("", description="One line that tells what this is.")),
        units=(_units(), Field(default_factory=dict, description="Names of the units of the numbers in this file.")),
        calendar=(_calendar() | None, Field(None, description="What the time 0 is as a date.")),
        body=(_union("body", "field"), Field(description="The rigid body.")),
        state=(_table("State", STATE, "Attitude, and rate or momentum, at a time."), Field(description="The start.")),
        forces=(several, Field([], description="What turns the body; none: free motion.")),
        orbits=(named, Field({}, description="Where the body is, by name.")),
        frames=(
            _named(_model(frame["RotatingFrame"], "")),
            Field({}, description="Axes that turn evenly, by name."),
        ),
        times=(_table("Times", TIMES, "When the motion is wanted."), Field(description="The times of the result.")),
        run=(_run(charts), Field(default_factory=dict, description="How to compute.")),
        outputs=(_outputs(), Field(default_factory=dict, description="Names of the files to write.")),
        ensemble=(_ensemble() | None, Field(None, description="Many members, spread around this one.")),
    )
    return model


# ------------------------------------------------------------------ tables


def _created(model: str, /, **fields: Any) -> Any:
    """Return a model that refuses keys that it does not know."""
    create: Any = create_model
    return create(model, __config__=STRICT, **fields)


def _one_of(names: Iterable[str]) -> Any:
    literal: Any = Literal
    return literal[tuple(names)]


def _several(model: Any) -> Any:
    return list[model]


def _named(model: Any) -> Any:
    return dict[StrictStr, model]


def _units() -> Any:
    return _created(
        "Units",
        time=(StrictStr, Field("1", description="Such as s; one of s, min, h, d where rates or times have a unit.")),
        inertia=(StrictStr, Field("1", description="Such as kg m2.")),
    )


def _calendar() -> Any:
    return _created(
        "Calendar",
        zero=(StrictStr, Field(description="The date of t = 0, such as 2026-11-21T00:00:00.")),
        scale=(StrictStr, Field(description="Of that date: UTC, TAI, GPS, TT, TDB, TCB or TCG.")),
        unit=(StrictStr, Field("s", description="Of time: s, min, h or d.")),
    )


def _run(charts: tuple[str, ...]) -> Any:
    return _created(
        "Run",
        method=(_one_of(METHOD_NAMES), Field("integration", description="The closed form is for no forces.")),
        formulation=(_one_of(charts), Field("lie_poisson", description="The variables integrated.")),
        tolerance=(_number("number"), Field(None, description="Relative error in a step; default: rounding.")),
        precision=(_one_of(PRECISIONS), Field("double", description="Of the arithmetic.")),
        dense=(StrictBool, Field(False, description="Integrate as for dense output; the file has the times alone.")),
    )


def _outputs() -> Any:
    names = {"result": ".nc or .zarr; default: the name of this file", "plot": ".png, .pdf or .svg", "view": ".html"}
    return _created(
        "Outputs",
        **{name: (StrictStr, Field(None, description=f"A name that ends in {end}.")) for name, end in names.items()},
    )


def _ensemble() -> Any:
    place = "The number to vary by its place, such as state.omega_body; state.turn turns the attitude about body axes."
    spread = _created(
        "Spread",
        of=(StrictStr, Field(description=place)),
        distribution=(
            _one_of(("normal", "uniform", "isotropic")),
            Field("normal", description="Around the value in this file; isotropic: any attitude, of state.turn."),
        ),
        size=(
            Any,
            Field(None, description="Standard deviation, or half the width: a number, or one for each component."),
        ),
    )
    return _created(
        "Ensemble",
        members=(Annotated[StrictInt, Field(ge=1, le=1_000_000)], Field(description="How many.")),
        seed=(Annotated[StrictInt, Field(ge=0, lt=2**63)], Field(description="Makes the same members again.")),
        spread=(_several(spread), Field(description="What differs between them.")),
    )


def _union(group: str, inner: str) -> Any:
    """Return a table that says by its type which keys it has."""
    models = [Annotated[_model(maker, inner), Tag(name)] for name, maker in makers(group).items()]
    default = DEFAULTS.get(group)

    def type_of(value: Any) -> Any:
        if isinstance(value, BaseModel):
            return value.type  # type: ignore[attr-defined]
        return value.get("type", default) if isinstance(value, Mapping) else None

    return Annotated[Union[tuple(models)], Discriminator(type_of)]  # noqa: UP007


def _model(maker: Maker, inner: str) -> Any:
    default = maker.name if maker.name in DEFAULTS.values() else ...
    fields = {key.name: _field(key, inner) for key in maker.keys}
    return _created(
        maker.name.replace(".", "_"),
        __doc__=maker.help,
        type=(_one_of((maker.name,)), Field(default)),
        **fields,
    )


def _table(name: str, keys: Iterable[Key], said: str) -> Any:
    return _created(name, __doc__=said, **{key.name: _field(key, "") for key in keys})


def _field(key: Key, inner: str) -> Any:
    kinds: dict[str, Callable[[], Any]] = {
        "text": lambda: StrictStr,
        "texts": lambda: StrictStr | list[StrictStr],
        "whole": lambda: StrictInt,
        "truth": lambda: StrictBool,
        "file": lambda: Annotated[StrictStr, WithJsonSchema({"type": "string", "description": FILE_NAME})],
        "files": lambda: list[StrictStr],
        "shape": lambda: _union("shape", ""),
        "shapes": lambda: _several(_union("part", "")),
        "orbit": lambda: Annotated[StrictStr, WithJsonSchema({"type": "string", "description": ORBIT_NAME})],
        "orbits": lambda: list[StrictStr],
        "named": lambda: _named(_number("number", key.rank)),
        "field": lambda: _union(inner, inner),
    }
    annotation = kinds[key.kind]() if key.kind in kinds else _number(key.kind, key.rank)
    if key.required:
        return annotation, Field(description=key.help or None)
    return annotation, Field(key.default, description=key.help or None)


FILE_NAME = "The path of a file, from the folder of this one: in it or below."

ORBIT_NAME = "The name of a table under orbits, or name.from_primary, name.from_secondary."

# ------------------------------------------------------------------ numbers


def _number(kind: str, rank: int = 0) -> Any:
    one: dict[str, Any] = {"type": "number"} if kind == "number" else {"type": ["number", "string"]}
    several: dict[str, Any] = {"type": "array", "items": one if rank < 2 else {"type": "array", "items": one}}
    if rank:
        said = several if rank > 1 else {"type": "array", "items": {"anyOf": [one, several]}}
    else:
        said = {"anyOf": [one, several]}
    return Annotated[Any, BeforeValidator(functools.partial(_checked, kind)), WithJsonSchema(said)]


def _checked(kind: str, value: Any, info: ValidationInfo) -> Any:
    """Return the numbers, those with a unit in radians and units of time; dates as they are."""
    name, unit = str(info.field_name), (info.context or {}).get("time_unit")
    if kind == "time" and _is_date(value):
        return value
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


def _is_date(value: Any) -> bool:
    first = value[0] if isinstance(value, list) and value else value
    return isinstance(first, str) and first[4:5] == "-"


def converted(value: Any, kind: str, unit: str | None, name: str) -> Any:
    """Return a number or nested lists of numbers without texts.

    Raises
    ------
    ValueError
        If there is anything else among them.
    """
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
    text = repr(value) if not isinstance(value, int) or abs(value) < 2**64 else "a large number"
    return text if len(text) <= 40 else text[:37] + "..."
