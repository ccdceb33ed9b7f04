"""A system with another value of one of its named numbers."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np

from poinsot.mechanics.parameter_names import named_numbers, resolve
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.system import System

__all__ = ["NamedNumber"]


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
        indices = resolve(system, name)
        self.name = next(full for full, numbers in named_numbers(system).items() if numbers == indices)
        self._system = system
        part, *inner, last = self.name.split(".")
        record: Any = system.body if part == "body" else system.forces[int(part[len("forces[") : -1])]
        for field in inner:
            record = getattr(record, field)
        self._owner, self._field = record, last.partition("[")[0]
        self._index = tuple(int(i) for i in re.findall(r"\[(\d+)\]", last))
        self.value = float(np.asarray(getattr(record, self._field))[self._index])

    def system(self, value: float) -> System:
        """Return the system with another value, checked as if it were written so."""
        made: dict[int, Any] = {}
        body, *forces = (self._replaced(record, value, made) for record in (self._system.body, *self._system.forces))
        return System(body, *forces, units=self._system.units)

    def _replaced(self, record: Parametric, value: float, made: dict[int, Any]) -> Any:
        if id(record) not in made:
            fields: Any = dataclasses.fields(record)  # type: ignore[arg-type]
            own = {field.name: getattr(record, field.name) for field in fields}
            new = {n: self._replaced(x, value, made) if isinstance(x, Parametric) else x for n, x in own.items()}
            if record is self._owner:
                array = np.array(own[self._field], dtype=float)
                array[self._index] = value
                new[self._field] = array
            changed = any(new[n] is not x for n, x in own.items())
            made[id(record)] = type(record)(**new) if changed else record
        return made[id(record)]
