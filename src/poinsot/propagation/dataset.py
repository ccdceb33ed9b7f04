"""A motion as a labelled dataset, with units, frames and provenance."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.calendar import SCALES, Calendar
from poinsot.mechanics.part import Jump, Part
from poinsot.mechanics.state import RIGID, AnyState, named
from poinsot.mechanics.system import System
from poinsot.mechanics.units import DerivedUnits
from poinsot.printable import quoted

if TYPE_CHECKING:
    import xarray

__all__ = [
    "COLUMNS",
    "OF_BODY",
    "OF_TWO",
    "Described",
    "Motion",
    "StoredPart",
    "components",
    "dataset_of",
    "dataset_of_result",
    "read_parts",
    "told_jumps",
    "told_parts",
]

Array = NDArray[np.float64]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"


OF_BODY = (
    "quaternion",
    "conjugate_momenta",
    "angular_momentum_body",
    "angular_momentum_space",
    "omega_body",
    "omega_space",
)
"""What a dataset has of the rotation of each body, by the names of its trajectory."""

OF_TWO = ("position", "momentum", "velocity", "angular_momentum_space")
"""What it has of the motion of two bodies about each other."""

TANGENCY = "q . Q / |Q|"
"""The long name of the tangency error. Files of version 0.2 contain the absolute product "q . Q"."""

COLUMNS = ("kinetic_energy", "potential_energy", "norm_error", "tangency_error")
"""What it has of each motion."""


class StoredPart(NamedTuple):
    """What a file says of a part: its variables, with the number of scalars of each."""

    name: str
    variables: Mapping[str, int]
    momenta: frozenset[str]
    jump: Jump | None = None

    @property
    def size(self) -> int:
        """The number of its scalars."""
        return sum(self.variables.values())

    def of_members(self, members: Any) -> StoredPart:
        """Return the part of some members."""
        return self if self.jump is None else self._replace(jump=self.jump.of_members(members))


class Motion(NamedTuple):
    """What a dataset is made of.

    Attributes
    ----------
    system : System
    initial : State
    times : array (n,)
    leading : tuple of str
        The first dimensions of what lies along the times.
    columns : mapping
        Arrays along the times, members first, by `COLUMNS`, `OF_TWO`, and `OF_BODY` of each body; those of parts are
        `own_...`, of integrals `integral_...` and `drift_...`.
    orbits : array, optional
        The variables of orbits integrated along.
    calendar : Calendar or None
    attributes : mapping
        How it was computed, in words.
    """

    system: System
    initial: AnyState
    times: Array
    leading: tuple[str, ...]
    columns: Mapping[str, Array]
    orbits: Array | None
    calendar: Calendar | None
    attributes: Mapping[str, Any]


def dataset_of(motion: Motion) -> xarray.Dataset:
    """Return the dataset of a motion, one variable for each quantity, along `time`, members first.

    It has what a trajectory is made of, bit for bit, and nothing of the machine that computed it; of its system no
    more than its `repr`, to which `save` adds what makes it again.
    """
    import xarray

    parts = motion.system.parts
    return xarray.Dataset(
        {name: (dims, values, attributes) for name, dims, values, attributes in _Variables(motion).all()},
        coords={
            "time": ("time", motion.times, {"units": motion.system.units["time"], **_said_of_time(motion.calendar)}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
            **{f"component_{part.name}": components(part) for part in parts if part.size},
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "Rotation of a rigid body" if len(motion.system.of_bodies) == 1 else "Motion of two bodies",
            "conventions": CONVENTIONS,
            "system": repr(motion.system),
            "initial_state": repr(motion.initial),
            **({"parts": told_parts(parts)} if parts else {}),
            **({"jumps": told_jumps(motion.system.dynamics.jumping)} if motion.system.dynamics.jumping else {}),
            **motion.attributes,
            **{f"units_{measure}": unit for measure, unit in motion.system.units.items()},
        },
    )


Described = tuple[tuple[str, ...], Any, str, str]
"""A variable of a dataset: its dimensions behind the members, its values, unit and meaning."""


def dataset_of_result(
    title: str,
    system: System,
    times: Array,
    variables: Mapping[str, Described],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Return the dataset of what an analysis found along times, with members first where there are any."""
    import xarray

    def put(dims: tuple[str, ...], values: Any, unit: str, meaning: str) -> tuple[Any, ...]:
        array = np.asarray(values)
        return ("member",) * (array.ndim - len(dims)) + dims, array, _named(unit, meaning)

    time = ("time", times, {"units": system.units["time"], **_said_of_time(system.calendar)})
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


