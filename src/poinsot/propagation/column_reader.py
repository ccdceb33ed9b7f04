"""Rows of a motion, and columns that are read or computed from them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from poinsot.immutable import cached_property, read_only
from poinsot.integration import equations
from poinsot.integration.formulations import formulation_of
from poinsot.integration.problem import Problem
from poinsot.integration.state_vector import StateVector
from poinsot.kinematics.state import RIGID, AnyState, Phase, changed, state_of
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Dated, Environment, within
from poinsot.mechanics.observable import Observable
from poinsot.propagation.columns import ORBIT_VARIABLES, Column, ColumnBlock, ColumnTable, columns_of_observables
from poinsot.propagation.event_record import NO_EVENTS, EventRecords
from poinsot.propagation.recorded import RecordedEvent, RecordedSystem
from poinsot.quantities import Array
from poinsot.records.members import members_of
from poinsot.storage.run_record import RunRecord
from poinsot.storage.selection import Chosen, rows_of
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.integrals import Integral
from poinsot.systems.pair_dynamics import PairDynamics
from poinsot.systems.system import System

if TYPE_CHECKING:
    from poinsot.storage.ensemble_store import EnsembleStore

__all__ = ["NO_COLUMNS", "ColumnReader", "LazyColumns", "MotionRows", "body_systems"]

EVERY = slice(None)
NO_COLUMNS: Mapping[str, Array] = read_only({})
NO_OBSERVABLES: Mapping[str, Observable] = read_only({})

ROWS_PER_BLOCK = 16_384
"""Rows whose columns are computed together, so that intermediate results stay in the cache."""


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


class MotionRows:
    """Rows of a motion in memory or in a store, with the records of its events.

    Parameters
    ----------
    phase : mapping or callable
        State variables by name, or a function that returns them on first access. Arrays of a store are read when they
        are indexed.
    columns : mapping or callable, optional
        Recorded columns by name, or a function that returns them: columns that are read instead of computed.
    events : EventRecords, optional
        Records of the events.
    summary : mapping, optional
        Recorded part of the summary of the motion. Default: the summary follows from the rows.
    store : EnsembleStore, optional
        Store from which the rows are read.
    observables : mapping
        Observables whose readings are recorded columns, by name.
    """

    def __init__(
        self,
        phase: Phase | Callable[[], Phase],
        columns: Columns | Callable[[], Columns] = NO_COLUMNS,
        events: EventRecords = NO_EVENTS,
        summary: Summary | None = None,
        store: EnsembleStore | None = None,
        observables: Mapping[str, Observable] = NO_OBSERVABLES,
    ) -> None:
        self._phase, self._columns = phase, columns
        self.events, self.summary, self.store = events, summary, store
        self.observables = read_only(dict(observables)) if observables else NO_OBSERVABLES

    @cached_property
    def phase(self) -> Phase:
        """State variables by name."""
        return self._phase() if callable(self._phase) else self._phase

    @property
    def columns(self) -> Columns:
        """Recorded columns by name."""
        return self._columns() if callable(self._columns) else self._columns

    @property
    def recorded(self) -> LazyColumns:
        """All columns that are read: state variables and recorded columns."""
        read: dict[str, Callable[[], Array]] = {}
        for name, values in self.phase.items():
            if name == "orbit" and "quaternion" not in self.phase:
                read["position"] = partial(_components, values, slice(3))
                read["momentum"] = partial(_components, values, slice(3, None))
            else:
                read[name if name in RIGID else f"own_{name}"] = partial(np.asarray, values)
        columns = self.columns
        for name in columns:
            read[name] = partial(_column, columns, name)
        return LazyColumns(read)

    def absent(self, member: int) -> str:
        """Return the reason why a member has no rows yet; "" if it has rows."""
        there = self.store is None or self.store.whole[member // self.store.chunk]
        return "" if there else "the store does not have this member yet"

    def in_memory(self) -> MotionRows:
        """Return the rows with their arrays in memory."""
        if self.store is None:
            return self
        read = {name: partial(np.asarray, values) for name, values in self.columns.items()}
        rows = changed(self.phase, np.asarray)
        return MotionRows(rows, LazyColumns(read), self.events, observables=self.observables)

    def isel(
        self, members: Chosen | slice | None, at: NDArray[np.intp] | slice, events: EventRecords = NO_EVENTS
    ) -> MotionRows:
        """Return the rows of some members, None for one body, at some times, with the given records of events."""
        rows, columns = partial(rows_of, members=members, at=at), self.columns
        read = {name: partial(_rows_of_column, columns, name, rows) for name in columns}
        observables = self.observables
        if members is not None and observables:
            observables = {name: members_of(each, members) for name, each in observables.items()}
        return MotionRows(changed(self.phase, rows), LazyColumns(read), events, observables=observables)

    def with_observables(self, observables: Mapping[str, Observable], readings: Columns) -> MotionRows:
        """Return the rows together with readings of observables, by name."""
        columns = {**self.columns, **readings}
        return MotionRows(self.phase, columns, self.events, self.summary, self.store, observables)

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        own = self.phase, dict(self.columns), self.events, self.summary, self.store, dict(self.observables)
        return MotionRows, own


def _column(columns: Columns, name: str) -> Array:
    return np.asarray(columns[name])


def _rows_of_column(columns: Columns, name: str, rows: Callable[[Array], Array]) -> Array:
    return rows(columns[name])


def _components(values: Array, places: slice) -> Array:
    return np.array(values)[..., places]


class ColumnReader:
    """Reader of the columns of a motion: recorded columns are read from the source, others follow from the states.

    Parameters
    ----------
    system : System
        System of the motion.
    initial : State
        Initial state, from which drifts are measured.
    times : array (n,)
        Times of the rows.
    rows : MotionRows
        Rows of the motion.
    run : RunRecord
        Run of the motion, whose formulation defines the variables of integrated orbits.
    """

    def __init__(self, system: System, initial: AnyState, times: Array, rows: MotionRows, run: RunRecord) -> None:
        self.system, self.initial, self.times, self.rows, self.run = system, initial, times, rows, run
        self._columns: ColumnTable | None = None

    def __getstate__(self) -> dict[str, object]:
        """Return the reader without values that follow from the rows."""
        return {name: value for name, value in vars(self).items() if name not in ("_variables", "_of_bodies", "table")}

    @property
    def is_ensemble(self) -> bool:
        """True if the first axis of the rows is the axis of members."""
        return next(iter(self.rows.phase.values())).ndim == 3

    @property
    def state(self) -> AnyState:
        """States in all rows."""
        return state_of(changed(self.rows.phase, np.asarray), self.times)

    @property
    def columns(self) -> ColumnTable:
        """Columns of the system of the motion."""
        self._columns = self._columns or ColumnTable(self.system)
        return self._columns

    @cached_property
    def table(self) -> dict[str, Column]:
        """Columns of the motion by name."""
        recorded, readings = self._recorded, self.rows.observables
        of_system = self.columns.of_motion(recorded)
        return {**of_system, **columns_of_observables(readings)} if readings else of_system

    def environment(self, rows: MotionRows | None = None, times: Array | None = None) -> Environment:
        """Return the environment at the times, or at the times of some rows."""
        t, columns = self.times if times is None else times, (self.rows if rows is None else rows).columns
        if ORBIT_VARIABLES not in columns or isinstance(self.system, RecordedSystem):
            return Environment(t)
        problem, variables = self._variables
        return variables.environment(problem, t, np.asarray(columns[ORBIT_VARIABLES]))

    @cached_property
    def _variables(self) -> tuple[Problem, StateVector]:
        """Integrated variables, which give the variables of orbits their meaning."""
        watched = [event for event in self.rows.events.watched if not isinstance(event, RecordedEvent)]
        problem, formulation = Problem(self.system, watched), formulation_of(self.run.formulation)
        return problem, equations.state_vector(problem, self.initial, formulation, self.run.precision)

    @cached_property
    def _of_bodies(self) -> Mapping[str, ColumnTable]:
        return {name: ColumnTable(system) for name, system in body_systems(self.system).items()}

    @property
    def _recorded(self) -> LazyColumns:
        return self.rows.recorded

    def block(self, environment: Callable[[], Environment]) -> ColumnBlock:
        """Return all rows, with the function that returns their environment."""
        return self._block(self.state, environment, self.rows.columns)

    def _block(self, state: AnyState, environment: Callable[[], Environment], recorded: Columns) -> ColumnBlock:
        return ColumnBlock(self.columns, state, environment, recorded, lambda: self._of_bodies)

    def read(self, names: Collection[str]) -> dict[str, Array]:
        """Return columns by name: recorded columns as they are, others computed in blocks of times."""
        recorded = self._recorded
        found = {name: np.asarray(recorded[name]) for name in names if name in recorded}
        if not (left := {*names} - found.keys()):
            return found
        columns = self.table
        drifts = {name: each for name in columns if name in left and (each := columns[name].drift_of) is not None}
        wanted = left - drifts.keys() | {f"integral_{each.name}" for each in drifts.values()}
        wanted |= {"kinetic_energy", "potential_energy"} if drifts else set()
        along, sizes = (EVERY,) if self.is_ensemble else (), np.zeros(())
        for at, block in self._blocks():
            sizes = np.fmax(sizes, _sizes(block)) if drifts else sizes
            for name in (name for name in columns if name in wanted):
                values = block[name]
                if name not in found:
                    shape = [*values.shape]
                    shape[len(along)] = self.times.size
                    found[name] = np.empty(shape, values.dtype)
                found[name][*along, at] = values
        for name, each in drifts.items():
            found[name] = _drift(each, self.initial, found[f"integral_{each.name}"], sizes)
        return {name: found[name] for name in names}

    def of_integrals(self, prefix: str) -> dict[str, Array]:
        """Return the values ("integral_") or drifts ("drift_") of the integrals, by the name of the integral."""
        names = [name for name in self.table if name.startswith(prefix)]
        return {name.removeprefix(prefix): values for name, values in self.read(names).items()}

    def _blocks(self) -> Iterator[tuple[slice, ColumnBlock]]:
        """Yield the rows in blocks of times; one block if formulas round by all the times together, as orbits do."""
        dated = any(isinstance(each, Dated) for record in self.system.dynamics.records for each in within(record))
        rows, members = self.rows.in_memory(), EVERY if self.is_ensemble else None
        count = max(self.times.size, 1)
        step = count if dated else ROWS_PER_BLOCK // max(self.members, 1) or count
        for first in range(0, count, step):
            at = slice(first, first + step)
            some, times = rows.isel(members, at), self.times[at]
            state = state_of(some.phase, times)
            yield at, self._block(state, partial(self.environment, some, times), some.columns)

    @property
    def members(self) -> int:
        """Number of members, 1 for one body."""
        return len(next(iter(self.rows.phase.values()))) if self.is_ensemble else 1


def _sizes(block: ColumnBlock) -> Array:
    """Return the largest energies and momenta, by which drifts are divided; shape (2, ...)."""
    T_and_U = np.abs(block["kinetic_energy"]) + np.abs(block["potential_energy"])
    return np.stack([np.fmax.reduce(each, axis=-1, initial=0.0) for each in (T_and_U, _momentum_size(block))])


def _momentum_size(block: ColumnBlock) -> Array:
    """Return the sum of the magnitudes of all angular momenta; shape (n,)."""
    with np.errstate(over="ignore"):
        each = [np.linalg.norm(body["angular_momentum_body"], axis=-1) for body in block.bodies.values()]
        if len(each) > 1:
            each.append(np.linalg.norm(np.cross(block["position"], block["momentum"]), axis=-1))
        return np.asarray(sum(each))


def _drift(integral: Integral, initial: AnyState, values: Array, sizes: Array) -> Array:
    size = sizes[0 if integral.is_energy else 1]
    with np.errstate(invalid="ignore"):
        change: Array = values - np.asarray(integral.value(initial))[..., None]
    change /= np.where(size > 0, size, 1.0)[..., None]
    return change


class OneOfTwo(BodyDynamics):
    """One of two bodies, whose rotation is read from a motion of both. The forces belong to the system of both."""

    measures: ClassVar[tuple[str, ...]] = PairDynamics.measures
    moves_alone: ClassVar[bool] = False


def body_systems(system: System) -> Mapping[str, System]:
    """Return the system of each rigid body by name: the system itself if it has one body."""
    if len(system.of_bodies) == 1:
        return {"": system}
    return {name: _system_of(body, system.units) for name, body in system.of_bodies.items()}


def _system_of(body: Body, units: Mapping[str, str]) -> System[Body]:
    return System._of(OneOfTwo(body, ()), units)
