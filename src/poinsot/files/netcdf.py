"""Trajectories as files, NetCDF-4 or Zarr, which are read bit for bit."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from poinsot.atomic_write import exists, new_file, new_folder, unwritable
from poinsot.checked import checked
from poinsot.files.reader_process import ReaderProcess
from poinsot.kinematics.state import AnyState, Phase, named, state_of
from poinsot.mechanics.body import Body, ObliqueBody
from poinsot.mechanics.two_bodies import BODIES, TwoBodies
from poinsot.printable import described, quoted, shortened
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.columns import RENAMED, Requirement, names_with, static_columns
from poinsot.propagation.dataset import read_observables, read_parts, state_variables, text_of_parts, with_present_names
from poinsot.propagation.recorded import RecordedSystem, recorded_integral
from poinsot.propagation.scenario_of_motion import OF_SCENARIOS, WITH_FILES, with_texts
from poinsot.propagation.stored_motion import (
    arrays_in,
    event_attributes,
    event_tables,
    event_variables,
    events_in,
    failures_in,
    phase_in,
    result_in,
    run_in,
    stored_events,
    times_in,
)
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar
from poinsot.scenarios.system_text import rebuilt_system
from poinsot.storage.ensemble_store import EnsembleStore, save_in_chunks
from poinsot.storage.memory import available_memory
from poinsot.storage.netcdf_writer import write_netcdf
from poinsot.storage.run_record import Method, RunRecord
from poinsot.storage.selection import Chosen
from poinsot.storage.zarr_group import GROUP, StoreError, plain
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.pair_dynamics import PairDynamics
from poinsot.systems.system import System, is_of_two_bodies

if TYPE_CHECKING:
    import xarray

__all__ = ["READINGS", "ReadingsFoundError", "load", "read_dataset", "save", "write_dataset"]

SUFFIXES = (".nc", ".zarr")

ONE, ORBIT = ("",), {"position": 3, "momentum": 3}
PHASES = tuple(
    {named(body, name): size for body in bodies for name, size in rigid.items()} | (ORBIT if bodies != ONE else {})
    for bodies in (ONE, BODIES)
    for rigid in ({"quaternion": 4, "angular_momentum_body": 3}, {"quaternion": 4, "conjugate_momenta": 4})
)
"""State variables of one body and of two bodies, with their sizes."""

RECORDED = "recorded_"
"""Prefix of a second copy of the columns that require the formulas of parts, which `load` reads."""

OF_STATES = {name for sizes in PHASES for each in sizes for name in (each, f"initial_{each}")}
OF_BODIES = [named(body, name) for body in (*ONE, *BODIES) for name in ("moments", "principal_axes", "mass")]
READINGS = "readings"
"""Attribute of a file of readings, which describes them."""

SHAPES = tuple(named(body, "shape_") for body in (*ONE, *BODIES))
PREFIXES = (
    "integral_",
    "drift_",
    "own_",
    "initial_own_",
    "initial_jumped_",
    RECORDED,
    "event_",
    "system_",
    "readings_",
    "observable_",
    *SHAPES,
)
"""Prefixes of the names of variables that are read. The last ones belong to arrays that a text names."""

RUN = ("method", "formulation", "precision", "tolerance", "order", "steps")
SUMMARY = (*RUN, "kernel", "lanes", "norm_error", "tangency_error", "integrals")

FOREIGN = (OSError, RuntimeError, KeyError, IndexError, TypeError, AttributeError, MemoryError, ValueError)
"""Errors of the libraries about incomplete files."""

MAGIC = b"\x89HDF\r\n\x1a\n"

SECONDS_PER_BYTE = 1e-8
"""Processor time to read a byte, seconds."""


@checked
def save(motion: Trajectory, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a trajectory with its events, units, frames and provenance to a file that `load` reads.

    The file contains no information about the machine. If body, forces and orbits are built in and made of parameters,
    the file also contains the text of a scenario, and `poinsot run` on the file repeats the motion.

    Parameters
    ----------
    motion : Trajectory
        Motion to write.
    path : str or Path
        Name that ends in `.nc` (NetCDF-4) or `.zarr` (a folder in Zarr format 3). An ensemble in a store is copied to
        `.zarr` with the chunks that exist; writing it to `.nc` requires all chunks.
    overwrite : bool
        True to replace an existing file of that name.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If the first argument is not a trajectory, the name has another ending, the folder does not exist, or the file
        exists.

    Examples
    --------
    >>> path = pt.save(motion, "new.nc")
    >>> bool(np.all(pt.load(path).quaternion == motion.quaternion))
    True
    """
    path = _checked_path(path)
    if motion.run.method is Method.ONE_OF_TWO:
        raise ValueError("motion must be the motion of both bodies, got the motion of one body.")
    store = motion.store
    if path.suffix == ".zarr" and store is not None:
        known = {name: motion.provenance[name] for name in OF_SCENARIOS if motion.provenance.get(name) is not None}
        with new_folder(path, overwrite, GROUP) as part:
            store.copy_to(part, known)
        return path
    if store is not None and not store.whole.all():
        raise ValueError(
            f"motion must be whole to be saved as {path.suffix}, got {store.finished} of {store.members} members. "
            "Save it as .zarr, or let the call that made the store go on."
        )
    of_all = _along_time(motion)
    data = with_texts(
        _recorded(of_all, motion), motion.system, motion.run, motion.provenance, motion.has_dense_output
    ).assign(_happened(motion))
    data = data.assign_attrs(event_attributes(motion._rows.events.watched))
    if path.suffix == ".nc":
        write_dataset(data, path, overwrite)
    else:
        with new_folder(path, overwrite, GROUP) as part:
            summary = {name: of_all.attrs[name] for name in of_all.attrs.keys() - motion.variables(()).attrs.keys()}
            about = {"failures": motion.failures, "run": motion.run.of_chunk, "summary": summary}
            save_in_chunks(data, part, about)
    return path


