"""A system, and how it was run, as the text of a scenario: what a result needs to be run again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.formulations import formulations
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.parameters import Parametric, records_in
from poinsot.mechanics.state import named
from poinsot.mechanics.system import System
from poinsot.orbits.restricted_three_body import CirclingPair
from poinsot.printable import quoted
from poinsot.propagation.trajectory import Trajectory
from poinsot.shapes.assembly import Assembly
from poinsot.storage.run_record import Method

if TYPE_CHECKING:
    import xarray

__all__ = [
    "METHODS",
    "MOST_CHARACTERS",
    "MOST_KEYS",
    "MOST_NUMBERS",
    "OF_SCENARIOS",
    "SYSTEM",
    "WHOLE",
    "WITH_FILES",
    "Text",
    "shape_of",
    "text_of",
    "with_texts",
]

MOST_CHARACTERS = 1_000_000
"""Of a scenario: what is read in a second."""

MOST_NUMBERS = 20_000
MOST_KEYS = 5_000

OF_SCENARIOS = ("title", "seed", "scenario", "scenario_of", "scenario_read")
"""What a trajectory knows of the scenario that made it, and a file too."""

SYSTEM, WHOLE = "system", "state, times and system"
"""What the text of a scenario in a file is of: the rest is in the variables."""

WITH_FILES = "state, times and system, with files"
"""The scenario names files: what was read from them is in `scenario_read`, the text of the system, and variables."""

METHODS = {
    Method.TAYLOR: "integration",
    Method.TAYLOR_OF_MEMBERS: "integration",
    Method.CLOSED_FORM: "closed form",
}
"""What a scenario calls the methods that it can have."""

MOST_WRITTEN = 100
"""Numbers of one array in a text; longer ones are named there, and are variables beside it."""

HEADER = "# Written for a system made in Python. State and times are variables of the file that has this text.\n"


class Text(NamedTuple):
    """A text in TOML, and the arrays that it names as {data = "..."}."""

    text: str
    data: dict[str, NDArray[Any]]


def text_of(motion: Trajectory) -> Text:
    """Return body, forces, orbits, units and run as TOML, every number with all its digits.

    A ValueError says why one of them cannot be written: a class from outside the package, a motion not computed here.
    """
    if motion.run.method not in METHODS:
        source = f"{motion.run.method} ({motion.run.formulation})"
        raise ValueError(f"a motion must be computed from a state to be run again, got a {source}.")
    system, writer = motion.system, _Writer("system")
    outside = {type(x).__qualname__: None for x in _all((system.body, *system.forces)) if _is_outside(x)}
    if outside:
        raise ValueError(f"the classes of a scenario must be the package's own, got {' and '.join(outside)}.")
    units = {name: unit for name, unit in system.units.items() if unit != "1"}
    parts = [_table("[units]", units)] if units else []
    parts += [_table("[calendar]", vars(system.calendar))] if system.calendar else []
    parts += [writer.section("[body]", system.body)]
    parts += [writer.section("[[forces]]", force) for force in system.forces]
    text = "\n".join([HEADER, *parts, *writer.orbits, _table("[run]", _options(motion))])
    if len(text) > MOST_CHARACTERS or text.count(",") > MOST_NUMBERS:
        given = text.count(",")
        raise ValueError(f"a scenario must have at most {MOST_NUMBERS} numbers to be stored in a file, got {given}.")
    return Text(text, writer.data)


def with_texts(data: xarray.Dataset, motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a motion with the text that makes its system again, or why there can be none.

    Arrays that the text names are variables, and so are those of the body's shape, whose text is `shape`.
    """
    texts, arrays = _texts_of(motion)
    about = {"units": "1", "long_name": "named in a text"}
    own = {
        name: ([f"{name}_axis{i}" for i in range(np.ndim(values))], values, about) for name, values in arrays.items()
    }
    return data.assign(own).assign_attrs(texts)


