"""The motion of a body: what a propagation returns, and everything that is read from it."""

from __future__ import annotations

import functools
import json
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, curves, rounded, told, told_times
from poinsot.errors import level_of_user, real_numbers
from poinsot.immutable import ReadOnlyDict, owned
from poinsot.integration import equations
from poinsot.integration.formulations import formulation_of
from poinsot.integration.problem import Problem
from poinsot.lazy import cached_property
from poinsot.mechanics import euler
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Environment
from poinsot.mechanics.event import Event
from poinsot.mechanics.frame import Frame, checked_frame
from poinsot.mechanics.part import jumps_at
from poinsot.mechanics.state import RIGID, AnyState, Phase, State, changed, named
from poinsot.mechanics.system import System
from poinsot.printable import described
from poinsot.propagation.columns import along_times
from poinsot.propagation.dataset import COLUMNS, OF_BODY, Motion, dataset_of
from poinsot.propagation.event_record import EventRecord, EventsOfMembers, EventSource, KnownEvents, StoredEvent
from poinsot.propagation.relative_motion import RelativeMotion
from poinsot.propagation.run_record import Run, told_kernel
from poinsot.propagation.selection import (
    Chosen,
    Index,
    checked_index,
    refuse_other_names,
    rows_of,
    state_of_members,
    system_of_members,
)
from poinsot.quantities import Times

if TYPE_CHECKING:
    import xarray
    from scipy.spatial.transform import Rotation

    from poinsot.propagation.ensemble_store import EnsembleStore


Array = NDArray[np.float64]
Rows = Callable[[Array], Array]
Several = slice | Sequence[int] | NDArray[Any]
EVERY = slice(None)
NOTHING = ReadOnlyDict()
SUMMARY = {"method", "formulation", "precision", "tolerance", "order", "steps", "wall_time", "kernel", "lanes"}
SUMMARY |= {"norm_error", "tangency_error", "integrals"}
"""The entries of every summary; the others are drifts, formulas outside their validity, and quantities at limits."""
ORBIT = ("position", "momentum")
"""What a dataset has for the orbit of two bodies."""
OF_PARTS = ("title", "calendar", "reference_frame")
"""What a part of a motion, or one of two bodies, has of the provenance of the whole: the scenario is not its own."""

Interpolant = Callable[[Array], Phase]


