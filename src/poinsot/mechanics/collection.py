"""Records taken together: their numbers in one row, their orbits, the times at which they change."""

from __future__ import annotations

import functools
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.functions import Scalar
from poinsot.immutable import Immutable, cached_property
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Dated, Orbit, frames_of, within
from poinsot.mechanics.members import common_axis, expanded
from poinsot.mechanics.parameters import Parametric, union_of_knots

__all__ = ["Collection"]

Answer = TypeVar("Answer")

KNOT_ROUNDINGS = 64
"""Largest difference of equal knots of two tables, in roundings of the time."""


class Collection(Immutable):
    """Records taken together, such as a body and the forces on it, with the numbers of all of them."""

    @property
    @abstractmethod
    def records(self) -> tuple[Parametric, ...]:
        """The records."""

    @property
    def definition(self) -> tuple[Any, ...]:
        """The records, and the units of a system."""
        return *self.records, getattr(self, "units", None)

    @abstractmethod
    def with_records(self, records: Iterable[Any]) -> Self:
        """Return the same of other records, unchecked."""

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations, without any real number."""
        return tuple(record.structure for record in self.records)

    @cached_property
    def alike(self) -> Answers:
        """What is known of all collections of the same structure: their formulas are one."""
        return answers_of(self.structure)

    def known(self, question: Callable[..., Any], *given: Any) -> Any:
        """Return the answer to a question about the formulas, whatever the numbers: it is asked once of a structure."""
        answers = self.alike
        if question not in answers:
            answers[question] = question(self, *given)
        return answers[question]

    def once(self, question: Callable[[Self], Answer]) -> Answer:
        """Return the answer to a question about the collection with its numbers: it is asked once."""
        if question not in self._once:
            self._once[question] = question(self)
        answer: Answer = self._once[question]
        return answer

    @cached_property
    def _once(self) -> dict[Callable[..., Any], Any]:
        return {}

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
        knots = union_of_knots(self.records)
        if not knots.size:
            return knots
        return knots[np.diff(knots, prepend=-np.inf) > KNOT_ROUNDINGS * np.spacing(np.abs(knots))]

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
        return next((calendar for calendar in self._said("calendar") if calendar is not None), None)

    @cached_property
    def _dated(self) -> list[Dated]:
        """The orbits, rotation models and fields of its records."""
        return [part for record in self.records for part in within(record) if isinstance(part, Dated)]

    def _said(self, name: str) -> Iterator[Any]:
        """Yield an attribute of orbits, rotation models and fields."""
        return (getattr(part, name) for part in self._dated)

    def between_knots(self, time: ArrayLike | None = None) -> Self:
        """Return what it is between the knots around a time, by default the first two."""
        if not self.knots.size:
            return self
        time = 0.5 * (self.knots[0] + self.knots[1]) if time is None else time
        return self.with_records(record.between_knots(time) for record in self.records)

    def beside(self, shape: tuple[int, ...]) -> Self:
        """Return the same with numbers that broadcast against arrays of a shape, members first.

        It is kept, with what its orbits have computed.
        """
        axes = len(shape)
        if axes not in self._twins:
            self._twins[axes] = self.with_numbers(expanded(number, axes) for number in self.numbers)
        return self._twins[axes]

    @cached_property
    def _twins(self) -> dict[int, Self]:
        return {}

    def with_numbers(self, scalars: Iterable[Scalar]) -> Self:
        """Return the same on other scalars: runtime parameters, symbols, arrays."""
        scalars = iter(scalars)
        return self.with_records(record.with_numbers(scalars) for record in self.records)

    def refuse_other_axes(self) -> None:
        """Raise a ValueError for orbits and rotation models along different axes, or with different calendars."""
        frames = frames_of(self._said("reference_frame"))
        calendars = dict.fromkeys(calendar for calendar in self._said("calendar") if calendar is not None)
        for what, found in (("reference frame", frames), ("calendar", calendars)):
            if len(found) > 1:
                first, second, *_ = found
                hint = " Make one, and give calendar= to all." if what == "calendar" else ""
                if SPACE_AXES_UNNAMED in found:
                    hint = " Give reference_frame= to the one or the other."
                raise ValueError(f"the orbits of a system must have one {what}, got {first} and {second}.{hint}")


class Answers(dict[Callable[..., Any], Any]):
    """Results about a structure by the function that computed them; another process computes them again.

    Attributes
    ----------
    by_variables : dict
        Results for integrated variables of one structure.
    """

    def __init__(self, structure: tuple[Any, ...]) -> None:
        super().__init__()
        self.structure = structure
        self.by_variables: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return answers_of, (self.structure,)


@functools.lru_cache(256)
def answers_of(structure: tuple[Any, ...]) -> Answers:
    """Return the answers about a structure, the same for all collections that have it."""
    return Answers(structure)