def _texts_of(motion: Trajectory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the texts of scenario and shape, or why there is none, and the arrays that they name."""
    known = {key: motion.provenance[key] for key in OF_SCENARIOS if motion.provenance.get(key) is not None}
    shapes: dict[str, Any] = {}
    for body, one in zip(motion.initial.of_bodies, motion.system.of_bodies.values(), strict=True):
        name = named(body, "shape")
        if shape := shape_of(one, name):
            known[name] = shape.text
            shapes |= shape.data
    if "scenario" in known and ("scenario_read" in known or known["scenario_of"] != WITH_FILES):
        return known, {**motion.provenance.get("data", {}), **shapes}
    if not isinstance(motion.system, System):
        return known | {"not_rerunnable": motion.system.not_rerunnable}, shapes
    try:
        text = text_of(motion)
    except ValueError as error:
        return known | {"not_rerunnable": str(error)}, shapes
    read = {"scenario_read": text.text} if "scenario" in known else {"scenario": text.text, "scenario_of": SYSTEM}
    return known | read, {**text.data, **shapes}


def shape_of(body: Body, name: str) -> Text | None:
    """Return the shape that a body was made of as the table of a body; None if there is none of the package's own.

    Long arrays begin with the name.
    """
    shape = body.shape
    if shape is None or any(_is_outside(part) for part in _parts_of(shape)):
        return None
    writer = _Writer(name)
    text = _table("[body]", {"type": "Body.from_shape"}) + writer.section("[body.shape]", shape)
    return Text(text, writer.data) if len(text) <= MOST_CHARACTERS and text.count("=") < 0.8 * MOST_KEYS else None


def _parts_of(shape: Any) -> Iterator[Any]:
    """Yield a shape, or the parts of one that has parts."""
    if not isinstance(shape, Assembly):
        yield shape
        return
    for part in shape.parts:
        yield from _parts_of(part)


def _is_outside(record: Any) -> bool:
    return type(record).__module__.partition(".")[0] != "poinsot"


def _all(records: Iterable[Parametric]) -> Iterator[Parametric]:
    for record in records:
        yield record
        yield from _all(record.records)


def _options(motion: Trajectory) -> dict[str, Any]:
    run, known = motion.run, formulations()
    if run.method is Method.CLOSED_FORM:
        return {"method": "closed form"}
    if run.formulation not in known:
        raise ValueError(
            f"the formulation of a scenario must be one of {', '.join(known)}, got {quoted(run.formulation)}."
        )
    options = {"formulation": run.formulation, "tolerance": run.tolerance, "precision": run.precision}
    return options | ({"dense": True} if motion.has_dense_output else {})


class _Writer:
    """Writes records as tables; orbits get a name, each once, and a table of their own."""

    def __init__(self, name: str) -> None:
        self.orbits: list[str] = []
        self.data: dict[str, NDArray[Any]] = {}
        self._name = name
        self._names: dict[int, str] = {}

    def section(self, heading: str, record: Any) -> str:
        """Return a record or a shape as a table, the records in it and the parts of a shape as tables in that."""
        kind, made_of = record.definition
        fields: dict[str, Any] = {"type": kind}
        inner = []
        if isinstance(record, Assembly):
            made_of, inner = {}, [self.section(f"[[{heading.strip('[]')}.parts]]", part) for part in _parts_of(record)]
        for name, value in made_of.items():
            records, place = records_in(value), f"{heading.strip('[]')}.{name}"
            if not records:
                fields[name] = self._kept(value)
            elif isinstance(records[0], Orbit | CirclingPair):
                names = [self._name_of(orbit) for orbit in records]
                fields[name] = names if isinstance(value, tuple) else names[0]
            else:
                place = f"[[{place}]]" if isinstance(value, tuple) else f"[{place}]"
                inner += [self.section(place, each) for each in records]
        return "\n".join([_table(heading, fields), *inner])

    def _kept(self, value: Any) -> Any:
        """Return a value, or the name of a long array."""
        if not isinstance(value, np.ndarray) or value.size <= MOST_WRITTEN:
            return value
        name = f"{self._name}_{len(self.data) + 1}"
        self.data[name] = value
        return {"data": name}

    def _name_of(self, orbit: Any) -> str:
        if id(orbit) not in self._names:
            self._names[id(orbit)] = name = f"orbit{len(self._names) + 1}"
            self.orbits.append(self.section(f"[orbits.{name}]", orbit))
        return self._names[id(orbit)]


def _table(heading: str, fields: dict[str, Any]) -> str:
    lines = (f"{name} = {_written(value)}" for name, value in fields.items())
    return "\n".join([heading, *lines, ""])


def _written(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {_written(item)}' for key, item in value.items())}}}"
    if isinstance(value, bool):
        return str(value).lower()
    plain = value if isinstance(value, int | list) else np.asarray(value).tolist()
    if isinstance(plain, list):
        return f"[{', '.join(map(_written, plain))}]"
    return repr(plain) if math.isfinite(plain) else str(plain)