class Trajectory(Summarized):
    """Motion at the requested times; every property is an array whose first axis is the axis of the times.

    In an ensemble every array gains the axis of the members first: (members, n, 4) for quaternions.

    Attributes
    ----------
    system : System
        System that was integrated.
    initial : State
        Initial state, from which drifts are measured.
    times : array (n,)
        Requested times, in the order of the call.
    run : Run
        Method, order, number of steps, tolerance and versions.
    failures : dict
        Map from the number of a failed member to the reason; its rows are NaN from the time of failure. For a motion of
        one such member, the key is 0.
    store : EnsembleStore or None
        Store of an ensemble, from which arrays are read on access.
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
    run: Run
    failures: dict[int, str]
    store: EnsembleStore | None
    event_source: EventSource
    provenance: dict[str, Any]
    _computed: Callable[[], Phase]
    _interpolant: tuple[Interpolant, float, float] | None
    _environment: Callable[[], Environment] | None
    _seals: ClassVar[bool] = False
    _of_whole: ClassVar[tuple[str, ...]] = COLUMNS
    """What a dataset has of it beside the rotation of each body."""

    _kept_state: AnyState | None = None
    """The states, with what they have computed: of a part of a motion that is soon forgotten."""

    def __init__(
        self,
        system: System,
        initial: AnyState,
        times: Array,
        phase: Callable[[], Phase],
        run: Run,
        interpolant: tuple[Interpolant, float, float] | None = None,
        failures: Mapping[int, str] | None = None,
        environment: Callable[[], Environment] | None = None,
    ) -> None:
        if failures.__class__ is not dict and not isinstance(failures, Mapping | None):
            raise TypeError(f"failures must be a mapping of members to reasons, got {described(failures)}.")
        vars(self).update(  # in a tenth of the time of assignments
            system=system,
            initial=initial,
            times=owned(times),
            _computed=phase,
            run=run,
            failures=owned(dict(failures)) if failures else NOTHING,
            _interpolant=interpolant,
            _environment=environment,
            store=None,
            event_source=KnownEvents(),
            provenance=NOTHING,
        )

    def __getstate__(self) -> dict[str, Any]:
        """Return the motion as numbers: what computes them on demand has computed them."""
        computed = {"phase": self.phase, "environment": self.environment, "event_source": KnownEvents(self.events)}
        return {**vars(self), **computed, "_computed": None, "_environment": None}

    # ------------------------------------------------------------------ reading

    @cached_property
    def phase(self) -> Phase:
        """State variables by name, as integrated.

        The names are `quaternion`, and `angular_momentum_body` or `conjugate_momenta`.
        """
        return self._computed()

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Boolean array, True at the times that the motion reached; shape (n,), for an ensemble (members, n)."""
        first = np.asarray(next(iter(self.phase.values())))
        return np.asarray(np.isfinite(first[..., 0]))

    @cached_property
    def events(self) -> tuple[EventRecord, ...]:
        """Records of the events, in the order of `propagate(..., events=[...])`.

        For a motion in a file or a store, the records are read on access; for a member, only its chunk is read. An
        event from a file provides its `kind`, its `repr` and whether it is `terminal`, but not its formula.
        """
        return self.event_source.of_members(None)

    @property
    def of_bodies(self) -> dict[str, Trajectory]:
        """The rotations of the bodies, by what their names in a phase begin with."""
        return {"": self}

    @property
    def _state(self) -> AnyState:
        return self._kept_state or type(self.initial).computed(changed(self.phase, np.asarray), self.times)

    @cached_property
    def environment(self) -> Environment:
        """Environment at the times; `motion.environment.position(orbit)` returns three arrays (n,), space axes.

        Positions on integrated orbits are results of the run; positions on other orbits follow from formulas.
        """
        return Environment(self.times) if self._environment is None else self._environment()

    @property
    def quaternion(self) -> Array:
        """Unit quaternions body -> space, scalar first; shape (n, 4).

        poinsot never normalises them, so that their norm error is a measure of accuracy.
        """
        return np.asarray(self.phase["quaternion"])

    @property
    def conjugate_momenta(self) -> Array:
        """Conjugate momenta Q = 2 q (0, g); shape (n, 4)."""
        return self._state.of_bodies[""].conjugate_momenta

    @property
    def attitude(self) -> Rotation:
        """Attitudes body -> space as a scipy rotation."""
        return rotation(self.quaternion)

    @property
    def angular_momentum_body(self) -> Array:
        """Angular momentum g = Im(q~ Q)/2 along the body axes; shape (n, 3)."""
        return self._state.of_bodies[""].angular_momentum_body

    @property
    def own(self) -> Phase:
        """Variables of the system's parts: name of the part -> array (n, k)."""
        return self._state.own

    @property
    def angular_momentum_space(self) -> Array:
        """Angular momentum G = Im(Q q~)/2 along the space axes; shape (n, 3)."""
        return self._state.angular_momentum_space

    @property
    def omega_body(self) -> Array:
        """Inertial angular velocity along the body axes; shape (n, 3)."""
        return np.asarray(self.system.omega_body(self._state))

    @property
    def omega_space(self) -> Array:
        """Inertial angular velocity along the space axes; shape (n, 3)."""
        return quat.rotate(self.quaternion, self.omega_body)

    @property
    def kinetic_energy(self) -> Array:
        """Kinetic energy T, eq. (9); shape (n,)."""
        return np.asarray(self.system.kinetic_energy(self._state))

    @property
    def potential_energy(self) -> Array:
        """Potential energy U, the sum of all potentials; shape (n,)."""
        return np.asarray(self.system.potential_energy(self._state, self.environment))

    @property
    def torques_body(self) -> dict[str, Array]:
        """Torque of each force along the body axes: name of the class -> array (n, 3).

        Torques between the body and its parts are not included. The mapping is empty for a loaded motion whose forces
        are unknown.
        """
        return self.system.torques_body(self._state, self.environment)

    @property
    def energy(self) -> Array:
        """Total energy T + U; shape (n,)."""
        return self.kinetic_energy + self.potential_energy

    @property
    def has_dense_output(self) -> bool:
        """True if the motion has dense output and can be called at any time."""
        return self._interpolant is not None

    @checked
    def euler(self, sequence: str = "313") -> tuple[Array, Array]:
        """Return Euler angles (radians) and their canonical momenta, each (n, 3), as `State.euler` does.

        Rows are NaN at singular attitudes, where `State.euler` raises an error. One warning names a regular sequence.
        """
        q = self.quaternion
        sine = euler.sine_of_attitudes(q, sequence)
        if sentence := euler.singularity(sine, sequence, q):
            warnings.warn(sentence, stacklevel=level_of_user())
        regular = sine >= euler.SINGULAR_SINE
        if np.all(regular):
            return self._state.of_bodies[""].euler(sequence)
        angles, momenta = np.full((2, *q.shape[:-1], 3), np.nan)
        angles[regular] = euler.angles_from_quaternion(q[regular], sequence)
        momenta[regular] = euler.momenta_from_angular_momentum(
            angles[regular], self.angular_momentum_body[regular], sequence
        )
        return angles, momenta

    @checked
    def relative_to(self, frame: Frame) -> RelativeMotion:
        """Return attitude and angular velocity relative to a moving frame, such as `orbit.frame`."""
        frame = checked_frame(frame)
        frame_omega = quat.rotate(quat.conjugate(self.quaternion), frame.omega_space(self.times))
        return RelativeMotion(
            self.times,
            quat.product(quat.conjugate(frame.quaternion(self.times)), self.quaternion),
            self.omega_body - frame_omega,
        )

    def __call__(self, time: Times) -> State:
        """Return the state at a time, or a batch of states at an array of times, from the dense output."""
        if self._interpolant is None:
            raise ValueError(
                "a trajectory must have dense output to be called, got none. Propagate one motion with dense=True."
            )
        interpolant, first, last = self._interpolant
        calendar = self.system.calendar
        time = time if calendar is None else calendar.time(time)
        t = real_numbers("time", time, self.system.units["time"])
        if t.size and (t.min() < first or t.max() > last):
            outside = t.min() if t.min() < first else t.max()
            raise ValueError(f"time must lie within [{first:.15g}, {last:.15g}], got {outside:.15g}.")
        phase = changed(interpolant(t.ravel()), lambda x: x.reshape(*t.shape, x.shape[-1]))
        return type(self.initial).computed(phase, t, jumps_at(self.system.dynamics.jumping, t))  # type: ignore[return-value]

    # ------------------------------------------------------------------ members and times

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
        """Return what an index of the first axis chooses: members of an ensemble, times of one body."""
        chosen: Any = index
        return self.isel(member=chosen) if self.is_ensemble else self.isel(time=chosen)

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
        at = checked_index("time", time, self.times.size)
        members = self._members(member)
        if isinstance(at, int):
            phase = changed(self.phase, lambda x: rows_of(x, members, at))
            time = np.full(next(iter(phase.values())).shape[:-1], self.times[at])
            jumped = jumps_at(self.system.dynamics.jumping, time, EVERY if members is None else members)
            return type(self.initial).computed(phase, time, jumped)  # type: ignore[return-value]
        if np.any(np.diff(at) <= 0):
            raise ValueError("time must have the order of the times of the motion, got places in another order.")
        return self._selected(members, at)

    def _members(self, index: Index) -> Chosen | None:
        """Return which members are chosen; None of one body."""
        if self.is_ensemble:
            return checked_index("member", index, len(self))
        if not (isinstance(index, slice) and index == EVERY):
            raise ValueError("motion must be an ensemble to have members, but it is of one body.")
        return None

    def _selected(self, members: Chosen | None, at: NDArray[np.intp]) -> Trajectory:
        """Return the motion of some members, None: of the one body, at some times."""
        if isinstance(members, int):
            first = rows_of(next(iter(self.phase.values())), members, at)
            at = at[np.isfinite(first[:, 0])]
        rows = functools.partial(rows_of, members=members, at=at)
        motion = self._made_of(members, rows, self.times[at], changed(self.phase, rows))
        of_whom = range(1) if members is None else np.atleast_1d(members).tolist()
        motion._complete(
            failures={new: why for new, old in enumerate(of_whom) if (why := self._why_ended(old))},
            provenance={key: self.provenance[key] for key in OF_PARTS if key in self.provenance},
        )
        return motion

    def _why_ended(self, member: int) -> str | None:
        """Return why a member has no motion to the end; None if it has one."""
        absent = self.store is not None and not self.store.whole[member // self.store.chunk]
        return "the store does not have this member yet" if absent else self.failures.get(member)

    def _made_of(self, members: Chosen | None, rows: Rows, times: Array, phase: Phase) -> Trajectory:
        """Return the motion that consists of some rows of the arrays of this one."""
        system, initial, source = self.system, self.initial, self.event_source
        if members is not None:
            system, initial = system_of_members(system, members), state_of_members(initial, members)
            source = EventsOfMembers(source, members, system)

        def environment() -> Environment:
            values = self._orbits
            if values is None:
                return Environment(times)
            watched = [event for event in source.watched if not isinstance(event, StoredEvent)]
            problem = Problem(system, watched)
            variables = equations.state_vector(
                problem, initial, formulation_of(self.run.formulation), self.run.precision
            )
            return variables.environment(problem, times, rows(values))

        own = type(self)
        motion = own(system, initial, times, lambda: phase, self.run, self._interpolant, environment=environment)
        motion._complete(event_source=source)
        return motion

    @property
    def _orbits(self) -> Any:
        """The variables of orbits integrated along, in a store or not; None without any."""
        return self.environment.orbit_values if self.store is None else self.store.arrays.get("carried")

    # ------------------------------------------------------------------ proof

    @property
    def norm_error(self) -> Array:
        """Norm error |q| - 1; shape (n,)."""
        return np.asarray(quat.norm(self.quaternion)) - 1

    @property
    def tangency_error(self) -> Array:
        """Ratio q . Q / |Q|, which is zero for a momentum that is tangent to the unit sphere or zero; shape (n,)."""
        q, momenta = self.quaternion, self.conjugate_momenta
        size = np.hypot.reduce(momenta, axis=-1)  # squares may overflow
        return np.asarray(quat.dot(q, momenta / np.where(size == 0, 1.0, size)[..., None]))

    @property
    def integrals(self) -> dict[str, Array]:
        """Conserved quantities of the system along the motion, by name; empty if there are none."""
        return self._proof("integral")

    @property
    def drift(self) -> dict[str, Array]:
        """Relative change of each conserved quantity since the initial state, each of shape (n,) or (members, n).

        The change of an energy is divided by |T| + |U|, and the change of a momentum by |g|, each at its maximum along
        the motion.
        """
        return self._proof("drift")

    def _proof(self, kind: str) -> dict[str, Array]:
        names = {f"{kind}_{name}": name for name in self._integral_names}
        return {names[key]: values for key, values in along_times(self, names).items()}

    @property
    def _momentum_size(self) -> Array:
        """What drifts of momenta are measured against; shape (n,)."""
        with np.errstate(over="ignore"):
            return np.asarray(np.linalg.norm(self.angular_momentum_body, axis=-1))

    @property
    def summary(self) -> dict[str, Any]:
        """Record of the method and of the drift of the invariants.

        For a motion in a store it contains the method only: the drift would require reading the whole store.
        """
        if self.store is not None:
            return self._told_run | self.store.summary
        return self._summary_with(along_times(self, self._errors))

    def _summary_with(self, errors: Mapping[str, Array]) -> dict[str, Any]:
        """Return the summary of a motion with such errors along the times."""
        none = {"integrals": "none: this system conserves neither energy nor a momentum"}
        return {
            **self._told_run,
            **{name: float(np.fmax.reduce(np.abs(errors[name]), axis=None, initial=0.0)) for name in self._errors},
            **({} if self._integral_names else none),
            **self._exceptions,
        }

    @property
    def _errors(self) -> list[str]:
        """The variables of a dataset that are zero but for errors."""
        return ["norm_error", "tangency_error", *(f"drift_{name}" for name in self._integral_names)]

    @property
    def _told_run(self) -> dict[str, Any]:
        run = {key: value for key, value in asdict(self.run).items() if key != "versions"}
        return run | {"method": str(self.run.method)}

    @property
    def _exceptions(self) -> dict[str, str]:
        """How many times a formula need not hold, with its error, or a quantity is at its limit, by name."""
        known, told = (self._state, self.environment), dict[str, str]()
        misused = {name: at for name, at in self.system.validity(*known).items() if np.any(at)}
        errors = self.system.relative_errors(*known) if misused else {}
        limited = {name: at for name, at in self.system.limits(*known).items() if np.any(at)}
        for name, at in (misused | limited).items():
            error = f", error about {100 * np.nanmax(errors[name]):.2g}%" if name in errors else ""
            told[name] = f"{np.count_nonzero(at)} of {at.size} times{error}"
        return told

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        known = self.summary
        steps = f", order {known['order']}, {known['steps']} steps, tolerance {known['tolerance']:.3g}"
        _, *ends = self._interpolant or [None]
        unit = self.system.units["time"]
        drift = [(name.removeprefix("drift_"), size) for name, size in known.items() if name.startswith("drift_")]
        return f"Trajectory of {rounded(repr(self.system))}", {
            "times": told_times(self.times, unit),
            "members": f"{len(self)}, {len(self.failures)} failed" if self.is_ensemble else "",
            "store": "" if self.store is None else str(self.store),
            "method": str(known["method"]) + (steps if known["steps"] else ""),
            "kernel": told_kernel(known["kernel"], known["lanes"]),
            "variables": f"{known['formulation']}, {known['precision']} precision",
            "wall time": told(known["wall_time"], "s") if np.isfinite(known["wall_time"]) else "",
            "dense output": "any time" if ends[:1] == [-np.inf] else told(ends, unit),
            **self._told_errors(known),
            "drift": ", ".join(f"{name} {size:.2g}" for name, size in drift) or known.get("integrals", ""),
            "events": ", ".join(f"{event.kind} {count}" for event, count in self._counted_events),
            "ended": "; ".join(self._ends),
            **{name: text for name, text in known.items() if name not in SUMMARY and not name.startswith("drift_")},
        }

    def _told_errors(self, known: Mapping[str, Any]) -> dict[str, str]:
        """Return the lines about the distance of states from the unit sphere, where it is known."""
        names = {"norm_error": "norm error", "tangency_error": "tangency error (relative)"}
        return {text: f"{known[name]:.3g}" for name, text in names.items() if name in known}

    @override
    def _repr_html_(self) -> str:
        return super()._repr_html_() + "".join(self._sketches())

    def _sketches(self) -> Iterator[str]:
        """Yield small plots: of one motion and its errors, or of some members of an ensemble."""
        unit = self.system.units["time"]
        if self.is_ensemble:
            few = np.unique(np.linspace(0, len(self) - 1, 5).astype(int))
            name, values = self.isel(member=few)._sketched_member
            yield curves(name, self.times, {f"member {i}": y for i, y in zip(few, values, strict=True)}, unit)
            return
        yield curves("motion", self.times, self._sketched, unit)
        symbols = {integral.name: integral.symbol for integral in self.system.integrals}
        drift = {f"drift of {symbols[name]}": values for name, values in self.drift.items()}
        yield curves("largest so far", self.times, {"norm error": self.norm_error, **drift}, unit, errors=True)

    @property
    def _sketched(self) -> dict[str, Array]:
        """What a small plot shows of one motion."""
        return {f"q{i}": self.quaternion[:, i] for i in range(4)}

    @property
    def _sketched_member(self) -> tuple[str, Array]:
        """What a small plot shows of each of several members."""
        return "rate", np.hypot.reduce(self.omega_body, axis=-1)

    @property
    def _counted_events(self) -> list[tuple[Event, int]]:
        """Each event that was watched for, and how often it happened."""
        return list(zip(self.event_source.watched, self.event_source.counts, strict=True))

    @property
    def _ends(self) -> Iterator[str]:
        """What is said of the terminal events that ended the motion, or members of it."""
        for number, (event, count) in enumerate(self._counted_events):
            if event.terminal and count:
                when = f"{count} members" if self.is_ensemble else f"at t = {told(self.events[number].times[0])}"
                yield f"{when}, by {event.kind}"

    @property
    def dataset(self) -> xarray.Dataset:
        """Motion as an xarray Dataset with units, frames and provenance; for a store, its variables."""
        if self.store is None:
            data = self.variables(self.variable_names)
            known = self._summary_with({name: data[name].values for name in self._errors})
        else:
            known, stored = self.summary, self.store.dataset()
            names = [name for name in self.store.sharded if name in self.variable_names]
            along = {str(stored[name].dims[1]) for name in names}
            if len(along) > 1:
                return stored
            own = stored[names].drop_vars("time", errors="ignore")
            at_times = own.rename_dims(dict.fromkeys(along - {"time"}, "time"))
            data = self.variables(()).assign({name: at_times.variables[name] for name in names})
        return data.assign_attrs({key: value for key, value in known.items() if key != "wall_time"})

    @property
    def _integral_names(self) -> list[str]:
        return [integral.name for integral in self.system.integrals]

    @property
    def variable_names(self) -> tuple[str, ...]:
        """Names of the variables of a dataset along the times."""
        proof = [f"{kind}_{name}" for name in self._integral_names for kind in ("integral", "drift")]
        own = [f"own_{part.name}" for part in self.system.parts if part.size]
        carried = ["carried"] if self._orbits is not None else []
        return (*self._columns, *own, *proof, *carried)

    @property
    def state_variables(self) -> tuple[str, ...]:
        """Names of the state variables."""
        of_two = ORBIT if "quaternion" not in self.phase and "orbit" in self.phase else ()
        rigid = (name for name in self.phase if name in RIGID)
        return (*rigid, *of_two, *(f"own_{part.name}" for part in self.system.parts if part.size))

    def variables(self, names: Collection[str]) -> xarray.Dataset:
        """Return some variables of the dataset, with the initial state and the body.

        Parameters
        ----------
        names : list of str
            Some of `variable_names`.
        """
        refuse_other_names("names", names, (*self.variable_names, "carried"))
        frame, provenance = self.reference_frame, self.provenance
        columns = along_times(self, [name for name in names if name != "carried"])
        return dataset_of(
            Motion(
                system=self.system,
                initial=self.initial,
                times=self.times,
                leading=("member", "time") if self.is_ensemble else ("time",),
                columns={name: columns[name] for name in self.variable_names if name in columns},
                orbits=self.environment.orbit_values if "carried" in names else None,
                calendar=self.calendar,
                attributes={
                    "state_variables": " ".join(name.removeprefix("own_") for name in self.state_variables),
                    **{f"version_{name}": version for name, version in self.run.versions.items()},
                    **({"failures": json.dumps(self.failures)} if self.failures else {}),
                    **{key: provenance[key] for key in ("title", "seed") if provenance.get(key) is not None},
                    **({} if frame == SPACE_AXES_UNNAMED else {"reference_frame": frame}),
                },
            )
        )

    def _at_hand(self, names: Collection[str]) -> dict[str, Array]:
        """Return those of some variables of the dataset that need not be computed."""
        held = {name if name in RIGID else f"own_{name}": values for name, values in self.phase.items()}
        return {name: np.asarray(held[name]) for name in names if name in held}

    @property
    def _in_memory(self) -> Trajectory:
        """The motion with its arrays in memory."""
        return self if self.store is None else self.isel()

    def _part(self, at: slice) -> Trajectory:
        """Return the motion at some times, as it is read once: it keeps what it computes of its states."""
        members = EVERY if self.is_ensemble else None
        rows = functools.partial(rows_of, members=members, at=at)
        part = self._made_of(None, rows, self.times[at], changed(self.phase, rows))
        part._kept_state = part._state
        return part

    @property
    def _columns(self) -> dict[str, Callable[[], Array]]:
        """What a dataset may have of the motion, each computed when it is called."""
        each = {
            named(body, name): functools.partial(getattr, one, name)
            for body, one in self.of_bodies.items()
            for name in OF_BODY
        }
        return each | {name: functools.partial(getattr, self, name) for name in self._of_whole}

    @property
    def calendar(self) -> Calendar | None:
        """Calendar of the times, from the orbits, the scenario or the file of the motion."""
        calendar: Calendar | None = self.system.calendar or self.provenance.get("calendar")
        return calendar

    @property
    def reference_frame(self) -> str:
        """Name of the space axes, from the orbits or from the file of the motion."""
        named = (orbit.reference_frame for orbit in self.system.orbits)
        own = next((frame for frame in named if frame != SPACE_AXES_UNNAMED), None)
        return str(own or self.provenance.get("reference_frame", SPACE_AXES_UNNAMED))
