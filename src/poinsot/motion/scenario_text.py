"""A system, and how it was run, as the text of a scenario: what a result needs to be run again."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.mechanics.parameters import Parametric, Table, kinds_of
from poinsot.mechanics.sky import Orbit

if TYPE_CHECKING:
    from poinsot.motion.trajectory import Trajectory

__all__ = ["METHODS", "MOST_CHARACTERS", "MOST_NUMBERS", "text_of"]

MOST_CHARACTERS = 1_000_000
"""Of a scenario: what is read in a second."""

MOST_NUMBERS = 20_000

METHODS = {"Taylor": "integration", "Taylor, members in batches": "integration", "closed form": "closed form"}
"""How a trajectory says that it was computed, and what a scenario calls it."""

HEADER = "# Written for a system made in Python. State and times are variables of the file that has this text.\n"


def text_of(motion: Trajectory) -> str:
    """Return body, forces, orbits, units and run as TOML, every number with all its digits.

    Raises
    ------
    ValueError
        With a sentence, if one of them cannot be written: a class from outside the package, an orbit that is a table,
        or a motion that was not computed here.
    """
    if motion.run.method not in METHODS:
        raise ValueError(
            f"a motion must be computed from a state to be run again, but this one is a {_source(motion)}."
        )
    system, writer = motion.system, _Writer()
    _check(system.body, *system.forces)
    units = {name: unit for name, unit in system.units.items() if unit != "1"}
    parts = [
        _table("[units]", units) if units else "",
        writer.section("[body]", system.body),
        *(writer.section("[[forces]]", force) for force in system.forces),
    ]
    text = "\n".join([HEADER, *filter(None, parts), *writer.orbits, _table("[run]", _options(motion))])
    if len(text) > MOST_CHARACTERS or text.count(",") > MOST_NUMBERS:
        raise ValueError(
            f"a scenario must have at most {MOST_NUMBERS} numbers to be kept in a file, but this one has "
            f"{text.count(',')}."
        )
    return text


def _source(motion: Trajectory) -> str:
    return f"{motion.run.method} ({motion.run.formulation})"


def _check(*records: Any) -> None:
    """Refuse what no file can name, all of it at once."""
    everything = list(_all(records))
    outside = {type(x).__qualname__: None for x in everything if type(x).__module__.partition(".")[0] != "poinsot"}
    if outside:
        raise ValueError(f"the classes of a scenario must be the package's own, but {_listed(outside)} came.")
    tables = {
        type(x).__qualname__: None for x in everything if any(isinstance(value, Table) for value in vars(x).values())
    }
    if tables:
        raise ValueError(f"the orbits of a scenario must be given by parameters, but {_listed(tables)} is a table.")


def _listed(names: Any) -> str:
    return " and ".join(names)


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

    def __init__(self) -> None:
        self.orbits: list[str] = []
        self._names: dict[int, str] = {}

    def section(self, heading: str, record: Parametric) -> str:
        fields: dict[str, Any] = {"type": type(record).__name__}
        inner = []
        for name in kinds_of(type(record)):
            value = getattr(record, name)
            if not isinstance(value, Parametric):
                fields[name] = value
            elif isinstance(value, Orbit) or _holds_orbits(value):
                fields[name] = self._name_of(value)
            else:
                inner.append(self.section(f"[{heading.strip('[]')}.{name}]", value))
        return "\n".join([_table(heading, fields), *inner])

    def _name_of(self, orbit: Parametric) -> str:
        if id(orbit) not in self._names:
            self._names[id(orbit)] = name = f"orbit{len(self._names) + 1}"
            self.orbits.append(self.section(f"[orbits.{name}]", orbit))
        return self._names[id(orbit)]


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
def _(value: bool) -> str:
    return str(value).lower()


@_written.register
def _(value: int) -> str:
    return str(value)


def _nested(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_nested, value))}]"
    return repr(value) if math.isfinite(value) else str(value)