def load(source: str | Path | xarray.Dataset) -> Trajectory:
    """Return the trajectory in a file that `save` wrote, or in a dataset that xarray read from such a file.

    Times, quaternions, momenta, initial state, events and integrated orbits are restored bit for bit. Body, forces and
    orbits are restored from the text and arrays in the file. If the file lacks this text (with user-defined classes,
    and for every `motion.dataset`), the trajectory contains the body but not the forces. Potential energy and integrals
    are then read from the file, and `motion.system.not_rerunnable` gives the reason. The wall time is NaN, and there is
    no dense output.

    Parameters
    ----------
    source : str, Path or xarray.Dataset
        File that `save` wrote. poinsot rejects files with other chunks or codecs. A dataset is not checked for its
        origin: load only datasets from files that you trust.

    Returns
    -------
    Trajectory
        The stored motion.

    Raises
    ------
    OSError, ValueError
        If the file cannot be opened, was not written by `save`, or is incomplete.

    Examples
    --------
    >>> pt.load("m.nc").system.body
    Body(moments=[1.25, 1.0, 0.75])
    """
    import xarray

    if isinstance(source, xarray.Dataset):
        return _Reading(source, "the dataset").trajectory()
    path = _checked_path(source)
    if path.suffix == ".zarr":
        return _in_store(path)
    data = _opened(path)
    if READINGS in data.attrs:
        raise ReadingsFoundError(f"{shortened(path)} must have a motion, got readings. Use pt.files.read_readings.")
    reading = _Reading(data, shortened(path))
    _check_digest(data, path)
    return reading.trajectory()


class ReadingsFoundError(ValueError):
    """Error of a file that contains readings in place of a motion."""


