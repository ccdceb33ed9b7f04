"""The motion of a body or of two bodies: the result of a propagation, and everything that is read from it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.errors import real_numbers
from poinsot.immutable import ReadOnlyDict, cached_property, owned
from poinsot.kinematics.state import AnyState, Phase, State, changed, state_of
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Environment
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.part import jumps_at
from poinsot.printable import described
from poinsot.propagation import motion_report
from poinsot.propagation.column_reader import ColumnReader, MotionRows, body_systems
from poinsot.propagation.dataset import dataset_of_motion, dataset_of_store, with_present_names
from poinsot.propagation.event_record import EventRecord
from poinsot.propagation.quantities_of_motion import QuantitiesOfMotion
from poinsot.propagation.two_body_motion import refuse_one_body
from poinsot.quantities import Array, Times
from poinsot.records.calendar import Calendar
from poinsot.records.members import members_of
from poinsot.storage.run_record import Method, RunRecord
from poinsot.storage.selection import Chosen, Index, checked_index, refuse_other_names, rows_of
from poinsot.systems.system import System

if TYPE_CHECKING:
    import xarray

    from poinsot.storage.ensemble_store import EnsembleStore

Several = slice | Sequence[int] | NDArray[np.int_] | NDArray[np.bool_]
Dense = tuple[Callable[[Array], Phase], float, float]
"""Dense output: a function of times, and the first and the last time at which it is defined."""

EVERY = slice(None)
NOTHING = ReadOnlyDict()
SHARED_PROVENANCE = ("title", "calendar", "reference_frame")
"""Provenance that also describes a part of a motion, or one of two bodies. The scenario describes the whole."""


class Trajectory(QuantitiesOfMotion):
    """Motion at the requested times; every property is an array whose first axis is the axis of the times.

    In an ensemble every array gains the axis of the members first: (members, n, 4) for quaternions. A motion of two
    bodies contains the relative orbit, and `primary` and `secondary` are the motions of the single bodies.

    Attributes
    ----------
    system : System
        System that was integrated.
    initial : State
        Initial state, from which drifts are measured.
    times : array (n,)
        Requested times, in the order of the call.
    run : RunRecord
        Method, order, number of steps, tolerance and versions.
    failures : dict
        Map from the number of a failed member to the reason; its rows are NaN from the time of failure. For a motion of
        one such member, the key is 0.
    provenance : dict
        Entries of a motion made from a scenario: its `title`, the `seed` of its spread, and the text `scenario`.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 2))
    >>> motion = pt.propagate(pt.System(body), start, [0.0, 1.0], dense=True)
    >>> motion(0.5).quaternion.round(4)
    array([0.8776, 0.    , 0.    , 0.4794])
    """

    system: System
    initial: AnyState
    times: Array
    run: RunRecord
    failures: dict[int, str]
    provenance: dict[str, Any]
    _rows: MotionRows
    _dense: Dense | None
    _pair: Trajectory | None
    _seals: ClassVar[bool] = False

    def __init__(
        self,
        system: System,
        initial: AnyState,
        times: Array,
        rows: MotionRows,
        run: RunRecord,
        dense: Dense | None = None,
        failures: Mapping[int, str] | None = None,
        provenance: Mapping[str, Any] = NOTHING,
    ) -> None:
        if failures.__class__ is not dict and not isinstance(failures, Mapping | None):
            raise TypeError(f"failures must be a mapping of members to reasons, got {described(failures)}.")
        times = owned(times)
        vars(self).update(  # in a tenth of the time of assignments
            system=system,
            initial=initial,
            times=times,
            run=run,
            failures=owned(dict(failures)) if failures else NOTHING,
            provenance=owned(dict(provenance)) if provenance else NOTHING,
            _rows=rows,
            _reader=ColumnReader(system, initial, times, rows, run),
            _dense=dense,
            _pair=None,
            _body="",
        )

    def __getstate__(self) -> dict[str, object]:
        """Return the motion without the environment, which follows from its rows."""
        return {name: value for name, value in vars(self).items() if name != "environment"}

    # ------------------------------------------------------------------ rows

    @property
    def phase(self) -> Phase:
        """State variables by name, as integrated.

        The names are `quaternion`, and `angular_momentum_body` or `conjugate_momenta`.
        """
        return self._rows.phase

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Boolean array, True at the times that the motion reached; shape (n,), for an ensemble (members, n)."""
        first = np.asarray(next(iter(self.phase.values())))
        return np.asarray(np.isfinite(first[..., 0]))

    @property
    def events(self) -> tuple[EventRecord, ...]:
        """Records of the events, in the order of `propagate(..., events=[...])`.

        For a motion in a file or a store, the records are read on access; for a member, only its chunk is read. An
        event from a file provides its `kind`, its `repr` and whether it is `terminal`, but not its formula.
        """
        return self._rows.events.records

    @property
    def store(self) -> EnsembleStore | None:
        """Store of an ensemble, from which arrays are read on access; None for a motion in memory."""
        return self._rows.store

    @property
    def observables(self) -> Mapping[str, Observable]:
        """Observables whose readings are variables of the motion, by name: `propagate(..., observables=[...])`."""
        return self._rows.observables

    def with_observables(self, observables: Mapping[str, Observable], readings: Mapping[str, Array]) -> Trajectory:
        """Return the motion together with readings of observables, by name, at its times."""
        rows = self._rows.with_observables(observables, readings)
        about = self.run, self._dense, self.failures, self.provenance
        return Trajectory(self.system, self.initial, self.times, rows, *about)

    @cached_property
    def environment(self) -> Environment:
        """Environment at the times; `motion.environment.position(orbit)` returns three arrays (n,), space axes.

        Positions on integrated orbits are results of the run; positions on other orbits follow from formulas.
        """
        return self._reader.environment()

    # ------------------------------------------------------------------ two bodies

    @property
    def of_bodies(self) -> dict[str, Trajectory]:
        """Motions of the single bodies by name: {"": motion} for one body, else `primary` and `secondary`."""
        names = self.system.of_bodies
        return {"": self} if len(names) == 1 else {name: self._of_body(name) for name in names}

    @property
    def primary(self) -> Trajectory:
        """Rotation of the primary of two bodies, as the motion of one body."""
        return self._of_body("primary")

    @property
    def secondary(self) -> Trajectory:
        """Rotation of the secondary of two bodies, as the motion of one body."""
        return self._of_body("secondary")

    def _of_body(self, body: str) -> Trajectory:
        refuse_one_body(self.system, body)
        dense = None
        if self._dense is not None:
            dense = partial(_interpolated, self, body), *self._dense[1:]
        system, initial = body_systems(self.system)[body], self.initial.of_bodies[body]
        run = dataclasses.replace(self.run, method=Method.ONE_OF_TWO)
        rows = MotionRows(partial(_phase_of, self._reader, body))
        motion = Trajectory(system, initial, self.times, rows, run, dense, self.failures, self._shared_provenance)
        motion._pair, motion._body = self, body
        return motion

    # ------------------------------------------------------------------ times and members

    @property
    def has_dense_output(self) -> bool:
        """True if the motion has dense output and can be called at any time."""
        return self._dense is not None

    def __call__(self, time: Times) -> State:
        """Return the state at a time, or a batch of states at an array of times, from the dense output."""
        if self._dense is None:
            raise ValueError(
                "a trajectory must have dense output to be called, got none. Propagate one motion with dense=True."
            )
        interpolant, first, last = self._dense
        time = time if self.system.calendar is None else self.system.calendar.time(time)
        t = real_numbers("time", time, self.system.units["time"])
        if t.size and (t.min() < first or t.max() > last):
            outside = t.min() if t.min() < first else t.max()
            raise ValueError(f"time must lie within [{first:.15g}, {last:.15g}], got {outside:.15g}.")
        phase = changed(interpolant(t.ravel()), lambda x: x.reshape(*t.shape, x.shape[-1]))
        return state_of(phase, t, jumps_at(self.system.dynamics.jumping, t))  # type: ignore[return-value]

    def __len__(self) -> int:
        """Return the length of the first axis of its arrays: members of an ensemble, times of one body."""
        return len(next(iter(self.phase.values())))

    @property
    def is_ensemble(self) -> bool:
        """True if the first axis of arrays is the axis of members."""
        return next(iter(self.phase.values())).ndim == 3

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: Index) -> Any:
        """Return members of an ensemble, or times of one body, chosen by an index of the first axis."""
        return self._isel(member=index) if self.is_ensemble else self._isel(time=index)

    @checked
    def member(self, member: int) -> Trajectory:
        """Return the motion of one member of an ensemble, with its own system, initial state and events.

        The result is a motion of one body, equal to the rows of the ensemble bit for bit. Times that the member did not
        reach are omitted, and `failures[0]` contains the reason. `run` describes the run of the ensemble.
        """
        return self.isel(member=member)

    @overload
    def isel(self, *, time: int, member: Index = ...) -> State: ...

    @overload
    def isel(self, *, time: Several = ..., member: Index = ...) -> Trajectory: ...

    def isel(self, *, time: Index = EVERY, member: Index = EVERY) -> Trajectory | State:
        """Return the motion at some of its times, or of some of its members, selected by index.

        Parameters
        ----------
        time : int, slice, array of int or of bool, optional
            Index of one time, which returns the `State` at this time, or of several times in the order of the motion.
            The result keeps the initial state, run, events and dense output of the whole motion.
        member : int, slice, array of int or of bool, optional
            Index of one member, which returns a motion of one body as `member` does, or of several members, which are
            renumbered.

        Raises
        ------
        IndexError, TypeError, ValueError
            If an index is out of range or invalid, or if the order of the times would change.
        """
        return self._isel(time, member)

    def _isel(self, time: Index = EVERY, member: Index = EVERY) -> Trajectory | State:
        at, members = checked_index("time", time, self.times.size), self._members(member)
        if isinstance(at, int):
            phase = changed(self.phase, lambda x: rows_of(x, members, at))
            t = np.full(next(iter(phase.values())).shape[:-1], self.times[at])
            return state_of(phase, t, jumps_at(self.system.dynamics.jumping, t, EVERY if members is None else members))  # type: ignore[return-value]
        if np.any(np.diff(at) <= 0):
            raise ValueError("time must have the order of the times of the motion, got places in another order.")
        return self._selected(members, at)

    def _members(self, index: Index) -> Chosen | None:
        """Return the chosen members; None for one body."""
        if self.is_ensemble:
            return checked_index("member", index, len(self))
        if not (isinstance(index, slice) and index == EVERY):
            raise ValueError("motion must be an ensemble to have members, but it is of one body.")
        return None

    def _selected(self, members: Chosen | None, at: NDArray[np.intp]) -> Trajectory:
        """Return the motion of some members, None for one body, at some times."""
        if self._pair is not None:
            return self._pair._selected(members, at)._of_body(self._body)
        if isinstance(members, int):
            first = rows_of(next(iter(self.phase.values())), members, at)
            at = at[np.isfinite(first[:, 0])]
        system, initial, events = self.system, self.initial, self._rows.events
        if members is not None:
            system, initial = members_of(system, members), members_of(initial, members)
            events = events.of_members(members, system)
        chosen = range(1) if members is None else np.atleast_1d(members).tolist()
        failures = {new: why for new, old in enumerate(chosen) if (why := self._why_ended(old))}
        rows, provenance = self._rows.isel(members, at, events), self._shared_provenance
        return Trajectory(system, initial, self.times[at], rows, self.run, self._dense, failures, provenance)

    def _why_ended(self, member: int) -> str | None:
        """Return the reason why a member has no motion to the end; None if it has one."""
        return self._rows.absent(member) or self.failures.get(member)

    # ------------------------------------------------------------------ summary and dataset

    @property
    def summary(self) -> dict[str, str | float]:
        """Record of the method and of the drift of the invariants.

        For a motion in a store it contains the method only: the drift would require reading the whole store.
        """
        return self._summary_with(self._reader.read)

    def _summary_with(self, read: Callable[[Collection[str]], Mapping[str, Array]]) -> dict[str, str | float]:
        """Return the summary, with a function that returns columns by name."""
        return motion_report.summary(self._reader, self.run, read, lambda: self.environment)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        ends = () if self._dense is None else self._dense[1:]
        return motion_report.lines(self._reader, self.summary, ends, len(self.failures))

    @override
    def _repr_html_(self) -> str:
        members = motion_report.shown_members(self._reader)
        shown = self._selected(np.array(members), np.arange(self.times.size)) if members else self
        return super()._repr_html_() + motion_report.sketches(shown._reader, members)

    @property
    def dataset(self) -> xarray.Dataset:
        """Motion as an xarray Dataset with units, frames and provenance; for a store, its variables."""
        if self.store is not None:
            stored = with_present_names(self.store.dataset())
            return dataset_of_store(stored, self.variables(()), self.variable_names, self.summary)
        data = self.variables(self.variable_names)
        known = self._summary_with(lambda names: {name: data[name].values for name in names})
        return data.assign_attrs({key: value for key, value in known.items() if key != "wall_time"})

    def variables(self, names: Collection[str]) -> xarray.Dataset:
        """Return some variables of the dataset, with the initial state and the body.

        Parameters
        ----------
        names : list of str
            Some of `variable_names`.
        """
        refuse_other_names("names", names, self._reader.table)
        known = self.run, self.failures, self.provenance, self.calendar, self.reference_frame
        return dataset_of_motion(self._reader, names, *known)

    @property
    def _shared_provenance(self) -> dict[str, Any]:
        return {key: self.provenance[key] for key in SHARED_PROVENANCE if key in self.provenance}

    @property
    def calendar(self) -> Calendar | None:
        """Calendar of the times, from the orbits, the scenario or the file of the motion."""
        calendar = self.system.calendar or self.provenance.get("calendar")
        return calendar if isinstance(calendar, Calendar) else None

    @property
    def reference_frame(self) -> str:
        """Name of the space axes, from the orbits or from the file of the motion."""
        named = (orbit.reference_frame for orbit in self.system.orbits)
        own = next((frame for frame in named if frame != SPACE_AXES_UNNAMED), None)
        return str(own or self.provenance.get("reference_frame", SPACE_AXES_UNNAMED))


def _phase_of(reader: ColumnReader, body: str) -> Phase:
    return reader.state.of_bodies[body].phase


def _interpolated(motion: Trajectory, body: str, times: Array) -> Phase:
    return motion(times).of_bodies[body].phase


# ---------------------------------------------------------------------- bodies of motions as arguments


def is_of_two_bodies(motion: Trajectory) -> bool:
    """Return True if a motion contains two bodies."""
    return len(motion.system.of_bodies) > 1


def _of_two_bodies(name: str, motion: Trajectory) -> Trajectory:
    if not is_of_two_bodies(motion):
        raise TypeError(f"{name} must be the motion of two bodies, got the motion of one body.")
    return motion


OfTwoBodies = Annotated[Trajectory, _of_two_bodies]
"""Annotation of a motion of two bodies."""


def of_one_body(motion: Trajectory, body: str | None) -> Trajectory:
    """Return the motion of one body, for a motion of two the body with the given name."""
    known = motion.of_bodies
    if body is None and len(known) == 1:
        return motion
    if body not in known:
        rule = "must be primary or secondary" if len(known) > 1 else "must not be there for a motion of one body"
        raise ValueError(f"body {rule}, got {body or 'none'}.")
    return known[body]