def told_parts(parts: Iterable[Part | StoredPart]) -> str:
    """Return what a file says of parts: the variables of each, and which of them are angular momenta."""
    said = {part.name: {"variables": dict(part.variables), "momenta": sorted(part.momenta)} for part in parts}
    return json.dumps(said)


def told_jumps(parts: Iterable[Part | StoredPart]) -> str:
    """Return the text of a file about the times of jumps: the period and the phase of each part, also of members."""
    each = {part.name: part.jump for part in parts if part.jump is not None}
    return json.dumps(
        {name: [np.asarray(x).tolist() for x in (jump.period, jump.phase)] for name, jump in each.items()}
    )


def read_parts(said: str, jumps: str = "{}") -> tuple[StoredPart, ...]:
    """Return the parts in a file, from the texts of `told_parts` and `told_jumps`."""
    told, jumping = json.loads(said).items(), {name: _read_jump(*each) for name, each in json.loads(jumps).items()}
    parts = tuple(
        StoredPart(name, each["variables"], frozenset(each["momenta"]), jumping.get(name)) for name, each in told
    )
    for part in parts:
        counts = part.variables.values()
        if not part.name.isidentifier() or part.name in RIGID or any(type(n) is not int or n < 1 for n in counts):
            raise ValueError(f"parts must have names and numbers of scalars, got {quoted(part.name)}.")
    return parts


def _read_jump(period: Any, phase: Any) -> Jump:
    jump = Jump(np.asarray(period, dtype=float), np.asarray(phase, dtype=float))
    if not (np.all(np.isfinite([*np.ravel(jump.period), *np.ravel(jump.phase)])) and np.all(jump.period > 0)):
        raise ValueError(f"jumps must have finite times and positive periods, got {jump}.")
    return jump


def components(part: Part | StoredPart) -> list[str]:
    """Return the names of the scalars of a part."""
    counts = part.variables.items()
    return [name if count == 1 else f"{name}_{i + 1}" for name, count in counts for i in range(count)]


def _said_of_time(calendar: Calendar | None) -> dict[str, str]:
    """Return what the times mean as dates; the unit stays alone, because a decoded date has no 64 bits of time."""
    if calendar is None:
        return {"long_name": "time"}
    counted = {"tai": "TAI", "tt": "TT", "tdb": "TDB", "tcb": "TCB", "tcg": "TCG"}[SCALES[calendar.scale]]
    return {
        "long_name": f"time since {calendar.zero} {calendar.scale}, counted in {counted}",
        "epoch": calendar.zero,
        "scale": calendar.scale,
        "counted_in": counted,
    }