def write_dataset(data: xarray.Dataset, path: Path, overwrite: bool) -> None:
    """Write a dataset to a NetCDF file with the digest of its numbers."""
    data.attrs["digest"] = _digest(data)
    with new_file(path, overwrite) as part:
        try:
            write_netcdf(data, part)
        except (OSError, RuntimeError) as error:  # the library does not name the cause
            reason = f"netCDF says: {getattr(error, 'strerror', None) or error}"
            raise OSError(f"{unwritable(path, reason)} Is the disk full?") from error


def read_dataset(path: Path) -> xarray.Dataset:
    """Return the variables of a NetCDF file that are read; raise a ValueError if its numbers are not as written."""
    data = _opened(path)
    _check_digest(data, path)
    return data


def _check_digest(data: xarray.Dataset, path: Path) -> None:
    if data.attrs.get("digest") != _digest(data):
        given = "others: the digest differs" if "digest" in data.attrs else "no digest"
        raise ValueError(f"{shortened(path)} must have the numbers that were saved, got {given}.")


# ------------------------------------------------------------------ files


@checked
def _checked_path(path: str | Path) -> Path:
    if Path(path).suffix not in SUFFIXES:
        raise ValueError(f"path must end in {' or '.join(SUFFIXES)}, got {quoted(Path(path).name)}.")
    return Path(path)


