"""Systems, shapes and observables as the text of a scenario: written, and read again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.observable import Observable
from poinsot.observables.light_curve import Surfaces
from poinsot.orbits.restricted_three_body import CirclingPair
from poinsot.records.calendar import Calendar
from poinsot.records.parameters import Parametric, records_in
from poinsot.scenarios.toml_text import MAX_CHARACTERS, MAX_KEYS, MAX_NUMBERS
from poinsot.shapes.assembly import Assembly
from poinsot.shapes.shape import Shape
from poinsot.systems.system import System

__all__ = ["Text", "rebuilt_observables", "rebuilt_system", "shape_of", "text_of", "text_of_observables"]

MAX_WRITTEN = 100
"""Largest size of an array in a text. The text names longer arrays, which are variables of the same file."""

NO_MORE: Mapping[str, Any] = {}

HEADER = "# Written for a system made in Python. State and times are variables of the file that has this text.\n"


class Text(NamedTuple):
    """A text in TOML, and the arrays that it names as {data = "..."}."""

    text: str
    data: dict[str, NDArray[Any]]


def text_of(system: System, run: Mapping[str, Any]) -> Text:
    """Return body, forces, orbits and units of a system and the options of a run as TOML, numbers with all digits.

    A ValueError names classes from outside the package, and too many numbers.
    """
    writer = _Writer("system")
    _refuse_outside((system.body, *system.forces))
    units = {name: unit for name, unit in system.units.items() if unit != "1"}
    parts = [_table("[units]", units)] if units else []
    parts += [_table("[calendar]", vars(system.calendar))] if system.calendar else []
    parts += [writer.section("[body]", system.body)]
    parts += [writer.section("[[forces]]", force) for force in system.forces]
    return Text(_bounded([HEADER, *parts, *writer.orbits, _table("[run]", dict(run))]), writer.data)


def rebuilt_system(text: str, name: str, *, data: Mapping[str, Any] | None = None) -> System:
    """Return the system alone that a text without state and times describes, which may name arrays in the data."""
    from poinsot.scenarios.builder import Parts

    return Parts(text, name, whole=False, data=data).system()


OF_OBSERVABLES = "# Written for readings, which are variables of the file that has this text.\n"
NO_BODY = "[body]  # of no meaning: the text describes observables alone\nmoments = [1, 1, 1]\n"


def text_of_observables(observables: Mapping[str, Observable], calendar: Calendar | None) -> Text:
    """Return observables by the names of their readings as TOML, with their orbits; numbers have all digits.

    A ValueError names classes from outside the package, and too many numbers.
    """
    _refuse_outside(observables.values())
    writer = _Writer("observable")
    parts = [_table("[calendar]", vars(calendar))] if calendar else []
    parts += [writer.section("[[observe]]", each, {"name": name}) for name, each in observables.items()]
    return Text(_bounded([OF_OBSERVABLES, NO_BODY, *parts, *writer.orbits]), writer.data)


def rebuilt_observables(text: str, name: str, *, data: Mapping[str, Any] | None = None) -> tuple[Observable, ...]:
    """Return the observables that a text describes, which may name arrays in the data."""
    from poinsot.scenarios.builder import Parts

    plans = Parts(text, name, whole=False, data=data).plans(np.zeros(1))
    return tuple(plan.observable for plan in plans)


def _refuse_outside(records: Iterable[Parametric]) -> None:
    """Raise a ValueError for records, or records in them, of classes from outside the package."""
    every = list(_all(records))
    every += [shape for each in every for value in each.definition[1].values() for shape in _shapes_in(value)]
    outside = {type(x).__qualname__: None for x in every if _is_outside(x)}
    if outside:
        raise ValueError(f"the classes of a scenario must be the package's own, got {' and '.join(outside)}.")


def _bounded(parts: Iterable[str]) -> str:
    """Return tables as one text; raise a ValueError for one that is too long to be read."""
    text = "\n".join(parts)
    if len(text) > MAX_CHARACTERS or text.count(",") > MAX_NUMBERS:
        given = text.count(",")
        raise ValueError(f"a scenario must have at most {MAX_NUMBERS} numbers to be stored in a file, got {given}.")
    return text


def shape_of(body: Body, name: str) -> Text | None:
    """Return the shape that a body was made of as the table of a body; None if there is none of the package's own.

    Long arrays begin with the name.
    """
    shape = body.shape
    if shape is None or any(_is_outside(part) for part in _parts_of(shape)):
        return None
    writer = _Writer(name)
    text = _table("[body]", {"type": "Body.from_shape"}) + writer.section("[body.shape]", shape)
    return Text(text, writer.data) if len(text) <= MAX_CHARACTERS and text.count("=") < 0.8 * MAX_KEYS else None


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


def _shapes_in(value: Any) -> tuple[Any, ...]:
    """Return the shapes that a field of a record contains."""
    if isinstance(value, Surfaces):
        return value.each
    return (value,) if isinstance(value, Shape) else ()


class _Writer:
    """Writes records as tables; orbits get a name, each once, and a table of their own."""

    def __init__(self, name: str) -> None:
        self.orbits: list[str] = []
        self.data: dict[str, NDArray[Any]] = {}
        self._name = name
        self._names: dict[int, str] = {}

    def section(self, heading: str, record: Any, more: Mapping[str, Any] = NO_MORE) -> str:
        """Return a record or a shape as a table, the records in it and the parts of a shape as tables in that."""
        kind, made_of = record.definition
        fields: dict[str, Any] = {"type": kind, **more}
        inner = []
        if isinstance(record, Assembly):
            made_of, inner = {}, [self.section(f"[[{heading.strip('[]')}.parts]]", part) for part in _parts_of(record)]
        for name, value in made_of.items():
            records, place = records_in(value), f"{heading.strip('[]')}.{name}"
            if shapes := _shapes_in(value):
                place = f"[{place}]" if len(shapes) == 1 else f"[[{place}]]"
                inner += [self.section(place, each) for each in shapes]
            elif not records:
                fields[name] = self._short_or_named(value)
            elif isinstance(records[0], Orbit | CirclingPair):
                names = [self._name_of(orbit) for orbit in records]
                fields[name] = names if isinstance(value, tuple) else names[0]
            else:
                place = f"[[{place}]]" if isinstance(value, tuple) else f"[{place}]"
                inner += [self.section(place, each) for each in records]
        return "\n".join([_table(heading, fields), *inner])

    def _short_or_named(self, value: Any) -> Any:
        """Return a value, or the name of a long array."""
        if not isinstance(value, np.ndarray) or value.size <= MAX_WRITTEN:
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