class _Variables:
    """The variables of the dataset, each with its dimensions, unit and meaning."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.units = DerivedUnits(motion.system.units)
        self.leading = motion.leading
        self.found: list[tuple[str, tuple[str, ...], Any, dict[str, str]]] = []
        self.said = _said_of_columns(self.units, list(motion.initial.of_bodies))
        self.parts = {part.name: part for part in motion.system.parts if part.size}

    def all(self) -> list[tuple[str, tuple[str, ...], Any, dict[str, str]]]:
        self._motion()
        self._proof()
        self._origin()
        return self.found

    def _put(self, name: str, values: Any, unit: str, meaning: str, axis: str = "", **attributes: str) -> None:
        dims = (*self.leading, axis) if axis else self.leading
        self.found.append((name, dims, values, {**_named(unit, meaning), **attributes}))

    def _motion(self) -> None:
        columns = self.motion.columns
        for name in (each for each in self.said if each in columns):
            unit, meaning, axis, said = self.said[name]
            self._put(name, columns[name], unit, meaning, axis, **said)
        for name, part in self.parts.items():
            if (values := columns.get(f"own_{name}")) is not None:
                self._put(f"own_{name}", values, *self._said_of_part(part))

    def _proof(self) -> None:
        columns, units, put = self.motion.columns, self.units, self._put
        for integral in self.motion.system.integrals:
            value, drift = f"integral_{integral.name}", f"drift_{integral.name}"
            unit, kind = (units.energy, "energy") if integral.is_energy else (units.momentum, "momentum")
            if value in columns:
                put(value, columns[value], unit, integral.meaning, symbol=integral.symbol, kind=kind)
            if drift in columns:
                put(drift, columns[drift], "1", f"relative drift of {integral.meaning}")

    def _origin(self) -> None:
        """Add what the motion started from, and what was integrated along with it."""
        motion, units = self.motion, self.units
        state = motion.initial
        for name, values in state.rigid.items():
            unit, meaning, axis, said = self.said[name]
            self._fixed(f"initial_{name}", values, unit, f"{meaning}, at the start", axis, **said)
        for name, part in self.parts.items():
            unit, meaning, axis = self._said_of_part(part)
            self._fixed(f"initial_own_{name}", state.own[name], unit, f"{meaning}, at the start", axis)
        for name, done in state.jumped.items():
            self._fixed(f"initial_jumped_{name}", done.astype(float), "1", f"1 if {name} has jumped at the start")
        self._fixed("initial_time", state.time, units.time, "time of the start")
        for name, body in zip(state.of_bodies, motion.system.of_bodies.values(), strict=True):
            self._body(name, body)
        if len(state.of_bodies) > 1:
            pair: Any = motion.system.body
            self._fixed("masses", pair.masses, units.mass, "masses of primary and secondary", "body")
            self._fixed("G", pair.G, units.gravitation, "constant of gravitation")
        if motion.orbits is not None:
            self._put("carried", motion.orbits, "1", "variables of the orbits that were integrated along", "variable")

    def _body(self, name: str, body: Any) -> None:
        """Add what is known of a body."""
        units, of = self.units, _of(name)
        self._fixed(named(name, "moments"), body.moments, units.inertia, f"principal moments of inertia{of}", "axis")
        meaning, axes = f"principal axes along the body axes, in columns{of}", ("axis", "principal_axis")
        self._fixed(named(name, "principal_axes"), body.principal_matrix, "1", meaning, *axes, frame="body")
        if body.mass is not None:
            self._fixed(named(name, "mass"), body.mass, units.mass, f"mass{of}")

    def _said_of_part(self, part: Part | StoredPart) -> tuple[str, str, str]:
        """Return unit, meaning and axis of the variables of a part; other kinds have no unit in common."""
        unit = self.units.momentum if set(part.momenta) == set(part.variables) else ""
        return unit, f"variables of the part {part.name}", f"component_{part.name}"

    def _fixed(self, name: str, values: Any, unit: str, meaning: str, *axes: str, **attributes: str) -> None:
        values = np.asarray(values)
        dims = axes if values.ndim == len(axes) else ("member", *axes)
        self.found.append((name, dims, values, {**_named(unit, meaning), **attributes}))


def _said_of_columns(units: DerivedUnits, bodies: list[str]) -> dict[str, tuple[str, str, str, dict[str, str]]]:
    """Return unit, meaning, axis and frame of what a dataset has of a motion, by its name."""
    momentum, rate = units.momentum, "inertial angular velocity"
    of_body: dict[str, tuple[str, str, str, dict[str, str]]] = {
        "quaternion": ("1", "Euler parameters q, body to space", "parameter", {}),
        "conjugate_momenta": (momentum, "momenta Q conjugate to q", "parameter", {}),
        "angular_momentum_body": (momentum, "angular momentum", "axis", {"frame": "body"}),
        "angular_momentum_space": (momentum, "angular momentum", "axis", {"frame": "space"}),
        "omega_body": (units.rate, rate, "axis", {"frame": "body"}),
        "omega_space": (units.rate, rate, "axis", {"frame": "space"}),
    }
    one = bodies == [""]
    place = "of the secondary relative to the primary"
    of_two = {
        "position": (units.length, f"position {place}", "axis", {"frame": "space"}),
        "momentum": (units.linear_momentum, f"reduced mass times velocity {place}", "axis", {"frame": "space"}),
        "velocity": (units.velocity, f"velocity {place}", "axis", {"frame": "space"}),
        "angular_momentum_space": (momentum, "angular momentum about the barycentre", "axis", {"frame": "space"}),
    }
    return {
        **{
            named(body, name): (unit, f"{meaning}{_of(body)}", axis, said)
            for body in bodies
            for name, (unit, meaning, axis, said) in of_body.items()
        },
        **({} if one else of_two),
        "kinetic_energy": (units.energy, "rotational kinetic energy T" if one else "kinetic energy T", "", {}),
        "potential_energy": (units.energy, "potential energy U", "", {}),
        "norm_error": ("1", "|q| - 1", "", {}),
        "tangency_error": ("1", TANGENCY, "", {}),
    }


def _of(body: str) -> str:
    return f", of the {body}" if body else ""


def _named(unit: str, meaning: str) -> dict[str, str]:
    return {**({"units": unit} if unit else {}), "long_name": meaning}
