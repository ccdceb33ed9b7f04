"""A system, and how it was run, as the text of a scenario: what a result needs to be run again."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.parameters import Parametric, kinds_of
from poinsot.shapes.solids import Solid

if TYPE_CHECKING:
    from poinsot.propagation.trajectory import Trajectory

__all__ = ["METHODS", "MOST_CHARACTERS", "MOST_NUMBERS", "Text", "shape_of", "text_of"]

MOST_CHARACTERS = 1_000_000
"""Of a scenario: what is read in a second."""

MOST_NUMBERS = 20_000

METHODS = {"Taylor": "integration", "Taylor, members in batches": "integration", "closed form": "closed form"}
"""How a trajectory says that it was computed, and what a scenario calls it."""

MOST_WRITTEN = 100
"""Numbers of one array in a text; longer ones are named there, and are variables beside it."""

HEADER = "# Written for a system made in Python. State and times are variables of the file that has this text.\n"


class Text(NamedTuple):
    """A text in TOML, and the arrays that it names as {data = "..."}."""

    text: str
    data: dict[str, NDArray[Any]]


def text_of(motion: Trajectory) -> Text:
    """Return body, forces, orbits, units and run as TOML, every number with all its digits.

    Raises
    ------
    ValueError
        With a sentence, if one of them cannot be written: a class from outside the package, or a motion that was not
        computed here.
    """
    if motion.run.method not in METHODS:
        raise ValueError(
            f"a motion must be computed from a state to be run again, but this one is a {_source(motion)}."
        )
    system, writer = motion.system, _Writer("system")
    _check(system.body, *system.forces)
    units = {name: unit for name, unit in system.units.items() if unit != "1"}
    parts = [
        _table("[units]", units) if units else "",
        _table("[calendar]", vars(system.calendar)) if system.calendar else "",
        writer.section("[body]", system.body),
        *(writer.section("[[forces]]", force) for force in system.forces),
    ]
    text = "\n".join([HEADER, *filter(None, parts), *writer.orbits, _table("[run]", _options(motion))])
    if len(text) > MOST_CHARACTERS or text.count(",") > MOST_NUMBERS:
        raise ValueError(
            f"a scenario must have at most {MOST_NUMBERS} numbers to be kept in a file, but this one has "
            f"{text.count(',')}."
        )
    return Text(text, writer.data)


def shape_of(motion: Trajectory) -> Text | None:
    """Return the shape that the body was made of as the table of a body; None if there is none of the package's own."""
    shape = motion.system.body.shape
    if shape is None or any(_is_outside(part) for part in _parts_of(shape)):
        return None
    writer = _Writer("shape")
    text = _table("[body]", {"type": "Body.from_shape"}) + writer.shape("[body.shape]", shape)
    return Text(text, writer.data) if len(text) <= MOST_CHARACTERS and text.count("=") < MOST_KEYS else None


MOST_KEYS = 4_000
"""Of the text of a shape."""


def _parts_of(shape: Any) -> Iterator[Any]:
    """Yield a shape, or the parts of one that has parts."""
    if not hasattr(shape, "parts"):
        yield shape
        return
    for part in shape.parts:
        yield from _parts_of(part)


def _is_outside(record: Any) -> bool:
    return type(record).__module__.partition(".")[0] != "poinsot"


def _source(motion: Trajectory) -> str:
    return f"{motion.run.method} ({motion.run.formulation})"


def _check(*records: Any) -> None:
    """Refuse what no file can name, all of it at once."""
    outside = {type(x).__qualname__: None for x in _all(records) if _is_outside(x)}
    if outside:
        raise ValueError(f"the classes of a scenario must be the package's own, got {' and '.join(outside)}.")


def _all(records: Any) -> Iterator[Parametric]:
    for record in records:
        yield record
        yield from _all(record.parts)


def _options(motion: Trajectory) -> dict[str, Any]:
    run = motion.run
    if METHODS[run.method] == "closed form":
        return {"method": "closed form"}
    options = {"formulation": run.formulation, "tolerance": run.tolerance, "precision": run.precision}
    return options | ({"dense": True} if motion.has_dense_output else {})


