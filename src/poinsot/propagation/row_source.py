"""Sources of the rows of a motion: arrays in memory, rows computed on first access, and stores of ensembles."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.immutable import cached_property, read_only
from poinsot.mechanics.state import RIGID, Phase, changed
from poinsot.propagation.event_record import NO_EVENTS, EventRecords
from poinsot.storage.selection import Chosen, rows_of

if TYPE_CHECKING:
    from poinsot.storage.ensemble_store import EnsembleStore

__all__ = [
    "Columns",
    "ComputedRows",
    "LazyColumns",
    "MemoryRows",
    "RowSource",
    "StoreRows",
    "recorded_columns",
    "selected",
]

Array = NDArray[np.float64]
Columns = Mapping[str, Array]
"""Recorded columns by name. Arrays of a store have the interface of arrays and are read when they are indexed."""

Summary = Mapping[str, str | float]


class LazyColumns(Columns):
    """Columns by name, each read on first access.

    Parameters
    ----------
    read : mapping
        Functions that return the columns.
    """

    def __init__(self, read: Mapping[str, Callable[[], Array]]) -> None:
        self._read = read
        self._known: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._known:
            self._known[name] = self._read[name]()
        return self._known[name]

    def __contains__(self, name: object) -> bool:  # without reading the column
        return name in self._read

    def __iter__(self) -> Iterator[str]:
        return iter(self._read)

    def __len__(self) -> int:
        return len(self._read)

    def __reduce__(self) -> tuple[type, tuple[dict[str, Array]]]:
        return dict, (dict(self),)


class RowSource(Protocol):
    """Source of the rows of a motion: state variables and recorded columns, with the records of events."""

    @property
    def phase(self) -> Phase:
        """State variables by name; arrays of a store are read when they are indexed."""

    @property
    def columns(self) -> Columns:
        """Columns that are read instead of computed."""

    @property
    def events(self) -> EventRecords:
        """Records of the events."""

    @property
    def summary(self) -> Summary | None:
        """Recorded part of the summary of the motion; None if the summary follows from the rows."""

    @property
    def store(self) -> EnsembleStore | None:
        """Store from which the rows are read."""

    def absent(self, member: int) -> str:
        """Return the reason why a member has no rows; "" if it has rows."""

    def in_memory(self) -> RowSource:
        """Return the source with its arrays in memory."""


class MemoryRows:
    """Rows in memory, integrated, selected or read from a file.

    Parameters
    ----------
    phase : dict
        State variables by name.
    columns : mapping, optional
        Recorded columns by name.
    events : EventRecords, optional
        Records of the events.
    summary : mapping, optional
        Recorded summary.
    """

    store: EnsembleStore | None = None

    def __init__(
        self,
        phase: Phase,
        columns: Columns | None = None,
        events: EventRecords = NO_EVENTS,
        summary: Summary | None = None,
    ) -> None:
        self.phase, self.columns, self.events = read_only(phase), {} if columns is None else columns, events
        self.summary = summary

    def absent(self, _: int) -> str:
        """Return "": all rows are there."""
        return ""

    def in_memory(self) -> MemoryRows:
        """Return the source itself."""
        return self


class ComputedRows:
    """Rows that are computed on first access, such as the rows of an integrator in other variables.

    Parameters
    ----------
    phase : callable
        Returns the state variables by name.
    columns : callable, optional
        Returns the recorded columns by name.
    events : EventRecords, optional
        Records of the events.
    """

    summary: Summary | None = None
    store: EnsembleStore | None = None

    def __init__(
        self, phase: Callable[[], Phase], columns: Callable[[], Columns] = dict, events: EventRecords = NO_EVENTS
    ) -> None:
        self._phase, self._columns, self.events = phase, columns, events

    @cached_property
    def phase(self) -> Phase:
        """State variables by name."""
        return self._phase()

    @property
    def columns(self) -> Columns:
        """Recorded columns by name."""
        return self._columns()

    def absent(self, _: int) -> str:
        """Return "": all rows are there."""
        return ""

    def in_memory(self) -> ComputedRows:
        """Return the source itself."""
        return self

    def __reduce__(self) -> tuple[type, tuple[Phase, Columns, EventRecords]]:
        return MemoryRows, (self.phase, dict(self.columns), self.events)


class StoreRows:
    """Rows of an ensemble in a store, which are read when they are indexed.

    Parameters
    ----------
    store : EnsembleStore
        Store of the ensemble.
    phase : dict
        Arrays of the state variables by name.
    columns : mapping
        Arrays of recorded columns by name.
    events : EventRecords, optional
        Records of the events.
    """

    def __init__(self, store: EnsembleStore, phase: Phase, columns: Columns, events: EventRecords = NO_EVENTS) -> None:
        self.store, self.phase, self.columns, self.events = store, phase, columns, events

    @property
    def summary(self) -> Summary:
        """Summary that `save` wrote; the summary of other stores would require reading all rows."""
        return self.store.summary

    def absent(self, member: int) -> str:
        """Return the reason why a member has no rows yet; "" if it has rows."""
        return "" if self.store.whole[member // self.store.chunk] else "the store does not have this member yet"

    def in_memory(self) -> MemoryRows:
        """Return the source with its arrays in memory."""
        read = {name: functools.partial(np.asarray, values) for name, values in self.columns.items()}
        return MemoryRows(changed(self.phase, np.asarray), LazyColumns(read), self.events)


def selected(
    source: RowSource,
    members: Chosen | slice | None,
    at: NDArray[np.intp] | slice,
    events: EventRecords = NO_EVENTS,
) -> MemoryRows:
    """Return the rows of some members, None for one body, at some times, with the given records of events."""
    rows = functools.partial(rows_of, members=members, at=at)
    columns = {name: functools.partial(_rows_of_column, source.columns, name, rows) for name in source.columns}
    return MemoryRows(changed(source.phase, rows), LazyColumns(columns), events)


def _rows_of_column(columns: Columns, name: str, rows: Callable[[Array], Array]) -> Array:
    return rows(columns[name])


def recorded_columns(source: RowSource) -> LazyColumns:
    """Return the columns of a source that are read: state variables and recorded columns."""
    read: dict[str, Callable[[], Array]] = {}
    for name, values in source.phase.items():
        if name == "orbit" and "quaternion" not in source.phase:
            read["position"] = functools.partial(_components, values, slice(3))
            read["momentum"] = functools.partial(_components, values, slice(3, None))
        else:
            read[name if name in RIGID else f"own_{name}"] = functools.partial(np.asarray, values)
    for name in source.columns:
        read[name] = functools.partial(_column, source.columns, name)
    return LazyColumns(read)


def _column(columns: Columns, name: str) -> Array:
    return np.asarray(columns[name])


def _components(values: Array, places: slice) -> Array:
    return np.array(values)[..., places]