def _along_time(motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a motion; of one in a store that keeps other variables at other times, with all of them."""
    data = motion.dataset
    along = all("time" in data[name].dims for name in state_variables(motion.system, motion.phase))
    return data if along else motion.variables(motion.variable_names).assign_attrs(data.attrs)


def _recorded(data: xarray.Dataset, motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a motion, with copies of the columns that require parts under names that `load` reads."""
    if not motion.system.parts:
        return data
    names = [name for name in names_with(Requirement.PARTS) if name in motion.variable_names]
    own = data if all(name in data for name in names) else motion.variables(names)
    return data.assign({f"{RECORDED}{name}": own[name] for name in names})


def _happened(motion: Trajectory) -> dict[str, Any]:
    """Return the events along a motion as variables; empty ones have no place in NetCDF, which extends them."""
    return {name: variable for name, variable in event_variables(motion.events).items() if len(variable[1])}


def _in_store(path: Path) -> Trajectory:
    """Return the motion in a store, or its dataset if it does not contain all state variables."""
    if not exists(path):
        raise FileNotFoundError(f"No such file: {shortened(path)}")
    if not (path / GROUP).is_file():
        raise ValueError(f"{shortened(path)} must be a Zarr store, got none: it has no {GROUP}.")
    try:
        store = EnsembleStore(path)
        store.check_files()
        if store.chunk and phase_in(store) is None:
            return cast("Trajectory", result_in(store))
        return _Reading(store.variables(), shortened(path), store).trajectory()
    except (StoreError, KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:
        what = str(error) if isinstance(error, StoreError) else f"its attributes have no {str(error)[:60]}"
        raise ValueError(f"{shortened(path)} must be a whole result as save writes it, got another: {what}.") from None


def _opened(path: Path) -> xarray.Dataset:
    """Return the variables of a file that are read; raise one ValueError for any other file."""
    import xarray

    if not path.exists():
        raise FileNotFoundError(f"No such file: {shortened(path)}")
    _check_magic(path)
    try:
        variables, attributes = _netcdf_content(path)
        return xarray.Dataset(variables, attrs=attributes)
    except FOREIGN as error:
        what = " ".join(str(error).split())[:100].rstrip(".") or type(error).__name__
        raise ValueError(f"{shortened(path)} must be a whole result as save writes it, got another: {what}.") from None


def _check_magic(path: Path) -> None:
    """Raise a ValueError for other files before a library opens them."""
    if not path.is_file():
        raise ValueError(f"{shortened(path)} must be a file, got a folder or a device.")
    with path.open("rb") as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise ValueError(f"{shortened(path)} must be a NetCDF-4 file, got other first bytes.")


def _netcdf_content(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    size, left = path.stat().st_size, available_memory()
    if size > left:  # also of a file with holes, which takes less on a disk
        raise ValueError(f"it needs {size} bytes of memory, of which {left} are left")
    process = ReaderProcess("poinsot.storage.netcdf_reader", "", memory=2 * size, files=1)
    with contextlib.closing(process):
        (attributes, variables), arrays = process.call(
            "content", str(path), size, sorted(_names()), list(PREFIXES), seconds=SECONDS_PER_BYTE * size
        )
    content = zip(variables, arrays, strict=True)
    return {name: (dims, array, own) for (name, dims, own), array in content}, attributes


def _names() -> set[str]:
    """Return the names of variables that are read, of this version and of version 0.2."""
    columns = {*names_with(Requirement.FORCES), *names_with(Requirement.ORBITS), *RENAMED}
    return {"time", "initial_time", "masses", "G", *OF_BODIES, *OF_STATES, *columns}


def _digest(data: xarray.Dataset) -> str:
    """Return the SHA-256 of the numbers and the attributes that are read again, in the order of their names."""
    digest = hashlib.sha256()
    names = _names() | json.loads(str(data.attrs.get("observables", "{}"))).keys()
    for name in sorted(str(name) for name in data.variables if name in names or str(name).startswith(PREFIXES)):
        digest.update(f"{name}{data[name].shape}".encode())
        digest.update(np.ascontiguousarray(data[name].values, dtype="<f8").reshape(-1).data)
    attributes = {str(key): plain(value) for key, value in data.attrs.items() if key != "digest"}
    digest.update(json.dumps(attributes, sort_keys=True).encode())
    return digest.hexdigest()


# ------------------------------------------------------------------ from a dataset


class _Reading:
    """Reader of a dataset as a trajectory."""

    def __init__(self, data: xarray.Dataset, name: str, store: EnsembleStore | None = None) -> None:
        self.data, self.name, self.store = with_present_names(data), name, store
        data = self.data
        names = data.attrs.get("state_variables")
        parts = data.attrs.get("parts", "{}")
        try:
            self.parts = read_parts(parts, data.attrs.get("jumps", "{}"))
        except (ValueError, RecursionError, TypeError, KeyError, AttributeError):
            raise ValueError(f"{name} must have parts by name with their variables, got {described(parts)}.") from None
        text = data.attrs.get("observables", "{}")
        try:
            found = read_observables(text)
        except (ValueError, RecursionError, TypeError, KeyError, AttributeError):
            raise ValueError(f"{name} must have observables by name, got {described(text)}.") from None
        self.observables = {each: found[each] for each in found if each in data.variables}
        self.own = {part.name: part.size for part in self.parts if part.size}
        self.sizes = next((sizes for sizes in PHASES if " ".join((*sizes, *self.own)) == names), PHASES[0])
        self.bodies = BODIES if "position" in self.sizes else ONE
        alike = PHASES[:2] if self.bodies == ONE else PHASES[2:]
        self.initial = next((s for s in alike if all(f"initial_{each}" in data.variables for each in s)), alike[0])
        own = {f"{kind}_{name}": size for kind in ("own", "initial_own") for name, size in self.own.items()}
        self.jumped = [part.name for part in self.parts if f"initial_jumped_{part.name}" in data.variables]
        self._check_variables(own)
        self.measures = (BodyDynamics if self.bodies == ONE else PairDynamics).measures
        for key in (*RUN, *(f"units_{measure}" for measure in self.measures), "state_variables"):
            if key not in data.attrs:
                raise ValueError(f"{name} must have the attribute {key}, got none.")
        if names != " ".join((*self.sizes, *self.own)):
            raise ValueError(f"{name} must have state_variables that are q and momenta, got {described(names)}.")

    def _check_variables(self, own: dict[str, int]) -> None:
        """Raise a ValueError for variables that are missing, not real, or of contradictory shapes."""
        variables = self.data.variables
        first = next(iter(self.sizes))
        shape = variables[first].shape if first in variables else (0, 4)
        count, members = variables[self.time].size if self.time in variables else 0, shape[:-2]
        allowed: dict[str, list[tuple[int, ...]]] = {self.time: [(count,)], "initial_time": [(), members]}
        for name, size in {**self.sizes, **{f"initial_{each}": n for each, n in self.initial.items()}, **own}.items():
            allowed[name] = [(size,), (*members, size)] if name.startswith("initial_") else [(*members, count, size)]
        of_bodies: dict[str, tuple[int, ...]] = {"moments": (3,), "principal_axes": (3, 3), "mass": ()}
        known = {named(body, name): size for body in self.bodies for name, size in of_bodies.items()}
        known = {name: size for name, size in known.items() if not name.endswith("mass") or name in variables}
        known |= {} if self.bodies == ONE else {"masses": (2,), "G": ()}
        known |= {f"initial_jumped_{name}": () for name in self.jumped}
        of_jumps = {np.shape(x) for part in self.parts if part.jump for x in part.jump[:2]}
        if not of_jumps <= {(), members}:
            raise ValueError(f"{self.name} must have jumps of each member, got {described(self.data.attrs['jumps'])}.")
        allowed |= {name: [size, (*members, *size)] for name, size in known.items()}
        for name, shapes in allowed.items():
            array = self._variable(name)
            if array.shape not in shapes or array.dtype.kind != "f" or len(members) > 1:
                rule = f"{self.name} must have numbers of shape {shapes[-1]} in {name}"
                raise ValueError(f"{rule}, got shape {array.shape}.")

    def _variable(self, name: str) -> Any:
        if name not in self.data.variables:
            raise ValueError(f"{self.name} must have the variable {name}, got none.")
        return self.data[name]

    def _array(self, name: str) -> Array:
        return np.array(self._variable(name).values, dtype=float)

    def _rows(self, name: str) -> Any:
        """Return a variable along the times; do not read it from a store."""
        self._variable(name)
        return self._array(name) if self.store is None or not self.store.chunk else arrays_in(self.store)[name]

    @property
    def time(self) -> str:
        """The name of the times."""
        return "time" if self.store is None or not self.store.chunk else times_in(self.store)

    def trajectory(self) -> Trajectory:
        try:
            system, recorded = self._system(), {}
        except (ValueError, TypeError, ImportError) as error:
            system, recorded = self._recorded_system(str(error)), self._recorded_columns()
        else:
            for body, one in zip(self.bodies, system.of_bodies.values(), strict=True):
                one._complete(shape=self._shape(body) or one.shape)
        columns, whole = recorded | self._orbit_variables() | self._readings(), isinstance(system, System)
        phase, initial, run = self._phase(), self._initial(), self._run()
        events = stored_events(events_in(self.data.attrs), system, phase, self._crossings())
        if self.store is not None and self.store.chunk:
            rows = MotionRows(phase, columns, events, self.store.summary, self.store, self.observables)
        else:
            summary = None if whole else self._summary()
            rows = MotionRows(phase, columns, events, summary, observables=self.observables)
        failures, provenance = self._failures(), self._provenance(whole)
        return Trajectory(system, initial, self._array(self.time), rows, run, failures=failures, provenance=provenance)

    def _crossings(self) -> Callable[[Chosen | None], Iterator[Mapping[str, Any]]]:
        """Return a function that yields the tables of the events of some members, None for all."""
        own, store = self._named_arrays("event_"), self.store

        def tables(members: Chosen | None) -> Iterator[Mapping[str, Any]]:
            yield own
            if store is not None:
                yield from event_tables(store, members)

        return tables

    def _failures(self) -> dict[int, str]:
        if self.store is not None and self.store.chunk:
            return failures_in(self.store)
        try:
            failures = json.loads(self.data.attrs.get("failures", "{}"))
        except (ValueError, RecursionError):
            failures = None
        if not isinstance(failures, dict):
            raise ValueError(f"{self.name} must have failures by member, got something else.")
        return {int(member): str(why) for member, why in failures.items()}

    def _provenance(self, whole: bool) -> dict[str, Any]:
        """Return the entries about the scenario; for a system that cannot be run, calendar and axes only."""
        attributes, times = self.data.attrs, self.data["time"].attrs
        known = (
            {key: attributes[key] for key in OF_SCENARIOS if key in attributes}
            if whole and "scenario" in attributes
            else {}
        )
        if whole and "seed" in attributes:
            known["seed"] = int(attributes["seed"])
        if whole and (data := self._named_arrays("system_")):
            known["data"] = data
        if "epoch" in times and "scale" in times:
            known["calendar"] = Calendar(str(times["epoch"]), str(times["scale"]), str(times.get("units", "s")))
        if attributes.get("reference_frame"):
            known["reference_frame"] = str(attributes["reference_frame"])
        return known

    def _named_arrays(self, beginning: str) -> dict[str, Any]:
        return {name: self.data[name].values for name in self._names(beginning)}

    def _shape(self, body: str) -> Any:
        """Return the shape that a body was made of, None if the file has none."""
        name = named(body, "shape")
        if name not in self.data.attrs:
            return None
        text = str(self.data.attrs[name])
        return (
            rebuilt_system(text, f"the {name} in {self.name}", data=self._named_arrays(f"{name}_")).of_bodies[""].shape
        )

    def _system(self) -> System:
        """Return body and forces, made again from the text in the file."""
        attributes = self.data.attrs
        if "scenario" not in attributes:
            alone = f"{self.name} names its forces and has nothing that makes them again. `save` writes that."
            raise ValueError(attributes.get("not_rerunnable", alone))
        text = attributes["scenario"]
        if attributes.get("scenario_of") == WITH_FILES:
            if "scenario_read" not in attributes:
                raise ValueError(attributes.get("not_rerunnable", f"{self.name} has not what its scenario read."))
            text = attributes["scenario_read"]
        data = self._named_arrays("system_")
        system = rebuilt_system(str(text), f"the scenario in {self.name}", data=data)
        same = self._are_there([*system.of_bodies.values()]) and text_of_parts(system.parts) == text_of_parts(
            self.parts
        )
        if is_of_two_bodies(system):
            same = same and all(np.array_equal(getattr(system.body, x), self._array(x)) for x in ("masses", "G"))
        if not same or dict(system.units) != self._units():
            raise ValueError(f"the scenario in {self.name} must describe the saved body, got another body.")
        return system

    def _are_there(self, bodies: Sequence[Body]) -> bool:
        """Return True if bodies have the moments in the file."""
        moments = [self._array(named(body, "moments")) for body in self.bodies]
        return len(bodies) == len(moments) and all(map(np.array_equal, (one.moments for one in bodies), moments))

    def _body(self, name: str) -> Body:
        """Return a body with the numbers of the file alone."""
        moments, axes = (self._array(named(name, kind)) for kind in ("moments", "principal_axes"))
        mass = self._array(named(name, "mass")) if named(name, "mass") in self.data.variables else None
        is_plain = np.array_equal(axes, np.eye(3))
        body = Body(moments, mass=mass) if is_plain else ObliqueBody(moments, axes, mass=mass)
        body._complete(shape=self._shape(name))
        return body

    def _recorded_system(self, reason: str) -> System:
        """Return the body with the numbers of the file, without its forces."""
        data, bodies = self.data, [self._body(name) for name in self.bodies]
        names = [name.removeprefix("integral_") for name in self._named_arrays("integral_")]
        body: Body | TwoBodies = bodies[0]
        if self.bodies != ONE:
            body = TwoBodies(bodies[0], bodies[1], self._array("G"), masses=self._array("masses"))
        integrals = tuple(recorded_integral(name, data[f"integral_{name}"].attrs) for name in names)
        text = str(data.attrs.get("system", "unknown"))
        system = RecordedSystem(body, self._units(), text, reason, integrals, self.parts)
        return cast(System, system)

    def _recorded_columns(self) -> dict[str, Array]:
        """Return the columns that require forces or parts."""
        stored = {
            name: name for name in (*names_with(Requirement.FORCES), *self._names("integral_"), *self._names("drift_"))
        }
        for name in names_with(Requirement.PARTS) if self.parts else ():
            stored[name] = f"{RECORDED}{name}" if f"{RECORDED}{name}" in self.data.variables else name
        return {name: self._rows(variable) for name, variable in stored.items() if variable in self.data.variables}

    def _names(self, prefix: str) -> list[str]:
        return [str(name) for name in self.data.variables if str(name).startswith(prefix)]

    def _orbit_variables(self) -> dict[str, Array]:
        """Return the variables of integrated orbits, if the file contains them."""
        return {name: self._rows(name) for name in names_with(Requirement.ORBITS) if name in self.data.variables}

    def _readings(self) -> dict[str, Array]:
        """Return the readings of observables."""
        return {name: self._rows(name) for name in self.observables}

    def _summary(self) -> dict[str, str | float] | None:
        """Return the summary in the attributes of the file; None if it contains none."""
        known = {str(key): value for key, value in self.data.attrs.items()}
        found = {key: value for key, value in known.items() if key in SUMMARY or key.startswith("drift_")}
        variables, present = self.data.variables, static_columns(("",))["tangency_error"].meaning
        if "tangency_error" in variables and variables["tangency_error"].attrs.get("long_name") != present:
            found.pop("tangency_error", None)  # version 0.2 contains the absolute product q . Q
        return found or None

    def _units(self) -> dict[str, str]:
        return {name: str(self.data.attrs[f"units_{name}"]) for name in self.measures}

    def _initial(self) -> AnyState:
        phase = {name: self._array(f"initial_{name}") for name in self.initial}
        phase |= {name: self._array(f"initial_own_{name}") for name in self.own}
        jumped = {name: self._array(f"initial_jumped_{name}") == 1 for name in self.jumped}
        return state_of(_with_orbit(phase), self._array("initial_time"), jumped)

    def _phase(self) -> Phase:
        if self.store is not None and (stored := phase_in(self.store)) is not None:
            return stored
        own = {name: self._array(f"own_{name}") for name in self.own}
        return _with_orbit({name: self._array(name) for name in self.sizes}) | own

    def _run(self) -> RunRecord:
        attributes = self.data.attrs
        versions = {
            name.removeprefix("version_"): str(attributes[name]) for name in attributes if name.startswith("version_")
        }
        method, formulation, precision = (str(attributes[key]) for key in RUN[:3])
        if method not in list(Method):
            raise ValueError(f"the method in {self.name} must be one of {'; '.join(Method)}, got {quoted(method)}.")
        tolerance, order, steps = float(attributes["tolerance"]), int(attributes["order"]), int(attributes["steps"])
        kernel, lanes = str(attributes.get("kernel", ""))[:40], int(attributes.get("lanes", 0))
        run = RunRecord(
            Method(method), formulation, precision, tolerance, order, steps, math.nan, versions, kernel, lanes
        )
        return run if self.store is None else run_in(self.store, run)


def _with_orbit(variables: Phase) -> Phase:
    """Return the variables of a file as those of a phase, where position and momentum of two bodies are one array."""
    orbit = [variables[name] for name in ORBIT if name in variables]
    phase = {name: values for name, values in variables.items() if name not in ORBIT}
    return phase | {"orbit": np.concatenate(orbit, axis=-1)} if orbit else phase
