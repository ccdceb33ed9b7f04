"""A trajectory as a labelled dataset, with units, frames and provenance, and a dataset as a trajectory."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.mechanics.calendar import SCALES, Calendar
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.mechanics.state import RIGID
from poinsot.mechanics.units import DerivedUnits
from poinsot.propagation.stored_trajectory import StoredPart

if TYPE_CHECKING:
    import xarray

    from poinsot.mechanics.part import Part
    from poinsot.propagation.trajectory import Trajectory

__all__ = ["calendar_of", "components", "dataset_of", "read_parts", "space_axes_of", "told_parts"]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"


def dataset_of(motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a trajectory, one variable for each quantity, along `time`, members first.

    It has what a trajectory is made of, bit for bit, and nothing of the machine that computed it; of its system no
    more than its `repr`, to which `save` adds what makes it again.
    """
    import xarray

    parts = motion.system.parts
    return xarray.Dataset(
        {name: (dims, values, attributes) for name, dims, values, attributes in _Variables(motion).all()},
        coords={
            "time": ("time", motion.times, {"units": motion.system.units["time"], **_said_of_time(motion)}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
            **{f"component_{part.name}": components(part) for part in parts if part.size},
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "Rotation of a rigid body",
            "conventions": CONVENTIONS,
            "system": repr(motion.system),
            "initial_state": repr(motion.initial),
            "state_variables": " ".join(motion.phase),
            **({"parts": told_parts(parts)} if parts else {}),
            **{key: value for key, value in motion.summary.items() if key != "wall_time"},
            **({"failures": json.dumps(motion.failures)} if motion.failures else {}),
            **{f"version_{name}": version for name, version in motion.run.versions.items()},
            **{key: motion.provenance[key] for key in ("title", "seed") if motion.provenance.get(key) is not None},
            **({} if space_axes_of(motion) == SPACE_AXES_UNNAMED else {"reference_frame": space_axes_of(motion)}),
            "units_time": motion.system.units["time"],
            "units_inertia": motion.system.units["inertia"],
        },
    )


def told_parts(parts: Iterable[Part | StoredPart]) -> str:
    """Return what a file says of parts: the variables of each, and which of them are angular momenta."""
    said = {part.name: {"variables": dict(part.variables), "momenta": sorted(part.momenta)} for part in parts}
    return json.dumps(said)


def read_parts(said: str) -> tuple[StoredPart, ...]:
    """Return the parts of which a file says so, by what `told_parts` has written."""
    told = json.loads(said).items()
    parts = tuple(StoredPart(name, each["variables"], frozenset(each["momenta"])) for name, each in told)
    for part in parts:
        counts = part.variables.values()
        if not part.name.isidentifier() or part.name in RIGID or any(type(n) is not int or n < 1 for n in counts):
            raise ValueError(f"parts must have names and numbers of scalars, got {part.name!r}.")
    return parts


def components(part: Part | StoredPart) -> list[str]:
    """Return the names of the scalars of a part."""
    counts = part.variables.items()
    return [name if count == 1 else f"{name}_{i + 1}" for name, count in counts for i in range(count)]


def calendar_of(motion: Trajectory) -> Calendar | None:
    """Return what the times of a motion mean as dates: by its orbits, or by the scenario that made it."""
    calendar: Calendar | None = motion.system.calendar or motion.provenance.get("calendar")
    return calendar


def space_axes_of(motion: Trajectory) -> str:
    """Return the name of the space axes of a motion, by its orbits or by the file that had it."""
    named = (orbit.reference_frame for orbit in motion.system.orbits)
    own = next((frame for frame in named if frame != SPACE_AXES_UNNAMED), None)
    return str(own or motion.provenance.get("reference_frame", SPACE_AXES_UNNAMED))


def _said_of_time(motion: Trajectory) -> dict[str, str]:
    """Return what the times mean as dates; the unit stays alone, because a decoded date has no 64 bits of time."""
    calendar = calendar_of(motion)
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

    def __init__(self, motion: Trajectory) -> None:
        self.motion = motion
        self.units = DerivedUnits(motion.system.units)
        self.leading = ("time",) if motion.quaternion.ndim == 2 else ("member", "time")
        self.found: list[tuple[str, tuple[str, ...], Any, dict[str, str]]] = []
        momentum = self.units.momentum
        self._of_states: dict[str, tuple[str, str, str, dict[str, str]]] = {
            "quaternion": ("1", "Euler parameters q, body to space", "parameter", {}),
            "conjugate_momenta": (momentum, "momenta Q conjugate to q", "parameter", {}),
            "angular_momentum_body": (momentum, "angular momentum", "axis", {"frame": "body"}),
        }
        self.parts = {part.name: part for part in motion.system.parts if part.size}

    def all(self) -> list[tuple[str, tuple[str, ...], Any, dict[str, str]]]:
        self._motion()
        self._proof()
        self._origin()
        return self.found

    def _put(self, name: str, values: Any, unit: str, meaning: str, axis: str | None = None, **attributes: str) -> None:
        dims = self.leading if axis is None else (*self.leading, axis)
        self.found.append((name, dims, values, {**_named(unit, meaning), **attributes}))

    def _motion(self) -> None:
        motion, units, put = self.motion, self.units, self._put
        for name, (unit, meaning, axis, said) in self._of_states.items():
            put(name, getattr(motion, name), unit, meaning, axis, **said)
        for name, part in self.parts.items():
            put(f"own_{name}", motion.own[name], *self._said_of_part(part))
        momentum = motion.angular_momentum_space
        put("angular_momentum_space", momentum, units.momentum, "angular momentum", "axis", frame="space")
        for frame in ("body", "space"):
            omega = getattr(motion, f"omega_{frame}")
            put(f"omega_{frame}", omega, units.rate, "inertial angular velocity", "axis", frame=frame)
        put("kinetic_energy", motion.kinetic_energy, units.energy, "rotational kinetic energy T")
        put("potential_energy", motion.potential_energy, units.energy, "potential energy U")

    def _proof(self) -> None:
        motion, units, put = self.motion, self.units, self._put
        put("norm_error", motion.norm_error, "1", "|q| - 1")
        put("tangency_error", motion.tangency_error, units.momentum, "q . Q")
        values, drift = motion.integrals, motion.drift
        for integral in motion.system.integrals:
            name, kind = integral.name, "energy" if integral.is_energy else "momentum"
            unit = units.energy if integral.is_energy else units.momentum
            put(f"integral_{name}", values[name], unit, integral.meaning, symbol=integral.symbol, kind=kind)
            put(f"drift_{name}", drift[name], "1", f"relative drift of {integral.meaning}")

    def _origin(self) -> None:
        """Add what the motion started from, and what was integrated along with it."""
        motion, units = self.motion, self.units
        state, body = motion.initial, motion.system.body
        for name, values in state.rigid.items():
            unit, meaning, axis, said = self._of_states[name]
            self._fixed(f"initial_{name}", values, unit, f"{meaning}, at the start", axis, **said)
        for name, part in self.parts.items():
            unit, meaning, axis = self._said_of_part(part)
            self._fixed(f"initial_own_{name}", state.own[name], unit, f"{meaning}, at the start", axis)
        self._fixed("initial_time", state.time, units.time, "time of the start")
        self._fixed("moments", body.moments, units.inertia, "principal moments of inertia", "axis")
        matrix = body.principal_matrix
        meaning = "principal axes along the body axes, in columns"
        self._fixed("principal_axes", matrix, "1", meaning, "axis", "principal_axis", frame="body")
        along = motion.environment.orbit_values
        if along is not None:
            self._put("carried", along, "1", "variables of the orbits that were integrated along", "variable")

    def _said_of_part(self, part: Part | StoredPart) -> tuple[str, str, str]:
        """Return unit, meaning and axis of the variables of a part; other kinds have no unit in common."""
        unit = self.units.momentum if set(part.momenta) == set(part.variables) else ""
        return unit, f"variables of the part {part.name}", f"component_{part.name}"

    def _fixed(self, name: str, values: Any, unit: str, meaning: str, *axes: str, **attributes: str) -> None:
        values = np.asarray(values)
        dims = axes if values.ndim == len(axes) else ("member", *axes)
        self.found.append((name, dims, values, {**_named(unit, meaning), **attributes}))


def _named(unit: str, meaning: str) -> dict[str, str]:
    return {**({"units": unit} if unit else {}), "long_name": meaning}
