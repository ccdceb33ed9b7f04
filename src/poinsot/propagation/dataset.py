"""Labelled datasets of motions and of results, with units, frames and provenance."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from poinsot.kinematics.state import RIGID, AnyState, Phase, named
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.part import Jump, Part
from poinsot.printable import quoted
from poinsot.propagation.column_reader import ColumnReader
from poinsot.propagation.columns import RENAMED, Column
from poinsot.propagation.recorded import RecordedObservable, RecordedPart
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array
from poinsot.records.calendar import Calendar, attributes_of_time
from poinsot.records.units import DerivedUnits
from poinsot.storage.run_record import RunRecord
from poinsot.systems.system import System

if TYPE_CHECKING:
    import xarray

__all__ = [
    "ResultVariable",
    "components",
    "dataset_of_motion",
    "dataset_of_result",
    "dataset_of_store",
    "json_of_observables",
    "read_observables",
    "read_parts",
    "state_variables",
    "text_of_jumps",
    "text_of_parts",
    "with_present_names",
]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"


def dataset_of_motion(
    motion: ColumnReader,
    names: Collection[str],
    run: RunRecord,
    failures: Mapping[int, str],
    provenance: Mapping[str, str | int],
    calendar: Calendar | None,
    reference_frame: str,
) -> xarray.Dataset:
    """Return the dataset of a motion, with one variable for each column, along `time`, members first.

    It contains the numbers of the trajectory bit for bit, and no information about the machine. The system is described
    by its `repr`; `save` adds the text from which it is made again.
    """
    import xarray

    system, units, table = motion.system, DerivedUnits(motion.system.units), motion.table
    observables = motion.rows.observables
    arrays = motion.read(names) if names else {}
    leading = ("member", "time") if motion.is_ensemble else ("time",)
    along = {
        name: ((*leading, column.axis) if column.axis else leading, arrays[name], column.attributes_in(units))
        for name, column in table.items()
        if name in arrays
    }
    return xarray.Dataset(
        along | dict(_initial(motion.initial, table, units)) | dict(_bodies(motion.initial, system, units)),
        coords={
            "time": ("time", motion.times, {"units": system.units["time"], **attributes_of_time(calendar)}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
            **{f"component_{part.name}": components(part) for part in system.parts if part.size},
            **{f"component_{name}": list(each.components) for name, each in observables.items() if each.components},
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "Rotation of a rigid body" if len(system.of_bodies) == 1 else "Motion of two bodies",
            "conventions": CONVENTIONS,
            "system": repr(system),
            "initial_state": repr(motion.initial),
            **({"parts": text_of_parts(system.parts)} if system.parts else {}),
            **({"observables": json_of_observables(observables, units)} if observables else {}),
            **({"jumps": text_of_jumps(system.dynamics.jumping)} if system.dynamics.jumping else {}),
            "state_variables": " ".join(
                name.removeprefix("own_") for name in state_variables(motion.system, motion.rows.phase)
            ),
            **{f"version_{name}": version for name, version in run.versions.items()},
            **({"failures": json.dumps(failures)} if failures else {}),
            **{key: provenance[key] for key in ("title", "seed") if provenance.get(key) is not None},
            **({} if reference_frame == SPACE_AXES_UNNAMED else {"reference_frame": reference_frame}),
            **{f"units_{measure}": unit for measure, unit in system.units.items()},
        },
    )


def dataset_of_store(
    stored: xarray.Dataset, data: xarray.Dataset, names: Collection[str], record: Mapping[str, str | float]
) -> xarray.Dataset:
    """Return the dataset of a motion in a store, with the stored variables, of which chunks are read when needed.

    `data` contains the initial state and the bodies, `names` the variables along the times, and `record` the summary.
    If variables are stored at different times, the result is the dataset of the store.
    """
    along_members = [str(name) for name in stored.data_vars if name in names]
    along = {str(stored[name].dims[1]) for name in along_members}
    if len(along) > 1:
        return stored
    own = stored[along_members].drop_vars("time", errors="ignore")
    at_times = own.rename_dims(dict.fromkeys(along - {"time"}, "time"))
    whole = data.assign({name: at_times.variables[name] for name in along_members})
    return whole.assign_attrs({key: value for key, value in record.items() if key != "wall_time"})


def state_variables(system: System, phase: Phase) -> tuple[str, ...]:
    """Return the names of the state variables in a dataset."""
    orbit = ("position", "momentum") if "quaternion" not in phase and "orbit" in phase else ()
    rigid = (name for name in phase if name in RIGID)
    return (*rigid, *orbit, *(f"own_{part.name}" for part in system.parts if part.size))


def with_present_names(data: xarray.Dataset) -> xarray.Dataset:
    """Return a dataset of any version with the present names of its variables."""
    return data.rename({old: new for old, new in RENAMED.items() if old in data.variables})


ResultVariable = tuple[tuple[str, ...], ArrayLike, str, str]
"""Variable of the dataset of an analysis: its dimensions after the members, its values, unit and meaning."""


def dataset_of_result(
    title: str,
    system: System,
    times: Array,
    variables: Mapping[str, ResultVariable],
    coordinates: Mapping[str, Sequence[object] | Array],
    attributes: Mapping[str, object],
) -> xarray.Dataset:
    """Return the dataset of the results of an analysis along times, with members first if there are any."""
    import xarray

    def put(
        dims: tuple[str, ...], values: ArrayLike, unit: str, meaning: str
    ) -> tuple[tuple[str, ...], Array, dict[str, str]]:
        array = np.asarray(values)
        return ("member",) * (array.ndim - len(dims)) + dims, array, _named(unit, meaning)

    time = ("time", times, {"units": system.units["time"], **attributes_of_time(system.calendar)})
    return xarray.Dataset(
        {name: put(*described) for name, described in variables.items()},
        coords={"time": time, **coordinates},
        attrs={
            "Conventions": "CF-1.11",
            "title": title,
            "system": repr(system),
            **attributes,
            **{f"units_{measure}": unit for measure, unit in system.units.items()},
        },
    )


def text_of_parts(parts: Iterable[Part | RecordedPart]) -> str:
    """Return the text of a file about the parts: their variables, and the angular momenta among these."""
    parts_by_name = {part.name: {"variables": dict(part.variables), "momenta": sorted(part.momenta)} for part in parts}
    return json.dumps(parts_by_name)


def text_of_jumps(parts: Iterable[Part | RecordedPart]) -> str:
    """Return the text of a file about the times of jumps: the period and the offset of each part, also of members."""
    each = {part.name: part.jump for part in parts if part.jump is not None}
    return json.dumps(
        {name: [np.asarray(x).tolist() for x in (jump.period, jump.offset)] for name, jump in each.items()}
    )


def json_of_observables(observables: Mapping[str, Observable], units: DerivedUnits) -> str:
    """Return the text of a file about the observables whose readings it contains."""
    return json.dumps(
        {
            name: {
                "text": repr(each),
                "components": each.components,
                "errors": each.errors,
                "unit": each.unit(units),
                "frame": each.frame,
            }
            for name, each in observables.items()
        }
    )


def read_observables(text: str) -> dict[str, RecordedObservable]:
    """Return the observables in a file, from the text of `json_of_observables`."""
    found = {}
    for name, each in json.loads(text).items():
        words, errors = each["components"], each["errors"]
        known = [each["text"], each["unit"], each["frame"], *words, *errors]
        if not name.isidentifier() or not all(isinstance(word, str) for word in known):
            raise ValueError(f"observables must have names and texts, got {quoted(name)}.")
        found[name] = RecordedObservable(each["text"], " ".join(words), " ".join(errors), each["unit"], each["frame"])
    return found


def read_parts(text: str, jumps: str = "{}") -> tuple[RecordedPart, ...]:
    """Return the parts in a file, from the texts of `text_of_parts` and `text_of_jumps`."""
    described, jumping = json.loads(text).items(), {name: _read_jump(*each) for name, each in json.loads(jumps).items()}
    parts = tuple(
        RecordedPart(name, each["variables"], frozenset(each["momenta"]), jumping.get(name)) for name, each in described
    )
    for part in parts:
        counts = part.variables.values()
        if not part.name.isidentifier() or part.name in RIGID or any(type(n) is not int or n < 1 for n in counts):
            raise ValueError(f"parts must have names and numbers of scalars, got {quoted(part.name)}.")
    return parts


def _read_jump(period: ArrayLike, offset: ArrayLike) -> Jump:
    jump = Jump(np.asarray(period, dtype=float), np.asarray(offset, dtype=float))
    if not (np.all(np.isfinite([*np.ravel(jump.period), *np.ravel(jump.offset)])) and np.all(jump.period > 0)):
        raise ValueError(f"jumps must have finite times and positive periods, got {jump}.")
    return jump


def components(part: Part | RecordedPart) -> list[str]:
    """Return the names of the scalars of a part."""
    counts = part.variables.items()
    return [name if count == 1 else f"{name}_{i + 1}" for name, count in counts for i in range(count)]


Variable = tuple[tuple[str, ...], Array, dict[str, str]]
"""Variable of a dataset: its dimensions, values and attributes."""


def _initial(state: AnyState, columns: Mapping[str, Column], units: DerivedUnits) -> Iterator[tuple[str, Variable]]:
    """Yield the variables of the initial state."""
    own = {f"own_{name}": values for name, values in state.own.items()}
    for name, values in {**state.rigid, **{name: own[name] for name in columns if name in own}}.items():
        column = columns[name]
        yield f"initial_{name}", _fixed(values, column.attributes_in(units, ", at the start"), column.axis)
    for name, done in state.jumped.items():
        yield f"initial_jumped_{name}", _fixed(done, _named("1", f"1 if {name} has jumped at the start"))
    yield "initial_time", _fixed(state.time, _named(units.time, "time of the start"))


def _bodies(state: AnyState, system: System, units: DerivedUnits) -> Iterator[tuple[str, Variable]]:
    """Yield the variables of the bodies: moments, axes and masses."""
    for name, body in zip(state.of_bodies, system.of_bodies.values(), strict=True):
        mass: Array | None = body.mass  # type: ignore[attr-defined]  # a field of Body with a default
        of = f", of the {name}" if name else ""
        moments = _named(units.inertia, f"principal moments of inertia{of}")
        axes = {**_named("1", f"principal axes along the body axes, in columns{of}"), "frame": "body"}
        yield named(name, "moments"), _fixed(body.moments, moments, "axis")
        yield named(name, "principal_axes"), _fixed(body.principal_matrix, axes, "axis", "principal_axis")
        if mass is not None:
            yield named(name, "mass"), _fixed(mass, _named(units.mass, f"mass{of}"))
    if len(system.of_bodies) > 1:
        pair = two_bodies(system)
        yield "masses", _fixed(pair.masses, _named(units.mass, "masses of primary and secondary"), "body")
        yield "G", _fixed(pair.G, _named(units.gravitation, "constant of gravitation"))


def _fixed(values: ArrayLike, attributes: dict[str, str], *axes: str) -> Variable:
    """Return a variable that is constant in time; a further first dimension is the dimension of members."""
    array = np.asarray(values, dtype=float)
    return axes if array.ndim == len(axes) else ("member", *axes), array, attributes


def _named(unit: str, meaning: str) -> dict[str, str]:
    return {**({"units": unit} if unit else {}), "long_name": meaning}