class _Writer:
    """Writes records as tables; those of the sky get a name, each once, and a table of their own."""

    def __init__(self, name: str) -> None:
        self.orbits: list[str] = []
        self.data: dict[str, NDArray[Any]] = {}
        self._name = name
        self._names: dict[int, str] = {}

    def section(self, heading: str, record: Parametric) -> str:
        fields: dict[str, Any] = {"type": type(record).__name__}
        inner = []
        for name, value in _fields_of(record).items():
            if not isinstance(value, Parametric):
                fields[name] = self._kept(value)
            elif isinstance(value, Orbit) or _holds_orbits(value):
                fields[name] = self._name_of(value)
            else:
                inner.append(self.section(f"[{heading.strip('[]')}.{name}]", value))
        return "\n".join([_table(heading, fields), *inner])

    def shape(self, heading: str, shape: Any) -> str:
        """Return a shape as a table, its parts as tables in it."""
        name = heading.strip("[]")
        if hasattr(shape, "parts"):
            parts = [self.shape(f"[[{name}.parts]]", part) for part in _parts_of(shape)]
            return "\n".join([_table(heading, {"type": type(shape).__name__}), *parts])
        fields = {key: self._kept(value) for key, value in _of_shape(shape).items()}
        return _table(heading, {"type": type(shape).__name__, **fields})

    def _kept(self, value: Any) -> Any:
        """Return a value, or the name of a long array."""
        if not isinstance(value, np.ndarray) or value.size <= MOST_WRITTEN:
            return value
        name = f"{self._name}_{len(self.data) + 1}"
        self.data[name] = value
        return {"data": name}

    def _name_of(self, orbit: Parametric) -> str:
        if id(orbit) not in self._names:
            self._names[id(orbit)] = name = f"orbit{len(self._names) + 1}"
            self.orbits.append(self.section(f"[orbits.{name}]", orbit))
        return self._names[id(orbit)]


def _fields_of(record: Parametric) -> dict[str, Any]:
    """Return the fields of a record by name; in the place of a table, what it is made of."""
    if hasattr(record, "pieces"):
        return _of_pieces(record)
    return {name: getattr(record, name) for name in kinds_of(type(record))}


def _of_pieces(orbit: Any) -> dict[str, Any]:
    pieces = orbit.pieces
    names = ("knots", "coefficients", "reference_frame", "origin")
    error = {} if math.isnan(pieces.error) else {"error": pieces.error}
    dated = pieces.calendar is not None
    return {"mu": orbit.mu, **{name: getattr(pieces, name) for name in names}, **error, "dated": dated} | {
        "radius": orbit.radius
    }


OF_SHAPES = {
    "Mesh": ("vertices", "faces"),
    "Mascons": ("masses", "positions"),
    "Ellipsoid": ("semiaxes",),
    "Cylinder": ("radius", "height"),
}
"""What shapes are made of, but for mass and place."""


def _of_shape(shape: Any) -> dict[str, Any]:
    fields = {name: getattr(shape, name) for name in OF_SHAPES[type(shape).__name__]}
    if type(shape).__name__ != "Mascons":
        fields["mass"] = shape.mass
    if isinstance(shape, Solid):
        fields |= {"position": shape.center_of_mass, "matrix": shape._axes}
    return fields


def _holds_orbits(record: Parametric) -> bool:
    """Whether orbits are seen from it, as a path beside two attractors."""
    return hasattr(record, "from_primary")


def _table(heading: str, fields: dict[str, Any]) -> str:
    lines = (f"{name} = {_written(value)}" for name, value in fields.items())
    return "\n".join([heading, *lines, ""])


@functools.singledispatch
def _written(value: Any) -> str:
    array = np.asarray(value)
    return _nested(array.tolist())


@_written.register
def _(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")


@_written.register
def _(value: dict) -> str:  # type: ignore[type-arg]
    return f"{{{', '.join(f'{key} = {_written(item)}' for key, item in value.items())}}}"


@_written.register
def _(value: bool) -> str:
    return str(value).lower()


@_written.register
def _(value: int) -> str:
    return str(value)


def _nested(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_nested, value))}]"
    return repr(value) if math.isfinite(value) else str(value)
