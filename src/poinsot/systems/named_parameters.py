"""The real numbers of a system by name, `body.moments[0]`, `forces[0].orbit.eccentricity`, and other values of them."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.environment import Orbit
from poinsot.printable import quoted
from poinsot.quantities import Quantity, annotated_with
from poinsot.records.parameters import Parametric, of_each
from poinsot.systems.dynamics import AnyDynamics
from poinsot.systems.system import System

__all__ = [
    "NamedNumber",
    "binary_size",
    "named_numbers",
    "names_of_numbers",
    "names_of_system",
    "number_of",
    "refuse_integrated",
    "refuse_name_of_number",
    "resolve",
    "with_numbers",
]

Record = TypeVar("Record", bound=Parametric)


def named_numbers(system: System) -> dict[str, tuple[int, ...]]:
    """Return which of the numbers each name stands for: several where forces share one orbit.

    They are counted between two knots, and the numbers of tables have no names.
    """
    count = {name: i for i, (name, _) in enumerate(names_of_system(system.dynamics.between_knots()))}
    groups: dict[tuple[int, str], list[str]] = {}
    for name, own in names_of_system(system.dynamics):
        groups.setdefault(own, []).append(name)
    return {names[0]: tuple(count[name] for name in names) for names in groups.values() if names[0] in count}


Own = tuple[int, str]
"""Identity of a number: the record that has it, and its name there."""


def names_of_system(system: AnyDynamics) -> list[tuple[str, Own]]:
    """Return the name and the identity of each number of the body and the forces."""
    forces = [(f"forces[{i}]", force) for i, force in enumerate(system.forces)]
    return names_of_numbers([("body", system.body), *forces])


def names_of_numbers(records: Iterable[tuple[str, Parametric]]) -> list[tuple[str, Own]]:
    """Return the name and the identity of each number of named records, in the order of `numbers`."""
    return [(f"{start}.{name}", own) for start, record in records for name, own in record.number_names()]


def resolve(system: System, name: str) -> tuple[int, ...]:
    """Return which of the numbers a name stands for; its last parts will do where they say which.

    Raises
    ------
    ValueError
        With the nearest names if there is none or more than one; or if an orbit is integrated from it.
    """
    known = named_numbers(system)
    full = [each for each in known if each == name or each.endswith(f".{name}")]
    if len(full) != 1:
        refuse_name_of_number(name, full, known, "the system")
    refuse_integrated(system.orbits, dict(names_of_system(system.dynamics))[full[0]], name)
    return known[full[0]]


def refuse_name_of_number(name: str, found: Sequence[str], known: Iterable[str], owner: str) -> NoReturn:
    """Raise a ValueError about a name that stands for no number or for several, with the nearest names."""
    import difflib

    tails = {each.rpartition(".")[2]: each for each in known}
    last = str(name).rpartition(".")[2]
    near = found or [tails[tail] for tail in difflib.get_close_matches(last, tails, 3, 0.0)]
    raise ValueError(f"parameters must name single numbers of {owner}, got {quoted(name)}. Near: {', '.join(near)}.")


def refuse_integrated(orbits: Iterable[Orbit], own: Own, name: str) -> None:
    """Raise a ValueError if a number belongs to an orbit that is integrated with the motion."""
    if own[0] in {owner for orbit in orbits if not orbit.closed_form for owner in _owners(orbit)}:
        raise ValueError(
            f"parameters must not belong to an orbit that is integrated with the motion, got {quoted(name)}. "
            "Take differences of two runs."
        )


def _owners(record: Parametric) -> set[int]:
    return {id(record), *(own for part in record.records for own in _owners(part))}


def _full_name(system: System, name: str) -> str:
    indices = resolve(system, name)
    return next(full for full, numbers in named_numbers(system).items() if numbers == indices)


def _found(system: System, name: str) -> tuple[Any, str, tuple[int, ...]]:
    """Return the record that has a number, by its full name, the field, and the place in an array."""
    part, *inner, last = name.split(".")
    record: Any = system.body if part == "body" else system.forces[int(part[len("forces[") : -1])]
    for field in inner:
        name, _, number = field.rstrip("]").partition("[")
        record = getattr(record, name)[int(number)] if number else getattr(record, name)
    return record, *_split(last)


def binary_size(system: System, name: str) -> Any:
    """Return the binary exponent of about what a number changes by: of its size above one, 0 of angles and times.

    Of an ensemble whose members have numbers of their own an array (members,).

    Times and angles are counted from anywhere; so may be numbers below one, such as eccentricities.
    """
    record, field, index = _found(system, _full_name(system, name))
    if field in annotated_with(type(record), Quantity):
        return 0
    place: Any = (..., *index)
    return np.maximum(np.frexp(np.abs(getattr(record, field)[place]))[1], 0)


class NamedNumber:
    """One real number of a system, by name; of an orbit that several forces share, one for all of them.

    Parameters
    ----------
    system : System
    name : str
        As for `state_transition`.

    Attributes
    ----------
    name : str
        In full.
    value : float
        In the system.
    """

    def __init__(self, system: System, name: str) -> None:
        self._system, self.name = system, _full_name(system, name)
        self._owner, field, index = _found(system, self.name)
        self._place = field + "".join(f"[{i}]" for i in index)
        self.value = float(np.asarray(getattr(self._owner, field))[index])

    def system(self, value: float) -> System:
        """Return the system with another value, checked as if it were written so."""
        made, _ = with_numbers(self._system, (), {(id(self._owner), self._place): np.asarray(value)})
        return made


def with_numbers(
    system: System, records: Sequence[Record], values: Mapping[Own, NDArray[np.float64]]
) -> tuple[System, list[Record]]:
    """Return a system and further records with other numbers; records that were shared are shared again.

    Parameters
    ----------
    system : System
    records : sequence of Parametric
        Records such as observables, which may share orbits with the system.
    values : mapping
        New values by the identities of the numbers; an array (members,) gives each member a value of its own.
    """
    made: dict[int, Any] = {}
    changes: dict[int, list[tuple[str, NDArray[np.float64]]]] = {}
    for (owner, place), value in values.items():
        changes.setdefault(owner, []).append((place, value))
    body, *forces = (_replaced(each, changes, made) for each in (system.body, *system.forces))
    changed = body is not system.body or any(new is not old for new, old in zip(forces, system.forces, strict=True))
    whole = System(body, *forces, units=system.units) if changed else system
    return whole, [_replaced(each, changes, made) for each in records]


def number_of(records: Iterable[Parametric], own: Own) -> NDArray[np.float64]:
    """Return the value of a number of some records by its identity."""
    owner, place = own
    found = next(each for record in records for each in _within(record) if id(each) == owner)
    field, index = _split(place)
    components: Any = (..., *index)
    return np.asarray(np.asarray(getattr(found, field), dtype=float)[components])


def _within(record: Parametric) -> Iterator[Parametric]:
    yield record
    for part in record.records:
        yield from _within(part)


def _split(place: str) -> tuple[str, tuple[int, ...]]:
    """Return the field of a number, and its place in an array."""
    return place.partition("[")[0], tuple(int(i) for i in re.findall(r"\[(\d+)\]", place))


def _replaced(record: Any, changes: Mapping[int, list[tuple[str, NDArray[np.float64]]]], made: dict[int, Any]) -> Any:
    if id(record) not in made:
        fields: Any = dataclasses.fields(record)
        own = {field.name: getattr(record, field.name) for field in fields}
        new = {name: of_each(value, lambda inner: _replaced(inner, changes, made)) for name, value in own.items()}
        for place, value in changes.get(id(record), ()):
            field, index = _split(place)
            old = np.asarray(new[field], dtype=float)
            array = np.array(np.broadcast_to(old, np.broadcast_shapes(old.shape, (*value.shape, *(1,) * len(index)))))
            components: Any = (..., *index)
            array[components] = value
            new[field] = array
        changed = any(new[name] is not value for name, value in own.items())
        made[id(record)] = type(record)(**new) if changed else record
    return made[id(record)]
