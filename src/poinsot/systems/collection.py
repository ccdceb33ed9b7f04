"""Records taken together: their numbers in one row, their orbits, the times at which they change."""

from __future__ import annotations

import functools
from collections.abc import Hashable, Iterable, Iterator
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.functions import Scalar
from poinsot.immutable import Immutable, cached_property
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Dated, Orbit, frames_of, within
from poinsot.records.calendar import Calendar
from poinsot.records.members import common_axis, expanded
from poinsot.records.parameters import Parametric, Tabulated, union_of_knots

__all__ = ["Collection", "knots_of", "results_of"]

KNOT_ROUNDINGS = 64
"""Largest difference of equal knots of two tables, in roundings of the time."""


class Collection(Immutable):
    """Records taken together, such as a body and the forces on it, with the numbers of all of them."""

    records: tuple[Parametric, ...]
    results: Results
    """Results for the collection with its numbers."""

    def __init__(self, records: tuple[Any, ...]) -> None:
        vars(self).update(records=records, results=Results())

    @property
    def definition(self) -> tuple[Parametric, ...]:
        """The records, which define the collection."""
        return self.records

    def with_records(self, records: Iterable[Any]) -> Self:
        """Return the collection with other records, unchecked."""
        twin = object.__new__(type(self))
        Collection.__init__(twin, tuple(records))
        twin._name_records()
        return twin

    def _name_records(self) -> None:
        """Set the attributes that name some of the records."""

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """Classes, integers and names that select the equations, without any real number."""
        return tuple(record.structure for record in self.records)

    @cached_property
    def alike(self) -> ResultsOfStructure:
        """Results that all collections of the same structure share, since their formulas are the same."""
        return results_of(self.structure)

    @cached_property
    def numbers(self) -> tuple[NDArray[np.float64], ...]:
        """The real parameters of the records, in the order in which `with_numbers` takes them."""
        return tuple(number for record in self.records for number in record.numbers)

    @cached_property
    def members(self) -> tuple[int, ...]:
        """The shape of the member axis of the numbers: () for one body, (members,) for an ensemble."""
        return common_axis("body and forces", {number.shape for number in self.numbers})

    @cached_property
    def orbits(self) -> tuple[Orbit, ...]:
        """The orbits of its records, one as often as it is there."""
        return tuple([part for part in self._dated if isinstance(part, Orbit)])

    @cached_property
    def knots(self) -> NDArray[np.float64]:
        """Times, ascending, at which the tables of its orbits change their polynomials; of equal ones, the first."""
        return knots_of(self.records)

    @cached_property
    def span(self) -> tuple[float, float]:
        """The first and the last time at which all its orbits, fields and tables are known."""
        first, last = -np.inf, np.inf
        for part in self._dated:
            begin, end = part.span
            first, last = max(first, begin), min(last, end)
        return first, last

    @cached_property
    def calendar(self) -> Calendar | None:
        """Calendar of the times; None if no orbit and no rotation model has a calendar."""
        return next((calendar for calendar in self._values_of("calendar") if calendar is not None), None)

    @cached_property
    def _dated(self) -> list[Dated]:
        """The orbits, rotation models and fields of its records."""
        return [part for record in self.records for part in within(record) if isinstance(part, Dated)]

    def _values_of(self, name: str) -> Iterator[Any]:
        """Yield an attribute of orbits, rotation models and fields."""
        return (getattr(part, name) for part in self._dated)

    def between_knots(self, time: ArrayLike | None = None) -> Self:
        """Return the collection between the knots around a time, by default the first two."""
        if not self.knots.size:
            return self
        time = 0.5 * (self.knots[0] + self.knots[1]) if time is None else time
        return self.with_records(record.between_knots(time) for record in self.records)

    def broadcast_to(self, shape: tuple[int, ...]) -> Self:
        """Return a copy with numbers that broadcast against arrays of a shape, members first.

        Later calls return the same copy, with the results that its orbits have computed.
        """
        axes = len(shape)
        if axes not in self.results:
            self.results[axes] = self.with_numbers(expanded(number, axes) for number in self.numbers)
        found: Self = self.results[axes]
        return found

    def with_numbers(self, scalars: Iterable[Scalar]) -> Self:
        """Return the collection on other scalars: runtime parameters, symbols, arrays."""
        scalars = iter(scalars)
        return self.with_records([record.with_numbers(scalars) for record in self.records])

    def refuse_other_axes(self) -> None:
        """Raise a ValueError for orbits and rotation models along different axes, or with different calendars."""
        frames = frames_of(self._values_of("reference_frame"))
        calendars = dict.fromkeys(calendar for calendar in self._values_of("calendar") if calendar is not None)
        for what, found in (("reference frame", frames), ("calendar", calendars)):
            if len(found) > 1:
                first, second, *_ = found
                hint = " Make one, and give calendar= to all." if what == "calendar" else ""
                if SPACE_AXES_UNNAMED in found:
                    hint = " Give reference_frame= to the one or the other."
                raise ValueError(f"the orbits of a system must have one {what}, got {first} and {second}.{hint}")


class Results(dict[Hashable, Any]):
    """Results about a collection by the name or the function that computed them; a copy of the collection has none."""

    def __reduce__(self) -> tuple[Any, ...]:
        return Results, ()


class ResultsOfStructure(Results):
    """Results about a structure by the name or the function that computed them; another process computes them again.

    Attributes
    ----------
    by_variables : dict
        Results for integrated variables of one structure.
    """

    def __init__(self, structure: tuple[Any, ...]) -> None:
        super().__init__()
        self.structure = structure
        self.by_variables: dict[Any, Any] = {}

    @override
    def __reduce__(self) -> tuple[Any, ...]:
        return results_of, (self.structure,)


@functools.lru_cache(256)
def results_of(structure: tuple[Any, ...]) -> ResultsOfStructure:
    """Return the results about a structure, the same for all collections with it."""
    return ResultsOfStructure(structure)


def knots_of(records: Iterable[Tabulated]) -> NDArray[np.float64]:
    """Return the knots of the tables of records, ascending; the first of several knots that are equal to rounding."""
    knots = union_of_knots(records)
    if not knots.size:
        return knots
    return knots[np.diff(knots, prepend=-np.inf) > KNOT_ROUNDINGS * np.spacing(np.abs(knots))]
